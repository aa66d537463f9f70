//! How far cutter, shank and holder are clear of triangles.
//!
//! - *Solid*: a convex piece of the assembly: a frustum about the tool axis, made larger all around by a radius. The
//!   cutting end is a disc made larger by the corner radius (of a ball: a point), all else a frustum as it is.
//! - *Profile*: half of a solid's section along its axis; a place has the coordinates `rho` (distance from the axis) and
//!   `z` (height above the tip) in it.
//! - *Signed distance* of a place: how far it is from the solid, negative within, where it is its depth. Of a convex
//!   solid it is a convex function of the place, so what a gradient tells of it is true everywhere: it lies above its
//!   tangent planes.
//!
//! The smallest signed distance over all triangles is wanted. In steps:
//!
//! 1. The tree of boxes is descended, the nearer box first. The tangent plane at the middle of a box bounds the signed
//!    distance in the whole box from below; boxes that cannot beat the smallest one so far are left out. So are
//!    triangles.
//! 2. Along each side of a triangle the function of one variable is minimised between brackets: the tangents at both
//!    ends bound it from below, so the error is known.
//! 3. Within the triangle the nearest place of the solid, if it lies outside, is the one farthest along the triangle's
//!    normal: known by formula. Where a solid pierces the triangle without reaching its sides, a place of the axis or of
//!    a chord in the triangle tells so.
//!
//! # Source
//! Regions of the profile and tests of triangles as in Ericson, "Real-Time Collision Detection", chapter 5; bounds by
//! tangents are Kelley's, "The Cutting-Plane Method for Solving Convex Programs", 1960, in one variable.

use crate::geometry::{DVec3, OrderBy, nearest_on_triangle};
use crate::tool::{Assembly, AssemblyPart};

/// Most triangles in a box that is not divided: fewer make the tree deeper than testing them costs.
const LEAF: usize = 4;
/// Boxes that wait during a descent; each division halves the triangles, of which there are less than 2³².
const WAITING: usize = 64;
/// Distances along the sides of triangles are exact to this, mm.
const EXACT: f64 = 1e-8;
/// Most steps along one side of a triangle; 4 to 8 are usual, and each two of them halve the bracket.
const MOST_STEPS: usize = 80;

/// Triangles that the tool must stay clear of, in a tree of boxes.
#[derive(Clone, Debug, Default)]
pub struct Hindrance {
    nodes: Vec<Node>,
    /// In the order of the leaves.
    triangles: Vec<[DVec3; 3]>,
}

/// A box of the tree.
#[derive(Copy, Clone, Debug)]
struct Node {
    middle: DVec3,
    half: DVec3,
    /// First triangle of a leaf; else the first of two adjacent children.
    first: usize,
    /// Triangles of a leaf; 0 of others.
    count: usize,
}

/// How far an assembly is clear.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Clearance {
    /// Distance between the assembly and the triangles, mm, exact to 1e-6 mm where it is positive. Zero or negative where
    /// they touch or penetrate: then minus the depth within the assembly of the deepest place on the sides of the
    /// triangles (within a triangle it may be deeper).
    pub distance: f64,
    /// Which part is nearest.
    pub part: AssemblyPart,
    /// Nearest (or deepest) place of the triangles, mm; the tool's tip where none is as near as was asked.
    pub place: DVec3,
}

/// Distance of the whole assembly with its tip at `tip` from the triangles.
///
/// `tip`: mm; `axis`: unit vector from the tip to the holder. `beyond`: distances from there on are not told apart, mm,
/// and `beyond` itself is returned for them; smaller is faster. Infinity finds all.
pub fn clearance(
    hindrance: &Hindrance,
    assembly: &Assembly,
    tip: DVec3,
    axis: DVec3,
    beyond: f64,
) -> Clearance {
    let mut solids = vec![Solid::of_end(assembly)];
    solids.extend(above_end(assembly));
    nearest_of(hindrance, &solids, Pose { tip, axis }, beyond)
}

/// The same of everything above the cutter's corner: the cutter's side from the corner's height on, shank and holder.
///
/// A ball is as clear for one axis as for another; this is what the axis decides.
pub fn clearance_above_end(
    hindrance: &Hindrance,
    assembly: &Assembly,
    tip: DVec3,
    axis: DVec3,
    beyond: f64,
) -> Clearance {
    nearest_of(hindrance, &above_end(assembly), Pose { tip, axis }, beyond)
}

