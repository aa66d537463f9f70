//! Programs by hand: what they mean is known in closed form.

use super::*;
use evencut_core::geometry::DVec3;
use evencut_core::geometry::math::{acos, cos, hypot, sin};
use evencut_core::machine::{
    Arrangement, Axes, Chain, Coolant, RotaryAxis, Setup, SpindleDirection, Travel, WorkOffset,
};
use evencut_core::toolpath::MoveKind;
use std::f64::consts::{FRAC_PI_2, PI, TAU};

fn plain(text: &str) -> GcodeProgram {
    read(text, &ReadOptions::default()).unwrap_or_else(|error| panic!("{error}"))
}

fn tables(arrangement: Arrangement) -> ReadOptions {
    ReadOptions { axes: arrangement.axes(0.0), ..ReadOptions::default() }
}

fn end(program: &GcodeProgram) -> DVec3 {
    program.path.points.last().unwrap().tip
}

fn tips(program: &GcodeProgram) -> Vec<DVec3> {
    program.path.points.iter().map(|p| p.tip).collect()
}

fn fault(text: &str) -> (u32, Fault) {
    match read(text, &ReadOptions::default()) {
        Err(GcodeError::Block { line, fault, .. }) => (line, fault),
        other => panic!("{other:?}"),
    }
}

fn length(program: &GcodeProgram) -> f64 {
    tips(program).windows(2).map(|w| w[1].distance(w[0])).sum()
}

#[test]
fn words_are_read_as_controllers_read_them() {
    let spaced = plain("G21 G90\nG0 X1.5 Y-0.3 Z10\nG1 Z0 F60\nX2\nM2\n");
    let dense = "\u{feff}%\nO1234 (NAME)\r\nN10g21G90 ; all of it\r\nN20 G00X1.5Y-.3Z+10.(up)\r\n\r\n\
                 (a)g1(b)z0 f 6 0 (c)\r\nX2.\r\nN99999 m30\r\n%\r\nG99 this is not read";
    let dense = plain(dense);
    assert_eq!(tips(&spaced), tips(&dense));
    assert_eq!(spaced.lines, [2, 3, 4]);
    assert_eq!(dense.lines, [4, 6, 7]);
    assert_eq!(dense.findings, []);
    let kinds: Vec<_> = dense.path.points.iter().map(|p| p.kind).collect();
    assert_eq!(kinds, [MoveKind::Rapid, MoveKind::Cut, MoveKind::Cut]);
    assert_eq!(dense.path.points[2].feed, 1.0);
    assert!((dense.path.points[2].time - 10.5).abs() < 1e-12);
}

#[test]
fn accepted_codes_move_nothing() {
    let text = "G17 G40 G49 G80 G61 G54 G94\nG64 P0.01 Q0.02\nT1 M6\nG43 H1\nS1000 M3 M8\nM0\nM1\n\
                G0 X0 Y0 Z5\nG4 P2.5\nG1 F300 X10\nG64\nM7 M9 M5\nM30";
    let program = plain(text);
    assert_eq!(tips(&program), [DVec3::new(0.0, 0.0, 5.0), DVec3::new(10.0, 0.0, 5.0)]);
    assert!((program.path.points[1].time - 4.5).abs() < 1e-12, "2 s of travel, 2.5 s of dwell");
    assert_eq!(program.moves.len(), 2);
    assert_eq!(program.points_of(1), 1..2);
    assert!(program.moves[1].setting.turns() && program.moves[1].duration == 2.0);
}

#[test]
fn units_and_increments_mix() {
    let program = plain(
        "G20 G90 G0 X1 Y1 Z1\nG91 X.5\nG21 Y-5.4\nG90 G1 X0 F600\nG20 F10 G91 Y1\nG21 Y1\nM2",
    );
    let expected = [
        DVec3::new(25.4, 25.4, 25.4),
        DVec3::new(38.1, 25.4, 25.4),
        DVec3::new(38.1, 20.0, 25.4),
        DVec3::new(0.0, 20.0, 25.4),
        DVec3::new(0.0, 45.4, 25.4),
        DVec3::new(0.0, 46.4, 25.4),
    ];
    for (a, b) in tips(&program).iter().zip(expected) {
        assert!(a.distance(b) < 1e-12, "{a} is not {b}");
    }
    let feeds: Vec<_> = program.path.points.iter().map(|p| 60.0 * p.feed).collect();
    assert!((feeds[3] - 600.0).abs() < 1e-9 && (feeds[4] - 254.0).abs() < 1e-9);
    assert_eq!(feeds[5], feeds[4], "a feed in force keeps its speed when units change");
}

#[test]
fn the_path_starts_where_all_is_known() {
    let program = plain("G0 Z50\nX1\nG91 Y5\nX1\nG90 Y2\nG1 X3 F60\nM2");
    assert_eq!(program.lines, [5, 6]);
    assert_eq!(tips(&program)[0], DVec3::new(2.0, 2.0, 50.0));
    assert_eq!(program.path.points[0].time, 0.0);
    assert_eq!(program.moves.len(), 6);
    assert!(plain("G0 X1 Y1\nM2").path.points.is_empty());
}

