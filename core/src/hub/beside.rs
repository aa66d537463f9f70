//! The curve beside a blade on which the outermost pass may run.
//!
//! Steps: (1) the geodesic offset of the blade's edge by the cutter's radius and the clearance; (2) where the blade leans over
//! the hub, so that the ball touches it there, the curve is moved farther out, along geodesics square to it, until the
//! ball is clear; (3) these moves are spread to both sides and smoothed, never made smaller.

use super::error::HubError;
use super::geodesic::geodesic;
use super::offset::{Side, offset};
use super::spline::ParameterCurve;
use super::wheel::Wheel;
use crate::cutter_location::Hindrance;
use crate::geometry::DVec2;

/// Places of the curve that are tried.
const PLACES: usize = 720;
/// Steps in which a place is moved out, as parts of its distance from the edge, and the most of them.
const STEP: f64 = 0.125;
const STEPS: u32 = 24;
/// Halvings of the last step.
const HALVINGS: u32 = 12;
/// Distance from a blade that leans over the ball, clearances: some room for the tool axis.
const ROOM: f64 = 1.1;
/// Places to either side over which moves are spread and smoothed.
const SPREAD: usize = 18;
/// Error of the geodesics, mm.
const EXACT: f64 = 1e-6;

/// The curve for a ball of a radius that keeps a clearance, mm, beside the edge of a blade, counter-clockwise. `tolerance`:
/// of the curve, mm.
///
/// # Errors
/// Those of the offset; [`HubError::NoRoom`] where the blade leans over farther than three times that far.
pub fn beside(
    wheel: &Wheel,
    edge: &ParameterCurve,
    blade: &Hindrance,
    (radius, clearance): (f64, f64),
    tolerance: f64,
) -> Result<ParameterCurve, HubError> {
    let curve = offset(&wheel.hub, edge, radius + clearance, Side::Right, tolerance)?;
    let count = if curve.is_closed() { PLACES } else { PLACES + 1 };
    let is_clear = |at: DVec2| {
        let jet = wheel.hub.jet_beyond(at);
        let centre = jet.point + jet.normal() * (wheel.side() * radius);
        blade.clears_ball(centre, radius, ROOM * clearance)
    };
    let moved = |i: usize, by: f64| {
        let [at, way, _] = curve.jet(i as f64 / PLACES as f64);
        if by == 0.0 {
            return Ok(at);
        }
        let jet = wheel.hub.jet_beyond(at);
        let out = jet.tangent(way).cross(jet.normal());
        let rates = jet.rates(out).unwrap_or(DVec2::ZERO);
        geodesic(&wheel.hub, at, rates, by, EXACT).map(|end| end.at)
    };
    let needed = |i: usize| {
        let is_clear_by = |by: f64| moved(i, by).map(is_clear);
        let mut clear = 0.0;
        let mut blocked = None;
        for step in 0..=STEPS {
            clear = f64::from(step) * STEP * (radius + clearance);
            if is_clear_by(clear)? {
                break;
            }
            blocked = Some(clear);
        }
        let Some(mut blocked) = blocked else { return Ok(0.0) };
        if blocked == clear {
            let place = wheel.hub.point(moved(i, 0.0)?);
            return Err(HubError::NoRoom { place, diameter: 2.0 * radius, clearance });
        }
        for _ in 0..HALVINGS {
            let middle = 0.5 * (clear + blocked);
            *(if is_clear_by(middle)? { &mut clear } else { &mut blocked }) = middle;
        }
        Ok(clear)
    };
    let needed = (0..count).map(needed).collect::<Result<Vec<f64>, _>>()?;
    if needed.iter().all(|by| *by == 0.0) {
        return Ok(curve);
    }
    let by = smooth_above(&needed, curve.is_closed());
    let points =
        by.iter().enumerate().map(|(i, by)| moved(i, *by)).collect::<Result<Vec<_>, _>>()?;
    ParameterCurve::fit(&wheel.hub, &points, curve.is_closed(), DEGREE, tolerance)
}

/// Degree of the curve.
const DEGREE: usize = 3;

/// A smooth line that is nowhere below another one.
fn smooth_above(line: &[f64], closed: bool) -> Vec<f64> {
    let n = line.len() as isize;
    let at = |i: isize| if closed { i.rem_euclid(n) } else { i.clamp(0, n - 1) } as usize;
    let near = |i: usize| (-(SPREAD as isize)..=SPREAD as isize).map(move |k| at(i as isize + k));
    let highest: Vec<f64> =
        (0..line.len()).map(|i| near(i).map(|k| line[k]).fold(0.0, f64::max)).collect();
    let count = (2 * SPREAD + 1) as f64;
    (0..line.len()).map(|i| near(i).map(|k| highest[k]).sum::<f64>() / count).collect()
}
