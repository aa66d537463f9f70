//! What a mesh file holds, for a user who wants to know before writing a job.

use std::fmt;

use super::Surface;
use super::build::{
    Fault, Spot, SurfaceError, check_indices, several_pieces, short, topology_faults,
};
use crate::geometry::DVec3;
use crate::mesh::repair::{bounding_box, face_area, split_pinches};
use crate::mesh::{Connectivity, Judgement, Repairs, TriangleSoup, VertexId, judge, repair};

/// Concave radii above this many diagonals are the noise of flat or convex places.
const FLATTEST: f64 = 100.0;
/// Lengths of boundary loops and areas of components that are written out.
const LISTED: usize = 6;

/// The figures of a mesh, after repair, in the units of the file.
#[derive(Clone, Debug, PartialEq)]
pub struct Inspection {
    /// Vertices and faces as read.
    pub read: (usize, usize),
    /// What was repaired.
    pub repairs: Repairs,
    /// Topology of the whole mesh.
    pub judgement: Judgement,
    /// Total area.
    pub area: f64,
    /// Corners of the bounding box.
    pub bounds: (DVec3, DVec3),
    /// Shortest and longest edge.
    pub edges: (f64, f64),
    /// The tightest concave place, which limits the cutter's radius.
    pub concave: Concave,
    /// What keeps the whole mesh from being machined without a selection.
    pub faults: Vec<Fault>,
}

/// The tightest concave place of a mesh.
#[derive(Copy, Clone, Debug, PartialEq)]
pub enum Concave {
    /// Not measured: the mesh is not an oriented manifold.
    Unmeasured,
    /// Nothing is concave, or not more than a flat place with rounding.
    Nowhere,
    /// Smallest radius and where it is.
    Radius {
        /// The radius, in the units of the file.
        radius: f64,
        /// Where.
        at: DVec3,
    },
}

impl Inspection {
    /// Inspects a mesh; lengths stay in its units.
    ///
    /// # Errors
    /// [`SurfaceError::NoFaces`], [`SurfaceError::BadIndex`] or [`SurfaceError::NoArea`].
    pub fn new(soup: TriangleSoup) -> Result<Self, SurfaceError> {
        check_indices(&soup)?;
        let read = (soup.positions.len(), soup.faces.len());
        let repaired = repair(soup);
        let (mesh, repairs) = (repaired.mesh, repaired.repairs);
        if mesh.faces.is_empty() {
            return Err(SurfaceError::NoArea { faces: read.1 });
        }
        let judgement = judge(&mesh.positions, &mesh.faces);
        let bounds = bounding_box(&mesh.positions);
        Ok(Self {
            read,
            repairs,
            area: mesh.faces.iter().map(|face| face_area(&mesh.positions, *face)).sum(),
            bounds,
            edges: edge_range(&mesh),
            faults: several_pieces(&judgement, &mesh)
                .into_iter()
                .chain(topology_faults(&judgement))
                .collect(),
            concave: smallest_concave_radius(mesh, (bounds.1 - bounds.0).length()),
            judgement,
        })
    }
}

fn edge_range(mesh: &TriangleSoup) -> (f64, f64) {
    let at = |v: u32| mesh.positions[v as usize];
    let sides = mesh.faces.iter().flat_map(|&[a, b, c]| [(a, b), (b, c), (c, a)]);
    sides
        .map(|(a, b)| (at(b) - at(a)).length())
        .fold((f64::INFINITY, 0.0), |(low, high), l| (low.min(l), high.max(l)))
}

/// The smallest concave radius over all vertices.
fn smallest_concave_radius(mut mesh: TriangleSoup, diagonal: f64) -> Concave {
    split_pinches(&mut mesh, |_| true);
    let faces = mesh.faces.iter().map(|face| face.map(VertexId)).collect();
    let Ok(connectivity) = Connectivity::new(mesh.positions.len(), faces) else {
        return Concave::Unmeasured;
    };
    let surface = Surface::new(connectivity, mesh.positions);
    let field = surface.curvature(None);
    let lowest = field.operators().iter().map(|o| o.principal().0).zip(surface.positions());
    match lowest.min_by(|(a, _), (b, _)| a.total_cmp(b)) {
        Some((k, at)) if k * FLATTEST * diagonal < -1.0 => {
            Concave::Radius { radius: -1.0 / k, at: *at }
        }
        _ => Concave::Nowhere,
    }
}

impl fmt::Display for Inspection {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let j = &self.judgement;
        let (low, high) = self.bounds;
        let (shortest, longest) = self.edges;
        let areas: Vec<f64> = j.components.iter().map(|c| c.area).collect();
        let genus = j.genus.map_or("not defined".to_owned(), |genus| genus.to_string());
        writeln!(f, "read           {} vertices, {} faces", self.read.0, self.read.1)?;
        writeln!(f, "repaired       {}", self.repairs)?;
        writeln!(f, "mesh           {} vertices, {} faces", j.vertices, j.faces)?;
        writeln!(f, "components     {} (area {} mm²)", areas.len(), listed(&areas))?;
        let loops = &j.boundary_loops;
        match loops.len() {
            0 => writeln!(f, "boundary       none: the surface is closed")?,
            n => writeln!(f, "boundary loops {n} (length {} mm)", listed(loops))?,
        }
        writeln!(f, "genus          {genus} (Euler characteristic {})", j.euler)?;
        writeln!(f, "area           {} mm²", short(self.area))?;
        writeln!(f, "bounding box   {} to {} mm", Spot(low), Spot(high))?;
        writeln!(f, "edges          {} to {} mm", short(shortest), short(longest))?;
        f.write_str("tightest       ")?;
        match self.concave {
            Concave::Unmeasured => writeln!(f, "not measured: the mesh is not a manifold")?,
            Concave::Nowhere => writeln!(f, "no concave place")?,
            Concave::Radius { radius, at } => {
                writeln!(f, "concave radius {} mm at {}", short(radius), Spot(at))?
            }
        }
        for fault in &self.faults {
            writeln!(f, "fault          {fault}")?;
        }
        Ok(())
    }
}

/// The first few numbers, and how many more there are.
fn listed(values: &[f64]) -> String {
    let shown: Vec<String> = values.iter().take(LISTED).map(|v| short(*v)).collect();
    match values.len().saturating_sub(LISTED) {
        0 => shown.join(", "),
        more => format!("{}, and {more} more", shown.join(", ")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface::AnalyticSurface;

    #[test]
    fn a_bowl_is_reported_with_its_radius() {
        let bowl = AnalyticSurface::SphereCap { radius: -25.0, diameter: 30.0 }.mesh(0.7);
        let inspection = Inspection::new(bowl).unwrap();
        let Concave::Radius { radius, .. } = inspection.concave else { panic!("not concave") };
        assert!((radius / 25.0 - 1.0).abs() < 0.01, "{radius}");
        assert!(inspection.faults.is_empty());
        let rim = inspection.judgement.boundary_loops[0];
        assert!((rim / (std::f64::consts::PI * 30.0) - 1.0).abs() < 1e-3);
        let text = inspection.to_string();
        for word in ["components     1", "boundary loops 1 (length 94.2", "genus          0"] {
            assert!(text.contains(word), "{text}");
        }
    }

    #[test]
    fn a_dome_has_no_concave_place() {
        let dome = AnalyticSurface::SphereCap { radius: 25.0, diameter: 30.0 }.mesh(0.7);
        assert_eq!(Inspection::new(dome).unwrap().concave, Concave::Nowhere);
    }
}
