//! Position of the tip of a cutter that touches a contact.

use crate::geometry::DVec3;
use crate::tool::Tool;

/// Sine of the slope below which ground counts as level. Larger: flat ends cut into slopes by this times their
/// radius; smaller: the rounding of coordinates in files decides on which side of its contact the cutter stands.
const LEVEL: f64 = 1e-4;

/// Whether ground of unit `normal` is level, for a cutter along `axis`.
pub fn is_level(normal: DVec3, axis: DVec3) -> bool {
    normal.reject_from_normalized(axis).length_squared() <= LEVEL * LEVEL
}

/// From the tip of the cutter to the point at which it touches a surface of unit `normal`, mm.
///
/// `r_c a - r_c n - (R - r_c) m`, with `m` the direction of the part of `n` perpendicular to `a`. On level ground the
/// whole flat bottom touches, and `m` is zero: the point lies under the middle of it.
pub fn contact_offset(tool: &Tool, normal: DVec3, axis: DVec3) -> DVec3 {
    let corner = tool.corner_radius();
    let bottom = tool.radius() - corner;
    let ball = (axis - normal) * corner;
    if bottom == 0.0 {
        return ball;
    }
    let m = match is_level(normal, axis) {
        true => DVec3::ZERO,
        false => normal.reject_from_normalized(axis).normalize(),
    };
    ball - m * bottom
}

/// Position of the tool tip, mm, that touches `contact` on a surface of unit `normal` toward the tool,
/// leaving an allowance of `allowance` mm.
///
/// `CL = CC + allowance n + r_c n + (R - r_c) m - r_c a`.
pub fn tip(tool: &Tool, contact: DVec3, normal: DVec3, axis: DVec3, allowance: f64) -> DVec3 {
    contact + normal * allowance - contact_offset(tool, normal, axis)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ball_flat_and_bull_follow_the_formula() {
        let n = DVec3::new(0.6, 0.0, 0.8);
        let at = |r, c| tip(&Tool::new(r, c).unwrap(), DVec3::ZERO, n, DVec3::Z, 0.0);
        assert!((at(5.0, 5.0) - (n * 5.0 - DVec3::Z * 5.0)).length() < 1e-15);
        assert!((at(5.0, 0.0) - DVec3::X * 5.0).length() < 1e-15);
        assert!((at(5.0, 1.0) - (n + DVec3::X * 4.0 - DVec3::Z)).length() < 1e-15);
    }

    #[test]
    fn the_bottom_lies_on_a_horizontal_surface() {
        for corner in [0.0, 1.0, 5.0] {
            let tool = Tool::new(5.0, corner).unwrap();
            let t = tip(&tool, DVec3::new(1.0, 2.0, 3.0), DVec3::Z, DVec3::Z, 0.25);
            assert!((t.z - 3.25).abs() < 1e-15);
        }
    }
}
