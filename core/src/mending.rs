//! Places that a delivered path leaves too high, and detours over them.
//!
//! Level curves know the strip of a tilted flat bottom to second order, and where it ends half a side step
//! beside them. Where they turn sharply, meet the boundary at a small angle, or end beside others that run
//! another way, what is left is measured on the path itself.
//!
//! - *Height* of a sample of the surface: how far along its normal the lowest position of the bottom is.
//! - *Detour*: from the nearest place of a pass to the rear of a high place, along it facing the way of the
//!   pass, and back.
//!
//! 1. The bottom, a disc, goes straight from each point of the path to the next; the samples that it covers
//!    are as high as it is at the lowest.
//! 2. The highest sample gets a detour along those about it that are too high; then the highest of the others.

use crate::cutter_location::RaisedStretch;
use crate::flat_path::FlatPoint;
use crate::flatten::{Chart, Locator};
use crate::geometry::disc::{Disc, lowest};
use crate::geometry::math::cbrt;
use crate::geometry::{DVec2, DVec3};
use crate::mesh::FaceId;
use crate::parallel;
use crate::surface::Surface;
use crate::toolpath::{MoveKind, PathPoint};

/// Distance of samples, side steps. Larger: high places are overlooked; smaller: slower, with its square.
const SPACING: f64 = 0.05;
/// How much denser samples are beside the boundary, where places are small.
const RIM: f64 = 4.0;
/// How far beside the highest sample, side steps, others belong to its detour, and how far ahead and behind.
const GROUP: [f64; 2] = [0.25, 1.5];
/// How far beside a detour, side steps, nothing is high any more.
const SWEPT: f64 = 0.4;
/// How far a detour goes on ahead of the last sample, side steps: the edge of the strip lags.
const AHEAD: f64 = 0.05;
/// Part of the way to the boundary that a detour goes on at most. More: rounding leads it outside.
const WITHIN: f64 = 0.98;
/// Farthest that what the bottom stands over is from its middle, radii: it stands less than half of one high.
const NEAR: f64 = 1.1;
/// Longest part of a move, mm, on which heights change evenly while the axis turns.
const LONGEST: f64 = 0.6;
/// Most detours. More: it is not single places that are too high.
const MOST_DETOURS: usize = 2000;
/// Size of the cells in which samples lie, radii. Larger: more of them are looked at in vain; smaller: more cells.
const CELL: f64 = 0.5;
/// Most cells of a grid.
const MOST_CELLS: f64 = 2e6;
/// Most samples; larger surfaces get fewer.
const MOST_SAMPLES: f64 = 4e6;

/// What is to be kept.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct MendOptions {
    /// Radius of the flat bottom, mm.
    pub radius: f64,
    /// Distance of passes, mm.
    pub side_step: f64,
    /// What is higher is gone over again, mm.
    pub limit: f64,
    /// Threads to use; the detours do not depend on it.
    pub threads: usize,
}

/// A place of the surface.
#[derive(Copy, Clone)]
struct Sample {
    at: DVec3,
    normal: DVec3,
    flat: DVec2,
    /// mm per flat mm.
    scale: f64,
}

/// The samples of a surface, by cells.
pub struct Mender<'a> {
    options: MendOptions,
    locator: &'a Locator<'a>,
    samples: Vec<Sample>,
    low: DVec3,
    cell: f64,
    counts: [usize; 3],
    /// First sample of each cell, and the number of all.
    starts: Vec<usize>,
}

impl<'a> Mender<'a> {
    /// For a surface and its chart; `locator`: over its flat faces.
    pub fn new(
        surface: &Surface,
        chart: &Chart,
        locator: &'a Locator<'a>,
        options: MendOptions,
    ) -> Self {
        let samples = samples(surface, chart, options.side_step * SPACING);
        let low = samples.iter().map(|s| s.at).fold(DVec3::INFINITY, DVec3::min);
        let high = samples.iter().map(|s| s.at).fold(DVec3::NEG_INFINITY, DVec3::max);
        let size = (high - low).max(DVec3::splat(options.radius));
        let cell = (CELL * options.radius).max(cbrt(size.x * size.y * size.z / MOST_CELLS));
        let counts = [size.x, size.y, size.z].map(|s| (s / cell) as usize + 1);
        let mut grid = Self { options, locator, samples, low, cell, counts, starts: Vec::new() };
        grid.sort();
        grid
    }

