//! The grid of a window: nodes on a surface, with the normals along which heights are measured.
//!
//! Terms. A *window* is a rectangle of parameters `(u, v)` of a surface, which a closure turns into places. Two
//! discretisations of the source: *uniform*, even steps of `u` and of `v`, so small that no cell is longer than
//! `d_max`; *constant*, a net whose cells all have the length `d_max`, within `eps`, along both directions: the first row
//! and column by bisection on `du` and `dv`, every other node by bisection on both in turn, until it has its distance
//! from both neighbours (a Chebyshev net).

use crate::geometry::{DVec2, DVec3};
use crate::parallel;
use thiserror::Error;

/// Most nodes of a grid.
pub const MOST_NODES: f64 = 2e7;
/// How often the uniform grid may be made finer until its longest cell is short enough.
const REFINEMENTS: usize = 20;
/// Rounds of it after which steps are made smaller than the longest cell asks for, by so much more each time.
const SOON: usize = 5;
const ROOM: f64 = 0.01;
/// Halvings of a bisection: enough for all bits of a length.
const HALVINGS: usize = 60;
/// Rounds of bisections on `du` and `dv` in turn.
const ROUNDS: usize = 40;
/// Most doublings of the first guess of a step.
const DOUBLINGS: usize = 20;

/// A node of a grid.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Node {
    /// Place on the surface, mm.
    pub place: DVec3,
    /// Unit normal toward the tool.
    pub normal: DVec3,
}

impl Node {
    /// No node: a place of the grid beyond the surface.
    pub const BEYOND: Self = Self { place: DVec3::NAN, normal: DVec3::ZERO };

    /// Whether it is on the surface.
    pub fn is_on_surface(&self) -> bool {
        self.normal != DVec3::ZERO
    }
}

/// Why a window has no grid.
#[derive(Copy, Clone, Debug, PartialEq, Error)]
pub enum GridError {
    /// A node is not on the surface.
    #[error(
        "texture: the window leaves the surface {} from its middle: make it smaller or move it",
        from_middle(*.u, *.v)
    )]
    OffSurface {
        /// First parameter of the node.
        u: f64,
        /// Second parameter.
        v: f64,
    },
    /// No two neighbouring nodes are on the surface.
    #[error(
        "texture: cells of {cell} mm are longer than the surface is wide: give a smaller spacing"
    )]
    TooCoarse {
        /// Length of a cell, mm.
        cell: f64,
    },
    /// Steps of the flat map that keep cells short enough were not found.
    #[error(
        "texture: no even grid in the flat map keeps all cells on the surface below {cell} mm: give another spacing"
    )]
    NoSteps {
        /// Length of a cell, mm.
        cell: f64,
    },
    /// More nodes than a grid may have.
    #[error(
        "texture: a window of {nodes:.0} nodes; at most {MOST_NODES:.0}: make it smaller, or its spacing larger"
    )]
    TooMany {
        /// The nodes asked for.
        nodes: f64,
    },
    /// No extent, or cells that cannot be.
    #[error(
        "texture: a window of {along} by {across} mm with cells of {cell} mm; all must be positive numbers"
    )]
    NoExtent {
        /// Along the feed.
        along: f64,
        /// Across it.
        across: f64,
        /// Length of a cell.
        cell: f64,
    },
    /// A net of constant cells does not close over the surface.
    #[error(
        "texture: no cells of constant length {} from the middle of the window: the surface turns too much for it; use \
         the uniform discretisation",
        from_middle(*.u, *.v)
    )]
    NoNet {
        /// First parameter.
        u: f64,
        /// Second parameter.
        v: f64,
    },
}

/// Where a place is, seen from the middle of a window by somebody who looks along the feed.
fn from_middle(u: f64, v: f64) -> String {
    let along = if u < 0.0 { "behind" } else { "ahead" };
    let across = if v < 0.0 { "to the right of" } else { "to the left of" };
    format!("{:.4} mm {along} and {:.4} mm {across} the feed", u.abs(), v.abs())
}

/// Which cells a grid has.
#[derive(Copy, Clone, Debug, PartialEq)]
pub enum Discretisation {
    /// Even steps of the parameters.
    Uniform,
    /// Even lengths on the surface, within a part of the cell.
    Constant {
        /// `eps`, mm.
        eps: f64,
    },
}

/// A structured grid of nodes on a surface.
#[derive(Clone, Debug, PartialEq)]
pub struct Grid {
    nodes: Vec<Node>,
    counts: [usize; 2],
    cells: Cells,
}

