//! The cusp that two neighbouring passes leave.
//!
//! Seen along the feed, the moving cutter is a convex shape that touches the surface at the contact: everything below
//! each of its supporting lines stays. With the unit direction
//! `d = sin(psi) e - cos(psi) n` (`n` normal, `e` across the feed, `m` from the contact to the
//! bottom's middle) the shape reaches
//!
//! `S(psi) = b (d.m) + b sqrt(1 - (d.a)^2) + r_c (1 - cos psi)`
//!
//! beyond the contact, `b = R - r_c`, for all `d` below the axis, `d.a <= 0`. At a distance `y` across the feed its
//! lower side is `P(y) = max over psi of y tan(psi) - S(psi) / cos(psi)`, which is concave in `tan(psi)`. A surface
//! that falls away by `k y^2 / 2` adds that. Two passes a side step `D` apart leave the largest value of
//! `min(P(y), P(y - D))`: on a plane `R - sqrt(R^2 - D^2/4)` for a ball, and `D sin(t) cos(t)` for a flat end that
//! leans by `t` across the feed.

use crate::cutter_location::ToolAxis;
use crate::geometry::DVec3;
use crate::geometry::math::{acos_clamped, atan2, cos, sin};
use crate::surface::{CurvatureField, Surface};
use crate::tool::Tool;
use core::f64::consts::{FRAC_PI_2, PI};

/// Steps of the searches; each roughly halves the uncertainty.
const STEPS: usize = 32;
/// Fraction of an interval that a golden-section step keeps.
const GOLDEN: f64 = 0.618_033_988_749_894_8;
/// Directions of the slope against the feed that are tried.
const HEADINGS: usize = 5;
/// Width of the classes of slopes, rad.
const CLASS: f64 = PI / 90.0;
/// Steepest supporting line, rad from the surface.
const STEEPEST: f64 = FRAC_PI_2 - 1e-3;

/// Inclination of the tool axis to the surface normal.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Lean {
    /// Angle from the normal, rad.
    pub angle: f64,
    /// Direction in which it leans: angle from the feed about the normal, rad.
    pub heading: f64,
}

/// The moving cutter seen along the feed.
struct Section {
    corner: f64,
    bottom: f64,
    /// Axis and direction to the bottom's middle, along feed, across, normal.
    axis: DVec3,
    middle: DVec3,
    curvature: f64,
}

impl Section {
    fn new(tool: &Tool, lean: Lean, curvature: f64) -> Self {
        let (s, c) = (sin(lean.angle), cos(lean.angle));
        let axis = DVec3::new(s * cos(lean.heading), s * sin(lean.heading), c);
        // Upright, the middle of the bottom is the contact.
        let middle = (DVec3::Z - axis * c).normalize_or_zero();
        let corner = tool.corner_radius();
        Self { corner, bottom: tool.radius() - corner, axis, middle, curvature }
    }

    /// Height of the lower side over the surface at a distance across the feed.
    fn height(&self, y: f64) -> f64 {
        let line = |psi: f64| {
            let (s, c) = (sin(psi), cos(psi));
            let d = DVec3::new(0.0, s, -c);
            let along = d.dot(self.axis);
            let reach = self.bottom * (d.dot(self.middle) + (1.0 - along * along).max(0.0).sqrt())
                + self.corner * (1.0 - c);
            (y * s - reach) / c
        };
        // d.a = 0 is the direction across the cylinder.
        let wall = |side: f64| {
            let across = side * self.axis.y;
            if across > 0.0 { atan2(self.axis.z, across).min(STEEPEST) } else { STEEPEST }
        };
        let highest = largest(line, -wall(-1.0), wall(1.0));
        (highest + 0.5 * self.curvature * y * y).max(0.0)
    }
}

/// Largest value of a function with one peak, by golden section.
fn largest(f: impl Fn(f64) -> f64, mut low: f64, mut high: f64) -> f64 {
    let (mut a, mut b) = (high - GOLDEN * (high - low), low + GOLDEN * (high - low));
    let (mut fa, mut fb) = (f(a), f(b));
    for _ in 0..STEPS {
        if fa < fb {
            (low, a, fa) = (a, b, fb);
            b = low + GOLDEN * (high - low);
            fb = f(b);
        } else {
            (high, b, fb) = (b, a, fa);
            a = high - GOLDEN * (high - low);
            fa = f(a);
        }
    }
    fa.max(fb)
}

