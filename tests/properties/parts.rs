//! Whole parts: the planner takes closed solids with walls, pockets and undersides as they are, and what it plans on
//! the surface that the cutter reaches keeps its limits on the solid itself.

use core::f64::consts::TAU;
use std::fmt::Write;

use evencut_core::geometry::{DVec3, math};
use evencut_core::job::{self, Job};
use evencut_core::plan::{Files, Planned, plan};
use evencut_core::toolpath::MoveKind;
use evencut_service::compare::{Figures, judged};
use evencut_service::new_job::contents;
use evencut_tests::shared_data;

/// Tolerance of the jobs, mm.
const TOLERANCE: f64 = 0.01;
/// Slope up to which they machine, degrees.
const STEEPEST: f64 = 80.0;
/// Half the side of the block's pocket, half the side of the block, depth of the pocket, and of the block, mm.
const POCKET: [f64; 4] = [6.0, 10.0, 3.0, 6.0];

/// A job on a file of that name.
fn job(kind: &str, diameter: f64, surface: &str, path: &str) -> Job {
    let strips = if kind == "flat" { "stepover = 3.0" } else { "scallop = 0.03" };
    let text = format!(
        "version = 1\n[surface]\n{surface}\nsteepest = {STEEPEST}\n[tool]\nkind = \"{kind}\"\n\
         diameter = {diameter}\n[cut]\n{strips}\naxial_depth = 0.3\nfeed = 1200.0\n\
         tolerance = {TOLERANCE}\n[path]\n{path}\n[force]\ncontrol = \"off\"\n"
    );
    match job::read(text.as_bytes()) {
        Ok(resolved) => resolved.job,
        Err(faults) => panic!("{}", faults.render("parts", text.as_bytes())),
    }
}

fn kept(name: &str, job: &Job, file: &[u8]) -> (Planned, Figures) {
    let planned = plan(job, Files::of_surface(Some(file)), 2, &mut |_, _| {})
        .unwrap_or_else(|error| panic!("{name}: {error}"));
    let figures = judged(job, &planned, 2).unwrap_or_else(|error| panic!("{name}: {error}"));
    let v = figures.report.verification.as_ref().unwrap();
    assert!(v.passed, "{name}: {:?}", v.broken);
    (planned, figures)
}

/// A block with its top at z = 0, as OBJ; with a square pocket in its middle.
fn block(has_pocket: bool) -> Vec<u8> {
    let [inner, outer, depth, height] = POCKET;
    let square = |half: f64, z: f64| {
        [(-half, -half), (half, -half), (half, half), (-half, half)].map(|(x, y)| [x, y, z])
    };
    let mut corners = [square(outer, -height), square(outer, 0.0)].concat();
    let mut bands = vec![(0, 4)];
    let mut faces: Vec<[u32; 3]> = vec![[0, 2, 1], [0, 3, 2]];
    if has_pocket {
        corners.extend([square(inner, 0.0), square(inner, -depth)].concat());
        bands.extend([(4, 8), (8, 12)]);
        faces.extend([[12, 13, 14], [12, 14, 15]]);
    } else {
        faces.extend([[4, 5, 6], [4, 6, 7]]);
    }
    for (a, b) in bands {
        for (i, j) in [(0, 1), (1, 2), (2, 3), (3, 0)] {
            faces.extend([[a + i, a + j, b + j], [a + i, b + j, b + i]]);
        }
    }
    let mut text = String::new();
    for [x, y, z] in corners {
        writeln!(text, "v {x} {y} {z}").unwrap();
    }
    for face in faces {
        let [a, b, c] = face.map(|v| v + 1);
        writeln!(text, "f {a} {b} {c}").unwrap();
    }
    text.into_bytes()
}

/// The solid of the block with its pocket as boxes: floor and four sides.
fn boxes() -> [(DVec3, DVec3); 5] {
    let [inner, outer, depth, height] = POCKET;
    let of = |x: [f64; 2], y: [f64; 2], top: f64| {
        (DVec3::new(x[0], y[0], -height), DVec3::new(x[1], y[1], top))
    };
    let all = [-outer, outer];
    [
        of(all, all, -depth),
        of([-outer, -inner], all, 0.0),
        of([inner, outer], all, 0.0),
        of(all, [-outer, -inner], 0.0),
        of(all, [inner, outer], 0.0),
    ]
}

