//! The judge against closed forms, and against faults planted in paths.

use super::*;
use crate::footprint::Footprint;
use crate::geometry::math;
use crate::tool::{Assembly, AssemblyPart, Tool};
use crate::toolpath::PathPoint;

/// A triangle mesh made from a grid.
struct Part {
    positions: Vec<DVec3>,
    faces: Vec<[u32; 3]>,
}

impl Part {
    /// `n` by `m` cells over the unit square, mapped by `at`.
    fn grid(n: usize, m: usize, at: impl Fn(f64, f64) -> DVec3) -> Self {
        let mut positions = Vec::new();
        for j in 0..=m {
            for i in 0..=n {
                positions.push(at(i as f64 / n as f64, j as f64 / m as f64));
            }
        }
        let index = |i: usize, j: usize| (j * (n + 1) + i) as u32;
        let mut faces = Vec::new();
        for j in 0..m {
            for i in 0..n {
                let [a, b, c, d] =
                    [index(i, j), index(i + 1, j), index(i + 1, j + 1), index(i, j + 1)];
                faces.extend([[a, b, c], [a, c, d]]);
            }
        }
        Self { positions, faces }
    }

    fn plane(width: f64, depth: f64) -> Self {
        Self::grid(2, 2, |u, v| DVec3::new(u * width, v * depth, 0.0))
    }

    fn facets(&self) -> Facets<'_> {
        Facets { positions: &self.positions, faces: &self.faces }
    }
}

const FEED: f64 = 20.0;

/// A path along polylines of tip and axis at [`FEED`], with rapids 20 mm up between them.
fn path(passes: &[Vec<(DVec3, DVec3)>]) -> Toolpath {
    let mut points: Vec<PathPoint> = Vec::new();
    let mut time = 0.0;
    let mut push = |kind, tip: DVec3, axis: DVec3, pass: usize| {
        time += points.last().map_or(0.0, |p| p.tip.distance(tip) / FEED);
        points.push(PathPoint {
            kind,
            pass: pass as u32,
            region: 0,
            tip,
            axis,
            normal: axis,
            flat: None,
            feed: FEED,
            mrr: 0.0,
            alpha: 0.0,
            time,
        });
    };
    for (i, pass) in passes.iter().enumerate() {
        let ((first, a), (last, b)) = (pass[0], pass[pass.len() - 1]);
        push(MoveKind::Rapid, first + a * 20.0, a, i);
        pass.iter().for_each(|&(tip, axis)| push(MoveKind::Cut, tip, axis, i));
        push(MoveKind::Cut, last + b * 20.0, b, i);
    }
    Toolpath { points }
}

fn options(radius: f64, corner: f64) -> VerifyOptions {
    VerifyOptions {
        tool: Tool::new(radius, corner).unwrap(),
        length: f64::INFINITY,
        depth: 0.5,
        tells_rate: true,
        earlier: None,
        allowance: 0.0,
        scallop: None,
        tolerance: 0.002,
        mrr_limit: None,
        load: None,
        spacing: 0.1,
        up: DVec3::Z,
        inaccessible: Vec::new(),
        bridges: Vec::new(),
        walls: None,
        above: None,
        stock: None,
        avoided: Vec::new(),
        threads: 1,
    }
}

fn judged(path: &Toolpath, part: &Part, options: &VerifyOptions) -> Verification {
    let nothing = Facets { positions: &[], faces: &[] };
    verify(path, part.facets(), nothing, options, &mut |_| {}).unwrap()
}

/// Straight passes along x over a plane at z = 0, `y` apart, from beyond one side to beyond the
/// other.
fn raster(width: f64, ys: &[f64]) -> Vec<Vec<(DVec3, DVec3)>> {
    let end = |x, y| (DVec3::new(x, y, 0.0), DVec3::Z);
    ys.iter().map(|&y| vec![end(-8.0, y), end(width + 8.0, y)]).collect()
}

fn evenly(from: f64, step: f64, count: usize) -> Vec<f64> {
    (0..count).map(|i| from + step * i as f64).collect()
}

#[track_caller]
fn assert_close(found: f64, expected: f64, relative: f64) {
    let error = found / expected - 1.0;
    assert!(error.abs() <= relative, "{found}, expected {expected}: {:+.3} %", 100.0 * error);
}

#[test]
fn cusps_of_a_ball_on_a_plane() {
    let (r, d) = (5.0, 1.0);
    let v =
        judged(&path(&raster(20.0, &evenly(0.0, d, 21))), &Part::plane(20.0, 20.0), &options(r, r));
    let h = r - (r * r - 0.25 * d * d).sqrt();
    assert_close(v.figures.largest.unwrap().height, h, 0.01);
    assert_close(v.figures.mean, h / 3.0, 0.01);
    assert!(v.figures.gouge.is_none_or(|g| g.height > -1e-9));
    assert_eq!(v.figures.untouched.0, 0.0);
}

/// Samples of both sides lie together in tiles and blocks.
#[test]
fn cusps_of_a_ball_on_both_sides_of_a_thin_sheet() {
    let (r, d, thickness) = (4.0, 0.8, 0.9);
    let sheet = |z: f64| move |u: f64, v: f64| DVec3::new(20.0 * u, 20.0 * v, z);
    let (mut part, back) = (Part::grid(2, 2, sheet(0.0)), Part::grid(2, 2, sheet(-thickness)));
    let first = part.positions.len() as u32;
    part.positions.extend(back.positions);
    part.faces.extend(back.faces.iter().map(|&[a, b, c]| [a, c, b].map(|v| v + first)));
    let front = raster(20.0, &evenly(0.0, d, 26));
    let below = DVec3::Z * thickness;
    let back = front.iter().map(|pass| pass.iter().map(|&(p, a)| (p - below, -a)).collect());
    let aside = DVec3::X * 80.0;
    let turn = vec![(aside, DVec3::Z), (aside, DVec3::X), (aside - below, -DVec3::Z)];
    let passes: Vec<Vec<_>> = front.iter().cloned().chain([turn]).chain(back).collect();
    let v = judged(&path(&passes), &part, &options(r, r));
    assert_close(v.figures.largest.unwrap().height, r - (r * r - 0.25 * d * d).sqrt(), 0.01);
    assert_eq!(v.figures.untouched.0, 0.0);
    assert_close(v.figures.area, 800.0, 1e-9);
}

#[test]
fn cusps_of_a_ball_on_an_incline_in_three_axes() {
    let (r, d, slope) = (4.0, 0.8, 35f64.to_radians());
    let (c, s) = (math::cos(slope), math::sin(slope));
    let tilt = |p: DVec3| DVec3::new(p.x, p.y * c, p.y * s);
    let normal = DVec3::new(0.0, -s, c);
    let part = Part::grid(2, 2, |u, v| tilt(DVec3::new(20.0 * u, 20.0 * v, 0.0)));
    let tip = |x, y| (tilt(DVec3::new(x, y, 0.0)) + normal * r - DVec3::Z * r, DVec3::Z);
    let passes: Vec<_> =
        (0..=25).map(|i| d * f64::from(i)).map(|y| vec![tip(-5.0, y), tip(25.0, y)]).collect();
    let v = judged(&path(&passes), &part, &options(r, r));
    assert_close(v.figures.largest.unwrap().height, r - (r * r - 0.25 * d * d).sqrt(), 0.01);
    assert_eq!(v.figures.by_slope[2].area, v.figures.area);
    // A flat end leaves stairs: right-angled, as high as the triangle over the side step.
    let tip = |x, y| (tilt(DVec3::new(x, y, 0.0)) - DVec3::Y * r, DVec3::Z);
    let passes: Vec<_> =
        (-1..=26).map(|i| d * f64::from(i)).map(|y| vec![tip(-5.0, y), tip(25.0, y)]).collect();
    let v = judged(&path(&passes), &part, &options(r, 0.0));
    assert_close(v.figures.largest.unwrap().height, d * s * c, 0.01);
}

/// Height over a circle of radius `c` at half an angle `phi` between cutters of radius `r`.
fn cusp_on_circle(c: f64, r: f64, phi: f64) -> f64 {
    let (x, y) = ((c + r) * math::sin(0.5 * phi), (c + r) * math::cos(0.5 * phi));
    y - (r * r - x * x).sqrt() - c
}

#[test]
fn cusps_of_a_ball_on_a_cylinder() {
    let (c, r, phi) = (20.0, 3.0, 0.03);
    let on = |a: f64, rho: f64, y: f64| DVec3::new(rho * math::sin(a), y, rho * math::cos(a));
    let part = Part::grid(800, 1, |u, v| on(u - 0.5, c, 10.0 * v));
    let pass = |a: f64| [-5.0, 15.0].map(|y| (on(a, c + r, y) - DVec3::Z * r, DVec3::Z)).to_vec();
    let passes: Vec<_> = (-18..=18).map(|i| pass(f64::from(i) * phi)).collect();
    let v = judged(&path(&passes), &part, &options(r, r));
    assert_close(v.figures.largest.unwrap().height, cusp_on_circle(c, r, phi), 0.01);
}

