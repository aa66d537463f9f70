//! The channel of a hub between its blades, with passes and tool axes, seen in parallel projection.
//!
//! Blades are drawn as if of glass, over the channel: where one stands before the passes, they still can be seen.

use super::colour::{self, Rgb};
use super::path_layers::{LIST_STEP, PathLayers, Tint, legend, line_width, list_line, scale_bar};
use super::placement::Placement;
use super::shading::Side;
use super::svg::{Anchor, Stroke, Svg};
use super::view::{Canvas, Shape, View, triad};
use super::{png, surface_view};
use evencut_core::geometry::{DVec2, DVec3};
use evencut_core::toolpath::{MoveKind, PathPoint, Toolpath};
use evencut_core::verify::Facets;

const MARGIN: f64 = 30.0;
const HEADER: f64 = 50.0;
/// Upper left corner of the drawing, px.
const ORIGIN: DVec2 = DVec2::new(MARGIN, HEADER);
const LEGEND_WIDTH: f64 = 170.0;
const LEGEND_HEIGHT: f64 = 330.0 + 3.0 * LIST_STEP;
/// Raster pixels a px.
const FINENESS: f64 = 2.0;
/// Toward the viewer: parts along the surface normal, along the channel backward, and across it. More of the last two
/// shows the axes better, and hides more of the channel behind a blade.
const TOWARD: [f64; 3] = [0.8, 0.5, 0.1];
/// How far the hub beside the channel is moved back, px: it runs on under the channel and would show through.
const BACK: f64 = 2.0;
/// Passes on which tool axes are drawn, and axes on a pass as long as the longest one.
const AXES: [usize; 2] = [6, 10];
/// Length of a drawn axis, in diagonals of the channel.
const AXIS_LENGTH: f64 = 0.16;
const AXIS: Stroke = Stroke::solid(colour::INK, 0.8);
/// Shades of the channel, of the hub beside it, and of blades: in all, with mixtures, they have to fit a byte.
const CHANNEL_SHADES: usize = 24;
const HUB_SHADES: usize = 12;
const BLADE_SHADES: usize = 4;
/// Dark and light colours of the channel, of the hub beside it, and of blades.
const CHANNEL: [Rgb; 2] = [Rgb([0xb9, 0xb9, 0xb0]), Rgb([0xfb, 0xfa, 0xf3])];
const HUB: [Rgb; 2] = [Rgb([0xc4, 0xc8, 0xcd]), Rgb([0xea, 0xec, 0xee])];
const BLADE: [Rgb; 2] = [Rgb([0x86, 0xa4, 0xbd]), Rgb([0xd9, 0xe6, 0xf0])];
/// The rims of blades, and how wide they are, raster pixels.
const RIM: Rgb = Rgb([0x6f, 0x86, 0x99]);
const RIM_WIDTH: isize = 2;
/// How much of what is behind a blade it covers.
const COVERS: f64 = 0.5;
/// A step of a blade's depth that is drawn as a rim, in diagonals of the channel.
const STEP: f64 = 0.04;

/// The channel of a hub.
#[derive(Copy, Clone, Debug)]
pub struct ChannelScene<'a> {
    /// What is machined.
    pub channel: Facets<'a>,
    /// The hub about it.
    pub hub: Facets<'a>,
    /// The blades beside it and in it.
    pub blades: Facets<'a>,
}

/// A line along the tool axis, mm.
struct Axis {
    tip: DVec3,
    end: DVec3,
}