/// How deep a ball with its shank is in a solid, mm, by distances from boxes.
fn depth_in(tip: DVec3, radius: f64, boxes: &[(DVec3, DVec3)]) -> f64 {
    let centre = tip + DVec3::Z * radius;
    let distance = |(low, high): &(DVec3, DVec3)| {
        // Above the centre the cutter is a cylinder.
        let low = DVec3::new(low.x, low.y, f64::NEG_INFINITY);
        centre.distance(centre.clamp(low, *high))
    };
    radius - boxes.iter().map(distance).fold(f64::INFINITY, f64::min)
}

/// The path stays out of the exact solid, and is judged to keep its limits on all that it is to machine.
#[test]
fn a_block_with_a_pocket_is_machined_as_it_is() {
    let (radius, [inner, outer, depth, _]) = (1.5, POCKET);
    let job = job("ball", 2.0 * radius, "file = \"block.obj\"", "pattern = \"contour\"");
    let (planned, figures) = kept("pocket", &job, &block(true));
    assert_eq!(planned.prepared.pieces, 2, "land and floor");
    let boxes = boxes();
    let mut deepest = (f64::NEG_INFINITY, DVec3::ZERO);
    for pair in planned.toolpath.points.windows(2) {
        for k in 1..=8 {
            let tip = pair[0].tip.lerp(pair[1].tip, f64::from(k) / 8.0);
            let depth = depth_in(tip, radius, &boxes);
            if depth > deepest.0 {
                deepest = (depth, tip);
            }
        }
    }
    assert!(deepest.0 <= TOLERANCE, "{deepest:?}");
    // It comes down to the floor, no deeper.
    let lowest = planned.toolpath.points.iter().map(|p| p.tip.z).fold(f64::INFINITY, f64::min);
    assert!((lowest + depth).abs() <= TOLERANCE, "{lowest}");
    let aside = planned.prepared.aside.as_ref().unwrap();
    // Land and floor, fillets of the ball along the walls up to the steepest slope.
    let (land, floor) = (4.0 * (outer * outer - inner * inner), 4.0 * (inner - radius).powi(2));
    let fillets = 8.0 * (inner - radius) * radius * f64::to_radians(STEEPEST);
    let area = figures.report.surface.area_mm2;
    let corners = 4.0 * radius * radius * 2.0;
    assert!((area - land - floor - fillets).abs() < corners + 2.0, "{area}");
    let away = 4.0 * outer * outer + 8.0 * outer * POCKET[3] + 8.0 * inner * depth;
    assert!((aside.away - away).abs() < 1e-6, "{aside:?}");
    assert!(planned.toolpath.points.iter().any(|p| p.kind == MoveKind::Rapid));
}

/// A plate with a square boss on it, its corners on the axes, as OBJ: a ball rolls around its upright edges.
fn boss() -> Vec<u8> {
    let corners = |half: f64, z: f64| {
        [(-half, 0.0), (0.0, -half), (half, 0.0), (0.0, half)].map(|(x, y)| [x, y, z])
    };
    let plate = [(-12.0, -12.0), (12.0, -12.0), (12.0, 12.0), (-12.0, 12.0)];
    let plate = plate.map(|(x, y)| [x, y, 0.0]);
    let mut text = String::new();
    for [x, y, z] in [plate, corners(6.0, 0.0), corners(6.0, 5.0)].concat() {
        writeln!(text, "v {x} {y} {z}").unwrap();
    }
    text.push_str("f 9 10 11\nf 9 11 12\n");
    for (a, b) in [(1, 5), (5, 9)] {
        for (i, j) in [(0, 1), (1, 2), (2, 3), (3, 0)] {
            writeln!(text, "f {} {} {}\nf {} {} {}", a + i, a + j, b + j, a + i, b + j, b + i)
                .unwrap();
        }
    }
    text.into_bytes()
}

