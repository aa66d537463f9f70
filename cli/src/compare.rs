//! `evencut compare`: one job planned with several patterns or divisions into regions, judged alike.

use std::path::PathBuf;
use std::time::Instant;

use clap::Args;
use evencut_core::compare::{
    RegionVariant, Row, Variant, judged, planned, to_csv, to_svg, to_text,
};
use evencut_core::job::{self, Faults, Job, Pattern};
use evencut_core::plan::Files;
use evencut_core::results::ResultsError;

use crate::input::Contents;
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
    /// Compare divisions into regions instead of patterns, all or some, separated by commas: single,
    /// piecewise (one region, one stepover for the largest stretch of its map), distortion-piecewise,
    /// distortion, tensor
    #[arg(
        long, value_name = "LIST", value_delimiter = ',', value_parser = regions,
        num_args = 0..=1, require_equals = true, conflicts_with = "patterns"
    )]
    regions: Option<Vec<RegionVariant>>,
    /// Threads to use [default: 1, so that seconds of computing can be compared]
    #[arg(long, value_name = "N")]
    threads: Option<std::num::NonZeroUsize>,
    /// Print comma-separated values instead of aligned text
    #[arg(long)]
    csv: bool,
    /// Print a picture of bars as SVG instead of aligned text
    #[arg(long, conflicts_with = "csv")]
    svg: bool,
}

fn regions(text: &str) -> Result<RegionVariant, String> {
    let names: Vec<_> = RegionVariant::ALL.iter().map(|v| v.name()).collect();
    let found = RegionVariant::ALL.into_iter().find(|v| v.name() == text);
    found.ok_or_else(|| format!("one of {} is needed", names.join(", ")))
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
            Ok((rows, exit)) => {
                let title = self.job.file_stem().unwrap_or_default().to_string_lossy();
                streams.data(&match (self.csv, self.svg) {
                    (true, _) => to_csv(&rows),
                    (_, true) => to_svg(&title, &rows),
                    _ => to_text(&rows),
                });
                exit
            }
            Err(Failed(exit, message)) => {
                streams.message(&message);
                exit
            }
        }
    }

    /// The rows, and that of their exit codes which all have, or [`Exit::NotVerified`].
    fn rows(&self, streams: &mut Streams<'_>) -> Result<(Vec<Row>, Exit), Failed> {
        let name = input::name(&self.job);
        let failed = |exit, faults: &Faults, source: &[u8]| {
            Failed(exit, faults.render(&name, source).trim_end().to_owned() + "\n")
        };
        let source = input::read_job(&self.job)
            .map_err(|fault| failed(Exit::BadJob, &Faults(vec![fault]), b""))?;
        let job = job::read(&source).map_err(|faults| failed(Exit::BadJob, &faults, &source))?.job;
        let contents = Contents::of_job(&self.job, &job, &source)
            .map_err(|fault| failed(Exit::BadSurface, &Faults(vec![fault]), &source))?;
        let (mut rows, mut exits) = (Vec::new(), Vec::new());
        for variant in self.variants() {
            streams.message(&format!("planning {}\n", variant.name()));
            let (row, exit) = self.row(&job, contents.files(), variant, &source);
            rows.push(row);
            exits.push(exit);
        }
        let of_all = exits.first().filter(|first| exits.iter().all(|exit| exit == *first));
        Ok((rows, of_all.copied().unwrap_or(Exit::NotVerified)))
    }

    fn variants(&self) -> Vec<Variant> {
        match (&self.regions, &self.patterns[..]) {
            (Some(some), _) if !some.is_empty() => {
                some.iter().map(|&r| Variant::Regions(r)).collect()
            }
            (Some(_), _) => RegionVariant::ALL.map(Variant::Regions).into(),
            (None, []) => Pattern::ALL.map(Variant::Pattern).into(),
            (None, some) => some.iter().map(|&p| Variant::Pattern(p)).collect(),
        }
    }

    fn row(&self, job: &Job, files: Files, variant: Variant, source: &[u8]) -> (Row, Exit) {
        let job = variant.of(job);
        let threads = self.threads.map_or(1, std::num::NonZeroUsize::get);
        let begun = Instant::now();
        let plan = planned(&job, files, threads);
        let seconds = begun.elapsed().as_secs_f64();
        let figures = plan.and_then(|plan| judged(&job, &plan, threads));
        let told = |error: ResultsError| {
            let (exit, fault) = failure::explain(&error, source, None);
            (exit, fault.message)
        };
        let figures = figures.map_err(told);
        let exit = match &figures {
            Ok(figures) if figures.verification().is_some_and(|v| v.passed) => Exit::Done,
            Ok(_) => Exit::NotVerified,
            Err((exit, _)) => *exit,
        };
        (Row { variant, seconds, figures: figures.map_err(|(_, message)| message) }, exit)
    }
}
