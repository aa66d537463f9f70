//! Passes → the path in the plane: cut with the disc that represents the cutter, or laid out as they are.

use super::prepared::Prepared;
use crate::centring::Centring;
use crate::engagement::{Cutting, Simulation, Stock, predicted};
use crate::flat_path::FlatPoint;
use crate::flatten::Locator;
use crate::job::{ForceControl, Job, Pattern};
use crate::level_set::FieldTerrain;
use crate::link::{CutOptions, Excess, Group, LayOptions, Measured, cut_passes, lay};
use crate::load::LoadLimits;
use crate::outline::Outline;
use crate::regions::{JointTerrain, Layout, RegionMesh};
use crate::removal::excesses;
use crate::toolpath::{MoveKind, Planar, Toolpath};
use crate::trochoid::Loops;

/// Largest distance of the points of centred passes, side steps.
const CENTRED: f64 = 0.25;
/// The disc's radius in side steps, at least: neighbouring discs overlap by a tenth.
const COVERING: f64 = 0.55;
/// Where loops cut too much, they are to cut less by the factor by which they do, times this one.
const MORE: f64 = 1.06;
/// The largest factor at once.
const MOST: f64 = 1.5;

/// The data of the plane.
pub struct Plane<'a> {
    pub job: &'a Job,
    pub region_meshes: &'a [RegionMesh],
    pub layouts: &'a [Layout],
    /// Over the fine mesh of every region mesh.
    pub fine: &'a [Locator<'a>],
    pub region: &'a Outline,
    /// Adjusts the passes of cutters whose strips lag.
    pub centring: Option<Centring<'a>>,
}

/// A flat path and what was inserted into it.
pub struct FlatCut {
    pub points: Vec<FlatPoint>,
    /// Trochoid loops.
    pub loops: usize,
    /// Whether its removal rates are known: those of the disc model.
    pub is_rated: bool,
}

impl<'a> Plane<'a> {
    /// Clearance, scale and levels over the whole chart; one for every thread.
    pub fn terrain(&self) -> JointTerrain<'a> {
        let parts = self.region_meshes.iter().zip(self.layouts).zip(self.fine);
        JointTerrain::new(
            parts.map(|((g, l), fine)| FieldTerrain::new(&g.fine, &l.field, fine)).collect(),
        )
    }

    /// Whether passes are cut anew, slowed or with trochoids, where plain ones would break a limit.
    pub fn is_walked(&self) -> bool {
        let Job { path, force, .. } = self.job;
        match path.pattern {
            Pattern::Contour => force.control != ForceControl::Off,
            _ => force.control.takes_trochoids(),
        }
    }

    fn groups(&self, order: &[usize]) -> Vec<Group<'a>> {
        order.iter().map(|&k| self.layouts[k].group()).collect()
    }

    /// The plain passes over the regions in the given order.
    pub fn laid(&self, order: &[usize]) -> FlatCut {
        let points = lay(&self.groups(order), &self.terrain(), &lay_options(self.job));
        let points = match &self.centring {
            Some(centring) => centring.centred(&points),
            None => points,
        };
        FlatCut { points, loops: 0, is_rated: false }
    }

    /// Where a path of plain passes cuts more than a section, mm³ per mm of travel.
    pub fn excess(&self, plain: &Toolpath, section: f64) -> Excess {
        Excess::above(plain, section, self.job.tool.radius(), &self.terrain())
    }

    /// Where a path's cutting moves break a limit on engagement or feed per tooth, and by which factor.
    pub fn beyond(&self, path: &Toolpath, bounds: &LoadLimits) -> Excess {
        let factors = excesses(path, bounds).into_iter().map(|by| Some((by? * MORE).min(MOST)));
        Excess::of(path, factors, self.job.tool.radius(), &self.terrain())
    }

    /// The disc that represents the cutter. `limit`: of its removal rate, mm³/s.
    fn cutting(&self, limit: f64) -> Cutting {
        let job = self.job;
        Cutting {
            // The disc that takes as much of the layer as the cutter, but covers the side step.
            radius: job
                .tool
                .mean_radius(job.cut.axial_depth)
                .max(COVERING * job.nominal_side_step()),
            depth: job.cut.axial_depth,
            feed: job.cut.feed,
            vfc: job.force.vfc,
            limit,
        }
    }

    /// What the disc predicts for the moves of a delivered path.
    pub fn predicted(&self, path: &Toolpath) -> Vec<Option<Planar>> {
        let terrain = self.terrain();
        let stock = Stock::new(self.region);
        predicted(path, Simulation::new(self.cutting(f64::INFINITY), &terrain, stock))
    }

    /// The passes as the disc cuts them, with trochoids near the places of `plain`: their loops cut no more than a
    /// `section`, mm³ per mm of travel, and less by the factors of `beyond`, where paths like this broke a limit.
    pub fn cut(
        &self,
        order: &[usize],
        (plain, section): (&Excess, f64),
        beyond: &[Excess],
        progress: &mut dyn FnMut(f64),
    ) -> FlatCut {
        let job = self.job;
        let cutting = self.cutting(section * job.cut.feed);
        let options = CutOptions {
            order: job.path.order,
            links: job.path.links,
            control: job.force.control,
            loops: Loops {
                radius: (0.5 * job.nominal_side_step()).max(job.trochoid.min_radius),
                least: job.trochoid.min_radius,
                smallest: (0.5 * job.trochoid.min_radius).min(0.25 * job.nominal_side_step()),
                max_bite: job.trochoid.max_step,
                return_feed: job.trochoid.return_feed,
                tolerance: job.cut.tolerance,
                hand: if job.keeps_material_on_right() { 1.0 } else { -1.0 },
            },
        };
        let terrain = self.terrain();
        let mut simulation = Simulation::new(cutting, &terrain, Stock::new(self.region));
        let measured = Measured {
            plain: &|at| plain.nearest(at),
            beyond: &|at| beyond.iter().filter_map(|excess| excess.most(at)).product(),
        };
        let (groups, laid) = (&self.groups(order), &self.laid(order).points);
        let loops = cut_passes(&mut simulation, (groups, laid), &options, measured, progress);
        FlatCut { points: at_nominal_feeds(simulation.finish().0, job), loops, is_rated: true }
    }
}

/// How passes are adjusted whose strips, below cusps `cusp` mm high, lag; `None` for the others.
pub fn centring<'a>(
    job: &Job,
    cusp: f64,
    prepared: &'a Prepared,
    locator: &'a Locator<'a>,
) -> Option<Centring<'a>> {
    let footprint = job.footprint();
    footprint.lags().then(|| Centring {
        surface: &prepared.surface,
        chart: &prepared.chart,
        locator,
        curvature: &prepared.curvature,
        footprint,
        cusp,
        step: CENTRED * job.nominal_side_step(),
    })
}

/// How passes are laid out where the removal rate does not matter.
fn lay_options(job: &Job) -> LayOptions {
    LayOptions {
        order: job.path.order,
        traverse: job.path.traverse,
        links: job.path.links,
        stock_on_right: job.keeps_material_on_right(),
        radius: job.tool.radius(),
        height: job.cut.axial_depth,
        feed: job.cut.feed,
        footprint: job.footprint(),
    }
}

/// The path at the feeds from which the true removal rate may reduce them; the feeds of the plane engine serve only
/// its own decisions.
fn at_nominal_feeds(mut points: Vec<FlatPoint>, job: &Job) -> Vec<FlatPoint> {
    for p in &mut points {
        p.feed = if p.kind == MoveKind::Return { job.trochoid.return_feed } else { job.cut.feed };
    }
    points
}
