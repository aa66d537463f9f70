//! What is wrong with a mesh file, and where.

use std::fmt;

use thiserror::Error;

use super::format::MeshFormat;

/// Where in a file.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum Place {
    /// The file as a whole.
    Whole,
    /// A line of a text file, from 1.
    Line(usize),
    /// A byte of a binary file, from 0.
    Byte(usize),
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Whole => f.write_str("whole file"),
            Self::Line(line) => write!(f, "line {line}"),
            Self::Byte(byte) => write!(f, "byte {byte}"),
        }
    }
}

/// Why a file is not the mesh it claims to be.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("mesh: {format} file, {place}: found {found}; expected {expected}")]
pub struct ReadError {
    /// Format the file was read as.
    pub format: MeshFormat,
    /// Where.
    pub place: Place,
    /// What is there.
    pub found: String,
    /// What should be there.
    pub expected: String,
}
