//! The colours of a heat map, what they stand for, and the legend that says so.

use super::colour::{self, Rgb};
use super::marks::Mark;
use super::shading::Side;
use super::svg::{Anchor, Stroke, Svg, round_step};
use super::view::Canvas;
use evencut_core::geometry::DVec2;

/// Colours between nothing and the upper end.
const STEPS: u8 = 18;
/// Above the limit.
pub const OVER: u8 = STEPS;
/// Nothing was done there; hatched.
pub const MISSING: u8 = STEPS + 1;
const STRIPE: u8 = STEPS + 2;
/// Not machined.
pub const PLAIN: u8 = STEPS + 3;
const INNER: u8 = STEPS + 4;
/// Judged apart.
pub const APART: u8 = STEPS + 5;
/// Cut into, in three depths.
const GOUGE: u8 = STEPS + 6;
const DEPTHS: u8 = 3;

/// Tones of every colour by shading: more show bands less, fewer leave room for colours.
const TONES: u8 = 9;
/// Brightness of the darkest.
const DARKEST: f64 = 0.78;
/// Raster pixels of a stripe with its gap.
const HATCH: usize = 10;

/// Width of the legend, px.
pub const LEGEND_WIDTH: f64 = 260.0;
const BAR: DVec2 = DVec2::new(16.0, 150.0);
const HEADING: f64 = 40.0;
const SWATCH: f64 = 20.0;
const OVER_HEIGHT: f64 = 24.0;
const NEUTRAL_HEIGHT: f64 = 18.0;
const DEPTH_HEIGHT: f64 = 10.0;
/// Nearest that two labels may stand, px.
const LABEL_ROOM: f64 = 13.0;

/// How deep gouges are shown, in the units of the scale.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Depths {
    /// Where they begin.
    pub tolerance: f64,
    /// The deepest.
    pub deepest: f64,
}

/// From values to colours.
#[derive(Clone, Debug)]
pub struct Scale {
    /// What is measured.
    pub title: &'static str,
    /// Its unit.
    pub unit: &'static str,
    /// Colour of a share of the upper end.
    pub ramp: fn(f64) -> Rgb,
    /// Colour above the limit.
    pub over: Rgb,
    /// Value at the upper end.
    pub top: f64,
    /// The limit; the upper end is there.
    pub limit: Option<f64>,
    /// By how much the limit may be exceeded.
    pub slack: f64,
    /// The largest value.
    pub largest: f64,
    /// Gouges, if they are shown.
    pub depths: Option<Depths>,
    /// Meaning of the further colours.
    pub others: Vec<(u8, &'static str)>,
}

impl Scale {
    /// A scale that ends at the limit, or without one at a round number above the largest value.
    pub fn new(limit: Option<f64>, slack: f64, largest: f64) -> Self {
        let limit = limit.filter(|&l| l > 0.0 && l.is_finite());
        let top = limit.unwrap_or_else(|| round_above(largest));
        Self {
            title: "",
            unit: "",
            ramp: colour::of_share,
            over: colour::OVER_LIMIT,
            top,
            limit,
            slack: slack.max(0.0),
            largest,
            depths: None,
            others: Vec::new(),
        }
    }

    /// Whether a value is above the limit.
    pub fn is_over(&self, value: f64) -> bool {
        self.limit.is_some_and(|limit| value > limit + self.slack)
    }

    /// The colour of a value that is no gouge.
    pub fn tone(&self, value: f64) -> u8 {
        if self.is_over(value) {
            return OVER;
        }
        let share = (value / self.top).clamp(0.0, 1.0);
        ((share * f64::from(STEPS)) as u8).min(STEPS - 1)
    }

    /// The colour of a gouge by its depth.
    pub fn gouge(&self, depth: f64) -> u8 {
        let share = self.depths.map_or(0.0, |d| {
            let range = d.deepest - d.tolerance;
            if range > 0.0 { (depth - d.tolerance) / range } else { 1.0 }
        });
        GOUGE + ((share.clamp(0.0, 1.0) * f64::from(DEPTHS)) as u8).min(DEPTHS - 1)
    }

