//! Height of the reached surface over a place.
//!
//! Terms. The *tip height* of the cutter over a place is where its tip is when the cutter stands on the part there;
//! the *lower side* of the cutter is a height over its tip. The reached surface over `p` is the lowest, over all places
//! `c` within the cutter's radius, of the tip height over `c` plus the lower side at `p`.
//!
//! Where the cutter fits, that is the part itself: one query tells. Elsewhere:
//!
//! 1. Starts: where the cutter stands that leaves the places around, which were asked before, and the nearest place at
//!    which the facet below is touched; a ring of places around if there are none. One with a flat bottom is moved off
//!    what stands beside the place, too, wall by wall: right beside a wall there is hardly a place from which it comes
//!    down. The best of them, by the true part.
//! 2. With the facets known so far as the part, the best `c` is sought (`minimax`).
//! 3. The true part is asked there: the facet that holds the cutter up is added. Known facets alone give a lower bound,
//!    the query an upper bound; they meet after a few rounds, since over a few facets the sum is nearly the largest of
//!    linear functions.
//!
//! Beside walls the sum jumps, and a narrow valley of it may be missed: then the height is one that another place of
//! the cutter leaves, higher than the lowest, and no cutter that is led by it cuts into the part. What the cutter leaves
//! that stands for a place nearby is looked at, too, in the end (`net`).

use super::facet::{area_normal, nearest_above};
use super::minimax::lowest;
use super::options::ReachOptions;
use crate::cutter_location::{CheckMesh, Standing, Upright, tip};
use crate::geometry::halves::nearest_within_seen;
use crate::geometry::math::cos;
use crate::geometry::{DVec2, DVec3};
use crate::parallel;
use crate::surface::Part;
use crate::tool::Tool;

/// What rounding may change, mm.
const ROUNDED: f64 = 1e-5;
/// Radius of the needle that looks for the part, mm.
const NEEDLE: f64 = 1e-6;
/// Fraction of the accuracy up to which bounds of a height need not meet.
const MEET: f64 = 0.5;
/// Fraction of the accuracy by which the cutter may be too high over a place where it counts as fitting.
const FITS: f64 = 0.5;
/// Ways from a place to the ring of starts, and how far, cutter radii: beside a wall the cutter stands farther away.
const AROUND: [DVec2; 8] = [
    DVec2::new(1.0, 0.0),
    DVec2::new(0.7, 0.7),
    DVec2::new(0.0, 1.0),
    DVec2::new(-0.7, 0.7),
    DVec2::new(-1.0, 0.0),
    DVec2::new(-0.7, -0.7),
    DVec2::new(0.0, -1.0),
    DVec2::new(0.7, -0.7),
];
const STARTS: [f64; 3] = [0.3, 0.7, 0.97];
/// Size of the first step in search of the place of the cutter, cutter radii: from a start of the ring, and from one
/// that leaves a place nearby.
const FIRST_STEP: f64 = 0.5;
const NEAR_STEP: f64 = 0.1;
/// How far from a wall a cutter is that does not touch it, mm: more than rounding, and so little that a slot as wide
/// as the cutter is wide enough.
const BESIDE: f64 = 1e-8;
/// Most walls that a cutter is moved off: the facets of a rounded corner.
const MOST_WALLS: usize = 16;
/// What is steeper than this cosine to the axis is a wall off which a flat bottom is moved: 60 degrees.
const WALL: f64 = 0.5;
/// A flat bottom is moved off walls beside ground whose cosine to the axis is not below this, 30 degrees; steeper ground
/// it comes down to from the side.
const GROUND: f64 = 0.866;
/// Most facets by which it is sought.
const MOST_FACETS: usize = 24;
/// A machined facet is in sight where it is not lower than the part by more than this, mm.
const IN_SIGHT: f64 = 1e-4;
/// A start is at most this far away, cutter radii: just not at the cutter's side.
const WITHIN: f64 = 1.0 - 1e-6;

