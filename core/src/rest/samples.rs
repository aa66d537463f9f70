//! Places at which the height that a path leaves is measured.
//!
//! - *Over faces*: all over the surface, for cutters with a flat bottom, whose edge leaves narrow peaks anywhere.
//! - *Beside passes*: for a ball, where the ball alone would leave a little more than the limit on either side of a
//!   pass and around its ends. What no pass covers is bounded by such places and by the rim: if these are low enough,
//!   everything is.
//! - *Over edges*: on faces across which the surface turns away. There a cutter leaves little on the edge itself and much just
//!   beside it, on strips narrower than the distance between other samples.
//! - *On the rim*: along the boundary, where passes end.

use crate::flatten::{Chart, Locator};
use crate::geometry::math::{cos, sin};
use crate::geometry::{DVec2, DVec3, OrderBy};
use crate::link::Delivered;
use crate::mesh::{FaceId, HalfEdgeId, VertexId};
use crate::surface::{Surface, SurfacePoint};
use crate::toolpath::MoveKind;
use core::cell::RefCell;
use core::f64::consts::{FRAC_1_SQRT_2, TAU};

/// Distance between samples over faces, side steps. Larger: high places are overlooked; smaller: time grows
/// quadratically.
const SPACING: f64 = 0.06;
/// How much denser they are beside the boundary, where the affected places are small.
const DENSER: f64 = 4.0;
/// Distance between samples on the rim, side steps.
const ON_RIM: f64 = 0.02;
/// Cosine of the angle between normals at corners of a face, from which on it lies across an edge (25 degrees).
const EDGE: f64 = 0.906_307_787;
/// Distance between samples along edges, side steps.
const ALONG_EDGE: f64 = 0.05;
/// Distance along a pass of the samples beside it, side steps.
const ALONG: f64 = 0.2;
/// Distance to which higher places beside those samples are searched, side steps.
const AROUND: f64 = 0.02;
/// Height above the limit at which the ball alone passes over the samples beside its pass.
const BEYOND: f64 = 1.02;
/// Bisection steps to the place where it does.
const STEPS: usize = 3;
/// A turn of a pass by more than this, rad, is checked on its outer side.
const TURN: f64 = 0.35;
/// How often samples around one can be refined.
pub const LEVELS: u8 = 2;
/// Number of additional samples along and across each sample that is nearly too high.
const FINER: u32 = 3;
/// Fraction of that sample's area that they cover: no branch reaches what lies on the boundary itself.
const INNER: f64 = 0.9;
/// Length of steps toward higher places, sample distances.
const BESIDE: f64 = 2.0;
/// Distances, side steps, and directions from which a cutter may reach a place that it cannot touch.
const FROM: [f64; 5] = [0.1, 0.2, 0.3, 0.4, 0.5];
const AROUND_IT: u32 = 16;
/// Weight of the opposite corner at samples on the rim.
const OFF_RIM: f64 = 1e-9;
/// Samples beside passes that are handed over together.
const RUN: usize = 1 << 17;
/// Greatest number of samples over faces, over edges and on the rim; on larger surfaces they are less dense.
const MOST: f64 = 2e6;
const MOST_OVER_EDGES: f64 = 4e5;
const MOST_ON_RIM: f64 = 2e5;

/// A place of the surface.
#[derive(Copy, Clone)]
pub struct Sample {
    /// Position, mm.
    pub at: DVec3,
    /// Unit normal.
    pub normal: DVec3,
    /// Its flat image.
    pub flat: DVec2,
    /// mm per flat mm.
    pub scale: f64,
    /// Distance between samples here, mm.
    pub spacing: f64,
    /// Where it is on the boundary.
    pub rim: Option<Rim>,
    /// The face.
    pub face: FaceId,
    /// How often samples around it were refined.
    pub level: u8,
    /// How many branches over it had no effect.
    pub branches: u8,
    /// Whether it is nearly too high and clearly higher than those before and behind it beside the same pass.
    pub is_top: bool,
    /// Whether its surroundings were searched for higher places.
    pub is_climbed: bool,
    /// At what flat distance beside it the cutter has to touch to lower it.
    pub beside: DVec2,
}

/// A place on a side of the boundary.
#[derive(Copy, Clone)]
pub struct Rim {
    /// The side.
    pub side: HalfEdgeId,
    /// Fraction of the edge that lies before it.
    part: f32,
}

