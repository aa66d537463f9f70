//! Rings cut one after the other in the plane, with trochoids where the limit requires them.
//!
//! *Trial*: a ring is first cut without trochoids; only if that exceeds the limit, both in the plane and in the
//! simulation of plain passes, is it undone and cut again with trochoids on the stretches that exceed it.

use super::group::{Group, LONGEST_LINK, SLANT, oriented};
use super::order::{Precedence, Sequence};
use crate::engagement::Simulation;
use crate::flat_path::FlatPoint;
use crate::geometry::{DVec2, OrderBy};
use crate::job::{ForceControl, Links, RingOrder};
use crate::level_set::{Branch, Pass};
use crate::toolpath::MoveKind;
use crate::trochoid::{self, BranchRef, Corridor, Loops, Span};

/// Over-engaged stretches closer than this, as a fraction of the cutter radius, are merged.
const JOIN: f64 = 1.0;
/// Over-engaged stretches are extended by this fraction of the cutter radius at both ends.
const WIDEN: f64 = 0.5;
/// A link on the surface that would have to be slower than this fraction of the feed is not used.
const SLOWEST_LINK: f64 = 0.05;

/// Least true removal rate over that of the disc. Lower: where a slot is shallow on one side only, loops, which cut in
/// front, are slowed; higher: more loops.
const LEAST_SHARE: f64 = 0.5;

/// How many levels rings are apart between which loops run.
const NEIGHBOURS: core::ops::Range<f64> = 0.75..1.5;

/// How rings are cut and joined.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct CutOptions {
    /// Order of the rings.
    pub order: RingOrder,
    /// How they are joined.
    pub links: Links,
    /// What is done where the limit is exceeded.
    pub control: ForceControl,
    /// Loops, where these are inserted.
    pub loops: Loops,
}

/// What simulated paths truly cut near a flat place.
#[derive(Copy, Clone)]
pub struct Measured<'a> {
    /// The rate of plain passes, mm³/s, where that exceeds the limit.
    pub plain: &'a dyn Fn(DVec2) -> Option<f64>,
    /// The section of the path with trochoids over the largest allowed, where that is more than 1; 1 elsewhere.
    pub beyond: &'a dyn Fn(DVec2) -> f64,
}

/// Cuts the rings of all groups, one group after the other; `progress` is called with the fraction done. Returns the number of trochoid loops.
pub fn cut_passes(
    simulation: &mut Simulation,
    groups: &[Group],
    options: &CutOptions,
    measured: Measured,
    mut progress: impl FnMut(f64),
) -> usize {
    let mut loops = 0;
    let all: usize = groups.iter().map(|g| g.passes.len()).sum();
    let mut done = 0;
    for (region, group) in (0..).zip(groups) {
        simulation.begin_region(region);
        cut_group(simulation, group, (options, measured), &mut loops, || {
            done += 1;
            progress(done as f64 / all as f64);
        });
    }
    loops
}

/// Cuts the rings of a group; `on_ring` is called after each.
fn cut_group(
    simulation: &mut Simulation,
    Group { passes: rings, precedence }: &Group,
    (options, measured): (&CutOptions, Measured),
    loops: &mut usize,
    mut on_ring: impl FnMut(),
) {
    let mut sequence = Sequence::new(precedence);
    let mut last = None;
    // Rings come with higher values on their right; turned so that the stock is on the side that the
    // cut direction asks for.
    let stock_is_higher = options.order == RingOrder::OutsideIn;
    let reverse = stock_is_higher != (options.loops.hand > 0.0);
    let distance = |simulation: &Simulation, r: usize| {
        let from = simulation.at();
        let points = rings[r].points.iter();
        points.map(|p| (*p - from).length_squared()).fold(f64::INFINITY, f64::min)
    };
    while let Some(index) = sequence.next_nearest(last, |r| distance(simulation, r)) {
        let task = PassTask {
            options,
            measured,
            rings,
            precedence,
            index,
            has_cleared_side: !precedence.before(index).is_empty(),
            is_last: precedence.after(index).is_empty(),
        };
        *loops += task.cut(simulation, &oriented(&rings[index], reverse));
        simulation.next_pass();
        last = Some(index);
        on_ring();
    }
}

