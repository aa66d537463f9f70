//! The pipeline: a job and file contents in, a path and its figures out, one stage after the other.

mod delivery;
mod error;
mod load;
mod plane;
mod tilt;

use crate::cutter_location::{CheckMesh, LiftedSpan};
use crate::flat_path::FlatPoint;
use crate::flatten::{Chart, FlattenError, Locator, Quality, abf, bff};
use crate::geometry::DVec3;
use crate::job::{Boundary, Division, FlattenMethod, Job, Pattern, Start, Stepover};
use crate::level_set::{ClosingReport, PassMesh, StripMetric};
use crate::lift::Lift;
use crate::link::Deliverer;
use crate::machine::Axes;
use crate::machine_time::fill_time;
use crate::mesh::{FaceId, VertexId};
use crate::outline::Outline;
use crate::pattern;
use crate::regions::tensor::{self, Topology};
use crate::regions::{self, Divided, LayoutOptions, RegionMesh, Regions, Undivided};
use crate::removal::{self, Coverage};
use crate::strips::{Strips, part_of_strip, strip};
use crate::surface::{Built, CurvatureField, Part, Surface, Warning};
use crate::toolpath::Toolpath;
use crate::walls::Clearance;
use core::cell::OnceCell;
use delivery::{Delivery, Finished, deliver_options, rapid_plane};
use error::FARTHEST;
pub use error::PlanError;
pub use load::Files;
pub use load::{load, load_beside};
use plane::{FlatCut, Plane, centring};
use tilt::{axis_rule, tilted};

/// Fraction of the tolerance by which the polylines of rings may deviate from the level curve.
const RING_TOLERANCE: f64 = 0.25;
/// Farthest distance of a part from the origin, mm: half of the largest coordinate that is read back from a program.
const LONGEST_TRAVEL: f64 = 5e5;

/// Farthest distance of a point of a start curve from the surface's bounding box, in diagonals of the box.
const CURVE_AWAY: f64 = 0.25;

/// The steps of the pipeline that take time.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum Stage {
    /// Reading and checking the surface.
    Surface,
    /// Flattening it.
    Flatten,
    /// Distance field and rings.
    Rings,
    /// Cutting in the plane, with force control and, for comparison, without.
    Cut,
    /// Mapping onto the surface, locating the cutter, joining.
    Locate,
    /// Simulating the path to verify it.
    Verify,
    /// Simulating the texture of the job's window.
    Texture,
    /// Writing program, tables, pictures and report.
    Write,
}

/// A plan and what is known about it.
#[derive(Debug)]
pub struct Planned {
    /// The surface.
    pub surface: Surface,
    /// Warnings about it.
    pub warnings: Vec<Warning>,
    /// Its flat image.
    pub chart: Chart,
    /// How conformal the map is.
    pub quality: Quality,
    /// Constraint residual and steps of the angle-based map.
    pub angle_residual: Option<(f64, usize)>,
    /// Shortest length that passes on the surface can have, mm.
    pub length_floor: f64,
    /// Share of the area on which passes are at least 0.9 of the allowed side step apart.
    pub even_share: f64,
    /// The regions; `None` for an undivided surface.
    pub divided: Option<Divided>,
    /// Where the best feed direction is undefined, if the surface is divided by it.
    pub topology: Option<Topology>,
    /// Number of passes.
    pub passes: usize,
    /// The gaps between passes that were closed; places are flat.
    pub closing: ClosingReport,
    /// Number of rings in the longest chain of nested rings.
    pub ring_depth: usize,
    /// The delivered path.
    pub toolpath: Toolpath,
    /// The path of the plain passes, where the removal rate is limited.
    pub plain: Option<Toolpath>,
    /// Trochoid loops.
    pub loops: usize,
    /// Where the cutter had to be lifted.
    pub lifted: Vec<LiftedSpan>,
    /// What the path leaves uncut.
    pub coverage: Coverage,
    /// Facets of the part that are not machined, and of the mesh beside the surface.
    pub rest: Part,
    /// Height of the cusps that are meant to stay, mm: the job's limit, or the largest that the side step leaves.
    pub cusp_limit: f64,
    /// Height of the rapids, mm.
    pub rapid_plane: f64,
    /// The most concave place; `None` where nothing is concave.
    pub tightest: Option<Tightest>,
}

/// The most concave place of a surface, and how much of it is too concave for the cutter.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Tightest {
    /// Smallest concave radius of curvature, mm.
    pub radius: f64,
    /// Where, mm.
    pub place: DVec3,
    /// Area that is more concave than the cutter is convex, mm²: the cutter does not fit there.
    pub too_concave: f64,
}

