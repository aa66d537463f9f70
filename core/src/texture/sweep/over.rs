//! What the edges sweep over one tile.
//!
//! Terms. The *top* of a tile is the highest that material still stands over its middle: nothing above it lowers a node,
//! and since the nearest moves come first it is low soon. Steps: (1) halve a move, and leave out the parts on which the
//! body of the cutter stays off the tile, or all teeth turn past it; (2) in each of the time steps that remain, go along
//! the edges; a point that is far from the tile lets as many elements be skipped as are shorter than the distance;
//! (3) test each quadrilateral with the nodes in its box.

use super::options::Search;
use super::simulation::Sweep;
use super::stint::{ROUNDING, Stint};
use super::work::Work;
use crate::geometry::DVec3;
use crate::geometry::math::{asin, atan2};
use crate::texture::engagement::Stretch;
use crate::texture::grid::Node;
use crate::texture::kinematics::Pose;
use crate::texture::tile::{Local, Tile, met};
use std::f64::consts::{PI, TAU};
use std::ops::Range;

/// Time steps that are gone through one by one: fewer cost more looks at the tile, more cost steps without a tooth.
const RUN: u32 = 4;
/// Time steps after which the top is looked for again: that takes about as long as some of them.
const LOOK: u32 = 64;

/// Heights of a tile's nodes; NaN beyond the surface.
pub(super) struct Swept {
    pub heights: Vec<f64>,
    pub work: Work,
}

impl Swept {
    /// Of a tile to which nothing came.
    pub fn before(sweep: &Sweep, tile: &Tile) -> Self {
        let height = |node: &Node| if node.is_on_surface() { sweep.start } else { f64::NAN };
        Self { heights: tile.nodes(sweep.grid).map(height).collect(), work: Work::default() }
    }
}

/// A simulation over one tile.
pub(super) struct Over<'a> {
    sweep: &'a Sweep<'a>,
    tile: &'a Tile,
    local: Local,
    swept: Swept,
    /// Whether a node was lowered since the top was looked for.
    is_lower: bool,
}

/// What of the teeth may come to a tile in some time steps.
struct Seen {
    /// Points of the edge.
    stretch: Stretch,
    /// Angle of the spindle at which tooth 0 is over the tile, and how far it may be off that, rad.
    turn: f64,
    off: f64,
}

impl Seen {
    /// Whether a tooth at `psi` may come to the tile while the spindle is near `angle`.
    fn has(&self, psi: f64, angle: f64) -> bool {
        let apart = psi + angle - self.turn;
        (apart - TAU * (apart / TAU).round()).abs() <= self.off
    }
}

impl<'a> Over<'a> {
    pub fn new(sweep: &'a Sweep<'a>, tile: &'a Tile, mut local: Local) -> Self {
        if sweep.search == Search::Buckets {
            local.forget_heights();
        }
        let swept = Swept::before(sweep, tile);
        Self { sweep, tile, local, swept, is_lower: false }
    }

    pub fn local(&self) -> &Local {
        &self.local
    }

    pub fn done(self) -> Swept {
        self.swept
    }

    /// All elements of all teeth in all steps of a move.
    pub fn all(&mut self, stint: &Stint) {
        for step in 0..stint.steps {
            let frames = [step, step + 1].map(|step| self.frame(stint, step));
            for tooth in 0..self.sweep.teeth.psi().len() {
                self.elements(stint, tooth, stint.stretch, [&frames[0], &frames[1]]);
            }
        }
    }

    /// The steps of a move on which a tooth comes near.
    pub fn visit(&mut self, stint: &Stint) {
        self.part(stint, 0, stint.steps);
    }

    fn part(&mut self, stint: &Stint, first: u32, end: u32) {
        self.look(stint, end - first);
        let middle = first + (end - first) / 2;
        let pose = stint.pose(middle);
        let angle = self.sweep.spindle.angle(stint.time(middle));
        // To the end that is farther away.
        let part = f64::from(end - middle) / f64::from(stint.steps);
        let Some(seen) = self.seen(stint, &pose, part) else { return };
        let psi = self.sweep.teeth.psi();
        if !psi.iter().any(|psi| seen.has(*psi, angle)) {
            return;
        }
        if end - first <= RUN {
            return self.run(stint, first..end, &seen, angle);
        }
        let quarter = |a: u32, b: u32| stint.pose(a + (b - a) / 2).centre;
        let [one, two] = [quarter(first, middle), quarter(middle, end)]
            .map(|centre| centre.distance_squared(self.local.middle));
        let mut halves = [(first, middle), (middle, end)];
        if two < one {
            halves.swap(0, 1);
        }
        halves.into_iter().for_each(|(first, end)| self.part(stint, first, end));
    }

    /// Looks for the top before a part of some length, once on the way down to single steps.
    fn look(&mut self, stint: &Stint, steps: u32) {
        let is_due = steps <= LOOK && (2 * steps > LOOK || steps == stint.steps);
        if is_due && self.is_lower {
            self.is_lower = false;
            self.local.lower_top(self.sweep.grid, self.tile, &self.swept.heights);
        }
    }

