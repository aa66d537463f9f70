//! The remaining stock: the region minus everything swept so far.
//!
//! A quadtree over the plane. A leaf is *done* when it lies outside of the region or inside one capsule; otherwise it
//! lists the capsules and the edges of the region that touch it, so every answer is exact for the polyline path: the
//! tree only selects the few shapes to test. Changes are recorded, so that a trial move can be undone. Squares of what
//! is done serve again for others, so that the tree is as large as the front of what is swept.

use super::arc::Engagement;
use super::capsule::{Capsule, circle_segment};
use crate::geometry::{DVec2, OrderBy};
use crate::outline::Outline;

/// A leaf that a capsule touches is split down to this fraction of the cutter radius. Larger: longer lists in each
/// leaf; smaller: more leaves along the front.
const LEAF_SIZE: f64 = 1.0 / 6.0;
/// A leaf with more capsules than this is split further…
const CROWDED: usize = 16;
/// …down to this fraction of the cutter radius.
const FINEST: f64 = 1.0 / 200.0;
/// A leaf with more edges than this is split until it is this fraction of the region's size.
const MANY_SIDES: usize = 6;
const FINEST_SIDES: f64 = 1e-5;

#[derive(Clone, Debug)]
enum Node {
    /// Four children from this index on.
    Inner(u32),
    /// Nothing left to cut here.
    Done,
    Leaf(Leaf),
}

#[derive(Clone, Debug, Default)]
struct Leaf {
    capsules: Vec<u32>,
    sides: Vec<u32>,
    /// Whether the centre of the leaf lies in the region.
    center_inside: bool,
}

#[derive(Clone, Debug)]
enum Undo {
    Listed(u32),
    Replaced(u32, Node),
}

/// A square of the quadtree.
#[derive(Copy, Clone)]
struct Square {
    center: DVec2,
    half: f64,
}

impl Square {
    fn child(self, i: usize) -> Self {
        let half = 0.5 * self.half;
        let sign =
            DVec2::new(if i & 1 == 0 { -1.0 } else { 1.0 }, if i & 2 == 0 { -1.0 } else { 1.0 });
        Self { center: self.center + sign * half, half }
    }

    fn holds(self, p: DVec2) -> bool {
        let d = p - self.center;
        -self.half <= d.x && d.x < self.half && -self.half <= d.y && d.y < self.half
    }

    fn corners(self) -> [DVec2; 4] {
        let h = self.half;
        [(-h, -h), (h, -h), (h, h), (-h, h)].map(|(x, y)| self.center + DVec2::new(x, y))
    }

    /// Whether the segment meets the closed square (separating axes).
    fn meets_segment(self, [a, b]: [DVec2; 2]) -> bool {
        let (middle, half) = ((a + b) * 0.5 - self.center, (b - a) * 0.5);
        let reach = half.abs() + DVec2::splat(self.half);
        middle.x.abs() <= reach.x
            && middle.y.abs() <= reach.y
            && half.perp_dot(middle).abs() <= self.half * (half.x.abs() + half.y.abs())
    }

    /// Squared distances from `p` to the nearest and to the farthest point of the square.
    fn distance_squared(self, p: DVec2) -> (f64, f64) {
        let d = (p - self.center).abs();
        let near = (d - DVec2::splat(self.half)).max(DVec2::ZERO);
        (near.length_squared(), (d + DVec2::splat(self.half)).length_squared())
    }
}

/// A saved state; see [`Stock::checkpoint`].
#[derive(Debug)]
pub struct Checkpoint {
    journal: usize,
    capsules: usize,
    nodes: usize,
}

/// The stock in the flat plane: region minus swept capsules.
#[derive(Clone, Debug)]
pub struct Stock {
    nodes: Vec<Node>,
    /// The first of every four nodes that are no longer part of the tree.
    free: Vec<u32>,
    root: (DVec2, f64),
    capsules: Vec<Capsule>,
    sides: Vec<[DVec2; 2]>,
    journal: Vec<Undo>,
    journalling: bool,
}

