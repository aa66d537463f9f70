//! Walls beside the surface: where its boundary is a wall, those of a part that a flat bottom reaches, and what is avoided.
//!
//! - *Own wall*: a face of the part that meets the boundary and rises there.
//! - *Swept wall*: elsewhere, the boundary edge moved up along the tool axis or along the surface's normal.
//! - *Wall of a reached part*: a face that rises beside level ground, for a cutter with a flat bottom on that.
//! - *Avoided mesh*: a mesh from which the job keeps the cutter a distance, independent of the boundary.
//!
//! Steps: (1) each edge of the boundary has an own wall or gets a swept one. (2) Own walls continue over the part's
//! steep faces. (3) All are represented by rulings: swept ones in their sweep direction, own ones straight up their
//! facets, as are the steep facets of avoided meshes.

use crate::cutter_location::{
    Avoided, CheckMesh, Obstacles, PassOptions, Ruling, Stand, Standing, ToolAxis, tip, tool_axis,
};
use crate::flatten::Locator;
use crate::geometry::{DVec2, DVec3, OrderBy};
use crate::level_set::PassMesh;
use crate::mesh::{FaceId, HalfEdgeId, VertexId};
use crate::parallel;
use crate::surface::{Part, Surface};
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

/// Sine of the angle to the surface from which on an adjacent face is a wall: 45 degrees.
const STEEP: f64 = core::f64::consts::FRAC_1_SQRT_2;
/// Cosine to the axis of a cutter with a flat bottom on level ground below which a face rises there: 10 degrees. It is
/// lifted over what rises less.
const RISING: f64 = 0.985;
/// Greatest number of rulings. More: memory; fewer: between two rulings a cutter may enter the wall by more than an
/// eighth of the tolerance, which the check against its facets then shows.
const MOST_RULINGS: f64 = 2e6;

/// Direction in which walls rise.
#[derive(Copy, Clone, Debug, PartialEq)]
pub enum Sweep {
    /// Along this unit axis.
    Axis(DVec3),
    /// Along the surface's normal at its boundary.
    Normal,
}

/// Walls of a job.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct WallOptions {
    /// The direction in which they rise.
    pub sweep: Sweep,
    /// How high swept walls stand above the boundary, mm.
    pub height: f64,
    /// Allowance on the part's own walls, mm.
    pub allowance: f64,
    /// Distance between rulings, mm.
    pub spacing: f64,
}

impl WallOptions {
    /// Distance between rulings for a cutter of that radius that may enter walls by `tolerance`, mm.
    pub fn spacing(radius: f64, tolerance: f64) -> f64 {
        (radius * tolerance).sqrt()
    }
}

/// Walls beside a surface.
#[derive(Clone, Debug, Default)]
pub struct Walls {
    /// `#V` positions of the swept walls, mm.
    positions: Vec<DVec3>,
    /// Their facets, `#F` triples.
    faces: Vec<[u32; 3]>,
    /// Rulings of all.
    rulings: Vec<Ruling>,
    /// Avoided meshes, those at the same distance as one.
    avoided: Vec<(f64, Part)>,
}

/// A side of the boundary, the surface on its left.
#[derive(Copy, Clone)]
struct Side {
    ends: [VertexId; 2],
    /// Unit normal of the surface's face there.
    normal: DVec3,
    /// Unit direction into the surface.
    inward: DVec3,
}

type Bits = [u64; 3];

impl Walls {
    /// The walls along the whole boundary of a surface; `rest`: the other faces of its part.
    pub fn beside(surface: &Surface, rest: &Part, options: &WallOptions) -> Self {
        let sides = sides(surface);
        let steep = SteepFaces::new(rest);
        let mut out = Self::default();
        let mut own: Vec<(usize, DVec3)> = Vec::new();
        let mut swept: Vec<Side> = Vec::new();
        for side in &sides {
            let ends = side.ends.map(|v| surface.positions()[v.index()]);
            match steep.rising(ends, side.normal) {
                Some(face) => own.push((face, up(options.sweep, side.normal))),
                None => swept.push(*side),
            }
        }
        out.sweep(surface, &swept, options);
        for (face, up) in steep.spread(own) {
            out.rule_facet(steep.corners(face), up, options, true);
        }
        out
    }

