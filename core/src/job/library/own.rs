//! evencut's own libraries: TOML with `[[tool]]` tables that have the keys of a job's `[tool]`, a `name` among them, and
//! `units` at the top, as in a job.

use super::entry::{LibraryTool, told};
use super::error::LibraryError;
use crate::job::document::{read_table, unit_of_length};
use crate::job::file::{ToolTable, Units};
use toml::de::{DeTable, DeValue};

/// Keys at the top.
const KEYS: [&str; 2] = ["units", "tool"];

/// The tools of a file.
///
/// # Errors
/// [`LibraryError`] where it is no TOML, has other keys, or too many tools.
pub(super) fn read(source: &str) -> Result<Vec<LibraryTool>, LibraryError> {
    let starts: Vec<usize> =
        std::iter::once(0).chain(source.match_indices('\n').map(|(i, _)| i + 1)).collect();
    let line = |at: usize| starts.partition_point(|&start| start <= at);
    let said =
        |at: usize, message: &str| LibraryError::syntax(&format!("line {}: {message}", line(at)));
    let document = DeTable::parse(source).map_err(|error| {
        let message = error.message().split_whitespace().collect::<Vec<_>>().join(" ");
        said(error.span().map_or(0, |span| span.start), &message)
    })?;
    let document = document.get_ref();
    if let Some(key) = document.keys().find(|key| !KEYS.contains(&key.get_ref().as_ref())) {
        let name: String = key.get_ref().chars().take(40).collect();
        let rule = "unknown key; a library has `units` and [[tool]] tables";
        return Err(said(key.span().start, &format!("{name}: {rule}")));
    }
    let units = match document.get("units") {
        None => Units::Mm,
        Some(units) => match units.get_ref() {
            DeValue::String(units) if units == "mm" => Units::Mm,
            DeValue::String(units) if units == "inch" => Units::Inch,
            _ => return Err(said(units.span().start, "units: available: \"mm\", \"inch\"")),
        },
    };
    let unit = unit_of_length(document);
    let Some(DeValue::Array(tools)) = document.get("tool").map(|value| value.get_ref()) else {
        return Err(LibraryError::syntax("it is neither JSON nor TOML with [[tool]] tables"));
    };
    LibraryError::unless_few(tools.len())?;
    let entry = |tool: &toml::Spanned<DeValue<'_>>| {
        let DeValue::Table(table) = tool.get_ref() else {
            return LibraryTool::new([None], "").with(Err("it is no table".to_owned()));
        };
        let (mut table, faults) = read_table::<ToolTable>("tool", table, unit);
        let kind = table.kind.map_or("end mill", |kind| kind.name());
        let mut entry = LibraryTool::new([table.name.take().as_deref()], kind);
        entry.units = units;
        entry.refused = match faults.0.first() {
            Some(fault) => {
                let at = fault.span.as_ref().map_or(tool.span().start, |span| span.start);
                Some(format!("line {}: {}", line(at), told(fault)))
            }
            None if table.library.is_some() => Some("library: not in a library".to_owned()),
            None => None,
        };
        entry.table = table;
        entry
    };
    Ok(tools.iter().map(entry).collect())
}
