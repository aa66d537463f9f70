//! The net without what lies outside of the outline: triangles across it are cut where their sides cross it.
//!
//! The outline crosses a side where one end is outside, where the surface jumps between two ends, at the upper edge
//! of a wall, or where the surface becomes steeper than it is machined. Each crossing is found by bisection from each end
//! that is on the surface: on a steep slope the corners of the net alone would make an outline of steps that are long along
//! the axis. Steep places in the midst of gentler ones are kept: they are thinner than a triangle.

use super::facet::area_normal;
use super::lattice::{Key, Triangle};
use super::net::{Net, SAME_SIDE, tangent};
use super::terrain::Height;
use crate::geometry::DVec3;
use crate::mesh::TriangleSoup;
use crate::parallel;
use std::collections::{BTreeMap, BTreeSet, HashMap, HashSet};

/// Bisections of a side. Fewer: the surface ends farther before the upper edge of a wall, and what is cut within the
/// tolerance of the wall there counts as a deep cut.
const HALVINGS: u32 = 10;
/// A crossing nearer to an end of the side than this fraction of it is at that end: the corner of the net is moved there, or, at
/// the end that is outside, all that are as near are one. Else there would be slivers, and notches where those are left out.
const AT_END: f64 = 0.1;
/// Cosine of the angle between a triangle and the surface, above which a triangle on the outline is kept.
const ALONG: f64 = 0.95;
/// Height of a triangle on the outline over its longest side, seen from above, below which it is left out.
const SLIM: f64 = 0.03;
/// How much steeper than the steepest slope a straight line between two places of one surface may seem, times; and mm.
const SLACK: (f64, f64) = (1.05, 1e-4);

/// A corner of the cut net.
#[derive(Copy, Clone, Debug, PartialEq, Eq, Hash)]
enum Corner {
    /// A place of the net.
    At(Key),
    /// The last place of the surface on the way from the first place to the second.
    Crossing(Key, Key),
}

/// A place of the surface, mm, and its unit normal.
type Place = (DVec3, DVec3);

/// Where the outline crosses a side.
#[derive(Copy, Clone, Debug)]
struct Crossing {
    /// Part of the way.
    part: f64,
    place: Place,
    /// From where the side leads there.
    from: Key,
}

/// Takes out the crossings that are at the beginning of their sides: the place of the farthest one, by the corner that it
/// takes the place of.
fn move_corners(crossings: &mut BTreeMap<[Key; 2], Option<Crossing>>) -> BTreeMap<Key, Place> {
    let mut farthest: BTreeMap<Key, Crossing> = BTreeMap::new();
    for ([from, _], slot) in crossings.iter_mut() {
        let Some(crossing) = slot.take_if(|c| c.part <= AT_END) else { continue };
        let best = farthest.entry(*from).or_insert(crossing);
        if crossing.part > best.part {
            *best = crossing;
        }
    }
    farthest.into_iter().map(|(from, crossing)| (from, crossing.place)).collect()
}

/// Joins the crossings that are at the end of their sides, where that is outside: to the one that is nearest to it.
fn join_at_ends(crossings: &mut BTreeMap<[Key; 2], Option<Crossing>>, machined: &Machined) {
    let is_at_end =
        |to: Key, crossing: &Crossing| crossing.part >= 1.0 - AT_END && !machined.is_on(to);
    let mut nearest: BTreeMap<Key, Crossing> = BTreeMap::new();
    for ([_, to], crossing) in crossings.iter() {
        let Some(crossing) = crossing.filter(|c| is_at_end(*to, c)) else { continue };
        let best = nearest.entry(*to).or_insert(crossing);
        if crossing.part > best.part {
            *best = crossing;
        }
    }
    for ([_, to], crossing) in crossings.iter_mut() {
        if let Some(own) = crossing.as_mut().filter(|c| is_at_end(*to, c)) {
            *own = nearest[to];
        }
    }
}

/// The net within the outline, and the normals at its corners: what has a normal of at least `steepest` along the axis.
pub(super) fn trimmed(net: &Net, steepest: f64) -> (TriangleSoup, Vec<DVec3>) {
    let machined = Machined::of(net, steepest);
    let triangles: Vec<Triangle> =
        net.triangles().into_iter().filter(|t| t.iter().any(|k| machined.is_gentle(*k))).collect();
    let crossed: BTreeSet<[Key; 2]> = triangles
        .iter()
        .flat_map(|t| (0..3).flat_map(|k| [[t[k], t[(k + 1) % 3]], [t[(k + 1) % 3], t[k]]]))
        .filter(|[from, to]| machined.is_crossed(*from, *to))
        .collect();
    let crossed: Vec<[Key; 2]> = crossed.into_iter().collect();
    let found = parallel::map(net.threads, &crossed, |[from, to]| machined.crossing(*from, *to));
    let mut crossings: BTreeMap<[Key; 2], Option<Crossing>> =
        crossed.into_iter().zip(found).collect();
    let moved = move_corners(&mut crossings);
    join_at_ends(&mut crossings, &machined);
    let (numbers, sides, out) = (HashMap::new(), HashSet::new(), TriangleSoup::default());
    let mut soup = Soup { machined, crossings, moved, numbers, sides, out, normals: Vec::new() };
    triangles.iter().for_each(|t| soup.add_cut(*t));
    (soup.out, soup.normals)
}

