//! The edge of a fillet or blade on the hub.
//!
//! Terms: a *foot* is a surface of a fillet, or of a blade that has none, which ends at the hub; its
//! *run* is the part of its edge that lies on the hub.
//!
//! 1. Of each foot the side that lies on the hub within the tolerance, or nearly so, and half of it not
//!    beyond the rim; else the curve in which it meets the hub: along each of its lines across the hub the height over the hub changes its sign
//!    (the foot may be continued a little to get there, as the hub may beyond its rim), and the place
//!    is found by regula falsi.
//! 2. The runs are put in a row end to end, turned where they must be. A short gap, as that of a blunt
//!    trailing edge, is closed by a straight piece in the parameter plane.
//! 3. Points so dense that cubics through them keep the tolerance, crowded at the joints, where the
//!    edge may have corners; counter-clockwise; fitted.

use super::error::HubError;
use super::sampling::{Samples, toward_corner};
use super::spline::{ParameterCurve, area};
use crate::geometry::{DVec2, DVec3, OrderBy};
use crate::nurbs::NurbsSurface;

/// Degree of the fitted curve.
const DEGREE: usize = 3;
/// Part of the tolerance that the fit may take; the rest is for the cubics between the samples.
const FIT: f64 = 0.7;
/// Part of the domain by which the hub is continued beyond an open rim. Larger reaches blades that
/// overhang farther, on polynomials that resemble the hub less.
const BEYOND_RIM: f64 = 0.15;
/// Part of the hub's size by which a side may be off it and still be the edge, where none is nearer: surfaces fitted to
/// measured blades end so near to it.
const NEAR: f64 = 5e-4;
/// Part of its domain by which a foot is continued to reach the hub.
const BEYOND_FOOT: f64 = 0.05;
/// Part of the length of all runs that a gap may have to be closed. Larger would close one side of a
/// blade to a blade; smaller leaves thick trailing edges open.
const GAP: f64 = 0.05;
/// Part of the longest run's length from which on another one is a flank of the blade, too, and no end of it.
const FLANK: f64 = 0.2;
/// Part of the hub's domain within which an end is at its rim.
const AT_RIM: f64 = 0.01;
/// Places along a side or line that are tried.
const PLACES: usize = 65;
/// Places along either parameter of the hub from which the nearest point is looked for.
const GRID: usize = 33;
/// Places across the hub at which the height is taken.
const HEIGHTS: usize = 17;
/// Trials for a place on the hub; each gains about a digit and a half.
const TRIALS: usize = 60;
/// Halvings of the end of a run.
const HALVINGS: usize = 40;
/// Steps of the nearest point beyond a rim, and halvings of each.
const NEWTON_STEPS: usize = 30;
const STEP_HALVINGS: usize = 10;

/// The edge of a blade's `feet` on the hub, in the hub's parameters.
///
/// `feet`: the fillet, or the blade where it has none; several surfaces may make the ring together, in
/// any order. Those that do not meet the hub are left out; of several closed rings the widest counts. Counter-clockwise around the blade as seen from the tip of `u` cross `v`; an open edge
/// as it would be with a straight line between its ends. `tolerance`, mm: how far a side may be off the
/// hub to be the edge, and how far the curve may be off the edge.
///
/// Closed where the edge closes, also over a gap of up to a twentieth of its length. Where the blade
/// runs beyond the rim of the hub, the edge goes on by up to 15 % of the hub's domain on the
/// polynomials that the hub is at its rim; what is farther is left out, and the edge is open there.
///
/// # Errors
/// [`HubError::NoFoot`]; [`HubError::NoEdge`] where no foot meets the hub;
/// [`HubError::EdgeGap`] between feet; those of [`ParameterCurve::fit`].
pub fn edge_on_hub(
    hub: &NurbsSurface,
    feet: &[NurbsSurface],
    tolerance: f64,
) -> Result<ParameterCurve, HubError> {
    let finder = Finder { hub, tolerance, coarse: coarse(hub) };
    let (mut runs, mut without) = (Vec::new(), None);
    for (index, foot) in feet.iter().enumerate() {
        match finder.run(index, foot) {
            Ok(run) => runs.push(run),
            Err(error) => without = without.or(Some(error)),
        }
    }
    if runs.is_empty() {
        return Err(without.unwrap_or(HubError::NoFoot));
    }
    let mut widest: Option<(f64, Vec<DVec2>)> = None;
    for ring in runs.iter().filter(|run| run.closed) {
        let path = finder.path(ring, false, DVec2::ZERO)?;
        let starts: Vec<f64> = (0..PLACES).map(|k| k as f64 / PLACES as f64).collect();
        let samples = Samples::new(hub, &starts, true, tolerance, path)?;
        let points: Vec<DVec2> = samples.list.iter().map(|s| s.at).collect();
        let size = area(&points).abs();
        if widest.as_ref().is_none_or(|(most, _)| size > *most) {
            widest = Some((size, points));
        }
    }
    if let Some((_, points)) = widest {
        return fitted(hub, points, true, tolerance);
    }
    let (links, closed) = finder.links(&runs)?;
    let mut points = Vec::new();
    for link in &links {
        points.extend(finder.points(link)?);
    }
    fitted(hub, points, closed, tolerance)
}

