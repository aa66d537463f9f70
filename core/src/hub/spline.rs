//! B-spline curves in the parameter plane of a surface.
//!
//! Terms: the *parameter* m of a curve runs from 0 to 1 with the arc length on the surface; a
//! *candidate* is a place where a knot may stand.
//!
//! 1. The points get parameters by their chords in space (Piegl and Tiller, "The NURBS Book",
//!    equation 9.5).
//! 2. Least squares with a few knots (the same, section 9.4.1, with the normal equations 9.65); a
//!    closed curve has a periodic knot vector, so that it is as smooth at its seam as elsewhere.
//! 3. Spans in which a point is farther from its place on the curve than the tolerance, measured in
//!    space, are divided in the middle of their points, and step 2 is repeated. Every knot is at a
//!    point (for even degrees between two), so that no span is empty and the equations stay regular
//!    (Schoenberg and Whitney, 1953); with all candidates the curve interpolates.
//! 4. Values by the recursion of Cox and de Boor.

use super::error::HubError;
use crate::geometry::{DVec2, DVec3};
use crate::nurbs::{Direction, Knots, LARGEST_DEGREE, NurbsSurface};

/// Spans at first. More would be kept where fewer do; fewer takes more rounds.
const FIRST_SPANS: usize = 8;
/// Rounds of dividing spans; each halves the points between knots.
const ROUNDS: usize = 40;
/// Part of the surface's size within which two points in a row are one.
const SAME: f64 = 1e-13;

/// A B-spline curve in the parameter plane of a surface, closed or open.
///
/// On a surface that is closed around, its values go on without a jump over the seam. A closed curve
/// ends where it begins, thus does not run around such a surface.
#[derive(Clone, Debug, PartialEq)]
pub struct ParameterCurve {
    closed: bool,
    knots: Knots,
    /// A closed curve's first `degree` ones are repeated at its end.
    points: Vec<DVec2>,
    deviation: f64,
}

impl ParameterCurve {
    /// A curve through points, by least squares.
    ///
    /// `points`: parameters of the surface that go on without a jump; the first is not repeated at
    /// the end of a closed curve. `tolerance`: how far a point may be from the curve, mm on the
    /// surface. An open curve begins and ends exactly at the outer points; a closed one of degree
    /// `degree` has `degree - 1` continuous derivatives at its seam, too.
    ///
    /// Between the points it is as near as they are dense.
    ///
    /// # Errors
    /// [`HubError::TooFewPoints`]; [`HubError::NotFitted`] where not even a knot at every point does.
    pub fn fit(
        surface: &NurbsSurface,
        points: &[DVec2],
        closed: bool,
        degree: usize,
        tolerance: f64,
    ) -> Result<Self, HubError> {
        let degree = degree.clamp(1, LARGEST_DEGREE);
        let data = Data::new(surface, points, closed, degree)?;
        let count = data.candidates.len();
        let mut chosen = vec![false; count];
        let first = FIRST_SPANS.max(degree + 1).min(count);
        (0..first).for_each(|k| chosen[k * count / first] = true);
        let not_fitted = |at: DVec3, off: f64| HubError::NotFitted { at, off, tolerance };
        let mut last = (data.places[0], f64::INFINITY);
        for _ in 0..ROUNDS {
            let Some(mut curve) = data.solve(&chosen) else {
                return Err(not_fitted(last.0, last.1));
            };
            let off = data.deviations(surface, &curve);
            let worst = (0..off.len()).max_by(|a, b| off[*a].total_cmp(&off[*b])).unwrap_or(0);
            last = (data.places[worst], off[worst]);
            if off[worst] <= tolerance {
                curve.deviation = off[worst];
                return Ok(curve);
            }
            if !data.divide(&mut chosen, &off, tolerance) {
                if chosen.iter().all(|c| *c) {
                    break;
                }
                // What is wrong in a span without candidates may come from the next.
                chosen.fill(true);
            }
        }
        Err(not_fitted(last.0, last.1))
    }

    /// Whether it ends where it begins.
    pub fn is_closed(&self) -> bool {
        self.closed
    }

