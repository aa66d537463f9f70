//! Whether a program is the path that it was written from, cut with the tool, offsets, spindle and coolant of the job.
//!
//! The points of the path are sought in the program in their order, to the rounding of its numbers; what the program does
//! between two of them must stay near the straight line that joins them. Where one block may do for a run of points, the points
//! within it need only lie beside its way. Rapids between may run anywhere: their height
//! is judged by `check`. Before the first point and after the last one the program must stay above the clearance plane,
//! or go along the tool axis to or from that point.

use super::program::{Finding, FindingKind, GcodeProgram};
use super::setting::Setting;
use evencut_core::geometry::{DVec3, distance_to_segment};
use evencut_core::toolpath::{MoveKind, PathPoint, Toolpath};

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
    /// Whether it may pass points of the path by within the tolerance: one block for a run of them.
    pub has_runs: bool,
}

/// Where a program that was read leaves the path first.
pub fn leaves(program: &GcodeProgram, path: &Toolpath, options: Following) -> Option<Finding> {
    let Following { tolerance, rounding, radius, clearance_plane, has_runs } = options;
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
    // Whether the program passes a point within a run of cuts by, between two of its own points.
    let passes = |k: usize, i: usize| {
        let is_cut = |i: usize| path.points.get(i).is_some_and(|p| p.kind != MoveKind::Rapid);
        let is_within = i > 0 && is_cut(i) && is_cut(i + 1);
        let next = read.get(k + 1).filter(|q| is_within && q.kind != MoveKind::Rapid);
        next.is_some_and(|q| distance_to_segment(path.points[i].tip, read[k].tip, q.tip) <= most)
    };
    // Whether the program, on its way to a point, comes to where it meets that.
    let ends_run = |k: usize, i: usize| {
        let (before, p) = (path.points[i - 1].tip, &path.points[i]);
        let is_near = |q: &&PathPoint| distance_to_segment(q.tip, before, p.tip) <= most;
        read[k + 1..].iter().take_while(is_near).any(|q| meets(q, p))
    };
    let mut at = 0;
    // The point of the program that lies behind the last point of the path that was passed by.
    let mut behind = None;
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
            // Where a run ends the program meets the path: back along itself that end would be passed by, too.
            if has_runs && passes(at, i) && !ends_run(at, i) {
                behind = Some(at);
                break;
            }
            let off = match before {
                _ if behind == Some(at) => 0.0,
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

/// Where a program first cuts with another setting than the operations, in their order, ask for.
pub fn differs(program: &GcodeProgram, mut wanted: Vec<Setting>) -> Option<Finding> {
    let mut found: Vec<(u32, Setting)> = Vec::new();
    for m in program.moves.iter().filter(|m| !m.rapid) {
        if found.last().is_none_or(|(_, last)| *last != m.setting) {
            found.push((m.line, m.setting));
        }
    }
    let &(_, first) = found.first()?;
    // What the program leaves out is no difference between operations either.
    for setting in &mut wanted {
        setting.tool = setting.tool.filter(|_| first.tool.is_some());
        setting.length_offset = setting.length_offset.filter(|_| first.length_offset.is_some());
        setting.speed = setting.speed.round();
    }
    wanted.dedup();
    let finding = |line, message| Finding { line, kind: FindingKind::Setting, message };
    let other = found.iter().zip(&wanted).find_map(|((line, setting), wanted)| {
        setting.differs(wanted).map(|message| finding(*line, message))
    });
    let (line, there, asked) = (found.last()?.0, found.len(), wanted.len());
    let number = || {
        finding(
            line,
            format!(
                "tool, offsets, spindle and coolant are set {there} times for its cuts; the job asks for {asked}"
            ),
        )
    };
    other.or_else(|| (there != asked).then(number))
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
