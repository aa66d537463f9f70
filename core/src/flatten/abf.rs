//! Angle-based flattening: the conformal map whose flat angles are nearest the surface's.
//!
//! Terms, as in the sources. `a` are the sought flat angles, three per face; `b` their targets,
//! the surface's angles scaled to sum to 2 pi around an interior vertex, unscaled at the boundary;
//! `w = 1 / b^2` the weights. The constraints are that each face's angles sum to pi, that those
//! around an interior vertex sum to 2 pi (*planarity*), and that its *wheel* of faces closes:
//! `sum ln(sin a_next) - ln(sin a_prev) = 0`.
//!
//! Steps, repeated until the constraints hold: 1 linearise the constraints at `a`; 2 eliminate the
//! faces' own constraint, face by face; 3 solve for the two multipliers of each interior vertex;
//! 4 move `a` to the minimum, less far if an angle would come close to zero, whose weight then
//! rises.

use std::f64::consts::{PI, TAU};

use super::angle_layout::lay_out;
use super::chart::Chart;
use super::disk::Disk;
use super::error::FlattenError;
use super::intrinsic::measure;
use super::laplace::Interior;
use crate::geometry::math::{cos, ln, sin};
use crate::linalg::{
    Cholesky, NotPositiveDefinite, SymmetricMatrix, conjugate_gradients, nested_dissection,
};
use crate::surface::Surface;

/// Constraint residual at which the iteration ends, rad: just above what rounding leaves.
const CLOSED: f64 = 1e-11;
/// Largest constraint residual of an accepted result, rad.
const ACCEPTED: f64 = 1e-8;
/// Steps after which the iteration gives up; meshes without needles take 4 to 8.
const MOST_STEPS: usize = 60;
/// The multipliers may leave this multiple of the squared residual in the linearised constraints,
/// which is what linearising leaves anyway: more costs steps, less conjugate gradient steps.
const SLACK: f64 = 0.1;
/// Conjugate gradient steps that cost as much as a new factorisation.
const FACTOR_WORTH: usize = 8;
/// Part of an angle that must remain after one step.
const KEPT: f64 = 0.1;
/// Factor on `1 / w` of an angle that one step would have made smaller than that.
const STIFFEN: f64 = 0.25;

/// Result of [`abf`].
#[derive(Clone, Debug)]
pub struct AngleBased {
    /// The chart.
    pub chart: Chart,
    /// The flat angles, `#F` by 3, rad.
    pub angles: Vec<[f64; 3]>,
    /// Steps of the iteration.
    pub steps: usize,
    /// Largest residual of the constraints: rad, and for wheels the logarithm.
    pub residual: f64,
}

/// The angle-based chart, checked: no face turned over, no overlap.
///
/// # Errors
/// [`FlattenError`] when the surface is not a disk with holes, when the angles do not converge, or
/// when the chart is not valid.
///
/// # Source
/// Energy and constraints: Sheffer, de Sturler, Engineering with Computers 17, 2001. Reduction:
/// Sheffer, Lévy, Mogilnitsky, Bogomyakov, "ABF++", TOG 2005. Logarithmic wheel condition and
/// least squares: Zayer, Lévy, Seidel, "Linear Angle Based Parameterization", SGP 2007, repeated
/// here until the constraints hold.
pub fn abf(surface: &Surface) -> Result<AngleBased, FlattenError> {
    let flattening = abf_unchecked(surface)?;
    flattening.chart.validate(surface)?;
    Ok(flattening)
}

/// As [`abf`], without the check that the chart is valid.
///
/// # Errors
/// [`FlattenError`] when the surface is not a disk with holes, or the angles do not converge.
pub fn abf_unchecked(surface: &Surface) -> Result<AngleBased, FlattenError> {
    let disk = Disk::new(surface)?;
    let (mut angles, steps, residual) = solve_angles(&disk)?;
    let mut flat = lay_out(&disk, &angles)?;
    flat.truncate(surface.positions().len());
    angles.truncate(disk.surface_faces);
    Ok(AngleBased { chart: Chart::new(surface, flat), angles, steps, residual })
}

