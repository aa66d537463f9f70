//! The bytes of a library → its tools.

use super::entry::LibraryTool;
use super::error::{LARGEST, LARGEST_TOML, LibraryError};
use super::{freecad, fusion, own};
use serde_json::Value;

/// A library of tools.
#[derive(Clone, Debug, PartialEq)]
pub struct ToolLibrary {
    /// Its tools, in the order of the file; at least one.
    pub tools: Vec<LibraryTool>,
}

impl ToolLibrary {
    /// Reads a library; its content shows the format. `bytes`: at most 8 MiB, of TOML 1 MiB.
    ///
    /// # Errors
    /// [`LibraryError`] where it is no library. A tool that cannot be used is no error, but has a reason.
    pub fn read(bytes: &[u8]) -> Result<Self, LibraryError> {
        bounded(bytes.len(), LARGEST)?;
        if bytes.starts_with(b"PK\x03\x04") {
            return Err(LibraryError::Packed);
        }
        let text = core::str::from_utf8(bytes).map_err(|_| LibraryError::NotText)?;
        let text = text.trim_start_matches('\u{feff}');
        let tools = if text.trim_start().starts_with('{') {
            let json = serde_json::from_str(text)
                .map_err(|error| LibraryError::syntax(&format!("no JSON: {error}")))?;
            of_json(&json)?
        } else {
            bounded(bytes.len(), LARGEST_TOML)?;
            own::read(text)?
        };
        if tools.is_empty() {
            return Err(LibraryError::Empty);
        }
        Ok(Self { tools })
    }
}

fn bounded(bytes: usize, most: usize) -> Result<(), LibraryError> {
    if bytes > most { Err(LibraryError::Large { bytes, most }) } else { Ok(()) }
}

fn of_json(json: &Value) -> Result<Vec<LibraryTool>, LibraryError> {
    if let Some(data) = json["data"].as_array() {
        LibraryError::unless_few(data.len())?;
        return Ok(fusion::read(data));
    }
    if let Some(tools) = json["tools"].as_array() {
        LibraryError::unless_few(tools.len())?;
        return Ok(freecad::read_list(tools));
    }
    match json["shape"].is_string() && json["parameter"].is_object() {
        true => Ok(vec![freecad::read_bit(json)]),
        false => Err(LibraryError::UnknownJson),
    }
}
