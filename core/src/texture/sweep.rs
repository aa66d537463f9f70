//! What the edges sweep over a window: the height map.
//!
//! Terms. A *quadrilateral* is what an edge element sweeps in a time step, taken as two triangles; its error is that of a
//! chord, `l² / (8 r)`. A node's height is the least at which its normal meets one, from the start height down; one
//! that lies deeper than the start height is high is not looked at. Steps: (1) per move, the part of the edge that can
//! cut and the number of time steps; (2) per tile of the grid, the time steps on which the cutter comes near, by
//! halving every move; (3) per step and tooth, the elements that come near; (4) per quadrilateral, the nodes in its
//! box.
//!
//! Tiles are independent and each runs through the path in order; the least of heights is exact. So the result does not
//! depend on the number of threads, and nothing is merged.

use super::edge::{Edge, Runout, Teeth};
use super::engagement::{Stretch, lowest_stretch};
use super::grid::Grid;
use super::kinematics::{FeedMove, Pose, Spindle};
use super::steps::{edge_step, time_step};
use super::tile::{Local, Tile, met};
use crate::geometry::DVec3;
use crate::geometry::math::{asin, atan2};
use crate::parallel;
use crate::tool::Tool;
use std::f64::consts::{PI, TAU};

/// Time steps that are gone through one by one once they cannot be left out together.
const RUN: u32 = 4;
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
    /// Part of the edges. Time steps are those of the effective part in any case, so that the results can be
    /// compared.
    pub part: EdgePart,
    /// Shortest length that is resolved, mm: `l_min`; `None` for the grid's shortest cell.
    pub resolution: Option<f64>,
    /// Number of threads, which changes nothing but the time.
    pub threads: usize,
}

/// The heights over a grid, and what they took.
#[derive(Clone, Debug, PartialEq)]
pub struct HeightMap {
    /// Height of each node along its normal, mm, in the grid's order.
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

/// The heights that the moves of a path leave over a grid.
pub fn sweep(
    grid: &Grid,
    cutter: &Cutter,
    moves: &[FeedMove],
    options: &SweepOptions,
) -> HeightMap {
    let l_min = options.resolution.unwrap_or(grid.cells().least);
    let edge = Edge::new(&cutter.tool, cutter.helix);
    let end = edge.side() + options.start;
    // On a flat end without a corner there is no arc; the step is the length itself.
    let step = edge_step(l_min, cutter.tool.radius()) * cutter.tool.radius();
    let teeth = Teeth::new(&edge, cutter.flutes, &cutter.runout, end, step);
    let stints: Vec<Stint> =
        moves.iter().map(|m| Stint::new(m, cutter, &teeth, options, l_min)).collect();
    let sweep = Sweep { grid, teeth: &teeth, spindle: cutter.spindle, start: options.start };
    let tiles = Tile::all(grid);
    let swept = parallel::map(options.threads, &tiles, |tile| sweep.tile(tile, &stints));
    let mut heights = vec![options.start; grid.nodes().len()];
    let mut work = Work {
        steps: stints.iter().map(|s| u64::from(s.steps)).sum(),
        edge_points: stints.iter().map(Stint::points).max().unwrap_or(0),
        ..Work::default()
    };
    for (tile, swept) in tiles.iter().zip(swept) {
        work.quads += swept.work.quads;
        work.tests += swept.work.tests;
        for (row, j) in swept.heights.chunks(tile.columns.len()).zip(tile.rows.clone()) {
            let first = j * grid.counts()[0] + tile.columns.start;
            heights[first..first + row.len()].copy_from_slice(row);
        }
    }
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
        let dt = time_step(l_min, cutter.spindle.speed, out(effective.last), feed);
        let steps = (of.duration / dt).ceil().clamp(1.0, f64::from(u32::MAX)) as u32;
        let stretch = if options.part == EdgePart::Full { all } else { effective };
        let rim = TAU * cutter.spindle.speed * out(stretch.last);
        let step_way = (rim + feed) * of.duration / f64::from(steps) * (1.0 + ROUNDING);
        Self { of, steps, stretch, way: feed * of.duration * (1.0 + ROUNDING), step_way }
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
}

/// Heights of a tile's nodes.
struct SweptTile {
    heights: Vec<f64>,
    work: Work,
}

/// Where a tile lies, seen from the cutter.
struct Seen {
    /// From the corner's centre to the tile's middle, mm.
    way: DVec3,
    /// Distance of its middle from the axis, mm.
    out: f64,
    /// Points of the edge that come as near as was asked.
    stretch: Stretch,
}

impl Sweep<'_> {
    fn tile(&self, tile: &Tile, stints: &[Stint]) -> SweptTile {
        let count = tile.columns.len() * tile.rows.len();
        let mut swept = SweptTile { heights: vec![self.start; count], work: Work::default() };
        let Some(local) = Local::new(self.grid, tile, self.start) else { return swept };
        let mut over = Over { sweep: self, tile, local: &local, rows: Rows::default() };
        for stint in stints {
            over.visit(stint, 0, stint.steps, &mut swept);
        }
        swept
    }

    /// Where a tile lies, if a point of the stretch, turned all around, may come within `reach` mm of its middle.
    fn seen(&self, pose: &Pose, middle: DVec3, reach: f64, stretch: Stretch) -> Option<Seen> {
        let way = middle - pose.centre;
        let height = way.dot(pose.axis);
        let out = (way - pose.axis * height).length();
        let part = &self.teeth.profile()[stretch.first..=stretch.last];
        // Both grow along the profile.
        let first = part.partition_point(|p| p.rho < out - reach || p.z < height - reach);
        let end = part.partition_point(|p| p.rho <= out + reach && p.z <= height + reach);
        let found = Stretch {
            first: (stretch.first + first).saturating_sub(1).max(stretch.first),
            last: (stretch.first + end).min(stretch.last),
        };
        (first < end).then_some(Seen { way, out, stretch: found })
    }
}

