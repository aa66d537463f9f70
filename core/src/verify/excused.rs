//! What remains at a place, and where it is not held to the limit: the cutter does not fit, or a wall is adjacent.

use super::figures::DEEPEST;
use super::material::Swept;
use super::options::{Sphere, VerifyOptions};
use super::outcome::Outcome;
use super::profile::Profile;
use crate::geometry::DVec3;

/// Exemptions in a part of space.
pub struct Excused<'a, 'p> {
    inaccessible: Vec<&'a Sphere>,
    /// Edges on which walls stand.
    walled: Vec<[DVec3; 2]>,
    profile: &'a Profile<'p>,
    tolerance: f64,
}

impl<'a, 'p> Excused<'a, 'p> {
    /// The exemptions within a sphere; `walled`: the edges on which walls stand.
    pub fn near(
        options: &'a VerifyOptions,
        walled: &[[DVec3; 2]],
        profile: &'a Profile<'p>,
        (centre, radius): (DVec3, f64),
    ) -> Self {
        let tolerance = options.tolerance;
        let is_near = |s: &&Sphere| s.centre.distance(centre) < s.radius + radius;
        let is_edge_near = |e: &&[DVec3; 2]| distance_to(**e, centre) < radius + tolerance;
        Self {
            inaccessible: options.inaccessible.iter().filter(is_near).collect(),
            walled: walled.iter().filter(is_edge_near).copied().collect(),
            profile,
            tolerance,
        }
    }

    /// The outcome of a sample there.
    pub fn outcome(&self, s: &Swept, options: &VerifyOptions) -> Outcome {
        let sample = &s.sample;
        let inside = |b: &&Sphere| b.centre.distance(sample.position) <= b.radius;
        let beside = |e: &[DVec3; 2]| distance_to(*e, sample.position) < self.tolerance;
        // Out of reach by rounding alone, maybe.
        let is_rim = sample.on_rim && !s.is_cut();
        let allowance = if sample.machined { options.allowance } else { 0.0 };
        Outcome {
            position: sample.position.as_vec3().to_array(),
            residual: self.residual(s, allowance, options) as f32,
            area: sample.area as f32,
            up: sample.normal.dot(options.up) as f32,
            by: s.by,
            cut_before: s.cut_before,
            opened_by: s.opened_by,
            machined: sample.machined,
            is_bridge: sample.is_bridge,
            inaccessible: self.inaccessible.iter().any(inside),
            at_wall: sample.machined && (is_rim || self.walled.iter().any(beside)),
        }
    }

    /// Height left above the allowance, mm. Deeper cuts than are measured, and what no cut reached, stay what they are.
    fn residual(&self, s: &Swept, allowance: f64, options: &VerifyOptions) -> f64 {
        let (place, normal) = (s.sample.position, s.sample.normal);
        let residual = s.height - allowance;
        let limit = options.scallop.unwrap_or(f64::INFINITY) + options.tolerance;
        let deepest = DEEPEST * options.tool.radius() * (1.0 - 1e-6);
        if residual > limit && s.is_cut() {
            self.profile.height(place, normal, allowance, residual)
        } else if residual < -options.tolerance && allowance == 0.0 && -residual < deepest {
            -self.profile.depth(place, normal, -residual)
        } else {
            residual
        }
    }
}

/// Distance of a point from an edge.
fn distance_to([a, b]: [DVec3; 2], point: DVec3) -> f64 {
    let along = b - a;
    let part = ((point - a).dot(along) / along.length_squared()).clamp(0.0, 1.0);
    point.distance(a + along * part)
}
