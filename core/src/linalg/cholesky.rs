//! Multifrontal Cholesky factorisation of sparse symmetric positive definite matrices.
//!
//! Terms. The *front* of a supernode is its panel and, below and to the right of it, the *update*
//! it passes to its parent. Children's updates are added into the parent's front, the panel is
//! factored, and its outer product leaves the new update.

use thiserror::Error;

use super::dense::{Packed, Panel};
use super::matrix::SymmetricMatrix;
use super::symbolic::{ChildLists, Symbolic};

/// The matrix to be factored is not positive definite.
#[derive(Copy, Clone, Debug, PartialEq, Eq, Error)]
#[error(
    "the matrix is not positive definite at row {row}: the pivot is not a positive finite number"
)]
pub struct NotPositiveDefinite {
    /// Row of the matrix, as given.
    pub row: u32,
}

/// The factor `L` of `P A P^T = L L^T`.
///
/// # Source
/// Liu, "The multifrontal method for sparse matrix solution", SIAM Review 34, 1992.
#[derive(Clone, Debug)]
pub struct Cholesky {
    symbolic: Symbolic,
    values: Vec<f64>,
}

impl Cholesky {
    /// Factors `matrix`, eliminating rows in `order` (a permutation).
    ///
    /// # Errors
    /// [`NotPositiveDefinite`] with the first row whose pivot is not positive.
    pub fn new(matrix: &SymmetricMatrix, order: &[u32]) -> Result<Self, NotPositiveDefinite> {
        let symbolic = Symbolic::new(matrix, order);
        let total = symbolic.panel_start[symbolic.supernodes()];
        let mut factor = Self { symbolic, values: vec![0.0; total] };
        factor.eliminate(matrix.values())?;
        Ok(factor)
    }

    /// Factors another matrix with the same sparsity pattern in place.
    ///
    /// # Errors
    /// As [`Self::new`]; the factor is then unusable.
    pub fn refactor(&mut self, matrix: &SymmetricMatrix) -> Result<(), NotPositiveDefinite> {
        self.values.fill(0.0);
        self.eliminate(matrix.values())
    }

    /// Number of rows.
    pub fn size(&self) -> usize {
        self.symbolic.order.len()
    }

    /// Number of stored values of the factor.
    pub fn stored(&self) -> usize {
        self.values.len()
    }

    fn eliminate(&mut self, matrix: &[f64]) -> Result<(), NotPositiveDefinite> {
        let symbolic = &self.symbolic;
        let count = symbolic.supernodes();
        let mut children = ChildLists::new(count);
        let mut updates: Vec<Vec<f64>> = vec![Vec::new(); count];
        let mut place = vec![0u32; self.size()];
        let mut packed = Packed::default();
        for s in 0..count {
            let columns = symbolic.columns(s);
            let rows = symbolic.rows_of(s);
            for (i, &row) in rows.iter().enumerate() {
                place[row as usize] = i as u32;
            }
            let values = &mut self.values[symbolic.panel_start[s]..symbolic.panel_start[s + 1]];
            let mut panel = Panel { values, height: rows.len(), width: columns.len() };
            symbolic.assemble(&mut panel, columns.clone(), matrix, &place);
            let below = panel.height - panel.width;
            let mut update = vec![0.0; below * below];
            let mut child = children.first(s);
            while let Some(c) = child {
                let passed = std::mem::take(&mut updates[c]);
                let from = &symbolic.rows_of(c)[symbolic.columns(c).len()..];
                extend_add(&mut panel, &mut update, &passed, from, &place);
                child = children.next(c);
            }
            panel
                .factor(&mut packed)
                .map_err(|j| NotPositiveDefinite { row: symbolic.order[columns.start + j] })?;
            if below > 0 {
                panel.subtract_below(&mut update, &mut packed);
                updates[s] = update;
                children.add(symbolic.parent[s] as usize, s);
            }
        }
        Ok(())
    }

