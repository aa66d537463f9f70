//! The path on the shaded surface, seen in parallel projection.

use super::path_layers::{PathLayers, legend, line_width, scale_bar};
use super::shading::{self, Corner, Raster};
use super::svg::{Anchor, Stroke, Svg};
use super::{colour, png};
use crate::geometry::{DVec2, DVec3, any_perpendicular};
use crate::surface::Surface;
use crate::toolpath::{PathPoint, Toolpath};

/// Room for the surface, px.
const ROOM: DVec2 = DVec2::new(720.0, 600.0);
const MARGIN: f64 = 30.0;
const HEADER: f64 = 50.0;
const LEGEND_WIDTH: f64 = 170.0;
const LEGEND_HEIGHT: f64 = 330.0;
/// Raster pixels a px, so that edges stay clean.
const FINENESS: f64 = 2.0;
/// Length after which a move is looked at anew for being hidden, px.
const LOOK_EVERY: f64 = 2.0;
/// How far behind the surface a point may lie and still be seen, px: what the facets' chords and
/// the raster's steps amount to on a slope.
const SLACK: f64 = 3.0;

/// The shaded surface with the path on it, coloured by removal rate; hidden parts are left out.
///
/// `contacts`: for each path point its place on the surface, mm, `None` away from it; a missing
/// entry counts as `None`. `limit`: removal rate at the end of the colour scale, mm³/s.
pub fn surface_view(
    surface: &Surface,
    path: &Toolpath,
    contacts: &[Option<DVec3>],
    limit: f64,
) -> String {
    let view = View::of(surface);
    let drawn = view.size * view.scale;
    let size = DVec2::new(
        drawn.x + 3.0 * MARGIN + LEGEND_WIDTH,
        HEADER + drawn.y.max(LEGEND_HEIGHT) + 2.5 * MARGIN,
    );
    let mut svg = Svg::new(
        size.x,
        size.y,
        "Path on the surface",
        "Shaded view of the surface with the cutter path on it, coloured by removal rate.",
    );
    svg.text(DVec2::new(MARGIN, 30.0), Anchor::Start, 16.0, "Path on the surface");
    let raster = rasterised(surface, &view);
    let (w, h) = (raster.width, raster.height);
    let picture = png::encode(w as u32, h as u32, &raster.shade, &shading::palette());
    svg.image(view.origin(), DVec2::new(w as f64, h as f64) / FINENESS, &picture);
    let mut layers = PathLayers::new(limit);
    let length = add_path(&mut layers, &view, &raster, path, contacts);
    let area = raster.shade.iter().filter(|&&s| s > 0).count() as f64 / (FINENESS * FINENESS);
    layers.draw(&mut svg, line_width(area / length.max(1.0)));
    legend(&mut svg, DVec2::new(drawn.x + 2.0 * MARGIN, HEADER), limit);
    scale_bar(&mut svg, DVec2::new(MARGIN, size.y - 24.0), view.scale, "mm");
    triad(&mut svg, &view, DVec2::new(size.x - 70.0, size.y - 50.0));
    svg.finish()
}

/// Parallel projection onto the screen.
struct View {
    right: DVec3,
    up: DVec3,
    toward_viewer: DVec3,
    low: DVec2,
    size: DVec2,
    scale: f64,
}

impl View {
    /// A view from the side to which the surface faces, from above and somewhat from the right.
    fn of(surface: &Surface) -> Self {
        let normal = mean_normal(surface);
        let across = (DVec3::X - normal * normal.x).normalize_or(any_perpendicular(normal));
        let away = normal.cross(across);
        let toward_viewer = (0.72 * normal - 0.6 * away + 0.35 * across).normalize();
        let right = normal.cross(toward_viewer).normalize();
        let up = toward_viewer.cross(right);
        let flat = |p: &DVec3| DVec2::new(p.dot(right), p.dot(up));
        let (low, high) = surface
            .positions()
            .iter()
            .map(flat)
            .fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(l, h), p| (l.min(p), h.max(p)));
        let size = high - low;
        let scale = (ROOM.x / size.x).min(ROOM.y / size.y);
        Self { right, up, toward_viewer, low, size, scale }
    }

    fn origin(&self) -> DVec2 {
        DVec2::new(MARGIN, HEADER)
    }

    /// Place in px from the upper left corner of the drawn surface.
    fn place(&self, p: DVec3) -> DVec2 {
        let x = p.dot(self.right) - self.low.x;
        let y = self.low.y + self.size.y - p.dot(self.up);
        DVec2::new(x, y) * self.scale
    }
}

