//! The files that a job names, or its formula → its surface, the part to which it belongs, and what to stay away from.

use super::error::PlanError;
use crate::geometry::DVec3;
use crate::job::{
    AnalyticKind, AnalyticOptions, AnalyticParameters, Avoid, FlattenMethod, HubOptions, Job,
    StockShape, SurfaceOptions, SurfaceSource,
};
use crate::machine::Axes;
use crate::mesh::{MeshFormat, judge, read};
use crate::reach::{ReachOptions, turn_outward};
use crate::step::{SmoothFormat, smooth};
use crate::surface::{AnalyticSurface, Part, Whole, build_beside, build_whole};
use crate::tool::Tool;

/// Fraction of the tolerance by which the mesh of a NURBS surface may deviate from it.
const CHORD: f64 = 0.25;

/// Fraction of the tolerance up to which the reached surface may be off.
const ACCURACY: f64 = 0.5;

/// Contents of the files that a job names.
#[derive(Copy, Clone, Debug, Default)]
pub struct Files<'a> {
    /// Content of the surface file; `None` for a formula.
    pub surface: Option<&'a [u8]>,
    /// Names and contents of the meshes beside the surface, `avoid.file` and `stock.file`.
    pub meshes: &'a [(String, Vec<u8>)],
    /// Content of the post-processor's file, `output.gcode.post_file`; `None` if there is none.
    pub post: Option<&'a [u8]>,
    /// Names and contents of the files that the job was completed with: all that is planned stands in the job, and these
    /// in the report.
    pub beside: &'a [(String, Vec<u8>)],
    /// Names and contents of the files of blades, `hub.blade` and `hub.splitter`.
    pub blades: &'a [(String, Vec<u8>)],
}

impl<'a> Files<'a> {
    /// The files of a job that names at most a surface.
    pub fn of_surface(surface: Option<&'a [u8]>) -> Self {
        Self { surface, ..Self::default() }
    }

    /// The file of a blade that the job calls so.
    pub(super) fn blade(&self, name: &str) -> Option<&'a [u8]> {
        named(self.blades, name)
    }
}

fn named<'a>(files: &'a [(String, Vec<u8>)], name: &str) -> Option<&'a [u8]> {
    files.iter().find(|(held, _)| held == name).map(|(_, bytes)| &bytes[..])
}

/// What the channel of a hub depends on besides the hub.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct HubKeys {
    pub options: HubOptions,
    /// Radius of the cutter, mm.
    pub radius: f64,
    pub tolerance: f64,
}

/// All keys of a job on which its surface and the flat map depend, and whether they can be used.
#[derive(Clone, Debug, PartialEq)]
pub struct SurfaceKeys {
    pub(super) surface: SurfaceOptions,
    pub(super) flatten: FlattenMethod,
    /// The material before the first operation.
    stock: Option<StockShape>,
    /// What the tool stays away from.
    avoid: Vec<Avoid>,
    /// Largest distance between a smooth surface and its facets, mm.
    pub(super) chord: f64,
    /// About a rotary centre a part may not lie far away.
    pub(super) axes: Axes,
    /// Where the surface is what the cutter reaches of the part: the cutter, what it leaves on the part, mm, and the
    /// tolerance, mm.
    reached_by: Option<(Tool, f64, f64)>,
    /// Where it is a channel of a hub, on what that depends.
    pub(super) hub: Option<HubKeys>,
}

impl SurfaceKeys {
    /// Those of a job.
    pub fn of(job: &Job) -> Self {
        Self {
            surface: job.surface.clone(),
            flatten: job.flatten,
            stock: job.stock.clone(),
            avoid: job.avoid.clone(),
            chord: job.surface.chord.unwrap_or(CHORD * job.cut.tolerance),
            axes: job.machine.axes,
            hub: job.hub.as_ref().map(|options| HubKeys {
                options: options.clone(),
                radius: job.tool.radius(),
                tolerance: job.cut.tolerance,
            }),
            reached_by: job
                .surface
                .steepest
                .map(|_| (job.tool, job.cut.allowance, job.cut.tolerance)),
        }
    }
}

impl SurfaceKeys {
    /// How the part is reached; `None` where the surface is machined as it is.
    pub(super) fn reach(&self, threads: usize) -> Option<ReachOptions> {
        let (tool, allowance, tolerance) = self.reached_by?;
        self.surface.steepest.map(|steepest| ReachOptions {
            tool,
            allowance,
            accuracy: ACCURACY * tolerance,
            steepest,
            threads,
        })
    }
}

