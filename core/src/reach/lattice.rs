//! Places at which heights are asked: a lattice of squares over the part, each divided into four right triangles,
//! which are halved again and again.
//!
//! Terms. *Unit*: the distance of neighbouring places of the lattice. *Apex*: the corner of a triangle at its right
//! angle; the side across from it is its *base*, whose middle is the apex of both halves.

use crate::geometry::DVec2;
use crate::surface::Part;

/// Halvings of the sides of a square.
const LEVELS: u32 = 7;
/// Side of a square, cutter radii.
const SQUARE: f64 = 0.5;
/// Most squares; on larger parts they are larger.
const MOST_SQUARES: f64 = 40_000.0;
/// Squares along the shorter side of a part at least.
const FEWEST: f64 = 6.0;
/// How far the lattice begins before the part, squares: its lines are not to run along straight edges.
const BEFORE: DVec2 = DVec2::new(0.37, 0.41);

/// A place of the lattice, units.
pub(super) type Key = (i32, i32);

/// A triangle: apex and the ends of its base, counter-clockwise.
pub(super) type Triangle = [Key; 3];

/// The lattice.
#[derive(Copy, Clone, Debug)]
pub(super) struct Lattice {
    origin: DVec2,
    /// mm.
    pub unit: f64,
    squares: (i32, i32),
}

impl Lattice {
    /// Over all faces of a part; `None` if there is none with an area seen from above.
    pub fn over(part: &Part, radius: f64) -> Option<Self> {
        let used = part.faces.iter().flatten().map(|&v| part.positions[v as usize].truncate());
        let (low, high) =
            used.fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(l, h), p| (l.min(p), h.max(p)));
        let size = high - low;
        if !(size.is_finite() && size.min_element() > 0.0) {
            return None;
        }
        let fine = (SQUARE * radius).min(size.min_element() / FEWEST);
        let side = fine
            .max((size.x * size.y / MOST_SQUARES).sqrt())
            .max(size.max_element() / MOST_SQUARES);
        let squares = (size / side + 1.0).ceil();
        Some(Self {
            origin: low - BEFORE * side,
            unit: side / f64::from(1u32 << LEVELS),
            squares: (squares.x as i32, squares.y as i32),
        })
    }

    /// Units along a square.
    fn side() -> i32 {
        1 << LEVELS
    }

    /// Where a place is, mm.
    pub fn at(&self, (i, j): Key) -> DVec2 {
        self.origin + DVec2::new(f64::from(i), f64::from(j)) * self.unit
    }

    /// The triangles before any is halved.
    pub fn triangles(&self) -> impl Iterator<Item = Triangle> + '_ {
        let (columns, rows) = self.squares;
        let side = Self::side();
        let square = move |i: i32, j: i32| {
            let (x, y) = (i * side, j * side);
            let corners = [(x, y), (x + side, y), (x + side, y + side), (x, y + side)];
            let middle = (x + side / 2, y + side / 2);
            (0..4).map(move |k| [middle, corners[k], corners[(k + 1) % 4]])
        };
        (0..rows).flat_map(move |j| (0..columns).flat_map(move |i| square(i, j)))
    }

    /// The triangle before any is halved in which a place lies; `None` outside of the lattice.
    pub fn around(&self, at: DVec2) -> Option<Triangle> {
        let p = (at - self.origin) / self.unit;
        let side = f64::from(Self::side());
        let (i, j) = ((p.x / side).floor(), (p.y / side).floor());
        let is_in =
            i >= 0.0 && j >= 0.0 && i < f64::from(self.squares.0) && j < f64::from(self.squares.1);
        if !is_in {
            return None;
        }
        let (x, y) = (i as i32 * Self::side(), j as i32 * Self::side());
        let side = Self::side();
        let corners = [(x, y), (x + side, y), (x + side, y + side), (x, y + side)];
        let from_middle = p - DVec2::new(f64::from(x), f64::from(y)) - 0.5 * f64::from(side);
        let k = match (
            from_middle.y.abs() >= from_middle.x.abs(),
            from_middle.x > 0.0,
            from_middle.y > 0.0,
        ) {
            (true, _, false) => 0,
            (false, true, _) => 1,
            (true, _, true) => 2,
            (false, false, _) => 3,
        };
        Some([(x + side / 2, y + side / 2), corners[k], corners[(k + 1) % 4]])
    }

    /// The half of a triangle in which a place lies.
    pub fn half_around(&self, triangle: Triangle, at: DVec2) -> Triangle {
        let [apex, middle] = [triangle[0], middle(triangle[1], triangle[2])].map(|k| self.at(k));
        let side = (middle - apex).perp_dot(at - apex);
        // The first half is on the right of the way from the apex to the middle.
        halves(triangle)[usize::from(side > 0.0)]
    }

    /// The places that are apexes on both sides of the base with this middle, and the places of the square around a
    /// middle of a slanting base.
    pub fn needed(&self, (i, j): Key) -> impl Iterator<Item = Key> + '_ {
        let s = 1 << (i | j).trailing_zeros();
        let (is_odd_i, is_odd_j) = (i / s % 2 != 0, j / s % 2 != 0);
        let around = match (is_odd_i, is_odd_j) {
            (true, true) => [(i - s, j - s), (i + s, j - s), (i + s, j + s), (i - s, j + s)],
            (true, false) => [(i, j - s), (i, j + s), (i, j - s), (i, j + s)],
            _ => [(i - s, j), (i + s, j), (i - s, j), (i + s, j)],
        };
        let (columns, rows) = self.squares;
        let most = (columns * Self::side(), rows * Self::side());
        around
            .into_iter()
            .filter(move |k| (0..=most.0).contains(&k.0) && (0..=most.1).contains(&k.1))
    }

    /// Whether a place exists before any triangle is halved.
    pub fn is_given(&self, (i, j): Key) -> bool {
        let (side, half) = (Self::side(), Self::side() / 2);
        let is_corner = i % side == 0 && j % side == 0;
        is_corner || (i % side == half && j % side == half)
    }
}

/// The middle of a side.
pub(super) fn middle(a: Key, b: Key) -> Key {
    ((a.0 + b.0) / 2, (a.1 + b.1) / 2)
}

/// Whether a triangle has halves on the lattice.
pub(super) fn has_halves([_, a, b]: Triangle) -> bool {
    (a.0 + b.0) % 2 == 0 && (a.1 + b.1) % 2 == 0
}

/// The halves of a triangle.
pub(super) fn halves([apex, a, b]: Triangle) -> [Triangle; 2] {
    let middle = middle(a, b);
    [[middle, apex, a], [middle, b, apex]]
}
