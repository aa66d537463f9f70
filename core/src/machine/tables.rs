//! The rotary axes on their way along a path: legs between their positions, and the time that they take.

use super::chain::{Angles, Chain, between, rounded};
use super::limits::Machine;
use crate::geometry::DVec3;
use core::f64::consts::TAU;

/// Part of the tolerance by which a tool axis near the first rotary axis may be off, at the cutter's rim. Larger: fewer turns of
/// that; with what interpolation may err it stays below the tolerance.
const OFF_POLE: f64 = 0.25;
/// The same as an angle at most, rad.
const WIDEST_POLE: f64 = 0.01;
/// Halvings of one move between rotary positions: past the pole the first axis turns in a small part of it.
const DEEPEST: u32 = 20;
/// Most legs of a turn in place.
const MOST_LEGS: f64 = 1e4;

/// Tip, mm, and unit axis of the cutter in the workpiece.
pub type Place = (DVec3, DVec3);

/// A part of a move in which all axes run straight.
#[derive(Copy, Clone, Debug)]
pub struct Leg {
    /// Where the rotary axes stand at its end.
    pub rotary: Angles,
    /// Where the linear axes stand at its end, mm.
    pub to: DVec3,
    /// s.
    pub time: f64,
}

/// The rotary axes of a machine, where they stand and what they can do.
#[derive(Copy, Clone, Debug)]
pub struct Tables {
    /// Where they stand.
    pub at: Angles,
    /// How they are arranged.
    pub chain: Chain,
    /// Turn of the first axis by whole windings with its next turn, rad.
    unwinding: f64,
    tolerance: f64,
    /// Of the cutter, mm.
    radius: f64,
    max_feed: f64,
    /// Decimals of a degree to which positions are rounded.
    decimals: Option<u32>,
    /// Whether the controller keeps the tip on its line while the rotary axes turn.
    keeps_tip: bool,
}

impl Tables {
    /// Those of a machine that has any, at their zero, for a cutter of that radius, mm, whose tip and rim may leave their
    /// places by less than `tolerance`, mm.
    pub fn of(machine: &Machine, tolerance: f64, radius: f64) -> Option<Self> {
        let (chain, max_feed) = (*machine.axes.chain()?, machine.max_feed);
        let (at, unwinding, decimals, keeps_tip) = ([0.0; 2], 0.0, None, false);
        Some(Self { at, chain, unwinding, tolerance, radius, max_feed, decimals, keeps_tip })
    }

    /// The controller keeps the tip on its straight line while the axes turn: tool centre control.
    pub fn keeping_tip(self, keeps_tip: bool) -> Self {
        Self { keeps_tip, ..self }
    }

    /// Positions are rounded to so many decimals of a degree.
    pub fn rounded(self, decimals: u32) -> Self {
        Self { decimals: Some(decimals), ..self }
    }

    /// Turns to a unit axis, and gives the least time for it, s.
    pub fn turn(&mut self, axis: DVec3) -> f64 {
        let from = self.at;
        self.at = self.toward(axis);
        self.chain.time(from, self.at)
    }

    /// Prepares the next turn for a stretch that is then gone without one between: the first axis is wound back, or on, by
    /// whole turns, as few as keep it within its range on all of the stretch. Where none do it stays.
    pub fn unwind(&mut self, stretch: impl Iterator<Item = DVec3>) {
        self.unwinding = 0.0;
        let (low, high) = self.chain.axes()[0].range;
        if low == f64::NEG_INFINITY && high == f64::INFINITY {
            return;
        }
        let mut ahead = *self;
        let mut reach = (f64::INFINITY, f64::NEG_INFINITY);
        for axis in stretch {
            ahead.turn(axis);
            reach = (reach.0.min(ahead.at[0]), reach.1.max(ahead.at[0]));
        }
        // The fewest turns that bring the end that is out of range back into it.
        let turns = if reach.1 > high {
            -((reach.1 - high) / TAU).ceil()
        } else {
            ((low - reach.0) / TAU).ceil().max(0.0)
        };
        let back = turns * TAU;
        if reach.0 + back >= low && reach.1 + back <= high {
            self.unwinding = back;
        }
    }

    /// Adds the legs of a move of `time` s: halved until each stays, as the controller interpolates all five axes,
    /// within half the tolerance of the straight tip line and of the turning axis.
    ///
    /// # Errors
    /// The tip near which no leg is short enough.
    pub fn go(
        &mut self,
        from: Place,
        to: Place,
        time: f64,
        legs: &mut Vec<Leg>,
    ) -> Result<(), DVec3> {
        self.halved(from, to, (time, DEEPEST), legs)
    }

