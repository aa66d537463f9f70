//! Strip-width tensor: the topology of the best feed direction, and where it divides a surface.
//!
//! - *Tensor*: `T = (k_tool I + K) / 2`. Its major eigenvector, the most convex principal direction,
//!   is the best feed direction: across it the strip, `2 sqrt(h / (b^T T b))`, is the widest.
//! - *Degenerate point*: all feed directions are equally good, `T11 = T22` and `T12 = 0`. With `p = (T11 - T22)/2`,
//!   `q = T12` and `delta = dp/dx dq/dy - dp/dy dq/dx` it is a *trisector* (`delta < 0`, index -1/2, three sectors in
//!   which the directions bend away) or a *wedge* (`delta > 0`, index 1/2, the directions turn around it).
//! - *Separatrix*: a line of the best feed direction that begins at a trisector; it divides sectors for which no
//!   single family of passes is suitable.
//!
//! Steps: field ([`TensorField`]), points (on meshes and on NURBS surfaces), separatrices, which are traced,
//! smoothed, and returned as flat polylines that end on the boundary, at a point, or on one another.
//!
//! # Source
//! Xu, Li, Liu, J. Nanjing Univ. Aeronautics & Astronautics 48(6) 2016, 847-855; for ball ends Liu et
//! al., Computer-Aided Design 66 (2015) 1-13.

mod exact;
mod field;
mod jet;
mod points;
mod separatrix;
mod spline;
#[cfg(test)]
mod tests;
mod topology;
mod trace;

pub use field::TensorField;
pub use separatrix::{rays, sampled};
pub use topology::{Cancelled, DegeneratePoint, FreeArea, Kind, Separatrix, Topology};
pub use trace::{End, Tracer};

use crate::flatten::{Chart, Locator};
use crate::geometry::DVec2;
use crate::geometry::math::{cos, sin};
use crate::geometry::polyline::distance_to_segment;
use crate::job::TensorOptions;
use crate::surface::{CurvatureField, Surface};
use points::{Sizes, Smoothing};

/// Distance from a trisector, in mean edges, at which its separatrices begin on a mesh: closer in, the field is
/// determined by too few faces.
const CLEAR_OF_POINT: f64 = 2.0;
/// The same in parts of the size where the field is exact.
const CLEAR_EXACT: f64 = 2e-3;
/// Turn from the cubic's ray within which the circle around a point is searched for the ray, rad.
const RAY_SEARCH: f64 = 0.5;
/// Halvings of that search.
const HALVINGS: usize = 30;
/// Distance, in parts of the size, within which lines meet points and each other.
const MEETS: f64 = 2e-3;
/// Largest distance of a smoothed separatrix from the traced one, in parts of the size.
const SMOOTHING: f64 = 2e-3;
/// Length of a line, in fractions of the size, before it can meet its origin or itself.
const OWN_WAY: f64 = 0.02;

/// The topology of the strip-width tensor of a surface, and its field.
///
/// `chart`, `locator`: its conformal flat image and the finder over it; `curvature`: its shape
/// operators; `k_tool`: effective curvature of the cutter across the feed
/// ([`Footprint::k_tool`](crate::footprint::Footprint::k_tool)), 1/mm. On a mesh of a NURBS surface points
/// and field are exact.
pub fn topology<'a>(
    surface: &'a Surface,
    (chart, locator): (&'a Chart, &'a Locator<'a>),
    curvature: &CurvatureField,
    k_tool: f64,
    options: &TensorOptions,
) -> (Topology, TensorField<'a>) {
    let mut field = TensorField::new(surface, (chart, locator), curvature, k_tool);
    let sizes = Sizes::of(surface);
    let own = surface.parameters();
    let smoothing = match own {
        Some(_) => Smoothing::default(),
        None => points::smooth(&mut field, sizes, options.scale),
    };
    let free = points::free_areas(&mut field, smoothing.noise);
    let mut found = match own {
        Some(own) => points::Found {
            points: exact::on_nurbs(&field, own, sizes.size),
            ..points::Found::default()
        },
        None => points::on_mesh(&field, sizes, smoothing.scale),
    };
    for point in &mut found.points {
        point.divides = point.kind == Kind::Trisector
            && gain(&field, point, 0.25 * sizes.size) >= options.least_gain;
    }
    let points::Found { points, cancelled, doubtful } = found;
    let clear = match own {
        Some(_) => CLEAR_EXACT * sizes.size,
        None => (CLEAR_OF_POINT * sizes.edge).max(smoothing.scale),
    };
    let separatrices = separatrices(&field, &points, clear);
    let values = field.values().to_vec();
    let smoothing = smoothing.scale;
    let topology = Topology { points, cancelled, doubtful, free, smoothing, separatrices, values };
    (topology, field)
}

/// How much wider the widest strip is than the narrowest at a distance of `distance` mm from a point.
fn gain(field: &TensorField, point: &DegeneratePoint, distance: f64) -> f64 {
    let vertices = field.surface().connectivity().face(point.at.face);
    let mean: f64 = (0..3).map(|i| field.means()[vertices[i].index()] * point.at.weights[i]).sum();
    // Eigenvalues are mean ± off; strips go with the inverse of the root.
    let off = point.delta.abs().sqrt() * distance;
    if off >= mean { f64::INFINITY } else { ((mean + off) / (mean - off)).sqrt() - 1.0 }
}