/// Planes, and their first, second and third axis.
const PLANES: [(&str, [usize; 3]); 3] =
    [("G17", [0, 1, 2]), ("G18", [2, 0, 1]), ("G19", [1, 2, 0])];

#[test]
fn arcs_keep_the_tolerance_in_all_planes() {
    for (code, [first, second, third]) in PLANES {
        let [a, b, across] = [first, second, third].map(|axis| ["X", "Y", "Z"][axis]);
        let [i, j] = [first, second].map(|axis| ["I", "J", "K"][axis]);
        for (sense, sign) in [("G2", -1.0), ("G3", 1.0)] {
            // From angle 0 on a circle of 20 mm about (5, -3) through 1.5 turns and 12 mm along.
            let text = format!(
                "{code} G0 X0 Y0 Z0\n{a}25 {b}-3\n{sense} {a}-15 {b}-3 {across}12 {i}-20 {j}0 P2 F600\nM2"
            );
            let program = plain(&text);
            assert_eq!(program.findings, []);
            let tips = &tips(&program)[1..];
            let sweep = 3.0 * PI;
            let chords = tips.len() - 1;
            let fewest = (sweep / (2.0 * acos(1.0 - 0.001 / 20.0))).ceil() as usize;
            assert!(chords >= fewest && chords <= fewest + 3, "{chords} chords, {fewest} needed");
            for (n, tip) in tips.iter().enumerate() {
                let u = n as f64 / chords as f64;
                let angle = sign * sweep * u;
                let mut expected = DVec3::ZERO;
                expected[first] = 5.0 + 20.0 * cos(angle);
                expected[second] = -3.0 + 20.0 * sin(angle);
                expected[third] = 12.0 * u;
                assert!(tip.distance(expected) < 1e-9, "{code} {sense}: {tip} is not {expected}");
            }
            for pair in tips.windows(2) {
                let middle = pair[0].lerp(pair[1], 0.5);
                let radius = hypot(middle[first] - 5.0, middle[second] + 3.0);
                assert!((0.0..0.001).contains(&(20.0 - radius)));
            }
            let helix = hypot(20.0 * sweep, 12.0);
            let time = program.path.points.last().unwrap().time - program.path.points[1].time;
            assert!((time - helix / 10.0).abs() < 1e-9);
            // Chords are short of their arc by a 24th of the square of their angle.
            assert!(length(&program) > hypot(25.0, 3.0));
        }
    }
}

#[test]
fn full_circles_close_and_helices_have_their_length() {
    for (code, [first, ..]) in PLANES {
        let i = ["I", "J", "K"][first];
        let program = plain(&format!("{code} G0 X1 Y2 Z3\nG2 {i}4 F60\nM2"));
        assert!((length(&program) / (4.0 * TAU) - 1.0).abs() < 1e-4, "{code}");
        assert_eq!(end(&program), DVec3::new(1.0, 2.0, 3.0));
    }
    let program = plain("G0 X1 Y2 Z3\nG91 G3 I4 Z-5 P3 F60\nM2");
    assert!((length(&program) / hypot(12.0 * TAU, 5.0) - 1.0).abs() < 1e-4);
    assert_eq!(end(&program), DVec3::new(1.0, 2.0, -2.0));
    // Steps that do not add up to zero in binary still close the circle.
    let program = plain("G0 X0.1 Y0 Z0\nG91 G1 X.1 F60\nX.1\nG90 G2 X.3 Y0 I1\nM2");
    assert!((length(&program) - 0.2) / TAU > 0.999);
}

#[test]
fn centres_may_be_absolute() {
    let offset = plain("G0 X10 Y0 Z0\nG3 X0 Y10 I-10 J0 F60\nM2");
    let absolute = plain("G0 X10 Y0 Z0\nG90.1 G3 X0 Y10 I0 J0 F60\nM2");
    let back = plain("G90.1 G0 X10 Y0 Z0\nG91.1 G3 X0 Y10 I-10 F60\nM2");
    assert_eq!(tips(&offset), tips(&absolute));
    assert_eq!(tips(&offset), tips(&back));
}

#[test]
fn radii_choose_the_short_or_the_long_way() {
    for (sense, radius, sweep) in [
        ("G3", "10", FRAC_PI_2),
        ("G3", "-10", 3.0 * FRAC_PI_2),
        ("G2", "10", FRAC_PI_2),
        ("G2", "-10", 3.0 * FRAC_PI_2),
    ] {
        let program = plain(&format!("G0 X10 Y0 Z0\n{sense} X0 Y10 R{radius} F60\nM2"));
        assert!((length(&program) / (10.0 * sweep) - 1.0).abs() < 1e-4, "{sense} R{radius}");
        let centre_at_zero = (sense == "G3") == (radius == "10");
        let centre = if centre_at_zero { DVec3::ZERO } else { DVec3::new(10.0, 10.0, 0.0) };
        assert!(tips(&program).iter().all(|tip| (tip.distance(centre) - 10.0).abs() < 1e-9));
    }
    let half = plain("G20 G0 X0 Y0 Z0\nG2 X2 R1 F60\nM2");
    assert!(half.findings.is_empty() && (length(&half) / (25.4 * PI) - 1.0).abs() < 1e-4);
    assert!(tips(&half)[1..].iter().all(|tip| tip.y > -1e-9), "clockwise from left to right");
}

