//! The judge against closed forms, and against faults planted in paths.

use super::*;
use crate::geometry::math;
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
        stock: 0.0,
        scallop: None,
        tolerance: 0.002,
        mrr_limit: None,
        spacing: 0.1,
        up: DVec3::Z,
        too_tight: Vec::new(),
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