#[test]
fn around_a_boss_nothing_is_inaccessible() {
    let job = job("ball", 6.0, "file = \"boss.obj\"", "pattern = \"contour\"");
    let (planned, figures) = kept("boss", &job, &boss());
    assert!(planned.coverage.inaccessible_places.is_empty());
    let v = figures.report.verification.as_ref().unwrap();
    assert_eq!((v.inaccessible_mm2, v.rest_mm2), (0.0, 0.0));
}

/// The cutter reaches the top of the boss and the plate around it: two pieces, which are regions, and may be divided further.
#[test]
fn pieces_of_a_part_are_divided() {
    let mpf = "pattern = \"mpf\"";
    let even = "pattern = \"contour\"\n[regions]\nmethod = \"distortion\"";
    let tensor = "pattern = \"iso-scallop\"\n[regions]\nmethod = \"tensor\"";
    for path in [mpf, even, tensor] {
        let (planned, _) = kept(path, &job("ball", 4.0, "file = \"boss.obj\"", path), &boss());
        let count = planned.passes.divided.map_or(1, |divided| divided.parts.len());
        assert!(count >= 2, "{path}: {count}");
    }
    // In what is left between bands no curve along the widest strips may be long enough to cross a face.
    kept("bored boss", &job("ball", 4.0, "file = \"boss.obj\"", mpf), &bored_boss());
    kept("block", &job("ball", 4.0, "file = \"block.obj\"", mpf), &block(true));
}

#[test]
fn a_closed_block_is_faced_by_a_flat_end() {
    let job = job("flat", 6.0, "file = \"block.obj\"", "pattern = \"iso-planar\"");
    let (planned, figures) = kept("block", &job, &block(false));
    let outer = POCKET[1];
    assert!((figures.report.surface.area_mm2 - 4.0 * outer * outer).abs() < 0.5);
    assert!(planned.toolpath.points.iter().all(|p| p.tip.z > -TOLERANCE));
}

/// On a level plane the whole bottom of a bull end cuts: passes are farther apart by that than a ball of its corner's radius
/// would need.
#[test]
fn a_bull_end_faces_a_block_with_its_bottom() {
    let bull = "bull\"\ncorner_radius = 1.0 # \"";
    let job = job(bull, 6.0, "file = \"block.obj\"", "pattern = \"contour\"");
    let (planned, _) = kept("block", &job, &block(false));
    let moves = planned.toolpath.points.windows(2).filter(|w| w[1].kind == MoveKind::Cut);
    let length: f64 = moves.map(|w| w[0].tip.distance(w[1].tip)).sum();
    let (area, corner_step) = (4.0 * POCKET[1] * POCKET[1], 2.0 * (0.03f64 * (2.0 - 0.03)).sqrt());
    assert!(length < 0.5 * area / corner_step, "{length}");
}