#[test]
fn arcs_that_miss_their_circle_are_findings() {
    let text = "G0 X10 Y0 Z0\nG3 X0 Y10.25 I-10 F60\nG1 X0 Y0\nG2 X20.5 R10\nM2";
    let findings = plain(text).findings;
    assert_eq!(findings.iter().map(|f| f.line).collect::<Vec<_>>(), [2, 4]);
    assert!(findings.iter().all(|f| f.kind == FindingKind::ArcRadius));
    assert!(findings.iter().all(|f| f.message.contains("0.2500 mm")), "{findings:?}");
    let lenient = ReadOptions { arc_tolerance: 0.26, ..ReadOptions::default() };
    assert_eq!(read(text, &lenient).unwrap().findings, []);
    assert_eq!(end(&plain("G0 X10 Y0 Z0\nG3 X0 Y10.25 I-10 F60\nM2")), DVec3::Y * 10.25);
}

/// With tool centre control on, what is programmed is the tip in the workpiece, whichever way the axis is given.
#[test]
fn tool_centre_control_programs_the_tip() {
    let forms = [
        // The axis that stands along Z with A at 90 and C at 0 degrees is Y.
        "G0 A0 C0\nG43.4 H1\nG0 X1 Y2 Z3\nG1 X5 Y2 Z3 A90 F60",
        "G0 A0 C0\nG43.5 H1\nG0 X1 Y2 Z3\nG1 X5 J1 K0 F60",
        "G0 A0 C0\nG234 H1\nG0 X1 Y2 Z3\nG1 X5 A90 F60",
        "TRAORI\nG0 X1 Y2 Z3 A3=0 B3=0 C3=1\nG1 X5 B3=1 C3=0 F60",
    ];
    let heidenhain = "0 BEGIN PGM P MM\n1 TOOL CALL 3 Z S100\n2 M3\n3 FUNCTION TCPM F TCP AXIS SPAT PATHCTRL VECTOR\n4 LN X+1 \
                      Y+2 Z+3 TX+0 TY+0 TZ+1 FMAX\n5 LN X+5 Y+2 Z+3 TX+0 TY+1 TZ+0 F60\n6 M30\n7 END PGM P MM";
    let cldata = "PARTNO P\nSPINDL/RPM,100,CLW\nRAPID\nGOTO/1,2,3,0,0,1\nFEDRAT/60,MMPM\nGOTO/5,2,3,0,1,0\nFINI";
    let words = forms.map(|moves| format!("S100 M3\n{moves}\nG49\nM30"));
    let programs = words.iter().map(String::as_str).chain([heidenhain, cldata]);
    let options = tables(Arrangement::Xyzac);
    for text in programs {
        let program = read(text, &options).unwrap_or_else(|error| panic!("{error}\n{text}"));
        let (first, last) = (program.path.points[0], program.path.points.last().unwrap());
        assert!(first.tip.distance(DVec3::new(1.0, 2.0, 3.0)) < 1e-12, "{text}");
        assert!(last.tip.distance(DVec3::new(5.0, 2.0, 3.0)) < 1e-12, "{text}");
        assert!(last.axis.distance(DVec3::Y) < 1e-12, "{text}: {}", last.axis);
        // The tip goes straight, 4 mm at 60 mm/min, while the axis turns in the plane of Y and Z.
        assert!((last.time - 4.0).abs() < 1e-12, "{text}: {} s", last.time);
        assert!(program.path.points.len() > 3, "{text}");
        for p in &program.path.points {
            let way = (p.tip.x - 1.0) / 4.0;
            assert!((p.tip.y - 2.0).abs() + (p.tip.z - 3.0).abs() < 1e-9, "{text}: {}", p.tip);
            assert!(p.axis.x.abs() < 1e-9 && (0.0..=1.0).contains(&way), "{text}: {}", p.axis);
        }
        // Tables A and C carry the tip from where it is programmed: Rx(90) Rz(0) of it.
        let at = program.machine.last().unwrap();
        assert!(at.linear.distance(DVec3::new(5.0, -3.0, 2.0)) < 1e-9, "{text}: {}", at.linear);
    }
    // Tables B and C stand elsewhere for the same axis; tip and axis are the same.
    let other = tables(Arrangement::Xyzbc);
    for text in [heidenhain, cldata] {
        let program = read(text, &other).unwrap();
        let last = program.path.points.last().unwrap();
        assert!(last.axis.distance(DVec3::Y) < 1e-12 && (last.tip.x - 5.0).abs() < 1e-12);
        // Any tables carry the tip to the same height.
        assert!((program.machine.last().unwrap().linear.z - 2.0).abs() < 1e-9);
    }
}

