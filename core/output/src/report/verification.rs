//! What the judge found, as numbers with stable keys and as text.

use super::hub::HubVerdict;
use super::json;
use super::record::{FileRecord, Versions};
use evencut_core::geometry::DVec3;
use evencut_core::tool::AssemblyPart;
use evencut_core::units::per_minute;
use evencut_core::verify::{
    self, Avoided, Band, Broken, Crests, Fault, Load, LoadOptions, MRR_NOISE, Nearest, Quantity,
    Spot, Verification, VerifyOptions, WallFigures, Window, Worst,
};
use serde::Serialize;
use std::fmt::Write;

/// Faulty moves listed at most; their number is reported.
const MOST_LISTED: usize = 20;
/// Depths of cuts into walls are given in mm from this one on, mm.
const MILLIMETRES: f64 = 0.1;
/// Lower ends of the slope bands, degrees; the last band ends at 180.
const SLOPES: [f64; 5] = [0.0, 15.0, 30.0, 45.0, 60.0];

/// What a simulation of the path measured, independently of the plan.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct VerificationFigures {
    /// Whether every limit is kept.
    pub passed: bool,
    /// The limits that are broken, in words.
    pub broken: Vec<String>,
    /// What may keep them, by the keys of a job.
    pub remedies: Vec<String>,
    /// Area that was judged, mm²; what lies where the cutter does not fit is apart.
    pub area_mm2: f64,
    /// Number of samples.
    pub samples: u64,
    /// Distance of samples, mm.
    pub spacing_mm: f64,
    /// What is left above the surface along its normal.
    pub scallop: ScallopFigures,
    /// The cusps between neighbouring passes, from sections across these; null where none was found.
    pub cusps: Option<CuspFigures>,
    /// The same by slope of the surface against the Z axis.
    pub by_slope: Vec<SlopeFigures>,
    /// The same by region of the path.
    pub by_region: Vec<RegionFigures>,
    /// Deepest cut into the part, mm; 0 or positive where nothing is cut into.
    pub gouge_mm: f64,
    /// Where, mm.
    pub gouge_at_mm: Option<[f64; 3]>,
    /// Line of the path that cut it.
    pub gouge_by_line: Option<u64>,
    /// Whether it may be deeper: gouges are measured up to half the cutter radius.
    pub gouge_may_be_deeper: bool,
    /// Area cut into deeper than the tolerance, mm².
    pub gouged_mm2: f64,
    /// Cuts into the walls around what is machined; null where there are none but the part's own faces.
    pub walls: Option<WallCutFigures>,
    /// Cuts into the stock, along the normal of where it ends; null where the job does not say where that is.
    pub stock: Option<StockCutFigures>,
    /// Area that no move reached, mm².
    pub untouched_mm2: f64,
    /// A place of it, mm.
    pub untouched_at_mm: Option<[f64; 3]>,
    /// Area where the plan says that the cutter does not fit, mm².
    pub inaccessible_mm2: f64,
    /// Largest residual there, mm.
    pub inaccessible_residual_mm: f64,
    /// Part of that area on which more than the limit on the scallop is left, mm²: the rest for a smaller cutter.
    pub rest_mm2: f64,
    /// Greatest height left on it, mm.
    pub rest_height_mm: f64,
    /// Measured removal rate; null where the depth of the stock is not known.
    pub mrr: Option<MrrFigures>,
    /// What was asked of the cutter at worst; null where the depth of the stock or the teeth are not known.
    pub load: Option<LoadFigures>,
    /// How far shank and holder stay clear of part and stock, as far as they are known and can come near.
    pub above_cutter: Vec<AboveCutterFigures>,
    /// How far the tool stays away from each mesh that it avoids.
    pub avoided: Vec<AvoidedFigures>,
    /// Number of rapids that touch stock or part.
    pub rapids_in_stock: u64,
    /// The first of them.
    pub rapids: Vec<FaultFigures>,
    /// Number of moves at feed that state none.
    pub moves_without_feed: u64,
    /// The first of them.
    pub without_feed: Vec<FaultFigures>,
    /// What a check of the program found, in words.
    pub program: Vec<String>,
}

/// Cuts into the walls around what is machined.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct WallCutFigures {
    /// Area of the walls as far up as the cutter goes, mm².
    pub area_mm2: f64,
    /// Depth of the deepest cut, mm; 0 where nothing is cut into.
    pub deepest_mm: f64,
    /// Where, mm.
    pub deepest_at_mm: Option<[f64; 3]>,
    /// Line of the path that cut it.
    pub deepest_by_line: Option<u64>,
    /// Whether it may be deeper: cuts into walls are measured up to the cutter's diameter.
    pub may_be_deeper: bool,
    /// Area of wall cut into deeper than the tolerance, mm².
    pub cut_mm2: f64,
}

/// Cuts into the stock where the job says where it ends: over the surface and beside it.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct StockCutFigures {
    /// How deep the cutter may go at once, mm: what is cut over the surface, and the tolerance.
    pub allowed_mm: f64,
    /// Depth of the deepest cut, mm; 0 where nothing is cut into.
    pub deepest_mm: f64,
    /// Where, mm.
    pub deepest_at_mm: Option<[f64; 3]>,
    /// Line of the path that cut it.
    pub deepest_by_line: Option<u64>,
    /// Whether it may be deeper: cuts into stock are measured up to the cutter's diameter.
    pub may_be_deeper: bool,
}

