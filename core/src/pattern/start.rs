//! Start curves of iso-scallop passes.

use crate::flatten::Locator;
use crate::geometry::math::{atan2, cos, sin};
use crate::geometry::{DVec2, DVec3, OrderBy};
use crate::job::Start;
use crate::level_set::strip_metric::FlatMetric;
use crate::level_set::{Accuracy, LevelSetError, PassField, PassMesh};
use crate::mesh::{FaceId, VertexId};
use core::f64::consts::PI;

/// Steps of a traced curve, passes.
const STEP: f64 = 0.5;
/// Most steps of a traced curve.
const MOST_STEPS: usize = 20_000;
/// Metrics whose widths differ by less than this fraction give no direction.
const EVEN: f64 = 0.02;
/// Smoothing rounds of a traced curve; it is smoothed over the square root of this many steps.
const SMOOTHINGS: usize = 100;
/// Turn of the boundary within two passes that counts as a corner, rad.
const CORNER: f64 = PI / 5.0;
/// Directions of straight lines that are tried.
const LINES: u32 = 8;
/// Curves along the best feed direction that are tried.
const FEED_LINES: usize = 6;
/// Most sides of the boundary that are tried.
const MOST_SIDES: usize = 6;

/// The flat direction along the long side of the smallest rectangle around the chart.
pub fn long_side(mesh: &PassMesh) -> DVec2 {
    let hull = convex_hull(outer_loop(mesh).iter().map(|v| mesh.uv()[v.index()]).collect());
    let extent = |axis: DVec2| {
        let along = hull.iter().map(|p| p.dot(axis));
        along.clone().fold(f64::NEG_INFINITY, f64::max) - along.fold(f64::INFINITY, f64::min)
    };
    let mut best = (f64::INFINITY, DVec2::X);
    for i in 0..hull.len() {
        let side = hull[(i + 1) % hull.len()] - hull[i];
        let Some(axis) = side.try_normalize() else { continue };
        let (long, short) = (extent(axis), extent(axis.perp()));
        // Rounding must not decide between the sides of a square.
        if long * short < best.0 * (1.0 - 1e-9) {
            best = (long * short, if long >= short * (1.0 - 1e-9) { axis } else { axis.perp() });
        }
    }
    best.1
}

/// The convex hull, counter-clockwise (Andrew's monotone chain).
fn convex_hull(mut points: Vec<DVec2>) -> Vec<DVec2> {
    points.order_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    let mut hull: Vec<DVec2> = Vec::new();
    for pass in 0..2 {
        let start = hull.len();
        for &p in &points {
            while hull.len() >= start + 2 {
                let (a, b) = (hull[hull.len() - 2], hull[hull.len() - 1]);
                if (b - a).perp_dot(p - b) > 0.0 {
                    break;
                }
                hull.pop();
            }
            hull.push(p);
        }
        hull.pop();
        if pass == 0 {
            points.reverse();
        }
    }
    hull
}

/// The loop of the boundary with the largest extent.
fn outer_loop(mesh: &PassMesh) -> &[VertexId] {
    let area = |l: &[VertexId]| {
        let at = |i: usize| mesh.uv()[l[i % l.len()].index()];
        (0..l.len()).map(|i| at(i).perp_dot(at(i + 1))).sum::<f64>().abs()
    };
    let loops = mesh.connectivity().boundary_loops();
    let best = loops.iter().max_by(|a, b| area(a).total_cmp(&area(b)));
    best.map_or(&[], |l| l.as_slice())
}

/// Start of iso-scallop passes.
#[derive(Clone, Debug, PartialEq)]
pub enum Source {
    /// The whole boundary.
    Boundary,
    /// The outer boundary from the vertex at a flat point to that at another.
    Side(DVec2, DVec2),
    /// A flat curve.
    Curve(Vec<DVec2>),
    /// A flat curve, continued straight beyond the boundary.
    GoingOn(Vec<DVec2>),
}

