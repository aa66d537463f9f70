//! `evencut compare`: one job planned with several patterns or divisions into regions, verified alike.

use std::path::PathBuf;
use std::sync::Arc;
use std::time::Instant;

use clap::Args;
use evencut_core::job::{Faults, Job, Pattern, Resolved};
use evencut_core::plan::{PlanError, Prepared, Stage, SurfaceKeys, plan_on, stock_of};
use evencut_service::compare::{
    RegionVariant, Row, Variant, control, judged, texture, to_csv, to_svg, to_text,
};
use evencut_service::failure;
use evencut_service::faults::{fault, place};
use evencut_service::results::ResultsError;
use evencut_service::results::texture::TextureError;
use evencut_service::stages::words;

use crate::input::Contents;
use crate::plan::Failed;
use crate::progress::Progress;
use crate::{Exit, Streams, input};

/// Largest tilt, degrees: the largest lead angle of a job.
const MOST_TILT: f64 = 60.0;

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
    /// piecewise (one region, one stepover for the largest stretch of its flat map), distortion-piecewise,
    /// distortion, tensor
    #[arg(
        long, value_name = "LIST", value_delimiter = ',', value_parser = regions,
        num_args = 0..=1, require_equals = true, conflicts_with = "patterns"
    )]
    regions: Option<Vec<RegionVariant>>,
    /// Compare the texture of the job's window for these lead angles of the tool axis, degrees, separated by commas
    #[arg(
        long, value_name = "LIST", value_delimiter = ',',
        conflicts_with_all = ["patterns", "regions"]
    )]
    tilts: Vec<f64>,
    /// Compare it for these feeds per tooth, mm, separated by commas
    #[arg(
        long, value_name = "LIST", value_delimiter = ',',
        conflicts_with_all = ["patterns", "regions"]
    )]
    feeds_per_tooth: Vec<f64>,
    /// Compare how limits on the cut are kept: by a slower feed, by trochoids, by whichever is the fastest within all
    /// limits; beside plain passes, at the full feed and slowed throughout
    #[arg(long, conflicts_with_all = ["patterns", "regions", "tilts", "feeds_per_tooth", "svg"])]
    control: bool,
    /// Number of threads [default: 1, so that computing times can be compared]
    #[arg(long, value_name = "N")]
    threads: Option<std::num::NonZeroUsize>,
    /// Print comma-separated values instead of aligned text
    #[arg(long)]
    csv: bool,
    /// Print a bar chart as SVG instead of aligned text
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
    /// Plans and verifies the job once for every pattern; prints the table.
    pub fn run(&self, streams: &mut Streams<'_>) -> Exit {
        if !(self.tilts.is_empty() && self.feeds_per_tooth.is_empty()) {
            return self.textures(streams);
        }
        match self.rows(streams) {
            Ok((rows, exit)) => {
                let title = self.job.file_stem().unwrap_or_default().to_string_lossy();
                streams.data(&match (self.csv, self.svg) {
                    (true, _) if self.control => control::to_csv(&rows),
                    (true, _) => to_csv(&rows),
                    (_, true) => to_svg(&title, &rows),
                    _ if self.control => control::to_text(&rows),
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

    /// Plans, verifies and simulates the job once for every tilt and feed per tooth; prints the table.
    fn textures(&self, streams: &mut Streams<'_>) -> Exit {
        match self.texture_rows(streams) {
            Ok((rows, exit)) => {
                let title = self.job.file_stem().unwrap_or_default().to_string_lossy();
                streams.data(&match (self.csv, self.svg) {
                    (true, _) => texture::to_csv(&rows),
                    (_, true) => texture::to_svg(&title, &rows),
                    _ => texture::to_text(&rows),
                });
                exit
            }
            Err(Failed(exit, message)) => {
                streams.message(&message);
                exit
            }
        }
    }

    fn texture_rows(&self, streams: &mut Streams<'_>) -> Result<(Vec<texture::Row>, Exit), Failed> {
        let choices = self.choices()?;
        let (source, job, contents) = self.read()?;
        if job.texture.is_none() {
            let error = ResultsError::Texture(TextureError::NoWindow);
            let (exit, fault) = failure::explain(&error, &source, None);
            return Err(self.failed(exit, &Faults(vec![fault]), &source));
        }
        let own = job.cut.feed / (job.cut.spindle * f64::from(job.flutes));
        let feeds = choices.iter().map(|choice| choice.feed_per_tooth.unwrap_or(own));
        let finest = feeds.fold(own, f64::min);
        // All that cannot be is reported before anything is planned.
        let varied: Result<Vec<Job>, _> =
            choices.iter().map(|choice| choice.of(&job, finest)).collect();
        let varied = varied.map_err(|error| {
            let place = input::name(&self.job);
            Failed(Exit::BadJob, format!("error: {error}\n --> {place}\n"))
        })?;
        let prepared = self.prepared(&job, &contents, &source)?;
        let (mut rows, mut exits) = (Vec::new(), Vec::new());
        for varied in varied {
            streams.message(&format!("planning row {}\n", rows.len() + 1));
            let made = texture::made(&prepared, &varied, self.threads()).map_err(|error| {
                let (exit, fault) = failure::explain(&error, &source, None);
                (exit, fault.message)
            });
            exits.push(match &made {
                Ok(made) if made.broken.is_empty() => Exit::Done,
                Ok(_) => Exit::NotVerified,
                Err((exit, _)) => *exit,
            });
            rows.push(texture::Row { job: varied, made: made.map_err(|(_, message)| message) });
        }
        Ok((rows, of_all(&exits)))
    }

    /// Every tilt with every feed per tooth.
    fn choices(&self) -> Result<Vec<texture::Choice>, Failed> {
        let bad = |message: String| Failed(Exit::BadJob, format!("error: {message}\n"));
        if let Some(tilt) = self.tilts.iter().find(|t| !(0.0..=MOST_TILT).contains(*t)) {
            return Err(bad(format!("--tilts: {tilt} is not from 0 to {MOST_TILT} degrees")));
        }
        if let Some(feed) = self.feeds_per_tooth.iter().find(|f| !(f.is_finite() && **f > 0.0)) {
            return Err(bad(format!("--feeds-per-tooth: {feed} is not a positive number")));
        }
        let or_own = |some: &[f64]| match some {
            [] => vec![None],
            some => some.iter().copied().map(Some).collect(),
        };
        let feeds = or_own(&self.feeds_per_tooth);
        let with = |tilt: Option<f64>| {
            let tilt = tilt.map(f64::to_radians);
            let choice = move |&feed_per_tooth| texture::Choice { tilt, feed_per_tooth };
            feeds.iter().map(choice).collect::<Vec<_>>()
        };
        Ok(or_own(&self.tilts).into_iter().flat_map(with).collect())
    }

    /// The job's text, the job, and the contents of the files that it names.
    fn read(&self) -> Result<(Vec<u8>, Job, Contents), Failed> {
        let source = input::read_job(&self.job)
            .map_err(|fault| self.failed(Exit::BadJob, &Faults(vec![fault]), b""))?;
        let job = input::resolved(&self.job, &source)
            .and_then(Resolved::only)
            .map_err(|faults| self.failed(Exit::BadJob, &faults, &source))?
            .job;
        if job.hub.is_some() {
            let message =
                "of a hub there is one pattern, and no limit on the cut: nothing can be compared";
            let fault = fault(message.to_owned(), place(&source, "path.pattern"));
            return Err(self.failed(Exit::BadJob, &Faults(vec![fault]), &source));
        }
        let contents = Contents::of_job(&self.job, &job, &source)
            .map_err(|fault| self.failed(Exit::BadSurface, &Faults(vec![fault]), &source))?;
        Ok((source, job, contents))
    }

    /// The surface, which all variants share.
    fn prepared(
        &self,
        job: &Job,
        contents: &Contents,
        source: &[u8],
    ) -> Result<Arc<Prepared>, Failed> {
        let failed = |error: PlanError| {
            let (exit, fault) = failure::explain(&ResultsError::from(error), source, None);
            self.failed(exit, &Faults(vec![fault]), source)
        };
        let mut progress = Progress::on_standard_error();
        let mut tell = |stage, part| progress.report(words(stage), part);
        Prepared::new(SurfaceKeys::of(job), contents.files(), self.threads(), &mut tell)
            .map_err(failed)
    }

    fn threads(&self) -> usize {
        self.threads.map_or(1, std::num::NonZeroUsize::get)
    }

    fn failed(&self, exit: Exit, faults: &Faults, source: &[u8]) -> Failed {
        let text = faults.render(&input::name(&self.job), source);
        Failed(exit, text.trim_end().to_owned() + "\n")
    }

    /// The rows, and the exit code that they have in common, or [`Exit::NotVerified`].
    fn rows(&self, streams: &mut Streams<'_>) -> Result<(Vec<Row>, Exit), Failed> {
        let (source, job, contents) = self.read()?;
        let prepared = self.prepared(&job, &contents, &source)?;
        let (mut rows, mut exits) = (Vec::new(), Vec::new());
        for variant in self.variants(&job) {
            streams.message(&format!("planning {}\n", variant.name()));
            let (row, exit) = self.row(&prepared, &job, variant, &source);
            rows.push(row);
            exits.push(exit);
        }
        Ok((rows, of_all(&exits)))
    }

    fn variants(&self, job: &Job) -> Vec<Variant> {
        if self.control {
            return control::controls(job).into_iter().map(Variant::Control).collect();
        }
        match (&self.regions, &self.patterns[..]) {
            (Some(some), _) if !some.is_empty() => {
                some.iter().map(|&r| Variant::Regions(r)).collect()
            }
            (Some(_), _) => RegionVariant::ALL.map(Variant::Regions).into(),
            (None, []) => Pattern::ALL.map(Variant::Pattern).into(),
            (None, some) => some.iter().map(|&p| Variant::Pattern(p)).collect(),
        }
    }

    fn row(
        &self,
        prepared: &Arc<Prepared>,
        job: &Job,
        variant: Variant,
        source: &[u8],
    ) -> (Row, Exit) {
        let (job, threads) = (variant.of(job), self.threads());
        let begun = Instant::now();
        let mut progress = Progress::on_standard_error();
        let mut tell = |stage, part| progress.report(words(stage), part);
        let plan = plan_on(prepared, &job, &stock_of(&job), threads, &mut tell)
            .map_err(ResultsError::from);
        let seconds = begun.elapsed().as_secs_f64();
        progress.report(words(Stage::Verify), 0.0);
        let figures = plan.and_then(|plan| judged(&job, &plan, threads));
        let fault = |error: ResultsError| {
            let (exit, fault) = failure::explain(&error, source, None);
            (exit, fault.message)
        };
        let figures = figures.map_err(fault);
        let exit = match &figures {
            Ok(figures) if figures.verification().is_some_and(|v| v.passed) => Exit::Done,
            Ok(_) => Exit::NotVerified,
            Err((exit, _)) => *exit,
        };
        (Row { variant, seconds, figures: figures.map_err(|(_, message)| message) }, exit)
    }
}

/// [`Exit::NotVerified`] where a row breaks a limit, else that of the first row that was refused.
fn of_all(exits: &[Exit]) -> Exit {
    let broken = exits.iter().find(|&&exit| exit == Exit::NotVerified);
    let refused = || exits.iter().find(|&&exit| exit != Exit::Done);
    broken.or_else(refused).copied().unwrap_or(Exit::Done)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_refused_row_is_no_broken_limit() {
        let [done, surface, limit, broken] =
            [Exit::Done, Exit::BadSurface, Exit::LimitNotMet, Exit::NotVerified];
        assert_eq!(of_all(&[done, done]), done);
        assert_eq!(of_all(&[done, limit, surface]), limit);
        assert_eq!(of_all(&[surface, done, broken]), broken);
    }
}
