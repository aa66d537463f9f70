//! A coarse triangulation of a surface → triangles of the right size and of good shape.
//!
//! Edges that are too long are split at the middle of their parameters; edges are
//! flipped where that betters the worse of their two faces, as long as none turns over in the
//! parameters; vertices move to the middle of their triangles, on the surface, where that makes
//! the worst of them better. Lengths are measured on the surface, along straight lines of the
//! parameters, so that sheets that are near in space do not mix.
//!
//! # Source
//! Botsch and Kobbelt, "A remeshing approach to multiresolution modeling", SGP 2004, for the
//! operations; Lawson 1977 for the flips.

use super::metric::{Metric, shape};
use super::sizing::Sizing;
use super::start::Start;
use super::surface::NurbsSurface;
use crate::geometry::{DVec2, DVec3, OrderBy};

const NONE: u32 = u32::MAX;
/// Edge over the allowed length from which it is split.
const TOO_LONG: f64 = 1.25;
/// Edge over the allowed length below which its faces are not split any more.
const TOO_SHORT: f64 = 0.05;
/// Passes of splitting; each halves the longest edges.
const SPLIT_PASSES: usize = 80;
/// Passes that split the sides themselves that are too long; later ones split the longest sides of their
/// faces. Where a triangle reaches around an edge of the surface that is thinner than it is long, its longest
/// side may exceed less than the others, the halves of which would come back forever.
const FIRST_PASSES: usize = 24;
/// Of so many faces one may have a side that is too long when later passes end: sizes are a guess, and the
/// distance from the surface is measured afterwards.
const FEW: usize = 1000;
/// Rounds of the last smoothing.
const SMOOTHINGS: usize = 4;
/// Flips per edge in one go; Lawson's flips end by themselves in the plane only.
const FLIPS_PER_EDGE: usize = 8;
/// Part of its parameter area below which a face counts as turned over.
const UPRIGHT: f64 = 1e-3;
/// Factor by which a flip must better the worse of two shapes; below it rounding could go in circles.
const BETTER: f64 = 1.001;
/// Part of the length on the surface below which a straight line takes a short cut.
const STRAIGHT: f64 = 0.7;
/// Height of a face, in its longest edge, from which it has a plane.
const NEEDLE: f64 = 1e-3;
/// Shape (1 for equilateral) from which a vertex may move although the worst face gets worse.
const GOOD: f64 = 0.75;

/// A mesh in the making.
pub(super) struct Mesh<'a> {
    surface: &'a NurbsSurface,
    sizing: &'a Sizing,
    pub positions: Vec<DVec3>,
    /// Allowed lengths of edges.
    metrics: Vec<Metric>,
    free: Vec<Option<usize>>,
    fixed: Vec<bool>,
    pub faces: Vec<[u32; 3]>,
    /// Parameters of the corners, without jumps within a face.
    pub corners: Vec<[DVec2; 3]>,
    /// Side across each side (three times the face plus the corner it starts at).
    across: Vec<u32>,
    /// Faces that changed since the last pass of splitting.
    dirty: Vec<bool>,
    /// Length over what is allowed by side, as far as it was asked for; of unchanged faces it holds.
    excesses: Vec<Option<f64>>,
    /// Whether the straight line takes a short cut by side, as far as it was asked for and still holds.
    short_cuts: Vec<Option<bool>>,
    most_faces: usize,
}

/// More faces would be needed than are allowed; how many there are.
pub(super) struct TooMany(pub usize);

impl<'a> Mesh<'a> {
    pub fn new(
        surface: &'a NurbsSurface,
        sizing: &'a Sizing,
        start: Start,
        most_faces: usize,
    ) -> Self {
        let positions: Vec<DVec3> = start.parameters.iter().map(|p| surface.point(*p)).collect();
        let (faces, corners): (Vec<_>, Vec<_>) = start.faces.into_iter().unzip();
        let across = across(&faces);
        let metrics = start.parameters.iter().map(|p| sizing.metric(*p)).collect();
        let (free, fixed) = (start.free, start.fixed);
        let dirty = vec![true; faces.len()];
        let mut mesh = Self {
            surface,
            sizing,
            positions,
            metrics,
            free,
            fixed,
            faces,
            corners,
            across,
            dirty,
            excesses: Vec::new(),
            short_cuts: Vec::new(),
            most_faces,
        };
        mesh.short_cuts.resize(mesh.across.len(), None);
        (0..mesh.faces.len()).for_each(|f| mesh.settle(f));
        mesh.take_boundary_sizes();
        mesh
    }