    /// The colours of all tones, unshaded.
    pub fn colours(&self) -> Vec<[u8; 3]> {
        (0..GOUGE + DEPTHS).map(|tone| self.colour(tone).0).collect()
    }

    fn colour(&self, tone: u8) -> Rgb {
        match tone {
            OVER => self.over,
            MISSING => colour::UNTOUCHED,
            STRIPE => colour::UNTOUCHED_STRIPE,
            PLAIN => colour::PLAIN,
            INNER => colour::INNER,
            APART => colour::APART,
            GOUGE.. => colour::GOUGES[usize::from(tone - GOUGE).min(2)],
            step => (self.ramp)((f64::from(step) + 0.5) / f64::from(STEPS)),
        }
    }

    /// The palette of [`Self::indices`].
    pub fn palette(&self) -> Vec<Rgb> {
        let shaded = |tone: u8| {
            let base = self.colour(tone);
            let part = |i: u8| DARKEST + (1.0 - DARKEST) * f64::from(i) / f64::from(TONES - 1);
            (0..TONES).map(move |i| Rgb([0; 3]).mix(base, part(i)))
        };
        std::iter::once(Rgb([255; 3])).chain((0..GOUGE + DEPTHS).flat_map(shaded)).collect()
    }

    /// The marked canvas as indices into the palette.
    pub fn indices(&self, canvas: &Canvas, field: &[Option<Mark>]) -> Vec<u8> {
        let index = |(pixel, mark): (usize, &Option<Mark>)| {
            let Some((side, brightness)) = canvas.raster.look(pixel) else { return 0 };
            let plain = if side == Side::Inner { INNER } else { PLAIN };
            let (x, y) = (pixel % canvas.raster.width, pixel / canvas.raster.width);
            let tone = match mark.map_or(plain, |m| m.tone) {
                MISSING if (x + y) % HATCH < HATCH / 3 => STRIPE,
                tone => tone,
            };
            1 + tone * TONES + (brightness * f64::from(TONES - 1) + dither(x, y)) as u8
        };
        field.iter().enumerate().map(index).collect()
    }

    /// Height of the legend, px.
    pub fn height(&self) -> f64 {
        let over = self.limit.map_or(0.0, |_| OVER_HEIGHT);
        let gouge = self.depths.map_or(0.0, |_| NEUTRAL_HEIGHT + f64::from(DEPTHS) * DEPTH_HEIGHT);
        HEADING + over + BAR.y + gouge + SWATCH * (1.0 + self.others.len() as f64)
    }

    /// Draws the legend from the upper left corner `at`.
    pub fn legend(&self, svg: &mut Svg, at: DVec2) {
        svg.text(at + DVec2::new(0.0, 10.0), Anchor::Start, 13.0, self.title);
        svg.text(at + DVec2::new(0.0, 27.0), Anchor::Start, 12.0, self.unit);
        let mut foot = at + DVec2::new(0.0, HEADING);
        if self.limit.is_some() {
            foot = self.over_block(svg, foot);
        }
        foot = self.bar(svg, foot);
        if let Some(depths) = self.depths {
            foot = self.gouge_blocks(svg, foot, depths);
        }
        for &(tone, meaning) in &self.others {
            foot.y += SWATCH;
            self.swatch(svg, foot, tone, meaning);
        }
    }

    fn over_block(&self, svg: &mut Svg, at: DVec2) -> DVec2 {
        let limit = self.limit.unwrap_or(self.top);
        let size = DVec2::new(BAR.x, OVER_HEIGHT);
        framed(svg, at, size, self.over);
        let mut label = format!("above {}", number(limit + self.slack));
        if self.is_over(self.largest) {
            label += &format!(", up to {}", number(self.largest));
        }
        svg.text(at + DVec2::new(BAR.x + 8.0, 11.0), Anchor::Start, 12.0, &label);
        at + DVec2::new(0.0, OVER_HEIGHT)
    }

