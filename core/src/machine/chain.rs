//! The rotary axes of a machine as a chain from the workpiece to the tool.
//!
//! Terms. A *table* carries the workpiece, a *head* the spindle. `u1`, `u2` are the directions of the axis nearer to the
//! workpiece and of that nearer to the tool, `θ1`, `θ2` their positions. A table that turns by `θ` turns the tool, seen from
//! the workpiece, by `-θ`; a head by `θ`. With these signs the tool axis in the workpiece is
//! `R(u1, ±θ1) R(u2, ±θ2) z`.
//!
//! The inverse is Paden and Kahan's second subproblem (Murray, Li and Sastry, "A Mathematical Introduction to Robotic
//! Manipulation", 1994, ch. 3.2): `θ2` from the component of the tool axis along `u1`, which `θ1` does not change, then `θ1`
//! from what is left across it. Two positions of `θ2` fit.

use crate::geometry::DVec3;
use crate::geometry::math::{acos_clamped, atan2, cos, hypot, sin};
use core::f64::consts::{FRAC_PI_2, PI, TAU};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use thiserror::Error;

/// Sine of the angle between tool axis and `u1` at which they are one: rounding.
const ALONG: f64 = 1e-12;
/// Sine below which two directions of a machine are one.
const PARALLEL: f64 = 1e-3;
/// By how much a cosine may be beyond 1 through rounding.
const ROUNDING: f64 = 1e-9;

/// Positions of the rotary axes in the order of the [`Chain`], rad.
pub type Angles = [f64; 2];

/// What a rotary axis turns.
#[derive(Copy, Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Carries {
    /// The workpiece.
    Table,
    /// The spindle.
    Head,
}

/// A rotary axis.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct RotaryAxis {
    /// `A`, `B` or `C`.
    pub letter: char,
    /// What it turns.
    pub carries: Carries,
    /// Direction about which it turns counter-clockwise; unit vector, machine coordinates, all axes at zero.
    pub direction: DVec3,
    /// A point that it turns about, mm, all axes at zero: of a table in the program's coordinates, of a head from the
    /// spindle's gauge line.
    pub centre: DVec3,
    /// Least and greatest position, rad; without end where there are none.
    pub range: (f64, f64),
    /// Fastest turn, rad/s.
    pub max_speed: f64,
    /// Largest acceleration, rad/s²; infinite where it is not asked.
    pub max_acceleration: f64,
}

impl RotaryAxis {
    /// An axis about the direction that its letter names, through zero, without limits but 90 degrees/s.
    pub fn plain(letter: char, carries: Carries) -> Self {
        let direction = match letter {
            'A' => DVec3::X,
            'B' => DVec3::Y,
            _ => DVec3::Z,
        };
        Self {
            letter,
            carries,
            direction,
            centre: DVec3::ZERO,
            range: (f64::NEG_INFINITY, f64::INFINITY),
            max_speed: FRAC_PI_2,
            max_acceleration: f64::INFINITY,
        }
    }
}

/// Two rotary axes, the one nearer to the workpiece first.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Chain {
    axes: [RotaryAxis; 2],
    /// From the tip to the spindle's gauge line, mm; 0 without heads.
    gauge_length: f64,
}

/// Why rotary axes are no chain.
#[derive(Copy, Clone, Debug, PartialEq, Error)]
pub enum ChainError {
    /// Both have one letter.
    #[error("both rotary axes are called {0}")]
    SameLetter(char),
    /// A head stands before a table.
    #[error("a head stands before a table; the order is from the workpiece to the tool")]
    Order,
    /// The axis next to the tool turns the tool about itself.
    #[error("axis {0} is next to the tool and turns it about its own axis, which tilts nothing")]
    AlongTool(char),
    /// The directions are parallel.
    #[error("both rotary axes turn about the same direction")]
    Parallel,
}

