//! Truths: surfaces whose umbilics are known in closed form.

use super::points::{crossings, turns_of_boundary};
use super::*;
use crate::flatten::bff;
use crate::flatten::samples::jitter;
use crate::geometry::DVec3;
use crate::geometry::math::atan2;
use crate::mesh::{Connectivity, TriangleSoup, VertexId};
use crate::surface::AnalyticSurface;

/// Effective curvature of a ball of 5 mm radius.
const BALL: f64 = 0.2;

fn surface(soup: TriangleSoup) -> Surface {
    let faces = soup.faces.iter().map(|f| f.map(VertexId)).collect();
    Surface::new(Connectivity::new(soup.positions.len(), faces).unwrap(), soup.positions)
}

/// Moves every vertex: every coordinate by at most `part` of the edge, which is also the root mean
/// square of the way.
fn noisy(mut soup: TriangleSoup, edge: f64, part: f64) -> TriangleSoup {
    // Numbers between -1/2 and 1/2.
    let amplitude = 2.0 * part * edge;
    for (i, p) in soup.positions.iter_mut().enumerate() {
        *p += DVec3::new(jitter(i, 11), jitter(i, 12), jitter(i, 13)) * amplitude;
    }
    soup
}

fn found(surface: &Surface) -> Topology {
    let chart = bff(surface).unwrap();
    let locator = chart.locator(surface);
    let curvature = surface.curvature(None);
    let options = TensorOptions::default();
    let (topology, field) = topology(surface, (&chart, &locator), &curvature, BALL, &options);
    let signs: i64 = crossings(&field).iter().map(|c| if c.delta > 0.0 { 1 } else { -1 }).sum();
    assert_eq!(signs, turns_of_boundary(&field), "indices do not add up");
    topology
}

fn print(name: &str, surface: &Surface, topology: &Topology) {
    println!(
        "{name}: {} faces, {} points, {} cancelled, {} doubtful, {} free, smoothing {:.3} mm",
        surface.connectivity().face_count(),
        topology.points.len(),
        topology.cancelled.len(),
        topology.doubtful,
        topology.free.len(),
        topology.smoothing
    );
}

/// Asserts that exactly the places `expected` are found, all of `kind`, within `part` of the size.
fn check(name: &str, surface: &Surface, expected: &[DVec3], kind: Kind, part: f64) -> Topology {
    let topology = found(surface);
    print(name, surface, &topology);
    let size = surface.area().sqrt();
    for at in expected {
        let nearest = topology
            .points
            .iter()
            .min_by(|a, b| a.place.distance(*at).total_cmp(&b.place.distance(*at)))
            .unwrap_or_else(|| panic!("{name}: nothing found"));
        let off = nearest.place.distance(*at) / size;
        println!("  {:?} off by {:.4} % of the size", nearest.kind, 100.0 * off);
        assert!(off <= part, "{name}: {} is not {at}", nearest.place);
        assert_eq!(nearest.kind, kind, "{name}");
    }
    assert_eq!(topology.points.len(), expected.len(), "{name}: {:#?}", topology.points);
    topology
}

/// Numbers of faces, and the edges that give them on an area of `area` mm².
fn meshes(area: f64) -> impl Iterator<Item = (f64, f64)> {
    [5e3, 20e3, 80e3].into_iter().map(move |n| (n, (4.0 * area / (n * 3f64.sqrt())).sqrt()))
}

#[test]
fn monkey_saddle_has_one_trisector() {
    let saddle = AnalyticSurface::MonkeySaddle { size: 40.0, height: 4.0 };
    for (n, edge) in meshes(1700.0) {
        for (noise, part) in [(0.0, 0.005), (0.01, 0.02)] {
            let mesh = surface(noisy(saddle.mesh(edge), edge, noise));
            let name = format!("monkey saddle {n} noise {noise}");
            let topology = check(&name, &mesh, &[DVec3::ZERO], Kind::Trisector, part);
            let cuts = topology.cuts();
            assert_eq!(cuts.len(), 3, "{name}: {:?}", topology.separatrices);
            let ends: Vec<End> = topology.separatrices.iter().map(|s| s.end).collect();
            assert!(ends.iter().all(|e| *e == End::Boundary), "{name}: {ends:?}");
        }
    }
}

/// The best feed follows the ridges: separatrices of the monkey saddle run along x and at 120 degrees.
#[test]
fn separatrices_of_the_monkey_saddle_are_its_ridges() {
    let saddle = AnalyticSurface::MonkeySaddle { size: 40.0, height: 1.0 };
    let mesh = surface(saddle.mesh(0.4));
    let chart = bff(&mesh).unwrap();
    let locator = chart.locator(&mesh);
    let curvature = mesh.curvature(None);
    let (topology, _) =
        topology(&mesh, (&chart, &locator), &curvature, BALL, &TensorOptions::default());
    for separatrix in &topology.separatrices {
        for at in &separatrix.line[1..separatrix.line.len() - 1] {
            let p = mesh.position(locator.locate(*at).unwrap());
            let angle = atan2(p.y, p.x);
            // z = x³ - 3 x y²: most convex along x at negative x, and every third of a turn.
            let third = core::f64::consts::TAU / 3.0;
            let off = angle - core::f64::consts::PI;
            let off = off - third * (off / third).round();
            let beside = p.truncate().length() * sin(off).abs();
            assert!(beside < 0.25, "{p} is {beside} mm beside the ridge");
        }
    }
}

