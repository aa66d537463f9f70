//! Halves of the plane.

use super::DVec2;

/// Most steps to a place whose halves depend on it.
const MOST_STEPS: usize = 64;

/// A half of the plane: a unit direction, and how far along it the half begins.
pub type Half = (DVec2, f64);

/// The place nearest to the origin that lies in all of some halves of the plane, or outside of one by `slack` at most;
/// `None` if there is none.
///
/// It is the origin, or the nearest on the edge of a half, or the corner of two edges.
pub fn nearest_within(halves: &[Half], slack: f64) -> Option<DVec2> {
    let is_within = |at: &DVec2| halves.iter().all(|(out, d)| out.dot(*at) >= d - slack);
    let feet = halves.iter().map(|(out, d)| *out * *d);
    let corners = halves.iter().enumerate().flat_map(|(i, (n, d))| {
        let meet =
            move |(m, e): &Half| DVec2::new(d * m.y - e * n.y, e * n.x - d * m.x) / n.perp_dot(*m);
        halves[i + 1..].iter().map(meet)
    });
    let places = [DVec2::ZERO].into_iter().chain(feet).chain(corners).filter(is_within);
    places.min_by(|a, b| a.length_squared().total_cmp(&b.length_squared()))
}

/// As [`nearest_within`] where the halves depend on the place from which they are seen: those of `from`, those of the
/// place found, and so on until it moves by less than `slack`. `seen`: the halves, `None` if there is no such place.
pub fn nearest_within_seen(
    from: DVec2,
    slack: f64,
    seen: &dyn Fn(DVec2) -> Option<Vec<Half>>,
) -> Option<DVec2> {
    let mut at = from;
    for _ in 0..MOST_STEPS {
        let before = at;
        at = nearest_within(&seen(at)?, slack)?;
        if at.distance(before) <= slack {
            break;
        }
    }
    Some(at)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nearest_place_is_on_an_edge_or_in_a_corner() {
        let slanting = DVec2::new(0.6, 0.8);
        let near = |halves: &[Half]| nearest_within(halves, 1e-9);
        assert_eq!(near(&[]), Some(DVec2::ZERO));
        assert_eq!(near(&[(DVec2::X, -1.0)]), Some(DVec2::ZERO));
        assert_eq!(near(&[(slanting, 5.0)]), Some(DVec2::new(3.0, 4.0)));
        assert_eq!(near(&[(DVec2::X, 2.0), (slanting, 5.0)]), Some(DVec2::new(3.0, 4.0)));
        let corner = near(&[(DVec2::X, 4.0), (slanting, 5.0)]).unwrap();
        assert!(corner.distance(DVec2::new(4.0, 3.25)) < 1e-12);
        assert_eq!(near(&[(DVec2::X, 1.0), (DVec2::NEG_X, -0.5)]), None);
    }

    /// Outside of two circles, seen from the place: where they meet, if each holds the nearest place out of the other.
    #[test]
    fn out_of_circles_the_nearest_place_is_found_step_by_step() {
        let outside = |at: DVec2| {
            let out_of = |middle: DVec2| {
                let out = (at - middle).normalize();
                (out, out.dot(middle) + 5.0)
            };
            Some([DVec2::new(-3.0, -0.1), DVec2::new(3.0, -0.1)].map(out_of).to_vec())
        };
        let found = nearest_within_seen(DVec2::ZERO, 1e-9, &outside).unwrap();
        assert!(found.distance(DVec2::new(0.0, 3.9)) < 1e-6, "{found}");
    }
}
