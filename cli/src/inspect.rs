//! `evencut inspect`: the contents of a surface file.

use std::path::{Path, PathBuf};

use clap::Args;
use evencut_core::step::{FaceMesh, SmoothFormat, StepError, StepFace, StepFile};
use evencut_core::surface::Inspection;
use evencut_service::blisk::{Blisk, Kind};
use evencut_service::new_job::{self, Contents};
use serde_json::{Value, json};

use crate::{Exit, Streams, input};

/// Arguments of `evencut inspect`.
#[derive(Args)]
pub struct Inspect {
    /// Surface file: stl, obj, ply, off, json, step or stp
    #[arg(value_name = "FILE")]
    file: PathBuf,
    /// Factor that converts the file's lengths to millimetres
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
        if SmoothFormat::from_name(&self.file.to_string_lossy()) == Some(SmoothFormat::Step) {
            return self.run_step(streams);
        }
        match contents(&self.file, self.scale) {
            Ok(Contents { inspection, .. }) if self.json => {
                streams.data(&format!("{:#}\n", as_json(&inspection)));
                Exit::Done
            }
            Ok(Contents { inspection, .. }) => {
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

impl Inspect {
    /// Lists the faces of a STEP file.
    fn run_step(&self, streams: &mut Streams<'_>) -> Exit {
        match self.faces() {
            Ok(text) => {
                streams.data(&text);
                Exit::Done
            }
            Err(message) => {
                streams.message(&format!("error: {message}\n --> {}\n", input::shown(&self.file)));
                Exit::BadSurface
            }
        }
    }

    /// The faces of a STEP file, and what they are together; those that cannot be used are listed with their fault.
    fn faces(&self) -> Result<String, String> {
        let bytes = std::fs::read(&self.file).map_err(|error| format!("surface: {error}"))?;
        let file = StepFile::read(&bytes).map_err(|error| error.to_string())?;
        let looked = file.look().map_err(|error| error.to_string())?;
        let faces = listed(&file, &looked, self.scale);
        let whole = new_job::of_faces(&looked, self.scale).ok().map(|c| c.inspection);
        let blisk = Blisk::find(&file, &looked);
        if self.json {
            let whole = whole.as_ref().map(as_json);
            let blisk = blisk.as_ref().map(blisk_as_json);
            let all = json!({ "faces": faces, "together": whole, "blisk": blisk });
            return Ok(format!("{all:#}\n"));
        }
        let mut text = table(&faces);
        if let Some(Inspection { area, bounds: (low, high), .. }) = whole {
            let [low, high] = [low, high].map(|p| format!("({:.2}, {:.2}, {:.2})", p.x, p.y, p.z));
            text += &format!("   all                     {area:.2} from {low} to {high} mm\n");
        }
        text += &blisk.map_or(String::new(), |blisk| blisk.text());
        Ok(text)
    }
}

/// The hub and the blades; numbers of faces from 1.
fn blisk_as_json(blisk: &Blisk) -> Value {
    let numbers = |faces: &[usize]| faces.iter().map(|f| f + 1).collect::<Vec<usize>>();
    let kind = |kind: &Kind| json!({ "count": kind.count, "faces": numbers(&kind.faces), "fillets": numbers(&kind.fillets) });
    json!({
        "hub": blisk.hub + 1,
        "axis": blisk.axis.way.to_array(),
        "origin_mm": blisk.axis.origin.to_array(),
        "blades": blisk.kinds.iter().map(kind).collect::<Vec<Value>>(),
    })
}

/// Number, kind, area and fault of every face.
fn listed(file: &StepFile, looked: &[Result<FaceMesh, StepError>], scale: f64) -> Vec<Value> {
    let one = |(i, (face, mesh)): (usize, (&StepFace, &Result<FaceMesh, StepError>))| {
        let (area, fault) = match mesh {
            Ok(mesh) => (Some(mesh.area() * scale * scale), None),
            Err(error) => (None, Some(error.to_string())),
        };
        json!({ "face": i + 1, "kind": face.kind, "instance": face.id, "area_mm2": area, "fault": fault })
    };
    file.faces().iter().zip(looked).enumerate().map(one).collect()
}

fn table(faces: &[Value]) -> String {
    let mut text = format!(
        "{} faces; surface.face chooses one, some or \"all\"\n  face  kind               area mm²\n",
        faces.len()
    );
    for face in faces {
        let kind = face["kind"].as_str().unwrap_or_default();
        let last = match (face["area_mm2"].as_f64(), face["fault"].as_str()) {
            (Some(area), _) => format!("{area:.2}"),
            (None, fault) => format!("not usable: {}", fault.unwrap_or_default()),
        };
        text += &format!("{:>6}  {kind:18} {last}\n", face["face"].as_u64().unwrap_or_default());
    }
    text
}

/// What a surface file holds, with its lengths multiplied by `scale`, or why it cannot be used.
pub fn contents(file: &Path, scale: f64) -> Result<Contents, String> {
    let bytes = std::fs::read(file).map_err(|error| format!("surface: {error}"))?;
    new_job::contents(&file.to_string_lossy(), &bytes, scale)
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
        "facets_off_smooth_mm": inspection.off_smooth,
        "smallest_concave_radius_mm": radius(&inspection.concave),
        "smallest_concave_radius_at_mm": inspection.concave.map(|(_, at)| at.to_array()),
        "smallest_convex_radius_mm": radius(&inspection.convex),
        "mean_normal": facing.mean.to_array(),
        "normals_from_mean_deg": facing.from_mean.to_degrees(),
        "normals_from_z_deg": facing.from_up.to_degrees(),
        "faults": faults,
    })
}
