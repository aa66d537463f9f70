//! A net of right triangles that follows the heights of the reached surface.
//!
//! A triangle is halved where the surface deviates from it by more than the accuracy, along the surface's normal, and
//! while it is large if it lies across the outline. The triangle on the other side of its base is halved with it, and
//! whatever has to be halved before: no side ever ends on the middle of another.

use super::error::ReachError;
use super::lattice::{Key, Lattice, Triangle, halves, has_halves, middle};
use super::options::ReachOptions;
use super::terrain::{Height, Terrain};
use crate::geometry::math::tan;
use crate::geometry::{DVec2, DVec3, OrderBy};
use crate::parallel;
use std::collections::{HashMap, HashSet};

/// Longest base across the outline, cutter radii.
const OUTLINE: f64 = 1.0 / 16.0;
/// What is steeper than this cosine to the axis is no longer taken for shorter.
const STEEP: f64 = 0.25;
/// Shortest base on what the cutter bridges, radii of the cutter's rounding, or of a flat end.
const BRIDGE: f64 = 1.0 / 8.0;
/// Shortest base over an edge beside which it bridges the part, cutter radii.
const EDGE: f64 = 1.0 / 128.0;
/// Cosine of the angle between two places on one side of an edge, as near as the ends of a side: 45 degrees.
pub(super) const SAME_SIDE: f64 = core::f64::consts::FRAC_1_SQRT_2;
/// Tangent of a slope that may be a wall: 60 degrees.
const WALL: f64 = 1.732_050_807_568_877_2;
/// How much steeper than at its ends a line between two places of one surface may seem.
const SLACK: f64 = 1.05;
/// Rounds in which heights are passed on from place to place.
const SETTLED: usize = 16;
/// Most heights that are asked; more are refused; fewer in WebAssembly, all of whose memory is 4 GB.
const MOST: usize = if cfg!(target_pointer_width = "32") { 1_500_000 } else { 8_000_000 };

/// The triangles, and the height at every place that was asked.
pub(super) struct Net<'a> {
    terrain: &'a Terrain<'a>,
    pub lattice: Lattice,
    heights: HashMap<Key, Option<Height>>,
    /// Middles of bases whose triangles are halved.
    halved: HashSet<Key>,
    /// Bases at which no halving is needed.
    settled: HashSet<[Key; 2]>,
    accuracy: f64,
    /// Longest base across the outline, mm.
    outline: f64,
    /// Shortest base on what the cutter bridges, mm.
    bridge: f64,
    /// Shortest base over an edge beside which the cutter bridges the part, mm.
    edge: f64,
    /// Tangent of the steepest slope that is followed: what is steeper is a jump.
    pub steepest: f64,
    pub threads: usize,
}

/// Tangent of the slope of a surface with this unit normal.
pub(super) fn tangent(normal: DVec3) -> f64 {
    normal.truncate().length() / normal.z.max(f64::MIN_POSITIVE)
}

impl<'a> Net<'a> {
    pub fn new(terrain: &'a Terrain<'a>, lattice: Lattice, options: &ReachOptions) -> Self {
        let corner = options.tool.corner_radius();
        let rounding = if corner > 0.0 { corner } else { options.tool.radius() };
        Self {
            terrain,
            lattice,
            heights: HashMap::new(),
            halved: HashSet::new(),
            settled: HashSet::new(),
            accuracy: options.accuracy,
            outline: (OUTLINE * options.tool.radius()).max(2.0 * lattice.unit),
            bridge: BRIDGE * rounding,
            edge: EDGE * options.tool.radius(),
            steepest: tan(options.followed()),
            threads: options.threads,
        }
    }

    /// The height at a place, which was asked before.
    pub fn known(&self, key: Key) -> Option<Height> {
        self.heights.get(&key).copied().flatten()
    }

    /// The height at any place; `near`: that of a place nearby.
    pub fn height(&self, at: DVec2, near: Height) -> Option<Height> {
        self.terrain.height(at, &[near])
    }

    /// The place of a key, mm; it must be one at which there is a height.
    pub fn place(&self, key: Key, height: Height) -> DVec3 {
        self.lattice.at(key).extend(height.z)
    }

    /// All triangles.
    pub fn triangles(&self) -> Vec<Triangle> {
        let mut open: Vec<Triangle> = self.lattice.triangles().collect();
        open.reverse();
        let mut out = Vec::new();
        while let Some(triangle) = open.pop() {
            if self.is_halved(triangle) {
                open.extend(halves(triangle));
            } else {
                out.push(triangle);
            }
        }
        out
    }

