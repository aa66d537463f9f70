//! The channels of a hub → their figures.

use crate::blisk::Blisk;
use evencut_core::hub::{ChannelFigures, ChannelLines, Passage, Shortened};
use evencut_core::job::{BladeSurface, Job, SurfaceSource};
use evencut_core::plan::{Files, PlanError, Planned, Prepared};
use evencut_core::step::{SmoothFormat, StepFile};
use evencut_core::surface::Part;
use evencut_core::tool::{Assembly, AssemblyPart};
use evencut_core::toolpath::{MoveKind, PathPoint, Toolpath};
use evencut_core::verify::{Facets, clearance};
use evencut_output::preview::{ChannelScene, Clearances, FlatLines};
use evencut_output::report::{HubFigures, MeasuredClearance, Warning};
use std::borrow::Cow;

/// Distances above this many wanted ones, and above the cutter's radius, are not measured.
const FAR: f64 = 10.0;
/// Part of the wanted distance to which the measured one is known.
const ACCURACY: f64 = 0.02;

/// The path that is simulated and drawn: of a hub that through the first channel, since the others are turned.
pub fn simulated(planned: &Planned) -> Cow<'_, Toolpath> {
    let points = &planned.toolpath.points;
    match planned.channels {
        None => Cow::Borrowed(&planned.toolpath),
        Some(_) => {
            let count = points.iter().take_while(|p| p.region == 0).count();
            Cow::Owned(Toolpath { points: points[..count].to_vec() })
        }
    }
}

/// Refuses a job of a hub whose STEP file has faces in the way of the channels that the job does not name: they would be
/// cut into.
///
/// # Errors
/// [`PlanError::Blade`] with the numbers of the faces.
pub fn refuse_unnamed(job: &Job, files: Files) -> Result<(), PlanError> {
    let (Some(hub), SurfaceSource::File(name), Some(bytes)) =
        (&job.hub, &job.surface.source, files.surface)
    else {
        return Ok(());
    };
    if SmoothFormat::from_name(name) != Some(SmoothFormat::Step) {
        return Ok(());
    }
    let named: Vec<usize> = hub.blade.iter().chain(&hub.splitter).filter_map(face).collect();
    // A file that cannot be read is refused in its place.
    let Ok(file) = StepFile::read(bytes) else { return Ok(()) };
    let Ok(looked) = file.look() else { return Ok(()) };
    let found = Blisk::find(&file, &looked).filter(|b| Some(b.hub) == hub_face(job, &file));
    let Some((missing, beside)) = found.and_then(|blisk| blisk.unnamed(&named)) else {
        return Ok(());
    };
    let numbers: Vec<String> = missing.iter().map(|face| (face + 1).to_string()).collect();
    let (faces, are) = if missing.len() == 1 { ("face", "is") } else { ("faces", "are") };
    let numbers = numbers.join(", ");
    let is_splitter = |beside| hub.splitter.iter().filter_map(face).any(|face| face == beside);
    let key = if beside.is_some_and(is_splitter) { "hub.splitter" } else { "hub.blade" };
    let what = match beside {
        Some(_) => format!(
            "{faces} {numbers} of the file {are} of the same blade or splitter, but not named: it would be cut into; name all of \
             its faces"
        ),
        None => format!(
            "{faces} {numbers} of the file {are} of a blade or splitter that is not named: it would be cut into; name it in \
             hub.splitter or hub.blade"
        ),
    };
    Err(PlanError::Blade { key, what })
}

/// The index of a face that a blade names.
fn face(item: &BladeSurface) -> Option<usize> {
    match item {
        BladeSurface::Face(number) => (*number as usize).checked_sub(1),
        BladeSurface::File(_) => None,
    }
}

/// The face that is the hub of a job.
fn hub_face(job: &Job, file: &StepFile) -> Option<usize> {
    file.choose(job.surface.face.number(), false).ok()
}

/// What is known of the channels before they are simulated.
pub fn figures(job: &Job, planned: &Planned, figures: &ChannelFigures) -> HubFigures {
    let [strips, equal] = figures.lengths;
    let (per_mm, per_s) = fastest_turn(&planned.toolpath, job.tool.radius());
    HubFigures {
        channels: figures.channels as u64,
        spacing: figures.spacing.name().into(),
        strips_length_mm: strips,
        equal_parameter_length_mm: equal,
        map: if figures.is_harmonic { "harmonic" } else { "coons" }.into(),
        least_jacobian: figures.least_jacobian,
        edge_deviation_mm: figures.edge_deviation,
        narrowest_mm: figures.narrowest.1,
        narrowest_at_mm: figures.narrowest.0.to_array(),
        axis_turn_deg_per_mm: per_mm,
        axis_turn_deg_per_s: per_s,
        clearance_mm: job.hub.as_ref().map_or(0.0, |hub| hub.clearance),
        shortened_extensions: figures.shortened.count as u64,
        shortest_extension_mm: match figures.shortened {
            Shortened { count: 0, .. } => job.hub.as_ref().map_or(0.0, |hub| hub.extension),
            Shortened { least: (length, _), .. } => length,
        },
        retracts_in_channel: figures.retracts as u64,
        measured: None,
    }
}

