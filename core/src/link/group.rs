//! The passes of a region, and what all ways of joining them have in common.

use super::order::Precedence;
use crate::level_set::Pass;

/// Longest link on the surface, cutter radii.
pub const LONGEST_LINK: f64 = 8.0;
/// The next ring starts this many cutter radii ahead, so that the link meets it at a slant.
pub const SLANT: f64 = 2.0;

/// The passes of a region and their order constraints.
#[derive(Copy, Clone, Debug)]
pub struct Group<'a> {
    /// The passes.
    pub passes: &'a [Pass],
    /// Which passes must be cut before which.
    pub precedence: &'a Precedence,
}

impl Group<'_> {
    /// Whether all of its passes are closed.
    pub fn has_rings_only(&self) -> bool {
        self.passes.iter().all(|p| p.is_closed)
    }
}

/// A pass, reversed on request.
pub(crate) fn oriented(pass: &Pass, reverse: bool) -> Pass {
    let mut turned = pass.clone();
    if reverse {
        turned.points.reverse();
        turned.overrun.reverse();
        turned.half.reverse();
        turned.beside.reverse();
        turned.branches.iter_mut().for_each(|s| s.at = pass.points.len() - 1 - s.at);
    }
    turned
}
