//! Hubs whose measures tests know in closed form.

use super::channel::{Channel, ROWS};
use super::spline::ParameterCurve;
use super::wheel::Wheel;
use crate::geometry::math::{cos, sin};
use crate::geometry::{DVec2, DVec3};
use crate::job::{BladeSurface, HubChannels, HubOptions, HubPasses};
use crate::nurbs::NurbsCurve;
use core::f64::consts::TAU;

/// Blades about the axis z.
pub fn options(blades: u32) -> HubOptions {
    HubOptions {
        blades,
        axis: DVec3::Z,
        origin: DVec3::ZERO,
        blade: vec![BladeSurface::Face(1)],
        splitter: Vec::new(),
        clearance: 0.5,
        extension: 6.0,
        passes: HubPasses::Strips,
        channels: HubChannels::All,
    }
}

/// A cylinder about z from z = 0 on, u around and v from 0 to 1 along; its development has the way around and z, mm.
#[derive(Copy, Clone)]
pub struct Cylinder {
    pub radius: f64,
    pub length: f64,
}

impl Cylinder {
    /// As a hub, with the tool outside.
    pub fn wheel(&self, blades: u32) -> Wheel {
        self.wheel_with_tool(blades, 2.0 * self.radius)
    }

    /// As a hub with the tool at a distance from the axis, mm.
    pub fn wheel_with_tool(&self, blades: u32, distance: f64) -> Wheel {
        let (a, b) = (DVec3::X * self.radius, DVec3::new(self.radius, 0.0, self.length));
        let surface = NurbsCurve::line(a, b).unwrap().revolved(DVec3::ZERO, DVec3::Z).unwrap();
        let tool = DVec3::new(0.0, distance, 0.5 * self.length);
        Wheel::new(&surface, &options(blades), tool).unwrap()
    }

    /// Parameters of a place of the development; beyond a rim, too.
    pub fn at(&self, flat: DVec2) -> DVec2 {
        let quarter = 0.25 * TAU * self.radius;
        let (arc, part) = ((flat.x / quarter).floor(), (flat.x / quarter).rem_euclid(1.0));
        let (s, c) = (sin(0.25 * TAU * part), cos(0.25 * TAU * part));
        // The arc of degree two with the weights 1, 1/sqrt(2), 1: sin and cos by its parameter, solved for it.
        let half = 0.5_f64.sqrt();
        let (mut low, mut high) = (0.0, 1.0);
        for _ in 0..60 {
            let t = 0.5 * (low + high);
            let y = 2.0 * half * t * (1.0 - t) + t * t;
            let x = (1.0 - t) * (1.0 - t) + 2.0 * half * t * (1.0 - t);
            *(if y * c > x * s { &mut high } else { &mut low }) = t;
        }
        DVec2::new(arc + 0.5 * (low + high), flat.y / self.length)
    }

    /// The place of the development at an angle between 0 and a whole turn.
    pub fn flat(&self, place: DVec3) -> DVec2 {
        let angle = crate::geometry::math::atan2(place.y, place.x).rem_euclid(TAU);
        DVec2::new(self.radius * angle, place.z)
    }

    /// The closed curve through places of the development.
    pub fn curve(&self, wheel: &Wheel, points: &[DVec2], closed: bool) -> ParameterCurve {
        let points: Vec<DVec2> = points.iter().map(|p| self.at(*p)).collect();
        ParameterCurve::fit(&wheel.hub, &points, closed, 3, 1e-5).unwrap()
    }

    /// The ellipse with semi-axes `half` around `centre`.
    pub fn ellipse(&self, wheel: &Wheel, centre: DVec2, half: DVec2) -> ParameterCurve {
        let angle = |i: usize| TAU * i as f64 / 360.0;
        let points = (0..360).map(|i| centre + half * DVec2::new(cos(angle(i)), sin(angle(i))));
        self.curve(wheel, &points.collect::<Vec<DVec2>>(), true)
    }

    /// The channel between two lines of the development, given by the part of the way along.
    pub fn channel(
        &self,
        wheel: &Wheel,
        left: impl Fn(f64) -> DVec2,
        right: impl Fn(f64) -> DVec2,
    ) -> Channel {
        let part = |r: usize| r as f64 / (ROWS - 1) as f64;
        let left: Vec<DVec2> = (0..ROWS).map(|r| self.at(left(part(r)))).collect();
        let right: Vec<DVec2> = (0..ROWS).map(|r| self.at(right(part(r)))).collect();
        Channel::new(wheel, &left, &right, &[]).unwrap()
    }
}