/// A block of six plane faces that share nothing, as STEP, its top at z = 0 and its side twice `half` mm.
fn step_block(half: f64, height: f64) -> Vec<u8> {
    let mut lines = vec!["#1=(LENGTH_UNIT()NAMED_UNIT(*)SI_UNIT(.MILLI.,.METRE.))".to_owned()];
    lines.push("#2=(GEOMETRIC_REPRESENTATION_CONTEXT(3)GLOBAL_UNIT_ASSIGNED_CONTEXT((#1)))".into());
    let mut add = |text: String| {
        lines.push(format!("#{}={text}", lines.len() + 1));
        lines.len()
    };
    let triple = |v: DVec3| format!("({:?},{:?},{:?})", v.x, v.y, v.z);
    let middle = DVec3::new(0.0, 0.0, -0.5 * height);
    let size = DVec3::new(half, half, 0.5 * height);
    let mut faces = Vec::new();
    for (normal, u) in [
        (DVec3::X, DVec3::Y),
        (DVec3::NEG_X, DVec3::NEG_Y),
        (DVec3::Y, DVec3::NEG_X),
        (DVec3::NEG_Y, DVec3::X),
        (DVec3::Z, DVec3::X),
        (DVec3::NEG_Z, DVec3::NEG_X),
    ] {
        let v = normal.cross(u);
        let corner = |a: f64, b: f64| middle + (normal + u * a + v * b) * size;
        let corners = [corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)];
        let points = corners.map(|p| add(format!("CARTESIAN_POINT('',{})", triple(p))));
        let vertices = points.map(|p| add(format!("VERTEX_POINT('',#{p})")));
        let mut edges = Vec::new();
        for i in 0..4 {
            let (from, to) = (corners[i], corners[(i + 1) % 4]);
            let way = add(format!("DIRECTION('',{})", triple((to - from).normalize())));
            let vector = add(format!("VECTOR('',#{way},1.0)"));
            let line = add(format!("LINE('',#{},#{vector})", points[i]));
            let [a, b] = [vertices[i], vertices[(i + 1) % 4]];
            let edge = add(format!("EDGE_CURVE('',#{a},#{b},#{line},.T.)"));
            edges.push(format!("#{}", add(format!("ORIENTED_EDGE('',*,*,#{edge},.T.)"))));
        }
        let outline = add(format!("EDGE_LOOP('',({}))", edges.join(",")));
        let bound = add(format!("FACE_OUTER_BOUND('',#{outline},.T.)"));
        let [z, x] = [normal, u].map(|d| add(format!("DIRECTION('',{})", triple(d))));
        let frame = add(format!("AXIS2_PLACEMENT_3D('',#{},#{z},#{x})", points[0]));
        let plane = add(format!("PLANE('',#{frame})"));
        faces.push(format!("#{}", add(format!("ADVANCED_FACE('',(#{bound}),#{plane},.T.)"))));
    }
    add(format!("CLOSED_SHELL('',({}))", faces.join(",")));
    let text = lines.join(";\n");
    format!(
        "ISO-10303-21;\nHEADER;\nFILE_DESCRIPTION((''),'2;1');\nFILE_NAME('','',(''),(''),'','','');\n\
         FILE_SCHEMA(('AUTOMOTIVE_DESIGN'));\nENDSEC;\nDATA;\n{text};\nENDSEC;\nEND-ISO-10303-21;\n"
    )
    .into_bytes()
}

#[test]
fn all_or_several_faces_of_a_step_body_are_machined() {
    let half = POCKET[1];
    let file = step_block(half, POCKET[3]);
    let top = 4.0 * half * half;
    // Its top, and one of its sides with it, is what three axes reach.
    for faces in ["\"all\"", "[1, 5]", "[5]"] {
        let surface = format!("file = \"block.step\"\nface = {faces}");
        let job = job("flat", 6.0, &surface, "pattern = \"iso-planar\"");
        let (planned, figures) = kept(faces, &job, &file);
        assert!((figures.report.surface.area_mm2 - top).abs() < 0.5, "{faces}");
        assert!(planned.toolpath.points.iter().all(|p| p.tip.z > -TOLERANCE), "{faces}");
        let selected = figures.report.surface.set_aside.as_ref().unwrap().selected_mm2;
        let side = 2.0 * half * POCKET[3];
        let asked = match faces {
            "\"all\"" => 2.0 * top + 4.0 * side,
            "[5]" => top,
            _ => top + side,
        };
        assert!((selected - asked).abs() < 1e-6, "{faces}: {selected} of {asked}");
    }
}

#[test]
fn several_faces_need_a_steepest_slope() {
    let text = "version = 1\n[surface]\nfile = \"a.step\"\nface = \"all\"\n[tool]\ndiameter = 6.0\n\
                [cut]\nscallop = 0.02\nfeed = 900.0\n";
    let faults = job::read(text.as_bytes()).unwrap_err().render("job.toml", text.as_bytes());
    assert!(faults.contains("job.toml:4") && faults.contains("steepest = 80.0"), "{faults}");
    for none in ["[]", "0", "\"some\"", "[0]"] {
        let text = text.replace("\"all\"", none);
        assert!(job::read(text.as_bytes()).is_err(), "{none}");
    }
}

