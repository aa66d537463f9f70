//! Closed forms: straight passes, slots, pockets.

use super::*;
use crate::flat_path::Terrain;
use crate::geometry::{DVec2, DVec3, math};
use crate::job::FeedComponent;
use crate::outline::Outline;
use crate::toolpath::{MoveKind, PathPoint, Toolpath};

fn rectangle(x0: f64, y0: f64, x1: f64, y1: f64) -> Vec<DVec2> {
    [(x0, y0), (x1, y0), (x1, y1), (x0, y1)].map(|(x, y)| DVec2::new(x, y)).to_vec()
}

fn big_plate() -> Stock {
    Stock::new(&Outline::from_loops(vec![rectangle(-100.0, -100.0, 100.0, 100.0)]))
}

fn sweep_polyline(stock: &mut Stock, radius: f64, points: &[(f64, f64)]) {
    for w in points.windows(2) {
        let [a, b] = [w[0], w[1]].map(|(x, y)| DVec2::new(x, y));
        stock.sweep(Capsule::new(a, radius, b, radius));
    }
}

#[test]
fn slot_engages_the_whole_half_circle() {
    let stock = big_plate();
    for angle in 0..12 {
        let feed = DVec2::new(math::cos(angle as f64), math::sin(angle as f64));
        let e = stock.engagement(DVec2::new(3.0, 7.0), 5.0, feed);
        assert!((e.alpha - core::f64::consts::PI).abs() < 1e-12);
        assert!((e.normal_feed - 2.0).abs() < 1e-12);
    }
}

#[test]
fn straight_pass_engages_by_its_side_step() {
    for step in [0.01, 0.3, 0.63, 2.5, 5.0, 7.5, 9.9] {
        let mut stock = big_plate();
        // A neighbour pass in many short pieces, as a real ring has.
        let pass: Vec<_> = (0..=800).map(|i| (-120.0 + 0.3 * i as f64, 1.0)).collect();
        sweep_polyline(&mut stock, 5.0, &pass);
        for x in [-3.3, 0.0, 12.34] {
            let e = stock.engagement(DVec2::new(x, 1.0 + step), 5.0, DVec2::X);
            let alpha = math::acos(1.0 - step / 5.0);
            assert!((e.alpha - alpha).abs() < 1e-9, "step {step}: {} {alpha}", e.alpha);
            assert!((e.normal_feed - step / 5.0).abs() < 1e-9, "step {step}: {}", e.normal_feed);
        }
    }
}

#[test]
fn neighbour_as_one_long_capsule_or_many_pieces_is_the_same() {
    let mut stock = big_plate();
    sweep_polyline(&mut stock, 5.0, &[(-120.0, 1.0), (120.0, 1.0)]);
    let e = stock.engagement(DVec2::new(0.3, 3.0), 5.0, DVec2::NEG_X);
    assert!((e.normal_feed - 0.4).abs() < 1e-12);
}

#[test]
fn outside_of_the_region_is_air() {
    let stock = big_plate();
    let e = stock.engagement(DVec2::new(0.0, 100.0), 5.0, DVec2::X);
    assert!((e.normal_feed - 1.0).abs() < 1e-12, "half immersion");
    let e = stock.engagement(DVec2::new(0.0, 103.0), 5.0, DVec2::X);
    assert!((e.normal_feed - 0.4).abs() < 1e-12);
    let e = stock.engagement(DVec2::new(0.0, 106.0), 5.0, DVec2::X);
    assert_eq!(e.normal_feed, 0.0);
}

/// First lap of a square pocket with walls, then the second at side step `D`: along the sides the
/// second lap is engaged by `D`; it leaves the stock before its corners, since what is left after
/// the first lap is a square whose corner the disc passes `R - D` before it turns.
#[test]
fn square_pocket_second_lap() {
    let (radius, step) = (5.0, 2.0);
    let mut stock = Stock::new(&Outline::from_loops(vec![rectangle(0.0, 0.0, 60.0, 60.0)]));
    let lap = |d: f64| [(d, d), (60.0 - d, d), (60.0 - d, 60.0 - d), (d, 60.0 - d), (d, d)];
    sweep_polyline(&mut stock, radius, &lap(radius));
    let y = radius + step;
    let middle = stock.engagement(DVec2::new(30.0, y), radius, DVec2::X);
    assert!((middle.normal_feed - step / radius).abs() < 1e-9);
    // The stock's lower edge is y = 10, its right edge x = 50. With the centre at x the arc is in
    // stock where y >= 10 and x <= 50: sin from (10 - y)/R up to the sine whose cosine is (50 - x)/R.
    let x: f64 = 48.0;
    let e = stock.engagement(DVec2::new(x, y), radius, DVec2::X);
    let cosine: f64 = (50.0 - x) / radius;
    let low = (1.0 - cosine * cosine).sqrt();
    let expected = 1.0 - low.max((10.0 - y) / radius);
    assert!((e.normal_feed - expected).abs() < 1e-9, "{} {expected}", e.normal_feed);
    let past = stock.engagement(DVec2::new(50.5, y), radius, DVec2::X);
    assert_eq!(past.normal_feed, 0.0, "all stock lies behind");
}

