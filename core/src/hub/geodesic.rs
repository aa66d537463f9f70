//! Geodesics of a NURBS surface by their differential equation.
//!
//! Terms: a *geodesic* is the curve on a surface that turns neither left nor right, so that a
//! short piece of it is the shortest way; a *piece* of the surface lies between neighbouring knots
//! and has all derivatives.
//!
//! 1. `u''^k + G^k_ij u'^i u'^j = 0` with the Christoffel symbols `G^k_ij = g^kl S_ij . S_l` of the
//!    exact first and second derivatives (do Carmo, "Differential Geometry of Curves and Surfaces",
//!    section 4-4, equation 4).
//! 2. Embedded Runge-Kutta steps of orders 5 and 4 over the arc length (Dormand and Prince, "A family
//!    of embedded Runge-Kutta formulae", 1980), the error per length held below the tolerance.
//! 3. No step runs over a knot line, where second derivatives jump: it ends on the line, and the
//!    next begins with the derivatives beyond it. The direction keeps its angle to the line.
//! 4. The length is measured again by Simpson's rule on the speed in space; the value in the middle
//!    of a step is the fourth-order one of Shampine, "Some practical Runge-Kutta formulas", 1986.

use super::error::HubError;
use crate::geometry::{DVec2, DVec3};
use crate::nurbs::{Jet, NurbsSurface, Piece};

/// Steps of one geodesic, at most; a smooth surface takes about ten.
const MOST_STEPS: usize = 20_000;
/// Smallest step, part of the whole length. Larger ends geodesics that could pass a sharp bend;
/// smaller takes longer to give up.
const LEAST_STEP: f64 = 1e-9;
/// Part of the domain by which a geodesic may leave an open direction, on the continued polynomials.
/// Larger follows polynomials that no longer resemble the hub; smaller stops wide cutters at a rim.
pub(super) const BEYOND: f64 = 0.5;
/// Part of the domain that counts as on a knot line.
const ON_LINE: f64 = 1e-10;
/// Trials for a step that ends on a knot line; each gains about a digit and a half.
const LANDINGS: usize = 60;
/// Part of the surface's size that one step cannot be more exact than.
const ROUNDING: f64 = 1e-15;

/// The end of a geodesic.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Geodesic {
    /// Parameters of the end; they go on around along closed directions of the surface.
    pub at: DVec2,
    /// Rates of the parameters there by the arc length, 1/mm.
    pub direction: DVec2,
    /// Arc length measured along it, mm.
    pub length: f64,
}

#[derive(Copy, Clone)]
struct State {
    at: DVec2,
    rate: DVec2,
}

impl State {
    fn plus(self, by: State, factor: f64) -> Self {
        Self { at: self.at + by.at * factor, rate: self.rate + by.rate * factor }
    }
}

/// A knot line: the axis whose parameter is constant on it, and its value.
type Line = (usize, f64);

/// One step and what is known of it.
struct Step {
    end: State,
    middle: State,
    /// Difference of the two orders.
    error: State,
}

