//! Repairs that lose no shape: weld, drop what is degenerate or doubled, turn faces one way.
//!
//! In order: unreferenced vertices are dropped, vertices within a tolerance welded, faces that
//! then repeat a vertex and faces that occur twice dropped, faces without area dissolved into
//! their neighbours, and each component's faces turned to face the same way.

use super::edges::{Edges, Side, ends, fans};
use super::soup::TriangleSoup;
use super::weld::weld;
use crate::geometry::{DVec3, OrderBy};

/// Welding tolerance as a part of the bounding box's diagonal.
///
/// Larger values close cracks that were meant, smaller ones miss the last digits of text files.
const WELD: f64 = 1e-9;

/// Rounds of dissolving; rows of faces without area may need several.
const DISSOLVE_ROUNDS: usize = 16;

const NONE: u32 = u32::MAX;

/// What was repaired.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Repairs {
    /// Distance within which vertices were welded, in the mesh's units.
    pub tolerance: f64,
    /// Vertices that no face names, dropped.
    pub unreferenced: usize,
    /// Vertices welded to one in exactly the same place.
    pub welded: usize,
    /// Vertices welded to one that was not in exactly the same place.
    pub moved: usize,
    /// Faces that named a vertex twice, before or after welding; dropped.
    pub collapsed: usize,
    /// Faces with the same three vertices as another one, dropped.
    pub duplicates: usize,
    /// Faces without area, dissolved into their neighbours.
    pub dissolved: usize,
    /// Faces turned over to agree with their neighbours.
    pub reoriented: usize,
}

/// A mesh after repair; no vertex is unused and no face names a vertex twice.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Repaired {
    /// The mesh, in the units it came in.
    pub mesh: TriangleSoup,
    /// What was done to it.
    pub repairs: Repairs,
}

/// Repairs `soup`, whose indices must be below its number of vertices.
///
/// Non-manifold edges and vertices and surfaces with one side only are left as they are, for
/// [`judge`](super::judge()) to report.
pub fn repair(soup: TriangleSoup) -> Repaired {
    let mut mesh = soup;
    let mut repairs = Repairs::default();
    weld_vertices(&mut mesh, &mut repairs);
    repairs.collapsed = retain_faces(&mut mesh, |_, [a, b, c]| a != b && b != c && c != a);
    drop_duplicates(&mut mesh, &mut repairs);
    dissolve(&mut mesh, &mut repairs);
    compact(&mut mesh);
    let turn = orientation(&mesh.positions, &mesh.faces).turn;
    repairs.reoriented = turn.iter().filter(|t| **t).count();
    turn_faces(&mut mesh, |f| turn[f]);
    Repaired { mesh, repairs }
}

/// Keeps the faces that `keep` (face number, vertices) says, with their texture; how many went.
pub(crate) fn retain_faces(
    mesh: &mut TriangleSoup,
    keep: impl Fn(usize, [u32; 3]) -> bool,
) -> usize {
    let before = mesh.faces.len();
    let kept: Vec<bool> = mesh.faces.iter().enumerate().map(|(f, face)| keep(f, *face)).collect();
    let mut flags = kept.iter();
    mesh.faces.retain(|_| flags.next().is_some_and(|k| *k));
    if let Some(texture) = &mut mesh.texture {
        let mut flags = kept.iter();
        texture.retain(|_| flags.next().is_some_and(|k| *k));
    }
    before - mesh.faces.len()
}

/// Turns over the faces that `turn` names.
pub(crate) fn turn_faces(mesh: &mut TriangleSoup, turn: impl Fn(usize) -> bool) {
    for (f, face) in mesh.faces.iter_mut().enumerate() {
        if turn(f) {
            face.swap(1, 2);
            if let Some(texture) = &mut mesh.texture {
                texture[f].swap(1, 2);
            }
        }
    }
}

/// Drops unused vertices, keeping the order of the others; how many went.
pub(crate) fn compact(mesh: &mut TriangleSoup) -> usize {
    let mut number = vec![NONE; mesh.positions.len()];
    for v in mesh.faces.iter().flatten() {
        number[*v as usize] = 0;
    }
    let mut kept = Vec::with_capacity(mesh.positions.len());
    for (v, slot) in number.iter_mut().enumerate() {
        if *slot == 0 {
            *slot = kept.len() as u32;
            kept.push(mesh.positions[v]);
        }
    }
    let dropped = mesh.positions.len() - kept.len();
    for v in mesh.faces.iter_mut().flatten() {
        *v = number[*v as usize];
    }
    mesh.positions = kept;
    dropped
}

