//! Fast marching over triangles given by edge lengths, with fronts that may be curved.

use super::bend::second_differences;
use super::refine::PassMesh;
use crate::mesh::{Connectivity, HalfEdgeId, VertexId};
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// How accurate a distance is.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum Accuracy {
    /// With straight fronts: good enough to compare fields.
    Sketch,
    /// With curved fronts: good enough for passes.
    Full,
}

/// Fast marching, one triangle or an unfolded pair of triangles at a time.
///
/// # Source
/// Kimmel and Sethian 1998; the correction for curved fronts is ours.
pub(super) struct Front<'a> {
    connectivity: &'a Connectivity,
    lengths: Vec<f64>,
    /// Second difference of the field along every side.
    bends: Vec<f64>,
}

/// State of a march.
struct March {
    value: Vec<f64>,
    settled: Vec<bool>,
    /// Where the front may go; it does not cross between two vertices that are both excluded.
    allowed: Vec<bool>,
}

/// Bit patterns that order non-negative numbers, with negative ones before them in reverse.
fn order(value: f64) -> u64 {
    let bits = value.to_bits();
    if bits >> 63 == 0 { bits | (1 << 63) } else { !bits }
}

impl<'a> Front<'a> {
    pub fn new(connectivity: &'a Connectivity, length: impl Fn(HalfEdgeId) -> f64) -> Self {
        let sides = 3 * connectivity.face_count() as u32;
        let lengths: Vec<f64> = (0..sides).map(|h| length(HalfEdgeId(h))).collect();
        Self { connectivity, bends: vec![0.0; lengths.len()], lengths }
    }

    /// Distances in passes; at full accuracy with the curvature of the fronts estimated from a first march.
    pub fn solve(
        mesh: &'a PassMesh,
        sources: &[(VertexId, f64)],
        accuracy: Accuracy,
        allowed: impl Fn(VertexId) -> bool,
    ) -> Vec<f64> {
        let mut front = Self::new(mesh.connectivity(), |h| mesh.pass_length(h));
        let planar = front.march(sources, &allowed);
        if accuracy == Accuracy::Sketch {
            return planar;
        }
        front.bends = second_differences(mesh, &planar);
        front.march(sources, allowed)
    }

    fn length(&self, side: HalfEdgeId) -> f64 {
        self.lengths[side.index()]
    }

    /// Values at all vertices that `allowed` lets the front reach; infinite elsewhere.
    pub fn march(
        &self,
        sources: &[(VertexId, f64)],
        allowed: impl Fn(VertexId) -> bool,
    ) -> Vec<f64> {
        let count = self.connectivity.vertex_count();
        let allowed = (0..count as u32).map(|v| allowed(VertexId(v))).collect();
        let mut state =
            March { value: vec![f64::INFINITY; count], settled: vec![false; count], allowed };
        let mut heap = BinaryHeap::new();
        for &(v, d) in sources {
            state.value[v.index()] = d;
            heap.push(Reverse((order(d), v)));
        }
        let mut candidates = Vec::new();
        while let Some(Reverse((k, v))) = heap.pop() {
            if state.settled[v.index()] || k != order(state.value[v.index()]) {
                continue;
            }
            state.settled[v.index()] = true;
            candidates.clear();
            self.candidates(v, &state, &mut candidates);
            for &(target, d) in &candidates {
                let t = target.index();
                if !state.settled[t] && d < state.value[t] && state.allowed[t] {
                    state.value[t] = d;
                    heap.push(Reverse((order(d), target)));
                }
            }
        }
        state.value
    }

    /// The values that a settled vertex `v` offers its neighbours and the vertices across its opposite edges.
    fn candidates(&self, v: VertexId, state: &March, out: &mut Vec<(VertexId, f64)>) {
        let Some(first) = self.connectivity.leaving(v) else { return };
        let mut side = first;
        loop {
            self.candidates_in_face(v, side, state, out);
            match self.connectivity.opposite(side.prev()) {
                Some(next) if next != first => side = next,
                _ => return,
            }
        }
    }

