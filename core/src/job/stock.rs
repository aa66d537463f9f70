//! The material before the first operation.

use crate::geometry::DVec3;

/// Where the material ends.
#[derive(Clone, Debug, PartialEq)]
pub enum StockShape {
    /// A box between two corners, the least first, mm.
    Box([DVec3; 2]),
    /// A mesh in a file, relative to the job file; placed as the surface's file is.
    File(String),
}
