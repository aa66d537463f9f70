//! The solids that an assembly is made of: how far a place is from them, and how far they reach in a direction.
//!
//! - *Signed distance*: positive outside; inside, minus the distance from the skin. Of a convex solid it is a convex
//!   function of the place, and its slope is a unit vector, the *outward* direction.
//! - *Support*: how far a solid reaches in a direction `n`, `max n·x` over its places `x`. No place has a signed distance
//!   of less than `n·x - support(n)`, whatever the unit vector `n`: a plane parts the two.
//! - *Ring*: a circle about the tool axis. A cutter is the hull of the ring at its top and of the ring along which the
//!   centre of its corner radius runs, with that radius about it; a frustum is the hull of its two rims.
//!
//! A solid of revolution is seen in two coordinates, height above the tip and distance from the axis.
//!
//! Source: Rockafellar, "Convex Analysis" (1970), section 13 (support functions).

use super::body::Placed;
use crate::geometry::{DVec2, DVec3, any_perpendicular};
use crate::tool::{Assembly, AssemblyPart};

/// A place this close to the skin lies on it, mm.
const TOUCH: f64 = 1e-12;

/// A convex solid of revolution about the tool axis; heights from the tip, mm.
#[derive(Copy, Clone, Debug)]
pub enum Solid {
    /// The cutting end.
    Cutter {
        /// Its radius.
        radius: f64,
        /// Its corner radius.
        corner: f64,
        /// Height of its top, at least the corner radius.
        top: f64,
    },
    /// A cylinder or a cone.
    Frustum {
        /// Where it begins and ends, rising.
        heights: [f64; 2],
        /// Its radii there.
        radii: [f64; 2],
    },
}

/// A circle about the tool axis, with a ball about each of its places.
struct Ring {
    height: f64,
    radius: f64,
    round: f64,
}

/// A place as seen from a solid.
#[derive(Copy, Clone, Debug)]
pub struct Seen {
    /// Signed distance, mm.
    pub distance: f64,
    /// Outward direction, unit.
    pub outward: DVec3,
}

/// A stretch of a move, seen from its ends.
#[derive(Copy, Clone, Debug)]
pub struct Stretch {
    /// The cutter at both ends.
    pub ends: [Placed; 2],
    /// How far the end of the unit axis leaves the straight line between its ends at most.
    pub sag: f64,
}

impl Stretch {
    /// A cutter that stands still.
    pub fn still(at: Placed) -> Self {
        Self { ends: [at; 2], sag: 0.0 }
    }
}

impl Solid {
    /// The solids of an assembly. What is higher than `highest` is left out, mm.
    pub fn of(assembly: &Assembly, highest: f64) -> Vec<(AssemblyPart, Self)> {
        let (radius, corner) = (assembly.tool.radius(), assembly.tool.corner_radius());
        let top = assembly.cutter_length.min(highest).max(corner);
        let mut all = vec![(AssemblyPart::Cutter, Self::Cutter { radius, corner, top })];
        for section in &assembly.sections {
            let [low, high] = section.heights;
            if low >= highest || high.is_nan() || low.is_nan() {
                continue;
            }
            let [narrow, wide] = section.radii.map(|r| r.max(0.0));
            // The radius where it is cut off.
            let end = high.min(highest).max(low);
            let part = if high > low { (end - low) / (high - low) } else { 1.0 };
            let is_whole = end == high;
            let last = if is_whole { wide } else { narrow + (wide - narrow) * part };
            let solid = Self::Frustum { heights: [low, end], radii: [narrow, last] };
            all.push((section.part, solid));
        }
        all
    }

    /// Distance of its farthest place from the tip, mm.
    pub fn reach(&self) -> f64 {
        let far = |h: f64, r: f64| DVec2::new(h, r).length();
        match *self {
            // No place of the rounded end is farther away than the corner around it.
            Self::Cutter { radius, top, .. } => far(top, radius),
            Self::Frustum { heights: [low, high], radii: [a, b] } => far(low, a).max(far(high, b)),
        }
    }

    /// Its largest radius, mm.
    pub fn widest(&self) -> f64 {
        match *self {
            Self::Cutter { radius, .. } => radius,
            Self::Frustum { radii: [a, b], .. } => a.max(b),
        }
    }

    /// A place as seen from it.
    pub fn see(&self, at: Placed, place: DVec3) -> Seen {
        let way = place - at.tip;
        let height = way.dot(at.axis);
        let across = way - at.axis * height;
        let radius = across.length();
        let (distance, slope) = self.signed(DVec2::new(height, radius));
        let aside = if radius > TOUCH { across / radius } else { any_perpendicular(at.axis) };
        Seen { distance, outward: at.axis * slope.x + aside * slope.y }
    }

