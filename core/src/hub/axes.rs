//! Tool axes between the blades.
//!
//! - *Stand*: a place of the hub on which the cutter stands. The middle of its ball stays where it is when the axis
//!   turns, so the axis decides about what is above that middle alone; the cutting end is not asked here.
//! - *Lean*: angle between axis and surface normal.
//! - *Slab*: a piece of the assembly between two heights. Its *lever* is how high it is above the middle of the ball:
//!   when the axis turns by an angle, the slab moves by lever times angle.
//! - *Worth* of an axis: by how much it may turn, whatever the direction, until some slab comes nearer to the triangles
//!   than is wanted: the least of (distance - wanted) / lever, rad. The axis of greatest worth stands in the middle of
//!   the cone of axes that are allowed, however long the tool is. Slabs beside the ball hardly move and count only if
//!   they are too near. Of an axis that is not allowed it is how much nearer than wanted the tool is, in radii of the
//!   slab, negative.
//! - *Score*: the worth, less for a lean; so little less that it stays in the middle between two blades, but enough that
//!   it does not lean out of the channel's end, where there is always more room.
//! - *Field*: an axis per node of a grid of stands, and smooth ones in between.
//!
//! In steps:
//!
//! 1. At the middle node axes all over the cone around the normal are tried, the best is made better by steps that halve.
//!    One that cannot beat the best so far is left as soon as the first triangle shows it.
//! 2. From there the other nodes follow, ring by ring: each begins with the axes of the neighbours it has and makes the
//!    best of them better. So the field stays within one part of the allowed cones where they have several. Where that
//!    gives no allowed axis, step 1.
//! 3. Nodes without an axis are searched closer; if one stays without, planning ends with its place and what touches.
//! 4. Axes move toward the mean of their neighbours, as long as they keep a share of their worth: the smoothest field
//!    within the cones. Where the whole move is too far, a part of it or one of its two components is taken.
//! 5. Between nodes, the axes are those of a bicubic spline through them (Catmull-Rom), made unit vectors.
//!
//! All nodes of a ring or a round see what was there before it, so the order and the number of threads do not matter.
//!
//! # Source
//! The bisector of two blades as in spec 07; the spline: Catmull, Rom, "A class of local interpolating splines", 1974.

use super::error::HubError;
use crate::cutter_location::{Clearance, Hindrance, Pose, Solid, above_end, clearance_above_end};
use crate::geometry::math::{acos_clamped, cos, sin};
use crate::geometry::{DVec3, any_perpendicular};
use crate::parallel;
use crate::tool::{Assembly, AssemblyPart, Section};
use std::f64::consts::{FRAC_PI_2, TAU};

/// Angle between the axes that are tried at first, rad: narrower allowed cones may be missed, halving it takes four
/// times as long.
const COARSE: f64 = 10.0 / 180.0 * std::f64::consts::PI;
/// The same where none was found.
const FINE: f64 = 2.5 / 180.0 * std::f64::consts::PI;
/// Angle at which the steps that halve end, rad; the worth is within about as much of the greatest.
const LAST_STEP: f64 = 0.25 / 180.0 * std::f64::consts::PI;
/// First step from a neighbour's axis, rad.
const NEXT: f64 = 4.0 / 180.0 * std::f64::consts::PI;
/// Most steps of one length. They mostly end by themselves.
const MOST_STEPS: usize = 16;
/// Directions of a step.
const WAYS: u32 = 8;
/// Worth that needs no more, rad: room of 14 degrees on all sides. With more, axes would rather lean for more room; with
/// less, wide channels get axes beside the middle.
const AMPLE: f64 = 0.25;
/// What a lean takes from the score, rad at 90 degrees. Toward a blade the worth falls by an angle as the axis turns by it;
/// what this adds is less, so the middle between two blades stays the best. An axis that leans by 50 degrees is not taken
/// if the normal is allowed.
const UPRIGHT: f64 = 0.7;
/// By how much every allowed axis is better than those that are not.
const ALLOWED: f64 = 1e6;
/// Share of its worth that a node keeps for clearance when the field is made smooth. 1 would keep all noise of the
/// search, 0 leave nothing for the places between nodes.
const KEPT: f64 = 0.5;
/// Moves toward the mean that are not worth a test, rad.
const STILL: f64 = 1e-4;
/// Rounds of making smooth: waves shorter than some ten nodes go.
const ROUNDS: usize = 48;
/// Distances are not better known than this, mm.
const EXACT: f64 = 1e-6;
/// Worths that differ by less are the same, rad.
const SAME: f64 = 1e-9;
/// Slabs double in height; so many reach farther than any tool.
const MOST_SLABS: i32 = 24;
/// How much thinner a shank could be, in what it comes too near: tried for the message.
const THINNER: [f64; 4] = [1.0, 1.5, 2.0, 3.0];
/// How much farther a tool could stick out, mm: tried for the message where the holder touches.
const LONGER: [f64; 6] = [5.0, 10.0, 20.0, 30.0, 50.0, 80.0];