    /// Puts the samples in the order of their cells.
    fn sort(&mut self) {
        let mut by_cell: Vec<(usize, Sample)> =
            self.samples.iter().map(|s| (self.index(self.cell_of(s.at)), *s)).collect();
        by_cell.sort_by_key(|(cell, _)| *cell);
        let [x, y, z] = self.counts;
        self.starts = (0..=x * y * z).map(|c| by_cell.partition_point(|(i, _)| *i < c)).collect();
        self.samples = by_cell.into_iter().map(|(_, sample)| sample).collect();
    }

    fn cell_of(&self, at: DVec3) -> [usize; 3] {
        let place = (at - self.low) / self.cell;
        let [x, y, z] = self.counts;
        [(place.x, x), (place.y, y), (place.z, z)].map(|(p, n)| (p.max(0.0) as usize).min(n - 1))
    }

    fn index(&self, [x, y, z]: [usize; 3]) -> usize {
        (z * self.counts[1] + y) * self.counts[0] + x
    }

    /// The flat path with detours over what the path that it became leaves too high; `None` where nothing is.
    ///
    /// What is low enough is forgotten: detours only take more.
    pub fn mended(
        &mut self,
        flat: &[FlatPoint],
        path: &[PathPoint],
        raised: &[RaisedStretch],
    ) -> Option<Vec<FlatPoint>> {
        let heights = self.heights(path);
        // Where the cutter does not fit it cannot come lower.
        let fits = |s: &Sample| raised.iter().all(|r| r.place.distance(s.at) > self.options.radius);
        let is_high = |i: &usize| heights[*i] > self.options.limit && fits(&self.samples[*i]);
        let mut high: Vec<usize> = (0..heights.len()).filter(is_high).collect();
        high.sort_by(|&a, &b| heights[b].total_cmp(&heights[a]));
        let still: Vec<Sample> = high.iter().map(|&i| self.samples[i]).collect();
        let mut detours: Vec<(usize, [DVec2; 2])> = Vec::new();
        while let Some(&worst) = high.first() {
            let Some((from, heading)) = nearest(flat, self.samples[worst].flat) else { break };
            if detours.len() == MOST_DETOURS {
                break;
            }
            detours.push((from, self.detour(&mut high, heading)));
        }
        self.samples = still;
        self.sort();
        (!detours.is_empty()).then(|| with_detours(flat, detours))
    }

    /// Along the samples about the first one, which, and all beside, are done with.
    fn detour(&self, high: &mut Vec<usize>, heading: DVec2) -> [DVec2; 2] {
        let Sample { flat: origin, scale, .. } = self.samples[high[0]];
        let steps = scale / self.options.side_step;
        let place = |i: usize| {
            let way = (self.samples[i].flat - origin) * steps;
            (way.dot(heading), way.perp_dot(heading).abs())
        };
        let [beside, ahead] = GROUP;
        let group = high.iter().map(|&i| place(i));
        let group = group.filter(|(along, across)| along.abs() <= ahead && *across <= beside);
        let (rear, front) = group.fold((0.0f64, 0.0f64), |(r, f), (a, _)| (r.min(a), f.max(a)));
        let front = front + AHEAD;
        let is_left = |(along, across): (f64, f64)| along < rear || along > front || across > SWEPT;
        high.retain(|&i| is_left(place(i)));
        [rear, front].map(|along| self.within(origin, origin + heading * (along / steps)))
    }

    /// The end of the straight flat way from a place of the chart, or where it is still on the chart.
    fn within(&self, from: DVec2, to: DVec2) -> DVec2 {
        let Ok(start) = self.locator.locate(from) else { return from };
        match self.locator.walk(start.face, from, to, |_, _| {}) {
            Ok(_) => to,
            Err(outside) => from.lerp(outside.uv, WITHIN),
        }
    }

