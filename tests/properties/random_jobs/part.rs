//! The part: facets with the normals that a smooth surface would have, random places on them, and its edges.

use crate::random::Random;
use evencut_core::geometry::DVec3;
use evencut_core::surface::Part;
use std::collections::HashMap;

/// Facets that meet at more than this angle (40 degrees; its cosine) share no normal.
const CREASE: f64 = 0.766;
/// Corners nearer than this are one, mm.
const SAME: f64 = 1e-5;

/// A place on the part.
#[derive(Copy, Clone, Debug)]
pub struct Place {
    /// Where, mm.
    pub at: DVec3,
    /// Unit normal, interpolated over the facet.
    pub normal: DVec3,
}

/// Facets of one side of the part: what is machined, or the rest.
pub struct Mesh {
    /// Corners of the facets, mm.
    pub faces: Vec<[DVec3; 3]>,
    /// Normals at the corners.
    pub normals: Vec<[DVec3; 3]>,
    /// Area up to and with each facet, mm².
    sums: Vec<f64>,
    cells: HashMap<[i64; 3], Vec<u32>>,
    cell: f64,
}

/// An edge of the machined surface with nothing machined behind it.
#[derive(Copy, Clone, Debug)]
pub struct Rim {
    /// Its ends, mm, with the surface on the left.
    pub ends: [DVec3; 2],
    /// Unit normals there: each facet counts with its area.
    pub normals: [DVec3; 2],
    /// The same, each facet with its angle.
    pub by_angle: [DVec3; 2],
    /// Unit normal of the facet.
    pub facet: DVec3,
}

impl Rim {
    /// Distance of a point, mm.
    pub fn distance(&self, p: DVec3) -> f64 {
        let [a, b] = self.ends;
        let t = (p - a).dot(b - a) / (b - a).length_squared();
        a.lerp(b, t.clamp(0.0, 1.0)).distance(p)
    }
}

/// Normal of a triangle, twice as long as its area.
pub fn doubled([a, b, c]: [DVec3; 3]) -> DVec3 {
    (b - a).cross(c - a)
}

/// A corner's name.
pub fn key(p: DVec3) -> [i64; 3] {
    (p / SAME).to_array().map(|x| x.round() as i64)
}

/// The point of a triangle nearest to a point, as weights of its corners (Ericson, "Real-Time Collision
/// Detection", 2004, 5.1.5).
pub fn nearest_weights([a, b, c]: [DVec3; 3], p: DVec3) -> [f64; 3] {
    let (ab, ac, ap) = (b - a, c - a, p - a);
    let (d1, d2) = (ab.dot(ap), ac.dot(ap));
    if d1 <= 0.0 && d2 <= 0.0 {
        return [1.0, 0.0, 0.0];
    }
    let bp = p - b;
    let (d3, d4) = (ab.dot(bp), ac.dot(bp));
    if d3 >= 0.0 && d4 <= d3 {
        return [0.0, 1.0, 0.0];
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        let v = d1 / (d1 - d3);
        return [1.0 - v, v, 0.0];
    }
    let cp = p - c;
    let (d5, d6) = (ab.dot(cp), ac.dot(cp));
    if d6 >= 0.0 && d5 <= d6 {
        return [0.0, 0.0, 1.0];
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        let w = d2 / (d2 - d6);
        return [1.0 - w, 0.0, w];
    }
    let va = d3 * d6 - d5 * d4;
    if va <= 0.0 && d4 >= d3 && d5 >= d6 {
        let w = (d4 - d3) / ((d4 - d3) + (d5 - d6));
        return [0.0, 1.0 - w, w];
    }
    let sum = va + vb + vc;
    [1.0 - vb / sum - vc / sum, vb / sum, vc / sum]
}

fn mixed(corners: &[DVec3; 3], [u, v, w]: [f64; 3]) -> DVec3 {
    corners[0] * u + corners[1] * v + corners[2] * w
}

