//! One job planned with several patterns, or with several divisions into regions, verified alike, for a comparison
//! side by side.
//!
//! All rows have the job's surface, cutter, limit and machine in common. The removal rate is not limited: paths are
//! compared by their length and by the cusps that they leave. [`control`] compares how limits on the cut are kept.

pub mod control;
pub mod texture;

use crate::results::{ResultsError, judge, report};
use core::fmt::Write;
use evencut_core::job::{
    Compensation, DistortionOptions, Division, FirstPass, ForceControl, Job, Pattern, TensorOptions,
};
use evencut_core::plan::{Planned, stock_of};
use evencut_output::preview::{Bars, comparison};
use evencut_output::report::{CuspFigures, Lines, Report, VerificationFigures};

/// Header of the table as comma-separated values.
pub const CSV_HEADER: &str = "pattern,passes,length_mm,length_over_floor,feed_length_mm,retracts,\
machine_time_s,computing_s,limit_mm,tolerance_mm,largest_mm,p99_mm,gouge_mm,cusp_p5_mm,cusp_p50_mm,\
cusp_p95_mm,cusps_within_percent,even_area_percent,kept,regions,uniformity,spacing_mean,\
spacing_deviation,refused";

/// What is varied.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum Variant {
    /// The pattern.
    Pattern(Pattern),
    /// The division into regions.
    Regions(RegionVariant),
    /// What is done where a limit on the cut would be exceeded.
    Control(ForceControl),
}

/// A division into regions.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum RegionVariant {
    /// One region, with side steps adapted to the surface.
    Single,
    /// One region, with one flat stepover for the largest stretch of its map.
    Piecewise,
    /// Regions with even maps, each with one flat stepover.
    DistortionPiecewise,
    /// The same regions, with side steps adapted to the surface.
    Distortion,
    /// Regions divided where the best feed direction divides.
    Tensor,
}

impl RegionVariant {
    /// All, in the order in which they are compared.
    pub const ALL: [Self; 5] =
        [Self::Single, Self::Piecewise, Self::DistortionPiecewise, Self::Distortion, Self::Tensor];

    /// Its name in the table.
    pub fn name(self) -> &'static str {
        match self {
            Self::Single => "single",
            Self::Piecewise => "piecewise",
            Self::DistortionPiecewise => "distortion-piecewise",
            Self::Distortion => "distortion",
            Self::Tensor => "tensor",
        }
    }
}

impl Variant {
    /// Its name in the table.
    pub fn name(self) -> &'static str {
        match self {
            Self::Pattern(pattern) => pattern.name(),
            Self::Regions(regions) => regions.name(),
            Self::Control(control) => control.name(),
        }
    }

    /// The job with this variation; patterns and divisions without a limit on the rate.
    pub fn of(self, job: &Job) -> Job {
        match self {
            Self::Pattern(pattern) => with_pattern(job, pattern),
            Self::Regions(regions) => with_regions(job, regions),
            Self::Control(control) => control::with_control(job, control),
        }
    }
}

/// A variant and its figures.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// What was varied.
    pub variant: Variant,
    /// Computing time without reading and flattening the surface, which all rows share, and without verification, s, as
    /// measured by the caller.
    pub seconds: f64,
    /// The figures, or why there are none.
    pub figures: Result<Figures, String>,
}

/// Figures of a plan.
#[derive(Clone, Debug, PartialEq)]
pub struct Figures {
    /// Report of the plan, with the verification.
    pub report: Report,
}

/// The job with another pattern, its other choices left to the pattern, and no limit on the rate.
pub fn with_pattern(job: &Job, pattern: Pattern) -> Job {
    let mut job = job.clone();
    if job.path.pattern != pattern {
        job.path.pattern = pattern;
        job.path.first = match pattern.has_rings() {
            true => FirstPass::Edge,
            false => FirstPass::HalfStrip,
        };
    }
    if pattern.divides_itself() {
        job.regions.division = Division::Single;
    }
    job.force.control = ForceControl::Off;
    job
}