impl Source {
    /// All vertices that a start allows, on a mesh whose vertices keep their indices when it is refined.
    pub fn candidates(mesh: &PassMesh, locator: &Locator, start: &Start) -> Vec<Self> {
        let sides = || {
            let sides = sides(mesh);
            if sides.is_empty() { vec![Self::Boundary] } else { sides }
        };
        match start {
            Start::Widest => vec![Self::Curve(widest(mesh, locator))],
            Start::Boundary => sides(),
            Start::Curve(points) => vec![Self::Curve(through_points(mesh, locator, points))],
            Start::Shortest => {
                let mut all = sides();
                all.push(Self::Curve(widest(mesh, locator)));
                all.extend(lines(mesh, locator).into_iter().map(Self::Curve));
                all.extend(feed_lines(mesh, locator).into_iter().map(Self::Curve));
                all
            }
        }
    }

    /// As above, with a curve continued straight beyond the boundary.
    pub fn going_on(self) -> Self {
        match self {
            Self::Curve(curve) => Self::GoingOn(curve),
            other => other,
        }
    }

    /// The distance from it.
    ///
    /// # Errors
    /// [`LevelSetError::NoCurve`] when it crosses no face.
    pub fn field(
        &self,
        mesh: &PassMesh,
        locator: &Locator,
        accuracy: Accuracy,
    ) -> Result<PassField, LevelSetError> {
        match self {
            Self::Boundary => Ok(PassField::from_boundary(mesh)),
            Self::Side(from, to) => {
                Ok(PassField::from_vertices(mesh, &between(mesh, *from, *to), accuracy))
            }
            Self::Curve(curve) => PassField::from_curve(mesh, locator, curve, accuracy),
            Self::GoingOn(curve) => PassField::from_curve_going_on(mesh, locator, curve, accuracy),
        }
    }
}

/// Straight flat lines through the middle of the chart, evenly over half a turn from its long side.
fn lines(mesh: &PassMesh, locator: &Locator) -> Vec<Vec<DVec2>> {
    let axis = long_side(mesh);
    let count = mesh.uv().len().max(1) as f64;
    let middle = mesh.uv().iter().copied().sum::<DVec2>() / count;
    let trace = Trace { mesh, locator };
    let line = |i: u32| {
        let angle = PI * f64::from(i) / f64::from(LINES);
        let turn = DVec2::new(cos(angle), sin(angle));
        let way = turn.rotate(axis);
        let step = 1e-3 * trace.size();
        trace.lengthened(vec![middle - way * step, middle + way * step])
    };
    let is_through = |line: &Vec<DVec2>| line.len() == 4;
    (0..LINES).map(line).filter(is_through).collect()
}

/// Curves along the best feed direction through places all over the chart.
fn feed_lines(mesh: &PassMesh, locator: &Locator) -> Vec<Vec<DVec2>> {
    let flat = |f: usize| mesh.connectivity().face(FaceId(f as u32)).map(|v| mesh.uv()[v.index()]);
    let area = |f: usize| {
        let [a, b, c] = flat(f);
        0.5 * (b - a).perp_dot(c - a).abs()
    };
    let count = mesh.connectivity().face_count();
    let whole: f64 = (0..count).map(area).sum();
    let middle =
        (0..count).map(|f| flat(f).into_iter().sum::<DVec2>() / 3.0 * area(f)).sum::<DVec2>()
            / whole;
    let turn = |i: usize| 2.4 * i as f64;
    let trace = Trace { mesh, locator };
    let fallback = long_side(mesh);
    (0..FEED_LINES)
        .map(|i| {
            // Vogel's spiral spreads places evenly over a disc.
            let radius = (whole / PI * (i as f64 + 0.5) / FEED_LINES as f64).sqrt();
            middle + DVec2::new(cos(turn(i)), sin(turn(i))) * radius
        })
        .filter(|place| locator.locate(*place).is_ok())
        .map(|place| trace.lengthened(trace.through(place, fallback)))
        .filter(|line| line.len() > 3)
        .collect()
}

