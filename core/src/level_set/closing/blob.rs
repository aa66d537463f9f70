//! Places that belong together, and the line along their middle.

use super::gaps::{LIMIT, Place, RASTER};
use super::tree::Tree;
use crate::geometry::DVec2;
use crate::parallel;
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// Places this close are neighbours, passes.
const LINK: f64 = 1.2 * RASTER;
/// Places handed to a thread at a time.
const CHUNK: usize = 2048;
/// Excess over the limit that counts as little when the middle is sought, passes. Smaller: the line
/// keeps closer to the middle; larger: it is shorter.
const SHALLOW: f64 = 0.02;

/// Places and who is whose neighbour.
pub struct Blob<'a> {
    places: &'a [Place],
    members: Vec<u32>,
    /// Neighbours of each member and their distances, passes, by index in `members`.
    neighbours: Vec<Vec<(u32, f64)>>,
}

/// Puts the places into connected blobs, in order of their first places.
pub fn blobs(places: &[Place], threads: usize) -> Vec<Blob<'_>> {
    let mut near = all_near(places, threads);
    let mut index = vec![u32::MAX; places.len()];
    let mut out = Vec::new();
    for first in 0..places.len() {
        if index[first] != u32::MAX {
            continue;
        }
        let mut blob = Blob { places, members: vec![first as u32], neighbours: Vec::new() };
        index[first] = 0;
        while blob.neighbours.len() < blob.members.len() {
            let member = blob.members[blob.neighbours.len()];
            let mut neighbours = core::mem::take(&mut near[member as usize]);
            // Nearness is measured where one is, and need not be mutual: a place that is near to none of an
            // earlier blob may have neighbours in it, which are not its blob's.
            neighbours.retain_mut(|(id, _)| {
                let known = index[*id as usize];
                if known == u32::MAX {
                    index[*id as usize] = blob.members.len() as u32;
                    blob.members.push(*id);
                }
                let own = index[*id as usize];
                let is_member = blob.members.get(own as usize) == Some(id);
                *id = own;
                is_member
            });
            blob.neighbours.push(neighbours);
        }
        out.push(blob);
    }
    out
}

/// For every place the places within [`LINK`] and their distances, passes, by index.
fn all_near(places: &[Place], threads: usize) -> Vec<Vec<(u32, f64)>> {
    let points: Vec<[DVec2; 2]> = places.iter().map(|p| [p.at, p.at]).collect();
    let tree = Tree::new(&points);
    let near = |place: &Place| {
        let mut near = Vec::new();
        tree.visit(&place.metric, place.at, LINK, |hit| near.push((hit.id, hit.distance)));
        near.sort_unstable_by_key(|(id, _)| *id);
        near
    };
    let chunks: Vec<&[Place]> = places.chunks(CHUNK).collect();
    let parts = parallel::map(threads, &chunks, |chunk| chunk.iter().map(near).collect::<Vec<_>>());
    parts.into_iter().flatten().collect()
}

/// What a step between neighbours costs when a line is sought.
#[derive(Copy, Clone)]
enum Cost {
    /// Its length.
    Length,
    /// Its length, weighted so that it keeps to the middle.
    Middle,
}

impl Blob<'_> {
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

    /// A second way between the ends of `line` through members that `allowed` tells.
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
            for &(to, length) in &self.neighbours[at as usize] {
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
