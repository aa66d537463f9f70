//! The planner for a page: decode, call, encode.
//!
//! Faults are reported in the words of the command, and files have its bytes. All calls run to their
//! end; a page calls from a worker and ends that to cancel.

mod editor;
mod fault;
mod plan;
mod tables;
mod texture;

use evencut_core::job;
use evencut_core::mesh::{MeshFormat, read};
use evencut_core::surface::Inspection;
use evencut_service::new_job::facts;
use wasm_bindgen::prelude::wasm_bindgen;

#[wasm_bindgen]
extern "C" {
    /// Given by the worker: takes the message of a panic before the module ends.
    #[wasm_bindgen(js_name = evencutPanicked)]
    fn panicked(message: &str);
}

/// Sends messages of panics to the worker.
#[wasm_bindgen(start)]
pub fn start() {
    std::panic::set_hook(Box::new(|panic| panicked(&panic.to_string())));
}

/// What may be written at a place of a job, as JSON: `from`, where the begun word stands, and `options` with `text`,
/// `kind` (`table`, `key` or `value`), `unit` and `about`. Places are UTF-16 units from the start.
#[wasm_bindgen]
pub fn completions(source: &str, at: usize) -> String {
    editor::completions(source, at).to_string()
}

/// What the key means that ends at a place of a job, as JSON: `key`, `about` and `expected`; null where there is none.
#[wasm_bindgen]
pub fn explanation(source: &str, at: usize) -> String {
    editor::explanation(source, at).to_string()
}

/// What is wrong with a job, as JSON: `faults`, the names of the `surface` file and of the `wall` file, if any, and the
/// `name` of the job; all null where the job cannot be read.
///
/// `surfaces`: names of the meshes that are there.
#[wasm_bindgen]
pub fn check(source: &str, surfaces: Vec<String>) -> String {
    fault::check(source, &surfaces).to_string()
}

/// A commented job file for a surface file.
///
/// # Errors
/// A message, if the file holds no usable surface.
#[wasm_bindgen(js_name = newJob)]
pub fn new_job(name: &str, bytes: &[u8]) -> Result<String, String> {
    let format = MeshFormat::from_name(name)
        .ok_or("surface: the format is not known; the name must end in .stl, .obj, .ply or .off")?;
    let mesh = read(bytes, format).map_err(|error| error.to_string())?;
    let inspection = Inspection::new(mesh).map_err(|error| error.to_string())?;
    Ok(job::template(name, &facts(&inspection)))
}
