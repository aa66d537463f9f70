//! Contacts beside the level curves, so that the strips lie where the level curves are.
//!
//! The edges of the strip of a tilted flat bottom trail behind the contact. On a twisted surface one edge is higher
//! there than the other, so that the contact is not in the middle of the strip. Level curves mark the middles of
//! strips: half a pass from the boundary and from each other, in whatever direction they are cut.
//!
//! 1. Points are added to open passes, at most a fraction of a side step apart.
//! 2. Each point is moved across the feed by the distance between the contact and the middle of its strip.
//! 3. Ends at the boundary are moved along the pass until they lie on it again.
//! 4. The cutter faces the mean direction of the pass over a side step, since it would lean to the side by a fraction
//!    of the noise of that direction. On a branch it faces as on its pass.

use crate::flat_path::FlatPoint;
use crate::flatten::{Chart, Locator};
use crate::footprint::Footprint;
use crate::geometry::{DVec2, DVec3};
use crate::surface::{CurvatureField, Surface};
use crate::toolpath::MoveKind;

/// Fraction of the distance to the boundary by which a point is moved at most. More: rounding moves it outside.
const WITHIN: f64 = 0.98;
/// Greatest distance by which an end is moved along its pass, steps.
const LONGEST: f64 = 6.0;

/// Number of points before and after one from which its direction is measured. Fewer: noise; more: sharp turns are
/// smoothed.
const BESIDE: usize = 2;

/// The data needed to move passes.
#[derive(Copy, Clone, Debug)]
pub struct Centring<'a> {
    /// The surface.
    pub surface: &'a Surface,
    /// Its flat image.
    pub chart: &'a Chart,
    /// Over its flat faces.
    pub locator: &'a Locator<'a>,
    /// Its curvature.
    pub curvature: &'a CurvatureField,
    /// The cutter.
    pub footprint: Footprint,
    /// Height of the cusps between strips, mm.
    pub cusp: f64,
    /// Largest distance of points, mm.
    pub step: f64,
}

/// A point of a pass.
#[derive(Copy, Clone)]
struct Vertex {
    /// Flat place.
    at: DVec2,
    /// Flat place after it is moved.
    moved: DVec2,
    /// Flat unit direction of the pass there.
    heading: DVec2,
    /// Whether it is a point of the original pass.
    is_old: bool,
}

