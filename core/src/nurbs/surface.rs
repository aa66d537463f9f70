//! The surface itself: points, derivatives, normal, curvature, nearest point.

use glam::DVec4;

use super::basis::Knots;
use super::error::{Direction, NurbsError};
use crate::geometry::shape::ShapeOperator;
use crate::geometry::{DMat3, DVec2, DVec3};

/// Largest coordinate, mm; squares and cubes of lengths stay exact enough below it.
const LARGEST_COORDINATE: f64 = 1e12;
/// Range of weights.
const WEIGHTS: std::ops::RangeInclusive<f64> = 1e-9..=1e9;
/// Part of the size within which opposite sides are one seam, or a side is one point.
const COINCIDES: f64 = 1e-6;
/// Places along a side that are compared.
const SIDE_SAMPLES: usize = 33;
/// Steps of the nearest point; quadratic convergence needs about five.
const NEWTON_STEPS: usize = 40;
/// Halvings of a step that does not come nearer.
const HALVINGS: usize = 12;
/// Sine between the tangents below which the surface has no normal, and part of the mean length
/// that a tangent must have.
const SINGULAR: f64 = 1e-7;

/// A point of a surface with its derivatives by the parameters.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Jet {
    /// The point, mm.
    pub point: DVec3,
    /// First derivatives by u and v.
    pub first: [DVec3; 2],
    /// Second derivatives by uu, uv, vv.
    pub second: [DVec3; 3],
}

impl Jet {
    /// The rates of the parameters along a tangent of the surface, mm; `None` where the surface has
    /// no normal.
    pub(crate) fn rates(&self, tangent: DVec3) -> Option<DVec2> {
        let [su, sv] = self.first;
        let (e, f, g) = (su.length_squared(), su.dot(sv), sv.length_squared());
        let (a, b) = (tangent.dot(su), tangent.dot(sv));
        let area = e * g - f * f;
        // Negated, so that NaN is refused too.
        let regular = area > SINGULAR * SINGULAR * e * g && area.is_finite();
        regular.then(|| DVec2::new(g * a - f * b, e * b - f * a) / area)
    }

    /// The tangent along which the parameters change at `rates`, mm.
    pub(crate) fn tangent(&self, rates: DVec2) -> DVec3 {
        self.first[0] * rates.x + self.first[1] * rates.y
    }

    /// Unit normal, `u` cross `v`; zero where the tangents are parallel or vanish.
    pub fn normal(&self) -> DVec3 {
        let [u, v] = self.first;
        let cross = u.cross(v);
        let scale = u.length() * v.length();
        if cross.length() > SINGULAR * scale { cross / cross.length() } else { DVec3::ZERO }
    }
}

/// Parameters between neighbouring knots, where a surface is one quotient of polynomials.
#[derive(Copy, Clone, Debug, PartialEq)]
pub(crate) struct Piece {
    spans: [usize; 2],
    /// What comes off a parameter that runs on around a closed direction.
    turns: DVec2,
    /// Its least and greatest parameters; infinite where an open direction ends.
    pub low: DVec2,
    pub high: DVec2,
}

/// The numbers of a surface.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct NurbsParts {
    /// Degrees in u and v.
    pub degree: [usize; 2],
    /// Full knot vectors in u and v.
    pub knots: [Vec<f64>; 2],
    /// Control points by u, then v.
    pub points: Vec<Vec<DVec3>>,
    /// Weights of the points, of the same shape; empty for a surface that is not rational.
    pub weights: Vec<Vec<f64>>,
}

/// A rational B-spline surface.
///
/// Knot vectors may be clamped or not; the domain is where the functions sum to 1. Beyond the
/// domain a closed direction goes on around, an open one stops.
#[derive(Clone, Debug, PartialEq)]
pub struct NurbsSurface {
    knots: [Knots; 2],
    columns: usize,
    /// `(w x, w y, w z, w)`, by u, then v.
    points: Vec<DVec4>,
    closed: [bool; 2],
    /// Sides that are one point: u low, u high, v low, v high.
    degenerate: [bool; 4],
    /// Diagonal of the box of the control points, mm.
    size: f64,
}