impl StockCutFigures {
    fn line(&self) -> String {
        let deepest = at_least(self.may_be_deeper).to_owned() + &format!("{:.3}", self.deepest_mm);
        format!(
            "cut up to {deepest} mm deep at once, over the surface and beside ({:.3} allowed)",
            self.allowed_mm
        )
    }
}

/// What is left above the surface, mm.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct ScallopFigures {
    /// Limit, mm; null where there is none.
    pub limit_mm: Option<f64>,
    /// By how much the limit may be exceeded, mm.
    pub tolerance_mm: f64,
    /// Largest residual, mm.
    pub largest_mm: f64,
    /// Where, mm.
    pub largest_at_mm: Option<[f64; 3]>,
    /// What the largest residual may lie above the largest sample at most, mm.
    pub sampling_bound_mm: f64,
    /// Whether the limit is kept by the samples, but what may stand between them could break it.
    pub kept_within_sampling_bound: bool,
    /// Residual that 99 % of the area stay below, mm.
    pub p99_mm: f64,
    /// Residual that half of the area stays below, mm.
    pub p50_mm: f64,
    /// Mean, mm.
    pub mean_mm: f64,
    /// Area above the limit, mm².
    pub above_mm2: f64,
    /// The same, percent.
    pub above_percent: f64,
    /// Worst places above limit and tolerance: height and place, mm.
    pub spots: Vec<SpotFigures>,
}

/// Heights of the cusps between neighbouring passes; each stands for as much of the passes' length.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct CuspFigures {
    /// Number of cusps that were measured.
    pub count: u64,
    /// Share of the passes' sides that have none: no next pass, or near the boundary or the end of a pass.
    pub share_left_out: f64,
    /// Height that 5 % stay below, mm.
    pub p5_mm: f64,
    /// Height that half stay below, mm.
    pub p50_mm: f64,
    /// Height that 95 % stay below, mm.
    pub p95_mm: f64,
    /// Largest height, mm.
    pub largest_mm: f64,
    /// Where, mm.
    pub largest_at_mm: Option<[f64; 3]>,
    /// Share between 0.9 of the limit on the scallop and the limit; null where there is none.
    pub share_within: Option<f64>,
    /// Share above the limit.
    pub share_above: Option<f64>,
}

/// A place and the residual there.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct SpotFigures {
    /// Residual, mm.
    pub height_mm: f64,
    /// Where, mm.
    pub at_mm: [f64; 3],
    /// Line of the path that left it; null where no move came.
    pub line: Option<u64>,
}

/// Residual on a band of slopes.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct SlopeFigures {
    /// Lower end of the band, degrees.
    pub from_deg: f64,
    /// Its area, mm².
    pub area_mm2: f64,
    /// Part of it above the limit on the scallop, percent.
    pub above_percent: f64,
    /// Largest residual, mm.
    pub largest_mm: f64,
}

/// Residual on a region of the path.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct RegionFigures {
    /// Index of the region.
    pub region: u64,
    /// Its area, mm².
    pub area_mm2: f64,
    /// Part of it above the limit on the scallop, percent.
    pub above_percent: f64,
    /// Largest residual, mm.
    pub largest_mm: f64,
}

/// Removal rate over windows of a fifth of the cutter radius.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct MrrFigures {
    /// Limit, mm³/min; null where there is none.
    pub limit_mm3_per_min: Option<f64>,
    /// Largest measured rate, mm³/min.
    pub peak_mm3_per_min: f64,
    /// Tool tip there, mm.
    pub peak_at_mm: Option<[f64; 3]>,
    /// Line of the path there.
    pub peak_line: Option<u64>,
    /// Time there, s.
    pub peak_time_s: f64,
    /// Largest measured rate as a multiple of the limit.
    pub peak_over_limit: Option<f64>,
    /// Volume that was removed, mm³.
    pub removed_mm3: f64,
    /// Largest predicted rate over the same windows, mm³/min; null where the path predicts none.
    pub predicted_peak_mm3_per_min: Option<f64>,
    /// Root mean square of predicted less measured rate while cutting, mm³/min.
    pub rms_difference_mm3_per_min: Option<f64>,
    /// The same as a multiple of the limit.
    pub rms_difference_over_limit: Option<f64>,
    /// Largest difference of predicted and measured rate, mm³/min.
    pub largest_difference_mm3_per_min: Option<f64>,
    /// Tool tip there, mm.
    pub largest_difference_at_mm: Option<[f64; 3]>,
}

/// What was asked of the cutter at worst, over the same windows.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct LoadFigures {
    /// Largest angle of engagement on passes and loops, degrees, of a disc that takes the same volume.
    pub engagement_deg: f64,
    /// Its limit, degrees; null where there is none.
    pub engagement_limit_deg: Option<f64>,
    /// Smallest feed per tooth where passes and loops cut, mm.
    pub feed_per_tooth_mm: f64,
    /// Its limit, mm; null where there is none.
    pub feed_per_tooth_limit_mm: Option<f64>,
    /// Largest power, W; null where the material is not known.
    pub power_w: Option<f64>,
    /// Its limit, W; null where there is none.
    pub power_limit_w: Option<f64>,
    /// Largest mean cutting force, N; null where the material is not known.
    pub force_n: Option<f64>,
    /// Its limit, N; null where there is none.
    pub force_limit_n: Option<f64>,
}

