//! evencut's own libraries: TOML with `[[tool]]` tables that have the keys of a job's `[tool]`, a `name` among them, and
//! `units` at the top, as in a job.

use super::entry::{LibraryTool, told};
use crate::job::document::{read_tool, unit_of_length};
use crate::job::fault::line_and_column;
use crate::job::file::Units;
use toml::de::{DeTable, DeValue};

/// Keys at the top.
const KEYS: [&str; 2] = ["units", "tool"];

/// The tools of a file, or why there are none.
pub(super) fn read(source: &str) -> Result<Vec<LibraryTool>, String> {
    let line = |at: usize| line_and_column(source, at).0;
    let document = DeTable::parse(source).map_err(|error| {
        let message = error.message().split_whitespace().collect::<Vec<_>>().join(" ");
        format!("line {}: {message}", line(error.span().map_or(0, |span| span.start)))
    })?;
    let document = document.get_ref();
    if let Some(key) = document.keys().find(|key| !KEYS.contains(&key.get_ref().as_ref())) {
        let name: String = key.get_ref().chars().take(40).collect();
        return Err(format!(
            "line {}: {name}: unknown key; a library has `units` and [[tool]] tables",
            line(key.span().start)
        ));
    }
    let units = match document.get("units").map(|value| value.get_ref()) {
        None => Units::Mm,
        Some(DeValue::String(units)) if units == "mm" => Units::Mm,
        Some(DeValue::String(units)) if units == "inch" => Units::Inch,
        Some(_) => return Err("units: available: \"mm\", \"inch\"".to_owned()),
    };
    let unit = unit_of_length(document);
    let Some(DeValue::Array(tools)) = document.get("tool").map(|value| value.get_ref()) else {
        return Err("there is no [[tool]] table".to_owned());
    };
    let entry = |tool: &toml::Spanned<DeValue<'_>>| {
        let DeValue::Table(table) = tool.get_ref() else {
            return LibraryTool::new([None], "").with(Err("it is no table".to_owned()));
        };
        let (mut table, faults) = read_tool(table, unit);
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
