//! `evencut plan`: a job file → a directory of results.

use std::path::{Path, PathBuf};

use clap::Args;
use evencut_core::job::{Faults, Resolved, Severity};
use evencut_service::failure;
use evencut_service::faults::{fault, place};
use evencut_service::results::{
    Input, OperationError, OutputFile, Results, ResultsError, ResultsOptions, operations_results,
    results,
};
use evencut_service::stages::words;

use crate::input::{Contents, Paths};
use crate::output::{self, OutputError, ResultDirectory};
use crate::progress::Progress;
use crate::{Exit, Streams, input, post};

/// Arguments of `evencut plan`.
#[derive(Args)]
pub struct Plan {
    /// Job file; `-` reads standard input
    #[arg(value_name = "JOB")]
    job: PathBuf,
    /// Output directory; earlier results in it are replaced [default: results/JOB's name]
    #[arg(short, long, value_name = "DIR")]
    output: Option<PathBuf>,
    /// Post-processor instead of the job's: a name that `evencut post` lists, none, or a post file (.toml)
    #[arg(long, value_name = "NAME|FILE")]
    post: Option<String>,
    /// Number of threads; the results do not depend on it [default: all]
    #[arg(long, value_name = "N")]
    threads: Option<std::num::NonZeroUsize>,
    /// Print the report as JSON instead of its summary
    #[arg(long)]
    json: bool,
    /// Do not simulate the path to verify what it leaves and removes
    #[arg(long)]
    no_verify: bool,
    /// Print errors only (and the report, with --json)
    #[arg(short, long)]
    quiet: bool,
}

/// A job as it was read, with the bytes behind it.
struct Read {
    resolved: Resolved,
    source: Vec<u8>,
    contents: Contents,
}

/// Why there are no results: exit code and messages.
pub(crate) struct Failed(pub(crate) Exit, pub(crate) String);

impl Failed {
    /// What is wrong with a file.
    pub fn file(exit: Exit, message: impl std::fmt::Display, path: &Path) -> Self {
        Self(exit, format!("error: {message}\n --> {}\n", input::shown(path)))
    }
}

impl Plan {
    /// Plans the job and writes all of its results, or none.
    pub fn run(&self, streams: &mut Streams<'_>) -> Exit {
        match self.plan(streams) {
            Ok(()) => Exit::Done,
            Err(Failed(exit, message)) => {
                streams.message(&message);
                exit
            }
        }
    }

    fn plan(&self, streams: &mut Streams<'_>) -> Result<(), Failed> {
        let read = self.read(streams)?;
        let target = self.target();
        // Before the work, not after it.
        output::check(&target).map_err(|error| of_output(&error))?;
        if !read.resolved.operations.is_empty() {
            return self.operations(&read, &target, streams);
        }
        let results = self.results(&read)?;
        let written = write(&target, &results.files).map_err(|error| of_output(&error))?;
        if self.json {
            streams.data(&results.report.to_json());
        } else if !self.quiet {
            streams.data(&results.report.summary());
        }
        if !self.quiet {
            streams.message(&format!("results in {}\n", input::shown(&written)));
        }
        match &results.report.verification {
            Some(verification) if !verification.passed => {
                Err(Failed(Exit::NotVerified, broken(&verification.broken, &verification.remedies)))
            }
            // Of a program that is wrong nobody is left in the dark, simulated or not.
            None if !results.program.is_empty() => {
                Err(Failed(Exit::NotVerified, broken(&results.program, &[])))
            }
            _ => self.asked_texture(&read, &results),
        }
    }

    /// Plans a job of several operations.
    fn operations(
        &self,
        read: &Read,
        target: &Path,
        streams: &mut Streams<'_>,
    ) -> Result<(), Failed> {
        let Read { resolved, source, contents } = read;
        let name = self.job.file_name().unwrap_or_default().to_string_lossy();
        let input = Input { name: &name, bytes: source };
        let mut progress = self.progress();
        let planned = operations_results(
            resolved,
            input,
            contents.files(),
            self.options(),
            &mut |_, stage, part| progress.report(words(stage), part),
        );
        drop(progress);
        let results = planned.map_err(|OperationError { operation, error }| {
            let Failed(exit, message) = self.explained(&error, read);
            let name = &resolved.operations[operation - 1].name;
            Failed(exit, format!("operation {operation} ({name}):\n{message}"))
        })?;
        let written = write(target, &results.files).map_err(|error| of_output(&error))?;
        let report = &results.report;
        if self.json {
            streams.data(&report.to_json());
        } else if !self.quiet {
            streams.data(&report.summary());
        }
        if !self.quiet {
            streams.message(&format!("results in {}\n", input::shown(&written)));
        }
        let unmeasured = results.operations.iter().flat_map(|results| &results.program);
        let wrong: Vec<String> = match report.passed {
            Some(_) => report.broken(),
            None => report.findings.iter().chain(unmeasured).cloned().collect(),
        };
        let judged = results.operations.iter().filter_map(|one| one.report.verification.as_ref());
        let mut remedies: Vec<String> = judged.flat_map(|v| &v.remedies).cloned().collect();
        remedies.sort_unstable();
        remedies.dedup();
        match wrong.is_empty() {
            true => Ok(()),
            false => Err(Failed(Exit::NotVerified, broken(&wrong, &remedies))),
        }
    }