impl LoadFigures {
    fn of(load: &Load, options: &LoadOptions) -> Self {
        let value = |worst: Worst| worst.map(|(value, _)| value);
        Self {
            engagement_deg: value(load.engaged).unwrap_or(0.0).to_degrees(),
            engagement_limit_deg: options.most_engaged.map(f64::to_degrees),
            feed_per_tooth_mm: value(load.per_tooth).unwrap_or(0.0),
            feed_per_tooth_limit_mm: options.least_per_tooth,
            power_w: value(load.power),
            power_limit_w: options.most_power,
            force_n: value(load.force),
            force_limit_n: options.most_force,
        }
    }

    /// On one line.
    fn line(&self) -> String {
        let of = |limit: Option<String>| limit.map_or_else(String::new, |l| format!(" of {l}"));
        let mut line = if self.engagement_deg == 0.0 {
            "engagement and feed per tooth not judged: a program does not tell passes from links"
                .to_owned()
        } else {
            format!(
                "engaged {:.0}{}°{}, at least {:.4} mm per tooth{}",
                self.engagement_deg,
                of(self.engagement_limit_deg.map(|l| format!("{l:.0}"))),
                self.engagement_limit_deg.map_or("", |l| scatter(self.engagement_deg, l)),
                self.feed_per_tooth_mm,
                self.feed_per_tooth_limit_mm
                    .map_or_else(String::new, |l| format!(" ({l:.4} asked)")),
            )
        };
        if let (Some(power), Some(force)) = (self.power_w, self.force_n) {
            let _ = write!(
                line,
                ", {power:.0}{} W{}, {force:.0}{} N{}",
                of(self.power_limit_w.map(|l| format!("{l:.0}"))),
                self.power_limit_w.map_or("", |l| scatter(power, l)),
                of(self.force_limit_n.map(|l| format!("{l:.0}"))),
                self.force_limit_n.map_or("", |l| scatter(force, l)),
            );
        }
        line
    }
}

/// Says of a value above its limit that the simulation is not closer than that.
fn scatter(value: f64, limit: f64) -> &'static str {
    const { assert!(MRR_NOISE == 1.03) };
    if value > limit { " (+ 3 % scatter allowed)" } else { "" }
}

/// How far shank or holder stay clear of part and stock.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct AboveCutterFigures {
    /// `shank` or `holder`.
    pub part: String,
    /// Least distance, mm; negative where it cuts in.
    pub clearance_mm: f64,
    /// Whether it is at least that: farther was not looked.
    pub is_at_least: bool,
    /// What was asked, mm.
    pub asked_mm: f64,
    /// The nearest place of the part, mm.
    pub at_mm: [f64; 3],
    /// Line of the path.
    pub line: Option<u64>,
}

fn above_cutter(verification: &Verification, lines: &Lines) -> Vec<AboveCutterFigures> {
    let nearest = verification.above.iter().flat_map(|above| &above.nearest);
    let figures = |n: &Nearest| AboveCutterFigures {
        part: n.part.name().to_owned(),
        clearance_mm: n.distance,
        is_at_least: n.is_farther,
        asked_mm: n.wanted.max(0.0),
        at_mm: n.place.to_array(),
        line: lines.of(n.of),
    };
    nearest.map(figures).collect()
}

/// How far the tool stays away from a mesh that it avoids, measured on every move.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct AvoidedFigures {
    /// What the mesh is called.
    pub name: String,
    /// The distance that was asked, mm.
    pub asked_mm: f64,
    /// Least distance of the tool, mm; negative where it cuts in.
    pub clearance_mm: f64,
    /// Whether it is at least that: farther was not looked.
    pub is_at_least: bool,
    /// The part of the tool that comes so near: `cutter`, `shank` or `holder`.
    pub part: String,
    /// The nearest place of the mesh, mm.
    pub at_mm: [f64; 3],
    /// Line of the path.
    pub line: Option<u64>,
}

fn avoided(
    verification: &Verification,
    options: &VerifyOptions,
    lines: &Lines,
) -> Vec<AvoidedFigures> {
    let all = options.avoided.iter().zip(&verification.avoided);
    let figures = |(avoided, figures): (&Avoided, &verify::AvoidedFigures)| {
        let n = figures.closest()?;
        Some(AvoidedFigures {
            name: avoided.name.clone(),
            asked_mm: avoided.distance,
            clearance_mm: n.distance,
            is_at_least: n.is_farther,
            part: n.part.name().to_owned(),
            at_mm: n.place.to_array(),
            line: lines.of(n.of),
        })
    };
    all.filter_map(figures).collect()
}

/// A move that may not be.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct FaultFigures {
    /// Line of the path.
    pub line: Option<u64>,
    /// Where, mm.
    pub at_mm: [f64; 3],
    /// How deep in material, mm.
    pub depth_mm: f64,
}

/// Lines of a path's points in the file they come from.
#[derive(Copy, Clone, Debug)]
pub enum Lines<'a> {
    /// A table with a header and a row a point.
    Table,
    /// As listed.
    Listed(&'a [u32]),
}

