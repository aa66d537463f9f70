//! A detour from a pass to gaps and back.

use crate::geometry::DVec2;

/// A ring or a branch.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum Line {
    /// By index.
    Pass(usize),
    /// By index, in the order in which they were added.
    Branch(usize),
}

/// A point of a pass from which a branch leaves.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Anchor {
    /// The pass.
    pub line: Line,
    /// Its segment.
    pub segment: usize,
    /// Where on the segment: 0 start, 1 end.
    pub t: f64,
    /// The flat point.
    pub at: DVec2,
    /// Distance from the place that was queried, passes.
    pub distance: f64,
}

/// A detour from a pass to gaps and back.
#[derive(Clone, Debug, PartialEq)]
pub struct AnchoredBranch {
    /// Where it leaves and returns.
    pub anchor: Anchor,
    /// Flat points between leaving and returning.
    pub points: Vec<DVec2>,
    /// Whether no ring of a higher level is beside the cluster: it is the core of the rings.
    pub is_core: bool,
}

/// The line from the anchor over `points` back to it.
pub fn closed(anchor: &Anchor, points: &[DVec2]) -> Vec<DVec2> {
    let ends = core::iter::once(anchor.at);
    let mut line: Vec<DVec2> = ends.clone().chain(points.iter().copied()).chain(ends).collect();
    line.dedup();
    line
}
