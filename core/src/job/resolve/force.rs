//! The limit on the removal rate, and what is done where it would be exceeded.

use super::resolver::Resolver;
use crate::job::force::{FeedComponent, Force, ForceControl, MrrLimit};
use crate::job::path::Pattern;
use crate::units::per_second;

impl Resolver<'_> {
    pub(super) fn force(&mut self) -> Force {
        let table = &self.file.force;
        if self.places.has("force.mrr_limit") && self.places.has("force.relative") {
            let message = format!("given beside {}", self.named("force.mrr_limit"));
            self.fault("force.relative", message, "keep one of the two");
        }
        let pattern = self.file.path.pattern.unwrap_or(Pattern::Contour);
        let default = match pattern.takes_trochoids() {
            true => ForceControl::Trochoid,
            false => ForceControl::Off,
        };
        let control = table.control.unwrap_or(default);
        if control == ForceControl::Trochoid && !pattern.takes_trochoids() {
            let message =
                format!("trochoids are possible in contour passes only, not {:?}", pattern.name());
            let help = "give `control = \"feed\"` or `\"off\"`, or `pattern = \"contour\"`";
            self.fault("force.control", message, help);
        }
        let cubic = self.unit * self.unit * self.unit;
        Force {
            limit: match table.mrr_limit {
                Some(limit) => MrrLimit::Absolute(per_second(limit * cubic)),
                None => MrrLimit::Relative(table.relative.unwrap_or(1.5)),
            },
            control,
            vfc: table.vfc.unwrap_or(FeedComponent::Mean),
        }
    }
}
