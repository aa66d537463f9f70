//! Cutting a split mesh along lines.
//!
//! - *Isoline*: where a function that is linear on every face changes its sign.
//! - *Polyline*: given by flat points, as separatrices are.
//!
//! Afterwards both run along edges of the mesh. Where a line passes very close to a vertex, it is moved onto it;
//! otherwise needle-shaped faces would result.

use super::split_mesh::{SplitMesh, next, previous};
use crate::flatten::Locator;
use crate::geometry::{DVec2, OrderBy, cross2};
use crate::mesh::FaceId;

/// Fraction of an edge, or of a face's height, by which a line is moved at most to meet a vertex or an edge. Larger:
/// ragged lines; smaller: needles.
const SNAP: f64 = 0.05;
/// Most vertices that are made to follow an isoline.
const MOST_VERTICES: usize = 2_000_000;
/// Edges that a straight piece of a line may cross.
const MOST_CROSSINGS: usize = 100_000;

impl SplitMesh {
    /// Inserts vertices where a function of the vertices is 0, on the edges of faces with one label; returns the
    /// function at all vertices, old and new.
    ///
    /// Afterwards no face of that label has corners of both signs.
    pub fn cut_isoline(&mut self, label: u32, mut value: Vec<f64>) -> Vec<f64> {
        let sides: Vec<u32> = (0..self.faces().len())
            .filter(|&f| self.labels()[f] == label)
            .flat_map(|f| [0, 1, 2].map(|k| 3 * f as u32 + k))
            .collect();
        self.snap_to_vertices(&sides, &mut value);
        let crossed =
            |value: &[f64], (a, b): (u32, u32)| value[a as usize] * value[b as usize] < 0.0;
        // New sides join a new vertex, where the function is 0, to a corner: only old ones are crossed.
        let mut ends: Vec<(u32, u32)> =
            sides.iter().map(|&h| self.ends(h)).filter(|&e| crossed(&value, e)).collect();
        ends.iter_mut().for_each(|e| *e = (e.0.min(e.1), e.0.max(e.1)));
        ends.order_total();
        ends.dedup();
        for (a, b) in ends {
            let Some(side) = self.around(a).into_iter().find(|&h| self.ends(h).1 == b) else {
                continue;
            };
            let (u, v) = (value[a as usize], value[b as usize]);
            if self.split_side(side, u / (u - v)).is_some() {
                value.push(0.0);
            }
        }
        value
    }

    /// Halves the longest sides of faces that may hold a place where a function is 0, until they are at most `finest` side
    /// steps long; returns the function at all vertices. It grows by no more than 1 a side step of `side_step` mm.
    pub fn refined_about_zero(
        &mut self,
        function: &dyn Fn(DVec2) -> f64,
        (side_step, finest): (f64, f64),
    ) -> Vec<f64> {
        let mut values: Vec<f64> = self.uv().iter().map(|&at| function(at)).collect();
        let mut open: Vec<u32> = (0..self.faces().len() as u32).rev().collect();
        while let Some(face) = open.pop() {
            let sides = [3 * face, 3 * face + 1, 3 * face + 2];
            let longest = sides.into_iter().fold(sides[0], |best, side| {
                if self.length(side) > self.length(best) { side } else { best }
            });
            let long = self.length(longest) / side_step;
            let corners = self.faces()[face as usize].map(|v| values[v as usize]);
            let least = corners.iter().map(|v| v.abs()).fold(f64::INFINITY, f64::min);
            if long <= finest || least > long || values.len() >= MOST_VERTICES {
                continue;
            }
            let other = self.opposite(longest).map(|side| side / 3);
            let count = self.faces().len() as u32;
            let Some(middle) = self.split_side(longest, 0.5) else { continue };
            values.push(function(self.uv()[middle as usize]));
            open.extend(other);
            open.push(face);
            open.extend(count..self.faces().len() as u32);
        }
        values
    }

