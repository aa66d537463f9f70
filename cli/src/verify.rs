//! `evencut verify`: what a path really leaves and removes.

use evencut_core::units::per_second;
use std::path::{Path, PathBuf};

use clap::{ArgGroup, Args, ValueEnum};
use evencut_core::geometry::DVec3;
use evencut_core::job::{Faults, Job, Resolved};
use evencut_core::machine::{Arrangement, Axes};
use evencut_core::tool::Tool;
use evencut_core::verify::{Rise, Sphere, VerifyError, VerifyOptions, Walls};
use evencut_output::gcode::CheckOptions;
use evencut_output::report::{FileRecord, Recorded};
use evencut_service::results::{Input, named_files, verify_options};
use evencut_service::verdict::{
    Mismatch, ProgramRules, ReadPath, UP, Verdict, VerdictError, Workpiece, verdict,
};

use crate::input::{Contents, Paths};
use crate::output::{self, ResultDirectory};
use crate::plan::{Failed, broken, of_output};
use crate::progress::Progress;
use crate::{Exit, Streams, input};

/// Samples per cutter radius where nothing else determines their density.
const SAMPLES_PER_RADIUS: f64 = 40.0;
/// Depth of the stock where it is not given, as a fraction of the cutter radius; the removal rate is then not
/// reported.
const UNKNOWN_DEPTH: f64 = 0.2;

/// Least and largest factor on a mesh's lengths.
const SCALES: (f64, f64) = (1e-6, 1e6);
/// Least and largest height of a wall, mm.
const WALL_HEIGHTS: (f64, f64) = (0.001, 10_000.0);
/// Samples per cutter radius, at least.
const FEWEST_PER_RADIUS: f64 = 4.0;
/// Deepest stock that is simulated, cutter radii.
const MOST_RADII: f64 = 20.0;

/// Arguments of `evencut verify`.
#[derive(Args)]
#[command(group(ArgGroup::new("meshes").args(["surface", "part"]).multiple(true)))]
pub struct Verify {
    /// Directory of results (its toolpath.csv), a toolpath.csv, or a program (G-code)
    #[arg(value_name = "PATH")]
    path: PathBuf,
    /// Job that the path belongs to: surface, cutter, limits and machine are taken from it
    #[arg(long, value_name = "JOB", conflicts_with_all = ["surface", "tool"])]
    job: Option<PathBuf>,
    /// Mesh of the surface that the path machines: stl, obj, ply or off [default: that of the directory of results]
    #[arg(long, value_name = "FILE", requires = "tool")]
    surface: Option<PathBuf>,
    /// Further mesh of the part: it is not machined and must not be cut into
    #[arg(long, value_name = "FILE")]
    part: Option<PathBuf>,
    /// The boundary of the machined surface is a wall, which must not be cut into
    #[arg(long, requires = "surface", conflicts_with = "job")]
    wall: bool,
    /// Height of the wall above the edge of the machined surface, mm [default: the cutter's diameter, or the
    /// height of the stock if that is more]
    #[arg(long, value_name = "MM", requires = "wall", allow_hyphen_values = true)]
    wall_height: Option<f64>,
    /// Factor on the lengths of --surface and --part that makes them millimetres
    #[arg(
        long,
        default_value_t = 1.0,
        value_name = "S",
        requires = "meshes",
        allow_hyphen_values = true
    )]
    scale: f64,
    /// Faces of the mesh within this angle of +Z are machined; the others must not be cut into
    #[arg(
        long,
        default_value_t = 89.9,
        value_name = "DEGREES",
        requires = "surface",
        allow_hyphen_values = true
    )]
    within: f64,
    /// Cutter: ball:DIAMETER, flat:DIAMETER or bull:DIAMETER:CORNER_RADIUS, mm
    #[arg(long, value_name = "CUTTER", value_parser = cutter, requires = "surface")]
    tool: Option<Tool>,
    /// Axes of the machine that runs the program
    #[arg(long, value_enum, default_value_t = Machine::Three)]
    axes: Machine,
    /// Limit on the scallop height, mm [default: the job's]
    #[arg(long, value_name = "MM", allow_hyphen_values = true)]
    scallop: Option<f64>,
    /// Tolerance on scallop height and gouges, mm [default: the job's, or 0.005]
    #[arg(long, value_name = "MM", allow_hyphen_values = true)]
    tolerance: Option<f64>,
    /// Axial depth of the stock, mm, for the removal rate [default: the job's]
    #[arg(long, value_name = "MM", allow_hyphen_values = true)]
    depth: Option<f64>,
    /// Allowance left on the surface, mm [default: the job's, or 0]
    #[arg(long, value_name = "MM", allow_hyphen_values = true)]
    allowance: Option<f64>,
    /// Limit on the removal rate, mm³/min [default: the job's]
    #[arg(long, value_name = "MM3/MIN", allow_hyphen_values = true)]
    mrr_limit: Option<f64>,
    /// Distance between samples, mm [default: a tenth of the job's side step, or R/40]
    #[arg(long, value_name = "MM", allow_hyphen_values = true)]
    spacing: Option<f64>,
    /// Directory for the report and pictures
    #[arg(short, long, value_name = "DIR")]
    output: Option<PathBuf>,
    /// Number of threads; the results do not depend on it [default: all]
    #[arg(long, value_name = "N")]
    threads: Option<std::num::NonZeroUsize>,
    /// Print the report as JSON
    #[arg(long)]
    json: bool,
}

