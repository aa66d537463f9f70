//! The faces that the job's selection means.

use super::error::SurfaceError;
use super::fault::topology_faults;
use crate::geometry::DVec3;
use crate::geometry::math::acos_clamped;
use crate::job::{Component, Selection};
use crate::mesh::repair::{
    bounding_box, compact, orientation, retain_faces, split_pinches, turn_faces,
};
use crate::mesh::{Judgement, TriangleSoup, component_of, judge, nonmanifold_vertices};

/// Area that a piece must have, as a part of the largest one's, to be machined in its place;
/// a smaller one is hardly what was meant.
const WORTHWHILE: f64 = 0.5;
/// How many pieces, largest first, are looked at for one that can be machined.
const CANDIDATES: usize = 16;

/// The piece picked.
pub(super) struct Picked {
    /// Its faces; vertices of its own.
    pub piece: TriangleSoup,
    /// What it is.
    pub judgement: Judgement,
    /// Pieces left out, and their area, mm².
    pub left_out: (usize, f64),
    /// Pieces larger than this one that were passed over because they cannot be machined.
    pub passed_over: u32,
    /// Boundary vertices split because the selection left faces that only touched there.
    pub split: usize,
}

/// Applies the conditions, then the choice of component.
pub(super) fn pick(mut mesh: TriangleSoup, selection: &Selection) -> Result<Picked, SurfaceError> {
    let conditions = selection.normal_within.is_some() || selection.within_box.is_some();
    let split = if conditions { select_faces(&mut mesh, selection)? } else { 0 };
    let whole = judge(&mesh.positions, &mesh.faces);
    let count = whole.components.len();
    let number = match count {
        0 | 1 => Vec::new(),
        _ => component_of(&mesh.positions, &mesh.faces, &whole.components),
    };
    let (index, passed_over) = match selection.component {
        Component::Index(index) if index as usize >= count => {
            return Err(SurfaceError::NoSuchComponent { index, count });
        }
        // All of it, whatever was asked for.
        _ if count < 2 => (None, 0),
        Component::Only => (None, 0),
        Component::Largest => {
            let least = WORTHWHILE * whole.components.first().map_or(0.0, |c| c.area);
            let candidates = whole.components.iter().take(CANDIDATES).zip(0..);
            let usable =
                candidates.take_while(|(c, _)| c.area >= least).map(|(_, i)| i).find(|&i| {
                    let (_, judgement) = component(&mesh, &number, i);
                    topology_faults(&judgement).is_empty()
                });
            (Some(usable.unwrap_or(0)), usable.unwrap_or(0))
        }
        Component::Index(i) => (Some(i), 0),
    };
    let total: f64 = whole.components.iter().map(|c| c.area).sum();
    let (piece, judgement, left_out) = match index {
        None => (mesh, whole, (0, 0.0)),
        Some(i) => {
            let rest = total - whole.components[i as usize].area;
            let (piece, judgement) = component(&mesh, &number, i);
            (piece, judgement, (count - 1, rest))
        }
    };
    Ok(Picked { piece, judgement, left_out, passed_over, split })
}

/// One component with vertices of its own.
fn component(mesh: &TriangleSoup, number: &[u32], index: u32) -> (TriangleSoup, Judgement) {
    let mut piece = mesh.clone();
    retain_faces(&mut piece, |f, _| number[f] == index);
    compact(&mut piece);
    let judgement = judge(&piece.positions, &piece.faces);
    (piece, judgement)
}

/// Keeps the faces that meet the conditions; how many vertices had to be split.
fn select_faces(mesh: &mut TriangleSoup, selection: &Selection) -> Result<usize, SurfaceError> {
    let faulty = nonmanifold_vertices(&mesh.positions, &mesh.faces);
    select_by_normal(mesh, selection)?;
    select_by_box(mesh, selection)?;
    // Touching faces that the selection made are parted; those of the file stay for the judge.
    let split = split_pinches(mesh, |v| !faulty[v as usize]);
    compact(mesh);
    // A part of a surface with one side only may have two.
    let turn = orientation(&mesh.positions, &mesh.faces).turn;
    turn_faces(mesh, |f| turn[f]);
    Ok(split)
}

fn select_by_normal(mesh: &mut TriangleSoup, selection: &Selection) -> Result<(), SurfaceError> {
    let Some((limit, of)) = selection.normal_within else { return Ok(()) };
    let angles: Vec<f64> = mesh
        .faces
        .iter()
        .map(|face| {
            let [a, b, c] = face.map(|v| mesh.positions[v as usize]);
            acos_clamped((b - a).cross(c - a).normalize_or_zero().dot(of))
        })
        .collect();
    let faces = mesh.faces.len();
    retain_faces(mesh, |f, _| angles[f] <= limit);
    if !mesh.faces.is_empty() {
        return Ok(());
    }
    Err(SurfaceError::NoNormalWithin {
        limit: limit.to_degrees(),
        of,
        faces,
        nearest: angles.iter().copied().fold(f64::INFINITY, f64::min).to_degrees(),
        farthest: angles.iter().copied().fold(0.0, f64::max).to_degrees(),
    })
}

fn select_by_box(mesh: &mut TriangleSoup, selection: &Selection) -> Result<(), SurfaceError> {
    let Some((low, high)) = selection.within_box else { return Ok(()) };
    let faces = mesh.faces.len();
    let (part_low, part_high) = bounding_box(&mesh.positions);
    let positions = std::mem::take(&mut mesh.positions);
    let inside = |p: DVec3| p.cmpge(low).all() && p.cmple(high).all();
    let centroid = |face: [u32; 3]| face.map(|v| positions[v as usize]).iter().sum::<DVec3>() / 3.0;
    retain_faces(mesh, |_, face| inside(centroid(face)));
    mesh.positions = positions;
    if !mesh.faces.is_empty() {
        return Ok(());
    }
    Err(SurfaceError::NoneInBox { low, high, faces, part_low, part_high })
}
