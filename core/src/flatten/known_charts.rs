//! Both methods against surfaces whose conformal chart is known in closed form.

use std::f64::consts::FRAC_PI_3;

use super::samples;
use super::{Chart, FlattenError, abf, bff, outer_loop};
use crate::geometry::math::{cos, sin};
use crate::geometry::{DMat3, DVec2, DVec3, cross2};
use crate::mesh::{Connectivity, FaceId, VertexId};
use crate::surface::Surface;

fn both(surface: &Surface) -> [Chart; 2] {
    [bff(surface).unwrap(), abf(surface).unwrap().chart]
}

fn assert_isometric(surface: &Surface) {
    for chart in both(surface) {
        for f in 0..surface.connectivity().face_count() as u32 {
            let d = chart.distortion(surface, FaceId(f));
            assert!(d.q() - 1.0 < 1e-6 && (d.s() - 1.0).abs() < 1e-6, "face {f}: {d:?}");
        }
    }
}

#[test]
fn planes_keep_their_shape() {
    assert_isometric(&samples::sheared_plane(20, 0.0));
    assert_isometric(&samples::sheared_plane(20, 6.0));
    assert_isometric(&samples::disk(12, |r, t| DVec3::new(r * cos(t), r * sin(t), 3.0)));
}

#[test]
fn cylinders_and_cones_unroll() {
    assert_isometric(&samples::rolled_sheet(24, 0.0));
    assert_isometric(&samples::rolled_sheet(24, 0.6));
}

#[test]
fn one_triangle_keeps_its_shape() {
    let corners = [DVec3::ZERO, DVec3::new(3.0, 0.0, 1.0), DVec3::new(0.0, 4.0, -1.0)];
    let faces = vec![[0, 1, 2].map(VertexId)];
    assert_isometric(&Surface::new(Connectivity::new(3, faces).unwrap(), corners.to_vec()));
}

/// A spherical cap of radius 50 mm over polar angles up to 60 degrees.
fn cap(rings: u32) -> Surface {
    samples::disk(rings, |r, t| {
        let polar = FRAC_PI_3 * r;
        50.0 * DVec3::new(sin(polar) * cos(t), sin(polar) * sin(t), cos(polar))
    })
}

/// Largest relative error of a chart's scale against the stereographic projection's, which is
/// proportional to `cos^2(polar / 2)`.
fn stereographic_error(surface: &Surface, chart: &Chart) -> f64 {
    let exact = |p: DVec3| 0.5 * (1.0 + p.z / 50.0);
    let ratio = |v: usize| chart.vertex_scale()[v] / exact(surface.positions()[v]);
    let inside = |v: &usize| !surface.connectivity().is_boundary(VertexId(*v as u32)) && *v > 0;
    let (mut low, mut high) = (f64::INFINITY, 0.0f64);
    for v in (0..surface.positions().len()).filter(inside) {
        low = low.min(ratio(v));
        high = high.max(ratio(v));
    }
    high / low - 1.0
}

#[test]
fn sphere_cap_scales_as_stereographic_projection() {
    let error = |rings: u32| {
        let surface = cap(rings);
        stereographic_error(&surface, &bff(&surface).unwrap())
    };
    let (coarse, fine) = (error(10), error(20));
    assert!(fine < 0.01 && fine < 0.6 * coarse, "{coarse} {fine}");
}

#[test]
fn sphere_cap_becomes_conformal_under_refinement() {
    for k in 0..2 {
        let excess = |rings: u32| {
            let surface = cap(rings);
            both(&surface)[k].quality(&surface).mean_q - 1.0
        };
        let (coarse, fine) = (excess(10), excess(20));
        assert!(fine < 0.02 && fine < 0.6 * coarse, "method {k}: {coarse} {fine}");
    }
}

#[test]
fn steep_spike_is_flattened_without_flips() {
    // The apex angles sum to about 1.2 rad and must open to 2 pi.
    let spike = samples::disk(20, |r, t| DVec3::new(r * cos(t), r * sin(t), 5.0 * (1.0 - r)));
    for chart in both(&spike) {
        let quality = chart.quality(&spike);
        assert!(quality.flips == 0 && quality.mean_q < 1.3, "{quality:?}");
    }
}

