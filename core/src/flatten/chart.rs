//! The flat image of a surface, and its scale.

use super::locator::{FaceTree, Locator};
use crate::geometry::{DVec2, cross2};
use crate::mesh::FaceId;
use crate::surface::{Surface, SurfacePoint};
use std::sync::{Arc, OnceLock};

/// A flat image of a surface: one flat point per vertex, same connectivity, same total area.
#[derive(Clone, Debug)]
pub struct Chart {
    uv: Vec<DVec2>,
    vertex_scale: Vec<f64>,
    /// Made when it is first needed.
    tree: OnceLock<Arc<FaceTree>>,
}

impl Chart {
    /// A chart from `#V` flat points, which are scaled so that flat area = surface area.
    pub fn new(surface: &Surface, mut uv: Vec<DVec2>) -> Self {
        let faces = surface.connectivity().faces();
        let flat: f64 = faces
            .iter()
            .map(|f| 0.5 * cross2(uv[f[0].index()], uv[f[1].index()], uv[f[2].index()]))
            .sum();
        let factor = (surface.area() / flat).sqrt();
        for p in &mut uv {
            *p *= factor;
        }
        let vertex_scale = vertex_scale(surface, &uv);
        Self { uv, vertex_scale, tree: OnceLock::new() }
    }

    /// `#V` flat points, flat mm.
    pub fn uv(&self) -> &[DVec2] {
        &self.uv
    }

    /// Finds the points of `surface`, of which this is the image, by their flat points.
    pub fn locator<'a>(&'a self, surface: &'a Surface) -> Locator<'a> {
        let connectivity = surface.connectivity();
        let tree = self.tree.get_or_init(|| FaceTree::new(connectivity, &self.uv).into());
        Locator::by(Arc::clone(tree), connectivity, &self.uv)
    }

    /// `#V` linear scales `s`, mm on the surface per flat mm, area-weighted means of the faces'.
    pub fn vertex_scale(&self) -> &[f64] {
        &self.vertex_scale
    }

    /// Linear scale at a surface point, interpolated.
    pub fn scale(&self, surface: &Surface, point: SurfacePoint) -> f64 {
        let v = surface.connectivity().face(point.face);
        (0..3).map(|i| self.vertex_scale[v[i].index()] * point.weights[i]).sum()
    }
}

/// `sqrt(surface area / flat area)` of the faces around each vertex.
fn vertex_scale(surface: &Surface, uv: &[DVec2]) -> Vec<f64> {
    let mut area = vec![(0.0, 0.0); uv.len()];
    for (f, face) in surface.connectivity().faces().iter().enumerate() {
        let [a, b, c] = surface.corners(FaceId(f as u32));
        let solid = (b - a).cross(c - a).length();
        let flat = cross2(uv[face[0].index()], uv[face[1].index()], uv[face[2].index()]).abs();
        for v in face {
            area[v.index()].0 += solid;
            area[v.index()].1 += flat;
        }
    }
    area.iter().map(|&(solid, flat)| if flat > 0.0 { (solid / flat).sqrt() } else { 1.0 }).collect()
}
