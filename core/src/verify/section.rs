//! Sections of the surface by a plane: chains of points with normals, from a place outward.
//!
//! Facets near the place are found in a tree of boxes; the pieces of the section on them are joined where they share
//! a point of an edge, which both facets compute identically.

use super::samples::Facets;
use crate::geometry::DVec3;

/// Facets of a leaf.
const LEAF: usize = 8;
/// Pieces of a chain at most.
const MOST_PIECES: usize = 4096;

/// Facets in a tree of boxes.
pub struct Surface<'a> {
    facets: Facets<'a>,
    normals: Vec<[DVec3; 3]>,
    order: Vec<u32>,
    /// In depth-first order, the left child of a node next to it.
    nodes: Vec<Node>,
}

/// A box around some of the facets.
struct Node {
    low: DVec3,
    high: DVec3,
    /// Index of the right child; 0 in a leaf.
    right: u32,
}

/// A point of a section.
#[derive(Copy, Clone, Debug)]
pub struct Place {
    /// Where, mm.
    pub position: DVec3,
    /// Unit normal of the surface.
    pub normal: DVec3,
}

/// Points along a section, from its start, with their distances along it, mm.
#[derive(Clone, Debug)]
pub struct Chain {
    places: Vec<(f64, Place)>,
    /// Whether the surface ends where it does.
    ends_at_boundary: bool,
}

/// A facet's part of a section: ends identified by their edges.
struct Piece {
    ends: [([u32; 2], Place); 2],
}

impl<'a> Surface<'a> {
    /// The facets of a surface.
    pub fn new(facets: Facets<'a>) -> Self {
        let mut out = Self {
            facets,
            normals: facets.normals(),
            order: (0..facets.faces.len() as u32).collect(),
            nodes: Vec::new(),
        };
        let middle = |face: &[u32; 3]| {
            let [a, b, c] = facets.corners(face);
            a + b + c
        };
        let middles: Vec<DVec3> = facets.faces.iter().map(middle).collect();
        let mut order = core::mem::take(&mut out.order);
        out.build(&mut order, &middles);
        out.order = order;
        out
    }

    fn bounds(&self, faces: &[u32]) -> (DVec3, DVec3) {
        let corners = |&f: &u32| self.facets.corners(&self.facets.faces[f as usize]);
        super::samples::bounds(faces.iter().flat_map(corners))
    }

    /// `middles`: a point in every facet, by which facets are halved.
    fn build(&mut self, order: &mut [u32], middles: &[DVec3]) {
        let (low, high) = self.bounds(order);
        let node = self.nodes.len();
        self.nodes.push(Node { low, high, right: 0 });
        if order.len() <= LEAF {
            return;
        }
        let size = high - low;
        let axis = (0..3).fold(0, |best, i| if size[i] > size[best] { i } else { best });
        let middle = |f: u32| middles[f as usize][axis];
        let half = order.len() / 2;
        order
            .select_nth_unstable_by(half, |&a, &b| middle(a).total_cmp(&middle(b)).then(a.cmp(&b)));
        let (left, right) = order.split_at_mut(half);
        self.build(left, middles);
        self.nodes[node].right = self.nodes.len() as u32;
        self.build(right, middles);
    }

    fn visit(&self, node: usize, faces: &[u32], ball: (DVec3, f64), to: &mut dyn FnMut(u32)) {
        let Node { low, high, right: next } = self.nodes[node];
        if ball.0.clamp(low, high).distance(ball.0) > ball.1 {
            return;
        }
        if faces.len() <= LEAF {
            return faces.iter().for_each(|&f| to(f));
        }
        let (left, right) = faces.split_at(faces.len() / 2);
        self.visit(node + 1, left, ball, to);
        self.visit(next as usize, right, ball, to);
    }

    /// The section through the surface near `centre` perpendicular to `way` (unit), up to `reach` mm to both sides:
    /// two chains from the place nearest to `centre` outward, to the left of the direction and to the right, seen
    /// from outside. `None` where there is no surface.
    pub fn across(&self, centre: DVec3, way: DVec3, reach: f64) -> Option<[Chain; 2]> {
        let mut pieces = Vec::new();
        // Chains wind: a little more than they are long.
        self.visit(0, &self.order, (centre, 1.1 * reach), &mut |f| {
            pieces.extend(self.piece(f as usize, centre, way));
        });
        let nearest = |p: &Piece| p.closest(centre).position.distance(centre);
        let first = (0..pieces.len())
            .min_by(|&a, &b| nearest(&pieces[a]).total_cmp(&nearest(&pieces[b])).then(a.cmp(&b)))?;
        let start = pieces[first].closest(centre);
        let left = start.normal.cross(way);
        let [a, b] = pieces[first].ends;
        let swap = (b.1.position - a.1.position).dot(left) > 0.0;
        let ends = if swap { [1, 0] } else { [0, 1] };
        Some(ends.map(|end| chain(&pieces, first, end, start, reach)))
    }

