//! Flat paths → delivered ones: with their true removal rates, and without the material that the first passes leave.

use super::design::Design;
use super::error::{PlanError, SLOWEST};
use super::load::Avoided;
use super::prepared::Prepared;
use crate::cutter_location::{AboveEnd, Hindrance, KeptClear, LiftedSpan, PassOptions, ToolAxis};
use crate::flat_path::FlatPoint;
use crate::flatten::{Chart, Locator};
use crate::geometry::DVec3;
use crate::job::{Boundary, ForceControl, Inaccessible, Job};
use crate::link::{DeliverOptions, Delivered, Deliverer};
use crate::machine::Axes;
use crate::machine_time::{fill_time, machine_time};
use crate::removal::{
    self, Access, Before, Columns, Coverage, Cutter, Feeds, Layer, Limit, Removed, TooSlow, rated,
};
use crate::rest::{Places, Rest, RestOptions};
use crate::strips::CuspBudget;
use crate::surface::{Part, Surface};
use crate::toolpath::Toolpath;
use crate::walls::{Sweep, WallOptions, Walls};
use core::cell::OnceCell;

/// Fraction of the stock's depth above which the remaining material counts as untouched.
const TOUCHED: f64 = 0.98;
/// Approaches are slow from this fraction of the clearance above the stock on.
const SLOW: f64 = 0.2;

/// How much farther than asked the cutter is kept from what is avoided, tolerances: it may come nearer by one, and what
/// is left covers the rounding of coordinates in programs.
const SPARE: f64 = 1.25;
/// How much farther than asked wide sections are kept from everything, mm: between two points of the program the tool
/// turns by its own interpolation.
const BETWEEN: f64 = 0.2;
/// How far from the surface what is avoided may push the cutter aside, radii of the cutter with the distance: it is
/// pushed no farther.
const NEAR: f64 = 4.0;

/// The path of the plain passes, for comparison.
#[derive(Clone, Debug)]
pub struct Plain {
    /// At the full feed, but for links.
    pub at_full_feed: Toolpath,
    /// Slowed wherever rate or power exceed their limits; `None` where that would be too slow.
    pub slowed: Option<Toolpath>,
}

/// A delivered path, and what it leaves.
pub struct Finished {
    pub toolpath: Toolpath,
    pub lifted: Vec<LiftedSpan>,
    pub coverage: Coverage,
}

/// From flat paths to delivered ones.
pub struct Delivery<'a> {
    pub job: &'a Job,
    pub surface: &'a Surface,
    pub chart: &'a Chart,
    pub locator: &'a Locator<'a>,
    pub deliverer: Deliverer<'a>,
    pub cusps: CuspBudget,
    /// How far the facets may be off a smooth surface, mm.
    pub chord: f64,
    /// Height of the material over the surface before any cut, mm, and by how much it may be higher where earlier cutters
    /// bridged the part.
    pub top: f64,
    pub bridged: f64,
    /// What has cut it before.
    pub before: &'a Before,
    /// The material, once it is asked for, and what of it is beside the surface.
    pub columns: &'a OnceCell<Columns>,
    pub beside: &'a OnceCell<Columns>,
}

