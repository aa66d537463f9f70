//! Ends of open passes on inner borders: how far each pass continues beyond its border.
//!
//! - *Joint*: such an end, and the straight flat continuation from there, on the surface.
//! - *Lag*: how far the edge of the strip trails behind the contact (`footprint`).
//!
//! A border that is met at a slant leaves uncut places on the acute side of the last half strip. The passes of the
//! neighbouring region machine some of them; each of the others is assigned to the joint that reaches it on the
//! shortest continuation, and every joint continues as far as its farthest place requires, plus the blend.

use super::options::LayoutOptions;
use super::region_mesh::RegionMesh;
use crate::flat_path::Terrain;
use crate::flatten::Locator;
use crate::footprint::Footprint;
use crate::geometry::DVec2;
use crate::job::{Job, Traverse};
use crate::level_set::{ClosingOptions, Gap, Pass, PassField, shortened, uncovered};
use crate::link::oriented;

/// Longest continuation beyond an inner border, half pass distances.
const LONGEST: f64 = 14.0;
/// Half pass distances by which a pass is assumed to end early: it machines beside its ends, but nothing beyond them.
const BEFORE_END: f64 = 1.0;
/// How much farther a flat bottom continues, half pass distances: its edge is not rounded.
const ROOM: f64 = 0.1;
/// Farthest place, passes, that a continuation machines.
const BESIDE: f64 = 0.5;

/// An end of an open pass on an inner border.
#[derive(Clone, Debug)]
pub(super) struct Joint {
    at: DVec2,
    /// Unit direction of the continuation.
    way: DVec2,
    /// How far the continuation stays on the surface, flat mm.
    room: f64,
    /// Half the distance of passes there, flat mm.
    half: f64,
    /// mm per flat mm.
    scale: f64,
    /// How far it continues, flat mm.
    by: f64,
}

/// The joints of a pass at its start and its end.
pub(super) type Joints = [Option<Joint>; 2];

impl Joint {
    /// At the end of a pass; `None` if that end lies on the boundary of the surface or the pass has no end.
    fn of(pass: &Pass, chart: &Locator, terrain: &dyn Terrain) -> Option<Self> {
        let [.., before, last] = pass.points[..] else { return None };
        let half = pass.half[1];
        if pass.is_closed || half == 0.0 {
            return None;
        }
        let way = (last - before).try_normalize()?;
        let room = reached(chart, last, last + way * (LONGEST * half)).distance(last);
        let scale = terrain.scale(last).unwrap_or(1.0);
        (room > half).then_some(Self { at: last, way, room, half, scale, by: 0.0 })
    }

    /// How far it has to continue to reach a place, flat mm; `None` where it does not pass beside it. `lag`: of the
    /// edge of the strip, flat mm per flat mm across.
    fn need(&self, place: &Gap, lag: impl Fn(f64) -> f64) -> Option<f64> {
        let far = self.way * (LONGEST * self.half + self.room);
        let (beside, t) = place.metric.nearest_on(place.at, self.at - far, self.at + far);
        let along = (2.0 * t - 1.0) * far.length();
        if beside > BESIDE || along <= -2.0 * self.half {
            return None;
        }
        let need = along + lag(place.at.distance(self.at + self.way * along));
        (need < self.room).then_some(need)
    }

    /// The part of the continuation beside which it counts as machined.
    fn line(&self) -> [DVec2; 2] {
        let by = (self.by - BEFORE_END * self.half).max(0.0);
        [self.at, self.at + self.way * by]
    }
}

/// How far the straight flat line from a point stays on the surface.
fn reached(chart: &Locator, from: DVec2, to: DVec2) -> DVec2 {
    let Ok(start) = chart.locate(from) else { return from };
    match chart.walk(start.face, from, to, |_, _| {}) {
        Ok(_) => to,
        Err(outside) => outside.uv,
    }
}

/// The joints of some passes, which no longer overrun there.
pub(super) fn joints(passes: &mut [Pass], chart: &Locator, terrain: &dyn Terrain) -> Vec<Joints> {
    let of = |pass: &mut Pass| {
        let joints = [oriented(pass, true), pass.clone()].map(|p| Joint::of(&p, chart, terrain));
        for (end, _) in joints.iter().enumerate().filter(|(_, j)| j.is_some()) {
            (pass.overrun[end], pass.half[end]) = (0.0, 0.0);
        }
        joints
    };
    passes.iter_mut().map(of).collect()
}

