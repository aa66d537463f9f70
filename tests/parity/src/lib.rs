//! Core as a WebAssembly module with plain functions, for the test that its results have the
//! same bytes as the native ones.
//!
//! The caller allocates blocks, fills them with the inputs, calls [`plan`], and reads the files.

use std::cell::RefCell;

use evencut_core::job::{self, SurfaceSource};
use evencut_core::plan::Files;
use evencut_service::results::{Input, OutputFile, ResultsOptions, operations_results, results};

thread_local! {
    static BLOCKS: RefCell<Vec<Vec<u8>>> = const { RefCell::new(Vec::new()) };
    static FILES: RefCell<Vec<OutputFile>> = const { RefCell::new(Vec::new()) };
}

/// Allocates the next block, of `length` bytes, and returns its address.
///
/// The blocks of a run are, in order: name and content of the job file, content of the surface.
// SAFETY: the only function of this name in the module.
#[unsafe(no_mangle)]
pub extern "C" fn allocate(length: usize) -> *mut u8 {
    BLOCKS.with_borrow_mut(|blocks| {
        blocks.push(vec![0; length]);
        // The block does not move when the list of blocks grows.
        blocks.last_mut().map_or(std::ptr::null_mut(), |block| block.as_mut_ptr())
    })
}

/// Plans from the blocks and frees them. Returns the number of files; on failure 0, and file 0
/// holds the message.
// SAFETY: the only function of this name in the module.
#[unsafe(no_mangle)]
pub extern "C" fn plan() -> usize {
    let blocks = BLOCKS.take();
    match files(&blocks) {
        Ok(files) => {
            let count = files.len();
            FILES.set(files);
            count
        }
        Err(message) => {
            FILES.set(vec![OutputFile { name: "error".into(), bytes: message.into_bytes() }]);
            0
        }
    }
}

fn files(blocks: &[Vec<u8>]) -> Result<Vec<OutputFile>, String> {
    let [name, source, surface, blades @ ..] = blocks else {
        return Err("three blocks are needed, and two for each blade".into());
    };
    let blade =
        |pair: &[Vec<u8>; 2]| (String::from_utf8_lossy(&pair[0]).into_owned(), pair[1].clone());
    let blades: Vec<(String, Vec<u8>)> = blades.as_chunks().0.iter().map(blade).collect();
    let name = std::str::from_utf8(name).map_err(|e| e.to_string())?;
    let resolved = job::read(source).map_err(|faults| faults.render(name, source))?;
    let job = &resolved.job;
    let surface = match &job.surface.source {
        SurfaceSource::File(_) => Some(&surface[..]),
        SurfaceSource::Analytic(_) => None,
    };
    let job_file = Input { name, bytes: source };
    let files = Files { blades: &blades, ..Files::of_surface(surface) };
    let options = ResultsOptions { threads: 1, verify: true };
    if !resolved.operations.is_empty() {
        let results = operations_results(&resolved, job_file, files, options, &mut |_, _, _| {});
        return Ok(results.map_err(|e| e.error.to_string())?.files);
    }
    let results = results(job, job_file, files, options, &mut |_, _| {});
    Ok(results.map_err(|e| e.to_string())?.files)
}

fn part(index: usize, of: fn(&OutputFile) -> &[u8]) -> (*const u8, usize) {
    FILES.with_borrow(|files| {
        files.get(index).map_or((std::ptr::null(), 0), |file| (of(file).as_ptr(), of(file).len()))
    })
}

fn name(file: &OutputFile) -> &[u8] {
    file.name.as_bytes()
}

fn content(file: &OutputFile) -> &[u8] {
    &file.bytes
}

/// Address of the name of a file.
// SAFETY: the only function of this name in the module.
#[unsafe(no_mangle)]
pub extern "C" fn name_address(index: usize) -> *const u8 {
    part(index, name).0
}

/// Length of the name of a file, bytes.
// SAFETY: the only function of this name in the module.
#[unsafe(no_mangle)]
pub extern "C" fn name_length(index: usize) -> usize {
    part(index, name).1
}

/// Address of the content of a file.
// SAFETY: the only function of this name in the module.
#[unsafe(no_mangle)]
pub extern "C" fn content_address(index: usize) -> *const u8 {
    part(index, content).0
}

/// Length of the content of a file, bytes.
// SAFETY: the only function of this name in the module.
#[unsafe(no_mangle)]
pub extern "C" fn content_length(index: usize) -> usize {
    part(index, content).1
}