#[test]
fn cusps_of_a_ball_on_a_sphere() {
    let (c, r, phi) = (20.0, 3.0, 0.04);
    let on = |polar: f64, a: f64, rho: f64| {
        let s = rho * math::sin(polar);
        DVec3::new(s * math::cos(a), s * math::sin(a), rho * math::cos(polar))
    };
    // Around the pole, clear of the singular point.
    let part = Part::grid(100, 160, |u, v| on(0.1 + 0.24 * u, 0.4 * v, c));
    let circle = |polar: f64| -> Vec<_> {
        (-50..=150)
            .map(|i| {
                let p = on(polar, 0.01 * f64::from(i) - 0.3, c + r);
                (p - DVec3::Z * r, DVec3::Z)
            })
            .collect()
    };
    let passes: Vec<_> = (1..=10).map(|i| circle(f64::from(i) * phi)).collect();
    let v = judged(&path(&passes), &part, &options(r, r));
    assert_close(v.figures.largest.unwrap().height, cusp_on_circle(c, r, phi), 0.01);
    assert!(v.figures.gouge.is_none_or(|g| g.height > -2e-4));
}

/// Measured rates of windows in the middle of pass `pass` over a plane.
fn rates(v: &Verification, path: &Toolpath, pass: u32) -> Vec<f64> {
    let inside = |w: &&Window| {
        path.points[w.of as usize + 1].pass == pass && (4.0..16.0).contains(&w.place.x)
    };
    v.rate.windows.iter().filter(inside).map(|w| w.measured).collect()
}

#[test]
fn rate_of_straight_passes_of_a_flat_end() {
    let (r, d, depth) = (5.0, 1.5, 0.5);
    // Slightly askew, as paths are.
    let path = path(&raster(20.0, &evenly(0.0, d, 14)));
    let v = judged(&path, &Part::plane(20.0, 20.0), &options(r, 0.0));
    for pass in [3, 7] {
        let rates = rates(&v, &path, pass);
        assert!(rates.len() > 8);
        rates.iter().for_each(|&rate| assert_close(rate, d * depth * FEED, 0.02));
    }
    assert_close(v.rate.volume, 400.0 * depth, 1e-6);
}

#[test]
fn rate_of_a_ball_leaves_the_cusps() {
    let (r, d, depth) = (3.0, 1.2, 0.5);
    let path = path(&raster(20.0, &evenly(0.0, d, 18)));
    let v = judged(&path, &Part::plane(20.0, 20.0), &options(r, r));
    // Mean height under a circle through the cusps.
    let half: f64 = 0.5 * d;
    let angle = math::asin(half / r);
    let under = r * d - (half * (r * r - half * half).sqrt() + r * r * angle);
    for rate in rates(&v, &path, 8) {
        assert_close(rate, (d * depth - under) * FEED, 0.02);
    }
    // The first pass cuts a segment of the circle.
    let angle = math::acos_clamped(1.0 - depth / r);
    let segment = r * r * (angle - math::sin(angle) * math::cos(angle));
    let slot = crate::verify::tests::path(&raster(20.0, &[10.0]));
    let v = judged(&slot, &Part::plane(20.0, 20.0), &options(r, r));
    for rate in rates(&v, &slot, 0) {
        assert_close(rate, segment * FEED, 0.02);
    }
}

/// Whatever side walls come from on a steep place, what is not left was removed: every other pass, and those between
/// in the order of their places or against it, along the slope or up and down.
#[test]
fn all_that_a_flat_end_takes_of_a_slope_is_removed() {
    let (r, d, slope) = (3.0, 0.9, 50f64.to_radians());
    let (c, s) = (math::cos(slope), math::sin(slope));
    let tilt = |x: f64, y: f64| DVec3::new(x, y * c, y * s);
    let part = Part::grid(2, 2, |u, v| tilt(16.0 * u, 16.0 * v));
    let tip = |x, y| (tilt(x, y) - DVec3::Y * r, DVec3::Z);
    for along in [true, false] {
        let pass = |i: i32| {
            let at = d * f64::from(i);
            if along {
                vec![tip(-5.0, at), tip(21.0, at)]
            } else {
                vec![tip(at, 21.0), tip(at, -5.0), tip(at, 21.0)]
            }
        };
        let up = (-1..20).step_by(2);
        let between: Vec<i32> = (0..20).step_by(2).collect();
        for order in [between.clone(), between.into_iter().rev().collect()] {
            let passes: Vec<_> = up.clone().chain(order).map(pass).collect();
            let v = judged(&path(&passes), &part, &options(r, 0.0));
            // Above the upper edge the stock ends straight up, in a wedge that is a sector of the slope's angle; below a
            // pass just beyond that edge a triangle of it stays.
            let below = if along { (18.0 * d - 16.0) * s } else { 0.0 };
            let wedge = 16.0 * 0.5 * (slope * (0.5 * 0.5) - below * below * s / c);
            let volume = v.figures.area * (0.5 - v.figures.mean) + wedge;
            assert_close(v.rate.volume, volume, 1e-3);
        }
    }
}

#[test]
fn same_result_for_any_number_of_threads() {
    let path = path(&raster(20.0, &evenly(0.0, 0.9, 23)));
    let part = Part::plane(20.0, 20.0);
    let one = judged(&path, &part, &options(5.0, 1.0));
    for threads in [2, 5] {
        let many = judged(&path, &part, &VerifyOptions { threads, ..options(5.0, 1.0) });
        assert_eq!(
            (&one.figures, &one.rate, &one.samples),
            (&many.figures, &many.rate, &many.samples)
        );
    }
}

/// A ball of 5 mm over 20 x 20 mm in passes of 0.6 mm: cusps of 9 µm.
fn good() -> Vec<Vec<(DVec3, DVec3)>> {
    raster(20.0, &evenly(0.0, 0.6, 35))
}

fn strict() -> VerifyOptions {
    VerifyOptions {
        scallop: Some(0.0095),
        mrr_limit: Some(7.0),
        tolerance: 0.001,
        ..options(5.0, 5.0)
    }
}

fn planted(passes: &[Vec<(DVec3, DVec3)>]) -> Verification {
    judged(&path(passes), &Part::plane(20.0, 20.0), &strict())
}

/// Past the first passes, which cut a slot at the full feed.
fn broken(v: &Verification) -> Vec<Broken> {
    let others = |b: &&Broken| !matches!(b, Broken::RemovalRate { .. });
    v.figures.broken.iter().filter(others).copied().collect()
}

#[test]
fn a_good_path_breaks_nothing() {
    assert_eq!(broken(&planted(&good())), []);
}

#[test]
fn a_planted_gouge_is_found() {
    let mut passes = good();
    let deep = |x: f64, z: f64| (DVec3::new(x, passes[17][0].0.y, z), DVec3::Z);
    let (a, b) = (passes[17][0], passes[17][1]);
    passes[17] = vec![a, deep(12.0, 0.0), deep(12.3, -0.02), deep(12.6, 0.0), b];
    let v = planted(&passes);
    let [Broken::Gouge { worst, .. }] = broken(&v)[..] else { panic!("{:?}", v.figures.broken) };
    assert_close(worst.height, -0.02, 0.05);
    assert!(worst.place.distance(DVec3::new(12.3, 10.2, 0.0)) < 1.0);
    let of = worst.of.unwrap() as usize;
    assert_eq!(path(&passes).points[of + 1].pass, 17);
}

#[test]
fn a_missing_pass_and_a_doubled_step_are_found() {
    let mut passes = good();
    passes.remove(20);
    let v = planted(&passes);
    let [Broken::Scallop { worst, .. }] = broken(&v)[..] else { panic!("{:?}", v.figures.broken) };
    assert_close(worst.height, 5.0 - (25.0f64 - 0.36).sqrt(), 0.01);
    assert!((worst.place.y - 12.0).abs() < 0.1, "{}", worst.place);
    // Half of the passes left out from 9 mm to 15 mm.
    let ys = evenly(0.0, 0.6, 35).into_iter().enumerate();
    let ys: Vec<f64> =
        ys.filter(|(i, y)| i % 2 == 0 || !(9.0..15.0).contains(y)).map(|(_, y)| y).collect();
    let v = planted(&raster(20.0, &ys));
    assert_eq!(broken(&v).len(), 1);
    assert!(v.figures.spots.iter().all(|s| (8.9..15.1).contains(&s.place.y)));
    assert!(v.figures.spots.len() > 3);
}

#[test]
fn a_rapid_through_stock_and_a_lost_feed_are_found() {
    let passes = good();
    let mut path = path(&passes);
    // The way to pass 10, which starts beside the part, goes 0.2 mm above it from the middle.
    let first = path.points.iter().position(|p| p.pass == 10).unwrap();
    let low = DVec3::new(8.0, 13.0, 0.2);
    path.points[first].tip = low;
    path.points[first - 1].tip = low + DVec3::X * 3.0;
    path.points[first + 1].feed = 0.0;
    let v = judged(&path, &Part::plane(20.0, 20.0), &strict());
    let rapid = v.figures.rapids.iter().find(|f| path.points[f.of as usize + 1].pass == 10);
    let rapid = rapid.expect("the rapid is found");
    assert!(
        (rapid.place.y - 13.0).abs() < 1.0 && (7.0..12.0).contains(&rapid.place.x),
        "{}",
        rapid.place
    );
    assert_close(rapid.depth, 0.3, 0.01);
    assert_eq!(v.figures.without_feed.len(), 1);
    assert_eq!(v.figures.without_feed[0].of as usize, first);
    assert!(broken(&v).iter().any(|b| matches!(b, Broken::Rapid { .. })));
    assert!(broken(&v).iter().any(|b| matches!(b, Broken::NoFeed { .. })));
}

