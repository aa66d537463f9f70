//! Pieces of a split mesh: connected faces with one label, as meshes of their own.

use super::split_mesh::{NONE, SplitMesh, next, previous};
use crate::geometry::{DVec2, DVec3};
use crate::mesh::{Connectivity, VertexId};
use crate::surface::Surface;
use std::collections::{BTreeMap, BTreeSet};

/// A piece of a split mesh as a mesh of its own: a disk, or a disk with holes.
///
/// Where a piece touches itself at a vertex, that vertex occurs twice.
#[derive(Clone, Debug)]
pub struct Piece {
    /// Half-edge connectivity.
    pub connectivity: Connectivity,
    /// `#V` vertices of the split mesh.
    pub vertices: Vec<u32>,
    /// `#F` faces of the split mesh.
    pub faces: Vec<u32>,
    /// Sides of the boundary, start and end, beyond which another piece lies.
    pub inner_border: BTreeSet<(VertexId, VertexId)>,
}

impl Piece {
    /// `#V` flat points.
    pub fn uv(&self, split_mesh: &SplitMesh) -> Vec<DVec2> {
        self.vertices.iter().map(|&v| split_mesh.uv()[v as usize]).collect()
    }

    /// The piece as a surface.
    pub fn surface(&self, split_mesh: &SplitMesh) -> Surface {
        let positions: Vec<DVec3> =
            self.vertices.iter().map(|&v| split_mesh.positions()[v as usize]).collect();
        Surface::new(self.connectivity.clone(), positions)
    }

    /// Area, mm².
    pub fn area(&self, split_mesh: &SplitMesh) -> f64 {
        self.faces.iter().map(|&f| split_mesh.area(f as usize)).sum()
    }
}

/// Connected groups of faces of a split mesh.
struct Groups<'a> {
    split_mesh: &'a SplitMesh,
    /// Group of every face of the split mesh; [`NONE`] for faces in no group.
    of_face: Vec<u32>,
    count: usize,
}

impl<'a> Groups<'a> {
    /// The connected faces with the same key, not separated by a line, in the order of their first faces.
    fn connected(split_mesh: &'a SplitMesh, faces: &[u32], key: impl Fn(u32) -> u32) -> Self {
        let mut keys = vec![NONE; split_mesh.faces().len()];
        faces.iter().for_each(|&f| keys[f as usize] = key(f));
        let mut of_face = vec![NONE; keys.len()];
        let mut count = 0;
        for &first in faces {
            if of_face[first as usize] != NONE {
                continue;
            }
            of_face[first as usize] = count;
            let mut open = vec![first];
            while let Some(f) = open.pop() {
                for h in [0, 1, 2].map(|k| 3 * f + k) {
                    let Some(g) = split_mesh.opposite(h).map(|o| o / 3) else { continue };
                    let is_same = keys[g as usize] == keys[f as usize] && !split_mesh.has_line(h);
                    if of_face[g as usize] == NONE && is_same {
                        of_face[g as usize] = count;
                        open.push(g);
                    }
                }
            }
            count += 1;
        }
        Self { split_mesh, of_face, count: count as usize }
    }

    /// Lengths of the borders between groups, mm, by pairs of groups, the smaller first.
    fn borders(&self, faces: &[u32]) -> BTreeMap<(u32, u32), f64> {
        let mut borders = BTreeMap::new();
        for h in faces.iter().flat_map(|f| [3 * f, 3 * f + 1, 3 * f + 2]) {
            let Some(o) = self.split_mesh.opposite(h).filter(|o| h < *o) else { continue };
            let (a, b) = (self.of_face[h as usize / 3], self.of_face[o as usize / 3]);
            if a != b && b != NONE {
                *borders.entry((a.min(b), a.max(b))).or_insert(0.0) += self.split_mesh.length(h);
            }
        }
        borders
    }

    /// For every group the one into which it is merged: groups smaller than `least` mm², the smallest first, go to
    /// the neighbour with the longest shared border.
    fn owners(&self, faces: &[u32], least: f64) -> Vec<u32> {
        let mut areas = vec![0.0; self.count];
        for &f in faces {
            areas[self.of_face[f as usize] as usize] += self.split_mesh.area(f as usize);
        }
        let mut borders = self.borders(faces);
        let mut owner: Vec<u32> = (0..self.count as u32).collect();
        let mut open: Vec<u32> = (0..self.count as u32).collect();
        loop {
            open.retain(|&p| owner[p as usize] == p && areas[p as usize] < least);
            let by_area = |a: &&u32, b: &&u32| areas[**a as usize].total_cmp(&areas[**b as usize]);
            let Some(&p) = open.iter().min_by(by_area) else { break };
            let touching = |&(a, b): &(u32, u32)| a == p || b == p;
            let of_p: Vec<_> =
                borders.iter().filter(|(k, _)| touching(k)).map(|(k, l)| (*k, *l)).collect();
            let Some(((a, b), _)) = of_p.iter().max_by(|a, b| a.1.total_cmp(&b.1)).copied() else {
                // All there is.
                open.retain(|&q| q != p);
                continue;
            };
            let into = if a == p { b } else { a };
            owner[p as usize] = into;
            areas[into as usize] += areas[p as usize];
            for ((a, b), length) in of_p {
                borders.remove(&(a, b));
                let other = if a == p { b } else { a };
                if other != into {
                    *borders.entry((other.min(into), other.max(into))).or_insert(0.0) += length;
                }
            }
        }
        (0..self.count as u32).map(|p| last(&owner, p)).collect()
    }
}