/// The geodesic from the parameters `from` along `direction`, `length` mm long.
///
/// `direction`: any rates of the parameters; only their direction counts. `tolerance`: how far its
/// end may be off, mm. Beyond an open side of the surface it goes on by up to half of the domain on
/// the polynomials that the surface is there.
///
/// # Errors
/// [`HubError::GeodesicEnds`] where the surface has no normal or ends,
/// [`HubError::GeodesicInexact`] where the measured length is more than ten tolerances off.
pub fn geodesic(
    surface: &NurbsSurface,
    from: DVec2,
    direction: DVec2,
    length: f64,
    tolerance: f64,
) -> Result<Geodesic, HubError> {
    let start = surface.piece(from, direction);
    let jet = surface.jet_in(&start, from);
    let ends = |done: f64| HubError::GeodesicEnds { from: jet.point, done, wanted: length };
    let speed = jet.tangent(direction).length();
    if !(speed > 0.0 && speed.is_finite() && length >= 0.0 && length.is_finite()) {
        return Err(ends(0.0));
    }
    let mut run = Run {
        surface,
        state: State { at: from, rate: direction / speed },
        piece: start,
        length,
        tolerance,
        done: 0.0,
        measured: 0.0,
    };
    let mut step = length * 0.25;
    for _ in 0..MOST_STEPS {
        if run.done >= length {
            break;
        }
        if !(step > LEAST_STEP * length && run.is_near()) {
            return Err(ends(run.done));
        }
        step = run.advance(step);
    }
    if run.done < length || !run.is_near() {
        return Err(ends(run.done));
    }
    let allowed = 10.0 * tolerance.max(ROUNDING * surface.size()) + 1e-12 * length;
    let off = (run.measured - length).abs();
    if off > allowed {
        return Err(HubError::GeodesicInexact { from: jet.point, off, allowed });
    }
    Ok(Geodesic { at: run.state.at, direction: run.state.rate, length: run.measured })
}

struct Run<'a> {
    surface: &'a NurbsSurface,
    state: State,
    piece: Piece,
    length: f64,
    tolerance: f64,
    done: f64,
    measured: f64,
}

