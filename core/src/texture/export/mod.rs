//! Files of a height map.
//!
//! - `csv`: one line per node, `x_mm,y_mm,z_um`.
//! - `asc`: a matrix with a header, which SurfaceTopography, Gwyddion and others read; a line is a line of nodes along the
//!   feed.
//! - `x3p`: the container of ISO 25178-72.
//!
//! Heights are those over the nominal form as simulated, mean plane included. Nodes stand at even steps, the mean lengths
//! of the grid's cells: on a curved surface the map is laid flat. Nodes beyond the surface have no height: an empty field,
//! `nan`, and the NaN that X3P has for points that are not valid.

mod x3p;

pub use x3p::{X3pError, x3p};

use super::grid::Grid;
use std::fmt::Write;

/// µm in a mm.
pub const MICRO: f64 = 1e3;

/// A height map on even nodes.
#[derive(Copy, Clone, Debug)]
pub struct Matrix<'a> {
    /// Numbers of nodes along and across the feed.
    pub counts: [usize; 2],
    /// Distances of nodes, mm.
    pub steps: [f64; 2],
    /// Heights, mm, along the feed fastest; NaN beyond the surface.
    pub heights: &'a [f64],
}

impl<'a> Matrix<'a> {
    /// Heights over a grid, in its order.
    pub fn new(grid: &Grid, heights: &'a [f64]) -> Self {
        Self { counts: grid.counts(), steps: grid.cells().mean, heights }
    }
}

/// The map as `x_mm,y_mm,z_um`, to 0.1 nm in height.
pub fn csv(map: &Matrix) -> Vec<u8> {
    let mut text = String::from("x_mm,y_mm,z_um\n");
    for (k, h) in map.heights.iter().enumerate() {
        let x = (k % map.counts[0]) as f64 * map.steps[0];
        let y = (k / map.counts[0]) as f64 * map.steps[1];
        // Writing to a string cannot fail.
        let _ = match h.is_nan() {
            true => writeln!(text, "{x:.6},{y:.6},"),
            false => writeln!(text, "{x:.6},{y:.6},{:.4}", h * MICRO),
        };
    }
    text.into_bytes()
}

/// The map as a matrix of heights in µm, to 0.1 pm, under a header in the manner of Gwyddion's text export: width and
/// height of the map in mm, which are the steps times the numbers of nodes.
pub fn asc(map: &Matrix) -> Vec<u8> {
    let size = |axis: usize| map.steps[axis] * map.counts[axis] as f64;
    let mut text = format!(
        "# Channel: Texture\n# Width: {:.9} mm\n# Height: {:.9} mm\n# Value units: um\n",
        size(0),
        size(1)
    );
    for row in map.heights.chunks(map.counts[0].max(1)) {
        for (i, h) in row.iter().enumerate() {
            let gap = if i == 0 { "" } else { " " };
            let _ = match h.is_nan() {
                true => write!(text, "{gap}nan"),
                false => write!(text, "{gap}{:.7}", h * MICRO),
            };
        }
        text.push('\n');
    }
    text.into_bytes()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_those_of_the_nodes() {
        let heights = [0.0, 0.001, 0.002, 0.003, 0.004, 0.0050001];
        let map = Matrix { counts: [3, 2], steps: [0.1, 0.2], heights: &heights };
        let table = String::from_utf8(csv(&map)).unwrap();
        assert_eq!(table.lines().count(), 7);
        assert_eq!(table.lines().last(), Some("0.200000,0.200000,5.0001"));
        let matrix = String::from_utf8(asc(&map)).unwrap();
        assert!(matrix.contains("# Width: 0.300000000 mm"));
        assert_eq!(matrix.lines().last(), Some("3.0000000 4.0000000 5.0001000"));
        let gap = [f64::NAN, 0.001];
        let map = Matrix { counts: [2, 1], steps: [0.1, 0.1], heights: &gap };
        assert!(String::from_utf8(csv(&map)).unwrap().contains("\n0.000000,0.000000,\n"));
        assert!(String::from_utf8(asc(&map)).unwrap().ends_with("\nnan 1.0000000\n"));
    }
}
