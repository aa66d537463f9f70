//! Dense, area-uniform samples of the part, in tiles that are processed independently.
//!
//! - *Patch*: a facet, or a piece of one that is larger than a tile.
//! - *Tile*: adjacent patches with at most a given number of samples.
//! - *Block*: a few neighbouring samples of a tile, with their bounds.
//!
//! A patch is halved across its longest side until the pieces are as small as the sample density requires; each piece
//! is a *cell* with a sample near its centroid. Cells cover the surface without gaps, so areas and volumes add up
//! over any strip of it, which scattered samples would not. Centroids never lie on the rim of the machined surface;
//! there, further samples without area are added.

use crate::geometry::offset::{CrossSection, corner_normals};
use crate::geometry::{DVec3, nearest_on_triangle};

/// Samples per tile. Larger: less to share between threads; smaller: more tiles against which a move must be tested.
const TILE: f64 = 1024.0;
/// Samples per block. Larger: more samples tested needlessly; smaller: more bounds.
pub const BLOCK: usize = 16;
/// Largest cell, as a fraction of the squared distance of samples: halving then leaves cells around it.
const CELL: f64 = core::f64::consts::SQRT_2;
/// Width over length up to which a piece is cut across instead of being halved; and length of its pieces over the longest
/// that they may be, so that their diagonals are no longer.
const NARROW: f64 = 0.125;
const LENGTH: f64 = 0.9;
/// How far a sample may lie from its cell's centroid, as a fraction of the distance to the cell's rim. With 0, a row
/// of samples that runs along a cusp may miss its top; with 1, cells are no longer evenly covered.
const SCATTER: f64 = 0.5;
/// Inverse powers of the plastic number, the root of `x³ = x + 1`: the most uniform sequence of pairs (Roberts, "The
/// unreasonable effectiveness of quasirandom sequences", 2018).
const STEPS: [f64; 2] = [0.754_877_666_246_692_7, 0.569_840_290_998_053_2];

/// A triangle mesh to be sampled.
#[derive(Copy, Clone, Debug)]
pub struct Facets<'a> {
    /// `#V` positions, mm.
    pub positions: &'a [DVec3],
    /// `#F` triples of indices into them, counter-clockwise from outside.
    pub faces: &'a [[u32; 3]],
}

/// A side of a facet, from one of its corners to the next.
#[derive(Copy, Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Side {
    /// Index of the facet.
    pub facet: u32,
    /// The corner.
    pub corner: u8,
}

/// A facet or a piece of one.
#[derive(Copy, Clone, Debug)]
pub struct Patch {
    pub(super) corners: [DVec3; 3],
    normals: [DVec3; 3],
    area: f64,
    /// Whether it is to be machined; otherwise it is only an obstacle.
    pub(super) machined: bool,
    /// Whether the cutter bridges the part there.
    is_bridge: bool,
    /// The edges on the rim of the machined surface, each starting at the corner of its number.
    rim: [bool; 3],
}

/// Patches that are processed together.
#[derive(Clone, Debug)]
pub struct Tile {
    /// Its patches.
    pub patches: Vec<Patch>,
    /// Centre of the sphere around it, mm.
    pub centre: DVec3,
    /// Radius of that sphere, mm.
    pub radius: f64,
}

/// A sample.
#[derive(Copy, Clone, Debug)]
pub struct Sample {
    /// Place on the part, mm.
    pub position: DVec3,
    /// From there to the centroid of its cell, mm: one of millions of samples, and short.
    pub to_centroid: [f32; 3],
    /// Unit normal, outward.
    pub normal: DVec3,
    /// The area that it represents, and how its cell changes with the height over it.
    pub section: CrossSection,
    /// Whether it is to be machined.
    pub machined: bool,
    /// Whether the cutter bridges the part there.
    pub is_bridge: bool,
    /// Depth of the wall's own material behind it, mm; `None` where it is not a wall.
    pub wall: Option<f64>,
    /// Whether it lies exactly on the rim of the machined surface, which moves need not reach.
    pub on_rim: bool,
}