/// The job with another division into regions, and no limit on the rate.
pub fn with_regions(job: &Job, variant: RegionVariant) -> Job {
    let given = match job.regions.division {
        Division::Distortion(options) => options,
        Division::Single | Division::Tensor(_) => DistortionOptions::default(),
    };
    let tensor = match job.regions.division {
        Division::Tensor(options) => options,
        Division::Single | Division::Distortion(_) => TensorOptions::default(),
    };
    let distortion = |compensation, depth| {
        Division::Distortion(DistortionOptions { compensation, depth, ..given })
    };
    let mut job = job.clone();
    job.regions.division = match variant {
        RegionVariant::Single => Division::Single,
        RegionVariant::Piecewise => distortion(Compensation::Piecewise, 0),
        RegionVariant::DistortionPiecewise => distortion(Compensation::Piecewise, given.depth),
        RegionVariant::Distortion => distortion(Compensation::Exact, given.depth),
        RegionVariant::Tensor => Division::Tensor(tensor),
    };
    // The bands of that pattern are a division of their own.
    if variant != RegionVariant::Single && job.path.pattern.divides_itself() {
        job.path.pattern = Pattern::IsoScallop;
    }
    job.force.control = ForceControl::Off;
    job
}

/// Verifies a plan.
///
/// # Errors
/// [`ResultsError::Verify`] when the path cannot be verified.
pub fn judged(job: &Job, planned: &Planned, threads: usize) -> Result<Figures, ResultsError> {
    let (verification, options) = judge(job, planned, &stock_of(job), threads, &mut |_| {})?;
    let mut report = report(job, planned, Vec::new());
    report.verification =
        Some(VerificationFigures::of(&verification, &options, Lines::Table, Vec::new()));
    Ok(Figures { report })
}

impl Figures {
    /// The verification; `None` where it was not run.
    pub fn verification(&self) -> Option<&VerificationFigures> {
        self.report.verification.as_ref()
    }

    fn cusps(&self) -> Option<&CuspFigures> {
        self.verification().and_then(|v| v.cusps.as_ref())
    }

    /// Length of all moves at feed, mm.
    fn feed_length(&self) -> f64 {
        let l = &self.report.delivered.length_mm;
        l.total - l.rapid
    }
}

/// The rows as aligned text, heights in µm.
pub fn to_text(rows: &[Row]) -> String {
    let mut out = format!(
        "{:<21}{:>7}{:>10}{:>9}{:>10}{:>9}{:>9}{:>9}{:>8}{:>8}{:>22}{:>8}{:>9}  {}\n",
        "",
        "passes",
        "mm",
        "/ floor",
        "at feed",
        "min:s",
        "comp. s",
        "largest",
        "P99",
        "gouge",
        "cusps P5 P50 P95",
        "within",
        "of limit",
        "kept"
    );
    for row in rows {
        // Writing to a string cannot fail.
        let _ = match &row.figures {
            Ok(figures) => writeln!(out, "{}", text_row(row, figures)),
            Err(message) => writeln!(out, "{:<21}{message}", row.variant.name()),
        };
    }
    push_notes(&mut out, rows);
    out
}

/// The tolerance above the limit, and which limits are broken.
fn push_notes(out: &mut String, rows: &[Row]) {
    let judged = rows.iter().filter_map(|row| {
        let figures = row.figures.as_ref().ok()?;
        Some((row.variant.name(), figures.verification()?))
    });
    let all: Vec<(&str, &VerificationFigures)> = judged.collect();
    if let Some((_, first)) = all.first().filter(|(_, v)| v.scallop.limit_mm.is_some()) {
        let tolerance = 1e3 * first.scallop.tolerance_mm;
        let _ = writeln!(
            out,
            "heights in µm; kept: up to {tolerance:.1} µm, the tolerance, above the limit"
        );
    }
    for (name, v) in all {
        for broken in &v.broken {
            let _ = writeln!(out, "{name}: {broken}");
        }
    }
}

