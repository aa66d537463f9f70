//! The first, coarse triangulation of a domain: constrained Delaunay of its boundary and a few
//! inner points.

use spade::handles::FixedFaceHandle;
use spade::{ConstrainedDelaunayTriangulation, Point2, Triangulation};

use super::domain::{Domain, distance, inside, sampled};
use super::error::NurbsError;
use super::sizing::Sizing;
use super::surface::NurbsSurface;
use crate::geometry::DVec2;

/// Inner points along a parameter, at most.
const MOST_INNER: usize = 24;
/// Edges that lie between inner points at first.
const COARSENESS: f64 = 4.0;
/// Distance of an inner point from the boundary, in steps between inner points.
const CLEAR: f64 = 0.35;
/// Points of the circle that stands for an outer pole.
const POLE_CIRCLE: usize = 24;

/// A triangulation of a domain; counter-clockwise in the parameters.
pub(super) struct Start {
    /// Parameters of the vertices.
    pub parameters: Vec<DVec2>,
    /// The parameter that has no meaning at a vertex, where the surface has a pole.
    pub free: Vec<Option<usize>>,
    /// Vertices that stay where they are.
    pub fixed: Vec<bool>,
    /// Vertices of the faces, and their parameters there, which do not jump within a face.
    pub faces: Vec<([u32; 3], [DVec2; 3])>,
}

type Delaunay = ConstrainedDelaunayTriangulation<Point2<f64>>;

/// What becomes vertices.
#[derive(Default)]
struct Points {
    parameters: Vec<DVec2>,
    /// Images in the plane.
    flat: Vec<DVec2>,
    /// Vertices that are the same one: the first of each.
    same: Vec<u32>,
    free: Vec<Option<usize>>,
    /// First vertex of each pole of the surface: u low, u high, v low, v high.
    poles: [Option<u32>; 4],
}

impl Points {
    fn add(&mut self, at: DVec2, flat: DVec2, pole: Option<usize>) -> u32 {
        let index = self.parameters.len() as u32;
        self.parameters.push(at);
        self.flat.push(flat);
        self.free.push(pole.map(|side| 1 - side / 2));
        let same = pole.map(|side| *self.poles[side].get_or_insert(index));
        self.same.push(same.unwrap_or(index));
        index
    }
}

impl Start {
    /// Triangulates `domain`, its boundary within `chord` mm of its curves, with `most` points on each loop at most.
    pub fn new(
        surface: &NurbsSurface,
        sizing: &Sizing,
        domain: &Domain,
        (chord, most): (f64, usize),
    ) -> Result<Self, NurbsError> {
        let mut points = Points::default();
        let mut loops: Vec<Vec<u32>> = Vec::new();
        for line in &domain.loops {
            let samples = sampled(surface, sizing, domain, line, (chord, most))?;
            let add = |&p: &DVec2| points.add(p, domain.flat(p), domain.pole_side(surface, p));
            loops.push(samples.iter().map(add).collect());
        }
        add_poles(surface, domain, &mut points, &mut loops);
        let boundary = points.parameters.len();
        let polygons: Vec<Vec<DVec2>> =
            loops.iter().map(|l| l.iter().map(|&v| points.flat[v as usize]).collect()).collect();
        for p in inner(sizing, domain, &polygons) {
            points.add(p, domain.flat(p), None);
        }
        let delaunay = triangulated(surface, &points, &loops)?;
        let faces = faces(&delaunay, &points, domain);
        if faces.is_empty() {
            return Err(NurbsError::BadLoops { why: "they hold no area" });
        }
        let fixed = (0..points.parameters.len()).map(|v| v < boundary).collect();
        Ok(Self { parameters: points.parameters, free: points.free, fixed, faces })
    }
}

/// The pole in the middle of a ring, and the one around it.
fn add_poles(
    surface: &NurbsSurface,
    domain: &Domain,
    points: &mut Points,
    loops: &mut Vec<Vec<u32>>,
) {
    for (k, at) in domain.poles().into_iter().enumerate() {
        let Some(ring) = domain.ring else { return };
        let side = domain.pole_side(surface, at);
        if k == 0 {
            points.add(at, DVec2::ZERO, side);
            continue;
        }
        let around = (0..POLE_CIRCLE).map(|i| {
            let mut p = at;
            let period = domain.high[ring.axis] - domain.low[ring.axis];
            p[ring.axis] += period * i as f64 / POLE_CIRCLE as f64;
            points.add(p, domain.flat(p), side)
        });
        loops.push(around.collect());
    }
}

