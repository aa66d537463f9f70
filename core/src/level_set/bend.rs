//! How a field bends along the edges of the mesh: second differences from quadratic fits.
//!
//! Fast marching assumes a straight front between two vertices. Where the front is curved, the field there differs
//! from the chord by half the second difference times `t (1 - t)`; with this correction the error of the distance
//! falls with the square of the edge length.

use super::refine::PassMesh;
use crate::geometry::DVec2;
use crate::mesh::{HalfEdgeId, VertexId};
use nalgebra::{SMatrix, SVector};

/// Neighbours below which the second ring is taken in too: a quadric has five unknown terms.
const FEWEST: usize = 6;
/// Fraction of the largest diagonal term that is added to all diagonal terms: stabilises fits to few neighbours.
const DAMPING: f64 = 1e-6;

/// Second difference of a field along every side: one per half-edge.
///
/// Of the estimates at the two ends the smaller one counts, and none where their signs differ: across a ridge of the
/// field there is no second difference.
pub(super) fn second_differences(mesh: &PassMesh, values: &[f64]) -> Vec<f64> {
    let mut near = Vec::new();
    let count = values.len() as u32;
    let hessians: Vec<[f64; 3]> =
        (0..count).map(|v| hessian(mesh, values, VertexId(v), &mut near)).collect();
    let along = |v: VertexId, d: DVec2| {
        let [xx, xy, yy] = hessians[v.index()];
        xx * d.x * d.x + 2.0 * xy * d.x * d.y + yy * d.y * d.y
    };
    let sides = 3 * mesh.connectivity().face_count() as u32;
    let difference = |side: HalfEdgeId| {
        let (a, b) = mesh.connectivity().ends(side);
        let d = mesh.uv()[b.index()] - mesh.uv()[a.index()];
        smaller(along(a, d), along(b, d))
    };
    (0..sides).map(|h| difference(HalfEdgeId(h))).collect()
}

/// The one nearer to 0; 0 where the signs differ.
fn smaller(a: f64, b: f64) -> f64 {
    match (a * b > 0.0, a.abs() < b.abs()) {
        (false, _) => 0.0,
        (true, true) => a,
        (true, false) => b,
    }
}

/// Second derivatives `xx, xy, yy` of the field at a vertex, per flat mm²; 0 where its neighbours do not determine
/// them.
fn hessian(mesh: &PassMesh, values: &[f64], v: VertexId, near: &mut Vec<VertexId>) -> [f64; 3] {
    near.clear();
    near.extend(mesh.neighbours(v));
    if near.len() < FEWEST {
        for i in 0..near.len() {
            for w in mesh.neighbours(near[i]) {
                if w != v && !near.contains(&w) {
                    near.push(w);
                }
            }
        }
    }
    let (origin, here) = (mesh.uv()[v.index()], values[v.index()]);
    let offset = |w: &VertexId| mesh.uv()[w.index()] - origin;
    let reach = near.iter().map(|w| offset(w).length()).fold(0.0, f64::max);
    let mut matrix = SMatrix::<f64, 5, 5>::zeros();
    let mut right = SVector::<f64, 5>::zeros();
    for w in near.iter().filter(|w| values[w.index()].is_finite()) {
        let d = offset(w) / reach;
        let row = [d.x, d.y, 0.5 * d.x * d.x, d.x * d.y, 0.5 * d.y * d.y];
        let rise = values[w.index()] - here;
        for (i, x) in row.into_iter().enumerate() {
            // The factorisation reads nothing above the diagonal.
            row[..=i].iter().enumerate().for_each(|(j, y)| matrix[(i, j)] += x * y);
            right[i] += x * rise;
        }
    }
    let damping = DAMPING * matrix.diagonal().max();
    matrix += SMatrix::<f64, 5, 5>::identity() * damping;
    let solved = matrix.cholesky().map(|c| c.solve(&right) / (reach * reach));
    match solved {
        Some(c) if c.iter().all(|c| c.is_finite()) => [c[2], c[3], c[4]],
        _ => [0.0; 3],
    }
}
