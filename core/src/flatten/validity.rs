//! Whether a chart is one-to-one: no face turned over, boundary simple.

use super::Chart;
use super::error::FlattenError;
use crate::geometry::{DVec2, cross2};
use crate::mesh::VertexId;
use crate::surface::Surface;

impl Chart {
    /// Checks that no flat face is turned over and that the flat boundary does not cross itself.
    ///
    /// A map of a disk with both is one-to-one.
    ///
    /// # Errors
    /// [`FlattenError::Flipped`] or [`FlattenError::Overlap`] with one example.
    pub fn validate(&self, surface: &Surface) -> Result<(), FlattenError> {
        self.check_orientation(surface)?;
        self.check_boundary(surface)
    }

    fn check_orientation(&self, surface: &Surface) -> Result<(), FlattenError> {
        let faces = surface.connectivity().faces();
        let turned = |f: &[VertexId; 3]| {
            let [a, b, c] = f.map(|v| self.uv()[v.index()]);
            let area = cross2(a, b, c);
            area <= 0.0 || area.is_nan()
        };
        let Some(face) = faces.iter().position(turned) else { return Ok(()) };
        let corners = faces[face].map(|v| surface.positions()[v.index()]);
        Err(FlattenError::Flipped {
            count: faces.iter().filter(|f| turned(f)).count(),
            face: face as u32,
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
/// Sweeps over the sides in the order of their smallest `x` and keeps those still open.
fn first_crossing(sides: &[[VertexId; 2]], uv: &[DVec2]) -> Option<(usize, DVec2)> {
    let ends = |s: usize| sides[s].map(|v| uv[v.index()]);
    let mut order: Vec<(f64, u32)> = (0..sides.len())
        .map(|s| {
            let [a, b] = ends(s);
            (a.x.min(b.x), s as u32)
        })
        .collect();
    order.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    let mut open: Vec<u32> = Vec::new();
    for &(x, s) in &order {
        let [a, b] = ends(s as usize);
        open.retain(|&t| {
            let [c, d] = ends(t as usize);
            c.x.max(d.x) >= x
        });
        for &t in &open {
            let shared = sides[s as usize].iter().any(|v| sides[t as usize].contains(v));
            let [c, d] = ends(t as usize);
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
}
