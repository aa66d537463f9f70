//! Places that a delivered path leaves too high, and detours over them.
//!
//! Level curves know the strip of a cutter with a flat bottom to second order, and where it ends half a side
//! step beside them. Where they turn sharply, meet the boundary at a small angle, or end beside others that run
//! another way, what is left is measured on the path itself.
//!
//! - *Height* of a sample of the surface: how far along its normal the cutter is at the lowest.
//! - *Detour*: from the nearest place of a pass to the rear of a high place, along it facing the way of the
//!   pass, and back.
//!
//! 1. The cutter goes straight from each point of the path to the next; the samples that it covers are as high
//!    as it is at the lowest.
//! 2. The highest sample gets a detour along those about it that are too high; then the highest of the others.

use crate::cutter_location::{Obstacles, PassOptions, is_in_wall, raise_at};
use crate::flat_path::FlatPoint;
use crate::flatten::{Chart, Locator};
use crate::geometry::{DVec2, DVec3};
use crate::mesh::{FaceId, VertexId};
use crate::parallel;
use crate::removal::{Columns, Cutter, FeedIndex, Layer, Line};
use crate::surface::{Surface, SurfacePoint};
use crate::toolpath::{MoveKind, Toolpath};
use std::collections::BTreeSet;

/// Distance of samples, side steps. Larger: high places are overlooked; smaller: slower, with its square.
const SPACING: f64 = 0.04;
/// Parts of the limit from which on there are more samples about one, and still more about each of those: between
/// samples of a sharp cusp as high as the limit none is lower.
const NEARLY: [f64; 2] = [0.85, 0.95];
/// More samples along and across each of those.
const FINER: u32 = 3;
/// Part of the place of one that those take: no detour comes to what lies on the boundary itself.
const INNER: f64 = 0.9;
/// How much denser samples are beside the boundary, where places are small.
const RIM: f64 = 4.0;
/// How far beside the highest sample, side steps, others belong to its detour, and how far ahead and behind.
const GROUP: [f64; 2] = [0.25, 1.5];
/// Part of a height that a detour is worth which lowers it to that where the cutter does not fit.
const WORTH: f64 = 0.5;
/// Size of the cells in each of which the cutter is tried at one sample, side steps. Smaller: slower.
const CELL: f64 = 0.1;
/// How far beside a detour, side steps, nothing is high any more.
const SWEPT: f64 = 0.4;
/// How far a detour goes on ahead of the last sample, side steps: the edge of the strip lags.
const AHEAD: f64 = 0.05;
/// Part of the way to the boundary that a detour goes on at most. More: rounding leads it outside.
const WITHIN: f64 = 0.98;
/// Heights that are told apart, limits: what is higher is as high.
const TOLD: f64 = 10.0;
/// Most detours. More: it is not single places that are too high.
const MOST_DETOURS: usize = 2000;
/// Most samples; larger surfaces get fewer.
const MOST_SAMPLES: f64 = 2e6;

/// What is to be kept.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct MendOptions {
    /// How the cutter stands.
    pub pass: PassOptions,
    /// Distance of passes, mm.
    pub side_step: f64,
    /// What is higher is gone over again, mm.
    pub limit: f64,
    /// How far behind the contact the edge of the strip is, mm: by that detours go on beyond the boundary.
    pub lag: f64,
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
    /// How far apart samples are here, mm.
    spacing: f64,
}

/// The samples of a surface.
pub struct Mender<'a> {
    options: MendOptions,
    surface: &'a Surface,
    chart: &'a Chart,
    locator: &'a Locator<'a>,
    obstacles: &'a Obstacles,
    /// Those that were not low enough, or all before that is known.
    samples: Vec<Sample>,
    is_fresh: bool,
}

impl<'a> Mender<'a> {
    /// For a surface and its chart; `locator`: over its flat faces; `obstacles`: the part.
    pub fn new(
        surface: &'a Surface,
        chart: &'a Chart,
        locator: &'a Locator<'a>,
        obstacles: &'a Obstacles,
        options: MendOptions,
    ) -> Self {
        let samples = Vec::new();
        let mut mender =
            Self { options, surface, chart, locator, obstacles, samples, is_fresh: true };
        mender.spread();
        mender
    }

    /// Samples evenly over all faces.
    fn spread(&mut self) {
        let asked = self.options.side_step * SPACING;
        let share = (asked * asked).max(self.surface.area() / MOST_SAMPLES);
        let mut due = 0.0;
        for face_id in self.faces_by_place() {
            let face = self.surface.connectivity().face(face_id);
            let [a, b, c] = self.surface.corners(face_id);
            let area = 0.5 * (b - a).cross(c - a).length();
            let is_rim = face.iter().any(|v| self.surface.connectivity().is_boundary(*v));
            let share = if is_rim { share / RIM } else { share };
            let n = (area / share).sqrt().ceil().clamp(1.0, 1e3) as usize;
            for weights in thirds(n) {
                due += area / (n * n) as f64;
                if due >= share {
                    due -= share;
                    let place = SurfacePoint { face: face_id, weights };
                    self.samples.push(self.sample(place, share.sqrt()));
                }
            }
        }
    }