    /// The height of every sample over the surface, mm; infinite where nothing comes.
    fn heights(&self, path: &[PathPoint]) -> Vec<f64> {
        // From afar the cutter arrives from above, and may turn.
        let is_near = |w: &[PathPoint]| w[0].tip.distance(w[1].tip) <= self.options.radius;
        let cuts = |w: &&[PathPoint]| match w[1].kind {
            MoveKind::Rapid => false,
            MoveKind::Link => is_near(w),
            _ => true,
        };
        let moves: Vec<&[PathPoint]> = path.windows(2).filter(cuts).collect();
        let share = moves.len().div_ceil(self.options.threads.max(1)).max(1);
        let shares: Vec<&[&[PathPoint]]> = moves.chunks(share).collect();
        let lowest = |mut all: Vec<f64>, part: Vec<f64>| {
            all.iter_mut().zip(part).for_each(|(height, of_part)| *height = height.min(of_part));
            all
        };
        let parts = parallel::map(self.options.threads, &shares, |moves| self.heights_of(moves));
        let none = || vec![f64::INFINITY; self.samples.len()];
        parts.into_iter().reduce(lowest).unwrap_or_else(none)
    }

    /// The same for some of the moves.
    fn heights_of(&self, moves: &[&[PathPoint]]) -> Vec<f64> {
        let mut heights = vec![f64::INFINITY; self.samples.len()];
        for w in moves {
            let n = (w[0].tip.distance(w[1].tip) / LONGEST).ceil().clamp(1.0, 1e4) as usize;
            let at = |k: usize| between(&w[0], &w[1], k as f64 / n as f64);
            (0..n).for_each(|k| self.lower(&mut heights, &at(k), &at(k + 1)));
        }
        heights
    }

    /// Lowers the samples that a move goes over.
    fn lower(&self, heights: &mut [f64], from: &PathPoint, to: &PathPoint) {
        let radius = DVec3::splat(self.options.radius);
        let low = self.cell_of(from.tip.min(to.tip) - radius);
        let high = self.cell_of(from.tip.max(to.tip) + radius);
        // Samples farther from the middle of the move are neither under the bottom nor near to it.
        let middle = 0.5 * (from.tip + to.tip);
        let reach = NEAR * self.options.radius + 0.5 * from.tip.distance(to.tip);
        let is_near = |sample: &Sample| sample.at.distance_squared(middle) <= reach * reach;
        for z in low[2]..=high[2] {
            for y in low[1]..=high[1] {
                let first = self.starts[self.index([low[0], y, z])];
                let last = self.starts[self.index([high[0], y, z]) + 1];
                let all = self.samples[first..last].iter().zip(&mut heights[first..last]);
                for (sample, height) in all.filter(|(sample, _)| is_near(sample)) {
                    if let Some(h) = sample.height([from, to], self.options.radius) {
                        *height = height.min(h);
                    }
                }
            }
        }
    }
}

impl Sample {
    /// How low the bottom comes over the sample on a move, mm; `None` where it does not cover it.
    fn height(&self, ends: [&PathPoint; 2], radius: f64) -> Option<f64> {
        let discs = ends.map(|p| Disc { middle: p.tip, axis: p.axis });
        lowest(discs, radius, self.at, self.normal)
    }
}

/// The cutter at a part of a move.
fn between(from: &PathPoint, to: &PathPoint, part: f64) -> PathPoint {
    let axis = from.axis.lerp(to.axis, part).normalize_or(to.axis);
    PathPoint { tip: from.tip.lerp(to.tip, part), axis, ..*to }
}

