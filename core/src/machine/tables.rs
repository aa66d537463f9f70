//! The tables on their way along a path: legs between rotary positions, and the time that they take.

use super::limits::Machine;
use super::xyzac::Rotary;
use crate::geometry::{DVec3, math};

/// Part of the tolerance by which an axis near the C axis may be off, at the cutter's rim. Larger: fewer turns of
/// C; with what interpolation may err it stays below the tolerance.
const OFF_POLE: f64 = 0.25;
/// The same as an angle at most, rad.
const WIDEST_POLE: f64 = 0.01;
/// Halvings of one move between rotary positions: past the pole C turns in a small part of it.
const DEEPEST: u32 = 20;
/// Most legs of a turn of C in place.
const MOST_LEGS: f64 = 1e4;

/// Tip, mm, and unit axis of the cutter in the workpiece.
pub(crate) type Place = (DVec3, DVec3);

/// A part of a move in which all five axes run straight.
#[derive(Copy, Clone, Debug)]
pub(crate) struct Leg {
    /// Where the tables stand at its end.
    pub rotary: Rotary,
    /// The tip at its end, machine coordinates, mm.
    pub to: DVec3,
    /// s.
    pub time: f64,
}

/// The tables of a machine, where they stand and what they can do.
#[derive(Copy, Clone, Debug)]
pub(crate) struct Tables {
    /// Where they stand.
    pub at: Rotary,
    tolerance: f64,
    /// Of the cutter, mm.
    radius: f64,
    max_feed: f64,
    max_rotary_speed: f64,
    /// Decimals of a degree to which positions are rounded.
    decimals: Option<u32>,
    /// Whether the controller keeps the tip on its line while the tables turn.
    keeps_tip: bool,
}

impl Tables {
    /// Tables at their zero, for a cutter of that radius, mm, whose tip and rim may leave their places by less than
    /// `tolerance`, mm.
    pub fn new(machine: &Machine, tolerance: f64, radius: f64) -> Self {
        let Machine { max_feed, max_rotary_speed, .. } = *machine;
        let (at, decimals, keeps_tip) = (Rotary::default(), None, false);
        Self { at, tolerance, radius, max_feed, max_rotary_speed, decimals, keeps_tip }
    }

    /// The controller keeps the tip on its straight line while the tables turn: tool centre control.
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
        self.time_of(from, self.at)
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
            let target = next.to_machine(to.0);
            // Tables that turn fast carry the tip around its straight way, and the axes along.
            let tip = from.0.distance(to.0) + 4.0 * error;
            let axes = target.distance(self.at.to_machine(from.0));
            let least = (tip.max(axes) / self.max_feed).max(self.time_of(self.at, next));
            self.at = next;
            legs.push(Leg { rotary: next, to: target, time: time.max(least) });
            return Ok(());
        }
        if self.at.is_at_pole() && next.c != self.at.c {
            self.turn_in_place(from.0, next.c, legs);
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

    /// Turns C where A leaves the tool axis alone, about a tip that stays where it is.
    fn turn_in_place(&mut self, tip: DVec3, c: f64, legs: &mut Vec<Leg>) {
        let from = self.at;
        // The chord of a turn by `t` at distance `r` from the C axis lies `r t²/8` inside of it.
        let sagitta = math::hypot(tip.x, tip.y) * (c - from.c) * (c - from.c) / 8.0;
        let count = (sagitta / (0.5 * self.tolerance)).sqrt().ceil().clamp(1.0, MOST_LEGS);
        for i in 1..=count as u32 {
            let before = self.at;
            self.at = self.written(from.lerp(Rotary { c, ..from }, f64::from(i) / count));
            let to = self.at.to_machine(tip);
            let along = to.distance(before.to_machine(tip)) / self.max_feed;
            let time = along.max(self.time_of(before, self.at));
            legs.push(Leg { rotary: self.at, to, time });
        }
    }

    fn toward(&self, axis: DVec3) -> Rotary {
        let pole = (OFF_POLE * self.tolerance / self.radius).min(WIDEST_POLE);
        self.written(self.at.toward(axis, pole))
    }

    fn written(&self, rotary: Rotary) -> Rotary {
        self.decimals.map_or(rotary, |decimals| rotary.rounded(decimals))
    }

    /// Least time from one position to another, s.
    fn time_of(&self, from: Rotary, to: Rotary) -> f64 {
        from.turn_to(to) / self.max_rotary_speed
    }

    /// How far a move in which all five axes run straight leaves the straight line of the tip, or the cutter's
    /// rim through the turn of the axis, at its quarters; mm.
    fn interpolation_error(&self, b: Rotary, from: Place, to: Place) -> f64 {
        let a = self.at;
        let (start, end) = (a.to_machine(from.0), b.to_machine(to.0));
        if a == b {
            return 0.0;
        }
        [0.25, 0.5, 0.75].into_iter().fold(0.0, |worst: f64, u| {
            let rotary = a.lerp(b, u);
            let tip = match self.keeps_tip {
                true => 0.0,
                false => rotary.to_part(start.lerp(end, u)).distance(from.0.lerp(to.0, u)),
            };
            let wanted = from.1.lerp(to.1, u).try_normalize().unwrap_or(to.1);
            worst.max(tip).max(self.radius * rotary.axis().distance(wanted))
        })
    }

    /// Turns to a unit axis while the linear axes of the machine run straight, and gives the tips on the way, each with
    /// the position of the tables: so many that straight lines between them stay within half the tolerance.
    pub fn turn_straight(&mut self, from: DVec3, to: Place) -> Vec<(DVec3, Rotary)> {
        let start = self.at;
        self.turn(to.1);
        let end = self.at;
        let (a, b) = (start.to_machine(from), end.to_machine(to.0));
        // A chord of a turn by `t` at distance `r` from the centre lies `r t²/8` inside of it, and a share of the
        // linear way `l` that is turned by `t` bends by at most `l t/4`.
        let turn = start.turn_to(end);
        let reach = from.length().max(to.0.length());
        let sagitta = reach * turn * turn / 4.0 + a.distance(b) * turn / 4.0;
        let count = (sagitta / (0.5 * self.tolerance)).sqrt().ceil().clamp(1.0, MOST_LEGS);
        let place = |i: u32| {
            let u = f64::from(i) / count;
            if i == count as u32 {
                return (to.0, end);
            }
            let rotary = self.written(start.lerp(end, u));
            (rotary.to_part(a.lerp(b, u)), rotary)
        };
        (1..=count as u32).map(place).collect()
    }
}
