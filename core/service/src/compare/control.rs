//! One job planned with every way to keep its limits on the cut: constant load against conventional passes.
//!
//! Rows: the plain passes at the full feed, and at the one feed that keeps rate, power and force, both as planned; then
//! each control, planned and verified.

use super::{Figures, Row, quoted};
use core::fmt::Write;
use evencut_core::job::{ForceControl, Job};
use evencut_output::report::{PathFigures, RateFigures, VerificationFigures};

/// Header of the table as comma-separated values.
pub const CSV_HEADER: &str = "control,length_mm,machine_time_s,peak_over_limit,near_limit_percent,variation,\
engagement_deg,feed_per_tooth_mm,power_w,force_n,loops,measured_over_limit,computing_s,kept,refused";

/// The job with another control.
pub(super) fn with_control(job: &Job, control: ForceControl) -> Job {
    let mut job = job.clone();
    job.force.control = control;
    job
}

/// The controls that a job's pattern takes, in the order in which they are compared.
pub fn controls(job: &Job) -> Vec<ForceControl> {
    let all = [ForceControl::Feed, ForceControl::Trochoid, ForceControl::Fastest];
    let takes_trochoids = job.path.pattern.takes_trochoids(job.footprint().lags());
    let takes = |c: &ForceControl| takes_trochoids || !c.takes_trochoids();
    all.into_iter().filter(takes).collect()
}

/// A line of the table.
struct Line<'a> {
    name: &'a str,
    path: &'a PathFigures,
    /// Trochoid loops.
    loops: u64,
    verification: Option<&'a VerificationFigures>,
    seconds: Option<f64>,
}

/// The paths of the rows, those that are only planned first; a row without figures has a message instead.
fn lines(rows: &[Row]) -> Vec<Result<Line<'_>, (&'static str, &str)>> {
    let reports = rows.iter().filter_map(|row| row.figures.as_ref().ok());
    let first = reports.map(|figures| &figures.report).next();
    let mut out = Vec::new();
    if let Some(report) = first {
        for (name, path) in [("plain", &report.plain), ("slowed throughout", &report.slowed)] {
            if let Some(path) = path {
                out.push(Ok(Line { name, path, loops: 0, verification: None, seconds: None }));
            }
        }
    }
    out.extend(rows.iter().map(|row| match &row.figures {
        Ok(figures) => Ok(Line {
            name: row.variant.name(),
            path: &figures.report.delivered,
            loops: figures.report.force.trochoid_loops,
            verification: figures.verification(),
            seconds: Some(row.seconds),
        }),
        Err(message) => Err((row.variant.name(), &message[..])),
    }));
    out
}

/// The rows as aligned text.
pub fn to_text(rows: &[Row]) -> String {
    let mut out = format!(
        "{:<19}{:>8}{:>9}{:>8}{:>10}{:>11}{:>9}{:>10}{:>9}{:>9}{:>7}{:>10}{:>9}  {}\n",
        "",
        "mm",
        "min:s",
        "peak",
        "0.8 to 1",
        "variation",
        "engaged",
        "mm/tooth",
        "W",
        "N",
        "loops",
        "measured",
        "comp. s",
        "kept"
    );
    for line in lines(rows) {
        // Writing to a string cannot fail.
        let _ = match line {
            Ok(line) => writeln!(out, "{}", line.to_text()),
            Err((name, message)) => writeln!(out, "{name:<19}{message}"),
        };
    }
    out.push_str("peak, 0.8 to 1 (share of the cutting time), measured: multiples of the limit; engaged: degrees\n");
    for row in rows {
        let broken = row.figures.as_ref().ok().and_then(Figures::verification).map(|v| &v.broken);
        for broken in broken.into_iter().flatten() {
            let _ = writeln!(out, "{}: {broken}", row.variant.name());
        }
    }
    out
}

impl Line<'_> {
    fn to_text(&self) -> String {
        let time = self.path.machine_time_s.total.round() as u64;
        let rate = |value: fn(&RateFigures) -> String| {
            self.path.rate.as_ref().map_or_else(String::new, value)
        };
        let whole = |value: Option<f64>| value.map_or_else(String::new, |v| format!("{v:.0}"));
        format!(
            "{:<19}{:>8.0}{:>9}{:>8}{:>10}{:>11}{:>9}{:>10}{:>9}{:>9}{:>7}{:>10}{:>9}  {}",
            self.name,
            self.path.length_mm.total,
            format!("{}:{:02}", time / 60, time % 60),
            rate(|r| format!("{:.3}", r.peak_over_limit)),
            rate(|r| format!("{:.0} %", 100.0 * r.near_limit)),
            rate(|r| format!("{:.3}", r.variation)),
            rate(|r| format!("{:.0}", r.engagement_deg)),
            rate(|r| format!("{:.4}", r.feed_per_tooth_mm)),
            whole(self.path.rate.and_then(|r| r.power_w)),
            whole(self.path.rate.and_then(|r| r.force_n)),
            self.loops,
            self.measured().map_or_else(String::new, |m| format!("{m:.3}")),
            self.seconds.map_or_else(String::new, |s| format!("{s:.1}")),
            match self.verification.map(|v| v.passed) {
                Some(true) => "yes",
                Some(false) => "no",
                None => "",
            },
        )
        .trim_end()
        .to_owned()
    }

    /// The rate that the simulation measured, as a multiple of its limit.
    fn measured(&self) -> Option<f64> {
        self.verification.and_then(|v| v.mrr.as_ref()).and_then(|mrr| mrr.peak_over_limit)
    }

    fn csv(&self) -> String {
        let rate = self.path.rate;
        let of = |value: Option<f64>| value.map_or_else(String::new, |v| format!("{v:.6}"));
        let numbers = [
            Some(self.path.length_mm.total),
            Some(self.path.machine_time_s.total),
            rate.map(|r| r.peak_over_limit),
            rate.map(|r| 100.0 * r.near_limit),
            rate.map(|r| r.variation),
            rate.map(|r| r.engagement_deg),
            rate.map(|r| r.feed_per_tooth_mm),
            rate.and_then(|r| r.power_w),
            rate.and_then(|r| r.force_n),
        ];
        let last = [of(self.measured()), of(self.seconds)];
        let kept = self.verification.map_or_else(String::new, |v| v.passed.to_string());
        let fields = core::iter::once(self.name.to_owned())
            .chain(numbers.map(of))
            .chain([self.loops.to_string()])
            .chain(last)
            .chain([kept, String::new()]);
        fields.collect::<Vec<_>>().join(",")
    }
}

/// The rows as comma-separated values under [`CSV_HEADER`]; empty fields where there is no figure, the reason last
/// where a control was refused.
pub fn to_csv(rows: &[Row]) -> String {
    let mut out = format!("{CSV_HEADER}\n");
    let empty = CSV_HEADER.matches(',').count();
    for line in lines(rows) {
        let _ = match line {
            Ok(line) => writeln!(out, "{}", line.csv()),
            Err((name, why)) => writeln!(out, "{name}{}{}", ",".repeat(empty), quoted(why)),
        };
    }
    out
}
