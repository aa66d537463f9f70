//! The job file as it is written: every key optional, in the job's own units.
//!
//! These types are the one description of the format. Their [schema](super::schema()) drives the
//! reading, is shipped for editors, and is printed as the reference.
//!
//! Attributes of a key: `x-unit` is its unit in a job with `units = "mm"`; `default` is a constant
//! default and `x-default` one that depends on other keys, both filled in by the resolution.

use schemars::JsonSchema;
use serde::{Deserialize, Deserializer, Serialize};

use super::cut::{CutDirection, Inaccessible};
use super::force::{FeedComponent, ForceControl, MaterialGroup};
use super::hub::{BladeSurface, HubChannels, HubPasses};
use super::output::Picture;
use super::path::{Boundary, FirstPass, Links, Parameter, Pattern, RingOrder, StartKey, Traverse};
use super::regions::{Compensation, DistortionMeasure, RegionMethod, RegionOrder};
use super::surface::{AnalyticKind, FlattenMethod};
use super::texture::TextureCells;
use crate::machine::{Arrangement, Carries, Coolant, SpindleDirection, WorkOffset};
use crate::tool::ToolKind;

/// The version of the format that is read and written.
pub const VERSION: u32 = 1;

/// A job: which surface to machine, with what, and how.
#[derive(Clone, Debug, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(
    title = "evencut job file",
    extend("required" = ["version", "surface", "tool", "cut"])
)]
pub struct JobFile {
    /// Version of the job file format.
    #[schemars(extend("minimum" = VERSION, "maximum" = VERSION))]
    pub version: Option<u32>,
    /// Name of the job, written into programs and reports. Control characters and `( ) ; %`
    /// are refused, since they end comments in programs.
    #[schemars(extend("minLength" = 1, "maxLength" = 100, "x-default" = "the surface file's name without its extension, or the kind of formula"))]
    pub name: Option<String>,
    /// Unit of every length in this file: lengths in mm or inch, feeds in mm/min or inch/min,
    /// removal rates in mm³/min or inch³/min, accelerations in mm/s² or inch/s².
    #[schemars(extend("default" = "mm"))]
    pub units: Option<Units>,
    /// The surface to machine: a mesh `file`, or a formula in `[surface.analytic]`.
    #[serde(default)]
    pub surface: SurfaceTable,
    /// How the surface is laid flat.
    #[serde(default)]
    pub flatten: FlattenTable,
    /// The cutter.
    #[serde(default)]
    pub tool: ToolTable,
    /// Cutting data. The side step comes from either `scallop` or `stepover`.
    #[serde(default)]
    pub cut: CutTable,
    /// Division of the surface into regions.
    #[serde(default)]
    pub regions: RegionsTable,
    /// Passes and links.
    #[serde(default)]
    pub path: PathTable,
    /// The material before the first operation, where it is known: a `box`, or a mesh `file`. Over the surface it may be no
    /// thicker than `cut.allowance` and `cut.axial_depth` together; rapids run above it, and the simulation measures what is cut
    /// of it beside the surface. Without it, the surface is covered by that much and nothing stands beside it. With `path.pattern = "hub"` it says nothing.
    #[serde(default, skip_serializing_if = "is_default")]
    pub stock: StockTable,
    /// What stands beside the surface and must not be touched, such as clamps and vices: a table `[[avoid]]` for each.
    /// Passes, links and rapids keep their distance; the simulation measures it on every move, for cutter, shank and
    /// holder. With `path.pattern = "hub"` it says nothing.
    #[schemars(extend("x-default" = "nothing stands there", "maxItems" = 100))]
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub avoid: Option<Vec<AvoidTable>>,
    /// The blades of a blisk, with `path.pattern = "hub"`: the surface is its hub.
    #[serde(default, skip_serializing_if = "is_default")]
    pub hub: HubTable,
    /// Limits on the cut: on the material removal rate, at most one of `mrr_limit` and `relative`; on power and force,
    /// which need a `[material]`; on feed per tooth and engagement. They are measured over windows of a fifth of the
    /// cutter radius.
    #[serde(default)]
    pub force: ForceTable,
    /// What is cut, for limits on power and force: a `group`, or `kc11` and `mc`.
    #[serde(default, skip_serializing_if = "is_default")]
    pub material: MaterialTable,
    /// Trochoids, used with `force.control = "fastest"` or `"trochoid"`.
    #[serde(default)]
    pub trochoid: TrochoidTable,
    /// The machine and its limits.
    #[serde(default)]
    pub machine: MachineTable,
    /// The window whose texture is simulated, and how the teeth stand.
    #[serde(default, skip_serializing_if = "is_default")]
    pub texture: TextureTable,
    /// Operations on the same surface, in their order: a table `[[operation]]` for each, with what differs from the
    /// tables above. Each meets the material that those before it left. Without any, the job is one operation.
    #[schemars(with = "Vec<OperationTable>", extend("x-default" = "the job is one operation", "minItems" = 1, "maxItems" = 20))]
    #[serde(default, skip_serializing, deserialize_with = "apart")]
    pub operation: (),
    /// What to write besides the report, the path and the resolved job.
    #[serde(default)]
    pub output: OutputTable,
}