    /// Marks a face as changed.
    fn touch(&mut self, f: usize) {
        self.dirty[f] = true;
        self.short_cuts[3 * f..3 * f + 3].fill(None);
    }

    /// Sizes of boundary vertices from the steps of the boundary.
    fn take_boundary_sizes(&mut self) {
        let mut sums = vec![(0.0, 0.0); self.positions.len()];
        for side in (0..self.across.len()).filter(|&s| self.across[s] == NONE) {
            let (a, b) = self.ends(side);
            for v in [a, b] {
                let length = self.metrics[v].length(self.positions[b] - self.positions[a]);
                sums[v] = (sums[v].0 + length, sums[v].1 + 1.0);
            }
        }
        for (metric, (sum, count)) in self.metrics.iter_mut().zip(sums) {
            if sum > 0.0 {
                *metric = metric.scaled((1.2 * sum / count).min(1.0));
            }
        }
    }

    fn ends(&self, side: usize) -> (usize, usize) {
        let face = self.faces[side / 3];
        (face[side % 3] as usize, face[(side % 3 + 1) % 3] as usize)
    }

    /// Parameters of the ends of a side.
    fn along(&self, side: usize) -> (DVec2, DVec2) {
        let corners = self.corners[side / 3];
        (corners[side % 3], corners[(side % 3 + 1) % 3])
    }

    /// Gives pole corners the parameter between the other corners.
    fn settle(&mut self, f: usize) {
        let face = self.faces[f];
        for i in 0..3 {
            if let Some(axis) = self.free[face[i] as usize] {
                let others = [(i + 1) % 3, (i + 2) % 3];
                let telling = others.iter().filter(|&&k| self.free[face[k] as usize] != Some(axis));
                let (sum, count) =
                    telling.fold((0.0, 0.0), |(s, n), &k| (s + self.corners[f][k][axis], n + 1.0));
                if count > 0.0 {
                    self.corners[f][i][axis] = sum / count;
                }
            }
        }
    }

    /// How much longer the straight line between the parameters of two vertices is than the
    /// straight line in space; 1 where they hardly differ.
    fn detour(&self, [v, w]: [u32; 2], [p, q]: [DVec2; 2]) -> f64 {
        let [v, w] = [v as usize, w as usize];
        let (a, b) = (self.positions[v], self.positions[w]);
        let chord = a.distance(b);
        if chord >= STRAIGHT * self.sizing.longest(p, q) && chord > 0.0 {
            return 1.0;
        }
        let line = self.sizing.length(p, q);
        if chord <= 0.0 || chord >= STRAIGHT * line {
            return 1.0;
        }
        // The grid knows long lines; short ones, as around a thin edge, are followed.
        let long = line > 1.5 * self.metrics[v].wide.min(self.metrics[w].wide);
        if long { line / chord } else { self.way([a, b], [p, q]) / chord }
    }

    /// Whether the straight line between the ends of a side takes a short cut.
    fn is_short_cut(&mut self, side: usize) -> bool {
        if let Some(known) = self.short_cuts[side] {
            return known;
        }
        let ((a, b), (p, q)) = (self.ends(side), self.along(side));
        let is = self.detour([a as u32, b as u32], [p, q]) > 1.0;
        self.short_cuts[side] = Some(is);
        if self.across[side] != NONE {
            self.short_cuts[self.across[side] as usize] = Some(is);
        }
        is
    }

    /// Length of a polyline on the surface, mm.
    fn way(&self, [a, b]: [DVec3; 2], [p, q]: [DVec2; 2]) -> f64 {
        let between = [0.25, 0.5, 0.75].map(|t| self.surface.point(p.lerp(q, t)));
        let places = [a, between[0], between[1], between[2], b];
        places.windows(2).map(|pair| pair[0].distance(pair[1])).sum()
    }

