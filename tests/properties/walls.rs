//! Walls around what is machined: the cutter touches them and never enters them, and what it cannot reach beside them
//! is as large as geometry says.

use std::f64::consts::{FRAC_PI_2, PI, TAU};
use std::fmt::Write;

use evencut_core::geometry::math::{cos, sin};
use evencut_core::job::{self, Job};
use evencut_core::plan::{Files, plan};
use evencut_service::compare::{Figures, judged};

/// Height of the cusps, mm.
const SCALLOP: f64 = 0.05;

/// A cutter, with what says how wide its strips are.
#[derive(Copy, Clone)]
struct Cutter {
    kind: &'static str,
    radius: f64,
    corner: f64,
    strips: &'static str,
}

const CUTTERS: [Cutter; 3] = [
    Cutter { kind: "flat", radius: 5.0, corner: 0.0, strips: "stepover = 2.0" },
    Cutter { kind: "bull", radius: 5.0, corner: 2.0, strips: "scallop = 0.05" },
    Cutter { kind: "ball", radius: 4.0, corner: 4.0, strips: "scallop = 0.05" },
];

impl Cutter {
    /// How far from its axis it cuts deep enough on level ground, mm.
    fn covers(&self) -> f64 {
        let lack = self.corner - SCALLOP.min(self.corner);
        self.radius - self.corner + (self.corner * self.corner - lack * lack).sqrt()
    }

    /// A job on a file of that name, with walls.
    fn job(&self, surface: &str, more: &str) -> Job {
        let corner = match self.kind {
            "bull" => format!("corner_radius = {}\n", self.corner),
            _ => String::new(),
        };
        let text = format!(
            "version = 1\n{surface}\n[tool]\nkind = \"{}\"\ndiameter = {}\n{corner}\
             [cut]\n{}\nfeed = 1200.0\naxial_depth = 0.5\n[path]\nboundary = \"wall\"\n{more}",
            self.kind,
            2.0 * self.radius,
            self.strips,
        );
        match job::read(text.as_bytes()) {
            Ok(resolved) => resolved.job,
            Err(faults) => panic!("{}", faults.render("walls", text.as_bytes())),
        }
    }
}

const FILE: &str = "[surface]\nfile = \"part.obj\"";
const OFF: &str = "[force]\ncontrol = \"off\"\n";

/// The job's path as the judge sees it, which must touch the wall at most and not cut in.
fn judgement(name: &str, job: &Job, file: Option<&[u8]>) -> Figures {
    let plan = plan(job, Files::of_surface(file), 2, &mut |_, _| {})
        .unwrap_or_else(|error| panic!("{name}: {error}"));
    let figures = judged(job, &plan, 2).unwrap_or_else(|error| panic!("{name}: {error}"));
    let v = figures.report.verification.as_ref().unwrap();
    let walls = v.walls.as_ref();
    println!(
        "{name:24} wall {:7.2} µm, gouge {:6.2} µm, scallop {:7.1} µm, rest {:9.3} mm², untouched {} mm²",
        1e3 * walls.map_or(0.0, |w| w.deepest_mm),
        1e3 * v.gouge_mm,
        1e3 * v.scallop.largest_mm,
        v.rest_mm2,
        v.untouched_mm2,
    );
    assert!(walls.is_none_or(|w| w.deepest_mm <= job.cut.tolerance), "{name}: {walls:?}");
    assert!(v.gouge_mm >= -job.cut.tolerance, "{name}: {:?}", v.broken);
    figures
}

/// The same of a path that must keep all limits.
fn kept(name: &str, job: &Job, file: Option<&[u8]>) -> Figures {
    let figures = judgement(name, job, file);
    let v = figures.report.verification.as_ref().unwrap();
    assert!(v.passed, "{name}: {:?}", v.broken);
    figures
}

/// A level plate of cells of 2 mm as OBJ.
fn plate(cells: (u32, u32), is_in: impl Fn(u32, u32) -> bool) -> Vec<u8> {
    let (nx, ny) = cells;
    let mut text = String::new();
    for (i, j) in (0..=ny).flat_map(|j| (0..=nx).map(move |i| (i, j))) {
        writeln!(text, "v {} {} 0", 2 * i, 2 * j).unwrap();
    }
    for (i, j) in (0..ny).flat_map(|j| (0..nx).map(move |i| (i, j))).filter(|&(i, j)| is_in(i, j)) {
        let at = 1 + i + j * (nx + 1);
        writeln!(text, "f {} {} {} {}", at, at + 1, at + nx + 2, at + nx + 1).unwrap();
    }
    text.into_bytes()
}

