//! The surface as a metric: edge lengths and corner cotangents, flipped to intrinsic Delaunay.
//!
//! On an intrinsic Delaunay triangulation every edge's cotangent weight is non-negative, however
//! obtuse the faces of the mesh are (Bobenko and Springborn 2007; Fisher et al. 2007).

use super::disk::Disk;
use super::error::FlattenError;
use crate::geometry::OrderBy;
use crate::geometry::math::atan2;
use crate::mesh::FaceId;

const NONE: u32 = u32::MAX;
/// An edge is flipped when its cotangents sum to less than minus this part of their sizes; less
/// would flip edges of cocircular faces to and fro.
const FLIP_MARGIN: f64 = 1e-10;
/// Flips allowed per edge; far above what meshes need, it bounds the time on degenerate ones.
const FLIPS_PER_EDGE: usize = 32;

/// Edge lengths and cotangents of a triangulation that may differ from the mesh's.
pub(super) struct IntrinsicTriangulation {
    /// Start vertex of every side.
    tail: Vec<u32>,
    opposite: Vec<u32>,
    length: Vec<f64>,
    /// Cotangent of the angle opposite each side.
    cotangent: Vec<f64>,
}

/// Angles of the faces of `disk`, `#F` by 3, and its triangulation as it stands.
pub(super) fn measure(
    disk: &Disk,
) -> Result<(Vec<[f64; 3]>, IntrinsicTriangulation), FlattenError> {
    let faces = disk.connectivity.faces();
    let sides = 3 * faces.len();
    let mut angles = Vec::with_capacity(faces.len());
    let mut metric = IntrinsicTriangulation {
        tail: Vec::with_capacity(sides),
        opposite: Vec::with_capacity(sides),
        length: Vec::with_capacity(sides),
        cotangent: Vec::with_capacity(sides),
    };
    for (f, face) in faces.iter().enumerate() {
        let p = face.map(|v| disk.positions[v.index()]);
        let edge = [p[1] - p[0], p[2] - p[1], p[0] - p[2]];
        let double_area = edge[0].cross(edge[1]).length();
        if !(double_area > 0.0 && double_area < f64::INFINITY) {
            return Err(FlattenError::Degenerate { face: f as u32, at: p[0] });
        }
        // The corner opposite side c is c + 2, between sides c + 1 and c + 2.
        let dot = [0, 1, 2].map(|c| -edge[(c + 1) % 3].dot(edge[(c + 2) % 3]));
        angles.push([1, 2, 0].map(|side| atan2(double_area, dot[side])));
        for c in 0..3 {
            let side = FaceId(f as u32).half_edge(c);
            metric.tail.push(face[c].0);
            metric.opposite.push(disk.connectivity.opposite(side).map_or(NONE, |o| o.0));
            metric.length.push(edge[c].length());
            metric.cotangent.push(dot[c] / double_area);
        }
    }
    Ok((angles, metric))
}

fn next(h: usize) -> usize {
    if h % 3 == 2 { h - 2 } else { h + 1 }
}

fn prev(h: usize) -> usize {
    if h.is_multiple_of(3) { h + 2 } else { h - 1 }
}

impl IntrinsicTriangulation {
    /// Flips edges until every cotangent weight is non-negative.
    pub fn flip_to_delaunay(&mut self) {
        let mut open: Vec<u32> = (0..self.tail.len() as u32)
            .filter(|&h| h < self.opposite[h as usize] && self.is_flippable(h as usize))
            .collect();
        let mut budget = FLIPS_PER_EDGE * self.tail.len();
        while let Some(h) = open.pop() {
            let h = h as usize;
            if budget == 0 || !self.is_flippable(h) {
                continue;
            }
            budget -= 1;
            let o = self.opposite[h] as usize;
            if self.flip(h, o) {
                open.extend([next(h), prev(h), next(o), prev(o)].map(|h| h as u32));
            }
        }
    }

    fn is_flippable(&self, h: usize) -> bool {
        let o = self.opposite[h];
        if o == NONE || o as usize / 3 == h / 3 {
            return false;
        }
        let (a, b) = (self.cotangent[h], self.cotangent[o as usize]);
        a + b < -FLIP_MARGIN * (1.0 + a.abs() + b.abs())
    }

    /// Replaces side `h` (and `o`, its other half) by the other diagonal of the two faces.
    ///
    /// Returns false, changing nothing, when rounding leaves a new face without area.
    fn flip(&mut self, h: usize, o: usize) -> bool {
        // h: a -> b with c opposite; o: b -> a with d opposite.
        let (bc, ca, ad, db) = (next(h), prev(h), next(o), prev(o));
        let base = self.length[h];
        let apex = |along: f64, across: f64| {
            let x = (base * base + along * along - across * across) / (2.0 * base);
            (x, double_area([base, along, across]) / base)
        };
        let (cx, cy) = apex(self.length[ca], self.length[bc]);
        let (dx, dy) = apex(self.length[ad], self.length[db]);
        let diagonal = ((cx - dx) * (cx - dx) + (cy + dy) * (cy + dy)).sqrt();
        let first = [diagonal, self.length[ca], self.length[ad]];
        let second = [diagonal, self.length[db], self.length[bc]];
        if !(double_area(first) > 0.0 && double_area(second) > 0.0) {
            return false;
        }
        let (c, d) = (self.tail[ca], self.tail[db]);
        let outer = [ca, ad, db, bc].map(|s| (self.tail[s], self.opposite[s]));
        self.set_side(h, d, diagonal);
        self.set_side(o, c, diagonal);
        let slots = [next(h), prev(h), next(o), prev(o)];
        let lengths = [first[1], first[2], second[1], second[2]];
        // Two of the outer sides may be halves of one edge: map their old slots to the new ones.
        let moved = |old: u32| match old as usize {
            s if s == ca => slots[0] as u32,
            s if s == ad => slots[1] as u32,
            s if s == db => slots[2] as u32,
            s if s == bc => slots[3] as u32,
            _ => old,
        };
        for i in 0..4 {
            let (tail, opposite) = outer[i];
            self.set_side(slots[i], tail, lengths[i]);
            self.opposite[slots[i]] = if opposite == NONE { NONE } else { moved(opposite) };
            if opposite != NONE {
                self.opposite[moved(opposite) as usize] = slots[i] as u32;
            }
        }
        self.update_cotangents(h);
        self.update_cotangents(o);
        true
    }

