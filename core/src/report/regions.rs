//! What is told of a divided surface.

use crate::regions::{Divided, Evenness, Spacing};
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

impl SpacingFigures {
    fn of(spacing: &Spacing) -> Self {
        Self { mean: spacing.mean, deviation: spacing.deviation(), max: spacing.most }
    }
}

impl DivisionFigures {
    /// Of a divided surface; `lengths`: of the passes of every region in the order of machining, mm.
    pub fn of(divided: &Divided, method: &str, lengths: &[f64]) -> Self {
        let piece = |(part, &length): (&crate::regions::PartFigures, &f64)| {
            let Evenness { uniformity, least, most } = part.evenness;
            PieceFigures {
                area_mm2: part.area,
                uniformity,
                stretch_min: least,
                stretch_max: most,
                passes: part.passes as u64,
                length_mm: length,
                spacing: SpacingFigures::of(&part.spacing),
            }
        };
        let pieces: Vec<PieceFigures> = divided.parts.iter().zip(lengths).map(piece).collect();
        let area: f64 = pieces.iter().map(|p| p.area_mm2).sum();
        let whole = &divided.undivided;
        Self {
            method: method.into(),
            count: pieces.len() as u64,
            uniformity_min: pieces.iter().map(|p| p.uniformity).fold(1.0, f64::min),
            uniformity_mean: pieces.iter().map(|p| p.area_mm2 * p.uniformity).sum::<f64>() / area,
            spacing: SpacingFigures::of(&divided.spacing()),
            length_mm: lengths.iter().sum(),
            undivided: UndividedFigures {
                uniformity: whole.evenness.uniformity,
                stretch_min: whole.evenness.least,
                stretch_max: whole.evenness.most,
                spacing: SpacingFigures::of(&whole.spacing),
                length_mm: whole.length,
            },
            pieces,
        }
    }
}