    fn candidates_in_face(
        &self,
        v: VertexId,
        side: HalfEdgeId,
        state: &March,
        out: &mut Vec<(VertexId, f64)>,
    ) {
        let (p, q) = self.connectivity.ends(side.next());
        let (vp, pq, qv) = (self.length(side), self.length(side.next()), self.length(side.prev()));
        let at = |w: VertexId| state.settled[w.index()].then_some(state.value[w.index()]);
        let here = state.value[v.index()];
        out.push((p, here + vp));
        out.push((q, here + qv));
        if let Some(there) = at(q) {
            let bend = self.bends[side.prev().index()];
            out.extend(planar_front(here, there, [qv, vp, pq]).map(|f| (p, f.curved(bend))));
        }
        if let Some(there) = at(p) {
            let bend = self.bends[side.index()];
            out.extend(planar_front(here, there, [vp, qv, pq]).map(|f| (q, f.curved(bend))));
        }
        let Some(across) = self.connectivity.opposite(side.next()) else { return };
        let (_, w) = self.connectivity.ends(across.next());
        let is_shut = !state.allowed[p.index()] && !state.allowed[q.index()];
        if state.settled[w.index()] || is_shut {
            return;
        }
        // Unfold: p at the origin, q on the x axis, w above, v below.
        let (qx, wp, wq) = (pq, self.length(across.next()), self.length(across.prev()));
        let (Some(below), Some(above)) = (apex(qx, vp, qv), apex(qx, wp, wq)) else { return };
        let (vx, vy) = (below.0, -below.1);
        let reach = ((above.0 - vx) * (above.0 - vx) + (above.1 - vy) * (above.1 - vy)).sqrt();
        let through = |x: f64, y: f64| {
            let crossing = above.0 + (x - above.0) * above.1 / (above.1 - y);
            (0.0..=qx).contains(&crossing)
        };
        if through(vx, vy) {
            out.push((w, here + reach));
        }
        let sides = [(p, 0.0, vp, wp, side), (q, qx, qv, wq, side.prev())];
        for (corner, corner_x, from_v, to_w, edge) in sides {
            if let Some(there) = at(corner)
                && let Some(front) = planar_front(here, there, [from_v, reach, to_w])
                && through(vx + (corner_x - vx) * front.foot, vy * (1.0 - front.foot))
            {
                out.push((w, front.curved(self.bends[edge.index()])));
            }
        }
    }
}

/// Apex `(x, y >= 0)` over the base from 0 to `base` at the given distances from its ends.
fn apex(base: f64, from_start: f64, from_end: f64) -> Option<(f64, f64)> {
    if base <= 0.0 {
        return None;
    }
    let x = (base * base + from_start * from_start - from_end * from_end) / (2.0 * base);
    let y = (from_start * from_start - x * x).max(0.0).sqrt();
    (y > 0.0).then_some((x, y))
}

/// A planar front over an edge, at the apex of its triangle.
struct PlanarFront {
    value: f64,
    /// Where on the edge (0 start, 1 end) the ray through the apex comes from.
    foot: f64,
}

impl PlanarFront {
    /// The value behind a curved front: the second difference of the field along the edge.
    fn curved(&self, bend: f64) -> f64 {
        self.value - 0.5 * bend * self.foot * (1.0 - self.foot)
    }
}

/// The front that passes the ends of an edge at `start` and `end`, at the third corner.
///
/// Lengths: edge, start to apex, end to apex. `None` when the ray through the apex misses the edge.
fn planar_front(
    start: f64,
    end: f64,
    [edge, from_start, from_end]: [f64; 3],
) -> Option<PlanarFront> {
    let (x, y) = apex(edge, from_start, from_end)?;
    let along = (end - start) / edge;
    if along.abs() >= 1.0 {
        return None;
    }
    let up = (1.0 - along * along).sqrt();
    let foot = (x - y * along / up) / edge;
    (0.0..=1.0).contains(&foot).then_some(PlanarFront { value: start + along * x + up * y, foot })
}
