//! `evencut compare`: one job planned with several patterns, judged alike.

use std::path::PathBuf;
use std::time::Instant;

use clap::Args;
use evencut_core::compare::{Row, judged, planned, to_csv, to_text, with_pattern};
use evencut_core::job::{self, Faults, Job, Pattern};
use evencut_core::results::ResultsError;

use crate::plan::Failed;
use crate::{Exit, Streams, failure, input};

/// Arguments of `evencut compare`.
#[derive(Args)]
pub struct Compare {
    /// Job file
    #[arg(value_name = "JOB")]
    job: PathBuf,
    /// Patterns to compare, separated by commas [default: all]
    #[arg(long, value_name = "LIST", value_delimiter = ',', value_parser = pattern)]
    patterns: Vec<Pattern>,
    /// Threads to use [default: 1, so that seconds of computing can be compared]
    #[arg(long, value_name = "N")]
    threads: Option<std::num::NonZeroUsize>,
    /// Print comma-separated values instead of aligned text
    #[arg(long)]
    csv: bool,
}

fn pattern(text: &str) -> Result<Pattern, String> {
    let names: Vec<_> = Pattern::ALL.iter().map(|p| p.name()).collect();
    let found = Pattern::ALL.into_iter().find(|p| p.name() == text);
    found.ok_or_else(|| format!("one of {} is needed", names.join(", ")))
}

impl Compare {
    /// Plans and judges the job once for every pattern; prints the table.
    pub fn run(&self, streams: &mut Streams<'_>) -> Exit {
        match self.rows(streams) {
            Ok(rows) => {
                streams.data(&if self.csv { to_csv(&rows) } else { to_text(&rows) });
                let kept = |row: &Row| {
                    let verification = row.figures.as_ref().ok()?.report.verification.as_ref();
                    verification.map(|v| v.passed)
                };
                let all_kept = rows.iter().all(|row| kept(row) == Some(true));
                if all_kept { Exit::Done } else { Exit::NotVerified }
            }
            Err(Failed(exit, message)) => {
                streams.message(&message);
                exit
            }
        }
    }

    fn rows(&self, streams: &mut Streams<'_>) -> Result<Vec<Row>, Failed> {
        let name = input::name(&self.job);
        let failed = |exit, faults: &Faults, source: &[u8]| {
            Failed(exit, faults.render(&name, source).trim_end().to_owned() + "\n")
        };
        let source = input::read_job(&self.job)
            .map_err(|fault| failed(Exit::BadJob, &Faults(vec![fault]), b""))?;
        let job = job::read(&source).map_err(|faults| failed(Exit::BadJob, &faults, &source))?.job;
        let file = match input::surface_path(&self.job, &job) {
            None => None,
            Some(path) => Some(
                input::read_surface(&path, &source)
                    .map_err(|fault| failed(Exit::BadSurface, &Faults(vec![fault]), &source))?,
            ),
        };
        let patterns = if self.patterns.is_empty() { &Pattern::ALL[..] } else { &self.patterns };
        let mut rows = Vec::new();
        for &pattern in patterns {
            streams.message(&format!("planning {}\n", pattern.name()));
            rows.push(self.row(&job, file.as_deref(), pattern, &source));
        }
        Ok(rows)
    }

    fn row(&self, job: &Job, file: Option<&[u8]>, pattern: Pattern, source: &[u8]) -> Row {
        let job = with_pattern(job, pattern);
        let threads = self.threads.map_or(1, std::num::NonZeroUsize::get);
        let begun = Instant::now();
        let plan = planned(&job, file, threads);
        let seconds = begun.elapsed().as_secs_f64();
        let figures = plan.and_then(|plan| judged(&job, &plan, threads));
        let told = |error: ResultsError| failure::explain(&error, source, None).1.message;
        Row { pattern, seconds, figures: figures.map_err(told) }
    }
}
