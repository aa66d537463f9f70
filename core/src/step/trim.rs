//! Edges in space → trimming loops in the parameters.
//!
//! Points along an edge are projected to the surface one after the other, each from the parameters
//! of the one before, so that a loop goes on where a closed surface has its seam. Curves in the
//! parameters that a file may give are not needed: they are approximations of the same edges.

use super::model::on_ellipse;
use crate::geometry::math::atan2;
use crate::geometry::{DVec2, DVec3};
use crate::nurbs::{NurbsCurve, NurbsSurface, TrimLoop};

/// Points along an edge, at least and at most.
const SAMPLES: (usize, usize) = (16, 1024);
/// Part of the chord error that the points of an edge may leave.
const PART: f64 = 0.25;
/// Distance of an edge from its surface, as a part of the surface's size, that is refused.
const FARTHEST: f64 = 2e-3;
/// The same from which another place of the surface is looked for.
const ASTRAY: f64 = 1e-5;
/// Places of the surface from which the nearest point is sought, along a parameter, and how many
/// of the nearest are tried.
const SEEDS: (usize, usize) = (24, 6);

/// The curve of an edge.
#[derive(Clone, Debug)]
pub(super) enum Curve {
    /// A point and a unit direction.
    Line(DVec3, DVec3),
    /// Centre and semi-axes.
    Ellipse(DVec3, DVec3, DVec3),
    Spline(NurbsCurve),
}

/// An edge of a face.
#[derive(Clone, Debug)]
pub(super) struct Edge {
    /// The edge that faces share.
    pub id: u64,
    pub curve: Curve,
    /// Its vertices in space and their numbers.
    pub ends: [DVec3; 2],
    pub vertices: [u64; 2],
    /// Whether it runs along its curve.
    pub same: bool,
    /// Whether the face runs along it.
    pub forward: bool,
}

impl Edge {
    /// `count + 1` points in the direction of the face.
    pub fn samples(&self, count: usize) -> Vec<DVec3> {
        let [a, b] = if self.same { self.ends } else { [self.ends[1], self.ends[0]] };
        let closed = self.vertices[0] == self.vertices[1] || a == b;
        let part = |k: usize| k as f64 / count as f64;
        let mut points: Vec<DVec3> = match &self.curve {
            Curve::Line(..) => (0..=count).map(|k| a.lerp(b, part(k))).collect(),
            Curve::Ellipse(centre, x, y) => {
                let angle = |p: DVec3| {
                    let d = p - *centre;
                    atan2(d.dot(*y) / y.length_squared(), d.dot(*x) / x.length_squared())
                };
                let (from, mut turn) = (angle(a), angle(b) - angle(a));
                if closed || turn <= 1e-12 {
                    turn += std::f64::consts::TAU;
                }
                if closed {
                    turn = std::f64::consts::TAU;
                }
                (0..=count).map(|k| on_ellipse(*centre, *x, *y, from + turn * part(k))).collect()
            }
            Curve::Spline(curve) => {
                let (low, high) = curve.domain();
                let (mut from, mut to) =
                    if closed { (low, high) } else { (nearest(curve, a), nearest(curve, b)) };
                if from >= to {
                    // A closed curve that starts elsewhere goes on over its end.
                    let around = curve.point(low).distance(curve.point(high))
                        < 1e-6 * a.distance(b).max(1e-9);
                    if around { to += high - low } else { (from, to) = (low, high) }
                }
                let at = |t: f64| curve.point(if t > high { t - (high - low) } else { t });
                (0..=count).map(|k| at(from + (to - from) * part(k))).collect()
            }
        };
        if self.same != self.forward {
            points.reverse();
        }
        points
    }

    /// Points so dense that the lines between them stay within `tolerance` of the curve.
    fn within(&self, tolerance: f64) -> Vec<DVec3> {
        let mut count = SAMPLES.0;
        if let Curve::Spline(curve) = &self.curve {
            count = count.max(2 * curve.spans()).min(SAMPLES.1);
        }
        loop {
            let points = self.samples(2 * count);
            let off =
                |k: usize| points[2 * k + 1].distance(0.5 * (points[2 * k] + points[2 * k + 2]));
            let worst = (0..count).map(off).fold(0.0, f64::max);
            // Halving the step leaves a quarter.
            if worst <= 4.0 * tolerance || 2 * count >= SAMPLES.1 {
                return points;
            }
            count *= 2;
        }
    }

