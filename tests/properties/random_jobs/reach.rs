//! Whether an upright cutter can come to a place: it is dropped on facets and walls at a grid of places.
//!
//! Dropping is exact on corners, edges and planes: the height of an edge less the cutter's underside is concave
//! along the edge, so that golden section finds its highest place.

use crate::cutter::{Cutter, least};
use evencut_core::geometry::{DVec2, DVec3};
use std::cell::RefCell;
use std::collections::HashMap;

/// Grid places on a cutter radius.
const PLACES: f64 = 16.0;
/// Rounding of heights, mm.
const CLEAR: f64 = 1e-7;

/// What an upright cutter is dropped on.
pub struct Obstacles {
    cutter: Cutter,
    faces: Vec<[DVec3; 3]>,
    edges: Vec<[DVec3; 2]>,
    face_cells: HashMap<[i64; 2], Vec<u32>>,
    edge_cells: HashMap<[i64; 2], Vec<u32>>,
    cell: f64,
    /// At places of the grid: the highest tip that is known to cut into something, the lowest that is not.
    known: RefCell<HashMap<[i64; 2], (f64, f64)>>,
}

fn cell_of(p: DVec2, cell: f64) -> [i64; 2] {
    [(p.x / cell).floor() as i64, (p.y / cell).floor() as i64]
}

impl Obstacles {
    /// Of facets, and of further edges: the tops of walls.
    pub fn new(cutter: Cutter, faces: Vec<[DVec3; 3]>, walls: &[[DVec3; 2]]) -> Self {
        let mut edges: Vec<[DVec3; 2]> = walls.to_vec();
        let mut known = std::collections::HashSet::new();
        for face in &faces {
            for k in 0..3 {
                let (a, b) = (face[k], face[(k + 1) % 3]);
                let (ka, kb) = (crate::part::key(a), crate::part::key(b));
                if known.insert(if ka < kb { [ka, kb] } else { [kb, ka] }) {
                    edges.push([a, b]);
                }
            }
        }
        let cell = cutter.radius;
        let bucket = |low: DVec3, high: DVec3, index: usize, cells: &mut HashMap<_, Vec<u32>>| {
            let reach = DVec2::splat(cutter.radius);
            let low = cell_of(low.truncate() - reach, cell);
            let high = cell_of(high.truncate() + reach, cell);
            for x in low[0]..=high[0] {
                for y in low[1]..=high[1] {
                    cells.entry([x, y]).or_default().push(index as u32);
                }
            }
        };
        let (mut face_cells, mut edge_cells) = (HashMap::new(), HashMap::new());
        for (i, [a, b, c]) in faces.iter().enumerate() {
            bucket(a.min(*b).min(*c), a.max(*b).max(*c), i, &mut face_cells);
        }
        for (i, [a, b]) in edges.iter().enumerate() {
            bucket(a.min(*b), a.max(*b), i, &mut edge_cells);
        }
        let known = RefCell::new(HashMap::new());
        Self { cutter, faces, edges, face_cells, edge_cells, cell, known }
    }

    /// Whether a cutter with this tip cuts into nothing.
    fn is_clear(&self, tip: DVec3) -> bool {
        let at = tip.truncate();
        let cell = cell_of(at, self.cell);
        let mut faces = self.face_cells.get(&cell).into_iter().flatten();
        let mut edges = self.edge_cells.get(&cell).into_iter().flatten();
        let above = |found: Option<f64>| found.is_some_and(|z| z > tip.z + CLEAR);
        !faces.any(|&f| above(self.on_face(&self.faces[f as usize], at)))
            && !edges.any(|&e| {
                let [a, b] = self.edges[e as usize];
                a.z.max(b.z) > tip.z && above(self.on_edge(&[a, b], at))
            })
    }

    /// The lowest tip of a cutter with its axis at `at` that cuts into nothing.
    #[cfg(test)]
    fn dropped(&self, at: DVec2) -> f64 {
        let cell = cell_of(at, self.cell);
        let faces = self.face_cells.get(&cell).into_iter().flatten();
        let edges = self.edge_cells.get(&cell).into_iter().flatten();
        let on_faces = faces.filter_map(|&f| self.on_face(&self.faces[f as usize], at));
        let on_edges = edges.filter_map(|&e| self.on_edge(&self.edges[e as usize], at));
        on_faces.chain(on_edges).fold(f64::NEG_INFINITY, f64::max)
    }

    /// Tip on the plane of a facet, where the contact lies in the facet.
    fn on_face(&self, face: &[DVec3; 3], at: DVec2) -> Option<f64> {
        let [a, b, c] = *face;
        let normal = (b - a).cross(c - a).normalize();
        if normal.z <= 1e-9 {
            return None;
        }
        let (radius, corner) = (self.cutter.radius, self.cutter.corner);
        let level = normal.truncate();
        let across = level.normalize_or_zero() * (radius - corner) + level * corner;
        let touch = at - across;
        let side = |p: DVec3, q: DVec3| {
            (q.truncate() - p.truncate()).perp_dot(touch - p.truncate()) >= -1e-12
        };
        if !(side(a, b) && side(b, c) && side(c, a)) {
            return None;
        }
        let height = a.z - level.dot(touch - a.truncate()) / normal.z;
        Some(height + corner * normal.z - corner)
    }

