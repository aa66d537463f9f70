//! One job planned with several lead angles and feeds per tooth: the texture of its window, and the machine time.
//!
//! Everything else is taken from the job, including its limit on the removal rate; the grid is the same for all: that
//! of the job or, in a window, a finer one for the least feed per tooth. Every path is verified.

use super::{judged, quoted};
use crate::results::ResultsError;
use crate::results::texture::{Simulated, window_of};
use core::fmt::Write;
use evencut_core::geometry::OrderBy;
use evencut_core::job::{Job, TextureOptions};
use evencut_core::machine::Axes;
use evencut_core::plan::{Prepared, Stage, plan_on, stock_of};
use evencut_core::texture::export::Matrix;
use evencut_core::units::per_minute;
use evencut_output::preview::{TexturePanel, texture_panels};
use evencut_output::report::TextureFigures;
use std::sync::Arc;
use thiserror::Error;

/// Header of the table as comma-separated values.
pub const CSV_HEADER: &str = "tilt_deg,feed_per_tooth_mm,feed_mm_per_min,length_mm,machine_time_s,sa_um,sq_um,sz_um,\
ssk,sku,ra_along_um,rz_along_um,ra_across_um,rz_across_um,tests_per_node,kept,refused";

/// Cells in a feed per tooth, at least.
const CELLS: f64 = 10.0;

/// What is varied.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Choice {
    /// Lead of the axis toward the feed, rad; `None` for the job's.
    pub tilt: Option<f64>,
    /// Feed per tooth, mm; `None` for the job's.
    pub feed_per_tooth: Option<f64>,
}

/// Why a choice is not possible.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum ChoiceError {
    /// The machine keeps its axis upright.
    #[error("a tilt needs a machine with rotary axes: give axes = \"xyzac\" in [machine]")]
    Upright,
    /// An upright cutter with a flat bottom on a machine that tilts it.
    #[error(
        "at a tilt of 0 on five axes a cutter with a flat bottom cuts with its heel: give a larger tilt"
    )]
    Heel,
    /// The feed is above that of the machine.
    #[error("{feed:.0} mm/min is above machine.max_feed, {most:.0} mm/min")]
    TooFast {
        /// The feed that follows from the feed per tooth, mm/min.
        feed: f64,
        /// The machine's greatest feed, mm/min.
        most: f64,
    },
}

/// A choice and its result.
#[derive(Clone, Debug)]
pub struct Row {
    /// The job that was planned.
    pub job: Job,
    /// Its result, or why there is none.
    pub made: Result<Made, String>,
}

/// A texture and what it takes to machine it.
#[derive(Clone, Debug)]
pub struct Made {
    /// The texture.
    pub figures: TextureFigures,
    /// Heights over the mean plane, mm, along the feed first.
    pub heights: Vec<f64>,
    /// Length of all passes, mm.
    pub length: f64,
    /// Time on the machine, s.
    pub machine_time: f64,
    /// The limits that the verification found broken, in words.
    pub broken: Vec<String>,
}

impl Choice {
    /// The job with this choice. `finest`: the least feed per tooth of all choices, mm.
    ///
    /// # Errors
    /// [`ChoiceError`]: what the job's machine does not allow.
    pub fn of(self, job: &Job, finest: f64) -> Result<Job, ChoiceError> {
        let mut job = job.clone();
        if let Some(tilt) = self.tilt {
            if job.machine.axes == Axes::ThreeAxis && tilt != 0.0 {
                return Err(ChoiceError::Upright);
            }
            if job.machine.axes != Axes::ThreeAxis && tilt == 0.0 && job.tool.bottom_radius() > 0.0
            {
                return Err(ChoiceError::Heel);
            }
            job.cut.lead = tilt;
        }
        if let Some(per_tooth) = self.feed_per_tooth {
            let feed = per_tooth * job.cut.spindle * f64::from(job.flutes);
            if feed > job.machine.max_feed {
                let [feed, most] = [feed, job.machine.max_feed].map(per_minute);
                return Err(ChoiceError::TooFast { feed, most });
            }
            job.cut.feed = feed;
        }
        // A whole surface so fine would be too much.
        if let Some(TextureOptions { spacing, whole: false, .. }) = &mut job.texture {
            *spacing = spacing.min(finest / CELLS);
        }
        Ok(job)
    }
}

