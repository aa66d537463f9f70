//! The piece of the parameter plane that is meant, and its boundary as points.
//!
//! On a surface that is closed in one direction, a loop may run around; then the domain is a ring,
//! which is laid in the plane as an annulus: one parameter becomes the angle and the other the
//! radius, so that no seam remains. A side of the surface that is one point (a pole) closes the
//! ring's hole.

use super::error::NurbsError;
use super::sizing::Sizing;
use super::surface::NurbsSurface;
use crate::geometry::math::{cos, sin};
use crate::geometry::polyline::distance_to_segment;
use crate::geometry::{DVec2, DVec3};

/// Steps in which a piece of boundary is measured, at least.
const MEASURED: usize = 128;
/// Part of a period that one step of a boundary spans at most.
const WIDEST_STEP: f64 = 1.0 / 16.0;
/// Distance from a pole, as a part of the domain, that counts as on it.
const AT_POLE: f64 = 1e-9;

/// A closed line in the parameter plane.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TrimLoop {
    /// Its points, the first not repeated; where the surface is closed they go on without a jump.
    pub points: Vec<DVec2>,
    /// Points that must become vertices, in increasing order.
    pub corners: Vec<usize>,
    /// How often it runs around the surface along u and along v.
    pub winding: [i32; 2],
}

impl TrimLoop {
    /// Twice the signed area.
    fn area(&self) -> f64 {
        let n = self.points.len();
        (0..n).map(|i| self.points[i].perp_dot(self.points[(i + 1) % n])).sum()
    }

    fn shifted(mut self, by: DVec2) -> Self {
        self.points.iter_mut().for_each(|p| *p += by);
        self
    }
}

/// A ring around a closed direction.
#[derive(Copy, Clone, Debug, PartialEq)]
pub(super) struct Ring {
    /// The parameter that runs around: 0 for u, 1 for v.
    pub axis: usize,
    /// Its period.
    period: f64,
    /// Whether the other parameter's low or high side is a pole of the domain.
    poles: [bool; 2],
    /// Radius in the plane is `base + slope * (other - from)`.
    base: f64,
    slope: f64,
    from: f64,
}

/// A piece of the parameter plane.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Domain {
    pub loops: Vec<TrimLoop>,
    /// Rectangle that holds it.
    pub low: DVec2,
    pub high: DVec2,
    pub ring: Option<Ring>,
    scale: DVec2,
}

impl Domain {
    /// A rectangle of parameters, without the sides at which a closed surface goes on; one side at least is a boundary.
    pub fn rectangle(surface: &NurbsSurface, (low, high): (DVec2, DVec2)) -> Self {
        let axis = match surface.around((low, high)) {
            [true, _] => 0,
            [false, true] => 1,
            [false, false] => {
                let points = vec![low, DVec2::new(high.x, low.y), high, DVec2::new(low.x, high.y)];
                let side = TrimLoop { points, corners: vec![0, 1, 2, 3], winding: [0, 0] };
                return Self::new(vec![side], (low, high), None);
            }
        };
        let other = 1 - axis;
        let ends = surface.poles_of((low, high), other);
        let mut loops = Vec::new();
        for (end, at) in
            [low[other], high[other]].into_iter().enumerate().filter(|(e, _)| !ends[*e])
        {
            // In parts, since a step must not span half of the way around.
            let steps = (0..32).map(|k| {
                let part = f64::from(k) / 32.0;
                let part = if end == 0 { part } else { 1.0 - part };
                let mut p = DVec2::splat(at);
                p[axis] = low[axis] + (high[axis] - low[axis]) * part;
                p
            });
            let mut winding = [0, 0];
            winding[axis] = if end == 0 { 1 } else { -1 };
            loops.push(TrimLoop { points: steps.collect(), corners: vec![0], winding });
        }
        Self::new(loops, (low, high), Some(Ring::new(axis, (low, high), ends)))
    }

    /// The piece at the left of `loops`, which run around it counter-clockwise in the parameter
    /// plane (holes clockwise).
    pub fn trimmed(surface: &NurbsSurface, loops: Vec<TrimLoop>) -> Result<Self, NurbsError> {
        let bad = |why| NurbsError::BadLoops { why };
        let winds = |axis: usize| loops.iter().any(|l| l.winding[axis] != 0);
        let (from, to) = surface.domain();
        let period = to - from;
        match [winds(0), winds(1)] {
            [true, true] => Err(bad("they run around both parameters")),
            [false, false] => {
                let outer = loops.iter().map(TrimLoop::area).enumerate();
                let outer =
                    outer.max_by(|a, b| a.1.abs().total_cmp(&b.1.abs())).map_or(0, |(i, _)| i);
                if loops[outer].area() < 0.0
                    && let Some(domain) = Self::around_holes(surface, &loops)
                {
                    return Ok(domain);
                }
                let outline = loops[outer].points.clone();
                let shifted = |(i, l): (usize, TrimLoop)| {
                    if i == outer { l } else { into(&outline, l, surface.closed(), period) }
                };
                let loops: Vec<TrimLoop> = loops.into_iter().enumerate().map(shifted).collect();
                let bounds = bounds(&loops[outer..=outer]);
                Ok(Self::new(loops, bounds, None))
            }
            [around_u, _] => Self::winding(surface, loops, usize::from(!around_u)),
        }
    }