impl Run<'_> {
    fn jet(&self, at: DVec2) -> Jet {
        self.surface.jet_in(&self.piece, at)
    }

    /// Takes a step of up to `step` mm, or none where that would be too inexact; returns the length
    /// to try next, mm.
    fn advance(&mut self, step: f64) -> f64 {
        let whole = step.min(self.length - self.done);
        let Some(trial) = self.step(whole) else { return 0.25 * step };
        let share = self.tolerance * whole / self.length;
        let share = share.max(ROUNDING * self.surface.size());
        let error = self.size(trial.error);
        // The error of a step falls with the fifth power of its length, its share with the first.
        let ratio = (share / error.max(1e-30)).sqrt().sqrt();
        let next = whole * (0.9 * ratio).clamp(0.2, 4.0);
        if !error.is_finite() {
            return 0.25 * step;
        }
        if error > share {
            return next.min(0.9 * whole);
        }
        let Some((taken, trial, line)) = self.within_piece(whole, trial) else {
            return 0.25 * step;
        };
        self.accept(taken, &trial);
        if let Some((axis, value)) = line {
            self.cross(axis, value);
        }
        next.max(step.min(whole))
    }

    /// Position error of a step, mm: that of the place and what that of the direction makes over the
    /// rest of the way.
    fn size(&self, error: State) -> f64 {
        let jet = self.jet(self.state.at);
        jet.tangent(error.at).length().max(jet.tangent(error.rate).length() * self.length)
    }

    /// Shortens a step to end on the knot line that it crosses first.
    fn within_piece(&mut self, whole: f64, trial: Step) -> Option<(f64, Step, Option<Line>)> {
        let (mut taken, mut trial, mut line) = (whole, trial, None);
        let (low, high) = self.surface.domain();
        for axis in 0..2 {
            let slack = ON_LINE * (high[axis] - low[axis]);
            let (from, to) = (self.state.at[axis], trial.end.at[axis]);
            let value = if to > self.piece.high[axis] + slack {
                self.piece.high[axis]
            } else if to < self.piece.low[axis] - slack {
                self.piece.low[axis]
            } else {
                continue;
            };
            // One that starts on the line and bends over it belongs to the other side.
            if (from - value).abs() <= slack {
                let mut way = self.state.rate;
                way[axis] = to - value;
                let mut at = self.state.at;
                at[axis] = value;
                self.piece = self.surface.piece(at, way);
                trial = self.step(taken)?;
                continue;
            }
            (taken, trial) = self.land(axis, value, taken, trial)?;
            line = Some((axis, value));
        }
        Some((taken, trial, line))
    }

    /// The step that ends on a knot line.
    ///
    /// # Source
    /// Regula falsi as changed by Dowell and Jarratt ("Illinois"), 1971.
    fn land(&self, axis: usize, value: f64, whole: f64, trial: Step) -> Option<(f64, Step)> {
        let (low, high) = self.surface.domain();
        let close = 1e-3 * ON_LINE * (high[axis] - low[axis]);
        let (mut a, mut fa) = (0.0, self.state.at[axis] - value);
        let (mut b, mut fb) = (whole, trial.end.at[axis] - value);
        let mut best = (whole, trial);
        for _ in 0..LANDINGS {
            let h = (a * fb - b * fa) / (fb - fa);
            let step = self.step(h)?;
            let f = step.end.at[axis] - value;
            best = (h, step);
            if f.abs() <= close || b - a <= 1e-15 * whole {
                break;
            }
            if (f > 0.0) == (fb > 0.0) {
                (b, fb) = (h, f);
                fa *= 0.5;
            } else {
                (a, fa) = (h, f);
                fb *= 0.5;
            }
        }
        Some(best)
    }

    fn accept(&mut self, taken: f64, step: &Step) {
        let speed = |s: State| self.jet(s.at).tangent(s.rate).length();
        let speeds = speed(self.state) + 4.0 * speed(step.middle) + speed(step.end);
        self.measured += taken * speeds / 6.0;
        self.done += taken;
        if self.length - self.done <= 1e-15 * self.length {
            self.done = self.length;
        }
        self.state = step.end;
    }

    /// Goes over into the piece beyond a knot line. Where the parameters run at another speed there,
    /// or the surface has a crease, the direction keeps its angle to the line.
    fn cross(&mut self, axis: usize, value: f64) {
        let before = self.jet(self.state.at);
        let velocity = before.tangent(self.state.rate);
        self.state.at[axis] = value;
        self.piece = self.surface.piece(self.state.at, self.state.rate);
        let after = self.jet(self.state.at);
        let frame = |jet: &Jet| {
            let line = jet.first[1 - axis].normalize_or_zero();
            (line, jet.normal().cross(line))
        };
        let ((line, across), (new_line, new_across)) = (frame(&before), frame(&after));
        let velocity = new_line * velocity.dot(line) + new_across * velocity.dot(across);
        if let Some(rate) = after.rates(velocity) {
            self.state.rate = rate;
        }
    }

    /// Whether the place is one where the surface may still be used.
    fn is_near(&self) -> bool {
        let (low, high) = self.surface.domain();
        let reach = (high - low) * BEYOND;
        let closed = self.surface.closed();
        let at = self.state.at;
        at.is_finite()
            && (0..2)
                .all(|i| closed[i] || (low[i] - reach[i]..=high[i] + reach[i]).contains(&at[i]))
    }

    /// The right-hand side of the equation; `None` without a normal.
    fn slope(&self, state: State) -> Option<State> {
        let jet = self.jet(state.at);
        let (u, v) = (state.rate.x, state.rate.y);
        let [uu, uv, vv] = jet.second;
        let bend: DVec3 = uu * (u * u) + uv * (2.0 * u * v) + vv * (v * v);
        Some(State { at: state.rate, rate: -jet.rates(bend)? })
    }

    /// A step of `h` mm.
    fn step(&self, h: f64) -> Option<Step> {
        let y = self.state;
        let mut k = [self.slope(y)?; 7];
        for i in 1..7 {
            let mut at = y;
            for (j, a) in STAGES[i - 1].iter().enumerate().take(i) {
                at = at.plus(k[j], h * a);
            }
            k[i] = self.slope(at)?;
        }
        let sum = |start: State, weights: &[f64; 7]| {
            k.iter().zip(weights).fold(start, |s, (k, w)| s.plus(*k, h * w))
        };
        let zero = State { at: DVec2::ZERO, rate: DVec2::ZERO };
        let fifth = STAGES[5];
        let end = sum(y, &[fifth[0], fifth[1], fifth[2], fifth[3], fifth[4], fifth[5], 0.0]);
        Some(Step { end, middle: sum(y, &MIDDLE), error: sum(zero, &ERROR) })
    }
}