impl NurbsSurface {
    /// A surface from its numbers.
    ///
    /// # Errors
    /// [`NurbsError`] naming the number that does not fit.
    pub fn new(parts: NurbsParts) -> Result<Self, NurbsError> {
        let NurbsParts { degree, knots: [knots_u, knots_v], points, weights } = parts;
        let (rows, columns) = (points.len(), points.first().map_or(0, Vec::len));
        if let Some((row, found)) =
            points.iter().map(Vec::len).enumerate().find(|(_, n)| *n != columns)
        {
            return Err(NurbsError::Ragged { row, found, expected: columns });
        }
        let knots = [
            Knots::new(Direction::U, degree[0], knots_u, rows)?,
            Knots::new(Direction::V, degree[1], knots_v, columns)?,
        ];
        let mut homogeneous = Vec::with_capacity(rows * columns);
        for (i, row) in points.iter().enumerate() {
            for (j, &at) in row.iter().enumerate() {
                let weight = match weights.get(i) {
                    None if weights.is_empty() => 1.0,
                    row => row.and_then(|r| r.get(j)).copied().unwrap_or(f64::NAN),
                };
                homogeneous.push(checked_point(i, j, at, weight)?);
            }
        }
        Self {
            knots,
            columns,
            points: homogeneous,
            closed: [false; 2],
            degenerate: [false; 4],
            size: 0.0,
        }
        .with_sides()
    }

    /// Finds out which sides coincide or are points.
    fn with_sides(mut self) -> Result<Self, NurbsError> {
        let positions = || self.points.iter().map(|p| p.truncate() / p.w);
        let low = positions().fold(DVec3::INFINITY, DVec3::min);
        let high = positions().fold(DVec3::NEG_INFINITY, DVec3::max);
        self.size = (high - low).length();
        if self.size <= 0.0 {
            return Err(NurbsError::NoArea);
        }
        let (from, to) = self.domain();
        let near = COINCIDES * self.size;
        let step = |k: usize| k as f64 / (SIDE_SAMPLES - 1) as f64;
        let side = |axis: usize, end: DVec2| -> Vec<DVec3> {
            (0..SIDE_SAMPLES)
                .map(|k| {
                    let mut at = from + (to - from) * step(k);
                    at[axis] = end[axis];
                    self.jet_inside(at).point
                })
                .collect()
        };
        let mut closed = [false; 2];
        let mut degenerate = [false; 4];
        for axis in 0..2 {
            let (a, b) = (side(axis, from), side(axis, to));
            let is_point = |s: &[DVec3]| s.iter().all(|p| p.distance(s[0]) <= near);
            degenerate[2 * axis] = is_point(&a);
            degenerate[2 * axis + 1] = is_point(&b);
            closed[axis] = a.iter().zip(&b).all(|(p, q)| p.distance(*q) <= near)
                && !(degenerate[2 * axis] && degenerate[2 * axis + 1]);
        }
        (self.closed, self.degenerate) = (closed, degenerate);
        Ok(self)
    }

    /// Least and greatest parameters.
    pub fn domain(&self) -> (DVec2, DVec2) {
        let [(u0, u1), (v0, v1)] = [self.knots[0].domain(), self.knots[1].domain()];
        (DVec2::new(u0, v0), DVec2::new(u1, v1))
    }

    /// Whether opposite sides coincide, in u and in v.
    pub fn closed(&self) -> [bool; 2] {
        self.closed
    }

    /// Which sides are one point: u low, u high, v low, v high.
    pub fn degenerate(&self) -> [bool; 4] {
        self.degenerate
    }

    /// Whether a rectangle of parameters goes all around, along u and along v.
    pub(super) fn around(&self, (low, high): (DVec2, DVec2)) -> [bool; 2] {
        let (from, to) = self.domain();
        [0, 1].map(|axis| self.closed[axis] && low[axis] <= from[axis] && high[axis] >= to[axis])
    }

