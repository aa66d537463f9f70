//! The texture of a window as a picture: heights in colours, with a scale, and profiles along and across the feed.

use super::colour::{self, Rgb};
use super::png;
use super::svg::{Anchor, Stroke, Svg, round_step};
use evencut_core::geometry::DVec2;
use evencut_core::texture::export::{MICRO, Matrix};

const WIDTH: f64 = 960.0;
/// Upper left corner of the map, px.
const MAP: DVec2 = DVec2::new(84.0, 86.0);
/// The largest map, px.
const LARGEST: DVec2 = DVec2::new(660.0, 520.0);
/// Width of the colour bar and its distance from the map, px.
const BAR: DVec2 = DVec2::new(18.0, 36.0);
/// The least map, px: ticks along it are to be told apart.
pub(super) const LEAST: f64 = 64.0;
/// Most ticks along a side.
const TICKS: u32 = 6;
/// Width of a letter and height of a line, px, and the gap between labels side by side.
const LETTER: DVec2 = DVec2::new(7.0, 13.0);
const BESIDE: f64 = 8.0;
/// Colours of the bar: more than a printer tells apart.
const BAND: usize = 96;
/// Size of a profile's panel, px, and the room over it.
const PANEL: DVec2 = DVec2::new(780.0, 110.0);
const ROOM: f64 = 66.0;
/// Most raster pixels along a side: beyond it every so many nodes are shown.
const MOST_PIXELS: usize = 1200;
/// Colours of the raster.
const COLOURS: u8 = 254;
/// The largest map among others, px, the room beside and under it, and how many stand in a row.
const SMALL: DVec2 = DVec2::new(240.0, 360.0);
const GAP: DVec2 = DVec2::new(60.0, 96.0);
/// The least room for it, px: its captions take that.
const NARROWEST: DVec2 = DVec2::new(210.0, LEAST);
const COLUMNS: usize = 4;
const PROFILE: Rgb = Rgb([0x1f, 0x5f, 0x86]);

/// The heights of a map over its mean plane, in µm, with the middle profiles. `levelled`: the map without that plane;
/// `caption`: what is said under the title.
pub fn texture_map(levelled: &Matrix, caption: &str) -> String {
    let scale = Heights::of_all(core::slice::from_ref(levelled));
    let [nu, nv] = levelled.counts;
    let size = length_and_width(levelled);
    let zoom = (LARGEST / size).min_element();
    let shown = (size * zoom).max(DVec2::splat(LEAST));
    let panels = MAP.y + shown.y + ROOM;
    let height = panels + 2.0 * (PANEL.y + ROOM) - 10.0;
    let title = "Texture that the teeth leave";
    let mut svg = Svg::new(WIDTH, height, title, "Heights over the mean plane, and profiles.");
    svg.text(DVec2::new(30.0, 26.0), Anchor::Start, 16.0, title);
    svg.text(DVec2::new(30.0, 46.0), Anchor::Start, 12.0, caption);
    let (columns, rows, pixels) = raster(levelled, &scale);
    let palette: Vec<Rgb> = (0..=COLOURS).map(colour_of).collect();
    svg.stretched_image(MAP, shown, &png::encode(columns, rows, &pixels, &palette));
    rulers(&mut svg, MAP, size, shown);
    svg.text(MAP - DVec2::new(8.0, 13.0), Anchor::End, 12.0, "across, mm");
    bar(&mut svg, &scale, MAP + DVec2::new(shown.x + BAR.y, 0.0), shown.y);
    let row = |i: usize| levelled.heights[nv / 2 * nu + i] * MICRO;
    let column = |j: usize| levelled.heights[j * nu + nu / 2] * MICRO;
    let profiles: [(&str, f64, Vec<f64>); 2] = [
        ("Profile along the feed, in the middle", size.x, (0..nu).map(row).collect()),
        ("Profile across the feed, in the middle", size.y, (0..nv).map(column).collect()),
    ];
    for (k, (name, length, heights)) in profiles.iter().enumerate() {
        let corner = DVec2::new(MAP.x, panels + k as f64 * (PANEL.y + ROOM));
        profile(&mut svg, corner, (name, *length, heights));
    }
    svg.finish()
}

