//! A surface file → what it holds, and a job file to start from.

use crate::blisk::Blisk;
use evencut_core::hub::HubError;
use evencut_core::job::{Outside, SurfaceFacts, coarse_facets, guessed_unit, template};
use evencut_core::mesh::{MeshFormat, TriangleSoup, read};
use evencut_core::nurbs::{MeshOptions, NurbsError, Trim, mesh, read_json};
use evencut_core::plan::{Design, Files, PlanError, SurfaceKeys};
use evencut_core::step::{FaceMesh, SmoothFormat, StepError, StepFile, together};
use evencut_core::surface::Inspection;

/// Largest z of the mean unit normal of a surface that looks down; one that looks sideways keeps its side.
const DOWNWARD: f64 = -0.25;

/// A part is turned where less of it is seen from +Z than this part of what is seen from elsewhere.
const HARDLY: f64 = 0.1;

/// What a surface file holds.
pub struct Contents {
    /// Its triangles in figures; a smooth surface is made into triangles.
    pub inspection: Inspection,
    /// Number of its CAD faces, if it is a STEP file.
    pub faces: Option<usize>,
    /// Whether the file holds these triangles, and nothing that is smoother.
    pub is_mesh: bool,
    /// The hub and the blades in it, if it looks like a blisk, and the diameter of a cutter for the channels, mm.
    pub blisk: Option<(Blisk, f64)>,
}

/// Diameters of balls that are tried for the channels of a blisk, mm.
const DIAMETERS: [f64; 12] = [16.0, 12.0, 10.0, 8.0, 6.0, 5.0, 4.0, 3.0, 2.0, 1.5, 1.0, 0.5];
/// Number of blades that is written where the file has only one.
const GUESSED: usize = 10;

/// The largest usual ball that passes the channels of a blisk, mm; the smallest where the channels cannot be laid out.
fn ball_for(blisk: &Blisk, name: &str, bytes: &[u8]) -> f64 {
    let smallest = DIAMETERS[DIAMETERS.len() - 1];
    let mut bound = DIAMETERS[0];
    for diameter in DIAMETERS {
        if diameter > bound {
            continue;
        }
        let job = blisk.job(name, diameter, blisk.blades().unwrap_or(GUESSED));
        let Ok(resolved) = evencut_core::job::read(job.as_bytes()) else { return smallest };
        let keys = SurfaceKeys::of(&resolved.job);
        match Design::new(&keys, Files::of_surface(Some(bytes)), 1) {
            Ok(_) => return diameter,
            Err(PlanError::Hub(error)) => match *error {
                HubError::TooNarrow { largest, .. } => bound = largest,
                HubError::NoRoom { .. } => {}
                _ => return smallest,
            },
            Err(_) => return smallest,
        }
    }
    smallest
}

/// What a surface file holds, its lengths multiplied by `scale`. `name`: the file's, whose ending tells the format.
///
/// # Errors
/// Why it cannot be used.
pub fn contents(name: &str, bytes: &[u8], scale: f64) -> Result<Contents, String> {
    let (soup, is_mesh) = match SmoothFormat::from_name(name) {
        Some(SmoothFormat::Json) => (nurbs_mesh(bytes).map_err(|e| e.to_string())?, false),
        Some(SmoothFormat::Step) => {
            let file = StepFile::read(bytes).map_err(|e| e.to_string())?;
            let looked = file.look().map_err(|e| e.to_string())?;
            let blisk = Blisk::find(&file, &looked);
            let blisk = blisk.map(|blisk| {
                let diameter = ball_for(&blisk, name, bytes);
                (blisk, diameter)
            });
            return Ok(Contents { blisk, ..of_faces(&looked, scale)? });
        }
        None => {
            let format = MeshFormat::from_name(name).ok_or(
                "surface: the format is not known; the name must end in .stl, .obj, .ply, .off, .json, .step or .stp; save other files, IGES and 3MF too, as STEP or STL",
            )?;
            (read(bytes, format).map_err(|e| e.to_string())?, true)
        }
    };
    Ok(Contents { inspection: inspected(soup, scale)?, faces: None, is_mesh, blisk: None })
}