/// Whether the whole assembly is at least so far from the triangles, mm; without its cutting end, only what is above that.
pub(crate) fn is_clear(
    hindrance: &Hindrance,
    assembly: &Assembly,
    pose: Pose,
    distance: f64,
    with_end: bool,
) -> bool {
    let end = with_end.then(|| Solid::of_end(assembly));
    let mut solids = end.into_iter().chain(above_end(assembly));
    solids.all(|solid| hindrance.nearest(&solid, pose, distance, distance).is_none())
}

/// The place of the triangles nearest to a point, mm; `None` where there are none.
pub fn nearest_place(hindrance: &Hindrance, to: DVec3) -> Option<DVec3> {
    let point = Solid::new(AssemblyPart::Cutter, [0.0; 2], [0.0; 2], 0.0);
    let pose = Pose { tip: to, axis: DVec3::Z };
    let near = hindrance.nearest(&point, pose, f64::INFINITY, f64::NEG_INFINITY);
    near.map(|near| near.place)
}

fn nearest_of(hindrance: &Hindrance, solids: &[Solid], pose: Pose, beyond: f64) -> Clearance {
    let mut best = Clearance { distance: beyond, part: AssemblyPart::Cutter, place: pose.tip };
    for solid in solids {
        if let Some(near) = hindrance.nearest(solid, pose, best.distance, f64::NEG_INFINITY) {
            best = Clearance { distance: near.distance, part: solid.part, place: near.place };
        }
    }
    best
}

/// The solids of all above the cutting end, from there upward.
pub(crate) fn above_end(assembly: &Assembly) -> Vec<Solid> {
    let (corner, radius) = (assembly.tool.corner_radius(), assembly.tool.radius());
    let side = [corner, assembly.cutter_length.max(corner)];
    let mut solids = vec![Solid::new(AssemblyPart::Cutter, side, [radius; 2], 0.0)];
    let sections = assembly.sections.iter();
    solids.extend(sections.map(|s| Solid::new(s.part, s.heights, s.radii, 0.0)));
    solids
}

/// Where the tool stands.
#[derive(Copy, Clone, Debug)]
pub(crate) struct Pose {
    /// Its tip, mm.
    pub tip: DVec3,
    /// Unit vector from there to the holder.
    pub axis: DVec3,
}

/// A convex piece of the assembly.
#[derive(Copy, Clone, Debug)]
pub(crate) struct Solid {
    /// Which part it belongs to.
    pub part: AssemblyPart,
    heights: [f64; 2],
    radii: [f64; 2],
    /// By how much the frustum is made larger all around.
    round: f64,
    /// Length of the side in the profile, its unit direction (rho, z) upward, and the unit normal outward.
    length: f64,
    up: [f64; 2],
    out: [f64; 2],
}

/// Signed distance at a place, and how it grows.
#[derive(Copy, Clone, Debug)]
struct Tangent {
    value: f64,
    gradient: DVec3,
}

/// The place of the triangles that was found.
#[derive(Copy, Clone, Debug)]
pub(crate) struct Near {
    /// Signed distance, mm.
    pub distance: f64,
    /// Where, mm.
    pub place: DVec3,
}

impl Solid {
    /// A frustum between two heights above the tip, with a radius at each, made larger by `round`; all mm.
    pub(crate) fn new(
        part: AssemblyPart,
        mut heights: [f64; 2],
        mut radii: [f64; 2],
        round: f64,
    ) -> Self {
        if heights[1] < heights[0] {
            heights.swap(0, 1);
            radii.swap(0, 1);
        }
        let rise = heights[1] - heights[0];
        if rise <= 0.0 {
            radii = [radii[0].max(radii[1]); 2];
        }
        let wide = radii[1] - radii[0];
        let length = (rise * rise + wide * wide).sqrt();
        // A disc has no side: its rim is on both ends of one that stands upright.
        let up = if length > 0.0 { [wide / length, rise / length] } else { [0.0, 1.0] };
        Self { part, heights, radii, round, length, up, out: [up[1], -up[0]] }
    }

    fn of_end(assembly: &Assembly) -> Self {
        let (corner, bottom) = (assembly.tool.corner_radius(), assembly.tool.bottom_radius());
        Self::new(AssemblyPart::Cutter, [corner; 2], [bottom; 2], corner)
    }

