//! Jobs drawn at random.

use crate::part::Mesh;
use crate::random::Random;
use evencut_core::job;
use evencut_core::plan::Files;
use evencut_service::verdict::Workpiece;
use std::fmt::Write;
use std::path::Path;

/// Surfaces by formula.
const KINDS: [&str; 7] =
    ["plane", "sphere-cap", "cylinder", "torus-patch", "saddle", "monkey-saddle", "bump"];
/// Real surfaces: file and largest extent in its own unit.
const FILES: [(&str, f64); 22] = [
    ("mesh/botanic_garden.off", 31.0),
    ("mesh/capsule_2holes.off", 1.9),
    ("mesh/carpet_110.stl", 152.0),
    ("mesh/train_station.off", 113.0),
    ("mesh/hemisphere.obj", 0.95),
    ("mesh/hecc_hub_passage_coarse.obj", 211.0),
    ("mesh/hecc_hub_passage_splitter_coarse.stl", 211.0),
    ("mesh/lilium.obj", 2.0),
    ("nurbs/surf114_half_coarse.obj", 84.0),
    ("nurbs/kj66_blade_coarse.stl", 40.0),
    ("nurbs/e3_hpt_rotor1_side_coarse.obj", 61.0),
    ("nurbs/wigley_hull_coarse.obj", 2500.0),
    ("nurbs/mainbody_back_face13_coarse.stl", 144.0),
    ("nurbs/teapot_patch04.json", 50.0),
    ("nurbs/teapot_patch12.json", 37.5),
    ("nurbs/teapot_patch16.json", 45.0),
    ("nurbs/surf114_half.json", 84.0),
    ("nurbs/hood_fender.json", 407.0),
    ("nurbs/kj66_hub.json", 100.0),
    ("nurbs/drone_prop_blade.json", 127.0),
    ("nurbs/hecc_hub_sector.json", 190.0),
    ("nurbs/propeller_hub.json", 76.0),
];
/// Side steps on the part's extent, at most: what keeps a plan short.
const MOST_PASSES: f64 = 40.0;
/// Least area that is worth a job, squares of the extent.
const LEAST: f64 = 0.12;

/// A drawn job.
pub struct Drawn {
    /// The job file.
    pub text: String,
    /// What it is, in short.
    pub about: String,
}

/// Two or three digits, as nobody types more.
fn short(x: f64) -> f64 {
    format!("{x:.2e}").parse().unwrap_or(x)
}

