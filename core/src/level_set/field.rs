//! Fields whose level curves are the passes.

use super::beyond::beside_ways_on;
use super::error::LevelSetError;
use super::front::{Accuracy, Front};
use super::refine::PassMesh;
use super::strip_metric::{FlatMetric, StripMetric};
use crate::flatten::{Chart, Locator};
use crate::geometry::{DVec2, DVec3, OrderBy};
use crate::mesh::{Connectivity, FaceId, HalfEdgeId, VertexId};
use crate::surface::Surface;

/// Greatest number of passes of a paced field.
const MOST_PASSES: f64 = 20_000.0;
/// Intervals per pass in which a field is paced. More: slower; fewer: the tightest place of an interval affects more
/// than its own pass.
const INTERVALS: f64 = 4.0;
/// A change of the field's gradient from one face to the next, per pass, that leaves gaps.
const SHARP: f64 = 0.4;
/// Level curves at least this fraction of a side step apart count as even.
const EVEN: f64 = 0.9;
/// A vertex nearer to a curve than this, passes, is on it.
const ON_CURVE: f64 = 1e-6;
/// A field that grows by less than this per pass leaves gaps.
const FLAT: f64 = 0.97;
/// A part of a pass whose neighbour is farther away by at most this fraction of the side step needs no branch.
const SLACK: f64 = 0.01;
/// Length of a branch for each unit of length that it closes.
const OUT_AND_BACK: f64 = 2.0;
/// A function that grows by less than this fraction of the distance does not show how far away its zero is.
const HARDLY: f64 = 0.25;
/// Most intervals.
const MOST_INTERVALS: f64 = 4.0e5;

/// A value per vertex of a [`PassMesh`] that grows by at least 1 per pass.
#[derive(Clone, Debug)]
pub struct PassField {
    values: Vec<f64>,
    inside: f64,
}

impl PassField {
    /// Distance in passes from the boundary.
    pub fn from_boundary(mesh: &PassMesh) -> Self {
        let values = Front::solve(mesh, &boundary_sources(mesh), Accuracy::Full, |_| true);
        Self { values, inside: 0.0 }
    }

    /// Distance in passes from some vertices that start with values of their own; what lies below the least of these
    /// is not part of the field.
    pub fn from_values(mesh: &PassMesh, sources: &[(VertexId, f64)]) -> Self {
        let inside = sources.iter().map(|s| s.1).fold(0.0, f64::min);
        let values = Front::solve(mesh, sources, Accuracy::Full, |_| true);
        Self { values, inside }
    }

    /// Distance in passes from the curve on which the cutter touches a wall; negative where the cutter is not clear
    /// of it.
    ///
    /// `clearance`: clearance between cutter and walls at the `#V` vertices, mm, of which only values near zero
    /// matter; `radius`: of the cutter, mm.
    ///
    /// # Errors
    /// [`LevelSetError::NoRoom`] when there is no vertex at which the cutter is clear.
    pub fn from_clearance(
        mesh: &PassMesh,
        clearance: &[f64],
        radius: f64,
    ) -> Result<Self, LevelSetError> {
        let widest = clearance.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        if widest <= 0.0 {
            return Err(LevelSetError::NoRoom { radius, widest: (radius + widest).max(0.0) });
        }
        let slopes = slopes(mesh, clearance);
        let beside = |v: VertexId| clearance[v.index()] / slopes[v.index()];
        let is_clear = |v: VertexId| clearance[v.index()] > 0.0;
        let mut sources: Vec<VertexId> = Vec::new();
        for face in mesh.connectivity().faces() {
            if face.iter().any(|&v| is_clear(v)) && !face.iter().all(|&v| is_clear(v)) {
                sources.extend(face.iter().filter(|&&v| is_clear(v)));
            }
        }
        sources.order_total();
        sources.dedup();
        // Clear all over: the boundary is no nearer than the cutter comes.
        if sources.is_empty() {
            return Ok(Self::from_boundary(mesh));
        }
        let sources: Vec<_> = sources.into_iter().map(|v| (v, beside(v))).collect();
        let mut values = Front::solve(mesh, &sources, Accuracy::Full, is_clear);
        for (v, value) in values.iter_mut().enumerate() {
            if clearance[v] <= 0.0 {
                *value = beside(VertexId(v as u32));
            }
        }
        Ok(Self { values, inside: 0.0 })
    }

