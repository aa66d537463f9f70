//! The waist: the path that is delivered, as typed points with feed, axis and purpose.

use crate::geometry::{DVec2, DVec3};

/// What a move is for.
#[derive(Copy, Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum MoveKind {
    /// Along a pass.
    Cut,
    /// The cutting part of a trochoid.
    Trochoid,
    /// The part of a trochoid loop that cuts nothing.
    Return,
    /// Between passes at feed, on the surface, approaching or retracting.
    Link,
    /// At rapid speed, above the clearance height.
    Rapid,
}

/// The end of a move; the move starts at the point before. The first point is where the path starts.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct PathPoint {
    /// Purpose of the move that ends here.
    pub kind: MoveKind,
    /// Index of the pass, in cutting order.
    pub pass: u32,
    /// Index of the region.
    pub region: u32,
    /// Tool tip, mm.
    pub tip: DVec3,
    /// Unit tool axis, from the tip to the spindle.
    pub axis: DVec3,
    /// Unit surface normal at the contact, toward the tool; the axis where there is no contact.
    pub normal: DVec3,
    /// Flat image of the contact, flat mm; `None` away from the surface.
    pub flat: Option<DVec2>,
    /// Feed of the move that ends here, mm/s, measured at the contact.
    pub feed: f64,
    /// Largest predicted removal rate on the move that ends here, mm³/s.
    pub mrr: f64,
    /// Engagement angle where that rate occurs, rad.
    pub alpha: f64,
    /// Time at which the point is reached with the feeds as commanded, s.
    pub time: f64,
}

/// The path that is delivered.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct Toolpath {
    /// The points, in cutting order.
    pub points: Vec<PathPoint>,
}
