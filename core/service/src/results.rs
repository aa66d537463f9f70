//! A plan → the files of its results, byte for byte the same on every machine.

mod division;
mod error;
mod files;
pub(crate) mod hub;
mod operations;
mod program;
mod setup;
pub mod texture;
mod topology;

pub use error::ResultsError;
pub use files::{Input, OutputFile};
pub use operations::{OperationError, OperationsResults, operations_results};

use core::f64::consts::PI;
use evencut_core::geometry::{DVec3, OrderBy};
use evencut_core::job::{
    Boundary, FlattenMethod, ForceControl, Job, MinChip, Picture, PostSource, SurfaceSource,
};
use evencut_core::load::LoadLimits;
use evencut_core::machine::{Axes, Machine};
use evencut_core::machine_time::machine_time;
use evencut_core::plan::{
    self, Files, Laid, MapKind, Planned, Prepared, Stage, Stock, SurfaceKeys, plan, plan_on,
    stock_of,
};
use evencut_core::reach::Aside;
use evencut_core::surface;
use evencut_core::toolpath::{MoveKind, PathPoint, Toolpath};
use evencut_core::units::per_minute;
use evencut_core::verify::{
    AboveCutter, Avoided, Earlier, EarlierCut, Facets, LoadOptions, Rise, Solid, Sphere,
    Verification, VerifyError, VerifyOptions, Walls, verify,
};
use evencut_output::post::{self, Dialect, DialectError, PostError};
use evencut_output::preview::{
    Clearances, Drawn, FlatLines, Linked, channel_view, clearance_chart, flat_map, mrr_chart,
    rate_map, regions_map, residual_map, surface_view, tensor_map, tool_drawing,
};
use evencut_output::report::{
    AsideFigures, ByKind, CoverageFigures, DivisionFigures, FORMAT, FileRecord, FlattenFigures,
    ForceFigures, GougeFigures, LiftedSpan, Lines, PassFigures, PathFigures, PlaneFigures, Profile,
    RateFigures, Report, StepoverFigures, SurfaceFigures, TiltFigures, VerificationFigures,
    Versions, Warning,
};
use program::WrittenProgram;
use texture::{TextureResults, texture_on};

/// Smaller areas that are not machined are not mentioned, mm².
const NOTEWORTHY: f64 = 0.005;
/// A flat map whose scale varies by more than this factor gets a warning.
const WIDEST_SCALE: f64 = 30.0;
/// Stock higher than this fraction of the smallest concave radius stands over what is cut on the other side of the hollow:
/// up to 0.62 predicted and simulated rates agreed on a hollow of 8 mm, at 0.75 they differed by a tenth of the limit.
const DEEP: f64 = 0.6;
/// Tables that make the path slower by more than this factor get a warning.
const SLOW_TABLES: f64 = 1.25;
/// Verification samples per side step.
const SAMPLES_PER_STEP: f64 = 10.0;
/// Verification samples per cutter radius, at least: a window of travel, a fifth of the radius, has to contain
/// several.
const SAMPLES_PER_RADIUS: f64 = 20.0;

/// The results of a job.
#[derive(Clone, Debug)]
pub struct Results {
    /// All files, the report last.
    pub files: Vec<OutputFile>,
    /// The report.
    pub report: Report,
    /// What is wrong with the program, in words; part of the verification, if there is one.
    pub program: Vec<String>,
}

/// How results are made.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub struct ResultsOptions {
    /// Number of threads; the results do not depend on it.
    pub threads: usize,
    /// Whether the path is verified by a simulation.
    pub verify: bool,
}

/// Intermediate results that can be shown early.
#[derive(Clone, Debug)]
pub struct Early {
    /// Files as the results will contain them; before the path is delivered, pictures of it instead.
    pub files: Vec<OutputFile>,
    /// The numbers behind the pictures.
    pub linked: Linked,
    /// Report of the planned path without its verification; `None` before the path is delivered.
    pub report: Option<Report>,
}

/// Callbacks during the making of results.
pub struct Watch<'a> {
    /// Called with the stage and the fraction of it that is done.
    pub progress: &'a mut dyn FnMut(Stage, f64),
    /// Called when the path is laid out, and when it is planned but not yet verified.
    pub show: &'a mut dyn FnMut(Early),
}

/// Plans a job, writes all files it requests, and returns the numbers behind their pictures.
///
/// Arguments and files as for [`results()`]; `watch` receives what can be shown before the end.
///
/// # Errors
/// [`ResultsError`]; no partial results are returned.
pub fn linked_results(
    job: &Job,
    job_file: Input,
    files: Files,
    options: ResultsOptions,
    watch: Watch,
) -> Result<(Results, Linked), ResultsError> {
    let Watch { progress, show } = watch;
    let inputs = Inputs::new(job, job_file, files)?;
    let prepared = Prepared::new(SurfaceKeys::of(job), files, options.threads, progress)?;
    let planned = match job.hub {
        // There is no flat path to show.
        Some(_) => plan_on(&prepared, job, &stock_of(job), options.threads, progress)?,
        None => {
            let laid = Laid::new(&prepared, job, &stock_of(job), options.threads, progress)?;
            show(before_delivery(job, &prepared, &laid));
            laid.planned(progress)?
        }
    };
    let written = Written::of(&inputs, &planned)?;
    let files = written.in_order(job, Vec::new()).cloned().collect();
    let linked = written.linked(job, &planned, None);
    show(Early { files, linked, report: Some(written.report.clone()) });
    let judged = inputs.judge(&planned, &stock_of(job), options, progress)?;
    let linked = written.linked(job, &planned, judged.as_ref());
    Ok((written.finish(&inputs, &planned, judged.as_ref(), options.threads, progress), linked))
}

