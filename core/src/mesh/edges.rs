//! Edges of any triangles, manifold or not, and what they join.

use crate::geometry::OrderBy;

/// A side of a face: `3 f + c` runs from corner `c` of face `f` to the next corner.
pub(super) type Side = u32;

/// Start and end vertex of a side.
pub(super) fn ends(faces: &[[u32; 3]], side: Side) -> (u32, u32) {
    let face = faces[side as usize / 3];
    let corner = side as usize % 3;
    (face[corner], face[(corner + 1) % 3])
}

/// The next side of the same face; a side stands for the corner it leaves, too.
pub(super) fn next_side(side: Side) -> Side {
    if side % 3 == 2 { side - 2 } else { side + 1 }
}

/// All sides grouped by the edge (unordered pair of vertices) they lie on.
pub(super) struct Edges {
    sides: Vec<Side>,
    /// `#E + 1` starts of the groups.
    start: Vec<u32>,
}

impl Edges {
    /// Groups the sides of `faces`, whose vertices are below `vertex_count`.
    pub fn new(vertex_count: usize, faces: &[[u32; 3]]) -> Self {
        // By the smaller vertex first (counting sort), then by the larger one in the short groups.
        let mut bucket = vec![0_u32; vertex_count + 1];
        let all = 0..3 * faces.len() as u32;
        let low = |side| {
            let (a, b) = ends(faces, side);
            a.min(b) as usize
        };
        for side in all.clone() {
            bucket[low(side) + 1] += 1;
        }
        for v in 0..vertex_count {
            bucket[v + 1] += bucket[v];
        }
        let mut fill = bucket.clone();
        let mut sides = vec![0; 3 * faces.len()];
        for side in all {
            let slot = &mut fill[low(side)];
            sides[*slot as usize] = side;
            *slot += 1;
        }
        let high = |side: Side| {
            let (a, b) = ends(faces, side);
            a.max(b)
        };
        let mut start = Vec::with_capacity(sides.len() / 2 + 1);
        for v in 0..vertex_count {
            let from = bucket[v] as usize;
            let group = &mut sides[from..bucket[v + 1] as usize];
            group.order_total_by_key(|&side| (high(side), side));
            for i in 0..group.len() {
                if i == 0 || high(group[i - 1]) != high(group[i]) {
                    start.push((from + i) as u32);
                }
            }
        }
        start.push(sides.len() as u32);
        Self { sides, start }
    }

    /// The edges, each as its sides in increasing order.
    pub fn iter(&self) -> impl Iterator<Item = &[Side]> {
        self.start.windows(2).map(|w| &self.sides[w[0] as usize..w[1] as usize])
    }

    /// Number of edges.
    pub fn len(&self) -> usize {
        self.start.len() - 1
    }
}

/// Disjoint sets of `0..n`; the root of a set is its smallest member.
pub(super) struct Sets(Vec<u32>);

impl Sets {
    pub fn new(n: usize) -> Self {
        Self((0..n as u32).collect())
    }

    pub fn root(&mut self, mut i: u32) -> u32 {
        while self.0[i as usize] != i {
            let parent = self.0[i as usize];
            self.0[i as usize] = self.0[parent as usize];
            i = parent;
        }
        i
    }

    pub fn join(&mut self, a: u32, b: u32) {
        let (a, b) = (self.root(a), self.root(b));
        self.0[a.max(b) as usize] = a.min(b);
    }
}

/// Corners grouped into fans: around a vertex, faces that hang together by edges.
///
/// Returns for every corner the smallest corner of its fan. A vertex with more than one fan is
/// non-manifold.
pub(super) fn fans(faces: &[[u32; 3]], edges: &Edges) -> Vec<u32> {
    let mut sets = Sets::new(3 * faces.len());
    for sides in edges.iter() {
        for pair in sides.windows(2) {
            let (h, g) = (pair[0], pair[1]);
            let same = ends(faces, h).0 == ends(faces, g).0;
            let (g_start, g_end) = if same { (g, next_side(g)) } else { (next_side(g), g) };
            sets.join(h, g_start);
            sets.join(next_side(h), g_end);
        }
    }
    (0..3 * faces.len() as u32).map(|corner| sets.root(corner)).collect()
}

/// For every face the smallest face of its component; components hang together by edges.
pub(super) fn component_roots(faces: &[[u32; 3]], edges: &Edges) -> Vec<u32> {
    let mut sets = Sets::new(faces.len());
    for sides in edges.iter() {
        for pair in sides.windows(2) {
            sets.join(pair[0] / 3, pair[1] / 3);
        }
    }
    (0..faces.len() as u32).map(|face| sets.root(face)).collect()
}
