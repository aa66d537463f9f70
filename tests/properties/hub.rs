//! Channels between blades: judged on cutter, shank and holder, all alike, and in a program that a machine can run.
#![expect(
    clippy::disallowed_methods,
    reason = "a witness that shares no functions with the product"
)]

use std::fs;
use std::path::Path;
use std::sync::LazyLock;

use evencut_core::geometry::DVec3;
use evencut_core::job::{self, Job};
use evencut_core::machine::Post;
use evencut_core::plan::{Files, Planned, plan};
use evencut_core::toolpath::{MoveKind, PathPoint, Toolpath};
use evencut_core::verify::{Facets, clearance};
use evencut_output::gcode::{CheckOptions, check};
use evencut_output::post::{Dialect, ProgramOptions, program};
use evencut_service::compare::judged;
use evencut_service::results::{Input, ResultsOptions, results};
use evencut_tests::follow::{assert_follows, read_for};
use evencut_tests::linuxcnc::{in_part, interpreted};
use evencut_tests::{ledger, shared_data};

/// Distances up to this one are told apart, mm, and how well.
const BEYOND: f64 = 1.0;
const ACCURACY: f64 = 0.002;

/// NASA's HECC impeller: the channels between its main blades, a splitter in each.
const HECC: &str = "version = 1\nname = \"hecc\"\n[surface]\nfile = \"hecc_hub_sector.json\"\n[tool]\n\
    kind = \"ball\"\ndiameter = 6.0\nstickout = 90.0\n[cut]\nscallop = 0.02\naxial_depth = 0.5\nfeed = 1200\n\
    tolerance = 0.005\n[path]\npattern = \"hub\"\n[hub]\nblades = 15\naxis = [1, 0, 0]\n\
    blade = [\"hecc_main_blade.json\"]\nsplitter = [\"hecc_splitter_blade.json\"]\n[machine]\naxes = \"xyzac\"\n";

/// The shipped blisk and the impeller with their channels, planned once for all tests.
static BLISK: LazyLock<(Case, Planned)> = LazyLock::new(|| {
    let folder = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../jobs"));
    let text = fs::read_to_string(folder.join("blisk.toml")).unwrap();
    let case = Case::new("blisk", &text, folder);
    let planned = case.planned(2);
    (case, planned)
});
static HECC_CHANNELS: LazyLock<Option<(Case, Planned)>> = LazyLock::new(|| {
    let case = Case::hecc()?;
    let planned = case.planned(2);
    Some((case, planned))
});

/// A job with its files.
struct Case {
    name: &'static str,
    job: Job,
    surface: Vec<u8>,
    blades: Vec<(String, Vec<u8>)>,
}

impl Case {
    fn new(name: &'static str, text: &str, folder: &Path) -> Self {
        let job = match job::read(text.as_bytes()) {
            Ok(resolved) => resolved.job,
            Err(faults) => panic!("{}", faults.render(name, text.as_bytes())),
        };
        let bytes = |file: &str| fs::read(folder.join(file)).unwrap();
        let job::SurfaceSource::File(file) = &job.surface.source else { panic!("{name}: no file") };
        let blades = job.blade_files().into_iter().map(|f| (f.to_owned(), bytes(f))).collect();
        Self { name, surface: bytes(file), blades, job }
    }

    fn hecc() -> Option<Self> {
        shared_data().map(|data| Self::new("hecc", HECC, &data.join("nurbs")))
    }

    fn planned(&self, threads: usize) -> Planned {
        let surface = Files::of_surface(Some(&self.surface));
        let files = Files { blades: &self.blades, ..surface };
        plan(&self.job, files, threads, &mut |_, _| {})
            .unwrap_or_else(|error| panic!("{}: {error}", self.name))
    }

    fn wanted(&self) -> f64 {
        self.job.hub.as_ref().unwrap().clearance
    }

    /// Smallest distance of cutter, shank and holder on a path: of all of them from the blades, of what is above the cutter
    /// from the hub, too.
    fn clearance(&self, planned: &Planned, points: &[PathPoint]) -> f64 {
        let path = Toolpath { points: points.to_vec() };
        let of = |part: &evencut_core::surface::Part| {
            let facets = Facets { positions: &part.positions, faces: &part.faces };
            clearance(&path, facets, &self.job.assembly, BEYOND, ACCURACY, 2).unwrap()
        };
        let blades = of(planned.prepared.passage().unwrap().blades());
        let [_, shank, holder] = of(&planned.prepared.rest).by_part;
        [shank, holder].into_iter().flatten().fold(blades.smallest, f64::min)
    }

