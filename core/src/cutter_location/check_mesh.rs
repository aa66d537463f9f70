//! How far a cutter must be lifted along its axis to touch no facet of the part.
//!
//! Steps: (1) a tree over the facets is built once; each node keeps a box along the mean normal and the longest
//! direction of its facets. (2) A query keeps the cutter lifted as far as the facets seen so far require. A node is
//! skipped where a plane separates its box from that cutter (see [`super::solid`]); the others are ordered by how far
//! the cutter must rise for that, highest first. On a smooth surface only nodes within about their own size of the
//! contact are opened. (3) Facets whose planes the cutter crosses are evaluated exactly (see [`super::drop`]).
//!
//! Queries do not use earlier ones. Starting from the result of a neighbouring query would save one node in twenty,
//! since the first descent ends beside the contact.

use super::drop::Profile;
use super::solid::{Block, Solid};
use crate::geometry::{DMat3, DVec3, any_perpendicular};
use crate::tool::Tool;

/// Facets per leaf. Fewer: more memory and tree steps; more: needless facet tests.
const LEAF_FACES: usize = 4;

/// Subtrees up to this size are measured facet by facet, larger ones from their children. Larger: building takes
/// longer (each doubling one more pass over all facets); smaller: queries take longer, since boxes of boxes are
/// loose.
const TIGHT_FACES: usize = 1 << 19;

/// A facet that would raise the cutter by less than this beyond the others is ignored, mm.
const NEGLIGIBLE: f64 = 1e-10;

/// A facet whose height over length is below this has no reliable normal: its error is 1e-16 over this, rad.
const SLIVER: f64 = 1e-5;

/// After this many lifts, a cutter that still touches something is lifted clear of everything above.
const MOST_ROUNDS: u32 = 64;

/// The part as an obstacle: facets of any connectivity, both sides solid.
#[derive(Clone, Debug)]
pub struct CheckMesh {
    nodes: Vec<Node>,
    /// Facets in tree order.
    facets: Vec<Facet>,
}

/// A facet of the part.
#[derive(Copy, Clone, Debug)]
struct Facet {
    corners: [DVec3; 3],
    /// Unit normal; zero for slivers.
    normal: DVec3,
}

impl Facet {
    fn new(corners: [DVec3; 3]) -> Self {
        let mut facet = Self { corners, normal: DVec3::ZERO };
        let [a, b, c] = corners;
        let longest = a.distance_squared(b).max(b.distance_squared(c)).max(c.distance_squared(a));
        let area = facet.area();
        if area.length() > SLIVER * longest {
            facet.normal = area.normalize_or_zero();
        }
        facet
    }

    /// Normal as long as twice the area.
    fn area(&self) -> DVec3 {
        let [a, b, c] = self.corners;
        (b - a).cross(c - a)
    }
}

/// A node of the tree. Facets `first..first + count` where `count > 0`; else the children are the
/// next node and node `first`.
#[derive(Copy, Clone, Debug, Default)]
struct Node {
    /// Its box, along the mean normal of the facets, the longest direction across it, and the third.
    block: Block,
    /// Half of its diagonal.
    radius: f64,
    first: u32,
    count: u32,
}

/// A facet during construction of the tree; single precision only decides on which side it goes.
#[derive(Copy, Clone)]
struct Item {
    centroid: [f32; 3],
    face: u32,
}

/// The cutter in place: one query.
struct Query {
    tip: DVec3,
    frame: [DVec3; 3],
    /// The cutter, lifted as far as is known to be necessary.
    solid: Solid,
    /// Obstacles higher above the tip are ignored, mm.
    reach: f64,
    /// Lower bound of the height of what was ignored, mm.
    lowest_ignored: f64,
    /// The facet that required the largest lift so far.
    highest: Option<u32>,
}

