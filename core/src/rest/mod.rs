//! Rest: places that a delivered path leaves too high, and the branches of its passes over them.
//!
//! Level curves model the strip of a cutter with a flat bottom to second order, and only up to half a side step
//! beside them. Where passes turn sharply, meet the boundary at a small angle, or end beside passes in another
//! direction, the remaining height is measured on the path itself.
//!
//! - *Height* of a sample of the surface: the lowest position of the cutter along its normal (`heights`).
//! - *Branch*: a detour from the nearest place of a pass to the rear end of a high place, along it with the cutter
//!   facing as on the pass, and back (`branch`). Where the cutter cannot go there on the surface, a *rest pass*: down
//!   from above, along it and up again.
//!
//! 1. The cutter moves straight from each point of the path to the next; the height of a sample is the lowest
//!    position of the cutter over it.
//! 2. A place that the cutter cannot touch is reached from the nearest place beside it where the cutter comes low
//!    enough; a place that cannot be reached at all is inaccessible.
//! 3. The highest sample gets a branch along the samples around it that are too high. What the branch leaves of all
//!    samples near it is measured; what is still too high is next. A branch that lowers nothing enough is left out.
//! 4. The branches are inserted into the path, which is not changed elsewhere: no sample gets higher.
//! 5. The surroundings of what is nearly too high are searched for higher places, and 2 to 4 are repeated.

use crate::cutter_location::{is_in_wall, lowest_off_walls, raise_at, standing_clear};
use crate::geometry::{DVec2, DVec3};
use crate::link::{DeliverError, Delivered, Deliverer};
use crate::parallel;
use crate::removal::{FeedIndex, Place};
use crate::toolpath::{PathPoint, Toolpath};
use std::collections::BTreeSet;

mod branch;
mod heights;
mod samples;

use branch::{Branch, inserted};
pub use samples::Places;
use samples::Sample;

/// A branch where the cutter does not fit is worth making if it lowers a height to this fraction.
const WORTH: f64 = 0.5;
/// Number of branches over a place after which it is given up: an obstacle holds the cutter up.
const TRIES: u8 = 3;
/// Greatest number of rounds of searching and lowering.
const ROUNDS: usize = 6;
/// Greatest number of branches of a round, and of those that are tried. More: the problem is not single places.
const MOST_BRANCHES: usize = 2000;
const MOST_TRIED: usize = 3 * MOST_BRANCHES;

/// What may be left.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct RestOptions {
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
}

/// Measures a path and cuts what it leaves too high.
pub struct Rest<'a> {
    options: RestOptions,
    places: Places<'a>,
    deliverer: Deliverer<'a>,
    /// Those that were nearly too high.
    samples: Vec<Sample>,
    /// Number of the first samples that lie in rows beside passes, alternately on one side and the other.
    in_rows: usize,
    /// What is too high and cannot be lowered.
    inaccessible: Vec<Place>,
}

/// From where a sample that is too high can be lowered.
enum Lowered {
    /// The cutter has to touch at this distance beside it, flat.
    From(DVec2),
    /// It does not fit.
    Nowhere,
    /// It would penetrate a wall, and does not come low enough beside it.
    InWall,
}

impl<'a> Rest<'a> {
    /// For the places of a surface on which `deliverer` puts paths.
    pub fn new(places: Places<'a>, deliverer: Deliverer<'a>, options: RestOptions) -> Self {
        let (samples, inaccessible) = (Vec::new(), Vec::new());
        Self { options, places, deliverer, samples, in_rows: 0, inaccessible }
    }

    /// The path with branches over what it leaves too high. All that a branch or pass may leave is looked at.
    ///
    /// # Errors
    /// [`DeliverError`] when a rest pass cannot be delivered.
    pub fn cut(&mut self, path: Delivered) -> Result<Delivered, DeliverError> {
        (self.samples, self.in_rows) = self.all_samples(&path);
        self.rounds(path)
    }

    /// The path with branches over what is too high at these flat places.
    ///
    /// # Errors
    /// As [`cut`](Self::cut).
    pub fn cut_at(&mut self, left: &[DVec2], path: Delivered) -> Result<Delivered, DeliverError> {
        let samples = left.iter().filter_map(|at| self.places.at(*at));
        (self.samples, self.in_rows) = (samples.collect(), 0);
        self.rounds(path)
    }

    /// The places that were found too high where the cutter cannot come low enough, from whichever side.
    pub fn into_inaccessible(self) -> Vec<Place> {
        self.inaccessible
    }