impl Sample {
    /// One of machined stock at a place, mm, along a unit direction, without area.
    pub fn bare(position: DVec3, normal: DVec3) -> Self {
        Self {
            position,
            to_centroid: [0.0; 3],
            normal,
            section: CrossSection::default(),
            machined: true,
            is_bridge: false,
            wall: None,
            on_rim: false,
        }
    }

    /// Centroid of its cell, mm.
    pub fn centroid(&self) -> DVec3 {
        self.position + DVec3::from_array(self.to_centroid.map(f64::from))
    }

    /// Distance at which cells of this size repeat: two triangles make a square.
    pub fn cell_width(&self) -> f64 {
        (2.0 * self.section.area).sqrt()
    }
}

impl Facets<'_> {
    pub(super) fn corners(&self, face: &[u32; 3]) -> [DVec3; 3] {
        face.map(|v| self.positions[v as usize])
    }

    /// Area, mm².
    pub fn area(&self) -> f64 {
        self.faces.iter().map(|f| 0.5 * doubled(self.corners(f)).length()).sum()
    }

    /// Normals at the corners of every facet.
    pub(super) fn normals(&self) -> Vec<[DVec3; 3]> {
        corner_normals(self.positions, self.faces)
    }
}

/// Normal of a triangle, as long as twice its area.
fn doubled([a, b, c]: [DVec3; 3]) -> DVec3 {
    (b - a).cross(c - a)
}

/// Tiles over a part: `design` is machined, `rest` is only an obstacle. Facets without area are left out. `spacing`:
/// distance between samples, mm. `rim`: edges of facets of the design, in order, on its rim. `bridges`: which facets of
/// the design bridge the part; empty where none does.
pub fn tiles(
    design: Facets,
    rest: Facets,
    spacing: f64,
    rim: &[Side],
    bridges: &[bool],
) -> Vec<Tile> {
    let largest = TILE * spacing * spacing;
    let mut patches = Vec::new();
    let mut sides = rim.iter().peekable();
    for (facets, machined) in [(design, true), (rest, false)] {
        for (f, (face, normals)) in facets.faces.iter().zip(facets.normals()).enumerate() {
            let mut rim = [false; 3];
            while machined && let Some(side) = sides.next_if(|s| s.facet as usize == f) {
                rim[usize::from(side.corner)] = true;
            }
            let corners = facets.corners(face);
            let area = 0.5 * doubled(corners).length();
            if area > 0.0 {
                // Needles are as bad as large facets: their tile would reach far.
                let length = LENGTH * largest.sqrt();
                let most = Most { area: 0.25 * largest, side: largest, length };
                let is_bridge = machined && bridges.get(f) == Some(&true);
                let patch = Patch { corners, normals, area, machined, is_bridge, rim };
                split(patch, most, &mut |p| patches.push(p));
            }
        }
    }
    let mut out = Vec::new();
    group(&mut patches, largest, &mut out);
    out
}

/// How large pieces of a patch may be.
#[derive(Copy, Clone, Debug)]
struct Most {
    /// Area, mm².
    area: f64,
    /// Longest side, squared, mm².
    side: f64,
    /// Length of the pieces of needles, mm.
    length: f64,
}

/// The pieces of a patch that are no larger.
fn split(patch: Patch, most: Most, out: &mut impl FnMut(Patch)) {
    let side = |i: usize| patch.corners[i].distance_squared(patch.corners[(i + 1) % 3]);
    let longest = (0..3).fold(0, |best, i| if side(i) > side(best) { i } else { best });
    if patch.area <= most.area && side(longest) <= most.side {
        return out(patch);
    }
    let patch = patch.turned(longest);
    if side(longest) > most.side && 2.0 * patch.area <= NARROW * side(longest) {
        return slice(patch, most, out);
    }
    let ([a, b, c], [na, nb, nc]) = (patch.corners, patch.normals);
    let (m, nm) = (0.5 * (a + b), (na + nb).normalize_or(na));
    let area = 0.5 * patch.area;
    let half = |corners, normals, rim| Patch { corners, normals, area, rim, ..patch };
    let [ab, bc, ca] = patch.rim;
    split(half([a, m, c], [na, nm, nc], [ab, false, ca]), most, out);
    split(half([m, b, c], [nm, nb, nc], [ab, bc, false]), most, out);
}

