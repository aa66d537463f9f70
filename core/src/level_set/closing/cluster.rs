//! Places that belong together, and their middle line.

use super::gaps::{LIMIT, Place, RASTER};
use crate::geometry::{DVec2, OrderBy};
use crate::level_set::strip_metric::FlatMetric;
use crate::parallel;
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// Places this close are neighbours, passes.
const LINK: f64 = 1.2 * RASTER;
/// Places handed to a thread at a time.
const CHUNK: usize = 2048;
/// Cells of the search for neighbours along the longer side of all places, at most.
const MOST_CELLS: f64 = 1024.0;
/// Excess over the limit that counts as small when the middle line is sought, passes. Smaller: the line keeps closer
/// to the middle; larger: it is shorter.
const SHALLOW: f64 = 0.02;

/// The neighbours of every place.
pub struct Nearness {
    /// Where the neighbours of every place begin, and where the last ones end.
    begins: Vec<usize>,
    /// Neighbours and their distances, passes, by index.
    links: Vec<(u32, f64)>,
}

impl Nearness {
    /// Of all places.
    pub fn of(places: &[Place], threads: usize) -> Self {
        let grid = Grid::of(places);
        let numbered: Vec<u32> = (0..places.len() as u32).collect();
        let chunks: Vec<&[u32]> = numbered.chunks(CHUNK).collect();
        let near = |&&own: &&u32, links: &mut Vec<(u32, f64)>| {
            let (place, first) = (&places[own as usize], links.len());
            grid.visit(place, |id| {
                let distance = place.metric.length(place.at - places[id as usize].at);
                if distance <= LINK {
                    links.push((id, distance));
                }
            });
            links[first..].order_total_by_key(|(id, _)| *id);
            links.len()
        };
        let parts = parallel::map(threads, &chunks, |chunk| {
            let mut links = Vec::new();
            let ends: Vec<usize> = chunk.iter().map(|own| near(&own, &mut links)).collect();
            (ends, links)
        });
        let mut all = Self { begins: vec![0], links: Vec::new() };
        for (ends, links) in parts {
            let first = all.links.len();
            all.begins.extend(ends.into_iter().map(|end| first + end));
            all.links.extend(links);
        }
        all
    }

    /// The neighbours among the places that are kept, which are renumbered.
    pub fn among(&self, kept: &[bool]) -> Self {
        let mut count = 0;
        let number = |is_kept: &bool| {
            count += u32::from(*is_kept);
            count.wrapping_sub(1)
        };
        let numbers: Vec<u32> = kept.iter().map(number).collect();
        let mut out = Self { begins: vec![0], links: Vec::new() };
        for place in (0..kept.len()).filter(|&place| kept[place]) {
            let links = self.links(place).iter().filter(|(id, _)| kept[*id as usize]);
            out.links.extend(links.map(|&(id, distance)| (numbers[id as usize], distance)));
            out.begins.push(out.links.len());
        }
        out
    }

    fn links(&self, place: usize) -> &[(u32, f64)] {
        &self.links[self.begins[place]..self.begins[place + 1]]
    }
}

/// How far away neighbours of a place may be in the direction in which passes are closest, flat mm.
fn reach(place: &Place) -> f64 {
    LINK / place.metric.most().max(f64::MIN_POSITIVE)
}

/// Places by the grid cells of the plane in which they lie.
struct Grid {
    low: DVec2,
    cell: f64,
    columns: usize,
    rows: usize,
    /// Where the places of every cell begin, and where the last ones end.
    begins: Vec<u32>,
    ids: Vec<u32>,
}

impl Grid {
    fn of(places: &[Place]) -> Self {
        let points = || places.iter().map(|p| p.at);
        let low = points().fold(DVec2::INFINITY, DVec2::min);
        let high = points().fold(DVec2::NEG_INFINITY, DVec2::max);
        let mut reaches: Vec<f64> = places.iter().map(reach).collect();
        let middle = reaches.len() / 2;
        let typical = match reaches.is_empty() {
            true => 1.0,
            false => *reaches.select_nth_unstable_by(middle, f64::total_cmp).1,
        };
        // No more cells than a few times the places, either.
        let most = MOST_CELLS.min(2.0 * (places.len() as f64).sqrt() + 1.0);
        let finest = (high - low).max_element().max(f64::MIN_POSITIVE) / most;
        let cell = if typical.is_finite() { typical.max(finest) } else { finest };
        let mut grid =
            Self { low, cell, columns: 1, rows: 1, begins: Vec::new(), ids: vec![0; places.len()] };
        if !places.is_empty() {
            [grid.columns, grid.rows] = grid.count(high).map(|k| k + 1);
        }
        let mut begins = vec![0u32; grid.columns * grid.rows + 1];
        points().for_each(|at| begins[grid.cell_of(at) + 1] += 1);
        (1..begins.len()).for_each(|c| begins[c] += begins[c - 1]);
        let mut next = begins.clone();
        for (id, at) in points().enumerate() {
            let slot = &mut next[grid.cell_of(at)];
            grid.ids[*slot as usize] = id as u32;
            *slot += 1;
        }
        grid.begins = begins;
        grid
    }

