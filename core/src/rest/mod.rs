//! Rest: places that a delivered path leaves too high, branches of its passes over them, and rest passes of their own
//! over what the material columns show as left (`passes`).
//!
//! Level curves model the strip of a cutter with a flat bottom to second order, and only up to half a side step
//! beside them. Where passes turn sharply, meet the boundary at a small angle, or end beside passes in another
//! direction, the remaining height is measured on the path itself.
//!
//! - *Height* of a sample of the surface: the lowest position of the cutter along its normal.
//! - *Branch*: a detour from the nearest place of a pass to the rear end of a high place, along it with the cutter
//!   facing as on the pass, and back.
//!
//! 1. The cutter moves straight from each point of the path to the next; the height of a sample is the lowest
//!    position of the cutter over it.
//! 2. The highest sample gets a branch along the samples around it that are too high; then the highest of the others.
//! 3. A place that the cutter cannot touch is reached from the nearest place beside it where the cutter comes low
//!    enough; a place that cannot be reached at all is inaccessible.
//! 4. When no sample is too high any more, the surroundings of those that nearly are get searched for higher places;
//!    then all places are checked once more, as branches may have left others too high.

use crate::cutter_location::{Obstacles, PassOptions, is_in_wall, raise_at, standing_clear};
use crate::flat_path::FlatPoint;
use crate::geometry::{DVec2, DVec3};
use crate::parallel;
use crate::removal::{Columns, Cutter, FeedIndex, Layer, Line, Place};
use crate::tool::ToolKind;
use crate::toolpath::{MoveKind, PathPoint, Toolpath};
use std::collections::BTreeSet;

mod passes;
mod samples;

pub use passes::{RestPassOptions, rest_passes};
pub use samples::Places;
use samples::{Ball, LEVELS, Sample};

/// Fractions of the limit above which more samples are placed around one, and still more around each of those: the
/// samples nearest to the crest of a sharp cusp as high as the limit are not lower than this.
const NEARLY: [f64; LEVELS as usize] = [0.85, 0.95];
/// Fraction of the limit by which a sample must be higher than another to count as clearly higher.
const CLEARLY: f64 = 0.01;
/// How far beside the highest sample, and how far ahead and behind, side steps, others belong to its branch.
const GROUP: [f64; 2] = [0.25, 1.5];
/// A branch where the cutter does not fit is worth making if it lowers a height to this fraction.
const WORTH: f64 = 0.5;
/// Size of the cells in each of which the cutter is tested at one sample, side steps. Smaller: slower.
const CELL: f64 = 0.1;
/// How far beside a branch, side steps, no place is too high any more.
const SWEPT: f64 = 0.4;
/// How far a branch continues ahead of the last sample, side steps: the edge of the strip trails behind.
const AHEAD: f64 = 0.05;
/// How far inside the boundary branches along it run, side steps.
const INSIDE: f64 = 0.15;
/// Number of branches over a place after which it is given up: an obstacle holds the cutter up.
const TRIES: u8 = 3;
/// Greatest number of times that all places are checked.
const LOOKS: u32 = 3;
/// Greatest number of steps toward higher places, halved where none is higher; and the shortest step, side steps.
const CLIMBS: usize = 18;
const FINEST: f64 = 0.0003;
/// Fraction of the distance to the boundary that a branch may continue. More: rounding moves it outside.
const WITHIN: f64 = 0.98;
/// Heights are clamped at this multiple of the limit.
const CLAMP: f64 = 10.0;
/// Greatest number of branches. More: the problem is not single places.
const MOST_BRANCHES: usize = 2000;

/// Limits and cutter.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct RestOptions {
    /// How the cutter is located.
    pub pass: PassOptions,
    /// Distance between passes, mm.
    pub side_step: f64,
    /// Places higher than this are machined again, mm.
    pub limit: f64,
    /// Places lower than this, mm, do not come near the limit again.
    pub close: f64,
    /// How far the edge of the strip trails behind the contact, mm: branches continue beyond the boundary by this.
    pub lag: f64,
    /// Whether passes must cover the surface up to its boundary: no wall stands there.
    pub has_open_rim: bool,
    /// Number of threads; the branches do not depend on it.
    pub threads: usize,
}