/// Corners of the axis-parallel box around `positions`; zero for none.
pub(crate) fn bounding_box(positions: &[DVec3]) -> (DVec3, DVec3) {
    let low = positions.iter().copied().reduce(DVec3::min).unwrap_or_default();
    let high = positions.iter().copied().reduce(DVec3::max).unwrap_or_default();
    (low, high)
}

fn weld_vertices(mesh: &mut TriangleSoup, repairs: &mut Repairs) {
    repairs.unreferenced = compact(mesh);
    let (low, high) = bounding_box(&mesh.positions);
    repairs.tolerance = (WELD * (high - low).length()).max(f64::MIN_POSITIVE);
    let first = weld(&mesh.positions, repairs.tolerance);
    for (v, &to) in first.iter().enumerate() {
        if to as usize != v {
            let exact = mesh.positions[v] == mesh.positions[to as usize];
            *(if exact { &mut repairs.welded } else { &mut repairs.moved }) += 1;
        }
    }
    for v in mesh.faces.iter_mut().flatten() {
        *v = first[*v as usize];
    }
    compact(mesh);
}

fn drop_duplicates(mesh: &mut TriangleSoup, repairs: &mut Repairs) {
    let mut order: Vec<([u32; 3], u32)> = mesh
        .faces
        .iter()
        .zip(0..)
        .map(|(face, f)| {
            let mut sorted = *face;
            sorted.order_total();
            (sorted, f)
        })
        .collect();
    order.order_total();
    let mut doubled = vec![false; mesh.faces.len()];
    for pair in order.windows(2) {
        doubled[pair[1].1 as usize] = pair[0].0 == pair[1].0;
    }
    repairs.duplicates = retain_faces(mesh, |f, _| !doubled[f]);
}

/// Height of a triangle over its longest side, and the corner that side leaves.
fn height(positions: &[DVec3], face: [u32; 3]) -> (f64, usize) {
    let p = face.map(|v| positions[v as usize]);
    let side = |i: usize| (p[(i + 1) % 3] - p[i]).length();
    let longest = (1..3).fold(0, |best, i| if side(i) > side(best) { i } else { best });
    let twice_area = (p[1] - p[0]).cross(p[2] - p[0]).length();
    (twice_area / side(longest), longest)
}

/// Whether a face has no area: its height is within the tolerance.
pub(crate) fn is_flat(positions: &[DVec3], face: [u32; 3], tolerance: f64) -> bool {
    // A NaN height (all corners in one place) counts as flat.
    let height = height(positions, face).0;
    height <= tolerance || height.is_nan()
}

/// Removes faces whose corners lie on a line.
///
/// Dropping such a face would open a slit, so its middle corner is put into the neighbour across
/// its longest side, which becomes two faces. On the boundary it is simply dropped.
fn dissolve(mesh: &mut TriangleSoup, repairs: &mut Repairs) {
    let tolerance = repairs.tolerance;
    let count = |mesh: &TriangleSoup| {
        mesh.faces.iter().filter(|f| is_flat(&mesh.positions, **f, tolerance)).count()
    };
    let before = count(mesh);
    let mut left = before;
    for _ in 0..DISSOLVE_ROUNDS {
        if left == 0 {
            break;
        }
        dissolve_round(mesh, tolerance);
        left = count(mesh);
    }
    repairs.dissolved = before.saturating_sub(left);
}

fn dissolve_round(mesh: &mut TriangleSoup, tolerance: f64) {
    let mut across = vec![Across::Several; 3 * mesh.faces.len()];
    for sides in Edges::new(mesh.positions.len(), &mesh.faces).iter() {
        match *sides {
            [h] => across[h as usize] = Across::Nothing,
            [h, g] => {
                across[h as usize] = Across::Side(g);
                across[g as usize] = Across::Side(h);
            }
            _ => {}
        }
    }
    let mut touched = vec![false; mesh.faces.len()];
    let mut dropped = vec![false; mesh.faces.len()];
    for f in 0..mesh.faces.len() {
        let (height, longest) = height(&mesh.positions, mesh.faces[f]);
        if height > tolerance || touched[f] {
            continue;
        }
        match across[3 * f + longest] {
            Across::Nothing => (touched[f], dropped[f]) = (true, true),
            Across::Side(g) if !touched[g as usize / 3] => {
                (touched[f], touched[g as usize / 3]) = (true, true);
                split_neighbour(mesh, f, (longest + 2) % 3, g);
            }
            _ => {}
        }
    }
    retain_faces(mesh, |f, _| !dropped[f]);
}

/// What lies across a side.
#[derive(Copy, Clone)]
enum Across {
    /// The boundary.
    Nothing,
    /// One other face's side.
    Side(Side),
    /// More than one other face.
    Several,
}

