//! Curvature on a mesh, by fitting a polynomial height field around every vertex.
//!
//! The neighbours of a vertex within a radius are written in a frame aligned with its normal, and
//! a height field of degree three (two, where there are too few neighbours) is fitted to them by
//! weighted least squares. Its first and second derivatives at the vertex give the shape operator
//! through both fundamental forms. The cubic terms make the estimate second-order accurate on
//! neighbourhoods without symmetry, above all along the boundary.
//!
//! # Source
//! Cazals and Pouget, "Estimating differential quantities using polynomial fitting of osculating
//! jets", CAGD 22 (2005).

use super::manifold::Surface;
use super::point::SurfacePoint;
use crate::geometry::shape::ShapeOperator;
use crate::geometry::{DVec3, any_perpendicular};
use crate::mesh::{HalfEdgeId, VertexId};
use nalgebra::{Matrix3, Vector3};

/// Default fit radius in mean edge lengths around the vertex. Smaller measures the tessellation
/// and, along the boundary, sees too few rows for the cubic terms; larger blurs the shape.
const RADIUS_IN_EDGES: f64 = 3.5;
/// Most neighbours that a fit uses, nearest rings first; bounds the work for a huge radius.
const MOST_NEIGHBOURS: usize = 512;
/// Most edges that a search follows; bounds the work where thousands of faces share a vertex.
const MOST_EDGES: usize = 4096;
/// Neighbours below which only the quadratic terms are fitted.
const FEWEST_FOR_CUBIC: usize = 13;
/// Neighbours below which the radius is enlarged.
const FEWEST: usize = 8;
/// How often the radius is enlarged, and by how much.
const ENLARGEMENTS: usize = 10;
const ENLARGEMENT: f64 = 1.25;
/// Part of a column's norm that must be independent of the columns before it.
const INDEPENDENT: f64 = 1e-5;
/// Cosine between normals below which a neighbour lies on another sheet of the surface.
const SAME_SHEET: f64 = 0.1;

/// 1, u, v, u², uv, v² and the four cubic terms.
const TERMS: usize = 10;
const QUADRATIC_TERMS: usize = 6;

/// Shape operators at the vertices of a surface.
#[derive(Clone, Debug, PartialEq)]
pub struct CurvatureField {
    operators: Vec<ShapeOperator>,
    poor: usize,
    /// At which vertices it is that of the normals; empty for none.
    of_normals: Vec<bool>,
}

impl CurvatureField {
    /// A field from `#V` known operators, for surfaces with exact derivatives.
    pub fn from_operators(operators: Vec<ShapeOperator>) -> Self {
        Self { operators, poor: 0, of_normals: Vec::new() }
    }

    /// Estimates the shape operator at every vertex of `surface`.
    ///
    /// `radius`: scale of the fit, mm; `None` takes 3.5 mean edge lengths around each vertex. At
    /// most 512 neighbours are used. A vertex with too few of them takes more, whatever the
    /// radius; where even those do not tell a height field the operator is flat and counted by
    /// [`poor`](Self::poor). Never NaN.
    pub fn estimate(surface: &Surface, radius: Option<f64>) -> Self {
        Self::fitted(surface, radius, 0.0, &vec![None; surface.positions().len()])
    }

    /// As [`estimate`](Self::estimate), for a surface that is made up of two kinds of places: at the vertices of `exact`
    /// faces the curvature is that by which the vertex normals change from one to the next, however long the sides are;
    /// at all others it is fitted to these others alone, at a scale of at least `least` mm where no `radius` is given. `exact`: of each of the `#F` faces whether its normals are exact; empty for none.
    ///
    /// # Source
    /// Rusinkiewicz, "Estimating curvatures and their derivatives on triangle meshes", 3DPVT 2004, weighted by area.
    pub fn of_normals(surface: &Surface, exact: &[bool], radius: Option<f64>, least: f64) -> Self {
        Self::fitted(surface, radius, least, &bends_of_normals(surface, exact))
    }

