//! Polygons into triangles.

use super::error::{Place, ReadError};
use super::format::MeshFormat;
use crate::geometry::{DVec2, DVec3, any_perpendicular, cross2};

/// Largest polygon that ear clipping is given, whose time grows with the square or worse.
const LARGEST_CLIPPED: usize = 1024;

/// Cuts a polygon of at least three corners into triangles of corner numbers.
///
/// Convex polygons become a fan, others are clipped ear by ear in their mean plane; what has no
/// ear left (a corner repeated, a polygon that crosses itself) becomes a fan for the mesh checks
/// to judge.
///
/// # Errors
/// [`TooLarge`] for a polygon that is neither convex nor small.
pub(super) fn triangulate(corners: &[DVec3], out: &mut Vec<[u32; 3]>) -> Result<(), TooLarge> {
    match corners.len() {
        0..3 => {}
        3 => out.push([0, 1, 2]),
        n => {
            let flat = project(corners);
            if is_convex(&flat) {
                fan(&(0..n as u32).collect::<Vec<_>>(), out);
            } else if n <= LARGEST_CLIPPED {
                clip_ears(&flat, out);
            } else {
                return Err(TooLarge(n));
            }
        }
    }
    Ok(())
}

/// A polygon that is not convex and has more corners than are clipped.
#[derive(Copy, Clone, Debug)]
pub(super) struct TooLarge(usize);

impl TooLarge {
    /// The error to report.
    pub fn at(self, format: MeshFormat, place: Place) -> ReadError {
        ReadError {
            format,
            place,
            found: format!("a face with {} corners that is not convex", self.0),
            expected: format!("at most {LARGEST_CLIPPED} corners, or a convex face"),
        }
    }
}

/// A polygon with fewer than three corners is not a face.
pub(super) fn too_few_corners(format: MeshFormat, place: Place, n: usize) -> ReadError {
    ReadError {
        format,
        place,
        found: format!("a face with {n} corners"),
        expected: "at least 3".into(),
    }
}

fn fan(corners: &[u32], out: &mut Vec<[u32; 3]>) {
    out.extend(corners.windows(2).skip(1).map(|w| [corners[0], w[0], w[1]]));
}

/// Corners in the plane of the polygon's area vector (Newell), counter-clockwise.
fn project(corners: &[DVec3]) -> Vec<DVec2> {
    let origin = corners[0];
    let next = corners.iter().cycle().skip(1);
    let area: DVec3 = corners.iter().zip(next).map(|(a, b)| (a - origin).cross(b - origin)).sum();
    let normal = area.try_normalize().unwrap_or(DVec3::Z);
    let u = any_perpendicular(normal);
    let v = normal.cross(u);
    corners.iter().map(|p| DVec2::new((p - origin).dot(u), (p - origin).dot(v))).collect()
}

fn is_convex(flat: &[DVec2]) -> bool {
    let n = flat.len();
    (0..n).all(|i| cross2(flat[i], flat[(i + 1) % n], flat[(i + 2) % n]) >= 0.0)
}

fn clip_ears(flat: &[DVec2], out: &mut Vec<[u32; 3]>) {
    let mut left: Vec<u32> = (0..flat.len() as u32).collect();
    let at = |v: u32| flat[v as usize];
    let mut i = 0;
    let mut refused = 0;
    while left.len() > 3 && refused < left.len() {
        let n = left.len();
        let (a, b, c) = (left[(i + n - 1) % n], left[i % n], left[(i + 1) % n]);
        let ear = cross2(at(a), at(b), at(c)) > 0.0
            && !left.iter().any(|&v| v != a && v != b && v != c && inside(flat, [a, b, c], v));
        if ear {
            out.push([a, b, c]);
            left.remove(i % n);
            refused = 0;
            // Clipping alternate corners keeps the triangles from fanning out of one vertex.
            i = if i >= left.len() { 0 } else { i };
        } else {
            refused += 1;
            i = (i + 1) % n;
        }
    }
    fan(&left, out);
}

fn inside(flat: &[DVec2], [a, b, c]: [u32; 3], v: u32) -> bool {
    let [a, b, c, p] = [a, b, c, v].map(|i| flat[i as usize]);
    // A corner that only repeats one of the ear's own does not block it.
    p != a
        && p != b
        && p != c
        && cross2(a, b, p) >= 0.0
        && cross2(b, c, p) >= 0.0
        && cross2(c, a, p) >= 0.0
}

#[cfg(test)]
mod tests {
    use super::*;

    fn area(corners: &[DVec3]) -> f64 {
        let mut triangles = Vec::new();
        triangulate(corners, &mut triangles).unwrap();
        assert_eq!(triangles.len(), corners.len() - 2);
        let corner = |i: u32| corners[i as usize];
        triangles
            .iter()
            .map(|&[a, b, c]| (corner(b) - corner(a)).cross(corner(c) - corner(a)).z / 2.0)
            .inspect(|part| assert!(*part > 0.0))
            .sum()
    }

    #[test]
    fn a_concave_polygon_is_covered_once() {
        let arrow = [(0.0, 0.0), (4.0, 0.0), (4.0, 4.0), (2.0, 1.0), (0.0, 4.0)];
        let arrow = arrow.map(|(x, y)| DVec3::new(x, y, 0.0));
        for first in 0..arrow.len() {
            let mut turned = arrow.to_vec();
            turned.rotate_left(first);
            assert!((area(&turned) - 10.0).abs() < 1e-12);
        }
    }

    #[test]
    fn a_star_is_covered_once() {
        let corners: Vec<DVec3> = (0..200)
            .map(|i| {
                let angle = f64::from(i) * std::f64::consts::TAU / 200.0;
                let radius = if i % 2 == 0 { 1.0 } else { 0.4 };
                use crate::geometry::math::{cos, sin};
                DVec3::new(radius * cos(angle), radius * sin(angle), 0.0)
            })
            .collect();
        let truth = 200.0 * 0.5 * 0.4 * crate::geometry::math::sin(std::f64::consts::TAU / 200.0);
        assert!((area(&corners) - truth).abs() < 1e-12);
    }

    #[test]
    fn repeated_corners_end() {
        let square = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)];
        let corners: Vec<DVec3> =
            (0..1000).map(|i| DVec3::new(square[i % 4].0, square[i % 4].1, 0.0)).collect();
        let mut triangles = Vec::new();
        triangulate(&corners, &mut triangles).unwrap();
        assert_eq!(triangles.len(), 998);
    }
}
