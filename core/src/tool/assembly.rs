//! The cutter with all that turns with it: shank and holder.

use super::cutter::Tool;

/// Which part of an assembly it is.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum AssemblyPart {
    /// The cutting end.
    Cutter,
    /// What the cutter is made on, up to the holder.
    Shank,
    /// What holds the shank.
    Holder,
}

impl AssemblyPart {
    /// Its name in reports and messages.
    pub fn name(self) -> &'static str {
        match self {
            Self::Cutter => "cutter",
            Self::Shank => "shank",
            Self::Holder => "holder",
        }
    }
}

/// A cylinder or a cone about the tool axis.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Section {
    /// Shank or holder.
    pub part: AssemblyPart,
    /// Heights above the tip at which it begins and ends, mm, rising.
    pub heights: [f64; 2],
    /// Its radii there, mm.
    pub radii: [f64; 2],
}

/// A cutter, and the sections above it.
#[derive(Clone, Debug, PartialEq)]
pub struct Assembly {
    /// The cutter.
    pub tool: Tool,
    /// Height above the tip to which the cutter reaches, mm, at least its corner radius.
    pub cutter_length: f64,
    /// Shank and holder, from the cutter upward.
    pub sections: Vec<Section>,
}

impl Assembly {
    /// A cutter alone.
    pub fn of_cutter(tool: Tool, cutter_length: f64) -> Self {
        Self { tool, cutter_length, sections: Vec::new() }
    }

    /// Height of the whole assembly above the tip, mm.
    pub fn height(&self) -> f64 {
        self.sections.iter().fold(self.cutter_length, |top, s| top.max(s.heights[1]))
    }

    /// Largest radius of the whole assembly, mm.
    pub fn largest_radius(&self) -> f64 {
        let radii = self.sections.iter().flat_map(|s| s.radii);
        radii.fold(self.tool.radius(), f64::max)
    }
}