/// Where a chain of owners ends.
fn last(owner: &[u32], mut p: u32) -> u32 {
    while owner[p as usize] != p {
        p = owner[p as usize];
    }
    p
}

impl SplitMesh {
    /// Divides some faces into connected groups with the same key, not separated by a line; groups smaller than
    /// `least` mm² go to the neighbour with which they share the longest border.
    pub fn groups(&self, faces: &[u32], key: impl Fn(u32) -> u32, least: f64) -> Vec<Vec<u32>> {
        let groups = Groups::connected(self, faces, key);
        let owners = groups.owners(faces, least);
        let mut lists: Vec<Vec<u32>> = vec![Vec::new(); groups.count];
        for &f in faces {
            lists[owners[groups.of_face[f as usize] as usize] as usize].push(f);
        }
        lists.retain(|list| !list.is_empty());
        lists
    }

    /// The mesh of some faces; `None` if they are not a manifold, which cannot happen for faces of a manifold.
    pub fn piece(&self, faces: &[u32]) -> Option<Piece> {
        let mut is_in = vec![false; self.faces().len()];
        faces.iter().for_each(|&f| is_in[f as usize] = true);
        let same = |h: u32| self.opposite(h).filter(|o| is_in[*o as usize / 3]);
        // One vertex for every fan of faces around a vertex of the split mesh.
        let mut corner = vec![NONE; 3 * is_in.len()];
        let mut vertices = Vec::new();
        let sides = || faces.iter().flat_map(|f| [3 * f, 3 * f + 1, 3 * f + 2]);
        for h in sides() {
            if corner[h as usize] != NONE {
                continue;
            }
            let id = vertices.len() as u32;
            vertices.push(self.ends(h).0);
            let clockwise = core::iter::successors(same(h).map(next), |&g| same(g).map(next));
            let counter = core::iter::successors(same(previous(h)), |&g| same(previous(g)));
            corner[h as usize] = id;
            clockwise.take_while(|&g| g != h).for_each(|g| corner[g as usize] = id);
            counter.take_while(|&g| g != h).for_each(|g| corner[g as usize] = id);
        }
        let at = |h: u32| VertexId(corner[h as usize]);
        let triples = faces.iter().map(|f| [0, 1, 2].map(|k| at(3 * f + k))).collect();
        let inner = sides().filter(|&h| self.opposite(h).is_some() && same(h).is_none());
        Some(Piece {
            inner_border: inner.map(|h| (at(h), at(next(h)))).collect(),
            connectivity: Connectivity::new(vertices.len(), triples).ok()?,
            faces: faces.to_vec(),
            vertices,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::super::split_mesh::samples::{BUMP, middle};
    use super::*;

    #[test]
    fn small_groups_go_to_the_longest_border() {
        let (surface, chart) = &*BUMP;
        let split_mesh = SplitMesh::new(surface, chart);
        let all: Vec<u32> = (0..split_mesh.faces().len() as u32).collect();
        let stripe = |f: u32| {
            let x = split_mesh.uv()[split_mesh.faces()[f as usize][0] as usize].x - middle().x;
            u32::from(x > 0.0) + u32::from(x > 1.5)
        };
        assert!(split_mesh.groups(&all, stripe, 0.0).len() >= 3);
        let groups = split_mesh.groups(&all, stripe, 200.0);
        assert_eq!(groups.len(), 2);
        assert_eq!(groups.iter().map(Vec::len).sum::<usize>(), all.len());
    }

    /// Two faces that share a vertex only: the vertex is there twice.
    #[test]
    fn a_pinched_piece_is_a_manifold() {
        let (surface, chart) = &*BUMP;
        let split_mesh = SplitMesh::new(surface, chart);
        let inner = (0..split_mesh.uv().len() as u32).find(|&v| {
            let fan = split_mesh.around(v);
            fan.len() == 6 && split_mesh.opposite(fan[0]).is_some()
        });
        let fan = split_mesh.around(inner.unwrap());
        let faces = [fan[0] / 3, fan[3] / 3];
        let piece = split_mesh.piece(&faces).unwrap();
        assert_eq!(piece.vertices.len(), 6);
        assert_eq!(piece.connectivity.boundary_loops().len(), 2);
    }
}