/// From the place of the widest strip both ways along the best feed direction to the boundary.
fn widest(mesh: &PassMesh, locator: &Locator) -> Vec<DVec2> {
    let fallback = long_side(mesh);
    let width = |f: usize| {
        let face = FaceId(f as u32);
        let [a, b, c] = mesh.connectivity().face(face).map(|v| mesh.positions()[v.index()]);
        let [p, q, r] = mesh.connectivity().face(face).map(|v| mesh.uv()[v.index()]);
        let scale = ((b - a).cross(c - a).length() / (q - p).perp_dot(r - p).abs()).sqrt();
        mesh.flat_metric(face).map_or(0.0, |m| scale / m.least())
    };
    let widths: Vec<f64> = (0..mesh.connectivity().face_count()).map(width).collect();
    let largest = widths.iter().copied().fold(0.0, f64::max);
    // Of all as wide, the one nearest to the middle: a long curve.
    let centre = |f: usize| {
        let [p, q, r] = mesh.connectivity().face(FaceId(f as u32)).map(|v| mesh.uv()[v.index()]);
        (p + q + r) / 3.0
    };
    let count = widths.len().max(1) as f64;
    let middle = (0..widths.len()).map(centre).sum::<DVec2>() / count;
    let as_wide = (0..widths.len()).filter(|&f| widths[f] >= largest * (1.0 - EVEN));
    let nearest = as_wide.min_by(|&a, &b| {
        centre(a).distance_squared(middle).total_cmp(&centre(b).distance_squared(middle))
    });
    let from = centre(nearest.unwrap_or(0));
    let trace = Trace { mesh, locator };
    trace.lengthened(trace.through(from, fallback))
}

/// The curve through the surface points nearest to `points`, lengthened to the boundary.
fn through_points(mesh: &PassMesh, locator: &Locator, points: &[DVec3]) -> Vec<DVec2> {
    let mut curve: Vec<DVec2> = points.iter().map(|&p| nearest(mesh, p)).collect();
    curve.dedup();
    Trace { mesh, locator }.lengthened(curve)
}

/// Flat image of the surface point nearest to `p`.
fn nearest(mesh: &PassMesh, p: DVec3) -> DVec2 {
    let mut best = (f64::INFINITY, DVec2::ZERO);
    for face in mesh.connectivity().faces() {
        let corners = face.map(|v| mesh.positions()[v.index()]);
        let weights = crate::geometry::nearest_on_triangle(p, corners);
        let at: DVec3 = (0..3).map(|i| corners[i] * weights[i]).sum();
        let square = at.distance_squared(p);
        if square < best.0 {
            best = (square, (0..3).map(|i| mesh.uv()[face[i].index()] * weights[i]).sum());
        }
    }
    best.1
}

/// Follows the best feed direction through the chart.
pub(super) struct Trace<'a> {
    pub mesh: &'a PassMesh,
    pub locator: &'a Locator<'a>,
}

impl Trace<'_> {
    fn metric(&self, at: DVec2) -> Option<FlatMetric> {
        self.mesh.flat_metric(self.locator.locate(at).ok()?.face)
    }

    /// The flat direction in which strips across are the widest; `None` where all are equally wide.
    fn direction(&self, at: DVec2) -> Option<DVec2> {
        let metric = self.metric(at)?;
        (metric.anisotropy() > EVEN).then(|| metric.direction_of_most())
    }

    /// Traces both ways from a place and smooths the curve; `fallback`: the direction where all strips are equally
    /// wide.
    pub fn through(&self, from: DVec2, fallback: DVec2) -> Vec<DVec2> {
        let first = self.direction(from).unwrap_or(fallback);
        let mut curve = self.follow(from, -first);
        curve.reverse();
        curve.extend(self.follow(from, first).into_iter().skip(1));
        smoothed(curve)
    }

    fn follow(&self, from: DVec2, heading: DVec2) -> Vec<DVec2> {
        let mut points = vec![from];
        let (mut at, mut heading) = (from, heading);
        for _ in 0..MOST_STEPS {
            let Some(metric) = self.metric(at) else { break };
            let step = STEP / metric.mean();
            let turned = |d: DVec2| if d.dot(heading) < 0.0 { -d } else { d };
            let here = self.direction(at).map_or(heading, turned);
            let middle = self.direction(at + here * (0.5 * step)).map_or(here, turned);
            let to = at + middle * step;
            if self.metric(to).is_none() || has_come_back(&points, to, step) {
                break;
            }
            points.push(to);
            (at, heading) = (to, middle);
        }
        points
    }

    /// A curve extended straight at both ends as far as the chart reaches.
    pub fn lengthened(&self, mut curve: Vec<DVec2>) -> Vec<DVec2> {
        for _ in 0..2 {
            curve.reverse();
            let [.., before, last] = curve[..] else { continue };
            let Some(way) = (last - before).try_normalize() else { continue };
            let Ok(at) = self.locator.locate(last) else { continue };
            let far = last + way * self.size();
            if let Err(outside) = self.locator.walk(at.face, last, far, |_, _| {}) {
                curve.push(outside.uv);
            }
        }
        curve
    }

    /// Diameter of the chart, flat mm.
    fn size(&self) -> f64 {
        let uv = self.mesh.uv();
        let low = uv.iter().copied().fold(DVec2::INFINITY, DVec2::min);
        let high = uv.iter().copied().fold(DVec2::NEG_INFINITY, DVec2::max);
        (high - low).length()
    }
}

