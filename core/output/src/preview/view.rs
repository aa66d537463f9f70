//! A triangle mesh seen in parallel projection, and what of it can be seen.

use super::colour;
use super::placement::Placement;
use super::shading::{self, Corner, Raster, Side};
use super::svg::{Anchor, Stroke, Svg};
use evencut_core::geometry::{DVec2, DVec3, any_perpendicular};
use evencut_core::surface::Surface;
use evencut_core::verify::Facets;

/// Room for the surface, px.
const ROOM: DVec2 = DVec2::new(720.0, 600.0);
/// How far behind the surface a point may lie and still be seen, px: what the facets' chords and
/// the raster's steps amount to on a slope.
const SLACK: f64 = 3.0;
/// Room on each side of what is machined for what is not, as a part of its extent.
const SURROUNDINGS: f64 = 0.3;

/// A triangle mesh to be drawn.
pub struct Shape {
    positions: Vec<DVec3>,
    /// Unit normals of the vertices.
    normals: Vec<DVec3>,
    /// Triples of indices, counter-clockwise from outside; those of what is machined first.
    faces: Vec<[u32; 3]>,
    /// Number of faces that are machined.
    machined: usize,
}

impl Shape {
    /// A surface, all of it machined.
    pub fn of(surface: &Surface) -> Self {
        let (positions, faces) = surface.triangles();
        let normals = surface.vertex_normals().to_vec();
        Self { positions: positions.to_vec(), normals, machined: faces.len(), faces }
    }

    /// What is machined and the rest of the part. Facets with indices that lead nowhere are left
    /// out.
    pub fn of_part(design: Facets, rest: Facets) -> Self {
        let shift = design.positions.len() as u32;
        let sound =
            |f: &&[u32; 3], of: &Facets| f.iter().all(|&v| (v as usize) < of.positions.len());
        let mut faces: Vec<[u32; 3]> =
            design.faces.iter().filter(|f| sound(f, &design)).copied().collect();
        let machined = faces.len();
        let others = rest.faces.iter().filter(|f| sound(f, &rest));
        faces.extend(others.map(|f| f.map(|v| v + shift)));
        let positions = [design.positions, rest.positions].concat();
        let normals = vertex_normals(&positions, &faces);
        Self { positions, normals, faces, machined }
    }

    fn corners(&self, face: &[u32; 3]) -> [DVec3; 3] {
        face.map(|v| self.positions[v as usize])
    }

    /// Corners of a range of faces, mm.
    fn corners_of(&self, faces: std::ops::Range<usize>) -> impl Iterator<Item = DVec3> + '_ {
        self.faces[faces].iter().flat_map(|f| self.corners(f))
    }

    /// Whether some of it is not machined.
    pub fn has_rest(&self) -> bool {
        self.machined < self.faces.len()
    }

    /// The mean of the machined faces' normals, weighted with their areas; +Z where they cancel, as
    /// on a solid.
    pub fn mean_normal(&self) -> DVec3 {
        let normals = self.faces[..self.machined].iter().map(|f| doubled(self.corners(f)));
        let (sum, size) =
            normals.fold((DVec3::ZERO, 0.0), |(sum, size), n| (sum + n, size + n.length()));
        if sum.length() > 1e-6 * size { sum.normalize() } else { DVec3::Z }
    }
}

/// Normal of a triangle, as long as twice its area.
fn doubled([a, b, c]: [DVec3; 3]) -> DVec3 {
    (b - a).cross(c - a)
}

/// Means of the normals around each vertex, weighted with the faces' areas.
fn vertex_normals(positions: &[DVec3], faces: &[[u32; 3]]) -> Vec<DVec3> {
    let mut sums = vec![DVec3::ZERO; positions.len()];
    for face in faces {
        let normal = doubled(face.map(|v| positions[v as usize]));
        face.iter().for_each(|&v| sums[v as usize] += normal);
    }
    sums.into_iter().map(|n| n.normalize_or(DVec3::Z)).collect()
}

/// A rectangle around projected points, mm.
#[derive(Copy, Clone)]
struct Extent {
    low: DVec2,
    high: DVec2,
}

impl Extent {
    /// Around points; at the origin if there is none.
    fn of(points: impl Iterator<Item = DVec2>) -> Self {
        let (low, high) = points
            .filter(|p| p.is_finite())
            .fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(l, h), p| (l.min(p), h.max(p)));
        if low.x <= high.x {
            Self { low, high }
        } else {
            Self { low: DVec2::ZERO, high: DVec2::ZERO }
        }
    }

    /// With the rest of the part, or with as much of it as leaves room for what is machined.
    fn with_surroundings(self, rest: Self) -> Self {
        let most = SURROUNDINGS * (self.high - self.low);
        if rest.low == rest.high {
            return self;
        }
        Self {
            low: self.low.min(rest.low.max(self.low - most)),
            high: self.high.max(rest.high.min(self.high + most)),
        }
    }
}

