//! Passes: level curves of a field, closed or ending on the boundary.

use super::field::PassField;
use super::refine::PassMesh;
use crate::geometry::DVec2;
use crate::mesh::{FaceId, HalfEdgeId};

/// Passes on an open boundary run this far inside it, and passes that end there stop this far from it, in passes:
/// visually on the boundary, but with room for rounding before they leave the chart.
pub const INSIDE: f64 = 0.02;
/// Levels closer than this, passes, to the end of the field's range are on it.
const ROUNDING: f64 = 1e-6;
/// Longest overrun, passes. Beyond it the pass deviates too far from the straight line from which gaps are measured.
const LONGEST_OVERRUN: f64 = 1.0;
/// Open passes shorter than this, passes, are left out.
const SHORTEST: f64 = 0.1;

/// A level curve of the field, higher values on its right.
#[derive(Clone, Debug, PartialEq)]
pub struct Pass {
    /// Value of the field, passes.
    pub level: f64,
    /// Flat points, in order; of a closed pass the last is joined to the first.
    pub points: Vec<DVec2>,
    /// Whether it is a ring.
    pub is_closed: bool,
    /// How far an open pass continues straight beyond its start and its end, flat mm, to machine the boundary where
    /// it meets it at a slant.
    pub overrun: [f64; 2],
    /// Half the distance from its neighbours at its start and its end, flat mm; 0 where it does not end on the
    /// boundary.
    pub half: [f64; 2],
    /// How far ahead of its start and its end the boundary lies half way to a neighbour, on the acute side, flat mm.
    pub beside: [f64; 2],
    /// Branches that close gaps beside it; see [`close`](super::close).
    pub branches: Vec<Branch>,
}

impl Pass {
    /// Its points, with the first one repeated at the end of a ring.
    pub fn line(&self) -> impl DoubleEndedIterator<Item = DVec2> + '_ {
        self.points.iter().chain(self.points.first().filter(|_| self.is_closed)).copied()
    }
}

/// A detour of a pass, out and back.
#[derive(Clone, Debug, PartialEq)]
pub struct Branch {
    /// Index of the point of the pass from which it leaves and to which it returns.
    pub at: usize,
    /// Flat points between leaving and returning.
    pub points: Vec<DVec2>,
}

/// Where the outermost passes run.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum Outermost {
    /// At the end of the field's range.
    Edge,
    /// At most half a pass inside of it: gives the fewest passes.
    HalfStrip,
}

/// Levels, one apart, of the rings of a field that is 0 on the boundary or, with negative values
/// outside, on the first ring.
pub fn ring_levels(field: &PassField) -> Vec<f64> {
    let (low, high) = field.range();
    let first = if low < 0.0 { 0.0 } else { INSIDE };
    let rest = (1..).map(f64::from).take_while(|&level| level < high);
    core::iter::once(first).chain(rest).collect()
}

/// As above, half a pass further inside.
pub fn half_levels(field: &PassField) -> Vec<f64> {
    let (_, high) = field.range();
    let first = (0.5_f64).min(0.5 * high);
    (0..).map(|k| first + f64::from(k)).take_while(|&level| level < high).collect()
}

/// Levels of open passes, the outermost ones equally far from both ends of the field's range.
///
/// Half strips are one apart, the first and the last at most half a pass from the ends; with edges the range is
/// divided evenly.
pub fn open_levels(field: &PassField, outermost: Outermost) -> Vec<f64> {
    let (low, high) = field.range();
    let strips = (high - low - ROUNDING).ceil().max(1.0);
    match outermost {
        Outermost::HalfStrip => {
            let first = 0.5 * (low + high - (strips - 1.0));
            (0..strips as u32).map(|k| first + f64::from(k)).collect()
        }
        Outermost::Edge => {
            let inside = INSIDE.min(0.25 * (high - low));
            let step = (high - low - 2.0 * inside) / strips;
            (0..=strips as u32).map(|k| low + inside + step * f64::from(k)).collect()
        }
    }
}

