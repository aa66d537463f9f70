//! Triangles over a chart, into which lines can be inserted.
//!
//! - *Split mesh*: the faces of a surface, some of them divided into smaller ones that lie exactly on them;
//!   flat and spatial points of new vertices are the same means of the corners, so that neither the
//!   surface nor its map change.
//! - *Parent*: the face of the surface that contains a face of the split mesh.
//! - *Label*: the piece that a face belongs to.
//!
//! New vertices are inserted only on edges and into faces; both keep the mesh conforming.

use crate::flatten::Chart;
use crate::geometry::{DVec2, DVec3, cross2};
use crate::mesh::{FaceId, HalfEdgeId, VertexId};
use crate::surface::Surface;
use std::collections::{BTreeMap, BTreeSet};

/// No side, no vertex.
pub(super) const NONE: u32 = u32::MAX;
/// Mean number of flips per edge after which the improvement of the triangles is given up.
const FLIPS: usize = 10;

/// A mean of at most three vertices of the surface: vertex and weight, the rest with weight 0.
pub type Mean = [(u32, f64); 3];

/// The mean of two means, a fraction `t` from `a` to `b`; `None` when they have more than three vertices.
fn between(a: &Mean, b: &Mean, t: f64) -> Option<Mean> {
    let mut out: Vec<(u32, f64)> = Vec::with_capacity(6);
    let parts = a.iter().map(|m| (m.0, m.1 * (1.0 - t))).chain(b.iter().map(|m| (m.0, m.1 * t)));
    for (vertex, weight) in parts.filter(|m| m.1 != 0.0) {
        match out.iter_mut().find(|m| m.0 == vertex) {
            Some(known) => known.1 += weight,
            None => out.push((vertex, weight)),
        }
    }
    let spare = (out.first()?.0, 0.0);
    (out.len() <= 3).then(|| core::array::from_fn(|i| out.get(i).copied().unwrap_or(spare)))
}

/// Triangles over a chart, with a label for each.
#[derive(Clone, Debug)]
pub struct SplitMesh {
    faces: Vec<[u32; 3]>,
    opposite: Vec<u32>,
    leaving: Vec<u32>,
    uv: Vec<DVec2>,
    positions: Vec<DVec3>,
    means: Vec<Mean>,
    /// Of vertices put on sides: the ends, and how far from the first.
    origins: Vec<Option<(u32, u32, f64)>>,
    parents: Vec<u32>,
    /// Further faces of a parent that was divided.
    children: BTreeMap<u32, Vec<u32>>,
    /// Sides that a line runs along, smaller vertex first.
    lines: BTreeSet<(u32, u32)>,
    labels: Vec<u32>,
}

impl SplitMesh {
    /// The faces of a surface and its chart, all with label 0.
    pub fn new(surface: &Surface, chart: &Chart) -> Self {
        let connectivity = surface.connectivity();
        let count = connectivity.face_count();
        let vertices = connectivity.vertex_count() as u32;
        let sides = (0..3 * count as u32).map(HalfEdgeId);
        let leaving = |v: u32| connectivity.leaving(VertexId(v)).map_or(NONE, |h| h.0);
        Self {
            faces: connectivity.faces().iter().map(|f| f.map(|v| v.0)).collect(),
            opposite: sides.map(|h| connectivity.opposite(h).map_or(NONE, |o| o.0)).collect(),
            leaving: (0..vertices).map(leaving).collect(),
            uv: chart.uv().to_vec(),
            positions: surface.positions().to_vec(),
            means: (0..vertices).map(|v| [(v, 1.0), (v, 0.0), (v, 0.0)]).collect(),
            origins: vec![None; vertices as usize],
            parents: (0..count as u32).collect(),
            children: BTreeMap::new(),
            lines: BTreeSet::new(),
            labels: vec![0; count],
        }
    }

    /// `#F` triples of vertices.
    pub fn faces(&self) -> &[[u32; 3]] {
        &self.faces
    }

