//! Rest finishing: where earlier operations left more than they may → regions of the surface.
//!
//! 1. The heights that all earlier paths leave are measured at the vertices of a mesh that resolves passes.
//! 2. They are closed: places between those that are too high belong to them, so that a few regions with long passes
//!    come of many spots. A border of a fraction of a pass lets the strips of the operation end on what is finished.
//! 3. The surface is divided along that border, and the regions within it are kept. Single spots that do not make a
//!    region are left to the rest passes over what the path leaves.

use super::error::PlanError;
use super::prepared::Prepared;
use crate::flatten::Locator;
use crate::geometry::DVec2;
use crate::job::Job;
use crate::level_set::{PassField, PassMesh, StripMetric};
use crate::mesh::VertexId;
use crate::regions::Regions;
use crate::removal::{Before, Columns, Layer, Line, Stage, Stock};
use std::sync::Arc;

/// How far the regions reach beyond what is too high, passes.
const BORDER: f64 = 0.4;
/// Half the width of what is closed between places that are too high, passes. Smaller: more regions and links; larger:
/// more is cut once more.
const CLOSED: f64 = 1.5;

/// The surface as earlier operations left it.
pub(super) struct Uncut<'a> {
    pub prepared: &'a Arc<Prepared>,
    pub job: &'a Job,
    pub stock: &'a Stock,
    pub before: &'a Before,
    pub threads: usize,
}

impl Uncut<'_> {
    /// The regions in which more than `limit` mm is left above the allowance; `metrics`: as of
    /// [`PassMesh::coarse`].
    ///
    /// # Errors
    /// [`PlanError::NoRest`] where there are none.
    pub fn regions(&self, limit: f64, metrics: &[StripMetric]) -> Result<Regions, PlanError> {
        let (surface, chart) = (&self.prepared.surface, &self.prepared.chart);
        let mesh = PassMesh::coarse(surface, chart, metrics.to_vec())?.refined()?;
        let heights = self.heights(&mesh, limit);
        let high = (0u32..).zip(&heights).filter(|(_, height)| **height > limit);
        let sources: Vec<(VertexId, f64)> = high.map(|(v, _)| (VertexId(v), 0.0)).collect();
        if sources.is_empty() {
            return Err(PlanError::NoRest { limit });
        }
        let around = PassField::from_values(&mesh, &sources);
        let far = (0u32..).zip(around.values()).filter(|(_, distance)| **distance > CLOSED);
        let far: Vec<(VertexId, f64)> = far.map(|(v, _)| (VertexId(v), 0.0)).collect();
        // Where nothing is far away, all of it is rest.
        let closed = (!far.is_empty()).then(|| PassField::from_values(&mesh, &far));
        let locator = Locator::new(mesh.connectivity(), mesh.uv());
        let inside = |at: DVec2| {
            let Some(closed) = &closed else { return 1.0 };
            let Ok(place) = locator.locate(at) else { return -1.0 };
            let corners = mesh.connectivity().face(place.face);
            let value = |i: usize| closed.values()[corners[i].index()] * place.weights[i];
            (0..3).map(value).sum::<f64>() - (CLOSED - BORDER)
        };
        Ok(Regions::where_positive(surface, chart, &inside, self.job.nominal_side_step())?)
    }

    /// The heights above the allowance at the `#V` vertices of a mesh, mm: exact above `enough`.
    fn heights(&self, mesh: &PassMesh, enough: f64) -> Vec<f64> {
        let locator = self.prepared.locator();
        let surface = &self.prepared.surface;
        let line = |(v, at): (usize, &DVec2)| {
            let place = locator.locate(*at).ok()?;
            let line = Line { foot: surface.position(place), normal: surface.normal(place) };
            Some((v, (line, *at)))
        };
        let (vertices, lines): (Vec<usize>, Vec<(Line, DVec2)>) =
            mesh.uv().iter().enumerate().filter_map(line).unzip();
        let allowance = self.job.cut.allowance;
        let layer = Layer { allowance, depth: self.stock.top - allowance, falls: false };
        let (columns, ids) = Columns::on(&lines, f64::INFINITY, layer.top());
        let stages: Vec<Stage> = self.before.stages().collect();
        let left = columns.remains(&stages, layer, allowance + enough, self.threads);
        let mut heights = vec![0.0; mesh.uv().len()];
        for (id, height) in ids.iter().zip(left.into_iter().flatten()) {
            heights[vertices[*id as usize]] = height - allowance;
        }
        heights
    }
}