#[test]
fn a_spike_of_the_removal_rate_is_found() {
    // Passes after the first clear, with 1.2 mm more feed of 5 times in the middle of one.
    let mut passes = good();
    let y = passes[17][0].0.y;
    let at = |x: f64| (DVec3::new(x, y, 0.0), DVec3::Z);
    passes[17] = vec![at(-8.0), at(11.0), at(12.2), at(28.0)];
    let mut path = path(&passes);
    let fast = path.points.iter().position(|p| p.pass == 17 && p.tip.x == 12.2).unwrap();
    let saved = 0.8 * (path.points[fast].time - path.points[fast - 1].time);
    path.points[fast].feed *= 5.0;
    path.points[fast..].iter_mut().for_each(|p| p.time -= saved);
    let v = judged(&path, &Part::plane(20.0, 20.0), &strict());
    let later = v.rate.windows.iter().filter(|w| path.points[w.of as usize + 1].pass > 4);
    let worst = later.copied().reduce(|a, b| if b.measured > a.measured { b } else { a }).unwrap();
    assert!(worst.place.distance(DVec3::new(11.6, y, 0.0)) < 1.0, "{}", worst.place);
    assert!(worst.measured > 3.0 * 0.5 * 0.6 * FEED);
}

#[test]
fn what_the_plan_calls_inaccessible_is_judged_apart() {
    let mut passes = good();
    passes.remove(20);
    let inaccessible =
        (0..80).map(|i| Sphere { centre: DVec3::new(0.25 * f64::from(i), 12.0, 0.0), radius: 0.6 });
    let options = VerifyOptions { inaccessible: inaccessible.collect(), ..strict() };
    let v = judged(&path(&passes), &Part::plane(20.0, 20.0), &options);
    assert_eq!(broken(&v), []);
    assert_close(v.figures.inaccessible.largest, 5.0 - (25.0f64 - 0.36).sqrt(), 0.01);
    assert_close(v.figures.inaccessible.area, 20.0 * 1.2, 0.1);
}

#[test]
fn the_rest_of_the_part_is_guarded() {
    // A wall stands where the cutter runs out.
    let wall = Part::grid(4, 4, |u, v| DVec3::new(24.0, 20.0 * u, 10.0 * v - 1.0));
    let turned: Vec<[u32; 3]> = wall.faces.iter().map(|&[a, b, c]| [a, c, b]).collect();
    let rest = Facets { positions: &wall.positions, faces: &turned };
    let part = Part::plane(20.0, 20.0);
    let v = verify(&path(&good()), part.facets(), rest, &strict(), &mut |_| {}).unwrap();
    let gouge = v.figures.gouge.unwrap();
    assert!(gouge.height < -1.0 && (gouge.place.x - 24.0).abs() < 1e-6);
    assert_close(v.figures.area, 400.0, 1e-6);
}

/// Round a corner of the part that juts out, 2 micrometres deep: a line down from beside the edge goes far through the
/// cutter, where the other wall is near. A cutter beside it is found as deep as it is.
#[test]
fn at_an_edge_of_the_rest_cuts_are_no_deeper_than_to_its_other_side() {
    let (r, beside) = (5.0, 4e-6);
    // Walls along x and y from the corner at the origin, each with a narrow strip at the corner, and the floor around.
    let part = Part::grid(2, 2, |u, v| DVec3::new(20.0 * u, 20.0 * v, 0.0));
    let along = |u: f64| if u < 0.5 { 2.0 * u * beside } else { beside + (2.0 * u - 1.0) * 12.0 };
    let x = Part::grid(2, 1, |u, v| DVec3::new(-along(u), 0.0, 6.0 * v));
    let y = Part::grid(2, 1, |u, v| DVec3::new(0.0, -along(u), 6.0 * v));
    let positions: Vec<DVec3> = x.positions.iter().chain(&y.positions).copied().collect();
    let first = x.positions.len() as u32;
    // The former faces +y, the latter +x.
    let faces: Vec<[u32; 3]> = x
        .faces
        .iter()
        .copied()
        .chain(y.faces.iter().map(|f| f.map(|v| v + first)))
        .map(|[a, b, c]| {
            let [p, q, s] = [a, b, c].map(|v| positions[v as usize]);
            let faces_out = (q - p).cross(s - p).dot(DVec3::ONE) > 0.0;
            if faces_out { [a, b, c] } else { [a, c, b] }
        })
        .collect();
    let rest = Facets { positions: &positions, faces: &faces };
    for deep in [0.001, 0.0019] {
        let corner = |degrees: f64| {
            let (s, c) = (math::sin(degrees.to_radians()), math::cos(degrees.to_radians()));
            (DVec3::new(c, s, 0.0) * (r - deep), DVec3::Z)
        };
        let ends = [DVec3::new(r - deep, -10.0, 0.0), DVec3::new(-10.0, r - deep, 0.0)];
        let round: Vec<_> = core::iter::once((ends[0], DVec3::Z))
            .chain((0..=180).map(|k| corner(0.5 * f64::from(k))))
            .chain([(ends[1], DVec3::Z)])
            .collect();
        let v =
            verify(&path(&[round]), part.facets(), rest, &options(r, 0.0), &mut |_| {}).unwrap();
        let gouge = v.figures.gouge.unwrap();
        assert!(
            (-gouge.height - deep).abs() < 2e-4,
            "{} of {deep} at {}",
            gouge.height,
            gouge.place
        );
    }
}

#[test]
fn nothing_to_judge_is_said() {
    let part = Part::plane(1.0, 1.0);
    let none = Facets { positions: &[], faces: &[] };
    let good = path(&good());
    let error = |path: &Toolpath, facets, options: &VerifyOptions| {
        verify(path, facets, none, options, &mut |_| {}).unwrap_err()
    };
    assert_eq!(error(&good, none, &strict()), VerifyError::NoSurface);
    let empty = Toolpath::default();
    assert_eq!(error(&empty, part.facets(), &strict()), VerifyError::NoPath { points: 0 });
    let bad = VerifyOptions { spacing: f64::NAN, ..strict() };
    assert!(matches!(error(&good, part.facets(), &bad), VerifyError::NotPositive { .. }));
}

#[test]
fn a_step_that_grazes_the_surface_between_its_places_is_not_lost() {
    // Long chords that dip under the plane by less than the ball's rise over a quarter of a step,
    // as on a real path; before them, a coarse pass leaves a cusp over the same samples.
    let part = Part::plane(20.0, 4.0);
    let pass = |y: f64, z: f64| {
        vec![(DVec3::new(-8.0, y, z), DVec3::Z), (DVec3::new(28.0, y, z), DVec3::Z)]
    };
    let options = VerifyOptions { spacing: 0.05, ..options(5.0, 5.0) };
    let low = [1.6, 2.4].map(|y| pass(y, 0.0));
    let grazing = [pass(2.0, -2e-5)];
    let path = path(&[low.to_vec(), grazing.to_vec()].concat());
    let along = judged(&path, &part, &options).samples.into_iter();
    let worst = along
        .filter(|s| (s.position[1] - 2.0).abs() < 0.01)
        .map(|s| s.residual)
        .fold(f32::MIN, f32::max);
    assert!(worst < 1e-4, "{worst} mm left under the cutter");
}

/// A cutter along one side of a thin wall has nothing to do with its other side, unless it cuts through.
#[test]
fn beside_a_thin_wall_is_no_gouge_and_through_it_is_one() {
    let (r, thick) = (3.0, 0.2);
    let options = VerifyOptions { spacing: 0.3, tolerance: 0.005, ..options(r, 0.0) };
    let floor = Part::grid(2, 2, |u, v| DVec3::new(thick + 12.0 * u, 20.0 * v, 0.0));
    let side = |x: f64, up: f64| {
        let at = move |u: f64, v: f64| DVec3::new(x, 20.0 * (0.5 + up * (u - 0.5)), 8.0 * v);
        Part::grid(8, 8, at)
    };
    let top = Part::grid(1, 8, |u, v| DVec3::new(thick * u, 20.0 * v, 8.0));
    let mut wall = Part { positions: Vec::new(), faces: Vec::new() };
    for part in [side(thick, 1.0), side(0.0, -1.0), top] {
        let first = wall.positions.len() as u32;
        wall.positions.extend(part.positions);
        wall.faces.extend(part.faces.iter().map(|f| f.map(|v| v + first)));
    }
    for (depth, expected) in [(0.0, 0.0), (0.001, 0.001), (0.05, 0.05), (1.0, 0.1)] {
        let at = |y: f64| (DVec3::new(thick + r - depth, y, 0.0), DVec3::Z);
        let along = path(&[vec![at(-5.0), at(25.0)]]);
        let v = verify(&along, floor.facets(), wall.facets(), &options, &mut |_| {});
        let gouge = v.unwrap().figures.gouge.map_or(0.0, |g| -g.height);
        // Half of the wall is nearer to each of its sides.
        assert!((gouge - expected).abs() < 1e-3, "{depth}: {gouge}");
    }
}

