//! The curve at a geodesic distance from another one.
//!
//! Terms: the *raw offset* is where the geodesics end that start perpendicular to the curve; it has
//! *crossings* with itself where the curve bends inward more tightly than the distance, or comes near
//! to another part of itself; they divide it into *pieces*.
//!
//! 1. From points of the curve, with tangent T and normal N, geodesics of the distance's length along
//!    `+-(T x N)`; more points where a cubic through the ends misses them.
//! 2. Crossings of the polygon of the ends in the parameter plane, each placed exactly on the cubics.
//! 3. The winding number on the right of every piece: it changes by 1 at a crossing, and is 0 outside
//!    of the leftmost point. A piece bounds what is nearer than the distance where the number is 0 on
//!    one side and that of the whole curve's sense on the other (Chen and McMains, "Polygon offsetting
//!    by computing winding numbers", 2005, section 3), and where it runs in the curve's own direction:
//!    beyond the centre of curvature it runs against it. Other pieces, those nearer than the distance
//!    to another part of the curve, are left out.
//! 4. The pieces that remain are joined at the crossings, the longest chain is kept (a wide place
//!    behind a narrow gap makes others), and fitted; points crowd at its corners so that the spline
//!    follows them within the tolerance.

use super::error::HubError;
use super::geodesic::{Geodesic, geodesic};
use super::sampling::{Sample, Samples, toward_corner};
use super::spline::{ParameterCurve, area};
use crate::geometry::{DVec2, DVec3, OrderBy, cross2};
use crate::nurbs::NurbsSurface;

/// Parts of every knot span of the curve at which it is sampled first.
const PARTS: usize = 3;
/// Degree of the fitted curve.
const DEGREE: usize = 3;
/// Part of the tolerance that the fit may take; the rest is for the cubics between the samples.
const FIT: f64 = 0.7;
/// Part of the tolerance to which each geodesic is exact.
const EXACT: f64 = 1e-3;
/// Steps by which a crossing is placed on the cubics; each gains about two digits.
const REFINEMENTS: usize = 12;

/// A side of the direction of travel, seen from the tip of `u` cross `v` of the surface.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum Side {
    /// To the left: only tests ask for it.
    #[cfg(test)]
    Left,
    /// To the right: the outside of a curve that runs counter-clockwise.
    Right,
}

/// The curve at geodesic distance `distance` mm from `curve`, in the same sense.
///
/// Points of it are exact to a thousandth of `tolerance`, and it runs within `tolerance` mm of them.
/// Parts that are nearer to another part of the curve are trimmed; the corners that remain are kept
/// within the tolerance. Beyond an open rim of the surface it goes on as [`geodesic`] does.
///
/// Of an open curve the ends of the offset are taken to be valid, and parts are trimmed where the
/// offset crosses itself; an offset that crosses the curve itself is not seen.
///
/// # Errors
/// Those of [`geodesic`] and [`ParameterCurve::fit`]; [`HubError::NoOffset`] where nothing remains.
pub fn offset(
    surface: &NurbsSurface,
    curve: &ParameterCurve,
    distance: f64,
    side: Side,
    tolerance: f64,
) -> Result<ParameterCurve, HubError> {
    let raw = raw_offset(surface, curve, distance, side, tolerance)?;
    let closed = curve.is_closed();
    let sense = if closed && curve.area() < 0.0 { -1 } else { 0 };
    let forward = |m: f64| {
        let (end, way) = ray(surface, curve, m, distance, side, tolerance)?;
        let jet = surface.jet_beyond(end.at);
        let ahead = jet.normal().cross(jet.tangent(end.direction)) * way;
        let h = 0.25 * raw.spacing(m);
        let [before, after] =
            [m - h, m + h].map(|m| surface.jet_beyond(raw.cubic(raw.before(m), m)).point);
        Ok((after - before).dot(ahead) > 0.0)
    };
    let chain = trimmed(surface, &raw, closed, sense, tolerance, &forward)?;
    let Some(points) = chain else {
        let at = surface.jet_beyond(curve.point(0.0)).point;
        return Err(HubError::NoOffset { at, distance });
    };
    ParameterCurve::fit(surface, &points, closed, DEGREE, FIT * tolerance)
}

/// The ends of the geodesics, not trimmed, by the parameter of the curve.
fn raw_offset(
    surface: &NurbsSurface,
    curve: &ParameterCurve,
    distance: f64,
    side: Side,
    tolerance: f64,
) -> Result<Samples, HubError> {
    let breaks = curve.breaks();
    let mut starts: Vec<f64> = breaks
        .windows(2)
        .flat_map(|w| (0..PARTS).map(|k| w[0] + (w[1] - w[0]) * k as f64 / PARTS as f64))
        .collect();
    if !curve.is_closed() {
        starts.push(1.0);
    }
    let end = |m: f64| Ok(ray(surface, curve, m, distance, side, tolerance)?.0.at);
    Samples::new(surface, &starts, curve.is_closed(), tolerance, end)
}

