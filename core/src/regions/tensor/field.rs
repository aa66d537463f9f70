//! The anisotropic part of the strip-width tensor in the chart.
//!
//! In a conformal chart directions are kept, so the tensor's entries along the chart's axes give the best feed
//! direction in the chart: with `p = (T11 - T22)/2` and `q = T12` it lies at half the angle of `(p, q)`.

use crate::flatten::{Chart, Locator};
use crate::geometry::math::{atan2, cos, sin};
use crate::geometry::{DVec2, DVec3};
use crate::mesh::{FaceId, VertexId};
use crate::surface::{CurvatureField, ShapeOperator, Surface, SurfacePoint};

/// Fraction of the distance to the mean of its neighbours by which a vertex moves in a round of smoothing: larger
/// values overshoot on regular meshes.
const RELAXATION: f64 = 0.5;
/// Most rounds of smoothing.
const MOST_ROUNDS: usize = 500;
/// Rounds that spread directions into areas without one.
const FILLING: usize = 400;

/// Strip-width tensor at the vertices of a surface and between them.
#[derive(Clone, Debug)]
pub struct TensorField<'a> {
    surface: &'a Surface,
    chart: &'a Chart,
    locator: &'a Locator<'a>,
    /// Unit tangents along the chart's first axis.
    axes: Vec<DVec3>,
    /// `(p, q)`, 1/mm.
    values: Vec<DVec2>,
    /// `(T11 + T22) / 2`, 1/mm.
    means: Vec<f64>,
    /// Vertices whose value comes from their neighbours.
    filled: Vec<bool>,
    k_tool: f64,
}

impl<'a> TensorField<'a> {
    /// The tensor `T = (k_tool I + K) / 2` on a surface with shape operators `curvature`.
    ///
    /// `k_tool`: effective curvature of the cutter across the feed, 1/mm; `locator` is over the chart.
    pub fn new(
        surface: &'a Surface,
        (chart, locator): (&'a Chart, &'a Locator<'a>),
        curvature: &CurvatureField,
        k_tool: f64,
    ) -> Self {
        let axes = first_axes(surface, chart);
        let operators = curvature.operators();
        let of = |(shape, axis): (&ShapeOperator, &DVec3)| anisotropy(shape, *axis);
        let values = operators.iter().zip(&axes).map(of).collect();
        let means = operators.iter().map(|shape| 0.5 * (k_tool + shape.mean())).collect();
        let filled = vec![false; axes.len()];
        Self { surface, chart, locator, axes, values, means, filled, k_tool }
    }

    /// The surface.
    pub fn surface(&self) -> &'a Surface {
        self.surface
    }

