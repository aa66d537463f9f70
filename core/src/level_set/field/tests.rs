//! Distances known in closed form.

use super::*;
use crate::flatten::bff;
use crate::geometry::DVec3;
use crate::geometry::math::{asin, hypot};
use crate::job::{Component, Faces, Selection, SurfaceOptions, SurfaceSource};
use crate::level_set::strip_metric;
use crate::surface::{AnalyticSurface, build};

fn mesh_of(shape: &AnalyticSurface, edge: f64, side_step: f64) -> PassMesh {
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
    let surface = build(shape.mesh(edge), &options).unwrap().surface;
    let chart = bff(&surface).unwrap();
    let metric = vec![strip_metric::even(side_step); surface.positions().len()];
    PassMesh::new(&surface, &chart, metric).unwrap()
}

/// On a cap the distance from the rim is an arc of a great circle; the fronts bend toward the middle,
/// where they meet in a point.
#[test]
fn distance_on_a_cap_is_good_to_a_few_hundredths_of_a_pass() {
    let (radius, rim) = (40.0, 30.0);
    let arc = |d: f64| radius * asin(d / radius);
    let shape = AnalyticSurface::SphereCap { radius, diameter: 2.0 * rim };
    for (edge, w, bound) in [(0.5, 1.0, 0.01), (0.5, 0.5, 0.0125), (1.0, 2.0, 0.01)] {
        let mesh = mesh_of(&shape, edge, w);
        let field = PassField::from_boundary(&mesh);
        let error = |(p, v): (&DVec3, &f64)| {
            let d = hypot(p.x, p.y);
            (d, v - (arc(rim) - arc(d)) / w)
        };
        let errors: Vec<_> = mesh.positions().iter().zip(field.values()).map(error).collect();
        let worst = |near: f64, far: f64| {
            let ring = errors.iter().filter(|(d, _)| (near..far).contains(d));
            ring.map(|(_, e)| e.abs()).fold(0.0, f64::max)
        };
        println!("edge {edge} pass {w}: {:.4}, middle {:.4}", worst(4.0, 31.0), worst(0.0, 4.0));
        assert!(worst(4.0, 31.0) < bound, "edge {edge} pass {w}: {}", worst(4.0, 31.0));
        assert!(worst(0.0, 4.0) < 0.05, "edge {edge} pass {w}: {}", worst(0.0, 4.0));
    }
}

/// From a straight line through a plane the distance is exact on both sides.
#[test]
fn distance_from_a_line_is_signed() {
    let mesh = mesh_of(&AnalyticSurface::Plane { width: 30.0, depth: 20.0 }, 1.3, 1.7);
    let locator = Locator::new(mesh.connectivity(), mesh.uv());
    // Flat points of two places in space: the chart of a plane is a motion.
    let [a, b] = [DVec3::new(-15.0, -6.0, 0.0), DVec3::new(15.0, 4.0, 0.0)];
    let [p, q] = [a, b].map(|p| {
        let nearest = |v: &usize| mesh.positions()[*v].distance(p);
        let v = (0..mesh.uv().len()).min_by(|v, w| nearest(v).total_cmp(&nearest(w))).unwrap();
        (mesh.positions()[v], mesh.uv()[v])
    });
    let field = PassField::from_curve(&mesh, &locator, &[p.1, q.1], Accuracy::Full).unwrap();
    let way = (q.0 - p.0).normalize();
    for (at, value) in mesh.positions().iter().zip(field.values()) {
        let beside = (*at - p.0).dot(way);
        // At the ends fronts have the boundary on one side.
        if (2.0..(q.0 - p.0).length() - 2.0).contains(&beside) {
            let exact = way.cross(*at - p.0).z / 1.7;
            assert!((value - exact).abs() < 2e-3, "{at}: {value} is not {exact}");
        }
    }
}

/// The pace of a linear function on a plane is its slope; its level curves are a side step apart.
#[test]
fn a_linear_function_is_paced_evenly() {
    let mesh = mesh_of(&AnalyticSurface::Plane { width: 30.0, depth: 20.0 }, 1.0, 0.8);
    let raw: Vec<f64> = mesh.positions().iter().map(|p| 3.0 * p.x - 4.0 * p.y).collect();
    let field = PassField::paced(&mesh, &raw).unwrap();
    let (low, high) = field.range();
    // The function changes by 5 per mm.
    assert!((high - low - (3.0 * 30.0 + 4.0 * 20.0) / 5.0 / 0.8).abs() < 1e-6);
    let length = field.length(&mesh);
    assert!((length - 600.0 / 0.8).abs() < 1e-6 * length, "{length}");
    assert!((length_floor(&mesh) - 600.0 / 0.8).abs() < 1e-6 * length);
}

#[test]
fn a_constant_cannot_be_paced() {
    let mesh = mesh_of(&AnalyticSurface::Plane { width: 8.0, depth: 8.0 }, 1.0, 0.8);
    let raw = vec![1.0; mesh.uv().len()];
    assert!(PassField::paced(&mesh, &raw).is_err());
}

/// A curve from the rim of a ring to its hole does not part it: the distance has no sign, and both fronts
/// meet on the far side.
#[test]
fn a_curve_that_parts_nothing_gives_a_plain_distance() {
    let mesh = mesh_of(&AnalyticSurface::Plane { width: 20.0, depth: 20.0 }, 1.0, 1.0);
    let locator = Locator::new(mesh.connectivity(), mesh.uv());
    let middle = mesh.uv().iter().copied().sum::<DVec2>() / mesh.uv().len() as f64;
    let curve = [middle, middle + DVec2::new(4.0, 0.0)];
    let field = PassField::from_curve(&mesh, &locator, &curve, Accuracy::Full).unwrap();
    assert!(field.values().iter().all(|v| *v >= 0.0 && v.is_finite()));
}

/// Where much of a pass would need branches beside each other, passes are closer; single places get them.
#[test]
fn branches_are_few_beside_each_other() {
    let pace = |passes: f64, length: f64| Pace { low: 0.0, high: 1.0, passes, length };
    let cheapest =
        |most: f64, length: f64| cheapest_pace(&mut [pace(1.0, 1.0), pace(most, length)]);
    assert_eq!(cheapest(1.5, 0.1), 1.0);
    // Out and back along half is as long as all at the double pace where half asks for it.
    assert_eq!(cheapest(1.5, 1.0), 1.5);
    assert_eq!(cheapest(3.0, 2.0), 3.0);
    assert_eq!(cheapest(50.0, 0.01), 1.0);
    assert_eq!(cheapest(50.0, 2.0), 50.0);
    assert_eq!(cheapest_pace(&mut []), 0.0);
}
