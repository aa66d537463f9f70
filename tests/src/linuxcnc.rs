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
        Some(0) => Some(Ok(lines.lines().filter_map(straight).collect())),
        Some(1) => Some(Err(String::from_utf8_lossy(&run.stderr).into_owned())),
        code => {
            println!("skipped: LinuxCNC's interpreter could not be had or run ({code:?})");
            None
        }
    }
}

/// A `STRAIGHT_FEED(x, y, z, a, b, c)` or `STRAIGHT_TRAVERSE` line.
fn straight(line: &str) -> Option<CanonMove> {
    let rapid = line.contains("STRAIGHT_TRAVERSE");
    if !rapid && !line.contains("STRAIGHT_FEED") {
        return None;
    }
    let inside = line.split(['(', ')']).nth(1)?;
    let numbers: Vec<f64> = inside.split(',').map(|n| n.trim().parse().unwrap()).collect();
    Some((rapid, numbers.try_into().ok()?))
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
