//! A branch over a high place: where it leaves the path, where it runs, and its insertion.

use super::context::Rest;
use super::high::High;
use super::samples::Sample;
use crate::cutter_location::is_way_clear;
use crate::flat_path::FlatPoint;
use crate::geometry::{DVec2, OrderBy};
use crate::link::{DeliverError, Delivered, Deliverer, OnSurface};
use crate::toolpath::{MoveKind, PathPoint};
use core::ops::Range;
use std::collections::BTreeSet;

/// How far beside the line through the highest sample, and how far from one another along it, side steps, others belong to
/// its branch.
const GROUP: [f64; 2] = [0.25, 1.5];
/// Greatest length of a branch to either side of the highest sample, side steps. Smaller: long ridges get several
/// branches, each with a way out and back.
const LONGEST: f64 = 96.0;
/// How far a branch continues ahead of the last sample, side steps: the edge of the strip trails behind.
const AHEAD: f64 = 0.05;
/// How far inside the boundary branches along it run, side steps.
const INSIDE: f64 = 0.15;
/// Fraction of the distance to the boundary that a branch may continue. More: rounding moves it outside.
const WITHIN: f64 = 0.98;
/// Moves that are looked through together. Fewer: more boxes; more: more moves near a place.
const RUN: usize = 64;
/// What rounding may add to the square of a distance, times.
const ROUNDED: f64 = 1.0 + 1e-9;
/// Places of a path less than this fraction of the tolerance apart are one.
const SAME: f64 = 0.1;

/// The place of a path that is nearest to a high place: on the move to a point.
#[derive(Copy, Clone, Debug)]
struct Anchor {
    /// Index of the point.
    to: usize,
    /// Fraction of the move before it.
    part: f64,
    /// Where that is, and the direction in which the cutter faces there.
    place: OnSurface,
}

/// A cut over high places.
pub(super) enum Branch {
    /// From a place of the path and back to it, on the surface.
    On(Anchored),
    /// From above and up again: its flat path, and what it is on the surface.
    Apart(Vec<FlatPoint>, Delivered),
}

/// A branch that leaves from a place of the path.
pub(super) struct Anchored {
    anchor: Anchor,
    path: Delivered,
}

impl Branch {
    /// Where the cutter goes.
    pub fn path(&self) -> &Delivered {
        match self {
            Self::On(Anchored { path, .. }) | Self::Apart(_, path) => path,
        }
    }
}

