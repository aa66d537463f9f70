//! LinuxCNC's own interpreter as a judge of programs.
#![expect(
    clippy::disallowed_methods,
    reason = "a witness that shares no functions with the product"
)]

use evencut_core::geometry::DVec3;
use std::process::Command;

/// Whether rapid, and X, Y, Z, A, B, C.
pub type CanonMove = (bool, [f64; 6]);

/// What LinuxCNC's interpreter says: its canonical moves, or its complaint. `None`, visibly, where
/// the interpreter is not to be had.
pub fn interpreted(text: &str, name: &str) -> Option<Result<Vec<CanonMove>, String>> {
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/../../shared/peers/rs274.sh");
    if !std::path::Path::new(script).exists() {
        println!("skipped: ../shared not present");
        return None;
    }
    let folder = std::env::temp_dir().join(format!("evencut-gcode-{}-{name}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let (program, canon) = (folder.join("p.ngc"), folder.join("p.canon"));
    std::fs::write(&program, text).unwrap();
    let run = Command::new("bash").arg(script).args([&program, &canon]).output().unwrap();
    let lines = std::fs::read_to_string(&canon).unwrap_or_default();
    std::fs::remove_dir_all(&folder).unwrap();
    match run.status.code() {
        Some(0) => Some(Ok(canonical(&lines))),
        Some(1) => Some(Err(String::from_utf8_lossy(&run.stderr).into_owned())),
        code => {
            println!("skipped: LinuxCNC's interpreter could not be had or run ({code:?})");
            None
        }
    }
}

/// The moves among canonical commands, lengths in mm.
fn canonical(lines: &str) -> Vec<CanonMove> {
    let (mut unit, mut plane) = (1.0, [0, 1, 2]);
    let mut moves: Vec<CanonMove> = Vec::new();
    for line in lines.lines() {
        let command = line.split_whitespace().nth(2).unwrap_or_default();
        if command.starts_with("USE_LENGTH_UNITS") {
            unit = if command.contains("INCHES") { 25.4 } else { 1.0 };
        } else if command.starts_with("SELECT_PLANE") {
            plane = [("XY", [0, 1, 2]), ("XZ", [2, 0, 1]), ("YZ", [1, 2, 0])]
                .into_iter()
                .find_map(|(name, axes)| command.contains(name).then_some(axes))
                .unwrap();
        } else if let Some((rapid, mut end)) = straight(line) {
            end[..3].iter_mut().for_each(|length| *length *= unit);
            moves.push((rapid, end));
        } else if command.starts_with("ARC_FEED") {
            moves.push((false, arc(&numbers(line), plane, unit)));
        }
    }
    moves
}

/// End of an `ARC_FEED(first, second, centre, centre, turns, third, a, b, c)`.
fn arc(numbers: &[f64], plane: [usize; 3], unit: f64) -> [f64; 6] {
    let mut end = [0.0, 0.0, 0.0, numbers[6], numbers[7], numbers[8]];
    for (axis, at) in plane.into_iter().zip([0, 1, 5]) {
        end[axis] = unit * numbers[at];
    }
    end
}

/// A `STRAIGHT_FEED(x, y, z, a, b, c)` or `STRAIGHT_TRAVERSE` line.
fn straight(line: &str) -> Option<CanonMove> {
    let rapid = line.contains("STRAIGHT_TRAVERSE");
    if !rapid && !line.contains("STRAIGHT_FEED") {
        return None;
    }
    Some((rapid, numbers(line).try_into().ok()?))
}

/// The arguments of a canonical command.
fn numbers(line: &str) -> Vec<f64> {
    let inside = line.split(['(', ')']).nth(1).unwrap();
    inside.split(',').map(|n| n.trim().parse().unwrap()).collect()
}

/// Machine to workpiece by the definition of the tables, independent of the post.
pub fn in_part(p: [f64; 6]) -> (DVec3, DVec3) {
    let (a, c) = (p[3].to_radians(), p[5].to_radians());
    let untilt =
        |v: DVec3| DVec3::new(v.x, v.y * a.cos() + v.z * a.sin(), v.z * a.cos() - v.y * a.sin());
    let unturn =
        |v: DVec3| DVec3::new(v.x * c.cos() + v.y * c.sin(), v.y * c.cos() - v.x * c.sin(), v.z);
    (unturn(untilt(DVec3::new(p[0], p[1], p[2]))), unturn(untilt(DVec3::Z)))
}