/// The job of a seed. `data`: the folder of real surfaces, if there is one.
pub fn drawn(seed: u64, data: Option<&Path>) -> Drawn {
    let mut r = Random::new(seed);
    let five = r.happens(0.4);
    let kind = r.of(&["ball", "ball", "ball", "bull", "bull", "flat"]);
    let diameter = r.of(&[2.0, 3.0, 4.0, 6.0, 8.0, 10.0, 12.0]);
    let corner = match kind {
        "ball" => 0.5 * diameter,
        "bull" => short(diameter * r.between(0.06, 0.42)),
        _ => 0.0,
    };
    let lead = if five { short(r.between(2.0, 20.0)) } else { 0.0 };
    // What decides the side step: the radius across the feed.
    let bent = if kind == "ball" || lead == 0.0 {
        corner
    } else {
        corner + (0.5 * diameter - corner) / evencut_core::geometry::math::sin(lead.to_radians())
    };
    let upright_flat = kind == "flat" && !five;
    let by_scallop = !upright_flat && r.happens(0.75);
    let wide = short((diameter * r.between(3.0, 10.0)).clamp(20.0, 60.0));
    // High enough for a plan that does not last.
    let half = 0.5 * wide / MOST_PASSES;
    let least = half * half / (2.0 * bent.max(0.1));
    let scallop = short(r.between(0.01, 0.1).max(least).min(0.1).min(0.8 * corner.max(0.1)));
    let fixed = short((diameter * r.between(0.06, 0.4)).max(2.0 * half));
    let side_step =
        if by_scallop { (2.0 * (2.0 * scallop * bent).sqrt()).min(diameter) } else { fixed };
    let extent = short(wide.min(MOST_PASSES * side_step));

    let mut text = String::from("version = 1\n");
    let real = data.filter(|_| r.happens(0.5));
    let about = match real {
        Some(data) => real_surface(&mut r, &mut text, data, extent, five),
        None => formula(&mut r, &mut text, extent),
    };
    let _ = writeln!(text, "[tool]\nkind = \"{kind}\"\ndiameter = {diameter:?}");
    if kind == "bull" {
        let _ = writeln!(text, "corner_radius = {corner:?}");
    }
    text.push_str("[cut]\n");
    let _ = match by_scallop {
        true => writeln!(text, "scallop = {scallop:?}"),
        false => writeln!(text, "stepover = {fixed:?}"),
    };
    let _ = writeln!(text, "feed = {:?}", short(r.between(400.0, 3000.0)));
    if r.happens(0.5) {
        let _ = writeln!(text, "tolerance = {:?}", r.of(&[0.002, 0.01, 0.02]));
    }
    if r.happens(0.6) {
        let _ = writeln!(text, "axial_depth = {:?}", short(diameter * r.between(0.03, 0.3)));
    }
    if r.happens(0.25) {
        let _ = writeln!(text, "allowance = {:?}", short(r.between(0.05, 0.5)));
    }
    if five && (kind != "ball" || r.happens(0.7)) {
        let _ = writeln!(text, "lead = {lead:?}");
    }
    if r.happens(0.2) {
        text.push_str("direction = \"conventional\"\n");
    }
    let pattern = path(&mut r, &mut text, diameter, five && kind != "ball");
    text.push_str("[machine]\n");
    let _ = writeln!(text, "axes = \"{}\"", if five { "xyzac" } else { "3" });
    if r.happens(0.1) {
        let half = short(extent * r.between(0.5, 1.5) + diameter);
        let _ = writeln!(
            text,
            "[machine.travel]\nx = [{:?}, {half:?}]\nz = [{:?}, {half:?}]",
            -half, -half
        );
    }
    let about =
        format!("{about} {extent} {kind} {diameter}{} {pattern}", if five { " xyzac" } else { "" });
    Drawn { text, about }
}

fn formula(r: &mut Random, text: &mut String, extent: f64) -> String {
    let kind = r.of(&KINDS);
    let _ = writeln!(text, "[surface.analytic]\nkind = \"{kind}\"\nsize = {extent:?}");
    let sign = if r.happens(0.5) { 1.0 } else { -1.0 };
    let mut number = |key: &str, value: f64| {
        let _ = writeln!(text, "{key} = {:?}", short(value));
    };
    let radius = extent * r.between(0.55, 2.0);
    match kind {
        "sphere-cap" | "cylinder" => number("radius", radius),
        "torus-patch" => {
            number("radius", radius);
            number("tube_radius", radius * r.between(0.4, 0.9));
        }
        "saddle" | "monkey-saddle" => number("height", sign * extent * r.between(0.03, 0.35)),
        "bump" => {
            number("radius", extent * r.between(0.1, 0.4));
            number("height", sign * extent * r.between(0.03, 0.35));
        }
        _ => {}
    }
    if r.happens(0.2) {
        number("resolution", extent / r.between(40.0, 120.0));
    }
    kind.to_owned()
}

/// Turns and selections that are tried for a surface.
const TURNS: usize = 8;

fn real_surface(r: &mut Random, text: &mut String, data: &Path, extent: f64, five: bool) -> String {
    let (file, native) = r.of(&FILES);
    let path = data.join(file);
    let path = path.canonicalize().unwrap_or(path);
    let bytes = std::fs::read(&path).unwrap_or_default();
    let mut turned = String::new();
    for _ in 0..TURNS {
        turned = turned_surface(r, &path, short(extent / native), five);
        let probe = format!(
            "version = 1\n{turned}[tool]\ndiameter = 4.0\n[cut]\nscallop = 0.05\nfeed = 600.0\n\
             tolerance = 0.05\n"
        );
        // Most turns show the tool nothing, or the back.
        let part = job::read(probe.as_bytes()).ok().and_then(|resolved| {
            Workpiece::of_job(&resolved.job, Files::of_surface(Some(&bytes)), 1)
                .ok()
                .map(|(part, _)| part)
        });
        if part.is_some_and(|part| Mesh::new(&part.design).area() > LEAST * extent * extent) {
            break;
        }
    }
    text.push_str(&turned);
    Path::new(file).file_stem().unwrap_or_default().to_string_lossy().into_owned()
}