impl Chain {
    /// `gauge_length`: from the tip to the spindle's gauge line, mm.
    ///
    /// # Errors
    /// [`ChainError`]: the axes do not tilt the tool in two ways.
    pub fn new(axes: [RotaryAxis; 2], gauge_length: f64) -> Result<Self, ChainError> {
        let [first, second] = axes;
        if first.letter == second.letter {
            return Err(ChainError::SameLetter(first.letter));
        }
        if (first.carries, second.carries) == (Carries::Head, Carries::Table) {
            return Err(ChainError::Order);
        }
        if second.direction.cross(DVec3::Z).length() < PARALLEL {
            return Err(ChainError::AlongTool(second.letter));
        }
        if first.direction.cross(second.direction).length() < PARALLEL {
            return Err(ChainError::Parallel);
        }
        let has_heads = second.carries == Carries::Head;
        Ok(Self { axes, gauge_length: if has_heads { gauge_length } else { 0.0 } })
    }

    /// The axes, from the workpiece to the tool.
    pub fn axes(&self) -> &[RotaryAxis; 2] {
        &self.axes
    }

    /// From the tip to the spindle's gauge line, mm; 0 without heads.
    pub fn gauge_length(&self) -> f64 {
        self.gauge_length
    }

    /// Letters of the axes.
    pub fn letters(&self) -> [char; 2] {
        self.axes.map(|axis| axis.letter)
    }

    /// Whether an axis turns the spindle.
    pub fn has_heads(&self) -> bool {
        self.axes[1].carries == Carries::Head
    }

    /// Whether linear axes that run straight carry the tip straight through the frame of the tool: tables about program
    /// zero.
    pub fn is_centred(&self) -> bool {
        self.axes.iter().all(|a| a.carries == Carries::Table && a.centre == DVec3::ZERO)
    }

    /// How far places are from the centres that they turn about, mm, for a tip at a distance from program zero.
    pub(crate) fn reach(&self, from_zero: f64) -> f64 {
        let arm = |a: &RotaryAxis| match a.carries {
            Carries::Table => from_zero + a.centre.length(),
            Carries::Head => self.gauge_length + a.centre.length(),
        };
        self.axes.iter().map(arm).fold(from_zero, f64::max)
    }

    /// By how much the tool axis turns in the workpiece, rad.
    fn turn_of_tool(&self, i: usize, at: Angles) -> f64 {
        match self.axes[i].carries {
            Carries::Table => -at[i],
            Carries::Head => at[i],
        }
    }

    /// The tool axis in the workpiece, a unit vector.
    pub fn axis(&self, at: Angles) -> DVec3 {
        self.of_tool_frame(DVec3::Z, at)
    }

    /// A place of the workpiece in axes that turn with the tool, mm: Z is its height along the tool axis.
    pub fn in_tool_frame(&self, tip: DVec3, at: Angles) -> DVec3 {
        let v = rotated(tip, self.axes[0].direction, -self.turn_of_tool(0, at));
        rotated(v, self.axes[1].direction, -self.turn_of_tool(1, at))
    }

    /// The inverse of [`Self::in_tool_frame`].
    pub(crate) fn of_tool_frame(&self, place: DVec3, at: Angles) -> DVec3 {
        let v = rotated(place, self.axes[1].direction, self.turn_of_tool(1, at));
        rotated(v, self.axes[0].direction, self.turn_of_tool(0, at))
    }

    /// How far heads carry the tip off the place that the linear axes name, mm.
    fn swing(&self, at: Angles) -> DVec3 {
        let mut tip = DVec3::ZERO;
        for (axis, angle) in self.axes.iter().zip(at).rev() {
            if axis.carries == Carries::Head {
                let centre = axis.centre + self.gauge_length * DVec3::Z;
                tip = centre + rotated(tip - centre, axis.direction, angle);
            }
        }
        tip
    }

    /// Positions of the linear axes, mm, for a tip in the workpiece.
    pub fn to_machine(&self, tip: DVec3, at: Angles) -> DVec3 {
        let mut place = tip;
        for (axis, angle) in self.axes.iter().zip(at) {
            if axis.carries == Carries::Table {
                place = axis.centre + rotated(place - axis.centre, axis.direction, angle);
            }
        }
        place - self.swing(at)
    }