fn text_row(row: &Row, figures: &Figures) -> String {
    let passes = &figures.report.passes;
    let time = figures.report.delivered.machine_time_s.total.round() as u64;
    let micro = |mm: f64| format!("{:.1}", 1e3 * mm);
    let mut line = format!(
        "{:<21}{:>7}{:>10.0}{:>9.3}{:>10.0}{:>9}{:>9.2}",
        row.variant.name(),
        passes.count,
        passes.length_mm,
        passes.length_over_floor,
        figures.feed_length(),
        format!("{}:{:02}", time / 60, time % 60),
        row.seconds,
    );
    if let Some(v) = figures.verification() {
        let s = &v.scallop;
        let cusps = figures.cusps().map_or_else(String::new, |c| {
            format!("{} {} {}", micro(c.p5_mm), micro(c.p50_mm), micro(c.p95_mm))
        });
        let within = figures.cusps().and_then(|c| c.share_within);
        let within = within.map_or_else(String::new, |w| format!("{:.0} %", 100.0 * w));
        let limit = s.limit_mm.map_or_else(String::new, micro);
        let _ = write!(
            line,
            "{:>9}{:>8}{:>8}{cusps:>22}{within:>8}{limit:>9}  {}",
            micro(s.largest_mm),
            micro(s.p99_mm),
            micro((-v.gouge_mm).max(0.0)),
            if v.passed { "yes" } else { "no" },
        );
    }
    if let Some(r) = figures.report.regions.as_ref().filter(|r| r.count > 1) {
        let _ = write!(
            line,
            "{}{} regions, spacing {:.3} ± {:.3}",
            if figures.verification().is_some() { ", " } else { "  " },
            r.count,
            r.spacing.mean,
            r.spacing.deviation
        );
    }
    line
}

/// The rows as comma-separated values under [`CSV_HEADER`]; empty fields where there is no figure, the reason last
/// where a variant was refused.
pub fn to_csv(rows: &[Row]) -> String {
    let mut out = format!("{CSV_HEADER}\n");
    for row in rows {
        let fields = match &row.figures {
            Ok(figures) => csv_fields(row, figures),
            Err(why) => {
                let empty = CSV_HEADER.matches(',').count() - 1;
                core::iter::repeat_n(String::new(), empty).chain([quoted(why)]).collect()
            }
        };
        let _ = writeln!(out, "{},{}", row.variant.name(), fields.join(","));
    }
    out
}

/// A message as a field of comma-separated values, on one line.
fn quoted(message: &str) -> String {
    let line = message.split_whitespace().collect::<Vec<_>>().join(" ");
    format!("\"{}\"", line.replace('"', "\"\""))
}

fn csv_fields(row: &Row, figures: &Figures) -> Vec<String> {
    let passes = &figures.report.passes;
    let of = |value: Option<f64>| value.map_or_else(String::new, |v| format!("{v:.6}"));
    let v = figures.verification();
    let cusps = figures.cusps();
    let numbers = [
        Some(passes.length_mm),
        Some(passes.length_over_floor),
        Some(figures.feed_length()),
        Some(figures.report.passes.retracts as f64),
        Some(figures.report.delivered.machine_time_s.total),
        Some(row.seconds),
        v.and_then(|v| v.scallop.limit_mm),
        v.map(|v| v.scallop.tolerance_mm),
        v.map(|v| v.scallop.largest_mm),
        v.map(|v| v.scallop.p99_mm),
        v.map(|v| v.gouge_mm),
        cusps.map(|c| c.p5_mm),
        cusps.map(|c| c.p50_mm),
        cusps.map(|c| c.p95_mm),
        cusps.and_then(|c| c.share_within).map(|w| 100.0 * w),
        Some(100.0 * figures.report.passes.even_share),
    ];
    let kept = v.map_or_else(String::new, |v| v.passed.to_string());
    let regions = figures.report.regions.as_ref();
    let divided = [
        of(regions.map(|r| r.uniformity_min)),
        of(regions.map(|r| r.spacing.mean)),
        of(regions.map(|r| r.spacing.deviation)),
    ];
    let count = regions.map_or(1, |r| r.count);
    core::iter::once(passes.count.to_string())
        .chain(numbers.map(of))
        .chain([kept, count.to_string()])
        .chain(divided)
        .chain([String::new()])
        .collect()
}

/// The rows as a chart: lengths as multiples of the floor, times, and what is left relative to the limit.
pub fn to_svg(title: &str, rows: &[Row]) -> String {
    let bars = |row: &Row| {
        let figures = row.figures.as_ref().ok();
        let verification = figures.and_then(Figures::verification);
        let seconds = figures.map(|f| f.report.delivered.machine_time_s.total);
        Bars {
            name: row.variant.name(),
            length: figures.map(|f| (f.report.passes.length_mm, f.report.passes.length_over_floor)),
            machine_time: seconds,
            residual: verification.map(|v| (v.scallop.largest_mm, v.scallop.limit_mm)),
            computing: row.seconds,
            regions: figures.and_then(|f| f.report.regions.as_ref()).map_or(1, |r| r.count),
            is_kept: verification.map(|v| v.passed),
        }
    };
    comparison(title, &rows.iter().map(bars).collect::<Vec<_>>())
}
