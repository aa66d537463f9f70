//! What the machine is set to while it cuts, and whether that is what was asked for.

use evencut_core::machine::{Coolant, Setup, SpindleDirection};
use evencut_core::units::per_minute;

/// By how much the speed of the spindle may differ: what is programmed is whole, and this part of it.
const SPEED_ROUNDING: (f64, f64) = (1.0, 1e-3);
/// G codes of the work offsets, in tenths, in the order of [`evencut_core::machine::WorkOffset`].
const OFFSETS: [u32; 9] = [540, 550, 560, 570, 580, 590, 591, 592, 593];

/// What the machine is set to.
#[derive(Copy, Clone, Debug, PartialEq, Default)]
pub struct Setting {
    /// Number of the tool in the spindle; `None` where the program names none.
    pub tool: Option<u32>,
    /// Number of the offset of its length; `None` where the program names none.
    pub length_offset: Option<u32>,
    /// Whether a tool was changed and its length is not taken into account since.
    pub lacks_length: bool,
    /// G code of the work offset, in tenths; `None` where the program names none, or one that controllers number
    /// differently.
    pub work_offset: Option<u32>,
    /// Speed of the spindle, rev/min.
    pub speed: f64,
    /// How the spindle turns; `None` where it stands.
    pub direction: Option<SpindleDirection>,
    /// Whether any coolant is on.
    pub has_coolant: bool,
}

impl Setting {
    /// That which a job asks for; `spindle`: its speed, rev/s.
    pub fn wanted(setup: &Setup, spindle: f64) -> Self {
        Self {
            tool: Some(setup.tool_number),
            length_offset: Some(setup.length_offset),
            lacks_length: false,
            work_offset: setup.work_offset.map(|offset| OFFSETS[offset as usize]),
            speed: per_minute(spindle),
            direction: Some(setup.spindle),
            has_coolant: setup.coolant != Coolant::Off,
        }
    }

    /// Whether the spindle turns.
    pub fn turns(&self) -> bool {
        self.direction.is_some() && self.speed > 0.0
    }

    /// How it is another one than what is asked for. A program may leave the numbers of tool and offsets out, and have
    /// coolant where none is asked for; that the spindle stands is found by `check`.
    pub fn differs(&self, wanted: &Self) -> Option<String> {
        let other = |what: &str, found: Option<u32>, wanted: Option<u32>| {
            let (found, wanted) = found.zip(wanted).filter(|(found, wanted)| found != wanted)?;
            Some(format!("{what} {found}; the job has {wanted}"))
        };
        let code = |tenths: Option<u32>| tenths.map(|tenths| f64::from(tenths) / 10.0);
        let offsets = code(self.work_offset).zip(code(wanted.work_offset));
        let (least, share) = SPEED_ROUNDING;
        let is_fast = (self.speed - wanted.speed).abs() > least.max(share * wanted.speed);
        other("cuts with tool", self.tool, wanted.tool)
            .or_else(|| other("the length offset is", self.length_offset, wanted.length_offset))
            .or_else(|| {
                let (found, wanted) = offsets.filter(|(found, wanted)| found != wanted)?;
                Some(format!("the work offset is G{found}; the job has G{wanted}"))
            })
            .or_else(|| {
                let (speed, wanted) = (self.speed, wanted.speed);
                let message =
                    || format!("the spindle turns at {speed:.0} rev/min; the job has {wanted:.0}");
                (self.turns() && is_fast).then(message)
            })
            .or_else(|| {
                let is_other = self.turns() && self.direction != wanted.direction;
                is_other.then(|| {
                    "the spindle turns the other way than the job says (M3, M4)".to_string()
                })
            })
            .or_else(|| {
                let is_dry = wanted.has_coolant && !self.has_coolant;
                is_dry.then(|| "cuts without the coolant that the job asks for".to_string())
            })
    }
}