impl Tightest {
    /// `None` where nothing is concave.
    fn of(job: &Job, surface: &Surface, curvature: &CurvatureField) -> Option<Self> {
        let k_min = |i: usize| curvature.operators()[i].principal().0;
        let count = surface.positions().len();
        let vertex = (0..count).min_by(|&a, &b| k_min(a).total_cmp(&k_min(b)))?;
        let k = k_min(vertex);
        let k_tool = strip(job, job.cut.tolerance).k_tool();
        let too_concave = |face: &[VertexId; 3]| face.map(|v| k_min(v.index()) < -k_tool);
        let area = |f: usize, face: &[VertexId; 3]| {
            let [a, b, c] = surface.corners(FaceId(f as u32));
            let share = too_concave(face).iter().filter(|&&is| is).count() as f64 / 3.0;
            0.5 * (b - a).cross(c - a).length() * share
        };
        let faces = surface.connectivity().faces().iter().enumerate();
        let too_concave = faces.map(|(f, face)| area(f, face)).fold(0.0, |sum, a| sum + a);
        let place = surface.positions()[vertex];
        (k < 0.0).then_some(Self { radius: -1.0 / k, place, too_concave })
    }
}

/// Plans a job. `files`: the contents of the files that it names; `threads`: number of threads, on which the result
/// does not depend.
///
/// `progress` is called with the stage and the fraction of it that is done.
///
/// # Errors
/// [`PlanError`]: what cannot be planned, where, and what to change.
pub fn plan(
    job: &Job,
    files: Files,
    threads: usize,
    progress: &mut dyn FnMut(Stage, f64),
) -> Result<Planned, PlanError> {
    plan_showing(job, files, threads, progress, &mut |_| {})
}

/// The surface of a job and its flat map, without a plan. `files`: as for [`plan`].
///
/// # Errors
/// [`PlanError`]: a surface that cannot be read or flattened.
pub fn laid_flat(job: &Job, files: Files) -> Result<(Surface, Chart), PlanError> {
    let surface = load(job, files)?.surface;
    let (chart, _) = flatten(job, &surface)?;
    Ok((surface, chart))
}

/// A path before it is delivered: without cutter locations and final feeds, and without the extra passes over places
/// where the cutter did not fit.
#[derive(Copy, Clone, Debug)]
pub struct Sketch<'a> {
    /// The surface.
    pub surface: &'a Surface,
    /// Its flat image.
    pub chart: &'a Chart,
    /// The path in the flat plane.
    pub points: &'a [FlatPoint],
    /// Whether its removal rates are known: those of the disc model in the plane.
    pub is_rated: bool,
}

