//! From the file as written to the complete job: defaults, units, combinations.
//!
//! Each table has one function. A value that another fault already concerns is replaced by its
//! default and raises no second fault; the job is given out only if there is none at all.

use super::document::{Document, Places};
use super::fault::{Fault, Faults};
use super::file::{
    AnalyticTable, ComponentKey, ComponentRule, JobFile, PostKey, SelectTable, Units,
};
use super::units::{INCH, per_second, radians, to_per_minute};
use super::{
    AnalyticKind, AnalyticOptions, AnalyticParameters, Boundary, Component, Cut, CutDirection,
    FeedComponent, FlattenMethod, Force, ForceControl, Job, Links, MrrLimit, OutputOptions,
    PathOptions, Picture, Post, Resolved, RingOrder, Selection, Stepover, SurfaceOptions,
    SurfaceSource, TooTight, TrochoidOptions,
};
use crate::geometry::DVec3;
use crate::machine::{Axes, Machine, Travel};
use crate::tool::{Tool, ToolKind};

/// Mesh formats by the ending of the file's name.
const MESH_FORMATS: [&str; 4] = ["stl", "obj", "ply", "off"];

/// Largest number of mesh edges along a surface given by a formula: four million vertices.
const LARGEST_GRID: f64 = 2000.0;

/// Cutting speed that the default spindle speed is made of, mm/min.
const CUTTING_SPEED: f64 = 150_000.0;

/// Relative difference below which a written corner radius is the cutter radius: inches and
/// thirds are rounded in files, and a ball of 6.35 mm has no flat of a nanometre.
const SAME_RADIUS: f64 = 1e-6;