/// The edge that the bounds of a blade's faces are where they lie on the hub; `None` where those make no ring, as of
/// blades that end within the hub.
///
/// `bounds`: points along the edges that bound the faces taken together, in any order and sense; a bound counts as a
/// whole. Sense, tolerance, rim and gaps as for [`edge_on_hub`], but an open edge runs from rim to rim. The edge is as
/// exact between the points as they are dense.
///
/// # Errors
/// Those of [`ParameterCurve::fit`].
pub fn edge_along(
    hub: &NurbsSurface,
    bounds: &[Vec<DVec3>],
    tolerance: f64,
) -> Result<Option<ParameterCurve>, HubError> {
    let finder = Finder { hub, tolerance, coarse: coarse(hub) };
    let on_hub: Vec<(Vec<DVec2>, f64)> = bounds.iter().filter_map(|b| finder.on_hub(b)).collect();
    for within in [tolerance, tolerance.max(NEAR * hub.size())] {
        let near: Vec<&Vec<DVec2>> =
            on_hub.iter().filter(|(_, off)| *off <= within).map(|(line, _)| line).collect();
        let rings = finder.rings(near);
        let widest = rings.into_iter().max_by(|a, b| {
            let size = |ring: &Ring| area(&ring.points).abs();
            size(a).total_cmp(&size(b))
        });
        if let Some(Ring { points, closed }) = widest {
            return fitted(hub, points, closed, tolerance).map(Some);
        }
    }
    Ok(None)
}

/// The curve through points, counter-clockwise.
fn fitted(
    hub: &NurbsSurface,
    mut points: Vec<DVec2>,
    closed: bool,
    tolerance: f64,
) -> Result<ParameterCurve, HubError> {
    if area(&points) < 0.0 {
        points.reverse();
    }
    ParameterCurve::fit(hub, &points, closed, DEGREE, FIT * tolerance)
}

/// Points all over the hub and their parameters.
fn coarse(hub: &NurbsSurface) -> Vec<(DVec2, DVec3)> {
    let (low, high) = hub.domain();
    let part = |k: usize| (k as f64 + 0.5) / GRID as f64;
    (0..GRID * GRID)
        .map(|k| low + (high - low) * DVec2::new(part(k / GRID), part(k % GRID)))
        .map(|at| (at, hub.point(at)))
        .collect()
}

fn nearest(coarse: &[(DVec2, DVec3)], target: DVec3) -> DVec2 {
    let off = |c: &(DVec2, DVec3)| c.1.distance_squared(target);
    let best = coarse.iter().min_by(|a, b| off(a).total_cmp(&off(b)));
    best.map_or(DVec2::ZERO, |c| c.0)
}

