//! What differs between controllers.

/// What differs between controllers.
pub struct Dialect {
    pub extension: &'static str,
    /// Blocks before the first move; `{tolerance}`, `{tool}`, `{speed}` and `{feed_mode}` are filled in.
    pub preamble: &'static [&'static str],
    /// Blocks after the last move.
    pub ending: &'static [&'static str],
    /// What opens and closes a comment.
    pub comment: [&'static str; 2],
    pub feed_per_minute: &'static str,
    pub inverse_time: &'static str,
    pub rapid: &'static str,
    pub feed: &'static str,
    /// Decimals of lengths in mm, of angles in degrees and of feeds.
    pub decimals: [u32; 3],
}
