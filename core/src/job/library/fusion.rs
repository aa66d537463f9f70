//! Libraries of Fusion (Autodesk): JSON as its tool library exports it.
//!
//! `{ "data": [tool, ...], "version": n }`. Of a tool are read:
//!
//! - `description` and `product-id`: its names; `type`: `ball end mill`, `flat end mill` and `bull nose end mill`, all
//!   others are refused; `unit`: `millimeters` or `inches`;
//! - `geometry`, by the letters of ISO 13399 where it has any: `DC` cutting diameter, `RE` corner radius, `NOF` flutes,
//!   `LCF` length of the flutes, `shoulder-length` and `shoulder-diameter` of the neck, `SFDM` shank diameter, `LB` length
//!   below the holder, `HAND` whether it is right-handed;
//! - `post-process`: `number`, `length-offset`, `diameter-offset`, of which 0 is none;
//! - `holder`: `segments`, each `height`, `lower-diameter` and `upper-diameter`, from the cutter upward, in a `unit` of its own.
//!
//! Not read: `start-values` (feeds and speeds are the job's), `shaft` (the shank is a cylinder of `SFDM`), `expressions`
//! (Fusion has written their values beside them).
//!
//! # Source
//! Exports of Fusion in public repositories; there is no published description.

use super::entry::{LibraryTool, mm_in, scaled};
use super::json::{above_zero, no_cutter, number, shown, text, whole};
use crate::job::file::{HolderTable, ToolTable, Units};
use crate::tool::ToolKind;
use serde_json::Value;

/// The tools of `data`.
pub(super) fn read(data: &[Value]) -> Vec<LibraryTool> {
    data.iter().map(read_tool).collect()
}

fn read_tool(tool: &Value) -> LibraryTool {
    let kind = text(tool, "type").unwrap_or("a tool without type");
    let mut entry = LibraryTool::new([text(tool, "description"), text(tool, "product-id")], kind);
    let numbers = match numbers(&tool["post-process"]) {
        Ok(numbers) => numbers,
        Err(reason) => return entry.with(Err(reason)),
    };
    entry.table = numbers.clone();
    entry.units = match units_of(tool) {
        Ok(units) => units.unwrap_or(Units::Mm),
        Err(reason) => return entry.with(Err(reason)),
    };
    // Of a tool that is refused the list shows this much.
    entry.table.diameter = above_zero(&tool["geometry"], "DC").ok().flatten();
    let family = match kind {
        "ball end mill" => ToolKind::Ball,
        "flat end mill" => ToolKind::Flat,
        "bull nose end mill" => ToolKind::Bull,
        _ => return entry.with(Err(no_cutter(kind))),
    };
    entry.is_left_hand = tool["geometry"]["HAND"] == false;
    let holder = holder(&tool["holder"], entry.units);
    let table = holder.and_then(|holder| {
        let cutter = cutter(&tool["geometry"], family)?;
        Ok(ToolTable {
            number: numbers.number,
            length_offset: numbers.length_offset,
            diameter_offset: numbers.diameter_offset,
            holder,
            ..cutter
        })
    });
    entry.with(table)
}

/// Numbers of the tool and of its offsets.
fn numbers(post: &Value) -> Result<ToolTable, String> {
    let given = |key| Ok::<_, String>(whole(post, key)?.filter(|number| *number > 0));
    Ok(ToolTable {
        number: given("number")?,
        length_offset: given("length-offset")?,
        diameter_offset: given("diameter-offset")?,
        ..ToolTable::default()
    })
}

fn units_of(object: &Value) -> Result<Option<Units>, String> {
    match object["unit"].as_str() {
        Some("millimeters") => Ok(Some(Units::Mm)),
        Some("inches") => Ok(Some(Units::Inch)),
        None if object["unit"].is_null() => Ok(None),
        _ => Err(format!("unit is {}; known: millimeters, inches", shown(&object["unit"]))),
    }
}

fn cutter(geometry: &Value, kind: ToolKind) -> Result<ToolTable, String> {
    let length = |key| above_zero(geometry, key);
    let diameter = length("DC")?.ok_or("its cutting diameter (DC) is missing")?;
    let corner_radius = length("RE")?;
    if kind == ToolKind::Bull && corner_radius.is_none() {
        return Err("its corner radius (RE) is missing".to_owned());
    }
    let stickout = length("LB")?;
    // A neck that is no wider than the cutter is below the shank.
    let neck = length("shoulder-length")?;
    let is_slim = length("shoulder-diameter")?.is_none_or(|neck| neck <= diameter);
    let reach = neck.filter(|_| is_slim).into_iter().chain(length("LCF")?).reduce(f64::max);
    // Flutes may go on into the holder.
    let length_below = reach.map(|reach| stickout.map_or(reach, |below| reach.min(below)));
    Ok(ToolTable {
        kind: Some(kind),
        diameter: Some(diameter),
        corner_radius,
        flutes: whole(geometry, "NOF")?.filter(|flutes| *flutes > 0),
        length: length_below,
        shank_diameter: length("SFDM")?,
        stickout,
        ..ToolTable::default()
    })
}

/// The pieces of a holder, in the unit of its tool.
fn holder(holder: &Value, units: Units) -> Result<Option<Vec<HolderTable>>, String> {
    let Some(segments) = holder["segments"].as_array() else { return Ok(None) };
    let own = units_of(holder)?.unwrap_or(units);
    let mut pieces = Vec::new();
    for segment in segments {
        let diameter = number(segment, "lower-diameter")?;
        let upper = number(segment, "upper-diameter")?;
        let piece = HolderTable {
            diameter,
            upper_diameter: upper.filter(|upper| Some(*upper) != diameter),
            length: number(segment, "height")?,
        };
        // A step is two pieces of different width.
        if piece.length != Some(0.0) {
            pieces.push(piece);
        }
    }
    let table =
        ToolTable { holder: (!pieces.is_empty()).then_some(pieces), ..ToolTable::default() };
    let factor = if own == units { 1.0 } else { mm_in(own) / mm_in(units) };
    Ok(scaled(&table, factor).holder)
}