/// Measures a path and lays out branches.
pub struct RestFinder<'a> {
    options: RestOptions,
    places: Places<'a>,
    obstacles: &'a Obstacles,
    /// Those that were nearly too high.
    samples: Vec<Sample>,
    /// Number of the first samples that lie in rows beside passes, alternately on one side and the other.
    in_rows: usize,
    /// Whether branches were added since all places were checked.
    is_changed: bool,
    /// How often all places were checked.
    looks: u32,
    /// What is too high and cannot be lowered.
    inaccessible: Vec<Place>,
}

/// From where a sample that is too high can be lowered.
enum Lowered {
    /// The cutter has to touch at this distance beside it, flat.
    From(DVec2),
    /// It does not fit.
    Nowhere,
    /// It would penetrate a wall.
    InWall,
}

impl<'a> RestFinder<'a> {
    /// For the places of a surface; `obstacles`: the part.
    pub fn new(places: Places<'a>, obstacles: &'a Obstacles, options: RestOptions) -> Self {
        Self {
            options,
            places,
            obstacles,
            samples: Vec::new(),
            in_rows: 0,
            is_changed: true,
            looks: 0,
            inaccessible: Vec::new(),
        }
    }

    /// The places that were found too high where the cutter cannot come low enough, from whichever side.
    pub fn into_inaccessible(self) -> Vec<Place> {
        self.inaccessible
    }

    /// All places to be checked.
    fn look(&mut self, flat: &[FlatPoint]) {
        let RestOptions { pass, limit, .. } = self.options;
        (self.samples, self.in_rows) = match pass.tool.kind() {
            ToolKind::Ball => {
                let ball = Ball { radius: pass.tool.radius(), allowance: pass.allowance, limit };
                let samples = self.places.beside_passes(flat, &ball);
                let count = samples.len();
                (samples, count)
            }
            _ => (self.places.over_faces(), 0),
        };
        if self.options.has_open_rim {
            self.samples.extend(self.places.on_rim());
        }
        (self.is_changed, self.looks) = (false, self.looks + 1);
    }

    /// The heights of all samples, with additional samples where it is nearly too high.
    fn refined(&mut self, path: &Toolpath) -> Vec<f64> {
        let limit = self.options.limit;
        let enough =
            |level: u8| NEARLY.get(usize::from(level)).map_or(self.options.close, |n| n * limit);
        let mut heights = self.heights(&self.samples, path, enough(0));
        let mut known = 0;
        while known < self.samples.len() {
            // What is too high is gone over anyway.
            let mut more = Vec::new();
            for (i, height) in heights.iter().enumerate().skip(known) {
                let Sample { level, .. } = self.samples[i];
                if level < LEVELS && (enough(level)..=limit).contains(height) {
                    more.extend(self.places.about(&self.samples[i]));
                    self.samples[i].level = LEVELS;
                }
            }
            known = self.samples.len();
            heights.extend(self.heights(&more, path, enough(LEVELS)));
            self.samples.extend(more);
        }
        heights
    }

    /// The heights of all samples, and which of them are too high and can be lowered.
    fn high(&mut self, path: &Toolpath) -> (Vec<f64>, Vec<usize>) {
        let mut heights = self.refined(path);
        let mut high = self.worth_lowering(&heights, path);
        if high.is_empty() || self.in_rows > 0 {
            self.climb(&mut heights, path);
            high = self.worth_lowering(&heights, path);
        }
        (heights, high)
    }

    /// Whether a sample beside a pass is nearly too high and clearly higher than those before and behind it.
    fn is_top(&self, i: usize, heights: &[f64]) -> bool {
        if i < 2 || i + 2 >= self.in_rows {
            return false;
        }
        let (before, here, behind) = (heights[i - 2], heights[i], heights[i + 2]);
        let limit = self.options.limit;
        (NEARLY[0] * limit..=limit).contains(&here)
            && here >= before.max(behind)
            && here - before.min(behind) > CLEARLY * limit
    }