/// As [`plan`]; `sketched` is called once with the path before it is delivered, since delivery takes most of the
/// time.
///
/// # Errors
/// As [`plan`].
pub fn plan_showing(
    job: &Job,
    files: Files,
    threads: usize,
    progress: &mut dyn FnMut(Stage, f64),
    sketched: &mut dyn FnMut(Sketch),
) -> Result<Planned, PlanError> {
    progress(Stage::Surface, 0.0);
    let Built { surface, part, warnings, .. } = load(job, files)?;
    let beside = load_beside(job, files)?;
    refuse_too_far(job, &part)?;
    refuse_curve_away(job, &surface)?;
    progress(Stage::Flatten, 0.0);
    let (chart, angle_residual) = flatten(job, &surface)?;
    let quality = chart.quality(&surface);
    progress(Stage::Rings, 0.0);
    let curvature = surface.curvature(job.surface.curvature_radius);
    let tightest = Tightest::of(job, &surface, &curvature);
    let Strips { metrics, creases } = Strips::of(job, &surface, &chart, &curvature);
    let locator = Locator::new(surface.connectivity(), chart.uv());
    let (regions, topology) =
        division(job, &surface, (&chart, &locator), &curvature, &metrics, threads)?;
    let undivided = regions.as_ref().map(|r| Undivided::of(r, &surface, &chart, &metrics));
    let region_meshes =
        regions::region_meshes(regions.as_ref(), &surface, &chart, metrics, threads)?;
    let floor = region_meshes.iter().map(RegionMesh::length_floor).sum::<f64>() / creases;
    let fine: Vec<Locator> = region_meshes.iter().map(RegionMesh::locator).collect();
    let mut rest = part.without(&surface);
    let walls = delivery::walls(job, &surface, &rest, beside.as_ref());
    if let Some(beside) = &beside {
        rest.add(beside);
    }
    let options = deliver_options(job, rapid_plane(&part, walls.corners(), job), threads);
    let obstacles = walls.obstacles(CheckMesh::new(part.positions, part.faces));
    let clearance =
        Clearance { surface: &surface, chart: &locator, obstacles: &obstacles, pass: options.pass };
    let tolerance = ring_tolerance(job, &chart);
    let layout_options = LayoutOptions {
        job,
        surface: &surface,
        chart: &locator,
        tolerance,
        tilted: tilted(job),
        // What stands on an open surface is no place to begin from.
        clearance: (job.path.boundary == Boundary::Wall).then_some(clearance),
        threads,
    };
    let layouts = regions::lay_out(&region_meshes, &fine, &layout_options)?;
    let place = |at| locator.locate(at).ok().map(|p| surface.position(p));
    let order = regions::in_order(regions.as_ref(), &layouts, job.regions.order, place);
    let region = Outline::of_chart(&surface, &chart);
    let plane = Plane {
        job,
        region_meshes: &region_meshes,
        layouts: &layouts,
        fine: &fine,
        region: &region,
        centring: centring(job, &surface, (&chart, &locator), &curvature),
    };
    let lift = Lift::new(&surface, &chart, &locator, job.tool.radius());
    let lift = lift.going_far(tilted(job).is_some());
    let delivery = Delivery {
        job,
        surface: &surface,
        chart: &chart,
        locator: &locator,
        deliverer: Deliverer { lift: &lift, obstacles: &obstacles, options },
        cusp_limit: cusp_limit(job, &surface, &curvature),
        columns: OnceCell::new(),
    };
    progress(Stage::Cut, 0.0);
    let (cut, plain) = cut(&plane, &delivery, &order, |p| progress(Stage::Cut, p))?;
    sketched(Sketch {
        surface: &surface,
        chart: &chart,
        points: &cut.points,
        is_rated: cut.is_rated,
    });
    progress(Stage::Locate, 0.0);
    let finished = delivery.finished(&cut.points, &mut |p| progress(Stage::Locate, p))?;
    let Finished { mut toolpath, lifted, coverage, .. } = finished;
    fill_time(&mut toolpath, &job.tool, &job.machine);
    Ok(Planned {
        rest,
        coverage,
        cusp_limit: delivery.cusp_limit,
        length_floor: floor * part_of_strip(job),
        even_share: regions::even_share(&region_meshes, &layouts),
        divided: regions
            .zip(undivided)
            .map(|(r, undivided)| Divided::of(r, order, &region_meshes, &layouts, undivided)),
        topology,
        closing: ClosingReport::joined(layouts.iter().map(|l| l.closing.clone())),
        ring_depth: layouts.iter().map(|l| l.depth).max().unwrap_or(0),
        passes: layouts.iter().map(|l| l.passes.len()).sum(),
        warnings,
        quality,
        angle_residual,
        toolpath,
        plain,
        loops: cut.loops,
        lifted,
        rapid_plane: options.rapid_plane,
        tightest,
        surface,
        chart,
    })
}

/// The flat path, and that of the plain passes on the part where the removal rate is limited. Plain passes that keep
/// to the limit are the path themselves.
fn cut(
    plane: &Plane,
    delivery: &Delivery,
    order: &[usize],
    progress: impl FnMut(f64),
) -> Result<(FlatCut, Option<Toolpath>), PlanError> {
    let laid = plane.laid(order);
    let plain = delivery.plain(&laid.points)?;
    let excess = plain.as_ref().filter(|_| plane.is_walked()).map(|path| plane.excess(path));
    let cut = match excess.filter(|excess| !excess.is_empty()) {
        Some(excess) => plane.cut(order, &excess, progress),
        None => laid,
    };
    Ok((cut, plain))
}

type AngleResidual = Option<(f64, usize)>;

fn flatten(job: &Job, surface: &Surface) -> Result<(Chart, AngleResidual), FlattenError> {
    match job.flatten {
        FlattenMethod::Bff => Ok((bff(surface)?, None)),
        FlattenMethod::Abf => {
            let map = abf(surface)?;
            Ok((map.chart, Some((map.residual, map.steps))))
        }
    }
}

/// How far the flat polylines of passes may deviate from the level curves, flat mm.
fn ring_tolerance(job: &Job, chart: &Chart) -> f64 {
    let largest = chart.vertex_scale().iter().copied().fold(0.0, f64::max);
    // Pass 0 of an open boundary stays clear of it.
    let tolerance = (RING_TOLERANCE * job.cut.tolerance).min(0.005 * job.nominal_side_step());
    tolerance / largest
}