    fn start(&self) -> u64 {
        self.vertices[usize::from(!self.forward)]
    }

    fn end(&self) -> u64 {
        self.vertices[usize::from(self.forward)]
    }
}

/// Parameter of the point of a curve nearest to `p`.
fn nearest(curve: &NurbsCurve, p: DVec3) -> f64 {
    let (low, high) = curve.domain();
    let count = 8 * curve.spans() + 8;
    let step = (high - low) / count as f64;
    let distance = |t: f64| curve.point(t).distance_squared(p);
    let at = |k: usize| if k == count { high } else { low + step * k as f64 };
    let best =
        (0..=count).min_by(|&a, &b| distance(at(a)).total_cmp(&distance(at(b)))).unwrap_or(0);
    let (mut a, mut b) = ((at(best) - step).max(low), (at(best) + step).min(high));
    for _ in 0..80 {
        let (c, d) = (a + (b - a) / 3.0, b - (b - a) / 3.0);
        if distance(c) <= distance(d) { b = d } else { a = c }
    }
    let inner = 0.5 * (a + b);
    [low, high, inner]
        .into_iter()
        .min_by(|x, y| distance(*x).total_cmp(&distance(*y)))
        .unwrap_or(inner)
}

/// The edges of a face by bound.
#[derive(Clone, Debug)]
pub(super) struct Edges {
    pub bounds: Vec<Vec<Edge>>,
}

impl Edges {
    /// The loops that remain once edges that are run along both ways (seams) are left out.
    pub fn without_seams(&self) -> Vec<Vec<&Edge>> {
        let all: Vec<&Edge> = self.bounds.iter().flatten().collect();
        let is_seam = |e: &Edge| all.iter().any(|o| o.id == e.id && o.forward != e.forward);
        if !all.iter().any(|e| is_seam(e)) {
            return self.bounds.iter().map(|b| b.iter().collect()).collect();
        }
        let mut left: Vec<&Edge> = all.iter().filter(|e| !is_seam(e)).copied().collect();
        left.reverse();
        let mut loops = Vec::new();
        while let Some(first) = left.pop() {
            let mut chain = vec![first];
            while let Some(next) =
                left.iter().rposition(|e| e.start() == chain[chain.len() - 1].end())
            {
                if chain[chain.len() - 1].end() == first.start() {
                    break;
                }
                chain.push(left.remove(next));
            }
            loops.push(chain);
        }
        loops
    }
}

/// The trimming loops of a face on `surface`, the face at their left in the parameters.
///
/// `chord`: what the mesh may be off, in the units of the surface; `reversed`: the face looks
/// against `u` cross `v`.
pub(super) fn loops(
    surface: &NurbsSurface,
    edges: &Edges,
    chord: f64,
    reversed: bool,
) -> Result<Vec<TrimLoop>, &'static str> {
    let tracker = Tracker::new(surface);
    let closed = surface.closed() != [false; 2];
    let plain = || edges.bounds.iter().map(|b| b.iter().collect()).collect();
    let chains: Vec<Vec<&Edge>> = if closed { edges.without_seams() } else { plain() };
    let mut result = Vec::new();
    for chain in chains.into_iter().filter(|c| !c.is_empty()) {
        let (mut points, mut corners) = (Vec::new(), Vec::new());
        for edge in chain {
            corners.push(points.len());
            let samples = edge.within(PART * chord);
            points.extend(&samples[..samples.len() - 1]);
        }
        let mut line = tracker.project(&points, &corners)?;
        if reversed {
            line = turned(line);
        }
        result.push(line);
    }
    Ok(result)
}

/// The same loop the other way round.
fn turned(line: TrimLoop) -> TrimLoop {
    let n = line.points.len();
    let TrimLoop { mut points, corners, winding } = line;
    points.reverse();
    let mut corners: Vec<usize> = corners.iter().map(|c| n - 1 - c).collect();
    corners.sort_unstable();
    TrimLoop { points, corners, winding: winding.map(|w| -w) }
}