    /// What a plane cuts out of a facet.
    fn piece(&self, face: usize, centre: DVec3, way: DVec3) -> Option<Piece> {
        let corners = self.facets.faces[face];
        let height = corners.map(|v| (self.facets.positions[v as usize] - centre).dot(way));
        let mut ends = (0..3).filter_map(|i| {
            let j = (i + 1) % 3;
            if (height[i] < 0.0) == (height[j] < 0.0) {
                return None;
            }
            // In the same order from both facets.
            let (i, j) = if corners[i] < corners[j] { (i, j) } else { (j, i) };
            let t = height[i] / (height[i] - height[j]);
            let at = |k: usize| self.facets.positions[corners[k] as usize];
            let normals = self.normals[face];
            let normal = normals[i].lerp(normals[j], t).normalize_or(normals[i]);
            Some(([corners[i], corners[j]], Place { position: at(i).lerp(at(j), t), normal }))
        });
        Some(Piece { ends: [ends.next()?, ends.next()?] })
    }
}

impl Piece {
    fn closest(&self, point: DVec3) -> Place {
        let [(_, a), (_, b)] = self.ends;
        let way = b.position - a.position;
        let t = (point - a.position).dot(way) / way.length_squared();
        a.lerp(&b, if t > 0.0 { t.min(1.0) } else { 0.0 })
    }
}

impl Place {
    fn lerp(&self, other: &Self, t: f64) -> Self {
        let normal = self.normal.lerp(other.normal, t).normalize_or(self.normal);
        Self { position: self.position.lerp(other.position, t), normal }
    }
}

/// Pieces from a place on the first of them through that end of it onward.
fn chain(pieces: &[Piece], first: usize, end: usize, start: Place, reach: f64) -> Chain {
    let mut out = vec![(0.0, start)];
    let (mut piece, mut end, mut length) = (first, end, 0.0);
    let mut ends_at_boundary = false;
    while length < reach && out.len() < MOST_PIECES {
        let (edge, place) = pieces[piece].ends[end];
        length += place.position.distance(out[out.len() - 1].1.position);
        out.push((length, place));
        let next = pieces.iter().enumerate().find_map(|(i, p)| {
            let at = p.ends.iter().position(|e| e.0 == edge)?;
            (i != piece).then_some((i, 1 - at))
        });
        ends_at_boundary = next.is_none() && length < reach;
        let Some(next) = next else { break };
        (piece, end) = next;
    }
    Chain { places: out, ends_at_boundary }
}

impl Chain {
    /// How far it goes, mm.
    pub fn length(&self) -> f64 {
        self.places.last().map_or(0.0, |l| l.0)
    }

    /// Whether the boundary is less than `distance` mm beyond the place `way` mm along it.
    pub fn is_near_boundary(&self, way: f64, distance: f64) -> bool {
        self.ends_at_boundary && self.length() - way < distance
    }

    /// The place that far along it, at most at its end.
    pub fn at(&self, way: f64) -> Place {
        let i = self.places.partition_point(|p| p.0 < way).clamp(1, self.places.len() - 1);
        let ((from, a), (to, b)) = (self.places[i - 1], self.places[i]);
        let t = if to > from { ((way - from) / (to - from)).clamp(0.0, 1.0) } else { 0.0 };
        a.lerp(&b, t)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sections_of_a_folded_strip_are_as_long_as_it_unfolded() {
        // A roof over y with its ridge at y = 1, ten cells along x.
        let mut positions = Vec::new();
        let mut faces = Vec::new();
        for i in 0..=10u32 {
            for (y, z) in [(0.0, 0.0), (1.0, 1.0), (2.0, 0.0)] {
                positions.push(DVec3::new(f64::from(i), y, z));
            }
            if i < 10 {
                for v in [3 * i, 3 * i + 1] {
                    faces.extend([[v, v + 3, v + 4], [v, v + 4, v + 1]]);
                }
            }
        }
        let surface = Surface::new(Facets { positions: &positions, faces: &faces });
        let centre = DVec3::new(4.3, 0.5, 0.5);
        let [left, right] = surface.across(centre, DVec3::X, 9.0).unwrap();
        let root = 2f64.sqrt();
        assert!(right.is_near_boundary(0.0, root) && !right.is_near_boundary(0.0, 0.5 * root));
        let [left_part, _] = surface.across(centre, DVec3::X, 0.5).unwrap();
        assert!(!left_part.is_near_boundary(0.4, 1.0));
        assert!((right.length() - 0.5 * root).abs() < 1e-12, "{}", right.length());
        assert!((left.length() - 1.5 * root).abs() < 1e-12, "{}", left.length());
        assert!(
            left.at(1.0).position.distance(DVec3::new(
                4.3,
                0.5 + 0.5 * root,
                2.0 - 0.5 - 0.5 * root
            )) < 0.5
        );
        assert!(surface.across(DVec3::new(50.0, 0.0, 0.0), DVec3::X, 1.0).is_none());
    }
}