/// A map beside others.
#[derive(Clone, Debug)]
pub struct TexturePanel<'a> {
    /// What it is a map of.
    pub heading: String,
    /// What is said of it.
    pub caption: String,
    /// The map without its mean plane.
    pub levelled: Matrix<'a>,
}

/// Maps side by side in the same colours.
pub fn texture_panels(title: &str, panels: &[TexturePanel]) -> String {
    let maps: Vec<Matrix> = panels.iter().map(|panel| panel.levelled).collect();
    let scale = Heights::of_all(&maps);
    let sizes: Vec<DVec2> = maps.iter().map(length_and_width).collect();
    let largest = sizes.iter().copied().fold(DVec2::splat(1e-9), DVec2::max);
    let zoom = (SMALL / largest).min_element();
    let cell = (largest * zoom).max(NARROWEST) + GAP;
    let columns = panels.len().clamp(1, COLUMNS);
    let rows = panels.len().div_ceil(columns).max(1);
    let width = (MAP.x + cell.x * columns as f64 + BAR.x + 70.0).max(WIDTH);
    let height = MAP.y + cell.y * rows as f64 + 10.0;
    let mut svg = Svg::new(width, height, title, "Heights over the mean plane, side by side.");
    svg.text(DVec2::new(30.0, 26.0), Anchor::Start, 16.0, title);
    let palette: Vec<Rgb> = (0..=COLOURS).map(colour_of).collect();
    for (k, ((panel, map), size)) in panels.iter().zip(&maps).zip(&sizes).enumerate() {
        let place = DVec2::new((k % columns) as f64, (k / columns) as f64);
        let corner = MAP + place * cell;
        let shown = (*size * zoom).max(DVec2::splat(LEAST));
        svg.text(corner - DVec2::new(0.0, 26.0), Anchor::Start, 13.0, &panel.heading);
        svg.text(corner - DVec2::new(0.0, 9.0), Anchor::Start, 12.0, &panel.caption);
        let (columns, rows, pixels) = raster(map, &scale);
        svg.stretched_image(corner, shown, &png::encode(columns, rows, &pixels, &palette));
        rulers(&mut svg, corner, *size, shown);
    }
    let corner = MAP + DVec2::new(cell.x * columns as f64, 0.0);
    bar(&mut svg, &scale, corner, cell.y - GAP.y);
    svg.finish()
}

/// Length of a map along the feed and its width, mm.
pub(super) fn length_and_width(map: &Matrix) -> DVec2 {
    let side = |k: usize| (map.counts[k].max(2) - 1) as f64 * map.steps[k];
    DVec2::new(side(0), side(1))
}

/// The range of heights, µm.
pub(super) struct Heights {
    pub low: f64,
    pub high: f64,
}

impl Heights {
    /// Of all maps together.
    pub fn of_all(maps: &[Matrix]) -> Self {
        Self::around(maps.iter().flat_map(|map| map.heights.iter().map(|h| h * MICRO)))
    }

    /// Of heights in µm; NaN are none.
    fn around(heights: impl Iterator<Item = f64> + Clone) -> Self {
        let heights = heights.filter(|height| !height.is_nan());
        let (low, high) = (heights.clone().reduce(f64::min), heights.reduce(f64::max));
        let [low, high] = [low, high].map(|height| height.unwrap_or(0.0));
        // Of a plane, a range that can be divided by.
        if high - low > 1e-6 {
            Self { low, high }
        } else {
            Self { low: low - 5e-4, high: low + 5e-4 }
        }
    }

    /// The part of the range that lies below a height.
    pub fn share(&self, height: f64) -> f64 {
        ((height - self.low) / (self.high - self.low)).clamp(0.0, 1.0)
    }

    /// Round heights in the range, not more than stand apart on `length` px where a label takes the `room` px.
    pub fn ticks_on(&self, length: f64, room: impl Fn(&str) -> f64) -> Vec<(f64, f64)> {
        let fit = |ticks: &Vec<(f64, f64)>| {
            let apart = |step: f64| step / (self.high - self.low) * length;
            ticks.len() < 2
                || ticks.iter().all(|(value, step)| room(&number(*value, *step)) <= apart(*step))
        };
        let mut fewer = (1..=TICKS).rev().map(|most| self.ticks(f64::from(most)));
        // A single one always fits.
        fewer.find(fit).unwrap_or_else(|| self.ticks(1.0).into_iter().take(1).collect())
    }

