//! Strips of a bull end that stands upright: its curvature at the contact depends on the feed direction.
//!
//! On a slope of angle `theta` the cutter has the radius of its corner down the slope and, across it, the curvature
//! of the tilted ring of its bottom, `sin(theta) / (R - r_c + r_c sin(theta))`. With `S` the sum of that tensor and
//! the shape operator, what a move along `d` leaves beside it is to second order `S - (S d)(S d)ᵀ / dᵀ S d`, so a
//! strip with the unit direction `b` across it has the width `w` with `1 / w² = 1 / (8 h bᵀ S⁻¹ b)`. Passes at a
//! distance of one in the metric `S / (8 h)` lie one such strip apart, as those of a ball do.
//!
//! On a level plane the whole bottom touches, and strips are wider by its diameter in all directions.

use crate::footprint::Footprint;
use crate::geometry::DVec3;
use crate::geometry::math::sin;
use crate::level_set::StripMetric;
use crate::level_set::strip_metric::{even, of_frame};
use crate::surface::ShapeOperator;

/// Slope angle below which strips blend into those of the corner, rad: on nearly level ground the direction of
/// steepest descent changes from place to place, and with it the side on which the cutter stands.
const LEVEL: f64 = 5.0 * core::f64::consts::PI / 180.0;
/// Side step on a level plane as a fraction of the widest: where rings turn by a right angle they are farther apart by the
/// inverse.
const AT_TURNS: f64 = core::f64::consts::FRAC_1_SQRT_2;
/// By what factor strips across the slope may be wider than those along it. Larger: gaps between passes are measured
/// in ever smaller pieces along the wide strips, in time that grows quadratically.
const MOST_WIDER: f64 = 6.0;
/// Greatest skew of strips: 1 would make them infinitely long in one direction.
const MOST_SKEW: f64 = 0.9;

/// Strips of a cutter that stands along the z axis.
pub struct Upright {
    /// The cutter.
    pub footprint: Footprint,
    /// Height of the cusps, mm.
    pub cusp: f64,
    /// Widest strip across the slope, mm: wider ones would remove too much.
    pub widest: f64,
}

impl Upright {
    /// The strip metric at a place; `None` where strips are as wide in all directions of the feed. `bent` gives the curvature that the strip meets for a curvature of the surface;
    /// `corner` is `1/w²` of a ball with the corner's radius on such a section, passes² per mm².
    pub fn metric(
        &self,
        shape: &ShapeOperator,
        bent: impl Fn(f64) -> f64,
        corner: impl Fn(f64) -> f64,
    ) -> Option<StripMetric> {
        let normal = shape.normal();
        let slope = DVec3::Z.reject_from(normal);
        let down = slope.normalize_or(shape.frame[0]);
        let frame = [down, normal.cross(down)];
        let [k_down, mixed, k_level] = shape.in_frame(frame).k;
        let [k_down, k_level] = [k_down, k_level].map(bent);
        let sin_slope = slope.length();
        let level = self.footprint.along_slope(sin_slope)?;
        let wide = level.width(self.cusp, k_level, k_down);
        let steep = (sin_slope / sin(LEVEL)).min(1.0);
        let along = corner(k_down);
        let across = steep / (wide * wide) + (1.0 - steep) * corner(k_level);
        let least = (along / (MOST_WIDER * MOST_WIDER)).max(1.0 / (self.widest * self.widest));
        let weights = [along, across.max(least)];
        // The skew is that of the sum of both tensors, to second order.
        let sums = [self.footprint.k_tool() + k_down, level.k_tool() + k_level];
        let even = (sums[0] * sums[1]).max(0.0).sqrt();
        let skew = if even > 0.0 { (mixed / even).clamp(-MOST_SKEW, MOST_SKEW) } else { 0.0 };
        let skewed = skew * steep * (weights[0] * weights[1]).sqrt();
        Some(of_frame(frame, [weights[0], skewed, weights[1]], corner(0.0)))
    }

    /// The strip metric on a level plane; `None` for a cutter without flat bottom and corners.
    pub fn on_plane(&self) -> Option<StripMetric> {
        let widest = 2.0 * self.footprint.bottom()? + self.footprint.side_step(self.cusp);
        Some(even((AT_TURNS * widest).min(self.widest)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::math::cos;
    use crate::level_set::strip_metric::square_of;
    use crate::tool::Tool;

    /// The ring's silhouette beside a move up the slope is an ellipse, offset by the corner's radius; beside a
    /// level move it is the corner.
    #[test]
    fn a_slope_has_two_widths() {
        let footprint = Footprint::new(Tool::new(5.0, 1.0).unwrap(), 0.0);
        let upright = Upright { footprint, cusp: 1e-4, widest: f64::INFINITY };
        let angle: f64 = 0.5;
        let shape = ShapeOperator::flat(DVec3::new(sin(angle), 0.0, cos(angle)));
        let metric = upright.metric(&shape, |k| k, |k| (1.0 + k) / (8.0 * 1e-4)).unwrap();
        let width = |d: DVec3| 1.0 / square_of(&metric, d).sqrt();
        let down = width(DVec3::new(cos(angle), 0.0, -sin(angle)));
        assert!((down / (8.0 * 1e-4 * 1.0f64).sqrt() - 1.0).abs() < 1e-9);
        let across = (8.0 * 1e-4 * (1.0 + 4.0 / sin(angle))).sqrt();
        assert!((width(DVec3::Y) / across - 1.0).abs() < 1e-4);
        let narrowed = Upright { widest: 0.7 * across, ..upright };
        let metric = narrowed.metric(&shape, |k| k, |k| (1.0 + k) / (8.0 * 1e-4)).unwrap();
        let width = 1.0 / square_of(&metric, DVec3::Y).sqrt();
        assert!((width / narrowed.widest - 1.0).abs() < 1e-9);
    }

    /// On level ground strips are the corner's in all directions, and stay so nearby.
    #[test]
    fn level_ground_has_the_corners_strips() {
        let footprint = Footprint::new(Tool::new(5.0, 1.0).unwrap(), 0.0);
        let upright = Upright { footprint, cusp: 0.01, widest: f64::INFINITY };
        let corner = |k: f64| (1.0 + k) / 0.08;
        for angle in [0.0f64, 1e-9, 1e-4] {
            let shape = ShapeOperator::flat(DVec3::new(sin(angle), 0.0, cos(angle)));
            let metric = upright.metric(&shape, |k| k, corner).unwrap();
            for d in [DVec3::X, DVec3::Y] {
                assert!((square_of(&metric, d) / corner(0.0) - 1.0).abs() < 2e-3, "{angle}");
            }
        }
    }
}
