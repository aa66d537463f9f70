//! Why triangles are not a surface that can be machined, in words.

use std::fmt;

use thiserror::Error;

use super::fault::Fault;
use super::message::Spot;
use crate::geometry::DVec3;
use crate::mesh::TopologyFault;

/// Largest coordinate after placing, mm; beyond it squares and cubes of lengths lose meaning.
pub(super) const FARTHEST: f64 = 1e12;

/// Why triangles are not a surface that can be machined.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum SurfaceError {
    /// The mesh is empty.
    #[error("surface: the mesh has no faces; give a file with at least one triangle")]
    NoFaces,
    /// A face names a vertex that is not there.
    #[error("surface: face {face} names vertex {vertex} of {vertices}; indices start at 0")]
    BadIndex {
        /// The face.
        face: usize,
        /// The vertex it names.
        vertex: u32,
        /// Number of vertices.
        vertices: usize,
    },
    /// A coordinate is too large or not a number.
    #[error(
        "surface: vertex {vertex} lands at {} mm; coordinates must stay below {FARTHEST:e} mm: \
         check surface.scale and surface.translate", Spot(*.at)
    )]
    TooFar {
        /// The vertex.
        vertex: usize,
        /// Where it lands, mm.
        at: DVec3,
    },
    /// No face has any area.
    #[error(
        "surface: none of the {faces} faces has an area; all corners coincide or lie on lines: \
         check the file and surface.scale"
    )]
    NoArea {
        /// Faces that were read.
        faces: usize,
    },
    /// Nothing was selected by the normal.
    #[error(
        "surface: surface.select.normal_within = {limit:.4} degrees of {} keeps none of {faces} \
         faces; their normals are between {nearest:.4} and {farthest:.4} degrees from it: allow \
         more than {nearest:.4}, or set surface.flip if the faces look the wrong way", Spot(*.of)
    )]
    NoNormalWithin {
        /// Largest angle allowed, degrees.
        limit: f64,
        /// Direction it is measured from.
        of: DVec3,
        /// Faces there were.
        faces: usize,
        /// Smallest angle of any face, degrees.
        nearest: f64,
        /// Largest angle of any face, degrees.
        farthest: f64,
    },
    /// Nothing was selected by the box.
    #[error(
        "surface: the box of surface.select from {} to {} mm keeps none of {faces} faces; the \
         part reaches from {} to {} mm: check surface.scale, surface.translate and the box",
        Spot(*.low), Spot(*.high), Spot(*.part_low), Spot(*.part_high)
    )]
    NoneInBox {
        /// Lower corner of the box, mm.
        low: DVec3,
        /// Upper corner of the box, mm.
        high: DVec3,
        /// Faces that the other conditions left.
        faces: usize,
        /// Lower corner of the part, mm.
        part_low: DVec3,
        /// Upper corner of the part, mm.
        part_high: DVec3,
    },
    /// There is no such component.
    #[error(
        "surface: surface.select.component = {index}, but there are {count} connected pieces; \
         they count from 0 in order of decreasing area"
    )]
    NoSuchComponent {
        /// The index asked for.
        index: u32,
        /// Number of components.
        count: usize,
    },
    /// The piece is not a manifold with boundary and without handles.
    #[error("surface: {}", Listed(.0))]
    Unusable(Vec<Fault>),
    /// The piece is not an oriented manifold.
    #[error("surface: {0}")]
    Topology(#[from] TopologyFault),
}

struct Listed<'a>(&'a [Fault]);

impl fmt::Display for Listed<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (i, fault) in self.0.iter().enumerate() {
            write!(f, "{}{fault}", if i == 0 { "" } else { "; also " })?;
        }
        Ok(())
    }
}
