//! What is wrong with a job file, shown at the place where it is written.

use crate::geometry::OrderBy;
use std::fmt::Write;
use std::ops::Range;

/// One thing that is wrong, or worth a warning.
#[derive(Clone, Debug, PartialEq)]
pub struct Fault {
    /// Dotted key it concerns, as `cut.feed`; empty for the whole file.
    pub key: String,
    /// What was found and why it cannot stay.
    pub message: String,
    /// What is allowed or what to do, a line each.
    pub help: Vec<String>,
    /// Bytes of the source it concerns; `None` if nothing in the file is to be pointed at.
    pub span: Option<Range<usize>>,
}

impl Fault {
    /// A fault of `key` without a place.
    pub(super) fn new(key: impl Into<String>, message: impl Into<String>) -> Self {
        Self { key: key.into(), message: message.into(), help: Vec::new(), span: None }
    }

    /// Adds a line of help.
    pub(super) fn help(mut self, line: impl Into<String>) -> Self {
        self.help.push(line.into());
        self
    }

    /// Sets the place.
    pub(super) fn at(mut self, span: Option<Range<usize>>) -> Self {
        self.span = span;
        self
    }
}

/// All that is wrong with a job file, in the order of the file.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct Faults(pub Vec<Fault>);

/// How grave a list of faults is.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum Severity {
    /// The job cannot be planned.
    Error,
    /// The job can be planned, but look again.
    Warning,
}

impl Severity {
    fn label(self) -> &'static str {
        match self {
            Severity::Error => "error",
            Severity::Warning => "warning",
        }
    }
}

impl Faults {
    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// The same faults, pointing at nothing.
    pub(super) fn without_places(mut self) -> Self {
        self.0.iter_mut().for_each(|fault| fault.span = None);
        self
    }

    /// Puts the faults in the order of the file; those without a place come last.
    pub(super) fn sort(&mut self) {
        self.0.order_by_key(|f| f.span.as_ref().map_or((usize::MAX, 0), |s| (s.start, s.end)));
    }

    /// The faults as text: message, file, line, column, the source line with carets, and help.
    ///
    /// `source`: the bytes that were read. No colours; control characters of the source are shown
    /// as `?`, long lines around the place only.
    pub fn render(&self, file_name: &str, source: &[u8]) -> String {
        self.render_as(Severity::Error, file_name, source)
    }

    /// As [`Faults::render`], under the given heading.
    pub fn render_as(&self, severity: Severity, file_name: &str, source: &[u8]) -> String {
        let text = String::from_utf8_lossy(source);
        let mut out = String::new();
        for fault in self.0.iter().take(RENDERED) {
            render_one(&mut out, fault, severity, file_name, &text);
        }
        if self.0.len() > RENDERED {
            // Writing to a string cannot fail.
            let _ = writeln!(out, "and {} more", self.0.len() - RENDERED);
        }
        out
    }
}

/// Faults that are rendered; who has more sees the rest after mending these.
const RENDERED: usize = 100;

/// Line and column, both from 1, of a byte of `source`; columns count characters.
pub fn line_and_column(source: &str, byte: usize) -> (usize, usize) {
    let byte = floor_boundary(source, byte);
    let before = &source[..byte];
    let line_start = start_of_line(source, byte);
    (before.matches('\n').count() + 1, source[line_start..byte.max(line_start)].chars().count() + 1)
}

/// First byte of the line that holds `byte`; a byte order mark is not part of the first line.
fn start_of_line(source: &str, byte: usize) -> usize {
    let mark = if source.starts_with('\u{feff}') { '\u{feff}'.len_utf8() } else { 0 };
    source[..byte].rfind('\n').map_or(mark, |i| i + 1)
}

fn floor_boundary(source: &str, byte: usize) -> usize {
    let mut byte = byte.min(source.len());
    while !source.is_char_boundary(byte) {
        byte -= 1;
    }
    byte
}

fn render_one(out: &mut String, fault: &Fault, severity: Severity, file: &str, source: &str) {
    let colon = if fault.key.is_empty() { "" } else { ": " };
    let (label, key) = (severity.label(), printable(&fault.key));
    // Writing to a string cannot fail.
    let _ = writeln!(out, "{label}: {key}{colon}{}", printable(&fault.message));
    let gutter = match &fault.span {
        Some(span) => render_place(out, span, file, source),
        None => {
            let _ = writeln!(out, " --> {file}");
            1
        }
    };
    for line in &fault.help {
        let _ = writeln!(out, "{:gutter$} = {}", "", printable(line));
    }
    out.push('\n');
}

/// Writes the arrow, the source line and the carets; returns the gutter's width.
fn render_place(out: &mut String, span: &Range<usize>, file: &str, source: &str) -> usize {
    let start = floor_boundary(source, span.start);
    let start = start.max(start_of_line(source, start));
    let end = floor_boundary(source, span.end.max(start));
    let (line, column) = line_and_column(source, start);
    let line_start = start_of_line(source, start);
    let line_end = source[start..].find('\n').map_or(source.len(), |i| start + i);
    let text = source[line_start..line_end].trim_end_matches('\r');
    let last = end.min(line_start + text.len());
    let carets = source.get(start..last).map_or(0, |s| s.chars().count()).max(1);

    let (shown, before, carets) = window(text, column - 1, carets);
    let gutter = line.to_string().len();
    let _ = writeln!(out, "{:gutter$}--> {file}:{line}:{column}", "");
    let _ = writeln!(out, "{:gutter$} |", "");
    let _ = writeln!(out, "{line} | {}", shown.trim_end());
    let _ = writeln!(out, "{:gutter$} | {:before$}{}", "", "", "^".repeat(carets));
    gutter
}

/// Widest piece of a source line that is shown, in characters.
const SHOWN: usize = 100;

/// The piece of a line around the carets, with the carets' place in it.
fn window(line: &str, before: usize, carets: usize) -> (String, usize, usize) {
    let total = line.chars().count();
    let from = if total <= SHOWN { 0 } else { before.saturating_sub(SHOWN / 3) };
    let piece: String = line.chars().skip(from).take(SHOWN).collect();
    let lead = if from > 0 { "…" } else { "" };
    let tail = if from + SHOWN < total { "…" } else { "" };
    let at = before - from + lead.chars().count();
    (format!("{lead}{}{tail}", printable(&piece)), at, carets.min(SHOWN - (before - from)).max(1))
}

/// Tabs as spaces and other control characters as `?`, one character each.
fn printable(text: &str) -> String {
    text.chars()
        .map(|c| match c {
            '\t' => ' ',
            c if c.is_control() => '?',
            c => c,
        })
        .collect()
}
