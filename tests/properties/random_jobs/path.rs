//! The delivered path, read from its table, and the pieces of it that come near a place.

use crate::cutter::{Cutter, Line, Piece, Pose};
use evencut_core::geometry::DVec3;

/// Longest piece of a move, cutter radii: pieces are found by boxes.
const LONGEST: f64 = 0.5;
/// Largest turn on a piece, rad: searches along a piece take it for convex, which a bent way of a point is not by
/// its square times the lever over 8, 1 µm on 10 mm, where there are two lowest places to choose from.
const LARGEST_TURN: f64 = 0.03;
/// Pieces in a leaf of the tree.
const LEAF: usize = 4;

/// A row of the table.
#[derive(Clone, Debug)]
pub struct Row {
    /// Kind of the move that ends here.
    pub kind: String,
    /// Index of the pass.
    pub pass: u32,
    /// The cutter.
    pub pose: Pose,
    /// Feed, mm/min.
    pub feed: f64,
    /// Time, s.
    pub time: f64,
}

impl Row {
    /// Whether the move that ends here is a rapid.
    pub fn is_rapid(&self) -> bool {
        self.kind == "rapid"
    }
}

/// Reads `toolpath.csv`; what is wrong with it where it is no table of numbers.
pub fn rows(text: &str) -> Result<Vec<Row>, String> {
    let mut lines = text.lines();
    let header = lines.next().unwrap_or_default();
    let columns: Vec<&str> = header.split(',').collect();
    let column = |name: &str| {
        columns.iter().position(|c| *c == name).ok_or(format!("no column {name} in {header}"))
    };
    let places = ["x", "y", "z", "i", "j", "k", "feed", "t", "mrr", "nx", "ny", "nz", "alpha"];
    let places: Vec<usize> = places.into_iter().map(column).collect::<Result<_, _>>()?;
    let (kind, pass) = (column("kind")?, column("pass")?);
    lines
        .enumerate()
        .map(|(i, line)| {
            let fields: Vec<&str> = line.split(',').collect();
            let number = |c: &usize| {
                let value = fields.get(*c).and_then(|f| f.parse::<f64>().ok());
                let value = value.filter(|v| v.is_finite());
                value.ok_or(format!("line {}: no number in column {c}: {line}", i + 2))
            };
            let v: Vec<f64> = places.iter().map(number).collect::<Result<_, _>>()?;
            let axis = DVec3::new(v[3], v[4], v[5]);
            if (axis.length() - 1.0).abs() > 1e-6 {
                return Err(format!("line {}: the axis is no unit vector: {line}", i + 2));
            }
            Ok(Row {
                kind: fields[kind].to_owned(),
                pass: number(&pass)? as u32,
                pose: Pose { tip: DVec3::new(v[0], v[1], v[2]), axis: axis.normalize() },
                feed: v[6],
                time: v[7],
            })
        })
        .collect()
}

/// The pieces of a move.
pub fn pieces(from: Pose, to: Pose, of: usize, longest: f64) -> impl Iterator<Item = Piece> {
    let whole = Piece { from, to, of };
    let length = from.tip.distance(to.tip) / longest;
    let turn = from.axis.distance(to.axis) / LARGEST_TURN;
    let count = length.max(turn).ceil().max(1.0) as usize;
    (0..count).map(move |k| {
        let at = |k: usize| whole.at(k as f64 / count as f64);
        Piece { from: at(k), to: at(k + 1), of }
    })
}

type Box3 = (DVec3, DVec3);

fn join(a: Box3, b: Box3) -> Box3 {
    (a.0.min(b.0), a.1.max(b.1))
}

fn meet(a: &Box3, b: &Box3) -> bool {
    a.0.cmple(b.1).all() && b.0.cmple(a.1).all()
}

/// Everything that a cutter sweeps along a path.
pub struct Sweep {
    /// The cutter.
    pub cutter: Cutter,
    /// All pieces; the tree puts those near each other together.
    pieces: Vec<Piece>,
    boxes: Vec<Box3>,
    tree: Vec<Node>,
}

struct Node {
    bounds: Box3,
    first: usize,
    count: usize,
    /// Index of the second half; 0 for a leaf. The first half comes next.
    second: usize,
}

/// Box around a cutter.
fn around(cutter: &Cutter, pose: &Pose) -> Box3 {
    let axis = pose.axis;
    let across = (DVec3::ONE - axis * axis).max(DVec3::ZERO).map(f64::sqrt) * cutter.radius;
    let length = cutter.length.min(1e6);
    let top = pose.tip + axis * length;
    (pose.tip.min(top) - across, pose.tip.max(top) + across)
}

impl Sweep {
    /// What is swept between the rows.
    pub fn new(rows: &[Row], cutter: Cutter) -> Self {
        let mut all: Vec<Piece> = Vec::new();
        for (i, pair) in rows.windows(2).enumerate() {
            all.extend(pieces(pair[0].pose, pair[1].pose, i, LONGEST * cutter.radius));
        }
        let boxes = |p: &Piece| join(around(&cutter, &p.from), around(&cutter, &p.to));
        let mut keyed: Vec<(Piece, Box3)> = all.iter().map(|p| (*p, boxes(p))).collect();
        let mut tree = Vec::new();
        build(&mut keyed, 0, &mut tree);
        let (pieces, boxes) = keyed.into_iter().unzip();
        Self { cutter, pieces, boxes, tree }
    }

