//! Order of the rings: every ring after its neighbours on the cleared side.

use crate::geometry::{DVec2, OrderBy};
use crate::job::RingOrder;
use crate::level_set::Pass;

/// Points of a ring for which the nearest ring of the previous level is looked up.
const PROBES: usize = 24;

/// For every ring the rings that must be cut before it.
#[derive(Clone, Debug, PartialEq)]
pub struct Precedence {
    before: Vec<Vec<usize>>,
    after: Vec<Vec<usize>>,
}

impl Precedence {
    /// From the rings' levels and distances: a ring follows the nearest rings one level further out.
    pub fn new(rings: &[Pass], order: RingOrder) -> Self {
        let mut outer = vec![Vec::new(); rings.len()];
        for (i, ring) in rings.iter().enumerate() {
            let below = (ring.level.ceil() - 1.0).max(0.0);
            let candidates: Vec<usize> = (0..rings.len())
                .filter(|&j| j != i && rings[j].level.floor() == below)
                .filter(|&j| rings[j].level < ring.level)
                .collect();
            let step = ring.points.len().div_ceil(PROBES).max(1);
            for &p in ring.points.iter().step_by(step) {
                let nearest = candidates.iter().copied().min_by(|&a, &b| {
                    distance_squared(&rings[a], p).total_cmp(&distance_squared(&rings[b], p))
                });
                outer[i].extend(nearest);
            }
            outer[i].order_total();
            outer[i].dedup();
        }
        let mut inner = vec![Vec::new(); rings.len()];
        for (i, list) in outer.iter().enumerate() {
            for &j in list {
                inner[j].push(i);
            }
        }
        match order {
            RingOrder::OutsideIn => Self { before: outer, after: inner },
            RingOrder::InsideOut => Self { before: inner, after: outer },
        }
    }

    /// Rings that must be cut before this one.
    pub fn before(&self, ring: usize) -> &[usize] {
        &self.before[ring]
    }

    /// Rings that wait for this one.
    pub fn after(&self, ring: usize) -> &[usize] {
        &self.after[ring]
    }

    /// Number of rings on the longest chain.
    pub fn depth(&self) -> usize {
        let mut depth = vec![0; self.before.len()];
        let mut sequence = Sequence::new(self);
        while let Some(ring) = sequence.next_nearest(None, |_| 0.0) {
            depth[ring] = 1 + self.before[ring].iter().map(|&b| depth[b]).max().unwrap_or(0);
        }
        depth.into_iter().max().unwrap_or(0)
    }
}

/// Squared distance of `p` from the nearest vertex of a ring.
fn distance_squared(ring: &Pass, p: DVec2) -> f64 {
    ring.points.iter().map(|q| (*q - p).length_squared()).fold(f64::INFINITY, f64::min)
}

/// Hands out rings whose predecessors are cut: those that follow the last one first, else nearest.
pub struct Sequence<'a> {
    precedence: &'a Precedence,
    waiting: Vec<usize>,
    ready: Vec<usize>,
}

impl<'a> Sequence<'a> {
    /// Nothing cut yet.
    pub fn new(precedence: &'a Precedence) -> Self {
        let waiting: Vec<usize> = precedence.before.iter().map(Vec::len).collect();
        let ready = (0..waiting.len()).filter(|&i| waiting[i] == 0).collect();
        Self { precedence, waiting, ready }
    }

    /// The next ring; `distance` rates the candidates.
    pub fn next_nearest(
        &mut self,
        last: Option<usize>,
        distance: impl Fn(usize) -> f64,
    ) -> Option<usize> {
        let follows = |r: usize| last.is_some_and(|l| self.precedence.before[r].contains(&l));
        let (slot, _) = self
            .ready
            .iter()
            .enumerate()
            .map(|(slot, &r)| (slot, (!follows(r), distance(r), r)))
            .min_by(|(_, a), (_, b)| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)).then(a.2.cmp(&b.2)))?;
        let ring = self.ready.swap_remove(slot);
        for &next in self.precedence.after(ring) {
            self.waiting[next] -= 1;
            if self.waiting[next] == 0 {
                self.ready.push(next);
            }
        }
        Some(ring)
    }
}
