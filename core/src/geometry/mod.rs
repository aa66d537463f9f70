//! Vectors, reproducible elementary functions, small planar geometry and the shape operator of a surface.

pub mod beyond;
pub mod boxes;
pub mod disc;
pub mod halves;
pub mod math;
pub mod offset;
mod order;
pub mod polyline;
pub mod shape;
mod shown;

pub use glam::{DMat3, DVec2, DVec3};
pub use order::OrderBy;
pub use shown::Shown;

/// Twice the signed area of triangle `a b c`: positive when counter-clockwise.
pub fn cross2(a: DVec2, b: DVec2, c: DVec2) -> f64 {
    (b - a).perp_dot(c - a)
}

/// The rotation about X, then Y, then Z, by these angles, rad.
pub fn rotation(angles: DVec3) -> DMat3 {
    let [(sx, cx), (sy, cy), (sz, cz)] = angles.to_array().map(|a| (math::sin(a), math::cos(a)));
    let about_x = DMat3::from_cols(DVec3::X, DVec3::new(0.0, cx, sx), DVec3::new(0.0, -sx, cx));
    let about_y = DMat3::from_cols(DVec3::new(cy, 0.0, -sy), DVec3::Y, DVec3::new(sy, 0.0, cy));
    let about_z = DMat3::from_cols(DVec3::new(cz, sz, 0.0), DVec3::new(-sz, cz, 0.0), DVec3::Z);
    about_z * about_y * about_x
}

/// Any unit vector perpendicular to the unit vector `n`.
pub fn any_perpendicular(n: DVec3) -> DVec3 {
    let helper = if n.x.abs() < 0.6 { DVec3::X } else { DVec3::Y };
    n.cross(helper).normalize()
}

/// Distance of `p` from the straight line from `a` to `b`, which ends there.
pub fn distance_to_segment(p: DVec3, a: DVec3, b: DVec3) -> f64 {
    let (way, square) = (b - a, a.distance_squared(b));
    let part = if square > 0.0 { ((p - a).dot(way) / square).clamp(0.0, 1.0) } else { 0.0 };
    p.distance(a + way * part)
}

/// Barycentric coordinates of the point of triangle `a b c` nearest to `p`.
///
/// # Source
/// Ericson, "Real-Time Collision Detection", section 5.1.5.
pub fn nearest_on_triangle(p: DVec3, [a, b, c]: [DVec3; 3]) -> [f64; 3] {
    let (ab, ac) = (b - a, c - a);
    let (d1, d2) = (ab.dot(p - a), ac.dot(p - a));
    let (d3, d4) = (ab.dot(p - b), ac.dot(p - b));
    let (d5, d6) = (ab.dot(p - c), ac.dot(p - c));
    if d1 <= 0.0 && d2 <= 0.0 {
        return [1.0, 0.0, 0.0];
    }
    if d3 >= 0.0 && d4 <= d3 {
        return [0.0, 1.0, 0.0];
    }
    if d6 >= 0.0 && d5 <= d6 {
        return [0.0, 0.0, 1.0];
    }
    let (va, vb, vc) = (d3 * d6 - d5 * d4, d5 * d2 - d1 * d6, d1 * d4 - d3 * d2);
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        let t = d1 / (d1 - d3);
        return [1.0 - t, t, 0.0];
    }
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        let t = d2 / (d2 - d6);
        return [1.0 - t, 0.0, t];
    }
    if va <= 0.0 && d4 >= d3 && d5 >= d6 {
        let t = (d4 - d3) / ((d4 - d3) + (d5 - d6));
        return [0.0, 1.0 - t, t];
    }
    let sum = va + vb + vc;
    [va / sum, vb / sum, vc / sum]
}