impl Lines<'_> {
    /// The line on which a move ends.
    fn of(&self, index: u32) -> Option<u64> {
        let point = index as usize + 1;
        match self {
            Self::Table => Some(point as u64 + 2),
            Self::Listed(lines) => lines.get(point).map(|&line| u64::from(line)),
        }
    }
}

fn percent(part: f64, of: f64) -> f64 {
    if of > 0.0 { 100.0 * part / of } else { 0.0 }
}

fn place(at: Option<DVec3>) -> Option<[f64; 3]> {
    at.map(|p| p.to_array())
}

impl VerificationFigures {
    /// The figures of a judged path. `program`: what a check of the program found.
    pub fn of(
        verification: &Verification,
        options: &VerifyOptions,
        lines: Lines,
        program: Vec<String>,
    ) -> Self {
        let f = &verification.figures;
        let broken: Vec<String> =
            f.broken.iter().map(|b| described(b, options, &lines)).chain(program.clone()).collect();
        let mut remedies: Vec<String> = Vec::new();
        for text in f.broken.iter().filter_map(remedy) {
            if !remedies.iter().any(|known| known == text) {
                remedies.push(text.to_owned());
            }
        }
        let faults = |faults: &[Fault]| {
            let figures = |f: &Fault| FaultFigures {
                line: lines.of(f.of),
                at_mm: f.place.to_array(),
                depth_mm: f.depth,
            };
            faults.iter().take(MOST_LISTED).map(figures).collect()
        };
        Self {
            passed: broken.is_empty(),
            broken,
            remedies,
            area_mm2: f.area,
            samples: f.samples as u64,
            spacing_mm: f.spacing,
            scallop: scallop(verification, options, &lines),
            cusps: cusps(&verification.crests, options.scallop),
            by_slope: SLOPES.iter().zip(&f.by_slope).map(|(&from, b)| slope(from, b)).collect(),
            by_region: f.by_region.iter().map(|(region, b)| of_region(*region, b)).collect(),
            gouge_mm: f.gouge.map_or(0.0, |g| g.height),
            gouge_at_mm: place(f.gouge.map(|g| g.place)),
            gouge_by_line: f.gouge.and_then(|g| g.of).and_then(|of| lines.of(of)),
            gouge_may_be_deeper: f.gouge_is_deeper,
            gouged_mm2: f.gouged,
            walls: f.walls.as_ref().map(|walls| cut_walls(walls, &lines)),
            stock: f.stock.as_ref().map(|stock| StockCutFigures {
                allowed_mm: options.most_into_stock(),
                deepest_mm: stock.deepest.map_or(0.0, |d| d.height),
                deepest_at_mm: place(stock.deepest.map(|d| d.place)),
                deepest_by_line: stock.deepest.and_then(|d| d.of).and_then(|of| lines.of(of)),
                may_be_deeper: stock.is_deeper,
            }),
            untouched_mm2: f.untouched.0,
            untouched_at_mm: place(f.untouched.1),
            inaccessible_mm2: f.inaccessible.area,
            inaccessible_residual_mm: f.inaccessible.largest,
            rest_mm2: f.inaccessible.above,
            rest_height_mm: if f.inaccessible.above > 0.0 { f.inaccessible.largest } else { 0.0 },
            mrr: mrr(verification, options, &lines),
            load: verification.load.zip(options.load).map(|(l, o)| LoadFigures::of(&l, &o)),
            above_cutter: above_cutter(verification, &lines),
            avoided: avoided(verification, options, &lines),
            rapids_in_stock: f.rapids.len() as u64,
            rapids: faults(&f.rapids),
            moves_without_feed: f.without_feed.len() as u64,
            without_feed: faults(&f.without_feed),
            program,
        }
    }

    /// What was measured: labels and lines, those of walls and of what is avoided only where there are some.
    pub fn short(&self) -> Vec<(&'static str, String)> {
        let walls = self.walls.as_ref().map(|walls| ("walls", self.walls_line(walls)));
        let gouge = self.gouge_line() + &self.above_line();
        let first = [("scallop", self.scallop_line()), ("gouge", gouge)];
        let last = [("reach", self.reach_line()), ("rate", self.rate_line())];
        let load = self.load.as_ref().map(|load| ("load", load.line()));
        let stock = self.stock.as_ref().map(|stock| ("stock", stock.line()));
        let avoided = self.avoided_line().map(|line| ("avoided", line));
        first.into_iter().chain(walls).chain(stock).chain(avoided).chain(last).chain(load).collect()
    }

    /// How far the tool stays away from what it avoids: of the mesh where least is left of the distance.
    fn avoided_line(&self) -> Option<String> {
        let spare = |a: &AvoidedFigures| a.clearance_mm - a.asked_mm;
        let a = self.avoided.iter().min_by(|a, b| spare(a).total_cmp(&spare(b)))?;
        let least = if a.is_at_least { "at least " } else { "" };
        let mut line = format!("{} {least}{:.3} mm from {}", a.part, a.clearance_mm, a.name);
        let _ = write!(line, " ({:.3} asked)", a.asked_mm);
        if self.avoided.len() > 1 {
            let _ = write!(line, ", least of {}", self.avoided.len());
        }
        Some(line)
    }

