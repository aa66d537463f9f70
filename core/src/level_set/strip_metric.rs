//! The strip metric: the number of passes in a step across the surface.

use crate::geometry::math::{atan2, cos, sin};
use crate::geometry::{DVec2, DVec3};
use crate::surface::ShapeOperator;

/// The strip metric at a point: a symmetric tensor, passes² per mm², as `[xx, yy, zz, xy, yz, zx]`.
pub type StripMetric = [f64; 6];

/// The same side step everywhere, mm.
pub fn even(side_step: f64) -> StripMetric {
    let m = 1.0 / (side_step * side_step);
    [m, m, m, 0.0, 0.0, 0.0]
}

/// The strip metric in which a strip has length 1 in both principal directions: `weight` is `1/w²` for the normal
/// curvatures across the feed and along it, passes² per mm².
///
/// To second order `M = (k_tool I + K) / (8 h)`. Along the normal, where no step goes, the tensor is that of a plane.
///
/// # Source
/// Kim 2007.
pub fn of_scallop(shape: &ShapeOperator, weight: impl Fn(f64, f64) -> f64) -> StripMetric {
    let (k_min, k_max, along_max) = shape.principal();
    let normal = shape.normal();
    let along_min = normal.cross(along_max);
    let mut metric = [0.0; 6];
    let ways = [(k_min, k_max, along_min), (k_max, k_min, along_max), (0.0, 0.0, normal)];
    for (k, along, d) in ways {
        add_square(&mut metric, d, weight(k, along));
    }
    metric
}

/// The strip metric with the components `[aa, ab, bb]` in an orthonormal frame of the tangent plane, and
/// `normal` along the normal, passes² per mm².
pub fn of_frame([a, b]: [DVec3; 2], [aa, ab, bb]: [f64; 3], normal: f64) -> StripMetric {
    let mut metric = [0.0; 6];
    add_square(&mut metric, a, aa - ab);
    add_square(&mut metric, b, bb - ab);
    add_square(&mut metric, a + b, ab);
    add_square(&mut metric, a.cross(b), normal);
    metric
}

fn add_square(metric: &mut StripMetric, d: DVec3, w: f64) {
    let square = [d.x * d.x, d.y * d.y, d.z * d.z, d.x * d.y, d.y * d.z, d.z * d.x];
    for (m, s) in metric.iter_mut().zip(square) {
        *m += w * s;
    }
}

/// Squared length of `e` in the metric, passes².
pub fn square_of(m: &StripMetric, e: DVec3) -> f64 {
    m[0] * e.x * e.x
        + m[1] * e.y * e.y
        + m[2] * e.z * e.z
        + 2.0 * (m[3] * e.x * e.y + m[4] * e.y * e.z + m[5] * e.z * e.x)
}

/// The strip metric in the flat plane, passes² per flat mm².
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct FlatMetric {
    /// Along the first flat coordinate.
    pub xx: f64,
    /// Mixed.
    pub xy: f64,
    /// Along the second flat coordinate.
    pub yy: f64,
}

impl FlatMetric {
    /// The metric `m` of space, pulled back from the triangle `positions` to its flat image `uv`.
    ///
    /// `None` for a flat image without area.
    pub fn of_triangle(m: &StripMetric, positions: [DVec3; 3], uv: [DVec2; 3]) -> Option<Self> {
        let (e, f) = (uv[1] - uv[0], uv[2] - uv[0]);
        let (p, q) = (positions[1] - positions[0], positions[2] - positions[0]);
        let twice_area = e.perp_dot(f);
        // Images in space of the flat unit vectors.
        let x = (p * f.y - q * e.y) / twice_area;
        let y = (q * e.x - p * f.x) / twice_area;
        let (xx, yy) = (square_of(m, x), square_of(m, y));
        let metric = Self { xx, xy: 0.5 * (square_of(m, x + y) - xx - yy), yy };
        let determinant = metric.determinant();
        (determinant.is_finite() && determinant > 0.0).then_some(metric)
    }

    /// Number of passes in the flat step `d`.
    pub fn length(&self, d: DVec2) -> f64 {
        self.dot(d, d).max(0.0).sqrt()
    }

    fn dot(&self, a: DVec2, b: DVec2) -> f64 {
        self.xx * a.x * b.x + self.xy * (a.x * b.y + a.y * b.x) + self.yy * a.y * b.y
    }

    /// Determinant of the metric, (passes² per flat mm²)².
    fn determinant(&self) -> f64 {
        self.xx * self.yy - self.xy * self.xy
    }

