//! Colours of removal rates and of moves of different kinds.

/// An sRGB colour.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub struct Rgb(pub [u8; 3]);

impl Rgb {
    /// As `#rrggbb`.
    pub fn hex(self) -> String {
        let [r, g, b] = self.0;
        format!("#{r:02x}{g:02x}{b:02x}")
    }

    /// The colour a share `t` of the way to `other`, rounded.
    pub fn mix(self, other: Rgb, t: f64) -> Rgb {
        let blend = |i: usize| {
            let (a, b) = (f64::from(self.0[i]), f64::from(other.0[i]));
            (a + (b - a) * t).round() as u8
        };
        Rgb([blend(0), blend(1), blend(2)])
    }
}

/// A heat scale at 0, 1/3, 2/3, 1: pale to amber, so that blues and reds are left for faults.
const HEIGHTS: [Rgb; 4] = [
    Rgb([0xf4, 0xf3, 0xec]),
    Rgb([0xf7, 0xe6, 0xa2]),
    Rgb([0xf0, 0xc0, 0x55]),
    Rgb([0xd9, 0x92, 0x2b]),
];

/// Viridis at 0, 1/8, ... 1.
///
/// # Source
/// van der Walt and Smith, "mpl colormaps" (2015), released under CC0: perceptually even and
/// readable with any colour-vision deficiency.
const VIRIDIS: [Rgb; 9] = [
    Rgb([0x44, 0x01, 0x54]),
    Rgb([0x47, 0x2d, 0x7b]),
    Rgb([0x3b, 0x52, 0x8b]),
    Rgb([0x2c, 0x72, 0x8e]),
    Rgb([0x21, 0x91, 0x8c]),
    Rgb([0x28, 0xae, 0x80]),
    Rgb([0x5e, 0xc9, 0x62]),
    Rgb([0xad, 0xdc, 0x30]),
    Rgb([0xfd, 0xe7, 0x25]),
];

/// The light end of viridis vanishes on a light ground: the scale stops short of it.
const LIGHTEST: f64 = 0.9;

/// Colour of a removal rate as a share of the limit, 0 to 1: light for little, dark at the limit.
pub fn of_share(share: f64) -> Rgb {
    let place = 8.0 * LIGHTEST * (1.0 - share.clamp(0.0, 1.0));
    let below = (place.floor() as usize).min(7);
    VIRIDIS[below].mix(VIRIDIS[below + 1], place - below as f64)
}

/// Colour of a height as a share of the limit, 0 to 1: paler for less.
pub fn of_height(share: f64) -> Rgb {
    let place = 3.0 * share.clamp(0.0, 1.0);
    let below = (place.floor() as usize).min(2);
    HEIGHTS[below].mix(HEIGHTS[below + 1], place - below as f64)
}

/// Heights above the limit: much darker than the end of their scale, for eyes that see no red.
pub const WARNING: Rgb = Rgb([0xb8, 0x0f, 0x1e]);
/// Gouges by depth.
pub const GOUGES: [Rgb; 3] =
    [Rgb([0x8c, 0x7c, 0xe6]), Rgb([0x5a, 0x3c, 0xc8]), Rgb([0x2c, 0x0a, 0x80])];
/// Where nothing was done.
pub const UNTOUCHED: Rgb = Rgb([0x3a, 0x3f, 0x46]);
/// The stripes of its hatching.
pub const UNTOUCHED_STRIPE: Rgb = Rgb([0x9a, 0xa1, 0xaa]);
/// What is judged apart.
pub const APART: Rgb = Rgb([0x86, 0xb3, 0xad]);
/// What is not machined.
pub const PLAIN: Rgb = Rgb([0xd3, 0xd7, 0xdc]);
/// Inner sides.
pub const INNER: Rgb = Rgb([0xdd, 0xcf, 0xc0]);
/// Removal rates above the limit: the vermilion of Okabe and Ito, "Color Universal Design" (2008).
pub const OVER_LIMIT: Rgb = Rgb([0xd5, 0x5e, 0x00]);
/// Returns of trochoids, which cut nothing.
pub const RETURN: Rgb = Rgb([0x98, 0x9e, 0xa6]);
/// Links at feed.
pub const LINK: Rgb = Rgb([0x5a, 0x60, 0x68]);
/// Rapids: the sky blue of the same set.
pub const RAPID: Rgb = Rgb([0x56, 0xb4, 0xe9]);
/// Text and axes.
pub const INK: Rgb = Rgb([0x22, 0x26, 0x2b]);
/// Secondary text, grid.
pub const FAINT: Rgb = Rgb([0xd9, 0xdc, 0xe0]);
/// The material in flat pictures.
pub const MATERIAL: Rgb = Rgb([0xf1, 0xf2, 0xf0]);
/// Background.
pub const GROUND: Rgb = Rgb([0xff, 0xff, 0xff]);

#[cfg(test)]
mod tests {
    use super::*;

    /// Relative luminance of the sRGB standard, with its exponent rounded to 2.
    fn luminance(c: Rgb) -> f64 {
        let part = |i: usize| (f64::from(c.0[i]) / 255.0).powi(2);
        0.2126 * part(0) + 0.7152 * part(1) + 0.0722 * part(2)
    }

    #[test]
    fn anchors_are_met() {
        assert_eq!(of_share(1.0), VIRIDIS[0]);
        assert_eq!(of_share(1.0 - 0.5 / LIGHTEST), VIRIDIS[4]);
    }

    #[test]
    fn more_is_darker() {
        for scale in [of_share, of_height] {
            let shades: Vec<f64> =
                (0..=100).map(|i| luminance(scale(f64::from(i) / 100.0))).collect();
            assert!(shades.windows(2).all(|w| w[1] <= w[0] + 1e-3));
        }
    }

    #[test]
    fn faults_differ_from_the_scale_in_lightness() {
        let end = luminance(of_height(1.0));
        for fault in [WARNING, GOUGES[1], GOUGES[2], UNTOUCHED] {
            assert!(luminance(fault) < 0.4 * end);
        }
        assert!(luminance(GOUGES[0]) < 0.4 * luminance(of_height(0.0)));
    }
}