/// Which corners of the net are machined.
struct Machined<'a> {
    net: &'a Net<'a>,
    /// Cosine of the steepest slope that is machined.
    steepest: f64,
    /// Corners of triangles of which no corner is gentle enough.
    beyond: HashSet<Key>,
}

impl<'a> Machined<'a> {
    fn of(net: &'a Net<'a>, steepest: f64) -> Self {
        let mut machined = Self { net, steepest, beyond: HashSet::new() };
        let triangles = net.triangles().into_iter();
        let steep = triangles.filter(|t| !t.iter().any(|k| machined.is_gentle(*k)));
        machined.beyond = steep.flatten().collect();
        machined
    }

    fn is_gentle(&self, key: Key) -> bool {
        self.net.known(key).is_some_and(|h| h.normal.z >= self.steepest)
    }

    fn is_on(&self, key: Key) -> bool {
        self.net.known(key).is_some() && !self.beyond.contains(&key)
    }

    /// Whether the outline lies between two places, of which the first is machined.
    fn is_crossed(&self, from: Key, to: Key) -> bool {
        let net = self.net;
        match (net.known(from), net.known(to)) {
            (Some(a), Some(b)) if self.is_on(from) => {
                let length = net.lattice.at(from).distance(net.lattice.at(to));
                !self.is_on(to) || net.jumps(a, b, length)
            }
            _ => self.is_on(from),
        }
    }

    /// The last place that is machined on the way from one place to another; `None`: at once.
    fn crossing(&self, from: Key, to: Key) -> Option<Crossing> {
        let steepest = if self.is_on(to) { f64::NEG_INFINITY } else { self.steepest };
        crossing(self.net, steepest, from, to)
    }
}

/// The last place of the surface, no steeper than this cosine, on the way from one place to another; `None`: at once.
fn crossing(net: &Net, steepest: f64, from: Key, to: Key) -> Option<Crossing> {
    let (begin, end) = (net.lattice.at(from), net.lattice.at(to));
    let first = net.known(from)?;
    let length = begin.distance(end);
    let (mut low, mut high) = (0.0, 1.0);
    let mut place = None;
    let mut near = first;
    for _ in 0..HALVINGS {
        let part = 0.5 * (low + high);
        let at = begin.lerp(end, part);
        // Just beyond an edge the cutter may seem to rest on it, or be lower than the surface leads there.
        let belongs = |h: &Height| {
            let slope = tangent(first.normal).max(tangent(h.normal)).min(net.steepest);
            let may_differ = SLACK.0 * slope * part * length + SLACK.1;
            (h.z - first.z).abs() <= may_differ
                && h.normal.dot(first.normal) >= SAME_SIDE
                && h.normal.z >= steepest
        };
        match net.height(at, near).filter(belongs) {
            Some(height) => {
                (low, near, place) = (part, height, Some((at.extend(height.z), height.normal)))
            }
            None => high = part,
        }
    }
    place.map(|place| Crossing { part: low, place, from })
}

struct Soup<'a> {
    machined: Machined<'a>,
    crossings: BTreeMap<[Key; 2], Option<Crossing>>,
    moved: BTreeMap<Key, Place>,
    numbers: HashMap<Corner, u32>,
    /// Sides of faces.
    sides: HashSet<[u32; 2]>,
    out: TriangleSoup,
    normals: Vec<DVec3>,
}