    fn rounds(&mut self, mut path: Delivered) -> Result<Delivered, DeliverError> {
        for _ in 0..ROUNDS {
            let (heights, high) = self.high(&path.toolpath);
            let branches = self.branches(&path, heights, high);
            if branches.is_empty() {
                break;
            }
            path = inserted(path, branches, &self.deliverer)?;
        }
        Ok(path)
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

    /// Branches over what is too high, the highest sample first. Afterwards the samples are those that are or were
    /// nearly too high.
    fn branches(
        &mut self,
        path: &Delivered,
        mut heights: Vec<f64>,
        mut high: Vec<usize>,
    ) -> Vec<Branch> {
        let RestOptions { limit, close, .. } = self.options;
        let lowerable: BTreeSet<usize> = high.iter().copied().collect();
        high.sort_by(|&a, &b| heights[b].total_cmp(&heights[a]));
        let mut branches: Vec<Branch> = Vec::new();
        for _ in 0..MOST_TRIED {
            let Some(&worst) = high.first().filter(|_| branches.len() < MOST_BRANCHES) else {
                break;
            };
            let before = heights[worst];
            let Some((branch, aimed)) = self.branch(&high, path) else { break };
            let lowered = branch.is_some_and(|branch| {
                let is_of_use = self.lower(&mut heights, &high, &branch);
                branches.extend(is_of_use.then_some(branch));
                is_of_use
            });
            for &i in aimed.iter().filter(|i| heights[**i] > limit) {
                self.samples[i].branches += 1;
            }
            // What came lower, but not low enough, is for the next round, which looks for a way from beside.
            let is_lowered = lowered && heights[worst] < before;
            high.retain(|&i| {
                heights[i] > limit
                    && self.samples[i].branches < TRIES
                    && !(i == worst && is_lowered)
            });
        }
        let is_left = |i: &usize| heights[*i] > close || lowerable.contains(i);
        let is_excused = |i: &usize| heights[*i] > limit && !lowerable.contains(i);
        let left = (0..heights.len()).filter(|i| is_left(i) && !is_excused(i));
        self.samples = left.map(|i| self.samples[i]).collect();
        self.in_rows = 0;
        for branch in &branches {
            let beside = self.samples_beside(branch.path());
            self.samples.extend(beside);
        }
        branches
    }

    /// Lowers the heights of what is too high by those that a branch leaves; whether one comes low enough, or much
    /// lower where the cutter does not fit.
    fn lower(&self, heights: &mut [f64], high: &[usize], branch: &Branch) -> bool {
        let near: Vec<usize> = high.iter().copied().filter(|&i| self.is_near(i, branch)).collect();
        let samples: Vec<Sample> = near.iter().map(|&i| self.samples[i]).collect();
        let left = self.heights(&samples, &branch.path().toolpath, self.options.limit);
        let mut is_of_use = false;
        for (i, left) in near.into_iter().zip(left) {
            is_of_use |= left <= self.options.limit.max(WORTH * heights[i]);
            heights[i] = heights[i].min(left);
        }
        is_of_use
    }

    /// Whether a branch may lower a sample.
    fn is_near(&self, sample: usize, branch: &Branch) -> bool {
        let Sample { at, .. } = self.samples[sample];
        let tool = self.deliverer.options.pass.tool;
        let points = &branch.path().toolpath.points;
        let reach = 2.0 * tool.radius() + self.options.side_step;
        let is_beside = |w: &[PathPoint]| {
            let (from, way) = (w[0].tip, w[1].tip - w[0].tip);
            let along = (at - from).dot(way) / way.length_squared().max(f64::MIN_POSITIVE);
            (from + way * along.clamp(0.0, 1.0)).distance(at) <= reach
        };
        points.windows(2).any(is_beside)
    }

    /// The samples that are too high and can be lowered: where the cutter, if it is to touch there, comes low enough,
    /// or much lower than it did, or can lower them from a place beside. The highest sample of a cell represents the
    /// whole cell.
    fn worth_lowering(&mut self, heights: &[f64], path: &Toolpath) -> Vec<usize> {
        let is_worth =
            |i: &usize| heights[*i] > self.options.limit && self.samples[*i].branches < TRIES;
        let cells = self.by_cell((0..heights.len()).filter(is_worth), heights);
        let feeds = FeedIndex::new(path, self.deliverer.options.pass.axis);
        let lowered = parallel::map(self.deliverer.options.threads, &cells, |cell| {
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
        let (limit, obstacles) = (self.options.limit, self.deliverer.obstacles);
        let pass = &self.deliverer.options.pass;
        let &Sample { at, normal, flat, .. } = sample;
        let low = at + normal * (pass.allowance + limit);
        if is_in_wall(at, normal, feed, pass, obstacles) {
            let beside = lowest_off_walls(at, normal, feed, pass, obstacles);
            return match beside.is_some_and(|beside| beside.contains(low)) {
                true => Lowered::From(DVec2::ZERO),
                false => Lowered::InWall,
            };
        }
        let raise = raise_at(at, normal, feed, pass, obstacles);
        if raise <= limit.max(WORTH * height) {
            return Lowered::From(DVec2::ZERO);
        }
        let reaches = |s: &Sample| {
            standing_clear(s.at, s.normal, feed, pass, obstacles).is_some_and(|at| at.contains(low))
        };
        let place = self.places.around(sample).find(reaches);
        place.map_or(Lowered::Nowhere, |place| Lowered::From(place.flat - flat))
    }
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
