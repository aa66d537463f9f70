//! What a cutter machines beside its contact as it moves on: how wide the strip is that it leaves below the cusps, where
//! the middle of that strip lies, and how far its edges trail behind.
//!
//! An upright cutter touches sloping ground with its corner and a ball touches with itself: their strips lie on both sides of
//! the contact. A flat bottom, leaning, touches with its rim.
//!
//! - *Strip*: as wide as the side step at which the cusp between two passes is exactly `h`.
//! - *Profile*: the cutter's outline seen along the feed. For a ball a circle; for a flat end with
//!   lead `lambda` an ellipse with semi-axes `R` and `R sin(lambda)`; for a bull end that of the flat
//!   bottom, `R - r_c` and `(R - r_c) sin(lambda)`, offset by `r_c`.
//! - *Section*: the surface across the feed, a circle of curvature `k`, positive where convex.
//!
//! - *Setback*: the points of a tilted flat bottom beside the contact lie behind it, where a surface that
//!   bends along the feed has risen or fallen.
//!
//! - *Lag*: the setback at a distance across the feed. The sides of the strip are swept up to a boundary only
//!   when the contact is beyond it by the lag of the strip's edge.
//!
//! Second order, `w = sqrt(8 h / (k_tool + k))` (Kim 2001, eq. of the strip width). Exactly,
//! the cusp stands where the profile has risen to the height `h` over the section; the width is the
//! arc of the section between two such places.

use crate::geometry::math::{atan2, cos, sin};
use crate::tool::Tool;
use core::f64::consts::FRAC_PI_2;

/// Halvings of the profile's parameter: beyond rounding.
const HALVINGS: usize = 52;
/// Curvatures along the feed of a table: its range is halved.
const ALONG: usize = 3;
/// Nodes of a table. Fewer: `1/w²` is interpolated with an error above 1e-6 of it.
const NODES: usize = 1025;
/// Places between the contact and the edge of a strip at which its lag is asked for.
const ACROSS: u32 = 16;
/// Strips are no wider than this part of the diameter, so that passes overlap.
const WIDEST: f64 = 0.9;

/// A cutter as it touches the surface.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Footprint {
    /// What of the cutter touches.
    tool: Tool,
    sin_lead: f64,
    /// How much of a way along the bottom goes backward.
    cos_lead: f64,
    /// The whole cutter, if on slopes its bottom widens the strips of its corner.
    whole: Option<Tool>,
}

impl Footprint {
    /// Of a cutter whose axis leans from the surface's normal toward the feed by `lead` rad; with a lead of 0 that of one
    /// that stands upright, of which the corner touches.
    pub fn new(tool: Tool, lead: f64) -> Self {
        if lead != 0.0 {
            return Self::leaning(tool, sin(lead));
        }
        match Tool::new(tool.corner_radius(), tool.corner_radius()) {
            Ok(corner) => {
                let whole = (tool.bottom_radius() > 0.0).then_some(tool);
                Self { whole, ..Self::leaning(corner, 1.0) }
            }
            Err(_) => Self { tool, sin_lead: 0.0, cos_lead: 0.0, whole: None },
        }
    }

    /// `sin_lead`: sine of the angle between axis and normal in the plane of the feed.
    fn leaning(tool: Tool, sin_lead: f64) -> Self {
        let cos_lead = (1.0 - sin_lead * sin_lead).max(0.0).sqrt();
        Self { tool, sin_lead, cos_lead, whole: None }
    }

    /// That of an upright cutter that moves level along a slope, given by the sine of its angle: the bottom leans across the
    /// feed. `None` where it is the same in all directions.
    pub fn along_slope(&self, sin_slope: f64) -> Option<Self> {
        self.whole.map(|tool| Self::leaning(tool, sin_slope))
    }

    /// Radius of the flat bottom of an upright cutter with rounded corners, mm; `None` for other cutters.
    pub fn bottom(&self) -> Option<f64> {
        self.whole.map(|tool| tool.bottom_radius())
    }

    /// Whether the edges of its strip trail behind the contact.
    pub fn lags(&self) -> bool {
        self.tool.bottom_radius() * self.cos_lead > 0.0
    }