/// Heights of the crests of a path, with at least half of the sides measured.
#[track_caller]
fn crests(v: &Verification) -> &[f64] {
    assert!(v.crests.measured_share() > 0.5, "{} of {}", v.crests.heights.len(), v.crests.sides);
    &v.crests.heights
}

#[test]
fn every_crest_of_even_passes_is_as_high() {
    let (r, d) = (5.0, 1.0);
    let v =
        judged(&path(&raster(20.0, &evenly(0.0, d, 21))), &Part::plane(20.0, 20.0), &options(r, r));
    let h = r - (r * r - 0.25 * d * d).sqrt();
    crests(&v).iter().for_each(|&found| assert_close(found, h, 0.005));
    let [within, above] = v.crests.shares(1.001 * h);
    assert_eq!([within, above], [1.0, 0.0]);
}

#[test]
fn half_of_the_crests_of_alternating_passes_are_lower() {
    let (r, d) = (5.0, 1.0);
    let ys: Vec<f64> = (0..24).map(|i| d * (0.9 * f64::from(i) + 0.1 * f64::from(i % 2))).collect();
    let v = judged(&path(&raster(20.0, &ys)), &Part::plane(20.0, 20.0), &options(r, r));
    let h = |d: f64| r - (r * r - 0.25 * d * d).sqrt();
    let [low, high] = [h(0.8 * d), h(d)];
    let count = |of: f64| crests(&v).iter().filter(|&f| (f / of - 1.0).abs() < 0.005).count();
    assert_eq!(count(low) + count(high), crests(&v).len());
    assert_close(count(low) as f64, 0.5 * crests(&v).len() as f64, 0.04);
    assert_close(v.crests.shares(1.001 * high)[0], 0.5, 0.04);
}

#[test]
fn crests_of_a_bull_on_a_plane() {
    // Flats of 2 mm radius overlap in part: what stands between them is cut by the rims.
    let (r, corner, d) = (3.0, 1.0, 4.6);
    let v = judged(
        &path(&raster(40.0, &evenly(0.0, d, 10))),
        &Part::plane(40.0, 41.0),
        &options(r, corner),
    );
    let half = 0.5 * d - (r - corner);
    let h = corner - (corner * corner - half * half).sqrt();
    crests(&v).iter().for_each(|&found| assert_close(found, h, 0.02));
}

/// Under a tilted bottom a line is the lowest where the rim begins to round, within a step.
#[test]
fn crests_of_a_tilted_bull_are_its_silhouettes() {
    let (r, corner, lead, h) = (5.0, 1.0, 0.09, 0.02);
    let options = options(r, corner);
    let strip = Footprint::new(options.tool, lead).width(h, 0.0, 0.0);
    let axis = DVec3::new(math::sin(lead), 0.0, math::cos(lead));
    let bottom = axis * corner + DVec3::X.reject_from(axis).normalize() * (r - corner);
    let tip = |x: f64, y: f64| (DVec3::new(x, y, corner) - bottom, axis);
    let pass = |y: f64| (-14..=65).map(|i| tip(0.731 * f64::from(i), y)).collect();
    let passes: Vec<Vec<_>> = (0..=12).map(|i| pass(strip * f64::from(i))).collect();
    let v = judged(&path(&passes), &Part::plane(30.0, 12.0 * strip), &options);
    assert_close(v.figures.largest.unwrap().height, h, 0.01);
}

#[test]
fn crests_along_and_across_a_cylinder() {
    let (c, r, phi) = (20.0, 3.0, 0.03);
    let on = |a: f64, rho: f64, y: f64| DVec3::new(rho * math::sin(a), y, rho * math::cos(a));
    let part = Part::grid(800, 1, |u, v| on(u - 0.5, c, 10.0 * v));
    let tip = |a: f64, y: f64| (on(a, c + r, y) - DVec3::Z * r, DVec3::Z);
    let along: Vec<_> =
        (-18..=18).map(|i| [-5.0, 15.0].map(|y| tip(f64::from(i) * phi, y)).to_vec()).collect();
    let v = judged(&path(&along), &part, &options(r, r));
    let h = cusp_on_circle(c, r, phi);
    crests(&v).iter().for_each(|&found| assert_close(found, h, 0.01));
    let d = 0.6;
    let arc = |y: f64| (-300..=300).map(|i| tip(0.002 * f64::from(i), y)).collect();
    let across: Vec<_> = (-1..=18).map(|i| arc(d * f64::from(i))).collect();
    let v = judged(&path(&across), &part, &options(r, r));
    let h = r - (r * r - 0.25 * d * d).sqrt();
    crests(&v).iter().for_each(|&found| assert_close(found, h, 0.01));
}

#[test]
fn crests_of_rings_on_a_sphere() {
    let (c, r, phi) = (20.0, 3.0, 0.04);
    let on = |polar: f64, a: f64, rho: f64| {
        let s = rho * math::sin(polar);
        DVec3::new(s * math::cos(a), s * math::sin(a), rho * math::cos(polar))
    };
    let part = Part::grid(200, 400, |u, v| on(0.1 + 0.3 * u, 0.8 * v, c));
    let circle = |polar: f64| -> Vec<_> {
        (-50..=200)
            .map(|i| {
                let p = on(polar, 0.005 * f64::from(i), c + r);
                (p - DVec3::Z * r, DVec3::Z)
            })
            .collect()
    };
    let passes: Vec<_> = (1..=11).map(|i| circle(f64::from(i) * phi)).collect();
    let v = judged(&path(&passes), &part, &options(r, r));
    let h = cusp_on_circle(c, r, phi);
    crests(&v).iter().for_each(|&found| assert_close(found, h, 0.02));
}

#[test]
fn a_single_pass_has_no_crest() {
    let v = judged(&path(&raster(20.0, &[10.0])), &Part::plane(20.0, 20.0), &options(5.0, 5.0));
    assert_eq!(v.crests.heights, [] as [f64; 0]);
    assert!(v.crests.sides > 0 && v.crests.percentile(0.5).is_none());
}

#[test]
fn too_many_samples_are_put_farther_apart() {
    let path = path(&raster(20.0, &[10.0]));
    let asked = |spacing| VerifyOptions { spacing, ..options(5.0, 5.0) };
    assert_eq!(checked(&path, 400.0, 0.0, &asked(0.02)).unwrap(), 0.02);
    let spacing = checked(&path, 300.0, 100.0, &asked(0.001)).unwrap();
    assert_close(spacing, 0.01, 1e-9);
}

/// Between walls as high as they are by default.
fn walled(path: &Toolpath, part: &Part, options: &VerifyOptions) -> Verification {
    let height = 2.0 * options.tool.radius();
    let walls = options.walls.or(Some(Walls { height, rise: Rise::Up }));
    judged(path, part, &VerifyOptions { walls, ..options.clone() })
}

/// A pass along x over a plane 40 mm long and 30 mm wide, whose sides the cutter does not reach, with its axis at `y`.
fn beside_wall(y: f64, axis: DVec3) -> Toolpath {
    let at = |x| (DVec3::new(x, y, 0.0), axis);
    path(&[vec![at(12.0), at(28.0)]])
}

fn deepest(v: &Verification) -> f64 {
    v.figures.walls.unwrap().deepest.map_or(0.0, |d| d.height)
}

/// The depth and the place of the wall that is reported as broken.
fn broken_wall(v: &Verification) -> Option<Spot> {
    let wall = |b: &Broken| match b {
        Broken::Wall { worst, .. } => Some(*worst),
        _ => None,
    };
    v.figures.broken.iter().find_map(wall)
}

#[track_caller]
fn assert_near(found: f64, expected: f64, within: f64) {
    assert!((found - expected).abs() <= within, "{found}, expected {expected}");
}

#[test]
fn cuts_into_a_wall_are_as_deep_as_the_cutter_stands_over_it() {
    let (r, part) = (5.0, Part::plane(40.0, 30.0));
    for corner in [0.0, 1.5, 5.0] {
        for depth in [0.01, 0.4, 2.83, 5.0, 7.0, 9.5] {
            let path = beside_wall(r - depth, DVec3::Z);
            let v = walled(&path, &part, &options(r, corner));
            assert_near(deepest(&v), depth, 1.5e-3);
            let wall = broken_wall(&v).unwrap();
            assert!(wall.place.y == 0.0 && (0.0..=10.0).contains(&wall.place.z), "{}", wall.place);
            assert_eq!(path.points[wall.of.unwrap() as usize + 1].kind, MoveKind::Cut);
            assert!(!v.figures.walls.unwrap().is_deeper);
        }
    }
    // A flat end along 16 mm of a wall, over all of its height.
    let (depth, v) = (0.4, walled(&beside_wall(4.6, DVec3::Z), &part, &options(r, 0.0)));
    let half: f64 = r - depth;
    let length = 16.0 + 2.0 * (r * r - half * half).sqrt();
    assert_close(v.figures.walls.unwrap().cut, 10.0 * length, 0.02);
    assert_close(v.figures.walls.unwrap().area, 10.0 * 140.0, 1e-9);
}

