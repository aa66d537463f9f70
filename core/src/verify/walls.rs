//! The walls around the machined surface: what stands outside its boundary and must stay.
//!
//! - *Own wall*: a face of the rest of the part that rises from a boundary edge by [`RISES`] or more. It is checked
//!   with the rest, where the depth of a cut at its edges is at most the distance from the part's other faces.
//! - *Swept wall*: any other boundary edge, moved along the tool axis or along the surface's normal. What lies behind
//!   it, seen from the machined surface, is material.
//!
//! A place of that material lies on the normal line of the nearest place of the swept wall, at a depth equal to its
//! distance from the wall. So a line extends into the material only as far as no other swept wall is nearer
//! (`depth_behind`): at a protruding corner, or on a thin wall, the depth of a cut is then the distance from the
//! wall, and what the cutter does beyond the far side does not count.

use super::samples::{Facets, Side};
use crate::geometry::boxes::{Boxes, around};
use crate::geometry::offset::CREASE;
use crate::geometry::{DVec3, OrderBy, nearest_on_triangle};
use std::collections::BTreeMap;

/// Sine of the angle to the machined surface from which a face of the part is a wall: 45 degrees.
const RISES: f64 = core::f64::consts::FRAC_1_SQRT_2;
/// How far the facets of a twisted wall may lie from its rulings, mm.
const TWIST: f64 = 1e-3;
/// Facets along a twisted wall's rulings and across them, at most.
const MOST_PARTS: [f64; 2] = [8.0, 64.0];
/// Thickness of a sheet that ends at its far side, tolerances: half of it is more than the tolerance.
const THIN: f64 = 8.0;
/// A length that counts as zero, mm.
const TOUCH: f64 = 1e-9;
/// Rounds in which the ball behind a place shrinks until it touches a facet; each adds a digit or more.
const ROUNDS: usize = 12;

/// Walls that stand around what is machined.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Walls {
    /// How far they stand above the edge of the surface, mm.
    pub height: f64,
    /// Their direction.
    pub rise: Rise,
}

/// The direction in which walls stand.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum Rise {
    /// The direction from which slopes are measured: the axis of a cutter that does not turn.
    Up,
    /// The normal of the surface at its boundary, with straight lines between its vertices.
    Normal,
}

/// The swept walls as facets whose normals point to what is machined.
#[derive(Clone, Debug, Default)]
pub struct Sheet {
    positions: Vec<DVec3>,
    faces: Vec<[u32; 3]>,
}

/// A facet of a wall.
#[derive(Copy, Clone, Debug)]
pub struct Facet {
    corners: [DVec3; 3],
    /// Its unit normal.
    pub normal: DVec3,
    /// The sphere around it.
    middle: DVec3,
    radius: f64,
}

/// A position by its bits, ignoring the sign of a zero.
type Key = [u64; 3];

/// An edge of the boundary, with the machined surface on its left as seen from the tool.
#[derive(Copy, Clone, Debug)]
pub struct Edge {
    /// From where to where.
    pub ends: [DVec3; 2],
    /// Unit normal of the machined facet.
    normal: DVec3,
    /// Which side of it.
    pub side: Side,
}

/// The boundary of the machined surface.
#[derive(Clone, Debug, Default)]
pub struct Outline {
    /// The edges at which it is open, in order.
    pub open: Vec<Side>,
    /// The ends of the edges on which walls stand, in order.
    pub walled: Vec<[DVec3; 2]>,
}

impl Outline {
    /// `is_walled`: whether walls stand around all of `design`; otherwise only where `rest` rises from it, or within
    /// `tolerance` mm beside it.
    pub fn of(design: Facets, rest: Facets, is_walled: bool, tolerance: f64) -> Self {
        let edges = boundary(design);
        let mut out = Self::default();
        let own = own_walls(&edges, rest);
        let is_beside = match is_walled {
            true => vec![true; edges.len()],
            false => walls_beside(&edges, rest, tolerance),
        };
        for ((edge, is_own), is_beside) in edges.iter().zip(own).zip(is_beside) {
            match is_own || is_beside {
                true => out.walled.push(edge.ends),
                false => out.open.push(edge.side),
            }
        }
        out.open.order_total();
        out
    }
}

