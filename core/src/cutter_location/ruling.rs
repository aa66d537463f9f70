//! Walls beside the cutter: how deep it penetrates them, and where it just touches them.
//!
//! - *Ruling*: a straight line up a wall. Rulings are so close together that between two of them a cutter enters the
//!   wall by an eighth of the tolerance at most (`s²/(8R)`).
//! - *Stand*: how deep the cutter penetrates the worst ruling, and the direction out of it, across the cutter's axis.
//!
//! A cutter is pushed off walls across its axis: out of the worst ruling, then to the nearest place out of that and of the
//! next, and so on. Beside a ruling its end is round; the direction out of it is that from where the cutter is, so that
//! the nearest place is found step by step.

use super::standing::Standing;
use crate::geometry::halves::nearest_within_seen;
use crate::geometry::{DVec2, DVec3, OrderBy, any_perpendicular};
use crate::tool::Tool;
use core::cmp::Ordering;
use rstar::{AABB, RTree, RTreeObject};

/// Greatest number of rulings that a cutter is pushed out of: those of two walls, or of a round corner.
const MOST_RULINGS: usize = 32;
/// Farthest distance that a cutter is pushed, radii of the cutter with its allowance: where it touches the surface, its axis is at most a
/// radius behind a wall, and out of a corner of 60 degrees it moves twice as far as out of a wall.
const FARTHEST: f64 = 4.0;
/// A cutter that penetrates a wall by less than this touches it, mm.
const TOUCH: f64 = 1e-7;
/// Distances from the axis, radii of the cutter with its allowance, within which rulings are looked at: few where a wall
/// is close, those that the cutter may touch, and at last all that show on which side of a wall it stands.
const AROUND: [f64; 3] = [0.35, 1.05, 2.1];
/// Halvings of a ruling in the search for the deepest penetration of a rounded end: to a millionth of its length.
const HALVINGS: usize = 20;
/// Below this, mm, it does not matter how much deeper a rounded end penetrates a ruling than the cutter's side does.
const NEGLIGIBLE: f64 = 1e-5;
/// Two directions out that differ by less than this (sine) are the same: those from neighbouring rulings of a
/// straight wall differ by up to their distance over the cutter's radius.
const SAME_WAY: f64 = 0.1;
/// Rulings less than this apart, across the axis, are one line, mm.
const SAME_LINE: f64 = 1e-9;

/// A straight line up a wall.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Ruling {
    /// Its foot, mm.
    pub from: DVec3,
    /// Its top, mm.
    pub to: DVec3,
    /// Unit direction out of the wall.
    pub inward: DVec3,
    /// Allowance on the wall, or distance that is kept from it, mm: the cutter is taken to be larger by it on all sides.
    pub allowance: f64,
    /// Whether a cutter whose axis is behind the wall is moved out in front of it; otherwise it has no place there.
    pub clears_behind: bool,
    /// Whether it is in the way of a cutter on level ground alone: elsewhere the contact says where the cutter stands.
    pub beside_level: bool,
}

impl RTreeObject for Ruling {
    type Envelope = AABB<[f64; 3]>;

    fn envelope(&self) -> Self::Envelope {
        AABB::from_corners(self.from.to_array(), self.to.to_array())
    }
}

/// Position of the cutter relative to the walls around it.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Stand {
    /// How deep it penetrates the worst of them, mm; negative where it is clear.
    pub depth: f64,
    /// Unit direction out of that, across the axis.
    pub away: DVec3,
    /// Whether its axis is behind a wall from where it is not moved out.
    pub is_lost: bool,
}

/// A cutter pushed off walls.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Pushed {
    /// Its tip, mm.
    pub tip: DVec3,
    /// Direction out of the last wall that it touches; `None` where it was clear.
    pub away: Option<DVec3>,
}

/// The walls of a part, for queries at places.
#[derive(Clone, Debug, Default)]
pub struct Rulings {
    tree: RTree<Ruling>,
    /// The largest allowance, mm.
    allowance: f64,
}