    fn is_halved(&self, triangle: Triangle) -> bool {
        has_halves(triangle) && self.halved.contains(&middle(triangle[1], triangle[2]))
    }

    /// Halves until the heights at the middles of bases, and one level below, are met.
    ///
    /// # Errors
    /// [`TooFine`](ReachError::TooFine) if that takes too many heights.
    pub fn refine(&mut self) -> Result<(), ReachError> {
        loop {
            let open: Vec<Triangle> =
                self.triangles().into_iter().filter(|t| !self.is_settled(*t)).collect();
            if open.is_empty() {
                break;
            }
            self.refuse_too_many()?;
            self.ask(open.iter().flatten().copied());
            let places = open.iter().filter(|t| has_halves(**t)).flat_map(|t| self.tested(*t));
            let places: Vec<Key> = places.collect();
            self.ask(places.into_iter());
            for triangle in open {
                if self.has_to_be_halved(triangle) {
                    self.halve(middle(triangle[1], triangle[2]));
                } else {
                    self.settled.insert([triangle[0], triangle[1]]);
                }
            }
        }
        let corners: Vec<Key> = self.triangles().into_iter().flatten().collect();
        self.ask(corners.into_iter());
        Ok(())
    }

    fn refuse_too_many(&self) -> Result<(), ReachError> {
        match self.heights.len() {
            many if many > MOST => Err(ReachError::TooFine { most: MOST, accuracy: self.accuracy }),
            _ => Ok(()),
        }
    }

    /// Halves until the corners of the part are met, which may lie between the places that were asked.
    ///
    /// # Errors
    /// As [`refine`](Self::refine).
    pub fn refine_at(&mut self, corners: &[DVec3]) -> Result<(), ReachError> {
        let seen = |p: &DVec3| match self.terrain.is_in_sight(*p) {
            true => self.terrain.height(p.truncate(), &[]),
            false => None,
        };
        let heights = parallel::map(self.threads, corners, seen);
        let pairs = corners.iter().zip(heights).filter_map(|(p, h)| Some((p.truncate(), h?)));
        let mut open: Vec<(DVec2, Height)> = pairs.collect();
        while !open.is_empty() {
            self.refuse_too_many()?;
            let mut off = Vec::new();
            let mut bases = Vec::new();
            for (at, height) in open {
                let Some(triangle) = self.around(at) else { continue };
                if has_halves(triangle) && self.misses(triangle, at, height) {
                    bases.push(middle(triangle[1], triangle[2]));
                    off.push((at, height));
                }
            }
            bases.into_iter().for_each(|base| self.halve(base));
            let corners: Vec<Key> = self.triangles().into_iter().flatten().collect();
            self.ask(corners.into_iter());
            open = off;
        }
        self.refine()
    }

