//! Standard output and error of a run.

use std::io::{ErrorKind, Write};

use crate::Exit;

/// Where a command writes: data and messages.
///
/// A reader that closes the pipe (`evencut schema | head`) ends the data without a message.
pub struct Streams<'a> {
    out: &'a mut dyn Write,
    err: &'a mut dyn Write,
    colour: bool,
    failure: Option<std::io::Error>,
}

impl<'a> Streams<'a> {
    /// Writes data to `out` and messages to `err`, the latter in colour if `colour` is set.
    pub fn new(out: &'a mut dyn Write, err: &'a mut dyn Write, colour: bool) -> Self {
        Self { out, err, colour, failure: None }
    }

    /// Writes data; after a failure, nothing more is written.
    pub fn data(&mut self, text: &str) {
        if self.failure.is_none() {
            self.failure = self.out.write_all(text.as_bytes()).err();
        }
    }

    /// Writes a message.
    pub fn message(&mut self, text: &str) {
        let painted = if self.colour { paint(text) } else { text.to_owned() };
        // Where standard error is closed there is nobody to tell.
        let _ = self.err.write_all(painted.as_bytes());
    }

    /// Flushes, and turns data that could not be written into [`Exit::Internal`].
    pub fn finish(&mut self, exit: Exit) -> Exit {
        if self.failure.is_none() {
            self.failure = self.out.flush().err();
        }
        match self.failure.take() {
            Some(error) if error.kind() != ErrorKind::BrokenPipe => {
                self.message(&format!("error: standard output: {error}\n"));
                exit.max(Exit::Internal)
            }
            _ => exit,
        }
    }
}

const BOLD_RED: &str = "\x1b[1;31m";
const BOLD_YELLOW: &str = "\x1b[1;33m";
const RESET: &str = "\x1b[0m";

/// Colours the headings and carets of rendered faults.
fn paint(text: &str) -> String {
    let mut colour = BOLD_RED;
    text.split_inclusive('\n')
        .map(|line| {
            for (heading, of_heading) in [("error", BOLD_RED), ("warning", BOLD_YELLOW)] {
                if let Some(rest) = line.strip_prefix(heading).filter(|r| r.starts_with(':')) {
                    colour = of_heading;
                    return format!("{colour}{heading}{RESET}{rest}");
                }
            }
            let body = line.trim_end_matches('\n');
            match body.trim_start_matches([' ', '|']) {
                carets if !carets.is_empty() && carets.bytes().all(|b| b == b'^') => {
                    let before = &body[..body.len() - carets.len()];
                    format!("{before}{colour}{carets}{RESET}\n")
                }
                _ => line.to_owned(),
            }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    struct Broken(ErrorKind);

    impl Write for Broken {
        fn write(&mut self, _: &[u8]) -> std::io::Result<usize> {
            Err(self.0.into())
        }
        fn flush(&mut self) -> std::io::Result<()> {
            Ok(())
        }
    }

    fn exit_after(kind: ErrorKind) -> (Exit, String) {
        let mut messages = Vec::new();
        let mut out = Broken(kind);
        let mut streams = Streams::new(&mut out, &mut messages, false);
        streams.data("data");
        let exit = streams.finish(Exit::Done);
        (exit, String::from_utf8(messages).unwrap())
    }

    #[test]
    fn a_reader_that_goes_away_is_no_error() {
        assert_eq!(exit_after(ErrorKind::BrokenPipe), (Exit::Done, String::new()));
        let (exit, message) = exit_after(ErrorKind::StorageFull);
        assert_eq!(exit, Exit::Internal);
        assert!(message.starts_with("error: standard output: "), "{message}");
    }

    #[test]
    fn headings_and_carets_are_coloured() {
        let text = "warning: cut: x\n  | a^\n  |  ^^\n";
        let expected =
            format!("{BOLD_YELLOW}warning{RESET}: cut: x\n  | a^\n  |  {BOLD_YELLOW}^^{RESET}\n");
        assert_eq!(paint(text), expected);
    }
}
