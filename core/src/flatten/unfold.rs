//! Maps that turn faces over → maps that turn none over.
//!
//! A conformal map is found for a triangulation with better edges than those of the mesh; long thin faces of the mesh,
//! and rough places, may be turned over in it. They are few and lie together.
//!
//! - *Distortion* of a face: its Dirichlet energy over its flat area, 1 where the face keeps its angles, more elsewhere,
//!   and infinite where its flat area vanishes. For a face that is turned over the area is replaced by a small positive
//!   one that grows with it.
//!
//! Steps: (1) around the faces that are turned over, each vertex in turn is moved to where the faces around it are
//! distorted least, by Newton steps, until all look up; (2) where that does not help, with more and more rings of faces
//! around them. (3) Where the flat boundary crosses itself, or all that has failed, the boundary is laid on a
//! circle, and every inner vertex is the mean of its neighbours with positive weights; this turns no face over.
//!
//! Sources: Hormann, Greiner, "MIPS: an efficient global parametrization method" (2000), the distortion; Garanzha,
//! Kaporin, Kudryavtseva, Protais, Ray, Sokolov, "Foldover-free maps in 50 lines of code", TOG 2021, the area of faces
//! that are turned over; Tutte, "How to draw a graph" (1963), step 3.

use super::bff::{bff_unchecked, boundary_lengths};
use super::chart::Chart;
use super::disk::Disk;
use super::distortion::Distortion;
use super::error::FlattenError;
use super::intrinsic::{measure, weights_from_angles};
use super::laplace::DirichletLaplacian;
use crate::geometry::math::{cos, sin};
use crate::geometry::{DVec2, cross2};
use crate::mesh::{FaceId, VertexId};
use crate::surface::Surface;
use std::collections::BTreeSet;
use std::f64::consts::TAU;

/// Rings of faces around the ones that are turned over, at first; twice as many each time, as often as this.
const RINGS: usize = 3;
const TIMES: u32 = 6;
/// Sweeps over the vertices until no face is turned over, at most, and afterwards.
const SWEEPS: usize = 150;
const SMOOTHED: usize = 12;
/// Moves of vertices in one attempt, at most.
const MOST_MOVES: usize = 20_000_000;
/// Halvings of a step that makes a vertex's faces worse.
const HALVINGS: usize = 24;
/// Least area that replaces that of a face that is turned over, of that which it should have; and how much of the most
/// negative one is added.
const LEAST: f64 = 1e-6;
const OF_WORST: f64 = 0.2;
/// Least and greatest weight of an edge in step 3: cotangents of 89.4 and 0.6 degrees.
const WEIGHTS: [f64; 2] = [0.01, 100.0];

/// A chart that turns no face over and does not overlap, where a conformal one would.
///
/// # Errors
/// [`FlattenError`] when the surface is not a disk with holes, or no such chart was found.
pub fn unfolded(surface: &Surface) -> Result<Chart, FlattenError> {
    unfolded_from(surface, bff_unchecked(surface)?)
}

/// The chart, or one like it that turns no face over and does not overlap.
fn unfolded_from(surface: &Surface, chart: Chart) -> Result<Chart, FlattenError> {
    match chart.validate(surface) {
        Ok(()) => return Ok(chart),
        Err(FlattenError::Flipped { .. }) => {
            let mut unfolding = Unfolding::new(surface, chart.uv().to_vec());
            if unfolding.run(|_| true) {
                let chart = Chart::new(surface, unfolding.flat);
                if chart.validate(surface).is_ok() {
                    return Ok(chart);
                }
            }
        }
        Err(_) => {}
    }
    let mut unfolding = Unfolding::new(surface, on_circle(surface)?);
    let connectivity = surface.connectivity();
    unfolding.run(|v| !connectivity.is_boundary(v));
    let chart = Chart::new(surface, unfolding.flat);
    chart.validate(surface)?;
    Ok(chart)
}