/// However high a wall is, it is looked at as closely where the cutter goes.
#[test]
fn a_high_wall_is_cut_as_deep_as_a_low_one() {
    let (r, part) = (5.0, Part::plane(40.0, 30.0));
    let path = beside_wall(r - 0.02, DVec3::Z);
    for rise in [Rise::Up, Rise::Normal] {
        let walls = Some(Walls { height: 1e6, rise });
        let v = walled(&path, &part, &VerifyOptions { walls, length: 30.0, ..options(r, 0.0) });
        assert_near(deepest(&v), 0.02, 1.5e-3);
        assert!(v.figures.walls.unwrap().area < 100.0 * 140.0);
    }
}

#[test]
fn walls_change_no_other_figure() {
    let (path, part) = (beside_wall(2.0, DVec3::Z), Part::plane(40.0, 30.0));
    let [open, between] = [judged, walled].map(|judge| judge(&path, &part, &options(5.0, 1.0)));
    assert_eq!((&open.samples, &open.rate), (&between.samples, &between.rate));
    let (walls, mut broken) = (None, between.figures.broken.clone());
    broken.retain(|b| !matches!(b, Broken::Wall { .. }));
    assert_eq!(open.figures, Figures { walls, broken, ..between.figures });
    assert_eq!(open.figures.walls, None);
}

#[test]
fn a_cutter_that_touches_a_wall_does_not_cut_it() {
    let (r, part) = (5.0, Part::plane(40.0, 30.0));
    let round = [(r, r), (35.0, r), (35.0, 25.0), (r, 25.0), (r, r)];
    let round = round.map(|(x, y)| (DVec3::new(x, y, 0.0), DVec3::Z)).to_vec();
    for corner in [0.0, 1.5, 5.0] {
        let v = walled(&path(std::slice::from_ref(&round)), &part, &options(r, corner));
        assert!(deepest(&v) <= 1e-3, "{}", deepest(&v));
        assert_eq!(broken_wall(&v), None);
    }
}

/// Between two circles: the outer wall is round towards the cutter, the inner one is a pin of 3 mm diameter.
#[test]
fn round_walls_are_cut_as_deep_as_the_path_is_off() {
    let (inner, outer, r, turns) = (1.5, 12.0, 3.0, 360);
    let on = |rho: f64, a: f64| DVec3::new(rho * math::cos(a), rho * math::sin(a), 0.0);
    let turn = |i: usize| core::f64::consts::TAU * (i % turns) as f64 / turns as f64;
    let part = Part::grid(turns, 1, |u, v| {
        on(outer + (inner - outer) * v, turn((u * turns as f64).round() as usize))
    });
    let circle = |rho: f64| path(&[(0..=turns).map(|i| (on(rho, turn(i)), DVec3::Z)).collect()]);
    for corner in [0.0, 3.0] {
        for (at, depth) in [(outer - r, 0.0), (outer - r + 0.6, 0.6), (inner + r, 0.0)] {
            let v = walled(&circle(at), &part, &options(r, corner));
            assert_near(deepest(&v), depth, 2e-3);
        }
        // What is left of a pin is as deep as it is thick.
        let v = walled(&circle(inner + r - 0.6), &part, &options(r, corner));
        assert_near(deepest(&v), 0.6, 2e-3);
    }
}

#[test]
fn a_leaning_cutter_cuts_a_wall_with_its_rim_or_its_shank() {
    let (r, part, lean) = (5.0, Part::plane(40.0, 30.0), 10f64.to_radians());
    let (s, c) = (math::sin(lean), math::cos(lean));
    let walls = Some(Walls { height: 8.0, rise: Rise::Normal });
    let options = VerifyOptions { walls, ..options(r, 0.0) };
    let lifted = |mut path: Toolpath| {
        path.points.iter_mut().for_each(|p| p.tip.z += r * s);
        path
    };
    // Away from the wall: the rim on its side is `2 R sin` up.
    let v = walled(&lifted(beside_wall(4.0, DVec3::new(0.0, s, c))), &part, &options);
    assert_near(deepest(&v), r * c - 4.0, 5e-3);
    assert_near(broken_wall(&v).unwrap().place.z, 2.0 * r * s, 0.1);
    // Over the wall: the shank leans farther the higher it is.
    let v = walled(&lifted(beside_wall(6.0, DVec3::new(0.0, -s, c))), &part, &options);
    assert_near(deepest(&v), r * c + 8.0 * s / c - 6.0, 2e-2);
    assert_near(broken_wall(&v).unwrap().place.z, 8.0, 0.1);
}

/// Over a sphere the walls along its normals are a cone around its middle.
#[test]
fn walls_along_normals_stand_square_to_the_surface() {
    let (c, r, edge) = (20.0, 3.0, 0.5);
    let on = |polar: f64, a: f64, rho: f64| {
        let s = rho * math::sin(polar);
        DVec3::new(s * math::cos(a), s * math::sin(a), rho * math::cos(polar))
    };
    let part = Part::grid(400, 150, |u, v| on(0.05 + (edge - 0.05) * u, 2.0 * v, c));
    for depth in [0.0, 0.3, 2.0] {
        let polar = edge - math::asin((r - depth) / (c + r));
        let at = |i: usize| {
            let a = 0.8 + 0.004 * i as f64;
            (on(polar, a, c), on(polar, a, 1.0))
        };
        let walls = Some(Walls { height: 6.0, rise: Rise::Normal });
        let options = VerifyOptions { walls, ..options(r, r) };
        let v = walled(&path(&[(0..=100).map(at).collect()]), &part, &options);
        // The normals at the edge are those of facets half a cell within.
        assert_near(deepest(&v), depth, 3e-3);
    }
}

#[test]
fn a_cutter_behind_a_wall_and_one_that_passes_through_it_are_found() {
    let (r, part) = (5.0, Part::plane(40.0, 30.0));
    for corner in [0.0, 1.5, 5.0] {
        // With its middle behind the wall; with all of it, come down from above; out of sight.
        for (y, depth) in [(-4.0, 9.0), (-7.5, 10.0), (-21.0, 0.0)] {
            let v = walled(&beside_wall(y, DVec3::Z), &part, &options(r, corner));
            assert_near(deepest(&v), depth, 2e-3);
            assert_eq!(v.figures.walls.unwrap().is_deeper, depth == 10.0);
        }
        let at = |y| (DVec3::new(20.0, y, 0.0), DVec3::Z);
        for (from, to) in [(15.0, -60.0), (-60.0, 15.0)] {
            let v = walled(&path(&[vec![at(from), at(to)]]), &part, &options(r, corner));
            assert_near(deepest(&v), 10.0, 1e-6);
        }
    }
    // Over the wall is nothing.
    let mut above = beside_wall(0.0, DVec3::Z);
    above.points.iter_mut().for_each(|p| p.tip.z = p.tip.z.max(10.001));
    let v = walled(&above, &part, &options(r, r));
    assert_eq!(v.figures.walls.unwrap().deepest, None);
}

#[test]
fn a_rapid_through_a_wall_is_found() {
    let (r, part) = (5.0, Part::plane(40.0, 30.0));
    let mut path = beside_wall(15.0, DVec3::Z);
    path.points[0].tip = DVec3::new(20.0, 2.0, 6.0);
    let mut second = path.points[0];
    second.tip.x = 21.0;
    path.points.insert(1, second);
    let v = walled(&path, &part, &options(r, 0.0));
    let wall = broken_wall(&v).unwrap();
    assert_near(wall.height, 3.0, 2e-3);
    assert_eq!(wall.of, Some(0));
    assert_near(v.figures.rapids[0].depth, 3.0, 2e-3);
}

/// Along a wall that ends at a corner which juts out: the lines of the other wall lie along the cut.
#[test]
fn at_a_corner_that_juts_out_cuts_are_no_deeper_than_along_its_walls() {
    let points =
        [(0.0, 0.0), (30.0, 0.0), (30.0, 30.0), (-30.0, 30.0), (-30.0, -30.0), (0.0, -30.0)];
    let part = Part {
        positions: points.map(|(x, y)| DVec3::new(x, y, 0.0)).to_vec(),
        faces: vec![[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 5]],
    };
    let r = 5.0;
    let at = |x, y| (DVec3::new(x, y, 0.0), DVec3::Z);
    for depth in [0.0, 0.02, 0.3, 2.0] {
        let y = r - depth;
        let along = vec![at(20.0, y), at(-15.0, y), at(-15.0, -20.0)];
        let v = walled(&path(&[along]), &part, &options(r, 0.0));
        assert_near(deepest(&v), depth, 1.5e-3);
    }
}

