//! Dropping a cutter on one triangle, in the frame of the cutter's axis.
//!
//! Terms. The *axis frame* has the tool tip at the origin and the tool axis as +Z. The *profile*
//! `g(rho)` is the height of the cutter's lower side above the tip at distance `rho` from the axis.
//! The *need* of a point is `z - g(rho)`: how far the tip must rise along the axis for the point
//! to lie on the cutter and not inside it; a point with `rho >= R` needs nothing.
//!
//! `g` is convex and increases with `rho`, so need is a concave function of position. Its largest value over a
//! triangle is therefore found in steps: (1) the point where the cutter is tangent to the plane; if it lies in the
//! triangle, done; (2) otherwise the largest need lies on one of the edges beyond which that point lies. The
//! concavity also gives a bound that costs one square root: need lies below each of its tangent planes.

use crate::geometry::{DVec2, DVec3};
use crate::tool::Tool;

/// How much slimmer than the cutter its checked shape is, mm.
///
/// A wall that the cutter's side touches lies at `rho = R` up to rounding. With 0, rounding would
/// lift the cutter to the top of the wall; with 1e-3 the penetration would show in tolerances.
const SIDE_SLACK: f64 = 1e-6;

/// A facet whose normal has less than this cosine to the axis is a wall: its edges decide.
///
/// Too small, and the tangent point loses its digits (error 1e-16 R / cosine); too large, and the facet's own contact
/// is missed (error `r_c` times cosine / 2). At 1e-8 both are below 1e-7 mm.
const WALL_COSINE: f64 = 1e-8;

/// Shape of the cutter's lower side.
#[derive(Copy, Clone, Debug)]
pub(super) struct Profile {
    /// Radius of the checked cylinder.
    pub radius: f64,
    /// Corner radius.
    pub corner: f64,
    /// Radius of the flat bottom: `radius - corner`.
    pub bottom: f64,
}

/// What need is at a point and how it changes around it:
/// `need(p) <= value + (p - q).axis + pull (p - q).e`,
/// with `e` the vector from the axis to the point `q`.
#[derive(Copy, Clone, Debug)]
pub(super) struct Tangent {
    /// Need at the point, or a bound of it.
    pub value: f64,
    /// Gradient across the axis over the distance from the axis; zero or negative, 1/mm.
    pub pull: f64,
}

impl Profile {
    pub fn new(tool: &Tool) -> Self {
        let slack = SIDE_SLACK.min(1e-3 * tool.radius());
        let radius = tool.radius() - slack;
        let corner = tool.corner_radius().min(radius);
        Self { radius, corner, bottom: radius - corner }
    }

    /// `g(rho)` for `0 <= rho <= radius`.
    pub fn height(&self, rho: f64) -> f64 {
        let w = (rho - self.bottom).max(0.0);
        self.corner - (self.corner * self.corner - w * w).max(0.0).sqrt()
    }

    /// Tangent of the need function at height `z` and squared distance `rho_squared` from the axis.
    ///
    /// At `rho = R` the profile is vertical and its tangent says nothing about heights, so the
    /// tangent is taken at most 0.98 of the corner out (slope 5): steeper bounds walls better and
    /// slopes worse.
    pub fn tangent(&self, z: f64, rho_squared: f64) -> Tangent {
        let furthest = self.bottom + 0.98 * self.corner;
        if rho_squared <= self.bottom * self.bottom || self.corner == 0.0 {
            return Tangent { value: z, pull: 0.0 };
        }
        if self.bottom == 0.0 && rho_squared <= furthest * furthest {
            let root = (self.corner * self.corner - rho_squared).sqrt();
            let value = z - (self.corner - root);
            return Tangent { value, pull: -1.0 / root };
        }
        let rho = rho_squared.sqrt();
        let at = rho.min(furthest);
        let w = at - self.bottom;
        let root = (self.corner * self.corner - w * w).sqrt();
        let slope = w / root;
        let value = z - (self.corner - root) - slope * (rho - at);
        Tangent { value, pull: -slope / rho }
    }

    /// Largest need over the triangle, or a value not above `floor` where that is not exceeded.
    pub fn triangle(&self, t: [DVec3; 3], floor: f64) -> f64 {
        if self.bound(t) <= floor {
            return floor;
        }
        let normal = (t[1] - t[0]).cross(t[2] - t[0]);
        let length = normal.length();
        if length == 0.0 || normal.z.abs() < WALL_COSINE * length {
            return (0..3).fold(floor, |best, i| best.max(self.edge(t[i], t[(i + 1) % 3])));
        }
        let side = normal.z.signum();
        let n = normal * (side / length);
        let slope = n.truncate().length();
        let tangent_point = if slope > 0.0 {
            n.truncate() * -(self.corner + self.bottom / slope)
        } else {
            DVec2::ZERO
        };
        let mut best = floor;
        let mut inside = true;
        let search = self.bottom > 0.0 && self.corner > 0.0;
        for i in 0..3 {
            let (a, b) = (t[i], t[(i + 1) % 3]);
            let beyond = (b - a).truncate().perp_dot(tangent_point - a.truncate()) * side < 0.0;
            if beyond {
                inside = false;
                if !search || self.edge_bound(a, b) > best {
                    best = best.max(self.edge(a, b));
                }
            }
        }
        if inside {
            let z = t[0].z - n.truncate().dot(tangent_point - t[0].truncate()) / n.z;
            best = best.max(z - self.corner * (1.0 - n.z));
        }
        best
    }

