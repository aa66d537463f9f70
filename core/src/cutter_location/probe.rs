//! One cutter tested at a place: moved off walls, lowered onto the part, or lifted clear of both.

use super::axis::tool_axis;
use super::obstacles::Obstacles;
use super::options::PassOptions;
use super::standing::Standing;
use super::tip::{is_level, tip};
use crate::geometry::{DVec3, any_perpendicular};
use crate::tool::Tool;

/// How much lower the part may lie beside a wall, as a multiple of the distance by which the cutter is moved off it:
/// slopes up to 80 degrees.
const BELOW: f64 = 6.0;
/// Fraction of the tolerance by which a cutter beside a wall may penetrate it: between rulings it is an eighth.
const AT_WALL: f64 = 0.2;
/// Raise, tolerances, above which a cutter that is in a steep wall by little is moved aside instead.
const WORTH_ASIDE: f64 = 4.0;
/// How far it is moved aside at most, cutter radii, and tolerances: facets and chords of rounded walls are off by that.
const FARTHEST_ASIDE: (f64, f64) = (0.02, 2.0);
/// Halvings of the distance aside, once one is found that suffices.
const ASIDE_HALVINGS: u32 = 2;
/// Directions aside, turned from the one out of the surface, as cosine and sine.
const ASIDE: [(f64, f64); 8] = [
    (1.0, 0.0),
    (DIAGONAL, DIAGONAL),
    (DIAGONAL, -DIAGONAL),
    (0.0, 1.0),
    (0.0, -1.0),
    (-DIAGONAL, DIAGONAL),
    (-DIAGONAL, -DIAGONAL),
    (-1.0, 0.0),
];
const DIAGONAL: f64 = core::f64::consts::FRAC_1_SQRT_2;

/// Position of the cutter instead of the intended one.
pub(super) struct Placed {
    pub tip: DVec3,
    /// How far it was lifted.
    pub raise: f64,
    /// Whether it is clear of everything.
    pub is_free: bool,
    /// Direction out of the wall off which it was moved, unit.
    pub away: Option<DVec3>,
}

/// The cutter as it is tested against the part and the walls.
pub(super) struct Probe<'a> {
    pub obstacles: &'a Obstacles,
    pub tool: Tool,
    pub allowance: f64,
    pub tolerance: f64,
    pub reach: f64,
}

impl<'a> Probe<'a> {
    pub fn new(options: &PassOptions, obstacles: &'a Obstacles) -> Self {
        let PassOptions { tool, allowance, tolerance, reach, .. } = *options;
        Self { obstacles, tool, allowance, tolerance, reach }
    }

    fn standing(&self, tip: DVec3, axis: DVec3) -> Standing {
        Standing { tool: self.tool, tip, axis, reach: self.reach }
    }

    /// Whether the cutter penetrates by less than `depth`, measured along the normal.
    pub fn clears(&self, tip: DVec3, axis: DVec3, depth: f64) -> bool {
        self.obstacles.is_clear(self.standing(tip, axis), self.allowance, depth)
    }

    /// Whether the cutter penetrates nothing by more than three quarters of the tolerance on the straight way from one
    /// tip and axis to another: between places `s` apart it penetrates a sharp edge by `s²/(8R)` more.
    pub fn is_straight_clear(&self, a: (DVec3, DVec3), b: (DVec3, DVec3)) -> bool {
        let apart = (4.0 * self.tool.radius() * self.tolerance).sqrt();
        let count = (a.0.distance(b.0) / apart).ceil().max(1.0);
        let axis = |u: f64| a.1.lerp(b.1, u).try_normalize().unwrap_or(b.1);
        (1..count as u32)
            .map(|i| f64::from(i) / count)
            .all(|u| self.clears(a.0.lerp(b.0, u), axis(u), 0.25 * self.tolerance))
    }

    /// Position of the cutter intended at `tip` on a surface of unit `normal`: moved off walls and then lowered onto the
    /// part; lifted where it does not fit. Where it is in a steep side of the part by little, and would be lifted over
    /// the whole of it, it is moved aside.
    pub fn placed(&self, tip: DVec3, axis: DVec3, normal: DVec3) -> Placed {
        let pushed = self.obstacles.pushed(self.standing(tip, axis), is_level(normal, axis));
        if let Some(pushed) = pushed
            && pushed.away.is_some()
        {
            let below = BELOW * pushed.tip.distance(tip) + self.tolerance;
            let at = self.standing(pushed.tip, axis);
            // The part's own walls, which it touches, are not to hold it up.
            let slack = AT_WALL * self.tolerance;
            let tip = self.obstacles.dropped(at, self.allowance - slack, below) + axis * slack;
            let tip = tip + axis * self.raise(tip, axis).0;
            if self.clears(tip, axis, 0.25 * self.tolerance) {
                return Placed { tip, raise: 0.0, is_free: true, away: pushed.away };
            }
        }
        let (raise, is_free) = self.raise(tip, axis);
        let is_worth = raise > WORTH_ASIDE * self.tolerance;
        let aside = is_worth.then(|| self.aside(tip, axis, normal)).flatten();
        aside.unwrap_or(Placed { tip: tip + axis * raise, raise, is_free, away: None })
    }

