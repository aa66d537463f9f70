//! `evencut tools`: the tools of a library.

use std::path::PathBuf;

use clap::Args;
use evencut_core::job::file::ToolTable;
use evencut_core::job::{LibraryTool, ToolLibrary};

use crate::plan::Failed;
use crate::{Exit, Streams};

/// Widest line that is printed, characters.
const WIDEST: usize = 104;
/// Widest columns of names and kinds, characters.
const NAMES: usize = 28;
const KINDS: usize = 20;

/// Arguments of `evencut tools`.
#[derive(Args)]
pub struct Tools {
    /// Library of tools: toml, fctb, fctl or json
    #[arg(value_name = "FILE")]
    file: PathBuf,
}

impl Tools {
    /// Lists the tools, and which of them cannot be used.
    pub fn run(&self, streams: &mut Streams<'_>) -> Exit {
        match self.library() {
            Ok(library) => {
                streams.data(&listed(&library));
                Exit::Done
            }
            Err(Failed(exit, message)) => {
                streams.message(&message);
                exit
            }
        }
    }

    fn library(&self) -> Result<ToolLibrary, Failed> {
        let failed = |message: String| Failed::file(Exit::BadJob, message, &self.file);
        // A pipe or a device may never end.
        if self.file.exists() && !self.file.is_file() {
            return Err(failed("tools: this is no file".to_owned()));
        }
        let bytes = std::fs::read(&self.file).map_err(|error| failed(format!("tools: {error}")))?;
        ToolLibrary::read(&bytes).map_err(|error| failed(format!("tools: {error}")))
    }
}

/// Headings of the columns; lengths are in mm.
const HEADINGS: [&str; 8] = ["T", "name", "type", "D", "corner", "flutes", "stickout", "holder"];

/// The table of a library, and why tools cannot be used.
fn listed(library: &ToolLibrary) -> String {
    let mut rows = vec![HEADINGS.map(str::to_owned)];
    rows.extend(library.tools.iter().map(row));
    let widths: [usize; 8] = std::array::from_fn(|column| {
        rows.iter().map(|row| row[column].chars().count()).max().unwrap_or(0)
    });
    let mut text = String::new();
    for row in &rows {
        let cells =
            row.iter().zip(widths).enumerate().map(|(column, (cell, width))| match column {
                1 | 2 => format!("{cell:<width$}"),
                _ => format!("{cell:>width$}"),
            });
        text.push_str(cells.collect::<Vec<_>>().join("  ").trim_end());
        text.push('\n');
    }
    text.push_str("lengths in mm; holder: length x largest diameter\n");
    let unusable = library.tools.iter().map(|tool| (tool, tool.faults()));
    let unusable: Vec<_> = unusable.filter(|(_, faults)| !faults.is_empty()).collect();
    if !unusable.is_empty() {
        text.push_str("\ncannot be used:\n");
    }
    for (tool, faults) in unusable {
        let number = tool.number().map_or_else(String::new, |number| format!("T{number} "));
        text.push_str(&wrapped(&format!("{number}{}: {}", tool.name(), faults.join("; "))));
    }
    text
}

fn row(tool: &LibraryTool) -> [String; 8] {
    let ToolTable { diameter, corner_radius, flutes, stickout, holder, .. } = tool.in_mm();
    let holder = holder.filter(|pieces| !pieces.is_empty()).map(|pieces| {
        let length: f64 = pieces.iter().filter_map(|piece| piece.length).sum();
        let ends = pieces.iter().flat_map(|piece| [piece.diameter, piece.upper_diameter]);
        let widest = ends.flatten().fold(0.0, f64::max);
        format!("{} x {}", shown(length), shown(widest))
    });
    let length = |value: Option<f64>| value.map_or_else(|| "-".to_owned(), shown);
    let whole = |value: Option<u32>| value.map_or_else(|| "-".to_owned(), |n| n.to_string());
    [
        whole(tool.number()),
        cut(tool.name(), NAMES),
        cut(&tool.kind, KINDS),
        length(diameter),
        length(corner_radius),
        whole(flutes),
        length(stickout),
        holder.unwrap_or_else(|| "-".to_owned()),
    ]
}

/// A length to a thousandth, without zeros at its end.
fn shown(length: f64) -> String {
    if length.abs() >= 1e4 {
        return format!("{length:.1e}");
    }
    let text = format!("{length:.3}");
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

/// A text of so many characters at most.
fn cut(text: &str, most: usize) -> String {
    if text.chars().count() <= most {
        return text.to_owned();
    }
    text.chars().take(most - 1).chain(['…']).collect()
}

/// A text in lines, indented.
fn wrapped(text: &str) -> String {
    let (mut lines, mut width) = ("  ".to_owned(), 2);
    for (i, word) in text.split_whitespace().enumerate() {
        let length = word.chars().count();
        if i > 0 && width + 1 + length > WIDEST {
            lines.push_str("\n    ");
            width = 4;
        } else if i > 0 {
            lines.push(' ');
            width += 1;
        }
        lines.push_str(word);
        width += length;
    }
    lines.push('\n');
    lines
}