impl CheckMesh {
    /// An obstacle from `#V` positions, mm, and `#F` triples of indices into them.
    ///
    /// Faces that refer to a vertex that does not exist, or to one that is not finite, are left out.
    pub fn new(positions: Vec<DVec3>, faces: Vec<[u32; 3]>) -> Self {
        let corners = |f: &[u32; 3]| -> Option<[DVec3; 3]> {
            let p = f.map(|v| positions.get(v as usize).copied().filter(|p| p.is_finite()));
            Some([p[0]?, p[1]?, p[2]?])
        };
        let source: Vec<[DVec3; 3]> = faces.iter().filter_map(corners).collect();
        let mut items: Vec<Item> = source
            .iter()
            .enumerate()
            .map(|(face, t)| Item {
                centroid: ((t[0] + t[1] + t[2]) / 3.0).as_vec3().to_array(),
                face: face as u32,
            })
            .collect();
        let mut mesh = Self {
            nodes: Vec::with_capacity(source.len() / 2 + 1),
            facets: Vec::with_capacity(source.len()),
        };
        if !items.is_empty() {
            mesh.build(&source, &mut items);
        }
        mesh
    }

    /// No obstacle.
    pub fn nothing() -> Self {
        Self { nodes: Vec::new(), facets: Vec::new() }
    }

    /// Number of facets.
    pub fn face_count(&self) -> usize {
        self.facets.len()
    }

    /// The smallest distance, mm, by which a tip at `tip` must move along the unit `axis` so that the cutter touches
    /// no facet; 0 where it is clear.
    ///
    /// The cutter is its end (ball, flat or bull) under a cylinder of its radius up to `reach` mm above
    /// the tip (infinity for no limit); facets or parts of facets higher than that are ignored. The
    /// result leaves no penetration above 2e-6 mm: the checked cylinder is 1e-6 mm slimmer than
    /// the tool, so that walls along its side do not count.
    ///
    /// # Source
    /// Drop-cutter contacts with facets, edges and vertices as in Chuang, Chen, Yau, "A reverse
    /// engineering approach to generating interference-free tool paths in three-axis machining from scanned
    /// data of physical models", Int. J. Adv. Manuf. Technol. 19 (2002); pruning by concavity is ours.
    pub fn raise(&self, tool: &Tool, tip: DVec3, axis: DVec3, reach: f64) -> f64 {
        let mut query = Query::new(tool, tip, axis, reach);
        let mut raise = self.descend(&mut query, 0.0, f64::INFINITY);
        // A lifted cutter reaches higher and may meet what was ignored.
        let mut rounds = 0;
        while query.lowest_ignored < reach + raise && query.reach < reach + raise {
            rounds += 1;
            query.reach = if rounds < MOST_ROUNDS { reach + raise } else { f64::INFINITY };
            query.lowest_ignored = f64::INFINITY;
            raise = self.descend(&mut query, raise, f64::INFINITY);
        }
        raise
    }

    /// As [`Self::raise`] for a cutter of any length, with the corners of the facet that the lifted cutter touches.
    pub fn raise_onto(&self, tool: &Tool, tip: DVec3, axis: DVec3) -> (f64, Option<[DVec3; 3]>) {
        let mut query = Query::new(tool, tip, axis, f64::INFINITY);
        let raise = self.descend(&mut query, 0.0, f64::INFINITY);
        (raise, query.highest.map(|facet| self.facets[facet as usize].corners))
    }

    /// Whether [`Self::raise`] is 0; stops at the first facet that is touched.
    pub fn is_clear(&self, tool: &Tool, tip: DVec3, axis: DVec3, reach: f64) -> bool {
        self.descend(&mut Query::new(tool, tip, axis, reach), 0.0, 0.0) <= 0.0
    }