impl Delivery<'_> {
    /// The material as it lies over the surface.
    fn layer(&self) -> Layer {
        let allowance = self.job.cut.allowance;
        Layer { allowance, depth: self.top - allowance, falls: false }
    }

    /// The material with what earlier cutters bridged, of which rates are computed. On slopes so thick a layer says
    /// nothing of the cusps.
    fn whole_layer(&self) -> Layer {
        let layer = self.layer();
        Layer { depth: layer.depth + self.bridged, falls: self.bridged > 0.0, ..layer }
    }

    /// The plain passes with their true removal rates, for comparison with the path; `None` where the rates are not
    /// needed.
    pub fn plain(&self, flat: &[FlatPoint]) -> Result<Option<Plain>, PlanError> {
        if self.job.force.control == ForceControl::Off {
            return Ok(None);
        }
        let walls = self.deliverer.obstacles.without_part();
        let path = Deliverer { obstacles: &walls, ..self.deliverer }.path(flat, None, |_| {})?;
        let removed = self.removed(&path.toolpath);
        let at_full_feed = self.rated(&path.toolpath, &removed, Feeds::LinksLimited)?;
        // Where it would be too slow it is no alternative.
        let slowed = self.rated(&path.toolpath, &removed, Feeds::Limited).ok();
        Ok(Some(Plain { at_full_feed, slowed }))
    }

    /// The path of the passes alone.
    pub fn delivered(
        &self,
        flat: &[FlatPoint],
        progress: &mut dyn FnMut(f64),
    ) -> Result<Delivered, PlanError> {
        Ok(self.deliverer.path(flat, None, progress)?)
    }

    /// Whether the passes, at feeds that keep the limits, take longer on the machine than a path; so do those that cannot
    /// be slowed enough.
    pub fn is_slower(&self, flat: &[FlatPoint], other: &Toolpath) -> Result<bool, PlanError> {
        let passes = self.delivered(flat, &mut |_| {})?;
        let Ok(limited) = self.limited(&passes.toolpath) else { return Ok(true) };
        let job = self.job;
        let time = |path: &Toolpath| {
            machine_time(path, &job.tool, &job.machine, job.cut.tolerance).limited.total()
        };
        Ok(time(&limited) > time(other))
    }

    /// The path with branches over what its passes leave.
    pub fn finished(&self, passes: Delivered) -> Result<Finished, PlanError> {
        let places = Places {
            surface: self.surface,
            chart: self.chart,
            locator: self.locator,
            side_step: self.job.nominal_side_step(),
        };
        let mut rest = Rest::new(places, self.deliverer, self.before, self.rest_options());
        let delivered = rest.cut(passes)?;
        let (Delivered { toolpath, lifted, .. }, mut coverage) =
            self.covered(delivered, &mut rest)?;
        refuse_inaccessible(self.job, &lifted)?;
        if toolpath.points.is_empty()
            && let Some(least) = lifted.iter().min_by(|a, b| a.raise.total_cmp(&b.raise))
        {
            return Err(PlanError::FitsNowhere { place: least.place, raise: least.raise });
        }
        coverage.inaccessible_places.extend(rest.into_inaccessible());
        let toolpath = match self.job.force.control {
            ForceControl::Off => toolpath,
            _ => self.limited(&toolpath)?,
        };
        Ok(Finished { toolpath, lifted, coverage })
    }

    /// The path with its true removal rates, at feeds that keep the limits.
    pub fn limited(&self, path: &Toolpath) -> Result<Toolpath, PlanError> {
        self.rated(path, &self.removed(path), Feeds::Limited)
    }

    /// What a path leaves, with branches over what the cutter reaches of it. It is only computed where the cutter did
    /// not fit, where there are walls: beside them stays what it cannot enter, and where passes cover a part alone.
    fn covered(
        &self,
        path: Delivered,
        rest: &mut Rest,
    ) -> Result<(Delivered, Coverage), PlanError> {
        let has_walls = !self.deliverer.obstacles.rulings().is_empty();
        if path.lifted.is_empty() && !has_walls && !self.job.rest {
            let coverage = Coverage { area: self.surface.area(), ..Coverage::default() };
            return Ok((path, coverage));
        }
        let coverage = self.coverage(&path.toolpath);
        let points = path.toolpath.points.len();
        let path = rest.cut_at(&coverage.never_covered_flat, path)?;
        let is_same = path.toolpath.points.len() == points;
        let coverage = if is_same { coverage } else { self.coverage(&path.toolpath) };
        Ok((path, coverage))
    }

    fn columns(&self) -> &Columns {
        let (layer, threads) = (self.whole_layer(), self.deliverer.options.threads);
        let cut = || self.fresh_columns(layer).cut_before(self.before, layer, threads);
        self.columns.get_or_init(cut)
    }

    /// The material beside the surface.
    fn beside(&self) -> &Columns {
        let (layer, threads) = (self.whole_layer(), self.deliverer.options.threads);
        let (side_step, top) = (self.job.nominal_side_step(), layer.top());
        let fresh = || Columns::beside(self.surface, self.chart, side_step, DVec3::Z, top);
        self.beside.get_or_init(|| fresh().cut_before(self.before, layer, threads))
    }

    fn fresh_columns(&self, layer: Layer) -> Columns {
        let side_step = self.job.nominal_side_step();
        Columns::new(self.surface, self.chart, side_step, layer.top())
    }

    /// Columns within the tolerance of walls.
    fn rim(&self) -> Columns {
        let (job, top) = (self.job, self.layer().top());
        let apart = 0.1 * job.nominal_side_step();
        Columns::along_boundary(self.surface, self.chart, (job.cut.tolerance, apart), top)
    }

    /// What a path leaves of the columns.
    fn coverage(&self, path: &Toolpath) -> Coverage {
        let access = Access {
            pass: self.deliverer.options.pass,
            layer: self.layer(),
            obstacles: self.deliverer.obstacles,
            path,
            rim: (!self.deliverer.obstacles.rulings().is_empty()).then(|| self.rim()),
            follows_walls: self.job.path.boundary == Boundary::Wall,
            // Columns stand on facets, below the smooth surface by the chord error.
            cusp: self.cusps.limit + self.chord,
            cell: self.job.nominal_side_step(),
            before: self.before,
            threads: self.deliverer.options.threads,
        };
        match self.bridged > 0.0 {
            true => removal::coverage(&self.fresh_columns(access.layer), &access),
            false => removal::coverage(self.columns(), &access),
        }
    }

    /// What the path may leave.
    fn rest_options(&self) -> RestOptions {
        let job = self.job;
        // Wherever cusps may be as high as the stock, it is to be touched.
        let touched = TOUCHED * self.layer().depth;
        RestOptions {
            side_step: job.nominal_side_step(),
            limit: self.cusps.too_high().min(touched),
            allowed: self.cusps.allowed().min(touched),
            close: self.cusps.limit.min(touched),
            lag: job.footprint().lag(0.5 * job.nominal_side_step()),
            has_open_rim: job.path.boundary == Boundary::Open,
        }
    }

    /// What a path truly removes.
    fn removed(&self, path: &Toolpath) -> Removed {
        let options = &self.deliverer.options;
        let cutter = Cutter { tool: self.job.tool, length: options.pass.reach };
        let cut =
            |columns: &Columns| columns.cut(path, cutter, self.whole_layer(), options.threads);
        cut(self.columns()).with(&cut(self.beside()))
    }

    /// The path with its true removal rates and the resulting feeds.
    fn rated(
        &self,
        path: &Toolpath,
        removed: &Removed,
        feeds: fn(Limit) -> Feeds,
    ) -> Result<Toolpath, PlanError> {
        let job = self.job;
        let limit = Limit {
            load: job.load(),
            feed: job.cut.feed,
            return_feed: job.trochoid.return_feed,
            slowest: SLOWEST,
        };
        let unreachable = |TooSlow { place, rate, left, feed }| PlanError::LimitUnreachable {
            place,
            rate,
            left,
            feed,
        };
        let mut path =
            rated(path, removed, feeds(limit), job.tool.radius()).map_err(unreachable)?;
        fill_time(&mut path, &job.tool, &job.machine);
        Ok(path)
    }
}

