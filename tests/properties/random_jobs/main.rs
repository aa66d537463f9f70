//! Jobs drawn at random, planned, and judged by brute force that shares nothing with the product's own judge: a
//! job that would exit with 0 must keep its limits in truth.
//!
//! | environment | says |
//! |---|---|
//! | `EVENCUT_RANDOM_JOBS` | how many jobs; 10 by default |
//! | `EVENCUT_RANDOM_SEED` | of the whole sweep |
//! | `EVENCUT_RANDOM_ONLY` | the sub-seed of the one job to run, here and not in a process of its own |
//! | `EVENCUT_RANDOM_JOB` | a job file to plan and judge instead |
//! | `EVENCUT_RANDOM_SECONDS` | after how long a job is ended; 60 by default |
//! | `EVENCUT_RANDOM_CHECKS` | the only checks whose failures count, such as `residual,gouge` |
//!
//! Each job runs in a process of its own, which is ended when it takes too long. Jobs that fail are written to
//! the target's folder for temporary files.

mod cutter;
mod draw;
mod judge;
mod part;
mod path;
mod random;
mod rate;
mod reach;
mod walls;

use draw::{Drawn, drawn};
use evencut_core::cutter_location::LocateError;
use evencut_core::job::{self, SurfaceSource};
use evencut_core::link::DeliverError;
use evencut_core::plan::{Files, PlanError};
use evencut_core::verify::VerifyError;
use evencut_output::post::PostError;
use evencut_service::results::{Input, OutputFile, ResultsError, ResultsOptions, results};
use evencut_service::verdict::Workpiece;
use evencut_tests::shared_data;
use judge::Failure;
use random::Random;
use std::collections::BTreeMap;
use std::env::var;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::Mutex;
use std::time::{Duration, Instant};

/// Jobs of a sweep by default, and its seed.
const JOBS: usize = 10;
const SEED: u64 = 20;
/// A job that takes longer is ended by default, s.
const LONGEST: u64 = 60;
/// Before the line that tells a job's outcome.
const MARK: &str = "@@ ";
/// Name of the test below, for processes of their own.
const TEST: &str = "a_job_that_is_said_to_be_kept_is_kept";

/// How a job went.
#[derive(Copy, Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Outcome {
    /// Its limits are kept in truth.
    Kept,
    /// The product's judge found a limit broken.
    Broken,
    /// It was refused.
    Refused,
    /// It was said to be kept, and is not.
    Silent,
    /// The product fell over: it would exit with 1.
    Crashed,
    /// It took too long.
    Slow,
}

impl Outcome {
    const ALL: [(Self, &str); 6] = [
        (Self::Kept, "kept"),
        (Self::Broken, "broken"),
        (Self::Refused, "refused"),
        (Self::Silent, "SILENT"),
        (Self::Crashed, "CRASHED"),
        (Self::Slow, "slow"),
    ];

    fn name(self) -> &'static str {
        Self::ALL.iter().find(|o| o.0 == self).map_or("", |o| o.1)
    }
}

/// Failures that count.
fn counts(failure: &Failure) -> bool {
    var("EVENCUT_RANDOM_CHECKS")
        .map_or(true, |checks| checks.split(',').any(|c| c == failure.check))
}

/// Whether the command would exit with 1 and call it a bug.
fn is_bug(error: &ResultsError) -> bool {
    match error {
        ResultsError::Plan(PlanError::Deliver(error)) => {
            !matches!(error, DeliverError::Locate(LocateError::BelowHorizon { .. }))
        }
        ResultsError::Plan(_) | ResultsError::Verify(VerifyError::TooFine { .. }) => false,
        ResultsError::Post(PostError::Singular { .. } | PostError::Travel { .. }) => false,
        ResultsError::Post(_)
        | ResultsError::Program(_)
        | ResultsError::Verify(_)
        | ResultsError::Texture(_) => true,
    }
}