/// The moves along a ring, with the branches that leave from their ends.
struct Course<'a> {
    start: DVec2,
    moves: Vec<FlatPoint>,
    /// Index of the move and the branch.
    branches: Vec<(usize, &'a Branch)>,
}

impl Course<'_> {
    /// Turned so that it does not begin inside an over-engaged stretch, unless all of it is one.
    fn begun_outside(self, over: &[Option<f64>]) -> (Self, Vec<Option<f64>>) {
        let n = self.moves.len();
        let first_clear = over.iter().position(Option::is_none).unwrap_or(0);
        if first_clear == 0 || over[n - 1].is_none() {
            return (self, over.to_vec());
        }
        let turn = |i: usize| (i + first_clear) % n;
        let back = |(i, branch): (usize, _)| ((i + n - first_clear) % n, branch);
        let turned = Self {
            start: self.moves[first_clear - 1].at,
            moves: (0..n).map(|i| self.moves[turn(i)]).collect(),
            branches: self.branches.into_iter().map(back).collect(),
        };
        (turned, (0..n).map(|i| over[turn(i)]).collect())
    }

    /// The branches that leave at the end of a move.
    fn branches_after(&self, index: usize) -> impl Iterator<Item = &Branch> + '_ {
        self.branches.iter().filter(move |(i, _)| *i == index).map(|(_, branch)| *branch)
    }

    /// The branches of a stretch, for loops that start at the end of the move before it.
    fn branches(&self, stretch: &Stretch) -> Vec<BranchRef<'_>> {
        let inside = self.branches.iter().filter(|(i, _)| stretch.moves.contains(i));
        let mut branches: Vec<BranchRef> = inside
            .map(|(i, branch)| BranchRef {
                at: i + 1 - stretch.moves.start,
                points: &branch.points,
            })
            .collect();
        branches.order_by_key(|b| b.at);
        branches
    }
}

/// One ring to be cut.
struct PassTask<'a> {
    options: &'a CutOptions,
    measured: Measured<'a>,
    /// All rings of the group, and which of them it is.
    rings: &'a [Pass],
    precedence: &'a Precedence,
    index: usize,
    has_cleared_side: bool,
    is_last: bool,
}

