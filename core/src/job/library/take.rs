//! What a job does not say of its tool, filled in from the library that it names.

use super::choose::{Asked, told};
use super::entry::{self, LibraryTool, mm_in, scaled};
use super::read::ToolLibrary;
use crate::job::beside::{Beside, Load};
use crate::job::document::{self, Document, Places};
use crate::job::fault::Fault;
use crate::job::file::{JobFile, ToolTable, Units};
use crate::job::write::toml_of;
use crate::machine::SpindleDirection;
use crate::tool::ToolKind;

/// Relative difference below which a corner radius is half the diameter: files round them.
const SAME_RADIUS: f64 = 1e-6;

/// Fills in the tool of a document from its library; what is wrong with that is noted.
///
/// `load` gives the library's content. Returns its name and content, where the job names one that can be had.
pub(in crate::job) fn take(
    document: &mut Document,
    load: &mut Load<'_>,
) -> Option<(String, Vec<u8>)> {
    let tool = document.file.tool.clone();
    let Some(library) = tool.library.clone() else {
        if tool.name.is_some() && !document.places.has("tool.library") {
            let fault =
                Fault::new("tool.name", "names a tool of a library, but there is no `library`");
            document.note(
                fault.help("give `tool.library`, the file of the tool, or leave the name out"),
            );
        }
        return None;
    };
    let bytes = match load(Beside::Library, &library) {
        Ok(bytes) => bytes,
        Err(fault) => {
            document.note(fault);
            return None;
        }
    };
    let read = match ToolLibrary::read(&bytes) {
        Ok(read) => read,
        Err(error) => {
            document.note(Fault::new("tool.library", format!("{library}: {error}")));
            return None;
        }
    };
    let is_faulty = |key: &str, is_read: bool| document.places.has(key) && !is_read;
    if is_faulty("tool.name", tool.name.is_some())
        || is_faulty("tool.number", tool.number.is_some())
    {
        return Some((library, bytes));
    }
    let asked = Asked { library: &library, name: tool.name.as_deref(), number: tool.number };
    let filled = asked
        .choose(&read.tools)
        .and_then(|chosen| fill(document, chosen, asked))
        .map_err(|fault| fault.help(format!("`evencut tools {library}` lists its tools")));
    if let Err(fault) = filled {
        document.note(fault);
    }
    Some((library, bytes))
}

/// Fills in a tool.
fn fill(document: &mut Document, chosen: &LibraryTool, asked: Asked<'_>) -> Result<(), Fault> {
    let cannot = |reason: &str| {
        let message = format!("{} of {} cannot be used: {reason}", told(chosen), asked.library);
        Fault::new(asked.key(), message)
    };
    if let Some(reason) = &chosen.refused {
        return Err(cannot(reason));
    }
    let own = document.file.units.unwrap_or(Units::Mm);
    let rest = not_given(&chosen.table, &document.file.tool, &document.places);
    if let Some(reason) = out_of_range(&rest, chosen.units) {
        return Err(cannot(&reason));
    }
    let factor = if own == chosen.units { 1.0 } else { mm_in(chosen.units) / mm_in(own) };
    let tool = &mut document.file.tool;
    let from = scaled(&rest, factor);
    let mut filled = Vec::new();
    merge(&mut tool.kind, from.kind, "kind", &mut filled);
    merge(&mut tool.diameter, from.diameter, "diameter", &mut filled);
    merge(&mut tool.corner_radius, from.corner_radius, "corner_radius", &mut filled);
    merge(&mut tool.flutes, from.flutes, "flutes", &mut filled);
    merge(&mut tool.helix, from.helix, "helix", &mut filled);
    merge(&mut tool.number, from.number, "number", &mut filled);
    merge(&mut tool.length_offset, from.length_offset, "length_offset", &mut filled);
    merge(&mut tool.diameter_offset, from.diameter_offset, "diameter_offset", &mut filled);
    merge(&mut tool.length, from.length, "length", &mut filled);
    merge(&mut tool.shank_diameter, from.shank_diameter, "shank_diameter", &mut filled);
    merge(&mut tool.stickout, from.stickout, "stickout", &mut filled);
    merge(&mut tool.holder, from.holder, "holder", &mut filled);
    merge(&mut tool.clearance, from.clearance, "clearance", &mut filled);
    for key in filled {
        document.places.came_by(&format!("tool.{key}"), asked.key());
    }
    if chosen.is_left_hand && !document.places.has("cut.spindle_direction") {
        document.file.cut.spindle_direction = Some(SpindleDirection::CounterClockwise);
    }
    if document.file.tool.diameter.is_none() && !document.places.has("tool.diameter") {
        return Err(cannot("it has no diameter").help("give `tool.diameter`"));
    }
    Ok(())
}

fn merge<T>(
    own: &mut Option<T>,
    from: Option<T>,
    key: &'static str,
    filled: &mut Vec<&'static str>,
) {
    if from.is_some() {
        *own = from;
        filled.push(key);
    }
}

/// The keys of a tool that the job does not give, nor what would contradict those that it gives.
fn not_given(table: &ToolTable, job: &ToolTable, places: &Places) -> ToolTable {
    let ToolTable { kind, diameter, corner_radius, number, length_offset, diameter_offset, .. } =
        *table;
    let gives = |key: &str| places.has(&format!("tool.{key}"));
    // A ball stays a ball when the job changes its diameter.
    let is_ball = |corner: f64| {
        let radius = 0.5 * diameter.unwrap_or_default();
        kind == Some(ToolKind::Ball) && (corner - radius).abs() <= SAME_RADIUS * radius
    };
    let is_other = gives("kind") && job.kind != kind;
    let corner_radius = corner_radius.filter(|corner| !is_ball(*corner) && !is_other);
    // Offsets that follow the number still do when the job changes it.
    let length_offset = length_offset.filter(|offset| Some(*offset) != number);
    let followed = length_offset.or(number);
    let diameter_offset = diameter_offset.filter(|offset| Some(*offset) != followed);
    let free = |key: &str| !gives(key);
    ToolTable {
        library: None,
        name: None,
        kind: kind.filter(|_| free("kind") && free("corner_radius")),
        diameter: diameter.filter(|_| free("diameter")),
        corner_radius: corner_radius.filter(|_| free("corner_radius")),
        flutes: table.flutes.filter(|_| free("flutes")),
        helix: table.helix.filter(|_| free("helix")),
        number: number.filter(|_| free("number")),
        length_offset: length_offset.filter(|_| free("length_offset")),
        diameter_offset: diameter_offset.filter(|_| free("diameter_offset")),
        length: table.length.filter(|_| free("length")),
        shank_diameter: table.shank_diameter.filter(|_| free("shank_diameter")),
        stickout: table.stickout.filter(|_| free("stickout")),
        gauge_length: table.gauge_length.filter(|_| free("gauge_length")),
        holder: table.holder.clone().filter(|_| free("holder")),
        clearance: table.clearance.filter(|_| free("clearance")),
    }
}

/// The first value that a job may not have, and why.
fn out_of_range(tool: &ToolTable, units: Units) -> Option<String> {
    let file = JobFile { units: Some(units), tool: tool.clone(), ..JobFile::default() };
    let text = match toml_of(&file) {
        Ok(text) => text,
        Err(error) => return Some(error.to_string()),
    };
    let faults = match document::read(text.as_bytes()) {
        Ok(document) => document.faults,
        Err(faults) => faults,
    };
    faults.0.iter().find(|fault| fault.key.starts_with("tool.")).map(entry::told)
}