/// Plans a job and writes all files it requests.
///
/// `job_file`: the job as read; `files`: the contents of the files it names. A path that breaks a limit is a result
/// as well: the report's `verification` says so.
///
/// # Errors
/// [`ResultsError`]; no partial results are returned.
pub fn results(
    job: &Job,
    job_file: Input,
    files: Files,
    options: ResultsOptions,
    progress: &mut dyn FnMut(Stage, f64),
) -> Result<Results, ResultsError> {
    let inputs = Inputs::new(job, job_file, files)?;
    let planned = plan(job, files, options.threads, progress)?;
    let written = Written::of(&inputs, &planned)?;
    let judged = inputs.judge(&planned, &stock_of(job), options, progress)?;
    Ok(written.finish(&inputs, &planned, judged.as_ref(), options.threads, progress))
}

/// The files that a job names, under the names that it gives them, as far as they are available.
pub fn named_files<'a>(job: &'a Job, files: Files<'a>) -> Vec<Input<'a>> {
    let surface = match &job.surface.source {
        SurfaceSource::File(name) => Some(name.as_str()),
        SurfaceSource::Analytic(_) => None,
    };
    let named = [(surface, files.surface), (job.post_file(), files.post)];
    let input = |(name, bytes): (Option<&'a str>, Option<&'a [u8]>)| {
        Some(Input { name: name?, bytes: bytes? })
    };
    let held = |files: &'a [(String, Vec<u8>)], name: &'a str| {
        let (_, bytes) = files.iter().find(|(held, _)| held == name)?;
        Some(Input { name, bytes })
    };
    let meshes = job.mesh_files().filter_map(|name| held(files.meshes, name));
    let blades = job.blade_files().into_iter().filter_map(|name| held(files.blades, name));
    let beside = files.beside.iter().map(|(name, bytes)| Input { name, bytes });
    named.into_iter().filter_map(input).chain(meshes).chain(blades).chain(beside).collect()
}

/// The post-processor of a job, and whether it can write the job's program; `file`: the content of its file.
///
/// # Errors
/// [`PostError`] if it cannot be read, or has no programs for the job's axes, coolant or work offset.
pub fn dialect(job: &Job, file: Option<&[u8]>) -> Result<Option<Dialect>, PostError> {
    let dialect = match &job.output.gcode {
        None => return Ok(None),
        Some(PostSource::Named(post)) => Dialect::of(*post)?,
        Some(PostSource::File(name)) => {
            let bytes = file.ok_or_else(|| DialectError::NoFile(name.clone()))?;
            Dialect::read(bytes)?
        }
    };
    post::check(&dialect, &job.machine.axes, &job.setup)?;
    Ok(Some(dialect))
}

/// The data from which results are made.
struct Inputs<'a> {
    job: &'a Job,
    job_file: Input<'a>,
    files: Files<'a>,
    /// The post-processor, if a program is wanted.
    dialect: Option<Dialect>,
    /// Which operation of a job of several it is.
    part: Option<Part>,
}

/// An operation of a job of several.
#[derive(Copy, Clone)]
struct Part {
    number: usize,
    /// Whether its program is a file of its own.
    has_own_program: bool,
}

type Judged = (Verification, VerifyOptions);

impl<'a> Inputs<'a> {
    /// # Errors
    /// [`ResultsError::Post`] before the work if no program can be written after it.
    fn new(job: &'a Job, job_file: Input<'a>, files: Files<'a>) -> Result<Self, ResultsError> {
        let dialect = dialect(job, files.post)?;
        hub::refuse_unnamed(job, files)?;
        Ok(Self { job, job_file, files, dialect, part: None })
    }

    /// The name of a file of its results.
    fn named(&self, name: &str) -> String {
        self.part.map_or_else(|| name.to_owned(), |part| format!("{}-{name}", part.number))
    }

    fn judge(
        &self,
        planned: &Planned,
        stock: &Stock,
        options: ResultsOptions,
        progress: &mut dyn FnMut(Stage, f64),
    ) -> Result<Option<Judged>, VerifyError> {
        let progress = &mut |part| progress(Stage::Verify, part);
        let judge = || judge(self.job, planned, stock, options.threads, progress);
        options.verify.then(judge).transpose()
    }

    /// The texture of the job's window, if it has one. If it cannot be simulated, the plan is still made, with a
    /// warning.
    fn texture(
        &self,
        planned: &Planned,
        threads: usize,
        progress: &mut dyn FnMut(Stage, f64),
        warnings: &mut Vec<Warning>,
    ) -> Option<TextureResults> {
        let options = self.job.texture.as_ref()?;
        let on = (&*planned.prepared, &planned.toolpath);
        let progress = &mut |part| progress(Stage::Texture, part);
        match texture_on(self.job, options, on, threads, progress) {
            Ok(texture) => Some(texture),
            Err(error) => {
                let message = without_stage(&error.to_string());
                warnings.push(warning("texture", message, "correct the [texture] table"));
                None
            }
        }
    }

    fn records(&self) -> Vec<FileRecord> {
        let named = named_files(self.job, self.files);
        let all = core::iter::once(self.job_file).chain(named);
        all.map(|f| FileRecord::of(f.name, f.bytes)).collect()
    }
}

/// What is written of a plan, whether or not it passes verification.
struct Written {
    /// The place on the surface of every point of the path.
    contacts: Vec<Option<DVec3>>,
    /// Resolved job, table, and program with the findings of its check.
    files: Vec<OutputFile>,
    findings: Vec<String>,
    pictures: Vec<Drawing>,
    /// Without verification and outputs.
    report: Report,
}

/// A picture that was drawn.
struct Drawing {
    picture: Picture,
    heading: &'static str,
    file: OutputFile,
}