/// Flat angles that satisfy the constraints, the steps taken and the residual left.
fn solve_angles(disk: &Disk) -> Result<(Vec<[f64; 3]>, usize, f64), FlattenError> {
    let mut problem = AngleProblem::new(disk)?;
    let mut system = VertexSystem::new(disk, &problem.interior);
    let mut best = f64::INFINITY;
    for steps in 0..MOST_STEPS {
        let constraints = problem.constraints();
        let residual = problem.residual(&constraints);
        // Below the accepted residual, another step that gains nothing is rounding.
        if residual < CLOSED || (best < ACCEPTED && residual > 0.5 * best) {
            return Ok((problem.angles, steps, residual));
        }
        best = best.min(residual);
        let multipliers = system.solve(disk, &problem, constraints, residual)?;
        problem.advance(multipliers);
    }
    Err(FlattenError::NotConverged { residual: best, steps: MOST_STEPS, limit: ACCEPTED })
}

/// The energy and the constraints at the present angles.
struct AngleProblem {
    /// Unknown of each corner's vertex, `u32::MAX` on the boundary.
    corners: Vec<[u32; 3]>,
    interior: Interior,
    targets: Vec<[f64; 3]>,
    /// `1 / w`.
    compliance: Vec<[f64; 3]>,
    angles: Vec<[f64; 3]>,
    /// Cotangents of `angles`.
    cotangents: Vec<[f64; 3]>,
}

/// Planarity and wheel residual of every unknown vertex.
type VertexConstraints = Vec<[f64; 2]>;

impl AngleProblem {
    fn new(disk: &Disk) -> Result<Self, FlattenError> {
        let (mut targets, _) = measure(disk)?;
        let interior = Interior::new(disk);
        let faces = disk.connectivity.faces();
        let corners: Vec<[u32; 3]> =
            faces.iter().map(|f| f.map(|v| interior.unknown[v.index()])).collect();
        let mut sums = vec![0.0; interior.vertex.len()];
        for (corner, angle) in corners.iter().flatten().zip(targets.iter().flatten()) {
            if let Some(sum) = sums.get_mut(*corner as usize) {
                *sum += angle;
            }
        }
        for (corner, angle) in corners.iter().flatten().zip(targets.iter_mut().flatten()) {
            if let Some(sum) = sums.get(*corner as usize) {
                *angle *= TAU / sum;
            }
        }
        let compliance = targets.iter().map(|b| b.map(|b| b * b)).collect();
        let angles: Vec<[f64; 3]> =
            targets.iter().map(|b| b.map(|a| a * PI / (b[0] + b[1] + b[2]))).collect();
        let cotangents = vec![[0.0; 3]; angles.len()];
        Ok(Self { corners, interior, targets, compliance, angles, cotangents })
    }

    /// Residuals of the vertex constraints; brings the cotangents up to date.
    fn constraints(&mut self) -> VertexConstraints {
        let mut planarity_and_product = vec![[-TAU, 1.0]; self.interior.vertex.len()];
        for (f, corners) in self.corners.iter().enumerate() {
            let sines = self.angles[f].map(sin);
            (0..3).for_each(|c| self.cotangents[f][c] = cos(self.angles[f][c]) / sines[c]);
            for c in 0..3 {
                if let Some(vertex) = planarity_and_product.get_mut(corners[c] as usize) {
                    vertex[0] += self.angles[f][c];
                    vertex[1] *= sines[(c + 1) % 3] / sines[(c + 2) % 3];
                }
            }
        }
        for vertex in &mut planarity_and_product {
            vertex[1] = ln(vertex[1]);
        }
        planarity_and_product
    }

    /// Largest residual of all constraints; not a number if any is.
    fn residual(&self, vertices: &VertexConstraints) -> f64 {
        let faces = self.angles.iter().map(|a| a[0] + a[1] + a[2] - PI);
        let all = faces.chain(vertices.iter().flatten().copied());
        all.fold(0.0, |most: f64, r| if most.is_nan() || r.abs() <= most { most } else { r.abs() })
    }

