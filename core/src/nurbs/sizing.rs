//! How long the edges of a mesh may be, place by place.
//!
//! First fundamental form and curvature are sampled on a grid of parameters that has every knot
//! span. The edge length follows from the curvature and the chord error, across the direction of
//! least curvature (`narrow`) and along it (`wide`); both then grow from place to place by no more
//! than a given rate, so that neighbouring triangles are of like size.

use super::metric::{GROWTH, Metric};
use super::surface::NurbsSurface;
use crate::geometry::shape::ShapeOperator;
use crate::geometry::{DVec2, DVec3};

/// Lines of the grid along one parameter, at least and at most.
const LINES: (usize, usize) = (33, 800);
/// Part of the edge length that the chord error would allow; flips and moves need some of the rest.
const CAUTION: f64 = 0.95;
/// Longest edge as a part of the radius of curvature (0.35 turns by 20 degrees).
const TURN: f64 = 0.35;
/// Most that an edge along the direction of least curvature may be longer than one across. Larger
/// saves little more (blades: 2.5 halves the triangles, 6 leaves a quarter) and makes angles
/// below 15 degrees common, which the flat image suffers from.
const LONGER: f64 = 2.5;
/// Steps in which an edge length and the mean bend over it are brought together.
const WINDOWS: usize = 30;
/// Sweeps over the grid; each carries sizes along all rows and columns both ways.
const SWEEPS: usize = 3;
/// Nodes and weights of Gauss's three-point rule on [0, 1].
const GAUSS: [(f64, f64); 3] = [
    (0.112_701_665_379_258_3, 5.0 / 18.0),
    (0.5, 8.0 / 18.0),
    (0.887_298_334_620_741_7, 5.0 / 18.0),
];

/// Lengths that a mesh must keep.
#[derive(Copy, Clone, Debug, PartialEq)]
pub(super) struct Limits {
    /// Largest distance between surface and mesh, mm.
    pub chord: f64,
    /// Longest edge, in square roots of the area of the domain.
    pub longest: f64,
}

/// Edge lengths and metric over a rectangle of parameters.
pub(super) struct Sizing {
    lines: [Vec<f64>; 2],
    /// First fundamental form `E, F, G` by u, then v.
    form: Vec<[f64; 3]>,
    /// Edge length across the direction of least curvature by u, then v, mm.
    size: Vec<f64>,
    /// Edge length along it, mm.
    wide: Vec<f64>,
    /// The direction of least curvature.
    along: Vec<DVec3>,
    /// Shifts that lead from one end to the other, for closed directions.
    period: [Option<f64>; 2],
    low: DVec2,
    /// Greatest `E, |F|, G`.
    fastest: [f64; 3],
    buckets: [Buckets; 2],
}

impl Sizing {
    /// Samples `surface` over the rectangle from `low` to `high`.
    pub fn new(surface: &NurbsSurface, (low, high): (DVec2, DVec2), limits: Limits) -> Self {
        let lines = [0, 1].map(|axis| grid_lines(surface, axis, low[axis], high[axis]));
        let (from, to) = surface.domain();
        let period = [0, 1].map(|a| (surface.closed()[a]).then(|| to[a] - from[a]));
        let (form, along) = (Vec::new(), Vec::new());
        let buckets = [0, 1].map(|axis: usize| Buckets::of(&lines[axis]));
        let fastest = [0.0; 3];
        let (size, wide) = (Vec::new(), Vec::new());
        let mut this = Self { lines, form, size, wide, along, period, low, fastest, buckets };
        let mut bends = Vec::new();
        for &u in &this.lines[0] {
            for &v in &this.lines[1] {
                let at = DVec2::new(u, v);
                let [su, sv] = surface.jet(at).first;
                this.form.push([su.length_squared(), su.dot(sv), sv.length_squared()]);
                let (bend, along) = surface.shape(at).map_or(Bend::NONE, bend);
                bends.push(bend);
                this.along.push(along);
            }
        }
        for form in &this.form {
            this.fastest = [0, 1, 2].map(|k| this.fastest[k].max(form[k].abs()));
        }
        this.size = vec![0.0; bends.len()];
        let longest = limits.longest * this.area().sqrt();
        let most: Vec<f64> = bends.iter().map(|b| b.most).collect();
        this.allow(&most, limits.chord, longest);
        let wide = |(size, bend): (&f64, &Bend)| (size * bend.longer).min(longest);
        this.wide = this.size.iter().zip(&bends).map(wide).collect();
        this.grade();
        for (wide, size) in this.wide.iter_mut().zip(&this.size) {
            *wide = wide.clamp(*size, LONGER * size);
        }
        this
    }

