//! What is told of a plan: numbers with stable keys, a summary for the terminal, a page.
//!
//! Keys carry their units. The numbers are written with six significant digits, so that the bytes
//! of [`Report::to_json`] depend on nothing but the plan.

mod json;
mod page;
mod profile;
mod regions;
mod summary;
mod tensor;
mod texture;
mod verification;

pub(crate) use page::escaped;
pub use profile::Profile;
pub use regions::{DivisionFigures, PieceFigures, SpacingFigures, UndividedFigures};
pub use tensor::{PointFigures, TensorFigures};
pub use texture::{
    ArealFigures, CuttingFigures, ProfileFigures, TextureFigures, WindowFigures, WorkFigures,
};
pub use verification::{
    CuspFigures, FaultFigures, Lines, MrrFigures, RegionFigures, ScallopFigures, SlopeFigures,
    SpotFigures, VerificationFigures, VerificationReport, WallCutFigures,
};

use crate::toolpath::{MoveKind, Toolpath};
use serde::Serialize;
use sha2::{Digest, Sha256};

/// Version of the report's keys: grows when one changes its meaning or goes away.
pub const FORMAT: u32 = 1;

/// The report of one plan.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct Report {
    /// Version of these keys.
    pub format: u32,
    /// Name of the job.
    pub job: String,
    /// What made the plan.
    pub versions: Versions,
    /// Files that were read.
    pub inputs: Vec<FileRecord>,
    /// The surface that is machined.
    pub surface: SurfaceFigures,
    /// What was mended in the mesh, in words.
    pub repairs: Vec<String>,
    /// What a reader should know before cutting.
    pub warnings: Vec<Warning>,
    /// Quality of the flat map.
    pub flatten: FlattenFigures,
    /// The passes.
    pub passes: PassFigures,
    /// The regions; missing where the surface is not divided.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub regions: Option<DivisionFigures>,
    /// Where the best feed direction is undefined; missing where the surface is not divided by it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tensor: Option<TensorFigures>,
    /// The side step.
    pub stepover: StepoverFigures,
    /// Limit and measured removal rate.
    pub force: ForceFigures,
    /// The plain passes at the nominal feed; null where the removal rate is not controlled.
    pub plain: Option<PathFigures>,
    /// The plain passes at the one feed that respects the limit; null where it is not controlled.
    pub slowed: Option<PathFigures>,
    /// The path that is delivered.
    pub delivered: PathFigures,
    /// What the cutter reaches.
    pub coverage: CoverageFigures,
    /// Where the cutter does not fit.
    pub gouge: GougeFigures,
    /// What a simulation of the path measured, independently of the plan; null where it was not run.
    pub verification: Option<VerificationFigures>,
    /// The texture that the teeth leave in the job's window; missing where the job has none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub texture: Option<TextureFigures>,
    /// Files that were written.
    pub outputs: Vec<FileRecord>,
}

/// Versions of what made a plan.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct Versions {
    /// Version of evencut.
    pub evencut: String,
    /// Version of the job file's format.
    pub job_file: u32,
}

/// A file and what identifies it.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct FileRecord {
    /// File name relative to the job, or to the folder of the results.
    pub name: String,
    /// Length, bytes.
    pub bytes: u64,
    /// SHA-256 of the content, hexadecimal.
    pub sha256: String,
}

/// A warning and what can be done.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct Warning {
    /// Stage that warns.
    pub stage: String,
    /// What was found, with its measured value.
    pub message: String,
    /// What would mend it; empty where the message says it all.
    pub remedy: String,
}

/// The surface that is machined.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct SurfaceFigures {
    /// Area, mm².
    pub area_mm2: f64,
    /// Number of triangles.
    pub faces: u64,
    /// Number of vertices.
    pub vertices: u64,
    /// Number of boundary loops; more than one means holes.
    pub boundary_loops: u64,
    /// Lower corner of the bounding box, mm.
    pub box_low_mm: [f64; 3],
    /// Upper corner of the bounding box, mm.
    pub box_high_mm: [f64; 3],
    /// Smallest concave radius of curvature, mm; null where nothing is concave.
    pub smallest_concave_radius_mm: Option<f64>,
    /// Where that is, mm.
    pub smallest_concave_at_mm: Option<[f64; 3]>,
    /// Area that is more concave than the cutter is convex, mm²: the cutter does not fit there.
    pub too_concave_mm2: f64,
}

/// Quality of the flat map.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct FlattenFigures {
    /// abf or bff.
    pub method: String,
    /// Iterations until the constraints were met.
    pub iterations: u64,
    /// Largest violation of the constraints, rad.
    pub constraint_residual: f64,
    /// Quasi-conformal error of the triangles, mean by area; 1 is conformal.
    pub quasi_conformal_mean: f64,
    /// Largest quasi-conformal error.
    pub quasi_conformal_max: f64,
    /// Smallest scale, mm on the surface per flat mm.
    pub scale_min: f64,
    /// Largest scale, mm on the surface per flat mm.
    pub scale_max: f64,
    /// Number of flipped triangles.
    pub flips: u64,
}