impl Rest<'_> {
    /// A branch along the samples around the worst one, and the samples that it is to lower; no branch where the
    /// cutter cannot go there; `None` where the path has no place to leave from.
    pub(super) fn branch(
        &self,
        worst: usize,
        high: &High,
        moves: &Moves,
    ) -> Option<(Option<Branch>, Vec<usize>)> {
        let (sample, path) = (&self.samples[worst], moves.path);
        let anchor = moves.nearest(sample.flat)?;
        let facing = anchor.place.facing;
        // The last time it goes across.
        let heading = if sample.branches < 2 { facing } else { facing.perp() };
        let (line, aimed) = self.line(worst, high, heading);
        let model = &path.toolpath.points[anchor.to];
        let point = |at: DVec2, kind: MoveKind, overrun: f64| FlatPoint {
            at,
            height: 0.0,
            kind,
            pass: model.pass,
            region: model.region,
            feed: model.feed,
            mrr: model.mrr,
            alpha: model.alpha,
            length: 0.0,
            heading: Some(facing),
            overrun,
        };
        let Line { rear, front, overrun } = line;
        let there =
            [(anchor.place.flat, 0.0), (rear, 0.0), (front, overrun), (anchor.place.flat, 0.0)];
        let flat = there.map(|(at, overrun)| point(at, MoveKind::Cut, overrun));
        let leave = path.toolpath.points[anchor.to - 1].toward(model, anchor.part);
        let on = self.deliverer.on_surface(&flat, leave.axis).filter(|branch| {
            let points = &branch.toolpath.points;
            let is_joined = |p: &PathPoint| self.is_way_clear(&leave, p);
            points.first().is_some_and(is_joined) && points.last().is_some_and(is_joined)
        });
        if let Some(path) = on {
            return Some((Some(Branch::On(Anchored { anchor, path })), aimed));
        }
        let pass = path.toolpath.points.last().map_or(0, |p| p.pass + 1);
        let ends = [(rear, MoveKind::Rapid), (rear, MoveKind::Link), (front, MoveKind::Cut)];
        let flat = ends.map(|(at, kind)| FlatPoint {
            pass,
            height: if kind == MoveKind::Rapid { self.options.side_step } else { 0.0 },
            ..point(at, kind, 0.0)
        });
        let apart = self.deliverer.path(&flat, None, |_| {}).ok();
        let apart = apart.filter(|path| !path.toolpath.points.is_empty());
        Some((apart.map(|path| Branch::Apart(flat.to_vec(), path)), aimed))
    }

    /// Whether the cutter may go straight from where it leaves the path to an end of a branch. They differ a little
    /// where a pass turns the axis more slowly.
    fn is_way_clear(&self, leave: &PathPoint, end: &PathPoint) -> bool {
        let Deliverer { obstacles, options, .. } = &self.deliverer;
        is_way_clear((leave.tip, leave.axis), (end.tip, end.axis), &options.pass, obstacles)
    }

    /// Where a branch runs that lowers the worst of the high samples and those around it, which are returned, too.
    fn line(&self, worst: usize, high: &High, heading: DVec2) -> (Line, Vec<usize>) {
        let sample = &self.samples[worst];
        // Where that was in vain, over the very place.
        let origin = match sample.branches {
            0 if sample.beside == DVec2::ZERO => self.places.inside(sample, INSIDE),
            _ => sample.flat + sample.beside,
        };
        let scale = sample.scale;
        let steps = scale / self.options.side_step;
        let along = |i: usize| {
            let Sample { flat, beside, .. } = self.samples[i];
            let way = (flat + beside - origin) * steps;
            (way.dot(heading), way.perp_dot(heading).abs())
        };
        let [beside, ahead] = GROUP;
        let mut aimed = BTreeSet::from([worst]);
        // How far the samples continue forward or backward, none missing.
        let mut end = |sign: f64| {
            let mut far = 0.0;
            loop {
                let at = origin + heading * (sign * far / steps);
                let radius = (ahead * ahead + beside * beside).sqrt() / steps;
                let mut next = far;
                for i in high.within_flat(at, radius, worst) {
                    let (along, across) = along(i);
                    if across <= beside && (sign * along - far).abs() <= ahead {
                        // What lies farther on gets a branch of its own if this one is in vain there.
                        if far == 0.0 {
                            aimed.insert(i);
                        }
                        next = next.max(sign * along);
                    }
                }
                if next == far || next >= LONGEST {
                    return sign * next;
                }
                far = next;
            }
        };
        let (front, rear) = (end(1.0), end(-1.0));
        let aimed = aimed.into_iter().collect();
        let at = |along: f64| origin + heading * (along / steps);
        let (end, is_at_boundary) = self.within(origin, at(front + AHEAD));
        let overrun = if is_at_boundary { self.options.lag } else { 0.0 };
        let ahead = (end - origin).dot(heading);
        // Beyond the boundary it goes on as before, so that there is to be as much before.
        let before = ahead - overrun / scale;
        let (begin, _) = self.within(origin, at(rear.min(before * steps)));
        (Line { rear: begin, front: end, overrun }, aimed)
    }

    /// The end of the straight flat line from a place of the chart, or the last point of it on the chart, and whether
    /// it leaves the chart.
    fn within(&self, from: DVec2, to: DVec2) -> (DVec2, bool) {
        let Ok(start) = self.places.locator.locate(from) else { return (from, true) };
        match self.places.locator.walk(start.face, from, to, |_, _| {}) {
            Ok(_) => (to, false),
            Err(outside) => (from.lerp(outside.uv, WITHIN), true),
        }
    }
}

/// A straight flat line over high places.
struct Line {
    /// Where it begins.
    rear: DVec2,
    /// Where it ends.
    front: DVec2,
    /// How far it continues beyond the boundary there, mm.
    overrun: f64,
}

/// The moves of a path by runs of them that lie together, for nearest places.
pub(super) struct Moves<'a> {
    /// The path.
    path: &'a Delivered,
    /// Numbers of the points at which moves end, and the flat box around those moves.
    runs: Vec<(Range<usize>, DVec2, DVec2)>,
}

