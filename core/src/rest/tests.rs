use super::heights::CLAMP;
use super::*;
use crate::cutter_location::{CheckMesh, Obstacles, PassOptions, ToolAxis};
use crate::flat_path::FlatPoint;
use crate::flatten::Chart;
use crate::footprint::Footprint;
use crate::geometry::math::sin;
use crate::job::{Component, Faces, Selection, SurfaceOptions, SurfaceSource};
use crate::lift::Lift;
use crate::link::{DeliverOptions, Deliverer};
use crate::removal::Before;
use crate::surface::{AnalyticSurface, Surface, build};
use crate::tool::Tool;
use crate::toolpath::MoveKind;

const RADIUS: f64 = 2.5;
const LEAD: f64 = 0.1;
const HALF: f64 = 5.0;
const SIDE_STEP: f64 = 1.0;

/// A level square around the origin.
fn plane() -> Surface {
    let options = SurfaceOptions {
        source: SurfaceSource::File(String::new()),
        scale: 1.0,
        rotate: DVec3::ZERO,
        translate: DVec3::ZERO,
        select: Selection { component: Component::Only, ..Selection::default() },
        curvature_radius: None,
        steepest: None,
        chord: None,
        face: Faces::Only,
        flip: false,
    };
    let plane = AnalyticSurface::Plane { width: 2.0 * HALF, depth: 2.0 * HALF };
    build(plane.mesh(1.0), &options).unwrap().surface
}

/// The square, and more triangles above it.
fn part(above: &[[[f64; 3]; 3]]) -> CheckMesh {
    let surface = plane();
    let (positions, mut faces) = surface.triangles();
    let first = positions.len() as u32;
    faces.extend((0..above.len() as u32).map(|i| [0, 1, 2].map(|corner| first + 3 * i + corner)));
    let more = above.as_flattened().iter().map(|p| DVec3::from(*p));
    CheckMesh::new(positions.iter().copied().chain(more).collect(), faces)
}

fn ball() -> PassOptions {
    PassOptions {
        tool: Tool::new(RADIUS, RADIUS).unwrap(),
        axis: ToolAxis::Fixed(DVec3::Z),
        axis_rate: f64::INFINITY,
        largest_tilt: 0.0,
        allowance: 0.5,
        tolerance: 0.001,
        reach: f64::INFINITY,
    }
}

/// A flat end that leans forward.
fn flat_end() -> PassOptions {
    PassOptions {
        tool: Tool::new(RADIUS, 0.0).unwrap(),
        axis: ToolAxis::Lead(LEAD),
        allowance: 0.0,
        ..ball()
    }
}

/// How high the flat end's edge is so far beside the contact.
fn lag(beside: f64) -> f64 {
    (RADIUS - (RADIUS * RADIUS - beside * beside).sqrt()) * sin(LEAD)
}

fn options(limit: f64, close: f64, lag: f64) -> RestOptions {
    RestOptions { side_step: SIDE_STEP, limit, allowed: limit, close, lag, has_open_rim: true }
}

/// A ball whose passes are a side step apart.
fn of_ball() -> RestOptions {
    let cusp = RADIUS - (RADIUS * RADIUS - 0.25 * SIDE_STEP * SIDE_STEP).sqrt();
    options(1.02 * cusp, cusp, 0.0)
}

/// Passes along x from and to the boundary, or another place.
fn straight(ys: &[f64], end: impl Fn(f64) -> f64) -> Vec<FlatPoint> {
    let point = |at: DVec2, kind: MoveKind| FlatPoint {
        at,
        height: 0.0,
        kind,
        pass: 0,
        region: 0,
        feed: 10.0,
        mrr: 0.0,
        alpha: 0.0,
        length: 0.5,
        heading: None,
        overrun: 0.0,
    };
    let pass = |&y: &f64| {
        let [from, to] = [-HALF, end(y)].map(|x| DVec2::new(x, y));
        [point(from, MoveKind::Rapid), point(from, MoveKind::Link), point(to, MoveKind::Cut)]
    };
    ys.iter().flat_map(pass).collect()
}

/// A path before and after the rest is cut, and what cannot be reached.
struct Done {
    before: Delivered,
    after: Delivered,
    inaccessible: Vec<Place>,
    /// The highest sample that is left where the cutter comes.
    highest: f64,
}

impl Done {
    /// Flat places of the points that were added.
    fn added(&self) -> Vec<DVec2> {
        let mut old = self.before.toolpath.points.iter().peekable();
        let is_new = |p: &&PathPoint| old.next_if(|o| o.tip == p.tip && o.kind == p.kind).is_none();
        let new: Vec<&PathPoint> = self.after.toolpath.points.iter().filter(is_new).collect();
        assert!(old.peek().is_none(), "a point of the path is gone");
        new.iter().filter_map(|p| p.flat).collect()
    }
}

fn done(flat: &[FlatPoint], pass: PassOptions, check: CheckMesh, options: RestOptions) -> Done {
    let surface = plane();
    let uv: Vec<DVec2> = surface.positions().iter().map(|p| p.truncate()).collect();
    let chart = Chart::new(&surface, uv);
    let locator = chart.locator(&surface);
    let places =
        Places { surface: &surface, chart: &chart, locator: &locator, side_step: SIDE_STEP };
    let footprint = Footprint::new(pass.tool, 0.0);
    let lift = Lift::new(&surface, &chart, &locator, (RADIUS, footprint), None);
    let obstacles = Obstacles::of_part(check);
    let deliver = DeliverOptions {
        pass,
        rapid_plane: 20.0,
        highest_raise: RADIUS,
        entry_radius: 0.0,
        threads: 2,
        slow_below: 1.0,
        air_feed: 20.0,
        rapid_feed: 100.0,
    };
    let deliverer = Deliverer { lift: &lift, obstacles: &obstacles, options: deliver };
    let before = deliverer.path(flat, None, |_| {}).unwrap();
    let uncut = Before::default();
    let mut rest = Rest::new(places, deliverer, &uncut, options);
    let after = rest.cut(before.clone()).unwrap();
    rest.samples = rest.all_samples(&after, None);
    let strokes = rest.strokes(&after.toolpath);
    let heights = rest.refined(&strokes);
    let high = rest.worth_lowering(&heights, &after.toolpath);
    let highest = high.iter().map(|&i| heights[i]).fold(0.0, f64::max);
    Done { before, after, inaccessible: rest.into_inaccessible(), highest }
}

