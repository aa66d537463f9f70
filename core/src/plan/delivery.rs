//! Flat paths → delivered ones: with their true removal rates, and without the material that the first passes leave.

use super::error::{PlanError, SLOWEST};
use super::load::chord;
use super::tilt::{axis_rule, tilted};
use crate::cutter_location::{LiftedSpan, PassOptions, ToolAxis};
use crate::flat_path::FlatPoint;
use crate::flatten::{Chart, Locator};
use crate::geometry::DVec3;
use crate::job::{Boundary, ForceControl, Inaccessible, Job};
use crate::link::{DeliverOptions, Delivered, Deliverer};
use crate::machine::Axes;
use crate::machine_time::fill_time;
use crate::removal::{
    self, Access, Columns, Coverage, Cutter, Feeds, Layer, Limit, Place, TooSlow, rated,
};
use crate::rest::{Places, Rest, RestOptions};
use crate::surface::{Part, Surface};
use crate::toolpath::Toolpath;
use crate::walls::{Sweep, WallOptions, Walls};

/// Fraction of the tolerance above the limit from which on a place is too high: samples may miss the highest point.
const TOO_HIGH: f64 = 0.7;
/// The same fraction from which on a place may be too high once further branches have changed which points the path
/// keeps.
const CLOSE: f64 = 0.0;
/// Fraction of the stock's depth above which the remaining material counts as untouched.
const TOUCHED: f64 = 0.98;

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
    pub cusp_limit: f64,
}

