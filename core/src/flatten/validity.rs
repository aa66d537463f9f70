//! Whether a chart is one-to-one: no face turned over, boundary simple.

use super::chart::Chart;
use super::error::FlattenError;
use crate::geometry::{DVec2, OrderBy, cross2};
use crate::mesh::{FaceId, VertexId};
use crate::surface::Surface;

impl Chart {
    /// Checks that no flat face is turned over and that the flat boundary does not cross itself.
    ///
    /// With one loop that runs counter-clockwise and the holes clockwise, every flat point is
    /// then covered at most once.
    ///
    /// # Errors
    /// [`FlattenError::Flipped`] or [`FlattenError::Overlap`] with one example.
    pub fn validate(&self, surface: &Surface) -> Result<(), FlattenError> {
        self.check_orientation(surface)?;
        self.check_boundary(surface)
    }

    fn check_orientation(&self, surface: &Surface) -> Result<(), FlattenError> {
        let faces = || 0..surface.connectivity().face_count() as u32;
        let turned = |f: &u32| !self.distortion(surface, FaceId(*f)).is_up();
        let Some(face) = faces().find(turned) else { return Ok(()) };
        let corners = surface.corners(FaceId(face));
        Err(FlattenError::Flipped {
            count: faces().filter(turned).count(),
            face,
            at: (corners[0] + corners[1] + corners[2]) / 3.0,
        })
    }

    fn check_boundary(&self, surface: &Surface) -> Result<(), FlattenError> {
        let mut sides = Vec::new();
        for cycle in surface.connectivity().boundary_loops() {
            for (i, &v) in cycle.iter().enumerate() {
                sides.push([v, cycle[(i + 1) % cycle.len()]]);
            }
        }
        match first_crossing(&sides, self.uv()) {
            None => Ok(()),
            Some((side, uv)) => {
                Err(FlattenError::Overlap { uv, at: surface.positions()[sides[side][0].index()] })
            }
        }
    }
}

/// A side that crosses another one without sharing a vertex, and where.
///
/// Sweeps along the boundary's longer extent over the sides by their start and keeps those still
/// open.
fn first_crossing(sides: &[[VertexId; 2]], uv: &[DVec2]) -> Option<(usize, DVec2)> {
    let ends = |s: u32| sides[s as usize].map(|v| uv[v.index()]);
    let (mut low, mut high) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
    for p in (0..sides.len() as u32).flat_map(ends) {
        low = low.min(p);
        high = high.max(p);
    }
    let axis = usize::from(high.y - low.y > high.x - low.x);
    let mut order: Vec<(f64, u32)> = (0..sides.len() as u32)
        .map(|s| {
            let [a, b] = ends(s);
            (a[axis].min(b[axis]), s)
        })
        .collect();
    order.order_total_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    let mut open: Vec<u32> = Vec::new();
    for &(start, s) in &order {
        let [a, b] = ends(s);
        open.retain(|&t| {
            let [c, d] = ends(t);
            c[axis].max(d[axis]) >= start
        });
        for &t in &open {
            let shared = sides[s as usize].iter().any(|v| sides[t as usize].contains(v));
            let [c, d] = ends(t);
            if !shared && cross(a, b, c, d) {
                return Some((s as usize, meeting(a, b, c, d)));
            }
        }
        open.push(s);
    }
    None
}

/// Whether segments `a b` and `c d` properly cross.
fn cross(a: DVec2, b: DVec2, c: DVec2, d: DVec2) -> bool {
    let apart = |p: f64, q: f64, r: f64, s: f64| p.max(q) < r.min(s) || r.max(s) < p.min(q);
    if apart(a.x, b.x, c.x, d.x) || apart(a.y, b.y, c.y, d.y) {
        return false;
    }
    let opposite = |p: f64, q: f64| (p > 0.0 && q < 0.0) || (p < 0.0 && q > 0.0);
    opposite(cross2(a, b, c), cross2(a, b, d)) && opposite(cross2(c, d, a), cross2(c, d, b))
}

/// The common point of two crossing segments.
fn meeting(a: DVec2, b: DVec2, c: DVec2, d: DVec2) -> DVec2 {
    let (p, q) = (cross2(c, d, a), cross2(c, d, b));
    a + (b - a) * (p / (p - q))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::flatten::samples;
    use crate::geometry::DVec3;
    use crate::geometry::math::{cos, sin};
    use std::f64::consts::TAU;

    #[test]
    fn turned_face_and_crossing_boundary_are_found() {
        let surface = samples::sheared_plane(4, 0.0);
        let flat: Vec<DVec2> = surface.positions().iter().map(|p| p.truncate()).collect();
        assert_eq!(Chart::new(&surface, flat.clone()).validate(&surface), Ok(()));
        let mut pulled = flat.clone();
        pulled[12].x += 0.8;
        let fault = Chart::new(&surface, pulled).validate(&surface);
        assert!(matches!(fault, Err(FlattenError::Flipped { .. })), "{fault:?}");
        let surface = samples::grid(40, |x, y| DVec3::new(10.0 * x, y, 0.0));
        let rolled = |turn: f64| -> Vec<DVec2> {
            let at = |p: &DVec3| {
                let angle = turn * p.x / 10.0;
                (3.0 - p.y) * DVec2::new(cos(angle), sin(angle))
            };
            surface.positions().iter().map(at).collect()
        };
        assert_eq!(Chart::new(&surface, rolled(6.0)).validate(&surface), Ok(()));
        let fault = Chart::new(&surface, rolled(7.0)).validate(&surface);
        assert!(matches!(fault, Err(FlattenError::Overlap { .. })), "{fault:?}");
    }
    #[test]
    fn a_ring_wound_twice_is_found_though_no_sides_cross() {
        let ring = samples::ring(24);
        let wound = |turns: f64| -> Vec<DVec2> {
            let at = |k: u32| {
                let angle = turns * TAU * f64::from(k % 24) / 24.0;
                (if k < 24 { 2.0 } else { 1.0 }) * DVec2::new(cos(angle), sin(angle))
            };
            (0..48).map(at).collect()
        };
        assert_eq!(Chart::new(&ring, wound(1.0)).validate(&ring), Ok(()));
        let fault = Chart::new(&ring, wound(2.0)).validate(&ring);
        assert!(matches!(fault, Err(FlattenError::Overlap { .. })), "{fault:?}");
    }
}
