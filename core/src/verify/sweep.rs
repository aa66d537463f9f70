//! A tile of the part while the cutter goes along the path: the height above the surface that is left
//! on each sample's normal line, and how much each step takes.
//!
//! The line of a sample starts full of material up to the stock's height and down into the part. A
//! step lowers it to where the line enters the cutter. What stands lower than the surface is a gouge.
//!
//! For the volume that is taken, a sample stands for a cell as wide as the distance of samples: where a
//! wall of the cutter passes over it, it goes by parts, so that the rate does not count samples but
//! area. The residual knows no cells.
//!
//! Most steps near a tile do not reach what is left of it. A block of samples is left out where a
//! plane parts it from the cutter: the plane through the cutter's point nearest to the block's
//! highest point, across the way to it. The cutter is convex, so it lies behind that plane.

use super::body::{Body, Placed};
use super::motion::{Motion, Step};
use super::samples::{BLOCK, Sample, Tile};
use crate::geometry::DVec3;

/// What the judge assumes about material and cutter.
#[derive(Copy, Clone, Debug)]
pub struct Material {
    /// Height of the stock above the surface where it is machined, mm.
    pub height: f64,
    /// Gouges deeper than this are reported as this deep, mm.
    pub deepest: f64,
    /// Distance of samples, mm.
    pub spacing: f64,
}

/// Material thinner than this is none, mm: a flat end slides over what it has cut.
const NOTHING: f64 = 1e-7;

/// A sample after the sweep.
#[derive(Copy, Clone, Debug)]
pub struct Swept {
    /// The sample.
    pub sample: Sample,
    /// Height left above the surface along the normal, mm; negative in a gouge.
    pub height: f64,
    /// Mean height left over its cell, as far as the volume goes, mm.
    pub left: f64,
    /// The move that left it, `None` where none came.
    pub by: Option<u32>,
    /// The move that took the upper half of the stock.
    pub opened_by: Option<u32>,
    /// The last rapid that came, and the height it found, mm.
    rapid: Option<(u32, f64)>,
}

/// A tile after the sweep.
#[derive(Clone, Debug, Default)]
pub struct SweptTile {
    /// Its samples.
    pub samples: Vec<Swept>,
    /// Volume taken, mm³, by step, in order.
    pub removed: Vec<(u64, f64)>,
    /// Rapids that took material: step and place of the most taken.
    pub touched: Vec<Touch>,
}

/// A rapid in material.
#[derive(Copy, Clone, Debug)]
pub struct Touch {
    /// Index of the move.
    pub of: u32,
    /// Where, mm.
    pub place: DVec3,
    /// Height taken there, mm.
    pub depth: f64,
}

/// Samples that lie together and what bounds them.
struct Block {
    centre: DVec3,
    normal: DVec3,
    /// Farthest sample's line across the mean normal, up to the stock's height.
    radius: f64,
    /// Highest material above the centre along the mean normal.
    top: f64,
    /// Lowest place of interest there.
    bottom: f64,
}

/// Blocks that are looked at together first.
const BLOCKS: usize = 8;
/// Steps that lower something of them before their bound is made anew.
const STALE: u32 = 12;

/// Blocks that lie together and what bounds all of them.
struct Group {
    bound: Block,
    blocks: Vec<Block>,
    /// Steps that lowered something since the bound was made.
    stale: u32,
}

impl Group {
    fn new(samples: &[Swept], material: Material) -> Self {
        Self {
            bound: Block::new(samples, material),
            blocks: samples.chunks(BLOCK).map(|b| Block::new(b, material)).collect(),
            stale: 0,
        }
    }
}

/// Sweeps a tile.
pub fn sweep(tile: &Tile, motion: &Motion, body: &Body, material: Material) -> SweptTile {
    let start = |sample: &Sample| if sample.machined { material.height } else { 0.0 };
    let samples = tile.samples(material.spacing).into_iter().map(|sample| Swept {
        sample,
        height: start(&sample),
        left: start(&sample),
        by: None,
        opened_by: None,
        rapid: None,
    });
    let mut out = SweptTile { samples: samples.collect(), ..SweptTile::default() };
    let mut groups: Vec<Group> =
        out.samples.chunks(BLOCKS * BLOCK).map(|g| Group::new(g, material)).collect();
    let reach = tile.radius + material.height.max(material.deepest);
    motion.near(body, tile.centre, reach, &mut |step| {
        let rapid = motion.moves()[step.of as usize].rapid;
        let mut cut = StepCut { step, body, material, rapid, volume: 0.0, worst: None };
        for (group, samples) in groups.iter_mut().zip(out.samples.chunks_mut(BLOCKS * BLOCK)) {
            cut.group(group, samples);
        }
        if cut.volume > 0.0 {
            out.removed.push((step.index, cut.volume));
        }
        out.touched.extend(cut.worst);
    });
    out
}

/// A step taking what it reaches.
struct StepCut<'a> {
    step: &'a Step,
    body: &'a Body,
    material: Material,
    rapid: bool,
    volume: f64,
    worst: Option<Touch>,
}

