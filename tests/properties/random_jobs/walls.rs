//! Walls: what stands beside the machined surface where the rest of the part does not rise.

use crate::cutter::{Cutter, Line, Pose};
use crate::part::{Mesh, Rim, key};
use crate::path::Sweep;
use evencut_core::geometry::DVec3;
use std::collections::HashMap;

/// Places on the height of a wall that leans with the normals. An upright cutter is the widest at the top.
const HEIGHTS: [f64; 6] = [0.02, 0.1, 0.25, 0.5, 0.75, 1.0];

/// The wall over an edge of the machined surface.
#[derive(Copy, Clone, Debug)]
pub struct Wall {
    /// The edge.
    pub rim: Rim,
    /// From the feet of its ends to their tops, mm.
    pub up: [DVec3; 2],
    /// How far the tops may be off, since normals at corners are a matter of choice, mm.
    pub doubt: f64,
}

/// How deep the cutter stands in a wall.
#[derive(Copy, Clone, Debug)]
pub struct Stand {
    /// Depth, mm.
    pub depth: f64,
    /// Where, mm.
    pub at: DVec3,
    /// The move.
    pub of: usize,
}

/// The walls `height` mm high over the edges of the machined surface beside which no face of the rest rises by 45
/// degrees; upright, or along the surface's normals.
pub fn walls(rims: &[Rim], rest: &Mesh, height: f64, upright: bool) -> Vec<Wall> {
    let mut beside: HashMap<[[i64; 3]; 2], Vec<usize>> = HashMap::new();
    let named = |a: DVec3, b: DVec3| {
        let (a, b) = (key(a), key(b));
        if a < b { [a, b] } else { [b, a] }
    };
    for (f, face) in rest.faces.iter().enumerate() {
        (0..3).for_each(|k| beside.entry(named(face[k], face[(k + 1) % 3])).or_default().push(f));
    }
    let rises = |rim: &Rim, f: usize| {
        let [a, b] = rim.ends;
        let edge = (b - a).normalize();
        let face = rest.faces[f];
        let middle = (face[0] + face[1] + face[2]) / 3.0 - a;
        let away = (middle - edge * middle.dot(edge)).normalize_or_zero();
        let up = if upright { DVec3::Z } else { rim.facet };
        away.dot(up) >= 0.5f64.sqrt() - 1e-9
    };
    let is_wall = |rim: &&Rim| {
        let faces = beside.get(&named(rim.ends[0], rim.ends[1]));
        !faces.into_iter().flatten().any(|&f| rises(rim, f))
    };
    let wall = |rim: &Rim| {
        let doubt = (0..2).map(|k| rim.normals[k].distance(rim.by_angle[k])).fold(0.0, f64::max);
        Wall {
            rim: *rim,
            up: if upright { [DVec3::Z * height; 2] } else { rim.normals.map(|n| n * height) },
            doubt: if upright { 0.0 } else { doubt * height },
        }
    };
    rims.iter().filter(is_wall).map(wall).collect()
}

impl Wall {
    /// Part of the way between two places after which an upright wall stands.
    pub fn crossed(&self, from: DVec3, to: DVec3) -> Option<f64> {
        let [a, b] = self.rim.ends;
        let [left, right] = [a, b].map(|end| side(from, to, end));
        let [before, behind] = [from, to].map(|p| side(a, b, p));
        let part = before / (before - behind);
        let at = from.lerp(to, part);
        let top = (a + self.up[0]).lerp(b + self.up[1], left / (left - right));
        (before * behind < 0.0 && left * right < 0.0 && at.z < top.z).then_some(part)
    }

    /// The deepest place at which the cutter stands in the wall, among places that the doubt about it does not
    /// explain.
    pub fn deepest(&self, sweep: &Sweep, tolerance: f64) -> Option<Stand> {
        let [a, b] = self.rim.ends;
        let upright = self.up[0] == self.up[1];
        let inward = self.rim.facet.cross(b - a);
        let along = ((b - a).length() / (0.125 * sweep.cutter.radius)).ceil().clamp(1.0, 40.0);
        let heights = if upright { &HEIGHTS[5..] } else { &HEIGHTS[..] };
        let mut best: Option<Stand> = None;
        for k in 0..along as usize {
            let t = (k as f64 + 0.5) / along;
            let up = self.up[0].lerp(self.up[1], t);
            // Level behind an upright wall, else across the edge.
            let behind = inward - up * (inward.dot(up) / up.length_squared());
            let Some(behind) = (-behind).try_normalize() else { continue };
            for &h in heights {
                let foot = a.lerp(b, t) + up * h;
                let slack = tolerance + self.doubt * h;
                let line = Line { foot, along: behind };
                let reach = 2.5 * sweep.cutter.radius;
                sweep.near(line, 0.0, reach, &mut |piece| {
                    let behind = |s: f64| through(&sweep.cutter, &piece.at(s), line, reach);
                    for s in [0.0, 0.25, 0.5, 0.75, 1.0] {
                        let depth = behind(s).unwrap_or(0.0) - slack;
                        if depth > 0.0 && best.is_none_or(|d| depth + slack > d.depth) {
                            best = Some(Stand { depth: depth + slack, at: foot, of: piece.of });
                        }
                    }
                });
            }
        }
        best
    }
}

