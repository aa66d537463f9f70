//! A path in the flat plane → the path of the cutter, and what is known about it.

use super::delivery::{Delivery, Finished, Plain};
use super::error::PlanError;
use super::laid::{Ground, Laid};
use super::plane::{FlatCut, Plane};
use super::prepared::Prepared;
use super::stage::Stage;
use crate::cutter_location::LiftedSpan;
use crate::geometry::DVec3;
use crate::hub::ChannelFigures;
use crate::job::{ForceControl, Job, Stepover};
use crate::level_set::ClosingReport;
use crate::machine_time::fill_time;
use crate::mesh::{FaceId, VertexId};
use crate::regions::tensor::Topology;
use crate::regions::{self, Divided, Layout};
use crate::removal::{Beyond, Coverage, Cutter, Earlier, beyond};
use crate::strips::CuspBudget;
use crate::toolpath::{Planar, Toolpath};
use std::sync::Arc;

/// How often trochoids that cut too much at once are laid again.
const ROUNDS: usize = 12;
/// How often they are without cutting any less, and how often while the worst place stays just as it is: the loops do not
/// come there.
const IDLE_ROUNDS: usize = 5;
const SAME_ROUNDS: usize = 3;
/// Times the bound: what passes cut above this is not brought below by branches over what they leave.
const HOPELESS: f64 = 1.1;

/// A plan and what is known about it.
#[derive(Debug)]
pub struct Planned {
    /// The surface and its flat map.
    pub prepared: Arc<Prepared>,
    /// The most concave place; `None` where nothing is concave.
    pub tightest: Option<Tightest>,
    /// The passes in figures.
    pub passes: Passes,
    /// The delivered path.
    pub toolpath: Toolpath,
    /// The path of the plain passes, where the removal rate is limited.
    pub plain: Option<Plain>,
    /// Height of the rapids, mm.
    pub rapid_plane: f64,
    /// Where the cutter had to be lifted.
    pub lifted: Vec<LiftedSpan>,
    /// What the path leaves uncut.
    pub coverage: Coverage,
    /// How high cusps may be.
    pub cusps: CuspBudget,
    /// The plane's prediction for each point of the path; empty where rates are not needed.
    pub planar: Vec<Option<Planar>>,
    /// The channels of a hub, if it is a path through them.
    pub channels: Option<ChannelFigures>,
}

