//! Surfaces of the shared data against their stated figures; skipped where it is not present.

use std::path::PathBuf;

use super::*;
use crate::geometry::math::acos_clamped;
use crate::geometry::{DVec2, DVec3};
use crate::mesh::{judge, repair};

fn shared() -> Option<PathBuf> {
    crate::shared_data::shared_data("nurbs")
}

/// Smallest angles of all triangles, degrees, in increasing order.
fn angles(mesh: &NurbsMesh) -> Vec<f64> {
    let at = |v: u32| mesh.soup.positions[v as usize];
    let least = |f: &[u32; 3]| {
        (0..3)
            .map(|i| {
                let (p, q, r) = (at(f[i]), at(f[(i + 1) % 3]), at(f[(i + 2) % 3]));
                acos_clamped((q - p).normalize_or_zero().dot((r - p).normalize_or_zero()))
            })
            .fold(f64::INFINITY, f64::min)
            .to_degrees()
    };
    let mut all: Vec<f64> = mesh.soup.faces.iter().map(least).collect();
    all.sort_by(f64::total_cmp);
    all
}

/// Faces whose height is lost in rounding.
fn without_area(mesh: &NurbsMesh) -> usize {
    let at = |v: u32| mesh.soup.positions[v as usize];
    let flat = |f: &&[u32; 3]| {
        let (a, b, c) = (at(f[1]) - at(f[0]), at(f[2]) - at(f[1]), at(f[0]) - at(f[2]));
        let longest = a.length_squared().max(b.length_squared()).max(c.length_squared());
        a.cross(b).length() <= 1e-9 * longest
    };
    mesh.soup.faces.iter().filter(flat).count()
}

#[test]
fn a_blade_within_a_micrometre_takes_long_triangles() {
    let Some(folder) = shared() else { return };
    for (name, chord, most) in [
        ("e3_hpt_rotor1_side", 0.001, 60_000),
        ("hecc_main_blade", 0.00125, 150_000),
        ("surf114_half", 0.004, 80_000),
    ] {
        let file = read_json(&std::fs::read(folder.join(name).with_extension("json")).unwrap());
        let surface = file.unwrap().surface;
        let (low, high) = surface.domain();
        let options = MeshOptions { chord, ..MeshOptions::default() };
        let began = std::time::Instant::now();
        let mesh = mesh(&surface, Trim::Rectangle(low, high), options).unwrap();
        let (faces, angles) = (mesh.soup.faces.len(), angles(&mesh));
        println!("{name} {faces} {} {} {:?}", angles[faces / 100], angles[0], began.elapsed());
        assert!(faces < most && mesh.chord_error <= chord, "{name}: {faces}");
        assert!(angles[faces / 100] > 15.0 && angles[0] > 1.0, "{name}: {}", angles[0]);
    }
}

fn area(mesh: &NurbsMesh) -> f64 {
    let at = |v: u32| mesh.soup.positions[v as usize];
    mesh.soup
        .faces
        .iter()
        .map(|f| 0.5 * (at(f[1]) - at(f[0])).cross(at(f[2]) - at(f[0])).length())
        .sum()
}

/// Area and integral of |K| by Gauss's rule on pieces of every knot span.
fn exact(surface: &NurbsSurface, low: DVec2, high: DVec2) -> (f64, f64) {
    const RULE: [(f64, f64); 4] = [
        (0.069_431_844_202_973_71, 0.173_927_422_568_726_93),
        (0.330_009_478_207_571_87, 0.326_072_577_431_273_07),
        (0.669_990_521_792_428_1, 0.326_072_577_431_273_07),
        (0.930_568_155_797_026_3, 0.173_927_422_568_726_93),
    ];
    let nodes = |axis: usize| {
        let inner = surface.breaks(axis).into_iter().map(|b| b.0);
        let inner = inner.filter(|&k| k > low[axis] && k < high[axis]);
        let breaks: Vec<f64> =
            std::iter::once(low[axis]).chain(inner).chain([high[axis]]).collect();
        let parts = (64 / breaks.len()).max(2);
        let mut nodes = Vec::new();
        for pair in breaks.windows(2) {
            let step = (pair[1] - pair[0]) / parts as f64;
            for k in 0..parts {
                nodes.extend(RULE.map(|(x, w)| (pair[0] + step * (k as f64 + x), w * step)));
            }
        }
        nodes
    };
    let (us, vs) = (nodes(0), nodes(1));
    let (mut area, mut curvature) = (0.0, 0.0);
    for &(u, wu) in &us {
        for &(v, wv) in &vs {
            let at = DVec2::new(u, v);
            let [su, sv] = surface.jet(at).first;
            let part = wu * wv * su.cross(sv).length();
            area += part;
            curvature += part * surface.shape(at).map_or(0.0, |s| s.gaussian().abs());
        }
    }
    (area, curvature)
}