    /// The whole of a surface with two poles but for holes, which run clockwise. On other surfaces
    /// loops that run the other way can only be meant to bound what is inside.
    fn around_holes(surface: &NurbsSurface, loops: &[TrimLoop]) -> Option<Self> {
        let axis = surface.closed().iter().position(|c| *c)?;
        let bounds = surface.domain();
        let other = 1 - axis;
        let poles = [0, 1].map(|end| surface.degenerate()[2 * other + end]);
        let ring = Some(Ring::new(axis, bounds, poles));
        (poles == [true, true]).then(|| Self::new(loops.to_vec(), bounds, ring))
    }

    fn winding(
        surface: &NurbsSurface,
        mut loops: Vec<TrimLoop>,
        axis: usize,
    ) -> Result<Self, NurbsError> {
        let bad = |why| NurbsError::BadLoops { why };
        let other = 1 - axis;
        let (from, to) = surface.domain();
        if loops.iter().any(|l| l.winding[axis].abs() > 1) {
            return Err(bad("one runs around several times"));
        }
        // What is at the left of a loop along u is at higher v; of one along v, at lower u.
        let upward = if axis == 0 { 1 } else { -1 };
        let which = |sign: i32| loops.iter().position(|l| l.winding[axis] == sign * upward);
        let count = loops.iter().filter(|l| l.winding[axis] != 0).count();
        let mean =
            |l: &TrimLoop| l.points.iter().map(|p| p[other]).sum::<f64>() / l.points.len() as f64;
        let (low_loop, high_loop) = (which(1), which(-1));
        let mut poles = [false; 2];
        match (low_loop, high_loop, count) {
            (Some(a), Some(b), 2) => {
                // A closed other direction goes on from one end to the other.
                let period = to[other] - from[other];
                if surface.closed()[other] && mean(&loops[b]) <= mean(&loops[a]) {
                    let mut by = DVec2::ZERO;
                    by[other] = period;
                    loops[b] = std::mem::take(&mut loops[b]).shifted(by);
                }
            }
            (Some(_), None, 1) => poles[1] = true,
            (None, Some(_), 1) => poles[0] = true,
            _ => return Err(bad("more than two run around")),
        }
        let is_pole = |end: usize| surface.degenerate()[2 * other + end];
        if (poles[0] && !is_pole(0)) || (poles[1] && !is_pole(1)) {
            // The loop runs the other way than it should, or the piece has no end.
            poles = [poles[1] && is_pole(0), poles[0] && is_pole(1)];
            if poles == [false; 2] {
                return Err(bad("one runs around, and there is no pole at its other side"));
            }
        }
        let (mut low, mut high) = bounds(&loops);
        (low[axis], high[axis]) = (from[axis], to[axis]);
        if poles[0] {
            low[other] = from[other];
        }
        if poles[1] {
            high[other] = to[other];
        }
        Ok(Self::new(loops, (low, high), Some(Ring::new(axis, (low, high), poles))))
    }

    fn new(loops: Vec<TrimLoop>, (low, high): (DVec2, DVec2), ring: Option<Ring>) -> Self {
        Self { loops, low, high, ring, scale: DVec2::ONE }
    }

    /// Fits the plane image to the surface's mean lengths.
    pub fn fit(&mut self, sizing: &Sizing) {
        self.scale = sizing.mean_speed();
        let (scale, extent) = (self.scale, self.high - self.low);
        if let Some(ring) = &mut self.ring {
            let other = 1 - ring.axis;
            let radius = scale[ring.axis] * ring.period / std::f64::consts::TAU;
            let height = scale[other] * extent[other];
            ring.fit(radius, height);
        }
    }

    /// Image in the plane of the triangulation.
    pub fn flat(&self, at: DVec2) -> DVec2 {
        match &self.ring {
            None => (at - self.low) * self.scale,
            Some(ring) => ring.flat(at),
        }
    }

    /// Whether the image in the plane is mirrored.
    pub fn mirrored(&self) -> bool {
        self.ring.is_some_and(|ring| (ring.axis == 0) == (ring.slope > 0.0))
    }