/// The part under the cutter.
pub(super) struct Terrain<'a> {
    part: &'a CheckMesh,
    /// The machined facets, where these are not all.
    machined: Option<CheckMesh>,
    /// The walls, for a cutter with a flat bottom.
    walls: Option<CheckMesh>,
    needle: Upright,
    /// The cutter with the allowance on all sides.
    cutter: Upright,
    /// The same a little wider: what clears the known facets by it clears them whatever is rounded.
    wider: Upright,
    /// Lower than the part, mm.
    floor: f64,
    meet: f64,
    /// How far the cutter may be too high where it counts as fitting, mm.
    fits: f64,
    /// Cosine of the steepest slope that is followed.
    steepest: f64,
}

/// The reached surface over a place.
#[derive(Copy, Clone, Debug, PartialEq)]
pub(super) struct Height {
    /// Height, mm.
    pub z: f64,
    /// Unit normal.
    pub normal: DVec3,
    /// Where the cutter's axis is that leaves a bridge; `None` where the cutter fits.
    pub by: Option<DVec2>,
}

impl Height {
    /// Whether the cutter bridges the part there.
    pub fn is_bridge(&self) -> bool {
        self.by.is_some()
    }
}

/// What a needle finds.
struct Top {
    z: f64,
    facet: [DVec3; 3],
}

impl Top {
    /// Unit normal of the facet.
    fn normal(&self) -> DVec3 {
        area_normal(self.facet).normalize_or(DVec3::Z)
    }
}

impl<'a> Terrain<'a> {
    pub fn new(
        obstacle: &'a CheckMesh,
        part: &Part,
        machined: &Part,
        options: &ReachOptions,
    ) -> Self {
        let upright = |tool: Option<Tool>| Upright::new(tool.unwrap_or(options.tool));
        let at =
            Standing { tool: options.tool, tip: DVec3::ZERO, axis: DVec3::Z, reach: f64::INFINITY };
        let lowest = part.positions.iter().map(|p| p.z).fold(f64::INFINITY, f64::min);
        let is_all = machined.faces.len() == part.faces.len();
        let own = || CheckMesh::new(machined.positions.clone(), machined.faces.clone());
        let corners = |face: &[u32; 3]| face.map(|v| part.positions[v as usize]);
        let is_wall = |face: &&[u32; 3]| {
            let normal = area_normal(corners(face));
            normal.z.abs() < WALL * normal.length()
        };
        let walls = || part.faces.iter().filter(is_wall).copied().collect();
        let walls = || CheckMesh::new(part.positions.clone(), walls());
        Self {
            part: obstacle,
            machined: (!is_all).then(own),
            walls: (options.tool.bottom_radius() > 0.0).then(walls),
            needle: upright(Tool::new(NEEDLE, 0.0).ok()),
            cutter: upright(at.grown(options.allowance).map(|s| s.tool)),
            wider: upright(at.grown(options.allowance + ROUNDED).map(|s| s.tool)),
            floor: lowest - 1.0,
            meet: MEET * options.accuracy,
            fits: FITS * options.accuracy,
            steepest: cos(options.followed()),
        }
    }

    /// The reached surface over a place; `None` where nothing is machined. `around`: the heights of places nearby.
    pub fn height(&self, at: DVec2, around: &[Height]) -> Option<Height> {
        // Behind a face that looks down is material: an open surface is not machined from its back.
        let top = self.top(at).filter(|top| area_normal(top.facet).z > 0.0)?;
        let machined = || self.machined.as_ref();
        if machined().is_some_and(|m| !self.is_hit(m, at, top.z)) {
            return None;
        }
        let height = match self.fits(at, &top) {
            Some(normal) => Height { z: top.z, normal, by: None },
            None => self.bridge(at, &top, around),
        };
        (height.normal.z >= self.steepest).then_some(height)
    }

