//! What the cut left at a place of the surface.

use crate::geometry::DVec3;

/// A sample of the design surface after the cut.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Outcome {
    /// Place, mm.
    pub position: [f32; 3],
    /// What is left above surface and allowance, mm; negative in a gouge.
    pub residual: f32,
    /// The area it stands for, mm².
    pub area: f32,
    /// Cosine of the slope.
    pub up: f32,
    /// The move that left it; it ends at the path's point after that.
    pub by: Option<u32>,
    /// The move that took the upper half of the stock.
    pub opened_by: Option<u32>,
    /// Whether it is machined: the rest of the part is only guarded against gouges.
    pub machined: bool,
    /// Whether the plan says that the cutter does not fit there.
    pub inaccessible: bool,
    /// Whether a wall is nearer than the tolerance: its place is known to no more, so nothing need be reached there.
    pub at_wall: bool,
}

impl Outcome {
    /// Where it is, mm.
    pub fn place(&self) -> DVec3 {
        let [x, y, z] = self.position.map(f64::from);
        DVec3::new(x, y, z)
    }

    /// Whether what is left there is held to the limit.
    pub(super) fn is_judged(&self) -> bool {
        self.machined && !self.inaccessible && !self.at_wall
    }
}