    /// The cutter moved across its axis by the least distance that suffices, if there is one.
    fn aside(&self, tip: DVec3, axis: DVec3, normal: DVec3) -> Option<Placed> {
        let out = normal.reject_from_normalized(axis).try_normalize();
        let out = out.unwrap_or(any_perpendicular(axis));
        let along = axis.cross(out);
        let clears =
            |way: DVec3, by: f64| self.clears(tip + (way + axis) * by, axis, 0.25 * self.tolerance);
        let farthest =
            (FARTHEST_ASIDE.0 * self.tool.radius()).max(FARTHEST_ASIDE.1 * self.tolerance);
        let mut by = 0.5 * self.tolerance;
        while by <= farthest {
            let ways = ASIDE.iter().map(|(c, s)| out * *c + along * *s);
            if let Some(way) = { ways }.find(|way| clears(*way, by)) {
                let mut short = 0.5 * by;
                for _ in 0..ASIDE_HALVINGS {
                    let middle = 0.5 * (short + by);
                    if clears(way, middle) { by = middle } else { short = middle }
                }
                let tip = tip + way * by;
                let (raise, is_free) = self.raise(tip, axis);
                return Some(Placed {
                    tip: tip + axis * raise,
                    raise: raise + by,
                    is_free,
                    away: None,
                });
            }
            by *= 2.0;
        }
        None
    }

    /// The raise, and whether it is sufficient: a small penetration is accepted where removing it would require a
    /// large lift along a wall.
    fn raise(&self, tip: DVec3, axis: DVec3) -> (f64, bool) {
        let (at, slack) = (self.standing(tip, axis), 0.25 * self.tolerance);
        let raise = self.obstacles.raise(at, self.allowance);
        if raise <= 2.0 * slack {
            return (raise, true);
        }
        let least = self.obstacles.raise_within(at, self.allowance, slack);
        let is_along_wall = least == 0.0 || raise - least > BELOW * slack;
        if is_along_wall { (least, false) } else { (raise, true) }
    }
}

/// Whether the cutter may go straight from one tip and axis to another.
pub fn is_way_clear(
    from: (DVec3, DVec3),
    to: (DVec3, DVec3),
    options: &PassOptions,
    obstacles: &Obstacles,
) -> bool {
    Probe::new(options, obstacles).is_straight_clear(from, to)
}

/// How far the cutter must be lifted where it is to touch one contact of a path going along `feed`, mm; infinite
/// where that is impossible: the surface faces away, or the allowance leaves nothing of the cutter.
pub fn raise_at(
    contact: DVec3,
    normal: DVec3,
    feed: DVec3,
    options: &PassOptions,
    obstacles: &Obstacles,
) -> f64 {
    touching(contact, normal, feed, options)
        .map_or(f64::INFINITY, |at| obstacles.raise(at, options.allowance))
}

/// The cutter that is to touch one contact of a path going along `feed`, lifted clear of what obstructs it; `None`
/// where the surface faces away or the allowance leaves nothing of the cutter.
pub fn standing_clear(
    contact: DVec3,
    normal: DVec3,
    feed: DVec3,
    options: &PassOptions,
    obstacles: &Obstacles,
) -> Option<Standing> {
    let at = touching(contact, normal, feed, options)?;
    Some(at.lifted(obstacles.raise(at, options.allowance)))
}

/// The cutter that is to touch one contact of a path going along `feed` and would penetrate a wall: moved off it and
/// lowered onto the part; `None` where no wall obstructs it, or the surface faces away.
pub fn lowest_off_walls(
    contact: DVec3,
    normal: DVec3,
    feed: DVec3,
    options: &PassOptions,
    obstacles: &Obstacles,
) -> Option<Standing> {
    is_in_wall(contact, normal, feed, options, obstacles).then_some(())?;
    let at = touching(contact, normal, feed, options)?;
    let placed = Probe::new(options, obstacles).placed(at.tip, at.axis, normal);
    Some(Standing { tip: placed.tip, ..at })
}

/// Whether the cutter penetrates a wall where it touches one contact of a path going along `feed`.
pub fn is_in_wall(
    contact: DVec3,
    normal: DVec3,
    feed: DVec3,
    options: &PassOptions,
    obstacles: &Obstacles,
) -> bool {
    let rulings = obstacles.rulings();
    touching(contact, normal, feed, options)
        .and_then(|at| rulings.stand(&at, is_level(normal, at.axis)))
        .is_some_and(|stand| stand.depth > 0.25 * options.tolerance)
}

/// The cutter touching a contact of a path going along `feed`, ignoring obstacles; `None` where the surface faces
/// away or the allowance leaves nothing of the cutter.
fn touching(contact: DVec3, normal: DVec3, feed: DVec3, options: &PassOptions) -> Option<Standing> {
    let axis = tool_axis(options.axis, normal, feed);
    let tip = tip(&options.tool, contact, normal, axis, options.allowance);
    let at = Standing { tool: options.tool, tip, axis, reach: options.reach };
    (normal.dot(axis) > 0.0 && at.grown(options.allowance).is_some()).then_some(at)
}