    /// Poles that belong to the inside, with their parameters.
    pub fn poles(&self) -> Vec<DVec2> {
        let Some(ring) = self.ring else { return Vec::new() };
        let other = 1 - ring.axis;
        let ends = [self.low[other], self.high[other]];
        let at = |end: usize| {
            let mut p = self.low;
            p[other] = ends[end];
            p
        };
        (0..2).filter(|&end| ring.poles[end]).map(at).collect()
    }

    /// The side of the surface that is one point and holds `at`.
    pub fn pole_side(&self, surface: &NurbsSurface, at: DVec2) -> Option<usize> {
        let (from, to) = surface.domain();
        (0..4).filter(|&side| surface.degenerate()[side]).find(|&side| {
            let axis = side / 2;
            let end = if side % 2 == 0 { from[axis] } else { to[axis] };
            (at[axis] - end).abs() <= AT_POLE * (to[axis] - from[axis])
        })
    }
}

impl Ring {
    fn new(axis: usize, (low, high): (DVec2, DVec2), poles: [bool; 2]) -> Self {
        Self {
            axis,
            period: high[axis] - low[axis],
            poles,
            base: 1.0,
            slope: 1.0,
            from: low[1 - axis],
        }
        .with_extent(high[1 - axis] - low[1 - axis])
    }

    fn with_extent(mut self, extent: f64) -> Self {
        self.slope = 1.0 / extent;
        self
    }

    /// Radii for a mean radius and a height: a pole comes to the centre, else a hole stays there.
    fn fit(&mut self, radius: f64, height: f64) {
        let extent = 1.0 / self.slope.abs();
        let (inner, outer) = match self.poles {
            [false, false] => {
                let inner = (radius - 0.5 * height).max(0.3 * radius);
                (inner, inner + height)
            }
            _ => (0.0, height),
        };
        let rise = (outer - inner) / extent;
        // A pole only at the high side is the centre.
        (self.base, self.slope) =
            if self.poles == [false, true] { (outer, -rise) } else { (inner, rise) };
    }

    fn flat(&self, at: DVec2) -> DVec2 {
        let angle = std::f64::consts::TAU * (at[self.axis] / self.period);
        let radius = (self.base + self.slope * (at[1 - self.axis] - self.from)).max(0.0);
        DVec2::new(radius * cos(angle), radius * sin(angle))
    }

    /// `at` moved by whole turns so that it lies within half a turn of `near`.
    pub fn unwrapped(&self, at: DVec2, near: DVec2) -> DVec2 {
        let mut moved = at;
        let turns = ((at[self.axis] - near[self.axis]) / self.period).round();
        moved[self.axis] -= turns * self.period;
        moved
    }
}

fn bounds(loops: &[TrimLoop]) -> (DVec2, DVec2) {
    let points = || loops.iter().flat_map(|l| l.points.iter().copied());
    (points().fold(DVec2::INFINITY, DVec2::min), points().fold(DVec2::NEG_INFINITY, DVec2::max))
}

/// A hole moved by whole periods so that it lies inside the outer loop, where it can.
fn into(outline: &[DVec2], hole: TrimLoop, closed: [bool; 2], period: DVec2) -> TrimLoop {
    let shifts = |axis: usize| if closed[axis] { [0.0, -1.0, 1.0].as_slice() } else { &[0.0] };
    for &i in shifts(0) {
        for &j in shifts(1) {
            let by = DVec2::new(i, j) * period;
            if hole.points.first().is_some_and(|p| inside(outline, *p + by)) {
                return hole.shifted(by);
            }
        }
    }
    hole
}

/// Whether a point is inside a polygon (even-odd rule).
pub(super) fn inside(polygon: &[DVec2], p: DVec2) -> bool {
    let n = polygon.len();
    let crosses = |i: &usize| {
        let (a, b) = (polygon[*i], polygon[(*i + 1) % n]);
        (a.y > p.y) != (b.y > p.y) && p.x < a.x + (p.y - a.y) / (b.y - a.y) * (b.x - a.x)
    };
    (0..n).filter(crosses).count() % 2 == 1
}

/// Distance of a point from a closed polygon.
pub(super) fn distance(polygon: &[DVec2], p: DVec2) -> f64 {
    let n = polygon.len();
    let d = |i: usize| distance_to_segment(p, polygon[i], polygon[(i + 1) % n]);
    (0..n).map(d).fold(f64::INFINITY, f64::min)
}

