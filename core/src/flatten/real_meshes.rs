//! Both methods on real parts; skipped where the data is not present.

use super::{Chart, abf, bff, unfolded};
use crate::geometry::math::atan2;
use crate::geometry::{DVec2, DVec3};
use crate::job::{Faces, Selection, SurfaceOptions, SurfaceSource};
use crate::mesh::{MeshFormat, TriangleSoup, read};
use crate::surface::{Built, Surface, build};
use std::collections::BTreeMap;

/// The mesh of a file and its texture coordinates, `None` where the data is not present.
fn load(name: &str) -> Option<(Surface, Vec<[DVec2; 3]>)> {
    let bytes = std::fs::read(crate::shared_data::shared_data("")?.join(name)).unwrap();
    let soup = read(&bytes, MeshFormat::from_name(name).unwrap()).unwrap();
    let Built { surface, texture, .. } = build(soup, &as_it_is(name)).unwrap();
    Some((surface, texture.unwrap_or_default()))
}

fn as_it_is(name: &str) -> SurfaceOptions {
    SurfaceOptions {
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
    }
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

/// Moves every vertex by up to `by` along each axis, mm; those at one place alike.
fn shake(soup: &mut TriangleSoup, by: f64) {
    let mut state = 12_345_u64;
    let mut draw = || {
        state =
            state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as f64 / f64::from(1u32 << 30) - 1.0
    };
    let mut moved = BTreeMap::new();
    for p in &mut soup.positions {
        let way = moved.entry(p.to_array().map(f64::to_bits));
        *p += *way.or_insert_with(|| by * DVec3::new(draw(), draw(), draw()));
    }
}

/// Every mesh of the shared data, as it is, with noise of a hundredth of its size, and of three tenths of an edge; of the
/// nasty ones those that are one manifold piece that can be laid flat.
#[test]
fn rough_and_nasty_surfaces_flatten_without_flips_or_overlap() {
    let Some(root) = crate::shared_data::shared_data("") else { return };
    let files = |folder: &str| std::fs::read_dir(root.join(folder)).unwrap();
    let name = |folder: &str, file: std::io::Result<std::fs::DirEntry>| {
        format!("{folder}/{}", file.unwrap().file_name().to_string_lossy())
    };
    let folders = ["mesh", "nurbs", "nasty"];
    let all = folders.iter().flat_map(|folder| files(folder).map(|file| name(folder, file)));
    let mut names: Vec<String> = all.collect();
    names.sort();
    let mut count = 0;
    for name in names {
        let Some(format) = MeshFormat::from_name(&name) else { continue };
        let bytes = std::fs::read(root.join(&name)).unwrap();
        let Ok(soup) = read(&bytes, format) else { continue };
        let Ok(Built { surface, .. }) = build(soup.clone(), &as_it_is(&name)) else { continue };
        let positions = surface.positions();
        let (low, high) = positions
            .iter()
            .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(l, h), &p| (l.min(p), h.max(p)));
        let faces = surface.connectivity().faces();
        let edge = |f: &[crate::mesh::VertexId; 3]| {
            positions[f[0].index()].distance(positions[f[1].index()])
        };
        let edge = faces.iter().map(edge).sum::<f64>() / faces.len() as f64;
        for by in [0.0, 0.01 * low.distance(high), 0.3 * edge] {
            let mut soup = soup.clone();
            shake(&mut soup, by);
            let Ok(Built { surface, .. }) = build(soup, &as_it_is(&name)) else { continue };
            if surface.connectivity().euler_characteristic()
                != 2 - surface.connectivity().boundary_loops().len() as i64
            {
                continue;
            }
            let chart = unfolded(&surface).unwrap_or_else(|e| panic!("{name}, {by} mm: {e}"));
            let quality = chart.quality(&surface);
            assert!(quality.flips == 0, "{name}, {by} mm: {quality:?}");
            count += 1;
        }
    }
    println!("{count} flat maps");
    assert!(count > 240, "{count}");
}