    /// Round heights in the range.
    pub fn ticks(&self, most: f64) -> Vec<(f64, f64)> {
        let step = round_step(self.high - self.low, most);
        let first = (self.low / step).ceil() as i64;
        let last = (self.high / step).floor() as i64;
        (first..=last).map(|i| (i as f64 * step, step)).collect()
    }
}

/// Colour `index` of the raster, 1 for the lowest.
fn colour_of(index: u8) -> Rgb {
    colour::of_share(1.0 - f64::from(index.saturating_sub(1)) / f64::from(COLOURS - 1))
}

/// The map as pixels, the last line of nodes on top.
fn raster(map: &Matrix, scale: &Heights) -> (u32, u32, Vec<u8>) {
    let [nu, nv] = map.counts;
    let [columns, rows] = [nu, nv].map(|n| n.min(MOST_PIXELS));
    let mut pixels = Vec::with_capacity(columns * rows);
    for y in 0..rows {
        let j = (rows - 1 - y) * nv / rows;
        for x in 0..columns {
            let height = map.heights[j * nu + x * nu / columns] * MICRO;
            // Nothing is drawn beyond the surface, nor where nothing was cut.
            pixels.push(match height.is_nan() {
                true => 0,
                false => 1 + (scale.share(height) * f64::from(COLOURS - 1)).round() as u8,
            });
        }
    }
    (columns as u32, rows as u32, pixels)
}

/// Room for a label beside others, px.
fn beside(label: &str) -> f64 {
    label.chars().count() as f64 * LETTER.x + BESIDE
}

/// Lengths along the foot and the left side of the map, mm.
fn rulers(svg: &mut Svg, corner: DVec2, size: DVec2, shown: DVec2) {
    let ink = Stroke::solid(colour::INK, 1.0);
    let foot = corner + DVec2::new(0.0, shown.y);
    for (value, step) in (Heights { low: 0.0, high: size.x }).ticks_on(shown.x, beside) {
        let at = foot + DVec2::new(value / size.x * shown.x, 0.0);
        svg.line(at, at + DVec2::new(0.0, 5.0), ink);
        svg.text(at + DVec2::new(0.0, 18.0), Anchor::Middle, 12.0, &number(value, step));
    }
    for (value, step) in (Heights { low: 0.0, high: size.y }).ticks_on(shown.y, |_| LETTER.y) {
        let at = foot - DVec2::new(0.0, value / size.y * shown.y);
        svg.line(at, at - DVec2::new(5.0, 0.0), ink);
        svg.text(at + DVec2::new(-8.0, 4.0), Anchor::End, 12.0, &number(value, step));
    }
    let label = foot + DVec2::new(shown.x / 2.0, 34.0);
    svg.text(label, Anchor::Middle, 12.0, "along the feed, mm");
}

/// The colours and the heights that they stand for, from an upper left corner down.
fn bar(svg: &mut Svg, scale: &Heights, corner: DVec2, length: f64) {
    let band = length / BAND as f64;
    for i in 0..BAND {
        let low = corner + DVec2::new(0.0, i as f64 * band);
        let fill = colour::of_share((i as f64 + 0.5) / BAND as f64);
        // A little more, so that nothing shines through between two of them.
        let more = if i + 1 < BAND { 0.5 } else { 0.0 };
        svg.rectangle(low, DVec2::new(BAR.x, band + more), fill);
    }
    for (value, step) in scale.ticks_on(length, |_| LETTER.y) {
        let at = corner + DVec2::new(BAR.x, (1.0 - scale.share(value)) * length);
        svg.line(at, at + DVec2::new(4.0, 0.0), Stroke::solid(colour::INK, 1.0));
        svg.text(at + DVec2::new(8.0, 4.0), Anchor::Start, 12.0, &number(value, step));
    }
    svg.text(corner - DVec2::new(0.0, 8.0), Anchor::Start, 12.0, "height, µm");
}