    /// Side step on a plane that leaves cusps of the height `h`, mm, at most the diameter: the chord of a circle, or of
    /// second order where the bottom leans.
    pub fn side_step(&self, h: f64) -> f64 {
        let corner = self.tool.corner_radius();
        match self.lags() {
            true => (8.0 * h / self.k_tool()).sqrt(),
            false => 2.0 * (h * (2.0 * corner - h)).max(0.0).sqrt(),
        }
    }

    /// Effective curvature `k_tool` across the feed, 1/mm.
    pub fn k_tool(&self) -> f64 {
        self.tool.effective_curvature(self.sin_lead)
    }

    /// The widest side step, mm: nine tenths of the diameter.
    pub fn widest(&self) -> f64 {
        2.0 * WIDEST * self.tool.radius()
    }

    /// Width of the strip, mm, that cusps of the height `h` leave on a surface with the curvatures `k` across the feed and
    /// `along` along it, 1/mm; at most [`widest`](Self::widest), which also stands for sections on which the cutter
    /// leaves no such cusp.
    pub fn width(&self, h: f64, k: f64, along: f64) -> f64 {
        2.0 * self.edge(h, k, along, 0.0)
    }

    /// How far to the left of the contact the middle of the strip below cusps of the height `h` lies, mm, on a surface
    /// with the curvatures `k` across the feed, `along` along it, and `twist`, 1/mm, mixed of the feed and its left: behind the
    /// contact, where a flat bottom leaves its edges, the surface stands lower on one side than on the other.
    pub fn middle(&self, h: f64, k: f64, along: f64, twist: f64) -> f64 {
        0.5 * (self.edge(h, k, along, -twist) - self.edge(h, k, along, twist))
    }

    /// Distance of the edge of the strip from the contact, mm, at most half of [`widest`](Self::widest);
    /// `twist`: mixed curvature of the way to that side and the way back, 1/mm.
    fn edge(&self, h: f64, k: f64, along: f64, twist: f64) -> f64 {
        let rises = |t: f64| {
            let (x, z) = self.profile(t);
            let y = self.setback(t);
            let z = z + (0.5 * along * y + twist * x) * y;
            let outward = 1.0 + k * z;
            // Height over the circle of curvature k, without dividing by k.
            let height = (k * (x * x + z * z) + 2.0 * z)
                / (1.0 + (k * k * x * x + outward * outward).sqrt());
            outward <= 0.0 || height >= h
        };
        if !rises(FRAC_PI_2) {
            return 0.5 * self.widest();
        }
        let (mut low, mut high) = (0.0, FRAC_PI_2);
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            if rises(middle) { high = middle } else { low = middle }
        }
        let (x, z) = self.profile(high);
        let half = if k == 0.0 { x } else { atan2(k * x, 1.0 + k * z) / k };
        half.clamp(0.0, 0.5 * self.widest())
    }

    /// How far the bottom's point at parameter `t` lies behind the contact, mm.
    fn setback(&self, t: f64) -> f64 {
        self.tool.bottom_radius() * (1.0 - cos(t)) * self.cos_lead
    }

    /// How far the cutter touches behind the contact at `across` mm beside it, mm; 0 where no edge trails.
    pub fn lag(&self, across: f64) -> f64 {
        if !self.lags() {
            return 0.0;
        }
        if self.tool.corner_radius() == 0.0 {
            let radius = self.tool.radius();
            let ahead = (radius * radius - across * across).max(0.0).sqrt();
            return (radius - ahead) * self.cos_lead;
        }
        let (mut low, mut high) = (0.0, FRAC_PI_2);
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            if self.profile(middle).0 < across { low = middle } else { high = middle }
        }
        self.setback(high)
    }

    /// How far a pass goes beyond a boundary at its start and at its end, mm, so that its strip is swept up
    /// to it: `half` is half the strip's width, `beside` how far ahead the boundary lies at that side of the
    /// strip at which it is the farthest.
    ///
    /// At the end the lag of that side adds up; at the start what lies behind the contact is swept already.
    pub fn overruns(&self, half: f64, beside: f64) -> [f64; 2] {
        let missing = |i: u32| {
            let part = f64::from(i) / f64::from(ACROSS);
            beside * part - self.lag(half * part)
        };
        let start = (0..=ACROSS).map(missing).fold(0.0, f64::max);
        [start, beside + self.lag(half)]
    }

    /// The profile at parameter `t`, 0 at the contact: distance across the feed and height, mm.
    fn profile(&self, t: f64) -> (f64, f64) {
        let corner = self.tool.corner_radius();
        let across = self.tool.bottom_radius();
        let up = across * self.sin_lead;
        let (s, c) = (sin(t), cos(t));
        // Outward normal of the ellipse; a ball's profile is the offset of a point.
        let (nx, nz) = if across > 0.0 { (up * s, -across * c) } else { (s, -c) };
        let length = (nx * nx + nz * nz).sqrt();
        let (nx, nz) = if length > 0.0 { (nx / length, nz / length) } else { (1.0, 0.0) };
        (across * s + corner * nx, up * (1.0 - c) + corner * (1.0 + nz))
    }
}

