//! `cargo xtask test`: all tests, natively and of the page, whose files are compared with the native ones.

use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};

use crate::serve;

/// The browser's target.
pub const WASM: &str = "wasm32-unknown-unknown";

/// Runs all tests; the first that fails ends the run.
pub fn test(project: &Path) -> Result<(), String> {
    // The tests' own notices are hidden by the test runner.
    if !project.join("../shared/data").is_dir() {
        println!("skipped: tests on real meshes, since there is no ../shared/data");
    }
    let mut ahead = page_ahead();
    let tested = run(cargo(project).args(["test", "--workspace"]));
    if let Some(build) = &mut ahead {
        if tested.is_err() {
            build.kill().ok();
        }
        // What it may have failed at fails again below, and is seen there.
        build.wait().ok();
    }
    tested?;
    page(project)
}

/// Builds the page while the native tests run: its optimiser keeps one core busy for minutes, and they not always both.
fn page_ahead() -> Option<Child> {
    chromium()?;
    let mut build = Command::new(std::env::current_exe().ok()?);
    build.arg("page").stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null()).spawn().ok()
}

/// Tests the page in a real browser; without one, what node can tell.
pub fn page(project: &Path) -> Result<(), String> {
    if chromium().is_none() {
        let missing = "no Chromium: install it (on Debian: apt-get install chromium), or name it in \
                       CHROMIUM";
        if std::env::var_os("CI").is_some() {
            return Err(format!("tests of the page: {missing}"));
        }
        println!("skipped: tests of the page, since there is {missing}");
        // The page's tests compare the same bytes.
        return parity(project);
    }
    // As the tests have built it already, with all of the workspace: how it is optimised reaches no result.
    run(cargo(project).args(["build", "--workspace", "--bin", "evencut"]))?;
    with_page(project, |node, address| {
        node.args(["--test", "--test-concurrency=2", "--test-reporter=spec"])
            .args(["web/tests/page.test.mjs", "web/tests/using.test.mjs"])
            .env("PAGE", address)
            .env("EVENCUT", native(project, "debug"))
            .env("PICTURES", target_folder(project).join("page-pictures"));
    })
}

/// Builds the page, serves it, and runs node against it.
fn with_page(project: &Path, set_up: impl Fn(&mut Command, &str)) -> Result<(), String> {
    let folder = crate::page::page(project)?;
    let (listener, address) = serve::listen(0)?;
    // Ends with this process.
    std::thread::spawn(move || serve::serve(&folder, &listener));
    let mut node = Command::new("node");
    set_up(&mut node, &address);
    run(node.current_dir(project))
}

/// Where Chromium is: `CHROMIUM`, or where systems put it.
fn chromium() -> Option<PathBuf> {
    let named = std::env::var_os("CHROMIUM").map(PathBuf::from);
    let usual = ["chromium", "chromium-browser", "google-chrome"];
    let usual = usual.iter().map(|name| Path::new("/usr/bin").join(name));
    named.into_iter().chain(usual).find(|path| path.is_file())
}

/// Plans the shipped jobs natively and in WebAssembly and compares the bytes.
pub fn parity(project: &Path) -> Result<(), String> {
    if Command::new("node").arg("--version").output().is_err() {
        println!("skipped: native against WebAssembly, since there is no node");
        return Ok(());
    }
    install_target(project)?;
    run(cargo(project).args(["build", "--workspace", "--bin", "evencut"]))?;
    // Built as the page is: it shares what the page needs, and is what browsers run.
    let build = ["build", "--profile", "page", "--package", "evencut-parity", "--target", WASM];
    run(cargo(project).args(build))?;
    let command = native(project, "debug");
    let module = target_folder(project).join(WASM).join("page/evencut_parity.wasm");
    let mut node = Command::new("node");
    node.arg("tests/parity/parity.mjs").args([command, module]).args(jobs(project)?);
    run(node.current_dir(project))
}