/// Lengths of the cells of a grid, mm.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Cells {
    /// Means along `u` and along `v`.
    pub mean: [f64; 2],
    /// The shortest, `l_min`.
    pub least: f64,
    /// The longest.
    pub largest: f64,
}

impl Grid {
    /// The grid of the window of `size` mm about parameters 0, with cells of at most `cell` mm, or of just that
    /// length.
    ///
    /// `surface` gives the node at parameters `(u, v)`, which are mm where the surface is not stretched; `None` where
    /// there is none, which is an error, or [`Node::BEYOND`], which leaves a gap in a uniform grid.
    ///
    /// # Errors
    /// [`GridError`]: a window that is not on the surface or has no or too many nodes.
    pub fn new(
        size: DVec2,
        cell: f64,
        discretisation: Discretisation,
        threads: usize,
        surface: &(impl Fn(DVec2) -> Option<Node> + Sync),
    ) -> Result<Self, GridError> {
        let numbers = [size.x, size.y, cell];
        if !numbers.iter().all(|x| x.is_finite() && *x > 0.0) {
            return Err(GridError::NoExtent { along: size.x, across: size.y, cell });
        }
        refuse_too_many([size.x / cell, size.y / cell])?;
        match discretisation {
            Discretisation::Uniform => Self::uniform(size, cell, threads, surface),
            Discretisation::Constant { eps } => Self::constant(size, cell, eps, surface),
        }
    }

    /// Nodes, `u` fastest.
    pub fn nodes(&self) -> &[Node] {
        &self.nodes
    }

    /// Numbers of nodes along `u` and along `v`.
    pub fn counts(&self) -> [usize; 2] {
        self.counts
    }

    /// Lengths of the cells.
    pub fn cells(&self) -> Cells {
        self.cells
    }

    /// Node `i` along `u`, `j` along `v`.
    pub fn node(&self, i: usize, j: usize) -> &Node {
        &self.nodes[j * self.counts[0] + i]
    }

    fn uniform(
        size: DVec2,
        cell: f64,
        threads: usize,
        surface: &(impl Fn(DVec2) -> Option<Node> + Sync),
    ) -> Result<Self, GridError> {
        // Rounding must not ask for one cell more than a length divides into.
        let steps = |length: f64, cell: f64| (length / cell - 1e-9).ceil().max(1.0);
        let mut asked = [cell; 2];
        for round in 0..REFINEMENTS {
            let [nu, nv] = [steps(size.x, asked[0]), steps(size.y, asked[1])];
            refuse_too_many([nu, nv])?;
            let at =
                |i: usize, j: usize| DVec2::new(i as f64 / nu - 0.5, j as f64 / nv - 0.5) * size;
            let rows: Vec<usize> = (0..=nv as usize).collect();
            let row = |j: &usize| -> Result<Vec<Node>, GridError> {
                let node = |i| surface(at(i, *j)).ok_or_else(|| off(at(i, *j)));
                (0..=nu as usize).map(node).collect()
            };
            let mut nodes = Vec::with_capacity((nu as usize + 1) * (nv as usize + 1));
            for row in parallel::map(threads, &rows, row) {
                nodes.extend(row?);
            }
            let grid = Self::of(nodes, [nu as usize + 1, nv as usize + 1]);
            let longest = grid.longest();
            if longest.contains(&0.0) {
                return Err(GridError::TooCoarse { cell });
            }
            if longest.iter().all(|l| *l <= cell * (1.0 + 1e-9)) {
                return Ok(grid);
            }
            // Where the surface ends between nodes, finer steps may meet a longer cell: room for it, more from round to round.
            let room = if round < SOON { 1e-6 } else { ROOM * (round + 1 - SOON) as f64 };
            for axis in [0, 1] {
                asked[axis] *= (cell / longest[axis]).min(1.0) * (1.0 - room);
            }
        }
        Err(GridError::NoSteps { cell })
    }

