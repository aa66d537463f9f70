//! A tile of the grid: what bounds its nodes, and which of them a swept quadrilateral may meet.
//!
//! Terms. A node's *line* is the stretch of its normal from `height` below to `height` above it. The *local map* of a
//! tile takes a place to grid coordinates `(i, j)` and a height, all of them linear; nodes whose lines it misplaces are
//! allowed for by a *margin* that is measured at every one of them. So a quadrilateral that meets a node's line has
//! that node in its box, widened by the margin, and no scan of the grid is needed.

use super::grid::{Grid, Node};
use crate::geometry::{DMat3, DVec3, any_perpendicular};
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
    /// The tiles that a grid is made of, row by row, with `side` nodes along theirs, at least 1.
    pub fn all(grid: &Grid, side: usize) -> Vec<Self> {
        let [nu, nv] = grid.counts();
        let part = |from: usize, count: usize| from..(from + side).min(count);
        let row = |j: usize| {
            (0..nu).step_by(side).map(move |i| Self { columns: part(i, nu), rows: part(j, nv) })
        };
        (0..nv).step_by(side).flat_map(row).collect()
    }

    /// All of a grid as one.
    pub fn whole(grid: &Grid) -> Self {
        let [nu, nv] = grid.counts();
        Self { columns: 0..nu, rows: 0..nv }
    }

    /// Writes what is held of its nodes among that of a grid with `nu` nodes along `u`.
    pub fn write<T: Copy>(&self, own: &[T], nu: usize, all: &mut [T]) {
        for (row, j) in own.chunks(self.columns.len()).zip(self.rows.clone()) {
            let first = j * nu + self.columns.start;
            all[first..first + row.len()].copy_from_slice(row);
        }
    }

    /// The mean of the sides of its cells along an axis, and of those that lead on from it; `None` where there are none.
    fn side(&self, grid: &Grid, axis: usize) -> Option<DVec3> {
        let counts = grid.counts();
        let (mut sum, mut count) = (DVec3::ZERO, 0.0);
        for j in self.rows.start.saturating_sub(1)..self.rows.end {
            for i in self.columns.start.saturating_sub(1)..self.columns.end {
                let next = [i + usize::from(axis == 0), j + usize::from(axis == 1)];
                if next[0] < counts[0] && next[1] < counts[1] {
                    let way = grid.node(next[0], next[1]).place - grid.node(i, j).place;
                    if !way.is_nan() {
                        (sum, count) = (sum + way, count + 1.0);
                    }
                }
            }
        }
        (count > 0.0).then(|| sum / count)
    }

    /// The mean place of its nodes, and their mean grid coordinates from its own first ones; `None` where none is on the
    /// surface.
    fn middle(&self, grid: &Grid) -> Option<(DVec3, DVec3)> {
        let (mut place, mut at, mut count) = (DVec3::ZERO, DVec3::ZERO, 0.0);
        for (k, node) in self.nodes(grid).enumerate().filter(|(_, node)| node.is_on_surface()) {
            let columns = self.columns.len();
            at += DVec3::new((k % columns) as f64, (k / columns) as f64, 0.0);
            (place, count) = (place + node.place, count + 1.0);
        }
        (count > 0.0).then(|| (place / count, at / count))
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
    /// Farthest end of a line from it along the tile, mm.
    side: f64,
    /// Rows: gradients of `i`, `j` and the height at the middle.
    rows: [DVec3; 3],
    /// Grid coordinates of the middle.
    origin: DVec3,
    /// How far lines are misplaced along `i` and `j`.
    margin: [f64; 2],
    /// Heights over the middle between which all lines lie, mm: the second is the top of the material.
    heights: [f64; 2],
    counts: [usize; 2],
    /// mm per unit of a grid coordinate, where that is the shortest.
    shortest: [f64; 2],
}

/// Where a tile is, seen along an axis from its middle: no farther than `side` off the axis, from `low` to `high` along it.
#[derive(Copy, Clone, Debug)]
pub struct Bounds {
    pub side: f64,
    pub low: f64,
    pub high: f64,
}

