//! A run that is interrupted leaves nothing behind.

mod common;

use common::{empty, evencut, streams};
use evencut_cli::output::{ResultDirectory, remove_unfinished};
use std::fs;
use std::io::Read;
use std::path::Path;
use std::process::{Command, Stdio};

/// Deeper than the tool is wide: a warning is printed before planning begins. Planning takes minutes.
const SLOW: &str = "version = 1\n[surface.analytic]\nkind = \"saddle\"\nsize = 100.0\nheight = 9.0\n\
                    [tool]\nkind = \"ball\"\ndiameter = 4.0\n[cut]\nscallop = 0.0005\nfeed = 900.0\n\
                    axial_depth = 5.0\n";

fn names(directory: &Path) -> Vec<String> {
    let entries = fs::read_dir(directory).unwrap();
    let mut names: Vec<String> =
        entries.map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

#[test]
fn results_that_are_being_written_are_removed() {
    let directory = empty("interrupted-writing");
    let mut results = ResultDirectory::begin(&directory.join("out")).unwrap();
    results.write("path.ngc", b"G0").unwrap();
    assert_eq!(names(&directory).len(), 1);
    drop(remove_unfinished());
    assert!(names(&directory).is_empty());
}

#[test]
#[cfg_attr(not(unix), ignore = "sends a signal")]
fn earlier_results_stay_when_a_run_is_interrupted() {
    let directory = empty("interrupted-planning");
    let job = "version = 1\n[surface.analytic]\nkind = \"plane\"\nsize = 10.0\n\
               [tool]\ndiameter = 4.0\n[cut]\nstepover = 1.2\nfeed = 600.0\n";
    fs::write(directory.join("quick.toml"), job).unwrap();
    assert_eq!(streams(&evencut(&directory, &["plan", "quick.toml", "-o", "out"])).0, 0);
    fs::write(directory.join("slow.toml"), SLOW).unwrap();
    let all = || [names(&directory), names(&directory.join("out"))];
    let before = all();
    let mut run = Command::new(env!("CARGO_BIN_EXE_evencut"))
        .current_dir(&directory)
        .args(["plan", "slow.toml", "-o", "out"])
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut first = [0];
    run.stderr.as_mut().unwrap().read_exact(&mut first).unwrap();
    let sent = Command::new("kill").args(["-INT", &run.id().to_string()]).status().unwrap();
    assert!(sent.success());
    assert_eq!(run.wait().unwrap().code(), Some(130));
    assert_eq!(all(), before);
}
