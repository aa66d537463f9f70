//! Programs mean the path they were written from: read back by our reader and by LinuxCNC's interpreter.
#![expect(
    clippy::disallowed_methods,
    reason = "a witness that shares no functions with the product"
)]

use evencut_core::geometry::DVec3;
use evencut_core::machine::{
    Arrangement, Axes, Chain, Coolant, Machine, Post, RotaryAxis, Setup, SpindleDirection,
    WorkOffset,
};
use evencut_core::machine_time::{fill_time, machine_time};
use evencut_core::tool::Tool;
use evencut_core::toolpath::{MoveKind, PathPoint, Toolpath};
use evencut_output::gcode::{
    CheckOptions, Fault, FindingKind, Following, GcodeError, ReadOptions, check, leaves, read,
};
use evencut_output::post::{
    self, Dialect, DialectError, OperationProgram, PostError, Program, ProgramOptions,
};
use evencut_tests::follow::{READ_BACK, assert_follows, met, read_for};
use evencut_tests::grbl::accepted;
use evencut_tests::linuxcnc::{in_part, interpreted};

const RAPID_PLANE: f64 = 60.0;
const TOLERANCE: f64 = 0.005;
const RADIUS: f64 = 5.0;
/// From the tip to the pivot of heads, mm.
const PIVOT: f64 = 180.0;

fn options(axes: Axes) -> ProgramOptions {
    ProgramOptions {
        name: "wavy (rings)\nM30; 50 % \u{e9}".to_string(),
        machine: Machine {
            axes,
            max_feed: 250.0,
            max_acceleration: 2000.0,
            clearance: 10.0,
            travel: evencut_core::machine::Travel::default(),
        },
        rapid_plane: RAPID_PLANE,
        tool: Tool::new(RADIUS, 1.0).unwrap(),
        setup: Setup { tool_number: 3, length_offset: 4, ..Setup::default() },
        spindle: 133.0,
        tolerance: TOLERANCE,
    }
}

/// A LinuxCNC program.
fn program(path: &Toolpath, options: &ProgramOptions) -> Result<Program, PostError> {
    program_of(Post::LinuxCnc, path, options)
}

fn program_of(post: Post, path: &Toolpath, options: &ProgramOptions) -> Result<Program, PostError> {
    post::program(path, options, &Dialect::of(post)?)
}

fn limits() -> CheckOptions {
    CheckOptions {
        clearance_plane: Some(RAPID_PLANE),
        max_feed: Some(options(ac()).machine.max_feed),
        ..CheckOptions::default()
    }
}

fn point(kind: MoveKind, pass: u32, tip: DVec3, axis: DVec3, feed: f64) -> PathPoint {
    PathPoint {
        kind,
        pass,
        region: 0,
        tip,
        axis,
        normal: (axis + DVec3::new(0.05, 0.02, 0.0)).normalize(),
        flat: None,
        feed,
        mrr: 0.0,
        alpha: 0.0,
        time: 0.0,
    }
}

/// Wavy rings, joined in turn by links on the surface and by retracts with rapids.
fn rings(axes: Axes, rings: u32, around: u32) -> Toolpath {
    let axis_at = |t: f64| match axes {
        Axes::ThreeAxis => DVec3::Z,
        Axes::FiveAxis(_) => {
            let tilt = 0.35 + 0.2 * (3.0 * t).sin();
            DVec3::new(tilt.sin() * t.cos(), tilt.sin() * t.sin(), tilt.cos())
        }
    };
    let mut points: Vec<PathPoint> = Vec::new();
    for ring in 0..rings {
        let at = |i: u32| {
            let t = std::f64::consts::TAU * f64::from(i) / f64::from(around);
            let r = 10.0 + 1.5 * f64::from(ring) + 0.8 * (5.0 * t).sin();
            let z = 4.0 * (2.0 * t).cos() - 0.05 * r;
            (DVec3::new(r * t.cos(), r * t.sin(), z), axis_at(t))
        };
        let (first, axis) = at(0);
        let lift = |tip: DVec3| tip + axis * (RAPID_PLANE + 5.0 - tip.dot(axis));
        if ring % 3 == 0 {
            if let Some(&last) = points.last() {
                points.push(point(MoveKind::Link, ring, lift(last.tip), last.axis, 30.0));
            }
            points.push(point(MoveKind::Rapid, ring, lift(first), axis, 0.0));
        }
        points.push(point(MoveKind::Link, ring, first, axis, 15.0));
        for i in 1..=around {
            let (tip, axis) = at(i);
            let feed = if i % 50 < 10 { 12.0 } else { 20.0 };
            points.push(point(MoveKind::Cut, ring, tip, axis, feed));
        }
    }
    Toolpath { points }
}

#[test]
fn reading_back_gives_the_path() {
    let all = Arrangement::ALL.map(|name| (name, name.axes(PIVOT)));
    for (post, (name, axes)) in Post::ALL.into_iter().flat_map(|p| all.map(|a| (p, a))) {
        let path = rings(axes, 9, 400);
        let written = program_of(post, &path, &options(axes));
        if post == Post::Grbl && axes != Axes::ThreeAxis {
            let expected = DialectError::Axes {
                post: "grbl".to_string(),
                table: "five_axis",
                axes: "five axes",
            };
            assert_eq!(written.unwrap_err(), PostError::Dialect(expected));
            continue;
        }
        let text = written.unwrap().text;
        let program = read_for(&options(axes).machine, &text);
        assert_follows(&path, &met(&program), RAPID_PLANE, TOLERANCE, RADIUS);
        let height = |i: usize| program.path.points[i].tip.dot(program.path.points[i].axis);
        for (i, m) in program.moves.iter().enumerate().filter(|(_, m)| m.rapid) {
            let is_high = |p| height(p) >= RAPID_PLANE - TOLERANCE;
            assert!(program.points_of(i).all(is_high), "{post:?}, {name:?}, line {}", m.line);
        }
        let last = height(program.path.points.len() - 1);
        assert!(last >= RAPID_PLANE - 1e-4, "{post:?}, {name:?} ends below the rapid plane");
        let rules = CheckOptions { clearance_plane: Some(RAPID_PLANE - TOLERANCE), ..limits() };
        assert_eq!(check(&program, &rules), [], "{post:?}, {name:?}");
        let rounding = Dialect::of(post).unwrap().rounding();
        assert_eq!(leaves(&program, &path, following(rounding)), None, "{post:?}, {name:?}");
    }
}