    fn constant(
        size: DVec2,
        cell: f64,
        eps: f64,
        surface: &impl Fn(DVec2) -> Option<Node>,
    ) -> Result<Self, GridError> {
        let cells = (size / cell).round().max(DVec2::ONE);
        let counts = [cells.x as usize + 1, cells.y as usize + 1];
        let net = Net { surface, cell, eps };
        let mut at = Vec::with_capacity(counts[0] * counts[1]);
        let mut nodes: Vec<Node> = Vec::with_capacity(at.capacity());
        for j in 0..counts[1] {
            for i in 0..counts[0] {
                let below = (j > 0).then(|| nodes.len() - counts[0]);
                let uv = match (i, below) {
                    (0, None) => -0.5 * size,
                    (_, None) => net.step(at[i - 1], &nodes[i - 1], DVec2::X)?,
                    (0, Some(b)) => net.step(at[b], &nodes[b], DVec2::Y)?,
                    (_, Some(b)) => {
                        let left = nodes.len() - 1;
                        // The fourth corner of a parallelogram.
                        let guess = at[left] + at[b] - at[b - 1];
                        net.corner(guess, &nodes[left], &nodes[b])?
                    }
                };
                nodes.push(surface(uv).ok_or_else(|| off(uv))?);
                at.push(uv);
            }
        }
        Ok(Self::of(nodes, counts))
    }

    fn of(nodes: Vec<Node>, counts: [usize; 2]) -> Self {
        let cells = Cells { mean: [0.0; 2], least: 0.0, largest: 0.0 };
        let mut grid = Self { nodes, counts, cells };
        let (mut sums, mut least, mut largest) = ([0.0; 2], f64::INFINITY, 0.0_f64);
        let mut sides = [0_usize; 2];
        grid.visit_sides(|axis, length| {
            sums[axis] += length;
            sides[axis] += 1;
            (least, largest) = (least.min(length), largest.max(length));
        });
        let mean = [0, 1].map(|axis| sums[axis] / sides[axis].max(1) as f64);
        grid.cells = Cells { mean, least, largest };
        grid
    }

    /// Longest sides of cells along `u` and along `v`, mm.
    fn longest(&self) -> [f64; 2] {
        let mut longest = [0.0_f64; 2];
        self.visit_sides(|axis, length| longest[axis] = longest[axis].max(length));
        longest
    }

    fn visit_sides(&self, mut visit: impl FnMut(usize, f64)) {
        let [nu, nv] = self.counts;
        for j in 0..nv {
            for i in 0..nu {
                let here = self.node(i, j).place;
                let mut side = |axis: usize, next: Option<&Node>| {
                    let length = next.map_or(f64::NAN, |node| here.distance(node.place));
                    // A place beyond the surface has no sides.
                    if !length.is_nan() {
                        visit(axis, length);
                    }
                };
                side(0, (i + 1 < nu).then(|| self.node(i + 1, j)));
                side(1, (j + 1 < nv).then(|| self.node(i, j + 1)));
            }
        }
    }
}

fn off(uv: DVec2) -> GridError {
    GridError::OffSurface { u: uv.x, v: uv.y }
}

fn refuse_too_many([nu, nv]: [f64; 2]) -> Result<(), GridError> {
    let nodes = (nu + 1.0) * (nv + 1.0);
    if nodes > MOST_NODES { Err(GridError::TooMany { nodes }) } else { Ok(()) }
}

/// A net of cells of one length.
struct Net<'a, S> {
    surface: &'a S,
    cell: f64,
    eps: f64,
}

