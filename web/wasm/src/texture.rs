//! The texture of a window for a page.

use evencut_core::geometry::DVec3;
use evencut_core::job::{self, Fault, Severity, SurfaceSource, TextureOptions};
use evencut_core::plan::Files;
use evencut_core::toolpath::Toolpath;
use evencut_service::results::texture::{TextureResults, texture_of_path};
use evencut_service::{failure, faults};
use js_sys::Uint8Array;
use wasm_bindgen::prelude::wasm_bindgen;

use crate::fault;

/// A simulated window: its files and what is reported of it.
#[wasm_bindgen]
pub struct Texture(TextureResults);

/// Simulates what the teeth leave of a planned path about a place of its surface.
///
/// `source`: the job that was planned, whose `[texture]` tells the rest of the window if it has one; `path`: its
/// toolpath.csv; `at`: the place, mm; the others as of [`plan`](crate::plan::plan).
///
/// # Errors
/// The fault, as JSON.
#[wasm_bindgen]
pub fn texture(
    source: &str,
    surface: Option<Vec<u8>>,
    wall: Option<Vec<u8>>,
    path: &str,
    at: Vec<f64>,
) -> Result<Texture, String> {
    let bytes = source.as_bytes();
    let error = |fault: &Fault| fault::as_json(fault, Severity::Error, source).to_string();
    let mut job = match job::read(bytes) {
        Ok(resolved) => resolved.job,
        Err(faults) => return Err(faults.0.first().map(error).unwrap_or_default()),
    };
    let failed_with = |message: String| error(&faults::fault(message, None));
    let [x, y, z] = at[..] else { return Err(failed_with("a place has three coordinates".into())) };
    let at = DVec3::new(x, y, z);
    job.texture = Some(match job.texture.take() {
        Some(window) => TextureOptions { at, whole: false, ..window },
        None => TextureOptions::about(at, &job),
    });
    let path = Toolpath::from_csv(path).map_err(|failed| failed_with(failed.to_string()))?;
    let file = match &job.surface.source {
        SurfaceSource::File(file) => Some(file.as_str()),
        SurfaceSource::Analytic(_) => None,
    };
    let files = Files { surface: surface.as_deref(), wall: wall.as_deref() };
    match texture_of_path(&job, files, &path, 1, &mut |_, _| {}) {
        Ok(results) => Ok(Texture(results)),
        Err(failed) => Err(error(&failure::explain(&failed, bytes, file).1)),
    }
}

#[wasm_bindgen]
impl Texture {
    /// Names of the files.
    pub fn names(&self) -> Vec<String> {
        self.0.files.iter().map(|file| file.name.clone()).collect()
    }

    /// Content of a file; empty if there is no such file.
    pub fn file(&self, name: &str) -> Uint8Array {
        let file = self.0.files.iter().find(|file| file.name == name);
        Uint8Array::from(file.map_or(&[][..], |file| &file.bytes))
    }

    /// What the command prints.
    pub fn summary(&self) -> String {
        self.0.figures.summary()
    }
}
