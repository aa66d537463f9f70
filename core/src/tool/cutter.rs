//! The cutter: a solid of revolution with a corner radius.

use crate::geometry::math::acos_clamped;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use thiserror::Error;

/// What a cutter's dimensions may not be.
#[derive(Copy, Clone, Debug, PartialEq, Error)]
pub enum ToolError {
    /// The diameter is not a positive number.
    #[error("tool: diameter {0} mm; it must be a positive number")]
    Diameter(f64),
    /// The corner radius does not fit in the cutter.
    #[error(
        "tool: corner radius {corner} mm; it must lie between 0 and the cutter radius {radius} mm"
    )]
    CornerRadius {
        /// Corner radius found, mm.
        corner: f64,
        /// Cutter radius, mm.
        radius: f64,
    },
}

/// The three families of end mill.
#[derive(Copy, Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum ToolKind {
    /// Ball end: corner radius equals the radius.
    Ball,
    /// Flat end: sharp corner.
    Flat,
    /// Bull nose: corner radius in between.
    Bull,
}

impl ToolKind {
    /// Its name in job files and programs.
    pub fn name(self) -> &'static str {
        match self {
            Self::Ball => "ball",
            Self::Flat => "flat",
            Self::Bull => "bull",
        }
    }
}

/// A cutter of radius `R` and corner radius `r_c`, mm, tip at the origin, axis up.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Tool {
    radius: f64,
    corner_radius: f64,
}

impl Tool {
    /// A cutter from its radius and corner radius, mm.
    ///
    /// # Errors
    /// [`ToolError`] unless `0 <= corner_radius <= radius` and `0 < radius`.
    pub fn new(radius: f64, corner_radius: f64) -> Result<Self, ToolError> {
        if !(radius.is_finite() && radius > 0.0) {
            return Err(ToolError::Diameter(2.0 * radius));
        }
        if !(0.0..=radius).contains(&corner_radius) {
            return Err(ToolError::CornerRadius { corner: corner_radius, radius });
        }
        Ok(Self { radius, corner_radius })
    }

    /// Cutter radius `R`, mm.
    pub fn radius(&self) -> f64 {
        self.radius
    }

    /// Corner radius `r_c`, mm: 0 for a flat end, `R` for a ball.
    pub fn corner_radius(&self) -> f64 {
        self.corner_radius
    }

    /// Radius of the flat bottom `R - r_c`, mm: 0 for a ball.
    pub fn bottom_radius(&self) -> f64 {
        self.radius - self.corner_radius
    }

    /// The family that the corner radius puts it in.
    pub fn kind(&self) -> ToolKind {
        if self.corner_radius == 0.0 {
            ToolKind::Flat
        } else if self.corner_radius == self.radius {
            ToolKind::Ball
        } else {
            ToolKind::Bull
        }
    }

    /// Mean radius over a depth `H` above the tip, mm: the radius of the disc that sweeps the same
    /// section out of a layer of that depth.
    ///
    /// `1/H * integral of r(z) dz`, `r(z) = R - r_c + sqrt(2 r_c z - z²)` up to `r_c` and `R` above.
    /// Exact for slots and steady passes of a cutter that stands along the normal.
    pub fn mean_radius(&self, depth: f64) -> f64 {
        let (r, b) = (self.corner_radius, self.bottom_radius());
        let round = depth.min(r);
        if depth <= 0.0 || round == 0.0 {
            return if depth > 0.0 { self.radius } else { b };
        }
        // Half the segment of height `round` of the corner's circle.
        let rest = r - round;
        let segment = 0.5 * (r * r * acos_clamped(rest / r) - rest * (r * r - rest * rest).sqrt());
        (b * round + segment + self.radius * (depth - round)) / depth
    }

    /// Length of the profile from the tip up to a depth, without the flat bottom, mm: how much of the cutting edge is in a
    /// layer of that depth, the helix apart.
    pub fn edge_length(&self, depth: f64) -> f64 {
        let r = self.corner_radius;
        let round = if r > 0.0 { r * acos_clamped(1.0 - depth.min(r) / r) } else { 0.0 };
        round + (depth - r).max(0.0)
    }

    /// Effective curvature across the feed for a lead whose sine is `sin_lead`, 1/mm.
    ///
    /// `1 / (r_c + (R - r_c) / sin lead)`; a flat end at lead 0 gives 0.
    ///
    /// # Source
    /// `k_tool` of the strip width; Kim 2001 for the bull form.
    pub fn effective_curvature(&self, sin_lead: f64) -> f64 {
        let flat = self.bottom_radius();
        if flat == 0.0 {
            return 1.0 / self.radius;
        }
        sin_lead / (self.corner_radius * sin_lead + flat)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mean_radius_is_the_mean_of_the_profile() {
        for (radius, corner) in [(5.0, 5.0), (5.0, 0.0), (6.0, 2.0)] {
            let tool = Tool::new(radius, corner).unwrap();
            for depth in [0.3, 1.5, 4.0, 9.0] {
                let n = 200_000;
                let profile = |i: u32| {
                    let z = (f64::from(i) + 0.5) * depth / f64::from(n);
                    let rest = (corner - z).max(0.0);
                    radius - corner + (corner * corner - rest * rest).sqrt()
                };
                let mean = (0..n).map(profile).sum::<f64>() / f64::from(n);
                assert!((tool.mean_radius(depth) - mean).abs() < 1e-5);
            }
        }
        assert_eq!(Tool::new(5.0, 0.0).unwrap().mean_radius(2.0), 5.0);
        assert_eq!(Tool::new(5.0, 2.0).unwrap().mean_radius(0.0), 3.0);
    }

    #[test]
    fn the_edge_is_a_quarter_circle_and_what_is_above_it() {
        let quarter = core::f64::consts::FRAC_PI_2;
        let bull = Tool::new(5.0, 2.0).unwrap();
        assert!((bull.edge_length(2.0) - 2.0 * quarter).abs() < 1e-12);
        assert!((bull.edge_length(3.5) - 2.0 * quarter - 1.5).abs() < 1e-12);
        assert_eq!(Tool::new(5.0, 0.0).unwrap().edge_length(1.5), 1.5);
    }
}