    /// Rulings of all faces of a part but those that are nearly level, up to `short` mm below their upper ends: a cutter at
    /// the height of that stands on the face, not beside it.
    pub fn of_part(part: &Part, axis: DVec3, short: f64, options: &WallOptions) -> Self {
        let corners = part.faces.iter().map(|f| f.map(|v| part.positions[v as usize]));
        let steep: Vec<[DVec3; 3]> =
            corners.filter(|c| face_normal(*c).dot(axis).abs() < RISING).collect();
        let mut out = Self::default();
        out.rule_facets(&steep, axis, options);
        out.rulings.retain_mut(|ruling| {
            let up = ruling.to - ruling.from;
            let part = 1.0 - short / up.dot(axis);
            ruling.to = ruling.from + up * part;
            ruling.beside_level = true;
            part > 0.0
        });
        out
    }

    /// Adds all of a mesh from which the cutter keeps `distance` mm. Rulings are made only within `near` mm of the
    /// surface, as seen by the tool.
    pub fn avoid(
        &mut self,
        mesh: &Part,
        distance: f64,
        surface: &Surface,
        options: &WallOptions,
        near: f64,
    ) {
        match self.avoided.iter_mut().find(|(other, _)| *other == distance) {
            Some((_, all)) => all.add(mesh),
            None => self.avoided.push((distance, mesh.clone())),
        }
        let up = match options.sweep {
            Sweep::Axis(axis) => axis,
            Sweep::Normal => {
                surface.vertex_normals().iter().copied().sum::<DVec3>().normalize_or(DVec3::Z)
            }
        };
        let across = |p: DVec3| match options.sweep {
            Sweep::Axis(axis) => p.reject_from(axis),
            Sweep::Normal => p,
        };
        let bounds = |places: &mut dyn Iterator<Item = DVec3>| {
            places.fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(l, h), p| (l.min(p), h.max(p)))
        };
        let (low, high) = bounds(&mut surface.positions().iter().map(|&p| across(p)));
        let is_near = |corners: &[DVec3; 3]| {
            let (l, h) = bounds(&mut corners.iter().map(|&p| across(p)));
            l.cmple(high + near).all() && h.cmpge(low - near).all()
        };
        let corners = |f: &[u32; 3]| f.map(|v| mesh.positions[v as usize]);
        let is_steep = |corners: &[DVec3; 3]| face_normal(*corners).dot(up).abs() <= STEEP;
        let ruled: Vec<[DVec3; 3]> =
            mesh.faces.iter().map(corners).filter(|c| is_steep(c) && is_near(c)).collect();
        self.rule_facets(&ruled, up, &WallOptions { allowance: distance, ..*options });
    }

    /// How far these walls reach at most, and what is avoided with its distance, by a measure of places; minus infinity
    /// where there is nothing.
    pub fn top(&self, reach: impl Fn(&DVec3) -> f64) -> (f64, f64) {
        let top = |places: &[DVec3]| places.iter().map(&reach).fold(f64::NEG_INFINITY, f64::max);
        let avoided = self.avoided.iter().map(|(distance, mesh)| top(&mesh.positions) + distance);
        (top(&self.positions), avoided.fold(f64::NEG_INFINITY, f64::max))
    }

    /// What the cutter must keep clear of: the part and these walls.
    pub fn obstacles(self, part: Arc<CheckMesh>) -> Obstacles {
        let mesh = |(distance, Part { positions, faces }): (f64, Part)| Avoided {
            mesh: CheckMesh::new(positions, faces),
            distance,
        };
        let avoided = self.avoided.into_iter().map(mesh).collect();
        let walls = CheckMesh::new(self.positions, self.faces);
        Obstacles::with_walls(part, walls, avoided, self.rulings)
    }

    fn sweep(&mut self, surface: &Surface, sides: &[Side], options: &WallOptions) {
        let directions = directions(surface, sides, options.sweep);
        let inwards = inwards(sides);
        let at = |v: &VertexId| surface.positions()[v.index()];
        let length: f64 = sides.iter().map(|s| at(&s.ends[0]).distance(at(&s.ends[1]))).sum();
        let spacing = options.spacing.max(length / MOST_RULINGS);
        for side in sides {
            let [a, b] = side.ends;
            let (from, to) = (at(&a), at(&b));
            let (up, next) = (directions[&a], directions[&b]);
            let first = self.positions.len() as u32;
            let tops = [from + up * options.height, to + next * options.height];
            self.positions.extend([from, to, tops[1], tops[0]]);
            self.faces.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
            let count = (from.distance(to) / spacing).ceil().max(1.0) as u32;
            for i in 0..=count {
                let t = f64::from(i) / f64::from(count);
                let inward = match i {
                    0 => inwards[&a],
                    i if i == count => inwards[&b],
                    _ => side.inward,
                };
                let (from, to) = (from.lerp(to, t), tops[0].lerp(tops[1], t));
                self.rulings.push(Ruling {
                    from,
                    to,
                    inward,
                    allowance: 0.0,
                    clears_behind: true,
                    beside_level: false,
                });
            }
        }
    }

    /// Rulings straight up facets, behind which the cutter has no place.
    fn rule_facets(&mut self, facets: &[[DVec3; 3]], up: DVec3, options: &WallOptions) {
        let width = |c: &[DVec3; 3]| (c[1] - c[0]).length().max((c[2] - c[0]).length());
        let all: f64 = facets.iter().map(width).sum();
        let spacing = options.spacing.max(all / MOST_RULINGS);
        let options = WallOptions { spacing, ..*options };
        facets.iter().for_each(|corners| self.rule_facet(*corners, up, &options, false));
    }

    /// Rulings straight up a facet.
    fn rule_facet(
        &mut self,
        corners: [DVec3; 3],
        up: DVec3,
        options: &WallOptions,
        clears_behind: bool,
    ) {
        let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalize_or_zero();
        let Some(steepest) = up.reject_from(normal).try_normalize() else { return };
        let across = normal.cross(steepest);
        let mut places = corners.map(|c| c.dot(across)).to_vec();
        let low = places.iter().copied().fold(f64::INFINITY, f64::min);
        let high = places.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let count = ((high - low) / options.spacing).ceil().clamp(1.0, MOST_RULINGS);
        places.extend((1..count as u32).map(|i| low + (high - low) * f64::from(i) / count));
        for place in places {
            let on = |i: usize| {
                let (a, b) = (corners[i], corners[(i + 1) % 3]);
                let (s, t) = (a.dot(across) - place, b.dot(across) - place);
                // A side along the ruling is met at its ends, by the other sides.
                (s * t <= 0.0 && s != t).then(|| a.lerp(b, s / (s - t)))
            };
            let met = (0..3).filter_map(on);
            let ends = met.fold(None, |ends: Option<(DVec3, DVec3)>, p| {
                let (low, high) = ends.unwrap_or((p, p));
                let lower = p.dot(steepest) < low.dot(steepest);
                let higher = p.dot(steepest) > high.dot(steepest);
                Some((if lower { p } else { low }, if higher { p } else { high }))
            });
            // What a mere corner of a facet would tell, its neighbours tell better.
            if let Some((from, to)) = ends.filter(|(from, to)| clears_behind || from != to) {
                self.rulings.push(Ruling {
                    from,
                    to,
                    inward: normal,
                    allowance: options.allowance,
                    clears_behind,
                    beside_level: false,
                });
            }
        }
    }
}

