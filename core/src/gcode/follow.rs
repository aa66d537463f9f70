//! Whether a program is the path that it was written from.
//!
//! The points of the path are sought in the program in their order; what the program does between two of them must stay
//! near the straight line that joins them. Rapids between may run anywhere: their height is judged by `check`.

use super::program::{Finding, FindingKind, GcodeProgram};
use crate::geometry::{DVec3, distance_to_segment};
use crate::toolpath::{MoveKind, PathPoint, Toolpath};

/// Where a program that was read leaves the path by more than `tolerance`, mm, first; `radius`: that of the cutter, mm, at
/// whose rim the direction of the axis counts.
pub fn leaves(
    program: &GcodeProgram,
    path: &Toolpath,
    tolerance: f64,
    radius: f64,
) -> Option<Finding> {
    let read = &program.path.points;
    let meets = |q: &PathPoint, p: &PathPoint| {
        q.tip.distance(p.tip).max(radius * q.axis.distance(p.axis)) <= tolerance
    };
    let mut at = 0;
    for (i, p) in path.points.iter().enumerate() {
        let before = i.checked_sub(1).map(|i| path.points[i].tip);
        loop {
            let Some(q) = read.get(at) else {
                let off = read.last().map_or(0.0, |q| q.tip.distance(p.tip));
                return Some(finding(program, at, off, p.tip));
            };
            if meets(q, p) {
                break;
            }
            // Before the first point the program may come from anywhere.
            if let Some(before) = before.filter(|_| p.kind != MoveKind::Rapid) {
                let off = distance_to_segment(q.tip, before, p.tip);
                if off > tolerance {
                    return Some(finding(program, at, off, p.tip));
                }
            }
            at += 1;
        }
    }
    None
}

fn finding(program: &GcodeProgram, at: usize, off: f64, wanted: DVec3) -> Finding {
    let last = program.lines.last().copied().unwrap_or(1);
    Finding {
        line: program.lines.get(at).copied().unwrap_or(last),
        kind: FindingKind::OffPath,
        message: format!(
            "leaves the planned path by {off:.3} mm on the way to ({:.3}, {:.3}, {:.3}): the post writes another path",
            wanted.x, wanted.y, wanted.z
        ),
    }
}