/// Whether parameters are in the domain or near enough to an open rim.
fn is_near_domain(hub: &NurbsSurface, at: DVec2) -> bool {
    let (low, high) = hub.domain();
    let reach = (high - low) * BEYOND_RIM;
    let inside =
        |i: usize| (low[i] - reach[i]..=high[i] + reach[i]).contains(&at[i]) || hub.closed()[i];
    at.is_finite() && inside(0) && inside(1)
}

/// The parameters of the nearest point of the surface and its distance, mm; beyond an open rim on the
/// polynomials that the surface is there.
///
/// # Source
/// Newton's method on the squared distance, as [`NurbsSurface::project`].
fn project(surface: &NurbsSurface, target: DVec3, guess: DVec2) -> (DVec2, f64) {
    let (mut at, mut distance) = surface.project(target, guess);
    let (low, high) = surface.domain();
    let on_rim = |i: usize| !surface.closed()[i] && (at[i] <= low[i] || at[i] >= high[i]);
    if !(on_rim(0) || on_rim(1)) {
        return (at, distance);
    }
    for _ in 0..NEWTON_STEPS {
        let jet = surface.jet_beyond(at);
        let off = jet.point - target;
        let [su, sv] = jet.first;
        let gradient = DVec2::new(off.dot(su), off.dot(sv));
        let [uu, uv, vv] = jet.second.map(|s| off.dot(s));
        let (e, f, g) = (su.length_squared() + uu, su.dot(sv) + uv, sv.length_squared() + vv);
        let det = e * g - f * f;
        let step = if e > 0.0 && det > 1e-9 * e * g {
            DVec2::new(g * gradient.x - f * gradient.y, e * gradient.y - f * gradient.x) / det
        } else {
            jet.rates(off).unwrap_or(DVec2::ZERO)
        };
        let mut better = None;
        let mut factor = 1.0;
        for _ in 0..STEP_HALVINGS {
            let next = at - step * factor;
            let there = surface.jet_beyond(next).point.distance(target);
            if there < distance {
                better = Some((next, there));
                break;
            }
            factor *= 0.5;
        }
        let Some((next, there)) = better else { break };
        let gained = distance - there;
        (at, distance) = (next, there);
        if gained <= 1e-14 * surface.size() {
            break;
        }
    }
    (at, distance)
}

/// What gives a run's points.
#[derive(Copy, Clone)]
enum Edge {
    /// The side of the foot at a value of the parameter across.
    Side {
        /// Value of the foot's other parameter.
        across: f64,
        /// How far it may be off the hub, mm.
        within: f64,
    },
    /// Where the foot meets the hub.
    Meeting,
}

/// Places in a row that are on the hub.
#[derive(Copy, Clone)]
struct Row {
    axis: usize,
    edge: Edge,
    first: usize,
    last: usize,
}

impl Row {
    fn count(&self) -> usize {
        self.last + 1 - self.first
    }
}

/// The part of a foot's edge that lies on the hub.
struct Run<'a> {
    foot: &'a NurbsSurface,
    /// The foot's parameter along the edge: 0 for u, 1 for v.
    axis: usize,
    edge: Edge,
    /// Its values at both ends.
    ends: [f64; 2],
    closed: bool,
}

/// A run, or the straight piece over a gap, in its place in the row.
enum Link<'a> {
    Run {
        run: &'a Run<'a>,
        /// Whether it is followed from its end to its beginning.
        turned: bool,
        /// Where it begins, on the turn around the hub on which the one before ends.
        start: DVec2,
        /// Whether its beginning and end may be corners.
        corners: bool,
    },
    Gap(DVec2, DVec2),
}

/// Bounds in a row, with the points of a curve through them.
struct Ring {
    points: Vec<DVec2>,
    closed: bool,
}

struct Finder<'a> {
    hub: &'a NurbsSurface,
    tolerance: f64,
    coarse: Vec<(DVec2, DVec3)>,
}

impl<'a> Finder<'a> {
    /// Parameters of the hub for a point in space, the distance with the sign of the normal's side,
    /// mm.
    fn height(&self, at: DVec3) -> (DVec2, f64) {
        let (on, off) = project(self.hub, at, nearest(&self.coarse, at));
        let jet = self.hub.jet_beyond(on);
        (on, if (at - jet.point).dot(jet.normal()) < 0.0 { -off } else { off })
    }

