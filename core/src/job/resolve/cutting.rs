//! The cutter, the cutting data and the trochoids, which must fit each other.

use super::resolver::Resolver;
use crate::job::cut::{Cut, CutDirection, Inaccessible, Stepover};
use crate::job::force::TrochoidOptions;
use crate::job::units::{radians, to_per_minute};
use crate::machine::{Axes, Machine};
use crate::tool::{Tool, ToolKind};
use crate::units::per_second;

/// Largest angle between axis and normal by default, deg.
const LARGEST_TILT: f64 = 45.0;
/// Cutting speed that the default spindle speed is made of, mm/min.
const CUTTING_SPEED: f64 = 150_000.0;

/// Relative difference below which a written corner radius is the cutter radius: inches and
/// thirds are rounded in files, and a ball of 6.35 mm has no flat of a nanometre.
const SAME_RADIUS: f64 = 1e-6;

/// Endings of libraries of tools.
const LIBRARIES: [&str; 5] = ["toml", "json", "fctb", "fctl", "tools"];

impl Resolver<'_> {
    pub(super) fn tool(&mut self) -> Option<Tool> {
        let table = &self.file.tool;
        if let Some(file) = &table.library {
            self.check_file("tool.library", file, &LIBRARIES);
        }
        let is_known = ["tool.diameter", "tool.library"].iter().any(|key| self.places.has(key));
        if self.places.found("tool") && !is_known {
            let help = "expected a number from 0.001 to 500 (mm), or a file of tools, `library`";
            self.fault("tool.diameter", "missing; it has no default", help);
        }
        let radius = 0.5 * (table.diameter? * self.unit);
        let corner = table.corner_radius.map(|c| c * self.unit);
        let corner = corner.map(|c| if same_radius(c, radius) { radius } else { c });
        let fitting = corner.filter(|c| *c <= radius);
        if let (Some(c), None) = (corner, fitting) {
            let help = format!("give at most the cutter radius, {}", self.show(radius));
            self.fault("tool.corner_radius", format!("{} is more than fits", self.show(c)), help);
        }
        self.check_corner(fitting, radius);
        let default = match table.kind {
            Some(ToolKind::Flat) => 0.0,
            Some(ToolKind::Bull) => 0.2 * radius,
            Some(ToolKind::Ball) | None => radius,
        };
        match Tool::new(radius, fitting.unwrap_or(default)) {
            Ok(tool) => Some(tool),
            Err(error) => {
                self.fault("tool", error.to_string(), "correct `diameter` or `corner_radius`");
                None
            }
        }
    }

    /// Kind and corner radius, where both are given, must agree.
    fn check_corner(&mut self, corner: Option<f64>, radius: f64) {
        let (Some(corner), Some(kind)) = (corner, self.file.tool.kind) else { return };
        let (agrees, rule) = match kind {
            ToolKind::Ball => {
                (corner == radius, format!("{}, half the diameter", self.show(radius)))
            }
            ToolKind::Flat => (corner == 0.0, "0".to_owned()),
            ToolKind::Bull => (
                corner > 0.0 && corner < radius,
                format!("more than 0 and less than {}", self.show(radius)),
            ),
        };
        if !agrees {
            let kind = kind.name();
            let message =
                format!("{}; the corner radius of a {kind} end is {rule}", self.show(corner));
            let help = "correct it, or leave out `tool.kind`, which follows from it";
            self.fault("tool.corner_radius", message, help);
        }
    }

    pub(super) fn cut(&mut self, tool: Option<Tool>, machine: &Machine) -> Option<Cut> {
        let table = &self.file.cut;
        let diameter = tool.map_or(10.0, |t| 2.0 * t.radius());
        let lead = radians(table.lead.unwrap_or(match machine.axes {
            Axes::ThreeAxis => 0.0,
            Axes::FiveAxis(_) => 5.0,
        }));
        let stepover = self.stepover();
        if let (Some(tool), Some(stepover)) = (tool, stepover) {
            self.check_stepover(tool, stepover, lead);
        }
        self.check_lead(tool, machine.axes, lead);
        self.check_tilt(machine.axes);
        let largest_tilt = match machine.axes {
            Axes::ThreeAxis => 0.0,
            Axes::FiveAxis(_) => radians(table.max_tilt.unwrap_or(LARGEST_TILT)),
        };
        let axial_depth = self.length(table.axial_depth, 0.05 * diameter);
        if tool.is_some() && axial_depth > 4.0 * diameter {
            let help = format!("give at most 4 diameters, {}", self.show(4.0 * diameter));
            self.fault(
                "cut.axial_depth",
                format!("{} is deeper than flutes are long", self.show(axial_depth)),
                help,
            );
        }
        let feed = per_second(table.feed? * self.unit);
        self.check_feed("cut.feed", feed, machine);
        let speed = (CUTTING_SPEED / (std::f64::consts::PI * diameter)).round();
        Some(Cut {
            stepover: stepover?,
            axial_depth,
            feed,
            spindle: per_second(table.spindle.unwrap_or(speed.min(12_000.0))),
            lead,
            largest_tilt,
            tolerance: self.length(table.tolerance, 0.005),
            allowance: self.length(table.allowance, 0.0),
            direction: table.direction.unwrap_or(CutDirection::Climb),
            inaccessible: table.inaccessible.unwrap_or(Inaccessible::Lift),
        })
    }

    fn stepover(&mut self) -> Option<Stepover> {
        let table = &self.file.cut;
        match (self.places.has("cut.scallop"), self.places.has("cut.stepover")) {
            (true, true) => {
                let message = format!("given beside {}", self.named("cut.scallop"));
                self.fault("cut.stepover", message, "keep one of the two");
                None
            }
            (false, false) => {
                if self.places.found("cut") {
                    let help = "give a scallop height, `scallop = 0.01`, or a side step, \
                                `stepover = 0.5`";
                    self.fault("cut", "neither `scallop` nor `stepover` is given", help);
                }
                None
            }
            _ => match (table.scallop, table.stepover) {
                (Some(h), _) => Some(Stepover::Scallop(h * self.unit)),
                (None, side_step) => side_step.map(|d| Stepover::Fixed(d * self.unit)),
            },
        }
    }

    fn check_stepover(&mut self, tool: Tool, stepover: Stepover, lead: f64) {
        let (radius, corner) = (tool.radius(), tool.corner_radius());
        match stepover {
            Stepover::Fixed(d) if d > 2.0 * radius => {
                let help = format!("give at most the tool diameter, {}", self.show(2.0 * radius));
                let message = format!("{} would leave ridges between the passes", self.show(d));
                self.fault("cut.stepover", message, help);
            }
            Stepover::Scallop(h) if corner > 0.0 && h > corner => {
                let help =
                    format!("give at most {}; finishing takes 0.005 to 0.05 mm", self.show(corner));
                let message = format!("{} is higher than the corner radius", self.show(h));
                self.fault("cut.scallop", message, help);
            }
            Stepover::Scallop(h) if h > radius => {
                let help =
                    format!("give at most {}; finishing takes 0.005 to 0.05 mm", self.show(radius));
                let message = format!("{} is higher than the cutter radius", self.show(h));
                self.fault("cut.scallop", message, help);
            }
            Stepover::Scallop(_) if corner == 0.0 && lead == 0.0 => {
                let message = "an upright flat end leaves no scallop on a flat surface";
                let help = "give `cut.stepover`, or a ball or bull end, or five axes and \
                            `cut.lead`";
                self.fault("cut.scallop", message, help);
            }
            _ => {}
        }
    }

    fn check_lead(&mut self, tool: Option<Tool>, axes: Axes, lead: f64) {
        if axes != Axes::ThreeAxis && self.places.has("surface.steepest") {
            let help = "remove it, or give `axes = \"3\"` in [machine]";
            self.fault("surface.steepest", "needs a fixed tool axis: three axes", help);
        }
        match axes {
            Axes::ThreeAxis if lead > 0.0 => {
                let message = format!(
                    "a tilted tool axis, but {} has three axes",
                    self.named("machine.axes")
                );
                let help = "give `lead = 0`, or five axes in [machine], such as `axes = \"xyzac\"`";
                self.fault("cut.lead", message, help);
            }
            Axes::FiveAxis(_) if lead == 0.0 => {
                let Some(tool) = tool.filter(|t| t.bottom_radius() > 0.0) else { return };
                let kind = tool.kind().name();
                let message = format!("a {kind} end without lead cuts with its heel on five axes");
                self.fault("cut.lead", message, "give a lead above 0; 3 to 10 deg are usual");
            }
            _ => {}
        }
    }

    fn check_tilt(&mut self, axes: Axes) {
        if axes == Axes::ThreeAxis && self.places.has("cut.max_tilt") {
            let message =
                format!("the axis does not turn: {} has three axes", self.named("machine.axes"));
            let help = "leave it out, or give five axes in [machine], such as `axes = \"xyzac\"`";
            self.fault("cut.max_tilt", message, help);
        }
    }

    fn check_feed(&mut self, key: &str, feed: f64, machine: &Machine) {
        if feed > machine.max_feed {
            let fastest = to_per_minute(machine.max_feed);
            let found = to_per_minute(feed);
            let message =
                format!("{}/min is above {}", self.show(found), self.named("machine.max_feed"));
            self.fault(key, message, format!("give at most {}/min", self.show(fastest)));
        }
    }

    pub(super) fn trochoid(
        &mut self,
        tool: Option<Tool>,
        machine: &Machine,
    ) -> Option<TrochoidOptions> {
        let table = &self.file.trochoid;
        let diameter = 2.0 * tool?.radius();
        let cutting = self.file.cut.feed.map_or(machine.max_feed, |f| per_second(f * self.unit));
        let options = TrochoidOptions {
            max_step: self.length(table.max_step, 0.2 * diameter),
            min_radius: self.length(table.min_radius, 0.05 * diameter),
            return_feed: table.return_feed.map_or_else(
                || (2.5 * cutting).min(machine.max_feed),
                |f| per_second(f * self.unit),
            ),
        };
        if options.max_step > diameter {
            let message = format!("{} leaves material between loops", self.show(options.max_step));
            let help = format!("give at most the tool diameter, {}", self.show(diameter));
            self.fault("trochoid.max_step", message, help);
        }
        // Less than the smallest bite that is laid, with room for the scale of the map.
        if options.max_step < 2e-3 * diameter {
            let message = format!("{}: loops without number", self.show(options.max_step));
            let help = format!(
                "give at least a five-hundredth of the tool diameter, {}",
                self.show(2e-3 * diameter)
            );
            self.fault("trochoid.max_step", message, help);
        }
        if options.min_radius > 2.0 * diameter {
            let message =
                format!("{}: loops as wide as several cutters", self.show(options.min_radius));
            let help =
                format!("give at most twice the tool diameter, {}", self.show(2.0 * diameter));
            self.fault("trochoid.min_radius", message, help);
        }
        self.check_feed("trochoid.return_feed", options.return_feed, machine);
        Some(options)
    }
}

fn same_radius(a: f64, b: f64) -> bool {
    (a - b).abs() <= SAME_RADIUS * b
}
