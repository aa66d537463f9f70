//! Paths: tables, and programs of any controller.

use crate::{Outcome, refused};
use evencut_core::geometry::DVec3;
use evencut_core::machine::{Arrangement, Coolant, Machine, Setup, Travel};
use evencut_core::tool::Tool;
use evencut_core::toolpath::{MoveKind, PathPoint, Toolpath};
use evencut_output::gcode::{self, CheckOptions, GcodeProgram, ReadOptions};
use evencut_output::post::{self, Dialect, ProgramOptions};
use evencut_service::results::Input;
use evencut_service::verdict::{ProgramRules, ReadPath};

/// Points of a program: enough for small ones, and for the limit to be met.
const MOST_POINTS: usize = 20_000;

/// A table of a path.
pub fn toolpath(bytes: &[u8]) -> Outcome {
    match ReadPath::new(Input { name: "toolpath.csv", bytes }, &ProgramRules::default()) {
        Ok(read) => {
            let points = &read.path.points;
            assert!(points.len() <= bytes.len() / 31);
            assert!(points.iter().all(|p| p.tip.is_finite()));
            let is_unit = |v: DVec3| (v.length() - 1.0).abs() < 1e-9;
            assert!(points.iter().all(|p| is_unit(p.axis) && is_unit(p.normal)));
            let again = Toolpath::from_csv(&read.path.to_csv(&[]));
            let again = again.unwrap_or_else(|error| panic!("what was written: {error}"));
            assert_eq!(again.points.len(), points.len());
            Outcome::Read
        }
        Err(error) => refused(&error.to_string()),
    }
}

/// A post-processor's file: what it reads writes programs without a panic.
pub fn post(bytes: &[u8]) -> Outcome {
    let dialect = match Dialect::read(bytes) {
        Ok(dialect) => dialect,
        Err(error) => return refused(&error.to_string()),
    };
    for axes in Arrangement::ALL.map(|name| name.axes(100.0)) {
        let machine = Machine {
            axes,
            max_feed: 100.0,
            max_acceleration: 1000.0,
            clearance: 10.0,
            travel: Travel::default(),
        };
        let options = ProgramOptions {
            name: "fuzz".into(),
            machine,
            rapid_plane: 10.0,
            tool: Tool::new(3.0, 1.0).expect("a bull end"),
            setup: Setup { coolant: Coolant::Flood, ..Setup::default() },
            spindle: 100.0,
            tolerance: 0.01,
        };
        let path = Toolpath { points: vec![at(0.0, 0.0), at(5.0, 0.2)] };
        match post::program(&path, &options, &dialect) {
            Ok(program) => assert!(program.text.is_ascii() && program.text.ends_with('\n')),
            Err(error) => drop(refused(&error.to_string())),
        }
    }
    Outcome::Read
}

/// A cut to `x` with an axis that leans by `lean`.
fn at(x: f64, lean: f64) -> PathPoint {
    let axis = DVec3::new(lean, 0.0, 1.0).normalize();
    PathPoint {
        kind: MoveKind::Cut,
        pass: 0,
        region: 0,
        tip: DVec3::new(x, 1.0, 2.0),
        axis,
        normal: axis,
        flat: None,
        feed: 10.0,
        mrr: 0.0,
        alpha: 0.0,
        time: 0.0,
    }
}

/// A program, as machines of all kinds read it.
pub fn program(bytes: &[u8]) -> Outcome {
    let text = String::from_utf8_lossy(bytes);
    let zero = Some(DVec3::splat(100.0));
    let machines = [
        (Arrangement::ThreeAxis, zero, false),
        (Arrangement::ThreeAxis, None, true),
        (Arrangement::Xyzac, zero, true),
        (Arrangement::XyzbcMixed, None, false),
    ];
    let mut outcome = Outcome::Refused;
    for (arrangement, machine_zero, block_delete) in machines {
        let options = ReadOptions {
            axes: arrangement.axes(100.0),
            machine_zero,
            block_delete,
            max_points: MOST_POINTS,
            ..ReadOptions::default()
        };
        match gcode::read(&text, &options) {
            Ok(program) => {
                assert_sound(&program);
                outcome = Outcome::Read;
            }
            Err(error) => drop(refused(&error.to_string())),
        }
    }
    outcome
}

/// Whatever was read is a path.
fn assert_sound(program: &GcodeProgram) {
    let points = &program.path.points;
    assert!(points.len() <= MOST_POINTS && points.len() == program.lines.len());
    assert_eq!(points.len(), program.machine.len());
    assert!(points.iter().all(|p| p.tip.is_finite() && (p.axis.length() - 1.0).abs() < 1e-9));
    assert!(points.iter().all(|p| p.feed >= 0.0 && p.time >= 0.0));
    assert!(points.windows(2).all(|pair| pair[1].time >= pair[0].time));
    assert!(program.lines.windows(2).all(|pair| pair[1] >= pair[0]));
    let limits =
        CheckOptions { clearance_plane: Some(10.0), max_feed: Some(5.0), ..Default::default() };
    let findings = gcode::check(program, &limits);
    assert!(findings.len() <= 8 * program.moves.len() + 1);
    assert!(findings.windows(2).all(|pair| pair[1].line >= pair[0].line));
}
