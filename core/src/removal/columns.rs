//! Columns of material on the surface, in tiles.
//!
//! Steps: (1) the chart, rotated by an angle that no path follows, is halved in both directions until a square of
//! `SIDE x SIDE` cells is as fine as required at its scale. (2) Every cell whose middle lies on a face is a column:
//! it stands on that face along the interpolated normal and has the cell's area on the surface. (3) Neighbouring
//! tiles are grouped into blocks, units of work for threads, with a tree over the tiles of each.
//!
//! Columns beside the surface, in the wedge of stock over edges to which it rises, are a set of their own: they count for
//! the removal rate and have no area, so nothing is ever left to be machined on them.

use crate::flatten::Chart;
use crate::geometry::offset::{CrossSection, beside, corner_normals};
use crate::geometry::{DVec2, DVec3, cross2, math};
use crate::mesh::{FaceId, HalfEdgeId, VertexId};
use crate::surface::{Surface, SurfacePoint};

use super::body::Line;

/// Cells along a tile's side. More: larger tiles are opened because of one corner; fewer: more tiles.
const SIDE: usize = 4;
/// Columns per nominal side step. More: smoother rates; time grows quadratically.
const PER_STEP: f64 = 10.0;
/// Greatest number of columns aimed at: a whole part at the finest resolution costs memory and time.
const MOST_COLUMNS: f64 = 8e5;
/// Angle of the grid, rad; the golden section of a right angle keeps it from aligning with paths.
const TURN: f64 = 0.599_997;
/// Halvings below the squares of the mean scale: range over which an uneven chart is followed.
const MOST_HALVINGS: u32 = 8;
/// Tiles in a block.
const BLOCK: usize = 512;

/// A column of material.
#[derive(Copy, Clone, Debug)]
pub(super) struct Column {
    pub line: Line,
    pub section: CrossSection,
}

/// A disc-shaped neighbourhood that holds columns: all within `radius` of the line through
/// `middle` along `normal`, and between `low` and a height that falls.
#[derive(Copy, Clone, Debug)]
pub(super) struct Bound {
    pub middle: DVec3,
    pub normal: DVec3,
    pub radius: f64,
    pub low: f64,
}

/// Neighbouring columns and where their heights stand in those of the block.
#[derive(Clone, Debug)]
pub(super) struct Tile {
    pub first: usize,
    pub count: usize,
    pub bound: Bound,
}

/// A node of a block's tree: its children, which come later, or a tile.
#[derive(Copy, Clone, Debug)]
pub(super) struct Node {
    pub bound: Bound,
    pub parent: u32,
    pub children: Option<[u32; 2]>,
    pub tile: u32,
}

/// Tiles that one thread works on at a time.
#[derive(Clone, Debug)]
pub(super) struct Block {
    pub columns: Vec<Column>,
    /// How high they stand before the cut, mm.
    pub heights: Vec<f64>,
    /// Where the columns are in the chart.
    pub flat: Vec<DVec2>,
    pub tiles: Vec<Tile>,
    /// The root first.
    pub nodes: Vec<Node>,
}

/// All columns of a surface.
#[derive(Clone, Debug)]
pub struct Columns {
    pub(super) blocks: Vec<Block>,
    /// Distance between columns on the surface, mm, at most.
    pub(super) spacing: f64,
}

/// A cell's place before it has a bound.
struct Leaf {
    columns: Vec<(Column, DVec2)>,
}

/// Cuts the chart into cells.
struct Grid<'a> {
    surface: &'a Surface,
    /// `#V` turned flat points.
    turned: Vec<DVec2>,
    /// `#F` linear scales.
    scale: Vec<f64>,
    /// `#F` sections of columns of 1 mm².
    sections: Vec<CrossSection>,
    spacing: f64,
    /// Smallest tile, flat mm.
    smallest: f64,
    leaves: Vec<Leaf>,
}

fn turned(p: DVec2, by: DVec2) -> DVec2 {
    by.rotate(p)
}

