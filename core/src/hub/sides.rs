//! The offset curve of a blade → the sides of the channels at its two flanks.
//!
//! - *Nose*: the end of the offset curve that is foremost along the hub; *tail*: the other one. Where a blade reaches to
//!   the rim of the hub the curve ends there.
//! - *Flank*: the curve from nose to tail at one side of the blade.
//!
//! A side begins where the curve has turned from the direction around by 45 degrees, or is square to it where it turns
//! on: a cut across the channel from nose to nose would touch both curves, and the channel would end in a cusp.

use super::error::HubError;
use super::spline::ParameterCurve;
use super::wheel::Wheel;
use crate::geometry::{DVec2, DVec3};

/// Points of an offset curve that are looked at.
const POINTS: usize = 1440;
/// Sine of the angle between flank and direction around from which on it is a side of a channel.
const TURNED: f64 = core::f64::consts::FRAC_1_SQRT_2;
/// Part of a flank that is its end: one over this.
const END: usize = 5;
/// Share of the greatest sine below which a flank has turned back.
const BACK: f64 = 0.97;

/// The two flanks of a blade, from nose to tail, as points in the parameters.
#[derive(Clone, Debug)]
pub struct Flanks {
    /// The one at which the parameter around is smaller.
    pub before: Vec<DVec2>,
    /// The one at which it is greater.
    pub behind: Vec<DVec2>,
}

impl Flanks {
    /// Those of an offset curve. `for_cut`: without what runs around the ends of the blade.
    ///
    /// # Errors
    /// [`HubError::NoFlanks`] where the curve does not lie around a blade.
    pub fn new(wheel: &Wheel, curve: &ParameterCurve, for_cut: bool) -> Result<Self, HubError> {
        let along = 1 - wheel.around;
        let count = if curve.is_closed() { POINTS } else { POINTS + 1 };
        let points: Vec<DVec2> =
            (0..count).map(|i| curve.point(i as f64 / POINTS as f64)).collect();
        let extreme = |sign: f64| {
            let by_height = |a: &usize, b: &usize| {
                (sign * points[*a][along]).total_cmp(&(sign * points[*b][along]))
            };
            (0..points.len()).min_by(by_height).unwrap_or(0)
        };
        let (nose, tail) = (extreme(1.0), extreme(-1.0));
        let flanks = match curve.is_closed() {
            true => {
                let forward = |from: usize, to: usize| {
                    let steps = (to + points.len() - from) % points.len();
                    let all = (0..=steps).map(|k| points[(from + k) % points.len()]);
                    all.collect::<Vec<DVec2>>()
                };
                let mut back = forward(tail, nose);
                back.reverse();
                [forward(nose, tail), back]
            }
            false => {
                let (is_nose, turn) = if points[0][along] > points[nose][along] {
                    (true, nose)
                } else {
                    (false, tail)
                };
                let (mut first, second) = (points[..=turn].to_vec(), points[turn..].to_vec());
                if is_nose {
                    first.reverse();
                    [first, second]
                } else {
                    let mut second = second;
                    second.reverse();
                    [first, second]
                }
            }
        };
        let [a, b] = flanks.map(|flank| trimmed(wheel, flank, for_cut));
        let mean =
            |f: &[DVec2]| f.iter().map(|p| p[wheel.around]).sum::<f64>() / f.len().max(1) as f64;
        if a.len() < 8 || b.len() < 8 {
            return Err(HubError::NoFlanks { at: wheel.hub.point(points[nose]) });
        }
        let (before, behind) = if mean(&a) < mean(&b) { (a, b) } else { (b, a) };
        Ok(Self { before, behind })
    }

    /// The flanks of the blade that stands so many pitches farther on.
    ///
    /// # Errors
    /// [`HubError::NotAlike`].
    pub fn carried(&self, wheel: &Wheel, pitches: i32, tolerance: f64) -> Result<Self, HubError> {
        let carry = |flank: &[DVec2]| {
            flank.iter().map(|p| wheel.carried(*p, pitches, tolerance)).collect::<Result<_, _>>()
        };
        Ok(Self { before: carry(&self.before)?, behind: carry(&self.behind)? })
    }
}

