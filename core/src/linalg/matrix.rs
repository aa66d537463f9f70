//! Symmetric sparse matrices and their graphs.

use crate::geometry::OrderBy;

/// A symmetric sparse matrix: its lower triangle with the diagonal, by columns.
///
/// Rows ascend inside a column and the diagonal entry comes first.
#[derive(Clone, Debug, PartialEq)]
pub struct SymmetricMatrix {
    column_start: Vec<u32>,
    row: Vec<u32>,
    value: Vec<f64>,
}

impl SymmetricMatrix {
    /// A matrix from its diagonal and its `(i, j, value)` entries off the diagonal.
    ///
    /// Each pair `i != j` is given once, in either direction; entries given more often add up in
    /// the order given.
    pub fn new(diagonal: &[f64], entries: &[(u32, u32, f64)]) -> Self {
        let n = diagonal.len();
        let mut start = vec![0u32; n + 1];
        for &(i, j, _) in entries {
            start[i.min(j) as usize + 1] += 1;
        }
        for c in 0..n {
            start[c + 1] += start[c];
        }
        let mut fill = start.clone();
        let mut grouped = vec![(0u32, 0.0); entries.len()];
        for &(i, j, value) in entries {
            let slot = &mut fill[i.min(j) as usize];
            grouped[*slot as usize] = (i.max(j), value);
            *slot += 1;
        }
        let mut column_start = Vec::with_capacity(n + 1);
        let mut row = Vec::with_capacity(n + entries.len());
        let mut value = Vec::with_capacity(n + entries.len());
        column_start.push(0);
        for c in 0..n {
            let column = &mut grouped[start[c] as usize..start[c + 1] as usize];
            column.order_by_key(|e| e.0);
            row.push(c as u32);
            value.push(diagonal[c]);
            for &(r, v) in column.iter() {
                match value.last_mut() {
                    Some(last) if row.last() == Some(&r) => *last += v,
                    _ => {
                        row.push(r);
                        value.push(v);
                    }
                }
            }
            column_start.push(row.len() as u32);
        }
        Self { column_start, row, value }
    }

    /// Number of rows and columns.
    pub fn size(&self) -> usize {
        self.column_start.len() - 1
    }

    /// Where each column's entries begin in [`Self::rows`]; one more at the end.
    pub(super) fn column_start(&self) -> &[u32] {
        &self.column_start
    }

    /// Row of every stored entry.
    pub(super) fn rows(&self) -> &[u32] {
        &self.row
    }

    /// Value of every stored entry.
    pub(super) fn values(&self) -> &[f64] {
        &self.value
    }

    /// Value of every stored entry, to be set anew on the same pattern; see [`Self::slot`].
    pub fn values_mut(&mut self) -> &mut [f64] {
        &mut self.value
    }

    /// Index among the values of entry `(i, j)`, in either direction, if it is stored.
    pub fn slot(&self, i: u32, j: u32) -> Option<usize> {
        let column = i.min(j) as usize;
        let from = self.column_start[column] as usize;
        let rows = &self.row[from..self.column_start[column + 1] as usize];
        rows.binary_search(&i.max(j)).ok().map(|k| from + k)
    }

    /// `A x` for `N` vectors at once.
    pub fn multiply<const N: usize>(&self, x: &[[f64; N]]) -> Vec<[f64; N]> {
        let mut y = vec![[0.0; N]; x.len()];
        for c in 0..self.size() {
            let from = self.column_start[c] as usize;
            for e in from..self.column_start[c + 1] as usize {
                let (r, a) = (self.row[e] as usize, self.value[e]);
                for k in 0..N {
                    y[r][k] += a * x[c][k];
                    if r != c {
                        y[c][k] += a * x[r][k];
                    }
                }
            }
        }
        y
    }

    /// The graph of the entries off the diagonal.
    pub fn adjacency(&self) -> Adjacency {
        let n = self.size();
        let mut start = vec![0u32; n + 1];
        for c in 0..n {
            for &r in self.below(c) {
                start[c + 1] += 1;
                start[r as usize + 1] += 1;
            }
        }
        for v in 0..n {
            start[v + 1] += start[v];
        }
        let mut fill = start.clone();
        let mut neighbour = vec![0u32; start[n] as usize];
        for c in 0..n {
            for &r in self.below(c) {
                for (a, b) in [(c as u32, r), (r, c as u32)] {
                    neighbour[fill[a as usize] as usize] = b;
                    fill[a as usize] += 1;
                }
            }
        }
        Adjacency { start, neighbour }
    }

    fn below(&self, column: usize) -> &[u32] {
        &self.row[self.column_start[column] as usize + 1..self.column_start[column + 1] as usize]
    }
}

/// An undirected graph: the neighbours of every node.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Adjacency {
    start: Vec<u32>,
    neighbour: Vec<u32>,
}

impl Adjacency {
    /// Number of nodes.
    pub fn size(&self) -> usize {
        self.start.len() - 1
    }

    /// The neighbours of a node.
    pub fn of(&self, node: u32) -> &[u32] {
        let node = node as usize;
        &self.neighbour[self.start[node] as usize..self.start[node + 1] as usize]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn repeated_entries_add_up() {
        let a = SymmetricMatrix::new(&[2.0, 3.0], &[(0, 1, 1.0), (1, 0, 0.5)]);
        assert_eq!(a.multiply(&[[1.0], [2.0]]), vec![[5.0], [7.5]]);
        assert_eq!(a.adjacency().of(0), &[1]);
    }
}
