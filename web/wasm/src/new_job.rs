//! A job for a surface.

use evencut_service::new_job::contents;

use crate::fault::Failure;

/// A commented job file for a surface file. `name`: the surface file's.
///
/// # Errors
/// A message, if the file holds no usable surface.
pub fn new_job(name: &str, bytes: &[u8]) -> Result<String, Failure> {
    let contents = contents(name, bytes, 1.0).map_err(Failure::Message)?;
    Ok(contents.job(name))
}
