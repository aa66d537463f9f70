//! What a cut asks of the cutter, and the feed that keeps this within limits.
//!
//! Terms. The *section* of a cut is the volume removed per millimetre of travel, mm². The cutter is seen as the disc that
//! takes as much of the layer as it does: radius `R`, depth `H`. A section `A` engages it over the angle
//! `phi = acos(1 - A / (R H))`: 90 degrees for `R H`, 180 for a slot. The mean *chip thickness* over that arc is
//! `h_m = f_z A / (R H phi)`, with `f_z` the feed per tooth, times `H` over the length of the engaged edge where that
//! is rounded. Removing `Q = A V_f` takes the power `P = k_c Q`, `k_c = k_c1.1 h_m^-m_c`, and the mean cutting force is
//! `P / v_c`, with the cutting speed `v_c` at `R`.
//!
//! The larger the section, the slower the feed that keeps rate, power and force. So the limits on how far the cutter may
//! be engaged and how slow it may go are one: the largest section that it may be given.
//!
//! Source: Kienzle, "Die Bestimmung von Kräften und Leistungen an spanenden Werkzeugen und Werkzeugmaschinen", VDI-Z 94
//! (1952); Altintas, "Manufacturing Automation" (2012), ch. 2.

use crate::geometry::math;
use crate::tool::Tool;
use core::f64::consts::{PI, TAU};

/// Passes this close to a link, in cutter radii, share windows with it, over which rates are predicted: their rates have
/// a part of what the link removes, and their engagement does not count.
pub const BESIDE_LINKS: f64 = 0.15;
/// Passes this close to a link, in cutter radii, are slowed for what it removes: their feed per tooth does not count.
pub const SLOWED_BESIDE: f64 = 2.0 * BESIDE_LINKS;
/// Feeds and sections are sought to this fraction of themselves.
const FOUND: f64 = 1e-9;

/// How hard a material is to cut: `k_c = k_c1.1 h^-m_c`.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Material {
    /// Specific cutting force `k_c1.1` at a chip of 1 mm by 1 mm, N/mm².
    pub kc11: f64,
    /// Its exponent `m_c`.
    pub mc: f64,
}

/// The cutter as a disc in its layer, and how fast its teeth come.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Teeth {
    /// Mean radius over the depth, mm.
    pub radius: f64,
    /// Depth of the layer, mm.
    pub depth: f64,
    /// Length of the edge within the layer, mm.
    pub edge: f64,
    /// Teeth per second.
    pub rate: f64,
    /// Cutting speed at the mean radius, mm/s.
    pub speed: f64,
}

/// Limits on the cut.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct LoadLimits {
    /// The cutter.
    pub teeth: Teeth,
    /// On the removal rate, mm³/s; infinite where there is none.
    pub rate: f64,
    /// On the power, mW (N mm/s), with the material; `None` where there is none.
    pub power: Option<(f64, Material)>,
    /// The smallest feed per tooth, mm; 0 where there is none.
    pub least_per_tooth: f64,
    /// The largest angle of engagement, rad; pi where there is none.
    pub most_engaged: f64,
}

impl Teeth {
    /// Those of a tool in a layer of that depth, mm, at that speed, rev/s.
    pub fn of(tool: &Tool, depth: f64, flutes: u32, spindle: f64) -> Self {
        let radius = tool.mean_radius(depth);
        Self {
            radius,
            depth,
            edge: tool.edge_length(depth),
            rate: f64::from(flutes) * spindle,
            speed: TAU * radius * spindle,
        }
    }

    /// Section of a slot, mm²: the largest there is.
    pub fn slot(&self) -> f64 {
        2.0 * self.radius * self.depth
    }

    /// Angle of engagement of a section, rad.
    pub fn engaged(&self, section: f64) -> f64 {
        math::acos_clamped(1.0 - 2.0 * section / self.slot())
    }

    /// The section that engages the cutter over an angle, mm².
    pub fn section(&self, engaged: f64) -> f64 {
        0.5 * self.slot() * (1.0 - math::cos(engaged.clamp(0.0, PI)))
    }

    /// Feed per tooth, mm.
    pub fn per_tooth(&self, feed: f64) -> f64 {
        feed / self.rate
    }

    /// Mean chip thickness of a section at a feed, mm.
    pub fn chip(&self, section: f64, feed: f64) -> f64 {
        let engaged = self.engaged(section);
        if engaged <= 0.0 {
            return 0.0;
        }
        let part = (2.0 * section / self.slot()).min(2.0);
        self.per_tooth(feed) * part / engaged * (self.depth / self.edge).min(1.0)
    }
}

impl Material {
    /// Power of a section at a feed, mW.
    pub fn power(&self, teeth: &Teeth, section: f64, feed: f64) -> f64 {
        let chip = teeth.chip(section, feed);
        if chip > 0.0 { self.kc11 * math::powf(chip, -self.mc) * section * feed } else { 0.0 }
    }

    /// The feed at which a section takes a power, mm/s: `P ~ V_f^(1 - m_c)`.
    fn feed(&self, teeth: &Teeth, section: f64, power: f64) -> f64 {
        let at_one = self.power(teeth, section, 1.0);
        if at_one > 0.0 { math::powf(power / at_one, 1.0 / (1.0 - self.mc)) } else { f64::INFINITY }
    }
}

