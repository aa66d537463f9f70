//! From the complete job back to a job file with every key written out.

use super::avoid::Avoid;
use super::complete::Job;
use super::cut::{Cut, Stepover};
use super::file::{
    AnalyticTable, AvoidTable, ComponentKey, ComponentRule, CutTable, DistortionTable, FaceKey,
    FaceRule, FlattenTable, ForceTable, GcodeTable, HolderTable, HubTable, JobFile, MachineTable,
    MaterialTable, OutputTable, PathTable, PostKey, RegionsTable, RotaryLetter, RotaryTable,
    SelectTable, StockTable, SurfaceTable, TensorTable, TextureTable, ToolTable, TravelTable,
    TrochoidTable, Units, VERSION,
};
use super::force::{MinChip, MrrLimit};
use super::hub::HubOptions;
use super::output::{Post, PostSource};
use super::path::{Boundary, PathOptions, Start, StartKey};
use super::regions::{Division, RegionOptions};
use super::resolve::{is_step, uses};
use super::stock::StockShape;
use super::surface::{AnalyticOptions, Component, Faces, Selection, SurfaceOptions, SurfaceSource};
use super::texture::TextureOptions;
use super::units::{to_degrees, to_per_minute};
use crate::load::Material;
use crate::machine::{Arrangement, Axes, Chain, Machine, RotaryAxis, Setup};
use crate::tool::AssemblyPart;
use core::f64::consts::PI;
use serde::Serialize;

impl Job {
    /// The job as a job file, in mm, mm/min, degrees, with every default written out.
    ///
    /// Read again, it resolves to an equal job.
    pub fn to_toml(&self) -> String {
        text(&self.to_file())
    }

    /// The job as a job file, every key given.
    pub fn to_file(&self) -> JobFile {
        JobFile {
            version: Some(VERSION),
            name: Some(self.name.clone()),
            units: Some(Units::Mm),
            surface: self.surface_table(),
            flatten: FlattenTable { method: Some(self.flatten) },
            tool: self.tool_table(),
            cut: self.cut_table(),
            regions: regions_table(&self.regions),
            path: path_table(&self.path),
            stock: self.stock.as_ref().map(stock_table).unwrap_or_default(),
            avoid: (!self.avoid.is_empty()).then(|| self.avoid.iter().map(avoid_table).collect()),
            hub: self.hub.as_ref().map(hub_table).unwrap_or_default(),
            force: self.force_table(),
            material: self.force.material.map(material_table).unwrap_or_default(),
            trochoid: TrochoidTable {
                max_step: Some(self.trochoid.max_step),
                min_radius: Some(self.trochoid.min_radius),
                return_feed: Some(to_per_minute(self.trochoid.return_feed)),
            },
            machine: machine_table(&self.machine, &self.setup),
            texture: self.texture.as_ref().map(texture_table).unwrap_or_default(),
            operation: (),
            output: self.output_table(),
        }
    }

    /// Of a hub without what says nothing about it.
    fn surface_table(&self) -> SurfaceTable {
        let table = surface_table(&self.surface);
        match self.hub {
            Some(_) => SurfaceTable { flip: None, select: None, ..table },
            None => table,
        }
    }

    fn cut_table(&self) -> CutTable {
        let table = cut_table(&self.cut, &self.setup);
        let turns = self.machine.axes != Axes::ThreeAxis && self.hub.is_none();
        CutTable {
            lead: table.lead.filter(|_| self.hub.is_none()),
            max_tilt: table.max_tilt.filter(|_| turns),
            ..table
        }
    }

    fn tool_table(&self) -> ToolTable {
        ToolTable {
            kind: Some(self.tool.kind()),
            diameter: Some(2.0 * self.tool.radius()),
            corner_radius: Some(self.tool.corner_radius()),
            flutes: Some(self.flutes),
            helix: Some(to_degrees(self.helix)),
            number: Some(self.setup.tool_number),
            length_offset: Some(self.setup.length_offset),
            diameter_offset: Some(self.setup.diameter_offset),
            gauge_length: self.machine.axes.chain().map(Chain::gauge_length).filter(|g| *g > 0.0),
            ..self.shank_and_holder()
        }
    }

