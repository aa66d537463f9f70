//! Long, thin triangles, cut across before sides are halved: halving makes three of one for half the length, where two
//! would do, so that a strip as long as a thousand passes would become tens of thousands of triangles.
//!
//! 1. Sides of needles are divided into pieces about as long as the needle is wide, or one pass.
//! 2. A triangle is cut into triangles between the places of the side that has most and those of the two others, the
//!    shorter way across first.
//! 3. Beside a needle others may become thin; so once more, until none is.

use super::{PassMesh, heron};
use crate::level_set::LevelSetError;
use crate::mesh::{Connectivity, FaceId, HalfEdgeId, VertexId};

/// Width over length up to which a triangle is a needle.
const NARROW: f64 = 0.2;
/// Greatest number of rounds.
const ROUNDS: usize = 6;

impl PassMesh {
    /// Cuts needles with sides longer than `longest` passes across.
    pub(super) fn with_needles_cut(self, longest: f64) -> Result<Self, LevelSetError> {
        let mut mesh = self;
        for _ in 0..ROUNDS {
            let Some(next) = mesh.cut_across(longest)? else { break };
            mesh = next;
        }
        Ok(mesh)
    }

    /// Into how many pieces each side is divided.
    fn pieces(&self, longest: f64) -> Vec<u32> {
        let mut pieces = vec![1u32; 3 * self.connectivity.face_count()];
        for f in 0..self.connectivity.face_count() as u32 {
            let sides = [0, 1, 2].map(|i| FaceId(f).half_edge(i));
            let lengths = sides.map(|h| self.pass_length(h));
            let long = lengths.into_iter().fold(0.0, f64::max);
            let width = 2.0 * heron(lengths) / long.max(f64::MIN_POSITIVE);
            if long <= longest || width > NARROW * long {
                continue;
            }
            for (side, length) in sides.into_iter().zip(lengths) {
                // More than any mesh may have is too many in any case.
                let count = (length / width.max(longest)).ceil().clamp(1.0, 1e9) as u32;
                for h in core::iter::once(side).chain(self.connectivity.opposite(side)) {
                    pieces[h.index()] = pieces[h.index()].max(count);
                }
            }
        }
        pieces
    }

    /// One round; `None` where there is nothing to cut.
    fn cut_across(&self, longest: f64) -> Result<Option<Self>, LevelSetError> {
        let pieces = self.pieces(longest);
        let more: f64 = pieces.iter().map(|n| f64::from(n - 1)).sum();
        if more == 0.0 {
            return Ok(None);
        }
        if self.connectivity.face_count() as f64 + more > self.most_faces as f64 {
            return Err(self.too_many());
        }
        let mut next = self.clone_to_refine();
        // First of the places on each side, and whether they are numbered from its end.
        let mut first = vec![(u32::MAX, false); pieces.len()];
        for h in 0..pieces.len() {
            if pieces[h] == 1 || first[h].0 != u32::MAX {
                continue;
            }
            let side = HalfEdgeId(h as u32);
            let (a, b) = self.connectivity.ends(side);
            first[h] = (next.uv.len() as u32, false);
            if let Some(o) = self.connectivity.opposite(side) {
                first[o.index()] = (first[h].0, true);
            }
            for k in 1..pieces[h] {
                next.push_between(a.index(), b.index(), f64::from(k) / f64::from(pieces[h]));
            }
        }
        let on_side = |h: HalfEdgeId| {
            let (count, (first, is_back)) = (pieces[h.index()] - 1, first[h.index()]);
            (0..count).map(move |k| VertexId(first + if is_back { count - 1 - k } else { k }))
        };
        let mut faces = Vec::with_capacity(self.connectivity.face_count() + more as usize);
        for (f, face) in self.connectivity.faces().iter().enumerate() {
            let sides = [0, 1, 2].map(|i| FaceId(f as u32).half_edge(i));
            let base = (0..3).max_by_key(|&i| pieces[sides[i].index()]).unwrap_or(0);
            let [own, after, last] = [0, 1, 2].map(|k| (base + k) % 3);
            if pieces[sides[own].index()] == 1 {
                faces.push(*face);
                continue;
            }
            // Around the triangle, from the end of the base on.
            let mut around = Vec::new();
            for k in [after, last, own] {
                around.push(face[k]);
                around.extend(on_side(sides[k]));
            }
            let count = around.len();
            let of_base = pieces[sides[own].index()] as usize;
            let mut lower = around[count - of_base..].to_vec();
            lower.push(around[0]);
            around.truncate(count + 1 - of_base);
            around.reverse();
            next.between(&lower, &around, &mut faces);
        }
        // Dividing sides keeps a manifold a manifold.
        let connectivity = Connectivity::new(next.uv.len(), faces);
        debug_assert!(connectivity.is_ok(), "cutting needles broke the mesh");
        let Ok(connectivity) = connectivity else { return Ok(None) };
        next.connectivity = connectivity;
        Ok(Some(next))
    }