/// Integral of |K| over the triangles, from exact values at their middles.
fn total_curvature(mesh: &NurbsMesh, surface: &NurbsSurface) -> f64 {
    let at = |v: u32| mesh.soup.positions[v as usize];
    let texture = mesh.soup.texture.as_ref().unwrap();
    let part = |(f, c): (&[u32; 3], &[DVec2; 3])| {
        let area = 0.5 * (at(f[1]) - at(f[0])).cross(at(f[2]) - at(f[0])).length();
        area * surface.shape((c[0] + c[1] + c[2]) / 3.0).map_or(0.0, |s| s.gaussian().abs())
    };
    mesh.soup.faces.iter().zip(texture).map(part).sum()
}

/// A wavy rational surface of degree 3 x 2.
fn wavy() -> NurbsSurface {
    let at = |i: usize, j: usize| {
        let (x, y) = (i as f64, j as f64);
        DVec3::new(10.0 * x + y, 12.0 * y - 0.5 * x, 3.0 * ((i * j + i) % 4) as f64)
    };
    NurbsSurface::new(NurbsParts {
        degree: [3, 2],
        knots: [
            vec![0.0, 0.0, 0.0, 0.0, 0.3, 0.7, 1.0, 1.0, 1.0, 1.0],
            vec![0.0, 0.0, 0.0, 1.0, 2.0, 2.0, 2.0],
        ],
        points: (0..6).map(|i| (0..4).map(|j| at(i, j)).collect()).collect(),
        weights: (0..6)
            .map(|i| (0..4).map(|j| 1.0 + 0.3 * ((i + 2 * j) % 3) as f64).collect())
            .collect(),
    })
    .unwrap()
}

#[test]
fn derivatives_agree_with_differences() {
    let (surface, h) = (wavy(), 1e-4);
    for (u, v) in [(0.11, 0.2), (0.5, 1.3), (0.9, 1.9), (0.31, 0.99)] {
        let at = DVec2::new(u, v);
        let jet = surface.jet(at);
        assert!((jet.point - surface.point(at)).length() < 1e-12);
        let p = |i: f64, j: f64| surface.point(at + h * DVec2::new(i, j));
        let first =
            [(p(1.0, 0.0) - p(-1.0, 0.0)) / (2.0 * h), (p(0.0, 1.0) - p(0.0, -1.0)) / (2.0 * h)];
        let second = [
            (p(1.0, 0.0) - 2.0 * p(0.0, 0.0) + p(-1.0, 0.0)) / (h * h),
            (p(1.0, 1.0) - p(1.0, -1.0) - p(-1.0, 1.0) + p(-1.0, -1.0)) / (4.0 * h * h),
            (p(0.0, 1.0) - 2.0 * p(0.0, 0.0) + p(0.0, -1.0)) / (h * h),
        ];
        assert!(jet.first.iter().zip(first).all(|(a, b)| (*a - b).length() < 1e-4), "{jet:?}");
        assert!(jet.second.iter().zip(second).all(|(a, b)| (*a - b).length() < 1e-3), "{jet:?}");
    }
}

#[test]
fn points_beside_the_surface_are_projected_back() {
    let surface = wavy();
    for (u, v) in [(0.2, 0.3), (0.55, 1.4), (0.8, 0.9)] {
        let at = DVec2::new(u, v);
        let target = surface.point(at) + surface.normal(at) * 0.2;
        let (found, distance) = surface.project(target, at + DVec2::new(0.02, -0.05));
        assert!(
            (found - at).length() < 1e-7 && (distance - 0.2).abs() < 1e-9,
            "{found} {distance}"
        );
    }
}