impl LoadLimits {
    /// The fastest feed at which a section keeps the limits on rate and power, mm/s; infinite where nothing is cut.
    pub fn feed(&self, section: f64) -> f64 {
        if section <= 0.0 {
            return f64::INFINITY;
        }
        let by_power =
            |(power, material): (f64, Material)| material.feed(&self.teeth, section, power);
        (self.rate / section).min(self.power.map_or(f64::INFINITY, by_power))
    }

    /// The largest of rate and power as fractions of their limits.
    pub fn share(&self, section: f64, feed: f64) -> f64 {
        if section <= 0.0 {
            return 0.0;
        }
        let power = self
            .power
            .map_or(0.0, |(most, material)| material.power(&self.teeth, section, feed) / most);
        (section * feed / self.rate).max(power)
    }

    /// The section of which a full feed just keeps rate and power, mm².
    pub fn at_full_feed(&self, feed: f64) -> f64 {
        self.largest(feed)
    }

    /// Whether a slower feed alone cannot keep them.
    pub fn bound_sections(&self) -> bool {
        self.most_engaged < PI || self.least_per_tooth > 0.0
    }

    /// The largest section that may be cut: the engagement is kept, and at the feed that it takes, times `margin`, the
    /// feed per tooth is; infinite where neither is limited.
    pub fn thickest(&self, margin: f64) -> f64 {
        let by_angle = match self.most_engaged < PI {
            true => self.teeth.section(self.most_engaged),
            false => f64::INFINITY,
        };
        let by_chip = match self.least_per_tooth > 0.0 {
            true => self.largest(self.least_per_tooth * self.teeth.rate / margin),
            false => f64::INFINITY,
        };
        by_angle.min(by_chip)
    }

    /// The largest section that keeps rate and power at a feed, mm².
    fn largest(&self, feed: f64) -> f64 {
        let by_rate = self.rate / feed;
        if self.power.is_none() || self.feed(by_rate.min(self.teeth.slot())) >= feed {
            return by_rate;
        }
        // Power grows with the section.
        let (mut low, mut high) = (0.0, by_rate.min(self.teeth.slot()));
        while high - low > FOUND * high {
            let middle = 0.5 * (low + high);
            if self.feed(middle) >= feed { low = middle } else { high = middle }
        }
        low
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn close(a: f64, b: f64) {
        assert!((a - b).abs() <= 1e-9 * b.abs().max(1e-12), "{a} is not {b}");
    }

    /// A flat end of 10 mm, 4 flutes, 6000 rev/min, 2 mm deep, in steel of 2100 N/mm² with m_c = 0.25.
    fn limits() -> (Teeth, Material) {
        let teeth = Teeth::of(&Tool::new(5.0, 0.0).unwrap(), 2.0, 4, 100.0);
        (teeth, Material { kc11: 2100.0, mc: 0.25 })
    }

    /// By hand: f_z = 20 / 400 = 0.05 mm; in a slot h_m = 2 f_z / pi = 0.0318 mm; k_c = 2100 * 0.0318^-0.25 = 4971
    /// N/mm²; Q = 10 * 2 * 20 = 400 mm³/s; P = 1.988 kW; v_c = 3.14 m/s; F = 633 N.
    #[test]
    fn a_straight_slot_is_as_by_hand() {
        let (teeth, material) = limits();
        close(teeth.engaged(20.0), PI);
        close(teeth.chip(20.0, 20.0), 0.1 / PI);
        let power = material.power(&teeth, 20.0, 20.0);
        let kc = 2100.0 * math::powf(0.1 / PI, -0.25);
        close(power, kc * 400.0);
        assert!((1e-6 * power - 1.988).abs() < 1e-3);
        assert!((power / teeth.speed - 633.0).abs() < 1.0);
    }

    /// A side step of 1 mm: h_m = f_z a_e 360 / (pi D phi), phi = acos(1 - 2 a_e / D).
    #[test]
    fn a_side_cut_has_the_chip_of_the_textbook() {
        let (teeth, _) = limits();
        let phi = math::acos(1.0 - 0.2);
        close(teeth.engaged(2.0), phi);
        close(teeth.chip(2.0, 20.0), 0.05 * 360.0 / (PI * 10.0 * phi.to_degrees()));
        close(teeth.section(phi), 2.0);
    }

    #[test]
    fn feeds_keep_rate_and_power_and_no_slower() {
        let (teeth, material) = limits();
        let all = LoadLimits {
            teeth,
            rate: 300.0,
            power: Some((5e5, material)),
            least_per_tooth: 0.01,
            most_engaged: PI,
        };
        for section in [0.5, 3.0, 9.0, 20.0] {
            close(all.share(section, all.feed(section)), 1.0);
        }
        // At the largest section the feed per tooth is the least allowed.
        close(teeth.per_tooth(all.feed(all.thickest(1.0))), 0.01);
        let by_rate = LoadLimits { power: None, ..all };
        close(by_rate.thickest(1.0), 300.0 / 4.0);
        close(by_rate.thickest(0.5), 300.0 / 8.0);
        let quarter = LoadLimits { most_engaged: 0.5 * PI, ..by_rate };
        close(quarter.thickest(1.0), 10.0);
        let none = LoadLimits { least_per_tooth: 0.0, ..by_rate };
        assert_eq!(none.thickest(1.0), f64::INFINITY);
    }
}