    /// What of the tool is above the cutter, where it is asked for.
    fn shank_and_holder(&self) -> ToolTable {
        if self.assembly.sections.is_empty() {
            return ToolTable::default();
        }
        let of_part = |part| self.assembly.sections.iter().filter(move |s| s.part == part);
        let holder = of_part(AssemblyPart::Holder).map(|s| HolderTable {
            diameter: Some(2.0 * s.radii[0]),
            upper_diameter: Some(2.0 * s.radii[1]),
            length: Some(s.heights[1] - s.heights[0]),
        });
        let holder: Vec<HolderTable> = holder.collect();
        ToolTable {
            length: Some(self.assembly.cutter_length),
            shank_diameter: of_part(AssemblyPart::Shank).next().map(|s| 2.0 * s.radii[0]),
            stickout: of_part(AssemblyPart::Shank).next().map(|s| s.heights[1]),
            holder: (!holder.is_empty()).then_some(holder),
            clearance: self.hub.is_none().then_some(self.clearance),
            ..ToolTable::default()
        }
    }

    fn force_table(&self) -> ForceTable {
        let force = &self.force;
        let (mrr_limit, relative) = match force.limit {
            Some(MrrLimit::Absolute(limit)) => (Some(to_per_minute(limit)), None),
            Some(MrrLimit::Relative(factor)) => (None, Some(factor)),
            None => (None, None),
        };
        let min_chip = match force.min_chip {
            MinChip::Limit(least) => Some(least),
            MinChip::Wish(_) => None,
        };
        ForceTable {
            mrr_limit,
            relative,
            power: force.power,
            cutting_force: force.cutting_force,
            min_chip,
            max_engagement: (force.max_engagement < PI).then(|| to_degrees(force.max_engagement)),
            control: Some(force.control),
            vfc: Some(force.vfc),
        }
    }

    fn output_table(&self) -> OutputTable {
        let (post, post_file) = match &self.output.gcode {
            Some(PostSource::File(file)) => (None, Some(file.clone())),
            Some(PostSource::Named(post)) => (Some(post_key(*post)), None),
            None => (Some(PostKey::None), None),
        };
        let Setup { program_number, arcs, .. } = self.setup;
        let (program_number, arcs) = (Some(program_number), Some(arcs));
        OutputTable {
            gcode: Some(GcodeTable { post, post_file, program_number, arcs }),
            svg: Some(self.output.pictures.clone()),
        }
    }
}

/// A complete job file as text.
pub(super) fn text(file: &JobFile) -> String {
    // The file holds strings, numbers and tables only, which TOML can all express.
    let body = toml_of(file).unwrap_or_default();
    format!("# The job as it was planned, with every default filled in.\n{body}")
}

/// A table as TOML text; keys without a value are left out.
///
/// It goes through one tree of values: code that writes every type as text made the page's module 35 kB larger.
///
/// # Errors
/// What TOML cannot express.
pub(super) fn toml_of(table: &impl Serialize) -> Result<String, toml::ser::Error> {
    toml::to_string(&toml::Table::try_from(table)?)
}

fn post_key(post: Post) -> PostKey {
    match post {
        Post::LinuxCnc => PostKey::LinuxCnc,
        Post::Fanuc => PostKey::Fanuc,
        Post::Haas => PostKey::Haas,
        Post::Siemens => PostKey::Siemens,
        Post::Heidenhain => PostKey::Heidenhain,
        Post::Grbl => PostKey::Grbl,
        Post::Cldata => PostKey::Cldata,
    }
}