/// `[[operation]]`: what differs from the job's tables, key by key; `tool` replaces `[tool]` as a whole.
#[derive(Clone, Debug, PartialEq, Default, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct OperationTable {
    /// Name of the operation, written into programs and reports, as the job's `name`.
    #[schemars(extend("minLength" = 1, "maxLength" = 60, "x-default" = "the word operation and its number"))]
    pub name: Option<String>,
    /// Rest finishing: only what the operations before left too high is cut, because their cutters did not fit there.
    #[schemars(extend("default" = false))]
    pub rest: Option<bool>,
    /// The cutter of the operation, instead of `[tool]`.
    #[schemars(with = "OwnKeys", extend("x-as" = "tool"))]
    #[serde(default, skip_serializing_if = "is_default")]
    pub tool: ToolTable,
    /// Keys of `[cut]` that differ.
    #[schemars(with = "OwnKeys", extend("x-as" = "cut"))]
    #[serde(default, skip_serializing_if = "is_default")]
    pub cut: CutTable,
    /// Keys of `[regions]` that differ.
    #[schemars(with = "OwnKeys", extend("x-as" = "regions"))]
    #[serde(default, skip_serializing_if = "is_default")]
    pub regions: RegionsTable,
    /// Keys of `[path]` that differ.
    #[schemars(with = "OwnKeys", extend("x-as" = "path"))]
    #[serde(default, skip_serializing_if = "is_default")]
    pub path: PathTable,
    /// Keys of `[force]` that differ.
    #[schemars(with = "OwnKeys", extend("x-as" = "force"))]
    #[serde(default, skip_serializing_if = "is_default")]
    pub force: ForceTable,
    /// Keys of `[trochoid]` that differ.
    #[schemars(with = "OwnKeys", extend("x-as" = "trochoid"))]
    #[serde(default, skip_serializing_if = "is_default")]
    pub trochoid: TrochoidTable,
}

/// The keys of a table of the job.
#[derive(JsonSchema)]
struct OwnKeys {}

/// Operations are read and written apart from the job: each is a job with all tables.
fn apart<'de, D: Deserializer<'de>>(_: D) -> Result<(), D::Error> {
    Ok(())
}

/// Unit of length.
#[derive(Copy, Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Units {
    /// Millimetres.
    Mm,
    /// Inches of 25.4 mm.
    Inch,
}

/// `[surface]`.
#[derive(Clone, Debug, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(extend("oneOf" = [{ "required": ["file"] }, { "required": ["analytic"] }]))]
pub struct SurfaceTable {
    /// Mesh (stl, obj, ply or off), NURBS surface (json) or CAD faces (step or stp); the path is
    /// relative to the job file.
    #[schemars(extend("x-default" = "required, or `analytic`", "minLength" = 1, "maxLength" = 4096))]
    pub file: Option<String>,
    /// Unit of the lengths in the file; a STEP file states its own.
    #[schemars(extend("x-default" = "`units` of the job"))]
    pub units: Option<Units>,
    /// Factor on the surface's lengths, applied first.
    #[schemars(extend("default" = 1.0, "minimum" = 1e-6, "maximum" = 1e6))]
    pub scale: Option<f64>,
    /// Rotations about X, then Y, then Z, applied after the scale.
    #[schemars(extend("default" = [0.0, 0.0, 0.0], "items" = { "type": "number", "x-unit": "deg", "minimum": -360.0, "maximum": 360.0 }))]
    pub rotate: Option<[f64; 3]>,
    /// Shift along X, Y, Z, applied last.
    #[schemars(extend("default" = [0.0, 0.0, 0.0], "items" = { "type": "number", "x-unit": "mm", "minimum": -1e10, "maximum": 1e10 }))]
    pub translate: Option<[f64; 3]>,
    /// Machine the surface from the side that its faces point away from.
    #[schemars(extend("default" = false))]
    pub flip: Option<bool>,
    /// Which faces are machined; the conditions add up.
    #[schemars(extend("x-default" = "all faces, which must be connected"))]
    pub select: Option<SelectTable>,
    /// Face of a STEP file to machine, counted from 1 as `evencut inspect` lists them; the other
    /// faces belong to the part that must not be cut into. With `steepest` also several faces, `[1, 4]`, or `"all"`.
    #[schemars(extend("x-default" = "the only face; the largest with `select.component = \"largest\"`"))]
    pub face: Option<FaceKey>,
    /// Largest distance between a NURBS surface and the triangles that are made of it. Positions,
    /// normals and curvature stay those of the surface.
    #[schemars(extend("x-unit" = "mm", "x-default" = "a quarter of `cut.tolerance`", "minimum" = 1e-6, "maximum" = 10.0))]
    pub chord: Option<f64>,
    /// Radius over which curvature is estimated; NURBS surfaces have exact curvature.
    #[schemars(extend("x-unit" = "mm", "x-default" = "from the mesh's edge lengths", "exclusiveMinimum" = 0.0, "maximum" = 1e4))]
    pub curvature_radius: Option<f64>,
    /// Steepest slope that is machined, three axes only: paths are planned on what the cutter leaves of the part, seen
    /// from above; the part may be any triangles. What is steeper, faces away or lies under something else is set
    /// aside and reported.
    #[schemars(extend("x-unit" = "deg", "x-default" = "the surface is machined as it is", "minimum" = 5.0, "maximum" = 89.0))]
    pub steepest: Option<f64>,
    /// A surface given by a formula, centred on the origin and machined from above.
    pub analytic: Option<AnalyticTable>,
}

/// Conditions on the faces to machine, after scale, rotation and translation.
#[derive(Clone, Debug, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SelectTable {
    /// Keep faces whose normal is within this angle of the direction `of`.
    #[schemars(extend("x-unit" = "deg", "x-default" = "any normal", "exclusiveMinimum" = 0.0, "maximum" = 180.0))]
    pub normal_within: Option<f64>,
    /// Direction for `normal_within`; need not have length 1.
    #[schemars(extend("default" = [0.0, 0.0, 1.0], "items" = { "type": "number", "minimum": -1e6, "maximum": 1e6 }))]
    pub of: Option<[f64; 3]>,
    /// Keep faces whose centroid lies in this box: least corner, greatest corner.
    #[serde(rename = "box")]
    #[schemars(extend("x-default" = "everywhere", "items" = { "type": "array", "minItems": 3, "maxItems": 3, "items": { "type": "number", "x-unit": "mm", "minimum": -1e6, "maximum": 1e6 } }))]
    pub within_box: Option<[[f64; 3]; 2]>,
    /// Which connected piece of what is left: `"only"` (there must be one), `"largest"` by area, or
    /// an index in order of decreasing area, from 0.
    #[schemars(extend("default" = "only"))]
    pub component: Option<ComponentKey>,
}