    /// Solves `A x = b` in place for `N` right-hand sides side by side.
    pub fn solve<const N: usize>(&self, b: &mut [[f64; N]]) {
        let order = &self.symbolic.order;
        let mut x: Vec<[f64; N]> = order.iter().map(|&v| b[v as usize]).collect();
        let mut below = Vec::new();
        for s in 0..self.symbolic.supernodes() {
            self.forward(s, &mut x, &mut below);
        }
        for s in (0..self.symbolic.supernodes()).rev() {
            self.backward(s, &mut x, &mut below);
        }
        for (&v, x) in order.iter().zip(&x) {
            b[v as usize] = *x;
        }
    }

    /// The panel of a supernode with its columns and the rows below them.
    fn panel(&self, s: usize) -> (&[f64], std::ops::Range<usize>, &[u32]) {
        let symbolic = &self.symbolic;
        let columns = symbolic.columns(s);
        let values = &self.values[symbolic.panel_start[s]..symbolic.panel_start[s + 1]];
        let rows = &symbolic.rows_of(s)[columns.len()..];
        (values, columns, rows)
    }

    fn forward<const N: usize>(&self, s: usize, x: &mut [[f64; N]], sums: &mut Vec<[f64; N]>) {
        let (values, columns, rows) = self.panel(s);
        let (width, height) = (columns.len(), columns.len() + rows.len());
        sums.clear();
        sums.resize(rows.len(), [0.0; N]);
        let own = &mut x[columns];
        for j in 0..width {
            let column = &values[j * height..(j + 1) * height];
            let pivot = column[j];
            let xj = own[j].map(|v| v / pivot);
            own[j] = xj;
            for (x, l) in own[j + 1..].iter_mut().zip(&column[j + 1..width]) {
                (0..N).for_each(|k| x[k] -= l * xj[k]);
            }
            for (sum, l) in sums.iter_mut().zip(&column[width..]) {
                (0..N).for_each(|k| sum[k] += l * xj[k]);
            }
        }
        for (&row, sum) in rows.iter().zip(sums.iter()) {
            (0..N).for_each(|k| x[row as usize][k] -= sum[k]);
        }
    }

    fn backward<const N: usize>(&self, s: usize, x: &mut [[f64; N]], below: &mut Vec<[f64; N]>) {
        let (values, columns, rows) = self.panel(s);
        let (width, height) = (columns.len(), columns.len() + rows.len());
        below.clear();
        below.extend(rows.iter().map(|&row| x[row as usize]));
        let own = &mut x[columns];
        for j in (0..width).rev() {
            let column = &values[j * height..(j + 1) * height];
            let inside = product(&column[j + 1..width], &own[j + 1..]);
            let under = product(&column[width..], below);
            let pivot = column[j];
            (0..N).for_each(|k| own[j][k] = (own[j][k] - inside[k] - under[k]) / pivot);
        }
    }
}

impl Symbolic {
    /// Adds the matrix's entries of `columns` into their panel.
    fn assemble(
        &self,
        panel: &mut Panel,
        columns: std::ops::Range<usize>,
        matrix: &[f64],
        place: &[u32],
    ) {
        for (j, c) in columns.enumerate() {
            let column = &mut panel.values[j * panel.height..(j + 1) * panel.height];
            for &(row, e) in
                &self.entries[self.entry_start[c] as usize..self.entry_start[c + 1] as usize]
            {
                column[place[row as usize] as usize] += matrix[e as usize];
            }
        }
    }
}

/// Adds a child's update, whose rows are `rows`, into a front.
fn extend_add(panel: &mut Panel, update: &mut [f64], child: &[f64], rows: &[u32], place: &[u32]) {
    let below = panel.height - panel.width;
    for (j, &column) in rows.iter().enumerate() {
        let c = place[column as usize] as usize;
        let source = &child[j * rows.len() + j..(j + 1) * rows.len()];
        let (target, shift) = if c < panel.width {
            (&mut panel.values[c * panel.height..(c + 1) * panel.height], 0)
        } else {
            let c = c - panel.width;
            (&mut update[c * below..(c + 1) * below], panel.width)
        };
        for (&row, v) in rows[j..].iter().zip(source) {
            target[place[row as usize] as usize - shift] += v;
        }
    }
}

