//! A shaded picture of a surface with its depths (z-buffer).

use super::colour::Rgb;
use evencut_core::geometry::{DVec2, DVec3};

/// Shades of the surface; more grow the picture without being distinguished.
pub const SHADES: usize = 80;
/// Colours of the outer side, dark and light.
const OUTER: (Rgb, Rgb) = (Rgb([0xa9, 0xb0, 0xb8]), Rgb([0xf8, 0xf8, 0xf5]));
/// Colours of the inner side.
const INNER: (Rgb, Rgb) = (Rgb([0xb0, 0x9e, 0x8c]), Rgb([0xdd, 0xcf, 0xc0]));

/// What is seen of a facet.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum Side {
    /// The outer side of what is machined.
    Outer,
    /// An inner side.
    Inner,
    /// The outer side of what is not machined.
    Guarded,
}

/// Pixels with shade and depth.
pub struct Raster {
    pub width: usize,
    pub height: usize,
    /// 1 + shade + [`SHADES`] times the side of each pixel, 0 where nothing is.
    pub shade: Vec<u8>,
    /// Nearness to the viewer of each pixel, mm; minus infinity where nothing is.
    pub nearness: Vec<f64>,
}

/// A projected corner: place in pixels, nearness in mm, brightness 0 to 1 of the outer side.
#[derive(Copy, Clone)]
pub struct Corner {
    pub place: DVec2,
    pub nearness: f64,
    pub brightness: f64,
}

/// The palette that [`Raster::shade`] refers to where all is machined.
pub fn palette() -> Vec<Rgb> {
    let ramp = |(dark, light): (Rgb, Rgb)| {
        (0..SHADES).map(move |i| dark.mix(light, i as f64 / (SHADES - 1) as f64))
    };
    std::iter::once(Rgb([255; 3])).chain(ramp(OUTER)).chain(ramp(INNER)).collect()
}

/// Brightness of a unit normal under a light over the viewer's left shoulder.
///
/// `toward_viewer`, `right`, `up`: unit axes of the view.
pub fn brightness(normal: DVec3, right: DVec3, up: DVec3, toward_viewer: DVec3) -> f64 {
    let light = (toward_viewer - 0.7 * right + 0.5 * up).normalize();
    let lit = normal.dot(light).max(0.0);
    // Squaring spreads the tones of surfaces that are nearly flat.
    lit * lit
}

/// Stretches the brightness of all corners over the shades, so that gentle surfaces show their
/// shape too; what varies less than a fifth stays pale, or facets would show.
pub fn spread(corners: &mut [Corner]) {
    let low = corners.iter().map(|c| c.brightness).fold(f64::INFINITY, f64::min);
    let high = corners.iter().map(|c| c.brightness).fold(f64::NEG_INFINITY, f64::max);
    let range = (high - low).max(0.2);
    for corner in corners {
        corner.brightness = 1.0 - (high - corner.brightness) / range;
    }
}

impl Raster {
    /// An empty picture.
    pub fn new(width: usize, height: usize) -> Self {
        let pixels = width * height;
        Self { width, height, shade: vec![0; pixels], nearness: vec![f64::NEG_INFINITY; pixels] }
    }

    /// Fills a triangle; one seen from behind shows its inner side.
    pub fn fill(&mut self, corners: [Corner; 3], side: Side) {
        let [a, b, c] = corners.map(|corner| corner.place);
        let area = evencut_core::geometry::cross2(a, b, c);
        if area == 0.0 || !area.is_finite() {
            return;
        }
        // The y axis points down, so the outer side runs clockwise.
        let side = if area > 0.0 { Side::Inner } else { side };
        let (low, high) = (a.min(b).min(c), a.max(b).max(c));
        let columns = pixel_range(low.x, high.x, self.width);
        for y in pixel_range(low.y, high.y, self.height) {
            for x in columns.clone() {
                let p = DVec2::new(x as f64 + 0.5, y as f64 + 0.5);
                let weights = [(b, c), (c, a), (a, b)]
                    .map(|(from, to)| evencut_core::geometry::cross2(from, to, p) / area);
                if weights.iter().all(|&w| w >= 0.0) {
                    self.put(y * self.width + x, &corners, weights, side);
                }
            }
        }
    }