    /// The faces in the order of a curve that fills squares of the chart one after the other (Morton 1966): where faces are
    /// smaller than samples are apart, every so many of them in turn leave no gaps.
    fn faces_by_place(&self) -> Vec<FaceId> {
        let uv = self.chart.uv();
        let fold = |f: fn(DVec2, DVec2) -> DVec2| uv.iter().copied().reduce(f).unwrap_or_default();
        let (low, high) = (fold(DVec2::min), fold(DVec2::max));
        let cells = f64::from(u16::MAX) / (high - low).max_element().max(f64::MIN_POSITIVE);
        // The bits of a number, every other one.
        let spread = |x: f64| (0..16).fold(0u32, |bits, i| bits | (x as u32 >> i & 1) << (2 * i));
        let key = |face: &[VertexId; 3]| {
            let middle = face.iter().map(|v| uv[v.index()]).sum::<DVec2>() / 3.0;
            let cell = (middle - low) * cells;
            spread(cell.x) | spread(cell.y) << 1
        };
        let faces = self.surface.connectivity().faces().iter().enumerate();
        let mut keyed: Vec<(u32, u32)> = faces.map(|(f, face)| (key(face), f as u32)).collect();
        keyed.sort_unstable();
        keyed.into_iter().map(|(_, f)| FaceId(f)).collect()
    }

    /// A sample on a face.
    fn sample(&self, SurfacePoint { face, weights }: SurfacePoint, spacing: f64) -> Sample {
        let corners = self.surface.corners(face);
        let vertices = self.surface.connectivity().face(face);
        let normals = vertices.map(|v| self.surface.vertex_normals()[v.index()]);
        let uv = vertices.map(|v| self.chart.uv()[v.index()]);
        let [a, b, c] = corners;
        let area = (b - a).cross(c - a).length();
        let flat = (uv[1] - uv[0]).perp_dot(uv[2] - uv[0]).abs();
        Sample {
            at: (0..3).map(|i| corners[i] * weights[i]).sum(),
            normal: (0..3).map(|i| normals[i] * weights[i]).sum::<DVec3>().normalize_or_zero(),
            flat: (0..3).map(|i| uv[i] * weights[i]).sum(),
            scale: (area / flat).sqrt(),
            spacing,
        }
    }

    /// Samples about one, closer to each other.
    fn about(&self, sample: &Sample) -> impl Iterator<Item = Sample> {
        let (spacing, of_one) = (sample.spacing, 1.0 / f64::from(FINER));
        let (middle, side) = (sample.flat, spacing / sample.scale);
        let offset = move |i: u32| INNER * ((f64::from(i) + 0.5) * of_one - 0.5);
        let places = (0..FINER * FINER)
            .map(move |i| middle + DVec2::new(offset(i % FINER), offset(i / FINER)) * side);
        places
            .filter_map(move |p| Some(self.sample(self.locator.locate(p).ok()?, spacing * of_one)))
    }

    /// The heights of all samples, with more of them where it is nearly too high.
    fn refined(&mut self, path: &Toolpath) -> Vec<f64> {
        let [nearly, more_nearly] = NEARLY.map(|part| part * self.options.limit);
        let mut heights = self.heights(&self.samples, path, nearly);
        // What the cutter cannot lower, as beside walls, is not looked at more closely.
        let to_lower: BTreeSet<usize> = self.to_lower(&heights, path).into_iter().collect();
        let limit = self.options.limit;
        for (i, height) in heights.iter_mut().enumerate() {
            if *height > limit && !to_lower.contains(&i) {
                *height = 0.0;
            }
        }
        let mut known = 0;
        for (nearly, enough) in [(nearly, more_nearly), (more_nearly, self.options.limit)] {
            let high = self.samples.iter().zip(&heights).skip(known);
            let high = high.filter(|(_, height)| **height > nearly);
            let more: Vec<Sample> = high.flat_map(|(sample, _)| self.about(sample)).collect();
            known = self.samples.len();
            heights.extend(self.heights(&more, path, enough));
            self.samples.extend(more);
        }
        heights
    }

