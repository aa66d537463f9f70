//! OFF, ASCII: `OFF`, counts, vertices, polygons; colours and normals are passed over.

use super::check::check_vertex_count;
use super::error::{Place, ReadError};
use super::format::MeshFormat;
use super::polygon::{too_few_corners, triangulate};
use super::text::{Token, Tokens, quote};
use crate::mesh::soup::TriangleSoup;

/// Shortest vertex line: three digits, two blanks and a line end.
const SHORTEST_VERTEX: u64 = 6;
/// Shortest face line: `3 0 1 2`, the last without line end.
const SHORTEST_FACE: u64 = 7;

pub(super) fn read(bytes: &[u8]) -> Result<TriangleSoup, ReadError> {
    let mut tokens = Tokens::new(bytes, 0, MeshFormat::Off, true);
    header(&mut tokens)?;
    let (vertices, faces) = counts(&mut tokens)?;
    let mut soup = TriangleSoup::default();
    soup.positions.reserve(vertices);
    for _ in 0..vertices {
        tokens.skip_blank();
        soup.positions.push(tokens.position_in_line()?);
        tokens.skip_line();
    }
    soup.faces.reserve(faces);
    let (mut corners, mut cut) = (Vec::new(), Vec::new());
    for _ in 0..faces {
        polygon(&mut tokens, vertices, &mut corners)?;
        cut.clear();
        let points: Vec<_> = corners.iter().map(|&v| soup.positions[v as usize]).collect();
        triangulate(&points, &mut cut)
            .map_err(|e| e.at(MeshFormat::Off, tokens.line(tokens.position() - 1)))?;
        soup.faces.extend(cut.iter().map(|t| t.map(|i| corners[i as usize])));
    }
    match tokens.next() {
        None => Ok(soup),
        rest => Err(tokens.unexpected(rest, &format!("the end after {faces} faces"))),
    }
}

/// `OFF`, `COFF`, `NOFF`, `STOFF` and their mixtures, or nothing at all.
fn header(tokens: &mut Tokens) -> Result<(), ReadError> {
    let start = tokens.position();
    let word = tokens.next();
    let Some(token) = word else { return Err(tokens.unexpected(word, "`OFF`")) };
    if token.text[0].is_ascii_digit() && !token.text.ends_with(b"OFF") {
        tokens.seek(start);
        return Ok(());
    }
    let Some(end) = token.text.windows(3).position(|w| w.eq_ignore_ascii_case(b"OFF")) else {
        return Err(tokens.unexpected(word, "`OFF`"));
    };
    if !token.text[..end].iter().all(|b| b"STCN".contains(&b.to_ascii_uppercase())) {
        return Err(tokens.unexpected(word, "three-dimensional `OFF`"));
    }
    // Counts may be glued to the keyword.
    tokens.seek(token.start + end + 3);
    let after = tokens.position();
    match tokens.next_in_line() {
        Some(t) if t.is("BINARY") => {
            let expected = "ASCII OFF: binary OFF is not read, convert the file to PLY";
            Err(tokens.error(t.start, quote(t.text), expected))
        }
        _ => {
            tokens.seek(after);
            Ok(())
        }
    }
}

/// Vertex and face count; the edge count, which many leave out, is ignored.
fn counts(tokens: &mut Tokens) -> Result<(usize, usize), ReadError> {
    let v = tokens.next();
    let vertices = tokens.count(v, "the number of vertices")?;
    let f = tokens.next_in_line();
    let faces = tokens.count(f, "the number of faces")?;
    tokens.skip_line();
    let left = tokens.remaining() as u64 + 1;
    let needed = vertices
        .saturating_mul(SHORTEST_VERTEX)
        .saturating_add(faces.saturating_mul(SHORTEST_FACE));
    if needed > left {
        let found = format!("{vertices} vertices and {faces} faces announced");
        let expected = format!("counts that fit the {} bytes that follow", left - 1);
        let at = v.map_or(0, |t: Token| t.start);
        return Err(tokens.error(at, found, &expected));
    }
    check_vertex_count(MeshFormat::Off, Place::Whole, vertices as usize)?;
    Ok((vertices as usize, faces as usize))
}

/// `n i1 .. in`, then an optional colour.
fn polygon(tokens: &mut Tokens, vertices: usize, corners: &mut Vec<u32>) -> Result<(), ReadError> {
    let first = tokens.next();
    let n = tokens.count(first, "the number of corners of a face")?;
    corners.clear();
    for _ in 0..n {
        let token = tokens.next_in_line();
        let index = tokens.count(token, "a vertex index")?;
        if index >= vertices as u64 {
            let expected = format!("a vertex index below {vertices}");
            return Err(tokens.unexpected(token, &expected));
        }
        corners.push(index as u32);
    }
    if n < 3 {
        let place = tokens.line(first.map_or(0, |t| t.start));
        return Err(too_few_corners(MeshFormat::Off, place, corners.len()));
    }
    tokens.skip_line();
    Ok(())
}
