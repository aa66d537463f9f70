//! Many inputs, each within its time.

use crate::{Outcome, Target};
use std::path::{Path, PathBuf};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::Duration;

/// Longest that an input of a few thousand bytes may take, built for tests, on a busy machine.
pub const LONGEST: Duration = Duration::from_secs(20);

/// How many inputs had which outcome.
#[derive(Copy, Clone, Debug, Default)]
pub struct Counts {
    /// Those that were read.
    pub read: usize,
    /// Those that were refused.
    pub refused: usize,
}

/// Gives a reader one input after the other. The input at work stands in `folder`, and stays there when the reader ends
/// the process.
///
/// # Panics
/// When an input makes the reader panic, or takes longer than [`LONGEST`].
pub fn watched(
    target: Target,
    folder: &Path,
    inputs: impl Iterator<Item = Vec<u8>> + Send + 'static,
) -> Counts {
    // Tests, which are threads with names, do not share it.
    let user = std::thread::current()
        .name()
        .unwrap_or("main")
        .replace(|c: char| !c.is_alphanumeric(), "-");
    let at_work: PathBuf = folder.join(format!("{}-{user}", target.name));
    let file = at_work.clone();
    let (tell, told) = channel();
    let worker = std::thread::spawn(move || {
        for bytes in inputs {
            std::fs::write(&file, &bytes).unwrap_or_else(|e| panic!("{}: {e}", file.display()));
            // Nobody listens any more where the input before was too slow.
            if tell.send((target.read)(&bytes)).is_err() {
                return;
            }
        }
    });
    let mut counts = Counts::default();
    loop {
        match told.recv_timeout(LONGEST) {
            Ok(Outcome::Read) => counts.read += 1,
            Ok(Outcome::Refused) => counts.refused += 1,
            Err(RecvTimeoutError::Disconnected) => break,
            Err(RecvTimeoutError::Timeout) => {
                panic!("{}: no end after {LONGEST:?}: {}", target.name, at_work.display())
            }
        }
    }
    assert!(worker.join().is_ok(), "{}: panicked at {}", target.name, at_work.display());
    counts
}
