//! The window whose texture is simulated.

use super::resolver::Resolver;
use crate::geometry::DVec2;
use crate::job::complete::Job;
use crate::job::file::TextureTable;
use crate::job::texture::{TextureCells, TextureOptions};
use crate::job::units::radians;
use crate::machine::SpindleDirection;

impl Resolver<'_> {
    /// The window, if the job has one. `job`: all of it but its window.
    pub(super) fn texture(&mut self, job: &Job) -> Option<TextureOptions> {
        let table = &self.file.texture;
        let whole = table.whole.unwrap_or(false);
        let by_default = match table.at {
            Some(at) => TextureOptions { whole, ..TextureOptions::about(self.point(at), job) },
            None if whole => TextureOptions::of_all(job),
            None => {
                if *table != TextureTable::default() {
                    let help = "give `at = [x, y, z]`, a place on the surface, or `whole = true`";
                    self.fault("texture", "a window without a place", help);
                }
                return None;
            }
        };
        if whole && table.discretisation == Some(TextureCells::Constant) {
            let message = "a net of constant cells cannot cover a whole surface";
            self.fault("texture.discretisation", message, "use \"uniform\"");
        }
        if job.setup.spindle == SpindleDirection::CounterClockwise {
            let message = "textures are simulated of cutters that turn clockwise";
            self.fault("cut.spindle_direction", message, "leave it out, or leave out [texture]");
        }
        let flutes = by_default.tooth_runout.len();
        let teeth = match &table.tooth_runout {
            Some(teeth) => teeth.iter().map(|t| t * self.unit).collect(),
            None => by_default.tooth_runout,
        };
        if teeth.len() != flutes {
            let message = format!("{} numbers for {flutes} flutes", teeth.len());
            let named = self.named("tool.flutes");
            self.fault("texture.tooth_runout", message, format!("give one for each of {named}"));
        }
        Some(TextureOptions {
            size: table.size.map_or(by_default.size, |size| DVec2::from(size) * self.unit),
            spacing: self.length(table.spacing, by_default.spacing),
            runout: self.length(table.runout, by_default.runout),
            runout_angle: radians(table.runout_angle.unwrap_or(0.0)),
            tooth_runout: teeth,
            spindle_phase: radians(table.spindle_phase.unwrap_or(0.0)),
            cells: table.discretisation.unwrap_or(by_default.cells),
            ..by_default
        })
    }
}