impl Mesh {
    /// From a part of the public library; facets without area are left out.
    pub fn new(part: &Part) -> Self {
        let corners = |f: &[u32; 3]| f.map(|v| part.positions[v as usize]);
        let all: Vec<[DVec3; 3]> = part.faces.iter().map(corners).collect();
        Self::of(all.into_iter().filter(|f| doubled(*f).length() > 0.0).collect())
    }

    /// From triangles; corners at the same place are one.
    pub fn of(faces: Vec<[DVec3; 3]>) -> Self {
        let mut around: HashMap<[i64; 3], Vec<usize>> = HashMap::new();
        for (f, face) in faces.iter().enumerate() {
            face.iter().for_each(|p| around.entry(key(*p)).or_default().push(f));
        }
        let normal = |f: usize, p: DVec3| {
            let own = doubled(faces[f]);
            let smooth = |g: &&usize| {
                let other = doubled(faces[**g]);
                other.dot(own) > CREASE * other.length() * own.length()
            };
            let sum: DVec3 =
                around[&key(p)].iter().filter(smooth).map(|&g| doubled(faces[g])).sum();
            sum.normalize_or(own.normalize())
        };
        let normals =
            faces.iter().enumerate().map(|(f, face)| face.map(|p| normal(f, p))).collect();
        let mut sum = 0.0;
        let area = |f: &[DVec3; 3]| {
            sum += 0.5 * doubled(*f).length();
            sum
        };
        let sums: Vec<f64> = faces.iter().map(area).collect();
        let mean = (sums.last().copied().unwrap_or(0.0) / faces.len().max(1) as f64).sqrt();
        let cell = (3.0 * mean).max(1e-3);
        let mut cells: HashMap<[i64; 3], Vec<u32>> = HashMap::new();
        for (f, face) in faces.iter().enumerate() {
            let low = face[0].min(face[1]).min(face[2]) / cell;
            let high = face[0].max(face[1]).max(face[2]) / cell;
            let [low, high] = [low, high].map(|p| p.to_array().map(|x| x.floor() as i64));
            for x in low[0]..=high[0] {
                for y in low[1]..=high[1] {
                    for z in low[2]..=high[2] {
                        cells.entry([x, y, z]).or_default().push(f as u32);
                    }
                }
            }
        }
        Self { faces, normals, sums, cells, cell }
    }

    /// Area, mm².
    pub fn area(&self) -> f64 {
        self.sums.last().copied().unwrap_or(0.0)
    }

    /// The place on a facet with these weights of its corners.
    pub fn place(&self, face: usize, weights: [f64; 3]) -> Place {
        let normal = mixed(&self.normals[face], weights).normalize_or(self.normals[face][0]);
        Place { at: mixed(&self.faces[face], weights), normal }
    }

    /// A random place; every area is as likely.
    pub fn random(&self, random: &mut Random) -> Place {
        let at = random.unit() * self.area();
        let face = self.sums.partition_point(|s| *s < at).min(self.faces.len() - 1);
        let (mut u, mut v) = (random.unit(), random.unit());
        if u + v > 1.0 {
            (u, v) = (1.0 - u, 1.0 - v);
        }
        self.place(face, [1.0 - u - v, u, v])
    }

    /// A random place about that far from another.
    pub fn beside(&self, place: &Place, radius: f64, random: &mut Random) -> Option<Place> {
        let mut coordinate = || random.between(-radius, radius);
        let way = DVec3::new(coordinate(), coordinate(), coordinate());
        let way = way - place.normal * way.dot(place.normal);
        self.nearest(place.at + way, 2.0 * radius)
    }

    /// The place nearest to a point, if one is within `reach`.
    pub fn nearest(&self, p: DVec3, reach: f64) -> Option<Place> {
        let mut best: Option<(f64, usize, [f64; 3])> = None;
        for face in self.within(p, reach) {
            let weights = nearest_weights(self.faces[face], p);
            let far = mixed(&self.faces[face], weights).distance(p);
            if far <= reach && best.is_none_or(|b| far < b.0) {
                best = Some((far, face, weights));
            }
        }
        best.map(|(_, face, weights)| self.place(face, weights))
    }

