//! `evencut inspect`: what a mesh file holds.

use std::path::{Path, PathBuf};

use clap::Args;
use evencut_core::mesh::{MeshFormat, read};
use evencut_core::surface::Inspection;
use serde_json::{Value, json};

use crate::{Exit, Streams, input};

/// Arguments of `evencut inspect`.
#[derive(Args)]
pub struct Inspect {
    /// Mesh file: stl, obj, ply or off
    #[arg(value_name = "FILE")]
    file: PathBuf,
    /// Factor on the file's lengths that makes them millimetres
    #[arg(long, default_value_t = 1.0, value_name = "S", value_parser = scale)]
    scale: f64,
    /// Print the figures as JSON
    #[arg(long)]
    json: bool,
}

pub(crate) fn scale(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(scale) if (1e-6..=1e6).contains(&scale) => Ok(scale),
        _ => Err("a number from 0.000001 to 1000000 is needed".into()),
    }
}

impl Inspect {
    /// Inspects the file.
    pub fn run(&self, streams: &mut Streams<'_>) -> Exit {
        match inspect(&self.file, self.scale) {
            Ok(inspection) if self.json => {
                streams.data(&format!("{:#}\n", as_json(&inspection)));
                Exit::Done
            }
            Ok(inspection) => {
                streams.data(&inspection.to_string());
                Exit::Done
            }
            Err(message) => {
                streams.message(&format!("error: {message}\n --> {}\n", input::shown(&self.file)));
                Exit::BadSurface
            }
        }
    }
}

/// The figures of a mesh file with its lengths multiplied by `scale`, or what is wrong with it.
pub fn inspect(file: &Path, scale: f64) -> Result<Inspection, String> {
    let format = MeshFormat::from_name(&file.to_string_lossy())
        .ok_or("surface: the format is not known; the name must end in .stl, .obj, .ply or .off")?;
    let bytes = std::fs::read(file).map_err(|error| format!("surface: {error}"))?;
    let mut mesh = read(&bytes, format).map_err(|error| error.to_string())?;
    mesh.positions.iter_mut().for_each(|p| *p *= scale);
    Inspection::new(mesh).map_err(|error| error.to_string())
}

fn as_json(inspection: &Inspection) -> Value {
    let Inspection { judgement, repairs, facing, .. } = inspection;
    let radius = |place: &Option<(f64, _)>| place.map(|(radius, _)| radius);
    let areas: Vec<f64> = judgement.components.iter().map(|c| c.area).collect();
    let faults: Vec<String> = inspection.faults.iter().map(ToString::to_string).collect();
    json!({
        "read": { "vertices": inspection.read.0, "faces": inspection.read.1 },
        "repairs": repairs.to_string(),
        "vertices": judgement.vertices,
        "faces": judgement.faces,
        "component_areas_mm2": areas,
        "boundary_loop_lengths_mm": judgement.boundary_loops,
        "euler": judgement.euler,
        "genus": judgement.genus,
        "area_mm2": inspection.area,
        "box_low_mm": inspection.bounds.0.to_array(),
        "box_high_mm": inspection.bounds.1.to_array(),
        "shortest_edge_mm": inspection.edges.0,
        "longest_edge_mm": inspection.edges.1,
        "smallest_concave_radius_mm": radius(&inspection.concave),
        "smallest_concave_radius_at_mm": inspection.concave.map(|(_, at)| at.to_array()),
        "smallest_convex_radius_mm": radius(&inspection.convex),
        "mean_normal": facing.mean.to_array(),
        "normals_from_mean_deg": facing.from_mean.to_degrees(),
        "normals_from_z_deg": facing.from_up.to_degrees(),
        "faults": faults,
    })
}
