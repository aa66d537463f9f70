//! Flat path → cutter contacts on the surface.
//!
//! A straight flat move becomes the polyline of its crossings with the mesh: within a triangle a
//! straight flat line is a straight line in space.

use crate::cutter_location::{Contact, facet_error};
use crate::flat_path::FlatPoint;
use crate::flatten::{Chart, Locator, OutsideChart};
use crate::footprint::Footprint;
use crate::geometry::beyond::Parabola;
use crate::geometry::{DVec2, DVec3};
use crate::mesh::{FaceId, HalfEdgeId};
use crate::surface::{Surface, SurfacePoint};

/// Contacts closer than this are merged, mm.
const SAME: f64 = 1e-6;
/// Distance of contacts beyond the chart, cutter radii.
const OVERRUN_STEP: f64 = 0.05;

/// A contact with its place in the plane.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct LiftedPoint {
    /// Flat point.
    pub uv: DVec2,
    /// Index of the flat move it belongs to.
    pub source: usize,
}

/// Contacts of a run of moves, each with its source.
#[derive(Clone, Debug, Default)]
pub struct Lifted {
    /// Contacts; `key` is the index here.
    pub contacts: Vec<Contact>,
    /// One entry per contact.
    pub points: Vec<LiftedPoint>,
}

/// Maps flat paths onto one surface.
pub struct Lift<'a> {
    surface: &'a Surface,
    chart: &'a Chart,
    locator: &'a Locator<'a>,
    tool_radius: f64,
    footprint: Footprint,
    axis: Option<DVec3>,
}

impl<'a> Lift<'a> {
    /// For a surface, its chart, an index over the chart, and a cutter: its radius, mm, how it touches, and its axis,
    /// if that is fixed.
    pub fn new(
        surface: &'a Surface,
        chart: &'a Chart,
        locator: &'a Locator<'a>,
        (tool_radius, footprint): (f64, Footprint),
        axis: Option<DVec3>,
    ) -> Self {
        Self { surface, chart, locator, tool_radius, footprint, axis }
    }

    /// Maps a run of moves onto the surface; `first` is the index of `run[0]` in the whole path.
    ///
    /// Where a move cuts a corner of the boundary, the contact goes straight in space from where it leaves the chart
    /// to where it returns.
    ///
    /// # Errors
    /// [`OutsideChart`] when the first or the last point lies outside of the chart.
    pub fn run(&self, run: &[FlatPoint], first: usize) -> Result<Lifted, OutsideChart> {
        let mut out = Lifted::default();
        let Some(start) = run.first() else { return Ok(out) };
        let mut at = self.locate(start.at)?;
        self.push(&mut out, at, start, first, start.at, start.height);
        let mut from = start;
        for (i, to) in run.iter().enumerate().skip(1) {
            match self.walk(&mut out, at, from, to, first + i) {
                Ok(end) => (at, from) = (end, to),
                // A stretch that cuts a corner of the boundary: straight on to where it is back.
                Err(_) if i + 1 < run.len() => {}
                Err(outside) => return Err(outside),
            }
        }
        let n = out.contacts.len();
        for i in
            (0..n).filter(|&i| out.contacts[i].feed_direction == DVec3::ZERO).collect::<Vec<_>>()
        {
            let (a, b) = (i.saturating_sub(1), (i + 1).min(n - 1));
            let mut way = out.contacts[b].position - out.contacts[a].position;
            if way == DVec3::ZERO {
                way = out.contacts[b].position - out.contacts[i].position;
            }
            out.contacts[i].feed_direction = way;
        }
        let step = OVERRUN_STEP * self.tool_radius;
        Ok(overrun(out, run, first, (step, &self.footprint), self.axis))
    }

    fn locate(&self, at: DVec2) -> Result<SurfacePoint, OutsideChart> {
        self.locator.locate(at)
    }

    /// Appends the crossings of one move and its end; returns where it ends.
    fn walk(
        &self,
        out: &mut Lifted,
        start: SurfacePoint,
        from: &FlatPoint,
        to: &FlatPoint,
        source: usize,
    ) -> Result<SurfacePoint, OutsideChart> {
        let way = to.at - from.at;
        let mut done = 0.0;
        let crossed = out.contacts.len();
        let walked = self.locator.walk(start.face, from.at, to.at, |side, t| {
            let uv = from.at + way * t;
            if t > done
                && let Some(point) = self.point_on(side, uv)
            {
                done = t;
                let height = from.height + (to.height - from.height) * t;
                let there = FlatPoint { heading: heading(from, to, t), ..*to };
                self.push(out, point, &there, source, uv, height);
            }
        });
        let end = walked.or_else(|_| {
            out.contacts.truncate(crossed);
            out.points.truncate(crossed);
            self.locate(to.at)
        })?;
        self.push(out, end, to, source, to.at, to.height);
        Ok(end)
    }