/// The regions, and where the best feed direction is undefined, if they are divided by it.
fn division(
    job: &Job,
    surface: &Surface,
    (chart, locator): (&Chart, &Locator),
    curvature: &CurvatureField,
    metrics: &[StripMetric],
    threads: usize,
) -> Result<(Option<Regions>, Option<Topology>), PlanError> {
    let mut topology = topology(job, surface, (chart, locator), curvature);
    let regions = match job.path.pattern {
        Pattern::Mpf => Some(banded(job, surface, chart, metrics.to_vec())?),
        _ => divided(job, surface, chart, topology.as_ref(), threads)?,
    };
    if let (Some(topology), Some(regions)) = (&mut topology, &regions) {
        // What was too small may have been joined again.
        topology.points.iter_mut().for_each(|p| p.divides &= regions.is_at_border(p.at.face));
    }
    Ok((regions, topology))
}

/// The regions that the job specifies; `None` for a single one.
fn divided(
    job: &Job,
    surface: &Surface,
    chart: &Chart,
    topology: Option<&Topology>,
    threads: usize,
) -> Result<Option<Regions>, FlattenError> {
    let least = job.regions.min_area;
    match &job.regions.division {
        Division::Single => Ok(None),
        Division::Tensor(_) => {
            let cuts = topology.map_or_else(Vec::new, Topology::cuts);
            Regions::along(surface, chart, &cuts, least).map(Some)
        }
        Division::Distortion(options) => {
            Regions::even(surface, chart, options, least, threads).map(Some)
        }
    }
}

/// The regions that are bands of a machining potential field.
fn banded(
    job: &Job,
    surface: &Surface,
    chart: &Chart,
    metric: Vec<StripMetric>,
) -> Result<Regions, PlanError> {
    let mesh = PassMesh::coarse(surface, chart, metric)?;
    let locator = Locator::new(mesh.connectivity(), mesh.uv());
    let bands = pattern::bands(&mesh, &locator);
    let regions = Regions::along(surface, chart, &bands.cuts, job.regions.min_area)?;
    Ok(regions.with_starts(&bands.starts))
}

/// The topology of the best feed direction, for jobs that divide by it.
fn topology(
    job: &Job,
    surface: &Surface,
    (chart, locator): (&Chart, &Locator),
    curvature: &CurvatureField,
) -> Option<Topology> {
    let Division::Tensor(options) = &job.regions.division else { return None };
    // The height of the cusps has no part in the directions.
    let k_tool = strip(job, 1.0).k_tool();
    Some(tensor::topology(surface, (chart, locator), curvature, k_tool, options).0)
}

/// Height of the cusps that a job allows on a surface, mm: its limit, or the largest that its side step leaves.
pub fn cusp_limit(job: &Job, surface: &Surface, curvature: &CurvatureField) -> f64 {
    let axis = axis_rule(job);
    match job.cut.stepover {
        Stepover::Scallop(h) => h,
        Stepover::Fixed(d) => removal::worst_cusp(&job.tool, axis, surface, curvature, d),
    }
}

fn refuse_too_far(job: &Job, part: &Part) -> Result<(), PlanError> {
    let (low, high) = part
        .positions
        .iter()
        .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(l, h), &p| (l.min(p), h.max(p)));
    let middle = 0.5 * (low + high);
    let (distance, times) = (middle.length(), middle.length() / (high - low).length());
    if distance > LONGEST_TRAVEL {
        return Err(PlanError::FarFromOrigin { middle, distance });
    }
    if job.machine.axes != Axes::ThreeAxis && times > FARTHEST {
        return Err(PlanError::FarFromCentre { middle, distance, times });
    }
    Ok(())
}

/// Points of a start curve are moved to the nearest place of the surface; points far away are a mistake.
fn refuse_curve_away(job: &Job, surface: &Surface) -> Result<(), PlanError> {
    let Start::Curve(points) = &job.path.start else { return Ok(()) };
    let places = surface.positions().iter();
    let (low, high) =
        places.fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(l, h), &p| (l.min(p), h.max(p)));
    let size = (high - low).length();
    for (&point, number) in points.iter().zip(1..) {
        let distance = point.distance(point.clamp(low, high));
        if distance > CURVE_AWAY * size {
            return Err(PlanError::CurveAway { point, number, distance, size });
        }
    }
    Ok(())
}