/// The passes.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct PassFigures {
    /// Pattern of the job.
    pub pattern: String,
    /// Number of passes.
    pub count: u64,
    /// Depth of the tree of rings.
    pub tree_depth: u64,
    /// Cores between the last passes that needed closing.
    pub closed_cores: u64,
    /// Detours of passes that close cores and corners.
    pub spurs: u64,
    /// Their length on the surface, out and back, mm.
    pub spur_length_mm: f64,
    /// Largest distance of a place near a ridge of the passes' field from the nearest pass, in side
    /// steps; half between parallel passes.
    pub widest_gap_passes: f64,
    /// Shortest length that passes on the surface can have, mm: the integral of one over the widest strip.
    pub length_floor_mm: f64,
    /// Length of the passes' contacts on the surface, mm.
    pub length_mm: f64,
    /// That length as a multiple of the floor.
    pub length_over_floor: f64,
    /// How often the cutter leaves the part to go on elsewhere.
    pub retracts: u64,
    /// Share of the area on which neighbouring passes are at least 0.9 of the allowed side step apart, by
    /// the passes' field.
    pub even_share: f64,
}

/// The side step.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct StepoverFigures {
    /// Nominal side step on the surface, mm.
    pub nominal_mm: f64,
    /// Nominal side step as a share of the cutter radius.
    pub over_radius: f64,
}

/// Limit and removal rate of the delivered path.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct ForceFigures {
    /// off, trochoid or feed.
    pub control: String,
    /// Limit of the removal rate, mm³/min.
    pub limit_mm3_per_min: f64,
    /// Removal rate of a straight pass at the nominal side step, mm³/min.
    pub straight_pass_mm3_per_min: f64,
    /// Intervals of the plain passes above the limit; null where the rate is not controlled.
    pub over_limit_intervals: Option<u64>,
    /// Trochoid loops in the delivered path.
    pub trochoid_loops: u64,
}

/// A value for each kind of move and their sum.
#[derive(Copy, Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct ByKind {
    /// Along passes.
    pub cut: f64,
    /// Cutting parts of trochoids.
    pub trochoid: f64,
    /// Parts of trochoids that cut nothing.
    #[serde(rename = "return")]
    pub return_: f64,
    /// Links at feed.
    pub link: f64,
    /// Rapids.
    pub rapid: f64,
    /// All moves.
    pub total: f64,
}

impl ByKind {
    /// Adds to a kind and to the sum.
    pub fn add(&mut self, kind: MoveKind, value: f64) {
        let slot = match kind {
            MoveKind::Cut => &mut self.cut,
            MoveKind::Trochoid => &mut self.trochoid,
            MoveKind::Return => &mut self.return_,
            MoveKind::Link => &mut self.link,
            MoveKind::Rapid => &mut self.rapid,
        };
        *slot += value;
        self.total += value;
    }

    /// The values with names to read, the sum last.
    pub fn rows(&self) -> [(&'static str, f64); 6] {
        [
            ("cut", self.cut),
            ("trochoid", self.trochoid),
            ("trochoid return", self.return_),
            ("link", self.link),
            ("rapid", self.rapid),
            ("total", self.total),
        ]
    }
}

/// Length, time and removal rate of a path.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct PathFigures {
    /// Nominal feed, mm/min.
    pub feed_mm_per_min: f64,
    /// Length of the tool tip's path by kind of move, mm.
    pub length_mm: ByKind,
    /// Time with the feeds as commanded by kind of move, s.
    pub time_s: ByKind,
    /// Time under the machine's limits by kind of move, s.
    pub machine_time_s: ByKind,
    /// Predicted removal rate; these keys are missing where it is not controlled.
    #[serde(flatten)]
    pub rate: Option<RateFigures>,
}

/// Predicted removal rate of a path.
#[derive(Copy, Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct RateFigures {
    /// Largest removal rate, mm³/min.
    pub peak_mm3_per_min: f64,
    /// Mean removal rate while cutting, mm³/min.
    pub mean_mm3_per_min: f64,
    /// Coefficient of variation of the removal rate while cutting.
    pub variation: f64,
    /// Largest removal rate as a multiple of the limit.
    pub peak_over_limit: f64,
}

impl RateFigures {
    /// Figures of a path whose points tell their rate; `limit`: mm³/s.
    pub fn of(path: &Toolpath, limit: f64) -> Self {
        let profile = Profile::of(path);
        let peak = profile.peak();
        Self {
            peak_mm3_per_min: 60.0 * peak,
            mean_mm3_per_min: 60.0 * profile.mean_while_cutting(),
            variation: profile.variation_while_cutting(),
            peak_over_limit: peak / limit,
        }
    }
}