    /// Known operators, and fitted ones where there is none.
    fn fitted(
        surface: &Surface,
        radius: Option<f64>,
        least: f64,
        known: &[Option<ShapeOperator>],
    ) -> Self {
        let rings = Rings::new(surface);
        let radii = match radius {
            Some(r) if r > 0.0 => vec![r; surface.positions().len()],
            _ => {
                let radii = rings.default_radii(surface.positions());
                radii.into_iter().map(|r| r.max(least)).collect()
            }
        };
        let mut search = Search::new(surface.positions().len());
        let mut operators = Vec::with_capacity(radii.len());
        let mut poor = 0;
        let fits = Fits { surface, rings: &rings, known };
        for (v, (&radius, known)) in radii.iter().zip(known).enumerate() {
            if let Some(operator) = known {
                operators.push(*operator);
                continue;
            }
            let fitted = fits.at_vertex(&mut search, v, radius);
            poor += usize::from(fitted.is_none());
            let normal = surface.vertex_normals()[v];
            operators.push(fitted.unwrap_or_else(|| ShapeOperator::flat(normal)));
        }
        Self { operators, poor, of_normals: known.iter().map(Option::is_some).collect() }
    }

    /// Whether the operator at a vertex is that of the normals, whatever the length of the sides there.
    pub fn is_of_normals(&self, vertex: VertexId) -> bool {
        self.of_normals.get(vertex.index()) == Some(&true)
    }

    /// `#V` operators.
    pub fn operators(&self) -> &[ShapeOperator] {
        &self.operators
    }

    /// The operator at a vertex.
    pub fn vertex(&self, vertex: VertexId) -> &ShapeOperator {
        &self.operators[vertex.index()]
    }

    /// Vertices whose curvature could not be estimated and is given as flat.
    pub fn poor(&self) -> usize {
        self.poor
    }

    /// The operator at a surface point, interpolated from the three vertices.
    ///
    /// Each one is first turned to the normal there, so that the tilt between the vertices takes
    /// nothing away.
    pub fn at(&self, surface: &Surface, point: SurfacePoint) -> ShapeOperator {
        let vertices = surface.connectivity().face(point.face);
        let mut normal = surface.normal(point);
        if normal == DVec3::ZERO {
            normal = surface.vertex_normals()[vertices[0].index()];
        }
        let frame = frame_of(normal);
        let mut k = [0.0; 3];
        for (vertex, weight) in vertices.iter().zip(point.weights) {
            let turned = self.vertex(*vertex).turned_to(normal).in_frame(frame);
            for (sum, part) in k.iter_mut().zip(turned.k) {
                *sum += weight * part;
            }
        }
        ShapeOperator { frame, k }
    }
}

/// A tangent frame.
fn frame_of(normal: DVec3) -> [DVec3; 2] {
    let u = any_perpendicular(normal);
    [u, normal.cross(u)]
}

/// The operators by which the normals change, at the vertices of `exact` faces: over all faces around, or over those
/// that are not exact if there are any. The curvature jumps there, and strips are as narrow as on that side.
fn bends_of_normals(surface: &Surface, exact: &[bool]) -> Vec<Option<ShapeOperator>> {
    // Of exact faces and of others: the sum, weighted by area.
    let mut sums = vec![[([0.0; 3], 0.0); 2]; surface.positions().len()];
    let faces = surface.connectivity().faces();
    for (face, exact) in faces.iter().zip(exact) {
        let Some((bend, area)) = bend_of_normals(surface, face) else { continue };
        for vertex in face {
            let normal = surface.vertex_normals()[vertex.index()];
            let k = bend.turned_to(normal).in_frame(frame_of(normal)).k;
            let (sum, whole) = &mut sums[vertex.index()][usize::from(!exact)];
            *sum = [0, 1, 2].map(|i| sum[i] + area * k[i]);
            *whole += area;
        }
    }
    let mean = |(normal, [of_exact, of_others]): (&DVec3, [([f64; 3], f64); 2])| {
        let (sum, area) = if of_others.1 > 0.0 { of_others } else { of_exact };
        let frame = frame_of(*normal);
        (of_exact.1 > 0.0).then(|| ShapeOperator { frame, k: sum.map(|k| k / area) })
    };
    surface.vertex_normals().iter().zip(sums).map(mean).collect()
}