    /// The height over a place, if that is lower, which the cutter leaves where it stands to leave the height over another.
    pub fn also_left(&self, at: DVec2, now: Height, other: (DVec2, Height)) -> Option<Height> {
        let by = now.by.and(other.1.by)?;
        let across = [at, other.0].map(|place| place.distance(by));
        if across[0] > WITHIN * self.cutter.radius() {
            return None;
        }
        let [own, there] = across.map(|across| self.cutter.lower_side(across));
        let height = Height {
            z: other.1.z - there + own,
            normal: self.cutter.normal(at - by),
            by: Some(by),
        };
        let is_lower = height.z < now.z - ROUNDED && height.normal.z >= self.steepest;
        is_lower.then_some(height)
    }

    /// Whether a place of the part is in sight from above.
    pub fn is_in_sight(&self, place: DVec3) -> bool {
        self.top(place.truncate()).is_none_or(|top| top.z <= place.z + IN_SIGHT)
    }

    /// How far places are above the part, mm.
    pub fn above(&self, places: &[DVec3], threads: usize) -> Vec<f64> {
        parallel::map(threads, places, |p| self.top(p.truncate()).map_or(0.0, |top| p.z - top.z))
    }

    fn top(&self, at: DVec2) -> Option<Top> {
        let landing = self.needle.lands(self.part, at, self.floor)?;
        Some(Top { z: landing.tip, facet: landing.facet })
    }

    fn is_hit(&self, mesh: &CheckMesh, at: DVec2, z: f64) -> bool {
        self.needle.lands(mesh, at, self.floor).is_some_and(|own| own.tip >= z - IN_SIGHT)
    }

    /// The normal of the part, if the cutter fits there.
    fn fits(&self, at: DVec2, top: &Top) -> Option<DVec3> {
        let normal = top.normal();
        let tool = self.cutter.tool();
        let fits = || {
            let tip = tip(tool, at.extend(top.z), normal, DVec3::Z, 0.0);
            self.part.is_clear(tool, tip + DVec3::Z * self.fits, DVec3::Z, f64::INFINITY)
        };
        (normal.z >= self.steepest && fits()).then_some(normal)
    }

    /// The reached surface where the cutter does not fit.
    fn bridge(&self, at: DVec2, top: &Top, around: &[Height]) -> Height {
        let mut known = vec![top.facet];
        let known_to_leave: Vec<DVec2> = around.iter().filter_map(|h| h.by).collect();
        let radius = self.cutter.radius();
        let touching = top.normal().truncate() * radius;
        let is_ground = top.normal().z >= GROUND;
        let beside = is_ground.then(|| self.off_walls(at, top.z)).flatten();
        let near = known_to_leave.iter().map(|by| *by - at).chain(beside);
        let mut best = (f64::INFINITY, DVec2::ZERO);
        for across in near.chain([touching, DVec2::ZERO]) {
            self.improve(&mut best, at, top, across, &mut known);
        }
        let is_alone = known_to_leave.is_empty();
        if is_alone {
            for across in AROUND.iter().flat_map(|way| STARTS.map(|part| *way * (part * radius))) {
                self.improve(&mut best, at, top, across, &mut known);
            }
        }
        let step = if is_alone { FIRST_STEP } else { NEAR_STEP };
        let local: Vec<[DVec3; 3]> = known.iter().map(|f| f.map(|p| p - at.extend(0.0))).collect();
        self.settle(at, top.z, local, step * radius, &mut best);
        // Under a flat bottom there may be others as good; the rounding beside it would seem to slope.
        let bottom = self.cutter.tool().bottom_radius();
        if bottom > 0.0 && best.1.length() > bottom {
            let under = best.1.clamp_length_max(bottom);
            self.improve(&mut best, at, top, under, &mut known);
        }
        Height { z: best.0, normal: self.cutter.normal(-best.1), by: Some(at + best.1) }
    }

