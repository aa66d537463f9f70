//! Limits on the cut, and what is done where they would be exceeded.

use super::resolver::Resolver;
use crate::footprint::Footprint;
use crate::job::complete::Job;
use crate::job::cut::Cut;
use crate::job::force::{FeedComponent, Force, ForceControl, MinChip, MrrLimit};
use crate::job::path::Pattern;
use crate::job::units::radians;
use crate::load::Material;
use crate::tool::Tool;
use crate::units::per_second;
use core::f64::consts::PI;

/// Feed per tooth below which trochoids are preferred, tool diameters: a third of the radius of a carbide cutter's edge,
/// which is about a thousandth of its diameter. Chips form from 0.14 to 0.43 of that radius on (Cheng et al., Int. J.
/// Adv. Manuf. Technol. 97 (2018), 3119).
const THIN_CHIP: f64 = 3e-4;
/// The same as a share of the full feed per tooth, at most.
const MOST_THIN: f64 = 0.5;
/// Exponent of the chip thickness where only `kc11` is given.
const USUAL_MC: f64 = 0.25;
/// Keys that limit what is removed in a time.
const RATES: [&str; 4] = ["mrr_limit", "relative", "power", "cutting_force"];
/// Keys that limit how the cutter is loaded at any feed, or by a slow one.
const LOADS: [&str; 2] = ["min_chip", "max_engagement"];

impl Resolver<'_> {
    pub(super) fn force(&mut self, tool: Option<Tool>, cut: Option<&Cut>) -> Force {
        let table = &self.file.force;
        if self.places.has("force.mrr_limit") && self.places.has("force.relative") {
            let message = format!("given beside {}", self.named("force.mrr_limit"));
            self.fault("force.relative", message, "keep one of the two");
        }
        let given = |keys: &[&str]| {
            keys.iter().map(|key| format!("force.{key}")).find(|key| self.places.has(key))
        };
        let rate = given(&RATES);
        let is_limited = rate.is_some();
        let lags = tool.zip(cut).is_some_and(|(tool, cut)| Footprint::new(tool, cut.lead).lags());
        let control = self.control(rate, given(&LOADS), lags);
        let cubic = self.unit * self.unit * self.unit;
        Force {
            limit: match (table.mrr_limit, table.relative) {
                (Some(limit), _) => Some(MrrLimit::Absolute(per_second(limit * cubic))),
                (None, Some(factor)) => Some(MrrLimit::Relative(factor)),
                (None, None) => (!is_limited).then_some(MrrLimit::Relative(1.5)),
            },
            power: table.power,
            cutting_force: table.cutting_force,
            material: self.material(),
            min_chip: self.min_chip(tool, cut),
            max_engagement: table.max_engagement.map_or(PI, radians),
            control,
            vfc: table.vfc.unwrap_or(FeedComponent::Mean),
        }
    }

    /// `rate`, `load`: the keys of limits that the job states, which slowing keeps or does not; `lags`: whether the
    /// cutter's strips lag.
    fn control(&mut self, rate: Option<String>, load: Option<String>, lags: bool) -> ForceControl {
        let pattern = self.file.path.pattern.unwrap_or(Pattern::Contour);
        let takes_trochoids = pattern.takes_trochoids(lags);
        let needs_trochoids = pattern == Pattern::Contour || load.is_some();
        let default = match rate.or(load) {
            _ if takes_trochoids && needs_trochoids => ForceControl::Fastest,
            Some(_) if pattern != Pattern::Hub => ForceControl::Feed,
            Some(key) if self.file.force.control.is_none() => {
                let help = "leave it out";
                self.fault(&key, "the pattern hub keeps no limit on the cut", help);
                ForceControl::Off
            }
            _ => ForceControl::Off,
        };
        let control = self.file.force.control.unwrap_or(default);
        if control.takes_trochoids() && !takes_trochoids {
            let message = match pattern {
                Pattern::Hub | Pattern::Spiral => {
                    format!("trochoids are not possible in {:?} passes", pattern.name())
                }
                _ => format!(
                    "trochoids of an inclined flat or bull end are possible in contour passes only, not {:?}",
                    pattern.name()
                ),
            };
            let help = "give `control = \"feed\"` or `\"off\"`, or `pattern = \"contour\"`";
            self.fault("force.control", message, help);
        }
        control
    }

    /// What is cut; power and force cannot be limited without it.
    fn material(&mut self) -> Option<Material> {
        let table = &self.file.material;
        for key in ["force.power", "force.cutting_force"] {
            if self.places.has(key) && table.group.is_none() && table.kc11.is_none() {
                let help = "name it: `[material]` with `group = \"P\"`, or with `kc11` and `mc`";
                self.fault(key, "depends on what is cut, which the job does not say", help);
            }
        }
        if table.mc.is_some() && table.group.is_none() && table.kc11.is_none() {
            self.fault("material.mc", "given without `kc11`", "give `kc11`, or a `group` instead");
        }
        let of_group = table.group.map(|group| group.hardest());
        let kc11 = table.kc11.or(of_group.map(|m| m.kc11))?;
        Some(Material { kc11, mc: table.mc.or(of_group.map(|m| m.mc)).unwrap_or(USUAL_MC) })
    }

    fn min_chip(&mut self, tool: Option<Tool>, cut: Option<&Cut>) -> MinChip {
        let flutes = f64::from(self.file.tool.flutes.unwrap_or(4));
        let full = cut.map_or(f64::INFINITY, |cut| cut.feed / (cut.spindle * flutes));
        let Some(least) = self.file.force.min_chip.map(|chip| chip * self.unit) else {
            let diameter = tool.map_or(0.0, |tool| 2.0 * tool.radius());
            return MinChip::Wish((THIN_CHIP * diameter).min(MOST_THIN * full));
        };
        if least >= full {
            let message = format!("the full feed is only {} per tooth", self.show(full));
            let help = "give less, a higher `cut.feed` or a lower `cut.spindle`";
            self.fault("force.min_chip", message, help);
        }
        MinChip::Limit(least)
    }

    /// What straight passes engage, they engage everywhere.
    pub(super) fn check_engagement(&mut self, job: &Job) {
        let teeth = job.teeth();
        let straight = teeth.engaged(job.nominal_side_step() * job.cut.axial_depth);
        if job.force.max_engagement < straight {
            let message = format!(
                "a straight pass engages the cutter over {:.1} degrees",
                straight.to_degrees()
            );
            let help = "give more, or a smaller `cut.stepover` or `cut.scallop`";
            self.fault("force.max_engagement", message, help);
        }
    }
}
