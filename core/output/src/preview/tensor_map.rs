//! The best feed directions in the plane of the chart, where they are undefined, and the regions parted
//! there.

use super::colour::{self, Rgb};
use super::flat_map::{Frame, outlines};
use super::path_layers::scale_bar;
use super::regions_map::FILLS;
use super::svg::{Anchor, Stroke, Svg};
use evencut_core::flatten::Chart;
use evencut_core::geometry::DVec2;
use evencut_core::geometry::math::{cos, sin};
use evencut_core::surface::Surface;

const MARGIN: f64 = 30.0;
const HEADER: f64 = 50.0;
const LEGEND: DVec2 = DVec2::new(230.0, 330.0);
/// Distance between strokes and their length, px.
const SPACING: f64 = 15.0;
const STROKE: f64 = 11.0;
/// How far fills of regions are lightened, so that strokes stand out.
const LIGHTER: f64 = 0.45;
/// Radius of the mark of a point, px.
const MARK: f64 = 7.0;
/// Separatrices and what divides: the vermilion and the blue of Okabe and Ito (2008).
const SEPARATRIX: Rgb = Rgb([0xd5, 0x5e, 0x00]);
const WEDGE: Rgb = Rgb([0x00, 0x72, 0xb2]);
const STROKES: Rgb = Rgb([0x5a, 0x60, 0x68]);

/// Where the best feed direction is undefined, and what it parts. Lines and places are those of the chart, flat mm.
#[derive(Clone, Debug)]
pub struct TensorPicture<'a> {
    /// Degenerate points.
    pub points: Vec<PointMark>,
    /// Separatrices.
    pub separatrices: Vec<&'a [DVec2]>,
    /// Outlines of every region; none of a surface that is not divided.
    pub regions: Vec<Vec<Vec<DVec2>>>,
    /// Pairs of points that were taken for noise.
    pub cancelled_pairs: usize,
    /// Area without direction, mm²; `None` where there is none.
    pub free_area: Option<f64>,
}

/// A degenerate point as it is drawn.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct PointMark {
    /// Where, flat mm.
    pub at: DVec2,
    /// What it is.
    pub kind: PointKind,
    /// Whether the surface is divided there.
    pub divides: bool,
}

/// Kinds of degenerate points.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum PointKind {
    /// Three sectors in which the directions bend away.
    Trisector,
    /// The directions turn around it.
    Wedge,
}

/// Regions coloured, short strokes along the best feed direction, degenerate points marked by their kind,
/// separatrices.
///
/// `direction_at`: unit vector along the best feed direction at a flat place; zero where there is none, `None` off the
/// surface.
pub fn tensor_map(
    surface: &Surface,
    chart: &Chart,
    topology: &TensorPicture,
    direction_at: &dyn Fn(DVec2) -> Option<DVec2>,
) -> String {
    let outlines = outlines(surface, chart);
    let frame = Frame::around(&outlines);
    let map = frame.size * frame.scale;
    let size =
        DVec2::new(map.x + 3.0 * MARGIN + LEGEND.x, HEADER + map.y.max(LEGEND.y) + 2.0 * MARGIN);
    let mut svg = Svg::new(
        size.x,
        size.y,
        "Best feed directions",
        "The flattened surface with strokes along the best feed direction, the points where it is \
         undefined, the lines that part its sectors, and the regions.",
    );
    svg.text(DVec2::new(MARGIN, 30.0), Anchor::Start, 16.0, "Best feed directions");
    let placed = |line: &[DVec2]| -> Vec<DVec2> { line.iter().map(|&p| frame.place(p)).collect() };
    let loops: Vec<Vec<DVec2>> = outlines.iter().map(|l| placed(l)).collect();
    svg.region(&loops, colour::MATERIAL, None);
    for (k, outlines) in topology.regions.iter().enumerate() {
        let loops: Vec<Vec<DVec2>> = outlines.iter().map(|l| placed(l)).collect();
        svg.region(&loops, FILLS[k % FILLS.len()].mix(colour::GROUND, LIGHTER), None);
    }
    strokes(&mut svg, &frame, direction_at);
    svg.region_outline(&loops, Stroke::solid(colour::INK, 1.0));
    for separatrix in &topology.separatrices {
        svg.polyline(&placed(separatrix), Stroke::solid(colour::GROUND, 4.5));
        svg.polyline(&placed(separatrix), Stroke::solid(SEPARATRIX, 2.5));
    }
    for point in &topology.points {
        mark(&mut svg, frame.place(point.at), point.kind, point.divides);
    }
    legend(&mut svg, topology, DVec2::new(map.x + 2.0 * MARGIN, HEADER));
    scale_bar(&mut svg, DVec2::new(MARGIN, size.y - 24.0), frame.scale, "mm (flat)");
    svg.finish()
}

