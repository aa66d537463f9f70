//! Machine ↔ workpiece coordinates.
//!
//! Tables with their centre at program zero: A turns about X, or B about Y, and carries C, which turns
//! about Z. A workpiece point `p` stands in the machine at `Rx(A) Rz(C) p` or `Ry(B) Rz(C) p`.
//!
//! Source: LinuxCNC's kinematics xyzac-trt and xyzbc-trt at their default directions, without offsets.

use crate::geometry::DVec3;
use crate::geometry::math::{cos, sin};
use crate::machine::{Axes, Rotary};
use core::f64::consts::FRAC_PI_2;

/// Sine of the angle to the C axis below which a tool axis is along it: the last digits of its direction.
const UPRIGHT: f64 = 1e-6;

/// Arrangement of the axes of the machine that a program is written for.
#[derive(Copy, Clone, Debug, PartialEq, Eq, Default)]
pub enum Kinematics {
    /// Three linear axes.
    #[default]
    ThreeAxis,
    /// Table A about X carries table C about Z.
    Xyzac,
    /// Table B about Y carries table C about Z.
    Xyzbc,
}

impl From<Axes> for Kinematics {
    fn from(axes: Axes) -> Self {
        match axes {
            Axes::ThreeAxis => Self::ThreeAxis,
            Axes::Xyzac => Self::Xyzac,
        }
    }
}

/// Where the axes of the machine stand.
#[derive(Copy, Clone, Debug, PartialEq, Default)]
pub struct MachinePosition {
    /// X, Y and Z, mm.
    pub linear: DVec3,
    /// A or B, and C, rad; 0 on three axes.
    pub rotary: [f64; 2],
}

impl MachinePosition {
    /// The position at the share `u` of a straight move to `end`.
    pub(super) fn lerp(&self, end: &Self, u: f64) -> Self {
        let turn = |i: usize| self.rotary[i] + (end.rotary[i] - self.rotary[i]) * u;
        Self { linear: self.linear.lerp(end.linear, u), rotary: [turn(0), turn(1)] }
    }
}

impl Kinematics {
    /// Letters of the axes, in the order X, Y, Z, then the rotary ones.
    pub(super) fn letters(self) -> &'static [char] {
        match self {
            Self::ThreeAxis => &['X', 'Y', 'Z'],
            Self::Xyzac => &['X', 'Y', 'Z', 'A', 'C'],
            Self::Xyzbc => &['X', 'Y', 'Z', 'B', 'C'],
        }
    }

    /// Its name, for messages.
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::ThreeAxis => "a three-axis machine",
            Self::Xyzac => "xyzac",
            Self::Xyzbc => "xyzbc",
        }
    }

    /// A machine point in workpiece coordinates, with the tables at `rotary`.
    pub fn to_part(self, p: DVec3, rotary: [f64; 2]) -> DVec3 {
        let [first, c] = rotary;
        match self {
            Self::ThreeAxis => p,
            Self::Xyzac => Rotary { a: first, c }.to_part(p),
            Self::Xyzbc => {
                let (sb, cb, sc, cc) = (sin(first), cos(first), sin(c), cos(c));
                let x = cb * p.x - sb * p.z;
                DVec3::new(cc * x + sc * p.y, cc * p.y - sc * x, sb * p.x + cb * p.z)
            }
        }
    }

    /// A workpiece point in machine coordinates, with the tables at `rotary`.
    pub fn to_machine(self, p: DVec3, rotary: [f64; 2]) -> DVec3 {
        let [first, c] = rotary;
        match self {
            Self::ThreeAxis => p,
            Self::Xyzac => Rotary { a: first, c }.to_machine(p),
            Self::Xyzbc => {
                let (sb, cb, sc, cc) = (sin(first), cos(first), sin(c), cos(c));
                let (x, y) = (cc * p.x - sc * p.y, sc * p.x + cc * p.y);
                DVec3::new(cb * x + sb * p.z, y, cb * p.z - sb * x)
            }
        }
    }

    /// The position of the tables for a unit tool axis that turns least from `near`.
    pub(super) fn rotary_toward(self, axis: DVec3, near: [f64; 2]) -> [f64; 2] {
        // Tables B and C stand as A and C do that are turned by a right angle about Z.
        let offset = match self {
            Self::ThreeAxis => return near,
            Self::Xyzac => 0.0,
            Self::Xyzbc => FRAC_PI_2,
        };
        let Rotary { a, c } = Rotary { a: near[0], c: near[1] - offset }.toward(axis, UPRIGHT);
        [a, c + offset]
    }

    /// Tip and unit tool axis in the workpiece.
    pub fn tip_and_axis(self, at: &MachinePosition) -> (DVec3, DVec3) {
        let axis = self.to_part(DVec3::Z, at.rotary);
        (self.to_part(at.linear, at.rotary), axis)
    }
}