/// A post that means another path is found out, whichever way it does.
/// Two operations with their tools in one program are the one path after the other, of every post that changes tools.
#[test]
fn a_program_of_operations_is_all_their_paths() {
    let mut read_back = 0;
    for (post, axes) in Post::ALL.into_iter().flat_map(|post| both_axes().map(|axes| (post, axes)))
    {
        let dialect = Dialect::of(post).unwrap();
        assert_eq!(dialect.changes_tools(&axes), post != Post::Grbl, "{post:?}");
        if post == Post::Grbl {
            continue;
        }
        let lifted = |mut path: Toolpath| {
            let last = path.points[path.points.len() - 1];
            let lift = (RAPID_PLANE + 5.0 - last.tip.dot(last.axis)) * last.axis;
            path.points.push(point(MoveKind::Link, 0, last.tip + lift, last.axis, 30.0));
            path
        };
        let paths = [rings(axes, 6, 300), rings(axes, 4, 200)].map(lifted);
        let tools = [3, 8];
        let operations = [0, 1].map(|i| OperationProgram {
            name: format!("number {i}"),
            path: &paths[i],
            options: ProgramOptions {
                setup: Setup { tool_number: tools[i], length_offset: tools[i], ..Setup::default() },
                ..options(axes)
            },
        });
        let text = post::program_of_operations(&operations, &dialect).unwrap().text;
        let program = read_for(&options(axes).machine, &text);
        let path = Toolpath { points: paths.map(|path| path.points).concat() };
        let bound = READ_BACK.max(dialect.rounding());
        assert_follows(&path, &met(&program), RAPID_PLANE - 0.01, bound + TOLERANCE, RADIUS);
        assert_eq!(check(&program, &CheckOptions::default()), [], "{post:?}");
        for tool in tools {
            let called =
                [format!("T{tool} M6"), format!("TOOL CALL {tool} "), format!("LOADTL/{tool},")];
            assert_eq!(
                called.iter().map(|c| text.matches(&c[..]).count()).sum::<usize>(),
                1,
                "{post:?}"
            );
        }
        // It ends once.
        let ends = ["M2\n", "M30\n", "FINI\n"].map(|end| text.matches(end).count());
        assert_eq!(ends.iter().sum::<usize>(), 1, "{post:?}: {ends:?}");
        if post == Post::LinuxCnc
            && let Some(verdict) = interpreted(&text, "operations")
        {
            verdict.unwrap_or_else(|why| panic!("LinuxCNC rejects it: {why}"));
        }
        read_back += 1;
    }
    assert_eq!(read_back, 12);
}

#[test]
fn a_program_that_is_not_the_path_is_found_out() {
    let changes = [
        ("x = \"X{}\"\ny = \"Y{}\"", "x = \"Y{}\"\ny = \"X{}\""),
        ("length = 4", "length = 1"),
        ("\"G21 G90", "\"G20 G90"),
        ("\"G21 G90", "\"G21 G91"),
        ("z = \"Z{}\"", "z = \"Z-{}\""),
        // Beside the path, before it and after it.
        ("\"{coolant_on}\"]", "\"G0 X0 Y0 Z70\", \"G1 Z-5 F100\"]"),
        ("\"M5\", \"M2\"", "\"G1 X0 Y0 Z-5\", \"M5\", \"M2\""),
    ];
    let path = rings(Axes::ThreeAxis, 3, 200);
    for (old, new) in changes {
        let source = Dialect::source(Post::Grbl);
        assert!(source.contains(old), "{old}");
        let dialect = Dialect::read(source.replacen(old, new, 1).as_bytes()).unwrap();
        let text = post::program(&path, &options(Axes::ThreeAxis), &dialect).unwrap().text;
        // Some are refused as no program at all.
        let Ok(program) = read(&text, &ReadOptions::default()) else { continue };
        let found = leaves(&program, &path, following(dialect.rounding()));
        assert_eq!(found.map(|f| f.kind), Some(FindingKind::OffPath), "{new}");
    }
}

fn following(rounding: f64) -> Following {
    let clearance_plane = RAPID_PLANE;
    Following { tolerance: TOLERANCE, rounding, radius: RADIUS, clearance_plane, has_runs: false }
}

fn both_axes() -> [Axes; 2] {
    [Axes::ThreeAxis, ac()]
}

/// Tables A and C.
fn ac() -> Axes {
    Arrangement::Xyzac.axes(0.0)
}

/// The same axes with other limits.
fn limited(axes: Axes, limit: impl Fn(RotaryAxis) -> RotaryAxis) -> Axes {
    let Axes::FiveAxis(chain) = axes else { return axes };
    Axes::FiveAxis(Chain::new(chain.axes().map(limit), chain.gauge_length()).unwrap())
}

