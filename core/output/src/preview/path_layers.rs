//! The path as a few fine polylines, one layer for each colour, with the legend that explains them.

use super::colour::{self, Rgb};
use super::svg::{Anchor, Stroke, Svg, clock};
use evencut_core::geometry::DVec2;
use evencut_core::toolpath::{MoveKind, PathPoint, Toolpath};
use evencut_core::units::per_minute;
use std::fmt::Write;

/// Colours between nothing and the end of the scale: more grow the file, fewer show bands.
const SHADES: usize = 12;
/// What rounding may add to a rate that is at the limit.
const AT_LIMIT: f64 = 1.0 + 1e-6;
/// Largest displacement by leaving out points, px: invisible.
const TOLERANCE: f64 = 0.02;

/// From one entry of the list of lines to the next, px.
pub const LIST_STEP: f64 = 20.0;

/// Layers in drawing order.
const RAPID: usize = 0;
const LINK: usize = 1;
const RETURN: usize = 2;
const FIRST_SHADE: usize = 3;
const OVER: usize = FIRST_SHADE + SHADES;
const LAYERS: usize = OVER + 1;

/// What the colours of cutting moves tell.
#[derive(Copy, Clone, Debug, PartialEq)]
pub enum Tint {
    /// The removal rate; the scale ends at this limit, mm³/s.
    Rate(f64),
    /// When they are cut; the scale ends with the path, s.
    Time(f64),
}

impl Tint {
    /// The removal rate where it is limited, else when a path cuts. `limit`: mm³/s.
    pub fn of(path: &Toolpath, limit: Option<f64>) -> Self {
        let duration = || path.points.last().map_or(0.0, |p| p.time);
        limit.map_or_else(|| Self::Time(duration()), Self::Rate)
    }

    /// What the colours tell, in words.
    pub fn words(self) -> &'static str {
        match self {
            Self::Rate(_) => "removal rate",
            Self::Time(_) => "time of cutting",
        }
    }

    /// Where a move lies on the scale; above 1 only where a limit is exceeded.
    fn share(self, point: &PathPoint) -> f64 {
        let share = |value: f64, end: f64| if end > 0.0 { value / end } else { 0.0 };
        match self {
            Self::Rate(limit) => share(point.mrr, limit),
            Self::Time(end) => share(point.time, end).min(1.0),
        }
    }
}

/// Moves sorted into layers, px.
pub struct PathLayers {
    tint: Tint,
    data: Vec<String>,
    run: Vec<DVec2>,
    layer: usize,
}

impl PathLayers {
    /// Empty layers.
    pub fn new(tint: Tint) -> Self {
        Self { tint, data: vec![String::new(); LAYERS], run: Vec::new(), layer: RAPID }
    }

    /// Adds the straight move that ends at a point of the path, between two points of the picture.
    pub fn add(&mut self, point: &PathPoint, from: DVec2, to: DVec2) {
        let layer = self.layer_of(point);
        if layer != self.layer || self.run.last() != Some(&from) {
            self.flush();
            self.layer = layer;
            self.run.push(from);
        }
        self.run.push(to);
    }

    fn layer_of(&self, point: &PathPoint) -> usize {
        let share = self.tint.share(point);
        match point.kind {
            MoveKind::Rapid => RAPID,
            _ if share > AT_LIMIT => OVER,
            MoveKind::Link => LINK,
            MoveKind::Return => RETURN,
            MoveKind::Cut | MoveKind::Trochoid => {
                FIRST_SHADE + ((share.max(0.0) * SHADES as f64) as usize).min(SHADES - 1)
            }
        }
    }

    /// Writes the current run to its layer.
    fn flush(&mut self) {
        let run = std::mem::take(&mut self.run);
        if run.len() > 1 {
            append(&mut self.data[self.layer], &simplified(&run));
        }
    }

    /// Draws all layers; `width`: of a cutting line, px.
    pub fn draw(mut self, svg: &mut Svg, width: f64) {
        self.flush();
        for (layer, data) in self.data.iter().enumerate().filter(|(_, d)| !d.is_empty()) {
            svg.fine_lines(data, stroke_of(layer, width));
        }
    }
}

fn stroke_of(layer: usize, width: f64) -> Stroke {
    match layer {
        RAPID => Stroke::dashed(colour::RAPID, 0.7 * width),
        LINK => Stroke::solid(colour::LINK, 0.7 * width),
        RETURN => Stroke::solid(colour::RETURN, 0.6 * width),
        OVER => Stroke::solid(colour::OVER_LIMIT, 1.4 * width),
        shade => Stroke::solid(shade_colour(shade - FIRST_SHADE), width),
    }
}

/// Colours of removal rates from none to the limit, then of what is above it.
pub fn colours() -> [Rgb; SHADES + 1] {
    std::array::from_fn(|i| if i < SHADES { shade_colour(i) } else { colour::OVER_LIMIT })
}

