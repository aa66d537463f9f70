//! How far the whole assembly, cutter, shank and holder, stays clear of facets on every move.
//!
//! - *Solid*: one of the convex solids of revolution of the assembly (`solids`).
//! - *Stretch*: a piece of a move. Tip and axis go as [`PathPoint::toward`] interpolates them.
//! - *Parting plane*: a plane with the solid on one side and the facet on the other. The facet does not move, and how far
//!   the solid reaches in the plane's direction anywhere on a stretch is known; so one plane is a lower bound of the
//!   distance for the whole stretch, and a close one for a cutter that passes alongside.
//!
//! For each move and solid: (1) the facets that could be near on the move, from a tree of boxes, of which one plane may part
//! all at once; a move so long that this would be many is halved first, and empty halves are done; (2) for each of them, the solid in the middle of the
//! stretch: its signed distance is a convex function over the facet, and is minimised by cutting: the polygon that holds
//! the minimum is cut through its centroid, across the slope there (`narrow`). Every place looked at gives an upper
//! bound, the distance there, and a lower one, the plane across the slope; (3) once the plane is within the accuracy of
//! the least distance so far, or farther, the facet is done; otherwise the stretch is halved for the facets that remain.
//!
//! Source: Kuhn and Levin's method of centroid cuts: Levin, "On an algorithm for the minimization of convex functions",
//! Soviet Mathematics Doklady 6 (1965); halving of motions by bounds of the travel: Schwarzer, Saha, Latombe, "Exact
//! collision checking of robot paths", Algorithmic Foundations of Robotics V (2004).

use super::body::Placed;
use super::samples::Facets;
use super::solids::{Solid, Stretch};
use crate::geometry::boxes::{Boxed, around};
use crate::geometry::{DVec2, DVec3, nearest_on_triangle};
use crate::parallel;
use crate::tool::{Assembly, AssemblyPart};
use crate::toolpath::{PathPoint, Toolpath};
use rstar::{AABB, RTree, SelectionFunction};
use std::cell::Cell;
use std::collections::VecDeque;

/// Moves that are measured one after another, each beginning with the facet nearest to the one before. Larger: less to
/// share between threads; smaller: more moves that begin without one.
const CHUNK: usize = 64;
/// Cuts of a facet at most; each leaves less than two thirds of it.
const MOST_CUTS: usize = 48;
/// How often a stretch is halved at most.
const DEEPEST: u32 = 30;
/// Facets looked at for a solid on one move at most; for those that remain, the bound by their distance and the travel
/// and what was known of the stretch before counts. Only collisions come near it.
const MOST_LOOKS: usize = 20_000;
/// Smallest accuracy, mm.
const FINEST: f64 = 1e-6;
/// Of a collision, the depth is known to this part of it only.
const DEPTH: f64 = 0.1;
/// The gap between both bounds for one position of the cutter at which cutting ends, by that which is asked for.
const CLOSE: f64 = 0.05;
/// The parts of an assembly, in the order of [`ClearanceFigures::by_part`].
const PARTS: [AssemblyPart; 3] = [AssemblyPart::Cutter, AssemblyPart::Shank, AssemblyPart::Holder];

/// How far an assembly stays clear of facets.
#[derive(Clone, Debug, PartialEq)]
pub struct ClearanceFigures {
    /// Smallest distance, mm: at most the true one, and at least that minus the accuracy. Negative where the assembly cuts
    /// into the facets, with a depth that is known to a tenth. The distance up to which it was looked for, if nothing
    /// is nearer.
    pub smallest: f64,
    /// The part of the assembly that is so near.
    pub part: AssemblyPart,
    /// Place on the facets that is so near; if nothing is, that nearest to the first tip.
    pub at: DVec3,
    /// Index of the path point that ends the move.
    pub move_index: usize,
    /// The smallest distance of cutter, shank and holder, mm; `None` where the assembly has no such part.
    pub by_part: [Option<f64>; 3],
    /// Place on the facets that is nearest to each of them; if nothing is, that nearest to the first tip.
    pub at_by_part: [DVec3; 3],
    /// The smallest distances of cutter, shank and holder on the move that ends at each path point, mm; at the first
    /// point, there. A part that the assembly does not have has the distance up to which it was looked for.
    pub along: Vec<[f64; 3]>,
}

/// The smallest distance between `assembly` and `facets` over all moves of `path`, links and rapids too.
///
/// `beyond`: distances above it, mm, do not matter and count as equal to it. `accuracy`: by how much a distance may come
/// out too small, mm; never too large. `None` for an empty path, no facets, or numbers that are not finite.
pub fn clearance(
    path: &Toolpath,
    facets: Facets,
    assembly: &Assembly,
    beyond: f64,
    accuracy: f64,
    threads: usize,
) -> Option<ClearanceFigures> {
    let survey = Survey::new(path, facets, assembly, beyond, accuracy)?;
    survey.figures(path, facets, threads)
}

