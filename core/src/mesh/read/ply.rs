//! PLY: ASCII and binary of either byte order, any property types, lists and extra elements.

use super::check::{check_vertex_count, finite};
use super::error::{Place, ReadError};
use super::format::MeshFormat;
use super::polygon::{too_few_corners, triangulate};
use super::text::{Tokens, quote};
use crate::geometry::{DVec3, Shown};
use crate::mesh::soup::TriangleSoup;

#[derive(Copy, Clone, PartialEq)]
enum Encoding {
    Ascii,
    LittleEndian,
    BigEndian,
}

#[derive(Copy, Clone, PartialEq)]
enum Scalar {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

impl Scalar {
    fn from_name(name: &[u8]) -> Option<Self> {
        Some(match name {
            b"char" | b"int8" => Self::I8,
            b"uchar" | b"uint8" => Self::U8,
            b"short" | b"int16" => Self::I16,
            b"ushort" | b"uint16" => Self::U16,
            b"int" | b"int32" => Self::I32,
            b"uint" | b"uint32" => Self::U32,
            b"float" | b"float32" => Self::F32,
            b"double" | b"float64" => Self::F64,
            _ => return None,
        })
    }

    fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }

    /// The value of little-endian bytes, padded to eight; every type fits in an `f64`.
    fn value(self, b: [u8; 8]) -> f64 {
        match self {
            Self::I8 => f64::from(b[0] as i8),
            Self::U8 => f64::from(b[0]),
            Self::I16 => f64::from(i16::from_le_bytes([b[0], b[1]])),
            Self::U16 => f64::from(u16::from_le_bytes([b[0], b[1]])),
            Self::I32 => f64::from(i32::from_le_bytes([b[0], b[1], b[2], b[3]])),
            Self::U32 => f64::from(u32::from_le_bytes([b[0], b[1], b[2], b[3]])),
            Self::F32 => f64::from(f32::from_le_bytes([b[0], b[1], b[2], b[3]])),
            Self::F64 => f64::from_le_bytes(b),
        }
    }
}

/// What a property is to us.
#[derive(Copy, Clone, PartialEq)]
enum Role {
    Axis(usize),
    Corners,
    Ignored,
}

struct Property {
    /// Type of a list's length; `None` for a single value.
    length: Option<Scalar>,
    scalar: Scalar,
    role: Role,
}

struct Element {
    name: Vec<u8>,
    count: u64,
    properties: Vec<Property>,
    /// Byte of its header line.
    at: usize,
}

impl Element {
    /// Fewest bytes that one row can have.
    fn shortest_row(&self, encoding: Encoding) -> usize {
        let least = |p: &Property| match encoding {
            // A digit and a separator.
            Encoding::Ascii => 2,
            _ => p.length.unwrap_or(p.scalar).size(),
        };
        self.properties.iter().map(least).sum()
    }
}

pub(super) fn read(bytes: &[u8]) -> Result<TriangleSoup, ReadError> {
    let mut tokens = Tokens::new(bytes, 0, MeshFormat::Ply, false);
    let (encoding, elements) = header(&mut tokens)?;
    check_roles(&tokens, &elements)?;
    let mut body = Body { bytes, tokens, encoding };
    let mut positions = Vec::new();
    let mut polygons = Polygons::default();
    for element in &elements {
        let row = element.shortest_row(encoding);
        if row == 0 {
            continue;
        }
        body.check_count(element, row)?;
        match element.name.as_slice() {
            b"vertex" => read_vertices(&mut body, element, &mut positions)?,
            b"face" => read_polygons(&mut body, element, &mut polygons)?,
            _ => pass_over(&mut body, element)?,
        }
    }
    body.check_end()?;
    triangles(&body, positions, &polygons)
}

fn header<'a>(tokens: &mut Tokens<'a>) -> Result<(Encoding, Vec<Element>), ReadError> {
    let magic = tokens.next_in_line();
    if magic.is_none_or(|t| t.text != b"ply") {
        return Err(tokens.unexpected(magic, "`ply`"));
    }
    tokens.skip_line();
    let mut encoding = None;
    let mut elements: Vec<Element> = Vec::new();
    loop {
        let word = tokens.next();
        match word.map(|t| t.text) {
            Some(b"format") => encoding = Some(read_encoding(tokens)?),
            Some(b"element") => elements.push(read_element(tokens)?),
            Some(b"property") => {
                let property = read_property(tokens)?;
                match elements.last_mut() {
                    Some(element) => element.properties.push(property),
                    None => return Err(tokens.unexpected(word, "`element` before `property`")),
                }
            }
            Some(b"comment" | b"obj_info") => {}
            Some(b"end_header") => break,
            _ => return Err(tokens.unexpected(word, "`element`, `property` or `end_header`")),
        }
        tokens.skip_line();
    }
    tokens.skip_line();
    let missing = || tokens.error(0, "a header without `format`".into(), "`format ascii 1.0`");
    Ok((encoding.ok_or_else(missing)?, elements))
}

