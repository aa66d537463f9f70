//! From the file as written to the complete job: defaults, units, combinations.
//!
//! Each table has one function. A value that another fault already concerns is replaced by its
//! default and raises no second fault; the job is given out only if there is none at all.

mod cutting;
mod regions;
mod surface;
mod texture;

pub(super) use surface::{is_step, uses};

use surface::{MESH_FORMATS, kind_name};

use super::document::{Document, Places};
use super::fault::{Fault, Faults};
use super::file::{AnalyticTable, JobFile, PostKey, Units};
use super::units::{INCH, per_second, radians};
use super::{
    Boundary, FeedComponent, FirstPass, FlattenMethod, Force, ForceControl, Job, Links, MrrLimit,
    OutputOptions, PathOptions, Pattern, Picture, Post, RegionMethod, Resolved, RingOrder, Start,
    StartKey, Stepover, Traverse,
};
use crate::geometry::DVec3;
use crate::machine::{Axes, Machine, Travel};

/// Resolves a document.
///
/// # Errors
/// The faults of the document and all that are found here, in the order of the file.
pub(super) fn resolve(document: Document) -> Result<Resolved, Faults> {
    let Document { file, places, faults } = document;
    let unit = match file.units {
        Some(Units::Inch) => INCH,
        Some(Units::Mm) | None => 1.0,
    };
    let mut resolver = Resolver { file: &file, places, unit, faults: faults.0, warnings: vec![] };
    let job = resolver.job();
    let (mut faults, mut warnings) = (Faults(resolver.faults), Faults(resolver.warnings));
    match job {
        Some(job) if faults.is_empty() => {
            warnings.sort();
            Ok(Resolved { job, warnings })
        }
        _ => {
            faults.sort();
            Err(faults)
        }
    }
}

/// Overlap of the strips of neighbouring regions by default, nominal side steps. Smaller: the error of
/// the passes shows in the cusps along borders; larger: longer paths.
const BLEND: f64 = 0.1;

struct Resolver<'a> {
    file: &'a JobFile,
    places: Places,
    /// mm in the job's unit of length.
    unit: f64,
    faults: Vec<Fault>,
    warnings: Vec<Fault>,
}

