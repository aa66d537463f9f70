//! What a mesh is as a surface: pieces, boundary, genus, and where it is not a manifold.

use std::collections::BTreeMap;

use super::edges::{Edges, Sets, component_roots, ends, fans, next_side};
use super::repair::{face_area, orientation};
use crate::geometry::{DVec3, OrderBy};

/// Area of the openings of a closed surface, at most, over its own.
const SLITS: f64 = 1e-4;

/// A connected component; faces hang together by edges.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct ComponentSummary {
    /// Number of faces.
    pub faces: usize,
    /// Area, in the mesh's units squared.
    pub area: f64,
    /// The lowest face of it, by number.
    pub first_face: u32,
}

/// How often a fault occurs, and one place of it.
#[derive(Copy, Clone, Debug, PartialEq, Default)]
pub struct Occurrences {
    /// How often.
    pub count: usize,
    /// One place, if there is any.
    pub example: Option<DVec3>,
}

impl Occurrences {
    fn add(&mut self, place: DVec3) {
        self.count += 1;
        self.example.get_or_insert(place);
    }
}

/// The topology of a mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct Judgement {
    /// Number of faces.
    pub faces: usize,
    /// Number of vertices that faces use.
    pub vertices: usize,
    /// Components in order of decreasing area (ties: by first face).
    pub components: Vec<ComponentSummary>,
    /// Length of every boundary loop, longest first.
    pub boundary_loops: Vec<f64>,
    /// Area that the boundary loops enclose, as the length of each loop's area vector; a slit has none.
    pub openings: f64,
    /// `V - E + F`.
    pub euler: i64,
    /// Handles, summed over the components; `None` where it has no meaning (non-manifold or
    /// non-orientable).
    pub genus: Option<u64>,
    /// Edges on more than two faces; the example is an edge's midpoint.
    pub nonmanifold_edges: Occurrences,
    /// Vertices at which pieces only touch.
    pub nonmanifold_vertices: Occurrences,
    /// Edges at which no choice of orientation lets the faces agree; none if orientable.
    pub orientation_conflicts: Occurrences,
}

impl Judgement {
    /// Whether the faces enclose a solid: without boundary, or with slits only, as where the vertices of one wall lie on an
    /// edge of the next.
    pub fn is_closed(&self) -> bool {
        let area = self.components.iter().fold(0.0, |sum, c| sum + c.area);
        self.openings <= SLITS * area
    }
}

/// Judges faces whose vertices are below `positions.len()` and distinct in every face.
pub fn judge(positions: &[DVec3], faces: &[[u32; 3]]) -> Judgement {
    let edges = Edges::new(positions.len(), faces);
    let fan_of = fans(faces, &edges);
    let midpoint = |side| {
        let (a, b) = ends(faces, side);
        0.5 * (positions[a as usize] + positions[b as usize])
    };
    let mut nonmanifold_edges = Occurrences::default();
    for sides in edges.iter().filter(|sides| sides.len() > 2) {
        nonmanifold_edges.add(midpoint(sides[0]));
    }
    let mut orientation_conflicts = Occurrences::default();
    for side in orientation(positions, faces).conflicts {
        orientation_conflicts.add(midpoint(side));
    }
    let (vertices, fans, nonmanifold_vertices) = count_vertices(positions, faces, &fan_of);
    let components = components(positions, faces, &edges);
    let (boundary_loops, openings) = boundary_loops(positions, faces, &edges, &fan_of);
    let manifold = nonmanifold_edges.count == 0 && orientation_conflicts.count == 0;
    let flat = |corners: usize| corners as i64 - edges.len() as i64 + faces.len() as i64;
    // With touching pieces parted, every component has 2 - 2 genus - loops.
    let handles = 2 * components.len() as i64 - boundary_loops.len() as i64 - flat(fans);
    Judgement {
        faces: faces.len(),
        vertices,
        euler: flat(vertices),
        genus: manifold.then_some(handles.max(0) as u64 / 2),
        components,
        boundary_loops,
        openings,
        nonmanifold_edges,
        nonmanifold_vertices,
        orientation_conflicts,
    }
}

