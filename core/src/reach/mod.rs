//! The surface that an upright cutter leaves of a part: what of any part can be machined in one setup.
//!
//! - *Reached surface*: the lowest surface that the cutter, standing anywhere on the part, leaves; the part closed by
//!   the cutter. It is the part's own surface wherever the cutter fits, and the cutter's where that bridges a groove or
//!   a corner. Seen along the axis it is the graph of a height: without overhang, handle or fold, and nowhere more
//!   concave than the cutter. Passes on it need lifting only where it is not found exactly, beside walls mostly.
//! - *Set aside*: what faces away from the axis, lies in the shadow of something above it, or is steeper than the job
//!   machines.
//!
//! 1. The height at a place: where a needle stops that is let down on the part. If the cutter fits there, it is that
//!    of the reached surface; else the cutter is moved about until it reaches deepest over that place (`terrain`).
//! 2. A net of right triangles over the part, halved where heights deviate from them, and beside the outline (`net`).
//! 3. Triangles on the outline are cut where it crosses their sides (`trim`).
//!
//! The part may be any triangles: open or closed, of many pieces, with cracks, overlaps and folds.
//!
//! Source: closing by a structuring element, Serra, "Image Analysis and Mathematical Morphology", Academic Press 1982,
//! here of a solid and sampled; the net: Evans, Kirkpatrick, Townsend, "Right-triangulated irregular
//! networks", Algorithmica 30 (2001).

mod aside;
mod error;
mod facet;
mod lattice;
mod minimax;
mod net;
mod options;
mod outward;
mod terrain;
mod trim;

pub use aside::Aside;
pub use error::ReachError;
pub use options::ReachOptions;
pub use outward::turn_outward;

use crate::cutter_location::CheckMesh;
use crate::geometry::DVec3;
use crate::geometry::math::cos;
use crate::mesh::repair::{compact, retain_faces, split_pinches};
use crate::mesh::{Connectivity, FaceId, TriangleSoup, VertexId, component_of, judge};
use crate::surface::{Part, Surface};
use core::ops::Range;
use facet::area_normal;
use lattice::Lattice;
use net::Net;
use std::collections::BTreeMap;
use terrain::Terrain;

/// Pieces smaller than this are not machined, squared cutter radii.
const SMALLEST_PIECE: f64 = 0.02;

/// Bridges lower than this many times the accuracy are not reported; and what lies this many times it above the part
/// counts as a bridge, under which only the part can be cut into.
const BRIDGE: f64 = 4.0;
const ABOVE: f64 = 0.1;

/// Distances between the unit normals at the ends of a side (1 to 17 degrees) that lies across an edge which passes round
/// off. Sharper ones keep the normals that were found: beside rims of walls means of these left places above the limit.
const EDGE: Range<f64> = 0.02..0.3;

/// What of a part is machined in one setup.
#[derive(Clone, Debug)]
pub struct Reached {
    /// The surface that the cutter leaves; it may consist of several pieces.
    pub surface: Surface,
    /// Number of its pieces.
    pub pieces: usize,
    /// What of the part is not machined, in figures.
    pub aside: Aside,
    /// Over which of its faces the cutter bridges the part: a corner or the middle is above it.
    pub bridges: Vec<bool>,
    /// Which of its faces are the cutter's own surface: all corners are above the part.
    pub is_of_cutter: Vec<bool>,
    /// The faces of the part that are not machined.
    pub rest: Part,
}

/// The surface that the cutter leaves of the faces `machined` of a `part`.
///
/// # Errors
/// [`ReachError`] if there is none.
pub fn reach(part: &Part, machined: &Part, options: &ReachOptions) -> Result<Reached, ReachError> {
    let obstacle = CheckMesh::new(part.positions.clone(), part.faces.clone());
    let terrain = Terrain::new(&obstacle, part, machined, options);
    let (mut aside, own_rest) = aside::set_aside(&terrain, machined, options);
    let nothing = ReachError::Nothing {
        away: aside.away + aside.steep,
        shadowed: aside.shadowed,
        steepest: options.steepest.to_degrees(),
    };
    let lattice = Lattice::over(machined, options.tool.radius()).ok_or(nothing)?;
    let mut net = Net::new(&terrain, lattice, options);
    net.refine()?;
    net.refine_at(&machined.positions)?;
    net.settle();
    let (soup, normals) = trim::trimmed(&net, cos(options.steepest));
    let (soup, normals, pieces, small) = worthwhile(soup, &normals, options.tool.radius());
    aside.small = small;
    let connectivity = {
        let faces = soup.faces.iter().map(|f| f.map(VertexId)).collect();
        Connectivity::new(soup.positions.len(), faces).map_err(|_| nothing)?
    };
    if connectivity.face_count() == 0 {
        return Err(nothing);
    }
    let surface = Surface::new(connectivity, soup.positions);
    let [bridges, is_of_cutter] = bridges(&terrain, &surface, options, &mut aside);
    let normals = rounded(&surface, &is_of_cutter, normals);
    let surface = surface.with_normals(normals);
    let mut rest = part.without_faces(machined);
    rest.add(&own_rest);
    Ok(Reached { surface, pieces, aside, bridges, is_of_cutter, rest })
}

