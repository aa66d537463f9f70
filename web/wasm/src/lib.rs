//! The planner for a page: decode, call, encode.
//!
//! It answers a page's requests in a worker. Faults are reported in the words of the command, and files have its bytes.
//! All requests run to their end; a page ends the worker to cancel.

mod answer;
mod editor;
mod fault;
mod new_job;
mod plan;
mod request;
mod tables;
mod texture;
mod worker;

use wasm_bindgen::prelude::wasm_bindgen;

/// Answers the page's requests from now on. Called as soon as the module is loaded, which must be in a worker.
#[wasm_bindgen(start)]
pub fn start() {
    worker::start();
}
