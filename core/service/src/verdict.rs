//! A path from a file → report and pictures of its verification, for paths made here and elsewhere.

use crate::results::hub::{Beside, measured_on};
use crate::results::{self, Input, OutputFile};
use evencut_core::geometry::{DVec3, math};
use evencut_core::job::Job;
use evencut_core::machine::Axes;
use evencut_core::mesh::{MeshFormat, ReadError, Repaired, Repairs, read, repair};
use evencut_core::plan::{CuspBudget, Design, Files, PlanError, SurfaceKeys};
use evencut_core::surface::{Part, Warning};
use evencut_core::toolpath::{CsvError, MoveKind, Toolpath};
use evencut_core::verify::{
    Avoided, Facets, LoadOptions, Solid, VerifyError, VerifyOptions, verify,
};
use evencut_output::gcode::{self, CheckOptions, Finding, GcodeError};
use evencut_output::preview::{rate_map, residual_map};
use evencut_output::report::{
    FORMAT, FileRecord, HubVerdict, Lines, VerificationFigures, VerificationReport, Versions,
};
use thiserror::Error;

/// Millimetres in an inch, and the factor by which a ratio may differ from it: a path is larger than its surface by
/// cutter and approaches.
const INCH: f64 = 25.4;
const INCH_SPREAD: f64 = 1.6;
/// A path this many times larger or smaller than the surface is probably in other units.
const FAR_LARGER: f64 = 12.0;
/// The same factor where the path touches nothing.
const LARGER: f64 = 4.0;

/// Why a path is not verified.
#[derive(Debug, Error)]
pub enum VerdictError {
    /// The path's table cannot be read.
    #[error(transparent)]
    Csv(#[from] CsvError),
    /// The path's program cannot be read.
    #[error(transparent)]
    Gcode(#[from] GcodeError),
    /// The path is not text.
    #[error("{name}: byte {at} is not UTF-8; a path is a toolpath.csv or a program in plain text")]
    NotText {
        /// The file.
        name: String,
        /// Index of the first byte that is not text.
        at: usize,
    },
    /// The file of a mesh cannot be read.
    #[error(transparent)]
    Read(#[from] ReadError),
    /// The file name has no known extension.
    #[error(
        "mesh: the format of {0:?} is not known; its name must end in .stl, .obj, .ply or .off"
    )]
    UnknownFormat(String),
    /// The mesh refers to vertices that do not exist or are not finite.
    #[error("mesh: face {face} refers to a vertex that does not exist or is not finite")]
    BadFace {
        /// Index of the face.
        face: usize,
    },
    /// The job's surface cannot be built.
    #[error(transparent)]
    Surface(Box<PlanError>),
    /// There is nothing to verify.
    #[error(transparent)]
    Verify(#[from] VerifyError),
}

/// The part against which a path is verified.
#[derive(Clone, Debug, Default)]
pub struct Workpiece {
    /// What is machined.
    pub design: Part,
    /// What is not machined and must not be cut into.
    pub rest: Part,
    /// Faces of what is machined over which the cutter bridges the part; empty where there are none.
    pub bridges: Vec<bool>,
    /// Where the stock ends before any cut, if that is known.
    pub stock: Option<Solid>,
    /// What the whole tool must stay away from.
    pub avoided: Vec<Avoided>,
    /// What stands beside the first channel of a hub.
    pub beside: Option<Beside>,
    /// Repairs of a mesh file; `None` where there is nothing worth mentioning.
    pub mended: Option<Warning>,
}

/// Signs that a path and a surface do not belong together.
#[derive(Copy, Clone, Debug, PartialEq, Error)]
pub enum Mismatch {
    /// One is far larger than the other.
    #[error(
        "the path spans {path:.1} mm, the surface {surface:.1} mm{}; check the units of both",
        inches(*path, *surface)
    )]
    Size {
        /// Longest side of the box around the cutting moves, mm.
        path: f64,
        /// That of the surface, mm.
        surface: f64,
    },
    /// They lie apart.
    #[error(
        "the cutting moves lie {distance:.1} mm away from the surface; the path may belong to another \
         job or another origin"
    )]
    Apart {
        /// Distance between the boxes around them, mm.
        distance: f64,
    },
    /// They lie at the same place, but do not meet.
    #[error("no move touches the surface; check the origin and the direction of the Z axis")]
    Untouched,
}

/// Hint for a ratio of sizes near 25.4.
fn inches(path: f64, surface: f64) -> &'static str {
    let is_inch = |ratio: f64| (INCH / INCH_SPREAD..INCH * INCH_SPREAD).contains(&ratio);
    if is_inch(path / surface) {
        ": the surface may be in inches (--scale 25.4)"
    } else if is_inch(surface / path) {
        ": the path may be in inches"
    } else {
        ""
    }
}

