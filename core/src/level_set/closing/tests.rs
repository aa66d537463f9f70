//! Gaps of closed rings, measured in space by another way than the planner's.

use super::*;
use crate::flatten::{Chart, Locator, bff};
use crate::footprint::Footprint;
use crate::geometry::{DVec3, math};
use crate::job::RingOrder;
use crate::job::{Component, Faces, Selection, SurfaceOptions, SurfaceSource};
use crate::level_set::{FieldTerrain, passes, ring_levels, strip_metric};
use crate::mesh::{Connectivity, VertexId};
use crate::surface::{AnalyticSurface, Surface, build};
use crate::tool::Tool;
use core::f64::consts::TAU;
use std::collections::BTreeMap;

/// Gaps wider than this fail a test: the limit and the raster of the measurement, passes.
const WIDEST: f64 = 0.506 + 0.02;

/// A flat part: `nx` by `ny` quads with corners at `at`, those that `keep` takes by their indices.
fn flat(
    nx: u32,
    ny: u32,
    at: impl Fn(u32, u32) -> DVec2,
    keep: impl Fn(u32, u32) -> bool,
) -> (Surface, Chart) {
    let corners: Vec<DVec2> =
        (0..=ny).flat_map(|j| (0..=nx).map(move |i| (i, j))).map(|(i, j)| at(i, j)).collect();
    // Corners at the same place are one: a grid may close on itself or run into a point.
    let key = |p: &DVec2| ((p.x * 1e6).round() as i64, (p.y * 1e6).round() as i64);
    let first: BTreeMap<_, u32> =
        corners.iter().enumerate().rev().map(|(i, p)| (key(p), i as u32)).collect();
    let vertex = |i: u32, j: u32| first[&key(&corners[(j * (nx + 1) + i) as usize])];
    let mut faces = Vec::new();
    for (i, j) in (0..ny).flat_map(|j| (0..nx).map(move |i| (i, j))).filter(|(i, j)| keep(*i, *j)) {
        let (a, b, c, d) = (vertex(i, j), vertex(i + 1, j), vertex(i + 1, j + 1), vertex(i, j + 1));
        let halves = if (i + j) % 2 == 0 { [[a, b, c], [a, c, d]] } else { [[a, b, d], [b, c, d]] };
        faces.extend(halves.into_iter().filter(|[a, b, c]| a != b && b != c && c != a));
    }
    let mut used: Vec<u32> = faces.iter().flatten().copied().collect();
    used.sort_unstable();
    used.dedup();
    let number = |v: u32| VertexId(used.binary_search(&v).unwrap() as u32);
    let faces: Vec<_> = faces.iter().map(|f| f.map(number)).collect();
    let uv: Vec<DVec2> = used.iter().map(|&v| corners[v as usize]).collect();
    let positions = uv.iter().map(|p| DVec3::new(p.x, p.y, 0.0)).collect();
    let surface = Surface::new(Connectivity::new(uv.len(), faces).unwrap(), positions);
    let chart = Chart::new(&surface, uv);
    (surface, chart)
}

fn rectangle(width: f64, height: f64) -> (Surface, Chart) {
    let n = |side: f64| (2.0 * side).ceil().max(4.0) as u32;
    let (nx, ny) = (n(width), n(height));
    let at = |i, j| {
        DVec2::new(width * f64::from(i) / f64::from(nx), height * f64::from(j) / f64::from(ny))
    };
    flat(nx, ny, at, |_, _| true)
}

/// Closed rings and how wide their gaps are.
struct Closed {
    rings: Vec<Pass>,
    plain: f64,
    report: ClosingReport,
    widest: f64,
}

/// Closes the rings at a side step of `step` mm and measures.
fn closed(
    surface: &Surface,
    chart: &Chart,
    step: f64,
    inset: Option<f64>,
    order: RingOrder,
) -> Closed {
    let ball = Footprint::new(Tool::new(5.0, 5.0).unwrap(), 0.0);
    closed_leaving(surface, chart, step, inset, (order, ball, [1.0; 2]))
}

/// With this cutter, where cusps of the second height, mm, may be left by passes laid out for those of the first.
fn closed_leaving(
    surface: &Surface,
    chart: &Chart,
    step: f64,
    inset: Option<f64>,
    (order, footprint, cusps): (RingOrder, Footprint, [f64; 2]),
) -> Closed {
    let metric = vec![strip_metric::even(step); chart.uv().len()];
    let mesh = PassMesh::new(surface, chart, metric).unwrap();
    let field = match inset {
        Some(radius) => {
            let clear = |p: &DVec2| to_boundary(surface, chart, *p) - radius;
            let clearance: Vec<f64> = mesh.uv().iter().map(clear).collect();
            PassField::from_clearance(&mesh, &clearance, radius).unwrap()
        }
        None => PassField::from_boundary(&mesh),
    };
    let locator = Locator::new(mesh.connectivity(), mesh.uv());
    let terrain = FieldTerrain::new(&mesh, &field, &locator);
    let mut rings = passes(&mesh, &field, &ring_levels(&field));
    for ring in &mut rings {
        ring.points = crate::geometry::polyline::simplify_closed(&ring.points, 0.002 * step);
    }
    let on_chart = chart.locator(surface);
    let measure = |rings: &[Pass]| widest(surface, chart, &on_chart, rings, &terrain, step);
    let plain = measure(&rings);
    let options =
        ClosingOptions { order, on_levels: true, beside: &[], footprint, cusps, threads: 2 };
    let report = close(&mut rings, &mesh, &field, &terrain, &options);
    let widest = measure(&rings);
    Closed { rings, plain, report, widest }
}

