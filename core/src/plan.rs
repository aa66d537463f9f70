//! The pipeline: job and bytes in, path and measures out, a line per stage.

use crate::centring::Centring;
use crate::cutter_location::{CheckMesh, PassOptions, RaisedStretch, ToolAxis};
use crate::engagement::{Cutting, Stock, Walk};
use crate::feed::fill_time;
use crate::flat_path::{FlatPoint, Terrain};
use crate::flatten::{Chart, FlattenError, Locator, Quality, abf, bff};
use crate::geometry::DVec3;
use crate::job::{
    AnalyticKind, AnalyticOptions, AnalyticParameters, Boundary, CutDirection, Division,
    FlattenMethod, ForceControl, Job, Pattern, Stepover, SurfaceSource, TooTight,
};
use crate::level_set::{ClosingReport, FieldTerrain, LevelSetError, PassMesh, StripMetric};
use crate::link::{
    self, CutCounts, CutOptions, DeliverError, DeliverOptions, Delivered, Group, LayOptions,
    TouchUp, cut_passes, deliver, lay,
};
use crate::machine::Axes;
use crate::mending::{MendOptions, Mender};
use crate::mesh::{FaceId, MeshFormat, ReadError, VertexId, read};
use crate::parallel;
use crate::pattern;
use crate::region::Region;
use crate::regions::tensor::{self, Topology};
use crate::regions::{self, Divided, Ground, JointTerrain, LayoutOptions, Regions, Undivided};
use crate::removal::{self, Access, Columns, Coverage, Feeds, Layer, Limit, TooSlow, rated};
use crate::step::{SmoothError, SmoothFormat, smooth};
use crate::strip_width::Strip;
use crate::strips::{Strips, part_of_strip, strip};
use crate::surface::{
    AnalyticSurface, Built, CurvatureField, Part, Surface, SurfaceError, Warning, build,
};
use crate::tool::ToolKind;
use crate::toolpath::{MoveKind, Toolpath};
use crate::trochoid::Loops;
use thiserror::Error;

/// Part of the tolerance that ring polylines may deviate from the level curve.
const RING_TOLERANCE: f64 = 0.25;
/// Part of the tolerance that the mesh of a NURBS surface may be off it.
const CHORD: f64 = 0.25;
/// Rounds of passes over what the columns show as left.
const TOUCH_UPS: usize = 2;
/// Farthest distance of a part from the rotary centre, in diagonals of its box.
const FARTHEST: f64 = 20.0;
/// A move that would have to be slower than this part of the feed means that the limit cannot be
/// kept.
const SLOWEST: f64 = 0.005;

/// Rounds of detours over what is too high. More: what is left cannot be reached.
const MENDS: usize = 3;
/// Part of the tolerance above the limit from which on a place is too high: samples may miss the highest.
const MENDED: f64 = 0.8;
/// Largest distance of the points of centred passes, side steps.
const CENTRED: f64 = 0.25;

/// Side steps that the disc's radius covers at least: neighbouring discs overlap by a tenth.
const COVERING: f64 = 0.55;