fn up(sweep: Sweep, normal: DVec3) -> DVec3 {
    match sweep {
        Sweep::Axis(axis) => axis,
        Sweep::Normal => normal,
    }
}

/// The sides of the boundary, in the order of the faces.
fn sides(surface: &Surface) -> Vec<Side> {
    let connectivity = surface.connectivity();
    let all = (0..3 * connectivity.face_count() as u32).map(HalfEdgeId);
    let outer = all.filter(|h| connectivity.opposite(*h).is_none());
    let side = |h: HalfEdgeId| {
        let (a, b) = connectivity.ends(h);
        let normal = face_normal(surface.corners(h.face()));
        let way = surface.positions()[b.index()] - surface.positions()[a.index()];
        Side { ends: [a, b], normal, inward: normal.cross(way).normalize_or_zero() }
    };
    outer.map(side).collect()
}

fn face_normal([a, b, c]: [DVec3; 3]) -> DVec3 {
    (b - a).cross(c - a).normalize_or_zero()
}

/// The direction in which the wall rises at the ends of boundary edges.
fn directions(surface: &Surface, sides: &[Side], sweep: Sweep) -> BTreeMap<VertexId, DVec3> {
    let at = |v: VertexId| match sweep {
        Sweep::Axis(axis) => axis,
        Sweep::Normal => mean_normal(surface, v),
    };
    sides.iter().flat_map(|s| s.ends).map(|v| (v, at(v))).collect()
}

