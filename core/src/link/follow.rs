//! Open passes cut in the plane as they were laid out, with trochoids where the limit requires them.
//!
//! - *Stock side*: the side of a pass on which stock is left. It changes from pass to pass where these run to and fro.
//! - *Cleared side*: the other one, where the pass before has cut; there loops have room.
//!
//! 1. Each pass is cut in trial along the points laid for it.
//! 2. Where that exceeds the limit, loops run on the cleared side, as beside rings. The first pass into full stock has no
//!    cleared side: its loops run on the stock side, and the pass is run again as it was laid, which takes what loops
//!    leave along it. So are passes beyond which nothing follows, and those with loops up to the boundary.

use super::course::{Course, CutOptions, Measured, Stretch, shares, stretches};
use crate::engagement::Simulation;
use crate::flat_path::FlatPoint;
use crate::geometry::DVec2;
use crate::level_set::Branch;
use crate::toolpath::MoveKind;
use crate::trochoid::{self, Corridor, Loops, Span};

/// Distance of the places at which the sides of a stretch are looked at, cutter radii.
const PROBED: f64 = 0.5;
/// Passes farther from a pass than this many of its largest loops' diameters do not bound them.
const NEAR: f64 = 2.0;

/// Cuts the passes of a region along the points `laid` for them; `on_pass` is called after each. Returns the number of
/// trochoid loops.
pub(super) fn cut_laid(
    simulation: &mut Simulation,
    laid: &[FlatPoint],
    (options, measured): (&CutOptions, Measured),
    mut on_pass: impl FnMut(),
) -> usize {
    let passes: Vec<LaidPass> = laid.chunk_by(|a, b| a.pass == b.pass).map(LaidPass::of).collect();
    let mut loops = 0;
    for index in 0..passes.len() {
        let task = Task { options, measured, passes: &passes, index };
        loops += task.cut(simulation);
        simulation.next_pass();
        on_pass();
    }
    loops
}

/// The points laid for one pass.
struct LaidPass<'a> {
    /// Those with which the cutter comes to it.
    arrival: &'a [FlatPoint],
    /// Those of the pass and its branches.
    moves: &'a [FlatPoint],
    /// The box around it, flat mm.
    bounds: [DVec2; 2],
}

impl<'a> LaidPass<'a> {
    fn of(points: &'a [FlatPoint]) -> Self {
        let first = points.iter().position(|p| p.kind == MoveKind::Cut).unwrap_or(points.len());
        let (arrival, moves) = points.split_at(first);
        let empty = [DVec2::INFINITY, DVec2::NEG_INFINITY];
        let around = |[low, high]: [DVec2; 2], p: &FlatPoint| [low.min(p.at), high.max(p.at)];
        Self { arrival, moves, bounds: points.iter().fold(empty, around) }
    }

