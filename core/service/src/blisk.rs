//! What of a STEP file looks like the hub, the blades and the fillets of a blisk.
//!
//! - *Axis*: that of the surfaces of revolution with the largest area together.
//! - *Body*: faces of revolution about it, and flat ones across it. All others, where they hang together at corners,
//!   are a *group*; groups that meet the same face of the body are blades, and that face is the hub.
//! - *Kind*: blades that are one another turned about the axis; the largest are main blades, others splitters.

use evencut_core::geometry::math::atan2;
use evencut_core::geometry::{DMat3, DVec2, DVec3, OrderBy, any_perpendicular};
use evencut_core::nurbs::NurbsSurface;
use evencut_core::step::{FaceMesh, StepError, StepFile};
use std::f64::consts::TAU;
use std::fmt::Write;

/// Deviations from a surface of revolution, and distances of corners that are one, as parts of the sizes.
const ROUND: f64 = 1e-4;
const SAME: f64 = 1e-5;
/// How near to the hub a corner of a blade is on it, as a part of the size of the hub.
const ON_HUB: f64 = 5e-4;
/// Differences of the extents of blades that are alike, as a part of the largest.
const ALIKE: f64 = 0.04;
/// By how much blades at the distance of two of them may miss a whole turn, as a part of it.
const EVEN: f64 = 0.02;
/// Part of the largest group's extent below which a group is a splinter.
const SPLINTER: f64 = 0.1;
/// Distance of the middle of a flat face from the axis, as a part of its radius, below which it lies around the axis.
const CENTRED: f64 = 0.05;
/// Widest gap between places, rad, seen along the axis, below which they stand all around it: blades leave more.
const GAP: f64 = 0.25 * TAU;
/// Places of a group, at most, whose heights over a hub are looked at.
const PLACES: usize = 200;
/// Cosine between normals of hub and fillet above which one continues the other, and the part of triangles on the hub.
const CONTINUES: f64 = 0.7;

/// An axis of rotation.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Axis {
    /// The point of it that is nearest to the origin, mm.
    pub origin: DVec3,
    /// Unit direction, along the coordinate in which it is largest.
    pub way: DVec3,
}

/// Blades that are one another turned.
#[derive(Clone, Debug, PartialEq)]
pub struct Kind {
    /// Faces of the first one that are seen above the hub, from 0.
    pub faces: Vec<usize>,
    /// Those of them that continue the hub.
    pub fillets: Vec<usize>,
    /// Number of such blades in the file.
    pub count: usize,
    /// Number that stand around the axis as far apart as the nearest two of them.
    pub around: usize,
}

/// A blisk, or as much of it as a file holds.
#[derive(Clone, Debug, PartialEq)]
pub struct Blisk {
    /// The face of the hub, from 0.
    pub hub: usize,
    /// Its area, mm².
    pub area: f64,
    /// The axis.
    pub axis: Axis,
    /// Main blades, then splitters.
    pub kinds: Vec<Kind>,
    /// Of each kind the faces of all such blades that are seen above the hub, from 0.
    standing: Vec<Vec<Vec<usize>>>,
}

/// A group of faces.
struct Group {
    faces: Vec<usize>,
    corners: Vec<DVec3>,
    /// Radii and heights about the axis, from and to.
    extents: [f64; 4],
}

impl Axis {
    fn profile(&self, p: DVec3) -> DVec2 {
        let off = p - self.origin;
        DVec2::new(off.cross(self.way).length(), off.dot(self.way))
    }

    fn is_same(&self, other: &Self, near: f64) -> bool {
        self.way.dot(other.way) > 1.0 - ROUND && self.origin.distance(other.origin) < near
    }
}

/// The axis of a surface of revolution, `None` of any other.
fn axis_of(surface: &NurbsSurface) -> Option<Axis> {
    (0..2).find_map(|around| axis_about(surface, around))
}