/// Level rings of chords within a tenth of the tolerance, one inside the other, joined by links.
fn level_rings() -> Toolpath {
    let mut points = vec![point(MoveKind::Rapid, 0, DVec3::new(10.0, 0.0, 65.0), DVec3::Z, 0.0)];
    for ring in 0..5 {
        let r = 10.0 - f64::from(ring);
        for i in 0..=500 {
            let t = std::f64::consts::TAU * f64::from(i) / 500.0;
            let (kind, tip) = (if i == 0 { MoveKind::Link } else { MoveKind::Cut }, t.sin_cos());
            points.push(point(
                kind,
                ring as u32,
                DVec3::new(r * tip.1, r * tip.0, 0.0),
                DVec3::Z,
                20.0,
            ));
        }
    }
    Toolpath { points }
}

/// The largest distance of the points of one line from another line, each looked for from where the last one was found
/// on; the witness is not the product's.
fn farthest(points: &[DVec3], line: &[DVec3]) -> f64 {
    let to_segment = |p: DVec3, w: &[DVec3]| {
        let way = w[1] - w[0];
        let u = (p - w[0]).dot(way) / way.length_squared().max(f64::MIN_POSITIVE);
        p.distance(w[0] + way * u.clamp(0.0, 1.0))
    };
    let mut at = 0;
    let off = |p: &DVec3| {
        let near = &line[at.min(line.len() - 2)..(at + 600).min(line.len())];
        let all = near.windows(2).enumerate().map(|(i, w)| (i, to_segment(*p, w)));
        let (i, off) = all.min_by(|a, b| a.1.total_cmp(&b.1)).unwrap();
        at += i;
        off
    };
    points.iter().map(off).fold(0.0, f64::max)
}

/// Blocks along lines and arcs are the path within half the tolerance, and so read the controllers' own parsers.
#[test]
fn runs_of_points_are_lines_and_arcs() {
    let plain = options(Axes::ThreeAxis);
    let arcs = Setup { arcs: true, ..plain.setup };
    let options = ProgramOptions { setup: arcs, ..plain.clone() };
    for (name, path) in [("level", level_rings()), ("wavy", rings(Axes::ThreeAxis, 9, 1000))] {
        let points = program(&path, &plain).unwrap().text.lines().count();
        for post in [Post::LinuxCnc, Post::Fanuc, Post::Haas, Post::Siemens, Post::Grbl] {
            let text = program_of(post, &path, &options).unwrap().text;
            let read = read_for(&options.machine, &text);
            let following = Following { has_runs: true, ..following(1e-4) };
            assert_eq!(leaves(&read, &path, following), None, "{post:?}, {name}");
            // From the first point at feed on: before it rapids go their own way.
            let cuts = |all: &[PathPoint]| -> Vec<DVec3> {
                let cuts = all.iter().filter(|p| p.kind != MoveKind::Rapid && p.tip.z < 20.0);
                cuts.map(|p| p.tip).collect()
            };
            let (planned, found) = (cuts(&path.points), cuts(&read.path.points));
            let first = found.iter().position(|p| p.distance(planned[0]) < 0.001).unwrap();
            let last = found.iter().rposition(|p| p.distance(planned[planned.len() - 1]) < 0.001);
            let found = &found[first..=last.unwrap()];
            let off = farthest(&planned, found).max(farthest(found, &planned));
            assert!(off <= 0.5 * TOLERANCE + 0.0012, "{post:?}, {name}: {off}");
            let blocks = text.lines().count();
            println!("{name}, {post:?}: {blocks} blocks for {points}");
            // A quarter on level ground, two thirds on slopes.
            let most = if name == "level" { points / 4 } else { 2 * points / 3 };
            assert!(blocks <= most, "{post:?}, {name}: {blocks} of {points}");
            // The other way round it is another path.
            let turned = text.replacen("G3 ", "G2 ", 1);
            assert!(turned != text);
            let read = read_for(&options.machine, &turned);
            assert!(leaves(&read, &path, following).is_some(), "{post:?}, {name}");
            match post {
                Post::LinuxCnc => {
                    assert!(interpreted(&text, name).is_none_or(|moves| moves.is_ok()));
                }
                Post::Grbl => assert!(accepted(&text, name).is_none_or(|ok| ok == Ok(()))),
                _ => {}
            }
        }
    }
    let refused = program_of(Post::Heidenhain, &level_rings(), &options).unwrap_err().to_string();
    assert!(refused.starts_with("post: heidenhain has no words for arcs"), "{refused}");
}

/// Points closer together than the tolerance, at a turn, are no leave of it.
#[test]
fn points_close_together_are_not_off_the_path() {
    let at = |x: f64, y: f64| point(MoveKind::Cut, 0, DVec3::new(x, y, 0.0), DVec3::Z, 10.0);
    let mut points = vec![at(0.0, 0.0)];
    points.extend((1..=40).map(|i| at(10.0 + 1e-3 * f64::from(i), 0.0)));
    points.extend((1..=40).map(|i| at(10.04, 1e-3 * f64::from(i))));
    points.extend((1..=40).map(|i| at(10.04 - 1e-3 * f64::from(i), 0.04)));
    points.push(at(0.0, 5.0));
    let path = Toolpath { points };
    for tolerance in [0.002, 0.005, 0.05] {
        let text = program(&path, &options(Axes::ThreeAxis)).unwrap().text;
        let read = read_for(&options(Axes::ThreeAxis).machine, &text);
        let following = Following { tolerance, ..following(1e-4) };
        assert_eq!(leaves(&read, &path, following), None, "{tolerance}");
    }
}

/// A post that gives the feed of the tip a minute takes as long as one that times each block.
#[test]
fn all_posts_take_the_same_time() {
    for axes in both_axes() {
        let path = rings(axes, 3, 300);
        let time = |post| {
            let text = program_of(post, &path, &options(axes)).unwrap().text;
            let read = read_for(&options(axes).machine, &text);
            let cut = read.moves.iter().filter(|m| !m.rapid);
            cut.map(|m| m.duration).sum::<f64>()
        };
        let expected = time(Post::LinuxCnc);
        let all = Post::ALL.into_iter().filter(|p| axes == Axes::ThreeAxis || *p != Post::Grbl);
        for post in all {
            let share = time(post) / expected;
            // Heidenhain's feeds have one decimal: 0.05 of 700 mm/min.
            assert!((share - 1.0).abs() < 2e-4, "{post:?}: {share}");
        }
    }
}

