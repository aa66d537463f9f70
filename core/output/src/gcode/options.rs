//! How a program is read.

use super::error::GcodeError;
use evencut_core::geometry::DVec3;
use evencut_core::machine::Axes;

/// How a program is read.
#[derive(Clone, Debug, PartialEq)]
pub struct ReadOptions {
    /// Axes of the machine; three by default.
    pub axes: Axes,
    /// Largest distance of a chord from its arc, or from the way of the tip while rotary axes turn,
    /// mm; at least 1e-6. While they turn it also holds 50 mm up the tool, for the axis.
    pub chord_tolerance: f64,
    /// How much the radii at the two ends of an arc may differ, mm; more is a finding.
    pub arc_tolerance: f64,
    /// Speed of rapids, mm/s.
    pub rapid_feed: f64,
    /// Machine zero in the program's coordinates, mm: G53 is measured from it and G28 goes to it.
    /// `None`: where such moves lead is unknown, and they may only stand before and after the path, and before a change of
    /// the tool, after which the path goes on at rapid speed.
    pub machine_zero: Option<DVec3>,
    /// Whether the switch "block delete" is on: blocks that start with `/` are left out.
    pub block_delete: bool,
    /// Most points of the path, each of about 250 bytes.
    pub max_points: usize,
}

impl Default for ReadOptions {
    fn default() -> Self {
        Self {
            axes: Axes::ThreeAxis,
            chord_tolerance: 0.001,
            arc_tolerance: 0.01,
            rapid_feed: 250.0,
            machine_zero: None,
            block_delete: false,
            max_points: 10_000_000,
        }
    }
}

/// Whether all options are in their range.
///
/// # Errors
/// [`GcodeError::Option`], naming the first that is not.
pub fn validate(options: &ReadOptions) -> Result<(), GcodeError> {
    let rules = [
        ("chord_tolerance", options.chord_tolerance, 1e-6, "at least 1e-6 mm"),
        ("arc_tolerance", options.arc_tolerance, 0.0, "at least 0 mm"),
        ("rapid_feed", options.rapid_feed, f64::MIN_POSITIVE, "positive, mm/s"),
    ];
    for (name, value, least, rule) in rules {
        if !(value.is_finite() && value >= least) {
            return Err(GcodeError::Option { name, value, rule });
        }
    }
    let zero = options.machine_zero.unwrap_or_default();
    if !zero.is_finite() {
        return Err(GcodeError::Option { name: "machine_zero", value: f64::NAN, rule: "finite" });
    }
    Ok(())
}
