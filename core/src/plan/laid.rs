//! A prepared surface → regions, passes on each, their order, and the path over them in the flat plane.

use super::delivery::{Delivery, Plain, above_end, deliver_options, rapid_plane, walls};
use super::error::PlanError;
use super::given_stock;
use super::plane::{FlatCut, Plane, centring};
use super::prepared::Prepared;
use super::stage::Stage;
use super::uncut::Uncut;
use crate::cutter_location::{Obstacles, ToolAxis};
use crate::flat_path::FlatPoint;
use crate::flatten::{FlattenError, Locator};
use crate::geometry::DVec3;
use crate::job::{Boundary, Division, ForceControl, Job, Start};
use crate::level_set::{PassMesh, StripMetric};
use crate::lift::Lift;
use crate::link::{DeliverOptions, Deliverer, Excess};
use crate::machine::Axes;
use crate::outline::Outline;
use crate::pattern;
use crate::regions::tensor::{self, Topology};
use crate::regions::{self, Layout, LayoutOptions, RegionMesh, Regions, Undivided};
use crate::removal::{Before, CLOSEST, Columns, Stock};
use crate::strips::{CuspBudget, Strips};
use crate::surface::Surface;
use crate::walls::Clearance;
use core::cell::OnceCell;
use std::sync::Arc;

/// Fraction of the tolerance by which the polylines of rings may deviate from the level curve.
const RING_TOLERANCE: f64 = 0.25;
/// Fraction of the tolerance that cutter locations on a reached surface use: where the cutter bridges the part, it
/// touches edges all along a pass, and what is rounded in the program must not break the limit.
const ON_REACHED: f64 = 0.9;
/// Farthest distance of a point of a start curve from the surface's bounding box, in diagonals of the box.
const CURVE_AWAY: f64 = 0.25;

/// A path in the flat plane, with all that it takes to deliver it: what is missing are cutter locations, the feeds of
/// the real cutter, and the extra passes over places where the cutter did not fit.
pub struct Laid<'a> {
    pub(super) ground: Ground<'a>,
    pub(super) flat: FlatCut,
    /// The path of the plain passes, where the removal rate is limited.
    pub(super) plain: Option<Plain>,
}

/// The passes of a job on a prepared surface, and what they must keep clear of.
pub(super) struct Ground<'a> {
    pub prepared: &'a Arc<Prepared>,
    pub job: &'a Job,
    /// The regions, and what a single stepover would give; `None` for an undivided surface.
    pub regions: Option<(Regions, Undivided)>,
    /// Where the best feed direction is undefined, if the surface is divided by it.
    pub topology: Option<Topology>,
    pub region_meshes: Vec<RegionMesh>,
    pub layouts: Vec<Layout>,
    /// The indices of the regions in the order of machining.
    pub order: Vec<usize>,
    /// Shortest length that passes can have, mm.
    pub length_floor: f64,
    pub obstacles: Obstacles,
    pub options: DeliverOptions,
    pub cusps: CuspBudget,
    /// Height of the material over the surface before any cut, mm.
    top: f64,
    /// By how much it may be higher where earlier cutters bridged the part, mm.
    bridged: f64,
    /// What has cut it before.
    before: Before,
    /// The material, once it is asked for, and what of it is beside the surface.
    columns: OnceCell<Columns>,
    beside: OnceCell<Columns>,
}

impl<'a> Laid<'a> {
    /// Lays out the passes of a job on its surface; `stock`: the material that they meet. `progress`: as for
    /// [`Prepared::new`].
    ///
    /// # Errors
    /// [`PlanError`]: what cannot be planned, where, and what to change.
    ///
    /// # Panics
    /// If the surface is not that of the job: if [`Prepared::is_of`] is false.
    pub fn new(
        prepared: &'a Arc<Prepared>,
        job: &'a Job,
        stock: &Stock,
        threads: usize,
        progress: &mut dyn FnMut(Stage, f64),
    ) -> Result<Self, PlanError> {
        assert!(prepared.is_of(job), "plan: the surface was prepared for other keys of the job");
        refuse_curve_away(job, &prepared.surface)?;
        progress(Stage::Rings, 0.0);
        let ground = Ground::new(prepared, job, stock, threads)?;
        progress(Stage::Cut, 0.0);
        let (flat, plain) = ground
            .on(|plane, delivery| ground.cut(plane, delivery, &mut |p| progress(Stage::Cut, p)))?;
        Ok(Self { ground, flat, plain })
    }

    /// The path in the flat plane.
    pub fn points(&self) -> &[FlatPoint] {
        &self.flat.points
    }

    /// Whether its removal rates are known: those of the disc model in the plane.
    pub fn is_rated(&self) -> bool {
        self.flat.is_rated
    }
}