/// The channel with its blades, the path on it, coloured by removal rate, or where that is not limited by the time of
/// cutting, and tool axes at regular distances on some of the passes.
///
/// `contacts`: for each path point its place on the channel, mm, `None` away from it. `limit`: removal rate at the end
/// of the colour scale, mm³/s.
pub fn channel_view(
    scene: &ChannelScene,
    path: &Toolpath,
    contacts: &[Option<DVec3>],
    limit: Option<f64>,
) -> String {
    let tint = Tint::of(path, limit);
    let drawn = Drawing::of(scene, path, contacts);
    let (view, axes) = (drawn.view, &drawn.axes);
    let hub = Canvas::new(&drawn.hub, view, FINENESS);
    let nothing = Facets { positions: &[], faces: &[] };
    let blades = Canvas::new(&Shape::of_part(scene.blades, nothing), view, FINENESS);
    let extent = view.drawn();
    let size = DVec2::new(
        extent.x + 3.0 * MARGIN + LEGEND_WIDTH,
        HEADER + extent.y.max(LEGEND_HEIGHT) + 2.5 * MARGIN,
    );
    let mut svg = Svg::new(
        size.x,
        size.y,
        "Channel with tool axes",
        &format!(
            "The channel between two blades with the passes on it, coloured by {}, and the tool axis at places of \
             some passes.",
            tint.words()
        ),
    );
    svg.text(DVec2::new(MARGIN, 30.0), Anchor::Start, 16.0, "Channel with tool axes");
    let (w, h) = (hub.raster.width, hub.raster.height);
    let pixels = mixed(&hub, &blades, STEP * drawn.diagonal);
    svg.image(ORIGIN, hub.size(), &png::encode(w as u32, h as u32, &pixels, &palette()));
    let mut layers = PathLayers::new(tint);
    let length = surface_view::add_path(&mut layers, &hub, path, contacts);
    let machined = |i: &usize| hub.raster.look(*i).is_some_and(|(side, _)| side == Side::Outer);
    let area = (0..hub.raster.shade.len()).filter(machined).count() as f64 / (FINENESS * FINENESS);
    layers.draw(&mut svg, line_width(area / length.max(1.0)));
    for axis in axes {
        svg.line(ORIGIN + view.place(axis.tip), ORIGIN + view.place(axis.end), AXIS);
        let foot = ORIGIN + view.place(axis.tip);
        svg.circle(foot, 1.3, Some(colour::INK), Stroke::solid(colour::INK, 0.1));
    }
    let below = legend(&mut svg, DVec2::new(extent.x + 2.0 * MARGIN, HEADER), tint);
    let below = list_line(&mut svg, below, AXIS, "tool axis");
    list_line(&mut svg, below, Stroke::solid(RIM, 1.3), "blade");
    scale_bar(&mut svg, DVec2::new(MARGIN, size.y - 24.0), view.scale, "mm");
    triad(&mut svg, &view, DVec2::new(size.x - 70.0, size.y - 50.0));
    svg.finish()
}

/// Where [`channel_view`] shows places.
pub(super) fn placement(
    scene: &ChannelScene,
    path: &Toolpath,
    contacts: &[Option<DVec3>],
) -> Placement {
    Drawing::of(scene, path, contacts).view.placement(ORIGIN)
}

/// What is drawn, and from where.
struct Drawing {
    hub: Shape,
    axes: Vec<Axis>,
    view: View,
    /// Diagonal of the box around the channel, mm.
    diagonal: f64,
}

impl Drawing {
    fn of(scene: &ChannelScene, path: &Toolpath, contacts: &[Option<DVec3>]) -> Self {
        let (low, high) = scene
            .channel
            .positions
            .iter()
            .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(l, h), p| (l.min(*p), h.max(*p)));
        let diagonal = if low.x <= high.x { low.distance(high) } else { 0.0 };
        let passes = passes(path, contacts);
        let axes = axes(&passes, AXIS_LENGTH * diagonal);
        let nothing = Facets { positions: &[], faces: &[] };
        let normal = Shape::of_part(scene.channel, nothing).mean_normal();
        let along = along(&passes, normal);
        let [up, back, aside] = TOWARD;
        let across = along.cross(normal);
        let toward = (up * normal - back * along + aside * across).normalize();
        let ends = axes.iter().flat_map(|axis| [axis.tip, axis.end]);
        let solid = scene.channel.positions.iter().chain(scene.blades.positions).copied();
        let view = View::against(toward, along, solid.chain(ends));
        let back = toward * (BACK / view.scale);
        let positions: Vec<DVec3> = scene.hub.positions.iter().map(|p| *p - back).collect();
        let about = Facets { positions: &positions, faces: scene.hub.faces };
        Self { hub: Shape::of_part(scene.channel, about), axes, view, diagonal }
    }
}