/// Whether a curve comes close to an earlier part of itself.
fn has_come_back(points: &[DVec2], to: DVec2, step: f64) -> bool {
    let before = points.len().saturating_sub(8);
    points[..before].iter().any(|p| p.distance(to) < 2.0 * step)
}

/// A curve without the noise of its steps; the ends stay.
fn smoothed(mut points: Vec<DVec2>) -> Vec<DVec2> {
    for _ in 0..SMOOTHINGS {
        let before = points.clone();
        for i in 1..points.len().saturating_sub(1) {
            points[i] = 0.25 * (before[i - 1] + 2.0 * before[i] + before[i + 1]);
        }
    }
    points
}

/// The outer boundary between its corners, by its ends; none without two corners, the longest first.
fn sides(mesh: &PassMesh) -> Vec<Source> {
    let outer = outer_loop(mesh);
    let n = outer.len();
    let reach = mesh.mean_pass();
    let turns: Vec<f64> = (0..n).map(|i| turn(mesh, outer, i, reach)).collect();
    let is_corner = |i: usize| {
        let here = turns[i].abs();
        // The sharpest of its neighbourhood.
        let near = (1..=4).flat_map(|k| [(i + k) % n, (i + n - k % n) % n]);
        here > CORNER && near.into_iter().all(|j| j == i || turns[j].abs() <= here)
    };
    let corners: Vec<usize> = (0..n).filter(|&i| is_corner(i)).collect();
    if corners.len() < 2 {
        return Vec::new();
    }
    let length = |k: usize| -> f64 {
        let (from, to) = (corners[k], corners[(k + 1) % corners.len()]);
        let at = |i: usize| mesh.positions()[outer[i % n].index()];
        (0..(to + n - from) % n).map(|i| at(from + i).distance(at(from + i + 1))).sum()
    };
    let mut order: Vec<usize> = (0..corners.len()).collect();
    order.order_by(|&a, &b| length(b).total_cmp(&length(a)).then(a.cmp(&b)));
    let at = |k: usize| mesh.uv()[outer[corners[k % corners.len()]].index()];
    let side = |k: usize| Source::Side(at(k), at(k + 1));
    order.into_iter().take(MOST_SIDES).map(side).collect()
}

/// The vertices of the outer boundary from the one nearest to a flat point to the one nearest to another.
fn between(mesh: &PassMesh, from: DVec2, to: DVec2) -> Vec<VertexId> {
    let outer = outer_loop(mesh);
    let nearest = |p: DVec2| {
        let square = |i: &usize| mesh.uv()[outer[*i].index()].distance_squared(p);
        (0..outer.len()).min_by(|a, b| square(a).total_cmp(&square(b))).unwrap_or(0)
    };
    let (start, end) = (nearest(from), nearest(to));
    let n = outer.len();
    let length = if end == start { n } else { (end + n - start) % n };
    (0..=length).filter_map(|k| outer.get((start + k) % n)).copied().collect()
}

/// Turn of a loop at a vertex, seen over `reach` mm to either side, rad.
fn turn(mesh: &PassMesh, outer: &[VertexId], i: usize, reach: f64) -> f64 {
    let n = outer.len();
    let at = |k: usize| mesh.positions()[outer[k % n].index()];
    let chord = |back: bool| {
        let next = |k: usize| if back { (k + n - 1) % n } else { (k + 1) % n };
        let mut k = next(i);
        while k != i && at(k).distance(at(i)) < reach {
            k = next(k);
        }
        at(k) - at(i)
    };
    let (before, after) = (-chord(true), chord(false));
    atan2(before.cross(after).length(), before.dot(after))
}