    /// The largest need above `floor`, best nodes first; or the first one found above `enough`.
    fn descend(&self, query: &mut Query, floor: f64, enough: f64) -> f64 {
        let mut best = floor;
        if self.nodes.is_empty() {
            return best;
        }
        query.stand_at(best);
        let mut open = Vec::with_capacity(64);
        open.push((f64::INFINITY, 0u32));
        while let Some((bound, index)) = open.pop() {
            let node = &self.nodes[index as usize];
            if bound <= best + NEGLIGIBLE {
                continue;
            }
            if node.count > 0 {
                let first = node.first as usize;
                let before = best;
                for (index, facet) in
                    (node.first..).zip(&self.facets[first..first + node.count as usize])
                {
                    let need = query.facet(facet, best);
                    if need > best {
                        (best, query.highest) = (need, Some(index));
                    }
                }
                if best > enough {
                    return best;
                }
                if best > before {
                    query.stand_at(best);
                }
                continue;
            }
            let [near, far] = [index + 1, node.first]
                .map(|child| (query.rise(&self.nodes[child as usize]), child));
            let [near, far] = if near.0 >= far.0 { [near, far] } else { [far, near] };
            for (rise, child) in [far, near] {
                if rise > 0.0 {
                    open.push((best + NEGLIGIBLE + rise, child));
                }
            }
        }
        best
    }

    /// Appends the subtree over `items`.
    fn build(&mut self, source: &[[DVec3; 3]], items: &mut [Item]) -> Span {
        let index = self.nodes.len();
        let start = self.facets.len();
        if items.len() <= LEAF_FACES {
            self.facets.extend(items.iter().map(|i| Facet::new(source[i.face as usize])));
            let facets = &self.facets[start..];
            let span = Span::of(index, facets);
            let count = facets.len() as u32;
            self.nodes.push(Node { first: start as u32, count, ..tight(facets, &span) });
            return span;
        }
        let axis = widest_axis(items);
        let half = items.len() / 2;
        items.select_nth_unstable_by(half, |a, b| {
            a.centroid[axis].total_cmp(&b.centroid[axis]).then(a.face.cmp(&b.face))
        });
        self.nodes.push(Node::default());
        let (low, high) = items.split_at_mut(half);
        let near = self.build(source, low);
        let far = self.build(source, high);
        let span = near.join(index, &far);
        let node = if self.facets.len() - start <= TIGHT_FACES {
            tight(&self.facets[start..], &span)
        } else {
            join(&self.nodes[near.index], &self.nodes[far.index], &span)
        };
        self.nodes[index] = Node { first: far.index as u32, ..node };
        span
    }
}

/// What a subtree returns to its parent.
struct Span {
    index: usize,
    low: DVec3,
    high: DVec3,
    /// Sum of the facets' normals, each as long as twice its area.
    area: DVec3,
}

impl Span {
    fn of(index: usize, facets: &[Facet]) -> Self {
        let points = || facets.iter().flat_map(|f| f.corners);
        Self {
            index,
            low: points().fold(DVec3::INFINITY, DVec3::min),
            high: points().fold(DVec3::NEG_INFINITY, DVec3::max),
            area: facets.iter().map(|f| f.area()).sum(),
        }
    }

    fn join(&self, index: usize, other: &Self) -> Self {
        let (low, high) = (self.low.min(other.low), self.high.max(other.high));
        Self { index, low, high, area: self.area + other.area }
    }

    fn middle(&self) -> DVec3 {
        0.5 * (self.low + self.high)
    }

    fn normal(&self) -> DVec3 {
        self.area.try_normalize().unwrap_or(DVec3::Z)
    }
}

fn widest_axis(items: &[Item]) -> usize {
    let mut low = [f32::INFINITY; 3];
    let mut high = [f32::NEG_INFINITY; 3];
    for item in items {
        for k in 0..3 {
            low[k] = low[k].min(item.centroid[k]);
            high[k] = high[k].max(item.centroid[k]);
        }
    }
    let extent = [high[0] - low[0], high[1] - low[1], high[2] - low[2]];
    if extent[0] >= extent[1] && extent[0] >= extent[2] {
        0
    } else if extent[1] >= extent[2] {
        1
    } else {
        2
    }
}

