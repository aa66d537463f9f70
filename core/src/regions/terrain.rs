//! All regions, evaluated at flat points.

use crate::flat_path::Terrain;
use crate::geometry::DVec2;
use crate::level_set::FieldTerrain;
use core::cell::Cell;

/// The terrains of several regions as one; no straight line leads from one region to another.
pub struct JointTerrain<'a> {
    parts: Vec<FieldTerrain<'a>>,
    /// Region of the last query: the next one is usually for the same region.
    last: Cell<usize>,
}

impl<'a> JointTerrain<'a> {
    /// Of the terrains of all regions.
    pub fn new(parts: Vec<FieldTerrain<'a>>) -> Self {
        Self { parts, last: Cell::new(0) }
    }

    /// The first answer, starting with the last region.
    fn ask<T>(&self, question: impl Fn(&FieldTerrain) -> Option<T>) -> Option<T> {
        let last = self.last.get();
        let others = (0..self.parts.len()).filter(|&k| k != last);
        core::iter::once(last).chain(others).find_map(|k| {
            let answer = question(self.parts.get(k)?)?;
            self.last.set(k);
            Some(answer)
        })
    }
}

impl Terrain for JointTerrain<'_> {
    fn scale(&self, at: DVec2) -> Option<f64> {
        self.ask(|part| part.scale(at))
    }

    fn room(&self, at: DVec2) -> Option<f64> {
        self.ask(|part| part.room(at))
    }

    fn joins(&self, from: DVec2, to: DVec2) -> bool {
        self.ask(|part| part.joins(from, to).then_some(())).is_some()
    }
}