/// Cuts a long and narrow patch whose first side is its longest across: at its widest place, and each part into pieces
/// of equal length. Halves of needles are ever thinner needles, three times as many for half the length.
fn slice(patch: Patch, most: Most, out: &mut impl FnMut(Patch)) {
    let ([a, b, c], [na, nb, nc]) = (patch.corners, patch.normals);
    let [ab, bc, ca] = patch.rim;
    let along = b - a;
    let part = ((c - a).dot(along) / along.length_squared()).clamp(0.0, 1.0);
    let (foot, normal) = (a + along * part, na.lerp(nb, part).normalize_or(na));
    let of = |part: f64, corners, normals, rim| {
        let area = part * patch.area;
        Patch { corners, normals, area, rim, ..patch }
    };
    let from_a = of(part, [a, foot, c], [na, normal, nc], [ab, false, ca]);
    let from_b = of(1.0 - part, [b, c, foot], [nb, nc, normal], [bc, false, ab]);
    for needle in [from_a, from_b].into_iter().filter(|needle| needle.area > 0.0) {
        let ([tip, u, v], [n, nu, nv]) = (needle.corners, needle.normals);
        let length = tip.distance(u).max(tip.distance(v));
        let count = (length / most.length).ceil().max(1.0);
        let [tip_u, u_v, v_tip] = needle.rim;
        let at = |x: DVec3, nx: DVec3, j: f64| {
            (tip.lerp(x, j / count), n.lerp(nx, j / count).normalize_or(n))
        };
        // The numbers are whole.
        for j in (0..count as u32).map(f64::from) {
            let [(u0, nu0), (u1, nu1)] = [at(u, nu, j), at(u, nu, j + 1.0)];
            let [(v0, nv0), (v1, nv1)] = [at(v, nv, j), at(v, nv, j + 1.0)];
            let is_last = j + 1.0 == count;
            let share = needle.area / (count * count);
            let piece = |times: f64, corners, normals, rim| {
                let area = times * share;
                Patch { corners, normals, area, rim, ..needle }
            };
            let rim = [tip_u, u_v && is_last, v_tip && j == 0.0];
            split(piece(j + 1.0, [u0, u1, v1], [nu0, nu1, nv1], rim), most, out);
            if j > 0.0 {
                let rim = [false, v_tip, false];
                split(piece(j, [u0, v1, v0], [nu0, nv1, nv0], rim), most, out);
            }
        }
    }
}

/// Halves the patches at the middle of their widest direction until a half fits a tile.
fn group(patches: &mut [Patch], largest: f64, out: &mut Vec<Tile>) {
    let area: f64 = patches.iter().map(|p| p.area).sum();
    if patches.is_empty() {
        return;
    }
    if area <= largest || patches.len() == 1 {
        return out.push(Tile::new(patches.to_vec()));
    }
    let centroid = |p: &Patch| (p.corners[0] + p.corners[1] + p.corners[2]) / 3.0;
    let axis = widest(patches.iter().map(centroid));
    let half = patches.len() / 2;
    patches.select_nth_unstable_by(half, |a, b| {
        let (a, b) = (centroid(a), centroid(b));
        let lexical = |p: DVec3| [p[axis], p.x, p.y, p.z];
        lexical(a)
            .iter()
            .zip(&lexical(b))
            .map(|(x, y)| x.total_cmp(y))
            .fold(core::cmp::Ordering::Equal, core::cmp::Ordering::then)
    });
    let (low, high) = patches.split_at_mut(half);
    group(low, largest, out);
    group(high, largest, out);
}