    /// Whether the sides of a rectangle of parameters at its least and its greatest value of one are single points.
    pub(super) fn poles_of(&self, (low, high): (DVec2, DVec2), axis: usize) -> [bool; 2] {
        let (from, to) = self.domain();
        let is_pole = |end: usize| self.degenerate[2 * axis + end];
        [low[axis] <= from[axis] && is_pole(0), high[axis] >= to[axis] && is_pole(1)]
    }

    /// Diagonal of the box around the control points, mm.
    pub fn size(&self) -> f64 {
        self.size
    }

    /// Degrees in u and v.
    pub fn degree(&self) -> [usize; 2] {
        [self.knots[0].degree(), self.knots[1].degree()]
    }

    /// The different knots along an axis (0 for u, 1 for v) and how often each occurs.
    pub(crate) fn breaks(&self, axis: usize) -> Vec<(f64, usize)> {
        self.knots[axis].breaks()
    }

    /// Control points, mm, and weights, by u, then v.
    pub fn control_points(&self) -> impl Iterator<Item = (DVec3, f64)> {
        self.points.iter().map(|p| (p.truncate() / p.w, p.w))
    }

    /// Parameters in the domain that mean the same point: around along closed directions, the
    /// nearest along others.
    pub fn wrap(&self, at: DVec2) -> DVec2 {
        let (low, high) = self.domain();
        let mut at = at;
        for axis in 0..2 {
            let (l, h) = (low[axis], high[axis]);
            if self.closed[axis] && !(l..=h).contains(&at[axis]) {
                let turns = ((at[axis] - l) / (h - l)).floor();
                at[axis] -= turns * (h - l);
            }
            // NaN becomes the low end.
            at[axis] = if at[axis] >= l { at[axis].min(h) } else { l };
        }
        at
    }

    /// Point and derivatives at the parameters `at`.
    pub fn jet(&self, at: DVec2) -> Jet {
        self.jet_inside(self.wrap(at))
    }

    /// Point and derivatives at `at`; beyond the end of an open direction those of the polynomials
    /// that the surface is there.
    pub(crate) fn jet_beyond(&self, at: DVec2) -> Jet {
        self.jet_in(&self.piece(at, DVec2::ONE), at)
    }

    /// The piece that one who goes from `at` along `way` is first in. Parameters go on around along
    /// closed directions and beyond the ends of others.
    pub(crate) fn piece(&self, at: DVec2, way: DVec2) -> Piece {
        let (low, high) = self.domain();
        let (mut spans, mut turns) = ([0; 2], DVec2::ZERO);
        let mut ends = [DVec2::NEG_INFINITY, DVec2::INFINITY];
        for axis in 0..2 {
            let (l, period) = (low[axis], high[axis] - low[axis]);
            let forward = way[axis] >= 0.0;
            if self.closed[axis] {
                let whole = ((at[axis] - l) / period).floor();
                let starts = !forward && at[axis] - whole * period <= l;
                turns[axis] = (whole - if starts { 1.0 } else { 0.0 }) * period;
            }
            let (span, [from, to]) = self.knots[axis].span_toward(at[axis] - turns[axis], forward);
            spans[axis] = span;
            if self.closed[axis] || from > l {
                ends[0][axis] = from + turns[axis];
            }
            if self.closed[axis] || to < high[axis] {
                ends[1][axis] = to + turns[axis];
            }
        }
        Piece { spans, turns, low: ends[0], high: ends[1] }
    }

    /// Point and derivatives at `at` of the polynomials that the surface is in a piece.
    pub(crate) fn jet_in(&self, piece: &Piece, at: DVec2) -> Jet {
        self.jet_of(piece.spans, at - piece.turns)
    }