impl Written {
    fn of(inputs: &Inputs, planned: &Planned) -> Result<Self, ResultsError> {
        let job = inputs.job;
        let mut files = Vec::new();
        if inputs.part.is_none() {
            let bytes = job.to_toml().into_bytes();
            files.push(OutputFile { name: "job.resolved.toml".into(), bytes });
        }
        files.push(OutputFile {
            name: inputs.named("toolpath.csv"),
            bytes: planned.toolpath.to_csv(&planned.planar).into_bytes(),
        });
        let dialect = inputs.dialect.as_ref();
        let mut program =
            dialect.map(|dialect| WrittenProgram::of(job, planned, dialect)).transpose()?;
        let has_own_program = inputs.part.is_none_or(|part| part.has_own_program);
        if let Some(program) = program.as_mut().filter(|_| has_own_program) {
            program.rename(inputs.named(&program.file.name));
        }
        let setup = {
            let is_first = inputs.part.is_none_or(|part| part.number == 1);
            setup::figures(job, planned, program.as_ref(), is_first)
        };
        let (mut findings, mut unread) = (Vec::new(), None);
        if let Some(program) = program {
            files.extend(has_own_program.then_some(program.file));
            (findings, unread) = (program.findings, program.unread);
        }
        let contacts = contacts(&planned.prepared, &planned.toolpath);
        let mut report = report_on(job, planned, inputs.records(), &contacts);
        report.setup = Some(setup);
        report.warnings.extend(unread.map(|error| {
            let message = format!("it is written, but not checked: {error}");
            warning("program", message, "check it on the machine's control or by its simulation")
        }));
        let mut pictures = pictures(job, planned, &contacts, report.regions.as_ref());
        pictures.iter_mut().for_each(|d| d.file.name = inputs.named(&d.file.name));
        Ok(Self { contacts, files, findings, pictures, report })
    }

    /// The files, and pictures in the order in which the job lists them; `measured`: further pictures.
    fn in_order<'a>(
        &'a self,
        job: &'a Job,
        measured: Vec<&'a Drawing>,
    ) -> impl Iterator<Item = &'a OutputFile> {
        let drawings = self.drawings(job, measured);
        self.files.iter().chain(drawings.into_iter().map(|d| &d.file))
    }

    fn drawings<'a>(&'a self, job: &Job, measured: Vec<&'a Drawing>) -> Vec<&'a Drawing> {
        let mut all: Vec<&Drawing> = self.pictures.iter().chain(measured).collect();
        all.order_by_key(|d| job.output.pictures.iter().position(|p| *p == d.picture));
        all
    }

    fn linked(&self, job: &Job, planned: &Planned, judged: Option<&Judged>) -> Linked {
        let path = hub::simulated(planned);
        let surface = &planned.prepared.surface;
        let (positions, faces) = surface.triangles();
        Linked::of(&Drawn {
            surface,
            chart: &planned.prepared.chart,
            lines: &hub::lines(&planned.prepared),
            channel: hub::scene(&planned.prepared, Facets { positions, faces: &faces }),
            path: &path,
            contacts: &self.contacts[..path.points.len()],
            plain: planned.plain.as_ref().map(|plain| &plain.at_full_feed),
            rest: rest(planned),
            verification: judged.map(|(verification, _)| verification),
            limit: rate_limit(job),
            scallop: planned.cusps.limit,
            tolerance: job.cut.tolerance,
        })
    }

    /// The results, the report last.
    fn finish(
        self,
        inputs: &Inputs,
        planned: &Planned,
        judged: Option<&Judged>,
        threads: usize,
        progress: &mut dyn FnMut(Stage, f64),
    ) -> Results {
        progress(Stage::Write, 0.0);
        let clear = judged.and_then(|_| hub::measured(inputs.job, planned, threads)).unzip();
        let mut measured = judged.map_or_else(Vec::new, |judged| {
            measured(inputs.job, planned, judged, clear.1.as_ref())
        });
        measured.iter_mut().for_each(|d| d.file.name = inputs.named(&d.file.name));
        let mut report = self.report.clone();
        let mut findings = self.findings.clone();
        if let (Some(hub), Some(_)) = (&mut report.hub, judged) {
            hub.measured = clear.0;
            findings.extend(hub.broken());
        }
        report.verification = judged.map(|(verification, options)| {
            let findings = findings.clone();
            VerificationFigures::of(verification, options, Lines::Table, findings)
        });
        let mut files: Vec<OutputFile> =
            self.in_order(inputs.job, measured.iter().collect()).cloned().collect();
        let texture = inputs.texture(planned, threads, progress, &mut report.warnings);
        let from = files.len();
        if let Some(TextureResults { files: more, figures }) = texture {
            files.extend(more);
            report.texture = Some(figures);
        }
        report.outputs = files.iter().map(|f| FileRecord::of(&f.name, &f.bytes)).collect();
        let shown = self.drawings(inputs.job, measured.iter().collect());
        let tool = tool_drawing(&inputs.job.assembly);
        let mut shown: Vec<(&str, &str)> = core::iter::once(("Tool", &tool[..]))
            .chain(shown.iter().map(|d| (d.heading, d.text())))
            .collect();
        let texture = files[from..].iter().find(|file| file.name == texture::PICTURE);
        shown.extend(texture.map(|file| ("Texture that the teeth leave", text(file))));
        let page = report.to_html(&shown);
        let bytes = page.into_bytes();
        files.push(OutputFile { name: inputs.named("report.html"), bytes });
        let bytes = report.to_json().into_bytes();
        files.push(OutputFile { name: inputs.named("report.json"), bytes });
        progress(Stage::Write, 1.0);
        Results { files, report, program: self.findings.clone() }
    }
}

impl Drawing {
    fn new(picture: Picture, name: &str, heading: &'static str, svg: String) -> Self {
        Self { picture, heading, file: OutputFile { name: name.into(), bytes: svg.into_bytes() } }
    }

    fn text(&self) -> &str {
        text(&self.file)
    }
}

/// A picture's text.
fn text(picture: &OutputFile) -> &str {
    // A drawing is made of text.
    std::str::from_utf8(&picture.bytes).unwrap_or_default()
}

/// The limit on the removal rate, mm³/s, if there is one.
fn rate_limit(job: &Job) -> Option<f64> {
    (job.force.control != ForceControl::Off).then(|| job.mrr_limit())
}