    /// Shape of a face as its metrics see it: 1 for the best, 0 for a needle.
    fn shape_of(&self, face: [u32; 3]) -> f64 {
        let p = face.map(|v| self.positions[v as usize]);
        shape([0, 1, 2].map(|i| self.square(face, p[(i + 1) % 3] - p[i])))
    }

    /// Shape of a face from the lengths of its sides on the surface.
    fn shape_along(&self, face: [u32; 3], corners: [DVec2; 3]) -> f64 {
        shape([0, 1, 2].map(|i| {
            let j = (i + 1) % 3;
            let detour = self.detour([face[i], face[j]], [corners[i], corners[j]]);
            let (a, b) = (self.positions[face[i] as usize], self.positions[face[j] as usize]);
            detour * detour * a.distance_squared(b)
        }))
    }

    /// Square of an edge's length for a face, in those that are allowed.
    fn square(&self, face: [u32; 3], edge: DVec3) -> f64 {
        face.iter().map(|&v| self.metrics[v as usize].square(edge)).sum()
    }

    /// Length of a side over what is allowed.
    fn excess(&self, side: usize) -> f64 {
        let ((a, b), (p, q)) = (self.ends(side), self.along(side));
        self.excess_between([a as u32, b as u32], [p, q])
    }

    fn excess_between(&self, ends: [u32; 2], [p, q]: [DVec2; 2]) -> f64 {
        let [a, b] = ends.map(|v| v as usize);
        let edge = self.positions[b] - self.positions[a];
        let mean = 0.5 * (self.metrics[a].length(edge) + self.metrics[b].length(edge));
        let middle = self.sizing.metric(0.5 * (p + q)).length(edge);
        self.detour(ends, [p, q]) * mean.max(middle)
    }

    /// Splits, flips and moves until no edge is too long.
    pub fn refine(&mut self) -> Result<(), TooMany> {
        self.flip_all();
        for pass in 0..SPLIT_PASSES {
            let count = self.split_pass(pass < FIRST_PASSES)?;
            self.flip_all();
            if count * 8 < self.faces.len() && pass < FIRST_PASSES {
                self.smooth();
                self.flip_all();
            }
            let few = if pass < FIRST_PASSES { 0 } else { self.faces.len() / FEW };
            if count <= few {
                break;
            }
        }
        self.dirty.fill(true);
        for _ in 0..SMOOTHINGS {
            self.smooth();
            self.flip_all();
        }
        Ok(())
    }

    /// Splits the edges that are too long, longest first, one per face; how many.
    fn split_pass(&mut self, by_excess: bool) -> Result<usize, TooMany> {
        self.excesses.resize(self.across.len(), None);
        let mut long: Vec<(f64, usize)> = Vec::new();
        for side in 0..self.across.len() {
            if self.dirty[side / 3] {
                self.excesses[side] = None;
            }
            if self.across[side] == NONE || side > self.across[side] as usize {
                continue;
            }
            let excess = self.excesses[side].unwrap_or_else(|| self.excess(side));
            self.excesses[side] = Some(excess);
            if excess > TOO_LONG && !self.beside_short(side) {
                long.push(if by_excess { (excess, side) } else { self.longest_beside(side) });
            }
        }
        long.order_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
        let sides = long.into_iter().map(|(_, s)| s).collect();
        self.split(sides)
    }

    /// The longest inner side of the two faces of a side, and its length along the surface, mm.
    fn longest_beside(&self, side: usize) -> (f64, usize) {
        let faces = [side / 3, self.across[side] as usize / 3];
        let sides = faces.into_iter().flat_map(|f| [3 * f, 3 * f + 1, 3 * f + 2]);
        let inner = sides.filter(|&s| self.across[s] != NONE).map(|s| {
            let (p, q) = self.along(s);
            (self.sizing.length(p, q), s.min(self.across[s] as usize))
        });
        inner.fold((0.0, side), |a, b| if b.0 > a.0 { b } else { a })
    }

    /// Whether a face of a side is a needle already, which halving its long sides makes no better.
    fn beside_short(&self, side: usize) -> bool {
        [side, self.across[side] as usize].into_iter().any(|s| {
            let face = self.faces[s / 3];
            let p = face.map(|v| self.positions[v as usize]);
            (0..3).any(|i| self.square(face, p[(i + 1) % 3] - p[i]) < 3.0 * TOO_SHORT * TOO_SHORT)
        })
    }