    fn bar(&self, svg: &mut Svg, at: DVec2) -> DVec2 {
        let piece = BAR.y / f64::from(STEPS);
        for step in 0..STEPS {
            let y = at.y + BAR.y - f64::from(step + 1) * piece;
            // Half a px more, so that no line of the ground shows between the steps.
            let size = DVec2::new(BAR.x, piece + if step > 0 { 0.5 } else { 0.0 });
            svg.rectangle(DVec2::new(at.x, y), size, self.colour(step));
        }
        outline(svg, at, BAR);
        let step = round_step(self.top, 5.0);
        let height = |value: f64| at.y + BAR.y * (1.0 - value / self.top);
        for i in 0..=(self.top / step + 1e-9).floor() as usize {
            let value = step * i as f64;
            if self.limit.is_none() || height(value) - at.y >= LABEL_ROOM {
                tick(svg, DVec2::new(at.x + BAR.x, height(value)), &number(value));
            }
        }
        if let Some(limit) = self.limit {
            let to = at + DVec2::new(BAR.x + 4.0, 0.0);
            svg.line(at - DVec2::new(4.0, 0.0), to, Stroke::solid(colour::INK, 2.0));
            let label = to + DVec2::new(4.0, 4.0);
            svg.text(label, Anchor::Start, 12.0, &format!("{} limit", number(limit)));
        }
        at + DVec2::new(0.0, BAR.y)
    }

    fn gouge_blocks(&self, svg: &mut Svg, at: DVec2, depths: Depths) -> DVec2 {
        framed(svg, at, DVec2::new(BAR.x, NEUTRAL_HEIGHT), self.colour(0));
        let top = at + DVec2::new(0.0, NEUTRAL_HEIGHT);
        let size = DVec2::new(BAR.x, DEPTH_HEIGHT);
        for i in 0..DEPTHS {
            let low = top + DVec2::new(0.0, f64::from(i) * DEPTH_HEIGHT);
            svg.rectangle(low, size, self.colour(GOUGE + i));
        }
        let height = f64::from(DEPTHS) * DEPTH_HEIGHT;
        outline(svg, top, DVec2::new(BAR.x, height));
        let tolerance = format!("{} and below: gouge", number(-depths.tolerance));
        tick(svg, top + DVec2::new(BAR.x, 0.0), &tolerance);
        let foot = top + DVec2::new(0.0, height);
        if depths.deepest > depths.tolerance {
            let deepest = format!("{} deepest", number(-depths.deepest));
            tick(svg, foot + DVec2::new(BAR.x, 0.0), &deepest);
        }
        foot
    }

