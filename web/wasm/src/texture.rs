//! The texture of a window for a page.

use evencut_core::geometry::DVec3;
use evencut_core::job::TextureOptions;
use evencut_core::toolpath::Toolpath;
use evencut_service::faults;
use evencut_service::results::texture::{TextureResults, texture_of_path};

use crate::fault::Failure;
use crate::request::JobFiles;

/// Simulates what the teeth leave of a planned path about a place of its surface.
///
/// `given`: the job that was planned, whose `[texture]` tells the rest of the window if it has one; `path`: its
/// toolpath.csv; `at`: the place, mm.
///
/// # Errors
/// The fault.
pub fn texture(given: &JobFiles, path: &[u8], at: [f64; 3]) -> Result<TextureResults, Failure> {
    let mut job = given.job()?;
    let at = DVec3::from_array(at);
    job.texture = Some(match job.texture.take() {
        Some(window) => TextureOptions { at, whole: false, ..window },
        None => TextureOptions::about(at, &job),
    });
    let path = Toolpath::from_csv(&String::from_utf8_lossy(path))
        .map_err(|failed| given.fault(&faults::fault(failed.to_string(), None)))?;
    texture_of_path(&job, given.named(), &path, 1, &mut |_, _| {})
        .map_err(|error| given.failure(&job, &error))
}