    /// The flat path with detours over what the path that it became leaves too high; `None` where nothing is.
    ///
    /// What is low enough is forgotten: detours only take more.
    pub fn mended(&mut self, flat: &[FlatPoint], path: &Toolpath) -> Option<Vec<FlatPoint>> {
        let heights = match core::mem::take(&mut self.is_fresh) {
            true => self.refined(path),
            false => self.heights(&self.samples, path, self.options.limit),
        };
        let mut high = self.to_lower(&heights, path);
        high.sort_by(|&a, &b| heights[b].total_cmp(&heights[a]));
        let still: Vec<Sample> = high.iter().map(|&i| self.samples[i]).collect();
        let mut detours: Vec<Detour> = Vec::new();
        while let Some(&worst) = high.first() {
            let Some((from, heading)) = nearest(flat, self.samples[worst].flat) else { break };
            if detours.len() == MOST_DETOURS {
                break;
            }
            detours.push(self.detour(&mut high, from, heading));
        }
        self.samples = still;
        (!detours.is_empty()).then(|| with_detours(flat, detours))
    }

    /// The samples that are too high and can be lowered: where the cutter, if it is to touch there, comes low
    /// enough, or much lower than it did. The highest of a cell stands for all of it.
    fn to_lower(&self, heights: &[f64], path: &Toolpath) -> Vec<usize> {
        let MendOptions { pass, side_step, limit, threads, .. } = self.options;
        let cell = |i: usize| {
            (self.samples[i].at / (CELL * side_step)).to_array().map(|x| x.floor() as i64)
        };
        let high = (0..heights.len()).filter(|&i| heights[i] > limit);
        let mut high: Vec<([i64; 3], usize)> = high.map(|i| (cell(i), i)).collect();
        high.sort_by(|a, b| a.0.cmp(&b.0).then(heights[b.1].total_cmp(&heights[a.1])));
        let cells: Vec<&[([i64; 3], usize)]> = high.chunk_by(|a, b| a.0 == b.0).collect();
        let feeds = FeedIndex::new(path, pass.axis);
        let can_be_lowered = parallel::map(threads, &cells, |cell| {
            let Sample { at, normal, flat, .. } = self.samples[cell[0].1];
            let feed = feeds.nearest(flat);
            // No detour leads into a wall.
            if is_in_wall(at, normal, feed, &pass, self.obstacles) {
                return false;
            }
            let raise = raise_at(at, normal, feed, &pass, self.obstacles);
            raise <= limit.max(WORTH * heights[cell[0].1])
        });
        let lowered = cells.iter().zip(can_be_lowered).filter(|(_, can_be)| *can_be);
        lowered.flat_map(|(cell, _)| cell.iter().map(|c| c.1)).collect()
    }

    /// Along the samples about the first one, which, and all beside, are done with.
    fn detour(&self, high: &mut Vec<usize>, from: usize, heading: DVec2) -> Detour {
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
        let at = |along: f64| origin + heading * (along / steps);
        let (front, is_at_boundary) = self.within(origin, at(front));
        let overrun = if is_at_boundary { self.options.lag } else { 0.0 };
        // Beyond the boundary it goes on as before, so that there is to be as much before.
        let before = (front - origin).dot(heading) - overrun / scale;
        let (rear, _) = self.within(origin, at(rear.min(before * steps)));
        Detour { from, heading, rear, front, overrun }
    }

    /// The end of the straight flat way from a place of the chart, or where it is still on the chart, and whether
    /// it leaves it.
    fn within(&self, from: DVec2, to: DVec2) -> (DVec2, bool) {
        let Ok(start) = self.locator.locate(from) else { return (from, true) };
        match self.locator.walk(start.face, from, to, |_, _| {}) {
            Ok(_) => (to, false),
            Err(outside) => (from.lerp(outside.uv, WITHIN), true),
        }
    }

    /// The height that a path leaves on every sample, mm: exact above `enough`, elsewhere not below what is left.
    fn heights(&self, samples: &[Sample], path: &Toolpath, enough: f64) -> Vec<f64> {
        let MendOptions { pass, limit, threads, .. } = self.options;
        let cutter = Cutter { tool: pass.tool, length: pass.reach };
        let layer = Layer { stock: 0.0, depth: TOLD * limit };
        let line = |s: &Sample| (Line { foot: s.at, normal: s.normal }, s.flat);
        let lines: Vec<(Line, DVec2)> = samples.iter().map(line).collect();
        let (columns, ids) = Columns::on(&lines, layer.top());
        let path = near_links(path, cutter.tool.radius());
        let left = columns.remains(&path, cutter, layer, enough, threads);
        let mut heights = vec![0.0; lines.len()];
        ids.iter().zip(left.heights()).for_each(|(id, height)| heights[*id as usize] = height);
        heights
    }
}