/// Faces of a STEP file, by number or all.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum FaceKey {
    /// By rule.
    Rule(FaceRule),
    /// One, by its number.
    Number(#[schemars(extend("minimum" = 1, "maximum" = 1_000_000))] u32),
    /// Several, by their numbers.
    Numbers(
        #[schemars(extend("minItems" = 1, "uniqueItems" = true, "items" = { "type": "integer", "minimum": 1, "maximum": 1_000_000 }))]
         Vec<u32>,
    ),
}

/// Faces of a STEP file, by rule.
#[derive(Copy, Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum FaceRule {
    /// All that can be used.
    All,
}

/// A connected piece, by rule or by index.
#[derive(Copy, Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum ComponentKey {
    /// By rule.
    Rule(ComponentRule),
    /// By index, in order of decreasing area, from 0.
    Index(#[schemars(extend("maximum" = 1_000_000))] u32),
}

/// A connected piece, by rule.
#[derive(Copy, Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum ComponentRule {
    /// There must be only one.
    Only,
    /// The one of largest area.
    Largest,
}

/// A surface given by a formula. Only `kind` is required; a number that the kind does not use is
/// refused.
#[derive(Clone, Debug, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(extend("required" = ["kind"]))]
pub struct AnalyticTable {
    /// Which formula.
    pub kind: Option<AnalyticKind>,
    /// Side of the square, or diameter of the disk, seen from above.
    #[schemars(extend("x-unit" = "mm", "default" = 100.0, "minimum" = 0.001, "maximum" = 1e4))]
    pub size: Option<f64>,
    /// Main radius (sphere-cap, cylinder, torus-patch, bump).
    #[schemars(extend("x-unit" = "mm", "default" = 80.0, "minimum" = 0.001, "maximum" = 1e6))]
    pub radius: Option<f64>,
    /// Radius of the tube (torus-patch).
    #[schemars(extend("x-unit" = "mm", "default" = 60.0, "minimum" = 0.001, "maximum" = 1e6))]
    pub tube_radius: Option<f64>,
    /// Height (saddle, monkey-saddle, bump); negative turns it over.
    #[schemars(extend("x-unit" = "mm", "default" = 10.0, "minimum" = -1e4, "maximum" = 1e4))]
    pub height: Option<f64>,
    /// Edge length of the mesh that is made.
    #[schemars(extend("x-unit" = "mm", "x-default" = "a hundredth of `size`, at most 1 mm", "minimum" = 1e-4, "maximum" = 1e3))]
    pub resolution: Option<f64>,
}

/// `[flatten]`.
#[derive(Clone, Debug, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FlattenTable {
    /// Conformal flattening method.
    #[schemars(extend("default" = "bff"))]
    pub method: Option<FlattenMethod>,
}

/// `[tool]`.
#[derive(Clone, Debug, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(extend("oneOf" = [{ "required": ["library"] }, { "required": ["diameter"], "not": { "required": ["library"] } }]))]
pub struct ToolTable {
    /// File from which the tool is taken, relative to the job file: evencut's own (toml), a tool bit of FreeCAD (fctb) or a
    /// library of Fusion (json). What else this table gives counts instead of what the file says. `evencut tools FILE`
    /// lists its tools.
    #[schemars(extend("x-default" = "none: this table says all", "minLength" = 1, "maxLength" = 4096))]
    pub library: Option<String>,
    /// Name of the tool in `library`.
    #[schemars(extend("x-default" = "the tool of this `number`, or the only one", "minLength" = 1, "maxLength" = 200))]
    pub name: Option<String>,
    /// Family of end mill.
    #[schemars(extend("x-default" = "from `corner_radius`: flat where it is 0, bull where it is below the radius, else ball"))]
    pub kind: Option<ToolKind>,
    /// Cutter diameter.
    #[schemars(extend("x-unit" = "mm", "x-default" = "required, or `library`", "minimum" = 0.001, "maximum" = 500.0))]
    pub diameter: Option<f64>,
    /// Corner radius.
    #[schemars(extend("x-unit" = "mm", "x-default" = "ball: half the diameter; flat: 0; bull: a tenth of the diameter", "minimum" = 0.0, "maximum" = 250.0))]
    pub corner_radius: Option<f64>,
    /// Number of flutes.
    #[schemars(extend("default" = 4, "minimum" = 1, "maximum" = 64))]
    pub flutes: Option<u32>,
    /// Helix angle.
    #[schemars(extend("x-unit" = "deg", "default" = 30.0, "minimum" = 0.0, "maximum" = 75.0))]
    pub helix: Option<f64>,
    /// Number in the tool table of the machine; without `name` it also chooses the tool in `library`.
    #[schemars(extend("x-default" = "that in `library`, else 1", "minimum" = 1, "maximum" = 99_999))]
    pub number: Option<u32>,
    /// Number of the offset of its length (H), where its post names one.
    #[schemars(extend("x-default" = "`number`", "minimum" = 1, "maximum" = 99_999))]
    pub length_offset: Option<u32>,
    /// Number of the offset of its diameter (D). The program compensates no diameter; a post may name it.
    #[schemars(extend("x-default" = "`length_offset`", "minimum" = 0, "maximum" = 99_999))]
    pub diameter_offset: Option<u32>,
    /// Length from the tip to where the shank begins: flutes and neck.
    #[schemars(extend("x-unit" = "mm", "x-default" = "twice the diameter", "minimum" = 0.001, "maximum" = 1000.0))]
    pub length: Option<f64>,
    /// Diameter of the shank.
    #[schemars(extend("x-unit" = "mm", "x-default" = "`diameter`", "minimum" = 0.001, "maximum" = 500.0))]
    pub shank_diameter: Option<f64>,
    /// Length from the tip to the holder.
    #[schemars(extend("x-unit" = "mm", "x-default" = "ten diameters", "minimum" = 0.001, "maximum" = 2000.0))]
    pub stickout: Option<f64>,
    /// Length from the tip to the spindle's gauge line; asked for where a head turns the spindle.
    #[schemars(extend("x-unit" = "mm", "x-default" = "`stickout` and the lengths of `holder`, where that is given", "minimum" = 0.001, "maximum" = 3000.0))]
    pub gauge_length: Option<f64>,
    /// The holder as cylinders and cones, from the shank upward.
    #[schemars(extend("x-default" = "none", "minItems" = 1, "maxItems" = 100))]
    pub holder: Option<Vec<HolderTable>>,
    /// How far holder and shank, where they are wider than the cutter, must stay clear of part and stock:
    /// the simulation measures it on every move. Where the axis turns, a shank that is not wider must not cut in. Checked where
    /// one of `length`, `shank_diameter`, `stickout` and `holder` is given; with `path.pattern = "hub"` there is `hub.clearance`.
    /// It is also the default of `avoid.distance`.
    #[schemars(extend("x-unit" = "mm", "x-default" = "0.5 mm", "minimum" = 0.0, "maximum" = 100.0))]
    pub clearance: Option<f64>,
}