impl Resolver<'_> {
    fn job(&mut self) -> Option<Job> {
        let surface = self.surface();
        let name = self.name();
        let tool = self.tool();
        let machine = self.machine();
        let cut = self.cut(tool, &machine);
        let trochoid = self.trochoid(tool, &machine);
        let force = self.force();
        let file = self.file;
        let mut job = Job {
            name,
            surface: surface?,
            flatten: file.flatten.method.unwrap_or(FlattenMethod::Bff),
            tool: tool?,
            flutes: file.tool.flutes.unwrap_or(4),
            helix: radians(file.tool.helix.unwrap_or(30.0)),
            regions: self.regions(tool?),
            cut: cut?,
            path: self.path(),
            force,
            trochoid: trochoid?,
            machine,
            texture: None,
            output: self.output(),
        };
        if file.regions.blend.is_none() {
            job.regions.blend = BLEND * job.nominal_side_step();
        }
        if file.path.wall_height.is_none() {
            let stock = job.cut.stock + job.cut.axial_depth;
            job.path.wall_height = stock.max(2.0 * job.tool.radius());
        }
        job.texture = self.texture(&job);
        self.check_blend(&job);
        self.second_looks(&job);
        Some(job)
    }

    /// Notes a fault of `key` at its place.
    fn fault(&mut self, key: &str, message: impl Into<String>, help: impl Into<String>) {
        let place = self.places.of(key);
        self.faults.push(Fault::new(key, message).help(help).at(place));
    }

    fn warn(&mut self, key: &str, message: impl Into<String>, help: impl Into<String>) {
        let place = self.places.of(key);
        self.warnings.push(Fault::new(key, message).help(help).at(place));
    }

    /// `key` and the line it stands on, for messages that concern two keys.
    fn named(&self, key: &str) -> String {
        match self.places.line(key) {
            Some(line) => format!("`{key}` (line {line})"),
            None => format!("`{key}` (default)"),
        }
    }

    /// A length of so many mm in the unit of the job, to six decimals.
    fn show(&self, length: f64) -> String {
        let name = if self.unit == 1.0 { "mm" } else { "inch" };
        let rounded = (length / self.unit * 1e6).round() / 1e6;
        format!("{rounded} {name}")
    }

    fn length(&self, value: Option<f64>, default: f64) -> f64 {
        value.map_or(default, |v| v * self.unit)
    }

    fn feed(&self, value: Option<f64>, default: f64) -> f64 {
        per_second(value.map_or(default, |v| v * self.unit))
    }

    fn point(&self, p: [f64; 3]) -> DVec3 {
        DVec3::from(p) * self.unit
    }

    fn name(&mut self) -> String {
        let Some(name) = &self.file.name else { return self.default_name() };
        if let Some(bad) = name.chars().find(|c| !fits_name(*c)) {
            let help = "any characters but control characters and ( ) ; %";
            self.fault(
                "name",
                format!("contains {bad:?}, which ends a comment in a program"),
                help,
            );
        } else if name.trim() != name {
            self.fault("name", "begins or ends with a space", "remove it");
        }
        name.clone()
    }

    fn default_name(&self) -> String {
        let surface = &self.file.surface;
        let stem = match (&surface.file, &surface.analytic) {
            (Some(file), _) => {
                let last = file.rsplit(['/', '\\']).next().unwrap_or_default();
                last.rsplit_once('.').map_or(last, |(stem, _)| stem).to_owned()
            }
            (None, Some(AnalyticTable { kind: Some(kind), .. })) => kind_name(*kind),
            _ => String::new(),
        };
        let stem: String = stem.chars().filter(|c| fits_name(*c)).take(100).collect();
        let stem = stem.trim();
        if stem.is_empty() { "job".to_owned() } else { stem.to_owned() }
    }

    fn machine(&mut self) -> Machine {
        let table = &self.file.machine;
        let travel = table.travel.clone().unwrap_or_default();
        Machine {
            axes: table.axes.unwrap_or(Axes::ThreeAxis),
            max_feed: self.feed(table.max_feed, 15_000.0),
            max_acceleration: self.length(table.max_acceleration, 2000.0),
            max_rotary_speed: radians(table.max_rotary_speed.unwrap_or(90.0)),
            clearance: self.length(table.clearance, 10.0),
            travel: Travel {
                x: self.reach("x", travel.x),
                y: self.reach("y", travel.y),
                z: self.reach("z", travel.z),
            },
        }
    }

    fn reach(&mut self, axis: &str, reach: Option<[f64; 2]>) -> Option<(f64, f64)> {
        let [least, greatest] = reach?;
        if least >= greatest {
            let key = format!("machine.travel.{axis}");
            let message = format!("from {least} to {greatest} there is no way to go");
            self.fault(&key, message, "give the least position first, then the greatest");
        }
        Some((least * self.unit, greatest * self.unit))
    }

    fn force(&mut self) -> Force {
        let table = &self.file.force;
        if self.places.has("force.mrr_limit") && self.places.has("force.relative") {
            let message = format!("given beside {}", self.named("force.mrr_limit"));
            self.fault("force.relative", message, "keep one of the two");
        }
        let pattern = self.file.path.pattern.unwrap_or(Pattern::Contour);
        let default = match pattern {
            Pattern::Contour => ForceControl::Trochoid,
            _ => ForceControl::Off,
        };
        let control = table.control.unwrap_or(default);
        if control == ForceControl::Trochoid && pattern != Pattern::Contour {
            let message =
                format!("trochoids are put into contour passes only, not {:?}", pattern.name());
            let help = "give `control = \"feed\"` or `\"off\"`, or `pattern = \"contour\"`";
            self.fault("force.control", message, help);
        }
        let cubic = self.unit * self.unit * self.unit;
        Force {
            limit: match table.mrr_limit {
                Some(limit) => MrrLimit::Absolute(per_second(limit * cubic)),
                None => MrrLimit::Relative(table.relative.unwrap_or(1.5)),
            },
            control,
            vfc: table.vfc.unwrap_or(FeedComponent::Mean),
        }
    }

    fn path(&mut self) -> PathOptions {
        let table = &self.file.path;
        let pattern = table.pattern.unwrap_or(Pattern::Contour);
        let boundary = table.boundary.unwrap_or(Boundary::Open);
        let first = match pattern.has_rings() {
            true => FirstPass::Edge,
            false => FirstPass::HalfStrip,
        };
        let start = match (&table.curve, table.start) {
            (Some(points), _) => Start::Curve(points.iter().map(|&p| self.point(p)).collect()),
            (None, Some(StartKey::Boundary)) => Start::Boundary,
            (None, Some(StartKey::Widest)) => Start::Widest,
            (None, Some(StartKey::Shortest) | None) => Start::Shortest,
        };
        let path = PathOptions {
            pattern,
            start,
            along: table.along,
            angle: table.angle.map(radians),
            traverse: table.traverse.unwrap_or(Traverse::Zigzag),
            first: table.first.unwrap_or(first),
            order: table.order.unwrap_or(RingOrder::OutsideIn),
            links: table.links.unwrap_or(Links::Surface),
            boundary,
            wall_height: self.length(table.wall_height, 0.0),
            wall_file: table.wall_file.clone(),
        };
        if let Some(file) = &path.wall_file {
            self.check_file("path.wall_file", file, &MESH_FORMATS);
        }
        self.check_path(&path);
        path
    }

    /// Keys of [path] that say nothing about the pattern chosen are refused.
    fn check_path(&mut self, path: &PathOptions) {
        if self.places.has("path.curve") && self.places.has("path.start") {
            let message = format!("given beside {}", self.named("path.start"));
            self.fault("path.curve", message, "keep one of the two");
        }
        if let Start::Curve(points) = &path.start
            && points.windows(2).all(|pair| pair[0] == pair[1])
        {
            self.fault("path.curve", "all its points are the same", "give two places at least");
        }
        let pattern = self.named("path.pattern");
        for key in Pattern::KEYS {
            let owners = Pattern::ALL.into_iter().filter(|p| p.uses(key));
            let path_key = format!("path.{key}");
            if self.places.has(&path_key) && !path.pattern.uses(key) {
                let names: Vec<_> = owners.map(|p| format!("{:?}", p.name())).collect();
                let message = format!("says nothing about {pattern} = {:?}", path.pattern.name());
                let help = format!("leave it out; it belongs to {}", names.join(", "));
                self.fault(&path_key, message, help);
            }
        }
        let is_wall = path.boundary == Boundary::Wall;
        if !is_wall && self.places.has("path.wall_height") {
            let help = "leave it out, or give `boundary = \"wall\"`";
            self.fault("path.wall_height", "there is no wall", help);
        }
        if is_wall && path.pattern != Pattern::Contour {
            let message = format!("only contour passes keep off walls, not {pattern}");
            self.fault("path.boundary", message, "give `boundary = \"open\"` or contour");
        }
        if is_wall && self.file.path.first == Some(FirstPass::HalfStrip) {
            let message = "between walls the first pass runs along the wall";
            self.fault("path.first", message, "leave it out, or give `boundary = \"open\"`");
        }
    }

    fn output(&self) -> OutputOptions {
        let table = &self.file.output;
        let division = match self.file.regions.method {
            None | Some(RegionMethod::Single) => None,
            Some(RegionMethod::Distortion) => Some(Picture::Regions),
            Some(RegionMethod::Tensor) => Some(Picture::Tensor),
        };
        let all = || {
            use Picture::{Flat, Mrr, Removal, Scallop, Surface};
            let mut all = vec![Flat, Surface, Mrr, Scallop, Removal];
            division.into_iter().for_each(|picture| all.insert(2, picture));
            all
        };
        OutputOptions {
            gcode: match table.gcode.as_ref().and_then(|g| g.post) {
                Some(PostKey::None) => None,
                Some(PostKey::LinuxCnc) | None => Some(Post::LinuxCnc),
            },
            pictures: table.svg.clone().unwrap_or_else(all),
        }
    }

    /// Warnings about a complete job.
    fn second_looks(&mut self, job: &Job) {
        if let Stepover::Scallop(h) = job.cut.stepover
            && job.cut.tolerance >= h
        {
            let message = format!(
                "{} is not below the scallop {}",
                self.show(job.cut.tolerance),
                self.show(h)
            );
            let help = "a chord tolerance of half the scallop or less shows in the cusps";
            self.warn("cut.tolerance", message, help);
        }
        if let Some(chord) = job.surface.chord
            && chord > job.cut.tolerance
        {
            let message = format!(
                "triangles up to {} off the surface, above the tolerance {}",
                self.show(chord),
                self.show(job.cut.tolerance)
            );
            let help = "the cusps stand on the triangles: give half the tolerance or less";
            self.warn("surface.chord", message, help);
        }
        let (limit, straight) = (60.0 * job.mrr_limit(), 60.0 * job.nominal_mrr());
        if limit < straight && job.force.control != ForceControl::Off {
            let key = match job.force.limit {
                MrrLimit::Absolute(_) => "force.mrr_limit",
                MrrLimit::Relative(_) => "force.relative",
            };
            let message = format!(
                "a straight pass removes {straight:.1} mm³/min, above the limit of {limit:.1} mm³/min"
            );
            self.warn(
                key,
                message,
                "every pass will need the cure; lower feed, depth or side step",
            );
        }
        let per_tooth = job.cut.feed / (job.cut.spindle * f64::from(job.flutes));
        if per_tooth > 0.1 * job.tool.radius() {
            let message =
                format!("{} per tooth is more than 5 % of the diameter", self.show(per_tooth));
            self.warn("cut.feed", message, "check `cut.feed`, `cut.spindle` and `tool.flutes`");
        }
        if job.cut.axial_depth > 2.0 * job.tool.radius() {
            let message =
                format!("{} is deeper than the tool is wide", self.show(job.cut.axial_depth));
            self.warn("cut.axial_depth", message, "check it against the length of the flutes");
        }
        if let Stepover::Scallop(h) = job.cut.stepover
            && h >= job.cut.axial_depth
        {
            let depth = self.show(job.cut.axial_depth);
            let message = format!("cusps of {} stand as high as the stock, {depth}", self.show(h));
            self.warn(
                "cut.scallop",
                message,
                "lower it, or give `cut.axial_depth` what is to be cut",
            );
        }
    }
}

fn fits_name(c: char) -> bool {
    !c.is_control() && !"();%".contains(c)
}
