//! A cutter in place.

use crate::geometry::DVec3;
use crate::tool::Tool;

/// A cutter in place, for a query.
#[derive(Copy, Clone, Debug)]
pub struct Standing {
    /// The cutter.
    pub tool: Tool,
    /// Its tip, mm.
    pub tip: DVec3,
    /// Unit axis.
    pub axis: DVec3,
    /// Length above the tip that must be clear, mm; may be infinite.
    pub reach: f64,
}

impl Standing {
    /// The same cutter moved along its axis, mm.
    pub fn lifted(self, by: f64) -> Self {
        Self { tip: self.tip + self.axis * by, ..self }
    }

    /// Whether a place lies in the cutter.
    pub fn contains(&self, place: DVec3) -> bool {
        let way = place - self.tip;
        let height = way.dot(self.axis);
        let (radius, round) = (self.tool.radius(), self.tool.corner_radius());
        let lack = (round - height).max(0.0);
        let wide = radius - round + (round * round - lack * lack).max(0.0).sqrt();
        let across = way.reject_from_normalized(self.axis).length_squared();
        (0.0..=self.reach).contains(&height) && across <= wide * wide
    }

    /// The cutter offset outward at its side and its end (inward if negative), mm; `None` where nothing is left.
    pub fn grown(self, growth: f64) -> Option<Self> {
        let radius = self.tool.radius() + growth;
        let corner = (self.tool.corner_radius() + growth).max(0.0);
        let tool = Tool::new(radius, corner.min(radius)).ok()?;
        Some(Self { tool, ..self.lifted(-growth) })
    }

    /// The cutter offset outward on all sides, at its upper end, too, less `depth`, mm; `None` where nothing is left.
    pub(super) fn away(self, distance: f64, depth: f64) -> Option<Self> {
        let grown = self.grown(distance - depth)?;
        Some(Self { reach: self.reach + 2.0 * distance, ..grown })
    }
}
