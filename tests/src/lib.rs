//! What the tests share.

pub mod follow;
pub mod grbl;
pub mod linuxcnc;

use std::path::PathBuf;

use evencut_core::geometry::DVec3;
use evencut_core::job::{Component, Faces, Selection, SurfaceOptions, SurfaceSource};

/// Tells a figure for the ledger, which `cargo xtask accept` writes: what was asked for and what was measured.
pub fn ledger(figure: &str, asked: &str, measured: &str) {
    println!("ledger: | {figure} | {asked} | {measured} |");
}

/// The folder of real geometry beside the repository. Where it is missing, says that the test is skipped.
///
/// # Panics
/// Where it is missing although the environment variable `CI` is set: there no test may skip unseen.
pub fn shared_data() -> Option<PathBuf> {
    // Two levels: out of `tests`, and out of the repository.
    let data = PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../../shared/data"));
    if data.is_dir() {
        return Some(data);
    }
    assert!(std::env::var_os("CI").is_none(), "no {}, which CI must have", data.display());
    println!("skipped: no {}", data.display());
    None
}

/// Options that take a file as it is, in mm.
pub fn as_it_is(component: Component) -> SurfaceOptions {
    SurfaceOptions {
        source: SurfaceSource::File(String::new()),
        scale: 1.0,
        rotate: DVec3::ZERO,
        translate: DVec3::ZERO,
        select: Selection { component, ..Selection::default() },
        curvature_radius: None,
        steepest: None,
        flip: false,
        face: Faces::Only,
        chord: None,
    }
}