    /// Sets the function to 0 at the vertices that its isoline passes very closely.
    fn snap_to_vertices(&self, sides: &[u32], value: &mut [f64]) {
        for &side in sides {
            let (a, b) = self.ends(side);
            let (u, v) = (value[a as usize], value[b as usize]);
            if u * v >= 0.0 {
                continue;
            }
            let t = u / (u - v);
            if t < SNAP {
                value[a as usize] = 0.0;
            } else if t > 1.0 - SNAP {
                value[b as usize] = 0.0;
            }
        }
    }

    /// Cuts along a polyline of flat points; `locator` is over the chart that the split mesh was made of.
    ///
    /// Ends beyond the boundary are pulled back to it.
    pub fn cut_polyline(&mut self, line: &[DVec2], locator: &Locator) {
        let line = inside(line, locator);
        let mut last = None;
        for p in line {
            let Some(here) = self.vertex_at(p, locator) else { continue };
            if let Some(before) = last {
                self.run(before, here);
            }
            last = Some(here);
        }
    }

    /// The vertex at a flat point, a new one if there is none.
    fn vertex_at(&mut self, p: DVec2, locator: &Locator) -> Option<u32> {
        let parent: FaceId = locator.locate(p).ok()?.face;
        let rated = self.parts(parent).map(|f| (f, self.weights(f, p)));
        let least = |w: &[f64; 3]| w.iter().copied().fold(f64::INFINITY, f64::min);
        let (face, weights) = rated.max_by(|a, b| least(&a.1).total_cmp(&least(&b.1)))?;
        let corner = |k: usize| self.faces()[face as usize][k % 3];
        let small: Vec<usize> = (0..3).filter(|&k| weights[k] < SNAP).collect();
        match small[..] {
            [] => self.split_face(face, weights),
            // Opposite to corner k lies the side that leaves corner k + 1.
            [k] => {
                let (u, v) = (weights[(k + 1) % 3].max(0.0), weights[(k + 2) % 3].max(0.0));
                let side = 3 * face + ((k as u32 + 1) % 3);
                self.split_side(side, v / (u + v))
            }
            _ => (0..3).max_by(|&i, &j| weights[i].total_cmp(&weights[j])).map(corner),
        }
    }

    /// Barycentric coordinates of a flat point in a face.
    fn weights(&self, face: u32, p: DVec2) -> [f64; 3] {
        let [a, b, c] = self.faces()[face as usize].map(|v| self.uv()[v as usize]);
        let whole = cross2(a, b, c);
        [cross2(p, b, c) / whole, cross2(a, p, c) / whole, cross2(a, b, p) / whole]
    }

    /// Runs a line straight from one vertex to another.
    fn run(&mut self, from: u32, to: u32) {
        let mut at = from;
        for _ in 0..MOST_CROSSINGS {
            if at == to {
                return;
            }
            let Some(step) = self.step(at, to) else { return };
            self.add_line(at, step);
            at = step;
        }
    }

    /// The next vertex on the line, inserted where the line crosses an edge if need be.
    fn step(&mut self, at: u32, to: u32) -> Option<u32> {
        let fan = self.around(at);
        let corners = |h: u32| (self.ends(h).1, self.ends(previous(h)).0);
        if fan.iter().any(|&h| corners(h).0 == to || corners(h).1 == to) {
            return Some(to);
        }
        let (here, there) = (self.uv()[at as usize], self.uv()[to as usize]);
        for h in fan {
            let (p, q) = corners(h);
            let (u, v) = (
                cross2(here, there, self.uv()[p as usize]),
                cross2(here, there, self.uv()[q as usize]),
            );
            // The way lies between p on its right and q on its left.
            if u <= 0.0 && v >= 0.0 && v > u {
                let t = u / (u - v);
                let crossing = self.uv()[p as usize].lerp(self.uv()[q as usize], t);
                if (crossing - here).dot(there - here) <= 0.0 {
                    continue;
                }
                return match t {
                    _ if t < SNAP => Some(p),
                    _ if t > 1.0 - SNAP => Some(q),
                    _ => self.split_side(next(h), t),
                };
            }
        }
        None
    }
}

