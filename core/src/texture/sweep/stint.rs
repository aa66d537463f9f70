//! A move in time steps: which part of the edge can cut on it, and how far its points go.

use super::options::{Cutter, EdgePart, SweepOptions};
use crate::geometry::DVec3;
use crate::texture::edge::Teeth;
use crate::texture::engagement::{Stretch, lowest_stretch};
use crate::texture::kinematics::{FeedMove, Pose};
use crate::texture::steps::time_step;
use std::f64::consts::TAU;

/// Rounding of lengths, as a part of them.
pub(super) const ROUNDING: f64 = 1e-9;

/// A move, cut into time steps.
pub(super) struct Stint<'a> {
    pub of: &'a FeedMove,
    pub steps: u32,
    /// The points of the edge that are simulated.
    pub stretch: Stretch,
    /// Farthest way of a point of the body in the whole move, without the turn of the spindle, mm.
    pub way: f64,
    /// Farthest way of a simulated point in a time step, mm.
    pub step_way: f64,
    /// Middle and radius of a ball that holds all simulated points on the move.
    pub ball: (DVec3, f64),
}

impl<'a> Stint<'a> {
    pub fn new(
        of: &'a FeedMove,
        cutter: &Cutter,
        teeth: &Teeth,
        options: &SweepOptions,
        l_min: f64,
    ) -> Self {
        let profile = teeth.profile();
        let all = Stretch { first: 0, last: profile.len() - 1 };
        let thickness = options.thickness + options.slack + teeth.runout() + teeth.step();
        let effective = of.normals.map_or(all, |normals| {
            let tilted = |s: f64| {
                let normal = normals[0].lerp(normals[1], s).normalize_or(normals[1]);
                let cosine = normal.dot(of.pose(s).axis).clamp(-1.0, 1.0);
                lowest_stretch(profile, cosine, thickness)
            };
            tilted(0.0).hull(tilted(0.5)).hull(tilted(1.0))
        });
        let out = |k: usize| profile[k].rho + teeth.runout();
        let last = profile[all.last];
        let reach = out(all.last) + (last.z - profile[0].z);
        // The tip's, and what the turn of the axis adds to it.
        let feed = of.tip_feed() + of.turn_rate() * reach;
        let stretch_of = |part| if part == EdgePart::Full { all } else { effective };
        let pace = stretch_of(options.pace);
        let dt = time_step(l_min, cutter.spindle.speed, out(pace.last), feed);
        let steps = (of.duration / dt).ceil().clamp(1.0, f64::from(u32::MAX)) as u32;
        let stretch = stretch_of(options.part);
        let rim = TAU * cutter.spindle.speed * out(stretch.last);
        let step_way = (rim + feed) * of.duration / f64::from(steps) * (1.0 + ROUNDING);
        let way = feed * of.duration * (1.0 + ROUNDING);
        let heights = [stretch.first, stretch.last].map(|k| profile[k].z.abs());
        let far = out(stretch.last) + heights[0].max(heights[1]);
        let ball = (of.pose(0.5).centre, far + way + step_way + teeth.spacing());
        Self { of, steps, stretch, way, step_way, ball }
    }

    /// Of a place from the way of the corner's centre, mm².
    pub fn distance_squared(&self, place: DVec3) -> f64 {
        let [a, b] = [0.0, 1.0].map(|s| self.of.pose(s).centre);
        let way = b - a;
        let part =
            ((place - a).dot(way) / way.length_squared().max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
        place.distance_squared(a + way * part)
    }

    pub fn points(&self) -> u64 {
        (self.stretch.last - self.stretch.first + 1) as u64
    }

    pub fn pose(&self, step: u32) -> Pose {
        self.of.pose(f64::from(step) / f64::from(self.steps))
    }

    pub fn time(&self, step: u32) -> f64 {
        self.of.start + self.of.duration * f64::from(step) / f64::from(self.steps)
    }
}