/// The same, with the parameter that may run around it.
fn axis_about(surface: &NurbsSurface, around: usize) -> Option<Axis> {
    const ROWS: [f64; 5] = [0.1, 0.3, 0.5, 0.7, 0.9];
    let near = ROUND * surface.size();
    let (low, high) = surface.domain();
    let at = |turn: f64, row: f64| {
        let mut part = DVec2::splat(row);
        part[around] = turn;
        surface.point(low + (high - low) * part)
    };
    let circle = |row: f64| {
        let [a, b, c] = [0.05, 0.35, 0.65].map(|turn| at(turn, row));
        let (ab, ac) = (b - a, c - a);
        let normal = ab.cross(ac);
        let square = normal.length_squared();
        if square < 1e-6 * ab.length_squared() * ac.length_squared() || square == 0.0 {
            return None;
        }
        let to_centre = (normal.cross(ab) * ac.length_squared()
            + ac.cross(normal) * ab.length_squared())
            / (2.0 * square);
        let centre = a + to_centre;
        let radius = to_centre.length();
        let way = normal.normalize_or_zero();
        let is_on = |turn: f64| {
            let off = at(turn, row) - centre;
            (off.length() - radius).abs() < near && off.dot(way).abs() < near
        };
        [0.15, 0.45, 0.8, 0.95].into_iter().all(is_on).then_some((centre, way))
    };
    let circles: Option<Vec<(DVec3, DVec3)>> = ROWS.into_iter().map(circle).collect();
    let circles = circles?;
    let &(first, way) = circles.first()?;
    let is_straight = |(centre, other): &(DVec3, DVec3)| {
        other.dot(way).abs() > 1.0 - ROUND && (*centre - first).cross(way).length() < near
    };
    if !circles.iter().all(is_straight) {
        return None;
    }
    let by_size = |a: &usize, b: &usize| way[*a].abs().total_cmp(&way[*b].abs());
    let largest = (0..3).max_by(by_size).unwrap_or(2);
    let way = if way[largest] < 0.0 { -way } else { way };
    Some(Axis { origin: first - way * first.dot(way), way })
}

/// Whether places stand all around an axis, such as the sides of a nut.
fn encloses(places: &[DVec3], axis: &Axis) -> bool {
    let across = any_perpendicular(axis.way);
    let along = axis.way.cross(across);
    let angle = |p: &DVec3| atan2((*p - axis.origin).dot(along), (*p - axis.origin).dot(across));
    let mut angles: Vec<f64> = places.iter().map(angle).collect();
    angles.order_by(f64::total_cmp);
    let ends = angles.first().zip(angles.last()).map_or(TAU, |(a, b)| a + TAU - b);
    angles.windows(2).map(|w| w[1] - w[0]).fold(ends, f64::max) < GAP
}

