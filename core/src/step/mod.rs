//! STEP files (AP203, AP214, AP242): their faces as NURBS surfaces with trimming loops.
//!
//! Steps: the text becomes instances (`part21`); faces are found through their shells, their
//! surfaces become NURBS surfaces, elementary ones included (`model`); the curves of their edges
//! are projected to the parameters and become trimming loops (`trim`).
//!
//! # Source
//! ISO 10303-21 (text), ISO 10303-42 (geometry and topology).

mod load;
mod model;
mod part21;
#[cfg(test)]
mod tests;
mod trim;

pub use load::{SmoothError, SmoothFormat, smooth};
use thiserror::Error;

use crate::geometry::{DMat3, DVec3};
use crate::mesh::TriangleSoup;
use crate::mesh::repair::turn_faces;
use crate::nurbs::{MeshOptions, NurbsError, NurbsMesh, NurbsSurface, Trim, mesh};

/// Faces listed in a message.
const LISTED: usize = 40;

/// Why a STEP file is not usable.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum StepError {
    /// The text is not that of a STEP file.
    #[error("step: line {line}: found {found}; expected {expected}")]
    Syntax {
        /// The line, from 1.
        line: usize,
        /// What is there.
        found: String,
        /// What should be there.
        expected: &'static str,
    },
    /// An instance is missing or not what it should be.
    #[error("step: #{id} {name}: {what}")]
    Instance {
        /// Its number.
        id: u64,
        /// Its entity, or nothing.
        name: String,
        /// What is wrong.
        what: String,
    },
    /// There are no faces.
    #[error(
        "step: the file has no faces (ADVANCED_FACE or FACE_SURFACE); export the part as a boundary representation (AP203, AP214 or AP242)"
    )]
    NoFaces,
    /// Lengths of several units.
    #[error(
        "step: the file uses several units of length ({0} and {1} mm); export the part with one"
    )]
    Units(f64, f64),
    /// Parts that are moved into an assembly.
    #[error(
        "step: #{0} moves a part within an assembly, which is not supported; export the part alone, in its final position"
    )]
    Assembly(u64),
    /// The face asked for is not there.
    #[error("step: surface.face = {face}, but the file has {count} faces: {list}")]
    NoSuchFace {
        /// The face, from 1.
        face: u32,
        /// Number of faces.
        count: usize,
        /// The faces.
        list: String,
    },
    /// There are several faces and none is chosen.
    #[error(
        "step: the file has {count} faces; choose one with surface.face, or the largest with surface.select.component = \"largest\": {list}"
    )]
    SeveralFaces {
        /// Number of faces.
        count: usize,
        /// The faces.
        list: String,
    },
    /// A face that cannot be used.
    #[error("step: face {face} ({kind}, #{id}): {what}")]
    Face {
        /// The face, from 1.
        face: usize,
        /// Its number in the file.
        id: u64,
        /// Kind of its surface.
        kind: String,
        /// What is wrong.
        what: String,
    },
}

/// A face of a STEP file.
#[derive(Clone, Debug)]
pub struct StepFace {
    /// Number of its instance.
    pub id: u64,
    /// Kind of its surface, in the field's words.
    pub kind: String,
    /// Its surface and loops, or why there are none.
    shape: Result<Trimmed, String>,
}

/// A surface with loops.
#[derive(Clone, Debug)]
struct Trimmed {
    surface: NurbsSurface,
    edges: trim::Edges,
    /// Whether the face looks against `u` cross `v`.
    reversed: bool,
}

/// The faces of a STEP file, in the order of its shells.
#[derive(Clone, Debug)]
pub struct StepFile {
    faces: Vec<StepFace>,
}

/// A face as triangles.
#[derive(Clone, Debug)]
pub struct FaceMesh {
    /// Its surface, mm.
    pub surface: NurbsSurface,
    /// Its triangles, counter-clockwise from outside the part.
    pub mesh: NurbsMesh,
}

impl StepFile {
    /// Reads a STEP file; lengths become millimetres.
    ///
    /// Memory stays within a small multiple of `bytes.len()`.
    ///
    /// # Errors
    /// [`StepError`] naming the line or the instance. A face that cannot be used is told when it
    /// is asked for.
    pub fn read(bytes: &[u8]) -> Result<Self, StepError> {
        let faces = model::faces(&part21::parse(bytes)?)?;
        if faces.is_empty() { Err(StepError::NoFaces) } else { Ok(Self { faces }) }
    }