/// Half axes of the ellipsoid.
const AXES: [f64; 3] = [30.0, 24.0, 18.0];

/// The ellipsoid without the cap around its -y end, by equal steps.
fn ellipsoid(edge: f64) -> TriangleSoup {
    let [a, b, c] = AXES;
    let most = 2.35;
    let rings = (most * 24.0 / edge).ceil() as usize;
    let (mut positions, mut faces) = (vec![DVec3::new(0.0, b, 0.0)], Vec::new());
    let count = |ring: usize| {
        let angle = most * ring as f64 / rings as f64;
        ((core::f64::consts::TAU * 24.0 * sin(angle) / edge).round() as u32).max(6)
    };
    let (mut before, mut n_before) = (0u32, 1u32);
    for ring in 1..=rings {
        let polar = most * ring as f64 / rings as f64;
        let (n, start) = (count(ring), positions.len() as u32);
        for i in 0..n {
            let around = core::f64::consts::TAU * f64::from(i) / f64::from(n);
            let r = sin(polar);
            positions.push(DVec3::new(a * r * cos(around), b * cos(polar), c * r * sin(around)));
        }
        // Between two rings, the one that lags behind moves on.
        let (mut i, mut j) = (0, 0);
        while i < n || (j < n_before && n_before > 1) {
            let outer = f64::from(i + 1) / f64::from(n);
            let inner = f64::from(j + 1) / f64::from(n_before);
            let (o, p) = (start + i % n, before + j % n_before);
            if n_before == 1 || (i < n && outer <= inner) || j == n_before {
                faces.push([p, start + (i + 1) % n, o]);
                i += 1;
            } else {
                faces.push([p, before + (j + 1) % n_before, o]);
                j += 1;
            }
        }
        (before, n_before) = (start, n);
    }
    TriangleSoup { positions, faces, texture: None }
}

#[test]
fn ellipsoid_has_four_wedges() {
    let [a, b, c] = AXES;
    let x = a * ((a * a - b * b) / (a * a - c * c)).sqrt();
    let z = c * ((b * b - c * c) / (a * a - c * c)).sqrt();
    let at = |s: f64, t: f64| DVec3::new(s * x, 0.0, t * z);
    let expected = [at(1.0, 1.0), at(1.0, -1.0), at(-1.0, 1.0), at(-1.0, -1.0)];
    for (n, edge) in meshes(6400.0) {
        for (noise, part) in [(0.0, 0.005), (0.01, 0.02)] {
            let mesh = surface(noisy(ellipsoid(edge), edge, noise));
            let name = format!("ellipsoid {n} noise {noise}");
            let topology = check(&name, &mesh, &expected, Kind::Wedge, part);
            assert!(topology.cuts().is_empty());
        }
    }
}

#[test]
fn planes_and_spheres_have_no_direction_and_are_not_divided() {
    let plane = AnalyticSurface::Plane { width: 40.0, depth: 30.0 };
    let dome = AnalyticSurface::SphereCap { radius: 30.0, diameter: 40.0 };
    for (name, truth) in [("plane", plane), ("sphere", dome)] {
        for noise in [0.0, 0.01] {
            let mesh = surface(noisy(truth.mesh(0.6), 0.6, noise));
            let topology = found(&mesh);
            print(name, &mesh, &topology);
            assert!(topology.cuts().is_empty(), "{name}");
            if noise == 0.0 {
                let covered: f64 = topology.free.iter().map(|f| f.area).sum();
                assert!(covered > 0.9 * mesh.area(), "{name}: {covered}");
                assert!(topology.points.is_empty(), "{name}: {:?}", topology.points);
            }
        }
    }
}

/// Points keep their kind and place when the part is moved and its vertices are reordered.
#[test]
fn moved_and_reordered_surfaces_have_the_same_points() {
    let saddle = AnalyticSurface::MonkeySaddle { size: 40.0, height: 4.0 };
    let mesh = saddle.mesh(1.0);
    let n = mesh.positions.len() as u32;
    let turned = TriangleSoup {
        positions: mesh.positions.iter().rev().map(|p| DVec3::new(p.y, p.z, p.x) + 7.0).collect(),
        faces: mesh.faces.iter().rev().map(|f| f.map(|v| n - 1 - v)).collect(),
        texture: None,
    };
    check("moved", &surface(turned), &[DVec3::splat(7.0)], Kind::Trisector, 0.001);
}

/// A plane cut by three lines that meet inside falls into three regions.
#[test]
fn lines_that_meet_inside_part_a_plane() {
    let plane = AnalyticSurface::Plane { width: 40.0, depth: 30.0 };
    let mesh = surface(plane.mesh(0.7));
    let flat: Vec<DVec2> = mesh.positions().iter().map(|p| p.truncate()).collect();
    let chart = Chart::new(&mesh, flat);
    let at = DVec2::new(3.1, -2.7);
    let line = |to: DVec2| (0..=12).map(|i| at.lerp(to, f64::from(i) / 12.0)).collect();
    let ends = [DVec2::new(1.234, -15.0), DVec2::new(20.0, 7.7), DVec2::new(-20.0, 6.1)];
    let lines: Vec<Vec<DVec2>> = ends.into_iter().map(line).collect();
    let regions = crate::regions::Regions::along(&mesh, &chart, &lines, 5.0).unwrap();
    assert_eq!(regions.list.len(), 3);
}
