//! Rotary tables: A turns about X and carries C, which turns about Z; their centre is program zero.
//!
//! Workpiece point `p` stands in the machine at `P = Rx(A) Rz(C) p`, and the tool axis that stands along
//! the machine's Z is `(sin C sin A, cos C sin A, cos A)`. This is the inverse
//! that LinuxCNC's xyzac-trt kinematics have at their default directions and without offsets (checked against
//! its formulas); since the program holds its result, the machine must run trivial kinematics.

use crate::geometry::DVec3;
use crate::geometry::math::{acos_clamped, atan2, cos, hypot, sin};
use std::f64::consts::{PI, TAU};

/// Sine of A at which it stands upright: rounding.
const UPRIGHT: f64 = 1e-12;

/// Positions of the rotary axes, rad.
#[derive(Copy, Clone, Debug, PartialEq, Default)]
pub(crate) struct Rotary {
    pub a: f64,
    pub c: f64,
}

impl Rotary {
    /// The position for a unit axis that turns least from `self`: either sign of A, any winding of C. An axis
    /// nearer than `pole` to the C axis, by the sine of the angle, is taken for it, and leaves C where it is.
    pub fn toward(self, axis: DVec3, pole: f64) -> Self {
        let sine = hypot(axis.x, axis.y);
        if sine < pole {
            let a = if axis.z > 0.0 { 0.0 } else { PI.copysign(self.a) };
            return Self { a, c: self.c };
        }
        let tilt = if axis.z.abs() < 0.7 { acos_clamped(axis.z) } else { atan2(sine, axis.z) };
        let turn = atan2(axis.x, axis.y);
        let up = Self { a: tilt, c: nearest_winding(turn, self.c) };
        let down = Self { a: -tilt, c: nearest_winding(turn + PI, self.c) };
        let travel = |r: Self| (r.a - self.a).abs() + (r.c - self.c).abs();
        if travel(down) < travel(up) { down } else { up }
    }

    /// Machine coordinates of a workpiece point.
    pub fn to_machine(self, p: DVec3) -> DVec3 {
        let (sc, cc, sa, ca) = (sin(self.c), cos(self.c), sin(self.a), cos(self.a));
        let (x, y) = (cc * p.x - sc * p.y, sc * p.x + cc * p.y);
        DVec3::new(x, ca * y - sa * p.z, sa * y + ca * p.z)
    }

    /// Workpiece coordinates of a machine point.
    pub fn to_part(self, p: DVec3) -> DVec3 {
        let (sc, cc, sa, ca) = (sin(self.c), cos(self.c), sin(self.a), cos(self.a));
        let (y, z) = (ca * p.y + sa * p.z, ca * p.z - sa * p.y);
        DVec3::new(cc * p.x + sc * y, cc * y - sc * p.x, z)
    }

    /// The tool axis in the workpiece.
    pub fn axis(self) -> DVec3 {
        self.to_part(DVec3::Z)
    }

    /// Whether the tool stands along the C axis, from above or below: C turns nothing but the part about it.
    pub fn is_at_pole(self) -> bool {
        sin(self.a).abs() < UPRIGHT
    }

    /// The larger of the turns of A and C, rad.
    pub fn turn_to(self, other: Self) -> f64 {
        (other.a - self.a).abs().max((other.c - self.c).abs())
    }

    pub fn lerp(self, other: Self, u: f64) -> Self {
        Self { a: self.a + (other.a - self.a) * u, c: self.c + (other.c - self.c) * u }
    }

    /// The position as it will be written, with this many decimals of a degree.
    pub fn rounded(self, decimals: u32) -> Self {
        let scale = 10u64.pow(decimals) as f64;
        let round = |angle: f64| ((angle.to_degrees() * scale).round() / scale).to_radians();
        Self { a: round(self.a), c: round(self.c) }
    }
}

fn nearest_winding(angle: f64, near: f64) -> f64 {
    angle + ((near - angle) / TAU).round() * TAU
}

#[cfg(test)]
mod tests {
    use super::*;

    const POLE: f64 = 1e-9;

    #[test]
    fn the_wanted_axis_is_turned_upright_and_back() {
        let mut at = Rotary::default();
        for i in 0..400 {
            let t = 0.1 * f64::from(i);
            let tilt = 1.2 * sin(0.37 * t);
            let axis = DVec3::new(sin(tilt) * cos(t), sin(tilt) * sin(t), cos(tilt));
            at = at.toward(axis, POLE);
            assert!((at.axis() - axis).length() < 1e-12);
            assert!((at.to_machine(axis) - DVec3::Z).length() < 1e-12);
            let p = DVec3::new(3.0, -7.0, 11.0 + t);
            assert!((at.to_part(at.to_machine(p)) - p).length() < 1e-12);
        }
    }

    #[test]
    fn c_winds_on_and_stays_at_the_pole() {
        let mut at = Rotary::default();
        for i in 0..=720 {
            let t = f64::from(i) * PI / 90.0;
            let next = at.toward(DVec3::new(0.6 * sin(t), 0.6 * cos(t), 0.8), POLE);
            assert!((next.c - at.c).abs() < 0.04 && (i == 0 || (next.a - at.a).abs() < 1e-9));
            at = next;
        }
        assert!((at.c - 4.0 * TAU).abs() < 1e-9);
        let upright = at.toward(DVec3::Z, POLE);
        assert_eq!((upright.a, upright.c), (0.0, at.c));
        let beyond = upright.toward(DVec3::new(0.0, -0.6, 0.8), POLE);
        assert!(beyond.a < 0.0 && (beyond.c - at.c).abs() < 1e-9, "A goes through, C stays");
    }
}
