//! B-spline basis functions and their derivatives, without allocation.

use super::degree::LARGEST_DEGREE;
use super::error::{Direction, NurbsError};

/// Functions that are not zero in a span, at most.
const MOST: usize = LARGEST_DEGREE + 1;

/// Values and first and second derivatives of the functions that are not zero at a parameter.
pub(crate) struct Basis {
    /// Index of the first of them.
    pub first: usize,
    /// Order of derivative by function; those beyond the degree are zero.
    pub values: [[f64; MOST]; 3],
}

/// Values of the functions that are not zero at a parameter.
pub(crate) struct Values {
    /// Index of the first of them.
    pub first: usize,
    /// By function.
    pub values: [f64; MOST],
}

/// A degree and a nondecreasing knot vector.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Knots {
    degree: usize,
    knots: Vec<f64>,
}

impl Knots {
    /// Checks a knot vector for `points` control points.
    pub fn new(
        direction: Direction,
        degree: usize,
        knots: Vec<f64>,
        points: usize,
    ) -> Result<Self, NurbsError> {
        if degree == 0 || degree > LARGEST_DEGREE {
            return Err(NurbsError::Degree { direction, degree });
        }
        if points <= degree {
            return Err(NurbsError::TooFewPoints { direction, points, degree });
        }
        let expected = points + degree + 1;
        if knots.len() != expected {
            return Err(NurbsError::KnotCount { direction, found: knots.len(), expected });
        }
        if let Some(index) = knots.iter().position(|k| !k.is_finite()) {
            return Err(NurbsError::KnotNotFinite { direction, index });
        }
        if let Some(i) = knots.windows(2).position(|pair| pair[1] < pair[0]) {
            let (before, value) = (knots[i], knots[i + 1]);
            return Err(NurbsError::KnotsDecrease { direction, index: i + 1, before, value });
        }
        let this = Self { degree, knots };
        let (low, high) = this.domain();
        // A difference that rounding swallows is no domain; one too large overflows.
        if !(high > low && (high - low).is_finite()) {
            return Err(NurbsError::EmptyDomain { direction, low, high });
        }
        let inner = &this.knots[1..points + degree];
        let repeats = inner.windows(degree + 1).position(|w| w[degree] == w[0]);
        match repeats {
            Some(at) => Err(NurbsError::KnotRepeats { direction, value: inner[at], degree }),
            None => Ok(this),
        }
    }

    pub fn degree(&self) -> usize {
        self.degree
    }

    /// The parameters for which the functions sum to 1.
    pub fn domain(&self) -> (f64, f64) {
        (self.knots[self.degree], self.knots[self.knots.len() - 1 - self.degree])
    }

    /// The different knots of the domain and how often each occurs.
    pub fn breaks(&self) -> Vec<(f64, usize)> {
        let (low, high) = self.domain();
        let mut breaks: Vec<(f64, usize)> = Vec::new();
        for &k in self.knots.iter().filter(|k| (low..=high).contains(*k)) {
            match breaks.last_mut() {
                Some((last, count)) if *last == k => *count += 1,
                _ => breaks.push((k, 1)),
            }
        }
        breaks
    }

    /// The knot span that holds `t`, a parameter of the domain.
    fn span(&self, t: f64) -> usize {
        let points = self.knots.len() - 1 - self.degree;
        let after = self.knots.partition_point(|&k| k <= t).clamp(self.degree + 1, points);
        // The last span of the domain may be empty in an unclamped vector.
        let mut span = after - 1;
        while span > self.degree && self.knots[span] == self.knots[span + 1] {
            span -= 1;
        }
        span
    }

    /// The knot span in which one that comes from `t` on the way `forward` is first, and its ends;
    /// beyond the domain the outermost span.
    pub fn span_toward(&self, t: f64, forward: bool) -> (usize, [f64; 2]) {
        let mut span = self.span(t);
        if !forward && t <= self.knots[span] {
            let mut before = (self.degree..span).rev();
            span = before.find(|&s| self.knots[s] < self.knots[s + 1]).unwrap_or(span);
        }
        (span, [self.knots[span], self.knots[span + 1]])
    }

    /// The values of the functions at `t`, as [`basis`](Self::basis) has them.
    pub fn values(&self, t: f64) -> Values {
        let span = self.span(t);
        let mut n = [0.0; MOST];
        n[0] = 1.0;
        (1..=self.degree).for_each(|q| self.raise(&mut n, q, span, t));
        Values { first: span - self.degree, values: n }
    }

    /// The functions at `t`, a parameter of the domain; beyond it the polynomials of the outermost
    /// spans go on.
    pub fn basis(&self, t: f64) -> Basis {
        self.basis_in(self.span(t), t)
    }