    /// If a requested window cannot be simulated, the plan is written, but the run does not count as a success.
    fn asked_texture(&self, read: &Read, results: &Results) -> Result<(), Failed> {
        let warnings = &results.report.warnings;
        let failed = warnings.iter().find(|warning| warning.stage == "texture");
        match failed {
            Some(warning)
                if read.resolved.job.texture.is_some() && results.report.texture.is_none() =>
            {
                let message = format!("texture: {}; all else is written", warning.message);
                let fault = fault(message, place(&read.source, "texture"));
                Err(self.failed(Exit::BadJob, &Faults(vec![fault]), &read.source))
            }
            _ => Ok(()),
        }
    }

    /// Reads the job and the files it names; prints warnings.
    fn read(&self, streams: &mut Streams<'_>) -> Result<Read, Failed> {
        let source = input::read_job(&self.job)
            .map_err(|fault| self.failed(Exit::BadJob, &Faults(vec![fault]), b""))?;
        let resolved = input::resolved(&self.job, &source)
            .map_err(|faults| self.failed(Exit::BadJob, &faults, &source))?;
        if !self.quiet {
            let name = input::name(&self.job);
            streams.message(&resolved.warnings.render_as(Severity::Warning, &name, &source));
        }
        let mut resolved = resolved;
        let mut own = None;
        if let Some(asked) = &self.post {
            let chosen;
            (chosen, own) = post::chosen(asked)?;
            let operations = resolved.operations.iter_mut().map(|operation| &mut operation.job);
            for job in operations.chain([&mut resolved.job]) {
                job.output.gcode.clone_from(&chosen);
            }
        }
        let mut paths = Paths::of_job(&self.job, &resolved.job);
        if own.is_some() {
            // Named on the command line, and so relative to the current directory.
            paths.post = None;
        }
        let mut contents = Contents::read(paths, &source)
            .map_err(|fault| self.failed(Exit::BadSurface, &Faults(vec![fault]), &source))?
            .beside(core::mem::take(&mut resolved.beside));
        contents.post = own.or(contents.post);
        Ok(Read { resolved, source, contents })
    }

    fn threads(&self) -> usize {
        let all = || std::thread::available_parallelism().ok();
        self.threads.or_else(all).map_or(1, std::num::NonZeroUsize::get)
    }

    fn results(&self, read: &Read) -> Result<Results, Failed> {
        let Read { resolved, source, contents } = read;
        let job_name = self.job.file_name().unwrap_or_default().to_string_lossy();
        let mut progress = self.progress();
        results(
            &resolved.job,
            Input { name: &job_name, bytes: source },
            contents.files(),
            self.options(),
            &mut |stage, part| progress.report(words(stage), part),
        )
        .map_err(|error| self.explained(&error, read))
    }

    fn progress(&self) -> Progress {
        if self.quiet { Progress::hidden() } else { Progress::on_standard_error() }
    }

    fn options(&self) -> ResultsOptions {
        ResultsOptions { threads: self.threads(), verify: !self.no_verify }
    }

    /// Why there are no results.
    fn explained(&self, error: &ResultsError, Read { source, contents, .. }: &Read) -> Failed {
        let surface = contents.surface.as_ref().map(|(path, _)| input::shown(path));
        let (exit, fault) = failure::explain(error, source, surface.as_deref());
        self.failed(exit, &Faults(vec![fault]), source)
    }

    fn failed(&self, exit: Exit, faults: &Faults, source: &[u8]) -> Failed {
        let text = faults.render(&input::name(&self.job), source);
        Failed(exit, text.trim_end().to_owned() + "\n")
    }

    /// The output directory: relative to the current directory.
    fn target(&self) -> PathBuf {
        match &self.output {
            Some(directory) => directory.clone(),
            None if input::is_standard_input(&self.job) => Path::new("results").join("job"),
            None => Path::new("results").join(self.job.file_stem().unwrap_or_default()),
        }
    }
}

fn write(target: &Path, files: &[OutputFile]) -> Result<PathBuf, OutputError> {
    let mut directory = ResultDirectory::begin(target)?;
    for file in files {
        directory.write(&file.name, &file.bytes)?;
    }
    directory.commit()?;
    Ok(target.to_owned())
}

/// The limits that the simulation found broken, as messages, and what helps.
pub fn broken(sentences: &[String], remedies: &[String]) -> String {
    let errors = sentences.iter().map(|sentence| format!("error: verification: {sentence}\n"));
    errors.chain(remedies.iter().map(|remedy| format!("help: {remedy}\n"))).collect()
}

/// Why results cannot be written, as a failure.
pub(crate) fn of_output(error: &OutputError) -> Failed {
    let exit = match error {
        OutputError::NotADirectory(_) | OutputError::Foreign { .. } | OutputError::Nameless(_) => {
            Exit::BadJob
        }
        OutputError::FileName(_) | OutputError::Io { .. } => Exit::Internal,
    };
    Failed(exit, format!("error: {error}\n"))
}