fn read_encoding(tokens: &mut Tokens) -> Result<Encoding, ReadError> {
    let word = tokens.next_in_line();
    match word.map(|t| t.text) {
        Some(b"ascii") => Ok(Encoding::Ascii),
        Some(b"binary_little_endian") => Ok(Encoding::LittleEndian),
        Some(b"binary_big_endian") => Ok(Encoding::BigEndian),
        _ => Err(tokens.unexpected(word, "`ascii`, `binary_little_endian` or `binary_big_endian`")),
    }
}

fn read_element(tokens: &mut Tokens) -> Result<Element, ReadError> {
    let at = tokens.position();
    let name = tokens.next_in_line();
    let Some(text) = name.map(|t| t.text) else {
        return Err(tokens.unexpected(name, "the name of an element"));
    };
    let count = tokens.next_in_line();
    let count = tokens.count(count, "the number of elements")?;
    Ok(Element { name: text.to_vec(), count, properties: Vec::new(), at })
}

fn read_property(tokens: &mut Tokens) -> Result<Property, ReadError> {
    let first = tokens.next_in_line();
    let list = first.is_some_and(|t| t.text == b"list");
    let (length, scalar) = if list {
        (Some(read_scalar(tokens)?), read_scalar(tokens)?)
    } else {
        let named = first.and_then(|t| Scalar::from_name(t.text));
        (None, named.ok_or_else(|| tokens.unexpected(first, "a type such as `float`"))?)
    };
    let name = tokens.next_in_line();
    let Some(name) = name.map(|t| t.text) else {
        return Err(tokens.unexpected(name, "the name of a property"));
    };
    let role = match (list, name) {
        (false, b"x") => Role::Axis(0),
        (false, b"y") => Role::Axis(1),
        (false, b"z") => Role::Axis(2),
        (true, b"vertex_indices" | b"vertex_index") => Role::Corners,
        _ => Role::Ignored,
    };
    Ok(Property { length, scalar, role })
}

fn read_scalar(tokens: &mut Tokens) -> Result<Scalar, ReadError> {
    let word = tokens.next_in_line();
    word.and_then(|t| Scalar::from_name(t.text))
        .ok_or_else(|| tokens.unexpected(word, "a type such as `uchar`"))
}

/// Vertices have x, y and z; faces have corners; both occur once.
fn check_roles(tokens: &Tokens, elements: &[Element]) -> Result<(), ReadError> {
    for (name, wanted, expected) in [
        (
            &b"vertex"[..],
            &[Role::Axis(0), Role::Axis(1), Role::Axis(2)][..],
            "one element `vertex` with the properties x, y and z",
        ),
        (b"face", &[Role::Corners], "one element `face` with a list `vertex_indices`"),
    ] {
        let named: Vec<&Element> = elements.iter().filter(|e| e.name == name).collect();
        let has = |role: &Role| named[0].properties.iter().filter(|p| p.role == *role).count() == 1;
        if named.len() != 1 || !wanted.iter().all(has) {
            let at = named.first().map_or(0, |e| e.at);
            let found = format!("a header with {} such elements or without those", named.len());
            return Err(tokens.error(at, found, expected));
        }
    }
    Ok(())
}

/// Where the values come from.
struct Body<'a> {
    bytes: &'a [u8],
    tokens: Tokens<'a>,
    encoding: Encoding,
}

impl Body<'_> {
    fn place(&self, at: usize) -> Place {
        match self.encoding {
            Encoding::Ascii => self.tokens.line(at),
            _ => Place::Byte(at),
        }
    }

    fn error(&self, at: usize, found: String, expected: &str) -> ReadError {
        let (format, place) = (MeshFormat::Ply, self.place(at));
        ReadError { format, place, found, expected: expected.into() }
    }

    /// Byte of the next value.
    fn at(&mut self) -> usize {
        if self.encoding == Encoding::Ascii {
            self.tokens.skip_blank();
        }
        self.tokens.position()
    }

    fn value(&mut self, scalar: Scalar) -> Result<f64, ReadError> {
        if self.encoding == Encoding::Ascii {
            let token = self.tokens.next();
            let parsed = token.and_then(|t| std::str::from_utf8(t.text).ok()?.parse().ok());
            return parsed.ok_or_else(|| self.tokens.unexpected(token, "a number"));
        }
        let (at, size) = (self.at(), scalar.size());
        let Some(raw) = self.bytes.get(at..at + size) else {
            let found = format!("{} bytes left", self.bytes.len() - at);
            return Err(self.error(at, found, &format!("a value of {size} bytes")));
        };
        let mut b = [0; 8];
        b[..size].copy_from_slice(raw);
        if self.encoding == Encoding::BigEndian {
            b[..size].reverse();
        }
        self.tokens.seek(at + size);
        Ok(scalar.value(b))
    }

    /// A list's length, held against the bytes left.
    fn length(&mut self, scalar: Scalar, items: Scalar) -> Result<usize, ReadError> {
        let at = self.at();
        let length = self.value(scalar)?;
        let item = if self.encoding == Encoding::Ascii { 2 } else { items.size() };
        let left = (self.bytes.len() - self.at() + 1) / item;
        if length >= 0.0 && length.fract() == 0.0 && length <= left as f64 {
            return Ok(length as usize);
        }
        let expected = format!("a whole number up to {left}: more does not fit in the file");
        Err(self.error(at, format!("a list of length {}", Shown(length)), &expected))
    }

    fn check_count(&mut self, element: &Element, row: usize) -> Result<(), ReadError> {
        // The last value of a text file may lack its separator.
        let left = (self.bytes.len() - self.at() + 1) as u64;
        let fits = left / row as u64;
        if element.count <= fits {
            return Ok(());
        }
        let found = format!("{} elements {} announced", element.count, quote(&element.name));
        let expected = format!("at most {fits}: the bytes that follow hold no more");
        Err(self.tokens.error(element.at, found, &expected))
    }

    /// Nothing but blanks may follow the last element.
    fn check_end(&mut self) -> Result<(), ReadError> {
        let from = self.at();
        let rest = &self.bytes[from..];
        let Some(blank) = rest.iter().position(|b| !b.is_ascii_whitespace()) else {
            return Ok(());
        };
        let (at, found) = (from + blank, format!("{} more bytes", rest.len() - blank));
        Err(self.error(at, found, "the end of the file: the header counts less than is there"))
    }
}

