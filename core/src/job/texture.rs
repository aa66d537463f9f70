//! The window whose texture is simulated, and how the teeth stand.

use crate::geometry::{DVec2, DVec3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Which cells the grid of a window has.
#[derive(Copy, Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum TextureCells {
    /// Even steps of the flat map, at most `spacing` long on the surface.
    Uniform,
    /// A net whose cells are all `spacing` long on the surface.
    Constant,
}

/// A window of the surface, and the teeth.
#[derive(Clone, Debug, PartialEq)]
pub struct TextureOptions {
    /// A place near the window's middle, mm; of the whole surface, one where its direction is that of the feed.
    pub at: DVec3,
    /// Whether it is all of the surface, instead of a window of a size.
    pub whole: bool,
    /// Size along and across the feed, mm.
    pub size: DVec2,
    /// Length of a cell of the grid, mm.
    pub spacing: f64,
    /// Distance of the cutter's axis from that of the spindle, mm.
    pub runout: f64,
    /// Direction of that from tooth 0, rad.
    pub runout_angle: f64,
    /// How much farther out each tooth stands, mm; one for each flute.
    pub tooth_runout: Vec<f64>,
    /// Angle of tooth 0 from the first feed direction when the path starts, rad.
    pub spindle_phase: f64,
    /// Which cells the grid has.
    pub cells: TextureCells,
}
