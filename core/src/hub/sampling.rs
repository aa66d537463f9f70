//! Points of a curve that is known by evaluation, as dense as a cubic through them needs.
//!
//! Every interval is halved; where the cubic through the four points around it misses its middle by
//! more than a quarter of the tolerance, its halves are halved in turn. Splines through the points
//! are then as near as the cubics (an interpolating cubic spline is a fourth-order method as well).

use super::error::HubError;
use crate::geometry::DVec2;
use crate::nurbs::NurbsSurface;

/// Rounds of halving. More follows cusps farther, where points within the tolerance stop it anyhow.
const ROUNDS: usize = 24;
/// Points, at most: beyond it a curve is refused rather than computed for minutes.
const MOST: usize = 20_000;
/// Halvings of the way to a corner.
const TOWARD_CORNER: usize = 40;

/// A point of a curve and its parameter.
#[derive(Copy, Clone, Debug, PartialEq)]
pub(super) struct Sample {
    /// The curve's parameter.
    pub m: f64,
    /// Parameters of the surface.
    pub at: DVec2,
}

/// Points of a curve in increasing order of its parameter.
#[derive(Clone, Debug)]
pub(super) struct Samples {
    /// The points; of a closed curve the first, at 0, is not repeated at 1.
    pub list: Vec<Sample>,
    closed: bool,
}

impl Samples {
    /// Samples `curve` at `starts`, increasing, and between them as densely as cubics need that stay
    /// within `tolerance` mm. A closed curve has parameters from 0 to less than 1.
    pub fn new(
        surface: &NurbsSurface,
        starts: &[f64],
        closed: bool,
        tolerance: f64,
        mut curve: impl FnMut(f64) -> Result<DVec2, HubError>,
    ) -> Result<Self, HubError> {
        let place = |at: DVec2| surface.jet_beyond(at).point;
        let mut sampled = |m: f64| Ok(Sample { m, at: curve(m)? });
        let list: Result<Vec<Sample>, HubError> = starts.iter().map(|m| sampled(*m)).collect();
        let mut samples = Self { list: list?, closed };
        // Whether the interval after each point is to be halved.
        let mut coarse = vec![true; samples.list.len()];
        for _ in 0..ROUNDS {
            if !coarse.contains(&true) {
                break;
            }
            let (mut list, mut flags) = (Vec::new(), Vec::new());
            for (i, (here, coarse)) in samples.list.iter().zip(&coarse).enumerate() {
                list.push(*here);
                let Some(next) = samples.get(i as isize + 1).filter(|_| *coarse) else {
                    flags.push(false);
                    continue;
                };
                let m = 0.5 * (here.m + next.m);
                let middle = sampled(m)?;
                let (a, b, c) = (place(here.at), place(middle.at), place(next.at));
                let missed = b.distance(place(samples.cubic(i as isize, m)));
                let tiny = a.distance(b).max(b.distance(c)) < 0.25 * tolerance;
                let more = missed > 0.25 * tolerance && !tiny;
                list.push(middle);
                flags.extend([more; 2]);
            }
            if let Some(last) = list.last().filter(|_| list.len() > MOST) {
                return Err(HubError::TooFine { at: place(last.at), most: MOST, tolerance });
            }
            samples.list = list;
            coarse = flags;
        }
        Ok(samples)
    }

    /// The point `i`; a closed curve goes on around.
    pub fn get(&self, i: isize) -> Option<Sample> {
        let n = self.list.len() as isize;
        if self.closed && n > 0 {
            let s = self.list[i.rem_euclid(n) as usize];
            Some(Sample { m: s.m + i.div_euclid(n) as f64, at: s.at })
        } else {
            usize::try_from(i).ok().and_then(|i| self.list.get(i)).copied()
        }
    }

    /// The last point at or before `m`.
    pub fn before(&self, m: f64) -> isize {
        let turns = if self.closed { m.floor() } else { 0.0 };
        let after = self.list.partition_point(|s| s.m <= m - turns) as isize;
        after - 1 + turns as isize * self.list.len() as isize
    }

    /// How far apart the parameters around `m` are.
    pub fn spacing(&self, m: f64) -> f64 {
        let i = self.before(m);
        match (self.get(i), self.get(i + 1)) {
            (Some(a), Some(b)) => b.m - a.m,
            _ => 0.0,
        }
    }

    /// The cubic through the points around the interval from point `i` to the next, at `m`; of a
    /// lower degree where there are fewer.
    pub fn cubic(&self, i: isize, m: f64) -> DVec2 {
        let near: Vec<Sample> = (i - 1..=i + 2).filter_map(|k| self.get(k)).collect();
        let part = |(k, s): (usize, &Sample)| {
            let others = near.iter().enumerate().filter(|(l, _)| *l != k);
            let weight: f64 = others.map(|(_, o)| (m - o.m) / (s.m - o.m)).product();
            s.at * weight
        };
        near.iter().enumerate().map(part).sum()
    }
}

/// Points between a corner and `to`, that of the corner first, nearer to it by halves until they are
/// within a quarter of the tolerance: there a spline's knots may stand so close that it follows the
/// corner. `curve` gives the point at a part of the way, 0 at the corner.
pub(super) fn toward_corner(
    surface: &NurbsSurface,
    tolerance: f64,
    mut curve: impl FnMut(f64) -> Result<DVec2, HubError>,
) -> Result<Vec<DVec2>, HubError> {
    let corner = surface.jet_beyond(curve(0.0)?).point;
    let (mut part, mut points) = (0.5, Vec::new());
    for _ in 0..TOWARD_CORNER {
        let at = curve(part)?;
        points.push(at);
        if surface.jet_beyond(at).point.distance(corner) < 0.25 * tolerance {
            break;
        }
        part *= 0.5;
    }
    points.reverse();
    Ok(points)
}
