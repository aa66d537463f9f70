//! Smooth surfaces: read, and made into triangles, few of them.

use crate::mesh::as_it_is;
use crate::{Outcome, refused};
use evencut_core::geometry::{DMat3, DVec3};
use evencut_core::nurbs::{MeshOptions, NurbsError, NurbsFile, NurbsMesh, Trim, mesh, read_json};
use evencut_core::step::{StepError, StepFile};
use evencut_core::surface::build_parametric;

/// How far triangles may be off the faces of the seeds, mm.
const CHORD: f64 = 0.1;

/// A NURBS surface in a file of JSON.
pub fn nurbs(bytes: &[u8]) -> Outcome {
    let meshed = |file: NurbsFile| -> Result<(), NurbsError> {
        let (low, high) = file.trim.unwrap_or(file.surface.domain());
        let made =
            mesh(&file.surface, Trim::Rectangle(low, high), coarse(5e-3 * file.surface.size()))?;
        assert_sound(&made);
        if let Err(error) = build_parametric(made.soup, file.surface, &as_it_is()) {
            assert!(!error.to_string().is_empty());
        }
        Ok(())
    };
    match read_json(bytes).and_then(meshed) {
        Ok(()) => Outcome::Read,
        Err(error) => refused(&error.to_string()),
    }
}

/// The largest face of a STEP file.
pub fn step(bytes: &[u8]) -> Outcome {
    let meshed = |file: StepFile| -> Result<(), StepError> {
        let largest = file.choose(None, true)?;
        let face = file.mesh(largest, (DMat3::IDENTITY, DVec3::ZERO), coarse(CHORD))?;
        assert_sound(&face.mesh);
        if let Err(error) = build_parametric(face.mesh.soup, face.surface, &as_it_is()) {
            assert!(!error.to_string().is_empty());
        }
        Ok(())
    };
    match StepFile::read(bytes).and_then(meshed) {
        Ok(()) => Outcome::Read,
        Err(error) => refused(&error.to_string()),
    }
}

fn coarse(chord: f64) -> MeshOptions {
    MeshOptions { chord, longest: 0.5, most_faces: 5000 }
}

fn assert_sound(mesh: &NurbsMesh) {
    let soup = &mesh.soup;
    assert!(soup.positions.iter().all(|p| p.is_finite()));
    let count = soup.positions.len() as u32;
    assert!(soup.faces.iter().flatten().all(|&corner| corner < count));
    assert!(mesh.chord_error.is_finite());
}
