//! The piece of surface itself: a mesh that is an oriented manifold, with its normals.

use std::sync::Arc;

use super::parametrisation::Parametrisation;
use super::point::SurfacePoint;
use crate::geometry::DVec3;
use crate::mesh::{Connectivity, FaceId};

/// A connected, oriented, manifold piece of surface, mm, faces counter-clockwise from the tool.
#[derive(Clone, Debug)]
pub struct Surface {
    connectivity: Connectivity,
    positions: Vec<DVec3>,
    vertex_normals: Vec<DVec3>,
    parametrisation: Option<Arc<Parametrisation>>,
}

impl Surface {
    /// A surface from connectivity and `#V` positions, mm.
    ///
    /// Normals are averaged with the corner angles as weights (Thürmer and Wüthrich 1998).
    pub fn new(connectivity: Connectivity, positions: Vec<DVec3>) -> Self {
        let vertex_normals = angle_weighted_normals(&connectivity, &positions);
        Self { connectivity, positions, vertex_normals, parametrisation: None }
    }

    /// The same surface with these `#V` unit normals toward the tool.
    pub fn with_normals(mut self, normals: Vec<DVec3>) -> Self {
        self.vertex_normals = normals;
        self
    }

    /// The same surface that knows what it is a mesh of: positions and normals between the
    /// vertices, normals at them and curvature become exact.
    pub fn with_parametrisation(mut self, parametrisation: Parametrisation) -> Self {
        let exact = parametrisation.vertex_normals(&self.connectivity, &self.positions);
        for (normal, exact) in self.vertex_normals.iter_mut().zip(exact) {
            *normal = exact.unwrap_or(*normal);
        }
        self.parametrisation = Some(Arc::new(parametrisation));
        self
    }

    /// The parameters of a mesh of a NURBS surface, and that surface.
    pub fn parameters(&self) -> Option<&Parametrisation> {
        self.parametrisation.as_deref()
    }

    /// Half-edge connectivity.
    pub fn connectivity(&self) -> &Connectivity {
        &self.connectivity
    }

    /// `#V` vertex positions, mm.
    pub fn positions(&self) -> &[DVec3] {
        &self.positions
    }

    /// `#V` positions, mm, and `#F` triples of indices into them.
    pub fn triangles(&self) -> (&[DVec3], Vec<[u32; 3]>) {
        let faces = self.connectivity.faces().iter().map(|f| f.map(|v| v.0)).collect();
        (&self.positions, faces)
    }

    /// `#V` unit normals toward the tool.
    pub fn vertex_normals(&self) -> &[DVec3] {
        &self.vertex_normals
    }

    /// The corner positions of a face.
    pub fn corners(&self, face: FaceId) -> [DVec3; 3] {
        self.connectivity.face(face).map(|v| self.positions[v.index()])
    }

    /// Position of a surface point, mm; exact on a NURBS surface.
    pub fn position(&self, point: SurfacePoint) -> DVec3 {
        if let Some(parametrisation) = &self.parametrisation {
            return parametrisation.position(point);
        }
        let c = self.corners(point.face);
        (0..3).map(|i| c[i] * point.weights[i]).sum()
    }

    /// Unit normal at a surface point, interpolated from the vertices; exact on a NURBS surface.
    pub fn normal(&self, point: SurfacePoint) -> DVec3 {
        if let Some(normal) = self.parametrisation.as_ref().and_then(|p| p.normal(point)) {
            return normal;
        }
        let vertices = self.connectivity.face(point.face);
        let sum: DVec3 =
            (0..3).map(|i| self.vertex_normals[vertices[i].index()] * point.weights[i]).sum();
        sum.normalize_or_zero()
    }

    /// Total area, mm².
    pub fn area(&self) -> f64 {
        (0..self.connectivity.face_count())
            .map(|f| {
                let [a, b, c] = self.corners(FaceId(f as u32));
                0.5 * (b - a).cross(c - a).length()
            })
            .sum()
    }
}

fn angle_weighted_normals(connectivity: &Connectivity, positions: &[DVec3]) -> Vec<DVec3> {
    let mut normals = vec![DVec3::ZERO; positions.len()];
    for face in connectivity.faces() {
        let p = face.map(|v| positions[v.index()]);
        let normal = (p[1] - p[0]).cross(p[2] - p[0]).normalize_or_zero();
        for i in 0..3 {
            let (u, v) = (p[(i + 1) % 3] - p[i], p[(i + 2) % 3] - p[i]);
            let angle = crate::geometry::math::atan2(u.cross(v).length(), u.dot(v));
            normals[face[i].index()] += normal * angle;
        }
    }
    normals.iter().map(|n| n.normalize_or_zero()).collect()
}