/// Arcs are those of the tip, too: half a circle of 2 mm about (3, 2) in the workpiece, the table leaning.
#[test]
fn with_tool_centre_control_arcs_are_those_of_the_tip() {
    let options = tables(Arrangement::Xyzac);
    for turn in ["", " A40 C10"] {
        let text = format!(
            "S100 M3\nG0 A30 C0\nG43.4 H1\nG0 X1 Y2 Z3\nG3 X5 Y2 I2 J0 F60{turn}\nG49\nM30"
        );
        let program = read(&text, &options).unwrap();
        let points = &program.path.points;
        assert!(points.len() > 20, "{} points", points.len());
        for p in points {
            let off = (hypot(p.tip.x - 3.0, p.tip.y - 2.0) - 2.0).abs();
            assert!(
                off < 1e-9 && (p.tip.z - 3.0).abs() < 1e-9 && p.tip.y < 2.0 + 1e-9,
                "{}",
                p.tip
            );
        }
        let last = points.last().unwrap();
        assert!(last.tip.distance(DVec3::new(5.0, 2.0, 3.0)) < 1e-9, "{}", last.tip);
        // `2 pi` mm at 60 mm/min.
        assert!((last.time - 2.0 * std::f64::consts::PI).abs() < 1e-9, "{} s", last.time);
    }
}

#[test]
fn numbered_offsets_are_told_apart_and_axes_need_control() {
    for text in [
        "G54.1 P1\nG0 X1 Y1 Z1\nG54.1 P2\nM2",
        "G54\nG0 X1 Y1 Z1\nG154 P1\nM2",
        "0 BEGIN PGM P MM\nCYCL DEF 247 Q339=+1\nL X+1 Y+1 Z+1 FMAX\nCYCL DEF 247 Q339=+2\nEND PGM P MM",
        "G0 X1 Y1 Z1\nA3=0 B3=1 C3=0 X2\nM2",
        "0 BEGIN PGM P MM\nL X+1 Y+1 Z+1 FMAX\nLN X+2 TX+0 TY+1 TZ+0 F60\nEND PGM P MM",
    ] {
        assert!(matches!(fault(text).1, Fault::Refused { .. }), "{text}");
    }
    assert!(matches!(fault("G54.1 P1.5\nG0 X1\nM2").1, Fault::Unused('P')));
    for text in ["G54.1 P2\nG0 X1 Y1 Z1\nG54.1 P2\nM2", "G154 P7\nG0 X1 Y1 Z1\nM2"] {
        assert!(read(text, &ReadOptions::default()).is_ok(), "{text}");
    }
}

#[test]
fn other_formats_name_what_they_do_not_read() {
    let heidenhain = |line: &str| fault(&format!("0 BEGIN PGM P MM\n{line}\n9 END PGM P MM")).1;
    for line in
        ["1 CC X+1 Y+1", "1 CALL LBL 1", "L X+1 RL F100", "1 CYCL DEF 200 DRILLING", "FN 0: Q1 = 5"]
    {
        assert!(matches!(heidenhain(line), Fault::Refused { .. }), "{line}");
    }
    for line in ["1 L X+1..2", "1 L IX+1", "1 L TX+", "1 L X1,5"] {
        assert!(matches!(heidenhain(line), Fault::Word(_)), "{line}");
    }
    let cldata = |line: &str| fault(&format!("PARTNO P\n{line}\nFINI")).1;
    for line in ["CYCLE/DRILL", "GOTO/1,2", "FEDRAT/0.1,MMPR", "CIRCLE/1,2,3,0,0,1,5"] {
        assert!(matches!(cldata(line), Fault::Refused { .. }), "{line}");
    }
    assert!(matches!(cldata("GOTO/1,2,x"), Fault::Word(_)));
}

