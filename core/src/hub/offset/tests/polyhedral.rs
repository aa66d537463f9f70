//! Shortest distances on triangles from one of their vertices, exactly, by straight lines through triangles laid flat.
//!
//! - *Window*: a piece of a side that is seen from the source through a row of triangles; the source is where it lies in the plane
//!   of the triangle beyond.
//!
//! A window is carried over the triangle beyond to its other two sides, where the third corner parts it. None is left out,
//! though others be nearer: on a patch a few millimetres wide they are some hundred thousand. What is hidden behind a saddle
//! vertex, which is a wedge of less than a thousandth of a millimetre here, is seen by no window; ways around the vertex are
//! left out.
//!
//! Source: windows of Mitchell, Mount, Papadimitriou, "The discrete geodesic problem", SIAM J. Comput. 16 (1987).

use crate::geometry::{DVec2, DVec3};
use std::collections::BTreeMap;

/// A place on a triangle: its number, and the parts of its corners.
pub struct Target {
    pub face: usize,
    pub parts: [f64; 3],
}

/// A window on the side from corner `a` to `b` of the face beyond; the side runs along x from 0, the face lies above.
struct Window {
    face: usize,
    a: u32,
    b: u32,
    source: DVec2,
    seen: [f64; 2],
}

pub struct Triangles<'a> {
    pub positions: &'a [DVec3],
    pub faces: &'a [[u32; 3]],
}

impl Triangles<'_> {
    fn length(&self, a: u32, b: u32) -> f64 {
        self.positions[a as usize].distance(self.positions[b as usize])
    }

    /// Distances of the targets from a vertex that are at most `reach`; others are infinite.
    pub fn distances(&self, source: u32, targets: &[Target], reach: f64) -> Vec<f64> {
        let mut beyond: BTreeMap<(u32, u32), usize> = BTreeMap::new();
        for (i, &[a, b, c]) in self.faces.iter().enumerate() {
            beyond.extend([((a, b), i), ((b, c), i), ((c, a), i)]);
        }
        let mut of_face: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
        for (i, target) in targets.iter().enumerate() {
            of_face.entry(target.face).or_default().push(i);
        }
        let mut found = vec![f64::INFINITY; targets.len()];
        let mut open: Vec<Window> = Vec::new();
        // The side from p to q of a face, seen from the face on its other side.
        let across = |p: (u32, DVec2), q: (u32, DVec2), source: DVec2, seen: [DVec2; 2]| {
            let face = *beyond.get(&(p.0, q.0))?;
            let way = (q.1 - p.1).normalize();
            let off = source - p.1;
            let source = DVec2::new(way.dot(off), way.perp_dot(off));
            let seen = seen.map(|x| way.dot(x - p.1));
            (seen[1] > seen[0]).then_some(Window { face, a: p.0, b: q.0, source, seen })
        };
        for face in self.faces.iter().filter(|f| f.contains(&source)) {
            let k = face.iter().position(|v| *v == source).unwrap();
            let [p, q] = [face[(k + 1) % 3], face[(k + 2) % 3]];
            // Laid flat with the side from q to p along x.
            let (length, apex) = (self.length(q, p), self.apex(q, p, source));
            let (q, p) = ((q, DVec2::ZERO), (p, DVec2::new(length, 0.0)));
            let apex = DVec2::new(apex.x, -apex.y);
            open.extend(across(q, p, apex, [q.1, p.1]));
        }
        while let Some(Window { face, a, b, source, seen }) = open.pop() {
            let corners = self.faces[face];
            let c = corners.into_iter().find(|v| *v != a && *v != b).unwrap();
            let place = |v: u32| match v {
                v if v == a => DVec2::ZERO,
                v if v == b => DVec2::new(self.length(a, b), 0.0),
                _ => self.apex(a, b, c),
            };
            // Where the line from the source to a place passes the side.
            let passes = |p: DVec2| source.x + (p.x - source.x) * source.y / (source.y - p.y);
            for &i in of_face.get(&face).into_iter().flatten() {
                let parts = targets[i].parts.iter().zip(corners);
                let at: DVec2 = parts.map(|(part, v)| place(v) * *part).sum();
                if (seen[0]..=seen[1]).contains(&passes(at)) {
                    found[i] = found[i].min(at.distance(source));
                }
            }
            let [pa, pb, pc] = [a, b, c].map(place);
            let middle = passes(pc).clamp(seen[0], seen[1]);
            // The place of a line between two others that is seen through x.
            let seen_at = |x: f64, p: DVec2, q: DVec2| {
                let way = DVec2::new(x, 0.0) - source;
                p.lerp(q, way.perp_dot(source - p) / way.perp_dot(q - p))
            };
            for (from, to, [low, high]) in
                [((a, pa), (c, pc), [seen[0], middle]), ((c, pc), (b, pb), [middle, seen[1]])]
            {
                if high - low < 1e-12 {
                    continue;
                }
                let ends = [low, high].map(|x| seen_at(x, from.1, to.1));
                let way = ends[1] - ends[0];
                let part = (source - ends[0]).dot(way) / way.length_squared();
                if source.distance(ends[0].lerp(ends[1], part.clamp(0.0, 1.0))) <= reach {
                    open.extend(across(from, to, source, ends));
                }
            }
        }
        found
    }

    /// The third corner of a triangle whose side from `a` to `b` runs along x from 0, above it.
    fn apex(&self, a: u32, b: u32, c: u32) -> DVec2 {
        let (ab, ac, bc) = (self.length(a, b), self.length(a, c), self.length(b, c));
        let x = (ab * ab + ac * ac - bc * bc) / (2.0 * ab);
        DVec2::new(x, (ac * ac - x * x).max(0.0).sqrt())
    }
}