/// One place of a channel at which the cutter stands.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Stand {
    /// Where the cutter touches, mm.
    pub contact: DVec3,
    /// Unit normal there, toward the tool.
    pub normal: DVec3,
    /// Unit direction of the pass.
    pub along: DVec3,
}

/// What is asked of the axes.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct AxisOptions {
    /// Distance wanted between triangles and all above the middle of the ball, mm, at least 0.
    pub clearance: f64,
    /// How far the ball stays off the contact, mm.
    pub allowance: f64,
    /// Largest angle between axis and normal, rad, up to a right angle.
    pub steepest: f64,
    /// Threads to use; the result does not depend on it.
    pub threads: usize,
}

/// Tool axes at the nodes of a grid over a channel, and smooth ones in between.
#[derive(Clone, Debug, PartialEq)]
pub struct AxisField {
    rows: usize,
    columns: usize,
    axes: Vec<DVec3>,
    clearances: Vec<f64>,
}

impl AxisField {
    /// Axes for the stands of a grid: `rows` stations along the channel, `columns` across, row by row.
    ///
    /// The tip at a node is `contact + (r + allowance) n - r a`. At every node, all above the middle of the ball keeps
    /// `options.clearance` of the hindrance (to 1e-6 mm), and the axis leans by `options.steepest` at most.
    ///
    /// Of a hub in the hindrance, a leaning cutter's side is only `r (1 - sin lean)` clear, beside the ball; where that is
    /// less than the clearance wanted, such axes are not taken.
    ///
    /// # Errors
    /// [`HubError::NoAxis`] where a node has no such axis; [`HubError::AxisGrid`], [`HubError::AxisStand`],
    /// [`HubError::AxisOption`] for stands and options that are none.
    pub fn new(
        stands: &[Stand],
        rows: usize,
        columns: usize,
        hindrance: &Hindrance,
        assembly: &Assembly,
        options: &AxisOptions,
    ) -> Result<Self, HubError> {
        check(options)?;
        if rows.checked_mul(columns) != Some(stands.len()) || stands.is_empty() {
            return Err(HubError::AxisGrid { stands: stands.len(), rows, columns });
        }
        let seat = |(i, stand): (usize, &Stand)| {
            let fault = HubError::AxisStand { row: i / columns, column: i % columns };
            Seat::new(stand).ok_or(fault)
        };
        let seats = stands.iter().enumerate().map(seat).collect::<Result<Vec<_>, _>>()?;
        let grid = Grid { rows, columns, seats };
        let judge = Judge::new(hindrance, assembly, options);
        let best = grid.best_axes(&judge, assembly, options)?;
        let axes = grid.smooth(&judge, best, options.threads);
        let nodes: Vec<usize> = (0..axes.len()).collect();
        let clearances = parallel::map(options.threads, &nodes, |&i| {
            judge.measure(&grid.seats[i], axes[i], assembly).distance
        });
        Ok(Self { rows, columns, axes, clearances })
    }

    /// Rows and columns of the grid.
    pub fn size(&self) -> (usize, usize) {
        (self.rows, self.columns)
    }

    /// The axes at the nodes, unit vectors, row by row.
    pub fn axes(&self) -> &[DVec3] {
        &self.axes
    }

    /// Distance of all above the middle of the ball from the hindrance, mm, measured at the nodes with the axes as they
    /// are; infinite where there is nothing.
    pub fn clearances(&self) -> &[f64] {
        &self.clearances
    }

    /// Unit axis at a place of the grid: `row` from 0 to rows - 1, `column` from 0 to columns - 1; beyond them as at
    /// the border.
    ///
    /// Goes through the axes of the nodes, and turns without a jump, as its first derivative does.
    pub fn axis(&self, row: f64, column: f64) -> DVec3 {
        let (i, s) = place_in(row, self.rows);
        let (j, t) = place_in(column, self.columns);
        let in_row = |i: usize| cubic(self.columns, j, t, |j| self.node(i, j));
        let sum = cubic(self.rows, i, s, in_row);
        sum.try_normalize().unwrap_or_else(|| self.node(i, j))
    }

