//! Figures of a divided surface once its passes are laid out.

use super::distortion::Evenness;
use super::division::Regions;
use super::layout::{Layout, Spacing};
use super::region_mesh::RegionMesh;
use crate::flatten::Chart;
use crate::level_set::StripMetric;
use crate::level_set::strip_metric::FlatMetric;
use crate::mesh::{FaceId, VertexId};
use crate::surface::Surface;

/// A divided surface and its passes in figures.
#[derive(Clone, Debug)]
pub struct Divided {
    /// The regions.
    pub regions: Regions,
    /// For every region, in the order of machining, its index there.
    pub order: Vec<usize>,
    /// Figures of the regions, in the order of machining.
    pub parts: Vec<PartFigures>,
    /// The figures of the undivided surface.
    pub undivided: Undivided,
}

/// A region in figures.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct PartFigures {
    /// Area, mm².
    pub area: f64,
    /// How evenly it maps.
    pub evenness: Evenness,
    /// Number of passes.
    pub passes: usize,
    /// Distances between passes.
    pub spacing: Spacing,
}

/// What a single stepover for the largest stretch of the undivided map would give.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Undivided {
    /// How evenly it maps.
    pub evenness: Evenness,
    /// Distances that passes would have.
    pub spacing: Spacing,
    /// Length of the passes, mm: the integral of one over their distance, mean over the directions.
    pub length: f64,
}

impl Divided {
    /// Figures of regions, the order of their machining, and the passes on them.
    pub fn of(
        regions: Regions,
        order: Vec<usize>,
        region_meshes: &[RegionMesh],
        layouts: &[Layout],
        undivided: Undivided,
    ) -> Self {
        let part = |&k: &usize| PartFigures {
            area: regions.list[k].piece.area(&regions.split_mesh),
            evenness: regions.list[k].evenness,
            passes: layouts[k].passes.len(),
            spacing: layouts[k].spacing(&region_meshes[k]),
        };
        let parts = order.iter().map(part).collect();
        Self { regions, order, parts, undivided }
    }

    /// Distances between passes, all regions together.
    pub fn spacing(&self) -> Spacing {
        Spacing::joined(self.parts.iter().map(|p| p.spacing))
    }
}

impl Undivided {
    /// Of a surface, its chart, and the strip metric at its `#V` vertices.
    pub fn of(regions: &Regions, surface: &Surface, chart: &Chart, metric: &[StripMetric]) -> Self {
        let stretch = regions.stretch.vertices();
        let most = regions.whole.most;
        let face = |(f, face): (usize, &[VertexId; 3])| {
            let [a, b, c] = surface.corners(FaceId(f as u32));
            let uv = face.map(|v| chart.uv()[v.index()]);
            let mean = core::array::from_fn(|i| {
                face.iter().map(|v| metric[v.index()][i]).sum::<f64>() / 3.0
            });
            let flat_metric = FlatMetric::of_triangle(&mean, [a, b, c], uv)?;
            let by = 3.0 * most / face.iter().map(|v| stretch[v.index()]).sum::<f64>();
            let area = 0.5 * (b - a).cross(c - a).length();
            let flat = 0.5 * (uv[1] - uv[0]).perp_dot(uv[2] - uv[0]).abs();
            Some((
                Spacing::everywhere(1.0 / by, area),
                flat_metric.mean() * by * (area * flat).sqrt(),
            ))
        };
        let faces: Vec<(Spacing, f64)> =
            surface.connectivity().faces().iter().enumerate().filter_map(face).collect();
        Self {
            evenness: regions.whole,
            spacing: Spacing::joined(faces.iter().map(|f| f.0)),
            length: faces.iter().map(|f| f.1).sum(),
        }
    }
}
