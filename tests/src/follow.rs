//! Whether moves that were read from a program are the path it was written from.

use evencut_core::geometry::DVec3;
use evencut_core::machine::Machine;
use evencut_core::toolpath::{MoveKind, PathPoint, Toolpath};
use evencut_output::gcode::{GcodeProgram, ReadOptions, read};

/// Largest distance of a programmed point from the path's, mm.
pub const READ_BACK: f64 = 0.001;

/// A program as the machine that it was written for reads it.
pub fn read_for(machine: &Machine, text: &str) -> GcodeProgram {
    let options =
        ReadOptions { axes: machine.axes, rapid_feed: machine.max_feed, ..Default::default() };
    read(text, &options).unwrap_or_else(|error| panic!("{error}"))
}

/// The points of a program: all of moves at feed, the ends of rapids. Rapid or not, tip, axis.
pub fn met(program: &GcodeProgram) -> Vec<(bool, DVec3, DVec3)> {
    let mut met = Vec::new();
    for (i, m) in program.moves.iter().enumerate() {
        let points = &program.path.points[program.points_of(i)];
        // Between rotary positions a rapid may run anywhere above the plane.
        let skipped = if m.rapid { points.len().saturating_sub(1) } else { 0 };
        met.extend(points[skipped..].iter().map(|p| (m.rapid, p.tip, p.axis)));
    }
    met
}

fn distance_to_segment(p: DVec3, a: DVec3, b: DVec3) -> f64 {
    let d = b - a;
    let u = if d.length_squared() > 0.0 { (p - a).dot(d) / d.length_squared() } else { 0.0 };
    p.distance(a + d * u.clamp(0.0, 1.0))
}

/// Asserts that every point of the path is met in order within [`READ_BACK`]; points between lie on
/// its segments within half the path tolerance. `read`: rapid or not, tip, axis.
pub fn assert_follows(
    path: &Toolpath,
    read: &[(bool, DVec3, DVec3)],
    rapid_plane: f64,
    path_tolerance: f64,
    tool_radius: f64,
) {
    let mut next = 0;
    for &(rapid, tip, axis) in read {
        if next == path.points.len() {
            // Only the final retract may follow.
            assert!(tip.dot(axis) > rapid_plane - 0.001, "{tip} after the path's end");
            continue;
        }
        let p = &path.points[next];
        let is_high = tip.dot(axis) > rapid_plane - path_tolerance;
        // An axis beside the C axis may be taken for it, if the cutter's rim is off by little.
        let off_rim = |p: &PathPoint| p.axis.distance(axis) * tool_radius;
        let is_upright = |p: &PathPoint| axis.z.abs() == 1.0 && off_rim(p) < 0.25 * path_tolerance;
        let is_axis = |p: &PathPoint| axis.distance(p.axis) < 1e-5 || is_upright(p);
        let meets = |p: &PathPoint| tip.distance(p.tip) < READ_BACK && is_axis(p);
        if meets(p) {
            assert!(next == 0 || rapid == (p.kind == MoveKind::Rapid));
            next += 1;
            // Points that the program's digits do not tell apart are one block.
            next += path.points[next..].iter().take_while(|p| meets(p)).count();
        } else if next > 0 && !(rapid && is_high) {
            let off = distance_to_segment(tip, path.points[next - 1].tip, p.tip);
            assert!(off < 0.5 * path_tolerance + READ_BACK, "{tip} is {off} mm beside the path");
        }
    }
    assert_eq!(next, path.points.len(), "the program leaves the path at point {next}");
}