impl Local {
    /// The map of a tile whose lines reach `height` mm either way; `None` where its grid has no area, or no node on the
    /// surface.
    pub fn new(grid: &Grid, tile: &Tile, height: f64) -> Option<Self> {
        let counts = [tile.columns.len(), tile.rows.len()];
        let normal = tile.nodes(grid).map(|n| n.normal).sum::<DVec3>().try_normalize()?;
        let [du, dv] = sides(grid, tile, normal);
        let columns = DMat3::from_cols(du, dv, normal);
        if columns.determinant().abs() <= f64::MIN_POSITIVE {
            return None;
        }
        let inverse = columns.inverse().transpose();
        let (middle, origin) = tile.middle(grid)?;
        let mut local = Self {
            middle,
            radius: 0.0,
            side: 0.0,
            rows: [inverse.x_axis, inverse.y_axis, normal],
            origin,
            margin: [ROUNDING; 2],
            heights: [f64::INFINITY, f64::NEG_INFINITY],
            counts,
            shortest: [inverse.x_axis, inverse.y_axis].map(|row| 1.0 / row.length()),
        };
        for (k, node) in tile.nodes(grid).enumerate().filter(|(_, node)| node.is_on_surface()) {
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
            let along = end - self.rows[2] * self.rows[2].dot(end);
            self.side = self.side.max(along.length() + ROUNDING);
        }
    }

    /// Lowers the top to the highest of what is left on the nodes of the tile, to whose `heights` nothing is added.
    pub fn lower_top(&mut self, grid: &Grid, tile: &Tile, heights: &[f64]) {
        let normal = self.rows[2];
        let held = tile.nodes(grid).zip(heights).filter(|(node, _)| node.is_on_surface());
        let top = held.map(|(node, height)| {
            let cosine = node.normal.dot(normal);
            // A line that goes down where others go up tells nothing.
            let up = if cosine > 0.0 { cosine * height } else { f64::INFINITY };
            (node.place - self.middle).dot(normal) + up
        });
        let top = top.fold(f64::NEG_INFINITY, f64::max) + ROUNDING;
        self.heights[1] = self.heights[1].min(top);
    }

    /// How the tile looks along an axis.
    pub fn bounds(&self, axis: DVec3) -> Bounds {
        let cosine = self.rows[2].dot(axis);
        let sine = (1.0 - cosine * cosine).max(0.0).sqrt();
        let [low, high] = self.heights;
        let ends = [low * cosine, high * cosine];
        let lean = self.side * sine;
        Bounds {
            side: self.side + sine * low.abs().max(high.abs()),
            low: ends[0].min(ends[1]) - lean,
            high: ends[0].max(ends[1]) + lean,
        }
    }

    /// At least so far from the material over the tile is a place from which `way` goes to the middle, mm.
    pub fn distance(&self, way: DVec3) -> f64 {
        let height = -way.dot(self.rows[2]);
        let along = (way + self.rows[2] * height).length();
        let off = (along - self.side).max(0.0);
        let over = (height - self.heights[1]).max(self.heights[0] - height).max(0.0);
        (off * off + over * over).sqrt()
    }

    /// At least so far from all places whose boxes hold a node is a mapped place, mm.
    pub fn outside(&self, at: DVec3) -> f64 {
        let beside = |x: f64, axis: usize| {
            let last = (self.counts[axis] - 1) as f64;
            (-self.margin[axis] - x).max(x - last - self.margin[axis]) * self.shortest[axis]
        };
        let over = (at.z - self.heights[1]).max(self.heights[0] - at.z);
        beside(at.x, 0).max(beside(at.y, 1)).max(over) - ROUNDING
    }

    /// Lets boxes hold nodes at any height over or under a quadrilateral.
    pub fn forget_heights(&mut self) {
        self.heights = [f64::NEG_INFINITY, f64::INFINITY];
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

/// Sides of a tile's cells along `u` and `v`; where it has none along one, as at a node that stands alone at the rim of a
/// surface, any that is square to the rest does.
fn sides(grid: &Grid, tile: &Tile, normal: DVec3) -> [DVec3; 2] {
    let mean = grid.cells().mean;
    match [0, 1].map(|axis| tile.side(grid, axis)) {
        [Some(du), Some(dv)] => [du, dv],
        [Some(du), None] => [du, normal.cross(du).normalize_or_zero() * mean[1]],
        [None, Some(dv)] => [dv.cross(normal).normalize_or_zero() * mean[0], dv],
        [None, None] => {
            let x = any_perpendicular(normal);
            [x * mean[0], normal.cross(x) * mean[1]]
        }
    }
}

/// The integers between two numbers, from 0 and below `count`.
fn range(low: f64, high: f64, count: usize) -> Range<usize> {
    let count = count as f64;
    // NaN gives an empty range. Casts round down; `ceil` and `floor` are calls on many machines.
    if !(high >= 0.0 && low < count) {
        return 0..0;
    }
    let low = low.max(0.0);
    let down = low as u32;
    let first = down + u32::from(f64::from(down) < low);
    let end = high.min(count - 1.0) as u32 + 1;
    first as usize..(end.max(first)) as usize
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
        let tiles = Tile::all(&grid, SIDE);
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
