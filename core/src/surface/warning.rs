//! What a user should know about a surface that can be machined.

use thiserror::Error;

use super::manifold::Surface;
use super::message::{Spot, short};
use super::select::Picked;
use crate::geometry::DVec3;
use crate::geometry::math::acos_clamped;
use crate::mesh::repair::bounding_box;
use crate::mesh::{FaceId, HalfEdgeId, Repairs, TriangleSoup};

/// Parts smaller than this are likely in other units, mm.
const SMALLEST_PART: f64 = 0.5;
/// Parts larger than this are likely in other units, mm.
const LARGEST_PART: f64 = 20_000.0;
/// Part of the diagonal that a 32-bit coordinate may step without a warning.
const COARSEST_STEP: f64 = 1e-5;
/// Angle between neighbouring faces that counts as a crease, rad (40 degrees).
const CREASE: f64 = 40.0 * std::f64::consts::PI / 180.0;
/// Largest z of the mean unit normal of a surface that is said to look down.
const DOWNWARD: f64 = -0.25;
/// Faces below which nothing can be said about curvature.
const FEWEST_FACES: usize = 8;

/// Something about the surface that is accepted but may not be meant.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum Warning {
    /// The mesh was repaired.
    #[error("surface: the mesh was repaired: {0}")]
    Repaired(Repairs),
    /// Pieces were left out.
    #[error(
        "surface: {count} other connected pieces with {} mm² in all are not machined \
         (surface.select.component)", short(*.area)
    )]
    PiecesLeftOut {
        /// How many.
        count: usize,
        /// Their area, mm².
        area: f64,
    },
    /// Larger pieces could not be machined.
    #[error(
        "surface: the {count} largest pieces cannot be machined (closed, with handles or not \
         manifold); the next one is taken"
    )]
    PassedOver {
        /// How many.
        count: u32,
    },
    /// Closed bodies were inside out.
    #[error(
        "surface: the faces of {count} closed {} inward; they are machined from outside all the same",
        if *.count == 1 { "body look" } else { "bodies look" }
    )]
    TurnedOutward {
        /// How many.
        count: usize,
    },
    /// Vertices were split.
    #[error(
        "surface: {count} boundary vertices were split because the selected faces only touched \
         there"
    )]
    Split {
        /// How many.
        count: usize,
    },
    /// The part is tiny.
    #[error(
        "surface: the part is only {} mm across; are its units metres or inches? see \
         surface.scale", short(*.diagonal)
    )]
    Tiny {
        /// Diagonal of the bounding box, mm.
        diagonal: f64,
    },
    /// The part is huge.
    #[error("surface: the part is {} mm across; check surface.scale", short(*.diagonal))]
    Huge {
        /// Diagonal of the bounding box, mm.
        diagonal: f64,
    },
    /// The part is far from the origin.
    #[error(
        "surface: the part is {} mm across but lies {} mm from the origin, where files with \
         32-bit or 8-digit coordinates resolve only {} mm; export it nearer to the origin",
        short(*.diagonal), short(*.offset), short(*.step)
    )]
    FarFromOrigin {
        /// Diagonal of the bounding box, mm.
        diagonal: f64,
        /// Largest coordinate, mm.
        offset: f64,
        /// Step of a 32-bit coordinate there, mm.
        step: f64,
    },
    /// The surface is creased.
    #[error(
        "surface: {count} creases of more than {:.0} degrees, the sharpest of {angle:.1} degrees \
         at {}; cusps are not even across them", CREASE.to_degrees(), Spot(*.at)
    )]
    Creases {
        /// Edges concerned.
        count: usize,
        /// Sharpest angle between normals, degrees.
        angle: f64,
        /// Midpoint of that edge, mm.
        at: DVec3,
    },
    /// Faces of the file that could not be meshed.
    #[error(
        "surface: {count} other faces of the file are not in the part and are not guarded against \
         cutting into them: {first}"
    )]
    FacesLeftOut {
        /// How many.
        count: usize,
        /// What is wrong with the first.
        first: String,
    },
    /// The surface has hardly any faces.
    #[error("surface: the mesh is too coarse to estimate its curvature; number of faces: {faces}")]
    Coarse {
        /// Number of faces.
        faces: usize,
    },
    /// The surface looks down.
    #[error(
        "surface: the faces point away from +Z on average (mean normal {}); if the tool comes \
         from the other side set surface.flip = true", Spot(*.normal)
    )]
    LooksDown {
        /// Area-weighted mean normal, unit length.
        normal: DVec3,
    },
}