    fn halved(
        &mut self,
        from: Place,
        to: Place,
        (time, depth): (f64, u32),
        legs: &mut Vec<Leg>,
    ) -> Result<(), DVec3> {
        let next = self.toward(to.1);
        let error = self.interpolation_error(next, from, to);
        if error <= 0.5 * self.tolerance {
            let target = self.chain.to_machine(to.0, next);
            // Tables that turn fast carry the tip around its straight way, and the axes along.
            let tip = from.0.distance(to.0) + 4.0 * error;
            let axes = target.distance(self.chain.to_machine(from.0, self.at));
            let least = (tip.max(axes) / self.max_feed).max(self.chain.time(self.at, next));
            self.at = next;
            legs.push(Leg { rotary: next, to: target, time: time.max(least) });
            return Ok(());
        }
        if self.chain.is_at_pole(self.at) && next[0] != self.at[0] {
            self.turn_in_place(from.0, next[0], legs);
            return self.halved(from, to, (time, depth), legs);
        }
        if depth == 0 {
            return Err(from.0);
        }
        let axis = (from.1 + to.1).try_normalize().unwrap_or(to.1);
        let middle = (0.5 * (from.0 + to.0), axis);
        self.halved(from, middle, (0.5 * time, depth - 1), legs)?;
        self.halved(middle, to, (0.5 * time, depth - 1), legs)
    }

    /// Turns the first axis where the tool stands along it, about a tip that stays where it is.
    fn turn_in_place(&mut self, tip: DVec3, first: f64, legs: &mut Vec<Leg>) {
        let from = self.at;
        // The chord of a turn by `t` at distance `r` from its centre lies `r t²/8` inside of it.
        let turn = first - from[0];
        let sagitta = self.chain.reach(tip.length()) * turn * turn / 8.0;
        let count = (sagitta / (0.5 * self.tolerance)).sqrt().ceil().clamp(1.0, MOST_LEGS);
        for i in 1..=count as u32 {
            let before = self.at;
            self.at = self.written(between(from, [first, from[1]], f64::from(i) / count));
            let to = self.chain.to_machine(tip, self.at);
            let along = to.distance(self.chain.to_machine(tip, before)) / self.max_feed;
            let time = along.max(self.chain.time(before, self.at));
            legs.push(Leg { rotary: self.at, to, time });
        }
    }

    fn toward(&mut self, axis: DVec3) -> Angles {
        let pole = (OFF_POLE * self.tolerance / self.radius).min(WIDEST_POLE);
        let near = [self.at[0] + core::mem::take(&mut self.unwinding), self.at[1]];
        self.written(self.chain.toward(near, axis, pole))
    }

    fn written(&self, rotary: Angles) -> Angles {
        self.decimals.map_or(rotary, |decimals| rounded(rotary, decimals))
    }

    /// How far a move in which all five axes run straight leaves the straight line of the tip, or the cutter's
    /// rim through the turn of the axis, at its quarters; mm.
    fn interpolation_error(&self, b: Angles, from: Place, to: Place) -> f64 {
        let (a, chain) = (self.at, &self.chain);
        let (start, end) = (chain.to_machine(from.0, a), chain.to_machine(to.0, b));
        if a == b {
            return 0.0;
        }
        [0.25, 0.5, 0.75].into_iter().fold(0.0, |worst: f64, u| {
            let rotary = between(a, b, u);
            let tip = match self.keeps_tip {
                true => 0.0,
                false => chain.to_part(start.lerp(end, u), rotary).distance(from.0.lerp(to.0, u)),
            };
            let wanted = from.1.lerp(to.1, u).try_normalize().unwrap_or(to.1);
            worst.max(tip).max(self.radius * chain.axis(rotary).distance(wanted))
        })
    }

    /// Turns to a unit axis while the tip runs straight in the frame of the tool, so that its height along the tool axis
    /// never falls below those at both ends; about program zero that is how tables and linear axes run that start and stop
    /// together. Gives the places on the way, with the positions of the rotary axes: so many that straight lines of the
    /// tip between them stay within half the tolerance, or, where the linear axes run straight, one where they suffice.
    pub fn turn_straight(&mut self, from: DVec3, to: Place) -> Vec<(DVec3, Angles)> {
        let start = self.at;
        self.turn(to.1);
        let (end, chain) = (self.at, self.chain);
        if !self.keeps_tip && chain.is_centred() {
            return vec![(to.0, end)];
        }
        let (a, b) = (chain.in_tool_frame(from, start), chain.in_tool_frame(to.0, end));
        // A chord of a turn by `t` at distance `r` from the centre lies `r t²/8` inside of it, and a share of the
        // linear way `l` that is turned by `t` bends by at most `l t/4`.
        let turn = chain.turn(start, end);
        let reach = chain.reach(from.length().max(to.0.length()));
        let sagitta = reach * turn * turn / 4.0 + a.distance(b) * turn / 4.0;
        let count = (sagitta / (0.5 * self.tolerance)).sqrt().ceil().clamp(1.0, MOST_LEGS);
        let place = |i: u32| {
            let u = f64::from(i) / count;
            if i == count as u32 {
                return (to.0, end);
            }
            let rotary = self.written(between(start, end, u));
            (chain.of_tool_frame(a.lerp(b, u), rotary), rotary)
        };
        (1..=count as u32).map(place).collect()
    }
}
