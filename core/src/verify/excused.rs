//! Where remaining material is not held to the limit: the cutter does not fit, or a wall is adjacent.

use super::material::Swept;
use super::options::{Sphere, VerifyOptions};
use super::outcome::Outcome;
use crate::geometry::DVec3;

/// Exemptions in a part of space.
pub struct Excused<'a> {
    inaccessible: Vec<&'a Sphere>,
    /// Edges on which walls stand.
    walled: Vec<[DVec3; 2]>,
    tolerance: f64,
}

impl<'a> Excused<'a> {
    /// The exemptions within a sphere; `walled`: the edges on which walls stand.
    pub fn near(
        options: &'a VerifyOptions,
        walled: &[[DVec3; 2]],
        centre: DVec3,
        radius: f64,
    ) -> Self {
        let tolerance = options.tolerance;
        let is_near = |s: &&Sphere| s.centre.distance(centre) < s.radius + radius;
        let is_edge_near = |e: &&[DVec3; 2]| distance_to(**e, centre) < radius + tolerance;
        Self {
            inaccessible: options.inaccessible.iter().filter(is_near).collect(),
            walled: walled.iter().filter(is_edge_near).copied().collect(),
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
            residual: (s.height - allowance) as f32,
            area: sample.section.area as f32,
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
}

/// Distance of a point from an edge.
fn distance_to([a, b]: [DVec3; 2], point: DVec3) -> f64 {
    let along = b - a;
    let part = ((point - a).dot(along) / along.length_squared()).clamp(0.0, 1.0);
    point.distance(a + along * part)
}