/// Passes at ascending levels, without branches; within a level in order of the first face.
pub fn passes(mesh: &PassMesh, field: &PassField, levels: &[f64]) -> Vec<Pass> {
    let mut tracer = Tracer::new(mesh, field.values());
    let mut passes = Vec::new();
    for (&level, faces) in levels.iter().zip(faces_by_level(mesh, field.values(), levels)) {
        passes.extend(faces.into_iter().filter_map(|face| tracer.trace(face, level)));
        tracer.next_level();
    }
    passes
}

/// For every level the faces it crosses, in order.
fn faces_by_level(mesh: &PassMesh, values: &[f64], levels: &[f64]) -> Vec<Vec<FaceId>> {
    let mut by_level = vec![Vec::new(); levels.len()];
    for (f, face) in mesh.connectivity().faces().iter().enumerate() {
        let v = face.map(|v| values[v.index()]);
        if v.iter().any(|v| !v.is_finite()) {
            continue;
        }
        let low = v.into_iter().fold(f64::INFINITY, f64::min);
        let high = v.into_iter().fold(f64::NEG_INFINITY, f64::max);
        // A level is crossed when low <= level < high.
        let from = levels.partition_point(|&level| level < low);
        let to = levels.partition_point(|&level| level < high);
        for faces in &mut by_level[from..to.max(from)] {
            faces.push(FaceId(f as u32));
        }
    }
    by_level
}

/// Follows level curves through the mesh, each once per level.
struct Tracer<'a> {
    mesh: &'a PassMesh,
    values: &'a [f64],
    seen: Vec<u32>,
    stamp: u32,
}

/// In which direction a level curve is followed.
#[derive(Copy, Clone, PartialEq)]
enum Way {
    /// Higher values on the right.
    Forward,
    /// Higher values on the left.
    Backward,
}

/// The boundary at the end of a level curve, as stored in [`Pass`].
#[derive(Copy, Clone, Default)]
struct Rim {
    overrun: f64,
    half: f64,
    beside: f64,
}

/// How a level curve ends.
#[derive(Copy, Clone, PartialEq)]
enum End {
    /// Where it began.
    Closed,
    /// On a side of the boundary.
    Boundary(HalfEdgeId),
    /// Where the field is unknown.
    Unreached,
}

impl<'a> Tracer<'a> {
    fn new(mesh: &'a PassMesh, values: &'a [f64]) -> Self {
        Self { mesh, values, seen: vec![0; mesh.connectivity().face_count()], stamp: 1 }
    }

    fn next_level(&mut self) {
        self.stamp += 1;
    }

    /// The curve through `face`; `None` if it was traced before or is too short.
    fn trace(&mut self, face: FaceId, level: f64) -> Option<Pass> {
        if self.seen[face.index()] == self.stamp {
            return None;
        }
        let (mut points, end) = self.follow(face, level, Way::Forward);
        if end == End::Closed {
            points.dedup();
            let (none, branches) = ([0.0; 2], Vec::new());
            let pass = Pass {
                level,
                points,
                is_closed: true,
                overrun: none,
                half: none,
                beside: none,
                branches,
            };
            return (pass.points.len() >= 3).then_some(pass);
        }
        self.seen[face.index()] = 0;
        let (mut whole, start) = self.follow(face, level, Way::Backward);
        whole.reverse();
        whole.append(&mut points);
        whole.dedup();
        let pass_size = 1.0 / self.mesh.flat_metric(face)?.mean();
        let [before, after] = self.overruns(&whole, [start, end])?;
        Some(Pass {
            level,
            points: without_ends(whole, pass_size)?,
            is_closed: false,
            overrun: [before.overrun, after.overrun],
            half: [before.half, after.half],
            beside: [before.beside, after.beside],
            branches: Vec::new(),
        })
    }

    /// Overruns of an open curve with these ends, and half its distance from its neighbours there; `None` for a curve
    /// of one point.
    fn overruns(&self, points: &[DVec2], ends: [End; 2]) -> Option<[Rim; 2]> {
        let [first, second, ..] = points else { return None };
        let [.., before, last] = points else { return None };
        let length = |way: DVec2, end: End| match end {
            End::Boundary(side) => self.overrun(way, side).unwrap_or_default(),
            _ => Rim::default(),
        };
        Some([length(*first - *second, ends[0]), length(*last - *before, ends[1])])
    }

