//! Curves that continue straight beyond the boundary.
//!
//! Fronts from the end of a curve are round: on the boundary beyond it, passes turn within their own width. The
//! passes of a curve that continues straight in the plane meet the boundary straight; their field is known there by
//! integrating along the boundary, `dphi = n dp / |n|`, with the normal `n` of the straight continuation and its
//! length in passes. No such value changes by more than one pass per pass, so fronts can start from these values as
//! well as from any others.

use super::refine::PassMesh;
use crate::geometry::DVec2;
use crate::geometry::polyline::distance_to_segment;
use crate::mesh::{HalfEdgeId, VertexId};

/// A curve whose end is within this distance of the boundary, passes, ends on it.
const ON_BOUNDARY: f64 = 0.05;

/// Signed values at the boundary vertices beside the straight continuations at both ends of a flat curve: positive on
/// its left.
pub(super) fn beside_ways_on(mesh: &PassMesh, curve: &[DVec2]) -> Vec<(VertexId, f64)> {
    let [first, second, ..] = *curve else { return Vec::new() };
    let [.., before, last] = *curve else { return Vec::new() };
    let end = WayOn::new(mesh, last, last - before).map_or_else(Vec::new, |way| way.values());
    let start = WayOn::new(mesh, first, first - second).map_or_else(Vec::new, |way| way.values());
    // Seen from the start left is right.
    end.into_iter().chain(start.into_iter().map(|(v, value)| (v, -value))).collect()
}

/// The continuation beyond one end.
struct WayOn<'a> {
    mesh: &'a PassMesh,
    end: DVec2,
    way: DVec2,
    /// The side of the boundary on which the end lies.
    side: HalfEdgeId,
}

impl<'a> WayOn<'a> {
    /// `None` where the end is not on the boundary.
    fn new(mesh: &'a PassMesh, end: DVec2, way: DVec2) -> Option<Self> {
        let connectivity = mesh.connectivity();
        let sides = (0..3 * connectivity.face_count() as u32).map(HalfEdgeId);
        let outer = sides.filter(|h| connectivity.opposite(*h).is_none());
        let off = |h: &HalfEdgeId| {
            let (a, b) = connectivity.ends(*h);
            distance_to_segment(end, mesh.uv()[a.index()], mesh.uv()[b.index()])
        };
        let side = outer.min_by(|a, b| off(a).total_cmp(&off(b)))?;
        let is_on = off(&side) * mesh.flat_metric(side.face())?.mean() < ON_BOUNDARY;
        let way = way.try_normalize()?;
        is_on.then_some(Self { mesh, end, way, side })
    }

    /// The values along the boundary on both sides of the end, as far as the boundary lies beyond the end.
    fn values(&self) -> Vec<(VertexId, f64)> {
        let connectivity = self.mesh.connectivity();
        let is_on = |l: &&Vec<VertexId>| l.contains(&connectivity.ends(self.side).0);
        let Some(cycle) = connectivity.boundary_loops().iter().find(is_on) else {
            return Vec::new();
        };
        let (a, b) = connectivity.ends(self.side);
        let n = cycle.len();
        let Some(at) = cycle.iter().position(|v| *v == a) else { return Vec::new() };
        let is_forward = cycle[(at + 1) % n] == b;
        let from_b = (1..n).map(|k| cycle[if is_forward { at + k } else { at + n - k } % n]);
        let from_a = (0..n - 1).map(|k| cycle[if is_forward { at + n - k } else { at + k } % n]);
        let mut out = self.along(from_b);
        out.extend(self.along(from_a));
        out
    }

    fn along(&self, vertices: impl Iterator<Item = VertexId>) -> Vec<(VertexId, f64)> {
        let normal = self.way.perp();
        let mut out: Vec<(VertexId, f64)> = Vec::new();
        let (mut from, mut value) = (self.end, 0.0);
        for v in vertices {
            let to = self.mesh.uv()[v.index()];
            let Some(step) = self.step(v, to - from) else { break };
            // Positive in front of the line that fronts from the end itself go along.
            let ahead = (to - self.end).perp_dot(self.across(v).unwrap_or(normal));
            if ahead <= 0.0 || value * step < 0.0 {
                break;
            }
            value += step;
            out.push((v, value));
            from = to;
        }
        out
    }

    /// Number of passes across the continuation in a flat step beside a vertex.
    fn step(&self, v: VertexId, step: DVec2) -> Option<f64> {
        let face = self.mesh.connectivity().leaving(v)?.face();
        let normal = self.way.perp();
        Some(normal.dot(step) / self.mesh.flat_metric(face)?.slope(normal))
    }

    /// The flat direction in which fronts leave the continuation on its left.
    fn across(&self, v: VertexId) -> Option<DVec2> {
        let face = self.mesh.connectivity().leaving(v)?.face();
        Some(self.mesh.flat_metric(face)?.across(self.way.perp()))
    }
}