    /// The tip in the workpiece, mm, for positions of the linear axes.
    pub fn to_part(&self, linear: DVec3, at: Angles) -> DVec3 {
        let mut place = linear + self.swing(at);
        for (axis, angle) in self.axes.iter().zip(at).rev() {
            if axis.carries == Carries::Table {
                place = axis.centre + rotated(place - axis.centre, axis.direction, -angle);
            }
        }
        place
    }

    /// Whether the tool stands along the first axis, which then turns nothing but the tool about itself.
    pub(crate) fn is_at_pole(&self, at: Angles) -> bool {
        let (u, turn) = (self.axes[1].direction, self.turn_of_tool(1, at));
        rotated(DVec3::Z, u, turn).cross(self.axes[0].direction).length() < ALONG
    }

    /// Position of the second axis, besides `±` the returned second number, rad, for a component `along` of the tool axis
    /// on the first axis' direction, and `across` it; `None` where it cannot be reached.
    fn tilt(&self, along: f64, across: f64) -> Option<(f64, f64)> {
        let [u1, u2] = self.axes.map(|axis| axis.direction);
        let fixed = u2 * u2.z;
        let (a, b) = (u1.dot(DVec3::Z - fixed), u1.dot(u2.cross(DVec3::Z)));
        let (size, middle) = (hypot(a, b), atan2(b, a));
        let offset = u1.dot(fixed);
        if offset.abs() < ALONG && (size - 1.0).abs() < ALONG {
            // The same as below, exact near the pole.
            return Some((middle, atan2(across, along)));
        }
        let cosine = (along - offset) / size;
        (cosine.abs() <= 1.0 + ROUNDING).then(|| (middle, acos_clamped(cosine)))
    }

    /// Whether the tool can be turned to a unit axis.
    pub fn reaches(&self, axis: DVec3) -> bool {
        let u1 = self.axes[0].direction;
        self.tilt(u1.dot(axis), u1.cross(axis).length()).is_some()
    }

    /// The position for a unit axis that turns least from `near`: either of the two, any winding of the first axis, within
    /// the range of the second one if that can be. An axis nearer than `pole` to the first one, by the sine of the angle,
    /// is taken for it, and leaves its position as it is. What cannot be reached leaves all as it is.
    pub fn toward(&self, near: Angles, axis: DVec3, pole: f64) -> Angles {
        let u1 = self.axes[0].direction;
        let (mut along, mut across) = (u1.dot(axis), u1.cross(axis).length());
        let at_pole = across < pole;
        if at_pole {
            (along, across) = (1.0_f64.copysign(along), 0.0);
        }
        let Some((middle, half)) = self.tilt(along, across) else { return near };
        let [s1, s2] = self.axes.map(|a| if a.carries == Carries::Head { 1.0 } else { -1.0 });
        let (low, high) = self.axes[1].range;
        let position = |half: f64| {
            let second = within(s2 * middle + half, near[1], (low, high));
            let first = if at_pole {
                near[0]
            } else {
                let from = rotated(DVec3::Z, self.axes[1].direction, s2 * second);
                let across = from.dot(axis) - u1.dot(from) * along;
                nearest_winding(s1 * atan2(u1.dot(from.cross(axis)), across), near[0])
            };
            let beyond = (low - second).max(second - high).max(0.0);
            ([first, second], beyond)
        };
        let travel = |to: Angles| (to[0] - near[0]).abs() + (to[1] - near[1]).abs();
        let (up, down) = (position(half), position(-half));
        let is_less = down.1 < up.1 || (down.1 == up.1 && travel(down.0) < travel(up.0));
        if is_less { down.0 } else { up.0 }
    }

    /// The larger of the turns, rad.
    pub fn turn(&self, from: Angles, to: Angles) -> f64 {
        (to[0] - from[0]).abs().max((to[1] - from[1]).abs())
    }

