//! Degenerate points of the tensor on a mesh.
//!
//! - *Crossing*: a flat face over which the linear field `(p, q)` vanishes once. The field winds around
//!   it once, forward or backward; half of that is the index of the directions.
//! - *Pair*: a wedge and a trisector produced by noise; together they change nothing far away.
//! - *Free area*: vertices at which the field is indistinguishable from zero, as on a plane or a sphere.
//!
//! Steps: the noise and the smoothing that it requires; free areas; crossings; pairs cancelled; every remaining place
//! located again on a height field of high degree, over a disc as large as the noise requires.
//!
//! # Source
//! Delmarcelle, "The visualization of second-order tensor fields", thesis, Stanford 1994: index and
//! kind by the sign of the determinant `delta`.

use super::field::TensorField;
use super::jet::{Patch, Zero};
use super::topology::{Cancelled, DegeneratePoint, FreeArea, Kind};
use crate::geometry::math::cbrt;
use crate::geometry::{DVec2, DVec3, OrderBy, nearest_on_triangle};
use crate::mesh::{FaceId, HalfEdgeId};
use crate::surface::{Surface, SurfacePoint};

/// Places at which the noise is measured.
const NOISE_SAMPLES: usize = 192;
/// Radius over which it is measured, in mean edges.
const NOISE_RADIUS: f64 = 3.6;
/// The standard deviation of a Gaussian, in mean edges, that smooths as much as the default estimate
/// of the curvature does.
const ESTIMATE: f64 = 1.1;
/// Largest noise after smoothing, as a fraction of the field's magnitude.
const NOISE: f64 = 0.01;
/// Largest smoothing, as a fraction of the size.
const SMOOTHEST: f64 = 0.04;
/// Fraction of the curvature below which the field on a mesh is indistinguishable from zero.
const ZERO_ON_MESH: f64 = 0.01;
/// The same where the curvature is exact.
const ZERO_EXACT: f64 = 1e-7;
/// Standard deviations of the noise below which the field is indistinguishable from zero, too.
const TOLD_FROM_NOISE: f64 = 3.0;
/// Fraction of the surface that an area without direction covers at least.
const FREE_SHARE: f64 = 0.01;
/// Smallest distance, in mean edges, within which a wedge and a trisector cancel.
const PAIR_EDGES: f64 = 7.0;
/// The same in standard deviations of the smoothing.
const PAIR_SMOOTHINGS: f64 = 3.0;
/// Fraction of the size to which a place is found.
const PLACE: f64 = 0.0005;
/// First and largest radius of the discs, in mean edges and in parts of the size, and the growth.
const FIRST_DISC: f64 = 4.0;
const LARGEST_DISC: f64 = 0.2;
const GROWTH: f64 = 1.3;
/// Standard deviations that the gradient of the field must exceed.
const SIGNIFICANT: f64 = 3.0;
/// Greatest number of places that are located again; more are noise, of which only the strongest are looked at.
const MOST_PLACES: usize = 256;

/// What is found on a mesh.
#[derive(Debug, Default)]
pub struct Found {
    /// The points.
    pub points: Vec<DegeneratePoint>,
    /// Pairs that were cancelled.
    pub cancelled: Vec<Cancelled>,
    /// Crossings that the noise may have made.
    pub doubtful: usize,
}

/// Sizes of a mesh.
#[derive(Copy, Clone, Debug)]
pub struct Sizes {
    /// Square root of the area, mm.
    pub size: f64,
    /// Edge of an equilateral triangle as large as the mean face, mm.
    pub edge: f64,
}

impl Sizes {
    /// Of a surface.
    pub fn of(surface: &Surface) -> Self {
        let area = surface.area();
        let faces = surface.connectivity().face_count().max(1) as f64;
        Self { size: area.sqrt(), edge: (4.0 * area / (faces * 3f64.sqrt())).sqrt() }
    }

    /// Vertices per mm².
    fn density(&self) -> f64 {
        2.0 / (3f64.sqrt() * self.edge * self.edge)
    }
}

/// What smoothing has done to a field.
#[derive(Copy, Clone, Debug, Default)]
pub struct Smoothing {
    /// Standard deviation of the Gaussian, mm; 0 where the field is exact.
    pub scale: f64,
    /// Standard deviation of the noise that is left, 1/mm.
    pub noise: f64,
}

