//! A pass that is cut in trial: its moves, the stretches of it that exceed the limit, and the ways to it.

use super::group::LONGEST_LINK;
use crate::engagement::Simulation;
use crate::flat_path::FlatPoint;
use crate::geometry::{DVec2, OrderBy};
use crate::job::{ForceControl, Links, RingOrder};
use crate::level_set::Branch;
use crate::toolpath::MoveKind;
use crate::trochoid::{self, BranchRef, Loops, Span};

/// Over-engaged stretches closer than this, as a fraction of the cutter radius, are merged.
const JOIN: f64 = 1.0;
/// Over-engaged stretches are extended by this fraction of the cutter radius at both ends.
const WIDEN: f64 = 0.5;
/// A link on the surface that would have to be slower than this fraction of the feed is not used.
const SLOWEST_LINK: f64 = 0.05;

/// Least true removal rate over that of the disc. Lower: where a slot is shallow on one side only, loops, which cut in
/// front, are slowed; higher: more loops.
const LEAST_SHARE: f64 = 0.5;

/// How passes are cut and joined.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct CutOptions {
    /// Order of rings.
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

impl Measured<'_> {
    /// For each move that exceeds the limit the true removal rate over that of the disc.
    pub fn over(&self, moves: &[FlatPoint], simulation: &Simulation) -> Vec<Option<f64>> {
        let limit = simulation.cutting.limit;
        let share = |m: &FlatPoint| {
            let (rate, beyond) = (rate_at_nominal(m, simulation), (self.beyond)(m.at));
            let is_above = rate * beyond > limit * (1.0 + 1e-9);
            let plain = is_above.then(|| (self.plain)(m.at))?;
            let truth = plain.or((beyond > 1.0).then_some(rate))?;
            Some((truth / rate).clamp(LEAST_SHARE, 1.0) * beyond)
        };
        moves.iter().map(share).collect()
    }
}

/// The moves along a pass, with the branches that leave from their ends.
pub(super) struct Course<'a> {
    pub start: DVec2,
    pub moves: Vec<FlatPoint>,
    /// Index of the move and the branch.
    pub branches: Vec<(usize, &'a Branch)>,
}

impl Course<'_> {
    /// Turned so that it does not begin inside an over-engaged stretch, unless all of it is one.
    pub fn begun_outside(self, over: &[Option<f64>]) -> (Self, Vec<Option<f64>>) {
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

    /// Cuts the branches that leave at the end `from` of a move, out and back.
    pub fn cut_branches(&self, simulation: &mut Simulation, index: usize, from: DVec2) {
        let out_and_back = self.branches_after(index).flat_map(|s| s.points.iter().chain([&from]));
        simulation.facing_on(|simulation| {
            out_and_back.for_each(|&q| simulation.cut_limited(q, MoveKind::Cut));
        });
    }

    /// The branches of a stretch, for loops that start at the end of the move before it.
    pub fn branches(&self, stretch: &Stretch) -> Vec<BranchRef<'_>> {
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

impl CutOptions {
    /// Goes to where the first loop of a span starts.
    pub(super) fn reach_loop(&self, simulation: &mut Simulation, span: &Span) {
        let loops = &self.loops;
        let (back, center, radius) = trochoid::entry(simulation, span, loops);
        if radius > 0.0 && !simulation.is_clear(back) && !self.can_link(simulation, back) {
            simulation.face((center - back).try_normalize());
            if simulation.has_begun() {
                simulation.arrive(back, simulation.cutting.depth, MoveKind::Rapid);
            }
            trochoid::enter(simulation, back, center, loops);
            simulation.face(None);
        } else {
            let to = if radius > 0.0 { back } else { center };
            self.reach(simulation, to, span.points[1] - span.points[0]);
        }
    }

    fn can_link(&self, simulation: &Simulation, to: DVec2) -> bool {
        let way = to - simulation.at();
        let (length, disc) = (way.length(), simulation.disc(simulation.at()));
        if !simulation.has_begun() || self.links == Links::Retract || length > LONGEST_LINK * disc {
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
    pub(super) fn reach(&self, simulation: &mut Simulation, to: DVec2, ahead: DVec2) {
        if self.can_link(simulation, to) {
            return simulation.cut_limited(to, MoveKind::Link);
        }
        simulation.face(ahead.try_normalize());
        if simulation.has_begun() {
            simulation.arrive(to, simulation.cutting.depth, MoveKind::Rapid);
        } else {
            simulation.arrive(to, simulation.cutting.depth, MoveKind::Link);
        }
        let loops = &self.loops;
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
pub(super) fn most_room(simulation: &Simulation, from: DVec2, distance: f64) -> (DVec2, f64) {
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
pub(super) fn shares(over: &[Option<f64>]) -> Vec<f64> {
    let first = over.iter().copied().flatten().next().unwrap_or(1.0);
    let mut shares = vec![first];
    for share in over {
        shares.push(share.unwrap_or(shares[shares.len() - 1]));
    }
    shares
}

/// The removal rate a move would have at the nominal feed.
fn rate_at_nominal(m: &FlatPoint, simulation: &Simulation) -> f64 {
    if m.feed > 0.0 { m.mrr * simulation.cutting.feed / m.feed } else { m.mrr }
}

/// A run of moves that is cut in one way.
pub(super) struct Stretch {
    pub moves: core::ops::Range<usize>,
    pub over: bool,
}

/// Over-engaged runs, joined and widened, and the plain runs between them.
pub(super) fn stretches(moves: &[FlatPoint], over: &[Option<f64>], radius: f64) -> Vec<Stretch> {
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