/// A cylinder or a cone of a holder.
#[derive(Clone, Debug, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(extend("required" = ["diameter", "length"]))]
pub struct HolderTable {
    /// Diameter, of a cone that at its lower end.
    #[schemars(extend("x-unit" = "mm", "minimum" = 0.001, "maximum" = 1000.0))]
    pub diameter: Option<f64>,
    /// Diameter at its upper end.
    #[schemars(extend("x-unit" = "mm", "x-default" = "`diameter`", "minimum" = 0.001, "maximum" = 1000.0))]
    pub upper_diameter: Option<f64>,
    /// Length along the axis.
    #[schemars(extend("x-unit" = "mm", "minimum" = 0.001, "maximum" = 2000.0))]
    pub length: Option<f64>,
}

/// `[hub]`.
#[derive(Clone, Debug, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(extend("required" = ["blades", "blade"]))]
pub struct HubTable {
    /// Number of blades, splitters not counted.
    #[schemars(extend("minimum" = 2, "maximum" = 1000))]
    pub blades: Option<u32>,
    /// All surfaces of one blade, with its fillet: NURBS files (json), which are placed as the hub is, or numbers of
    /// faces of the hub's STEP file. Their edge on the hub bounds the channels.
    #[schemars(extend("minItems" = 1, "maxItems" = 1000))]
    pub blade: Option<Vec<BladeSurface>>,
    /// All surfaces of one splitter blade, with its fillet.
    #[schemars(extend("x-default" = "there are none", "minItems" = 1, "maxItems" = 1000))]
    pub splitter: Option<Vec<BladeSurface>>,
    /// Direction of the axis of rotation, as the hub is placed; need not have length 1.
    #[schemars(extend("default" = [0.0, 0.0, 1.0], "items" = { "type": "number", "minimum": -1e6, "maximum": 1e6 }))]
    pub axis: Option<[f64; 3]>,
    /// A point of the axis of rotation.
    #[schemars(extend("default" = [0.0, 0.0, 0.0], "items" = { "type": "number", "x-unit": "mm", "minimum": -1e6, "maximum": 1e6 }))]
    pub origin: Option<[f64; 3]>,
    /// Distance that cutter, shank and holder keep from blades and fillets.
    #[schemars(extend("x-unit" = "mm", "x-default" = "2 % of the tool diameter", "minimum" = 1e-4, "maximum" = 100.0))]
    pub clearance: Option<f64>,
    /// How far passes go on beyond both ends of a channel.
    #[schemars(extend("x-unit" = "mm", "x-default" = "half the tool diameter", "minimum" = 0.001, "maximum" = 1000.0))]
    pub extension: Option<f64>,
    /// How passes are spaced.
    #[schemars(extend("default" = "shortest"))]
    pub passes: Option<HubPasses>,
    /// Which channels are machined.
    #[schemars(extend("default" = "all"))]
    pub channels: Option<HubChannels>,
}

/// `[cut]`.
#[derive(Clone, Debug, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(extend("required" = ["feed"], "oneOf" = [{ "required": ["scallop"] }, { "required": ["stepover"] }]))]
pub struct CutTable {
    /// Scallop height that the cusps may reach; sets the side step place by place.
    #[schemars(extend("x-unit" = "mm", "x-default" = "required, or `stepover`", "minimum" = 1e-6, "maximum" = 10.0))]
    pub scallop: Option<f64>,
    /// Side step, the same everywhere on the surface.
    #[schemars(extend("x-unit" = "mm", "x-default" = "required, or `scallop`", "minimum" = 1e-5, "maximum" = 500.0))]
    pub stepover: Option<f64>,
    /// Axial depth of cut, along the surface normal.
    #[schemars(extend("x-unit" = "mm", "x-default" = "5 % of the tool diameter", "minimum" = 1e-5, "maximum" = 500.0))]
    pub axial_depth: Option<f64>,
    /// Nominal feed.
    #[schemars(extend("x-unit" = "mm/min", "minimum" = 0.001, "maximum" = 1e6))]
    pub feed: Option<f64>,
    /// Spindle speed.
    #[schemars(extend("x-unit" = "rev/min", "x-default" = "a cutting speed of 150 m/min, at most 12000 rev/min", "minimum" = 1.0, "maximum" = 1e6))]
    pub spindle: Option<f64>,
    /// Direction in which the spindle turns, seen from the spindle: clockwise (M3) for right-hand cutters. Climb milling stays
    /// climb milling.
    #[schemars(extend("default" = "clockwise"))]
    pub spindle_direction: Option<SpindleDirection>,
    /// Coolant while it cuts.
    #[schemars(extend("default" = "off"))]
    pub coolant: Option<Coolant>,
    /// Lead angle: tilt of the tool axis in the feed direction. Five axes only.
    #[schemars(extend("x-unit" = "deg", "x-default" = "0 on three axes, else 5", "minimum" = 0.0, "maximum" = 60.0))]
    pub lead: Option<f64>,
    /// Largest angle between tool axis and surface normal to which the axis is tilted where the cutter's side, the shank or
    /// the holder would touch the part or an avoided mesh; 0: never. A ball end is tilted to all sides, others get more
    /// lead. Five axes only.
    #[schemars(extend("x-unit" = "deg", "x-default" = "45 on five axes", "minimum" = 0.0, "maximum" = 80.0))]
    pub max_tilt: Option<f64>,
    /// Chord tolerance of the path.
    #[schemars(extend("x-unit" = "mm", "x-default" = "0.005 mm", "minimum" = 1e-6, "maximum" = 10.0))]
    pub tolerance: Option<f64>,
    /// Allowance left on the surface.
    #[schemars(extend("x-unit" = "mm", "default" = 0.0, "minimum" = 0.0, "maximum" = 100.0))]
    pub allowance: Option<f64>,
    /// On which side of the cutter the material lies.
    #[schemars(extend("default" = "climb"))]
    pub direction: Option<CutDirection>,
    /// What to do where the cutter does not fit.
    #[schemars(extend("default" = "lift"))]
    pub inaccessible: Option<Inaccessible>,
}