    /// Parameters of the hub on an edge; `None` where the edge is not on the hub.
    fn on_edge(&self, foot: &NurbsSurface, axis: usize, edge: Edge, along: f64) -> Option<DVec2> {
        let at = |across: f64| {
            let mut at = DVec2::splat(across);
            at[axis] = along;
            foot.jet_beyond(at).point
        };
        let (on, off) = match edge {
            Edge::Side { across, .. } => self.height(at(across)),
            Edge::Meeting => {
                let across = self.meeting(foot, 1 - axis, &at)?;
                self.height(at(across))
            }
        };
        let within = match edge {
            Edge::Side { within, .. } => within,
            Edge::Meeting => self.tolerance,
        };
        (off.abs() <= within && is_near_domain(self.hub, on)).then_some(on)
    }

    /// Parameters of a bound's points, without a jump, and how far they are off the hub, mm; `None` if some are too far
    /// beyond its rim or off it.
    fn on_hub(&self, bound: &[DVec3]) -> Option<(Vec<DVec2>, f64)> {
        let within = self.tolerance.max(NEAR * self.hub.size());
        let (mut line, mut farthest) = (Vec::with_capacity(bound.len()), 0.0_f64);
        for &point in bound {
            let (on, off) = self.height(point);
            if !(off.abs() <= within && is_near_domain(self.hub, on)) {
                return None;
            }
            let last = line.last().copied().unwrap_or(on);
            line.push(self.beside(on, last));
            farthest = farthest.max(off.abs());
        }
        (line.len() > 1).then_some((line, farthest))
    }

    /// Bounds put end to end, the longest first: those rows that close, and those from rim to rim.
    fn rings(&self, bounds: Vec<&Vec<DVec2>>) -> Vec<Ring> {
        let place = |at: DVec2| self.hub.jet_beyond(at).point;
        let length = |line: &[DVec2]| {
            line.windows(2).map(|w| place(w[0]).distance(place(w[1]))).sum::<f64>()
        };
        let mut left: Vec<(f64, &Vec<DVec2>)> =
            bounds.into_iter().map(|line| (length(line), line)).collect();
        left.order_by(|a, b| a.0.total_cmp(&b.0));
        let mut rings = Vec::new();
        while let Some((mut total, first)) = left.pop() {
            let mut row: Vec<Vec<DVec2>> = vec![first.clone()];
            let closed = loop {
                let (Some(start), Some(end)) = (
                    row.first().and_then(|line| line.first()).copied(),
                    row.last().and_then(|line| line.last()).copied(),
                ) else {
                    break false;
                };
                let to_start = place(end).distance(place(start));
                let ends = left.iter().enumerate().flat_map(|(k, (_, line))| {
                    let ends = [(line.first(), false), (line.last(), true)];
                    ends.map(|(at, turned)| {
                        let gap = at.map_or(f64::INFINITY, |at| place(*at).distance(place(end)));
                        (gap, k, turned)
                    })
                });
                let next = ends.min_by(|a, b| a.0.total_cmp(&b.0));
                match next.filter(|(gap, ..)| *gap < to_start && *gap <= GAP * total) {
                    Some((_, k, turned)) => {
                        let (length, line) = left.remove(k);
                        total += length;
                        row.push(self.following(line, turned, end));
                    }
                    None if to_start <= GAP * total => break true,
                    None if row.len() > 1 || self.is_at_rim(end) => {
                        // On from the other end, if that may be continued.
                        let begins_free = !self.is_at_rim(start);
                        if !(begins_free && self.is_at_rim(end)) {
                            break false;
                        }
                        row.reverse();
                        row.iter_mut().for_each(|line| line.reverse());
                        if !self.can_go_on(&row, &left, GAP * total) {
                            break false;
                        }
                    }
                    None => break false,
                }
            };
            let ends = [row.first().and_then(|l| l.first()), row.last().and_then(|l| l.last())];
            if closed || ends.iter().all(|end| end.is_some_and(|end| self.is_at_rim(*end))) {
                rings.push(Ring { points: self.through(&row), closed });
            }
        }
        rings
    }

