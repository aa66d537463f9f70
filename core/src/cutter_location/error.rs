//! Why a pass has no cutter locations.

use thiserror::Error;

use crate::geometry::DVec3;

/// Why a pass has no cutter locations.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum LocateError {
    /// The surface faces away from the tool.
    #[error(
        "locate: {count} of {total} contacts face away from the tool, first at ({:.3}, {:.3}, {:.3}), where the normal is {degrees:.1} degrees from the axis; it must be below 90: exclude these faces, turn the part (surface.rotate), turn its sides (surface.flip), machine in five axes, or machine what can be reached from above (surface.steepest)",
        place.x, place.y, place.z
    )]
    BelowHorizon {
        /// How many contacts.
        count: usize,
        /// Of how many.
        total: usize,
        /// The first of them, mm.
        place: DVec3,
        /// Angle between normal and axis there, degrees.
        degrees: f64,
    },
    /// An invalid contact.
    #[error(
        "locate: contact {index} at ({:.3}, {:.3}, {:.3}) has a position, unit normal, feed direction or feed that is not finite",
        place.x, place.y, place.z
    )]
    NotFinite {
        /// Its index.
        index: usize,
        /// Its position, mm.
        place: DVec3,
    },
}