    fn put(&mut self, pixel: usize, corners: &[Corner; 3], weights: [f64; 3], side: Side) {
        let mean = |value: fn(&Corner) -> f64| -> f64 {
            (0..3).map(|i| weights[i] * value(&corners[i])).sum()
        };
        let nearness = mean(|c| c.nearness);
        if nearness <= self.nearness[pixel] {
            return;
        }
        let brightness = if side == Side::Inner { 0.5 } else { mean(|c| c.brightness) };
        let step = (brightness.clamp(0.0, 1.0) * (SHADES - 1) as f64).round() as u8;
        self.nearness[pixel] = nearness;
        self.shade[pixel] = 1 + step + side as u8 * SHADES as u8;
    }

    /// Side and brightness, 0 to 1, of what is seen in a pixel.
    pub fn look(&self, pixel: usize) -> Option<(Side, f64)> {
        let shade = usize::from(self.shade[pixel]).checked_sub(1)?;
        let side = [Side::Outer, Side::Inner, Side::Guarded][(shade / SHADES).min(2)];
        Some((side, (shade % SHADES) as f64 / (SHADES - 1) as f64))
    }

    /// The pixel at a place.
    pub fn index_at(&self, place: DVec2) -> Option<usize> {
        let (x, y) = (place.x.floor(), place.y.floor());
        let inside = x >= 0.0 && y >= 0.0 && x < self.width as f64 && y < self.height as f64;
        inside.then(|| y as usize * self.width + x as usize)
    }

    /// Nearness at a place; `None` where nothing is.
    pub fn nearness_at(&self, place: DVec2) -> Option<f64> {
        let nearness = self.nearness[self.index_at(place)?];
        nearness.is_finite().then_some(nearness)
    }
}

/// Pixels whose centres may lie between two coordinates.
fn pixel_range(low: f64, high: f64, count: usize) -> std::ops::Range<usize> {
    let clip = |x: f64| x.clamp(0.0, count as f64) as usize;
    clip((low - 0.5).ceil())..clip((high + 0.5).floor())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn triangle(nearness: f64, brightness: f64) -> [Corner; 3] {
        [(0.0, 0.0), (0.0, 8.0), (8.0, 0.0)].map(|p| Corner {
            place: DVec2::from(p),
            nearness,
            brightness,
        })
    }

    #[test]
    fn nearer_hides_farther_in_any_order() {
        let draw = |order: [f64; 2]| {
            let mut raster = Raster::new(8, 8);
            for n in order {
                raster.fill(triangle(n, n), Side::Outer);
            }
            raster.shade
        };
        assert_eq!(draw([0.0, 1.0]), draw([1.0, 0.0]));
        assert_eq!(draw([0.0, 1.0])[0], SHADES as u8);
    }

    #[test]
    fn outside_is_empty() {
        let mut raster = Raster::new(8, 8);
        raster.fill(triangle(2.0, 1.0), Side::Outer);
        assert_eq!(raster.nearness_at(DVec2::new(7.5, 7.5)), None);
        assert_eq!(raster.nearness_at(DVec2::new(1.5, 1.5)), Some(2.0));
        assert_eq!(raster.nearness_at(DVec2::new(-1.0, 1.0)), None);
    }

    #[test]
    fn sides_are_told_apart() {
        let [a, b, c] = triangle(1.0, 1.0);
        let seen = |corners, side| {
            let mut raster = Raster::new(8, 8);
            raster.fill(corners, side);
            (raster.look(0), raster.look(63))
        };
        assert_eq!(seen([a, b, c], Side::Guarded), (Some((Side::Guarded, 1.0)), None));
        assert_eq!(seen([a, c, b], Side::Guarded).0.map(|l| l.0), Some(Side::Inner));
    }

    #[test]
    fn shades_fit_a_byte() {
        assert!(palette().len() <= 256 && 3 * SHADES < 256);
    }
}