/// Projects points one after the other.
struct Tracker<'a> {
    surface: &'a NurbsSurface,
    seeds: Vec<(DVec2, DVec3)>,
}

impl<'a> Tracker<'a> {
    fn new(surface: &'a NurbsSurface) -> Self {
        let (low, high) = surface.domain();
        let part = |k: usize| k as f64 / (SEEDS.0 - 1) as f64;
        let mut seeds = Vec::new();
        for i in 0..SEEDS.0 {
            for j in 0..SEEDS.0 {
                let at = low + (high - low) * DVec2::new(part(i), part(j));
                seeds.push((at, surface.point(at)));
            }
        }
        Self { surface, seeds }
    }

    /// The nearest point from anywhere.
    fn anywhere(&self, p: DVec3) -> (DVec2, f64) {
        let mut near: Vec<(f64, DVec2)> =
            self.seeds.iter().map(|(at, q)| (q.distance_squared(p), *at)).collect();
        near.sort_by(|a, b| a.0.total_cmp(&b.0));
        let tried = near.iter().take(SEEDS.1).map(|(_, at)| self.surface.project(p, *at));
        tried.min_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or((DVec2::ZERO, f64::INFINITY))
    }

    /// The side that is one point and is at `p`, and the parameters there.
    fn pole(&self, p: DVec3) -> Option<(usize, DVec2)> {
        let (low, high) = self.surface.domain();
        (0..4).filter(|&side| self.surface.degenerate()[side]).find_map(|side| {
            let at = if side % 2 == 0 { low } else { high };
            let near = ASTRAY * self.surface.size();
            (self.surface.point(at).distance(p) <= near).then_some((side / 2, at))
        })
    }

    /// `at` moved by whole periods to where it is nearest to `near`.
    fn unwrapped(&self, at: DVec2, near: DVec2) -> DVec2 {
        let (low, high) = self.surface.domain();
        let mut moved = at;
        for axis in 0..2 {
            if self.surface.closed()[axis] {
                let period = high[axis] - low[axis];
                moved[axis] -= ((at[axis] - near[axis]) / period).round() * period;
            }
        }
        moved
    }

    fn project(&self, points: &[DVec3], corners: &[usize]) -> Result<TrimLoop, &'static str> {
        let size = self.surface.size();
        let n = points.len();
        // Start where the parameters have a meaning.
        let start =
            (0..n).find(|&k| self.pole(points[k]).is_none()).ok_or("its edges are one point")?;
        let mut line = TrimLoop::default();
        let mut before = self.anywhere(points[start]).0;
        let first = before;
        let mut through_pole = false;
        for k in (start..start + n).chain([start + n]) {
            let p = points[k % n];
            if let Some((axis, end)) = self.pole(p) {
                before[axis] = end[axis];
                if !through_pole {
                    line.corners.push(line.points.len());
                    line.points.push(before);
                }
                through_pole = true;
                continue;
            }
            let (mut at, mut off) =
                if through_pole { self.anywhere(p) } else { self.surface.project(p, before) };
            if off > ASTRAY * size {
                let other = self.anywhere(p);
                if other.1 < 0.5 * off {
                    (at, off) = other;
                }
            }
            if off > FARTHEST * size || off.is_nan() {
                return Err("an edge does not lie on its surface");
            }
            at = self.unwrapped(at, before);
            if through_pole {
                // From the pole the loop goes on along another line of the parameters.
                let last = line.points.len() - 1;
                let mut leave = at;
                let (axis, _) =
                    self.pole(points[(k + n - 1) % n]).ok_or("an edge touches a pole")?;
                leave[axis] = line.points[last][axis];
                line.corners.push(line.points.len());
                line.points.push(leave);
                through_pole = false;
            }
            if k < start + n {
                if corners.contains(&(k % n)) {
                    line.corners.push(line.points.len());
                }
                line.points.push(at);
            } else {
                let (low, high) = self.surface.domain();
                let turns = (at - first) / (high - low);
                let turn = |axis: usize| {
                    if self.surface.closed()[axis] { turns[axis].round() as i32 } else { 0 }
                };
                line.winding = [turn(0), turn(1)];
            }
            before = at;
        }
        Ok(line)
    }
}