/// Height of the cusp, mm, between two passes `side_step` mm apart, on a surface of normal
/// `curvature` (1/mm, positive where convex) across the feed.
pub fn cusp(tool: &Tool, lean: Lean, curvature: f64, side_step: f64) -> f64 {
    let section = Section::new(tool, lean, curvature);
    let (mut low, mut high) = (0.0, side_step);
    for _ in 0..STEPS {
        let y = 0.5 * (low + high);
        if section.height(y) < section.height(y - side_step) { low = y } else { high = y }
    }
    section.height(low).max(section.height(high - side_step))
}

/// The highest cusp, mm, that passes `side_step` mm apart can leave anywhere on a surface, whatever their direction.
///
/// Vertices of about the same slope against a fixed axis form one class, represented by its most convex vertex.
pub fn worst_cusp(
    tool: &Tool,
    axis: ToolAxis,
    surface: &Surface,
    curvature: &CurvatureField,
    side_step: f64,
) -> f64 {
    let classes = (FRAC_PI_2 / CLASS) as usize;
    let mut most_convex = vec![None::<f64>; classes];
    for (normal, shape) in surface.vertex_normals().iter().zip(curvature.operators()) {
        let angle = match axis {
            ToolAxis::Fixed(axis) => acos_clamped(normal.dot(axis)),
            ToolAxis::Lead(lead) => lead,
        };
        let class = ((angle / CLASS) as usize).min(classes - 1);
        let (_, k, _) = shape.principal();
        most_convex[class] = Some(most_convex[class].map_or(k, |other| other.max(k)));
    }
    let headings = match axis {
        ToolAxis::Fixed(_) if tool.bottom_radius() > 0.0 => HEADINGS,
        _ => 1,
    };
    let mut worst = 0.0f64;
    for (class, k) in most_convex.iter().enumerate() {
        let Some(k) = *k else { continue };
        let angle = match axis {
            ToolAxis::Fixed(_) => (class as f64 + 0.5) * CLASS,
            ToolAxis::Lead(lead) => lead,
        };
        for i in 0..headings {
            let heading = FRAC_PI_2 * i as f64 / (HEADINGS - 1) as f64;
            worst = worst.max(cusp(tool, Lean { angle, heading }, k, side_step));
        }
    }
    worst
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tool(corner: f64) -> Tool {
        Tool::new(5.0, corner).unwrap()
    }

    const UPRIGHT: Lean = Lean { angle: 0.0, heading: 0.0 };

    #[test]
    fn a_ball_leaves_the_circle_however_it_leans() {
        for d in [0.3, 1.0, 3.0] {
            let exact = 5.0 - (25.0f64 - 0.25 * d * d).sqrt();
            for lean in [UPRIGHT, Lean { angle: 0.4, heading: 1.0 }] {
                assert!((cusp(&tool(5.0), lean, 0.0, d) / exact - 1.0).abs() < 1e-4);
            }
            let convex = cusp(&tool(5.0), UPRIGHT, 0.1, d);
            assert!((convex - exact - 0.1 * d * d / 8.0).abs() < 1e-6);
        }
    }

    #[test]
    fn a_flat_end_leaves_nothing_upright_and_steps_on_a_slope() {
        assert!(cusp(&tool(0.0), UPRIGHT, 0.0, 2.0) < 1e-9);
        for angle in [0.1, 0.3, 0.7, 1.2] {
            let lean = Lean { angle, heading: FRAC_PI_2 };
            let step = cusp(&tool(0.0), lean, 0.0, 1.0);
            assert!((step - sin(angle) * cos(angle)).abs() < 2e-3, "{step}");
        }
    }

    #[test]
    fn a_lead_leaves_the_ellipse() {
        // Seen along the feed the edge is an ellipse with half axes R and R sin(lead).
        let (lead, d) = (0.2, 1.5);
        let exact = 5.0 * sin(lead) * (1.0 - (1.0f64 - 0.25 * d * d / 25.0).sqrt());
        let found = cusp(&tool(0.0), Lean { angle: lead, heading: 0.0 }, 0.0, d);
        assert!((found / exact - 1.0).abs() < 1e-4, "{found} is not {exact}");
        // A corner makes it the strip width's effective curvature.
        let bull = cusp(&tool(1.0), Lean { angle: lead, heading: 0.0 }, 0.0, 0.4);
        let k = tool(1.0).effective_curvature(sin(lead));
        assert!((bull / (k * 0.16 / 8.0) - 1.0).abs() < 0.01, "{bull}");
    }
}