/// A ball that rolls over a ridge as sharp as a knife touches it all the time. The lines inward from the ridge soon
/// leave the part, and what the ball does beyond is no gouge, unless it is in the ridge by more than the tolerance.
#[test]
fn a_ball_that_touches_a_sharp_ridge_does_not_cut_it() {
    let (r, flank) = (5.0, 80.0_f64.to_radians());
    let slope = math::tan(flank);
    let ridge = Part::grid(2, 2, |u, v| {
        let y = 2.0 * v - 1.0;
        DVec3::new(30.0 * u, 0.4 * y, -0.4 * slope * y.abs())
    });
    for depth in [0.0, 0.0015, 0.05] {
        let pass = |i: i32| {
            let lean = flank * f64::from(i) / 40.0;
            let way = (r - depth) * DVec3::new(0.0, math::sin(lean), math::cos(lean));
            let tip = |x: f64| (way + DVec3::new(x, 0.0, -r), DVec3::Z);
            vec![tip(-8.0), tip(38.0)]
        };
        let passes: Vec<_> = (-40..=40).map(pass).collect();
        let v = judged(&path(&passes), &ridge, &options(r, r));
        let gouge = v.figures.gouge.map_or(0.0, |g| -g.height);
        if depth <= 0.002 {
            assert_near(gouge, depth, 1e-4);
        } else {
            assert!(gouge >= depth, "{gouge}");
        }
    }
}

#[test]
fn a_face_of_the_part_is_guarded_in_place_of_a_wall() {
    let (r, part) = (5.0, Part::plane(40.0, 30.0));
    let face = Part::grid(2, 1, |u, v| DVec3::new(40.0 * u, 0.0, 12.0 * v));
    let turned: Vec<[u32; 3]> = face.faces.iter().map(|&[a, b, c]| [a, c, b]).collect();
    let rest = Facets { positions: &face.positions, faces: &turned };
    let walls = Some(Walls { height: 10.0, rise: Rise::Up });
    let options = VerifyOptions { walls, ..options(r, 0.0) };
    let path = beside_wall(r - 0.7, DVec3::Z);
    let v = verify(&path, part.facets(), rest, &options, &mut |_| {}).unwrap();
    assert_eq!(deepest(&v), 0.0);
    assert_close(v.figures.walls.unwrap().area, 10.0 * 100.0, 1e-9);
    assert_near(v.figures.gouge.unwrap().height, -0.7, 1e-3);
    // Not if it falls away.
    let down: Vec<DVec3> = face.positions.iter().map(|&p| DVec3::new(p.x, p.y, -p.z)).collect();
    let rest = Facets { positions: &down, faces: &face.faces };
    let v = verify(&path, part.facets(), rest, &options, &mut |_| {}).unwrap();
    assert_near(deepest(&v), 0.7, 1e-3);
}

#[test]
fn walls_are_judged_alike_by_any_number_of_threads() {
    let (path, part) = (beside_wall(3.3, DVec3::Z), Part::plane(40.0, 30.0));
    let one = walled(&path, &part, &options(5.0, 1.0));
    let many = walled(&path, &part, &VerifyOptions { threads: 3, ..options(5.0, 1.0) });
    assert_eq!(one.figures, many.figures);
}

#[test]
fn the_rest_for_a_smaller_cutter_is_what_stands_above_the_limit() {
    let mut passes = good();
    passes.remove(20);
    let inaccessible =
        (0..80).map(|i| Sphere { centre: DVec3::new(0.25 * f64::from(i), 12.0, 0.0), radius: 0.9 });
    let options = VerifyOptions { inaccessible: inaccessible.collect(), ..strict() };
    let v = judged(&path(&passes), &Part::plane(20.0, 20.0), &options);
    // A circle of 5 mm over a gap of 1.2 mm stands 9.5 µm high and more on this width in the middle.
    let height = 0.0095f64;
    let width = 1.2 - 2.0 * (10.0 * height - height * height).sqrt();
    assert_close(v.figures.inaccessible.above, 20.0 * width, 0.02);
    assert!(v.figures.inaccessible.area > 30.0);
}

/// Height of the cusp that a ball of 5 mm leaves on a plane.
fn cusp_on_plane(d: f64) -> f64 {
    5.0 - (25.0 - 0.25 * d * d).sqrt()
}

fn within(limit: f64) -> VerifyOptions {
    VerifyOptions { scallop: Some(limit), tolerance: 1e-4, spacing: 0.16, ..options(5.0, 5.0) }
}

#[test]
fn a_crest_between_samples_is_told_to_a_tenth_of_a_micrometre() {
    // Between two passes, and lying askew to the samples.
    let (d, turn) = (1.2, 0.3f64);
    let (c, s) = (math::cos(turn), math::sin(turn));
    let turned = |x: f64, y: f64| DVec3::new(c * x - s * y, s * x + c * y, 0.0);
    let part = Part::grid(2, 2, |u, v| turned(20.0 * u, d * (v - 0.5)));
    let pass = |y: f64| [-8.0, 28.0].map(|x| (turned(x, y), DVec3::Z)).to_vec();
    let path = path(&[pass(-0.5 * d), pass(0.5 * d)]);
    let h = cusp_on_plane(d);
    for (limit, breaks) in [(h - 5e-4, true), (h + 1e-4, false)] {
        let v = judged(&path, &part, &within(limit));
        let found = v.figures.largest.unwrap().height;
        assert!((found - h).abs() < 1e-4, "{found}, expected {h}");
        assert_eq!(!v.figures.broken.is_empty(), breaks, "{:?}", v.figures.broken);
        assert!(v.figures.sampling_bound < 3e-4, "{}", v.figures.sampling_bound);
    }
    // Far from the limit nothing is searched for.
    let v = judged(&path, &part, &within(2.0 * h));
    assert!(v.figures.sampling_bound > 1e-3 && v.figures.broken.is_empty());
}

#[test]
fn a_cusp_on_the_rim_is_found() {
    let part = Part::plane(20.0, 20.0);
    let v = judged(&path(&raster(20.0, &evenly(0.3, 1.0, 20))), &part, &within(0.045));
    let h = cusp_on_plane(1.4);
    assert_close(v.figures.largest.unwrap().height, h, 1e-5);
    let [Broken::Scallop { worst, .. }] = broken(&v)[..] else { panic!("{:?}", v.figures.broken) };
    assert_eq!(worst.place.y, 20.0);
    assert!(v.samples.iter().all(|s| s.area > 0.0 && f64::from(s.residual) < h - 1e-4));
    assert_close(v.figures.area, 400.0, 1e-9);
}

/// Passes along both sides leave pyramids; one stands alone.
#[test]
fn a_single_narrow_peak_is_found() {
    let (d, wide) = (1.2, 1.3);
    let ys: Vec<f64> =
        (0..18).map(|i| d * f64::from(i) + if i > 8 { wide - d } else { 0.0 }).collect();
    let along = raster(20.0, &ys);
    let across = along
        .iter()
        .map(|pass| pass.iter().map(|&(p, a)| (DVec3::new(p.y, p.x, p.z), a)).collect());
    let path = path(&along.iter().cloned().chain(across).collect::<Vec<_>>());
    let part = Part::plane(20.0, 20.0);
    let one = judged(&path, &part, &within(cusp_on_plane(1.29)));
    let [Broken::Scallop { worst, .. }] = broken(&one)[..] else {
        panic!("{:?}", one.figures.broken)
    };
    assert!((worst.height - cusp_on_plane(wide)).abs() < 1e-4, "{}", worst.height);
    let peak = 8.0 * d + 0.5 * wide;
    assert!(worst.place.distance(DVec3::new(peak, peak, 0.0)) < 0.003, "{}", worst.place);
    let many = judged(&path, &part, &VerifyOptions { threads: 3, ..within(cusp_on_plane(1.29)) });
    assert_eq!(one.figures, many.figures);
}

#[test]
fn a_gouge_between_samples_is_told() {
    let mut passes = good();
    let (a, b) = (passes[17][0], passes[17][1]);
    let at = |x: f64, z: f64| (DVec3::new(x, a.0.y, z), DVec3::Z);
    passes[17] = vec![a, at(11.5, 0.0), at(12.04, -0.0105), at(12.6, 0.0), b];
    let asked = VerifyOptions { spacing: 0.29, tolerance: 0.005, ..strict() };
    let v = judged(&path(&passes), &Part::plane(20.0, 20.0), &asked);
    assert!((v.figures.gouge.unwrap().height + 0.0105).abs() < 2e-5, "{:?}", v.figures.gouge);
    assert!(broken(&v).iter().any(|b| matches!(b, Broken::Gouge { .. })));
}

/// The edge of a flat end goes along the rim; what is beyond by less than a thousandth of its radius is not asked for.
/// What is beyond by more is untouched, though it stands for no area, and though the stock may be lower than the limit
/// on the scallop.
#[test]
fn a_rim_that_is_just_reached_is_not_untouched() {
    let pass = |y: f64| [-8.0, 28.0].map(|x| (DVec3::new(x, y, 0.0), DVec3::Z)).to_vec();
    let is_untouched = |by: f64| {
        let path = path(&[5.0 + by, 11.0, 15.0].map(pass));
        // The tolerance of the path excuses nothing: it may go beyond the rim.
        let options = VerifyOptions { scallop: Some(0.6), tolerance: 0.02, ..options(5.0, 0.0) };
        let v = judged(&path, &Part::plane(20.0, 20.0), &options);
        let (area, place) = v.figures.untouched;
        assert_eq!(area, 0.0);
        let is_broken = |b: &Broken| matches!(b, Broken::Untouched { .. });
        assert_eq!(broken(&v).iter().any(is_broken), place.is_some());
        place.is_some()
    };
    assert_eq!([0.0, 2e-3, 6e-3, 1.9e-2].map(is_untouched), [false, false, true, true]);
}

