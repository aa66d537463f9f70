//! NURBS surfaces: evaluation, nearest point, and triangles that keep their parameters.
//!
//! A surface ([`NurbsSurface`]) maps its parameters u and v to space. What is machined is a piece
//! of it ([`Trim`]): a rectangle of parameters or what trimming loops bound. [`mesh()`] makes
//! triangles of it whose corners know their parameters, so that position, normal and curvature
//! stay exact between the vertices.

mod basis;
mod curve;
mod degree;
mod domain;
mod error;
mod json;
mod mesh;
mod metric;
mod refine;
mod sizing;
mod start;
mod surface;
#[cfg(test)]
mod tests;

pub(crate) use basis::Knots;
pub use curve::NurbsCurve;
pub use degree::LARGEST_DEGREE;
pub use domain::TrimLoop;
pub use error::{Direction, NurbsError};
pub use json::{NurbsFile, read_json};
pub use mesh::{MeshOptions, NurbsMesh, Trim, mesh};
pub(crate) use surface::Piece;
pub use surface::{Jet, NurbsParts, NurbsSurface};
