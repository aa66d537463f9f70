//! The inverse map: flat point → point of the surface.
//!
//! Flat faces may differ in size a thousandfold and more, so they are found through a tree of
//! bounding boxes. Along a path, walking from the previous point's face is faster still.

use super::error::OutsideChart;
use crate::geometry::{DVec2, OrderBy, cross2};
use crate::mesh::{Connectivity, FaceId, HalfEdgeId};
use crate::surface::SurfacePoint;
use std::sync::Arc;

/// Faces in one leaf of the tree: more make the search slower, fewer the tree larger.
const LEAF: usize = 4;
/// A weight this far below zero is rounding: the point lies on the side.
const ON_SIDE: f64 = 1e-12;
/// A point outside by at most this part of the chart's size lies on its boundary.
const ON_BOUNDARY: f64 = 1e-9;
/// Tolerances of way within which faces, at very uneven scale, may be too small to walk through.
const SHORT_WALK: f64 = 1e3;
/// Faces a walk may cross before the tree takes over.
const LONGEST_WALK: usize = 64;

/// Finds the surface points of the flat points of a chart.
#[derive(Clone, Debug)]
pub struct Locator<'a> {
    flat: Flat<'a>,
    tree: Arc<FaceTree>,
}

/// The flat faces of a mesh: its connectivity and `#V` flat points.
#[derive(Copy, Clone, Debug)]
struct Flat<'a> {
    connectivity: &'a Connectivity,
    uv: &'a [DVec2],
}

/// The boxes around the flat faces of a mesh, of which it holds nothing.
#[derive(Clone, Debug, Default)]
pub struct FaceTree {
    nodes: Vec<Node>,
    /// Faces in the order of the leaves.
    faces: Vec<u32>,
    /// Distance from the boundary within which a point counts as on it, flat mm.
    tolerance: f64,
}

/// A box around some faces; its first child follows it.
#[derive(Copy, Clone, Debug)]
struct Node {
    low: DVec2,
    high: DVec2,
    /// Second child of an inner node; where the faces of a leaf begin.
    second_or_first: u32,
    /// Faces of a leaf; 0 for an inner node.
    count: u32,
}

impl Node {
    fn is_near(&self, p: DVec2, distance: f64) -> bool {
        (self.low - p).max(p - self.high).max_element() <= distance
    }
}

impl Flat<'_> {
    fn corners(&self, face: FaceId) -> [DVec2; 3] {
        self.connectivity.face(face).map(|v| self.uv[v.index()])
    }
}

impl<'a> Locator<'a> {
    /// Indexes the flat faces of a mesh: its connectivity and `#V` flat points.
    pub fn new(connectivity: &'a Connectivity, uv: &'a [DVec2]) -> Self {
        Self::by(Arc::new(FaceTree::new(connectivity, uv)), connectivity, uv)
    }

    /// By the boxes made earlier of the same flat faces.
    pub fn by(tree: Arc<FaceTree>, connectivity: &'a Connectivity, uv: &'a [DVec2]) -> Self {
        Self { flat: Flat { connectivity, uv }, tree }
    }

    /// The surface point at `uv`, flat mm.
    ///
    /// On a shared side or corner, the face of the smallest index.
    ///
    /// # Errors
    /// [`OutsideChart`] when `uv` lies outside by more than rounding.
    pub fn locate(&self, uv: DVec2) -> Result<SurfacePoint, OutsideChart> {
        let mut found: Option<SurfacePoint> = None;
        self.tree.visit(uv, 0.0, |face| {
            let earlier = found.is_none_or(|best| face < best.face);
            if earlier && let Some(weights) = inside(self.flat.corners(face), uv) {
                found = Some(SurfacePoint { face, weights });
            }
        });
        match found {
            Some(point) => Ok(point),
            None => self.nearest(uv).ok_or(OutsideChart { uv }),
        }
    }

