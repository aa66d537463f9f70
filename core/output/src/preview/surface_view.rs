//! The path on the shaded surface, seen in parallel projection.

use super::path_layers::{PathLayers, Tint, legend, line_width, scale_bar};
use super::placement::Placement;
use super::svg::{Anchor, Svg};
use super::view::{Canvas, Shape, View, triad};
use super::{png, shading};
use evencut_core::geometry::{DVec2, DVec3};
use evencut_core::surface::Surface;
use evencut_core::toolpath::{PathPoint, Toolpath};

const MARGIN: f64 = 30.0;
const HEADER: f64 = 50.0;
/// Upper left corner of the drawn surface, px.
const ORIGIN: DVec2 = DVec2::new(MARGIN, HEADER);
const LEGEND_WIDTH: f64 = 170.0;
const LEGEND_HEIGHT: f64 = 330.0;
/// Raster pixels a px, so that edges stay clean.
const FINENESS: f64 = 2.0;
/// Length after which a move is looked at anew for being hidden, px.
const LOOK_EVERY: f64 = 2.0;

/// The shaded surface with the path on it, coloured by removal rate, or where that is not limited by
/// the time of cutting; hidden parts are left out.
///
/// `contacts`: for each path point its place on the surface, mm, `None` away from it; a missing
/// entry counts as `None`. `limit`: removal rate at the end of the colour scale, mm³/s.
pub fn surface_view(
    surface: &Surface,
    path: &Toolpath,
    contacts: &[Option<DVec3>],
    limit: Option<f64>,
) -> String {
    let tint = Tint::of(path, limit);
    let shape = Shape::of(surface);
    let canvas = Canvas::new(&shape, View::of(&shape, &[]), FINENESS);
    let (view, raster) = (&canvas.view, &canvas.raster);
    let drawn = view.drawn();
    let size = DVec2::new(
        drawn.x + 3.0 * MARGIN + LEGEND_WIDTH,
        HEADER + drawn.y.max(LEGEND_HEIGHT) + 2.5 * MARGIN,
    );
    let mut svg = Svg::new(
        size.x,
        size.y,
        "Path on the surface",
        &format!(
            "Shaded view of the surface with the cutter path on it, coloured by {}.",
            tint.words()
        ),
    );
    svg.text(DVec2::new(MARGIN, 30.0), Anchor::Start, 16.0, "Path on the surface");
    let (w, h) = (raster.width, raster.height);
    let picture = png::encode(w as u32, h as u32, &raster.shade, &shading::palette());
    svg.image(ORIGIN, canvas.size(), &picture);
    let mut layers = PathLayers::new(tint);
    let length = add_path(&mut layers, &canvas, path, contacts);
    let area = raster.shade.iter().filter(|&&s| s > 0).count() as f64 / (FINENESS * FINENESS);
    layers.draw(&mut svg, line_width(area / length.max(1.0)));
    legend(&mut svg, DVec2::new(drawn.x + 2.0 * MARGIN, HEADER), tint);
    scale_bar(&mut svg, DVec2::new(MARGIN, size.y - 24.0), view.scale, "mm");
    triad(&mut svg, view, DVec2::new(size.x - 70.0, size.y - 50.0));
    svg.finish()
}

/// Where [`surface_view`] shows places.
pub(super) fn placement(surface: &Surface) -> Placement {
    View::of(&Shape::of(surface), &[]).placement(ORIGIN)
}

/// Adds the visible parts of the moves on the surface. Returns their length, px.
pub(super) fn add_path(
    layers: &mut PathLayers,
    canvas: &Canvas,
    path: &Toolpath,
    contacts: &[Option<DVec3>],
) -> f64 {
    let mut length = 0.0;
    let ends = path.points.iter().zip(contacts);
    for ((_, from), (point, to)) in ends.clone().zip(ends.skip(1)) {
        if let (Some(from), Some(to)) = (from, to) {
            length += add_move(layers, canvas, point, [*from, *to]);
        }
    }
    length
}

fn add_move(
    layers: &mut PathLayers,
    canvas: &Canvas,
    point: &PathPoint,
    [from, to]: [DVec3; 2],
) -> f64 {
    let view = &canvas.view;
    let total = view.place(from).distance(view.place(to));
    let pieces = (total / LOOK_EVERY).ceil().max(1.0) as usize;
    let at = |i: usize| from.lerp(to, i as f64 / pieces as f64);
    let mut length = 0.0;
    for i in 0..pieces {
        let (a, b) = (at(i), at(i + 1));
        if canvas.is_visible(a) && canvas.is_visible(b) {
            layers.add(point, ORIGIN + view.place(a), ORIGIN + view.place(b));
            length += total / pieces as f64;
        }
    }
    length
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::preview::samples;

    #[test]
    fn a_million_faces_stay_small() {
        let s = samples::bump(708);
        assert!(s.surface.connectivity().face_count() > 1_000_000);
        let path = samples::rings(&s, 200_000);
        let text = surface_view(&s.surface, &path, &s.contacts(&path), Some(samples::LIMIT));
        assert!(text.len() < 5_000_000, "{}", text.len());
    }
}