#[test]
fn numbering_of_vertices_does_not_matter() {
    let shape = |x: f64, y: f64| DVec3::new(x, y, 0.2 * sin(5.0 * x) * y);
    let surface = samples::grid(18, shape);
    let n = surface.positions().len();
    let renumbered = |v: VertexId| VertexId((v.index() * 7 % n) as u32);
    let mut positions = surface.positions().to_vec();
    for (v, p) in surface.positions().iter().enumerate() {
        positions[renumbered(VertexId(v as u32)).index()] = *p;
    }
    let reversed = surface.connectivity().faces().iter().rev();
    let faces = reversed.map(|f| [f[1], f[2], f[0]].map(renumbered)).collect();
    let other = Surface::new(Connectivity::new(n, faces).unwrap(), positions);
    for (a, b) in both(&surface).iter().zip(&both(&other)) {
        for v in 0..n {
            let scale = b.vertex_scale()[renumbered(VertexId(v as u32)).index()];
            assert!((a.vertex_scale()[v] - scale).abs() < 1e-9);
        }
    }
}

#[test]
fn least_distortion_keeps_the_boundary_scale_constant() {
    let surface = samples::grid(30, |x, y| DVec3::new(x, y, 0.3 * x * y));
    let chart = bff(&surface).unwrap();
    let rim = outer_loop(&surface).unwrap();
    let stretch = |i: usize| {
        let (a, b) = (rim[i].index(), rim[(i + 1) % rim.len()].index());
        let flat = chart.uv()[a].distance(chart.uv()[b]);
        flat / surface.positions()[a].distance(surface.positions()[b])
    };
    let all: Vec<f64> = (0..rim.len()).map(stretch).collect();
    let (low, high) = all.iter().fold((f64::MAX, 0.0f64), |(l, h), &s| (l.min(s), h.max(s)));
    assert!(high / low < 1.005, "{low} {high}");
}

#[test]
fn moving_the_part_changes_no_angle_and_area_is_kept() {
    let shape = |x: f64, y: f64| DVec3::new(40.0 * x, 40.0 * y, 8.0 * sin(4.0 * x) * cos(3.0 * y));
    let turn = DMat3::from_axis_angle(DVec3::new(0.6, 0.0, 0.8), 1.1);
    let still = samples::grid(16, shape);
    let moved = samples::grid(16, |x, y| turn * shape(x, y) + DVec3::new(300.0, -20.0, 7.0));
    for (a, b) in both(&still).iter().zip(&both(&moved)) {
        let flat: f64 = still
            .connectivity()
            .faces()
            .iter()
            .map(|f| f.map(|v| a.uv()[v.index()]))
            .map(|[p, q, r]| 0.5 * cross2(p, q, r))
            .sum();
        assert!((flat / still.area() - 1.0).abs() < 1e-12);
        for (s, t) in a.vertex_scale().iter().zip(b.vertex_scale()) {
            assert!((s - t).abs() < 1e-9);
        }
    }
}

/// A square plate with a square hole, bent by `bend`.
fn plate_with_hole(bend: f64) -> Surface {
    let full = samples::grid(12, |x, y| DVec3::new(x, y, bend * (x * x - y * y)));
    let hole = |p: DVec3| (p.x - 0.5).abs() < 0.2 && (p.y - 0.5).abs() < 0.2;
    let positions = full.positions().to_vec();
    let faces: Vec<_> = full
        .connectivity()
        .faces()
        .iter()
        .filter(|f| !hole(f.map(|v| positions[v.index()]).iter().sum::<DVec3>() / 3.0))
        .copied()
        .collect();
    Surface::new(Connectivity::new(positions.len(), faces).unwrap(), positions)
}

#[test]
fn holes_stay_holes() {
    assert_isometric(&plate_with_hole(0.0));
    let surface = plate_with_hole(0.3);
    assert_eq!(surface.connectivity().boundary_loops().len(), 2);
    assert_eq!(outer_loop(&surface).unwrap().len(), 48);
    for chart in both(&surface) {
        assert_eq!(chart.uv().len(), surface.positions().len());
        assert!(chart.quality(&surface).mean_q < 1.05);
    }
}

#[test]
fn closed_surfaces_and_flat_faces_are_refused() {
    let corners = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z].to_vec();
    let tetrahedron = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]].map(|f| f.map(VertexId));
    let closed = Surface::new(Connectivity::new(4, tetrahedron.to_vec()).unwrap(), corners.clone());
    let fault = bff(&closed).unwrap_err();
    assert_eq!(fault, FlattenError::NotADisk { loops: 0, chi: 2 });
    assert!(fault.to_string().contains("0 boundary loops, Euler characteristic 2"));

    let line = [DVec3::ZERO, DVec3::X, 2.0 * DVec3::X].to_vec();
    let sliver = Surface::new(Connectivity::new(3, vec![[0, 1, 2].map(VertexId)]).unwrap(), line);
    assert!(matches!(abf(&sliver), Err(FlattenError::Degenerate { face: 0, .. })));
    assert_eq!(Chart::new(&sliver, vec![DVec2::ZERO, DVec2::X, DVec2::Y]).uv().len(), 3);
}