    /// What holds of all channels of a hub.
    fn assert_kept(&self, planned: &Planned) {
        let name = self.name;
        let points = &planned.toolpath.points;
        let figures = judged(&self.job, planned, 2).unwrap();
        let v = figures.report.verification.as_ref().unwrap();
        assert!(v.passed, "{name}: {:?}", v.broken);
        assert_eq!(v.untouched_mm2, 0.0, "{name}");
        assert!(planned.lifted.is_empty(), "{name}");
        let hub = self.job.hub.as_ref().unwrap();
        let found = planned.channels.unwrap();
        assert_eq!(found.channels, hub.blades as usize, "{name}");
        assert!(found.least_jacobian > 0.0, "{name}: {}", found.least_jacobian);
        // No retract within a channel, with a splitter neither.
        assert_eq!(found.retracts, 0, "{name}");
        assert_eq!(found.shortened.count, 0, "{name}: {:?}", found.shortened);
        for channel in 0..hub.blades {
            let kinds = points.iter().filter(|p| p.region == channel).map(|p| p.kind);
            let flying: Vec<bool> = kinds.map(|k| k == MoveKind::Rapid).collect();
            let lands = flying.windows(2).filter(|w| w[0] && !w[1]).count();
            assert!(flying[0] && lands == 1, "{name}: channel {channel} is left {lands} times");
        }
        let first: Vec<PathPoint> = points.iter().take_while(|p| p.region == 0).copied().collect();
        let measured = self.clearance(planned, &first);
        let asked = format!("at least {} mm", self.wanted());
        ledger(&format!("hub, clearance, {name}"), &asked, &format!("{measured:.3} mm"));
        // What is measured is at most the true distance.
        assert!(measured >= self.wanted(), "{name}: {measured}");
        let ([strips, equal], floor) = (found.lengths, found.length_floor);
        let over = 100.0 * (strips / floor - 1.0);
        ledger(&format!("hub, length over floor, {name}"), "5 %", &format!("{over:.1} %"));
        assert!(strips <= equal, "{name}: {strips} of {equal} mm");
        assert!(strips > 0.99 * floor && strips < 1.05 * floor, "{name}: {over} %");
        self.assert_turned(points, &first);
        let again = self.planned(1);
        assert_eq!(again.toolpath, planned.toolpath, "{name}: threads change the path");
    }

    /// Every channel is the first one turned about the axis.
    fn assert_turned(&self, points: &[PathPoint], first: &[PathPoint]) {
        let hub = self.job.hub.as_ref().unwrap();
        let turned = |v: DVec3, angle: f64| {
            let along = hub.axis * hub.axis.dot(v);
            let across = v - along;
            let (s, c) = angle.sin_cos();
            along + across * c + hub.axis.cross(across) * s
        };
        let own = |all: &[PathPoint]| {
            all.iter().filter(|p| p.kind != MoveKind::Rapid).copied().collect::<Vec<_>>()
        };
        let first = own(first);
        let pitch = std::f64::consts::TAU / f64::from(hub.blades);
        let off = |sign: f64| {
            let mut most = 0.0_f64;
            for channel in 1..hub.blades {
                let here: Vec<PathPoint> =
                    points.iter().filter(|p| p.region == channel).copied().collect();
                let here = own(&here);
                assert_eq!(here.len(), first.len(), "{}: channel {channel}", self.name);
                let angle = sign * pitch * f64::from(channel);
                for (a, b) in first.iter().zip(&here) {
                    let tip = hub.origin + turned(a.tip - hub.origin, angle);
                    most = most.max(tip.distance(b.tip));
                    most = most.max(turned(a.axis, angle).distance(b.axis));
                }
            }
            most
        };
        let most = off(1.0).min(off(-1.0));
        assert!(most < 1e-8, "{}: {most} mm beside the first channel", self.name);
    }

    fn options(&self, planned: &Planned) -> ProgramOptions {
        ProgramOptions {
            name: self.name.into(),
            machine: self.job.machine,
            rapid_plane: planned.rapid_plane,
            tool: self.job.tool,
            setup: self.job.setup,
            spindle: self.job.cut.spindle,
            tolerance: self.job.cut.tolerance,
        }
    }
}

