//! Poisson problems on a disk with values given on its boundary.

use super::disk::Disk;
use super::error::FlattenError;
use crate::geometry::{DVec2, DVec3};
use crate::linalg::{Cholesky, SymmetricMatrix, nested_dissection};
use crate::mesh::VertexId;

const NONE: u32 = u32::MAX;

/// The cotangent Laplacian of a disk, factored over its interior vertices.
pub(super) struct DirichletLaplacian {
    interior: Interior,
    factor: Cholesky,
    /// `(interior unknown, boundary vertex, weight)` of the edges that reach the boundary.
    coupling: Vec<(u32, u32, f64)>,
}

/// Numbering of the vertices inside a disk.
pub(super) struct Interior {
    /// Vertex of each unknown.
    pub vertex: Vec<u32>,
    /// Unknown of each vertex, `u32::MAX` on the boundary and for unused vertices.
    pub unknown: Vec<u32>,
}

impl Interior {
    /// Numbers the vertices inside `disk`.
    pub fn new(disk: &Disk) -> Self {
        let connectivity = &disk.connectivity;
        let mut unknown = vec![NONE; connectivity.vertex_count()];
        let mut vertex = Vec::with_capacity(unknown.len());
        for v in 0..unknown.len() as u32 {
            let used = connectivity.leaving(VertexId(v)).is_some();
            if used && !connectivity.is_boundary(VertexId(v)) {
                unknown[v as usize] = vertex.len() as u32;
                vertex.push(v);
            }
        }
        Self { vertex, unknown }
    }

    /// The unknown of a vertex, if it has one.
    pub fn of(&self, vertex: u32) -> Option<u32> {
        let unknown = self.unknown[vertex as usize];
        (unknown != NONE).then_some(unknown)
    }

    /// Positions of the unknowns' vertices, for ordering.
    pub fn positions(&self, disk: &Disk) -> Vec<DVec3> {
        self.vertex.iter().map(|&v| disk.positions[v as usize]).collect()
    }
}

impl DirichletLaplacian {
    /// The Laplacian of edges with the given weights.
    ///
    /// # Errors
    /// [`FlattenError::Singular`] when it cannot be factored.
    pub fn new(disk: &Disk, weights: Vec<(u32, u32, f64)>) -> Result<Self, FlattenError> {
        let interior = Interior::new(disk);
        let mut diagonal = vec![0.0; interior.vertex.len()];
        let mut entries = Vec::with_capacity(weights.len());
        let mut coupling = Vec::new();
        for (a, b, w) in weights {
            if a == b {
                continue; // a loop of the intrinsic triangulation joins a vertex to itself
            }
            let ends = (interior.of(a), interior.of(b));
            for end in [ends.0, ends.1].into_iter().flatten() {
                diagonal[end as usize] += w;
            }
            match ends {
                (Some(i), Some(j)) => entries.push((i, j, -w)),
                (Some(i), None) => coupling.push((i, b, w)),
                (None, Some(j)) => coupling.push((j, a, w)),
                (None, None) => {}
            }
        }
        let matrix = SymmetricMatrix::new(&diagonal, &entries);
        drop(entries);
        let order = nested_dissection(&matrix.adjacency(), &interior.positions(disk));
        let factor = Cholesky::new(&matrix, &order).map_err(|fault| FlattenError::Singular {
            system: "Laplace",
            at: disk.positions[interior.vertex[fault.row as usize] as usize],
        })?;
        Ok(Self { interior, factor, coupling })
    }

    /// Solves `A u = source` inside with `u = 0` on the boundary; `source` and `u` per vertex.
    pub fn solve_zero_boundary(&self, source: &[f64]) -> Vec<f64> {
        let mut x: Vec<[f64; 1]> =
            self.interior.vertex.iter().map(|&v| [source[v as usize]]).collect();
        self.factor.solve(&mut x);
        let mut u = vec![0.0; source.len()];
        for (&v, x) in self.interior.vertex.iter().zip(&x) {
            u[v as usize] = x[0];
        }
        u
    }

    /// Integrated outward derivative at the boundary vertices of a `u` that is zero there.
    pub fn outward_flux(&self, u: &[f64]) -> Vec<f64> {
        let mut flux = vec![0.0; u.len()];
        for &(i, b, w) in &self.coupling {
            flux[b as usize] -= w * u[self.interior.vertex[i as usize] as usize];
        }
        flux
    }

    /// Replaces the interior values of `points` by the harmonic extension of the boundary's.
    pub fn extend(&self, points: &mut [DVec2]) {
        let mut x = vec![[0.0; 2]; self.interior.vertex.len()];
        for &(i, b, w) in &self.coupling {
            let p = points[b as usize];
            x[i as usize][0] += w * p.x;
            x[i as usize][1] += w * p.y;
        }
        self.factor.solve(&mut x);
        for (&v, x) in self.interior.vertex.iter().zip(&x) {
            points[v as usize] = DVec2::new(x[0], x[1]);
        }
    }
}