#[test]
fn surfaces_of_revolution_have_the_curvature_of_their_formulas() {
    let x = DVec3::X;
    type Curvatures = fn(DVec3) -> [f64; 2];
    let cases: [(NurbsSurface, Curvatures); 3] = [
        (
            NurbsCurve::half_circle(DVec3::ZERO, -5.0 * DVec3::Z, 5.0 * x)
                .unwrap()
                .revolved(DVec3::ZERO, DVec3::Z)
                .unwrap(),
            |_| [0.2, 0.2],
        ),
        (
            NurbsCurve::line(4.0 * x, 4.0 * x + 7.0 * DVec3::Z)
                .unwrap()
                .revolved(DVec3::ZERO, DVec3::Z)
                .unwrap(),
            |_| [0.0, 0.25],
        ),
        (
            NurbsCurve::ellipse(10.0 * x, 3.0 * x, 3.0 * DVec3::Z)
                .unwrap()
                .revolved(DVec3::ZERO, DVec3::Z)
                .unwrap(),
            |p| {
                let r = p.truncate().length();
                let other = (r - 10.0) / (3.0 * r);
                [other, 1.0 / 3.0]
            },
        ),
    ];
    for (surface, expected) in cases {
        let (low, high) = surface.domain();
        for k in 1..40 {
            let part = DVec2::new(f64::from(k) / 40.0, f64::from((7 * k) % 40) / 40.0);
            let at = low + (high - low) * part;
            let Some(shape) = surface.shape(at) else { continue };
            let (least, most, _) = shape.principal();
            let [a, b] = expected(surface.point(at));
            assert!(
                (least - a).abs() < 1e-11 && (most - b).abs() < 1e-11,
                "{least} {most} {a} {b}"
            );
        }
    }
}

#[test]
fn a_cap_around_a_pole_is_a_disk() {
    let sphere = NurbsCurve::half_circle(DVec3::ZERO, -5.0 * DVec3::Z, 5.0 * DVec3::X).unwrap();
    let sphere = sphere.revolved(DVec3::ZERO, DVec3::Z).unwrap();
    let (low, high) = sphere.domain();
    let trim = Trim::Rectangle(DVec2::new(low.x, 0.5 * (low.y + high.y)), high);
    let made = mesh(&sphere, trim, MeshOptions::default()).unwrap();
    let judged = judge(&made.soup.positions, &made.soup.faces);
    assert_eq!((judged.euler, judged.boundary_loops.len()), (1, 1));
    assert!((area(&made) / (50.0 * std::f64::consts::PI) - 1.0).abs() < 2e-3);
    assert!(angles(&made)[0] > 20.0, "{:?}", &angles(&made)[..3]);
}

#[test]
fn closed_surfaces_are_meshed_whole() {
    let sphere = NurbsCurve::half_circle(DVec3::ZERO, -5.0 * DVec3::Z, 5.0 * DVec3::X).unwrap();
    let sphere = sphere.revolved(DVec3::ZERO, DVec3::Z).unwrap();
    let way = [(1, 0), (1, 1), (0, 1), (-1, 1), (-1, 0), (-1, -1), (0, -1), (1, -1), (1, 0)];
    let corner = |(x, z): (i32, i32)| {
        let weight = if x * z == 0 { 1.0 } else { 0.5_f64.sqrt() };
        (DVec3::new(6.0 + 2.0 * f64::from(x), 0.0, 2.0 * f64::from(z)), weight)
    };
    let knots = [0, 0, 0, 1, 1, 2, 2, 3, 3, 4, 4, 4].map(f64::from).to_vec();
    let tube = NurbsCurve::new(2, knots, way.map(corner).to_vec()).unwrap();
    let ring = tube.revolved(DVec3::ZERO, DVec3::Z).unwrap();
    let pi = std::f64::consts::PI;
    // A sphere of radius 5, and a torus of radii 6 and 2.
    for (surface, exact, euler) in [(sphere, 100.0 * pi, 2), (ring, 48.0 * pi * pi, 0)] {
        let (low, high) = surface.domain();
        for trim in [Trim::Rectangle(low, high), Trim::Loops(Vec::new())] {
            let made = mesh(&surface, trim, MeshOptions::default()).unwrap();
            assert!((area(&made) / exact - 1.0).abs() < 2e-3, "{} {exact}", area(&made));
            assert!(made.chord_error <= 0.01);
            let welded = repair(made.soup).mesh;
            let judged = judge(&welded.positions, &welded.faces);
            assert_eq!((judged.euler, judged.components.len()), (euler, 1));
        }
    }
}