    /// Point and first and second derivative by `m`. A closed curve goes on around, an open one stops
    /// at its ends.
    pub fn jet(&self, m: f64) -> [DVec2; 3] {
        let m = if self.closed { m - m.floor() } else { m.clamp(0.0, 1.0) };
        let basis = self.knots.basis(m);
        let points = &self.points[basis.first..=basis.first + self.knots.degree()];
        basis.values.map(|values| points.iter().zip(&values).map(|(p, n)| *p * *n).sum())
    }

    /// Parameters of the surface at `m`.
    pub fn point(&self, m: f64) -> DVec2 {
        self.jet(m)[0]
    }

    /// The greatest distance between a point that was fitted and its place on the curve, mm.
    pub fn deviation(&self) -> f64 {
        self.deviation
    }

    /// Number of control points.
    #[cfg(test)]
    pub fn control_points(&self) -> usize {
        self.points.len() - if self.closed { self.knots.degree() } else { 0 }
    }

    /// The knots from 0 to 1.
    pub(super) fn breaks(&self) -> Vec<f64> {
        self.knots.breaks().into_iter().map(|(m, _)| m).collect()
    }

    /// Twice the signed area that it encloses in the parameter plane, an open one with the line
    /// between its ends; positive where it runs counter-clockwise.
    pub(super) fn area(&self) -> f64 {
        let breaks = self.breaks();
        let points: Vec<DVec2> = breaks
            .windows(2)
            .flat_map(|w| (0..4).map(|k| self.point(w[0] + (w[1] - w[0]) * f64::from(k) / 4.0)))
            .chain((!self.closed).then(|| self.point(1.0)))
            .collect();
        area(&points)
    }
}

/// Twice the signed area of a polygon.
pub(super) fn area(points: &[DVec2]) -> f64 {
    let Some(&start) = points.first() else { return 0.0 };
    points.windows(2).map(|w| (w[0] - start).perp_dot(w[1] - start)).sum()
}

/// What a curve is fitted to.
struct Data {
    closed: bool,
    degree: usize,
    points: Vec<DVec2>,
    places: Vec<DVec3>,
    /// The curve's parameter of every point.
    at: Vec<f64>,
    /// Where knots may stand; the first of a closed curve is 0.
    candidates: Vec<f64>,
}

impl Data {
    fn new(
        surface: &NurbsSurface,
        all: &[DVec2],
        closed: bool,
        degree: usize,
    ) -> Result<Self, HubError> {
        let near = SAME * surface.size();
        let (mut points, mut places) = (Vec::<DVec2>::new(), Vec::<DVec3>::new());
        for p in all {
            let place = surface.jet_beyond(*p).point;
            if places.last().is_none_or(|last| last.distance(place) > near) {
                points.push(*p);
                places.push(place);
            }
        }
        while closed && points.len() > 1 && places[0].distance(places[points.len() - 1]) <= near {
            points.pop();
            places.pop();
        }
        let n = points.len();
        if n < degree + 1 || !places.iter().all(|p| p.is_finite()) {
            let at = places.first().copied().unwrap_or(DVec3::ZERO);
            return Err(HubError::TooFewPoints { at, found: n, degree });
        }
        let chords = (0..n).map(|i| places[i].distance(places[(i + 1) % n]));
        let chords: Vec<f64> = chords.take(if closed { n } else { n - 1 }).collect();
        let total: f64 = chords.iter().sum();
        let even = degree.is_multiple_of(2);
        // Knots of even degree stand between points; then the seam does, too.
        let mut sum = if closed && even { 0.5 * chords[n - 1] } else { 0.0 };
        let mut at = vec![sum / total];
        for chord in &chords[..n - 1] {
            sum += chord;
            at.push(sum / total);
        }
        if !closed {
            at[n - 1] = 1.0;
        }
        let middles = || at.windows(2).map(|w| 0.5 * (w[0] + w[1]));
        let candidates: Vec<f64> = match (closed, even) {
            (true, false) => at.clone(),
            (true, true) => std::iter::once(0.0).chain(middles()).collect(),
            // As many as leave no more control points than points.
            (false, false) => at[degree.div_ceil(2)..n - degree.div_ceil(2)].to_vec(),
            (false, true) => middles().skip(degree / 2).take(n - 1 - degree).collect(),
        };
        Ok(Self { closed, degree, points, places, at, candidates })
    }

