//! The judge by brute force: a delivered table and the part's triangles against what a kept job promises.

use crate::cutter::{Cutter, Line};
use crate::part::{Mesh, Place};
use crate::path::{Row, Sweep, rows};
use crate::random::Random;
use crate::rate::{Layer, peak, share_of};
use crate::reach::Obstacles;
use crate::walls::{Stand, tops, walls};
use evencut_core::geometry::DVec3;
use evencut_core::geometry::math::{acos_clamped, atan2, cos, sin};
use evencut_core::job::{Boundary, ForceControl, Job};
use evencut_core::machine::Axes;
use evencut_output::report::Report;
use evencut_service::verdict::Workpiece;

/// What heights may be off: the table has six decimals, which is 1.7e-6 mm at a tip and 4e-7 mm at the end of a
/// lever of 100 mm, a bent move 1e-4 mm, the searches less.
const NOISE: f64 = 3e-4;
/// Share of a height that it may be off: normals between corners are a matter of choice to some degrees, and a
/// height along a line 4.5 degrees off is 0.3 % larger.
const SHARE: f64 = 0.003;
/// Random places on the machined surface, on its rim, and on the rest.
const PLACES: usize = 4000;
const RIM_PLACES: usize = 800;
const REST_PLACES: usize = 3000;
/// Worst places around which further ones are tried, rounds of that, and places a round.
const WORST: usize = 12;
const ROUNDS: usize = 5;
const BESIDE: usize = 24;
/// Peak of the removal rate over the limit that the product's own judge lets pass.
const RATE_NOISE: f64 = 1.03;
/// Places said to be out of reach that are tried, at most.
const TRIED: usize = 150;
/// Excused though within reach: largest share of the surface, and largest area, mm². Both must be exceeded.
const EXCUSED: (f64, f64) = (0.01, 1.0);
/// Random stretches on which the rate is measured.
const STRETCHES: usize = 1;

/// A promise that is not kept.
#[derive(Clone, Debug)]
pub struct Failure {
    /// Which check.
    pub check: &'static str,
    /// What was found.
    pub what: String,
}

/// What brute force found.
#[derive(Clone, Debug, Default)]
pub struct Findings {
    /// Promises that are not kept.
    pub failures: Vec<Failure>,
    /// The worst figures.
    pub figures: Vec<String>,
}

impl Findings {
    fn fail(&mut self, check: &'static str, what: String) {
        self.failures.push(Failure { check, what });
    }
}

/// A judged job.
struct Case<'a> {
    job: &'a Job,
    report: &'a Report,
    rows: Vec<Row>,
    sweep: Sweep,
    design: Mesh,
    rest: Mesh,
    random: Random,
    out: Findings,
}

/// A place with its height or depth.
type Measured = (f64, Place);

fn shown(p: DVec3) -> String {
    format!("({:.3}, {:.3}, {:.3})", p.x, p.y, p.z)
}

/// Judges what was delivered for a job that exits with 0.
pub fn judged(job: &Job, table: &str, part: &Workpiece, report: &Report, seed: u64) -> Findings {
    let rows = match rows(table) {
        Ok(rows) => rows,
        Err(what) => {
            return Findings {
                failures: vec![Failure { check: "table", what }],
                ..Findings::default()
            };
        }
    };
    let cutter = Cutter {
        radius: job.tool.radius(),
        corner: job.tool.corner_radius(),
        length: job.cutter_length(),
    };
    let sweep = Sweep::new(&rows, cutter);
    let (design, rest) = (Mesh::new(&part.design), Mesh::new(&part.rest));
    let random = Random::new(seed);
    let out = Findings::default();
    let mut case = Case { job, report, rows, sweep, design, rest, random, out };
    case.moves();
    case.residual();
    case.gouges();
    if job.path.boundary == Boundary::Wall {
        case.walls();
    }
    if job.force.control != ForceControl::Off {
        case.rate();
    }
    case.out
}