    /// Where it begins.
    fn start(&self) -> Option<&'a FlatPoint> {
        self.arrival.last()
    }

    /// Its sides without those of branches.
    fn sides(&self) -> impl Iterator<Item = [DVec2; 2]> + '_ {
        let on_pass = self.moves.iter().filter(|p| !is_on_branch(p));
        let points = self.start().into_iter().chain(on_pass).map(|p| p.at);
        points.clone().zip(points.skip(1)).map(|(a, b)| [a, b])
    }

    fn is_near(&self, other: &Self, distance: f64) -> bool {
        let ([a, b], [c, d]) = (self.bounds, other.bounds);
        let gap = (c - b).max(a - d);
        gap.max_element() <= distance
    }

    /// How far it goes on beyond the boundary after its end, mm.
    fn overrun(&self) -> f64 {
        self.moves.iter().find(|p| p.overrun > 0.0).map_or(0.0, |p| p.overrun)
    }

    /// Its branches, each with the index of the last of the moves before it.
    fn branches(&self) -> Vec<(usize, Branch)> {
        let mut branches = Vec::new();
        let mut root = self.start().map_or(DVec2::ZERO, |p| p.at);
        let mut open: Option<(usize, Branch)> = None;
        for (i, p) in self.moves.iter().enumerate() {
            if !is_on_branch(p) {
                root = p.at;
                branches.extend(open.take());
            } else if p.at == root {
                branches.extend(open.take());
            } else {
                let first = || (i.saturating_sub(1), Branch { at: i, points: Vec::new() });
                open.get_or_insert_with(first).1.points.push(p.at);
            }
        }
        branches.extend(open);
        branches
    }

    /// Cuts it as it was laid, once the cutter is at its start, slower where the limit requires it.
    fn cut(&self, simulation: &mut Simulation) {
        for p in self.moves {
            simulation.face(p.heading);
            if p.at == simulation.at() {
                // Back from beyond the boundary.
                simulation.arrive(p.at, 0.0, MoveKind::Cut);
            } else {
                simulation.cut_limited(p.at, MoveKind::Cut);
            }
            simulation.overrun(p.overrun);
        }
        simulation.face(None);
    }

    /// Comes to its start as laid.
    fn arrive(&self, simulation: &mut Simulation) {
        let mut height = 0.0;
        for p in self.arrival {
            if p.height == 0.0 && height == 0.0 && simulation.has_begun() {
                simulation.cut_limited(p.at, p.kind);
            } else {
                simulation.arrive(p.at, p.height, p.kind);
                if p.height == 0.0 {
                    simulation.plunge();
                }
            }
            height = p.height;
            simulation.overrun(p.overrun);
        }
    }

    /// Comes to its start from above.
    fn arrive_from_above(&self, simulation: &mut Simulation) {
        let Some(start) = self.start() else { return };
        if simulation.has_begun() {
            simulation.arrive(start.at, simulation.cutting.depth, MoveKind::Rapid);
        }
        simulation.arrive(start.at, 0.0, MoveKind::Link);
        simulation.plunge();
        simulation.overrun(start.overrun);
    }
}

/// Branches keep the direction that the cutter faced.
fn is_on_branch(point: &FlatPoint) -> bool {
    point.heading.is_some()
}

/// What lies beside a stretch.
#[derive(Copy, Clone, Debug, PartialEq)]
struct Sides {
    /// Whether the stock is on the right of the feed.
    stock_on_right: bool,
    /// Whether loops have room on the other side.
    has_cleared: bool,
    /// Whether no stock is left beyond the pass.
    is_last: bool,
}

impl Sides {
    /// As the places `apart`, flat mm, from the stretch `points` are.
    fn of(simulation: &Simulation, points: &[DVec2], apart: f64) -> Self {
        let (mut stock, mut clear, mut all) = ([0usize; 2], [0usize; 2], 0);
        for w in points.windows(2) {
            let Some(ahead) = (w[1] - w[0]).try_normalize() else { continue };
            let spacing = PROBED * simulation.disc(w[0]);
            let count = (w[0].distance(w[1]) / spacing).ceil().clamp(1.0, 1e4) as usize;
            for i in 0..count {
                let at = w[0].lerp(w[1], (i as f64 + 0.5) / count as f64);
                all += 1;
                for (side, way) in [-ahead.perp(), ahead.perp()].into_iter().enumerate() {
                    let beside = at + way * apart;
                    if simulation.terrain.scale(beside).is_none() {
                        continue;
                    }
                    match simulation.has_stock(beside) {
                        true => stock[side] += 1,
                        false => clear[side] += 1,
                    }
                }
            }
        }
        let stock_on_right = stock[0] >= stock[1];
        let [stock_side, other] = if stock_on_right { [0, 1] } else { [1, 0] };
        Self {
            stock_on_right,
            has_cleared: 2 * clear[other] > all,
            is_last: 2 * stock[stock_side] <= all,
        }
    }
}

/// One pass to be cut.
struct Task<'a> {
    options: &'a CutOptions,
    measured: Measured<'a>,
    /// All passes of the region, and which of them it is.
    passes: &'a [LaidPass<'a>],
    index: usize,
}