#[test]
fn the_channels_of_an_axial_blisk_are_machined_within_their_limits() {
    let (case, planned) = &*BLISK;
    case.assert_kept(planned);
}

#[test]
fn the_channels_of_an_impeller_are_machined_within_their_limits() {
    if let Some((case, planned)) = &*HECC_CHANNELS {
        case.assert_kept(planned);
    }
}

/// The program of all channels turns the tables no faster than they can, and LinuxCNC's interpreter follows the path.
#[test]
fn programs_of_channels_run_on_the_machine() {
    let (case, planned) = &*BLISK;
    assert_runs(case, planned);
}

/// Of an impeller, too, around its splitters; one channel, whose program is as long as that of a blisk.
#[test]
fn the_program_of_an_impeller_runs_on_the_machine() {
    let Some(mut case) = Case::hecc() else { return };
    case.job.hub.as_mut().unwrap().channels = job::HubChannels::One;
    let planned = case.planned(2);
    assert_runs(&case, &planned);
}

fn assert_runs(case: &Case, planned: &Planned) {
    let options = case.options(planned);
    let dialect = Dialect::of(Post::LinuxCnc).unwrap();
    let text = program(&planned.toolpath, &options, &dialect).unwrap().text;
    let read = read_for(&options.machine, &text);
    let limits = CheckOptions {
        clearance_plane: Some(planned.rapid_plane),
        travel: options.machine.travel,
        max_feed: Some(options.machine.max_feed),
    };
    assert_eq!(check(&read, &limits), []);
    let mut at = read.machine[0].rotary;
    let mut fastest = 0.0_f64;
    for (i, m) in read.moves.iter().enumerate() {
        let Some(end) = read.points_of(i).last() else { continue };
        let to = read.machine[end].rotary;
        let turn = (0..2).map(|k| (to[k] - at[k]).abs()).fold(0.0, f64::max);
        if !m.rapid && turn > 0.0 {
            fastest = fastest.max(turn / m.duration);
        }
        at = to;
    }
    let chain = options.machine.axes.chain().unwrap();
    assert!(fastest <= 1.001 * chain.axes()[0].max_speed, "{fastest} rad/s");
    let Some(moves) = interpreted(&text, case.name) else { return };
    let moves = moves.unwrap_or_else(|message| panic!("LinuxCNC rejects it: {message}"));
    let met: Vec<(bool, DVec3, DVec3)> =
        moves.iter().map(|&(rapid, p)| (rapid, in_part(p).0, in_part(p).1)).collect();
    let radius = case.job.tool.radius();
    let tolerance = case.job.cut.tolerance;
    // The first block only lifts; X and Y are not yet known.
    assert_follows(&planned.toolpath, &met[1..], planned.rapid_plane, tolerance, radius);
}

/// A job for faces of a STEP file: the hub, its axis, one blade.
fn of_step(
    file: &str,
    face: u32,
    blades: u32,
    axis: [u32; 3],
    blade: &str,
    diameter: u32,
) -> String {
    format!(
        "version = 1\nname = \"step\"\n[surface]\nfile = \"{file}\"\nface = {face}\n[tool]\nkind = \"ball\"\n\
         diameter = {diameter}.0\nstickout = 150.0\n[cut]\nscallop = 0.02\naxial_depth = 0.5\nfeed = 1200\n\
         tolerance = 0.01\n[path]\npattern = \"hub\"\n[hub]\nblades = {blades}\naxis = {axis:?}\nblade = {blade}\n\
         channels = \"one\"\n[machine]\naxes = \"xyzac\"\n"
    )
}

/// An extension that would run into the next blade of a propeller is shortened, and the path stays clear of it.
#[test]
fn extensions_give_way_to_blades() {
    let Some(data) = shared_data() else { return };
    let text = of_step("bladex_propeller_hub_one_blade.step", 5, 5, [1, 0, 0], "[8, 9, 10]", 10);
    let case = Case::new("propeller", &text, &data.join("step"));
    let planned = case.planned(2);
    let found = planned.channels.unwrap();
    let wanted = case.job.hub.as_ref().unwrap().extension;
    assert!(found.shortened.count > 0 && found.shortened.least.0 < wanted, "{found:?}");
    assert!(case.clearance(&planned, &planned.toolpath.points) >= case.wanted());
}

