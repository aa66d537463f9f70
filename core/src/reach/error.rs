//! Why a part cannot be reached.

use thiserror::Error;

/// Why there is no reached surface.
#[derive(Copy, Clone, Debug, PartialEq, Error)]
pub enum ReachError {
    /// Nothing to be machined is in sight from above.
    #[error(
        "surface: nothing of what is selected can be machined from +Z: {:.3} mm² face away or are steeper than \
         {steepest:.1} degrees, {:.3} mm² lie under something else; turn the part with surface.rotate, or an \
         open one over with surface.flip",
        away,
        shadowed
    )]
    Nothing {
        /// Area that faces away or is too steep, mm².
        away: f64,
        /// Area in the shadow of something, mm².
        shadowed: f64,
        /// Steepest slope that is machined, degrees.
        steepest: f64,
    },
    /// The part has too many details for the tolerance.
    #[error(
        "surface: what the cutter reaches of the part takes more than {most} heights within {accuracy:.4} mm; choose a \
         larger cut.tolerance, or a part of the surface by surface.select"
    )]
    TooFine {
        /// Greatest number of heights.
        most: usize,
        /// How far the surface may be off, mm.
        accuracy: f64,
    },
}