impl Columns {
    /// Columns over a whole surface, about an eighth of `side_step` mm apart; `top`: height of the layer's upper
    /// side, mm.
    pub fn new(surface: &Surface, chart: &Chart, side_step: f64, top: f64) -> Self {
        let by = DVec2::new(math::cos(TURN), math::sin(TURN));
        let points: Vec<DVec2> = chart.uv().iter().map(|&p| turned(p, by)).collect();
        let faces = surface.connectivity().faces();
        let scale_of = |(f, v): (usize, &[VertexId; 3])| {
            let [a, b, c] = surface.corners(FaceId(f as u32));
            let flat = cross2(points[v[0].index()], points[v[1].index()], points[v[2].index()]);
            let solid = (b - a).cross(c - a).length();
            if flat > 0.0 { (solid / flat).sqrt() } else { 0.0 }
        };
        let scale: Vec<f64> = faces.iter().enumerate().map(scale_of).collect();
        let spacing = spacing(surface, side_step);
        let mut grid = Grid {
            surface,
            turned: points,
            scale,
            sections: sections(surface),
            spacing,
            // Flat and solid area are equal in all, so the mean scale is one.
            smallest: SIDE as f64 * spacing / f64::from(1u32 << MOST_HALVINGS),
            leaves: Vec::new(),
        };
        grid.cut_all();
        let back = DVec2::new(by.x, -by.y);
        let blocks =
            grid.leaves.chunks(BLOCK).map(|leaves| Block::new(leaves, back, top)).collect();
        Self { blocks, spacing }
    }

    /// Columns on the edges of the boundary, in the wedge of stock between the normals there and `up`, as far apart as
    /// the others; `top`: height of the layer's upper side, mm.
    pub fn beside(surface: &Surface, chart: &Chart, side_step: f64, up: DVec3, top: f64) -> Self {
        let connectivity = surface.connectivity();
        let normals = face_normals(surface);
        let spacing = spacing(surface, side_step);
        let sides = (0..3 * connectivity.face_count() as u32).map(HalfEdgeId);
        let mut columns = Vec::new();
        for side in sides.filter(|h| connectivity.opposite(*h).is_none()) {
            let face = side.face();
            let ends = [side.corner(), (side.corner() + 1) % 3];
            let corners = surface.corners(face);
            let uv = ends.map(|i| chart.uv()[connectivity.face(face)[i].index()]);
            let normals = ends.map(|i| normals[face.index()][i]);
            let found = beside(ends.map(|i| corners[i]), normals, up, (spacing, top));
            columns.extend(found.iter().map(|c| {
                let line = Line { foot: c.foot, normal: c.direction };
                (Column { line, section: c.section }, uv[0].lerp(uv[1], c.along))
            }));
        }
        Self { spacing, ..Self::of(&columns, f64::INFINITY, top).0 }
    }

    /// Columns without areas, up to the given distance inside the boundary of a surface, mm, and `spacing` mm apart;
    /// `top`: height of the layer's upper side, mm.
    pub fn along_boundary(
        surface: &Surface,
        chart: &Chart,
        (inside, spacing): (f64, f64),
        top: f64,
    ) -> Self {
        let connectivity = surface.connectivity();
        let sides = (0..3 * connectivity.face_count() as u32).map(HalfEdgeId);
        let mut lines = Vec::new();
        for side in sides.filter(|h| connectivity.opposite(*h).is_none()) {
            let (face, corner) = (side.face(), side.corner());
            let corners = surface.corners(face);
            let flat = connectivity.face(face).map(|v| chart.uv()[v.index()]);
            let (a, b) = (corners[corner], corners[(corner + 1) % 3]);
            let length = a.distance(b);
            let high = (b - a).cross(corners[(corner + 2) % 3] - a).length() / length;
            // Of a narrow face the middle.
            let inward = (inside / high).min(0.5);
            let count = (length / spacing).ceil().max(1.0) as u32;
            for i in 0..count {
                let along = (f64::from(i) + 0.5) / f64::from(count);
                let mut weights = [0.0; 3];
                weights[corner] = (1.0 - inward) * (1.0 - along);
                weights[(corner + 1) % 3] = (1.0 - inward) * along;
                weights[(corner + 2) % 3] = inward;
                let point = SurfacePoint { face, weights };
                let normal = surface.normal(point);
                if normal != DVec3::ZERO && inward.is_finite() {
                    let at = (0..3).map(|k| flat[k] * weights[k]).sum();
                    lines.push((Line { foot: surface.position(point), normal }, at));
                }
            }
        }
        Self { spacing, ..Self::on(&lines, f64::INFINITY, top).0 }
    }

    /// Columns on these lines with their flat places, without areas; and which line each column stands on. `width`: of
    /// what is tested together at most, flat mm; `top`: the height of the layer's upper side, mm.
    pub(crate) fn on(lines: &[(Line, DVec2)], width: f64, top: f64) -> (Self, Vec<u32>) {
        let column = |&(line, flat): &(Line, DVec2)| {
            let section = CrossSection::default();
            (Column { line, section }, flat)
        };
        let columns: Vec<(Column, DVec2)> = lines.iter().map(column).collect();
        Self::of(&columns, width, top)
    }