/// The ball whose path is checked.
#[derive(Copy, Clone)]
pub struct Ball {
    /// Radius, mm.
    pub radius: f64,
    /// Allowance, mm.
    pub allowance: f64,
    /// The limit, mm.
    pub limit: f64,
}

/// Places of samples on a surface.
#[derive(Copy, Clone)]
pub struct Places<'a> {
    /// The surface.
    pub surface: &'a Surface,
    /// Its chart.
    pub chart: &'a Chart,
    /// Over its flat faces.
    pub locator: &'a Locator<'a>,
    /// Distance between passes, mm.
    pub side_step: f64,
}

impl Places<'_> {
    /// Evenly over all faces.
    pub fn over_faces(&self) -> Vec<Sample> {
        let mut out = Vec::new();
        let asked = self.side_step * SPACING;
        let share = (asked * asked).max(self.surface.area() / MOST);
        let mut due = 0.0;
        for face_id in self.faces_by_place() {
            let face = self.surface.connectivity().face(face_id);
            let [a, b, c] = self.surface.corners(face_id);
            let area = 0.5 * (b - a).cross(c - a).length();
            let is_rim = face.iter().any(|v| self.surface.connectivity().is_boundary(*v));
            let share = if is_rim { share / DENSER } else { share };
            let n = (area / share).sqrt().ceil().clamp(1.0, 1e3) as usize;
            for weights in thirds(n) {
                due += area / (n * n) as f64;
                if due >= share {
                    due -= share;
                    let place = SurfacePoint { face: face_id, weights };
                    out.push(self.sample(place, share.sqrt()));
                }
            }
        }
        out
    }

    /// On faces across edges, by their length.
    pub fn over_edges(&self) -> Vec<Sample> {
        let faces = (0..self.surface.connectivity().face_count() as u32).map(FaceId);
        let edges: Vec<FaceId> = faces.filter(|f| self.is_across_edge(*f)).collect();
        let longest = |f: &FaceId| {
            let [a, b, c] = self.surface.corners(*f);
            a.distance(b).max(b.distance(c)).max(c.distance(a))
        };
        let asked = self.side_step * ALONG_EDGE;
        let length: f64 = edges.iter().map(longest).sum();
        let spacing = asked.max(length / MOST_OVER_EDGES);
        let mut out = Vec::new();
        let mut due = 0.5;
        for face in edges {
            let n = (longest(&face) / spacing).ceil().clamp(1.0, 1e3) as usize;
            for weights in thirds(n) {
                due += longest(&face) / (spacing * (n * n) as f64);
                if due >= 1.0 {
                    due -= 1.0;
                    out.push(self.sample(SurfacePoint { face, weights }, spacing));
                }
            }
        }
        out
    }

    /// Whether the normals at two corners of a face diverge by much.
    fn is_across_edge(&self, face: FaceId) -> bool {
        let normals = self.surface.vertex_normals();
        let normal = self.surface.connectivity().face(face).map(|v| normals[v.index()]);
        let corner = self.surface.corners(face);
        [(0, 1), (1, 2), (2, 0)].into_iter().any(|(a, b)| {
            let is_convex = (normal[b] - normal[a]).dot(corner[b] - corner[a]) > 0.0;
            is_convex && normal[a].dot(normal[b]) < EDGE
        })
    }

    /// The faces in the order of a curve that fills squares of the chart one after the other (Morton 1966): where
    /// faces are smaller than the distance between samples, taking every n-th face leaves no gaps.
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
        keyed.order_total();
        keyed.into_iter().map(|(_, f)| FaceId(f)).collect()
    }

    /// At a flat place; `None` outside of the chart.
    pub fn at(&self, flat: DVec2) -> Option<Sample> {
        let place = self.locator.locate(flat).ok()?;
        Some(self.sample(place, self.side_step * SPACING))
    }

    /// Along the boundary.
    pub fn on_rim(&self) -> Vec<Sample> {
        let connectivity = self.surface.connectivity();
        let all = (0..3 * connectivity.face_count() as u32).map(HalfEdgeId);
        let outer = all.filter(|h| connectivity.opposite(*h).is_none());
        let sides: Vec<Rim> = outer.map(|side| Rim { side, part: 0.5 }).collect();
        let length: f64 = sides.iter().map(|rim| self.length(rim.side)).sum();
        let asked = (self.side_step * ON_RIM).max(length / MOST_ON_RIM);
        let along = |rim: &Rim| {
            let count = (self.length(rim.side) / asked).ceil().max(1.0);
            self.along(*rim, self.length(rim.side) / count, count as u32, 1.0)
        };
        sides.iter().flat_map(along).collect()
    }

    /// On both sides of the passes of a ball, around their ends and outside of their turns. `seen` takes them in runs of
    /// about [`RUN`]: on a large surface they are too many to be kept.
    pub fn beside_passes(&self, path: &Delivered, ball: &Ball, mut seen: impl FnMut(Vec<Sample>)) {
        let out = RefCell::new(Vec::new());
        let mut hint = FaceId(0);
        // Part of the way to the next samples that is done.
        let mut due = 0.5;
        let mut add = |at: DVec2, directions: &[DVec2]| {
            let place = self.locator.locate_from(hint, at).ok()?;
            hint = place.face;
            let middle = self.sample(place, AROUND * self.side_step);
            let mut out = out.borrow_mut();
            out.extend(directions.iter().filter_map(|d| self.edge(&middle, *d, ball)));
            Some(middle.scale)
        };
        let at = |i: usize| path.places.get(i).copied().flatten().map(|place| place.flat);
        let is_cut = |i: usize| {
            let kind = path.toolpath.points.get(i).map(|p| p.kind);
            at(i).is_some() && matches!(kind, Some(MoveKind::Cut | MoveKind::Trochoid))
        };
        let way = |i: usize| (at(i)? - at(i - 1)?).try_normalize();
        for i in (1..path.places.len()).filter(|&i| is_cut(i)) {
            let (Some(from), Some(to)) = (at(i - 1), at(i)) else { continue };
            let Some(ahead) = way(i) else { continue };
            if !is_cut(i - 1) {
                add(from, &fan(-ahead));
            }
            let next = Some(i + 1).filter(|n| is_cut(*n)).and_then(way);
            let turn = next.map_or(0.0, |next| next.distance(ahead));
            let scale = match next {
                None => add(to, &fan(ahead)),
                Some(next) if turn > TURN => add(to, &[(ahead - next).normalize_or(ahead)]),
                Some(_) => add(to, &[]),
            };
            // Short moves, as of a fine curve, share samples.
            let length = from.distance(to) * scale.unwrap_or(0.0);
            // On the outer side of a turn they are farther apart.
            let way = (length / self.side_step + 0.5 * turn) / ALONG;
            let count = (due + way).floor();
            for k in 0..count.min(1e5) as u32 {
                let part = (f64::from(k) + 1.0 - due) / way;
                add(from.lerp(to, part.min(1.0)), &[ahead.perp(), -ahead.perp()]);
            }
            due += way - count;
            if out.borrow().len() >= RUN {
                seen(out.take());
            }
        }
        seen(out.take());
    }

    /// Where a ball that touches `middle` stands a little more than the limit above the surface, in a flat direction.
    fn edge(&self, middle: &Sample, direction: DVec2, ball: &Ball) -> Option<Sample> {
        let centre = middle.at + middle.normal * (ball.radius + ball.allowance);
        let asked = BEYOND * ball.limit;
        let mut away = 0.5 * self.side_step / middle.scale;
        let mut edge = None;
        for _ in 0..STEPS {
            let place =
                self.locator.locate_from(middle.face, middle.flat + direction * away).ok()?;
            let sample = self.sample(place, middle.spacing);
            let off = sample.at - centre;
            let along = off.dot(sample.normal);
            let root = along * along - off.length_squared() + ball.radius * ball.radius;
            // Beside the ball it is nearer.
            let height =
                if root > 0.0 { -along - root.sqrt() - ball.allowance } else { 4.0 * asked };
            let factor = (asked / height.max(f64::MIN_POSITIVE)).sqrt();
            away *= factor.clamp(0.5, 2.0);
            edge = Some(Sample { level: LEVELS, ..sample });
        }
        edge
    }

    fn length(&self, side: HalfEdgeId) -> f64 {
        let corners = self.surface.corners(side.face());
        corners[side.corner()].distance(corners[side.next().corner()]).max(f64::MIN_POSITIVE)
    }

    /// The given number of samples, evenly over that fraction of an edge around a place of it.
    fn along(&self, about: Rim, spacing: f64, count: u32, share: f64) -> Vec<Sample> {
        let place = |i: u32| {
            let off = (f64::from(i) + 0.5) / f64::from(count) - 0.5;
            let part = (f64::from(about.part) + share * off).clamp(0.0, 1.0);
            let mut weights = [OFF_RIM; 3];
            weights[about.side.corner()] = (1.0 - part) * (1.0 - OFF_RIM);
            weights[about.side.next().corner()] = part * (1.0 - OFF_RIM);
            let place = SurfacePoint { face: about.side.face(), weights };
            let rim = Rim { part: part as f32, ..about };
            Sample { rim: Some(rim), ..self.sample(place, spacing) }
        };
        (0..count).map(place).collect()
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
            scale: (area / flat.max(f64::MIN_POSITIVE)).sqrt(),
            spacing,
            rim: None,
            face,
            level: 0,
            branches: 0,
            is_top: false,
            is_climbed: false,
            beside: DVec2::ZERO,
        }
    }

    /// More closely spaced samples around one.
    pub fn about(&self, sample: &Sample) -> Vec<Sample> {
        let (spacing, of_one) = (sample.spacing, 1.0 / f64::from(FINER));
        let level = sample.level + 1;
        if let Some(rim) = sample.rim {
            let share = spacing / self.length(rim.side);
            let more = self.along(rim, spacing * of_one, FINER, share);
            return more.into_iter().map(|s| Sample { level, ..s }).collect();
        }
        let side = spacing / sample.scale;
        let offset = |i: u32| INNER * ((f64::from(i) + 0.5) * of_one - 0.5) * side;
        let offsets = (0..FINER * FINER).map(|i| DVec2::new(offset(i % FINER), offset(i / FINER)));
        self.at_offsets(sample, offsets, spacing * of_one, level)
    }

    /// The places around a sample, a little farther away than the distance between samples.
    pub fn beside(&self, sample: &Sample) -> Vec<Sample> {
        let side = BESIDE * sample.spacing;
        let Sample { spacing, level, .. } = *sample;
        if let Some(rim) = sample.rim {
            let off = (side / self.length(rim.side)) as f32;
            let moved = |off: f32| Rim { part: rim.part + off, ..rim };
            let both = [-off, off].into_iter().flat_map(|o| self.along(moved(o), spacing, 1, 0.0));
            return both.map(|s| Sample { level, ..s }).collect();
        }
        let offset = |i: u32| (f64::from(i) - 1.0) * side / sample.scale;
        let offsets = (0..9).filter(|i| *i != 4).map(|i| DVec2::new(offset(i % 3), offset(i / 3)));
        self.at_offsets(sample, offsets, spacing, level)
    }

    /// Places from which a cutter that cannot touch a sample may reach it, the nearest first.
    pub fn around(&self, sample: &Sample) -> impl Iterator<Item = Sample> {
        let side = self.side_step / sample.scale;
        let (face, flat, spacing) = (sample.face, sample.flat, sample.spacing);
        let offset = move |(distance, i): (f64, u32)| {
            let turn = TAU * f64::from(i) / f64::from(AROUND_IT);
            DVec2::new(cos(turn), sin(turn)) * distance * side
        };
        let offsets = FROM.into_iter().flat_map(|d| (0..AROUND_IT).map(move |i| (d, i)));
        offsets.map(offset).filter_map(move |offset| {
            let place = self.locator.locate_from(face, flat + offset).ok()?;
            Some(self.sample(place, spacing))
        })
    }

    fn at_offsets(
        &self,
        sample: &Sample,
        offsets: impl Iterator<Item = DVec2>,
        spacing: f64,
        level: u8,
    ) -> Vec<Sample> {
        let at = |off: DVec2| {
            let place = self.locator.locate_from(sample.face, sample.flat + off).ok()?;
            Some(Sample { level, ..self.sample(place, spacing) })
        };
        offsets.filter_map(at).collect()
    }

    /// A sample's flat place; on the rim, moved inside by the given number of side steps.
    pub fn inside(&self, sample: &Sample, steps: f64) -> DVec2 {
        let Some(Rim { side, .. }) = sample.rim else { return sample.flat };
        let face = self.surface.connectivity().face(side.face());
        let uv = face.map(|v| self.chart.uv()[v.index()]);
        let way = uv[side.next().corner()] - uv[side.corner()];
        let inward = way.perp().normalize_or_zero() * self.side_step / sample.scale;
        let moved = sample.flat + inward * steps;
        self.locator.locate_from(sample.face, moved).map_or(sample.flat, |_| moved)
    }
}

/// Directions ahead and to both sides.
fn fan(ahead: DVec2) -> [DVec2; 5] {
    let side = ahead.perp();
    let [left, right] = [side, -side].map(|s| (ahead + s) * FRAC_1_SQRT_2);
    [side, left, ahead, right, -side]
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
