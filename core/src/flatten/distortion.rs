//! How far a chart is from an isometry, face by face.

use super::chart::Chart;
use crate::geometry::{DVec2, DVec3};
use crate::mesh::FaceId;
use crate::surface::Surface;

/// Singular values of the affine map from a flat face to its surface face, mm per flat mm.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Distortion {
    /// Largest stretch.
    pub sigma_max: f64,
    /// Smallest stretch; negative when the flat face is turned over.
    pub sigma_min: f64,
}

impl Distortion {
    /// Distortion of a face from its corners on the surface and in the plane.
    pub fn of_triangle(solid: [DVec3; 3], flat: [DVec2; 3]) -> Self {
        // The surface face in its own plane: first side along x.
        let (e, g) = (solid[1] - solid[0], solid[2] - solid[0]);
        let length = e.length();
        let (gx, gy) = (e.dot(g) / length, e.cross(g).length() / length);
        let (p, q) = (flat[1] - flat[0], flat[2] - flat[0]);
        let det = p.perp_dot(q);
        // J = [e g] [p q]^-1
        let (a, b) = ((length * q.y - gx * p.y) / det, (gx * p.x - length * q.x) / det);
        let (c, d) = (-gy * p.y / det, gy * p.x / det);
        let similar = ((a + d) * (a + d) + (c - b) * (c - b)).sqrt();
        let mirrored = ((a - d) * (a - d) + (c + b) * (c + b)).sqrt();
        Self { sigma_max: 0.5 * (similar + mirrored), sigma_min: 0.5 * (similar - mirrored) }
    }

    /// Whether the flat face is neither turned over nor without area, beyond rounding.
    pub fn is_up(self) -> bool {
        self.sigma_min > 0.0
    }

    /// Quasi-conformal error `sigma_max / sigma_min`, 1 where conformal.
    pub fn q(self) -> f64 {
        self.sigma_max / self.sigma_min.abs()
    }

    /// Linear scale `sqrt(sigma_max sigma_min)`.
    pub fn s(self) -> f64 {
        self.tau().sqrt()
    }

    /// Area scale `sigma_max sigma_min`: surface area per flat area.
    pub fn tau(self) -> f64 {
        self.sigma_max * self.sigma_min.abs()
    }

    /// Mean stretch `sqrt((sigma_max^2 + sigma_min^2) / 2)` (Sander et al. 2001).
    pub fn sigma_ave(self) -> f64 {
        (0.5 * (self.sigma_max * self.sigma_max + self.sigma_min * self.sigma_min)).sqrt()
    }
}

/// Summary of the distortion of a chart.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Quality {
    /// Mean quasi-conformal error, weighted by surface area.
    pub mean_q: f64,
    /// Largest quasi-conformal error.
    pub max_q: f64,
    /// Smallest linear scale, mm per flat mm.
    pub min_s: f64,
    /// Largest linear scale, mm per flat mm.
    pub max_s: f64,
    /// Flat faces that are turned over or without area.
    pub flips: usize,
}

impl Chart {
    /// Distortion of one face.
    pub fn distortion(&self, surface: &Surface, face: FaceId) -> Distortion {
        let flat = surface.connectivity().face(face).map(|v| self.uv()[v.index()]);
        Distortion::of_triangle(surface.corners(face), flat)
    }

    /// Summary over all faces.
    pub fn quality(&self, surface: &Surface) -> Quality {
        let mut quality =
            Quality { mean_q: 0.0, max_q: 0.0, min_s: f64::INFINITY, max_s: 0.0, flips: 0 };
        let mut total = 0.0;
        for f in 0..surface.connectivity().face_count() as u32 {
            let d = self.distortion(surface, FaceId(f));
            let [a, b, c] = surface.corners(FaceId(f));
            let area = (b - a).cross(c - a).length();
            if d.is_up() {
                quality.mean_q += area * d.q();
                total += area;
                quality.max_q = quality.max_q.max(d.q());
            } else {
                quality.flips += 1;
            }
            quality.min_s = quality.min_s.min(d.s());
            quality.max_s = quality.max_s.max(d.s());
        }
        quality.mean_q /= total;
        quality
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_stretch() {
        let flat = [DVec2::ZERO, DVec2::X, DVec2::Y];
        let solid = [DVec3::Z, DVec3::Z + 3.0 * DVec3::X, DVec3::Z + 2.0 * DVec3::Y];
        let d = Distortion::of_triangle(solid, flat);
        assert!((d.sigma_max - 3.0).abs() < 1e-15 && (d.sigma_min - 2.0).abs() < 1e-15);
        assert!((d.q() - 1.5).abs() < 1e-15 && (d.tau() - 6.0).abs() < 1e-14);
        let turned = Distortion::of_triangle(solid, [flat[0], flat[2], flat[1]]);
        assert!(turned.sigma_min < 0.0);
    }
}
