//! Every reader of the product, given any bytes: it reads or refuses them, and never panics, hangs, or takes memory
//! without bound; what it refuses it explains.
//!
//! A *target* is one reader and what must hold of all that it reads. Targets are run by libFuzzer, which looks for inputs
//! by the branches that they reach (`cargo xtask fuzz`), and with seeds damaged at random by the test `readers`, the same
//! ones every time.

mod job;
mod mesh;
mod path;
mod smooth;
mod tools;
mod watch;

pub use job::job;
pub use mesh::{obj, off, ply, stl};
pub use path::{post, program, toolpath};
pub use smooth::{nurbs, step};
pub use tools::tools;
pub use watch::{Counts, LONGEST, watched};

use std::path::{Path, PathBuf};

/// Memory that a process which reads small files may have at most, bytes; beyond, it is ended.
pub const MOST_MEMORY: usize = 512 << 20;
/// Longest message of an error, characters: it is read in a terminal.
const LONGEST_MESSAGE: usize = 400;

/// What a reader did with bytes.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// It read them.
    Read,
    /// It refused them, and said why.
    Refused,
}

/// A reader.
#[derive(Copy, Clone, Debug)]
pub struct Target {
    /// Its name, as the command line and the folders of its inputs have it.
    pub name: &'static str,
    /// Reads bytes and asserts what must hold.
    pub read: fn(&[u8]) -> Outcome,
}

/// All readers.
pub const TARGETS: [Target; 11] = [
    Target { name: "job", read: job },
    Target { name: "nurbs", read: nurbs },
    Target { name: "obj", read: obj },
    Target { name: "off", read: off },
    Target { name: "ply", read: ply },
    Target { name: "post", read: post },
    Target { name: "program", read: program },
    Target { name: "step", read: step },
    Target { name: "stl", read: stl },
    Target { name: "toolpath", read: toolpath },
    Target { name: "tools", read: tools },
];

impl Target {
    /// Folders of sound files, from which others are made.
    pub fn seeds(&self) -> Vec<PathBuf> {
        match self.name {
            "post" => vec![project("core/posts")],
            name => vec![project("fuzz/seeds").join(name)],
        }
    }

    /// Folders of files that are to be refused, or once were a fault of the reader.
    pub fn odd(&self) -> Vec<PathBuf> {
        let mut folders = vec![project("tests/regressions/readers").join(self.name)];
        if self.name == "job" {
            folders.push(project("tests/golden/job"));
        }
        folders.retain(|folder| folder.is_dir());
        folders
    }
}

/// A path in the project.
fn project(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(path)
}

/// The outcome of bytes that were refused: the reason is there, and no longer than can be read.
fn refused(reason: &str) -> Outcome {
    assert!(!reason.trim().is_empty(), "refused without a reason");
    assert!(reason.chars().count() < LONGEST_MESSAGE, "{reason}");
    Outcome::Refused
}
