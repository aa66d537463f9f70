//! Progress on a terminal: one line with stage and percentage, for runs longer than a second.

use std::io::Write;
use std::time::{Duration, Instant};

/// Runs shorter than this show no progress.
const QUIET: Duration = Duration::from_secs(1);

/// Least time between two drawings; more would flicker and cost time, less would seem stuck.
const PAUSE: Duration = Duration::from_millis(100);

/// Draws progress on a terminal, and nothing elsewhere.
///
/// The line is cleared when the value is dropped, so that messages start on an empty line.
pub struct Progress<W: Write> {
    /// `None` where it is not a terminal.
    terminal: Option<W>,
    start: Instant,
    last_drawn: Option<Duration>,
}

impl<W: Write> Progress<W> {
    /// Progress on `terminal`; `None` draws nothing.
    pub fn new(terminal: Option<W>) -> Self {
        Self { terminal, start: Instant::now(), last_drawn: None }
    }

    /// Notes that `stage` has come to `fraction` (0 to 1) of its work.
    pub fn report(&mut self, stage: &str, fraction: f64) {
        self.report_at(self.start.elapsed(), stage, fraction);
    }

    /// As [`Progress::report`], `now` after the start.
    fn report_at(&mut self, now: Duration, stage: &str, fraction: f64) {
        let due = now >= QUIET && self.last_drawn.is_none_or(|last| now >= last + PAUSE);
        let Some(terminal) = self.terminal.as_mut().filter(|_| due) else { return };
        let percent = (100.0 * fraction).clamp(0.0, 100.0);
        self.last_drawn = Some(now);
        // Progress that cannot be shown is no reason to stop.
        let _ = write!(terminal, "\r\x1b[K{stage} {percent:.0} %").and_then(|()| terminal.flush());
    }
}

impl<W: Write> Drop for Progress<W> {
    fn drop(&mut self) {
        if let (Some(terminal), Some(_)) = (self.terminal.as_mut(), self.last_drawn) {
            let _ = write!(terminal, "\r\x1b[K").and_then(|()| terminal.flush());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn drawn(reports: &[(u64, f64)]) -> String {
        let mut bytes = Vec::new();
        let mut progress = Progress::new(Some(&mut bytes));
        for (milliseconds, fraction) in reports {
            progress.report_at(Duration::from_millis(*milliseconds), "rings", *fraction);
        }
        drop(progress);
        String::from_utf8(bytes).unwrap()
    }

    #[test]
    fn short_runs_draw_nothing() {
        assert_eq!(drawn(&[(0, 0.0), (500, 0.5), (999, 1.0)]), "");
    }

    #[test]
    fn long_runs_draw_at_intervals_and_clear_the_line() {
        let text = drawn(&[(1000, 0.25), (1050, 0.3), (1100, 0.5), (1200, 7.0)]);
        assert_eq!(text, "\r\x1b[Krings 25 %\r\x1b[Krings 50 %\r\x1b[Krings 100 %\r\x1b[K");
    }
}