/// Strokes on a square grid of pixels, none where there is no direction.
fn strokes(svg: &mut Svg, frame: &Frame, direction_at: &dyn Fn(DVec2) -> Option<DVec2>) {
    let map = frame.size * frame.scale;
    let [columns, rows] = [map.x, map.y].map(|s| (s / SPACING) as u32 + 1);
    let mut data = String::new();
    for row in 0..rows {
        for column in 0..columns {
            let cell = DVec2::new(f64::from(column) + 0.5, f64::from(row) + 0.5);
            let at = frame.flat(DVec2::new(MARGIN, HEADER) + cell * SPACING);
            let Some(direction) = direction_at(at) else { continue };
            let fits = |p: DVec2| direction_at(p).is_some();
            let way = direction * (0.5 * STROKE / frame.scale);
            if !(fits(at - way) && fits(at + way)) {
                continue;
            }
            let ends = [at - way, at + way].map(|p| frame.place(p) * 100.0);
            let [a, b] = ends.map(|p| format!("{:.0} {:.0}", p.x, p.y));
            data.push_str(&format!("M{a}L{b}"));
        }
    }
    svg.fine_lines(&data, Stroke::solid(STROKES, 1.2));
}

/// The mark of a point: a triangle for a trisector, a disc for a wedge; pale if it does not divide.
fn mark(svg: &mut Svg, at: DVec2, kind: PointKind, divides: bool) {
    let rim = Stroke::solid(colour::INK, 1.4);
    match kind {
        PointKind::Trisector => {
            let corner = |i: u32| {
                let angle = core::f64::consts::TAU * (f64::from(i) / 3.0 - 0.25);
                at + DVec2::new(cos(angle), sin(angle)) * (1.4 * MARK)
            };
            let fill = if divides { SEPARATRIX } else { colour::GROUND };
            svg.region(&[(0..3).map(corner).collect()], fill, Some(rim));
        }
        PointKind::Wedge => svg.circle(at, MARK, Some(WEDGE), rim),
    }
}

fn legend(svg: &mut Svg, topology: &TensorPicture, at: DVec2) {
    let mut y = at.y + 12.0;
    let mut row = |svg: &mut Svg, draw: &dyn Fn(&mut Svg, DVec2), text: &str| {
        draw(svg, DVec2::new(at.x + 14.0, y));
        svg.text(DVec2::new(at.x + 38.0, y + 4.0), Anchor::Start, 12.0, text);
        y += 26.0;
    };
    let half = DVec2::new(12.0, 0.0);
    let dash = |stroke: Stroke| move |svg: &mut Svg, p: DVec2| svg.line(p - half, p + half, stroke);
    row(svg, &dash(Stroke::solid(STROKES, 1.2)), "best feed direction");
    row(svg, &dash(Stroke::solid(SEPARATRIX, 2.5)), "separatrix, cut along");
    let count = |is: &dyn Fn(&PointMark) -> bool| topology.points.iter().filter(|p| is(p)).count();
    let kinds: [(PointKind, bool, &str); 3] = [
        (PointKind::Trisector, true, "trisector that divides"),
        (PointKind::Trisector, false, "trisector that does not"),
        (PointKind::Wedge, false, "wedge"),
    ];
    for (kind, divides, text) in kinds {
        let number = count(&|p| p.kind == kind && p.divides == divides);
        let text = format!("{number} × {text}");
        if number > 0 {
            row(svg, &|svg, p| mark(svg, p, kind, divides), &text);
        }
    }
    let mut note = |text: String| row(svg, &|_, _| (), &text);
    if topology.cancelled_pairs > 0 {
        let count = topology.cancelled_pairs;
        note(format!("{count} pair{} taken for noise", if count == 1 { "" } else { "s" }));
    }
    if let Some(area) = topology.free_area {
        note(format!("{area:.0} mm² without direction"));
    }
}