impl Walls {
    /// The swept walls around `design`; `rest` has its own. `up`: unit.
    pub fn swept(&self, design: Facets, rest: Facets, up: DVec3) -> Sheet {
        let edges = boundary(design);
        let is_own = own_walls(&edges, rest);
        let rises = match self.rise {
            Rise::Up => edges.iter().flat_map(|e| e.ends).map(|p| (key(p), up)).collect(),
            Rise::Normal => normals(design, &edges),
        };
        let swept: Vec<Edge> =
            edges.iter().zip(is_own).filter(|(_, own)| !own).map(|(e, _)| *e).collect();
        Sheet::over(&swept, &rises, self.height)
    }
}

impl Sheet {
    /// Edges moved by `height` along the direction at each of their ends.
    fn over(edges: &[Edge], rises: &BTreeMap<Key, DVec3>, height: f64) -> Self {
        let rise = |p: DVec3| rises.get(&key(p)).copied().unwrap_or(DVec3::Z) * height;
        // How far a single pair of facets lies from the rulings.
        let twist = |e: &Edge| 0.25 * rise(e.ends[0]).distance(rise(e.ends[1]));
        let largest = edges.iter().map(twist).fold(0.0, f64::max);
        // Neighbours share a column, hence the number of its parts.
        let rows = (largest / TWIST).sqrt().ceil().clamp(1.0, MOST_PARTS[0]);
        let mut sheet = Self::default();
        let mut columns = BTreeMap::new();
        for edge in edges {
            let parts = (twist(edge) / (TWIST * rows)).ceil().clamp(1.0, MOST_PARTS[1]);
            let [a, b] = edge.ends;
            let mut end = |sheet: &mut Self, p: DVec3| {
                *columns.entry(key(p)).or_insert_with(|| sheet.column(p, rise(p), rows))
            };
            let (first, last) = (end(&mut sheet, a), end(&mut sheet, b));
            let mut left = first;
            for i in 1..=parts as u32 {
                let part = f64::from(i) / parts;
                let right = match i == parts as u32 {
                    true => last,
                    false => sheet.column(a.lerp(b, part), rise(a).lerp(rise(b), part), rows),
                };
                sheet.strip(left, right, rows as u32);
                left = right;
            }
        }
        sheet
    }

    /// Adds points above each other; returns the index of the lowest.
    fn column(&mut self, foot: DVec3, rise: DVec3, rows: f64) -> u32 {
        let first = self.positions.len() as u32;
        self.positions.extend((0..=rows as u32).map(|j| foot + rise * (f64::from(j) / rows)));
        first
    }

    /// Adds the facets between two columns.
    fn strip(&mut self, left: u32, right: u32, rows: u32) {
        for j in 0..rows {
            let [a, b, c, d] = [left + j, left + j + 1, right + j + 1, right + j];
            self.faces.extend([[a, b, c], [a, c, d]]);
        }
    }

    /// The facets; none where all walls are the part's own.
    pub fn facets(&self) -> Facets<'_> {
        Facets { positions: &self.positions, faces: &self.faces }
    }
}

impl Facet {
    /// `None` without an area.
    pub fn of(corners: [DVec3; 3]) -> Option<Self> {
        let [a, b, c] = corners;
        let normal = (b - a).cross(c - a).try_normalize()?;
        let middle = (a + b + c) / 3.0;
        let radius = corners.map(|p| p.distance(middle)).into_iter().fold(0.0, f64::max);
        Some(Self { corners, normal, middle, radius })
    }
}

/// The facets within a distance of a point.
pub fn near<'a>(
    facets: Facets<'a>,
    centre: DVec3,
    distance: f64,
) -> impl Iterator<Item = Facet> + 'a {
    let is_near = move |f: &Facet| f.middle.distance(centre) <= distance + f.radius;
    facets.faces.iter().filter_map(move |f| Facet::of(facets.corners(f)).filter(is_near))
}

/// How far behind a place of the part no other face of it is nearer, mm; capped at `most`. The far side of a sheet counts
/// if what is in between is thicker than a few tolerances: a thinner one is checked from both sides through and through.
pub fn part_behind(
    place: DVec3,
    normal: DVec3,
    facets: &[Facet],
    most: f64,
    tolerance: f64,
) -> f64 {
    let ends_part = |f: &Facet| f.normal.dot(normal) > -CREASE;
    let behind = depth_behind(place, normal, facets, &ends_part, most);
    // The ball that touches both sides is half as thick.
    let with_far_side = depth_behind(place, normal, facets, &|_| true, behind);
    if with_far_side > 0.5 * THIN * tolerance { with_far_side } else { behind }
}

