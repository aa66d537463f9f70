//! What keeps a piece of a mesh from being machined.

use thiserror::Error;

use super::message::{Spot, short};
use crate::geometry::DVec3;
use crate::mesh::{Judgement, TriangleSoup};

/// A fault of the piece to be machined.
#[derive(Copy, Clone, Debug, PartialEq, Error)]
pub enum Fault {
    /// There is more than one piece and the job does not say which.
    #[error(
        "{count} connected pieces (the two largest have {} and {} mm², the second one is at {}); one \
         is machined at a time: set surface.select.component to \"largest\" or to an index, or \
         close the cracks between them", short(*.largest), short(*.second), Spot(*.at)
    )]
    Pieces {
        /// Number of pieces.
        count: usize,
        /// Area of the largest, mm².
        largest: f64,
        /// Area of the next, mm².
        second: f64,
        /// A corner of the second one, mm.
        at: DVec3,
    },
    /// The piece has no boundary.
    #[error(
        "a closed surface of {faces} faces {}; a surface to machine has one: give \
         surface.steepest, which machines what the cutter reaches from above, or pick the faces with surface.select \
         (normal_within or a box)", without_boundary(*.slits)
    )]
    Closed {
        /// Number of faces.
        faces: usize,
        /// Number of boundary loops, none of which has an area.
        slits: usize,
    },
    /// Edges with more than two faces.
    #[error(
        "non-manifold edges (more than two faces meet): {count}, e.g. at {}; an edge has one or \
         two faces: mend the mesh there or leave it out with surface.select", Spot(*.at)
    )]
    NonManifoldEdges {
        /// How many.
        count: usize,
        /// Midpoint of one, mm.
        at: DVec3,
    },
    /// Vertices at which parts of the surface only touch.
    #[error(
        "non-manifold vertices (parts of the surface only touch there): {count}, e.g. at {}; mend \
         the mesh there or leave it out with surface.select", Spot(*.at)
    )]
    NonManifoldVertices {
        /// How many.
        count: usize,
        /// One of them, mm.
        at: DVec3,
    },
    /// The surface has one side only.
    #[error(
        "a non-orientable surface: at {count} edges, e.g. at {}, the faces cannot agree on a \
         side; cut the mesh open or leave a part out with surface.select", Spot(*.at)
    )]
    OneSided {
        /// Edges in conflict.
        count: usize,
        /// Midpoint of one, mm.
        at: DVec3,
    },
    /// The surface has handles.
    #[error(
        "genus {genus} (that many handles); a surface that can be laid flat has genus 0: select \
         a part of it with surface.select"
    )]
    Handles {
        /// Number of handles.
        genus: u64,
    },
    /// Faces without area that could not be dissolved.
    #[error(
        "{count} faces without area that cannot be dissolved, e.g. at {} (height below \
         {tolerance:.3e} mm); mend the mesh there", Spot(*.at)
    )]
    Flat {
        /// How many.
        count: usize,
        /// A corner of one, mm.
        at: DVec3,
        /// Largest height of such a face, mm.
        tolerance: f64,
    },
    /// Vertices whose faces fold back so that they have no normal.
    #[error(
        "{count} vertices without a normal, e.g. at {}: the faces there fold back onto each \
         other; mend the mesh there", Spot(*.at)
    )]
    NoNormal {
        /// How many.
        count: usize,
        /// One of them, mm.
        at: DVec3,
    },
}

fn without_boundary(slits: usize) -> String {
    match slits {
        0 => "without boundary".to_owned(),
        1 => "whose boundary is a slit without area".to_owned(),
        n => format!("whose boundary is {n} slits without area"),
    }
}

/// The fault of having more than one piece.
pub(super) fn several_pieces(judgement: &Judgement, mesh: &TriangleSoup) -> Option<Fault> {
    let [first, second, ..] = judgement.components[..] else { return None };
    let corner = mesh.faces[second.first_face as usize][0];
    let at = mesh.positions[corner as usize];
    let (count, largest) = (judgement.components.len(), first.area);
    Some(Fault::Pieces { count, largest, second: second.area, at })
}

/// What is wrong with the topology, apart from the number of pieces.
pub(super) fn topology_faults(judgement: &Judgement) -> Vec<Fault> {
    let mut faults = Vec::new();
    if judgement.is_closed() {
        let slits = judgement.boundary_loops.len();
        faults.push(Fault::Closed { faces: judgement.faces, slits });
    }
    if let Some(at) = judgement.nonmanifold_edges.example {
        faults.push(Fault::NonManifoldEdges { count: judgement.nonmanifold_edges.count, at });
    }
    if let Some(at) = judgement.nonmanifold_vertices.example {
        faults.push(Fault::NonManifoldVertices { count: judgement.nonmanifold_vertices.count, at });
    }
    if let Some(at) = judgement.orientation_conflicts.example {
        faults.push(Fault::OneSided { count: judgement.orientation_conflicts.count, at });
    }
    match judgement.genus {
        Some(genus) if genus > 0 => faults.push(Fault::Handles { genus }),
        _ => {}
    }
    faults
}