/// The geodesic from the curve at `m`, and 1 to the right, -1 to the left.
fn ray(
    surface: &NurbsSurface,
    curve: &ParameterCurve,
    m: f64,
    distance: f64,
    side: Side,
    tolerance: f64,
) -> Result<(Geodesic, f64), HubError> {
    let [at, rate, _] = curve.jet(m);
    let jet = surface.jet_beyond(at);
    let sign = if side == Side::Right { 1.0 } else { -1.0 };
    let way = jet.tangent(rate).cross(jet.normal()) * sign;
    let way = way.try_normalize().and_then(|w| jet.rates(w));
    let way = way.ok_or(HubError::NoDirection { at: jet.point })?;
    Ok((geodesic(surface, at, way, distance, EXACT * tolerance)?, sign))
}

/// A passage of the raw offset through one of its crossings.
#[derive(Copy, Clone)]
struct Event {
    /// The sample before, and the curve's parameter.
    segment: usize,
    m: f64,
    crossing: usize,
    /// By how much the winding number on the right changes.
    change: i32,
    at: DVec2,
}

/// The valid points of a raw offset in order; `None` where there are none. `sense`: winding number on
/// the right of valid pieces; `forward`: whether it runs in the curve's direction at a parameter.
fn trimmed(
    surface: &NurbsSurface,
    raw: &Samples,
    closed: bool,
    sense: i32,
    tolerance: f64,
    forward: &impl Fn(f64) -> Result<bool, HubError>,
) -> Result<Option<Vec<DVec2>>, HubError> {
    let events = crossings(raw, closed);
    let points = || raw.list.iter().map(|s| s.at).collect::<Vec<_>>();
    if events.is_empty() {
        let turned = closed && (area(&points()) < 0.0) != (sense < 0);
        return Ok((!turned && forward(0.5)?).then(points));
    }
    // Piece k ends at event k and begins at the one before; the last of an open curve is beyond all.
    let count = events.len() + usize::from(!closed);
    let mut numbers = vec![0; count];
    for k in 1..count {
        numbers[k] = numbers[k - 1] + events[k - 1].change;
    }
    if closed {
        let (outer, number) = outside(raw);
        // Piece 0 goes on after the last event.
        let k = events.partition_point(|e| e.m < outer) % count;
        let shift = number - numbers[k];
        numbers.iter_mut().for_each(|n| *n += shift);
    }
    let mut valid = Vec::with_capacity(count);
    for (k, number) in numbers.iter().enumerate() {
        let from = if k > 0 {
            events[k - 1].m
        } else if closed {
            events[count - 1].m - 1.0
        } else {
            0.0
        };
        let to = events.get(k).map_or(1.0, |e| e.m);
        valid.push(*number == sense && forward(0.5 * (from + to))?);
    }
    let chains = chains(&events, &valid, closed);
    let mut best: Option<(f64, Vec<DVec2>)> = None;
    for chain in chains {
        let mut points = Vec::new();
        for k in chain {
            let from = if closed { (k + count - 1) % count } else { k.wrapping_sub(1) };
            piece(surface, raw, events.get(from), events.get(k), tolerance, &mut points)?;
        }
        // A hole runs the other way.
        if closed && (area(&points) < 0.0) != (sense < 0) {
            continue;
        }
        let places: Vec<DVec3> = points.iter().map(|p| surface.jet_beyond(*p).point).collect();
        let length: f64 = places.windows(2).map(|w| w[0].distance(w[1])).sum();
        if best.as_ref().is_none_or(|(l, _)| length > *l) {
            best = Some((length, points));
        }
    }
    Ok(best.map(|(_, points)| points))
}

/// The curve's parameter of the leftmost point, and the winding number on the right of it.
fn outside(raw: &Samples) -> (f64, i32) {
    let n = raw.list.len();
    let left = |a: &usize, b: &usize| raw.list[*a].at.x.total_cmp(&raw.list[*b].at.x);
    let i = (0..n).min_by(left).unwrap_or(0);
    let at = |k: usize| raw.list[k % n].at;
    let number = if cross2(at(i + n - 1), at(i), at(i + 1)) >= 0.0 { 0 } else { -1 };
    (raw.list[i].m, number)
}

/// All passages through crossings, in the order of the curve's parameter.
fn crossings(raw: &Samples, closed: bool) -> Vec<Event> {
    let n = raw.list.len();
    let segments = if closed { n } else { n.saturating_sub(1) };
    let ends = |i: usize| (raw.list[i].at, raw.list[(i + 1) % n].at);
    let mut order: Vec<usize> = (0..segments).collect();
    let low = |i: usize| ends(i).0.x.min(ends(i).1.x);
    order.order_by(|a, b| low(*a).total_cmp(&low(*b)));
    let mut events = Vec::new();
    for (k, &i) in order.iter().enumerate() {
        let (a, b) = ends(i);
        let right = a.x.max(b.x);
        for &j in order[k + 1..].iter().take_while(|j| low(**j) <= right) {
            let beside = i.abs_diff(j) == 1 || (closed && i.abs_diff(j) == segments - 1);
            let (c, d) = ends(j);
            let [p, q, r, s] = [cross2(a, b, c), cross2(a, b, d), cross2(c, d, a), cross2(c, d, b)];
            if beside || (p >= 0.0) == (q >= 0.0) || (r >= 0.0) == (s >= 0.0) {
                continue;
            }
            let crossing = events.len() / 2;
            let (m, at) = exact_crossing(raw, [i, j], [r / (r - s), p / (p - q)]);
            // The second goes to the left of the first, or the other way round.
            let change = if q > p { 1 } else { -1 };
            events.push(Event { segment: i, m: m[0], crossing, change: -change, at });
            events.push(Event { segment: j, m: m[1], crossing, change, at });
        }
    }
    events.order_by(|a, b| a.segment.cmp(&b.segment).then(a.m.total_cmp(&b.m)));
    events
}

