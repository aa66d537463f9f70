//! Arcs: two ends and a centre, or two ends and a radius → a circle or a helix.

use super::error::Fault;
use evencut_core::geometry::math::{atan2, cos, hypot, sin};
use evencut_core::geometry::{DVec2, DVec3};
use std::f64::consts::TAU;

/// Ends nearer than this are one point: the arc is a full circle. mm.
///
/// Smaller: sums of increments do not close their circle; larger: short arcs become circles.
const SAME: f64 = 1e-6;

/// Largest radius, mm: beyond it rounding shows in the path.
const LARGEST: f64 = 1e7;

/// Plane of arcs: G17, G18, G19.
#[derive(Copy, Clone, Debug, PartialEq, Eq, Default)]
pub(super) enum Plane {
    #[default]
    Xy,
    Zx,
    Yz,
}

impl Plane {
    /// Indices of the first and the second axis, and of the one across; right-handed.
    pub fn axes(self) -> [usize; 3] {
        match self {
            Self::Xy => [0, 1, 2],
            Self::Zx => [2, 0, 1],
            Self::Yz => [1, 2, 0],
        }
    }
}

/// How the program tells the circle.
#[derive(Copy, Clone, Debug, PartialEq)]
pub(super) enum Circle {
    /// Its centre, in the plane.
    Centre(DVec2),
    /// Its radius; negative for the longer way round.
    Radius(f64),
}

/// Ends and sense of an arc in its plane.
#[derive(Copy, Clone, Debug)]
pub(super) struct Ends {
    pub from: DVec2,
    pub to: DVec2,
    pub counter_clockwise: bool,
    /// Times round, 1 for less than a full circle.
    pub turns: f64,
}

/// A circle, or a spiral where the radii at the ends differ.
#[derive(Copy, Clone, Debug, PartialEq)]
pub(super) struct Arc {
    pub plane: Plane,
    centre: DVec2,
    start_angle: f64,
    /// Counter-clockwise positive, rad.
    sweep: f64,
    radii: [f64; 2],
    /// By how much the ends do not fit, mm.
    pub mismatch: f64,
}

impl Arc {
    /// # Errors
    /// [`Fault::Arc`] where there is no such circle.
    pub fn new(plane: Plane, ends: &Ends, circle: Circle) -> Result<Self, Fault> {
        let (centre, excess) = match circle {
            Circle::Centre(centre) => (centre, 0.0),
            Circle::Radius(radius) => centre_of(ends, radius)?,
        };
        let (start, end) = (ends.from - centre, ends.to - centre);
        let radii = [start.length(), end.length()];
        if radii[0] < SAME || radii[1] < SAME {
            return Err(Fault::Arc("has radius 0: an end lies on its centre"));
        }
        // Also refuses what is not a number.
        if !radii.iter().all(|radius| (0.0..=LARGEST).contains(radius)) {
            return Err(Fault::Arc("has a radius above 10 km; write it as G1"));
        }
        let start_angle = atan2(start.y, start.x);
        let sweep = sweep(ends, start_angle, atan2(end.y, end.x));
        let mismatch = (radii[1] - radii[0]).abs().max(excess);
        Ok(Self { plane, centre, start_angle, sweep, radii, mismatch })
    }

    /// Its length in the plane, mm; of a spiral as if it gained its radius along a straight line.
    pub fn length(&self) -> f64 {
        let along = 0.5 * (self.radii[0] + self.radii[1]) * self.sweep;
        hypot(along, self.radii[1] - self.radii[0])
    }

    /// How many equal chords stay within `tolerance` mm.
    ///
    /// A chord lies within an eighth of the square of its step times the largest second derivative, here
    /// by the angle: the radius, and twice what a spiral gains per rad.
    pub fn chords(&self, tolerance: f64) -> f64 {
        let gain = (self.radii[1] - self.radii[0]).abs() / self.sweep.abs();
        let second = self.radii[0].max(self.radii[1]) + 2.0 * gain;
        // No fewer than three to a turn, however small it is.
        let step = (8.0 * tolerance / second).sqrt().min(TAU / 3.0);
        (self.sweep.abs() / step).ceil().max(1.0)
    }

    /// Moves a point of the straight line between the ends onto the arc, at its share `u`.
    pub fn bend(&self, mut straight: DVec3, u: f64) -> DVec3 {
        let angle = self.start_angle + self.sweep * u;
        let radius = self.radii[0] + (self.radii[1] - self.radii[0]) * u;
        let [i, j, _] = self.plane.axes();
        straight[i] = self.centre.x + radius * cos(angle);
        straight[j] = self.centre.y + radius * sin(angle);
        straight
    }
}

/// Centre of the arc of a radius, and by how much half the chord exceeds it.
fn centre_of(ends: &Ends, radius: f64) -> Result<(DVec2, f64), Fault> {
    let chord = ends.to - ends.from;
    let half = 0.5 * chord.length();
    if half < 0.5 * SAME {
        return Err(Fault::Arc("ends where it starts and R leaves its centre open; give I, J, K"));
    }
    if radius.abs() < SAME {
        return Err(Fault::Arc("has radius 0"));
    }
    let across = (radius * radius - half * half).max(0.0).sqrt();
    let left = chord.perp() / (2.0 * half);
    let side = if ends.counter_clockwise == (radius > 0.0) { across } else { -across };
    Ok((ends.from + 0.5 * chord + side * left, (half - radius.abs()).max(0.0)))
}

fn sweep(ends: &Ends, from: f64, to: f64) -> f64 {
    let turn = if ends.counter_clockwise { to - from } else { from - to };
    let part = if ends.from.distance(ends.to) < SAME || turn == 0.0 {
        TAU
    } else if turn < 0.0 {
        turn + TAU
    } else {
        turn
    };
    let all = part + TAU * (ends.turns - 1.0);
    if ends.counter_clockwise { all } else { -all }
}