/// What a reader should know of the channels before cutting.
pub fn warnings(job: &Job, figures: &ChannelFigures) -> Vec<Warning> {
    let mut all = Vec::new();
    let warning =
        |message: String, hint: &str| Warning { stage: "hub".into(), message, remedy: hint.into() };
    let Shortened { count, least: (length, at) } = figures.shortened;
    if let (Some(hub), true) = (&job.hub, count > 0) {
        let message = format!(
            "in every channel {count} extension{} of passes {} shorter than hub.extension ({:.3} mm), since the tool would \
             come too near to a blade; the shortest has {length:.3} mm, at ({:.3}, {:.3}, {:.3})",
            if count == 1 { "" } else { "s" },
            if count == 1 { "is" } else { "are" },
            hub.extension,
            at.x,
            at.y,
            at.z
        );
        all.push(warning(
            message,
            "set a smaller hub.extension, or look at the ends of the channels",
        ));
    }
    if figures.retracts > 0 {
        let message = "between the two parts of a channel beside the splitter the cutter is lifted off: no clear way \
                       was found around the splitter";
        all.push(warning(
            message.into(),
            "a smaller cutter or a larger hub.extension may have one",
        ));
    }
    all
}

/// Fastest turn of the axis on passes, degrees per mm of the way of the ball's centre, and per s.
fn fastest_turn(path: &Toolpath, radius: f64) -> (f64, f64) {
    let turn = |w: &[PathPoint]| {
        let centre = |p: &PathPoint| p.tip + p.axis * radius;
        let length = centre(&w[1]).distance(centre(&w[0]));
        let angle = w[0].axis.distance(w[1].axis).to_degrees();
        (
            angle / length.max(f64::MIN_POSITIVE),
            angle / (w[1].time - w[0].time).max(f64::MIN_POSITIVE),
        )
    };
    let cuts =
        path.points.windows(2).filter(|w| w[1].kind == MoveKind::Cut && w[0].kind == MoveKind::Cut);
    cuts.map(turn)
        .fold((0.0, 0.0), |most, turn| (f64::max(most.0, turn.0), f64::max(most.1, turn.1)))
}

/// The lines of the channel in the flat map; none without a hub.
pub fn lines(prepared: &Prepared) -> FlatLines {
    prepared.channel_lines().map_or_else(FlatLines::default, |ChannelLines { edges, across }| {
        FlatLines { edges, across }
    })
}

/// The channel with the hub about it and its blades. `channel`: the surface that is machined.
pub fn scene<'a>(prepared: &'a Prepared, channel: Facets<'a>) -> Option<ChannelScene<'a>> {
    let (hub, blades) = (facets(prepared.hub_about()?), facets(prepared.passage()?.blades()));
    Some(ChannelScene { channel, hub, blades })
}

fn facets(part: &Part) -> Facets<'_> {
    Facets { positions: &part.positions, faces: &part.faces }
}

/// What stands beside a channel, and the tool that must stay away from it.
#[derive(Clone, Debug)]
pub struct Beside {
    /// The blades.
    pub blades: Part,
    /// The blades and the hub about the channel.
    pub all: Part,
    /// The tool.
    pub assembly: Assembly,
    /// The distance that is wanted, mm.
    pub wanted: f64,
}

impl Beside {
    /// That of a job of a hub.
    pub fn of(job: &Job, passage: &Passage, all: &Part) -> Option<Self> {
        let wanted = job.hub.as_ref()?.clearance;
        let (blades, assembly) = (passage.blades().clone(), job.assembly.clone());
        Some(Self { blades, all: all.clone(), assembly, wanted })
    }
}

/// Distances of the tool from what stands beside the channel, measured on the path of a plan: in short, and along it.
pub fn measured(
    job: &Job,
    planned: &Planned,
    threads: usize,
) -> Option<(MeasuredClearance, Clearances)> {
    let beside = Beside::of(job, planned.prepared.passage()?, &planned.prepared.rest)?;
    measured_on(&simulated(planned), &beside, threads)
}

/// The same of any path.
pub fn measured_on(
    path: &Toolpath,
    beside: &Beside,
    threads: usize,
) -> Option<(MeasuredClearance, Clearances)> {
    let Beside { blades, all, assembly, wanted } = beside;
    let wanted = *wanted;
    let beyond = (FAR * wanted).max(assembly.tool.radius());
    let accuracy = ACCURACY * wanted;
    let of = |part: &Part| clearance(path, facets(part), assembly, beyond, accuracy, threads);
    // The cutter touches the hub; what is above it must not.
    let (blades, all) = (of(blades)?, of(all)?);
    let [cutter, _, _] = blades.by_part;
    let [_, shank, holder] = all.by_part;
    let cutter_mm = cutter.unwrap_or(beyond);
    let [of_cutter, ..] = blades.at_by_part;
    let [_, of_shank, of_holder] = all.at_by_part;
    let mut nearest = (cutter_mm, of_cutter, AssemblyPart::Cutter);
    for (distance, at, part) in
        [(shank, of_shank, AssemblyPart::Shank), (holder, of_holder, AssemblyPart::Holder)]
    {
        if let Some(distance) = distance.filter(|d| *d < nearest.0) {
            nearest = (distance, at, part);
        }
    }
    let (_, at, part) = nearest;
    let least = |([cutter, ..], [_, shank, holder]): (&[f64; 3], &[f64; 3])| {
        cutter.min(*shank).min(*holder)
    };
    let along = Clearances {
        time: path.points.iter().map(|p| p.time).collect(),
        distance: blades.along.iter().zip(&all.along).map(least).collect(),
        wanted,
        beyond,
    };
    let figures = MeasuredClearance {
        cutter_mm,
        shank_mm: shank,
        holder_mm: holder,
        at_mm: at.to_array(),
        part: part.name().into(),
    };
    Some((figures, along))
}
