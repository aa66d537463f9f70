//! Fill-reducing elimination orders for graphs whose nodes have positions.
//!
//! Terms. A *separator* is a set of nodes whose removal splits the rest in two; eliminating it
//! last keeps the two parts from filling each other (George 1973). Here it is found by a median
//! plane across the longest side of the part's bounding box. Parts of at most [`LEAF`] nodes are
//! ordered by minimum degree, where the *halo*, the neighbours already in separators, counts.

use super::matrix::Adjacency;
use crate::geometry::DVec3;

/// Largest part ordered by minimum degree: a larger one costs time, a smaller one fill.
const LEAF: usize = 96;
/// Words of the bit sets of a leaf and its halo.
const WORDS: usize = 3;

type Bits = [u64; WORDS];

/// A fill-reducing elimination order by nested dissection with planes.
///
/// `points`: one position per node. Returns the nodes in the order of elimination.
///
/// # Source
/// George, "Nested dissection of a regular finite element mesh", SIAM J. Numer. Anal. 10, 1973.
pub fn nested_dissection(graph: &Adjacency, points: &[DVec3]) -> Vec<u32> {
    let n = graph.size();
    let mut order: Vec<u32> = (0..n as u32).collect();
    let mut dissection = Dissection {
        graph,
        points,
        part: vec![0; n],
        parts: 1,
        keyed: Vec::with_capacity(n),
        leaf: Leaf::new(n),
    };
    let mut open = vec![(0, n)];
    while let Some((from, to)) = open.pop() {
        let nodes = &mut order[from..to];
        if nodes.len() <= LEAF {
            dissection.leaf.order(graph, nodes);
            continue;
        }
        let (left, right) = dissection.split(nodes);
        open.push((from, from + left));
        open.push((from + left, from + left + right));
    }
    order
}

struct Dissection<'a> {
    graph: &'a Adjacency,
    points: &'a [DVec3],
    /// The part each node lies in; separators keep a number of their own.
    part: Vec<u32>,
    parts: u32,
    keyed: Vec<(f64, u32)>,
    leaf: Leaf,
}

impl Dissection<'_> {
    /// Rearranges `nodes` into left part, right part, separator; returns the two parts' sizes.
    fn split(&mut self, nodes: &mut [u32]) -> (usize, usize) {
        let axis = self.longest_axis(nodes);
        self.keyed.clear();
        self.keyed.extend(nodes.iter().map(|&v| (self.points[v as usize][axis], v)));
        let middle = nodes.len() / 2;
        self.keyed.select_nth_unstable_by(middle, |a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let (left, right) = (self.parts, self.parts + 1);
        self.parts += 2;
        for (i, &(_, v)) in self.keyed.iter().enumerate() {
            self.part[v as usize] = if i < middle { left } else { right };
        }
        let touching = |side: &[(f64, u32)], other: u32| {
            side.iter().filter(|&&(_, v)| self.touches(v, other)).count()
        };
        let (a, b) = self.keyed.split_at(middle);
        let (cut, other) =
            if touching(a, right) <= touching(b, left) { (left, right) } else { (right, left) };
        self.arrange(nodes, cut, other)
    }

    /// Moves the nodes of part `cut` that touch `other` to the end, as the separator.
    fn arrange(&mut self, nodes: &mut [u32], cut: u32, other: u32) -> (usize, usize) {
        let (mut first, mut second, mut end) = (0, 0, nodes.len());
        let inside = |s: &Self, v: u32| s.part[v as usize] == cut && !s.touches(v, other);
        for i in 0..self.keyed.len() {
            let v = self.keyed[i].1;
            if inside(self, v) {
                nodes[first] = v;
                first += 1;
            } else if self.part[v as usize] == cut {
                end -= 1;
                nodes[end] = v;
            }
        }
        for i in 0..self.keyed.len() {
            let v = self.keyed[i].1;
            if self.part[v as usize] == other {
                nodes[first + second] = v;
                second += 1;
            }
        }
        for &v in &nodes[end..] {
            self.part[v as usize] = 0;
        }
        (first, second)
    }

    fn touches(&self, node: u32, part: u32) -> bool {
        self.graph.of(node).iter().any(|&w| self.part[w as usize] == part)
    }

    fn longest_axis(&self, nodes: &[u32]) -> usize {
        let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for &v in nodes {
            low = low.min(self.points[v as usize]);
            high = high.max(self.points[v as usize]);
        }
        let size = high - low;
        (0..3).fold(0, |best, axis| if size[axis] > size[best] { axis } else { best })
    }
}

