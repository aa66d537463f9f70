//! Places that belong together, and their middle line.

use super::gaps::{LIMIT, Place, RASTER};
use crate::geometry::{DVec2, OrderBy};
use crate::level_set::strip_metric::FlatMetric;
use core::cell::OnceCell;
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// Places this close are neighbours, passes.
const LINK: f64 = 1.2 * RASTER;
/// Excess over the limit that counts as small when the middle line is sought, passes. Smaller: the line keeps closer
/// to the middle; larger: it is shorter.
const SHALLOW: f64 = 0.02;
/// Fraction by which places are searched a little farther than [`LINK`], because of rounding.
const ROUNDING: f64 = 1e-9;

/// Places in rows of the plane, each row from left to right.
struct Rows {
    low: f64,
    height: f64,
    /// Where every row begins, and where the last one ends.
    begins: Vec<u32>,
    /// Horizontal coordinates and indices of the places.
    entries: Vec<(f64, u32)>,
}

impl Rows {
    fn of(places: &[Place]) -> Self {
        let heights = || places.iter().map(|p| p.at.y);
        let low = heights().fold(f64::INFINITY, f64::min);
        let extent = heights().fold(f64::NEG_INFINITY, f64::max) - low;
        let mut reaches: Vec<f64> = places.iter().map(reach).collect();
        let middle = reaches.len() / 2;
        let typical = match reaches.is_empty() {
            true => 1.0,
            false => *reaches.select_nth_unstable_by(middle, f64::total_cmp).1,
        };
        // No more rows than a few times the places.
        let least = (extent / (2.0 * places.len() as f64 + 1.0)).max(f64::MIN_POSITIVE);
        let height = if typical.is_finite() { typical.max(least) } else { least };
        let mut rows = Self { low, height, begins: Vec::new(), entries: Vec::new() };
        let mut keyed: Vec<(usize, f64, u32)> =
            (0..).zip(places).map(|(id, p)| (rows.row_of(p.at.y), p.at.x, id)).collect();
        keyed.order_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)));
        let count = keyed.last().map_or(0, |last| last.0 + 1);
        let begin = |row: usize| keyed.partition_point(|k| k.0 < row) as u32;
        rows.begins = (0..=count).map(begin).collect();
        rows.entries = keyed.into_iter().map(|(_, x, id)| (x, id)).collect();
        rows
    }

    /// The row of a height; what is below the first one belongs to it.
    fn row_of(&self, y: f64) -> usize {
        ((y - self.low) / self.height) as usize
    }

    /// Calls `found` for all places within [`LINK`] of one, and for some others: in every row those that the ellipse
    /// of that metric covers.
    fn visit(&self, place: &Place, mut found: impl FnMut(u32)) {
        let (at, FlatMetric { xx, xy, yy }) = (place.at, place.metric);
        // The ellipse is xx x² + 2 xy x y + yy y² = LINK².
        let link = LINK * (1.0 + ROUNDING);
        let lean = xy / xx;
        let square = (yy - lean * xy).max(f64::MIN_POSITIVE);
        let high = link / square.sqrt();
        let last = (self.begins.len() - 1).min(self.row_of(at.y + high) + 1);
        for row in self.row_of(at.y - high)..last {
            let low = self.low + row as f64 * self.height - at.y;
            let [from, to] = [low, low + self.height].map(|y| y.max(-high).min(high));
            let nearest = from.max(0.0).min(to);
            let half = ((link * link - square * nearest * nearest).max(0.0) / xx).sqrt();
            let [from, to] = [-lean * from, -lean * to];
            let (left, right) = (at.x + from.min(to) - half, at.x + from.max(to) + half);
            let [begin, end] = [row, row + 1].map(|r| self.begins[r] as usize);
            let entries = &self.entries[begin..end];
            let first = entries.partition_point(|entry| entry.0 < left);
            let within = entries[first..].iter().take_while(|entry| entry.0 <= right);
            within.for_each(|entry| found(entry.1));
        }
    }
}

/// How far away neighbours of a place may be in the direction in which passes are closest, flat mm.
fn reach(place: &Place) -> f64 {
    LINK / place.metric.most().max(f64::MIN_POSITIVE)
}

/// Places and which of them belong together.
pub struct Clusters<'a> {
    places: &'a [Place],
    rows: Rows,
    /// The first place of the cluster of every place.
    first: Vec<u32>,
    /// The number of every place in its cluster.
    number: Vec<u32>,
    /// The places of every cluster, in order.
    members: Vec<Vec<u32>>,
}

