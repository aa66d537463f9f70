//! Half-edge connectivity of a manifold, consistently oriented triangle mesh; no positions.

use crate::geometry::OrderBy;
use thiserror::Error;

/// Index of a vertex.
#[derive(Copy, Clone, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub struct VertexId(pub u32);

/// Index of a face (triangle).
#[derive(Copy, Clone, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub struct FaceId(pub u32);

/// A side of a face: half-edge `3 f + c` runs from corner `c` of face `f` to corner `c + 1`.
#[derive(Copy, Clone, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub struct HalfEdgeId(pub u32);

impl VertexId {
    /// As an array index.
    pub fn index(self) -> usize {
        self.0 as usize
    }
}

impl FaceId {
    /// As an array index.
    pub fn index(self) -> usize {
        self.0 as usize
    }

    /// The half-edge that leaves corner `corner` (0, 1 or 2).
    pub fn half_edge(self, corner: usize) -> HalfEdgeId {
        HalfEdgeId(3 * self.0 + corner as u32)
    }
}

impl HalfEdgeId {
    /// As an array index.
    pub fn index(self) -> usize {
        self.0 as usize
    }

    /// The face it bounds.
    pub fn face(self) -> FaceId {
        FaceId(self.0 / 3)
    }

    /// The corner it leaves.
    pub fn corner(self) -> usize {
        (self.0 % 3) as usize
    }

    /// The next side of the same face.
    pub fn next(self) -> HalfEdgeId {
        HalfEdgeId(if self.0 % 3 == 2 { self.0 - 2 } else { self.0 + 1 })
    }

    /// The previous side of the same face.
    pub fn prev(self) -> HalfEdgeId {
        HalfEdgeId(if self.0.is_multiple_of(3) { self.0 + 2 } else { self.0 - 1 })
    }
}

/// Why faces do not form an oriented manifold.
#[derive(Copy, Clone, Debug, PartialEq, Eq, Error)]
pub enum TopologyFault {
    /// A directed side occurs twice: a non-manifold edge, or neighbours of opposite orientation.
    #[error("the side from vertex {from} to vertex {to} occurs in two faces in the same direction")]
    RepeatedSide {
        /// Start vertex.
        from: u32,
        /// End vertex.
        to: u32,
    },
    /// A face names a vertex twice or one that does not exist.
    #[error("face {face} repeats a vertex or names one that does not exist")]
    BadFace {
        /// The face.
        face: u32,
    },
    /// The boundary passes more than once through a vertex.
    #[error("the boundary passes more than once through vertex {vertex}")]
    PinchedVertex {
        /// The vertex.
        vertex: u32,
    },
}

const NONE: u32 = u32::MAX;

/// Half-edge connectivity of a manifold triangle mesh with consistent orientation.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Connectivity {
    faces: Vec<[VertexId; 3]>,
    opposite: Vec<u32>,
    /// A half-edge leaving each vertex; for a boundary vertex its boundary half-edge.
    leaving: Vec<u32>,
    loops: Vec<Vec<VertexId>>,
}

impl Connectivity {
    /// Joins the sides of `faces`, whose vertices are below `vertex_count`.
    ///
    /// # Errors
    /// [`TopologyFault`] when the faces are not an oriented manifold.
    pub fn new(vertex_count: usize, faces: Vec<[VertexId; 3]>) -> Result<Self, TopologyFault> {
        for (f, &[a, b, c]) in faces.iter().enumerate() {
            let known = [a, b, c].iter().all(|v| v.index() < vertex_count);
            if !known || a == b || b == c || c == a {
                return Err(TopologyFault::BadFace { face: f as u32 });
            }
        }
        let opposite = match_sides(vertex_count, &faces)?;
        let mut leaving = vec![NONE; vertex_count];
        for h in (0..opposite.len()).rev() {
            let v = faces[h / 3][h % 3].index();
            if leaving[v] == NONE || (opposite[h] == NONE && opposite[leaving[v] as usize] != NONE)
            {
                leaving[v] = h as u32;
            }
        }
        let loops = trace_boundary(&faces, &opposite, vertex_count)?;
        Ok(Self { faces, opposite, leaving, loops })
    }

    /// Number of vertices, used or not.
    pub fn vertex_count(&self) -> usize {
        self.leaving.len()
    }

    /// Number of faces.
    pub fn face_count(&self) -> usize {
        self.faces.len()
    }

    /// All faces, `#F` vertex triples, counter-clockwise seen from the tool.
    pub fn faces(&self) -> &[[VertexId; 3]] {
        &self.faces
    }

    /// The vertices of one face.
    pub fn face(&self, face: FaceId) -> [VertexId; 3] {
        self.faces[face.index()]
    }

    /// The same side seen from the neighbouring face; `None` on the boundary.
    pub fn opposite(&self, side: HalfEdgeId) -> Option<HalfEdgeId> {
        let o = self.opposite[side.index()];
        (o != NONE).then_some(HalfEdgeId(o))
    }

    /// Start and end vertex of a side.
    pub fn ends(&self, side: HalfEdgeId) -> (VertexId, VertexId) {
        let f = self.faces[side.face().index()];
        (f[side.corner()], f[side.next().corner()])
    }

    /// A side leaving `vertex`, the boundary one if there is one; `None` for an unused vertex.
    ///
    /// From it, `opposite(side.prev())` repeated visits every face around the vertex,
    /// counter-clockwise.
    pub fn leaving(&self, vertex: VertexId) -> Option<HalfEdgeId> {
        let h = self.leaving[vertex.index()];
        (h != NONE).then_some(HalfEdgeId(h))
    }

