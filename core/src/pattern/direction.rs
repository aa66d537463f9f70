//! The direction field: a potential whose gradient follows the best cross directions.
//!
//! - *Best cross direction* of a face: the one in which the strip is the widest, an eigenvector of the
//!   strip metric. It has no sign.
//! - *Target*: a flat gradient that grows by 1 per strip, in a direction between the best one and that of the
//!   previous field, depending on the gain.
//!
//! 1. The previous field is at first the best iso-scallop or iso-planar field: it supplies the sign, and the
//!    direction where all are equally good.
//! 2. The potential is the least-squares solution `integral of |grad phi - V|²`, a Poisson equation; it is the
//!    previous field of the next round.
//!
//! The map is conformal, so the flat Dirichlet energy equals that of the surface.
//!
//! # Source
//! Zou, Wang, Feng, "A new approach to generating iso-level tool paths: length-optimal tool path
//! planning for freeform surfaces with preferred feed directions", CAD 2020.

use crate::geometry::{DVec2, DVec3};
use crate::level_set::strip_metric::FlatMetric;
use crate::level_set::{LevelSetError, PassField, PassMesh};
use crate::linalg::{Cholesky, SymmetricMatrix, nested_dissection};
use crate::mesh::{FaceId, VertexId};

/// Solves, each with targets from the previous one.
const ROUNDS: usize = 6;
/// Gains, as a fraction of the strip, at which the best direction has half the weight: from following it closely to
/// hardly at all.
pub const STRENGTHS: [f64; 5] = [0.1, 0.2, 0.4, 0.8, 1.6];

/// What is known of a face.
#[derive(Copy, Clone)]
struct Cell {
    metric: FlatMetric,
    /// Flat unit vector across the best feed direction.
    across: DVec2,
    /// Weight of the best direction: 0 none, approaching 1.
    decided: f64,
    area: f64,
    /// Flat gradients of the three corners' hat functions.
    hats: [DVec2; 3],
}

/// The potential at the vertices, passes; `like`: the field before the first round; `half`: the gain, as a fraction
/// of the strip, at which the best direction has half the weight.
///
/// # Errors
/// [`LevelSetError::Uneven`] when the equations cannot be solved.
pub fn potential(mesh: &PassMesh, like: &PassField, half: f64) -> Result<Vec<f64>, LevelSetError> {
    let cells = cells(mesh, half);
    let factor = laplacian(mesh, &cells)?;
    let mut values = like.values().to_vec();
    for _ in 0..ROUNDS {
        let mut right = sources(mesh, &cells, &values);
        factor.solve(&mut right);
        values = right.into_iter().map(|[x]| x).collect();
    }
    Ok(values)
}

fn cells(mesh: &PassMesh, half: f64) -> Vec<Option<Cell>> {
    let cell = |f: usize| {
        let face = FaceId(f as u32);
        let metric = mesh.flat_metric(face)?;
        let [a, b, c] = mesh.connectivity().face(face).map(|v| mesh.uv()[v.index()]);
        let twice_area = (b - a).perp_dot(c - a);
        let gain = metric.anisotropy();
        Some(Cell {
            metric,
            across: metric.direction_of_most().perp(),
            decided: gain * gain / (gain * gain + half * half),
            area: 0.5 * twice_area,
            hats: [c - b, a - c, b - a].map(|e| e.perp() / twice_area),
        })
    };
    (0..mesh.connectivity().face_count()).map(cell).collect()
}

/// The Laplacian, factored; the first vertex is fixed, since a potential is determined up to a constant.
fn laplacian(mesh: &PassMesh, cells: &[Option<Cell>]) -> Result<Cholesky, LevelSetError> {
    let mut diagonal = vec![0.0; mesh.uv().len()];
    let mut entries = Vec::with_capacity(3 * cells.len());
    for (cell, face) in cells.iter().zip(mesh.connectivity().faces()) {
        let Some(cell) = cell else { continue };
        for i in 0..3 {
            let j = (i + 1) % 3;
            diagonal[face[i].index()] += cell.area * cell.hats[i].length_squared();
            entries.push((face[i].0, face[j].0, cell.area * cell.hats[i].dot(cell.hats[j])));
        }
    }
    let largest = diagonal.iter().copied().fold(0.0, f64::max);
    for d in &mut diagonal {
        if *d == 0.0 {
            *d = largest;
        }
    }
    diagonal[0] += largest;
    let matrix = SymmetricMatrix::new(&diagonal, &entries);
    let places: Vec<DVec3> = mesh.uv().iter().map(|p| p.extend(0.0)).collect();
    let order = nested_dissection(&matrix.adjacency(), &places);
    Cholesky::new(&matrix, &order).map_err(|_| LevelSetError::Uneven { passes: f64::INFINITY })
}

/// Integrals of the targets against the gradients of the hat functions.
fn sources(mesh: &PassMesh, cells: &[Option<Cell>], before: &[f64]) -> Vec<[f64; 1]> {
    let mut right = vec![[0.0]; before.len()];
    for (cell, face) in cells.iter().zip(mesh.connectivity().faces()) {
        let Some(cell) = cell else { continue };
        let corners = face.map(VertexId::index);
        let gradient: DVec2 = (0..3).map(|i| cell.hats[i] * before[corners[i]]).sum();
        let way = gradient.normalize_or(cell.across);
        let across = if cell.across.dot(way) < 0.0 { -cell.across } else { cell.across };
        let toward = (across * cell.decided + way * (1.0 - cell.decided)).normalize_or(way);
        let target = toward / cell.metric.slope(toward);
        for (corner, hat) in corners.into_iter().zip(cell.hats) {
            right[corner][0] += cell.area * hat.dot(target);
        }
    }
    right
}
