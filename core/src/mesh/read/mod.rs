//! Mesh files from bytes: STL, OBJ, PLY, OFF → [`TriangleSoup`].
//!
//! A header's counts are held against the bytes present before anything is allocated, and every
//! fault is reported with its line or byte offset.

mod check;
mod error;
mod format;
mod obj;
mod off;
mod ply;
mod polygon;
mod stl;
mod text;

pub use error::{Place, ReadError};
pub use format::MeshFormat;

use super::soup::TriangleSoup;

/// Reads a mesh file.
///
/// Coordinates stay in the file's units. Polygons are cut into triangles. Memory stays within a
/// small multiple of `bytes.len()`, whatever the header says.
///
/// # Errors
/// [`ReadError`] if the bytes are not a complete file of that format with at least one face, or
/// if a coordinate is not a finite number.
pub fn read(bytes: &[u8], format: MeshFormat) -> Result<TriangleSoup, ReadError> {
    let whole = |found: String, expected: &str| ReadError {
        format,
        place: Place::Whole,
        found,
        expected: expected.into(),
    };
    if bytes.is_empty() {
        return Err(whole("an empty file (0 bytes)".into(), "a mesh with at least one face"));
    }
    if bytes.starts_with(&[0xfe, 0xff]) || bytes.starts_with(&[0xff, 0xfe]) {
        return Err(whole("UTF-16 text".into(), "plain ASCII or UTF-8: save the file as UTF-8"));
    }
    let soup = match format {
        MeshFormat::Stl => stl::read(bytes),
        MeshFormat::Obj => obj::read(bytes),
        MeshFormat::Ply => ply::read(bytes),
        MeshFormat::Off => off::read(bytes),
    }?;
    if soup.faces.is_empty() {
        let found = format!("{} vertices and no face", soup.positions.len());
        return Err(whole(found, "at least one face"));
    }
    Ok(soup)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{DVec2, DVec3};

    fn message(bytes: &[u8], format: MeshFormat) -> String {
        read(bytes, format).unwrap_err().to_string()
    }

    fn binary_stl(header: &str, announced: u32, triangles: usize) -> Vec<u8> {
        let mut bytes = format!("{header:80}").into_bytes();
        bytes.extend(announced.to_le_bytes());
        for t in 0..triangles {
            let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, t as f32]];
            bytes.extend([0; 12]);
            bytes.extend(corners.iter().flatten().flat_map(|c| c.to_le_bytes()));
            bytes.extend([0; 2]);
        }
        bytes
    }

    #[test]
    fn a_binary_stl_may_call_itself_solid_but_must_count_right() {
        let soup = read(&binary_stl("solid facet", 2, 2), MeshFormat::Stl).unwrap();
        assert_eq!(soup.faces, [[0, 1, 2], [3, 4, 5]]);
        assert_eq!(soup.positions[5], DVec3::new(0.0, 1.0, 1.0));
        for announced in [1, 3, u32::MAX] {
            let text = message(&binary_stl("solid", announced, 2), MeshFormat::Stl);
            assert!(text.contains(&format!("a count of {announced} triangles")), "{text}");
            assert!(text.contains("room for 2.00"), "{text}");
        }
    }

    #[test]
    fn an_ascii_stl_with_a_facet_of_four_vertices_is_refused() {
        let text = "solid\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\n\
                    vertex 1 1 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid\n";
        let text = message(text.as_bytes(), MeshFormat::Stl);
        assert_eq!(
            text,
            "mesh: STL file, line 8: found a facet of 4 vertices; expected 3 vertices"
        );
    }

    #[test]
    fn an_obj_keeps_texture_across_continued_lines_and_forward_references() {
        let text = "f 1/1 2/2 \\\n 3/3 -1/4 # not yet there\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";
        let error = message(text.as_bytes(), MeshFormat::Obj);
        assert!(error.contains("line 2") && error.contains("-1/4"), "{error}");
        let text = format!("{}vt 0 0\nvt 2 0\nvt 2 2\nvt 0 2\n", text.replace("-1/4", "4/4"));
        let soup = read(text.as_bytes(), MeshFormat::Obj).unwrap();
        assert_eq!(soup.faces, [[0, 1, 2], [0, 2, 3]]);
        let texture = soup.texture.unwrap();
        assert_eq!(texture[1], [DVec2::ZERO, DVec2::splat(2.0), DVec2::new(0.0, 2.0)]);
    }

    #[test]
    fn a_ply_with_more_than_it_counts_is_refused() {
        let header = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\n\
                      property float y\nproperty float z\nelement face 1\n\
                      property list uchar int vertex_indices\nend_header\n";
        let body = "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
        assert!(read(format!("{header}{body}").as_bytes(), MeshFormat::Ply).is_ok());
        let text = message(format!("{header}{body}3 0 1 2\n").as_bytes(), MeshFormat::Ply);
        assert!(text.contains("line 14") && text.contains("counts less"), "{text}");
        let text = message(format!("{header}{}", &body[..20]).as_bytes(), MeshFormat::Ply);
        assert!(text.contains("line 13") && text.contains("list of length 3"), "{text}");
    }

    #[test]
    fn a_ply_cannot_announce_what_does_not_fit() {
        let text = "ply\nformat binary_little_endian 1.0\nelement vertex 4000000000\n\
                    property float x\nproperty float y\nproperty float z\nelement face 1\n\
                    property list uint int vertex_indices\nend_header\nxxxx";
        let text = message(text.as_bytes(), MeshFormat::Ply);
        assert!(text.contains("line 3") && text.contains("4000000000 elements"), "{text}");
    }

    #[test]
    fn an_off_may_lack_its_edge_count_and_carry_colours() {
        let text = "COFF\n# made up\n4 1\n0 0 0 255 0 0\n\n1 0 0 255 0 0\n1 1 0 1 1 1\n\
                    0 1 0 0 0 0\n4 0 1 2 3 0.5 0.5 0.5";
        let soup = read(text.as_bytes(), MeshFormat::Off).unwrap();
        assert_eq!(soup.faces, [[0, 1, 2], [0, 2, 3]]);
        let text = message(text.replace("4 0 1 2 3", "4 0 1 2 4").as_bytes(), MeshFormat::Off);
        assert!(text.contains("line 9") && text.contains("below 4"), "{text}");
    }
}