/// The cutter of a query.
struct Query<'a> {
    tool: &'a Tool,
    tip: DVec3,
    axis: DVec3,
    reach: f64,
    /// Whether it stands on level ground.
    is_level: bool,
}

/// A ruling seen from the cutter.
struct Seen {
    /// Smallest distance from the axis, mm.
    distance: f64,
    /// From the axis to the nearest point of the ruling.
    across: DVec3,
    /// How deep the cutter penetrates it, and from the axis to where.
    depth: f64,
    deepest: DVec3,
}

impl Rulings {
    /// An index over rulings.
    pub fn new(rulings: Vec<Ruling>) -> Self {
        let allowance = rulings.iter().map(|r| r.allowance).fold(0.0, f64::max);
        Self { tree: RTree::bulk_load(rulings), allowance }
    }

    /// Whether there is no wall.
    pub fn is_empty(&self) -> bool {
        self.tree.size() == 0
    }

    /// Position relative to the walls of a cutter, on level ground or not; `None` where no wall is
    /// near.
    ///
    /// Where its axis is behind the nearest wall, it penetrates the wall by its radius plus the distance to the axis.
    pub fn stand(&self, at: &Standing, is_level: bool) -> Option<Stand> {
        let Standing { ref tool, tip, axis, reach } = *at;
        self.worst(&Query { tool, tip, axis, reach, is_level }).map(|(stand, _)| stand)
    }

    /// The position relative to the worst ruling, and that.
    fn worst(&self, query: &Query) -> Option<(Stand, &Ruling)> {
        if self.is_empty() {
            return None;
        }
        let radius = query.tool.radius() + self.allowance;
        let mut found = None;
        for around in AROUND.map(|around| around * radius) {
            found = self.worst_within(query, around);
            // Rulings farther off are no nearer, and penetrated less deep.
            let is_all = |(stand, _, nearest): &(Stand, &Ruling, f64)| {
                nearest + SAME_LINE <= around && stand.depth >= radius - around
            };
            if found.as_ref().is_some_and(is_all) {
                break;
            }
        }
        found.map(|(stand, ruling, _)| (stand, ruling))
    }

    /// The same of the rulings within a distance of the axis, and the distance of the nearest one.
    fn worst_within(&self, query: &Query, around: f64) -> Option<(Stand, &Ruling, f64)> {
        let &Query { tool, axis, .. } = query;
        // Those at the least distance, for lines that are equally near.
        let mut nearest: Vec<(f64, &Ruling, DVec3)> = Vec::new();
        let mut worst: Option<(f64, &Ruling, DVec3)> = None;
        for ruling in self.tree.locate_in_envelope_intersecting(self.envelope(query, around)) {
            let floor = worst.map_or(f64::NEG_INFINITY, |w| w.0);
            let Some(seen) = query.sees(ruling, floor).filter(|s| s.distance <= around) else {
                continue;
            };
            // Equal ones go by their place, so that the order of the tree does not matter.
            let before = |best: &(f64, &Ruling, DVec3), value: f64| {
                value == best.0 && place(best.1) <= place(ruling)
            };
            let least = nearest.iter().map(|n| n.0).fold(f64::INFINITY, f64::min);
            if seen.distance <= least + SAME_LINE {
                nearest.retain(|n| n.0 <= seen.distance + SAME_LINE);
                nearest.push((seen.distance, ruling, seen.across));
            }
            if worst.is_none_or(|w| seen.depth > w.0 || seen.depth == w.0 && !before(&w, w.0)) {
                worst = Some((seen.depth, ruling, seen.deepest));
            }
        }
        let first = |a: &&(f64, &Ruling, DVec3), b: &&(f64, &Ruling, DVec3)| {
            place(a.1).partial_cmp(&place(b.1)).unwrap_or(Ordering::Equal)
        };
        let &(distance, ruling, across) = nearest.iter().min_by(first)?;
        // Of all that meet in this line, as at a corner: their mean tells on which side the cutter stands.
        let on_line = nearest.iter().filter(|n| n.2.distance(across) <= SAME_LINE);
        let mut inwards: Vec<DVec3> = on_line.map(|n| n.1.inward).collect();
        // In an order that is not that of the tree.
        inwards.order_by(|a, b| a.to_array().partial_cmp(&b.to_array()).unwrap_or(Ordering::Equal));
        let out: DVec3 = inwards.into_iter().sum();
        let inward = query.inward(ruling);
        if across.dot(out.reject_from(axis)) > 0.0 {
            let depth = tool.radius() + ruling.allowance + distance;
            let away = across.try_normalize().unwrap_or(inward);
            return Some((Stand { depth, away, is_lost: !ruling.clears_behind }, ruling, distance));
        }
        let (depth, ruling, across) = worst?;
        let away = (-across).try_normalize().unwrap_or(query.inward(ruling));
        Some((Stand { depth, away, is_lost: false }, ruling, distance))
    }