/// Splits the face of side `g` at corner `middle` of the flat face `f`, which becomes one half.
fn split_neighbour(mesh: &mut TriangleSoup, f: usize, middle: usize, g: Side) {
    let (u, from) = (g as usize / 3, g as usize % 3);
    let (to, tip) = ((from + 1) % 3, (from + 2) % 3);
    let (neighbour, c) = (mesh.faces[u], mesh.faces[f][middle]);
    mesh.faces[u] = [neighbour[from], c, neighbour[tip]];
    mesh.faces[f] = [c, neighbour[to], neighbour[tip]];
    if let Some(texture) = &mut mesh.texture {
        let (neighbour, c) = (texture[u], texture[f][middle]);
        texture[u] = [neighbour[from], c, neighbour[tip]];
        texture[f] = [c, neighbour[to], neighbour[tip]];
    }
}

/// Which faces to turn over so that neighbours agree, and where that is impossible.
pub(crate) struct Orientation {
    /// Per face.
    pub turn: Vec<bool>,
    /// One side of each edge whose faces cannot agree: the surface has one side only.
    pub conflicts: Vec<Side>,
}

/// Floods every component over its manifold edges; the orientation of most of its area wins.
pub(crate) fn orientation(positions: &[DVec3], faces: &[[u32; 3]]) -> Orientation {
    let mut across = vec![NONE; 3 * faces.len()];
    for sides in Edges::new(positions.len(), faces).iter() {
        if let [h, g] = *sides {
            across[h as usize] = g;
            across[g as usize] = h;
        }
    }
    let agree = |h: Side, g: Side| ends(faces, h).0 != ends(faces, g).0;
    let mut turn = vec![false; faces.len()];
    let mut seen = vec![false; faces.len()];
    let mut piece: Vec<u32> = Vec::new();
    for start in 0..faces.len() {
        if seen[start] {
            continue;
        }
        seen[start] = true;
        piece.clear();
        piece.push(start as u32);
        let mut at = 0;
        while at < piece.len() {
            let f = piece[at];
            at += 1;
            for h in 3 * f..3 * f + 3 {
                let g = across[h as usize];
                if g != NONE && !seen[g as usize / 3] {
                    seen[g as usize / 3] = true;
                    turn[g as usize / 3] = turn[f as usize] == agree(h, g);
                    piece.push(g / 3);
                }
            }
        }
        settle_majority(positions, faces, &piece, &mut turn);
    }
    let conflicts = (0..3 * faces.len() as u32)
        .filter(|&h| {
            let g = across[h as usize];
            let turned = |side: Side| turn[side as usize / 3];
            g != NONE && h < g && agree(h, g) != (turned(h) == turned(g))
        })
        .collect();
    Orientation { turn, conflicts }
}

/// Reverses the choice for a component if most of its area would be turned over.
fn settle_majority(positions: &[DVec3], faces: &[[u32; 3]], piece: &[u32], turn: &mut [bool]) {
    let area = |f: u32| face_area(positions, faces[f as usize]);
    let signed: f64 =
        piece.iter().map(|&f| if turn[f as usize] { area(f) } else { -area(f) }).sum();
    if signed > 0.0 {
        for &f in piece {
            turn[f as usize] = !turn[f as usize];
        }
    }
}

/// Area of one face.
pub(crate) fn face_area(positions: &[DVec3], face: [u32; 3]) -> f64 {
    let [a, b, c] = face.map(|v| positions[v as usize]);
    0.5 * (b - a).cross(c - a).length()
}

