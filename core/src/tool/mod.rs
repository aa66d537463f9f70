//! The cutter, and what turns with it.

mod assembly;
mod cutter;

pub use assembly::{Assembly, AssemblyPart, Section};
pub use cutter::{Tool, ToolError, ToolKind};
