//! Why a STEP file is not usable.

use crate::geometry::Shown;
use thiserror::Error;

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
        "step: the file uses several units of length ({} and {} mm); export the part with one",
        Shown(*.0),
        Shown(*.1)
    )]
    Units(f64, f64),
    /// Parts that are moved into an assembly.
    #[error(
        "step: #{0} moves a part within an assembly, which is not supported; export the part alone, in its final position"
    )]
    Assembly(u64),
    /// All faces together are too fine.
    #[error(
        "step: its faces together take more than {most} triangles; choose fewer with surface.face, or a larger \
         surface.chord"
    )]
    TooManyTriangles {
        /// Most triangles.
        most: usize,
    },
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
        "step: the file has {count} faces; choose one with surface.face, the largest with surface.select.component = \"largest\", or with surface.steepest several or \"all\": {list}"
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
