//! What once went wrong, each with the smallest file that shows it.

use evencut_fuzz::{MOST_MEMORY, TARGETS, watched};
use std::alloc::System;
use std::collections::BTreeSet;
use std::path::Path;

#[global_allocator]
static MEMORY: cap::Cap<System> = cap::Cap::new(System, MOST_MEMORY);

/// Files in `readers`, and what the reader that their folder names did.
const READERS: [(&str, &str); 7] = [
    (
        "nurbs/one-corner-far-off.json",
        "took minutes: a boundary of 400 000 points, for a mesh of 5000 triangles",
    ),
    ("nurbs/trim-of-300-digits.json", "was refused with a message that nobody can read"),
    ("ply/coordinates-of-300-digits.ply", "was refused with a message that nobody can read"),
    ("step/bezier-without-points.step", "panicked: its knots were counted from -1"),
    ("step/endless-name.step", "was refused with a message as long as the name"),
    ("step/weight-of-300-digits.step", "was refused with a message that nobody can read"),
    ("toolpath/odd-header.csv", "was refused with a message full of the header's odd letters"),
];

#[test]
fn readers_read_or_refuse_what_they_once_fell_over() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("regressions/readers");
    let mut there = BTreeSet::new();
    for target in TARGETS {
        let Ok(files) = std::fs::read_dir(folder.join(target.name)) else { continue };
        for file in files {
            let file = file.unwrap();
            let name = format!("{}/{}", target.name, file.file_name().to_str().unwrap());
            let story = READERS.iter().find(|(known, _)| *known == name);
            println!("{name} {}", story.unwrap_or_else(|| panic!("{name} has no story")).1);
            let bytes = std::fs::read(file.path()).unwrap();
            watched(target, Path::new(env!("CARGO_TARGET_TMPDIR")), [bytes].into_iter());
            there.insert(name);
        }
    }
    assert_eq!(there.len(), READERS.len(), "stories without their files");
}
