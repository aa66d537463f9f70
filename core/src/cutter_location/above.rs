//! What is above the cutting end, where it must not touch: the cutter's side, shank and holder.
//!
//! - *Wide*: a section that is wider than the cutter somewhere; it keeps a distance.
//! - *Slim*: the cutter's own side and sections that are not wider; they may touch.
//! - *Room*: by how much more than wanted the wide sections are away from everything, mm; negative where one is too
//!   near, at most [`AMPLE`].

use super::clearance::{Hindrance, Pose, Solid, above_end};
use crate::geometry::DVec3;
use crate::tool::{Assembly, AssemblyPart};

/// Room that is not told from more, mm. Larger: slower to measure, but fewer places between two.
const AMPLE: f64 = 8.0;
/// Share by which a section that is as wide as the cutter may seem wider.
const ROUNDING: f64 = 1e-9;

/// Triangles, and the distances that the tool keeps from them.
#[derive(Clone, Debug)]
pub struct KeptClear {
    /// The triangles.
    pub hindrance: Hindrance,
    /// Distance of wide sections, mm.
    pub wide: f64,
    /// Distance of the cutter's side and of slim sections, mm; negative: how deep they may be in it.
    pub slim: f64,
}

/// Shank and holder, the cutter's side, and what they keep clear of.
#[derive(Clone, Debug)]
pub struct AboveEnd {
    wide: Vec<Solid>,
    slim: Vec<Solid>,
    kept: Vec<KeptClear>,
    height: f64,
}

impl AboveEnd {
    /// Of an assembly.
    pub fn new(assembly: &Assembly, kept: Vec<KeptClear>) -> Self {
        let least = assembly.tool.radius() * (1.0 + ROUNDING);
        let is_wide = |s: &Solid| s.part != AssemblyPart::Cutter && s.largest_radius() > least;
        let (wide, slim) = above_end(assembly).into_iter().partition(is_wide);
        Self { wide, slim, kept, height: assembly.height() }
    }

    /// Height of the whole assembly, mm.
    pub fn height(&self) -> f64 {
        self.height
    }

    /// The room of a tool with this tip and axis. Where there is none, how much is missing may not be all.
    pub fn room(&self, tip: DVec3, axis: DVec3) -> f64 {
        let pose = Pose { tip, axis };
        let mut room = AMPLE;
        for KeptClear { hindrance, wide, .. } in &self.kept {
            for solid in &self.wide {
                if let Some(near) = hindrance.nearest(solid, pose, wide + room, *wide) {
                    room = near.distance - wide;
                }
                if room < 0.0 {
                    return room;
                }
            }
        }
        room
    }

    /// Whether the cutter's side and slim sections are clear, where they may be `deeper` mm deeper than elsewhere.
    pub fn is_slim_clear(&self, tip: DVec3, axis: DVec3, deeper: f64) -> bool {
        let pose = Pose { tip, axis };
        self.kept.iter().all(|KeptClear { hindrance, slim, .. }| {
            let wanted = slim - deeper;
            self.slim.iter().all(|solid| hindrance.nearest(solid, pose, wanted, wanted).is_none())
        })
    }

    /// Whether wide sections stay clear while the tool moves away along its axis, up by `height` mm.
    pub fn is_way_out_clear(&self, tip: DVec3, axis: DVec3, height: f64) -> bool {
        let pose = Pose { tip, axis };
        let swept: Vec<Solid> = self.wide.iter().map(|solid| solid.drawn_up(height)).collect();
        self.kept.iter().all(|KeptClear { hindrance, wide, .. }| {
            swept.iter().all(|solid| hindrance.nearest(solid, pose, *wide, *wide).is_none())
        })
    }
}
