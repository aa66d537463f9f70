//! The refined mesh and its field, evaluated at flat points.

use super::field::PassField;
use super::refine::PassMesh;
use crate::flat_path::Terrain;
use crate::flatten::Locator;
use crate::geometry::DVec2;
use crate::mesh::FaceId;
use crate::surface::SurfacePoint;
use core::cell::Cell;

/// Scale and clearance at flat points, interpolated on a [`PassMesh`].
pub struct FieldTerrain<'a> {
    mesh: &'a PassMesh,
    field: &'a PassField,
    locator: &'a Locator<'a>,
    /// Face of the last query: the next one is usually near it.
    last: Cell<FaceId>,
}

impl<'a> FieldTerrain<'a> {
    /// `locator` is over the mesh's flat triangles.
    pub fn new(mesh: &'a PassMesh, field: &'a PassField, locator: &'a Locator) -> Self {
        Self { mesh, field, locator, last: Cell::new(FaceId(0)) }
    }

    fn find(&self, at: DVec2) -> Option<SurfacePoint> {
        let found = self.locator.locate_from(self.last.get(), at).ok()?;
        self.last.set(found.face);
        Some(found)
    }

    fn interpolate(&self, at: DVec2, values: &[f64]) -> Option<f64> {
        let p = self.find(at)?;
        let v = self.mesh.connectivity().face(p.face);
        Some((0..3).map(|i| values[v[i].index()] * p.weights[i]).sum())
    }
}

impl Terrain for FieldTerrain<'_> {
    fn scale(&self, at: DVec2) -> Option<f64> {
        self.interpolate(at, self.mesh.scale())
    }

    fn room(&self, at: DVec2) -> Option<f64> {
        // Open passes leave nothing out: everything is as far inside as can be.
        self.interpolate(at, self.field.values()).map(|value| value - self.field.inside())
    }

    fn joins(&self, from: DVec2, to: DVec2) -> bool {
        self.find(from).is_some_and(|p| self.locator.walk(p.face, from, to, |_, _| {}).is_ok())
    }
}