impl Blisk {
    /// The blisk in a file, `looked` at with [`StepFile::look`]; `None` if there is none.
    pub fn find(file: &StepFile, looked: &[Result<FaceMesh, StepError>]) -> Option<Self> {
        let count = file.faces().len();
        let surfaces: Vec<Option<NurbsSurface>> =
            (0..count).map(|i| file.surface(i, (DMat3::IDENTITY, DVec3::ZERO)).ok()).collect();
        let corners: Vec<Vec<DVec3>> = (0..count).map(|i| file.corners(i)).collect();
        let all = || corners.iter().flatten();
        let (low, high) = all().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), p| {
            (low.min(*p), high.max(*p))
        });
        let size = (high - low).length();
        if !(size > 0.0 && size.is_finite()) {
            return None;
        }
        let area =
            |i: usize| looked.get(i).and_then(|m| m.as_ref().ok()).map_or(0.0, FaceMesh::area);
        let axes: Vec<Option<Axis>> =
            surfaces.iter().map(|s| s.as_ref().and_then(axis_of)).collect();
        let round = |axis: &Axis| {
            let axis = *axis;
            let near = ROUND * size;
            move |other: &Option<Axis>| other.is_some_and(|other| axis.is_same(&other, near))
        };
        let total = |axis: &Axis| {
            let is_same = round(axis);
            (0..count).filter(|i| is_same(&axes[*i])).map(area).sum::<f64>()
        };
        let axis = axes.iter().flatten().copied().max_by(|a, b| total(a).total_cmp(&total(b)))?;
        let is_round: Vec<bool> = axes.iter().map(round(&axis)).collect();
        let mesh = |i: usize| looked.get(i).and_then(|m| m.as_ref().ok());
        let is_body = |i: usize| is_round[i] || is_across(mesh(i), &axis, ROUND * size);
        let groups = groups(&corners, &is_body, &axis, SAME * size);
        let of_hub = |hub: usize| {
            let Some(surface) = &surfaces[hub] else { return Vec::new() };
            let places = |group: &Group| {
                let positions = |i: &usize| mesh(*i).map(|m| &m.mesh.soup.positions);
                let all = || group.faces.iter().filter_map(positions).flatten().copied();
                let step = (all().count() / PLACES).max(1);
                group.corners.iter().copied().chain(all().step_by(step)).collect::<Vec<DVec3>>()
            };
            let is_blade = |places: &[DVec3]| meets(surface, places) && !encloses(places, &axis);
            groups.iter().filter(|g| is_blade(&places(g))).collect::<Vec<&Group>>()
        };
        let hubs = (0..count).filter(|i| is_round[*i]).map(|i| (of_hub(i), i));
        let by_blades = |a: &(Vec<&Group>, usize), b: &(Vec<&Group>, usize)| {
            a.0.len().cmp(&b.0.len()).then(area(a.1).total_cmp(&area(b.1)))
        };
        let (blades, hub) = hubs.max_by(by_blades).filter(|(blades, _)| !blades.is_empty())?;
        let surface = surfaces[hub].as_ref()?;
        let kinds = kinds(&blades);
        let mut standing = Vec::new();
        let kinds = kinds.into_iter().filter_map(|alike| {
            let first = alike.first()?;
            let heights = first.corners.iter().map(|p| height(surface, *p).1);
            let farthest = heights.max_by(|a, b| a.abs().total_cmp(&b.abs()));
            let side = farthest.unwrap_or(1.0).signum();
            let near = ON_HUB * surface.size();
            let is_seen = |i: &usize| {
                mesh(*i).is_some_and(|m| {
                    m.mesh.soup.positions.iter().any(|p| height(surface, *p).1 * side > near)
                })
            };
            let seen = |group: &&Group| group.faces.iter().copied().filter(is_seen).collect();
            let faces: Vec<usize> = seen(first);
            standing.extend((!faces.is_empty()).then(|| alike.iter().map(seen).collect()));
            let is_fillet = |i: &usize| mesh(*i).is_some_and(|m| continues(surface, m, near));
            let fillets = faces.iter().copied().filter(is_fillet).collect();
            let (count, around) = (alike.len(), around(&alike, &axis));
            (!faces.is_empty()).then_some(Kind { faces, fillets, count, around })
        });
        let kinds: Vec<Kind> = kinds.collect();
        let area = area(hub);
        (!kinds.is_empty()).then_some(Self { hub, area, axis, kinds, standing })
    }

    /// Faces in the way of the channels, from 0, where only those `named` are known to be there: those of a blade or a
    /// splitter of which none is named, or the others of one of which some are, and one of these.
    pub fn unnamed(&self, named: &[usize]) -> Option<(Vec<usize>, Option<usize>)> {
        let size = |faces: &[Vec<usize>]| faces.first().map_or(0, Vec::len);
        self.standing.iter().filter(|alike| size(alike) > 0).find_map(|alike| {
            let count = |blade: &&Vec<usize>| blade.iter().filter(|f| named.contains(f)).count();
            let best = alike.iter().max_by_key(count)?;
            let missing: Vec<usize> =
                best.iter().copied().filter(|face| !named.contains(face)).collect();
            let beside = best.iter().copied().find(|face| named.contains(face));
            (!missing.is_empty()).then_some((missing, beside))
        })
    }

    /// Number of main blades, if the file has more than one: as many as stand around as far apart as the nearest two.
    pub fn blades(&self) -> Option<usize> {
        self.kinds.first().filter(|main| main.count > 1).map(|main| main.around)
    }

    /// Number of main blades that were found, where the distance of the nearest two tells of another one.
    pub fn found_of(&self) -> Option<(usize, usize)> {
        let main = self.kinds.first()?;
        (main.count > 1 && main.count != main.around).then_some((main.count, main.around))
    }

    /// What was found, in words.
    pub fn text(&self) -> String {
        let numbers = |faces: &[usize]| {
            faces.iter().map(|f| (f + 1).to_string()).collect::<Vec<String>>().join(", ")
        };
        let origin = self.axis.origin + DVec3::ZERO;
        // No -0.
        let rounded = |x: f64| (x * 1e4).round() / 1e4 + 0.0;
        let way = DVec3::from(self.axis.way.to_array().map(rounded));
        let mut text = format!(
            "looks like a blisk about the axis ({:.4}, {:.4}, {:.4}) through ({:.3}, {:.3}, {:.3})\n  hub       face {}, \
             {:.2} mm², of revolution\n",
            way.x,
            way.y,
            way.z,
            origin.x,
            origin.y,
            origin.z,
            self.hub + 1,
            self.area
        );
        for (kind, name) in self.kinds.iter().zip(["blade", "splitter", "other", "other"]) {
            // Writing to a string cannot fail.
            let _ = writeln!(
                text,
                "  {name:9} {} in the file, turned about the axis; faces of the first: {}",
                kind.count,
                numbers(&kind.faces)
            );
            if kind.count > 1 && kind.count != kind.around {
                let _ = writeln!(
                    text,
                    "            the nearest two stand {:.2} degrees apart, as {} do: the others differ or were not told from \
                     the body",
                    360.0 / kind.around as f64,
                    kind.around
                );
            }
            let fillets = match kind.fillets.is_empty() {
                true => "none: the blade meets the hub in a corner".to_owned(),
                false => format!("faces {} continue the hub", numbers(&kind.fillets)),
            };
            let _ = writeln!(text, "  fillet    {fillets}");
        }
        text
    }

    /// A commented job for the channels between the blades. `file`: the STEP file relative to the job; `diameter`: of the
    /// cutter, mm; `blades`: their number.
    pub fn job(&self, file: &str, diameter: f64, blades: usize) -> String {
        let numbers = |kind: &Kind| {
            kind.faces.iter().map(|f| (f + 1).to_string()).collect::<Vec<String>>().join(", ")
        };
        let Axis { origin, way } = self.axis;
        let rounded = |p: DVec3| p.to_array().map(|x| (x * 1e6).round() / 1e6 + 0.0);
        let splitter = self.kinds.get(1).map_or(String::new(), |kind| {
            format!("splitter = [{}]       # the faces of one splitter\n", numbers(kind))
        });
        let doubt = match self.blades() {
            Some(_) => "",
            None => "   # A GUESS: the file has one blade only. Correct the number",
        };
        let blade = self.kinds.first().map_or(String::new(), numbers);
        let file = toml::Value::String(file.to_owned());
        format!(
            "\
# A job for the hub of a blisk: the channels between its blades. Every key with its default is in
# docs/job-file.md. Lengths in mm, angles in degrees, feeds in mm/min.
version = 1

[surface]
file = {file}
face = {hub}               # the hub, as evencut inspect lists it

[hub]
blades = {blades}{doubt}
axis = {way:?}
origin = {origin:?}
blade = [{blade}]          # all faces of one blade with its fillet
{splitter}
[tool]
kind = \"ball\"
diameter = {diameter:?}             # passes the narrowest place of the channels
stickout = {stickout:?}            # shank that stands out of the holder

[cut]
scallop = 0.02             # cusp height
axial_depth = {depth:?}
feed = 1200.0
tolerance = 0.01

[path]
pattern = \"hub\"

[machine]
axes = \"xyzac\"
",
            hub = self.hub + 1,
            way = rounded(way),
            origin = rounded(origin),
            stickout = (15.0 * diameter).ceil(),
            depth = (0.05 * diameter * 100.0).round() / 100.0,
        )
    }
}

