//! The path in the plane of the chart.

use super::colour;
use super::path_layers::{LIST_STEP, PathLayers, Tint, legend, line_width, list_line, scale_bar};
use super::placement::Placement;
use super::svg::{Anchor, Stroke, Svg};
use evencut_core::flatten::Chart;
use evencut_core::geometry::{DVec2, math};
use evencut_core::surface::Surface;
use evencut_core::toolpath::{MoveKind, PathPoint, Toolpath};

/// Room for the map, px.
const MAP: DVec2 = DVec2::new(720.0, 640.0);
const MARGIN: f64 = 30.0;
const HEADER: f64 = 50.0;
const LEGEND_WIDTH: f64 = 170.0;
const LEGEND_HEIGHT: f64 = 330.0;
/// With the lines of a channel.
const LEGEND_WITH_LINES: f64 = LEGEND_HEIGHT + 3.0 * LIST_STEP;
const OUTLINE: Stroke = Stroke::solid(colour::INK, 1.0);
const EDGE: Stroke = Stroke::solid(colour::RETURN, 1.3);
const ACROSS: Stroke = Stroke::solid(colour::RETURN, 0.7);

/// Lines of the channel of a hub, flat mm; none of any other surface.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FlatLines {
    /// The edges of the blades, or of their fillets, on the hub.
    pub edges: Vec<Vec<DVec2>>,
    /// Lines across the channel.
    pub across: Vec<Vec<DVec2>>,
}

impl FlatLines {
    fn is_empty(&self) -> bool {
        self.edges.is_empty() && self.across.is_empty()
    }

    fn draw(&self, svg: &mut Svg, frame: &Frame) {
        for (lines, stroke) in [(&self.across, ACROSS), (&self.edges, EDGE)] {
            for line in lines {
                let placed: Vec<DVec2> = line.iter().map(|p| frame.place(*p)).collect();
                svg.polyline(&placed, stroke);
            }
        }
    }

    fn explain(svg: &mut Svg, at: DVec2) {
        let entries =
            [(EDGE, "edge of the blade"), (OUTLINE, "its offset"), (ACROSS, "cross line")];
        entries.into_iter().fold(at, |at, (stroke, label)| list_line(svg, at, stroke, label));
    }
}

/// The outline of the flat surface with its holes, and the path in it coloured by removal rate, or
/// where that is not limited by the time of cutting.
///
/// `lines`: those of a channel. `limit`: removal rate at the end of the colour scale, mm³/s. The chart is turned so
/// that it lies broad.
pub fn flat_map(
    surface: &Surface,
    chart: &Chart,
    lines: &FlatLines,
    path: &Toolpath,
    limit: Option<f64>,
) -> String {
    let tint = Tint::of(path, limit);
    let outlines = outlines(surface, chart);
    let frame = Frame::with_lines(&outlines, lines);
    let legend_height = if lines.is_empty() { LEGEND_HEIGHT } else { LEGEND_WITH_LINES };
    let map = frame.size * frame.scale;
    let size = DVec2::new(
        map.x + 3.0 * MARGIN + LEGEND_WIDTH,
        HEADER + map.y.max(legend_height) + 2.0 * MARGIN,
    );
    let mut svg = Svg::new(
        size.x,
        size.y,
        "Flat map of the path",
        &format!(
            "Outline of the flattened surface with the cutter path, coloured by {}.",
            tint.words()
        ),
    );
    svg.text(DVec2::new(MARGIN, 30.0), Anchor::Start, 16.0, "Path in the flat map");
    let placed: Vec<Vec<DVec2>> =
        outlines.iter().map(|l| l.iter().map(|&p| frame.place(p)).collect()).collect();
    svg.region(&placed, colour::MATERIAL, Some(OUTLINE));
    lines.draw(&mut svg, &frame);
    let mut layers = PathLayers::new(tint);
    let length = add_path(&mut layers, &frame, path);
    let area = surface.area() * frame.scale * frame.scale;
    layers.draw(&mut svg, line_width(area / length.max(1.0)));
    let below = legend(&mut svg, DVec2::new(map.x + 2.0 * MARGIN, HEADER), tint);
    if !lines.is_empty() {
        FlatLines::explain(&mut svg, below);
    }
    scale_bar(&mut svg, DVec2::new(MARGIN, size.y - 24.0), frame.scale, "mm (flat)");
    svg.finish()
}

/// The boundary loops in flat mm.
pub(super) fn outlines(surface: &Surface, chart: &Chart) -> Vec<Vec<DVec2>> {
    let loops = surface.connectivity().boundary_loops();
    loops.iter().map(|l| l.iter().map(|v| chart.uv()[v.index()]).collect()).collect()
}

