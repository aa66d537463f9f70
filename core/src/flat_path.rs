//! The path in the flat plane: what the planner decides before it is lifted to the surface.

use crate::geometry::DVec2;
use crate::toolpath::MoveKind;

/// The end of a move in the flat plane; the move starts at the point before.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct FlatPoint {
    /// Flat image of the contact, flat mm.
    pub at: DVec2,
    /// Height above the finished surface along the tool axis, mm.
    pub height: f64,
    /// Purpose.
    pub kind: MoveKind,
    /// Index of the pass, in cutting order.
    pub pass: u32,
    /// Index of the region, in cutting order.
    pub region: u32,
    /// Feed on the surface, mm/s.
    pub feed: f64,
    /// Largest removal rate on the move, mm³/s.
    pub mrr: f64,
    /// Engagement angle where that rate occurs, rad.
    pub alpha: f64,
    /// Length of the move on the surface, mm.
    pub length: f64,
    /// Flat direction that the cutter faces where that is not its way: on branches, out and back.
    pub heading: Option<DVec2>,
    /// Where the cutter goes on straight beyond the chart: at the end of a pass by this, mm on the
    /// surface; negative at the start of one, from which it comes; 0 elsewhere.
    pub overrun: f64,
}

/// What the flat plane knows of the surface.
pub trait Terrain {
    /// Linear scale `s` at a flat point, mm per flat mm; `None` outside of the chart.
    fn scale(&self, at: DVec2) -> Option<f64>;

    /// How many passes a flat point lies inside of ring 0; negative outside of it, `None` outside
    /// of the chart.
    fn room(&self, at: DVec2) -> Option<f64>;

    /// Whether the straight flat line between two points stays inside of the chart.
    fn joins(&self, from: DVec2, to: DVec2) -> bool;
}
