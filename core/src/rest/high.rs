//! The samples that are too high, the highest first, and those of them that are near a place.

use super::samples::Sample;
use crate::geometry::{DVec2, DVec3, OrderBy};
use std::collections::BTreeMap;

/// Most cells that a search looks into; where it would be more, all samples are looked at.
const MOST_CELLS: f64 = 256.0;

/// Numbers of samples by the cells of a grid in which they lie.
struct Cells<const N: usize> {
    side: f64,
    cells: BTreeMap<[i64; N], Vec<usize>>,
}

/// The samples that are too high, in the order in which they are lowered.
pub(super) struct High {
    order: Vec<usize>,
    /// Height of the first, mm.
    most: f64,
    /// Place in that order of every sample that is still too high.
    rank: BTreeMap<usize, usize>,
    /// How many of the first are done.
    done: usize,
    in_space: Cells<3>,
    flat: Cells<2>,
}

impl<const N: usize> Cells<N> {
    fn of(side: f64, places: impl Iterator<Item = (usize, [f64; N])>) -> Self {
        let mut out = Self { side, cells: BTreeMap::new() };
        for (i, place) in places {
            let cell = out.cell(place);
            out.cells.entry(cell).or_default().push(i);
        }
        out
    }

    fn cell(&self, place: [f64; N]) -> [i64; N] {
        place.map(|x| (x / self.side).floor() as i64)
    }

    /// The samples in all cells that meet a box; `None` where these are too many.
    fn within(&self, low: [f64; N], high: [f64; N]) -> Option<Vec<usize>> {
        let [first, last] = [self.cell(low), self.cell(high)];
        let count: f64 = (0..N).map(|k| last[k] as f64 - first[k] as f64 + 1.0).product();
        if count > MOST_CELLS {
            return None;
        }
        let mut out = Vec::new();
        let mut cell = first;
        loop {
            out.extend(self.cells.get(&cell).into_iter().flatten());
            let Some(k) = (0..N).find(|&k| cell[k] < last[k]) else { return Some(out) };
            cell[k] += 1;
            cell[..k].copy_from_slice(&first[..k]);
        }
    }
}

impl High {
    /// `side`: size of the cells in space, mm; `side_step`: of those in the flat map, mm on the surface.
    pub(super) fn of(
        mut order: Vec<usize>,
        samples: &[Sample],
        heights: &[f64],
        side: f64,
        side_step: f64,
    ) -> Self {
        order.order_by(|&a, &b| heights[b].total_cmp(&heights[a]));
        let scale = order.iter().map(|&i| samples[i].scale).fold(0.0, f64::max);
        let in_space = Cells::of(side, order.iter().map(|&i| (i, samples[i].at.to_array())));
        let aimed = |i: usize| (samples[i].flat + samples[i].beside).to_array();
        let flat = Cells::of(side_step / scale, order.iter().map(|&i| (i, aimed(i))));
        let rank = order.iter().enumerate().map(|(rank, &i)| (i, rank)).collect();
        let most = order.first().map_or(0.0, |&i| heights[i]);
        Self { order, most, rank, done: 0, in_space, flat }
    }

    /// The highest at first of those that are left.
    pub(super) fn worst(&mut self) -> Option<usize> {
        while let Some(i) = self.order.get(self.done) {
            if self.rank.contains_key(i) {
                return Some(*i);
            }
            self.done += 1;
        }
        None
    }

    /// The greatest height at first, mm.
    pub(super) fn most(&self) -> f64 {
        self.most
    }

    /// Leaves one out.
    pub(super) fn remove(&mut self, sample: usize) {
        self.rank.remove(&sample);
    }

    /// Those that may lie within a box, mm, in order.
    pub(super) fn within(&self, low: DVec3, high: DVec3) -> Vec<usize> {
        self.in_order(self.in_space.within(low.to_array(), high.to_array()))
    }

    /// Those that may aim at places less than `radius` from a flat place, flat mm, and one of them besides, in order.
    pub(super) fn within_flat(&self, at: DVec2, radius: f64, besides: usize) -> Vec<usize> {
        let around = |by: f64| (at + DVec2::splat(by)).to_array();
        let mut near = self.flat.within(around(-radius), around(radius));
        near.iter_mut().for_each(|near| near.push(besides));
        self.in_order(near)
    }

    /// Those of some, or all, that are left, in order.
    fn in_order(&self, some: Option<Vec<usize>>) -> Vec<usize> {
        let Some(some) = some else {
            let left = |i: &usize| self.rank.contains_key(i);
            return self.order[self.done..].iter().copied().filter(left).collect();
        };
        let mut ranks: Vec<usize> = some.iter().filter_map(|i| self.rank.get(i)).copied().collect();
        ranks.order_total();
        ranks.dedup();
        ranks.into_iter().map(|rank| self.order[rank]).collect()
    }
}
