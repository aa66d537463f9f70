//! Runs of points for which one block will do: along a straight line, or along an arc in the plane XY whose height grows with
//! its angle.
//!
//! Steps: (1) from a point on, runs of 2, 4, 8, ... moves are tried until one does not fit, and the longest between is found by
//! halving; (2) an arc goes through the first, a middle and the last point, and its middle is shifted so that points lie as
//! far inside as outside; (3) all points of a run, and the middles between them, must lie within the tolerance of it.

use core::f64::consts::{PI, TAU};
use evencut_core::geometry::math::{atan2, hypot};
use evencut_core::geometry::{DVec2, DVec3, distance_to_segment};

/// Most moves of a run.
pub(super) const MOST: usize = 2048;
/// Largest turn of an arc, rad, less than half: controllers disagree on what is longer.
const LARGEST_TURN: f64 = 0.95 * PI;
/// Radius of an arc and its chord, mm, at least; and the radius at most.
const SMALLEST: f64 = 0.02;
const LARGEST_RADIUS: f64 = 2000.0;

/// What a run lies along.
#[derive(Copy, Clone, Debug, PartialEq)]
pub(super) enum Shape {
    Line,
    Arc { centre: DVec2, counter_clockwise: bool },
}

/// The longest run of at least two moves that begins at the first of `tips`: how many moves, and along what.
pub(super) fn longest(tips: &[DVec3], tolerance: f64) -> Option<(usize, Shape)> {
    let most = (tips.len().saturating_sub(1)).min(MOST);
    let run = |shape: &dyn Fn(&[DVec3]) -> Option<Shape>| {
        let fits = |moves: usize| shape(&tips[..=moves]);
        let mut best = (2 <= most).then(|| fits(2)).flatten().map(|shape| (2, shape))?;
        let mut fails = None;
        while fails.is_none() && best.0 < most {
            let next = (2 * best.0).min(most);
            match fits(next) {
                Some(shape) => best = (next, shape),
                None => fails = Some(next),
            }
        }
        let mut fails = fails.unwrap_or(best.0);
        while fails > best.0 + 1 {
            let middle = (best.0 + fails) / 2;
            match fits(middle) {
                Some(shape) => best = (middle, shape),
                None => fails = middle,
            }
        }
        Some(best)
    };
    let line = run(&|tips| line(tips, tolerance));
    let arc = run(&|tips| arc(tips, tolerance));
    match (line, arc) {
        (Some(line), Some(arc)) if arc.0 > line.0 => Some(arc),
        (line, arc) => line.or(arc),
    }
}

/// Whether the points lie along a line, none behind the one before it.
fn line(tips: &[DVec3], tolerance: f64) -> Option<Shape> {
    let (first, last) = (*tips.first()?, *tips.last()?);
    let way = last - first;
    let goes_on = tips.windows(2).all(|w| (w[1] - w[0]).dot(way) > 0.0);
    let is_near = |tip: &DVec3| distance_to_segment(*tip, first, last) <= tolerance;
    (goes_on && tips.iter().all(is_near)).then_some(Shape::Line)
}

/// The arc along which the points lie.
fn arc(tips: &[DVec3], tolerance: f64) -> Option<Shape> {
    let (first, last) = (*tips.first()?, *tips.last()?);
    let (a, b) = (first.truncate(), last.truncate());
    let chord = b - a;
    if chord.length() < SMALLEST || !chord.is_finite() {
        return None;
    }
    // The centre lies on the line halfway between the ends, so that both radii are the same.
    let (middle, across) = (0.5 * (a + b), chord.perp() / chord.length());
    let through = |p: DVec2| {
        let (along, off) = ((p - middle).dot(chord) / chord.length(), (p - middle).dot(across));
        let half = 0.5 * chord.length();
        // |p - c| = |a - c| with c = middle + h across.
        (along * along + off * off - half * half) / (2.0 * off)
    };
    let bulge = tips[tips.len() / 2].truncate();
    let mut h = through(bulge);
    for _ in 0..2 {
        let centre = middle + h * across;
        let radius = a.distance(centre);
        if !(SMALLEST..=LARGEST_RADIUS).contains(&radius) {
            return None;
        }
        let off = |tip: &DVec3| tip.truncate().distance(centre) - radius;
        let (low, high) = tips
            .iter()
            .map(off)
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), e| (l.min(e), h.max(e)));
        let out = (bulge - centre).normalize_or_zero();
        let shifted = through(centre + out * (radius + 0.5 * (low + high)));
        if !shifted.is_finite() {
            break;
        }
        h = shifted;
    }
    let centre = middle + h * across;
    let radius = a.distance(centre);
    if !(SMALLEST..=LARGEST_RADIUS).contains(&radius) {
        return None;
    }
    let turn = |from: DVec3, to: DVec3| {
        let (p, q) = (from.truncate() - centre, to.truncate() - centre);
        atan2(p.perp_dot(q), p.dot(q))
    };
    let sense = turn(tips[0], tips[1]).signum();
    let mut turned = vec![0.0];
    for w in tips.windows(2) {
        let step = sense * turn(w[0], w[1]);
        let all = turned[turned.len() - 1] + step;
        if !(step > 0.0 && all <= LARGEST_TURN) {
            return None;
        }
        turned.push(all);
    }
    let whole = turned[turned.len() - 1];
    debug_assert!(whole < TAU);
    let off = |tip: DVec3, part: f64| {
        let height = first.z + (last.z - first.z) * part;
        hypot(tip.truncate().distance(centre) - radius, tip.z - height)
    };
    let is_near = |i: usize| {
        let here = off(tips[i], turned[i] / whole) <= tolerance;
        let between = tips.get(i + 1).is_none_or(|next| {
            off(0.5 * (tips[i] + *next), 0.5 * (turned[i] + turned[i + 1]) / whole) <= tolerance
        });
        here && between
    };
    let fits = (0..tips.len()).all(is_near);
    fits.then_some(Shape::Arc { centre, counter_clockwise: sense > 0.0 })
}

#[cfg(test)]
mod tests;