/// Real files that cannot be machined as they are from above: half a ball up to its vertical rim, and one with a fin.
#[test]
fn closed_and_folded_real_meshes_are_planned_from_above() {
    let Some(data) = shared_data() else { return };
    for (file, scale, diameter) in
        [("mesh/hemisphere.obj", 25.0, 6.0), ("nasty/hemi_fin.obj", 0.5, 6.0)]
    {
        let bytes = std::fs::read(data.join(file)).unwrap();
        let surface = format!("file = \"{file}\"\nscale = {scale}");
        let job = job("ball", diameter, &surface, "pattern = \"contour\"");
        let (planned, _) = kept(file, &job, &bytes);
        assert!(planned.prepared.aside.is_some());
    }
}

/// Where the outline of what is reached turns sharply, triangles beside it may lie one over another: the part is planned all the
/// same, as `evencut new` proposes.
#[test]
fn a_real_part_with_many_holes_is_planned() {
    let file = "mesh/plane_26holes.obj";
    let Some(data) = shared_data() else { return };
    let bytes = std::fs::read(data.join(file)).unwrap();
    let contents = contents(file, &bytes, 1.0).unwrap();
    let job = job::read(contents.job(file).as_bytes()).unwrap().job;
    kept(file, &job, &bytes);
}

/// A scan of 16 x 12 mm as OBJ: places half a millimetre apart, moved aside by up to 0.2 mm, so that some faces fold
/// over, and up or down by up to 8 µm.
fn scan(seed: u64) -> (Vec<u8>, usize) {
    let mut state = seed;
    let mut random = || {
        state =
            state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 40) as f64 / f64::from(1 << 23) - 1.0
    };
    let (columns, rows) = (33, 25);
    let is_rim = |k: usize, count: usize| k == 0 || k + 1 == count;
    let mut places = Vec::new();
    for i in 0..columns {
        for j in 0..rows {
            let aside = if is_rim(i, columns) || is_rim(j, rows) { 0.0 } else { 0.2 };
            let x = 0.5 * i as f64 + aside * random();
            let y = 0.5 * j as f64 + aside * random();
            let bump = 0.02 * ((x - 8.0) * (x - 8.0) - (y - 6.0) * (y - 6.0));
            places.push([x, y, bump + 0.008 * random()]);
        }
    }
    let faces = faces_of(columns, rows);
    let area = |[a, b, c]: &[usize; 3]| {
        let [a, b, c] = [*a, *b, *c].map(|v| places[v]);
        (b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1])
    };
    let folded = faces.iter().filter(|face| area(face) < 0.0).count();
    (obj(&places, &faces), folded)
}

/// Two triangles between any four neighbours of columns of places.
fn faces_of(columns: usize, rows: usize) -> Vec<[usize; 3]> {
    let squares = (0..columns - 1).flat_map(|i| (0..rows - 1).map(move |j| (i, j)));
    let two = |(i, j): (usize, usize)| {
        let (a, b) = (i * rows + j, (i + 1) * rows + j);
        [[a, b, b + 1], [a, b + 1, a + 1]]
    };
    squares.flat_map(two).collect()
}

fn obj(places: &[[f64; 3]], faces: &[[usize; 3]]) -> Vec<u8> {
    let mut text = String::new();
    places.iter().for_each(|[x, y, z]| writeln!(text, "v {x} {y} {z}").unwrap());
    for face in faces {
        let [a, b, c] = face.map(|v| v + 1);
        writeln!(text, "f {a} {b} {c}").unwrap();
    }
    text.into_bytes()
}

/// A block with a square pocket, a round boss in it and a bore through both: outlines one above or inside the other, of
/// 128 corners each.
fn bored_boss() -> Vec<u8> {
    const CORNERS: usize = 128;
    let square = |half: f64| (half, true);
    let circle = |radius: f64| (radius, false);
    let outlines = [
        (circle(7.0), 0.0),
        (square(50.0), 0.0),
        (square(50.0), 30.0),
        (square(35.0), 30.0),
        (square(35.0), 15.0),
        (circle(15.0), 15.0),
        (circle(15.0), 29.0),
        (circle(7.0), 29.0),
    ];
    let mut places = Vec::new();
    for ((size, is_square), z) in outlines {
        for k in 0..CORNERS {
            let turn = TAU * k as f64 / CORNERS as f64;
            let (x, y) = (math::cos(turn), math::sin(turn));
            let out = if is_square { size / x.abs().max(y.abs()) } else { size };
            places.push([out * x, out * y, z]);
        }
    }
    let mut faces = Vec::new();
    for (k, i) in (0..outlines.len()).flat_map(|k| (0..CORNERS).map(move |i| (k, i))) {
        let at = |k: usize, i: usize| k % outlines.len() * CORNERS + i % CORNERS;
        let [a, b, c, d] = [at(k, i), at(k, i + 1), at(k + 1, i + 1), at(k + 1, i)];
        faces.extend([[a, b, c], [a, c, d]]);
    }
    obj(&places, &faces)
}