    /// Distance in passes from some vertices, between neighbours of which the front starts out straight.
    pub fn from_vertices(mesh: &PassMesh, vertices: &[VertexId], accuracy: Accuracy) -> Self {
        let sources: Vec<_> = vertices.iter().map(|&v| (v, 0.0)).collect();
        let values = Front::solve(mesh, &sources, accuracy, |_| true);
        Self { values, inside: f64::NEG_INFINITY }
    }

    /// Signed distance in passes from a flat curve: positive on its left.
    ///
    /// Where the curve does not divide the surface in two, as beside a hole, the distance has no sign.
    ///
    /// # Errors
    /// [`LevelSetError::NoCurve`] when the curve crosses no face.
    pub fn from_curve(
        mesh: &PassMesh,
        locator: &Locator,
        curve: &[DVec2],
        accuracy: Accuracy,
    ) -> Result<Self, LevelSetError> {
        Self::from_beside(mesh, beside_curve(mesh, locator, curve), accuracy)
    }

    /// As [`from_curve`](Self::from_curve), for the curve continued straight beyond the boundary: passes do not turn
    /// where they meet it.
    ///
    /// # Errors
    /// [`LevelSetError::NoCurve`] when the curve crosses no face.
    pub fn from_curve_going_on(
        mesh: &PassMesh,
        locator: &Locator,
        curve: &[DVec2],
        accuracy: Accuracy,
    ) -> Result<Self, LevelSetError> {
        let mut near = beside_curve(mesh, locator, curve);
        if !near.is_empty() {
            near.extend(beside_ways_on(mesh, curve));
            near.order_by(|a, b| a.0.cmp(&b.0).then(a.1.abs().total_cmp(&b.1.abs())));
            near.dedup_by_key(|n| n.0);
        }
        Self::from_beside(mesh, near, accuracy)
    }

    /// Signed distance in passes from the curve between the vertices with these distances.
    fn from_beside(
        mesh: &PassMesh,
        near: Vec<(VertexId, f64)>,
        accuracy: Accuracy,
    ) -> Result<Self, LevelSetError> {
        if near.is_empty() {
            return Err(LevelSetError::NoCurve);
        }
        let mut side = vec![0i8; mesh.uv().len()];
        for &(v, d) in &near {
            side[v.index()] = if d < 0.0 { -1 } else { 1 };
        }
        let sources = |sign: f64| -> Vec<(VertexId, f64)> {
            let on_side = near.iter().filter(|(_, d)| (*d < 0.0) == (sign < 0.0));
            on_side.map(|&(v, d)| (v, d.abs())).collect()
        };
        let left = Front::solve(mesh, &sources(1.0), accuracy, |v| side[v.index()] >= 0);
        let right = Front::solve(mesh, &sources(-1.0), accuracy, |v| side[v.index()] <= 0);
        let is_parted = left.iter().zip(&right).all(|(l, r)| l.is_infinite() || r.is_infinite());
        let signed = |(l, r): (&f64, &f64)| match (is_parted, l <= r) {
            (_, true) => *l,
            (true, false) => -*r,
            (false, false) => *r,
        };
        let values = left.iter().zip(&right).map(signed).collect();
        Ok(Self { values, inside: f64::NEG_INFINITY })
    }