/// The same for shank and holder alone; `None` also where the assembly has neither.
pub(super) fn clearance_of_sections(
    path: &Toolpath,
    facets: Facets,
    assembly: &Assembly,
    beyond: f64,
    accuracy: f64,
    threads: usize,
) -> Option<ClearanceFigures> {
    let mut survey = Survey::new(path, facets, assembly, beyond, accuracy)?;
    survey.solids.retain(|(part, _)| *part != AssemblyPart::Cutter);
    if survey.solids.is_empty() {
        return None;
    }
    survey.figures(path, facets, threads)
}

impl Survey {
    /// What was measured of all moves.
    fn figures(&self, path: &Toolpath, facets: Facets, threads: usize) -> Option<ClearanceFigures> {
        let starts: Vec<usize> = (0..path.points.len()).step_by(CHUNK).collect();
        let chunks = parallel::map(threads, &starts, |&from| self.chunk(&path.points, from));
        let first = nearest(path.points[0].tip, facets)?;
        let mut figures = ClearanceFigures {
            smallest: self.beyond,
            part: AssemblyPart::Cutter,
            at: first,
            move_index: 0,
            by_part: PARTS.map(|p| self.solids.iter().any(|s| s.0 == p).then_some(self.beyond)),
            at_by_part: [first; 3],
            along: Vec::with_capacity(path.points.len()),
        };
        for (i, of_move) in chunks.iter().flatten().enumerate() {
            let mut least = [self.beyond; 3];
            for (k, known) in of_move.iter().enumerate() {
                let Some(known) = known else { continue };
                let distance = known.distance();
                least[k] = least[k].min(distance);
                if let (true, Some(at)) =
                    (figures.by_part[k].is_some_and(|d| distance < d), known.at)
                {
                    figures.at_by_part[k] = at;
                }
                figures.by_part[k] = figures.by_part[k].map(|d| d.min(distance));
                if let (true, Some(at)) = (distance < figures.smallest, known.at) {
                    figures.smallest = distance;
                    (figures.part, figures.at, figures.move_index) = (PARTS[k], at, i);
                }
            }
            figures.along.push(least);
        }
        Some(figures)
    }
}

/// The place of the facets nearest to a point.
fn nearest(point: DVec3, facets: Facets) -> Option<DVec3> {
    let on = |f: &[u32; 3]| {
        let corners = facets.corners(f);
        let [a, b, c] = nearest_on_triangle(point, corners);
        corners[0] * a + corners[1] * b + corners[2] * c
    };
    let nearer = |p: &DVec3, q: &DVec3| p.distance(point).total_cmp(&q.distance(point));
    facets.faces.iter().map(on).min_by(nearer)
}

/// A facet.
struct Facet {
    corners: [DVec3; 3],
    /// The sphere around it.
    middle: DVec3,
    radius: f64,
}

/// What is measured, and against what.
struct Survey {
    facets: Vec<Facet>,
    /// Boxes around them, with their numbers.
    tree: RTree<Boxed>,
    solids: Vec<(AssemblyPart, Solid)>,
    beyond: f64,
    accuracy: f64,
}

/// What is known of a part of the assembly on a move.
#[derive(Copy, Clone, Debug)]
struct Known {
    /// The least distance measured at any time, mm: the true one is not greater.
    measured: f64,
    /// Where on the facets.
    at: Option<DVec3>,
    /// Of all facets that could be nearer, the least that their distances may be, mm.
    least: f64,
}

impl Known {
    /// At most the true distance.
    fn distance(&self) -> f64 {
        self.measured.min(self.least)
    }

    /// Notes that no more is known of a facet than that it is not nearer than `least`, around a place of it.
    fn is_at_least(&mut self, least: f64, place: DVec3) {
        self.least = self.least.min(least);
        if self.least < self.measured {
            self.at = self.at.or(Some(place));
        }
    }

    /// Whether a place is nearer than what was measured so far, which it then replaces.
    fn is_nearer(&mut self, found: &Found) -> bool {
        let is_nearer = found.upper < self.measured;
        if is_nearer {
            (self.measured, self.at) = (found.upper, Some(found.at));
        }
        is_nearer
    }
}