fn shade_colour(shade: usize) -> Rgb {
    colour::of_share((shade as f64 + 0.5) / SHADES as f64)
}

/// Width of a cutting line so that neighbouring passes stay apart: `spacing` between them, px.
pub fn line_width(spacing: f64) -> f64 {
    (0.3 * spacing).clamp(0.25, 1.3)
}

/// Appends a polyline in whole hundredths of a pixel, relative moves after the first point.
fn append(data: &mut String, points: &[DVec2]) {
    let whole = |p: DVec2| ((100.0 * p.x).round() as i64, (100.0 * p.y).round() as i64);
    let mut last = whole(points[0]);
    // Writing to a string cannot fail.
    let _ = write!(data, "M{} {}l", last.0, last.1);
    let mut first = true;
    for &p in &points[1..] {
        let next = whole(p);
        let (dx, dy) = (next.0 - last.0, next.1 - last.1);
        let before_x = if first || dx < 0 { "" } else { " " };
        let before_y = if dy < 0 { "" } else { " " };
        let _ = write!(data, "{before_x}{dx}{before_y}{dy}");
        (last, first) = (next, false);
    }
}

/// The polyline without points that lie within the tolerance of the chord that replaces them.
///
/// # Source
/// Douglas and Peucker, "Algorithms for the reduction of the number of points", 1973.
fn simplified(points: &[DVec2]) -> Vec<DVec2> {
    let mut keep = vec![false; points.len()];
    keep[0] = true;
    keep[points.len() - 1] = true;
    let mut open = vec![(0, points.len() - 1)];
    while let Some((from, to)) = open.pop() {
        if let Some(far) = farthest(points, from, to) {
            keep[far] = true;
            open.extend([(from, far), (far, to)]);
        }
    }
    points.iter().zip(keep).filter(|(_, k)| *k).map(|(&p, _)| p).collect()
}

/// The point farthest from the chord, if it is farther than the tolerance.
fn farthest(points: &[DVec2], from: usize, to: usize) -> Option<usize> {
    let (a, chord) = (points[from], points[to] - points[from]);
    let length = chord.length_squared();
    let mut worst = (TOLERANCE * TOLERANCE, None);
    for (i, &p) in points.iter().enumerate().take(to).skip(from + 1) {
        let t = if length > 0.0 { ((p - a).dot(chord) / length).clamp(0.0, 1.0) } else { 0.0 };
        let distance = p.distance_squared(a + chord * t);
        if distance > worst.0 {
            worst = (distance, Some(i));
        }
    }
    worst.1
}

/// Colour bar and the list of lines, from the upper left corner `at`, 170 x 330 px. Returns where the list can go on.
pub fn legend(svg: &mut Svg, at: DVec2, tint: Tint) -> DVec2 {
    let (title, unit) = match tint {
        Tint::Rate(_) => ("Removal rate", "mm³/min"),
        Tint::Time(_) => ("Time of cutting", "min:s"),
    };
    let bar = DVec2::new(16.0, 168.0);
    let top = at + DVec2::new(0.0, 40.0);
    svg.text(at + DVec2::new(0.0, 10.0), Anchor::Start, 13.0, title);
    svg.text(at + DVec2::new(0.0, 27.0), Anchor::Start, 12.0, unit);
    let piece = bar.y / SHADES as f64;
    for shade in 0..SHADES {
        let y = top.y + bar.y - (shade + 1) as f64 * piece;
        svg.rectangle(DVec2::new(at.x, y), DVec2::new(bar.x, piece), shade_colour(shade));
    }
    for share in [0.0, 0.25, 0.5, 0.75, 1.0] {
        let y = top.y + bar.y * (1.0 - share);
        let from = DVec2::new(at.x + bar.x, y);
        svg.line(from, from + DVec2::new(4.0, 0.0), Stroke::solid(colour::INK, 1.0));
        svg.text(from + DVec2::new(8.0, 4.0), Anchor::Start, 12.0, &label(tint, share));
    }
    list_lines(svg, top + DVec2::new(0.0, bar.y + 28.0), tint)
}

fn label(tint: Tint, share: f64) -> String {
    match tint {
        Tint::Rate(limit) if share == 1.0 => format!("{} limit", rate(per_minute(limit))),
        Tint::Rate(limit) => rate(per_minute(limit) * share),
        Tint::Time(end) if share == 1.0 => format!("{} end", clock(end)),
        Tint::Time(end) => clock(end * share),
    }
}

/// The lines that have colours of their own; where no rate is known nothing exceeds it.
fn list_lines(svg: &mut Svg, at: DVec2, tint: Tint) -> DVec2 {
    let all =
        [(OVER, "above the limit"), (RETURN, "trochoid return"), (LINK, "link"), (RAPID, "rapid")];
    let of_rates = match tint {
        Tint::Rate(_) => 0,
        Tint::Time(_) => 2,
    };
    let shown = all.into_iter().skip(of_rates);
    shown.fold(at, |at, (layer, label)| list_line(svg, at, stroke_of(layer, 1.8), label))
}