/// Points on a coarse grid that lie well inside.
fn inner(sizing: &Sizing, domain: &Domain, polygons: &[Vec<DVec2>]) -> Vec<DVec2> {
    let (low, high) = (domain.low, domain.high);
    let middle = 0.5 * (low + high);
    let count = |axis: usize| {
        let mut ends = [middle, middle];
        (ends[0][axis], ends[1][axis]) = (low[axis], high[axis]);
        let edges = sizing.length(ends[0], ends[1]) / sizing.size(middle);
        ((edges / COARSENESS) as usize).min(MOST_INNER)
    };
    let around = |axis: usize| domain.ring.is_some_and(|r| r.axis == axis);
    let counts = [0, 1].map(|axis| match (domain.ring, around(axis)) {
        (None, _) => count(axis),
        // Enough that no triangle reaches around the hole.
        (Some(_), true) => count(axis).max(12),
        (Some(_), false) => count(axis).max(1),
    });
    let at = |axis: usize, k: usize| {
        let shift = if around(axis) { 0.0 } else { 1.0 };
        let part = (k as f64 + shift) / (counts[axis] as f64 + shift);
        low[axis] + (high[axis] - low[axis]) * part
    };
    let mut points = Vec::new();
    for i in 0..counts[0] {
        for j in 0..counts[1] {
            let p = DVec2::new(at(0, i), at(1, j));
            let flat = domain.flat(p);
            let step = |axis: usize| {
                let mut next = p;
                next[axis] += (high[axis] - low[axis]) / (counts[axis] + 1) as f64;
                domain.flat(next).distance(flat)
            };
            let clear = CLEAR * step(0).min(step(1));
            let within = polygons.iter().filter(|l| inside(l, flat)).count() % 2 == 1;
            if within && polygons.iter().all(|l| distance(l, flat) > clear) {
                points.push(p);
            }
        }
    }
    points
}

fn triangulated(
    surface: &NurbsSurface,
    points: &Points,
    loops: &[Vec<u32>],
) -> Result<Delaunay, NurbsError> {
    let crossed =
        |v: u32| NurbsError::LoopsCross { at: surface.point(points.parameters[v as usize]) };
    let mut delaunay = Delaunay::new();
    let mut handles = Vec::with_capacity(points.flat.len());
    for (v, p) in points.flat.iter().enumerate() {
        let handle = delaunay.insert(Point2::new(p.x, p.y)).map_err(|_| crossed(v as u32))?;
        if handle.index() != v {
            return Err(crossed(v as u32));
        }
        handles.push(handle);
    }
    for line in loops {
        for (i, &a) in line.iter().enumerate() {
            let b = line[(i + 1) % line.len()];
            let (from, to) = (handles[a as usize], handles[b as usize]);
            if !delaunay.can_add_constraint(from, to) {
                return Err(crossed(a));
            }
            delaunay.add_constraint(from, to);
            if !delaunay.exists_constraint(from, to) {
                return Err(crossed(a));
            }
        }
    }
    Ok(delaunay)
}

/// The faces inside: those that an odd number of boundary edges parts from the outside.
fn faces(delaunay: &Delaunay, points: &Points, domain: &Domain) -> Vec<([u32; 3], [DVec2; 3])> {
    let mut odd: Vec<Option<bool>> = vec![None; delaunay.num_all_faces()];
    let mut pending: Vec<FixedFaceHandle<_>> = vec![delaunay.outer_face().fix()];
    odd[pending[0].index()] = Some(false);
    for edge in delaunay.convex_hull() {
        let face = edge.rev().face().fix();
        if odd[face.index()].is_none() {
            odd[face.index()] = Some(edge.is_constraint_edge());
            pending.push(face);
        }
    }
    while let Some(face) = pending.pop() {
        let Some(inner) = delaunay.face(face).as_inner() else { continue };
        let own = odd[face.index()].unwrap_or(false);
        for edge in inner.adjacent_edges() {
            let next = edge.rev().face().fix();
            if odd[next.index()].is_none() {
                odd[next.index()] = Some(own != edge.is_constraint_edge());
                pending.push(next);
            }
        }
    }
    let mut faces = Vec::new();
    for face in delaunay.inner_faces().filter(|f| odd[f.fix().index()] == Some(true)) {
        let corners = face.vertices().map(|v| v.fix().index());
        let at = corners.map(|v| points.parameters[v]);
        let merged = corners.map(|v| points.same[v]);
        let [a, b, c] = merged;
        if a == b || b == c || c == a {
            continue;
        }
        // Whole turns are distinguished from a corner that is no pole.
        let near = (0..3).find(|&i| points.free[corners[i]].is_none()).unwrap_or(0);
        let at = match domain.ring {
            Some(ring) => at.map(|p| ring.unwrapped(p, at[near])),
            None => at,
        };
        faces.push(if domain.mirrored() {
            ([a, c, b], [at[0], at[2], at[1]])
        } else {
            (merged, at)
        });
    }
    faces
}