/// Pictures of a path before delivery.
fn before_delivery(job: &Job, prepared: &Prepared, laid: &Laid) -> Early {
    let (surface, chart) = (&prepared.surface, &prepared.chart);
    let path = path_on_surface(prepared, laid);
    let contacts = contacts(prepared, &path);
    let limit = rate_limit(job).filter(|_| laid.is_rated());
    let lines = FlatLines::default();
    let flat = flat_map(surface, chart, &lines, &path, limit);
    let view = surface_view(surface, &path, &contacts, limit);
    let file = |name: &str, svg: String| OutputFile { name: name.into(), bytes: svg.into_bytes() };
    let linked = Linked::of(&Drawn {
        surface,
        chart,
        lines: &lines,
        channel: None,
        path: &path,
        contacts: &contacts,
        plain: None,
        rest: Facets { positions: &[], faces: &[] },
        verification: None,
        limit,
        scallop: 0.0,
        tolerance: job.cut.tolerance,
    });
    Early { files: vec![file("flat.svg", flat), file("surface.svg", view)], linked, report: None }
}

/// The path before delivery, its tips on the surface.
fn path_on_surface(prepared: &Prepared, laid: &Laid) -> Toolpath {
    let locator = prepared.locator();
    let mut time = 0.0;
    let mut tip = DVec3::ZERO;
    let points = laid.points().iter().map(|p| {
        tip = locator.locate(p.at).map_or(tip, |at| prepared.surface.position(at));
        time += if p.feed > 0.0 { p.length / p.feed } else { 0.0 };
        PathPoint {
            kind: p.kind,
            pass: p.pass,
            region: 0,
            tip,
            axis: DVec3::Z,
            normal: DVec3::Z,
            flat: Some(p.at),
            feed: p.feed,
            mrr: p.mrr,
            alpha: p.alpha,
            time,
        }
    });
    Toolpath { points: points.collect() }
}

/// Simulates the delivered path and measures what it leaves and removes.
pub(crate) fn judge(
    job: &Job,
    planned: &Planned,
    stock: &Stock,
    threads: usize,
    progress: &mut dyn FnMut(f64),
) -> Result<(Verification, VerifyOptions), VerifyError> {
    let places = &planned.coverage.inaccessible_places;
    let sphere = |p: &evencut_core::removal::Place| Sphere { centre: p.centre, radius: p.radius };
    let options = VerifyOptions {
        inaccessible: places.iter().map(sphere).collect(),
        bridges: planned.prepared.bridges.clone(),
        stock: given_stock(planned.prepared.stock.as_ref()),
        avoided: avoided(&planned.prepared.avoided),
        earlier: earlier(stock),
        ..verify_options(job, planned.cusps.limit, threads)
    };
    let (positions, faces) = planned.prepared.surface.triangles();
    let design = Facets { positions, faces: &faces };
    let guarded = &planned.prepared.guarded;
    let rest = Facets { positions: &guarded.positions, faces: &guarded.faces };
    let verification = verify(&hub::simulated(planned), design, rest, &options, progress)?;
    Ok((verification, options))
}

/// What the judge is told of earlier cuts.
fn earlier(stock: &Stock) -> Option<Earlier> {
    let cut = |earlier: &std::sync::Arc<plan::Earlier>| EarlierCut {
        path: earlier.path.clone(),
        tool: earlier.cutter.tool,
        length: earlier.cutter.length,
    };
    let cuts: Vec<EarlierCut> = stock.earlier.iter().map(cut).collect();
    (!cuts.is_empty()).then_some(Earlier { top: stock.top, bridged: stock.bridged, cuts })
}

/// What the judge is told of meshes to stay away from.
pub(crate) fn avoided(meshes: &[plan::Avoided]) -> Vec<Avoided> {
    let of = |a: &plan::Avoided| Avoided {
        name: a.name.clone(),
        distance: a.distance,
        positions: a.mesh.positions.clone(),
        faces: a.mesh.faces.clone(),
    };
    meshes.iter().map(of).collect()
}

/// What the judge is told of where the stock ends.
pub(crate) fn given_stock(solid: Option<&surface::Part>) -> Option<Solid> {
    solid.map(|s| Solid { positions: s.positions.clone(), faces: s.faces.clone() })
}

/// The verification options of a job, apart from its meshes; `cusp_limit`: height of the cusps that are meant to stay,
/// mm.
pub fn verify_options(job: &Job, cusp_limit: f64, threads: usize) -> VerifyOptions {
    let limits_rate = job.force.control != ForceControl::Off;
    let of_radius = job.tool.radius() / SAMPLES_PER_RADIUS;
    VerifyOptions {
        tool: job.tool,
        length: job.cutter_length(),
        depth: job.cut.axial_depth,
        tells_rate: limits_rate,
        load: limits_rate.then(|| load_options(job)),
        allowance: job.cut.allowance,
        earlier: None,
        scallop: Some(cusp_limit),
        tolerance: job.cut.tolerance,
        mrr_limit: job.force.limit.filter(|_| limits_rate).map(|_| job.mrr_limit()),
        spacing: of_radius.min(job.nominal_side_step() / SAMPLES_PER_STEP),
        up: DVec3::Z,
        inaccessible: Vec::new(),
        bridges: Vec::new(),
        walls: (job.path.boundary == Boundary::Wall).then(|| walls(job)),
        above: above_cutter(job),
        stock: None,
        avoided: Vec::new(),
        threads,
    }
}

/// What is above the cutter of a job; of a hub it is measured against its blades, apart.
fn above_cutter(job: &Job) -> Option<AboveCutter> {
    let is_known = job.hub.is_none() && !job.assembly.sections.is_empty();
    is_known.then(|| AboveCutter { assembly: job.assembly.clone(), clearance: job.clearance })
}

/// The teeth of a job's cutter, and what may be asked of them.
fn load_options(job: &Job) -> LoadOptions {
    let bounds = job.bounds();
    LoadOptions {
        flutes: job.flutes,
        spindle: job.cut.spindle,
        material: job.force.material.map(|m| (m.kc11, m.mc)),
        most_engaged: (bounds.most_engaged < PI).then_some(bounds.most_engaged),
        least_per_tooth: (bounds.least_per_tooth > 0.0).then_some(bounds.least_per_tooth),
        most_power: job.force.power,
        most_force: job.force.cutting_force,
        knows_links: true,
    }
}