    /// `#V` flat points.
    pub fn uv(&self) -> &[DVec2] {
        &self.uv
    }

    /// `#V` positions, mm.
    pub fn positions(&self) -> &[DVec3] {
        &self.positions
    }

    /// `#V` means of the surface's vertices.
    pub fn means(&self) -> &[Mean] {
        &self.means
    }

    /// `#F` faces of the surface.
    pub fn parents(&self) -> &[u32] {
        &self.parents
    }

    /// `#F` labels.
    pub fn labels(&self) -> &[u32] {
        &self.labels
    }

    /// Number of labels, which count from 0.
    pub fn pieces(&self) -> usize {
        self.labels.iter().max().map_or(0, |&l| l as usize + 1)
    }

    /// All faces with the label of one.
    pub fn labelled(&self, face: u32) -> Vec<u32> {
        let label = self.labels[face as usize];
        (0..self.faces.len() as u32).filter(|&f| self.labels[f as usize] == label).collect()
    }

    /// Labels some faces.
    pub fn set_label(&mut self, faces: &[u32], label: u32) {
        faces.iter().for_each(|&f| self.labels[f as usize] = label);
    }

    /// Appends the values of vertices that were inserted on edges later, linear along the edge; NaN for other new
    /// ones.
    pub fn extend(&self, values: &mut Vec<f64>) {
        for origin in &self.origins[values.len()..] {
            let of = |(a, b, t): (u32, u32, f64)| {
                values[a as usize] * (1.0 - t) + values[b as usize] * t
            };
            values.push(origin.map_or(f64::NAN, of));
        }
    }

    /// The same side of the neighbouring face; `None` on the boundary.
    pub fn opposite(&self, side: u32) -> Option<u32> {
        let o = self.opposite[side as usize];
        (o != NONE).then_some(o)
    }

    /// Start and end of a side.
    pub fn ends(&self, side: u32) -> (u32, u32) {
        let face = self.faces[side as usize / 3];
        (face[side as usize % 3], face[(side as usize + 1) % 3])
    }

    /// Area of a face on the surface, mm².
    pub fn area(&self, face: usize) -> f64 {
        let [a, b, c] = self.faces[face].map(|v| self.positions[v as usize]);
        0.5 * (b - a).cross(c - a).length()
    }

    /// Length of a side on the surface, mm.
    pub fn length(&self, side: u32) -> f64 {
        let (a, b) = self.ends(side);
        self.positions[a as usize].distance(self.positions[b as usize])
    }

    /// Whether a line runs along a side.
    pub fn has_line(&self, side: u32) -> bool {
        self.lines.contains(&sorted(self.ends(side)))
    }

    pub(super) fn add_line(&mut self, a: u32, b: u32) {
        self.lines.insert(sorted((a, b)));
    }

    /// The sides that leave a vertex, counter-clockwise, from the boundary one if there is one.
    pub fn around(&self, vertex: u32) -> Vec<u32> {
        let mut first = self.leaving[vertex as usize];
        if first == NONE {
            return Vec::new();
        }
        let begin = first;
        // Clockwise to the boundary.
        while let Some(before) = self.opposite(first) {
            first = next(before);
            if first == begin {
                break;
            }
        }
        let onward = |h: &u32| self.opposite(previous(*h)).filter(|n| *n != first);
        core::iter::successors(Some(first), onward).collect()
    }

