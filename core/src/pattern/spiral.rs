//! Spirals: rings joined to one continuous path.
//!
//! The path runs once round the outermost ring of a chain and then from ring to ring: while it goes
//! once round, it moves from each point of a ring toward the nearest point of the next one, in
//! proportion to the way done. Neighbouring turns stay one pass apart, as the rings are.
//!
//! A chain ends where rings split or meet; every branch is a spiral of its own.

use crate::geometry::DVec2;
use crate::level_set::Pass;
use crate::link::Precedence;

/// Points on a turn of the spiral for each point of the ring.
const DENSER: usize = 2;

/// Spirals through all rings, each an open pass; single rings stay rings.
pub fn spiral(rings: &[Pass], precedence: &Precedence) -> Vec<Pass> {
    let follows = |r: usize| match (precedence.after(r), r) {
        ([next], _) if precedence.before(*next) == [r] => Some(*next),
        _ => None,
    };
    let is_start = |r: usize| match precedence.before(r) {
        [before] => follows(*before).is_none(),
        _ => true,
    };
    let starts = (0..rings.len()).filter(|&r| is_start(r));
    starts
        .map(|r| {
            let chain: Vec<&Pass> =
                core::iter::successors(Some(r), |&r| follows(r)).map(|r| &rings[r]).collect();
            wound(&chain)
        })
        .collect()
}

/// The spiral of a chain of rings.
fn wound(chain: &[&Pass]) -> Pass {
    let (Some(first), Some(last)) = (chain.first(), chain.last()) else {
        return Pass {
            level: 0.0,
            points: Vec::new(),
            is_closed: false,
            overrun: [0.0; 2],
            spurs: Vec::new(),
        };
    };
    if chain.len() == 1 {
        return (*first).clone();
    }
    let mut points: Vec<DVec2> = first.line().collect();
    let mut turn = around(first, first.points[0]);
    for ring in &chain[1..] {
        let whole: f64 = turn.windows(2).map(|w| w[0].distance(w[1])).sum();
        let mut done = 0.0;
        for i in 0..turn.len() {
            if i > 0 {
                done += turn[i].distance(turn[i - 1]);
            }
            points.push(turn[i].lerp(nearest(ring, turn[i]), done / whole));
        }
        turn = around(ring, points[points.len() - 1]);
    }
    points.extend(around(last, points[points.len() - 1]));
    points.dedup();
    Pass { level: first.level, points, is_closed: false, overrun: [0.0; 2], spurs: Vec::new() }
}

/// A ring from its point nearest to `from` once round and back, with more points.
fn around(ring: &Pass, from: DVec2) -> Vec<DVec2> {
    let line: Vec<DVec2> = ring.line().collect();
    let (_, segment, start) = closest(&line, from);
    let n = line.len() - 1;
    let corners = (1..=n).map(|k| line[(segment + k) % n]);
    let coarse: Vec<DVec2> =
        core::iter::once(start).chain(corners).chain(core::iter::once(start)).collect();
    let mut out = Vec::with_capacity(DENSER * coarse.len());
    for w in coarse.windows(2) {
        out.extend((0..DENSER).map(|k| w[0].lerp(w[1], k as f64 / DENSER as f64)));
    }
    out.push(start);
    out.dedup();
    out
}

fn nearest(ring: &Pass, p: DVec2) -> DVec2 {
    let line: Vec<DVec2> = ring.line().collect();
    closest(&line, p).2
}

/// Squared distance, segment and place of the point of a polyline nearest to `p`.
fn closest(line: &[DVec2], p: DVec2) -> (f64, usize, DVec2) {
    let on = |(i, w): (usize, &[DVec2])| {
        let way = w[1] - w[0];
        let t = ((p - w[0]).dot(way) / way.length_squared()).clamp(0.0, 1.0);
        let at = if t.is_nan() { w[0] } else { w[0] + way * t };
        (at.distance_squared(p), i, at)
    };
    let best = line.windows(2).enumerate().map(on).min_by(|a, b| a.0.total_cmp(&b.0));
    best.unwrap_or((f64::INFINITY, 0, p))
}
