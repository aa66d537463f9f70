//! How a part is reached.

use crate::tool::Tool;

/// How much steeper than it is machined the surface is followed, so that its outline does not depend on single facets;
/// and up to which slope at most, rad (4 and 88 degrees).
const BEYOND: f64 = 4.0 * core::f64::consts::PI / 180.0;
const STEEPEST: f64 = 88.0 * core::f64::consts::PI / 180.0;

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

impl ReachOptions {
    /// Steepest slope up to which the reached surface is followed, rad: a little beyond what is machined.
    pub(super) fn followed(&self) -> f64 {
        (self.steepest + BEYOND).min(STEEPEST)
    }
}
