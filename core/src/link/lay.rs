//! Passes → one flat path at the nominal feed, ignoring the removal rate.
//!
//! Rings are cut one after the other in an order that respects their precedence; open passes to and fro or all one
//! way. Consecutive passes are joined on the surface where the straight flat line between them is short and stays on
//! it, otherwise by a retract.

use super::group::{Group, LONGEST_LINK, SLANT, oriented};
use super::order::{Precedence, Sequence};
use crate::flat_path::{FlatPoint, Terrain};
use crate::footprint::Footprint;
use crate::geometry::{DVec2, OrderBy};
use crate::job::{Links, RingOrder, Traverse};
use crate::level_set::{INSIDE, Pass};
use crate::toolpath::MoveKind;

/// A strip that lags, at the end of its pass, is taken to be wider by this factor: neighbours are not quite
/// parallel, boundaries not quite straight.
const ROOM: f64 = 1.1;

/// How passes are laid out.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct LayOptions {
    /// Order of rings.
    pub order: RingOrder,
    /// Traversal of open passes.
    pub traverse: Traverse,
    /// How passes are joined.
    pub links: Links,
    /// Whether the material lies on the right of the feed.
    pub stock_on_right: bool,
    /// Cutter radius, mm.
    pub radius: f64,
    /// Height over the surface at which the cutter arrives, mm.
    pub height: f64,
    /// Feed, mm/s.
    pub feed: f64,
    /// The cutter.
    pub footprint: Footprint,
}

/// Lays out the passes of one region after the other.
pub fn lay(groups: &[Group], terrain: &dyn Terrain, options: &LayOptions) -> Vec<FlatPoint> {
    let mut layer = Layer { terrain, options, points: Vec::new(), pass: 0, region: 0 };
    for (region, group) in (0..).zip(groups) {
        layer.region = region;
        if group.has_rings_only() {
            layer.rings(group.passes, group.precedence);
        } else {
            layer.open(group.passes);
        }
    }
    layer.points
}

struct Layer<'a> {
    terrain: &'a dyn Terrain,
    options: &'a LayOptions,
    points: Vec<FlatPoint>,
    pass: u32,
    region: u32,
}