/// Cutting outward into a corner: stock on the left and ahead.
#[test]
fn inside_corner_engages_side_and_front() {
    let (radius, step) = (5.0, 1.0);
    // The cleared square [-20, 20]² is an island of air, so that its corners are sharp.
    let island: Vec<_> = rectangle(-20.0, -20.0, 20.0, 20.0).into_iter().rev().collect();
    let plate = rectangle(-100.0, -100.0, 100.0, 100.0);
    let stock = Stock::new(&Outline::from_loops(vec![plate, island]));
    // Going +x along y = 16 with stock above y = 20 and beyond x = 20.
    let center = DVec2::new(17.0, 15.0 + step);
    let e = stock.engagement(center, radius, DVec2::X);
    // Above y = 20: sine >= 0.8; beyond x = 20: cosine >= 0.6, i.e. |sine| <= 0.8: all from -0.8 to 1,
    // but for the cleared square's own lower right corner, far away.
    assert!((e.normal_feed - 1.8).abs() < 1e-6, "{}", e.normal_feed);
}

/// Annular pocket: after a lap at radius r1, a lap at r1 + D outward leaves a crescent whose
/// engagement follows from two circles: the cutter circle and the cleared edge (radius r1 + R).
#[test]
fn annular_pocket_second_lap() {
    let (radius, first, step) = (5.0, 20.0, 1.5);
    let mut stock = big_plate();
    let circle = |r: f64, n: usize| -> Vec<(f64, f64)> {
        (0..=n)
            .map(|i| 2.0 * core::f64::consts::PI * i as f64 / n as f64)
            .map(|a| (r * math::cos(a), r * math::sin(a)))
            .collect()
    };
    sweep_polyline(&mut stock, radius, &circle(first, 20_000));
    let second = first + step;
    // Centre at (second, 0), feed +y: stock beyond the circle of radius r1 + R about the origin.
    let e = stock.engagement(DVec2::new(second, 0.0), radius, DVec2::Y);
    // A point of the cutter circle at angle t from +x is in stock when
    // second² + R² + 2 second R cos t > (r1 + R)²; the leading half has 0 < t < pi.
    let edge = first + radius;
    let cosine = (edge * edge - second * second - radius * radius) / (2.0 * second * radius);
    let alpha = math::acos(cosine);
    assert!((e.alpha - alpha).abs() < 1e-6, "{} {alpha}", e.alpha);
    assert!((e.normal_feed - (1.0 - cosine)).abs() < 1e-6);
}

/// L-shaped pocket with walls: at the reflex corner the second lap follows the first at side step
/// D on both legs.
#[test]
fn l_shaped_pocket_legs() {
    let (radius, step) = (4.0, 1.0);
    let outline = [(0.0, 0.0), (60.0, 0.0), (60.0, 30.0), (30.0, 30.0), (30.0, 60.0), (0.0, 60.0)];
    let region = Outline::from_loops(vec![outline.map(|(x, y)| DVec2::new(x, y)).to_vec()]);
    let mut stock = Stock::new(&region);
    let lap = |d: f64| {
        [
            (d, d),
            (60.0 - d, d),
            (60.0 - d, 30.0 - d),
            (30.0 - d, 30.0 - d),
            (30.0 - d, 60.0 - d),
            (d, 60.0 - d),
            (d, d),
        ]
    };
    sweep_polyline(&mut stock, radius, &lap(radius));
    let d = radius + step;
    for (x, y, feed) in
        [(30.0, d, DVec2::X), (50.0, 30.0 - d, DVec2::NEG_X), (30.0 - d, 45.0, DVec2::Y)]
    {
        let e = stock.engagement(DVec2::new(x, y), radius, feed);
        assert!((e.normal_feed - step / radius).abs() < 1e-9, "{x} {y}: {}", e.normal_feed);
    }
}

#[test]
fn rollback_restores_the_stock() {
    let mut stock = big_plate();
    sweep_polyline(&mut stock, 5.0, &[(-50.0, 0.0), (50.0, 0.0)]);
    let probe = |s: &Stock| s.engagement(DVec2::new(0.0, 1.0), 5.0, DVec2::X);
    let before = probe(&stock);
    let mark = stock.checkpoint();
    for i in 0..200 {
        let y = 0.05 * i as f64;
        sweep_polyline(&mut stock, 5.0, &[(-20.0, y), (20.0, y + 0.3)]);
    }
    assert_ne!(probe(&stock), before);
    stock.rollback(&mark);
    assert_eq!(probe(&stock), before);
    stock.checkpoint();
    sweep_polyline(&mut stock, 5.0, &[(-20.0, 3.0), (20.0, 3.0)]);
    stock.commit();
    assert_eq!(probe(&stock).normal_feed, 0.0);
}