fn profile(svg: &mut Svg, corner: DVec2, (name, length, heights): (&str, f64, &[f64])) {
    let scale = Heights::around(heights.iter().copied());
    svg.text(corner - DVec2::new(0.0, 9.0), Anchor::Start, 13.0, name);
    svg.text(corner + DVec2::new(PANEL.x, -9.0), Anchor::End, 12.0, "height, µm, by length, mm");
    let up = |height: f64| (1.0 - scale.share(height)) * PANEL.y;
    for (value, step) in scale.ticks(4.0) {
        let at = corner + DVec2::new(0.0, up(value));
        svg.line(at, at + DVec2::new(PANEL.x, 0.0), Stroke::solid(colour::FAINT, 1.0));
        svg.text(at + DVec2::new(-8.0, 4.0), Anchor::End, 12.0, &number(value, step));
    }
    for (value, step) in (Heights { low: 0.0, high: length }).ticks(8.0) {
        let at = corner + DVec2::new(value / length * PANEL.x, PANEL.y);
        svg.line(at, at + DVec2::new(0.0, 5.0), Stroke::solid(colour::INK, 1.0));
        svg.text(at + DVec2::new(0.0, 18.0), Anchor::Middle, 12.0, &number(value, step));
    }
    // More points than pixels cannot be seen.
    let every = heights.len().div_ceil(4 * MOST_PIXELS).max(1);
    let last = heights.len().saturating_sub(1).max(1) as f64;
    let points = heights.iter().enumerate().step_by(every);
    let points: Vec<DVec2> =
        points.map(|(i, h)| corner + DVec2::new(i as f64 / last * PANEL.x, up(*h))).collect();
    // A line for every stretch that is on the surface.
    for stretch in points.split(|point| point.is_nan()).filter(|stretch| stretch.len() > 1) {
        svg.polyline(stretch, Stroke::solid(PROFILE, 1.2));
    }
}

/// A number with the decimals of its step.
pub(super) fn number(value: f64, step: f64) -> String {
    let decimals = (0..9).find(|d| {
        let shifted = step * 10f64.powi(*d);
        (shifted - shifted.round()).abs() < 1e-6 * shifted
    });
    format!("{:.*}", decimals.unwrap_or(9) as usize, value + 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_map_is_drawn_with_its_scale_and_profiles() {
        let heights: Vec<f64> = (0..2000 * 3).map(|k| f64::from(k % 100) * 1e-5).collect();
        let map = Matrix { counts: [2000, 3], steps: [0.01, 0.01], heights: &heights };
        let text = texture_map(&map, "Sa <1");
        assert_eq!(text.matches("<image ").count(), 1);
        assert_eq!(text.matches("preserveAspectRatio=\"none\"").count(), 1);
        assert_eq!(text.matches("<polyline ").count(), 2);
        assert!(text.contains("height, µm") && text.contains("Sa &lt;1"));
        assert_eq!(text, texture_map(&map, "Sa <1"));
        assert!(text.len() < 200_000);
        let gaps: Vec<f64> =
            heights.iter().map(|h| if *h > 4e-4 { f64::NAN } else { *h }).collect();
        let map = Matrix { heights: &gaps, ..map };
        let text = texture_map(&map, "");
        assert!(!text.contains("NaN") && text.matches("<polyline ").count() > 2);
        let plane = Matrix { counts: [2, 2], steps: [0.1, 0.1], heights: &[0.0; 4] };
        assert!(!texture_map(&plane, "").contains("NaN"));
    }

    #[test]
    fn numbers_have_the_decimals_of_their_step() {
        assert_eq!(number(0.2, 0.1), "0.2");
        assert_eq!(number(0.25, 0.05), "0.25");
        assert_eq!(number(-20.0, 10.0), "-20");
    }

    #[test]
    fn labels_stand_apart_on_any_length() {
        for length in [LEAST, 100.0, 300.0, LARGEST.x] {
            for high in [3e-4, 0.02, 0.1, 2.5, 30.0, 700.0] {
                let range = Heights { low: 0.0, high };
                let ticks = range.ticks_on(length, beside);
                let place = |k: usize| ticks[k].0 / high * length;
                let half = |k: usize| 0.5 * beside(&number(ticks[k].0, ticks[k].1));
                assert!(!ticks.is_empty() && ticks.len() <= TICKS as usize + 1);
                for k in 1..ticks.len() {
                    assert!(place(k) - place(k - 1) >= half(k) + half(k - 1), "{length} {ticks:?}");
                }
            }
        }
        // A narrow window is as wide as its labels need.
        let map = Matrix { counts: [3, 251], steps: [0.01; 2], heights: &[0.0; 753] };
        let text = texture_map(&map, "");
        assert!(text.contains(">0.02<"));
    }
}