/// Distance of a flat place from the boundary.
fn to_boundary(surface: &Surface, chart: &Chart, at: DVec2) -> f64 {
    let loops = surface.connectivity().boundary_loops();
    let sides = loops.iter().flat_map(|l| (0..l.len()).map(|i| [l[i], l[(i + 1) % l.len()]]));
    let ends = sides.map(|side| side.map(|v| chart.uv()[v.index()]));
    let distances = ends.map(|[a, b]| crate::geometry::polyline::distance_to_segment(at, a, b));
    distances.fold(f64::INFINITY, f64::min)
}

/// Largest distance in space, in side steps, of points all over the surface inside of ring 0 from
/// points all along the passes. None of the planner's search takes part.
fn widest(
    surface: &Surface,
    chart: &Chart,
    locator: &Locator,
    rings: &[Pass],
    terrain: &dyn Terrain,
    step: f64,
) -> f64 {
    let mut cells: BTreeMap<[i64; 3], Vec<DVec3>> = BTreeMap::new();
    let cell = |p: DVec3| [p.x, p.y, p.z].map(|x| (x / step).floor() as i64);
    let mut add = |a: DVec2, b: DVec2| {
        let n = ((b - a).length() / (0.02 * step)).ceil().max(1.0) as usize;
        for i in 0..=n {
            let p = surface.position(locator.locate(a.lerp(b, i as f64 / n as f64)).unwrap());
            cells.entry(cell(p)).or_default().push(p);
        }
    };
    for ring in rings {
        let next = |i: usize| ring.points[(i + 1) % ring.points.len()];
        (0..ring.points.len()).for_each(|i| add(ring.points[i], next(i)));
        for branch in &ring.branches {
            let root = [ring.points[branch.at]];
            let line: Vec<DVec2> =
                root.iter().chain(&branch.points).chain(&root).copied().collect();
            line.windows(2).for_each(|w| add(w[0], w[1]));
        }
    }
    let mut widest = 0.0;
    for face in surface.connectivity().faces() {
        let uv = face.map(|v| chart.uv()[v.index()]);
        let p = face.map(|v| surface.positions()[v.index()]);
        let longest = (0..3).map(|i| (p[i] - p[(i + 1) % 3]).length()).fold(0.0, f64::max);
        let n = (longest / (0.04 * step)).ceil().max(1.0) as usize;
        for (i, j) in (0..=n).flat_map(|i| (0..=n - i).map(move |j| (i, j))) {
            let (s, t) = (i as f64 / n as f64, j as f64 / n as f64);
            if terrain
                .room(uv[0] + (uv[1] - uv[0]) * s + (uv[2] - uv[0]) * t)
                .is_none_or(|r| r < 0.0)
            {
                continue;
            }
            let at = p[0] + (p[1] - p[0]) * s + (p[2] - p[0]) * t;
            let [x, y, z] = cell(at);
            let mut nearest = f64::INFINITY;
            for key in (x - 1..=x + 1)
                .flat_map(|x| (y - 1..=y + 1).map(move |y| (x, y)))
                .flat_map(|(x, y)| (z - 1..=z + 1).map(move |z| [x, y, z]))
            {
                for q in cells.get(&key).into_iter().flatten() {
                    nearest = nearest.min((*q - at).length_squared());
                }
            }
            widest = f64::max(widest, nearest.sqrt().min(2.0 * step));
        }
    }
    widest / step
}

fn ring_length(rings: &[Pass]) -> f64 {
    let of = |r: &Pass| {
        (0..r.points.len())
            .map(|i| (r.points[(i + 1) % r.points.len()] - r.points[i]).length())
            .sum::<f64>()
    };
    rings.iter().map(of).sum()
}

fn check(name: &str, c: &Closed) {
    println!(
        "{name}: widest {:.4} before, {:.4} after (reported {:.4}); {} branches, {} cores, {:.2} mm beside {:.0} mm, left {:.4}",
        c.plain,
        c.widest,
        c.report.widest_gap,
        c.report.branches,
        c.report.cores,
        c.report.length,
        ring_length(&c.rings),
        c.report.left
    );
    assert!(c.widest <= WIDEST, "{name}: {}", c.widest);
    assert_eq!(c.report.left, 0.0, "{name}");
    assert!(c.report.widest_gap <= 0.506, "{name}");
    assert_eq!(c.rings.iter().map(|r| r.branches.len()).sum::<usize>() > 0, c.report.branches > 0);
}