/// Why a job cannot be planned.
#[derive(Debug, Error)]
pub enum PlanError {
    /// The surface file was not given.
    #[error("surface: the job names the file {0:?}, but it was not given")]
    NoFile(String),
    /// The file name does not tell a known format.
    #[error(
        "surface: the format of {0:?} is not known; its name must end in .stl, .obj, \
         .ply, .off, .json, .step or .stp"
    )]
    UnknownFormat(String),
    /// The file cannot be read.
    #[error(transparent)]
    Read(#[from] ReadError),
    /// The NURBS surface or the STEP file cannot be used.
    #[error(transparent)]
    Smooth(#[from] SmoothError),
    /// The triangles are no usable surface.
    #[error(transparent)]
    Surface(#[from] SurfaceError),
    /// The surface cannot be laid flat.
    #[error(transparent)]
    Flatten(#[from] FlattenError),
    /// No rings can be laid.
    #[error(transparent)]
    Rings(#[from] LevelSetError),
    /// The path cannot be delivered.
    #[error(transparent)]
    Deliver(#[from] DeliverError),
    /// The part lies too far from the rotary centre for five axes.
    #[error(
        "machine: the middle of the part lies {distance:.0} mm from the rotary centre (the origin), \
         {times:.0} times its own size; at most {FARTHEST} times can be turned within the tolerance: \
         set surface.translate = [{:.0}, {:.0}, {:.0}]",
        -middle.x, -middle.y, -middle.z
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
        "force: near ({:.3}, {:.3}, {:.3}) mm the limit of {:.2} mm³/min leaves a feed of {:.3} mm/min, \
         {:.1} mm³/min at the full feed; a feed below {} % of cut.feed is not planned: raise \
         force.mrr_limit, or reduce cut.axial_depth or cut.stepover",
        place.x, place.y, place.z, 60.0 * limit, 60.0 * feed, 60.0 * rate, 100.0 * SLOWEST
    )]
    LimitUnreachable {
        /// Where, mm.
        place: DVec3,
        /// Rate at the nominal feed, mm³/s.
        rate: f64,
        /// The feed it would take, mm/s.
        feed: f64,
        /// The limit, mm³/s.
        limit: f64,
    },
    /// The cutter does not fit and the job says to refuse.
    #[error(
        "cutter: it does not fit near ({:.3}, {:.3}, {:.3}) mm, where it would have to be raised by {raise:.3} mm \
         ({stretches} stretch{}, {length:.1} mm of path); use a smaller cutter or cut.too_tight = \"avoid\"",
        place.x, place.y, place.z, if *stretches == 1 { "" } else { "es" }
    )]
    TooTight {
        /// Worst place, mm.
        place: DVec3,
        /// Raise there, mm.
        raise: f64,
        /// Number of stretches.
        stretches: usize,
        /// Their length, mm.
        length: f64,
    },
}

/// The steps of the pipeline that take time.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum Stage {
    /// Reading and checking the surface.
    Surface,
    /// Laying it flat.
    Flatten,
    /// Distance field and rings.
    Rings,
    /// Cutting, with force control and, for comparison, without.
    Cut,
    /// Lifting, locating, joining.
    Locate,
    /// Simulating the path to judge it.
    Verify,
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
    /// How conformal that is.
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
    /// The gaps between them that were closed; places are flat.
    pub closing: ClosingReport,
    /// Rings on the longest chain of rings inside each other.
    pub ring_depth: usize,
    /// The delivered path.
    pub toolpath: Toolpath,
    /// The path of the plain passes, where the removal rate is limited.
    pub plain: Option<Toolpath>,
    /// What was inserted.
    pub counts: CutCounts,
    /// Where the cutter had to be raised.
    pub raised: Vec<RaisedStretch>,
    /// What the path leaves.
    pub coverage: Coverage,
    /// Facets of the part that are not machined.
    pub rest: Part,
    /// Height of the cusps that are meant to stay, mm: the job's, or what the side step leaves at
    /// worst.
    pub cusp_limit: f64,
    /// Height of the rapids, mm.
    pub rapid_plane: f64,
    /// The most concave place; `None` where nothing is concave.
    pub tightest: Option<Tightest>,
}

/// Where a surface is the most concave, and how much of it is too concave for the cutter.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Tightest {
    /// Smallest concave radius of curvature, mm.
    pub radius: f64,
    /// Where, mm.
    pub place: DVec3,
    /// Area that is more concave than the cutter is convex, mm²: there it does not fit.
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