#[test]
fn errors_name_the_line_and_the_remedy() {
    let at_start = "G0 X0 Y0 Z0\n";
    let refused = [
        "G41 D1",
        "G42.1 D2",
        "G81 X1 Y1 Z-1 R2",
        "G73",
        "M98 P100",
        "M99",
        "G65 P1",
        "O100 sub",
        "o<a> call",
        "#1=5",
        "G1 X[1+2] F9",
        "G92 X0",
        "G10 L2 P1",
        "G52 X1",
        "G68 R10",
        "G43.1",
        "G95",
        "G96 S100",
        "G33",
        "G38.2",
        "G5.1",
        "G7",
        "G123.4",
        "M123",
        "O5",
        "G55 G0 X1",
    ];
    for code in refused {
        let (line, fault) = fault(&format!("G54\n{at_start}{code}\nM2"));
        // What only the machine knows, and what the tool goes elsewhere by, or at another feed.
        let is_harmless = ["#1=5", "G1 X[1+2] F9", "G5.1", "G7", "G123.4", "M123"].contains(&code);
        let Fault::Refused { displaces, .. } = fault else { panic!("{code}: {fault}") };
        assert_eq!(displaces, !is_harmless, "{code}");
        assert_eq!(line, 3, "{code}");
    }
    for word in ["X", "X1..2", "X1-2", "5", "G", "G1.55", "\u{e4}1", "!", "X1/2", ")", "G-1"] {
        let (line, fault) = fault(&format!("{at_start}{word}\nM2"));
        assert!(matches!(fault, Fault::Word(_)), "{word}: {fault}");
        assert_eq!(line, 2);
    }
    for (text, letter) in
        [("G1 I5 F9 X1", 'I'), ("G0 X1 P3", 'P'), ("X1E3", 'E'), ("Q1", 'Q'), ("U1", 'U')]
    {
        assert_eq!(fault(&format!("{at_start}{text}")), (2, Fault::Unused(letter)));
    }
    for text in ["G0 G1", "X1 X2", "G90 G91", "G20 G21", "G17 G18", "G4 G28"] {
        assert!(matches!(fault(text).1, Fault::Twice(_)), "{text}");
    }
    assert_eq!(fault("(open\nM2"), (1, Fault::Comment));
    assert_eq!(fault("\nX1"), (2, Fault::NoMotion));
    assert_eq!(fault("G0 X1\nG80\nX1"), (3, Fault::NoMotion));
    assert_eq!(fault("G2 G53 X1"), (1, Fault::NoMotion));
    assert!(matches!(fault("G0 X1000001"), (1, Fault::TooFar { axis: 'X', .. })));
    assert!(matches!(fault("G0 X0\nG91\nX900000\nX900000"), (4, Fault::TooFar { .. })));
    for long in ["G0 X", "G0 X0 Y0 Z0\nO", "G1 X1 F", "G2 X1 R", "G0 X1\nN1"] {
        let text = format!("{long}{}", "9".repeat(300));
        if let Err(error) = read(&text, &ReadOptions::default()) {
            assert!(error.to_string().len() < 400, "{error}");
        }
    }
    let message = read("G0 X1\n G81 X1 R3 ", &ReadOptions::default()).unwrap_err().to_string();
    assert!(message.starts_with("program, line 2, \"G81 X1 R3\": G81 is not read: a canned cycle"));
}

#[test]
fn arcs_without_a_circle_are_errors() {
    for (arc, why) in [
        ("G2 X9 F9", "no centre"),
        ("G18 G2 X9 J5", "no centre"),
        ("G2 X9 I0 J0", "radius 0"),
        ("G2 X9 Y5 I9 J5", "radius 0"),
        ("G2 X9 R0", "radius 0"),
        ("G2 X0 Y0 R5", "ends where it starts"),
        ("G2 X9 I4.5 R4.5", "both a radius"),
        ("G90.1 G2 X9 I4.5", "one coordinate"),
        ("G2 X9 I4.5 P0", "turns"),
        ("G2 X9 I4.5 P1.5", "turns"),
        ("G2 X1 Y1 R999999999999", "above 10 km"),
        ("G18 G91 G28 Z0\nG2 X9 I4.5", "not known"),
    ] {
        match fault(&format!("G0 X0 Y0 Z0\n{arc}")).1 {
            Fault::Arc(rule) => assert!(rule.contains(why), "{arc}: {rule}"),
            other => panic!("{arc}: {other}"),
        }
    }
    assert_eq!(fault("G0 X0 Y0 Z0\nG2 X9 I4.5 K1"), (2, Fault::Unused('K')));
}

#[test]
fn points_are_bounded() {
    let options = ReadOptions { max_points: 1000, ..ReadOptions::default() };
    for text in ["G0 X0 Y0 Z0\nG2 I5 P999999999\nM2", "G0 X0 Y0 Z0\nG2 I999999\nM2"] {
        let error = read(text, &options).unwrap_err();
        assert!(error.to_string().contains("more than 1000 points"), "{error}");
    }
    let turning = ReadOptions { axes: Arrangement::Xyzac.axes(0.0), ..options };
    for text in ["G0 X999999 Y0 Z0\nC9\nM2", "G0 X1 Y0 Z0\nC999999\nM2"] {
        let error = read(text, &turning).unwrap_err();
        assert!(error.to_string().contains("more than 1000 points"), "{error}");
    }
    let options = ReadOptions { chord_tolerance: 0.0, ..ReadOptions::default() };
    assert!(matches!(
        read("M2", &options),
        Err(GcodeError::Option { name: "chord_tolerance", .. })
    ));
    let options = ReadOptions { rapid_feed: f64::NAN, ..ReadOptions::default() };
    assert!(matches!(read("M2", &options), Err(GcodeError::Option { name: "rapid_feed", .. })));
}

#[test]
fn references_are_followed_where_known() {
    let text = "G0 X1 Y2 Z3\nG91 G28 Z0\nG90 G53 G0 X-10 Y-20\nG30\nM2";
    let zero = Some(DVec3::new(100.0, 200.0, 300.0));
    let program =
        read(text, &ReadOptions { machine_zero: zero, ..ReadOptions::default() }).unwrap();
    let expected = [(1.0, 2.0, 3.0), (1.0, 2.0, 300.0), (90.0, 180.0, 300.0)];
    assert_eq!(tips(&program), expected.map(DVec3::from));
    // Before and after the path they need not be known.
    let program = plain("G91 G28 Z0\nG90 G0 X0 Y0\nZ5\nG1 X5 F9\nG91 G28 X1 Z1\nG28 Y0\nM2");
    assert_eq!(program.lines, [3, 4, 5]);
    assert_eq!(end(&program), DVec3::new(6.0, 0.0, 6.0));
    let (line, fault) = fault("G0 X0 Y0 Z5\nG53 G0 Z0\nX7\nZ3\nM2");
    assert_eq!((line, fault), (4, Fault::Lost { since: 2 }));
}