    /// Greatest angle between the axes of two neighbouring nodes, rad. Where it is large, what the nodes keep clear of
    /// need not be clear in between.
    pub fn largest_turn(&self) -> f64 {
        let turn = |i: usize, j: usize| acos_clamped(self.axes[i].dot(self.axes[j]));
        let turns = (0..self.axes.len()).map(|i| {
            let right = if (i + 1) % self.columns > 0 { turn(i, i + 1) } else { 0.0 };
            let down = i + self.columns;
            right.max(if down < self.axes.len() { turn(i, down) } else { 0.0 })
        });
        turns.fold(0.0, f64::max)
    }

    fn node(&self, row: usize, column: usize) -> DVec3 {
        self.axes[row * self.columns + column]
    }
}

/// The node before a place and how far it is from there to the next; `count` nodes.
fn place_in(place: f64, count: usize) -> (usize, f64) {
    let last = count.saturating_sub(1);
    // What is no number is at the beginning.
    let place = place.max(0.0).min(last as f64);
    let i = (place.floor() as usize).min(last.saturating_sub(1));
    (i, place - i as f64)
}

/// Catmull-Rom spline between nodes i and i + 1; past the ends the nodes go on in a straight line.
fn cubic(count: usize, i: usize, t: f64, node: impl Fn(usize) -> DVec3) -> DVec3 {
    if count < 2 {
        return node(i);
    }
    let (b, c) = (node(i), node(i + 1));
    let a = if i > 0 { node(i - 1) } else { 2.0 * b - c };
    let d = if i + 2 < count { node(i + 2) } else { 2.0 * c - b };
    let (t2, t3) = (t * t, t * t * t);
    0.5 * ((2.0 * b)
        + t * (c - a)
        + t2 * (2.0 * a - 5.0 * b + 4.0 * c - d)
        + t3 * (3.0 * (b - c) + d - a))
}

fn check(options: &AxisOptions) -> Result<(), HubError> {
    let AxisOptions { clearance, allowance, steepest, .. } = *options;
    let fault = |name, value, rule| Err(HubError::AxisOption { name, value, rule });
    if !(clearance.is_finite() && clearance >= 0.0) {
        return fault("clearance", clearance, "a number of mm, 0 or more");
    }
    if !allowance.is_finite() {
        return fault("allowance", allowance, "a number of mm");
    }
    if !(0.0..=FRAC_PI_2).contains(&steepest) {
        return fault("largest lean", steepest, "an angle in rad, from 0 to a right angle");
    }
    Ok(())
}

/// A stand with its frame.
struct Seat {
    contact: DVec3,
    normal: DVec3,
    /// Across the normal, along the pass.
    along: DVec3,
    across: DVec3,
}

impl Seat {
    fn new(stand: &Stand) -> Option<Self> {
        let normal = stand.normal.try_normalize()?;
        let flat = stand.along - stand.along.dot(normal) * normal;
        // A pass along the normal has no direction on the surface: any does.
        let along = flat.try_normalize().unwrap_or_else(|| any_perpendicular(normal));
        let seat = Self { contact: stand.contact, normal, along, across: normal.cross(along) };
        (seat.contact.is_finite() && seat.along.is_finite()).then_some(seat)
    }

    fn axis(&self, local: DVec3) -> DVec3 {
        local.x * self.along + local.y * self.across + local.z * self.normal
    }
}

/// A piece of the assembly.
struct Slab {
    solid: Solid,
    /// mm; `None` beside the ball.
    lever: Option<f64>,
    /// Its largest radius, at least that of the cutter, mm.
    radius: f64,
}

/// Tells what axes are worth.
struct Judge<'a> {
    hindrance: &'a Hindrance,
    slabs: Vec<Slab>,
    radius: f64,
    largest_radius: f64,
    allowance: f64,
    wanted: f64,
    /// Cosine of the largest lean.
    least_cosine: f64,
}

