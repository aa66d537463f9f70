//! Caps: faces that fill the holes of a surface while it is flattened.
//!
//! A hole is filled with the constrained Delaunay triangulation of its loop, seen along the loop's
//! mean normal, without new vertices. Where the loop seen so crosses itself, or a diagonal would
//! double an edge of the surface, a fan around a new centre vertex fills it instead.

use spade::handles::FixedFaceHandle;
use spade::{ConstrainedDelaunayTriangulation, Point2, Triangulation};

use crate::geometry::{DVec2, DVec3, OrderBy, any_perpendicular};
use crate::mesh::{Connectivity, VertexId};
use crate::surface::Surface;

/// The faces and positions of `surface` with every boundary loop but `open` filled.
pub(super) fn fill(surface: &Surface, open: usize) -> (Vec<[VertexId; 3]>, Vec<DVec3>) {
    let connectivity = surface.connectivity();
    let mut faces = connectivity.faces().to_vec();
    let mut positions = surface.positions().to_vec();
    for (i, cycle) in connectivity.boundary_loops().iter().enumerate() {
        if i == open {
            continue;
        }
        // Seen from the cap, the loop runs the other way.
        let cycle: Vec<VertexId> = cycle.iter().rev().copied().collect();
        match triangulate(&cycle, surface) {
            Some(cap) => faces.extend(cap),
            None => fan(&cycle, &mut faces, &mut positions),
        }
    }
    (faces, positions)
}

/// Joins every side of a loop to a new vertex at the loop's centre.
fn fan(cycle: &[VertexId], faces: &mut Vec<[VertexId; 3]>, positions: &mut Vec<DVec3>) {
    let sum: DVec3 = cycle.iter().map(|v| positions[v.index()]).sum();
    let centre = VertexId(positions.len() as u32);
    positions.push(sum / cycle.len() as f64);
    for (i, &v) in cycle.iter().enumerate() {
        faces.push([v, cycle[(i + 1) % cycle.len()], centre]);
    }
}

/// Triangles between the vertices of a loop, or `None` when its projection is not simple or a
/// diagonal is already an edge of the surface.
fn triangulate(cycle: &[VertexId], surface: &Surface) -> Option<Vec<[VertexId; 3]>> {
    let flat = project(cycle, surface.positions());
    let mut delaunay = ConstrainedDelaunayTriangulation::<Point2<f64>>::new();
    let mut handles = Vec::with_capacity(cycle.len());
    for p in &flat {
        handles.push(delaunay.insert(Point2::new(p.x, p.y)).ok()?);
    }
    if delaunay.num_vertices() != cycle.len() {
        return None;
    }
    for i in 0..cycle.len() {
        let (a, b) = (handles[i], handles[(i + 1) % cycle.len()]);
        if !delaunay.can_add_constraint(a, b) || !delaunay.add_constraint(a, b) {
            return None;
        }
    }
    let first = delaunay.get_edge_from_neighbors(handles[0], *handles.get(1)?)?;
    let inside = flood(&delaunay, first.face().fix());
    // Vertices were inserted in the order of the loop, so their indices are places in it.
    let cap: Vec<[VertexId; 3]> = inside
        .iter()
        .filter_map(|&f| delaunay.face(f).as_inner())
        .map(|f| f.vertices().map(|v| cycle[v.fix().index()]))
        .collect();
    let fills = cap.len() + 2 == cycle.len() && inside.len() == cap.len();
    (fills && !doubles_an_edge(&cap, cycle, surface.connectivity())).then_some(cap)
}

/// The faces reached from `start` without crossing a constraint.
fn flood(
    delaunay: &ConstrainedDelaunayTriangulation<Point2<f64>>,
    start: FixedFaceHandle<spade::handles::PossiblyOuterTag>,
) -> Vec<FixedFaceHandle<spade::handles::PossiblyOuterTag>> {
    let mut seen = vec![false; delaunay.num_all_faces()];
    seen[start.index()] = true;
    let mut reached = vec![start];
    let mut next = 0;
    while next < reached.len() {
        if let Some(face) = delaunay.face(reached[next]).as_inner() {
            for edge in face.adjacent_edges() {
                let other = edge.rev().face().fix();
                if !edge.is_constraint_edge() && !seen[other.index()] {
                    seen[other.index()] = true;
                    reached.push(other);
                }
            }
        }
        next += 1;
    }
    reached
}

/// Whether an inner edge of the cap joins two vertices that the surface joins already.
fn doubles_an_edge(cap: &[[VertexId; 3]], cycle: &[VertexId], connectivity: &Connectivity) -> bool {
    let mut sides: Vec<(VertexId, VertexId)> =
        (0..cycle.len()).map(|i| (cycle[i], cycle[(i + 1) % cycle.len()])).collect();
    sides.order_total();
    let is_diagonal = |&(a, b): &(VertexId, VertexId)| sides.binary_search(&(a, b)).is_err();
    cap.iter()
        .flat_map(|f| [(f[0], f[1]), (f[1], f[2]), (f[2], f[0])])
        .filter(is_diagonal)
        .any(|(a, b)| joined(connectivity, a, b))
}

/// Whether the surface has an edge between two vertices.
fn joined(connectivity: &Connectivity, a: VertexId, b: VertexId) -> bool {
    // `a` lies on the boundary, so the walk ends there.
    let mut side = connectivity.leaving(a);
    while let Some(s) = side {
        if connectivity.ends(s).1 == b || connectivity.ends(s.prev()).0 == b {
            return true;
        }
        side = connectivity.opposite(s.prev());
    }
    false
}

/// The loop seen along its mean normal, counter-clockwise.
fn project(cycle: &[VertexId], positions: &[DVec3]) -> Vec<DVec2> {
    let at = |i: usize| positions[cycle[i % cycle.len()].index()];
    let centre: DVec3 = (0..cycle.len()).map(at).sum::<DVec3>() / cycle.len() as f64;
    let area: DVec3 = (0..cycle.len()).map(|i| (at(i) - centre).cross(at(i + 1) - centre)).sum();
    let normal = area.try_normalize().unwrap_or(DVec3::Z);
    let x = any_perpendicular(normal);
    let y = normal.cross(x);
    (0..cycle.len()).map(|i| DVec2::new((at(i) - centre).dot(x), (at(i) - centre).dot(y))).collect()
}