    /// Whether a bound begins or ends beside the end of a row.
    fn can_go_on(&self, row: &[Vec<DVec2>], left: &[(f64, &Vec<DVec2>)], allowed: f64) -> bool {
        let place = |at: &DVec2| self.hub.jet_beyond(*at).point;
        let Some(end) = row.last().and_then(|line| line.last()).map(place) else { return false };
        let ends = left.iter().flat_map(|(_, line)| [line.first(), line.last()]);
        ends.flatten().any(|at| place(at).distance(end) <= allowed)
    }

    /// A bound that follows on `end`, on the same turn around the hub.
    fn following(&self, line: &[DVec2], turned: bool, end: DVec2) -> Vec<DVec2> {
        let mut line = line.to_vec();
        if turned {
            line.reverse();
        }
        let shift = line.first().map_or(DVec2::ZERO, |first| self.beside(*first, end) - *first);
        line.iter_mut().for_each(|at| *at += shift);
        line
    }

    /// Whether a place is at an open rim of the hub or beyond it.
    fn is_at_rim(&self, at: DVec2) -> bool {
        let (low, high) = self.hub.domain();
        let near = AT_RIM * (high - low);
        let is_at = |i: usize| at[i] <= low[i] + near[i] || at[i] >= high[i] - near[i];
        (0..2).any(|i| !self.hub.closed()[i] && is_at(i))
    }

    /// Points along a row of bounds, crowded at their ends, where there may be corners.
    fn through(&self, row: &[Vec<DVec2>]) -> Vec<DVec2> {
        let place = |at: DVec2| self.hub.jet_beyond(at).point;
        let mut points: Vec<DVec2> = Vec::new();
        for line in row {
            let [first, second, .., before, last] = line[..] else {
                points.extend(line);
                continue;
            };
            let crowd = |corner: DVec2, to: DVec2| {
                toward_corner(self.hub, self.tolerance, |part| Ok(corner.lerp(to, part)))
                    .unwrap_or_default()
            };
            let is_new = |p: &DVec2| place(*p).distance(place(first)) > 0.25 * self.tolerance;
            if points.last().is_none_or(is_new) {
                points.push(first);
            }
            points.extend(crowd(first, second));
            points.extend(&line[1..line.len() - 1]);
            points.extend(crowd(last, before).into_iter().rev());
            points.push(last);
        }
        let (first, last) = (points.first().copied(), points.last().copied());
        if let (Some(first), Some(last)) = (first, last)
            && points.len() > 1
            && place(first).distance(place(last)) <= 0.25 * self.tolerance
        {
            points.pop();
        }
        points
    }

    /// Where a line of the foot passes through the hub, nearest to the low end of the foot.
    ///
    /// # Source
    /// Regula falsi as changed by Dowell and Jarratt ("Illinois"), 1971.
    fn meeting(
        &self,
        foot: &NurbsSurface,
        across: usize,
        at: &dyn Fn(f64) -> DVec3,
    ) -> Option<f64> {
        let (low, high) = (foot.domain().0[across], foot.domain().1[across]);
        let beyond = if foot.closed()[across] { 0.0 } else { BEYOND_FOOT * (high - low) };
        let (from, to) = (low - beyond, high + beyond);
        let height = |t: f64| {
            let (on, off) = self.height(at(t));
            // Far beyond the rim it says nothing.
            is_near_domain(self.hub, on).then_some(off)
        };
        let mut last: Option<(f64, f64)> = None;
        let mut bracket = None;
        for k in 0..HEIGHTS {
            let t = from + (to - from) * k as f64 / (HEIGHTS - 1) as f64;
            let here = height(t).map(|h| (t, h));
            if let (Some(a), Some(b)) = (last, here)
                && (a.1 < 0.0) != (b.1 < 0.0)
            {
                bracket = Some((a, b));
                break;
            }
            last = here;
        }
        let ((mut a, mut fa), (mut b, mut fb)) = bracket?;
        for _ in 0..TRIALS {
            let t = (a * fb - b * fa) / (fb - fa);
            let f = height(t)?;
            if f.abs() <= 1e-3 * self.tolerance * FIT || b - a <= 1e-14 * (high - low) {
                return Some(t);
            }
            if (f < 0.0) == (fb < 0.0) {
                (b, fb) = (t, f);
                fa *= 0.5;
            } else {
                (a, fa) = (t, f);
                fb *= 0.5;
            }
        }
        Some(0.5 * (a + b))
    }