    /// The knot vector with the chosen candidates.
    fn knots(&self, chosen: &[bool]) -> Vec<f64> {
        let picked = self.candidates.iter().zip(chosen).filter(|(_, c)| **c).map(|(m, _)| *m);
        let inner: Vec<f64> = picked.collect();
        let p = self.degree;
        if !self.closed {
            let ends = |value: f64| std::iter::repeat_n(value, p + 1);
            return ends(0.0).chain(inner).chain(ends(1.0)).collect();
        }
        let spans = inner.len();
        // From p knots before the seam to p after its return.
        (0..=spans + 2 * p)
            .map(|j| {
                let turns = (p.div_ceil(spans)) as f64;
                let k = j + p.div_ceil(spans) * spans - p;
                inner[k % spans] + (k / spans) as f64 - turns
            })
            .collect()
    }

    /// The curve of least squares; `None` where the equations have no solution.
    fn solve(&self, chosen: &[bool]) -> Option<ParameterCurve> {
        let p = self.degree;
        let vector = self.knots(chosen);
        let count = vector.len() - p - 1;
        let knots = Knots::new(Direction::U, p, vector, count).ok()?;
        let last = self.points.len() - 1;
        let mut points = vec![DVec2::ZERO; count];
        // An open curve's ends are known.
        let unknowns = if self.closed { count - p } else { count - 2 };
        let unknown = |i: usize| {
            if self.closed {
                Some(i % unknowns)
            } else {
                i.checked_sub(1).filter(|i| *i < unknowns)
            }
        };
        if !self.closed {
            (points[0], points[count - 1]) = (self.points[0], self.points[last]);
        }
        // Coordinates from the first point on keep the rounding small.
        let origin = self.points[0];
        let mut equations = Banded::new(unknowns, p);
        for (m, point) in self.at.iter().zip(&self.points) {
            let basis = knots.basis(*m);
            let mut right = *point - origin;
            for r in 0..=p {
                let i = basis.first + r;
                if unknown(i).is_none() {
                    right -= (points[i] - origin) * basis.values[0][r];
                }
            }
            for r in 0..=p {
                let Some(row) = unknown(basis.first + r) else { continue };
                let place = equations.order(row);
                equations.right[place] += right * basis.values[0][r];
                for s in 0..=p {
                    if let Some(column) = unknown(basis.first + s) {
                        equations.add(row, column, basis.values[0][r] * basis.values[0][s]);
                    }
                }
            }
        }
        let solution = equations.solve()?;
        for (i, point) in points.iter_mut().enumerate() {
            if let Some(k) = unknown(i) {
                *point = solution[k] + origin;
            }
        }
        Some(ParameterCurve { closed: self.closed, knots, points, deviation: 0.0 })
    }

    /// Distance of every point to its place on the curve, mm.
    fn deviations(&self, surface: &NurbsSurface, curve: &ParameterCurve) -> Vec<f64> {
        let off = |(m, place): (&f64, &DVec3)| {
            let at = surface.jet_beyond(curve.point(*m)).point;
            let off = at.distance(*place);
            if off.is_finite() { off } else { f64::INFINITY }
        };
        self.at.iter().zip(&self.places).map(off).collect()
    }

