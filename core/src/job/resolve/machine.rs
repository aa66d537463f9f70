//! The machine and the reach of its axes.

use super::resolver::Resolver;
use crate::job::units::radians;
use crate::machine::{Axes, Machine, Travel};

impl Resolver<'_> {
    pub(super) fn machine(&mut self) -> Machine {
        let table = &self.file.machine;
        let travel = table.travel.clone().unwrap_or_default();
        Machine {
            axes: table.axes.unwrap_or(Axes::ThreeAxis),
            max_feed: self.feed(table.max_feed, 15_000.0),
            max_acceleration: self.length(table.max_acceleration, 2000.0),
            max_rotary_speed: radians(table.max_rotary_speed.unwrap_or(90.0)),
            clearance: self.length(table.clearance, 10.0),
            travel: Travel {
                x: self.reach("x", travel.x),
                y: self.reach("y", travel.y),
                z: self.reach("z", travel.z),
            },
        }
    }

    fn reach(&mut self, axis: &str, reach: Option<[f64; 2]>) -> Option<(f64, f64)> {
        let [least, greatest] = reach?;
        if least >= greatest {
            let key = format!("machine.travel.{axis}");
            let message = format!("from {least} to {greatest} there is no travel");
            self.fault(&key, message, "give the least position first, then the greatest");
        }
        Some((least * self.unit, greatest * self.unit))
    }
}