    /// Climbs from samples that are nearly too high to higher places beside them: samples leave gaps, and the peaks
    /// left by the edge of a flat end are narrow.
    fn climb(&mut self, heights: &mut Vec<f64>, path: &Toolpath) {
        let RestOptions { limit, close, .. } = self.options;
        // Beside passes samples lie on ridges already.
        let low = if self.in_rows > 0 { close } else { close.min(NEARLY[0] * limit) };
        let is_nearly = |i: &usize| {
            let is_high = (low..=limit).contains(&heights[*i]) || self.is_top(*i, heights);
            is_high && !self.samples[*i].is_climbed
        };
        let finest = FINEST * self.options.side_step;
        let nearly = self.by_cell((0..heights.len()).filter(is_nearly), heights);
        let mut front: Vec<usize> = nearly.iter().map(|cell| cell[0]).collect();
        for _ in 0..CLIMBS {
            if front.is_empty() {
                break;
            }
            let beside: Vec<Vec<Sample>> =
                front.iter().map(|&i| self.places.beside(&self.samples[i])).collect();
            front.iter().for_each(|&i| self.samples[i].is_climbed = true);
            let found = self.heights(&beside.concat(), path, low);
            let mut next = Vec::new();
            let mut known = 0;
            for (&from, beside) in front.iter().zip(beside) {
                let of = &found[known..known + beside.len()];
                known += beside.len();
                let highest = beside.into_iter().zip(of).max_by(|a, b| a.1.total_cmp(b.1));
                if let Some((sample, &height)) = highest.filter(|h| *h.1 > heights[from]) {
                    if height <= limit {
                        next.push(self.samples.len());
                    }
                    self.samples.push(sample);
                    heights.push(height);
                } else if heights[from] >= close && self.samples[from].spacing > finest {
                    self.samples[from].spacing *= 0.5;
                    next.push(from);
                }
            }
            front = next;
        }
    }

    /// The flat path with branches over what its delivered path leaves too high; `None` where nothing is too high.
    ///
    /// Samples that are low enough are dropped: branches only remove more material, except where the path keeps fewer
    /// points.
    pub fn with_branches(&mut self, flat: &[FlatPoint], path: &Toolpath) -> Option<Vec<FlatPoint>> {
        let (mut heights, mut high) = self.high(path);
        // What was low enough once may have been spoiled by branches.
        while high.is_empty() && self.is_changed && self.looks < LOOKS {
            self.look(flat);
            (heights, high) = self.high(path);
        }
        self.is_changed |= !high.is_empty();
        high.sort_by(|&a, &b| heights[b].total_cmp(&heights[a]));
        let limit = self.options.limit;
        let lowerable: BTreeSet<usize> = high.iter().copied().collect();
        let is_left = |i: &usize| match heights[*i] > limit {
            true => lowerable.contains(i),
            false => heights[*i] > self.options.close,
        };
        let left: Vec<Sample> = (0..heights.len())
            .filter(is_left)
            .map(|i| Sample {
                branches: self.samples[i].branches + u8::from(heights[i] > limit),
                ..self.samples[i]
            })
            .collect();
        let mut branches: Vec<Branch> = Vec::new();
        while let Some(&worst) = high.first() {
            let Some((from, heading)) = nearest(flat, self.samples[worst].flat) else { break };
            if branches.len() == MOST_BRANCHES {
                break;
            }
            branches.push(self.branch(&mut high, from, heading));
        }
        (self.samples, self.in_rows) = (left, 0);
        (!branches.is_empty()).then(|| with_branches(flat, branches))
    }