/// The passes of a plan in figures.
#[derive(Debug)]
pub struct Passes {
    /// Number of passes.
    pub count: usize,
    /// Number of rings in the longest chain of nested rings.
    pub depth: usize,
    /// Trochoid loops.
    pub loops: usize,
    /// Whether they bite no more than the full feed allows, although the feed may be reduced: larger ones broke a limit.
    pub are_loops_small: bool,
    /// Shortest length that passes on the surface can have, mm.
    pub length_floor: f64,
    /// Share of the area on which passes are at least 0.9 of the allowed side step apart.
    pub even_share: f64,
    /// The gaps between passes that were closed; places are flat.
    pub closing: ClosingReport,
    /// The regions; `None` for an undivided surface.
    pub divided: Option<Divided>,
    /// Where the best feed direction is undefined, if the surface is divided by it.
    pub topology: Option<Topology>,
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

impl Planned {
    /// What its path has cut, for the operations after it.
    pub fn earlier(&self, job: &Job) -> Earlier {
        Earlier {
            path: self.toolpath.clone(),
            cutter: Cutter { tool: job.tool, length: job.cutter_length() },
            cusps: self.cusps.limit,
            allowance: job.cut.allowance,
            bridged: self.prepared.aside.as_ref().map_or(0.0, |aside| aside.deepest_bridged),
        }
    }
}

impl Laid<'_> {
    /// Delivers the path. `progress`: as for [`Prepared::new`].
    ///
    /// # Errors
    /// As [`Laid::new`].
    pub fn planned(self, progress: &mut dyn FnMut(Stage, f64)) -> Result<Planned, PlanError> {
        let Self { ground, flat, plain } = self;
        progress(Stage::Locate, 0.0);
        let (flat, finished, are_loops_small) = ground.on(|plane, delivery| {
            let (plain, control) = (plain.as_ref(), ground.job.force.control);
            let found = within_bounds(&ground, (plane, delivery), (flat, control), plain, progress);
            match (found, plain) {
                (Err(why @ PlanError::TooThick { .. }), Some(plain))
                    if control == ForceControl::Fastest =>
                {
                    // Slowed loops broke a limit; smaller ones at the full feed may keep it.
                    let control = ForceControl::Trochoid;
                    let cut = |control: ForceControl| {
                        ground.cut_within((plane, control), plain, &[], &mut |_| {})
                    };
                    let Some(flat) = cut(control) else { return Err(why) };
                    // Where the feed cannot be reduced they are the same.
                    if cut(ForceControl::Fastest).is_some_and(|tried| tried.points == flat.points) {
                        return Err(why);
                    }
                    let on = (plane, delivery);
                    within_bounds(&ground, on, (flat, control), Some(plain), progress)
                        .map(|(flat, finished)| (flat, finished, true))
                        .map_err(|_| why)
                }
                (found, _) => found.map(|(flat, finished)| (flat, finished, false)),
            }
        })?;
        let Finished { mut toolpath, lifted, coverage } = finished;
        let job = ground.job;
        fill_time(&mut toolpath, &job.tool, &job.machine);
        let planar = match job.force.control {
            ForceControl::Off => Vec::new(),
            // The plane knows nothing of what was cut before.
            _ if ground.is_cut_before() => Vec::new(),
            _ => ground.on(|plane, _| plane.predicted(&toolpath)),
        };
        for (p, planar) in toolpath.points.iter_mut().zip(&planar) {
            p.alpha = planar.map_or(0.0, |planar| planar.alpha);
        }
        Ok(Planned {
            prepared: Arc::clone(ground.prepared),
            tightest: Tightest::of(job, ground.prepared),
            toolpath,
            plain,
            rapid_plane: ground.options.rapid_plane,
            lifted,
            coverage,
            cusps: ground.cusps,
            planar,
            channels: None,
            passes: Passes::of(ground, flat.loops, are_loops_small),
        })
    }
}

/// The finished path. Where trochoids turn out to cut more at once than may be, since the real cutter is no disc, they
/// are laid again with smaller bites; branches over what passes leave come last.
///
/// # Errors
/// [`PlanError::TooThick`] where that does not help.
fn within_bounds(
    ground: &Ground,
    (plane, delivery): (&Plane, &Delivery),
    (mut flat, control): (FlatCut, ForceControl),
    plain: Option<&Plain>,
    progress: &mut dyn FnMut(Stage, f64),
) -> Result<(FlatCut, Finished), PlanError> {
    let (job, bounds) = (ground.job, ground.job.bounds());
    let is_bound = job.force.control != ForceControl::Off && bounds.bound_sections();
    let mut excesses = Vec::new();
    let mut rounds = Rounds::default();
    // Laid again, if that may help a path that breaks a bound.
    let mut smaller = |path: &Toolpath, loops: usize, worst: f64| {
        let may_help = rounds.may_help(worst) && loops > 0 && excesses.len() < ROUNDS;
        let plain = plain.filter(|_| may_help)?;
        excesses.push(plane.beyond(path, &bounds));
        ground.cut_within((plane, control), plain, &excesses, &mut |_| {})
    };
    let too_thick = |beyond: Beyond| PlanError::TooThick {
        place: beyond.place,
        engaged: bounds.teeth.engaged(beyond.section),
        most: bounds.most_engaged,
        per_tooth: bounds.teeth.per_tooth(beyond.feed),
        least: bounds.least_per_tooth,
        remedy: thinner(job, bounds.least_per_tooth > 0.0),
    };
    let mut round = 0;
    loop {
        let done = f64::from(round) / ROUNDS as f64;
        let passes = delivery.delivered(&flat.points, &mut |p| match round {
            0 => progress(Stage::Locate, p),
            _ => progress(Stage::Loops, done),
        })?;
        round += 1;
        // Branches take long to find: the passes are to keep the bounds before.
        if is_bound && flat.loops > 0 {
            let path = delivery.limited(&passes.toolpath)?;
            if let Some(worst) = beyond(&path, &bounds) {
                match smaller(&path, flat.loops, worst.excess) {
                    Some(again) => {
                        flat = again;
                        continue;
                    }
                    None if worst.excess > HOPELESS => return Err(too_thick(worst)),
                    None => {}
                }
            }
        }
        progress(Stage::Rest, 0.0);
        let finished = delivery.finished(passes)?;
        let Some(beyond) = is_bound.then(|| beyond(&finished.toolpath, &bounds)).flatten() else {
            return Ok((flat, finished));
        };
        flat = smaller(&finished.toolpath, flat.loops, beyond.excess)
            .ok_or_else(|| too_thick(beyond))?;
    }
}