/// The facets whose boxes are within a distance of a solid in the middle of a stretch, and that no plane parts from it far
/// enough: of a floor below a holder one plane says it of all facets.
struct Near<'a> {
    solid: &'a Solid,
    middle: &'a Middle,
    distance: f64,
    /// Parted so far, a box need not be opened, mm.
    enough: f64,
    /// The least that boxes were parted that were not opened for that, mm, and the middle of that box.
    parted: &'a Cell<Option<(f64, DVec3)>>,
}

impl Near<'_> {
    fn includes(&self, envelope: &AABB<[f64; 3]>) -> bool {
        let [low, high] = [envelope.lower(), envelope.upper()].map(DVec3::from_array);
        let (centre, half) = (0.5 * (low + high), 0.5 * (high - low));
        let seen = self.solid.see(self.middle.at, centre);
        if seen.distance - half.length() > self.distance {
            return false;
        }
        let n = seen.outward;
        let nearest = n.dot(centre) - n.abs().dot(half);
        let parted = nearest - self.solid.support(n, &self.middle.stretch);
        if parted < self.enough {
            return true;
        }
        if self.parted.get().is_none_or(|(least, _)| parted < least) {
            self.parted.set(Some((parted, centre)));
        }
        false
    }
}

impl SelectionFunction<Boxed> for Near<'_> {
    fn should_unpack_parent(&self, envelope: &AABB<[f64; 3]>) -> bool {
        self.includes(envelope)
    }

    fn should_unpack_leaf(&self, leaf: &Boxed) -> bool {
        use rstar::RTreeObject;
        self.includes(&leaf.envelope())
    }
}

/// A piece of a move that is still to be measured, by the parts of the move at which it begins and ends.
struct Open {
    from: f64,
    to: f64,
    /// How often the move was halved.
    depth: u32,
    /// The facets that could be near, each with what its distance is at least, mm; `None` while the move is too long to
    /// say.
    facets: Option<Vec<(u32, f64)>>,
}

/// A solid in the middle of a stretch.
struct Middle {
    at: Placed,
    /// The stretch around it.
    stretch: Stretch,
    /// How far a place of the solid goes from the middle to either end, mm.
    travel: f64,
}

/// What is sought of a facet.
struct Wanted {
    /// Distances above it do not matter, mm.
    need: f64,
    /// By how much a lower bound may be too small, mm.
    tolerance: f64,
}

/// Bounds of the distance of a facet.
struct Found {
    /// The least distance in the middle of the stretch found so far, mm.
    upper: f64,
    /// Where.
    at: DVec3,
    /// No less than this is the distance in the middle, mm.
    lower: f64,
    /// Nor less than this anywhere on the stretch, mm.
    least: f64,
}

impl Survey {
    /// `None` where there is nothing to measure.
    fn new(
        path: &Toolpath,
        facets: Facets,
        assembly: &Assembly,
        beyond: f64,
        accuracy: f64,
    ) -> Option<Self> {
        let tips = || path.points.iter().map(|p| p.tip);
        let of_face = |f: &[u32; 3]| {
            let corners = facets.corners(f);
            let middle = (corners[0] + corners[1] + corners[2]) / 3.0;
            let radius = corners.iter().map(|p| p.distance(middle)).fold(0.0, f64::max);
            Facet { corners, middle, radius }
        };
        let all: Vec<Facet> = facets.faces.iter().map(of_face).collect();
        let finite = tips().chain(path.points.iter().map(|p| p.axis)).all(DVec3::is_finite)
            && all.iter().all(|f| f.radius.is_finite() && f.middle.is_finite());
        if path.points.is_empty() || all.is_empty() || !finite {
            return None;
        }
        let places = || tips().chain(all.iter().flat_map(|f| f.corners));
        let low = places().fold(DVec3::INFINITY, DVec3::min);
        let high = places().fold(DVec3::NEG_INFINITY, DVec3::max);
        let far = low.distance(high);
        // Even of a tool of any length, no more can come near.
        let beyond = beyond.max(0.0).min(far + 1.0);
        let solids = Solid::of(assembly, far + beyond + 1.0);
        let boxed = |(facet, number): (&Facet, u32)| around(number, &facet.corners);
        let tree = RTree::bulk_load(all.iter().zip(0..).map(boxed).collect());
        Some(Self { facets: all, tree, solids, beyond, accuracy: accuracy.max(FINEST) })
    }