impl<'a> Clusters<'a> {
    /// Puts the places into connected clusters, in order of their first places.
    pub fn of(places: &'a [Place]) -> Self {
        let rows = Rows::of(places);
        let mut sets = Sets::new(places.len());
        for (own, place) in (0..).zip(places) {
            rows.visit(place, |id| {
                if sets.first(id) != sets.first(own) && is_near(place, &places[id as usize]) {
                    sets.join(own, id);
                }
            });
        }
        let first: Vec<u32> = (0..places.len() as u32).map(|id| sets.first(id)).collect();
        let mut members: Vec<Vec<u32>> = Vec::new();
        let mut cluster = vec![0; places.len()];
        let mut number = vec![0; places.len()];
        for (id, &first) in (0..).zip(&first) {
            if first == id {
                cluster[id as usize] = members.len();
                members.push(Vec::new());
            }
            let of = &mut members[cluster[first as usize]];
            number[id as usize] = of.len() as u32;
            of.push(id);
        }
        Self { places, rows, first, number, members }
    }

    /// Every cluster.
    pub fn iter(&self) -> impl Iterator<Item = Cluster<'_>> {
        self.members.iter().map(|members| Cluster { all: self, members, near: OnceCell::new() })
    }

    /// The neighbours of the members of a cluster.
    fn nearness(&self, members: &[u32]) -> Nearness {
        let mut near = Nearness { begins: vec![0], links: Vec::new() };
        for &member in members {
            let (place, begin) = (&self.places[member as usize], near.links.len());
            self.rows.visit(place, |id| {
                let is_member = self.first[id as usize] == self.first[member as usize];
                if is_member && is_near(place, &self.places[id as usize]) {
                    near.links.push(self.number[id as usize]);
                }
            });
            near.links[begin..].order_total();
            near.begins.push(near.links.len());
        }
        near
    }
}

fn is_near(place: &Place, other: &Place) -> bool {
    distance(place, other) <= LINK
}

/// How far a place is from another, passes.
fn distance(place: &Place, other: &Place) -> f64 {
    place.metric.length(place.at - other.at)
}

/// Sets of numbers, each known by its first one.
struct Sets {
    /// A number of the same set that is not larger; that of the first is its own.
    before: Vec<u32>,
}

impl Sets {
    fn new(count: usize) -> Self {
        Self { before: (0..count as u32).collect() }
    }

    fn first(&mut self, mut id: u32) -> u32 {
        while self.before[id as usize] != id {
            let before = self.before[id as usize];
            self.before[id as usize] = self.before[before as usize];
            id = before;
        }
        id
    }

    fn join(&mut self, one: u32, other: u32) {
        let (one, other) = (self.first(one), self.first(other));
        self.before[one.max(other) as usize] = one.min(other);
    }
}

/// The neighbours of every member of a cluster, as members.
struct Nearness {
    /// Where the neighbours of every member begin, and where the last ones end.
    begins: Vec<usize>,
    links: Vec<u32>,
}

impl Nearness {
    fn links(&self, member: u32) -> &[u32] {
        &self.links[self.begins[member as usize]..self.begins[member as usize + 1]]
    }
}

/// Places that are connected.
pub struct Cluster<'a> {
    all: &'a Clusters<'a>,
    members: &'a [u32],
    /// Once it is asked for.
    near: OnceCell<Nearness>,
}

/// Cost of a step between neighbours when a line is sought.
#[derive(Copy, Clone)]
enum Cost {
    /// Its length.
    Length,
    /// Its length, weighted so that the line keeps to the middle.
    Middle,
}

