//! The order in which regions are machined.
//!
//! - *Neighbours*: regions whose boundaries touch.
//! - *Way*: from the last pass of a region to the nearest place of the first pass of the next.
//!
//! One walk through the graph of neighbours starts at every region; the one with the shortest ways is used.

use super::division::{Region, Regions};
use super::layout::Layout;
use super::split_mesh::SplitMesh;
use crate::geometry::{DVec2, DVec3};
use crate::job::RegionOrder;
use crate::level_set::Pass;
use std::collections::{BTreeSet, VecDeque};

/// Places of a pass that ways are measured from and to. Fewer: worse orders; more: slower.
const PROBES: usize = 24;
/// With more regions than this, walks begin at the largest ones only.
const MOST_STARTS: usize = 60;

/// The order in which the regions are machined; `place`: of a flat point on the surface.
pub fn in_order(
    regions: Option<&Regions>,
    layouts: &[Layout],
    order: RegionOrder,
    place: impl Fn(DVec2) -> Option<DVec3>,
) -> Vec<usize> {
    let Some(regions) = regions else { return (0..layouts.len()).collect() };
    let parts = &regions.list;
    let graph = Graph {
        neighbours: neighbours(&regions.split_mesh, &regions.list),
        ways: ways(layouts, place),
    };
    let starts: Vec<usize> = (0..parts.len()).take(MOST_STARTS).collect();
    let walks: &[fn(&Graph, usize) -> Vec<usize>] = match order {
        RegionOrder::DepthFirst => &[Graph::depth_first],
        RegionOrder::BreadthFirst => &[Graph::breadth_first],
        RegionOrder::Nearest => &[Graph::nearest],
        RegionOrder::Shortest => &[Graph::depth_first, Graph::breadth_first, Graph::nearest],
    };
    let all = walks.iter().flat_map(|walk| starts.iter().map(|&s| walk(&graph, s)));
    let best = all.map(|o| (graph.length(&o), o)).min_by(|a, b| a.0.total_cmp(&b.0));
    best.map_or_else(Vec::new, |(_, order)| order)
}

/// Regions and the ways between them.
struct Graph {
    neighbours: Vec<Vec<usize>>,
    /// From one region to another, mm.
    ways: Vec<Vec<f64>>,
}

impl Graph {
    /// Length of the ways of an order, mm.
    fn length(&self, order: &[usize]) -> f64 {
        order.windows(2).map(|w| self.ways[w[0]][w[1]]).sum()
    }

    /// Neighbours that are not done yet, the nearest first.
    fn open_neighbours(&self, at: usize, is_done: &[bool]) -> Vec<usize> {
        let mut open: Vec<usize> =
            self.neighbours[at].iter().copied().filter(|&n| !is_done[n]).collect();
        open.sort_by(|&a, &b| self.ways[at][a].total_cmp(&self.ways[at][b]));
        open
    }

    /// The region that is not done yet and nearest to the last one, where the surface consists of several pieces.
    fn nearest_open(&self, order: &[usize], is_done: &[bool]) -> Option<usize> {
        let ways = &self.ways[*order.last()?];
        let open = (0..is_done.len()).filter(|&r| !is_done[r]);
        open.min_by(|&a, &b| ways[a].total_cmp(&ways[b]))
    }

    fn depth_first(&self, start: usize) -> Vec<usize> {
        let mut is_done = vec![false; self.neighbours.len()];
        let (mut order, mut stack) = (Vec::new(), vec![start]);
        while let Some(at) = stack.pop().or_else(|| self.nearest_open(&order, &is_done)) {
            if !is_done[at] {
                is_done[at] = true;
                order.push(at);
                stack.extend(self.open_neighbours(at, &is_done).into_iter().rev());
            }
        }
        order
    }

    fn breadth_first(&self, start: usize) -> Vec<usize> {
        let mut is_done = vec![false; self.neighbours.len()];
        let (mut order, mut queue) = (Vec::new(), VecDeque::from([start]));
        while let Some(at) = queue.pop_front().or_else(|| self.nearest_open(&order, &is_done)) {
            if !is_done[at] {
                is_done[at] = true;
                order.push(at);
                queue.extend(self.open_neighbours(at, &is_done));
            }
        }
        order
    }

    fn nearest(&self, start: usize) -> Vec<usize> {
        let mut left: Vec<usize> = (0..self.neighbours.len()).filter(|&r| r != start).collect();
        let mut order = vec![start];
        let mut at = start;
        while let Some(slot) = (0..left.len())
            .min_by(|&a, &b| self.ways[at][left[a]].total_cmp(&self.ways[at][left[b]]))
        {
            at = left.remove(slot);
            order.push(at);
        }
        order
    }
}

/// Ways from every region to every other one, mm.
fn ways(layouts: &[Layout], place: impl Fn(DVec2) -> Option<DVec3>) -> Vec<Vec<f64>> {
    let probes = |pass: &Pass| -> Vec<DVec3> {
        let step = pass.points.len().div_ceil(PROBES).max(1);
        pass.points.iter().step_by(step).filter_map(|&p| place(p)).collect()
    };
    let ends = |layout: &Layout| {
        [layout.passes.first(), layout.passes.last()].map(|p| p.map_or_else(Vec::new, probes))
    };
    let ends: Vec<[Vec<DVec3>; 2]> = layouts.iter().map(ends).collect();
    let nearest = |from: &[DVec3], to: &[DVec3]| {
        let ways = from.iter().flat_map(|p| to.iter().map(|q| p.distance_squared(*q)));
        ways.fold(f64::INFINITY, f64::min).sqrt()
    };
    let from = |last: &[DVec3]| ends.iter().map(|[first, _]| nearest(last, first)).collect();
    ends.iter().map(|[_, last]| from(last)).collect()
}

/// For every region the ones that share a side with it.
pub fn neighbours(split_mesh: &SplitMesh, regions: &[Region]) -> Vec<Vec<usize>> {
    let mut of_face = vec![usize::MAX; split_mesh.faces().len()];
    for (k, region) in regions.iter().enumerate() {
        region.piece.faces.iter().for_each(|&f| of_face[f as usize] = k);
    }
    let mut pairs: BTreeSet<(usize, usize)> = BTreeSet::new();
    for h in 0..3 * split_mesh.faces().len() as u32 {
        let other = split_mesh.opposite(h).map(|o| of_face[o as usize / 3]);
        let here = of_face[h as usize / 3];
        // What belongs to no region is not machined.
        let other = other.filter(|&o| o != here && o != usize::MAX);
        pairs.extend(other.map(|o| (here, o)));
    }
    let mut lists = vec![Vec::new(); regions.len()];
    for (a, b) in pairs {
        if let Some(list) = lists.get_mut(a) {
            list.push(b);
        }
    }
    lists
}