/// Beside sharp rims cusps stand on strips narrower than those at which the planner looks elsewhere.
#[test]
fn rims_of_a_pocket_and_a_boss_keep_a_small_limit() {
    let text = "version = 1\n[surface]\nfile = \"boss.obj\"\nsteepest = 80.0\n[tool]\ndiameter = 10.0\n[cut]\n\
                scallop = 0.01\naxial_depth = 0.2\nfeed = 900.0\ntolerance = 0.005\n[force]\ncontrol = \"off\"\n";
    let job = job::read(text.as_bytes()).unwrap().job;
    kept("bored boss", &job, &bored_boss());
}

/// Noise makes valleys that no cutter fits into, and folds a few faces over; the job that is written for such a scan keeps
/// its limits all the same, whatever the noise.
#[test]
fn scans_with_noise_and_folded_faces_keep_their_limits() {
    let mut folded = 0;
    for seed in 1..=4 {
        let (file, turned) = scan(seed);
        folded += turned;
        let contents = contents("scan.obj", &file, 1.0).unwrap();
        let asked = "scallop = 0.01\ntolerance = 0.005\ndiameter = 3.0\n";
        let key = |line: &str| line.split(" =").next().unwrap().to_owned();
        let line = |line: &str| match asked.lines().find(|asked| key(asked) == key(line)) {
            Some(asked) => format!("{asked}\n"),
            None => format!("{line}\n"),
        };
        let text: String = contents.job("scan.obj").lines().map(line).collect();
        let job = job::read(text.as_bytes()).unwrap().job;
        kept(&format!("scan {seed}"), &job, &file);
    }
    assert!(folded > 0, "no face is turned over");
}

/// A block of boxes side by side, as OBJ: between neighbouring `xs` and `ys`, mm, as high as `heights` says, row by row.
fn terraces(xs: &[f64], ys: &[f64], heights: &[&[f64]]) -> Vec<u8> {
    let mut out = String::new();
    let mut count = 0;
    let mut face = |corners: [[f64; 3]; 4]| {
        for [x, y, z] in corners {
            writeln!(out, "v {x} {y} {z}").unwrap();
        }
        let [a, b, c, d] = [1, 2, 3, 4].map(|k| count + k);
        writeln!(out, "f {a} {b} {c}\nf {a} {c} {d}").unwrap();
        count += 4;
    };
    let height = |i: isize, j: isize| {
        let row = usize::try_from(j).ok().and_then(|j| heights.get(j));
        row.and_then(|row| row.get(usize::try_from(i).ok()?)).copied().unwrap_or(0.0)
    };
    for (j, y) in ys.windows(2).enumerate() {
        for (i, x) in xs.windows(2).enumerate() {
            let ([x, to_x], [y, to_y]) = ([x[0], x[1]], [y[0], y[1]]);
            let z = heights[j][i];
            face([[x, y, z], [to_x, y, z], [to_x, to_y, z], [x, to_y, z]]);
            face([[x, y, 0.0], [x, to_y, 0.0], [to_x, to_y, 0.0], [to_x, y, 0.0]]);
            // Its sides, counter-clockwise as seen from above, and the box beyond each.
            let (i, j) = (i as isize, j as isize);
            let sides = [
                ([x, y], [to_x, y], (i, j - 1)),
                ([to_x, y], [to_x, to_y], (i + 1, j)),
                ([to_x, to_y], [x, to_y], (i, j + 1)),
                ([x, to_y], [x, y], (i - 1, j)),
            ];
            for ([a, b], [c, d], (i, j)) in sides {
                let low = height(i, j);
                if low < z {
                    face([[a, b, low], [c, d, low], [c, d, z], [a, b, z]]);
                }
            }
        }
    }
    out.into_bytes()
}

