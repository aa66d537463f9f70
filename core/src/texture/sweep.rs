//! What the edges sweep over a window: the height map.
//!
//! Terms. A *quadrilateral* is what an edge element sweeps in a time step, taken as two triangles; its error is that of a
//! chord, `l² / (8 r)`. A node's height is the least at which its normal meets one, from the start height down to the
//! *floor*: as far below the surface as the start height or the slack of the path, whichever is more, and the run-out by
//! which teeth come deeper; what lies below it is not looked at. Steps: (1) per move, the part of the edge that can
//! cut and the number of time steps (`stint`); (2) per tile of the grid, the moves that come near, the nearest first;
//! (3) per move, what its teeth sweep over the tile (`over`).
//!
//! Tiles are independent and the least of heights is exact in any order. So the result does not depend on the number of
//! threads, and nothing is merged.

mod options;
mod over;
mod simulation;
mod stint;
mod work;

pub use options::{Cutter, EdgePart, Search, SweepOptions};
pub use work::Work;

use super::edge::{Edge, Teeth};
use super::grid::Grid;
use super::kinematics::FeedMove;
use super::steps::edge_step;
use super::tile::{Local, SIDE, Tile};
use crate::geometry::{DVec3, OrderBy};
use crate::parallel;
use over::{Over, Swept};
use simulation::{Group, Sweep};
use stint::Stint;

/// Groups of tiles after which progress is reported: fewer would leave it standing for long, more would leave threads without
/// work at their ends.
const GROUPS: usize = 100;
/// Fewest tiles of a group.
const LEAST_GROUP: usize = 8;

/// The heights over a grid, and what they took.
#[derive(Clone, Debug, PartialEq)]
pub struct HeightMap {
    /// Height of each node along its normal, mm, in the grid's order; NaN beyond the surface.
    pub heights: Vec<f64>,
    /// What it took.
    pub work: Work,
}

/// The heights that the moves of a path leave over a grid. `progress` is called with the part done.
pub fn sweep(
    grid: &Grid,
    cutter: &Cutter,
    moves: &[FeedMove],
    options: &SweepOptions,
    progress: &mut dyn FnMut(f64),
) -> HeightMap {
    let l_min = options.resolution.unwrap_or(grid.cells().least);
    let edge = Edge::new(&cutter.tool, cutter.helix);
    let end = edge.side() + options.start;
    // On a flat end without a corner there is no arc; the step is the length itself.
    let step = edge_step(l_min, cutter.tool.radius()) * cutter.tool.radius();
    let teeth = Teeth::new(&edge, cutter.flutes, &cutter.runout, end, step);
    let stints: Vec<Stint> =
        moves.iter().map(|m| Stint::new(m, cutter, &teeth, options, l_min)).collect();
    let mut work = Work {
        steps: stints.iter().map(|s| u64::from(s.steps)).sum(),
        edge_points: stints.iter().map(Stint::points).max().unwrap_or(0),
        ..Work::default()
    };
    let sweep = Sweep {
        grid,
        teeth: &teeth,
        spindle: cutter.spindle,
        start: options.start,
        floor: options.start.max(options.slack) + cutter.runout.largest(),
        search: options.search,
        ball: (cutter.tool.bottom_radius() == 0.0).then(|| cutter.tool.radius()),
        groups: Group::all(&stints),
        stints,
    };
    let tiles = match options.search {
        Search::Near => Tile::all(grid, tile_side(l_min, grid.cells().least)),
        Search::Buckets => vec![Tile::whole(grid)],
    };
    let mut heights = vec![options.start; grid.nodes().len()];
    // In groups, so that progress shows.
    let group = tiles.len().div_ceil(GROUPS).max(LEAST_GROUP);
    let mut done = 0;
    for group in tiles.chunks(group) {
        progress(done as f64 / tiles.len() as f64);
        done += group.len();
        let swept = parallel::map(options.threads, group, |tile| sweep.tile(tile));
        for (tile, swept) in group.iter().zip(swept) {
            work.quads += swept.work.quads;
            work.tests += swept.work.tests;
            tile.write(&swept.heights, grid.counts()[0], &mut heights);
        }
    }
    progress(1.0);
    HeightMap { heights, work }
}

/// Nodes along the side of a tile: fewer where cells are longer than the steps. There hardly any quadrilateral meets a
/// line, and what comes near a tile without meeting one is most of the work: the narrower the tile, the less of it.
fn tile_side(l_min: f64, cell: f64) -> usize {
    let part = (l_min / cell).min(1.0);
    (SIDE as f64 * part * part).round().max(1.0) as usize
}

impl Sweep<'_> {
    fn tile(&self, tile: &Tile) -> Swept {
        let Some(local) = Local::new(self.grid, tile, self.floor) else {
            return Swept::before(self, tile);
        };
        let mut over = Over::new(self, tile, local);
        match self.search {
            Search::Near => self.near(over.local()).into_iter().for_each(|stint| over.visit(stint)),
            Search::Buckets => self.stints.iter().for_each(|stint| over.all(stint)),
        }
        over.done()
    }

    /// The stints that may come to a tile, the nearest first.
    fn near(&self, local: &Local) -> Vec<&Stint<'_>> {
        let may = |&(middle, radius): &(DVec3, f64)| {
            middle.distance(local.middle) <= radius + local.radius
        };
        let groups = self.groups.iter().filter(|group| may(&group.ball));
        let stints = groups.flat_map(|group| &self.stints[group.stints.clone()]);
        let mut near: Vec<(f64, &Stint)> = stints
            .filter(|stint| may(&stint.ball))
            .map(|stint| (stint.distance_squared(local.middle), stint))
            .collect();
        near.order_by(|a, b| a.0.total_cmp(&b.0));
        near.into_iter().map(|(_, stint)| stint).collect()
    }
}

#[cfg(test)]
mod tests;