/// Beside the nose of a splitter, and in the corner of an oblique end, passes a strip apart leave more than the limit and the
/// tolerance; what is measured there is cut again.
#[test]
fn what_strips_leave_is_cut_again() {
    let Some(data) = shared_data() else { return };
    let files = [
        ("hecc_one_main_one_splitter.step", "[4, 5, 6, 12]", "splitter = [7, 8, 9]"),
        ("hecc_one_blade_fillet1mm.step", "[2, 3, 4, 5, 6, 9, 10, 11, 14]", ""),
    ];
    for (file, blade, splitter) in files {
        let text = of_step(file, 1, 10, [1, 0, 0], blade, 6);
        let text = text.replace("channels =", &format!("{splitter}\nchannels ="));
        let case = Case::new("hecc", &text, &data.join("step"));
        let figures = judged(&case.job, &case.planned(2), 2).unwrap();
        let v = figures.report.verification.as_ref().unwrap();
        assert!(v.passed, "{file}: {:?}", v.broken);
    }
}

/// A file with nine blades, and jobs with other numbers. Faces of the blade's body that are not its foot do no harm.
#[test]
fn a_number_of_blades_that_is_not_that_of_the_file_is_refused() {
    let Some(data) = shared_data() else { return };
    let case = |blades: u32, blade: &str| {
        let text = of_step("kj66_impeller.step", 65, blades, [0, 1, 0], blade, 4);
        Case::new("kj66", &text, &data.join("step"))
    };
    for blades in [7, 10] {
        let case = case(blades, "[1, 2, 3]");
        let files = Files::of_surface(Some(&case.surface));
        let error = plan(&case.job, files, 1, &mut |_, _| {}).err().unwrap().to_string();
        assert!(error.contains("as 9 blades stand"), "{blades}: {error}");
    }
    for blade in ["[1, 2, 3]", "[1, 2, 3, 5, 7, 9]"] {
        assert_eq!(case(9, blade).planned(2).channels.unwrap().channels, 1);
    }
}

/// Faces of a blade or a splitter of the file that the job does not name would be cut into.
#[test]
fn faces_of_blades_that_are_not_named_are_refused() {
    let Some(data) = shared_data() else { return };
    let refusal = |blade: &str, splitter: &str| {
        let text = of_step("hecc_one_main_one_splitter.step", 1, 15, [1, 0, 0], blade, 6);
        let text = text.replace("channels =", &format!("{splitter}\nchannels ="));
        let case = Case::new("hecc", &text, &data.join("step"));
        let input = Input { name: "job.toml", bytes: text.as_bytes() };
        let files = Files::of_surface(Some(&case.surface));
        let options = ResultsOptions { threads: 1, verify: false };
        results(&case.job, input, files, options, &mut |_, _| {}).err().map(|e| e.to_string())
    };
    let none = refusal("[4, 5, 6, 12]", "").unwrap();
    assert!(none.contains("of a blade or splitter that is not named"), "{none}");
    let part = refusal("[4, 5, 6]", "splitter = [7, 8, 9]").unwrap();
    assert!(part.contains("face 12 of the file is of the same blade"), "{part}");
}

/// With the same centres, and axes along the normals of the hub or leaning over from them, the tool runs into blades, and the
/// judge sees it.
#[test]
fn without_its_axes_the_path_collides() {
    let cases = [Some(&*BLISK), HECC_CHANNELS.as_ref()];
    for (case, planned) in cases.into_iter().flatten() {
        let radius = case.job.tool.radius();
        let hub = case.job.hub.as_ref().unwrap();
        let first = || planned.toolpath.points.iter().take_while(|p| p.region == 0);
        let with = |lean: f64| {
            let turned = |p: &PathPoint| {
                let around = hub.axis.cross(p.tip - hub.origin).normalize();
                let axis = (p.normal + around * lean).normalize();
                PathPoint { tip: p.tip + (p.axis - axis) * radius, axis, ..*p }
            };
            // Deep collisions take long to measure; some of the passes will do.
            let cuts = first().filter(|p| p.kind == MoveKind::Cut && p.pass % 6 == 0);
            case.clearance(planned, &cuts.map(turned).collect::<Vec<PathPoint>>())
        };
        // Blades that stand straight up from their hub are cleared along its normals.
        let found = [0.0, 1.0].map(with);
        println!("{}: {found:.3?} mm with other axes", case.name);
        let smallest = found[0].min(found[1]);
        assert!(
            smallest < case.wanted() - 2.0 * case.job.cut.tolerance,
            "{}: {found:?}",
            case.name
        );
    }
}