/// The axis along which points spread most.
pub fn widest(points: impl Iterator<Item = DVec3>) -> usize {
    let (low, high) = bounds(points);
    let size = high - low;
    if size.x >= size.y && size.x >= size.z {
        0
    } else if size.y >= size.z {
        1
    } else {
        2
    }
}

/// Lowest and highest coordinates.
pub fn bounds(points: impl Iterator<Item = DVec3>) -> (DVec3, DVec3) {
    points.fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(l, h), p| (l.min(p), h.max(p)))
}

impl Tile {
    fn new(patches: Vec<Patch>) -> Self {
        let around = Self::around(patches.iter().flat_map(|p| p.corners));
        Self { patches, ..around }
    }

    /// One without patches around places.
    pub fn around(places: impl Iterator<Item = DVec3> + Clone) -> Self {
        let (low, high) = bounds(places.clone());
        let centre = 0.5 * (low + high);
        let radius = places.map(|p| p.distance(centre)).fold(0.0, f64::max);
        Self { patches: Vec::new(), centre, radius }
    }

    /// Its samples, about `spacing` mm apart, in blocks of [`BLOCK`] neighbouring ones; those on the rim and `inset`
    /// mm beside it have no area.
    pub fn samples(&self, spacing: f64, inset: f64) -> Vec<Sample> {
        let (mut out, mut rim) = (Vec::new(), Vec::new());
        let cell = CELL * spacing * spacing;
        // A needle's cells may be as long as a few squares; where it is machined they are as long as others.
        let side = 9.0 * cell;
        for &patch in &self.patches {
            let length = if patch.machined { cell.sqrt() } else { LENGTH * side.sqrt() };
            let most = Most { area: cell, side, length };
            split(patch, most, &mut |p| {
                out.push(p.sample(out.len()));
                p.sample_rim(inset, &mut rim);
            });
        }
        arrange(&mut out);
        // By themselves, so that they change no other block.
        arrange(&mut rim);
        out.append(&mut rim);
        out
    }
}

impl Patch {
    /// The same, beginning at another corner.
    fn turned(self, first: usize) -> Self {
        let turn = |i: usize| (first + i) % 3;
        let corners = [0, 1, 2].map(|i| self.corners[turn(i)]);
        let normals = [0, 1, 2].map(|i| self.normals[turn(i)]);
        let rim = [0, 1, 2].map(|i| self.rim[turn(i)]);
        Self { corners, normals, rim, ..self }
    }

    fn sample(&self, index: usize) -> Sample {
        let place = |k: usize| (0.5 + index as f64 * STEPS[k]).fract();
        let (mut u, mut v) = (place(0), place(1));
        if u + v > 1.0 {
            (u, v) = (1.0 - u, 1.0 - v);
        }
        let pull = |x: f64| SCATTER * x + (1.0 - SCATTER) / 3.0;
        let (u, v) = (pull(u), pull(v));
        let centroid = (self.corners[0] + self.corners[1] + self.corners[2]) / 3.0;
        let sample = self.at([1.0 - u - v, u, v]);
        let to_centroid = (centroid - sample.position).as_vec3().to_array();
        let section = CrossSection::on(self.area, self.corners, self.normals);
        Sample { to_centroid, section, ..sample }
    }

    /// Samples without area on the edges that lie on the rim, at the start and the middle of each, and one beside the
    /// latter: the rim itself may be just out of reach.
    fn sample_rim(&self, inset: f64, out: &mut Vec<Sample>) {
        for i in (0..3).filter(|&i| self.rim[i]) {
            let [a, b, c] = [i, (i + 1) % 3, (i + 2) % 3];
            let mix = |from: f64, opposite: f64| {
                let mut weights = [0.0; 3];
                (weights[a], weights[c]) = (from, opposite);
                weights[b] = 1.0 - from - opposite;
                self.at(weights)
            };
            let (begin, half) = (mix(1.0, 0.0), mix(0.5, 0.0));
            let width = 2.0 * self.area / self.corners[a].distance(self.corners[b]);
            let part = (inset / width).min(1.0 / 3.0);
            out.extend([begin, half].map(|s| Sample { on_rim: true, ..s }));
            if part > 0.0 {
                out.push(mix(0.5 * (1.0 - part), part));
            }
        }
    }