/// Axes of a machine, as arguments name them.
#[derive(Copy, Clone, PartialEq, Eq, ValueEnum)]
enum Machine {
    #[value(name = "3")]
    Three,
    Xyzac,
    Xyzbc,
}

/// A cutter from `ball:10`, `flat:10` or `bull:10:1`.
fn cutter(text: &str) -> Result<Tool, String> {
    let fields: Vec<&str> = text.split(':').collect();
    let number = |s: &str| s.parse::<f64>().map_err(|_| format!("{s:?} is no number"));
    let (diameter, corner) = match fields[..] {
        ["ball", d] => (number(d)?, 0.5 * number(d)?),
        ["flat", d] => (number(d)?, 0.0),
        ["bull", d, c] => (number(d)?, number(c)?),
        _ => return Err("write ball:10, flat:10 or bull:10:1".into()),
    };
    Tool::new(0.5 * diameter, corner).map_err(|error| error.to_string())
}

/// The data against which a path is verified.
struct Subject {
    workpiece: Workpiece,
    options: VerifyOptions,
    rules: ProgramRules,
    /// Names and contents of the files that the job names and of the part's, where there are such.
    meshes: Vec<(String, Vec<u8>)>,
}

impl Verify {
    /// Verifies the path.
    pub fn run(&self, streams: &mut Streams<'_>) -> Exit {
        match self.verify(streams) {
            Ok(()) => Exit::Done,
            Err(Failed(exit, message)) => {
                streams.message(&message);
                exit
            }
        }
    }

    fn verify(&self, streams: &mut Streams<'_>) -> Result<(), Failed> {
        if let Some(target) = &self.output {
            output::check(target).map_err(|error| of_output(&error))?;
        }
        let (file, inaccessible) = self.path_file(streams)?;
        let mut subject = match (&self.job, &self.surface) {
            (Some(job), _) => self.of_job(job, |read| Paths::of_job(job, read))?,
            (None, Some(surface)) => self.of_mesh(surface)?,
            (None, None) => self.of_results()?,
        };
        if let Some(mended) = &subject.workpiece.mended {
            streams.message(&format!("warning: {mended}\n"));
        }
        if let Some(part) = &self.part {
            self.guard(part, &mut subject)?;
        }
        self.override_options(&mut subject.options);
        self.refuse_bad_numbers(&subject.options)?;
        subject.options.inaccessible = inaccessible;
        let bytes = std::fs::read(&file).map_err(|e| Failed::file(Exit::BadJob, e, &file))?;
        let name = file.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let path = Input { name: &name, bytes: &bytes };
        let read = ReadPath::new(path, &subject.rules)
            .map_err(|error| Failed::file(Exit::BadJob, error, &file))?;
        let meshes = subject.meshes.iter().map(|(name, bytes)| Input { name, bytes });
        let inputs: Vec<Input> = std::iter::once(path).chain(meshes).collect();
        let mut progress = Progress::on_standard_error();
        let verdict = verdict(&read, &subject.workpiece, &subject.options, &inputs, &mut |part| {
            progress.report("simulating the path", part);
        })
        .map_err(|error| match (&error, &self.surface) {
            (VerdictError::Verify(VerifyError::NoSurface), Some(surface)) => {
                let message = format!("{error}: no facet lies within --within of +Z");
                Failed::file(Exit::BadSurface, message, surface)
            }
            _ => Failed::file(exit_of(&error), error, &file),
        })?;
        drop(progress);
        if let Some(mismatch) = Mismatch::of(&read.path, &subject.workpiece, &verdict.report) {
            streams.message(&format!("hint: {mismatch}\n"));
        }
        self.tell(&verdict, &file, subject.options.spacing, streams)
    }