/// Separatrices of all points that divide, in their order.
fn separatrices(field: &TensorField, points: &[DegeneratePoint], clear: f64) -> Vec<Separatrix> {
    let uv = field.chart().uv();
    let low = uv.iter().copied().fold(DVec2::INFINITY, DVec2::min);
    let high = uv.iter().copied().fold(DVec2::NEG_INFINITY, DVec2::max);
    let size = (high - low).length();
    let tracing = Tracing { tracer: Tracer::new(field, size), field, points, size };
    let mut lines: Vec<Separatrix> = Vec::new();
    for (from, point) in points.iter().enumerate().filter(|(_, p)| p.divides) {
        // Flat mm per mm.
        let scale = 1.0 / field.chart().scale(field.surface(), point.at);
        for &ray in &point.rays {
            lines.push(tracing.separatrix(from, ray, clear * scale, &lines));
        }
    }
    lines
}

struct Tracing<'a> {
    tracer: Tracer<'a>,
    field: &'a TensorField<'a>,
    points: &'a [DegeneratePoint],
    size: f64,
}

impl Tracing<'_> {
    fn separatrix(&self, from: usize, ray: f64, clear: f64, lines: &[Separatrix]) -> Separatrix {
        let start = self.points[from].flat;
        let heading = self.ray_on_circle(start, ray, clear);
        let begin = start + heading * clear;
        let stop = |line: &[DVec2], to: DVec2| self.met(from, line, to, lines);
        let (traced, end) = self.tracer.follow(begin, heading, &stop);
        let mut line = vec![start];
        line.extend(traced);
        let smooth = spline::fitted(&line, SMOOTHING * self.size);
        let is_clear = |line: &[DVec2]| {
            let inner = &line[1..line.len().max(2) - 1];
            inner.iter().all(|p| self.field.locator().locate(*p).is_ok())
                && !lines.iter().any(|other| cross_inside(line, &other.line))
        };
        let line = if is_clear(&smooth) { smooth } else { line };
        Separatrix { from, end, line }
    }

    /// The direction near `ray` in which the field on the circle around a point is radial.
    fn ray_on_circle(&self, centre: DVec2, ray: f64, radius: f64) -> DVec2 {
        let unit = |angle: f64| DVec2::new(cos(angle), sin(angle));
        let off = |angle: f64| {
            let way = unit(angle);
            self.tracer.direction(centre + way * radius, way).map(|d| way.perp_dot(d))
        };
        let (mut low, mut high) = (ray - RAY_SEARCH, ray + RAY_SEARCH);
        let (Some(at_low), Some(at_high)) = (off(low), off(high)) else { return unit(ray) };
        if (at_low > 0.0) == (at_high > 0.0) {
            return unit(ray);
        }
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            match off(middle) {
                Some(here) if (here > 0.0) == (at_low > 0.0) => low = middle,
                _ => high = middle,
            }
        }
        unit(0.5 * (low + high))
    }

    /// What the last step of a line meets: a point, another line, the line itself.
    fn met(
        &self,
        from: usize,
        line: &[DVec2],
        to: DVec2,
        lines: &[Separatrix],
    ) -> Option<(DVec2, End)> {
        let at = *line.last()?;
        let reach = MEETS * self.size;
        let behind = self.behind(line);
        for (i, point) in self.points.iter().enumerate() {
            let can_return = i != from || behind > 0;
            if can_return && distance_to_segment(point.flat, at, to) < reach {
                return Some((point.flat, End::Point(i)));
            }
        }
        let others = lines.iter().filter(|l| l.from != from || behind > 0);
        let segments = others.flat_map(|l| l.line.windows(2)).chain(line[..behind].windows(2));
        for segment in segments {
            if let Some(place) = trace::crossing(at, to, segment[0], segment[1]) {
                return Some((place, End::Line));
            }
            if distance_to_segment(to, segment[0], segment[1]) < 0.25 * reach {
                return Some((foot(to, segment[0], segment[1]), End::Line));
            }
        }
        None
    }
}

impl Tracing<'_> {
    /// Points of a line that lie so far behind its end that it can meet them.
    fn behind(&self, line: &[DVec2]) -> usize {
        let mut way = 0.0;
        let far = (1..line.len()).rev().find(|&i| {
            way += line[i].distance(line[i - 1]);
            way > OWN_WAY * self.size
        });
        far.unwrap_or(0)
    }
}

/// The point of a segment nearest to `p`.
fn foot(p: DVec2, a: DVec2, b: DVec2) -> DVec2 {
    let way = b - a;
    let square = way.length_squared();
    let t = if square > 0.0 { ((p - a).dot(way) / square).clamp(0.0, 1.0) } else { 0.0 };
    a + way * t
}

/// Whether two lines cross other than at their ends.
fn cross_inside(line: &[DVec2], other: &[DVec2]) -> bool {
    let last = line.len().saturating_sub(2);
    line.windows(2)
        .enumerate()
        .filter(|(i, _)| *i > 0 && *i < last)
        .any(|(_, p)| other.windows(2).any(|q| trace::crossing(p[0], p[1], q[0], q[1]).is_some()))
}
