//! A job for a surface.

use evencut_core::job;
use evencut_core::mesh::{MeshFormat, read};
use evencut_core::surface::Inspection;
use evencut_service::new_job::facts;

use crate::fault::Failure;

/// A commented job file for a surface file. `name`: the surface file's.
///
/// # Errors
/// A message, if the file holds no usable surface.
pub fn new_job(name: &str, bytes: &[u8]) -> Result<String, Failure> {
    let format = MeshFormat::from_name(name).ok_or_else(|| {
        let known = "the name must end in .stl, .obj, .ply or .off";
        Failure::Message(format!("surface: the format is not known; {known}"))
    })?;
    let mesh = read(bytes, format).map_err(|error| Failure::Message(error.to_string()))?;
    let inspection = Inspection::new(mesh).map_err(|error| Failure::Message(error.to_string()))?;
    Ok(job::template(name, &facts(&inspection)))
}