    /// The path's file, and the places where the plan beside it says that the cutter does not fit.
    fn path_file(&self, streams: &mut Streams<'_>) -> Result<(PathBuf, Vec<Sphere>), Failed> {
        let (file, directory) = if self.path.is_dir() {
            (self.path.join("toolpath.csv"), self.path.as_path())
        } else {
            (self.path.clone(), self.path.parent().unwrap_or(Path::new("")))
        };
        if self.path.is_dir() && !file.exists() {
            let is_of_operations = self.path.join("1-toolpath.csv").exists();
            let message = match program_in(&self.path) {
                _ if is_of_operations => "the directory holds the results of several operations, and one path with one \
                                          tool is verified here; their plan has simulated them one after the other: \
                                          see report.json and the reports of the operations"
                    .to_owned(),
                Some(name) => format!(
                    "the directory holds no toolpath.csv, but {name}: name that file to verify it"
                ),
                None => "the directory holds no toolpath.csv; give a directory of results, a \
                         toolpath.csv or a program"
                    .to_owned(),
            };
            return Err(Failed::file(Exit::BadJob, message, &self.path));
        }
        let report = directory.join("report.json");
        let Ok(bytes) = std::fs::read(&report) else { return Ok((file, Vec::new())) };
        let recorded =
            Recorded::read(&bytes).map_err(|error| Failed::file(Exit::BadJob, error, &report))?;
        for name in changed(&recorded, directory) {
            streams.message(&format!(
                "warning: {name} is not the file that {} was written with; {}\n",
                input::shown(&report),
                if self.path.is_dir() && name != "toolpath.csv" {
                    "only toolpath.csv is verified here: name the program to verify it"
                } else {
                    "the inaccessible places in the report may not be those of this path"
                }
            ));
        }
        let places = recorded.coverage.inaccessible_places.iter();
        let sphere = |&[x, y, z, radius]: &[f64; 4]| Sphere { centre: DVec3::new(x, y, z), radius };
        Ok((file, places.map(sphere).collect()))
    }

    /// Subject from the job with which results were made.
    fn of_results(&self) -> Result<Subject, Failed> {
        let job = self.path.join("job.resolved.toml");
        if !job.is_file() {
            let message = "error: give --job, or --surface and --tool; only a directory of results \
                           holds the job it was made with\n";
            return Err(Failed(Exit::BadJob, message.into()));
        }
        self.of_job(&job, |read| Paths::of_results(&self.path, read)).map_err(|failed| {
            let no_file = failed.0 == Exit::BadSurface;
            let help = "help: the job of these results is somewhere else: name it with --job\n";
            Failed(failed.0, failed.1 + if no_file { help } else { "" })
        })
    }

    /// Subject from a job; `paths` returns the paths of the files that it names.
    fn of_job(&self, path: &Path, paths: impl Fn(&Job) -> Paths) -> Result<Subject, Failed> {
        let failed = |exit, faults: Faults, source: &[u8]| {
            Failed(exit, faults.render(&input::name(path), source))
        };
        let source = input::read_job(path)
            .map_err(|fault| failed(Exit::BadJob, Faults(vec![fault]), b""))?;
        let Resolved { job, beside, .. } = input::resolved(path, &source)
            .and_then(Resolved::only)
            .map_err(|faults| failed(Exit::BadJob, faults, &source))?;
        let contents = Contents::read(paths(&job), &source)
            .map_err(|fault| failed(Exit::BadSurface, Faults(vec![fault]), &source))?
            .beside(beside);
        let (workpiece, cusp_limit) = Workpiece::of_job(&job, contents.files(), self.threads())
            .map_err(|error| Failed::file(Exit::BadSurface, error, path))?;
        let meshes = named_files(&job, contents.files());
        Ok(Subject {
            options: verify_options(&job, cusp_limit, self.threads()),
            rules: rules_of(&job),
            workpiece,
            meshes: meshes.iter().map(|m| (m.name.to_owned(), m.bytes.to_owned())).collect(),
        })
    }

