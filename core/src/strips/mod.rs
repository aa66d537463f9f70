//! Width of the strips all over a surface, for a job.
//!
//! On a mesh whose facets are as long as strips are wide the curvature is concentrated in creases: the strips are
//! those of the facets, not of the smooth surface that the mesh approximates.

mod budget;
mod upright;

pub use budget::CuspBudget;

use crate::cutter_location::is_level;
use crate::flatten::Chart;
use crate::footprint::StripTable;
use crate::geometry::DVec3;
use crate::job::{ForceControl, Job, Stepover};
use crate::level_set::{StripMetric, length_floor_of, strip_metric};
use crate::mesh::{FaceId, VertexId};
use crate::surface::{CurvatureField, ShapeOperator, Surface};
use upright::Upright;

/// Fraction of the strip width at which passes are spaced: the distance field is accurate to a few thousandths of it,
/// and the cusp height grows with its square.
const SHARE_OF_STRIP: f64 = 0.9975;
/// Fraction of the limit on the removal rate that a straight pass uses at most; bends use more.
const SHARE_OF_LIMIT: f64 = 0.8;
/// Edges shorter than this fraction of a strip do not concentrate the curvature in creases.
const FINE_FACET: f64 = 0.6;

/// The strips of a surface.
pub struct Strips {
    /// The strip metric at each of the `#V` vertices.
    pub metrics: Vec<StripMetric>,
    /// By what factor creases make the shortest path longer.
    pub creases: f64,
    /// The spacing of passes as a fraction of the widest that the limit allows, on a plane.
    pub spacing: f64,
}

impl Strips {
    /// Strips that leave the cusps, or have the width of the side step, that the job specifies.
    pub fn of(
        job: &Job,
        cusps: &CuspBudget,
        surface: &Surface,
        chart: &Chart,
        curvature: &CurvatureField,
    ) -> Self {
        if let Stepover::Fixed(side_step) = job.cut.stepover {
            let metrics = vec![strip_metric::even(side_step); surface.positions().len()];
            return Self { metrics, creases: 1.0, spacing: 1.0 };
        }
        let facets = facets(surface, curvature);
        let level = level(surface);
        let metrics = |facets: &[f64]| metrics(job, cusps, curvature, facets, &level);
        let smooth = metrics(&vec![0.0; facets.len()]);
        let metrics = metrics(&facets);
        let floor = |metrics: &[StripMetric]| length_floor_of(surface, chart, metrics);
        let on_plane = |h: f64| job.footprint().width(h, 0.0, 0.0);
        Self {
            creases: floor(&metrics) / floor(&smooth),
            spacing: SHARE_OF_STRIP * on_plane(cusps.aimed) / on_plane(cusps.limit),
            metrics,
        }
    }
}

/// The strip metric at every vertex, if facets are `facets` mm long there. `level`: which vertices lie in level planes.
fn metrics(
    job: &Job,
    cusps: &CuspBudget,
    curvature: &CurvatureField,
    facets: &[f64],
    level: &[bool],
) -> Vec<StripMetric> {
    let (operators, footprint, cusp) = (curvature.operators(), job.footprint(), cusps.aimed);
    let width = footprint.width(cusp, 0.0, 0.0);
    let bends = operators.iter().zip(facets).map(|(o, facet)| {
        let (low, high, _) = o.principal();
        (low, gathered(high, facet / width))
    });
    let (low, high) = bends.fold((0.0f64, 0.0f64), |(l, h), (a, b)| (l.min(a), h.max(b)));
    // Where the surface is as concave as the cutter is convex the strip is as wide as it gets.
    let table = StripTable::new(&footprint, cusp, low.max(-footprint.k_tool()), high);
    let upright = Upright { footprint, cusp, widest: widest(job) };
    let of_vertex = |((shape, facet), level): ((&ShapeOperator, &f64), &bool)| {
        let bent = |k: f64| gathered(k, facet / width);
        let on_plane = level.then(|| upright.on_plane()).flatten();
        let metric = on_plane.or_else(|| upright.metric(shape, bent, |k| table.weight(k, 0.0)));
        let on_both_sides =
            || strip_metric::of_scallop(shape, |k, along| table.weight(bent(k), along));
        metric.unwrap_or_else(on_both_sides).map(|m| m / (SHARE_OF_STRIP * SHARE_OF_STRIP))
    };
    operators.iter().zip(facets).zip(level).map(of_vertex).collect()
}

/// The widest strip that a straight pass may remove at full feed, mm, but never less than the job's own.
fn widest(job: &Job) -> f64 {
    match job.force.control {
        ForceControl::Off => f64::INFINITY,
        ForceControl::Trochoid | ForceControl::Feed | ForceControl::Fastest => {
            let allowed = job.load().at_full_feed(job.cut.feed) / job.cut.axial_depth;
            (SHARE_OF_LIMIT * allowed).max(job.nominal_side_step())
        }
    }
}

/// The curvature across strips on a mesh whose facets are `facet` strips long: between creases there is none, and a
/// strip across a crease has the curvature of the whole facet.
fn gathered(k: f64, facet: f64) -> f64 {
    let share = ((facet - FINE_FACET) / (1.0 - FINE_FACET)).clamp(0.0, 1.0);
    let most = if k < 0.0 { 0.0 } else { facet.max(1.0) };
    k * (1.0 + share * (most - 1.0))
}

/// Which vertices have level faces alone around them.
fn level(surface: &Surface) -> Vec<bool> {
    let mut out = vec![true; surface.positions().len()];
    for (f, face) in surface.connectivity().faces().iter().enumerate() {
        let [a, b, c] = surface.corners(FaceId(f as u32));
        if !is_level((b - a).cross(c - a).normalize_or_zero(), DVec3::Z) {
            face.iter().for_each(|v| out[v.index()] = false);
        }
    }
    out
}

/// Mean length of the edges at every vertex, mm; 0 where the surface is smooth and its mesh an image of it, and where its
/// curvature is that of its normals.
fn facets(surface: &Surface, curvature: &CurvatureField) -> Vec<f64> {
    let mut sums = vec![(0.0, 0u32); surface.positions().len()];
    if surface.parameters().is_none() {
        for face in surface.connectivity().faces() {
            for (a, b) in [(0, 1), (1, 2), (2, 0)].map(|(i, j)| (face[i], face[j])) {
                let length =
                    surface.positions()[a.index()].distance(surface.positions()[b.index()]);
                for v in [a, b] {
                    let (sum, count) = sums[v.index()];
                    sums[v.index()] = (sum + length, count + 1);
                }
            }
        }
    }
    let of_vertex = |(v, (sum, count)): (usize, (f64, u32))| match VertexId(v as u32) {
        v if curvature.is_of_normals(v) => 0.0,
        _ => sum / f64::from(count.max(1)),
    };
    sums.into_iter().enumerate().map(of_vertex).collect()
}

#[cfg(test)]
mod tests {
    use super::gathered;

    /// Facets that are small against strips bend as the surface does; on facets as long as a strip a valley is
    /// flat, and a ridge has all of its bend in the creases.
    #[test]
    fn creases_gather_curvature() {
        for k in [-0.1, 0.1] {
            assert_eq!(gathered(k, 0.0), k);
            assert_eq!(gathered(k, 0.6), k);
        }
        assert_eq!(gathered(-0.1, 1.0), 0.0);
        assert_eq!(gathered(0.1, 2.0), 0.2);
    }
}
