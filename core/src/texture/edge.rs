//! The cutting edges of a cutter, in a frame that turns with it.
//!
//! Terms. The *tool frame* has its origin `O_b` on the axis at the height of the corner's centre, `r_c` above the tip
//! (the centre of a ball), and `z_b` up the axis. The *profile* is the curve that the cutter's body is turned from:
//! the flat bottom, the quarter circle of the corner, the straight side; a place on it is named by its arc length `s`
//! from the axis. An edge winds around the body with constant lead: at height `z` it lies `beta = z tan(delta) / R`
//! behind, for a helix angle `delta`. On the flat bottom `z` is constant, so that the edge is radial there.
//!
//! Of a ball, `s = r alpha` with the axial angle `alpha` from the tip, and these are the formulas of the source:
//! `beta = -cos(alpha) tan(delta)` on the ball and `-cot(alpha) tan(delta)` on the cylinder.

use crate::geometry::math::{cos, sin, tan};
use crate::geometry::{DVec2, DVec3};
use crate::tool::Tool;
use std::f64::consts::{FRAC_PI_2, TAU};

/// Rounding of lengths, as a part of them.
const ROUNDING: f64 = 1e-9;

/// A place of the edge of tooth 0 without run-out.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct EdgePlace {
    /// Distance from the axis, mm.
    pub rho: f64,
    /// Height above the corner's centre, mm.
    pub z: f64,
    /// Lag, rad.
    pub beta: f64,
}

/// The edge of one tooth: a curve on the cutter's profile.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Edge {
    bottom: f64,
    corner: f64,
    /// Lag per height, rad/mm.
    lag: f64,
}

impl Edge {
    /// The edge of a cutter of helix angle `helix`, rad, within 90 degrees either way.
    pub fn new(tool: &Tool, helix: f64) -> Self {
        let corner = tool.corner_radius();
        Self { bottom: tool.radius() - corner, corner, lag: tan(helix) / tool.radius() }
    }

    /// Arc length of bottom and corner, mm: where the side begins.
    pub fn side(&self) -> f64 {
        self.bottom + self.corner * FRAC_PI_2
    }

    /// The place at arc length `s` mm along the profile, 0 on the axis.
    pub fn at(&self, s: f64) -> EdgePlace {
        let side = self.side();
        let (rho, z) = if s <= self.bottom {
            (s, -self.corner)
        } else if s < side {
            let alpha = (s - self.bottom) / self.corner;
            (self.bottom + self.corner * sin(alpha), -self.corner * cos(alpha))
        } else {
            (self.bottom + self.corner, s - side)
        };
        EdgePlace { rho, z, beta: z * self.lag }
    }

    /// Arc length along the profile at the axial angle `alpha` of a ball: `z = -r cos(alpha)` to 90 degrees, then
    /// `z = -r cot(alpha)`.
    ///
    /// `alpha`: rad, from 0 and below pi.
    pub fn of_axial_angle(&self, alpha: f64) -> f64 {
        let r = self.bottom + self.corner;
        if alpha <= FRAC_PI_2 { r * alpha } else { r * FRAC_PI_2 - r * cos(alpha) / sin(alpha) }
    }
}

/// How the teeth of a cutter stand to its axis of turning.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct Runout {
    /// Distance of the cutter's axis from that of the spindle, mm.
    pub offset: f64,
    /// Direction of that offset from tooth 0, rad, counted as the teeth are.
    pub angle: f64,
    /// How much farther out each tooth stands than the nominal one, mm; a missing one is 0.
    pub teeth: Vec<f64>,
}

impl Runout {
    /// The largest distance of an edge from where it would be without run-out, mm.
    pub fn largest(&self) -> f64 {
        self.offset.abs() + self.teeth.iter().fold(0.0, |most, t| t.abs().max(most))
    }
}

/// The edges of all teeth, as points on the profile at even steps of arc length.
#[derive(Clone, Debug, PartialEq)]
pub struct Teeth {
    profile: Vec<EdgePlace>,
    /// Per tooth, `x` and `y` of every point in the tool frame.
    across: Vec<Vec<DVec2>>,
    /// Angle of each tooth, rad.
    psi: Vec<f64>,
    step: f64,
    spacing: f64,
    runout: f64,
}

impl Teeth {
    /// `flutes` edges at `psi_j = 2 pi j / flutes`, from the axis up to arc length `end` mm, with points `step` mm
    /// apart.
    ///
    /// Point `k` lies at `s = k step` for any `end`: a shorter edge is the beginning of a longer one. A point of tooth
    /// `j` is `( rho cos(beta + psi_j), rho sin(beta + psi_j), z )`, with `rho` larger by the tooth's own run-out, and
    /// all are shifted by the cutter's.
    pub fn new(edge: &Edge, flutes: u32, runout: &Runout, end: f64, step: f64) -> Self {
        let count = (end / step).ceil() as u32;
        let profile: Vec<_> = (0..=count).map(|k| edge.at(f64::from(k) * step)).collect();
        let psi: Vec<_> = (0..flutes).map(|j| TAU * f64::from(j) / f64::from(flutes)).collect();
        let shift = DVec2::new(cos(runout.angle), sin(runout.angle)) * runout.offset;
        let of_tooth = |j: usize| {
            let out = runout.teeth.get(j).copied().unwrap_or(0.0);
            let at = |p: &EdgePlace| {
                let angle = p.beta + psi[j];
                DVec2::new(cos(angle), sin(angle)) * (p.rho + out) + shift
            };
            profile.iter().map(at).collect()
        };
        let across = (0..psi.len()).map(of_tooth).collect();
        let mut teeth = Self { profile, across, psi, step, spacing: 0.0, runout: runout.largest() };
        teeth.spacing = teeth.widest() * (1.0 + ROUNDING);
        teeth
    }

