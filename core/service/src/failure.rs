//! Why a job was not planned: exit code, place in the job file, and hint.

use evencut_core::cutter_location::LocateError;
use evencut_core::hub::HubError;
use evencut_core::job::Fault;
use evencut_core::level_set::LevelSetError;
use evencut_core::link::DeliverError;
use evencut_core::nurbs::NurbsError;
use evencut_core::plan::PlanError;
use evencut_core::reach::ReachError;
use evencut_core::step::{SmoothError, StepError};
use evencut_core::surface::SurfaceError;
use evencut_core::texture::window::WindowError;
use evencut_core::verify::VerifyError;
use evencut_output::post::{DialectError, PostError};

use crate::faults::{self, NamedFile};
use crate::results::ResultsError;
use crate::results::texture::TextureError;

/// How a run ended; the process's exit code.
#[derive(Copy, Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Exit {
    /// Done.
    Done = 0,
    /// A bug in evencut, or output that cannot be written.
    Internal = 1,
    /// Bad usage or a bad job file.
    BadJob = 2,
    /// The surface cannot be read or used.
    BadSurface = 3,
    /// A limit cannot be kept, or the cutter does not fit.
    LimitNotMet = 4,
    /// The finished path failed verification.
    NotVerified = 5,
}

impl Exit {
    /// The exit code.
    pub fn code(self) -> u8 {
        self as u8
    }
}

/// Keys that say where the surface comes from.
const SOURCE: &[&str] = &["surface.file", "surface.analytic.kind"];

/// How a failure is reported.
struct Failure {
    exit: Exit,
    /// Keys to point at: the first one that the job file contains.
    keys: &'static [&'static str],
    hint: Hint,
}

enum Hint {
    /// The message is complete.
    None,
    /// `evencut inspect` shows more about the mesh.
    Inspect,
    /// It should not have happened.
    Bug,
}

fn bad_surface(keys: &'static [&'static str], hint: Hint) -> Failure {
    Failure { exit: Exit::BadSurface, keys, hint }
}

/// A job that asks its post-processor for what that cannot write.
fn bad_post(keys: &'static [&'static str]) -> Failure {
    Failure { exit: Exit::BadJob, keys, hint: Hint::None }
}

fn limit(keys: &'static [&'static str]) -> Failure {
    Failure { exit: Exit::LimitNotMet, keys, hint: Hint::None }
}

const BUG: Failure = Failure { exit: Exit::Internal, keys: &[], hint: Hint::Bug };

/// The exit code of a failure, and the fault to show. `surface`: the surface file, if any.
pub fn explain(error: &ResultsError, job_source: &[u8], surface: Option<&str>) -> (Exit, Fault) {
    let failure = match error {
        ResultsError::Plan(error) => of_plan(error),
        ResultsError::Post(error) => of_post(error),
        ResultsError::Verify(VerifyError::TooFine { .. }) => {
            limit(&["tool.diameter", "surface.scale", "surface.file"])
        }
        ResultsError::Texture(error) => of_texture(error),
        ResultsError::Verify(_) | ResultsError::Program(_) => BUG,
    };
    let place = match error {
        ResultsError::Plan(PlanError::Avoided { index, .. }) => {
            faults::place(job_source, &NamedFile::Avoid(*index).key())
        }
        _ => failure.keys.iter().find_map(|key| faults::place(job_source, key)),
    };
    let mut fault = faults::fault(error.to_string(), place);
    match (failure.hint, surface) {
        (Hint::Inspect, Some(file)) => {
            fault.help.push(format!("`evencut inspect {file}` shows more of the mesh"));
        }
        (Hint::Bug, _) => fault.help.push(
            "this is a bug in evencut: please report it with the job file and the surface file"
                .into(),
        ),
        (Hint::Inspect | Hint::None, _) => {}
    }
    (failure.exit, fault)
}