fn regions_table(regions: &RegionOptions) -> RegionsTable {
    let method = Some(regions.method());
    // Of a single region there is nothing else to say.
    let mut table = RegionsTable {
        method,
        min_area: Some(regions.min_area),
        blend: Some(regions.blend),
        order: Some(regions.order),
        ..RegionsTable::default()
    };
    match regions.division {
        Division::Single => return RegionsTable { method, ..RegionsTable::default() },
        Division::Distortion(options) => {
            table.distortion = DistortionTable {
                measure: Some(options.measure),
                threshold: Some(options.threshold),
                uniformity: Some(options.uniformity),
                depth: Some(options.depth),
                compensation: Some(options.compensation),
            };
        }
        Division::Tensor(options) => {
            table.tensor =
                TensorTable { scale: options.scale, least_gain: Some(options.least_gain) };
        }
    }
    table
}

fn path_table(path: &PathOptions) -> PathTable {
    let (start, curve) = match &path.start {
        Start::Shortest => (Some(StartKey::Shortest), None),
        Start::Widest => (Some(StartKey::Widest), None),
        Start::Boundary => (Some(StartKey::Boundary), None),
        Start::Curve(points) => (None, Some(points.iter().map(|p| p.to_array()).collect())),
    };
    let uses = |key: &str| path.pattern.uses(key);
    PathTable {
        pattern: Some(path.pattern),
        start: start.filter(|_| uses("start")),
        curve,
        along: path.along,
        angle: path.angle.map(to_degrees),
        traverse: uses("traverse").then_some(path.traverse),
        first: uses("first").then_some(path.first),
        order: uses("order").then_some(path.order),
        links: uses("links").then_some(path.links),
        entry_radius: uses("entry_radius").then_some(path.entry_radius),
        boundary: uses("boundary").then_some(path.boundary),
        wall_height: (path.boundary == Boundary::Wall).then_some(path.wall_height),
    }
}

fn stock_table(stock: &StockShape) -> StockTable {
    match stock {
        StockShape::Box(corners) => {
            StockTable { corners: Some(corners.map(|c| c.to_array())), file: None }
        }
        StockShape::File(file) => StockTable { corners: None, file: Some(file.clone()) },
    }
}

fn avoid_table(avoid: &Avoid) -> AvoidTable {
    AvoidTable {
        file: Some(avoid.file.clone()),
        distance: Some(avoid.distance),
        name: Some(avoid.name.clone()),
    }
}

fn surface_table(surface: &SurfaceOptions) -> SurfaceTable {
    let (file, analytic) = match &surface.source {
        SurfaceSource::File(file) => (Some(file.clone()), None),
        SurfaceSource::Analytic(options) => (None, Some(analytic_table(options))),
    };
    SurfaceTable {
        units: file.as_deref().is_some_and(|f| !is_step(f)).then_some(Units::Mm),
        file,
        scale: Some(surface.scale),
        rotate: Some(surface.rotate.to_array().map(to_degrees)),
        translate: Some(surface.translate.to_array()),
        flip: Some(surface.flip),
        select: Some(select_table(&surface.select)),
        face: face_key(&surface.face),
        chord: surface.chord,
        curvature_radius: surface.curvature_radius,
        steepest: surface.steepest.map(to_degrees),
        analytic,
    }
}

fn face_key(faces: &Faces) -> Option<FaceKey> {
    match faces {
        Faces::Only => None,
        Faces::One(number) => Some(FaceKey::Number(*number)),
        Faces::Several(numbers) => Some(FaceKey::Numbers(numbers.clone())),
        Faces::All => Some(FaceKey::Rule(FaceRule::All)),
    }
}

fn analytic_table(options: &AnalyticOptions) -> AnalyticTable {
    let p = &options.parameters;
    let used = |name: &str, value: f64| uses(options.kind).contains(&name).then_some(value);
    AnalyticTable {
        kind: Some(options.kind),
        size: Some(p.size),
        radius: used("radius", p.radius),
        tube_radius: used("tube_radius", p.tube_radius),
        height: used("height", p.height),
        resolution: Some(p.resolution),
    }
}

