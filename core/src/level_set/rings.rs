//! Rings: closed level curves of the field, and which must be cut before which.

use super::{DistanceField, PassMesh};
use crate::geometry::DVec2;
use crate::mesh::{FaceId, HalfEdgeId};

/// Ring 0 of an open boundary runs this far inside it, in passes: on the boundary to the eye, but
/// with room for rounding before it leaves the chart.
const FIRST_LEVEL: f64 = 0.02;

/// A closed level curve of the field, higher values on its right.
#[derive(Clone, Debug, PartialEq)]
pub struct Ring {
    /// Value of the field, passes.
    pub level: f64,
    /// Flat points, in order; the last is joined to the first.
    pub points: Vec<DVec2>,
    /// Detours that close gaps beside it; see [`close`](super::close).
    pub spurs: Vec<Spur>,
}

/// A detour of a ring.
#[derive(Clone, Debug, PartialEq)]
pub struct Spur {
    /// Index of the ring's point that it leaves from and comes back to.
    pub at: usize,
    /// Flat points between leaving and coming back.
    pub points: Vec<DVec2>,
}

/// Rings at the levels 0, 1, 2, …, without spurs; each level's in order of first face.
///
/// Where the field ends at 0 (an open boundary) ring 0 runs just inside of it.
pub fn rings(mesh: &PassMesh, field: &DistanceField) -> Vec<Ring> {
    let mut tracer = Tracer::new(mesh, field.values());
    let lowest = field.values().iter().copied().fold(f64::INFINITY, f64::min);
    let first_level = if lowest < 0.0 { 0.0 } else { FIRST_LEVEL };
    let highest = field.values().iter().copied().filter(|v| v.is_finite()).fold(0.0, f64::max);
    let mut rings = Vec::new();
    for (k, faces) in
        faces_by_level(mesh, field.values(), first_level, highest).into_iter().enumerate()
    {
        let level = if k == 0 { first_level } else { k as f64 };
        for face in faces {
            rings.extend(tracer.trace(face, level).map(|points| Ring {
                level,
                points,
                spurs: Vec::new(),
            }));
        }
        tracer.next_level();
    }
    rings
}

/// For every whole level the faces it crosses, in order.
fn faces_by_level(
    mesh: &PassMesh,
    values: &[f64],
    first_level: f64,
    highest: f64,
) -> Vec<Vec<FaceId>> {
    let mut by_level = vec![Vec::new(); highest.ceil() as usize + 1];
    for (f, face) in mesh.connectivity().faces().iter().enumerate() {
        let v = face.map(|v| values[v.index()]);
        let low = v.into_iter().fold(f64::INFINITY, f64::min);
        let high = v.into_iter().fold(f64::NEG_INFINITY, f64::max);
        if !high.is_finite() || high <= 0.0 {
            continue;
        }
        if low <= first_level && high > first_level {
            by_level[0].push(FaceId(f as u32));
        }
        // A level is crossed when low <= level < high.
        let crossed = (low.max(1.0).ceil() as usize)..(high.ceil() as usize);
        for faces in by_level.iter_mut().take(crossed.end).skip(crossed.start) {
            faces.push(FaceId(f as u32));
        }
    }
    by_level
}

/// Follows level curves through the mesh, each once per level.
struct Tracer<'a> {
    mesh: &'a PassMesh,
    values: &'a [f64],
    seen: Vec<u32>,
    stamp: u32,
}

impl<'a> Tracer<'a> {
    fn new(mesh: &'a PassMesh, values: &'a [f64]) -> Self {
        Self { mesh, values, seen: vec![0; mesh.connectivity().face_count()], stamp: 1 }
    }

    fn next_level(&mut self) {
        self.stamp += 1;
    }

    /// The curve through `face`; `None` if it was traced before or leaves the mesh.
    fn trace(&mut self, face: FaceId, level: f64) -> Option<Vec<DVec2>> {
        let mut points = Vec::new();
        let mut at = face;
        while self.seen[at.index()] != self.stamp {
            self.seen[at.index()] = self.stamp;
            let exit = self.exit(at, level)?;
            points.push(self.crossing(exit, level));
            at = self.mesh.connectivity().opposite(exit)?.face();
        }
        points.dedup();
        (at == face && points.len() >= 3).then_some(points)
    }

    /// The side through which the curve, higher values on its right, leaves the face.
    ///
    /// A value equal to the level counts as below it, so that no curve passes through a vertex.
    fn exit(&self, face: FaceId, level: f64) -> Option<HalfEdgeId> {
        (0..3).map(|c| face.half_edge(c)).find(|&h| {
            let (a, b) = self.mesh.connectivity().ends(h);
            self.values[a.index()] > level && self.values[b.index()] <= level
        })
    }

    fn crossing(&self, side: HalfEdgeId, level: f64) -> DVec2 {
        let (a, b) = self.mesh.connectivity().ends(side);
        // From the lower vertex, so that both faces of the side get the same bits.
        let (a, b) = if a < b { (a, b) } else { (b, a) };
        let (u, v) = (self.values[a.index()], self.values[b.index()]);
        self.mesh.uv()[a.index()].lerp(self.mesh.uv()[b.index()], (level - u) / (v - u))
    }
}

#[cfg(test)]
mod tests;
