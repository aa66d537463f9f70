//! Rings → one path in cutting order: reach a ring, cut it with its cure, go on to the next.
//!
//! - *Reach*: on the surface when the straight way is inside of the region and the cut on it can be
//!   kept below the limit, else by retract, rapid and approach.
//! - *Trial*: a ring is first cut as it is; only if that exceeds the limit is it taken back and cut
//!   again with trochoids on the stretches that exceed it.

mod deliver;
mod order;

pub use deliver::{DeliverError, DeliverOptions, Delivered, deliver};
pub use order::Precedence;

use crate::engagement::Walk;
use crate::flat_path::FlatPoint;
use crate::geometry::DVec2;
use crate::job::{ForceControl, Links, RingOrder};
use crate::level_set::Ring;
use crate::toolpath::MoveKind;
use crate::trochoid::{self, Loops};
use order::Sequence;

/// Over-engaged stretches closer than this are one, as a part of the cutter radius.
const JOIN: f64 = 1.0;
/// Over-engaged stretches are widened by this part of the cutter radius at both ends.
const WIDEN: f64 = 0.25;
/// Longest link on the surface, cutter radii.
const LONGEST_LINK: f64 = 8.0;
/// A link on the surface that would have to be slower than this part of the feed is not taken.
const SLOWEST_LINK: f64 = 0.05;
/// The next ring starts this many cutter radii ahead, so that the link runs into it at a slant.
const SLANT: f64 = 2.0;

/// How rings are cut and joined.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct RingOptions {
    /// Order of the rings.
    pub order: RingOrder,
    /// How they are joined.
    pub links: Links,
    /// What is done where the limit is exceeded.
    pub control: ForceControl,
    /// Loops for [`ForceControl::Trochoid`].
    pub loops: Loops,
}

/// What was done.
#[derive(Copy, Clone, Debug, Default, PartialEq)]
pub struct RingCounts {
    /// Stretches that were taken by trochoids.
    pub intervals: usize,
    /// Trochoid loops.
    pub loops: usize,
    /// Retracts.
    pub retracts: usize,
}

/// Cuts all rings. `progress` is called with the part done.
pub fn cut_rings(
    walk: &mut Walk,
    rings: &[Ring],
    precedence: &Precedence,
    options: &RingOptions,
    mut progress: impl FnMut(f64),
) -> RingCounts {
    let mut counts = RingCounts::default();
    let mut sequence = Sequence::new(precedence);
    let mut last = None;
    let mut done = 0;
    let distance = |walk: &Walk, r: usize| {
        let from = walk.at();
        let points = rings[r].points.iter();
        points.map(|p| (*p - from).length_squared()).fold(f64::INFINITY, f64::min)
    };
    while let Some(index) = sequence.next_nearest(last, |r| distance(walk, r)) {
        let task = RingTask {
            options,
            has_cleared_side: !precedence.before(index).is_empty(),
            is_last: precedence.after(index).is_empty(),
        };
        let points = oriented(&rings[index].points, options);
        task.cut(walk, &points, &mut counts);
        walk.next_pass();
        last = Some(index);
        done += 1;
        progress(done as f64 / rings.len() as f64);
    }
    counts
}

/// Rings come with higher values on their right; turned so that the stock is on the side that the
/// cut direction asks for.
fn oriented(points: &[DVec2], options: &RingOptions) -> Vec<DVec2> {
    let stock_is_higher = options.order == RingOrder::OutsideIn;
    let stock_on_right = options.loops.hand > 0.0;
    if stock_is_higher == stock_on_right {
        points.to_vec()
    } else {
        points.iter().rev().copied().collect()
    }
}

/// One ring to be cut.
struct RingTask<'a> {
    options: &'a RingOptions,
    has_cleared_side: bool,
    is_last: bool,
}