fn between(low: f64, high: f64) -> impl Fn(&DVec2) -> bool {
    move |at| at.y > low && at.y < high
}

/// A ball along passes at these places leaves too much between two of them, beside the last one and where one ends
/// before the boundary: branches lower each, and nothing else is changed.
#[test]
fn what_a_ball_leaves_is_gone_over() {
    let of = |ys: &[f64], end: &dyn Fn(f64) -> f64| {
        done(&straight(ys, end), ball(), part(&[]), of_ball())
    };
    let all: Vec<f64> = (-5..5).map(|i| f64::from(i) + 0.5).collect();
    assert!(of(&all, &|_| HALF).added().is_empty());
    let gap: Vec<f64> = all.iter().copied().filter(|y| *y != 0.5).collect();
    let in_gap = of(&gap, &|_| HALF);
    assert!(in_gap.added().iter().any(between(0.0, 1.0)));
    assert!(in_gap.added().iter().all(|at| gap.contains(&at.y) || between(0.0, 1.0)(at)));
    assert_eq!(in_gap.highest, 0.0);
    // Along the gap at a stretch, not by a branch for every few side steps.
    let is_long = |w: &[DVec2]| w.iter().all(between(0.0, 1.0)) && (w[1].x - w[0].x).abs() > 8.0;
    assert!(in_gap.added().windows(2).any(is_long));
    let short: Vec<f64> = all.iter().copied().filter(|y| *y < 4.0).collect();
    let beside = of(&short, &|_| HALF);
    assert!(beside.added().iter().any(|at| at.y > 4.0));
    assert_eq!(beside.highest, 0.0);
    let ended = of(&all, &|y| if y == 0.5 { 2.0 } else { HALF });
    assert!(ended.added().iter().any(|at| at.x > 2.0 && between(0.0, 1.0)(at)));
    assert_eq!(ended.highest, 0.0);
}

/// Beside a step in the part a ball cannot touch the ground within its radius, but reaches half a side step of that
/// from where it can: what lies farther in is inaccessible, and nothing else is.
#[test]
fn what_cannot_be_touched_is_reached_from_beside() {
    let step = 0.1 - HALF;
    let reach = step + RADIUS + ball().allowance;
    let upright = [[-50.0, step, 0.0], [50.0, step, 0.0], [0.0, step, 50.0]];
    let rows: Vec<f64> = (0..7).map(|i| reach + 0.7 + 0.95 * f64::from(i)).collect();
    let done = done(&straight(&rows, |_| HALF), ball(), part(&[upright]), of_ball());
    let added = done.added();
    assert!(added.iter().any(between(reach - 1e-9, reach + 0.3)), "{added:?}");
    assert!(added.iter().all(|at| at.y > reach - 0.01), "{added:?}");
    let farthest = done.inaccessible.iter().map(|p| p.centre.y).fold(f64::MIN, f64::max);
    let to_limit = |limit: f64| (RADIUS * RADIUS - (RADIUS - limit).powi(2)).sqrt();
    let expected = reach - to_limit(of_ball().limit);
    assert!((farthest - expected).abs() < 0.1, "{farthest} of {expected}");
}

#[test]
fn a_missing_pass_is_made_up_for() {
    let limit = 0.5 * (lag(0.5 * SIDE_STEP) + lag(SIDE_STEP));
    let options = options(limit, limit, lag(0.5 * SIDE_STEP) / sin(LEAD));
    // It comes from and goes to beyond the boundary.
    let passes = |ys: &[f64]| {
        let mut flat = straight(ys, |_| HALF);
        for pass in flat.chunks_mut(3) {
            (pass[1].overrun, pass[2].overrun) = (-1.0, 1.0);
        }
        flat
    };
    let all: Vec<f64> = (-5..=5).map(f64::from).map(|y| 0.98 * y).collect();
    let whole = done(&passes(&all), flat_end(), part(&[]), options);
    assert!(whole.added().is_empty(), "{:?}", whole.added());
    let gap: Vec<f64> = all.iter().copied().filter(|y| *y != 0.0).collect();
    let made_up = done(&passes(&gap), flat_end(), part(&[]), options);
    let in_gap = made_up.added().iter().filter(|at| at.y.abs() < 0.5).count();
    assert!(in_gap >= 2);
    assert_eq!(made_up.highest, 0.0);
    // Under a roof over the gap nothing can be lowered, beside it all that the lifted passes leave.
    let height = CLAMP * limit;
    let roof = [[-50.0, -0.2, height], [50.0, -0.2, height], [0.0, 2.0, height]];
    let roofed = done(&passes(&gap), flat_end(), part(&[roof]), options);
    assert_eq!(roofed.highest, 0.0);
    let is_below = |p: &Place| (-0.2..1.8).contains(&p.centre.y);
    assert!(roofed.inaccessible.iter().any(is_below));
    assert!(roofed.added().iter().all(|at| at.y < 0.0 || at.y > 3.0), "{:?}", roofed.added());
}