impl<S: Fn(DVec2) -> Option<Node>> Net<'_, S> {
    /// Parameters from `from` along `direction` whose node is a cell away from `node`.
    fn step(&self, from: DVec2, node: &Node, direction: DVec2) -> Result<DVec2, GridError> {
        let mut far = self.cell;
        for _ in 0..DOUBLINGS {
            if self.distance(from + direction * far, node)? >= self.cell {
                return self.bisected(from, direction, [0.0, far], node);
            }
            far *= 1.25;
        }
        Err(GridError::NoNet { u: from.x, v: from.y })
    }

    /// Parameters near `guess` whose node is a cell away from both, by bisection on `u` for the one on the left and on
    /// `v` for the one below, in turn.
    fn corner(&self, guess: DVec2, left: &Node, below: &Node) -> Result<DVec2, GridError> {
        let mut at = guess;
        let aim = 0.5 * self.eps;
        for _ in 0..ROUNDS {
            let errors = [self.distance(at, left)?, self.distance(at, below)?]
                .map(|length| length - self.cell);
            if errors.iter().all(|e| e.abs() <= aim) {
                return Ok(at);
            }
            for (error, direction, node) in
                [(errors[0], DVec2::X, left), (errors[1], DVec2::Y, below)]
            {
                // The step is at most a few times the error where the net is not folded.
                let reach = 0.5 * self.cell.min(8.0 * error.abs() + self.eps);
                let bracket = [-reach, reach];
                at = self.bisected(at, direction, bracket, node)?;
            }
        }
        Err(GridError::NoNet { u: guess.x, v: guess.y })
    }

    /// Where, between two steps along `direction`, the distance from `node` grows past a cell.
    fn bisected(
        &self,
        from: DVec2,
        direction: DVec2,
        [mut near, mut far]: [f64; 2],
        node: &Node,
    ) -> Result<DVec2, GridError> {
        for _ in 0..HALVINGS {
            let middle = 0.5 * (near + far);
            let error = self.distance(from + direction * middle, node)? - self.cell;
            if error.abs() <= 0.125 * self.eps {
                (near, far) = (middle, middle);
                break;
            }
            *(if error < 0.0 { &mut near } else { &mut far }) = middle;
        }
        Ok(from + direction * (0.5 * (near + far)))
    }

    fn distance(&self, at: DVec2, node: &Node) -> Result<f64, GridError> {
        (self.surface)(at).map(|n| n.place.distance(node.place)).ok_or_else(|| off(at))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface::AnalyticSurface;

    fn of(surface: &AnalyticSurface) -> impl Fn(DVec2) -> Option<Node> + Sync + '_ {
        |at| Some(Node { place: surface.position(at), normal: surface.curvature(at).normal() })
    }

    fn surfaces() -> [AnalyticSurface; 4] {
        [
            AnalyticSurface::Plane { width: 30.0, depth: 20.0 },
            AnalyticSurface::SphereCap { radius: 40.0, diameter: 30.0 },
            AnalyticSurface::Torus { major: 30.0, minor: 10.0, length: 20.0, width: 15.0 },
            AnalyticSurface::Bump { size: 20.0, height: 3.0, width: 5.0 },
        ]
    }

    #[test]
    fn uniform_cells_are_at_most_as_long_as_asked_and_nearly_so() {
        for surface in surfaces() {
            let grid =
                Grid::new(DVec2::new(6.0, 4.0), 0.1, Discretisation::Uniform, 2, &of(&surface))
                    .unwrap();
            let cells = grid.cells();
            assert!(cells.largest <= 0.1 * (1.0 + 1e-9) && cells.largest > 0.097, "{cells:?}");
            assert!(grid.counts()[0] >= 61 && grid.counts()[1] >= 41);
        }
    }

    #[test]
    fn constant_cells_have_the_length_asked_for() {
        for surface in surfaces() {
            let asked = Discretisation::Constant { eps: 1e-5 };
            let grid = Grid::new(DVec2::new(6.0, 4.0), 0.1, asked, 1, &of(&surface)).unwrap();
            let cells = grid.cells();
            assert_eq!(grid.counts(), [61, 41]);
            assert!(cells.largest <= 0.1 + 1e-5 && cells.least >= 0.1 - 1e-5, "{cells:?}");
        }
    }

    /// The longest cells are at the rim, and whether one is there changes with the steps.
    #[test]
    fn a_whole_dome_has_a_grid_at_every_spacing() {
        let dome = |at: DVec2| {
            let r = at.length();
            if r > 0.995 {
                return Some(Node::BEYOND);
            }
            let place = at.extend((1.0 - r * r).sqrt());
            Some(Node { place, normal: place.normalize() })
        };
        for k in 0..60 {
            let cell = 0.02 + 0.001 * f64::from(k);
            let grid = Grid::new(DVec2::splat(1.99), cell, Discretisation::Uniform, 1, &dome);
            let largest = grid.unwrap_or_else(|e| panic!("{cell}: {e}")).cells().largest;
            assert!(largest <= cell * (1.0 + 1e-9), "{largest} of {cell}");
        }
    }

    #[test]
    fn what_is_no_window_is_refused() {
        let plane = |at: DVec2| {
            (at.x.abs() < 1.0).then_some(Node { place: at.extend(0.0), normal: DVec3::Z })
        };
        let new = |x: f64, cell: f64, how| Grid::new(DVec2::new(x, 1.0), cell, how, 1, &plane);
        for how in [Discretisation::Uniform, Discretisation::Constant { eps: 1e-5 }] {
            assert!(matches!(new(3.0, 0.1, how), Err(GridError::OffSurface { .. })));
            assert!(matches!(new(1.0, 1e-4, how), Err(GridError::TooMany { .. })));
            assert!(matches!(new(f64::NAN, 0.1, how), Err(GridError::NoExtent { .. })));
            assert!(matches!(new(1.0, 0.0, how), Err(GridError::NoExtent { .. })));
            assert!(new(1.0, 0.1, how).is_ok());
        }
    }
}
