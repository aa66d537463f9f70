//! LinuxCNC (RS-274/NGC).

use super::dialect::Dialect;

/// Millimetres, absolute, XY plane, no compensation, blending within the tolerance; M2 ends.
pub(super) const DIALECT: Dialect = Dialect {
    extension: "ngc",
    preamble: &[
        "G21 G90 G17 {feed_mode} G40 G49 G80",
        "G64 P{tolerance}",
        "T{tool} M6",
        "G43",
        "S{speed} M3",
    ],
    ending: &["M5", "M2"],
    comment: ["(", ")"],
    feed_per_minute: "G94",
    inverse_time: "G93",
    rapid: "G0",
    feed: "G1",
    decimals: [4, 5, 4],
};
