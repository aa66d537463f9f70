//! What in a complete job deserves a second look.

use super::resolver::Resolver;
use crate::job::complete::Job;
use crate::job::cut::Stepover;
use crate::job::force::{ForceControl, MrrLimit};
use crate::machine::Axes;
use crate::units::per_minute;
use core::f64::consts::PI;

/// Clearance of rapids, mm, below which set-ups are hardly exact enough.
const LOW: f64 = 0.1;
/// Feed per tooth, mm for cutters of 1 mm and more, in proportion for smaller ones, below which edges, which are rounded
/// by some micrometres, rub.
const THINNEST: f64 = 0.001;
/// Cutting speed, m/min, above which no metal is milled.
const FASTEST: f64 = 10_000.0;

impl Resolver<'_> {
    /// Warnings about a complete job.
    pub(super) fn add_warnings(&mut self, job: &Job) {
        if let Stepover::Scallop(h) = job.cut.stepover
            && job.cut.tolerance >= h
        {
            let message = format!(
                "{} is not below the scallop {}",
                self.show(job.cut.tolerance),
                self.show(h)
            );
            let help =
                "give half of the scallop or less: deviations up to the tolerance add to the cusps";
            self.warn("cut.tolerance", message, help);
        }
        let is_unknown = job.assembly.sections.is_empty() && job.hub.is_none();
        if is_unknown && !job.avoid.is_empty() && job.machine.axes != Axes::ThreeAxis {
            let message = format!(
                "only the cutter up to {} above its tip is kept clear of what is avoided: nothing is known of shank and holder",
                self.show(4.0 * job.tool.radius())
            );
            self.warn("avoid", message, "give `tool.length`, `tool.stickout` and `tool.holder`");
        }
        if let Some(chord) = job.surface.chord
            && chord > job.cut.tolerance
        {
            let message = format!(
                "triangles up to {} off the surface, above the tolerance {}",
                self.show(chord),
                self.show(job.cut.tolerance)
            );
            let help = "the cusps follow the triangles: give half the tolerance or less";
            self.warn("surface.chord", message, help);
        }
        if job.machine.clearance < LOW {
            let clearance = self.show(job.machine.clearance);
            let message = format!("rapids run only {clearance} above part and stock");
            let help = "set-ups are rarely exact to that: give some millimetres";
            self.warn("machine.clearance", message, help);
        }
        let (limit, straight) = (per_minute(job.mrr_limit()), per_minute(job.nominal_mrr()));
        if limit < straight && job.force.control != ForceControl::Off {
            let key = match job.force.limit {
                Some(MrrLimit::Absolute(_)) => "force.mrr_limit",
                Some(MrrLimit::Relative(_)) => "force.relative",
                None if job.force.power.is_some() => "force.power",
                None => "force.cutting_force",
            };
            let message = format!(
                "a straight pass removes {straight:.1} mm³/min, above the limit of {limit:.1} mm³/min"
            );
            self.warn(
                key,
                message,
                "every pass will have to be slowed or cut with trochoids; lower feed, depth or side step",
            );
        }
        for key in ["mrr_limit", "power", "cutting_force", "min_chip", "max_engagement"] {
            let key = format!("force.{key}");
            if job.force.control == ForceControl::Off && self.places.has(&key) {
                let message = "is neither kept nor judged, since `force.control` is \"off\"";
                self.warn(&key, message, "give `control = \"feed\"`, or remove the limit");
            }
        }
        let per_tooth = job.cut.feed / (job.cut.spindle * f64::from(job.flutes));
        if per_tooth > 0.1 * job.tool.radius() {
            let message =
                format!("{} per tooth is more than 5 % of the diameter", self.show(per_tooth));
            self.warn("cut.feed", message, "check `cut.feed`, `cut.spindle` and `tool.flutes`");
        }
        let diameter = 2.0 * job.tool.radius();
        if per_tooth < THINNEST * diameter.min(1.0) {
            let message =
                format!("{} per tooth is less than an edge can cut", self.show(per_tooth));
            self.warn("cut.feed", message, "check `cut.feed`, `cut.spindle` and `tool.flutes`");
        }
        let speed = 1e-3 * per_minute(PI * diameter * job.cut.spindle);
        if speed > FASTEST {
            let message = format!("the cutting speed would be {speed:.0} m/min");
            self.warn("cut.spindle", message, "check it against the cutter's diameter");
        }
        if job.cut.axial_depth > diameter {
            let message =
                format!("{} is deeper than the tool is wide", self.show(job.cut.axial_depth));
            self.warn("cut.axial_depth", message, "check it against the length of the flutes");
        }
        if let Stepover::Scallop(h) = job.cut.stepover
            && h >= job.cut.axial_depth
        {
            let depth = self.show(job.cut.axial_depth);
            let message = format!("cusps of {} are as high as the stock, {depth}", self.show(h));
            self.warn(
                "cut.scallop",
                message,
                "lower it, or set `cut.axial_depth` to the depth to be cut",
            );
        }
    }
}