/// Flat points with the outer boundary on a circle, each inner one a mean of its neighbours.
fn on_circle(surface: &Surface) -> Result<Vec<DVec2>, FlattenError> {
    let disk = Disk::new(surface)?;
    let (angles, _) = measure(&disk)?;
    let mut weights = weights_from_angles(&disk, &angles);
    weights.iter_mut().for_each(|w| w.2 = w.2.clamp(WEIGHTS[0], WEIGHTS[1]));
    let laplacian = DirichletLaplacian::new(&disk, weights)?;
    let boundary = disk.boundary();
    let sides = boundary_lengths(&disk);
    let whole: f64 = sides.iter().sum();
    let mut flat = vec![DVec2::ZERO; disk.positions.len()];
    let mut way = 0.0;
    for (v, side) in boundary.iter().zip(&sides) {
        let angle = TAU * way / whole;
        flat[v.index()] = DVec2::new(cos(angle), sin(angle));
        way += side;
    }
    laplacian.extend(&mut flat);
    flat.truncate(surface.positions().len());
    Ok(flat)
}

/// A face that has to be distorted little.
#[derive(Copy, Clone)]
struct Shape {
    /// Cotangents of its angles, by corner.
    cotangents: [f64; 3],
    /// Twice its area on the surface, mm².
    doubled: f64,
}

struct Unfolding<'a> {
    surface: &'a Surface,
    flat: Vec<DVec2>,
    shapes: Vec<Shape>,
    /// Faces around every vertex.
    around: Vec<Vec<u32>>,
    /// Flat area over that on the surface.
    density: f64,
}

/// A distortion with its first and second derivatives by the place of a vertex.
#[derive(Copy, Clone, Default)]
struct Jet {
    value: f64,
    slope: DVec2,
    bend: [f64; 3],
}

impl<'a> Unfolding<'a> {
    fn new(surface: &'a Surface, flat: Vec<DVec2>) -> Self {
        let faces = surface.connectivity().faces();
        let shape = |f: usize| {
            let [a, b, c] = surface.corners(FaceId(f as u32));
            let doubled = (b - a).cross(c - a).length().max(f64::MIN_POSITIVE);
            let cotangents = [(b - a).dot(c - a), (c - b).dot(a - b), (a - c).dot(b - c)];
            Shape { cotangents: cotangents.map(|d| d / doubled), doubled }
        };
        let mut around = vec![Vec::new(); flat.len()];
        for (f, face) in faces.iter().enumerate() {
            face.iter().for_each(|v| around[v.index()].push(f as u32));
        }
        let shapes: Vec<Shape> = (0..faces.len()).map(shape).collect();
        let area: f64 = faces.iter().map(|f| doubled(&flat, f).abs()).sum();
        let density = area / shapes.iter().map(|s| s.doubled).sum::<f64>();
        Self { surface, flat, shapes, around, density }
    }

    /// Whether no face is turned over in the end. `may_move`: which vertices may be moved.
    fn run(&mut self, may_move: impl Fn(VertexId) -> bool) -> bool {
        for times in 0..TIMES {
            let turned = self.turned();
            if turned.is_empty() {
                return true;
            }
            let vertices = self.beside(&turned, RINGS << times, &may_move);
            self.set_density(&vertices);
            let mut left = SWEEPS.min(MOST_MOVES / vertices.len().max(1));
            while left > 0 {
                left -= 1;
                let least = self.sweep(&vertices);
                if least > 0.0 && left > SMOOTHED {
                    left = SMOOTHED;
                }
            }
        }
        self.turned().is_empty()
    }

    /// The faces that are turned over.
    fn turned(&self) -> Vec<u32> {
        let connectivity = self.surface.connectivity();
        let distortion = |f: FaceId| {
            let flat = connectivity.face(f).map(|v| self.flat[v.index()]);
            Distortion::of_triangle(self.surface.corners(f), flat)
        };
        let faces = 0..connectivity.face_count() as u32;
        faces.filter(|&f| !distortion(FaceId(f)).is_up()).collect()
    }

    /// The vertices of some faces and of the rings around them, in order.
    fn beside(
        &self,
        faces: &[u32],
        rings: usize,
        may_move: &impl Fn(VertexId) -> bool,
    ) -> Vec<VertexId> {
        let corners = |f: u32| self.surface.connectivity().face(FaceId(f));
        let mut all: BTreeSet<VertexId> = faces.iter().flat_map(|&f| corners(f)).collect();
        let mut front: Vec<VertexId> = all.iter().copied().collect();
        for _ in 0..rings {
            let next = front.iter().flat_map(|v| &self.around[v.index()]).flat_map(|&f| corners(f));
            let next: BTreeSet<VertexId> = next.filter(|v| !all.contains(v)).collect();
            all.extend(&next);
            front = next.into_iter().collect();
        }
        all.into_iter().filter(|v| may_move(*v)).collect()
    }