    /// Calls `visit` with the pieces on which the cutter's box meets that of a line from `from` to `to`.
    pub fn near(&self, line: Line, from: f64, to: f64, visit: &mut dyn FnMut(&Piece)) {
        let (a, b) = (line.at(from), line.at(to));
        let target = (a.min(b) - DVec3::splat(1e-9), a.max(b) + DVec3::splat(1e-9));
        let mut open = vec![0usize];
        while let Some(index) = open.pop() {
            let Some(node) = self.tree.get(index) else { continue };
            if !meet(&node.bounds, &target) {
                continue;
            }
            if node.second > 0 {
                open.extend([index + 1, node.second]);
                continue;
            }
            for i in node.first..node.first + node.count {
                if meet(&self.boxes[i], &target) {
                    visit(&self.pieces[i]);
                }
            }
        }
    }

    /// The lowest place from `from` to `to` on a line that the cutter reaches on moves that `counts`, and the
    /// move.
    pub fn lowest(
        &self,
        line: Line,
        from: f64,
        to: f64,
        counts: &dyn Fn(usize) -> bool,
    ) -> Option<(f64, usize)> {
        let mut near: Vec<(f64, Piece)> = Vec::new();
        self.near(line, from, to, &mut |p| {
            if counts(p.of) {
                near.push((self.cutter.distance(&p.at(0.5), line.foot), *p));
            }
        });
        // The nearest first: after it most others are soon seen to be no lower.
        near.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut best: Option<(f64, usize)> = None;
        for (_, piece) in &near {
            let top = best.map_or(to, |b| b.0);
            if top <= from {
                break;
            }
            if let Some(low) = self.cutter.lowest(piece, line, from, top)
                && best.is_none_or(|b| low < b.0)
            {
                best = Some((low, piece.of));
            }
        }
        best
    }
}

fn build(all: &mut [(Piece, Box3)], first: usize, tree: &mut Vec<Node>) {
    let Some(start) = all.first().map(|a| a.1) else { return };
    let bounds = all.iter().map(|a| a.1).fold(start, join);
    let index = tree.len();
    tree.push(Node { bounds, first, count: all.len(), second: 0 });
    if all.len() <= LEAF {
        return;
    }
    let middle = |b: &Box3| 0.5 * (b.0 + b.1);
    let spread = all.iter().map(|a| middle(&a.1));
    let (low, high) =
        spread.fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(l, h), m| (l.min(m), h.max(m)));
    let size = high - low;
    let axis = (0..3).fold(0, |best, k| if size[k] > size[best] { k } else { best });
    let half = all.len() / 2;
    all.select_nth_unstable_by(half, |a, b| middle(&a.1)[axis].total_cmp(&middle(&b.1)[axis]));
    let (left, right) = all.split_at_mut(half);
    build(left, first, tree);
    tree[index].second = tree.len();
    build(right, first + half, tree);
}

#[cfg(test)]
mod tests {
    use super::*;

    const HEADER: &str = "pass,region,kind,x,y,z,i,j,k,nx,ny,nz,feed,mrr,alpha,t\n";

    #[test]
    fn tables_are_read_and_bad_ones_told() {
        let good = format!("{HEADER}0,0,rapid,1,2,3,0,0,1,0,0,1,600,0,0,0.5\n");
        let row = &rows(&good).unwrap()[0];
        assert!(row.is_rapid() && row.pose.tip == DVec3::new(1.0, 2.0, 3.0) && row.feed == 600.0);
        assert!(rows(&good.replace("600", "NaN")).is_err());
        assert!(rows(&good.replace("0,0,1,0,0,1", "0,0,2,0,0,1")).is_err());
    }

    #[test]
    fn the_tree_leaves_nothing_out() {
        let row = |i: usize| Row {
            kind: "cut".into(),
            pass: 0,
            pose: Pose {
                tip: DVec3::new((i % 30) as f64, (i / 30) as f64, 0.1 * (i % 7) as f64),
                axis: DVec3::new(0.02 * (i % 5) as f64, 0.0, 1.0).normalize(),
            },
            feed: 1.0,
            time: 0.0,
        };
        let rows: Vec<Row> = (0..600).map(row).collect();
        let cutter = Cutter { radius: 1.5, corner: 0.5, length: 6.0 };
        let sweep = Sweep::new(&rows, cutter);
        for k in 0..40 {
            let foot = DVec3::new(0.7 * f64::from(k), 0.45 * f64::from(k), 0.0);
            let line = Line { foot, along: DVec3::new(0.1, 0.2, 1.0).normalize() };
            let all = sweep.pieces.iter().filter_map(|p| cutter.lowest(p, line, -1.0, 2.0));
            let low = all.fold(f64::INFINITY, f64::min);
            let found = sweep.lowest(line, -1.0, 2.0, &|_| true).map_or(f64::INFINITY, |f| f.0);
            assert!(low == found || (low - found).abs() < 1e-6, "{low} {found}");
        }
    }
}