/// Plans and judges one job: the outcome and the rest of its line.
fn run(text: &str, folder: &Path, seed: u64) -> (Outcome, String) {
    let resolved = match job::read(text.as_bytes()) {
        Ok(resolved) => resolved,
        Err(faults) => {
            return (
                Outcome::Refused,
                format!("exit 2: {}: {}", faults.0[0].key, faults.0[0].message),
            );
        }
    };
    let job = resolved.job;
    let bytes = match &job.surface.source {
        SurfaceSource::File(file) => Some(std::fs::read(folder.join(file)).unwrap()),
        SurfaceSource::Analytic(_) => None,
    };
    let files = Files::of_surface(bytes.as_deref());
    let input = Input { name: "job.toml", bytes: text.as_bytes() };
    let options = ResultsOptions { threads: 1, verify: true };
    let started = Instant::now();
    let planned = match results(&job, input, files, options, &mut |_, _| {}) {
        Ok(planned) => planned,
        Err(error) => {
            let text = error.to_string();
            let outcome = if is_bug(&error) { Outcome::Crashed } else { Outcome::Refused };
            return (outcome, text.lines().next().unwrap_or_default().to_owned());
        }
    };
    let report = &planned.report;
    let broken = report.verification.as_ref().map_or(&[][..], |v| &v.broken[..]);
    let planning = started.elapsed().as_secs_f64();
    if let Some(first) = broken.first() {
        return (Outcome::Broken, format!("{first} ({planning:.1} s)"));
    }
    println!("planned in {planning:.1} s");
    let is_table = |f: &&OutputFile| f.name == "toolpath.csv";
    let table = planned.files.iter().find(is_table).unwrap();
    let table = std::str::from_utf8(&table.bytes).unwrap();
    let (part, _) = Workpiece::of_job(&job, files, 1).unwrap();
    let started = Instant::now();
    let found = judge::judged(&job, table, &part, report, seed);
    let judging = started.elapsed().as_secs_f64();
    let failures: Vec<&Failure> = found.failures.iter().filter(|f| counts(f)).collect();
    let outcome = if failures.is_empty() { Outcome::Kept } else { Outcome::Silent };
    let mut line = found.figures.join(", ");
    for failure in &found.failures {
        line += &format!(" | {}: {}", failure.check, failure.what);
    }
    (outcome, format!("{line} ({planning:.1} + {judging:.1} s)"))
}

/// Runs one job in a process of its own.
fn run_apart(seed: u64, text: &str, scratch: &Path) -> (Outcome, String) {
    let [out, job] = ["out", "job"].map(|end| scratch.join(format!("{seed:016x}.{end}")));
    std::fs::write(&job, text).unwrap();
    let file = std::fs::File::create(&out).unwrap();
    let mut child = Command::new(std::env::current_exe().unwrap())
        .args(["--exact", TEST, "--nocapture"])
        .env("EVENCUT_RANDOM_ONLY", format!("{seed:#x}"))
        .env("EVENCUT_RANDOM_JOB", &job)
        .stdout(Stdio::from(file.try_clone().unwrap()))
        .stderr(Stdio::from(file))
        .spawn()
        .unwrap();
    let longest = number("EVENCUT_RANDOM_SECONDS").unwrap_or(LONGEST);
    let started = Instant::now();
    let ended = loop {
        if child.try_wait().unwrap().is_some() {
            break true;
        }
        if started.elapsed() > Duration::from_secs(longest) {
            // It may just have ended.
            let _ = child.kill();
            let _ = child.wait();
            break false;
        }
        std::thread::sleep(Duration::from_millis(20));
    };
    let text = std::fs::read(&out).unwrap_or_default();
    let text = String::from_utf8_lossy(&text);
    [out, job].iter().for_each(|file| drop(std::fs::remove_file(file)));
    if let Some(line) = text.lines().find_map(|l| l.split_once(MARK)).map(|l| l.1) {
        let told = Outcome::ALL.iter().find_map(|o| Some((o.0, line.strip_prefix(o.1)?.trim())));
        if let Some((outcome, rest)) = told {
            return (outcome, rest.to_owned());
        }
    }
    if !ended {
        let planned = text.lines().find(|l| l.starts_with("planned in")).unwrap_or("not planned");
        return (Outcome::Slow, format!("{planned}, ended after {longest} s"));
    }
    let why = text.lines().skip_while(|l| !l.contains("panicked")).take(2).collect::<Vec<_>>();
    (Outcome::Crashed, why.join(" "))
}

fn number(name: &str) -> Option<u64> {
    let text = var(name).ok()?;
    let parsed = match text.strip_prefix("0x") {
        Some(digits) => u64::from_str_radix(digits, 16),
        None => text.parse(),
    };
    Some(parsed.unwrap_or_else(|_| panic!("{name}={text} is no number")))
}