impl PassTask<'_> {
    /// Cuts it; returns the number of trochoid loops.
    fn cut(&self, simulation: &mut Simulation, ring: &Pass) -> usize {
        let first = (!simulation.has_begun()).then(|| with_middle_of_longest_side(ring));
        let ring = first.as_ref().unwrap_or(ring);
        let start = start_index(simulation, &ring.points, &self.options.loops);
        let (before, from) = ring.points.split_at(start);
        let closed: Vec<DVec2> = from.iter().chain(before).chain(&from[..1]).copied().collect();
        let mark = simulation.mark();
        self.reach(simulation, closed[0], closed[1] - closed[0]);
        let mut course = Course { start: closed[0], moves: Vec::new(), branches: Vec::new() };
        for (i, &p) in closed.iter().enumerate().skip(1) {
            let made = simulation.since(&mark).len();
            simulation.cut_limited(p, MoveKind::Cut);
            course.moves.extend_from_slice(&simulation.since(&mark)[made..]);
            let index = (start + i) % ring.points.len();
            for branch in ring.branches.iter().filter(|s| s.at == index) {
                course.branches.push((course.moves.len().saturating_sub(1), branch));
                simulation.facing_on(|simulation| {
                    branch
                        .points
                        .iter()
                        .chain([&p])
                        .for_each(|&q| simulation.cut_limited(q, MoveKind::Cut));
                });
            }
        }
        let limit = simulation.cutting.limit;
        let share = |m: &FlatPoint| {
            let (rate, beyond) = (rate_at_nominal(m, simulation), (self.measured.beyond)(m.at));
            let is_above = rate * beyond > limit * (1.0 + 1e-9);
            let plain = is_above.then(|| (self.measured.plain)(m.at))?;
            let truth = plain.or((beyond > 1.0).then_some(rate))?;
            Some((truth / rate).clamp(LEAST_SHARE, 1.0) * beyond)
        };
        // Branches keep the limit by their feed: loops on them would cut nothing.
        let over: Vec<Option<f64>> = course.moves.iter().map(share).collect();
        let is_over = over.iter().any(Option::is_some);
        if !self.options.control.takes_trochoids() || !is_over {
            simulation.keep();
            return 0;
        }
        simulation.undo(&mark);
        simulation.keep();
        self.cut_with_trochoids(simulation, course, &over)
    }

    fn cut_with_trochoids(
        &self,
        simulation: &mut Simulation,
        course: Course,
        over: &[Option<f64>],
    ) -> usize {
        let (course, over) = course.begun_outside(over);
        let moves = &course.moves;
        let stretches = stretches(moves, &over, simulation.cutting.radius);
        let toward = if self.has_cleared_side { -1.0 } else { 1.0 };
        let is_run_again = !self.has_cleared_side || self.is_last;
        let corridor = self.corridor(simulation.disc(course.start) / simulation.cutting.radius);
        let mut at = course.start;
        let mut arrived = false;
        let mut count = 0;
        for stretch in &stretches {
            let ends = moves[stretch.moves.clone()].iter().map(|m| m.at);
            let points: Vec<DVec2> = core::iter::once(at).chain(ends).collect();
            let loops = &self.options.loops;
            if stretch.over {
                let branches = &course.branches(stretch);
                let shares = shares(&over[stretch.moves.clone()]);
                let span = Span {
                    points: &points,
                    branches,
                    corridor: &corridor,
                    toward,
                    shares: &shares,
                    is_run_again,
                };
                if !arrived {
                    self.reach_loop(simulation, &span);
                }
                count += trochoid::clear_span(simulation, &span, loops);
            } else {
                if !arrived {
                    self.reach(simulation, at, points[1] - at);
                }
                for (i, &p) in stretch.moves.clone().zip(&points[1..]) {
                    simulation.cut_limited(p, MoveKind::Cut);
                    let out_and_back =
                        course.branches_after(i).flat_map(|s| s.points.iter().chain([&p]));
                    simulation.facing_on(|simulation| {
                        out_and_back.for_each(|&q| simulation.cut_limited(q, MoveKind::Cut));
                    });
                }
            }
            arrived = true;
            at = points[points.len() - 1];
        }
        if is_run_again {
            let last = stretches.iter().rposition(|s| s.over).map_or(0, |i| stretches[i].moves.end);
            moves[..last].iter().for_each(|m| simulation.cut_limited(m.at, MoveKind::Cut));
        }
        count
    }

    /// What is beside the ring; `per_mm`: flat mm per mm.
    fn corridor(&self, per_mm: f64) -> Corridor {
        let Self { rings, precedence, index, .. } = *self;
        // Passes between two levels only close gaps.
        let apart = |i: &usize| (rings[*i].level - rings[index].level).abs();
        let beside = (0..rings.len()).filter(|i| NEIGHBOURS.contains(&apart(i)));
        // No ring that begins in uncut stock may be cut by the loops of another.
        let begins = |&i: &usize| !self.has_cleared_side && precedence.before(i).is_empty();
        let bounds = (0..rings.len()).filter(|i| *i == index || begins(i));
        let sides = |i: usize| sides(&rings[i]);
        Corridor::new(
            bounds.flat_map(sides),
            beside.flat_map(sides),
            2.0 * self.options.loops.radius * per_mm,
        )
    }

    /// Goes to where the first loop of a span starts.
    fn reach_loop(&self, simulation: &mut Simulation, span: &Span) {
        let loops = &self.options.loops;
        let (back, center, radius) = trochoid::entry(simulation, span, loops);
        if radius > 0.0 && !simulation.is_clear(back) && !self.can_link(simulation, back) {
            simulation.face((center - back).try_normalize());
            if simulation.has_begun() {
                simulation.arrive(back, simulation.cutting.depth, MoveKind::Rapid);
            }
            trochoid::enter(simulation, back, center, loops);
            simulation.face(None);
        } else {
            let to = if radius > 0.0 { back } else { span.points[0] };
            self.reach(simulation, to, span.points[1] - span.points[0]);
        }
    }

    fn can_link(&self, simulation: &Simulation, to: DVec2) -> bool {
        let way = to - simulation.at();
        let (length, disc) = (way.length(), simulation.disc(simulation.at()));
        if !simulation.has_begun()
            || self.options.links == Links::Retract
            || length > LONGEST_LINK * disc
        {
            return false;
        }
        let steps = (length / (0.2 * disc)).ceil().max(1.0) as usize;
        simulation.terrain.joins(simulation.at(), to)
            && (1..=steps).all(|i| {
                let p = simulation.at() + way * (i as f64 / steps as f64);
                let inside = simulation.terrain.room(p).is_some_and(|room| room >= -0.05);
                let rate = simulation.cutting.rate(&simulation.engagement(p, way / length));
                inside && rate * SLOWEST_LINK <= simulation.cutting.limit
            })
    }

    /// Goes to a point of the surface, by link or by retract. Before it goes on `ahead` from there the cutter faces that
    /// way: a leaning axis would swing all round with a helix.
    fn reach(&self, simulation: &mut Simulation, to: DVec2, ahead: DVec2) {
        if self.can_link(simulation, to) {
            return simulation.cut_limited(to, MoveKind::Link);
        }
        simulation.face(ahead.try_normalize());
        if simulation.has_begun() {
            simulation.arrive(to, simulation.cutting.depth, MoveKind::Rapid);
        } else {
            simulation.arrive(to, simulation.cutting.depth, MoveKind::Link);
        }
        let loops = &self.options.loops;
        if !simulation.is_clear(to) {
            let (back, center) = helix_place(simulation, to, loops);
            simulation.arrive(back, simulation.cutting.depth, MoveKind::Link);
            trochoid::enter(simulation, back, center, loops);
            simulation.cut_limited(to, MoveKind::Link);
        } else {
            simulation.arrive(to, 0.0, MoveKind::Link);
            simulation.plunge();
        }
        simulation.face(None);
    }
}

