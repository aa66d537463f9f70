//! What is written.

use super::resolver::Resolver;
use crate::job::file::{JobFile, PostKey};
use crate::job::output::{OutputOptions, Picture, Post, PostSource};
use crate::job::regions::RegionMethod;
use crate::machine::{Axes, Setup};

impl Resolver<'_> {
    pub(super) fn output(&mut self) -> OutputOptions {
        let table = &self.file.output;
        let division = match self.file.regions.method {
            None | Some(RegionMethod::Single) => None,
            Some(RegionMethod::Distortion) => Some(Picture::Regions),
            Some(RegionMethod::Tensor) => Some(Picture::Tensor),
        };
        let all = || {
            use Picture::{Channel, Clearance, Flat, Mrr, Removal, Scallop, Surface};
            let mut all = vec![Flat, Surface, Mrr, Scallop, Removal];
            if self.is_hub() {
                all.insert(2, Channel);
                all.push(Clearance);
            }
            division.into_iter().for_each(|picture| all.insert(2, picture));
            all
        };
        OutputOptions { pictures: table.svg.clone().unwrap_or_else(all), gcode: self.post() }
    }

    fn post(&mut self) -> Option<PostSource> {
        let table = self.file.output.gcode.as_ref();
        if let Some(file) = table.and_then(|gcode| gcode.post_file.clone()) {
            if table.is_some_and(|gcode| gcode.post.is_some()) {
                let message = format!("given beside {}", self.named("output.gcode.post"));
                self.fault("output.gcode.post_file", message, "keep one of the two");
            }
            self.check_file("output.gcode.post_file", &file, &["toml"]);
            return Some(PostSource::File(file));
        }
        let post = match table.and_then(|gcode| gcode.post) {
            Some(PostKey::None) => return None,
            Some(PostKey::LinuxCnc) | None => Post::LinuxCnc,
            Some(PostKey::Fanuc) => Post::Fanuc,
            Some(PostKey::Haas) => Post::Haas,
            Some(PostKey::Siemens) => Post::Siemens,
            Some(PostKey::Heidenhain) => Post::Heidenhain,
            Some(PostKey::Grbl) => Post::Grbl,
            Some(PostKey::Cldata) => Post::Cldata,
        };
        Some(PostSource::Named(post))
    }

    /// Arcs are of three axes.
    pub(super) fn check_arcs(&mut self, axes: &Axes) {
        let asked = self.file.output.gcode.as_ref().and_then(|gcode| gcode.arcs);
        if asked == Some(true) && *axes != Axes::ThreeAxis {
            let message = format!("says nothing about five axes ({})", self.named("machine.axes"));
            self.fault("output.gcode.arcs", message, "leave it out");
        }
    }

    /// What the program sets up before the first move.
    pub(super) fn setup(&self) -> Setup {
        let JobFile { tool, cut, machine, output, .. } = self.file;
        let gcode = output.gcode.as_ref();
        let tool_number = tool.number.unwrap_or(1);
        let length_offset = tool.length_offset.unwrap_or(tool_number);
        Setup {
            program_number: gcode.and_then(|gcode| gcode.program_number).unwrap_or(1),
            tool_number,
            length_offset,
            diameter_offset: tool.diameter_offset.unwrap_or(length_offset),
            work_offset: machine.work_offset,
            coolant: cut.coolant.unwrap_or_default(),
            spindle: cut.spindle_direction.unwrap_or_default(),
            arcs: gcode.and_then(|gcode| gcode.arcs).unwrap_or_default(),
        }
    }
}
