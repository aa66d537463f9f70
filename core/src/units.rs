//! Minutes, in which people count feeds, speeds and removal rates; all else is in seconds.

/// A minute, s.
pub const MINUTE: f64 = 60.0;

/// So much a minute that is so much a second.
pub fn per_minute(per_second: f64) -> f64 {
    MINUTE * per_second
}

/// So much a second that is so much a minute.
pub fn per_second(per_minute: f64) -> f64 {
    per_minute / MINUTE
}