/// A place for a helix beside `to` that stays inside of ring 0: its start and its centre.
fn helix_place(simulation: &Simulation, to: DVec2, loops: &Loops) -> (DVec2, DVec2) {
    let radius = loops.radius * simulation.disc(to) / simulation.cutting.radius;
    let room = |p: DVec2| simulation.terrain.room(p).unwrap_or(f64::NEG_INFINITY);
    let (inward, _) = most_room(simulation, to, 2.0 * radius);
    let fits = |r: f64| room(to + inward * (2.0 * r)) >= -0.05;
    let mut r = radius;
    while !fits(r) && r > 0.05 * radius {
        r *= 0.7;
    }
    (to, to + inward * r)
}

/// The direction in which there is the most room at a distance from a place, flat mm, and how much, passes.
fn most_room(simulation: &Simulation, from: DVec2, distance: f64) -> (DVec2, f64) {
    let room = |way: DVec2| {
        let room = simulation.terrain.room(from + way * distance);
        (way, room.unwrap_or(f64::NEG_INFINITY))
    };
    let ways = (0..16).map(|k| {
        let a = core::f64::consts::TAU * k as f64 / 16.0;
        DVec2::new(crate::geometry::math::cos(a), crate::geometry::math::sin(a))
    });
    ways.map(room).max_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or((DVec2::X, f64::NEG_INFINITY))
}

/// Per point of a stretch the share of its moves, where that is not known the one of the move before or after.
fn shares(over: &[Option<f64>]) -> Vec<f64> {
    let first = over.iter().copied().flatten().next().unwrap_or(1.0);
    let mut shares = vec![first];
    for share in over {
        shares.push(share.unwrap_or(shares[shares.len() - 1]));
    }
    shares
}

/// The sides of a ring.
fn sides(ring: &Pass) -> impl Iterator<Item = [DVec2; 2]> + '_ {
    let points = &ring.points;
    let closing = points.last().copied().zip(points.first().copied()).map(|(a, b)| [a, b]);
    points.windows(2).map(|w| [w[0], w[1]]).chain(closing)
}

