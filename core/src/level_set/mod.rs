//! Passes as level sets of a field on the surface.
//!
//! - *Strip metric*: lengths measured in passes; one side step is one unit.
//! - *Field*: a value at the vertices of a refined mesh that grows by at least 1 per pass: the distance from the
//!   boundary or from a curve in that metric, or another function scaled (*paced*) to do so.
//! - *Pass*: a level curve in the flat plane, closed (a *ring*) or open; its *level* is the value of the field on it.
//! - *Branch*: a detour of a pass, out and back, where fronts meet and the passes alone would leave a place farther
//!   than half a pass from any of them.
//!
//! Source: Kim 2001 and 2007 for the metric; Kimmel and Sethian 1998 for the distance on a triangle mesh.

mod bend;
mod beyond;
mod closing;
mod error;
mod field;
mod front;
mod passes;
mod refine;
pub mod strip_metric;
mod terrain;
mod thin;

pub use closing::{ClosingOptions, ClosingReport, Gap, close, uncovered};
pub use error::LevelSetError;
pub use field::{PassField, length_floor, length_floor_of};
pub use front::Accuracy;
pub(crate) use passes::shortened;
pub use passes::{Branch, INSIDE, Outermost, Pass, half_levels, open_levels, passes, ring_levels};
pub use refine::PassMesh;
pub use strip_metric::StripMetric;
pub use terrain::FieldTerrain;