#[test]
fn nothing_need_be_reached_nearer_to_a_wall_than_the_tolerance() {
    let pass = |y: f64| [5.2, 14.8].map(|x| (DVec3::new(x, y, 0.0), DVec3::Z)).to_vec();
    let round = [(5.2, 5.2), (14.8, 5.2), (14.8, 14.8), (5.2, 14.8), (5.2, 5.2)];
    let round = round.map(|(x, y)| (DVec3::new(x, y, 0.0), DVec3::Z)).to_vec();
    let path = path(&[round, pass(8.0), pass(12.0)]);
    let corners = [(0.0, 0.0), (20.0, 0.0), (20.0, 20.0), (0.0, 20.0)];
    let untouched = |tolerance: f64, walls: Option<Walls>| {
        let corner = |&(x, y): &(f64, f64)| Sphere { centre: DVec3::new(x, y, 0.0), radius: 5.5 };
        let inaccessible = corners.iter().map(corner).collect();
        let options = VerifyOptions { inaccessible, tolerance, walls, ..options(5.0, 0.0) };
        judged(&path, &Part::plane(20.0, 20.0), &options).figures.untouched.0
    };
    let walls = Some(Walls { height: 3.0, rise: Rise::Up });
    assert_eq!(untouched(0.21, walls), 0.0);
    assert!(untouched(0.05, walls) > 3.0 && untouched(0.21, None) > 6.0);
}

/// A cutter with a holder of that radius, mm, that begins so high above its tip.
fn above(stickout: f64, holder: f64, clearance: f64) -> Option<AboveCutter> {
    let tool = Tool::new(5.0, 5.0).unwrap();
    let section =
        |part, heights, radius| crate::tool::Section { part, heights, radii: [radius; 2] };
    let sections = vec![
        section(AssemblyPart::Shank, [15.0, stickout], 5.0),
        section(AssemblyPart::Holder, [stickout, stickout + 40.0], holder),
    ];
    Some(AboveCutter { assembly: Assembly { tool, cutter_length: 15.0, sections }, clearance })
}

/// Passes over a floor, the last one 15 mm from a wall of 60 mm.
fn beside_a_wall(stickout: f64, clearance: f64) -> Verification {
    let floor = Part::plane(40.0, 20.0);
    let wall = Part::grid(2, 2, |u, v| DVec3::new(40.0 * u, 20.0, 60.0 * v));
    let options = VerifyOptions {
        above: above(stickout, 12.0, clearance),
        spacing: 0.5,
        ..options(5.0, 5.0)
    };
    let path = path(&raster(40.0, &evenly(-5.0, 1.0, 11)));
    verify(&path, floor.facets(), wall.facets(), &options, &mut |_| {}).unwrap()
}

#[test]
fn a_holder_stays_as_far_from_a_wall_as_it_is() {
    // 15 mm from the axis to the wall, a holder of 12 mm, beside the wall from 30 mm up.
    let v = beside_a_wall(30.0, 1.0);
    let [holder] = &v.above.as_ref().unwrap().nearest[..] else { panic!("{:?}", v.above) };
    assert_eq!(holder.part, AssemblyPart::Holder);
    assert!((2.97..=3.0).contains(&holder.distance) && !holder.is_farther, "{holder:?}");
    assert!((holder.place.y - 20.0).abs() < 1e-9 && holder.place.z > 29.9, "{holder:?}");
    assert_eq!(v.above.as_ref().unwrap().farther_out, None);
    assert!(!v.figures.broken.iter().any(|b| matches!(b, Broken::TooNear { .. })));
    // 4 mm are kept once the holder begins `sqrt(4² - 3²)` above the wall: 62.65 mm, 33 whole mm farther out.
    let v = beside_a_wall(30.0, 4.0);
    let near = v.figures.broken.iter().find_map(|b| match b {
        Broken::TooNear { nearest, farther_out } => Some((*nearest, *farther_out)),
        _ => None,
    });
    let (nearest, farther_out) = near.expect("the holder is too near");
    assert!((nearest.wanted, farther_out) == (4.0, Some(33.0)), "{nearest:?}, {farther_out:?}");
    let v = beside_a_wall(63.0, 4.0);
    assert!(!v.figures.broken.iter().any(|b| matches!(b, Broken::TooNear { .. })), "{:?}", v.above);
    // Upright, a shank as wide as the cutter goes where that went.
    assert!(v.above.unwrap().nearest.iter().all(|n| n.part == AssemblyPart::Holder));
}

/// Stock counts as part: a holder that begins 6 mm above a floor with 0.5 mm of stock on it is 5.5 mm clear.
#[test]
fn a_holder_stays_clear_of_stock() {
    let tool = Tool::new(5.0, 5.0).unwrap();
    let (part, heights, radii) = (AssemblyPart::Holder, [6.0, 40.0], [20.0; 2]);
    let sections = vec![crate::tool::Section { part, heights, radii }];
    let judged = |clearance: f64| {
        let assembly = Assembly { tool, cutter_length: 6.0, sections: sections.clone() };
        let above = Some(AboveCutter { assembly, clearance });
        let options = VerifyOptions { above, spacing: 0.5, ..options(5.0, 5.0) };
        let path = path(&raster(40.0, &evenly(-5.0, 1.0, 11)));
        judged(&path, &Part::plane(40.0, 20.0), &options)
    };
    let v = judged(1.0);
    let [holder] = &v.above.as_ref().unwrap().nearest[..] else { panic!("{:?}", v.above) };
    assert!((5.47..=5.5).contains(&holder.distance) && !holder.is_farther, "{holder:?}");
    let is_broken =
        |v: &Verification| v.figures.broken.iter().any(|b| matches!(b, Broken::TooNear { .. }));
    // 5.8 mm would be there without the stock.
    assert!(!is_broken(&v) && is_broken(&judged(5.8)));
}

/// A shank no wider than the cutter must not cut in where the axis leans toward a wall.
#[test]
fn a_leaning_shank_is_measured() {
    let floor = Part::plane(40.0, 20.0);
    let wall = Part::grid(2, 2, |u, v| DVec3::new(40.0 * u, 20.0, 60.0 * v));
    let judged = |lean: f64| {
        let axis = DVec3::new(0.0, math::sin(lean), math::cos(lean));
        let pass = vec![(DVec3::new(0.0, 5.0, 0.0), DVec3::Z), (DVec3::new(40.0, 5.0, 0.0), axis)];
        let options = VerifyOptions {
            above: above(60.0, 5.0, 0.5),
            spacing: 0.5,
            length: 15.0,
            ..options(5.0, 5.0)
        };
        let v = verify(&path(&[pass]), floor.facets(), wall.facets(), &options, &mut |_| {});
        v.unwrap()
            .above
            .unwrap()
            .nearest
            .into_iter()
            .find(|n| n.part == AssemblyPart::Shank)
            .unwrap()
    };
    // At the height of 60 mm the axis leans by `60 tan`, and the shank reaches 5 mm across it.
    for (lean, is_clear) in [(0.05_f64, true), (0.3, false)] {
        let shank = judged(lean);
        assert_eq!(shank.distance > 0.0, is_clear, "{lean}: {shank:?}");
    }
}