/// Box of the facets themselves.
fn tight(facets: &[Facet], span: &Span) -> Node {
    let middle = span.middle();
    let frame = frame_along(span.normal(), facets, middle);
    let turned = frame.transpose();
    let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    for p in facets.iter().flat_map(|f| &f.corners) {
        let q = turned * (*p - middle);
        (low, high) = (low.min(q), high.max(q));
    }
    Node::holding(middle, frame, low, high)
}

/// The normal and, across it, the principal directions of the corners.
fn frame_along(normal: DVec3, facets: &[Facet], middle: DVec3) -> DMat3 {
    let u = any_perpendicular(normal);
    let v = normal.cross(u);
    let (mut uu, mut uv, mut vv) = (0.0, 0.0, 0.0);
    for p in facets.iter().flat_map(|f| &f.corners) {
        let (x, y) = (u.dot(*p - middle), v.dot(*p - middle));
        uu += x * x;
        uv += x * y;
        vv += y * y;
    }
    // Larger eigenvalue of the moments less `vv`; its eigenvector is (that, uv).
    let difference = 0.5 * (uu - vv);
    let root = (difference * difference + uv * uv).sqrt();
    let major = if difference >= 0.0 {
        u * (difference + root) + v * uv
    } else {
        u * uv + v * (root - difference)
    };
    let major = major.try_normalize().unwrap_or(u);
    DMat3::from_cols(normal, major, normal.cross(major))
}

/// Box that contains those of two nodes; their facets are not visited again.
fn join(a: &Node, b: &Node, span: &Span) -> Node {
    let (middle, normal) = (span.middle(), span.normal());
    let longest = span.high - span.low;
    let across = longest - normal * longest.dot(normal);
    let major = across.try_normalize().unwrap_or(any_perpendicular(normal));
    let frame = DMat3::from_cols(normal, major, normal.cross(major));
    let turned = frame.transpose();
    let reach = |node: &Node| {
        DVec3::new(
            node.block.extent(frame.x_axis),
            node.block.extent(frame.y_axis),
            node.block.extent(frame.z_axis),
        )
    };
    let (pa, pb) = (turned * (a.block.centre - middle), turned * (b.block.centre - middle));
    let (ra, rb) = (reach(a), reach(b));
    Node::holding(middle, frame, (pa - ra).min(pb - rb), (pa + ra).max(pb + rb))
}

impl Node {
    /// A node of no facets yet, from the box `low` to `high` about `middle` in `frame`, widened by the
    /// rounding of the figures.
    fn holding(middle: DVec3, frame: DMat3, low: DVec3, high: DVec3) -> Self {
        let centre = middle + frame * (0.5 * (low + high));
        let half = 0.5 * (high - low);
        let slack = 1e-14 * (centre.abs().max_element() + half.length());
        let half = half + DVec3::splat(slack);
        Self { block: Block { centre, frame, half }, radius: half.length(), first: 0, count: 0 }
    }
}

impl Query {
    fn new(tool: &Tool, tip: DVec3, axis: DVec3, reach: f64) -> Self {
        let side = any_perpendicular(axis);
        let frame = [side, axis.cross(side), axis];
        let solid = Solid { tip, axis, profile: Profile::new(tool) };
        Self { tip, frame, solid, reach, lowest_ignored: f64::INFINITY, highest: None }
    }

    fn to_frame(&self, p: DVec3) -> DVec3 {
        let d = p - self.tip;
        DVec3::new(d.dot(self.frame[0]), d.dot(self.frame[1]), d.dot(self.frame[2]))
    }

    /// Puts the cutter where it is lifted by `best`.
    fn stand_at(&mut self, best: f64) {
        self.solid.tip = self.tip + self.frame[2] * (best + NEGLIGIBLE);
    }

    /// Upper bound of how much further a node can raise the cutter; not positive where it cannot.
    fn rise(&mut self, node: &Node) -> f64 {
        let d = node.block.centre - self.tip;
        let height = d.dot(self.solid.axis);
        let outside = self.solid.profile.radius + node.radius;
        if d.length_squared() - height * height >= outside * outside {
            return 0.0;
        }
        if height + node.radius > self.reach {
            let lowest = height - node.block.extent(self.solid.axis);
            if lowest > self.reach {
                self.lowest_ignored = self.lowest_ignored.min(lowest);
                return 0.0;
            }
        }
        self.solid.rise(&node.block)
    }