/// Around the C axis a controller with tool centre control is given no more blocks than the path has points if it is
/// given the direction of the axis.
#[test]
fn the_direction_of_the_axis_needs_no_further_blocks() {
    let path = rings(ac(), 2, 200);
    let blocks = |post| {
        let text = program_of(post, &path, &options(ac())).unwrap().text;
        read_for(&options(ac()).machine, &text).moves.iter().filter(|m| !m.rapid).count()
    };
    assert!(blocks(Post::Siemens) <= path.points.len() + 2);
    assert!(blocks(Post::Fanuc) <= blocks(Post::LinuxCnc));
}

#[test]
fn numbers_coolant_and_offsets_come_into_every_program() {
    let setup = Setup {
        program_number: 12,
        tool_number: 7,
        length_offset: 17,
        diameter_offset: 27,
        work_offset: Some(WorkOffset::G55),
        coolant: Coolant::Flood,
        spindle: SpindleDirection::CounterClockwise,
        arcs: false,
    };
    let options = ProgramOptions { setup, ..options(Axes::ThreeAxis) };
    let path = rings(Axes::ThreeAxis, 2, 50);
    let holds = |post, blocks: &[&str]| {
        let text = program_of(post, &path, &options).unwrap().text;
        let mut rest = &text[..];
        for block in blocks {
            let at = rest.find(block).unwrap_or_else(|| panic!("{post:?}: no {block} in\n{rest}"));
            rest = &rest[at + block.len()..];
        }
    };
    holds(
        Post::LinuxCnc,
        &["\nG55\n", "T7 M6\n", "G43 H17\n", "S7980 M4\n", "M8\n", "M9\n", "M2\n"],
    );
    holds(
        Post::Fanuc,
        &["%\nO0012 (", "T7 M6\nG55\nS7980 M4\nM8\nG0 X", "G43 H17 Z60.0000\n", "M30\n%\n"],
    );
    holds(
        Post::Haas,
        &["%\nO0012 (", "T7 M6\nG55\nS7980 M4\nM8\nG0 X", "G43 H17 Z60.0000\n", "M30\n%\n"],
    );
    holds(Post::Siemens, &["\nG55\nT7 M6\nD1\nS7980 M4\nM8\n", "M9\nM5\nM30\n"]);
    holds(
        Post::Heidenhain,
        &[
            "0 BEGIN PGM wavy",
            "Q339=+2\n",
            "TOOL CALL 7 Z S7980\n",
            " M4\n",
            " M8\n",
            " M30\n",
            "END PGM",
        ],
    );
    holds(Post::Grbl, &["\nG55\nS7980 M4\nM8\n", "M9\nM5\nM2\n"]);
    holds(
        Post::Cldata,
        &[
            "LOADTL/7,ADJUST,17\nORIGIN/2\nSPINDL/RPM,7980,CCLW\nCOOLNT/FLOOD\n",
            "COOLNT/OFF\nSPINDL/OFF\nFINI\n",
        ],
    );
    let mist = Setup { coolant: Coolant::Mist, ..setup };
    let refused = program_of(Post::Grbl, &path, &ProgramOptions { setup: mist, ..options.clone() });
    let message = refused.unwrap_err().to_string();
    assert_eq!(message, "post: grbl has no coolant \"mist\"; it has flood, off");
    let far = Setup { work_offset: Some(WorkOffset::G591), ..setup };
    let refused = program_of(Post::Grbl, &path, &ProgramOptions { setup: far, ..options.clone() });
    assert!(refused.unwrap_err().to_string().starts_with("post: grbl has no work offset G59.1"));
}

/// A shop copies a post and changes five things.
#[test]
fn a_post_of_ones_own_is_a_changed_copy() {
    let mut source = Dialect::source(Post::Fanuc).to_string();
    let changes = [
        (
            "rapid = \"G0\"",
            "line_numbers = { prefix = \"N\", first = 10, step = 5 }\nrapid = \"G0\"",
        ),
        ("length = 4", "length = 3\ntrimmed = true"),
        ("\"O{program} ({job})\"", "\"O{program}\", \"(SHOP 7, {job})\""),
        ("flood = \"M8\"", "flood = \"M50\""),
        ("\"G90 G49\", \"M30\"", "\"G90 G49\", \"M99\""),
    ];
    for (old, new) in changes {
        assert_eq!(source.matches(old).count(), 1, "{old}");
        source = source.replace(old, new);
    }
    let dialect = Dialect::read(source.as_bytes()).unwrap();
    let setup = Setup { coolant: Coolant::Flood, ..Setup::default() };
    let options = ProgramOptions { setup, ..options(Axes::ThreeAxis) };
    let text = post::program(&rings(Axes::ThreeAxis, 2, 50), &options, &dialect).unwrap().text;
    assert!(
        text.starts_with("%\nO0001\n(SHOP 7, wavy__rings__M30__50____)\n(evencut)\n"),
        "{text}"
    );
    let lines: Vec<&str> = text.lines().collect();
    assert!(lines.contains(&"N10 G21 G90 G17 G94 G40 G49 G80"), "{text}");
    assert!(lines.contains(&"N15 G91 G28 Z0."), "{text}");
    assert!(lines.iter().any(|line| line.ends_with(" M50")), "{text}");
    assert!(text.ends_with(" M99\n%\n"), "{text}");
    assert!(lines.iter().any(|line| line.contains(" Z60.") && !line.contains("Z60.0")), "{text}");
}