    /// The samples that are too high and can be lowered: where the cutter, if it is to touch there, comes low enough,
    /// or much lower than it did, or can lower them from a place beside. The highest sample of a cell represents the
    /// whole cell.
    fn worth_lowering(&mut self, heights: &[f64], path: &Toolpath) -> Vec<usize> {
        let is_worth =
            |i: &usize| heights[*i] > self.options.limit && self.samples[*i].branches < TRIES;
        let cells = self.by_cell((0..heights.len()).filter(is_worth), heights);
        let feeds = FeedIndex::new(path, self.options.pass.axis);
        let lowered = parallel::map(self.options.threads, &cells, |cell| {
            let sample = &self.samples[cell[0]];
            self.lowered(sample, heights[cell[0]], feeds.nearest(sample.flat))
        });
        let mut out = Vec::new();
        for (cell, lowered) in cells.into_iter().zip(lowered) {
            match lowered {
                Lowered::From(beside) => {
                    cell.iter().for_each(|&i| self.samples[i].beside = beside);
                    out.extend(cell);
                }
                Lowered::Nowhere => self.inaccessible.extend(cell.iter().map(|&i| {
                    let Sample { at: centre, spacing: radius, .. } = self.samples[i];
                    Place { centre, radius }
                })),
                Lowered::InWall => {}
            }
        }
        out
    }

    /// From where the cutter lowers a sample.
    fn lowered(&self, sample: &Sample, height: f64, feed: DVec3) -> Lowered {
        let RestOptions { pass, limit, .. } = &self.options;
        let &Sample { at, normal, flat, .. } = sample;
        // No branch leads into a wall.
        if is_in_wall(at, normal, feed, pass, self.obstacles) {
            return Lowered::InWall;
        }
        let raise = raise_at(at, normal, feed, pass, self.obstacles);
        if raise <= limit.max(WORTH * height) {
            return Lowered::From(DVec2::ZERO);
        }
        let low = at + normal * (pass.allowance + limit);
        let reaches = |s: &Sample| {
            standing_clear(s.at, s.normal, feed, pass, self.obstacles)
                .is_some_and(|at| at.contains(low))
        };
        let place = self.places.around(sample).find(reaches);
        place.map_or(Lowered::Nowhere, |place| Lowered::From(place.flat - flat))
    }

    /// Samples by the cells in which they lie, the highest of each first.
    fn by_cell(&self, some: impl Iterator<Item = usize>, heights: &[f64]) -> Vec<Vec<usize>> {
        let side = CELL * self.options.side_step;
        let cell = |i: usize| (self.samples[i].at / side).to_array().map(|x| x.floor() as i64);
        let mut keyed: Vec<([i64; 3], usize)> = some.map(|i| (cell(i), i)).collect();
        keyed.sort_by(|a, b| a.0.cmp(&b.0).then(heights[b.1].total_cmp(&heights[a.1])));
        let cells = keyed.chunk_by(|a, b| a.0 == b.0);
        cells.map(|cell| cell.iter().map(|c| c.1).collect()).collect()
    }

    /// A branch along the samples around the first one; these and all beside it are then done.
    fn branch(&self, high: &mut Vec<usize>, from: usize, heading: DVec2) -> Branch {
        let worst = high[0];
        let sample = &self.samples[worst];
        // Where that was in vain, over the very place.
        let origin = match sample.branches {
            0 if sample.beside == DVec2::ZERO => self.places.inside(sample, INSIDE),
            _ => sample.flat + sample.beside,
        };
        let scale = sample.scale;
        let steps = scale / self.options.side_step;
        let place = |i: usize| {
            let Sample { flat, beside, .. } = self.samples[i];
            let way = (flat + beside - origin) * steps;
            (way.dot(heading), way.perp_dot(heading).abs())
        };
        let [beside, ahead] = GROUP;
        let group = high.iter().map(|&i| place(i));
        let group = group.filter(|(along, across)| along.abs() <= ahead && *across <= beside);
        let (rear, front) = group.fold((0.0f64, 0.0f64), |(r, f), (a, _)| (r.min(a), f.max(a)));
        let at = |along: f64| origin + heading * (along / steps);
        let (end, is_at_boundary) = self.within(origin, at(front + AHEAD));
        let overrun = if is_at_boundary { self.options.lag } else { 0.0 };
        let ahead = (end - origin).dot(heading);
        // Beyond the boundary it goes on as before, so that there is to be as much before.
        let before = ahead - overrun / scale;
        let (begin, _) = self.within(origin, at(rear.min(before * steps)));
        let (rear, front) = ((begin - origin).dot(heading) * steps, ahead * steps);
        let is_left = |(along, across): (f64, f64)| {
            along < rear - AHEAD || along > front + AHEAD || across > SWEPT
        };
        high.retain(|&i| i != worst && is_left(place(i)));
        let (rear, front) = (begin, end);
        Branch { from, heading, rear, front, overrun }
    }

