//! What is reported of a plan.

use super::hub::HubFigures;
use super::path::{PathFigures, PlaneFigures};
use super::record::{FileRecord, Versions};
use super::regions::DivisionFigures;
use super::setup::SetupFigures;
use super::tensor::TensorFigures;
use super::texture::TextureFigures;
use super::verification::VerificationFigures;
use evencut_core::geometry::math::acos_clamped;
use evencut_core::toolpath::{MoveKind, Toolpath};
use serde::Serialize;

/// Angle by which the axis stands off the lead where it counts as tilted, rad: turning between two points makes less.
const OFF_LEAD: f64 = 5.0 / 180.0 * core::f64::consts::PI;

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
    /// What is to be set up at the machine; null in comparisons, which write no program.
    pub setup: Option<SetupFigures>,
    /// The channels of a hub; missing for other patterns.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub hub: Option<HubFigures>,
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
    /// The plain passes, slowed only where a limit would be exceeded; null where that is not controlled, or where it
    /// would be too slow.
    pub slowed_locally: Option<PathFigures>,
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
    /// What of the selection is not machined in this setup; null where it is machined as it is.
    pub set_aside: Option<AsideFigures>,
}

/// Areas of a part that are not machined in one setup, by cause, and where the cutter bridges it.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct AsideFigures {
    /// Area that was selected, mm².
    pub selected_mm2: f64,
    /// Area that faces away from the tool axis, mm².
    pub away_mm2: f64,
    /// Area that is steeper than `surface.steepest`, mm².
    pub steep_mm2: f64,
    /// Area that lies under something else, mm².
    pub shadowed_mm2: f64,
    /// Area of pieces that are too small for passes, mm².
    pub small_mm2: f64,
    /// Area over which the cutter bridges the part, mm²: corners and grooves narrower than the cutter.
    pub bridged_mm2: f64,
    /// How much lower the part is there at most, mm.
    pub deepest_bridged_mm: f64,
}

/// Quality of the flat map.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct FlattenFigures {
    /// abf, bff, unfolded (a conformal map, changed where it would turn faces over or overlap), view (along the tool axis,
    /// where the surface is what the cutter reaches of a part) or parameters (those of a hub).
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
    /// Ways out of passes and back that close cores and corners.
    pub branches: u64,
    /// Their length on the surface, out and back, mm.
    pub branch_length_mm: f64,
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
    /// Where the tool axis is tilted off the job's lead; null where it is nowhere.
    pub tilted: Option<TiltFigures>,
}

/// Cutting moves whose tool axis is tilted off the job's lead by more than 5 degrees, mostly for shank or holder to clear.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct TiltFigures {
    /// Largest angle between the axis and the surface normal.
    pub largest_deg: f64,
    /// Tip of the tool there.
    pub largest_at_mm: [f64; 3],
    /// Length of these moves.
    pub length_mm: f64,
}

impl TiltFigures {
    /// Of a path that was planned with a lead, rad; `None` where its axis is nowhere off it.
    pub fn of(path: &Toolpath, lead: f64) -> Option<Self> {
        let mut figures: Option<Self> = None;
        for pair in path.points.windows(2) {
            let (from, to) = (&pair[0], &pair[1]);
            let tilt = acos_clamped(to.axis.dot(to.normal));
            if to.kind != MoveKind::Cut || (tilt - lead).abs() <= OFF_LEAD {
                continue;
            }
            let own = figures.get_or_insert(Self {
                largest_deg: 0.0,
                largest_at_mm: to.tip.to_array(),
                length_mm: 0.0,
            });
            own.length_mm += from.tip.distance(to.tip);
            if tilt.to_degrees() > own.largest_deg {
                (own.largest_deg, own.largest_at_mm) = (tilt.to_degrees(), to.tip.to_array());
            }
        }
        figures
    }
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
    /// off, fastest, trochoid or feed.
    pub control: String,
    /// Limit of the removal rate, mm³/min; where power or force are limited instead, the rate of a straight pass at the
    /// full feed that has that power.
    pub limit_mm3_per_min: f64,
    /// Removal rate of a straight pass at the nominal side step, mm³/min.
    pub straight_pass_mm3_per_min: f64,
    /// Limit on the angle of engagement, degrees; null where there is none.
    pub max_engagement_deg: Option<f64>,
    /// Limit on the feed per tooth, mm; null where there is none.
    pub min_chip_mm: Option<f64>,
    /// Feed per tooth below which trochoids are preferred, mm; null where they are not, or where there is a limit.
    pub preferred_chip_mm: Option<f64>,
    /// Limit on the power, W; null where there is none.
    pub power_w: Option<f64>,
    /// Limit on the mean cutting force, N; null where there is none.
    pub cutting_force_n: Option<f64>,
    /// Intervals of the plain passes above the limit; null where the rate is not controlled.
    pub over_limit_intervals: Option<u64>,
    /// Trochoid loops in the delivered path.
    pub trochoid_loops: u64,
    /// How the plane predicts the rate of the delivered path; null where the rate is not controlled.
    pub plane: Option<PlaneFigures>,
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
    pub inaccessible_mm2: f64,
    /// Where it is highest, mm; null if there is none.
    pub inaccessible_at_mm: Option<[f64; 3]>,
    /// Spheres that hold all of it: x, y, z, radius, mm.
    pub inaccessible_places: Vec<[f64; 4]>,
}

/// Where the cutter does not fit.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct GougeFigures {
    /// Spans of the path on which the cutter was lifted to clear the part.
    pub lifted: Vec<LiftedSpan>,
}

/// A span of the path on which the cutter was lifted.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct LiftedSpan {
    /// Tool tip where the span begins, mm.
    pub from_mm: [f64; 3],
    /// Its length, mm.
    pub length_mm: f64,
    /// The largest lift, mm.
    pub lifted_by_mm: f64,
}