impl<'a> Ground<'a> {
    fn new(
        prepared: &'a Arc<Prepared>,
        job: &'a Job,
        stock: &Stock,
        threads: usize,
    ) -> Result<Self, PlanError> {
        let (surface, chart, curvature) = (&prepared.surface, &prepared.chart, &prepared.curvature);
        let locator = &prepared.locator();
        let before = stock.strokes();
        let mut cusps = CuspBudget::of(job, surface, curvature);
        let heights = [cusps.aimed, cusps.left_open()];
        let Strips { metrics, creases, spacing } =
            Strips::of(job, &cusps, surface, chart, curvature);
        let (mut regions, topology) = match job.rest {
            true => {
                // What earlier operations were allowed to leave is none.
                cusps.limit = stock.allowed(job.cut.allowance).max(cusps.limit);
                let uncut = Uncut { prepared, job, stock, before: &before, threads };
                (Some(uncut.regions(cusps.too_high(), &metrics)?), None)
            }
            false => division(prepared, locator, job, &metrics, threads)?,
        };
        let undivided = regions.as_ref().map(|r| Undivided::of(r, surface, chart, &metrics));
        let mut region_meshes =
            regions::region_meshes(regions.as_ref(), surface, chart, metrics, threads)?;
        if let (true, Some(regions)) = (job.rest, &mut regions) {
            // Single spots get rest passes.
            let is_wide: Vec<bool> = region_meshes.iter().map(RegionMesh::holds_rings).collect();
            regions.retain(&is_wide);
            let mut wide = is_wide.into_iter();
            region_meshes.retain(|_| wide.next() == Some(true));
            if region_meshes.is_empty() {
                return Err(PlanError::RestTooNarrow { limit: cusps.too_high() });
            }
        }
        let floor = region_meshes.iter().map(RegionMesh::length_floor).sum::<f64>() / creases;
        if let (Some(solid), true) = (&prepared.stock, stock.earlier.is_empty()) {
            let meshes = region_meshes.iter().map(|region_mesh| &region_mesh.fine);
            let allowed = (stock.top, job.cut.tolerance);
            given_stock::refuse_thick(solid, meshes, allowed, threads)?;
        }
        let walls = walls(job, prepared);
        let plane = rapid_plane(&prepared.design, &walls, job, stock.top);
        let over = prepared.design.stock.is_none().then_some(stock.top);
        let mut options = deliver_options(job, plane, over, threads);
        if prepared.aside.is_some() {
            options.pass.tolerance *= ON_REACHED;
        }
        let obstacles = walls.obstacles(Arc::clone(&prepared.obstacle));
        let obstacles = match job.machine.axes {
            Axes::ThreeAxis => obstacles,
            Axes::FiveAxis(_) => obstacles.with_above(above_end(job, prepared)),
        };
        let clearance =
            Clearance { surface, chart: locator, obstacles: &obstacles, pass: options.pass };
        let layout_options = LayoutOptions {
            job,
            surface,
            chart: locator,
            tolerance: ring_tolerance(job, prepared),
            // What stands on an open surface is no place to begin from.
            clearance: (job.path.boundary == Boundary::Wall).then_some(clearance),
            cusps: heights,
            threads,
        };
        let layouts = regions::lay_out(&region_meshes, &layout_options)?;
        let place = |at| locator.locate(at).ok().map(|p| surface.position(p));
        let order = regions::in_order(regions.as_ref(), &layouts, job.regions.order, place);
        Ok(Self {
            prepared,
            job,
            regions: regions.zip(undivided),
            topology,
            region_meshes,
            layouts,
            order,
            length_floor: floor * spacing,
            obstacles,
            options,
            cusps,
            top: stock.top,
            bridged: stock.bridged,
            before,
            columns: OnceCell::new(),
            beside: OnceCell::new(),
        })
    }

    /// Whether earlier operations have cut the material.
    pub fn is_cut_before(&self) -> bool {
        self.before.stages().next().is_some()
    }

    /// Calls `work` with what lays paths over the passes and what delivers them.
    pub fn on<T>(&self, work: impl FnOnce(&Plane, &Delivery) -> T) -> T {
        let Self { prepared, job, .. } = *self;
        let (surface, chart) = (&prepared.surface, &prepared.chart);
        let locator = &prepared.locator();
        let fine: Vec<Locator> = self.region_meshes.iter().map(RegionMesh::locator).collect();
        let plane = Plane {
            job,
            region_meshes: &self.region_meshes,
            layouts: &self.layouts,
            fine: &fine,
            region: &Outline::of_chart(surface, chart),
            centring: centring(job, self.cusps.on_plane, prepared, locator),
        };
        let axis = match self.options.pass.axis {
            ToolAxis::Fixed(axis) => Some(axis),
            ToolAxis::Lead(_) => None,
        };
        let cutter = (job.tool.radius(), job.footprint());
        let lift = Lift::new(surface, chart, locator, cutter, axis);
        let delivery = Delivery {
            job,
            surface,
            chart,
            locator,
            deliverer: Deliverer { lift: &lift, obstacles: &self.obstacles, options: self.options },
            cusps: self.cusps,
            chord: prepared.chord(),
            top: self.top,
            bridged: self.bridged,
            before: &self.before,
            columns: &self.columns,
            beside: &self.beside,
        };
        work(&plane, &delivery)
    }

