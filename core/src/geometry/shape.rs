//! The shape operator of a surface at a point.

use super::math::{atan2, cos, hypot, sin};
use super::{DVec3, any_perpendicular};

/// How a surface bends at a point: `k(d) = d^T K d`, 1/mm, positive where it is convex seen from
/// the tool.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct ShapeOperator {
    /// Orthonormal tangent vectors `u`, `v`; `u × v` is the normal toward the tool.
    pub frame: [DVec3; 2],
    /// `K` in that frame: `kuu`, `kuv`, `kvv`, 1/mm.
    pub k: [f64; 3],
}

impl ShapeOperator {
    /// The operator of a plane with unit normal `normal`.
    pub fn flat(normal: DVec3) -> Self {
        Self::umbilic(normal, 0.0)
    }

    /// The operator that bends by `k` (1/mm) in every direction.
    pub fn umbilic(normal: DVec3, k: f64) -> Self {
        let u = any_perpendicular(normal);
        Self { frame: [u, normal.cross(u)], k: [k, 0.0, k] }
    }

    /// From the derivatives of a parametrisation whose `pu × pv` points toward the tool.
    ///
    /// `pu`, `pv` must be linearly independent.
    ///
    /// # Source
    /// First and second fundamental form, do Carmo, "Differential Geometry of Curves and
    /// Surfaces", section 3-3, with the sign of the second one reversed.
    pub fn from_derivatives([pu, pv]: [DVec3; 2], [puu, puv, pvv]: [DVec3; 3]) -> Self {
        let normal = pu.cross(pv).normalize_or_zero();
        let second = [-puu.dot(normal), -puv.dot(normal), -pvv.dot(normal)];
        let (e, f) = (pu.length(), pu.dot(pv));
        let x = pu / e;
        let y = normal.cross(x);
        // pv = (f/e) x + g y, so y = (pv - (f/e²) pu) / g.
        let g = pv.dot(y);
        let r = f / (e * e);
        let [l, m, n] = second;
        let xx = l / (e * e);
        let xy = (m - r * l) / (e * g);
        let yy = (n - 2.0 * r * m + r * r * l) / (g * g);
        Self { frame: [x, y], k: [xx, xy, yy] }
    }

    /// The unit normal toward the tool.
    pub fn normal(&self) -> DVec3 {
        self.frame[0].cross(self.frame[1])
    }

    /// Normal curvature in the tangential part of `direction`, of any length, 1/mm.
    ///
    /// A direction along the normal has no tangential part; it gives the mean curvature.
    pub fn normal_curvature(&self, direction: DVec3) -> f64 {
        let (x, y) = (direction.dot(self.frame[0]), direction.dot(self.frame[1]));
        let square = x * x + y * y;
        if square == 0.0 {
            return self.mean();
        }
        let [xx, xy, yy] = self.k;
        (xx * x * x + 2.0 * xy * x * y + yy * y * y) / square
    }

    /// Smallest and largest normal curvature, 1/mm, and the unit direction of the largest.
    pub fn principal(&self) -> (f64, f64, DVec3) {
        let [xx, xy, yy] = self.k;
        let half = 0.5 * (xx - yy);
        let (mean, radius) = (self.mean(), hypot(half, xy));
        let angle = 0.5 * atan2(xy, half);
        let direction = self.frame[0] * cos(angle) + self.frame[1] * sin(angle);
        (mean - radius, mean + radius, direction)
    }

    /// Mean curvature, 1/mm.
    pub fn mean(&self) -> f64 {
        0.5 * (self.k[0] + self.k[2])
    }

    /// Gaussian curvature, 1/mm².
    pub fn gaussian(&self) -> f64 {
        self.k[0] * self.k[2] - self.k[1] * self.k[1]
    }

    /// The same operator in the frame that the smallest rotation to the unit normal `normal` gives.
    pub fn turned_to(&self, normal: DVec3) -> Self {
        let own = self.normal();
        let axis = own.cross(normal);
        let cosine = own.dot(normal);
        // Rodrigues; opposite normals have no smallest rotation and keep the frame's mirror.
        let turn = |v: DVec3| {
            if cosine > -0.99 {
                v * cosine + axis.cross(v) + axis * (axis.dot(v) / (1.0 + cosine))
            } else {
                v - normal * v.dot(normal)
            }
        };
        let u = turn(self.frame[0]);
        let u = (u - normal * u.dot(normal)).normalize_or(any_perpendicular(normal));
        Self { frame: [u, normal.cross(u)], k: self.k }
    }

    /// `K` in another orthonormal frame of the same tangent plane.
    pub fn in_frame(&self, frame: [DVec3; 2]) -> Self {
        let [xx, xy, yy] = self.k;
        let [[a, b], [c, d]] = frame.map(|e| [e.dot(self.frame[0]), e.dot(self.frame[1])]);
        let form = |p: f64, q: f64, r: f64, s: f64| xx * p * r + xy * (p * s + q * r) + yy * q * s;
        Self { frame, k: [form(a, b, a, b), form(a, b, c, d), form(c, d, c, d)] }
    }
}