/// Samples evenly over all faces, about `spacing` mm apart, of the smooth surface that these stand for.
fn samples(surface: &Surface, chart: &Chart, spacing: f64) -> Vec<Sample> {
    let share = (spacing * spacing).max(surface.area() / MOST_SAMPLES);
    let (mut out, mut due) = (Vec::new(), 0.0);
    for (f, face) in surface.connectivity().faces().iter().enumerate() {
        let corners = surface.corners(FaceId(f as u32));
        let normals = face.map(|v| surface.vertex_normals()[v.index()]);
        let uv = face.map(|v| chart.uv()[v.index()]);
        let [a, b, c] = corners;
        let area = 0.5 * (b - a).cross(c - a).length();
        let flat = 0.5 * (uv[1] - uv[0]).perp_dot(uv[2] - uv[0]).abs();
        let is_rim = face.iter().any(|v| surface.connectivity().is_boundary(*v));
        let share = if is_rim { share / RIM } else { share };
        let n = (area / share).sqrt().ceil().clamp(1.0, 1e3) as usize;
        for weights in thirds(n) {
            due += area / (n * n) as f64;
            if due < share {
                continue;
            }
            due -= share;
            let at: DVec3 = (0..3).map(|i| corners[i] * weights[i]).sum();
            // Half way to the tangent planes: on a parabola.
            let tangent = |i: usize| normals[i] * (corners[i] - at).dot(normals[i]) * weights[i];
            out.push(Sample {
                at: at + 0.5 * (0..3).map(tangent).sum::<DVec3>(),
                normal: (0..3).map(|i| normals[i] * weights[i]).sum::<DVec3>().normalize_or_zero(),
                flat: (0..3).map(|i| uv[i] * weights[i]).sum(),
                scale: (area / flat).sqrt(),
            });
        }
    }
    out
}

/// Weights of the corners at the middles of the `n²` equal parts of a triangle.
fn thirds(n: usize) -> impl Iterator<Item = [f64; 3]> {
    let weights = move |i: usize, j: usize, part: f64| {
        let (u, v) = ((i as f64 + part) / n as f64, (j as f64 + part) / n as f64);
        [1.0 - u - v, u, v]
    };
    (0..n).flat_map(move |i| {
        (0..n - i).flat_map(move |j| {
            let down = (i + j + 1 < n).then(|| weights(i, j, 2.0 / 3.0));
            core::iter::once(weights(i, j, 1.0 / 3.0)).chain(down)
        })
    })
}

/// The point of a pass nearest to a flat place, by index, and the way that the cutter faces there.
fn nearest(flat: &[FlatPoint], place: DVec2) -> Option<(usize, DVec2)> {
    let on_pass = flat.iter().enumerate().filter(|(_, p)| p.kind == MoveKind::Cut);
    let facing = on_pass.filter_map(|(i, p)| Some((i, p.at, p.heading?)));
    let square = |p: &DVec2| p.distance_squared(place);
    let found = facing.min_by(|a, b| square(&a.1).total_cmp(&square(&b.1)));
    found.map(|(i, _, heading)| (i, heading))
}

