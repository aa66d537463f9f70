//! The hub as a surface around its axis.
//!
//! - *Around*: the parameter that runs about the axis; *along*: the other one, from one end of the hub to the other.
//! - *Pitch*: the turn from one blade to the next.
//!
//! A surface of revolution is made whole from its meridian, whatever part of it is given, so that all blades stand on
//! it. From blade to blade places are turned in space and projected, not shifted in the parameter: the parameter of
//! rational arcs does not run with the angle (S-HUB, step 3, corrected).

use super::error::HubError;
use crate::geometry::math::{cos, sin};
use crate::geometry::{DVec2, DVec3};
use crate::job::HubOptions;
use crate::nurbs::{Jet, NurbsCurve, NurbsSurface};
use core::f64::consts::TAU;

/// Distance from a rim, as a part of the hub, that counts as on it.
const AT_RIM: f64 = 1e-9;
/// Places along each parameter at which the shape is looked at.
const LOOKED_AT: usize = 9;
/// Deviation from a surface of revolution, as a part of its size, that is rounding of its file.
const ROUNDING: f64 = 1e-5;

/// The hub, its axis, and which way its blades follow each other.
#[derive(Clone, Debug)]
pub struct Wheel {
    /// The hub; whole if it is a surface of revolution.
    pub hub: NurbsSurface,
    /// The parameter that runs about the axis: 0 for u, 1 for v.
    pub around: usize,
    /// Number of blades.
    pub blades: u32,
    origin: DVec3,
    axis: DVec3,
    /// Turn about the axis from one blade to the next, so that the parameter around grows, rad.
    pitch: f64,
    /// 1 where the tool is on the side of `u` cross `v`, else -1.
    side: f64,
}

impl Wheel {
    /// The hub of a job, placed, mm. `on_tool_side`: a place in the air above the hub, such as one of a blade, mm.
    ///
    /// # Errors
    /// [`HubError`]: a surface that does not run around the axis.
    pub fn new(
        surface: &NurbsSurface,
        options: &HubOptions,
        on_tool_side: DVec3,
    ) -> Result<Self, HubError> {
        let HubOptions { origin, axis, blades, .. } = *options;
        let around = around(surface, origin, axis);
        let whole = revolved(surface, around, origin, axis);
        let (hub, around) = match whole {
            Some(whole) => (whole, 0),
            None => (surface.clone(), around),
        };
        if !hub.closed()[around] {
            return Err(HubError::NotAround { axis });
        }
        let mut wheel =
            Self { hub, around, blades, origin, axis, pitch: TAU / f64::from(blades), side: 1.0 };
        let (low, high) = wheel.hub.domain();
        let middle = 0.5 * (low + high);
        let jet = wheel.hub.jet(middle);
        if wheel.turn_direction(jet.point).dot(jet.first[around]) < 0.0 {
            wheel.pitch = -wheel.pitch;
        }
        let foot = wheel.nearest(on_tool_side);
        let jet = wheel.hub.jet(foot);
        if (on_tool_side - jet.point).dot(jet.normal()) < 0.0 {
            wheel.side = -1.0;
        }
        Ok(wheel)
    }

    /// Unit direction in which a place moves as the hub turns by a positive angle, times its distance from the axis.
    fn turn_direction(&self, place: DVec3) -> DVec3 {
        self.axis.cross(place - self.origin)
    }

    /// Unit direction around the axis at a place.
    pub fn around_at(&self, place: DVec3) -> DVec3 {
        self.turn_direction(place).normalize_or_zero()
    }

    /// Unit direction of the axis.
    pub fn axis(&self) -> DVec3 {
        self.axis
    }

    /// 1 where the tool is on the side of `u` cross `v`, else -1.
    pub fn side(&self) -> f64 {
        self.side
    }

    /// A direction turned by so many pitches.
    pub fn turned_direction(&self, direction: DVec3, pitches: i32) -> DVec3 {
        let angle = self.pitch * f64::from(pitches);
        let (s, c) = (sin(angle), cos(angle));
        let along = self.axis * self.axis.dot(direction);
        let across = direction - along;
        along + across * c + self.axis.cross(across) * s
    }

    /// A place turned by so many pitches, mm.
    pub fn turned(&self, place: DVec3, pitches: i32) -> DVec3 {
        self.origin + self.turned_direction(place - self.origin, pitches)
    }

    /// Parameters of a place of the hub after a turn by so many pitches; the parameter around goes on without a jump.
    ///
    /// # Errors
    /// [`HubError::NotAlike`] where the hub differs from pitch to pitch.
    pub fn carried(&self, at: DVec2, pitches: i32, tolerance: f64) -> Result<DVec2, HubError> {
        let place = self.turned(self.hub.point(at), pitches);
        let mut guess = at;
        guess[self.around] += self.period() * f64::from(pitches) / f64::from(self.blades);
        let (found, off) = self.hub.project(place, guess);
        if off > tolerance {
            return Err(HubError::NotAlike { at: place, off, tolerance });
        }
        Ok(found)
    }

