//! Vectors, reproducible elementary functions and small planar geometry.

pub mod math;
pub mod polyline;

pub use glam::{DMat3, DVec2, DVec3};

/// Twice the signed area of triangle `a b c`: positive when counter-clockwise.
pub fn cross2(a: DVec2, b: DVec2, c: DVec2) -> f64 {
    (b - a).perp_dot(c - a)
}

/// Any unit vector perpendicular to the unit vector `n`.
pub fn any_perpendicular(n: DVec3) -> DVec3 {
    let helper = if n.x.abs() < 0.6 { DVec3::X } else { DVec3::Y };
    n.cross(helper).normalize()
}
