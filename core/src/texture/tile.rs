//! A tile of the grid: what bounds its nodes, and which of them a swept quadrilateral may meet.
//!
//! Terms. A node's *line* is the stretch of its normal from `height` below to `height` above it. The *local map* of a
//! tile takes a place to grid coordinates `(i, j)` and a height, all of them linear; nodes whose lines it misplaces are
//! allowed for by a *margin* that is measured at every one of them. So a quadrilateral that meets a node's line has
//! that node in its box, widened by the margin, and no scan of the grid is needed.

use super::grid::{Grid, Node};
use crate::geometry::{DMat3, DVec3};
use std::ops::Range;

/// Nodes along the side of a tile: more of them loosen its bounds, fewer cost more looks at the path.
pub const SIDE: usize = 32;
/// Rounding of grid coordinates.
const ROUNDING: f64 = 1e-9;

/// A block of nodes of a grid.
#[derive(Clone, Debug)]
pub struct Tile {
    /// Along `u`.
    pub columns: Range<usize>,
    /// Along `v`.
    pub rows: Range<usize>,
}

impl Tile {
    /// The tiles that a grid is made of, row by row.
    pub fn all(grid: &Grid) -> Vec<Self> {
        let [nu, nv] = grid.counts();
        let part = |from: usize, count: usize| from..(from + SIDE).min(count);
        let row = |j: usize| {
            (0..nu).step_by(SIDE).map(move |i| Self { columns: part(i, nu), rows: part(j, nv) })
        };
        (0..nv).step_by(SIDE).flat_map(row).collect()
    }

    /// Its nodes, `u` fastest.
    pub fn nodes<'a>(&self, grid: &'a Grid) -> impl Iterator<Item = &'a Node> {
        let columns = self.columns.clone();
        let rows = self.rows.clone();
        rows.flat_map(move |j| columns.clone().map(move |i| grid.node(i, j)))
    }
}

/// The local map of a tile, and what bounds its lines.
#[derive(Clone, Debug)]
pub struct Local {
    /// A place in the middle, to which the others are relative, mm.
    pub middle: DVec3,
    /// Farthest end of a line from it, mm.
    pub radius: f64,
    /// Rows: gradients of `i`, `j` and the height at the middle.
    rows: [DVec3; 3],
    /// Grid coordinates of the middle.
    origin: DVec3,
    /// How far lines are misplaced along `i` and `j`.
    margin: [f64; 2],
    /// Heights over the middle between which all lines lie, mm.
    heights: [f64; 2],
    counts: [usize; 2],
}

impl Local {
    /// The map of a tile whose lines reach `height` mm either way; `None` where its grid has no area.
    pub fn new(grid: &Grid, tile: &Tile, height: f64) -> Option<Self> {
        let counts = [tile.columns.len(), tile.rows.len()];
        let corner = |a: usize, b: usize| {
            let i = if a == 0 { tile.columns.start } else { tile.columns.end - 1 };
            let j = if b == 0 { tile.rows.start } else { tile.rows.end - 1 };
            grid.node(i, j).place
        };
        let [nu, nv] = grid.counts();
        let [du, dv] = [0, 1].map(|axis| match (counts[axis], axis) {
            // A single row or column leans on the one beside it.
            (1, 0) => {
                let i = tile.columns.start.min(nu.saturating_sub(2));
                grid.node((i + 1).min(nu - 1), tile.rows.start).place
                    - grid.node(i, tile.rows.start).place
            }
            (1, _) => {
                let j = tile.rows.start.min(nv.saturating_sub(2));
                grid.node(tile.columns.start, (j + 1).min(nv - 1)).place
                    - grid.node(tile.columns.start, j).place
            }
            (n, 0) => {
                0.5 * (corner(1, 0) - corner(0, 0) + corner(1, 1) - corner(0, 1)) / (n - 1) as f64
            }
            (n, _) => {
                0.5 * (corner(0, 1) - corner(0, 0) + corner(1, 1) - corner(1, 0)) / (n - 1) as f64
            }
        });
        let normal = tile.nodes(grid).map(|n| n.normal).sum::<DVec3>().try_normalize()?;
        let columns = DMat3::from_cols(du, dv, normal);
        if columns.determinant().abs() <= f64::MIN_POSITIVE {
            return None;
        }
        let inverse = columns.inverse().transpose();
        let middle = 0.25 * (corner(0, 0) + corner(1, 0) + corner(0, 1) + corner(1, 1));
        let origin = DVec3::new((counts[0] - 1) as f64, (counts[1] - 1) as f64, 0.0) * 0.5;
        let mut local = Self {
            middle,
            radius: 0.0,
            rows: [inverse.x_axis, inverse.y_axis, normal],
            origin,
            margin: [ROUNDING; 2],
            heights: [f64::INFINITY, f64::NEG_INFINITY],
            counts,
        };
        for (k, node) in tile.nodes(grid).enumerate() {
            local.widen(node, (k % counts[0], k / counts[0]), height);
        }
        Some(local)
    }

    /// Lets the bounds hold a node's line.
    fn widen(&mut self, node: &Node, (i, j): (usize, usize), height: f64) {
        let place = node.place - self.middle;
        let at = self.map(place);
        let tilt = DVec3::from(self.rows.map(|row| row.dot(node.normal).abs())) * height;
        let off = (at - DVec3::new(i as f64, j as f64, at.z)).abs() + tilt;
        self.margin = [self.margin[0].max(off.x + ROUNDING), self.margin[1].max(off.y + ROUNDING)];
        self.heights[0] = self.heights[0].min(at.z - height - ROUNDING);
        self.heights[1] = self.heights[1].max(at.z + height + ROUNDING);
        for end in [place + node.normal * height, place - node.normal * height] {
            self.radius = self.radius.max(end.length());
        }
    }