    /// Position at the parameters `at`, mm.
    pub fn point(&self, at: DVec2) -> DVec3 {
        let at = self.wrap(at);
        let (u, v) = (self.knots[0].values(at.x), self.knots[1].values(at.y));
        let mut sum = DVec4::ZERO;
        for i in 0..=self.knots[0].degree() {
            let row = &self.row(u.first + i)[v.first..];
            let count = self.knots[1].degree() + 1;
            let along: DVec4 = row.iter().zip(&v.values[..count]).map(|(p, n)| *p * *n).sum();
            sum += along * u.values[i];
        }
        sum.truncate() / sum.w
    }

    /// The `i`-th row of control points.
    fn row(&self, i: usize) -> &[DVec4] {
        &self.points[i * self.columns..(i + 1) * self.columns]
    }

    fn jet_inside(&self, at: DVec2) -> Jet {
        let span = |axis: usize| self.knots[axis].span_toward(at[axis], true).0;
        self.jet_of([span(0), span(1)], at)
    }

    /// # Source
    /// Piegl and Tiller, "The NURBS Book", algorithms A3.6 and A4.4.
    fn jet_of(&self, spans: [usize; 2], at: DVec2) -> Jet {
        let u = self.knots[0].basis_in(spans[0], at.x);
        let v = self.knots[1].basis_in(spans[1], at.y);
        // 1, u, v, uu, uv, vv.
        let mut a = [DVec4::ZERO; 6];
        for i in 0..=self.knots[0].degree() {
            let mut along = [DVec4::ZERO; 3];
            let row = &self.row(u.first + i)[v.first..];
            for (j, p) in row.iter().enumerate().take(self.knots[1].degree() + 1) {
                for (sum, n) in along.iter_mut().zip(&v.values) {
                    *sum += *p * n[j];
                }
            }
            let n = [u.values[0][i], u.values[1][i], u.values[2][i]];
            for (slot, (order_u, order_v)) in
                [(0, 0), (1, 0), (0, 1), (2, 0), (1, 1), (0, 2)].into_iter().enumerate()
            {
                a[slot] += along[order_v] * n[order_u];
            }
        }
        quotient(a)
    }

    /// Unit normal at `at`, `u` cross `v`; zero where there is none.
    pub fn normal(&self, at: DVec2) -> DVec3 {
        self.jet(at).normal()
    }

    /// Exact shape operator, its normal along `u` cross `v`; `None` where there is no normal.
    pub fn shape(&self, at: DVec2) -> Option<ShapeOperator> {
        let jet = self.jet(at);
        let regular = jet.normal() != DVec3::ZERO
            && jet
                .first
                .iter()
                .zip(self.mean_tangents())
                .all(|(t, mean)| t.length() > SINGULAR * mean);
        regular.then(|| ShapeOperator::from_derivatives(jet.first, jet.second))
    }

    /// Lengths of the tangents of a surface of this size that runs evenly.
    fn mean_tangents(&self) -> [f64; 2] {
        let (low, high) = self.domain();
        [self.size / (high.x - low.x), self.size / (high.y - low.y)]
    }

    /// The same surface after `matrix`, then moved by `shift`.
    ///
    /// # Errors
    /// [`NurbsError::NotFinite`] where a point lands too far out.
    pub fn transformed(&self, matrix: DMat3, shift: DVec3) -> Result<Self, NurbsError> {
        let mut moved = self.clone();
        for (index, p) in moved.points.iter_mut().enumerate() {
            let at = matrix * (p.truncate() / p.w) + shift;
            *p = checked_point(index / self.columns, index % self.columns, at, p.w)?;
        }
        moved.with_sides()
    }

