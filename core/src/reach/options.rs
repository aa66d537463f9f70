//! How a part is reached.

use crate::tool::Tool;

/// How a part is reached.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct ReachOptions {
    /// The cutter; its axis is +Z.
    pub tool: Tool,
    /// Allowance left on the part, mm.
    pub allowance: f64,
    /// How far the reached surface may be from the exact one, mm.
    pub accuracy: f64,
    /// Steepest slope that is machined, rad from level.
    pub steepest: f64,
    /// Number of threads; the result does not depend on it.
    pub threads: usize,
}
