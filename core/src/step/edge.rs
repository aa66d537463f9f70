//! The edges of faces: their curves in space, and points along them.

use crate::geometry::DVec3;
use crate::geometry::distance_to_segment;
use crate::geometry::math::{atan2, cos, sin};
use crate::nurbs::NurbsCurve;

/// Points along an edge, at least and at most.
const SAMPLES: (usize, usize) = (16, 1024);

/// Distance of two edges that are one, as a part of the extent of all edges: faces of surfaces fitted one by one meet so
/// nearly. Larger closes the blunt end of a thin blade.
const ONE_EDGE: f64 = 1e-4;
/// Places of an edge that are looked for on another.
const LOOKED_FOR: usize = 32;

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
    pub fn within(&self, tolerance: f64) -> Vec<DVec3> {
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

/// Of edges and the numbers of their faces those at which no other face goes on, as points within `chord`.
pub(super) fn outer(edges: &[(usize, &Edge)], chord: f64) -> Vec<Vec<DVec3>> {
    let uses = |edge: &Edge| edges.iter().filter(|(_, other)| other.id == edge.id).count();
    let single: Vec<(usize, Vec<DVec3>)> = edges
        .iter()
        .filter(|(_, edge)| uses(edge) == 1)
        .map(|(face, edge)| (*face, edge.within(chord)))
        .collect();
    let all = || single.iter().flat_map(|(_, line)| line);
    let (low, high) = all()
        .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), p| (low.min(*p), high.max(*p)));
    let near = ONE_EDGE * (high - low).length();
    let is_inner = |(face, line): &(usize, Vec<DVec3>)| {
        let others: Vec<&Vec<DVec3>> =
            single.iter().filter(|(other, _)| other != face).map(|(_, line)| line).collect();
        let is_met = |p: &DVec3| {
            let mut sides = others.iter().flat_map(|other| other.windows(2));
            sides.any(|w| distance_to_segment(*p, w[0], w[1]) <= near)
        };
        line.iter().step_by((line.len() / LOOKED_FOR).max(1)).all(is_met)
    };
    let bounds = single.iter().filter(|edge| !is_inner(edge));
    bounds.map(|(_, line)| line.clone()).collect()
}

/// A point of an ellipse.
fn on_ellipse(centre: DVec3, x: DVec3, y: DVec3, angle: f64) -> DVec3 {
    centre + x * cos(angle) + y * sin(angle)
}
