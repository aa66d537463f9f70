//! Progress on standard error, with stage and percentage: on a terminal one line that is drawn again, for runs longer
//! than a second; in a file or pipe a line every few seconds, so that a log shows that the run is alive.

use std::io::{IsTerminal, Write};
use std::sync::mpsc::{self, RecvTimeoutError, Sender};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// Runs shorter than this show no progress.
const QUIET: Duration = Duration::from_secs(1);

/// Time between two updates; less would flicker and cost time, more would look stuck.
const PAUSE: Duration = Duration::from_millis(100);

/// Goes back to the start of the line and clears it.
const CLEARED: &str = "\r\x1b[K";

/// Time between two lines in a log, and before the first.
const LOGGED: Duration = Duration::from_secs(5);

/// Shows progress.
///
/// A separate thread draws, so that the seconds continue in a stage that reports nothing. On a terminal the line is
/// cleared when the value is dropped, so that messages start on an empty line.
pub struct Progress {
    /// `None` where nothing is drawn.
    drawing: Option<(Sender<State>, JoinHandle<()>)>,
}

/// Progress of a run.
#[derive(Copy, Clone)]
struct State {
    stage: &'static str,
    /// Fraction of the stage that is done, 0 to 1.
    part: f64,
}

impl Progress {
    /// Progress that is not shown.
    pub fn hidden() -> Self {
        Self { drawing: None }
    }

    /// Progress on standard error.
    pub fn on_standard_error() -> Self {
        let (sender, states) = mpsc::channel();
        let draw = move || {
            let mut line = Line::new(std::io::stderr(), std::io::stderr().is_terminal());
            loop {
                match states.recv_timeout(PAUSE) {
                    Ok(state) => line.state = Some(state),
                    Err(RecvTimeoutError::Timeout) => {}
                    Err(RecvTimeoutError::Disconnected) => return,
                }
                line.draw_at(line.start.elapsed());
            }
        };
        Self { drawing: Some((sender, std::thread::spawn(draw))) }
    }

    /// Records that `stage` is done to the fraction `part` (0 to 1).
    pub fn report(&mut self, stage: &'static str, part: f64) {
        if let Some((sender, _)) = &self.drawing {
            // Progress that cannot be shown is no reason to stop.
            let _ = sender.send(State { stage, part });
        }
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        if let Some((sender, thread)) = self.drawing.take() {
            drop(sender);
            // The line is cleared before anything else is written.
            let _ = thread.join();
        }
    }
}

/// The line on the terminal, or the lines of a log.
struct Line<W: Write> {
    out: W,
    is_terminal: bool,
    start: Instant,
    state: Option<State>,
    last_drawn: Option<Duration>,
}

impl<W: Write> Line<W> {
    fn new(out: W, is_terminal: bool) -> Self {
        Self { out, is_terminal, start: Instant::now(), state: None, last_drawn: None }
    }

    /// Draws, if it is due, `now` after the start.
    fn draw_at(&mut self, now: Duration) {
        let (quiet, pause) = if self.is_terminal { (QUIET, PAUSE) } else { (LOGGED, LOGGED) };
        let due = now >= quiet && self.last_drawn.is_none_or(|last| now >= last + pause);
        let Some(State { stage, part }) = self.state.filter(|_| due) else { return };
        let percent = (100.0 * part).clamp(0.0, 100.0);
        // Many stages report their start only.
        let percent = if part > 0.0 { format!(" {percent:.0} %") } else { String::new() };
        self.last_drawn = Some(now);
        let (before, after) = if self.is_terminal { (CLEARED, "") } else { ("", "\n") };
        let _ = write!(self.out, "{before}{stage}{percent} ({} s){after}", now.as_secs())
            .and_then(|()| self.out.flush());
    }
}

impl<W: Write> Drop for Line<W> {
    fn drop(&mut self) {
        if self.is_terminal && self.last_drawn.is_some() {
            let _ = write!(self.out, "{CLEARED}").and_then(|()| self.out.flush());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn drawn(is_terminal: bool, reports: &[(u64, f64)]) -> String {
        let mut bytes = Vec::new();
        let mut line = Line::new(&mut bytes, is_terminal);
        for (milliseconds, part) in reports {
            line.state = Some(State { stage: "rings", part: *part });
            line.draw_at(Duration::from_millis(*milliseconds));
        }
        drop(line);
        String::from_utf8(bytes).unwrap()
    }

    #[test]
    fn short_runs_draw_nothing() {
        assert_eq!(drawn(true, &[(0, 0.0), (500, 0.5), (999, 1.0)]), "");
    }

    #[test]
    fn long_runs_draw_at_intervals_and_clear_the_line() {
        let text = drawn(true, &[(1000, 0.0), (1050, 0.3), (1100, 0.5), (2200, 7.0)]);
        assert_eq!(
            text,
            "\r\x1b[Krings (1 s)\r\x1b[Krings 50 % (1 s)\r\x1b[Krings 100 % (2 s)\r\x1b[K"
        );
    }
    #[test]
    fn a_log_gets_a_line_every_five_seconds() {
        assert_eq!(drawn(false, &[(0, 0.0), (4900, 0.5)]), "");
        let text = drawn(false, &[(5000, 0.0), (9000, 0.3), (10100, 0.5)]);
        assert_eq!(text, "rings (5 s)\nrings 50 % (10 s)\n");
    }
}
