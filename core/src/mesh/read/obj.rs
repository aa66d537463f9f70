//! Wavefront OBJ: `v`, `vt` and `f` records; everything else is passed over.

use super::check::check_vertex_count;
use super::error::{Place, ReadError};
use super::format::MeshFormat;
use super::polygon::{too_few_corners, triangulate};
use super::text::{Token, Tokens, parse_index, quote};
use crate::geometry::{DVec2, DVec3};
use crate::mesh::soup::TriangleSoup;

/// No texture coordinate.
const NONE: u32 = u32::MAX;

/// A corner of a polygon: position and texture index, from 0.
#[derive(Copy, Clone)]
struct Corner {
    v: u32,
    vt: u32,
}

#[derive(Default)]
struct Records {
    positions: Vec<DVec3>,
    texture: Vec<DVec2>,
    corners: Vec<Corner>,
    /// For every polygon the end of its corners and the byte of its record.
    polygons: Vec<(usize, usize)>,
}

pub(super) fn read(bytes: &[u8]) -> Result<TriangleSoup, ReadError> {
    let mut tokens = Tokens::new(bytes, 0, MeshFormat::Obj, true);
    let mut records = Records::default();
    while let Some(word) = tokens.next() {
        match word.text {
            b"v" => records.positions.push(tokens.position_in_line()?),
            b"vt" => records.texture.push(texture_point(&mut tokens)?),
            b"f" => polygon(&mut tokens, word.start, &mut records)?,
            _ => {}
        }
        finish_record(&mut tokens);
    }
    check_vertex_count(MeshFormat::Obj, Place::Whole, records.positions.len())?;
    check_vertex_count(MeshFormat::Obj, Place::Whole, records.texture.len())?;
    check_indices(&tokens, &records)?;
    triangles(&tokens, records)
}

/// Passes over the rest of a record, continued lines included.
fn finish_record(tokens: &mut Tokens) {
    while tokens.next_in_line().is_some() {}
    tokens.skip_line();
}

/// `u [v [w]]`.
fn texture_point(tokens: &mut Tokens) -> Result<DVec2, ReadError> {
    let first = tokens.next_in_line();
    let u = tokens.number(first, "a number (texture u)")?;
    let v = match tokens.next_in_line() {
        Some(second) => tokens.number(Some(second), "a number (texture v)")?,
        None => 0.0,
    };
    Ok(DVec2::new(u, v))
}

fn polygon(tokens: &mut Tokens, at: usize, records: &mut Records) -> Result<(), ReadError> {
    let first = records.corners.len();
    while let Some(token) = tokens.next_in_line() {
        records.corners.push(corner(tokens, token, records)?);
    }
    let n = records.corners.len() - first;
    if n < 3 {
        return Err(too_few_corners(MeshFormat::Obj, tokens.line(at), n));
    }
    records.polygons.push((records.corners.len(), at));
    Ok(())
}

/// `v`, `v/vt`, `v//vn` or `v/vt/vn`.
fn corner(tokens: &Tokens, token: Token, records: &Records) -> Result<Corner, ReadError> {
    let mut parts = token.text.split(|b| *b == b'/');
    let v = parts.next().unwrap_or_default();
    let v = index(tokens, token, v, records.positions.len())?;
    let vt = match parts.next() {
        None | Some(b"") => NONE,
        Some(vt) => index(tokens, token, vt, records.texture.len())?,
    };
    Ok(Corner { v, vt })
}

/// An index from 0; negative ones count back from the last element so far.
fn index(tokens: &Tokens, token: Token, text: &[u8], so_far: usize) -> Result<u32, ReadError> {
    let wrong = |expected: &str| tokens.error(token.start, quote(token.text), expected);
    let from_zero = match parse_index(text) {
        None => return Err(wrong("a corner: v, v/vt, v//vn or v/vt/vn")),
        Some(0) => return Err(wrong("indices from 1 (or negative ones): 0 is not an OBJ index")),
        Some(i) if i > 0 => i - 1,
        Some(i) => match i.checked_add(so_far as i64) {
            Some(i) if i >= 0 => i,
            _ => return Err(wrong(&format!("an index from -{so_far} on: so many came before"))),
        },
    };
    match u32::try_from(from_zero) {
        Ok(i) if i != NONE => Ok(i),
        _ => Err(wrong("an index below 4294967295")),
    }
}

/// Indices may point forward, so they are checked when all is read.
fn check_indices(tokens: &Tokens, records: &Records) -> Result<(), ReadError> {
    let (vertices, textures) = (records.positions.len(), records.texture.len());
    let mut first = 0;
    for &(end, at) in &records.polygons {
        for corner in &records.corners[first..end] {
            let (what, index, count) = if corner.v as usize >= vertices {
                ("vertex", corner.v, vertices)
            } else if corner.vt != NONE && corner.vt as usize >= textures {
                ("texture", corner.vt, textures)
            } else {
                continue;
            };
            let found = format!("{what} index {}", u64::from(index) + 1);
            let expected = format!("at most {count}: that is how many the file has");
            return Err(tokens.error(at, found, &expected));
        }
        first = end;
    }
    Ok(())
}

fn triangles(tokens: &Tokens, records: Records) -> Result<TriangleSoup, ReadError> {
    let textured = records.corners.iter().all(|c| c.vt != NONE);
    let mut faces = Vec::with_capacity(records.polygons.len());
    let mut texture = Vec::new();
    let (mut points, mut cut) = (Vec::new(), Vec::new());
    let mut first = 0;
    for &(end, at) in &records.polygons {
        let corners = &records.corners[first..end];
        points.clear();
        points.extend(corners.iter().map(|c| records.positions[c.v as usize]));
        cut.clear();
        triangulate(&points, &mut cut).map_err(|e| e.at(MeshFormat::Obj, tokens.line(at)))?;
        for triangle in &cut {
            let triangle = triangle.map(|i| corners[i as usize]);
            faces.push(triangle.map(|c| c.v));
            if textured {
                texture.push(triangle.map(|c| records.texture[c.vt as usize]));
            }
        }
        first = end;
    }
    let texture = textured.then_some(texture);
    Ok(TriangleSoup { positions: records.positions, faces, texture })
}