    /// Any function on the surface, one value per vertex, stretched so that it grows by at least 1 per pass: by 1 at
    /// the tightest place of every pass, except for short stretches whose gaps are cheaper to close by branches than
    /// by closer passes everywhere.
    ///
    /// # Errors
    /// [`LevelSetError::Uneven`] when that takes thousands of passes: in places the function hardly changes.
    pub fn paced(mesh: &PassMesh, raw: &[f64]) -> Result<Self, LevelSetError> {
        let low = raw.iter().copied().fold(f64::INFINITY, f64::min);
        let high = raw.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let paces = paces(mesh, raw);
        if paces.is_empty() {
            return Err(LevelSetError::Uneven { passes: f64::INFINITY });
        }
        let mut sorted: Vec<f64> = paces.iter().map(|p| p.passes).collect();
        sorted.order_by(f64::total_cmp);
        let typical = sorted.get(sorted.len() / 2).copied().unwrap_or(1.0) * (high - low);
        let count = (INTERVALS * typical).ceil().clamp(1.0, MOST_INTERVALS) as usize;
        let step = (high - low) / count as f64;
        let interval = |value: f64| (((value - low) / step) as usize).min(count - 1);
        let mut of_interval: Vec<Vec<Pace>> = vec![Vec::new(); count];
        for pace in paces {
            let (from, to) = (interval(pace.low), interval(pace.high));
            let length = pace.length / (to - from + 1) as f64;
            for list in &mut of_interval[from..=to] {
                list.push(Pace { length, ..pace });
            }
        }
        let mut sums = vec![0.0];
        for list in &mut of_interval {
            sums.push(sums[sums.len() - 1] + cheapest_pace(list) * step);
        }
        let total = sums[count];
        if total.is_nan() || total > MOST_PASSES {
            return Err(LevelSetError::Uneven { passes: total });
        }
        let stretched = |value: &f64| {
            let i = interval(*value);
            sums[i] + ((value - low) / step - i as f64) * (sums[i + 1] - sums[i])
        };
        Ok(Self { values: raw.iter().map(stretched).collect(), inside: f64::NEG_INFINITY })
    }

    /// The same field rescaled: `origin` becomes 0, `origin + unit` becomes 1.
    pub fn rescaled(mut self, origin: f64, unit: f64) -> Self {
        self.values.iter_mut().for_each(|v| *v = (*v - origin) / unit);
        self.inside = (self.inside - origin) / unit;
        self
    }

    /// `#V` values; infinite where no front arrived.
    pub fn values(&self) -> &[f64] {
        &self.values
    }

    /// The surface below this value is not machined.
    pub fn inside(&self) -> f64 {
        self.inside
    }

