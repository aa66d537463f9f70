//! The texture of a window as pixels: heights in colours with their scale, for documents that take no SVG.

use super::colour::{self, Rgb};
use super::png;
use super::texture_map::{Heights, LEAST, length_and_width, number};
use evencut_core::geometry::DVec2;
use evencut_core::texture::export::{MICRO, Matrix};
use noto_sans_mono_bitmap::{FontWeight, RasterHeight, get_raster, get_raster_width};

/// Room around the map, px: left, above, right, below.
const ROOM: [usize; 4] = [72, 84, 128, 56];
/// The largest map, px.
const LARGEST: DVec2 = DVec2::new(900.0, 700.0);
/// From the top of an axis's name to the map, px.
const NAME: usize = 22;
/// Height of a line of text, and the gap between labels side by side, px.
const LINE: f64 = 16.0;
const BESIDE: f64 = 10.0;
/// Width of the colour bar and its distance from the map, px.
const BAR: [usize; 2] = [20, 28];
/// Length of a tick, px.
const TICK: usize = 5;
/// Colours of heights, from index 1 on; the rest of the palette leads from ink to the ground.
const COLOURS: usize = 224;
const GREYS: usize = 255 - COLOURS;
const INK: u8 = (COLOURS + 1) as u8;
const GROUND: u8 = 255;
const WHITE: Rgb = Rgb([0xff; 3]);

/// The heights of a map over its mean plane, in µm. `levelled`: the map without that plane; `lines`: what is written
/// over it.
pub fn texture_png(levelled: &Matrix, lines: [&str; 2]) -> Vec<u8> {
    let canvas = drawn(levelled, lines);
    let of_height = |i: usize| colour::of_share(1.0 - i as f64 / (COLOURS - 1) as f64);
    let grey = |i: usize| colour::INK.mix(WHITE, i as f64 / (GREYS - 1) as f64);
    let palette: Vec<Rgb> = core::iter::once(WHITE)
        .chain((0..COLOURS).map(of_height))
        .chain((0..GREYS).map(grey))
        .collect();
    png::encode(canvas.width as u32, canvas.height as u32, &canvas.pixels, &palette)
}

/// Map, scales and words.
fn drawn(levelled: &Matrix, lines: [&str; 2]) -> Canvas {
    let size = length_and_width(levelled);
    let zoom = (LARGEST / size).min_element();
    let shown = (size * zoom).max(DVec2::splat(LEAST));
    let [width, height] = [shown.x.round() as usize, shown.y.round() as usize];
    let longest = lines.map(|line| line.chars().count()).into_iter().max().unwrap_or(0);
    let letter = get_raster_width(FontWeight::Regular, RasterHeight::Size16);
    let text = longest * letter;
    let beside = |label: &str| label.chars().count() as f64 * letter as f64 + BESIDE;
    let mut canvas =
        Canvas::new((ROOM[0] + width + ROOM[2]).max(text + 2 * BAR[0]), ROOM[1] + height + ROOM[3]);
    canvas.text(BAR[0], 8, lines[0]);
    canvas.text(BAR[0], 28, lines[1]);
    let scale = Heights::of_all(core::slice::from_ref(levelled));
    let [nu, nv] = levelled.counts;
    let colour = |share: f64| 1 + (share * (COLOURS - 1) as f64).round() as u8;
    for y in 0..height {
        let j = ((height - 1 - y) * nv / height).min(nv - 1);
        for x in 0..width {
            let i = (x * nu / width).min(nu - 1);
            let height = levelled.heights[j * nu + i] * MICRO;
            let pixel = if height.is_nan() { GROUND } else { colour(scale.share(height)) };
            canvas.set(ROOM[0] + x, ROOM[1] + y, pixel);
        }
    }
    let foot = ROOM[1] + height;
    for (value, step) in (Heights { low: 0.0, high: size.x }).ticks_on(shown.x, beside) {
        let x = ROOM[0] + (value / size.x * (width - 1) as f64).round() as usize;
        (0..TICK).for_each(|k| canvas.set(x, foot + k, INK));
        canvas.centred(x, foot + 7, &number(value, step));
    }
    canvas.centred(ROOM[0] + width / 2, foot + 28, "along the feed, mm");
    for (value, step) in (Heights { low: 0.0, high: size.y }).ticks_on(shown.y, |_| LINE) {
        let y = foot - 1 - (value / size.y * (height - 1) as f64).round() as usize;
        (0..TICK).for_each(|k| canvas.set(ROOM[0] - 1 - k, y, INK));
        canvas.before(ROOM[0] - TICK - 4, y.saturating_sub(8), &number(value, step));
    }
    let left = ROOM[0] + width + BAR[1];
    for y in 0..height {
        let share = 1.0 - y as f64 / (height - 1) as f64;
        (0..BAR[0]).for_each(|k| canvas.set(left + k, ROOM[1] + y, colour(share)));
    }
    for (value, step) in scale.ticks_on(shown.y, |_| LINE) {
        let y = ROOM[1] + ((1.0 - scale.share(value)) * (height - 1) as f64).round() as usize;
        (0..TICK).for_each(|k| canvas.set(left + BAR[0] + k, y, INK));
        canvas.text(left + BAR[0] + TICK + 4, y.saturating_sub(8), &number(value, step));
    }
    canvas.text(BAR[0], ROOM[1] - NAME, "across, mm");
    canvas.text(left, ROOM[1] - NAME, "height, µm");
    canvas
}