impl StepCut<'_> {
    fn group(&mut self, group: &mut Group, samples: &mut [Swept]) {
        if group.bound.is_clear(self.step, self.body) {
            return;
        }
        let mut lowered = false;
        for (block, samples) in group.blocks.iter_mut().zip(samples.chunks_mut(BLOCK)) {
            if !block.is_clear(self.step, self.body) && self.block(samples) {
                block.settle(samples);
                lowered = true;
            }
        }
        if lowered {
            group.stale += 1;
            if group.stale >= STALE {
                group.bound.settle(samples);
                group.stale = 0;
            }
        }
    }

    /// Whether something of a block was lowered.
    fn block(&mut self, samples: &mut [Swept]) -> bool {
        let mut lowered = false;
        for s in samples {
            lowered |= self.sample(s);
        }
        lowered
    }

    fn sample(&mut self, s: &mut Swept) -> bool {
        let (step, body, material) = (self.step, self.body, self.material);
        if is_far(s, step, body, material) {
            return false;
        }
        let mut lowered = false;
        let height = lowered_to(s, step, body, material);
        if s.sample.machined {
            let left = left_on_cell(s, height, step, body, material);
            self.volume += (s.left - left) * s.sample.area;
            lowered = left < s.left;
            s.left = left;
        }
        let Some(height) = height else { return lowered };
        if self.rapid {
            let found = s.rapid.filter(|r| r.0 == step.of).map_or(s.height, |r| r.1);
            s.rapid = Some((step.of, found));
            if self.worst.is_none_or(|w| found - height > w.depth) {
                let place = s.sample.position + s.sample.normal * height;
                self.worst = Some(Touch { of: step.of, place, depth: found - height });
            }
        }
        (s.height, s.by) = (height, Some(step.of));
        if height < 0.5 * material.height {
            s.opened_by = s.opened_by.or(s.by);
        }
        true
    }
}

/// Whether a cutter with a wall in the material stays farther from all that is left of a sample's
/// cell than it goes in a step.
fn is_far(s: &Swept, step: &Step, body: &Body, material: Material) -> bool {
    if !body.has_wall_below(material.height) {
        return false;
    }
    let Sample { position, normal, .. } = s.sample;
    let top = position + normal * (s.height.max(s.left) - NOTHING);
    let near = body.nearest(&step.to, top);
    let way = 2.0 * step.half_way.length() + 2.0 * turned(step, top);
    near.outward.dot(normal) < 0.0 && near.distance > s.sample.cell_width() + way
}

/// The height to which a step lowers a sample's line, if it does.
fn lowered_to(s: &Swept, step: &Step, body: &Body, material: Material) -> Option<f64> {
    let Sample { position, normal, .. } = s.sample;
    if stays_clear(position + normal * (s.height - NOTHING), normal, step, body) {
        return None;
    }
    let (lowest, at) = lowest_entry(s, step, body)?;
    if lowest >= s.height {
        return None;
    }
    if lowest >= 0.0 {
        return Some(lowest);
    }
    // A cutter wholly behind the surface has nothing to do with this side of it.
    let surface = body.contains(&at, position);
    surface.then(|| lowest.max(-material.deepest)).filter(|&height| height < s.height)
}

/// Mean height left over a sample's cell after a step that lowers its line to `height`.
fn left_on_cell(
    s: &Swept,
    height: Option<f64>,
    step: &Step,
    body: &Body,
    material: Material,
) -> f64 {
    let exact = height.unwrap_or(s.height);
    let settled = exact < material.height && s.left <= exact + NOTHING;
    if settled || !body.has_wall_below(material.height) {
        return s.left.min(exact);
    }
    let Sample { centroid, normal, .. } = s.sample;
    let middle = centroid + normal * (0.5 * material.height);
    let width = s.sample.cell_width();
    let level = |at: &Placed| {
        let w = middle - at.tip;
        let across = w - at.axis * w.dot(at.axis);
        let rho = across.length();
        let inside = body.radius() - rho;
        let covered = (0.5 + inside / width).min(1.0);
        if covered <= 0.0 || rho == 0.0 {
            return None;
        }
        // What the part of the cell that is covered is cut down to.
        let inward = across * ((inside - 0.5 * width).min(0.0) / rho);
        let inner = body.entry(at, centroid + inward, normal)?.max(-material.deepest);
        Some(covered * inner + (1.0 - covered) * material.height)
    };
    [&step.middle, &step.to].into_iter().filter_map(level).fold(s.left, f64::min)
}

