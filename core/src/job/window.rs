//! The window that a job has where its texture is asked for and no more is said of it.

use super::complete::Job;
use super::texture::{TextureCells, TextureOptions};
use crate::geometry::{DVec2, DVec3};

/// A line of a window holds so many cusps by default, each of its five sections one: side steps across the feed, turns of
/// the spindle along it.
const CUSPS: f64 = 5.0;
/// Length of a window by default, widths, at least: a strip that is narrower is hard to look at.
const NARROWEST: f64 = 0.25;
/// Cells in the smaller of feed per tooth and side step by default.
const CELLS: f64 = 10.0;

impl TextureOptions {
    /// All of the surface of a job, with the feed's direction where it comes nearest to the origin.
    pub fn of_all(job: &Job) -> Self {
        Self { whole: true, ..Self::about(DVec3::ZERO, job) }
    }

    /// The window of a job about a place, mm, where nothing else is said of it: five side steps wide, five turns of the
    /// spindle long or a quarter of its width, ten cells in the smaller of feed per tooth and side step, teeth that stand
    /// evenly.
    pub fn about(at: DVec3, job: &Job) -> Self {
        let side_step = job.nominal_side_step();
        let per_turn = job.cut.feed / job.cut.spindle;
        let per_tooth = per_turn / f64::from(job.flutes);
        let width = CUSPS * side_step;
        Self {
            at,
            whole: false,
            size: DVec2::new((CUSPS * per_turn).max(NARROWEST * width), width),
            spacing: per_tooth.min(side_step) / CELLS,
            runout: 0.0,
            runout_angle: 0.0,
            tooth_runout: vec![0.0; job.flutes as usize],
            spindle_phase: 0.0,
            cells: TextureCells::Uniform,
        }
    }
}
