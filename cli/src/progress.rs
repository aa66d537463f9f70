//! Progress on a terminal: one line with stage and percentage, for runs longer than a second.

use std::io::{IsTerminal, Write};
use std::sync::mpsc::{self, RecvTimeoutError, Sender};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// Runs shorter than this show no progress.
const QUIET: Duration = Duration::from_secs(1);

/// Time between two updates; less would flicker and cost time, more would look stuck.
const PAUSE: Duration = Duration::from_millis(100);

/// Draws progress on a terminal, and nothing elsewhere.
///
/// A separate thread draws, so that the seconds continue in a stage that reports nothing. The line is cleared when
/// the value is dropped, so that messages start on an empty line.
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

    /// Progress on standard error, if that is a terminal.
    pub fn on_standard_error() -> Self {
        if !std::io::stderr().is_terminal() {
            return Self::hidden();
        }
        let (sender, states) = mpsc::channel();
        let draw = move || {
            let mut line = Line::new(std::io::stderr());
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

/// The line on the terminal.
struct Line<W: Write> {
    terminal: W,
    start: Instant,
    state: Option<State>,
    last_drawn: Option<Duration>,
}

impl<W: Write> Line<W> {
    fn new(terminal: W) -> Self {
        Self { terminal, start: Instant::now(), state: None, last_drawn: None }
    }

    /// Draws, if it is due, `now` after the start.
    fn draw_at(&mut self, now: Duration) {
        let due = now >= QUIET && self.last_drawn.is_none_or(|last| now >= last + PAUSE);
        let Some(State { stage, part }) = self.state.filter(|_| due) else { return };
        let percent = (100.0 * part).clamp(0.0, 100.0);
        // Many stages report their start only.
        let percent = if part > 0.0 { format!(" {percent:.0} %") } else { String::new() };
        self.last_drawn = Some(now);
        let _ = write!(self.terminal, "\r\x1b[K{stage}{percent} ({} s)", now.as_secs())
            .and_then(|()| self.terminal.flush());
    }
}

impl<W: Write> Drop for Line<W> {
    fn drop(&mut self) {
        if self.last_drawn.is_some() {
            let _ = write!(self.terminal, "\r\x1b[K").and_then(|()| self.terminal.flush());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn drawn(reports: &[(u64, f64)]) -> String {
        let mut bytes = Vec::new();
        let mut line = Line::new(&mut bytes);
        for (milliseconds, part) in reports {
            line.state = Some(State { stage: "rings", part: *part });
            line.draw_at(Duration::from_millis(*milliseconds));
        }
        drop(line);
        String::from_utf8(bytes).unwrap()
    }

    #[test]
    fn short_runs_draw_nothing() {
        assert_eq!(drawn(&[(0, 0.0), (500, 0.5), (999, 1.0)]), "");
    }

    #[test]
    fn long_runs_draw_at_intervals_and_clear_the_line() {
        let text = drawn(&[(1000, 0.0), (1050, 0.3), (1100, 0.5), (2200, 7.0)]);
        assert_eq!(
            text,
            "\r\x1b[Krings (1 s)\r\x1b[Krings 50 % (1 s)\r\x1b[Krings 100 % (2 s)\r\x1b[K"
        );
    }
}
