//! The window whose texture is simulated.

use super::Resolver;
use crate::geometry::DVec2;
use crate::job::units::radians;
use crate::job::{Job, TextureCells, TextureOptions};

/// Sides of a window by default, nominal side steps: each of the five sections of a line holds a cusp.
const SIDE_STEPS: f64 = 5.0;
/// Cells in the smaller of feed per tooth and side step by default.
const CELLS: f64 = 10.0;

impl Resolver<'_> {
    /// The window, if the job has one. `job`: all of it but its window.
    pub(super) fn texture(&mut self, job: &Job) -> Option<TextureOptions> {
        let table = &self.file.texture;
        let at = self.point(table.at?);
        let side_step = job.nominal_side_step();
        let per_tooth = job.cut.feed / (job.cut.spindle * f64::from(job.flutes));
        let size = match table.size {
            Some(size) => DVec2::from(size) * self.unit,
            None => DVec2::splat(SIDE_STEPS * side_step),
        };
        let flutes = job.flutes as usize;
        let teeth = table.tooth_runout.clone().unwrap_or_else(|| vec![0.0; flutes]);
        if teeth.len() != flutes {
            let message = format!("{} numbers for {flutes} flutes", teeth.len());
            let named = self.named("tool.flutes");
            self.fault("texture.tooth_runout", message, format!("give one for each of {named}"));
        }
        Some(TextureOptions {
            at,
            size,
            spacing: self.length(table.spacing, per_tooth.min(side_step) / CELLS),
            runout: self.length(table.runout, 0.0),
            runout_angle: radians(table.runout_angle.unwrap_or(0.0)),
            tooth_runout: teeth.iter().map(|t| t * self.unit).collect(),
            spindle_phase: radians(table.spindle_phase.unwrap_or(0.0)),
            cells: table.discretisation.unwrap_or(TextureCells::Uniform),
        })
    }
}
