//! GRBL's own parser as a judge of programs.

use std::process::Command;

/// Whether GRBL accepts every block, or what it says. `None`, visibly, where its parser is not to be had.
pub fn accepted(text: &str, name: &str) -> Option<Result<(), String>> {
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/../../shared/peers/grbl.sh");
    if !std::path::Path::new(script).exists() {
        println!("skipped: ../shared not present");
        return None;
    }
    let folder = std::env::temp_dir().join(format!("evencut-grbl-{}-{name}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let file = folder.join("p.nc");
    std::fs::write(&file, text).unwrap();
    // It leaves its settings where it runs.
    let run = Command::new("bash").arg(script).arg(&file).current_dir(&folder).output().unwrap();
    std::fs::remove_dir_all(&folder).unwrap();
    match run.status.code() {
        Some(0) => Some(Ok(())),
        Some(1) => Some(Err(String::from_utf8_lossy(&run.stdout).into_owned())),
        code => {
            println!("skipped: GRBL's parser could not be built or run ({code:?})");
            None
        }
    }
}