    /// How far a curve that leaves the surface through `side` continues: until it is level with the place of the
    /// boundary half a pass from it, on the acute side; and how far to the side that place is.
    fn overrun(&self, way: DVec2, side: HalfEdgeId) -> Option<Rim> {
        let (a, b) = self.mesh.connectivity().ends(side);
        let along = self.mesh.uv()[b.index()] - self.mesh.uv()[a.index()];
        let passes = (self.values[b.index()] - self.values[a.index()]).abs();
        let pass_size = 1.0 / self.mesh.flat_metric(side.face())?.mean();
        let way = way.try_normalize()?;
        let beside = 0.5 * way.dot(along).abs() / passes;
        let half = 0.5 * way.perp_dot(along).abs() / passes;
        let overrun = (beside + INSIDE * pass_size).min(LONGEST_OVERRUN * pass_size);
        Some(Rim { overrun, half: half.min(pass_size), beside: beside + INSIDE * pass_size })
    }

    /// The crossings with the sides through which the curve leaves `face` and those after it, and
    /// how it ends.
    fn follow(&mut self, face: FaceId, level: f64, way: Way) -> (Vec<DVec2>, End) {
        let mut points = Vec::new();
        let mut at = face;
        while self.seen[at.index()] != self.stamp {
            let Some(exit) = self.exit(at, level, way) else { break };
            self.seen[at.index()] = self.stamp;
            points.push(self.crossing(exit, level));
            let Some(next) = self.mesh.connectivity().opposite(exit) else {
                return (points, End::Boundary(exit));
            };
            at = next.face();
            if at == face {
                return (points, End::Closed);
            }
        }
        (points, End::Unreached)
    }

    /// The side through which the curve leaves the face; none where the field does not reach all of
    /// the face.
    ///
    /// A value equal to the level counts as below it, so that no curve passes through a vertex.
    fn exit(&self, face: FaceId, level: f64, way: Way) -> Option<HalfEdgeId> {
        let vertices = self.mesh.connectivity().face(face);
        if vertices.iter().any(|v| !self.values[v.index()].is_finite()) {
            return None;
        }
        (0..3).map(|c| face.half_edge(c)).find(|&h| {
            let (a, b) = self.mesh.connectivity().ends(h);
            let (a, b) = if way == Way::Forward { (a, b) } else { (b, a) };
            self.values[a.index()] > level && self.values[b.index()] <= level
        })
    }

    fn crossing(&self, side: HalfEdgeId, level: f64) -> DVec2 {
        let (a, b) = self.mesh.connectivity().ends(side);
        // From the lower vertex, so that both faces of the side get the same bits.
        let (a, b) = if a < b { (a, b) } else { (b, a) };
        let (u, v) = (self.values[a.index()], self.values[b.index()]);
        self.mesh.uv()[a.index()].lerp(self.mesh.uv()[b.index()], (level - u) / (v - u))
    }
}

/// An open curve shortened at its ends where these lie on the boundary; `None` if little is left.
fn without_ends(points: Vec<DVec2>, pass_size: f64) -> Option<Vec<DVec2>> {
    let mut points = shortened(points, INSIDE * pass_size);
    points.reverse();
    points = shortened(points, INSIDE * pass_size);
    points.reverse();
    let length: f64 = points.windows(2).map(|w| w[0].distance(w[1])).sum();
    (length > SHORTEST * pass_size).then_some(points)
}

/// A polyline without the last `cut` of its length.
pub(crate) fn shortened(mut line: Vec<DVec2>, mut cut: f64) -> Vec<DVec2> {
    while let [.., before, last] = line[..] {
        let length = before.distance(last);
        line.pop();
        if length > cut {
            line.push(last.lerp(before, cut / length));
            break;
        }
        cut -= length;
    }
    line
}

#[cfg(test)]
mod tests;
