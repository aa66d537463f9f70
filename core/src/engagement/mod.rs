//! Engagement of the cutter in the flat plane and the removal rate that follows from it.
//!
//! - *Stock*: the region minus what was swept before.
//! - *Leading half circle*: the part of the cutter circle that faces the feed.
//! - *Engaged arc*: the part of the leading half circle that is in stock.
//!
//! With `alpha` the engaged angle and `V_fc` the mean feed component normal to the engaged arc,
//! `MRR3 = R alpha V_fc H` and `alpha V_fc = V_f * integral of cos(theta) over the engaged arc`.
//!
//! Source: S-FORCE (spec 03, "The plane picture").

mod capsule;
mod swept;
mod walk;

pub use capsule::Capsule;
pub use swept::{Checkpoint, Stock};
pub use walk::{AIM, Cutting, Mark, Walk};

use crate::geometry::math;
use crate::job::FeedComponent;

/// How much of the leading half circle is in stock.
#[derive(Copy, Clone, Debug, Default, PartialEq)]
pub struct Engagement {
    /// Engagement angle, rad.
    pub alpha: f64,
    /// Integral of the cosine of the angle from the feed over the engaged arc, 0 to 2.
    pub normal_feed: f64,
}

impl Engagement {
    /// Adds the arc between two sines of the angle from the feed.
    fn add(&mut self, from: f64, to: f64) {
        self.alpha += math::asin(to) - math::asin(from);
        self.normal_feed += to - from;
    }

    /// The factor of `R H V_f` in the removal rate: `MRR3 = R H V_f * intensity`.
    pub fn intensity(&self, vfc: FeedComponent) -> f64 {
        match vfc {
            FeedComponent::Mean => self.normal_feed,
            FeedComponent::Feed => self.alpha,
        }
    }
}

#[cfg(test)]
mod tests;