    /// Pushes the triangles between two chains with the same ends, the lower one of three places at least. All within are
    /// off the other chain, so that no triangle lies on a side.
    fn between(&self, lower: &[VertexId], upper: &[VertexId], out: &mut Vec<[VertexId; 3]>) {
        let (n, m) = (lower.len() - 1, upper.len() - 1);
        out.push([lower[0], lower[1], upper[1]]);
        let (mut i, mut j) = (1, 1);
        while i < n - 1 || j < m - 1 {
            let across =
                |i: usize, j: usize| self.passes_between(lower[i].index(), upper[j].index());
            let is_below = match (i < n - 1, j < m - 1) {
                (true, true) => across(i + 1, j) <= across(i, j + 1),
                (below, _) => below,
            };
            if is_below {
                out.push([lower[i], lower[i + 1], upper[j]]);
                i += 1;
            } else {
                out.push([lower[i], upper[j + 1], upper[j]]);
                j += 1;
            }
        }
        out.push([lower[i], lower[n], upper[j]]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{DVec2, DVec3};
    use crate::level_set::strip_metric::even;

    /// A square of 100 mm in that many strips, whose passes are 1 mm apart.
    fn strips(count: u32) -> PassMesh {
        let x = |i: u32| 100.0 * f64::from(i) / f64::from(count);
        let uv: Vec<DVec2> =
            (0..=count).flat_map(|i| [DVec2::new(x(i), 0.0), DVec2::new(x(i), 100.0)]).collect();
        let faces = (0..count).flat_map(|i| {
            let [a, b, c, d] = [2 * i, 2 * i + 2, 2 * i + 3, 2 * i + 1].map(VertexId);
            [[a, b, c], [a, c, d]]
        });
        let positions: Vec<DVec3> = uv.iter().map(|p| p.extend(0.0)).collect();
        let connectivity = Connectivity::new(uv.len(), faces.collect()).unwrap();
        let (scale, metric) = (vec![1.0; uv.len()], vec![even(1.0); uv.len()]);
        PassMesh::coarse_of_faces(connectivity, uv, scale, positions, metric).unwrap()
    }

    #[test]
    fn strips_take_about_as_many_triangles_as_squares() {
        for count in [100, 400, 1000] {
            let mesh = strips(count).with_edges_below(1.0).unwrap();
            let faces = mesh.connectivity().faces();
            let area = |f: &[VertexId; 3]| {
                let [a, b, c] = f.map(|v| mesh.uv()[v.index()]);
                0.5 * (b - a).perp_dot(c - a)
            };
            assert!(faces.iter().all(|f| area(f) > 0.0));
            let sum: f64 = faces.iter().map(area).sum();
            assert!((sum - 1e4).abs() < 1e-6, "{sum}");
            // Two triangles a pass along each strip; where a strip is wider than a pass, halves of these. Halving alone makes
            // twenty times as many of a hundred strips.
            let least = 2.0 * 100.0 * f64::from(count);
            assert!(faces.len() as f64 <= 6.0 * least, "{count}: {}", faces.len());
        }
    }
}