#[test]
fn json_faults_name_their_place() {
    let good = r#"{"degree_u":1,"degree_v":1,"knots_u":[0,0,1,1],"knots_v":[0,0,1,1],
        "control_points":[[[0,0,0],[0,1,0]],[[1,0,0],[1,1,0]]]}"#;
    assert!(read_json(good.as_bytes()).is_ok());
    let cases = [
        ("[[1,0,0],[1,1,0]]", "[[1,0,0]]", "control_points[1]: 1 points; expected 2"),
        ("[1,1,0]]]", "[1,1]]]", "control_points[1][1]: found an array of 2 items"),
        ("[1,1,0]]]", "[1,1,1e13]]]", "control_points[1][1]"),
        ("\"knots_u\":[0,0,1,1]", "\"knots_u\":[0,1,0,1]", "knots_u[2] = 0 after 1"),
        ("\"knots_u\":[0,0,1,1]", "\"knots_u\":[0,0,1]", "3 knots; expected 4"),
        ("\"knots_v\":[0,0,1,1]", "\"knots_v\":[0,0,\"a\",1]", "knots_v[2]"),
        ("\"degree_u\":1", "\"degree_u\":1e9", "degree_u"),
        ("\"degree_u\":1", "\"degree_u\":900000000", "degree_u = 900000000"),
        ("\"degree_v\":1,", "", "degree_v: found nothing"),
        (
            "\"degree_u\"",
            "\"weights\":[[1,-1],[1,1]],\"degree_u\"",
            "weight of control_points[0][1] is -1",
        ),
        ("\"degree_u\"", "\"trim_domain\":[0,2,0,1],\"degree_u\"", "trim_domain"),
        ("]]]}", "", "not JSON"),
    ];
    for (from, to, expected) in cases {
        assert!(good.contains(from), "{from}");
        let message = read_json(good.replace(from, to).as_bytes()).unwrap_err().to_string();
        assert!(message.contains(expected), "{message}");
    }
}

#[test]
fn surfaces_of_the_manifest_mesh_within_their_chord_error() {
    let Some(folder) = shared() else { return };
    let mut names: Vec<_> = std::fs::read_dir(&folder)
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.extension().is_some_and(|e| e == "json"))
        .collect();
    names.sort();
    assert!(names.len() >= 20);
    println!(
        "{:24} {:>8} {:>10} {:>10} {:>9} {:>9} {:>8} {:>6} {:>6} {:>4} {:>5}",
        "surface",
        "faces",
        "chord",
        "measured",
        "area/ref",
        "|K|",
        "ref",
        "1 %",
        "least",
        "chi",
        "loops"
    );
    for path in names {
        let bytes = std::fs::read(&path).unwrap();
        let file = read_json(&bytes).unwrap();
        let value: serde_json::Value = serde_json::from_slice(&bytes).unwrap();
        let (low, high) = file.trim.unwrap_or(file.surface.domain());
        let chord = 5e-4 * file.surface.size();
        let options = MeshOptions { chord, ..MeshOptions::default() };
        let name = path.file_stem().unwrap().to_string_lossy().into_owned();
        let made = mesh(&file.surface, Trim::Rectangle(low, high), options);
        let mesh = made.unwrap_or_else(|error| panic!("{name}: {error}"));
        let stats = &value["curvature_stats"];
        let angles = angles(&mesh);
        let judged = judge(&mesh.soup.positions, &mesh.soup.faces);
        let (area_exact, curvature_exact) = exact(&file.surface, low, high);
        println!(
            "{name:24} {:>8} {chord:>10.5} {:>10.5} {:>9.5} {:>9.5} {:>8.4} {:>8.4} {:>8.4} {:>6.1} {:>6.1} {:>4} {:>5}",
            mesh.soup.faces.len(),
            mesh.chord_error,
            area(&mesh) / area_exact,
            area_exact / stats["area"].as_f64().unwrap(),
            total_curvature(&mesh, &file.surface),
            curvature_exact,
            stats["total_abs_K"].as_f64().unwrap(),
            angles[angles.len() / 100],
            angles[0],
            judged.euler,
            judged.boundary_loops.len(),
        );
        assert!(mesh.chord_error <= chord, "{name}");
        // The stated areas are sums over a grid and half a percent too large.
        assert!((area_exact / stats["area"].as_f64().unwrap() - 1.0).abs() < 0.02, "{name}");
        // The fit of that fillet rings at a sharp edge, and that bulb ends in two slits. The fillet
        // is the one surface left that is not meshed well: needles, some of them without area.
        let ringing = name == "hecc_main_blade_fillet";
        let singular = ringing || name == "surf114";
        assert!(ringing || (area(&mesh) / area_exact - 1.0).abs() < 2e-3, "{name}");
        assert!(singular || angles[angles.len() / 100] > 15.0, "{name}");
        assert!(ringing || without_area(&mesh) == 0, "{name}");
        let rings = file.surface.closed().iter().filter(|c| **c).count();
        // The egg, with two poles and a seam, is two halves, each with a boundary.
        assert_eq!(judged.boundary_loops.len(), 1 + rings, "{name}");
    }
}