    /// Splits sides, leaving out those of faces that changed before; how many.
    pub fn split(&mut self, sides: Vec<usize>) -> Result<usize, TooMany> {
        self.dirty.fill(false);
        let mut count = 0;
        for side in sides {
            let other = self.across[side];
            let second = if other == NONE { side / 3 } else { other as usize / 3 };
            if self.dirty[side / 3] || self.dirty[second] {
                continue;
            }
            (self.dirty[side / 3], self.dirty[second]) = (true, true);
            self.split_side(side);
            self.dirty.resize(self.faces.len(), true);
            count += 1;
            if self.faces.len() > self.most_faces {
                return Err(TooMany(self.faces.len()));
            }
        }
        Ok(count)
    }

    /// The middle of a side: along the line of the end that is no pole.
    fn middle(&self, side: usize) -> DVec2 {
        let ((v, w), (mut p, mut q)) = (self.ends(side), self.along(side));
        match (self.free[v], self.free[w]) {
            (Some(axis), None) => p[axis] = q[axis],
            (None, Some(axis)) => q[axis] = p[axis],
            _ => {}
        }
        0.5 * (p + q)
    }

    fn split_side(&mut self, side: usize) {
        let at = self.middle(side);
        let (a, b) = self.ends(side);
        let m = self.positions.len() as u32;
        self.positions.push(self.surface.point(at));
        let near = |metric: Metric, v: usize| {
            metric.near(&self.metrics[v], self.positions[v].distance(self.positions[m as usize]))
        };
        let metric = near(near(self.sizing.metric(at), a), b);
        self.metrics.push(metric);
        self.free.push(None);
        let other = self.across[side];
        self.fixed.push(other == NONE);
        if other == NONE {
            let (first, second) = self.cut(side, m, at);
            (self.across[first as usize], self.across[second as usize]) = (NONE, NONE);
            return;
        }
        let other = other as usize;
        let shift = self.shift(side, other);
        let (first, second) = self.cut(side, m, at);
        // The other side runs the other way.
        let (third, fourth) = self.cut(other, m, at + shift);
        self.join(first, fourth);
        self.join(second, third);
    }

    fn join(&mut self, a: u32, b: u32) {
        self.across[a as usize] = b;
        self.across[b as usize] = a;
    }

    /// What the parameters of the face across differ by.
    fn shift(&self, side: usize, other: usize) -> DVec2 {
        let ((v, _), (p, q), (r, s)) = (self.ends(side), self.along(side), self.along(other));
        // The side starts where the other ends; a pole does not tell.
        if self.free[v].is_none() { s - p } else { r - q }
    }

    /// Cuts the face of `side` from its middle `m` to the corner across; the two halves of the side.
    fn cut(&mut self, side: usize, m: u32, at: DVec2) -> (u32, u32) {
        let (f, i) = (side / 3, side % 3);
        let (j, k) = ((i + 1) % 3, (i + 2) % 3);
        let (face, corners) = (self.faces[f], self.corners[f]);
        let new = self.faces.len();
        self.faces[f][j] = m;
        self.corners[f][j] = at;
        self.faces.push([m, face[j], face[k]]);
        self.corners.push([at, corners[j], corners[k]]);
        self.across.extend([NONE; 3]);
        self.short_cuts.extend([None; 3]);
        self.short_cuts[3 * f..3 * f + 3].fill(None);
        let outer = self.across[3 * f + j];
        if outer == NONE {
            self.across[3 * new + 1] = NONE;
        } else {
            self.join((3 * new + 1) as u32, outer);
        }
        self.join((3 * f + j) as u32, (3 * new + 2) as u32);
        self.settle(f);
        self.settle(new);
        (side as u32, 3 * new as u32)
    }

