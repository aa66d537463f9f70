//! What is reported of a job of several operations: each in a line, and their sum.

use super::json;
use super::page::{STYLE, escaped};
use super::plan::{Report, Warning};
use super::record::{FileRecord, Versions};
use super::setup::ProgramFigures;
use serde::Serialize;
use std::fmt::Write;

/// A planned job of several operations.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct OperationsReport {
    /// Version of these keys.
    pub format: u32,
    /// Name of the job.
    pub job: String,
    /// What made the plan.
    pub versions: Versions,
    /// Files that were read.
    pub inputs: Vec<FileRecord>,
    /// The operations, in their order.
    pub operations: Vec<OperationFigures>,
    /// The program of all; null where none is written, or each operation has its own.
    pub program: Option<ProgramFigures>,
    /// Length of all paths, mm.
    pub length_mm: f64,
    /// Time of all on the machine, without changes of the tool, s.
    pub machine_time_s: f64,
    /// How often the tool is changed.
    pub tool_changes: u64,
    /// Whether every limit is kept; null where it was not measured.
    pub passed: Option<bool>,
    /// What is wrong with the program of all, in words.
    pub findings: Vec<String>,
    /// Operations that cut nothing, because nothing was left for them or nothing that a pass fits into, in words.
    pub skipped: Vec<String>,
    /// Files that were written.
    pub outputs: Vec<FileRecord>,
}

/// An operation in figures.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct OperationFigures {
    /// Its number, from 1.
    pub number: u64,
    /// Its name.
    pub name: String,
    /// Whether it only cuts what those before it left.
    pub rest: bool,
    /// Number of its tool.
    pub tool: u64,
    /// Its tool in words.
    pub cutter: String,
    /// The file of its own report.
    pub report: String,
    /// Number of its passes.
    pub passes: u64,
    /// Length of its path, mm.
    pub length_mm: f64,
    /// Time on the machine, s.
    pub machine_time_s: f64,
    /// Limit on the height of what it leaves, mm.
    pub limit_mm: f64,
    /// By how much it may be exceeded, mm; null where it was not measured.
    pub tolerance_mm: Option<f64>,
    /// Largest height left after it where its cutter fits, mm; null where it was not measured.
    pub largest_mm: Option<f64>,
    /// Area where more than the limit is left after it because its cutter does not fit, mm²: for a smaller one.
    pub rest_mm2: Option<f64>,
    /// Whether every limit is kept; null where it was not measured.
    pub passed: Option<bool>,
    /// The limits that are broken, in words.
    pub broken: Vec<String>,
    /// What a reader should know before cutting.
    pub warnings: Vec<Warning>,
}

impl OperationFigures {
    /// Those of a report of its own in the file `file`.
    pub fn of((name, number): (&str, u64), rest: bool, report: &Report, file: &str) -> Self {
        let measured = report.verification.as_ref();
        let tool = report.setup.as_ref().map(|setup| &setup.tool);
        let cutter = |t: &super::setup::SetupTool| {
            let corner = match t.kind.as_str() {
                "bull" => format!(", corner {}", t.corner_radius_mm),
                _ => String::new(),
            };
            // As many decimals as a drawing has.
            let short = |mm: f64| (1e4 * mm).round() / 1e4;
            format!("{} end, {} mm{corner}", t.kind, short(t.diameter_mm))
        };
        Self {
            number,
            name: name.to_owned(),
            rest,
            tool: tool.map_or(0, |t| t.number),
            cutter: tool.map_or_else(String::new, cutter),
            report: file.to_owned(),
            passes: report.passes.count,
            length_mm: report.delivered.length_mm.total,
            machine_time_s: report.delivered.machine_time_s.total,
            limit_mm: report.coverage.cusp_limit_mm,
            tolerance_mm: measured.map(|v| v.scallop.tolerance_mm),
            largest_mm: measured.map(|v| v.scallop.largest_mm),
            rest_mm2: measured.map(|v| v.rest_mm2),
            passed: measured.map(|v| v.passed),
            broken: measured.map_or_else(Vec::new, |v| v.broken.clone()),
            warnings: report.warnings.clone(),
        }
    }
}

/// Headings of the table of operations.
const HEADINGS: [&str; 7] =
    ["operation", "tool", "passes", "path, mm", "time, min:s", "left, µm (allowed)", "rest, mm²"];

impl OperationsReport {
    /// The report as JSON, keys in the order of the types, six significant digits.
    pub fn to_json(&self) -> String {
        json::pretty(self)
    }

    /// One screen of text for a terminal.
    pub fn summary(&self) -> String {
        let mut text = String::new();
        let _ = writeln!(text, "{}", self.job);
        let rows = self.rows();
        let wide = |column: usize| {
            let cells = rows.iter().map(|row| row[column].chars().count());
            cells.fold(HEADINGS[column].chars().count(), usize::max)
        };
        let widths: [usize; 7] = core::array::from_fn(wide);
        for row in core::iter::once(HEADINGS.map(str::to_owned)).chain(rows) {
            let mut line = String::new();
            for (i, (cell, width)) in row.iter().zip(widths).enumerate() {
                // Writing to a string cannot fail.
                let _ = match i {
                    0 | 1 => write!(line, "  {cell:<width$}"),
                    _ => write!(line, "  {cell:>width$}"),
                };
            }
            let _ = writeln!(text, "{}", line.trim_end());
        }
        let _ = writeln!(text, "\n  {}", self.sum());
        for sentence in &self.skipped {
            let _ = writeln!(text, "  {sentence}");
        }
        for operation in &self.operations {
            let number = operation.number;
            for w in &operation.warnings {
                let remedy = match w.remedy.as_str() {
                    "" => String::new(),
                    remedy => format!("; {remedy}"),
                };
                let _ = writeln!(text, "  operation {number}: {}: {}{remedy}", w.stage, w.message);
            }
        }
        text
    }