    /// Grid coordinates, and height in mm, of a place relative to the middle.
    pub fn map(&self, place: DVec3) -> DVec3 {
        self.origin + self.turn(place)
    }

    /// The linear part of the map.
    pub fn turn(&self, way: DVec3) -> DVec3 {
        DVec3::from(self.rows.map(|row| row.dot(way)))
    }

    /// Columns and rows, from the tile's own first ones, of the nodes whose lines a quadrilateral with these mapped
    /// corners may meet.
    pub fn box_of(&self, corners: [DVec3; 4]) -> [Range<usize>; 2] {
        let [a, b, c, d] = corners;
        let low = a.min(b).min(c.min(d));
        let high = a.max(b).max(c.max(d));
        if low.z > self.heights[1] || high.z < self.heights[0] {
            return [0..0, 0..0];
        }
        [
            range(low.x - self.margin[0], high.x + self.margin[0], self.counts[0]),
            range(low.y - self.margin[1], high.y + self.margin[1], self.counts[1]),
        ]
    }
}

/// The integers between two numbers, from 0 and below `count`.
fn range(low: f64, high: f64, count: usize) -> Range<usize> {
    // Casts saturate, and NaN gives an empty range.
    let first = low.ceil().max(0.0) as usize;
    let end = (high.floor() + 1.0).max(0.0) as usize;
    first..end.min(count).max(first)
}

/// The least height at which a line meets a swept quadrilateral, mm; `None` where it does not.
///
/// `corners`: `a` and `b` of the edge element before the step, `c` and `d` after it, in order around, relative to the
/// node; they make the triangles `abc` and `acd`. Neighbouring quadrilaterals share their sides bit for bit, and a side
/// is seen on the same side of the line from both, so that no line slips between them.
pub fn met(normal: DVec3, [a, b, c, d]: [DVec3; 4]) -> Option<f64> {
    let seen = |p: DVec3, q: DVec3| normal.dot(p.cross(q));
    let (ab, bc, ca) = (seen(a, b), seen(b, c), seen(c, a));
    let (cd, da) = (seen(c, d), seen(d, a));
    let first = crossing(normal, [a, b, c], [bc, ca, ab]);
    let second = crossing(normal, [a, c, d], [cd, da, -ca]);
    match (first, second) {
        (Some(x), Some(y)) => Some(x.min(y)),
        (x, y) => x.or(y),
    }
}

/// Where the line crosses a triangle, from the areas opposite to its corners.
fn crossing(normal: DVec3, corners: [DVec3; 3], areas: [f64; 3]) -> Option<f64> {
    let inside = areas.iter().all(|a| *a >= 0.0) || areas.iter().all(|a| *a <= 0.0);
    let sum = areas[0] + areas[1] + areas[2];
    if !inside || sum == 0.0 {
        return None;
    }
    let height = |i: usize| areas[i] * normal.dot(corners[i]);
    Some((height(0) + height(1) + height(2)) / sum)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::DVec2;
    use crate::surface::AnalyticSurface;
    use crate::texture::grid::Discretisation;

    #[test]
    fn every_line_is_inside_of_the_bounds_of_its_tile() {
        let surface = AnalyticSurface::Torus { major: 8.0, minor: 3.0, length: 20.0, width: 9.0 };
        let node = |at: DVec2| {
            let normal = surface.curvature(at).normal();
            Some(Node { place: surface.position(at), normal })
        };
        let size = DVec2::new(4.0, 3.0);
        let grid = Grid::new(size, 0.05, Discretisation::Uniform, 1, &node).unwrap();
        let tiles = Tile::all(&grid);
        let held: usize = tiles.iter().map(|t| t.columns.len() * t.rows.len()).sum();
        assert_eq!(held, grid.nodes().len());
        for tile in &tiles {
            let local = Local::new(&grid, tile, 0.3).unwrap();
            for (k, node) in tile.nodes(&grid).enumerate() {
                for height in [-0.3, 0.1, 0.3] {
                    let place = node.place + node.normal * height - local.middle;
                    assert!(place.length() <= local.radius * (1.0 + 1e-12));
                    let [columns, rows] = local.box_of([local.map(place); 4]);
                    assert!(columns.contains(&(k % tile.columns.len())));
                    assert!(rows.contains(&(k / tile.columns.len())));
                }
            }
        }
    }

    #[test]
    fn a_line_meets_a_quadrilateral_where_it_is() {
        let quad = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)];
        let at = |x: f64, y: f64| {
            met(DVec3::Z, quad.map(|(a, b)| DVec3::new(a - x, b - y, 1.0 + 0.5 * a)))
        };
        assert!((at(0.3, 0.8).unwrap() - 1.15).abs() < 1e-15);
        assert!((at(0.8, 0.3).unwrap() - 1.4).abs() < 1e-15);
        assert!(at(0.0, 0.0).is_some() && at(1.0, 0.5).is_some() && at(0.5, 0.5).is_some());
        assert!(at(1.01, 0.5).is_none() && at(0.5, -0.01).is_none());
        assert!(met(DVec3::X, quad.map(|(a, b)| DVec3::new(a, b, 1.0))).is_none());
    }
}