    /// Column and row of a place; places before the first cell belong to it.
    fn count(&self, at: DVec2) -> [usize; 2] {
        ((at - self.low) / self.cell).to_array().map(|x| x as usize)
    }

    fn cell_of(&self, at: DVec2) -> usize {
        let [column, row] = self.count(at);
        row.min(self.rows - 1) * self.columns + column.min(self.columns - 1)
    }

    /// Calls `found` for all places within [`LINK`] of one, and for some others: in every row of cells those that the
    /// ellipse of that metric covers.
    fn visit(&self, place: &Place, mut found: impl FnMut(u32)) {
        let (at, FlatMetric { xx, xy, yy }) = (place.at, place.metric);
        // The ellipse is xx x² + 2 xy x y + yy y² = LINK².
        let lean = xy / xx;
        let square = (yy - lean * xy).max(f64::MIN_POSITIVE);
        let high = LINK / square.sqrt();
        let [_, bottom] = self.count(at - DVec2::Y * high);
        let [_, top] = self.count(at + DVec2::Y * high);
        for row in bottom..=top.min(self.rows - 1) {
            let low = self.low.y + row as f64 * self.cell - at.y;
            let [from, to] = [low, low + self.cell].map(|y| y.max(-high).min(high));
            let nearest = from.max(0.0).min(to);
            let half = ((LINK * LINK - square * nearest * nearest).max(0.0) / xx).sqrt();
            let [from, to] = [-lean * from, -lean * to];
            // A cell more on either side for rounding.
            let [left, _] = self.count(at + DVec2::X * (from.min(to) - half - self.cell));
            let [right, _] = self.count(at + DVec2::X * (from.max(to) + half + self.cell));
            let right = right.min(self.columns - 1);
            let first = row * self.columns;
            let [from, to] = [left.min(right), right + 1].map(|c| self.begins[first + c] as usize);
            self.ids[from..to].iter().copied().for_each(&mut found);
        }
    }
}

/// Places and their neighbours.
pub struct Cluster<'a> {
    places: &'a [Place],
    members: Vec<u32>,
    /// By index in `members`.
    near: Nearness,
}

/// Puts the places into connected clusters, in order of their first places.
pub fn clusters<'a>(places: &'a [Place], near: &Nearness) -> Vec<Cluster<'a>> {
    let mut index = vec![u32::MAX; places.len()];
    let mut out = Vec::new();
    for first in 0..places.len() {
        if index[first] != u32::MAX {
            continue;
        }
        let mut members = vec![first as u32];
        let mut own = Nearness { begins: vec![0], links: Vec::new() };
        index[first] = 0;
        while own.begins.len() <= members.len() {
            let member = members[own.begins.len() - 1];
            for &(id, distance) in near.links(member as usize) {
                let known = index[id as usize];
                if known == u32::MAX {
                    index[id as usize] = members.len() as u32;
                    members.push(id);
                }
                // Nearness is measured where one is, and need not be mutual: a place that is near to none of
                // an earlier cluster may have neighbours in it, which are not its cluster's.
                let number = index[id as usize];
                if members.get(number as usize) == Some(&id) {
                    own.links.push((number, distance));
                }
            }
            own.begins.push(own.links.len());
        }
        out.push(Cluster { places, members, near: own });
    }
    out
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
        self.members.iter().map(|&m| &self.places[m as usize])
    }

    /// A member's place.
    pub fn member(&self, member: u32) -> &Place {
        &self.places[self.members[member as usize] as usize]
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
        let mut distance = vec![f64::INFINITY; self.members.len()];
        let mut before = vec![from; self.members.len()];
        let mut open = BinaryHeap::from([Reverse((0u64, from))]);
        distance[from as usize] = 0.0;
        while let Some(Reverse((bits, at))) = open.pop() {
            if bits != distance[at as usize].to_bits() {
                continue;
            }
            for &(to, length) in self.near.links(at as usize) {
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
        let near = Nearness::of(&places, 2);
        let kept: Vec<bool> = (0..places.len()).map(|i| i % 3 != 1).collect();
        let left: Vec<Place> = (0..places.len()).filter(|&i| kept[i]).map(|i| places[i]).collect();
        for (places, near) in [(&places, &near), (&left, &near.among(&kept))] {
            for (i, place) in places.iter().enumerate() {
                let distance = |other: &Place| place.metric.length(place.at - other.at);
                let all = places.iter().map(distance).enumerate();
                let expected: Vec<(u32, f64)> =
                    all.filter(|d| d.1 <= LINK).map(|(k, d)| (k as u32, d)).collect();
                assert_eq!(near.links(i), expected);
            }
        }
        assert!(near.links.len() > 2 * places.len());
        assert!(clusters(&[], &Nearness::of(&[], 1)).is_empty());
    }
}
