//! A tool of a library.

use crate::job::fault::Fault;
use crate::job::file::{
    AnalyticTable, CutTable, HolderTable, JobFile, SurfaceTable, ToolTable, Units, VERSION,
};
use crate::job::surface::AnalyticKind;
use crate::job::units::INCH;

/// Longest name that is kept, characters.
const LONGEST_NAME: usize = 200;

/// A tool of a library.
#[derive(Clone, Debug, PartialEq)]
pub struct LibraryTool {
    /// What it may be called by; the first is shown.
    pub names: Vec<String>,
    /// What it is, in the words of the file.
    pub kind: String,
    /// Unit of the lengths of its table.
    pub units: Units,
    /// Its keys, as far as the file gives them.
    pub table: ToolTable,
    /// Whether it is a left-hand cutter.
    pub is_left_hand: bool,
    /// Why it cannot be used, if the file alone shows that.
    pub refused: Option<String>,
}

impl LibraryTool {
    /// A tool without values. `names`: empty ones are left out; line breaks and their like become spaces.
    pub(super) fn new<'a>(names: impl IntoIterator<Item = Option<&'a str>>, kind: &str) -> Self {
        let clean = |name: &str| -> String {
            let plain = name.chars().map(|c| if c.is_control() { ' ' } else { c });
            plain.take(LONGEST_NAME).collect::<String>().trim().to_owned()
        };
        let names = names.into_iter().flatten().map(clean).filter(|name| !name.is_empty());
        Self {
            names: names.collect(),
            kind: clean(kind),
            units: Units::Mm,
            table: ToolTable::default(),
            is_left_hand: false,
            refused: None,
        }
    }

    /// The same, with its table, or the reason why there is none.
    pub(super) fn with(self, table: Result<ToolTable, String>) -> Self {
        match table {
            Ok(table) => Self { table, ..self },
            Err(reason) => Self { refused: Some(reason), ..self },
        }
    }

    /// The name that is shown; empty where it has none.
    pub fn name(&self) -> &str {
        self.names.first().map_or("", String::as_str)
    }

    /// Its number in the tool table of the machine, if it has one.
    pub fn number(&self) -> Option<u32> {
        self.table.number
    }

    /// Its keys, lengths in mm.
    pub fn in_mm(&self) -> ToolTable {
        scaled(&self.table, mm_in(self.units))
    }

    /// Why it cannot be used as it is: the file's own reason, or what the rules of `[tool]` say.
    pub fn faults(&self) -> Vec<String> {
        if let Some(reason) = &self.refused {
            return vec![reason.clone()];
        }
        // A job that asks nothing of its tool.
        let plane = AnalyticTable { kind: Some(AnalyticKind::Plane), ..AnalyticTable::default() };
        let job = JobFile {
            version: Some(VERSION),
            units: Some(self.units),
            surface: SurfaceTable { analytic: Some(plane), ..SurfaceTable::default() },
            tool: self.table.clone(),
            cut: CutTable { stepover: Some(1e-4), feed: Some(1.0), ..CutTable::default() },
            ..JobFile::default()
        };
        let faults = job.resolve().err().map_or_else(Vec::new, |faults| faults.0);
        faults.iter().filter(|f| f.key.starts_with("tool")).map(told).collect()
    }
}

/// A fault in a line.
pub(super) fn told(fault: &Fault) -> String {
    let key = fault.key.trim_start_matches("tool.");
    let help = fault.help.first().map_or_else(String::new, |help| format!("; {help}"));
    format!("{key}: {}{help}", fault.message)
}

/// mm in a unit of length.
pub(super) fn mm_in(units: Units) -> f64 {
    match units {
        Units::Mm => 1.0,
        Units::Inch => INCH,
    }
}

/// The same table in a unit of which there are `factor` in its own.
pub(super) fn scaled(table: &ToolTable, factor: f64) -> ToolTable {
    let length = |value: Option<f64>| value.map(|length| length * factor);
    let piece = |piece: &HolderTable| HolderTable {
        diameter: length(piece.diameter),
        upper_diameter: length(piece.upper_diameter),
        length: length(piece.length),
    };
    ToolTable {
        diameter: length(table.diameter),
        corner_radius: length(table.corner_radius),
        length: length(table.length),
        shank_diameter: length(table.shank_diameter),
        stickout: length(table.stickout),
        gauge_length: length(table.gauge_length),
        holder: table.holder.as_ref().map(|pieces| pieces.iter().map(piece).collect()),
        clearance: length(table.clearance),
        ..table.clone()
    }
}
