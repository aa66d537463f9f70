//! Symbolic factorisation: the elimination tree and the supernodes of the Cholesky factor.
//!
//! Terms. The *elimination tree* makes the first row below the diagonal of each column of the
//! factor its parent. A *supernode* is a run of columns with (nearly) the same rows, stored as one
//! dense panel: its own columns first, then the rows below.
//!
//! Steps: 1 elimination tree of the given order; 2 postorder, so that children precede parents
//! without gaps; 3 column counts; 4 supernodes, small ones merged into their parents; 5 rows.

use super::matrix::SymmetricMatrix;
use crate::geometry::OrderBy;

const NONE: u32 = u32::MAX;

/// Structure of the factor of one sparsity pattern under one order.
#[derive(Clone, Debug)]
pub(super) struct Symbolic {
    /// Original index of each row of the factor.
    pub order: Vec<u32>,
    /// First column of each supernode; one more at the end.
    pub first_column: Vec<u32>,
    /// Supernode that receives each supernode's update, or `u32::MAX` at a root.
    pub parent: Vec<u32>,
    /// Where each supernode's rows begin in `rows`; one more at the end.
    pub row_start: Vec<usize>,
    /// Rows of the panels, ascending.
    pub rows: Vec<u32>,
    /// Where each panel begins among the factor's values; one more at the end.
    pub panel_start: Vec<usize>,
    /// Where each column's matrix entries begin in `entries`; one more at the end.
    pub entry_start: Vec<u32>,
    /// `(row, index among the matrix's values)`, the diagonal first.
    pub entries: Vec<(u32, u32)>,
}

impl Symbolic {
    /// Analyses `matrix` eliminated in `order`, a permutation of its rows.
    pub fn new(matrix: &SymmetricMatrix, order: &[u32]) -> Self {
        let parent = elimination_tree(matrix, order);
        let post = postorder(&parent);
        let order: Vec<u32> = post.iter().map(|&p| order[p as usize]).collect();
        let parent = relabel(&parent, &post);
        let (entry_start, entries) = permuted_entries(matrix, &order);
        let counts = column_counts(&parent, &entry_start, &entries);
        let (first_column, row_counts) = supernodes(&parent, &counts);
        let mut symbolic = Self {
            order,
            parent: Vec::new(),
            row_start: Vec::with_capacity(first_column.len()),
            rows: Vec::new(),
            panel_start: Vec::with_capacity(first_column.len()),
            first_column,
            entry_start,
            entries,
        };
        symbolic.find_rows(&row_counts);
        symbolic
    }

    /// Number of supernodes.
    pub fn supernodes(&self) -> usize {
        self.first_column.len() - 1
    }

    /// Columns of a supernode.
    pub fn columns(&self, supernode: usize) -> std::ops::Range<usize> {
        self.first_column[supernode] as usize..self.first_column[supernode + 1] as usize
    }

    /// Rows of a supernode, its own columns first.
    pub fn rows_of(&self, supernode: usize) -> &[u32] {
        &self.rows[self.row_start[supernode]..self.row_start[supernode + 1]]
    }

    /// Fills rows, parents and panel offsets; children come before parents.
    fn find_rows(&mut self, row_counts: &[u32]) {
        let count = self.supernodes();
        let n = self.order.len();
        let mut owner = vec![0u32; n];
        for s in 0..count {
            self.columns(s).for_each(|c| owner[c] = s as u32);
        }
        self.parent = vec![NONE; count];
        self.rows.reserve(row_counts.iter().map(|&r| r as usize).sum());
        let mut children = ChildLists::new(count);
        let mut seen = vec![NONE; n];
        self.row_start.push(0);
        self.panel_start.push(0);
        for s in 0..count {
            let columns = self.columns(s);
            let from = self.rows.len();
            for c in columns.clone() {
                seen[c] = s as u32;
                self.rows.push(c as u32);
            }
            for c in columns.clone() {
                for e in self.entry_start[c] as usize..self.entry_start[c + 1] as usize {
                    push_new(&mut self.rows, &mut seen, self.entries[e].0, s as u32);
                }
            }
            let mut child = children.first(s);
            while let Some(c) = child {
                let width = self.columns(c).len();
                for i in self.row_start[c] + width..self.row_start[c + 1] {
                    let row = self.rows[i];
                    push_new(&mut self.rows, &mut seen, row, s as u32);
                }
                child = children.next(c);
            }
            self.rows[from + columns.len()..].order_total();
            if let Some(&row) = self.rows.get(from + columns.len()) {
                self.parent[s] = owner[row as usize];
                children.add(owner[row as usize] as usize, s);
            }
            let height = self.rows.len() - from;
            self.row_start.push(self.rows.len());
            self.panel_start.push(self.panel_start[s] + height * columns.len());
        }
    }
}

