//! Heights beside edges, as distances from the part.
//!
//! At an edge, on a folded face or on a sliver of a noisy mesh, a line along the facet's normal leaves the part at an
//! angle: what stands on the line is nearer to another facet than to the one from which it is measured. What is above
//! the limit there is measured as the zone of a profile of a surface is, by spheres around the part (ISO 1101:2017,
//! 17.9): its greatest distance from any facet, all along the line, so that neither what bridges a groove nor what is
//! cut through a thin wall is less than half of it.

use super::samples::Facets;
use crate::geometry::{DVec3, nearest_on_triangle};
use rstar::{AABB, PointDistance, RTree, RTreeObject};
use std::sync::OnceLock;

/// Number of places on a line at which the distance is measured. More: slower; fewer: less of what it is too high is
/// taken off, since between two of them the distance may be greater by half of their distance.
const PLACES: u32 = 64;

/// The facets of the part, ordered when the first place asks for them.
pub struct Profile<'a> {
    design: Facets<'a>,
    rest: Facets<'a>,
    /// Those of the design, and all.
    trees: [OnceLock<RTree<Face<'a>>>; 2],
}

/// A facet in the tree.
struct Face<'a> {
    of: Facets<'a>,
    index: u32,
}

impl Face<'_> {
    fn corners(&self) -> [DVec3; 3] {
        self.of.corners(&self.of.faces[self.index as usize])
    }
}

impl RTreeObject for Face<'_> {
    type Envelope = AABB<[f64; 3]>;

    fn envelope(&self) -> Self::Envelope {
        let corners = self.corners().map(|c| c.to_array());
        AABB::from_points(&corners)
    }
}

impl PointDistance for Face<'_> {
    fn distance_2(&self, point: &[f64; 3]) -> f64 {
        let point = DVec3::from_array(*point);
        let corners = self.corners();
        let [a, b, c] = nearest_on_triangle(point, corners);
        (corners[0] * a + corners[1] * b + corners[2] * c).distance_squared(point)
    }
}

impl<'a> Profile<'a> {
    /// `design`: what is machined; `rest`: other facets of the part.
    pub fn new(design: Facets<'a>, rest: Facets<'a>) -> Self {
        Self { design, rest, trees: Default::default() }
    }

    /// What of a height above a place of the design is farther from it than `allowance`, mm; not less than it is, and
    /// not more than was measured.
    pub fn height(&self, place: DVec3, normal: DVec3, allowance: f64, height: f64) -> f64 {
        let way = normal * (allowance + height);
        height.min(self.farthest(0, place, way) - allowance)
    }

    /// What of a depth behind a place is farther in from any facet, mm; likewise.
    pub fn depth(&self, place: DVec3, normal: DVec3, depth: f64) -> f64 {
        depth.min(self.farthest(1, place, -normal * depth))
    }

    /// The greatest distance from facets on a straight way that begins on one of them, mm; at most so much too great
    /// as half the distance between two places.
    fn farthest(&self, of: usize, from: DVec3, way: DVec3) -> f64 {
        let tree = self.trees[of].get_or_init(|| {
            let faces =
                |of: Facets<'a>| (0..of.faces.len() as u32).map(move |index| Face { of, index });
            let rest = Facets { faces: if of == 0 { &[] } else { self.rest.faces }, ..self.rest };
            RTree::bulk_load(faces(self.design).chain(faces(rest)).collect())
        });
        let distance = |k: u32| {
            let place = from + way * (f64::from(k) / f64::from(PLACES));
            tree.nearest_neighbor_iter_with_distance_2(place.to_array())
                .next()
                .map_or(f64::INFINITY, |(_, squared)| squared.sqrt())
        };
        let between = 0.5 * way.length() / f64::from(PLACES);
        // From the far end on, where it is mostly the farthest.
        let mut most = 0.0f64;
        for k in (1..=PLACES).rev() {
            most = most.max(distance(k) + between);
            if most >= way.length() {
                break;
            }
        }
        most
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A roof: two square faces that meet in a ridge along X at a right angle, the ridge at z = 0.
    fn roof() -> (Vec<DVec3>, Vec<[u32; 3]>) {
        let at = |x: f64, y: f64| DVec3::new(x, y, -y.abs());
        let places = [-10.0, 0.0, 10.0].map(|y| [at(-10.0, y), at(10.0, y)]).concat();
        (places, vec![[0, 1, 3], [0, 3, 2], [2, 3, 5], [2, 5, 4]])
    }

    const NONE: Facets<'static> = Facets { positions: &[], faces: &[] };

    #[test]
    fn heights_on_a_plane_are_distances() {
        let (positions, faces) = roof();
        let profile = Profile::new(Facets { positions: &positions, faces: &faces }, NONE);
        let normal = DVec3::new(0.0, 1.0, 1.0).normalize();
        for height in [0.01, 0.3, 2.0] {
            let place = DVec3::new(1.0, 5.0, -5.0);
            assert!((profile.height(place, normal, 0.0, height) - height).abs() < 1e-12);
            assert!((profile.height(place, normal, 0.2, height) - height).abs() < 1e-12);
            assert!((profile.depth(place, normal, height) - height).abs() < 1e-12);
        }
    }

    #[test]
    fn beside_an_edge_the_other_face_is_nearer() {
        let (positions, faces) = roof();
        let profile = Profile::new(Facets { positions: &positions, faces: &faces }, NONE);
        // A tenth before the ridge a line steeply along the face, as the normal of a sliver would be.
        let (place, normal) = (DVec3::new(0.0, 0.1, -0.1), DVec3::new(0.0, -1.0, 0.2).normalize());
        let end = place + normal;
        let exact = (end.z + end.y.abs()) / 2.0f64.sqrt();
        let got = profile.height(place, normal, 0.0, 1.0);
        assert!((exact..=exact + 0.5 / 64.0).contains(&got), "{got} {exact}");
        // Cut along a face right behind it: as deep as that is.
        let depth =
            profile.depth(DVec3::new(0.0, 0.0, 0.0), DVec3::new(0.0, -1.0, 1.01).normalize(), 5.0);
        assert!(depth < 0.2, "{depth}");
    }

    #[test]
    fn bridged_grooves_and_walls_that_are_cut_through_are_not_excused() {
        // Two sides of a groove, or of a wall, 1 mm apart.
        let side =
            |x: f64| [[-9.0, -9.0], [9.0, -9.0], [0.0, 9.0]].map(|[y, z]| DVec3::new(x, y, z));
        let positions = [side(0.0), side(1.0)].concat();
        let faces = [[0, 1, 2], [3, 5, 4]];
        let profile = Profile::new(Facets { positions: &positions, faces: &faces }, NONE);
        let normal = DVec3::X;
        assert!(profile.height(DVec3::ZERO, normal, 0.0, 1.0) >= 0.5);
        assert!(profile.depth(DVec3::ZERO, -normal, 1.0) >= 0.5);
    }
}