/// How the normals at the corners of a face change over it, and its area, mm²; `None` for a face without area. The
/// least-squares solution of `dn = K dx` on its three sides.
fn bend_of_normals(surface: &Surface, face: &[VertexId; 3]) -> Option<(ShapeOperator, f64)> {
    let [places, normals] =
        [surface.positions(), surface.vertex_normals()].map(|of| face.map(|v| of[v.index()]));
    let twice_area = (places[1] - places[0]).cross(places[2] - places[0]);
    let frame = frame_of(twice_area.try_normalize()?);
    let mut matrix = Matrix3::zeros();
    let mut right = Vector3::zeros();
    for (i, j) in [(0, 1), (1, 2), (2, 0)] {
        let [x, y] = frame.map(|e| e.dot(places[j] - places[i]));
        let [p, q] = frame.map(|e| e.dot(normals[j] - normals[i]));
        for (row, value) in [(Vector3::new(x, y, 0.0), p), (Vector3::new(0.0, x, y), q)] {
            matrix += row * row.transpose();
            right += row * value;
        }
    }
    let k = matrix.cholesky()?.solve(&right);
    let k = [k.x, k.y, k.z];
    k.iter()
        .all(|k| k.is_finite())
        .then_some((ShapeOperator { frame, k }, 0.5 * twice_area.length()))
}

impl Surface {
    /// Shape operators at the vertices: exact on a NURBS surface, else estimated at a scale of
    /// `radius` mm; see [`CurvatureField::estimate`].
    pub fn curvature(&self, radius: Option<f64>) -> CurvatureField {
        match self.parameters() {
            Some(parametrisation) => CurvatureField::from_operators(
                parametrisation.vertex_shapes(self.connectivity(), self.vertex_normals()),
            ),
            None => CurvatureField::estimate(self, radius),
        }
    }
}

/// Neighbours of every vertex along edges.
struct Rings {
    start: Vec<u32>,
    neighbours: Vec<u32>,
}

impl Rings {
    fn new(surface: &Surface) -> Self {
        let connectivity = surface.connectivity();
        let sides = || (0..3 * connectivity.face_count() as u32).map(HalfEdgeId);
        // Every side gives its end to its start; a boundary side also the other way round.
        let pairs = || {
            sides().flat_map(|side| {
                let (a, b) = connectivity.ends(side);
                let back = connectivity.opposite(side).is_none().then_some((b, a));
                std::iter::once((a, b)).chain(back)
            })
        };
        let mut start = vec![0; surface.positions().len() + 1];
        for (a, _) in pairs() {
            start[a.index() + 1] += 1;
        }
        for v in 1..start.len() {
            start[v] += start[v - 1];
        }
        let mut fill = start.clone();
        let mut neighbours = vec![0; start[start.len() - 1] as usize];
        for (a, b) in pairs() {
            neighbours[fill[a.index()] as usize] = b.0;
            fill[a.index()] += 1;
        }
        Self { start, neighbours }
    }

    fn around(&self, v: u32) -> &[u32] {
        let v = v as usize;
        &self.neighbours[self.start[v] as usize..self.start[v + 1] as usize]
    }

    /// Mean edge lengths, averaged once more over the neighbours, times the default factor.
    fn default_radii(&self, positions: &[DVec3]) -> Vec<f64> {
        let at = |v: u32| positions[v as usize];
        let mean = |v: u32, value: &dyn Fn(u32) -> f64| {
            let ring = self.around(v);
            ring.iter().map(|&w| value(w)).sum::<f64>() / ring.len().max(1) as f64
        };
        let vertices = 0..positions.len() as u32;
        let edge: Vec<f64> =
            vertices.clone().map(|v| mean(v, &|w| (at(w) - at(v)).length())).collect();
        let smooth = |v: u32| 0.5 * (edge[v as usize] + mean(v, &|w| edge[w as usize]));
        vertices.map(|v| RADIUS_IN_EDGES * smooth(v)).collect()
    }
}

/// The vertices around one, ring by ring.
struct Search {
    /// Last search that saw a vertex.
    seen: Vec<u32>,
    current: u32,
    found: Vec<u32>,
    /// Whether the last search ended at a limit and not at its radius.
    cut_off: bool,
}

impl Search {
    fn new(vertices: usize) -> Self {
        Self { seen: vec![0; vertices], current: 0, found: Vec::new(), cut_off: false }
    }

