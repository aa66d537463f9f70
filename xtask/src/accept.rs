//! `cargo xtask accept`: the tests that last long, and the ledger of the figures that were asked for.
//!
//! Tests that only repeat on larger inputs what others show, or that measure tables of figures, are marked
//! `#[ignore = "long: cargo xtask accept"]`. What they measure they tell in lines, see `evencut_tests::ledger`.

use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Command, Stdio};

use crate::test::cargo;

/// Where figures stand.
const LEDGER: &str = "docs/ledger.md";
/// How a line of a figure begins.
const MARK: &str = "ledger: ";

/// Runs the long tests and writes the ledger, whether they pass or not.
pub fn accept(project: &Path) -> Result<(), String> {
    let mut tests = cargo(project);
    tests.args(["test", "--package", "evencut-tests", "--no-fail-fast", "--"]);
    tests.args(["--ignored", "--nocapture", "--test-threads=1"]);
    let mut child = tests.stdout(Stdio::piped()).spawn().map_err(|e| format!("cargo: {e}"))?;
    let mut figures = Vec::new();
    if let Some(output) = child.stdout.take() {
        for line in BufReader::new(output).lines() {
            let line = line.map_err(|e| format!("cargo: {e}"))?;
            println!("{line}");
            // The name of a test stands before its first line.
            figures.extend(line.split_once(MARK).map(|(_, figure)| figure.to_owned()));
        }
    }
    let status = child.wait().map_err(|e| format!("cargo: {e}"))?;
    if figures.is_empty() {
        return Err(format!("no figure was measured: {status}"));
    }
    let path = project.join(LEDGER);
    std::fs::write(&path, ledger(&commit(project)?, &figures))
        .map_err(|e| format!("{}: {e}", path.display()))?;
    println!("{} figures in {LEDGER}", figures.len());
    if status.success() { Ok(()) } else { Err(format!("{tests:?}: {status}")) }
}

fn ledger(commit: &str, figures: &[String]) -> String {
    format!(
        "# Ledger\n\nFigures that were asked for, and what was measured: written by `cargo xtask accept`, on {commit}. \
         Bounds that must hold are\nin the tests; a figure here that misses what was asked is not met.\n\n\
         | figure | asked | measured |\n|---|---|---|\n{}\n",
        figures.join("\n")
    )
}

/// The commit that is measured, and its date.
pub fn commit(project: &Path) -> Result<String, String> {
    let mut git = Command::new("git");
    let log = git.args(["log", "-1", "--format=commit `%h` of %cs"]).current_dir(project);
    let output = log.output().map_err(|e| format!("git: {e}"))?;
    Ok(String::from_utf8_lossy(&output.stdout).trim().to_owned())
}