impl<'a> Judge<'a> {
    fn new(hindrance: &'a Hindrance, assembly: &Assembly, options: &AxisOptions) -> Self {
        let (radius, middle) = (assembly.tool.radius(), assembly.tool.corner_radius());
        let heights: Vec<f64> =
            (0..MOST_SLABS).map(|k| middle + radius * f64::from(1 << k)).collect();
        let pieces = above_end(assembly).into_iter().flat_map(|solid| solid.cut_at(&heights));
        let slab = |solid: Solid| {
            let [low, high] = solid.heights().map(|h| h - middle);
            let lever = (low.max(radius) * high.max(radius)).sqrt();
            let lever = (high > radius * (1.0 + SAME)).then_some(lever);
            Slab { solid, lever, radius: solid.largest_radius().max(radius) }
        };
        Self {
            hindrance,
            slabs: pieces.map(slab).collect(),
            radius,
            largest_radius: assembly.largest_radius(),
            allowance: options.allowance,
            wanted: options.clearance,
            least_cosine: cos(options.steepest),
        }
    }

    fn pose(&self, seat: &Seat, axis: DVec3) -> Pose {
        let middle = seat.contact + (self.radius + self.allowance) * seat.normal;
        Pose { tip: middle - self.radius * axis, axis }
    }

    fn measure(&self, seat: &Seat, axis: DVec3, assembly: &Assembly) -> Clearance {
        let Pose { tip, axis } = self.pose(seat, axis);
        clearance_above_end(self.hindrance, assembly, tip, axis, f64::INFINITY)
    }

    fn leans_too_much(&self, seat: &Seat, axis: DVec3) -> bool {
        axis.dot(seat.normal) < self.least_cosine - SAME
    }

    /// How far a slab must be for the axis to be worth so much.
    fn reach(&self, slab: &Slab, worth: f64) -> f64 {
        let lever = if worth > 0.0 { slab.lever.unwrap_or(0.0) } else { slab.radius };
        self.wanted + worth * lever
    }

    /// Worth of an axis, at most [`AMPLE`]; where that is not above `least`, anything not above it.
    fn worth(&self, seat: &Seat, axis: DVec3, least: f64) -> f64 {
        let pose = self.pose(seat, axis);
        let mut worth = AMPLE;
        for slab in &self.slabs {
            let (beyond, enough) = (self.reach(slab, worth), self.reach(slab, least));
            if let Some(near) = self.hindrance.nearest(&slab.solid, pose, beyond, enough) {
                let more = near.distance - self.wanted;
                let lever = slab.lever.filter(|_| more > 0.0).unwrap_or(slab.radius);
                worth = worth.min(more / lever);
                if worth <= least {
                    break;
                }
            }
        }
        worth
    }

    /// Whether the axis is allowed and worth at least so much.
    fn keeps(&self, seat: &Seat, axis: DVec3, worth: f64) -> bool {
        let pose = self.pose(seat, axis);
        let is_clear = |slab: &Slab| {
            let reach = self.reach(slab, worth) - SAME;
            self.hindrance.nearest(&slab.solid, pose, reach, reach).is_none()
        };
        !self.leans_too_much(seat, axis) && self.slabs.iter().all(is_clear)
    }

    fn is_refused(&self, best: &Candidate) -> bool {
        best.worth * self.largest_radius < -EXACT
    }

    /// Puts `axis` in place of the best so far, if it is better.
    fn try_axis(&self, seat: &Seat, axis: DVec3, best: &mut Candidate) -> bool {
        if self.leans_too_much(seat, axis) {
            return false;
        }
        let lean = UPRIGHT * (1.0 - axis.dot(seat.normal));
        let is_allowed = |worth: f64| worth >= -SAME;
        let least =
            if is_allowed(best.worth) { (best.score + lean).max(-SAME) } else { best.worth };
        if least >= AMPLE {
            return false;
        }
        let worth = self.worth(seat, axis, least);
        let score = if is_allowed(worth) { worth - lean } else { worth - ALLOWED };
        // Not for the last digits.
        let is_better = score > best.score + SAME;
        if is_better {
            *best = Candidate { axis, worth, score };
        }
        is_better
    }

    /// Step 1 at one node: `tried` are directions in its frame.
    fn search(&self, seat: &Seat, tried: &[DVec3], step: f64) -> Candidate {
        let mut best = Candidate::none(seat);
        for local in tried {
            self.try_axis(seat, seat.axis(*local), &mut best);
        }
        self.improve(seat, &mut best, 0.5 * step);
        best
    }