impl std::fmt::Display for Repairs {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let counts = [
            (self.unreferenced, "unused vertices dropped"),
            (self.moved, "vertices welded to near ones"),
            (self.collapsed, "faces that repeat a vertex dropped"),
            (self.duplicates, "duplicate faces dropped"),
            (self.dissolved, "faces without area dissolved"),
            (self.reoriented, "faces turned over to agree with their neighbours"),
        ];
        let mut before = "";
        for (count, what) in counts.into_iter().filter(|(count, _)| *count > 0) {
            write!(f, "{before}{count} {what}")?;
            before = ", ";
        }
        if before.is_empty() { f.write_str("nothing") } else { Ok(()) }
    }
}

impl Warning {
    /// Whether it doubts the side from which the surface is machined.
    pub(crate) fn is_of_side(&self) -> bool {
        matches!(self, Self::LooksDown { .. })
    }

    /// What was mended, in words, when that is what the warning is about.
    pub fn repair(&self) -> Option<String> {
        match self {
            Self::Repaired(repairs) => Some(repairs.to_string()),
            _ => None,
        }
    }
}

/// About the part as placed and repaired.
pub(super) fn of_part(mesh: &TriangleSoup, repairs: &Repairs) -> Vec<Warning> {
    let (low, high) = bounding_box(&mesh.positions);
    let diagonal = (high - low).length();
    let offset = low.abs().max(high.abs()).max_element();
    let step = offset * f64::from(f32::EPSILON);
    let mut warnings = Vec::new();
    // Welding exact copies is what every STL needs; all else is worth a word.
    if (Repairs { welded: 0, tolerance: 0.0, ..repairs.clone() }) != Repairs::default() {
        warnings.push(Warning::Repaired(repairs.clone()));
    }
    if diagonal < SMALLEST_PART {
        warnings.push(Warning::Tiny { diagonal });
    }
    if diagonal > LARGEST_PART {
        warnings.push(Warning::Huge { diagonal });
    }
    if step > COARSEST_STEP * diagonal {
        warnings.push(Warning::FarFromOrigin { diagonal, offset, step });
    }
    warnings
}

/// About what the selection did.
pub(super) fn of_selection(picked: &Picked) -> Vec<Warning> {
    let mut warnings = Vec::new();
    let (count, area) = picked.left_out;
    if picked.passed_over > 0 {
        warnings.push(Warning::PassedOver { count: picked.passed_over });
    }
    if count > 0 {
        warnings.push(Warning::PiecesLeftOut { count, area });
    }
    if picked.split > 0 {
        warnings.push(Warning::Split { count: picked.split });
    }
    warnings
}

/// About the surface itself.
pub(super) fn of_surface(surface: &Surface) -> Vec<Warning> {
    let mut warnings = Vec::new();
    let faces = surface.connectivity().face_count();
    if faces < FEWEST_FACES {
        warnings.push(Warning::Coarse { faces });
    }
    warnings.extend(creases(surface));
    let area: DVec3 = (0..faces as u32).map(|f| face_normal(surface, FaceId(f))).sum();
    let normal = area.normalize_or_zero();
    // A surface that closes on itself, such as a tube, has no mean normal to speak of.
    if normal.z < DOWNWARD && area.length() > 0.2 * surface.area() {
        warnings.push(Warning::LooksDown { normal });
    }
    warnings
}

/// Normal with the area as length.
fn face_normal(surface: &Surface, face: FaceId) -> DVec3 {
    let [a, b, c] = surface.corners(face);
    0.5 * (b - a).cross(c - a)
}

fn creases(surface: &Surface) -> Option<Warning> {
    let connectivity = surface.connectivity();
    let unit: Vec<DVec3> = (0..connectivity.face_count() as u32)
        .map(|f| face_normal(surface, FaceId(f)).normalize_or_zero())
        .collect();
    let (mut count, mut sharpest) = (0, (CREASE, None));
    for side in (0..3 * unit.len() as u32).map(HalfEdgeId) {
        let Some(other) = connectivity.opposite(side).filter(|o| side < *o) else { continue };
        let angle = acos_clamped(unit[side.face().index()].dot(unit[other.face().index()]));
        if angle > CREASE {
            count += 1;
            if angle > sharpest.0 {
                sharpest = (angle, Some(side));
            }
        }
    }
    let (angle, side) = (sharpest.0.to_degrees(), sharpest.1?);
    let (a, b) = connectivity.ends(side);
    let at = 0.5 * (surface.positions()[a.index()] + surface.positions()[b.index()]);
    Some(Warning::Creases { count, angle, at })
}
