//! Files of smooth surfaces → the surface to machine and its part.

use thiserror::Error;

use super::error::StepError;
use super::file::{FaceMesh, StepFile};
use crate::geometry::{DMat3, DVec3};
use crate::job::{Component, SurfaceOptions};
use crate::nurbs::{MeshOptions, NurbsError, Trim, mesh, read_json};
use crate::surface::{Built, Part, SurfaceError, Warning, build_parametric, placement};

/// A kind of file that holds smooth surfaces.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum SmoothFormat {
    /// One NURBS surface as JSON.
    Json,
    /// Faces of a STEP file.
    Step,
}

impl SmoothFormat {
    /// The format that a file name's extension says, in any case; `None` for any other extension.
    pub fn from_name(name: &str) -> Option<Self> {
        let (_, extension) = name.rsplit_once('.')?;
        match extension.to_ascii_lowercase().as_str() {
            "json" => Some(Self::Json),
            "step" | "stp" => Some(Self::Step),
            _ => None,
        }
    }
}

/// Why a file of smooth surfaces gives no surface to machine.
#[derive(Debug, Error)]
pub enum SmoothError {
    /// The NURBS surface cannot be used.
    #[error(transparent)]
    Nurbs(#[from] NurbsError),
    /// The STEP file cannot be used.
    #[error(transparent)]
    Step(#[from] StepError),
    /// The triangles made of it cannot be machined.
    #[error(transparent)]
    Surface(#[from] SurfaceError),
}

/// The surface that `options` select from a file, meshed within `chord` mm.
///
/// Faces of a STEP file that are not machined belong to the part; those that cannot be meshed are
/// a warning.
///
/// # Errors
/// [`SmoothError`]: what cannot be used, where, and what to change.
pub fn smooth(
    bytes: &[u8],
    format: SmoothFormat,
    options: &SurfaceOptions,
    chord: f64,
) -> Result<Built, SmoothError> {
    let place = (placement(options), options.translate);
    match format {
        SmoothFormat::Json => {
            let file = read_json(bytes)?;
            let surface = file.surface.transformed(place.0, place.1)?;
            let (low, high) = file.trim.unwrap_or(surface.domain());
            let asked = MeshOptions { chord, ..MeshOptions::default() };
            let mesh = mesh(&surface, Trim::Rectangle(low, high), asked)?;
            Ok(build_parametric(mesh.soup, surface, options)?)
        }
        SmoothFormat::Step => step(bytes, place, options, chord),
    }
}

fn step(
    bytes: &[u8],
    place: (DMat3, DVec3),
    options: &SurfaceOptions,
    chord: f64,
) -> Result<Built, SmoothError> {
    let file = StepFile::read(bytes)?;
    let largest = options.select.component == Component::Largest;
    let chosen = file.choose(options.face, largest)?;
    let asked = MeshOptions { chord, ..MeshOptions::default() };
    let FaceMesh { surface, mesh } = file.mesh(chosen, place, asked)?;
    let mut built = build_parametric(mesh.soup, surface, options)?;
    let mut unusable = Vec::new();
    for other in (0..file.faces().len()).filter(|&i| i != chosen) {
        let coarse = MeshOptions { chord, longest: 0.25, ..MeshOptions::default() };
        match file.mesh(other, place, coarse) {
            Ok(face) => add(&mut built.part, &face, options.flip),
            Err(error) => unusable.push(error.to_string()),
        }
    }
    if let Some(first) = unusable.first() {
        built.warnings.push(Warning::FacesLeftOut { count: unusable.len(), first: first.clone() });
    }
    Ok(built)
}

/// Adds a face to the part, seen from the side that is machined.
fn add(part: &mut Part, face: &FaceMesh, flip: bool) {
    let first = part.positions.len() as u32;
    let soup = &face.mesh.soup;
    part.positions.extend(&soup.positions);
    part.faces.extend(soup.faces.iter().map(|f| {
        let [a, b, c] = f.map(|v| v + first);
        if flip { [a, c, b] } else { [a, b, c] }
    }));
}
