//! How gaps are closed.

use crate::footprint::Footprint;
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
    /// The cutter: if its strip lags, it machines nothing beyond the end of a branch.
    pub footprint: Footprint,
    /// Number of threads; the branches do not depend on it.
    pub threads: usize,
}