impl Case<'_> {
    fn tolerance(&self) -> f64 {
        self.job.cut.tolerance
    }

    fn limit(&self) -> f64 {
        self.report.coverage.cusp_limit_mm
    }

    /// Above this a residual breaks the limit.
    fn too_high(&self) -> f64 {
        (1.0 + SHARE) * self.limit() + self.tolerance() + NOISE
    }

    /// Height left above surface and allowance; the depth of the layer where nothing came.
    fn height(&self, place: &Place) -> f64 {
        let line =
            Line { foot: place.at + place.normal * self.job.cut.allowance, along: place.normal };
        let (floor, top) = (-self.tolerance() - NOISE, self.job.cut.axial_depth);
        self.sweep.lowest(line, floor, top, &|_| true).map_or(top, |l| l.0)
    }

    /// Whether the plan says that the cutter does not come there.
    fn is_excused(&self, at: DVec3) -> bool {
        let places = &self.report.coverage.inaccessible_places;
        places.iter().any(|[x, y, z, r]| DVec3::new(*x, *y, *z).distance(at) <= r + 1e-6)
    }

    fn on_rims(&mut self, count: usize) -> Vec<Place> {
        let rims = self.design.rims();
        let mut out = Vec::new();
        for _ in 0..count.min(rims.len() * 20) {
            let rim = rims[self.random.below(rims.len())];
            let at = rim.ends[0].lerp(rim.ends[1], self.random.unit());
            let into = rim.facet.cross(rim.ends[1] - rim.ends[0]).normalize_or_zero();
            let far = self.random.unit() * self.job.nominal_side_step() * 0.5;
            out.extend(self.design.nearest(at + into * far, 1.0));
        }
        out
    }

    /// Places around the highest, ever nearer, with their values.
    fn refined(
        &mut self,
        mut found: Vec<Measured>,
        rest: bool,
        value: &dyn Fn(&Self, &Place) -> f64,
    ) -> Vec<Measured> {
        found.sort_by(|a, b| b.0.total_cmp(&a.0));
        let apart = self.job.nominal_side_step();
        let mut worst: Vec<Measured> = Vec::new();
        for m in found {
            if worst.len() < WORST && worst.iter().all(|w| w.1.at.distance(m.1.at) > apart) {
                worst.push(m);
            }
        }
        let mut radius = 0.5 * apart;
        for _ in 0..ROUNDS {
            for worst in &mut worst {
                for _ in 0..BESIDE {
                    let mesh = if rest { &self.rest } else { &self.design };
                    let Some(place) = mesh.beside(&worst.1, radius, &mut self.random) else {
                        continue;
                    };
                    let found = value(self, &place);
                    if found > worst.0 {
                        *worst = (found, place);
                    }
                }
            }
            radius *= 0.4;
        }
        worst.sort_by(|a, b| b.0.total_cmp(&a.0));
        worst
    }

    /// (1) and (4): nothing stands higher than allowed but where the cutter does not come.
    fn residual(&mut self) {
        let mut places: Vec<Place> =
            (0..PLACES).map(|_| self.design.random(&mut self.random)).collect();
        let whole = places.len() as f64;
        let rim = self.on_rims(RIM_PLACES);
        places.extend(rim);
        let verification = self.report.verification.as_ref();
        let told = verification.and_then(|v| v.scallop.largest_at_mm).map(DVec3::from);
        places.extend(told.and_then(|at| self.design.nearest(at, 1.0)));
        let measured: Vec<Measured> = places.iter().map(|p| (self.height(p), *p)).collect();
        let excused: Vec<Measured> = measured[..PLACES]
            .iter()
            .filter(|m| m.0 > self.too_high() && self.is_excused(m.1.at))
            .copied()
            .collect();
        let judged: Vec<Measured> =
            measured.into_iter().filter(|m| !self.is_excused(m.1.at)).collect();
        let untouched = self.job.cut.axial_depth - 1e-6;
        if judged.is_empty() {
            self.out.fail("residual", "everything is said to be out of reach".into());
            return;
        }
        let value = |case: &Self, p: &Place| {
            if case.is_excused(p.at) { f64::NEG_INFINITY } else { case.height(p) }
        };
        let worst = self.refined(judged, false, &value);
        let (height, place) = worst[0];
        let from_rim = self
            .design
            .rims()
            .iter()
            .map(|rim| rim.distance(place.at))
            .fold(f64::INFINITY, f64::min);
        self.out.figures.push(format!(
            "residual {:.1} of {:.1}+{:.1} µm, {:.2} mm from the rim (judge {:.1})",
            1e3 * height,
            1e3 * self.limit(),
            1e3 * self.tolerance(),
            from_rim,
            verification.map_or(0.0, |v| 1e3 * v.scallop.largest_mm)
        ));
        // No wall's place is known to more than the tolerance.
        let at_wall = self.job.path.boundary == Boundary::Wall && from_rim < self.tolerance();
        let untouched = if at_wall { f64::INFINITY } else { untouched };
        if height > self.too_high() || height >= untouched {
            let over = worst.iter().filter(|w| w.0 > self.too_high()).count();
            let bound = verification.map_or(0.0, |v| v.scallop.sampling_bound_mm);
            let told = if height <= self.limit() + self.tolerance() + bound {
                " (within what the judge says may stand between its samples)"
            } else {
                ""
            };
            let what = format!(
                "{:.1} µm left at {} of {:.1}+{:.1} µm allowed, {over} of {} worst places too \
                 high{}{told}",
                1e3 * height,
                shown(place.at),
                1e3 * self.limit(),
                1e3 * self.tolerance(),
                worst.len(),
                if height >= untouched { ", untouched" } else { "" },
            );
            self.out.fail("residual", what);
        }
        if !excused.is_empty() {
            self.excused(&excused, whole);
        }
    }

    /// (4): what is excused is out of reach.
    fn excused(&mut self, excused: &[Measured], whole: f64) {
        let area = self.design.area();
        let share = excused.len() as f64 / whole;
        self.out.figures.push(format!("excused {:.1} mm² of {area:.0}", share * area));
        if self.job.machine.axes != Axes::ThreeAxis {
            return;
        }
        let allowance = self.job.cut.allowance;
        let raised = |(face, normals): (&[DVec3; 3], &[DVec3; 3])| {
            [0, 1, 2].map(|k| face[k] + normals[k] * allowance)
        };
        let mut faces: Vec<[DVec3; 3]> =
            self.design.faces.iter().zip(&self.design.normals).map(raised).collect();
        faces.extend(&self.rest.faces);
        let walls = match self.job.path.boundary {
            Boundary::Wall => {
                walls(&self.design.rims(), &self.rest, self.job.path.wall_height, true)
            }
            Boundary::Open => Vec::new(),
        };
        let obstacles = Obstacles::new(self.sweep.cutter, faces, &tops(&walls));
        let allowed = self.limit() + self.tolerance() + allowance;
        // What lies behind a wall is the wall's.
        let admits = |p: &Place| {
            let point = p.at + p.normal * allowed;
            let free = walls.iter().filter_map(|w| w.crossed(p.at, point)).fold(1.0, f64::min);
            obstacles.admits(p.at.lerp(point, free))
        };
        // Evenly thinned.
        let tried = excused.len().min(TRIED);
        let picked = (0..tried).map(|i| &excused[i * excused.len() / tried].1);
        let reachable: Vec<Place> = picked.filter(|p| admits(p)).copied().collect();
        // Not what lies within half a side step of what is out of reach, or of what was cut.
        let rim = 0.5 * self.job.nominal_side_step();
        let mut inner = Vec::new();
        for place in &reachable {
            let is_rim = (0..16).any(|_| {
                let beside = self.design.beside(place, rim, &mut self.random);
                beside.is_some_and(|b| !admits(&b))
            });
            if !is_rim {
                inner.push(*place);
            }
        }
        let part = share * inner.len() as f64 / tried as f64;
        self.out.figures.push(format!(
            "within reach of it {:.1} mm²",
            share * area * reachable.len() as f64 / tried as f64
        ));
        if part > EXCUSED.0 && part * area > EXCUSED.1 {
            let at = shown(inner[inner.len() / 2].at);
            let what = format!(
                "{:.1} mm², {:.1} % of the surface, is said to be out of reach, but the cutter \
                 comes there, as at {at}",
                part * area,
                100.0 * part
            );
            self.out.fail("excused", what);
        }
    }

    /// How deep below the surface, at most a cutter radius, a cutter stands that holds the surface too.
    fn depth(&self, place: &Place, allowance: f64) -> f64 {
        let line = Line { foot: place.at + place.normal * allowance, along: place.normal };
        let radius = self.sweep.cutter.radius;
        let least = self.tolerance() + NOISE;
        let mut near = Vec::new();
        self.sweep.near(line, -least, 0.0, &mut |piece| near.push(*piece));
        let holds = |depth: f64| {
            near.iter().any(|piece| self.sweep.cutter.holds(piece, line.at(0.0), line.at(-depth)))
        };
        if !holds(least) {
            return 0.0;
        }
        let (mut low, mut high) = (least, radius);
        for _ in 0..20 {
            let middle = 0.5 * (low + high);
            if holds(middle) { low = middle } else { high = middle }
        }
        low
    }

    /// (2): nothing is cut into.
    fn gouges(&mut self) {
        let allowance = self.job.cut.allowance;
        let mut places: Vec<Place> =
            (0..PLACES / 2).map(|_| self.design.random(&mut self.random)).collect();
        places.extend(self.on_rims(RIM_PLACES));
        let machined = |case: &Self, p: &Place| case.depth(p, allowance);
        let found: Vec<Measured> = places.iter().map(|p| (machined(self, p), *p)).collect();
        let worst = self.refined(found, false, &machined)[0];
        self.cut_into("the surface", worst);
        if self.rest.faces.is_empty() {
            return;
        }
        let mut places: Vec<Place> =
            (0..REST_PLACES).map(|_| self.rest.random(&mut self.random)).collect();
        // Most cuts into the rest lie beside the surface.
        let rims = self.design.rims();
        for _ in 0..RIM_PLACES {
            let rim = rims[self.random.below(rims.len())];
            let at = rim.ends[0].lerp(rim.ends[1], self.random.unit());
            let reach = self.sweep.cutter.radius;
            let Some(place) = self.rest.nearest(at, 0.5 * reach) else { continue };
            let radius = self.random.between(0.0, reach);
            places.extend(self.rest.beside(&place, radius, &mut self.random));
        }
        let other = |case: &Self, p: &Place| case.depth(p, 0.0);
        let found: Vec<Measured> = places.iter().map(|p| (other(self, p), *p)).collect();
        let worst = self.refined(found, true, &other)[0];
        self.cut_into("the rest of the part", worst);
    }

    fn cut_into(&mut self, what: &str, (depth, place): Measured) {
        if depth <= 0.0 {
            return;
        }
        let judge = self.report.verification.as_ref().map_or(0.0, |v| v.gouge_mm);
        let text = format!(
            "{what} is cut {:.1} µm deep at {} (tolerance {:.1}; judge {:.1})",
            1e3 * depth,
            shown(place.at),
            1e3 * self.tolerance(),
            -1e3 * judge
        );
        self.out.fail("gouge", text);
    }

    /// (3): the cutter stands in no wall.
    fn walls(&mut self) {
        let upright = self.job.machine.axes == Axes::ThreeAxis;
        let height = self.job.path.wall_height;
        let walls = walls(&self.design.rims(), &self.rest, height, upright);
        let slack = self.tolerance() + NOISE;
        let stands: Vec<Stand> =
            walls.iter().filter_map(|w| w.deepest(&self.sweep, slack)).collect();
        let worst = stands.iter().max_by(|a, b| a.depth.total_cmp(&b.depth));
        self.out.figures.push(format!("{} walls", walls.len()));
        if let Some(worst) = worst {
            let row = &self.rows[worst.of + 1];
            let what = format!(
                "the cutter stands {:.1} µm in a wall at {} ({} of {} edges; worst on a {} of pass \
                 {}, line {})",
                1e3 * worst.depth,
                shown(worst.at),
                stands.len(),
                walls.len(),
                row.kind,
                row.pass,
                worst.of + 3
            );
            self.out.fail("wall", what);
        }
    }

    /// (5): the removal rate keeps its limit.
    fn rate(&mut self) {
        let limit = self.report.force.limit_mm3_per_min;
        let judged = self.report.verification.as_ref().and_then(|v| v.mrr.as_ref());
        let mut places = Vec::new();
        if let Some((line, at)) = judged.and_then(|m| Some((m.peak_line?, m.peak_at_mm?))) {
            let of = (line as usize).saturating_sub(3).min(self.rows.len() - 2);
            places.push((of, share_of(&self.rows, of, DVec3::from(at))));
        }
        let cutting: Vec<usize> = (0..self.rows.len() - 1)
            .filter(|&k| {
                let row = &self.rows[k + 1];
                !row.is_rapid() && row.feed > 0.0 && row.kind != "link"
            })
            .collect();
        for _ in 0..STRETCHES.min(cutting.len()) {
            places.push((cutting[self.random.below(cutting.len())], self.random.unit()));
        }
        let layer = Layer {
            top: self.job.cut.allowance + self.job.cut.axial_depth,
            floor: self.job.cut.allowance - self.tolerance(),
        };
        let side_step = self.job.nominal_side_step();
        let mut worst: f64 = 0.0;
        for place in places {
            let found = peak(
                &self.sweep,
                &self.rows,
                &self.design,
                layer,
                side_step,
                place,
                &mut self.random,
            );
            let Some(found) = found else { continue };
            worst = worst.max(found.rate / limit);
            if found.rate > RATE_NOISE * limit + found.noise {
                let what = format!(
                    "{:.0} ± {:.0} mm³/min over line {}, {:.3} of the limit ({} columns; judge {:.3})",
                    found.rate,
                    found.noise,
                    place.0 + 3,
                    found.rate / limit,
                    found.columns,
                    judged.and_then(|m| m.peak_over_limit).unwrap_or(0.0)
                );
                self.out.fail("rate", what);
            }
        }
        self.out.figures.push(format!(
            "rate {worst:.3} (judge {:.3})",
            judged.and_then(|m| m.peak_over_limit).unwrap_or(0.0)
        ));
    }

    /// (6): feeds, times, rapids and travel.
    fn moves(&mut self) {
        let upright = self.job.machine.axes == Axes::ThreeAxis;
        let fastest = 60.0 * self.job.machine.max_feed;
        let corners = self.design.faces.iter().chain(&self.rest.faces).flatten();
        // Tables turn the part anywhere in a ball around their centre, and the tool axis to the machine's Z.
        let reach = |p: &DVec3| if upright { p.z } else { p.length() };
        let top = corners.map(reach).fold(f64::NEG_INFINITY, f64::max);
        let height = |row: &Row| row.pose.tip.dot(row.pose.axis);
        let clear = top + self.job.cut.allowance + self.job.cut.axial_depth;
        let mut faults = Vec::new();
        for (k, pair) in self.rows.windows(2).enumerate() {
            let (from, to) = (&pair[0], &pair[1]);
            let moves = from.pose != to.pose;
            let length = to.pose.tip.distance(from.pose.tip);
            let time = to.time - from.time;
            if time < -1e-9 || to.feed < 0.0 || to.feed > fastest * (1.0 + 1e-6) {
                faults.push(format!("line {}: feed {} and {time} s", k + 3, to.feed));
            }
            if !to.is_rapid() && moves && (to.feed <= 0.0 || (length > 1e-3 && time <= 0.0)) {
                faults.push(format!("line {}: a move without feed or time", k + 3));
            }
            // Of an upright cutter the contact goes as far as the tip; the table rounds both.
            let feed = if time > 0.0 { 60.0 * length / time } else { to.feed };
            if upright && moves && length > 0.05 && (feed - to.feed).abs() > 0.01 * to.feed + 1.0 {
                faults.push(format!("line {}: feed {} in {feed:.1} in truth", k + 3, to.feed));
            }
            let lowest = height(from).min(height(to));
            if to.is_rapid() && lowest < clear - 1e-6 {
                faults.push(format!(
                    "line {}: a rapid at height {lowest:.3}, stock up to {clear:.3}",
                    k + 3
                ));
            }
        }
        if self.out_of_travel() {
            faults.push("machine.travel is left".into());
        }
        if let Some(first) = faults.first() {
            self.out.fail("moves", format!("{} faults, first: {first}", faults.len()));
        }
    }

    fn out_of_travel(&self) -> bool {
        let travel = self.job.machine.travel;
        let is_in = |p: DVec3| {
            let kept = |range: Option<(f64, f64)>, x: f64| {
                range.is_none_or(|(low, high)| (low - 1e-3..=high + 1e-3).contains(&x))
            };
            kept(travel.x, p.x) && kept(travel.y, p.y) && kept(travel.z, p.z)
        };
        let upright = self.job.machine.axes == Axes::ThreeAxis;
        self.rows.iter().any(|row| {
            let (tip, axis) = (row.pose.tip, row.pose.axis);
            if upright {
                return !is_in(tip);
            }
            // Tables A and C turn the axis up, one way or the other; upright any C may be.
            if axis.x.abs() + axis.y.abs() < 1e-6 {
                return false;
            }
            let tilt = acos_clamped(axis.z);
            let turn = atan2(axis.x, axis.y);
            ![1.0, -1.0].iter().any(|sign| {
                let (a, c) =
                    (sign * tilt, if *sign > 0.0 { turn } else { turn + core::f64::consts::PI });
                let (x, y) = (cos(c) * tip.x - sin(c) * tip.y, sin(c) * tip.x + cos(c) * tip.y);
                is_in(DVec3::new(x, cos(a) * y - sin(a) * tip.z, sin(a) * y + cos(a) * tip.z))
            })
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cutter::Pose;
    use crate::part::tests::sheet;
    use evencut_core::job;

    /// A ball of 5 mm over a plane of 20 mm in passes 1 mm apart, and the case to judge it.
    fn case<'a>(job: &'a Job, report: &'a Report, tip: impl Fn(f64, f64) -> DVec3) -> Case<'a> {
        let mut rows = Vec::new();
        for i in -10..=10 {
            for x in [-12.0, 12.0] {
                let x = if i % 2 == 0 { x } else { -x };
                let pose = Pose { tip: tip(x, f64::from(i)), axis: DVec3::Z };
                rows.push(Row { kind: "cut".into(), pass: 0, pose, feed: 600.0, time: 0.0 });
            }
        }
        let cutter = Cutter { radius: 5.0, corner: 5.0, length: f64::INFINITY };
        let sweep = Sweep::new(&rows, cutter);
        let (design, rest) = (Mesh::of(sheet(10.0, 20, |_, _| 0.0)), Mesh::of(Vec::new()));
        let (random, out) = (Random::new(7), Findings::default());
        Case { job, report, rows, sweep, design, rest, random, out }
    }

    fn job_of(more: &str) -> Job {
        let text = format!(
            "version = 1\n[surface.analytic]\nkind = \"plane\"\nsize = 20.0\nresolution = 2.0\n[tool]\ndiameter = \
             10.0\n[cut]\nfeed = 600.0\ntolerance = 0.005\n{more}\n[force]\ncontrol = \"off\"\n"
        );
        job::read(text.as_bytes()).unwrap().job
    }

    fn report_of(job: &Job) -> Report {
        let input = evencut_service::results::Input { name: "plane.toml", bytes: b"" };
        let options = evencut_service::results::ResultsOptions { threads: 1, verify: false };
        let files = evencut_core::plan::Files::default();
        evencut_service::results::results(job, input, files, options, &mut |_, _| {})
            .unwrap()
            .report
    }

    /// Passes 1 mm apart leave `5 - sqrt(25 - 0.25)` = 25.06 µm.
    #[test]
    fn cusps_on_a_plane_are_found_to_a_tenth_of_a_micrometre() {
        for (scallop, breaks) in [(0.0245, false), (0.0195, true)] {
            let job = job_of(&format!("scallop = {scallop}"));
            let report = report_of(&job);
            let mut case = case(&job, &report, |x, y| DVec3::new(x, y, 0.0));
            case.residual();
            let figure = &case.out.figures[0];
            assert!(figure.starts_with("residual 25.1 of"), "{figure}");
            assert_eq!(!case.out.failures.is_empty(), breaks, "{figure}");
            case.gouges();
            assert_eq!(case.out.failures.len(), usize::from(breaks));
        }
    }

    /// A pass 20 µm too deep.
    #[test]
    fn a_gouge_is_found_as_deep_as_it_is() {
        let job = job_of("scallop = 0.03");
        let report = report_of(&job);
        let deep = |x: f64, y: f64| DVec3::new(x, y, if y == 3.0 { -0.02 } else { 0.0 });
        let mut case = case(&job, &report, deep);
        case.gouges();
        assert_eq!(case.out.failures.len(), 1);
        let place = Place { at: DVec3::new(1.0, 3.0, 0.0), normal: DVec3::Z };
        assert!((case.depth(&place, 0.0) - 0.02).abs() < 1e-4);
        // What is left over an allowance of 0.1 mm that is cut away.
        assert!((case.depth(&place, 0.1) - 0.12).abs() < 1e-4);
    }

    /// The cusp of a sphere: passes along meridians of a dome.
    #[test]
    fn cusps_on_a_dome_are_those_of_two_circles() {
        let job = job_of("scallop = 0.05");
        let report = report_of(&job);
        let mut case = case(&job, &report, |x, y| DVec3::new(x, y, 0.0));
        let dome = |x: f64, y: f64| (900.0 - x * x - y * y).sqrt() - 30.0;
        case.design = Mesh::of(sheet(8.0, 160, dome));
        // Contacts on two circles around the X axis, 0.1 rad apart: side step 3 mm.
        let mut rows = Vec::new();
        for angle in [-0.05, 0.05] {
            for k in -40..=40 {
                // To and fro, for no move through the dome.
                let t = 0.08 * f64::from(k) * angle;
                let normal = DVec3::new(sin(t), cos(t) * sin(angle), cos(t) * cos(angle));
                let tip = normal * 35.0 - DVec3::Z * 35.0;
                let pose = Pose { tip, axis: DVec3::Z };
                rows.push(Row { kind: "cut".into(), pass: 0, pose, feed: 600.0, time: 0.0 });
            }
        }
        case.sweep = Sweep::new(&rows, case.sweep.cutter);
        let place = case.design.nearest(DVec3::ZERO, 1.0).unwrap();
        // Along the normal in the middle: the ball's centre 35 from the dome's, 0.05 rad aside.
        let (across, along) = (35.0 * sin(0.05), 35.0 * cos(0.05));
        let height = along - (25.0 - across * across).sqrt() - 30.0;
        assert!((case.height(&place) - height).abs() < 1e-3, "{} {height}", case.height(&place));
    }
}