/// Squares that serve again are none of the tree's: after any number of trials, kept or undone, the stock is that of
/// the moves that were kept, and no larger than its front.
#[test]
fn trials_leave_what_was_kept() {
    let (mut tried, mut plain) = (big_plate(), big_plate());
    let mut most = 0;
    for row in 0..60 {
        let y = -100.0 + 3.4 * f64::from(row);
        let pass: Vec<_> = (0..=40).map(|i| (-105.0 + 5.25 * f64::from(i), y)).collect();
        for offset in [1.0, 7.0, -2.0] {
            let mark = tried.checkpoint();
            let other: Vec<_> = pass.iter().map(|(x, y)| (*x, y + offset)).collect();
            sweep_polyline(&mut tried, 5.0, &other);
            tried.rollback(&mark);
        }
        tried.checkpoint();
        sweep_polyline(&mut tried, 5.0, &pass);
        tried.commit();
        sweep_polyline(&mut plain, 5.0, &pass);
        for i in 0..40 {
            let at = DVec2::new(-97.0 + 5.0 * f64::from(i), y + 2.0);
            let probe = |s: &Stock| s.engagement(at, 5.0, DVec2::X);
            assert_eq!(probe(&tried), probe(&plain), "{at}");
            assert_eq!(tried.has_stock(at + DVec2::Y * 4.0), plain.has_stock(at + DVec2::Y * 4.0));
        }
        most = most.max(plain.size().1);
    }
    // All of it is done: one square. What trials need at once is little more than what there is at once.
    assert_eq!([tried.size().1, plain.size().1], [1, 1]);
    assert!(tried.size().0 <= 3 * most, "{:?} of {most}", tried.size());
}

#[test]
fn remaining_area_is_region_minus_swept() {
    let mut stock = Stock::new(&Outline::from_loops(vec![rectangle(0.0, 0.0, 40.0, 30.0)]));
    sweep_polyline(&mut stock, 5.0, &[(10.0, 15.0), (30.0, 15.0)]);
    let mut area = 0.0;
    stock.remaining(0.05, |_, a| area += a);
    let swept = 20.0 * 10.0 + core::f64::consts::PI * 25.0;
    assert!((area - (1200.0 - swept)).abs() < 1.2, "{area}");
}

/// Twice as large on the surface as in the plane.
struct Double;

impl Terrain for Double {
    fn scale(&self, at: DVec2) -> Option<f64> {
        (at.abs().max_element() <= 100.0).then_some(2.0)
    }
    fn room(&self, _: DVec2) -> Option<f64> {
        Some(1.0)
    }
    fn joins(&self, _: DVec2, _: DVec2) -> bool {
        true
    }
}

#[test]
fn the_plane_predicts_a_slot_and_the_pass_beside_it() {
    use MoveKind::{Cut, Link, Rapid};
    let (radius, depth) = (10.0, 0.5);
    let point = |kind, flat: Option<[f64; 2]>, feed| PathPoint {
        kind,
        pass: 0,
        region: 0,
        tip: DVec3::ZERO,
        axis: DVec3::Z,
        normal: DVec3::Z,
        flat: flat.map(DVec2::from_array),
        feed,
        mrr: 0.0,
        alpha: 0.0,
        time: 0.0,
    };
    let path = Toolpath {
        points: vec![
            point(Rapid, None, 100.0),
            point(Link, Some([-50.0, 0.0]), 20.0),
            // A slot, at the nominal feed, then beside it at half of that, 4 mm on the surface.
            point(Cut, Some([50.0, 0.0]), 20.0),
            point(Link, Some([50.0, 2.0]), 20.0),
            point(Cut, Some([40.0, 2.0]), 10.0),
            point(Cut, Some([-40.0, 2.0]), 10.0),
            // Along the slot again: nothing is left; beyond the chart nothing is known.
            point(Cut, Some([-40.0, 0.0]), 20.0),
            point(Cut, Some([90.0, 0.0]), 20.0),
            point(Cut, Some([110.0, 0.0]), 20.0),
        ],
    };
    let vfc = FeedComponent::Mean;
    let cutting = Cutting { radius, depth, feed: 20.0, vfc, limit: f64::INFINITY };
    let planar = predicted(&path, Simulation::new(cutting, &Double, big_plate()));
    assert_eq!(
        planar.iter().map(Option::is_some).collect::<Vec<_>>(),
        [false, false, true, false, true, true, true, true, false]
    );
    let close = |a: f64, b: f64| assert!((a - b).abs() < 1e-9, "{a} is not {b}");
    let [slot, beside] = [2, 5].map(|i| planar[i].unwrap());
    close(slot.mrr3(), 2.0 * radius * depth * 20.0);
    close(slot.mrr2, 0.25 * slot.mrr3());
    close(slot.alpha, core::f64::consts::PI);
    close(beside.mrr3(), 4.0 * depth * 10.0);
    close(beside.alpha, math::acos(1.0 - 4.0 / radius));
    close(slot.tau, 4.0);
}