#[test]
fn deleted_blocks_are_left_out_when_asked() {
    let text = "G0 X0 Y0 Z5\n/G1 X5 F9\nN30/2 X6\nG1 X9 F9\nM2";
    assert_eq!(plain(text).lines, [1, 2, 3, 4]);
    let options = ReadOptions { block_delete: true, ..ReadOptions::default() };
    assert_eq!(read(text, &options).unwrap().lines, [1, 4]);
}

#[test]
fn the_ways_of_giving_feed_give_time() {
    let program = plain("G0 X0 Y0 Z0\nG93 G1 X10 F30\nX10 F60\nY5 F2\nG94 G1 Y0 F60\nM2");
    let times: Vec<_> = program.path.points.iter().map(|p| p.time).collect();
    assert_eq!(times, [0.0, 2.0, 33.0, 38.0], "a move without length takes its time as well");
    assert_eq!(program.path.points[1].feed, 5.0);
    let rapids = ReadOptions { rapid_feed: 20.0, ..ReadOptions::default() };
    let program = read("G0 X0 Y0 Z0\nX30 Y40\nM2", &rapids).unwrap();
    assert_eq!((program.path.points[1].time, program.path.points[1].feed), (2.5, 20.0));
    // Without a feed there is no time, and the path goes on.
    let program = plain("G0 X0 Y0 Z0\nG1 X9\nG93 X5\nM2");
    assert!(program.path.points.iter().all(|p| p.time == 0.0));
    assert_eq!(program.path.points[1].feed, 0.0);
}

#[test]
fn rotary_words_need_tables() {
    let refused = |text: &str, options: &ReadOptions| read(text, options).unwrap_err().to_string();
    let message = refused("G0 X0 Y0 Z0\nA10\nM2", &ReadOptions::default());
    assert!(message.contains("line 2") && message.contains("machine.axes"), "{message}");
    let message = refused("G0 B1", &tables(Arrangement::Xyzac));
    assert!(
        message.contains("B moves a rotary axis that a machine with the axes XYZCA does not have"),
        "{message}"
    );
    assert!(refused("G0 A1", &tables(Arrangement::Xyzbc)).contains("XYZCB does not have"));
}

#[test]
fn tables_turn_the_path_and_the_axis() {
    let ac = read("G0 X1 Y2 Z3 A90 C0\nC90\nM2", &tables(Arrangement::Xyzac)).unwrap();
    let (first, last) = (ac.path.points[0], ac.path.points.last().unwrap());
    // A = 90: machine (x, y, z) is workpiece (x, z, -y).
    assert!(first.tip.distance(DVec3::new(1.0, 3.0, -2.0)) < 1e-12);
    assert!(first.axis.distance(DVec3::Y) < 1e-12);
    assert!(
        last.tip.distance(DVec3::new(3.0, -1.0, -2.0)) < 1e-12
            && last.axis.distance(DVec3::X) < 1e-12
    );
    let bc = read("G0 X1 Y2 Z3 B90 C0\nC90\nM2", &tables(Arrangement::Xyzbc)).unwrap();
    let (first, last) = (bc.path.points[0], bc.path.points.last().unwrap());
    assert!(first.tip.distance(DVec3::new(-3.0, 2.0, 1.0)) < 1e-12);
    assert!(first.axis.distance(-DVec3::X) < 1e-12);
    assert!(
        last.tip.distance(DVec3::new(2.0, 3.0, 1.0)) < 1e-12
            && last.axis.distance(DVec3::Y) < 1e-12
    );
    assert_eq!(ac.machine.last().unwrap().linear, DVec3::new(1.0, 2.0, 3.0));
    assert!((ac.machine.last().unwrap().rotary[0] - FRAC_PI_2).abs() < 1e-15);
}

#[test]
fn turning_moves_keep_the_tolerance() {
    let texts = [
        "G0 X30 Y0 Z0\nG1 C180 F360\nM2",
        "G0 X30 Y5 Z10\nG1 X-20 Y9 A50 C-200 F360\nM2",
        "G0 X30 Y5 Z10\nG93 G2 X35 I2.5 Z2 A20 C10 P2 F3\nM2",
    ];
    for text in texts {
        let options = tables(Arrangement::Xyzac);
        let program = read(text, &options).unwrap();
        let fine = read(text, &ReadOptions { chord_tolerance: 1e-6, ..options }).unwrap();
        assert!(fine.lines.len() > 5 * program.lines.len());
        let mut at = 0;
        for p in &fine.path.points[1..] {
            let pair = |at: usize| [program.path.points[at], program.path.points[at + 1]];
            while pair(at)[1].time < p.time - 1e-9 {
                at += 1;
            }
            let [a, b] = pair(at);
            let d = b.tip - a.tip;
            let u = ((p.tip - a.tip).dot(d) / d.length_squared()).clamp(0.0, 1.0);
            let off = p.tip.distance(a.tip.lerp(b.tip, u));
            assert!(off < 0.00101, "{text}: {off} mm");
            let turned = p.axis.distance(a.axis.lerp(b.axis, u));
            assert!(turned < 0.001, "{text}: axis off by {turned}");
        }
    }
    let program = read(texts[0], &tables(Arrangement::Xyzac)).unwrap();
    let last = program.path.points.last().unwrap();
    assert!((last.time - 30.0).abs() < 1e-9, "180 degrees at 360 a minute");
    assert!((length(&program) / (30.0 * PI) - 1.0).abs() < 1e-4);
    assert!((last.feed / PI - 1.0).abs() < 1e-4, "the tip moves at 30 mm times 6 degrees a second");
}