    /// Lowers heights where the cutter bridges, to what it leaves that stands for a place beside: alone, the search for
    /// them may miss that.
    pub fn settle(&mut self) {
        let triangles = self.triangles();
        let sides = triangles.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]);
        let mut sides: Vec<[Key; 2]> = sides.flat_map(|[a, b]| [[a, b], [b, a]]).collect();
        let is_bridge = |k: &Key| self.known(*k).is_some_and(|h| h.is_bridge());
        sides.retain(|side| side.iter().all(is_bridge));
        sides.order_total();
        sides.dedup();
        for _ in 0..SETTLED {
            let lower = |[own, other]: &[Key; 2]| {
                let other = (self.lattice.at(*other), self.known(*other)?);
                let height =
                    self.terrain.also_left(self.lattice.at(*own), self.known(*own)?, other)?;
                Some((*own, height))
            };
            let found: Vec<(Key, Height)> = sides.iter().filter_map(lower).collect();
            if found.is_empty() {
                break;
            }
            for (key, height) in found {
                let is_lowest = self.known(key).is_some_and(|h| height.z < h.z);
                if is_lowest {
                    self.heights.insert(key, Some(height));
                }
            }
        }
    }

    /// Asks for heights.
    fn ask(&mut self, places: impl Iterator<Item = Key>) {
        let mut new: Vec<Key> = places.filter(|k| !self.heights.contains_key(k)).collect();
        new.order_total();
        new.dedup();
        let of = |key: &Key| {
            let around: Vec<Height> = match self.lattice.is_given(*key) {
                true => Vec::new(),
                false => self.lattice.needed(*key).filter_map(|k| self.known(k)).collect(),
            };
            self.terrain.height(self.lattice.at(*key), &around)
        };
        let heights = parallel::map(self.threads, &new, of);
        self.heights.extend(new.into_iter().zip(heights));
    }

    fn is_settled(&self, [apex, a, _]: Triangle) -> bool {
        self.settled.contains(&[apex, a])
    }

    /// The places at which a triangle is tested: the middle of its base, and of its other sides if those are long.
    fn tested(&self, [apex, a, b]: Triangle) -> Vec<Key> {
        let mut places = vec![middle(a, b)];
        let is_long = self.lattice.at(a).distance(self.lattice.at(b)) > self.outline;
        if is_long && has_halves([b, apex, a]) && has_halves([a, b, apex]) {
            places.extend([middle(apex, a), middle(b, apex)]);
        }
        places
    }

    fn has_to_be_halved(&self, triangle: Triangle) -> bool {
        if !has_halves(triangle) {
            return false;
        }
        let [apex, a, b] = triangle;
        let heights = triangle.map(|k| self.known(k));
        let base = self.lattice.at(a).distance(self.lattice.at(b));
        // Seen from above a steep place of the part is short.
        let of_part = heights.iter().flatten().filter(|h| !h.is_bridge()).map(|h| h.normal.z);
        let outline = self.outline * of_part.fold(1.0, f64::min).max(STEEP);
        let is_off = |key: Key, ends: [(Key, Option<Height>); 2]| match (
            self.known(key),
            ends[0].1,
            ends[1].1,
        ) {
            (Some(h), Some(from), Some(to)) => {
                let length = self.lattice.at(ends[0].0).distance(self.lattice.at(ends[1].0));
                let jumps = self.jumps(from, to, length);
                let is_smooth = from.is_bridge() || to.is_bridge() || h.is_bridge();
                let above = (h.z - 0.5 * (from.z + to.z)) * h.normal.z;
                match (jumps, is_smooth) {
                    (true, _) => base > outline,
                    // Below a chord over an edge the cutter cannot come.
                    (false, true) if above > self.accuracy => base > self.edge,
                    (false, true) => base > self.bridge && above < -self.accuracy,
                    (false, false) => above.abs() > self.accuracy,
                }
            }
            (None, None, None) => false,
            _ => base > outline,
        };
        let sides = [
            [(a, heights[1]), (b, heights[2])],
            [(apex, heights[0]), (a, heights[1])],
            [(b, heights[2]), (apex, heights[0])],
        ];
        let is_across = heights.iter().any(Option::is_some) && heights.iter().any(Option::is_none);
        (is_across && base > outline)
            || self.tested(triangle).into_iter().zip(sides).any(|(key, ends)| is_off(key, ends))
    }

    /// Whether the surface jumps between two places `length` mm apart, seen from above: it would have to be steeper than
    /// is followed; or the two face different ways, and it would have to be steep, and steeper than at both, as between the
    /// top of a wall and the rounding at its foot.
    pub fn jumps(&self, a: Height, b: Height, length: f64) -> bool {
        let slope = (a.z - b.z).abs() / length;
        let is_over_edge = || a.normal.dot(b.normal) < SAME_SIDE;
        let at_ends = || SLACK * tangent(a.normal).max(tangent(b.normal));
        slope > self.steepest || (slope > WALL && is_over_edge() && slope > at_ends())
    }

    /// Halves the triangles at a base, and before them what must be halved for them to exist.
    fn halve(&mut self, base: Key) {
        let mut open = vec![base];
        while let Some(key) = open.pop() {
            if !self.lattice.is_given(key) && self.halved.insert(key) {
                open.extend(self.lattice.needed(key));
            }
        }
    }

    /// The triangle in which a place lies.
    fn around(&self, at: DVec2) -> Option<Triangle> {
        let mut triangle = self.lattice.around(at)?;
        while self.is_halved(triangle) {
            triangle = self.lattice.half_around(triangle, at);
        }
        Some(triangle)
    }

    /// Whether a triangle is off the height at a place within it.
    fn misses(&self, triangle: Triangle, at: DVec2, height: Height) -> bool {
        let base = self.lattice.at(triangle[1]).distance(self.lattice.at(triangle[2]));
        let corners = triangle.map(|k| self.known(k).map(|h| self.place(k, h)));
        let [Some(a), Some(b), Some(c)] = corners else {
            // Beside the outline a place may be missed by the length of a side.
            return corners.iter().all(Option::is_none) && base > self.outline;
        };
        let normal = (b - a).cross(c - a);
        let z = a.z - normal.truncate().dot(at - a.truncate()) / normal.z;
        let low = a.z.min(b.z).min(c.z);
        let high = a.z.max(b.z).max(c.z);
        let jumps = high - low > self.steepest * base;
        !jumps && !height.is_bridge() && (z - height.z).abs() * height.normal.z > self.accuracy
    }
}