/// How it goes with trochoids that are laid again and again.
struct Rounds {
    least: f64,
    idle: usize,
    last: f64,
    same: usize,
}

impl Default for Rounds {
    fn default() -> Self {
        Self { least: f64::INFINITY, idle: 0, last: f64::INFINITY, same: 0 }
    }
}

impl Rounds {
    /// Whether another round may help; `worst`: by which factor the last one breaks a bound.
    fn may_help(&mut self, worst: f64) -> bool {
        if worst < self.least {
            (self.least, self.idle) = (worst, 0);
        }
        self.idle += 1;
        self.same = if worst == self.last { self.same + 1 } else { 0 };
        self.last = worst;
        self.idle <= IDLE_ROUNDS && self.same < SAME_ROUNDS
    }
}

/// What may help a job whose path breaks a limit on engagement or feed per tooth; `is_slow`: on the latter.
fn thinner(job: &Job, is_slow: bool) -> String {
    let pattern = job.path.pattern;
    let step = match job.cut.stepover {
        Stepover::Fixed(_) => "cut.stepover",
        Stepover::Scallop(_) => "cut.scallop",
    };
    let (tried, first, loops) = match job.force.control {
        ForceControl::Trochoid | ForceControl::Fastest => {
            let least = ", or let loops be smaller (trochoid.min_radius)";
            ("neither a slower feed nor trochoids keep that".to_owned(), "", least)
        }
        _ if pattern.takes_trochoids(job.footprint().lags()) => {
            let first = "let passes take trochoids (force.control = \"fastest\"), or ";
            ("a slower feed does not keep that".to_owned(), first, "")
        }
        _ => {
            let name = pattern.name();
            let tried =
                format!("a slower feed does not keep that, and {name:?} takes no trochoids");
            (tried, "give path.pattern = \"contour\", which does, or ", "")
        }
    };
    let rate = if is_slow { ", or raise the limit on rate, power or force" } else { "" };
    format!("{tried}: {first}reduce cut.axial_depth or {step}, or relax the limit{loops}{rate}")
}

impl Passes {
    fn of(ground: Ground, loops: usize, are_loops_small: bool) -> Self {
        let Ground { region_meshes, layouts, order, .. } = ground;
        let divided =
            |(regions, undivided)| Divided::of(regions, order, &region_meshes, &layouts, undivided);
        Self {
            count: layouts.iter().map(|l| l.passes.len()).sum(),
            depth: layouts.iter().map(|l| l.depth).max().unwrap_or(0),
            loops,
            are_loops_small,
            length_floor: ground.length_floor,
            even_share: regions::even_share(&region_meshes, &layouts),
            closing: ClosingReport::joined(layouts.iter().map(|l: &Layout| l.closing.clone())),
            divided: ground.regions.map(divided),
            topology: ground.topology,
        }
    }
}

impl Tightest {
    /// `None` where nothing is concave.
    pub(super) fn of(job: &Job, prepared: &Prepared) -> Option<Self> {
        let (surface, operators) = (&prepared.surface, prepared.curvature.operators());
        let k_min = |i: usize| operators[i].principal().0;
        let count = surface.positions().len();
        let vertex = (0..count).min_by(|&a, &b| k_min(a).total_cmp(&k_min(b)))?;
        let k = k_min(vertex);
        let k_tool = job.footprint().k_tool();
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
