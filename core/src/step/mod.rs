//! STEP files (AP203, AP214, AP242): their faces as NURBS surfaces with trimming loops.
//!
//! Steps: the text becomes instances (`part21`); faces are found through their shells, their
//! surfaces become NURBS surfaces, elementary ones included (`model`); the curves of their edges (`edge`)
//! are projected to the parameters and become trimming loops (`trim`).
//!
//! # Source
//! ISO 10303-21 (text), ISO 10303-42 (geometry and topology).

mod edge;
mod error;
mod face;
mod file;
mod load;
mod model;
mod part21;
#[cfg(test)]
mod tests;
mod trim;

pub use error::StepError;
pub use face::StepFace;
pub use file::{FaceMesh, StepFile, together};
pub use load::{SmoothError, SmoothFormat, smooth};