fn refuse_inaccessible(job: &Job, lifted: &[LiftedSpan]) -> Result<(), PlanError> {
    let worst = lifted.iter().max_by(|a, b| a.raise.total_cmp(&b.raise));
    match worst {
        Some(worst) if job.cut.inaccessible == Inaccessible::Refuse => {
            Err(PlanError::Inaccessible {
                place: worst.place,
                raise: worst.raise,
                spans: lifted.len(),
                length: lifted.iter().map(|r| r.length).sum(),
            })
        }
        _ => Ok(()),
    }
}

/// `stock`: height of the material over the surface, mm; `None` where it is given and may stand higher beside that.
pub fn deliver_options(
    job: &Job,
    rapid_plane: f64,
    stock: Option<f64>,
    threads: usize,
) -> DeliverOptions {
    DeliverOptions {
        pass: PassOptions {
            tool: job.tool,
            axis: ToolAxis::on(job.machine.axes, job.cut.lead),
            axis_rate: f64::INFINITY,
            largest_tilt: job.cut.largest_tilt,
            allowance: job.cut.allowance,
            tolerance: job.cut.tolerance,
            reach: job.cutter_length(),
        },
        rapid_plane,
        threads,
        highest_raise: job.tool.radius().max(2.0 * job.cut.axial_depth),
        entry_radius: job.path.entry_radius,
        slow_below: stock.map_or(f64::INFINITY, |stock| stock + SLOW * job.machine.clearance),
        air_feed: job.trochoid.return_feed.min(job.machine.max_feed),
        rapid_feed: job.machine.max_feed,
    }
}

