//! The controller of the machine, and what a program sets up there before the first move.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Post-processors that come along.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum Post {
    /// LinuxCNC (RS-274/NGC).
    LinuxCnc,
    /// Fanuc.
    Fanuc,
    /// Haas.
    Haas,
    /// Siemens SINUMERIK.
    Siemens,
    /// Heidenhain, conversational.
    Heidenhain,
    /// GRBL 1.1, three axes.
    Grbl,
    /// APT cutter location data.
    Cldata,
}

impl Post {
    /// All of them.
    pub const ALL: [Self; 7] = [
        Self::LinuxCnc,
        Self::Fanuc,
        Self::Haas,
        Self::Siemens,
        Self::Heidenhain,
        Self::Grbl,
        Self::Cldata,
    ];

    /// Its name in job files.
    pub fn name(self) -> &'static str {
        match self {
            Self::LinuxCnc => "linuxcnc",
            Self::Fanuc => "fanuc",
            Self::Haas => "haas",
            Self::Siemens => "siemens",
            Self::Heidenhain => "heidenhain",
            Self::Grbl => "grbl",
            Self::Cldata => "cldata",
        }
    }
}

/// Coolant while the spindle turns.
#[derive(Copy, Clone, Debug, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Coolant {
    /// None.
    #[default]
    Off,
    /// Flood.
    Flood,
    /// Mist.
    Mist,
    /// Air blast.
    Air,
    /// Through the spindle.
    Through,
}

impl Coolant {
    /// Its name in job files and posts.
    pub fn name(self) -> &'static str {
        match self {
            Self::Off => "off",
            Self::Flood => "flood",
            Self::Mist => "mist",
            Self::Air => "air",
            Self::Through => "through",
        }
    }
}

/// Work offset.
#[derive(Copy, Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum WorkOffset {
    /// The first.
    G54,
    /// The second.
    G55,
    /// The third.
    G56,
    /// The fourth.
    G57,
    /// The fifth.
    G58,
    /// The sixth.
    G59,
    /// The seventh.
    #[serde(rename = "G59.1")]
    G591,
    /// The eighth.
    #[serde(rename = "G59.2")]
    G592,
    /// The ninth.
    #[serde(rename = "G59.3")]
    G593,
}

impl WorkOffset {
    /// Its name in job files and posts.
    pub fn name(self) -> &'static str {
        match self {
            Self::G54 => "G54",
            Self::G55 => "G55",
            Self::G56 => "G56",
            Self::G57 => "G57",
            Self::G58 => "G58",
            Self::G59 => "G59",
            Self::G591 => "G59.1",
            Self::G592 => "G59.2",
            Self::G593 => "G59.3",
        }
    }
}

/// Direction in which the spindle turns, seen from the spindle towards the cutter's tip.
#[derive(Copy, Clone, Debug, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum SpindleDirection {
    /// Right-hand cutters (M3).
    #[default]
    Clockwise,
    /// Left-hand cutters (M4).
    CounterClockwise,
}

/// What a program sets up before the first move.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub struct Setup {
    /// Number of the program, 1 to 9999.
    pub program_number: u32,
    /// Of the cutter in the tool table.
    pub tool_number: u32,
    /// Numbers of the offsets of its length and its diameter.
    pub length_offset: u32,
    /// That of the diameter; no compensation is programmed, but a post may name it.
    pub diameter_offset: u32,
    /// `None`: that in force.
    pub work_offset: Option<WorkOffset>,
    /// Coolant.
    pub coolant: Coolant,
    /// Direction of the spindle.
    pub spindle: SpindleDirection,
    /// Whether runs of points are one block where they lie along a line or an arc (G2, G3).
    pub arcs: bool,
}

impl Default for Setup {
    fn default() -> Self {
        Self {
            program_number: 1,
            tool_number: 1,
            length_offset: 1,
            diameter_offset: 1,
            work_offset: None,
            coolant: Coolant::Off,
            spindle: SpindleDirection::Clockwise,
            arcs: false,
        }
    }
}
