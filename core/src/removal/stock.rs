//! The material before a cut: a layer over the surface, less what earlier paths removed of it.

use super::body::{Body, Cutter, Layer};
use super::columns::Columns;
use super::remains::{Stage, Strokes};
use super::sweep::BlockCut;
use crate::parallel;
use crate::tool::Tool;
use crate::toolpath::Toolpath;
use std::sync::Arc;

/// The material that an operation meets.
#[derive(Clone, Debug, Default)]
pub struct Stock {
    /// Height of its upper side over the surface before any cut, mm.
    pub top: f64,
    /// By how much it may be higher where a cutter bridged the part, mm.
    pub bridged: f64,
    /// The paths that have cut it, in their order.
    pub earlier: Vec<Arc<Earlier>>,
}

/// A path that has cut the material already.
#[derive(Clone, Debug)]
pub struct Earlier {
    /// The path.
    pub path: Toolpath,
    /// Its cutter.
    pub cutter: Cutter,
    /// How high it may leave cusps over its own allowance, mm.
    pub cusps: f64,
    /// Its allowance, mm.
    pub allowance: f64,
    /// How far at most the part lies under the surface that it was planned on, mm: where its cutter bridged the part.
    pub bridged: f64,
}

/// Strokes that cut the material before.
#[derive(Debug, Default)]
pub(crate) struct Before(Vec<(Strokes, Cutter)>);

impl Stock {
    /// Material of which nothing has been cut; `top`: the height of its upper side over the surface, mm.
    pub fn fresh(top: f64) -> Self {
        Self { top, bridged: 0.0, earlier: Vec::new() }
    }

    /// What is left after a further path.
    pub fn after(mut self, path: Earlier) -> Self {
        self.bridged = self.bridged.max(path.bridged);
        self.earlier.push(path.into());
        self
    }

    /// How high over the allowance of an operation cusps of earlier ones may stand, mm.
    pub fn allowed(&self, allowance: f64) -> f64 {
        let above = |e: &Arc<Earlier>| e.allowance + e.cusps - allowance;
        self.earlier.iter().map(above).reduce(f64::min).unwrap_or(f64::INFINITY)
    }

    /// The strokes that have cut it.
    pub(crate) fn strokes(&self) -> Before {
        let of = |e: &Arc<Earlier>| (Strokes::of(&e.path, &e.cutter.tool), e.cutter);
        Before(self.earlier.iter().map(of).collect())
    }
}

impl Before {
    /// These strokes, after those of a path.
    pub fn with<'a>(&'a self, strokes: &'a Strokes, tool: Tool, length: f64) -> Vec<Stage<'a>> {
        let own = Stage { strokes, cutter: Cutter { tool, length } };
        core::iter::once(own).chain(self.stages()).collect()
    }

    /// These strokes alone.
    pub fn stages(&self) -> impl Iterator<Item = Stage<'_>> {
        self.0.iter().map(|(strokes, cutter)| Stage { strokes, cutter: *cutter })
    }
}

impl Columns {
    /// The columns as earlier cuts leave them.
    pub(crate) fn cut_before(mut self, before: &Before, layer: Layer, threads: usize) -> Self {
        for Stage { strokes, cutter } in before.stages() {
            let body = Body::new(cutter, layer, self.spacing);
            let heights = parallel::map(threads, &self.blocks, |block| {
                let heights = block.heights.clone();
                let mut work = BlockCut::new(block, &body, heights, f64::NEG_INFINITY);
                work.run_on_tiles(strokes.all(), strokes.runs());
                work.heights
            });
            for (block, heights) in self.blocks.iter_mut().zip(heights) {
                block.heights = heights;
            }
        }
        self
    }
}
