//! A divided surface → its figures and pictures.

use evencut_core::mesh::VertexId;
use evencut_core::regions::{Divided, Evenness, PartFigures, Region, Spacing, neighbours};
use evencut_output::preview::{RegionPicture, RegionsPicture};
use evencut_output::report::{DivisionFigures, PieceFigures, SpacingFigures, UndividedFigures};

/// The figures of a divided surface; `lengths`: of the passes of every region in the order of machining, mm.
pub fn figures(divided: &Divided, method: &str, lengths: &[f64]) -> DivisionFigures {
    let piece = |(part, &length): (&PartFigures, &f64)| {
        let Evenness { uniformity, least, most } = part.evenness;
        PieceFigures {
            area_mm2: part.area,
            uniformity,
            stretch_min: least,
            stretch_max: most,
            passes: part.passes as u64,
            length_mm: length,
            spacing: spacing(&part.spacing),
        }
    };
    let pieces: Vec<PieceFigures> = divided.parts.iter().zip(lengths).map(piece).collect();
    let area: f64 = pieces.iter().map(|p| p.area_mm2).sum();
    let whole = &divided.undivided;
    DivisionFigures {
        method: method.into(),
        count: pieces.len() as u64,
        uniformity_min: pieces.iter().map(|p| p.uniformity).fold(1.0, f64::min),
        uniformity_mean: pieces.iter().map(|p| p.area_mm2 * p.uniformity).sum::<f64>() / area,
        spacing: spacing(&divided.spacing()),
        length_mm: lengths.iter().sum(),
        undivided: UndividedFigures {
            uniformity: whole.evenness.uniformity,
            stretch_min: whole.evenness.least,
            stretch_max: whole.evenness.most,
            spacing: spacing(&whole.spacing),
            length_mm: whole.length,
        },
        pieces,
    }
}

fn spacing(spacing: &Spacing) -> SpacingFigures {
    SpacingFigures { mean: spacing.mean, deviation: spacing.deviation(), max: spacing.most }
}

/// The picture of a divided surface.
pub fn picture(divided: &Divided) -> RegionsPicture<'_> {
    let regions = &divided.regions;
    let split_mesh = &regions.split_mesh;
    let whole = regions.stretch.vertices();
    let at = |v: u32| -> f64 {
        split_mesh.means()[v as usize].iter().map(|&(v, w)| whole[v as usize] * w).sum()
    };
    let undivided_stretch =
        split_mesh.faces().iter().map(|f| f.iter().map(|&v| at(v)).sum::<f64>() / 3.0).collect();
    let parts = regions.list.iter().zip(neighbours(&regions.split_mesh, &regions.list));
    RegionsPicture {
        positions: split_mesh.positions(),
        faces: split_mesh.faces(),
        labels: split_mesh.labels(),
        undivided_stretch,
        regions: parts.map(|(part, neighbours)| region(part, neighbours)).collect(),
        order: &divided.order,
    }
}

fn region(part: &Region, neighbours: Vec<usize>) -> RegionPicture<'_> {
    let faces = part.piece.connectivity.faces();
    let mean = |f: &[VertexId; 3]| f.iter().map(|v| part.stretch[v.index()]).sum::<f64>() / 3.0;
    RegionPicture {
        faces: &part.piece.faces,
        stretch: faces.iter().map(mean).collect(),
        neighbours,
    }
}