/// All shipped jobs, relative to the project.
pub fn jobs(project: &Path) -> Result<Vec<PathBuf>, String> {
    let folder = project.join("jobs");
    let entries = std::fs::read_dir(&folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    let names = entries.filter_map(|entry| entry.ok()).map(|entry| entry.file_name());
    let mut jobs: Vec<PathBuf> = names
        .map(|name| Path::new("jobs").join(name))
        .filter(|path| path.extension().is_some_and(|e| e == "toml"))
        .collect();
    jobs.sort();
    Ok(jobs)
}

/// Installs the target, unless rustc has it.
pub fn install_target(project: &Path) -> Result<(), String> {
    let mut rustc = Command::new("rustc");
    let output = rustc
        .args(["--print", "target-libdir", "--target", WASM])
        .current_dir(project)
        .output()
        .map_err(|e| format!("rustc: {e}"))?;
    if Path::new(String::from_utf8_lossy(&output.stdout).trim()).is_dir() {
        return Ok(());
    }
    run(Command::new("rustup").args(["target", "add", WASM]).current_dir(project))
        .map_err(|e| format!("{e}; the tests need the target {WASM}: install it beside this rustc"))
}

/// Where cargo builds.
pub fn target_folder(project: &Path) -> PathBuf {
    let folder = std::env::var_os("CARGO_TARGET_DIR").map_or("target".into(), PathBuf::from);
    project.join(folder)
}

/// Cargo in the project.
pub fn cargo(project: &Path) -> Command {
    let mut cargo = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    cargo.current_dir(project);
    cargo
}

/// Runs a command that must succeed.
pub fn run(command: &mut Command) -> Result<(), String> {
    let status = command.status().map_err(|e| format!("{command:?}: {e}"))?;
    if status.success() { Ok(()) } else { Err(format!("{command:?}: {status}")) }
}

/// Plans all jobs in the page and natively on one thread, and prints the ratio of the times.
pub fn speed(project: &Path) -> Result<(), String> {
    run(cargo(project).args(["build", "--release", "--package", "evencut-cli"]))?;
    // The page plans a single operation.
    let is_single = |job: &PathBuf| {
        let text = std::fs::read_to_string(project.join(job)).unwrap_or_default();
        !text.contains("[[operation]]")
    };
    let jobs: Vec<PathBuf> = jobs(project)?.into_iter().filter(is_single).collect();
    with_page(project, |node, address| {
        node.arg("web/tests/speed.mjs").args(&jobs).env("PAGE", address);
        node.env("EVENCUT", native(project, "release"));
    })
}

/// The command as `cargo build` leaves it in the folder of a profile.
pub fn native(project: &Path, profile: &str) -> PathBuf {
    let name = format!("evencut{}", std::env::consts::EXE_SUFFIX);
    target_folder(project).join(profile).join(name)
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    /// Packages with the features they are built with.
    fn packages(of: &[&str]) -> BTreeSet<String> {
        let project = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap();
        let plain = ["--locked", "--prefix", "none", "--format", "{p} {f}"];
        let output = cargo(project).arg("tree").args(plain).args(of).output().unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        // A package that was listed before has a star.
        let lines = String::from_utf8(output.stdout).unwrap();
        lines
            .lines()
            .filter(|line| !line.is_empty())
            .map(|line| line.trim_end_matches(" (*)").to_string())
            .collect()
    }

    /// A feature that only some other package asks for lets cargo build what `cargo xtask` has built (core, for
    /// minutes) once more for the tests.
    #[test]
    fn what_the_tasks_are_built_of_is_built_once() {
        let tasks = packages(&["--package", "xtask", "--edges", "normal,build"]);
        let all = packages(&["--workspace"]);
        let twice: Vec<&String> = tasks.difference(&all).collect();
        assert!(tasks.len() > 50, "{tasks:?}");
        assert!(
            twice.is_empty(),
            "ask for the features in xtask/Cargo.toml that the tests ask for: {twice:?}"
        );
    }
}