    /// Least and greatest finite value.
    pub fn range(&self) -> (f64, f64) {
        let finite = self.values.iter().copied().filter(|v| v.is_finite());
        finite.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)))
    }

    /// Length of the ridges at which fronts meet at such a sharp angle that gaps remain, mm.
    pub fn ridges(&self, mesh: &PassMesh) -> f64 {
        let connectivity = mesh.connectivity();
        let gradients: Vec<_> = (connectivity.faces().iter())
            .map(|face| {
                let corners = face.map(|v| mesh.uv()[v.index()]);
                gradient(corners, face.map(|v| self.values[v.index()]))
            })
            .collect();
        let length = |side: HalfEdgeId| {
            let other = connectivity.opposite(side).filter(|o| side < *o)?;
            let (here, there) = (gradients[side.face().index()]?, gradients[other.face().index()]?);
            let turn = mesh.flat_metric(side.face())?.slope(here - there);
            (turn > SHARP).then(|| mesh.length(side))
        };
        (0..3 * connectivity.face_count() as u32).filter_map(|h| length(HalfEdgeId(h))).sum()
    }

    /// Share of the area on which neighbouring level curves are at least 0.9 side steps apart.
    pub fn even_share(&self, mesh: &PassMesh) -> f64 {
        let (mut even, mut all) = (0.0, 0.0);
        for (f, face) in mesh.connectivity().faces().iter().enumerate() {
            let values = face.map(|v| self.values[v.index()]);
            let [a, b, c] = face.map(|v| mesh.positions()[v.index()]);
            let area = (b - a).cross(c - a).length();
            let metric = mesh.flat_metric(FaceId(f as u32));
            let gradient = gradient(face.map(|v| mesh.uv()[v.index()]), values);
            let (Some(metric), Some(gradient)) = (metric, gradient) else { continue };
            all += area;
            if metric.slope(gradient) <= 1.0 / EVEN {
                even += area;
            }
        }
        even / all
    }

    /// Length on the surface of all level curves one unit apart, mean over their offset, mm: the integral of the
    /// gradient's length (coarea formula), plus the extra length of [`flats`](Self::flats).
    pub fn length(&self, mesh: &PassMesh) -> f64 {
        self.growths(mesh).map(|(length, missing)| length * (1.0 + OUT_AND_BACK * missing)).sum()
    }

    /// Extra length on the surface, out and back, mm, where the field grows by less than one pass per pass.
    pub fn flats(&self, mesh: &PassMesh) -> f64 {
        self.growths(mesh).map(|(length, missing)| length * OUT_AND_BACK * missing).sum()
    }

    /// For every face the integral of the gradient's length, mm, and the fraction of a pass that is missing.
    fn growths<'a>(&'a self, mesh: &'a PassMesh) -> impl Iterator<Item = (f64, f64)> + 'a {
        let of_face = move |(f, face): (usize, &[VertexId; 3])| {
            let value = face.map(|v| self.values[v.index()]);
            let [a, b, c] = face.map(|v| mesh.positions()[v.index()]);
            let twice_area = (b - a).cross(c - a).length();
            // |grad| A = |sum of value times opposite side| / 2.
            let sum = (c - b) * value[0] + (a - c) * value[1] + (b - a) * value[2];
            let metric = mesh.flat_metric(FaceId(f as u32))?;
            let slope = gradient(face.map(|v| mesh.uv()[v.index()]), value)
                .map_or(1.0, |gradient| metric.slope(gradient));
            if value.iter().any(|v| !v.is_finite()) || twice_area <= 0.0 {
                return None;
            }
            let missing = if slope < FLAT { (1.0 / slope - 1.0).min(1.0) } else { 0.0 };
            Some((0.5 * sum.length(), missing))
        };
        mesh.connectivity().faces().iter().enumerate().filter_map(of_face)
    }

    /// Length of the level curves at the whole values from 0 to `last` on the surface, mm.
    pub fn length_of_levels(&self, mesh: &PassMesh, last: f64) -> f64 {
        let of_face = |face: &[VertexId; 3]| {
            let mut corners = face.map(|v| (self.values[v.index()], mesh.positions()[v.index()]));
            corners.order_by(|a, b| a.0.total_cmp(&b.0));
            let [(low, a), (middle, b), (high, c)] = corners;
            // A corner that nothing reaches has no level.
            if !(high.is_finite() && low < high) {
                return 0.0;
            }
            // The longest goes through the middle corner; the others are shorter in proportion.
            let longest = b.distance(a.lerp(c, (middle - low) / (high - low)));
            let part = |level: f64| match level < middle {
                true => (level - low) / (middle - low),
                false if high > middle => (high - level) / (high - middle),
                false => 1.0,
            };
            let (first, end) = (low.ceil().max(0.0), high.floor().min(last));
            let count = if end >= first { (end - first) as u32 + 1 } else { 0 };
            longest * (0..count).map(|k| part(first + f64::from(k))).sum::<f64>()
        };
        mesh.connectivity().faces().iter().map(of_face).sum()
    }

    /// Length of the boundary on which passes end, measured along the passes, mm: where it is at a slant to the
    /// passes, it is machined by branches and overruns. `last`: level of the last pass.
    pub fn slants(&self, mesh: &PassMesh, last: f64) -> f64 {
        let of_side = |side: HalfEdgeId| {
            let (a, b) = mesh.connectivity().ends(side);
            let [from, to] = [a, b].map(|v| self.values[v.index()]);
            let middle = 0.5 * (from + to);
            // Outside of the first and the last pass there is no other that could end.
            if mesh.connectivity().opposite(side).is_some() || !(middle > 0.0 && middle < last) {
                return 0.0;
            }
            let across = ((to - from).abs() / mesh.pass_length(side)).min(1.0);
            mesh.length(side) * (1.0 - across * across).sqrt()
        };
        (0..3 * mesh.connectivity().face_count() as u32).map(|h| of_side(HalfEdgeId(h))).sum()
    }
}

/// Growth per pass of a function on the vertices, mean over the faces around each; where it hardly grows, the growth
/// of a distance in mm.
fn slopes(mesh: &PassMesh, values: &[f64]) -> Vec<f64> {
    let connectivity = mesh.connectivity();
    let mut sums = vec![(0.0, 0u32); values.len()];
    for (f, face) in connectivity.faces().iter().enumerate() {
        let gradient =
            gradient(face.map(|v| mesh.uv()[v.index()]), face.map(|v| values[v.index()]));
        let slope = mesh.flat_metric(FaceId(f as u32)).zip(gradient).map(|(m, g)| m.slope(g));
        for v in face {
            let (sum, count) = sums[v.index()];
            sums[v.index()] = (sum + slope.unwrap_or(0.0), count + 1);
        }
    }
    let mut rates = vec![(0.0, 0.0); values.len()];
    for h in (0..3 * connectivity.face_count() as u32).map(HalfEdgeId) {
        let (a, b) = connectivity.ends(h);
        for v in [a, b] {
            rates[v.index()].0 += mesh.length(h);
            rates[v.index()].1 += mesh.pass_length(h);
        }
    }
    let slope = |((sum, count), (mm, passes)): ((f64, u32), (f64, f64))| {
        (sum / f64::from(count.max(1))).max(HARDLY * mm / passes)
    };
    sums.into_iter().zip(rates).map(slope).collect()
}