/// Whether a face lies flat across the axis and around it.
fn is_across(face: Option<&FaceMesh>, axis: &Axis, near: f64) -> bool {
    let Some(soup) = face.map(|face| &face.mesh.soup) else { return false };
    let profiles = || soup.positions.iter().map(|p| axis.profile(*p));
    let Some(height) = profiles().next().map(|p| p.y) else { return false };
    let (mut area, mut middle) = (0.0, DVec3::ZERO);
    for [a, b, c] in soup.faces.iter().map(|f| f.map(|v| soup.positions[v as usize])) {
        let twice = (b - a).cross(c - a).length();
        (area, middle) = (area + twice, middle + (a + b + c) * (twice / 3.0));
    }
    let farthest = profiles().map(|p| p.x).fold(0.0, f64::max);
    area > 0.0
        && profiles().all(|p| (p.y - height).abs() < near)
        && axis.profile(middle / area).x < CENTRED * farthest
}

/// Faces that are no body, put together where they share corners.
fn groups(
    corners: &[Vec<DVec3>],
    is_body: &dyn Fn(usize) -> bool,
    axis: &Axis,
    near: f64,
) -> Vec<Group> {
    let mut all: Vec<(DVec3, usize)> = Vec::new();
    for (i, of_face) in corners.iter().enumerate().filter(|(i, _)| !is_body(*i)) {
        all.extend(of_face.iter().map(|p| (*p, i)));
    }
    all.order_by(|a, b| a.0.x.total_cmp(&b.0.x).then(a.1.cmp(&b.1)));
    // The first face of each group, by face.
    let mut first: Vec<usize> = (0..corners.len()).collect();
    for (k, (p, face)) in all.iter().enumerate() {
        for (q, other) in all[k + 1..].iter().take_while(|(q, _)| q.x - p.x <= near) {
            let (a, b) = (first[*face], first[*other]);
            if a != b && p.distance(*q) <= near {
                first.iter_mut().filter(|f| **f == a.max(b)).for_each(|f| *f = a.min(b));
            }
        }
    }
    let mut groups: Vec<Group> = Vec::new();
    for lead in 0..corners.len() {
        let faces: Vec<usize> =
            (lead..corners.len()).filter(|i| first[*i] == lead && !is_body(*i)).collect();
        let corners: Vec<DVec3> = faces.iter().flat_map(|i| &corners[*i]).copied().collect();
        if corners.is_empty() {
            continue;
        }
        let mut extents = [f64::INFINITY, f64::NEG_INFINITY, f64::INFINITY, f64::NEG_INFINITY];
        for p in corners.iter().map(|p| axis.profile(*p)) {
            extents = [
                extents[0].min(p.x),
                extents[1].max(p.x),
                extents[2].min(p.y),
                extents[3].max(p.y),
            ];
        }
        groups.push(Group { faces, corners, extents });
    }
    let largest = groups.iter().map(Group::extent).fold(0.0, f64::max);
    groups.retain(|g| g.extent() > SPLINTER * largest);
    groups
}