/// Used vertices, fans, and the vertices with more than one fan.
fn count_vertices(
    positions: &[DVec3],
    faces: &[[u32; 3]],
    fan_of: &[u32],
) -> (usize, usize, Occurrences) {
    let fans_at = fans_at(positions.len(), faces, fan_of);
    let mut several = Occurrences::default();
    for (v, _) in fans_at.iter().enumerate().filter(|(_, fans)| **fans > 1) {
        several.add(positions[v]);
    }
    let used = fans_at.iter().filter(|fans| **fans > 0).count();
    (used, fans_at.iter().map(|fans| *fans as usize).sum(), several)
}

/// Number of fans around every vertex.
fn fans_at(vertex_count: usize, faces: &[[u32; 3]], fan_of: &[u32]) -> Vec<u32> {
    let mut count = vec![0; vertex_count];
    for (corner, &root) in fan_of.iter().enumerate() {
        count[faces[corner / 3][corner % 3] as usize] += u32::from(root as usize == corner);
    }
    count
}

fn components(positions: &[DVec3], faces: &[[u32; 3]], edges: &Edges) -> Vec<ComponentSummary> {
    let (roots, mut list) = (component_roots(faces, edges), Vec::new());
    let mut number = vec![0; faces.len()];
    for (f, &root) in roots.iter().enumerate() {
        if root as usize == f {
            number[f] = list.len();
            list.push(ComponentSummary { faces: 0, area: 0.0, first_face: root });
        }
        let component = &mut list[number[root as usize]];
        component.faces += 1;
        component.area += face_area(positions, faces[f]);
    }
    list.order_by(|a, b| b.area.total_cmp(&a.area).then(a.first_face.cmp(&b.first_face)));
    list
}

/// What is summed along a boundary loop.
struct Loop {
    start: DVec3,
    length: f64,
    area: DVec3,
}

/// Lengths of connected chains of boundary edges, with touching pieces parted, and the area that they enclose.
fn boundary_loops(
    positions: &[DVec3],
    faces: &[[u32; 3]],
    edges: &Edges,
    fan_of: &[u32],
) -> (Vec<f64>, f64) {
    let boundary = || edges.iter().filter(|sides| sides.len() == 1).map(|sides| sides[0]);
    let mut sets = Sets::new(fan_of.len());
    for h in boundary() {
        sets.join(fan_of[h as usize], fan_of[next_side(h) as usize]);
    }
    let mut all = BTreeMap::<u32, Loop>::new();
    for h in boundary() {
        let [a, b] = <[u32; 2]>::from(ends(faces, h)).map(|v| positions[v as usize]);
        let at = all.entry(sets.root(fan_of[h as usize])).or_insert(Loop {
            start: a,
            length: 0.0,
            area: DVec3::ZERO,
        });
        at.length += a.distance(b);
        at.area += 0.5 * (a - at.start).cross(b - at.start);
    }
    let mut lengths: Vec<f64> = all.values().map(|l| l.length).filter(|l| *l > 0.0).collect();
    lengths.order_by(|a, b| b.total_cmp(a));
    (lengths, all.values().fold(0.0, |sum, l| sum + l.area.length()))
}

/// For every face the index of its component in [`Judgement::components`].
pub(crate) fn component_of(
    positions: &[DVec3],
    faces: &[[u32; 3]],
    components: &[ComponentSummary],
) -> Vec<u32> {
    let roots = component_roots(faces, &Edges::new(positions.len(), faces));
    let mut number = vec![0; faces.len()];
    for (i, component) in components.iter().enumerate() {
        number[component.first_face as usize] = i as u32;
    }
    roots.iter().map(|root| number[*root as usize]).collect()
}

/// For every vertex whether pieces of surface only touch there.
pub(crate) fn nonmanifold_vertices(positions: &[DVec3], faces: &[[u32; 3]]) -> Vec<bool> {
    let fan_of = fans(faces, &Edges::new(positions.len(), faces));
    fans_at(positions.len(), faces, &fan_of).iter().map(|fans| *fans > 1).collect()
}