    /// Its pieces between the given heights, mm, rising; what is lower and higher than all of them too.
    pub(crate) fn cut_at(&self, heights: &[f64]) -> Vec<Self> {
        let [low, high] = self.heights;
        let inner = heights.iter().copied().filter(|h| *h > low && *h < high);
        let ends: Vec<f64> = [low].into_iter().chain(inner).chain([high]).collect();
        let radius = |h: f64| {
            let part = if high > low { (h - low) / (high - low) } else { 0.0 };
            self.radii[0] + part * (self.radii[1] - self.radii[0])
        };
        let piece = |w: &[f64]| {
            Self::new(self.part, [w[0], w[1]], [radius(w[0]), radius(w[1])], self.round)
        };
        ends.windows(2).map(piece).collect()
    }

    /// What it sweeps beyond itself when it moves up by `height` mm: a cylinder, from where it is the widest.
    pub(crate) fn drawn_up(&self, height: f64) -> Self {
        let ([low, high], [r0, r1]) = (self.heights, self.radii);
        let from = if r1 >= r0 { high } else { low };
        Self::new(self.part, [from, high + height], [r0.max(r1); 2], self.round)
    }

    /// Heights above the tip at which it begins and ends, mm.
    pub(crate) fn heights(&self) -> [f64; 2] {
        self.heights
    }

    /// Its largest radius, mm.
    pub(crate) fn largest_radius(&self) -> f64 {
        self.radii[0].max(self.radii[1]) + self.round
    }

    /// Signed distance in the profile and its derivatives by rho and z; the region of the nearest place decides.
    fn profile(&self, rho: f64, z: f64) -> (f64, [f64; 2]) {
        let ([low, high], [r0, r1]) = (self.heights, self.radii);
        let (below, above) = (low - z, z - high);
        let (x, y) = (rho - r0, z - low);
        let side = self.out[0] * x + self.out[1] * y;
        if side <= 0.0 && below <= 0.0 && above <= 0.0 {
            return if side >= below && side >= above {
                (side, self.out)
            } else if below >= above {
                (below, [0.0, -1.0])
            } else {
                (above, [0.0, 1.0])
            };
        }
        if below > 0.0 && rho <= r0 {
            return (below, [0.0, -1.0]);
        }
        if above > 0.0 && rho <= r1 {
            return (above, [0.0, 1.0]);
        }
        let along = self.up[0] * x + self.up[1] * y;
        if along > 0.0 && along < self.length {
            return (side, self.out);
        }
        let (x, y) = if along <= 0.0 { (x, y) } else { (rho - r1, z - high) };
        let off = (x * x + y * y).sqrt();
        if off > 0.0 { (off, [x / off, y / off]) } else { (0.0, self.out) }
    }

    fn tangent(&self, pose: Pose, place: DVec3) -> Tangent {
        let from = place - pose.tip;
        let z = from.dot(pose.axis);
        let across = from - z * pose.axis;
        let rho = across.length();
        let (value, [by_rho, by_z]) = self.profile(rho, z);
        // On the axis any direction across is as good; none is a gradient of a convex function too.
        let outward = if rho > 0.0 { by_rho / rho } else { 0.0 };
        Tangent { value: value - self.round, gradient: outward * across + by_z * pose.axis }
    }

    /// The place of the frustum, without `round`, that is farthest along `direction`, a unit vector.
    fn farthest(&self, pose: Pose, direction: DVec3) -> DVec3 {
        let rise = direction.dot(pose.axis);
        let across = direction - rise * pose.axis;
        let slope = across.length();
        let of = |i: usize| self.heights[i] * rise + self.radii[i] * slope;
        let i = usize::from(of(1) > of(0));
        let rim = if slope > 0.0 { (self.radii[i] / slope) * across } else { DVec3::ZERO };
        pose.tip + self.heights[i] * pose.axis + rim
    }
}

/// The smallest signed distance of a descent so far.
struct Search<'a> {
    solid: &'a Solid,
    pose: Pose,
    best: f64,
    place: Option<DVec3>,
}

