//! `evencut check`: checks job files against the format.

use std::path::{Path, PathBuf};

use clap::Args;
use evencut_core::job::{Fault, Faults, Job, Resolved, Severity, line_and_column};
use evencut_service::failure;
use evencut_service::results::dialect;
use serde_json::{Value, json};

use crate::input::Paths;
use crate::{Exit, Streams, input};

/// Arguments of `evencut check`.
#[derive(Args)]
pub struct Check {
    /// Job files; `-` reads standard input
    #[arg(required = true, value_name = "JOB")]
    jobs: Vec<PathBuf>,
    /// Print each good job with all its defaults filled in, as TOML
    #[arg(long, conflicts_with = "json")]
    resolved: bool,
    /// Print the findings as JSON: an array with an object per job file
    #[arg(long)]
    json: bool,
}

/// What was found in one job file.
struct Finding {
    name: String,
    source: Vec<u8>,
    errors: Faults,
    warnings: Faults,
    /// The job, if it has no errors.
    job: Option<Resolved>,
    exit: Exit,
}

impl Check {
    /// Checks all files; the exit code is that of the first faulty one.
    pub fn run(&self, streams: &mut Streams<'_>) -> Exit {
        let mut exit = Exit::Done;
        let mut objects = Vec::new();
        for path in &self.jobs {
            let finding = find(path);
            if exit == Exit::Done {
                exit = finding.exit;
            }
            if self.json {
                objects.push(as_json(&finding));
                continue;
            }
            report(&finding, streams);
            if let (true, Some(job)) = (self.resolved, &finding.job) {
                streams.data(&job.to_toml());
            }
        }
        if self.json {
            streams.data(&format!("{:#}\n", Value::Array(objects)));
        }
        exit
    }
}

/// Reads one job file and the files to which it refers.
fn find(path: &Path) -> Finding {
    let mut finding = Finding {
        name: input::name(path),
        source: Vec::new(),
        errors: Faults::default(),
        warnings: Faults::default(),
        job: None,
        exit: Exit::Done,
    };
    match input::read_job(path) {
        Ok(source) => finding.source = source,
        Err(fault) => {
            finding.fail(Exit::BadJob, Faults(vec![fault]));
            return finding;
        }
    }
    match input::resolved(path, &finding.source) {
        Ok(resolved) => {
            finding.warnings = resolved.warnings.clone();
            let missing = missing_files(path, &resolved.job, &finding.source);
            if !missing.is_empty() {
                finding.fail(Exit::BadSurface, Faults(missing));
            } else if let Some((exit, fault)) =
                resolved.jobs().find_map(|job| unusable_post(path, job, &finding.source))
            {
                finding.fail(exit, Faults(vec![fault]));
            }
            finding.job = Some(resolved);
        }
        Err(faults) => finding.fail(Exit::BadJob, faults),
    }
    finding
}

impl Finding {
    fn fail(&mut self, exit: Exit, errors: Faults) {
        self.exit = exit;
        self.errors = errors;
    }
}

/// The files that a job names but that do not exist.
fn missing_files(job_path: &Path, job: &Job, source: &[u8]) -> Vec<Fault> {
    let paths = Paths::of_job(job_path, job);
    let missing = paths.all().filter(|(_, path)| !path.is_file());
    missing.map(|(file, path)| file.missing(input::shown(path), source)).collect()
}

/// Why no program can be written.
fn unusable_post(job_path: &Path, job: &Job, source: &[u8]) -> Option<(Exit, Fault)> {
    let file = Paths::of_job(job_path, job).post.and_then(|path| std::fs::read(path).ok());
    let error = dialect(job, file.as_deref()).err()?;
    Some(failure::explain(&error.into(), source, None))
}

fn report(finding: &Finding, streams: &mut Streams<'_>) {
    let Finding { name, source, errors, warnings, .. } = finding;
    streams.message(&errors.render(name, source));
    streams.message(&warnings.render_as(Severity::Warning, name, source));
    let count = |n: usize, word: &str| format!("{n} {word}{}", if n == 1 { "" } else { "s" });
    streams.message(&match (errors.0.len(), warnings.0.len()) {
        (0, 0) => format!("{name}: good\n"),
        (0, n) => format!("{name}: good, {}\n", count(n, "warning")),
        (n, 0) => format!("{name}: {}\n", count(n, "error")),
        (n, m) => format!("{name}: {}, {}\n", count(n, "error"), count(m, "warning")),
    });
}

fn as_json(finding: &Finding) -> Value {
    let text = String::from_utf8_lossy(&finding.source);
    let list = |faults: &Faults| -> Vec<Value> {
        faults.0.iter().map(|fault| fault_as_json(fault, &text)).collect()
    };
    json!({
        "file": finding.name,
        "good": finding.errors.is_empty(),
        "errors": list(&finding.errors),
        "warnings": list(&finding.warnings),
    })
}

fn fault_as_json(fault: &Fault, source: &str) -> Value {
    let place = fault.span.as_ref().map(|span| {
        let (line, column) = line_and_column(source, span.start);
        let (end_line, end_column) = line_and_column(source, span.end);
        json!({ "line": line, "column": column, "end_line": end_line, "end_column": end_column })
    });
    json!({ "key": fault.key, "message": fault.message, "help": fault.help, "place": place })
}
