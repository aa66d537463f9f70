//! Whether the cutter, in a given place, is clear of a box or of a facet's plane.
//!
//! Terms. The *core* is the flat bottom disk of radius `R - r_c` at height `r_c` above the tip and everything
//! straight above it; for a ball end a ray. The cutter is everything closer to the core than the corner radius. Both
//! box and cutter are convex, so wherever they are apart a plane separates them.
//!
//! Ball: (1) the core's point nearest to the box's centre; (2) from there to the nearest point of the
//! box; (3) the plane across that direction. Below the ball's centre this is their exact distance.
//!
//! Flat and bull: (1) the point of the box nearest to where the cutter would touch the box's middle plane; (2) planes
//! whose normals lie in the plane through the axis and that point, so that the rim supports them there: across the
//! axis, along the box's own normal and across the gap to that point. On a slope that a flat end touches, a node is
//! skipped at twice its size from the contact.
//!
//! How far a plane lies inside the cutter, over its slope to the axis, bounds how far the cutter must rise.

use super::drop::Profile;
use crate::geometry::{DMat3, DVec3};

/// The cutter in place.
#[derive(Copy, Clone, Debug)]
pub(super) struct Solid {
    /// Its tip, mm.
    pub tip: DVec3,
    /// Unit axis.
    pub axis: DVec3,
    /// Its end.
    pub profile: Profile,
}

/// A box: its centre, unit directions and half its size along them.
#[derive(Copy, Clone, Debug, Default)]
pub(super) struct Block {
    pub centre: DVec3,
    pub frame: DMat3,
    pub half: DVec3,
}

impl Block {
    /// Coordinates of a direction along the box's own directions.
    pub fn turned(&self, direction: DVec3) -> DVec3 {
        let f = &self.frame;
        DVec3::new(f.x_axis.dot(direction), f.y_axis.dot(direction), f.z_axis.dot(direction))
    }

    /// How far the box reaches from its centre in a direction (of any length).
    pub fn extent(&self, direction: DVec3) -> f64 {
        self.turned(direction).abs().dot(self.half)
    }
}

/// The cutter as seen from a box: all in the box's own directions, from its centre.
struct View<'a> {
    half: DVec3,
    a: DVec3,
    tip: DVec3,
    profile: &'a Profile,
}

impl View<'_> {
    /// From the tip to the point of the box nearest to where the cutter would touch its middle plane.
    fn near_touch(&self) -> DVec3 {
        let Profile { corner, bottom, .. } = *self.profile;
        let n = DVec3::new(if self.a.x < 0.0 { -1.0 } else { 1.0 }, 0.0, 0.0);
        let across = n - self.a * n.dot(self.a);
        let touch = self.tip + (self.a - n) * corner - across.normalize_or_zero() * bottom;
        touch.clamp(-self.half, self.half) - self.tip
    }

    /// How far the cutter must rise for a plane to separate it from the box: one that touches it and faces along
    /// `lateral * outward + axis * up`, with `lateral` across the axis and `rho` long, `outward >= 0` and `up <= 0`.
    /// Not positive where the plane separates them now; infinite where it never will.
    fn rise(&self, lateral: DVec3, rho: f64, outward: f64, up: f64) -> f64 {
        let Profile { corner, bottom, .. } = *self.profile;
        let (w, out) = (lateral * outward + self.a * up, rho * outward);
        let mut past = w.abs().dot(self.half) + w.dot(self.tip) + bottom * out;
        if corner > 0.0 {
            past += corner * (up + (out * out + up * up).sqrt());
        }
        if up < 0.0 {
            past / -up
        } else if past < 0.0 {
            past
        } else {
            f64::INFINITY
        }
    }
}

impl Solid {
    /// Upper bound of how far the cutter must rise along its axis to be clear of a box, mm; not positive
    /// where it is clear now, infinite where nothing better is known.
    pub fn rise(&self, block: &Block) -> f64 {
        let Profile { corner, bottom, .. } = self.profile;
        let d = self.tip - block.centre;
        if bottom == 0.0 {
            let height = -d.dot(self.axis);
            let from_core = -d - self.axis * height.max(corner);
            return self.rise_of_ball(block, from_core, height < corner);
        }
        let view = View {
            half: block.half,
            a: block.turned(self.axis),
            tip: block.turned(d),
            profile: &self.profile,
        };
        let below = view.rise(DVec3::ZERO, 0.0, 0.0, -1.0);
        if below <= 0.0 {
            return below;
        }
        let near = view.near_touch();
        let height = near.dot(view.a);
        let lateral = near - view.a * height;
        let rho_squared = lateral.length_squared();
        let rho = rho_squared.sqrt();
        // The box's own normal, turned into the plane through the axis and that nearest point.
        // Near the axis the direction away from it is rounding noise.
        let sure = rho > 0.01 * self.profile.radius;
        let steep = if view.a.x > 0.0 { -lateral.x } else { lateral.x };
        let outward = if sure && steep > 0.0 { steep / rho_squared } else { 0.0 };
        let along_normal = view.rise(lateral, rho, outward, -view.a.x.abs());
        if along_normal <= 0.0 {
            return along_normal;
        }
        // From the core's nearest point.
        let out = rho - bottom;
        if !sure || out <= 0.0 {
            return below.min(along_normal);
        }
        let across_gap = view.rise(lateral, rho, out / rho, (height - corner).min(0.0));
        below.min(along_normal).min(across_gap)
    }

    /// [`Self::rise`] for a core that is a ray, from its nearest point to the box's centre.
    fn rise_of_ball(&self, block: &Block, from_core: DVec3, at_end: bool) -> f64 {
        let corner = self.profile.corner;
        let q = block.turned(from_core);
        let e = q - q.clamp(-block.half, block.half);
        let a = block.turned(self.axis);
        let up = e.dot(a);
        if at_end && up < 0.0 {
            let squared = e.length_squared();
            if squared >= corner * corner {
                return 0.0;
            }
            return (corner * squared.sqrt() - squared) / -up;
        }
        // Beside the ray only what is across it can part them, however far the cutter rises.
        let w = e - a * up;
        let length = w.length();
        if length >= corner && w.dot(q) - w.abs().dot(block.half) >= corner * length {
            0.0
        } else {
            f64::INFINITY
        }
    }

    /// Whether the cutter lies on the upper side of the plane through `point` across the unit `normal`.
    pub fn above_plane(&self, point: DVec3, normal: DVec3) -> bool {
        let Profile { corner, bottom, .. } = self.profile;
        let cosine = normal.dot(self.axis);
        let (normal, cosine) = if cosine < 0.0 { (-normal, -cosine) } else { (normal, cosine) };
        let gap = normal.dot(self.tip - point) - corner * (1.0 - cosine);
        gap >= 0.0 && gap * gap >= bottom * bottom * (1.0 - cosine * cosine)
    }
}