    /// The direction on a face whose flat image is `heading`.
    fn forward(&self, face: FaceId, heading: DVec2) -> DVec3 {
        let [a, b, c] = self.flat(face);
        let [p, q, r] = self.surface.corners(face);
        let (e, f) = (b - a, c - a);
        let area = e.perp_dot(f);
        if area == 0.0 {
            return DVec3::ZERO;
        }
        let (u, v) = (heading.perp_dot(f) / area, e.perp_dot(heading) / area);
        (q - p) * u + (r - p) * v
    }

    fn flat(&self, face: FaceId) -> [DVec2; 3] {
        self.surface.connectivity().face(face).map(|v| self.chart.uv()[v.index()])
    }

    /// The point of a side nearest to `at`.
    fn point_on(&self, side: HalfEdgeId, at: DVec2) -> Option<SurfacePoint> {
        let corners = self.flat(side.face());
        let i = side.corner();
        let (a, b) = (corners[i], corners[(i + 1) % 3]);
        let length = (b - a).length_squared();
        let t = ((at - a).dot(b - a) / length).clamp(0.0, 1.0);
        let mut weights = [0.0; 3];
        weights[i] = 1.0 - t;
        weights[(i + 1) % 3] = t;
        (length > 0.0).then_some(SurfacePoint { face: side.face(), weights })
    }

    fn push(
        &self,
        out: &mut Lifted,
        point: SurfacePoint,
        of: &FlatPoint,
        source: usize,
        uv: DVec2,
        height: f64,
    ) {
        let normal = self.surface.normal(point);
        let vertices = self.surface.connectivity().face(point.face);
        let normals = vertices.map(|v| self.surface.vertex_normals()[v.index()]);
        out.contacts.push(Contact {
            position: self.surface.position(point) + normal * height,
            normal,
            feed_direction: of.heading.map_or(DVec3::ZERO, |h| self.forward(point.face, h)),
            key: out.contacts.len(),
            feed: of.feed,
            kind: of.kind,
            facet_error: facet_error(self.surface.corners(point.face), normals, self.tool_radius),
        });
        out.points.push(LiftedPoint { uv, source });
    }
}

/// Flat direction that the cutter faces at a part of a move.
fn heading(from: &FlatPoint, to: &FlatPoint, part: f64) -> Option<DVec2> {
    match (from.heading, to.heading) {
        (Some(a), Some(b)) if from.pass == to.pass => Some(a.lerp(b, part)),
        _ => to.heading,
    }
}

/// The contacts with the overruns beyond the chart that the run's points require: along the feed at the last contact
/// of a point, curved as the surface is before it.
fn overrun(
    lifted: Lifted,
    run: &[FlatPoint],
    first: usize,
    (step, footprint): (f64, &Footprint),
    axis: Option<DVec3>,
) -> Lifted {
    if run.iter().all(|p| p.overrun == 0.0) {
        return lifted;
    }
    let mut out = Lifted::default();
    let mut push = |contact: Contact, point: LiftedPoint| {
        out.contacts.push(Contact { key: out.contacts.len(), ..contact });
        out.points.push(point);
    };
    for (i, (contact, point)) in lifted.contacts.iter().zip(&lifted.points).enumerate() {
        let is_last = lifted.points.get(i + 1).is_none_or(|next| next.source != point.source);
        let by = if is_last { run[point.source - first].overrun } else { 0.0 };
        if by == 0.0 {
            push(*contact, *point);
            continue;
        }
        let steps = (by.abs() / step).ceil() as usize;
        // Out and back: what comes before or after the pass runs on the surface.
        let ways = (0..=steps).chain((0..steps).rev());
        let pass = |k: &usize| run[lifted.points[*k].source - first].pass;
        let is_on_it = |k: &usize| pass(k) == pass(&i);
        let inward: Vec<&Contact> = if by < 0.0 {
            let after = (i + 1..lifted.contacts.len()).take_while(is_on_it);
            after.map(|k| &lifted.contacts[k]).collect()
        } else {
            let before = (0..i).rev().take_while(is_on_it);
            before.map(|k| &lifted.contacts[k]).collect()
        };
        let beyond = Beyond::new(contact, &inward, by);
        // The overruns of strips that lag are so long that the change of the curvature matters.
        let beyond = if footprint.lags() { beyond.with_change(&inward) } else { beyond };
        for k in ways {
            let part = k as f64 / steps as f64;
            let mut at = if k == 0 { *contact } else { beyond.at(part) };
            if axis.is_some_and(|axis| at.normal.dot(axis) <= 0.0) {
                // The surface ends before it faces away.
                at.normal = contact.normal;
            }
            push(at, *point);
        }
    }
    out
}