impl Centring<'_> {
    /// The path with its open passes moved; branches are kept, except where they leave.
    pub fn centred(&self, points: &[FlatPoint]) -> Vec<FlatPoint> {
        points.chunk_by(|a, b| a.pass == b.pass).flat_map(|pass| self.pass(pass)).collect()
    }

    fn pass(&self, points: &[FlatPoint]) -> Vec<FlatPoint> {
        let on_pass = points.iter().filter(is_on_pass);
        let mut line: Vec<DVec2> = on_pass.clone().map(|p| p.at).collect();
        line.dedup();
        if line.len() < 2 || line.first() == line.last() {
            return points.to_vec();
        }
        let mut vertices = self.moved(&line);
        let ends = [points.iter().any(|p| p.overrun < 0.0), points.iter().any(|p| p.overrun > 0.0)];
        for is_at_boundary in ends {
            if is_at_boundary {
                self.meet_boundary(&mut vertices);
            }
            vertices.reverse();
        }
        for v in &mut vertices {
            v.moved = self.within(v.at, v.moved);
        }
        for i in 0..vertices.len() {
            vertices[i].heading = heading(|k| vertices[k].moved, i, vertices.len());
        }
        self.along(points, &vertices)
    }

    /// The points of a pass, with the added ones, moved across.
    fn moved(&self, line: &[DVec2]) -> Vec<Vertex> {
        let mut dense: Vec<(DVec2, bool)> = Vec::new();
        for w in line.windows(2) {
            let scale = self.scale(w[0]).unwrap_or(1.0);
            let n = (scale * w[0].distance(w[1]) / self.step).ceil().clamp(1.0, 1e6);
            let between = (1..n as usize).map(|k| (w[0].lerp(w[1], k as f64 / n), false));
            dense.push((w[0], true));
            dense.extend(between);
        }
        dense.extend(line.last().map(|p| (*p, true)));
        let at = |i: usize| dense[i].0;
        let vertex = |i: usize| {
            let heading = heading(at, i, dense.len());
            let moved = self.aside(at(i), heading).map_or(at(i), |aside| at(i) + aside);
            Vertex { at: at(i), moved, heading, is_old: dense[i].1 }
        };
        (0..dense.len()).map(vertex).collect()
    }

    /// By how much a contact at a flat place, cut in a flat unit direction, is moved so that its strip lies there.
    fn aside(&self, at: DVec2, way: DVec2) -> Option<DVec2> {
        let (ahead, [along, twist, across]) = self.bends(at, way)?;
        let middle = self.footprint.middle(self.cusp, across, along, twist);
        Some(way.perp() * (-middle / ahead.length()))
    }

    /// The image in space of a flat direction at a place; and the curvature along it, mixed with its left normal, and
    /// along that normal, 1/mm.
    fn bends(&self, at: DVec2, way: DVec2) -> Option<(DVec3, [f64; 3])> {
        let point = self.locator.locate(at).ok()?;
        let ahead = self.in_space(point.face, way)?;
        let shape = self.curvature.at(self.surface, point);
        let feed = ahead.reject_from(shape.normal()).try_normalize()?;
        let left = shape.normal().cross(feed);
        Some((ahead, shape.in_frame([feed, left]).k))
    }

    /// Moves the first of the points along the pass to the boundary; points beyond it are dropped.
    fn meet_boundary(&self, vertices: &mut Vec<Vertex>) {
        let is_inside = |v: &Vertex| self.locator.locate(v.moved).is_ok();
        let Some(first) = vertices.iter().position(is_inside).filter(|k| k + 1 < vertices.len())
        else {
            return;
        };
        if vertices[1..first.max(1)].iter().any(|v| v.is_old) {
            return;
        }
        let from = vertices[first].moved;
        let beyond = match first {
            0 => {
                let way = (from - vertices[1].moved).normalize_or_zero();
                from + way * (LONGEST * self.step / self.scale(from).unwrap_or(1.0))
            }
            _ => vertices[first - 1].moved,
        };
        let end = self.within(from, beyond);
        if end != beyond {
            vertices[0].moved = end;
            vertices.drain(1..first.max(1));
        }
    }

    /// The moved points of a pass, with the added ones.
    fn along(&self, points: &[FlatPoint], vertices: &[Vertex]) -> Vec<FlatPoint> {
        let mut out: Vec<FlatPoint> = Vec::new();
        let mut rest = vertices.iter().peekable();
        let Some(mut last) = rest.next() else { return points.to_vec() };
        for (i, point) in points.iter().enumerate() {
            if is_on_pass(&point) && point.at != last.at {
                while let Some(v) = rest.next_if(|v| !v.is_old) {
                    let heading = Some(v.heading);
                    out.push(FlatPoint { at: v.moved, heading, overrun: 0.0, ..*point });
                }
                last = rest.next().unwrap_or(last);
            }
            let is_here = is_on_pass(&point) || point.at == last.at;
            let at = if is_here { last.moved } else { point.at };
            // Links to and fro face their way.
            let is_joined = point.kind == MoveKind::Link && i == 0;
            let is_high = point.height > 0.0;
            let heading = (!is_joined && !is_high).then_some(last.heading);
            out.push(FlatPoint { at, heading, ..*point });
        }
        out
    }

    /// The end of the straight flat line from a place of the chart, or the last point of it on the chart.
    fn within(&self, from: DVec2, to: DVec2) -> DVec2 {
        let Ok(start) = self.locator.locate(from) else { return from };
        match self.locator.walk(start.face, from, to, |_, _| {}) {
            Ok(_) => to,
            Err(outside) => from.lerp(outside.uv, WITHIN),
        }
    }

    /// The image in space of a flat direction on a face, mm per flat mm.
    fn in_space(&self, face: crate::mesh::FaceId, way: DVec2) -> Option<DVec3> {
        let [a, b, c] = self.surface.connectivity().face(face).map(|v| self.chart.uv()[v.index()]);
        let [p, q, r] = self.surface.corners(face);
        let (e, f) = (b - a, c - a);
        let area = e.perp_dot(f);
        let image = ((q - p) * way.perp_dot(f) + (r - p) * e.perp_dot(way)) / area;
        image.is_finite().then_some(image)
    }

    /// mm per flat mm.
    fn scale(&self, at: DVec2) -> Option<f64> {
        let point = self.locator.locate(at).ok()?;
        self.in_space(point.face, DVec2::X).map(|x| x.length())
    }
}

/// Whether a point belongs to its pass itself, not to a link or to a branch.
fn is_on_pass(point: &&FlatPoint) -> bool {
    point.heading.is_none() && point.height == 0.0
}

/// Flat unit direction of a line at one of its points, by those [`BESIDE`] points before and after: there that of
/// the chord, at the ends that of the parabola.
fn heading(at: impl Fn(usize) -> DVec2, i: usize, count: usize) -> DVec2 {
    let last = count - 1;
    let way = match (i < BESIDE, i + BESIDE > last) {
        (false, false) => at(i + BESIDE) - at(i - BESIDE),
        (true, false) if i + 2 * BESIDE <= last => at_end(|k| at(i + k * BESIDE)),
        (false, true) if i >= 2 * BESIDE => -at_end(|k| at(i - k * BESIDE)),
        _ => at((i + BESIDE).min(last)) - at(i.saturating_sub(BESIDE)),
    };
    way.normalize_or_zero()
}

/// Direction at the first of three points of a parabola.
fn at_end(at: impl Fn(usize) -> DVec2) -> DVec2 {
    4.0 * at(1) - 3.0 * at(0) - at(2)
}