    /// Area of the rectangle, mm².
    pub fn area(&self) -> f64 {
        self.cells().map(|(_, area)| area).sum()
    }

    /// Triangles that the rectangle takes, roughly.
    pub fn triangles(&self) -> f64 {
        self.cells().map(|(node, area)| self.in_cell(node, area)).sum()
    }

    /// Triangles that a cell takes.
    fn in_cell(&self, node: usize, area: f64) -> f64 {
        // Edges turn out a fifth shorter than allowed.
        area / (0.27 * self.size[node] * self.wide[node])
    }

    /// The parameters where most triangles per cell are needed.
    pub fn finest(&self) -> DVec2 {
        let counts = self.cells().map(|(node, area)| (node, self.in_cell(node, area)));
        let (node, _) = counts.fold((0, 0.0), |a, b| if b.1 > a.1 { b } else { a });
        let columns = self.lines[1].len();
        DVec2::new(self.lines[0][node / columns], self.lines[1][node % columns])
    }

    /// First node and area of every cell.
    fn cells(&self) -> impl Iterator<Item = (usize, f64)> {
        let [us, vs] = &self.lines;
        (0..us.len() - 1).flat_map(move |i| {
            (0..vs.len() - 1).map(move |j| {
                let node = i * vs.len() + j;
                let corners = [node, node + 1, node + vs.len(), node + vs.len() + 1];
                let density = |&n: &usize| {
                    let [e, f, g] = self.form[n];
                    (e * g - f * f).max(0.0).sqrt()
                };
                let mean = 0.25 * corners.iter().map(density).sum::<f64>();
                (node, mean * (us[i + 1] - us[i]) * (vs[j + 1] - vs[j]))
            })
        })
    }

    /// Lowers sizes so that they grow by `GROWTH` per length at most.
    fn grade(&mut self) {
        let (n, m) = (self.lines[0].len(), self.lines[1].len());
        for _ in 0..SWEEPS {
            for i in 0..n {
                let nodes: Vec<usize> = (0..m).map(|j| i * m + j).collect();
                self.grade_row(&nodes, 1);
            }
            for j in 0..m {
                let nodes: Vec<usize> = (0..n).map(|i| i * m + j).collect();
                self.grade_row(&nodes, 0);
            }
        }
    }

    /// Edge lengths from the mean bend over as long a way along either parameter, the more generous
    /// one: a bend that is over within an edge moves the surface off it by less than one that goes on.
    fn allow(&mut self, bends: &[f64], chord: f64, longest: f64) {
        let (n, m) = (self.lines[0].len(), self.lines[1].len());
        for i in 0..n {
            self.allow_row(
                &(0..m).map(|j| i * m + j).collect::<Vec<_>>(),
                1,
                bends,
                (chord, longest),
            );
        }
        for j in 0..m {
            self.allow_row(
                &(0..n).map(|i| i * m + j).collect::<Vec<_>>(),
                0,
                bends,
                (chord, longest),
            );
        }
    }

    fn allow_row(
        &mut self,
        nodes: &[usize],
        axis: usize,
        bends: &[f64],
        (chord, longest): (f64, f64),
    ) {
        let steps = self.steps(nodes, axis);
        // Running length and running bend.
        let mut sums = vec![(0.0, 0.0)];
        for (k, step) in steps.iter().enumerate() {
            let (way, turn) = sums[k];
            sums.push((way + step, turn + 0.5 * step * (bends[nodes[k]] + bends[nodes[k + 1]])));
        }
        let at = |way: f64| {
            let k = sums.partition_point(|s| s.0 <= way).clamp(1, sums.len() - 1);
            let (a, b) = (sums[k - 1], sums[k]);
            let part = if b.0 > a.0 { ((way - a.0) / (b.0 - a.0)).clamp(0.0, 1.0) } else { 0.0 };
            a.1 + (b.1 - a.1) * part
        };
        let end = sums[sums.len() - 1].0;
        for (k, &node) in nodes.iter().enumerate() {
            let mut size = longest;
            for _ in 0..WINDOWS {
                let (low, high) =
                    ((sums[k].0 - 0.5 * size).max(0.0), (sums[k].0 + 0.5 * size).min(end));
                let mean =
                    if high > low { (at(high) - at(low)) / (high - low) } else { bends[node] };
                let next = edge_for(mean, chord);
                if next >= size {
                    break;
                }
                size = (0.5 * (size + next)).min(4.0 * next);
            }
            self.size[node] = self.size[node].max(size);
        }
    }

