//! Everything that the cutter must keep clear of: the part, with its allowance, and walls.

use super::check_mesh::CheckMesh;
use super::ruling::{Pushed, Ruling, Rulings};
use crate::geometry::DVec3;
use crate::tool::Tool;
use std::sync::Arc;

/// Rounds in which the cutter is lifted out of the part and out of walls in turn.
const MOST_ROUNDS: usize = 8;

/// The first fraction of the way down that is tested.
const FIRST_DROP: f64 = 0.125;

/// The part and the walls beside it.
#[derive(Clone, Debug)]
pub struct Obstacles {
    part: Arc<CheckMesh>,
    walls: CheckMesh,
    rulings: Rulings,
}

/// A cutter in place, for a query.
#[derive(Copy, Clone, Debug)]
pub struct Standing {
    /// The cutter.
    pub tool: Tool,
    /// Its tip, mm.
    pub tip: DVec3,
    /// Unit axis.
    pub axis: DVec3,
    /// Length above the tip that must be clear, mm; may be infinite.
    pub reach: f64,
}

impl Standing {
    /// The same cutter moved along its axis, mm.
    pub fn lifted(self, by: f64) -> Self {
        Self { tip: self.tip + self.axis * by, ..self }
    }

    /// Whether a place lies in the cutter.
    pub fn contains(&self, place: DVec3) -> bool {
        let way = place - self.tip;
        let height = way.dot(self.axis);
        let (radius, round) = (self.tool.radius(), self.tool.corner_radius());
        let lack = (round - height).max(0.0);
        let wide = radius - round + (round * round - lack * lack).max(0.0).sqrt();
        let across = way.reject_from_normalized(self.axis).length_squared();
        (0.0..=self.reach).contains(&height) && across <= wide * wide
    }

    /// The cutter offset outward on all sides (inward if negative), mm; `None` where nothing is left.
    pub fn grown(self, growth: f64) -> Option<Self> {
        let radius = self.tool.radius() + growth;
        let corner = (self.tool.corner_radius() + growth).max(0.0);
        let tool = Tool::new(radius, corner.min(radius)).ok()?;
        Some(Self { tool, ..self.lifted(-growth) })
    }
}

impl Obstacles {
    /// A part without walls.
    pub fn of_part(part: CheckMesh) -> Self {
        Self { part: part.into(), walls: CheckMesh::nothing(), rulings: Rulings::default() }
    }

    /// A part with walls: as facets, and as rulings off which the cutter is pushed.
    pub fn with_walls(part: Arc<CheckMesh>, walls: CheckMesh, rulings: Vec<Ruling>) -> Self {
        Self { part, walls, rulings: Rulings::new(rulings) }
    }

    /// The walls alone.
    pub fn without_part(&self) -> Self {
        Self { part: CheckMesh::nothing().into(), ..self.clone() }
    }

    /// The walls to push the cutter off.
    pub fn rulings(&self) -> &Rulings {
        &self.rulings
    }

    /// How far the cutter must be lifted to clear the part, with `allowance` mm left on it, and the walls, mm.
    pub fn raise(&self, at: Standing, allowance: f64) -> f64 {
        let Some(grown) = at.grown(allowance) else { return 0.0 };
        let mut raise = 0.0;
        for _ in 0..MOST_ROUNDS {
            let of = |mesh: &CheckMesh, s: Standing| mesh.raise(&s.tool, s.tip, s.axis, s.reach);
            raise += of(&self.part, grown.lifted(raise));
            let more = of(&self.walls, at.lifted(raise));
            raise += more;
            if more == 0.0 {
                break;
            }
        }
        raise
    }

    /// Whether the cutter penetrates part (with `allowance` mm left on it) and walls by less than `depth` mm, measured
    /// along the normal.
    pub fn is_clear(&self, at: Standing, allowance: f64, depth: f64) -> bool {
        let clears = |mesh: &CheckMesh, growth: f64| {
            at.grown(growth).is_none_or(|s| mesh.is_clear(&s.tool, s.tip, s.axis, s.reach))
        };
        clears(&self.part, allowance - depth) && clears(&self.walls, -depth)
    }

    /// The cutter moved across its axis until it just touches the walls that it penetrated; `None` where it does not
    /// fit.
    pub fn pushed(&self, at: Standing) -> Option<Pushed> {
        if self.rulings.is_empty() {
            return Some(Pushed { tip: at.tip, away: None });
        }
        self.rulings.push(&at.tool, at.tip, at.axis, at.reach)
    }

    /// The cutter lowered, or lifted, along its axis until it rests on the part; unchanged if the part is not within
    /// `below` mm beneath it.
    pub fn dropped(&self, at: Standing, allowance: f64, below: f64) -> DVec3 {
        let Some(grown) = at.grown(allowance) else { return at.tip };
        // Most surfaces lie little lower; from far below more of the part stands in the way.
        let mut down = FIRST_DROP * below;
        loop {
            let low = grown.lifted(-down);
            let raise = self.part.raise(&low.tool, low.tip, low.axis, low.reach + down);
            if raise > 0.0 {
                return at.tip + at.axis * (raise - down);
            }
            if down >= below {
                return at.tip;
            }
            down = (2.0 * down).min(below);
        }
    }
}