impl RingTask<'_> {
    fn cut(&self, walk: &mut Walk, ring: &[DVec2], counts: &mut RingCounts) {
        let start = start_index(walk, ring);
        let closed: Vec<DVec2> = ring[start..].iter().chain(&ring[..=start]).copied().collect();
        let retracts = counts.retracts;
        let mark = walk.mark();
        self.reach(walk, closed[0], counts);
        let reached = walk.since(&mark).len();
        for &p in &closed[1..] {
            self.step(walk, p);
        }
        let moves = walk.since(&mark)[reached..].to_vec();
        let limit = walk.cutting.limit;
        let above = |m: &FlatPoint| rate_at_nominal(m, walk) > limit * (1.0 + 1e-9);
        let over: Vec<bool> = moves.iter().map(above).collect();
        if self.options.control != ForceControl::Trochoid || !over.contains(&true) {
            walk.keep();
            return;
        }
        walk.undo(&mark);
        walk.keep();
        counts.retracts = retracts;
        self.cut_with_trochoids(walk, closed[0], &moves, &over, counts);
    }

    /// A move along the ring itself.
    fn step(&self, walk: &mut Walk, to: DVec2) {
        match self.options.control {
            ForceControl::Off => walk.cut(to, MoveKind::Cut),
            ForceControl::Feed | ForceControl::Trochoid => walk.cut_limited(to, MoveKind::Cut),
        }
    }

    fn cut_with_trochoids(
        &self,
        walk: &mut Walk,
        start: DVec2,
        moves: &[FlatPoint],
        over: &[bool],
        counts: &mut RingCounts,
    ) {
        let (start, moves, over) = begin_outside(start, moves, over);
        let stretches = stretches(&moves, &over, walk.cutting.radius);
        let toward = if self.has_cleared_side { -1.0 } else { 1.0 };
        let mut at = start;
        let mut arrived = false;
        for stretch in &stretches {
            let ends = moves[stretch.moves.clone()].iter().map(|m| m.at);
            let points: Vec<DVec2> = core::iter::once(at).chain(ends).collect();
            let loops = &self.options.loops;
            if stretch.over {
                if !arrived {
                    self.reach_loop(walk, &points, toward, counts);
                }
                counts.intervals += 1;
                counts.loops += trochoid::clear_span(walk, &points, loops, toward);
            } else {
                if !arrived {
                    self.reach(walk, at, counts);
                }
                points[1..].iter().for_each(|&p| walk.cut_limited(p, MoveKind::Cut));
            }
            arrived = true;
            at = points[points.len() - 1];
        }
        if !self.has_cleared_side || self.is_last {
            let last = stretches.iter().rposition(|s| s.over).map_or(0, |i| stretches[i].moves.end);
            moves[..last].iter().for_each(|m| walk.cut_limited(m.at, MoveKind::Cut));
        }
    }

    /// Goes to where the first loop of a span starts.
    fn reach_loop(&self, walk: &mut Walk, span: &[DVec2], toward: f64, counts: &mut RingCounts) {
        let loops = &self.options.loops;
        let (back, center, radius) = trochoid::entry(walk, span, loops, toward);
        if radius > 0.0 && !walk.is_clear(back) && !self.can_link(walk, back) {
            if walk.has_begun() {
                counts.retracts += 1;
                walk.arrive(back, walk.cutting.depth, MoveKind::Rapid);
            }
            trochoid::enter(walk, back, center, loops);
        } else {
            self.reach(walk, if radius > 0.0 { back } else { span[0] }, counts);
        }
    }

    fn can_link(&self, walk: &Walk, to: DVec2) -> bool {
        let way = to - walk.at();
        let (length, disc) = (way.length(), walk.disc(walk.at()));
        if !walk.has_begun() || self.options.links == Links::Retract || length > LONGEST_LINK * disc
        {
            return false;
        }
        let steps = (length / (0.2 * disc)).ceil().max(1.0) as usize;
        walk.terrain.joins(walk.at(), to)
            && (1..=steps).all(|i| {
                let p = walk.at() + way * (i as f64 / steps as f64);
                let inside = walk.terrain.room(p).is_some_and(|room| room >= -0.05);
                let rate = walk.cutting.rate(&walk.engagement(p, way / length));
                inside && rate * SLOWEST_LINK <= walk.cutting.limit
            })
    }

    /// Goes to a point of the surface, by link or by retract.
    fn reach(&self, walk: &mut Walk, to: DVec2, counts: &mut RingCounts) {
        if self.can_link(walk, to) {
            match self.options.control {
                ForceControl::Off => walk.cut(to, MoveKind::Link),
                ForceControl::Feed | ForceControl::Trochoid => walk.cut_limited(to, MoveKind::Link),
            }
            return;
        }
        if walk.has_begun() {
            counts.retracts += 1;
            walk.arrive(to, walk.cutting.depth, MoveKind::Rapid);
        } else {
            walk.arrive(to, walk.cutting.depth, MoveKind::Link);
        }
        let loops = &self.options.loops;
        let limited = self.options.control != ForceControl::Off;
        if limited && !walk.is_clear(to) {
            let (back, center) = helix_place(walk, to, loops);
            walk.arrive(back, walk.cutting.depth, MoveKind::Link);
            trochoid::enter(walk, back, center, loops);
            walk.cut_limited(to, MoveKind::Link);
        } else {
            walk.arrive(to, 0.0, MoveKind::Link);
            walk.plunge();
        }
    }
}

