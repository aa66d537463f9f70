//! Colours of removal rates and of moves that are told apart.

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

/// Above the limit: the vermilion of Okabe and Ito, "Color Universal Design" (2008).
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
        let shades: Vec<f64> =
            (0..=100).map(|i| luminance(of_share(f64::from(i) / 100.0))).collect();
        assert!(shades.windows(2).all(|w| w[1] <= w[0] + 1e-3));
    }
}