    /// What is known of each part on the moves from `from` on.
    fn chunk(&self, points: &[PathPoint], from: usize) -> Vec<[Option<Known>; 3]> {
        let to = (from + CHUNK).min(points.len());
        // The facet nearest to each solid on the move before.
        let mut last: Vec<Option<u32>> = vec![None; self.solids.len()];
        let mut smallest = [self.beyond; 3];
        let of_move = |i: usize| {
            let ends = [&points[i.saturating_sub(1)], &points[i]];
            let mut of_parts = [None; 3];
            let mut of_move = self.beyond;
            for ((part, solid), last) in self.solids.iter().zip(&mut last) {
                let k = *part as usize;
                // What is neither the least on this move nor the least of this part need not be known closely.
                let cap = of_move.max(smallest[k]);
                let known =
                    of_parts[k].get_or_insert(Known { measured: cap, at: None, least: cap });
                self.measure(solid, ends, known, last);
                // What was measured, not its lower bounds: the inaccuracies of many moves would add up.
                of_move = of_move.min(known.measured);
                smallest[k] = smallest[k].min(known.measured);
            }
            of_parts
        };
        (from..to).map(of_move).collect()
    }

    /// Measures a solid on a move.
    fn measure(
        &self,
        solid: &Solid,
        ends: [&PathPoint; 2],
        known: &mut Known,
        last: &mut Option<u32>,
    ) {
        let first = Middle::of(solid, ends, [0.0, 1.0]);
        let tip = first.at.tip.to_array();
        let nearest = || self.tree.nearest_neighbor(tip).map(|b| b.data);
        if let Some(f) = last.or_else(nearest) {
            let wanted = self.wanted(known);
            let found = narrow(&self.facets[f as usize], solid, &first, &wanted);
            known.is_nearer(&found);
        }
        let mut looks = 0;
        // All of the move before its parts: of a deep collision the depth is known early, and with it how closely the rest
        // has to be.
        let whole = Open { from: 0.0, to: 1.0, depth: 0, facets: None };
        let mut open = VecDeque::from([whole]);
        while let Some(stretch) = open.pop_front() {
            let middle = Middle::of(solid, ends, [stretch.from, stretch.to]);
            let travel = middle.travel;
            let is_last = stretch.depth >= DEEPEST || travel <= 0.5 * self.accuracy;
            let halves = |facets: Option<Vec<(u32, f64)>>| {
                let between = 0.5 * (stretch.from + stretch.to);
                let depth = stretch.depth + 1;
                let half = |from, to| Open { from, to, depth, facets: facets.clone() };
                [half(stretch.from, between), half(between, stretch.to)]
            };
            let facets = match stretch.facets {
                Some(facets) => facets,
                None => {
                    let distance = known.measured.max(0.0) + travel;
                    let Wanted { need, tolerance } = self.wanted(known);
                    // What is farther than all that matters is told from what is just as far.
                    let slack = if need < self.beyond { tolerance } else { 0.0 };
                    let (enough, parted) = (need - slack, Cell::new(None));
                    let near = Near { solid, middle: &middle, distance, enough, parted: &parted };
                    let mut near = self.tree.locate_with_selection_function(near).map(|b| b.data);
                    let is_long = travel > known.measured.max(solid.widest()) && !is_last;
                    let facets: Vec<(u32, f64)> = match is_long {
                        true if near.next().is_some() => {
                            open.extend(halves(None));
                            continue;
                        }
                        true => Vec::new(),
                        false => near.map(|f| (f, f64::NEG_INFINITY)).collect(),
                    };
                    if let Some((least, place)) = parted.get() {
                        known.is_at_least(least, place);
                    }
                    facets
                }
            };
            let mut rest = Vec::new();
            for (f, known_least) in facets {
                let facet = &self.facets[f as usize];
                let away = solid.see(middle.at, facet.middle).distance - facet.radius - travel;
                let away = away.max(known_least);
                if away >= known.measured {
                    continue;
                }
                looks += 1;
                if looks > MOST_LOOKS {
                    known.is_at_least(away, facet.middle);
                    continue;
                }
                let found = narrow(facet, solid, &middle, &self.wanted(known));
                if known.is_nearer(&found) {
                    *last = Some(f);
                }
                let Wanted { need, tolerance } = self.wanted(known);
                let least = found.least.max(found.lower - travel).max(away);
                if is_last || least >= need - tolerance {
                    known.is_at_least(least, found.at);
                } else {
                    rest.push((f, least));
                }
            }
            if !rest.is_empty() {
                open.extend(halves(Some(rest)));
            }
        }
    }

    fn wanted(&self, known: &Known) -> Wanted {
        let tolerance = self.accuracy.max(-DEPTH * known.measured);
        Wanted { need: known.measured, tolerance }
    }
}

