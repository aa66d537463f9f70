//! Maps of channels whose shape is known in the parameters.

use super::super::shapes::{Cylinder, options};
use super::*;
use crate::geometry::math::sin;
use crate::nurbs::{NurbsParts, NurbsSurface};
use core::f64::consts::TAU;

const CYLINDER: Cylinder = Cylinder { radius: 50.0, length: 80.0 };

/// Both sides of a channel by the part of the way along it.
fn sides(left: impl Fn(f64) -> DVec2, right: impl Fn(f64) -> DVec2) -> (Vec<DVec2>, Vec<DVec2>) {
    let rows = || (0..ROWS).map(|r| part(r, ROWS));
    (rows().map(left).collect(), rows().map(right).collect())
}

fn parts() -> impl Iterator<Item = (f64, f64)> {
    (0..=10).flat_map(|i| (0..=10).map(move |j| (f64::from(i) / 10.0, f64::from(j) / 10.0)))
}

fn area(points: &[DVec2]) -> f64 {
    let n = points.len();
    0.5 * (0..n).map(|i| points[i].perp_dot(points[(i + 1) % n])).sum::<f64>()
}

#[test]
fn the_map_of_a_parallelogram_is_the_parallelogram() {
    let wheel = CYLINDER.wheel(12);
    let left = |s: f64| DVec2::new(0.3 + 0.4 * s, 0.1 + 0.8 * s);
    let across = DVec2::new(0.25, 0.06);
    let (a, b) = sides(left, |s| left(s) + across);
    let channel = Channel::new(&wheel, &a, &b, &[]).unwrap();
    assert!(!channel.is_harmonic);
    // All cells of one size.
    assert!((channel.least_jacobian - 1.0).abs() < 1e-9, "{}", channel.least_jacobian);
    for (s, t) in parts() {
        let off = channel.at(s, t).distance(left(s) + across * t);
        assert!(off < 1e-12, "({s}, {t}): {off}");
        let place = channel.place(&wheel, s, t);
        assert!(place.distance(wheel.hub.point(left(s) + across * t)) < 1e-9);
    }
}

/// The sides of a bent channel that becomes wider.
fn bent() -> (Vec<DVec2>, Vec<DVec2>) {
    sides(
        |s| DVec2::new(0.3 + 0.4 * s * s, 0.1 + 0.8 * s),
        |s| DVec2::new(0.5 + 0.6 * s * s + 0.05 * sin(6.0 * s), 0.12 + 0.75 * s),
    )
}

#[test]
fn the_inverse_finds_the_parameters() {
    let wheel = CYLINDER.wheel(12);
    let (a, b) = bent();
    let channel = Channel::new(&wheel, &a, &b, &[]).unwrap();
    for (s, t) in parts() {
        let (x, y) = channel.inverse(channel.at(s, t));
        assert!((x - s).abs() < 1e-9 && (y - t).abs() < 1e-9, "({s}, {t}): ({x}, {y})");
    }
}

/// Two sides that lean over like waves, one of them not: between them the ruled map runs backward.
fn leaning() -> (Vec<DVec2>, Vec<DVec2>) {
    let wave = |s: f64| 0.12 * sin(TAU * s);
    sides(
        |s| DVec2::new(0.3 + wave(s), 0.1 + 0.8 * (s + 2.0 * wave(s))),
        |s| DVec2::new(0.9, 0.1 + 0.8 * s),
    )
}

#[test]
fn where_the_ruled_map_folds_a_harmonic_one_does_not() {
    let wheel = CYLINDER.wheel(12);
    let (a, b) = leaning();
    // Ruled between the sides, a cell at the left one is turned over.
    let turned = |r: usize| (a[r + 1] - a[r]).perp_dot(b[r] - a[r]);
    assert!(turned(0) < 0.0 && turned(ROWS / 2) > 0.0);
    let channel = Channel::new(&wheel, &a, &b, &[]).unwrap();
    assert!(channel.is_harmonic && channel.least_jacobian > 0.0, "{}", channel.least_jacobian);
    // The outline is what it was.
    for (side, given) in [(channel.side(false), a), (channel.side(true), b)] {
        assert!(side.iter().zip(given).all(|(p, q)| p.distance(q) < 1e-12));
    }
    for (s, t) in parts() {
        let at = channel.at(s, t);
        let (x, y) = channel.inverse(at);
        assert!(channel.at(x, y).distance(at) < 1e-9, "({s}, {t})");
    }
}

#[test]
fn crossing_sides_are_refused() {
    let wheel = CYLINDER.wheel(12);
    let (a, b) = sides(
        |s| DVec2::new(0.3 + 0.4 * s, 0.1 + 0.8 * s),
        |s| DVec2::new(0.5 - 0.4 * s, 0.1 + 0.8 * s),
    );
    assert!(matches!(Channel::new(&wheel, &a, &b, &[]), Err(HubError::Folded { .. })));
}

/// A hub over an ellipse, which is made whole no more; v runs around.
fn elliptic() -> Wheel {
    let [x, y] = [DVec3::X * 50.0, DVec3::Y * 45.0];
    let ways = [x, x + y, y, y - x, -x, -x - y, -y, x - y, x];
    let weight = |i: usize| if i % 2 == 1 { 0.5_f64.sqrt() } else { 1.0 };
    let around = vec![0.0, 0.0, 0.0, 1.0, 1.0, 2.0, 2.0, 3.0, 3.0, 4.0, 4.0, 4.0];
    let hub = NurbsSurface::new(NurbsParts {
        degree: [1, 2],
        knots: [vec![0.0, 0.0, 1.0, 1.0], around],
        points: [0.0, 80.0].map(|z| ways.map(|way| way + DVec3::Z * z).to_vec()).to_vec(),
        weights: vec![(0..9).map(weight).collect(); 2],
    });
    Wheel::new(&hub.unwrap(), &options(2), DVec3::X * 90.0).unwrap()
}

#[test]
fn the_outline_is_counter_clockwise_whichever_parameter_runs_around() {
    let (a, b) = bent();
    let wheel = CYLINDER.wheel(12);
    let exact = {
        let mut outline = a.clone();
        outline.extend(b.iter().rev());
        area(&outline).abs()
    };
    let around_u = Channel::new(&wheel, &a, &b, &[]).unwrap().outline();
    let wheel = elliptic();
    assert_eq!(wheel.around, 1);
    let swap = |side: &[DVec2]| side.iter().map(|p| DVec2::new(p.y, p.x)).collect::<Vec<_>>();
    let around_v = Channel::new(&wheel, &swap(&a), &swap(&b), &[]).unwrap().outline();
    for outline in [around_u, around_v] {
        let enclosed = area(&outline.points);
        assert!((enclosed - exact).abs() < 1e-9, "{enclosed}: {exact}");
        assert_eq!(outline.winding, [0, 0]);
        let n = outline.points.len();
        assert!((0..n).all(|i| outline.points[i] != outline.points[(i + 1) % n]));
    }
}