impl Soup<'_> {
    /// What of a triangle is on the surface.
    fn add_cut(&mut self, t: [Key; 3]) {
        let is_on = t.map(|k| self.machined.is_on(k));
        // Side k leads from corner k to the next.
        let is_cut = [0, 1, 2].map(|k| {
            let (a, b) = (t[k], t[(k + 1) % 3]);
            self.crossings.contains_key(&[a, b]) || self.crossings.contains_key(&[b, a])
        });
        match is_cut.iter().filter(|c| **c).count() {
            0 if is_on[0] => self.add(t.map(Corner::At)),
            2 => {
                // The corner between the two sides that are cut is cut off.
                let k = (0..3).find(|k| !is_cut[(k + 1) % 3]).unwrap_or(0);
                let (own, next, last) = (t[k], t[(k + 1) % 3], t[(k + 2) % 3]);
                if is_on[k] {
                    self.add_corner(own, next, last);
                }
                if is_on[(k + 1) % 3] {
                    let (near, far) = (self.toward(next, own), self.toward(last, own));
                    self.add_quadrangle([near, Corner::At(next), Corner::At(last), far]);
                }
            }
            3 => {
                for k in (0..3).filter(|k| is_on[*k]) {
                    self.add_corner(t[k], t[(k + 1) % 3], t[(k + 2) % 3]);
                }
            }
            _ => {}
        }
    }

    /// The corner of a triangle between two sides that are cut.
    fn add_corner(&mut self, own: Key, next: Key, last: Key) {
        let (near, far) = (self.toward(own, next), self.toward(own, last));
        self.add([Corner::At(own), near, far]);
    }

    /// Where the surface ends on the way from a place to another.
    fn toward(&self, from: Key, to: Key) -> Corner {
        match self.crossings.get(&[from, to]) {
            Some(Some(crossing)) => Corner::Crossing(crossing.from, to),
            _ => Corner::At(from),
        }
    }

    /// Adds a quadrangle, divided along that diagonal which leaves out less of it.
    fn add_quadrangle(&mut self, corners: [Corner; 4]) {
        let [a, b, c, d] = corners;
        let [first, second] = [[[a, b, c], [a, c, d]], [[b, c, d], [b, d, a]]];
        let mut kept = |halves: [[Corner; 3]; 2]| {
            let area = |corners| self.kept(corners).map_or(0.0, |face| self.area_seen(face));
            halves.into_iter().map(area).fold(0.0, |sum, area| sum + area)
        };
        let halves = if kept(first) >= kept(second) { first } else { second };
        halves.into_iter().for_each(|corners| self.add(corners));
    }

    /// Adds a triangle, if it is one, lies on the surface and beside all others: where only some of the crossings around a place
    /// are one, it may lie over another.
    fn add(&mut self, corners: [Corner; 3]) {
        let Some(face) = self.kept(corners) else { return };
        let sides = [0, 1, 2].map(|k| [face[k], face[(k + 1) % 3]]);
        if sides.iter().all(|side| !self.sides.contains(side)) {
            self.sides.extend(sides);
            self.out.faces.push(face);
        }
    }

    /// A triangle, if it is one and lies on the surface.
    fn kept(&mut self, corners: [Corner; 3]) -> Option<[u32; 3]> {
        let face = corners.map(|corner| self.number(corner));
        let is_whole = face[0] != face[1] && face[1] != face[2] && face[2] != face[0];
        let is_cut = corners.iter().any(|c| matches!(c, Corner::Crossing(..)));
        (is_whole && (!is_cut || self.lies_on_surface(face))).then_some(face)
    }

    /// Whether a triangle is as inclined as the surface at its corners: slivers may lie across it.
    fn lies_on_surface(&self, face: [u32; 3]) -> bool {
        let normal: DVec3 = face.iter().map(|&v| self.normals[v as usize]).sum();
        let corners = face.map(|v| self.out.positions[v as usize]);
        let own = area_normal(corners);
        let side = |k: usize| (corners[(k + 1) % 3] - corners[k]).truncate().length_squared();
        let longest = (0..3).map(side).fold(0.0, f64::max);
        own.normalize_or_zero().dot(normal.normalize_or_zero()) >= ALONG && own.z >= SLIM * longest
    }

    /// Twice the area of a triangle, seen from above, mm².
    fn area_seen(&self, face: [u32; 3]) -> f64 {
        area_normal(face.map(|v| self.out.positions[v as usize])).z
    }

    fn number(&mut self, corner: Corner) -> u32 {
        if let Some(&number) = self.numbers.get(&corner) {
            return number;
        }
        let place = match corner {
            Corner::At(key) => self.moved.get(&key).copied().or_else(|| {
                let net = self.machined.net;
                net.known(key).map(|h| (net.place(key, h), h.normal))
            }),
            Corner::Crossing(from, to) => {
                self.crossings.get(&[from, to]).copied().flatten().map(|c| c.place)
            }
        };
        let number = self.out.positions.len() as u32;
        // Both were found to exist.
        let (place, normal) = place.unwrap_or((DVec3::ZERO, DVec3::Z));
        self.out.positions.push(place);
        self.normals.push(normal);
        self.numbers.insert(corner, number);
        number
    }
}
