//! What the edges sweep over a window: the height map.
//!
//! Terms. A *quadrilateral* is what an edge element sweeps in a time step, taken as two triangles; its error is that of a
//! chord, `l² / (8 r)`. A node's height is the least at which its normal meets one, from the start height down; one
//! that lies deeper than the start height is high is not looked at. Steps: (1) per move, the part of the edge that can
//! cut and the number of time steps; (2) per tile of the grid, the moves that come near, the nearest first; (3) per move,
//! what its teeth sweep over the tile (`over`).
//!
//! Tiles are independent and the least of heights is exact in any order. So the result does not depend on the number of
//! threads, and nothing is merged.

mod over;

use super::edge::{Edge, Runout, Teeth};
use super::engagement::{Stretch, lowest_stretch};
use super::grid::Grid;
use super::kinematics::{FeedMove, Pose, Spindle};
use super::steps::{edge_step, time_step};
use super::tile::{Local, Tile};
use crate::geometry::DVec3;
use crate::parallel;
use crate::tool::{Tool, ToolKind};
use over::{Over, Swept};
use std::f64::consts::TAU;
use std::ops::Range;

/// Moves that are looked at together first.
const GROUP: usize = 64;
/// Groups of tiles after which progress is told: fewer would leave it standing for long, more would leave threads without
/// work at their ends.
const GROUPS: usize = 100;
/// Fewest tiles of a group.
const LEAST_GROUP: usize = 8;
/// Rounding of lengths, as a part of them.
const ROUNDING: f64 = 1e-9;

/// Which part of the edges is simulated.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum EdgePart {
    /// The part that can touch material.
    Effective,
    /// All of it: bottom, corner, and the side up to the start height.
    Full,
}

/// How time steps and elements of an edge find the nodes that they may lower.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum Search {
    /// Tile by tile: only steps and elements that come near a tile are looked at.
    Near,
    /// All elements in all steps; each quadrilateral is tested with the nodes of its box along the grid, however high it
    /// goes over them, and on one thread. A measure for the other, which gives the same heights.
    Buckets,
}

/// A cutter with its teeth.
#[derive(Clone, Debug, PartialEq)]
pub struct Cutter {
    /// Its body.
    pub tool: Tool,
    /// Number of teeth.
    pub flutes: u32,
    /// Helix angle, rad.
    pub helix: f64,
    /// How the teeth stand to the axis of turning.
    pub runout: Runout,
    /// How it turns.
    pub spindle: Spindle,
}

/// How a sweep is simulated.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct SweepOptions {
    /// Height of the material over the surface before, mm.
    pub start: f64,
    /// How far above the contact material reaches on the edge, mm; see [`thickness`](super::engagement::thickness).
    pub thickness: f64,
    /// How far the path may be off the surface, mm; added to the thickness.
    pub slack: f64,
    /// Part of the edges.
    pub part: EdgePart,
    /// Part of the edges whose points go no farther than the resolution in a time step. Parts can be compared node for
    /// node where it is the same.
    pub pace: EdgePart,
    /// How nodes are found.
    pub search: Search,
    /// Shortest length that is resolved, mm: `l_min`; `None` for the grid's shortest cell.
    pub resolution: Option<f64>,
    /// Number of threads, which changes nothing but the time.
    pub threads: usize,
}

/// The heights over a grid, and what they took.
#[derive(Clone, Debug, PartialEq)]
pub struct HeightMap {
    /// Height of each node along its normal, mm, in the grid's order; NaN beyond the surface.
    pub heights: Vec<f64>,
    /// What it took.
    pub work: Work,
}

/// What a simulation took.
#[derive(Copy, Clone, Debug, PartialEq, Eq, Default)]
pub struct Work {
    /// Time steps of all moves.
    pub steps: u64,
    /// Points of the edge of one tooth, of the part that is simulated where it is the longest.
    pub edge_points: u64,
    /// Quadrilaterals near a tile.
    pub quads: u64,
    /// Lines of nodes tested against a quadrilateral.
    pub tests: u64,
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
        search: options.search,
        ball: (cutter.tool.kind() == ToolKind::Ball).then(|| cutter.tool.radius()),
        groups: Group::all(&stints),
        stints,
    };
    let tiles = match options.search {
        Search::Near => Tile::all(grid),
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

/// A move, cut into time steps.
struct Stint<'a> {
    of: &'a FeedMove,
    steps: u32,
    /// The points of the edge that are simulated.
    stretch: Stretch,
    /// Farthest way of a point of the body in the whole move, without the turn of the spindle, mm.
    way: f64,
    /// Farthest way of a simulated point in a time step, mm.
    step_way: f64,
    /// Middle and radius of a ball that holds all simulated points on the move.
    ball: (DVec3, f64),
}

