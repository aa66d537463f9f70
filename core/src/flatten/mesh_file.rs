//! Reads the triangle meshes of the test data (OBJ, OFF, PLY, binary STL): well-formed files only.

use std::collections::BTreeMap;

/// A mesh as the file gives it, polygons cut into fans.
#[derive(Default)]
pub struct MeshFile {
    pub positions: Vec<[f64; 3]>,
    pub faces: Vec<[u32; 3]>,
    /// Texture coordinates of the corners, when an OBJ file has them.
    pub texture: Vec<[[f64; 2]; 3]>,
}

/// Reads `bytes` by the extension of `name`.
pub fn read(name: &str, bytes: &[u8]) -> MeshFile {
    match name.rsplit('.').next() {
        Some("obj") => obj(&String::from_utf8_lossy(bytes)),
        Some("off") => off(&String::from_utf8_lossy(bytes)),
        Some("ply") => ply(bytes),
        Some("stl") => stl(bytes),
        other => panic!("no reader for {other:?}"),
    }
}

fn numbers<const N: usize>(words: &mut dyn Iterator<Item = &str>) -> [f64; N] {
    std::array::from_fn(|_| words.next().unwrap().parse().unwrap())
}

fn fan(mesh: &mut MeshFile, polygon: &[u32]) {
    for k in 1..polygon.len() - 1 {
        mesh.faces.push([polygon[0], polygon[k], polygon[k + 1]]);
    }
}

fn obj(text: &str) -> MeshFile {
    let mut mesh = MeshFile::default();
    let mut texture = Vec::new();
    for line in text.lines() {
        let mut words = line.split_whitespace();
        match words.next() {
            Some("v") => mesh.positions.push(numbers(&mut words)),
            Some("vt") => texture.push(numbers::<2>(&mut words)),
            Some("f") => {
                let corners: Vec<Vec<u32>> =
                    words.map(|w| w.split('/').map(|i| i.parse().unwrap_or(0)).collect()).collect();
                fan(&mut mesh, &corners.iter().map(|c| c[0] - 1).collect::<Vec<_>>());
                if corners.iter().all(|c| c.len() > 1 && c[1] > 0) {
                    let at = |k: usize| texture[corners[k][1] as usize - 1];
                    for k in 1..corners.len() - 1 {
                        mesh.texture.push([at(0), at(k), at(k + 1)]);
                    }
                }
            }
            _ => {}
        }
    }
    mesh
}

fn off(text: &str) -> MeshFile {
    let mut words = text.split_whitespace().skip(1);
    let [vertices, faces, _] = numbers(&mut words).map(|n: f64| n as usize);
    let positions = (0..vertices).map(|_| numbers(&mut words)).collect();
    let mut mesh = MeshFile { positions, ..MeshFile::default() };
    for _ in 0..faces {
        let [size] = numbers(&mut words);
        let polygon: Vec<u32> =
            (0..size as usize).map(|_| words.next().unwrap().parse().unwrap()).collect();
        fan(&mut mesh, &polygon);
    }
    mesh
}

/// Little-endian binary or ASCII; vertices start with x y z, faces are one list property.
fn ply(bytes: &[u8]) -> MeshFile {
    let end = bytes.windows(11).position(|w| w == b"end_header\n").unwrap() + 11;
    let header = String::from_utf8_lossy(&bytes[..end]).into_owned();
    let mut counts = BTreeMap::new();
    let mut vertex_types = Vec::new();
    let mut list_types = Vec::new();
    let mut element = "";
    for line in header.lines() {
        let words: Vec<&str> = line.split_whitespace().collect();
        match words[..] {
            ["element", name, count] => {
                element = name;
                counts.insert(name, count.parse::<usize>().unwrap());
            }
            ["property", "list", count, index, _] => list_types = vec![count, index],
            ["property", kind, _] if element == "vertex" => vertex_types.push(kind),
            _ => {}
        }
    }
    assert!(header.contains("binary_little_endian"), "only binary PLY");
    let mut at = end;
    let mut number = |kind: &str| {
        let size = match kind {
            "char" | "uchar" | "int8" | "uint8" => 1,
            "short" | "ushort" | "int16" | "uint16" => 2,
            "double" | "float64" => 8,
            _ => 4,
        };
        let raw = &bytes[at..at + size];
        at += size;
        match kind {
            "float" | "float32" => f64::from(f32::from_le_bytes(raw.try_into().unwrap())),
            "double" | "float64" => f64::from_le_bytes(raw.try_into().unwrap()),
            _ => raw.iter().rev().fold(0.0, |n, b| 256.0 * n + f64::from(*b)),
        }
    };
    let mut mesh = MeshFile::default();
    for _ in 0..counts["vertex"] {
        let values: Vec<f64> = vertex_types.iter().map(|t| number(t)).collect();
        mesh.positions.push([values[0], values[1], values[2]]);
    }
    for _ in 0..counts["face"] {
        let size = number(list_types[0]);
        let polygon: Vec<u32> = (0..size as u32).map(|_| number(list_types[1]) as u32).collect();
        fan(&mut mesh, &polygon);
    }
    mesh
}

/// Vertices are welded by exact position.
fn stl(bytes: &[u8]) -> MeshFile {
    let mut mesh = MeshFile::default();
    let mut known = BTreeMap::new();
    for record in bytes[84..].chunks_exact(50) {
        let corner = |k: usize| {
            let at = |c: usize| record[12 + 12 * k + 4 * c..][..4].try_into().unwrap();
            std::array::from_fn::<f32, 3, _>(|c| f32::from_le_bytes(at(c)) + 0.0)
        };
        mesh.faces.push([0, 1, 2].map(|k| {
            let p = corner(k);
            *known.entry(p.map(f32::to_bits)).or_insert_with(|| {
                mesh.positions.push(p.map(f64::from));
                mesh.positions.len() as u32 - 1
            })
        }));
    }
    mesh
}