#[test]
fn a_post_that_cannot_be_read_says_why() {
    let source = Dialect::source(Post::LinuxCnc);
    let read = |old: &str, new: &str| {
        assert!(source.contains(old), "{old}");
        Dialect::read(source.replacen(old, new, 1).as_bytes()).unwrap_err().to_string()
    };
    let message = read("rapid = \"G0\"", "rapids = \"G0\"");
    assert_eq!(message, "post: rapid: it is missing; it must be a text");
    let message = read("rapid = \"G0\"", "colour = 3\nrapid = \"G0\"");
    assert!(
        message.starts_with("post: line 5: colour: there is no such key; there are name"),
        "{message}"
    );
    let message = read("feed = 4", "feed = \"4\"");
    assert!(message.ends_with("decimals.feed: it must be a whole number from 0"), "{message}");
    let message = read("position = \"machine\"", "position = \"part\"");
    assert!(message.ends_with("five_axis.position: it must be one of machine, tip"), "{message}");
    let message = read("[words]", "[words");
    assert!(message.contains("line 13"), "{message}");
    let message = read("{tool} M6", "{tol} M6");
    assert!(
        message.starts_with("post: a text of three_axis has {tol}; known are program"),
        "{message}"
    );
    let message = read("x = \"X{}\"", "x = \"X\"");
    assert!(
        message.starts_with("post: words.x is \"X\"; it must be a text with {} once"),
        "{message}"
    );
    let message = read("length = 4", "length = 40");
    assert!(message.contains("decimals.length is 40; it must be 0 to 9"), "{message}");
    let message = read("extension = \"ngc\"", "extension = \"../x\"");
    assert!(message.contains("extension"), "{message}");
    let message = read("\"M5\", \"M2\"", "\"M5\\nG0 Z-50\", \"M2\"");
    assert!(message.contains("one line"), "{message}");
    assert!(Dialect::read(&[b'#'; 70_000]).unwrap_err().to_string().contains("70000 bytes"));
    assert!(Dialect::read(b"\xff").unwrap_err().to_string().contains("no text"));
}

/// Wherever the axes stand at the start, the tool goes up, or to the machine's reference, before it goes across.
#[test]
fn every_program_goes_up_before_it_goes_across() {
    let all = Arrangement::ALL.map(|name| name.axes(PIVOT));
    for (post, axes) in Post::ALL.into_iter().flat_map(|p| all.map(|a| (p, a))) {
        // APT has no blocks that go up alone; controllers are given what its post-processors write.
        if post == Post::Cldata || post == Post::Grbl && axes != Axes::ThreeAxis {
            continue;
        }
        let text = program_of(post, &rings(axes, 1, 50), &options(axes)).unwrap().text;
        let is_comment = |line: &str| {
            let numbered = line.trim_start_matches(char::is_numeric);
            numbered.trim_start().starts_with(['(', ';'])
        };
        let blocks = text.lines().filter(|line| !is_comment(line));
        let words = |line: &str| line.split_whitespace().map(str::to_owned).collect::<Vec<_>>();
        let begins = |words: &[String], letter: char| {
            let number = |w: &String| w.strip_prefix(letter).and_then(|n| n.parse::<f64>().ok());
            words.iter().find_map(number)
        };
        let before: Vec<Vec<String>> =
            blocks.map(words).take_while(|w| begins(w, 'X').is_none()).collect();
        let is_up = |w: &Vec<String>| {
            w.iter().any(|w| w == "G28")
                || begins(w, 'Z').is_some_and(|z| z >= RAPID_PLANE - TOLERANCE)
        };
        assert!(before.iter().any(is_up), "{post:?}, {axes:?}: {before:?}");
    }
}

#[test]
fn programs_are_plain_safe_and_end() {
    for axes in both_axes() {
        let text = program(&rings(axes, 4, 100), &options(axes)).unwrap().text;
        assert!(text.is_ascii() && text.ends_with("\nM5\nM2\n") && !text.contains('%'));
        assert!(!text.contains("-0.0000 ") && !text.contains("-0.0000\n"));
        for line in text.lines().filter(|l| l.contains('(')) {
            assert_eq!((line.matches('(').count(), line.matches(')').count()), (1, 1), "{line}");
        }
        let feed = text.lines().position(|l| l.starts_with("G1")).unwrap();
        assert!(text.lines().nth(feed).unwrap().contains(" F"));
        assert_eq!(text.lines().find(|l| l.starts_with("G0")), Some("G0 Z65.0000"));
    }
}

#[test]
fn rotary_axes_never_jump() {
    let text = program(&rings(ac(), 9, 400), &options(ac())).unwrap().text;
    let word = |line: &str, letter: char| {
        line.split(' ').find_map(|w| w.strip_prefix(letter)).map(|w| w.parse::<f64>().unwrap())
    };
    for letter in ['A', 'C'] {
        let angles: Vec<f64> =
            text.lines().filter(|l| !l.starts_with('(')).filter_map(|l| word(l, letter)).collect();
        assert!(angles.len() > 1000);
        assert!(angles[1..].windows(2).all(|w| (w[1] - w[0]).abs() < 5.0), "{letter} jumps");
    }
}