impl Stock {
    /// The uncut region.
    pub fn new(region: &Outline) -> Self {
        let (low, high) = region.bounds();
        // Off-centre and oversize by odd factors, so that square centres avoid round coordinates.
        let half = 0.5 * (high - low).max_element() * 1.071_324_9;
        let center = (low + high) * 0.5 + DVec2::new(0.013_131_7, 0.009_717_3) * half;
        let sides: Vec<_> = region.sides().collect();
        let outside = center - DVec2::new(2.7, 1.3) * half;
        let inside = crossings_between(outside, center, &sides, 0..sides.len() as u32) % 2 == 1;
        let leaf = Leaf {
            capsules: Vec::new(),
            sides: (0..sides.len() as u32).collect(),
            center_inside: inside,
        };
        let mut stock = Self {
            nodes: vec![Node::Leaf(leaf)],
            free: Vec::new(),
            root: (center, half),
            capsules: Vec::new(),
            sides,
            journal: Vec::new(),
            journalling: false,
        };
        stock.split_sides(0, stock.root_square());
        stock
    }

    fn root_square(&self) -> Square {
        Square { center: self.root.0, half: self.root.1 }
    }

    fn split_sides(&mut self, node: u32, square: Square) {
        let Node::Leaf(leaf) = &self.nodes[node as usize] else { return };
        if leaf.sides.len() <= MANY_SIDES || square.half < self.root.1 * FINEST_SIDES {
            return;
        }
        let first = self.split(node, square);
        for i in 0..4 {
            self.split_sides(first + i, square.child(i as usize));
        }
    }

    /// Marks a state that [`Self::rollback`] returns to. Checkpoints do not nest.
    pub fn checkpoint(&mut self) -> Checkpoint {
        self.commit();
        self.journalling = true;
        Checkpoint { journal: 0, capsules: self.capsules.len(), nodes: self.nodes.len() }
    }

    /// Undoes everything swept since the checkpoint.
    pub fn rollback(&mut self, to: &Checkpoint) {
        while self.journal.len() > to.journal {
            match self.journal.pop() {
                Some(Undo::Listed(node)) => {
                    if let Node::Leaf(leaf) = &mut self.nodes[node as usize] {
                        leaf.capsules.pop();
                    }
                }
                Some(Undo::Replaced(node, old)) => {
                    let undone = core::mem::replace(&mut self.nodes[node as usize], old);
                    if let (Node::Inner(first), Node::Leaf(_)) =
                        (undone, &self.nodes[node as usize])
                        && (first as usize) < to.nodes
                    {
                        self.release(first);
                    }
                }
                None => break,
            }
        }
        self.capsules.truncate(to.capsules);
        self.nodes.truncate(to.nodes);
    }

    /// Keeps what was swept since the checkpoint.
    pub fn commit(&mut self) {
        for undo in core::mem::take(&mut self.journal) {
            // What replaced inner nodes is done.
            if let Undo::Replaced(_, Node::Inner(first)) = undo {
                self.release(first);
            }
        }
        self.journalling = false;
    }

    /// Takes four nodes, and all below them, from the tree.
    fn release(&mut self, first: u32) {
        for node in first..first + 4 {
            let old = core::mem::replace(&mut self.nodes[node as usize], Node::Done);
            if let Node::Inner(below) = old {
                self.release(below);
            }
        }
        self.free.push(first);
    }

    /// Removes a capsule from the stock.
    pub fn sweep(&mut self, capsule: Capsule) {
        let id = self.capsules.len() as u32;
        self.capsules.push(capsule);
        self.sweep_node(0, self.root_square(), id, &capsule);
    }

    fn replace(&mut self, node: u32, new: Node) {
        let old = core::mem::replace(&mut self.nodes[node as usize], new);
        match old {
            _ if self.journalling => self.journal.push(Undo::Replaced(node, old)),
            Node::Inner(first) => self.release(first),
            _ => {}
        }
    }

    fn sweep_node(&mut self, node: u32, square: Square, id: u32, capsule: &Capsule) {
        if matches!(self.nodes[node as usize], Node::Done) {
            return;
        }
        let distance = capsule.signed_distance(square.center);
        let diagonal = core::f64::consts::SQRT_2 * square.half;
        if distance >= diagonal {
            return;
        }
        if distance <= -diagonal || square.corners().iter().all(|&c| capsule.contains(c)) {
            self.replace(node, Node::Done);
            return;
        }
        let radius = capsule.radius();
        if let Node::Leaf(leaf) = &mut self.nodes[node as usize] {
            let crowded = leaf.capsules.len() >= CROWDED && 2.0 * square.half > FINEST * radius;
            if 2.0 * square.half <= LEAF_SIZE * radius && !crowded {
                leaf.capsules.push(id);
                if self.journalling {
                    self.journal.push(Undo::Listed(node));
                }
                return;
            }
            self.split(node, square);
        }
        if let Node::Inner(first) = self.nodes[node as usize] {
            for i in 0..4 {
                self.sweep_node(first + i, square.child(i as usize), id, capsule);
            }
            let done = |n: &Node| matches!(n, Node::Done);
            if self.nodes[first as usize..first as usize + 4].iter().all(done) {
                self.replace(node, Node::Done);
            }
        }
    }

