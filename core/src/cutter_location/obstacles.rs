//! Everything that the cutter must keep clear of: the part, with its allowance, walls, and what it keeps a distance from.
//!
//! A distance is kept by a cutter that is larger by it on all sides and just touches.

use super::above::AboveEnd;
use super::check_mesh::CheckMesh;
use super::ruling::{Pushed, Ruling, Rulings};
use super::standing::Standing;
use crate::geometry::DVec3;
use std::sync::Arc;

/// Rounds in which the cutter is lifted out of the part and out of walls in turn.
const MOST_ROUNDS: usize = 8;

/// The first fraction of the way down that is tested.
const FIRST_DROP: f64 = 0.125;

/// A mesh that the cutter keeps a distance from.
#[derive(Clone, Debug)]
pub struct Avoided {
    /// Its facets.
    pub mesh: CheckMesh,
    /// The distance, mm.
    pub distance: f64,
}

/// The part, the walls beside it and what is avoided.
#[derive(Clone, Debug)]
pub struct Obstacles {
    part: Arc<CheckMesh>,
    walls: CheckMesh,
    avoided: Vec<Avoided>,
    rulings: Rulings,
    above: Option<Arc<AboveEnd>>,
}

impl Obstacles {
    /// A part without walls.
    pub fn of_part(part: CheckMesh) -> Self {
        let rulings = Rulings::default();
        Self {
            part: part.into(),
            walls: CheckMesh::nothing(),
            avoided: Vec::new(),
            rulings,
            above: None,
        }
    }

    /// A part with walls and what is avoided: as facets, and as rulings of both off which the cutter is pushed.
    pub fn with_walls(
        part: Arc<CheckMesh>,
        walls: CheckMesh,
        avoided: Vec<Avoided>,
        rulings: Vec<Ruling>,
    ) -> Self {
        Self { part, walls, avoided, rulings: Rulings::new(rulings), above: None }
    }

    /// The same, and what is above the cutting end, for which the axis is tilted.
    pub fn with_above(self, above: AboveEnd) -> Self {
        Self { above: Some(above.into()), ..self }
    }

    /// What is above the cutting end, if the axis is tilted for it.
    pub fn above(&self) -> Option<&AboveEnd> {
        self.above.as_deref()
    }

    /// The walls and what is avoided alone.
    pub fn without_part(&self) -> Self {
        Self { part: CheckMesh::nothing().into(), ..self.clone() }
    }

    /// The walls to push the cutter off.
    pub fn rulings(&self) -> &Rulings {
        &self.rulings
    }

    /// How far the cutter must be lifted to clear the part, with `allowance` mm left on it, the walls, and what is avoided
    /// by its distance, mm.
    pub fn raise(&self, at: Standing, allowance: f64) -> f64 {
        self.raise_within(at, allowance, 0.0)
    }

    /// How far the cutter must be lifted until [`is_clear`](Self::is_clear) holds for `depth`, mm.
    pub fn raise_within(&self, at: Standing, allowance: f64, depth: f64) -> f64 {
        let of = |mesh: &CheckMesh, s: Option<Standing>| {
            s.map_or(0.0, |s| mesh.raise(&s.tool, s.tip, s.axis, s.reach))
        };
        let mut raise = 0.0;
        for _ in 0..MOST_ROUNDS {
            raise += of(&self.part, at.lifted(raise).grown(allowance - depth));
            let mut more = of(&self.walls, at.lifted(raise).grown(-depth));
            for Avoided { mesh, distance } in &self.avoided {
                more += of(mesh, at.lifted(raise + more).away(*distance, depth));
            }
            raise += more;
            if more == 0.0 {
                break;
            }
        }
        raise
    }

    /// Whether the cutter penetrates part (with `allowance` mm left on it), walls and the distance of what is avoided by
    /// less than `depth` mm, measured along the normal.
    pub fn is_clear(&self, at: Standing, allowance: f64, depth: f64) -> bool {
        let clears = |mesh: &CheckMesh, grown: Option<Standing>| {
            grown.is_none_or(|s| mesh.is_clear(&s.tool, s.tip, s.axis, s.reach))
        };
        clears(&self.part, at.grown(allowance - depth))
            && clears(&self.walls, at.grown(-depth))
            && self.avoided.iter().all(|a| clears(&a.mesh, at.away(a.distance, depth)))
    }

