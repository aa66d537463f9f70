//! The material over a sample of the part: its height before the cut, and what is left of it.

use super::samples::Sample;

/// Assumptions about material and cutter.
#[derive(Copy, Clone, Debug)]
pub struct Material {
    /// Height of the stock above the surface where it is machined, mm.
    pub height: f64,
    /// Height above which no cut has reached the surface, mm: what bridged it is no cut of it.
    pub layer: f64,
    /// Allowance left where it is machined, mm.
    pub allowance: f64,
    /// Gouges deeper than this are reported with this depth, mm.
    pub deepest: f64,
    /// A cutter that is nowhere deeper in the part than this touches it, mm.
    pub tolerance: f64,
}

/// A sample after the sweep.
#[derive(Copy, Clone, Debug)]
pub struct Swept {
    /// The sample.
    pub sample: Sample,
    /// Height left above the surface along the normal, mm; negative in a gouge.
    pub height: f64,
    /// Mean height left over its cell, for the volume, mm.
    pub left: f64,
    /// The basis of that mean.
    pub(super) cell: Cell,
    /// The move that left it, `None` where no move reached it.
    pub by: Option<u32>,
    /// Whether an earlier cut reached it.
    pub cut_before: bool,
    /// The move that took the upper half of the stock.
    pub opened_by: Option<u32>,
    /// The last rapid that reached it, and the height it found, mm.
    pub(super) rapid: Option<(u32, f32)>,
}

/// The basis of the mean height over a sample's cell.
#[derive(Copy, Clone, Debug, PartialEq)]
pub(super) enum Cell {
    /// The sample's line: no wall of the cutter is in the material. This is also used on any step to whose axis the
    /// line is inclined, as on steep places.
    Line,
    /// A wall that has not yet passed over the whole cell.
    Open,
    /// The line through its centroid.
    Covered,
}

impl Swept {
    /// A sample before the sweep; `walled`: whether a wall of the cutter is in the material.
    pub fn new(sample: Sample, walled: bool, material: Material) -> Self {
        let height = if sample.machined { material.height } else { 0.0 };
        let by_parts = walled && sample.machined && sample.section.area > 0.0;
        let cell = if by_parts { Cell::Open } else { Cell::Line };
        Self {
            sample,
            height,
            left: height,
            cell,
            by: None,
            cut_before: false,
            opened_by: None,
            rapid: None,
        }
    }

    /// The sample for a later cut. Where this one has left less than the whole stock, the volume is measured on the
    /// sample's line. What it has cut into the part was said of it, and is no cut of the later one.
    pub fn for_next(self, walled: bool, material: Material) -> Self {
        let is_whole = !self.sample.machined || self.height >= material.height;
        if !self.is_cut() && is_whole {
            return Self::new(self.sample, walled, material);
        }
        let floor = if self.sample.machined { material.allowance } else { 0.0 };
        let height = self.height.max(floor);
        Self {
            height,
            left: height,
            cell: Cell::Line,
            by: None,
            cut_before: self.is_cut() && self.height < material.layer,
            opened_by: None,
            rapid: None,
            ..self
        }
    }

    /// Whether any cut reached it.
    pub fn is_cut(&self) -> bool {
        self.by.is_some() || self.cut_before
    }
}