    fn swatch(&self, svg: &mut Svg, at: DVec2, tone: u8, meaning: &str) {
        let size = DVec2::new(26.0, 14.0);
        framed(svg, at, size, self.colour(tone));
        if tone == MISSING {
            for i in 0..3 {
                let foot = at + DVec2::new(2.0 + 8.0 * f64::from(i), size.y);
                let head = foot + DVec2::new(6.0, -size.y);
                svg.line(foot, head, Stroke::solid(self.colour(STRIPE), 2.0));
            }
        }
        svg.text(at + DVec2::new(34.0, 11.0), Anchor::Start, 12.0, meaning);
    }
}

/// Threshold of a pixel, 0 to 1: shading in so few tones would show as contour lines.
///
/// # Source
/// Bayer, "An optimum method for two-level rendition of continuous-tone pictures", 1973.
fn dither(x: usize, y: usize) -> f64 {
    const ORDER: [[u8; 4]; 4] = [[0, 8, 2, 10], [12, 4, 14, 6], [3, 11, 1, 9], [15, 7, 13, 5]];
    (f64::from(ORDER[y % 4][x % 4]) + 0.5) / 16.0
}

fn framed(svg: &mut Svg, at: DVec2, size: DVec2, fill: Rgb) {
    svg.rectangle(at, size, fill);
    outline(svg, at, size);
}

/// Pale colours would end nowhere on the light ground.
fn outline(svg: &mut Svg, at: DVec2, size: DVec2) {
    let (x, y) = (DVec2::new(size.x, 0.0), DVec2::new(0.0, size.y));
    svg.polyline(&[at, at + x, at + size, at + y, at], Stroke::solid(colour::INK, 0.6));
}

fn tick(svg: &mut Svg, at: DVec2, label: &str) {
    svg.line(at, at + DVec2::new(4.0, 0.0), Stroke::solid(colour::INK, 1.0));
    svg.text(at + DVec2::new(8.0, 4.0), Anchor::Start, 12.0, label);
}

/// A value with as many digits as are of use, and a true minus.
pub fn number(value: f64) -> String {
    let size = value.abs();
    let is_whole = (size - size.round()).abs() < 1e-6;
    let digits = match size {
        _ if is_whole || size >= 100.0 => 0,
        _ if size >= 1.0 => 1,
        _ => 2,
    };
    let sign = if value < 0.0 { "−" } else { "" };
    format!("{sign}{size:.digits$}")
}

/// A round number not below a value; 1 where there is none above 0.
fn round_above(value: f64) -> f64 {
    if !(value > 1e-6 && value < 1e12) {
        return 1.0;
    }
    let step = round_step(value, 5.0);
    step * (value / step - 1e-9).ceil().max(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn drawn(scale: &Scale) -> String {
        let mut svg = Svg::new(300.0, 500.0, "", "");
        scale.legend(&mut svg, DVec2::ZERO);
        svg.finish()
    }

    #[test]
    fn the_limit_ends_the_scale() {
        let scale = Scale::new(Some(30.0), 2.0, 85.0);
        assert_eq!([scale.tone(0.0), scale.tone(29.9)], [0, STEPS - 1]);
        assert_eq!([scale.tone(31.9), scale.tone(32.1)], [STEPS - 1, OVER]);
        let text = drawn(&scale);
        assert!(text.contains(">30 limit<") && text.contains(">above 32, up to 85<"));
        assert!(!text.contains(">30<") && text.contains(">20<"));
    }

    #[test]
    fn without_a_limit_it_ends_round() {
        let scale = Scale::new(None, 0.0, 87.3);
        assert!(!scale.is_over(1e9));
        let text = drawn(&scale);
        assert!(text.contains(">100<") && !text.contains("limit") && !text.contains("above"));
    }

    #[test]
    fn odd_values_are_drawn() {
        for value in [f64::NAN, f64::INFINITY, -1.0, 0.0, 1e-300, 1e300] {
            let text = drawn(&Scale::new(Some(value), 0.0, value));
            assert!(text.len() < 20_000);
        }
    }

    #[test]
    fn gouges_darken_with_depth() {
        let depths = Some(Depths { tolerance: 5.0, deepest: 35.0 });
        let scale = Scale { depths, ..Scale::new(None, 0.0, 1.0) };
        assert_eq!([6.0, 16.0, 34.0, 35.0].map(|d| scale.gouge(d) - GOUGE), [0, 1, 2, 2]);
        let text = drawn(&scale);
        assert!(text.contains("−5 and below: gouge") && text.contains("−35 deepest"));
    }

    #[test]
    fn dithering_keeps_the_mean() {
        let pixels = || (0..4).flat_map(|y| (0..4).map(move |x| (x, y)));
        for sixteenths in 0..=16 {
            let level = f64::from(sixteenths) / 16.0;
            let sum: f64 = pixels().map(|(x, y)| (level + dither(x, y)).floor()).sum();
            assert_eq!(sum, f64::from(sixteenths));
        }
    }

    #[test]
    fn palette_fits_a_byte() {
        let palette = Scale::new(None, 0.0, 1.0).palette();
        assert_eq!(palette.len(), 1 + usize::from(GOUGE + DEPTHS) * usize::from(TONES));
        assert!(palette.len() <= 256);
    }

    #[test]
    fn numbers_are_of_use() {
        let shown = [-32.04, 0.25, 0.0, 1e3 * 0.03, 12.34, 1234.6].map(number);
        assert_eq!(shown, ["−32.0", "0.25", "0", "30", "12.3", "1235"]);
    }
}
