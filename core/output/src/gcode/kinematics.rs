//! Where the axes of a machine stand, and what that is in the workpiece.

use evencut_core::geometry::DVec3;
use evencut_core::machine::{Angles, Axes, between};

/// Sine of the angle to the first rotary axis below which a tool axis is along it: the last digits of its direction.
const UPRIGHT: f64 = 1e-6;

/// Where the axes of the machine stand.
#[derive(Copy, Clone, Debug, PartialEq, Default)]
pub struct MachinePosition {
    /// X, Y and Z, mm.
    pub linear: DVec3,
    /// The rotary axes, the one nearer to the workpiece first; 0 on three axes.
    pub rotary: Angles,
}

impl MachinePosition {
    /// The position at the share `u` of a straight move to `end`.
    pub(super) fn lerp(&self, end: &Self, u: f64) -> Self {
        let rotary = between(self.rotary, end.rotary, u);
        Self { linear: self.linear.lerp(end.linear, u), rotary }
    }
}

/// Machine and workpiece coordinates of any arrangement of axes.
#[derive(Copy, Clone, Debug, PartialEq)]
pub(super) struct Kinematics(pub Axes);

impl Kinematics {
    /// Letters of the axes: X, Y, Z, then the rotary ones, the one nearer to the workpiece first.
    pub fn letters(&self) -> &'static [char] {
        match self.0.chain().map(|chain| chain.letters()) {
            None => &['X', 'Y', 'Z'],
            Some(['A', 'B']) => &['X', 'Y', 'Z', 'A', 'B'],
            Some(['A', _]) => &['X', 'Y', 'Z', 'A', 'C'],
            Some(['B', 'A']) => &['X', 'Y', 'Z', 'B', 'A'],
            Some(['B', _]) => &['X', 'Y', 'Z', 'B', 'C'],
            Some([_, 'A']) => &['X', 'Y', 'Z', 'C', 'A'],
            Some(_) => &['X', 'Y', 'Z', 'C', 'B'],
        }
    }

    /// Its axes, for messages.
    pub fn name(&self) -> String {
        match self.0.chain() {
            None => "a three-axis machine".to_string(),
            Some(_) => format!("a machine with the axes {}", String::from_iter(self.letters())),
        }
    }

    /// A machine point in workpiece coordinates.
    pub fn to_part(self, p: DVec3, rotary: Angles) -> DVec3 {
        self.0.chain().map_or(p, |chain| chain.to_part(p, rotary))
    }

    /// A workpiece point in machine coordinates.
    pub fn to_machine(self, p: DVec3, rotary: Angles) -> DVec3 {
        self.0.chain().map_or(p, |chain| chain.to_machine(p, rotary))
    }

    /// The position of the rotary axes for a unit tool axis that turns least from `near`.
    pub fn rotary_toward(&self, axis: DVec3, near: Angles) -> Angles {
        self.0.chain().map_or(near, |chain| chain.toward(near, axis, UPRIGHT))
    }

    /// Tip and unit tool axis in the workpiece.
    pub fn tip_and_axis(&self, at: &MachinePosition) -> (DVec3, DVec3) {
        let axis = self.0.chain().map_or(DVec3::Z, |chain| chain.axis(at.rotary));
        (self.to_part(at.linear, at.rotary), axis)
    }

    /// The tip in axes that turn with the tool: Z is its height along the tool axis.
    pub fn in_tool_frame(&self, at: &MachinePosition) -> DVec3 {
        let tip = self.to_part(at.linear, at.rotary);
        self.0.chain().map_or(tip, |chain| chain.in_tool_frame(tip, at.rotary))
    }
}