/// Gives every fan of faces around a vertex that `may_split` names, but the first, a vertex of its
/// own, so that the boundary passes the vertex once; how many vertices were added.
pub(crate) fn split_pinches(mesh: &mut TriangleSoup, may_split: impl Fn(u32) -> bool) -> usize {
    let edges = Edges::new(mesh.positions.len(), &mesh.faces);
    let fans = fans(&mesh.faces, &edges);
    let before = mesh.positions.len();
    // The vertex of a fan: its own for the first fan of a vertex, else a new one.
    let mut taken = vec![false; before];
    let mut vertex = vec![NONE; fans.len()];
    for (corner, root) in fans.iter().enumerate() {
        let root = *root as usize;
        let v = mesh.faces[corner / 3][corner % 3];
        if vertex[root] == NONE {
            vertex[root] = if taken[v as usize] && may_split(v) {
                mesh.positions.push(mesh.positions[v as usize]);
                mesh.positions.len() as u32 - 1
            } else {
                taken[v as usize] = true;
                v
            };
        }
    }
    for (corner, root) in fans.iter().enumerate() {
        mesh.faces[corner / 3][corner % 3] = vertex[*root as usize];
    }
    mesh.positions.len() - before
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::DVec2;
    use crate::mesh::judge;

    fn soup(positions: &[(f64, f64)], faces: &[[u32; 3]]) -> TriangleSoup {
        let positions: Vec<DVec3> = positions.iter().map(|&(x, y)| DVec3::new(x, y, 0.0)).collect();
        // Texture coordinates equal to the positions show whether corners keep theirs.
        let texture = faces.iter().map(|f| f.map(|v| positions[v as usize].truncate())).collect();
        TriangleSoup { positions, faces: faces.to_vec(), texture: Some(texture) }
    }

    fn texture_follows(mesh: &TriangleSoup) -> bool {
        let texture = mesh.texture.as_deref().unwrap_or_default();
        let own = |f: &[u32; 3]| f.map(|v| mesh.positions[v as usize].truncate());
        texture.len() == mesh.faces.len() && mesh.faces.iter().map(own).eq(texture.iter().copied())
    }

    fn area(mesh: &TriangleSoup) -> f64 {
        mesh.faces.iter().map(|f| face_area(&mesh.positions, *f)).sum()
    }

    #[test]
    fn a_face_without_area_is_dissolved_without_a_slit() {
        // A square whose lower half is split at the diagonal's middle, the upper half is not: the
        // flat face 0 4 2 fills the slit between.
        let square = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0), (0.5, 0.5)];
        let faces = [[0, 1, 4], [1, 2, 4], [0, 4, 2], [0, 2, 3]];
        let Repaired { mesh, repairs } = repair(soup(&square, &faces));
        assert_eq!(repairs.dissolved, 1);
        assert!((area(&mesh) - 1.0).abs() < 1e-15);
        let judgement = judge(&mesh.positions, &mesh.faces);
        assert_eq!((judgement.faces, judgement.boundary_loops.len()), (4, 1));
        assert!((judgement.boundary_loops[0] - 4.0).abs() < 1e-15);
        assert!(texture_follows(&mesh));
    }

    #[test]
    fn a_row_of_flat_faces_is_dissolved() {
        let points =
            [(0.0, 0.0), (4.0, 0.0), (2.0, -3.0), (2.0, 3.0), (1.0, 0.0), (2.0, 0.0), (3.0, 0.0)];
        // Below, the edge from 0 to 1 is cut at 4, 5 and 6; above, it is whole.
        let faces = [
            [0, 2, 4],
            [4, 2, 5],
            [5, 2, 6],
            [6, 2, 1],
            [0, 4, 5],
            [0, 5, 6],
            [0, 6, 1],
            [0, 1, 3],
        ];
        let Repaired { mesh, repairs } = repair(soup(&points, &faces));
        assert_eq!(repairs.dissolved, 3);
        assert!((area(&mesh) - 12.0).abs() < 1e-12);
        assert!(mesh.faces.iter().all(|f| !is_flat(&mesh.positions, *f, repairs.tolerance)));
        assert_eq!(judge(&mesh.positions, &mesh.faces).boundary_loops.len(), 1);
        assert!(texture_follows(&mesh));
    }

    #[test]
    fn most_of_the_area_decides_the_side() {
        let points = [(0.0, 0.0), (9.0, 0.0), (9.0, 9.0), (0.0, 9.0), (10.0, 0.0)];
        // The two large faces look up, the small one down.
        let Repaired { mesh, repairs } = repair(soup(&points, &[[1, 2, 4], [0, 1, 2], [0, 2, 3]]));
        assert_eq!(repairs.reoriented, 1);
        assert_eq!(mesh.faces[0], [1, 4, 2]);
        assert!(texture_follows(&mesh));
    }

    #[test]
    fn repairing_twice_changes_nothing() {
        let points = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0), (1.0, 1.0), (7.0, 7.0)];
        let faces = [[0, 1, 2], [0, 4, 3], [0, 1, 4], [3, 3, 1]];
        let once = repair(soup(&points, &faces));
        let (welded, tolerance) = (once.repairs.welded, once.repairs.tolerance);
        assert_eq!((welded, once.repairs.unreferenced), (1, 1));
        assert_eq!((once.repairs.collapsed, once.repairs.duplicates), (1, 1));
        let twice = repair(once.mesh.clone());
        assert_eq!(twice.mesh, once.mesh);
        assert_eq!(twice.repairs, Repairs { tolerance, ..Repairs::default() });
        assert_eq!(twice.mesh.texture.unwrap()[0][1], DVec2::X);
    }
}