/// The lowest that a flat end of a radius comes over a place on its path, mm.
fn lowest_over(path: &[DVec3], radius: f64, x: f64, y: f64) -> f64 {
    let mut lowest = f64::INFINITY;
    for pair in path.windows(2) {
        let (from, way) = (pair[0], pair[1] - pair[0]);
        let (to_x, to_y) = (x - from.x, y - from.y);
        let square = way.x * way.x + way.y * way.y;
        let (begin, end) = if square > 0.0 {
            let along = (to_x * way.x + to_y * way.y) / square;
            let beside = (to_x * way.y - to_y * way.x).abs() / square.sqrt();
            let half = ((radius * radius - beside * beside) / square).max(0.0).sqrt();
            (if beside <= radius { along - half } else { 2.0 }, along + half)
        } else {
            (if to_x * to_x + to_y * to_y <= radius * radius { 0.0 } else { 2.0 }, 1.0)
        };
        if begin <= 1.0 && end >= 0.0 {
            let ends = [begin.max(0.0), end.min(1.0)].map(|part| from.z + part * way.z);
            lowest = lowest.min(ends[0]).min(ends[1]);
        }
    }
    lowest
}

/// A flat end cuts floors up to the walls beside them and nothing else: in a slot as wide as it is, on stairs, beside a thin wall,
/// and in a pocket up to its own radius in the corners.
#[test]
fn flat_ends_cut_floors_up_to_their_walls() {
    let slot = (vec![0.0, 30.0], vec![0.0, 8.0, 14.0, 22.0], vec![vec![9.0], vec![4.0], vec![9.0]]);
    let stairs = (vec![0.0, 7.0, 14.0, 21.0], vec![0.0, 20.0], vec![vec![12.0, 8.0, 4.0]]);
    let wall = (vec![0.0, 10.0, 10.2, 20.0], vec![0.0, 20.0], vec![vec![3.0, 9.0, 3.0]]);
    let high = vec![8.0; 3];
    let pocket_rows = vec![high.clone(), vec![8.0, 3.0, 8.0], high];
    let pocket = (vec![0.0, 5.0, 20.0, 25.0], vec![0.0, 5.0, 17.0, 22.0], pocket_rows);
    for (name, diameter, (xs, ys, rows)) in [
        ("slot", 6.0, slot.clone()),
        ("wide slot", 5.0, slot),
        ("stairs", 6.0, stairs),
        ("thin wall", 6.0, wall),
        ("pocket", 6.0, pocket),
    ] {
        let rows: Vec<&[f64]> = rows.iter().map(Vec::as_slice).collect();
        let job = job("flat", diameter, "file = \"terraces.obj\"", "pattern = \"contour\"");
        let (planned, _) = kept(name, &job, &terraces(&xs, &ys, &rows));
        let tips: Vec<DVec3> = planned.toolpath.points.iter().map(|p| p.tip).collect();
        let radius = 0.5 * diameter;
        let height = |x: f64, y: f64| {
            let [i, j] = [(&xs, x), (&ys, y)].map(|(all, at)| all.partition_point(|a| *a < at));
            rows[j - 1][i - 1]
        };
        // Inside corners of a pocket, where two walls are within the radius.
        let is_in_corner = |x: f64, y: f64| {
            let z = height(x, y);
            let near = |dx: f64, dy: f64| {
                let (x, y) = (x + dx, y + dy);
                let is_in = x > xs[0] && x < xs[xs.len() - 1] && y > ys[0] && y < ys[ys.len() - 1];
                is_in && height(x, y) > z
            };
            (near(radius, 0.0) || near(-radius, 0.0)) && (near(0.0, radius) || near(0.0, -radius))
        };
        let step = 0.25;
        let [wide, deep] = [&xs, &ys].map(|all| (all[all.len() - 1] / step) as usize);
        let mut left = 0;
        for k in 0..wide * deep {
            let at = |i: usize| (i as f64 + 0.5) * step;
            let (x, y) = (at(k % wide), at(k / wide));
            let over = lowest_over(&tips, radius, x, y) - height(x, y);
            assert!(over > -TOLERANCE, "{name}: cut by {over} at {x}, {y}");
            left += usize::from(over > TOLERANCE && !is_in_corner(x, y));
        }
        assert_eq!(left, 0, "{name}: places {step} mm apart that stay");
    }
}

