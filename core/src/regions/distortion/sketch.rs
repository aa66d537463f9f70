//! Candidate cuts of a piece.

use super::flattened::Flattened;
use super::measure::percentile;
use crate::geometry::math::{atan2, cos, sin};
use crate::geometry::{DVec2, OrderBy, cross2};
use crate::job::DistortionOptions;
use crate::mesh::{FaceId, HalfEdgeId, VertexId};

/// Length over which the measure is smoothed, as a fraction of the side of a square of the least area. Larger: cuts
/// miss the bumps; smaller: they follow the noise of a scan.
const NOISE: f64 = 0.2;
/// Length over which outlines are smoothed, as a fraction of the side of a square of the piece's area. Larger: they
/// miss the bumps; smaller: ragged.
const OUTLINE: f64 = 0.06;
/// Quantiles of the measure, by area, that are tried as thresholds.
const SHARES: [f64; 3] = [0.5, 0.25, 0.75];
/// Rounds of smoothing, at least and at most.
const ROUNDS: (f64, f64) = (4.0, 400.0);

/// A function at the `#V` vertices of a piece whose isoline at 0 is the cut.
#[derive(Clone, Debug)]
pub struct Cut(pub Vec<f64>);

/// The candidate cuts: the measure at its threshold and at its quartiles, and straight ones.
pub fn sketches(piece: &Flattened, options: &DistortionOptions, least: f64) -> Vec<Cut> {
    let measure = piece.stretch.measure(&piece.surface, options.measure);
    let smoothing = Smoothing::of(piece);
    let measure = smoothing.smoothed(measure.into_iter().map(|e| [e]), NOISE * least.sqrt());
    let measure: Vec<f64> = measure.into_iter().map(|[e]| e).collect();
    let outline = OUTLINE * piece.surface.area().sqrt();
    let [low, half, high] = shares(piece, &measure);
    let levels = [options.threshold, low, half, high];
    let sides = |e: &f64| levels.map(|level| if *e > level { 1.0 } else { -1.0 });
    // The sides smoothed, and not the measure alone, have a smooth border wherever it is nearly even.
    let sides = smoothing.smoothed(measure.iter().map(sides), outline);
    let isoline = |i: usize| Cut(sides.iter().map(|values| values[i]).collect());
    (0..levels.len()).map(isoline).chain(straight(piece)).collect()
}

/// Averages functions of the vertices of a piece.
struct Smoothing {
    /// The neighbours of all vertices, one vertex after the other.
    neighbours: Vec<u32>,
    /// Where those of each vertex begin, and where the last ones end.
    begins: Vec<usize>,
    /// Side of the mean triangle, mm.
    side: f64,
}

impl Smoothing {
    fn of(piece: &Flattened) -> Self {
        let connectivity = &piece.piece.connectivity;
        let mut begins = vec![0];
        let mut neighbours = Vec::with_capacity(4 * connectivity.face_count());
        let mut lists = vec![Vec::new(); connectivity.vertex_count()];
        for h in (0..3 * connectivity.face_count() as u32).map(HalfEdgeId) {
            let (a, b) = connectivity.ends(h);
            // Inner sides are met twice, once from each end.
            lists[a.index()].push(b.0);
            if connectivity.opposite(h).is_none() {
                lists[b.index()].push(a.0);
            }
        }
        for list in lists {
            neighbours.extend(list);
            begins.push(neighbours.len());
        }
        let count = connectivity.face_count().max(1) as f64;
        Self { neighbours, begins, side: (2.3 * piece.surface.area() / count).sqrt() }
    }

    /// `N` functions of the vertices, averaged over about `reach` mm.
    fn smoothed<const N: usize>(
        &self,
        values: impl Iterator<Item = [f64; N]>,
        reach: f64,
    ) -> Vec<[f64; N]> {
        let mut values: Vec<[f64; N]> = values.collect();
        let mut next = values.clone();
        // A round spreads values by half the square of a side.
        let rounds = 2.0 * (reach / self.side) * (reach / self.side);
        for _ in 0..rounds.clamp(ROUNDS.0, ROUNDS.1) as usize {
            self.average(&values, &mut next);
            core::mem::swap(&mut values, &mut next);
        }
        values
    }

