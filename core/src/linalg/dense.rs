//! Dense kernels of the supernodal factorisation.
//!
//! Panels are column-major. Products run over 4 x 4 tiles with plain multiplications and
//! additions; each element's sum runs over the columns in ascending order inside fixed blocks, so
//! the result does not depend on vector width or cache sizes.

/// Columns factored before the rest of the panel is updated.
const BLOCK: usize = 24;
/// Longest inner product summed in registers: more would leave the first-level cache.
const DEPTH: usize = 192;

/// A column-major panel: `width` columns of `height` rows, its square top the diagonal block.
pub(super) struct Panel<'a> {
    pub values: &'a mut [f64],
    pub height: usize,
    pub width: usize,
}

/// Rows of four, packed for the tile kernel: `tiles[t * depth + p]` holds column `p` of tile `t`.
#[derive(Clone, Debug, Default)]
pub(super) struct Packed {
    tiles: Vec<[f64; 4]>,
    depth: usize,
    rows: usize,
}

impl Packed {
    /// Packs columns `columns` of rows `from_row..` of `panel`.
    fn pack(&mut self, panel: &Panel, from_row: usize, columns: std::ops::Range<usize>) {
        self.rows = panel.height - from_row;
        self.depth = columns.len();
        let tiles = self.rows.div_ceil(4);
        self.tiles.resize(tiles * self.depth, [0.0; 4]);
        for (p, c) in columns.enumerate() {
            let column = &panel.values[c * panel.height + from_row..(c + 1) * panel.height];
            let (full, rest) = column.as_chunks::<4>();
            for (t, four) in full.iter().enumerate() {
                self.tiles[t * self.depth + p] = *four;
            }
            if !rest.is_empty() {
                let mut last = [0.0; 4];
                last[..rest.len()].copy_from_slice(rest);
                self.tiles[full.len() * self.depth + p] = last;
            }
        }
    }

    fn tile(&self, t: usize) -> &[[f64; 4]] {
        &self.tiles[t * self.depth..(t + 1) * self.depth]
    }

    /// Subtracts `P P^T` from the lower part of the first `columns` columns of `target`.
    fn subtract_square(&self, target: &mut [f64], stride: usize, columns: usize) {
        for tj in 0..columns.div_ceil(4) {
            let wide = (columns - 4 * tj).min(4);
            for ti in tj..self.rows.div_ceil(4) {
                let product = tile_product(self.tile(ti), self.tile(tj));
                let high = (self.rows - 4 * ti).min(4);
                for (j, sums) in product.iter().enumerate().take(wide) {
                    let at = (4 * tj + j) * stride + 4 * ti;
                    let skip = if ti == tj { j } else { 0 };
                    for (t, s) in
                        target[at..at + high].iter_mut().zip(sums.iter().take(high)).skip(skip)
                    {
                        *t -= s;
                    }
                }
            }
        }
    }
}

/// `sums[j][i] = sum over p of a[p][i] * b[p][j]`.
#[inline(always)]
fn tile_product(a: &[[f64; 4]], b: &[[f64; 4]]) -> [[f64; 4]; 4] {
    let mut sums = [[0.0; 4]; 4];
    for (a, b) in a.iter().zip(b) {
        for j in 0..4 {
            for i in 0..4 {
                sums[j][i] += a[i] * b[j];
            }
        }
    }
    sums
}

impl Panel<'_> {
    /// Cholesky-factors the panel's columns, or names the first column without positive pivot.
    pub fn factor(&mut self, packed: &mut Packed) -> Result<(), usize> {
        for from in (0..self.width).step_by(BLOCK) {
            let to = (from + BLOCK).min(self.width);
            self.factor_block(from, to)?;
            if to < self.width {
                packed.pack(self, to, from..to);
                let at = to * self.height + to;
                packed.subtract_square(&mut self.values[at..], self.height, self.width - to);
            }
        }
        Ok(())
    }

    /// Factors columns `from..to`, whose updates from the left are done.
    fn factor_block(&mut self, from: usize, to: usize) -> Result<(), usize> {
        let h = self.height;
        for j in from..to {
            let (done, rest) = self.values.split_at_mut((j + 1) * h);
            let column = &mut done[j * h + j..];
            let pivot = column[0];
            if !(pivot > 0.0 && pivot < f64::INFINITY) {
                return Err(j);
            }
            let root = pivot.sqrt();
            let inverse = 1.0 / root;
            column[0] = root;
            for v in &mut column[1..] {
                *v *= inverse;
            }
            for k in j + 1..to {
                let factor = column[k - j];
                let target = &mut rest[(k - j - 1) * h + k..(k - j) * h];
                for (t, v) in target.iter_mut().zip(&column[k - j..]) {
                    *t -= factor * v;
                }
            }
        }
        Ok(())
    }

    /// Subtracts `B B^T` from the lower part of `update`, where `B` are the rows below the square.
    pub fn subtract_below(&self, update: &mut [f64], packed: &mut Packed) {
        let below = self.height - self.width;
        for from in (0..self.width).step_by(DEPTH) {
            packed.pack(self, self.width, from..(from + DEPTH).min(self.width));
            packed.subtract_square(update, below, below);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A positive definite matrix of any size, column-major.
    fn matrix(n: usize) -> Vec<f64> {
        let at = |i: usize, j: usize| 1.0 / (1.0 + (i + j) as f64 + 0.3 * (i * j) as f64);
        let fill = |k: usize| {
            let (i, j) = (k % n, k / n);
            let gram: f64 = (0..n).map(|p| at(i, p) * at(j, p)).sum();
            gram + if i == j { 2.0 } else { 0.0 }
        };
        (0..n * n).map(fill).collect()
    }

    #[test]
    fn partial_factor_and_update_reproduce_the_matrix() {
        for (n, width) in [(1, 1), (7, 3), (30, 30), (61, 50), (260, 230)] {
            let a = matrix(n);
            let mut values = a[..n * width].to_vec();
            let mut panel = Panel { values: &mut values, height: n, width };
            let mut packed = Packed::default();
            panel.factor(&mut packed).unwrap();
            let below = n - width;
            let mut update = vec![0.0; below * below];
            panel.subtract_below(&mut update, &mut packed);
            for j in 0..n {
                for i in j..n {
                    let mut sum: f64 =
                        (0..width.min(j + 1)).map(|p| values[p * n + i] * values[p * n + j]).sum();
                    if j >= width {
                        sum = -update[(j - width) * below + i - width];
                        let direct: f64 =
                            (0..width).map(|p| values[p * n + i] * values[p * n + j]).sum();
                        assert!((sum - direct).abs() < 1e-12);
                    } else {
                        assert!((sum - a[j * n + i]).abs() < 1e-12, "{n} {width} {i} {j}");
                    }
                }
            }
        }
    }

    #[test]
    fn negative_pivot_is_named() {
        let mut values = vec![1.0, 2.0, 2.0, 1.0];
        let mut panel = Panel { values: &mut values, height: 2, width: 2 };
        assert_eq!(panel.factor(&mut Packed::default()), Err(1));
    }
}