/// Plans a job. `file`: the bytes of the surface file, if the job names one; `threads`: how many to
/// use, which changes nothing but the time.
///
/// `progress` is called with the stage and the part of it that is done.
///
/// # Errors
/// [`PlanError`]: what cannot be planned, where, and what to change.
pub fn plan(
    job: &Job,
    file: Option<&[u8]>,
    threads: usize,
    progress: &mut dyn FnMut(Stage, f64),
) -> Result<Planned, PlanError> {
    plan_showing(job, file, threads, progress, &mut |_| {})
}

/// A path before it is delivered: where it runs, but not yet where the cutter stands and how fast, nor
/// what is cut again because the cutter did not fit.
#[derive(Copy, Clone, Debug)]
pub struct Sketch<'a> {
    /// The surface.
    pub surface: &'a Surface,
    /// Its flat image.
    pub chart: &'a Chart,
    /// The path in the flat plane.
    pub points: &'a [FlatPoint],
    /// Whether its removal rates are known: those of a disc in the plane.
    pub is_rated: bool,
}

/// As [`plan`], and `sketched` is called once with the path before it is delivered, which takes most of the
/// time.
///
/// # Errors
/// As [`plan`].
pub fn plan_showing(
    job: &Job,
    file: Option<&[u8]>,
    threads: usize,
    progress: &mut dyn FnMut(Stage, f64),
    sketched: &mut dyn FnMut(Sketch),
) -> Result<Planned, PlanError> {
    progress(Stage::Surface, 0.0);
    let Built { surface, part, warnings, .. } = load(job, file)?;
    refuse_too_far(job, &part)?;
    progress(Stage::Flatten, 0.0);
    let (chart, angle_residual) = flatten(job, &surface)?;
    let quality = chart.quality(&surface);
    progress(Stage::Rings, 0.0);
    let curvature = surface.curvature(job.surface.curvature_radius);
    let tightest = Tightest::of(job, &surface, &curvature);
    let Strips { metrics, creases } = Strips::of(job, &surface, &chart, &curvature);
    let locator = Locator::new(surface.connectivity(), chart.uv());
    let mut topology = topology(job, &surface, (&chart, &locator), &curvature);
    let regions = match job.path.pattern {
        Pattern::Mpf => Some(banded(job, &surface, &chart, metrics.clone())?),
        _ => divided(job, &surface, &chart, topology.as_ref(), threads)?,
    };
    if let (Some(topology), Some(regions)) = (&mut topology, &regions) {
        // What was too small may have been joined again.
        topology.points.iter_mut().for_each(|p| p.divides &= regions.is_at_border(p.at.face));
    }
    let undivided = regions.as_ref().map(|r| Undivided::of(r, &surface, &chart, &metrics));
    let grounds = regions::grounds(regions.as_ref(), &surface, &chart, metrics, threads)?;
    let floor = grounds.iter().map(Ground::length_floor).sum::<f64>() / creases;
    let fine: Vec<Locator> = grounds.iter().map(Ground::locator).collect();
    let tolerance = ring_tolerance(job, &chart);
    let options = LayoutOptions {
        job,
        surface: &surface,
        chart: &locator,
        tolerance,
        tilted: tilted(job),
        threads,
    };
    let layouts = regions::lay_out(&grounds, &fine, &options)?;
    let place = |at| locator.locate(at).ok().map(|p| surface.position(p));
    let order = regions::in_order(regions.as_ref(), &layouts, job.regions.order, place);
    let region = Region::of_chart(&surface, &chart);
    let terrain = || {
        let parts = grounds.iter().zip(&layouts).zip(&fine);
        JointTerrain::new(
            parts.map(|((g, l), fine)| FieldTerrain::new(&g.fine, &l.field, fine)).collect(),
        )
    };
    let plane = Plane { job, terrain: terrain(), region: &region };
    progress(Stage::Cut, 0.0);
    let is_walked = job.path.pattern == Pattern::Contour && job.force.control != ForceControl::Off;
    let groups: Vec<Group> = order.iter().map(|&k| layouts[k].group()).collect();
    let centring = tilted(job).map(|_| Centring {
        surface: &surface,
        chart: &chart,
        locator: &locator,
        curvature: &curvature,
        strip: centred_strip(job),
        step: CENTRED * job.nominal_side_step(),
    });
    let plain = || {
        let (points, counts) = lay(&groups, &terrain(), &lay_options(job));
        (centring.as_ref().map_or_else(|| points.clone(), |c| c.centred(&points)), counts)
    };
    let (cut, plain) = if is_walked {
        let walk = || plane.cut(&groups, |p| progress(Stage::Cut, p));
        let (cut, (plain, _)) = parallel::both(threads, walk, plain);
        (cut, Some(plain))
    } else {
        let (points, counts) = plain();
        (FlatCut { points, counts }, None)
    };
    sketched(Sketch { surface: &surface, chart: &chart, points: &cut.points, is_rated: is_walked });
    progress(Stage::Locate, 0.0);
    let rest = part.without(&surface);
    let options = deliver_options(job, rapid_plane(&part, job), threads);
    let delivery = Delivery {
        job,
        surface: &surface,
        chart: &chart,
        locator: &locator,
        lift: crate::lift::Lift::new(&surface, &chart, &locator, job.tool.radius())
            .going_far(tilted(job).is_some()),
        check: CheckMesh::new(part.positions, part.faces),
        options,
        cusp_limit: cusp_limit(job, &surface, &curvature),
        terrain: terrain(),
        threads,
    };
    let flat = at_nominal_feeds(cut.points, job);
    let on_locate = &mut |p| progress(Stage::Locate, p);
    let (finished, plain) = match job.force.control {
        ForceControl::Off => (delivery.unlimited(&flat, on_locate)?, None),
        _ => {
            let columns = delivery.columns();
            let plain = delivery.plain(&columns, plain.as_deref().unwrap_or(&flat))?;
            (delivery.limited(&columns, &flat, on_locate)?, Some(plain))
        }
    };
    let Finished { mut toolpath, raised, coverage, .. } = finished;
    fill_time(&mut toolpath, &job.tool, &job.machine);
    Ok(Planned {
        rest,
        coverage,
        cusp_limit: delivery.cusp_limit,
        length_floor: floor * part_of_strip(job),
        even_share: regions::even_share(&grounds, &layouts),
        divided: regions
            .zip(undivided)
            .map(|(r, undivided)| Divided::of(r, order, &grounds, &layouts, undivided)),
        topology,
        closing: ClosingReport::joined(layouts.iter().map(|l| l.closing.clone())),
        ring_depth: layouts.iter().map(|l| l.depth).max().unwrap_or(0),
        passes: layouts.iter().map(|l| l.passes.len()).sum(),
        warnings,
        quality,
        angle_residual,
        toolpath,
        plain,
        counts: cut.counts,
        raised,
        rapid_plane: options.rapid_plane,
        tightest,
        surface,
        chart,
    })
}