impl Group {
    fn extent(&self) -> f64 {
        let [r0, r1, z0, z1] = self.extents;
        (r1 - r0).max(z1 - z0)
    }
}

/// How many blades stand around the axis as far apart as the nearest two of these; their number where that does not come
/// out even.
fn around(groups: &[&Group], axis: &Axis) -> usize {
    let middle = |g: &&Group| g.corners.iter().sum::<DVec3>() / g.corners.len().max(1) as f64;
    let across = any_perpendicular(axis.way);
    let angle = |p: DVec3| {
        let off = p - axis.origin;
        atan2(axis.way.cross(across).dot(off), across.dot(off))
    };
    let mut angles: Vec<f64> = groups.iter().map(middle).map(angle).collect();
    angles.order_by(f64::total_cmp);
    let next = angles.iter().skip(1).copied().chain(angles.first().map(|a| a + TAU));
    let least = angles.iter().zip(next).map(|(a, b)| b - a).fold(TAU, f64::min);
    let count = (TAU / least.max(1e-3)).round();
    match (count * least - TAU).abs() < EVEN * TAU {
        true => count as usize,
        false => groups.len(),
    }
}

/// Groups put together with those that are alike, the largest first.
fn kinds<'a>(groups: &[&'a Group]) -> Vec<Vec<&'a Group>> {
    let largest = groups.iter().map(|g| g.extent()).fold(0.0, f64::max);
    let mut kinds: Vec<Vec<&Group>> = Vec::new();
    for group in groups {
        let is_alike = |other: &&Group| {
            let pairs = group.extents.iter().zip(&other.extents);
            pairs.into_iter().all(|(a, b)| (a - b).abs() < ALIKE * largest)
        };
        match kinds.iter_mut().find(|kind| kind.first().is_some_and(is_alike)) {
            Some(kind) => kind.push(group),
            None => kinds.push(vec![group]),
        }
    }
    let extent = |kind: &Vec<&Group>| kind.first().map_or(0.0, |g| g.extent());
    kinds.order_by(|a, b| extent(b).total_cmp(&extent(a)));
    kinds
}