    /// Given columns, and which of them each is now; as above.
    fn of(columns: &[(Column, DVec2)], width: f64, top: f64) -> (Self, Vec<u32>) {
        let mut ids: Vec<u32> = (0..columns.len() as u32).collect();
        let mut leaves = Vec::new();
        halve(columns, &mut ids, (0, width), &mut leaves);
        let blocks = leaves.chunks(BLOCK).map(|leaves| Block::new(leaves, DVec2::X, top)).collect();
        (Self { blocks, spacing: 0.0 }, ids)
    }

    /// Number of columns.
    pub fn count(&self) -> usize {
        self.blocks.iter().map(|b| b.columns.len()).sum()
    }

    /// Area of all, mm².
    pub fn area(&self) -> f64 {
        self.blocks.iter().flat_map(|b| &b.columns).map(|c| c.section.area).sum()
    }
}

/// Distance between columns, mm.
fn spacing(surface: &Surface, side_step: f64) -> f64 {
    (side_step / PER_STEP).max((surface.area() / MOST_COLUMNS).sqrt())
}

/// `#F` normals at the corners of every face.
fn face_normals(surface: &Surface) -> Vec<[DVec3; 3]> {
    let faces: Vec<[u32; 3]> =
        surface.connectivity().faces().iter().map(|face| face.map(|v| v.0)).collect();
    corner_normals(surface.positions(), &faces)
}

/// `#F` sections of columns of 1 mm².
fn sections(surface: &Surface) -> Vec<CrossSection> {
    let of = |(f, normals): (usize, &[DVec3; 3])| {
        CrossSection::on(1.0, surface.corners(FaceId(f as u32)), *normals)
    };
    face_normals(surface).iter().enumerate().map(of).collect()
}

/// Orders columns so that neighbours follow each other, and puts a few of them into each leaf, which is no wider than
/// `width`.
fn halve(
    columns: &[(Column, DVec2)],
    ids: &mut [u32],
    (axis, width): (usize, f64),
    leaves: &mut Vec<Leaf>,
) {
    let places = || ids.iter().map(|id| columns[*id as usize].1);
    let size = || {
        let (low, high) =
            places().fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(l, h), p| (l.min(p), h.max(p)));
        high - low
    };
    let is_leaf = match ids.len() {
        0 => return,
        1 => true,
        few if few <= SIDE * SIDE => size().max_element() <= width,
        _ => false,
    };
    if is_leaf {
        leaves.push(Leaf { columns: ids.iter().map(|&id| columns[id as usize]).collect() });
        return;
    }
    let along = |id: u32| columns[id as usize].1[axis];
    let half = ids.len() / 2;
    ids.select_nth_unstable_by(half, |&a, &b| along(a).total_cmp(&along(b)).then(a.cmp(&b)));
    let (low, high) = ids.split_at_mut(half);
    halve(columns, low, (1 - axis, width), leaves);
    halve(columns, high, (1 - axis, width), leaves);
}

impl Grid<'_> {
    fn cut_all(&mut self) {
        let fold = |f: fn(DVec2, DVec2) -> DVec2, start| self.turned.iter().copied().fold(start, f);
        let (low, high) =
            (fold(DVec2::min, DVec2::INFINITY), fold(DVec2::max, DVec2::NEG_INFINITY));
        let extent = (high - low).max_element();
        if !(extent.is_finite() && extent > 0.0) {
            return;
        }
        // Halving a power of two ends at the spacing asked for where the scale is one.
        let mut side = SIDE as f64 * self.spacing;
        while side < extent {
            side *= 2.0;
        }
        let faces: Vec<u32> = (0..self.scale.len() as u32).collect();
        self.cut(low, side, &faces);
    }

    fn corners(&self, face: u32) -> [DVec2; 3] {
        self.surface.connectivity().face(FaceId(face)).map(|v| self.turned[v.index()])
    }

    fn cut(&mut self, low: DVec2, side: f64, faces: &[u32]) {
        let high = low + DVec2::splat(side);
        let meets = |&f: &u32| {
            let [a, b, c] = self.corners(f);
            let (l, h) = (a.min(b).min(c), a.max(b).max(c));
            h.cmpge(low).all() && l.cmple(high).all()
        };
        let inside: Vec<u32> = faces.iter().copied().filter(meets).collect();
        if inside.is_empty() {
            return;
        }
        let scale = inside.iter().map(|&f| self.scale[f as usize]).fold(0.0, f64::max);
        // Halving stops at the size nearest to the spacing asked for, by ratio.
        let fine = side * scale <= core::f64::consts::SQRT_2 * SIDE as f64 * self.spacing;
        if fine || 0.5 * side < self.smallest {
            self.push_leaf(low, side, &inside);
            return;
        }
        let half = 0.5 * side;
        for corner in [(0.0, 0.0), (half, 0.0), (0.0, half), (half, half)] {
            self.cut(low + DVec2::from(corner), half, &inside);
        }
    }

    fn push_leaf(&mut self, low: DVec2, side: f64, faces: &[u32]) {
        let step = side / SIDE as f64;
        let mut columns = Vec::with_capacity(SIDE * SIDE);
        let mut hint = 0;
        for i in 0..SIDE * SIDE {
            let cell = DVec2::new((i % SIDE) as f64 + 0.5, (i / SIDE) as f64 + 0.5);
            let at = low + cell * step;
            let place = |k: usize| self.place(faces[k], at).map(|p| (k, p));
            let found = place(hint).or_else(|| (0..faces.len()).find_map(place));
            let Some((k, point)) = found else { continue };
            hint = k;
            let scale = self.scale[faces[k] as usize];
            let normal = self.surface.normal(point);
            if normal != DVec3::ZERO {
                let line = Line { foot: self.surface.position(point), normal };
                let section = self.sections[faces[k] as usize].scaled(step * step * scale * scale);
                columns.push((Column { line, section }, at));
            }
        }
        if !columns.is_empty() {
            self.leaves.push(Leaf { columns });
        }
    }

    fn place(&self, face: u32, at: DVec2) -> Option<SurfacePoint> {
        let [a, b, c] = self.corners(face);
        let whole = cross2(a, b, c);
        let weights =
            [cross2(at, b, c) / whole, cross2(at, c, a) / whole, cross2(at, a, b) / whole];
        let inside = weights.iter().all(|&w| w >= 0.0);
        inside.then_some(SurfacePoint { face: FaceId(face), weights })
    }
}