    /// The cutter, on level ground or not, moved across its axis until it just touches the walls that it penetrated;
    /// `None` where it does not fit.
    pub fn pushed(&self, at: Standing, is_level: bool) -> Option<Pushed> {
        if self.rulings.is_empty() {
            return Some(Pushed { tip: at.tip, away: None });
        }
        self.rulings.push(&at, is_level)
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tool::Tool;

    /// A box from 10 mm on along X, 4 mm high, over a floor that is far below.
    fn clamp() -> (Vec<DVec3>, Vec<[u32; 3]>) {
        let place = |x: f64, y: f64, z: f64| DVec3::new(x, y, z);
        let positions = [(10.0, -9.0), (30.0, -9.0), (30.0, 9.0), (10.0, 9.0)];
        let positions = positions.iter().map(|&(x, y)| place(x, y, 4.0));
        let low = [place(10.0, -9.0, -4.0), place(10.0, 9.0, -4.0)];
        (positions.chain(low).collect(), vec![[0, 1, 2], [0, 2, 3], [0, 3, 5], [0, 5, 4]])
    }

    fn avoiding(distance: f64) -> Obstacles {
        let (positions, faces) = clamp();
        let rulings = (0..=360).map(|i| {
            let from = DVec3::new(10.0, -9.0 + f64::from(i) * 0.05, -4.0);
            let to = from.with_z(4.0);
            Ruling {
                from,
                to,
                inward: DVec3::NEG_X,
                allowance: distance,
                clears_behind: false,
                beside_level: false,
            }
        });
        let avoided = vec![Avoided { mesh: CheckMesh::new(positions, faces), distance }];
        let (part, walls) = (CheckMesh::nothing().into(), CheckMesh::nothing());
        Obstacles::with_walls(part, walls, avoided, rulings.collect())
    }

    fn standing(tool: Tool, x: f64, z: f64) -> Standing {
        Standing { tool, tip: DVec3::new(x, 0.0, z), axis: DVec3::Z, reach: f64::INFINITY }
    }

    /// The place of a ball from which the edge of the box, 4 mm up, is so far away: `sqrt((R + d)² - (R - 4)²)` aside.
    #[test]
    fn a_ball_keeps_its_distance_from_an_edge() {
        let ball = Tool::new(5.0, 5.0).unwrap();
        for distance in [0.0, 0.7, 3.0] {
            let obstacles = avoiding(distance);
            let aside = ((5.0 + distance) * (5.0 + distance) - 1.0f64).sqrt();
            let at = |x: f64| standing(ball, x, 0.0);
            assert!(obstacles.is_clear(at(10.0 - aside - 1e-4), 0.0, 0.0), "{distance}");
            assert!(!obstacles.is_clear(at(10.0 - aside + 1e-4), 0.0, 0.0), "{distance}");
            assert!(obstacles.is_clear(at(10.0 - aside + 1e-4), 0.0, 0.01), "{distance}");
            let pushed = obstacles.pushed(at(9.0), false).unwrap().tip;
            assert!((pushed.x - (10.0 - aside)).abs() < 1e-4, "{distance}: {pushed}");
        }
    }

    #[test]
    fn a_flat_end_is_lifted_by_its_distance_over_a_box() {
        let flat = Tool::new(5.0, 0.0).unwrap();
        for distance in [0.0, 0.7] {
            let raise = avoiding(distance).raise(standing(flat, 20.0, -1.0), 0.0);
            assert!((raise - (5.0 + distance)).abs() < 1e-5, "{distance}: {raise}");
            let beside = standing(flat, 5.0 - distance - 1e-3, -1.0);
            assert_eq!(avoiding(distance).raise(beside, 0.0), 0.0);
        }
    }

    /// Below a roof, the end of a short cutter is clear of it by the distance, too.
    #[test]
    fn the_upper_end_keeps_its_distance() {
        let roof = [(-9.0, -9.0), (9.0, -9.0), (0.0, 9.0)].map(|(x, y)| DVec3::new(x, y, 20.0));
        let mesh = CheckMesh::new(roof.to_vec(), vec![[0, 1, 2]]);
        let (part, walls) = (CheckMesh::nothing().into(), CheckMesh::nothing());
        let avoided = vec![Avoided { mesh, distance: 2.0 }];
        let obstacles = Obstacles::with_walls(part, walls, avoided, Vec::new());
        let flat = Tool::new(3.0, 0.0).unwrap();
        let at = |reach: f64| Standing { reach, ..standing(flat, 0.0, 0.0) };
        assert!(obstacles.is_clear(at(17.9), 0.0, 0.0));
        assert!(!obstacles.is_clear(at(18.1), 0.0, 0.0));
    }
}