    /// Lengths between neighbouring nodes along an axis, mm.
    fn steps(&self, nodes: &[usize], axis: usize) -> Vec<f64> {
        let form = |n: usize| self.form[n][2 * axis].max(0.0).sqrt();
        let lines = &self.lines[axis];
        (1..nodes.len())
            .map(|k| 0.5 * (form(nodes[k - 1]) + form(nodes[k])) * (lines[k] - lines[k - 1]))
            .collect()
    }

    fn grade_row(&mut self, nodes: &[usize], axis: usize) {
        let steps: Vec<f64> = self.steps(nodes, axis).iter().map(|s| GROWTH * s).collect();
        let closed = self.period[axis].is_some();
        grade(&mut self.size, nodes, &steps, closed);
        grade(&mut self.wide, nodes, &steps, closed);
    }

    /// Cell of a parameter along an axis and the place in it.
    fn cell(&self, axis: usize, t: f64) -> (usize, f64) {
        let lines = &self.lines[axis];
        let t = match self.period[axis] {
            Some(period) => t - ((t - self.low[axis]) / period).floor() * period,
            None => t,
        };
        let i = self.buckets[axis].cell(lines, t);
        (i, ((t - lines[i]) / (lines[i + 1] - lines[i])).clamp(0.0, 1.0))
    }

    /// Longest edge at `at` in its narrow direction, mm: the least of the cell's corners.
    pub fn size(&self, at: DVec2) -> f64 {
        self.metric(at).narrow
    }

    /// Longest edges at `at`: the least of the cell's corners, with the direction of the nearest.
    pub fn metric(&self, at: DVec2) -> Metric {
        let ((i, x), (j, y)) = (self.cell(0, at.x), self.cell(1, at.y));
        let m = self.lines[1].len();
        let n = i * m + j;
        let least = |s: &[f64]| s[n].min(s[n + 1]).min(s[n + m]).min(s[n + m + 1]);
        let nearest = n + if x > 0.5 { m } else { 0 } + usize::from(y > 0.5);
        let (narrow, wide) = (least(&self.size), least(&self.wide));
        Metric::new(narrow, wide, self.along[nearest])
    }

    fn form(&self, at: DVec2) -> [f64; 3] {
        let ((i, x), (j, y)) = (self.cell(0, at.x), self.cell(1, at.y));
        let m = self.lines[1].len();
        let n = i * m + j;
        let mix = |k: usize| {
            let f = &self.form;
            (f[n][k] * (1.0 - y) + f[n + 1][k] * y) * (1.0 - x)
                + (f[n + m][k] * (1.0 - y) + f[n + m + 1][k] * y) * x
        };
        [mix(0), mix(1), mix(2)]
    }

    /// Length on the surface of the straight line between parameters, mm.
    pub fn length(&self, a: DVec2, b: DVec2) -> f64 {
        let d = b - a;
        let speed = |t: f64| {
            let [e, f, g] = self.form(a + d * t);
            (e * d.x * d.x + 2.0 * f * d.x * d.y + g * d.y * d.y).max(0.0).sqrt()
        };
        GAUSS.iter().map(|&(t, weight)| weight * speed(t)).sum()
    }

    /// What [`length`](Self::length) is at most, without a look at where the line is, mm.
    pub fn longest(&self, a: DVec2, b: DVec2) -> f64 {
        let d = b - a;
        let [e, f, g] = self.fastest;
        (e * d.x * d.x + 2.0 * f * (d.x * d.y).abs() + g * d.y * d.y).sqrt()
    }

    /// Mean lengths of the tangents.
    pub fn mean_speed(&self) -> DVec2 {
        let mean = |k: usize| {
            self.form.iter().map(|f| f[k].max(0.0).sqrt()).sum::<f64>() / self.form.len() as f64
        };
        DVec2::new(mean(0), mean(2)).max(DVec2::splat(f64::MIN_POSITIVE))
    }
}

/// Where to look for a parameter among ascending lines.
struct Buckets {
    low: f64,
    per_length: f64,
    /// For every bucket the last line that is not above its start.
    first: Vec<u32>,
}