impl Block {
    fn new(leaves: &[Leaf], back: DVec2, top: f64) -> Self {
        let mut block = Self {
            columns: Vec::new(),
            heights: Vec::new(),
            flat: Vec::new(),
            tiles: Vec::new(),
            nodes: Vec::new(),
        };
        for leaf in leaves {
            let first = block.columns.len();
            block.columns.extend(leaf.columns.iter().map(|c| c.0));
            block.flat.extend(leaf.columns.iter().map(|c| turned(c.1, back)));
            let bound = Bound::of(&block.columns[first..], top);
            block.tiles.push(Tile { first, count: leaf.columns.len(), bound });
        }
        block.heights = vec![top; block.columns.len()];
        block.add_nodes(0, leaves.len(), 0, top);
        block
    }

    fn add_nodes(&mut self, from: usize, to: usize, parent: u32, top: f64) -> u32 {
        let index = self.nodes.len() as u32;
        let bound = if to - from == 1 {
            self.tiles[from].bound
        } else {
            let last = &self.tiles[to - 1];
            Bound::of(&self.columns[self.tiles[from].first..last.first + last.count], top)
        };
        self.nodes.push(Node { bound, parent, children: None, tile: from as u32 });
        if to - from > 1 {
            let middle = from + (to - from).div_ceil(2);
            let near = self.add_nodes(from, middle, index, top);
            let far = self.add_nodes(middle, to, index, top);
            self.nodes[index as usize].children = Some([near, far]);
        }
        index
    }
}

impl Bound {
    /// Of columns up to the height `top`.
    fn of(columns: &[Column], top: f64) -> Self {
        let count = columns.len().max(1) as f64;
        let middle = columns.iter().map(|c| c.line.foot).sum::<DVec3>() / count;
        let normal = columns.iter().map(|c| c.line.normal).sum::<DVec3>().normalize_or(DVec3::Z);
        let (mut radius, mut low) = (0.0f64, f64::INFINITY);
        for c in columns {
            for end in [c.line.foot, c.line.foot + c.line.normal * top] {
                let d = end - middle;
                let z = d.dot(normal);
                radius = radius.max((d - normal * z).length());
                low = low.min(z);
            }
        }
        Self { middle, normal, radius, low }
    }

    /// Height over the middle, along the normal, of a column that is `height` high.
    pub fn level(&self, column: &Column, height: f64) -> f64 {
        (column.line.foot + column.line.normal * height - self.middle).dot(self.normal)
    }

    /// The level in this bound of all below `level` in another.
    pub fn level_of(&self, other: &Self, level: f64) -> f64 {
        let cosine = self.normal.dot(other.normal);
        let sine = (1.0 - cosine * cosine).max(0.0).sqrt();
        let lift = if cosine > 0.0 { level } else { other.low };
        (other.middle - self.middle).dot(self.normal) + cosine * lift + sine * other.radius
    }

    /// The least of `d . x` over all places in the bound up to `level`.
    pub fn least_along(&self, d: DVec3, level: f64) -> f64 {
        let along = d.dot(self.normal);
        let across = (1.0 - along * along).max(0.0).sqrt();
        d.dot(self.middle) + (along * level).min(along * self.low) - across * self.radius
    }
}
