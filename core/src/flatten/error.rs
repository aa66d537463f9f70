//! Why a surface cannot be flattened.

use thiserror::Error;

use crate::geometry::{DVec2, DVec3};

/// Why a surface cannot be flattened, or its flat image not be used.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum FlattenError {
    /// Flattening needs a topological disk, possibly with holes.
    #[error(
        "flatten: {loops} boundary loops, Euler characteristic {chi}; a disk has 1 and 1, with \
         every hole one more and one less: select one open piece without handles"
    )]
    NotADisk {
        /// Boundary loops found.
        loops: usize,
        /// Euler characteristic found.
        chi: i64,
    },
    /// A face without area has no angles.
    #[error(
        "flatten: face {face} at ({:.3}, {:.3}, {:.3}) has no area; every face needs a positive \
         one: remove the face, or machine the part with surface.steepest", at.x, at.y, at.z
    )]
    Degenerate {
        /// The face.
        face: u32,
        /// Its first corner, mm.
        at: DVec3,
    },
    /// The linear system broke down.
    #[error(
        "flatten: the {system} system is not positive definite near ({:.3}, {:.3}, {:.3}); it is \
         for a connected mesh of well-shaped faces: remesh there", at.x, at.y, at.z
    )]
    Singular {
        /// Which system.
        system: &'static str,
        /// Vertex at which the factorisation stopped, mm.
        at: DVec3,
    },
    /// The angle-based iteration did not reach its constraints.
    #[error(
        "flatten: the angle constraints are off by {residual:.2e} rad after {steps} steps; \
         {limit:.0e} is required: use flatten.method \"bff\""
    )]
    NotConverged {
        /// Largest constraint residual, rad.
        residual: f64,
        /// Steps taken.
        steps: usize,
        /// Largest residual accepted, rad.
        limit: f64,
    },
    /// Faces are turned over in the plane.
    #[error(
        "flatten: {count} of the flat faces are turned over, for example face {face} at \
         ({:.3}, {:.3}, {:.3}); none may be: split the surface there or remesh it", at.x, at.y, at.z
    )]
    Flipped {
        /// How many faces.
        count: usize,
        /// One of them.
        face: u32,
        /// Its centre on the surface, mm.
        at: DVec3,
    },
    /// Two parts of the flat boundary cross.
    #[error(
        "flatten: the flat boundary crosses itself at u {:.3}, v {:.3}, on the surface near \
         ({:.3}, {:.3}, {:.3}); it must not: split the surface there", uv.x, uv.y, at.x, at.y, at.z
    )]
    Overlap {
        /// A place where it crosses, flat mm.
        uv: DVec2,
        /// A boundary vertex there, mm.
        at: DVec3,
    },
}

/// A flat point that lies outside the chart.
#[derive(Copy, Clone, Debug, PartialEq, Error)]
#[error(
    "flatten: the flat point u {:.6}, v {:.6} lies outside the chart; paths must stay inside its \
     boundary: clip them to it", uv.x, uv.y
)]
pub struct OutsideChart {
    /// The point, flat mm.
    pub uv: DVec2,
}
