//! Where tests find the data that is shared between projects.

use std::path::PathBuf;

/// A folder of it; `None`, and a line that says so, where it is not present.
///
/// # Panics
/// Where it is missing although the environment variable `CI` is set: there no test may skip unseen.
pub fn shared_data(folder: &str) -> Option<PathBuf> {
    // Two levels: out of `core`, and out of the repository.
    let path =
        PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../../shared/data")).join(folder);
    if path.is_dir() {
        return Some(path);
    }
    assert!(std::env::var_os("CI").is_none(), "no {}, which CI must have", path.display());
    println!("skipped: no {}", path.display());
    None
}