    /// As [`Self::locate`], walking from face `hint`: fast when `uv` is near it.
    ///
    /// On a shared side or corner, whichever face the walk reaches first.
    ///
    /// # Errors
    /// [`OutsideChart`] when `uv` lies outside by more than rounding.
    pub fn locate_from(&self, hint: FaceId, uv: DVec2) -> Result<SurfacePoint, OutsideChart> {
        let mut face = hint;
        for _ in 0..LONGEST_WALK {
            let corners = self.flat.corners(face);
            if let Some(weights) = inside(corners, uv) {
                return Ok(SurfacePoint { face, weights });
            }
            let weights = weights(corners, uv);
            let lowest = (0..3).fold(0, |l, i| if weights[i] < weights[l] { i } else { l });
            match self.flat.connectivity.opposite(face.half_edge((lowest + 1) % 3)) {
                Some(side) => face = side.face(),
                None => break,
            }
        }
        self.locate(uv)
    }

    /// Follows the straight flat line from `from` to `to` through the chart.
    ///
    /// `start`: a face that holds `from`. `cross` is called for every side crossed, with the side
    /// of the face that is left and the part of the way done. Returns the surface point of `to`.
    ///
    /// # Errors
    /// [`OutsideChart`] with the place where the line leaves the chart.
    pub fn walk(
        &self,
        start: FaceId,
        from: DVec2,
        to: DVec2,
        mut cross: impl FnMut(HalfEdgeId, f64),
    ) -> Result<SurfacePoint, OutsideChart> {
        let (way, mut face, mut done) = (to - from, start, 0.0);
        // A straight line enters a face once.
        for _ in 0..=self.flat.connectivity.face_count() {
            if let Some(weights) = inside(self.flat.corners(face), to) {
                return Ok(SurfacePoint { face, weights });
            }
            let Some((side, t)) = self.exit(face, from, way, done) else { break };
            done = t;
            let Some(next) = self.flat.connectivity.opposite(side) else { break };
            face = next.face();
            cross(side, t);
        }
        // What is left of the way is within rounding of the chart's coordinates: its end decides.
        let left = (1.0 - done) * way.length();
        match self.locate(to) {
            Ok(end) if left <= SHORT_WALK * self.tree.tolerance => Ok(end),
            _ => Err(OutsideChart { uv: from + way * done }),
        }
    }

    /// The side through which the line leaves `face`, and the part of the way done there.
    fn exit(&self, face: FaceId, from: DVec2, way: DVec2, done: f64) -> Option<(HalfEdgeId, f64)> {
        let corners = self.flat.corners(face);
        let leaving = (0..3).filter_map(|i| {
            let (a, b) = (corners[i], corners[(i + 1) % 3]);
            let across = way.perp_dot(b - a);
            // Positive where the way turns to the right of the side: outward.
            (across > 0.0).then(|| (face.half_edge(i), (a - from).perp_dot(b - a) / across))
        });
        let nearest = leaving.min_by(|x, y| x.1.total_cmp(&y.1));
        nearest.map(|(side, t)| (side, t.clamp(done, 1.0)))
    }

    /// The nearest point of the chart when it is within the tolerance.
    fn nearest(&self, uv: DVec2) -> Option<SurfacePoint> {
        let mut best = (self.tree.tolerance, None);
        self.tree.visit(uv, self.tree.tolerance, |face| {
            let (distance, weights) = nearest_on(self.flat.corners(face), uv);
            let first = best.1.is_none_or(|p: SurfacePoint| face < p.face);
            if distance < best.0 || (distance == best.0 && first) {
                best = (distance, Some(SurfacePoint { face, weights }));
            }
        });
        best.1
    }
}

impl FaceTree {
    /// The boxes around the flat faces of a mesh: its connectivity and `#V` flat points.
    pub fn new(connectivity: &Connectivity, uv: &[DVec2]) -> Self {
        let flat = Flat { connectivity, uv };
        let count = connectivity.face_count();
        let mut tree =
            Self { nodes: Vec::with_capacity(count), faces: by_place(flat), tolerance: 0.0 };
        if count > 0 {
            tree.build(flat, 0, count);
        }
        if let Some(root) = tree.nodes.first() {
            tree.tolerance = ON_BOUNDARY * (root.high - root.low).length();
        }
        tree
    }

