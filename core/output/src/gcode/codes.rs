//! Codes: what they change, and why others are refused.

use super::arc::Plane;
use super::error::Fault;
use super::setting::Setting;
use evencut_core::machine::SpindleDirection;

/// What to do about subprograms.
pub(super) const SUBPROGRAM: &str =
    "a subprogram or macro; have the program written as one run of plain moves";

/// Motion in force.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub(super) enum Motion {
    Rapid,
    Feed,
    Arc { counter_clockwise: bool },
}

/// What a code asks for in its own block only.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub(super) enum Once {
    /// G4.
    Dwell,
    /// G28.
    Home,
    /// G30, to a place that only the machine knows.
    SecondHome,
    /// G53.
    MachineCoordinates,
}

/// What stays in force.
#[derive(Clone, Debug)]
pub(super) struct Modal {
    pub motion: Option<Motion>,
    pub plane: Plane,
    /// Millimetres per unit.
    pub unit: f64,
    pub incremental: bool,
    pub absolute_centres: bool,
    pub inverse_time: bool,
    /// Coordinates are those of the tip in the workpiece: tool centre control is on.
    pub control: bool,
    /// There I, J and K are the direction of the tool axis.
    pub axis_by_ijk: bool,
    /// Work offset named so far.
    offset: Option<(u32, u32)>,
    /// Feed: as programmed, and in mm/min or 1/min.
    pub feed: Option<[f64; 2]>,
    /// Tool, offsets, spindle and coolant.
    pub setting: Setting,
    /// The tool that the next change puts into the spindle.
    pub next_tool: Option<u32>,
}

impl Default for Modal {
    fn default() -> Self {
        Self {
            motion: None,
            plane: Plane::Xy,
            unit: 1.0,
            incremental: false,
            absolute_centres: false,
            inverse_time: false,
            control: false,
            axis_by_ijk: false,
            offset: None,
            feed: None,
            setting: Setting::default(),
            next_tool: None,
        }
    }
}

impl Modal {
    /// Takes the G codes of a block, in tenths.
    pub fn g_codes(&mut self, codes: &[u32]) -> Result<Option<Once>, Fault> {
        let mut seen = 0_u32;
        let mut once = None;
        if codes.contains(&800) {
            self.motion = None;
        }
        for &code in codes {
            let group = 1 << group(code);
            if group != 1 && seen & group != 0 {
                return Err(Fault::Twice(name('G', code)));
            }
            seen |= group;
            once = once.or(self.g(code)?);
        }
        Ok(once)
    }

    fn g(&mut self, code: u32) -> Result<Option<Once>, Fault> {
        match code {
            0 => self.motion = Some(Motion::Rapid),
            10 => self.motion = Some(Motion::Feed),
            20 | 30 => self.motion = Some(Motion::Arc { counter_clockwise: code == 30 }),
            40 => return Ok(Some(Once::Dwell)),
            280 => return Ok(Some(Once::Home)),
            300 => return Ok(Some(Once::SecondHome)),
            530 => return Ok(Some(Once::MachineCoordinates)),
            170 => self.plane = Plane::Xy,
            180 => self.plane = Plane::Zx,
            190 => self.plane = Plane::Yz,
            200 | 7000 => self.unit = 25.4,
            210 | 7100 => self.unit = 1.0,
            900 | 910 => self.incremental = code == 910,
            901 | 911 => self.absolute_centres = code == 901,
            930 | 940 => self.feed_mode(code == 930),
            540 | 550 | 560 | 570 | 580 | 590 | 591 | 592 | 593 | 5050..=5990 => {
                self.offset(code, 0)?;
            }
            // The reader has the number that belongs to it.
            541 | 1540 => {}
            // Tool centre control goes on; the reader turns coordinates into those of the tip.
            434 | 435 | 2340 => self.axis_by_ijk = code == 435,
            // Nothing of these moves the tip: compensation off, lengths, path modes, cycles off.
            150 | 400 | 430 | 490 | 610 | 611 | 640 | 690 | 800 | 970 | 980 | 990 => {}
            _ => return Err(refused(name('G', code), refusal(code))),
        }
        Ok(None)
    }

    /// A feed is never carried from one mode to the other.
    fn feed_mode(&mut self, inverse_time: bool) {
        if self.inverse_time != inverse_time {
            self.feed = None;
        }
        self.inverse_time = inverse_time;
    }

