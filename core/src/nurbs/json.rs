//! A surface from JSON.
//!
//! An object with `degree_u`, `degree_v`, full knot vectors `knots_u`, `knots_v`, and
//! `control_points[i][j] = [x, y, z]` or `[x, y, z, w]`, `i` along u, coordinates not multiplied
//! with the weight; `weights[i][j]` may stand apart. `trim_domain = [u from, u to, v from, v to]`
//! limits the surface to a rectangle of parameters. Other keys are not looked at.

use serde_json::{Map, Value};

use super::error::NurbsError;
use super::surface::{NurbsParts, NurbsSurface};
use crate::geometry::{DVec2, DVec3};

/// Longest piece of a value in a message, characters.
const SHOWN: usize = 40;

/// A surface and the rectangle of its parameters that is meant.
#[derive(Clone, Debug, PartialEq)]
pub struct NurbsFile {
    /// The surface.
    pub surface: NurbsSurface,
    /// Least and greatest parameters, if the file gives them.
    pub trim: Option<(DVec2, DVec2)>,
}

/// Reads a surface; lengths stay in the file's units.
///
/// Memory stays within a small multiple of `bytes.len()`.
///
/// # Errors
/// [`NurbsError`] with the path of the value that does not fit.
pub fn read_json(bytes: &[u8]) -> Result<NurbsFile, NurbsError> {
    let value: Value =
        serde_json::from_slice(bytes).map_err(|error| NurbsError::Json(error.to_string()))?;
    let Value::Object(object) = &value else {
        return Err(unexpected("the file", &value, "an object"));
    };
    let (points, inline) = control_points(object)?;
    let weights = match (object.get("weights"), inline) {
        (None, Some(weights)) => weights,
        (None, None) => Vec::new(),
        (Some(_), Some(_)) => {
            let found = "weights in `weights` and as fourth coordinates".to_owned();
            let expected = "one of the two";
            return Err(NurbsError::Key { place: "weights".into(), found, expected });
        }
        (Some(value), None) => weights(value, &points)?,
    };
    let parts = NurbsParts {
        degree: [degree(object, "degree_u")?, degree(object, "degree_v")?],
        knots: [numbers(object, "knots_u")?, numbers(object, "knots_v")?],
        points,
        weights,
    };
    let surface = NurbsSurface::new(parts)?;
    let trim = match object.get("trim_domain") {
        None | Some(Value::Null) => None,
        Some(_) => Some(trim(&numbers(object, "trim_domain")?, &surface)?),
    };
    Ok(NurbsFile { surface, trim })
}

fn trim(numbers: &[f64], surface: &NurbsSurface) -> Result<(DVec2, DVec2), NurbsError> {
    let &[u0, u1, v0, v1] = numbers else {
        let found = format!("{} numbers", numbers.len());
        let expected = "4 numbers: u from, u to, v from, v to";
        return Err(NurbsError::Key { place: "trim_domain".into(), found, expected });
    };
    let (low, high) = surface.domain();
    let (from, to) = (DVec2::new(u0, v0), DVec2::new(u1, v1));
    // A last digit beyond the domain is rounding.
    let slack = (high - low) * 1e-9;
    let inside = from.cmpge(low - slack).all() && to.cmple(high + slack).all();
    if !(inside && to.cmpgt(from).all()) {
        return Err(NurbsError::TrimDomain { trim: [u0, u1, v0, v1], low, high });
    }
    Ok((from.max(low), to.min(high)))
}

fn unexpected(place: &str, value: &Value, expected: &'static str) -> NurbsError {
    let text = match value {
        Value::Array(items) => format!("an array of {} items", items.len()),
        Value::Object(_) => "an object".to_owned(),
        other => other.to_string(),
    };
    let found = match text.char_indices().nth(SHOWN) {
        Some((end, _)) => format!("{}…", &text[..end]),
        None => text,
    };
    NurbsError::Key { place: place.to_owned(), found, expected }
}