/// The part of a line inside the chart.
fn inside(line: &[DVec2], locator: &Locator) -> Vec<DVec2> {
    let mut points: Vec<DVec2> = Vec::with_capacity(line.len());
    let is_inside = |p: DVec2| locator.locate(p).is_ok();
    for w in line.windows(2) {
        let (a, b) = (w[0], w[1]);
        match (is_inside(a), is_inside(b)) {
            (true, true) => points.extend([a, b]),
            (true, false) => points.extend([Some(a), edge(a, b, locator)].into_iter().flatten()),
            (false, true) => points.extend([edge(b, a, locator), Some(b)].into_iter().flatten()),
            (false, false) => {}
        }
    }
    points.dedup();
    points
}

/// Where the line from a point inside to one outside leaves the chart.
fn edge(inner: DVec2, outer: DVec2, locator: &Locator) -> Option<DVec2> {
    let start = locator.locate(inner).ok()?;
    locator.walk(start.face, inner, outer, |_, _| {}).err().map(|outside| outside.uv)
}

#[cfg(test)]
mod tests {
    use super::super::split_mesh::samples::{BUMP, middle};
    use super::*;
    use crate::geometry::math::{cos, sin};

    /// Every side of the split mesh on which the function changes its sign has a vertex at 0 now.
    #[test]
    fn an_isoline_runs_along_sides() {
        let (surface, chart) = &*BUMP;
        let mut split_mesh = SplitMesh::new(surface, chart);
        let circle = |p: &DVec2| p.distance(middle()) - 9.03;
        let value = split_mesh.cut_isoline(0, chart.uv().iter().map(circle).collect());
        split_mesh.validate(surface);
        assert_eq!(value.len(), split_mesh.uv().len());
        let signs = |f: &[u32; 3]| f.map(|v| value[v as usize]);
        let mixed = |v: [f64; 3]| v.iter().any(|&x| x > 0.0) && v.iter().any(|&x| x < 0.0);
        assert!(!split_mesh.faces().iter().any(|f| mixed(signs(f))));
        let all: Vec<u32> = (0..split_mesh.faces().len() as u32).collect();
        let inside =
            |f: u32| u32::from(signs(&split_mesh.faces()[f as usize]).iter().sum::<f64>() > 0.0);
        assert_eq!(split_mesh.groups(&all, inside, 0.0).len(), 2);
    }

    /// Two lines through the middle make four pieces, however they lie to the mesh.
    #[test]
    fn crossing_lines_make_four_pieces() {
        let (surface, chart) = &*BUMP;
        let locator = chart.locator(surface);
        for turn in [0.0, 0.1, 0.37, core::f64::consts::FRAC_PI_4] {
            let way = DVec2::new(cos(turn), sin(turn)) * 100.0;
            let mut split_mesh = SplitMesh::new(surface, chart);
            for way in [way, way.perp()] {
                let line: Vec<DVec2> =
                    (0..=200).map(|i| middle() + way * (f64::from(i) / 100.0 - 1.0)).collect();
                split_mesh.cut_polyline(&line, &locator);
            }
            split_mesh.improve();
            split_mesh.validate(surface);
            let all: Vec<u32> = (0..split_mesh.faces().len() as u32).collect();
            let pieces = split_mesh.groups(&all, |_| 0, 0.0);
            assert_eq!(pieces.len(), 4, "turned by {turn}");
            for faces in &pieces {
                let piece = split_mesh.piece(faces).unwrap();
                assert_eq!(piece.connectivity.euler_characteristic(), 1);
                assert!((piece.area(&split_mesh) / surface.area() - 0.25).abs() < 0.01);
            }
        }
    }

    /// A line that ends inside does not part anything.
    #[test]
    fn a_line_without_end_on_the_boundary_parts_nothing() {
        let (surface, chart) = &*BUMP;
        let locator = chart.locator(surface);
        let mut split_mesh = SplitMesh::new(surface, chart);
        let line = [DVec2::new(-100.0, 3.0), DVec2::new(2.0, 3.3)].map(|p| middle() + p);
        split_mesh.cut_polyline(&line, &locator);
        split_mesh.validate(surface);
        let all: Vec<u32> = (0..split_mesh.faces().len() as u32).collect();
        assert_eq!(split_mesh.groups(&all, |_| 0, 0.0).len(), 1);
    }
}