    /// Vertices within `radius` of vertex `v`, connected to it within the radius; `v` is first.
    fn run(&mut self, positions: &[DVec3], rings: &Rings, v: u32, radius: f64) -> &[u32] {
        self.current += 1;
        self.found.clear();
        self.found.push(v);
        self.seen[v as usize] = self.current;
        let (mut at, mut followed) = (0, 0);
        while at < self.found.len() && self.found.len() < MOST_NEIGHBOURS {
            let ring = rings.around(self.found[at]);
            for &w in &ring[..ring.len().min(MOST_EDGES - followed)] {
                let near = (positions[w as usize] - positions[v as usize]).length_squared()
                    <= radius * radius;
                if near && self.seen[w as usize] != self.current {
                    self.seen[w as usize] = self.current;
                    self.found.push(w);
                }
            }
            followed = MOST_EDGES.min(followed + ring.len());
            at += 1;
        }
        self.cut_off = at < self.found.len() || followed == MOST_EDGES;
        self.found.truncate(MOST_NEIGHBOURS);
        &self.found
    }
}

/// Degree of a fitted height field.
#[derive(Copy, Clone, PartialEq)]
enum Degree {
    Quadratic,
    Cubic,
}

/// Fits at the vertices where no operator is known.
struct Fits<'a> {
    surface: &'a Surface,
    rings: &'a Rings,
    known: &'a [Option<ShapeOperator>],
}

impl Fits<'_> {
    /// Fits with the radius given, then with larger ones.
    fn at_vertex(&self, search: &mut Search, v: usize, radius: f64) -> Option<ShapeOperator> {
        let Self { surface, rings, .. } = *self;
        let mut radius = radius;
        let mut quadratic = None;
        for _ in 0..=ENLARGEMENTS {
            let near = search.run(surface.positions(), rings, v as u32, radius);
            let fitted = if near.len() > FEWEST { self.fit(v, near, radius) } else { None };
            match fitted {
                Some((operator, Degree::Cubic)) => return Some(operator),
                // Corners see too little for cubic terms; one larger radius is worth trying there.
                Some((operator, Degree::Quadratic)) if quadratic.is_none() => {
                    quadratic = Some(operator);
                }
                _ if quadratic.is_some() => return quadratic,
                _ => {}
            }
            if search.cut_off {
                return quadratic;
            }
            radius *= ENLARGEMENT;
        }
        // A surface of few faces: whatever its vertices tell.
        let near = search.run(surface.positions(), rings, v as u32, f64::INFINITY);
        let reach = |w: &u32| (surface.positions()[*w as usize] - surface.positions()[v]).length();
        let radius = near.iter().map(reach).fold(0.0, f64::max);
        quadratic.or_else(|| self.fit(v, near, radius).map(|(operator, _)| operator))
    }

    /// The least-squares height field over `near`; `None` if they do not determine one.
    fn fit(&self, v: usize, near: &[u32], radius: f64) -> Option<(ShapeOperator, Degree)> {
        let surface = self.surface;
        let origin = surface.positions()[v];
        let normal = surface.vertex_normals()[v];
        let x = any_perpendicular(normal);
        let y = normal.cross(x);
        let mut system = Normal::default();
        let mut used = 0;
        for &w in near {
            let is_known = self.known[w as usize].is_some();
            if is_known || surface.vertex_normals()[w as usize].dot(normal) < SAME_SHEET {
                continue;
            }
            // Lengths in radii keep the powers of the basis comparable.
            let d = (surface.positions()[w as usize] - origin) / radius;
            // Neighbours at the rim fade out, so that the estimate changes little as they come and go.
            let weight = 1.05 - d.length_squared();
            if weight > 0.0 {
                system.add(d.dot(x), d.dot(y), d.dot(normal), weight);
                used += 1;
            }
        }
        let cubic = if used > FEWEST_FOR_CUBIC { system.solve::<TERMS>() } else { None };
        let (degree, [_, p, q, uu, uv, vv]) = match cubic {
            Some([c0, c1, c2, c3, c4, c5, ..]) => (Degree::Cubic, [c0, c1, c2, c3, c4, c5]),
            None if used > QUADRATIC_TERMS => {
                (Degree::Quadratic, system.solve::<QUADRATIC_TERMS>()?)
            }
            None => return None,
        };
        let second = [2.0 * uu, uv, 2.0 * vv].map(|s| normal * (s / radius));
        let operator = ShapeOperator::from_derivatives([x + normal * p, y + normal * q], second);
        operator.k.iter().all(|k| k.is_finite()).then_some((operator, degree))
    }
}