/// The path on which links from afar do not cut: the cutter arrives from above, and may turn.
fn near_links(path: &Toolpath, radius: f64) -> Toolpath {
    let mut path = path.clone();
    for i in 1..path.points.len() {
        let way = path.points[i].tip.distance(path.points[i - 1].tip);
        if path.points[i].kind == MoveKind::Link && way > radius {
            path.points[i].kind = MoveKind::Rapid;
        }
    }
    path
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

/// The point of a pass nearest to a flat place, by index, and the way that the cutter faces or goes there.
fn nearest(flat: &[FlatPoint], place: DVec2) -> Option<(usize, DVec2)> {
    let square = |i: usize| flat[i].at.distance_squared(place);
    let way = |i: usize| {
        let before = (flat[i].at - flat[i.checked_sub(1)?].at).try_normalize();
        flat[i].heading.or(before)
    };
    let on_pass = (0..flat.len()).filter(|&i| flat[i].kind == MoveKind::Cut);
    let going = on_pass.filter(|&i| way(i).is_some());
    let found = going.min_by(|&a, &b| square(a).total_cmp(&square(b)))?;
    Some((found, way(found)?))
}

/// A way out from a point of the path over a high place and back.
struct Detour {
    /// Index of the point.
    from: usize,
    /// The way that the cutter faces.
    heading: DVec2,
    /// Where it begins, a flat place.
    rear: DVec2,
    /// Where it ends.
    front: DVec2,
    /// How far it goes on beyond the boundary there, mm.
    overrun: f64,
}

/// The path with detours.
fn with_detours(flat: &[FlatPoint], mut detours: Vec<Detour>) -> Vec<FlatPoint> {
    detours.sort_by_key(|detour| detour.from);
    let mut next = detours.into_iter().peekable();
    let mut out = Vec::new();
    for (i, point) in flat.iter().enumerate() {
        let facing = next.peek().filter(|detour| detour.from == i).map(|detour| detour.heading);
        let point = FlatPoint { heading: point.heading.or(facing), ..*point };
        out.push(point);
        while let Some(Detour { rear, front, overrun, .. }) = next.next_if(|d| d.from == i) {
            let ways = [(rear, 0.0), (front, overrun), (point.at, 0.0)];
            out.extend(ways.map(|(at, overrun)| FlatPoint { at, overrun, ..point }));
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cutter_location::{CheckMesh, ToolAxis};
    use crate::geometry::math::{cos, sin};
    use crate::job::{Component, Selection, SurfaceOptions, SurfaceSource};
    use crate::surface::{AnalyticSurface, build};
    use crate::tool::Tool;
    use crate::toolpath::PathPoint;

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
        let behind = lag(0.5 * side_step) / sin(LEAD);
        let options = MendOptions {
            pass: PassOptions {
                tool: Tool::new(RADIUS, 0.0).unwrap(),
                axis: ToolAxis::Lead(LEAD),
                axis_rate: f64::INFINITY,
                stock: 0.0,
                tolerance: 0.001,
                reach: f64::INFINITY,
            },
            side_step,
            limit,
            lag: behind,
            threads: 2,
        };
        let check = |roof: Option<f64>| {
            let (positions, mut faces) = surface.triangles();
            let roof = roof.map(|z| {
                [[-50.0, -0.2], [50.0, -0.2], [0.0, 2.0]].map(|[x, y]| DVec3::new(x, y, z))
            });
            let first = positions.len() as u32;
            faces.extend(roof.map(|_| [first, first + 1, first + 2]));
            Obstacles::of_part(CheckMesh::new(
                positions.iter().copied().chain(roof.into_iter().flatten()).collect(),
                faces,
            ))
        };
        let mended = |ys: &[f64], obstacles: &Obstacles| {
            let mut mender = Mender::new(&surface, &chart, &locator, obstacles, options);
            let mut flat = passes(ys);
            let mut rounds = 0;
            loop {
                let points =
                    flat.iter().map(|p| touching(p.at + p.overrun * DVec2::X, p.kind)).collect();
                let path = Toolpath { points };
                match mender.mended(&flat, &path) {
                    Some(more) if rounds < 4 => flat = more,
                    left => return (flat, rounds, left.is_none()),
                }
                rounds += 1;
            }
        };
        let all: Vec<f64> = (-5..=5).map(f64::from).map(|y| 0.98 * y).collect();
        let (flat, rounds, is_kept) = mended(&all, &check(None));
        assert!(is_kept && rounds == 0, "{rounds} rounds, {} points", flat.len());
        let gap: Vec<f64> = all.iter().copied().filter(|y| *y != 0.0).collect();
        let (flat, rounds, is_kept) = mended(&gap, &check(None));
        assert!(is_kept && rounds > 0, "{rounds} rounds");
        let added = flat.len() - passes(&gap).len();
        let in_gap = flat.iter().filter(|p| p.at.y.abs() < 0.5).count();
        assert!(in_gap >= 8 && added <= 4 * in_gap, "{in_gap} of {added}");
        // Under a roof over the gap, higher than half of what was left, no detour helps.
        let (flat, rounds, _) = mended(&gap, &check(Some(TOLD * limit)));
        assert!(rounds == 0 && flat.len() == passes(&gap).len(), "{rounds} rounds");
    }
}