const SOUND: &str =
    "G21 G90 G94\nS9000 M3\nG0 Z50\nX0 Y0\nG1 Z0 F600\nX10\nZ50\nG0 X20\nG1 Z0\nX30\nZ50\nM5\nM2\n";

fn limits() -> CheckOptions {
    CheckOptions {
        clearance_plane: Some(50.0),
        travel: Travel { x: Some((0.0, 30.0)), y: None, z: Some((-1.0, 60.0)) },
        max_feed: Some(10.0),
    }
}

fn kinds(text: &str) -> Vec<(u32, FindingKind)> {
    let findings = check(&plain(text), &limits());
    findings.iter().map(|finding| (finding.line, finding.kind)).collect()
}

#[test]
fn sound_programs_have_no_findings() {
    assert_eq!(kinds(SOUND), []);
}

#[test]
fn each_fault_is_found_at_its_line() {
    use FindingKind::*;
    let changed = |from: &str, to: &str| kinds(&SOUND.replacen(from, to, 1));
    assert_eq!(changed("G0 X20", "G0 X20 Z49.9"), [(8, DiagonalRapid)]);
    assert_eq!(changed("G0 X20\nG1 Z0", "G0 X20\nZ40\nG1 Z0"), [(9, LowRapid)]);
    assert_eq!(changed("Z50\nG0 X20", "G0 Z50\nX20"), [(7, LowRapid)]);
    assert_eq!(changed("G0 Z50\nX0 Y0", "G0 Z40\nZ50\nX0 Y0"), [(3, LowRapid)]);
    assert_eq!(changed(" F600", ""), [(5, NoFeed)]);
    assert_eq!(changed("F600", "F0"), [(5, NoFeed)]);
    assert_eq!(changed("G1 Z0 F600", "G93 G1 Z0 F12"), [(6, NoFeed)]);
    assert_eq!(changed("F600", "F600.1"), [(5, FastFeed)]);
    assert_eq!(changed("G1 Z0 F600\nX10", "G93 G1 Z0 F12\nX10 F61\nG94 F600"), [(6, FastFeed)]);
    assert_eq!(changed(" M3", ""), [(5, SpindleOff)]);
    assert_eq!(changed("S9000 ", ""), [(5, SpindleOff)]);
    assert_eq!(changed("G0 X20\nG1 Z0", "G0 X20 M5\nG1 Z0"), [(9, SpindleOff)]);
    assert_eq!(changed("X30", "X30.2 Z-1.5"), [(10, Travel), (10, Travel)]);
    assert_eq!(changed("X10\n", "X10\nG2 X12 I1.1\nG1\n"), [(7, ArcRadius)]);
    assert_eq!(changed("M2\n", "\n"), [(13, NoEnd)]);
}

#[test]
fn findings_say_how_far_and_for_how_long() {
    let text = SOUND.replacen(" F600", "", 1).replacen("X30", "X31", 1);
    let findings = check(&plain(&text), &limits());
    let said: Vec<_> = findings.iter().map(|finding| finding.to_string()).collect();
    assert_eq!(said.len(), 2);
    assert!(said[0].starts_with("program, line 5: ") && said[0].ends_with("(6 moves, to line 11)"));
    assert!(
        said[1].contains("line 10: X goes to 31.000; the machine allows 0 to 30 mm"),
        "{said:?}"
    );
    let found = check(&read(&text, &ReadOptions::default()).unwrap(), &limits());
    assert_eq!(found, findings);
    assert_eq!(check(&plain(&text), &CheckOptions::default()).len(), 1, "limits are optional");
}

#[test]
fn tables_have_limits_too() {
    let text = "S1 M3\nG0 X0 Y0 Z50 A10 C720\nG93 G1 A-40 F60\nM2";
    let Axes::FiveAxis(chain) = Arrangement::Xyzac.axes(0.0) else { panic!("tables") };
    let [c, a] = *chain.axes();
    let range = (-30.0f64.to_radians(), 30.0f64.to_radians());
    let chain = Chain::new([c, RotaryAxis { range, ..a }], 0.0).unwrap();
    let reading = ReadOptions { axes: Axes::FiveAxis(chain), ..ReadOptions::default() };
    let findings = check(&read(text, &reading).unwrap(), &CheckOptions::default());
    assert_eq!(findings.len(), 1);
    assert!(findings[0].message.contains("-40.000"), "{}", findings[0]);
    // A turn about the rotary centre while the machine descends is a diagonal rapid.
    let text = "G0 X0 Y0 Z50\nA10 Z20\nM2";
    let options = CheckOptions { clearance_plane: Some(50.0), ..CheckOptions::default() };
    let findings = check(&read(text, &tables(Arrangement::Xyzac)).unwrap(), &options);
    assert_eq!(findings[0].kind, FindingKind::DiagonalRapid);
}

