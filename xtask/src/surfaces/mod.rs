//! The surfaces that ship with the project, each from a published definition, mm, +Z up.

mod blade;
mod blisk;
mod crown;
pub mod franke;
pub mod revolved;
mod saddle;
mod wigley;

use crate::mesh_file;
use crate::triangulate::PlaneMesh;
use evencut_core::geometry::{DVec2, DVec3};
use evencut_core::mesh::TriangleSoup;

/// File names and contents of all shipped surfaces.
pub fn all() -> Result<Vec<(&'static str, Vec<u8>)>, String> {
    Ok(vec![
        ("wigley-hull.ply", mesh_file::ply(&wigley::half_hull()?)),
        ("franke-mould.ply", mesh_file::ply(&franke::mould()?)),
        ("naca-blade.ply", mesh_file::ply(&blade::pressure_side()?)),
        ("saddle-island.obj", mesh_file::obj(&saddle::patch_with_island()?)),
        ("crowned-block.stl", mesh_file::stl(&crown::block()?)),
        ("dome.json", revolved::dome()),
        ("blisk-hub.json", blisk::hub()),
        ("blisk-fillet.json", blisk::fillet()),
        ("blisk-blade.json", blisk::blade_surface()),
    ])
}

/// The plane mesh lifted point by point; orientation is kept.
fn lifted(plane: &PlaneMesh, lift: impl Fn(DVec2) -> DVec3) -> TriangleSoup {
    TriangleSoup {
        positions: plane.points.iter().map(|&p| lift(p)).collect(),
        faces: plane.faces.clone(),
        texture: None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use evencut_core::mesh::{Connectivity, VertexId};

    /// Largest committed file, bytes.
    const LARGEST: usize = 700_000;

    #[test]
    fn committed_files_are_what_the_generator_writes() {
        for (name, bytes) in all().unwrap() {
            let committed = std::fs::read(crate::surfaces_folder().join(name)).unwrap();
            assert!(committed == bytes, "{name} differs: run `cargo xtask surfaces`");
            assert!(bytes.len() < LARGEST, "{name}: {} bytes", bytes.len());
        }
    }

    fn meshes() -> [(TriangleSoup, i64, usize); 5] {
        [
            (wigley::half_hull().unwrap(), 1, 1),
            (franke::mould().unwrap(), 1, 1),
            (blade::pressure_side().unwrap(), 1, 1),
            (saddle::patch_with_island().unwrap(), 0, 2),
            (crown::block().unwrap(), 2, 0),
        ]
    }

    #[test]
    fn topology_is_the_one_promised() {
        for (mesh, euler, loops) in meshes() {
            let faces = mesh.faces.iter().map(|f| f.map(VertexId)).collect();
            let connectivity = Connectivity::new(mesh.positions.len(), faces).unwrap();
            assert_eq!(connectivity.euler_characteristic(), euler);
            assert_eq!(connectivity.boundary_loops().len(), loops);
            assert!((10_000..=20_000).contains(&connectivity.face_count()));
        }
    }

    fn smallest_angle(mesh: &TriangleSoup) -> f64 {
        let angle = |a: DVec3, b: DVec3, c: DVec3| (b - a).angle_between(c - a).to_degrees();
        mesh.faces
            .iter()
            .map(|f| f.map(|v| mesh.positions[v as usize]))
            .flat_map(|[a, b, c]| [angle(a, b, c), angle(b, c, a), angle(c, a, b)])
            .fold(f64::INFINITY, f64::min)
    }

    #[test]
    fn triangles_are_well_shaped() {
        for (mesh, ..) in meshes() {
            let smallest = smallest_angle(&mesh);
            assert!(smallest > 25.0, "smallest angle {smallest:.1} degrees");
        }
    }
}