/// Parameters of the nearest point of a surface and the distance from it, with the sign of the normal's side.
fn height(surface: &NurbsSurface, place: DVec3) -> (DVec2, f64) {
    const NET: usize = 12;
    let (low, high) = surface.domain();
    let step = |i: usize| (i as f64 + 0.5) / NET as f64;
    let net = (0..NET * NET).map(|k| low + (high - low) * DVec2::new(step(k / NET), step(k % NET)));
    let nearest = net.min_by(|a, b| {
        let off = |at: DVec2| surface.point(at).distance_squared(place);
        off(*a).total_cmp(&off(*b))
    });
    let (at, off) = surface.project(place, nearest.unwrap_or(low));
    let is_below = (place - surface.point(at)).dot(surface.normal(at)) < 0.0;
    (at, if is_below { -off } else { off })
}

/// Whether corners of a blade lie on a surface, some of them off it, or on both its sides.
fn meets(surface: &NurbsSurface, corners: &[DVec3]) -> bool {
    let near = ON_HUB * surface.size();
    let (low, high) = surface.domain();
    let heights: Vec<f64> = corners
        .iter()
        .map(|p| height(surface, *p))
        .filter(|(at, off)| {
            // Beyond the rim a side means nothing.
            let inside = |i: usize| surface.closed()[i] || at[i] > low[i] && at[i] < high[i];
            off.abs() <= near || inside(0) && inside(1)
        })
        .map(|(_, off)| off)
        .collect();
    let on = heights.iter().filter(|off| off.abs() <= near).count();
    let above = heights.iter().any(|off| *off > near);
    let below = heights.iter().any(|off| *off < -near);
    above != below && on > 1 && (above || below) || above && below
}

/// Whether a face continues a surface: its triangles on it look as it does.
fn continues(surface: &NurbsSurface, face: &FaceMesh, near: f64) -> bool {
    let soup = &face.mesh.soup;
    let (mut touching, mut along) = (0.0, 0.0);
    for corners in soup.faces.iter().map(|f| f.map(|v| soup.positions[v as usize])) {
        let [a, b, c] = corners;
        let on: Vec<DVec2> = corners
            .iter()
            .map(|p| height(surface, *p))
            .filter(|(_, off)| off.abs() <= near)
            .map(|(at, _)| at)
            .collect();
        let Some(at) = on.first() else { continue };
        if on.len() < 2 {
            continue;
        }
        let normal = (b - a).cross(c - a);
        touching += normal.length();
        along += normal.dot(surface.normal(*at)).abs();
    }
    touching > 0.0 && along > CONTINUES * touching
}