fn read_vertices(
    body: &mut Body,
    element: &Element,
    positions: &mut Vec<DVec3>,
) -> Result<(), ReadError> {
    check_vertex_count(MeshFormat::Ply, Place::Whole, element.count as usize)?;
    positions.reserve(element.count as usize);
    for _ in 0..element.count {
        let at = body.at();
        let mut p = [0.0; 3];
        for property in &element.properties {
            match property.role {
                Role::Axis(axis) => p[axis] = body.value(property.scalar)?,
                _ => pass_over_property(body, property)?,
            }
        }
        let position = finite(DVec3::from_array(p)).map_err(|found| {
            let found = format!("{found} of vertex {}", positions.len());
            body.error(at, found, "finite numbers")
        })?;
        positions.push(position);
    }
    Ok(())
}

/// Polygons as they come; faces may stand before the vertices.
#[derive(Default)]
struct Polygons {
    corners: Vec<u32>,
    /// End of the corners and byte of each.
    ends: Vec<(usize, usize)>,
}

fn read_polygons(
    body: &mut Body,
    element: &Element,
    polygons: &mut Polygons,
) -> Result<(), ReadError> {
    polygons.ends.reserve(element.count as usize);
    for _ in 0..element.count {
        let at = body.at();
        let first = polygons.corners.len();
        for property in &element.properties {
            match (property.role, property.length) {
                (Role::Corners, Some(length)) => {
                    for _ in 0..body.length(length, property.scalar)? {
                        let at = body.at();
                        let index = body.value(property.scalar)?;
                        if !(index >= 0.0 && index.fract() == 0.0 && index < f64::from(u32::MAX)) {
                            return Err(body.error(at, format!("{index}"), "a vertex index"));
                        }
                        polygons.corners.push(index as u32);
                    }
                }
                _ => pass_over_property(body, property)?,
            }
        }
        let n = polygons.corners.len() - first;
        if n < 3 {
            return Err(too_few_corners(MeshFormat::Ply, body.place(at), n));
        }
        polygons.ends.push((polygons.corners.len(), at));
    }
    Ok(())
}

fn pass_over(body: &mut Body, element: &Element) -> Result<(), ReadError> {
    for _ in 0..element.count {
        for property in &element.properties {
            pass_over_property(body, property)?;
        }
    }
    Ok(())
}

fn pass_over_property(body: &mut Body, property: &Property) -> Result<(), ReadError> {
    let values = match property.length {
        Some(length) => body.length(length, property.scalar)?,
        None => 1,
    };
    for _ in 0..values {
        body.value(property.scalar)?;
    }
    Ok(())
}

fn triangles(
    body: &Body,
    positions: Vec<DVec3>,
    polygons: &Polygons,
) -> Result<TriangleSoup, ReadError> {
    let mut faces = Vec::with_capacity(polygons.ends.len());
    let (mut points, mut cut) = (Vec::new(), Vec::new());
    let mut first = 0;
    for &(end, at) in &polygons.ends {
        let corners = &polygons.corners[first..end];
        points.clear();
        for &v in corners {
            let Some(&p) = positions.get(v as usize) else {
                let expected = format!("a vertex index below {}", positions.len());
                return Err(body.error(at, format!("vertex index {v}"), &expected));
            };
            points.push(p);
        }
        cut.clear();
        triangulate(&points, &mut cut).map_err(|e| e.at(MeshFormat::Ply, body.place(at)))?;
        faces.extend(cut.iter().map(|t| t.map(|i| corners[i as usize])));
        first = end;
    }
    Ok(TriangleSoup { positions, faces, texture: None })
}