    /// The step that fulfils the face's own constraint alone, and the projected compliance
    /// `P = W - W 1 1^T W / (1^T W 1)` under which further steps keep it.
    fn face_step(&self, f: usize) -> ([f64; 3], [[f64; 3]; 3]) {
        let (a, b, w) = (self.angles[f], self.targets[f], self.compliance[f]);
        let total = w[0] + w[1] + w[2];
        let lack = (PI - (b[0] + b[1] + b[2])) / total;
        let step = [0, 1, 2].map(|i| b[i] - a[i] + w[i] * lack);
        let mut projected = [[0.0; 3]; 3];
        for i in 0..3 {
            for j in 0..3 {
                projected[i][j] = -w[i] * w[j] / total;
            }
            projected[i][i] += w[i];
        }
        (step, projected)
    }

    /// Derivatives of the planarity and wheel constraints of the face's corners by its angles:
    /// `rows[2 c]` and `rows[2 c + 1]` for corner `c`.
    fn gradients(&self, f: usize) -> [[f64; 3]; 6] {
        let cot = self.cotangents[f];
        let mut rows = [[0.0; 3]; 6];
        for c in 0..3 {
            rows[2 * c][c] = 1.0;
            rows[2 * c + 1][(c + 1) % 3] = cot[(c + 1) % 3];
            rows[2 * c + 1][(c + 2) % 3] = -cot[(c + 2) % 3];
        }
        rows
    }

    /// Moves the angles to the minimum that the multipliers describe, or as far toward it as
    /// every angle stays positive.
    fn advance(&mut self, multipliers: &[[f64; 1]]) {
        let mut length: f64 = 1.0;
        let mut steps = Vec::with_capacity(self.angles.len());
        for f in 0..self.angles.len() {
            let (mut step, projected) = self.face_step(f);
            let rows = self.gradients(f);
            let mut force = [0.0; 3];
            for c in 0..3 {
                let at = 2 * self.corners[f][c] as usize;
                if let Some([plane, wheel]) = multipliers.get(at..at + 2) {
                    (0..3).for_each(|i| {
                        force[i] += rows[2 * c][i] * plane[0] + rows[2 * c + 1][i] * wheel[0];
                    });
                }
            }
            for i in 0..3 {
                step[i] += dot(projected[i], force);
                let angle = self.angles[f][i];
                if angle + step[i] < KEPT * angle {
                    length = length.min((KEPT - 1.0) * angle / step[i]);
                    self.compliance[f][i] *= STIFFEN;
                }
            }
            steps.push(step);
        }
        for (angles, step) in self.angles.iter_mut().zip(&steps) {
            (0..3).for_each(|i| angles[i] += length * step[i]);
        }
    }
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// The normal equations of the multipliers, two per unknown vertex.
struct VertexSystem {
    matrix: SymmetricMatrix,
    /// Where each face's 6 by 6 lower triangle goes among the matrix's values.
    slots: Vec<[u32; 21]>,
    order: Vec<u32>,
    /// Factor of the matrix of an earlier step.
    factor: Option<Cholesky>,
    /// Multipliers of the last step, two rows per vertex.
    multipliers: Vec<[f64; 1]>,
}

const NO_SLOT: u32 = u32::MAX;

impl VertexSystem {
    fn new(disk: &Disk, interior: &Interior) -> Self {
        let n = interior.vertex.len();
        let mut pairs = Vec::new();
        let connectivity = &disk.connectivity;
        for face in connectivity.faces() {
            for c in 0..3 {
                let ends = (interior.of(face[c].0), interior.of(face[(c + 1) % 3].0));
                // An edge inside is seen from both its faces; one direction suffices.
                if let (Some(i), Some(j)) = ends
                    && i < j
                {
                    pairs.push((i, j, 0.0));
                }
            }
        }
        let graph = SymmetricMatrix::new(&vec![0.0; n], &pairs);
        let order = nested_dissection(&graph.adjacency(), &interior.positions(disk));
        let mut entries: Vec<(u32, u32, f64)> =
            (0..n as u32).map(|i| (2 * i, 2 * i + 1, 0.0)).collect();
        for (i, j, _) in pairs {
            entries
                .extend([(0, 0), (0, 1), (1, 0), (1, 1)].map(|(a, b)| (2 * i + a, 2 * j + b, 0.0)));
        }
        let matrix = SymmetricMatrix::new(&vec![0.0; 2 * n], &entries);
        let slots = connectivity
            .faces()
            .iter()
            .map(|f| face_slots(&matrix, f.map(|v| interior.unknown[v.index()])))
            .collect();
        let order = order.iter().flat_map(|&v| [2 * v, 2 * v + 1]).collect();
        Self { matrix, slots, order, factor: None, multipliers: vec![[0.0]; 2 * n] }
    }

