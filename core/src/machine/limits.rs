//! How the axes of a machine are arranged, and what they can do.

use super::chain::Chain;

/// Farthest distance of a part from the origin, mm: half of the largest coordinate that is read back from a program.
pub const LONGEST_TRAVEL: f64 = 5e5;

/// Arrangement of the axes.
#[derive(Copy, Clone, Debug, PartialEq, Default)]
pub enum Axes {
    /// Three linear axes; the tool axis is fixed.
    #[default]
    ThreeAxis,
    /// Two rotary axes besides.
    FiveAxis(Chain),
}

impl Axes {
    /// The rotary axes, if there are any.
    pub fn chain(&self) -> Option<&Chain> {
        match self {
            Self::ThreeAxis => None,
            Self::FiveAxis(chain) => Some(chain),
        }
    }
}

/// Limits of the machine.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Machine {
    /// Arrangement of the axes.
    pub axes: Axes,
    /// Fastest feed, mm/s; rapids run at it too.
    pub max_feed: f64,
    /// Acceleration of the linear axes, mm/s².
    pub max_acceleration: f64,
    /// Height above part and stock at which rapids run, mm.
    pub clearance: f64,
    /// Where the linear axes can go, in the program's coordinates.
    pub travel: Travel,
}

/// Reach of the linear axes in the program's coordinates: least and greatest position, mm; an axis
/// that is `None` is not checked.
#[derive(Copy, Clone, Debug, PartialEq, Default)]
pub struct Travel {
    /// Along X.
    pub x: Option<(f64, f64)>,
    /// Along Y.
    pub y: Option<(f64, f64)>,
    /// Along Z.
    pub z: Option<(f64, f64)>,
}
