//! Files of smooth surfaces → the surface to machine and its part.

use thiserror::Error;

use super::error::StepError;
use super::file::{Budget, FaceMesh, StepFile, together};
use crate::geometry::{DMat3, DVec3};
use crate::job::{Component, Faces, SurfaceOptions};
use crate::mesh::repair::turn_faces;
use crate::nurbs::{MeshOptions, NurbsError, Trim, mesh, read_json};
use crate::surface::{
    Part, SurfaceError, Warning, Whole, build_parametric, build_placed, placement,
};

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

/// How long the sides of triangles of faces may be whose flat image does not matter, square roots of the area.
const LONGEST: f64 = 0.25;

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
) -> Result<Whole, SmoothError> {
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
) -> Result<Whole, SmoothError> {
    let file = StepFile::read(bytes)?;
    let all = 0..file.faces().len();
    let coarse = MeshOptions { chord, longest: LONGEST, ..MeshOptions::default() };
    let mut budget = Budget::default();
    let mut meshed = |face: usize| budget.take(file.mesh(face, place, coarse));
    let mut unusable = Vec::new();
    let (chosen, mut whole): (Vec<usize>, Whole) = match &options.face {
        Faces::All => {
            let mut usable = Vec::new();
            for face in all.clone() {
                match meshed(face)? {
                    Ok(mesh) => usable.push(mesh),
                    Err(error) => unusable.push(error),
                }
            }
            if usable.is_empty() && !unusable.is_empty() {
                return Err(unusable.swap_remove(0).into());
            }
            (all.clone().collect(), build_placed(together(&usable), options)?)
        }
        Faces::Several(numbers) => {
            let chosen = numbers.iter().map(|n| file.choose(Some(*n), false));
            let chosen = chosen.collect::<Result<Vec<usize>, _>>()?;
            let meshes = chosen.iter().map(|face| meshed(*face)?);
            let meshes = meshes.collect::<Result<Vec<FaceMesh>, _>>()?;
            (chosen, build_placed(together(&meshes), options)?)
        }
        Faces::One(_) | Faces::Only => {
            let largest = options.select.component == Component::Largest;
            let chosen = file.choose(options.face.number(), largest)?;
            let asked = MeshOptions { chord, ..MeshOptions::default() };
            let FaceMesh { surface, mesh } = file.mesh(chosen, place, asked)?;
            (vec![chosen], build_parametric(mesh.soup, surface, options)?)
        }
    };
    let mut is_chosen = vec![false; file.faces().len()];
    chosen.into_iter().for_each(|face| is_chosen[face] = true);
    let mut others = Vec::new();
    for other in all.filter(|face| !is_chosen[*face]) {
        match meshed(other)? {
            Ok(face) => others.push(face),
            Err(error) => unusable.push(error),
        }
    }
    let mut others = together(&others);
    if options.flip {
        // The part is seen from the side that is machined.
        turn_faces(&mut others, |_| true);
    }
    whole.part.add(&Part { positions: others.positions, faces: others.faces });
    if let Some(first) = unusable.first() {
        let (count, first) = (unusable.len(), first.to_string());
        whole.warnings.push(Warning::FacesLeftOut { count, first });
    }
    Ok(whole)
}