/// Smooths the field of a mesh as its noise requires, or over `scale` mm.
pub fn smooth(field: &mut TensorField, sizes: Sizes, scale: Option<f64>) -> Smoothing {
    // Second derivatives of white noise under a Gaussian of deviation s: p, which is a quarter of
    // their difference, has the deviation noise / (2 sqrt(16 pi density) s³).
    let per_cube = 0.5 * noise(field.surface(), sizes)
        / (16.0 * core::f64::consts::PI * sizes.density()).sqrt();
    let wanted = scale.unwrap_or_else(|| {
        let square: f64 = field.values().iter().map(|v| v.length_squared()).sum();
        let strength = (square / field.values().len().max(1) as f64).sqrt();
        let cube = per_cube / (NOISE * strength);
        if cube.is_finite() { cbrt(cube) } else { 0.0 }
    });
    let own = ESTIMATE * sizes.edge;
    let scale = wanted.min(SMOOTHEST * sizes.size).max(own);
    field.smooth((scale * scale - own * own).sqrt() / sizes.edge);
    Smoothing { scale, noise: per_cube / (scale * scale * scale) }
}

/// Median distance of the vertices from smooth height fields around places spread over the surface, mm.
fn noise(surface: &Surface, sizes: Sizes) -> f64 {
    let count = surface.positions().len();
    let step = (count / NOISE_SAMPLES).max(1);
    let deviation = |v: usize| {
        let (at, normal) = (surface.positions()[v], surface.vertex_normals()[v]);
        Some(Patch::fit(surface, at, normal, NOISE_RADIUS * sizes.edge)?.deviation)
    };
    let mut all: Vec<f64> = (0..count).step_by(step).filter_map(deviation).collect();
    all.order_by(f64::total_cmp);
    all.get(all.len() / 2).copied().unwrap_or(0.0)
}

/// Areas on which the field is indistinguishable from zero; there it is interpolated from the surroundings.
pub fn free_areas(field: &mut TensorField, noise: f64) -> Vec<FreeArea> {
    let surface = field.surface();
    let part = if surface.parameters().is_some() { ZERO_EXACT } else { ZERO_ON_MESH };
    let bends = field.means().iter().zip(field.values());
    // Half the mean curvature, and the rest.
    let square: f64 = bends
        .map(|(mean, v)| {
            let bend = mean - 0.5 * field.k_tool();
            bend * bend + v.length_squared()
        })
        .sum();
    let count = field.values().len().max(1) as f64;
    let zero = (part * (square / count).sqrt()).max(TOLD_FROM_NOISE * noise);
    let is_zero: Vec<bool> = field.values().iter().map(|v| v.length() <= zero).collect();
    let (areas, marked) = components(surface, &is_zero, FREE_SHARE * surface.area());
    field.fill(&marked);
    areas
}

/// Connected areas of marked vertices larger than `least` mm², and their vertices.
fn components(surface: &Surface, marked: &[bool], least: f64) -> (Vec<FreeArea>, Vec<bool>) {
    let area = vertex_areas(surface);
    let connectivity = surface.connectivity();
    let mut next: Vec<Vec<u32>> = vec![Vec::new(); marked.len()];
    for side in (0..3 * connectivity.face_count() as u32).map(HalfEdgeId) {
        let (a, b) = connectivity.ends(side);
        if marked[a.index()] && marked[b.index()] {
            next[a.index()].push(b.0);
            next[b.index()].push(a.0);
        }
    }
    let (mut areas, mut kept) = (Vec::new(), vec![false; marked.len()]);
    let mut seen = vec![false; marked.len()];
    for start in (0..marked.len()).filter(|&v| marked[v]) {
        let mut found = Vec::new();
        let mut open = vec![start];
        while let Some(v) = open.pop() {
            if !core::mem::replace(&mut seen[v], true) {
                found.push(v);
                open.extend(next[v].iter().map(|&w| w as usize));
            }
        }
        let covered: f64 = found.iter().map(|&v| area[v]).sum();
        if covered > least {
            let sum: DVec3 = found.iter().map(|&v| surface.positions()[v] * area[v]).sum();
            areas.push(FreeArea { area: covered, place: sum / covered });
            found.iter().for_each(|&v| kept[v] = true);
        }
    }
    (areas, kept)
}

