//! The bytes of a library → its tools.

use super::entry::LibraryTool;
use super::{freecad, fusion, own};
use serde_json::Value;
use thiserror::Error;

/// Largest library that is read, bytes. Real ones have some kilobytes a tool; JSON takes up to thirty times its length
/// once it is read.
const LARGEST: usize = 8 << 20;
/// Longest message of another reader, characters.
const LONGEST_MESSAGE: usize = 300;

/// Why a library cannot be read.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum LibraryError {
    /// It is too large.
    #[error("{bytes} bytes; a library of tools has at most {LARGEST}: export fewer tools")]
    Large {
        /// How many it has.
        bytes: usize,
    },
    /// It is packed.
    #[error("it is packed (zip), as Fusion's .tools files are: unpack it and give its tools.json")]
    Packed,
    /// It is no text.
    #[error("it is no text (UTF-8)")]
    NotText,
    /// It is neither JSON nor TOML, or not as libraries have it.
    #[error("{0}")]
    Syntax(String),
    /// JSON of something else.
    #[error(
        "it is JSON, but neither a library of Fusion (`data`) nor a bit (`shape`, `parameter`) or a list (`tools`) of FreeCAD"
    )]
    UnknownJson,
    /// It is empty.
    #[error("it holds no tools")]
    Empty,
}

/// A library of tools.
#[derive(Clone, Debug, PartialEq)]
pub struct ToolLibrary {
    /// Its tools, in the order of the file; at least one.
    pub tools: Vec<LibraryTool>,
}

impl ToolLibrary {
    /// Reads a library; its content shows the format. `bytes`: at most 8 MiB.
    ///
    /// # Errors
    /// [`LibraryError`] where it is no library. A tool that cannot be used is no error, but has a reason.
    pub fn read(bytes: &[u8]) -> Result<Self, LibraryError> {
        if bytes.len() > LARGEST {
            return Err(LibraryError::Large { bytes: bytes.len() });
        }
        if bytes.starts_with(b"PK\x03\x04") {
            return Err(LibraryError::Packed);
        }
        let text = core::str::from_utf8(bytes).map_err(|_| LibraryError::NotText)?;
        let text = text.trim_start_matches('\u{feff}');
        let short =
            |message: String| LibraryError::Syntax(message.chars().take(LONGEST_MESSAGE).collect());
        let tools = if text.trim_start().starts_with('{') {
            let json = serde_json::from_str(text).map_err(|e| short(format!("no JSON: {e}")))?;
            of_json(&json).ok_or(LibraryError::UnknownJson)?
        } else {
            own::read(text).map_err(short)?
        };
        if tools.is_empty() {
            return Err(LibraryError::Empty);
        }
        Ok(Self { tools })
    }
}

fn of_json(json: &Value) -> Option<Vec<LibraryTool>> {
    if let Some(data) = json["data"].as_array() {
        return Some(fusion::read(data));
    }
    if let Some(tools) = json["tools"].as_array() {
        return Some(freecad::read_list(tools));
    }
    let is_bit = json["shape"].is_string() && json["parameter"].is_object();
    is_bit.then(|| vec![freecad::read_bit(json)])
}