    /// How far shank and holder stay clear, after what is said of gouges.
    fn above_line(&self) -> String {
        let of = |n: &AboveCutterFigures| {
            let least = if n.is_at_least { "at least " } else { "" };
            format!("{} {least}{:.2}", n.part, n.clearance_mm)
        };
        let parts: Vec<String> = self.above_cutter.iter().map(of).collect();
        let asked = self.above_cutter.iter().map(|n| n.asked_mm).fold(0.0, f64::max);
        match parts.is_empty() {
            true => String::new(),
            false => format!("; {} mm clear ({asked:.2} asked)", parts.join(", ")),
        }
    }

    fn scallop_line(&self) -> String {
        let s = &self.scallop;
        let mut line = format!("largest {} µm", micrometres(s.largest_mm));
        if let Some(limit) = s.limit_mm {
            let _ = write!(
                line,
                " of {} µm allowed (+ {} µm tolerance)",
                given(limit),
                given(s.tolerance_mm)
            );
        }
        if self.scallop.kept_within_sampling_bound {
            let bound = micrometres(s.sampling_bound_mm);
            let _ = write!(line, "; narrow places between samples may be {bound} µm higher");
        }
        let _ = write!(line, ", P99 {}, mean {}", micrometres(s.p99_mm), micrometres(s.mean_mm));
        line
    }

    fn gouge_line(&self) -> String {
        if self.gouge_mm < -self.scallop.tolerance_mm {
            let at = self.gouge_at_mm.map_or_else(String::new, |p| format!(" at {}", spelled(p)));
            return format!(
                "{}{} µm deep{at}, {:.2} mm²",
                at_least(self.gouge_may_be_deeper),
                micrometres(-self.gouge_mm),
                self.gouged_mm2 + 0.0
            );
        }
        let (deepest, tolerance) = (micrometres(-self.gouge_mm), given(self.scallop.tolerance_mm));
        format!("none (deepest {deepest} µm, tolerance {tolerance} µm)")
    }

    fn walls_line(&self, walls: &WallCutFigures) -> String {
        let tolerance = self.scallop.tolerance_mm;
        if walls.deepest_mm > tolerance {
            let at =
                walls.deepest_at_mm.map_or_else(String::new, |p| format!(" at {}", spelled(p)));
            return format!(
                "cut {}{}{at}, {:.2} mm²",
                at_least(walls.may_be_deeper),
                depth_above(walls.deepest_mm, tolerance),
                walls.cut_mm2
            );
        }
        let (deepest, tolerance) = (micrometres(walls.deepest_mm), given(tolerance));
        format!("none cut (deepest {deepest} µm, tolerance {tolerance} µm)")
    }

    fn reach_line(&self) -> String {
        // No negative zero.
        let mut line = format!("{:.2} mm² untouched", self.untouched_mm2 + 0.0);
        if self.rest_mm2 > 0.0 {
            let _ = write!(
                line,
                ", {:.2} mm² rest for a smaller cutter ({} µm left)",
                self.rest_mm2,
                micrometres(self.rest_height_mm)
            );
        }
        let _ = write!(line, ", rapids in stock: {}", self.rapids_in_stock);
        line
    }

    fn rate_line(&self) -> String {
        let Some(mrr) = &self.mrr else {
            let why = match self.moves_without_feed {
                0 => "only with force.control in a job, with --depth in evencut verify",
                _ => "moves without a feed take no known time",
            };
            return format!("not measured: {why}");
        };
        let mut line = format!("peak {:.0} mm³/min", mrr.peak_mm3_per_min);
        if let Some(ratio) = mrr.peak_over_limit {
            let _ = write!(line, ", {ratio:.3} of the limit{}", scatter(ratio, 1.0));
        }
        match (mrr.rms_difference_over_limit, mrr.rms_difference_mm3_per_min) {
            (Some(part), _) => {
                let _ = write!(line, "; predicted differs by {:.1} % RMS", 100.0 * part);
            }
            (None, Some(rms)) => {
                let _ = write!(line, "; predicted differs by {rms:.0} mm³/min RMS");
            }
            (None, None) => {}
        }
        line
    }

    /// All of it as text for a reader.
    pub fn to_text(&self) -> String {
        let mut text = String::new();
        for (label, line) in self.short() {
            let _ = writeln!(text, "  {label:<10}{line}");
        }
        let s = &self.scallop;
        if let Some(cusps) = &self.cusps {
            let _ = writeln!(text, "  {:<10}{}", "cusps", cusps.line());
        }
        let _ = writeln!(
            text,
            "  {:<10}{} samples, {:.3} mm apart; narrow places between them may be {} µm higher",
            "sampled",
            self.samples,
            self.spacing_mm,
            micrometres(s.sampling_bound_mm)
        );
        let limited = s.limit_mm.is_some();
        let _ = writeln!(
            text,
            "\n  {:<14}{:>12}{:>14}{:>14}",
            "slope, deg",
            "area, mm²",
            if limited { "above, %" } else { "" },
            "largest, µm"
        );
        for (i, band) in self.by_slope.iter().enumerate() {
            let ends = match self.by_slope.get(i + 1) {
                Some(next) => format!("{:.0} to {:.0}", band.from_deg, next.from_deg),
                None => format!("{:.0} and above", band.from_deg),
            };
            let above = limited.then_some(band.above_percent);
            row(&mut text, &ends, band.area_mm2, above, band.largest_mm);
        }
        if self.by_region.len() > 1 {
            for r in &self.by_region {
                row(
                    &mut text,
                    &format!("region {}", r.region),
                    r.area_mm2,
                    limited.then_some(r.above_percent),
                    r.largest_mm,
                );
            }
        }
        if !s.spots.is_empty() {
            let _ = writeln!(text, "\n  worst scallops");
            for spot in &s.spots {
                let line = spot.line.map_or_else(String::new, |l| format!(", line {l}"));
                let (height, at) = (micrometres(spot.height_mm), spelled(spot.at_mm));
                let _ = writeln!(text, "    {height} µm at {at}{line}");
            }
        }
        text
    }
}

