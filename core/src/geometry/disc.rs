//! A disc that moves over a line, as the bottom of a flat end mill does over a column of material.

use super::DVec3;

/// A smaller cosine of line and axis than this is none: the disc is seen from its edge.
const EDGE_ON: f64 = 1e-9;

/// A disc in space.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Disc {
    /// Its middle, mm.
    pub middle: DVec3,
    /// Its unit normal.
    pub axis: DVec3,
}

/// How far along the line from `foot` in the unit direction `normal` a disc of radius `radius` comes at the
/// lowest on its straight way from one pose to another, mm; `None` where the line does not go through it, or
/// not from below.
///
/// Exact where the axis stays; else the place on the disc is taken as linear along the move.
#[inline]
pub fn lowest(ends: [Disc; 2], radius: f64, foot: DVec3, normal: DVec3) -> Option<f64> {
    if ends.iter().any(|disc| normal.dot(disc.axis) < EDGE_ON) {
        return None;
    }
    let height = |disc: &Disc| (disc.middle - foot).dot(disc.axis) / normal.dot(disc.axis);
    let [q0, q1] = ends.map(|disc| foot + normal * height(&disc) - disc.middle);
    // Where the way of the line through the disc's plane is in its circle.
    let way = q1 - q0;
    let (a, b, c) = (way.length_squared(), q0.dot(way), q0.length_squared() - radius * radius);
    let square = b * b - a * c;
    let (enters, leaves) = match a > 0.0 && square >= 0.0 {
        true => ((-b - square.sqrt()) / a, (-b + square.sqrt()) / a),
        false if c <= 0.0 => (0.0, 1.0),
        false => return None,
    };
    let [from, to] = ends;
    let at = |t: f64| {
        let t = t.clamp(0.0, 1.0);
        let axis = from.axis + (to.axis - from.axis) * t;
        height(&Disc { middle: from.middle.lerp(to.middle, t), axis })
    };
    (enters <= 1.0 && leaves >= 0.0).then(|| at(enters).min(at(leaves)))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A disc with its front lifted, going along x: the line beside its middle is lowest where the rear leaves
    /// it, half way through a move.
    #[test]
    fn the_rear_of_a_tilted_disc_is_lowest() {
        let axis = DVec3::new(-0.1, 0.0, 1.0).normalize();
        let disc = |x: f64| Disc { middle: DVec3::new(x, 0.0, 0.5), axis };
        let (radius, side) = (2.0_f64, 1.0);
        let rear = (radius * radius - side * side).sqrt();
        let foot = DVec3::new(0.0, side, 0.0);
        // In the plane of the disc lengths along x are longer than seen from above.
        let behind = rear * axis.z;
        let height = 0.5 - 0.1 * behind;
        let move_by = |from: f64, to: f64| lowest([disc(from), disc(to)], radius, foot, DVec3::Z);
        let found = move_by(behind - 0.3, behind + 0.3).unwrap();
        assert!((found - height).abs() < 1e-12, "{found} {height}");
        assert_eq!(move_by(behind + 0.01, behind + 0.5), None);
        let before = move_by(-0.2, 0.2).unwrap();
        assert!((before - (0.5 - 0.02)).abs() < 1e-12, "{before}");
        let beside = foot + DVec3::Y * 1.01;
        assert_eq!(lowest([disc(-3.0), disc(3.0)], radius, beside, DVec3::Z), None);
    }
}