/// These normals at the vertices of a surface, but means of those of the faces around along edges of the part where it turns
/// away: the needle finds either face there, and passes along the edge would swing from one to the other.
fn rounded(surface: &Surface, is_of_cutter: &[bool], mut normals: Vec<DVec3>) -> Vec<DVec3> {
    // Of the edges at every vertex the sharpest.
    let mut turns = vec![0.0f64; normals.len()];
    let mut is_known = vec![true; normals.len()];
    for (face, is_of_cutter) in surface.connectivity().faces().iter().zip(is_of_cutter) {
        for (a, b) in [(0, 1), (1, 2), (2, 0)].map(|(a, b)| (face[a].index(), face[b].index())) {
            is_known[a] &= is_of_cutter;
            let turn = normals[b] - normals[a];
            let way = surface.positions()[b] - surface.positions()[a];
            if turn.dot(way) > 0.0 {
                turns[a] = turns[a].max(turn.length());
                turns[b] = turns[b].max(turn.length());
            }
        }
    }
    for (v, normal) in normals.iter_mut().enumerate() {
        if EDGE.contains(&turns[v]) && !is_known[v] {
            *normal = surface.vertex_normals()[v];
        }
    }
    normals
}

/// The faces over which the cutter bridges the part, a corner or the middle is above it; and those of which all corners
/// are. Their area by the middles.
fn bridges(
    terrain: &Terrain,
    surface: &Surface,
    options: &ReachOptions,
    aside: &mut Aside,
) -> [Vec<bool>; 2] {
    let faces: Vec<[DVec3; 3]> = (0..surface.connectivity().face_count() as u32)
        .map(|f| surface.corners(FaceId(f)))
        .collect();
    let middles: Vec<DVec3> = faces.iter().map(|[a, b, c]| (a + b + c) / 3.0).collect();
    let of_middles = terrain.above(&middles, options.threads);
    let of_corners = terrain.above(surface.positions(), options.threads);
    for (corners, &above) in faces.iter().zip(&of_middles) {
        if above > BRIDGE * options.accuracy {
            aside.bridged += 0.5 * area_normal(*corners).length();
            aside.deepest_bridged = aside.deepest_bridged.max(above);
        }
    }
    let is_above = |above: &f64| *above > ABOVE * options.accuracy;
    let corner_above = |v: &VertexId| is_above(&of_corners[v.0 as usize]);
    let faces = surface.connectivity().faces();
    let any = faces.iter().zip(&of_middles);
    let any = any.map(|(face, middle)| is_above(middle) || face.iter().any(corner_above));
    [any.collect(), faces.iter().map(|face| face.iter().all(corner_above)).collect()]
}

/// Without pieces that are too small for passes; how many remain, and the area of those left out, mm².
fn worthwhile(
    mut soup: TriangleSoup,
    normals: &[DVec3],
    radius: f64,
) -> (TriangleSoup, Vec<DVec3>, usize, f64) {
    // A corner at which pieces touch becomes several with the same place; so the place tells the normal.
    let keyed = |(p, n): (&DVec3, &DVec3)| (p.to_array().map(f64::to_bits), *n);
    let known: BTreeMap<[u64; 3], DVec3> = soup.positions.iter().zip(normals).map(keyed).collect();
    split_pinches(&mut soup, |_| true);
    let judgement = judge(&soup.positions, &soup.faces);
    let least = SMALLEST_PIECE * radius * radius;
    let is_small: Vec<bool> = judgement.components.iter().map(|c| c.area < least).collect();
    let small = judgement.components.iter().filter(|c| c.area < least).map(|c| c.area).sum();
    let pieces = is_small.iter().filter(|s| !**s).count();
    if pieces < is_small.len() {
        let number = component_of(&soup.positions, &soup.faces, &judgement.components);
        retain_faces(&mut soup, |f, _| !is_small[number[f] as usize]);
    }
    compact(&mut soup);
    let normal = |p: &DVec3| known.get(&p.to_array().map(f64::to_bits)).copied();
    let normals = soup.positions.iter().map(|p| normal(p).unwrap_or(DVec3::Z)).collect();
    (soup, normals, pieces, small)
}

#[cfg(test)]
mod tests;