    /// The cutter moved across its axis until it penetrates no wall; `None` where it does not fit between them.
    pub fn push(&self, at: &Standing, is_level: bool) -> Option<Pushed> {
        let Standing { ref tool, tip, axis, reach } = *at;
        let across = any_perpendicular(axis);
        let frame = [across, axis.cross(across)];
        let flat = |v: DVec3| DVec2::from(frame.map(|f| f.dot(v)));
        let place = |at: DVec2| tip + frame[0] * at.x + frame[1] * at.y;
        let query = |at: DVec2| Query { tool, tip: place(at), axis, reach, is_level };
        let farthest = FARTHEST * (tool.radius() + self.allowance);
        let mut known: Vec<Ruling> = Vec::new();
        let mut at = DVec2::ZERO;
        while known.len() < MOST_RULINGS {
            let seen = |at: DVec2| {
                let half = |ruling| {
                    let (depth, away) = query(at).out_of(ruling)?;
                    let out = flat(away);
                    Some((out, out.dot(at) + depth))
                };
                Some(known.iter().filter_map(half).collect())
            };
            at = nearest_within_seen(at, SAME_LINE, &seen)?;
            if at.length() > farthest {
                return None;
            }
            let worst = self.worst(&query(at)).filter(|(stand, _)| stand.depth > TOUCH);
            let Some((stand, ruling)) = worst else {
                let away = known.last().and_then(|last| query(at).out_of(last)).map(|out| out.1);
                return Some(Pushed { tip: place(at), away });
            };
            if stand.is_lost || known.contains(ruling) {
                return None;
            }
            known.push(*ruling);
        }
        None
    }

    /// A box around the cutter, extended by the given distance.
    fn envelope(&self, query: &Query, around: f64) -> AABB<[f64; 3]> {
        let all = self.tree.root().envelope();
        let [low, high] = [all.lower(), all.upper()].map(DVec3::from);
        // A longer cutter meets nothing more.
        let far = query.tip.distance(0.5 * (low + high)) + low.distance(high);
        let top = query.tip + query.axis * query.reach.min(far);
        // The allowance is below its tip, too.
        let margin = DVec3::splat(around + self.allowance);
        let (from, to) = (query.tip.min(top) - margin, query.tip.max(top) + margin);
        AABB::from_corners(from.to_array(), to.to_array())
    }
}

fn place(ruling: &Ruling) -> [f64; 3] {
    ruling.from.to_array()
}

/// Where the cutter at `a` and at `b`, each touching a wall, would touch both walls: the corner between them; `None`
/// where the walls are parallel.
pub fn corner(a: (DVec3, DVec3), b: (DVec3, DVec3), axis: DVec3) -> Option<DVec3> {
    let (first, second) = (a.1.reject_from(axis), b.1.reject_from(axis));
    let along = axis.cross(second.try_normalize()?);
    let slope = along.dot(first.try_normalize()?);
    if slope.abs() < SAME_WAY {
        return None;
    }
    let missing = first.normalize().dot(a.0 - b.0);
    let corner = b.0 + along * (missing / slope);
    // As high as the middle of the two.
    let middle = 0.5 * (a.0 + b.0);
    Some(corner + axis * (middle - corner).dot(axis))
}

