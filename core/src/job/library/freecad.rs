//! Tool bits of FreeCAD (`.fctb`), and its lists of them (`.fctl`): JSON.
//!
//! A bit is `{ "name", "shape", "shape-type", "parameter": {...}, "attribute": {...} }`. `shape-type`, else the file name
//! of `shape`, says what it is: `endmill`, `ballend` and `bullnose` (or `torus`) are read, all others refused. Of its parameters
//! are read `Diameter`, `CuttingEdgeHeight`, `ShankDiameter`, `Flutes`, and of a bull end `CornerRadius`, or as older versions
//! wrote it `TorusRadius`, which is the same, or `FlatRadius`, the radius of the flat bottom. Lengths are texts with a unit,
//! `"5.0000 mm"`; a number alone is mm. `SpindleDirection` is `Reverse` for left-hand cutters.
//!
//! A bit has no number, stickout and holder; `Length` is that of the whole tool, of which some is in the holder. A list,
//! `{ "tools": [{ "nr", "path" }, ...] }`, gives numbers to bits, but their geometry stands in the bits' files.
//!
//! # Source
//! The bits and lists in `src/Mod/CAM/Tools` of FreeCAD, its shapes in `src/Mod/CAM/Path/Tool/shape/models`, and what
//! `src/Mod/CAM/Path/Tool/toolbit/migration.py` says of older parameters.

use super::entry::LibraryTool;
use super::json::{no_cutter, shown, text, whole};
use crate::job::file::ToolTable;
use crate::job::units::INCH;
use crate::tool::ToolKind;
use serde_json::Value;

/// Units of length with mm in them.
const UNITS: [(&str, f64); 13] = [
    ("", 1.0),
    ("mm", 1.0),
    ("cm", 10.0),
    ("dm", 100.0),
    ("m", 1000.0),
    ("um", 1e-3),
    ("µm", 1e-3),
    ("in", INCH),
    ("\"", INCH),
    ("ft", 12.0 * INCH),
    ("'", 12.0 * INCH),
    ("thou", 1e-3 * INCH),
    ("mil", 1e-3 * INCH),
];

/// The tool of a bit's file.
pub(super) fn read_bit(bit: &Value) -> LibraryTool {
    let shape = text(bit, "shape-type").or(text(bit, "shape")).unwrap_or("a bit without shape");
    let file = shape.rsplit(['/', '\\']).next().unwrap_or(shape);
    let kind = file.split('.').next().unwrap_or(file).to_ascii_lowercase();
    let mut entry = LibraryTool::new([text(bit, "name")], &kind);
    // Of a bit that is refused the list shows this much.
    entry.table.diameter = length(&bit["parameter"], "Diameter").ok().flatten();
    let family = match kind.as_str() {
        "ballend" => ToolKind::Ball,
        "endmill" => ToolKind::Flat,
        "bullnose" | "torus" => ToolKind::Bull,
        _ => return entry.with(Err(no_cutter(&kind))),
    };
    let turns = |table: &str| bit[table]["SpindleDirection"] == "Reverse";
    entry.is_left_hand = turns("parameter") || turns("attribute");
    entry.with(table_of(bit, family))
}

fn table_of(bit: &Value, kind: ToolKind) -> Result<ToolTable, String> {
    let given = &bit["parameter"];
    let diameter = length(given, "Diameter")?.ok_or("its Diameter is missing")?;
    let flutes = match whole(given, "Flutes")? {
        None => whole(&bit["attribute"], "Flutes")?,
        flutes => flutes,
    };
    let corner_radius = match kind {
        ToolKind::Bull => Some(corner(given, diameter)?),
        ToolKind::Ball | ToolKind::Flat => None,
    };
    Ok(ToolTable {
        kind: Some(kind),
        diameter: Some(diameter),
        corner_radius,
        // FreeCAD writes 0 where nobody has said it.
        flutes: flutes.filter(|flutes| *flutes > 0),
        length: length(given, "CuttingEdgeHeight")?,
        shank_diameter: length(given, "ShankDiameter")?,
        ..ToolTable::default()
    })
}

fn corner(given: &Value, diameter: f64) -> Result<f64, String> {
    for key in ["CornerRadius", "TorusRadius"] {
        if let Some(radius) = length(given, key)? {
            return Ok(radius);
        }
    }
    let flat = length(given, "FlatRadius")?.ok_or("its CornerRadius is missing")?;
    Ok(0.5 * diameter - flat)
}

/// A length, mm.
fn length(given: &Value, key: &str) -> Result<Option<f64>, String> {
    let found = match &given[key] {
        Value::Null => return Ok(None),
        Value::Number(number) => number.as_f64(),
        Value::String(text) => quantity(text),
        _ => None,
    };
    match found {
        Some(length) => Ok(Some(length)),
        None => {
            let value = shown(&given[key]);
            Err(format!("{key} is {value}; it must be a length such as \"5.0 mm\" or \"0.25 in\""))
        }
    }
}

/// A number with a unit, mm; decimals may follow a comma, and inches may be fractions: "1/4 in", "1 1/4 in".
fn quantity(text: &str) -> Option<f64> {
    let text = text.trim();
    let is_part = |c: char| c.is_ascii_digit() || " .,+-/".contains(c);
    let end = text.find(|c| !is_part(c)).unwrap_or(text.len());
    let (number, unit) = text.split_at(end);
    let decimal = |text: &str| text.replace(',', ".").parse::<f64>().ok();
    let fraction = |text: &str| {
        let (over, under) = text.split_once('/')?;
        Some(decimal(over)? / decimal(under)?)
    };
    let number = match *number.split_whitespace().collect::<Vec<_>>() {
        [one] => decimal(one).or_else(|| fraction(one))?,
        [whole, part] => decimal(whole)? + fraction(part)?,
        _ => return None,
    };
    let (_, mm) = UNITS.iter().find(|(name, _)| *name == unit.trim())?;
    Some(number * mm).filter(|length| length.is_finite())
}

/// The bits of a list.
pub(super) fn read_list(tools: &[Value]) -> Vec<LibraryTool> {
    let entry = |tool: &Value| {
        let path = text(tool, "path").unwrap_or_default();
        let mut entry = LibraryTool::new([Some(path)], "bit of a list");
        match whole(tool, "nr") {
            Ok(number) => entry.table.number = number,
            Err(reason) => return entry.with(Err(reason)),
        }
        let bit = entry.name().to_owned();
        entry.with(Err(format!(
            "a list has no geometry: give the file of the bit instead, `library = {bit:?}`, with the path to it"
        )))
    };
    tools.iter().map(entry).collect()
}
