//! The machine, its rotary axes and the reach of its axes.

use super::resolver::Resolver;
use crate::geometry::DVec3;
use crate::job::file::{RotaryLetter, RotaryTable, ToolTable};
use crate::job::units::radians;
use crate::machine::{Arrangement, Axes, Carries, Chain, Machine, RotaryAxis, Travel};

/// Fastest turn of a rotary axis by default, degrees/s.
const ROTARY_SPEED: f64 = 90.0;
/// Share by which a sum of lengths may seem longer.
const ROUNDING: f64 = 1e-9;

impl Resolver<'_> {
    pub(super) fn machine(&mut self) -> Machine {
        let axes = self.axes();
        let table = &self.file.machine;
        let travel = table.travel.clone().unwrap_or_default();
        Machine {
            axes,
            max_feed: self.feed(table.max_feed, 15_000.0),
            max_acceleration: self.length(table.max_acceleration, 2000.0),
            clearance: self.length(table.clearance, 10.0),
            travel: Travel {
                x: self.reach("x", travel.x),
                y: self.reach("y", travel.y),
                z: self.reach("z", travel.z),
            },
        }
    }

    /// After a fault some five axes, so that nothing is said of what follows from three.
    fn axes(&mut self) -> Axes {
        let faulty = Arrangement::Xyzac.axes(0.0);
        let table = &self.file.machine;
        if let Some(file) = &table.file {
            self.check_file("machine.file", file, &["toml"]);
        }
        let named = match (table.axes, &table.rotary) {
            (Some(_), Some(_)) => {
                let message = format!("given beside {}", self.named("machine.axes"));
                self.fault("machine.rotary", message, "keep one of the two");
                return faulty;
            }
            (named, None) => named.unwrap_or(Arrangement::ThreeAxis),
            (None, Some(_)) => Arrangement::ThreeAxis,
        };
        let of_name = |&(letter, carries): &(char, Carries)| {
            let letter = match letter {
                'A' => RotaryLetter::A,
                'B' => RotaryLetter::B,
                _ => RotaryLetter::C,
            };
            RotaryTable { letter: Some(letter), carries: Some(carries), ..RotaryTable::default() }
        };
        let given = table.rotary.clone();
        let tables = given.unwrap_or_else(|| named.rotary().iter().map(of_name).collect());
        let key = if self.places.has("machine.rotary") { "machine.rotary" } else { "machine.axes" };
        let [first, second] = &tables[..] else {
            let is_faulty = self.places.has("machine.rotary") || self.places.has("machine.axes");
            return if is_faulty && table.axes.is_none() { faulty } else { Axes::ThreeAxis };
        };
        let is_placed = |t: &RotaryTable| {
            let has_pivot = t.centre.is_some() || self.places.has("machine.pivot_length");
            t.carries != Some(Carries::Head) || has_pivot
        };
        if !tables.iter().all(is_placed) {
            let help = "give `machine.pivot_length`: from the spindle's gauge line up to the pivot";
            self.fault(
                key,
                "a head turns the spindle, but the place of its pivot is missing",
                help,
            );
            return faulty;
        }
        let [Some(first), Some(second)] = [first, second].map(|t| self.rotary(t, key)) else {
            return faulty;
        };
        if second.carries == Carries::Table && self.places.has("machine.pivot_length") {
            let help = "leave it out; a table has its `centre`";
            self.warn("machine.pivot_length", "says nothing about tables", help);
        }
        let has_heads = second.carries == Carries::Head;
        let length = self.gauge_length();
        if length.is_none() && has_heads {
            if !self.places.has("tool.gauge_length") {
                let help = "give `tool.gauge_length`, or describe the holder (`tool.holder`)";
                self.fault("tool", "a head turns the spindle, but the length from the tip to the spindle's gauge line is missing", help);
            }
            return faulty;
        }
        match Chain::new([first, second], length.unwrap_or(0.0)) {
            Ok(chain) => Axes::FiveAxis(chain),
            Err(error) => {
                let help =
                    "give two axes that tilt the tool, the one nearer to the workpiece first";
                self.fault(key, error.to_string(), help);
                faulty
            }
        }
    }

    /// `None` with a fault noted.
    fn rotary(&mut self, table: &RotaryTable, key: &str) -> Option<RotaryAxis> {
        let machine = &self.file.machine;
        let letter = match table.letter? {
            RotaryLetter::A => 'A',
            RotaryLetter::B => 'B',
            RotaryLetter::C => 'C',
        };
        let carries = table.carries?;
        let plain = RotaryAxis::plain(letter, carries);
        let direction =
            table.direction.map_or(Some(plain.direction), |d| DVec3::from(d).try_normalize());
        let Some(direction) = direction else {
            self.fault(
                key,
                format!("the direction of {letter} is 0"),
                "give the direction that it turns about",
            );
            return None;
        };
        let centre = match (carries, table.centre, machine.pivot_length) {
            (_, Some(centre), _) => self.point(centre),
            (Carries::Head, None, Some(length)) => self.unit * length * DVec3::Z,
            (Carries::Table, None, _) => DVec3::ZERO,
            // Refused before.
            (Carries::Head, None, None) => return None,
        };
        if let Some([low, high]) = table.range.filter(|[low, high]| low >= high) {
            let message = format!("the range of {letter} from {low} to {high} is empty");
            self.fault(key, message, "give the least position first, then the greatest");
            return None;
        }
        let range = table.range.map_or(plain.range, |[low, high]| (radians(low), radians(high)));
        let speed = table.max_speed.or(machine.max_rotary_speed).unwrap_or(ROTARY_SPEED);
        let acceleration = table.max_acceleration.or(machine.max_rotary_acceleration);
        Some(RotaryAxis {
            direction,
            centre,
            range,
            max_speed: radians(speed),
            max_acceleration: acceleration.map_or(f64::INFINITY, radians),
            ..plain
        })
    }

    /// From the tip to the spindle's gauge line, mm, as far as the job says.
    fn gauge_length(&mut self) -> Option<f64> {
        let ToolTable { gauge_length, stickout, holder, .. } = &self.file.tool;
        let of_holder = stickout.zip(holder.as_ref()).map(|(stickout, holder)| {
            holder.iter().filter_map(|section| section.length).fold(stickout, |sum, l| sum + l)
        });
        let least = of_holder.or(*stickout).unwrap_or(0.0) * (1.0 - ROUNDING);
        if let Some(length) = gauge_length.filter(|length| *length < least) {
            let message = format!("{length} is less than what stands below the gauge line");
            let help = format!("give at least {least:.3}: stickout and holder");
            self.fault("tool.gauge_length", message, help);
        }
        gauge_length.or(of_holder).map(|length| length * self.unit)
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