#[test]
fn inverse_time_adds_up_to_the_commanded_time() {
    let options = options(limited(ac(), |a| RotaryAxis { max_speed: 10.0, ..a }));
    let mut path = rings(ac(), 2, 300);
    fill_time(&mut path, &options.tool, &options.machine);
    let path = Toolpath { points: path.points[1..].to_vec() };
    let read = read_for(&options.machine, &program(&path, &options).unwrap().text);
    let moves = || read.moves.iter().filter(|m| !m.rapid);
    assert!(moves().all(|m| m.inverse_time));
    let timed: Vec<f64> = moves().map(|m| 60.0 / m.feed.unwrap()).collect();
    assert!(moves().zip(&timed).all(|(m, time)| (m.duration - time).abs() < 1e-9));
    // Without the approach before and the retract after the path.
    let total: f64 = timed[1..timed.len() - 1].iter().sum();
    let expected = path.points.last().unwrap().time - path.points[0].time;
    assert!((total / expected - 1.0).abs() < 1e-4, "{total} s is not {expected} s");
    let all: f64 = read.moves.iter().map(|m| m.duration).sum();
    assert!((read.path.points.last().unwrap().time / all - 1.0).abs() < 1e-9);
}

#[test]
fn tables_turn_no_faster_than_they_can() {
    let speed = 0.5;
    let mut options = options(limited(ac(), |a| RotaryAxis { max_speed: speed, ..a }));
    options.machine.max_acceleration = 1e9;
    let mut path = rings(ac(), 3, 300);
    path.points.remove(0);
    // One point stands along the C axis, and C turns there in place.
    path.points[200].axis = DVec3::Z;
    path.points[200].normal = DVec3::Z;
    let read = read_for(&options.machine, &program(&path, &options).unwrap().text);
    let mut at = read.machine[0].rotary;
    let mut moves = Vec::new();
    for (i, m) in read.moves.iter().enumerate() {
        // The first block only lifts: where the tables stand is not yet known.
        let Some(end) = read.points_of(i).last() else { continue };
        let to = read.machine[end].rotary;
        let turn = (0..2).map(|k| (to[k] - at[k]).abs()).fold(0.0, f64::max);
        if !m.rapid {
            moves.push((turn, m.duration));
        }
        at = to;
    }
    let fastest = moves.iter().map(|(turn, time)| turn / time).fold(0.0, f64::max);
    // Without the approach before and the retract after the path.
    let total: f64 = moves[1..moves.len() - 1].iter().map(|(_, time)| time).sum();
    // F has four decimals of a block a minute.
    assert!((0.99 * speed..1.001 * speed).contains(&fastest), "{fastest} rad/s");
    let tolerance = options.tolerance;
    let time = machine_time(&path, &options.tool, &options.machine, tolerance).limited;
    let expected = time.total() - time[MoveKind::Rapid];
    assert!((total / expected - 1.0).abs() < 1e-3, "{total} s is not {expected} s");
}

#[test]
fn interpolation_between_rotary_positions_stays_on_the_line() {
    // One long move that tilts by 60 degrees far from the rotary centre, and one through the pole.
    let tilted = DVec3::new(0.6, 0.3, 0.5).normalize();
    let through = DVec3::new(-0.1, -0.05, 1.0).normalize();
    let start = DVec3::new(80.0, -60.0, 10.0);
    let path = Toolpath {
        points: vec![
            point(MoveKind::Cut, 0, start, tilted, 10.0),
            point(MoveKind::Cut, 0, DVec3::new(90.0, -40.0, 0.0), DVec3::Z, 10.0),
            point(MoveKind::Cut, 0, DVec3::new(90.0, 40.0, 0.0), through, 10.0),
        ],
    };
    let text = program(&path, &options(ac())).unwrap().text;
    let read = read_for(&options(ac()).machine, &text);
    assert!(read.moves.len() > 40, "{} blocks are too few", read.moves.len());
    assert_follows(&path, &met(&read), RAPID_PLANE, TOLERANCE, RADIUS);
}

/// Where the axis passes the C axis so closely that C would jump the tables stand upright, C turns in place, and the
/// cutter's rim is off by less than the tolerance.
#[test]
fn near_the_c_axis_the_tables_turn_in_place() {
    // From above and, where A is half a turn, from below.
    [1.0, -1.0].into_iter().for_each(check_near_the_c_axis);
}

fn check_near_the_c_axis(up: f64) {
    let tilted = |x: f64, y: f64| DVec3::new(x, y, up).normalize();
    let axes = [
        tilted(0.1, 0.0),
        tilted(1e-4, 0.0),
        tilted(-1e-7, 1e-7),
        tilted(1e-12, -1e-9),
        tilted(0.0, 2e-4),
        tilted(0.0, 0.1),
        tilted(1e-5, -0.1),
        tilted(3e-4, 0.1),
    ];
    let at = |i: usize| DVec3::new(80.0 + i as f64, -60.0, 10.0);
    let cut = |(i, &axis): (usize, &DVec3)| point(MoveKind::Cut, 0, at(i), axis, 10.0);
    let path = Toolpath { points: axes.iter().enumerate().map(cut).collect() };
    let text = program(&path, &options(ac())).unwrap().text;
    let read = read_for(&options(ac()).machine, &text);
    assert_follows(&path, &met(&read), RAPID_PLANE, TOLERANCE, RADIUS);
    assert!(read.moves.len() < 1000, "{} blocks are too many", read.moves.len());
    let mut from = 0;
    for (_, tip, axis) in met(&read).into_iter().filter(|m| (m.1.z - 10.0).abs() < 0.01) {
        let way = (tip.x - 80.0).clamp(0.0, 6.999_999);
        from = from.max(way as usize);
        let (a, b) = (axes[way as usize], axes[way as usize + 1]);
        let wanted = a.lerp(b, way.fract()).normalize();
        assert!(RADIUS * axis.distance(wanted) < TOLERANCE, "{tip}: {axis} is not {wanted}");
    }
    assert_eq!(from, 6);
}