    /// Tip on an edge with its ends.
    fn on_edge(&self, [a, b]: &[DVec3; 2], at: DVec2) -> Option<f64> {
        let (start, way) = (a.truncate() - at, (*b - *a).truncate());
        // The part of the edge under the cutter.
        let (p, q) = (way.length_squared(), start.dot(way));
        let rest = start.length_squared() - self.cutter.radius * self.cutter.radius;
        let (from, to) = if p < 1e-24 {
            if rest > 0.0 {
                return None;
            }
            (0.0, 1.0)
        } else {
            let root = (q * q - p * rest).max(0.0).sqrt();
            if q * q - p * rest < 0.0 {
                return None;
            }
            (((-q - root) / p).max(0.0), ((-q + root) / p).min(1.0))
        };
        if from > to {
            return None;
        }
        let mut depth = |t: f64| {
            let across = (start + way * t).length().min(self.cutter.radius);
            self.cutter.underside(across).unwrap_or(0.0) - (a.z + (b.z - a.z) * t)
        };
        Some(-least(from, to, &mut depth).1)
    }

    /// Whether the cutter, cutting into nothing, can come down to a point: somewhere on the grid it would hold it.
    pub fn admits(&self, point: DVec3) -> bool {
        let radius = self.cutter.radius;
        let grid = radius / PLACES;
        let (low, high) = (
            cell_of(point.truncate() - DVec2::splat(radius), grid),
            cell_of(point.truncate() + DVec2::splat(radius), grid),
        );
        let node = |i: i64, j: i64| DVec2::new(i as f64 + 0.5, j as f64 + 0.5) * grid;
        (low[0]..=high[0]).any(|i| {
            (low[1]..=high[1]).any(|j| {
                let at = node(i, j);
                let Some(up) = self.cutter.underside(at.distance(point.truncate())) else {
                    return false;
                };
                let tip = at.extend(point.z - up);
                let known = self.known.borrow().get(&[i, j]).copied();
                let (blocked, clear) = known.unwrap_or((f64::NEG_INFINITY, f64::INFINITY));
                if tip.z <= blocked || tip.z >= clear {
                    return tip.z >= clear;
                }
                let is_clear = self.is_clear(tip);
                let range = if is_clear { (blocked, tip.z) } else { (tip.z, clear) };
                self.known.borrow_mut().insert([i, j], range);
                is_clear
            })
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::part::tests::sheet;

    fn cutter(radius: f64, corner: f64) -> Cutter {
        Cutter { radius, corner, length: f64::INFINITY }
    }

    #[test]
    fn cutters_rest_on_planes_edges_and_walls_as_formulas_say() {
        let slope = |x: f64, _: f64| 0.75 * x;
        for (radius, corner, tip) in [(2.0, 2.0, 0.5), (2.0, 0.0, 1.5), (2.0, 0.5, 0.125 + 1.125)] {
            // Normal (-0.6, 0, 0.8): tip above the axis's foot by R - r_c times the slope, and r_c (1 / 0.8 - 1).
            let tools = Obstacles::new(cutter(radius, corner), sheet(9.0, 6, slope), &[]);
            assert!((tools.dropped(DVec2::ZERO) - tip).abs() < 1e-9, "{radius} {corner}");
        }
        let ends = [DVec3::new(1.2, -5.0, 3.0), DVec3::new(1.2, 5.0, 3.0)];
        let wall = Obstacles::new(cutter(2.0, 2.0), Vec::new(), &[ends]);
        assert!((wall.dropped(DVec2::ZERO) - (3.0 - 2.0 + 1.6)).abs() < 1e-9);
        assert_eq!(wall.dropped(DVec2::new(-1.0, 0.0)), f64::NEG_INFINITY);
    }

    #[test]
    fn a_ball_comes_to_a_trough_wider_than_itself_only() {
        // Troughs of radius 3; the bottom at 0.
        let trough = |x: f64, _: f64| 3.0 - (9.0 - x * x).max(0.0).sqrt();
        let faces = sheet(2.9, 60, trough);
        let admits = |radius: f64| {
            Obstacles::new(cutter(radius, radius), faces.clone(), &[]).admits(DVec3::Z * 0.02)
        };
        assert!(admits(2.0) && !admits(4.0));
        // Beside a wall stays the corner under the ball.
        let wall = [DVec3::new(0.0, -9.0, 9.0), DVec3::new(0.0, 9.0, 9.0)];
        let floor = Obstacles::new(cutter(2.0, 2.0), sheet(9.0, 2, |_, _| 0.0), &[wall]);
        assert!(
            !floor.admits(DVec3::new(1.0, 0.0, 0.1)) && floor.admits(DVec3::new(2.1, 0.0, 0.01))
        );
    }
}