/// The vertices of a loop, spaced by the sizes and within `chord` of the curve on the surface; `most` at most, since a
/// mesh has about as many triangles as its boundary has points, and more.
pub(super) fn sampled(
    surface: &NurbsSurface,
    sizing: &Sizing,
    domain: &Domain,
    line: &TrimLoop,
    (chord, most): (f64, usize),
) -> Result<Vec<DVec2>, NurbsError> {
    let n = line.points.len();
    let period = match domain.ring {
        Some(ring) => {
            let mut period = DVec2::ZERO;
            period[ring.axis] = ring.period * f64::from(line.winding[ring.axis]);
            period
        }
        None => DVec2::ZERO,
    };
    let at = |i: usize| if i < n { line.points[i] } else { line.points[i % n] + period };
    let mut corners = line.corners.clone();
    if corners.is_empty() {
        corners.push(0);
    }
    let mut result = Vec::new();
    for (k, &from) in corners.iter().enumerate() {
        let to = corners.get(k + 1).copied().unwrap_or(corners[0] + n);
        let points: Vec<DVec2> = (from..=to).map(at).collect();
        let fewest = if corners.len() == 1 { 8 } else { 1 };
        let piece = Piece { surface, sizing, points, chord, most };
        result.extend(piece.sampled(fewest, domain.ring));
        if result.len() > most {
            let at = surface.point(line.points[0]);
            return Err(NurbsError::TooFine { at, chord, count: result.len() as f64, most });
        }
    }
    Ok(result)
}

/// A piece of boundary between corners.
struct Piece<'a> {
    surface: &'a NurbsSurface,
    sizing: &'a Sizing,
    points: Vec<DVec2>,
    chord: f64,
    most: usize,
}

impl Piece<'_> {
    /// Its points without the last one.
    fn sampled(&self, fewest: usize, ring: Option<Ring>) -> Vec<DVec2> {
        let legs = self.points.len() - 1;
        let parts = MEASURED.div_ceil(legs.max(1));
        let steps: Vec<f64> = (0..=legs * parts).map(|k| k as f64 / parts as f64).collect();
        let places: Vec<DVec3> = steps.iter().map(|&s| self.surface.point(self.at(s))).collect();
        let mut needed = vec![0.0];
        let mut total = 0.0;
        for k in 1..steps.len() {
            let middle = self.at(0.5 * (steps[k - 1] + steps[k]));
            total += self.sizing.metric(middle).length(places[k] - places[k - 1]);
            needed.push(total);
        }
        let length: f64 = places.windows(2).map(|p| p[0].distance(p[1])).sum();
        let count = if length <= 1e-9 * self.surface.size() {
            1
        } else {
            (total.ceil() as usize).clamp(fewest, self.most.saturating_add(1).max(fewest))
        };
        // Even steps of the size; then halves where the curve bends more than the surface.
        let mut result = Vec::with_capacity(count);
        let mut before = 0.0;
        for k in 1..=count {
            let next = if k == count {
                legs as f64
            } else {
                invert(&steps, &needed, total * k as f64 / count as f64)
            };
            self.halved(before, next, ring, 0, &mut result);
            before = next;
        }
        result
    }

    /// The place at `s`, counted in points.
    fn at(&self, s: f64) -> DVec2 {
        let i = (s.floor() as usize).min(self.points.len().saturating_sub(2));
        let next = self.points[(i + 1).min(self.points.len() - 1)];
        self.points[i].lerp(next, s - i as f64)
    }

    /// Puts the start of the step from `a` to `b` and whatever is needed between.
    fn halved(&self, a: f64, b: f64, ring: Option<Ring>, depth: usize, result: &mut Vec<DVec2>) {
        let at = |t: f64| self.at(a + (b - a) * t);
        let wide = ring.is_some_and(|r| (at(1.0) - at(0.0))[r.axis].abs() > WIDEST_STEP * r.period);
        let [p, q] = [0.0, 1.0].map(|t| self.surface.point(at(t)));
        let off = |t: f64| {
            let x = self.surface.point(at(t));
            let way = q - p;
            let square = way.length_squared();
            let s = if square > 0.0 { ((x - p).dot(way) / square).clamp(0.0, 1.0) } else { 0.0 };
            x.distance(p + way * s)
        };
        let bent = || [0.25, 0.5, 0.75].iter().any(|&t| off(t) > 0.7 * self.chord);
        if depth < 16 && result.len() <= self.most && (wide || bent()) {
            let middle = 0.5 * (a + b);
            self.halved(a, middle, ring, depth + 1, result);
            self.halved(middle, b, ring, depth + 1, result);
        } else {
            result.push(at(0.0));
        }
    }
}

/// The step at which the running sum reaches `value`.
fn invert(steps: &[f64], sums: &[f64], value: f64) -> f64 {
    let i = sums.partition_point(|&s| s < value).clamp(1, sums.len() - 1);
    let rise = sums[i] - sums[i - 1];
    let part = if rise > 0.0 { (value - sums[i - 1]) / rise } else { 0.0 };
    steps[i - 1] + (steps[i] - steps[i - 1]) * part.clamp(0.0, 1.0)
}
