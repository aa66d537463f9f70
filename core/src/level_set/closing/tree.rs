//! A tree of bounding boxes over flat segments, queried in the strip metric at the query point.

use crate::geometry::DVec2;
use crate::level_set::strip_metric::FlatMetric;

/// Segments in one leaf: more make a query slower, fewer make the tree larger.
const LEAF: usize = 4;
/// Boxes that wait during a search: one per level, and halving four thousand million segments takes 32 levels.
const WAITING: usize = 64;

/// Segments, found by distance. A point is a segment of length zero.
pub struct Tree {
    segments: Vec<[DVec2; 2]>,
    /// Index in the list that was given, for every segment.
    ids: Vec<u32>,
    nodes: Vec<Node>,
}

/// A box around segments; its first child follows it.
#[derive(Copy, Clone)]
struct Node {
    low: DVec2,
    high: DVec2,
    /// Second child of an inner node; where the segments of a leaf begin.
    second_or_first: u32,
    /// Segments of a leaf; 0 for an inner node.
    count: u32,
}

impl Node {
    /// A lower bound of the distance from `p`, flat mm.
    fn distance(&self, p: DVec2) -> f64 {
        (self.low - p).max(p - self.high).max(DVec2::ZERO).length()
    }
}

/// Boxes still to be visited and their distances, kept off the heap because searches are frequent.
struct Waiting {
    boxes: [(f64, usize); WAITING],
    count: usize,
}

impl Waiting {
    /// The root waits.
    fn new() -> Self {
        Self { boxes: [(0.0, 0); WAITING], count: 1 }
    }

    fn push(&mut self, item: (f64, usize)) {
        self.boxes[self.count] = item;
        self.count += 1;
    }

    fn pop(&mut self) -> Option<(f64, usize)> {
        self.count = self.count.checked_sub(1)?;
        Some(self.boxes[self.count])
    }
}

/// A segment found.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Hit {
    /// Index of the segment in the list that was given.
    pub id: u32,
    /// Its index in the tree.
    pub slot: u32,
    /// Distance, passes.
    pub distance: f64,
    /// Place on the segment: 0 start, 1 end.
    pub t: f64,
}

impl Tree {
    /// A tree over `segments`.
    pub fn new(segments: &[[DVec2; 2]]) -> Self {
        let mut keyed: Vec<(DVec2, u32)> =
            segments.iter().enumerate().map(|(i, [a, b])| (*a + *b, i as u32)).collect();
        let mut tree = Self { segments: Vec::new(), ids: Vec::new(), nodes: Vec::new() };
        if !keyed.is_empty() {
            tree.build(segments, &mut keyed, 0);
        }
        tree.ids = keyed.into_iter().map(|(_, id)| id).collect();
        tree.segments = tree.ids.iter().map(|&id| segments[id as usize]).collect();
        tree
    }

    /// A tree over the segments of open polylines.
    pub fn of_polylines(lines: &[Vec<DVec2>]) -> Self {
        let segments: Vec<[DVec2; 2]> =
            lines.iter().flat_map(|line| line.windows(2).map(|w| [w[0], w[1]])).collect();
        Self::new(&segments)
    }

    fn build(&mut self, all: &[[DVec2; 2]], keyed: &mut [(DVec2, u32)], first: usize) {
        let (mut low, mut high) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
        for p in keyed.iter().flat_map(|(_, id)| all[*id as usize]) {
            (low, high) = (low.min(p), high.max(p));
        }
        let node = self.nodes.len();
        let count = if keyed.len() <= LEAF { keyed.len() as u32 } else { 0 };
        self.nodes.push(Node { low, high, second_or_first: first as u32, count });
        if count > 0 {
            return;
        }
        let along = usize::from(high.y - low.y > high.x - low.x);
        let half = keyed.len() / 2;
        keyed.select_nth_unstable_by(half, |(a, i), (b, j)| {
            a[along].total_cmp(&b[along]).then(i.cmp(j))
        });
        let (left, right) = keyed.split_at_mut(half);
        self.build(all, left, first);
        self.nodes[node].second_or_first = self.nodes.len() as u32;
        self.build(all, right, first + half);
    }

    /// Distance from the segment at `slot` of the tree, taken from a [`Hit`].
    pub fn at_slot(&self, slot: u32, metric: &FlatMetric, p: DVec2) -> Hit {
        let [a, b] = self.segments[slot as usize];
        let (distance, t) = metric.nearest_on(p, a, b);
        Hit { id: self.ids[slot as usize], slot, distance, t }
    }

    /// The nearest segment closer than `within` passes among those that `accept` allows.
    pub fn nearest(
        &self,
        metric: &FlatMetric,
        p: DVec2,
        within: f64,
        accept: impl Fn(u32) -> bool,
    ) -> Option<Hit> {
        let (least, mut best, mut bound) = (metric.least(), None, within);
        let mut open = Waiting::new();
        while let Some((distance, index)) = open.pop() {
            let Some(node) = self.nodes.get(index) else { continue };
            if distance >= bound {
                continue;
            }
            let from = node.second_or_first as usize;
            if node.count == 0 {
                let child = |i: usize| (self.nodes[i].distance(p) * least, i);
                let (first, second) = (child(index + 1), child(from));
                // The nearer one is looked at first.
                let in_order = first.0 <= second.0;
                let (later, sooner) = if in_order { (second, first) } else { (first, second) };
                open.push(later);
                open.push(sooner);
                continue;
            }
            for slot in from..from + node.count as usize {
                let hit = self.at_slot(slot as u32, metric, p);
                if hit.distance < bound && accept(hit.id) {
                    bound = hit.distance;
                    best = Some(hit);
                }
            }
        }
        best
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nearest_is_what_a_search_of_all_finds() {
        let metric = FlatMetric { xx: 2.0, xy: 0.4, yy: 0.5 };
        let point = |i: u32| {
            let mixed = i.wrapping_mul(2_654_435_761);
            DVec2::new(f64::from(mixed >> 20), f64::from((mixed >> 8) & 0xfff)) * 0.01
        };
        let segments: Vec<_> =
            (0..300).map(|i| [point(i), point(i) + DVec2::new(1.0, 0.5)]).collect();
        let tree = Tree::new(&segments);
        for i in 1000..1100 {
            let p = point(i);
            let all = segments.iter().map(|[a, b]| metric.nearest_on(p, *a, *b).0);
            let nearest = all.fold(f64::INFINITY, f64::min);
            let hit = tree.nearest(&metric, p, f64::INFINITY, |_| true).unwrap();
            assert_eq!(hit.distance, nearest);
        }
        assert_eq!(Tree::new(&[]).nearest(&metric, DVec2::ZERO, 1.0, |_| true), None);
    }
}