fn get<'a>(
    object: &'a Map<String, Value>,
    key: &str,
    expected: &'static str,
) -> Result<&'a Value, NurbsError> {
    let missing = || NurbsError::Key { place: key.to_owned(), found: "nothing".into(), expected };
    object.get(key).ok_or_else(missing)
}

fn degree(object: &Map<String, Value>, key: &str) -> Result<usize, NurbsError> {
    let expected = "a whole number from 1";
    let value = get(object, key, expected)?;
    let degree = value.as_u64().and_then(|d| usize::try_from(d).ok());
    degree.ok_or_else(|| unexpected(key, value, expected))
}

fn numbers(object: &Map<String, Value>, key: &str) -> Result<Vec<f64>, NurbsError> {
    let expected = "an array of numbers";
    let value = get(object, key, expected)?;
    let items = value.as_array().ok_or_else(|| unexpected(key, value, expected))?;
    items.iter().enumerate().map(|(i, v)| number(v, || format!("{key}[{i}]"))).collect()
}

fn number(value: &Value, place: impl Fn() -> String) -> Result<f64, NurbsError> {
    value.as_f64().ok_or_else(|| unexpected(&place(), value, "a number"))
}

type Grid<T> = Vec<Vec<T>>;

/// Points by u, then v, and their fourth coordinates if they have them.
fn control_points(
    object: &Map<String, Value>,
) -> Result<(Grid<DVec3>, Option<Grid<f64>>), NurbsError> {
    let expected = "an array of rows of points";
    let value = get(object, "control_points", expected)?;
    let rows = value.as_array().ok_or_else(|| unexpected("control_points", value, expected))?;
    let mut points: Grid<DVec3> = Vec::with_capacity(rows.len());
    let mut weights: Grid<f64> = Vec::new();
    let rational = rows.first().and_then(|r| r.get(0)).and_then(Value::as_array);
    let rational = rational.is_some_and(|p| p.len() == 4);
    for (i, row) in rows.iter().enumerate() {
        let items = row
            .as_array()
            .ok_or_else(|| unexpected(&format!("control_points[{i}]"), row, "a row of points"))?;
        let read = |(j, v)| point(v, rational, &|| format!("control_points[{i}][{j}]"));
        let row: Vec<(DVec3, f64)> =
            items.iter().enumerate().map(read).collect::<Result<_, _>>()?;
        points.push(row.iter().map(|(p, _)| *p).collect());
        if rational {
            weights.push(row.iter().map(|(_, w)| *w).collect());
        }
    }
    Ok((points, rational.then_some(weights)))
}

fn point(
    value: &Value,
    rational: bool,
    place: &dyn Fn() -> String,
) -> Result<(DVec3, f64), NurbsError> {
    let expected = if rational { "[x, y, z, w]" } else { "[x, y, z]" };
    let items = value.as_array().filter(|p| p.len() == if rational { 4 } else { 3 });
    let items = items.ok_or_else(|| unexpected(&place(), value, expected))?;
    let at = |k: usize| number(&items[k], place);
    let weight = if rational { at(3)? } else { 1.0 };
    Ok((DVec3::new(at(0)?, at(1)?, at(2)?), weight))
}

/// Weights of the same shape as the points.
fn weights(value: &Value, points: &[Vec<DVec3>]) -> Result<Grid<f64>, NurbsError> {
    let expected = "as many rows of numbers as control_points has";
    let rows = value.as_array().filter(|rows| rows.len() == points.len());
    let rows = rows.ok_or_else(|| unexpected("weights", value, expected))?;
    let mut weights = Vec::with_capacity(rows.len());
    for (i, (row, points)) in rows.iter().zip(points).enumerate() {
        let items = row.as_array().filter(|items| items.len() == points.len());
        let expected = "as many numbers as the row of control_points";
        let items = items.ok_or_else(|| unexpected(&format!("weights[{i}]"), row, expected))?;
        let read = |(j, v)| number(v, || format!("weights[{i}][{j}]"));
        weights.push(items.iter().enumerate().map(read).collect::<Result<_, _>>()?);
    }
    Ok(weights)
}
