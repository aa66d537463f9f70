//! The format of a program, by its first line.

use super::block::{Block, Line};
use super::cldata::Cldata;
use super::error::Fault;
use super::heidenhain;

/// Statements with which cutter location data may begin.
const CLDATA: [&str; 10] = [
    "PARTNO", "PPRINT", "UNITS/", "MULTAX", "MACHIN/", "CUTTER/", "LOADTL/", "GOTO/", "SPINDL/",
    "$$",
];

/// Turns the lines of a program into blocks.
pub(super) enum Scanner {
    Words,
    Heidenhain,
    Cldata(Cldata),
}

impl Scanner {
    /// For a program.
    pub fn of(program: &str) -> Self {
        let first =
            program.lines().map(str::trim).find(|line| !line.is_empty()).unwrap_or_default();
        let first = first.to_ascii_uppercase();
        if heidenhain::unnumbered(&first).starts_with("BEGIN PGM") {
            Self::Heidenhain
        } else if CLDATA.iter().any(|word| first.starts_with(word)) {
            Self::Cldata(Cldata::default())
        } else {
            Self::Words
        }
    }

    /// Reads a line.
    pub fn scan(&mut self, block: &mut Block, text: &str, delete: bool) -> Result<Line, Fault> {
        match self {
            Self::Words => block.scan(text, delete),
            Self::Heidenhain => heidenhain::scan(block, text),
            Self::Cldata(state) => state.scan(block, text),
        }
    }
}