/// Side of a line through two level places on which a third lies: the doubled area between them.
fn side(a: DVec3, b: DVec3, c: DVec3) -> f64 {
    (b - a).truncate().perp_dot((c - a).truncate())
}

/// How far behind the start of a line the cutter stands that holds the start: all of it, where its centre does
/// too.
fn through(cutter: &Cutter, pose: &Pose, line: Line, reach: f64) -> Option<f64> {
    (cutter.distance(pose, line.foot) < 0.0)
        .then(|| cutter.span(pose, line, 0.0, reach).map_or(0.0, |s| s.1))
}

/// The tops of walls, on which an upright cutter can rest.
pub fn tops(walls: &[Wall]) -> Vec<[DVec3; 2]> {
    walls.iter().map(|w| [w.rim.ends[0] + w.up[0], w.rim.ends[1] + w.up[1]]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::part::tests::sheet;
    use crate::path::Row;

    fn row(x: f64, z: f64) -> Row {
        let pose = Pose { tip: DVec3::new(x, 0.0, z), axis: DVec3::Z };
        Row { kind: "cut".into(), pass: 0, pose, feed: 1.0, time: 0.0 }
    }

    fn deepest(walls: &[Wall], rows: &[Row]) -> f64 {
        let cutter = Cutter { radius: 2.0, corner: 2.0, length: f64::INFINITY };
        let sweep = Sweep::new(rows, cutter);
        walls.iter().filter_map(|w| w.deepest(&sweep, 0.005)).map(|s| s.depth).fold(0.0, f64::max)
    }

    #[test]
    fn a_wall_knows_how_deep_the_cutter_stands_in_it() {
        let floor = Mesh::of(sheet(5.0, 10, |_, _| 0.0));
        let nothing = Mesh::of(Vec::new());
        let walls = walls(&floor.rims(), &nothing, 4.0, true);
        assert_eq!(walls.len(), 40);
        // Tangent to the wall at x = 5, then 0.3 in it, then with its centre 0.5 behind it.
        assert_eq!(deepest(&walls, &[row(0.0, 0.0), row(3.0, 0.0)]), 0.0);
        assert!((deepest(&walls, &[row(0.0, 0.0), row(3.3, 0.0)]) - 0.3).abs() < 0.01);
        assert!((deepest(&walls, &[row(0.0, 0.0), row(5.5, 0.0)]) - 2.5).abs() < 0.01);
        // Above it there is no wall.
        assert_eq!(deepest(&walls, &[row(0.0, 4.01), row(9.0, 4.01)]), 0.0);
    }

    #[test]
    fn a_way_ends_at_a_wall_but_not_above_it() {
        let floor = Mesh::of(sheet(5.0, 10, |_, _| 0.0));
        let walls = walls(&floor.rims(), &Mesh::of(Vec::new()), 4.0, true);
        let free = |to: DVec3| {
            let from = DVec3::new(3.0, 0.3, 0.0);
            walls.iter().filter_map(|w| w.crossed(from, to)).fold(1.0, f64::min)
        };
        assert_eq!(free(DVec3::new(4.9, 0.3, 1.0)), 1.0);
        assert!((free(DVec3::new(7.0, 0.3, 1.0)) - 0.5).abs() < 1e-12);
        assert_eq!(free(DVec3::new(7.0, 0.3, 9.0)), 1.0);
    }

    #[test]
    fn faces_that_rise_stand_for_themselves() {
        let floor = Mesh::of(sheet(5.0, 2, |_, _| 0.0));
        let face = |rise: f64| {
            let (a, b) = (DVec3::new(5.0, -5.0, 0.0), DVec3::new(5.0, 0.0, 0.0));
            Mesh::of(vec![[b, a, DVec3::new(6.0, -2.0, rise)]])
        };
        let count = |rise: f64| walls(&floor.rims(), &face(rise), 4.0, true).len();
        assert_eq!([count(0.9), count(1.1)], [8, 7]);
    }
}