#[test]
fn beyond_an_open_end_the_last_polynomials_go_on() {
    // A quarter of a circle stays on its circle.
    let half = 0.5_f64.sqrt();
    let points = [(DVec3::X, 1.0), (DVec3::X + DVec3::Y, half), (DVec3::Y, 1.0)];
    let arc = NurbsCurve::new(2, vec![0.0, 0.0, 0.0, 1.0, 1.0, 1.0], points.to_vec()).unwrap();
    let arc = arc.extruded(DVec3::ZERO, DVec3::Z).unwrap();
    let jet = arc.jet_beyond(DVec2::new(1.2, -0.5));
    assert!(jet.point.x < 0.0 && (jet.point.z + 0.5).abs() < 1e-15, "{}", jet.point);
    assert!((jet.point.truncate().length() - 1.0).abs() < 1e-14);
    assert!(jet.first[0].dot(jet.point.truncate().extend(0.0)).abs() < 1e-14);
    let surface = wavy();
    let inside = DVec2::new(0.4, 1.2);
    assert_eq!(surface.jet_beyond(inside), surface.jet(inside));
    assert_eq!(surface.point(DVec2::new(0.4, 2.5)), surface.point(DVec2::new(0.4, 2.0)));
}

#[test]
fn at_a_knot_the_way_decides_on_the_piece() {
    let surface = wavy();
    let knot = DVec2::new(0.3, 1.0);
    let after = surface.piece(knot, DVec2::ONE);
    let before = surface.piece(knot, -DVec2::ONE);
    assert_eq!((after.low, after.high), (knot, DVec2::new(0.7, f64::INFINITY)));
    assert_eq!((before.low, before.high), (DVec2::NEG_INFINITY, knot));
    // Degrees 3 and 2 with simple knots: second derivatives by v jump.
    let (a, b) = (surface.jet_in(&after, knot), surface.jet_in(&before, knot));
    assert!(a.point.distance(b.point) < 1e-12 && a.first[1].distance(b.first[1]) < 1e-11);
    assert!(a.second[0].distance(b.second[0]) < 1e-9 && a.second[2].distance(b.second[2]) > 0.1);
    // Around a closed direction the pieces go on.
    let ring = NurbsCurve::line(DVec3::Z, DVec3::Z + DVec3::X).unwrap();
    let ring = ring.revolved(DVec3::ZERO, DVec3::X).unwrap();
    let seam = DVec2::new(8.0, 0.5);
    let (after, before) = (ring.piece(seam, DVec2::X), ring.piece(seam, -DVec2::X));
    assert_eq!((after.low.x, after.high.x, before.low.x, before.high.x), (8.0, 9.0, 7.0, 8.0));
    assert!(ring.jet_in(&before, seam).point.distance(DVec3::new(0.5, 0.0, 1.0)) < 1e-14);
}