/// A place for a helix beside `to` that stays inside of ring 0: its start and its centre.
fn helix_place(walk: &Walk, to: DVec2, loops: &Loops) -> (DVec2, DVec2) {
    let radius = loops.radius * walk.disc(to) / walk.cutting.radius;
    let room = |p: DVec2| walk.terrain.room(p).unwrap_or(f64::NEG_INFINITY);
    let directions = (0..16).map(|k| {
        let a = core::f64::consts::TAU * k as f64 / 16.0;
        DVec2::new(crate::geometry::math::cos(a), crate::geometry::math::sin(a))
    });
    let best = directions
        .max_by(|a, b| room(to + *a * (2.0 * radius)).total_cmp(&room(to + *b * (2.0 * radius))));
    let inward = best.unwrap_or(DVec2::X);
    let fits = |r: f64| room(to + inward * (2.0 * r)) >= -0.05;
    let mut r = radius;
    while !fits(r) && r > 0.05 * radius {
        r *= 0.7;
    }
    (to, to + inward * r)
}

/// The removal rate a move would have at the nominal feed.
fn rate_at_nominal(m: &FlatPoint, walk: &Walk) -> f64 {
    if m.feed > 0.0 { m.mrr * walk.cutting.feed / m.feed } else { m.mrr }
}

/// Where a ring is begun: a slant ahead of the point nearest to where the cutter is.
fn start_index(walk: &Walk, ring: &[DVec2]) -> usize {
    if !walk.has_begun() {
        return 0;
    }
    let from = walk.at();
    let distance = |i: usize| (ring[i] - from).length_squared();
    let mut i = (0..ring.len()).min_by(|&a, &b| distance(a).total_cmp(&distance(b))).unwrap_or(0);
    let perimeter: f64 =
        (0..ring.len()).map(|k| (ring[(k + 1) % ring.len()] - ring[k]).length()).sum();
    let mut left = (SLANT * walk.disc(from)).min(0.25 * perimeter);
    while left > 0.0 {
        let next = (i + 1) % ring.len();
        left -= (ring[next] - ring[i]).length();
        i = next;
    }
    i
}

/// Turns a ring so that it does not begin inside an over-engaged stretch, unless all of it is one.
fn begin_outside(
    start: DVec2,
    moves: &[FlatPoint],
    over: &[bool],
) -> (DVec2, Vec<FlatPoint>, Vec<bool>) {
    let first_clear = over.iter().position(|o| !o).unwrap_or(0);
    if !over[0] || !over[over.len() - 1] || first_clear == 0 {
        return (start, moves.to_vec(), over.to_vec());
    }
    let turn = |i: usize| (i + first_clear) % moves.len();
    let turned = (0..moves.len()).map(|i| moves[turn(i)]).collect();
    let flags = (0..moves.len()).map(|i| over[turn(i)]).collect();
    (moves[first_clear - 1].at, turned, flags)
}

/// A run of moves that is cut in one way.
struct Stretch {
    moves: core::ops::Range<usize>,
    over: bool,
}

/// Over-engaged runs, joined and widened, and the plain runs between them.
fn stretches(moves: &[FlatPoint], over: &[bool], radius: f64) -> Vec<Stretch> {
    let mut flags = over.to_vec();
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
