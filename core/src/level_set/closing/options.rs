//! How gaps are closed.

use crate::geometry::DVec2;
use crate::job::RingOrder;

/// How gaps are closed.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct ClosingOptions<'a> {
    /// Order of the rings.
    pub order: RingOrder,
    /// Whether there is a pass at every whole level.
    pub on_levels: bool,
    /// Flat segments of other passes, which machine their surroundings.
    pub beside: &'a [[DVec2; 2]],
    /// Whether the cutter has a flat bottom and is tilted: it machines nothing beyond the end of a branch.
    pub has_flat_bottom: bool,
    /// Number of threads; the branches do not depend on it.
    pub threads: usize,
}