    /// The density of the faces around some vertices.
    fn set_density(&mut self, vertices: &[VertexId]) {
        let faces: BTreeSet<u32> =
            vertices.iter().flat_map(|v| &self.around[v.index()]).copied().collect();
        let corners = |f: &u32| self.surface.connectivity().face(FaceId(*f));
        let flat: f64 = faces.iter().map(|f| doubled(&self.flat, &corners(f)).abs()).sum();
        let solid: f64 = faces.iter().map(|f| self.shapes[*f as usize].doubled).sum();
        if flat > 0.0 && solid > 0.0 {
            self.density = flat / solid;
        }
    }

    /// Flat area of a face over that which it should have.
    fn relative_area(&self, f: u32) -> f64 {
        let face = self.surface.connectivity().face(FaceId(f));
        doubled(&self.flat, &face) / (self.shapes[f as usize].doubled * self.density)
    }

    /// Moves every vertex once; the least area of the faces around them, of that which they should have.
    fn sweep(&mut self, vertices: &[VertexId]) -> f64 {
        let faces = |v: &VertexId| self.around[v.index()].iter();
        let areas = vertices.iter().flat_map(faces).map(|&f| self.relative_area(f));
        let least = areas.fold(f64::INFINITY, f64::min);
        let soft = LEAST + OF_WORST * (-least).max(0.0);
        vertices.iter().for_each(|v| self.move_vertex(*v, soft));
        least
    }

    fn move_vertex(&mut self, v: VertexId, soft: f64) {
        let (from, jet) = (self.flat[v.index()], self.jet(v, soft));
        let [xx, xy, yy] = jet.bend;
        let determinant = xx * yy - xy * xy;
        let newton =
            DVec2::new(xy * jet.slope.y - yy * jet.slope.x, xy * jet.slope.x - xx * jet.slope.y)
                / determinant;
        let is_good = determinant > 0.0 && xx > 0.0 && newton.is_finite();
        // Down the slope as far as the nearest corner, where the energy does not bend upward.
        let mut step = match is_good {
            true => newton,
            false => -jet.slope.normalize_or_zero() * self.nearest_corner(v),
        };
        for _ in 0..HALVINGS {
            self.flat[v.index()] = from + step;
            if self.jet(v, soft).value < jet.value {
                return;
            }
            step *= 0.5;
        }
        self.flat[v.index()] = from;
    }

    fn nearest_corner(&self, v: VertexId) -> f64 {
        let corners = |&f: &u32| self.surface.connectivity().face(FaceId(f));
        let others = self.around[v.index()].iter().flat_map(corners).filter(|w| *w != v);
        let distance = |w: VertexId| self.flat[w.index()].distance(self.flat[v.index()]);
        others.map(distance).fold(f64::INFINITY, f64::min)
    }

    /// The distortion of the faces around a vertex. `soft`: how soft the bound on the area is, of that which it should be.
    fn jet(&self, v: VertexId, soft: f64) -> Jet {
        self.around[v.index()].iter().fold(Jet::default(), |sum, &f| {
            let face = self.surface.connectivity().face(FaceId(f));
            let corner = face.iter().position(|w| *w == v).unwrap_or(0);
            let [a, b, c] = [0, 1, 2].map(|k| self.flat[face[(corner + k) % 3].index()]);
            let Shape { cotangents, doubled } = self.shapes[f as usize];
            let [ka, kb, kc] = [0, 1, 2].map(|k| cotangents[(corner + k) % 3]);
            let unit = 1.0 / (doubled * self.density);
            // Dirichlet energy and area, both over half the area that the face should have.
            let energy = 0.5
                * unit
                * (ka * (b - c).length_squared()
                    + kb * (c - a).length_squared()
                    + kc * (a - b).length_squared());
            let energy_slope = unit * (kb * (a - c) + kc * (a - b));
            let energy_bend = unit * (kb + kc);
            let area = unit * cross2(a, b, c);
            let area_slope = unit * (c - b).perp();
            let root = (area * area + soft * soft).sqrt();
            // Of a negative area the difference would lose all its digits.
            let bound =
                if area > 0.0 { 0.5 * (area + root) } else { 0.5 * soft * soft / (root - area) };
            let first = bound / root;
            let second = 0.5 * soft * soft / (root * root * root);
            let (by, square) = (1.0 / bound, 1.0 / (bound * bound));
            let slope = energy_slope * by - area_slope * (energy * first * square);
            let mixed = -first * square;
            let own = energy * (2.0 * first * first * square * by - second * square);
            let bend = |i: usize, j: usize| {
                let unit = f64::from(u8::from(i == j));
                energy_bend * by * unit
                    + mixed * (energy_slope[i] * area_slope[j] + energy_slope[j] * area_slope[i])
                    + own * area_slope[i] * area_slope[j]
            };
            Jet {
                value: sum.value + energy * by,
                slope: sum.slope + slope,
                bend: [
                    sum.bend[0] + bend(0, 0),
                    sum.bend[1] + bend(0, 1),
                    sum.bend[2] + bend(1, 1),
                ],
            }
        })
    }
}