impl Task<'_> {
    /// Cuts it; returns the number of trochoid loops.
    fn cut(&self, simulation: &mut Simulation) -> usize {
        let pass = &self.passes[self.index];
        let Some(start) = pass.start() else { return 0 };
        let mark = simulation.mark();
        pass.arrive(simulation);
        let branches = pass.branches();
        let mut course = Course { start: start.at, moves: Vec::new(), branches: Vec::new() };
        // The trial knows of branches where they leave only: they keep the limit by their feed.
        let mut next = branches.iter().peekable();
        for (i, p) in pass.moves.iter().enumerate() {
            let made = simulation.since(&mark).len();
            simulation.face(p.heading);
            simulation.cut_limited(p.at, MoveKind::Cut);
            if !is_on_branch(p) {
                course.moves.extend_from_slice(&simulation.since(&mark)[made..]);
            }
            while let Some((_, branch)) = next.next_if(|(after, _)| *after == i) {
                course.branches.push((course.moves.len().saturating_sub(1), branch));
            }
        }
        simulation.face(None);
        let over = self.measured.over(&course.moves, simulation);
        simulation.undo(&mark);
        simulation.keep();
        if self.options.control.takes_trochoids() && over.iter().any(Option::is_some) {
            return self.cut_with_trochoids(simulation, &course, &over);
        }
        pass.arrive(simulation);
        pass.cut(simulation);
        0
    }

    fn cut_with_trochoids(
        &self,
        simulation: &mut Simulation,
        course: &Course,
        over: &[Option<f64>],
    ) -> usize {
        let pass = &self.passes[self.index];
        let moves = &course.moves;
        let stretches = stretches(moves, over, simulation.cutting.radius);
        let per_mm = simulation.disc(course.start) / simulation.cutting.radius;
        let apart = 2.0 * self.options.loops.radius * per_mm;
        let corridor = self.corridor(apart);
        let points = |stretch: &Stretch| -> Vec<DVec2> {
            let before = stretch.moves.start.checked_sub(1).map_or(course.start, |i| moves[i].at);
            let ends = moves[stretch.moves.clone()].iter().map(|m| m.at);
            core::iter::once(before).chain(ends).collect()
        };
        let sides: Vec<Sides> =
            stretches.iter().map(|s| Sides::of(simulation, &points(s), apart)).collect();
        // What is left beside loops that nothing follows, and at the boundary, where they have no room.
        let leaves = |(s, side): (&Stretch, &Sides)| s.over && (side.is_last || !side.has_cleared);
        let at_boundary = [stretches.first(), stretches.last()].into_iter().flatten();
        let is_run_again =
            stretches.iter().zip(&sides).any(leaves) || at_boundary.into_iter().any(|s| s.over);
        let mut count = 0;
        let mut has_arrived = false;
        for (stretch, side) in stretches.iter().zip(&sides) {
            let points = points(stretch);
            if stretch.over {
                let hand = if side.stock_on_right { 1.0 } else { -1.0 };
                let options =
                    CutOptions { loops: Loops { hand, ..self.options.loops }, ..*self.options };
                let span = Span {
                    points: &points,
                    branches: &course.branches(stretch),
                    corridor: &corridor,
                    toward: if side.has_cleared { -1.0 } else { 1.0 },
                    shares: &shares(&over[stretch.moves.clone()]),
                    is_run_again,
                    begins_at_boundary: !has_arrived,
                };
                if !has_arrived {
                    options.reach_loop(simulation, &span);
                }
                count += trochoid::clear_span(simulation, &span, &options.loops);
            } else {
                if !has_arrived {
                    pass.arrive(simulation);
                }
                let last = moves.len() - 1;
                for (i, &p) in stretch.moves.clone().zip(&points[1..]) {
                    simulation.cut_limited(p, MoveKind::Cut);
                    if i == last && !is_run_again && pass.overrun() != 0.0 {
                        simulation.overrun(pass.overrun());
                        simulation.arrive(p, 0.0, MoveKind::Cut);
                    }
                    course.cut_branches(simulation, i, p);
                }
            }
            has_arrived = true;
        }
        if is_run_again {
            pass.arrive_from_above(simulation);
            pass.cut(simulation);
        }
        count
    }

    /// What is beside the pass; `size`: diameter of a loop, flat mm.
    fn corridor(&self, size: f64) -> Corridor {
        let pass = &self.passes[self.index];
        let is_beside =
            |(i, other): &(usize, &LaidPass)| *i != self.index && pass.is_near(other, NEAR * size);
        let beside = self.passes.iter().enumerate().filter(is_beside);
        Corridor::new(pass.sides(), beside.flat_map(|(_, other)| other.sides()), size)
    }
}

#[cfg(test)]
mod tests;