    /// The flat path, and that of the plain passes on the part where the removal rate is limited. Plain passes that
    /// keep to the limits are the path themselves.
    fn cut(
        &self,
        plane: &Plane,
        delivery: &Delivery,
        progress: &mut dyn FnMut(f64),
    ) -> Result<(FlatCut, Option<Plain>), PlanError> {
        let laid = plane.laid(&self.order);
        let plain = delivery.plain(&laid.points)?;
        let control = self.job.force.control;
        let cut = plain
            .as_ref()
            .and_then(|plain| self.cut_within((plane, control), plain, &[], progress));
        let Some(cut) = cut else { return Ok((laid, plain)) };
        // Trochoids that no limit asks for, only the wish for thicker chips, are not to take longer.
        let is_wish = control == ForceControl::Fastest && !self.job.bounds().bound_sections();
        let slowed = plain.as_ref().and_then(|plain| plain.slowed.as_ref()).filter(|_| is_wish);
        let is_slower = match slowed {
            Some(slowed) => delivery.is_slower(&cut.points, slowed)?,
            None => false,
        };
        Ok((if is_slower { laid } else { cut }, plain))
    }

    /// The flat path of passes that, plain and at the full feed, would break a limit: with trochoids wherever more would
    /// be cut at once than may be, and with smaller bites by the factors of `beyond`; `None` where plain passes break none.
    pub fn cut_within(
        &self,
        (plane, control): (&Plane, ForceControl),
        plain: &Plain,
        beyond: &[Excess],
        progress: &mut dyn FnMut(f64),
    ) -> Option<FlatCut> {
        let job = self.job;
        let load = job.load();
        let at_full_feed = load.at_full_feed(job.cut.feed);
        let most = match control {
            ForceControl::Off | ForceControl::Feed => at_full_feed,
            ForceControl::Trochoid => at_full_feed.min(load.thickest(CLOSEST)),
            ForceControl::Fastest => load.thickest(CLOSEST),
        };
        let path = &plain.at_full_feed;
        let is_plain = !plane.is_walked()
            || plane.excess(path, at_full_feed.min(load.thickest(CLOSEST))).is_empty();
        let cut = || plane.cut(&self.order, (&plane.excess(path, most), most), beyond, progress);
        (!is_plain).then(cut)
    }
}

/// How far the flat polylines of passes may deviate from the level curves, flat mm.
fn ring_tolerance(job: &Job, prepared: &Prepared) -> f64 {
    let largest = prepared.chart.vertex_scale().iter().copied().fold(0.0, f64::max);
    // Pass 0 of an open boundary stays clear of it.
    let tolerance = (RING_TOLERANCE * job.cut.tolerance).min(0.005 * job.nominal_side_step());
    tolerance / largest
}

/// The regions, and where the best feed direction is undefined, if they are divided by it.
fn division(
    prepared: &Prepared,
    locator: &Locator,
    job: &Job,
    metrics: &[StripMetric],
    threads: usize,
) -> Result<(Option<Regions>, Option<Topology>), PlanError> {
    let mut topology = topology(prepared, locator, job);
    let regions = match job.path.pattern.divides_itself() {
        true => Some(banded(prepared, job, metrics.to_vec())?),
        false => divided(prepared, job, topology.as_ref(), threads)?,
    };
    if let (Some(topology), Some(regions)) = (&mut topology, &regions) {
        // What was too small may have been joined again.
        topology.points.iter_mut().for_each(|p| p.divides &= regions.is_at_border(p.at.face));
    }
    Ok((regions, topology))
}

/// The regions that the job specifies; `None` for a single one.
fn divided(
    prepared: &Prepared,
    job: &Job,
    topology: Option<&Topology>,
    threads: usize,
) -> Result<Option<Regions>, FlattenError> {
    let (surface, chart, least) = (&prepared.surface, &prepared.chart, job.regions.min_area);
    match &job.regions.division {
        Division::Single if prepared.pieces > 1 => {
            Regions::along(surface, chart, &[], least).map(Some)
        }
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
fn banded(prepared: &Prepared, job: &Job, metric: Vec<StripMetric>) -> Result<Regions, PlanError> {
    let (surface, chart) = (&prepared.surface, &prepared.chart);
    let mesh = PassMesh::coarse(surface, chart, metric)?;
    let locator = Locator::new(mesh.connectivity(), mesh.uv());
    let bands = pattern::bands(&mesh, &locator);
    let regions = Regions::along(surface, chart, &bands.cuts, job.regions.min_area)?;
    Ok(regions.with_starts(&bands.starts))
}

/// The topology of the best feed direction, for jobs that divide by it.
fn topology(prepared: &Prepared, locator: &Locator, job: &Job) -> Option<Topology> {
    let Division::Tensor(options) = &job.regions.division else { return None };
    let k_tool = job.footprint().k_tool();
    let (surface, map) = (&prepared.surface, (&prepared.chart, locator));
    Some(tensor::topology(surface, map, &prepared.curvature, k_tool, options).0)
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
