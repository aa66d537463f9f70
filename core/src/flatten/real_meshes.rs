//! Both methods on real parts; skipped where the data is not present.

use super::{Chart, abf, bff};
use crate::geometry::math::atan2;
use crate::geometry::{DVec2, DVec3};
use crate::job::{Faces, Selection, SurfaceOptions, SurfaceSource};
use crate::mesh::{MeshFormat, read};
use crate::surface::{Built, Surface, build};

/// The mesh of a file and its texture coordinates, `None` where the data is not present.
fn load(name: &str) -> Option<(Surface, Vec<[DVec2; 3]>)> {
    let bytes = std::fs::read(crate::shared_data::shared_data("")?.join(name)).unwrap();
    let as_it_is = SurfaceOptions {
        source: SurfaceSource::File(name.to_owned()),
        scale: 1.0,
        rotate: DVec3::ZERO,
        translate: DVec3::ZERO,
        select: Selection::default(),
        curvature_radius: None,
        steepest: None,
        flip: false,
        face: Faces::Only,
        chord: None,
    };
    let soup = read(&bytes, MeshFormat::from_name(name).unwrap()).unwrap();
    let Built { surface, texture, .. } = build(soup, &as_it_is).unwrap();
    Some((surface, texture.unwrap_or_default()))
}

fn flat_angles(p: [DVec2; 3]) -> [f64; 3] {
    [0, 1, 2].map(|c| {
        let (u, v) = (p[(c + 1) % 3] - p[c], p[(c + 2) % 3] - p[c]);
        atan2(u.perp_dot(v), u.dot(v))
    })
}

/// RMS difference in degrees between the corner angles of a chart and of the given flat faces.
fn angle_rms(surface: &Surface, chart: &Chart, exact: &[[DVec2; 3]]) -> f64 {
    let mut sum = 0.0;
    for (face, exact) in surface.connectivity().faces().iter().zip(exact) {
        let ours = flat_angles(face.map(|v| chart.uv()[v.index()]));
        // The exact chart may be the mirror image.
        let theirs = flat_angles(*exact).map(f64::abs);
        sum += (0..3).map(|c| (ours[c] - theirs[c]).powi(2)).sum::<f64>();
    }
    (sum / (3 * exact.len()) as f64).sqrt().to_degrees()
}

#[test]
fn hub_passages_match_their_exact_chart() {
    for name in ["hecc_hub_passage_fine", "hecc_hub_passage_splitter_fine"] {
        let Some((surface, exact)) = load(&format!("mesh/{name}.obj")) else { return };
        for chart in [bff(&surface).unwrap(), abf(&surface).unwrap().chart] {
            let rms = angle_rms(&surface, &chart, &exact);
            assert!(rms < 0.5, "{name}: {rms} degrees");
        }
    }
}

/// Freeform parts, heads with deep features, and surfaces with 1 to 26 holes.
const PARTS: [(&str, f64); 14] = [
    ("mesh/cowhead.ply", 1.060),
    ("mesh/camelhead.off", 1.076),
    ("mesh/mask_face.ply", 1.029),
    ("mesh/demosthenes.obj", 1.069),
    ("mesh/hemisphere.obj", 1.022),
    ("mesh/hood_panel_120k.ply", 1.0001),
    ("mesh/aorta.stl", 1.11),
    ("mesh/train_station.off", 1.038),
    ("nurbs/teapot_patch16_fine.ply", 1.007),
    ("mesh/lilium.obj", 1.013),
    ("mesh/botanic_garden.off", 1.022),
    ("mesh/mountain.ply", 1.015),
    ("mesh/plane_26holes.obj", 1.161),
    ("mesh/capsule_2holes.off", 1.31),
];

#[test]
fn parts_flatten_without_flips_or_overlap() {
    for (name, most) in PARTS {
        let Some((surface, _)) = load(name) else { return };
        let angle_based = abf(&surface).unwrap();
        assert!(angle_based.residual < 1e-8, "{name}: {}", angle_based.residual);
        for chart in [bff(&surface).unwrap(), angle_based.chart] {
            let quality = chart.quality(&surface);
            assert!(quality.flips == 0 && quality.mean_q < most, "{name}: {quality:?}");
        }
    }
}

#[test]
fn flat_points_keep_the_solved_angles() {
    let Some((surface, _)) = load("mesh/camelhead.off") else { return };
    let result = abf(&surface).unwrap();
    for (face, solved) in surface.connectivity().faces().iter().zip(&result.angles) {
        let flat = flat_angles(face.map(|v| result.chart.uv()[v.index()]));
        (0..3).for_each(|c| assert!((flat[c] - solved[c]).abs() < 1e-6));
    }
}

#[test]
fn face_centres_are_located_on_a_chart_of_uneven_scale() {
    let Some((surface, _)) = load("mesh/cowhead.ply") else { return };
    let chart = bff(&surface).unwrap();
    let locator = chart.locator(&surface);
    for (f, face) in surface.connectivity().faces().iter().enumerate() {
        let [a, b, c] = face.map(|v| chart.uv()[v.index()]);
        assert_eq!(locator.locate((a + b + c) / 3.0).unwrap().face.index(), f);
    }
}