/// An entry of the list of lines. Returns where the next one goes.
pub fn list_line(svg: &mut Svg, at: DVec2, stroke: Stroke, label: &str) -> DVec2 {
    svg.line(at, at + DVec2::new(26.0, 0.0), stroke);
    svg.text(at + DVec2::new(34.0, 4.0), Anchor::Start, 12.0, label);
    at + DVec2::new(0.0, LIST_STEP)
}

/// A rate in mm³/min with as many digits as are of use.
pub fn rate(value: f64) -> String {
    if value >= 100.0 || value == 0.0 { format!("{value:.0}") } else { format!("{value:.1}") }
}

/// A scale bar of a round length, its left end at `at`; `scale`: px a mm.
pub fn scale_bar(svg: &mut Svg, at: DVec2, scale: f64, unit: &str) {
    let length = super::svg::round_step(160.0 / scale, 2.0);
    let end = at + DVec2::new(length * scale, 0.0);
    let ink = Stroke::solid(colour::INK, 1.5);
    let tick = DVec2::new(0.0, 4.0);
    svg.line(at, end, ink);
    svg.line(at - tick, at + tick, ink);
    svg.line(end - tick, end + tick, ink);
    svg.text(end + DVec2::new(8.0, 4.0), Anchor::Start, 12.0, &format!("{length} {unit}"));
}

#[cfg(test)]
mod tests {
    use super::*;
    use evencut_core::geometry::DVec3;

    fn point(kind: MoveKind, mrr: f64, time: f64) -> PathPoint {
        PathPoint {
            kind,
            pass: 0,
            region: 0,
            tip: DVec3::ZERO,
            axis: DVec3::Z,
            normal: DVec3::Z,
            flat: None,
            feed: 1.0,
            mrr,
            alpha: 0.0,
            time,
        }
    }

    #[test]
    fn straight_runs_become_one_chord() {
        let run: Vec<DVec2> = (0..100).map(|i| DVec2::new(f64::from(i), 3.0)).collect();
        assert_eq!(simplified(&run), [run[0], run[99]]);
    }

    #[test]
    fn left_out_points_stay_within_the_tolerance() {
        let run: Vec<DVec2> = (0..500)
            .map(|i| {
                DVec2::new(
                    f64::from(i) * 0.2,
                    20.0 * evencut_core::geometry::math::sin(f64::from(i) * 0.02),
                )
            })
            .collect();
        let short = simplified(&run);
        assert!(short.len() < run.len() / 2);
        for p in run {
            let distance = short
                .windows(2)
                .map(|w| {
                    let t =
                        ((p - w[0]).dot(w[1] - w[0]) / w[0].distance_squared(w[1])).clamp(0.0, 1.0);
                    p.distance(w[0].lerp(w[1], t))
                })
                .fold(f64::INFINITY, f64::min);
            assert!(distance <= TOLERANCE + 1e-9);
        }
    }

    #[test]
    fn rates_fall_into_layers() {
        let layers = PathLayers::new(Tint::Rate(10.0));
        let layer = |kind, mrr| layers.layer_of(&point(kind, mrr, 0.0));
        assert_eq!(layer(MoveKind::Cut, 10.0), OVER - 1);
        assert_eq!(layer(MoveKind::Trochoid, 10.1), OVER);
        assert_eq!(layer(MoveKind::Link, 0.0), LINK);
        assert_eq!(layer(MoveKind::Link, 11.0), OVER);
        assert_eq!(layer(MoveKind::Cut, 0.0), FIRST_SHADE);
    }

    #[test]
    fn without_a_limit_colours_tell_the_time() {
        let points = vec![point(MoveKind::Cut, 0.0, 0.0), point(MoveKind::Cut, 0.0, 90.0)];
        let layers = PathLayers::new(Tint::of(&Toolpath { points }, None));
        let layer = |kind, time| layers.layer_of(&point(kind, 99.0, time));
        assert_eq!(layer(MoveKind::Cut, 0.0), FIRST_SHADE);
        assert_eq!(layer(MoveKind::Cut, 46.0), FIRST_SHADE + SHADES / 2);
        assert_eq!(layer(MoveKind::Cut, 90.0), OVER - 1);
        assert_eq!(layer(MoveKind::Link, 90.0), LINK);
    }

    #[test]
    fn data_is_relative_and_whole() {
        let mut data = String::new();
        append(&mut data, &[DVec2::new(1.0, 2.0), DVec2::new(0.5, 2.5), DVec2::new(0.75, 2.0)]);
        assert_eq!(data, "M100 200l-50 50 25-50");
    }
}
