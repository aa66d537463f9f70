//! Passes cut one after the other in the plane, with trochoids where the limit requires them: rings in an order of their
//! own, open passes as they were laid out ([`follow`](super::follow)).
//!
//! *Trial*: a pass is first cut without trochoids; only if that exceeds the limit, both in the plane and in the
//! simulation of plain passes, is it undone and cut again with trochoids on the stretches that exceed it.

use super::course::{Course, CutOptions, Measured, most_room, shares, stretches};
use super::follow;
use super::group::{Group, SLANT, oriented};
use super::order::{Precedence, Sequence};
use crate::engagement::Simulation;
use crate::flat_path::FlatPoint;
use crate::geometry::DVec2;
use crate::job::RingOrder;
use crate::level_set::Pass;
use crate::toolpath::MoveKind;
use crate::trochoid::{self, Corridor, Loops, Span};

/// How many levels rings are apart between which loops run.
const NEIGHBOURS: core::ops::Range<f64> = 0.75..1.5;

/// Cuts the passes of all groups, one group after the other; `laid`: the plain path over them; `progress` is called with
/// the fraction done. Returns the number of trochoid loops.
pub fn cut_passes(
    simulation: &mut Simulation,
    (groups, laid): (&[Group], &[FlatPoint]),
    options: &CutOptions,
    measured: Measured,
    mut progress: impl FnMut(f64),
) -> usize {
    let mut loops = 0;
    let all: usize = groups.iter().map(|g| g.passes.len()).sum();
    let mut done = 0;
    for (region, group) in (0..).zip(groups) {
        simulation.begin_region(region);
        let on_pass = || {
            done += 1;
            progress(done as f64 / all as f64);
        };
        let task = (options, measured);
        if group.has_rings_only() {
            cut_group(simulation, group, task, &mut loops, on_pass);
        } else {
            let begin = laid.partition_point(|p| p.region < region);
            let end = laid.partition_point(|p| p.region <= region);
            loops += follow::cut_laid(simulation, &laid[begin..end], task, on_pass);
        }
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
        self.options.reach(simulation, closed[0], closed[1] - closed[0]);
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
        // Branches keep the limit by their feed: loops on them would cut nothing.
        let over = self.measured.over(&course.moves, simulation);
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
                    begins_at_boundary: false,
                };
                if !arrived {
                    self.options.reach_loop(simulation, &span);
                }
                count += trochoid::clear_span(simulation, &span, loops);
            } else {
                if !arrived {
                    self.options.reach(simulation, at, points[1] - at);
                }
                for (i, &p) in stretch.moves.clone().zip(&points[1..]) {
                    simulation.cut_limited(p, MoveKind::Cut);
                    course.cut_branches(simulation, i, p);
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
}

/// The sides of a ring.
fn sides(ring: &Pass) -> impl Iterator<Item = [DVec2; 2]> + '_ {
    let points = &ring.points;
    let closing = points.last().copied().zip(points.first().copied()).map(|(a, b)| [a, b]);
    points.windows(2).map(|w| [w[0], w[1]]).chain(closing)
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

#[cfg(test)]
mod tests;