#[test]
fn what_must_not_be_written_is_refused() {
    let three = options(Axes::ThreeAxis);
    let written = |p: Vec<PathPoint>| program(&Toolpath { points: p }, &three).unwrap_err();
    let low = DVec3::new(1.0, 2.0, 3.0);
    let high = DVec3::new(1.0, 2.0, 70.0);
    let at = |kind, tip, feed| point(kind, 0, tip, DVec3::Z, feed);
    assert_eq!(written(vec![]), PostError::Empty);
    let error = written(vec![at(MoveKind::Rapid, high, 0.0), at(MoveKind::Rapid, low, 0.0)]);
    assert!(matches!(error, PostError::LowRapid { index: 1, height: 3.0, .. }));
    let error = written(vec![at(MoveKind::Rapid, high, 0.0), at(MoveKind::Cut, low, 0.0)]);
    assert_eq!(error, PostError::Feed { index: 1, feed: 0.0 });
    let error = written(vec![point(MoveKind::Cut, 0, low, DVec3::X, 1.0)]);
    assert!(matches!(error, PostError::TiltedAxis { index: 0, .. }));
    let error = written(vec![at(MoveKind::Cut, DVec3::NAN, 1.0)]);
    assert_eq!(error, PostError::NotFinite { index: 0 });
}

#[test]
fn the_reader_names_the_line() {
    let found = |text: &str| -> Vec<_> {
        let program = read(text, &ReadOptions::default()).unwrap();
        let findings = check(&program, &CheckOptions::default());
        findings.iter().map(|f| (f.line, f.kind)).collect()
    };
    assert_eq!(found("S1 M3\nG0 X1 Y1 Z1\n"), [(2, FindingKind::NoEnd)]);
    assert_eq!(found("S1 M3\nG1 X1 Y1 Z1\nM2"), [(2, FindingKind::NoFeed)]);
    assert_eq!(found("S1 M3 G93\nG1 X1 F2\nX2\nM2"), [(3, FindingKind::NoFeed)]);
    let error = read("G0 Z5\nG2 X1 F2\nM2", &ReadOptions::default()).unwrap_err();
    assert!(matches!(&error, GcodeError::Block { line: 2, fault: Fault::Arc(_), .. }), "{error}");
    let error = read("X1\nM2", &ReadOptions::default()).unwrap_err();
    assert!(matches!(&error, GcodeError::Block { line: 1, fault: Fault::NoMotion, .. }), "{error}");
}

/// Forward kinematics of each arrangement, by hand: tip and tool axis in the workpiece from X, Y, Z, mm, A, B, C, degrees.
fn in_part_of(name: Arrangement, p: [f64; 6]) -> (DVec3, DVec3) {
    let at = DVec3::new(p[0], p[1], p[2]);
    let [(sa, ca), (sb, cb), (sc, cc)] = [p[3], p[4], p[5]].map(|d| d.to_radians().sin_cos());
    let back_by_c = |v: DVec3| DVec3::new(cc * v.x + sc * v.y, cc * v.y - sc * v.x, v.z);
    let back_by_b = |v: DVec3| DVec3::new(cb * v.x - sb * v.z, v.y, cb * v.z + sb * v.x);
    let hanging = |axis: DVec3| (at + PIVOT * (DVec3::Z - axis), axis);
    match name {
        Arrangement::ThreeAxis => (at, DVec3::Z),
        Arrangement::Xyzac => in_part(p),
        Arrangement::Xyzbc => (back_by_c(back_by_b(at)), back_by_c(back_by_b(DVec3::Z))),
        Arrangement::XyzabHead => hanging(DVec3::new(sb, -sa * cb, ca * cb)),
        Arrangement::XyzbcHead => hanging(DVec3::new(cc * sb, sc * sb, cb)),
        Arrangement::XyzbcMixed => {
            let (tip, axis) = hanging(DVec3::new(sb, 0.0, cb));
            (back_by_c(tip), back_by_c(axis))
        }
    }
}

#[test]
fn linuxcnc_understands_the_same_path() {
    for name in Arrangement::ALL {
        let axes = name.axes(PIVOT);
        let path = rings(axes, 12, 1000);
        let text = program(&path, &options(axes)).unwrap().text;
        let Some(moves) = interpreted(&text, name.name()) else { return };
        let moves = moves.unwrap_or_else(|message| panic!("LinuxCNC rejects it: {message}"));
        let read: Vec<_> = moves
            .iter()
            .map(|&(rapid, p)| (rapid, in_part_of(name, p).0, in_part_of(name, p).1))
            .collect();
        let mut rapids = read[1..].iter().filter(|m| m.0);
        assert!(rapids.all(|m| m.1.dot(m.2) >= RAPID_PLANE - TOLERANCE), "{name:?}");
        // The first block only lifts; X and Y are not yet known.
        assert_follows(&path, &read[1..], RAPID_PLANE, TOLERANCE, RADIUS);
    }
}

#[test]
fn grbl_accepts_its_programs() {
    let setup =
        Setup { work_offset: Some(WorkOffset::G57), coolant: Coolant::Flood, ..Setup::default() };
    let options = ProgramOptions { setup, ..options(Axes::ThreeAxis) };
    let text = program_of(Post::Grbl, &rings(Axes::ThreeAxis, 6, 500), &options).unwrap().text;
    let Some(verdict) = accepted(&text, "rings") else { return };
    assert_eq!(verdict, Ok(()));
    // The judge judges: it has no tool changes, and a feed move needs a feed.
    let with_change = text.replacen("S7980", "T1 M6\nS7980", 1);
    assert!(accepted(&with_change, "change").unwrap().is_err());
    assert!(accepted("G21 G90 G94\nG1 X1 Y1\nM2\n", "bad").unwrap().is_err());
}

