//! Bounds of groups of samples, by which a step that stays clear of a whole group is recognised at once.
//!
//! Samples are skipped where a plane separates them from the cutter: the plane through the cutter's point nearest to
//! their highest point, perpendicular to the line between the two. The cutter is convex, so it lies behind that
//! plane.

use super::body::Body;
use super::lanes::{Vectors, lanes};
use super::material::{Material, Swept};
use super::motion::Step;
use super::samples::Sample;
use crate::geometry::DVec3;

/// Material thinner than this is ignored, mm: a flat end slides over what it has cut.
pub const NOTHING: f64 = 1e-7;

/// Bounds of groups of samples, one per lane.
pub struct Bounds<const N: usize> {
    len: usize,
    centres: [DVec3; N],
    normals: Vectors<N>,
    /// Highest material of interest along the mean normal through the centre.
    tops: Vectors<N>,
    /// From the lowest place of interest to the highest along the mean normal.
    depth: [f64; N],
    /// The lowest place above the centre.
    bottom: [f64; N],
    /// Farthest sample's line across the mean normal, up to the stock's height.
    radius: [f64; N],
    /// How far below the surface the lines go, mm.
    deepest: f64,
}

impl<const N: usize> Bounds<N> {
    /// No set.
    pub const EMPTY: Self = Self {
        len: 0,
        centres: [DVec3::ZERO; N],
        normals: Vectors::ZERO,
        tops: Vectors::ZERO,
        depth: [0.0; N],
        bottom: [0.0; N],
        radius: [0.0; N],
        deepest: 0.0,
    };

    /// Adds a set; there may be `N`.
    pub fn add(&mut self, samples: &[Swept], material: Material) {
        let n = samples.len().max(1) as f64;
        let sum: DVec3 = samples.iter().map(|s| s.sample.position).sum();
        let centre = sum / n;
        let normals: DVec3 = samples.iter().map(|s| s.sample.normal).sum();
        let normal = normals.normalize_or(DVec3::Z);
        let cell = samples.iter().map(|s| 0.5 * s.sample.cell_width()).fold(0.0, f64::max);
        let across = |p: DVec3| (p - centre - normal * (p - centre).dot(normal)).length() + cell;
        let ends = |s: &Swept| {
            let Sample { position: p, normal: n, .. } = s.sample;
            across(p + n * s.height).max(across(p - n * material.deepest))
        };
        // On a thin sheet a set may hold samples of both sides.
        let low = |s: &Swept| {
            let Sample { position: p, normal: n, .. } = s.sample;
            let [top, bottom] = [p + n * s.height, p - n * material.deepest];
            (top - centre).dot(normal).min((bottom - centre).dot(normal))
        };
        let lane = self.len;
        self.len += 1;
        self.centres[lane] = centre;
        self.normals.set(lane, normal);
        self.radius[lane] = samples.iter().map(ends).fold(0.0, f64::max);
        self.deepest = material.deepest;
        self.bottom[lane] = samples.iter().map(low).fold(f64::INFINITY, f64::min);
        self.settle(lane, samples);
    }

    /// Updates the bound with what is left of a group.
    pub fn settle(&mut self, lane: usize, samples: &[Swept]) {
        let (centre, normal) = (self.centres[lane], self.normals.get(lane));
        let top = |s: &Swept| {
            let Sample { position: p, normal: n, .. } = s.sample;
            let [top, bottom] = [p + n * s.height.max(s.left), p - n * self.deepest];
            (top - centre).dot(normal).max((bottom - centre).dot(normal))
        };
        let top = samples.iter().map(top).fold(f64::NEG_INFINITY, f64::max);
        self.tops.set(lane, centre + normal * (top - NOTHING));
        self.depth[lane] = (top - self.bottom[lane]).max(0.0);
    }

    /// The groups of which the cutter may reach something during a step.
    pub fn reached(&self, step: &Step, body: &Body) -> u32 {
        let near = body.nearest_of(&step.to, &self.tops);
        let up = near.outward.dot(&self.normals);
        // Before its end the cutter was nearer if it goes away; but what is left was clear of it at the
        // start, where the step before ended.
        let nearer = near.outward.along(-2.0 * step.half_way);
        let dip = body.dip(2.0 * step.half_way.length()).unwrap_or(f64::INFINITY);
        let mut margin: [f64; N] = core::array::from_fn(|i| {
            let level = 1.0 - up[i] * up[i];
            let across = self.radius[i] * (if level > 0.0 { level } else { 0.0 }).sqrt();
            let below = if up[i] > 0.0 { self.depth[i] * up[i] } else { 0.0 };
            let way = if nearer[i] > dip { dip } else { nearer[i] };
            near.distance[i] - (if way > 0.0 { way } else { 0.0 }) - across - below
        });
        if step.half_turn != 0.0 {
            let far = self.tops.distances(step.middle.tip);
            for i in 0..N {
                let arms = far[i] + self.radius[i] + self.depth[i];
                margin[i] -= 2.0 * step.half_turn * arms;
            }
        }
        // A point in the cutter has no direction, hence no margin that is a number.
        let clear = lanes::<N>(|i| near.distance[i] > 0.0 && margin[i] > 0.0);
        !clear & ((1 << self.len) - 1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::offset::CrossSection;
    use crate::tool::Tool;
    use crate::verify::body::Placed;

    const RADIUS: f64 = 4.0;
    const STOCK: f64 = 0.5;
    const THICKNESS: f64 = 0.9;

    /// Three samples of the upper side of a thin sheet and one of its lower side.
    fn both_sides(material: Material) -> Vec<Swept> {
        let sample = |x: f64, z: f64, normal: DVec3| {
            let position = DVec3::new(x, 0.0, z);
            Sample {
                section: CrossSection::on(0.01, [DVec3::ZERO; 3], [DVec3::Z; 3]),
                ..Sample::bare(position, normal)
            }
        };
        let upper = [-0.1, 0.0, 0.1].map(|x| sample(x, 0.0, DVec3::Z));
        let lower = sample(0.0, -THICKNESS, -DVec3::Z);
        upper.into_iter().chain([lower]).map(|s| Swept::new(s, false, material)).collect()
    }

    /// A step along x of a ball whose tip is at a height, from above or from below.
    fn step(height: f64, axis: DVec3) -> Step {
        let at = |x: f64| Placed { tip: DVec3::new(x, 0.0, height), axis };
        let half_way = DVec3::X * 0.01;
        Step {
            from: at(-0.01),
            middle: at(0.0),
            to: at(0.01),
            of: 0,
            index: 0,
            half_way,
            half_turn: 0.0,
        }
    }

    #[test]
    fn the_stock_on_either_side_of_a_thin_sheet_is_reached() {
        let material =
            Material { height: STOCK, layer: STOCK, allowance: 0.0, deepest: 0.1, tolerance: 0.0 };
        let mut bounds = Bounds::<4>::EMPTY;
        bounds.add(&both_sides(material), material);
        let body = Body::new(&Tool::new(RADIUS, RADIUS).unwrap(), 40.0);
        let outer = [(STOCK, DVec3::Z), (-THICKNESS - STOCK, -DVec3::Z)];
        for (surface, axis) in outer {
            let inside = step(surface - 0.1 * axis.z, axis);
            assert_eq!(bounds.reached(&inside, &body), 1, "from {axis}");
            let clear = step(surface + 0.5 * axis.z, axis);
            assert_eq!(bounds.reached(&clear, &body), 0, "from {axis}");
        }
    }
}
