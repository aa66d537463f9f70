//! Flat point → the triangle that holds it.

use super::OutsideChart;
use crate::geometry::DVec2;
use crate::mesh::{Connectivity, FaceId};
use crate::surface::SurfacePoint;

/// Triangles in one leaf of the tree.
const LEAF: usize = 4;
/// Steps walked from a hint before the tree is asked.
const WALK: usize = 24;
/// A point this much outside of a triangle, as a part of its height, counts as on its edge.
const EDGE: f64 = 1e-9;

/// An index over the flat triangles of a mesh: a tree of bounding boxes, and walking.
#[derive(Clone, Debug)]
pub struct Locator {
    connectivity: Connectivity,
    uv: Vec<DVec2>,
    /// Faces in tree order.
    order: Vec<u32>,
    nodes: Vec<Node>,
}

#[derive(Copy, Clone, Debug)]
struct Node {
    low: DVec2,
    high: DVec2,
    /// Leaf: faces `first..first + count` of `order`. Inner: `count` is 0, children are the next
    /// node and `first`.
    first: u32,
    count: u32,
}

impl Locator {
    /// An index over a flat mesh: connectivity and `#V` flat points.
    pub fn new(connectivity: &Connectivity, uv: &[DVec2]) -> Self {
        let faces = connectivity.face_count();
        let mut locator = Self {
            connectivity: connectivity.clone(),
            uv: uv.to_vec(),
            order: (0..faces as u32).collect(),
            nodes: Vec::with_capacity(faces),
        };
        let centers: Vec<DVec2> = (0..faces as u32)
            .map(|f| locator.corners(FaceId(f)).into_iter().sum::<DVec2>() / 3.0)
            .collect();
        if faces > 0 {
            locator.build(0, faces, &centers);
        }
        locator
    }

    fn corners(&self, face: FaceId) -> [DVec2; 3] {
        self.connectivity.face(face).map(|v| self.uv[v.index()])
    }

    fn build(&mut self, first: usize, last: usize, centers: &[DVec2]) {
        let (mut low, mut high) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
        for &f in &self.order[first..last] {
            for p in self.corners(FaceId(f)) {
                (low, high) = (low.min(p), high.max(p));
            }
        }
        let slack = DVec2::splat(EDGE * (high - low).max_element());
        let (low, high) = (low - slack, high + slack);
        let node = self.nodes.len();
        let count = last - first;
        let leaf = Node { low, high, first: first as u32, count: count as u32 };
        self.nodes.push(leaf);
        if count <= LEAF {
            return;
        }
        let axis = usize::from((high - low).y > (high - low).x);
        let middle = count / 2;
        self.order[first..last].select_nth_unstable_by(middle, |&a, &b| {
            let of = |f: u32| centers[f as usize][axis];
            of(a).total_cmp(&of(b)).then(a.cmp(&b))
        });
        self.build(first, first + middle, centers);
        self.nodes[node].first = self.nodes.len() as u32;
        self.nodes[node].count = 0;
        self.build(first + middle, last, centers);
    }

    /// The surface point whose flat image is `at`; `None` outside.
    pub fn locate(&self, at: DVec2) -> Option<SurfacePoint> {
        let mut stack = vec![0u32];
        while let Some(index) = stack.pop() {
            let Some(node) = self.nodes.get(index as usize) else { break };
            if at.cmplt(node.low).any() || at.cmpgt(node.high).any() {
                continue;
            }
            if node.count == 0 {
                stack.extend([node.first, index + 1]);
                continue;
            }
            let leaf = node.first as usize..(node.first + node.count) as usize;
            for &f in &self.order[leaf] {
                let point = self.point_in(FaceId(f), at);
                if point.weights.iter().all(|&w| w >= -EDGE) {
                    return Some(point);
                }
            }
        }
        None
    }

    /// As [`Self::locate`], walking from a face near by first.
    ///
    /// # Errors
    /// [`OutsideChart`] when no triangle holds the point.
    pub fn locate_from(&self, near: FaceId, at: DVec2) -> Result<SurfacePoint, OutsideChart> {
        let mut face = near;
        for _ in 0..WALK {
            let point = self.point_in(face, at);
            let (corner, least) = (0..3).fold((0, f64::INFINITY), |best, i| {
                if point.weights[i] < best.1 { (i, point.weights[i]) } else { best }
            });
            if least >= -EDGE {
                return Ok(point);
            }
            // Through the side opposite to the most negative weight.
            match self.connectivity.opposite(face.half_edge((corner + 1) % 3)) {
                Some(side) => face = side.face(),
                None => break,
            }
        }
        self.locate(at).ok_or(OutsideChart { uv: at })
    }

    /// Barycentric coordinates of `at` in a face, negative outside of it.
    fn point_in(&self, face: FaceId, at: DVec2) -> SurfacePoint {
        let [a, b, c] = self.corners(face);
        let area = (b - a).perp_dot(c - a);
        let weights =
            [(b - at).perp_dot(c - at), (c - at).perp_dot(a - at), (a - at).perp_dot(b - at)]
                .map(|w| w / area);
        SurfacePoint { face, weights }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::flatten::samples::grid;
    use crate::geometry::DVec3;

    #[test]
    fn every_face_finds_its_own_centre_and_corners() {
        let surface = grid(9, |x, y| DVec3::new(x * x + x, y, 0.0));
        let uv: Vec<DVec2> = surface.positions().iter().map(|p| p.truncate()).collect();
        let locator = Locator::new(surface.connectivity(), &uv);
        for f in (0..surface.connectivity().face_count() as u32).map(FaceId) {
            let corners = locator.corners(f);
            let centre = (corners[0] + corners[1] + corners[2]) / 3.0;
            assert_eq!(locator.locate(centre).map(|p| p.face), Some(f));
            assert_eq!(locator.locate_from(FaceId(0), centre).map(|p| p.face), Ok(f));
            for corner in corners {
                let found = locator.locate(corner).unwrap();
                let at = surface.position(found).truncate();
                assert!((at - corner).length() < 1e-9);
            }
        }
    }

    #[test]
    fn outside_is_an_error_that_names_the_place() {
        let surface = grid(4, |x, y| DVec3::new(x, y, 0.0));
        let uv: Vec<DVec2> = surface.positions().iter().map(|p| p.truncate()).collect();
        let locator = Locator::new(surface.connectivity(), &uv);
        let far = DVec2::new(9.0, 9.0);
        assert_eq!(locator.locate(far), None);
        assert_eq!(locator.locate_from(FaceId(0), far), Err(OutsideChart { uv: far }));
    }
}