/// A point of a pass, and its place on the channel.
type Touching<'a> = (&'a PathPoint, DVec3);

/// The points of every pass that cut.
fn passes<'a>(path: &'a Toolpath, contacts: &[Option<DVec3>]) -> Vec<Vec<Touching<'a>>> {
    let mut passes: Vec<Vec<Touching>> = Vec::new();
    let cutting = path.points.iter().zip(contacts).filter(|(p, _)| p.kind == MoveKind::Cut);
    for (point, contact) in cutting {
        let Some(contact) = contact else { continue };
        match passes.last_mut().filter(|pass| pass[0].0.pass == point.pass) {
            Some(pass) => pass.push((point, *contact)),
            None => passes.push(vec![(point, *contact)]),
        }
    }
    passes
}

/// The unit direction along the channel: that of the longest pass, in the plane across the normal.
fn along(passes: &[Vec<Touching>], normal: DVec3) -> DVec3 {
    let chord = |pass: &Vec<Touching>| pass[pass.len() - 1].1 - pass[0].1;
    let longest = passes.iter().map(chord).max_by(|a, b| a.length().total_cmp(&b.length()));
    let flat = longest.map_or(DVec3::ZERO, |way| way - normal * way.dot(normal));
    flat.normalize_or(evencut_core::geometry::any_perpendicular(normal))
}

/// Axes at regular distances on some of the passes.
fn axes(passes: &[Vec<Touching>], length: f64) -> Vec<Axis> {
    let [shown, each] = AXES;
    let last = passes.len().saturating_sub(1);
    let mut chosen: Vec<usize> =
        (0..shown).map(|i| (i * last + (shown - 1) / 2) / (shown - 1)).collect();
    chosen.dedup();
    let ways: Vec<Vec<f64>> = passes.iter().map(|pass| ways(pass)).collect();
    let length_of = |way: &Vec<f64>| way[way.len() - 1];
    let longest = ways.iter().map(length_of).fold(f64::MIN_POSITIVE, f64::max);
    let of_pass = |i: usize| {
        let (pass, way) = (&passes[i], &ways[i]);
        let whole = length_of(way);
        let steps = ((whole / longest * (each - 1) as f64).round() as usize).max(1);
        let axis_at = move |k: usize| {
            let wanted = whole * k as f64 / steps as f64;
            let next = way.partition_point(|w| *w < wanted).clamp(1, pass.len() - 1);
            let (a, b) = (pass[next - 1].0, pass[next].0);
            let step = way[next] - way[next - 1];
            let part = if step > 0.0 { (wanted - way[next - 1]) / step } else { 0.0 };
            let tip = a.tip.lerp(b.tip, part);
            Axis { tip, end: tip + a.axis.lerp(b.axis, part).normalize_or(a.axis) * length }
        };
        (0..=steps).map(axis_at)
    };
    let is_line = |i: &usize| passes.get(*i).is_some_and(|pass| pass.len() > 1);
    chosen.into_iter().filter(is_line).flat_map(of_pass).collect()
}

/// The way along a pass up to each of its points, mm.
fn ways(pass: &[Touching]) -> Vec<f64> {
    let mut way = vec![0.0];
    for step in pass.windows(2) {
        way.push(way[way.len() - 1] + step[0].1.distance(step[1].1));
    }
    way
}

/// Shades behind blades: none, the channel's, the hub's.
const BEHIND: usize = 1 + CHANNEL_SHADES + HUB_SHADES;