    fn widest(&self) -> f64 {
        let of = |j: usize| {
            let points = 1..self.profile.len();
            points.map(move |k| self.point(j, k).distance(self.point(j, k - 1)))
        };
        (0..self.psi.len()).flat_map(of).fold(0.0, f64::max)
    }

    /// The points of tooth 0 without run-out, from the axis outward and up.
    pub fn profile(&self) -> &[EdgePlace] {
        &self.profile
    }

    /// Angles `psi_j` of the teeth, rad.
    pub fn psi(&self) -> &[f64] {
        &self.psi
    }

    /// Arc length between neighbouring points, mm.
    pub fn step(&self) -> f64 {
        self.step
    }

    /// The largest distance of neighbouring points of a tooth, mm: the step, and the lag between them.
    pub fn spacing(&self) -> f64 {
        self.spacing
    }

    /// The largest distance of a point from where it would be without run-out, mm.
    pub fn runout(&self) -> f64 {
        self.runout
    }

    /// Point `k` of tooth `j` in the tool frame, mm.
    pub fn point(&self, j: usize, k: usize) -> DVec3 {
        self.across[j][k].extend(self.profile[k].z)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::math::atan2;

    const HELIX: f64 = std::f64::consts::PI / 6.0;

    #[test]
    fn a_ball_has_the_formulas_of_the_source() {
        let r = 5.0;
        let edge = Edge::new(&Tool::new(r, r).unwrap(), HELIX);
        for i in 1..180 {
            let alpha = f64::from(i).to_radians();
            let at = edge.at(edge.of_axial_angle(alpha));
            let (z, rho) = match i <= 90 {
                true => (-r * cos(alpha), r * sin(alpha)),
                false => (-r * cos(alpha) / sin(alpha), r),
            };
            assert!((at.z - z).abs() < 1e-12 * r.max(z.abs()) && (at.rho - rho).abs() < 1e-12 * r);
            assert!((at.beta - z / r * tan(HELIX)).abs() < 1e-12 * (1.0 + z.abs()));
        }
    }

    #[test]
    fn value_and_slope_are_continuous_at_ninety_degrees_and_between_the_parts() {
        let r = 5.0;
        let edge = Edge::new(&Tool::new(r, r).unwrap(), HELIX);
        let h = 1e-6;
        let place = |alpha: f64| {
            let at = edge.at(edge.of_axial_angle(alpha));
            [at.rho, at.z, at.beta]
        };
        let (below, at, above) = (place(FRAC_PI_2 - h), place(FRAC_PI_2), place(FRAC_PI_2 + h));
        for i in 0..3 {
            let (before, after) = ((at[i] - below[i]) / h, (above[i] - at[i]) / h);
            assert!((above[i] - below[i]).abs() < 2.0 * h * r * 1.01);
            // Second derivatives are at most r.
            assert!((before - after).abs() < 2.0 * r * h, "{i} {before} {after}");
        }
        let bull = Edge::new(&Tool::new(5.0, 1.0).unwrap(), HELIX);
        for s in [4.0, bull.side()] {
            let [a, b, c] = [s - h, s, s + h].map(|s| bull.at(s));
            assert!((b.rho - a.rho - (c.rho - b.rho)).abs() < 2.0 * h * h / 1.0);
            assert!((b.z - a.z - (c.z - b.z)).abs() < 2.0 * h * h / 1.0);
        }
        assert_eq!(bull.at(0.0).beta, bull.at(3.0).beta);
        let flat = Edge::new(&Tool::new(5.0, 0.0).unwrap(), HELIX);
        assert_eq!(flat.at(2.0), EdgePlace { rho: 2.0, z: 0.0, beta: 0.0 });
        assert!((flat.at(6.0).z - 1.0).abs() < 1e-15 && flat.at(6.0).rho == 5.0);
    }

    #[test]
    fn teeth_stand_evenly_and_run_out_as_asked() {
        let edge = Edge::new(&Tool::new(5.0, 5.0).unwrap(), HELIX);
        let even = Teeth::new(&edge, 3, &Runout::default(), 7.0, 0.1);
        for j in 0..3 {
            let p = even.point(j, 50);
            let angle = atan2(p.y, p.x) - edge.at(50.0 * even.step()).beta - even.psi()[j];
            assert!((angle - TAU * (angle / TAU).round()).abs() < 1e-12);
        }
        let runout = Runout { offset: 0.01, angle: 0.0, teeth: vec![0.0, 0.02] };
        let off = Teeth::new(&edge, 3, &runout, 7.0, 0.1);
        assert!((off.point(0, 50) - even.point(0, 50) - DVec3::X * 0.01).length() < 1e-15);
        let tooth = off.point(1, 50) - DVec3::X * 0.01;
        assert!((tooth.truncate().length() - even.profile()[50].rho - 0.02).abs() < 1e-12);
        for j in 0..3 {
            assert!((0..=70).all(|k| off.point(j, k).distance(even.point(j, k)) <= off.runout()));
        }
    }
}