/// Arcs of every kind in the three planes, increments and inches; positions in tenths of a mil, which
/// both units tell with the four decimals that the interpreter prints.
const BY_HAND: &str = "G21 G90 G17 G94 G40 G49 G80
T1 M6
S1000 M3
G0 X0 Y0 Z25.4
G1 Z-2.54 F500
G2 X25.4 Y0 I12.7 J0
G3 X25.4 Y25.4 R12.7
G3 X50.8 Y0 Z-5.08 R-25.4
G2 I2.54
G3 X50.8 Y0 Z-7.62 I5.08 J2.54 P3
G18 G2 X76.2 Z-7.62 I12.7 K0
G3 X63.5 Z-20.32 Y5.08 R12.7
G2 X63.5 Z-10.16 R-7.62
G19 G2 Y30.48 Z-10.16 J12.7 K0
G3 Y20.32 Z0 R10.16
G3 Y20.32 Z5.08 X50.8 R-5.08
G91 G17 G1 X2.54
G3 X-5.08 Y5.08 I-5.08 J0
X2.54 Y-2.54 R2.54
G18 G2 X5.08 Z5.08 K5.08
G19 G3 Y2.54 Z2.54 R-2.54
G20 X0.5 Y0.1 Z0.1 R0.1
G17 G2 X0.4 Y0.2 I0.25 J0 P2
G90 G3 X1 Y1 R2
G18 G2 X1.5 Z1.1 R-0.5
G90.1 G17 G3 X2 Y1.5 I1.5 J1.5
G91 G91.1 G0 X0.1 Y-0.1 Z0.1
G21 G1 Y12.7
G90 G0 Z50.8
M5
M2
";

#[test]
fn linuxcnc_ends_arcs_where_we_do() {
    let Some(moves) = interpreted(BY_HAND, "arcs") else { return };
    let moves = moves.unwrap_or_else(|message| panic!("LinuxCNC rejects it: {message}"));
    let ours = read(BY_HAND, &ReadOptions::default()).unwrap();
    let ends = |i: usize| ours.path.points[ours.points_of(i).last().unwrap()].tip;
    assert!(moves.len() >= 25 && moves.len() == ours.moves.len());
    for (i, &(rapid, p)) in moves.iter().enumerate() {
        let (line, theirs) = (ours.moves[i].line, DVec3::new(p[0], p[1], p[2]));
        assert_eq!(rapid, ours.moves[i].rapid, "line {line}");
        assert!(ends(i).distance(theirs) < READ_BACK, "line {line}: {} is not {theirs}", ends(i));
    }
}

#[test]
fn linuxcnc_rejects_what_is_wrong() {
    // The judge judges: a feed move without feed must not pass.
    if let Some(verdict) = interpreted("G21 G90 G94\nG1 X1 Y1\nM2\n", "bad") {
        assert!(verdict.is_err());
    }
}

/// Tables beside program zero, and a table C that is wound back at retracts.
#[test]
fn tables_beside_zero_with_ranges_are_written_and_read() {
    let path = rings(ac(), 9, 400);
    let beside = |a: RotaryAxis| RotaryAxis { centre: DVec3::new(12.0, -30.0, -80.0), ..a };
    let turns = |turns: f64| {
        let range = (-turns * std::f64::consts::TAU, turns * std::f64::consts::TAU);
        move |a: RotaryAxis| if a.letter == 'C' { RotaryAxis { range, ..a } } else { a }
    };
    // Three rings between retracts wind C three times: more than two turns do not fit, three and a half do.
    for allowed in [f64::INFINITY, 2.0] {
        let axes = limited(limited(ac(), beside), turns(allowed));
        for post in [Post::LinuxCnc, Post::Fanuc] {
            let options = options(axes);
            let read = read_for(&options.machine, &program_of(post, &path, &options).unwrap().text);
            assert_follows(&path, &met(&read), RAPID_PLANE, TOLERANCE, RADIUS);
            let rules = CheckOptions { clearance_plane: Some(RAPID_PLANE - TOLERANCE), ..limits() };
            assert_eq!(check(&read, &rules), [], "{post:?}, {allowed} turns");
            let wound = read.machine.iter().map(|at| at.rotary[0].abs()).fold(0.0, f64::max);
            let most = allowed.min(9.0) * std::f64::consts::TAU;
            assert!(wound <= most + 1e-6 && wound > 0.7 * most, "{wound} rad, {allowed} turns");
        }
    }
    let narrow = options(limited(ac(), turns(1.0)));
    let error = program(&path, &narrow).unwrap_err();
    assert!(matches!(error, PostError::RotaryTravel { axis: 'C', .. }), "{error}");
    assert!(error.to_string().contains("path.links = \"retract\""), "{error}");
}

#[test]
fn what_the_rotary_axes_cannot_do_is_refused() {
    // A table about the slope between Y and Z leans no farther than a right angle.
    let slope = DVec3::new(0.0, 1.0, 1.0).normalize();
    let nutating = limited(ac(), |a| match a.letter {
        'A' => RotaryAxis { direction: slope, ..a },
        _ => a,
    });
    let below = DVec3::new(0.0, 1.0, -0.2).normalize();
    let at = |axis| point(MoveKind::Cut, 0, DVec3::new(1.0, 2.0, 3.0), axis, 10.0);
    let path = |axis| Toolpath { points: vec![at(DVec3::Z), at(axis)] };
    let error = program(&path(below), &options(nutating)).unwrap_err();
    assert!(error.to_string().contains("C and A cannot turn"), "{error}");
    program(&path(DVec3::new(0.5, 0.5, 0.7).normalize()), &options(nutating)).unwrap();
    // Siemens names the direction of the tool axis; Fanuc needs a word for each axis.
    let without_b = Dialect::source(Post::Fanuc).replace("b = \"B{}\"\n", "");
    let dialect = Dialect::read(without_b.as_bytes()).unwrap();
    let heads = options(Arrangement::XyzabHead.axes(PIVOT));
    let error = post::program(&path(DVec3::Z), &heads, &dialect).unwrap_err().to_string();
    assert!(error.contains("no word for the rotary axis B; add words.b"), "{error}");
}