/// The surface of a job and the part it belongs to.
pub(crate) fn load(job: &Job, file: Option<&[u8]>) -> Result<Built, PlanError> {
    let soup = match &job.surface.source {
        SurfaceSource::File(name) => {
            let bytes = file.ok_or_else(|| PlanError::NoFile(name.clone()))?;
            let chord = job.surface.chord.unwrap_or(CHORD * job.cut.tolerance);
            match SmoothFormat::from_name(name) {
                Some(format) => return Ok(smooth(bytes, format, &job.surface, chord)?),
                None => {
                    let format = MeshFormat::from_name(name)
                        .ok_or_else(|| PlanError::UnknownFormat(name.clone()))?;
                    read(bytes, format)?
                }
            }
        }
        SurfaceSource::Analytic(options) => {
            analytic_surface(options).mesh(options.parameters.resolution)
        }
    };
    Ok(build(soup, &job.surface)?)
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

/// The formula that the options name.
fn analytic_surface(options: &AnalyticOptions) -> AnalyticSurface {
    let AnalyticParameters { size, radius, tube_radius, height, .. } = options.parameters;
    match options.kind {
        AnalyticKind::Plane => AnalyticSurface::Plane { width: size, depth: size },
        AnalyticKind::SphereCap => AnalyticSurface::SphereCap { radius, diameter: size },
        AnalyticKind::Cylinder => AnalyticSurface::Cylinder { radius, width: size, length: size },
        AnalyticKind::TorusPatch => {
            AnalyticSurface::Torus { major: radius, minor: tube_radius, length: size, width: size }
        }
        AnalyticKind::Saddle => {
            AnalyticSurface::Saddle { radius: size * size / (8.0 * height), size }
        }
        AnalyticKind::MonkeySaddle => AnalyticSurface::MonkeySaddle { size, height },
        AnalyticKind::Bump => AnalyticSurface::Bump { size, height, width: radius },
    }
}

/// How far the flat polylines of passes may deviate from the level curves, flat mm.
fn ring_tolerance(job: &Job, chart: &Chart) -> f64 {
    let largest = chart.vertex_scale().iter().copied().fold(0.0, f64::max);
    // Pass 0 of an open boundary stays clear of it.
    let tolerance = (RING_TOLERANCE * job.cut.tolerance).min(0.005 * job.nominal_side_step());
    tolerance / largest
}

/// The regions that the job asks for; `None` for a single one.
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

/// What the plane knows: terrain, stock.
struct Plane<'a> {
    job: &'a Job,
    terrain: JointTerrain<'a>,
    region: &'a Region,
}