impl Layer<'_> {
    fn at(&self) -> Option<DVec2> {
        self.points.last().map(|p| p.at)
    }

    fn rings(&mut self, rings: &[Pass], precedence: &Precedence) {
        let stock_is_higher = self.options.order == RingOrder::OutsideIn;
        let stock_on_right = self.options.stock_on_right;
        let mut sequence = Sequence::new(precedence);
        let mut last = None;
        loop {
            let from = self.at();
            let distance = |r: usize| from.map_or(0.0, |from| nearest(&rings[r].points, from).1);
            let Some(index) = sequence.next_nearest(last, distance) else { break };
            let mut ring = oriented(&rings[index], stock_is_higher != stock_on_right);
            self.begin_ring(&mut ring);
            self.pass(&ring);
            last = Some(index);
        }
    }

    /// Rotates a ring so that it begins a slanted lead-in ahead of the point nearest to the cutter.
    fn begin_ring(&self, ring: &mut Pass) {
        let Some(from) = self.at() else { return };
        let disc = self.options.radius / self.terrain.scale(from).unwrap_or(1.0);
        let n = ring.points.len();
        let (mut start, _) = nearest(&ring.points, from);
        let step = |i: usize| ring.points[i].distance(ring.points[(i + 1) % n]);
        let mut left = (SLANT * disc).min(0.25 * (0..n).map(step).sum::<f64>());
        while left > 0.0 {
            left -= step(start);
            start = (start + 1) % n;
        }
        ring.points.rotate_left(start);
        ring.branches.iter_mut().for_each(|s| s.at = (s.at + n - start) % n);
    }

    /// Open passes, always continuing at the nearest end; rings among them in their own order.
    fn open(&mut self, passes: &[Pass]) {
        let mut left: Vec<usize> = (0..passes.len()).collect();
        let reverse_all = !self.options.stock_on_right;
        while let Some((slot, reverse)) = self.next_open(passes, &left) {
            let pass = &passes[left.remove(slot)];
            let reverse = match self.options.traverse {
                Traverse::Zigzag if !pass.is_closed => reverse,
                _ => reverse_all,
            };
            let mut pass = oriented(pass, reverse);
            if pass.is_closed {
                self.begin_ring(&mut pass);
            }
            self.pass(&pass);
        }
    }

    /// The next pass and whether its end is nearer than its start. The first pass comes first; in one-way order,
    /// passes keep their order.
    fn next_open(&self, passes: &[Pass], left: &[usize]) -> Option<(usize, bool)> {
        let from = self.at().filter(|_| self.options.traverse == Traverse::Zigzag);
        let Some(from) = from else { return (!left.is_empty()).then_some((0, false)) };
        let rate = |i: usize| {
            let points = &passes[i].points;
            let start = points[0].distance_squared(from);
            let end = points[points.len() - 1].distance_squared(from);
            (start.min(end), end < start)
        };
        let rated = left.iter().enumerate().map(|(slot, &i)| (slot, rate(i)));
        let best = rated.min_by(|a, b| a.1.0.total_cmp(&b.1.0).then(a.0.cmp(&b.0)));
        best.map(|(slot, (_, reverse))| (slot, reverse))
    }

    /// One pass from its start, with the move to it.
    fn pass(&mut self, pass: &Pass) {
        let start = pass.points[0];
        self.reach(start);
        let by = self.overruns(pass);
        if let Some(arrived) = self.points.last_mut() {
            arrived.overrun = -by[0];
        }
        let n = pass.points.len();
        let last = if pass.is_closed { n } else { n - 1 };
        let mut branches: Vec<_> = pass.branches.iter().collect();
        branches.order_by_key(|s| s.at);
        let branches_at = |i: usize| branches.iter().filter(move |s| s.at == i);
        for i in 0..=last {
            let p = pass.points[i % n];
            if i > 0 {
                self.push(p, 0.0, MoveKind::Cut, None);
            }
            // A ring's first point is come by twice.
            if i == last && pass.is_closed {
                break;
            }
            if i + 1 == n && !pass.is_closed {
                self.overrun(p, by[1], branches_at(i).next().is_some());
            }
            let towards = pass.points[(i + 1) % n] - p;
            let behind = if i > 0 { p - pass.points[i - 1] } else { towards };
            for branch in branches_at(i) {
                let heading = behind.try_normalize();
                for &q in branch.points.iter().chain([&p]) {
                    self.push(q, 0.0, MoveKind::Cut, heading);
                }
            }
        }
        self.pass += 1;
    }

    /// How far a pass extends before its start and beyond its end, mm on the surface.
    fn overruns(&self, pass: &Pass) -> [f64; 2] {
        let Some(ends) = pass.points.first().zip(pass.points.last()) else { return [0.0; 2] };
        let at = |end: usize, place: DVec2| {
            let scale = self.terrain.scale(place).unwrap_or(1.0);
            let footprint = &self.options.footprint;
            if pass.overrun[end] == 0.0 || !footprint.lags() {
                return scale * pass.overrun[end];
            }
            let half = ROOM * scale * pass.half[end];
            let beside = ROOM * scale * pass.overrun[end];
            // As much as it is drawn in at least.
            footprint.overruns(half, beside)[end].max(2.0 * INSIDE * half)
        };
        [at(0, *ends.0), at(1, *ends.1)]
    }

    /// Extends the pass beyond its end, before any branch leaves from there.
    fn overrun(&mut self, end: DVec2, by: f64, has_branches: bool) {
        if let Some(last) = self.points.last_mut() {
            last.overrun = by;
        }
        if has_branches {
            self.push(end, 0.0, MoveKind::Cut, None);
        }
    }

    /// Goes to a point of the surface, by link or by retract.
    fn reach(&mut self, to: DVec2) {
        let height = self.options.height;
        match self.at() {
            Some(from) if self.can_link(from, to) => {
                return self.push(to, 0.0, MoveKind::Link, None);
            }
            Some(_) => {
                self.push(to, height, MoveKind::Rapid, None);
            }
            None => self.push(to, height, MoveKind::Link, None),
        }
        self.push(to, 0.0, MoveKind::Link, None);
    }

    fn can_link(&self, from: DVec2, to: DVec2) -> bool {
        let scale = self.terrain.scale(from).unwrap_or(1.0);
        self.options.links == Links::Surface
            && self.options.traverse == Traverse::Zigzag
            && from.distance(to) * scale <= LONGEST_LINK * self.options.radius
            && self.terrain.joins(from, to)
    }

    fn push(&mut self, at: DVec2, height: f64, kind: MoveKind, heading: Option<DVec2>) {
        self.points.push(FlatPoint {
            at,
            height,
            kind,
            pass: self.pass,
            region: self.region,
            feed: self.options.feed,
            mrr: 0.0,
            alpha: 0.0,
            length: 0.0,
            heading,
            overrun: 0.0,
        });
    }
}

/// The point nearest to `from`: its index and squared distance.
fn nearest(points: &[DVec2], from: DVec2) -> (usize, f64) {
    let rated = points.iter().map(|p| p.distance_squared(from)).enumerate();
    rated.min_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or((0, f64::INFINITY))
}
