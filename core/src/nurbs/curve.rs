//! Rational B-spline curves, and the surfaces that are made of them.

use glam::DVec4;

use super::basis::Knots;
use super::error::{Direction, NurbsError};
use super::surface::{NurbsParts, NurbsSurface};
use crate::geometry::{DVec3, any_perpendicular};

/// A rational B-spline curve.
#[derive(Clone, Debug, PartialEq)]
pub struct NurbsCurve {
    degree: usize,
    knots: Vec<f64>,
    checked: Knots,
    points: Vec<(DVec3, f64)>,
}

impl NurbsCurve {
    /// A curve from its degree, full knot vector, control points, mm, and weights.
    ///
    /// # Errors
    /// [`NurbsError`] naming the number that does not fit.
    pub fn new(
        degree: usize,
        knots: Vec<f64>,
        points: Vec<(DVec3, f64)>,
    ) -> Result<Self, NurbsError> {
        let checked = Knots::new(Direction::U, degree, knots.clone(), points.len())?;
        for (i, &(at, weight)) in points.iter().enumerate() {
            if !at.is_finite() {
                return Err(NurbsError::NotFinite { i, j: 0, at });
            }
            if !(1e-9..=1e9).contains(&weight) {
                return Err(NurbsError::Weight { i, j: 0, weight });
            }
        }
        Ok(Self { degree, knots, checked, points })
    }

    /// The straight line between two points, with parameters from 0 to 1.
    pub fn line(a: DVec3, b: DVec3) -> Result<Self, NurbsError> {
        Self::new(1, vec![0.0, 0.0, 1.0, 1.0], vec![(a, 1.0), (b, 1.0)])
    }

    /// The whole ellipse around `centre` with semi-axes `x` and `y`, from the end of `x`.
    pub fn ellipse(centre: DVec3, x: DVec3, y: DVec3) -> Result<Self, NurbsError> {
        let half = 0.5_f64.sqrt();
        let ways = [x, x + y, y, y - x, -x, -x - y, -y, x - y, x];
        let points = ways.iter().enumerate();
        let points = points.map(|(i, w)| (centre + *w, if i % 2 == 1 { half } else { 1.0 }));
        Self::new(2, quarters(), points.collect())
    }

    /// Half of a circle, from `from` over `top`, both of one length and perpendicular.
    pub fn half_circle(centre: DVec3, from: DVec3, top: DVec3) -> Result<Self, NurbsError> {
        let half = 0.5_f64.sqrt();
        let ways = [from, from + top, top, top - from, -from];
        let points = ways.iter().enumerate();
        let points = points.map(|(i, w)| (centre + *w, if i % 2 == 1 { half } else { 1.0 }));
        Self::new(2, vec![0.0, 0.0, 0.0, 1.0, 1.0, 2.0, 2.0, 2.0], points.collect())
    }

    /// Least and greatest parameter.
    pub fn domain(&self) -> (f64, f64) {
        self.checked.domain()
    }

    /// Number of knot spans.
    pub fn spans(&self) -> usize {
        self.checked.breaks().len().saturating_sub(1)
    }

    /// The point at a parameter, mm; beyond the domain, its end.
    pub fn point(&self, t: f64) -> DVec3 {
        let (low, high) = self.domain();
        let basis = self.checked.basis(if t >= low { t.min(high) } else { low });
        let points = &self.points[basis.first..=basis.first + self.degree];
        let sum: DVec4 =
            points.iter().zip(&basis.values[0]).map(|((p, w), n)| (*p * *w).extend(*w) * *n).sum();
        sum.truncate() / sum.w
    }

    /// The surface that the curve sweeps along `way`; u along the curve.
    pub fn extruded(&self, from: DVec3, way: DVec3) -> Result<NurbsSurface, NurbsError> {
        let row = |(p, _): &(DVec3, f64)| vec![*p + from, *p + from + way];
        NurbsSurface::new(NurbsParts {
            degree: [self.degree, 1],
            knots: [self.knots.clone(), vec![0.0, 0.0, 1.0, 1.0]],
            points: self.points.iter().map(row).collect(),
            weights: self.points.iter().map(|(_, w)| vec![*w; 2]).collect(),
        })
    }

    /// The surface that the curve sweeps once around an axis of unit direction; u around, v along
    /// the curve.
    pub fn revolved(&self, origin: DVec3, axis: DVec3) -> Result<NurbsSurface, NurbsError> {
        let half = 0.5_f64.sqrt();
        let reach = |p: DVec3| p - origin - axis * (p - origin).dot(axis);
        // Points on the axis turn as the others do.
        let widest = self.points.iter().map(|(p, _)| reach(*p));
        let widest = widest.max_by(|a, b| a.length_squared().total_cmp(&b.length_squared()));
        let fallback =
            widest.and_then(DVec3::try_normalize).unwrap_or_else(|| any_perpendicular(axis));
        let mut points = vec![Vec::new(); 9];
        let mut weights = vec![Vec::new(); 9];
        for &(p, w) in &self.points {
            let r = reach(p);
            let x = r.try_normalize().unwrap_or(fallback) * r.length();
            let (centre, y) = (p - r, axis.cross(x));
            let ways = [x, x + y, y, y - x, -x, -x - y, -y, x - y, x];
            for (i, way) in ways.into_iter().enumerate() {
                points[i].push(centre + way);
                weights[i].push(if i % 2 == 1 { w * half } else { w });
            }
        }
        let knots = [quarters(), self.knots.clone()];
        NurbsSurface::new(NurbsParts { degree: [2, self.degree], knots, points, weights })
    }
}

/// Knots of a circle of four arcs of degree two.
fn quarters() -> Vec<f64> {
    vec![0.0, 0.0, 0.0, 1.0, 1.0, 2.0, 2.0, 3.0, 3.0, 4.0, 4.0, 4.0]
}