/// The surface of a job and the part it belongs to.
pub(super) fn load(keys: &SurfaceKeys, files: Files) -> Result<Whole, PlanError> {
    let soup = match &keys.surface.source {
        SurfaceSource::File(name) => {
            let bytes = files.surface.ok_or_else(|| PlanError::NoFile(name.clone()))?;
            match SmoothFormat::from_name(name) {
                Some(format) => {
                    return Ok(smooth(bytes, format, &keys.surface, keys.chord)?);
                }
                None => {
                    let format = MeshFormat::from_name(name)
                        .ok_or_else(|| PlanError::UnknownFormat(name.clone()))?;
                    read(bytes, format)?
                }
            }
        }
        SurfaceSource::Analytic(options) => {
            analytic_surface(options).mesh(options.parameters.resolution)
        }
    };
    Ok(build_whole(soup, &keys.surface)?)
}

/// A mesh beside the surface that the whole tool stays away from.
#[derive(Clone, Debug)]
pub struct Avoided {
    /// What it is called.
    pub name: String,
    /// How far the tool stays away from it, mm.
    pub distance: f64,
    /// Its facets, mm.
    pub mesh: Part,
}

/// A mesh beside the surface.
fn beside(keys: &SurfaceKeys, files: Files, file: &str) -> Result<Part, PlanError> {
    let bytes = named(files.meshes, file).ok_or_else(|| PlanError::NoFile(file.to_owned()))?;
    let format =
        MeshFormat::from_name(file).ok_or_else(|| PlanError::UnknownFormat(file.to_owned()))?;
    Ok(build_beside(read(bytes, format)?, &keys.surface)?)
}

/// The material before the first operation, if the job says where it ends.
pub(super) fn load_stock(keys: &SurfaceKeys, files: Files) -> Result<Option<Part>, PlanError> {
    let mut stock = match &keys.stock {
        None => return Ok(None),
        Some(StockShape::Box([least, greatest])) => cuboid(*least, *greatest),
        Some(StockShape::File(file)) => beside(keys, files, file)
            .map_err(|error| PlanError::Stock { file: file.clone(), error: Box::new(error) })?,
    };
    turn_outward(&mut stock);
    match judge(&stock.positions, &stock.faces).is_closed() {
        true => Ok(Some(stock)),
        false => Err(PlanError::OpenStock),
    }
}

/// A box, its faces counter-clockwise from outside.
fn cuboid(least: DVec3, greatest: DVec3) -> Part {
    let corner = |k: u32| {
        let of =
            |bit: u32, axis: usize| if k >> bit & 1 == 1 { greatest[axis] } else { least[axis] };
        DVec3::new(of(0, 0), of(1, 1), of(2, 2))
    };
    let sides: [[u32; 4]; 6] =
        [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    Part {
        positions: (0..8).map(corner).collect(),
        faces: sides.into_iter().flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]]).collect(),
    }
}

/// What the tool of a job stays away from, in the order of its tables.
pub(super) fn load_avoided(keys: &SurfaceKeys, files: Files) -> Result<Vec<Avoided>, PlanError> {
    let avoided = |(index, avoid): (usize, &Avoid)| {
        let Avoid { file, distance, name } = avoid;
        match beside(keys, files, file) {
            Ok(mesh) => Ok(Avoided { name: name.clone(), distance: *distance, mesh }),
            Err(error) => {
                let (file, error) = (file.clone(), Box::new(error));
                Err(PlanError::Avoided { index, file, error })
            }
        }
    };
    keys.avoid.iter().enumerate().map(avoided).collect()
}

/// The formula that the options name.
fn analytic_surface(options: &AnalyticOptions) -> AnalyticSurface {
    let AnalyticParameters { size, radius, tube_radius, height, .. } = options.parameters;
    match options.kind {
        AnalyticKind::Plane => AnalyticSurface::Plane { width: size, depth: size },
        AnalyticKind::SphereCap => AnalyticSurface::SphereCap { radius, diameter: size },
        AnalyticKind::Cylinder => AnalyticSurface::Cylinder { radius, width: size, length: size },
        AnalyticKind::TorusPatch => {
            AnalyticSurface::Torus { major: radius, minor: tube_radius, length: size, width: size }
        }
        AnalyticKind::Saddle => {
            AnalyticSurface::Saddle { radius: size * size / (8.0 * height), size }
        }
        AnalyticKind::MonkeySaddle => AnalyticSurface::MonkeySaddle { size, height },
        AnalyticKind::Bump => AnalyticSurface::Bump { size, height, width: radius },
    }
}