fn boundary_sources(mesh: &PassMesh) -> Vec<(VertexId, f64)> {
    mesh.connectivity().boundary_loops().iter().flatten().map(|&v| (v, 0.0)).collect()
}

/// Signed distances in passes of the vertices of all faces that a flat curve crosses or touches.
fn beside_curve(mesh: &PassMesh, locator: &Locator, curve: &[DVec2]) -> Vec<(VertexId, f64)> {
    let connectivity = mesh.connectivity();
    let mut near: Vec<(VertexId, f64)> = Vec::new();
    for (a, b) in curve.windows(2).map(|w| (w[0], w[1])) {
        // From the middle: the ends may lie on corners of the boundary, from where no walk begins.
        let middle = a.midpoint(b);
        let Ok(start) = locator.locate(middle) else { continue };
        let mut faces = vec![start.face];
        for end in [a, b] {
            let _ = locator.walk(start.face, middle, end, |side, _| {
                faces.push(side.face());
                faces.extend(connectivity.opposite(side).map(HalfEdgeId::face));
            });
        }
        let distance = |face: FaceId, v: VertexId| {
            let p = mesh.uv()[v.index()];
            let sign = if (b - a).perp_dot(p - a) < 0.0 { -1.0 } else { 1.0 };
            Some((v, sign * mesh.flat_metric(face)?.nearest_on(p, a, b).0))
        };
        let touched = |faces: &[FaceId]| -> Vec<(VertexId, f64)> {
            let corners = faces.iter().flat_map(|&f| connectivity.face(f).map(|v| (f, v)));
            corners.filter_map(|(f, v)| distance(f, v)).collect()
        };
        // A vertex on the curve: all faces around it are touched, else fronts would pass through it.
        let on_curve = touched(&faces).into_iter().filter(|(_, d)| d.abs() < ON_CURVE);
        let around: Vec<FaceId> = on_curve
            .flat_map(|(v, _)| mesh.sides_around(v).map(HalfEdgeId::face).collect::<Vec<_>>())
            .collect();
        near.extend(touched(&faces));
        near.extend(touched(&around));
    }
    near.order_by(|a, b| a.0.cmp(&b.0).then(a.1.abs().total_cmp(&b.1.abs())));
    near.dedup_by_key(|n| n.0);
    near
}

/// The pace of a function that a face requires.
#[derive(Copy, Clone)]
struct Pace {
    /// Range of the function on the face.
    low: f64,
    high: f64,
    /// Passes per unit of the function.
    passes: f64,
    /// Length of the level curves on the face, integrated over its range.
    length: f64,
}

/// The pace that makes passes and the branches beside them shortest: stretches that need more passes are machined
/// once more, out and back; those that need more than twice as many, as often as passes are missing.
fn cheapest_pace(list: &mut [Pace]) -> f64 {
    list.order_by(|a, b| b.passes.total_cmp(&a.passes));
    let whole: f64 = list.iter().map(|p| p.length).sum();
    let mut best = (f64::INFINITY, 0.0);
    // Of the stretches that ask for more than the pace, and than twice the pace: their length, and the passes
    // that these ask for along theirs.
    let (mut faster, mut next) = (0.0, 0);
    let (mut twice, mut asked, mut next_twice) = (0.0, 0.0, 0);
    for p in list.iter() {
        while list[next].passes > (1.0 + SLACK) * p.passes {
            faster += list[next].length;
            next += 1;
        }
        while list[next_twice].passes > 2.0 * p.passes {
            twice += list[next_twice].length;
            asked += list[next_twice].passes * list[next_twice].length;
            next_twice += 1;
        }
        let missing = p.passes * (faster - twice) + asked - p.passes * twice;
        let cost = p.passes * whole + OUT_AND_BACK * missing;
        if cost < best.0 {
            best = (cost, p.passes);
        }
    }
    best.1
}