/// Parallel projection onto the screen.
#[derive(Copy, Clone)]
pub struct View {
    /// Unit axis to the right.
    pub right: DVec3,
    /// Unit axis upward.
    pub up: DVec3,
    /// Unit axis out of the screen.
    pub toward_viewer: DVec3,
    low: DVec2,
    size: DVec2,
    /// Px a mm.
    pub scale: f64,
}

impl View {
    /// A view from the side to which the surface faces, from above and somewhat from the right.
    ///
    /// `more`: places that must be in the picture too, mm.
    pub fn of(shape: &Shape, more: &[DVec3]) -> Self {
        let normal = shape.mean_normal();
        let across = (DVec3::X - normal * normal.x).normalize_or(any_perpendicular(normal));
        let away = normal.cross(across);
        let toward_viewer = (0.72 * normal - 0.6 * away + 0.35 * across).normalize();
        let right = normal.cross(toward_viewer).normalize();
        let up = toward_viewer.cross(right);
        let flat = |p: DVec3| DVec2::new(p.dot(right), p.dot(up));
        let machined =
            Extent::of(shape.corners_of(0..shape.machined).chain(more.iter().copied()).map(flat));
        let rest = Extent::of(shape.corners_of(shape.machined..shape.faces.len()).map(flat));
        Self::framed([right, up, toward_viewer], machined.with_surroundings(rest))
    }

    /// A view against a direction, `up` as far upward as that leaves it, that holds places, mm.
    pub fn against(toward_viewer: DVec3, up: DVec3, places: impl Iterator<Item = DVec3>) -> Self {
        let right = up.cross(toward_viewer).normalize_or(any_perpendicular(toward_viewer));
        let up = toward_viewer.cross(right);
        let flat = |p: DVec3| DVec2::new(p.dot(right), p.dot(up));
        Self::framed([right, up, toward_viewer], Extent::of(places.map(flat)))
    }

    fn framed([right, up, toward_viewer]: [DVec3; 3], Extent { low, high }: Extent) -> Self {
        // A mesh without extent is drawn as a dot.
        let size = (high - low).max(DVec2::splat(1e-6));
        let scale = (ROOM.x / size.x).min(ROOM.y / size.y);
        Self { right, up, toward_viewer, low, size, scale }
    }

    /// Size of the drawn surface, px.
    pub fn drawn(&self) -> DVec2 {
        self.size * self.scale
    }

    /// Place in px from the upper left corner of the drawn surface.
    pub fn place(&self, p: DVec3) -> DVec2 {
        let x = p.dot(self.right) - self.low.x;
        let y = self.low.y + self.size.y - p.dot(self.up);
        DVec2::new(x, y) * self.scale
    }

    /// Where a picture that draws the surface from `corner` shows places.
    pub fn placement(&self, corner: DVec2) -> Placement {
        let zero = corner + self.place(DVec3::ZERO);
        let row = |axis: DVec3, at: f64| {
            let [a, b, c] = (axis * self.scale).to_array();
            [a, b, c, at]
        };
        Placement {
            x: row(self.right, zero.x),
            y: row(-self.up, zero.y),
            near: row(self.toward_viewer, 0.0),
            drawing: [corner.x, corner.y, self.drawn().x, self.drawn().y],
        }
    }
}

/// A rasterised view.
pub struct Canvas {
    /// The projection.
    pub view: View,
    /// What is seen in each of its pixels.
    pub raster: Raster,
    /// Raster pixels a px.
    pub fineness: f64,
}

impl Canvas {
    /// Draws a shape; `fineness`: raster pixels a px.
    pub fn new(shape: &Shape, view: View, fineness: f64) -> Self {
        let pixels = (view.drawn() * fineness).ceil();
        let mut raster = Raster::new(pixels.x as usize + 1, pixels.y as usize + 1);
        let corner = |(&p, &n): (&DVec3, &DVec3)| Corner {
            place: view.place(p) * fineness,
            nearness: p.dot(view.toward_viewer),
            brightness: shading::brightness(n, view.right, view.up, view.toward_viewer),
        };
        let mut corners: Vec<Corner> =
            shape.positions.iter().zip(&shape.normals).map(corner).collect();
        shading::spread(&mut corners);
        for (i, face) in shape.faces.iter().enumerate() {
            let side = if i < shape.machined { Side::Outer } else { Side::Guarded };
            raster.fill(face.map(|v| corners[v as usize]), side);
        }
        Self { view, raster, fineness }
    }