    /// Chooses a knot more in every span where a point is too far off; whether there was any.
    fn divide(&self, chosen: &mut [bool], off: &[f64], tolerance: f64) -> bool {
        let bad: Vec<f64> =
            self.at.iter().zip(off).filter(|(_, o)| **o > tolerance).map(|(m, _)| *m).collect();
        let count = chosen.len() as isize;
        // Indices of candidates; one before the first and one after the last stand for the ends.
        let mut ends: Vec<isize> = (0..count).filter(|k| chosen[*k as usize]).collect();
        ends.push(count);
        if !self.closed {
            ends.insert(0, -1);
        }
        let value = |k: isize| match k {
            k if k < 0 => 0.0,
            k if k >= count => 1.0,
            k => self.candidates[k as usize],
        };
        let mut any = false;
        for pair in ends.windows(2) {
            let (from, to) = (value(pair[0]), value(pair[1]));
            let first = bad.partition_point(|m| *m < from);
            if pair[1] - pair[0] >= 2 && bad.get(first).is_some_and(|m| *m <= to) {
                chosen[((pair[0] + pair[1]) / 2) as usize] = true;
                any = true;
            }
        }
        any
    }
}

/// Normal equations of a B-spline curve, closed or open.
///
/// The unknowns are taken from both ends in turn, so that those beside the seam of a closed curve are
/// neighbours and the matrix is a band.
struct Banded {
    width: usize,
    /// By row, from `width` before the diagonal to it.
    rows: Vec<Vec<f64>>,
    /// In the order of the rows.
    right: Vec<DVec2>,
}

impl Banded {
    fn new(unknowns: usize, degree: usize) -> Self {
        let width = (2 * degree + 1).min(unknowns.saturating_sub(1));
        Self {
            width,
            rows: vec![vec![0.0; width + 1]; unknowns],
            right: vec![DVec2::ZERO; unknowns],
        }
    }

    /// Row of an unknown.
    fn order(&self, unknown: usize) -> usize {
        let n = self.rows.len();
        if 2 * unknown < n { 2 * unknown } else { 2 * (n - 1 - unknown) + 1 }
    }

    fn add(&mut self, a: usize, b: usize, value: f64) {
        let (row, column) = (self.order(a), self.order(b));
        if column <= row {
            self.rows[row][self.width - (row - column)] += value;
        }
    }