#[test]
fn square() {
    let (surface, chart) = rectangle(20.0, 20.0);
    for (order, longest) in [(RingOrder::OutsideIn, 0.55), (RingOrder::InsideOut, 1.1)] {
        let c = closed(&surface, &chart, 1.0, None, order);
        check("square", &c);
        // At a right angle the shortest branch is (sqrt(2) - 1) / 2 long from the inner ring, and
        // twice as long from the outer one; out and back, at four corners of nine rings.
        assert!(c.report.length <= 4.0 * 10.0 * longest, "{}", c.report.length);
    }
}

/// At a right angle places are up to 0.586 passes from the rings, and their cusps 1.37 times as high as beside straight
/// ones: where that may be left, corners have no branches.
#[test]
fn corners_that_may_be_left_have_no_branches() {
    let (surface, chart) = rectangle(20.0, 20.0);
    let branches = |corner: f64, allowed: f64| {
        let footprint = Footprint::new(Tool::new(5.0, corner).unwrap(), 0.0);
        let leaving = (RingOrder::OutsideIn, footprint, [0.025, allowed * 0.025]);
        let c = closed_leaving(&surface, &chart, 1.0, None, leaving);
        assert!(c.widest <= 0.5 * allowed.sqrt() + 0.026, "{}", c.widest);
        assert_eq!(c.report.left, 0.0);
        c.report.branches
    };
    // The middle stays to be closed.
    assert!(branches(5.0, 1.45) <= 2);
    assert!(branches(5.0, 1.3) >= 4 * 8);
    // A flat end leaves the full depth beyond its edge.
    assert!(branches(0.0, 1.45) >= 4 * 8);
}

#[test]
fn walls() {
    let (surface, chart) = rectangle(23.0, 17.0);
    check("walls", &closed(&surface, &chart, 1.3, Some(3.0), RingOrder::OutsideIn));
}

#[test]
fn l_shape() {
    let at = |i, j| DVec2::new(f64::from(i), f64::from(j));
    let (surface, chart) = flat(24, 24, at, |i, j| i < 11 || j < 9);
    check("L", &closed(&surface, &chart, 1.4, None, RingOrder::OutsideIn));
}

/// A ring-shaped corridor is closed by going round its middle once.
#[test]
fn annulus() {
    for (width, rounds) in [(7.5, 1.0), (6.2, 0.0)] {
        let at = |i: u32, j: u32| {
            let (a, r) = (-TAU * f64::from(i % 96) / 96.0, 8.0 + width * f64::from(j) / 10.0);
            DVec2::new(r * math::cos(a), r * math::sin(a))
        };
        let (surface, chart) = flat(96, 10, at, |_, _| true);
        let c = closed(&surface, &chart, 1.0, None, RingOrder::OutsideIn);
        check("annulus", &c);
        let round = TAU * (8.0 + 0.5 * width);
        assert!(c.report.length <= 1.05 * rounds * round, "{} {round}", c.report.length);
    }
}

#[test]
fn sharp_triangle() {
    let (long, half) = (40.0, 40.0 * math::tan(15.0_f64.to_radians()));
    let n = 60;
    let at = |i: u32, j: u32| {
        let x = long * f64::from(i) / f64::from(n);
        DVec2::new(x, half / long * x * (2.0 * f64::from(j) / 20.0 - 1.0))
    };
    let (surface, chart) = flat(n, 20, at, |_, _| true);
    check("triangle", &closed(&surface, &chart, 1.0, None, RingOrder::OutsideIn));
}

#[test]
fn corridors() {
    for width in [1.2, 1.5, 1.9, 2.3, 7.5] {
        let (surface, chart) = rectangle(20.0, width);
        let c = closed(&surface, &chart, 1.0, None, RingOrder::OutsideIn);
        check(&format!("corridor of {width}"), &c);
        // At most out and back along the middle, and the corners.
        assert!(c.report.length <= 2.0 * 20.0 + 4.0 * 5.0, "{}", c.report.length);
    }
}

#[test]
fn bump() {
    let bump = AnalyticSurface::Bump { size: 40.0, height: 8.0, width: 8.0 };
    let options = SurfaceOptions {
        source: SurfaceSource::File(String::new()),
        scale: 1.0,
        rotate: DVec3::ZERO,
        translate: DVec3::ZERO,
        select: Selection { component: Component::Only, ..Selection::default() },
        curvature_radius: None,
        steepest: None,
        flip: false,
        face: Faces::Only,
        chord: None,
    };
    let surface = build(bump.mesh(0.7), &options).unwrap().surface;
    let chart = bff(&surface).unwrap();
    for step in [0.9, 2.0] {
        check("bump", &closed(&surface, &chart, step, None, RingOrder::OutsideIn));
    }
}