    /// Its flat image.
    pub fn chart(&self) -> &'a Chart {
        self.chart
    }

    /// Finds the places of flat points.
    pub fn locator(&self) -> &'a Locator<'a> {
        self.locator
    }

    /// `#V` pairs `(p, q)`, 1/mm.
    pub fn values(&self) -> &[DVec2] {
        &self.values
    }

    /// `#V` means of the tensor's eigenvalues, 1/mm.
    pub fn means(&self) -> &[f64] {
        &self.means
    }

    /// Effective curvature of the cutter across the feed, 1/mm.
    pub fn k_tool(&self) -> f64 {
        self.k_tool
    }

    /// `(p, q)` at a place: exact on a NURBS surface, else linear over the flat face.
    pub fn at(&self, point: SurfacePoint) -> DVec2 {
        let vertices = self.surface.connectivity().face(point.face);
        if !self.is_filled(point.face)
            && let Some(shape) = self.surface.parameters().and_then(|p| p.shape(p.at(point)))
        {
            return anisotropy(&shape, self.axis(point));
        }
        (0..3).map(|i| self.values[vertices[i].index()] * point.weights[i]).sum()
    }

    /// Whether the field over a face was taken from its surroundings.
    pub fn is_filled(&self, face: FaceId) -> bool {
        self.surface.connectivity().face(face).iter().any(|v| self.filled[v.index()])
    }

    /// The chart's first axis at a place, in space; nearly tangent, of length nearly 1.
    pub fn axis(&self, point: SurfacePoint) -> DVec3 {
        let vertices = self.surface.connectivity().face(point.face);
        (0..3).map(|i| self.axes[vertices[i].index()] * point.weights[i]).sum()
    }

    /// The flat direction, 1 long, of a tangent at a place with that unit normal.
    pub fn flat_direction(&self, point: SurfacePoint, normal: DVec3, tangent: DVec3) -> DVec2 {
        let axis = self.axis(point);
        DVec2::new(tangent.dot(axis), tangent.dot(normal.cross(axis))).normalize_or(DVec2::X)
    }

    /// Smooths the values over a distance of `edges` edges, the standard deviation of a Gaussian.
    pub fn smooth(&mut self, edges: f64) {
        // A round moves what is at a vertex by an edge with the probability of the relaxation, half
        // of it along each axis.
        let rounds = (2.0 * edges * edges / RELAXATION).round() as usize;
        let weights = self.weights();
        for _ in 0..rounds.min(MOST_ROUNDS) {
            self.relax(&weights, RELAXATION, |_| true);
        }
    }

    /// Gives the marked vertices values interpolated from their surroundings (harmonic).
    pub fn fill(&mut self, marked: &[bool]) {
        if marked.iter().all(|m| !m) || marked.iter().all(|m| *m) {
            return;
        }
        for v in (0..marked.len()).filter(|&v| marked[v]) {
            self.values[v] = DVec2::ZERO;
            self.filled[v] = true;
        }
        let weights = self.weights();
        for _ in 0..FILLING {
            self.relax(&weights, 1.0, |v| marked[v]);
        }
    }

    fn relax(&mut self, weights: &[[f64; 3]], part: f64, moves: impl Fn(usize) -> bool) {
        let mut sums = vec![(DVec2::ZERO, 0.0); self.values.len()];
        for (face, weights) in self.surface.connectivity().faces().iter().zip(weights) {
            for (i, &w) in weights.iter().enumerate() {
                let (a, b) = (face[i].index(), face[(i + 1) % 3].index());
                for (v, from) in [(a, b), (b, a)] {
                    sums[v].0 += self.values[from] * w;
                    sums[v].1 += w;
                }
            }
        }
        for (v, (sum, weight)) in sums.into_iter().enumerate() {
            if weight > 0.0 && moves(v) {
                let here = self.values[v];
                self.values[v] = here.lerp(sum / weight, part);
            }
        }
    }

    /// Cotangent weights of the edges of the flat faces, none negative: with them the mean over the neighbours of an
    /// inner vertex leaves linear fields unchanged.
    fn weights(&self) -> Vec<[f64; 3]> {
        let weight = |face: &[VertexId; 3]| {
            let uv = face.map(|v| self.chart.uv()[v.index()]);
            [0, 1, 2].map(|i| {
                let apex = uv[(i + 2) % 3];
                let (a, b) = (uv[i] - apex, uv[(i + 1) % 3] - apex);
                (a.dot(b) / a.perp_dot(b)).clamp(0.0, LARGEST_WEIGHT)
            })
        };
        self.surface.connectivity().faces().iter().map(weight).collect()
    }

    /// Unit vector along the best feed direction for a value; zero where there is none.
    pub fn direction_of(value: DVec2) -> DVec2 {
        if value == DVec2::ZERO {
            return DVec2::ZERO;
        }
        let angle = 0.5 * atan2(value.y, value.x);
        DVec2::new(cos(angle), sin(angle))
    }
}

/// Cotangents beyond this are those of needles.
const LARGEST_WEIGHT: f64 = 1e3;

/// `(p, q)` of the tensor of a shape operator along a tangent and across it; the part of the axis
/// along the normal is left out.
fn anisotropy(shape: &ShapeOperator, axis: DVec3) -> DVec2 {
    let normal = shape.normal();
    let along = (axis - normal * axis.dot(normal)).normalize_or(shape.frame[0]);
    let [xx, xy, yy] = shape.in_frame([along, normal.cross(along)]).k;
    DVec2::new(0.25 * (xx - yy), 0.5 * xy)
}

/// The chart's first axis as a unit tangent at every vertex: the faces' conformal parts, averaged
/// over their flat areas.
fn first_axes(surface: &Surface, chart: &Chart) -> Vec<DVec3> {
    let mut axes = vec![DVec3::ZERO; surface.positions().len()];
    for (f, face) in surface.connectivity().faces().iter().enumerate() {
        let [a, b, c] = surface.corners(FaceId(f as u32));
        let [k, l, m] = face.map(|v| chart.uv()[v.index()]);
        let (p, q, e, g) = (b - a, c - a, l - k, m - k);
        // Twice the flat area times the images of the flat unit vectors.
        let (x, y) = (p * g.y - q * e.y, q * e.x - p * g.x);
        let normal = p.cross(q).normalize_or_zero();
        let axis = x - normal.cross(y);
        face.iter().for_each(|v| axes[v.index()] += axis);
    }
    let normals = surface.vertex_normals();
    axes.iter().zip(normals).map(|(x, n)| (*x - *n * x.dot(*n)).normalize_or_zero()).collect()
}
