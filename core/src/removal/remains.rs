//! What a path leaves above a height, without recording where it removes what.
//!
//! Nearly every column is cut down by the moves that end nearest to it in the chart, of its own pass or of those beside
//! it. 1. These are tested on it. 2. Only columns that still stand are swept by the whole path, in time order, as in
//! [`Columns::cut`].

use super::body::{Body, Cutter, Layer, Stroke};
use super::columns::{Block, Columns};
use super::sweep::{BlockCut, Runs, cut_to_pieces};
use crate::geometry::DVec2;
use crate::parallel;
use crate::tool::Tool;
use crate::toolpath::{PathPoint, Toolpath};

/// Pieces before and behind the nearest one that are tested. Fewer: more columns are left to the sweep; more: slower.
const BESIDE: usize = 4;
/// Passes of which the nearest pieces are tested: a column between passes is cut down by its own or by one of those
/// beside it. Fewer, more: as above.
const PASSES: usize = 3;
/// Pieces farther than this from others in the order of the path count as another pass's.
const APART: u32 = 16;
/// Ends of pieces in a leaf of the tree over them.
const LEAF: usize = 8;

/// Flat places where pieces end, searchable by distance.
#[derive(Debug)]
struct Ends {
    /// Flat place and piece; the middle one of every range divides the others, alternately by its first and its
    /// second coordinate.
    ends: Vec<(DVec2, u32)>,
}

impl Ends {
    /// `at`: the piece of the path that each stroke is.
    fn new(
        points: &[PathPoint],
        first: &[usize],
        at: &[usize],
        parts: impl Fn(usize) -> f64,
    ) -> Self {
        let mut ends = Vec::with_capacity(at.len());
        let mut point = 0;
        for (stroke, &piece) in at.iter().enumerate() {
            while first[point + 1] <= piece {
                point += 1;
            }
            let (from, to) = (points[point - 1].flat, points[point].flat);
            let part = parts(piece);
            let place = match (from, to) {
                (Some(from), Some(to)) => Some(from.lerp(to, part)),
                (None, Some(to)) if part >= 1.0 => Some(to),
                _ => None,
            };
            ends.extend(place.map(|place| (place, stroke as u32)));
        }
        sort(&mut ends, 0);
        Self { ends }
    }

    /// The piece that ends nearest to a place, of those that are not near to some others in the order of the path.
    fn nearest(&self, at: DVec2, others: &[usize]) -> Option<usize> {
        let mut best = (f64::INFINITY, 0);
        search(&self.ends, 0, at, others, &mut best);
        best.0.is_finite().then_some(best.1 as usize)
    }
}

fn sort(ends: &mut [(DVec2, u32)], axis: usize) {
    if ends.len() <= LEAF {
        return;
    }
    let middle = ends.len() / 2;
    ends.select_nth_unstable_by(middle, |a, b| a.0[axis].total_cmp(&b.0[axis]).then(a.1.cmp(&b.1)));
    let (before, after) = ends.split_at_mut(middle);
    sort(before, 1 - axis);
    sort(&mut after[1..], 1 - axis);
}

fn search(ends: &[(DVec2, u32)], axis: usize, at: DVec2, others: &[usize], best: &mut (f64, u32)) {
    let look = |(place, stroke): &(DVec2, u32), best: &mut (f64, u32)| {
        let square = place.distance_squared(at);
        let is_other = || others.iter().all(|&o| stroke.abs_diff(o as u32) > APART);
        if (square, *stroke) < *best && is_other() {
            *best = (square, *stroke);
        }
    };
    if ends.len() <= LEAF {
        ends.iter().for_each(|end| look(end, best));
        return;
    }
    let (before, after) = ends.split_at(ends.len() / 2);
    let side = at[axis] - after[0].0[axis];
    let (near, far) = if side < 0.0 { (before, &after[1..]) } else { (&after[1..], before) };
    search(near, 1 - axis, at, others, best);
    if side * side <= best.0 {
        look(&after[0], best);
        search(far, 1 - axis, at, others, best);
    }
}

/// The strokes of a path, so arranged that those near a place are found.
#[derive(Debug)]
pub(crate) struct Strokes {
    all: Vec<Stroke>,
    ends: Ends,
    runs: Runs,
}