fn push_new(rows: &mut Vec<u32>, seen: &mut [u32], row: u32, supernode: u32) {
    if seen[row as usize] != supernode {
        seen[row as usize] = supernode;
        rows.push(row);
    }
}

/// Children of every node as linked lists.
#[derive(Clone, Debug)]
pub(super) struct ChildLists {
    head: Vec<u32>,
    next: Vec<u32>,
}

impl ChildLists {
    pub fn new(count: usize) -> Self {
        Self { head: vec![NONE; count], next: vec![NONE; count] }
    }

    pub fn add(&mut self, parent: usize, child: usize) {
        self.next[child] = self.head[parent];
        self.head[parent] = child as u32;
    }

    pub fn first(&self, parent: usize) -> Option<usize> {
        (self.head[parent] != NONE).then_some(self.head[parent] as usize)
    }

    pub fn next(&self, child: usize) -> Option<usize> {
        (self.next[child] != NONE).then_some(self.next[child] as usize)
    }
}

/// Parent of every column, by path compression (Liu 1986).
fn elimination_tree(matrix: &SymmetricMatrix, order: &[u32]) -> Vec<u32> {
    let graph = matrix.adjacency();
    let n = order.len();
    let mut place = vec![0u32; n];
    for (j, &v) in order.iter().enumerate() {
        place[v as usize] = j as u32;
    }
    let mut parent = vec![NONE; n];
    let mut ancestor = vec![NONE; n];
    for j in 0..n as u32 {
        for &w in graph.of(order[j as usize]) {
            let mut i = place[w as usize];
            while i < j {
                let up = ancestor[i as usize];
                ancestor[i as usize] = j;
                if up == NONE {
                    parent[i as usize] = j;
                    break;
                }
                i = up;
            }
        }
    }
    parent
}

/// Columns in postorder of the tree, children in ascending order.
fn postorder(parent: &[u32]) -> Vec<u32> {
    let n = parent.len();
    let mut children = ChildLists::new(n);
    let mut roots = Vec::new();
    for j in (0..n).rev() {
        match parent[j] {
            NONE => roots.push(j),
            p => children.add(p as usize, j),
        }
    }
    let mut post = Vec::with_capacity(n);
    let mut path: Vec<usize> = Vec::new();
    while let Some(root) = roots.pop() {
        path.push(root);
        while let Some(&j) = path.last() {
            match children.first(j) {
                Some(child) => {
                    children.head[j] = children.next[child];
                    path.push(child);
                }
                None => {
                    post.push(j as u32);
                    path.pop();
                }
            }
        }
    }
    post
}

fn relabel(parent: &[u32], post: &[u32]) -> Vec<u32> {
    let mut place = vec![0u32; post.len()];
    for (new, &old) in post.iter().enumerate() {
        place[old as usize] = new as u32;
    }
    post.iter()
        .map(|&old| match parent[old as usize] {
            NONE => NONE,
            p => place[p as usize],
        })
        .collect()
}

/// The lower triangle of the permuted matrix by columns, diagonal first.
fn permuted_entries(matrix: &SymmetricMatrix, order: &[u32]) -> (Vec<u32>, Vec<(u32, u32)>) {
    let n = order.len();
    let mut place = vec![0u32; n];
    for (j, &v) in order.iter().enumerate() {
        place[v as usize] = j as u32;
    }
    let (column_start, rows) = (matrix.column_start(), matrix.rows());
    let column_range = |c: usize| column_start[c] as usize..column_start[c + 1] as usize;
    let mut start = vec![0u32; n + 1];
    for c in 0..n {
        for e in column_range(c) {
            start[place[c].min(place[rows[e] as usize]) as usize + 1] += 1;
        }
    }
    for c in 0..n {
        start[c + 1] += start[c];
    }
    // The diagonal keeps the first slot of its column.
    let mut fill: Vec<u32> = start[..n].iter().map(|s| s + 1).collect();
    let mut entries = vec![(0, 0); start[n] as usize];
    for c in 0..n {
        for e in column_range(c) {
            let (i, j) = (place[c], place[rows[e] as usize]);
            let slot = if i == j {
                start[i as usize]
            } else {
                fill[i.min(j) as usize] += 1;
                fill[i.min(j) as usize] - 1
            };
            entries[slot as usize] = (i.max(j), e as u32);
        }
    }
    (start, entries)
}