/// The walls around the surface of a job.
fn walls(job: &Job) -> Walls {
    let rise = match job.machine.axes {
        Axes::ThreeAxis => Rise::Up,
        Axes::FiveAxis(_) => Rise::Normal,
    };
    Walls { height: job.path.wall_height, rise }
}

/// The pictures of the planned path that the job requests; `regions`: the figures of the regions.
fn pictures(
    job: &Job,
    planned: &Planned,
    contacts: &[Option<DVec3>],
    regions: Option<&DivisionFigures>,
) -> Vec<Drawing> {
    let (surface, limit) = (&planned.prepared.surface, rate_limit(job));
    let path = &*hub::simulated(planned);
    let contacts = &contacts[..path.points.len()];
    let draw = |&picture: &Picture| match picture {
        Picture::Flat => {
            let lines = hub::lines(&planned.prepared);
            let svg = flat_map(surface, &planned.prepared.chart, &lines, path, limit);
            Some(Drawing::new(picture, "flat.svg", "Flat map", svg))
        }
        Picture::Surface => {
            let svg = surface_view(surface, path, contacts, limit);
            Some(Drawing::new(picture, "surface.svg", "Surface", svg))
        }
        Picture::Regions => {
            planned.passes.divided.as_ref().zip(regions).map(|(divided, figures)| {
                let svg = regions_map(surface, &division::picture(divided), figures);
                Drawing::new(picture, "regions.svg", "Regions", svg)
            })
        }
        Picture::Tensor => planned.passes.topology.as_ref().map(|topology| {
            let (chart, locator) = (&planned.prepared.chart, planned.prepared.locator());
            let direction_at = |at| topology::direction_at(topology, surface, &locator, at);
            let drawn = topology::picture(topology, planned.passes.divided.as_ref());
            let svg = tensor_map(surface, chart, &drawn, &direction_at);
            Drawing::new(picture, "tensor.svg", "Best feed directions", svg)
        }),
        Picture::Mrr => planned.plain.as_ref().map(|plain| {
            let before = Profile::of(&plain.at_full_feed);
            let svg = mrr_chart(&before, &Profile::of(path), job.mrr_limit());
            Drawing::new(picture, "mrr.svg", "Removal rate along time", svg)
        }),
        Picture::Channel => {
            let (positions, faces) = surface.triangles();
            hub::scene(&planned.prepared, Facets { positions, faces: &faces }).map(|scene| {
                let svg = channel_view(&scene, path, contacts, limit);
                Drawing::new(picture, "channel.svg", "Channel with tool axes", svg)
            })
        }
        Picture::Scallop | Picture::Removal | Picture::Clearance => None,
    };
    job.output.pictures.iter().filter_map(draw).collect()
}

/// What must not be cut into.
fn rest(planned: &Planned) -> Facets<'_> {
    let rest = &planned.prepared.rest;
    Facets { positions: &rest.positions, faces: &rest.faces }
}

/// The pictures of the simulation that the job requests; `clear`: what it found along a hub's channel.
fn measured(
    job: &Job,
    planned: &Planned,
    (found, options): &Judged,
    clear: Option<&Clearances>,
) -> Vec<Drawing> {
    let (positions, faces) = planned.prepared.surface.triangles();
    let design = Facets { positions, faces: &faces };
    let rest = rest(planned);
    let draw = |&picture: &Picture| match picture {
        Picture::Scallop => {
            let svg = residual_map(design, rest, found, options.scallop, options.tolerance);
            Some(Drawing::new(picture, "scallop.svg", "Measured: what is left", svg))
        }
        Picture::Removal => {
            let svg = rate_map(design, rest, found, &hub::simulated(planned), options.mrr_limit);
            Some(Drawing::new(picture, "removal.svg", "Measured: removal rate", svg))
        }
        Picture::Clearance => clear.map(|clear| {
            let svg = clearance_chart(clear);
            Drawing::new(picture, "clearance.svg", "Measured: clearance along time", svg)
        }),
        Picture::Flat
        | Picture::Surface
        | Picture::Regions
        | Picture::Tensor
        | Picture::Mrr
        | Picture::Channel => None,
    };
    job.output.pictures.iter().filter_map(draw).collect()
}

/// The place on the surface of every point of a path.
fn contacts(prepared: &Prepared, path: &Toolpath) -> Vec<Option<DVec3>> {
    let locator = prepared.locator();
    let place = |at| locator.locate(at).ok().map(|p| prepared.surface.position(p));
    path.points.iter().map(|p| p.flat.and_then(place)).collect()
}

/// Length of the contacts along passes, mm, by region.
fn lengths_of_passes(planned: &Planned, contacts: &[Option<DVec3>]) -> Vec<f64> {
    let count = planned.passes.divided.as_ref().map_or(1, |d| d.parts.len());
    let mut lengths = vec![0.0; count];
    let points = planned.toolpath.points.windows(2).zip(contacts.windows(2));
    for (points, contacts) in points {
        if let [Some(a), Some(b)] = contacts
            && points[1].kind == MoveKind::Cut
            && let Some(length) = lengths.get_mut(points[1].region as usize)
        {
            *length += a.distance(*b);
        }
    }
    lengths
}

/// The report of a plan that is not yet verified.
pub(crate) fn report(job: &Job, planned: &Planned, inputs: Vec<FileRecord>) -> Report {
    report_on(job, planned, inputs, &contacts(&planned.prepared, &planned.toolpath))
}

/// How a job's regions are made: the bands of `mpf` are regions, whatever division the job has.
fn division_of(job: &Job) -> &'static str {
    match job.path.pattern {
        _ if job.rest => "rest",
        pattern if pattern.divides_itself() => pattern.name(),
        _ => job.regions.method().name(),
    }
}

/// Where the axis of a path is off the lead of its job; of a hub all axes are sought.
fn tilted(job: &Job, path: &Toolpath) -> Option<TiltFigures> {
    let turns = job.machine.axes != Axes::ThreeAxis && job.hub.is_none();
    turns.then(|| TiltFigures::of(path, job.cut.lead)).flatten()
}