/// Twice the flat area of a face.
fn doubled(flat: &[DVec2], face: &[VertexId; 3]) -> f64 {
    let [a, b, c] = face.map(|v| flat[v.index()]);
    cross2(a, b, c)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface::AnalyticSurface;

    #[test]
    fn the_slope_of_the_distortion_is_that_of_its_differences() {
        let surface = dome();
        let flat: Vec<DVec2> = surface.positions().iter().map(|p| p.truncate()).collect();
        let mut unfolding = Unfolding::new(&surface, flat);
        let v = VertexId(40);
        for (soft, aside) in [(1e-6, 0.05), (0.3, 1.9)] {
            unfolding.flat[v.index()].x += aside;
            let (at, step) = (unfolding.flat[v.index()], 1e-5);
            let jet = unfolding.jet(v, soft);
            for axis in 0..2 {
                let mut of = |sign: f64| {
                    unfolding.flat[v.index()][axis] = at[axis] + sign * step;
                    let jet = unfolding.jet(v, soft);
                    unfolding.flat[v.index()] = at;
                    (jet.value, jet.slope)
                };
                let (plus, minus) = (of(1.0), of(-1.0));
                let slope = (plus.0 - minus.0) / (2.0 * step);
                assert!((slope - jet.slope[axis]).abs() < 1e-5 * jet.slope.length(), "{slope}");
                let bend = (plus.1 - minus.1) / (2.0 * step);
                let expected = DVec2::new(jet.bend[axis], jet.bend[axis + 1]);
                assert!(bend.distance(expected) < 1e-4 * expected.length(), "{bend} {expected}");
            }
        }
    }

    fn dome() -> Surface {
        let soup = AnalyticSurface::SphereCap { radius: 25.0, diameter: 30.0 }.mesh(2.0);
        let faces = soup.faces.iter().map(|f| f.map(VertexId)).collect();
        let connectivity = crate::mesh::Connectivity::new(soup.positions.len(), faces).unwrap();
        Surface::new(connectivity, soup.positions)
    }

    #[test]
    fn what_is_turned_over_is_laid_right_and_the_rest_stays() {
        let surface = dome();
        let view: Vec<DVec2> = surface.positions().iter().map(|p| p.truncate()).collect();
        let inner = |v: u32| !surface.connectivity().is_boundary(VertexId(v));
        let mut bad = view.clone();
        for v in (0..view.len() as u32).filter(|&v| inner(v) && v % 97 == 5) {
            bad[v as usize] += DVec2::new(3.1, -2.3);
        }
        assert!(Chart::new(&surface, bad.clone()).validate(&surface).is_err());
        let mended = unfolded_from(&surface, Chart::new(&surface, bad)).unwrap();
        let quality = mended.quality(&surface);
        assert!(quality.flips == 0 && quality.mean_q < 1.1, "{quality:?}");
        // A boundary that crosses itself is laid on a circle.
        let twisted = view.iter().map(|p| DVec2::new(p.x * p.y, p.y)).collect();
        let mended = unfolded_from(&surface, Chart::new(&surface, twisted)).unwrap();
        let rim = surface.connectivity().boundary_loops()[0].iter();
        let radii: Vec<f64> = rim.map(|v| mended.uv()[v.index()].length()).collect();
        assert!(radii.iter().all(|r| (r / radii[0] - 1.0).abs() < 1e-9));
    }
}
