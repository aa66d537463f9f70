//! A tile of the part while the cutter goes along the path: the height above the surface that is left
//! on each sample's normal line, and how much each step takes.
//!
//! The line of a sample starts full of material up to the stock's height and down into the part. A step lowers it to
//! where the line enters the cutter. A height below the surface is a gouge.
//!
//! For the removed volume, a sample represents a cell as wide as the sample distance: where a wall of the cutter
//! passes over the cell, it is removed gradually, so that the rate measures area and does not count samples; not
//! where the line is inclined to its cell, as on steep places. The residual does not use cells.
//!
//! Most steps near a tile do not reach what is left of it. A block of samples is skipped where a plane separates it
//! from the cutter (`bound`).

use super::body::{Body, Placed};
use super::bound::{Bounds, NOTHING};
use super::lanes::{Vectors, each, lanes};
use super::material::{Cell, Material, Swept};
use super::motion::{Motion, Step};
use super::samples::{BLOCK, Sample, Tile};
use crate::geometry::DVec3;

/// A line counts as inclined to its cell from this fraction of the cell's width on.
const LEANING: f64 = 0.3;

/// A tile after the sweep.
#[derive(Clone, Debug, Default)]
pub struct SweptTile {
    /// Its samples.
    pub samples: Vec<Swept>,
    /// Volume removed, mm³, by step, in order.
    pub removed: Vec<(u64, f64)>,
    /// Rapids that removed material: step and place of the largest removal.
    pub touched: Vec<Touch>,
}

/// A rapid in material.
#[derive(Copy, Clone, Debug)]
pub struct Touch {
    /// Index of the move.
    pub of: u32,
    /// Where, mm.
    pub place: DVec3,
    /// Height removed there, mm.
    pub depth: f64,
}

/// Trisections by which the place of the edge is narrowed down: to a thousandth of a step.
const EDGE_STEPS: usize = 16;
/// How far inside the entry of a line under the edge it is evaluated, in fractions of half a step.
const INSIDE_EDGE: f64 = 1e-4;
/// Lines that rise less than this along the axis are square to it, mm/mm.
const SQUARE: f64 = 1e-9;
/// Most steps to the lowest place under a rounded rim.
const RIM_STEPS: usize = 11;
/// A height this close to the lowest counts as the lowest, mm.
const SETTLED: f64 = 5e-5;
/// Blocks that are tested together first.
const BLOCKS: usize = 8;
/// Groups of blocks whose bounds are tested together.
const GROUPS: usize = 8;
/// Number of steps that lower something of a group before its bound is recomputed.
const STALE: u32 = 12;

/// Blocks that lie together.
struct Group {
    bounds: Bounds<BLOCKS>,
    blocks: Vec<Block>,
    /// Steps that lowered something since the group's own bound was computed.
    stale: u32,
}

/// A block: what its samples' lines still hold.
struct Block {
    /// The samples.
    all: u32,
    /// Highest material on each line.
    tops: Vectors<BLOCK>,
    normals: Vectors<BLOCK>,
    cells: Cells,
}

/// The cells of a block's samples, for cutters whose wall cuts.
struct Cells {
    /// Those over which a wall has not yet passed.
    open: u32,
    /// Those that it passed over.
    covered: u32,
    /// Highest material over each centroid.
    tops: Vectors<BLOCK>,
    /// Middle of the stock over each centroid.
    middles: Vectors<BLOCK>,
    /// Squared distance from the cutter's axis at which its wall reaches the cell.
    reach: [f64; BLOCK],
}

/// Samples during the sweep, and their bounds.
struct Sweep {
    out: SweptTile,
    groups: Vec<Group>,
    bounds: Vec<Bounds<GROUPS>>,
}

/// A cut: the moves of a cutter.
#[derive(Copy, Clone)]
pub struct Cut<'a> {
    /// The moves.
    pub motion: &'a Motion,
    /// The cutter.
    pub body: &'a Body,
}