fn of_plan(error: &PlanError) -> Failure {
    match error {
        PlanError::NoRest { .. } | PlanError::RestTooNarrow { .. } => limit(&["operation"]),
        PlanError::NoFile(_) => BUG,
        PlanError::UnknownFormat(_) | PlanError::Read(_) => bad_surface(SOURCE, Hint::None),
        PlanError::Stock { .. } | PlanError::OpenStock => bad_surface(&["stock"], Hint::None),
        PlanError::StockTooThick { .. } => limit(&["stock", "cut.axial_depth"]),
        PlanError::Avoided { .. } => bad_surface(&["avoid"], Hint::None),
        PlanError::Surface(error) => bad_surface(surface_keys(error), Hint::Inspect),
        PlanError::Smooth(error) => of_smooth(error),
        PlanError::Reach(ReachError::Nothing { .. }) => {
            bad_surface(&["surface.rotate", "surface.file"], Hint::Inspect)
        }
        PlanError::Reach(ReachError::TooFine { .. }) => {
            bad_surface(&["cut.tolerance", "surface.steepest"], Hint::None)
        }
        PlanError::Blade { key: "hub.splitter", .. } => bad_surface(&["hub.splitter"], Hint::None),
        PlanError::Blade { key: "hub.blades", .. } => bad_surface(&["hub.blades"], Hint::None),
        PlanError::Blade { .. } => bad_surface(&["hub.blade"], Hint::None),
        PlanError::Hub(error) => of_hub(error),
        PlanError::Flatten(_) => bad_surface(SOURCE, Hint::Inspect),
        PlanError::Rings(LevelSetError::TooFine { .. }) => {
            bad_surface(&["cut.stepover", "cut.scallop"], Hint::None)
        }
        PlanError::Rings(LevelSetError::Needles { .. }) => bad_surface(SOURCE, Hint::None),
        PlanError::Rings(LevelSetError::TooSmall { .. }) => {
            bad_surface(&["surface.scale", "cut.stepover", "cut.scallop"], Hint::Inspect)
        }
        PlanError::Rings(LevelSetError::NeedsBlades) => bad_surface(&["path.pattern"], Hint::None),
        PlanError::Rings(LevelSetError::NoRoom { .. }) => limit(&["tool.diameter"]),
        PlanError::Rings(LevelSetError::NoCurve) | PlanError::CurveAway { .. } => {
            bad_surface(&["path.curve"], Hint::None)
        }
        PlanError::Rings(LevelSetError::ClosedParameter | LevelSetError::Uneven { .. }) => {
            bad_surface(&["path.angle", "path.along", "path.pattern"], Hint::None)
        }
        PlanError::Deliver(DeliverError::Locate(LocateError::BelowHorizon { .. })) => {
            bad_surface(&["surface.select", "surface.file", "machine.axes"], Hint::None)
        }
        PlanError::FarFromCentre { .. } | PlanError::FarFromOrigin { .. } => {
            bad_surface(&["surface.translate", "machine.axes", "surface.file"], Hint::None)
        }
        PlanError::Deliver(DeliverError::Outside(_))
        | PlanError::Deliver(DeliverError::Locate(LocateError::NotFinite { .. })) => BUG,
        PlanError::LimitUnreachable { .. } => {
            limit(&["force.mrr_limit", "force.relative", "force.power", "force.cutting_force"])
        }
        PlanError::TooThick { engaged, most, .. } if engaged > most => {
            limit(&["force.max_engagement"])
        }
        PlanError::TooThick { .. } => limit(&["force.min_chip"]),
        PlanError::Inaccessible { .. } => limit(&["cut.inaccessible", "tool.diameter"]),
        PlanError::FitsNowhere { .. } => limit(&["tool.diameter", "surface.select"]),
    }
}

fn of_hub(error: &HubError) -> Failure {
    match error {
        HubError::TooNarrow { .. } | HubError::NoRoom { .. } => limit(&["tool.diameter"]),
        HubError::TooNear { .. } | HubError::NoAxis { .. } => {
            limit(&["tool.holder", "tool.stickout", "tool.shank_diameter", "tool.diameter"])
        }
        HubError::NotAround { .. } | HubError::NotAlike { .. } => {
            bad_surface(&["hub.axis", "hub.origin", "hub.blades"], Hint::None)
        }
        HubError::Overlap { .. } => bad_surface(&["hub.blades", "hub.blade"], Hint::None),
        HubError::SplitterAside { .. } => bad_surface(&["hub.splitter"], Hint::None),
        _ => bad_surface(&["hub.blade", "hub"], Hint::None),
    }
}