    /// Whether `vertex` lies on the boundary.
    pub fn is_boundary(&self, vertex: VertexId) -> bool {
        self.leaving(vertex).is_some_and(|h| self.opposite(h).is_none())
    }

    /// Boundary loops as vertex cycles with the surface on their left.
    pub fn boundary_loops(&self) -> &[Vec<VertexId>] {
        &self.loops
    }

    /// `V - E + F` over the used vertices.
    pub fn euler_characteristic(&self) -> i64 {
        let used = self.leaving.iter().filter(|&&h| h != NONE).count() as i64;
        let boundary = self.opposite.iter().filter(|&&o| o == NONE).count() as i64;
        let edges = (self.opposite.len() as i64 + boundary) / 2;
        used - edges + self.faces.len() as i64
    }
}

/// Pairs every side with the one that runs the other way, by sorting within each start vertex.
fn match_sides(vertex_count: usize, faces: &[[VertexId; 3]]) -> Result<Vec<u32>, TopologyFault> {
    // Sides grouped by their smaller vertex (counting sort), then matched inside the short groups.
    let mut start = vec![0u32; vertex_count + 1];
    let ends = |h: usize| (faces[h / 3][h % 3].0, faces[h / 3][(h % 3 + 1) % 3].0);
    let sides = 3 * faces.len();
    for h in 0..sides {
        let (a, b) = ends(h);
        start[a.min(b) as usize + 1] += 1;
    }
    for v in 0..vertex_count {
        start[v + 1] += start[v];
    }
    let mut fill = start.clone();
    let mut grouped = vec![0u32; sides];
    for h in 0..sides {
        let (a, b) = ends(h);
        let slot = &mut fill[a.min(b) as usize];
        grouped[*slot as usize] = h as u32;
        *slot += 1;
    }
    let mut opposite = vec![NONE; sides];
    for v in 0..vertex_count {
        let group = &mut grouped[start[v] as usize..start[v + 1] as usize];
        group.order_total_by_key(|&h| {
            let (a, b) = ends(h as usize);
            (a.max(b), h)
        });
        let mut i = 0;
        while i < group.len() {
            let (a, b) = ends(group[i] as usize);
            let same = group[i..]
                .iter()
                .take_while(|&&h| {
                    let (c, d) = ends(h as usize);
                    c.max(d) == a.max(b)
                })
                .count();
            let run = &group[i..i + same];
            let (first, rest) = (run[0], &run[1..]);
            match rest {
                [] => {}
                [second] if ends(*second as usize) == (b, a) => {
                    opposite[first as usize] = *second;
                    opposite[*second as usize] = first;
                }
                _ => return Err(TopologyFault::RepeatedSide { from: a, to: b }),
            }
            i += same;
        }
    }
    Ok(opposite)
}

/// Boundary cycles, in order of their smallest half-edge, with the surface on the left.
fn trace_boundary(
    faces: &[[VertexId; 3]],
    opposite: &[u32],
    vertex_count: usize,
) -> Result<Vec<Vec<VertexId>>, TopologyFault> {
    let mut next = vec![NONE; vertex_count];
    let boundary = || (0..opposite.len()).filter(|&h| opposite[h] == NONE);
    for h in boundary() {
        let (a, b) = (faces[h / 3][h % 3], faces[h / 3][(h % 3 + 1) % 3]);
        if next[a.index()] != NONE {
            return Err(TopologyFault::PinchedVertex { vertex: a.0 });
        }
        next[a.index()] = b.0;
    }
    let mut seen = vec![false; vertex_count];
    let mut loops = Vec::new();
    for h in boundary() {
        let mut v = faces[h / 3][h % 3];
        if seen[v.index()] {
            continue;
        }
        let mut cycle = Vec::new();
        while !seen[v.index()] {
            seen[v.index()] = true;
            cycle.push(v);
            v = VertexId(next[v.index()]);
        }
        loops.push(cycle);
    }
    Ok(loops)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mesh(vertices: usize, faces: &[[u32; 3]]) -> Result<Connectivity, TopologyFault> {
        Connectivity::new(vertices, faces.iter().map(|f| f.map(VertexId)).collect())
    }

    #[test]
    fn two_triangles_share_one_edge() {
        let c = mesh(4, &[[0, 1, 2], [0, 2, 3]]).unwrap();
        assert_eq!(c.opposite(HalfEdgeId(2)), Some(HalfEdgeId(3)));
        assert_eq!(c.euler_characteristic(), 1);
        assert_eq!(c.boundary_loops(), &[[0, 1, 2, 3].map(VertexId).to_vec()]);
    }

    #[test]
    fn tetrahedron_is_closed() {
        let c = mesh(4, &[[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]]).unwrap();
        assert_eq!(c.euler_characteristic(), 2);
        assert!(c.boundary_loops().is_empty());
    }

    #[test]
    fn faults_are_named() {
        let fin = mesh(5, &[[0, 1, 2], [1, 0, 3], [0, 1, 4]]);
        assert!(matches!(fin, Err(TopologyFault::RepeatedSide { .. })));
        let bow = mesh(5, &[[0, 1, 2], [2, 3, 4]]);
        assert_eq!(bow, Err(TopologyFault::PinchedVertex { vertex: 2 }));
        assert_eq!(mesh(2, &[[0, 1, 2]]), Err(TopologyFault::BadFace { face: 0 }));
    }
}