/// A flat path and what was inserted.
#[derive(Clone)]
struct FlatCut {
    points: Vec<FlatPoint>,
    counts: CutCounts,
}

impl Plane<'_> {
    fn cut(&self, groups: &[Group], progress: impl FnMut(f64)) -> FlatCut {
        let job = self.job;
        let cutting = Cutting {
            // The disc that takes as much of the layer as the cutter, but covers the side step.
            radius: job
                .tool
                .mean_radius(job.cut.axial_depth)
                .max(COVERING * job.nominal_side_step()),
            depth: job.cut.axial_depth,
            feed: job.cut.feed,
            vfc: job.force.vfc,
            limit: job.mrr_limit(),
        };
        let options = CutOptions {
            order: job.path.order,
            links: job.path.links,
            control: job.force.control,
            loops: Loops {
                radius: (0.5 * job.nominal_side_step()).max(job.trochoid.min_radius),
                smallest: (0.5 * job.trochoid.min_radius).min(0.25 * job.nominal_side_step()),
                max_bite: job.trochoid.max_step,
                return_feed: job.trochoid.return_feed,
                tolerance: job.cut.tolerance,
                hand: match job.cut.direction {
                    CutDirection::Climb => 1.0,
                    CutDirection::Conventional => -1.0,
                },
            },
        };
        let mut walk = Walk::new(cutting, &self.terrain, Stock::new(self.region));
        let counts = cut_passes(&mut walk, groups, &options, progress);
        FlatCut { points: walk.finish().0, counts }
    }
}

/// A delivered path, and what it leaves.
struct Finished {
    toolpath: Toolpath,
    raised: Vec<RaisedStretch>,
    coverage: Coverage,
    /// What was removed; unknown where no columns were cut.
    removed: Option<removal::Removed>,
}

impl Finished {
    /// Goes on with a path that begins where this one ends.
    fn append(&mut self, next: Self) {
        self.toolpath.points.extend(next.toolpath.points.into_iter().skip(1));
        self.raised.extend(next.raised);
        (self.coverage, self.removed) = (next.coverage, next.removed);
    }
}

/// From flat paths to delivered ones.
struct Delivery<'a> {
    job: &'a Job,
    surface: &'a Surface,
    chart: &'a Chart,
    locator: &'a Locator<'a>,
    lift: crate::lift::Lift<'a>,
    check: CheckMesh,
    options: DeliverOptions,
    cusp_limit: f64,
    terrain: JointTerrain<'a>,
    threads: usize,
}

