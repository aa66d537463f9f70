//! `cargo xtask texture`: writes the table of docs/texture.md, the texture of two tilts on eight surfaces, and its picture
//! of the shipped job.

use std::fmt::Write;
use std::path::Path;
use std::process::Command;

use evencut_core::geometry::{DVec2, DVec3};
use evencut_core::nurbs::{NurbsSurface, read_json};
use serde_json::{Value, json};

use crate::surfaces::franke;
use crate::surfaces::revolved;
use crate::test::{cargo, native, run, target_folder};

const PATH: &str = "docs/texture.md";
const PICTURE: &str = "docs/texture-tilts.svg";
const START: &str = "<!-- table -->\n";
const END: &str = "<!-- end of table -->\n";
/// Half the side of a piece that is machined, mm.
const HALF: f64 = 5.0;
const JOB: &str = "\
version = 1
surface.file = \"surface.json\"
tool = { kind = \"ball\", diameter = 10.0, flutes = 2, helix = 30.0 }
cut = { stepover = 0.5, tolerance = 0.001, axial_depth = 0.2, feed = 1200.0, spindle = 6000.0 }
path.pattern = \"iso-planar\"
force.control = \"off\"
machine.axes = \"xyzac\"
texture.at = [0, 0, 0]
";

/// Simulates the shipped job and all surfaces, and writes picture and table.
pub fn texture(project: &Path) -> Result<(), String> {
    run(cargo(project).args(["build", "--release", "--package", "evencut-cli"]))?;
    println!("{PICTURE}");
    let picture = compared(project, &project.join("jobs/texture.toml"), "--svg")?;
    let path = project.join(PICTURE);
    std::fs::write(&path, picture).map_err(|e| format!("{}: {e}", path.display()))?;
    let mut table = String::from(
        "| surface | tilt | Sa | Sq | Sz | Ssk | Sku | Ra along | Rz along | Ra across | Rz across | tests a node |\n\
         |---|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|\n",
    );
    for (name, surface) in surfaces(project)? {
        println!("{name}");
        table += &rows(project, name, &surface)?;
    }
    let path = project.join(PATH);
    let page = std::fs::read_to_string(&path).map_err(|e| format!("{}: {e}", path.display()))?;
    let parts = page.split_once(START).zip(page.split_once(END));
    let Some(((before, _), (_, after))) = parts else {
        return Err(format!("{PATH} has no place for the table"));
    };
    std::fs::write(&path, format!("{before}{START}{table}{END}{after}"))
        .map_err(|e| format!("{}: {e}", path.display()))
}

/// The surfaces; those of other people only where they are.
fn surfaces(project: &Path) -> Result<Vec<(&'static str, Value)>, String> {
    let flat = [0, 0, 1, 1];
    let corner = |x: f64, y: f64| [HALF * x, HALF * y, 0.0];
    let plane = json!({
        "degree_u": 1, "degree_v": 1, "knots_u": flat, "knots_v": flat,
        "control_points": [[corner(-1.0, -1.0), corner(-1.0, 1.0)], [corner(1.0, -1.0), corner(1.0, 1.0)]],
    });
    let sphere = |is_concave| revolved::patch(0.0, 40.0, [0.15; 2], is_concave);
    let own = |path: &str| file(&project.join(path));
    let mut all = vec![
        ("plane", plane),
        ("sphere cap, R 40", sphere(false)),
        ("its concave twin", sphere(true)),
        ("torus patch, R 80 and 30", revolved::patch(50.0, 30.0, [0.1, 0.2], false)),
        ("trisector patch", piece(&own("docs/regions-tensor/trisector.json")?, 1.0)?),
        ("Franke's function", piece(&franke::spline(), 1.0)?),
    ];
    let shared = project.join("../shared/data/nurbs");
    if shared.is_dir() {
        for (name, path, scale) in [
            ("teapot, patch 12", "teapot_patch12.json", 20.0),
            ("blade", "hecc_main_blade.json", 1.0),
        ] {
            all.push((name, piece(&file(&shared.join(path))?, scale)?));
        }
    } else {
        println!("skipped: teapot and blade, since there is no ../shared/data");
    }
    Ok(all)
}

fn file(path: &Path) -> Result<Value, String> {
    let bytes = std::fs::read(path).map_err(|e| format!("{}: {e}", path.display()))?;
    serde_json::from_slice(&bytes).map_err(|e| format!("{}: {e}", path.display()))
}

/// The piece about the middle of a surface's parameters, turned so that it is level there, at the origin.
fn piece(surface: &Value, scale: f64) -> Result<Value, String> {
    let nurbs: NurbsSurface =
        read_json(&revolved::file(surface)).map_err(|error| error.to_string())?.surface;
    let (low, high) = nurbs.domain();
    let middle = 0.5 * (low + high);
    let (at, normal) = (nurbs.point(middle), nurbs.normal(middle));
    let step = 1e-4 * (high - low);
    let along = |d: DVec2| (nurbs.point(middle + d) - at) * scale;
    // Parameters that make a length of HALF.
    let reach = |d: DVec2| d * (HALF / along(d).length());
    let (u, v) = (reach(DVec2::new(step.x, 0.0)), reach(DVec2::new(0.0, step.y)));
    let x = along(DVec2::new(step.x, 0.0)).normalize();
    let y = normal.cross(x);
    let placed = |p: &Value| {
        let number = |i: usize| p[i].as_f64().unwrap_or_default();
        let d = (DVec3::new(number(0), number(1), number(2)) - at) * scale;
        let mut out = vec![d.dot(x), d.dot(y), d.dot(normal)];
        out.extend(p[3].as_f64());
        json!(out)
    };
    let mut piece = surface.clone();
    let rows = piece["control_points"].as_array_mut().into_iter().flatten();
    for point in rows.flat_map(|row| row.as_array_mut().into_iter().flatten()) {
        *point = placed(point);
    }
    let from = (middle - u - v).max(low);
    let to = (middle + u + v).min(high);
    piece["trim_domain"] = json!([from.x, to.x, from.y, to.y]);
    Ok(piece)
}

/// A job at two tilts, in one of the ways in which `evencut compare` tells them.
fn compared(project: &Path, job: &Path, kind: &str) -> Result<Vec<u8>, String> {
    let mut command = Command::new(native(project, "release"));
    command.arg("compare").arg(job).args(["--tilts", "0,15", kind]);
    let output = command.output().map_err(|e| format!("{command:?}: {e}"))?;
    match output.status.success() {
        true => Ok(output.stdout),
        false => Err(String::from_utf8_lossy(&output.stderr).into_owned()),
    }
}

/// The rows of a surface.
fn rows(project: &Path, name: &str, surface: &Value) -> Result<String, String> {
    let folder = target_folder(project).join("texture");
    let write = |name: &str, bytes: &[u8]| {
        let path = folder.join(name);
        std::fs::write(&path, bytes).map_err(|e| format!("{}: {e}", path.display()))
    };
    std::fs::create_dir_all(&folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    write("surface.json", &revolved::file(surface))?;
    write("job.toml", JOB.as_bytes())?;
    let stem: String = name.chars().filter(|c| c.is_ascii_alphanumeric()).collect();
    let job = folder.join("job.toml");
    let compared =
        |kind: &str| compared(project, &job, kind).map_err(|error| format!("{name}: {error}"));
    write(&format!("{stem}.svg"), &compared("--svg")?)?;
    let csv = String::from_utf8_lossy(&compared("--csv")?).into_owned();
    let mut lines = csv.lines();
    let header: Vec<&str> = lines.next().unwrap_or_default().split(',').collect();
    let columns = [
        "sa_um",
        "sq_um",
        "sz_um",
        "ssk",
        "sku",
        "ra_along_um",
        "rz_along_um",
        "ra_across_um",
        "rz_across_um",
        "tests_per_node",
    ];
    let mut out = String::new();
    for line in lines {
        let field = |name: &str| {
            let at = header.iter().position(|h| *h == name);
            at.and_then(|i| line.split(',').nth(i)).and_then(|text| text.parse::<f64>().ok())
        };
        let tilt = field("tilt_deg").unwrap_or_default();
        // Writing to a string cannot fail.
        let _ = write!(out, "| {name} | {tilt:.0}° |");
        for column in columns {
            let digits = if column == "tests_per_node" { 1 } else { 3 };
            let shown = field(column).map_or_else(String::new, |value| format!("{value:.digits$}"));
            let _ = write!(out, " {shown} |");
        }
        out.push('\n');
    }
    Ok(out)
}