    /// Size of the raster in the picture, px.
    pub fn size(&self) -> DVec2 {
        DVec2::new(self.raster.width as f64, self.raster.height as f64) / self.fineness
    }

    /// Whether nothing of the surface stands before a point of it.
    pub fn is_visible(&self, p: DVec3) -> bool {
        self.raster
            .nearness_at(self.view.place(p) * self.fineness)
            .is_none_or(|nearness| self.is_in_front(p, nearness))
    }

    fn is_in_front(&self, p: DVec3, nearness: f64) -> bool {
        p.dot(self.view.toward_viewer) + SLACK / self.view.scale >= nearness
    }

    /// The pixel in which a point of the surface is seen from outside: beyond the rim, the one
    /// beside it.
    pub fn pixel(&self, p: DVec3) -> Option<usize> {
        let place = self.view.place(p) * self.fineness;
        let own = self.raster.index_at(place);
        let shown = |i: &usize| self.raster.shade[*i] > 0;
        let beside = || {
            let around = (0..9).map(|i| DVec2::new(f64::from(i % 3 - 1), f64::from(i / 3 - 1)));
            around.filter_map(|d| self.raster.index_at(place + d)).find(shown)
        };
        let pixel = own.filter(shown).or_else(beside)?;
        let outside = self.raster.look(pixel).is_some_and(|(side, _)| side != Side::Inner);
        (outside && self.is_in_front(p, self.raster.nearness[pixel])).then_some(pixel)
    }
}

/// The part's axes, centred at `at`.
pub fn triad(svg: &mut Svg, view: &View, at: DVec2) {
    for (axis, name) in [(DVec3::X, "X"), (DVec3::Y, "Y"), (DVec3::Z, "Z")] {
        let direction = DVec2::new(axis.dot(view.right), -axis.dot(view.up));
        svg.line(at, at + 30.0 * direction, Stroke::solid(colour::INK, 1.5));
        let label = at + 39.0 * direction + DVec2::new(0.0, 4.0);
        svg.text(label, Anchor::Middle, 12.0, name);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::preview::samples;

    #[test]
    fn what_stands_behind_is_hidden() {
        let shape = Shape::of(&samples::bump(40).surface);
        let canvas = Canvas::new(&shape, View::of(&shape, &[]), 2.0);
        let toward = canvas.view.toward_viewer;
        assert!(canvas.is_visible(shape.positions[0]));
        let centre = DVec3::new(50.0, 50.0, 0.0);
        assert!(!canvas.is_visible(centre - 30.0 * toward));
        assert!(canvas.is_visible(centre + 60.0 * toward));
        assert_eq!(canvas.pixel(centre - 30.0 * toward), None);
    }

    #[test]
    fn every_vertex_in_view_has_a_pixel() {
        let shape = Shape::of(&samples::bump(40).surface);
        let canvas = Canvas::new(&shape, View::of(&shape, &[]), 1.5);
        let rim = shape.positions.iter().take(41);
        assert!(rim.clone().all(|&p| canvas.pixel(p).is_some()));
    }

    #[test]
    fn a_solid_is_seen_from_above() {
        let positions = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
        let faces = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
        let design = Facets { positions: &positions, faces: &faces };
        let nothing = Facets { positions: &[], faces: &[] };
        assert_eq!(Shape::of_part(design, nothing).mean_normal(), DVec3::Z);
    }

    #[test]
    fn the_viewer_stands_on_the_outer_side() {
        let shape = Shape::of(&samples::bump(10).surface);
        let view = View::of(&shape, &[]);
        assert!(view.toward_viewer.dot(shape.mean_normal()) > 0.5);
        assert!(view.right.cross(view.up).dot(view.toward_viewer) > 0.999);
    }

    #[test]
    fn meshes_without_extent_are_drawn() {
        let nothing = Facets { positions: &[], faces: &[] };
        let wild = Facets { positions: &[DVec3::NAN; 3], faces: &[[0, 1, 2], [0, 1, 7]] };
        for design in [nothing, wild] {
            let shape = Shape::of_part(design, nothing);
            let canvas = Canvas::new(&shape, View::of(&shape, &[]), 1.0);
            assert!(canvas.raster.shade.iter().all(|&s| s == 0));
        }
    }
}