    /// The sample without area at a weighted mean of the corners.
    fn at(&self, weights: [f64; 3]) -> Sample {
        let mix = |x: &[DVec3; 3]| x[0] * weights[0] + x[1] * weights[1] + x[2] * weights[2];
        let position = mix(&self.corners);
        let normal = mix(&self.normals).normalize_or(self.normals[0]);
        let (machined, is_bridge) = (self.machined, self.is_bridge);
        Sample { machined, is_bridge, ..Sample::bare(position, normal) }
    }

    /// The sample without area at its place nearest to a point.
    pub fn nearest(&self, point: DVec3) -> Sample {
        self.at(nearest_on_triangle(point, self.corners))
    }

    /// Whether it may come within a distance of a point.
    pub fn is_near(&self, point: DVec3, distance: f64) -> bool {
        let [a, b, c] = self.corners;
        let (low, high) = (a.min(b).min(c), a.max(b).max(c));
        point.clamp(low, high).distance_squared(point) <= distance * distance
    }
}

/// Reorders samples so that neighbouring ones follow each other.
fn arrange(samples: &mut [Sample]) {
    if samples.len() <= BLOCK {
        return;
    }
    let axis = widest(samples.iter().map(|s| s.position));
    // At a whole number of blocks, so that these are full.
    let half = samples.len().div_ceil(2 * BLOCK) * BLOCK;
    samples.select_nth_unstable_by(half, |a, b| {
        let (a, b) = (a.position, b.position);
        a[axis].total_cmp(&b[axis]).then(a.x.total_cmp(&b.x)).then(a.y.total_cmp(&b.y))
    });
    let (low, high) = samples.split_at_mut(half);
    arrange(low);
    arrange(high);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::OrderBy;

    fn square(size: f64) -> (Vec<DVec3>, Vec<[u32; 3]>) {
        let corner = |x, y| DVec3::new(x, y, 0.0) * size;
        (
            vec![corner(0.0, 0.0), corner(1.0, 0.0), corner(1.0, 1.0), corner(0.0, 1.0)],
            vec![[0, 1, 2], [0, 2, 3]],
        )
    }

    fn sampled(size: f64, spacing: f64) -> Vec<Sample> {
        let (positions, faces) = square(size);
        let nothing = Facets { positions: &[], faces: &[] };
        let tiles =
            tiles(Facets { positions: &positions, faces: &faces }, nothing, spacing, &[], &[]);
        tiles.iter().flat_map(|t| t.samples(spacing, 0.0)).collect()
    }

    #[test]
    fn areas_add_up_and_density_is_even() {
        let samples = sampled(50.0, 0.5);
        let total: f64 = samples.iter().map(|s| s.section.area).sum();
        assert!((total - 2500.0).abs() < 1e-6);
        for (x, y) in [(0.0, 0.0), (17.0, 3.0), (40.0, 40.0)] {
            let within = |s: &&Sample| {
                (x..x + 10.0).contains(&s.position.x) && (y..y + 10.0).contains(&s.position.y)
            };
            let area: f64 = samples.iter().filter(within).map(|s| s.section.area).sum();
            assert!((area - 100.0).abs() < 3.0, "{area}");
        }
    }

    /// Needles with their wide end, or their widest place, anywhere: as many samples as they are long, in order along
    /// them, and their rims whole.
    #[test]
    fn needles_have_as_many_samples_as_they_are_long() {
        let (length, spacing) = (150.0, 0.1);
        for (apex, width) in [(0.0, 0.04), (0.3, 0.04), (0.5, 1e-3), (0.97, 0.3), (1.0, 1e-6)] {
            let positions = [DVec3::ZERO, DVec3::X * length, DVec3::new(apex * length, width, 0.0)];
            let faces = [[0, 1, 2]];
            let nothing = Facets { positions: &[], faces: &[] };
            let rim = [0, 1, 2].map(|corner| Side { facet: 0, corner });
            let facets = Facets { positions: &positions, faces: &faces };
            let tiles = tiles(facets, nothing, spacing, &rim, &[]);
            let samples: Vec<Sample> = tiles.iter().flat_map(|t| t.samples(spacing, 0.0)).collect();
            let (inside, on_rim): (Vec<&Sample>, Vec<&Sample>) =
                samples.iter().partition(|s| s.section.area > 0.0);
            let total: f64 = inside.iter().map(|s| s.section.area).sum();
            assert!((total / (0.5 * length * width) - 1.0).abs() < 1e-6, "{apex} {total}");
            // Patches and cells are each two triangles wide; a cell is as long as a square one.
            let cell = CELL.sqrt() * spacing;
            let most = 1.1 * 4.0 * length / cell + total / (spacing * spacing);
            assert!((inside.len() as f64) < most, "{apex}: {} samples", inside.len());
            let as_rest = super::tiles(nothing, facets, spacing, &[], &[]);
            let as_rest =
                as_rest.iter().map(|t| t.samples(spacing, 0.0).len()).sum::<usize>() as f64;
            let most = 2.0 * length / spacing + total / (spacing * spacing);
            assert!(as_rest < most, "{apex}: {as_rest} samples of the rest");
            let mut along: Vec<f64> = inside.iter().map(|s| s.position.x).collect();
            along.order_by(f64::total_cmp);
            let gap = along.windows(2).map(|w| w[1] - w[0]).fold(0.0, f64::max);
            assert!(gap < 8.0 * spacing, "{apex}: nothing on {gap} mm");
            for y_is_top in [false, true] {
                let on = |s: &&&Sample| {
                    let x = s.position.x / length;
                    let top = width * if x < apex { x / apex } else { (1.0 - x) / (1.0 - apex) };
                    (s.position.y - if y_is_top { top } else { 0.0 }).abs() < 1e-9 * length
                };
                let mut along: Vec<f64> = on_rim.iter().filter(on).map(|s| s.position.x).collect();
                along.order_by(f64::total_cmp);
                let gap = along.windows(2).map(|w| w[1] - w[0]).fold(0.0, f64::max);
                assert!(along.len() > 2 && gap < 8.0 * spacing, "{apex}: {gap} mm of rim");
            }
        }
    }

    #[test]
    fn no_place_is_far_from_a_sample() {
        let samples = sampled(20.0, 0.25);
        let mut farthest: f64 = 0.0;
        for i in 0..40 {
            for j in 0..40 {
                let p = DVec3::new(0.37 + 0.48 * f64::from(i), 0.29 + 0.48 * f64::from(j), 0.0);
                let d =
                    samples.iter().map(|s| s.position.distance(p)).fold(f64::INFINITY, f64::min);
                farthest = farthest.max(d);
            }
        }
        assert!(farthest < 1.2 * 0.25, "{farthest}");
    }

    #[test]
    fn blocks_lie_together() {
        let samples = sampled(8.0, 0.26);
        for block in samples.chunks(BLOCK) {
            let (low, high) = bounds(block.iter().map(|s| s.position));
            assert!((high - low).max_element() < 3.2, "{low} {high}");
        }
    }

    #[test]
    fn creases_keep_their_normals() {
        let positions = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::NEG_Z];
        let faces = [[0, 1, 2], [0, 3, 1]];
        let normals = Facets { positions: &positions, faces: &faces }.normals();
        assert_eq!(normals[0][0], DVec3::Z);
        assert_eq!(normals[1][0], DVec3::NEG_Y);
    }
}