/// Where the cubics over two segments cross: the curve's parameters and the point. `parts`: where
/// their chords do.
fn exact_crossing(raw: &Samples, pair: [usize; 2], parts: [f64; 2]) -> ([f64; 2], DVec2) {
    let ends = pair.map(|i| {
        let here = raw.list[i];
        (here, raw.get(i as isize + 1).unwrap_or(here))
    });
    let chord = |k: usize| ends[k].1.at - ends[k].0.at;
    let mut parts = parts;
    let on = |k: usize, part: f64| {
        let (a, b): (Sample, Sample) = ends[k];
        (a.m + (b.m - a.m) * part, raw.cubic(pair[k] as isize, a.m + (b.m - a.m) * part))
    };
    let det = chord(0).perp_dot(chord(1));
    for _ in 0..REFINEMENTS {
        let gap = on(1, parts[1]).1 - on(0, parts[0]).1;
        let step = [gap.perp_dot(chord(1)) / det, gap.perp_dot(chord(0)) / det];
        for k in 0..2 {
            let next = parts[k] + step[k];
            if next.is_finite() {
                parts[k] = next.clamp(0.0, 1.0);
            }
        }
    }
    let [(m, p), (n, q)] = [on(0, parts[0]), on(1, parts[1])];
    ([m, n], 0.5 * (p + q))
}

/// Valid pieces, joined at their crossings, in order.
fn chains(events: &[Event], valid: &[bool], closed: bool) -> Vec<Vec<usize>> {
    let count = valid.len();
    let valid = |k: usize| valid[k];
    // The piece that begins at the other passage of the crossing at which piece k ends.
    let next = |k: usize| {
        let end = events.get(k)?;
        let other = events.iter().enumerate();
        let mut other = other.filter(|(l, e)| *l != k && e.crossing == end.crossing);
        other.next().map(|(l, _)| (l + 1) % count).filter(|l| valid(*l))
    };
    let mut seen = vec![false; count];
    let mut chains = Vec::new();
    for start in 0..if closed { count } else { 1 } {
        let (mut chain, mut k) = (Vec::new(), Some(start).filter(|k| valid(*k)));
        while let Some(piece) = k.filter(|k| !seen[*k]) {
            seen[piece] = true;
            chain.push(piece);
            k = next(piece);
        }
        let ends_well = if closed { k == Some(start) } else { chain.last() == Some(&(count - 1)) };
        if ends_well && !chain.is_empty() {
            chains.push(chain);
        }
    }
    chains
}

/// Appends the points of a piece: its first corner, and all up to before its last one.
fn piece(
    surface: &NurbsSurface,
    raw: &Samples,
    from: Option<&Event>,
    to: Option<&Event>,
    tolerance: f64,
    points: &mut Vec<DVec2>,
) -> Result<(), HubError> {
    let n = raw.list.len();
    // Samples from the one after the first corner to the one before the last, around where it is
    // after it.
    let first = from.map_or(0, |e| e.segment + 1) as isize;
    let mut last = to.map_or(n - 1, |e| e.segment) as isize;
    if let (Some(a), Some(b)) = (from, to)
        && (b.segment, b.m) <= (a.segment, a.m)
    {
        last += n as isize;
    }
    // On the way from a corner to another point; `turn`: whole turns of the curve's parameter.
    let toward = |corner: &Event, m: f64, to: DVec2| {
        let way = move |part: f64| {
            let at = raw.cubic(corner.segment as isize, corner.m + (m - corner.m) * part);
            // The corner is the middle of two cubics' ends.
            let off = corner.at - raw.cubic(corner.segment as isize, corner.m);
            Ok(if part >= 1.0 { to } else { at + off * (1.0 - part) })
        };
        toward_corner(surface, tolerance, way)
    };
    let beside =
        |k: isize, corner: &Event| raw.get(k).map(|s| (s.m - (s.m - corner.m).round(), s.at));
    if let Some(corner) = from {
        points.push(corner.at);
        if let Some((m, at)) = beside(first, corner).filter(|_| first <= last) {
            points.extend(toward(corner, m, at)?);
        }
    }
    points.extend((first..=last).filter_map(|k| raw.get(k)).map(|s| s.at));
    if let Some(corner) = to
        && let Some((m, at)) = beside(last, corner).filter(|_| first <= last)
    {
        points.extend(toward(corner, m, at)?.into_iter().rev());
    }
    Ok(())
}

#[cfg(test)]
mod tests;