    /// Signed distance of a place, given by height and distance from the axis, and its slope.
    fn signed(&self, at: DVec2) -> (f64, DVec2) {
        match *self {
            Self::Cutter { radius, corner, top } => {
                if at.x > top {
                    let way = at - DVec2::new(top, at.y.min(radius));
                    let distance = way.length();
                    return (distance, way / distance);
                }
                // From the core, whose skin lies a corner radius within that of the cutter.
                let from = DVec2::new(corner - at.x, at.y - (radius - corner));
                let around = if from.min_element() > 0.0 {
                    let distance = from.length();
                    (distance - corner, DVec2::new(-from.x, from.y) / distance)
                } else if from.x > from.y {
                    (from.x - corner, DVec2::NEG_X)
                } else {
                    (from.y - corner, DVec2::Y)
                };
                let below_top = (at.x - top, DVec2::X);
                if below_top.0 > around.0 { below_top } else { around }
            }
            Self::Frustum { heights: [low, high], radii: [a, b] } => {
                let (start, end) = (DVec2::new(low, a), DVec2::new(high, b));
                let side = end - start;
                let out = DVec2::new(-side.y, side.x).normalize_or(DVec2::Y);
                let walls = [
                    (low - at.x, DVec2::NEG_X),
                    (at.x - high, DVec2::X),
                    ((at - start).dot(out), out),
                ];
                let first = walls[0];
                let inside = walls.into_iter().fold(first, |m, w| if w.0 > m.0 { w } else { m });
                if inside.0 <= TOUCH {
                    return inside;
                }
                let along = (at - start).dot(side) / side.length_squared().max(f64::MIN_POSITIVE);
                let nearest = [
                    DVec2::new(low, at.y.min(a)),
                    DVec2::new(high, at.y.min(b)),
                    start + side * along.clamp(0.0, 1.0),
                ];
                let ways = nearest.map(|n| at - n);
                let first = ways[0];
                let nearer = |m: DVec2, w: DVec2| {
                    if w.length_squared() < m.length_squared() { w } else { m }
                };
                let way = ways.into_iter().fold(first, nearer);
                let distance = way.length();
                if distance > TOUCH { (distance, way / distance) } else { (distance, inside.1) }
            }
        }
    }

    /// How far it reaches in the direction of the unit vector `n` anywhere on a stretch of a move, at most.
    ///
    /// The place at height `h` on the axis moves on a line, but for the bend of the path of the axis; and a ring reaches
    /// as far beyond its centre as `|n x axis|`, a convex function of the axis: so both are greatest at an end of the
    /// stretch, but for that bend.
    pub fn support(&self, n: DVec3, stretch: &Stretch) -> f64 {
        let of = |ring: &Ring| {
            let at = |p: &Placed| {
                let (along, across) = (n.dot(p.axis), n.cross(p.axis).length());
                n.dot(p.tip) + ring.height * along + ring.radius * across
            };
            let [a, b] = &stretch.ends;
            at(a).max(at(b)) + ring.round + (ring.height.abs() + ring.radius) * stretch.sag
        };
        match *self {
            Self::Cutter { radius, corner, top } => {
                let rim = of(&Ring { height: top, radius, round: 0.0 });
                let lowest = stretch.ends.iter().map(|p| n.dot(p.axis)).fold(1.0, f64::min);
                // In a direction that rises along the axis, the top reaches farther.
                if lowest - stretch.sag >= 0.0 {
                    return rim;
                }
                rim.max(of(&Ring { height: corner, radius: radius - corner, round: corner }))
            }
            Self::Frustum { heights: [low, high], radii: [a, b] } => {
                let start = of(&Ring { height: low, radius: a, round: 0.0 });
                start.max(of(&Ring { height: high, radius: b, round: 0.0 }))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::math::{cos, sin};
    use crate::tool::{Section, Tool};

    fn solids() -> Vec<Solid> {
        let mut all = Vec::new();
        for (corner, length) in [(3.0, 9.0), (1.0, 1.2), (0.0, 5.0), (3.0, 3.0)] {
            let section = |heights, radii| Section { part: AssemblyPart::Shank, heights, radii };
            let assembly = Assembly {
                tool: Tool::new(3.0, corner).unwrap(),
                cutter_length: length,
                sections: vec![
                    section([9.0, 20.0], [2.0, 5.0]),
                    section([9.0, 12.0], [5.0, 0.0]),
                    section([4.0, 4.0], [3.0, 3.0]),
                ],
            };
            all.extend(Solid::of(&assembly, 1e3).into_iter().map(|(_, s)| s));
        }
        all
    }

    /// The two descriptions of a solid are of the same one: the largest parting plane is the distance, and the slope is
    /// its direction.
    #[test]
    fn the_distance_is_that_of_the_best_parting_plane() {
        let at = Placed { tip: DVec3::new(1.0, 2.0, 3.0), axis: DVec3::new(0.6, 0.0, 0.8) };
        let still = Stretch::still(at);
        for solid in solids() {
            for k in 0..300 {
                let k = f64::from(k);
                let way = DVec3::new(12.0 * sin(k), 12.0 * cos(2.3 * k), 14.0 * sin(0.7 * k) + 4.0);
                let place = at.tip + way;
                let seen = solid.see(at, place);
                let plane = |n: DVec3| n.dot(place) - solid.support(n, &still);
                assert!((seen.outward.length() - 1.0).abs() < 1e-9);
                let best = plane(seen.outward);
                assert!((best - seen.distance).abs() < 1e-9, "{solid:?}: {best}, {seen:?}");
                for i in 0..50 {
                    let (turn, z) = (f64::from(i), (f64::from(i) - 24.5) / 25.0);
                    let wide = (1.0 - z * z).sqrt();
                    let n = DVec3::new(wide * cos(turn), wide * sin(turn), z);
                    assert!(plane(n) <= seen.distance + 1e-9, "{solid:?}");
                }
            }
        }
    }

    #[test]
    fn what_is_higher_than_anything_is_left_out() {
        let tool = Tool::new(3.0, 3.0).unwrap();
        let holder =
            Section { part: AssemblyPart::Holder, heights: [50.0, 150.0], radii: [10.0, 30.0] };
        let assembly = Assembly { sections: vec![holder], ..Assembly::of_cutter(tool, 1e300) };
        let all = Solid::of(&assembly, 100.0);
        assert!(matches!(all[0].1, Solid::Cutter { top: 100.0, .. }));
        let Solid::Frustum { heights, radii } = all[1].1 else { panic!("{:?}", all[1]) };
        assert_eq!((heights, radii), ([50.0, 100.0], [10.0, 20.0]));
        assert_eq!(Solid::of(&assembly, 40.0).len(), 1);
    }
}