/// The lowest place at which a sample's line enters the cutter during a step.
///
/// Where the line enters is convex along the step: where it still falls at the end, that is the
/// lowest; else it is found between.
fn lowest_entry(s: &Swept, step: &Step, body: &Body) -> Option<(f64, Placed)> {
    let Sample { position, normal, .. } = s.sample;
    let entry = |at: Placed| body.entry(&at, position, normal).map(|height| (height, at));
    let end = entry(step.to);
    if let Some((height, _)) = end
        && body.is_rounded()
    {
        let point = position + normal * height;
        if step.approach(&step.to, &body.nearest(&step.to, point), point) >= 0.0 {
            return end;
        }
    }
    let (start, middle) = (entry(step.from), entry(step.middle));
    let between = if body.is_ball() && step.half_turn == 0.0 {
        body.ball_sweep_entry(&step.from, &step.to, position, normal)
    } else {
        start.zip(middle).zip(end).and_then(|((a, b), c)| {
            let at = vertex(a.0, b.0, c.0)?;
            let tip = step.middle.tip + step.half_way * at;
            let axis = step.middle.axis + 0.5 * at * (step.to.axis - step.from.axis);
            entry(Placed { tip, axis: axis.normalize_or(step.middle.axis) })
        })
    };
    let all = [between, start, middle, end].into_iter().flatten();
    all.reduce(|a, b| if b.0 < a.0 { b } else { a })
}

/// Where, from -1 to 1, the parabola through the values at -1, 0 and 1 is least, if between them.
fn vertex(a: f64, b: f64, c: f64) -> Option<f64> {
    let bend = a - 2.0 * b + c;
    let at = 0.5 * (a - c) / bend;
    (bend > 0.0 && at.abs() < 1.0 && at != 0.0).then_some(at)
}

/// Whether a step surely leaves a line's material as it is: its top and all below it.
///
/// The distance of the cutter from the line's material is convex along the step, and not negative at
/// its start, where the step before ended. So it stays positive if it still falls at the end without
/// having reached zero, or already grows at the start.
fn stays_clear(top: DVec3, normal: DVec3, step: &Step, body: &Body) -> bool {
    let end = body.nearest(&step.to, top);
    if end.distance <= 0.0 || end.outward.dot(normal) >= 0.0 {
        return false;
    }
    if step.approach(&step.to, &end, top) >= 0.0 {
        return true;
    }
    let start = body.nearest(&step.from, top);
    if start.distance <= 0.0 || start.outward.dot(normal) >= 0.0 {
        return false;
    }
    // It falls at the start and grows at the end: it stays above both tangents.
    let (falls, grows) =
        (step.approach(&step.from, &start, top), -step.approach(&step.to, &end, top));
    falls <= 0.0 || {
        let meet = (start.distance - end.distance + grows) / (falls + grows);
        start.distance - falls * meet > 0.0
    }
}

/// How far the turn of a step moves the cutter beside a point.
fn turned(step: &Step, point: DVec3) -> f64 {
    if step.half_turn == 0.0 { 0.0 } else { step.half_turn * point.distance(step.middle.tip) }
}

impl Block {
    fn new(samples: &[Swept], material: Material) -> Self {
        let n = samples.len().max(1) as f64;
        let sum: DVec3 = samples.iter().map(|s| s.sample.position).sum();
        let centre = sum / n;
        let normals: DVec3 = samples.iter().map(|s| s.sample.normal).sum();
        let normal = normals.normalize_or(DVec3::Z);
        let cell = samples.iter().map(|s| 0.5 * s.sample.cell_width()).fold(0.0, f64::max);
        let across = |p: DVec3| (p - centre - normal * (p - centre).dot(normal)).length() + cell;
        let ends = |s: &Swept| {
            let Sample { position: p, normal: n, .. } = s.sample;
            across(p + n * s.height).max(across(p - n * material.deepest))
        };
        let low = |s: &Swept| {
            (s.sample.position - s.sample.normal * material.deepest - centre).dot(normal)
        };
        let mut block = Self {
            centre,
            normal,
            radius: samples.iter().map(ends).fold(0.0, f64::max),
            top: 0.0,
            bottom: samples.iter().map(low).fold(f64::INFINITY, f64::min),
        };
        block.settle(samples);
        block
    }

    /// Takes note of what is left.
    fn settle(&mut self, samples: &[Swept]) {
        let top = |s: &Swept| {
            let left = s.height.max(s.left);
            (s.sample.position + s.sample.normal * left - self.centre).dot(self.normal)
        };
        self.top = samples.iter().map(top).fold(f64::NEG_INFINITY, f64::max);
    }

    /// Whether the cutter reaches nothing of the block during a step.
    fn is_clear(&self, step: &Step, body: &Body) -> bool {
        let point = self.centre + self.normal * (self.top - NOTHING);
        let near = body.nearest(&step.to, point);
        if near.distance <= 0.0 {
            return false;
        }
        let up = near.outward.dot(self.normal);
        let across = self.radius * (1.0 - up * up).max(0.0).sqrt();
        let below = (self.top - self.bottom).max(0.0) * up.max(0.0);
        let turn = turned(step, point) + step.half_turn * (self.radius + self.top - self.bottom);
        // Before its end the cutter was nearer if it goes away; but what is left was clear of it at the
        // start, where the step before ended.
        let nearer = (-2.0 * step.half_way.dot(near.outward)).max(0.0);
        let way = body.dip(2.0 * step.half_way.length()).map_or(nearer, |dip| dip.min(nearer));
        near.distance - way - across - below - 2.0 * turn > 0.0
    }
}