/// What the faces of a STEP file hold together, as [`StepFile::look`] shows them.
///
/// # Errors
/// Why none of them can be used.
pub fn of_faces(looked: &[Result<FaceMesh, StepError>], scale: f64) -> Result<Contents, String> {
    let usable = looked.iter().filter_map(|face| face.as_ref().ok());
    let soup = together(usable);
    match looked.iter().find_map(|face| face.as_ref().err()) {
        Some(error) if soup.faces.is_empty() => Err(error.to_string()),
        _ => {
            let inspection = inspected(soup, scale)?;
            Ok(Contents { inspection, faces: Some(looked.len()), is_mesh: false, blisk: None })
        }
    }
}

fn inspected(mut soup: TriangleSoup, scale: f64) -> Result<Inspection, String> {
    soup.positions.iter_mut().for_each(|p| *p *= scale);
    Inspection::new(soup).map_err(|e| e.to_string())
}

/// Triangles of a NURBS surface, within a ten-thousandth of its size.
fn nurbs_mesh(bytes: &[u8]) -> Result<TriangleSoup, NurbsError> {
    let file = read_json(bytes)?;
    let (low, high) = file.trim.unwrap_or(file.surface.domain());
    let options = MeshOptions { chord: 1e-4 * file.surface.size(), ..MeshOptions::default() };
    let mut soup = mesh(&file.surface, Trim::Rectangle(low, high), options)?.soup;
    // Parameters are no texture.
    soup.texture = None;
    Ok(soup)
}

impl Contents {
    /// A commented job file for it. `file`: the surface file's name relative to the job file.
    pub fn job(&self, file: &str) -> String {
        match &self.blisk {
            Some((blisk, diameter)) => {
                blisk.job(file, *diameter, blisk.blades().unwrap_or(GUESSED))
            }
            None => template(file, &self.facts()),
        }
    }

    /// What of the job has to be looked at before it is used.
    pub fn doubts(&self) -> Vec<String> {
        match &self.blisk {
            Some((blisk, _)) => self.doubt_of_blades(blisk).into_iter().collect(),
            None => self.doubts_of_mesh(),
        }
    }

    fn doubts_of_mesh(&self) -> Vec<String> {
        let facts = self.facts();
        let unit = guessed_unit(&facts).map(|unit| {
            let size = facts.size.iter().copied().fold(0.0, f64::max);
            format!(
                "the part would be {size:.3} mm long; the job takes its numbers as {unit}, which is a guess: correct it in \
                 the job if they are mm"
            )
        });
        let coarse = coarse_facets(&facts).map(|off| {
            format!(
                "if the mesh stands for a smooth surface, its facets are about {off:.3} mm off it, so cut.scallop and \
                 cut.tolerance of the job are coarse; where its edges are meant, write finer ones"
            )
        });
        unit.into_iter().chain(coarse).collect()
    }

    fn doubt_of_blades(&self, blisk: &Blisk) -> Option<String> {
        if let Some((found, around)) = blisk.found_of() {
            return Some(format!(
                "{found} blades were found in the file, and the nearest two stand as far apart as {around} do, so hub.blades = \
                 {around}; look whether the others differ"
            ));
        }
        blisk.blades().is_none().then(|| {
            format!(
                "the file has one blade only, so hub.blades = {GUESSED} is a guess; correct it in the job, and \
                 tool.diameter with it"
            )
        })
    }

    /// Facts from which a job file is made.
    fn facts(&self) -> SurfaceFacts {
        let Inspection {
            bounds,
            concave,
            convex,
            facing,
            faults,
            vector_area,
            enclosed,
            off_smooth,
            sharpest,
            ..
        } = &self.inspection;
        SurfaceFacts {
            size: (bounds.1 - bounds.0).to_array(),
            middle: (0.5 * (bounds.0 + bounds.1)).to_array(),
            smallest_concave_radius: concave.map(|(radius, _)| radius),
            smallest_convex_radius: convex.map(|(radius, _)| radius),
            solid: enclosed.map(|v| if v < 0.0 { Outside::Inward } else { Outside::Outward }),
            looks_down: vector_area.z < DOWNWARD * vector_area.length(),
            off_smooth: if self.is_mesh { *off_smooth } else { 0.0 },
            is_part: !faults.is_empty(),
            cad_faces: self.faces,
            mean_normal: facing.mean.to_array(),
            from_mean: facing.from_mean,
            most_from_mean: facing.most_from_mean,
            most_from_up: facing.most_from_up,
            most_from_down: facing.most_from_down,
            sharpest: if self.is_mesh { *sharpest } else { [0.0; 2] },
            seen_from: facing.fronts.map(|front| {
                let hardly = front.from_up < HARDLY * front.most;
                hardly.then(|| front.direction.to_array())
            }),
        }
    }
}