/// The continuation of a pass beyond its end: on the parabola that it follows before the end, in the tangent plane
/// and, like the surface, out of it.
struct Beyond {
    end: Contact,
    /// Its direction in the tangent plane.
    line: Parabola,
    /// Change of the normal along the way, per mm.
    turn: DVec3,
    /// Half the change of that, per mm².
    change: DVec3,
    /// Along the feed at the end of a pass, against it at the start.
    sign: f64,
}

impl Beyond {
    /// `inward`: the other contacts of the pass, the nearest first; `by`: length of the overrun, mm, negative before
    /// the start of the pass.
    fn new(end: &Contact, inward: &[&Contact], by: f64) -> Self {
        let far = by.abs();
        let inward = &without_branches(end, inward, 2.0 * far)[..];
        let flat = |v: DVec3| v.reject_from(end.normal);
        let is_far = |c: &&&Contact| c.position.distance(end.position) >= far;
        let beside = inward.iter().find(is_far).or(inward.last()).map_or(*end, |c| **c);
        let chord = end.position - beside.position;
        let turn = match chord.length() {
            0.0 => DVec3::ZERO,
            length => (end.normal - beside.normal) / length,
        };
        let back = |way: f64| at_way(end, inward, way).map(|p| flat(p - end.position));
        let line = Parabola::beyond(far, back).unwrap_or(Parabola::straight(flat(chord), far));
        Self { end: *end, line, turn, change: DVec3::ZERO, sign: by.signum() }
    }

    /// As above, but straight, as gaps beside it are measured; the normal follows a parabola through those of the end
    /// and of the points once and twice as far before it as the overrun is long; it is left unchanged where the
    /// curvature would more than double.
    fn with_change(self, inward: &[&Contact]) -> Self {
        let far = self.line.way.length();
        let straight = Self { line: Parabola::straight(self.line.way, far), ..self };
        let line = without_branches(&self.end, inward, 2.0 * far);
        let before = |way: f64| {
            let contact = line.iter().find(|c| c.position.distance(self.end.position) >= way)?;
            let way = contact.position.distance(self.end.position);
            (way > 0.0).then(|| (way, (self.end.normal - contact.normal) / way))
        };
        let Some(((near, first), (far, second))) = before(far).zip(before(2.0 * far)) else {
            return straight;
        };
        // n(-s) = n - a s + b s².
        let change = (first - second) / (far - near);
        let turn = first + change * near;
        let is_sound = change.is_finite() && change.length() * near <= turn.length();
        if is_sound { Self { turn, change, ..straight } } else { straight }
    }

    /// The contact at a fraction of the overrun.
    fn at(&self, part: f64) -> Contact {
        let Self { end, line, turn, change, sign } = *self;
        let aside = line.at(part);
        let far = aside.length();
        Contact {
            position: end.position + aside
                - end.normal * ((0.5 * turn + change * (far / 3.0)).dot(aside) * far),
            normal: (end.normal + turn * far + change * (far * far)).normalize_or(end.normal),
            feed_direction: line.heading(part) * sign,
            ..end
        }
    }
}

/// The contacts back to a given distance from the end, mm, without the overruns between.
fn without_branches<'a>(end: &Contact, inward: &[&'a Contact], back: f64) -> Vec<&'a Contact> {
    let mut line: Vec<&Contact> = Vec::new();
    for &contact in inward {
        let is_here = |c: &&Contact| c.position.distance(contact.position) < SAME;
        match line.iter().rposition(is_here) {
            Some(k) => line.truncate(k + 1),
            None => line.push(contact),
        }
        // A branch may begin just before.
        if contact.position.distance(end.position) > 2.0 * back {
            break;
        }
    }
    line
}

/// The point at a given distance back along a pass, mm; `None` where the pass is shorter.
fn at_way(end: &Contact, inward: &[&Contact], way: f64) -> Option<DVec3> {
    let (mut from, mut left) = (end.position, way);
    for contact in inward {
        let length = contact.position.distance(from);
        if length >= left && length > 0.0 {
            return Some(from.lerp(contact.position, left / length));
        }
        left -= length;
        from = contact.position;
    }
    None
}