fn row(text: &mut String, name: &str, area: f64, above: Option<f64>, largest: f64) {
    let above = above.map_or_else(String::new, |above| format!("{above:.3}"));
    let largest = if area > 0.0 { micrometres(largest) } else { "-".to_owned() };
    let _ = writeln!(text, "  {name:<14}{area:>12.2}{above:>14}{largest:>14}");
}

/// A length in µm with one decimal.
fn micrometres(mm: f64) -> String {
    // No negative zero.
    format!("{:.1}", (1e4 * mm).round() / 10.0 + 0.0)
}

/// A limit or tolerance of a job in µm, also where it is less than the figures have decimals for.
fn given(mm: f64) -> String {
    let short = micrometres(mm);
    if (1e4 * mm).round() >= 5.0 || mm <= 0.0 {
        short
    } else {
        format!("{}", (1e6 * mm).round() / 1e3)
    }
}

fn at_least(may_be_more: bool) -> &'static str {
    if may_be_more { "at least " } else { "" }
}

/// A depth above a limit, with its unit.
fn depth_above(mm: f64, limit: f64) -> String {
    if mm >= MILLIMETRES {
        format!("{mm:.2} mm")
    } else {
        format!("{} µm", micrometres_above(mm, limit))
    }
}

/// A height above a limit, with as many digits as show that it is.
fn micrometres_above(mm: f64, limit: f64) -> String {
    let short = micrometres(mm);
    if short == micrometres(limit) { format!("{:.4}", 1e3 * mm) } else { short }
}

fn spelled([x, y, z]: [f64; 3]) -> String {
    format!("({x:.2}, {y:.2}, {z:.2})")
}

fn scallop(v: &Verification, options: &VerifyOptions, lines: &Lines) -> ScallopFigures {
    let f = &v.figures;
    let spot = |s: &Spot| SpotFigures {
        height_mm: s.height,
        at_mm: s.place.to_array(),
        line: s.of.and_then(|of| lines.of(of)),
    };
    ScallopFigures {
        limit_mm: options.scallop,
        tolerance_mm: options.tolerance,
        largest_mm: f.largest.map_or(0.0, |l| l.height),
        largest_at_mm: place(f.largest.map(|l| l.place)),
        sampling_bound_mm: f.sampling_bound,
        kept_within_sampling_bound: is_doubtful(v, options),
        p99_mm: f.p99,
        p50_mm: f.p50,
        mean_mm: f.mean,
        above_mm2: f.above,
        above_percent: percent(f.above, f.area),
        spots: f.spots.iter().map(spot).collect(),
    }
}

fn cut_walls(walls: &WallFigures, lines: &Lines) -> WallCutFigures {
    WallCutFigures {
        area_mm2: walls.area,
        deepest_mm: walls.deepest.map_or(0.0, |d| d.height),
        deepest_at_mm: place(walls.deepest.map(|d| d.place)),
        deepest_by_line: walls.deepest.and_then(|d| d.of).and_then(|of| lines.of(of)),
        may_be_deeper: walls.is_deeper,
        cut_mm2: walls.cut,
    }
}

fn cusps(crests: &Crests, limit: Option<f64>) -> Option<CuspFigures> {
    let shares = limit.map(|limit| crests.shares(limit));
    Some(CuspFigures {
        count: crests.heights.len() as u64,
        share_left_out: 1.0 - crests.measured_share(),
        p5_mm: crests.percentile(0.05)?,
        p50_mm: crests.percentile(0.5)?,
        p95_mm: crests.percentile(0.95)?,
        largest_mm: crests.percentile(1.0)?,
        largest_at_mm: place(crests.highest_at),
        share_within: shares.map(|s| s[0]),
        share_above: shares.map(|s| s[1]),
    })
}

impl CuspFigures {
    fn line(&self) -> String {
        let [low, half, high] = [self.p5_mm, self.p50_mm, self.p95_mm].map(micrometres);
        let mut line = format!(
            "P5 {low}, P50 {half}, P95 {high}, largest {} µm",
            micrometres(self.largest_mm)
        );
        if let (Some(within), Some(above)) = (self.share_within, self.share_above) {
            let _ = write!(
                line,
                "; {:.0} % from 0.9 of the limit to it, {:.1} % above",
                100.0 * within,
                100.0 * above
            );
        }
        line
    }
}