/// Points of an edge at the start and at the end of a step: in grid coordinates.
#[derive(Default)]
struct Rows {
    before: Vec<DVec3>,
    after: Vec<DVec3>,
}

/// A simulation over one tile.
struct Over<'a> {
    sweep: &'a Sweep<'a>,
    tile: &'a Tile,
    local: &'a Local,
    rows: Rows,
}

impl Over<'_> {
    /// Goes through the steps from `first` to `end` on which the cutter comes near, halving them.
    fn visit(&mut self, stint: &Stint, first: u32, end: u32, swept: &mut SweptTile) {
        let middle = first + (end - first) / 2;
        let part = f64::from(end - first) / f64::from(stint.steps);
        let reach = self.reach() + stint.way * part + stint.step_way;
        let pose = stint.pose(middle);
        if self.sweep.seen(&pose, self.local.middle, reach, stint.stretch).is_none() {
            return;
        }
        if end - first <= RUN {
            return (first..end).for_each(|step| self.step(stint, step, swept));
        }
        self.visit(stint, first, middle, swept);
        self.visit(stint, middle, end, swept);
    }

    /// How near to the tile's middle a point without run-out has to be.
    fn reach(&self) -> f64 {
        self.local.radius + self.sweep.teeth.runout() + self.sweep.teeth.step()
    }

    fn step(&mut self, stint: &Stint, step: u32, swept: &mut SweptTile) {
        let before = stint.pose(step);
        let reach = self.reach() + stint.step_way;
        let Some(seen) = self.sweep.seen(&before, self.local.middle, reach, stint.stretch) else {
            return;
        };
        let spindle = self.sweep.spindle;
        let angle = spindle.angle(stint.time(step));
        let frames = [
            Frame::new(before, angle, self.local),
            Frame::new(stint.pose(step + 1), spindle.angle(stint.time(step + 1)), self.local),
        ];
        let [x, y] = before.turned(angle);
        let direction = atan2(seen.way.dot(y), seen.way.dot(x));
        // The angle in which the tile is seen, generously.
        let half = if seen.out > reach { asin(reach / seen.out) } else { PI };
        let profile = self.sweep.teeth.profile();
        let [low, high] = [seen.stretch.first, seen.stretch.last].map(|k| profile[k].beta);
        let near = half + 0.5 * (high - low).abs() + ROUNDING;
        for (tooth, psi) in self.sweep.teeth.psi().iter().enumerate() {
            let apart = psi + 0.5 * (low + high) - direction;
            if (apart - TAU * (apart / TAU).round()).abs() <= near {
                self.elements(tooth, seen.stretch, &frames, swept);
            }
        }
    }

    /// The quadrilaterals that a stretch of a tooth's edge sweeps.
    fn elements(
        &mut self,
        tooth: usize,
        stretch: Stretch,
        frames: &[Frame; 2],
        swept: &mut SweptTile,
    ) {
        let teeth = self.sweep.teeth;
        let points = || (stretch.first..=stretch.last).map(|k| teeth.point(tooth, k));
        self.rows.before.clear();
        self.rows.after.clear();
        self.rows.before.extend(points().map(|p| frames[0].map(p)));
        self.rows.after.extend(points().map(|p| frames[1].map(p)));
        for k in stretch.first..stretch.last {
            let i = k - stretch.first;
            let Rows { before, after } = &self.rows;
            let [columns, rows] =
                self.local.box_of([before[i], before[i + 1], after[i + 1], after[i]]);
            swept.work.quads += 1;
            if columns.is_empty() || rows.is_empty() {
                continue;
            }
            let [a, b] = [k, k + 1].map(|k| frames[0].place(teeth.point(tooth, k)));
            let [d, c] = [k, k + 1].map(|k| frames[1].place(teeth.point(tooth, k)));
            for j in rows {
                for i in columns.clone() {
                    self.test([i, j], [a, b, c, d], swept);
                }
            }
        }
    }

    /// Lowers a node to a quadrilateral that its line meets.
    fn test(&self, [i, j]: [usize; 2], corners: [DVec3; 4], swept: &mut SweptTile) {
        let node = self.sweep.grid.node(self.tile.columns.start + i, self.tile.rows.start + j);
        let place = node.place - self.local.middle;
        swept.work.tests += 1;
        let Some(height) = met(node.normal, corners.map(|c| c - place)) else { return };
        let held = &mut swept.heights[j * self.tile.columns.len() + i];
        if height < *held && height >= -self.sweep.start {
            *held = height;
        }
    }
}

/// The tool frame with its teeth turned, in space relative to a tile's middle and in its grid coordinates.
struct Frame {
    centre: DVec3,
    axes: [DVec3; 3],
    mapped_centre: DVec3,
    mapped: [DVec3; 3],
}

impl Frame {
    fn new(pose: Pose, angle: f64, local: &Local) -> Self {
        let [x, y] = pose.turned(angle);
        let axes = [x, y, pose.axis];
        let centre = pose.centre - local.middle;
        Self { centre, axes, mapped_centre: local.map(centre), mapped: axes.map(|a| local.turn(a)) }
    }

    fn place(&self, p: DVec3) -> DVec3 {
        self.centre + self.axes[0] * p.x + self.axes[1] * p.y + self.axes[2] * p.z
    }

    fn map(&self, p: DVec3) -> DVec3 {
        self.mapped_centre + self.mapped[0] * p.x + self.mapped[1] * p.y + self.mapped[2] * p.z
    }
}

#[cfg(test)]
mod tests;