/// Where [`flat_map`] shows flat places.
pub(super) fn placement(surface: &Surface, chart: &Chart, lines: &FlatLines) -> Placement {
    let frame = Frame::with_lines(&outlines(surface, chart), lines);
    let [origin, x, y] = [DVec2::ZERO, DVec2::X, DVec2::Y].map(|p| frame.place(p));
    let row = |of: fn(DVec2) -> f64| [of(x) - of(origin), of(y) - of(origin), 0.0, of(origin)];
    let map = frame.size * frame.scale;
    let drawing = [MARGIN, HEADER, map.x, map.y];
    Placement { x: row(|p| p.x), y: row(|p| p.y), near: [0.0; 4], drawing }
}

/// From flat mm to pixels.
pub(super) struct Frame {
    /// Cosine and sine of the turn.
    turn: DVec2,
    low: DVec2,
    /// Flat mm.
    pub size: DVec2,
    /// px per flat mm.
    pub scale: f64,
}

impl Frame {
    /// The frame around outlines and the edges beside them.
    fn with_lines(outlines: &[Vec<DVec2>], lines: &FlatLines) -> Self {
        Self::around(&[outlines, &lines.edges].concat())
    }

    /// The frame in which the outlines' bounding box is smallest, lying broad.
    pub fn around(outlines: &[Vec<DVec2>]) -> Self {
        let boxed = |degrees: u32| {
            let angle = f64::from(degrees).to_radians();
            let turn = DVec2::new(math::cos(angle), math::sin(angle));
            let points = outlines.iter().flatten().map(|p| turn.rotate(*p));
            let (low, high) = points
                .fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(l, h), p| (l.min(p), h.max(p)));
            (turn, low, high - low)
        };
        let smallest = (0..180)
            .map(boxed)
            .filter(|(.., size)| size.x >= size.y)
            .min_by(|a, b| (a.2.x * a.2.y).total_cmp(&(b.2.x * b.2.y)));
        let (turn, low, size) = smallest.unwrap_or((DVec2::X, DVec2::ZERO, DVec2::ONE));
        let scale = (MAP.x / size.x).min(MAP.y / size.y);
        Self { turn, low, size, scale }
    }

    /// The flat place of a pixel.
    pub fn flat(&self, pixel: DVec2) -> DVec2 {
        let p = DVec2::new(pixel.x - MARGIN, HEADER + self.size.y * self.scale - pixel.y);
        let back = DVec2::new(self.turn.x, -self.turn.y);
        back.rotate(p / self.scale + self.low)
    }

    /// The pixel of a flat place.
    pub fn place(&self, flat: DVec2) -> DVec2 {
        let p = (self.turn.rotate(flat) - self.low) * self.scale;
        DVec2::new(MARGIN + p.x, HEADER + self.size.y * self.scale - p.y)
    }
}

/// Adds the path; what happens away from the surface becomes a straight line. Returns the length of
/// the cutting moves, px.
fn add_path(layers: &mut PathLayers, frame: &Frame, path: &Toolpath) -> f64 {
    let mut length = 0.0;
    let mut last = None;
    let mut away = None;
    for point in &path.points {
        let Some(flat) = point.flat else {
            away = Some(if away == Some(MoveKind::Rapid) { MoveKind::Rapid } else { point.kind });
            continue;
        };
        let here = frame.place(flat);
        if let Some(before) = last {
            let direct = away.map(|kind| PathPoint { kind, mrr: 0.0, ..*point });
            let shown = direct.as_ref().unwrap_or(point);
            layers.add(shown, before, here);
            if shown.kind == MoveKind::Cut {
                length += here.distance(before);
            }
        }
        (last, away) = (Some(here), None);
    }
    length
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::preview::samples;

    #[test]
    fn same_input_same_bytes() {
        let s = samples::bump(20);
        let path = samples::rings(&s, 2_000);
        let draw =
            || flat_map(&s.surface, &s.chart, &FlatLines::default(), &path, Some(samples::LIMIT));
        assert_eq!(draw(), draw());
    }

    #[test]
    fn long_paths_stay_small() {
        let s = samples::bump(20);
        let path = samples::rings(&s, 200_000);
        assert_eq!(path.points.len(), 200_000);
        let bytes =
            flat_map(&s.surface, &s.chart, &FlatLines::default(), &path, Some(samples::LIMIT))
                .len();
        assert!(bytes < 5_000_000, "{bytes}");
    }

    #[test]
    fn oblique_strip_lies_broad() {
        let corners = [(0.0, 0.0), (30.0, 40.0), (22.0, 46.0), (-8.0, 6.0)].map(DVec2::from);
        let frame = Frame::around(&[corners.to_vec()]);
        assert!((frame.size.x - 50.0).abs() < 0.2 && (frame.size.y - 10.0).abs() < 0.5);
    }

    #[test]
    fn empty_path_is_drawn() {
        let s = samples::bump(4);
        assert!(
            flat_map(&s.surface, &s.chart, &FlatLines::default(), &Toolpath::default(), None)
                .ends_with("</svg>\n")
        );
    }
}
