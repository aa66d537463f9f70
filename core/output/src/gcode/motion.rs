//! A move of all axes → the shares of it at which its chords end.

use super::arc::Arc;
use super::kinematics::{Kinematics, MachinePosition};
use evencut_core::geometry::{DVec3, math};

/// Height above the tip at which a chord must hold as well, so that the axis does: mm.
const ARM: f64 = 50.0;

/// Turn within which the way of the tip is smooth enough to be judged at its quarters, rad.
const SMOOTH: f64 = 0.1;

/// Halvings of a stretch; every one quarters the error, and coordinates and tolerance are bounded, so
/// that far fewer are needed.
const DEEPEST: u32 = 24;

/// Share of the tolerance that may be used up at the quarters: an error may peak between them.
const MARGIN: f64 = 0.9;

/// A move between two known positions.
#[derive(Copy, Clone, Debug)]
pub(super) struct Segment {
    pub from: MachinePosition,
    pub to: MachinePosition,
    pub arc: Option<Arc>,
    pub kinematics: Kinematics,
    pub way: Way,
}

/// What runs straight in a move.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub(super) enum Way {
    /// All axes of the machine.
    Machine,
    /// The tip in the workpiece and the rotary axes.
    Tip,
    /// The tip in the workpiece; the tool axis turns in a plane.
    TipAndAxis,
}

impl Segment {
    /// Where the axes are at the share `u` of the move.
    pub fn at(&self, u: f64) -> MachinePosition {
        if u == 1.0 {
            return self.to;
        }
        let mut place = self.from.lerp(&self.to, u);
        if self.way != Way::Machine {
            let [(from, a), (to, b)] = self.ends();
            if self.way == Way::TipAndAxis {
                let axis = a.lerp(b, u).try_normalize().unwrap_or(b);
                place.rotary = self.kinematics.rotary_toward(axis, place.rotary);
            }
            let straight = from.lerp(to, u);
            let tip = self.arc.as_ref().map_or(straight, |arc| arc.bend(straight, u));
            place.linear = self.kinematics.to_machine(tip, place.rotary);
            return place;
        }
        if let Some(arc) = &self.arc {
            place.linear = arc.bend(place.linear, u);
        }
        place
    }

    /// Tip and tool axis in the workpiece at both ends.
    fn ends(&self) -> [(DVec3, DVec3); 2] {
        [&self.from, &self.to].map(|at| self.kinematics.tip_and_axis(at))
    }

    /// What a feed per minute is that of: travel of the linear axes, or that of the tip in the workpiece, mm.
    pub fn length(&self) -> f64 {
        let way = match self.way {
            Way::Machine => self.to.linear - self.from.linear,
            Way::Tip | Way::TipAndAxis => {
                let [(from, _), (to, _)] = self.ends();
                to - from
            }
        };
        match &self.arc {
            None => way.length(),
            Some(arc) => {
                let across = way[arc.plane.axes()[2]];
                DVec3::new(arc.length(), across, 0.0).length()
            }
        }
    }

    /// Travel of the rotary axes, rad.
    pub fn turn(&self) -> f64 {
        let [a, c] = [0, 1].map(|i| self.to.rotary[i] - self.from.rotary[i]);
        (a * a + c * c).sqrt()
    }

    /// What a feed per minute is that of where nothing travels: the turn of the rotary axes, or of the tool axis, rad.
    pub fn turn_alone(&self) -> f64 {
        if self.way != Way::TipAndAxis {
            return self.turn();
        }
        let [(_, a), (_, b)] = self.ends();
        math::atan2(a.cross(b).length(), a.dot(b))
    }

    /// The shares, rising to 1, at which chords within `tolerance` mm end; `None` if more than
    /// `most` were needed.
    pub fn chords(&self, tolerance: f64, most: usize) -> Option<Vec<f64>> {
        let turn = self.turn();
        let pieces = self.arc.map_or(1.0, |arc| arc.chords(tolerance));
        let pieces = pieces.max((turn / SMOOTH).ceil());
        // Also false for what is not a number.
        let most_pieces = most.min(u32::MAX as usize) as f64;
        if !(1.0..=most_pieces).contains(&pieces) {
            return None;
        }
        let shares = (1..=pieces as u32).map(|i| f64::from(i) / pieces);
        if turn == 0.0 {
            return Some(shares.collect());
        }
        let mut split = Split { segment: self, tolerance, most, shares: Vec::new() };
        let mut from = 0.0;
        for to in shares {
            split.halve(from, to, DEEPEST)?;
            from = to;
        }
        Some(split.shares)
    }
}

struct Split<'a> {
    segment: &'a Segment,
    tolerance: f64,
    most: usize,
    shares: Vec<f64>,
}

impl Split<'_> {
    fn halve(&mut self, from: f64, to: f64, depth: u32) -> Option<()> {
        if depth > 0 && self.error(from, to) > MARGIN * self.tolerance {
            let middle = 0.5 * (from + to);
            self.halve(from, middle, depth - 1)?;
            return self.halve(middle, to, depth - 1);
        }
        self.shares.push(to);
        (self.shares.len() <= self.most).then_some(())
    }

    /// Largest distance at the quarters between the move and its chord, of the tip and of a point of the
    /// axis above it, mm.
    fn error(&self, from: f64, to: f64) -> f64 {
        let ends = [self.place(from), self.place(to)];
        [0.25, 0.5, 0.75].into_iter().fold(0.0, |worst: f64, u| {
            let place = self.place(from + (to - from) * u);
            let off = |i: usize| place[i].distance(ends[0][i].lerp(ends[1][i], u));
            worst.max(off(0)).max(off(1))
        })
    }

    /// Tip and a point of the axis in the workpiece.
    fn place(&self, u: f64) -> [DVec3; 2] {
        let (tip, axis) = self.segment.kinematics.tip_and_axis(&self.segment.at(u));
        [tip, tip + ARM * axis]
    }
}