    /// Calls `look` for the faces of all leaves within `distance` of `p`.
    fn visit(&self, p: DVec2, distance: f64, mut look: impl FnMut(FaceId)) {
        let mut open = vec![0usize];
        while let Some(n) = open.pop() {
            let Some(node) = self.nodes.get(n) else { continue };
            if !node.is_near(p, distance) {
                continue;
            }
            let from = node.second_or_first as usize;
            if node.count == 0 {
                open.extend([from, n + 1]);
            } else {
                let leaf = &self.faces[from..from + node.count as usize];
                leaf.iter().for_each(|&f| look(FaceId(f)));
            }
        }
    }

    /// Appends the tree over `count` of the ordered faces from `first`; its box.
    fn build(&mut self, flat: Flat, first: usize, count: usize) -> (DVec2, DVec2) {
        let node = self.nodes.len();
        let (mut low, mut high) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
        self.nodes.push(Node { low, high, second_or_first: first as u32, count: count as u32 });
        if count <= LEAF {
            for &f in &self.faces[first..first + count] {
                for p in flat.corners(FaceId(f)) {
                    (low, high) = (low.min(p), high.max(p));
                }
            }
        } else {
            let half = count / 2;
            let left = self.build(flat, first, half);
            self.nodes[node].count = 0;
            self.nodes[node].second_or_first = self.nodes.len() as u32;
            let right = self.build(flat, first + half, count - half);
            (low, high) = (left.0.min(right.0), left.1.max(right.1));
        }
        (self.nodes[node].low, self.nodes[node].high) = (low, high);
        (low, high)
    }
}

/// The faces along a curve that fills the chart, by their centres.
///
/// Source: Morton, "A computer oriented geodetic data base", 1966.
fn by_place(flat: Flat) -> Vec<u32> {
    let centre = |f: u32| flat.corners(FaceId(f)).into_iter().sum::<DVec2>() / 3.0;
    let faces = 0..flat.connectivity.face_count() as u32;
    let centres: Vec<DVec2> = faces.map(centre).collect();
    let low = centres.iter().fold(DVec2::INFINITY, |low, c| low.min(*c));
    let high = centres.iter().fold(DVec2::NEG_INFINITY, |high, c| high.max(*c));
    let cells = f64::from(u32::MAX) / (high - low).max_element();
    // Casts saturate: of a chart without extent all faces are at one place.
    let key = |c: &DVec2| {
        let cell = (*c - low) * cells;
        spread(cell.x as u32) | spread(cell.y as u32) << 1
    };
    let mut keyed: Vec<(u64, u32)> = centres.iter().map(key).zip(0..).collect();
    keyed.order_total();
    keyed.into_iter().map(|(_, f)| f).collect()
}

/// The bits of a number, each followed by a zero.
fn spread(x: u32) -> u64 {
    let mut x = u64::from(x);
    for (shift, mask) in [
        (16, 0x0000_ffff_0000_ffff),
        (8, 0x00ff_00ff_00ff_00ff),
        (4, 0x0f0f_0f0f_0f0f_0f0f),
        (2, 0x3333_3333_3333_3333),
        (1, 0x5555_5555_5555_5555),
    ] {
        x = (x | x << shift) & mask;
    }
    x
}

/// Barycentric coordinates of `p`, which sum to 1; negative beyond the opposite side.
fn weights([a, b, c]: [DVec2; 3], p: DVec2) -> [f64; 3] {
    let area = cross2(a, b, c);
    let (u, v) = (cross2(p, b, c) / area, cross2(p, c, a) / area);
    [u, v, cross2(p, a, b) / area]
}

/// Weights of `p`, none negative, when it lies inside the triangle or on its boundary.
fn inside(corners: [DVec2; 3], p: DVec2) -> Option<[f64; 3]> {
    let weights = weights(corners, p);
    if !weights.iter().all(|&w| w >= -ON_SIDE) {
        return None;
    }
    let kept = weights.map(|w| w.max(0.0));
    let sum = kept[0] + kept[1] + kept[2];
    Some(kept.map(|w| w / sum))
}