    /// Flips until no edge of a changed face wants to.
    pub fn flip_all(&mut self) {
        let sides = (0..self.across.len()).rev().filter(|s| self.dirty[s / 3]);
        let mut pending: Vec<u32> = sides.map(|s| s as u32).collect();
        let mut left = FLIPS_PER_EDGE * pending.len();
        while let Some(side) = pending.pop() {
            let other = self.across[side as usize];
            if other == NONE || left == 0 || !self.wants_flip(side as usize, other as usize) {
                continue;
            }
            left -= 1;
            let (f, g) = (side / 3, other / 3);
            self.flip(side as usize, other as usize);
            self.touch(f as usize);
            self.touch(g as usize);
            pending.extend((0..3).flat_map(|i| [3 * f + i, 3 * g + i]));
        }
    }

    /// Twice the area of three corners in the parameters.
    fn parameter_area(corners: [DVec2; 3]) -> f64 {
        (corners[1] - corners[0]).perp_dot(corners[2] - corners[0])
    }

    /// The corners of both faces beside an edge, in the parameters of the first: its ends, the
    /// corner of the first face, that of the second.
    fn diamond(&self, side: usize, other: usize) -> ([u32; 4], [DVec2; 4]) {
        let (f, i, g, j) = (side / 3, side % 3, other / 3, other % 3);
        let shift = self.shift(side, other);
        let vertices = [
            self.faces[f][i],
            self.faces[f][(i + 1) % 3],
            self.faces[f][(i + 2) % 3],
            self.faces[g][(j + 2) % 3],
        ];
        let c = &self.corners[f];
        let corners = [c[i], c[(i + 1) % 3], c[(i + 2) % 3], self.corners[g][(j + 2) % 3] - shift];
        (vertices, corners)
    }

    fn wants_flip(&mut self, side: usize, other: usize) -> bool {
        let ([a, b, c, d], [pa, pb, pc, pd]) = self.diamond(side, other);
        if c == d || self.joined(side, other, c, d) {
            return false;
        }
        let old = Self::parameter_area([pa, pb, pc]).min(Self::parameter_area([pb, pa, pd]));
        let (new_a, new_b) =
            (self.settled([a, d, c], [pa, pd, pc]), self.settled([d, b, c], [pd, pb, pc]));
        let new = Self::parameter_area(new_a).min(Self::parameter_area(new_b));
        let whole = Self::parameter_area([pa, pb, pc]) + Self::parameter_area([pb, pa, pd]);
        if new <= UPRIGHT * whole.abs() {
            return old <= 0.0 && new > old && new > 0.0;
        }
        if old <= 0.0 {
            return true;
        }
        // Sides that take a short cut have no direction, so that metrics say nothing of them.
        let next = |s: usize, k: usize| s - s % 3 + (s + k) % 3;
        let sides = [side, next(side, 1), next(side, 2), next(other, 1), next(other, 2)];
        let bent =
            sides.into_iter().any(|s| self.is_short_cut(s)) || self.detour([c, d], [pc, pd]) > 1.0;
        let shape = |face: [u32; 3], corners: [DVec2; 3]| {
            if bent { self.shape_along(face, corners) } else { self.shape_of(face) }
        };
        let (old_a, old_b) =
            (self.settled([a, b, c], [pa, pb, pc]), self.settled([b, a, d], [pb, pa, pd]));
        let before = shape([a, b, c], old_a).min(shape([b, a, d], old_b));
        let after = shape([a, d, c], new_a).min(shape([d, b, c], new_b));
        // The worse of two shapes gets better with every flip, so that flipping ends.
        // No flip makes an edge that is too long still longer: splits would halve it forever.
        let no_longer = || {
            let old = self.excess_between([a, b], [pa, pb]);
            self.excess_between([c, d], [pc, pd]) <= old.max(TOO_LONG)
        };
        after > BETTER * before + 1e-9 && no_longer()
    }

    /// Corners with the free parameter of a pole between the others.
    fn settled(&self, face: [u32; 3], mut corners: [DVec2; 3]) -> [DVec2; 3] {
        for i in 0..3 {
            if let Some(axis) = self.free[face[i] as usize] {
                corners[i][axis] = 0.5 * (corners[(i + 1) % 3][axis] + corners[(i + 2) % 3][axis]);
            }
        }
        corners
    }