impl Delivery<'_> {
    fn layer(&self) -> Layer {
        Layer { stock: self.job.cut.stock, depth: self.job.cut.axial_depth }
    }

    fn columns(&self) -> Columns {
        Columns::new(self.surface, self.chart, self.job.nominal_side_step(), self.layer().top())
    }

    /// The path at the nominal feeds, whatever it removes. Only where the cutter did not fit is it asked
    /// what is left.
    fn unlimited(
        &self,
        flat: &[FlatPoint],
        progress: &mut dyn FnMut(f64),
    ) -> Result<Finished, PlanError> {
        let Delivered { toolpath, raised } = self.mended(flat, progress)?;
        refuse_too_tight(self.job, &raised)?;
        if raised.is_empty() {
            let coverage = Coverage { area: self.surface.area(), ..Coverage::default() };
            return Ok(Finished { toolpath, raised, coverage, removed: None });
        }
        let columns = self.columns();
        let coverage = self.with_access(&toolpath, |access| {
            let removed = removal::remains(&columns, access);
            removal::coverage(&columns, &removed, access)
        });
        Ok(Finished { toolpath, raised, coverage, removed: None })
    }

    /// The path at the nominal feeds, where a tilted flat end leaves too much with detours over that.
    fn mended(
        &self,
        flat: &[FlatPoint],
        progress: &mut dyn FnMut(f64),
    ) -> Result<Delivered, PlanError> {
        let mut delivered =
            deliver(flat, &self.lift, &self.check, &self.options, None, &mut *progress)?;
        let Some(options) = mend_options(self.job) else { return Ok(delivered) };
        let mut mender = Mender::new(self.surface, self.chart, self.locator, options);
        let mut flat = flat.to_vec();
        for _ in 0..MENDS {
            let Delivered { toolpath, raised } = &delivered;
            let Some(mended) = mender.mended(&flat, &toolpath.points, raised) else { break };
            flat = mended;
            delivered =
                deliver(&flat, &self.lift, &self.check, &self.options, None, &mut *progress)?;
        }
        Ok(delivered)
    }

    /// The plain passes with their true removal rates, beside which the delivered path stands.
    fn plain(&self, columns: &Columns, flat: &[FlatPoint]) -> Result<Toolpath, PlanError> {
        let no_check = CheckMesh::new(Vec::new(), Vec::new());
        let path = deliver(flat, &self.lift, &no_check, &self.options, None, |_| {})?.toolpath;
        Ok(self.rated(columns, &path, Feeds::LinksLimited, None)?.0)
    }

    /// The path at the feeds that keep the removal rate to the limit, with passes over what it leaves.
    fn limited(
        &self,
        columns: &Columns,
        flat: &[FlatPoint],
        progress: &mut dyn FnMut(f64),
    ) -> Result<Finished, PlanError> {
        let mut finished = self.limited_part(columns, flat, None, progress)?;
        let side_step = self.job.nominal_side_step();
        for _ in 0..TOUCH_UPS {
            let touch_up = TouchUp {
                side_step,
                beyond: 0.5 * side_step + self.job.tool.radius() - self.job.tool.corner_radius(),
                height: self.job.cut.axial_depth,
                feed: self.job.cut.feed,
                first_pass: finished.toolpath.points.last().map_or(0, |p| p.pass + 1),
                region: finished.toolpath.points.last().map_or(0, |p| p.region),
            };
            let left = &finished.coverage.never_covered_flat;
            let more = link::touch_up(left, &self.terrain, &touch_up);
            if more.is_empty() {
                break;
            }
            let more = self.limited_part(columns, &more, Some(&finished), progress)?;
            finished.append(more);
        }
        Ok(finished)
    }

    fn limited_part(
        &self,
        columns: &Columns,
        flat: &[FlatPoint],
        before: Option<&Finished>,
        progress: &mut dyn FnMut(f64),
    ) -> Result<Finished, PlanError> {
        let last = before.and_then(|b| b.toolpath.points.last().copied());
        let Delivered { toolpath, raised } =
            deliver(flat, &self.lift, &self.check, &self.options, last, progress)?;
        refuse_too_tight(self.job, &raised)?;
        let earlier = before.and_then(|b| b.removed.as_ref());
        let (toolpath, removed) = self.rated(columns, &toolpath, Feeds::Limited, earlier)?;
        let headings = before.map_or(&toolpath, |b| &b.toolpath);
        let coverage = self.coverage(columns, &removed, headings);
        Ok(Finished { toolpath, raised, coverage, removed: Some(removed) })
    }

    /// What is left of the columns; `headings`: a path whose nearest move gives the feed direction.
    fn coverage(
        &self,
        columns: &Columns,
        removed: &removal::Removed,
        headings: &Toolpath,
    ) -> Coverage {
        self.with_access(headings, |access| removal::coverage(columns, removed, access))
    }

    /// Calls `work` with what decides where the cutter can touch.
    fn with_access(&self, headings: &Toolpath, work: impl FnOnce(&Access) -> Coverage) -> Coverage {
        let is_open = self.job.path.boundary == Boundary::Open;
        let inside = |p| is_open || self.terrain.room(p).is_some_and(|room| room >= 0.0);
        work(&Access {
            tool: self.job.tool,
            axis: self.options.pass.axis,
            layer: self.layer(),
            check: &self.check,
            reach: self.options.pass.reach,
            inside: &inside,
            path: headings,
            tolerance: self.job.cut.tolerance,
            cusp: self.cusp_limit,
            cell: self.job.nominal_side_step(),
            threads: self.threads,
        })
    }

    /// The path with its true removal rates and the feeds that follow from them; and what it removed.
    fn rated(
        &self,
        columns: &Columns,
        path: &Toolpath,
        feeds: fn(Limit) -> Feeds,
        earlier: Option<&removal::Removed>,
    ) -> Result<(Toolpath, removal::Removed), PlanError> {
        let job = self.job;
        let removed = columns.cut(path, &job.tool, self.layer(), earlier, self.threads);
        let limit = Limit {
            rate: job.mrr_limit(),
            feed: job.cut.feed,
            return_feed: job.trochoid.return_feed,
            slowest: SLOWEST,
        };
        let unreachable = |TooSlow { place, rate, feed }| PlanError::LimitUnreachable {
            place,
            rate,
            feed,
            limit: job.mrr_limit(),
        };
        let mut path =
            rated(path, &removed, feeds(limit), job.tool.radius()).map_err(unreachable)?;
        fill_time(&mut path, &job.tool, &job.machine);
        Ok((path, removed))
    }
}

