//! The complete job, and what follows from its numbers.

use super::avoid::Avoid;
use super::cut::{Cut, CutDirection, Stepover};
use super::fault::Faults;
use super::force::{Force, MinChip, MrrLimit, TrochoidOptions};
use super::hub::HubOptions;
use super::output::{OutputOptions, PostSource};
use super::path::PathOptions;
use super::regions::RegionOptions;
use super::stock::StockShape;
use super::surface::{FlattenMethod, SurfaceOptions};
use super::texture::TextureOptions;
use crate::footprint::Footprint;
use crate::load::{LoadLimits, Teeth};
use crate::machine::{Axes, Machine, Setup, SpindleDirection};
use crate::tool::{Assembly, Tool};

/// A complete job: every default filled in, every value checked.
#[derive(Clone, Debug, PartialEq)]
pub struct Job {
    /// The job's own name.
    pub name: String,
    /// Where the surface comes from and which part of it is meant.
    pub surface: SurfaceOptions,
    /// How it is laid flat.
    pub flatten: FlattenMethod,
    /// The cutter.
    pub tool: Tool,
    /// The cutter with shank and holder; without sections where nothing is known of them.
    pub assembly: Assembly,
    /// How far what is wider than the cutter stays clear, mm.
    pub clearance: f64,
    /// Number of flutes.
    pub flutes: u32,
    /// Helix angle of the flutes, rad.
    pub helix: f64,
    /// Whether only that is cut which earlier operations left.
    pub rest: bool,
    /// Cutting data.
    pub cut: Cut,
    /// Division of the surface.
    pub regions: RegionOptions,
    /// Passes and links.
    pub path: PathOptions,
    /// The material before the first operation, if it is known beside the surface.
    pub stock: Option<StockShape>,
    /// What the whole tool stays away from.
    pub avoid: Vec<Avoid>,
    /// The blades of a blisk, with the pattern `hub`.
    pub hub: Option<HubOptions>,
    /// Limits on the cut.
    pub force: Force,
    /// Trochoid options.
    pub trochoid: TrochoidOptions,
    /// The machine.
    pub machine: Machine,
    /// What the program sets up before the first move.
    pub setup: Setup,
    /// The window whose texture is simulated, if there is one.
    pub texture: Option<TextureOptions>,
    /// What to write.
    pub output: OutputOptions,
}

/// An operation of a job.
#[derive(Clone, Debug, PartialEq)]
pub struct Operation {
    /// Its name.
    pub name: String,
    /// The job as if it were this operation alone.
    pub job: Job,
}

/// A job as it was resolved, with what deserves a second look.
#[derive(Clone, Debug, PartialEq)]
pub struct Resolved {
    /// The job; of several operations the first.
    pub job: Job,
    /// Its operations in their order; empty where it is a single one.
    pub operations: Vec<Operation>,
    /// Warnings, in the order of the file.
    pub warnings: Faults,
    /// Names in the job, and contents, of the files that it was completed with.
    pub beside: Vec<(String, Vec<u8>)>,
}

impl Job {
    /// Side step `D` of a straight pass on a flat surface, mm.
    ///
    /// A fixed stepover is itself. For a scallop height `h`: the chord of the corner's circle,
    /// `2 sqrt(2 r_c h - h²)`, where the tool stands upright; the second-order strip width
    /// `sqrt(8 h / k_tool)` for a flat or bull end with a lead. Never above the diameter.
    pub fn nominal_side_step(&self) -> f64 {
        match self.cut.stepover {
            Stepover::Fixed(side_step) => side_step,
            Stepover::Scallop(h) => self.footprint().side_step(h).min(2.0 * self.tool.radius()),
        }
    }

    /// Whether the material lies on the right of the feed: climb milling with the spindle turning clockwise, or
    /// conventional milling with it turning the other way.
    pub fn keeps_material_on_right(&self) -> bool {
        let is_clockwise = self.setup.spindle == SpindleDirection::Clockwise;
        (self.cut.direction == CutDirection::Climb) == is_clockwise
    }

    /// The post-processor's file, if it names one.
    pub fn post_file(&self) -> Option<&str> {
        match &self.output.gcode {
            Some(PostSource::File(file)) => Some(file),
            _ => None,
        }
    }

    /// The files of meshes beside the surface: of those that it avoids, in the order of their tables, then of the stock.
    pub fn mesh_files(&self) -> impl Iterator<Item = &str> {
        let stock = match &self.stock {
            Some(StockShape::File(file)) => Some(file.as_str()),
            _ => None,
        };
        self.avoid.iter().map(|avoid| avoid.file.as_str()).chain(stock)
    }

    /// The files of blades that it names, each once.
    pub fn blade_files(&self) -> Vec<&str> {
        self.hub.as_ref().map(HubOptions::files).unwrap_or_default()
    }

    /// The cutter as it touches the surface.
    pub fn footprint(&self) -> Footprint {
        Footprint::new(self.tool, self.cut.lead)
    }

    /// Removal rate `D H V_f` of a straight pass at the nominal side step, mm³/s.
    pub fn nominal_mrr(&self) -> f64 {
        self.nominal_side_step() * self.cut.axial_depth * self.cut.feed
    }

    /// Length of the cutter that is checked for collisions, mm: without end along a fixed axis; where it
    /// leans that of the job, or twice its diameter, as the reach of a short end mill.
    pub fn cutter_length(&self) -> f64 {
        match self.machine.axes {
            Axes::ThreeAxis => f64::INFINITY,
            Axes::FiveAxis(_) if self.assembly.sections.is_empty() => 4.0 * self.tool.radius(),
            Axes::FiveAxis(_) => self.assembly.cutter_length,
        }
    }

    /// The limit on the material removal rate, mm³/s; where power or force are limited instead, the rate at which a
    /// straight pass at the full feed has that power.
    pub fn mrr_limit(&self) -> f64 {
        match (self.force.limit, self.load().power) {
            (Some(MrrLimit::Absolute(limit)), _) => limit,
            (Some(MrrLimit::Relative(factor)), _) => factor * self.nominal_mrr(),
            (None, Some((power, material))) => {
                let (section, feed) = (self.nominal_mrr() / self.cut.feed, self.cut.feed);
                power * section * feed / material.power(&self.teeth(), section, feed)
            }
            (None, None) => f64::INFINITY,
        }
    }

    /// The cutter as a disc with teeth.
    pub fn teeth(&self) -> Teeth {
        Teeth::of(&self.tool, self.cut.axial_depth, self.flutes, self.cut.spindle)
    }

    /// The limits on the cut that the job itself gives: a feed per tooth that is only preferred is none.
    pub fn bounds(&self) -> LoadLimits {
        let least_per_tooth = match self.force.min_chip {
            MinChip::Limit(least) => least,
            MinChip::Wish(_) => 0.0,
        };
        LoadLimits { least_per_tooth, ..self.load() }
    }

    /// The limits on the cut by which it is planned.
    pub fn load(&self) -> LoadLimits {
        let (teeth, force) = (self.teeth(), &self.force);
        let by_force = force.cutting_force.map(|newtons| newtons * teeth.speed);
        let by_power = force.power.map(|watts| 1e3 * watts);
        let power = by_force.into_iter().chain(by_power).reduce(f64::min);
        LoadLimits {
            teeth,
            rate: match force.limit {
                Some(MrrLimit::Absolute(limit)) => limit,
                Some(MrrLimit::Relative(factor)) => factor * self.nominal_mrr(),
                None => f64::INFINITY,
            },
            power: power.zip(force.material),
            least_per_tooth: force.min_chip.value(),
            most_engaged: force.max_engagement,
        }
    }
}
