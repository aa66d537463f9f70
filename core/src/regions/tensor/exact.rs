//! Degenerate points of the tensor on a NURBS surface.
//!
//! Steps: the parameter plane is divided into cells, none of which crosses a knot; a cell at whose corners both `p`
//! and `q` change sign is searched by solving the bilinear system of its corners; Newton's method on the exact tensor
//! finds the place. A place outside of the surface's mesh, which is trimmed, does not count, nor does one that was
//! found before.
//!
//! # Source
//! Xu, Li, Liu (2016), section on trisector points.

use super::field::TensorField;
use super::jet::{Local, zero};
use super::topology::DegeneratePoint;
use crate::geometry::DVec2;
use crate::mesh::FaceId;
use crate::surface::{Parametrisation, SurfacePoint};

/// Cells along a parameter: least number over the whole surface, least number between knots, and greatest number in
/// all.
const ALONG: usize = 48;
const BETWEEN_KNOTS: usize = 3;
const MOST_CELLS: usize = 250_000;
/// Fraction of a cell by which corners keep away from the knots, where curvature may jump.
const INSET: f64 = 1e-6;
/// Fraction of a cell by which a place may lie outside of it.
const BESIDE: f64 = 0.5;
/// Fraction of the surface's size within which two places are the same.
const SAME: f64 = 1e-5;
/// Least growth of the field, as a fraction of the curvature over the size: below it a point is not isolated.
const ISOLATED: f64 = 1e-6;

/// The degenerate points of a field on the NURBS surface behind a mesh.
pub fn on_nurbs(field: &TensorField, own: &Parametrisation, size: f64) -> Vec<DegeneratePoint> {
    let breaks = [0, 1].map(|axis| cell_bounds(own, axis));
    let search = Search { field, own, size };
    let mut points: Vec<DegeneratePoint> = Vec::new();
    for u in breaks[0].windows(2) {
        for v in breaks[1].windows(2) {
            let cell = Cell { low: DVec2::new(u[0], v[0]), high: DVec2::new(u[1], v[1]) };
            for point in search.cell(cell) {
                let is_same = |p: &DegeneratePoint| p.place.distance(point.place) < SAME * size;
                if !points.iter().any(is_same) {
                    points.push(point);
                }
            }
        }
    }
    points
}

/// Bounds of the cells along an axis.
fn cell_bounds(own: &Parametrisation, axis: usize) -> Vec<f64> {
    let breaks: Vec<f64> = own.surface().breaks(axis).iter().map(|b| b.0).collect();
    let (low, high) = own.surface().domain();
    let breaks: Vec<f64> =
        breaks.into_iter().filter(|b| (low[axis]..=high[axis]).contains(b)).collect();
    let spans = breaks.len().saturating_sub(1).max(1);
    // Of either axis at most the root of the cells in all.
    let most = ((MOST_CELLS as f64).sqrt() as usize / spans).max(1);
    let parts = ALONG.div_ceil(spans).max(BETWEEN_KNOTS).min(most);
    let mut bounds = Vec::with_capacity(spans * parts + 1);
    for pair in breaks.windows(2) {
        let part = |k: usize| pair[0] + (pair[1] - pair[0]) * k as f64 / parts as f64;
        bounds.extend((0..parts).map(part));
    }
    bounds.extend(breaks.last());
    bounds
}

#[derive(Copy, Clone)]
struct Cell {
    low: DVec2,
    high: DVec2,
}

impl Cell {
    fn at(&self, s: DVec2) -> DVec2 {
        self.low + (self.high - self.low) * s
    }
}

struct Search<'a> {
    field: &'a TensorField<'a>,
    own: &'a Parametrisation,
    size: f64,
}