fn report_on(
    job: &Job,
    planned: &Planned,
    inputs: Vec<FileRecord>,
    contacts: &[Option<DVec3>],
) -> Report {
    let (limit, load) = (job.mrr_limit(), job.bounds());
    let surface = &planned.prepared.surface;
    let (flattening, quality) = (planned.prepared.flattening, &planned.prepared.quality);
    let figures = |path: &Toolpath, feed: f64| {
        let time = machine_time(path, &job.tool, &job.machine, job.cut.tolerance);
        let mut by_kind = ByKind::default();
        MoveKind::ALL.iter().for_each(|&kind| by_kind.add(kind, time.limited[kind]));
        let rate = || RateFigures::of(path, &load, job.force.material);
        PathFigures::of(path, feed, by_kind, planned.plain.is_some().then(rate))
    };
    let plain = planned.plain.as_ref().map(|plain| figures(&plain.at_full_feed, job.cut.feed));
    let slowed = planned.plain.as_ref().map(|plain| {
        let path = &plain.at_full_feed;
        let factor = slowest_of(path, &load, job.cut.feed) / job.cut.feed;
        figures(&slowed(path, factor, job), job.cut.feed * factor)
    });
    let locally = planned.plain.as_ref().and_then(|plain| plain.slowed.as_ref());
    let slowed_locally = locally.map(|path| figures(path, job.cut.feed));
    let lengths = lengths_of_passes(planned, contacts);
    let length: f64 = lengths.iter().sum();
    let division =
        planned.passes.divided.as_ref().map(|d| division::figures(d, division_of(job), &lengths));
    let delivered = figures(&planned.toolpath, job.cut.feed);
    let (low, high) = surface
        .positions()
        .iter()
        .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), &p| (low.min(p), high.max(p)));
    Report {
        format: FORMAT,
        job: job.name.clone(),
        versions: Versions { evencut: env!("CARGO_PKG_VERSION").into(), job_file: 1 },
        inputs,
        surface: SurfaceFigures {
            area_mm2: surface.area(),
            faces: surface.connectivity().face_count() as u64,
            vertices: surface.positions().len() as u64,
            boundary_loops: surface.connectivity().boundary_loops().len() as u64,
            box_low_mm: low.to_array(),
            box_high_mm: high.to_array(),
            smallest_concave_radius_mm: planned.tightest.map(|t| t.radius),
            smallest_concave_at_mm: planned.tightest.map(|t| t.place.to_array()),
            too_concave_mm2: planned.tightest.map_or(0.0, |t| t.too_concave),
            set_aside: planned.prepared.aside.as_ref().map(set_aside),
        },
        repairs: repairs(planned),
        warnings: warnings(job, planned, slowed_locally.as_ref(), &delivered),
        flatten: FlattenFigures {
            method: match job.flatten {
                _ if flattening.kind == MapKind::View => "view".into(),
                _ if flattening.kind == MapKind::Unfolded => "unfolded".into(),
                _ if flattening.kind == MapKind::Parameters => "parameters".into(),
                FlattenMethod::Abf => "abf".into(),
                FlattenMethod::Bff => "bff".into(),
            },
            iterations: flattening.steps as u64,
            constraint_residual: flattening.residual,
            quasi_conformal_mean: quality.mean_q,
            quasi_conformal_max: quality.max_q,
            scale_min: quality.min_s,
            scale_max: quality.max_s,
            flips: quality.flips as u64,
        },
        passes: PassFigures {
            pattern: job.path.pattern.name().into(),
            count: planned.passes.count as u64,
            tree_depth: planned.passes.depth as u64,
            closed_cores: planned.passes.closing.cores as u64,
            branches: planned.passes.closing.branches as u64,
            branch_length_mm: planned.passes.closing.length,
            widest_gap_passes: planned.passes.closing.widest_gap,
            length_floor_mm: planned.passes.length_floor,
            length_mm: length,
            length_over_floor: length / planned.passes.length_floor,
            retracts: planned.toolpath.retracts() as u64,
            even_share: planned.passes.even_share,
            tilted: tilted(job, &planned.toolpath),
        },
        setup: None,
        hub: planned.channels.as_ref().map(|figures| hub::figures(job, planned, figures)),
        regions: division,
        tensor: planned.passes.topology.as_ref().map(topology::figures),
        stepover: StepoverFigures {
            nominal_mm: job.nominal_side_step(),
            over_radius: job.nominal_side_step() / job.tool.radius(),
        },
        force: ForceFigures {
            control: job.force.control.name().into(),
            limit_mm3_per_min: per_minute(limit),
            straight_pass_mm3_per_min: per_minute(job.nominal_mrr()),
            max_engagement_deg: (load.most_engaged < PI).then(|| load.most_engaged.to_degrees()),
            min_chip_mm: (load.least_per_tooth > 0.0).then_some(load.least_per_tooth),
            preferred_chip_mm: match job.force.min_chip {
                MinChip::Wish(chip) if job.force.control == ForceControl::Fastest => Some(chip),
                _ => None,
            },
            power_w: job.force.power,
            cutting_force_n: job.force.cutting_force,
            over_limit_intervals: planned
                .plain
                .as_ref()
                .map(|plain| intervals_above(&plain.at_full_feed, &load)),
            trochoid_loops: planned.passes.loops as u64,
            plane: PlaneFigures::of(&planned.toolpath, &planned.planar, limit),
        },
        plain,
        slowed,
        slowed_locally,
        delivered,
        coverage: coverage(planned),
        gouge: GougeFigures { lifted: lifted(planned) },
        verification: None,
        texture: None,
        outputs: Vec::new(),
    }
}

/// The plain rings with every feed multiplied by `factor`.
fn slowed(plain: &Toolpath, factor: f64, job: &Job) -> Toolpath {
    let mut path = plain.clone();
    for p in &mut path.points {
        if p.kind != MoveKind::Rapid && p.flat.is_some() {
            p.feed *= factor;
            p.mrr *= factor;
        }
    }
    evencut_core::machine_time::fill_time(&mut path, &job.tool, &job.machine);
    path
}