/// Sweeps the samples of a tile by cuts in their order; what is removed and touched is that of the last one.
pub fn sweep(tile: &Tile, samples: Vec<Sample>, cuts: &[Cut], material: Material) -> SweptTile {
    let start = cuts.first().map_or_else(Vec::new, |cut| uncut(samples, cut.body, material));
    let mut out = SweptTile { samples: start, ..SweptTile::default() };
    let reach = tile.radius + material.height.max(material.deepest);
    for (i, Cut { motion, body }) in cuts.iter().enumerate() {
        if i > 0 {
            out.samples = for_next(out.samples, body, material);
        }
        let mut sweep = Sweep::new(out.samples, body, material);
        motion.near(body, tile.centre, reach, &mut |step| {
            sweep.take(step, motion.moves()[step.of as usize].rapid, body, material);
        });
        out = sweep.out;
    }
    out
}

/// The samples as a later cut meets them.
fn for_next(samples: Vec<Swept>, body: &Body, material: Material) -> Vec<Swept> {
    let walled = body.has_wall_below(material.height);
    samples.into_iter().map(|s| s.for_next(walled, material)).collect()
}

/// Scattered samples after cuts in their order, of each some steps.
pub fn swept_in_order(
    samples: Vec<Sample>,
    cuts: &[(Vec<Step>, &Body)],
    material: Material,
) -> Vec<Swept> {
    let Some((_, first)) = cuts.first() else { return Vec::new() };
    let mut samples = uncut(samples, first, material);
    for (i, (steps, body)) in cuts.iter().enumerate() {
        if i > 0 {
            samples = for_next(samples, body, material);
        }
        sweep_scattered(&mut samples, steps, body, material);
    }
    samples
}

/// Sweeps scattered samples by some steps, in their order. Samples without area do not count for the volume.
pub fn swept(samples: Vec<Sample>, steps: &[Step], body: &Body, material: Material) -> Vec<Swept> {
    let mut samples = uncut(samples, body, material);
    sweep_scattered(&mut samples, steps, body, material);
    samples
}

fn sweep_scattered(samples: &mut [Swept], steps: &[Step], body: &Body, material: Material) {
    for samples in samples.chunks_mut(BLOCK) {
        let mut bounds = Bounds::<1>::EMPTY;
        bounds.add(samples, material);
        let mut block = Block::new(samples, body, material);
        for step in steps {
            let mut cut = StepCut { step, body, material, rapid: false, volume: 0.0, worst: None };
            if bounds.reached(step, body) != 0 && cut.block(&mut block, samples) {
                bounds.settle(0, samples);
            }
        }
    }
}

fn uncut(samples: Vec<Sample>, body: &Body, material: Material) -> Vec<Swept> {
    let walled = body.has_wall_below(material.height);
    samples.into_iter().map(|s| Swept::new(s, walled, material)).collect()
}

impl Sweep {
    fn new(samples: Vec<Swept>, body: &Body, material: Material) -> Self {
        let out = SweptTile { samples, ..SweptTile::default() };
        let groups = out.samples.chunks(BLOCKS * BLOCK);
        let mut bounds: Vec<Bounds<GROUPS>> = Vec::new();
        for (i, group) in groups.clone().enumerate() {
            if i % GROUPS == 0 {
                bounds.push(Bounds::EMPTY);
            }
            bounds[i / GROUPS].add(group, material);
        }
        let groups = groups.map(|g| Group::new(g, body, material)).collect();
        Self { out, groups, bounds }
    }

    fn take(&mut self, step: &Step, rapid: bool, body: &Body, material: Material) {
        let Self { out, groups, bounds } = self;
        let mut cut = StepCut { step, body, material, rapid, volume: 0.0, worst: None };
        for (set, bounds) in bounds.iter_mut().enumerate() {
            for lane in each(bounds.reached(step, body)) {
                let of = set * GROUPS + lane;
                let first = of * BLOCKS * BLOCK;
                let end = (first + BLOCKS * BLOCK).min(out.samples.len());
                let samples = &mut out.samples[first..end];
                if cut.group(&mut groups[of], samples) {
                    bounds.settle(lane, samples);
                }
            }
        }
        if cut.volume > 0.0 {
            out.removed.push((step.index, cut.volume));
        }
        out.touched.extend(cut.worst);
    }
}

