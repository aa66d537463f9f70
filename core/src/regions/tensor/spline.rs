//! Smooth curves through the points of a traced line.
//!
//! A uniform cubic B-spline with as few spans as keep within a tolerance is fitted by least squares to
//! the points, by the way along the line; it begins and ends where the line does.
//!
//! # Source
//! Piegl and Tiller, "The NURBS Book", section 9.4.1.

use super::jet::Equations;
use crate::geometry::DVec2;

/// Most spans; the work grows with its third power.
const MOST_SPANS: usize = 64;
/// Points per span of the result.
const PER_SPAN: usize = 6;
/// Weight of the second differences of the control points: keeps spans without points from swinging.
const STIFFNESS: f64 = 1e-6;

/// Points of a B-spline within `tolerance` of the points of `line`; the line itself where no fit is.
pub fn fitted(line: &[DVec2], tolerance: f64) -> Vec<DVec2> {
    let Some(along) = parts_of_way(line) else { return line.to_vec() };
    let mut spans = 1;
    while spans <= MOST_SPANS && spans < 2 * line.len() {
        if let Some(spline) = Spline::fit(line, &along, spans)
            && line.iter().zip(&along).all(|(p, t)| spline.at(*t).distance(*p) <= tolerance)
        {
            let count = (spans * PER_SPAN).max(12);
            let mut points: Vec<DVec2> =
                (0..=count).map(|i| spline.at(i as f64 / count as f64)).collect();
            (points[0], points[count]) = (line[0], line[line.len() - 1]);
            return points;
        }
        spans *= 2;
    }
    line.to_vec()
}

/// Part of the way along the line at each point; `None` for a line without length.
fn parts_of_way(line: &[DVec2]) -> Option<Vec<f64>> {
    let mut along = vec![0.0];
    let mut way = 0.0;
    for pair in line.windows(2) {
        way += pair[0].distance(pair[1]);
        along.push(way);
    }
    (line.len() > 2 && way > 0.0).then(|| along.into_iter().map(|s| s / way).collect())
}

struct Spline {
    controls: Vec<DVec2>,
}

impl Spline {
    fn fit(line: &[DVec2], along: &[f64], spans: usize) -> Option<Self> {
        let count = spans + 3;
        // The ends are known: what is fitted is the offset from the chord, zero at both.
        let (first, last) = (line[0], line[line.len() - 1]);
        let mut x = Equations::new(count);
        let mut y = Equations::new(count);
        let mut add = |row: &[f64], value: DVec2, weight: f64| {
            x.add(row, value.x, weight);
            y.add(row, value.y, weight);
        };
        for (p, t) in line.iter().zip(along) {
            let mut row = vec![0.0; count];
            let (span, basis) = basis(*t, spans);
            row[span..span + 4].copy_from_slice(&basis);
            let is_end = *t == 0.0 || *t == 1.0;
            add(&row, *p - first.lerp(last, *t), if is_end { 1e6 } else { 1.0 });
        }
        for i in 0..count - 2 {
            let mut row = vec![0.0; count];
            (row[i], row[i + 1], row[i + 2]) = (1.0, -2.0, 1.0);
            add(&row, DVec2::ZERO, STIFFNESS * line.len() as f64);
        }
        let factor = x.factored()?;
        let (x, y) = (factor.solve(&x.right), factor.solve(&y.right));
        // A uniform cubic spline reproduces lines with its nodes spread evenly.
        let node = |i: usize| first.lerp(last, (i as f64 - 1.0) / spans as f64);
        let controls = (0..count).map(|i| node(i) + DVec2::new(x[i], y[i])).collect();
        Some(Self { controls })
    }

    fn at(&self, t: f64) -> DVec2 {
        let (span, basis) = basis(t, self.controls.len() - 3);
        (0..4).map(|i| self.controls[span + i] * basis[i]).sum()
    }
}

/// The span of a parameter and the values of its four uniform cubic B-splines.
fn basis(t: f64, spans: usize) -> (usize, [f64; 4]) {
    let at = (t * spans as f64).clamp(0.0, spans as f64);
    let span = (at as usize).min(spans - 1);
    let s = at - span as f64;
    let r = 1.0 - s;
    let sixth = 1.0 / 6.0;
    let basis = [
        sixth * r * r * r,
        sixth * (3.0 * s * s * s - 6.0 * s * s + 4.0),
        sixth * (3.0 * r * r * r - 6.0 * r * r + 4.0),
        sixth * s * s * s,
    ];
    (span, basis)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::math::{cos, sin};

    #[test]
    fn a_noisy_arc_becomes_smooth() {
        let exact = |t: f64| DVec2::new(cos(2.0 * t), sin(2.0 * t));
        let noise = |i: usize, salt| 0.004 * crate::flatten::samples::jitter(i, salt);
        let n = 200;
        let line: Vec<DVec2> = (0..=n)
            .map(|i| exact(i as f64 / n as f64) + DVec2::new(noise(i, 1), noise(i, 2)))
            .collect();
        let smooth = fitted(&line, 0.005);
        assert_eq!((smooth[0], smooth[smooth.len() - 1]), (line[0], line[n]));
        let inner = &smooth[1..smooth.len() - 1];
        let off = inner.iter().map(|p| (p.length() - 1.0).abs()).fold(0.0, f64::max);
        assert!(off < 0.0025 && smooth.len() < 50, "{off} with {} points", smooth.len());
    }

    #[test]
    fn straight_lines_stay() {
        let line: Vec<DVec2> = (0..9).map(|i| DVec2::new(f64::from(i), 0.0)).collect();
        let smooth = fitted(&line, 1e-6);
        assert!(smooth.iter().all(|p| p.y.abs() < 1e-9));
        assert_eq!(fitted(&line[..2], 1e-6), line[..2]);
    }
}