/// The cutter if it is tilted and has a flat bottom.
fn tilted(job: &Job) -> Option<Strip> {
    let is_tilted = job.machine.axes == Axes::Xyzac && job.tool.kind() != ToolKind::Ball;
    is_tilted.then(|| strip(job, job.cut.tolerance))
}

/// What tilted flat ends may leave, if the job says so.
fn mend_options(job: &Job) -> Option<MendOptions> {
    let Stepover::Scallop(limit) = job.cut.stepover else { return None };
    let is_flat = tilted(job).is_some() && job.tool.kind() == ToolKind::Flat;
    is_flat.then(|| MendOptions {
        radius: job.tool.radius(),
        side_step: job.nominal_side_step(),
        limit: limit + MENDED * job.cut.tolerance,
    })
}

/// The same cutter with the cusps that it leaves.
fn centred_strip(job: &Job) -> Strip {
    match job.cut.stepover {
        Stepover::Scallop(h) => strip(job, h),
        Stepover::Fixed(d) => {
            let k_tool = strip(job, 1.0).k_tool();
            strip(job, 0.125 * d * d * k_tool)
        }
    }
}

/// How passes are laid where the removal rate is not asked for.
fn lay_options(job: &Job) -> LayOptions {
    LayOptions {
        order: job.path.order,
        traverse: job.path.traverse,
        links: job.path.links,
        direction: job.cut.direction,
        radius: job.tool.radius(),
        height: job.cut.axial_depth,
        feed: job.cut.feed,
        tilted: tilted(job),
    }
}