impl Middle {
    fn of(solid: &Solid, [start, end]: [&PathPoint; 2], [from, to]: [f64; 2]) -> Self {
        let place = |t: f64| {
            let point = start.toward(end, t);
            Placed { tip: point.tip, axis: point.axis }
        };
        let at = place(0.5 * (from + to));
        let ends = [place(from), place(to)];
        let far = |p: &Placed| p.tip.distance(at.tip) + p.axis.distance(at.axis) * solid.reach();
        let travel = far(&ends[0]).max(far(&ends[1]));
        // The axis is `u / |u|` of a `u` on a straight line: its second derivative is at most three times the square of
        // `|u'| / |u|`, hence this bend over the stretch.
        let [u, v] = [from, to].map(|t| start.axis.lerp(end.axis, t));
        let way = v - u;
        let part = (-u.dot(way) / way.length_squared().max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
        let shortest = u.lerp(v, part).length().max(f64::MIN_POSITIVE);
        let turn = way.length() / shortest;
        Self { at, stretch: Stretch { ends, sag: 0.375 * turn * turn }, travel }
    }
}

/// Bounds of the distance between a solid and a facet.
fn narrow(facet: &Facet, solid: &Solid, middle: &Middle, wanted: &Wanted) -> Found {
    let [a, b, c] = facet.corners;
    let sides = [b - a, c - a];
    let still = Stretch::still(middle.at);
    let mut found =
        Found { upper: f64::INFINITY, at: a, lower: f64::NEG_INFINITY, least: f64::NEG_INFINITY };
    // Looks at a place, given by its parts of both sides; its slope along them.
    let look = |found: &mut Found, at: DVec2| {
        let place = a + sides[0] * at.x + sides[1] * at.y;
        let seen = solid.see(middle.at, place);
        let n = seen.outward;
        let nearest = facet.corners.iter().map(|p| n.dot(*p)).fold(f64::INFINITY, f64::min);
        found.lower = found.lower.max(nearest - solid.support(n, &still));
        found.least = found.least.max(nearest - solid.support(n, &middle.stretch));
        if seen.distance < found.upper {
            (found.upper, found.at) = (seen.distance, place);
        }
        DVec2::new(n.dot(sides[0]), n.dot(sides[1]))
    };
    let mut polygon = vec![DVec2::ZERO, DVec2::X, DVec2::Y];
    for _ in 0..MOST_CUTS {
        let centre = centroid(&polygon);
        let slope = look(&mut found, centre);
        // Where the plane of that slope is lowest.
        let lower = |p: &&DVec2, q: &&DVec2| slope.dot(**p).total_cmp(&slope.dot(**q));
        if let Some(&corner) = polygon.iter().min_by(lower) {
            look(&mut found, corner);
        }
        let enough = wanted.need.min(found.upper) - wanted.tolerance;
        if found.least.max(found.lower - middle.travel) >= enough
            || found.upper - found.lower <= CLOSE * wanted.tolerance
        {
            break;
        }
        polygon = below(&polygon, centre, slope);
        if polygon.len() < 3 {
            break;
        }
    }
    found
}

/// The part of a convex polygon that is not higher than `centre` on a plane of that slope.
fn below(polygon: &[DVec2], centre: DVec2, slope: DVec2) -> Vec<DVec2> {
    let height = |p: DVec2| slope.dot(p - centre);
    let mut kept = Vec::with_capacity(polygon.len() + 1);
    for (i, &p) in polygon.iter().enumerate() {
        let q = polygon[(i + 1) % polygon.len()];
        let (from, to) = (height(p), height(q));
        if from <= 0.0 {
            kept.push(p);
        }
        if (from < 0.0 && to > 0.0) || (from > 0.0 && to < 0.0) {
            kept.push(p.lerp(q, from / (from - to)));
        }
    }
    kept
}

/// Centroid of a convex polygon; the mean of its corners where it has no area.
fn centroid(polygon: &[DVec2]) -> DVec2 {
    let (mut area, mut moment, mut sum) = (0.0, DVec2::ZERO, DVec2::ZERO);
    let first = polygon.first().copied().unwrap_or_default();
    for (i, &p) in polygon.iter().enumerate() {
        let (u, v) = (p - first, polygon[(i + 1) % polygon.len()] - first);
        let part = u.perp_dot(v);
        area += part;
        moment += (u + v) * part;
        sum += u;
    }
    let middle = moment / (3.0 * area);
    first + if middle.is_finite() { middle } else { sum / polygon.len().max(1) as f64 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::math::{cos, sin};
    use crate::tool::{Section, Tool};
    use crate::toolpath::MoveKind;

    fn least(distances: [f64; 3]) -> f64 {
        distances.into_iter().fold(f64::INFINITY, f64::min)
    }

    const ACCURACY: f64 = 1e-3;

    fn path(places: &[(DVec3, DVec3)]) -> Toolpath {
        let point = |&(tip, axis): &(DVec3, DVec3)| PathPoint {
            kind: MoveKind::Cut,
            pass: 0,
            region: 0,
            tip,
            axis: axis.normalize(),
            normal: axis.normalize(),
            flat: None,
            feed: 1.0,
            mrr: 0.0,
            alpha: 0.0,
            time: 0.0,
        };
        Toolpath { points: places.iter().map(point).collect() }
    }

    fn ball() -> Assembly {
        Assembly::of_cutter(Tool::new(3.0, 3.0).unwrap(), 12.0)
    }

    /// A ball of radius 3 with a shank that widens to 5 and a holder.
    fn assembly() -> Assembly {
        let section = |part, heights, radii| Section { part, heights, radii };
        let sections = vec![
            section(AssemblyPart::Shank, [12.0, 40.0], [3.0, 5.0]),
            section(AssemblyPart::Holder, [40.0, 70.0], [12.0, 16.0]),
        ];
        Assembly { sections, ..ball() }
    }

    fn measured(
        places: &[(DVec3, DVec3)],
        triangles: &[[DVec3; 3]],
        assembly: &Assembly,
    ) -> ClearanceFigures {
        let positions: Vec<DVec3> = triangles.iter().flatten().copied().collect();
        let faces: Vec<[u32; 3]> =
            (0..triangles.len() as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
        let facets = Facets { positions: &positions, faces: &faces };
        let of = |threads| clearance(&path(places), facets, assembly, 20.0, ACCURACY, threads);
        let figures = of(1).unwrap();
        assert_eq!(of(3).unwrap(), figures);
        assert_eq!(figures.along.len(), places.len());
        figures
    }

    fn is_at_most(found: f64, truth: f64) {
        assert!(found <= truth + 1e-9 && found >= truth - ACCURACY, "{found}, should be {truth}");
    }

    /// A square of two facets.
    fn wall(corner: DVec3, u: DVec3, v: DVec3) -> [[DVec3; 3]; 2] {
        [[corner, corner + u, corner + u + v], [corner, corner + u + v, corner + v]]
    }

    /// Ten thousand facets as near as each other, on a move over all of them: the distance is known, not only bounded.
    #[test]
    fn a_wide_holder_passes_over_a_fine_floor() {
        let section = |part, heights, radii| Section { part, heights, radii };
        let holder = vec![section(AssemblyPart::Holder, [10.0, 40.0], [20.0, 20.0])];
        let wide =
            Assembly { sections: holder, ..Assembly::of_cutter(Tool::new(4.0, 4.0).unwrap(), 8.0) };
        let cell = |i: i32| {
            let corner = DVec3::new(f64::from(i % 100), f64::from(i / 100), 0.0) - 50.0 * DVec3::X;
            wall(corner - 50.0 * DVec3::Y, DVec3::X, DVec3::Y)
        };
        let floor: Vec<[DVec3; 3]> = (0..10_000).flat_map(cell).collect();
        let at = |x: f64| (DVec3::new(x, -0.5 * x, 0.5), DVec3::Z);
        let figures = measured(&[at(-40.0), at(40.0)], &floor, &wide);
        is_at_most(figures.by_part[2].unwrap(), 10.5);
        is_at_most(figures.by_part[0].unwrap(), 0.5);
    }

    const BIG: f64 = 100.0;

    /// The wall x = 10.
    fn upright() -> [[DVec3; 3]; 2] {
        let corner = DVec3::new(10.0, -0.5 * BIG, -0.5 * BIG);
        wall(corner, DVec3::Y * BIG, DVec3::Z * BIG)
    }

    #[test]
    fn a_ball_passes_a_wall_at_a_known_distance() {
        let at = |x: f64, y: f64| (DVec3::new(x, y, 0.0), DVec3::Z);
        let figures = measured(&[at(0.0, -30.0), at(6.0, 0.0), at(2.0, 30.0)], &upright(), &ball());
        is_at_most(figures.smallest, 1.0);
        assert!((figures.at.x - 10.0).abs() < 1e-9 && figures.part == AssemblyPart::Cutter);
        is_at_most(least(figures.along[0]), 7.0);
        is_at_most(least(figures.along[2]), 1.0);
        assert_eq!(figures.by_part[1], None);
        // And a tilted ball of no length beside its own contact.
        let short = Assembly::of_cutter(Tool::new(3.0, 3.0).unwrap(), 3.0);
        let axis = DVec3::new(-0.8, 0.0, 0.6);
        let figures =
            measured(&[(DVec3::new(6.5, 0.0, 0.0) - axis * 3.0, axis)], &upright(), &short);
        is_at_most(figures.smallest, 0.5);
        assert!(figures.at.distance(DVec3::new(10.0, 0.0, 0.0)) < 0.1, "{}", figures.at);
    }

    #[test]
    fn what_is_far_away_counts_as_the_distance_asked_for() {
        let far = (DVec3::new(-80.0, 0.0, 0.0), DVec3::Z);
        let figures = measured(&[far, far], &upright(), &ball());
        assert_eq!((figures.smallest, figures.along), (20.0, vec![[20.0; 3]; 2]));
    }

    #[test]
    fn a_cone_stands_beside_an_edge() {
        // The edge of a plate, at height 30 and parallel to Y: there the shank is less than 5 wide, and its side leans.
        let plate = wall(DVec3::new(9.0, -BIG, 30.0), DVec3::X * BIG, DVec3::Y * 2.0 * BIG);
        let at = |y: f64| (DVec3::new(0.0, y, 0.0), DVec3::Z);
        let mut cone = assembly();
        cone.sections.truncate(1);
        let figures = measured(&[at(-20.0), at(20.0)], &plate, &cone);
        // Distance from the line through (12, 3) and (40, 5).
        let truth = ((9.0 - 3.0) * 28.0 - (30.0 - 12.0) * 2.0) / (28.0f64 * 28.0 + 4.0).sqrt();
        is_at_most(figures.smallest, truth);
        assert_eq!(figures.part, AssemblyPart::Shank);
        assert!((figures.at.x - 9.0).abs() < 1e-6 && (figures.at.z - 30.0).abs() < 1e-6);
        is_at_most(figures.by_part[1].unwrap(), truth);
        assert_eq!(figures.at_by_part[1], figures.at);
        // The cutter ends 18 below.
        is_at_most(figures.by_part[0].unwrap(), DVec2::new(6.0, 18.0).length());
    }

    #[test]
    fn a_tilted_shank_passes_over_a_corner() {
        // Straight shank of radius 3; axis in the plane X Z, leaning by 30 degrees.
        let section = Section { part: AssemblyPart::Shank, heights: [12.0, 60.0], radii: [3.0; 2] };
        let tool = Assembly { sections: vec![section], ..ball() };
        let axis = DVec3::new(0.5, 0.0, 0.75f64.sqrt());
        // A corner that points up, below the shank at a height of 30, 5 from the axis.
        let place = axis * 30.0 + DVec3::new(axis.z, 0.0, -axis.x) * 5.0;
        let foot = |x: f64, y: f64| place + DVec3::new(x, y, -20.0);
        let spike = [
            [place, foot(1.0, 1.0), foot(1.0, -1.0)],
            [place, foot(1.0, -1.0), foot(2.0, 0.0)],
            [place, foot(2.0, 0.0), foot(1.0, 1.0)],
        ];
        let along = |y: f64| (DVec3::Y * y, axis);
        let figures = measured(&[along(-10.0), along(7.0)], &spike, &tool);
        is_at_most(figures.smallest, 2.0);
        assert!(figures.part == AssemblyPart::Shank && figures.at.distance(place) < 1e-6);
        assert_eq!(figures.move_index, 1);
    }

    /// Both ends of the move are clear of the spike by more than what is asked for; the axis swings through it.
    #[test]
    fn a_shank_that_swings_into_something_is_found() {
        let tip = DVec3::ZERO;
        let lean = |x: f64| DVec3::new(x, 0.0, 1.0);
        let top = DVec3::new(1.0, 0.0, 60.0);
        let spike = [[top, top + DVec3::new(0.1, 30.0, 0.0), top + DVec3::new(0.0, 30.0, 0.2)]];
        let ends = [(tip, lean(-0.8)), (tip, lean(0.9))];
        let still = |k: usize| measured(&[ends[k]], &spike, &assembly()).smallest;
        assert!(still(0) > 15.0 && still(1) > 15.0);
        let figures = measured(&ends, &spike, &assembly());
        // On the axis it lies 10 below the top of the holder, and that is known to a tenth.
        assert!(figures.smallest < -9.98 && figures.smallest > -11.1, "{}", figures.smallest);
        assert_eq!((figures.part, figures.move_index), (AssemblyPart::Holder, 1));
        // A little farther back it touches nothing.
        let beside = spike.map(|t| t.map(|p| p + DVec3::Y * 16.5));
        let figures = measured(&ends, &beside, &assembly());
        assert!(figures.smallest > 0.0 && figures.smallest < 3.0, "{}", figures.smallest);
    }

    #[test]
    fn facets_that_the_cutter_enters_are_a_collision() {
        let at = |x: f64| (DVec3::new(x, 0.0, 0.0), DVec3::Z);
        let figures = measured(&[at(0.0), at(7.5), at(0.0)], &upright(), &ball());
        assert!(figures.smallest <= -0.5 && figures.smallest > -0.56, "{}", figures.smallest);
        assert_eq!(figures.part, AssemblyPart::Cutter);
    }

    /// A rough landscape that tools pass over, with every position of a fine division compared.
    #[test]
    fn no_position_is_nearer_than_the_figures_say() {
        let height = |x: f64, y: f64| 3.0 * sin(0.4 * x) * cos(0.3 * y);
        let at = |i: u32, j: u32| {
            let (x, y) = (2.5 * f64::from(i) - 25.0, 2.5 * f64::from(j) - 25.0);
            DVec3::new(x, y, height(x, y))
        };
        let square = |i: u32, j: u32| {
            let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            [[a, b, c], [a, c, d]]
        };
        let land: Vec<[DVec3; 3]> =
            (0..20).flat_map(|i| (0..20).flat_map(move |j| square(i, j))).collect();
        let step = |k: u32| {
            let k = f64::from(k);
            let tip =
                DVec3::new(18.0 * sin(1.1 * k), 18.0 * cos(0.7 * k), 5.0 + 1.5 * sin(2.0 * k));
            (tip, DVec3::new(0.9 * sin(3.0 * k), 0.9 * cos(1.3 * k), 1.0))
        };
        let places: Vec<(DVec3, DVec3)> = (0..8).map(step).collect();
        let tool = assembly();
        let figures = measured(&places, &land, &tool);
        let points = path(&places).points;
        let solids = Solid::of(&tool, 1e3);
        let mut smallest = [f64::INFINITY; 3];
        for i in 1..points.len() {
            let mut of_move = f64::INFINITY;
            for k in 0..=60 {
                let point = points[i - 1].toward(&points[i], f64::from(k) / 60.0);
                let at = Placed { tip: point.tip, axis: point.axis };
                for ([a, b, c], (part, solid)) in
                    land.iter().flat_map(|t| solids.iter().map(move |s| (t, s)))
                {
                    for (u, v) in (0..=4).flat_map(|u| (0..=4 - u).map(move |v| (u, v))) {
                        let (u, v) = (f64::from(u) / 4.0, f64::from(v) / 4.0);
                        let place = *a + (*b - *a) * u + (*c - *a) * v;
                        let distance = solid.see(at, place).distance;
                        of_move = of_move.min(distance);
                        let part = &mut smallest[*part as usize];
                        *part = part.min(distance);
                    }
                }
            }
            let found = least(figures.along[i]);
            let slack = 0.15 + DEPTH * (-of_move).max(0.0);
            assert!(found <= of_move + 1e-9 && found >= of_move - slack, "{i}: {found} {of_move}");
        }
        for (found, truth) in figures.by_part.iter().zip(smallest) {
            let (found, truth) = (found.unwrap(), truth.min(20.0));
            let slack = 0.15 + DEPTH * (-truth).max(0.0);
            assert!(found <= truth + 1e-9 && found >= truth - slack, "{found} {truth}");
        }
    }

    #[test]
    fn nothing_is_measured_of_nothing() {
        let one = [[DVec3::ZERO, DVec3::X, DVec3::Y]];
        let facets = Facets { positions: &one[0], faces: &[[0, 1, 2]] };
        let nothing = Facets { positions: &[], faces: &[] };
        let of = |path: &Toolpath, facets| clearance(path, facets, &ball(), 5.0, 0.01, 1);
        let some = path(&[(DVec3::Z, DVec3::Z)]);
        assert!(of(&Toolpath::default(), facets).is_none() && of(&some, nothing).is_none());
        assert!(of(&path(&[(DVec3::NAN, DVec3::Z)]), facets).is_none());
        // An axis that turns round at once passes everything: no distance is known, but the search ends.
        let turned = path(&[(DVec3::Z * 9.0, DVec3::Z), (DVec3::Z * 9.0, DVec3::NEG_Z)]);
        assert!(of(&turned, facets).unwrap().smallest < 0.0);
        let endless = Assembly::of_cutter(Tool::new(3.0, 3.0).unwrap(), f64::INFINITY);
        let figures = clearance(&some, facets, &endless, f64::INFINITY, 0.0, 1).unwrap();
        assert!((figures.smallest - 1.0).abs() < 1e-3, "{}", figures.smallest);
    }
}