/// How far behind a place of a wall no other wall is nearer, mm; capped at `most`.
///
/// The radius of the largest ball behind it that touches the wall there and contains nothing of the facets. Facets at
/// an angle of less than a crease belong to the same wall: the chords of a curved boundary are not corners. A facet
/// that the ball meets from its front side does not count.
/// `counts` says which of `facets` count.
pub fn depth_behind(
    place: DVec3,
    normal: DVec3,
    facets: &[Facet],
    counts: &dyn Fn(&Facet) -> bool,
    most: f64,
) -> f64 {
    let (mut radius, mut centre) = (most, place - normal * most);
    let behind = |p: &DVec3| (place - *p).dot(normal) > TOUCH;
    for facet in facets {
        // Most are farther away.
        let reach = radius + facet.radius;
        if facet.middle.distance_squared(centre) >= reach * reach
            || facet.normal.dot(normal) >= CREASE
            || !facet.corners.iter().any(behind)
            || !counts(facet)
        {
            continue;
        }
        let before = (radius, centre);
        let mut touched = None;
        for _ in 0..ROUNDS {
            let weights = nearest_on_triangle(centre, facet.corners);
            let [a, b, c] = facet.corners;
            let nearest = a * weights[0] + b * weights[1] + c * weights[2];
            let way = place - nearest;
            if nearest.distance(centre) >= radius - TOUCH || !behind(&nearest) {
                break;
            }
            radius = (0.5 * way.length_squared() / way.dot(normal)).min(radius);
            centre = place - normal * radius;
            touched = Some(nearest);
        }
        // A facet seen from its front has none of that material behind it.
        if touched.is_some_and(|at: DVec3| (at - centre).dot(facet.normal) <= 0.0) {
            (radius, centre) = before;
        }
    }
    radius
}

fn key(p: DVec3) -> Key {
    // No negative zero.
    p.to_array().map(|x| (x + 0.0).to_bits())
}

fn undirected(edge: &Edge) -> [Key; 2] {
    let mut keys = edge.ends.map(key);
    keys.order_total();
    keys
}

/// The edges with a facet on one side only, in the order of their keys.
pub fn boundary(design: Facets) -> Vec<Edge> {
    let mut halves: Vec<([u32; 2], u32, Side)> = Vec::with_capacity(3 * design.faces.len());
    for (f, face) in design.faces.iter().enumerate() {
        for i in 0..3 {
            let (a, b) = (face[i], face[(i + 1) % 3]);
            let side = Side { facet: f as u32, corner: i as u8 };
            halves.push(([a.min(b), a.max(b)], a, side));
        }
    }
    halves.order_total();
    let single = halves.chunk_by(|a, b| a.0 == b.0).filter(|halves| halves.len() == 1);
    let mut edges: Vec<Edge> = single
        .filter_map(|half| {
            let (ends, from, side) = half[0];
            let to = if ends[0] == from { ends[1] } else { ends[0] };
            let [a, b, c] = design.corners(&design.faces[side.facet as usize]);
            let normal = (b - a).cross(c - a).try_normalize()?;
            let ends = [from, to].map(|v| design.positions[v as usize]);
            (key(ends[0]) != key(ends[1])).then_some(Edge { ends, normal, side })
        })
        .collect();
    // Facets that share positions, but no vertices.
    edges.order_by_key(undirected);
    let single = edges.chunk_by(|a, b| undirected(a) == undirected(b)).filter(|e| e.len() == 1);
    single.map(|e| e[0]).collect()
}

/// Which edges, given in the order of their keys, have a face of the rest of the part that is a wall.
fn own_walls(edges: &[Edge], rest: Facets) -> Vec<bool> {
    let keys: Vec<[Key; 2]> = edges.iter().map(undirected).collect();
    let mut ends: Vec<Key> = keys.iter().flatten().copied().collect();
    ends.order_total();
    ends.dedup();
    let is_end = |p: &DVec3| ends.binary_search(&key(*p)).is_ok();
    let at_boundary: Vec<bool> = rest.positions.iter().map(is_end).collect();
    let mut is_own = vec![false; edges.len()];
    for face in rest.faces {
        if face.iter().filter(|&&v| at_boundary[v as usize]).count() < 2 {
            continue;
        }
        let corners = rest.corners(face);
        for i in 0..3 {
            let [a, b, c] = [corners[i], corners[(i + 1) % 3], corners[(i + 2) % 3]];
            let mut wanted = [key(a), key(b)];
            wanted.order_total();
            let Ok(found) = keys.binary_search(&wanted) else { continue };
            let along = (b - a).normalize_or_zero();
            let away = (c - a).reject_from_normalized(along).normalize_or_zero();
            is_own[found] |= away.dot(edges[found].normal) >= RISES;
        }
    }
    is_own
}