/// `sum of l[i] * x[i]`, in four interleaved sums.
fn product<const N: usize>(l: &[f64], x: &[[f64; N]]) -> [f64; N] {
    let (l4, l_rest) = l.as_chunks::<4>();
    let (x4, x_rest) = x.as_chunks::<4>();
    let mut sums = [[0.0; N]; 4];
    for (l, x) in l4.iter().zip(x4) {
        for i in 0..4 {
            (0..N).for_each(|k| sums[i][k] += l[i] * x[i][k]);
        }
    }
    let mut total = [0.0; N];
    (0..N).for_each(|k| total[k] = (sums[0][k] + sums[1][k]) + (sums[2][k] + sums[3][k]));
    for (l, x) in l_rest.iter().zip(x_rest) {
        (0..N).for_each(|k| total[k] += l * x[k]);
    }
    total
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::DVec3;
    use crate::linalg::nested_dissection;

    /// Laplacian of a triangulated `side x side` grid, shifted to be positive definite.
    fn grid(side: u32) -> (SymmetricMatrix, Vec<DVec3>) {
        let n = (side * side) as usize;
        let (mut diagonal, mut entries, mut points) = (vec![1e-3; n], Vec::new(), Vec::new());
        for v in 0..side * side {
            let (x, y) = (v % side, v / side);
            points.push(DVec3::new(x.into(), y.into(), 0.0));
            for (dx, dy) in [(1, 0), (0, 1), (1, 1)] {
                if x + dx < side && y + dy < side {
                    let w = v + dx + side * dy;
                    let weight = 1.0 + f64::from((3 * v + 5 * w) % 7);
                    entries.push((v, w, -weight));
                    diagonal[v as usize] += weight;
                    diagonal[w as usize] += weight;
                }
            }
        }
        (SymmetricMatrix::new(&diagonal, &entries), points)
    }

    fn assert_solves(factor: &Cholesky, matrix: &SymmetricMatrix) {
        let n = matrix.size();
        let truth: Vec<[f64; 2]> =
            (0..n).map(|i| [(i % 17) as f64 - 8.0, 1.0 / (1.0 + i as f64)]).collect();
        let mut x = matrix.multiply(&truth);
        factor.solve(&mut x);
        for (x, t) in x.iter().zip(&truth) {
            assert!((x[0] - t[0]).abs() < 1e-7 && (x[1] - t[1]).abs() < 1e-7, "{x:?} {t:?}");
        }
    }

    #[test]
    fn solves_grids_of_many_sizes() {
        for side in [1, 2, 3, 9, 31, 80] {
            let (matrix, points) = grid(side);
            let order = nested_dissection(&matrix.adjacency(), &points);
            assert_solves(&Cholesky::new(&matrix, &order).unwrap(), &matrix);
        }
    }

    #[test]
    fn any_order_and_refactoring_work() {
        let (matrix, _) = grid(13);
        let n = matrix.size() as u32;
        let order: Vec<u32> = (0..n).map(|i| (i * 31) % n).collect();
        let mut factor = Cholesky::new(&matrix, &order).unwrap();
        assert_solves(&factor, &matrix);
        factor.refactor(&matrix).unwrap();
        assert_solves(&factor, &matrix);
    }

    #[test]
    fn separate_components_are_solved() {
        let matrix = SymmetricMatrix::new(&[2.0, 3.0, 4.0, 5.0], &[(0, 3, 1.0)]);
        assert_solves(&Cholesky::new(&matrix, &[2, 0, 1, 3]).unwrap(), &matrix);
    }

    #[test]
    fn indefinite_matrix_is_refused() {
        let matrix = SymmetricMatrix::new(&[1.0, 1.0, 1.0], &[(0, 2, 3.0)]);
        let fault = Cholesky::new(&matrix, &[0, 1, 2]).map(|_| ());
        assert_eq!(fault, Err(NotPositiveDefinite { row: 2 }));
    }
}