/// Weights of the stages; the last row is the fifth-order result.
const STAGES: [[f64; 6]; 6] = [
    [1.0 / 5.0, 0.0, 0.0, 0.0, 0.0, 0.0],
    [3.0 / 40.0, 9.0 / 40.0, 0.0, 0.0, 0.0, 0.0],
    [44.0 / 45.0, -56.0 / 15.0, 32.0 / 9.0, 0.0, 0.0, 0.0],
    [19372.0 / 6561.0, -25360.0 / 2187.0, 64448.0 / 6561.0, -212.0 / 729.0, 0.0, 0.0],
    [9017.0 / 3168.0, -355.0 / 33.0, 46732.0 / 5247.0, 49.0 / 176.0, -5103.0 / 18656.0, 0.0],
    [35.0 / 384.0, 0.0, 500.0 / 1113.0, 125.0 / 192.0, -2187.0 / 6784.0, 11.0 / 84.0],
];
/// Fifth-order weights less the fourth-order ones.
const ERROR: [f64; 7] = [
    71.0 / 57600.0,
    0.0,
    -71.0 / 16695.0,
    71.0 / 1920.0,
    -17253.0 / 339_200.0,
    22.0 / 525.0,
    -1.0 / 40.0,
];
/// Weights of the state after half of a step.
const MIDDLE: [f64; 7] = [
    0.5 * 6_025_192_743.0 / 30_085_553_152.0,
    0.0,
    0.5 * 51_252_292_925.0 / 65_400_821_598.0,
    -0.5 * 2_691_868_925.0 / 45_128_329_728.0,
    0.5 * 187_940_372_067.0 / 1_594_534_317_056.0,
    -0.5 * 1_776_094_331.0 / 19_743_644_256.0,
    0.5 * 11_237_099.0 / 235_043_384.0,
];

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::math::{atan2, cos, sin};
    use crate::nurbs::NurbsCurve;

    fn revolved(meridian: &NurbsCurve) -> NurbsSurface {
        meridian.revolved(DVec3::ZERO, DVec3::X).unwrap()
    }

    fn line(a: (f64, f64), b: (f64, f64)) -> NurbsSurface {
        let at = |(x, r): (f64, f64)| DVec3::new(x, 0.0, r);
        revolved(&NurbsCurve::line(at(a), at(b)).unwrap())
    }

    /// The start, the unit tangent there, and the end of geodesics in many directions.
    fn ends(surface: &NurbsSurface, from: DVec2, length: f64) -> Vec<(Jet, DVec3, DVec3)> {
        let jet = surface.jet(from);
        let x = jet.first[0].normalize();
        let y = jet.normal().cross(x);
        (0..24)
            .map(|k| {
                let turn = f64::from(k) * std::f64::consts::TAU / 24.0 + 0.01;
                let tangent = x * cos(turn) + y * sin(turn);
                let way = jet.rates(tangent * 3.0).unwrap();
                let end = geodesic(surface, from, way, length, 1e-10).unwrap();
                let there = surface.jet_beyond(end.at);
                let speed = there.tangent(end.direction).length();
                assert!((speed - 1.0).abs() < 1e-10, "{speed}");
                assert!((end.length - length).abs() < 1e-9, "{}", end.length);
                (jet, tangent, there.point)
            })
            .collect()
    }

    #[test]
    fn weights_of_the_stages_add_up() {
        assert!(ERROR.iter().sum::<f64>().abs() < 1e-15);
        assert!((MIDDLE.iter().sum::<f64>() - 0.5).abs() < 1e-9);
        assert!((STAGES[5].iter().sum::<f64>() - 1.0).abs() < 1e-15);
    }

    #[test]
    fn on_a_cylinder_they_are_helices() {
        let surface = line((-40.0, 50.0), (40.0, 50.0));
        // The second start is on a knot line, and some ways run over the seam.
        for from in [DVec2::new(0.3, 0.4), DVec2::new(1.0, 0.5), DVec2::new(3.9, 0.5)] {
            for (jet, way, end) in ends(&surface, from, 35.0) {
                let start = jet.point;
                let turn = 35.0 * way.dot(DVec3::X.cross(start) / 50.0) / 50.0;
                let around = DVec3::X.cross(start);
                let ring = DVec3::new(0.0, start.y, start.z) * cos(turn) + around * sin(turn);
                let exact = ring + DVec3::X * (start.x + 35.0 * way.x);
                assert!(end.distance(exact) < 1e-9, "{from} {:e}", end.distance(exact));
            }
        }
    }

    #[test]
    fn on_a_cone_they_are_straight_in_the_development() {
        let surface = line((0.0, 60.0), (60.0, 45.0));
        // Slant: r falls by 15 over 60. Apex at x = 240; the development turns by sine * angle.
        let slant = (1.0 + 16.0_f64).sqrt() / 1.0;
        let sine = 1.0 / slant;
        let flat = |p: DVec3, start: f64| {
            let r = DVec2::new(p.y, p.z).length();
            let mut angle = atan2(p.y, p.z) - start;
            if angle > std::f64::consts::PI {
                angle -= std::f64::consts::TAU;
            } else if angle < -std::f64::consts::PI {
                angle += std::f64::consts::TAU;
            }
            DVec2::new(cos(sine * angle), sin(sine * angle)) * (r / sine)
        };
        for from in [DVec2::new(0.3, 0.4), DVec2::new(2.0, 0.6)] {
            for (jet, way, end) in ends(&surface, from, 25.0) {
                let start = atan2(jet.point.y, jet.point.z);
                let around = DVec3::new(0.0, cos(start), -sin(start));
                let down = -DVec3::new(-4.0, sin(start), cos(start)) / slant;
                // In the development the start lies on the first axis.
                let a = flat(jet.point, start);
                let b = a + 25.0 * DVec2::new(-way.dot(down), way.dot(around));
                let off = b.distance(flat(end, start));
                assert!(off < 1e-9, "{from} {off:e}");
            }
        }
    }

    #[test]
    fn on_a_sphere_they_are_great_circles() {
        let arc = NurbsCurve::half_circle(DVec3::ZERO, DVec3::X * -50.0, DVec3::Z * 50.0).unwrap();
        let surface = revolved(&arc);
        for (jet, way, end) in ends(&surface, DVec2::new(0.7, 0.8), 30.0) {
            let exact = jet.point * cos(0.6) + way * (50.0 * sin(0.6));
            assert!(end.distance(exact) < 1e-9, "{:e}", end.distance(exact));
        }
    }

    #[test]
    fn they_go_on_beyond_a_rim_but_not_without_end() {
        let surface = line((0.0, 50.0), (40.0, 50.0));
        let end = geodesic(&surface, DVec2::new(0.5, 0.9), DVec2::Y, 10.0, 1e-9).unwrap();
        assert!((surface.jet_beyond(end.at).point.x - 46.0).abs() < 1e-9);
        let error = geodesic(&surface, DVec2::new(0.5, 0.9), DVec2::Y, 50.0, 1e-9).unwrap_err();
        assert!(matches!(error, HubError::GeodesicEnds { .. }), "{error}");
        let error = geodesic(&surface, DVec2::new(0.5, 0.9), DVec2::ZERO, 5.0, 1e-9).unwrap_err();
        assert!(error.to_string().contains("0.000 mm on, of 5.000 mm"), "{error}");
    }
}