    /// Whether the two corners across an edge are neighbours already (around a vertex of three).
    fn joined(&self, side: usize, other: usize, c: u32, d: u32) -> bool {
        let holds = |s: usize, v: u32| {
            let across = self.across[s];
            across != NONE && self.faces[across as usize / 3].contains(&v)
        };
        let next = |s: usize, k: usize| s - s % 3 + (s + k) % 3;
        holds(next(side, 1), d)
            || holds(next(side, 2), d)
            || holds(next(other, 1), c)
            || holds(next(other, 2), c)
    }

    fn flip(&mut self, side: usize, other: usize) {
        let ([a, b, c, d], [pa, pb, pc, pd]) = self.diamond(side, other);
        let (f, g) = (side / 3, other / 3);
        let next = |s: usize, k: usize| s - s % 3 + (s + k) % 3;
        let outer = |mesh: &Self, s: usize| mesh.across[s];
        let (bc, ca) = (outer(self, next(side, 1)), outer(self, next(side, 2)));
        let (ad, db) = (outer(self, next(other, 1)), outer(self, next(other, 2)));
        (self.faces[f], self.corners[f]) = ([a, d, c], [pa, pd, pc]);
        (self.faces[g], self.corners[g]) = ([d, b, c], [pd, pb, pc]);
        let (f3, g3) = (3 * f as u32, 3 * g as u32);
        for (s, o) in [(f3, ad), (f3 + 2, ca), (g3, db), (g3 + 1, bc)] {
            if o == NONE {
                self.across[s as usize] = NONE;
            } else {
                self.join(s, o);
            }
        }
        self.join(f3 + 1, g3 + 2);
        self.settle(f);
        self.settle(g);
    }

    /// Moves every inner vertex of a changed face toward the middle of its faces, where that does
    /// them good.
    pub fn smooth(&mut self) {
        let (start, around) = self.stars();
        for v in 0..self.positions.len() {
            let star = &around[start[v] as usize..start[v + 1] as usize];
            let changed = star.iter().any(|&c| self.dirty[c as usize / 3]);
            if changed && !self.fixed[v] && self.free[v].is_none() {
                self.move_vertex(v, star);
            }
        }
    }

    /// The corners (three times the face plus the corner) at every vertex.
    fn stars(&self) -> (Vec<u32>, Vec<u32>) {
        let mut start = vec![0; self.positions.len() + 1];
        for v in self.faces.iter().flatten() {
            start[*v as usize + 1] += 1;
        }
        for v in 1..start.len() {
            start[v] += start[v - 1];
        }
        let mut fill = start.clone();
        let mut around = vec![0; 3 * self.faces.len()];
        for (corner, v) in self.faces.iter().flatten().enumerate() {
            around[fill[*v as usize] as usize] = corner as u32;
            fill[*v as usize] += 1;
        }
        (start, around)
    }

    fn move_vertex(&mut self, v: usize, star: &[u32]) {
        let Some(&first) = star.first() else { return };
        let at = self.corners[first as usize / 3][first as usize % 3];
        let jet = self.surface.jet(at);
        let [su, sv] = jet.first;
        let (e, f, g) = (su.length_squared(), su.dot(sv), sv.length_squared());
        let det = e * g - f * f;
        if det <= 1e-12 * e * g {
            return;
        }
        let offset = self.middle_of(star) - self.positions[v];
        let (x, y) = (offset.dot(su), offset.dot(sv));
        let step = DVec2::new(g * x - f * y, e * y - f * x) / det;
        let before = self.worst(star, DVec2::ZERO, self.positions[v]);
        for factor in [1.0, 0.4] {
            let to = self.surface.point(at + step * factor);
            let after = self.worst(star, step * factor, to);
            if after > before || (after > GOOD && after > 0.9 * before) {
                for &corner in star {
                    self.corners[corner as usize / 3][corner as usize % 3] += step * factor;
                }
                self.positions[v] = to;
                for &corner in star {
                    self.settle(corner as usize / 3);
                    self.touch(corner as usize / 3);
                }
                return;
            }
        }
    }