    /// The run of a foot.
    fn run<'f>(&self, index: usize, foot: &'f NurbsSurface) -> Result<Run<'f>, HubError> {
        let (low, high) = foot.domain();
        let sides = [(0, low.y), (0, high.y), (1, low.x), (1, high.x)];
        let degenerate = foot.degenerate();
        let sides = sides.into_iter().zip([2, 3, 0, 1]).filter(|(_, side)| !degenerate[*side]);
        let sides: Vec<(usize, f64)> = sides.map(|(side, _)| side).collect();
        let on_hub = |within: f64| {
            let all = sides.iter().map(|&(axis, across)| (axis, Edge::Side { across, within }));
            let on_hub: Vec<(usize, Edge)> = all.filter(|s| self.stays(foot, s)).collect();
            self.best(foot, &on_hub).filter(|row| 2 * row.count() >= PLACES)
        };
        let near = self.tolerance.max(NEAR * self.hub.size());
        let best = on_hub(self.tolerance).or_else(|| on_hub(near));
        let best = best.or_else(|| self.best(foot, &[(0, Edge::Meeting), (1, Edge::Meeting)]));
        let Some(best) = best.filter(|row| row.count() >= 2) else {
            let mut nearest = (DVec3::ZERO, f64::INFINITY);
            for (axis, across) in sides {
                for k in 0..PLACES {
                    let mut at = DVec2::splat(across);
                    at[axis] = along(foot, axis, k);
                    let at = foot.point(at);
                    let off = self.height(at).1.abs();
                    if off < nearest.1 {
                        nearest = (at, off);
                    }
                }
            }
            let (at, off) = nearest;
            return Err(HubError::NoEdge { foot: index, at, off, tolerance: self.tolerance });
        };
        let Row { axis, edge, first: from, last: to } = best;
        let closed = foot.closed()[axis] && best.count() == PLACES;
        let valid = |t: f64| self.on_edge(foot, axis, edge, t).is_some();
        // From a place on the hub to one that is not.
        let reach = |on: usize, off: Option<usize>| {
            let mut on = along(foot, axis, on);
            let Some(mut off) = off.filter(|k| *k < PLACES).map(|k| along(foot, axis, k)) else {
                return on;
            };
            for _ in 0..HALVINGS {
                let middle = 0.5 * (on + off);
                *(if valid(middle) { &mut on } else { &mut off }) = middle;
            }
            on
        };
        let ends = [reach(from, from.checked_sub(1)), reach(to, Some(to + 1))];
        Ok(Run { foot, axis, edge, ends, closed })
    }

    /// Whether a side of a foot is nowhere off the hub, other than beyond its rim.
    fn stays(&self, foot: &NurbsSurface, (axis, edge): &(usize, Edge)) -> bool {
        let Edge::Side { across, within } = edge else { return true };
        (0..PLACES).all(|k| {
            let mut at = DVec2::splat(*across);
            at[*axis] = along(foot, *axis, k);
            let (on, off) = self.height(foot.point(at));
            off.abs() <= *within || !is_near_domain(self.hub, on)
        })
    }

    /// Of some edges of a foot the one with most places in a row on the hub.
    fn best(&self, foot: &NurbsSurface, edges: &[(usize, Edge)]) -> Option<Row> {
        let mut best: Option<Row> = None;
        for &(axis, edge) in edges {
            let mut first = 0;
            for last in 0..PLACES {
                if self.on_edge(foot, axis, edge, along(foot, axis, last)).is_none() {
                    first = last + 1;
                    continue;
                }
                let row = Row { axis, edge, first, last };
                if best.is_none_or(|b| row.count() > b.count()) {
                    best = Some(row);
                }
            }
        }
        best
    }

    /// The hub's parameters by the part of a run, from 0 to 1. They go on without a jump over seams of
    /// the hub, from the turn that is nearest to `start`.
    fn path(
        &self,
        run: &Run<'_>,
        turned: bool,
        start: DVec2,
    ) -> Result<impl Fn(f64) -> Result<DVec2, HubError>, HubError> {
        let point = move |part: f64| {
            let part = if turned { 1.0 - part } else { part };
            let along = run.ends[0] + (run.ends[1] - run.ends[0]) * part;
            self.on_edge(run.foot, run.axis, run.edge, along).ok_or_else(|| {
                let mut at = run.foot.domain().0;
                at[run.axis] = along;
                let at = run.foot.jet_beyond(at).point;
                HubError::OffHub { at, off: self.height(at).1.abs() }
            })
        };
        let most = (PLACES - 1) as f64;
        let mut places = vec![start];
        for k in 0..PLACES {
            let last = places[k];
            places.push(self.beside(point(k as f64 / most)?, last));
        }
        Ok(move |part: f64| {
            let near = places[1 + (part * most).round().clamp(0.0, most) as usize];
            Ok(self.beside(point(part)?, near))
        })
    }

    /// The same point, whole turns around the hub nearest to `other`.
    fn beside(&self, at: DVec2, other: DVec2) -> DVec2 {
        let (low, high) = self.hub.domain();
        let mut at = at;
        for i in 0..2 {
            if self.hub.closed()[i] {
                let period = high[i] - low[i];
                at[i] += ((other[i] - at[i]) / period).round() * period;
            }
        }
        at
    }

    /// The runs in a row with the gaps closed, and whether they make a ring.
    fn links<'r>(&self, runs: &'r [Run<'r>]) -> Result<(Vec<Link<'r>>, bool), HubError> {
        let place = |at: DVec2| self.hub.jet_beyond(at).point;
        let (mut each, mut ends) = (Vec::new(), Vec::new());
        for run in runs {
            let path = self.path(run, false, DVec2::ZERO)?;
            let points: Vec<DVec2> =
                (0..=16).map(|k| path(f64::from(k) / 16.0)).collect::<Result<_, _>>()?;
            each.push(points.windows(2).map(|w| place(w[0]).distance(place(w[1]))).sum::<f64>());
            ends.push([points[0], points[16]]);
        }
        let lengths: f64 = each.iter().sum();
        let allowed = GAP * lengths;
        let (row, gap) = self.row(&ends, &each, allowed);
        let (start, end) = (begin_of(&ends, row[0]), end_of(&ends, row[row.len() - 1]));
        let closed = place(start).distance(place(end)) <= allowed;
        let is_from_rim_to_rim = self.is_at_rim(start) && self.is_at_rim(end);
        if runs.len() > 1 && !closed && !is_from_rim_to_rim {
            let gap = gap.unwrap_or(place(start).distance(place(end)));
            return Err(HubError::EdgeGap { at: place(end), gap, allowed });
        }
        let mut links: Vec<Link<'r>> = Vec::new();
        let mut last = start;
        for (k, &(run, turned)) in row.iter().enumerate() {
            let begin = self.beside(begin_of(&ends, (run, turned)), last);
            if k > 0 {
                links.push(Link::Gap(last, begin));
            }
            links.push(Link::Run { run: &runs[run], turned, start: begin, corners: true });
            last = self.beside(end_of(&ends, (run, turned)), begin);
        }
        if closed {
            links.push(Link::Gap(last, self.beside(start, last)));
        } else if let [Link::Run { corners, .. }] = &mut links[..] {
            *corners = false;
        }
        Ok((links, closed))
    }

    /// Runs end to end, and whether each is turned: from the longest on whichever is the nearest, at either end, until the
    /// row closes or ends at the rim, or the gap to the next one, which is given, too, is too wide. Others are left out:
    /// they belong to what of the blade's body is not its foot.
    fn row(
        &self,
        ends: &[[DVec2; 2]],
        lengths: &[f64],
        allowed: f64,
    ) -> (Vec<(usize, bool)>, Option<f64>) {
        let place = |at: DVec2| self.hub.jet_beyond(at).point;
        let longest = (0..lengths.len()).max_by(|a, b| lengths[*a].total_cmp(&lengths[*b]));
        let longest = longest.unwrap_or(0);
        let mut row = vec![(longest, false)];
        let mut left: Vec<usize> = (0..ends.len()).filter(|run| *run != longest).collect();
        loop {
            let (start, end) = (begin_of(ends, row[0]), end_of(ends, row[row.len() - 1]));
            let around = place(start).distance(place(end));
            let free = [!self.is_at_rim(start), !self.is_at_rim(end)];
            let choices = left.iter().enumerate().flat_map(|(k, &run)| {
                [(false, false), (false, true), (true, false), (true, true)].map(
                    |(turned, at_end)| {
                        let next = (run, turned);
                        let gap = match at_end {
                            true => place(begin_of(ends, next)).distance(place(end)),
                            false => place(end_of(ends, next)).distance(place(start)),
                        };
                        (gap, k, turned, at_end)
                    },
                )
            });
            // Beyond the rim only another flank follows.
            let is_flank = |k: usize| lengths[left[k]] >= FLANK * lengths[longest];
            let choices =
                choices.filter(|(_, k, _, at_end)| free[usize::from(*at_end)] || is_flank(*k));
            let Some((gap, k, turned, at_end)) = choices.min_by(|a, b| a.0.total_cmp(&b.0)) else {
                return (row, None);
            };
            if gap > allowed || row.len() > 1 && around < gap {
                return (row, Some(gap));
            }
            let next = (left.remove(k), turned);
            row.insert(if at_end { row.len() } else { 0 }, next);
        }
    }

    /// Points of a link in order.
    fn points(&self, link: &Link<'_>) -> Result<Vec<DVec2>, HubError> {
        let Link::Run { run, turned, start, corners } = link else {
            let Link::Gap(from, to) = link else { return Ok(Vec::new()) };
            let (from, to) = (*from, *to);
            let mut points =
                toward_corner(self.hub, self.tolerance, |p| Ok(from + (to - from) * (0.5 * p)))?;
            points.push(0.5 * (from + to));
            let back =
                toward_corner(self.hub, self.tolerance, |p| Ok(to + (from - to) * (0.5 * p)))?;
            points.extend(back.into_iter().rev());
            return Ok(points);
        };
        let on = self.path(run, *turned, *start)?;
        let starts: Vec<f64> = (0..PLACES).map(|k| k as f64 / (PLACES - 1) as f64).collect();
        let samples = Samples::new(self.hub, &starts, false, self.tolerance, &on)?;
        let mut points: Vec<DVec2> = samples.list.iter().map(|s| s.at).collect();
        if *corners && let [first, second, .., before, end] = &samples.list[..] {
            let tail = 1.0 - before.m;
            let ahead = toward_corner(self.hub, self.tolerance, |p| on(second.m * p))?;
            let behind = toward_corner(self.hub, self.tolerance, |p| on(1.0 - tail * p))?;
            points = vec![first.at];
            points.extend(ahead);
            points.extend(samples.list[1..samples.list.len() - 1].iter().map(|s| s.at));
            points.extend(behind.into_iter().rev());
            points.push(end.at);
        }
        Ok(points)
    }
}

/// Where a run begins and ends, turned or not.
fn begin_of(ends: &[[DVec2; 2]], (run, turned): (usize, bool)) -> DVec2 {
    ends[run][usize::from(turned)]
}

fn end_of(ends: &[[DVec2; 2]], (run, turned): (usize, bool)) -> DVec2 {
    ends[run][usize::from(!turned)]
}

/// Place `k` along an axis of a foot.
fn along(foot: &NurbsSurface, axis: usize, k: usize) -> f64 {
    let (low, high) = (foot.domain().0[axis], foot.domain().1[axis]);
    low + (high - low) * k as f64 / (PLACES - 1) as f64
}

#[cfg(test)]
mod tests;