    /// Upper bound of the need over the triangle, from the tangent at its centroid.
    fn bound(&self, t: [DVec3; 3]) -> f64 {
        let q = (t[0] + t[1] + t[2]) / 3.0;
        let lateral = q.truncate();
        let tangent = self.tangent(q.z, lateral.length_squared());
        let gradient = (lateral * tangent.pull).extend(1.0);
        let rise = t.map(|v| gradient.dot(v - q));
        tangent.value + rise[0].max(rise[1]).max(rise[2])
    }

    /// Upper bound of the need over the segment, from the tangent at its middle.
    fn edge_bound(&self, a: DVec3, b: DVec3) -> f64 {
        let q = 0.5 * (a + b);
        let tangent = self.tangent(q.z, q.truncate().length_squared());
        let gradient = (q.truncate() * tangent.pull).extend(1.0);
        tangent.value + gradient.dot(b - q).abs()
    }

    /// Largest need over the segment; minus infinity where no part of it is under the cutter.
    pub fn edge(&self, a: DVec3, b: DVec3) -> f64 {
        let e = b - a;
        let run = e.truncate().length();
        if run < 1e-12 {
            let top = if a.z > b.z { a } else { b };
            return self.vertex(top);
        }
        let along = e.truncate() / run;
        let foot = along.perp_dot(a.truncate());
        let half_squared = self.radius * self.radius - foot * foot;
        if half_squared <= 0.0 {
            return f64::NEG_INFINITY;
        }
        let half = half_squared.sqrt();
        let start = along.dot(a.truncate());
        let (low, high) = (start.max(-half), (start + run).min(half));
        if low > high {
            return f64::NEG_INFINITY;
        }
        let steepness = e.z.abs() / run;
        let best = if self.bottom == 0.0 {
            half * e.z.abs() / e.length()
        } else if self.corner == 0.0 || steepness == 0.0 {
            if steepness == 0.0 { 0.0 } else { half }
        } else {
            self.tangent_on_line(foot, half, steepness)
        };
        let u = if e.z < 0.0 { -best } else { best }.clamp(low, high);
        let fraction = ((u - start) / run).clamp(0.0, 1.0);
        let rho = (foot * foot + u * u).sqrt().min(self.radius);
        a.z + e.z * fraction - self.height(rho)
    }

    fn vertex(&self, v: DVec3) -> f64 {
        let rho = v.truncate().length();
        if rho > self.radius { f64::NEG_INFINITY } else { v.z - self.height(rho) }
    }

    /// Where a bull-nose corner is tangent to a line that rises with `steepness` at plan distance
    /// `foot` from the axis: plan position `u >= 0` along the line, `half` where it leaves the disk.
    ///
    /// The slope of the profile along the line, `g'(rho) u / rho`, grows from 0 to infinity;
    /// `steepness * rho * sqrt(r_c^2 - w^2) - w u`, with `w = rho - bottom`, has the same sign as
    /// what is left to the steepness and no pole. Newton steps, bisection where they leave the
    /// bracket.
    fn tangent_on_line(&self, foot: f64, half: f64, steepness: f64) -> f64 {
        let mut low = (self.bottom * self.bottom - foot * foot).max(0.0).sqrt();
        let mut high = half;
        let mut u = 0.5 * (low + high);
        while high - low > 1e-13 * self.radius {
            let rho = (foot * foot + u * u).sqrt();
            let w = rho - self.bottom;
            let root = (self.corner * self.corner - w * w).max(0.0).sqrt();
            let left = steepness * rho * root - w * u;
            if left > 0.0 {
                low = u
            } else {
                high = u
            }
            let turn = u / rho;
            let slope = steepness * turn * (root - rho * w / root) - turn * u - w;
            let newton = u - left / slope;
            let step = newton - u;
            let accept = newton > low && newton < high;
            u = if accept { newton } else { 0.5 * (low + high) };
            if accept && step.abs() < 1e-12 * self.radius {
                break;
            }
            if u <= low || u >= high {
                break;
            }
        }
        u
    }
}
