//! What the tables are resolved with: places, the unit of length, and notes of faults and warnings.

use crate::geometry::DVec3;
use crate::job::document::Places;
use crate::job::fault::Fault;
use crate::job::file::JobFile;
use crate::units::per_second;

/// A job file on its way to a job, and what is noted on the way.
pub(super) struct Resolver<'a> {
    pub file: &'a JobFile,
    pub places: Places,
    /// mm in the job's unit of length.
    pub unit: f64,
    pub faults: Vec<Fault>,
    pub warnings: Vec<Fault>,
}

impl Resolver<'_> {
    /// Notes a fault of `key` at its place.
    pub fn fault(&mut self, key: &str, message: impl Into<String>, help: impl Into<String>) {
        let place = self.places.of(key);
        self.faults.push(Fault::new(key, message).help(help).at(place));
    }

    pub fn warn(&mut self, key: &str, message: impl Into<String>, help: impl Into<String>) {
        let place = self.places.of(key);
        self.warnings.push(Fault::new(key, message).help(help).at(place));
    }

    /// `key` and the line it stands on, for messages that concern two keys.
    pub fn named(&self, key: &str) -> String {
        match self.places.line(key) {
            Some(line) => format!("`{key}` (line {line})"),
            None => format!("`{key}` (default)"),
        }
    }

    /// A length of so many mm in the unit of the job, to six decimals.
    pub fn show(&self, length: f64) -> String {
        let name = if self.unit == 1.0 { "mm" } else { "inch" };
        let rounded = (length / self.unit * 1e6).round() / 1e6;
        format!("{rounded} {name}")
    }

    pub fn length(&self, value: Option<f64>, default: f64) -> f64 {
        value.map_or(default, |v| v * self.unit)
    }

    pub fn feed(&self, value: Option<f64>, default: f64) -> f64 {
        per_second(value.map_or(default, |v| v * self.unit))
    }

    pub fn point(&self, p: [f64; 3]) -> DVec3 {
        DVec3::from(p) * self.unit
    }
}