/// The path with ways out to both points and back after the points of these indices.
fn with_detours(flat: &[FlatPoint], mut detours: Vec<(usize, [DVec2; 2])>) -> Vec<FlatPoint> {
    detours.sort_by_key(|(from, _)| *from);
    let mut next = detours.into_iter().peekable();
    let mut out = Vec::new();
    for (i, point) in flat.iter().enumerate() {
        out.push(*point);
        while let Some((_, [rear, front])) = next.next_if(|(from, _)| *from == i) {
            out.extend([rear, front, point.at].map(|at| FlatPoint { at, overrun: 0.0, ..*point }));
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::math::{cos, sin};
    use crate::job::{Component, Selection, SurfaceOptions, SurfaceSource};
    use crate::surface::{AnalyticSurface, build};

    const RADIUS: f64 = 2.5;
    const LEAD: f64 = 0.1;
    const HALF: f64 = 5.0;

    /// A point of the path at which the bottom touches the plane, going along x.
    fn touching(at: DVec2, kind: MoveKind) -> PathPoint {
        let contact_to_tip = DVec3::new(-cos(LEAD), 0.0, sin(LEAD)) * RADIUS;
        PathPoint {
            kind,
            pass: 0,
            region: 0,
            tip: at.extend(0.0) + contact_to_tip,
            axis: DVec3::new(sin(LEAD), 0.0, cos(LEAD)),
            normal: DVec3::Z,
            flat: Some(at),
            feed: 10.0,
            mrr: 0.0,
            alpha: 0.0,
            time: 0.0,
        }
    }

    /// How high the bottom's edge is so far beside the contact.
    fn lag(beside: f64) -> f64 {
        (RADIUS - (RADIUS * RADIUS - beside * beside).sqrt()) * sin(LEAD)
    }

    #[test]
    fn the_edge_of_a_tilted_bottom_leaves_its_lag() {
        let [from, to] = [-HALF, HALF].map(|x| touching(DVec2::new(x, 0.0), MoveKind::Cut));
        for beside in [0.0, 0.4, 1.1, 2.3] {
            let (at, normal) = (DVec3::new(0.3, beside, 0.0), DVec3::Z);
            let sample = Sample { at, normal, flat: DVec2::ZERO, scale: 1.0 };
            let height = sample.height([&from, &to], RADIUS).unwrap();
            assert!((height - lag(beside)).abs() < 1e-12, "{beside}: {height}");
        }
        let aside = DVec3::new(0.0, RADIUS + 0.01, 0.0);
        let sample = Sample { at: aside, normal: DVec3::Z, flat: DVec2::ZERO, scale: 1.0 };
        assert_eq!(sample.height([&from, &to], RADIUS), None);
    }

    /// Passes along x and beyond the square, with points half a millimetre apart.
    fn passes(ys: &[f64]) -> Vec<FlatPoint> {
        let point = |y: f64, i: i32| FlatPoint {
            at: DVec2::new(0.5 * f64::from(i), y),
            height: 0.0,
            kind: if i == -12 { MoveKind::Link } else { MoveKind::Cut },
            pass: 0,
            region: 0,
            feed: 10.0,
            mrr: 0.0,
            alpha: 0.0,
            length: 0.5,
            heading: Some(DVec2::X),
            overrun: 0.0,
        };
        ys.iter().flat_map(|&y| (-12..=12).map(move |i| point(y, i))).collect()
    }

    #[test]
    fn a_missing_pass_is_made_up_for() {
        let side_step = 1.0;
        let size = 2.0 * HALF;
        let options = SurfaceOptions {
            source: SurfaceSource::File(String::new()),
            scale: 1.0,
            rotate: DVec3::ZERO,
            translate: DVec3::ZERO,
            select: Selection { component: Component::Only, ..Selection::default() },
            curvature_radius: None,
            chord: None,
            face: None,
            flip: false,
        };
        let plane = AnalyticSurface::Plane { width: size, depth: size };
        let surface = build(plane.mesh(1.0), &options).unwrap().surface;
        let flat = surface.positions().iter().map(|p| p.truncate()).collect();
        let chart = Chart::new(&surface, flat);
        let locator = Locator::new(surface.connectivity(), chart.uv());
        let limit = 0.5 * (lag(0.5 * side_step) + lag(side_step));
        let options = MendOptions { radius: RADIUS, side_step, limit, threads: 2 };
        let mended = |ys: &[f64]| {
            let mut mender = Mender::new(&surface, &chart, &locator, options);
            let mut flat = passes(ys);
            let mut rounds = 0;
            loop {
                let path: Vec<_> = flat.iter().map(|p| touching(p.at, p.kind)).collect();
                match mender.mended(&flat, &path, &[]) {
                    Some(more) if rounds < 4 => flat = more,
                    left => return (flat, rounds, left.is_none()),
                }
                rounds += 1;
            }
        };
        let all: Vec<f64> = (-5..=5).map(f64::from).map(|y| 0.98 * y).collect();
        let (flat, rounds, is_kept) = mended(&all);
        assert!(is_kept && rounds == 0, "{rounds} rounds, {} points", flat.len());
        let gap: Vec<f64> = all.iter().copied().filter(|y| *y != 0.0).collect();
        let (flat, rounds, is_kept) = mended(&gap);
        assert!(is_kept && rounds > 0, "{rounds} rounds");
        let added = flat.len() - passes(&gap).len();
        let in_gap = flat.iter().filter(|p| p.at.y.abs() < 0.5).count();
        assert!(in_gap >= 8 && added <= 4 * in_gap, "{in_gap} of {added}");
    }
}