/// Number of rows in every column of the factor, diagonal included; columns are in postorder.
///
/// # Source
/// Gilbert, Ng, Peyton, "An efficient algorithm to compute row and column counts for sparse
/// Cholesky factorization", SIAM J. Matrix Anal. Appl. 15, 1994.
fn column_counts(parent: &[u32], entry_start: &[u32], entries: &[(u32, u32)]) -> Vec<u32> {
    let n = parent.len();
    let mut first_descendant = vec![NONE; n];
    let mut count = vec![0i32; n];
    for k in 0..n {
        count[k] = i32::from(first_descendant[k] == NONE);
        let mut j = k as u32;
        while j != NONE && first_descendant[j as usize] == NONE {
            first_descendant[j as usize] = k as u32;
            j = parent[j as usize];
        }
    }
    let mut leaves = RowLeaves {
        ancestor: (0..n as u32).collect(),
        largest_first: vec![NONE; n],
        previous: vec![NONE; n],
    };
    for j in 0..n {
        if parent[j] != NONE {
            count[parent[j] as usize] -= 1;
        }
        for &(i, _) in &entries[entry_start[j] as usize + 1..entry_start[j + 1] as usize] {
            match leaves.visit(i as usize, j as u32, first_descendant[j]) {
                Leaf::No => {}
                Leaf::First => count[j] += 1,
                Leaf::Later { meeting } => {
                    count[j] += 1;
                    count[meeting as usize] -= 1;
                }
            }
        }
        if parent[j] != NONE {
            leaves.ancestor[j] = parent[j];
        }
    }
    for j in 0..n {
        if parent[j] != NONE {
            count[parent[j] as usize] += count[j];
        }
    }
    count.iter().map(|&c| c as u32).collect()
}

/// Whether a column is a leaf of a row's subtree of the elimination tree.
enum Leaf {
    No,
    First,
    /// With the previous leaf it meets at the given common ancestor.
    Later {
        meeting: u32,
    },
}

struct RowLeaves {
    ancestor: Vec<u32>,
    largest_first: Vec<u32>,
    previous: Vec<u32>,
}

impl RowLeaves {
    fn visit(&mut self, row: usize, column: u32, first_descendant: u32) -> Leaf {
        let largest = self.largest_first[row];
        if largest != NONE && first_descendant <= largest {
            return Leaf::No;
        }
        self.largest_first[row] = first_descendant;
        let previous = std::mem::replace(&mut self.previous[row], column);
        if previous == NONE {
            return Leaf::First;
        }
        let mut meeting = previous;
        while meeting != self.ancestor[meeting as usize] {
            meeting = self.ancestor[meeting as usize];
        }
        let mut s = previous;
        while s != meeting {
            s = std::mem::replace(&mut self.ancestor[s as usize], meeting);
        }
        Leaf::Later { meeting }
    }
}

/// First column of every supernode (one more at the end) and its number of rows.
///
/// A supernode is merged into the parent that follows it when few explicit zeros result
/// (the rule and its constants: Chen, Davis, Hager, Rajamanickam, CHOLMOD, TOMS 35, 2008).
fn supernodes(parent: &[u32], counts: &[u32]) -> (Vec<u32>, Vec<u32>) {
    let n = parent.len();
    let mut first: Vec<u32> = Vec::new();
    for j in 0..n {
        let joins = j > 0 && parent[j - 1] == j as u32 && counts[j - 1] == counts[j] + 1;
        if !joins {
            first.push(j as u32);
        }
    }
    first.push(n as u32);
    // From the last supernode down; `kept` is a stack whose top is the supernode that follows.
    let mut kept: Vec<Merged> = Vec::new();
    for s in (0..first.len() - 1).rev() {
        let (from, to) = (first[s], first[s + 1]);
        let single = Merged { from, width: to - from, rows: counts[from as usize], zeros: 0.0 };
        match kept.last_mut() {
            Some(next) if parent[to as usize - 1] == to => match single.merged_with(next) {
                Some(union) => *next = union,
                None => kept.push(single),
            },
            _ => kept.push(single),
        }
    }
    kept.reverse();
    let mut starts: Vec<u32> = kept.iter().map(|m| m.from).collect();
    starts.push(n as u32);
    (starts, kept.iter().map(|m| m.rows).collect())
}

struct Merged {
    from: u32,
    width: u32,
    rows: u32,
    zeros: f64,
}

impl Merged {
    /// This supernode with the `next` one, its parent, if that stores few zeros.
    fn merged_with(&self, next: &Merged) -> Option<Merged> {
        let width = self.width + next.width;
        let rows = self.width + next.rows;
        let added = f64::from(self.width) * f64::from(rows - self.rows);
        let zeros = self.zeros + next.zeros + added;
        let (w, r) = (f64::from(width), f64::from(rows));
        let share = zeros / (w * (w + 1.0) / 2.0 + w * (r - w));
        let worth = width <= 4
            || (width <= 16 && share < 0.8)
            || (width <= 48 && share < 0.1)
            || share < 0.05;
        worth.then_some(Merged { from: self.from, width, rows, zeros })
    }
}
