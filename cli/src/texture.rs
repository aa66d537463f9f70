//! `evencut texture`: a job or its results → the texture in a window.

use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};

use clap::Args;
use evencut_core::geometry::{DVec2, DVec3};
use evencut_core::job::{Faults, Job, Resolved, Severity, SurfaceSource, TextureOptions};
use evencut_core::texture::grid::GridError;
use evencut_core::toolpath::Toolpath;
use evencut_output::report::FileRecord;
use evencut_service::failure;
use evencut_service::results::ResultsError;
use evencut_service::results::texture::{
    TextureError, TextureResults, texture_of_path, texture_results,
};
use evencut_service::stages::words;

use crate::input::{Contents, Paths, recorded};
use crate::output::{self, ResultDirectory};
use crate::plan::{Failed, of_output};
use crate::progress::Progress;
use crate::{Exit, Streams, input};

/// Sizes and spacings, mm, that a job file may have as well.
const SIZES: RangeInclusive<f64> = 1e-4..=1000.0;
const SPACINGS: RangeInclusive<f64> = 1e-5..=10.0;

/// The job and the path of results.
const RESULTS: [&str; 2] = ["job.resolved.toml", "toolpath.csv"];

/// Arguments of `evencut texture`.
#[derive(Args)]
pub struct Texture {
    /// Job file to plan (`-` reads standard input), or a directory of results, whose toolpath.csv is used as it is
    #[arg(value_name = "JOB|RESULTS")]
    input: PathBuf,
    /// Job file of the results, needed if they are not near their surface file [default: their job.resolved.toml]
    #[arg(long, value_name = "JOB")]
    job: Option<PathBuf>,
    /// Place of the window, mm [default: the job's texture.at]
    #[arg(long, value_name = "X,Y,Z", value_delimiter = ',', allow_hyphen_values = true)]
    at: Option<Vec<f64>>,
    /// Its size along and across the feed, mm [default: the job's texture.size, or five side steps]
    #[arg(long, value_name = "MM,MM", value_delimiter = ',', allow_hyphen_values = true)]
    size: Option<Vec<f64>>,
    /// Simulate the whole surface instead of a window
    #[arg(long, conflicts_with = "size")]
    whole: bool,
    /// Grid spacing, mm [default: the job's texture.spacing, or a tenth of the feed per tooth]
    #[arg(long, value_name = "MM", allow_hyphen_values = true)]
    spacing: Option<f64>,
    /// Output directory; earlier results in it are replaced [default: results/JOB's name-texture]
    #[arg(short, long, value_name = "DIR")]
    output: Option<PathBuf>,
    /// Number of threads; the results do not depend on it [default: all]
    #[arg(long, value_name = "N")]
    threads: Option<std::num::NonZeroUsize>,
    /// Print errors only
    #[arg(short, long)]
    quiet: bool,
}