impl Mismatch {
    /// What is suspicious about a path that was verified.
    pub fn of(path: &Toolpath, workpiece: &Workpiece, report: &VerificationReport) -> Option<Self> {
        let figures = &report.verification;
        let untouched = figures.untouched_mm2 >= (1.0 - 1e-9) * figures.area_mm2;
        let cuts = path.points.iter().filter(|p| p.kind != MoveKind::Rapid).map(|p| p.tip);
        let corners = workpiece.design.faces.iter().flatten();
        let places = corners.map(|&v| workpiece.design.positions[v as usize]);
        let ((low, high), (least, most)) = (bounds(cuts), bounds(places));
        let (path, surface) = ((high - low).max_element(), (most - least).max_element());
        let ratio = path.max(surface) / path.min(surface);
        if !(path.is_finite() && surface.is_finite()) {
            return None;
        }
        if ratio > if untouched { LARGER } else { FAR_LARGER } {
            return Some(Self::Size { path, surface });
        }
        let distance = (low - most).max(least - high).max(DVec3::ZERO).length();
        match untouched {
            true if distance > 0.0 => Some(Self::Apart { distance }),
            true => Some(Self::Untouched),
            false => None,
        }
    }
}

/// Lowest and highest coordinates.
fn bounds(places: impl Iterator<Item = DVec3>) -> (DVec3, DVec3) {
    places.fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(l, h), p| (l.min(p), h.max(p)))
}

impl Workpiece {
    /// The part of a job: what it selects is machined, the rest of the part must not be cut into, and the tool must stay
    /// away from what the job avoids. Also returns the height of the cusps that the job allows, mm.
    ///
    /// # Errors
    /// [`VerdictError`] where the surface cannot be read or used.
    pub fn of_job(job: &Job, files: Files, threads: usize) -> Result<(Self, f64), VerdictError> {
        let failed = |error| VerdictError::Surface(Box::new(error));
        let keys = SurfaceKeys::of(job);
        let designed = Design::new(&keys, files, threads).map_err(failed)?;
        let beside = designed.passage().and_then(|p| Beside::of(job, p, &designed.guarded));
        let Design { surface, guarded, bridges, stock, avoided, .. } = designed;
        let (positions, faces) = surface.triangles();
        let design = Part { positions: positions.to_vec(), faces };
        let curvature = surface.curvature(job.surface.curvature_radius);
        let cusps = CuspBudget::of(job, &surface, &curvature).limit;
        let stock = results::given_stock(stock.as_ref());
        let avoided = results::avoided(&avoided);
        Ok((Self { rest: guarded, design, bridges, stock, avoided, beside, mended: None }, cusps))
    }

    /// The part in a mesh file, its lengths multiplied by `scale`: faces whose normals lie within `within` rad of +Z
    /// are machined. The mesh is welded and oriented outward, nothing else is repaired.
    ///
    /// # Errors
    /// [`VerdictError`] where the file cannot be read.
    pub fn of_mesh(file: Input, scale: f64, within: f64) -> Result<Self, VerdictError> {
        let Repaired { mesh, repairs } = mended(file, scale)?;
        let steepest = math::cos(within);
        let is_machined = |f: &&[u32; 3]| {
            let [a, b, c] = f.map(|v| mesh.positions[v as usize]);
            (b - a).cross(c - a).normalize_or_zero().z >= steepest
        };
        let of = |machined: bool| Part {
            positions: mesh.positions.clone(),
            faces: mesh.faces.iter().filter(|f| is_machined(f) == machined).copied().collect(),
        };
        // Welding exact copies is what every STL needs.
        let welded = Repairs { welded: 0, tolerance: 0.0, ..repairs.clone() };
        let mended = (welded != Repairs::default()).then_some(Warning::Repaired(repairs));
        let (design, rest) = (of(true), of(false));
        Ok(Self { design, rest, mended, ..Self::default() })
    }

    /// Adds the mesh in a file, its lengths multiplied by `scale`, to the rest of the part, which must not be cut
    /// into.
    ///
    /// # Errors
    /// [`VerdictError`] where the file cannot be read.
    pub fn guard(&mut self, file: Input, scale: f64) -> Result<(), VerdictError> {
        let mesh = mended(file, scale)?.mesh;
        self.rest.add(&Part { positions: mesh.positions, faces: mesh.faces });
        Ok(())
    }

    /// What is machined.
    pub fn design(&self) -> Facets<'_> {
        Facets { positions: &self.design.positions, faces: &self.design.faces }
    }

    /// The rest.
    pub fn rest(&self) -> Facets<'_> {
        Facets { positions: &self.rest.positions, faces: &self.rest.faces }
    }
}

