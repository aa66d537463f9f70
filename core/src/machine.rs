//! The machine: its axes and what they can do.

/// Arrangement of the axes.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum Axes {
    /// Three linear axes; the tool axis is fixed.
    ThreeAxis,
    /// Rotary tables A (about X) and C (about Z) under three linear axes.
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
    /// Height above part and stock at which rapids run, mm.
    pub clearance: f64,
}
