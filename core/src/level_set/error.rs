//! Why passes cannot be laid out.

use thiserror::Error;

/// Why passes cannot be laid out.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum LevelSetError {
    /// The mesh would need too many triangles.
    #[error(
        "passes: with a side step of {side_step:.4} mm they would need a mesh of more than {limit} triangles; \
         choose a larger cut.stepover or cut.scallop, or machine a smaller part"
    )]
    TooFine {
        /// Typical requested side step, mm.
        side_step: f64,
        /// Largest number of triangles.
        limit: usize,
    },
    /// Its triangles would have to be divided into too many.
    #[error(
        "passes: the surface has long, thin triangles, which would have to be divided into more than {limit}; remesh it \
         with triangles about as long as wide, or machine it as a part with surface.steepest"
    )]
    Needles {
        /// Largest number of triangles.
        limit: usize,
    },
    /// The surface is too small for a ring.
    #[error(
        "rings: the surface is only {passes:.3} side steps wide from its boundary to its middle; \
         check the unit and surface.scale, or choose a smaller cut.stepover or cut.scallop"
    )]
    TooSmall {
        /// Largest distance from the boundary, passes.
        passes: f64,
    },
    /// The passes are not level curves.
    #[error("passes: the pattern hub lies between blades; give them in [hub]")]
    NeedsBlades,
    /// The start curve does not cross the surface.
    #[error(
        "passes: the start curve crosses no face of the surface; give path.curve points near it"
    )]
    NoCurve,
    /// The surface is closed in the requested parameter.
    #[error(
        "passes: the surface is closed in that parameter, so passes along the other one would \
         jump at the seam; choose the other path.along, or another path.pattern"
    )]
    ClosedParameter,
    /// Passes along the level curves of this function would lie much too close together.
    #[error(
        "passes: {passes:.0} passes would be needed, because in places they would be much closer \
         together than the side step; choose another path.pattern, path.angle or path.along"
    )]
    Uneven {
        /// Passes needed.
        passes: f64,
    },
    /// The cutter fits nowhere between the walls.
    #[error(
        "rings: path.boundary = \"wall\", and the cutter, of {radius:.3} mm radius, does not fit between the walls: \
         at the widest place there is room for {widest:.3} mm radius; use a smaller cutter or path.boundary = \"open\""
    )]
    NoRoom {
        /// Cutter radius, mm.
        radius: f64,
        /// Radius for which there is room at the widest place, mm.
        widest: f64,
    },
}