    /// The multipliers of the linearised problem, whose constraints are off by `residual`.
    fn solve(
        &mut self,
        disk: &Disk,
        problem: &AngleProblem,
        constraints: VertexConstraints,
        residual: f64,
    ) -> Result<&[[f64; 1]], FlattenError> {
        let right = self.assemble(problem, constraints);
        let tolerance = (SLACK * residual * residual).clamp(0.1 * CLOSED, SLACK * residual);
        let solved = self.factor.as_ref().is_some_and(|factor| {
            let x = &mut self.multipliers;
            conjugate_gradients(&self.matrix, factor, &right, x, tolerance, FACTOR_WORTH)
        });
        if !solved {
            self.multipliers.copy_from_slice(&right);
            let factor = self.refactor().map_err(|fault| FlattenError::Singular {
                system: "angle",
                at: disk.positions[problem.interior.vertex[fault.row as usize / 2] as usize],
            })?;
            factor.solve(&mut self.multipliers);
            self.factor = Some(factor);
        }
        Ok(&self.multipliers)
    }

    /// Sets the matrix to that of the present angles; returns the right-hand side.
    fn assemble(
        &mut self,
        problem: &AngleProblem,
        constraints: VertexConstraints,
    ) -> Vec<[f64; 1]> {
        let mut right: Vec<[f64; 1]> = constraints.iter().flatten().map(|c| [-c]).collect();
        let values = self.matrix.values_mut();
        values.fill(0.0);
        for (f, slots) in self.slots.iter().enumerate() {
            let (step, projected) = problem.face_step(f);
            let rows = problem.gradients(f);
            let mut slot = slots.iter();
            for i in 0..6 {
                let at = problem.corners[f][i / 2] as usize;
                if let Some(r) = right.get_mut(2 * at + i % 2) {
                    r[0] -= dot(rows[i], step);
                }
                let pushed = [0, 1, 2].map(|k| dot(projected[k], rows[i]));
                for (row, &slot) in rows[..=i].iter().zip(&mut slot) {
                    if slot != NO_SLOT {
                        values[slot as usize] += dot(*row, pushed);
                    }
                }
            }
        }
        right
    }

    fn refactor(&mut self) -> Result<Cholesky, NotPositiveDefinite> {
        match self.factor.take() {
            Some(mut factor) => factor.refactor(&self.matrix).map(|()| factor),
            None => Cholesky::new(&self.matrix, &self.order),
        }
    }
}

/// Slots of the 6 by 6 lower triangle of a face, row by row.
fn face_slots(matrix: &SymmetricMatrix, corners: [u32; 3]) -> [u32; 21] {
    let mut slots = [NO_SLOT; 21];
    let mut k = 0;
    for i in 0..6 {
        for j in 0..=i {
            let (a, b) = (corners[i / 2], corners[j / 2]);
            if a != u32::MAX && b != u32::MAX {
                let slot = matrix.slot(2 * a + (i % 2) as u32, 2 * b + (j % 2) as u32);
                slots[k] = slot.map_or(NO_SLOT, |s| s as u32);
            }
            k += 1;
        }
    }
    slots
}
