//! Mesh files from bytes: STL, OBJ, PLY, OFF → [`TriangleSoup`].
//!
//! A header's counts are held against the bytes present before anything is allocated, and every
//! fault is reported with its line or byte offset.

mod obj;
mod off;
mod ply;
mod polygon;
mod stl;
mod text;

use std::fmt;

use thiserror::Error;

use super::TriangleSoup;
use crate::geometry::DVec3;

/// A kind of mesh file.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum MeshFormat {
    /// Stereolithography, binary or ASCII.
    Stl,
    /// Wavefront OBJ.
    Obj,
    /// Polygon file format, ASCII or binary of either byte order.
    Ply,
    /// Object file format, ASCII.
    Off,
}

impl MeshFormat {
    /// The format that a file name's extension says, in any case; `None` for any other extension.
    pub fn from_name(name: &str) -> Option<Self> {
        let (_, extension) = name.rsplit_once('.')?;
        match extension.to_ascii_lowercase().as_str() {
            "stl" => Some(Self::Stl),
            "obj" => Some(Self::Obj),
            "ply" => Some(Self::Ply),
            "off" => Some(Self::Off),
            _ => None,
        }
    }
}

impl fmt::Display for MeshFormat {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Stl => "STL",
            Self::Obj => "OBJ",
            Self::Ply => "PLY",
            Self::Off => "OFF",
        })
    }
}

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

/// Reads a mesh file.
///
/// Coordinates stay in the file's units. Polygons are cut into triangles. Memory stays within a
/// small multiple of `bytes.len()`, whatever the header says.
///
/// # Errors
/// [`ReadError`] if the bytes are not a complete file of that format with at least one face, or
/// if a coordinate is not a finite number.
pub fn read(bytes: &[u8], format: MeshFormat) -> Result<TriangleSoup, ReadError> {
    let whole = |found: String, expected: &str| ReadError {
        format,
        place: Place::Whole,
        found,
        expected: expected.into(),
    };
    if bytes.is_empty() {
        return Err(whole("an empty file (0 bytes)".into(), "a mesh with at least one face"));
    }
    if bytes.starts_with(&[0xfe, 0xff]) || bytes.starts_with(&[0xff, 0xfe]) {
        return Err(whole("UTF-16 text".into(), "plain ASCII or UTF-8: save the file as UTF-8"));
    }
    let soup = match format {
        MeshFormat::Stl => stl::read(bytes),
        MeshFormat::Obj => obj::read(bytes),
        MeshFormat::Ply => ply::read(bytes),
        MeshFormat::Off => off::read(bytes),
    }?;
    if soup.faces.is_empty() {
        let found = format!("{} vertices and no face", soup.positions.len());
        return Err(whole(found, "at least one face"));
    }
    Ok(soup)
}

/// Number of vertices as an index type, or an error: indices are 32-bit.
fn check_vertex_count(
    format: MeshFormat,
    place: Place,
    vertices: usize,
) -> Result<usize, ReadError> {
    if vertices < u32::MAX as usize {
        return Ok(vertices);
    }
    Err(ReadError {
        format,
        place,
        found: format!("{vertices} vertices"),
        expected: format!("fewer than {}", u32::MAX),
    })
}

/// The position, or what is wrong with it.
fn finite(position: DVec3) -> Result<DVec3, String> {
    if position.is_finite() {
        return Ok(position);
    }
    Err(format!("the coordinates ({}, {}, {})", position.x, position.y, position.z))
}