    /// Facets whose box may come within `reach` of a point; some twice.
    pub fn within(&self, p: DVec3, reach: f64) -> Vec<usize> {
        let index = |q: DVec3| (q / self.cell).to_array().map(|x| x.floor() as i64);
        let (low, high) = (index(p - DVec3::splat(reach)), index(p + DVec3::splat(reach)));
        let mut out = Vec::new();
        for x in low[0]..=high[0] {
            for y in low[1]..=high[1] {
                for z in low[2]..=high[2] {
                    let cell = self.cells.get(&[x, y, z]);
                    out.extend(cell.into_iter().flatten().map(|&f| f as usize));
                }
            }
        }
        out
    }

    /// The edges with a facet on one side only.
    pub fn rims(&self) -> Vec<Rim> {
        let mut sides: HashMap<[[i64; 3]; 2], usize> = HashMap::new();
        let mut angles: HashMap<[i64; 3], DVec3> = HashMap::new();
        let edge = |a: DVec3, b: DVec3| {
            let (a, b) = (key(a), key(b));
            if a < b { [a, b] } else { [b, a] }
        };
        for face in &self.faces {
            let normal = doubled(*face).normalize();
            for k in 0..3 {
                let (a, b, c) = (face[k], face[(k + 1) % 3], face[(k + 2) % 3]);
                *sides.entry(edge(a, b)).or_default() += 1;
                let (x, y) = ((b - a).normalize(), (c - a).normalize());
                let angle = evencut_core::geometry::math::acos_clamped(x.dot(y));
                *angles.entry(key(a)).or_default() += normal * angle;
            }
        }
        let mut out = Vec::new();
        for (f, face) in self.faces.iter().enumerate() {
            for k in 0..3 {
                let next = (k + 1) % 3;
                let ends = [face[k], face[next]];
                if sides[&edge(ends[0], ends[1])] == 1 {
                    let facet = doubled(*face).normalize();
                    let by_angle = ends.map(|p| angles[&key(p)].normalize_or(facet));
                    let normals = [self.normals[f][k], self.normals[f][next]];
                    out.push(Rim { ends, normals, by_angle, facet });
                }
            }
        }
        out
    }
}

#[cfg(test)]
pub mod tests {
    use super::*;

    /// A sheet over `[-half, half]²`, `steps` squares a side.
    pub fn sheet(half: f64, steps: i32, height: impl Fn(f64, f64) -> f64) -> Vec<[DVec3; 3]> {
        let at = |i: i32, j: i32| {
            let place = |k: i32| half * (2.0 * f64::from(k) / f64::from(steps) - 1.0);
            DVec3::new(place(i), place(j), height(place(i), place(j)))
        };
        let square = |i: i32, j: i32| {
            let (a, b, c, d) = (at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
            [[a, b, c], [a, c, d]]
        };
        (0..steps).flat_map(|i| (0..steps).flat_map(move |j| square(i, j))).collect()
    }

    #[test]
    fn places_lie_on_the_sheet_and_rims_around_it() {
        let mesh = Mesh::of(sheet(2.0, 8, |_, _| 1.0));
        let mut random = Random::new(3);
        assert!((mesh.area() - 16.0).abs() < 1e-12);
        for _ in 0..100 {
            let place = mesh.random(&mut random);
            assert!((place.at.z - 1.0).abs() < 1e-12 && place.normal == DVec3::Z);
            let beside = mesh.beside(&place, 0.1, &mut random).unwrap();
            assert!(beside.at.distance(place.at) < 0.2);
        }
        let near = mesh.nearest(DVec3::new(2.5, 0.3, 1.0), 1.0).unwrap();
        assert!(near.at.distance(DVec3::new(2.0, 0.3, 1.0)) < 1e-12);
        let rims = mesh.rims();
        let length: f64 = rims.iter().map(|r| r.ends[0].distance(r.ends[1])).sum();
        assert!(rims.len() == 32 && (length - 16.0).abs() < 1e-12);
    }
}