/// Mean of the normals of the faces around a vertex, weighted by area, unit.
fn mean_normal(surface: &Surface, vertex: VertexId) -> DVec3 {
    let connectivity = surface.connectivity();
    let mut sum = DVec3::ZERO;
    let mut add = |face: FaceId| {
        let [a, b, c] = surface.corners(face);
        sum += (b - a).cross(c - a);
    };
    // From the side that leaves it, to one side until the boundary, and to the other.
    let Some(first) = connectivity.leaving(vertex) else { return DVec3::Z };
    add(first.face());
    let mut left = first;
    while let Some(next) = connectivity.opposite(left.prev()).filter(|n| *n != first) {
        add(next.face());
        left = next;
    }
    let is_open = connectivity.opposite(left.prev()).is_none();
    let mut right = first;
    while is_open && let Some(next) = connectivity.opposite(right) {
        right = next.next();
        add(right.face());
    }
    sum.normalize_or(DVec3::Z)
}

/// Mean direction into the surface at the ends of sides.
fn inwards(sides: &[Side]) -> BTreeMap<VertexId, DVec3> {
    let mut sums: BTreeMap<VertexId, DVec3> = BTreeMap::new();
    for side in sides {
        side.ends.iter().for_each(|v| *sums.entry(*v).or_default() += side.inward);
    }
    sums.values_mut().for_each(|sum| *sum = sum.normalize_or_zero());
    sums
}

/// Faces of the rest of a part, by their sides.
struct SteepFaces<'a> {
    rest: &'a Part,
    /// Faces on each side, whose ends are in order.
    beside: BTreeMap<[Bits; 2], Vec<usize>>,
}

impl<'a> SteepFaces<'a> {
    fn new(rest: &'a Part) -> Self {
        let mut beside: BTreeMap<[Bits; 2], Vec<usize>> = BTreeMap::new();
        for (f, face) in rest.faces.iter().enumerate() {
            for key in keys(face.map(|v| rest.positions[v as usize])) {
                beside.entry(key).or_default().push(f);
            }
        }
        Self { rest, beside }
    }

    fn corners(&self, face: usize) -> [DVec3; 3] {
        self.rest.faces[face].map(|v| self.rest.positions[v as usize])
    }

    /// The face on a side that rises from a surface of that normal.
    fn rising(&self, [a, b]: [DVec3; 2], normal: DVec3) -> Option<usize> {
        let along = (b - a).try_normalize()?;
        let rises = |f: &&usize| {
            let off = |c: &DVec3| (*c - a).reject_from_normalized(along);
            let away =
                self.corners(**f).iter().map(off).max_by(|p, q| p.length().total_cmp(&q.length()));
            away.and_then(DVec3::try_normalize).is_some_and(|away| away.dot(normal) >= STEEP)
        };
        self.beside.get(&key(a, b))?.iter().find(rises).copied()
    }