    /// The polynomials that the functions are in a knot span, at any `t`.
    ///
    /// # Source
    /// Piegl and Tiller, "The NURBS Book", 2nd edition, algorithm A2.2 and equation 2.7, which
    /// gives the derivatives from the functions of the degrees below.
    pub fn basis_in(&self, span: usize, t: f64) -> Basis {
        let p = self.degree;
        let mut by_degree = [[0.0; MOST]; 3];
        let mut n = [0.0; MOST];
        n[0] = 1.0;
        for q in 1..=p {
            // Degrees p-2 and p-1 are kept for the derivatives.
            if q + 1 == p || q == p {
                by_degree[p - q + 1] = n;
            }
            self.raise(&mut n, q, span, t);
        }
        if p == 1 {
            by_degree[2] = [0.0; MOST];
        }
        let first = self.differentiate(&by_degree[1], p, span);
        let second = if p < 2 {
            [0.0; MOST]
        } else {
            let lower = self.differentiate(&by_degree[2], p - 1, span);
            self.differentiate(&lower, p, span)
        };
        Basis { first: span - p, values: [n, first, second] }
    }

    /// Functions of degree `q - 1` → those of degree `q`.
    fn raise(&self, n: &mut [f64; MOST], q: usize, span: usize, t: f64) {
        let u = &self.knots;
        let mut saved = 0.0;
        for r in 0..q {
            let (right, left) = (u[span + r + 1] - t, t - u[span + 1 + r - q]);
            let part = n[r] / (right + left);
            n[r] = saved + right * part;
            saved = left * part;
        }
        n[q] = saved;
    }

    /// Derivatives of the functions of degree `q` from (derivatives of) those of degree `q - 1`.
    fn differentiate(&self, lower: &[f64; MOST], q: usize, span: usize) -> [f64; MOST] {
        let u = &self.knots;
        let mut result = [0.0; MOST];
        for (r, slot) in result.iter_mut().enumerate().take(q + 1) {
            let i = span + r - q;
            let rise = if r > 0 { lower[r - 1] / (u[i + q] - u[i]) } else { 0.0 };
            let fall = if r < q { lower[r] / (u[i + q + 1] - u[i + 1]) } else { 0.0 };
            *slot = q as f64 * (rise - fall);
        }
        result
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn knots(degree: usize, knots: &[f64]) -> Knots {
        let points = knots.len() - degree - 1;
        Knots::new(Direction::U, degree, knots.to_vec(), points).unwrap()
    }

    #[test]
    fn functions_sum_to_one_and_derivatives_to_zero() {
        let vectors = [
            knots(1, &[0.0, 0.0, 2.0, 3.0, 3.0]),
            knots(3, &[0.0, 0.0, 0.0, 0.0, 0.5, 0.7, 0.7, 0.7, 2.0, 2.0, 2.0, 2.0]),
            // Not clamped.
            knots(2, &[-2.0, -1.0, 0.0, 1.0, 2.0, 3.0, 4.0]),
            knots(5, &[0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0]),
        ];
        for k in vectors {
            let (low, high) = k.domain();
            for i in 0..=20 {
                let basis = k.basis(low + (high - low) * f64::from(i) / 20.0);
                let values = k.values(low + (high - low) * f64::from(i) / 20.0);
                assert_eq!((values.first, values.values), (basis.first, basis.values[0]));
                let sum = |order: usize| basis.values[order].iter().sum::<f64>();
                assert!((sum(0) - 1.0).abs() < 1e-14);
                assert!(sum(1).abs() < 1e-12 && sum(2).abs() < 1e-11, "{} {}", sum(1), sum(2));
            }
        }
    }

    #[test]
    fn bad_knots_are_refused() {
        let bad = |degree, knots: &[f64], points| {
            Knots::new(Direction::V, degree, knots.to_vec(), points).unwrap_err().to_string()
        };
        assert!(bad(0, &[0.0, 1.0], 1).contains("degree_v = 0"));
        assert!(bad(2, &[0.0; 5], 2).contains("needs at least 3"));
        assert!(bad(1, &[0.0, 0.0, 1.0], 2).contains("3 knots; expected 4"));
        assert!(bad(1, &[0.0, 0.0, f64::NAN, 1.0], 2).contains("knots_v[2]"));
        assert!(bad(1, &[0.0, 2.0, 1.0, 1.0], 2).contains("knots_v[2] = 1 after 2"));
        assert!(bad(1, &[1.0; 4], 2).contains("from 1 to 1"));
        assert!(bad(1, &[0.0, 0.0, 1.0, 1.0, 2.0, 2.0], 4).contains("the knot 1 occurs"));
    }
}
