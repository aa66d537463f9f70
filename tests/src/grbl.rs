//! GRBL's own parser as a judge of programs, and its own planner of their time.

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

/// Time of a program by GRBL's own planner, s, or what it says; all axes with this feed, mm/min, acceleration, mm/s², and
/// junction deviation, mm. `None`, visibly, where its sources are not to be had or cannot be built.
pub fn timed(
    text: &str,
    name: &str,
    [feed, acceleration, deviation]: [f64; 3],
) -> Option<Result<f64, String>> {
    let sources = concat!(env!("CARGO_MANIFEST_DIR"), "/../../shared/peers/grbl/grbl-src.tar.xz");
    if !std::path::Path::new(sources).exists() {
        println!("skipped: ../shared not present");
        return None;
    }
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/peers/grbl_time.sh");
    let file = std::env::temp_dir().join(format!("evencut-time-{}-{name}.nc", std::process::id()));
    std::fs::write(&file, text).unwrap();
    let limits = [feed, acceleration, deviation].map(|x| x.to_string());
    let run =
        Command::new("bash").args([script, sources]).arg(&file).args(limits).output().unwrap();
    std::fs::remove_file(&file).unwrap();
    let messages = || String::from_utf8_lossy(&run.stderr).into_owned();
    match run.status.code() {
        Some(0) => {
            let seconds = String::from_utf8_lossy(&run.stdout).trim().parse();
            Some(seconds.map_err(|e: std::num::ParseFloatError| e.to_string()))
        }
        Some(1) => Some(Err(messages())),
        code => {
            println!(
                "skipped: GRBL's planner could not be built or run ({code:?}): {}",
                messages()
            );
            None
        }
    }
}