    /// Replaces a leaf by four and returns the index of the first.
    fn split(&mut self, node: u32, square: Square) -> u32 {
        let first = self.free.pop().unwrap_or_else(|| {
            let end = self.nodes.len();
            self.nodes.resize_with(end + 4, || Node::Done);
            end as u32
        });
        let old = core::mem::replace(&mut self.nodes[node as usize], Node::Inner(first));
        if let Node::Leaf(parent) = &old {
            for i in 0..4 {
                let child = self.child_of(parent, square, square.child(i));
                self.nodes[first as usize + i] = child;
            }
        }
        if self.journalling {
            self.journal.push(Undo::Replaced(node, old));
        }
        first
    }

    fn child_of(&self, parent: &Leaf, square: Square, child: Square) -> Node {
        let crossed = crossings_between(
            square.center,
            child.center,
            &self.sides,
            parent.sides.iter().copied(),
        );
        let center_inside = parent.center_inside ^ (crossed % 2 == 1);
        let sides: Vec<u32> = parent
            .sides
            .iter()
            .copied()
            .filter(|&s| child.meets_segment(self.sides[s as usize]))
            .collect();
        if sides.is_empty() && !center_inside {
            return Node::Done;
        }
        let diagonal = core::f64::consts::SQRT_2 * child.half;
        let mut capsules = Vec::new();
        for &c in &parent.capsules {
            let capsule = &self.capsules[c as usize];
            let distance = capsule.signed_distance(child.center);
            if distance <= -diagonal || child.corners().iter().all(|&p| capsule.contains(p)) {
                return Node::Done;
            }
            if distance < diagonal {
                capsules.push(c);
            }
        }
        Node::Leaf(Leaf { capsules, sides, center_inside })
    }

    /// Engagement of the cutter disc moving in the unit direction `feed`.
    ///
    /// The leading half circle is described by `s = sin(theta)`, theta from the feed direction, so
    /// that the feed component normal to the cutter integrates to a difference of `s`.
    pub fn engagement(&self, center: DVec2, radius: f64, feed: DVec2) -> Engagement {
        let mut query =
            Query { center, radius, feed, cuts: Vec::new(), total: Engagement::default() };
        self.engage_node(0, self.root_square(), &mut query);
        query.total
    }

    fn engage_node(&self, node: u32, square: Square, query: &mut Query) {
        let node = &self.nodes[node as usize];
        if matches!(node, Node::Done) {
            return;
        }
        let (near, far) = square.distance_squared(query.center);
        let square_radius = query.radius * query.radius;
        let ahead = (square.center - query.center).dot(query.feed)
            + square.half * (query.feed.x.abs() + query.feed.y.abs());
        if near > square_radius || far < square_radius || ahead < 0.0 {
            return;
        }
        match node {
            Node::Inner(first) => {
                for i in 0..4 {
                    self.engage_node(first + i, square.child(i as usize), query);
                }
            }
            Node::Leaf(leaf) => self.engage_leaf(leaf, square, query),
            Node::Done => {}
        }
    }

    fn engage_leaf(&self, leaf: &Leaf, square: Square, query: &mut Query) {
        let (center, radius) = (query.center, query.radius);
        query.cuts.clear();
        query.cuts.extend([-1.0, 1.0]);
        let corners = square.corners();
        for i in 0..4 {
            circle_segment(center, radius, corners[i], corners[(i + 1) % 4], |p| query.cut(p));
        }
        for &side in &leaf.sides {
            let [a, b] = self.sides[side as usize];
            circle_segment(center, radius, a, b, |p| query.cut(p));
        }
        for &c in &leaf.capsules {
            self.capsules[c as usize].crossings(center, radius, |p| {
                if square.holds(p) {
                    query.cut(p);
                }
            });
        }
        query.cuts.order_total_by(f64::total_cmp);
        for i in 1..query.cuts.len() {
            let (from, to) = (query.cuts[i - 1], query.cuts[i]);
            if to > from {
                let middle = query.between(from, to);
                if square.holds(middle) && self.leaf_has_stock(leaf, square, middle) {
                    query.total.add(from, to);
                }
            }
        }
    }

