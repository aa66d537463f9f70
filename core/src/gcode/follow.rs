//! Whether a program is the path that it was written from.
//!
//! The points of the path are sought in the program in their order, to the rounding of its numbers; what the program does
//! between two of them must stay near the straight line that joins them. Rapids between may run anywhere: their height
//! is judged by `check`. Before the first point and after the last one the program must stay above the clearance plane,
//! or go along the tool axis to or from that point.

use super::program::{Finding, FindingKind, GcodeProgram};
use crate::geometry::{DVec3, distance_to_segment};
use crate::toolpath::{MoveKind, PathPoint, Toolpath};

/// How far a point may be off besides the rounding of its numbers, mm: what is read is in chords.
const CLOSE: f64 = 1e-3;
/// Part of the tolerance by which an axis beside the first rotary axis may be off at the cutter's rim: it is taken for it.
const OFF_POLE: f64 = 0.25;

/// How closely a program must be the path.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Following {
    /// By how much it may leave the path, mm.
    pub tolerance: f64,
    /// By how much its numbers are rounded, mm.
    pub rounding: f64,
    /// Radius of the cutter, mm, at whose rim the direction of the axis counts.
    pub radius: f64,
    /// Height along the tool axis at and above which it may go anywhere before and after the path, mm.
    pub clearance_plane: f64,
}

/// Where a program that was read leaves the path first.
pub fn leaves(program: &GcodeProgram, path: &Toolpath, options: Following) -> Option<Finding> {
    let Following { tolerance, rounding, radius, clearance_plane } = options;
    if rounding > tolerance {
        let message = format!(
            "lengths are rounded by up to {rounding:.4} mm, more than cut.tolerance, {tolerance} mm: give the post more decimals"
        );
        return Some(Finding { line: 1, kind: FindingKind::OffPath, message });
    }
    let read = &program.path.points;
    let close = CLOSE + rounding;
    // Points closer together than this may be met early, so that the next ones are as far beside.
    let most = tolerance.max(3.0 * close);
    let meets = |q: &PathPoint, p: &PathPoint| {
        let off_axis = radius * q.axis.distance(p.axis);
        q.tip.distance(p.tip) <= close && off_axis <= OFF_POLE * tolerance + close
    };
    // Before or after the path: how far off the way along the axis, if too low for going anywhere.
    let off_end = |k: usize, end: &PathPoint| {
        let way = read[k].tip - end.tip;
        let is_high = read[k].tip.dot(read[k].axis) >= clearance_plane - most;
        if is_high { 0.0 } else { (way - way.dot(end.axis).max(0.0) * end.axis).length() }
    };
    let mut at = 0;
    for (i, p) in path.points.iter().enumerate() {
        let before = i.checked_sub(1).map(|i| path.points[i].tip);
        let from = at;
        loop {
            let Some(q) = read.get(at) else {
                let off = |k: &usize| read[*k].tip.distance(p.tip);
                let nearest = (from..read.len()).min_by(|a, b| off(a).total_cmp(&off(b)));
                let (at, off) = nearest.map_or((0, 0.0), |k| (k, off(&k)));
                return Some(finding(program, at, off, p.tip));
            };
            if meets(q, p) {
                break;
            }
            let off = match before {
                None => off_end(at, p),
                Some(_) if p.kind == MoveKind::Rapid => 0.0,
                Some(before) => distance_to_segment(q.tip, before, p.tip),
            };
            if off > most {
                return Some(finding(program, at, off, p.tip));
            }
            at += 1;
        }
    }
    let last = path.points.last()?;
    let after = (at..read.len()).map(|k| (k, off_end(k, last))).find(|(_, off)| *off > most);
    after.map(|(k, off)| finding(program, k, off, last.tip))
}

fn finding(program: &GcodeProgram, at: usize, off: f64, wanted: DVec3) -> Finding {
    Finding {
        line: program.lines.get(at).copied().unwrap_or(1),
        kind: FindingKind::OffPath,
        message: format!(
            "leaves the planned path by {off:.3} mm near ({:.3}, {:.3}, {:.3}): the post writes another path",
            wanted.x, wanted.y, wanted.z
        ),
    }
}