    fn of_mesh(&self, file: &Path) -> Result<Subject, Failed> {
        // The arguments' rules ask for both.
        let Some(tool) = self.tool else {
            return Err(Failed(Exit::BadJob, "error: --surface also needs --tool\n".into()));
        };
        in_range("--scale", self.scale, SCALES)?;
        in_range("--within", self.within, (0.0, 180.0))?;
        let (name, bytes) = mesh_file(file)?;
        let workpiece = Workpiece::of_mesh(
            Input { name: &name, bytes: &bytes },
            self.scale,
            self.within.to_radians(),
        )
        .map_err(|error| Failed::file(Exit::BadSurface, error, file))?;
        let axes = match self.axes {
            Machine::Three => Axes::ThreeAxis,
            Machine::Xyzac => Arrangement::Xyzac.axes(0.0),
            Machine::Xyzbc => Arrangement::Xyzbc.axes(0.0),
        };
        let options = VerifyOptions {
            tool,
            length: match self.axes {
                Machine::Three => f64::INFINITY,
                _ => 4.0 * tool.radius(),
            },
            depth: UNKNOWN_DEPTH * tool.radius(),
            tells_rate: self.depth.is_some(),
            earlier: None,
            allowance: 0.0,
            scallop: None,
            tolerance: 0.005,
            mrr_limit: None,
            load: None,
            spacing: tool.radius() / SAMPLES_PER_RADIUS,
            up: UP,
            inaccessible: Vec::new(),
            bridges: Vec::new(),
            walls: None,
            above: None,
            stock: None,
            avoided: Vec::new(),
            threads: self.threads(),
        };
        Ok(Subject {
            workpiece,
            options,
            rules: ProgramRules { axes, ..ProgramRules::default() },
            meshes: vec![(name, bytes)],
        })
    }

    /// Adds the further mesh to what must not be cut into.
    fn guard(&self, file: &Path, subject: &mut Subject) -> Result<(), Failed> {
        in_range("--scale", self.scale, SCALES)?;
        let (name, bytes) = mesh_file(file)?;
        let input = Input { name: &name, bytes: &bytes };
        subject
            .workpiece
            .guard(input, self.scale)
            .map_err(|error| Failed::file(Exit::BadSurface, error, file))?;
        subject.meshes.push((name, bytes));
        Ok(())
    }

    fn override_options(&self, options: &mut VerifyOptions) {
        options.scallop = self.scallop.or(options.scallop);
        options.tolerance = self.tolerance.unwrap_or(options.tolerance);
        options.depth = self.depth.unwrap_or(options.depth);
        options.allowance = self.allowance.unwrap_or(options.allowance);
        options.mrr_limit = self.mrr_limit.map(per_second).or(options.mrr_limit);
        options.spacing = self.spacing.unwrap_or(options.spacing);
        if self.wall {
            let stock = if options.tells_rate {
                options.allowance + options.depth
            } else {
                options.allowance
            };
            let height = self.wall_height.unwrap_or(stock.max(2.0 * options.tool.radius()));
            let rise = if self.axes == Machine::Three { Rise::Up } else { Rise::Normal };
            options.walls = Some(Walls { height, rise });
        }
    }

    fn refuse_bad_numbers(&self, options: &VerifyOptions) -> Result<(), Failed> {
        let rules = [
            ("--scallop", options.scallop.unwrap_or(1.0), f64::MIN_POSITIVE),
            ("--tolerance", options.tolerance, 0.0),
            ("--depth", options.depth, f64::MIN_POSITIVE),
            ("--allowance", options.allowance, 0.0),
            ("--mrr-limit", options.mrr_limit.unwrap_or(1.0), f64::MIN_POSITIVE),
            ("--spacing", options.spacing, f64::MIN_POSITIVE),
        ];
        if let Some(height) = self.wall_height {
            in_range("--wall-height", height, WALL_HEIGHTS)?;
        }
        let deepest = MOST_RADII * options.tool.radius();
        for (name, value) in [("--depth", options.depth), ("--allowance", options.allowance)] {
            if value > deepest {
                let message = format!(
                    "error: {name} is {value} mm; it must be at most {deepest} mm, {MOST_RADII} \
                     cutter radii\n"
                );
                return Err(Failed(Exit::BadJob, message));
            }
        }
        for (name, value, least) in rules {
            if !(value.is_finite() && value >= least) {
                let rule = if least > 0.0 { "positive" } else { "0 or positive" };
                let message = format!("error: {name} is {value}; it must be a {rule} number\n");
                return Err(Failed(Exit::BadJob, message));
            }
        }
        let widest = options.tool.radius() / FEWEST_PER_RADIUS;
        if options.spacing > widest {
            let message = format!(
                "error: --spacing is {} mm; it must be at most {widest} mm, a quarter of the cutter's radius\n",
                options.spacing
            );
            return Err(Failed(Exit::BadJob, message));
        }
        Ok(())
    }

