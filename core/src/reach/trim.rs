//! The net without what lies outside of the outline: triangles across it are cut where their sides cross it.
//!
//! The outline crosses a side where one end is outside, or where the surface jumps between two ends, at the upper edge
//! of a wall. Either way the crossing is found by bisection from each end that is on the surface.

use super::facet::area_normal;
use super::lattice::Key;
use super::net::{Net, SAME_SIDE, tangent};
use super::terrain::Height;
use crate::geometry::DVec3;
use crate::mesh::TriangleSoup;
use crate::parallel;
use std::collections::{BTreeMap, BTreeSet, HashMap};

/// Bisections of a side. Fewer: the surface ends farther before the upper edge of a wall, and what is cut within the
/// tolerance of the wall there counts as a deep cut.
const HALVINGS: u32 = 10;
/// A crossing nearer to an end of the side than this fraction of it is at that end.
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

/// The net within the outline, and the normals at its corners: triangles with a corner whose normal is at least
/// `steepest` along the axis.
pub(super) fn trimmed(net: &Net, steepest: f64) -> (TriangleSoup, Vec<DVec3>) {
    let is_gentle = |k: &Key| net.known(*k).is_some_and(|h| h.normal.z >= steepest);
    let mut triangles = net.triangles();
    triangles.retain(|t| t.iter().any(is_gentle));
    let crossed: BTreeSet<[Key; 2]> = triangles
        .iter()
        .flat_map(|t| (0..3).flat_map(|k| [[t[k], t[(k + 1) % 3]], [t[(k + 1) % 3], t[k]]]))
        .filter(|[from, to]| net.known(*from).is_some() && is_crossed(net, *from, *to))
        .collect();
    let crossed: Vec<[Key; 2]> = crossed.into_iter().collect();
    let found = parallel::map(net.threads, &crossed, |[from, to]| crossing(net, *from, *to));
    let crossings: BTreeMap<[Key; 2], Option<Place>> = crossed.into_iter().zip(found).collect();
    let (numbers, out) = (HashMap::new(), TriangleSoup::default());
    let mut soup = Soup { net, crossings, numbers, out, normals: Vec::new() };
    triangles.iter().for_each(|t| soup.add_cut(*t));
    (soup.out, soup.normals)
}

/// Whether the outline lies between two places, of which the first is on the surface.
fn is_crossed(net: &Net, from: Key, to: Key) -> bool {
    match (net.known(from), net.known(to)) {
        (Some(a), Some(b)) => {
            let length = net.lattice.at(from).distance(net.lattice.at(to));
            net.jumps(a, b, length)
        }
        _ => true,
    }
}

/// The last place of the surface on the way from one place to another; `None`: at once.
fn crossing(net: &Net, from: Key, to: Key) -> Option<Place> {
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
            (h.z - first.z).abs() <= may_differ && h.normal.dot(first.normal) >= SAME_SIDE
        };
        match net.height(at, near).filter(belongs) {
            Some(height) => {
                (low, near, place) = (part, height, Some((at.extend(height.z), height.normal)))
            }
            None => high = part,
        }
    }
    place.filter(|_| low > AT_END)
}

struct Soup<'a> {
    net: &'a Net<'a>,
    crossings: BTreeMap<[Key; 2], Option<Place>>,
    numbers: HashMap<Corner, u32>,
    out: TriangleSoup,
    normals: Vec<DVec3>,
}

impl Soup<'_> {
    /// What of a triangle is on the surface.
    fn add_cut(&mut self, t: [Key; 3]) {
        let is_on = t.map(|k| self.net.known(k).is_some());
        // Side k leads from corner k to the next.
        let is_cut = [0, 1, 2].map(|k| {
            let (a, b) = (t[k], t[(k + 1) % 3]);
            self.crossings.contains_key(&[a, b]) || self.crossings.contains_key(&[b, a])
        });
        match is_cut.iter().filter(|c| **c).count() {
            0 if is_on[0] => self.add(&t.map(Corner::At)),
            2 => {
                // The corner between the two sides that are cut is cut off.
                let k = (0..3).find(|k| !is_cut[(k + 1) % 3]).unwrap_or(0);
                let (own, next, last) = (t[k], t[(k + 1) % 3], t[(k + 2) % 3]);
                if is_on[k] {
                    self.add_corner(own, next, last);
                }
                if is_on[(k + 1) % 3] {
                    let (near, far) = (self.toward(next, own), self.toward(last, own));
                    self.add(&[near, Corner::At(next), Corner::At(last), far]);
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
        self.add(&[Corner::At(own), near, far]);
    }

    /// Where the surface ends on the way from a place to another.
    fn toward(&self, from: Key, to: Key) -> Corner {
        match self.crossings.get(&[from, to]) {
            Some(Some(_)) => Corner::Crossing(from, to),
            _ => Corner::At(from),
        }
    }

    /// Adds a convex polygon.
    fn add(&mut self, corners: &[Corner]) {
        let numbers: Vec<u32> = corners.iter().map(|c| self.number(*c)).collect();
        for k in 1..numbers.len() - 1 {
            let face = [numbers[0], numbers[k], numbers[k + 1]];
            let is_whole = face[0] != face[1] && face[1] != face[2] && face[2] != face[0];
            let is_cut = corners.iter().any(|c| matches!(c, Corner::Crossing(..)));
            if is_whole && (!is_cut || self.lies_on_surface(face)) {
                self.out.faces.push(face);
            }
        }
    }

    /// Whether a triangle is as inclined as the surface at its corners: slivers may lie across it.
    fn lies_on_surface(&self, face: [u32; 3]) -> bool {
        let corners = face.map(|v| self.out.positions[v as usize]);
        let normal: DVec3 = face.iter().map(|&v| self.normals[v as usize]).sum();
        let own = area_normal(corners);
        let longest = (0..3)
            .map(|k| (corners[(k + 1) % 3] - corners[k]).truncate().length_squared())
            .fold(0.0, f64::max);
        own.normalize_or_zero().dot(normal.normalize_or_zero()) >= ALONG && own.z >= SLIM * longest
    }

    fn number(&mut self, corner: Corner) -> u32 {
        if let Some(&number) = self.numbers.get(&corner) {
            return number;
        }
        let place = match corner {
            Corner::At(key) => self.net.known(key).map(|h| (self.net.place(key, h), h.normal)),
            Corner::Crossing(from, to) => self.crossings.get(&[from, to]).copied().flatten(),
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