/// The removal rate a move would have at the nominal feed.
fn rate_at_nominal(m: &FlatPoint, simulation: &Simulation) -> f64 {
    if m.feed > 0.0 { m.mrr * simulation.cutting.feed / m.feed } else { m.mrr }
}

/// The same ring with a point in the middle of its longest side: one of corners alone could start nowhere else.
fn with_middle_of_longest_side(ring: &Pass) -> Pass {
    let mut ring = ring.clone();
    let n = ring.points.len();
    let side = |i: usize| (ring.points[(i + 1) % n] - ring.points[i]).length_squared();
    let Some(longest) = (0..n).max_by(|&a, &b| side(a).total_cmp(&side(b)).then(b.cmp(&a))) else {
        return ring;
    };
    let middle = 0.5 * (ring.points[longest] + ring.points[(longest + 1) % n]);
    ring.points.insert(longest + 1, middle);
    for branch in ring.branches.iter_mut().filter(|b| b.at > longest) {
        branch.at += 1;
    }
    ring
}

/// Where a ring starts: a slanted lead-in ahead of the point nearest to the cutter; the first one where a helix down to it
/// has the most room, so not in a corner.
fn start_index(simulation: &Simulation, ring: &[DVec2], loops: &Loops) -> usize {
    if !simulation.has_begun() {
        let across =
            |at: DVec2| 2.0 * loops.radius * simulation.disc(at) / simulation.cutting.radius;
        let room = |i: &usize| most_room(simulation, ring[*i], across(ring[*i])).1;
        let more = |a: &usize, b: &usize| room(a).total_cmp(&room(b)).then(b.cmp(a));
        return (0..ring.len()).max_by(more).unwrap_or(0);
    }
    let from = simulation.at();
    let distance = |i: usize| (ring[i] - from).length_squared();
    let mut i = (0..ring.len()).min_by(|&a, &b| distance(a).total_cmp(&distance(b))).unwrap_or(0);
    let perimeter: f64 =
        (0..ring.len()).map(|k| (ring[(k + 1) % ring.len()] - ring[k]).length()).sum();
    let mut left = (SLANT * simulation.disc(from)).min(0.25 * perimeter);
    while left > 0.0 {
        let next = (i + 1) % ring.len();
        left -= (ring[next] - ring[i]).length();
        i = next;
    }
    i
}

/// A run of moves that is cut in one way.
struct Stretch {
    moves: core::ops::Range<usize>,
    over: bool,
}

/// Over-engaged runs, joined and widened, and the plain runs between them.
fn stretches(moves: &[FlatPoint], over: &[Option<f64>], radius: f64) -> Vec<Stretch> {
    let mut flags: Vec<bool> = over.iter().map(Option::is_some).collect();
    widen(&mut flags, moves, WIDEN * radius);
    join(&mut flags, moves, JOIN * radius);
    let mut out: Vec<Stretch> = Vec::new();
    for (i, &flag) in flags.iter().enumerate() {
        match out.last_mut() {
            Some(s) if s.over == flag => s.moves.end = i + 1,
            _ => out.push(Stretch { moves: i..i + 1, over: flag }),
        }
    }
    out
}

/// Sets the flags of moves within `by` mm of a set one, along the path.
fn widen(flags: &mut [bool], moves: &[FlatPoint], by: f64) {
    let original = flags.to_vec();
    for forward in [true, false] {
        let mut left = 0.0;
        for k in 0..flags.len() {
            let i = if forward { k } else { flags.len() - 1 - k };
            if original[i] {
                left = by;
            } else if left > 0.0 {
                flags[i] = true;
                left -= moves[i].length;
            }
        }
    }
}

/// Sets the flags in gaps shorter than `shortest` mm between set ones.
fn join(flags: &mut [bool], moves: &[FlatPoint], shortest: f64) {
    let mut last_set: Option<usize> = None;
    for i in 0..flags.len() {
        if !flags[i] {
            continue;
        }
        if let Some(l) = last_set {
            let gap: f64 = moves[l + 1..i].iter().map(|m| m.length).sum();
            if gap < shortest {
                flags[l + 1..i].fill(true);
            }
        }
        last_set = Some(i);
    }
}

#[cfg(test)]
mod tests;