    /// Better axes by steps that halve.
    fn improve(&self, seat: &Seat, best: &mut Candidate, first: f64) {
        let ways: Vec<(f64, f64)> = (0..WAYS)
            .map(|k| TAU * f64::from(k) / f64::from(WAYS))
            .map(|angle| (cos(angle), sin(angle)))
            .collect();
        let mut step = first;
        while step >= LAST_STEP {
            for _ in 0..MOST_STEPS {
                let from = best.axis;
                let u = any_perpendicular(from);
                let v = from.cross(u);
                let axes = ways.iter().map(|(x, y)| (from + step * (*x * u + *y * v)).normalize());
                // One after the other, each from the same place: the best of them.
                let better = axes.filter(|axis| self.try_axis(seat, *axis, best)).count();
                if better == 0 {
                    break;
                }
            }
            step *= 0.5;
        }
    }
}

/// An axis with what it is worth.
#[derive(Copy, Clone, Debug, PartialEq)]
struct Candidate {
    axis: DVec3,
    worth: f64,
    /// Its worth, less for a lean.
    score: f64,
}

/// What would help where `part` comes too near by `missing` mm; `clears` tells whether another assembly has an axis there.
fn remedy(
    assembly: &Assembly,
    part: AssemblyPart,
    missing: f64,
    clears: impl Fn(&Assembly) -> bool,
) -> String {
    let thinner = |by: &f64| {
        let mut other = assembly.clone();
        for section in other.sections.iter_mut().filter(|s| s.part == part) {
            section.radii = section.radii.map(|r| (r - by).max(0.0));
        }
        other
    };
    let by = THINNER.map(|share| share * missing);
    let found = by.iter().find(|by| part != AssemblyPart::Cutter && clears(&thinner(by)));
    let thin = found.map(|by| format!("a {} {:.1} mm thinner clears here", part.name(), 2.0 * by));
    let found =
        LONGER.iter().find(|by| part == AssemblyPart::Holder && clears(&longer(assembly, **by)));
    let long = found.map(|by| format!("a tool that sticks out {by} mm farther clears here"));
    match (part, long, thin) {
        (_, Some(long), Some(thin)) => format!("{long}, or {thin}"),
        (_, Some(one), None) | (_, None, Some(one)) => one,
        (AssemblyPart::Cutter, ..) => {
            format!(
                "take a cutter at least {:.1} mm thinner, or less clearance",
                2.0 * missing.max(0.0)
            )
        }
        (AssemblyPart::Shank, ..) => "take a smaller cutter with a thinner shank".into(),
        (AssemblyPart::Holder, ..) => {
            "take a smaller cutter with a thinner and longer shank".into()
        }
    }
}

/// The same with the holder `by` mm higher.
fn longer(assembly: &Assembly, by: f64) -> Assembly {
    let mut other = assembly.clone();
    let is_holder = |s: &Section| s.part == AssemblyPart::Holder;
    let lower = other.sections.iter().filter(|s| is_holder(s)).map(|s| s.heights[0]);
    let begin = lower.fold(f64::INFINITY, f64::min);
    // What reaches up to the holder now, does so then.
    for section in &mut other.sections {
        let raised = section.heights.map(|h| if h >= begin { h + by } else { h });
        section.heights = raised;
    }
    if other.cutter_length >= begin {
        other.cutter_length += by;
    }
    other
}

impl Candidate {
    fn none(seat: &Seat) -> Self {
        Self { axis: seat.normal, worth: f64::NEG_INFINITY, score: f64::NEG_INFINITY }
    }
}

/// Directions all over a cone about z, about `step` apart, the middle first.
fn cone(steepest: f64, step: f64) -> Vec<DVec3> {
    let rings = (steepest / step).ceil().max(1.0) as u32;
    let ring = |k: u32| {
        let lean = steepest * f64::from(k) / f64::from(rings);
        let count = (TAU * sin(lean) / step).ceil().max(1.0) as u32;
        (0..count).map(move |j| {
            // Every other ring is turned by half a step.
            let turn = TAU * (f64::from(j) + 0.5 * f64::from(k % 2)) / f64::from(count);
            DVec3::new(sin(lean) * cos(turn), sin(lean) * sin(turn), cos(lean))
        })
    };
    (0..=rings).flat_map(ring).collect()
}

/// The stands of a channel.
struct Grid {
    rows: usize,
    columns: usize,
    seats: Vec<Seat>,
}

impl Grid {
    fn neighbours(&self, node: usize) -> impl Iterator<Item = usize> {
        let (row, column) = (node / self.columns, node % self.columns);
        [
            (row > 0).then(|| node - self.columns),
            (row + 1 < self.rows).then_some(node + self.columns),
            (column > 0).then(|| node - 1),
            (column + 1 < self.columns).then_some(node + 1),
        ]
        .into_iter()
        .flatten()
    }