    fn threads(&self) -> usize {
        let all = || std::thread::available_parallelism().ok();
        self.threads.or_else(all).map_or(1, std::num::NonZeroUsize::get)
    }

    /// Prints and writes the result.
    fn tell(
        &self,
        verdict: &Verdict,
        file: &Path,
        asked: f64,
        streams: &mut Streams<'_>,
    ) -> Result<(), Failed> {
        let figures = &verdict.report.verification;
        if figures.spacing_mm > asked * (1.0 + 1e-9) {
            streams.message(&format!(
                "warning: a sample distance of {asked} mm needs too many samples; {:.4} mm is used instead\n",
                figures.spacing_mm
            ));
        }
        if self.json {
            streams.data(&verdict.report.to_json());
        } else {
            streams.data(&format!("{}\n{}", input::shown(file), verdict.report.to_text()));
        }
        if let Some(target) = &self.output {
            let write = || {
                let mut directory = ResultDirectory::begin(target)?;
                for file in &verdict.files {
                    directory.write(&file.name, &file.bytes)?;
                }
                directory.commit()
            };
            write().map_err(|error| of_output(&error))?;
            streams.message(&format!("verdict in {}\n", input::shown(target)));
        }
        if figures.passed {
            return Ok(());
        }
        Err(Failed(Exit::NotVerified, broken(&figures.broken, &figures.remedies)))
    }
}

/// The limits for a program of a job's machine.
fn rules_of(job: &Job) -> ProgramRules {
    ProgramRules {
        axes: job.machine.axes,
        rapid_feed: Some(job.machine.max_feed),
        check: CheckOptions {
            travel: job.machine.travel,
            max_feed: Some(job.machine.max_feed),
            ..CheckOptions::default()
        },
    }
}

fn exit_of(error: &VerdictError) -> Exit {
    match error {
        VerdictError::Csv(_)
        | VerdictError::Gcode(_)
        | VerdictError::NotText { .. }
        | VerdictError::Verify(VerifyError::NoPath { .. } | VerifyError::TooFine { .. }) => {
            Exit::BadJob
        }
        VerdictError::Verify(_)
        | VerdictError::Read(_)
        | VerdictError::UnknownFormat(_)
        | VerdictError::BadFace { .. }
        | VerdictError::Surface(_) => Exit::BadSurface,
    }
}

/// Name and content of the file of a mesh.
fn mesh_file(file: &Path) -> Result<(String, Vec<u8>), Failed> {
    let bytes = std::fs::read(file).map_err(|error| Failed::file(Exit::BadSurface, error, file))?;
    let name = file.file_name().unwrap_or_default().to_string_lossy().into_owned();
    Ok((name, bytes))
}

/// Rejects an argument outside its range.
fn in_range(name: &str, value: f64, (least, most): (f64, f64)) -> Result<(), Failed> {
    if (least..=most).contains(&value) {
        return Ok(());
    }
    let message = format!("error: {name} is {value}; it must be from {least} to {most}\n");
    Err(Failed(Exit::BadJob, message))
}

/// A program of results in a directory.
fn program_in(directory: &Path) -> Option<String> {
    let names = std::fs::read_dir(directory)
        .ok()?
        .filter_map(|entry| entry.ok()?.file_name().into_string().ok());
    names.filter(|name| name.starts_with("program.")).min()
}

/// Paths and programs beside a report whose content differs from the report's record.
fn changed(report: &Recorded, directory: &Path) -> Vec<String> {
    let differs = |output: &&FileRecord| {
        let is_path = output.name == "toolpath.csv" || output.name.starts_with("program.");
        let content = std::fs::read(directory.join(&output.name)).ok().filter(|_| is_path);
        content.is_some_and(|content| FileRecord::of(&output.name, &content) != **output)
    };
    report.outputs.iter().filter(differs).map(|output| output.name.clone()).collect()
}