impl Query<'_> {
    /// The ruling's direction out of the wall, across the axis.
    fn inward(&self, ruling: &Ruling) -> DVec3 {
        let across = ruling.inward.reject_from(self.axis);
        across.try_normalize().unwrap_or(any_perpendicular(self.axis))
    }

    /// How deep the cutter penetrates a ruling, and the unit direction out of it: negative where it is clear; `None` where
    /// it cannot touch it.
    fn out_of(&self, ruling: &Ruling) -> Option<(f64, DVec3)> {
        let seen = self.sees(ruling, f64::NEG_INFINITY)?;
        let inward = self.inward(ruling);
        if seen.across.dot(inward) > 0.0 {
            return Some((self.tool.radius() + ruling.allowance + seen.across.dot(inward), inward));
        }
        Some((seen.depth, (-seen.deepest).try_normalize().unwrap_or(inward)))
    }

    /// `None` for a ruling that lies wholly below the tip or above the cutter; if less deep than `floor`, the depth
    /// beside the rounded end does not matter.
    fn sees(&self, ruling: &Ruling, floor: f64) -> Option<Seen> {
        (self.is_level || !ruling.beside_level).then_some(())?;
        let grown = ruling.allowance;
        let tip = self.tip - self.axis * grown;
        let (reach, radius) = (self.reach + 2.0 * grown, self.tool.radius() + grown);
        let round = self.tool.corner_radius() + grown;
        let (a, b) = (ruling.from - tip, ruling.to - tip);
        let (low, high) = (a.dot(self.axis), b.dot(self.axis));
        let (foot, top) = (a - self.axis * low, b - self.axis * high);
        let rise = high - low;
        // The part of the ruling between two heights.
        let between = |from: f64, to: f64| {
            if rise == 0.0 {
                return (from <= low && low <= to).then_some((0.0, 1.0));
            }
            let (s, t) = ((from - low) / rise, (to - low) / rise);
            let (s, t) = (s.min(t).max(0.0), s.max(t).min(1.0));
            (s <= t).then_some((s, t))
        };
        let way = top - foot;
        let square = way.length_squared();
        let nearest_on = |(s, t): (f64, f64)| {
            let at = if square > 0.0 { -foot.dot(way) / square } else { s };
            foot + way * at.clamp(s, t)
        };
        let whole = between(0.0, reach)?;
        let across = nearest_on(whole);
        let distance = across.length();
        let mut seen = Seen { distance, across, depth: f64::NEG_INFINITY, deepest: across };
        if let Some(side) = between(round, reach) {
            seen.deepest = nearest_on(side);
            seen.depth = radius - seen.deepest.length();
        }
        // Beside the rounded end the cutter is slimmer, and the more so the lower.
        let known = seen.depth.max(floor) + NEGLIGIBLE;
        let lack = |part: f64| (round - (low + rise * part)).clamp(0.0, round);
        let half_chord = |lack: f64| (round * round - lack * lack).max(0.0).sqrt();
        let wide = |part: f64| radius - round + half_chord(lack(part));
        if radius - distance > known
            && let Some((mut s, mut t)) = between(0.0, round.min(reach))
            && wide(s).max(wide(t)) - nearest_on((s, t)).length() > known
        {
            // The penetration is concave: it grows up to the deepest place.
            let grows = |part: f64| {
                let (lack, across) = (lack(part), foot + way * part);
                rise * lack * across.length() >= across.dot(way) * half_chord(lack)
            };
            for _ in 0..HALVINGS {
                let middle = 0.5 * (s + t);
                if grows(middle) { s = middle } else { t = middle }
            }
            for part in [s, t] {
                let across = foot + way * part;
                let depth = wide(part) - across.length();
                if depth > seen.depth {
                    (seen.depth, seen.deepest) = (depth, across);
                }
            }
        }
        Some(seen)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::math::{cos, sin};

    const HIGH: f64 = 20.0;

    fn flat(radius: f64) -> Tool {
        Tool::new(radius, 0.0).unwrap()
    }

    /// Rulings along a flat polyline with the room on its left.
    fn along(line: &[(f64, f64)]) -> Vec<Ruling> {
        let mut out = Vec::new();
        for pair in line.windows(2) {
            let [a, b] = [pair[0], pair[1]].map(|(x, y)| DVec3::new(x, y, 0.0));
            let inward = DVec3::Z.cross(b - a).normalize();
            let count = (a.distance(b) / 0.05).ceil() as u32;
            out.extend((0..=count).map(|i| {
                let from = a.lerp(b, f64::from(i) / f64::from(count));
                Ruling {
                    from,
                    to: from + DVec3::Z * HIGH,
                    inward,
                    allowance: 0.0,
                    clears_behind: true,
                    beside_level: false,
                }
            }));
        }
        out
    }

    fn standing(tool: Tool, tip: DVec3) -> Standing {
        Standing { tool, tip, axis: DVec3::Z, reach: f64::INFINITY }
    }

    fn pushed(rulings: &Rulings, tool: &Tool, x: f64, y: f64) -> Option<DVec3> {
        let tip = DVec3::new(x, y, 1.0);
        rulings.push(&standing(*tool, tip), false).map(|p| p.tip)
    }

    /// In a wedge the place that touches both walls may be far from where the cutter was to stand: no place for it.
    #[test]
    fn a_cutter_is_pushed_two_diameters_at_most() {
        for (half, fits) in [(45.0f64, true), (12.0, false)] {
            let (s, c) = (sin(half.to_radians()), cos(half.to_radians()));
            let wedge = along(&[(80.0 * c, 80.0 * s), (0.0, 0.0), (80.0 * c, -80.0 * s)]);
            // At the apex; it touches both walls R / sin away.
            let tip = pushed(&Rulings::new(wedge), &flat(5.0), 0.01, 0.0);
            assert_eq!(tip.is_some(), fits, "{half} degrees: {tip:?}");
        }
    }

    #[test]
    fn a_cutter_is_pushed_off_a_wall_from_before_and_behind_it() {
        let rulings = Rulings::new(along(&[(-50.0, 0.0), (50.0, 0.0)]));
        for y in [4.9, 2.0, 0.0, -3.0, -5.0] {
            let tip = pushed(&rulings, &flat(5.0), 1.0, y).unwrap();
            assert!((tip - DVec3::new(1.0, 5.0, 1.0)).length() < 1e-3, "{y}: {tip}");
        }
        assert_eq!(pushed(&rulings, &flat(5.0), 1.0, 5.5), Some(DVec3::new(1.0, 5.5, 1.0)));
    }

    /// Nearer to a wall than its rulings are to each other, the direction from the nearest one is any.
    #[test]
    fn close_to_a_wall_a_cutter_is_pushed_straight_off_it() {
        let rulings = Rulings::new(along(&[(-50.0, 0.0), (50.0, 0.0)]));
        for (x, y) in [(1.02, 0.01), (1.04, 0.02), (1.01, 0.1)] {
            let tip = pushed(&rulings, &flat(5.0), x, y).unwrap();
            assert!((tip.x - x).abs() < 0.03 && (tip.y - 5.0).abs() < 1e-3, "{x} {y}: {tip}");
        }
    }

    /// Both walls are equally near, and neither is behind it.
    #[test]
    fn on_the_bisector_of_a_corner_it_stands_before_both_walls() {
        let walls = Rulings::new(along(&[(0.0, 30.0), (0.0, 0.0), (30.0, 0.0)]));
        let tool = flat(3.0);
        for i in 1..60 {
            let d = 0.1 * f64::from(i);
            let stand = walls.stand(&standing(tool, DVec3::new(d, d, 0.0)), false).unwrap();
            assert!((stand.depth - (3.0 - d)).abs() < 1e-3, "{d}: {stand:?}");
        }
    }

    #[test]
    fn in_a_corner_it_touches_both_walls() {
        let rulings = Rulings::new(along(&[(0.0, 50.0), (0.0, 0.0), (50.0, 0.0)]));
        let corner = DVec3::new(5.0, 5.0, 1.0);
        for (x, y) in [(4.0, 4.5), (1.0, 1.0), (4.9, 2.0)] {
            let tip = pushed(&rulings, &flat(5.0), x, y).unwrap();
            assert!(tip.distance(corner) < 1e-3, "{x} {y}: {tip}");
        }
        let touching = [DVec3::new(5.0, 5.3, 1.0), DVec3::new(5.4, 5.0, 1.0)];
        let found = super::corner((touching[0], DVec3::X), (touching[1], DVec3::Y), DVec3::Z);
        assert!(found.unwrap().distance(corner) < 1e-12);
    }

    /// From wherever close to a corner that juts out, the cutter comes to stand off both walls.
    #[test]
    fn around_a_corner_that_juts_out_it_is_off_both_walls() {
        let rulings = Rulings::new(along(&[(30.0, 0.0), (0.0, 0.0), (0.0, 30.0)]));
        for (x, y) in [(3.0, -0.3), (0.7, -2.0), (-0.2, -0.2), (-0.01, -1.0), (-4.5, 0.4)] {
            let tip = pushed(&rulings, &flat(5.0), x, y).unwrap();
            let nearest = DVec2::new(tip.x.max(0.0), tip.y.max(0.0));
            let off = tip.truncate().distance(if tip.x > 0.0 && tip.y > 0.0 {
                DVec2::NAN
            } else {
                nearest
            });
            assert!((off - 5.0).abs() < 2e-3, "{x} {y}: {tip}");
        }
    }

    #[test]
    fn between_walls_too_near_there_is_no_place() {
        let gap = |wide: f64| {
            let mut all = along(&[(-50.0, 0.0), (50.0, 0.0)]);
            all.extend(along(&[(50.0, wide), (-50.0, wide)]));
            pushed(&Rulings::new(all), &flat(5.0), 0.0, 4.0)
        };
        assert!(gap(9.9).is_none());
        assert!((gap(10.5).unwrap().y - 5.0).abs() < 1e-3);
    }

    #[test]
    fn a_ball_passes_closer_to_a_low_wall_and_over_it() {
        let low: Vec<Ruling> = along(&[(-50.0, 0.0), (50.0, 0.0)])
            .into_iter()
            .map(|r| Ruling { to: r.from + DVec3::Z, ..r })
            .collect();
        let rulings = Rulings::new(low);
        let ball = Tool::new(5.0, 5.0).unwrap();
        let tip = rulings.push(&standing(ball, DVec3::new(0.0, 1.0, 0.0)), false).unwrap().tip;
        // The sphere about z = 5 at the wall's top, z = 1.
        assert!((tip.y - 3.0).abs() < 1e-3, "{tip}");
        let above = DVec3::new(0.0, 0.0, 1.1);
        assert_eq!(rulings.stand(&standing(ball, above), false), None);
    }

    #[test]
    fn a_leaning_cutter_meets_the_wall_with_its_side() {
        let rulings = Rulings::new(along(&[(-50.0, 0.0), (50.0, 0.0)]));
        let lean = 0.1;
        let axis = DVec3::new(0.0, -sin(lean), cos(lean));
        let (tool, reach) = (Tool::new(5.0, 5.0).unwrap(), 12.0);
        let tip = DVec3::new(0.0, 6.0, 0.0);
        let stand = rulings.stand(&Standing { tool, tip, axis, reach }, false).unwrap();
        // Its axis comes nearer by sin(lean) per mm of length, up to the end of the cutter or of the wall.
        let top = tip + axis * reach;
        let rim = top.y - 5.0 * cos(lean);
        assert!((stand.depth - -rim / cos(lean)).abs() < 0.02, "{stand:?} {rim}");
    }
}