    /// The nodes by how many steps of the grid they are from its middle.
    fn rings(&self) -> Vec<Vec<usize>> {
        let (row, column) = (self.rows / 2, self.columns / 2);
        let mut rings = vec![Vec::new(); self.rows + self.columns];
        for node in 0..self.seats.len() {
            let (i, j) = (node / self.columns, node % self.columns);
            rings[i.abs_diff(row) + j.abs_diff(column)].push(node);
        }
        rings
    }

    /// Steps 1 to 3.
    fn best_axes(
        &self,
        judge: &Judge<'_>,
        assembly: &Assembly,
        options: &AxisOptions,
    ) -> Result<Vec<Candidate>, HubError> {
        let (coarse, fine) = (cone(options.steepest, COARSE), cone(options.steepest, FINE));
        let mut best: Vec<Candidate> = self.seats.iter().map(Candidate::none).collect();
        for ring in self.rings() {
            let found = parallel::map(options.threads, &ring, |&i| {
                let seat = &self.seats[i];
                let mut own = Candidate::none(seat);
                for j in self.neighbours(i).filter(|j| best[*j].worth > f64::NEG_INFINITY) {
                    judge.try_axis(seat, best[j].axis, &mut own);
                }
                judge.improve(seat, &mut own, NEXT);
                for (tried, step) in [(&coarse, COARSE), (&fine, FINE)] {
                    if judge.is_refused(&own) {
                        let other = judge.search(seat, tried, step);
                        own = if other.score > own.score { other } else { own };
                    }
                }
                own
            });
            for (i, candidate) in ring.into_iter().zip(found) {
                best[i] = candidate;
            }
        }
        let nodes = 0..self.seats.len();
        let refused: Vec<usize> = nodes.filter(|&i| judge.is_refused(&best[i])).collect();
        let worst = refused.iter().min_by(|i, j| best[**i].worth.total_cmp(&best[**j].worth));
        match worst {
            None => Ok(best),
            Some(&i) => {
                Err(self.no_axis((judge, assembly), options, (i, best[i].axis), refused.len()))
            }
        }
    }

    /// What is wrong at a node.
    fn no_axis(
        &self,
        (judge, assembly): (&Judge<'_>, &Assembly),
        options: &AxisOptions,
        (node, axis): (usize, DVec3),
        refused: usize,
    ) -> HubError {
        let seat = &self.seats[node];
        let found = judge.measure(seat, axis, assembly);
        let missing = judge.wanted - found.distance;
        let fine = cone(options.steepest, FINE);
        let clears = |other: &Assembly| {
            let judge = Judge::new(judge.hindrance, other, options);
            !judge.is_refused(&judge.search(seat, &fine, FINE))
        };
        HubError::NoAxis {
            at: seat.contact,
            row: node / self.columns,
            column: node % self.columns,
            refused,
            nodes: self.seats.len(),
            clearance: found.distance,
            wanted: judge.wanted,
            part: found.part,
            touches: found.place,
            remedy: remedy(assembly, found.part, missing, clears),
        }
    }

    /// Step 4.
    fn smooth(&self, judge: &Judge<'_>, best: Vec<Candidate>, threads: usize) -> Vec<DVec3> {
        let nodes: Vec<usize> = (0..best.len()).collect();
        let mut axes: Vec<DVec3> = best.iter().map(|c| c.axis).collect();
        for _ in 0..ROUNDS {
            axes = parallel::map(threads, &nodes, |&i| {
                let least = best[i].worth * if best[i].worth > 0.0 { KEPT } else { 1.0 };
                self.toward_mean(judge, i, &axes, least)
            });
        }
        axes
    }

    fn toward_mean(&self, judge: &Judge<'_>, node: usize, axes: &[DVec3], least: f64) -> DVec3 {
        let (seat, own) = (&self.seats[node], axes[node]);
        let count = self.neighbours(node).count();
        if count == 0 {
            return own;
        }
        let mean = self.neighbours(node).map(|j| axes[j]).sum::<DVec3>() / count as f64;
        // Half the way: the whole would let neighbours change places for ever.
        let step = 0.5 * (mean - own);
        if step.length() < STILL {
            return own;
        }
        let along = step.dot(seat.along) * seat.along;
        let moves = [step, 0.5 * step, along, step - along, 0.25 * step];
        let axes = moves.iter().filter_map(|m| (own + *m).try_normalize());
        axes.into_iter().find(|axis| judge.keeps(seat, *axis, least)).unwrap_or(own)
    }
}

#[cfg(test)]
mod tests;