/// The one feed at which every section of a path keeps the limits on rate and power, mm/s, `full` at most.
fn slowest_of(path: &Toolpath, load: &LoadLimits, full: f64) -> f64 {
    let cuts = path.points.iter().filter(|p| p.mrr > 0.0 && p.feed > 0.0);
    cuts.map(|p| load.feed(p.mrr / p.feed) * full / p.feed).fold(full, f64::min)
}

/// Number of runs of moves above the limits on rate and power, ignoring rounding.
fn intervals_above(path: &Toolpath, load: &LoadLimits) -> u64 {
    let above = |p: &PathPoint| p.feed > 0.0 && load.share(p.mrr / p.feed, p.feed) > 1.0 + 1e-9;
    let starts = |w: &&[PathPoint]| above(&w[1]) && !above(&w[0]);
    path.points.windows(2).filter(starts).count() as u64
}

fn coverage(planned: &Planned) -> CoverageFigures {
    let c = &planned.coverage;
    let sphere = |s: &evencut_core::removal::Place| [s.centre.x, s.centre.y, s.centre.z, s.radius];
    CoverageFigures {
        area_mm2: c.area,
        never_covered_mm2: c.never_covered,
        never_covered_percent: 100.0 * c.never_covered / c.area.max(f64::MIN_POSITIVE),
        inaccessible_mm2: c.inaccessible,
        inaccessible_at_mm: c.inaccessible_at.map(|p| p.to_array()),
        inaccessible_places: c.inaccessible_places.iter().map(sphere).collect(),
        cusp_limit_mm: planned.cusps.limit,
    }
}

fn lifted_length(planned: &Planned) -> f64 {
    planned.lifted.iter().map(|r| r.length).sum()
}

fn lifted(planned: &Planned) -> Vec<LiftedSpan> {
    let span = |r: &evencut_core::cutter_location::LiftedSpan| LiftedSpan {
        from_mm: r.place.to_array(),
        length_mm: r.length,
        lifted_by_mm: r.raise,
    };
    planned.lifted.iter().map(span).collect()
}

fn repairs(planned: &Planned) -> Vec<String> {
    planned.prepared.warnings.iter().filter_map(surface::Warning::repair).collect()
}

fn warning(stage: &str, message: String, remedy: &str) -> Warning {
    Warning { stage: stage.into(), message, remedy: remedy.into() }
}

/// Those remedies that apply.
fn remedies(all: &[(&str, bool)]) -> String {
    let those: Vec<&str> = all.iter().filter(|(_, applies)| *applies).map(|r| r.0).collect();
    those.join("; ")
}

/// A message without its leading stage name.
fn without_stage(message: &str) -> String {
    message.split_once(": ").map_or(message, |(_, rest)| rest).to_owned()
}

/// What helps where the cutter does not fit.
const SMALLER: &str =
    "use a smaller cutter or corner radius there, or a smaller cut.allowance if there is one";
/// What helps on a fixed axis where the surface has creases.
const REACHED: &str = "where it is noise, a fold or an edge, surface.steepest = 80.0 machines what the cutter reaches";

/// What helps beside a clamp.
const AVOIDED: &str =
    "beside what the cutter is kept clear of (avoid) no cutter helps, only another set-up";

/// What a reader should know before cutting.
fn warnings(
    job: &Job,
    planned: &Planned,
    slowed: Option<&PathFigures>,
    delivered: &PathFigures,
) -> Vec<Warning> {
    let is_of_creases = |w: &surface::Warning| matches!(w, surface::Warning::Creases { .. });
    // What the cutter leaves of a part has no places into which it does not fit.
    let may_be_reached = job.surface.steepest.is_none()
        && job.machine.axes == Axes::ThreeAxis
        && planned.prepared.warnings.iter().any(is_of_creases);
    let about_surface = planned.prepared.warnings.iter().filter(|w| w.repair().is_none());
    let about_surface = about_surface.map(|w| {
        let remedy = if is_of_creases(w) && may_be_reached { REACHED } else { "" };
        warning("surface", without_stage(&w.to_string()), remedy)
    });
    let mut out: Vec<Warning> = about_surface.collect();
    if let Some(aside) = &planned.prepared.aside {
        warn_of_aside(&mut out, job, aside);
    }
    let has_avoided = !job.avoid.is_empty();
    let c = &planned.coverage;
    if c.never_covered > 1e-3 * c.area {
        out.push(warning(
            "passes",
            format!("by the plan, {:.2} mm² stay higher than the cusps should be", c.never_covered),
            "choose a smaller cut.stepover or cut.scallop",
        ));
    }
    if c.inaccessible >= NOTEWORTHY {
        let message = format!(
            "{:.2} mm² are inaccessible: in corners, or beside walls and faces that the cutter must not touch",
            c.inaccessible
        );
        let smaller = "finish them with a smaller cutter";
        out.push(warning("passes", message, &remedies(&[(smaller, true), (AVOIDED, has_avoided)])));
    }
    if let Some(worst) = planned.lifted.iter().max_by(|a, b| a.raise.total_cmp(&b.raise)) {
        let length = match lifted_length(planned) {
            length if length < 0.05 => "less than 0.1".into(),
            length => format!("{length:.1}"),
        };
        out.push(warning(
            "cutter",
            format!(
                "the cutter does not fit on {} span{}, {length} mm in all; worst near \
                 ({:.3}, {:.3}, {:.3}) mm, lifted by {:.3} mm",
                planned.lifted.len(),
                if planned.lifted.len() == 1 { "" } else { "s" },
                worst.place.x,
                worst.place.y,
                worst.place.z,
                worst.raise
            ),
            &remedies(&[(SMALLER, true), (REACHED, may_be_reached), (AVOIDED, has_avoided)]),
        ));
    }
    let q = &planned.prepared.quality;
    if q.max_s > WIDEST_SCALE * q.min_s {
        let message = format!(
            "the scale of the flat map runs from {:.3} to {:.3}; side steps and removal rates are \
             inaccurate where it changes across the width of the cutter",
            q.min_s, q.max_s
        );
        out.push(warning("flatten", message, "select a smaller, flatter piece (surface.select)"));
    }
    out.extend(planned.channels.iter().flat_map(|figures| hub::warnings(job, figures)));
    warn_of_force(&mut out, job, planned, slowed, delivered);
    warn_of_tables(&mut out, job, planned, delivered);
    out
}

