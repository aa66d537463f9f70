//! The faces of a file: chosen, listed, meshed.

use super::edge::{Edge, outer};
use super::error::StepError;
use super::face::{StepFace, Trimmed};
use super::model::faces;
use super::part21::parse;
use super::trim::loops;
use crate::geometry::math::cbrt;
use crate::geometry::{DMat3, DVec3};
use crate::mesh::TriangleSoup;
use crate::mesh::repair::{face_area, turn_faces};
use crate::nurbs::{MeshOptions, NurbsError, NurbsMesh, NurbsSurface, Trim, mesh};
use crate::surface::Part;

/// Faces listed in a message.
const LISTED: usize = 40;
/// Most triangles of all faces of a file.
const MOST_TRIANGLES: usize = 8_000_000;

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

impl FaceMesh {
    /// Area of its triangles, mm².
    pub fn area(&self) -> f64 {
        let soup = &self.mesh.soup;
        soup.faces.iter().map(|f| face_area(&soup.positions, *f)).sum()
    }
}

impl StepFile {
    /// Reads a STEP file; lengths become millimetres.
    ///
    /// Memory stays within a small multiple of `bytes.len()`.
    ///
    /// # Errors
    /// [`StepError`] naming the line or the instance. A face that cannot be used is reported when it
    /// is asked for.
    pub fn read(bytes: &[u8]) -> Result<Self, StepError> {
        let faces = faces(&parse(bytes)?)?;
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
        let fault = |what: String| self.fault(index, what);
        let shape = self.shape(index)?;
        let of_nurbs = |error: NurbsError| fault(error.to_string());
        let scale = cbrt(matrix.determinant().abs());
        let loops = loops(&shape.surface, &shape.edges, options.chord / scale, shape.reversed);
        let loops = loops.map_err(|what| fault(what.to_owned()))?;
        let surface = shape.surface.transformed(matrix, shift).map_err(of_nurbs)?;
        let mut mesh = mesh(&surface, Trim::Loops(loops), options).map_err(of_nurbs)?;
        if shape.reversed {
            turn_faces(&mut mesh.soup, |_| true);
        }
        Ok(FaceMesh { surface, mesh })
    }

    /// The surface of face `index`, from 0, as far as the file has it, whatever part of it is the face.
    ///
    /// # Errors
    /// [`StepError::Face`] with what keeps it from being used.
    pub fn surface(
        &self,
        index: usize,
        (matrix, shift): (DMat3, DVec3),
    ) -> Result<NurbsSurface, StepError> {
        let shape = self.shape(index)?;
        let of_nurbs = |error: NurbsError| self.fault(index, error.to_string());
        shape.surface.transformed(matrix, shift).map_err(of_nurbs)
    }

    /// The ends of the edges of face `index`, from 0, mm; none of a face that cannot be used.
    pub fn corners(&self, index: usize) -> Vec<DVec3> {
        let shape = self.faces.get(index).and_then(|face| face.shape.as_ref().ok());
        let edges = shape.into_iter().flat_map(|shape| shape.edges.bounds.iter().flatten());
        edges.flat_map(|edge| edge.ends).collect()
    }

    /// The edges that bound `faces`, from 0, taken together: points of each in a row, the lines between them within
    /// `chord` mm of it. Edges at which one of the faces goes on in another, or in itself, are left out, also where the
    /// file does not say so but has both edges in one place.
    ///
    /// # Errors
    /// [`StepError::Face`] with what keeps a face from being used.
    pub fn boundary(
        &self,
        faces: &[usize],
        (matrix, shift): (DMat3, DVec3),
        chord: f64,
    ) -> Result<Vec<Vec<DVec3>>, StepError> {
        let chord = chord / cbrt(matrix.determinant().abs());
        let mut edges: Vec<(usize, &Edge)> = Vec::new();
        for &face in faces {
            edges.extend(self.shape(face)?.edges.bounds.iter().flatten().map(|e| (face, e)));
        }
        let outer = outer(&edges, chord).into_iter();
        Ok(outer.map(|line| line.into_iter().map(|p| matrix * p + shift).collect()).collect())
    }

    fn shape(&self, index: usize) -> Result<&Trimmed, StepError> {
        self.faces[index].shape.as_ref().map_err(|what| self.fault(index, what.clone()))
    }

    fn fault(&self, index: usize, what: String) -> StepError {
        let face = &self.faces[index];
        StepError::Face { face: index + 1, id: face.id, kind: face.kind.clone(), what }
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
        Ok(self.coarse(index)?.area())
    }

    /// Every face as triangles, mm, within a five-hundredth of its size, for a look at the whole; and why some cannot
    /// be used.
    ///
    /// # Errors
    /// [`StepError::TooManyTriangles`].
    pub fn look(&self) -> Result<Vec<Result<FaceMesh, StepError>>, StepError> {
        let mut budget = Budget::default();
        (0..self.faces.len()).map(|face| budget.take(self.coarse(face))).collect()
    }

    fn coarse(&self, index: usize) -> Result<FaceMesh, StepError> {
        let size = self.faces[index].shape.as_ref().map_or(1.0, |s| s.surface.size());
        let options = MeshOptions { chord: 2e-3 * size, longest: 0.5, most_faces: 20_000 };
        self.mesh(index, (DMat3::IDENTITY, DVec3::ZERO), options)
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

/// How many triangles all faces of a file have so far.
#[derive(Default)]
pub(super) struct Budget {
    used: usize,
}

impl Budget {
    /// Counts a face's triangles, if it can be used.
    ///
    /// # Errors
    /// [`StepError::TooManyTriangles`].
    pub fn take(
        &mut self,
        face: Result<FaceMesh, StepError>,
    ) -> Result<Result<FaceMesh, StepError>, StepError> {
        self.used += face.as_ref().map_or(0, |face| face.mesh.soup.faces.len());
        if self.used > MOST_TRIANGLES {
            return Err(StepError::TooManyTriangles { most: MOST_TRIANGLES });
        }
        Ok(face)
    }
}

/// The triangles of several faces; their parameters are left out, since each face has its own.
pub fn together<'a>(faces: impl IntoIterator<Item = &'a FaceMesh>) -> TriangleSoup {
    let mut part = Part::default();
    for FaceMesh { mesh: NurbsMesh { soup, .. }, .. } in faces {
        part.add(&Part { positions: soup.positions.clone(), faces: soup.faces.clone() });
    }
    TriangleSoup { positions: part.positions, faces: part.faces, texture: None }
}