/// `[regions]`.
#[derive(Clone, Debug, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RegionsTable {
    /// How the surface is divided.
    #[schemars(extend("default" = "single"))]
    pub method: Option<RegionMethod>,
    /// Least area of a region: smaller ones are joined to the neighbour with which they share the longest
    /// border. In mm², or in inch² in a job in inches.
    #[schemars(extend("x-unit" = "mm²", "x-default" = "a square of 1.5 tool diameters", "minimum" = 0.0, "maximum" = 1e8))]
    pub min_area: Option<f64>,
    /// How far the strips of neighbouring regions overlap along their border: with 0 the outermost passes
    /// run half a side step beside it, with a whole side step, which is the most, on it. Open passes go on
    /// so far beyond it.
    #[schemars(extend("x-unit" = "mm", "x-default" = "a tenth of the nominal side step", "minimum" = 0.0, "maximum" = 100.0))]
    pub blend: Option<f64>,
    /// In which order the regions are machined.
    #[schemars(extend("default" = "shortest"))]
    pub order: Option<RegionOrder>,
    /// Regions that map evenly, with `regions.method = "distortion"`.
    #[serde(default, skip_serializing_if = "is_default")]
    pub distortion: DistortionTable,
    /// Regions parted where the best feed direction parts, with `regions.method = "tensor"`.
    #[serde(default, skip_serializing_if = "is_default")]
    pub tensor: TensorTable,
}

/// `[regions.tensor]`.
#[derive(Clone, Debug, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TensorTable {
    /// How far the tensor of a mesh is smoothed: the standard deviation of a Gaussian. Larger blurs points
    /// that lie near each other into one or none.
    #[schemars(extend("x-unit" = "mm", "x-default" = "what the noise of the vertices asks for", "minimum" = 0.0, "maximum" = 1000.0))]
    pub scale: Option<f64>,
    /// A place without a best feed direction divides the surface only if, a quarter of the surface's size
    /// away from it, the widest strip is wider than the narrowest by this part.
    #[schemars(extend("default" = 0.02, "minimum" = 0.0, "maximum" = 10.0))]
    pub least_gain: Option<f64>,
}

fn is_default<T: Default + PartialEq>(value: &T) -> bool {
    *value == T::default()
}

/// `[regions.distortion]`.
#[derive(Clone, Debug, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DistortionTable {
    /// What tells where the map is uneven.
    #[schemars(extend("default" = "stretch"))]
    pub measure: Option<DistortionMeasure>,
    /// Value of the measure at which a region is first tried to be cut.
    #[schemars(extend("default" = 0.0, "minimum" = -10.0, "maximum" = 10.0))]
    pub threshold: Option<f64>,
    /// A region is split while the 5th percentile of its flat map's stretch is less than this part of the
    /// 95th.
    #[schemars(extend("default" = 0.85, "minimum" = 0.0, "maximum" = 0.99))]
    pub uniformity: Option<f64>,
    /// How often a region may be split again; with 0 the surface stays whole.
    #[schemars(extend("default" = 12, "minimum" = 0, "maximum" = 30))]
    pub depth: Option<u32>,
    /// What the flat stepover is divided by: the largest stretch of the region, or that of the place.
    #[schemars(extend("default" = "exact"))]
    pub compensation: Option<Compensation>,
}