/// The colours of [`mixed`] pixels.
fn palette() -> Vec<Rgb> {
    let ramp = |[dark, light]: [Rgb; 2], count: usize| {
        (0..count).map(move |i| dark.mix(light, i as f64 / (count - 1) as f64))
    };
    let behind: Vec<Rgb> = core::iter::once(colour::GROUND)
        .chain(ramp(CHANNEL, CHANNEL_SHADES))
        .chain(ramp(HUB, HUB_SHADES))
        .collect();
    let covered =
        ramp(BLADE, BLADE_SHADES).flat_map(|b| behind.iter().map(move |c| c.mix(b, COVERS)));
    behind.iter().copied().chain(covered).chain([RIM]).collect()
}

/// The pixels of the hub with the blades over it; `step`: of depth that is a rim, mm.
fn mixed(hub: &Canvas, blades: &Canvas, step: f64) -> Vec<u8> {
    let shade = |brightness: f64, count: usize| (brightness * (count - 1) as f64).round() as usize;
    let nearness = |i: usize| match blades.raster.nearness[i] {
        blade if blade > hub.raster.nearness[i] => blade,
        _ => f64::NEG_INFINITY,
    };
    let (width, height) = (blades.raster.width as isize, blades.raster.height as isize);
    // A crack between facets is one pixel wide: only what is lower for two is beyond a rim.
    let is_rim = |i: usize| {
        let (x, y) = (i as isize % width, i as isize / width);
        let is_lower = |x: isize, y: isize| {
            let inside = (0..width).contains(&x) && (0..height).contains(&y);
            inside && nearness((y * width + x) as usize) < nearness(i) - step
        };
        [(1, 0), (-1, 0), (0, 1), (0, -1)].into_iter().any(|(dx, dy)| {
            (1..=RIM_WIDTH).any(|k| {
                is_lower(x + k * dx, y + k * dy) && is_lower(x + (k + 1) * dx, y + (k + 1) * dy)
            })
        })
    };
    let pixel = |i: usize| {
        let behind = match hub.raster.look(i) {
            None => 0,
            Some((Side::Outer, b)) => 1 + shade(b, CHANNEL_SHADES),
            Some((_, b)) => 1 + CHANNEL_SHADES + shade(b, HUB_SHADES),
        };
        match blades.raster.look(i).filter(|_| nearness(i).is_finite()) {
            None => behind,
            Some(_) if is_rim(i) => BEHIND * (1 + BLADE_SHADES),
            Some((_, b)) => behind + BEHIND * (1 + shade(b, BLADE_SHADES)),
        }
    };
    (0..hub.raster.shade.len()).map(|i| pixel(i) as u8).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::preview::samples;

    #[test]
    fn shades_fit_a_byte() {
        assert_eq!(palette().len(), BEHIND * (1 + BLADE_SHADES) + 1);
        assert!(palette().len() <= 256);
    }

    #[test]
    fn axes_are_drawn_and_blades_cover() {
        let s = samples::bump(20);
        let path = samples::rings(&s, 2_000);
        let contacts = s.contacts(&path);
        let (positions, faces) = s.surface.triangles();
        let channel = Facets { positions, faces: &faces };
        let nothing = Facets { positions: &[], faces: &[] };
        let blade = [DVec3::new(0.0, 0.0, 60.0), DVec3::X * 90.0, DVec3::new(50.0, 90.0, 50.0)];
        let blades = Facets { positions: &blade, faces: &[[0, 1, 2]] };
        let draw = |blades| {
            let scene = ChannelScene { channel, hub: nothing, blades };
            channel_view(&scene, &path, &contacts, None)
        };
        let text = draw(blades);
        assert!(text.matches("<circle").count() >= AXES[1]);
        assert_ne!(text, draw(nothing));
        assert!(!text.contains("NaN"));
    }

    #[test]
    fn nothing_is_drawn() {
        let nothing = Facets { positions: &[], faces: &[] };
        let scene = ChannelScene { channel: nothing, hub: nothing, blades: nothing };
        let text = channel_view(&scene, &Toolpath::default(), &[], None);
        assert!(text.ends_with("</svg>\n") && !text.contains("NaN") && !text.contains("inf"));
    }
}