impl Cluster<'_> {
    /// The places.
    pub fn places(&self) -> impl Iterator<Item = &Place> + '_ {
        self.members.iter().map(|&m| &self.all.places[m as usize])
    }

    /// A member's place.
    pub fn member(&self, member: u32) -> &Place {
        &self.all.places[self.members[member as usize] as usize]
    }

    /// The place with the widest gap.
    pub fn deepest(&self) -> &Place {
        let deeper = |best: u32, m: u32| {
            if self.member(m).gap > self.member(best).gap { m } else { best }
        };
        self.member((0..self.members.len() as u32).fold(0, deeper))
    }

    /// The line along the middle, from one end to the other, as members.
    pub fn middle_line(&self) -> Vec<u32> {
        let everywhere = vec![true; self.members.len()];
        let one = self.farthest(0);
        let other = self.farthest(one);
        self.way(one, other, &everywhere).unwrap_or_else(|| vec![one])
    }

    /// A second route between the ends of `line` through members for which `allowed` is true.
    pub fn way_round(&self, line: &[u32], allowed: &[bool]) -> Option<Vec<u32>> {
        self.way(*line.last()?, *line.first()?, allowed)
    }

    /// Flat points of members.
    pub fn points(&self, line: &[u32]) -> Vec<DVec2> {
        line.iter().map(|&m| self.member(m).at).collect()
    }

    fn farthest(&self, from: u32) -> u32 {
        let everywhere = vec![true; self.members.len()];
        let (distance, _) = self.distances(from, Cost::Length, &everywhere);
        let farther = |best: u32, m: u32| {
            if distance[m as usize] > distance[best as usize] { m } else { best }
        };
        (0..distance.len() as u32).fold(0, farther)
    }

    fn way(&self, from: u32, to: u32, allowed: &[bool]) -> Option<Vec<u32>> {
        let (distance, before) = self.distances(from, Cost::Middle, allowed);
        if !distance[to as usize].is_finite() {
            return None;
        }
        let mut way = vec![to];
        let mut at = to;
        while at != from {
            at = before[at as usize];
            way.push(at);
        }
        way.reverse();
        Some(way)
    }

    /// Dijkstra 1959: cost of the cheapest way to each member, and the member before it on the way.
    fn distances(&self, from: u32, cost: Cost, allowed: &[bool]) -> (Vec<f64>, Vec<u32>) {
        let deepest = self.deepest().gap - LIMIT + SHALLOW;
        let near = self.near.get_or_init(|| self.all.nearness(self.members));
        let mut distance = vec![f64::INFINITY; self.members.len()];
        let mut before = vec![from; self.members.len()];
        let mut open = BinaryHeap::from([Reverse((0u64, from))]);
        distance[from as usize] = 0.0;
        while let Some(Reverse((bits, at))) = open.pop() {
            if bits != distance[at as usize].to_bits() {
                continue;
            }
            for &to in near.links(at) {
                let length = self::distance(self.member(at), self.member(to));
                let weight = match cost {
                    Cost::Length => 1.0,
                    Cost::Middle => deepest / (self.member(to).gap - LIMIT + SHALLOW),
                };
                let reached = distance[at as usize] + length * weight * weight;
                if allowed[to as usize] && reached < distance[to as usize] {
                    distance[to as usize] = reached;
                    before[to as usize] = at;
                    // Bits of non-negative numbers are in their order.
                    open.push(Reverse((reached.to_bits(), to)));
                }
            }
        }
        (distance, before)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Places of very different metrics.
    fn places() -> Vec<Place> {
        let part = |i: u32| f64::from(i.wrapping_mul(2_654_435_761) >> 12) / f64::from(1u32 << 20);
        let place = |i: u32| Place {
            at: DVec2::new(part(i), part(i + 7000)) * 0.5 - 3.0,
            metric: FlatMetric { xx: 2.0, xy: 0.3, yy: 0.5 + 30.0 * part(i + 900).powi(8) },
            level: 0.0,
            gap: 0.6,
            area: 1.0,
        };
        (0..700).map(place).collect()
    }

    #[test]
    fn neighbours_are_what_a_search_of_all_finds() {
        let places = places();
        let clusters = Clusters::of(&places);
        let mut links = 0;
        for cluster in clusters.iter() {
            let near = clusters.nearness(cluster.members);
            for (member, &id) in (0..).zip(cluster.members) {
                let place = &places[id as usize];
                let all = places.iter().enumerate().filter(|(_, other)| is_near(place, other));
                let expected: Vec<u32> = all.map(|(k, _)| k as u32).collect();
                let found: Vec<u32> =
                    near.links(member).iter().map(|&m| cluster.members[m as usize]).collect();
                assert_eq!(found, expected);
                links += found.len();
            }
        }
        assert!(links > 2 * places.len());
        assert!(clusters.members.len() > 1);
        assert_eq!(clusters.members.concat().len(), places.len());
        assert_eq!(Clusters::of(&[]).iter().count(), 0);
    }
}