fn of_texture(error: &TextureError) -> Failure {
    let bad_window = |keys| Failure { exit: Exit::BadJob, keys, hint: Hint::None };
    match error {
        TextureError::NoWindow | TextureError::Grid(_) => bad_window(&["texture"]),
        TextureError::WholeTooFine { .. } => bad_window(&["texture.spacing", "texture"]),
        TextureError::Still { .. } => bad_window(&["cut.spindle"]),
        TextureError::NoTime => bad_window(&[]),
        TextureError::NotCut { .. }
        | TextureError::Window(WindowError::OffSurface { .. } | WindowError::NoPass) => {
            bad_window(&["texture.at"])
        }
        TextureError::TooConcave(_) => limit(&["tool.diameter"]),
        TextureError::X3p(_) => BUG,
    }
}

fn of_smooth(error: &SmoothError) -> Failure {
    match error {
        SmoothError::Nurbs(NurbsError::TooFine { .. } | NurbsError::NotReached { .. }) => {
            bad_surface(&["surface.chord", "cut.tolerance", "surface.file"], Hint::None)
        }
        SmoothError::Step(StepError::NoSuchFace { .. }) => {
            bad_surface(&["surface.face"], Hint::None)
        }
        SmoothError::Step(StepError::TooManyTriangles { .. }) => {
            bad_surface(&["surface.face", "surface.chord"], Hint::None)
        }
        SmoothError::Step(StepError::Face { .. }) => {
            bad_surface(&["surface.face", "surface.file"], Hint::Inspect)
        }
        SmoothError::Nurbs(_) | SmoothError::Step(_) => bad_surface(SOURCE, Hint::None),
        SmoothError::Surface(error) => bad_surface(surface_keys(error), Hint::None),
    }
}

fn surface_keys(error: &SurfaceError) -> &'static [&'static str] {
    match error {
        SurfaceError::NoNormalWithin { .. } => &["surface.select.normal_within"],
        SurfaceError::NoneInBox { .. } => &["surface.select.box"],
        SurfaceError::NoSuchComponent { .. } => &["surface.select.component"],
        SurfaceError::TooFar { .. } => &["surface.scale", "surface.translate", "surface.file"],
        SurfaceError::NoFaces
        | SurfaceError::BadIndex { .. }
        | SurfaceError::NoArea { .. }
        | SurfaceError::Unusable(_)
        | SurfaceError::Topology(_) => SOURCE,
    }
}

fn of_post(error: &PostError) -> Failure {
    match error {
        PostError::Dialect(DialectError::Axes { .. }) => {
            bad_post(&["output.gcode.post", "output.gcode.post_file", "machine.axes"])
        }
        PostError::Dialect(DialectError::Coolant { .. }) => bad_post(&["cut.coolant"]),
        PostError::Dialect(DialectError::WorkOffset { .. }) => bad_post(&["machine.work_offset"]),
        PostError::Dialect(DialectError::Rotary { .. }) => {
            bad_post(&["output.gcode.post_file", "output.gcode.post", "machine.axes"])
        }
        PostError::Dialect(_) => bad_post(&["output.gcode.post_file", "output.gcode"]),
        PostError::RotaryTravel { .. } | PostError::Unreachable { .. } => {
            limit(&["machine.rotary", "machine.axes"])
        }
        PostError::Singular { .. } => limit(&["cut.tolerance", "machine.axes"]),
        PostError::Travel { axis: 'X', .. } => limit(&["machine.travel.x", "machine.travel"]),
        PostError::Travel { axis: 'Y', .. } => limit(&["machine.travel.y", "machine.travel"]),
        PostError::Travel { .. } => limit(&["machine.travel.z", "machine.travel"]),
        PostError::Empty
        | PostError::TiltedAxis { .. }
        | PostError::LowRapid { .. }
        | PostError::Feed { .. }
        | PostError::NotFinite { .. } => BUG,
    }
}
