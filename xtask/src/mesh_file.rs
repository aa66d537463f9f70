//! Writers for the shipped meshes; same triangles, same bytes.

use evencut_core::mesh::TriangleSoup;
use std::fmt::Write;

/// Binary STL: unwelded, 50 bytes a face, normals from the corners.
pub fn stl(mesh: &TriangleSoup) -> Vec<u8> {
    let mut out = vec![0u8; 80];
    out.extend((mesh.faces.len() as u32).to_le_bytes());
    for face in &mesh.faces {
        let [a, b, c] = face.map(|v| mesh.positions[v as usize]);
        let normal = (b - a).cross(c - a).normalize_or_zero();
        for p in [normal, a, b, c] {
            out.extend(p.to_array().iter().flat_map(|&x| (x as f32).to_le_bytes()));
        }
        out.extend([0u8; 2]);
    }
    out
}

/// Binary little-endian PLY with float coordinates.
pub fn ply(mesh: &TriangleSoup) -> Vec<u8> {
    let mut out = format!(
        "ply\nformat binary_little_endian 1.0\nelement vertex {}\nproperty float x\n\
         property float y\nproperty float z\nelement face {}\n\
         property list uchar int vertex_indices\nend_header\n",
        mesh.positions.len(),
        mesh.faces.len()
    )
    .into_bytes();
    for p in &mesh.positions {
        out.extend(p.to_array().iter().flat_map(|&x| (x as f32).to_le_bytes()));
    }
    for face in &mesh.faces {
        out.push(3);
        out.extend(face.iter().flat_map(|&v| (v as i32).to_le_bytes()));
    }
    out
}

/// Wavefront OBJ with four decimals (0.1 µm).
pub fn obj(mesh: &TriangleSoup) -> Vec<u8> {
    let mut out = String::new();
    for p in &mesh.positions {
        // Adding zero turns -0.0 into 0.0; writing to a string cannot fail.
        let _ = writeln!(out, "v {:.4} {:.4} {:.4}", p.x + 0.0, p.y + 0.0, p.z + 0.0);
    }
    for [a, b, c] in &mesh.faces {
        let _ = writeln!(out, "f {} {} {}", a + 1, b + 1, c + 1);
    }
    out.into_bytes()
}

#[cfg(test)]
mod tests {
    use super::*;
    use evencut_core::geometry::DVec3;

    #[test]
    fn sizes_follow_the_counts() {
        let mesh = TriangleSoup {
            positions: vec![DVec3::ZERO, DVec3::X, DVec3::Y],
            faces: vec![[0, 1, 2]],
            texture: None,
        };
        assert_eq!(stl(&mesh).len(), 84 + 50);
        let (binary, header_end) = (ply(&mesh), b"end_header\n");
        let header = binary.windows(11).position(|w| w == header_end).unwrap() + 11;
        assert_eq!(binary.len() - header, 3 * 12 + 13);
        assert_eq!(
            obj(&mesh),
            b"v 0.0000 0.0000 0.0000\nv 1.0000 0.0000 0.0000\nv 0.0000 1.0000 0.0000\nf 1 2 3\n"
        );
    }
}
