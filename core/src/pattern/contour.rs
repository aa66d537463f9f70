//! Contour passes: parallel to the boundary, or to where the cutter touches the walls on it.

use crate::level_set::{LevelSetError, PassField, PassMesh};

/// The distance from the boundary; between walls, from where a cutter of `radius` mm touches them: `clearance` of it at
/// every vertex, mm.
///
/// # Errors
/// [`LevelSetError`]: the cutter fits nowhere between the walls.
pub fn from_boundary(
    mesh: &PassMesh,
    clearance: Option<&[f64]>,
    radius: f64,
) -> Result<PassField, LevelSetError> {
    match clearance {
        None => Ok(PassField::from_boundary(mesh)),
        Some(clearance) => PassField::from_clearance(mesh, clearance, radius),
    }
}
