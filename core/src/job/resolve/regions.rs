//! The division into regions.

use super::resolver::Resolver;
use crate::job::complete::Job;
use crate::job::path::{Boundary, Pattern};
use crate::job::regions::{
    DistortionOptions, Division, RegionMethod, RegionOptions, RegionOrder, TensorOptions,
};
use crate::tool::Tool;

/// Side of a square of the least area that a region has by default, tool diameters.
const LEAST_SIDE: f64 = 1.5;
/// Keys that say nothing about a single region.
const KEYS: [&str; 3] = ["min_area", "blend", "order"];

impl Resolver<'_> {
    /// All but the blend that follows from the side step: 0.
    pub(super) fn regions(&mut self, tool: Tool) -> RegionOptions {
        let table = &self.file.regions;
        let method = table.method.unwrap_or(RegionMethod::Single);
        let side = 2.0 * LEAST_SIDE * tool.radius();
        let options = RegionOptions {
            division: match method {
                RegionMethod::Single => Division::Single,
                RegionMethod::Distortion => Division::Distortion(self.distortion()),
                RegionMethod::Tensor => Division::Tensor(self.tensor()),
            },
            min_area: table.min_area.map_or(side * side, |area| area * self.unit * self.unit),
            blend: self.length(table.blend, 0.0),
            order: table.order.unwrap_or(RegionOrder::Shortest),
        };
        self.check_regions(method);
        options
    }

    fn distortion(&self) -> DistortionOptions {
        let table = &self.file.regions.distortion;
        let default = DistortionOptions::default();
        DistortionOptions {
            measure: table.measure.unwrap_or(default.measure),
            threshold: table.threshold.unwrap_or(default.threshold),
            uniformity: table.uniformity.unwrap_or(default.uniformity),
            depth: table.depth.unwrap_or(default.depth),
            compensation: table.compensation.unwrap_or(default.compensation),
        }
    }

    fn tensor(&mut self) -> TensorOptions {
        let table = &self.file.regions.tensor;
        let default = TensorOptions::default();
        TensorOptions {
            scale: table.scale.map(|scale| scale * self.unit),
            least_gain: table.least_gain.unwrap_or(default.least_gain),
        }
    }

    /// Strips overlap by a side step at most: then the outermost passes lie on the border.
    pub(super) fn check_blend(&mut self, job: &Job) {
        let most = job.nominal_side_step();
        if job.regions.blend > most {
            let blend = self.show(job.regions.blend);
            let message =
                format!("{blend} is more than the nominal side step, {}", self.show(most));
            let help = "the outermost passes of both regions already run on their border with a whole \
                        side step";
            self.fault("regions.blend", message, help);
        }
    }

    fn check_regions(&mut self, method: RegionMethod) {
        let named = self.named("regions.method");
        let mut refuse = |key: String| {
            if self.places.has(&key) {
                let message = format!("says nothing about {named} = {:?}", method.name());
                self.fault(&key, message, "leave it out, or choose another method");
            }
        };
        if method == RegionMethod::Single {
            KEYS.iter().for_each(|key| refuse(format!("regions.{key}")));
        }
        if method != RegionMethod::Distortion {
            refuse("regions.distortion".into());
        }
        if method != RegionMethod::Tensor {
            refuse("regions.tensor".into());
        }
        if method != RegionMethod::Single
            && self.file.path.pattern.is_some_and(Pattern::divides_itself)
        {
            let message = format!("divides the surface itself, as {named} would");
            self.fault("path.pattern", message, "choose one of the two");
        }
        if method != RegionMethod::Single && self.file.path.boundary == Some(Boundary::Wall) {
            let message = format!("walls need a single region, which excludes {named}");
            self.fault("path.boundary", message, "give `boundary = \"open\"`");
        }
    }
}
