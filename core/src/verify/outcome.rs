//! The result of the cut at a place of the surface.

use crate::geometry::DVec3;

/// A sample of the design surface after the cut.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Outcome {
    /// Place, mm.
    pub position: [f32; 3],
    /// Height left above surface and allowance, mm; negative in a gouge.
    pub residual: f32,
    /// The area that it represents, mm².
    pub area: f32,
    /// Cosine of the slope.
    pub up: f32,
    /// The move that left it; that move ends at the next point of the path.
    pub by: Option<u32>,
    /// Whether an earlier cut reached it.
    pub cut_before: bool,
    /// The move that took the upper half of the stock.
    pub opened_by: Option<u32>,
    /// Whether it is machined: the rest of the part is only checked for gouges.
    pub machined: bool,
    /// Whether the cutter bridges the part there, so that only the part below can be cut into.
    pub is_bridge: bool,
    /// Whether the plan says that the cutter does not fit there.
    pub inaccessible: bool,
    /// Whether a wall is nearer than the tolerance: its position is not known more accurately, so nothing has to be
    /// reached there.
    pub at_wall: bool,
}

impl Outcome {
    /// Where it is, mm.
    pub fn place(&self) -> DVec3 {
        let [x, y, z] = self.position.map(f64::from);
        DVec3::new(x, y, z)
    }

    /// Whether any cut reached it.
    pub fn is_cut(&self) -> bool {
        self.by.is_some() || self.cut_before
    }

    /// Whether a negative height is a cut into the part.
    pub fn is_of_part(&self) -> bool {
        !self.is_bridge
    }

    /// Whether its height is held to the limit.
    pub(super) fn is_judged(&self) -> bool {
        self.machined && !self.inaccessible && !self.at_wall
    }
}