impl<'a> Stint<'a> {
    fn new(
        of: &'a FeedMove,
        cutter: &Cutter,
        teeth: &Teeth,
        options: &SweepOptions,
        l_min: f64,
    ) -> Self {
        let profile = teeth.profile();
        let all = Stretch { first: 0, last: profile.len() - 1 };
        let thickness = options.thickness + options.slack + teeth.runout() + teeth.step();
        let effective = of.normals.map_or(all, |normals| {
            let tilted = |s: f64| {
                let normal = normals[0].lerp(normals[1], s).normalize_or(normals[1]);
                let cosine = normal.dot(of.pose(s).axis).clamp(-1.0, 1.0);
                lowest_stretch(profile, cosine, thickness)
            };
            tilted(0.0).hull(tilted(0.5)).hull(tilted(1.0))
        });
        let out = |k: usize| profile[k].rho + teeth.runout();
        let last = profile[all.last];
        let reach = out(all.last) + (last.z - profile[0].z);
        // The tip's, and what the turn of the axis adds to it.
        let feed = of.tip_feed() + of.turn_rate() * reach;
        let stretch_of = |part| if part == EdgePart::Full { all } else { effective };
        let pace = stretch_of(options.pace);
        let dt = time_step(l_min, cutter.spindle.speed, out(pace.last), feed);
        let steps = (of.duration / dt).ceil().clamp(1.0, f64::from(u32::MAX)) as u32;
        let stretch = stretch_of(options.part);
        let rim = TAU * cutter.spindle.speed * out(stretch.last);
        let step_way = (rim + feed) * of.duration / f64::from(steps) * (1.0 + ROUNDING);
        let way = feed * of.duration * (1.0 + ROUNDING);
        let heights = [stretch.first, stretch.last].map(|k| profile[k].z.abs());
        let far = out(stretch.last) + heights[0].max(heights[1]);
        let ball = (of.pose(0.5).centre, far + way + step_way + teeth.spacing());
        Self { of, steps, stretch, way, step_way, ball }
    }

    /// Of a place from the way of the corner's centre, mm².
    fn distance_squared(&self, place: DVec3) -> f64 {
        let [a, b] = [0.0, 1.0].map(|s| self.of.pose(s).centre);
        let way = b - a;
        let part =
            ((place - a).dot(way) / way.length_squared().max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
        place.distance_squared(a + way * part)
    }

    fn points(&self) -> u64 {
        (self.stretch.last - self.stretch.first + 1) as u64
    }

    fn pose(&self, step: u32) -> Pose {
        self.of.pose(f64::from(step) / f64::from(self.steps))
    }

    fn time(&self, step: u32) -> f64 {
        self.of.start + self.of.duration * f64::from(step) / f64::from(self.steps)
    }
}

/// A simulation over a grid.
struct Sweep<'a> {
    grid: &'a Grid,
    teeth: &'a Teeth,
    spindle: Spindle,
    start: f64,
    search: Search,
    /// Radius of the cutter, if it is a ball.
    ball: Option<f64>,
    stints: Vec<Stint<'a>>,
    groups: Vec<Group>,
}

/// Stints that follow each other, in a ball.
struct Group {
    stints: Range<usize>,
    ball: (DVec3, f64),
}

impl Group {
    fn all(stints: &[Stint]) -> Vec<Self> {
        let of = |(k, group): (usize, &[Stint])| {
            let middle = group[group.len() / 2].ball.0;
            let radius = group.iter().map(|s| s.ball.0.distance(middle) + s.ball.1);
            let ball = (middle, radius.fold(0.0, f64::max) * (1.0 + ROUNDING));
            Self { stints: k * GROUP..k * GROUP + group.len(), ball }
        };
        stints.chunks(GROUP).enumerate().map(of).collect()
    }
}

impl Sweep<'_> {
    fn tile(&self, tile: &Tile) -> Swept {
        let Some(local) = Local::new(self.grid, tile, self.start) else {
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
        near.sort_by(|a, b| a.0.total_cmp(&b.0));
        near.into_iter().map(|(_, stint)| stint).collect()
    }
}

#[cfg(test)]
mod tests;