/// A third of the faces' areas at every vertex, mm².
fn vertex_areas(surface: &Surface) -> Vec<f64> {
    let mut area = vec![0.0; surface.positions().len()];
    for (f, face) in surface.connectivity().faces().iter().enumerate() {
        let [a, b, c] = surface.corners(FaceId(f as u32));
        let third = (b - a).cross(c - a).length() / 6.0;
        face.iter().for_each(|v| area[v.index()] += third);
    }
    area
}

/// A zero of the linear field over a flat face.
#[derive(Copy, Clone, Debug)]
pub struct Crossing {
    /// Where.
    pub at: SurfacePoint,
    /// Its place, mm.
    pub place: DVec3,
    /// Determinant of the field by flat coordinates, 1/mm² per flat mm².
    pub delta: f64,
}

impl Crossing {
    /// What kind of point it is.
    pub fn kind(&self) -> Kind {
        Kind::of(self.delta)
    }
}

/// All crossings of a field.
pub fn crossings(field: &TensorField) -> Vec<Crossing> {
    let faces = 0..field.surface().connectivity().face_count() as u32;
    // Values that are zero at a vertex would belong to several faces.
    let largest = field.values().iter().map(|v| v.length()).fold(0.0, f64::max);
    let aside = DVec2::new(1e-11, 0.618e-11) * largest;
    faces.filter_map(|f| crossing(field, FaceId(f), aside)).collect()
}

fn crossing(field: &TensorField, face: FaceId, aside: DVec2) -> Option<Crossing> {
    let surface = field.surface();
    let vertices = surface.connectivity().face(face);
    let [a, b, c] = vertices.map(|v| field.values()[v.index()] - aside);
    let parts = [b.perp_dot(c), c.perp_dot(a), a.perp_dot(b)];
    let same = parts.iter().all(|p| *p > 0.0) || parts.iter().all(|p| *p < 0.0);
    if !same {
        return None;
    }
    let sum = parts[0] + parts[1] + parts[2];
    let at = SurfacePoint { face, weights: parts.map(|p| p / sum) };
    let [k, l, m] = vertices.map(|v| field.chart().uv()[v.index()]);
    let delta = sum / (l - k).perp_dot(m - k);
    let place = (0..3).map(|i| surface.corners(face)[i] * at.weights[i]).sum();
    Some(Crossing { at, place, delta })
}

/// Twice the index of the directions along the boundary, summed over its loops with the surface on the left: the
/// crossings' signs must add up to it.
#[cfg(test)]
pub fn turns_of_boundary(field: &TensorField) -> i64 {
    let angle = |v: crate::mesh::VertexId| {
        let value = field.values()[v.index()];
        crate::geometry::math::atan2(value.y, value.x)
    };
    let tau = core::f64::consts::TAU;
    let turn = |line: &Vec<crate::mesh::VertexId>| {
        let n = line.len();
        let step = |i: usize| {
            let turn = angle(line[(i + 1) % n]) - angle(line[i]);
            turn - tau * (turn / tau).round()
        };
        (0..n).map(step).sum::<f64>() / tau
    };
    field.surface().connectivity().boundary_loops().iter().map(turn).sum::<f64>().round() as i64
}

/// Removes pairs of a wedge and a trisector closer than `distance`, the closest first.
pub fn cancel(mut crossings: Vec<Crossing>, distance: f64) -> (Vec<Crossing>, Vec<Cancelled>) {
    let mut pairs = Vec::new();
    for (i, a) in crossings.iter().enumerate() {
        for (j, b) in crossings.iter().enumerate().skip(i + 1) {
            let apart = a.place.distance(b.place);
            if apart < distance && a.kind() != b.kind() {
                pairs.push((apart, i, j));
            }
        }
    }
    pairs.order_by(|a, b| a.0.total_cmp(&b.0).then((a.1, a.2).cmp(&(b.1, b.2))));
    let mut gone = vec![false; crossings.len()];
    let mut cancelled = Vec::new();
    for (apart, i, j) in pairs {
        if !gone[i] && !gone[j] {
            (gone[i], gone[j]) = (true, true);
            let place = 0.5 * (crossings[i].place + crossings[j].place);
            cancelled.push(Cancelled { place, distance: apart });
        }
    }
    let mut index = 0..;
    crossings.retain(|_| index.next().is_some_and(|i: usize| !gone[i]));
    (crossings, cancelled)
}