/// Beside which edges a face of the rest of the part rises, within a distance, that need not end on them.
fn walls_beside(edges: &[Edge], rest: Facets, distance: f64) -> Vec<bool> {
    let grown = |(face, number): (&[u32; 3], u32)| {
        let corners = rest.corners(face);
        let [less, more] = [-distance, distance].map(|by| corners.map(|p| p + by));
        around(number, &[less, more].concat())
    };
    let boxes = Boxes::new(rest.faces.iter().zip(0..).map(grown).collect());
    let is_beside = |edge: &Edge| {
        let middle = 0.5 * (edge.ends[0] + edge.ends[1]);
        let rises = |[a, b, c]: [DVec3; 3]| {
            let normal = (b - a).cross(c - a).normalize_or_zero();
            let is_high = [a, b, c].iter().any(|p| (*p - middle).dot(edge.normal) > distance);
            let weights = nearest_on_triangle(middle, [a, b, c]);
            let nearest = a * weights[0] + b * weights[1] + c * weights[2];
            normal.dot(edge.normal).abs() < RISES && is_high && nearest.distance(middle) <= distance
        };
        boxes.holding(middle).any(|face| rises(rest.corners(&rest.faces[face as usize])))
    };
    edges.iter().map(is_beside).collect()
}

/// The normals at the ends of edges: means of those of the facets around them, weighted with their area.
fn normals(design: Facets, edges: &[Edge]) -> BTreeMap<Key, DVec3> {
    let ends = edges.iter().flat_map(|e| e.ends);
    let mut sums: BTreeMap<Key, DVec3> = ends.map(|p| (key(p), DVec3::ZERO)).collect();
    for face in design.faces {
        let corners = design.corners(face);
        let [a, b, c] = corners;
        for corner in corners {
            if let Some(sum) = sums.get_mut(&key(corner)) {
                *sum += (b - a).cross(c - a);
            }
        }
    }
    sums.values_mut().for_each(|n| *n = n.normalize_or(DVec3::Z));
    sums
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::math;

    const SQUARE: [[u32; 3]; 2] = [[0, 1, 2], [0, 2, 3]];
    const NOTHING: Facets = Facets { positions: &[], faces: &[] };

    fn square(size: f64) -> [DVec3; 4] {
        [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)].map(|(x, y)| DVec3::new(x, y, 0.0) * size)
    }

    fn area_and_sides(sheet: &Sheet, towards: DVec3) -> (f64, bool) {
        let facets = sheet.facets();
        let faces_it = |f: &[u32; 3]| {
            let [a, b, c] = facets.corners(f);
            (b - a).cross(c - a).dot(towards - a) > 0.0
        };
        (facets.area(), facets.faces.iter().all(faces_it))
    }

    #[test]
    fn walls_stand_around_a_square_and_face_it() {
        let positions = square(10.0);
        let design = Facets { positions: &positions, faces: &SQUARE };
        for rise in [Rise::Up, Rise::Normal] {
            let sheet = Walls { height: 3.0, rise }.swept(design, NOTHING, DVec3::Z);
            let (area, faces_it) = area_and_sides(&sheet, DVec3::new(5.0, 5.0, 1.0));
            assert!((area - 120.0).abs() < 1e-9 && faces_it, "{area}");
            assert_eq!(sheet.facets().positions.len(), 8);
        }
    }

    #[test]
    fn outlines_are_open_where_no_wall_rises() {
        let positions = square(10.0);
        let design = Facets { positions: &positions, faces: &SQUARE };
        let side = |facet, corner| Side { facet, corner };
        let open = Outline::of(design, NOTHING, false, 0.0);
        assert_eq!(open.open, [side(0, 0), side(0, 1), side(1, 1), side(1, 2)]);
        assert_eq!(
            (open.walled.len(), Outline::of(design, NOTHING, true, 0.0).walled.len()),
            (0, 4)
        );
        // It rises from the edge at y = 0.
        let rest = [positions[0], positions[1], DVec3::new(5.0, 0.0, 4.0)];
        let rest = Facets { positions: &rest, faces: &[[0, 2, 1]] };
        let own = Outline::of(design, rest, false, 0.0);
        assert_eq!((own.open.len(), own.walled.len()), (3, 1));
        // Beside it within the tolerance, with vertices of its own; and farther away, or only up to the edge.
        let beside = |y: f64, top: f64| {
            let wall = [(-3.0, top - 5.0), (13.0, top - 5.0), (5.0, top)];
            let wall = wall.map(|(x, z)| DVec3::new(x, y, z));
            let rest = Facets { positions: &wall, faces: &[[0, 2, 1]] };
            Outline::of(design, rest, false, 0.01).walled.len()
        };
        assert_eq!([beside(-0.009, 4.0), beside(-0.011, 4.0), beside(-0.009, 0.0)], [1, 0, 0]);
    }

    /// With vertices of their own, too.
    #[test]
    fn edges_inside_are_no_boundary() {
        let [a, b, c, d] = square(10.0);
        let positions = [a, b, c, a, c, d];
        let design = Facets { positions: &positions, faces: &[[0, 1, 2], [3, 4, 5]] };
        let sheet = Walls { height: 3.0, rise: Rise::Normal }.swept(design, NOTHING, DVec3::Z);
        assert!((sheet.facets().area() - 120.0).abs() < 1e-9);
    }

    #[test]
    fn a_face_of_the_part_is_a_wall_from_45_degrees_on() {
        let positions = square(10.0);
        let design = Facets { positions: &positions, faces: &SQUARE };
        let swept = |angle: f64| {
            let angle = angle.to_radians();
            // It leads away from the edge at y = 0.
            let top = DVec3::new(5.0, -math::cos(angle), math::sin(angle)) * 4.0;
            let rest = [positions[0], positions[1], top];
            let rest = Facets { positions: &rest, faces: &[[0, 2, 1]] };
            Walls { height: 3.0, rise: Rise::Up }.swept(design, rest, DVec3::Z).facets().area()
        };
        for (angle, area) in [(90.0, 90.0), (46.0, 90.0), (44.0, 120.0), (-90.0, 120.0)] {
            assert!((swept(angle) - area).abs() < 1e-9, "{angle}: {}", swept(angle));
        }
    }

    /// The rulings of a twisted wall are met, not the diagonal of four points.
    #[test]
    fn twisted_walls_follow_their_rulings() {
        let on = |x: f64| DVec3::new(x, 0.0, 0.0);
        let side = Side { facet: 0, corner: 0 };
        let edge = Edge { ends: [on(0.0), on(6.0)], normal: DVec3::Z, side };
        let tilted = DVec3::new(0.0, math::sin(0.2), math::cos(0.2));
        let rises = [(key(on(0.0)), DVec3::Z), (key(on(6.0)), tilted)].into_iter().collect();
        let sheet = Sheet::over(&[edge], &rises, 10.0);
        let facets = sheet.facets();
        let farthest = |s: f64, t: f64| {
            let on = on(6.0 * s) + DVec3::Z.lerp(tilted, s) * 10.0 * t;
            let far = |f: &[u32; 3]| {
                let corners = facets.corners(f);
                let w = nearest_on_triangle(on, corners);
                (corners[0] * w[0] + corners[1] * w[1] + corners[2] * w[2]).distance(on)
            };
            facets.faces.iter().map(far).fold(f64::INFINITY, f64::min)
        };
        for i in 0..20 {
            let (s, t) = (0.05 * f64::from(i) + 0.013, 0.043 * f64::from(i) + 0.021);
            assert!(farthest(s, t) < 1.5 * TWIST, "{}", farthest(s, t));
        }
    }

    #[test]
    fn lines_end_half_way_to_the_next_wall() {
        // An L: the corner at the origin juts out.
        let points = [(0.0, 0.0), (9.0, 0.0), (9.0, 9.0), (-9.0, 9.0), (-9.0, -9.0), (0.0, -9.0)];
        let positions = points.map(|(x, y)| DVec3::new(x, y, 0.0));
        let faces = [[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 5]];
        let design = Facets { positions: &positions, faces: &faces };
        let sheet = Walls { height: 8.0, rise: Rise::Up }.swept(design, NOTHING, DVec3::Z);
        let facets: Vec<Facet> = near(sheet.facets(), DVec3::ZERO, 60.0).collect();
        for s in [0.01, 0.3, 2.0] {
            let behind = depth_behind(DVec3::new(s, 0.0, 4.0), DVec3::Y, &facets, &|_| true, 20.0);
            assert!((behind - s).abs() < 1e-6, "{s}: {behind}");
        }
        let behind = |at: DVec3, normal| depth_behind(at, normal, &facets, &|_| true, 7.0);
        assert_eq!(behind(DVec3::new(8.0, 0.0, 4.0), DVec3::Y), 7.0);
        assert_eq!(behind(DVec3::new(0.0, 9.0, 4.0), -DVec3::Y), 7.0);
    }
}