    /// A page that asks for nothing from outside.
    pub fn to_html(&self) -> String {
        let name = escaped(&self.job);
        let mut html = format!(
            "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
             <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
             <title>{name}</title>\n<style>\n{STYLE}</style>\n</head>\n<body>\n<h1>{name}</h1>\n"
        );
        let count = self.broken().len();
        if count > 0 {
            let limits = if count == 1 { "limit is" } else { "limits are" };
            let _ = writeln!(
                html,
                "<p class=\"warning\"><strong>Do not run this program:</strong> {count} {limits} broken.</p>"
            );
        }
        for sentence in self.broken() {
            let sentence = escaped(&sentence);
            let _ = writeln!(html, "<p class=\"warning\"><strong>broken:</strong> {sentence}</p>");
        }
        let _ = writeln!(html, "<p>{}</p>", escaped(&self.sum()));
        html.push_str("<div class=\"scroll\">\n<table>\n<thead><tr>");
        for heading in HEADINGS {
            let _ = write!(html, "<th>{heading}</th>");
        }
        html.push_str("<th>setup and pictures</th></tr></thead>\n");
        for (operation, row) in self.operations.iter().zip(self.rows()) {
            html.push_str("<tr>");
            for (i, cell) in row.iter().enumerate() {
                let class = if i < 2 { "" } else { " class=\"number\"" };
                let _ = write!(html, "<td{class}>{}</td>", escaped(cell));
            }
            let page = escaped(&operation.report.replace(".json", ".html"));
            let _ = writeln!(html, "<td><a href=\"{page}\">{page}</a></td></tr>");
        }
        html.push_str("</table>\n</div>\n");
        for sentence in &self.skipped {
            let _ = writeln!(html, "<p class=\"warning\">{}</p>", escaped(sentence));
        }
        for operation in &self.operations {
            let number = operation.number;
            for w in &operation.warnings {
                let (stage, message) = (escaped(&w.stage), escaped(&w.message));
                let _ = writeln!(
                    html,
                    "<p class=\"warning\"><strong>operation {number}, {stage}:</strong> {message}</p>"
                );
            }
        }
        let version = escaped(&self.versions.evencut);
        let _ = write!(html, "<p>Made by evencut {version}.</p>\n</body>\n</html>\n");
        html
    }

    /// The limits that are broken, and what is wrong with the program, each with its operation.
    pub fn broken(&self) -> Vec<String> {
        let of = |operation: &OperationFigures| {
            let OperationFigures { name, number, .. } = operation;
            let sentence = |broken: &String| {
                format!("operation {number} ({name}, lines of {number}-toolpath.csv): {broken}")
            };
            operation.broken.iter().map(sentence).collect::<Vec<_>>()
        };
        let operations = self.operations.iter().flat_map(of);
        operations.chain(self.findings.iter().cloned()).collect()
    }

    /// The table of operations.
    fn rows(&self) -> Vec<[String; 7]> {
        let micro = |mm: f64| format!("{:.1}", 1e3 * mm);
        let row = |o: &OperationFigures| {
            let number = o.number;
            let limit = micro(o.limit_mm);
            let allowed = match o.tolerance_mm {
                Some(tolerance) => format!("{limit} + {}", micro(tolerance)),
                None => limit,
            };
            let left = o.largest_mm.map_or_else(|| "-".to_owned(), micro);
            [
                format!("{number} {}{}", o.name, if o.rest { " (rest)" } else { "" }),
                format!("{}: {}", o.tool, o.cutter),
                o.passes.to_string(),
                format!("{:.0}", o.length_mm),
                minutes(o.machine_time_s),
                format!("{left} ({allowed})"),
                o.rest_mm2.map_or_else(|| "-".to_owned(), |area| format!("{area:.2}")),
            ]
        };
        self.operations.iter().map(row).collect()
    }

    fn sum(&self) -> String {
        let changes = match self.tool_changes {
            0 => "no change of the tool".to_owned(),
            1 => "1 change of the tool, which is not in the time".to_owned(),
            n => format!("{n} changes of the tool, which are not in the time"),
        };
        let (length, time) = (self.length_mm, minutes(self.machine_time_s));
        let program = match &self.program {
            Some(p) => format!("; {} for {}, {} blocks", p.file, p.post, p.blocks),
            None => String::new(),
        };
        format!("{length:.0} mm in {time} min:s, {changes}{program}")
    }
}

/// Minutes and seconds.
fn minutes(seconds: f64) -> String {
    let whole = seconds.round() as u64;
    format!("{}:{:02}", whole / 60, whole % 60)
}