/// `[path]`.
#[derive(Clone, Debug, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PathTable {
    /// Pattern of the passes.
    #[schemars(extend("default" = "contour"))]
    pub pattern: Option<Pattern>,
    /// Where iso-scallop passes begin.
    #[schemars(extend("x-default" = "shortest"))]
    pub start: Option<StartKey>,
    /// Points of a curve at which iso-scallop passes begin, each taken to the nearest point of the
    /// surface; it is lengthened to the boundary.
    #[schemars(extend("x-default" = "`start` counts", "minItems" = 2, "maxItems" = 1000, "items" = { "type": "array", "minItems": 3, "maxItems": 3, "items": { "type": "number", "x-unit": "mm", "minimum": -1e6, "maximum": 1e6 } }))]
    pub curve: Option<Vec<[f64; 3]>>,
    /// Surface parameter along which iso-parametric passes run: of a NURBS surface its own, of a mesh
    /// the conformal coordinate along (u) or across (v) the longest extent of its flat image.
    #[schemars(extend("x-default" = "the one with the shorter path"))]
    pub along: Option<Parameter>,
    /// Direction of iso-planar passes seen from above, from X toward Y.
    #[schemars(extend("x-unit" = "deg", "x-default" = "the one with the shortest path, by steps of 15 degrees", "minimum" = -180.0, "maximum" = 180.0))]
    pub angle: Option<f64>,
    /// How open passes follow each other.
    #[schemars(extend("x-default" = "zigzag"))]
    pub traverse: Option<Traverse>,
    /// Where the outermost passes run on an open boundary.
    #[schemars(extend("x-default" = "edge for rings, else half-strip"))]
    pub first: Option<FirstPass>,
    /// Order of the rings.
    #[schemars(extend("default" = "outside-in"))]
    pub order: Option<RingOrder>,
    /// How consecutive passes are joined.
    #[schemars(extend("default" = "surface"))]
    pub links: Option<Links>,
    /// Radius of the arcs on which the cutter comes down to passes from above and leaves them upward, in the plane of
    /// feed direction and tool axis; smaller where that would touch the part or reach above the rapids. Passes that are
    /// joined on the surface (`links`) and those that begin with a helix have none. With 0 it comes straight down the
    /// tool axis.
    #[schemars(extend("x-unit" = "mm", "default" = 0.0, "minimum" = 0.0, "maximum" = 500.0))]
    pub entry_radius: Option<f64>,
    /// What lies outside of the surface's boundary.
    #[schemars(extend("default" = "open"))]
    pub boundary: Option<Boundary>,
    /// How far a wall stands above the edge of the surface; with `boundary = "wall"`.
    #[schemars(extend("x-unit" = "mm", "x-default" = "the tool diameter, or the stock's height if that is more", "minimum" = 1e-3, "maximum" = 1e4))]
    pub wall_height: Option<f64>,
}

/// A clamp, a vice, a pin, or whatever else the tool stays away from.
#[derive(Clone, Debug, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(extend("required" = ["file"]))]
pub struct AvoidTable {
    /// Mesh (stl, obj, ply or off); the path is relative to the job file. It has the coordinates of the surface's file
    /// and is placed as that is, by `surface.units`, `scale`, `rotate` and `translate`; beside a formula or a STEP file
    /// its lengths are mm.
    #[schemars(extend("minLength" = 1, "maxLength" = 4096))]
    pub file: Option<String>,
    /// How far cutter, shank and holder stay away from it at least, on every move; with 0 they may touch it.
    #[schemars(extend("x-unit" = "mm", "x-default" = "`tool.clearance`", "minimum" = 0.0, "maximum" = 100.0))]
    pub distance: Option<f64>,
    /// What it is called in messages and reports; each another name.
    #[schemars(extend("x-default" = "the file's name without its extension", "minLength" = 1, "maxLength" = 40))]
    pub name: Option<String>,
}

/// `[stock]`.
#[derive(Clone, Debug, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(extend("not" = { "required": ["box", "file"] }))]
pub struct StockTable {
    /// A box with sides along the axes: least corner, greatest corner, in the coordinates of the program.
    #[serde(rename = "box")]
    #[schemars(extend("x-default" = "`file` counts", "items" = { "type": "array", "minItems": 3, "maxItems": 3, "items": { "type": "number", "x-unit": "mm", "minimum": -1e6, "maximum": 1e6 } }))]
    pub corners: Option<[[f64; 3]; 2]>,
    /// Mesh (stl, obj, ply or off) of all of the material, the part's included; the path is relative to the job file, and it
    /// is placed as the files of `[[avoid]]` are.
    #[schemars(extend("x-default" = "`box` counts", "minLength" = 1, "maxLength" = 4096))]
    pub file: Option<String>,
}

/// `[force]`.
#[derive(Clone, Debug, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(extend("not" = { "required": ["mrr_limit", "relative"] }))]
pub struct ForceTable {
    /// Largest material removal rate.
    #[schemars(extend("x-unit" = "mm³/min", "x-default" = "`relative` counts", "exclusiveMinimum" = 0.0, "maximum" = 1e9))]
    pub mrr_limit: Option<f64>,
    /// Largest material removal rate, as a multiple of that of a straight pass at the nominal side
    /// step: side step × axial depth × feed.
    #[schemars(extend("x-default" = "1.5 where no limit on rate, power or force is given", "minimum" = 0.01, "maximum" = 1000.0))]
    pub relative: Option<f64>,
    /// Largest power of the cut, at the spindle's nose.
    #[schemars(extend("x-unit" = "W", "x-default" = "no limit", "minimum" = 1e-3, "maximum" = 1e6))]
    pub power: Option<f64>,
    /// Largest mean cutting force: the power over the cutting speed at the mean radius of the cutter's engaged part.
    #[schemars(extend("x-unit" = "N", "x-default" = "no limit", "minimum" = 1e-3, "maximum" = 1e6))]
    pub cutting_force: Option<f64>,
    /// Smallest feed per tooth, below which teeth rub instead of cutting; links and ramps may be slower.
    #[schemars(extend("x-unit" = "mm", "x-default" = "no limit; with `control = \"fastest\"`, trochoids are preferred below 0.03 % of the tool diameter", "exclusiveMinimum" = 0.0, "maximum" = 10.0))]
    pub min_chip: Option<f64>,
    /// Largest angle over which the cutter may be engaged, for its heat and wear: 180 in a slot; it is that of a disc that
    /// takes the same volume. Links and ramps may exceed it.
    #[schemars(extend("x-unit" = "deg", "x-default" = "no limit", "minimum" = 1.0, "maximum" = 180.0))]
    pub max_engagement: Option<f64>,
    /// What is done where a limit would be exceeded.
    #[schemars(extend("x-default" = "fastest for pattern contour, and where open passes take trochoids and a limit on engagement or feed per tooth is given; else feed where a limit is given, off where none is"))]
    pub control: Option<ForceControl>,
    /// Which feed component the removal rate is formed with.
    #[schemars(extend("default" = "mean"))]
    pub vfc: Option<FeedComponent>,
}