/// A pyramid with its top cut off, on a plate, as OBJ: slopes of 45 degrees that rise from level ground.
fn pyramid() -> Vec<u8> {
    let square = |half: f64, z: f64| {
        [(-half, -half), (half, -half), (half, half), (-half, half)].map(|(x, y)| [x, y, z])
    };
    let rings = [(16.0, -3.0), (16.0, 0.0), (9.0, 0.0), (4.0, 5.0)];
    let mut text = String::new();
    for [x, y, z] in rings.iter().flat_map(|(half, z)| square(*half, *z)) {
        writeln!(text, "v {x} {y} {z}").unwrap();
    }
    writeln!(text, "f 1 3 2\nf 1 4 3\nf 13 14 15\nf 13 15 16").unwrap();
    for first in [1, 5, 9] {
        for (i, j) in [(0, 1), (1, 2), (2, 3), (3, 0)] {
            let [a, b, c, d] = [first + i, first + j, first + 4 + j, first + 4 + i];
            writeln!(text, "f {a} {b} {c}\nf {a} {c} {d}").unwrap();
        }
    }
    text.into_bytes()
}

/// On level ground the middle of the cutter need not stand over its contact: at the foot of a slope it is moved off that, not
/// lifted over it.
#[test]
fn a_bull_end_is_not_lifted_at_the_foot_of_a_slope() {
    let bull = "bull\"\ncorner_radius = 1.0 # \"";
    let job = job(bull, 6.0, "file = \"pyramid.obj\"", "pattern = \"contour\"");
    let (planned, _) = kept("pyramid", &job, &pyramid());
    let highest = planned.lifted.iter().map(|span| span.raise).fold(0.0, f64::max);
    assert!(highest <= 3.0 * TOLERANCE, "{highest}");
}

/// A blade without its ends: a lens of two arcs 25 mm in radius over a chord of 30 mm, 20 mm long, of facets of about
/// 1.5 mm. It turns by 106 degrees at its edges.
fn lens_blade() -> Vec<u8> {
    const SIDE: usize = 20;
    let (radius, half) = (25.0_f64, 15.0_f64);
    let low = (radius * radius - half * half).sqrt();
    let place = |k: usize, y: f64| {
        let (side, part) = (k / SIDE, (k % SIDE) as f64 / SIDE as f64);
        let x = half * (1.0 - 2.0 * part);
        let z = (radius * radius - x * x).sqrt() - low;
        if side == 0 { [x, y, z] } else { [-x, y, -z] }
    };
    let rows = 14;
    let columns = (0..2 * SIDE).flat_map(|k| (0..rows).map(move |j| (k, 20.0 * j as f64 / 13.0)));
    let places: Vec<[f64; 3]> = columns.map(|(k, y)| place(k, y)).collect();
    let closed = faces_of(2 * SIDE + 1, rows).into_iter().map(|f| f.map(|v| v % places.len()));
    // Outward.
    let faces: Vec<[usize; 3]> = closed.map(|[a, b, c]| [a, c, b]).collect();
    obj(&places, &faces)
}

/// An axis along the normal jumps over a sharp edge: the job that is written for a blade with such edges machines what is
/// seen from above, and keeps its limits.
#[test]
fn a_blade_with_sharp_edges_is_machined_from_above() {
    let contents = contents("blade.obj", &lens_blade(), 1.0).unwrap();
    let job = job::read(contents.job("blade.obj").as_bytes()).unwrap().job;
    assert!(job.surface.steepest.is_some());
    let (planned, _) = kept("blade", &job, &lens_blade());
    let aside = planned.prepared.aside.unwrap();
    assert!(aside.away > 0.9 * planned.prepared.surface.area(), "{aside:?}");
}