/// A step that removes what it reaches.
struct StepCut<'a> {
    step: &'a Step,
    body: &'a Body,
    material: Material,
    rapid: bool,
    volume: f64,
    worst: Option<Touch>,
}

impl StepCut<'_> {
    /// Whether the group's bound has to be recomputed.
    fn group(&mut self, group: &mut Group, samples: &mut [Swept]) -> bool {
        let mut lowered = false;
        for lane in each(group.bounds.reached(self.step, self.body)) {
            let first = lane * BLOCK;
            let end = (first + BLOCK).min(samples.len());
            let samples = &mut samples[first..end];
            if self.block(&mut group.blocks[lane], samples) {
                group.bounds.settle(lane, samples);
                lowered = true;
            }
        }
        group.stale += u32::from(lowered);
        let stale = group.stale >= STALE;
        if stale {
            group.stale = 0;
        }
        stale
    }

    /// Whether something of a block was lowered.
    fn block(&mut self, block: &mut Block, samples: &mut [Swept]) -> bool {
        let lines = self.step.reaches(self.body, &block.tops, &block.normals, block.all);
        let cells = block.cells.reached(self.step, self.body, &block.normals);
        let mut lowered = false;
        for lane in each(lines | cells) {
            let s = &mut samples[lane];
            if self.sample(s, lines >> lane & 1 == 1, cells >> lane & 1 == 1) {
                block.note(lane, s);
                lowered = true;
            }
        }
        lowered
    }

    /// Whether something of a sample was lowered; the step may reach its line and its cell or not.
    fn sample(&mut self, s: &mut Swept, line: bool, cell: bool) -> bool {
        let (step, body, material) = (self.step, self.body, self.material);
        let mut lowered = false;
        let height = if line { lowered_to(s, step, body, material) } else { None };
        if s.sample.machined && (cell || height.is_some() || s.cell == Cell::Line) {
            let (left, cell) = left_on_cell(s, height, step, body, material);
            self.volume += s.sample.section.between(left, s.left);
            lowered = left < s.left;
            (s.left, s.cell) = (left, cell);
        }
        let Some(height) = height else { return lowered };
        if self.rapid {
            let found = s.rapid.filter(|r| r.0 == step.of).map_or(s.height, |r| f64::from(r.1));
            s.rapid = Some((step.of, found as f32));
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

/// The height to which a step lowers a sample's line, if it does.
fn lowered_to(s: &Swept, step: &Step, body: &Body, material: Material) -> Option<f64> {
    if let Some(behind) = s.sample.wall {
        return lowered_in_wall(s, behind, step, body);
    }
    let (lowest, at) = lowest_entry(s, step, body)?;
    if lowest >= s.height {
        return None;
    }
    if lowest >= 0.0 {
        return Some(lowest);
    }
    // A cutter wholly behind the surface has nothing to do with this side of it.
    let place = s.sample.position;
    if !body.contains(&at, place) {
        return None;
    }
    // At a sharp edge a line soon leaves the part, and the cutter that only touches the edge may be beyond: what lies
    // within it by no more than the tolerance is cut no deeper than that.
    let within = deepest_within(place, step, body).max(body.depth(&at, place)).max(0.0);
    let deepest = if within > material.tolerance { material.deepest } else { within };
    let height = lowest.max(-deepest);
    (height < s.height).then_some(height)
}

/// How deep within the cutter a place comes to lie during a step, mm; negative: outside.
fn deepest_within(place: DVec3, step: &Step, body: &Body) -> f64 {
    let centre = step.middle.tip + step.middle.axis * body.corner();
    let part = (place - centre).dot(step.half_way) / step.half_way.length_squared();
    let nearest = step.at(if part.is_finite() { part.clamp(-1.0, 1.0) } else { 0.0 });
    let depth = |at: &Placed| body.depth(at, place);
    [&step.from, &step.middle, &step.to, &nearest].map(depth).into_iter().fold(f64::MIN, f64::max)
}

/// As above, on the line of a wall that is material down to `behind` mm below its place.
///
/// A cutter wholly behind the wall is in that material as well.
fn lowered_in_wall(s: &Swept, behind: f64, step: &Step, body: &Body) -> Option<f64> {
    if s.height <= -behind {
        return None;
    }
    let Sample { position, normal, .. } = s.sample;
    let (lowest, at) = lowest_in_wall(s, step, body)?;
    if lowest < -behind {
        // Unless it comes no nearer than where the wall's material ends.
        let reaches = |at: &Placed| body.entry(at, position, -normal).is_some_and(|t| t < behind);
        let places = [&step.from, &step.middle, &step.to, &at];
        return places.into_iter().any(reaches).then_some(-behind);
    }
    (lowest < s.height).then_some(lowest)
}

/// The lowest place at which a wall's line enters the cutter during a step, faster where it is perpendicular to an
/// axis that does not turn: there the cutter is round.
fn lowest_in_wall(s: &Swept, step: &Step, body: &Body) -> Option<(f64, Placed)> {
    let Sample { position, normal, .. } = s.sample;
    if step.half_turn != 0.0 || normal.dot(step.to.axis).abs() > SQUARE {
        return lowest_entry(s, step, body);
    }
    let way = |at: &Placed| (at.tip - position).dot(normal);
    if way(&step.from).min(way(&step.to)) - body.radius() >= s.height {
        return None;
    }
    let entry = |at: Placed| body.entry(&at, position, normal).map(|height| (height, at));
    let places = [step.from, step.middle, step.to].map(entry);
    let [Some(a), Some(b), Some(c)] = places else { return lowest_entry(s, step, body) };
    let between = vertex(a.0, b.0, c.0).and_then(|part| entry(step.at(part)));
    Some(between.into_iter().fold(lower(a, lower(b, c)), lower))
}

/// Mean height left over a sample's cell after a step that lowers its line to `height`, and its basis from then on.
fn left_on_cell(
    s: &Swept,
    height: Option<f64>,
    step: &Step,
    body: &Body,
    material: Material,
) -> (f64, Cell) {
    let (centroid, normal) = (s.sample.centroid(), s.sample.normal);
    let width = s.sample.cell_width();
    // How far the top of the line is beside its foot, seen along the axis: a wall takes as long to pass over it.
    let lean = material.height * normal.cross(step.to.axis).length();
    if s.cell == Cell::Line || lean >= LEANING * width {
        return (s.left.min(height.unwrap_or(s.height)), s.cell);
    }
    let middle = centroid + normal * (0.5 * material.height);
    let (mut left, mut cell) = (s.left, s.cell);
    for at in [&step.middle, &step.to] {
        let w = middle - at.tip;
        let across = w - at.axis * w.dot(at.axis);
        let rho = across.length();
        let inside = body.radius() - rho;
        let covered = (0.5 + inside / width).min(1.0);
        if covered <= 0.0 || rho == 0.0 {
            continue;
        }
        // What the part of the cell that is covered is cut down to.
        let inward = across * ((inside - 0.5 * width).min(0.0) / rho);
        if let Some(inner) = body.entry(at, centroid + inward, normal) {
            let inner = inner.max(-material.deepest);
            left = left.min(covered * inner + (1.0 - covered) * material.height);
            if covered >= 1.0 && left < material.height {
                cell = Cell::Covered;
            }
        }
    }
    (left, cell)
}

/// The lowest place at which a sample's line enters the cutter during a step.
///
/// The place where the line enters is convex along the step: if it still falls at the end, that is the lowest;
/// otherwise it is searched between.
fn lowest_entry(s: &Swept, step: &Step, body: &Body) -> Option<(f64, Placed)> {
    let Sample { position, normal, .. } = s.sample;
    if !body.is_rounded()
        && step.half_turn == 0.0
        && let Some(lowest) = body.lowest_through_flat([step.from, step.to], position, normal)
    {
        return Some(lowest);
    }
    if !body.is_rounded() {
        return lowest_at_edge(step, body, position, normal);
    }
    let entry = |at: Placed, guess: f64| {
        body.entry_near(&at, position, normal, guess).map(|height| (height, at))
    };
    let end = entry(step.to, s.height);
    if let Some((height, _)) = end
        && body.is_rounded()
    {
        let point = position + normal * height;
        if step.approach(&step.to, &body.nearest(&step.to, point), point) >= 0.0 {
            return end;
        }
    }
    // The start is the end of the step before, or where the path begins.
    let guess = end.map_or(s.height, |e| e.0);
    let start = entry(step.from, guess);
    if body.is_ball() && step.half_turn == 0.0 {
        let between = body.ball_sweep_entry(&step.from, &step.to, position, normal);
        return [between, start, end].into_iter().flatten().reduce(lower);
    }
    if !body.is_ball() {
        return lowest_at_rim(step, body, (position, normal), [start, end], s.height);
    }
    let guess = start.map_or(guess, |s| 0.5 * (s.0 + guess));
    let middle = entry(step.middle, guess);
    let between = {
        start.zip(middle).zip(end).and_then(|((a, b), c)| {
            let at = vertex(a.0, b.0, c.0)?;
            entry(step.at(at), b.0 - 0.25 * at * (a.0 - c.0))
        })
    };
    [between, start, middle, end].into_iter().flatten().reduce(lower)
}

/// The lowest place at which a line enters a cutter with a rounded rim during a step, at the end of which it rises;
/// `ends`: where it enters at both ends. Not computed if it is certainly above what is left already.
///
/// Under a tilted bottom the entry falls evenly, and behind it rises like the rim's rounding: the curve is not a
/// parabola.
fn lowest_at_rim(
    step: &Step,
    body: &Body,
    (position, normal): (DVec3, DVec3),
    ends: [Option<(f64, Placed)>; 2],
    left: f64,
) -> Option<(f64, Placed)> {
    // Change of the height over the whole step.
    let slope = |(height, at): &(f64, Placed)| {
        let point = position + normal * *height;
        let near = body.nearest(at, point);
        step.approach(at, &near, point) / near.outward.dot(normal).min(-f64::MIN_POSITIVE)
    };
    let tangent = |part: f64, found: Option<(f64, Placed)>| {
        let known = found.as_ref().map(|f| (f.0, 0.5 * slope(f)));
        (part, known)
    };
    let [start, end] = ends;
    let mut best = ends.into_iter().flatten().reduce(lower);
    let (mut falling, mut rising) = (tangent(-1.0, start), tangent(1.0, end));
    if falling.1.is_some_and(|(_, slope)| slope > 0.0) {
        return best;
    }
    for round in 0..RIM_STEPS {
        let least = best.map_or(left, |b| b.0.min(left));
        let part = match (falling, rising) {
            ((from, Some((a, down))), (to, Some((b, up)))) => {
                // Where the tangents meet none is below; where the slope, if linear, is zero.
                let meet = (b - up * to - a + down * from) / (down - up);
                if !(from < meet && meet < to) || least - (a + down * (meet - from)) < SETTLED {
                    return best;
                }
                if round % 2 == 0 { meet } else { from - down * (to - from) / (up - down) }
            }
            _ => 0.5 * (falling.0 + rising.0),
        };
        let place = step.at(part);
        let guess = best.map_or(0.0, |b| b.0);
        let found = body.entry_near(&place, position, normal, guess).map(|height| (height, place));
        best = best.into_iter().chain(found).reduce(lower);
        let found = tangent(part, found);
        // Where the line is not met it is on the side on which it is.
        let is_rising = found.1.map_or(rising.1.is_none(), |(_, slope)| slope > 0.0);
        *(if is_rising { &mut rising } else { &mut falling }) = found;
    }
    best
}

/// The lowest place at which a line enters a cutter with a sharp edge during a step.
///
/// A wall that overhangs the line comes down on it steeply, until its edge passes; behind the edge the tilted bottom
/// rises: a valley with a kink, which a parabola does not find.
fn lowest_at_edge(
    step: &Step,
    body: &Body,
    position: DVec3,
    normal: DVec3,
) -> Option<(f64, Placed)> {
    let entry = |at: f64| {
        let at = step.at(at);
        body.entry(&at, position, normal).map(|height| (height, at))
    };
    let height = |found: Option<(f64, Placed)>| found.map_or(f64::INFINITY, |f| f.0);
    let [from, middle, to] = [-1.0, 0.0, 1.0].map(entry);
    let (a, b, c) = (height(from), height(middle), height(to));
    let (mut low, mut high) = match () {
        () if a < b => (-1.0, 0.0),
        () if c < b => (0.0, 1.0),
        () => (-1.0, 1.0),
    };
    // A line that the edge passes over may be met between these alone.
    let passing = edge_crossings(step, body, position, normal).into_iter().flatten();
    let met = [from, middle, to].into_iter().flatten();
    let mut best = met.chain(passing.filter_map(entry)).reduce(lower)?;
    for _ in 0..EDGE_STEPS {
        let third = (high - low) / 3.0;
        let (left, right) = (entry(low + third), entry(high - third));
        best = [left, right].into_iter().flatten().fold(best, lower);
        if height(left) < height(right) { high -= third } else { low += third }
    }
    Some(best)
}

/// The positions in a step, just inside, at which a line comes under a flat end's bottom and leaves it.
///
/// In the plane of the bottom the squared distance of the line from the axis is a parabola, if the cutter does not
/// turn; if it turns slightly, one step of Newton's method is needed.
fn edge_crossings(step: &Step, body: &Body, position: DVec3, normal: DVec3) -> [Option<f64>; 2] {
    let outside = |part: f64| body.outside_of_bottom(&step.at(part), position, normal);
    let [a, b, c] = [-1.0, 0.0, 1.0].map(outside);
    let (bend, slope) = (0.5 * (a - 2.0 * b + c), 0.5 * (c - a));
    let square = slope * slope - 4.0 * bend * b;
    if bend.is_nan() || bend <= 0.0 || square <= 0.0 {
        return [None; 2];
    }
    let root = square.sqrt();
    [-1.0, 1.0].map(|side| {
        let part = 0.5 * (side * root - slope) / bend;
        let part = part - outside(part) / (side * root) - side * INSIDE_EDGE;
        (part.abs() < 1.0).then_some(part)
    })
}

fn lower(a: (f64, Placed), b: (f64, Placed)) -> (f64, Placed) {
    if b.0 < a.0 { b } else { a }
}

/// Where, from -1 to 1, the parabola through the values at -1, 0 and 1 is least, if between them.
fn vertex(a: f64, b: f64, c: f64) -> Option<f64> {
    let bend = a - 2.0 * b + c;
    let at = 0.5 * (a - c) / bend;
    (bend > 0.0 && at.abs() < 1.0 && at != 0.0).then_some(at)
}

impl Group {
    fn new(samples: &[Swept], body: &Body, material: Material) -> Self {
        let mut bounds = Bounds::EMPTY;
        samples.chunks(BLOCK).for_each(|block| bounds.add(block, material));
        let block = |b| Block::new(b, body, material);
        Self { bounds, blocks: samples.chunks(BLOCK).map(block).collect(), stale: 0 }
    }
}

impl Block {
    fn new(samples: &[Swept], body: &Body, material: Material) -> Self {
        let zero = Vectors::ZERO;
        let reach = [0.0; BLOCK];
        let cells = Cells { open: 0, covered: 0, tops: zero, middles: zero, reach };
        let mut block = Self { all: 0, tops: zero, normals: zero, cells };
        for (lane, s) in samples.iter().enumerate() {
            let (centroid, normal) = (s.sample.centroid(), s.sample.normal);
            block.all |= 1 << lane;
            block.normals.set(lane, normal);
            block.cells.middles.set(lane, centroid + normal * (0.5 * material.height));
            let reach = body.radius() + 0.5 * s.sample.cell_width();
            block.cells.reach[lane] = reach * reach;
            block.note(lane, s);
        }
        block
    }

    /// Updates the bound with what is left of a sample.
    fn note(&mut self, lane: usize, s: &Swept) {
        let (position, centroid, normal) =
            (s.sample.position, s.sample.centroid(), s.sample.normal);
        self.tops.set(lane, position + normal * (s.height - NOTHING));
        self.cells.tops.set(lane, centroid + normal * (s.left - NOTHING));
        let mark =
            |set: &mut u32, is_in: bool| *set = *set & !(1 << lane) | u32::from(is_in) << lane;
        mark(&mut self.cells.open, s.cell == Cell::Open);
        mark(&mut self.cells.covered, s.cell == Cell::Covered);
    }
}

impl Cells {
    /// The cells of which the cutter may remove something in a step.
    fn reached(&self, step: &Step, body: &Body, normals: &Vectors<BLOCK>) -> u32 {
        let mut reached = 0;
        if self.covered != 0 {
            reached |= step.reaches(body, &self.tops, normals, self.covered);
        }
        if self.open != 0 {
            let [middle, to] = [&step.middle, &step.to].map(|at| self.middles.rho_squared(at));
            let least = |i: usize| if middle[i] < to[i] { middle[i] } else { to[i] };
            reached |= self.open & lanes::<BLOCK>(|i| least(i) < self.reach[i]);
        }
        reached
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tool::Tool;

    /// A number from 0 to 1, the next one of a row.
    fn number(seed: &mut u64) -> f64 {
        *seed =
            seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (*seed >> 11) as f64 / (1u64 << 53) as f64
    }

    /// The edge of a leaning flat end goes over lines near its side for a part of a step, which may be short: as low as
    /// at the lowest of many places of the step, which do not see what is met for less than the way between two.
    #[test]
    fn an_edge_that_passes_over_a_line_lowers_it() {
        let body = Body::new(&Tool::new(5.0, 0.0).unwrap(), 50.0);
        let mut seed = 7;
        let mut met = 0;
        for _ in 0..2000 {
            let mut any = |from: f64, to: f64| from + (to - from) * number(&mut seed);
            let (lead, turn) = (any(0.02, 0.4), any(-0.008, 0.008));
            let placed = |x: f64, lead: f64| Placed {
                tip: DVec3::new(x, 0.0, 5.0 * lead),
                axis: DVec3::new(lead, 0.3 * turn, 1.0).normalize(),
            };
            let half = any(0.05, 0.25);
            let [from, to] = [placed(-half, lead - turn), placed(half, lead + turn)];
            let middle =
                Placed { tip: 0.5 * (from.tip + to.tip), axis: (from.axis + to.axis).normalize() };
            let step = Step {
                from,
                middle,
                to,
                of: 0,
                index: 0,
                half_way: 0.5 * (to.tip - from.tip),
                half_turn: 0.5 * to.axis.distance(from.axis),
            };
            let foot = DVec3::new(any(-1.5, 1.5), any(4.7, 5.0), 0.0);
            let normal = DVec3::new(any(-0.1, 0.1), any(-0.1, 0.1), 1.0).normalize();
            let entry = |i: u32| {
                let at = step.at(f64::from(i) / 500.0 - 1.0);
                body.entry(&at, foot, normal)
            };
            let lowest = (0..=1000).filter_map(entry).reduce(f64::min);
            let found = lowest_at_edge(&step, &body, foot, normal).map(|(height, _)| height);
            let Some(lowest) = lowest else { continue };
            let found = found.unwrap();
            met += 1;
            assert!(found <= lowest + 1e-4, "{found} at the lowest, not {lowest}");
            assert!(found > lowest - 1e-3, "{found} instead of {lowest}");
        }
        assert!(met > 500, "{met}");
    }
}