fn slope(from_deg: f64, band: &Band) -> SlopeFigures {
    SlopeFigures {
        from_deg,
        area_mm2: band.area,
        above_percent: percent(band.above, band.area),
        largest_mm: band.largest,
    }
}

fn of_region(region: u32, band: &Band) -> RegionFigures {
    RegionFigures {
        region: u64::from(region),
        area_mm2: band.area,
        above_percent: percent(band.above, band.area),
        largest_mm: band.largest,
    }
}

fn mrr(v: &Verification, options: &VerifyOptions, lines: &Lines) -> Option<MrrFigures> {
    let rate = &v.rate;
    let limit = options.mrr_limit;
    let peak = rate.peak.filter(|_| options.tells_rate)?;
    let predicted = rate.windows.iter().map(|w| w.predicted).fold(0.0, f64::max);
    let predicts = predicted > 0.0;
    let difference = |w: Window| w.predicted - w.measured;
    Some(MrrFigures {
        limit_mm3_per_min: limit.map(per_minute),
        peak_mm3_per_min: per_minute(peak.measured),
        peak_at_mm: Some(peak.place.to_array()),
        peak_line: lines.of(peak.of),
        peak_time_s: 0.5 * (peak.time[0] + peak.time[1]),
        peak_over_limit: limit.map(|l| peak.measured / l),
        removed_mm3: rate.volume,
        predicted_peak_mm3_per_min: predicts.then_some(per_minute(predicted)),
        rms_difference_mm3_per_min: predicts.then_some(per_minute(rate.rms_difference)),
        rms_difference_over_limit: limit.filter(|_| predicts).map(|l| rate.rms_difference / l),
        largest_difference_mm3_per_min: rate
            .largest_difference
            .filter(|_| predicts)
            .map(|w| per_minute(difference(w))),
        largest_difference_at_mm: place(
            rate.largest_difference.filter(|_| predicts).map(|w| w.place),
        ),
    })
}

/// Whether the largest residual is within limit and tolerance, but not with the sampling bound added.
fn is_doubtful(v: &Verification, options: &VerifyOptions) -> bool {
    let most = options.scallop.map_or(f64::INFINITY, |limit| limit + options.tolerance);
    let largest = v.figures.largest.map_or(0.0, |l| l.height);
    largest <= most && largest + v.figures.sampling_bound > most
}

/// A number of things, in words that fit it.
fn counted(count: usize, thing: &str) -> String {
    format!("{count} {thing}{}", if count == 1 { "" } else { "s" })
}

/// How deep something cuts in, which is known to a tenth of a millimetre.
fn up_to(depth: f64) -> String {
    if depth < 0.05 { "less than 0.1 mm".to_owned() } else { format!("up to {depth:.1} mm") }
}

/// What may keep a limit; `None` where its sentence says so.
fn remedy(broken: &Broken) -> Option<&'static str> {
    Some(match broken {
        Broken::Scallop { .. } => {
            "give a larger `cut.tolerance` or `cut.scallop`, or a mesh with facets shorter than passes are apart"
        }
        Broken::Gouge { .. } | Broken::Wall { .. } => {
            "use a smaller cutter, give a larger `cut.tolerance`, or machine what is reached (`surface.steepest`)"
        }
        Broken::Untouched { .. } => {
            "try another `path.start` or `path.pattern`, or a smaller cutter"
        }
        Broken::RemovalRate { .. } | Broken::Load { .. } => {
            "give a smaller `cut.axial_depth`, or `force.control = \"fastest\"`"
        }
        Broken::Stock { .. } => {
            "rough the stock down to `cut.axial_depth` over the part, beside the surface too, or keep the path off it (`[[avoid]]`)"
        }
        Broken::Rapid { .. } => "give a larger `machine.clearance`",
        _ => return None,
    })
}