    /// Least time from one position to another, s.
    pub(crate) fn time(&self, from: Angles, to: Angles) -> f64 {
        let of = |i: usize| (to[i] - from[i]).abs() / self.axes[i].max_speed;
        of(0).max(of(1))
    }

    /// Largest acceleration, 1/s², of the share of a move that turns from one position to another.
    pub(crate) fn acceleration(&self, from: Angles, to: Angles) -> f64 {
        let of = |i: usize| {
            let turn = (to[i] - from[i]).abs();
            if turn == 0.0 { f64::INFINITY } else { self.axes[i].max_acceleration / turn }
        };
        of(0).min(of(1))
    }
}

/// Positions at a share of a straight turn.
pub fn between(from: Angles, to: Angles, u: f64) -> Angles {
    [0, 1].map(|i| from[i] + (to[i] - from[i]) * u)
}

/// Positions as they will be written, with this many decimals of a degree.
pub(crate) fn rounded(at: Angles, decimals: u32) -> Angles {
    let scale = 10u64.pow(decimals) as f64;
    at.map(|angle| ((angle.to_degrees() * scale).round() / scale).to_radians())
}

/// `v` turned by `angle` counter-clockwise about the unit vector `u` (Rodrigues).
fn rotated(v: DVec3, u: DVec3, angle: f64) -> DVec3 {
    let (s, c) = (sin(angle), cos(angle));
    c * v + s * u.cross(v) + (1.0 - c) * u.dot(v) * u
}

fn nearest_winding(angle: f64, near: f64) -> f64 {
    angle + ((near - angle) / TAU).round() * TAU
}

