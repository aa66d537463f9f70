//! Libraries: files from which a job takes its tool by number or by name.
//!
//! Terms: an *entry* is a tool of a library, as a `[tool]` table of its own unit; it is *refused* where evencut has no
//! such cutter, or the file does not say enough.
//!
//! 1. The format shows in the content: evencut's own (`own`), FreeCAD's (`freecad`), Fusion's (`fusion`). Each reader makes
//!    entries of it (`read`).
//! 2. The job's name or number chooses one (`choose`).
//! 3. What the job does not give itself is filled in from it (`take`), and goes through the rules of the job's own keys.

mod choose;
mod entry;
mod error;
mod freecad;
mod fusion;
mod json;
mod own;
mod read;
mod take;

pub use entry::LibraryTool;
pub use error::LibraryError;
pub use read::ToolLibrary;
pub(super) use take::take;

#[cfg(test)]
mod tests;
