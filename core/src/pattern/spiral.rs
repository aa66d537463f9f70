//! Spirals: rings joined to one continuous path.
//!
//! The path runs once round the outermost ring of a chain. Then it follows the level curves of the rings' field
//! between the rings: on each for a fraction of a turn, while moving over to the next one, so that the field grows by
//! 1 per turn. Neighbouring turns stay one pass apart and have corners where the rings have them. The innermost ring
//! is followed once round again.
//!
//! A chain ends where rings split or meet; every branch is a spiral of its own.

use crate::geometry::DVec2;
use crate::level_set::{Pass, PassField, PassMesh, passes};
use crate::link::Precedence;

/// Level curves followed in a turn. Fewer: corners are cut off by this part of a pass; more: slower.
const PARTS: u32 = 16;
/// Segments ahead of the last nearest one that are searched for the next nearest.
const AHEAD: usize = 48;

/// Spirals through all rings, each an open pass; single rings stay rings.
pub fn spiral(
    mesh: &PassMesh,
    field: &PassField,
    rings: &[Pass],
    precedence: &Precedence,
) -> Vec<Pass> {
    let (_, high) = field.range();
    let count = (high * f64::from(PARTS)) as u32;
    let levels: Vec<f64> = (1..=count).map(|k| f64::from(k) / f64::from(PARTS)).collect();
    let curves = passes(mesh, field, &levels);
    let follows = |r: usize| match precedence.after(r) {
        [next] if precedence.before(*next) == [r] => Some(*next),
        _ => None,
    };
    let is_start = |r: usize| match precedence.before(r) {
        [before] => follows(*before).is_none(),
        _ => true,
    };
    let chain = |r: usize| -> Vec<&Pass> {
        core::iter::successors(Some(r), |&r| follows(r)).map(|r| &rings[r]).collect()
    };
    (0..rings.len()).filter(|&r| is_start(r)).map(|r| wound(&chain(r), &curves)).collect()
}

/// The spiral of a chain of rings, from the first to the last; `curves`: level curves, the lowest first.
fn wound(chain: &[&Pass], curves: &[Pass]) -> Pass {
    let (first, last) = (chain[0], chain[chain.len() - 1]);
    if chain.len() == 1 {
        return first.clone();
    }
    let mut points: Vec<DVec2> = first.line().collect();
    let mut turn = Turn::new(first, first.points[0]);
    let is_inward = first.level <= last.level;
    let (low, high) = if is_inward { (first, last) } else { (last, first) };
    let from = curves.partition_point(|c| c.level <= low.level);
    let to = curves.partition_point(|c| c.level <= high.level);
    let mut between: Vec<&[Pass]> =
        curves[from..to.max(from)].chunk_by(|a, b| a.level == b.level).collect();
    if !is_inward {
        between.reverse();
    }
    for group in between {
        let at = points[points.len() - 1];
        let closed = group.iter().filter(|c| c.is_closed).map(|c| Turn::new(c, at));
        let next = closed.min_by(|a, b| a.apart(at).total_cmp(&b.apart(at)));
        let Some(next) = next else { break };
        turn.move_over(&next, &mut points);
        turn = Turn::new(next.pass, points[points.len() - 1]);
    }
    points.extend(Turn::new(last, points[points.len() - 1]).line);
    points.dedup();
    Pass { points, is_closed: false, ..first.clone() }
}

/// A ring from its point nearest to some place once round and back.
struct Turn<'a> {
    pass: &'a Pass,
    line: Vec<DVec2>,
}

impl<'a> Turn<'a> {
    fn new(pass: &'a Pass, from: DVec2) -> Self {
        let whole: Vec<DVec2> = pass.line().collect();
        let (segment, start) = nearest(&whole, from, 0..whole.len() - 1);
        let n = whole.len() - 1;
        let ends = [start];
        let between = (1..=n).map(|k| whole[(segment + k) % n]);
        Self { pass, line: ends.into_iter().chain(between).chain(ends).collect() }
    }

    fn apart(&self, from: DVec2) -> f64 {
        self.line[0].distance_squared(from)
    }

    /// Follows this turn for its part and moves over to the next one on the way.
    fn move_over(&self, next: &Turn, points: &mut Vec<DVec2>) {
        let length = |line: &[DVec2]| line.windows(2).map(|w| w[0].distance(w[1])).sum::<f64>();
        let part = length(&self.line) / f64::from(PARTS);
        let (mut done, mut segment) = (0.0, 0);
        let mut over = |p: DVec2, done: f64| {
            let window = segment..(segment + AHEAD).min(next.line.len() - 1);
            let (found, beside) = nearest(&next.line, p, window);
            segment = found;
            points.push(p.lerp(beside, (done / part).min(1.0)));
        };
        for w in self.line.windows(2) {
            let step = w[0].distance(w[1]);
            if done + step >= part {
                let t = if step > 0.0 { (part - done) / step } else { 1.0 };
                return over(w[0].lerp(w[1], t), part);
            }
            done += step;
            over(w[1], done);
        }
    }
}

/// The segment and the place of the point nearest to `p` on some segments of a polyline.
fn nearest(line: &[DVec2], p: DVec2, segments: core::ops::Range<usize>) -> (usize, DVec2) {
    let on = |i: usize| {
        let way = line[i + 1] - line[i];
        let t = ((p - line[i]).dot(way) / way.length_squared()).clamp(0.0, 1.0);
        let at = if t.is_nan() { line[i] } else { line[i] + way * t };
        (at.distance_squared(p), i, at)
    };
    let best = segments.clone().map(on).min_by(|a, b| a.0.total_cmp(&b.0));
    best.map_or((segments.start, p), |(_, segment, at)| (segment, at))
}