    /// The given faces with their upward directions, and all steep faces connected to them.
    fn spread(&self, from: Vec<(usize, DVec3)>) -> Vec<(usize, DVec3)> {
        let mut known: BTreeSet<usize> = BTreeSet::new();
        let mut open = from;
        let mut out = Vec::new();
        while let Some((face, up)) = open.pop() {
            let corners = self.corners(face);
            if face_normal(corners).dot(up).abs() > STEEP || !known.insert(face) {
                continue;
            }
            out.push((face, up));
            let next = keys(corners).into_iter().filter_map(|key| self.beside.get(&key)).flatten();
            open.extend(next.filter(|f| !known.contains(f)).map(|&f| (f, up)));
        }
        out.order_by_key(|f| f.0);
        out
    }
}

fn keys([a, b, c]: [DVec3; 3]) -> [[Bits; 2]; 3] {
    [key(a, b), key(b, c), key(c, a)]
}

fn key(a: DVec3, b: DVec3) -> [Bits; 2] {
    let [a, b] = [a, b].map(|p| p.to_array().map(f64::to_bits));
    if a <= b { [a, b] } else { [b, a] }
}

/// Fraction of the mesh's edge length by which the outermost pass is laid beyond the line where the cutter touches a
/// wall. The cutter is moved off the wall exactly later on; a pass laid inside stays there: with less, the pass cuts
/// corners.
const BEYOND: f64 = 0.35;
/// The same fraction by which it stays inside the edge of the surface.
const INSIDE: f64 = 0.01;

/// Clearance between cutter and walls where the cutter touches a surface.
#[derive(Copy, Clone)]
pub struct Clearance<'a> {
    /// The surface.
    pub surface: &'a Surface,
    /// Over its chart.
    pub chart: &'a Locator<'a>,
    /// The walls.
    pub obstacles: &'a Obstacles,
    /// How the cutter is located.
    pub pass: PassOptions,
}

impl Clearance<'_> {
    /// At the `#V` vertices of a mesh over the chart, mm: negative where the cutter is in a wall by more than a
    /// fraction of the mesh's edge length, at most the cutter radius.
    pub fn of_mesh(&self, mesh: &PassMesh, threads: usize) -> Vec<f64> {
        let vertices: Vec<VertexId> = (0..mesh.uv().len() as u32).map(VertexId).collect();
        parallel::map(threads, &vertices, |&v| {
            let (sum, count) = (mesh.sides_around(v))
                .fold((0.0, 0u32), |(sum, count), side| (sum + mesh.length(side), count + 1));
            let edge = sum / f64::from(count.max(1));
            let uv = mesh.uv()[v.index()];
            let clear = self.at(uv).map_or(-self.pass.tool.radius(), |c| c + BEYOND * edge);
            // Where the cutter touches the very edge without touching the wall, passes stay on the surface.
            match mesh.connectivity().is_boundary(v) {
                true => clear.min(-INSIDE * edge),
                false => clear,
            }
        })
    }

    /// At a flat point, mm; `None` outside of the chart and where the surface faces away from the cutter.
    fn at(&self, uv: DVec2) -> Option<f64> {
        let point = self.chart.locate(uv).ok()?;
        let (contact, normal) = (self.surface.position(point), self.surface.normal(point));
        let PassOptions { tool, axis: rule, allowance, reach, .. } = self.pass;
        let stand = |feed: DVec3| {
            let axis = tool_axis(rule, normal, feed);
            let tip = tip(&tool, contact, normal, axis, allowance);
            (normal.dot(axis) > 0.0).then(|| {
                self.obstacles.rulings().stand(&Standing { tool, tip, axis, reach }, false)
            })
        };
        let clear = |stand: Option<Stand>| stand.map_or(tool.radius(), |s| -s.depth);
        let upright = stand(DVec3::ZERO)?;
        let leans = matches!(rule, ToolAxis::Lead(lead) if lead > 0.0);
        let least = match upright.filter(|_| leans) {
            None => clear(upright),
            // The pass runs along the wall, one way or the other.
            Some(Stand { away, .. }) => {
                let feed = normal.cross(away);
                clear(stand(feed)?).min(clear(stand(-feed)?))
            }
        };
        Some(least.min(tool.radius()))
    }
}