    /// Steps with the teeth that may come near in them.
    fn run(&mut self, stint: &Stint, steps: Range<u32>, seen: &Seen, angle: f64) {
        let mut before = self.frame(stint, steps.start);
        for step in steps {
            let after = self.frame(stint, step + 1);
            for (tooth, psi) in self.sweep.teeth.psi().iter().enumerate() {
                if seen.has(*psi, angle) {
                    self.elements(stint, tooth, seen.stretch, [&before, &after]);
                }
            }
            before = after;
        }
    }

    /// What may come to the tile while the cutter is a part `part` of the move away from a pose at most; `None` if
    /// nothing does.
    fn seen(&self, stint: &Stint, pose: &Pose, part: f64) -> Option<Seen> {
        let teeth = self.sweep.teeth;
        let slack = stint.way * part + stint.step_way + teeth.spacing() + teeth.runout();
        let way = self.local.middle - pose.centre;
        if self.is_off_ball(stint, way, slack) {
            return None;
        }
        let bounds = self.local.bounds(pose.axis);
        let height = way.dot(pose.axis);
        let out = (way - pose.axis * height).length();
        let side = bounds.side + slack;
        let [low, high] = [height + bounds.low - slack, height + bounds.high + slack];
        let profile = teeth.profile();
        let edge = &profile[stint.stretch.first..=stint.stretch.last];
        // Both grow along the profile.
        let first = edge.partition_point(|p| p.rho < out - side || p.z < low);
        let end = edge.partition_point(|p| p.rho <= out + side && p.z <= high);
        if first >= end {
            return None;
        }
        let stretch = Stretch {
            first: (stint.stretch.first + first).saturating_sub(1).max(stint.stretch.first),
            last: (stint.stretch.first + end).min(stint.stretch.last),
        };
        let [low, high] = [stretch.first, stretch.last].map(|k| profile[k].beta);
        let turned = TAU * self.sweep.spindle.speed * stint.of.duration * part;
        let near = 0.5 * (high - low).abs() + turned + ROUNDING;
        if out <= side || near >= PI {
            return Some(Seen { stretch, turn: 0.0, off: PI + ROUNDING });
        }
        let direction = atan2(way.dot(pose.axis.cross(pose.x)), way.dot(pose.x));
        let turn = direction - 0.5 * (low + high);
        Some(Seen { stretch, turn, off: near + asin(side / out) })
    }

    /// Whether all points of the edge, which lie on a ball, stay off the tile. `way`: from the ball's centre to the
    /// tile's middle.
    fn is_off_ball(&self, stint: &Stint, way: DVec3, slack: f64) -> bool {
        let Some(radius) = self.sweep.ball else { return false };
        let is_ball = self.sweep.teeth.profile()[stint.stretch.last].z <= 0.0;
        is_ball && self.local.distance(way) > radius + slack
    }

    /// The tool frame at a step's start, its teeth turned.
    fn frame(&self, stint: &Stint, step: u32) -> Frame {
        let angle = self.sweep.spindle.angle(stint.time(step));
        Frame::new(stint.pose(step), angle, &self.local)
    }

    /// The quadrilaterals that a stretch of a tooth's edge sweeps.
    fn elements(&mut self, stint: &Stint, tooth: usize, stretch: Stretch, frames: [&Frame; 2]) {
        let (teeth, skips) = (self.sweep.teeth, self.sweep.search == Search::Near);
        let mapped = |frame: usize, k: usize| frames[frame].map(teeth.point(tooth, k));
        let mut k = stretch.first;
        // Point `k` before and, where it is known, after the step.
        let (mut a, mut d) = (mapped(0, k), None);
        while k < stretch.last {
            let free = (self.local.outside(a) - stint.step_way) / teeth.spacing();
            if skips && free >= 1.0 {
                k = stretch.last.min(k.saturating_add(free as usize));
                (a, d) = (mapped(0, k), None);
                continue;
            }
            let (b, c) = (mapped(0, k + 1), mapped(1, k + 1));
            self.swept.work.quads += 1;
            let [columns, rows] = self.local.box_of([a, b, c, d.unwrap_or_else(|| mapped(1, k))]);
            if !columns.is_empty() && !rows.is_empty() {
                let [a, b] = [k, k + 1].map(|k| frames[0].place(teeth.point(tooth, k)));
                let [d, c] = [k, k + 1].map(|k| frames[1].place(teeth.point(tooth, k)));
                for j in rows {
                    columns.clone().for_each(|i| self.test([i, j], [a, b, c, d]));
                }
            }
            (k, a, d) = (k + 1, b, Some(c));
        }
    }

    /// Lowers a node to a quadrilateral that its line meets.
    fn test(&mut self, [i, j]: [usize; 2], corners: [DVec3; 4]) {
        let node = self.sweep.grid.node(self.tile.columns.start + i, self.tile.rows.start + j);
        let place = node.place - self.local.middle;
        self.swept.work.tests += 1;
        let Some(height) = met(node.normal, corners.map(|c| c - place)) else { return };
        let held = &mut self.swept.heights[j * self.tile.columns.len() + i];
        if height < *held && height >= -self.sweep.floor {
            *held = height;
            self.is_lower = true;
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