/// Minimum degree inside one small part, on bit sets.
struct Leaf {
    /// Number of each node inside the present leaf and halo, plus one; zero outside.
    local: Vec<u8>,
    nodes: Vec<u32>,
    adjacent: Vec<Bits>,
    degree: Vec<u32>,
}

impl Leaf {
    fn new(n: usize) -> Self {
        Self { local: vec![0; n], nodes: Vec::new(), adjacent: Vec::new(), degree: Vec::new() }
    }

    fn order(&mut self, graph: &Adjacency, part: &mut [u32]) {
        self.gather(graph, part);
        for slot in part.iter_mut() {
            let Some(v) = self.cheapest() else { break };
            *slot = self.nodes[v];
            self.eliminate(v);
        }
        for &v in &self.nodes {
            self.local[v as usize] = 0;
        }
    }

    fn gather(&mut self, graph: &Adjacency, part: &[u32]) {
        self.nodes.clear();
        self.nodes.extend_from_slice(part);
        for (i, &v) in part.iter().enumerate() {
            self.local[v as usize] = i as u8 + 1;
        }
        self.adjacent.clear();
        self.adjacent.resize(part.len(), [0; WORDS]);
        for (i, &v) in part.iter().enumerate() {
            for &w in graph.of(v) {
                if self.local[w as usize] == 0 && self.nodes.len() < 64 * WORDS {
                    self.nodes.push(w);
                    self.local[w as usize] = self.nodes.len() as u8;
                }
                let l = self.local[w as usize] as usize;
                if l > 0 {
                    self.adjacent[i][(l - 1) / 64] |= 1 << ((l - 1) % 64);
                }
            }
        }
        self.degree.clear();
        self.degree.extend(self.adjacent.iter().map(|bits| count(*bits)));
    }

    fn cheapest(&self) -> Option<usize> {
        (0..self.degree.len())
            .min_by_key(|&v| self.degree[v])
            .filter(|&v| self.degree[v] < u32::MAX)
    }

    fn eliminate(&mut self, v: usize) {
        let clique = self.adjacent[v];
        self.degree[v] = u32::MAX;
        for word in 0..WORDS {
            let mut left = clique[word];
            while left != 0 {
                let w = 64 * word + left.trailing_zeros() as usize;
                left &= left - 1;
                if w >= self.degree.len() {
                    return;
                }
                let mut bits = self.adjacent[w];
                (0..WORDS).for_each(|k| bits[k] |= clique[k]);
                bits[v / 64] &= !(1 << (v % 64));
                bits[w / 64] &= !(1 << (w % 64));
                self.adjacent[w] = bits;
                self.degree[w] = count(bits);
            }
        }
    }
}

fn count(bits: Bits) -> u32 {
    bits.iter().map(|w| w.count_ones()).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linalg::SymmetricMatrix;

    #[test]
    fn order_is_a_permutation_that_ends_with_a_separator() {
        let side = 40u32;
        let mut entries = Vec::new();
        let mut points = Vec::new();
        for y in 0..side {
            for x in 0..side {
                points.push(DVec3::new(x.into(), 1.01 * f64::from(y), 0.0));
                let v = y * side + x;
                if x + 1 < side {
                    entries.push((v, v + 1, -1.0));
                }
                if y + 1 < side {
                    entries.push((v, v + side, -1.0));
                }
            }
        }
        let n = (side * side) as usize;
        let graph = SymmetricMatrix::new(&vec![4.0; n], &entries).adjacency();
        let order = nested_dissection(&graph, &points);
        let mut sorted = order.clone();
        sorted.sort_unstable();
        assert!(sorted.iter().enumerate().all(|(i, &v)| i == v as usize));
        let last = &order[n - side as usize..];
        assert!(last.iter().all(|&v| v / side == last[0] / side), "not one grid line: {last:?}");
    }
}