/// Difference of a squared length from 1 that rounding explains; such directions are kept as they
/// are, so that a resolved job reads back to the same bits.
const UNIT_LENGTH: f64 = 1e-15;

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
        let job = Job {
            name,
            surface: surface?,
            flatten: file.flatten.method.unwrap_or(FlattenMethod::Bff),
            tool: tool?,
            flutes: file.tool.flutes.unwrap_or(4),
            helix: radians(file.tool.helix.unwrap_or(30.0)),
            cut: cut?,
            path: self.path(),
            force,
            trochoid: trochoid?,
            machine,
            output: self.output(),
        };
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

    fn surface(&mut self) -> Option<SurfaceOptions> {
        let table = &self.file.surface;
        let source = self.source();
        let is_file = matches!(source, Some(SurfaceSource::File(_)));
        let unit = match table.units {
            Some(Units::Inch) if is_file => INCH,
            None if is_file => self.unit,
            _ => 1.0,
        };
        let scale = table.scale.unwrap_or(1.0) * unit;
        if !(1e-6..=1e6).contains(&scale) {
            let message = format!("with the file's unit, lengths are multiplied with {scale}");
            self.fault("surface.scale", message, "the product may be from 1e-6 to 1e6");
        }
        Some(SurfaceOptions {
            source: source?,
            scale,
            rotate: DVec3::from(table.rotate.unwrap_or_default().map(radians)),
            translate: self.point(table.translate.unwrap_or_default()),
            select: self.selection(),
            curvature_radius: table.curvature_radius.map(|r| r * self.unit),
            flip: table.flip.unwrap_or(false),
        })
    }

    fn source(&mut self) -> Option<SurfaceSource> {
        let table = &self.file.surface;
        let has_file = self.places.has("surface.file");
        let has_formula = self.places.has("surface.analytic");
        if has_file && has_formula {
            let message = format!("a formula beside {}", self.named("surface.file"));
            self.fault("surface.analytic", message, "keep one of the two");
            return None;
        }
        if has_formula && self.places.has("surface.units") {
            let help = "a formula has the job's `units`";
            self.fault("surface.units", "is the unit of a mesh file, and there is none", help);
        }
        match (&table.file, &table.analytic) {
            (Some(file), _) => {
                self.check_file(file);
                Some(SurfaceSource::File(file.clone()))
            }
            (None, Some(analytic)) => self.analytic(analytic).map(SurfaceSource::Analytic),
            (None, None) => {
                if !has_file && !has_formula && self.places.found("surface") {
                    let help = "give `file = \"part.stl\"`, or a formula in [surface.analytic]";
                    self.fault("surface", "neither `file` nor `analytic` is given", help);
                }
                None
            }
        }
    }

    fn check_file(&mut self, file: &str) {
        let ending = file.rsplit_once('.').map(|(_, e)| e.to_ascii_lowercase());
        let known = ending.as_deref().is_some_and(|e| MESH_FORMATS.contains(&e));
        if file.chars().any(char::is_control) {
            self.fault("surface.file", "contains a control character", "give the file's name");
        } else if !known {
            let message = format!("{file:?} does not end in the name of a mesh format");
            let help = format!("available: {}", MESH_FORMATS.join(", "));
            self.fault("surface.file", message, help);
        }
    }

    fn analytic(&mut self, table: &AnalyticTable) -> Option<AnalyticOptions> {
        let kind = table.kind?;
        let default = AnalyticParameters::default();
        let written = [
            ("radius", table.radius),
            ("tube_radius", table.tube_radius),
            ("height", table.height),
        ];
        for (name, value) in written {
            if value.is_some() && !uses(kind).contains(&name) {
                let message = format!("a {} does not have this number", kind_name(kind));
                let help = format!("it has: size, resolution, {}", uses(kind).join(", "));
                let help = help.trim_end_matches(", ");
                self.fault(&format!("surface.analytic.{name}"), message, help);
            }
        }
        let parameters = AnalyticParameters {
            size: self.length(table.size, default.size),
            radius: self.length(table.radius, default.radius),
            tube_radius: self.length(table.tube_radius, default.tube_radius),
            height: self.length(table.height, default.height),
            resolution: self.length(table.resolution, default.resolution),
        };
        self.check_analytic(kind, &parameters);
        Some(AnalyticOptions { kind, parameters })
    }

    fn check_analytic(&mut self, kind: AnalyticKind, p: &AnalyticParameters) {
        if p.size / p.resolution > LARGEST_GRID {
            let message =
                format!("{} over a size of {}", self.show(p.resolution), self.show(p.size));
            let help = format!(
                "give at least size / {LARGEST_GRID}, {}",
                self.show(p.size / LARGEST_GRID)
            );
            self.fault("surface.analytic.resolution", message, help);
        }
        if p.resolution > 0.25 * p.size {
            let message =
                format!("{} over a size of {}", self.show(p.resolution), self.show(p.size));
            self.fault("surface.analytic.resolution", message, "give at most size / 4");
        }
        let round = matches!(kind, AnalyticKind::SphereCap | AnalyticKind::Cylinder);
        if round && p.size >= 2.0 * p.radius {
            let message =
                format!("{}, but the radius is {}", self.show(p.size), self.show(p.radius));
            self.fault("surface.analytic.size", message, "give less than twice the radius");
        }
        if kind == AnalyticKind::TorusPatch && p.tube_radius >= p.radius {
            let message =
                format!("{}, but the radius is {}", self.show(p.tube_radius), self.show(p.radius));
            self.fault("surface.analytic.tube_radius", message, "give less than the radius");
        }
    }

    fn selection(&mut self) -> Selection {
        let Some(table) = &self.file.surface.select else { return Selection::default() };
        Selection {
            normal_within: self.normal_cone(table),
            within_box: self.selection_box(table),
            component: match table.component {
                None | Some(ComponentKey::Rule(ComponentRule::Only)) => Component::Only,
                Some(ComponentKey::Rule(ComponentRule::Largest)) => Component::Largest,
                Some(ComponentKey::Index(index)) => Component::Index(index),
            },
        }
    }

    fn normal_cone(&mut self, table: &SelectTable) -> Option<(f64, DVec3)> {
        let direction = DVec3::from(table.of.unwrap_or([0.0, 0.0, 1.0]));
        let length = direction.length();
        if length < 1e-9 {
            let help = "give a direction such as [0, 0, 1]";
            self.fault("surface.select.of", format!("a vector of length {length}"), help);
        }
        if table.of.is_some() && !self.places.has("surface.select.normal_within") {
            let help = "give `normal_within = 75.0`, or remove `of`";
            self.fault("surface.select.of", "a direction without `normal_within`", help);
        }
        let is_unit = (direction.length_squared() - 1.0).abs() <= UNIT_LENGTH;
        let unit = if is_unit { direction } else { direction.normalize_or_zero() };
        table.normal_within.map(|angle| (radians(angle), unit))
    }

    fn selection_box(&mut self, table: &SelectTable) -> Option<(DVec3, DVec3)> {
        let [least, greatest] = table.within_box?;
        for (axis, name) in ["x", "y", "z"].iter().enumerate() {
            let (a, b) = (least[axis], greatest[axis]);
            if a >= b {
                let help = "the first corner is the least, the second the greatest";
                self.fault("surface.select.box", format!("empty along {name}: {a} to {b}"), help);
            }
        }
        Some((self.point(least), self.point(greatest)))
    }

    fn tool(&mut self) -> Option<Tool> {
        let table = &self.file.tool;
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
            ToolKind::Bull => {
                (corner > 0.0 && corner < radius, format!("between 0 and {}", self.show(radius)))
            }
        };
        if !agrees {
            let kind = named_kind(kind);
            let message =
                format!("{}; the corner radius of a {kind} end is {rule}", self.show(corner));
            let help = "correct it, or leave out `tool.kind`, which follows from it";
            self.fault("tool.corner_radius", message, help);
        }
    }

    fn machine(&mut self) -> Machine {
        let table = &self.file.machine;
        let travel = table.travel.clone().unwrap_or_default();
        Machine {
            axes: table.axes.unwrap_or(Axes::ThreeAxis),
            max_feed: self.feed(table.max_feed, 15_000.0),
            max_acceleration: self.length(table.max_acceleration, 2000.0),
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

    fn cut(&mut self, tool: Option<Tool>, machine: &Machine) -> Option<Cut> {
        let table = &self.file.cut;
        let diameter = tool.map_or(10.0, |t| 2.0 * t.radius());
        let lead = radians(table.lead.unwrap_or(match machine.axes {
            Axes::ThreeAxis => 0.0,
            Axes::Xyzac => 5.0,
        }));
        let stepover = self.stepover();
        if let (Some(tool), Some(stepover)) = (tool, stepover) {
            self.check_stepover(tool, stepover, lead);
        }
        self.check_lead(tool, machine.axes, lead);
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
            tolerance: self.length(table.tolerance, 0.005),
            stock: self.length(table.stock, 0.0),
            direction: table.direction.unwrap_or(CutDirection::Climb),
            too_tight: table.too_tight.unwrap_or(TooTight::Avoid),
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
        match axes {
            Axes::ThreeAxis if lead > 0.0 => {
                let message = format!(
                    "a tilted tool axis, but {} has three axes",
                    self.named("machine.axes")
                );
                let help = "give `lead = 0`, or `axes = \"xyzac\"` in [machine]";
                self.fault("cut.lead", message, help);
            }
            Axes::Xyzac if lead == 0.0 => {
                let Some(tool) = tool.filter(|t| t.kind() != ToolKind::Ball) else { return };
                let kind = named_kind(tool.kind());
                let message = format!("a {kind} end without lead cuts with its heel on five axes");
                self.fault("cut.lead", message, "give a lead above 0; 3 to 10 deg are usual");
            }
            _ => {}
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

    fn trochoid(&mut self, tool: Option<Tool>, machine: &Machine) -> Option<TrochoidOptions> {
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

    fn force(&mut self) -> Force {
        let table = &self.file.force;
        if self.places.has("force.mrr_limit") && self.places.has("force.relative") {
            let message = format!("given beside {}", self.named("force.mrr_limit"));
            self.fault("force.relative", message, "keep one of the two");
        }
        let cubic = self.unit * self.unit * self.unit;
        Force {
            limit: match table.mrr_limit {
                Some(limit) => MrrLimit::Absolute(per_second(limit * cubic)),
                None => MrrLimit::Relative(table.relative.unwrap_or(1.5)),
            },
            control: table.control.unwrap_or(ForceControl::Trochoid),
            vfc: table.vfc.unwrap_or(FeedComponent::Mean),
        }
    }

    fn path(&self) -> PathOptions {
        let table = &self.file.path;
        PathOptions {
            order: table.order.unwrap_or(RingOrder::OutsideIn),
            links: table.links.unwrap_or(Links::Surface),
            boundary: table.boundary.unwrap_or(Boundary::Open),
        }
    }

    fn output(&self) -> OutputOptions {
        let table = &self.file.output;
        let all = || vec![Picture::Flat, Picture::Surface, Picture::Mrr];
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
    }
}

fn fits_name(c: char) -> bool {
    !c.is_control() && !"();%".contains(c)
}

fn same_radius(a: f64, b: f64) -> bool {
    (a - b).abs() <= SAME_RADIUS * b
}

fn named_kind(kind: ToolKind) -> &'static str {
    match kind {
        ToolKind::Ball => "ball",
        ToolKind::Flat => "flat",
        ToolKind::Bull => "bull",
    }
}

fn kind_name(kind: AnalyticKind) -> String {
    let name = match kind {
        AnalyticKind::Plane => "plane",
        AnalyticKind::SphereCap => "sphere-cap",
        AnalyticKind::Cylinder => "cylinder",
        AnalyticKind::TorusPatch => "torus-patch",
        AnalyticKind::Saddle => "saddle",
        AnalyticKind::MonkeySaddle => "monkey-saddle",
        AnalyticKind::Bump => "bump",
    };
    name.to_owned()
}

/// The numbers of a formula besides `size` and `resolution`.
pub(super) fn uses(kind: AnalyticKind) -> &'static [&'static str] {
    match kind {
        AnalyticKind::Plane => &[],
        AnalyticKind::SphereCap | AnalyticKind::Cylinder => &["radius"],
        AnalyticKind::TorusPatch => &["radius", "tube_radius"],
        AnalyticKind::Saddle | AnalyticKind::MonkeySaddle => &["height"],
        AnalyticKind::Bump => &["radius", "height"],
    }
}
