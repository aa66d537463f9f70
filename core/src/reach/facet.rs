//! Triangles.

use crate::geometry::{DVec2, DVec3};

/// Normal of a triangle, twice its area long.
pub(super) fn area_normal([a, b, c]: [DVec3; 3]) -> DVec3 {
    (b - a).cross(c - a)
}

/// The nearest place, seen from above, to `at` of what of a facet is higher than `z`, mm; `None` if nothing is.
pub(super) fn nearest_above(facet: [DVec3; 3], z: f64, at: DVec2) -> Option<DVec2> {
    let mut above: Vec<DVec2> = Vec::with_capacity(4);
    for k in 0..3 {
        let (a, b) = (facet[k], facet[(k + 1) % 3]);
        if a.z > z {
            above.push(a.truncate());
        }
        if (a.z > z) != (b.z > z) {
            above.push(a.lerp(b, (z - a.z) / (b.z - a.z)).truncate());
        }
    }
    let sides = || (0..above.len()).map(|k| (above[k], above[(k + 1) % above.len()]));
    let turns = || sides().map(|(a, b)| (b - a).perp_dot(at - a));
    if turns().all(|t| t > 0.0) || turns().all(|t| t < 0.0) {
        return (!above.is_empty()).then_some(at);
    }
    let on_side = |(a, b): (DVec2, DVec2)| {
        let way = b - a;
        let along = (at - a).dot(way) / way.length_squared().max(f64::MIN_POSITIVE);
        a + way * along.clamp(0.0, 1.0)
    };
    sides().map(on_side).min_by(|p, q| p.distance(at).total_cmp(&q.distance(at)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_of_a_facet_is_above_a_height_is_nearest_where_its_outline_says() {
        // A wall along Y at x = 2, seen as a line; a slope that is 1 high at x = 4; a level facet over the place.
        let at = |x: f64, y: f64, z: f64| DVec3::new(x, y, z);
        let wall = [at(2.0, -9.0, 0.0), at(2.0, 9.0, 0.0), at(2.0, 0.0, 6.0)];
        let slope = [at(3.0, -9.0, 0.0), at(9.0, 0.0, 6.0), at(3.0, 9.0, 0.0)];
        let level = [at(-9.0, -9.0, 3.0), at(9.0, -9.0, 3.0), at(0.0, 9.0, 3.0)];
        let near = |facet, z| nearest_above(facet, z, DVec2::ZERO);
        assert!(near(wall, 1.0).unwrap().distance(DVec2::new(2.0, 0.0)) < 1e-12);
        assert!(near(slope, 1.0).unwrap().distance(DVec2::new(4.0, 0.0)) < 1e-12);
        assert_eq!(near(level, 1.0), Some(DVec2::ZERO));
        assert_eq!(near(level, 3.0), None);
    }
}