fn scratch() -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("random_jobs");
    std::fs::create_dir_all(&folder).unwrap();
    folder
}

fn told(seed: u64, drawn: &Drawn, outcome: Outcome, rest: &str) {
    println!("{seed:#018x} {:<7} {}: {rest}", outcome.name(), drawn.about);
}

/// Runs all jobs of a sweep, and gives their outcomes in order.
fn sweep(jobs: usize, seed: u64) -> Vec<(u64, Outcome)> {
    let data = shared_data();
    let scratch = scratch();
    let mut seeds = Random::new(seed);
    let seeds: Vec<u64> = (0..jobs).map(|_| seeds.bits()).collect();
    let next = Mutex::new(seeds.iter());
    let outcomes = Mutex::new(BTreeMap::new());
    let work = || {
        loop {
            let Some(&seed) = next.lock().unwrap().next() else { return };
            let drawn = drawn(seed, data.as_deref());
            let (outcome, rest) = run_apart(seed, &drawn.text, &scratch);
            told(seed, &drawn, outcome, &rest);
            if matches!(outcome, Outcome::Silent | Outcome::Crashed | Outcome::Slow) {
                let text = format!("# {seed:#x} {}: {rest}\n{}", outcome.name(), drawn.text);
                std::fs::write(scratch.join(format!("{seed:016x}.toml")), text).unwrap();
            }
            outcomes.lock().unwrap().insert(seed, outcome);
        }
    };
    let workers = std::thread::available_parallelism().map_or(1, std::num::NonZeroUsize::get);
    std::thread::scope(|scope| (0..workers).for_each(|_| drop(scope.spawn(work))));
    outcomes.into_inner().unwrap().into_iter().collect()
}

#[test]
fn a_job_that_is_said_to_be_kept_is_kept() {
    let alone = |text: &str, folder: &Path, seed: u64| {
        let (outcome, rest) = run(text, folder, seed);
        println!("{MARK}{} {rest}", outcome.name());
        assert_ne!(outcome, Outcome::Silent);
    };
    if let Ok(path) = var("EVENCUT_RANDOM_JOB") {
        let path = PathBuf::from(path);
        let text = std::fs::read_to_string(&path).unwrap();
        let seed = number("EVENCUT_RANDOM_ONLY").unwrap_or(SEED);
        return alone(&text, path.parent().unwrap(), seed);
    }
    if let Some(seed) = number("EVENCUT_RANDOM_ONLY") {
        let drawn = drawn(seed, shared_data().as_deref());
        println!("{}", drawn.text);
        return alone(&drawn.text, Path::new(""), seed);
    }
    let jobs = number("EVENCUT_RANDOM_JOBS").map_or(JOBS, |n| n as usize);
    let outcomes = sweep(jobs, number("EVENCUT_RANDOM_SEED").unwrap_or(SEED));
    let count = |outcome: Outcome| outcomes.iter().filter(|o| o.1 == outcome).count();
    let counts: Vec<String> =
        Outcome::ALL.iter().map(|o| format!("{} {}", count(o.0), o.1)).collect();
    println!("{} jobs: {}", outcomes.len(), counts.join(", "));
    let bad = count(Outcome::Silent) + count(Outcome::Crashed);
    assert_eq!(bad, 0, "their job files are in {}", scratch().display());
}

/// Jobs of `tests/regressions/jobs`, each of which tells what it once showed.
#[test]
fn jobs_that_once_failed_silently_are_kept_or_reported() {
    let jobs = Path::new(env!("CARGO_MANIFEST_DIR")).join("regressions/jobs");
    let data = shared_data().map(|data| data.join("mesh"));
    let mut seen = 0;
    for file in std::fs::read_dir(jobs).unwrap() {
        let path = file.unwrap().path();
        let text = std::fs::read_to_string(&path).unwrap();
        let asks_for_data = text.contains("\nfile = ");
        let Some(folder) = data.as_deref().or((!asks_for_data).then_some(Path::new(""))) else {
            continue;
        };
        let (outcome, rest) = run(&text, folder, SEED);
        println!("{}: {} {rest}", path.display(), outcome.name());
        assert!(matches!(outcome, Outcome::Kept | Outcome::Broken), "{}: {rest}", path.display());
        seen += 1;
    }
    assert!(seen >= 2, "only {seen} jobs");
}