    /// The parameters of the point nearest to `target`, from a guess near by, and the distance, mm.
    ///
    /// Parameters go on around along closed directions. Converges to a local minimum.
    ///
    /// # Source
    /// Newton's method on the squared distance (Piegl and Tiller, section 6.1), with Gauss's
    /// approximation where the second derivatives do not make it convex, and halved steps.
    pub fn project(&self, target: DVec3, guess: DVec2) -> (DVec2, f64) {
        let mut at = self.limited(guess);
        let mut jet = self.jet(at);
        let mut distance = jet.point.distance_squared(target);
        for _ in 0..NEWTON_STEPS {
            let step = self.newton_step(&jet, target, at);
            let mut factor = 1.0;
            let mut better = None;
            for _ in 0..HALVINGS {
                let next = self.limited(at + step * factor);
                let there = self.jet(next);
                let d = there.point.distance_squared(target);
                if d < distance {
                    better = Some((next, there, d));
                    break;
                }
                factor *= 0.5;
            }
            let Some((next, there, d)) = better else { break };
            let gained = distance - d;
            (at, jet, distance) = (next, there, d);
            if gained <= 1e-14 * distance || distance <= 1e-24 * self.size * self.size {
                break;
            }
        }
        (at, distance.sqrt())
    }

    /// Clamped along open directions only.
    fn limited(&self, at: DVec2) -> DVec2 {
        let (low, high) = self.domain();
        let mut limited = at;
        for axis in 0..2 {
            if !self.closed[axis] || !at[axis].is_finite() {
                limited[axis] = at[axis].max(low[axis]).min(high[axis]);
            }
        }
        limited
    }

    fn newton_step(&self, jet: &Jet, target: DVec3, at: DVec2) -> DVec2 {
        let offset = jet.point - target;
        let [su, sv] = jet.first;
        let mut gradient = DVec2::new(offset.dot(su), offset.dot(sv));
        let (e, f, g) = (su.length_squared(), su.dot(sv), sv.length_squared());
        let [uu, uv, vv] = jet.second.map(|s| offset.dot(s));
        // Along a side that the step would leave, the other parameter moves alone.
        let (low, high) = self.domain();
        let stuck = |axis: usize, g: f64| {
            !self.closed[axis]
                && ((at[axis] <= low[axis] && g > 0.0) || (at[axis] >= high[axis] && g < 0.0))
        };
        let stuck = [stuck(0, gradient.x), stuck(1, gradient.y)];
        let mut h = [e + uu, f + uv, g + vv];
        let convex = h[0] > 0.0 && h[2] > 0.0 && h[0] * h[2] - h[1] * h[1] > 1e-9 * h[0] * h[2];
        if !convex {
            h = [e, f, g];
        }
        for axis in 0..2 {
            if stuck[axis] {
                gradient[axis] = 0.0;
                h[1] = 0.0;
            }
        }
        // A ridge keeps steps finite where the tangents are parallel or vanish.
        let ridge = 1e-12;
        let (a, c) = (h[0] + ridge * e + f64::MIN_POSITIVE, h[2] + ridge * g + f64::MIN_POSITIVE);
        let det = a * c - h[1] * h[1];
        if det > 1e-14 * a * c {
            -DVec2::new(c * gradient.x - h[1] * gradient.y, a * gradient.y - h[1] * gradient.x)
                / det
        } else {
            -DVec2::new(gradient.x / a, gradient.y / c) * 0.5
        }
    }
}

fn checked_point(i: usize, j: usize, at: DVec3, weight: f64) -> Result<DVec4, NurbsError> {
    // Negated, so that NaN is refused too.
    if !(at.is_finite() && at.abs().max_element() < LARGEST_COORDINATE) {
        return Err(NurbsError::NotFinite { i, j, at });
    }
    if !WEIGHTS.contains(&weight) {
        return Err(NurbsError::Weight { i, j, weight });
    }
    Ok((at * weight).extend(weight))
}

fn quotient(a: [DVec4; 6]) -> Jet {
    let [s, u, v, uu, uv, vv] = a;
    let w = s.w;
    let point = s.truncate() / w;
    let su = (u.truncate() - point * u.w) / w;
    let sv = (v.truncate() - point * v.w) / w;
    let suu = (uu.truncate() - su * (2.0 * u.w) - point * uu.w) / w;
    let suv = (uv.truncate() - sv * u.w - su * v.w - point * uv.w) / w;
    let svv = (vv.truncate() - sv * (2.0 * v.w) - point * vv.w) / w;
    Jet { point, first: [su, sv], second: [suu, suv, svv] }
}