/// The mean of the faces' normals, weighted with their areas; +Z where they cancel, as on a solid.
fn mean_normal(surface: &Surface) -> DVec3 {
    let faces = surface.connectivity().faces();
    let normals = faces.iter().map(|f| {
        let [a, b, c] = f.map(|v| surface.positions()[v.index()]);
        (b - a).cross(c - a)
    });
    let (sum, size) =
        normals.fold((DVec3::ZERO, 0.0), |(sum, size), n| (sum + n, size + n.length()));
    if sum.length() > 1e-6 * size { sum.normalize() } else { DVec3::Z }
}

fn rasterised(surface: &Surface, view: &View) -> Raster {
    let pixels = (view.size * view.scale * FINENESS).ceil();
    let mut raster = Raster::new(pixels.x as usize + 1, pixels.y as usize + 1);
    let corner = |v: usize| {
        let (p, n) = (surface.positions()[v], surface.vertex_normals()[v]);
        Corner {
            place: view.place(p) * FINENESS,
            nearness: p.dot(view.toward_viewer),
            brightness: shading::brightness(n, view.right, view.up, view.toward_viewer),
        }
    };
    let mut corners: Vec<Corner> = (0..surface.positions().len()).map(corner).collect();
    shading::spread(&mut corners);
    for face in surface.connectivity().faces() {
        raster.fill(face.map(|v| corners[v.index()]));
    }
    raster
}

/// Adds the visible parts of the moves on the surface. Returns their length, px.
fn add_path(
    layers: &mut PathLayers,
    view: &View,
    raster: &Raster,
    path: &Toolpath,
    contacts: &[Option<DVec3>],
) -> f64 {
    let mut length = 0.0;
    let ends = path.points.iter().zip(contacts);
    for ((_, from), (point, to)) in ends.clone().zip(ends.skip(1)) {
        if let (Some(from), Some(to)) = (from, to) {
            length += add_move(layers, view, raster, point, [*from, *to]);
        }
    }
    length
}

fn add_move(
    layers: &mut PathLayers,
    view: &View,
    raster: &Raster,
    point: &PathPoint,
    [from, to]: [DVec3; 2],
) -> f64 {
    let total = view.place(from).distance(view.place(to));
    let pieces = (total / LOOK_EVERY).ceil().max(1.0) as usize;
    let at = |i: usize| from.lerp(to, i as f64 / pieces as f64);
    let mut length = 0.0;
    for i in 0..pieces {
        let (a, b) = (at(i), at(i + 1));
        if is_visible(view, raster, a) && is_visible(view, raster, b) {
            let origin = view.origin();
            layers.add(point.kind, point.mrr, origin + view.place(a), origin + view.place(b));
            length += total / pieces as f64;
        }
    }
    length
}

/// Whether nothing of the surface stands before a point of it.
fn is_visible(view: &View, raster: &Raster, p: DVec3) -> bool {
    let slack = SLACK / view.scale;
    raster
        .nearness_at(view.place(p) * FINENESS)
        .is_none_or(|nearness| p.dot(view.toward_viewer) + slack >= nearness)
}

/// The part's axes, centred at `at`.
fn triad(svg: &mut Svg, view: &View, at: DVec2) {
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
    use crate::mesh::{Connectivity, VertexId};
    use crate::preview::samples;

    #[test]
    fn a_million_faces_stay_small() {
        let s = samples::bump(708);
        assert!(s.surface.connectivity().face_count() > 1_000_000);
        let path = samples::rings(&s, 200_000);
        let text = surface_view(&s.surface, &path, &s.contacts(&path), samples::LIMIT);
        assert!(text.len() < 5_000_000, "{}", text.len());
    }

    #[test]
    fn what_stands_behind_is_hidden() {
        let s = samples::bump(40);
        let view = View::of(&s.surface);
        let raster = rasterised(&s.surface, &view);
        let vertex = s.surface.positions()[0];
        assert!(is_visible(&view, &raster, vertex));
        let centre = DVec3::new(50.0, 50.0, 0.0);
        assert!(!is_visible(&view, &raster, centre - 30.0 * view.toward_viewer));
        assert!(is_visible(&view, &raster, centre + 60.0 * view.toward_viewer));
    }

    #[test]
    fn a_solid_is_seen_from_above() {
        let corners = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
        let faces = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]].map(|f| f.map(VertexId));
        let connectivity = Connectivity::new(4, faces.to_vec()).unwrap();
        assert_eq!(mean_normal(&Surface::new(connectivity, corners.to_vec())), DVec3::Z);
    }

    #[test]
    fn the_viewer_stands_on_the_outer_side() {
        let s = samples::bump(10);
        let view = View::of(&s.surface);
        assert!(view.toward_viewer.dot(mean_normal(&s.surface)) > 0.5);
        assert!(view.right.cross(view.up).dot(view.toward_viewer) > 0.999);
    }
}