fn select_table(select: &Selection) -> SelectTable {
    SelectTable {
        normal_within: select.normal_within.map(|(angle, _)| to_degrees(angle)),
        of: select.normal_within.map(|(_, direction)| direction.to_array()),
        within_box: select.within_box.map(|(a, b)| [a.to_array(), b.to_array()]),
        component: Some(match select.component {
            Component::Only => ComponentKey::Rule(ComponentRule::Only),
            Component::Largest => ComponentKey::Rule(ComponentRule::Largest),
            Component::Index(index) => ComponentKey::Index(index),
        }),
    }
}

fn material_table(material: Material) -> MaterialTable {
    MaterialTable { group: None, kc11: Some(material.kc11), mc: Some(material.mc) }
}

fn cut_table(cut: &Cut, setup: &Setup) -> CutTable {
    let (scallop, stepover) = match cut.stepover {
        Stepover::Scallop(h) => (Some(h), None),
        Stepover::Fixed(side_step) => (None, Some(side_step)),
    };
    CutTable {
        scallop,
        stepover,
        axial_depth: Some(cut.axial_depth),
        feed: Some(to_per_minute(cut.feed)),
        spindle: Some(to_per_minute(cut.spindle)),
        spindle_direction: Some(setup.spindle),
        coolant: Some(setup.coolant),
        lead: Some(to_degrees(cut.lead)),
        max_tilt: Some(to_degrees(cut.largest_tilt)),
        tolerance: Some(cut.tolerance),
        allowance: Some(cut.allowance),
        direction: Some(cut.direction),
        inaccessible: Some(cut.inaccessible),
    }
}

fn hub_table(hub: &HubOptions) -> HubTable {
    HubTable {
        blades: Some(hub.blades),
        blade: Some(hub.blade.clone()),
        splitter: (!hub.splitter.is_empty()).then(|| hub.splitter.clone()),
        axis: Some(hub.axis.to_array()),
        origin: Some(hub.origin.to_array()),
        clearance: Some(hub.clearance),
        extension: Some(hub.extension),
        passes: Some(hub.passes),
        channels: Some(hub.channels),
    }
}

fn machine_table(machine: &Machine, setup: &Setup) -> MachineTable {
    let travel = &machine.travel;
    let pair = |reach: Option<(f64, f64)>| reach.map(|(least, greatest)| [least, greatest]);
    let table = TravelTable { x: pair(travel.x), y: pair(travel.y), z: pair(travel.z) };
    MachineTable {
        file: None,
        axes: machine.axes.chain().is_none().then_some(Arrangement::ThreeAxis),
        rotary: machine.axes.chain().map(|chain| chain.axes().iter().map(rotary_table).collect()),
        pivot_length: None,
        max_feed: Some(to_per_minute(machine.max_feed)),
        max_acceleration: Some(machine.max_acceleration),
        max_rotary_speed: None,
        max_rotary_acceleration: None,
        clearance: Some(machine.clearance),
        work_offset: setup.work_offset,
        travel: (table != TravelTable::default()).then_some(table),
    }
}

fn rotary_table(axis: &RotaryAxis) -> RotaryTable {
    let (low, high) = axis.range;
    RotaryTable {
        letter: Some(match axis.letter {
            'A' => RotaryLetter::A,
            'B' => RotaryLetter::B,
            _ => RotaryLetter::C,
        }),
        carries: Some(axis.carries),
        direction: Some(axis.direction.to_array()),
        centre: Some(axis.centre.to_array()),
        range: low.is_finite().then_some([to_degrees(low), to_degrees(high)]),
        max_speed: Some(to_degrees(axis.max_speed)),
        max_acceleration: Some(axis.max_acceleration).filter(|a| a.is_finite()).map(to_degrees),
    }
}

fn texture_table(texture: &TextureOptions) -> TextureTable {
    TextureTable {
        at: Some(texture.at.to_array()),
        whole: Some(texture.whole),
        size: Some(texture.size.to_array()),
        spacing: Some(texture.spacing),
        runout: Some(texture.runout),
        runout_angle: Some(to_degrees(texture.runout_angle)),
        tooth_runout: Some(texture.tooth_runout.clone()),
        spindle_phase: Some(to_degrees(texture.spindle_phase)),
        discretisation: Some(texture.cells),
    }
}