fn turned_surface(r: &mut Random, path: &Path, scale: f64, five: bool) -> String {
    let mut text =
        format!("[surface]\nfile = {:?}\nscale = {scale:?}\n", path.display().to_string());
    let turns = [r.of(&[0.0, 90.0, 180.0, 270.0]), r.of(&[0.0, 0.0, 90.0, 180.0]), 0.0];
    let tilts = if r.happens(0.5) { [short(r.between(-30.0, 30.0)), 0.0, 0.0] } else { [0.0; 3] };
    let [a, b, c] = [0, 1, 2].map(|k| turns[k] + tilts[k]);
    let _ = writeln!(text, "rotate = [{a:?}, {b:?}, {c:?}]");
    if r.happens(0.3) {
        text.push_str("flip = true\n");
    }
    text.push_str("[surface.select]\ncomponent = \"largest\"\n");
    if !five || r.happens(0.5) {
        let _ = writeln!(text, "normal_within = {:?}", short(r.between(30.0, 80.0)));
    }
    text
}

/// `[path]`, `[regions]` and `[force]`; `lags`: whether the cutter is a leaning flat or bull end.
fn path(r: &mut Random, text: &mut String, diameter: f64, lags: bool) -> String {
    let others =
        ["iso-scallop", "iso-parametric", "iso-planar", "direction-field", "mpf", "spiral"];
    let pattern = if r.happens(0.5) { "contour" } else { r.of(&others) };
    let rings = pattern == "contour" || pattern == "spiral";
    let _ = writeln!(text, "[path]\npattern = \"{pattern}\"");
    let wall = pattern == "contour" && r.happens(0.4);
    if wall {
        text.push_str("boundary = \"wall\"\n");
        if r.happens(0.3) {
            let _ = writeln!(text, "wall_height = {:?}", short(diameter * r.between(0.1, 3.0)));
        }
    } else if r.happens(0.3) {
        let first = if rings { "half-strip" } else { "edge" };
        let _ = writeln!(text, "first = \"{first}\"");
    }
    if r.happens(0.2) {
        text.push_str("links = \"retract\"\n");
    }
    if r.happens(0.25) {
        text.push_str("entry_radius = 1.5\n");
    }
    if rings && r.happens(0.25) {
        text.push_str("order = \"inside-out\"\n");
    }
    if !rings && r.happens(0.2) {
        text.push_str("traverse = \"one-way\"\n");
    }
    match pattern {
        "iso-scallop" if r.happens(0.5) => {
            let _ = writeln!(text, "start = \"{}\"", r.of(&["widest", "boundary"]));
        }
        "iso-parametric" if r.happens(0.5) => {
            let _ = writeln!(text, "along = \"{}\"", r.of(&["u", "v"]));
        }
        "iso-planar" if r.happens(0.5) => {
            let _ = writeln!(text, "angle = {:?}", short(r.between(-180.0, 180.0)));
        }
        _ => {}
    }
    let mut about = format!("{pattern}{}", if wall { " wall" } else { "" });
    if !wall && pattern != "mpf" && r.happens(0.15) {
        let method = r.of(&["distortion", "tensor"]);
        let _ = writeln!(text, "[regions]\nmethod = \"{method}\"");
        let _ = write!(about, " {method}");
    }
    let control = match pattern {
        "contour" => r.of(&["off", "feed", "trochoid", "fastest"]),
        "spiral" => r.of(&["off", "off", "feed"]),
        _ if lags => r.of(&["off", "off", "feed"]),
        _ => r.of(&["off", "feed", "trochoid", "fastest"]),
    };
    let _ = writeln!(text, "[force]\ncontrol = \"{control}\"");
    if control != "off" {
        let _ = writeln!(text, "relative = {:?}", short(r.between(0.8, 2.0)));
        let _ = write!(about, " {control}");
    }
    about
}