/// A broken limit as a sentence.
fn described(broken: &Broken, options: &VerifyOptions, lines: &Lines) -> String {
    let at = |p: DVec3| spelled(p.to_array());
    let line = |of: u32| lines.of(of).map_or_else(String::new, |l| format!(", line {l}"));
    let left = |s: &Spot| match s.of {
        Some(of) => line(of),
        None if s.is_cut => ", left by an earlier operation".to_owned(),
        None => ", where no move came".to_owned(),
    };
    match broken {
        Broken::Scallop { worst, limit } => format!(
            "scallop of {} µm at {}{}; allowed are {} µm and {} µm of tolerance",
            micrometres_above(worst.height, limit + options.tolerance),
            at(worst.place),
            left(worst),
            given(*limit),
            given(options.tolerance)
        ),
        Broken::Gouge { worst, tolerance } => format!(
            "gouge of {} µm at {}{}; the tolerance is {} µm",
            micrometres_above(-worst.height, *tolerance),
            at(worst.place),
            left(worst),
            given(*tolerance)
        ),
        Broken::Wall { worst, is_deeper, tolerance } => format!(
            "cuts {}{} into the wall at {}{}; the tolerance is {}",
            at_least(*is_deeper),
            depth_above(worst.height, *tolerance),
            at(worst.place),
            left(worst),
            if worst.height >= MILLIMETRES {
                format!("{tolerance} mm")
            } else {
                format!("{} µm", given(*tolerance))
            }
        ),
        Broken::Stock { worst, is_deeper, limit } => format!(
            "cuts {}{:.3} mm deep into the stock at {}{}; {limit:.3} mm are cut at once",
            at_least(*is_deeper),
            worst.height,
            at(worst.place),
            left(worst)
        ),
        Broken::TooNear { nearest: n, farther_out } => {
            let part = n.part.name();
            let remedy = match (farther_out, n.part) {
                (Some(more), _) => format!("; {more:.0} mm more of stickout would clear it"),
                (None, AssemblyPart::Shank) => {
                    "; a longer tool.length or a thinner shank may clear it, more stickout does not"
                        .to_owned()
                }
                (None, _) => "; no longer stickout would clear it".to_owned(),
            };
            let how = match n.distance < 0.0 {
                true => format!("the {part} cuts {} into part or stock", up_to(-n.distance)),
                false => format!(
                    "the {part} stays only {:.3} mm clear of part and stock, asked are {:.3} mm,",
                    n.distance, n.wanted
                ),
            };
            format!("{how} at {}{}{remedy}", at(n.place), line(n.of))
        }
        Broken::Avoided { index, nearest: n, on_rapid, farther_out } => {
            let (part, name) = (n.part.name(), options.avoided.get(*index).map_or("", |a| &a.name));
            let remedy = match (farther_out, n.part) {
                (Some(more), _) => format!("{more:.0} mm more of stickout would clear it"),
                (None, AssemblyPart::Cutter) => {
                    "move it away, reduce its avoid.distance, or plan the path around it".to_owned()
                }
                (None, AssemblyPart::Shank) => {
                    "move it away, or use a longer tool.length or a thinner shank".to_owned()
                }
                (None, AssemblyPart::Holder) => "move it away, or use a slimmer holder".to_owned(),
            };
            let rapid = if *on_rapid { " on a rapid" } else { "" };
            let how = match n.distance < 0.0 {
                true => format!("the {part} cuts {} into {name:?}{rapid}", up_to(-n.distance)),
                false => format!(
                    "the {part} stays only {:.3} mm clear of {name:?}{rapid}, asked are {:.3} mm,",
                    n.distance, n.wanted
                ),
            };
            format!("{how} at {}{}; {remedy}", at(n.place), line(n.of))
        }
        Broken::FitsNowhere { area } => format!(
            "nothing could be verified: the cutter fits nowhere on the {area:.2} mm²; use a smaller one"
        ),
        Broken::Untouched { area, place } => {
            let few = if *area < 0.005 { "less than 0.01".into() } else { format!("{area:.2}") };
            format!("{few} mm² that no move reached, for example at {}", at(*place))
        }
        Broken::RemovalRate { worst, limit } => format!(
            "removal rate of {:.0} mm³/min, {:.3} of the limit, at {}{}",
            per_minute(worst.measured),
            worst.measured / limit,
            at(worst.place),
            line(worst.of)
        ),
        Broken::Load { quantity, value, limit, at: window } => {
            let what = match quantity {
                Quantity::Engagement => format!(
                    "the cutter is engaged over {:.1} degrees, allowed are {:.1},",
                    value.to_degrees(),
                    limit.to_degrees()
                ),
                Quantity::FeedPerTooth => {
                    format!("feed of {value:.5} mm per tooth, at least {limit:.5} are asked,")
                }
                Quantity::Power => {
                    format!("power of {value:.1} W, {:.3} of the limit,", value / limit)
                }
                Quantity::Force => {
                    format!("cutting force of {value:.1} N, {:.3} of the limit,", value / limit)
                }
            };
            format!("{what} at {}{}", at(window.place), line(window.of))
        }
        Broken::Rapid { count, worst } => format!(
            "{} through stock or part, {} µm deep at {}{}",
            counted(*count, "rapid"),
            micrometres(worst.depth),
            at(worst.place),
            line(worst.of)
        ),
        Broken::NoFeed { count, first } => format!(
            "{} at feed without a feed, the first to {}{}",
            counted(*count, "move"),
            at(first.place),
            line(first.of)
        ),
    }
}

/// The report of a path that was judged by itself.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct VerificationReport {
    /// Version of these keys.
    pub format: u32,
    /// What judged.
    pub versions: Versions,
    /// Files that were read.
    pub inputs: Vec<FileRecord>,
    /// What was found.
    pub verification: VerificationFigures,
    /// Distances from the blades of a hub; null for other paths.
    pub hub: Option<HubVerdict>,
}

impl VerificationReport {
    /// What was found, as text.
    pub fn to_text(&self) -> String {
        let hub = self.hub.as_ref().map(|hub| format!("  {:<10}{}\n", "hub", hub.line()));
        hub.unwrap_or_default() + &self.verification.to_text()
    }

    /// The report as JSON, six significant digits.
    pub fn to_json(&self) -> String {
        json::pretty(self)
    }
}

#[cfg(test)]
mod tests {
    use super::given;

    #[test]
    fn a_limit_is_never_told_as_none() {
        let told = |mm: f64| given(mm);
        assert_eq!(
            ["10.0", "0.1", "0.04", "0.001"].map(str::to_owned),
            [0.01, 1e-4, 4e-5, 1e-6].map(told)
        );
        assert_eq!(given(0.0), "0.0");
    }
}
