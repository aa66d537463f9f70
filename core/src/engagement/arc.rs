//! The engaged arc of the cutter circle.

use crate::geometry::math;
use crate::job::FeedComponent;

/// Engagement of the leading half circle.
#[derive(Copy, Clone, Debug, Default, PartialEq)]
pub struct Engagement {
    /// Engagement angle, rad.
    pub alpha: f64,
    /// Integral of the cosine of the angle from the feed over the engaged arc, 0 to 2.
    pub normal_feed: f64,
}

impl Engagement {
    /// Adds the arc between two sines of the angle from the feed.
    pub(super) fn add(&mut self, from: f64, to: f64) {
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