/// Exact widths for a range of curvatures: `1/w²` by interpolation, linear in the curvature across the
/// feed and by a parabola in that along it.
#[derive(Clone, Debug, PartialEq)]
pub struct StripTable {
    least: f64,
    step: f64,
    weights: [Vec<f64>; ALONG],
}

impl StripTable {
    /// For cusps of the height `h` and curvatures between `least` and `greatest`, 1/mm.
    pub fn new(footprint: &Footprint, h: f64, least: f64, greatest: f64) -> Self {
        let step = (greatest - least) / (NODES - 1) as f64;
        let weight = |i: usize, along: f64| {
            let w = footprint.width(h, least + step * i as f64, along);
            1.0 / (w * w)
        };
        let nodes = if step > 0.0 { NODES } else { 1 };
        let weights = [least, 0.5 * (least + greatest), greatest]
            .map(|along| (0..nodes).map(|i| weight(i, along)).collect());
        Self { least, step, weights }
    }

    /// `1/w²` at curvature `k` across the feed and `along` along it, 1/mm²; that of the end of the range
    /// beyond it.
    pub fn weight(&self, k: f64, along: f64) -> f64 {
        let [low, middle, high] = &self.weights;
        let last = low.len() - 1;
        if last == 0 {
            return low[0];
        }
        let at = ((k - self.least) / self.step).clamp(0.0, last as f64);
        let i = (at as usize).min(last - 1);
        let t = at - i as f64;
        let [low, middle, high] = [low, middle, high].map(|w| w[i] * (1.0 - t) + w[i + 1] * t);
        // Lagrange's parabola at -1, 0, 1.
        let s = (2.0 * (along - self.least) / (self.step * last as f64) - 1.0).clamp(-1.0, 1.0);
        middle + 0.5 * s * (high - low + s * (low + high - 2.0 * middle))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::math::asin;

    fn footprint(radius: f64, corner: f64, lead: f64) -> Footprint {
        Footprint::new(Tool::new(radius, corner).unwrap(), lead)
    }

    /// Kim 2001.
    fn second_order(footprint: &Footprint, h: f64, k: f64) -> f64 {
        (8.0 * h / (footprint.k_tool() + k)).sqrt()
    }

    /// Circle against circle: `w = 4/k asin(k s)`, `s² = h (2R - h) / (4 (1 + k R)(1 + k h))`.
    #[test]
    fn ball_on_a_circle() {
        let (r, h) = (5.0, 0.2_f64);
        for k in [-0.15, -0.05, 1e-9, 0.02, 0.1, 0.5] {
            let s = (h * (2.0 * r - h) / (4.0 * (1.0 + k * r) * (1.0 + k * h))).sqrt();
            let exact = 4.0 / k * asin(k * s);
            let found = footprint(r, r, 0.0).width(h, k, 0.0);
            assert!((found - exact.min(9.0)).abs() < 1e-6, "{k}: {found} is not {exact}");
        }
    }

    #[test]
    fn flat_end_on_a_plane_is_the_ellipse() {
        let (r, lead, h) = (2.5, 5.0f64.to_radians(), 0.05);
        let b = r * sin(lead);
        let exact = 2.0 * r * (2.0 * h / b - h * h / (b * b)).sqrt();
        assert!((footprint(r, 0.0, lead).width(h, 0.0, 0.0) - exact.min(1.8 * r)).abs() < 1e-9);
        let fine = footprint(r, 0.0, lead);
        let exact = 2.0 * r * (2.0 * 0.001 / b - 1e-6 / (b * b)).sqrt();
        assert!((fine.width(0.001, 0.0, 0.0) - exact).abs() < 1e-9);
    }

    /// All profiles come to the second order as the cusps get low.
    #[test]
    fn low_cusps_are_of_second_order() {
        for (corner, lead) in [(5.0, 0.0), (5.0, 0.3), (0.0, 0.2), (1.0, 0.1), (2.0, 0.6)] {
            for k in [-0.01, 0.0, 0.05] {
                let error = |h: f64| {
                    let s = footprint(5.0, corner, lead);
                    (s.width(h, k, 0.0) / second_order(&s, h, k) - 1.0).abs()
                };
                assert!(error(1e-5) < 1e-4, "{corner} {lead} {k}: {}", error(1e-5));
                assert!(error(1e-5) < 0.3 * error(1e-3), "{corner} {lead} {k}");
            }
        }
    }

    #[test]
    fn tables_are_close() {
        let (s, h) = (footprint(5.0, 1.0, 0.1), 0.02);
        let table = StripTable::new(&s, h, -0.015, 0.06);
        for i in 0..200 {
            let k = -0.015 + 0.075 * (f64::from(i) + 0.37) / 200.0;
            let along = 0.045 - k;
            let w = 1.0 / table.weight(k, along).sqrt();
            let exact = s.width(h, k, along);
            assert!((w / exact - 1.0).abs() < 1e-3, "{k}: {w} is not {exact}");
        }
        let even = StripTable::new(&s, h, 0.0, 0.0);
        assert_eq!(even.weight(1.0, 0.0), even.weight(0.0, 0.0));
    }

    /// The bottom's edge is a circle seen at an angle.
    #[test]
    fn lag_is_that_of_the_tilted_bottom() {
        let lead = 5.0f64.to_radians();
        let flat = footprint(2.5, 0.0, lead);
        for across in [0.0, 0.4, 1.7, 2.4] {
            let exact = (2.5 - (2.5f64 * 2.5 - across * across).sqrt()) * cos(lead);
            assert!((flat.lag(across) - exact).abs() < 1e-9, "{across}");
        }
        assert_eq!(footprint(2.5, 2.5, 0.0).overruns(1.0, 0.3), [0.3, 0.3]);
        // Square to the boundary: nothing at the start, the edge's lag at the end.
        assert_eq!(flat.overruns(1.7, 0.0), [0.0, flat.lag(1.7)]);
        // The edge at the angle of the boundary is what touches it first.
        let [start, end] = flat.overruns(1.7, 0.5);
        let tangent: f64 = 0.5 / 1.7 / cos(lead);
        let exact = 2.5 * cos(lead) * ((1.0 + tangent * tangent).sqrt() - 1.0);
        assert!((start - exact).abs() < 1e-3, "{start} {exact}");
        assert_eq!(end, 0.5 + flat.lag(1.7));
    }

    /// On `z = -c x y`, `y` ahead and `x` to the right, the bottom's circle is at the height of the cusps at
    /// both edges of the strip.
    #[test]
    fn twist_moves_the_strip_aside() {
        let (r, lead, h) = (2.5, 5.0f64.to_radians(), 0.05);
        let flat = footprint(r, 0.0, lead);
        for twist in [-0.02, 0.0, 0.02] {
            // Mixed of the feed and its left: the right has the other sign.
            let middle = flat.middle(h, 0.0, 0.0, -twist);
            let half = 0.5 * (flat.edge(h, 0.0, 0.0, twist) + flat.edge(h, 0.0, 0.0, -twist));
            assert_eq!(middle > 0.0, twist < 0.0, "{twist}: {middle}");
            let height = |left: f64| {
                let behind = r - (r * r - left * left).sqrt();
                behind * sin(lead) + twist * left * behind * cos(lead)
            };
            for edge in [middle + half, middle - half] {
                assert!((height(edge) - h).abs() < 1e-9, "{twist}: {edge}");
            }
        }
    }

    #[test]
    fn what_does_not_fit_is_as_wide_as_allowed() {
        assert_eq!(footprint(5.0, 5.0, 0.0).width(0.01, -0.2, 0.0), 9.0);
    }
}