    /// Half of every value, and half of the mean of its neighbours.
    fn average<const N: usize>(&self, values: &[[f64; N]], out: &mut [[f64; N]]) {
        for (v, (mean, value)) in out.iter_mut().zip(values).enumerate() {
            let around = &self.neighbours[self.begins[v]..self.begins[v + 1]];
            let mut sums = [0.0; N];
            for &w in around {
                (0..N).for_each(|i| sums[i] += values[w as usize][i]);
            }
            let count = around.len() as f64;
            let half = |i: usize| 0.5 * (value[i] + sums[i] / count);
            *mean = if around.is_empty() { *value } else { core::array::from_fn(half) };
        }
    }
}

/// The values below which a given fraction of the area lies.
fn shares(piece: &Flattened, values: &[f64]) -> [f64; 3] {
    let of_face = |f: u32| {
        let [a, b, c] = piece.surface.corners(FaceId(f));
        let face = piece.piece.connectivity.face(FaceId(f));
        let mean = face.iter().map(|v| values[v.index()]).sum::<f64>() / 3.0;
        (mean, 0.5 * (b - a).cross(c - a).length())
    };
    let count = piece.piece.connectivity.face_count() as u32;
    let mut rated: Vec<(f64, f64)> = (0..count).map(of_face).collect();
    rated.order_by(|a, b| a.0.total_cmp(&b.0));
    SHARES.map(|share| percentile(&rated, share))
}

/// Straight across the longer extent of the flat piece, through the middle of its largest hole or of
/// itself; and along it.
fn straight(piece: &Flattened) -> Vec<Cut> {
    let uv = piece.chart.uv();
    let (middle, axis) = principal(piece);
    let through = largest_hole(piece).unwrap_or(middle);
    let across = |axis: DVec2| Cut(uv.iter().map(|p| (*p - through).dot(axis)).collect());
    vec![across(axis), across(axis.perp())]
}

/// Centroid of the flat piece and the direction in which it is longest.
fn principal(piece: &Flattened) -> (DVec2, DVec2) {
    let uv = piece.chart.uv();
    let triangle = |face: &[VertexId; 3]| {
        let [a, b, c] = face.map(|v| uv[v.index()]);
        ((a + b + c) / 3.0, cross2(a, b, c).abs())
    };
    let all = || piece.piece.connectivity.faces().iter().map(triangle);
    let area: f64 = all().map(|(_, a)| a).sum();
    let middle = all().map(|(p, a)| p * a).sum::<DVec2>() / area;
    let (mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0);
    for (p, a) in all() {
        let d = p - middle;
        (xx, xy, yy) = (xx + a * d.x * d.x, xy + a * d.x * d.y, yy + a * d.y * d.y);
    }
    let angle = 0.5 * atan2(2.0 * xy, xx - yy);
    (middle, DVec2::new(cos(angle), sin(angle)))
}

/// The middle of the largest hole of the flat piece.
fn largest_hole(piece: &Flattened) -> Option<DVec2> {
    let uv = piece.chart.uv();
    let loops = piece.piece.connectivity.boundary_loops();
    let area = |l: &[VertexId]| {
        let at = |i: usize| uv[l[i % l.len()].index()];
        (0..l.len()).map(|i| at(i).perp_dot(at(i + 1))).sum::<f64>()
    };
    // Holes run clockwise.
    let holes = loops.iter().filter(|l| area(l) < 0.0);
    let largest = holes.min_by(|a, b| area(a).total_cmp(&area(b)))?;
    let sum: DVec2 = largest.iter().map(|v| uv[v.index()]).sum();
    Some(sum / largest.len() as f64)
}