/// A winding of an angle within a range, from half a turn back to half a turn on; `near` decides between its two ends.
fn within(angle: f64, near: f64, (low, high): (f64, f64)) -> f64 {
    let plain = nearest_winding(angle, 0.0);
    let plain = if plain.abs() >= PI { PI.copysign(near) } else { plain };
    let fits = |angle: &f64| (low..=high).contains(angle);
    [plain, plain - TAU, plain + TAU].into_iter().find(fits).unwrap_or(plain)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::machine::{Arrangement, Axes};

    const POLE: f64 = 1e-9;

    fn named(name: Arrangement) -> Chain {
        match name.axes(170.0) {
            Axes::FiveAxis(chain) => chain,
            Axes::ThreeAxis => panic!("{name:?} has rotary axes"),
        }
    }

    /// All that come along, one with tables beside program zero, and a table that turns about a slope.
    fn chains() -> Vec<Chain> {
        let mut all: Vec<Chain> = Arrangement::ALL[1..].iter().map(|n| named(*n)).collect();
        let [c, a] = *named(Arrangement::Xyzac).axes();
        let beside = [
            RotaryAxis { centre: DVec3::new(3.0, -20.0, -50.0), ..c },
            RotaryAxis { centre: DVec3::new(0.0, 7.0, 11.0), ..a },
        ];
        all.push(Chain::new(beside, 0.0).unwrap());
        let slope = DVec3::new(0.0, 1.0, 1.0).normalize();
        let nutating = [c, RotaryAxis { letter: 'B', direction: slope, ..a }];
        all.push(Chain::new(nutating, 0.0).unwrap());
        all
    }

    #[test]
    fn the_wanted_axis_is_reached_and_places_come_back() {
        for chain in chains() {
            let mut at = [0.0; 2];
            for i in 0..400 {
                let t = 0.1 * f64::from(i);
                let tilt = 1.2 * sin(0.37 * t);
                let axis = DVec3::new(sin(tilt) * cos(t), sin(tilt) * sin(t), cos(tilt));
                assert!(chain.reaches(axis));
                at = chain.toward(at, axis, POLE);
                let off = chain.axis(at).distance(axis);
                assert!(off < 1e-7, "{:?} at {i}: {off}", chain.letters());
                let p = DVec3::new(3.0, -7.0, 11.0 + t);
                let there = chain.to_machine(p, at);
                assert!(chain.to_part(there, at).distance(p) < 1e-10);
                let place = chain.in_tool_frame(p, at);
                assert!((place.z - p.dot(axis)).abs() < 1e-5, "the height is that along the axis");
                assert!(chain.of_tool_frame(place, at).distance(p) < 1e-10);
            }
        }
    }

    /// What moves when a rotary axis moves: of a table the workpiece, of a head the tool.
    #[test]
    fn heads_swing_the_tip_about_their_pivot() {
        let chain = named(Arrangement::XyzbcHead);
        let at = [0.0, FRAC_PI_2];
        assert!(chain.axis(at).distance(DVec3::X) < 1e-12);
        // The pivot stays 170 mm above zero; the tip stands that far on its side, towards -X.
        let tip = chain.to_part(DVec3::ZERO, at);
        assert!(tip.distance(DVec3::new(-170.0, 0.0, 170.0)) < 1e-9, "{tip}");
        let mixed = named(Arrangement::XyzbcMixed);
        let tip = mixed.to_part(DVec3::ZERO, [FRAC_PI_2, FRAC_PI_2]);
        assert!(tip.distance(DVec3::new(0.0, 170.0, 170.0)) < 1e-9, "{tip}");
    }

    /// Turned by half a turn about the slope between Y and Z the tool lies along Y: no farther can it lean.
    #[test]
    fn a_nutating_table_leans_no_farther_than_a_right_angle() {
        let chain = chains().pop().unwrap();
        assert!(chain.reaches(DVec3::Y) && chain.reaches(DVec3::X));
        let below = DVec3::new(0.0, 1.0, -0.1).normalize();
        assert!(!chain.reaches(below));
        assert_eq!(chain.toward([0.3, 0.4], below, POLE), [0.3, 0.4]);
    }

    #[test]
    fn c_winds_on_and_stays_at_the_pole() {
        let chain = named(Arrangement::Xyzac);
        let mut at = [0.0; 2];
        for i in 0..=720 {
            let t = f64::from(i) * PI / 90.0;
            let next = chain.toward(at, DVec3::new(0.6 * sin(t), 0.6 * cos(t), 0.8), POLE);
            assert!((next[0] - at[0]).abs() < 0.04 && (i == 0 || (next[1] - at[1]).abs() < 1e-9));
            at = next;
        }
        assert!((at[0] - 4.0 * TAU).abs() < 1e-9);
        let upright = chain.toward(at, DVec3::Z, POLE);
        assert_eq!(upright, [at[0], 0.0]);
        let beyond = chain.toward(upright, DVec3::new(0.0, -0.6, 0.8), POLE);
        assert!(beyond[1] < 0.0 && (beyond[0] - at[0]).abs() < 1e-9, "A goes through, C stays");
        // A that may not lean that way leaves the turn to C.
        let [c, a] = *chain.axes();
        let one_way = Chain::new([c, RotaryAxis { range: (0.0, 2.0), ..a }], 0.0).unwrap();
        let turned = one_way.toward(upright, DVec3::new(0.0, -0.6, 0.8), POLE);
        assert!(turned[1] > 0.0 && ((turned[0] - at[0]).abs() - PI).abs() < 1e-9);
    }

    #[test]
    fn what_is_no_chain_is_refused() {
        let [c, a] = *named(Arrangement::Xyzac).axes();
        let head = RotaryAxis { carries: Carries::Head, ..c };
        assert_eq!(Chain::new([c, c], 0.0), Err(ChainError::SameLetter('C')));
        assert_eq!(Chain::new([head, a], 0.0), Err(ChainError::Order));
        assert_eq!(Chain::new([a, c], 0.0), Err(ChainError::AlongTool('C')));
        let same = RotaryAxis { letter: 'B', ..a };
        assert_eq!(Chain::new([same, a], 0.0), Err(ChainError::Parallel));
    }
}
