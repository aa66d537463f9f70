//! Machines that come along, by name.

use super::chain::{Carries, Chain, RotaryAxis};
use super::limits::Axes;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Arrangement of the axes of a machine that comes along.
#[derive(Copy, Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum Arrangement {
    /// Three linear axes; the tool axis is fixed.
    #[serde(rename = "3")]
    ThreeAxis,
    /// Rotary tables: A (about X) carries C (about Z).
    #[serde(rename = "xyzac")]
    Xyzac,
    /// Rotary tables: B (about Y) carries C (about Z).
    #[serde(rename = "xyzbc")]
    Xyzbc,
    /// A head that turns the spindle: A (about X) carries B (about Y).
    #[serde(rename = "xyzab-head")]
    XyzabHead,
    /// A head that turns the spindle: C (about Z) carries B (about Y).
    #[serde(rename = "xyzbc-head")]
    XyzbcHead,
    /// A rotary table C (about Z), and a head B (about Y) that turns the spindle.
    #[serde(rename = "xyzbc-mixed")]
    XyzbcMixed,
}

impl Arrangement {
    /// All of them.
    pub const ALL: [Self; 6] = [
        Self::ThreeAxis,
        Self::Xyzac,
        Self::Xyzbc,
        Self::XyzabHead,
        Self::XyzbcHead,
        Self::XyzbcMixed,
    ];

    /// Its name in job files.
    pub fn name(self) -> &'static str {
        match self {
            Self::ThreeAxis => "3",
            Self::Xyzac => "xyzac",
            Self::Xyzbc => "xyzbc",
            Self::XyzabHead => "xyzab-head",
            Self::XyzbcHead => "xyzbc-head",
            Self::XyzbcMixed => "xyzbc-mixed",
        }
    }

    /// Its rotary axes, the one nearer to the workpiece first; empty on three axes.
    pub fn rotary(self) -> &'static [(char, Carries)] {
        use Carries::{Head, Table};
        match self {
            Self::ThreeAxis => &[],
            Self::Xyzac => &[('C', Table), ('A', Table)],
            Self::Xyzbc => &[('C', Table), ('B', Table)],
            Self::XyzabHead => &[('A', Head), ('B', Head)],
            Self::XyzbcHead => &[('C', Head), ('B', Head)],
            Self::XyzbcMixed => &[('C', Table), ('B', Head)],
        }
    }

    /// Its axes about program zero and, of heads, a pivot that is so far from the tip, mm.
    pub fn axes(self, pivot: f64) -> Axes {
        let axis = |&(letter, carries): &(char, Carries)| RotaryAxis::plain(letter, carries);
        match self.rotary() {
            [first, second] => Chain::new([axis(first), axis(second)], pivot)
                .map_or(Axes::ThreeAxis, Axes::FiveAxis),
            _ => Axes::ThreeAxis,
        }
    }
}