impl Search<'_> {
    fn take(&mut self, value: f64, place: DVec3) {
        if value < self.best {
            self.best = value;
            self.place = Some(place);
        }
    }

    fn at(&self, place: DVec3) -> Tangent {
        self.solid.tangent(self.pose, place)
    }

    /// No place of the box is nearer than this.
    fn bound(&self, node: &Node) -> f64 {
        let Tangent { value, gradient } = self.at(node.middle);
        value - gradient.abs().dot(node.half)
    }

    fn triangle(&mut self, corners: &[DVec3; 3]) {
        let &[a, b, c] = corners;
        if self.solid.length == 0.0 && self.solid.radii[0] == 0.0 {
            return self.triangle_of_ball(corners);
        }
        let middle = (a + b + c) / 3.0;
        let t = self.at(middle);
        let lowest = corners.map(|p| t.gradient.dot(p - middle)).into_iter().fold(0.0, f64::min);
        if t.value + lowest >= self.best {
            return;
        }
        let ends = corners.map(|p| self.at(p));
        for (i, j) in [(0, 1), (1, 2), (2, 0)] {
            self.side([corners[i], corners[j]], [ends[i], ends[j]]);
        }
        self.inside(corners);
    }

    fn triangle_of_ball(&mut self, corners: &[DVec3; 3]) {
        let centre = self.pose.tip + self.solid.heights[0] * self.pose.axis;
        let [u, v, w] = nearest_on_triangle(centre, *corners);
        // Of a triangle without area this has no answer; the sides, of its neighbours too, have.
        let place = u * corners[0] + v * corners[1] + w * corners[2];
        if place.is_finite() {
            self.take(place.distance(centre) - self.solid.round, place);
        }
    }

    /// Step 2: the least value along a side.
    fn side(&mut self, [from, to]: [DVec3; 2], [at_from, at_to]: [Tangent; 2]) {
        let way = to - from;
        let (mut a, mut b) = (0.0, 1.0);
        let (mut fa, mut ga) = (at_from.value, at_from.gradient.dot(way));
        let (mut fb, mut gb) = (at_to.value, at_to.gradient.dot(way));
        self.take(fa, from);
        self.take(fb, to);
        if ga >= 0.0 || gb <= 0.0 {
            return;
        }
        for step in 0..MOST_STEPS {
            // Where the tangents of both ends meet, no value is lower.
            let width = b - a;
            let meet = ((fb - fa - gb * width) / (ga - gb)).clamp(0.0, width);
            let lowest = fa + ga * meet;
            if lowest >= self.best - EXACT || fa.min(fb) - lowest <= EXACT {
                return;
            }
            // Exact for a kink, exact for a parabola, and so that the bracket surely shrinks, the middle.
            let next = match step % 3 {
                0 => a + width * ga / (ga - gb),
                1 => a + meet,
                _ => 0.5 * (a + b),
            };
            if !(next > a && next < b) {
                return;
            }
            let place = from + next * way;
            let t = self.at(place);
            self.take(t.value, place);
            let slope = t.gradient.dot(way);
            if slope < 0.0 {
                (a, fa, ga) = (next, t.value, slope);
            } else if slope > 0.0 {
                (b, fb, gb) = (next, t.value, slope);
            } else {
                return;
            }
        }
    }

    /// Step 3: what is nearest to the middle of the triangle.
    fn inside(&mut self, corners: &[DVec3; 3]) {
        let [a, b, c] = *corners;
        let Some(normal) = (b - a).cross(c - a).try_normalize() else {
            return;
        };
        let [low, high] = [-normal, normal].map(|d| self.solid.farthest(self.pose, d));
        let [under, over] = [low, high].map(|p| normal.dot(p - a));
        if under > 0.0 || over < 0.0 {
            let (nearest, off) = if under > 0.0 { (low, under) } else { (high, over) };
            let place = nearest - off * normal;
            if off.abs() - self.solid.round < self.best && covers(corners, normal, place) {
                self.take(off.abs() - self.solid.round, place);
            }
            return;
        }
        // The plane cuts the solid. Where no side of the triangle meets it, one place of the cut tells on which side of
        // them all others are.
        let chord = [low, high];
        let axis = self.solid.heights.map(|h| self.pose.tip + h * self.pose.axis);
        for [from, to] in [chord, axis] {
            let [f, t] = [from, to].map(|p| normal.dot(p - a));
            if f * t <= 0.0 && f != t {
                let place = from + f / (f - t) * (to - from);
                if covers(corners, normal, place) {
                    self.take(self.at(place).value, place);
                }
            }
        }
    }
}

/// Whether a place in the plane of a triangle is within it.
fn covers([a, b, c]: &[DVec3; 3], normal: DVec3, p: DVec3) -> bool {
    [(a, b), (b, c), (c, a)].iter().all(|(f, t)| (**t - **f).cross(p - **f).dot(normal) >= 0.0)
}

