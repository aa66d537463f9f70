//! Edges of blades by formula, and of measured blades on their hubs.

use super::*;
use crate::geometry::DMat3;
use crate::geometry::math::{cos, sin};
use crate::nurbs::{NurbsCurve, read_json};
use std::f64::consts::TAU;

/// A hub of radius 50 around x, from 0 to `length`.
fn cylinder(length: f64) -> NurbsSurface {
    let (a, b) = (DVec3::new(0.0, 0.0, 50.0), DVec3::new(length, 0.0, 50.0));
    NurbsCurve::line(a, b).unwrap().revolved(DVec3::ZERO, DVec3::X).unwrap()
}

/// An upright blade of elliptic section through the hub at x = `x`, at its seam.
fn blade(x: f64) -> NurbsSurface {
    let centre = DVec3::new(x, 0.0, 30.0);
    let section = NurbsCurve::ellipse(centre, DVec3::X * 14.0, DVec3::Y * 7.0).unwrap();
    section.extruded(DVec3::ZERO, DVec3::Z * 40.0).unwrap()
}

/// Points of a curve in space.
fn along(hub: &NurbsSurface, curve: &ParameterCurve, count: usize) -> Vec<DVec3> {
    (0..=count).map(|k| hub.jet_beyond(curve.point(k as f64 / count as f64)).point).collect()
}

/// Distance from the ellipse around x, to the first order, mm.
fn off_ellipse(p: DVec3, x: f64) -> f64 {
    let (a, b) = ((p.x - x) / 14.0, p.y / 7.0);
    let slope = DVec2::new(a / 14.0, b / 7.0).length() * 2.0;
    (a * a + b * b - 1.0) / slope
}

#[test]
fn a_blade_without_fillet_meets_the_hub() {
    let hub = cylinder(80.0);
    for tolerance in [1e-2, 1e-3] {
        let curve = edge_on_hub(&hub, &[blade(40.0)], tolerance).unwrap();
        println!("{} control points, {:e}", curve.control_points(), curve.deviation());
        assert!(curve.is_closed() && curve.area() > 0.0);
        for p in along(&hub, &curve, 1000) {
            assert!(p.z > 0.0 && off_ellipse(p, 40.0).abs() < tolerance, "{p}");
        }
    }
}

#[test]
fn two_sides_and_a_blunt_end_make_a_ring() {
    let hub = cylinder(80.0);
    let centre = DVec3::new(40.0, 0.0, 30.0);
    // Two sides, a round nose, and a tail that is cut off straight; not in order.
    let side = |y: f64, back: bool| {
        let (a, b) = (centre + DVec3::new(-20.0, y, 0.0), centre + DVec3::new(20.0, 0.2 * y, 0.0));
        let (a, b) = if back { (b, a) } else { (a, b) };
        NurbsCurve::line(a, b).unwrap().extruded(DVec3::ZERO, DVec3::Z * 40.0).unwrap()
    };
    let nose = NurbsCurve::half_circle(centre - DVec3::X * 20.0, DVec3::Y * 4.0, DVec3::X * -4.0);
    let nose = nose.unwrap().extruded(DVec3::ZERO, DVec3::Z * 40.0).unwrap();
    for back in [false, true] {
        let feet = [side(4.0, back), side(-4.0, false), nose.clone()];
        let curve = edge_on_hub(&hub, &feet, 0.01).unwrap();
        println!("{} control points, {:e}", curve.control_points(), curve.deviation());
        assert!(curve.is_closed() && curve.area() > 0.0);
        let points = along(&hub, &curve, 3000);
        for p in &points {
            let q = DVec2::new(p.x - 40.0, p.y.abs());
            let off = if q.x < -20.0 {
                (q + DVec2::X * 20.0).length() - 4.0
            } else {
                let side = (q.y - 2.4 + 0.08 * q.x) / (1.0 + 0.08_f64 * 0.08).sqrt();
                side.max(q.x - 20.0)
            };
            assert!(off.abs() < 0.013, "{p} {off}");
        }
        let tail = points.iter().filter(|p| p.x > 59.9).map(|p| p.y.abs());
        assert!(tail.fold(f64::INFINITY, f64::min) < 0.1);
    }
    // One side alone is open, and without the nose the gap is too wide.
    assert!(!edge_on_hub(&hub, &[side(4.0, false)], 0.01).unwrap().is_closed());
    let gap = edge_on_hub(&hub, &[side(4.0, false), nose, side(-9.0, false)], 0.01).unwrap_err();
    assert!(gap.to_string().contains("gap of"), "{gap}");
    assert_eq!(edge_on_hub(&hub, &[], 0.01).unwrap_err(), HubError::NoFoot);
}

#[test]
fn beyond_the_rim_the_hub_is_continued_a_little() {
    // The blade ends at 54, the hub at 50, and it can be continued to 57.5.
    let hub = cylinder(50.0);
    let curve = edge_on_hub(&hub, &[blade(40.0)], 1e-3).unwrap();
    assert!(curve.is_closed());
    assert!(along(&hub, &curve, 500).iter().all(|p| off_ellipse(*p, 40.0).abs() < 1e-3));
    // Farther out it is open there.
    let curve = edge_on_hub(&hub, &[blade(49.0)], 1e-3).unwrap();
    assert!(!curve.is_closed() && curve.area() > 0.0);
    let points = along(&hub, &curve, 500);
    assert!(points.iter().all(|p| off_ellipse(*p, 49.0).abs() < 1e-3));
    let ends = [points[0], points[500]];
    assert!(ends.iter().all(|p| p.x > 56.0 && p.x < 57.6), "{} {}", ends[0], ends[1]);
    let far = edge_on_hub(&hub, &[blade(400.0)], 1e-3).unwrap_err();
    assert!(matches!(far, HubError::NoEdge { foot: 0, .. }), "{far}");
}