impl Buckets {
    fn of(lines: &[f64]) -> Self {
        let (low, high) = (lines[0], lines[lines.len() - 1]);
        let count = 2 * lines.len();
        let per_length = count as f64 / (high - low);
        let start = |k: usize| low + k as f64 / per_length;
        let before = |k: usize| lines.partition_point(|&l| l <= start(k)).saturating_sub(1) as u32;
        Self { low, per_length, first: (0..count).map(before).collect() }
    }

    /// The last line but one, or the last before that is not above `t`; the first if all are.
    fn cell(&self, lines: &[f64], t: f64) -> usize {
        let bucket = ((t - self.low) * self.per_length) as usize;
        let mut i = self.first[bucket.min(self.first.len() - 1)] as usize;
        // The bucket's start is rounded.
        while i > 0 && lines[i] > t {
            i -= 1;
        }
        while i + 2 < lines.len() && lines[i + 1] <= t {
            i += 1;
        }
        i.min(lines.len() - 2)
    }
}

/// How a surface bends at a place.
struct Bend {
    /// What the principal curvatures add to the chord error of a triangle, as the curvature of a
    /// cylinder.
    most: f64,
    /// How much longer its edge along the direction of least curvature may be.
    longer: f64,
}

impl Bend {
    /// Of a place without a normal.
    const NONE: (Self, DVec3) = (Self { most: 0.0, longer: 1.0 }, DVec3::ZERO);
}

/// The bend and the direction in which it is least.
///
/// The error of an equilateral triangle of edge 1 is `h² / 8R` on a cylinder and `h² / 6R` on a
/// sphere; a surface whose curvatures differ is a sphere to triangles that are longer by the root of
/// their ratio.
fn bend(shape: ShapeOperator) -> (Bend, DVec3) {
    let (low, high, direction) = shape.principal();
    let along = if high.abs() > low.abs() { shape.normal().cross(direction) } else { direction };
    let (most, least) = (low.abs().max(high.abs()), low.abs().min(high.abs()));
    let longer =
        if most > LONGER * LONGER * least { LONGER } else { (most / least).max(1.0).sqrt() };
    let bend = most + longer * longer * least / 3.0;
    if bend.is_finite() && longer.is_finite() && along.is_finite() {
        (Bend { most: bend, longer }, along)
    } else {
        Bend::NONE
    }
}

/// Edge that stays within `chord` of a surface that bends so. Radii of less than two chord errors
/// count as that: what they do to the surface is within it, or is found when it is measured.
fn edge_for(bend: f64, chord: f64) -> f64 {
    if bend > 0.0 {
        (CAUTION * (8.0 * chord / bend).sqrt()).min(TURN / bend).max(4.0 * chord)
    } else {
        f64::INFINITY
    }
}

/// Lowers the sizes of a row so that none is larger than its neighbour by more than a step.
fn grade(sizes: &mut [f64], nodes: &[usize], steps: &[f64], closed: bool) {
    // Closed rows are gone through twice, so that sizes pass the seam.
    for _ in 0..if closed { 2 } else { 1 } {
        for (pair, step) in nodes.windows(2).zip(steps) {
            sizes[pair[1]] = sizes[pair[1]].min(sizes[pair[0]] + step);
        }
        for (pair, step) in nodes.windows(2).zip(steps).rev() {
            sizes[pair[0]] = sizes[pair[0]].min(sizes[pair[1]] + step);
        }
        if closed {
            let (first, last) = (nodes[0], nodes[nodes.len() - 1]);
            let least = sizes[first].min(sizes[last]);
            (sizes[first], sizes[last]) = (least, least);
        }
    }
}

fn grid_lines(surface: &NurbsSurface, axis: usize, low: f64, high: f64) -> Vec<f64> {
    let inner = surface.breaks(axis).into_iter().map(|(k, _)| k).filter(|&k| k > low && k < high);
    let breaks: Vec<f64> = std::iter::once(low).chain(inner).chain([high]).collect();
    let spans = breaks.len() - 1;
    let stride = spans.div_ceil(LINES.1);
    let parts = (LINES.0 - 1).div_ceil(spans).max(if 2 * spans <= LINES.1 { 2 } else { 1 });
    let mut lines: Vec<f64> = Vec::new();
    for (i, pair) in breaks.windows(2).enumerate().filter(|(i, _)| i % stride == 0) {
        let end = breaks[(i + stride).min(spans)];
        let steps = 0..parts;
        lines.extend(steps.map(|k| pair[0] + (end - pair[0]) * k as f64 / parts as f64));
    }
    lines.push(high);
    lines.dedup();
    lines
}
