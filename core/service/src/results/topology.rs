//! The topology of the best feed direction → its figures and pictures.

use evencut_core::flatten::Locator;
use evencut_core::geometry::DVec2;
use evencut_core::regions::tensor::{DegeneratePoint, Kind, TensorField, Topology};
use evencut_core::regions::{Divided, Region};
use evencut_core::surface::Surface;
use evencut_output::preview::{PointKind, PointMark, TensorPicture};
use evencut_output::report::{PointFigures, TensorFigures};

/// The figures of a topology.
pub fn figures(topology: &Topology) -> TensorFigures {
    let point = |p: &DegeneratePoint| PointFigures {
        kind: p.kind.name().to_owned(),
        at_mm: p.place.to_array(),
        delta: p.delta,
        divides: p.divides,
    };
    TensorFigures {
        points: topology.points.iter().map(point).collect(),
        separatrices: topology.separatrices.len() as u64,
        cancelled_pairs: topology.cancelled.len() as u64,
        doubtful: topology.doubtful as u64,
        free_mm2: topology.free.iter().map(|f| f.area).sum(),
        smoothing_mm: topology.smoothing,
    }
}

/// The picture of a topology, and of the regions that it separates.
pub fn picture<'a>(topology: &'a Topology, divided: Option<&Divided>) -> TensorPicture<'a> {
    let point = |p: &DegeneratePoint| PointMark {
        at: p.flat,
        kind: match p.kind {
            Kind::Trisector => PointKind::Trisector,
            Kind::Wedge => PointKind::Wedge,
        },
        divides: p.divides,
    };
    let free = || topology.free.iter().map(|f| f.area).sum();
    TensorPicture {
        points: topology.points.iter().map(point).collect(),
        separatrices: topology.separatrices.iter().map(|s| s.line.as_slice()).collect(),
        regions: divided.map_or_else(Vec::new, outlines),
        cancelled_pairs: topology.cancelled.len(),
        free_area: (!topology.free.is_empty()).then(free),
    }
}

/// The flat outlines of every region.
fn outlines(divided: &Divided) -> Vec<Vec<Vec<DVec2>>> {
    let split_mesh = &divided.regions.split_mesh;
    let outline = |part: &Region| {
        let uv = part.piece.uv(split_mesh);
        let cycles = part.piece.connectivity.boundary_loops().iter();
        cycles.map(|cycle| cycle.iter().map(|v| uv[v.index()]).collect()).collect()
    };
    divided.regions.list.iter().map(outline).collect()
}

/// Unit vector along the best feed direction at a flat place: zero where there is none, `None` off the surface.
pub fn direction_at(
    topology: &Topology,
    surface: &Surface,
    locator: &Locator,
    at: DVec2,
) -> Option<DVec2> {
    let point = locator.locate(at).ok()?;
    let corners = surface.connectivity().face(point.face);
    let value: DVec2 = (0..3).map(|i| topology.values[corners[i].index()] * point.weights[i]).sum();
    Some(TensorField::direction_of(value))
}
