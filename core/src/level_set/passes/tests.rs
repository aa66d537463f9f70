//! Rings of a disk, a square and an annulus.

use super::*;
use crate::flatten::Chart;
use crate::geometry::DVec3;
use crate::level_set::LevelSetError;
use crate::mesh::{Connectivity, VertexId};
use crate::outline::signed_area;
use crate::surface::Surface;

/// A flat plate of squares of side `h`, cut down to where `keep` holds at the centre.
fn plate(n: usize, h: f64, keep: impl Fn(DVec2) -> bool) -> (Surface, Chart) {
    let at = |i: usize, j: usize| DVec2::new(i as f64, j as f64) * h;
    let mut faces = Vec::new();
    for i in 0..n {
        for j in 0..n {
            if keep((at(i, j) + at(i + 1, j + 1)) * 0.5) {
                let v = |i: usize, j: usize| VertexId((i * (n + 1) + j) as u32);
                faces.push([v(i, j), v(i + 1, j), v(i + 1, j + 1)]);
                faces.push([v(i, j), v(i + 1, j + 1), v(i, j + 1)]);
            }
        }
    }
    let uv: Vec<_> = (0..=n).flat_map(|i| (0..=n).map(move |j| at(i, j))).collect();
    let positions: Vec<_> = uv.iter().map(|p| DVec3::new(p.x, p.y, 0.0)).collect();
    let surface = Surface::new(Connectivity::new(uv.len(), faces).unwrap(), positions);
    let chart = Chart::new(&surface, uv);
    (surface, chart)
}

fn pass_mesh(surface: &Surface, chart: &Chart, step: f64) -> PassMesh {
    let m = 1.0 / (step * step);
    let metric = vec![[m, m, m, 0.0, 0.0, 0.0]; chart.uv().len()];
    PassMesh::new(surface, chart, metric).unwrap()
}

fn rings(mesh: &PassMesh, field: &PassField) -> Vec<Pass> {
    passes(mesh, field, &ring_levels(field))
}

#[test]
fn rings_of_a_square_are_squares() {
    let (surface, chart) = plate(20, 1.0, |_| true);
    let mesh = pass_mesh(&surface, &chart, 1.0);
    let rings = rings(&mesh, &PassField::from_boundary(&mesh));
    let whole: Vec<_> = rings.iter().collect();
    assert_eq!(whole.len(), 10);
    for (k, ring) in whole.iter().enumerate() {
        let side = 20.0 - 2.0 * k as f64;
        // Higher values on the right: clockwise.
        let area = -signed_area(&ring.points);
        assert!((area / (side * side) - 1.0).abs() < 0.02, "ring {k}: {area}");
    }
}

#[test]
fn inset_rings_start_a_radius_inside() {
    let (surface, chart) = plate(30, 1.0, |_| true);
    let mesh = pass_mesh(&surface, &chart, 2.0);
    let clear = |radius: f64| -> Vec<f64> {
        let to_edge = |p: &DVec2| p.min(DVec2::splat(30.0) - *p).min_element();
        mesh.uv().iter().map(|p| to_edge(p) - radius).collect()
    };
    let field = PassField::from_clearance(&mesh, &clear(3.3), 3.3).unwrap();
    let rings = rings(&mesh, &field);
    for (k, ring) in rings.iter().enumerate() {
        let side = 30.0 - 6.6 - 4.0 * k as f64;
        let area = -signed_area(&ring.points);
        assert!((area.sqrt() - side).abs() < 0.25, "ring {k}: {area} {}", side * side);
    }
    let too_large = PassField::from_clearance(&mesh, &clear(15.1), 15.1);
    assert!(matches!(too_large, Err(LevelSetError::NoRoom { .. })));
}

/// On a disk the field is the radius minus the distance from the centre, up to the staircase of
/// the plate's edge.
#[test]
fn rings_of_a_disk_are_circles() {
    let n = 120;
    let centre = DVec2::splat(30.0);
    let (surface, chart) = plate(n, 0.5, |p| (p - centre).length() < 29.0);
    let mesh = pass_mesh(&surface, &chart, 2.0);
    let field = PassField::from_boundary(&mesh);
    for ring in rings(&mesh, &field).iter().filter(|r| r.level > 5.0) {
        let radii = || ring.points.iter().map(|p| (*p - centre).length());
        let (low, high) = (radii().fold(f64::MAX, f64::min), radii().fold(0.0, f64::max));
        assert!(high - low < 0.5, "level {}: {low} {high}", ring.level);
    }
}

/// Area and boundary stay, most vertices go; rings are as long.
#[test]
fn thinned_mesh_covers_the_same_plane() {
    let (surface, chart) = plate(80, 0.5, |p| p.distance(DVec2::splat(22.0)) > 6.0);
    let mesh = pass_mesh(&surface, &chart, 1.0);
    let thin = mesh.thinned(400);
    let area = |m: &PassMesh| -> f64 {
        let corners = m.connectivity().faces().iter().map(|f| f.map(|v| m.uv()[v.index()]));
        corners.map(|[a, b, c]| 0.5 * (b - a).perp_dot(c - a)).sum()
    };
    assert!(thin.uv().len() < mesh.uv().len() / 6, "{} vertices", thin.uv().len());
    assert!((area(&thin) / area(&mesh) - 1.0).abs() < 1e-12);
    assert_eq!(thin.connectivity().boundary_loops().len(), 2);
    let length = |m: &PassMesh| PassField::from_boundary(m).length(m);
    let ratio = length(&thin) / length(&mesh);
    assert!((ratio - 1.0).abs() < 0.02, "{ratio}");
}

#[test]
fn annulus_has_rings_from_both_sides() {
    let centre = DVec2::splat(15.0);
    let (surface, chart) =
        plate(30, 1.0, |p| (p - centre).length() < 14.0 && (p - centre).abs().max_element() > 4.0);
    let mesh = pass_mesh(&surface, &chart, 2.0);
    let field = PassField::from_boundary(&mesh);
    let rings = rings(&mesh, &field);
    let first: Vec<_> = rings.iter().filter(|r| r.level == INSIDE).collect();
    assert_eq!(first.len(), 2);
    let areas = first.iter().map(|r| signed_area(&r.points));
    assert!(areas.clone().any(|a| a > 0.0) && areas.clone().any(|a| a < 0.0));
}

/// A square's field is the distance to the nearest side, to 1e-3 passes away from the ridges.
#[test]
fn planar_fronts_are_close() {
    let (surface, chart) = plate(24, 1.0, |_| true);
    let mesh = pass_mesh(&surface, &chart, 3.0);
    let field = PassField::from_boundary(&mesh);
    for (p, v) in mesh.uv().iter().zip(field.values()) {
        let mut sides = [p.x, p.y, 24.0 - p.x, 24.0 - p.y];
        sides.sort_by(f64::total_cmp);
        // Within an edge of a ridge the two fronts blur.
        let slack = if sides[1] - sides[0] < 1.5 { 0.12 } else { 1e-3 };
        assert!((v - sides[0] / 3.0).abs() < slack, "{p}: {v} {}", sides[0] / 3.0);
    }
}
