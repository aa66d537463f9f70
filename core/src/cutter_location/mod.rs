//! Cutter contact → cutter location: where the tip must be for the cutter to touch the surface at a
//! point, and how far it must give way to the rest of the part.

mod check_mesh;
mod drop;
mod obstacles;
mod pass;
mod probe;
mod ruling;
mod solid;

pub use check_mesh::CheckMesh;
pub use obstacles::{Obstacles, Standing};
pub use pass::{
    Contact, Located, LocatedPass, PassOptions, RaisedStretch, facet_error, locate_pass,
};
pub use probe::{is_in_wall, lowest_off_walls, raise_at, standing_clear};
pub use ruling::{Pushed, Ruling, Rulings, Stand};

use crate::geometry::DVec3;
use crate::geometry::math::{cos, sin};
use crate::tool::Tool;
use thiserror::Error;

/// Sine of the slope below which ground is level. Larger: flat ends cut into slopes by this times their radius;
/// smaller: the rounding of coordinates in files decides on which side of its contact the cutter stands.
const LEVEL: f64 = 1e-4;

/// Why a pass has no cutter locations.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum LocateError {
    /// The surface faces away from the tool.
    #[error(
        "locate: {count} of {total} contacts face away from the tool, first at ({:.3}, {:.3}, {:.3}), where the normal is {degrees:.1} degrees from the axis; it must be below 90: exclude these faces, turn the part (surface.rotate), turn its sides (surface.flip) or machine in five axes",
        place.x, place.y, place.z
    )]
    BelowHorizon {
        /// How many contacts.
        count: usize,
        /// Of how many.
        total: usize,
        /// The first of them, mm.
        place: DVec3,
        /// Angle between normal and axis there, degrees.
        degrees: f64,
    },
    /// A contact that is no contact.
    #[error(
        "locate: contact {index} at ({:.3}, {:.3}, {:.3}) has a position, unit normal, feed direction or feed that is not finite",
        place.x, place.y, place.z
    )]
    NotFinite {
        /// Its index.
        index: usize,
        /// Its position, mm.
        place: DVec3,
    },
}

/// Where the tool axis comes from.
#[derive(Copy, Clone, Debug, PartialEq)]
pub enum ToolAxis {
    /// The same unit direction everywhere (three-axis; 3+2 when not +Z).
    Fixed(DVec3),
    /// Tilted by this angle, rad, from the surface normal toward the feed direction (five-axis).
    Lead(f64),
}

/// Unit tool axis at a contact with unit `normal` and feed direction `feed` (of any length).
///
/// `cos(lead) n + sin(lead) f`, with `f` the part of the feed direction perpendicular to `n`; `n`
/// itself where there is none.
pub fn tool_axis(rule: ToolAxis, normal: DVec3, feed: DVec3) -> DVec3 {
    match rule {
        ToolAxis::Fixed(axis) => axis,
        ToolAxis::Lead(lead) => {
            let forward = (feed - normal * feed.dot(normal)).normalize_or_zero();
            (normal * cos(lead) + forward * sin(lead)).normalize_or(normal)
        }
    }
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
    let across = normal - axis * normal.dot(axis);
    let m = if across.length_squared() > LEVEL * LEVEL { across.normalize() } else { DVec3::ZERO };
    ball - m * bottom
}

/// Position of the tool tip, mm, that touches `contact` on a surface of unit `normal` toward the tool,
/// leaving an allowance of `stock` mm.
///
/// `CL = CC + stock n + r_c n + (R - r_c) m - r_c a`.
pub fn tip(tool: &Tool, contact: DVec3, normal: DVec3, axis: DVec3, stock: f64) -> DVec3 {
    contact + normal * stock - contact_offset(tool, normal, axis)
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

    #[test]
    fn lead_tilts_toward_the_feed() {
        let axis = tool_axis(ToolAxis::Lead(0.1), DVec3::Z, DVec3::new(2.0, 0.0, 5.0));
        assert!((axis - DVec3::new(sin(0.1), 0.0, cos(0.1))).length() < 1e-15);
        let no_feed = tool_axis(ToolAxis::Lead(0.1), DVec3::Z, DVec3::Z);
        assert!((no_feed - DVec3::Z).length() < 1e-15);
    }
}