    /// The end of the straight flat line from a place of the chart, or the last point of it on the chart, and whether
    /// it leaves the chart.
    fn within(&self, from: DVec2, to: DVec2) -> (DVec2, bool) {
        let Ok(start) = self.places.locator.locate(from) else { return (from, true) };
        match self.places.locator.walk(start.face, from, to, |_, _| {}) {
            Ok(_) => (to, false),
            Err(outside) => (from.lerp(outside.uv, WITHIN), true),
        }
    }

    /// The height that a path leaves above the allowance on every sample, mm: exact above `enough`, an upper bound
    /// elsewhere.
    fn heights(&self, samples: &[Sample], path: &Toolpath, enough: f64) -> Vec<f64> {
        let RestOptions { pass, limit, threads, .. } = self.options;
        let cutter = Cutter { tool: pass.tool, length: pass.reach };
        let layer = Layer { allowance: pass.allowance, depth: CLAMP * limit };
        let line = |s: &Sample| (Line { foot: s.at, normal: s.normal }, s.flat);
        let lines: Vec<(Line, DVec2)> = samples.iter().map(line).collect();
        let (columns, ids) = Columns::on(&lines, layer.top());
        let path = near_links(path, cutter.tool.radius());
        let left = columns.remains(&path, cutter, layer, pass.allowance + enough, threads);
        let mut heights = vec![0.0; lines.len()];
        let above =
            ids.iter().zip(left.heights()).map(|(id, height)| (*id, height - pass.allowance));
        above.for_each(|(id, height)| heights[id as usize] = height);
        heights
    }
}

/// The path with links longer than the radius as rapids, since on them the cutter arrives from above and may turn; a
/// link without length remains at their ends.
fn near_links(path: &Toolpath, radius: f64) -> Toolpath {
    let mut points: Vec<PathPoint> = Vec::with_capacity(path.points.len());
    for point in &path.points {
        let way = points.last().map_or(0.0, |before| before.tip.distance(point.tip));
        if point.kind == MoveKind::Link && way > radius {
            points.push(PathPoint { kind: MoveKind::Rapid, ..*point });
        }
        points.push(*point);
    }
    Toolpath { points }
}

/// The point of a pass nearest to a flat place, by index, and the direction in which the cutter faces or moves there.
fn nearest(flat: &[FlatPoint], place: DVec2) -> Option<(usize, DVec2)> {
    let square = |i: usize| flat[i].at.distance_squared(place);
    let way = |i: usize| {
        let before = (flat[i].at - flat[i.checked_sub(1)?].at).try_normalize();
        flat[i].heading.or(before)
    };
    let on_pass = (0..flat.len()).filter(|&i| flat[i].kind == MoveKind::Cut);
    let going = on_pass.filter(|&i| way(i).is_some());
    let found = going.min_by(|&a, &b| square(a).total_cmp(&square(b)))?;
    Some((found, way(found)?))
}

/// A detour from a point of the path over a high place and back.
struct Branch {
    /// Index of the point.
    from: usize,
    /// The direction in which the cutter faces.
    heading: DVec2,
    /// Where it begins, a flat place.
    rear: DVec2,
    /// Where it ends.
    front: DVec2,
    /// How far it continues beyond the boundary there, mm.
    overrun: f64,
}