    fn leaf_has_stock(&self, leaf: &Leaf, square: Square, p: DVec2) -> bool {
        if leaf.capsules.iter().rev().any(|&c| self.capsules[c as usize].contains(p)) {
            return false;
        }
        let crossed = crossings_between(square.center, p, &self.sides, leaf.sides.iter().copied());
        leaf.center_inside ^ (crossed % 2 == 1)
    }

    /// Whether there is stock at `p`.
    pub fn has_stock(&self, p: DVec2) -> bool {
        let (mut node, mut square) = (0u32, self.root_square());
        if !square.holds(p) {
            return false;
        }
        loop {
            match &self.nodes[node as usize] {
                Node::Done => return false,
                Node::Leaf(leaf) => return self.leaf_has_stock(leaf, square, p),
                Node::Inner(first) => {
                    let right = u32::from(p.x >= square.center.x);
                    let upper = u32::from(p.y >= square.center.y);
                    let child = right + 2 * upper;
                    (node, square) = (first + child, square.child(child as usize));
                }
            }
        }
    }

    /// Number of squares that take memory, and of those in the tree.
    #[cfg(test)]
    pub fn size(&self) -> (usize, usize) {
        (self.nodes.len(), self.nodes.len() - 4 * self.free.len())
    }

    /// Calls `visit` with points that still have stock and the flat area that each represents.
    ///
    /// Leaves are sampled on a grid of `per_side²` points at most `spacing` apart, so areas are accurate to a few of
    /// those cells.
    #[cfg(test)]
    pub fn remaining(&self, spacing: f64, mut visit: impl FnMut(DVec2, f64)) {
        self.remaining_node(0, self.root_square(), spacing, &mut visit);
    }

    #[cfg(test)]
    fn remaining_node(
        &self,
        node: u32,
        square: Square,
        spacing: f64,
        visit: &mut impl FnMut(DVec2, f64),
    ) {
        match &self.nodes[node as usize] {
            Node::Done => {}
            Node::Inner(first) => {
                for i in 0..4 {
                    self.remaining_node(first + i, square.child(i as usize), spacing, visit);
                }
            }
            Node::Leaf(leaf) => {
                let n = ((2.0 * square.half / spacing).ceil() as usize).clamp(2, 4096);
                let step = 2.0 * square.half / n as f64;
                let low = square.center - DVec2::splat(square.half - 0.5 * step);
                for i in 0..n {
                    for j in 0..n {
                        let p = low + DVec2::new(i as f64, j as f64) * step;
                        if self.leaf_has_stock(leaf, square, p) {
                            visit(p, step * step);
                        }
                    }
                }
            }
        }
    }
}

/// One engagement query and its intermediate result.
struct Query {
    center: DVec2,
    radius: f64,
    feed: DVec2,
    cuts: Vec<f64>,
    total: Engagement,
}

impl Query {
    /// Splits the leading half circle at `p` if `p` is on it.
    fn cut(&mut self, p: DVec2) {
        let offset = p - self.center;
        if offset.dot(self.feed) > 0.0 {
            self.cuts.push((self.feed.perp_dot(offset) / self.radius).clamp(-1.0, 1.0));
        }
    }

    /// The point of the leading half circle midway (in angle) between two sines.
    fn between(&self, from: f64, to: f64) -> DVec2 {
        let cosine = |s: f64| (1.0 - s * s).max(0.0).sqrt();
        let direction = DVec2::new(cosine(from) + cosine(to), from + to).normalize_or_zero();
        let direction = if from == -1.0 && to == 1.0 { DVec2::X } else { direction };
        self.center + (self.feed * direction.x + self.feed.perp() * direction.y) * self.radius
    }
}

/// Number of the edges that the segment from `p` to `q` crosses.
fn crossings_between(
    p: DVec2,
    q: DVec2,
    sides: &[[DVec2; 2]],
    which: impl Iterator<Item = u32>,
) -> usize {
    let along = q - p;
    which
        .filter(|&i| {
            let [a, b] = sides[i as usize];
            let above = |v: DVec2| along.perp_dot(v - p) >= 0.0;
            let left = |v: DVec2| (b - a).perp_dot(v - a) >= 0.0;
            above(a) != above(b) && left(p) != left(q)
        })
        .count()
}