    /// From a place to the nearest axis of a cutter with a flat bottom that clears all walls there, with its tip at a
    /// height; `None` if none was found.
    fn off_walls(&self, at: DVec2, tip: f64) -> Option<DVec2> {
        let walls = self.walls.as_ref()?;
        let (radius, above) = (self.cutter.radius(), tip + ROUNDED);
        let mut known: Vec<[DVec3; 3]> = Vec::new();
        let mut across = DVec2::ZERO;
        while known.len() < MOST_WALLS {
            // At the end of a wall the cutter is moved off that, seen from where it is now.
            let seen = |across: DVec2| {
                (across.length() <= WITHIN * radius).then_some(())?;
                let side = |facet: &[DVec3; 3]| {
                    let wall = nearest_above(*facet, above, at + across)?;
                    let out = (at + across - wall).try_normalize()?;
                    Some((out, out.dot(wall - at) + radius + BESIDE))
                };
                known.iter().map(side).collect()
            };
            across = nearest_within_seen(across, BESIDE, &seen)?;
            match self.cutter.lands(walls, at + across, above) {
                None => return Some(across),
                Some(landing) if known.contains(&landing.facet) => return None,
                Some(landing) => known.push(landing.facet),
            }
        }
        None
    }

    /// Tries a place of the cutter, from `at` to its axis; the facet that holds it there is known then.
    fn improve(
        &self,
        best: &mut (f64, DVec2),
        at: DVec2,
        top: &Top,
        across: DVec2,
        known: &mut Vec<[DVec3; 3]>,
    ) {
        let across = across.clamp_length_max(WITHIN * self.cutter.radius());
        let lower_side = self.cutter.lower_side(across.length());
        let is_better = |tip: f64| {
            let tip = (at + across).extend(tip);
            self.part.is_clear(self.cutter.tool(), tip, DVec3::Z, f64::INFINITY)
        };
        if best.0.is_finite() && !is_better(best.0 - lower_side) {
            return;
        }
        let lowest = top.z - lower_side;
        let landing = self.cutter.lands(self.part, at + across, lowest);
        *best = (landing.map_or(lowest, |l| l.tip) + lower_side, across);
        known.extend(landing.map(|l| l.facet).filter(|f| !known.contains(f)));
    }

    /// Moves the cutter until it leaves a place as low as some facets allow, and asks the true part there, until both
    /// agree. `facets`: those that are known, with the place as origin; `least`: height of the part there.
    fn settle(
        &self,
        at: DVec2,
        least: f64,
        mut facets: Vec<[DVec3; 3]>,
        step: f64,
        best: &mut (f64, DVec2),
    ) {
        while facets.len() < MOST_FACETS {
            let (bound, across) = self.lowest_on(&facets, least, best.1, step);
            let tip = bound - self.cutter.lower_side(across.length());
            let landing = self.cutter.lands(self.part, at + across, tip);
            let z = landing.map_or(bound, |l| l.tip + bound - tip);
            if z < best.0 {
                *best = (z, across);
            }
            match landing.map(|l| l.facet.map(|p| p - at.extend(0.0))) {
                Some(facet) if best.0 > bound + self.meet && !facets.contains(&facet) => {
                    facets.push(facet);
                }
                _ => break,
            }
        }
    }

    /// Height of the reached surface of some facets and a point at height `least`, at the origin, and from there to the
    /// axis of the cutter that leaves it. `start`, `step`: where the search for that begins, and how wide.
    fn lowest_on(
        &self,
        facets: &[[DVec3; 3]],
        least: f64,
        start: DVec2,
        step: f64,
    ) -> (f64, DVec2) {
        let radius = self.cutter.radius();
        // The part at the place itself is the first.
        let left_by = |i: usize, across: DVec2, floor: f64| match i.checked_sub(1) {
            _ if across.length() > radius => f64::INFINITY,
            Some(i) => {
                let lower_side = self.cutter.lower_side(across.length());
                self.wider.tip_on(facets[i], across, floor - lower_side) + lower_side
            }
            None => least,
        };
        lowest(left_by, facets.len() + 1, start, step, 0.5 * self.meet)
    }
}
