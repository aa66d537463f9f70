//! What vertices of every format must keep to: indices of 32 bits, finite coordinates.

use super::error::{Place, ReadError};
use super::format::MeshFormat;
use crate::geometry::{DVec3, Shown};

/// Number of vertices as an index type, or an error: indices are 32-bit.
pub(super) fn check_vertex_count(
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
pub(super) fn finite(position: DVec3) -> Result<DVec3, String> {
    if position.is_finite() {
        return Ok(position);
    }
    let [x, y, z] = position.to_array().map(Shown);
    Err(format!("the coordinates ({x}, {y}, {z})"))
}
