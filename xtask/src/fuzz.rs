//! `cargo xtask fuzz`: libFuzzer on the readers, through cargo-fuzz.

use crate::test::{cargo, target_folder};
use evencut_fuzz::{LONGEST, TARGETS, Target};
use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::Stdio;

/// How long each reader is tried unless told, s.
const SECONDS: u64 = 60;
/// Memory that it may take, the fuzzer's own tables included, MiB.
const MEMORY: u64 = 2048;
/// Longest input, bytes.
const LONGEST_INPUT: u64 = 8192;
/// Lines that are shown of a run that failed.
const LAST: usize = 60;
/// Before the number of inputs in what libFuzzer prints.
const COUNT: &str = "stat::number_of_executed_units:";

/// Runs one reader, or all of them, and tells how many inputs each was given. Inputs that reach something new are kept in
/// the target's folder, where the next run goes on; one that fails ends the run.
pub fn fuzz(project: &Path, target: Option<&str>, seconds: Option<&str>) -> Result<(), String> {
    let seconds = match seconds {
        None => SECONDS,
        Some(text) => text.parse().map_err(|_| format!("{text:?} is no number of seconds"))?,
    };
    let chosen: Vec<Target> =
        TARGETS.into_iter().filter(|t| target.is_none_or(|name| name == t.name)).collect();
    if chosen.is_empty() {
        let names = TARGETS.map(|t| t.name).join(", ");
        return Err(format!("no reader has this name; there are {names}"));
    }
    let version = cargo(project).args(["fuzz", "--version"]).stderr(Stdio::null()).output();
    if !version.is_ok_and(|output| output.status.success()) {
        return Err(
            "no cargo-fuzz: cargo install cargo-fuzz; it needs a C++ compiler, but no nightly Rust"
                .into(),
        );
    }
    chosen.into_iter().try_for_each(|target| run(project, target, seconds))
}

fn run(project: &Path, target: Target, seconds: u64) -> Result<(), String> {
    let name = target.name;
    let folder = target_folder(project).join("fuzz");
    let kept = folder.join("corpus").join(name);
    let failed = folder.join("failed").join(name);
    for made in [&kept, &failed] {
        std::fs::create_dir_all(made).map_err(|e| format!("{}: {e}", made.display()))?;
    }
    let mut fuzzer = cargo(project);
    // As the tests are built: with checks of every sum. Sanitizers need a nightly Rust, and safe code little of them.
    fuzzer.args(["fuzz", "run", "--dev", "--sanitizer", "none", "--features", "libfuzzer"]);
    fuzzer.arg("--target-dir").arg(folder.join("build")).arg(name).arg(&kept);
    fuzzer.args([target.seeds(), target.odd()].concat()).arg("--");
    fuzzer.arg(format!("-artifact_prefix={}/", failed.display()));
    fuzzer.arg(format!("-max_total_time={seconds}")).arg(format!("-max_len={LONGEST_INPUT}"));
    fuzzer.arg(format!("-timeout={}", LONGEST.as_secs())).arg(format!("-rss_limit_mb={MEMORY}"));
    fuzzer.args(["-print_final_stats=1", "-verbosity=1"]);
    let mut child =
        fuzzer.stderr(Stdio::piped()).spawn().map_err(|error| format!("cargo fuzz: {error}"))?;
    let (mut inputs, mut last) = (None, Vec::new());
    if let Some(output) = child.stderr.take() {
        for line in BufReader::new(output).lines() {
            let line = line.map_err(|e| format!("cargo fuzz: {e}"))?;
            if let Some(count) = line.strip_prefix(COUNT) {
                inputs = Some(count.trim().to_owned());
            }
            last.push(line);
        }
    }
    let status = child.wait().map_err(|e| format!("cargo fuzz: {e}"))?;
    match inputs {
        Some(count) if status.success() => {
            println!("{name}: {count} inputs in {seconds} s, none failed");
            Ok(())
        }
        _ => {
            let told = last[last.len().saturating_sub(LAST)..].join("\n");
            let count = inputs.unwrap_or_else(|| "some".to_owned());
            Err(format!(
                "{told}\n{name}: failed after {count} inputs; the input is in {}",
                failed.display()
            ))
        }
    }
}
