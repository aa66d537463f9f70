//! Heights in rows and columns, as files hold them.

use crate::texture::grid::Grid;

/// A height map on even nodes.
#[derive(Copy, Clone, Debug)]
pub struct Matrix<'a> {
    /// Numbers of nodes along and across the feed.
    pub counts: [usize; 2],
    /// Distances of nodes, mm.
    pub steps: [f64; 2],
    /// Heights, mm, along the feed fastest; NaN where there is none: beyond the surface, or not cut.
    pub heights: &'a [f64],
}

impl<'a> Matrix<'a> {
    /// Heights over a grid, in its order.
    pub fn new(grid: &Grid, heights: &'a [f64]) -> Self {
        Self { counts: grid.counts(), steps: grid.cells().mean, heights }
    }
}
