//! The machine: its axes and what they can do.

mod xyzac;

pub(crate) use xyzac::{Rotary, pole};

use crate::geometry::DVec3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Arrangement of the axes.
#[derive(Copy, Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum Axes {
    /// Three linear axes; the tool axis is fixed.
    #[serde(rename = "3")]
    ThreeAxis,
    /// Rotary tables A (about X) and C (about Z) under three linear axes.
    #[serde(rename = "xyzac")]
    Xyzac,
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
    /// Fastest turn of a rotary axis, rad/s.
    pub max_rotary_speed: f64,
    /// Height above part and stock at which rapids run, mm.
    pub clearance: f64,
    /// Where the linear axes can go, in the program's coordinates.
    pub travel: Travel,
}

/// The tables of a machine on their way from axis to axis.
#[derive(Copy, Clone, Debug)]
pub(crate) struct Tables {
    at: Rotary,
    pole: f64,
    axes: Axes,
    speed: f64,
}

impl Tables {
    /// Tables at their zero; `radius`: of the cutter, whose rim may leave its place by less than `tolerance`, mm.
    pub fn new(machine: &Machine, tolerance: f64, radius: f64) -> Self {
        let pole = pole(tolerance, radius);
        Self { at: Rotary::default(), pole, axes: machine.axes, speed: machine.max_rotary_speed }
    }

    /// Least time to turn on to a unit axis, s.
    pub fn turn(&mut self, axis: DVec3) -> f64 {
        if self.axes == Axes::ThreeAxis {
            return 0.0;
        }
        let from = self.at;
        self.at = from.toward(axis, self.pole);
        from.turn_to(self.at) / self.speed
    }
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