/// A flank without what lies beyond the hub, and without what runs around its ends.
fn trimmed(wheel: &Wheel, flank: Vec<DVec2>, for_cut: bool) -> Vec<DVec2> {
    let along = 1 - wheel.around;
    let (low, high) = wheel.ends();
    let mut inside: Vec<DVec2> = Vec::with_capacity(flank.len());
    for (i, &p) in flank.iter().enumerate() {
        let is_in = |q: DVec2| (low..=high).contains(&q[along]);
        if let Some(&before) = i.checked_sub(1).and_then(|k| flank.get(k))
            && is_in(p) != is_in(before)
        {
            let (inner, outer) = if is_in(p) { (p, before) } else { (before, p) };
            let end = if outer[along] > high { high } else { low };
            let part = (end - inner[along]) / (outer[along] - inner[along]);
            let mut at = inner.lerp(outer, part);
            at[along] = end;
            inside.push(at);
        }
        if is_in(p) {
            inside.push(p);
        }
    }
    if !for_cut {
        return inside;
    }
    let sine = |pair: &[DVec2]| {
        let way = wheel.hub.point(pair[1]) - wheel.hub.point(pair[0]);
        let around = wheel.ways(pair[0])[0].normalize_or_zero();
        (way - around * way.dot(around)).length() / way.length().max(f64::MIN_POSITIVE)
    };
    let sines: Vec<f64> = inside.windows(2).map(sine).collect();
    let first = match inside.first() {
        Some(&p) if wheel.is_at_rim(p) => 0,
        _ => beginning(sines.iter().copied()),
    };
    let last = match inside.last() {
        Some(&p) if wheel.is_at_rim(p) => inside.len(),
        _ => inside.len() - beginning(sines.iter().rev().copied()),
    };
    inside.get(first..last).unwrap_or_default().to_vec()
}

/// Index of the piece of a flank, from its end, with which a side of a channel begins; `sines`: of the angles between
/// pieces and the direction around. Where the flank runs back around the end of the blade it is the place at which it is
/// square to that direction, else the first that is turned.
fn beginning(sines: impl ExactSizeIterator<Item = f64>) -> usize {
    let near = (sines.len() / END).max(1);
    let sines: Vec<f64> = sines.take(near).collect();
    let steepest = (0..sines.len()).max_by(|&a, &b| sines[a].total_cmp(&sines[b])).unwrap_or(0);
    let most = sines.get(steepest).copied().unwrap_or(0.0);
    if sines.last().is_some_and(|last| *last < BACK * most) {
        return steepest;
    }
    sines.iter().position(|sine| *sine >= TURNED).unwrap_or(steepest)
}

/// Places at equal parts of a line's length on the hub: `count` of them, with both ends.
pub fn spaced(wheel: &Wheel, line: &[DVec2], count: usize) -> Vec<DVec2> {
    let places: Vec<DVec3> = line.iter().map(|p| wheel.hub.point(*p)).collect();
    let mut lengths = vec![0.0; line.len()];
    for i in 1..line.len() {
        lengths[i] = lengths[i - 1] + places[i].distance(places[i - 1]);
    }
    let total = lengths.last().copied().unwrap_or(0.0);
    let at = |k: usize| {
        let wanted = total * k as f64 / (count - 1) as f64;
        let i = lengths.partition_point(|l| *l < wanted).clamp(1, line.len() - 1);
        let piece = lengths[i] - lengths[i - 1];
        let part = if piece > 0.0 { (wanted - lengths[i - 1]) / piece } else { 0.0 };
        line[i - 1].lerp(line[i], part.clamp(0.0, 1.0))
    };
    (0..count).map(at).collect()
}

/// The narrowest place between two sides: middle and width, mm; the width is negative where they cross.
pub fn narrowest(wheel: &Wheel, left: &[DVec2], right: &[DVec2]) -> (DVec3, f64) {
    let along = 1 - wheel.around;
    let places: Vec<DVec3> = right.iter().map(|p| wheel.hub.point(*p)).collect();
    let mut worst = (DVec3::ZERO, f64::INFINITY);
    for &p in left {
        let place = wheel.hub.point(p);
        let nearest = places
            .iter()
            .min_by(|a, b| a.distance_squared(place).total_cmp(&b.distance_squared(place)));
        let Some(&nearest) = nearest else { continue };
        // Beyond the other side at the same height along the hub.
        let crossed = right.windows(2).any(|w| {
            let (a, b) = (w[0][along] - p[along], w[1][along] - p[along]);
            let part = a / (a - b);
            a * b <= 0.0 && a != b && w[0].lerp(w[1], part)[wheel.around] < p[wheel.around]
        });
        let width = nearest.distance(place) * if crossed { -1.0 } else { 1.0 };
        if width < worst.1 {
            worst = (0.5 * (place + nearest), width);
        }
    }
    worst
}

#[cfg(test)]
mod tests;