/// A level ring as OBJ.
fn annulus(inner: f64, outer: f64) -> Vec<u8> {
    let (around, rings) = (360u32, 10u32);
    let mut text = String::new();
    for (k, i) in (0..=rings).flat_map(|k| (0..around).map(move |i| (k, i))) {
        let r = inner + (outer - inner) * f64::from(k) / f64::from(rings);
        let turn = TAU * f64::from(i) / f64::from(around);
        writeln!(text, "v {} {} 0", r * cos(turn), r * sin(turn)).unwrap();
    }
    for (k, i) in (0..rings).flat_map(|k| (0..around).map(move |i| (k, i))) {
        let (a, b) = (1 + k * around + i, 1 + k * around + (i + 1) % around);
        writeln!(text, "f {a} {} {} {b}", a + around, b + around).unwrap();
    }
    text.into_bytes()
}

/// What stays beside straight walls: of the area within `R` of a wall, that farther than `c` from where the axis may be.
/// Corners of the room turn by a right angle, out of it (`convex`) or into it (`reflex`).
fn rest_of_polygon(length: f64, convex: f64, reflex: f64, cutter: &Cutter) -> f64 {
    let (r, c) = (cutter.radius, cutter.covers());
    // Where the axis may not be, and how long the border of where it may be is.
    let kept_out = length * r - convex * r * r + reflex * 0.25 * PI * r * r;
    let border = length - convex * 2.0 * r + reflex * FRAC_PI_2 * r;
    kept_out - border * c - convex * 0.25 * PI * c * c + reflex * 0.25 * PI * c * c
}

fn check_rest(name: &str, cutter: &Cutter, file: &[u8], expected: f64) {
    let name = format!("{name} {}", cutter.kind);
    let figures = kept(&name, &cutter.job(FILE, OFF), Some(file));
    let rest = figures.report.verification.as_ref().unwrap().rest_mm2;
    // Where nothing stays, hundredths of what a straight wall keeps a ball from would be much.
    let allowed = 0.01 * expected.max(10.0);
    assert!((rest - expected).abs() <= allowed, "{name}: {rest} mm², expected {expected}");
}

#[test]
fn the_rest_beside_walls_of_a_square_is_as_large_as_it_must_be() {
    for cutter in &CUTTERS {
        let expected = rest_of_polygon(128.0, 4.0, 0.0, cutter);
        check_rest("square", cutter, &plate((16, 16), |_, _| true), expected);
    }
}

#[test]
fn the_rest_beside_walls_of_an_l_is_as_large_as_it_must_be() {
    for cutter in &CUTTERS {
        let expected = rest_of_polygon(144.0, 5.0, 1.0, cutter);
        check_rest("L", cutter, &plate((18, 18), |i, j| i < 8 || j < 8), expected);
    }
}

#[test]
fn the_rest_beside_walls_of_an_annulus_is_as_large_as_it_must_be() {
    let (inner, outer) = (8.0, 22.0);
    for cutter in &CUTTERS {
        let ring = |a: f64, b: f64| PI * (b * b - a * a);
        let lacks = cutter.radius - cutter.covers();
        let expected = ring(inner, inner + lacks) + ring(outer - lacks, outer);
        check_rest("annulus", cutter, &annulus(inner, outer), expected);
    }
}

/// The cutter's centre is beside its contact on slopes, and so is its flat bottom.
#[test]
fn no_cutter_enters_the_walls_of_a_saddle() {
    let saddle = "[surface.analytic]\nkind = \"saddle\"\nsize = 36.0\nheight = 3.0";
    let flat = |radius| Cutter { radius, strips: "stepover = 1.5", ..CUTTERS[0] };
    let bull = Cutter { corner: 1.0, strips: "stepover = 1.5", ..CUTTERS[1] };
    let ball = Cutter { radius: 5.0, corner: 5.0, ..CUTTERS[2] };
    for cutter in [flat(5.0), flat(3.0), bull, ball] {
        let name = format!("saddle {} {}", cutter.kind, 2.0 * cutter.radius);
        let more = if cutter.kind == "flat" { OFF } else { "" };
        kept(&name, &cutter.job(saddle, more), None);
    }
}

