//! What the tests share.

pub mod follow;
pub mod linuxcnc;

use std::path::PathBuf;

use evencut_core::geometry::DVec3;
use evencut_core::job::{Component, Selection, SurfaceOptions, SurfaceSource};

/// The folder of shared real geometry, if it is there; says so when it is not.
pub fn shared_data() -> Option<PathBuf> {
    let data = PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../../shared/data"));
    if data.is_dir() {
        return Some(data);
    }
    println!("skipped: ../shared not present");
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
        flip: false,
        face: None,
        chord: None,
    }
}