/// A box.
fn block(low: [f64; 3], high: [f64; 3]) -> Part {
    let corner = |i: usize| DVec3::from_array([0, 1, 2].map(|k| [low, high][i >> k & 1][k]));
    let sides =
        [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let halves = |s: [u32; 4]| [[s[0], s[1], s[2]], [s[0], s[2], s[3]]];
    Part {
        positions: (0..8).map(corner).collect(),
        faces: sides.into_iter().flat_map(halves).collect(),
    }
}

/// Passes over a floor from `y = 0` to 10, with a box to be avoided by that distance, mm.
fn beside(clamp: Part, distance: f64, above: Option<AboveCutter>) -> Verification {
    avoiding(&path(&raster(40.0, &evenly(0.0, 1.0, 11))), clamp, distance, above)
}

fn avoiding(
    path: &Toolpath,
    clamp: Part,
    distance: f64,
    above: Option<AboveCutter>,
) -> Verification {
    let Part { positions, faces } = clamp;
    let clamp = Avoided { name: "clamp".into(), distance, positions, faces };
    let options = VerifyOptions { above, spacing: 0.5, avoided: vec![clamp], ..options(5.0, 5.0) };
    judged(path, &Part::plane(40.0, 20.0), &options)
}

/// What of the tool is too near to what it must avoid, and whether on a rapid.
fn too_near(v: &Verification) -> Vec<(AssemblyPart, f64, bool)> {
    let found = v.figures.broken.iter().filter_map(|b| match *b {
        Broken::Avoided { index: 0, nearest, on_rapid, .. } => {
            Some((nearest.part, nearest.distance, on_rapid))
        }
        _ => None,
    });
    found.collect()
}

#[test]
fn a_cutter_is_as_far_from_a_clamp_as_its_side_is() {
    // The last pass runs 12 mm from the clamp, the cutter's side 7 mm.
    let clamp = || block([10.0, 22.0, -5.0], [30.0, 30.0, 8.0]);
    let v = beside(clamp(), 6.9, None);
    let [nearest] = &v.avoided[0].nearest[..] else { panic!("{:?}", v.avoided) };
    assert_eq!((nearest.part, nearest.wanted), (AssemblyPart::Cutter, 6.9));
    assert!((nearest.distance - 7.0).abs() < 0.01 && !nearest.is_farther, "{nearest:?}");
    assert!((nearest.place.y - 22.0).abs() < 1e-9, "{nearest:?}");
    assert!(too_near(&v).is_empty(), "{:?}", v.figures.broken);
    // One mm of distance more is not there.
    let [(part, distance, on_rapid)] = too_near(&beside(clamp(), 7.1, None))[..] else { panic!() };
    assert_eq!((part, on_rapid), (AssemblyPart::Cutter, false));
    assert!((distance - 7.0).abs() < 0.01, "{distance}");
    // Farther away than it is looked, it is told so.
    let [far] =
        &beside(block([0.0, 90.0, 0.0], [9.0, 99.0, 9.0]), 1.0, None).avoided[0].nearest[..]
    else {
        panic!()
    };
    assert!(far.is_farther && far.distance == 11.0, "{far:?}");
}

/// A clamp lower than the ball's middle is as far as the ball is round.
#[test]
fn a_ball_is_round_beside_a_low_clamp() {
    let v = beside(block([10.0, 14.0, -5.0], [30.0, 30.0, 2.0]), 0.1, None);
    let expected = DVec3::new(0.0, 4.0, 3.0).length() - 5.0;
    let [(_, distance, _)] = too_near(&v)[..] else { panic!("{:?}", v.avoided) };
    assert!((distance - expected).abs() < 0.01, "{distance}");
}

#[test]
fn a_rapid_through_a_tall_clamp_is_found() {
    // Two passes with a clamp between them, over which the rapid runs 20 mm up.
    let pass = |from: f64| vec![from, from + 10.0].into_iter();
    let pass = |from| pass(from).map(|x| (DVec3::new(x, 10.0, 0.0), DVec3::Z)).collect();
    let path = path(&[pass(0.0), pass(30.0)]);
    let over = |top: f64| avoiding(&path, block([19.0, 5.0, -5.0], [21.0, 15.0, top]), 0.5, None);
    assert!(too_near(&over(19.4)).is_empty());
    let [(part, distance, on_rapid)] = too_near(&over(19.8))[..] else { panic!() };
    assert!(
        part == AssemblyPart::Cutter && on_rapid && (distance - 0.2).abs() < 0.01,
        "{distance}"
    );
    let [(_, depth, true)] = too_near(&over(40.0))[..] else { panic!() };
    assert!(depth < -1.0, "{depth}");
}

/// The holder of 12 mm is 10 mm from a clamp that is higher than its lower end, and is clear of one once it begins
/// higher.
#[test]
fn a_holder_keeps_its_distance_from_a_clamp() {
    let clamp = || block([10.0, 32.0, -5.0], [30.0, 40.0, 33.0]);
    let near = |distance: f64| beside(clamp(), distance, above(30.0, 12.0, 0.0));
    let v = near(9.9);
    let holder = v.avoided[0].nearest.iter().find(|n| n.part == AssemblyPart::Holder).unwrap();
    assert!((holder.distance - 10.0).abs() < 0.01, "{holder:?}");
    assert_eq!(v.avoided[0].closest(), Some(holder));
    assert!(too_near(&v).is_empty() && v.avoided[0].farther_out.is_none());
    // 10.5 mm are kept `sqrt(10.5² - 10²)` = 3.2 mm above the clamp: 7 whole mm farther out.
    let v = near(10.5);
    let [(AssemblyPart::Holder, ..)] = too_near(&v)[..] else { panic!("{:?}", v.avoided) };
    assert_eq!(v.avoided[0].farther_out, Some(7.0));
}

#[test]
fn nothing_to_measure_is_no_clearance() {
    let part = Part { positions: vec![DVec3::ZERO], faces: Vec::new() };
    let avoided = Avoided {
        name: "clamp".into(),
        distance: 1.0,
        positions: part.positions,
        faces: part.faces,
    };
    let options = VerifyOptions { avoided: vec![avoided], ..options(5.0, 5.0) };
    let path = path(&raster(40.0, &evenly(0.0, 1.0, 11)));
    let nothing = Facets { positions: &[], faces: &[] };
    let plane = Part::plane(40.0, 20.0);
    let error = verify(&path, plane.facets(), nothing, &options, &mut |_| {}).unwrap_err();
    assert_eq!(error, VerifyError::NotMeasured { name: "clamp".into() });
}

/// A pass that follows another one: what both leave together, and a rate that is the difference. A ball of 4 mm after one of
/// 10 mm between the same passes: the cusps of both.
#[test]
fn a_cut_meets_what_earlier_ones_left() {
    let (width, step) = (20.0, 2.0);
    let part = Part::plane(width, width);
    let [first, second] = [5.0, 2.0];
    let earlier = path(&raster(width, &evenly(0.0, step, 11)));
    // The second goes half a step beside each pass of the first, over half of the plane alone.
    let own = path(&raster(width, &evenly(0.5 * step, step, 5)));
    let cut =
        EarlierCut { path: earlier, tool: Tool::new(first, first).unwrap(), length: f64::INFINITY };
    let earlier = Some(Earlier { top: 0.5, bridged: 0.0, cuts: vec![cut] });
    let asked = VerifyOptions { earlier, spacing: 0.05, ..options(second, second) };
    let v = judged(&own, &part, &asked);
    let cusp = |r: f64, d: f64| r - (r * r - 0.25 * d * d).sqrt();
    assert_eq!(v.figures.untouched.0, 0.0);
    // Where the second does not go, the cusps of the first stay; where it goes, where its side meets the first's.
    let largest = v.figures.largest.unwrap();
    assert_close(largest.height, cusp(first, step), 0.01);
    assert!(largest.of.is_none() && largest.is_cut && largest.place.y > 9.5, "{largest:?}");
    let on_second = v.samples.iter().filter(|s| s.position[1] < 8.5 && s.area > 0.0);
    let highest = on_second.map(|s| f64::from(s.residual)).fold(0.0, f64::max);
    // y from the middle of the first, 1 - y from that of the second: the heights of both are the same there.
    let meeting = (0..1000).map(|i| 1e-3 * f64::from(i));
    let both = |y: f64| cusp(first, 2.0 * y).min(cusp(second, 2.0 * (0.5 * step - y)));
    assert_close(highest, meeting.map(both).fold(0.0, f64::max), 0.02);
    // It takes the cusps that stand under it, whose section is known, and not the whole layer.
    let section = 2.0
        * (0..1000)
            .map(|i| 1e-3 * (f64::from(i) + 0.5))
            .map(|y| 1e-3 * (cusp(first, 2.0 * y) - cusp(second, 2.0 * (1.0 - y))).max(0.0))
            .sum::<f64>();
    let peak = v.rate.peak.unwrap().measured;
    assert_close(peak, section * FEED, 0.04);
    // Without the first one half of the plane is untouched, and the layer is taken whole.
    let alone = judged(&own, &part, &options(second, second));
    assert!(alone.figures.untouched.0 > 0.4 * width * width, "{}", alone.figures.untouched.0);
    assert!(alone.rate.peak.unwrap().measured > 5.0 * peak);
    let many = judged(&own, &part, &VerifyOptions { threads: 3, ..asked });
    assert_eq!(many.samples, v.samples);
}

/// A cutter that went over a place high above the surface has not cut it.
#[test]
fn what_bridges_a_place_is_no_cut_of_it() {
    let part = Part::plane(20.0, 20.0);
    let high = raster(20.0, &evenly(0.0, 1.0, 21));
    let high: Vec<Vec<(DVec3, DVec3)>> = high
        .into_iter()
        .map(|pass| pass.into_iter().map(|(tip, a)| (tip + 3.0 * DVec3::Z, a)).collect())
        .collect();
    let own = path(&raster(20.0, &evenly(0.0, 1.0, 8)));
    let cut = |path: &Toolpath| EarlierCut {
        path: path.clone(),
        tool: Tool::new(5.0, 5.0).unwrap(),
        length: f64::INFINITY,
    };
    let earlier = Earlier { top: 0.5, bridged: 4.0, cuts: vec![cut(&path(&high))] };
    let v = judged(&own, &part, &VerifyOptions { earlier: Some(earlier), ..options(5.0, 5.0) });
    assert!(v.figures.untouched.0 > 100.0, "{}", v.figures.untouched.0);
    // The first pass of the path takes the 3 mm that the earlier one left, and half of its own strip.
    assert!(v.rate.peak.unwrap().measured > 5.0 * FEED);
}