/// On five axes walls stand along the surface's normal, and the cutter leans along the pass. What a leaning bull end
/// reaches in a corner depends on the way it faces; a ball leaves the same whatever it does.
#[test]
fn no_leaning_cutter_enters_walls() {
    let bump = "[surface.analytic]\nkind = \"bump\"\nsize = 30.0\nheight = 4.0\nradius = 10.0";
    let cap = "[surface.analytic]\nkind = \"sphere-cap\"\nsize = 30.0\nradius = 40.0";
    let bull = Cutter { strips: "scallop = 0.05\nlead = 8.0", ..CUTTERS[1] };
    let ball = Cutter { strips: "scallop = 0.05\nlead = 15.0", ..CUTTERS[2] };
    for (name, surface) in [("bump", bump), ("cap", cap)] {
        let more = format!("{OFF}[machine]\naxes = \"xyzac\"\n");
        kept(&format!("{name} ball"), &ball.job(surface, &more), None);
        let figures = judgement(&format!("{name} bull"), &bull.job(surface, &more), None);
        let v = figures.report.verification.as_ref().unwrap();
        assert_eq!(v.rapids_in_stock, 0, "{name}");
    }
}

/// The floor of a pocket in a block: its walls are faces of the part. `draft`: by how much they lean outward over their
/// height of 12 mm.
fn pocket(draft: f64) -> Vec<u8> {
    let mut text = String::new();
    let rectangle = |text: &mut String, half: (f64, f64), z: f64| {
        for (x, y) in [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)] {
            writeln!(text, "v {} {} {z}", x * half.0, y * half.1).unwrap();
        }
    };
    rectangle(&mut text, (20.0, 15.0), 0.0);
    rectangle(&mut text, (20.0 + draft, 15.0 + draft), 12.0);
    rectangle(&mut text, (30.0, 25.0), 12.0);
    rectangle(&mut text, (30.0, 25.0), -10.0);
    text.push_str("f 1 2 3 4\n");
    for (low, up) in [(1, 5), (5, 9)] {
        for i in 0..4 {
            let j = (i + 1) % 4;
            writeln!(text, "f {} {} {} {}", low + i, up + i, up + j, low + j).unwrap();
        }
    }
    for i in 0..4 {
        let j = (i + 1) % 4;
        writeln!(text, "f {} {} {} {}", 9 + i, 13 + i, 13 + j, 9 + j).unwrap();
    }
    text.push_str("f 16 15 14 13\n");
    text.into_bytes()
}

#[test]
fn the_walls_of_a_pocket_are_the_part_s_own_faces() {
    let floor = format!(
        "{FILE}\nselect = {{ normal_within = 5.0, box = [[-25.0, -20.0, -1.0], [25.0, 20.0, 1.0]] }}"
    );
    for cutter in &CUTTERS {
        let name = format!("pocket {}", cutter.kind);
        let figures = kept(&name, &cutter.job(&floor, OFF), Some(&pocket(0.0)));
        let rest = figures.report.verification.as_ref().unwrap().rest_mm2;
        let expected = rest_of_polygon(140.0, 4.0, 0.0, cutter);
        assert!((rest - expected).abs() <= 0.01 * expected.max(10.0), "{name}: {rest} {expected}");
        kept(&format!("{name}, draft"), &cutter.job(&floor, OFF), Some(&pocket(1.0)));
    }
}

#[test]
fn a_cutter_too_wide_for_the_room_is_refused_with_what_fits() {
    let wide = Cutter { radius: 14.0, ..CUTTERS[0] };
    let plate = plate((25, 10), |_, _| true);
    let error =
        plan(&wide.job(FILE, OFF), Files::of_surface(Some(&plate)), 2, &mut |_, _| {}).unwrap_err();
    let message = error.to_string();
    assert!(message.contains("does not fit between the walls"), "{message}");
    assert!(message.contains("room for"), "{message}");
}