fn set_aside(aside: &Aside) -> AsideFigures {
    AsideFigures {
        selected_mm2: aside.selected,
        away_mm2: aside.away,
        steep_mm2: aside.steep,
        shadowed_mm2: aside.shadowed,
        small_mm2: aside.small,
        bridged_mm2: aside.bridged,
        deepest_bridged_mm: aside.deepest_bridged,
    }
}

/// What of the part is not machined in this setup, and what lies under the cutter without being touched.
fn warn_of_aside(out: &mut Vec<Warning>, job: &Job, aside: &Aside) {
    let steepest = job.surface.steepest.unwrap_or_default().to_degrees();
    let causes = [
        (aside.away, "face away from +Z".to_owned()),
        (aside.steep, format!("are steeper than {steepest:.0} degrees")),
        (aside.shadowed, "lie under something else".to_owned()),
        (aside.small, "lie in pieces too small for passes".to_owned()),
    ];
    let causes: Vec<String> = causes
        .into_iter()
        .filter(|(area, _)| *area >= NOTEWORTHY)
        .map(|(area, cause)| format!("{area:.2} mm² {cause}"))
        .collect();
    if !causes.is_empty() {
        let message = format!(
            "of {:.2} mm² selected are not machined: {}",
            aside.selected,
            causes.join(", ")
        );
        out.push(warning("surface", message, "machine them in another setup"));
    }
    if aside.bridged >= NOTEWORTHY {
        let message = format!(
            "on {:.2} mm² the cutter bridges the part, which lies up to {:.3} mm lower there",
            aside.bridged, aside.deepest_bridged
        );
        out.push(warning("surface", message, "finish these places with a smaller cutter"));
    }
}

/// What keeps the removal rate from being even, or makes it dear.
fn warn_of_force(
    out: &mut Vec<Warning>,
    job: &Job,
    planned: &Planned,
    slowed: Option<&PathFigures>,
    delivered: &PathFigures,
) {
    let top = job.cut.allowance + job.cut.axial_depth;
    if let Some(tightest) = planned.tightest.filter(|t| top > DEEP * t.radius)
        && job.force.control != ForceControl::Off
    {
        let message = format!(
            "the stock stands {top:.3} mm over the surface, whose smallest concave radius is {:.3} mm: where it reaches \
             over the other side of the hollow, predicted removal rates are inaccurate",
            tightest.radius
        );
        out.push(warning(
            "force",
            message,
            "rough it in layers first (cut.axial_depth, cut.allowance)",
        ));
    }
    if let Some(rate) = delivered.rate.filter(|rate| rate.peak_over_limit > 1.0) {
        out.push(warning(
            "force",
            format!("the load reaches {:.2} of its limit", rate.peak_over_limit),
            "set force.control to \"fastest\" or \"feed\"",
        ));
    }
    let slow =
        |p: &&[PathPoint]| p[1].flat.is_some() && p[1].feed < 0.5 * job.cut.feed && p[1].mrr > 0.0;
    let slow: f64 = (planned.toolpath.points.windows(2).filter(slow))
        .map(|w| w[0].tip.distance(w[1].tip))
        .sum();
    if job.force.control == ForceControl::Trochoid && slow > 0.01 * delivered.length_mm.total {
        out.push(warning(
            "force",
            format!("{slow:.0} mm of path had to be slowed below half the feed to keep the limit"),
            "raise force.relative or force.mrr_limit",
        ));
    }
    if planned.passes.are_loops_small {
        let message = "loops as large as a reduced feed allows break a limit on engagement or feed per tooth; these bite no more than the full feed allows, and take much longer".to_owned();
        out.push(warning(
            "force",
            message,
            "raise that limit, or reduce the side step or cut.axial_depth",
        ));
    }
    if let Some(slowed) = slowed.filter(|slowed| keeps_bounds(slowed, job))
        && planned.passes.loops > 0
        && delivered.machine_time_s.total > 1.01 * slowed.machine_time_s.total
    {
        let message = format!(
            "plain passes, slowed where it takes that, keep all limits and would take {:.0} s instead of {:.0} s",
            slowed.machine_time_s.total, delivered.machine_time_s.total
        );
        out.push(warning("force", message, "try force.control = \"fastest\" or \"feed\""));
    }
}

/// Whether a path keeps the job's limits on engagement and feed per tooth.
fn keeps_bounds(path: &PathFigures, job: &Job) -> bool {
    let bounds = job.bounds();
    path.rate.is_some_and(|rate| {
        rate.engagement_deg <= bounds.most_engaged.to_degrees() + 1e-6
            && rate.feed_per_tooth_mm >= bounds.least_per_tooth
    })
}

/// Rotary tables that make the path last much longer.
fn warn_of_tables(out: &mut Vec<Warning>, job: &Job, planned: &Planned, delivered: &PathFigures) {
    if job.machine.axes == Axes::ThreeAxis {
        return;
    }
    let machine = Machine { axes: Axes::ThreeAxis, ..job.machine };
    let path = &planned.toolpath;
    let without = machine_time(path, &job.tool, &machine, job.cut.tolerance).limited.total();
    let on_machine = delivered.machine_time_s.total;
    if on_machine > SLOW_TABLES * without {
        let message = format!(
            "the rotary axes make the path slower: {on_machine:.0} s on the machine, {without:.0} s without them"
        );
        let remedy = if job.hub.is_some() {
            "use faster rotary axes (machine.max_rotary_speed)"
        } else if job.path.pattern.uses("traverse") {
            "reduce cut.lead, set path.traverse = \"one-way\", or use faster rotary axes (machine.max_rotary_speed)"
        } else {
            "reduce cut.lead, or use faster rotary axes (machine.max_rotary_speed)"
        };
        out.push(warning("machine", message, remedy));
    }
}