/// The path with branches.
fn with_branches(flat: &[FlatPoint], mut branches: Vec<Branch>) -> Vec<FlatPoint> {
    branches.sort_by_key(|branch| branch.from);
    let mut next = branches.into_iter().peekable();
    let mut out = Vec::new();
    for (i, point) in flat.iter().enumerate() {
        let facing = next.peek().filter(|branch| branch.from == i).map(|branch| branch.heading);
        let point = FlatPoint { heading: point.heading.or(facing), ..*point };
        out.push(point);
        while let Some(Branch { rear, front, overrun, .. }) = next.next_if(|d| d.from == i) {
            let ways = [(rear, 0.0), (front, overrun), (point.at, 0.0)];
            out.extend(ways.map(|(at, overrun)| FlatPoint { at, overrun, ..point }));
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cutter_location::{CheckMesh, ToolAxis};
    use crate::flatten::{Chart, Locator};
    use crate::geometry::math::{cos, sin};
    use crate::job::{Component, Selection, SurfaceOptions, SurfaceSource};
    use crate::surface::{AnalyticSurface, Surface, build};
    use crate::tool::Tool;

    const RADIUS: f64 = 2.5;
    const LEAD: f64 = 0.1;
    const HALF: f64 = 5.0;

    /// A point of the path at which the bottom touches the plane, going along x.
    fn touching(at: DVec2, kind: MoveKind) -> PathPoint {
        let contact_to_tip = DVec3::new(-cos(LEAD), 0.0, sin(LEAD)) * RADIUS;
        PathPoint {
            kind,
            pass: 0,
            region: 0,
            tip: at.extend(0.0) + contact_to_tip,
            axis: DVec3::new(sin(LEAD), 0.0, cos(LEAD)),
            normal: DVec3::Z,
            flat: Some(at),
            feed: 10.0,
            mrr: 0.0,
            alpha: 0.0,
            time: 0.0,
        }
    }

    /// How high the bottom's edge is so far beside the contact.
    fn lag(beside: f64) -> f64 {
        (RADIUS - (RADIUS * RADIUS - beside * beside).sqrt()) * sin(LEAD)
    }

    /// Passes along x and beyond the square, with points half a millimetre apart.
    fn passes(ys: &[f64]) -> Vec<FlatPoint> {
        let point = |y: f64, i: i32| FlatPoint {
            at: DVec2::new(0.5 * f64::from(i), y),
            height: 0.0,
            kind: if i == -12 { MoveKind::Link } else { MoveKind::Cut },
            pass: 0,
            region: 0,
            feed: 10.0,
            mrr: 0.0,
            alpha: 0.0,
            length: 0.5,
            heading: Some(DVec2::X),
            overrun: 0.0,
        };
        ys.iter().flat_map(|&y| (-12..=12).map(move |i| point(y, i))).collect()
    }

    /// A level square around the origin.
    fn plane() -> Surface {
        let options = SurfaceOptions {
            source: SurfaceSource::File(String::new()),
            scale: 1.0,
            rotate: DVec3::ZERO,
            translate: DVec3::ZERO,
            select: Selection { component: Component::Only, ..Selection::default() },
            curvature_radius: None,
            chord: None,
            face: None,
            flip: false,
        };
        let plane = AnalyticSurface::Plane { width: 2.0 * HALF, depth: 2.0 * HALF };
        build(plane.mesh(1.0), &options).unwrap().surface
    }

    const SIDE_STEP: f64 = 1.0;

    /// A ball whose passes on a plane are a side step apart.
    fn ball() -> RestOptions {
        let cusp = RADIUS - (RADIUS * RADIUS - 0.25 * SIDE_STEP * SIDE_STEP).sqrt();
        RestOptions {
            pass: PassOptions {
                tool: Tool::new(RADIUS, RADIUS).unwrap(),
                axis: ToolAxis::Fixed(DVec3::Z),
                axis_rate: f64::INFINITY,
                allowance: 0.5,
                tolerance: 0.001,
                reach: f64::INFINITY,
            },
            side_step: SIDE_STEP,
            limit: 1.02 * cusp,
            close: cusp,
            lag: 0.0,
            has_open_rim: true,
            threads: 2,
        }
    }

    /// Straight passes along x from and to the boundary, or another place.
    fn straight(ys: &[f64], end: impl Fn(f64) -> f64) -> Vec<FlatPoint> {
        let point = |at: DVec2, kind: MoveKind| FlatPoint { at, kind, ..passes(&[0.0])[0] };
        let pass = |&y: &f64| {
            let [from, to] = [-HALF, end(y)].map(|x| DVec2::new(x, y));
            [point(from, MoveKind::Link), point(to, MoveKind::Cut)]
        };
        ys.iter().flat_map(pass).collect()
    }

    /// The flat path with branches of the ball, the rounds that took and what it cannot reach.
    fn with_branches(flat: &[FlatPoint], check: CheckMesh) -> (Vec<FlatPoint>, usize, Vec<Place>) {
        let surface = plane();
        let uv: Vec<DVec2> = surface.positions().iter().map(|p| p.truncate()).collect();
        let chart = Chart::new(&surface, uv);
        let locator = Locator::new(surface.connectivity(), chart.uv());
        let places =
            Places { surface: &surface, chart: &chart, locator: &locator, side_step: SIDE_STEP };
        let (obstacles, options) = (Obstacles::of_part(check), ball());
        let mut finder = RestFinder::new(places, &obstacles, options);
        let mut flat = flat.to_vec();
        for round in 0..20 {
            let point = |p: &FlatPoint| {
                let tip = p.at.extend(options.pass.allowance);
                PathPoint { tip, axis: DVec3::Z, ..touching(p.at, p.kind) }
            };
            match finder
                .with_branches(&flat, &Toolpath { points: flat.iter().map(point).collect() })
            {
                Some(more) => flat = more,
                None => return (flat, round, finder.into_inaccessible()),
            }
        }
        panic!("still too high");
    }

    fn between(low: f64, high: f64) -> impl Fn(&FlatPoint) -> bool {
        move |p| p.at.y > low && p.at.y < high
    }

    /// A ball along passes at these places leaves too much between two of them, beside the last one and where one ends
    /// before the boundary: branches lower each, and nothing else.
    #[test]
    fn what_a_ball_leaves_is_gone_over() {
        let part = || {
            let surface = plane();
            let (positions, faces) = surface.triangles();
            CheckMesh::new(positions.to_vec(), faces)
        };
        let all: Vec<f64> = (-5..5).map(|i| f64::from(i) + 0.5).collect();
        let (flat, rounds, _) = with_branches(&straight(&all, |_| HALF), part());
        assert_eq!((flat.len(), rounds), (20, 0));
        let gap: Vec<f64> = all.iter().copied().filter(|y| *y != 0.5).collect();
        let short: Vec<f64> = all.iter().copied().filter(|y| *y < 4.0).collect();
        let (in_gap, ..) = with_branches(&straight(&gap, |_| HALF), part());
        assert!(in_gap.iter().any(between(0.0, 1.0)), "{in_gap:?}");
        assert!(in_gap.iter().all(|p| gap.contains(&p.at.y) || between(0.0, 1.0)(p)));
        let (beside, ..) = with_branches(&straight(&short, |_| HALF), part());
        assert!(beside.iter().any(|p| p.at.y > 4.0), "{beside:?}");
        let ends = |y: f64| if y == 0.5 { 2.0 } else { HALF };
        let (ended, rounds, _) = with_branches(&straight(&all, ends), part());
        let beyond = |p: &FlatPoint| p.at.x > 2.0 && between(0.0, 1.0)(p);
        assert!(rounds > 0 && ended.iter().any(beyond), "{ended:?}");
    }

    /// Beside a step in the part a ball cannot touch the ground within its radius, but reaches half a side step of that
    /// from where it can: what lies farther in is inaccessible, and nothing else is.
    #[test]
    fn what_cannot_be_touched_is_reached_from_beside() {
        let step = 0.1 - HALF;
        let reach = step + RADIUS + ball().pass.allowance;
        let surface = plane();
        let (positions, mut faces) = surface.triangles();
        let first = positions.len() as u32;
        let upright = [[-50.0, 0.0], [50.0, 0.0], [0.0, 50.0]].map(|[x, z]| DVec3::new(x, step, z));
        faces.push([first, first + 1, first + 2]);
        let check = CheckMesh::new(positions.iter().copied().chain(upright).collect(), faces);
        let rows: Vec<f64> = (0..7).map(|i| reach + 0.7 + 0.95 * f64::from(i)).collect();
        let (flat, rounds, inaccessible) = with_branches(&straight(&rows, |_| HALF), check);
        assert!(rounds > 0 && flat.iter().any(between(reach - 1e-9, reach + 0.3)), "{flat:?}");
        assert!(flat.iter().all(|p| p.at.y > reach - 0.01), "{flat:?}");
        let farthest = inaccessible.iter().map(|p| p.centre.y).fold(f64::MIN, f64::max);
        let to_limit = |limit: f64| (RADIUS * RADIUS - (RADIUS - limit).powi(2)).sqrt();
        let expected = reach - to_limit(ball().limit);
        assert!((farthest - expected).abs() < 0.1, "{farthest} of {expected}");
    }

    #[test]
    fn a_missing_pass_is_made_up_for() {
        let side_step = 1.0;
        let surface = plane();
        let flat = surface.positions().iter().map(|p| p.truncate()).collect();
        let chart = Chart::new(&surface, flat);
        let locator = Locator::new(surface.connectivity(), chart.uv());
        let places = Places { surface: &surface, chart: &chart, locator: &locator, side_step };
        let limit = 0.5 * (lag(0.5 * side_step) + lag(side_step));
        let behind = lag(0.5 * side_step) / sin(LEAD);
        let options = RestOptions {
            pass: PassOptions {
                tool: Tool::new(RADIUS, 0.0).unwrap(),
                axis: ToolAxis::Lead(LEAD),
                axis_rate: f64::INFINITY,
                allowance: 0.0,
                tolerance: 0.001,
                reach: f64::INFINITY,
            },
            side_step,
            limit,
            close: limit,
            lag: behind,
            has_open_rim: true,
            threads: 2,
        };
        let check = |roof: Option<f64>| {
            let (positions, mut faces) = surface.triangles();
            let roof = roof.map(|z| {
                [[-50.0, -0.2], [50.0, -0.2], [0.0, 2.0]].map(|[x, y]| DVec3::new(x, y, z))
            });
            let first = positions.len() as u32;
            faces.extend(roof.map(|_| [first, first + 1, first + 2]));
            Obstacles::of_part(CheckMesh::new(
                positions.iter().copied().chain(roof.into_iter().flatten()).collect(),
                faces,
            ))
        };
        let with_branches = |ys: &[f64], obstacles: &Obstacles| {
            let mut finder = RestFinder::new(places, obstacles, options);
            let mut flat = passes(ys);
            let mut rounds = 0;
            loop {
                let points =
                    flat.iter().map(|p| touching(p.at + p.overrun * DVec2::X, p.kind)).collect();
                let path = Toolpath { points };
                match finder.with_branches(&flat, &path) {
                    Some(more) if rounds < 4 => flat = more,
                    left => return (flat, rounds, left.is_none()),
                }
                rounds += 1;
            }
        };
        let all: Vec<f64> = (-5..=5).map(f64::from).map(|y| 0.98 * y).collect();
        let (flat, rounds, is_kept) = with_branches(&all, &check(None));
        assert!(is_kept && rounds == 0, "{rounds} rounds, {} points", flat.len());
        let gap: Vec<f64> = all.iter().copied().filter(|y| *y != 0.0).collect();
        let (flat, rounds, is_kept) = with_branches(&gap, &check(None));
        assert!(is_kept && rounds > 0, "{rounds} rounds");
        let added = flat.len() - passes(&gap).len();
        let in_gap = flat.iter().filter(|p| p.at.y.abs() < 0.5).count();
        assert!(in_gap >= 8 && added <= 4 * in_gap, "{in_gap} of {added}");
        // Under a roof over the gap, higher than half of what was left, no branch helps.
        let (flat, rounds, _) = with_branches(&gap, &check(Some(CLAMP * limit)));
        assert!(rounds == 0 && flat.len() == passes(&gap).len(), "{rounds} rounds");
    }
}