/// `[material]`.
#[derive(Clone, Debug, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MaterialTable {
    /// Group by ISO 513: steel, stainless steel, cast iron, non-ferrous metals, heat-resistant alloys and titanium,
    /// hardened steel. The hardest of the group counts, so that limits hold for all of it.
    #[schemars(extend("x-default" = "given by `kc11`"))]
    pub group: Option<MaterialGroup>,
    /// Specific cutting force at a chip of 1 mm by 1 mm.
    #[schemars(extend("x-unit" = "N/mm²", "x-default" = "that of `group`", "minimum" = 10.0, "maximum" = 1e5))]
    pub kc11: Option<f64>,
    /// Its exponent: the force falls with the chip thickness to the power of `-mc`.
    #[schemars(extend("x-default" = "that of `group`, else 0.25", "minimum" = 0.0, "maximum" = 0.6))]
    pub mc: Option<f64>,
}

/// `[trochoid]`.
#[derive(Clone, Debug, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TrochoidTable {
    /// Largest step between loops.
    #[schemars(extend("x-unit" = "mm", "x-default" = "20 % of the tool diameter", "minimum" = 1e-5, "maximum" = 500.0))]
    pub max_step: Option<f64>,
    /// Smallest radius of a loop of the cutter's centre.
    #[schemars(extend("x-unit" = "mm", "x-default" = "5 % of the tool diameter", "minimum" = 1e-5, "maximum" = 500.0))]
    pub min_radius: Option<f64>,
    /// Feed on the half of a loop that cuts nothing.
    #[schemars(extend("x-unit" = "mm/min", "x-default" = "2.5 × `cut.feed`, at most `machine.max_feed`", "minimum" = 0.001, "maximum" = 1e6))]
    pub return_feed: Option<f64>,
}

/// `[machine]`.
#[derive(Clone, Debug, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MachineTable {
    /// Description of the machine: a file (toml) with keys of this table, lengths in mm; the path is relative to the job
    /// file. What is given here counts instead.
    #[schemars(extend("x-default" = "none", "minLength" = 1, "maxLength" = 4096))]
    pub file: Option<String>,
    /// Arrangement of the axes. Rotary tables turn about program zero; axes that lie elsewhere, or have ranges, are given in
    /// `rotary`.
    #[schemars(extend("x-default" = "3, or that of `rotary`"))]
    pub axes: Option<Arrangement>,
    /// The rotary axes, the one nearer to the workpiece first.
    #[schemars(extend("x-default" = "those of `axes`", "minItems" = 2, "maxItems" = 2))]
    pub rotary: Option<Vec<RotaryTable>>,
    /// From the spindle's gauge line up to the pivot of a head: where its axes are, unless `rotary` says otherwise.
    #[schemars(extend("x-unit" = "mm", "x-default" = "with a head required", "minimum" = 0.0, "maximum" = 10000.0))]
    pub pivot_length: Option<f64>,
    /// Fastest feed; rapids are timed with it too.
    #[schemars(extend("x-unit" = "mm/min", "x-default" = "15000 mm/min", "minimum" = 0.001, "maximum" = 1e6))]
    pub max_feed: Option<f64>,
    /// Acceleration of the linear axes.
    #[schemars(extend("x-unit" = "mm/s²", "x-default" = "2000 mm/s²", "minimum" = 0.01, "maximum" = 1e6))]
    pub max_acceleration: Option<f64>,
    /// Fastest turn of the rotary axes.
    #[schemars(extend("x-unit" = "deg/s", "x-default" = "90 deg/s", "minimum" = 0.01, "maximum" = 1e5))]
    pub max_rotary_speed: Option<f64>,
    /// Acceleration of the rotary axes.
    #[schemars(extend("x-unit" = "deg/s²", "x-default" = "not asked", "minimum" = 0.01, "maximum" = 1e7))]
    pub max_rotary_acceleration: Option<f64>,
    /// Height above part and stock, and above what is avoided with its distance, at which rapids run. Retracts, and approaches
    /// down to a fifth of it above the stock, run at `max_feed`; with `[stock]` approaches run at `trochoid.return_feed` all
    /// the way.
    #[schemars(extend("x-unit" = "mm", "x-default" = "10 mm", "exclusiveMinimum" = 0.0, "maximum" = 1e4))]
    pub clearance: Option<f64>,
    /// Work offset that the program calls.
    #[schemars(extend("x-default" = "none: the one in force on the machine"))]
    pub work_offset: Option<WorkOffset>,
    /// Where the linear axes can go, in the program's coordinates.
    #[schemars(extend("x-default" = "not checked"))]
    pub travel: Option<TravelTable>,
}

/// A rotary axis.
#[derive(Clone, Debug, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(extend("required" = ["letter", "carries"]))]
pub struct RotaryTable {
    /// Its letter in programs.
    pub letter: Option<RotaryLetter>,
    /// What it turns.
    pub carries: Option<Carries>,
    /// Direction about which it turns counter-clockwise, all axes at zero; need not have length 1.
    #[schemars(extend("x-default" = "A: X, B: Y, C: Z", "items" = { "type": "number", "minimum": -1e6, "maximum": 1e6 }))]
    pub direction: Option<[f64; 3]>,
    /// A point that it turns about, all axes at zero: of a table from program zero, of a head from the middle of the
    /// spindle's gauge line.
    #[schemars(extend("x-default" = "table: program zero; head: `[0, 0, pivot_length]`", "items" = { "type": "number", "x-unit": "mm", "minimum": -1e5, "maximum": 1e5 }))]
    pub centre: Option<[f64; 3]>,
    /// Least and greatest position.
    #[schemars(extend("x-default" = "without end", "items" = { "type": "number", "x-unit": "deg", "minimum": -1e6, "maximum": 1e6 }))]
    pub range: Option<[f64; 2]>,
    /// Fastest turn.
    #[schemars(extend("x-unit" = "deg/s", "x-default" = "`max_rotary_speed`", "minimum" = 0.01, "maximum" = 1e5))]
    pub max_speed: Option<f64>,
    /// Acceleration.
    #[schemars(extend("x-unit" = "deg/s²", "x-default" = "`max_rotary_acceleration`", "minimum" = 0.01, "maximum" = 1e7))]
    pub max_acceleration: Option<f64>,
}

