use super::*;
use evencut_core::job;

/// A plane under a ball, without a machine and without a window.
pub(crate) const JOB: &str = "version = 1
[surface]
analytic = { kind = \"plane\", size = 8, resolution = 1 }
[tool]
diameter = 10
flutes = 2
[cut]
stepover = 0.5
axial_depth = 0.2
feed = 1200
spindle = 6000
[path]
pattern = \"iso-planar\"
angle = 0
";

fn made(texture: &str, threads: usize) -> Result<TextureResults, ResultsError> {
    let job = job::read(format!("{JOB}{texture}").as_bytes()).unwrap().job;
    texture_results(&job, Files::default(), threads, &mut |_, _| {})
}

/// A small window on it.
pub(crate) const WINDOW: &str =
    "[texture]\nat = [0.2, 0.1, 0]\nsize = [0.4, 1.0]\nspacing = 0.02\n";

#[test]
fn a_planned_plane_has_the_cusps_of_its_passes() {
    let one = made(WINDOW, 1).unwrap();
    let names: Vec<_> = one.files.iter().map(|f| f.name.as_str()).collect();
    let wanted = ["csv", "asc", "x3p", "svg", "png", "json"].map(|end| format!("texture.{end}"));
    assert_eq!(names, wanted);
    for threads in [2, 3] {
        assert_eq!(made(WINDOW, threads).unwrap().files, one.files);
    }
    let report = &one.figures;
    assert_eq!((report.window.nodes, report.window.uncut), ([21, 51], 0));
    // Passes are a little nearer than asked, so that they fill the plane.
    let known = 0.5 * 0.5 / 40.0 * 1e3;
    assert!(report.across.rt_um > 0.8 * known && report.across.rt_um < 1.1 * known, "{report:?}");
    assert!(report.window.facets_um < 1e-9 && report.window.feed[0].abs() > 0.999);
    assert!(report.summary().contains("should have 2.500 mm"));
    let constant = made(&format!("{WINDOW}discretisation = \"constant\"\n"), 1).unwrap();
    assert!((constant.figures.areal.sa_um / report.areal.sa_um - 1.0).abs() < 1e-3);
}

#[test]
fn what_cannot_be_simulated_is_told() {
    assert!(matches!(made("", 1), Err(ResultsError::Texture(TextureError::NoWindow))));
    let refusal = |texture: &str| made(texture, 1).unwrap_err().to_string();
    assert!(
        refusal("[texture]\nat = [0, 0, 9]\nsize = [1, 1]\n").contains("no nearer than 9.0000 mm")
    );
    assert!(refusal("[texture]\nat = [3.9, 0, 0]\nsize = [1, 1]\n").contains("leaves the surface"));
    assert!(refusal("[texture]\nat = [0, 0, 0]\nspacing = 1e-5\n").contains("at most 20000000"));
    let job = job::read(format!("{JOB}{WINDOW}").as_bytes()).unwrap().job;
    let still = Job { cut: evencut_core::job::Cut { spindle: 0.0, ..job.cut }, ..job.clone() };
    let still = texture_results(&still, Files::default(), 1, &mut |_, _| {});
    assert!(matches!(still, Err(ResultsError::Texture(TextureError::Still { .. }))));
    assert!(engaged(&job, Some(4.0), Some(4.0), 0.0).is_err());
    assert!(engaged(&job, Some(40.0), Some(4.0), 0.0).unwrap() >= 10.0);
    assert!((engaged(&job, None, None, 0.0).unwrap() - 0.2).abs() < 1e-15);
}

#[test]
fn a_path_that_does_not_belong_to_the_surface_is_told() {
    let job = job::read(format!("{JOB}{WINDOW}").as_bytes()).unwrap().job;
    let path = plan(&job, Files::default(), 1, &mut |_, _| {}).unwrap().toolpath;
    let shifted = |z: f64| {
        let mut path = path.clone();
        path.points.iter_mut().for_each(|point| point.tip.z += z);
        texture_of_path(&job, Files::default(), &path, 1, &mut |_, _| {})
    };
    let not_cut =
        |result| matches!(result, Err(ResultsError::Texture(TextureError::NotCut { .. })));
    assert!(not_cut(shifted(50.0)));
    let notes = shifted(-0.1).unwrap().figures.notes;
    assert!(notes.iter().any(|note| note.contains("below the surface")), "{notes:?}");
    let mut still = path.clone();
    still.points.iter_mut().for_each(|point| point.time = 0.0);
    let still = texture_of_path(&job, Files::default(), &still, 1, &mut |_, _| {});
    assert!(matches!(still, Err(ResultsError::Texture(TextureError::NoTime))));
}

#[test]
fn a_whole_surface_has_a_grid_with_gaps_beyond_it() {
    let cap =
        JOB.replace("kind = \"plane\", size = 8", "kind = \"sphere-cap\", radius = 40, size = 4");
    let cap = cap.replace("resolution = 1", "resolution = 0.2");
    let of = |texture: &str, threads: usize| {
        let job = job::read(format!("{cap}{texture}").as_bytes()).unwrap().job;
        texture_results(&job, Files::default(), threads, &mut |_, _| {})
    };
    const WHOLE: &str = "[texture]\nwhole = true\nspacing = 0.02\n";
    let whole = of(WHOLE, 1).unwrap();
    assert_eq!(of(WHOLE, 3).unwrap().files, whole.files);
    let window = &whole.figures.window;
    // A disk fills pi / 4 of its square.
    let share = window.beyond as f64 / (window.nodes[0] * window.nodes[1]) as f64;
    assert!((share - (1.0 - std::f64::consts::FRAC_PI_4)).abs() < 0.02, "{share}");
    let csv = std::str::from_utf8(&whole.files[0].bytes).unwrap();
    let empty = csv.lines().filter(|line| line.ends_with(',')).count();
    assert_eq!(empty as u64, window.beyond);
    let matrix = std::str::from_utf8(&whole.files[1].bytes).unwrap();
    assert_eq!(matrix.matches("nan").count() as u64, window.beyond);
    // Its middle is a window's.
    let middle = of("[texture]\nat = [0, 0, 0]\nsize = [2, 2]\nspacing = 0.02\n", 1).unwrap();
    assert!((whole.figures.areal.sa_um / middle.figures.areal.sa_um - 1.0).abs() < 0.1);
    let coarse = of("[texture]\nwhole = true\nspacing = 9\n", 1);
    assert!(matches!(coarse, Err(ResultsError::Texture(TextureError::Grid(_)))));
    let constant = format!("{JOB}[texture]\nwhole = true\ndiscretisation = \"constant\"\n");
    assert!(job::read(constant.as_bytes()).is_err());
    assert!(job::read(format!("{JOB}[texture]\nsize = [1, 1]\n").as_bytes()).is_err());
}

/// Heights of texture.csv by place, in 0.1 µm along and across.
fn heights(results: &TextureResults) -> std::collections::BTreeMap<[i64; 2], Option<f64>> {
    let file = results.files.iter().find(|file| file.name == "texture.csv").unwrap();
    let text = std::str::from_utf8(&file.bytes).unwrap();
    let of = |line: &str| {
        let mut fields = line.split(',');
        let place = [0, 1].map(|_| {
            let mm: f64 = fields.next().unwrap().parse().unwrap();
            (1e4 * mm).round() as i64
        });
        (place, fields.next().unwrap().parse().ok())
    };
    text.lines().skip(1).map(of).collect()
}

#[test]
fn coarse_cells_have_the_heights_of_fine_ones() {
    let of = |spacing: f64| {
        let window = format!("[texture]\nat = [0.2, 0.1, 0]\nsize = [1, 1]\nspacing = {spacing}\n");
        made(&window, 2).unwrap()
    };
    let fine = of(0.01);
    let held = heights(&fine);
    for spacing in [0.1, 0.5, 1.0] {
        for (place, height) in heights(&of(spacing)) {
            let off = (height.unwrap() - held[&place].unwrap()).abs();
            assert!(off <= 0.01 * fine.figures.areal.sz_um, "{spacing} {place:?}: {off} µm");
        }
    }
}

#[test]
fn what_is_not_cut_counts_for_nothing_and_has_no_height() {
    let job = job::read(format!("{JOB}{WINDOW}").as_bytes()).unwrap().job;
    let path = plan(&job, Files::default(), 1, &mut |_, _| {}).unwrap().toolpath;
    let simulated =
        |path: &Toolpath| texture_of_path(&job, Files::default(), path, 1, &mut |_, _| {}).unwrap();
    let all = simulated(&path);
    // Without the passes of the other half, a ball of radius 5 mm leaves 0.2 mm beyond 1.4 mm beside the last one.
    let mut part = path.clone();
    part.points.retain(|point| point.tip.y < -1.1);
    let part = simulated(&part);
    let uncut = part.figures.window.uncut;
    assert_eq!(all.figures.window.uncut, 0);
    assert!(uncut > 50 && uncut < 21 * 51 - 50, "{uncut}");
    let (full, left) = (heights(&all), heights(&part));
    assert_eq!(left.values().filter(|height| height.is_none()).count() as u64, uncut);
    assert!(full.values().all(Option::is_some));
    let matrix = part.files.iter().find(|file| file.name == "texture.asc").unwrap();
    let matrix = std::str::from_utf8(&matrix.bytes).unwrap();
    assert_eq!(matrix.matches("nan").count() as u64, uncut);
    // What is left without a slope is lower than the step to the blank.
    let top = left.values().flatten().copied().fold(f64::NEG_INFINITY, f64::max);
    assert!(top < 200.0 && part.figures.areal.sz_um < 200.0);
    let told = part.figures.summary();
    assert!(told.contains(&format!(", {uncut} of them not cut")), "{told}");
    assert!(told.contains("left out of all parameters"), "{told}");
}

#[test]
fn a_whole_surface_with_too_many_nodes_is_told_a_spacing_that_works() {
    let told = made("[texture]\nwhole = true\nspacing = 1e-4\n", 1).unwrap_err().to_string();
    // 8 mm by 8 mm: 20 million nodes are 1.79 µm apart.
    assert!(told.contains("give a spacing of 0.0018 mm or more"), "{told}");
}

#[test]
fn a_window_that_is_short_along_the_feed_is_told() {
    let notes = |length: f64| {
        let window = format!("[texture]\nat = [0, 0, 0]\nsize = [{length}, 2.5]\nspacing = 0.02\n");
        made(&window, 1).unwrap().figures.notes
    };
    let short = notes(0.3);
    assert!(short.iter().any(|note| note.contains("should have 0.500 mm, two turns")), "{short:?}");
    assert!(notes(0.5).is_empty(), "{:?}", notes(0.5));
}