    /// A work offset, of codes that have several with its number.
    pub fn offset(&mut self, code: u32, number: u32) -> Result<(), Fault> {
        self.setting.work_offset = (number == 0 && code < 1000).then_some(code);
        match self.offset.replace((code, number)) {
            Some(before) if before != (code, number) => {
                let remedy = "a second work offset, and where it lies is not in the program; split the program at its offsets";
                Err(refused(name('G', code), (remedy, true)))
            }
            _ => Ok(()),
        }
    }

    /// Takes the M codes of a block, in tenths; whether one of them ends the program.
    pub fn m_codes(&mut self, codes: &[u32]) -> Result<bool, Fault> {
        let setting = &mut self.setting;
        // A tool change comes first and stops the spindle.
        if codes.contains(&60) {
            setting.tool = self.next_tool;
            setting.lacks_length = true;
            setting.direction = None;
        }
        let mut end = false;
        for &code in codes {
            match code {
                20 | 300 => end = true,
                30 => setting.direction = Some(SpindleDirection::Clockwise),
                40 => setting.direction = Some(SpindleDirection::CounterClockwise),
                50 => setting.direction = None,
                // Mist, flood, by air and through the spindle.
                70 | 80 | 830 | 880 => setting.has_coolant = true,
                90 | 840 | 890 => setting.has_coolant = false,
                0 | 60 | 10 | 100 | 110 | 480 | 490 => {}
                970 | 980 | 990 => return Err(refused(name('M', code), (SUBPROGRAM, true))),
                _ => {
                    let remedy = "a function of one machine; remove it if it moves no axis";
                    return Err(refused(name('M', code), (remedy, false)));
                }
            }
        }
        Ok(end)
    }

    /// Takes the feed and speed words of a block.
    pub fn rates(&mut self, feed: Option<f64>, speed: Option<f64>) {
        let scale = if self.inverse_time { 1.0 } else { self.unit };
        let feed = feed.map(|word| [word, word * scale]);
        // Under inverse time every block has its own.
        self.feed = if self.inverse_time { feed } else { feed.or(self.feed) };
        self.setting.speed = speed.unwrap_or(self.setting.speed);
    }
}

/// Codes of a group exclude each other; group 0 excludes nothing.
fn group(code: u32) -> u32 {
    match code {
        0 | 10 | 20 | 30 => 1,
        40 | 280 | 300 | 530 => 2,
        170 | 180 | 190 => 3,
        200 | 210 | 7000 | 7100 => 4,
        900 | 910 => 5,
        901 | 911 => 6,
        930 | 940 => 7,
        540..=593 | 1540 | 5050..=5990 => 8,
        430 | 434 | 435 | 490 | 2340 => 10,
        610..=640 => 9,
        _ => 0,
    }
}

/// A code as it is written.
fn name(letter: char, tenths: u32) -> String {
    match tenths % 10 {
        0 => format!("{letter}{}", tenths / 10),
        part => format!("{letter}{}.{part}", tenths / 10),
    }
}

fn refused(word: String, (remedy, displaces): (&'static str, bool)) -> Fault {
    Fault::Refused { word, remedy, displaces }
}

/// What a G code is that is not followed, and what to do instead; whether moves are others than those that are written.
fn refusal(code: u32) -> (&'static str, bool) {
    let cycles = matches!(code, 310..=319 | 380..=389 | 730 | 740 | 760 | 810..=899);
    let offsets =
        matches!(code, 100 | 160 | 410..=449 | 500 | 510 | 511 | 520 | 680..=689 | 920..=929);
    let displaces = cycles || offsets || matches!(code, 330..=339 | 650..=679 | 950 | 960);
    let remedy = match code {
        410..=429 => {
            "cutter compensation; have the path of the cutter's centre written, with G40 in force"
        }
        730 | 740 | 760 | 810..=899 => "a canned cycle; have its moves written out with G0 and G1",
        650..=679 => SUBPROGRAM,
        431..=449 => "a changed tool length; have the program written with G43, G43.4 or G49",
        100 | 520 | 920..=929 => {
            "an offset set by the program; have coordinates written from one work offset"
        }
        500 | 510 | 511 | 680..=689 | 160 => {
            "scaling, rotation or polar coordinates; have plain coordinates written"
        }
        50..=59 => "a spline or a high-speed mode; have G1, G2 and G3 written",
        70 | 80 => "a lathe's mode; mills are read",
        330..=339 | 950 | 960 => {
            "feed or speed by the turn or by the cutting speed; have F in units per minute (G94) or inverse time (G93), and G97, written"
        }
        310..=319 | 380..=389 => "a probing move; remove it",
        _ => "an unknown code; remove it if it moves no axis",
    };
    (remedy, displaces)
}