impl<'a> Moves<'a> {
    pub(super) fn of(path: &'a Delivered) -> Self {
        let count = path.places.len();
        let run = |first: usize| {
            let moves = first..(first + RUN).min(count);
            let places = path.places[first - 1..moves.end].iter().flatten();
            let (low, high) = places.fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(l, h), p| {
                (l.min(p.flat), h.max(p.flat))
            });
            (moves, low, high)
        };
        let runs = (1..count).step_by(RUN).map(run).filter(|(_, low, high)| low.x <= high.x);
        Self { path, runs: runs.collect() }
    }

    /// The place of a pass nearest to a flat place; of several the first.
    fn nearest(&self, place: DVec2) -> Option<Anchor> {
        let away = |(_, low, high): &(Range<usize>, DVec2, DVec2)| {
            place.distance_squared(place.clamp(*low, *high))
        };
        let least = |runs: &mut dyn Iterator<Item = &(Range<usize>, DVec2, DVec2)>| {
            let mut best: Option<(f64, Anchor)> = None;
            for run in runs {
                if best.is_none_or(|(least, _)| away(run) <= least * ROUNDED) {
                    self.nearest_of(run.0.clone(), place, &mut best);
                }
            }
            best
        };
        // A bound first, so that few runs are gone through.
        let by_distance = |a: &&(Range<usize>, DVec2, DVec2), b: &&(Range<usize>, DVec2, DVec2)| {
            away(a).total_cmp(&away(b))
        };
        let bound = least(&mut self.runs.iter().min_by(by_distance).into_iter());
        let bound = bound.map_or(f64::INFINITY, |(square, _)| square * ROUNDED);
        let best = least(&mut self.runs.iter().filter(|run| away(run) <= bound));
        best.map(|(_, anchor)| anchor)
    }

    fn nearest_of(&self, moves: Range<usize>, place: DVec2, best: &mut Option<(f64, Anchor)>) {
        let path = self.path;
        for (to, point) in moves.clone().zip(&path.toolpath.points[moves]) {
            let (Some(from), Some(end), MoveKind::Cut) =
                (path.places[to - 1], path.places[to], point.kind)
            else {
                continue;
            };
            let way = end.flat - from.flat;
            // Beyond the chart the place is that where it is left.
            if way == DVec2::ZERO || end.facing == DVec2::ZERO || !(from.is_exact && end.is_exact) {
                continue;
            }
            let part = ((place - from.flat).dot(way) / way.length_squared()).clamp(0.0, 1.0);
            let flat = from.flat + way * part;
            let square = flat.distance_squared(place);
            if best.is_none_or(|(least, _)| square < least) {
                let place = OnSurface { flat, ..end };
                *best = Some((square, Anchor { to, part, place }));
            }
        }
    }
}

/// The path with branches inserted into its moves, and rest passes at its end.
pub(super) fn inserted(
    path: Delivered,
    branches: Vec<Branch>,
    deliverer: &Deliverer,
) -> Result<Delivered, DeliverError> {
    let (mut on, mut apart) = (Vec::new(), Vec::new());
    for branch in branches {
        match branch {
            Branch::On(anchored) => on.push(anchored),
            Branch::Apart(flat, _) => apart.extend(flat),
        }
    }
    let place = |b: &Anchored| (b.anchor.to, b.anchor.part);
    on.order_by(|a, b| place(a).0.cmp(&place(b).0).then(place(a).1.total_cmp(&place(b).1)));
    let same = SAME * deliverer.options.pass.tolerance;
    let mut next = on.into_iter().peekable();
    let mut out = Delivered { lifted: path.lifted, ..Delivered::default() };
    let mut before: Option<PathPoint> = None;
    for (i, (point, place)) in path.toolpath.points.into_iter().zip(path.places).enumerate() {
        while let Some(branch) = next.next_if(|b| b.anchor.to == i && b.anchor.part < 1.0) {
            let leave = before.map_or(point, |from| from.toward(&point, branch.anchor.part));
            insert(&mut out, leave, branch, same);
        }
        out.push(point, place);
        while let Some(branch) = next.next_if(|b| b.anchor.to == i) {
            insert(&mut out, point, branch, same);
        }
        before = Some(point);
    }
    if !apart.is_empty() {
        let last = out.toolpath.points.last().copied();
        let Delivered { toolpath, places, lifted } = deliverer.path(&apart, last, |_| {})?;
        let skip = usize::from(last.is_some());
        for (point, place) in toolpath.points.into_iter().zip(places).skip(skip) {
            out.push(point, place);
        }
        out.lifted.extend(lifted);
    }
    Ok(out)
}

/// Goes to `leave`, along a branch and back to it. Places less than `same` mm apart are one.
fn insert(out: &mut Delivered, leave: PathPoint, branch: Anchored, same: f64) {
    let Anchored { anchor: Anchor { place, .. }, path: Delivered { toolpath, places, lifted } } =
        branch;
    let leave = PathPoint { flat: Some(place.flat), ..leave };
    let is_there = |p: &PathPoint| p.tip.distance(leave.tip) <= same;
    if !out.toolpath.points.last().is_some_and(is_there) {
        out.push(leave, Some(place));
    }
    // It begins and ends on the surface, the straight move that it leaves may be a little above or below.
    let points = || toolpath.points.iter().zip(&places);
    let is_away = |(p, _): (&PathPoint, _)| !is_there(p);
    let skipped = points().position(is_away).unwrap_or(0);
    let kept = points().rposition(is_away).map_or(0, |last| last + 1 - skipped);
    points().skip(skipped).take(kept).for_each(|(point, place)| out.push(*point, *place));
    out.push(leave, Some(place));
    out.lifted.extend(lifted);
}