impl Delivery<'_> {
    fn layer(&self) -> Layer {
        Layer { allowance: self.job.cut.allowance, depth: self.job.cut.axial_depth }
    }

    fn cutter(&self) -> Cutter {
        Cutter { tool: self.job.tool, length: self.deliverer.options.pass.reach }
    }

    /// The plain passes with their true removal rates, for comparison with the path; `None` where the rates are not
    /// needed.
    pub fn plain(&self, flat: &[FlatPoint]) -> Result<Option<Toolpath>, PlanError> {
        if self.job.force.control == ForceControl::Off {
            return Ok(None);
        }
        let walls = self.deliverer.obstacles.without_part();
        let path = Deliverer { obstacles: &walls, ..self.deliverer }.path(flat, None, |_| {})?;
        Ok(Some(self.rated(&self.columns(), &path.toolpath, Feeds::LinksLimited)?.0))
    }

    /// The path.
    pub fn finished(
        &self,
        flat: &[FlatPoint],
        progress: &mut dyn FnMut(f64),
    ) -> Result<Finished, PlanError> {
        let columns = &self.columns();
        let (delivered, inaccessible) = self.with_branches(flat, columns, progress)?;
        let is_all_cut = self.is_all_cut(&delivered);
        let Delivered { toolpath, lifted, .. } = delivered;
        let (toolpath, mut coverage) = match self.job.force.control {
            ForceControl::Off if is_all_cut => {
                (toolpath, Coverage { area: self.surface.area(), ..Coverage::default() })
            }
            ForceControl::Off => {
                let coverage = self.coverage(columns, &toolpath, None);
                (toolpath, coverage)
            }
            _ => {
                let (toolpath, removed) = self.rated(columns, &toolpath, Feeds::Limited)?;
                let coverage = self.coverage(columns, &toolpath, Some(&removed));
                (toolpath, coverage)
            }
        };
        coverage.inaccessible_places.extend(inaccessible);
        Ok(Finished { toolpath, lifted, coverage })
    }

    fn columns(&self) -> Columns {
        Columns::new(self.surface, self.chart, self.job.nominal_side_step(), self.layer().top())
    }

    /// Columns within the tolerance of walls.
    fn rim(&self) -> Columns {
        let (job, top) = (self.job, self.layer().top());
        let apart = 0.1 * job.nominal_side_step();
        Columns::along_boundary(self.surface, self.chart, (job.cut.tolerance, apart), top)
    }

    /// The path at the nominal feeds, with branches over what it leaves too high: of the samples, and of the columns
    /// where the cutter did not fit or the columns are cut anyway.
    fn with_branches(
        &self,
        flat: &[FlatPoint],
        columns: &Columns,
        progress: &mut dyn FnMut(f64),
    ) -> Result<(Delivered, Vec<Place>), PlanError> {
        let places = Places {
            surface: self.surface,
            chart: self.chart,
            locator: self.locator,
            side_step: self.job.nominal_side_step(),
        };
        let mut rest = Rest::new(places, self.deliverer, self.rest_options());
        let mut delivered = rest.cut(self.deliverer.path(flat, None, progress)?)?;
        if !self.is_all_cut(&delivered) {
            let left = self.coverage(columns, &delivered.toolpath, None).never_covered_flat;
            delivered = rest.cut_at(&left, delivered)?;
        }
        refuse_inaccessible(self.job, &delivered.lifted)?;
        match delivered.lifted.iter().min_by(|a, b| a.raise.total_cmp(&b.raise)) {
            Some(LiftedSpan { place, raise, .. }) if delivered.toolpath.points.is_empty() => {
                Err(PlanError::FitsNowhere { place: *place, raise: *raise })
            }
            _ => Ok((delivered, rest.into_inaccessible())),
        }
    }

    /// Whether the cutter fits everywhere and no wall keeps it off: then samples show all that is left.
    fn is_all_cut(&self, Delivered { lifted, .. }: &Delivered) -> bool {
        lifted.is_empty() && self.deliverer.obstacles.rulings().is_empty()
    }

    /// What a path leaves of the columns; `removed`: what it removed, if that was recorded.
    fn coverage(
        &self,
        columns: &Columns,
        path: &Toolpath,
        removed: Option<&removal::Removed>,
    ) -> Coverage {
        self.with_access(path, |access| match removed {
            // The wall of a leaned flat end, smeared for the sake of the rate, would count as left.
            Some(removed) if self.job.tool.corner_radius() > 0.0 => {
                removal::coverage(columns, removed, access)
            }
            _ => removal::coverage(columns, &removal::remains(columns, access), access),
        })
    }

    /// Calls `work` with what determines where the cutter of a path can touch.
    fn with_access(&self, path: &Toolpath, work: impl FnOnce(&Access) -> Coverage) -> Coverage {
        work(&Access {
            pass: self.deliverer.options.pass,
            layer: self.layer(),
            obstacles: self.deliverer.obstacles,
            path,
            rim: (!self.deliverer.obstacles.rulings().is_empty()).then(|| self.rim()),
            follows_walls: self.job.path.boundary == Boundary::Wall,
            // Columns stand on facets, below the smooth surface by the chord error.
            cusp: self.cusp_limit + self.chord(),
            cell: self.job.nominal_side_step(),
            threads: self.deliverer.options.threads,
        })
    }

    /// What the path may leave.
    fn rest_options(&self) -> RestOptions {
        let job = self.job;
        // Wherever cusps may be as high as the stock, it is to be touched.
        let touched = TOUCHED * job.cut.axial_depth;
        RestOptions {
            side_step: job.nominal_side_step(),
            limit: (self.cusp_limit + TOO_HIGH * job.cut.tolerance).min(touched),
            close: (self.cusp_limit + CLOSE * job.cut.tolerance).min(touched),
            lag: tilted(job).map_or(0.0, |strip| strip.lag(0.5 * job.nominal_side_step())),
            has_open_rim: job.path.boundary == Boundary::Open,
        }
    }

    /// How far the facets may be off a smooth surface, mm.
    fn chord(&self) -> f64 {
        self.surface.parameters().map_or(0.0, |_| chord(self.job))
    }

    /// The path with its true removal rates and the resulting feeds; and what it removed.
    fn rated(
        &self,
        columns: &Columns,
        path: &Toolpath,
        feeds: fn(Limit) -> Feeds,
    ) -> Result<(Toolpath, removal::Removed), PlanError> {
        let job = self.job;
        let removed =
            columns.cut(path, self.cutter(), self.layer(), None, self.deliverer.options.threads);
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

pub fn deliver_options(job: &Job, rapid_plane: f64, threads: usize) -> DeliverOptions {
    DeliverOptions {
        pass: PassOptions {
            tool: job.tool,
            axis: axis_rule(job),
            axis_rate: f64::INFINITY,
            allowance: job.cut.allowance,
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

/// Height that clears part, stock and walls: above the top in three axes; in five, above the sphere about the rotary
/// centre (the origin) that contains the part in any position of the tables. `walls`: the corners of swept walls, mm.
pub fn rapid_plane(part: &Part, walls: &[DVec3], job: &Job) -> f64 {
    let reach = |p: &DVec3| match job.machine.axes {
        Axes::ThreeAxis => p.z,
        Axes::Xyzac => p.length(),
    };
    let top = |places: &[DVec3]| places.iter().map(reach).fold(f64::NEG_INFINITY, f64::max);
    let stock = job.cut.axial_depth + job.cut.allowance;
    (top(&part.positions) + stock).max(top(walls)) + job.machine.clearance
}

/// The walls along a job's surface, none at an open boundary, and what stands `beside` it.
pub fn walls(job: &Job, surface: &Surface, rest: &Part, beside: Option<&Part>) -> Walls {
    let options = WallOptions {
        sweep: match axis_rule(job) {
            ToolAxis::Fixed(axis) => Sweep::Axis(axis),
            ToolAxis::Lead(_) => Sweep::Normal,
        },
        height: job.path.wall_height,
        allowance: job.cut.allowance,
        spacing: WallOptions::spacing(job.tool.radius(), job.cut.tolerance),
    };
    let mut walls = match job.path.boundary {
        Boundary::Open => Walls::default(),
        Boundary::Wall => Walls::beside(surface, rest, &options),
    };
    if let Some(mesh) = beside {
        walls.add(mesh, surface, &options, 4.0 * job.tool.radius());
    }
    walls
}
