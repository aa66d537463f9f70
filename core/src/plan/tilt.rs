//! How the machine of a job tilts its cutter.

use crate::cutter_location::ToolAxis;
use crate::geometry::DVec3;
use crate::job::Job;
use crate::machine::Axes;
use crate::strip_width::Strip;
use crate::strips::strip;
use crate::tool::ToolKind;

/// How the tool axis is determined at a place of the surface.
pub fn axis_rule(job: &Job) -> ToolAxis {
    match job.machine.axes {
        Axes::ThreeAxis => ToolAxis::Fixed(DVec3::Z),
        Axes::Xyzac => ToolAxis::Lead(job.cut.lead),
    }
}

/// The cutter if it is tilted and has a flat bottom.
pub fn tilted(job: &Job) -> Option<Strip> {
    let is_tilted = job.machine.axes == Axes::Xyzac && job.tool.kind() != ToolKind::Ball;
    is_tilted.then(|| strip(job, job.cut.tolerance))
}
