//! A piece of a surface → triangles within a chord error.
//!
//! Steps: edge lengths from the curvature ([`sizing`](super::sizing)), the boundary as points, a
//! coarse constrained Delaunay triangulation of the parameters ([`start`](super::start)),
//! refinement on the surface ([`refine`](super::refine)), then measuring: faces that are too far
//! off are split until none is.

use super::domain::{Domain, TrimLoop};
use super::error::NurbsError;
use super::refine::{Mesh, TooMany};
use super::sizing::{Limits, Sizing};
use super::start::Start;
use super::surface::NurbsSurface;
use crate::geometry::{DVec2, OrderBy};
use crate::mesh::TriangleSoup;
use crate::mesh::repair::compact;

/// Rounds of splitting the faces that are too far off the surface.
const ROUNDS: usize = 24;
/// Rounds that move vertices after the splits, and rounds that flip edges.
const SMOOTHED: usize = 10;
const FLIPPED: usize = 16;
/// Triangles that a mesh may have, in those estimated from the curvature, and how many more.
const ASTRAY: usize = 8;
const FEWEST: usize = 20_000;

/// What is asked of a mesh.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct MeshOptions {
    /// Largest distance between surface and mesh, mm.
    pub chord: f64,
    /// Longest edge in square roots of the area; smaller for a surface whose flat image matters.
    pub longest: f64,
    /// Most triangles.
    pub most_faces: usize,
}

impl Default for MeshOptions {
    /// 0.01 mm, some four thousand triangles at least, a million at most.
    fn default() -> Self {
        Self { chord: 0.01, longest: 0.025, most_faces: 1_000_000 }
    }
}

/// The piece of a surface that is meant.
#[derive(Clone, Debug, PartialEq)]
pub enum Trim {
    /// A rectangle: least and greatest parameters.
    Rectangle(DVec2, DVec2),
    /// What is at the left of these loops.
    Loops(Vec<TrimLoop>),
}

/// A mesh of a surface.
#[derive(Clone, Debug)]
pub struct NurbsMesh {
    /// Triangles, counter-clockwise in the parameters; the texture coordinates of their corners
    /// are the parameters, which go on without a jump within a face.
    pub soup: TriangleSoup,
    /// Largest distance between surface and mesh that was measured, mm.
    pub chord_error: f64,
}

/// Meshes the piece `trim` of `surface`; seams are closed and poles are single vertices. A piece without a boundary is
/// two halves side by side, each with its own vertices where they meet.
///
/// # Errors
/// [`NurbsError`] where its loops cross, or the chord error takes too many triangles or cannot be reached.
pub fn mesh(
    surface: &NurbsSurface,
    trim: Trim,
    options: MeshOptions,
) -> Result<NurbsMesh, NurbsError> {
    let whole = match trim {
        Trim::Rectangle(low, high) => (low, high),
        Trim::Loops(loops) if loops.is_empty() => surface.domain(),
        Trim::Loops(loops) => return mesh_of(surface, Domain::trimmed(surface, loops)?, options),
    };
    match halves(surface, whole) {
        None => mesh_of(surface, Domain::rectangle(surface, whole), options),
        Some([one, other]) => {
            let half = |piece| mesh_of(surface, Domain::rectangle(surface, piece), options);
            let (mut made, other) = (half(one)?, half(other)?);
            made.soup.add(other.soup);
            Ok(NurbsMesh { chord_error: made.chord_error.max(other.chord_error), ..made })
        }
    }
}

/// A rectangle of parameters, its least and its greatest.
type Rectangle = (DVec2, DVec2);

/// The halves of a rectangle of parameters of which no side is a boundary of the surface; `None` where one is.
fn halves(surface: &NurbsSurface, (low, high): Rectangle) -> Option<[Rectangle; 2]> {
    let around = surface.around((low, high));
    let axis = match around {
        [true, _] => 1,
        [false, false] => return None,
        [false, true] => 0,
    };
    let ends = surface.poles_of((low, high), axis);
    if !around[axis] && ends != [true; 2] {
        return None;
    }
    let (mut first, mut second) = ((low, high), (low, high));
    let middle = 0.5 * (low[axis] + high[axis]);
    first.1[axis] = middle;
    second.0[axis] = middle;
    Some([first, second])
}

/// Meshes a piece that has a boundary.
fn mesh_of(
    surface: &NurbsSurface,
    mut domain: Domain,
    options: MeshOptions,
) -> Result<NurbsMesh, NurbsError> {
    let MeshOptions { chord, longest, most_faces } = options;
    let sizing = Sizing::new(surface, (domain.low, domain.high), Limits { chord, longest });
    let estimate = sizing.triangles();
    let too_fine = |count: f64| {
        let at = surface.point(sizing.finest());
        NurbsError::TooFine { at, chord, count, most: most_faces }
    };
    // The estimate is of the whole rectangle, of which loops may leave a tenth.
    if estimate.is_nan() || estimate > 10.0 * most_faces as f64 {
        return Err(too_fine(estimate));
    }
    // Beyond some multiple the surface has a place that no triangle fits.
    let most = most_faces.min(ASTRAY * (estimate as usize) + FEWEST);
    domain.fit(&sizing);
    let start = Start::new(surface, &sizing, &domain, (chord, most))?;
    let mut mesh = Mesh::new(surface, &sizing, start, most);
    mesh.refine().map_err(|TooMany(count)| too_fine(count as f64))?;
    let chord_error = reach(&mut mesh, chord).map_err(|fault| match fault {
        Missed::TooMany(TooMany(count)) => too_fine(count as f64),
        Missed::At(at, error) => NurbsError::NotReached { at, error, chord },
    })?;
    let texture = Some(mesh.corners);
    let mut soup = TriangleSoup { positions: mesh.positions, faces: mesh.faces, texture };
    compact(&mut soup);
    Ok(NurbsMesh { soup, chord_error })
}

enum Missed {
    TooMany(TooMany),
    At(crate::geometry::DVec3, f64),
}

/// Splits until all faces are within `chord`; the largest error.
fn reach(mesh: &mut Mesh<'_>, chord: f64) -> Result<f64, Missed> {
    let mut worst = (0.0, 0);
    let mut errors: Vec<(f64, usize)> = Vec::new();
    for round in 0..ROUNDS {
        worst = (0.0, 0);
        let mut far: Vec<(f64, usize)> = Vec::new();
        errors.resize(mesh.faces.len(), (f64::NAN, 0));
        for (f, known) in errors.iter_mut().enumerate() {
            if round == 0 || mesh.is_changed(f) {
                *known = mesh.chord_error(f, chord);
            }
            let (error, side) = *known;
            if error > worst.0 {
                worst = (error, f);
            }
            if error > chord || error.is_nan() {
                far.push((error, side));
            }
        }
        if far.is_empty() {
            return Ok(worst.0);
        }
        far.order_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
        let sides = far.into_iter().map(|(_, side)| side).collect();
        mesh.split(sides).map_err(Missed::TooMany)?;
        // Flips and moves may undo what a split did; the last rounds go without.
        if round < FLIPPED {
            mesh.flip_all();
        }
        if round < SMOOTHED {
            mesh.smooth();
        }
    }
    Err(Missed::At(mesh.place(worst.1), worst.0))
}