impl Strokes {
    /// Those of a path of a cutter.
    pub fn of(path: &Toolpath, tool: &Tool) -> Self {
        let (removed, all, at) = cut_to_pieces(&path.points, tool);
        let parts = |piece: usize| removed.pieces[piece].end;
        let ends = Ends::new(&path.points, &removed.first, &at, parts);
        let runs = Runs::of(&all);
        Self { all, ends, runs }
    }

    pub(super) fn all(&self) -> &[Stroke] {
        &self.all
    }

    pub(super) fn runs(&self) -> &Runs {
        &self.runs
    }
}

/// Strokes of a path and the cutter that makes them.
#[derive(Copy, Clone)]
pub(crate) struct Stage<'a> {
    pub strokes: &'a Strokes,
    pub cutter: Cutter,
}

impl Columns {
    /// The heights that the strokes of some cutters leave on the columns, mm, block by block: exact where they are above
    /// `enough` mm, and at most that elsewhere. Which piece removes what is not recorded.
    pub(crate) fn remains(
        &self,
        stages: &[Stage],
        layer: Layer,
        enough: f64,
        threads: usize,
    ) -> Vec<Vec<f64>> {
        let body = |stage: &Stage| {
            // No rate is asked for: the wall of a leaned flat end, if smeared, would count as left.
            let is_sharp = stage.cutter.tool.corner_radius() == 0.0;
            Body::new(stage.cutter, layer, if is_sharp { 0.0 } else { self.spacing })
        };
        let bodies: Vec<Body> = stages.iter().map(body).collect();
        parallel::map(threads, &self.blocks, |block| {
            let cut = |heights, (Stage { strokes, .. }, body): (&Stage, &Body)| {
                let heights = tried(block, body, strokes, heights, enough);
                let mut work = BlockCut::new(block, body, heights, enough);
                work.run_on_tiles(&strokes.all, &strokes.runs);
                work.heights
            };
            stages.iter().zip(&bodies).fold(block.heights.clone(), cut)
        })
    }
}

/// The heights of a block's columns after the nearest pieces; `heights`: those before.
fn tried(
    block: &Block,
    body: &Body,
    strokes: &Strokes,
    mut heights: Vec<f64>,
    enough: f64,
) -> Vec<f64> {
    let Strokes { all, ends, .. } = strokes;
    // Whether the pieces beside one cut a column down far enough.
    let lower = |column: usize, height: &mut f64, nearest: usize| {
        let beside = nearest.saturating_sub(BESIDE)..(nearest + BESIDE + 1).min(all.len());
        let line = &block.columns[column].line;
        all[beside].iter().any(|stroke| {
            *height = body.lowered(stroke, line, *height);
            *height <= enough
        })
    };
    for tile in &block.tiles {
        let columns = tile.first..tile.first + tile.count;
        if heights[columns.clone()].iter().all(|height| *height <= enough) {
            continue;
        }
        let middle = block.flat[columns.clone()].iter().sum::<DVec2>() / tile.count as f64;
        let Some(of_tile) = ends.nearest(middle, &[]) else { continue };
        for column in columns {
            let height = &mut heights[column];
            let mut is_low = *height <= enough || lower(column, height, of_tile);
            let mut near = Vec::with_capacity(PASSES);
            while !is_low && near.len() < PASSES {
                let Some(piece) = ends.nearest(block.flat[column], &near) else { break };
                is_low = lower(column, height, piece);
                near.push(piece);
            }
        }
    }
    heights
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nearest_end_is_found() {
        let place = |i: u32| DVec2::new(f64::from(i * 7919 % 1013), f64::from(i * 104_729 % 997));
        let mut all: Vec<(DVec2, u32)> = (0..700).map(|i| (place(i), i)).collect();
        sort(&mut all, 0);
        let ends = Ends { ends: all.clone() };
        for i in 0..300 {
            let at = place(i + 5000) + DVec2::new(0.3, 0.1);
            let distance = |e: &(DVec2, u32)| e.0.distance_squared(at);
            let nearest = all.iter().min_by(|a, b| distance(a).total_cmp(&distance(b))).unwrap();
            let found = ends.nearest(at, &[]).unwrap();
            assert_eq!(place(found as u32).distance(at), nearest.0.distance(at));
        }
        assert_eq!(Ends { ends: Vec::new() }.nearest(DVec2::ZERO, &[]), None);
    }
}
