//! `evencut texture`: a job file → the texture that the teeth leave in its window.

use std::path::{Path, PathBuf};

use clap::Args;
use evencut_core::job::{self, Faults, Job, Severity};
use evencut_core::plan::Stage;
use evencut_core::results::ResultsError;
use evencut_core::results::texture::{TextureError, TextureResults, texture_results};
use evencut_core::texture::window::WindowError;

use crate::input::Contents;
use crate::output::{self, ResultDirectory};
use crate::plan::{Failed, of_output, words};
use crate::progress::Progress;
use crate::{Exit, Streams, failure, input};

/// Arguments of `evencut texture`.
#[derive(Args)]
pub struct Texture {
    /// Job file with a `[texture]` table; `-` reads standard input
    #[arg(value_name = "JOB")]
    job: PathBuf,
    /// Directory of the files, whose earlier ones are replaced [default: results/JOB's name-texture]
    #[arg(short, long, value_name = "DIR")]
    output: Option<PathBuf>,
    /// Threads to use, which change nothing but the time [default: all]
    #[arg(long, value_name = "N")]
    threads: Option<std::num::NonZeroUsize>,
    /// Print errors only
    #[arg(short, long)]
    quiet: bool,
}

impl Texture {
    /// Simulates the window and writes its files, all or none.
    pub fn run(&self, streams: &mut Streams<'_>) -> Exit {
        match self.simulate(streams) {
            Ok(()) => Exit::Done,
            Err(Failed(exit, message)) => {
                streams.message(&message);
                exit
            }
        }
    }

    fn simulate(&self, streams: &mut Streams<'_>) -> Result<(), Failed> {
        let source = input::read_job(&self.job)
            .map_err(|fault| self.failed(Exit::BadJob, &Faults(vec![fault]), b""))?;
        let resolved =
            job::read(&source).map_err(|faults| self.failed(Exit::BadJob, &faults, &source))?;
        if !self.quiet {
            let name = input::name(&self.job);
            streams.message(&resolved.warnings.render_as(Severity::Warning, &name, &source));
        }
        let target = self.target();
        // Before the work, not after it.
        output::check(&target).map_err(|error| of_output(&error))?;
        let results = self.results(&resolved.job, &source)?;
        let write = || {
            let mut directory = ResultDirectory::begin(&target)?;
            for file in &results.files {
                directory.write(&file.name, &file.bytes)?;
            }
            directory.commit()
        };
        write().map_err(|error| of_output(&error))?;
        if !self.quiet {
            streams.data(&results.report.summary());
            streams.message(&format!("texture in {}\n", input::shown(&target)));
        }
        Ok(())
    }

    fn results(&self, job: &Job, source: &[u8]) -> Result<TextureResults, Failed> {
        let contents = Contents::of_job(&self.job, job, source)
            .map_err(|fault| self.failed(Exit::BadSurface, &Faults(vec![fault]), source))?;
        let surface = contents.surface.as_ref().map(|(path, _)| input::shown(path));
        let mut progress =
            if self.quiet { Progress::hidden() } else { Progress::on_standard_error() };
        let all = || std::thread::available_parallelism().ok();
        let threads = self.threads.or_else(all).map_or(1, std::num::NonZeroUsize::get);
        let mut tell = |stage, part| {
            let words = if stage == Stage::Verify { "sweeping the window" } else { words(stage) };
            progress.report(words, part);
        };
        texture_results(job, contents.files(), threads, &mut tell).map_err(|error| match error {
            TextureError::Plan(error) => {
                let error = ResultsError::Plan(error);
                let (exit, fault) = failure::explain(&error, source, surface.as_deref());
                self.failed(exit, &Faults(vec![fault]), source)
            }
            error => {
                let (exit, key) = place_of(&error);
                let fault = input::fault(error.to_string(), input::place(source, key));
                self.failed(exit, &Faults(vec![fault]), source)
            }
        })
    }

    fn failed(&self, exit: Exit, faults: &Faults, source: &[u8]) -> Failed {
        let text = faults.render(&input::name(&self.job), source);
        Failed(exit, text.trim_end().to_owned() + "\n")
    }

    /// Where the files go: relative to where the command runs.
    fn target(&self) -> PathBuf {
        match &self.output {
            Some(directory) => directory.clone(),
            None => {
                let stem = match input::is_standard_input(&self.job) {
                    true => "job".into(),
                    false => self.job.file_stem().unwrap_or_default().to_string_lossy(),
                };
                Path::new("results").join(format!("{stem}-texture"))
            }
        }
    }
}

/// The exit code of a failure, and the key of the job file to point at.
fn place_of(error: &TextureError) -> (Exit, &'static str) {
    match error {
        TextureError::NoWindow => (Exit::BadJob, "texture"),
        TextureError::Still { .. } => (Exit::BadJob, "cut.spindle"),
        TextureError::Window(WindowError::OffSurface { .. } | WindowError::NoPass) => {
            (Exit::BadJob, "texture.at")
        }
        TextureError::Grid(_) => (Exit::BadJob, "texture"),
        TextureError::TooConcave(_) => (Exit::LimitNotMet, "tool.diameter"),
        TextureError::X3p(_) | TextureError::Plan(_) => (Exit::Internal, "texture"),
    }
}