    /// Middle of the faces around a vertex, small ones counting as much as their sizes ask.
    fn middle_of(&self, star: &[u32]) -> DVec3 {
        let (mut sum, mut total) = (DVec3::ZERO, 0.0);
        for &corner in star {
            let face = self.faces[corner as usize / 3];
            let [a, b, c] = face.map(|v| self.positions[v as usize]);
            let allowed =
                |&v: &u32| self.metrics[v as usize].narrow * self.metrics[v as usize].wide;
            let weight = (b - a).cross(c - a).length() / face.iter().map(allowed).sum::<f64>();
            sum += (a + b + c) * (weight / 3.0);
            total += weight;
        }
        if total > 0.0 {
            sum / total
        } else {
            self.positions[self.faces[star[0] as usize / 3][star[0] as usize % 3] as usize]
        }
    }

    /// Worst shape around a vertex moved by `step` to `to`; negative where a face turns over.
    fn worst(&self, star: &[u32], step: DVec2, to: DVec3) -> f64 {
        let quality = |&corner: &u32| {
            let (f, i) = (corner as usize / 3, corner as usize % 3);
            let mut p = self.faces[f].map(|v| self.positions[v as usize]);
            p[i] = to;
            let mut corners = self.corners[f];
            let old = Self::parameter_area(corners);
            corners[i] += step;
            let corners = self.settled(self.faces[f], corners);
            if Self::parameter_area(corners) <= UPRIGHT * old.abs() {
                return -1.0;
            }
            shape([0, 1, 2].map(|i| self.square(self.faces[f], p[(i + 1) % 3] - p[i])))
        };
        star.iter().map(quality).fold(f64::INFINITY, f64::min)
    }

    /// Farthest distance between surface and face, at the middles of face and sides; and the side
    /// to split: the boundary side that is too far off by itself, else the longest inner one.
    pub fn chord_error(&self, f: usize, chord: f64) -> (f64, usize) {
        let p = self.faces[f].map(|v| self.positions[v as usize]);
        let c = self.corners[f];
        let cross = (p[1] - p[0]).cross(p[2] - p[0]);
        let longest = (0..3).map(|i| p[i].distance_squared(p[(i + 1) % 3])).fold(0.0, f64::max);
        let needle = cross.length() <= NEEDLE * longest;
        let normal = cross.normalize_or_zero();
        let middle = (c[0] + c[1] + c[2]) / 3.0;
        let mut error = (self.surface.point(middle) - p[0]).dot(normal).abs();
        let mut best = (-1.0, 3 * f);
        for i in 0..3 {
            let side = 3 * f + i;
            let x = self.surface.point(self.middle(side));
            let (a, b) = (p[i], p[(i + 1) % 3]);
            let inner = self.across[side] != NONE;
            let way = (b - a).normalize_or_zero();
            let line = || (x - a - way * (x - a).dot(way)).length();
            // Beside an edge of the boundary there is nothing that could be nearer.
            let off = if inner && !needle { (x - a).dot(normal).abs() } else { line() };
            error = error.max(off);
            let rank = match inner {
                true => self.square(self.faces[f], b - a),
                false if off > chord => f64::INFINITY,
                false => 0.0,
            };
            if rank > best.0 {
                best = (rank, side);
            }
        }
        (error, best.1)
    }

    /// Whether a face changed since the last pass of splitting.
    pub fn is_changed(&self, f: usize) -> bool {
        self.dirty[f]
    }

    /// Where the middle of a face is.
    pub fn place(&self, f: usize) -> DVec3 {
        self.faces[f].iter().map(|v| self.positions[*v as usize]).sum::<DVec3>() / 3.0
    }
}

/// The side across every side.
fn across(faces: &[[u32; 3]]) -> Vec<u32> {
    let mut sides: Vec<(u32, u32, u32)> = Vec::with_capacity(3 * faces.len());
    for (f, face) in faces.iter().enumerate() {
        for i in 0..3 {
            let (a, b) = (face[i], face[(i + 1) % 3]);
            sides.push((a.min(b), a.max(b), (3 * f + i) as u32));
        }
    }
    sides.order_total();
    let mut across = vec![NONE; sides.len()];
    let mut k = 0;
    while k + 1 < sides.len() {
        if (sides[k].0, sides[k].1) == (sides[k + 1].0, sides[k + 1].1) {
            let (s, o) = (sides[k].2, sides[k + 1].2);
            (across[s as usize], across[o as usize]) = (o, s);
            k += 1;
        }
        k += 1;
    }
    across
}
