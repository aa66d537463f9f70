//! Parameters of locating a pass: cutter, axis, allowance, tolerance.

use super::axis::ToolAxis;
use crate::tool::Tool;

/// How a pass is located.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct PassOptions {
    /// The cutter.
    pub tool: Tool,
    /// How its axis is determined.
    pub axis: ToolAxis,
    /// Fastest turn of the axis along the pass, rad/mm; infinity for none.
    pub axis_rate: f64,
    /// Largest angle between axis and surface normal, rad, to which the axis is tilted where something would touch; 0 for
    /// never.
    pub largest_tilt: f64,
    /// Allowance left on the surface, mm.
    pub allowance: f64,
    /// Largest deviation of the path and largest penetration, mm.
    pub tolerance: f64,
    /// Length of the cutter above its tip that must clear the part, mm; infinity for no limit.
    pub reach: f64,
}
