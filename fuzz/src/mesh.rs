//! Meshes: read, mended and judged.

use crate::{Outcome, refused};
use evencut_core::geometry::DVec3;
use evencut_core::job::{self, Component, Faces, Selection, SurfaceOptions, SurfaceSource};
use evencut_core::mesh::{MeshFormat, TriangleSoup, read};
use evencut_core::surface::{Inspection, build, build_beside};
use evencut_service::new_job::Contents;

/// A mesh in a file of STL, as text or binary.
pub fn stl(bytes: &[u8]) -> Outcome {
    mesh(bytes, MeshFormat::Stl)
}

/// A mesh in a file of OBJ.
pub fn obj(bytes: &[u8]) -> Outcome {
    mesh(bytes, MeshFormat::Obj)
}

/// A mesh in a file of PLY, as text or binary, in both orders of bytes.
pub fn ply(bytes: &[u8]) -> Outcome {
    mesh(bytes, MeshFormat::Ply)
}

/// A mesh in a file of OFF.
pub fn off(bytes: &[u8]) -> Outcome {
    mesh(bytes, MeshFormat::Off)
}

fn mesh(bytes: &[u8], format: MeshFormat) -> Outcome {
    match read(bytes, format) {
        Ok(soup) => {
            // No more than the bytes can hold.
            assert!(soup.faces.len() + soup.positions.len() <= 2 * bytes.len());
            assert!(soup.positions.iter().all(|p| p.is_finite()));
            let count = soup.positions.len() as u32;
            assert!(soup.faces.iter().flatten().all(|&corner| corner < count));
            used(&soup);
            Outcome::Read
        }
        Err(error) => refused(&error.to_string()),
    }
}

/// Whatever was read is machined, stands beside, or gets a job file; or is refused.
fn used(soup: &TriangleSoup) {
    let options = as_it_is();
    if let Err(error) = build(soup.clone(), &options) {
        assert!(!error.to_string().is_empty());
    }
    if let Err(error) = build_beside(soup.clone(), &options) {
        assert!(!error.to_string().is_empty());
    }
    match Inspection::new(soup.clone()) {
        Ok(inspection) => {
            let text =
                Contents { inspection, faces: None, is_mesh: true, blisk: None }.job("part.stl");
            if let Err(faults) = job::read(text.as_bytes()) {
                panic!("{}\n{text}", faults.render("template", text.as_bytes()));
            }
        }
        Err(error) => assert!(!error.to_string().is_empty()),
    }
}

/// Options that take the largest piece of a file, in mm.
pub fn as_it_is() -> SurfaceOptions {
    SurfaceOptions {
        source: SurfaceSource::File(String::new()),
        scale: 1.0,
        rotate: DVec3::ZERO,
        translate: DVec3::ZERO,
        select: Selection { component: Component::Largest, ..Selection::default() },
        curvature_radius: None,
        steepest: None,
        flip: false,
        face: Faces::Only,
        chord: None,
    }
}
