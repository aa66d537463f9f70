//! Why a job cannot be planned.

use crate::flatten::FlattenError;
use crate::geometry::DVec3;
use crate::hub::HubError;
use crate::level_set::LevelSetError;
use crate::link::DeliverError;
use crate::mesh::ReadError;
use crate::reach::ReachError;
use crate::step::SmoothError;
use crate::surface::SurfaceError;
use crate::units::per_minute;
use thiserror::Error;

/// A shift that undoes another, never a negative zero.
fn back(x: f64) -> f64 {
    0.0 - x.round()
}

/// Farthest distance of a part from the rotary centre, in diagonals of its box.
pub(super) const FARTHEST: f64 = 20.0;
/// If a move would have to be slower than this fraction of the feed, the limit cannot be kept.
pub(super) const SLOWEST: f64 = 0.005;

/// Why a job cannot be planned.
#[derive(Debug, Error)]
pub enum PlanError {
    /// A file was not given.
    #[error("surface: the job names the file {0:?}, but it was not given")]
    NoFile(String),
    /// The file name has no known extension.
    #[error(
        "surface: the format of {0:?} is not known; its name must end in .stl, .obj, \
         .ply, .off, .json, .step or .stp"
    )]
    UnknownFormat(String),
    /// The file cannot be read.
    #[error(transparent)]
    Read(#[from] ReadError),
    /// A mesh to stay away from is not usable.
    #[error("avoid: {file}: {}", without_subject(.error))]
    Avoided {
        /// Index of its table.
        index: usize,
        /// Its file.
        file: String,
        /// Why.
        error: Box<PlanError>,
    },
    /// The mesh of the material is not usable.
    #[error("stock: {file}: {}", without_subject(.error))]
    Stock {
        /// Its file.
        file: String,
        /// Why.
        error: Box<PlanError>,
    },
    /// The mesh of the material encloses nothing.
    #[error(
        "stock: the mesh has openings, so that it encloses no material; give a closed one, or a `box`"
    )]
    OpenStock,
    /// The material is too thick over the surface.
    #[error(
        "stock: at ({:.2}, {:.2}, {:.2}) it reaches {thickness:.3} mm above the surface; cut.allowance and cut.axial_depth \
         together are {allowed:.3} mm: rough it down to that first, or give a greater cut.axial_depth",
        place.x, place.y, place.z
    )]
    StockTooThick {
        /// Where on the surface, mm.
        place: DVec3,
        /// How far it reaches from there: along the normal, up, or toward its nearest face, whichever is the least, mm.
        thickness: f64,
        /// How thick it may be, mm.
        allowed: f64,
    },
    /// The NURBS surface or the STEP file cannot be used.
    #[error(transparent)]
    Smooth(#[from] SmoothError),
    /// The triangles are not a usable surface.
    #[error(transparent)]
    Surface(#[from] SurfaceError),
    /// A surface of a blade cannot be used.
    #[error("hub: {key}: {what}")]
    Blade {
        /// The key that names it.
        key: &'static str,
        /// What is wrong with it.
        what: String,
    },
    /// The channels of a hub cannot be planned.
    #[error(transparent)]
    Hub(Box<HubError>),
    /// Nothing of the part can be reached.
    #[error(transparent)]
    Reach(#[from] ReachError),
    /// Nothing is left for rest finishing.
    #[error(
        "rest: the operations before leave less than {:.1} µm above the allowance everywhere, which is what cusps may have: \
         there is no rest, and nothing is cut",
        1e3 * limit
    )]
    NoRest {
        /// Height from which on it is rest, mm.
        limit: f64,
    },
    /// What is left for rest finishing holds no pass.
    #[error(
        "rest: what the operations before leave higher than {:.1} µm above the allowance stands in spots too narrow for a \
         pass: it stays; choose a smaller cut.stepover or cut.scallop, or plan an operation without `rest`",
        1e3 * limit
    )]
    RestTooNarrow {
        /// Height from which on it is rest, mm.
        limit: f64,
    },
    /// The surface cannot be flattened.
    #[error(transparent)]
    Flatten(#[from] FlattenError),
    /// No passes can be laid out.
    #[error(transparent)]
    Rings(#[from] LevelSetError),
    /// The path cannot be delivered.
    #[error(transparent)]
    Deliver(#[from] DeliverError),
    /// The part lies outside the range of any machine.
    #[error(
        "machine: the middle of the part lies {:.0} m from the origin, farther than any machine goes: \
         set surface.translate = [{:.0}, {:.0}, {:.0}]",
        1e-3 * distance, back(middle.x), back(middle.y), back(middle.z)
    )]
    FarFromOrigin {
        /// Middle of the bounding box, mm.
        middle: DVec3,
        /// Its distance from the origin, mm.
        distance: f64,
    },
    /// The start curve lies far from the surface.
    #[error(
        "passes: point {number} of path.curve, ({:.3}, {:.3}, {:.3}) mm, lies {distance:.0} mm from the surface, \
         which measures {size:.0} mm: give points on the surface, in the job's units and after \
         surface.rotate and surface.translate",
        point.x, point.y, point.z
    )]
    CurveAway {
        /// The point, mm.
        point: DVec3,
        /// Its number, from 1.
        number: usize,
        /// Its distance from the bounding box, mm.
        distance: f64,
        /// Diagonal of that, mm.
        size: f64,
    },
    /// The part lies too far from the rotary centre for five axes.
    #[error(
        "machine: the middle of the part lies {distance:.0} mm from the rotary centre (the origin), \
         {times:.0} times its own size; at most {FARTHEST} times can be turned within the tolerance: \
         set surface.translate = [{:.0}, {:.0}, {:.0}]",
        back(middle.x), back(middle.y), back(middle.z)
    )]
    FarFromCentre {
        /// Middle of the bounding box, mm.
        middle: DVec3,
        /// Its distance from the origin, mm.
        distance: f64,
        /// The distance as a multiple of the box's diagonal.
        times: f64,
    },
    /// The limit on the removal rate cannot be kept.
    #[error(
        "force: near ({:.3}, {:.3}, {:.3}) mm the limit of {:.2} mm³/min, be it on rate, power or force, leaves a feed of \
         {:.3} mm/min where the full feed would remove {:.1} mm³/min; less than {} % of cut.feed is not planned: raise \
         the limit ([force]), or reduce cut.axial_depth, or cut.scallop or cut.stepover",
        place.x, place.y, place.z, per_minute(*left), per_minute(*feed), per_minute(*rate), 100.0 * SLOWEST
    )]
    LimitUnreachable {
        /// Where, mm.
        place: DVec3,
        /// Rate at the nominal feed, mm³/s.
        rate: f64,
        /// Rate that the limits leave there, mm³/s.
        left: f64,
        /// The feed it would take, mm/s.
        feed: f64,
    },
    /// The cutter is engaged too far, or would have to go too slowly.
    #[error(
        "force: near ({:.3}, {:.3}, {:.3}) mm {}; {remedy}",
        place.x, place.y, place.z,
        thickness(*engaged, *most, *per_tooth, *least),
    )]
    TooThick {
        /// Where, mm.
        place: DVec3,
        /// Angle of engagement there, rad.
        engaged: f64,
        /// Its limit, rad.
        most: f64,
        /// Feed per tooth there, mm.
        per_tooth: f64,
        /// Its limit, mm.
        least: f64,
        /// What was tried, and what may help this job.
        remedy: String,
    },
    /// The cutter does not fit and the job does not allow lifting it.
    #[error(
        "cutter: it does not fit near ({:.3}, {:.3}, {:.3}) mm, where it would have to be lifted by {raise:.3} mm \
         ({spans} span{}, {length:.1} mm of path); use a smaller cutter or cut.inaccessible = \"lift\"",
        place.x, place.y, place.z, if *spans == 1 { "" } else { "s" }
    )]
    Inaccessible {
        /// Worst place, mm.
        place: DVec3,
        /// Raise there, mm.
        raise: f64,
        /// Number of spans.
        spans: usize,
        /// Their length, mm.
        length: f64,
    },
    /// The cutter can touch the surface nowhere.
    #[error(
        "cutter: it fits nowhere on this surface: even at ({:.3}, {:.3}, {:.3}) mm the part or its walls keep it \
         {raise:.3} mm too high; use a smaller cutter, or select what it can reach (surface.select)",
        place.x, place.y, place.z
    )]
    FitsNowhere {
        /// The place where it comes lowest, mm.
        place: DVec3,
        /// Raise there, mm.
        raise: f64,
    },
}

/// Which of the limits on engagement and feed per tooth is broken.
fn thickness(engaged: f64, most: f64, per_tooth: f64, least: f64) -> String {
    if engaged > most {
        format!(
            "the cutter is engaged over {:.1} degrees, more than force.max_engagement, {:.1}",
            engaged.to_degrees(),
            most.to_degrees()
        )
    } else {
        format!("the feed is {per_tooth:.5} mm per tooth, less than force.min_chip, {least:.5}")
    }
}

/// The message of an error without its subject.
fn without_subject(error: &PlanError) -> String {
    let whole = error.to_string();
    match whole.split_once(": ") {
        Some((subject, rest)) if !subject.contains(' ') => rest.to_owned(),
        _ => whole,
    }
}

impl From<HubError> for PlanError {
    fn from(error: HubError) -> Self {
        Self::Hub(Box::new(error))
    }
}