/// Plans and verifies a job on its surface, and simulates its window.
///
/// # Errors
/// As [`texture_results`](crate::results::texture::texture_results), and those of the verification.
pub fn made(prepared: &Arc<Prepared>, job: &Job, threads: usize) -> Result<Made, ResultsError> {
    let options = window_of(job)?;
    let planned = plan_on(prepared, job, &stock_of(job), threads, &mut |_: Stage, _| {})?;
    let on = (&**prepared, &planned.toolpath);
    let simulated = Simulated::of(job, options, on, threads, &mut |_| {})?;
    let report = judged(job, &planned, threads)?.report;
    let levelled = simulated.levelled();
    Ok(Made {
        figures: simulated.figures(job, &levelled),
        heights: levelled.heights().to_vec(),
        length: report.passes.length_mm,
        machine_time: report.delivered.machine_time_s.total,
        broken: report.verification.map_or_else(Vec::new, |v| v.broken),
    })
}

/// Lead in degrees and feed per tooth in mm of a job.
fn choice_of(job: &Job) -> (f64, f64) {
    (job.cut.lead.to_degrees(), job.cut.feed / (job.cut.spindle * f64::from(job.flutes)))
}

/// The rows as aligned text, heights in µm.
pub fn to_text(rows: &[Row]) -> String {
    let mut out = format!(
        "{:>6}{:>10}{:>10}{:>10}{:>9}{:>9}{:>9}{:>9}{:>10}{:>10}{:>11}{:>11}  {}\n",
        "tilt",
        "mm/tooth",
        "mm/min",
        "mm",
        "min:s",
        "Sa",
        "Sq",
        "Sz",
        "Ra along",
        "Rz along",
        "Ra across",
        "Rz across",
        "kept"
    );
    for Row { job, made } in rows {
        let (tilt, per_tooth) = choice_of(job);
        // Writing to a string cannot fail.
        let _ = write!(
            out,
            "{:>6}{per_tooth:>10.4}{:>10.0}",
            format!("{tilt:.1}°"),
            per_minute(job.cut.feed)
        );
        let _ = match made {
            Ok(made) => writeln!(out, "{}", text_row(made)),
            Err(message) => writeln!(out, "  {message}"),
        };
    }
    let mut notes: Vec<&String> = Vec::new();
    for Row { job, made } in rows {
        let Ok(made) = made else { continue };
        let (tilt, per_tooth) = choice_of(job);
        for broken in &made.broken {
            let _ = writeln!(out, "{tilt:.1}°, {per_tooth:.4} mm: {broken}");
        }
        // Most say the same of all.
        notes.extend(made.figures.notes.iter());
    }
    notes.order_total();
    notes.dedup();
    notes.iter().for_each(|note| {
        let _ = writeln!(out, "note: {note}");
    });
    out
}

fn text_row(made: &Made) -> String {
    let time = made.machine_time.round() as u64;
    let TextureFigures { areal, along, across, .. } = &made.figures;
    format!(
        "{:>10.0}{:>9}{:>9.3}{:>9.3}{:>9.3}{:>10.3}{:>10.3}{:>11.3}{:>11.3}  {}",
        made.length,
        format!("{}:{:02}", time / 60, time % 60),
        areal.sa_um,
        areal.sq_um,
        areal.sz_um,
        along.ra_um,
        along.rz_um,
        across.ra_um,
        across.rz_um,
        if made.broken.is_empty() { "yes" } else { "no" },
    )
}

/// The rows as comma-separated values under [`CSV_HEADER`]; empty fields where there is no figure, the reason last
/// where a choice was refused.
pub fn to_csv(rows: &[Row]) -> String {
    let mut out = format!("{CSV_HEADER}\n");
    for Row { job, made } in rows {
        let (tilt, per_tooth) = choice_of(job);
        let choice = format!("{tilt:.3},{per_tooth:.6},{:.3}", per_minute(job.cut.feed));
        let fields = match made {
            Ok(made) => {
                let TextureFigures { areal: a, along, across, .. } = &made.figures;
                let numbers = [
                    made.length,
                    made.machine_time,
                    a.sa_um,
                    a.sq_um,
                    a.sz_um,
                    a.ssk,
                    a.sku,
                    along.ra_um,
                    along.rz_um,
                    across.ra_um,
                    across.rz_um,
                    made.figures.work.tests as f64 / made.heights.len().max(1) as f64,
                ];
                let numbers = numbers.map(|x| format!("{x:.6}")).join(",");
                format!("{numbers},{},", made.broken.is_empty())
            }
            Err(why) => ",".repeat(CSV_HEADER.matches(',').count() - 3) + &quoted(why),
        };
        let _ = writeln!(out, "{choice},{fields}");
    }
    out
}

