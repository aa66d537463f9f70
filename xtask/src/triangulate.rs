//! Well-shaped unstructured triangulation of a plane domain.
//!
//! Boundary points at the wanted spacing, a hexagonal lattice inside, constrained Delaunay
//! triangulation, then a few rounds that move every inner point to the mean of its neighbours
//! (Field, "Laplacian smoothing and Delaunay triangulations", 1988) and triangulate again.

use evencut_core::geometry::{DVec2, cross2, math};
use spade::{ConstrainedDelaunayTriangulation, Point2, Triangulation};

/// Rounds of smoothing: one leaves creases along the boundary, more than five change little.
const ROUNDS: usize = 4;

/// A plane domain: the outer polygon counter-clockwise, holes either way round.
pub struct Domain {
    pub outer: Vec<DVec2>,
    pub holes: Vec<Vec<DVec2>>,
}

/// Points and counter-clockwise triangles of a domain.
pub struct PlaneMesh {
    pub points: Vec<DVec2>,
    pub faces: Vec<[u32; 3]>,
    /// The first `boundary` points are the domain's loops, outer loop first.
    pub boundary: usize,
}

impl Domain {
    /// A rectangle between two corners.
    pub fn rectangle(low: DVec2, high: DVec2, spacing: f64) -> Self {
        let corners = [low, DVec2::new(high.x, low.y), high, DVec2::new(low.x, high.y)];
        Self { outer: subdivided(&corners, spacing), holes: Vec::new() }
    }

    fn loops(&self) -> impl Iterator<Item = &Vec<DVec2>> {
        std::iter::once(&self.outer).chain(&self.holes)
    }

    fn contains(&self, p: DVec2) -> bool {
        self.loops().filter(|polygon| encloses(polygon, p)).count() == 1
    }

    /// Distance from the boundary's points, which are as dense as the mesh.
    fn clearance(&self, p: DVec2) -> f64 {
        let nearest = |polygon: &Vec<DVec2>| {
            polygon.iter().map(|q| q.distance_squared(p)).fold(f64::INFINITY, f64::min)
        };
        self.loops().map(nearest).fold(f64::INFINITY, f64::min).sqrt()
    }
}

/// A closed polygon whose sides are cut into equal pieces no longer than `spacing`.
pub fn subdivided(corners: &[DVec2], spacing: f64) -> Vec<DVec2> {
    let mut points = Vec::new();
    for (i, &a) in corners.iter().enumerate() {
        let b = corners[(i + 1) % corners.len()];
        let pieces = (a.distance(b) / spacing).ceil().max(1.0) as usize;
        points.extend((0..pieces).map(|k| a.lerp(b, k as f64 / pieces as f64)));
    }
    points
}

/// A circle as points no farther apart than `spacing`.
pub fn circle(centre: DVec2, radius: f64, spacing: f64) -> Vec<DVec2> {
    let count = (std::f64::consts::TAU * radius / spacing).ceil() as usize;
    (0..count)
        .map(|k| {
            let angle = std::f64::consts::TAU * k as f64 / count as f64;
            centre + radius * DVec2::new(math::cos(angle), math::sin(angle))
        })
        .collect()
}

/// Triangulates `domain` with sides of about `spacing`.
pub fn triangulate(domain: &Domain, spacing: f64) -> Result<PlaneMesh, String> {
    let mut points: Vec<DVec2> = domain.loops().flatten().copied().collect();
    let boundary = points.len();
    points.extend(lattice(domain, spacing));
    let mut faces = delaunay(domain, &points)?;
    for _ in 0..ROUNDS {
        smooth(&mut points, &faces, boundary);
        faces = delaunay(domain, &points)?;
    }
    Ok(PlaneMesh { points, faces, boundary })
}

/// Hexagonal lattice inside the domain, clear of the boundary by most of a spacing.
fn lattice(domain: &Domain, spacing: f64) -> Vec<DVec2> {
    let low = domain.outer.iter().copied().fold(DVec2::INFINITY, DVec2::min);
    let high = domain.outer.iter().copied().fold(DVec2::NEG_INFINITY, DVec2::max);
    let row_height = spacing * 3f64.sqrt() / 2.0;
    let rows = ((high.y - low.y) / row_height) as usize + 1;
    let columns = ((high.x - low.x) / spacing) as usize + 1;
    let site = |row: usize, column: usize| {
        let shift = if row.is_multiple_of(2) { 0.25 } else { 0.75 };
        low + DVec2::new((column as f64 + shift) * spacing, row as f64 * row_height)
    };
    (0..rows)
        .flat_map(|row| (0..columns).map(move |column| site(row, column)))
        .filter(|&p| domain.contains(p) && domain.clearance(p) > 0.7 * spacing)
        .collect()
}

