//! STL: binary, recognised by its length, or ASCII in any spelling.

use super::check::{check_vertex_count, finite};
use super::error::{Place, ReadError};
use super::format::MeshFormat;
use super::text::Tokens;
use crate::geometry::DVec3;
use crate::mesh::soup::TriangleSoup;

const HEADER: usize = 84;
const RECORD: usize = 50;

/// Reads either kind; facet normals are ignored, the corner order says the side.
pub(super) fn read(bytes: &[u8]) -> Result<TriangleSoup, ReadError> {
    if declared_length(bytes) == Some(bytes.len() as u64) {
        return read_binary(bytes);
    }
    // Past this point no binary file is sound; only text that starts with `solid` is.
    if looks_like_text(bytes) { read_ascii(bytes) } else { read_binary(bytes) }
}

/// Length that a binary header's count implies.
fn declared_length(bytes: &[u8]) -> Option<u64> {
    let count: [u8; 4] = bytes.get(HEADER - 4..HEADER)?.try_into().ok()?;
    Some(HEADER as u64 + RECORD as u64 * u64::from(u32::from_le_bytes(count)))
}

fn looks_like_text(bytes: &[u8]) -> bool {
    const SAMPLE: usize = 1024;
    let text = bytes.strip_prefix(&[0xef, 0xbb, 0xbf]).unwrap_or(bytes).trim_ascii_start();
    let solid = text.get(..5).is_some_and(|w| w.eq_ignore_ascii_case(b"solid"));
    solid && !text[..text.len().min(SAMPLE)].contains(&0)
}

fn read_binary(bytes: &[u8]) -> Result<TriangleSoup, ReadError> {
    let format = MeshFormat::Stl;
    let Some(declared) = declared_length(bytes) else {
        let found = format!("{} bytes that do not start with `solid`", bytes.len());
        let expected = "`solid` (ASCII) or a binary header of 84 bytes".into();
        return Err(ReadError { format, place: Place::Whole, found, expected });
    };
    if declared != bytes.len() as u64 {
        let count = (declared - HEADER as u64) / RECORD as u64;
        let (length, body) = (bytes.len(), (bytes.len() - HEADER) as f64 / RECORD as f64);
        return Err(ReadError {
            format,
            place: Place::Byte(HEADER - 4),
            found: format!("a count of {count} triangles in a file with room for {body:.2}"),
            expected: format!(
                "{declared} bytes for that count, not {length}: the file is cut off, damaged or \
                 not an STL file"
            ),
        });
    }
    let (records, _) = bytes[HEADER..].as_chunks::<RECORD>();
    check_vertex_count(format, Place::Byte(HEADER - 4), 3 * records.len())?;
    let mut positions = Vec::with_capacity(3 * records.len());
    for (t, record) in records.iter().enumerate() {
        for corner in 0..3 {
            let at = 12 + 12 * corner;
            let p = finite(position(&record[at..at + 12])).map_err(|found| ReadError {
                format,
                place: Place::Byte(HEADER + RECORD * t + at),
                found: format!("{found} in triangle {t}"),
                expected: "finite numbers".into(),
            })?;
            positions.push(p);
        }
    }
    Ok(unshared(positions))
}

fn position(twelve: &[u8]) -> DVec3 {
    let f = |i: usize| {
        f64::from(f32::from_le_bytes([twelve[i], twelve[i + 1], twelve[i + 2], twelve[i + 3]]))
    };
    DVec3::new(f(0), f(4), f(8))
}

/// A soup in which every face has vertices of its own.
fn unshared(positions: Vec<DVec3>) -> TriangleSoup {
    let faces = (0..positions.len() as u32 / 3).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
    TriangleSoup { positions, faces, texture: None }
}

/// ASCII STL; several solids are one soup, a missing `endsolid` is forgiven.
fn read_ascii(bytes: &[u8]) -> Result<TriangleSoup, ReadError> {
    let mut tokens = Tokens::new(bytes, 0, MeshFormat::Stl, false);
    let mut positions = Vec::new();
    // Byte where the open facet starts.
    let mut facet = None;
    while let Some(word) = tokens.next() {
        match word.text.to_ascii_lowercase().as_slice() {
            b"vertex" if facet.is_some() => positions.push(tokens.position_in_line()?),
            b"facet" => {
                facet = Some((word.start, positions.len()));
                tokens.skip_line();
            }
            b"endloop" => close_facet(&tokens, word.start, facet.take(), &positions)?,
            b"outer" | b"loop" | b"endfacet" => {}
            b"solid" | b"endsolid" => tokens.skip_line(),
            _ => return Err(tokens.unexpected(Some(word), "`facet`, `vertex` or `endsolid`")),
        }
    }
    if let Some((start, _)) = facet {
        let found = "a facet that the end of the file cuts off".into();
        return Err(tokens.error(start, found, "three vertices, `endloop` and `endfacet`"));
    }
    check_vertex_count(MeshFormat::Stl, Place::Whole, positions.len())?;
    Ok(unshared(positions))
}

/// A facet has three vertices, all inside its loop.
fn close_facet(
    tokens: &Tokens,
    at: usize,
    facet: Option<(usize, usize)>,
    positions: &[DVec3],
) -> Result<(), ReadError> {
    let Some((_, first)) = facet else {
        return Err(tokens.error(at, "`endloop` outside of a facet".into(), "`facet`"));
    };
    let corners = positions.len() - first;
    if corners == 3 && first % 3 == 0 {
        return Ok(());
    }
    Err(tokens.error(at, format!("a facet of {corners} vertices"), "3 vertices"))
}