    /// Passes per flat mm, mean over the directions.
    pub fn mean(&self) -> f64 {
        self.determinant().max(0.0).sqrt().sqrt()
    }

    /// Passes per flat mm in the direction with the fewest.
    pub fn least(&self) -> f64 {
        let (mean, half) = (0.5 * (self.xx + self.yy), 0.5 * (self.xx - self.yy));
        (mean - (half * half + self.xy * self.xy).sqrt()).max(0.0).sqrt()
    }

    /// Passes per flat mm in the direction with the most.
    pub fn most(&self) -> f64 {
        let (mean, half) = (0.5 * (self.xx + self.yy), 0.5 * (self.xx - self.yy));
        (mean + (half * half + self.xy * self.xy).sqrt()).sqrt()
    }

    /// The flat unit vector in the direction with the most passes: the best feed direction, since strips across it
    /// are the widest.
    pub fn direction_of_most(&self) -> DVec2 {
        let angle = 0.5 * atan2(2.0 * self.xy, self.xx - self.yy);
        DVec2::new(cos(angle), sin(angle))
    }

    /// How much wider the widest strip is than the narrowest, as a fraction of it: 0 if all are equal.
    pub fn anisotropy(&self) -> f64 {
        1.0 - self.least() / self.most()
    }

    /// Greatest slope per pass of a field with that flat gradient, per flat mm.
    pub fn slope(&self, gradient: DVec2) -> f64 {
        let DVec2 { x, y } = gradient;
        let square = self.yy * x * x - 2.0 * self.xy * x * y + self.xx * y * y;
        (square / self.determinant()).max(0.0).sqrt()
    }

    /// The flat direction in which a front with that normal advances.
    pub fn across(&self, normal: DVec2) -> DVec2 {
        let DVec2 { x, y } = normal;
        DVec2::new(self.yy * x - self.xy * y, self.xx * y - self.xy * x)
    }

    /// Distance in passes of `p` from the segment `a b`, and where on it: 0 at `a`, 1 at `b`.
    pub fn nearest_on(&self, p: DVec2, a: DVec2, b: DVec2) -> (f64, f64) {
        let (way, offset) = (b - a, p - a);
        let square = self.dot(way, way);
        let t = if square > 0.0 { (self.dot(offset, way) / square).clamp(0.0, 1.0) } else { 0.0 };
        (self.length(offset - way * t), t)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Ball on a cylinder: across it `w = sqrt(8 h / (1/r + 1/rho))`, along it the plane's.
    #[test]
    fn cylinder_has_two_widths() {
        let (r, rho, h) = (5.0, 40.0, 0.01);
        let shape = ShapeOperator { frame: [DVec3::X, DVec3::Y], k: [1.0 / rho, 0.0, 0.0] };
        let m = of_scallop(&shape, |k, _| (1.0 / r + k) / (8.0 * h));
        let width = |d: DVec3| 1.0 / square_of(&m, d).sqrt();
        assert!((width(DVec3::X) - (8.0 * h / (1.0 / r + 1.0 / rho)).sqrt()).abs() < 1e-12);
        assert!((width(DVec3::Y) - (8.0 * h * r).sqrt()).abs() < 1e-12);
    }

    /// A plane stretched twofold along x, with passes of 2 mm: flat steps count 1 and 1/2.
    #[test]
    fn flat_metric_is_drawn_back() {
        let flat = [DVec2::new(1.0, 1.0), DVec2::new(3.0, 1.5), DVec2::new(0.5, 4.0)];
        let positions = flat.map(|p| DVec3::new(2.0 * p.x, p.y, 0.0));
        let metric = FlatMetric::of_triangle(&even(2.0), positions, flat).unwrap();
        assert!((metric.length(DVec2::X) - 1.0).abs() < 1e-12);
        assert!((metric.length(DVec2::Y) - 0.5).abs() < 1e-12);
        assert!((metric.least() - 0.5).abs() < 1e-12);
        assert!((metric.mean() - 0.5_f64.sqrt()).abs() < 1e-12);
        assert!((metric.slope(DVec2::new(0.0, 1.0)) - 2.0).abs() < 1e-12);
        let (distance, t) = metric.nearest_on(DVec2::new(1.0, 2.0), DVec2::ZERO, DVec2::X * 4.0);
        assert!((distance - 1.0).abs() < 1e-12 && (t - 0.25).abs() < 1e-12);
        let line = [DVec2::ZERO, DVec2::X, DVec2::X * 2.0];
        assert_eq!(FlatMetric::of_triangle(&even(2.0), positions, line), None);
    }
}