/// Distance of the triangle's boundary from `p` and the weights of its nearest point.
fn nearest_on(corners: [DVec2; 3], p: DVec2) -> (f64, [f64; 3]) {
    let mut best = (f64::INFINITY, [0.0; 3]);
    for i in 0..3 {
        let (a, b) = (corners[i], corners[(i + 1) % 3]);
        let t = ((p - a).dot(b - a) / (b - a).length_squared()).clamp(0.0, 1.0);
        let distance = p.distance(a + (b - a) * t);
        if distance < best.0 {
            let mut weights = [0.0; 3];
            weights[i] = 1.0 - t;
            weights[(i + 1) % 3] = t;
            best = (distance, weights);
        }
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::flatten::Chart;
    use crate::flatten::samples::{self, jitter};
    use crate::surface::Surface;

    fn chart_of_plane(n: usize) -> (Surface, Chart) {
        let surface = samples::sheared_plane(n, 0.3);
        let flat = surface.positions().iter().map(|p| p.truncate()).collect();
        let chart = Chart::new(&surface, flat);
        (surface, chart)
    }

    #[test]
    fn every_inner_point_is_found_both_ways() {
        let (surface, chart) = chart_of_plane(23);
        let locator = chart.locator(&surface);
        let mut hint = FaceId(0);
        for k in 0..2000 {
            let (s, t) = (jitter(k, 7) + 0.5, jitter(k, 8) + 0.5);
            let uv = DVec2::new(s + 0.3 * t, t);
            let point = locator.locate(uv).unwrap();
            assert!(surface.position(point).truncate().distance(uv) < 1e-12);
            let walked = locator.locate_from(hint, uv).unwrap();
            assert!(surface.position(walked).truncate().distance(uv) < 1e-12);
            hint = walked.face;
        }
    }

    #[test]
    fn a_walk_crosses_sides_in_order_and_stops_at_the_boundary() {
        let (surface, chart) = chart_of_plane(12);
        let locator = chart.locator(&surface);
        let at = |i: usize| chart.uv()[i];
        let (from, to) = (at(1).lerp(at(40), 0.3), at(100).lerp(at(130), 0.6));
        let start = locator.locate(from).unwrap().face;
        let mut parts = Vec::new();
        let end = locator.walk(start, from, to, |_, t| parts.push(t)).unwrap();
        assert!(surface.position(end).truncate().distance(to) < 1e-9);
        assert!(parts.len() > 4 && parts.windows(2).all(|w| w[0] <= w[1]));
        let far = to + (to - from) * 9.0;
        let left = locator.walk(start, from, far, |_, _| {}).unwrap_err();
        assert!((left.uv - from).perp_dot(far - from).abs() < 1e-6);
    }

    #[test]
    fn corners_and_boundary_count_as_inside() {
        let (surface, chart) = chart_of_plane(9);
        let locator = chart.locator(&surface);
        for (v, &uv) in chart.uv().iter().enumerate() {
            let point = locator.locate(uv).unwrap();
            assert!(surface.position(point).distance(surface.positions()[v]) < 1e-12);
        }
        assert!(locator.locate(DVec2::new(0.4, -1e-10)).is_ok());
        assert!(locator.locate_from(FaceId(0), DVec2::new(0.4, -1e-10)).is_ok());
    }

    #[test]
    fn outside_is_an_error_with_its_place() {
        let (surface, chart) = chart_of_plane(9);
        let locator = chart.locator(&surface);
        for uv in [DVec2::new(0.4, -1e-6), DVec2::new(9.0, 9.0), DVec2::new(f64::NAN, 0.0)] {
            let fault = locator.locate(uv).unwrap_err();
            assert!(fault.uv == uv || uv.x.is_nan());
            assert!(locator.locate_from(FaceId(3), uv).is_err());
        }
    }
}
