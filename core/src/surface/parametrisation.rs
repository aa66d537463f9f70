//! What a mesh of a NURBS surface knows of it: the parameters of its corners.

use super::point::SurfacePoint;
use crate::geometry::math::atan2;
use crate::geometry::shape::ShapeOperator;
use crate::geometry::{DVec2, DVec3};
use crate::mesh::{Connectivity, FaceId};
use crate::nurbs::NurbsSurface;

/// Way from a corner to the middle of its face at which a surface is looked at where the corner
/// itself, a pole, has no normal. Smaller meets the singularity, larger another place.
const ASIDE: f64 = 1e-3;

/// A NURBS surface and the parameters of the corners of a mesh of it.
///
/// Parameters belong to corners and not to vertices: along the seam of a closed surface and at a
/// pole one vertex has several. Within a face they never jump, so that level sets of `u` or `v` can
/// be followed from face to face; across a seam they differ by [`period`](Self::period).
#[derive(Clone, Debug, PartialEq)]
pub struct Parametrisation {
    surface: NurbsSurface,
    corners: Vec<[DVec2; 3]>,
    /// 1 where the faces look along `u` cross `v`, else -1.
    side: f64,
}

impl Parametrisation {
    /// The parameters of the corners of all faces, on `surface`, mm.
    ///
    /// Faces may run counter-clockwise in the parameters or all of them clockwise: then the normal
    /// is that of the other side.
    pub fn new(surface: NurbsSurface, corners: Vec<[DVec2; 3]>) -> Self {
        let area = |[a, b, c]: &[DVec2; 3]| (*b - *a).perp_dot(*c - *a);
        let side = if corners.iter().map(area).sum::<f64>() < 0.0 { -1.0 } else { 1.0 };
        Self { surface, corners, side }
    }

    /// The surface, mm; beyond its domain closed directions go on around.
    pub fn surface(&self) -> &NurbsSurface {
        &self.surface
    }

    /// `#F` parameters of the corners.
    pub fn corners(&self) -> &[[DVec2; 3]] {
        &self.corners
    }

    /// Parameters of a vertex in the surface's domain, from one of its faces; on a seam or at a
    /// pole there are others.
    pub fn vertex(&self, face: FaceId, corner: usize) -> DVec2 {
        self.surface.wrap(self.corners[face.index()][corner])
    }

    /// What `u` and `v` grow by once around; `None` where the surface is not closed.
    pub fn period(&self) -> [Option<f64>; 2] {
        let (low, high) = self.surface.domain();
        [0, 1].map(|axis| self.surface.closed()[axis].then(|| high[axis] - low[axis]))
    }

    /// Parameters of a surface point, which may lie beyond the domain next to a seam.
    pub fn at(&self, point: SurfacePoint) -> DVec2 {
        let corners = self.corners[point.face.index()];
        (0..3).map(|i| corners[i] * point.weights[i]).sum()
    }

    /// Exact position of a surface point, mm.
    pub fn position(&self, point: SurfacePoint) -> DVec3 {
        self.surface.point(self.at(point))
    }

    /// Exact unit normal toward the tool; `None` where the surface has none.
    pub fn normal(&self, point: SurfacePoint) -> Option<DVec3> {
        self.normal_at(self.at(point))
    }

    /// Exact shape operator at parameters, its normal toward the tool; `None` where the surface has no
    /// normal.
    pub fn shape(&self, at: DVec2) -> Option<ShapeOperator> {
        let shape = self.surface.shape(at)?;
        Some(if self.side < 0.0 { reversed(shape) } else { shape })
    }

    fn normal_at(&self, at: DVec2) -> Option<DVec3> {
        let normal = self.surface.normal(at) * self.side;
        (normal != DVec3::ZERO).then_some(normal)
    }

    /// A corner, or a place next to it where the surface has a normal.
    fn regular(&self, face: usize, corner: usize) -> DVec2 {
        let corners = &self.corners[face];
        let at = corners[corner];
        if self.surface.shape(at).is_some() {
            return at;
        }
        at.lerp((corners[0] + corners[1] + corners[2]) / 3.0, ASIDE)
    }

    /// Normals at the vertices: means over the faces, weighted with the angles, so that creases and
    /// poles have one too.
    pub(super) fn vertex_normals(
        &self,
        connectivity: &Connectivity,
        positions: &[DVec3],
    ) -> Vec<Option<DVec3>> {
        let mut sums = vec![DVec3::ZERO; positions.len()];
        for (f, face) in connectivity.faces().iter().enumerate() {
            let p = face.map(|v| positions[v.index()]);
            for i in 0..3 {
                let (u, v) = (p[(i + 1) % 3] - p[i], p[(i + 2) % 3] - p[i]);
                let angle = atan2(u.cross(v).length(), u.dot(v));
                if let Some(normal) = self.normal_at(self.regular(f, i)) {
                    sums[face[i].index()] += normal * angle;
                }
            }
        }
        sums.into_iter().map(DVec3::try_normalize).collect()
    }

    /// Exact shape operators at the vertices, which have these normals; where a vertex is singular,
    /// those next to it.
    pub(super) fn vertex_shapes(
        &self,
        connectivity: &Connectivity,
        normals: &[DVec3],
    ) -> Vec<ShapeOperator> {
        let flat = |n: &DVec3| ShapeOperator::flat(*n);
        let mut operators: Vec<ShapeOperator> = normals.iter().map(flat).collect();
        for (f, face) in connectivity.faces().iter().enumerate() {
            for (i, v) in face.iter().enumerate() {
                if let Some(shape) = self.shape(self.regular(f, i)) {
                    operators[v.index()] = shape;
                }
            }
        }
        operators
    }
}

/// The operator seen from the other side.
fn reversed(shape: ShapeOperator) -> ShapeOperator {
    let ([x, y], [xx, xy, yy]) = (shape.frame, shape.k);
    ShapeOperator { frame: [y, x], k: [-yy, -xy, -xx] }
}
