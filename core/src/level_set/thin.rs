//! A mesh with fewer vertices over the same chart, good enough to compare fields on.
//!
//! The boundary keeps its vertices; of the others, the one nearest to the middle of each cell of a square grid is
//! kept. They are joined by constrained Delaunay triangulation of their flat points.

use super::refine::{COARSE, PassMesh};
use crate::geometry::DVec2;
use crate::mesh::{Connectivity, VertexId};
use spade::handles::{FixedFaceHandle, PossiblyOuterTag};
use spade::{ConstrainedDelaunayTriangulation, Point2, Triangulation};

type Delaunay = ConstrainedDelaunayTriangulation<Point2<f64>>;

impl PassMesh {
    /// A mesh with about that many vertices between those of the boundary, on which fields can be compared but passes
    /// cannot be laid out; the mesh itself where it has hardly more.
    pub fn thinned(&self, inner: usize) -> Self {
        let all = self.uv().len();
        let boundary: usize = self.connectivity().boundary_loops().iter().map(Vec::len).sum();
        let is_worthwhile = all > 2 * inner + boundary;
        is_worthwhile.then(|| self.joined(&self.kept(inner))).flatten().unwrap_or(self.clone())
    }

    /// The boundary's vertices, loop by loop, then the inner ones that are kept.
    fn kept(&self, inner: usize) -> Vec<VertexId> {
        let low = self.uv().iter().copied().fold(DVec2::INFINITY, DVec2::min);
        let high = self.uv().iter().copied().fold(DVec2::NEG_INFINITY, DVec2::max);
        let size = high - low;
        let cell = (size.x * size.y / inner.max(1) as f64).sqrt();
        let [columns, rows] = [size.x, size.y].map(|s| (s / cell) as usize + 1);
        let mut nearest: Vec<(f64, Option<VertexId>)> = vec![(f64::INFINITY, None); columns * rows];
        for (i, p) in self.uv().iter().enumerate() {
            let v = VertexId(i as u32);
            let at = (*p - low) / cell;
            let off = (at - at.floor() - 0.5).length_squared();
            let place = &mut nearest[at.y as usize * columns + at.x as usize];
            if off < place.0 && !self.connectivity().is_boundary(v) {
                *place = (off, Some(v));
            }
        }
        let loops = self.connectivity().boundary_loops().iter().flatten().copied();
        loops.chain(nearest.into_iter().filter_map(|n| n.1)).collect()
    }

    /// The mesh of these vertices; `None` where they cannot be joined.
    fn joined(&self, kept: &[VertexId]) -> Option<Self> {
        let mut delaunay = Delaunay::new();
        for v in kept {
            let p = self.uv()[v.index()];
            delaunay.insert(Point2::new(p.x, p.y)).ok()?;
        }
        if delaunay.num_vertices() != kept.len() {
            return None;
        }
        let mut first = 0;
        for cycle in self.connectivity().boundary_loops() {
            for i in 0..cycle.len() {
                let ends = [i, (i + 1) % cycle.len()];
                let [a, b] = ends.map(|k| spade::handles::FixedVertexHandle::from_index(first + k));
                if !delaunay.can_add_constraint(a, b) {
                    return None;
                }
                delaunay.add_constraint(a, b);
            }
            first += cycle.len();
        }
        let corners = |f: &FixedFaceHandle<PossiblyOuterTag>| {
            let face = delaunay.face(*f).as_inner()?;
            Some(face.vertices().map(|v| VertexId(v.fix().index() as u32)))
        };
        let faces = within(&delaunay).iter().filter_map(corners).collect();
        let connectivity = Connectivity::new(kept.len(), faces).ok()?;
        self.with_vertices(connectivity, kept).with_edges_below(COARSE).ok()
    }
}

/// The faces inside the constraints: those separated from the outside by an odd number of constraints.
fn within(delaunay: &Delaunay) -> Vec<FixedFaceHandle<PossiblyOuterTag>> {
    let mut crossed: Vec<Option<bool>> = vec![None; delaunay.num_all_faces()];
    let outer = delaunay.outer_face().fix();
    crossed[outer.index()] = Some(false);
    let mut open: Vec<_> = (delaunay.convex_hull())
        .map(|edge| (edge.rev().face().fix(), edge.is_constraint_edge()))
        .collect();
    let mut out = Vec::new();
    while let Some((face, inside)) = open.pop() {
        if crossed[face.index()].is_some() {
            continue;
        }
        crossed[face.index()] = Some(inside);
        if inside {
            out.push(face);
        }
        let Some(face) = delaunay.face(face).as_inner() else { continue };
        for edge in face.adjacent_edges() {
            open.push((edge.rev().face().fix(), inside != edge.is_constraint_edge()));
        }
    }
    out
}