    /// The larger of `floor` and the need of the part of a facet that is not above reach.
    fn facet(&mut self, facet: &Facet, floor: f64) -> f64 {
        if self.solid.above_plane(facet.corners[0], facet.normal) {
            return floor;
        }
        let t = facet.corners.map(|p| self.to_frame(p));
        let top = t[0].z.max(t[1].z).max(t[2].z);
        if top <= self.reach {
            return self.solid.profile.triangle(t, floor);
        }
        let bottom = t[0].z.min(t[1].z).min(t[2].z);
        self.lowest_ignored = self.lowest_ignored.min(bottom.max(self.reach));
        clip_below(t, self.reach)
            .into_iter()
            .flatten()
            .fold(floor, |best, piece| self.solid.profile.triangle(piece, best))
    }
}

/// The part of a triangle with `z <= height`, as up to two triangles.
fn clip_below(t: [DVec3; 3], height: f64) -> [Option<[DVec3; 3]>; 2] {
    let mut kept = [DVec3::ZERO; 4];
    let mut count = 0;
    for i in 0..3 {
        let (a, b) = (t[i], t[(i + 1) % 3]);
        if a.z <= height {
            kept[count] = a;
            count += 1;
        }
        if (a.z <= height) != (b.z <= height) {
            let mut cut = a + (b - a) * ((height - a.z) / (b.z - a.z));
            cut.z = height;
            kept[count] = cut;
            count += 1;
        }
    }
    match count {
        3 => [Some([kept[0], kept[1], kept[2]]), None],
        4 => [Some([kept[0], kept[1], kept[2]]), Some([kept[0], kept[2], kept[3]])],
        _ => [None, None],
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cutter_location::tip;
    use crate::geometry::math::{cos, sin};
    use crate::mesh::{self, MeshFormat};

    fn tools() -> [Tool; 4] {
        [(5.0, 5.0), (5.0, 0.0), (5.0, 1.0), (3.0, 2.5)].map(|(r, c)| Tool::new(r, c).unwrap())
    }

    /// A reproducible sequence in `0..1`.
    struct Sequence(u64);

    impl Sequence {
        fn next(&mut self) -> f64 {
            self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (self.0 >> 11) as f64 / (1u64 << 53) as f64
        }
        fn vector(&mut self, size: f64) -> DVec3 {
            DVec3::new(self.next() - 0.5, self.next() - 0.5, self.next() - 0.5) * (2.0 * size)
        }
    }

    fn grid(n: u32, size: f64, height: impl Fn(f64, f64) -> f64) -> CheckMesh {
        let at = |i: u32| (f64::from(i) / f64::from(n) - 0.5) * size;
        let positions = (0..=n)
            .flat_map(|j| (0..=n).map(move |i| (i, j)))
            .map(|(i, j)| DVec3::new(at(i), at(j), height(at(i), at(j))))
            .collect();
        let faces = (0..n)
            .flat_map(|j| (0..n).map(move |i| j * (n + 1) + i))
            .flat_map(|v| [[v, v + 1, v + n + 2], [v, v + n + 2, v + n + 1]])
            .collect();
        CheckMesh::new(positions, faces)
    }

    /// Need at a point, written from the solid of revolution and not from the planner's profile.
    fn need(tool: &Tool, tip: DVec3, axis: DVec3, p: DVec3) -> f64 {
        let h = (p - tip).dot(axis);
        let rho = ((p - tip) - axis * h).length();
        let (r, c) = (tool.radius(), tool.corner_radius());
        if rho >= r {
            return f64::NEG_INFINITY;
        }
        let over = rho - (r - c);
        if over <= 0.0 { h } else { h - c + (c * c - over * over).sqrt() }
    }

    fn sampled_raise(tool: &Tool, tip: DVec3, axis: DVec3, t: [DVec3; 3], n: u32) -> f64 {
        let mut best = 0.0f64;
        for i in 0..=n {
            for j in 0..=n - i {
                let (u, v) = (f64::from(i) / f64::from(n), f64::from(j) / f64::from(n));
                best =
                    best.max(need(tool, tip, axis, t[0] + (t[1] - t[0]) * u + (t[2] - t[0]) * v));
            }
        }
        best
    }

    #[test]
    fn one_triangle_against_dense_samples() {
        let mut s = Sequence(1);
        for round in 0..600 {
            let size = if round % 3 == 0 { 1.0 } else { 8.0 };
            let offset = s.vector(3.0);
            let t = [0; 3].map(|_| offset + s.vector(size));
            let axis = s.vector(1.0).normalize();
            let mesh = CheckMesh::new(t.to_vec(), vec![[0, 1, 2]]);
            for tool in tools() {
                let tip = s.vector(2.0);
                let raise = mesh.raise(&tool, tip, axis, f64::INFINITY);
                let sampled = sampled_raise(&tool, tip, axis, t, 150);
                assert!(raise >= sampled - 1e-4, "{raise} below {sampled}");
                let left = sampled_raise(&tool, tip + axis * (raise + 1e-4), axis, t, 150);
                assert!(left == 0.0, "still needs {left} after {raise}");
                // Steep pieces near the rim are where samples miss most.
                assert!(raise <= sampled + 0.5, "{raise} far above {sampled}");
            }
        }
    }

    #[test]
    fn the_highest_point_is_found_by_climbing() {
        // Ternary search inside ternary search: need is concave over a triangle.
        let mut s = Sequence(7);
        for _ in 0..200 {
            let t = [0; 3].map(|_| s.vector(3.0));
            let axis = s.vector(1.0).normalize();
            let mesh = CheckMesh::new(t.to_vec(), vec![[0, 1, 2]]);
            for tool in [Tool::new(9.0, 9.0).unwrap(), Tool::new(9.0, 3.0).unwrap()] {
                let tip = s.vector(1.0) - axis * 2.0;
                let at = |u: f64, v: f64| {
                    need(&tool, tip, axis, t[0] + (t[1] - t[0]) * u + (t[2] - t[0]) * v)
                };
                let climb = |f: &dyn Fn(f64) -> f64, top: f64| {
                    let (mut a, mut b) = (0.0, top);
                    for _ in 0..90 {
                        let (p, q) = (a + (b - a) / 3.0, b - (b - a) / 3.0);
                        if f(p) < f(q) { a = p } else { b = q }
                    }
                    f(0.5 * (a + b)).max(f(0.0)).max(f(top))
                };
                let expected = climb(&|u| climb(&|v| at(u, v), 1.0 - u), 1.0).max(0.0);
                let raise = mesh.raise(&tool, tip, axis, f64::INFINITY);
                assert!((raise - expected).abs() < 3e-6, "{raise} is not {expected}");
            }
        }
    }

    #[test]
    fn an_inclined_plane_is_touched_where_the_formula_says() {
        let slope = 0.4;
        let mesh = grid(40, 60.0, |x, _| slope * x);
        let normal = DVec3::new(-slope, 0.0, 1.0).normalize();
        for tool in tools() {
            let contact = DVec3::new(1.37, -0.21, slope * 1.37);
            let located = tip(&tool, contact, normal, DVec3::Z, 0.0);
            assert!(mesh.raise(&tool, located, DVec3::Z, f64::INFINITY) < 1e-9);
            let raise = mesh.raise(&tool, located - DVec3::Z * 0.3, DVec3::Z, f64::INFINITY);
            assert!((raise - 0.3).abs() < 2e-6, "{raise}");
            let tilted = DVec3::new(0.3, 0.1, 1.0).normalize();
            let located = tip(&tool, contact, normal, tilted, 0.0);
            let raise = mesh.raise(&tool, located - tilted * 0.3, tilted, f64::INFINITY);
            assert!((raise - 0.3).abs() < 2e-6, "{raise}");
        }
    }

    #[test]
    fn a_ball_in_a_narrower_bowl_hangs_on_its_rim() {
        // Bowl of radius 4 down from z = 0 as rings of a sphere; ball of radius 5 rests on the rim.
        let (n, rings) = (256u32, 40u32);
        let mut positions = Vec::new();
        for k in 0..=rings {
            let polar = std::f64::consts::FRAC_PI_2 * f64::from(k) / f64::from(rings);
            for i in 0..n {
                let turn = std::f64::consts::TAU * f64::from(i) / f64::from(n);
                let r = 4.0 * cos(polar);
                positions.push(DVec3::new(r * cos(turn), r * sin(turn), -4.0 * sin(polar)));
            }
        }
        let mut faces = Vec::new();
        for k in 0..rings {
            for i in 0..n {
                let (a, b) = (k * n + i, k * n + (i + 1) % n);
                faces.extend([[a, b, b + n], [a, b + n, a + n]]);
            }
        }
        let mesh = CheckMesh::new(positions, faces);
        let ball = Tool::new(5.0, 5.0).unwrap();
        let raise = mesh.raise(&ball, DVec3::new(0.0, 0.0, -4.0), DVec3::Z, f64::INFINITY);
        // It touches the middles of the rim's chords.
        let rim = 4.0 * cos(std::f64::consts::PI / f64::from(n));
        let expected = 4.0 - (5.0 - (25.0 - rim * rim).sqrt());
        assert!((raise - expected).abs() < 3e-6, "{raise} is not {expected}");
    }

    #[test]
    fn a_step_lifts_a_flat_end_at_once_and_a_ball_gradually() {
        let floor = [(-50.0, -50.0), (0.0, -50.0), (0.0, 50.0), (-50.0, 50.0)];
        let mut positions: Vec<DVec3> = floor.map(|(x, y)| DVec3::new(x, y, 0.0)).to_vec();
        positions.extend(floor.map(|(x, y)| DVec3::new(-x, y, 2.0)));
        let faces = vec![[0, 1, 2], [0, 2, 3], [4, 6, 5], [4, 7, 6], [1, 5, 6], [1, 6, 2]];
        let mesh = CheckMesh::new(positions, faces);
        let [ball, flat, bull, _] = tools();
        let raise = |tool: &Tool, x: f64| {
            mesh.raise(tool, DVec3::new(x, 1.0, 0.0), DVec3::Z, f64::INFINITY)
        };
        assert_eq!(raise(&flat, -5.0), 0.0);
        assert_eq!(raise(&bull, -5.0), 0.0);
        assert!((raise(&flat, -4.99) - 2.0).abs() < 1e-12);
        assert!((raise(&bull, -4.5) - (2.0 - (1.0 - 0.75f64.sqrt()))).abs() < 2e-6);
        assert!((raise(&ball, -4.5) - 0.0f64.max(2.0 - (5.0 - 4.75f64.sqrt()))).abs() < 2e-6);
        assert!((raise(&ball, -3.0) - (2.0 - 1.0)).abs() < 2e-6);
    }

    /// The raise without tree or planes.
    fn every_facet(mesh: &CheckMesh, tool: &Tool, tip: DVec3, axis: DVec3) -> f64 {
        let query = Query::new(tool, tip, axis, f64::INFINITY);
        let need =
            |f: &Facet| query.solid.profile.triangle(f.corners.map(|p| query.to_frame(p)), 0.0);
        mesh.facets.iter().map(need).fold(0.0, f64::max)
    }

    #[test]
    fn the_tree_agrees_with_every_facet_of_real_parts() {
        let Some(folder) = crate::shared_data::shared_data("mesh") else { return };
        let parts = [
            ("hood_panel_120k.ply", MeshFormat::Ply),
            ("aorta.stl", MeshFormat::Stl),
            ("mountain.ply", MeshFormat::Ply),
            ("plane_26holes.obj", MeshFormat::Obj),
            ("mask_face.ply", MeshFormat::Ply),
        ];
        for (name, format) in parts {
            let bytes = std::fs::read(folder.join(name)).unwrap();
            let soup = mesh::read(&bytes, format).unwrap();
            let low = soup.positions.iter().copied().fold(DVec3::INFINITY, DVec3::min);
            let high = soup.positions.iter().copied().fold(DVec3::NEG_INFINITY, DVec3::max);
            let scale = 60.0 / (high - low).max_element();
            let positions: Vec<_> = soup.positions.iter().map(|&p| (p - low) * scale).collect();
            let part = CheckMesh::new(positions.clone(), soup.faces);
            let mut s = Sequence(5);
            let mut lifted = 0;
            for _ in 0..8 {
                for tool in tools() {
                    let on = positions[(s.next() * positions.len() as f64) as usize];
                    let axis = (DVec3::Z * 1.5 + s.vector(1.0)).normalize();
                    let tip = on + s.vector(1.0);
                    let raise = part.raise(&tool, tip, axis, f64::INFINITY);
                    let all = every_facet(&part, &tool, tip, axis);
                    assert!((raise - all).abs() <= 2.0 * NEGLIGIBLE, "{name}: {raise} not {all}");
                    assert_eq!(raise == 0.0, part.is_clear(&tool, tip, axis, f64::INFINITY));
                    let clear = part.raise(&tool, tip + axis * (raise + 1e-9), axis, f64::INFINITY);
                    assert_eq!(clear, 0.0, "{name}: lifted by {raise}");
                    lifted += usize::from(raise > 0.0);
                }
            }
            assert!(lifted > 16, "{name}: only {lifted} of 32 touch");
        }
    }

    #[test]
    fn the_tree_agrees_with_every_facet_looked_at() {
        let height = |x: f64, y: f64| sin(0.9 * x) * cos(0.7 * y) + 0.3 * sin(3.1 * x + y);
        let mesh = grid(60, 24.0, height);
        let mut s = Sequence(3);
        for _ in 0..300 {
            for tool in tools() {
                let tip = s.vector(7.0) * DVec3::new(1.0, 1.0, 0.2);
                let axis = (DVec3::Z * 1.5 + s.vector(0.7)).normalize();
                let raise = mesh.raise(&tool, tip, axis, f64::INFINITY);
                let all = every_facet(&mesh, &tool, tip, axis);
                assert!((raise - all).abs() <= 2.0 * NEGLIGIBLE, "{raise} is not {all}");
                assert_eq!(raise == 0.0, mesh.is_clear(&tool, tip, axis, f64::INFINITY));
            }
        }
    }

    #[test]
    fn what_lies_beyond_reach_is_ignored_until_the_cutter_climbs_to_it() {
        let plate =
            |z: f64| [(-20.0, -20.0), (20.0, -20.0), (0.0, 30.0)].map(|(x, y)| DVec3::new(x, y, z));
        let mut positions = plate(0.5).to_vec();
        positions.extend(plate(30.0));
        let faces = vec![[0, 1, 2], [3, 4, 5]];
        let roofed = CheckMesh::new(positions.clone(), faces);
        for tool in tools() {
            let raise = |reach| roofed.raise(&tool, DVec3::ZERO, DVec3::Z, reach);
            assert!((raise(20.0) - 0.5).abs() < 1e-9);
            assert!((raise(29.6) - 30.0).abs() < 1e-9, "lifted by 0.5 it meets the roof");
            assert!((raise(f64::INFINITY) - 30.0).abs() < 1e-9);
        }
    }

    #[test]
    fn bad_faces_and_an_empty_mesh_raise_nothing() {
        let tool = tools()[0];
        let mesh = CheckMesh::new(vec![DVec3::NAN; 3], vec![[0, 1, 2], [0, 1, 9]]);
        assert_eq!(mesh.face_count(), 0);
        assert_eq!(mesh.raise(&tool, DVec3::ZERO, DVec3::Z, f64::INFINITY), 0.0);
    }
}