fn delaunay(domain: &Domain, points: &[DVec2]) -> Result<Vec<[u32; 3]>, String> {
    let sites = points.iter().map(|p| Point2::new(p.x, p.y)).collect();
    let mut edges = Vec::new();
    let mut start = 0;
    for polygon in domain.loops() {
        let n = polygon.len();
        edges.extend((0..n).map(|i| [start + i, start + (i + 1) % n]));
        start += n;
    }
    let mesh = ConstrainedDelaunayTriangulation::<Point2<f64>>::bulk_load_cdt(sites, edges)
        .map_err(|e| format!("triangulation: {e}"))?;
    let mut faces: Vec<[u32; 3]> = mesh
        .inner_faces()
        .map(|face| face.vertices().map(|v| v.index() as u32))
        .filter(|f| domain.contains(centroid(points, *f)) && !is_flat(points, *f))
        .map(lowest_first)
        .collect();
    faces.sort_unstable();
    Ok(faces)
}

fn centroid(points: &[DVec2], face: [u32; 3]) -> DVec2 {
    face.iter().map(|&v| points[v as usize]).sum::<DVec2>() / 3.0
}

/// Whether the corners lie on a line but for rounding, as three points of an oblique side may.
fn is_flat(points: &[DVec2], face: [u32; 3]) -> bool {
    let [a, b, c] = face.map(|v| points[v as usize]);
    cross2(a, b, c) < 1e-9 * a.distance_squared(b)
}

fn lowest_first([a, b, c]: [u32; 3]) -> [u32; 3] {
    if a < b && a < c {
        [a, b, c]
    } else if b < c {
        [b, c, a]
    } else {
        [c, a, b]
    }
}

fn smooth(points: &mut [DVec2], faces: &[[u32; 3]], boundary: usize) {
    let mut sum = vec![(DVec2::ZERO, 0.0); points.len()];
    for face in faces {
        for k in 0..3 {
            let (a, b) = (face[k] as usize, face[(k + 1) % 3] as usize);
            sum[a].0 += points[b];
            sum[a].1 += 1.0;
        }
    }
    for v in boundary..points.len() {
        points[v] = sum[v].0 / sum[v].1;
    }
}

/// Even-odd rule.
fn encloses(polygon: &[DVec2], p: DVec2) -> bool {
    let mut inside = false;
    for (i, &a) in polygon.iter().enumerate() {
        let b = polygon[(i + 1) % polygon.len()];
        if (a.y > p.y) != (b.y > p.y) && p.x < a.x + (p.y - a.y) / (b.y - a.y) * (b.x - a.x) {
            inside = !inside;
        }
    }
    inside
}

#[cfg(test)]
mod tests {
    use super::*;

    fn area(mesh: &PlaneMesh) -> f64 {
        let corner = |f: &[u32; 3], k: usize| mesh.points[f[k] as usize];
        mesh.faces.iter().map(|f| 0.5 * cross2(corner(f, 0), corner(f, 1), corner(f, 2))).sum()
    }

    #[test]
    fn rectangle_is_covered_once() {
        let domain = Domain::rectangle(DVec2::ZERO, DVec2::new(20.0, 10.0), 1.0);
        let mesh = triangulate(&domain, 1.0).unwrap();
        assert!((area(&mesh) - 200.0).abs() < 1e-9);
    }

    #[test]
    fn hole_stays_open() {
        let square =
            subdivided(&[(0., 0.), (20., 0.), (20., 20.), (0., 20.)].map(DVec2::from), 1.0);
        let hole = circle(DVec2::splat(10.0), 4.0, 1.0);
        let n = hole.len() as f64;
        let polygon = 0.5 * n * 16.0 * math::sin(std::f64::consts::TAU / n);
        let mesh = triangulate(&Domain { outer: square, holes: vec![hole] }, 1.0).unwrap();
        assert!((area(&mesh) - (400.0 - polygon)).abs() < 1e-9);
    }
}