/// Palette indices, row by row.
struct Canvas {
    width: usize,
    height: usize,
    pixels: Vec<u8>,
}

impl Canvas {
    fn new(width: usize, height: usize) -> Self {
        Self { width, height, pixels: vec![GROUND; width * height] }
    }

    /// Sets a pixel; outside there is none.
    fn set(&mut self, x: usize, y: usize, index: u8) {
        if x < self.width && y < self.height {
            self.pixels[y * self.width + x] = index;
        }
    }

    /// Writes from an upper left corner on.
    fn text(&mut self, x: usize, y: usize, text: &str) {
        let letter = get_raster_width(FontWeight::Regular, RasterHeight::Size16);
        for (k, c) in text.chars().enumerate() {
            let raster = |c| get_raster(c, FontWeight::Regular, RasterHeight::Size16);
            let Some(drawn) = raster(c).or_else(|| raster('?')) else { continue };
            for (dy, row) in drawn.rows().enumerate() {
                for (dx, &strength) in row.iter().enumerate().filter(|(_, s)| **s > 0) {
                    let grey = (255 - usize::from(strength)) * (GREYS - 1) / 255;
                    self.set(x + k * letter + dx, y + dy, INK + grey as u8);
                }
            }
        }
    }

    fn centred(&mut self, x: usize, y: usize, text: &str) {
        let half =
            text.chars().count() * get_raster_width(FontWeight::Regular, RasterHeight::Size16) / 2;
        self.text(x.saturating_sub(half), y, text);
    }

    /// Writes so that it ends at `x`.
    fn before(&mut self, x: usize, y: usize, text: &str) {
        let width =
            text.chars().count() * get_raster_width(FontWeight::Regular, RasterHeight::Size16);
        self.text(x.saturating_sub(width), y, text);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::ops::Range;

    #[test]
    fn a_map_of_any_shape_is_drawn() {
        for counts in [[300, 200], [2, 400], [500, 2], [2, 2]] {
            let heights: Vec<f64> = (0..counts[0] * counts[1]).map(|k| 1e-6 * k as f64).collect();
            let map = Matrix { counts, steps: [0.01; 2], heights: &heights };
            let png = texture_png(&map, ["a dome", "Sa 1 µm"]);
            assert!(png.starts_with(b"\x89PNG") && png.len() < 400_000, "{counts:?}");
            assert_eq!(png, texture_png(&map, ["a dome", "Sa 1 µm"]));
        }
    }

    #[test]
    fn both_axes_and_the_colours_are_named() {
        let heights: Vec<f64> = (0..600).map(|k| 1e-6 * f64::from(k)).collect();
        let map = Matrix { counts: [30, 20], steps: [0.01; 2], heights: &heights };
        let canvas = drawn(&map, ["", ""]);
        let is_written = |x: Range<usize>, y: Range<usize>| {
            y.into_iter().any(|y| {
                let row = &canvas.pixels[y * canvas.width..(y + 1) * canvas.width];
                row[x.clone()].iter().any(|pixel| (INK..GROUND).contains(pixel))
            })
        };
        let (over, foot) = (ROOM[1] - NAME..ROOM[1], canvas.height - ROOM[3]);
        let right = canvas.width - ROOM[2];
        assert!(is_written(BAR[0]..ROOM[0], over.clone()));
        assert!(is_written(right..canvas.width, over));
        assert!(is_written(ROOM[0]..right, foot + 28..canvas.height));
    }
}
