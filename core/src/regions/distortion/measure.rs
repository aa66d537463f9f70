//! How evenly a flat map scales a piece.

use crate::flatten::{Chart, Distortion};
use crate::geometry::{OrderBy, math};
use crate::job::DistortionMeasure;
use crate::mesh::FaceId;
use crate::surface::Surface;

/// Percentiles of the stretch that define the evenness of a map.
const PERCENTILES: (f64, f64) = (0.05, 0.95);

/// Stretch of a flat map, by area.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Evenness {
    /// `U = P5(sigma_ave) / P95(sigma_ave)`, area-weighted; 1 for a map of constant scale.
    pub uniformity: f64,
    /// Smallest mean stretch, mm per flat mm.
    pub least: f64,
    /// Largest mean stretch, mm per flat mm.
    pub most: f64,
}

/// Stretch of the faces of a flat map.
#[derive(Clone, Debug)]
pub struct Stretch {
    faces: Vec<Distortion>,
    areas: Vec<f64>,
    /// `#V` mean stretches, area-weighted means over the faces around.
    vertices: Vec<f64>,
}

impl Stretch {
    /// Of a chart of a surface.
    pub fn of(surface: &Surface, chart: &Chart) -> Self {
        let connectivity = surface.connectivity();
        let count = connectivity.face_count() as u32;
        let area = |f: u32| {
            let [a, b, c] = surface.corners(FaceId(f));
            0.5 * (b - a).cross(c - a).length()
        };
        let faces: Vec<_> = (0..count).map(|f| chart.distortion(surface, FaceId(f))).collect();
        let areas: Vec<f64> = (0..count).map(area).collect();
        let stretches: Vec<f64> = faces.iter().map(|d| d.sigma_ave()).collect();
        let vertices = to_vertices(surface, &stretches, &areas);
        Self { faces, areas, vertices }
    }

    /// `#V` mean stretches `sigma_ave`, mm per flat mm.
    pub fn vertices(&self) -> &[f64] {
        &self.vertices
    }

    /// Uniformity and range; the range is that of the vertices, since single faces of a scan are not significant.
    pub fn evenness(&self) -> Evenness {
        let mut rated: Vec<(f64, f64)> =
            self.faces.iter().map(|d| d.sigma_ave()).zip(self.areas.iter().copied()).collect();
        rated.order_by(|a, b| a.0.total_cmp(&b.0));
        let (low, high) = (percentile(&rated, PERCENTILES.0), percentile(&rated, PERCENTILES.1));
        let range = self.vertices.iter().copied();
        Evenness {
            uniformity: if high > 0.0 { low / high } else { 0.0 },
            least: range.clone().fold(f64::INFINITY, f64::min),
            most: range.fold(0.0, f64::max),
        }
    }

    /// The measure `e` at the `#V` vertices; its area-weighted mean is 0 for logarithmic measures.
    pub fn measure(&self, surface: &Surface, measure: DistortionMeasure) -> Vec<f64> {
        let of = |d: &Distortion| match measure {
            DistortionMeasure::Stretch => math::ln(d.sigma_ave()),
            DistortionMeasure::Area => math::ln(d.tau()),
            DistortionMeasure::Angle => d.q() - 1.0,
        };
        let mut values: Vec<f64> = self.faces.iter().map(of).collect();
        // A face without flat area says nothing.
        values.iter_mut().filter(|v| !v.is_finite()).for_each(|v| *v = 0.0);
        let whole: f64 = self.areas.iter().sum();
        let sum: f64 = values.iter().zip(&self.areas).map(|(v, a)| v * a).sum();
        if measure != DistortionMeasure::Angle && whole > 0.0 {
            values.iter_mut().for_each(|v| *v -= sum / whole);
        }
        to_vertices(surface, &values, &self.areas)
    }
}

/// The value below which a given fraction of the weight lies; `rated`: value and weight, sorted by value.
pub fn percentile(rated: &[(f64, f64)], part: f64) -> f64 {
    let whole: f64 = rated.iter().map(|r| r.1).sum();
    let mut sum = 0.0;
    for &(value, weight) in rated {
        sum += weight;
        if sum >= part * whole {
            return value;
        }
    }
    rated.last().map_or(0.0, |r| r.0)
}

/// Means over the faces around every vertex, by area.
fn to_vertices(surface: &Surface, values: &[f64], areas: &[f64]) -> Vec<f64> {
    let mut sums = vec![(0.0, 0.0); surface.positions().len()];
    for ((face, &value), &area) in surface.connectivity().faces().iter().zip(values).zip(areas) {
        for v in face.iter().filter(|_| value.is_finite()) {
            sums[v.index()].0 += area * value;
            sums[v.index()].1 += area;
        }
    }
    sums.into_iter().map(|(sum, area)| if area > 0.0 { sum / area } else { 0.0 }).collect()
}