#[test]
fn what_the_machine_is_set_to_is_compared_with_the_job() {
    let setup = Setup {
        tool_number: 3,
        length_offset: 4,
        work_offset: Some(WorkOffset::G591),
        coolant: Coolant::Flood,
        spindle: SpindleDirection::CounterClockwise,
        ..Setup::default()
    };
    let job = Setting::wanted(&setup, 50.004);
    let start = "G21 G59.1\nT3 M6\nG43 H4\nS3000 M4\nM8\nG0 X0 Y0 Z5\nG1 F300 X10\n";
    let message = |program: &str, jobs: &[Setting]| {
        differs(&plain(&format!("{program}M9 M5\nM2")), jobs.to_vec())
            .map(|finding| (finding.line, finding.message))
    };
    assert_eq!(message(start, &[job]), None);
    assert_eq!(message(start, &[job; 3]), None, "operations with one setting are one");
    for (from, to, wanted) in [
        ("T3", "T5", "cuts with tool 5; the job has 3"),
        ("H4", "H3", "the length offset is 3; the job has 4"),
        ("G59.1", "G59.2", "the work offset is G59.2; the job has G59.1"),
        ("S3000", "S300", "the spindle turns at 300 rev/min; the job has 3000"),
        ("M4", "M3", "the spindle turns the other way than the job says (M3, M4)"),
        ("M8", "M9", "cuts without the coolant that the job asks for"),
    ] {
        let program = start.replace(from, to);
        assert_eq!(message(&program, &[job]), Some((7, wanted.to_string())), "{to}");
    }
    // Numbers that a program leaves out are those of the machine.
    assert_eq!(message(&start.replace("T3 M6\nG43 H4\n", ""), &[job]), None);
    // A second tool.
    let second = Setting { tool: Some(7), speed: 5000.0, ..job };
    let both = format!("{start}G0 Z9\nT7 M6\nS5000 M4\nG0 X0\nG1 X5\n");
    assert_eq!(message(&both, &[job, second]), None);
    assert_eq!(message(&both, &[second, job]).unwrap().0, 7);
    assert_eq!(message(&both, &[job]).unwrap().0, 12);
    assert_eq!(message(start, &[job, second]).unwrap().0, 7);
    // The length of the tool is no longer taken into account.
    let without = format!("{start}G49\nG1 X5\n");
    assert_eq!(message(&without, &[job]).unwrap().0, 9);
}

/// Where the tip is depends on it: without it a longer tool goes into the part.
#[test]
fn a_tool_that_was_changed_cuts_with_its_length_only() {
    let lacking = |set: &str| {
        let text = format!("G21 G49\n{set}\nS3000 M3\nG0 X0 Y0 Z5\nG1 F300 X10\nX20\nM2");
        let all = check(&plain(&text), &CheckOptions::default());
        all.iter().map(|finding| (finding.line, finding.kind)).collect::<Vec<_>>()
    };
    for set in ["", "T1 M6\nG43 H1", "T1 M6 G43 H1", "T1 M6\nG43", "T1 M6\nG43.4 H1", "T1 M6\nD1"] {
        assert_eq!(lacking(set), [], "{set}");
    }
    for set in ["T1 M6\nG0", "T1 M6 G43 H1\nG49", "T1 M6\nD0", "T1 M6 G43 H1\nT2 M6"] {
        assert_eq!(lacking(set), [(6, FindingKind::NoLength)], "{set}");
    }
}

#[test]
fn other_formats_name_tool_and_offsets_too() {
    let apt = "PARTNO A\nUNITS/MM\nLOADTL/6,ADJUST,7\nSPINDL/RPM,900,CCLW\nCOOLNT/MIST\nFEDRAT/60,MMPM\n\
               GOTO/0,0,0\nGOTO/1,0,0\nCOOLNT/OFF\nGOTO/2,0,0\nFINI\n";
    let conversational = "BEGIN PGM A MM\nTOOL CALL 6 Z S900\nM4\nM8\nL X+0 Y+0 Z+0 F60\nL X+1\nM9\nL X+2\nM30\nEND PGM A MM\n";
    for (text, offset) in [(apt, Some(7)), (conversational, None)] {
        let program = plain(text);
        let set: Vec<Setting> = program.moves.iter().map(|m| m.setting).collect();
        assert_eq!(set[1].tool.zip(Some(set[1].speed)), Some((6, 900.0)));
        assert_eq!(set[1].length_offset, offset);
        assert_eq!(set[1].direction, Some(SpindleDirection::CounterClockwise));
        assert_eq!([set[1].has_coolant, set[2].has_coolant], [true, false]);
    }
    let named = plain(&apt.replace("LOADTL/6,ADJUST,7", "LOADTL/EM6"));
    assert_eq!(named.moves[1].setting.tool, None);
}