impl Hindrance {
    /// A tree over triangles.
    ///
    /// `positions`: corners, mm; `faces`: three indices of them per triangle. A face with a corner that does not exist
    /// or is not finite bounds nothing and is left out.
    pub fn new(positions: &[DVec3], faces: &[[u32; 3]]) -> Self {
        let corner = |i: u32| positions.get(i as usize).copied().filter(|p| p.is_finite());
        let triangle = |[a, b, c]: &[u32; 3]| Some([corner(*a)?, corner(*b)?, corner(*c)?]);
        let triangles: Vec<[DVec3; 3]> = faces.iter().filter_map(triangle).collect();
        if triangles.is_empty() {
            return Self::default();
        }
        let mut order: Vec<usize> = (0..triangles.len()).collect();
        let mut nodes = vec![boxed(&triangles, &order, 0)];
        let mut open = vec![(0, 0, order.len())];
        while let Some((node, from, to)) = open.pop() {
            let part = &mut order[from..to];
            if part.len() <= LEAF {
                part.order_total();
                continue;
            }
            let half = part.len() / 2;
            split(&triangles, part, half);
            let first = nodes.len();
            nodes.push(boxed(&triangles, &order[from..from + half], from));
            nodes.push(boxed(&triangles, &order[from + half..to], from + half));
            (nodes[node].first, nodes[node].count) = (first, 0);
            open.extend([(first, from, from + half), (first + 1, from + half, to)]);
        }
        Self { nodes, triangles: order.iter().map(|&i| triangles[i]).collect() }
    }

    /// Whether there is no triangle.
    pub fn is_empty(&self) -> bool {
        self.triangles.is_empty()
    }

    /// Whether a ball around `centre` of a radius, mm, is nowhere nearer than `clearance`, mm.
    pub fn clears_ball(&self, centre: DVec3, radius: f64, clearance: f64) -> bool {
        let ball = Solid::new(AssemblyPart::Cutter, [0.0; 2], [0.0; 2], radius);
        self.nearest(&ball, Pose { tip: centre, axis: DVec3::Z }, clearance, clearance).is_none()
    }

    /// The place of the triangles with the smallest signed distance from a solid, if that is below `beyond`.
    ///
    /// Stops at the first that is below `enough`, which need not be the smallest; both mm.
    pub(crate) fn nearest(
        &self,
        solid: &Solid,
        pose: Pose,
        beyond: f64,
        enough: f64,
    ) -> Option<Near> {
        let root = self.nodes.first()?;
        let mut search = Search { solid, pose, best: beyond, place: None };
        let mut waiting = [(0.0, 0); WAITING];
        waiting[0] = (search.bound(root), 0);
        let mut count = 1;
        while count > 0 && search.best >= enough {
            count -= 1;
            let (bound, index) = waiting[count];
            if bound >= search.best {
                continue;
            }
            let node = &self.nodes[index];
            if node.count > 0 {
                for triangle in &self.triangles[node.first..node.first + node.count] {
                    search.triangle(triangle);
                }
                continue;
            }
            let [a, b] = [node.first, node.first + 1].map(|i| (search.bound(&self.nodes[i]), i));
            let (near, far) = if a.0 <= b.0 { (a, b) } else { (b, a) };
            // The nearer one last, so that it is taken next.
            for child in [far, near] {
                if child.0 < search.best && count < WAITING {
                    waiting[count] = child;
                    count += 1;
                }
            }
        }
        search.place.map(|place| Near { distance: search.best, place })
    }
}

/// A leaf around some triangles, the first of which will be at `first`.
fn boxed(triangles: &[[DVec3; 3]], part: &[usize], first: usize) -> Node {
    let corners = part.iter().flat_map(|&i| triangles[i]);
    let nothing = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    let (low, high) = corners.fold(nothing, |(low, high), p| (low.min(p), high.max(p)));
    Node { middle: 0.5 * (low + high), half: 0.5 * (high - low), first, count: part.len() }
}

/// Puts the `half` lower ones, along the direction in which their middles are widest apart, in front.
fn split(triangles: &[[DVec3; 3]], part: &mut [usize], half: usize) {
    let middle = |i: usize| triangles[i].iter().sum::<DVec3>();
    let nothing = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    let (low, high) = part.iter().fold(nothing, |(low, high), &i| {
        let m = middle(i);
        (low.min(m), high.max(m))
    });
    let axis = (high - low).max_position();
    // Equal ones go by their number: the halves are the same however they are put in order.
    part.select_nth_unstable_by(half, |&i, &j| {
        middle(i)[axis].total_cmp(&middle(j)[axis]).then(i.cmp(&j))
    });
}

#[cfg(test)]
mod tests;