    /// The faces.
    pub fn faces(&self) -> &[StepFace] {
        &self.faces
    }

    /// The triangles of face `index`, from 0, its lengths multiplied by `matrix` and moved by
    /// `shift`.
    ///
    /// # Errors
    /// [`StepError::Face`] with what keeps it from being meshed.
    pub fn mesh(
        &self,
        index: usize,
        (matrix, shift): (DMat3, DVec3),
        options: MeshOptions,
    ) -> Result<FaceMesh, StepError> {
        let face = &self.faces[index];
        let fault = |what: String| StepError::Face {
            face: index + 1,
            id: face.id,
            kind: face.kind.clone(),
            what,
        };
        let shape = face.shape.as_ref().map_err(|what| fault(what.clone()))?;
        let of_nurbs = |error: NurbsError| fault(error.to_string());
        let scale = crate::geometry::math::cbrt(matrix.determinant().abs());
        let loops =
            trim::loops(&shape.surface, &shape.edges, options.chord / scale, shape.reversed);
        let loops = loops.map_err(|what| fault(what.to_owned()))?;
        let surface = shape.surface.transformed(matrix, shift).map_err(of_nurbs)?;
        let mut mesh = mesh(&surface, Trim::Loops(loops), options).map_err(of_nurbs)?;
        if shape.reversed {
            turn_faces(&mut mesh.soup, |_| true);
        }
        Ok(FaceMesh { surface, mesh })
    }

    /// Number, kind and area of every face as one line, coarsely measured.
    pub fn list(&self) -> String {
        let one = |i: usize| format!("{} {} {}", i + 1, self.faces[i].kind, self.area_text(i));
        let shown = self.faces.len().min(LISTED);
        let mut list: Vec<String> = (0..shown).map(one).collect();
        if shown < self.faces.len() {
            list.push(format!("and {} more", self.faces.len() - shown));
        }
        list.join(", ")
    }

    /// Area of a face, mm², coarsely measured.
    ///
    /// # Errors
    /// [`StepError::Face`] with what keeps it from being meshed.
    pub fn area(&self, index: usize) -> Result<f64, StepError> {
        let size = self.faces[index].shape.as_ref().map_or(1.0, |s| s.surface.size());
        let options = MeshOptions { chord: 2e-3 * size, longest: 0.5, most_faces: 20_000 };
        let face = self.mesh(index, (DMat3::IDENTITY, DVec3::ZERO), options)?;
        Ok(area(&face.mesh.soup))
    }

    fn area_text(&self, index: usize) -> String {
        match self.area(index) {
            Ok(area) => format!("{area:.4} mm²"),
            Err(_) => "(unusable)".to_owned(),
        }
    }

    /// The face that is meant: the one with number `face`, from 1, else the only one, else, if
    /// `largest`, the largest.
    ///
    /// # Errors
    /// [`StepError::NoSuchFace`] and [`StepError::SeveralFaces`] list the faces.
    pub fn choose(&self, face: Option<u32>, largest: bool) -> Result<usize, StepError> {
        let count = self.faces.len();
        match face {
            Some(number) if (1..=count).contains(&(number as usize)) => Ok(number as usize - 1),
            Some(face) => Err(StepError::NoSuchFace { face, count, list: self.list() }),
            None if count == 1 => Ok(0),
            None if largest => {
                let area = |i: &usize| self.area(*i).unwrap_or(0.0);
                let areas: Vec<(usize, f64)> = (0..count).map(|i| (i, area(&i))).collect();
                let best = areas.iter().max_by(|a, b| a.1.total_cmp(&b.1).then(b.0.cmp(&a.0)));
                Ok(best.map_or(0, |(i, _)| *i))
            }
            None => Err(StepError::SeveralFaces { count, list: self.list() }),
        }
    }
}

/// Area of triangles.
pub(crate) fn area(soup: &TriangleSoup) -> f64 {
    soup.faces.iter().map(|f| crate::mesh::repair::face_area(&soup.positions, *f)).sum()
}