/// What passes are certain to machine, as flat segments: their points, and as much of their continuations as is
/// decided.
pub(super) fn machined(passes: &[Pass], joints: &[Joints]) -> Vec<[DVec2; 2]> {
    let mut lines = Vec::new();
    for (pass, joints) in passes.iter().zip(joints) {
        let mut points: Vec<DVec2> = pass.line().collect();
        for joint in [&joints[1], &joints[0]] {
            if let Some(joint) = joint {
                match joint.by > BEFORE_END * joint.half {
                    true => points.push(joint.line()[1]),
                    false => points = shortened(points, BEFORE_END * joint.half - joint.by),
                }
            }
            points.reverse();
        }
        lines.extend(points.windows(2).map(|w| [w[0], w[1]]));
    }
    lines
}

/// Resets how far joints continue.
pub(super) fn reset(joints: &mut [Joints]) {
    joints.iter_mut().flatten().flatten().for_each(|joint| joint.by = 0.0);
}

/// The continuations of some passes, as far as they machine beside them.
pub(super) fn ways_on(joints: &[Joints]) -> impl Iterator<Item = [DVec2; 2]> + '_ {
    joints.iter().flatten().flatten().map(Joint::line).filter(|[a, b]| a != b)
}

/// Decides how far the joints of a region continue; `all`: what the passes of all regions machine.
pub(super) fn decide(
    joints: &mut [Joints],
    (region_mesh, field): (&RegionMesh, &PassField),
    all: &[[DVec2; 2]],
    options: &LayoutOptions,
    closing: &ClosingOptions,
) {
    let lags = Lags::of(options);
    let mut ends: Vec<(bool, &mut Joint)> = Vec::new();
    for [start, end] in joints.iter_mut() {
        ends.extend(start.iter_mut().map(|j| (false, j)));
        ends.extend(end.iter_mut().map(|j| (true, j)));
    }
    let mut needs = vec![0.0f64; ends.len()];
    for place in uncovered(&region_mesh.fine, field, all, closing) {
        let rated = ends.iter().enumerate().filter_map(|(i, (is_end, joint))| {
            let lag = |across: f64| lags.at(*is_end, across * joint.scale) / joint.scale;
            joint.need(&place, lag).map(|need| (need, i))
        });
        if let Some((need, i)) = rated.min_by(|a, b| a.0.total_cmp(&b.0)) {
            needs[i] = needs[i].max(need);
        }
    }
    let blend = options.job.regions.blend;
    for ((_, joint), need) in ends.iter_mut().zip(needs) {
        let room = if lags.footprint.lags() { ROOM * joint.half } else { 0.0 };
        joint.by = (need + room + blend / joint.scale).min(joint.room);
    }
}

/// Extends passes as their joints have decided.
pub(super) fn run_on(passes: &mut [Pass], joints: &[Joints]) {
    for (pass, joints) in passes.iter_mut().zip(joints) {
        for joint in [&joints[1], &joints[0]] {
            if let Some(joint) = joint.as_ref().filter(|j| j.by > 0.0) {
                pass.points.push(joint.at + joint.way * joint.by);
            }
            *pass = oriented(pass, true);
        }
    }
}

/// The lag of the job's cutter.
struct Lags {
    footprint: Footprint,
    /// Whether a pass is cut toward its last point, and whether toward its first.
    ways: [bool; 2],
}

impl Lags {
    fn of(options: &LayoutOptions) -> Self {
        let job @ Job { path, .. } = options.job;
        let is_forward = job.keeps_material_on_right();
        let ways = match path.traverse {
            Traverse::OneWay => [is_forward, !is_forward],
            Traverse::Zigzag => [true, true],
        };
        Self { footprint: job.footprint(), ways }
    }

    /// At a given distance across, mm: how much farther the contact must go, mm.
    fn at(&self, is_end: bool, across: f64) -> f64 {
        let lag = self.footprint.lag(across);
        // A pass that is cut from here begins with what lies behind its contact.
        if self.ways[usize::from(!is_end)] { lag } else { -lag }
    }
}