    fn set_side(&mut self, side: usize, tail: u32, length: f64) {
        self.tail[side] = tail;
        self.length[side] = length;
    }

    fn update_cotangents(&mut self, h: usize) {
        let sides = [h, next(h), prev(h)];
        let l = sides.map(|s| self.length[s]);
        let double_area = double_area(l);
        for i in 0..3 {
            let (a, b, c) = (l[i], l[(i + 1) % 3], l[(i + 2) % 3]);
            self.cotangent[sides[i]] = (b * b + c * c - a * a) / (2.0 * double_area);
        }
    }

    /// `(start, end, cotangent weight)` of every edge, one at a time.
    pub fn weights(&self) -> Vec<(u32, u32, f64)> {
        edge_weights(&self.tail, &self.opposite, &self.cotangent)
    }
}

/// Half the cotangents opposite each edge, with the edge's ends.
fn edge_weights(tail: &[u32], opposite: &[u32], cotangent: &[f64]) -> Vec<(u32, u32, f64)> {
    let mut weights = Vec::with_capacity(tail.len() / 2 + tail.len() / 16);
    for h in 0..tail.len() {
        let ends = (tail[h], tail[next(h)]);
        match opposite[h] {
            NONE => weights.push((ends.0, ends.1, 0.5 * cotangent[h])),
            o if (h as u32) < o => {
                weights.push((ends.0, ends.1, 0.5 * (cotangent[h] + cotangent[o as usize])));
            }
            _ => {}
        }
    }
    weights
}

/// Cotangent weights of the edges of `disk` whose faces have the given angles, `#F` by 3.
pub(super) fn weights_from_angles(disk: &Disk, angles: &[[f64; 3]]) -> Vec<(u32, u32, f64)> {
    let faces = disk.connectivity.faces();
    let tail: Vec<u32> = faces.iter().flatten().map(|v| v.0).collect();
    let opposite: Vec<u32> = (0..tail.len() as u32)
        .map(|h| disk.connectivity.opposite(crate::mesh::HalfEdgeId(h)).map_or(NONE, |o| o.0))
        .collect();
    let cotangent: Vec<f64> = angles
        .iter()
        .flat_map(|a| [a[2], a[0], a[1]])
        .map(|angle| crate::geometry::math::cos(angle) / crate::geometry::math::sin(angle))
        .collect();
    edge_weights(&tail, &opposite, &cotangent)
}

/// Twice the area of a triangle from its side lengths, stable for needles; 0 if they do not close.
///
/// # Source
/// Kahan, "Miscalculating area and angles of a needle-like triangle", 2014.
fn double_area(mut l: [f64; 3]) -> f64 {
    l.order_total_by(|a, b| b.total_cmp(a));
    let [a, b, c] = l;
    let product = (a + (b + c)) * (c - (a - b)) * (c + (a - b)) * (a + (b - c));
    if product > 0.0 { 0.5 * product.sqrt() } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::flatten::samples;

    #[test]
    fn needle_area() {
        let double = double_area([1.0, 1.0, 1e-9]);
        assert!((double / 1e-9 - 1.0).abs() < 1e-12);
        assert_eq!(double_area([3.0, 1.0, 1.0]), 0.0);
    }

    #[test]
    fn flipping_makes_every_weight_non_negative_and_keeps_linear_functions_harmonic() {
        let surface = samples::sheared_plane(12, 5.0);
        let disk = Disk::new(&surface).unwrap();
        let (_, mut metric) = measure(&disk).unwrap();
        let obtuse =
            |m: &IntrinsicTriangulation| m.weights().iter().filter(|w| w.2 < -1e-9).count();
        assert!(obtuse(&metric) > 50);
        metric.flip_to_delaunay();
        let boundary = |v: u32| disk.connectivity.is_boundary(crate::mesh::VertexId(v));
        let mut flux = vec![0.0; surface.positions().len()];
        for (a, b, w) in metric.weights() {
            assert!(w >= -1e-9 || (boundary(a) && boundary(b)));
            let step = surface.positions()[b as usize].x - surface.positions()[a as usize].x;
            flux[a as usize] += w * step;
            flux[b as usize] -= w * step;
        }
        for v in (0..flux.len()).filter(|&v| !boundary(v as u32)) {
            assert!(flux[v].abs() < 1e-9, "vertex {v}: {}", flux[v]);
        }
    }
}
