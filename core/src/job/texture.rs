//! The window whose texture is simulated, and how the teeth stand.

use super::Job;
use crate::geometry::{DVec2, DVec3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A line of a window holds so many cusps by default, each of its five sections one: side steps across the feed, turns of
/// the spindle along it.
const CUSPS: f64 = 5.0;
/// Length of a window by default, widths, at least: a strip that is narrower is hard to look at.
const NARROWEST: f64 = 0.25;
/// Cells in the smaller of feed per tooth and side step by default.
const CELLS: f64 = 10.0;

/// Which cells the grid of a window has.
#[derive(Copy, Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum TextureCells {
    /// Even steps of the flat map, at most `spacing` long on the surface.
    Uniform,
    /// A net whose cells are all `spacing` long on the surface.
    Constant,
}

/// A window of the surface, and the teeth.
#[derive(Clone, Debug, PartialEq)]
pub struct TextureOptions {
    /// A place near the window's middle, mm; of the whole surface, one where its direction is that of the feed.
    pub at: DVec3,
    /// Whether it is all of the surface, instead of a window of a size.
    pub whole: bool,
    /// Size along and across the feed, mm.
    pub size: DVec2,
    /// Length of a cell of the grid, mm.
    pub spacing: f64,
    /// Distance of the cutter's axis from that of the spindle, mm.
    pub runout: f64,
    /// Direction of that from tooth 0, rad.
    pub runout_angle: f64,
    /// How much farther out each tooth stands, mm; one for each flute.
    pub tooth_runout: Vec<f64>,
    /// Angle of tooth 0 from the first feed direction when the path starts, rad.
    pub spindle_phase: f64,
    /// Which cells the grid has.
    pub cells: TextureCells,
}

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