/// The path at the feeds from which the true removal rate lowers it: those of the plane engine are
/// for its own decisions.
fn at_nominal_feeds(mut points: Vec<FlatPoint>, job: &Job) -> Vec<FlatPoint> {
    for p in &mut points {
        p.feed = if p.kind == MoveKind::Return { job.trochoid.return_feed } else { job.cut.feed };
    }
    points
}

/// Height of the cusps that a job means to leave on a surface, mm: its limit, or what its side step
/// leaves at worst.
pub fn cusp_limit(job: &Job, surface: &Surface, curvature: &CurvatureField) -> f64 {
    let axis = axis_rule(job);
    match job.cut.stepover {
        Stepover::Scallop(h) => h,
        Stepover::Fixed(d) => removal::worst_cusp(&job.tool, axis, surface, curvature, d),
    }
}

fn refuse_too_far(job: &Job, part: &Part) -> Result<(), PlanError> {
    if job.machine.axes == Axes::ThreeAxis {
        return Ok(());
    }
    let (low, high) = part
        .positions
        .iter()
        .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(l, h), &p| (l.min(p), h.max(p)));
    let middle = 0.5 * (low + high);
    let (distance, times) = (middle.length(), middle.length() / (high - low).length());
    if times > FARTHEST {
        return Err(PlanError::FarFromCentre { middle, distance, times });
    }
    Ok(())
}

fn refuse_too_tight(job: &Job, raised: &[RaisedStretch]) -> Result<(), PlanError> {
    let worst = raised.iter().max_by(|a, b| a.raise.total_cmp(&b.raise));
    match worst {
        Some(worst) if job.cut.too_tight == TooTight::Refuse => Err(PlanError::TooTight {
            place: worst.place,
            raise: worst.raise,
            stretches: raised.len(),
            length: raised.iter().map(|r| r.length).sum(),
        }),
        _ => Ok(()),
    }
}

fn axis_rule(job: &Job) -> ToolAxis {
    match job.machine.axes {
        Axes::ThreeAxis => ToolAxis::Fixed(DVec3::Z),
        Axes::Xyzac => ToolAxis::Lead(job.cut.lead),
    }
}

fn deliver_options(job: &Job, rapid_plane: f64, threads: usize) -> DeliverOptions {
    DeliverOptions {
        pass: PassOptions {
            tool: job.tool,
            axis: axis_rule(job),
            axis_rate: f64::INFINITY,
            stock: job.cut.stock,
            tolerance: job.cut.tolerance,
            reach: job.cutter_length(),
        },
        rapid_plane,
        threads,
        highest_raise: job.tool.radius().max(2.0 * job.cut.axial_depth),
        air_feed: job.trochoid.return_feed.min(job.machine.max_feed),
        rapid_feed: job.machine.max_feed,
    }
}

/// Height that is clear of part and stock: above the top in three axes; in five, above the sphere
/// about the rotary centre (the origin) that holds the part in any position of the tables.
fn rapid_plane(part: &Part, job: &Job) -> f64 {
    let above = job.cut.axial_depth + job.cut.stock + job.machine.clearance;
    let reach = |p: &DVec3| match job.machine.axes {
        Axes::ThreeAxis => p.z,
        Axes::Xyzac => p.length(),
    };
    part.positions.iter().map(reach).fold(f64::NEG_INFINITY, f64::max) + above
}