/// Weighted normal equations of the fit; the quadratic ones are their leading block.
#[derive(Default)]
struct Normal {
    matrix: [[f64; TERMS]; TERMS],
    right: [f64; TERMS],
}

impl Normal {
    fn add(&mut self, u: f64, v: f64, height: f64, weight: f64) {
        let (uu, uv, vv) = (u * u, u * v, v * v);
        let basis = [1.0, u, v, uu, uv, vv, u * uu, u * uv, v * uv, v * vv];
        for i in 0..TERMS {
            let scaled = weight * basis[i];
            for (sum, other) in self.matrix[i][..=i].iter_mut().zip(basis) {
                *sum += scaled * other;
            }
            self.right[i] += scaled * height;
        }
    }

    /// Cholesky solution of the leading `N` equations; `None` if a term depends on those before.
    fn solve<const N: usize>(&self) -> Option<[f64; N]> {
        let mut l = [[0.0; N]; N];
        for i in 0..N {
            for j in 0..=i {
                let known: f64 = l[i][..j].iter().zip(&l[j][..j]).map(|(a, b)| a * b).sum();
                let sum = self.matrix[i][j] - known;
                if i > j {
                    l[i][j] = sum / l[j][j];
                } else if sum > INDEPENDENT * self.matrix[i][i] {
                    l[i][i] = sum.sqrt();
                } else {
                    return None;
                }
            }
        }
        let mut c = [0.0; N];
        for i in 0..N {
            let known: f64 = (0..i).map(|k| l[i][k] * c[k]).sum();
            c[i] = (self.right[i] - known) / l[i][i];
        }
        for i in (0..N).rev() {
            let known: f64 = (i + 1..N).map(|k| l[k][i] * c[k]).sum();
            c[i] = (c[i] - known) / l[i][i];
        }
        Some(c)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::DVec2;
    use crate::mesh::{Connectivity, TriangleSoup};
    use crate::surface::AnalyticSurface;

    fn surface(mesh: TriangleSoup) -> Surface {
        let faces = mesh.faces.iter().map(|f| f.map(VertexId)).collect();
        Surface::new(Connectivity::new(mesh.positions.len(), faces).unwrap(), mesh.positions)
    }

    /// Largest error of both principal curvatures, and its mean, relative to `scale` (1/mm).
    fn errors(truth: &AnalyticSurface, edge: f64, scale: f64) -> (f64, f64) {
        let surface = surface(truth.mesh(edge));
        let field = CurvatureField::estimate(&surface, None);
        assert_eq!(field.poor(), 0);
        let samples = truth.samples(edge);
        let error = |(operator, s): (&ShapeOperator, &DVec2)| {
            let exact = truth.curvature(*s).turned_to(operator.normal()).in_frame(operator.frame);
            let off = (0..3).map(|i| (operator.k[i] - exact.k[i]).abs()).fold(0.0, f64::max);
            off / scale
        };
        let all: Vec<f64> = field.operators().iter().zip(&samples).map(error).collect();
        let largest = all.iter().copied().fold(0.0, f64::max);
        (largest, all.iter().sum::<f64>() / all.len() as f64)
    }

    fn truths() -> [(AnalyticSurface, f64, f64); 5] {
        // Surface, edge length that gives about 10 000 faces, and the scale of its curvature.
        [
            (AnalyticSurface::SphereCap { radius: 20.0, diameter: 36.0 }, 0.48, 1.0 / 20.0),
            (AnalyticSurface::SphereCap { radius: -20.0, diameter: 36.0 }, 0.48, 1.0 / 20.0),
            (
                AnalyticSurface::Cylinder { radius: 15.0, width: 40.0, length: 40.0 },
                0.6,
                1.0 / 15.0,
            ),
            (
                AnalyticSurface::Torus { major: 30.0, minor: 10.0, length: 40.0, width: 25.0 },
                0.48,
                1.0 / 10.0,
            ),
            (AnalyticSurface::Saddle { radius: 20.0, size: 30.0 }, 0.45, 1.0 / 20.0),
        ]
    }

    #[test]
    fn truth_within_one_percent_at_ten_thousand_faces() {
        for (truth, edge, scale) in truths() {
            let faces = truth.mesh(edge).faces.len();
            assert!((8_000..14_000).contains(&faces), "{truth:?}: {faces} faces");
            let (largest, mean) = errors(&truth, edge, scale);
            println!("{truth:?}: {faces} faces, largest {largest:.2e}, mean {mean:.2e}");
            assert!(largest < 1e-2, "{truth:?}: {largest}");
            assert!(mean < 5e-3, "{truth:?}: {mean}");
        }
    }

    /// A floor and the quarter of a cylinder that a ball leaves at the foot of a wall, in chords of 30 degrees: there
    /// the curvature is that of the ball, and the floor beside it has none.
    #[test]
    fn a_rounding_of_few_faces_is_round_and_the_floor_beside_it_flat() {
        let radius = 3.0;
        let on_floor = (0..=8).map(|i| (DVec3::new(0.25 * f64::from(i) - 2.0, 0.0, 0.0), DVec3::Z));
        let on_rounding = (1..=3).map(|i| {
            let angle = f64::from(i) * core::f64::consts::FRAC_PI_6;
            let (s, c) = (crate::geometry::math::sin(angle), crate::geometry::math::cos(angle));
            (DVec3::new(s, 0.0, 1.0 - c) * radius, DVec3::new(-s, 0.0, c))
        });
        let profile: Vec<(DVec3, DVec3)> = on_floor.chain(on_rounding).collect();
        let rows = 6;
        let count = profile.len() as u32;
        let (mut positions, mut normals, mut faces, mut exact) =
            (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        for row in 0..rows {
            for (place, normal) in &profile {
                positions.push(*place + DVec3::Y * f64::from(row));
                normals.push(*normal);
            }
        }
        for row in 0..rows - 1 {
            for i in 0..count - 1 {
                let [a, b] = [row * count + i, (row + 1) * count + i];
                faces.extend([[a, a + 1, b + 1], [a, b + 1, b]]);
                exact.extend([i > 8, i > 8]);
            }
        }
        let faces = faces.into_iter().map(|f| f.map(VertexId)).collect();
        let connectivity = Connectivity::new(positions.len(), faces).unwrap();
        let surface = Surface::new(connectivity, positions).with_normals(normals);
        let field = CurvatureField::of_normals(&surface, &exact, None, 0.0);
        for (v, place) in surface.positions().iter().enumerate() {
            let (low, high, _) = field.operators()[v].principal();
            assert!(high.abs() < 1e-9, "{place}: {high}");
            if place.x > 1.6 {
                assert!((low + 1.0 / radius).abs() < 1e-6, "{place}: {low}");
                assert!(field.is_of_normals(VertexId(v as u32)));
            } else if place.x <= 0.0 {
                assert!(low.abs() < 1e-9, "{place}: {low}");
            }
        }
    }

    #[test]
    fn errors_fall_with_the_square_of_the_edge_length() {
        for (truth, edge, scale) in truths() {
            let (coarse, fine) = (errors(&truth, 2.0 * edge, scale), errors(&truth, edge, scale));
            let ratio = coarse.1 / fine.1;
            println!("{truth:?}: {coarse:?} -> {fine:?}, ratio {ratio:.2}");
            assert!(ratio > 3.4, "{truth:?}: {ratio}");
        }
    }

    /// A bump whose interior vertices are moved by up to a third of an edge, always alike.
    fn irregular_error(edge: f64) -> f64 {
        let truth = AnalyticSurface::Bump { size: 20.0, height: 3.0, width: 5.0 };
        let mut state = 7_u64;
        let mut random = || {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (state >> 40) as f64 / (1_u64 << 24) as f64 - 0.5
        };
        let samples: Vec<DVec2> = truth
            .samples(edge)
            .into_iter()
            .map(|s| {
                let inside = s.abs().max_element() < 10.0 - 0.9 * edge;
                let step = 0.6 * edge * DVec2::new(random(), random());
                if inside { s + step } else { s }
            })
            .collect();
        let mut mesh = truth.mesh(edge);
        mesh.positions = samples.iter().map(|s| truth.position(*s)).collect();
        let field = CurvatureField::estimate(&surface(mesh), None);
        let error = |(operator, s): (&ShapeOperator, &DVec2)| {
            let exact = truth.curvature(*s).turned_to(operator.normal()).in_frame(operator.frame);
            (0..3).map(|i| (operator.k[i] - exact.k[i]).abs()).fold(0.0, f64::max)
        };
        field.operators().iter().zip(&samples).map(error).fold(0.0, f64::max)
    }

    #[test]
    fn irregular_meshes_converge_with_the_square_too() {
        // The bump's curvature goes up to 3/25 per mm.
        let (coarse, fine) = (irregular_error(0.5), irregular_error(0.25));
        println!("irregular: {coarse:.2e} -> {fine:.2e}");
        assert!(fine < 0.01 * 3.0 / 25.0, "{fine}");
        assert!(coarse / fine > 3.0, "{coarse} {fine}");
    }

    #[test]
    fn moved_and_reordered_meshes_bend_alike() {
        let truth = AnalyticSurface::Bump { size: 20.0, height: 3.0, width: 5.0 };
        let mesh = truth.mesh(1.0);
        let n = mesh.positions.len() as u32;
        let turned = TriangleSoup {
            positions: mesh
                .positions
                .iter()
                .rev()
                .map(|p| DVec3::new(p.y, p.z, p.x) + 100.0)
                .collect(),
            faces: mesh.faces.iter().rev().map(|f| f.map(|v| n - 1 - v)).collect(),
            texture: None,
        };
        let one = CurvatureField::estimate(&surface(mesh), None);
        let other = CurvatureField::estimate(&surface(turned), None);
        for (a, b) in one.operators().iter().zip(other.operators().iter().rev()) {
            let ((low, high, _), (low_b, high_b, _)) = (a.principal(), b.principal());
            assert!((low - low_b).abs() < 1e-9 && (high - high_b).abs() < 1e-9);
        }
    }

    #[test]
    fn a_vertex_of_very_many_faces_does_not_stall_the_search() {
        let n = 30_000_u32;
        let rim = (0..n).map(|i| {
            let angle = std::f64::consts::TAU * f64::from(i) / f64::from(n);
            DVec3::new(crate::geometry::math::cos(angle), crate::geometry::math::sin(angle), 0.0)
        });
        let positions = std::iter::once(DVec3::ZERO).chain(rim).collect();
        let faces = (0..n).map(|i| [0, 1 + i, 1 + (i + 1) % n]).collect();
        let fan = surface(TriangleSoup { positions, faces, texture: None });
        let field = CurvatureField::estimate(&fan, None);
        assert!(field.operators().iter().all(|o| o.k.iter().all(|k| k.abs() < 1e-6)));
    }

    #[test]
    fn poor_neighbourhoods_are_flat_and_counted() {
        let corner = [DVec3::ZERO, DVec3::X, DVec3::Y].to_vec();
        let mesh = TriangleSoup { positions: corner, faces: vec![[0, 1, 2]], texture: None };
        let field = CurvatureField::estimate(&surface(mesh), Some(0.1));
        assert_eq!(field.poor(), 3);
        assert!(field.operators().iter().all(|o| o.k == [0.0; 3]));
    }

    #[test]
    fn interpolation_keeps_a_sphere_round() {
        let truth = AnalyticSurface::SphereCap { radius: 10.0, diameter: 16.0 };
        let mesh = truth.mesh(2.0);
        let exact = truth.samples(2.0).iter().map(|s| truth.curvature(*s)).collect();
        let (surface, field) = (surface(mesh), CurvatureField::from_operators(exact));
        for f in 0..surface.connectivity().face_count() as u32 {
            let point = SurfacePoint { face: crate::mesh::FaceId(f), weights: [0.2, 0.3, 0.5] };
            let (low, high, _) = field.at(&surface, point).principal();
            assert!((low - 0.1).abs() < 1e-12 && (high - 0.1).abs() < 1e-12);
        }
    }
}