/// Points of the elliptic edge about x = 40, from one part of its turn to another.
fn bound(from: f64, to: f64) -> Vec<DVec3> {
    let at = |k: i32| {
        let t = TAU * (from + (to - from) * f64::from(k) / 200.0);
        let (x, y) = (40.0 + 14.0 * cos(t), 7.0 * sin(t));
        DVec3::new(x, y, (2500.0 - y * y).sqrt())
    };
    (0..=200).map(at).collect()
}

#[test]
fn bounds_of_faces_on_the_hub_make_the_edge_in_any_order_and_sense() {
    let hub = cylinder(80.0);
    let above = bound(0.0, 0.2).iter().map(|p| *p * 1.2).collect();
    let bounds = vec![bound(0.4, 0.0), above, bound(0.4, 0.7), bound(1.0, 0.7)];
    let curve = edge_along(&hub, &bounds, 1e-3).unwrap().unwrap();
    assert!(curve.is_closed() && curve.area() > 0.0);
    assert!(along(&hub, &curve, 999).iter().all(|p| off_ellipse(*p, 40.0).abs() < 1e-3));
    // Without one of them there is no ring, and no blade's edge ends on the hub.
    assert!(edge_along(&hub, &bounds[..3], 1e-3).unwrap().is_none());
    // Up to the rim there is.
    let hub = cylinder(40.0);
    let half = [bound(0.5, 0.75), bound(0.5, 0.25)];
    let curve = edge_along(&hub, &half, 1e-3).unwrap().unwrap();
    assert!(!curve.is_closed() && curve.area() > 0.0);
}

fn read(name: &str) -> Option<NurbsSurface> {
    let path = crate::shared_data::shared_data("nurbs")?.join(name).with_extension("json");
    Some(read_json(&std::fs::read(path).unwrap()).unwrap().surface)
}

/// The same about the axis x.
fn turned(surface: &NurbsSurface, degrees: f64, shift: f64) -> NurbsSurface {
    let turn = DMat3::from_cols(
        DVec3::X,
        DVec3::new(0.0, cos(degrees.to_radians()), -sin(degrees.to_radians())),
        DVec3::new(0.0, sin(degrees.to_radians()), cos(degrees.to_radians())),
    );
    surface.transformed(turn, DVec3::X * shift).unwrap()
}

/// Greatest distance of points from a side v = low of a foot, mm.
fn off_side(foot: &NurbsSurface, points: &[DVec3]) -> f64 {
    let (low, high) = foot.domain();
    let side: Vec<DVec3> = (0..=8000)
        .map(|k| foot.point(DVec2::new(low.x + (high.x - low.x) * f64::from(k) / 8000.0, low.y)))
        .collect();
    let to = |p: &DVec3| side.iter().map(|q| q.distance(*p)).fold(f64::INFINITY, f64::min);
    points.iter().map(to).fold(0.0, f64::max)
}

#[test]
fn measured_impeller_blades_have_closed_edges() {
    let (Some(hub), Some(main)) = (read("hecc_hub_sector"), read("hecc_main_blade")) else {
        return;
    };
    let Some(splitter) = read("hecc_splitter_blade") else { return };
    for (name, blade, degrees) in [("main", main, -4.5), ("splitter", splitter, -6.0)] {
        let blade = turned(&blade, degrees, 0.0);
        for tolerance in [0.15, 0.02] {
            let began = std::time::Instant::now();
            let curve = edge_on_hub(&hub, std::slice::from_ref(&blade), tolerance).unwrap();
            let points = along(&hub, &curve, 700);
            let off = off_side(&blade, &points);
            let (count, deviation) = (curve.control_points(), curve.deviation());
            println!("{name} {tolerance}: {count}, {deviation}, {off}, {:?}", began.elapsed());
            assert!(curve.is_closed() && curve.area() > 0.0);
            // Also across the blunt trailing edge.
            assert!(off < 0.2, "{off}");
        }
    }
}

#[test]
fn a_measured_fillet_has_a_closed_edge() {
    let Some((hub, fillet)) = read("hecc_hub_sector").zip(read("hecc_main_blade_fillet")) else {
        return;
    };
    // The blade as made, cold, is not exactly where the design has the hub.
    let fillet = turned(&fillet, 64.0, -0.67);
    let curve = edge_on_hub(&hub, std::slice::from_ref(&fillet), 0.4).unwrap();
    let off = off_side(&fillet, &along(&hub, &curve, 700));
    println!("{} control points, {}, {off}", curve.control_points(), curve.deviation());
    assert!(curve.is_closed() && curve.area() > 0.0);
    assert!(off < 0.8, "{off}");
}

#[test]
fn a_measured_blade_through_its_hub_meets_it() {
    let Some((hub, blade)) = read("kj66_hub").zip(read("kj66_blade")) else { return };
    for tolerance in [0.05, 0.005] {
        let curve = edge_on_hub(&hub, std::slice::from_ref(&blade), tolerance).unwrap();
        assert!(!curve.is_closed());
        let points = along(&hub, &curve, 300);
        let guess = 0.5 * (blade.domain().0 + blade.domain().1);
        let off = points.iter().map(|p| blade.project(*p, guess).1).fold(0.0, f64::max);
        let ends = [points[0], points[300]].map(|p| DVec2::new(p.x, p.z).length());
        println!("{tolerance}: {}, {off}, radii {ends:?}", curve.control_points());
        assert!(off < tolerance, "{off}");
        let (least, most) = (ends[0].min(ends[1]), ends[0].max(ends[1]));
        assert!(least < 9.0 && most > 49.0, "{ends:?}");
    }
}