/// Height that clears part, material, walls and what is avoided: above the top in three axes; in five, above the sphere
/// about the rotary centre (the origin) that contains them in any position of the tables. `stock`: height of the
/// material over the surface, mm.
pub fn rapid_plane(design: &Design, walls: &Walls, job: &Job, stock: f64) -> f64 {
    let reach = |p: &DVec3| match job.machine.axes {
        Axes::ThreeAxis => p.z,
        Axes::FiveAxis(_) => p.length(),
    };
    let top = |part: &Part| part.positions.iter().map(reach).fold(f64::NEG_INFINITY, f64::max);
    let (walls, avoided) = walls.top(reach);
    let given = design.stock.as_ref().map_or(f64::NEG_INFINITY, top);
    (top(&design.part) + stock).max(given).max(walls).max(avoided) + job.machine.clearance
}

/// The walls along a job's surface, none at an open boundary, and what is avoided.
pub fn walls(job: &Job, prepared: &Prepared) -> Walls {
    let surface = &prepared.surface;
    let options = WallOptions {
        sweep: match ToolAxis::on(job.machine.axes, job.cut.lead) {
            ToolAxis::Fixed(axis) => Sweep::Axis(axis),
            ToolAxis::Lead(_) => Sweep::Normal,
        },
        height: job.path.wall_height,
        allowance: job.cut.allowance,
        spacing: WallOptions::spacing(job.tool.radius(), job.cut.tolerance),
    };
    let mut walls = match job.path.boundary {
        Boundary::Open if prepared.is_reached_by_flat(job) => {
            Walls::of_part(&prepared.part, DVec3::Z, job.cut.tolerance, &options)
        }
        Boundary::Open => Walls::default(),
        Boundary::Wall => Walls::beside(surface, &prepared.part.without(surface), &options),
    };
    for Avoided { mesh, distance, .. } in &prepared.avoided {
        let distance = distance + SPARE * job.cut.tolerance;
        let near = NEAR * (job.tool.radius() + distance);
        walls.avoid(mesh, distance, surface, &options, near);
    }
    walls
}

/// What the cutter's side, shank and holder keep clear of: the surface, on which there is stock, the rest of the part, and
/// what is avoided. All distances are larger than the judge asks for by [`SPARE`] tolerances and [`BETWEEN`].
pub fn above_end(job: &Job, prepared: &Prepared) -> AboveEnd {
    let Prepared { design, .. } = prepared;
    let tolerance = job.cut.tolerance;
    let spare = SPARE * tolerance + BETWEEN;
    let wide = job.clearance + spare;
    let stock = job.cut.allowance + job.cut.axial_depth;
    let kept = |mesh: &Part, wide: f64, slim: f64| KeptClear {
        hindrance: Hindrance::new(&mesh.positions, &mesh.faces),
        wide,
        slim,
    };
    let (positions, faces) = design.surface.triangles();
    let surface = Part { positions: positions.to_vec(), faces };
    let rest = design.part.without(&design.surface);
    let avoided = design.avoided.iter().map(|Avoided { mesh, distance, .. }| {
        let distance = distance + SPARE * tolerance;
        kept(mesh, distance + BETWEEN, distance)
    });
    let own = [kept(&surface, wide + stock, -tolerance), kept(&rest, wide, -tolerance)];
    let all = own.into_iter().chain(avoided).filter(|kept| !kept.hindrance.is_empty());
    AboveEnd::new(&job.assembly, all.collect())
}
