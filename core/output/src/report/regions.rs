//! What is reported of a divided surface.

use serde::Serialize;

/// A divided surface.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct DivisionFigures {
    /// How it was divided.
    pub method: String,
    /// Number of regions.
    pub count: u64,
    /// Least uniformity of a region's own flat map: its 5th percentile of stretch over its 95th.
    pub uniformity_min: f64,
    /// Mean uniformity of the regions, by area.
    pub uniformity_mean: f64,
    /// Distances between neighbouring passes.
    pub spacing: SpacingFigures,
    /// Length of the passes' contacts on the surface, mm.
    pub length_mm: f64,
    /// The same surface in one piece, with one flat stepover for the largest stretch of its map.
    pub undivided: UndividedFigures,
    /// The regions in the order of machining.
    pub pieces: Vec<PieceFigures>,
}

/// Distances between neighbouring passes as parts of the side step allowed there, by area; where
/// fronts meet apart.
#[derive(Copy, Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct SpacingFigures {
    /// Mean.
    pub mean: f64,
    /// Standard deviation.
    pub deviation: f64,
    /// Largest.
    pub max: f64,
}

/// A surface in one piece.
#[derive(Copy, Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct UndividedFigures {
    /// Uniformity of its flat map.
    pub uniformity: f64,
    /// Smallest stretch, mm on the surface per flat mm.
    pub stretch_min: f64,
    /// Largest stretch.
    pub stretch_max: f64,
    /// Distances between neighbouring passes.
    pub spacing: SpacingFigures,
    /// Length of the passes, mm: the area's integral of one over their distance.
    pub length_mm: f64,
}

/// A region.
#[derive(Copy, Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct PieceFigures {
    /// Area, mm².
    pub area_mm2: f64,
    /// Uniformity of its own flat map.
    pub uniformity: f64,
    /// Smallest stretch of that map, mm on the surface per flat mm.
    pub stretch_min: f64,
    /// Largest stretch.
    pub stretch_max: f64,
    /// Number of passes.
    pub passes: u64,
    /// Length of the passes' contacts on the surface, mm.
    pub length_mm: f64,
    /// Distances between neighbouring passes.
    pub spacing: SpacingFigures,
}