/// The points of a field on a mesh, `smoothing` mm its standard deviation.
pub fn on_mesh(field: &TensorField, sizes: Sizes, smoothing: f64) -> Found {
    let scale = (PAIR_EDGES * sizes.edge).max(PAIR_SMOOTHINGS * smoothing);
    let mut all = crossings(field);
    all.retain(|c| !field.is_filled(c.at.face));
    let found = all.len();
    all.order_by(|a, b| {
        let order = b.delta.abs().total_cmp(&a.delta.abs());
        order.then(a.at.face.0.cmp(&b.at.face.0))
    });
    all.truncate(16 * MOST_PLACES);
    let (mut left, cancelled) = cancel(all, scale);
    left.truncate(MOST_PLACES);
    let mut points: Vec<DegeneratePoint> = Vec::new();
    for crossing in &left {
        let Some(point) = refined(field, crossing, sizes) else { continue };
        let is_near = |p: &DegeneratePoint| p.place.distance(point.place) < 0.25 * scale;
        if !points.iter().any(is_near) {
            points.push(point);
        }
    }
    points.order_by_key(|p| p.at.face);
    let doubtful = found - 2 * cancelled.len() - points.len();
    Found { points, cancelled, doubtful }
}

/// The place of a crossing on the smallest height field that determines it; `None` where the field around it is
/// indistinguishable from noise.
fn refined(field: &TensorField, crossing: &Crossing, sizes: Sizes) -> Option<DegeneratePoint> {
    let surface = field.surface();
    let mut radius = FIRST_DISC * sizes.edge;
    let (mut place, mut best) = (crossing.place, None);
    loop {
        let normal = surface.normal(at_place(field, place, crossing)?);
        let patch = Patch::fit(surface, place, normal, radius);
        let zero = patch.as_ref().and_then(|patch| {
            let (zero, place) = patch.zero(place)?;
            Some((zero, place, patch.spread, patch.slope_spread))
        });
        if let Some(found) = zero {
            let moved = found.1.distance(place);
            let error = found.2 / found.0.delta().abs().sqrt();
            if best.is_none_or(|(least, _)| error < least) {
                best = Some((error, found));
            }
            if moved > 0.1 * radius && moved < radius {
                place = found.1;
                // Once more around the place; it moves less each time or the disc grows.
            } else if error < PLACE * sizes.size {
                break;
            }
        }
        radius *= GROWTH;
        if radius > LARGEST_DISC * sizes.size {
            break;
        }
    }
    let (_, (zero, place, _, spread)) = best?;
    let is_told = zero.delta().abs().sqrt() > SIGNIFICANT * spread;
    is_told.then(|| point_at(field, place, zero)).flatten()
}

/// The surface point at a place near a crossing.
fn at_place(field: &TensorField, place: DVec3, crossing: &Crossing) -> Option<SurfacePoint> {
    if place == crossing.place {
        return Some(crossing.at);
    }
    nearest(field.surface(), place)
}

fn point_at(field: &TensorField, place: DVec3, zero: Zero) -> Option<DegeneratePoint> {
    let at = nearest(field.surface(), place)?;
    Some(DegeneratePoint::new(field, at, place, zero))
}

/// The surface point nearest to `place`.
fn nearest(surface: &Surface, place: DVec3) -> Option<SurfacePoint> {
    let mut best: Option<(f64, SurfacePoint)> = None;
    for f in 0..surface.connectivity().face_count() as u32 {
        let (face, corners) = (FaceId(f), surface.corners(FaceId(f)));
        let weights = nearest_on_triangle(place, corners);
        let at: DVec3 = (0..3).map(|i| corners[i] * weights[i]).sum();
        let square = at.distance_squared(place);
        if best.is_none_or(|(least, _)| square < least) {
            best = Some((square, SurfacePoint { face, weights }));
        }
    }
    best.map(|(_, at)| at)
}