/// The maps side by side, in the same colours.
pub fn to_svg<'a>(title: &str, rows: &'a [Row]) -> String {
    let panel = |row: &'a Row| -> Option<TexturePanel<'a>> {
        let Row { job, made } = row;
        let made = made.as_ref().ok()?;
        let (tilt, per_tooth) = choice_of(job);
        let time = made.machine_time.round() as u64;
        let figures = &made.figures;
        Some(TexturePanel {
            heading: format!("tilt {tilt:.1}°, {per_tooth:.3} mm a tooth"),
            caption: format!(
                "Sa {:.3}, Sz {:.3} µm; {}:{:02} min",
                figures.areal.sa_um,
                figures.areal.sz_um,
                time / 60,
                time % 60
            ),
            levelled: Matrix {
                counts: figures.window.nodes.map(|n| n as usize),
                steps: figures.window.spacing_mm,
                heights: &made.heights,
            },
        })
    };
    let panels: Vec<TexturePanel> = rows.iter().filter_map(panel).collect();
    texture_panels(title, &panels)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::results::texture::tests::{JOB, WINDOW};
    use evencut_core::job;
    use evencut_core::plan::{Files, SurfaceKeys};

    /// The job on a machine with these axes.
    fn on(axes: &str) -> Job {
        let text = format!("{JOB}[machine]\naxes = \"{axes}\"\n{WINDOW}");
        job::read(text.as_bytes()).unwrap().job
    }

    #[test]
    fn tilts_and_feeds_are_compared_on_one_grid() {
        let job = on("xyzac");
        let keys = SurfaceKeys::of(&job);
        let prepared = Prepared::new(keys, Files::default(), 1, &mut |_, _| {}).unwrap();
        let row = |tilt: f64, per_tooth: f64| {
            let choice = Choice { tilt: Some(tilt), feed_per_tooth: Some(per_tooth) };
            let job = choice.of(&job, 0.1).unwrap();
            let made = made(&prepared, &job, 1).map_err(|e| e.to_string());
            Row { job, made }
        };
        let rows = [row(0.0, 0.1), row(0.2, 0.1), row(0.2, 0.2)];
        let made = rows.each_ref().map(|row| row.made.as_ref().unwrap());
        let nodes = made.map(|m| m.figures.window.nodes);
        assert!(nodes[0] == nodes[1] && nodes[1] == nodes[2] && nodes[0] == [41, 101]);
        assert!(made.iter().all(|m| m.broken.is_empty()), "{rows:?}");
        // Twice the feed is quicker and leaves larger cusps along it.
        assert!(made[2].machine_time < made[1].machine_time);
        assert!(made[2].figures.along.rt_um > 2.0 * made[1].figures.along.rt_um);
        let text = to_text(&rows);
        assert!(text.contains("11.5°") && text.lines().count() >= 4, "{text}");
        let csv = to_csv(&rows);
        let columns = CSV_HEADER.split(',').count();
        assert!(csv.lines().all(|line| line.split(',').count() == columns), "{csv}");
        let failed = Row { job: rows[0].job.clone(), made: Err("no".into()) };
        assert!(to_csv(&[failed]).lines().all(|line| line.split(',').count() == columns));
        assert_eq!(to_svg("a job", &rows).matches("<image ").count(), 3);
    }

    #[test]
    fn what_a_machine_cannot_do_is_refused() {
        let upright = on("3");
        let choice = |tilt, per_tooth| Choice { tilt: Some(tilt), feed_per_tooth: Some(per_tooth) };
        assert_eq!(choice(0.1, 0.1).of(&upright, 0.1), Err(ChoiceError::Upright));
        assert!(choice(0.0, 0.1).of(&upright, 0.1).is_ok());
        let most = upright.machine.max_feed;
        let fast = choice(0.0, 2.0 * most / (100.0 * 2.0)).of(&upright, 0.1);
        assert!(matches!(fast, Err(ChoiceError::TooFast { .. })));
    }
}