impl PathFigures {
    /// Figures of a path; `feed`: nominal, mm/s, `machine_time`: s by kind.
    pub fn of(path: &Toolpath, feed: f64, machine_time: ByKind, rate: Option<RateFigures>) -> Self {
        let (mut length, mut time) = (ByKind::default(), ByKind::default());
        for pair in path.points.windows(2) {
            length.add(pair[1].kind, pair[0].tip.distance(pair[1].tip));
            time.add(pair[1].kind, pair[1].time - pair[0].time);
        }
        Self {
            feed_mm_per_min: 60.0 * feed,
            length_mm: length,
            time_s: time,
            machine_time_s: machine_time,
            rate,
        }
    }
}

/// What the cutter reaches.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct CoverageFigures {
    /// Area of the surface, mm².
    pub area_mm2: f64,
    /// Height of the cusps that are meant to stay, mm: the scallop asked for, or the highest that the
    /// side step leaves.
    pub cusp_limit_mm: f64,
    /// Area where more than that and the tolerance is left although the cutter could touch, mm².
    pub never_covered_mm2: f64,
    /// The same as a share of the area, percent.
    pub never_covered_percent: f64,
    /// Area where more is left because the cutter cannot touch, mm².
    pub too_tight_mm2: f64,
    /// Where it is highest, mm; null if there is none.
    pub too_tight_at_mm: Option<[f64; 3]>,
    /// Spheres that hold all of it: x, y, z, radius, mm.
    pub too_tight_places: Vec<[f64; 4]>,
}

/// Where the cutter does not fit.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct GougeFigures {
    /// Stretches on which the cutter was raised to clear the part.
    pub raised: Vec<RaisedStretch>,
}

/// A stretch on which the cutter was raised.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct RaisedStretch {
    /// Tool tip where the stretch begins, mm.
    pub from_mm: [f64; 3],
    /// Its length, mm.
    pub length_mm: f64,
    /// The largest raise, mm.
    pub raised_by_mm: f64,
}

impl FileRecord {
    /// The record of a file with this content.
    pub fn of(name: &str, content: &[u8]) -> Self {
        let digest = Sha256::digest(content);
        let sha256 = digest.iter().map(|byte| format!("{byte:02x}")).collect();
        Self { name: name.to_owned(), bytes: content.len() as u64, sha256 }
    }
}

impl Report {
    /// The report as JSON, keys in the order of the types, six significant digits.
    ///
    /// Values that are not finite become null.
    pub fn to_json(&self) -> String {
        json::pretty(self)
    }

    /// One screen of text for a terminal.
    pub fn summary(&self) -> String {
        summary::summary(self)
    }

    /// A page with tables and pictures that asks for nothing from outside.
    ///
    /// `pictures`: heading and SVG text of each.
    pub fn to_html(&self, pictures: &[(&str, &str)]) -> String {
        page::page(self, pictures)
    }
}

#[cfg(test)]
mod documentation;
#[cfg(test)]
mod samples;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::DVec3;
    use crate::toolpath::PathPoint;

    #[test]
    fn digest_of_the_standard_example() {
        let record = FileRecord::of("a", b"abc");
        assert_eq!(
            record.sha256,
            "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad"
        );
        assert_eq!(record.bytes, 3);
    }

    fn point(kind: MoveKind, x: f64, mrr: f64, time: f64) -> PathPoint {
        PathPoint {
            kind,
            pass: 0,
            region: 0,
            tip: DVec3::new(x, 0.0, 0.0),
            axis: DVec3::Z,
            normal: DVec3::Z,
            flat: None,
            feed: 1.0,
            mrr,
            alpha: 0.0,
            time,
        }
    }

    #[test]
    fn figures_of_a_small_path() {
        let path = Toolpath {
            points: vec![
                point(MoveKind::Rapid, 0.0, 0.0, 0.0),
                point(MoveKind::Cut, 10.0, 2.0, 3.0),
                point(MoveKind::Cut, 12.0, 4.0, 4.0),
                point(MoveKind::Link, 15.0, 0.0, 6.0),
            ],
        };
        let rate = RateFigures::of(&path, 8.0);
        let f = PathFigures::of(&path, 5.0, ByKind::default(), Some(rate));
        assert_eq!((f.length_mm.cut, f.length_mm.link, f.length_mm.total), (12.0, 3.0, 15.0));
        assert_eq!((f.time_s.cut, f.time_s.link, f.time_s.total), (4.0, 2.0, 6.0));
        assert_eq!((rate.peak_mm3_per_min, rate.peak_over_limit), (240.0, 0.5));
        // Three seconds at 2 and one at 4: mean 2.5, variance 0.75.
        assert_eq!(rate.mean_mm3_per_min, 150.0);
        assert!((rate.variation - 0.75f64.sqrt() / 2.5).abs() < 1e-12);
    }
}