    /// The faces that a face of the surface is divided into.
    pub fn parts(&self, parent: FaceId) -> impl Iterator<Item = u32> + '_ {
        let more = self.children.get(&parent.0).into_iter().flatten().copied();
        core::iter::once(parent.0).chain(more)
    }

    /// Inserts a vertex on an edge, a fraction `t` from its start, and joins it to the corners opposite.
    ///
    /// `None` when that is not possible, as on an edge that was not one of a single face.
    pub fn split_side(&mut self, side: u32, t: f64) -> Option<u32> {
        let (a, b) = self.ends(side);
        let mean = between(&self.means[a as usize], &self.means[b as usize], t)?;
        let m = self.push_vertex(a, b, t, mean);
        if self.lines.remove(&sorted((a, b))) {
            self.lines.extend([sorted((a, m)), sorted((m, b))]);
        }
        let there = self.opposite(side);
        let (first, second) = self.halve(side, m);
        match there {
            None => {
                self.opposite[first as usize] = NONE;
                self.opposite[second as usize] = NONE;
            }
            Some(there) => {
                let (back_first, back_second) = self.halve(there, m);
                self.join(first, back_second);
                self.join(second, back_first);
            }
        }
        // Around a boundary the fan is searched from any of its sides.
        self.leaving[m as usize] = second;
        Some(m)
    }

    /// Divides the face of a side at `m` on it; returns the halves of the side. The neighbours of the
    /// other sides are kept.
    fn halve(&mut self, side: u32, m: u32) -> (u32, u32) {
        let face = side / 3;
        let (a, b) = self.ends(side);
        let c = self.faces[face as usize][(side as usize + 2) % 3];
        let (bc, ca) = (self.opposite(next(side)), self.opposite(previous(side)));
        let other = self.push_face(face, [m, b, c]);
        self.faces[face as usize] = [a, m, c];
        self.join_if(3 * face + 2, ca);
        self.join_if(3 * other + 1, bc);
        self.join(3 * face + 1, 3 * other + 2);
        self.leaving[a as usize] = 3 * face;
        self.leaving[b as usize] = 3 * other + 1;
        self.leaving[c as usize] = 3 * face + 2;
        (3 * face, 3 * other)
    }

    /// Puts a vertex into a face and joins it to the corners.
    pub fn split_face(&mut self, face: u32, weights: [f64; 3]) -> Option<u32> {
        let [a, b, c] = self.faces[face as usize];
        let outer = weights[1] + weights[2];
        let side = between(&self.means[b as usize], &self.means[c as usize], weights[2] / outer)?;
        let mean = between(&self.means[a as usize], &side, outer)?;
        let m = self.push_vertex(a, a, 0.0, mean);
        let corners = [a, b, c].map(|v| v as usize);
        self.uv[m as usize] = (0..3).map(|i| self.uv[corners[i]] * weights[i]).sum();
        self.positions[m as usize] = (0..3).map(|i| self.positions[corners[i]] * weights[i]).sum();
        let sides = [0, 1, 2].map(|k| self.opposite(3 * face + k));
        let (second, third) = (self.push_face(face, [b, c, m]), self.push_face(face, [c, a, m]));
        self.faces[face as usize] = [a, b, m];
        for (f, o) in [face, second, third].into_iter().zip(sides) {
            self.join_if(3 * f, o);
        }
        self.join(3 * face + 1, 3 * second + 2);
        self.join(3 * second + 1, 3 * third + 2);
        self.join(3 * third + 1, 3 * face + 2);
        for (v, side) in [(a, face), (b, second), (c, third)] {
            self.leaving[v as usize] = 3 * side;
        }
        self.leaving[m as usize] = 3 * face + 2;
        Some(m)
    }

    /// Makes the triangles inside of every divided face as well-shaped as possible without moving a line or a border.
    pub fn improve(&mut self) {
        let divided: Vec<u32> = self
            .children
            .iter()
            .flat_map(|(p, list)| core::iter::once(*p).chain(list.clone()))
            .collect();
        let mut open: Vec<u32> =
            divided.iter().flat_map(|f| [3 * f, 3 * f + 1, 3 * f + 2]).collect();
        for _ in 0..FLIPS * open.len() {
            let Some(side) = open.pop() else { return };
            if self.is_better_flipped(side) {
                open.extend(self.flip(side));
            }
        }
    }

    /// Whether the other diagonal of the two faces of an edge is the Delaunay one, and allowed.
    fn is_better_flipped(&self, side: u32) -> bool {
        let Some(there) = self.opposite(side) else { return false };
        let (f, g) = (side as usize / 3, there as usize / 3);
        if self.parents[f] != self.parents[g]
            || self.labels[f] != self.labels[g]
            || self.has_line(side)
        {
            return false;
        }
        let (a, b) = self.ends(side);
        let (c, d) = (self.ends(previous(side)).0, self.ends(previous(there)).0);
        let [a, b, c, d] = [a, b, c, d].map(|v| self.uv[v as usize]);
        let whole = cross2(a, b, c) + cross2(b, a, d);
        // Both new faces must have an area to speak of.
        let is_convex = cross2(a, d, c).min(cross2(d, b, c)) > 1e-3 * whole;
        // Opposite angles that sum up to more than a half turn.
        let (at_c, at_d) = ((a - c, b - c), (b - d, a - d));
        let sine = at_c.0.perp_dot(at_c.1) * at_d.0.dot(at_d.1)
            + at_c.0.dot(at_c.1) * at_d.0.perp_dot(at_d.1);
        let size = at_c.0.length() * at_c.1.length() * at_d.0.length() * at_d.1.length();
        is_convex && sine < -1e-9 * size
    }

    /// Flips the diagonal; returns the four edges around it.
    fn flip(&mut self, side: u32) -> [u32; 4] {
        let Some(there) = self.opposite(side) else { return [side; 4] };
        let (f, g) = (side / 3, there / 3);
        let (a, b) = self.ends(side);
        let (c, d) = (self.ends(previous(side)).0, self.ends(previous(there)).0);
        let outer = [next(side), previous(side), next(there), previous(there)];
        let [bc, ca, ad, db] = outer.map(|h| self.opposite(h));
        self.faces[f as usize] = [a, d, c];
        self.faces[g as usize] = [d, b, c];
        self.join_if(3 * f, ad);
        self.join_if(3 * f + 2, ca);
        self.join_if(3 * g, db);
        self.join_if(3 * g + 1, bc);
        self.join(3 * f + 1, 3 * g + 2);
        for (v, side) in [(a, 3 * f), (d, 3 * g), (b, 3 * g + 1), (c, 3 * f + 2)] {
            self.leaving[v as usize] = side;
        }
        [3 * f, 3 * f + 2, 3 * g, 3 * g + 1]
    }

    fn push_vertex(&mut self, a: u32, b: u32, t: f64, mean: Mean) -> u32 {
        let m = self.uv.len() as u32;
        self.uv.push(self.uv[a as usize].lerp(self.uv[b as usize], t));
        self.positions.push(self.positions[a as usize].lerp(self.positions[b as usize], t));
        self.means.push(mean);
        self.origins.push((a != b).then_some((a, b, t)));
        self.leaving.push(NONE);
        m
    }

    /// A new face with label and parent of another one.
    fn push_face(&mut self, of: u32, corners: [u32; 3]) -> u32 {
        let face = self.faces.len() as u32;
        self.faces.push(corners);
        self.opposite.extend([NONE; 3]);
        let parent = self.parents[of as usize];
        self.parents.push(parent);
        self.children.entry(parent).or_default().push(face);
        self.labels.push(self.labels[of as usize]);
        face
    }

    fn join(&mut self, a: u32, b: u32) {
        self.opposite[a as usize] = b;
        self.opposite[b as usize] = a;
    }

    fn join_if(&mut self, a: u32, b: Option<u32>) {
        match b {
            Some(b) => self.join(a, b),
            None => self.opposite[a as usize] = NONE,
        }
    }
}

fn sorted((a, b): (u32, u32)) -> (u32, u32) {
    (a.min(b), a.max(b))
}

/// The next side of the same face.
pub(super) fn next(side: u32) -> u32 {
    if side % 3 == 2 { side - 2 } else { side + 1 }
}

/// The previous side of the same face.
pub(super) fn previous(side: u32) -> u32 {
    if side.is_multiple_of(3) { side + 2 } else { side - 1 }
}

#[cfg(test)]
pub(super) mod samples;