    /// The unknowns by Cholesky's method; `None` where the matrix is not positive definite.
    fn solve(mut self) -> Option<Vec<DVec2>> {
        let (n, w) = (self.rows.len(), self.width);
        for i in 0..n {
            let from = i.saturating_sub(w);
            for j in from..=i {
                let mut sum = self.rows[i][w - (i - j)];
                for k in from.max(j.saturating_sub(w))..j {
                    sum -= self.rows[i][w - (i - k)] * self.rows[j][w - (j - k)];
                }
                self.rows[i][w - (i - j)] = if j < i {
                    sum / self.rows[j][w]
                } else if sum > 1e-14 * self.rows[i][w] {
                    sum.sqrt()
                } else {
                    return None;
                };
            }
        }
        for i in 0..n {
            for k in i.saturating_sub(w)..i {
                let known = self.right[k] * self.rows[i][w - (i - k)];
                self.right[i] -= known;
            }
            self.right[i] /= self.rows[i][w];
        }
        for i in (0..n).rev() {
            self.right[i] /= self.rows[i][w];
            for k in i.saturating_sub(w)..i {
                let known = self.right[i] * self.rows[i][w - (i - k)];
                self.right[k] -= known;
            }
        }
        Some((0..n).map(|k| self.right[self.order(k)]).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::math::{cos, sin};
    use crate::nurbs::NurbsCurve;
    use std::f64::consts::TAU;

    fn cylinder() -> NurbsSurface {
        let (a, b) = (DVec3::new(-40.0, 0.0, 50.0), DVec3::new(40.0, 0.0, 50.0));
        NurbsCurve::line(a, b).unwrap().revolved(DVec3::ZERO, DVec3::X).unwrap()
    }

    fn ellipse(turn: f64) -> DVec2 {
        // Across the seam of the surface at u = 4.
        DVec2::new(4.0 + 0.3 * cos(turn), 0.5 + 0.3 * sin(turn))
    }

    #[test]
    fn a_closed_fit_keeps_its_tolerance_and_is_smooth_at_the_seam() {
        let surface = cylinder();
        let points: Vec<DVec2> = (0..400).map(|k| ellipse(TAU * f64::from(k) / 400.0)).collect();
        for degree in 2..=5 {
            for tolerance in [1e-2, 1e-4] {
                let curve =
                    ParameterCurve::fit(&surface, &points, true, degree, tolerance).unwrap();
                assert!(curve.is_closed() && curve.deviation() <= tolerance);
                assert!(curve.control_points() < 200, "{}", curve.control_points());
                for k in 0..1000 {
                    let p = curve.point(f64::from(k) / 1000.0);
                    let q = (p - DVec2::new(4.0, 0.5)) / 0.3;
                    let on = DVec2::new(4.0, 0.5) + q.normalize() * 0.3;
                    let off = surface.point(p).distance(surface.point(on));
                    assert!(off < 1.5 * tolerance, "{degree} {tolerance} {k} {off}");
                }
                let (a, b) = (curve.jet(1.0 - 1e-13), curve.jet(1.0));
                for order in 0..degree.min(3) {
                    let scale = a[order].length().max(1.0);
                    assert!(a[order].distance(b[order]) < 1e-6 * scale, "{degree} {order}");
                }
                assert_eq!(curve.jet(-0.25), curve.jet(0.75));
                assert!(curve.area() > 0.0);
            }
        }
    }

    #[test]
    fn an_open_fit_ends_at_its_points_and_runs_with_the_arc_length() {
        let surface = cylinder();
        let points: Vec<DVec2> = (0..=200).map(|k| ellipse(4.0 * f64::from(k) / 200.0)).collect();
        for degree in 1..=4 {
            let tolerance = if degree == 1 { 1e-1 } else { 1e-3 };
            let curve = ParameterCurve::fit(&surface, &points, false, degree, tolerance).unwrap();
            assert!(curve.point(0.0).distance(points[0]) < 1e-14);
            assert!(curve.point(1.0).distance(points[200]) < 1e-14);
            let speed = |m: f64| {
                let jet = curve.jet(m);
                surface.jet(jet[0]).tangent(jet[1]).length()
            };
            if degree > 1 {
                let (a, b) = (speed(0.21), speed(0.77));
                assert!((a / b - 1.0).abs() < 0.02, "{degree}: {a} {b}");
            }
        }
        let far = ParameterCurve::fit(&surface, &points[..3], false, 3, 1e-3).unwrap_err();
        assert!(far.to_string().contains("3 different points"), "{far}");
    }

    #[test]
    fn corners_get_many_knots() {
        let surface = cylinder();
        let corner = DVec2::new(1.0, 0.5);
        // Points at both sides come nearer to the corner by halves.
        let way = |k: i32| (0..k).fold(1.0, |x, _| 0.5 * x);
        let mut points: Vec<DVec2> =
            (0..18).map(|k| corner + DVec2::new(-0.4, 0.1) * way(k)).collect();
        points.push(corner);
        points.extend((0..18).rev().map(|k| corner + DVec2::new(-0.4, -0.1) * way(k)));
        let curve = ParameterCurve::fit(&surface, &points, false, 3, 0.01).unwrap();
        let near = (0..=2000).map(|k| surface.point(curve.point(f64::from(k) / 2000.0)));
        let near = near.map(|p| p.distance(surface.point(corner))).fold(f64::INFINITY, f64::min);
        assert!(near < 0.011, "{near}");
    }

    #[test]
    fn polynomials_are_met_exactly() {
        let plane = NurbsCurve::line(DVec3::ZERO, DVec3::X).unwrap();
        let plane = plane.extruded(DVec3::ZERO, DVec3::Y).unwrap();
        let points: Vec<DVec2> = (0..=30).map(|k| DVec2::new(f64::from(k) / 30.0, 0.25)).collect();
        let curve = ParameterCurve::fit(&plane, &points, false, 3, 1e-9).unwrap();
        let jet = curve.jet(0.3);
        assert!(jet[0].distance(DVec2::new(0.3, 0.25)) < 1e-13, "{}", jet[0]);
        assert!(jet[1].distance(DVec2::X) < 1e-11 && jet[2].length() < 1e-9);
        assert!(curve.deviation() < 1e-13);
    }
}