impl Search<'_> {
    fn value(&self, at: DVec2) -> Option<DVec2> {
        let [xx, xy, yy] = self.own.surface().shape(at)?.k;
        Some(DVec2::new(0.25 * (xx - yy), 0.5 * xy))
    }

    fn cell(&self, cell: Cell) -> Vec<DegeneratePoint> {
        let (near, far) = (INSET, 1.0 - INSET);
        let corner = |s: f64, t: f64| self.value(cell.at(DVec2::new(s, t)));
        let corners = [corner(near, near), corner(far, near), corner(near, far), corner(far, far)];
        let [Some(a), Some(b), Some(c), Some(d)] = corners else { return Vec::new() };
        let values = [a, b, c, d];
        let changes = |axis: usize| {
            values.iter().any(|v| v[axis] > 0.0) && values.iter().any(|v| v[axis] < 0.0)
        };
        if !(changes(0) && changes(1)) {
            return Vec::new();
        }
        let mut starts = bilinear(values);
        if starts.is_empty() {
            starts.push(DVec2::splat(0.5));
        }
        starts.into_iter().filter_map(|s| self.polished(cell, s)).collect()
    }

    /// The exact place near a start in a cell, inside of the mesh.
    fn polished(&self, cell: Cell, start: DVec2) -> Option<DegeneratePoint> {
        let local = |at: DVec2| {
            let shape = self.own.shape(at)?;
            Some(Local { shape, first: self.own.surface().jet(at).first })
        };
        let found = zero(local, cell.at(start), cell.high - cell.low)?;
        let s = (found.at - cell.low) / (cell.high - cell.low);
        if (s - 0.5).abs().max_element() > 0.5 + BESIDE {
            return None;
        }
        let bend = self.own.shape(found.at)?.mean().abs() + 1.0 / self.size;
        let least = ISOLATED * bend / self.size;
        if found.delta().abs() < least * least {
            return None;
        }
        let at = self.on_mesh(found.at)?;
        let place = self.own.position(at);
        Some(DegeneratePoint::new(self.field, at, place, found).with_parameters(found.at))
    }

    /// The surface point with the parameters `at`.
    fn on_mesh(&self, at: DVec2) -> Option<SurfacePoint> {
        let period = self.own.period().map(|p| p.unwrap_or(0.0));
        let shifts =
            |axis: usize| if period[axis] > 0.0 { [0.0, -1.0, 1.0].as_slice() } else { &[0.0] };
        for i in shifts(0) {
            for j in shifts(1) {
                let moved = at + DVec2::new(i * period[0], j * period[1]);
                for (f, corners) in self.own.corners().iter().enumerate() {
                    if let Some(weights) = inside(corners, moved) {
                        return Some(SurfacePoint { face: FaceId(f as u32), weights });
                    }
                }
            }
        }
        None
    }
}

/// Barycentric coordinates of a point in a triangle of any orientation.
fn inside([a, b, c]: &[DVec2; 3], p: DVec2) -> Option<[f64; 3]> {
    let area = (*b - *a).perp_dot(*c - *a);
    let w = [(*b - p).perp_dot(*c - p), (*c - p).perp_dot(*a - p), (*a - p).perp_dot(*b - p)];
    let w = w.map(|w| w / area);
    w.iter().all(|w| *w >= -1e-9).then_some(w)
}

/// Where the bilinear field with the values `a` at (0, 0), `b` at (1, 0), `c` at (0, 1) and `d` at
/// (1, 1) vanishes, in the unit square and a little around it.
fn bilinear([a, b, c, d]: [DVec2; 4]) -> Vec<DVec2> {
    // a + s e + t f + s t g = 0; crossed with e + t g it leaves a quadratic equation for t.
    let (e, f, g) = (b - a, c - a, a - b - c + d);
    let (q0, q1, q2) = (a.perp_dot(e), a.perp_dot(g) + f.perp_dot(e), f.perp_dot(g));
    let mut places = Vec::new();
    for t in quadratic(q0, q1, q2) {
        let (way, left) = (e + g * t, a + f * t);
        let s = -left.dot(way) / way.length_squared();
        let at = DVec2::new(s, t);
        if (at - 0.5).abs().max_element() <= 0.5 + BESIDE {
            places.push(at);
        }
    }
    places
}

/// Real roots of `c + b x + a x²`.
fn quadratic(c: f64, b: f64, a: f64) -> Vec<f64> {
    let discriminant = b * b - 4.0 * a * c;
    if discriminant < 0.0 {
        return Vec::new();
    }
    // The sum that does not cancel.
    let q = -0.5 * (b + discriminant.sqrt() * if b < 0.0 { -1.0 } else { 1.0 });
    let roots = [q / a, c / q];
    let mut roots: Vec<f64> = roots.into_iter().filter(|x| x.is_finite()).collect();
    roots.dedup();
    roots
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bilinear_fields_vanish_where_they_should() {
        let at = DVec2::new(0.3, 0.7);
        let field = |s: f64, t: f64| {
            DVec2::new((s - at.x) * (1.0 + 0.5 * t), 2.0 * (t - at.y) * (1.5 - 0.4 * s))
        };
        let places = bilinear([field(0.0, 0.0), field(1.0, 0.0), field(0.0, 1.0), field(1.0, 1.0)]);
        assert_eq!(places.len(), 1);
        assert!(places[0].distance(at) < 1e-12, "{places:?}");
    }
}