/// Letter of a rotary axis.
#[derive(Copy, Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum RotaryLetter {
    /// About X, as a rule.
    A,
    /// About Y, as a rule.
    B,
    /// About Z, as a rule.
    C,
}

/// Least and greatest position of each linear axis, in the program's coordinates.
#[derive(Clone, Debug, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TravelTable {
    /// Reach along X.
    #[schemars(extend("x-default" = "not checked", "items" = { "type": "number", "x-unit": "mm", "minimum": -1e6, "maximum": 1e6 }))]
    pub x: Option<[f64; 2]>,
    /// Reach along Y.
    #[schemars(extend("x-default" = "not checked", "items" = { "type": "number", "x-unit": "mm", "minimum": -1e6, "maximum": 1e6 }))]
    pub y: Option<[f64; 2]>,
    /// Reach along Z.
    #[schemars(extend("x-default" = "not checked", "items" = { "type": "number", "x-unit": "mm", "minimum": -1e6, "maximum": 1e6 }))]
    pub z: Option<[f64; 2]>,
}

/// `[texture]`.
#[derive(Clone, Debug, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TextureTable {
    /// A place near the middle of the window, which lies about the nearest place of the surface; its sides run along
    /// and across the feed of the nearest pass.
    #[schemars(extend("x-default" = "required, or `whole`; with it, the origin", "items" = { "type": "number", "x-unit": "mm", "minimum": -1e6, "maximum": 1e6 }))]
    pub at: Option<[f64; 3]>,
    /// All of the surface instead of a window; `at` then says where its sides run along the feed. Nodes beyond the surface
    /// are empty in the files.
    #[schemars(extend("default" = false))]
    pub whole: Option<bool>,
    /// Size of the window along and across the feed; not used with `whole`.
    #[schemars(extend("x-default" = "along: five turns of the spindle, or a quarter of the width; across: five nominal side steps", "items" = { "type": "number", "x-unit": "mm", "minimum": 1e-4, "maximum": 1000.0 }))]
    pub size: Option<[f64; 2]>,
    /// Length of a cell of the grid: with `uniform` the longest, with `constant` every one.
    #[schemars(extend("x-unit" = "mm", "x-default" = "a tenth of the feed per tooth, or of the nominal side step if that is less", "minimum" = 1e-5, "maximum" = 10.0))]
    pub spacing: Option<f64>,
    /// How far the cutter's axis is off that of the spindle.
    #[schemars(extend("x-unit" = "mm", "default" = 0.0, "minimum" = 0.0, "maximum" = 1.0))]
    pub runout: Option<f64>,
    /// Direction of `runout` from tooth 0, counter-clockwise seen from the spindle.
    #[schemars(extend("x-unit" = "deg", "default" = 0.0, "minimum" = -360.0, "maximum" = 360.0))]
    pub runout_angle: Option<f64>,
    /// How much farther out than the nominal radius each tooth stands: a number for each flute.
    #[schemars(extend("x-default" = "0 for each flute", "minItems" = 1, "maxItems" = 100, "items" = { "type": "number", "x-unit": "mm", "minimum": -1.0, "maximum": 1.0 }))]
    pub tooth_runout: Option<Vec<f64>>,
    /// Angle of tooth 0 from the first feed direction when the path starts, counter-clockwise seen from the spindle.
    #[schemars(extend("x-unit" = "deg", "default" = 0.0, "minimum" = -360.0, "maximum" = 360.0))]
    pub spindle_phase: Option<f64>,
    /// Which cells the grid of the window has.
    #[schemars(extend("default" = "uniform"))]
    pub discretisation: Option<TextureCells>,
}

/// `[output]`.
#[derive(Clone, Debug, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct OutputTable {
    /// The program.
    #[schemars(extend("x-default" = "a LinuxCNC program"))]
    pub gcode: Option<GcodeTable>,
    /// Pictures to draw.
    #[schemars(extend("x-default" = "all that there is to draw", "maxItems" = 7, "uniqueItems" = true))]
    pub svg: Option<Vec<Picture>>,
}

/// The program.
#[derive(Clone, Debug, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct GcodeTable {
    /// Post-processor.
    #[schemars(extend("x-default" = "linuxcnc, or that of `post_file`"))]
    pub post: Option<PostKey>,
    /// Post-processor of your own: a file (toml), relative to the job file; `evencut post NAME` prints one to change.
    #[schemars(extend("x-default" = "none"))]
    pub post_file: Option<String>,
    /// Number of the program, where its post writes one.
    #[schemars(extend("default" = 1, "minimum" = 1, "maximum" = 9999))]
    pub program_number: Option<u32>,
    /// Whether runs of points are written as one block where they lie along a line or an arc (G2, G3) within half of
    /// `cut.tolerance`; three axes.
    #[schemars(extend("default" = false))]
    pub arcs: Option<bool>,
}

/// Post-processor, or none.
#[derive(Copy, Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum PostKey {
    /// LinuxCNC (RS-274/NGC).
    LinuxCnc,
    /// Fanuc; five axes with tool centre point control (G43.4).
    Fanuc,
    /// Haas; five axes with tool centre point control (G234).
    Haas,
    /// Siemens SINUMERIK; five axes with TRAORI.
    Siemens,
    /// Heidenhain, conversational; five axes with FUNCTION TCPM.
    Heidenhain,
    /// GRBL 1.1, three axes.
    Grbl,
    /// APT cutter location data for other post-processors.
    Cldata,
    /// No program is written.
    None,
}