/// The paces of all faces, by the mean slope of the faces around their corners.
fn paces(mesh: &PassMesh, raw: &[f64]) -> Vec<Pace> {
    let faces = mesh.connectivity().faces();
    let mut sums = vec![(0.0, 0.0); raw.len()];
    let mut lengths = vec![0.0; faces.len()];
    for (f, face) in faces.iter().enumerate() {
        let Some(metric) = mesh.flat_metric(FaceId(f as u32)) else { continue };
        let corners = face.map(|v| mesh.uv()[v.index()]);
        let Some(gradient) = gradient(corners, face.map(|v| raw[v.index()])) else { continue };
        let area = 0.5 * (corners[1] - corners[0]).perp_dot(corners[2] - corners[0]).abs();
        let scale = face.map(|v| mesh.scale()[v.index()]).into_iter().sum::<f64>() / 3.0;
        lengths[f] = gradient.length() * area * scale;
        for v in face {
            sums[v.index()].0 += area * metric.slope(gradient);
            sums[v.index()].1 += area;
        }
    }
    let slope = |v: VertexId| sums[v.index()].0 / sums[v.index()].1;
    let pace = |(f, face): (usize, &[VertexId; 3])| {
        let values = face.map(|v| raw[v.index()]);
        Pace {
            low: values.into_iter().fold(f64::INFINITY, f64::min),
            high: values.into_iter().fold(f64::NEG_INFINITY, f64::max),
            passes: 1.0 / face.map(slope).into_iter().fold(f64::INFINITY, f64::min),
            length: lengths[f],
        }
    };
    let all = faces.iter().enumerate().map(pace);
    all.filter(|p| p.passes.is_finite() && p.length > 0.0).collect()
}

/// Gradient of the linear function with these values at the corners; `None` without area.
pub(super) fn gradient([a, b, c]: [DVec2; 3], [u, v, w]: [f64; 3]) -> Option<DVec2> {
    let twice_area = (b - a).perp_dot(c - a);
    let gradient = ((b - a).perp() * (w - u) - (c - a).perp() * (v - u)) / twice_area;
    gradient.is_finite().then_some(gradient)
}

/// Shortest length that passes on the surface can have, mm: the integral of `1 / w_max`.
///
/// # Source
/// Kim 2001.
pub fn length_floor(mesh: &PassMesh) -> f64 {
    let metric = |face| mesh.flat_metric(face);
    floor_of_faces(mesh.connectivity(), mesh.positions(), mesh.uv(), metric)
}

/// As [`length_floor`], of a surface whose faces are not refined; `metric` is the strip metric at each of the
/// `#V` vertices.
pub fn length_floor_of(surface: &Surface, chart: &Chart, metric: &[StripMetric]) -> f64 {
    let (connectivity, positions, uv) = (surface.connectivity(), surface.positions(), chart.uv());
    let of_face = |face: FaceId| {
        let v = connectivity.face(face).map(VertexId::index);
        let [a, b, c] = v.map(|v| &metric[v]);
        let mean = core::array::from_fn(|i| (a[i] + b[i] + c[i]) / 3.0);
        FlatMetric::of_triangle(&mean, v.map(|v| positions[v]), v.map(|v| uv[v]))
    };
    floor_of_faces(connectivity, positions, uv, of_face)
}

fn floor_of_faces(
    connectivity: &Connectivity,
    positions: &[DVec3],
    uv: &[DVec2],
    metric: impl Fn(FaceId) -> Option<FlatMetric>,
) -> f64 {
    let of_face = |f: usize| {
        let face = FaceId(f as u32);
        let [a, b, c] = connectivity.face(face).map(|v| positions[v.index()]);
        let [p, q, r] = connectivity.face(face).map(|v| uv[v.index()]);
        let flat = (q - p).perp_dot(r - p).abs();
        let area = (b - a).cross(c - a).length();
        // Conformal: flat lengths count by the root of the area's scale.
        let per_mm = |m: FlatMetric| m.least() * (flat / area).sqrt();
        if area > 0.0 { 0.5 * area * metric(face).map_or(0.0, per_mm) } else { 0.0 }
    };
    (0..connectivity.face_count()).map(of_face).sum()
}

#[cfg(test)]
mod tests;
