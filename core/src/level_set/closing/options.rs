//! How gaps are closed.

use crate::footprint::Footprint;
use crate::geometry::DVec2;
use crate::job::RingOrder;

/// Clusters whose widest gap is not above this are left open in any case, passes: the field is no more accurate.
const ACCEPTED: f64 = 0.506;

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
    /// Heights of the cusps, mm: that for which passes are laid out, and the largest that may be left.
    pub cusps: [f64; 2],
    /// Number of threads; the branches do not depend on it.
    pub threads: usize,
}

impl ClosingOptions<'_> {
    /// The widest gap that may be left, passes: cusps over it are not above what may be left, where that tells apart from
    /// the accuracy of the field.
    pub(super) fn accepted(&self) -> f64 {
        let [aimed, left] = self.cusps.map(|h| self.footprint.side_step(h));
        if left > aimed { (0.5 * left / aimed).max(ACCEPTED) } else { ACCEPTED }
    }
}
