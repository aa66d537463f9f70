//! The blades of a blisk, and the shank and holder that must clear them.

use super::resolver::Resolver;
use crate::geometry::DVec3;
use crate::job::cut::Stepover;
use crate::job::file::{HubTable, ToolTable};
use crate::job::force::ForceControl;
use crate::job::hub::{BladeSurface, HubChannels, HubOptions, HubPasses};
use crate::job::path::Pattern;
use crate::job::surface::SurfaceSource;
use crate::job::{Cut, Force, SurfaceOptions};
use crate::machine::{Axes, Machine};
use crate::tool::{Assembly, AssemblyPart, Section, Tool, ToolKind};

/// Formats of the surfaces of blades.
const FORMATS: [&str; 1] = ["json"];
/// Distance from blades and extension of passes by default, tool diameters.
const CLEARANCE: f64 = 0.02;
const EXTENSION: f64 = 0.5;
/// Lengths of cutter and stickout by default, tool diameters.
const CUTTER: f64 = 2.0;
const STICKOUT: f64 = 10.0;

impl Resolver<'_> {
    pub(super) fn is_hub(&self) -> bool {
        self.file.path.pattern == Some(Pattern::Hub)
    }

    /// The cutter with shank and holder.
    pub(super) fn assembly(&mut self, tool: Tool) -> Assembly {
        let table = &self.file.tool;
        let is_hub = self.is_hub();
        let given = ["length", "shank_diameter", "stickout", "holder"];
        let is_known = is_hub || given.iter().any(|key| self.places.has(&format!("tool.{key}")));
        if self.places.has("tool.clearance") {
            let faulty = match (is_hub, is_known) {
                (true, _) => Some("of a hub it is `hub.clearance`"),
                (_, false) => Some("nothing is known of what is above the cutter"),
                _ => None,
            };
            let help = "leave it out, or give `tool.stickout` and `tool.holder`";
            faulty.into_iter().for_each(|message| self.fault("tool.clearance", message, help));
        }
        let ToolTable { length, shank_diameter, stickout, holder, .. } = table;
        let diameter = 2.0 * tool.radius();
        let cutter_length = self.length(*length, CUTTER * diameter);
        let stickout = self.length(*stickout, (STICKOUT * diameter).max(cutter_length));
        if cutter_length < tool.corner_radius() {
            let help =
                format!("give at least the corner radius, {}", self.show(tool.corner_radius()));
            self.fault("tool.length", "is shorter than the rounding of the end", help);
        }
        if stickout < cutter_length {
            let key =
                if self.places.has("tool.stickout") { "tool.stickout" } else { "tool.length" };
            let help = format!(
                "give a stickout of at least {}, or a shorter `tool.length`",
                self.show(cutter_length)
            );
            self.fault(key, "the cutter is longer than what stands out of the holder", help);
        }
        let radius = 0.5 * self.length(*shank_diameter, diameter);
        let mut sections = vec![Section {
            part: AssemblyPart::Shank,
            heights: [cutter_length, stickout],
            radii: [radius; 2],
        }];
        let mut from = stickout;
        for piece in holder.iter().flatten() {
            let (lower, to) =
                (self.length(piece.diameter, diameter), from + self.length(piece.length, 0.0));
            let upper = self.length(piece.upper_diameter, lower / self.unit * self.unit);
            let radii = [0.5 * lower, 0.5 * upper];
            sections.push(Section { part: AssemblyPart::Holder, heights: [from, to], radii });
            from = to;
        }
        // A shank without length still says where the holder begins.
        let is_there = |s: &Section| s.part == AssemblyPart::Shank || s.heights[1] > s.heights[0];
        sections.retain(|s| is_known && is_there(s));
        Assembly { tool, cutter_length, sections }
    }

    /// The blades, for the pattern that needs them.
    pub(super) fn hub(
        &mut self,
        (surface, tool): (&SurfaceOptions, &Tool),
        (cut, force, machine): (&Cut, &Force, &Machine),
    ) -> Option<HubOptions> {
        let table = &self.file.hub;
        if !self.is_hub() {
            if *table != HubTable::default() {
                let help = "give `path.pattern = \"hub\"`, or leave the table out";
                self.fault("hub", "belongs to the pattern hub", help);
            }
            return None;
        }
        self.check_of_hub(surface, tool, (cut, force, machine));
        let diameter = 2.0 * tool.radius();
        let axis = DVec3::from(table.axis.unwrap_or([0.0, 0.0, 1.0]));
        let length = axis.length();
        if length == 0.0 {
            self.fault("hub.axis", "has no direction", "give for example `axis = [0, 0, 1]`");
        }
        // A direction that is a unit vector already stays as it is.
        let axis = if (length - 1.0).abs() < 1e-15 { axis } else { axis.normalize_or(DVec3::Z) };
        Some(HubOptions {
            blades: table.blades.unwrap_or(2),
            axis,
            origin: self.point(table.origin.unwrap_or_default()),
            blade: table.blade.clone().unwrap_or_default(),
            splitter: table.splitter.clone().unwrap_or_default(),
            clearance: self.length(table.clearance, CLEARANCE * diameter),
            extension: self.length(table.extension, EXTENSION * diameter),
            passes: table.passes.unwrap_or(HubPasses::Shortest),
            channels: table.channels.unwrap_or(HubChannels::All),
        })
    }

    /// What the pattern asks of the other tables.
    fn check_of_hub(
        &mut self,
        surface: &SurfaceOptions,
        tool: &Tool,
        (cut, force, machine): (&Cut, &Force, &Machine),
    ) {
        let table = &self.file.hub;
        if table.blades.is_none() {
            self.fault(
                "hub.blades",
                "required with `path.pattern = \"hub\"`",
                "give the number of blades",
            );
        }
        if table.blade.is_none() {
            let help = "give the surfaces of one blade: `blade = [\"blade.json\", \"fillet.json\"]`, or numbers of \
                        faces of the STEP file";
            self.fault("hub.blade", "required with `path.pattern = \"hub\"`", help);
        }
        let file = match &surface.source {
            SurfaceSource::File(file) => file.as_str(),
            SurfaceSource::Analytic(_) => "",
        };
        let is_step = super::is_step(file);
        if !is_step && !file.to_ascii_lowercase().ends_with(".json") {
            let help = "give its NURBS surface (json), or a STEP file and `surface.face`";
            self.fault("surface.file", "a hub is planned on its smooth surface", help);
        }
        for (key, list) in [("hub.blade", &table.blade), ("hub.splitter", &table.splitter)] {
            for item in list.iter().flatten() {
                match item {
                    BladeSurface::File(file) => self.check_file(key, file, &FORMATS),
                    BladeSurface::Face(_) if is_step => {}
                    BladeSurface::Face(number) => {
                        let help = "give names of files, or take hub and blades from one STEP file";
                        self.fault(
                            key,
                            format!("{number} is a face, but the hub is no STEP file"),
                            help,
                        );
                    }
                }
            }
        }
        if machine.axes == Axes::ThreeAxis {
            let help = "give a machine with five axes, such as `machine.axes = \"xyzac\"`";
            self.fault("machine.axes", "between blades the tool axis has to turn", help);
        }
        if tool.kind() != ToolKind::Ball {
            let help = "give `kind = \"ball\"`, or another pattern";
            self.fault("tool.kind", "the pattern hub is planned for ball ends only", help);
        }
        if force.control != ForceControl::Off {
            let help = "give `control = \"off\"`";
            self.fault("force.control", "the pattern hub keeps no limit on the cut", help);
        }
        if let Stepover::Fixed(_) = cut.stepover {
            let help = "give `cut.scallop` instead";
            self.fault("cut.stepover", "the pattern hub spaces passes by the scallop height", help);
        }
        for (key, is_given) in [
            ("cut.lead", self.places.has("cut.lead")),
            ("cut.max_tilt", self.places.has("cut.max_tilt")),
            ("surface.steepest", surface.steepest.is_some()),
            ("stock", self.places.found("stock")),
            ("avoid", self.file.avoid.as_ref().is_some_and(|all| !all.is_empty())),
            ("surface.flip", self.places.has("surface.flip")),
            ("surface.select", self.places.has("surface.select")),
        ] {
            if is_given {
                let named = "says nothing about `path.pattern` = \"hub\"";
                self.fault(key, named, "leave it out");
            }
        }
    }
}