    /// How much the parameter around grows by once around.
    pub fn period(&self) -> f64 {
        let (low, high) = self.hub.domain();
        (high - low)[self.around]
    }

    /// Least and greatest parameter along.
    pub fn ends(&self) -> (f64, f64) {
        let (low, high) = self.hub.domain();
        (low[1 - self.around], high[1 - self.around])
    }

    /// Position and derivatives.
    pub fn jet(&self, at: DVec2) -> Jet {
        self.hub.jet(at)
    }

    /// The place of parameters, also a little beyond the rim, mm.
    pub fn place(&self, at: DVec2) -> DVec3 {
        self.hub.jet_beyond(at).point
    }

    /// Unit normal toward the tool.
    pub fn normal(&self, at: DVec2) -> DVec3 {
        self.hub.normal(at) * self.side
    }

    /// Parameters of the point of the hub nearest to a place, from the best of a net of places.
    pub fn nearest(&self, place: DVec3) -> DVec2 {
        let (low, high) = self.hub.domain();
        const NET: usize = 24;
        let step = |i: usize| (i as f64 + 0.5) / NET as f64;
        let net = (0..NET).flat_map(|i| (0..NET).map(move |j| DVec2::new(step(i), step(j))));
        let net = net.map(|t| low + (high - low) * t);
        let best = net
            .map(|at| (self.hub.point(at).distance_squared(place), at))
            .min_by(|a, b| a.0.total_cmp(&b.0));
        self.hub.project(place, best.map_or(low, |(_, at)| at)).0
    }

    /// Whether a place is on one of the rims of the hub.
    pub fn is_at_rim(&self, at: DVec2) -> bool {
        let (low, high) = self.ends();
        let along = at[1 - self.around];
        let near = AT_RIM * (high - low);
        along - low < near || high - along < near
    }

    /// Directions around and along, of any length, mm per parameter.
    pub fn ways(&self, at: DVec2) -> [DVec3; 2] {
        let jet = self.jet(at);
        [jet.first[self.around], jet.first[1 - self.around]]
    }
}

/// Places of a net over the domain, by the one parameter, then the other.
fn net(surface: &NurbsSurface) -> impl Iterator<Item = DVec2> {
    let (low, high) = surface.domain();
    let step = |i: usize| (i as f64 + 0.5) / LOOKED_AT as f64;
    let parts =
        (0..LOOKED_AT).flat_map(move |i| (0..LOOKED_AT).map(move |j| DVec2::new(step(i), step(j))));
    parts.map(move |t| low + (high - low) * t)
}

/// The parameter whose lines run about the axis rather than the other's.
fn around(surface: &NurbsSurface, origin: DVec3, axis: DVec3) -> usize {
    let mut sums = [0.0; 2];
    for at in net(surface) {
        let jet = surface.jet(at);
        let way = axis.cross(jet.point - origin).normalize_or_zero();
        for (sum, first) in sums.iter_mut().zip(jet.first) {
            *sum += first.normalize_or_zero().dot(way).abs();
        }
    }
    usize::from(sums[1] > sums[0])
}

/// The whole surface of revolution of which `surface` is a part, u around; `None` if it is none.
fn revolved(
    surface: &NurbsSurface,
    around: usize,
    origin: DVec3,
    axis: DVec3,
) -> Option<NurbsSurface> {
    let profile = |at: DVec2| {
        let p = surface.point(at) - origin;
        DVec2::new(p.dot(axis), axis.cross(p).length())
    };
    let (low, _) = surface.domain();
    let near = ROUNDING * surface.size();
    let is_round = |at: DVec2| {
        let mut first = at;
        first[around] = low[around];
        profile(at).distance(profile(first)) < near
    };
    if !net(surface).all(is_round) {
        return None;
    }
    meridian(surface, around)?.revolved(origin, axis).ok()
}

/// The line of the surface along the other parameter at the low end of the one around; `None` where control points do
/// not lie on it.
fn meridian(surface: &NurbsSurface, around: usize) -> Option<NurbsCurve> {
    let along = 1 - around;
    let breaks = surface.breaks(around);
    if breaks.first()?.1 != surface.degree()[around] + 1 {
        return None;
    }
    let knots: Vec<f64> = surface
        .breaks(along)
        .into_iter()
        .flat_map(|(knot, times)| core::iter::repeat_n(knot, times))
        .collect();
    let degree = surface.degree()[along];
    let count = knots.len().checked_sub(degree + 1)?;
    let all: Vec<(DVec3, f64)> = surface.control_points().collect();
    let points = match around {
        0 => all.get(..count)?.to_vec(),
        _ => {
            let columns = all.len() / count;
            (0..count).map(|i| all[i * columns]).collect()
        }
    };
    NurbsCurve::new(degree, knots, points).ok()
}

#[cfg(test)]
mod tests;