/// The mesh in a file, its lengths multiplied by `scale`, welded and oriented.
fn mended(file: Input, scale: f64) -> Result<Repaired, VerdictError> {
    let format = MeshFormat::from_name(file.name)
        .ok_or_else(|| VerdictError::UnknownFormat(file.name.to_owned()))?;
    let mut soup = read(file.bytes, format)?;
    soup.positions.iter_mut().for_each(|p| *p *= scale);
    let is_there = |&v: &u32| soup.positions.get(v as usize).is_some_and(|p| p.is_finite());
    if let Some(face) = soup.faces.iter().position(|f| !f.iter().all(is_there)) {
        return Err(VerdictError::BadFace { face });
    }
    Ok(repair(soup))
}

/// A path as it was read.
#[derive(Clone, Debug)]
pub struct ReadPath {
    /// The path.
    pub path: Toolpath,
    /// Lines of its points, for a program.
    pub lines: Option<Vec<u32>>,
    /// What is wrong with the program.
    pub findings: Vec<Finding>,
}

/// How a program is read and checked.
#[derive(Clone, Debug, Default)]
pub struct ProgramRules {
    /// The machine's axes.
    pub axes: Axes,
    /// Speed of rapids, mm/s; the reader's default where not given.
    pub rapid_feed: Option<f64>,
    /// The limits against which it is checked.
    pub check: CheckOptions,
}

impl ReadPath {
    /// A path from a file: a `toolpath.csv` by its name, else a program.
    ///
    /// # Errors
    /// [`VerdictError`], naming the line.
    pub fn new(file: Input, rules: &ProgramRules) -> Result<Self, VerdictError> {
        let text = std::str::from_utf8(file.bytes).map_err(|error| VerdictError::NotText {
            name: file.name.to_owned(),
            at: error.valid_up_to(),
        })?;
        if file.name.to_ascii_lowercase().ends_with(".csv") {
            let path = Toolpath::from_csv(text)?;
            return Ok(Self { path, lines: None, findings: Vec::new() });
        }
        let mut reading = gcode::ReadOptions { axes: rules.axes, ..gcode::ReadOptions::default() };
        reading.rapid_feed = rules.rapid_feed.unwrap_or(reading.rapid_feed);
        let program = gcode::read(text, &reading)?;
        let findings = gcode::check(&program, &rules.check);
        Ok(Self { path: program.path, lines: Some(program.lines), findings })
    }

    /// Lines of its points.
    pub fn lines(&self) -> Lines<'_> {
        self.lines.as_deref().map_or(Lines::Table, Lines::Listed)
    }
}

/// The result of verifying a path.
#[derive(Clone, Debug)]
pub struct Verdict {
    /// The report.
    pub report: VerificationReport,
    /// Report and pictures as files.
    pub files: Vec<OutputFile>,
}

/// Verifies a path. `inputs`: the files it comes from, for the record.
///
/// # Errors
/// [`VerdictError::Verify`] when there is nothing to verify.
pub fn verdict(
    read: &ReadPath,
    workpiece: &Workpiece,
    options: &VerifyOptions,
    inputs: &[Input],
    progress: &mut dyn FnMut(f64),
) -> Result<Verdict, VerdictError> {
    let (design, rest) = (workpiece.design(), workpiece.rest());
    let load = match read.lines {
        Some(_) => options.load.map(LoadOptions::of_program),
        None => options.load,
    };
    let options = &VerifyOptions {
        bridges: workpiece.bridges.clone(),
        stock: workpiece.stock.clone(),
        avoided: workpiece.avoided.clone(),
        load,
        ..options.clone()
    };
    let verification = verify(&read.path, design, rest, options, progress)?;
    let clear = workpiece.beside.as_ref().and_then(|beside| {
        let (measured, _) = measured_on(&read.path, beside, options.threads)?;
        Some(HubVerdict { clearance_mm: beside.wanted, measured })
    });
    let mut findings: Vec<String> = read.findings.iter().map(ToString::to_string).collect();
    findings.extend(clear.as_ref().and_then(HubVerdict::broken));
    let report = VerificationReport {
        format: FORMAT,
        versions: Versions { evencut: env!("CARGO_PKG_VERSION").into(), job_file: 1 },
        inputs: inputs.iter().map(|f| FileRecord::of(f.name, f.bytes)).collect(),
        verification: VerificationFigures::of(&verification, options, read.lines(), findings),
        hub: clear,
    };
    let scallop = residual_map(design, rest, &verification, options.scallop, options.tolerance);
    let file =
        |name: &str, text: String| OutputFile { name: name.into(), bytes: text.into_bytes() };
    let mut files = vec![file("verification.json", report.to_json()), file("scallop.svg", scallop)];
    if options.tells_rate {
        let removal = rate_map(design, rest, &verification, &read.path, options.mrr_limit);
        files.push(file("removal.svg", removal));
    }
    Ok(Verdict { report, files })
}

/// The direction from which slopes are measured.
pub const UP: DVec3 = DVec3::Z;