impl Texture {
    /// Simulates the window and writes all of its files, or none.
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
        self.exists()?;
        let path = self.path()?;
        let file = self.job_file();
        let source = input::read_job(&file)
            .map_err(|fault| self.failed(Exit::BadJob, &Faults(vec![fault]), b""))?;
        if self.input.is_dir() && self.job.is_none() {
            self.is_of_plan(RESULTS[0], &source)?;
        }
        let mut resolved = input::resolved(&file, &source)
            .and_then(Resolved::only)
            .map_err(|faults| self.failed(Exit::BadJob, &faults, &source))?;
        if !self.quiet {
            let name = input::name(&file);
            streams.message(&resolved.warnings.render_as(Severity::Warning, &name, &source));
        }
        resolved.job.texture = self.window(&resolved.job)?;
        let target = self.target();
        // Before the work, not after it.
        output::check(&target).map_err(|error| of_output(&error))?;
        if let Some(plan) = RESULTS.iter().find(|name| target.join(name).exists()) {
            let message = format!(
                "the directory holds a plan ({plan}), which would be lost: name another directory with -o"
            );
            return Err(Failed::file(Exit::BadJob, message, &target));
        }
        let results = self.results(&resolved.job, path.as_ref(), &source)?;
        let write = || {
            let mut directory = ResultDirectory::begin(&target)?;
            for file in &results.files {
                directory.write(&file.name, &file.bytes)?;
            }
            directory.commit()
        };
        write().map_err(|error| of_output(&error))?;
        if !self.quiet {
            streams.data(&results.figures.summary());
            streams.message(&format!("texture in {}\n", input::shown(&target)));
        }
        Ok(())
    }

    /// Whether the input exists.
    fn exists(&self) -> Result<(), Failed> {
        if input::is_standard_input(&self.input) || self.input.exists() {
            return Ok(());
        }
        let message = "there is no such file; give a job, or a directory of results as `evencut plan` writes them";
        Err(Failed::file(Exit::BadJob, message, &self.input))
    }

    /// The job file: for results, the one in their directory, unless another is named.
    fn job_file(&self) -> PathBuf {
        match &self.job {
            Some(job) => job.clone(),
            None if self.input.is_dir() => self.input.join(RESULTS[0]),
            None => self.input.clone(),
        }
    }

    /// The path of results; `None` for a job.
    fn path(&self) -> Result<Option<Toolpath>, Failed> {
        if !self.input.is_dir() {
            return match self.job {
                None => Ok(None),
                Some(_) => {
                    let message = "--job is for a directory of results, and this is not one";
                    Err(Failed::file(Exit::BadJob, message, &self.input))
                }
            };
        }
        let wanted = if self.job.is_some() { &RESULTS[1..] } else { &RESULTS };
        if let Some(missing) = wanted.iter().find(|name| !self.input.join(name).is_file()) {
            let message = format!(
                "the directory holds no {missing}; give a job, or a directory of results as `evencut plan` writes them"
            );
            return Err(Failed::file(Exit::BadJob, message, &self.input));
        }
        let file = self.input.join(RESULTS[1]);
        let failed = |error: &dyn std::fmt::Display| Failed::file(Exit::BadJob, error, &file);
        let text = std::fs::read_to_string(&file).map_err(|error| failed(&error))?;
        self.is_of_plan(RESULTS[1], text.as_bytes())?;
        Toolpath::from_csv(&text).map(Some).map_err(|error| failed(&error))
    }

    /// Rejects a file of the results that is not what the plan wrote; where there is no record of it, any is
    /// accepted.
    fn is_of_plan(&self, name: &str, bytes: &[u8]) -> Result<(), Failed> {
        let report = recorded(&self.input);
        match report.as_ref().and_then(|report| report.output(name)) {
            Some(file) if *file != FileRecord::of(name, bytes) => {
                let remedy = if name == RESULTS[0] {
                    "plan the job again, or name the right job with --job"
                } else {
                    "plan the job again"
                };
                let message = format!(
                    "the file is not what the plan wrote: its SHA-256 is not that of report.json; {remedy}"
                );
                Err(Failed::file(Exit::BadJob, message, &self.input.join(name)))
            }
            _ => Ok(()),
        }
    }

    /// Rejects files that the job of the results names but from which they were not made.
    fn are_of_plan(&self, job: &Job, contents: &Contents) -> Result<(), Failed> {
        let surface = match &job.surface.source {
            SurfaceSource::File(name) => Some(name.as_str()),
            SurfaceSource::Analytic(_) => None,
        };
        let surface = surface.zip(contents.surface.as_ref());
        let surface = surface.map(|(name, (path, bytes))| (name, path.as_path(), bytes));
        let avoided =
            contents.meshes.iter().map(|(name, bytes)| (&name[..], Path::new(name), bytes));
        let report = recorded(&self.input);
        for (name, path, bytes) in surface.into_iter().chain(avoided) {
            let recorded = report.as_ref().and_then(|report| report.input(name));
            if recorded.is_some_and(|file| *file != FileRecord::of(name, bytes)) {
                let message = "the plan was not made from this file: its SHA-256 is not that of report.json; plan the job \
                               again, or name with --job the job that is beside the right file";
                return Err(Failed::file(Exit::BadSurface, message, path));
            }
        }
        Ok(())
    }

    /// The job's window, changed by the arguments.
    fn window(&self, job: &Job) -> Result<Option<TextureOptions>, Failed> {
        let numbers = |name: &str, given: &Option<Vec<f64>>, count: usize| match given {
            Some(numbers) if numbers.len() != count || numbers.iter().any(|x| !x.is_finite()) => {
                let message =
                    format!("error: {name} takes {count} finite numbers separated by commas\n");
                Err(Failed(Exit::BadJob, message))
            }
            given => Ok(given.clone()),
        };
        let ranges = [
            ("--size", self.size.as_deref(), SIZES),
            ("--spacing", self.spacing.as_ref().map(core::slice::from_ref), SPACINGS),
        ];
        for (name, given, range) in ranges {
            if given.is_some_and(|given| !given.iter().all(|x| range.contains(x))) {
                let (least, most) = (range.start(), range.end());
                let message = format!("error: {name} must be between {least} and {most} mm\n");
                return Err(Failed(Exit::BadJob, message));
            }
        }
        let at = numbers("--at", &self.at, 3)?.map(|at| DVec3::new(at[0], at[1], at[2]));
        let size = numbers("--size", &self.size, 2)?.map(|size| DVec2::new(size[0], size[1]));
        let mut window = match (&job.texture, at) {
            (Some(window), at) => TextureOptions { at: at.unwrap_or(window.at), ..window.clone() },
            (None, Some(at)) => TextureOptions::about(at, job),
            (None, None) if self.whole => TextureOptions::of_all(job),
            (None, None) => return Ok(None),
        };
        window.whole = self.whole || (window.whole && at.is_none() && size.is_none());
        window.size = size.unwrap_or(window.size);
        window.spacing = self.spacing.unwrap_or(window.spacing);
        Ok(Some(window))
    }

    fn results(
        &self,
        job: &Job,
        path: Option<&Toolpath>,
        source: &[u8],
    ) -> Result<TextureResults, Failed> {
        let contents = match (path, &self.job) {
            (Some(_), None) => {
                let paths = Paths::of_results(&self.input, job);
                Contents::read(paths, source).map_err(|mut fault| {
                    fault.help = vec![
                        "the job of these results is somewhere else: name it with --job".into(),
                    ];
                    fault
                })
            }
            _ => Contents::of_job(&self.job_file(), job, source),
        };
        let contents = contents
            .map_err(|fault| self.failed(Exit::BadSurface, &Faults(vec![fault]), source))?;
        if path.is_some() && self.job.is_none() {
            self.are_of_plan(job, &contents)?;
        }
        let surface = contents.surface.as_ref().map(|(path, _)| input::shown(path));
        let mut progress =
            if self.quiet { Progress::hidden() } else { Progress::on_standard_error() };
        let all = || std::thread::available_parallelism().ok();
        let threads = self.threads.or_else(all).map_or(1, std::num::NonZeroUsize::get);
        let mut tell = |stage, part| progress.report(words(stage), part);
        let results = match path {
            None => texture_results(job, contents.files(), threads, &mut tell),
            Some(path) => texture_of_path(job, contents.files(), path, threads, &mut tell),
        };
        results.map_err(|error| {
            if let Some(failed) = self.of_arguments(&error) {
                return failed;
            }
            let (exit, fault) = failure::explain(&error, source, surface.as_deref());
            self.failed(exit, &Faults(vec![fault]), source)
        })
    }

    /// An error about a window given by arguments: it points at these, not at the job.
    fn of_arguments(&self, error: &ResultsError) -> Option<Failed> {
        let ResultsError::Texture(error) = error else { return None };
        let at = ("--at", self.at.is_some());
        let size = match self.whole {
            true => ("--whole", true),
            false => ("--size", self.size.is_some()),
        };
        let spacing = ("--spacing", self.spacing.is_some());
        let about = match error {
            TextureError::Window(_) | TextureError::NotCut { .. } => vec![at],
            TextureError::Grid(GridError::OffSurface { .. }) => vec![at, size],
            TextureError::Grid(_) | TextureError::WholeTooFine { .. } => vec![size, spacing],
            _ => vec![],
        };
        let given: Vec<&str> =
            about.into_iter().filter_map(|(name, is_given)| is_given.then_some(name)).collect();
        let message = error.to_string().replace("`texture.at`", "it");
        (!given.is_empty())
            .then(|| Failed(Exit::BadJob, format!("error: {message}\n --> {}\n", given.join(", "))))
    }

    fn failed(&self, exit: Exit, faults: &Faults, source: &[u8]) -> Failed {
        let text = faults.render(&input::name(&self.job_file()), source);
        Failed(exit, text.trim_end().to_owned() + "\n")
    }

    /// Name of the output directory: that of the job, or of the directory of results itself, whatever path leads to
    /// it.
    fn name(&self) -> String {
        let shown = |name: Option<&std::ffi::OsStr>| name.map(|n| n.to_string_lossy().into_owned());
        let name = match std::fs::canonicalize(&self.input) {
            _ if input::is_standard_input(&self.input) => None,
            Ok(directory) if self.input.is_dir() => shown(directory.file_name()),
            _ => shown(self.input.file_stem()),
        };
        name.unwrap_or_else(|| "job".into())
    }

    /// The output directory: relative to the current directory.
    fn target(&self) -> PathBuf {
        match &self.output {
            Some(directory) => directory.clone(),
            None => {
                let name = self.name();
                Path::new("results").join(format!("{name}-texture"))
            }
        }
    }
}
