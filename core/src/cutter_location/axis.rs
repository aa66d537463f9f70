//! Direction of the tool axis.

use crate::geometry::DVec3;
use crate::geometry::math::{cos, sin};
use crate::machine::Axes;

/// How the tool axis is determined.
#[derive(Copy, Clone, Debug, PartialEq)]
pub enum ToolAxis {
    /// The same unit direction everywhere (three-axis; 3+2 when not +Z).
    Fixed(DVec3),
    /// Tilted from the surface normal toward the feed direction by this lead angle, rad (five-axis).
    Lead(f64),
}

impl ToolAxis {
    /// On a machine with these axes: along Z where they are fixed, else with `lead` rad.
    pub fn on(axes: Axes, lead: f64) -> Self {
        match axes {
            Axes::ThreeAxis => Self::Fixed(DVec3::Z),
            Axes::FiveAxis(_) => Self::Lead(lead),
        }
    }
}

/// Unit tool axis at a contact with unit `normal` and feed direction `feed` (of any length).
///
/// `cos(lead) n + sin(lead) f`, with `f` the part of the feed direction perpendicular to `n`; `n`
/// itself where there is none.
pub fn tool_axis(rule: ToolAxis, normal: DVec3, feed: DVec3) -> DVec3 {
    match rule {
        ToolAxis::Fixed(axis) => axis,
        ToolAxis::Lead(lead) => {
            let forward = (feed - normal * feed.dot(normal)).normalize_or_zero();
            (normal * cos(lead) + forward * sin(lead)).normalize_or(normal)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lead_tilts_toward_the_feed() {
        let axis = tool_axis(ToolAxis::Lead(0.1), DVec3::Z, DVec3::new(2.0, 0.0, 5.0));
        assert!((axis - DVec3::new(sin(0.1), 0.0, cos(0.1))).length() < 1e-15);
        let no_feed = tool_axis(ToolAxis::Lead(0.1), DVec3::Z, DVec3::Z);
        assert!((no_feed - DVec3::Z).length() < 1e-15);
    }
}
