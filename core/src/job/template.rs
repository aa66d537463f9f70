//! A commented job file to start from.

use std::fmt::Write;

use crate::geometry::{DVec3, OrderBy, math, rotation};
use crate::machine::LONGEST_TRAVEL;

/// What is known of a surface file before a job for it is written, in the units of the file.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct SurfaceFacts {
    /// Extents of the bounding box.
    pub size: [f64; 3],
    /// Middle of the bounding box.
    pub middle: [f64; 3],
    /// Smallest concave radius of curvature, if known.
    pub smallest_concave_radius: Option<f64>,
    /// Smallest convex radius of curvature, if known: the concave one from the other side.
    pub smallest_convex_radius: Option<f64>,
    /// Where the faces look, if they bound a solid but for small openings.
    pub solid: Option<Outside>,
    /// Whether the faces look down rather than up, by area.
    pub looks_down: bool,
    /// Whether it is not one oriented piece with a boundary: only what is reached of it can be machined.
    pub is_part: bool,
    /// How far the facets of a mesh are off the smooth surface that they stand for.
    pub off_smooth: f64,
    /// Number of CAD faces, if the file has such; it states its unit then, and of several all are machined.
    pub cad_faces: Option<usize>,
    /// Unit mean of the face normals by area.
    pub mean_normal: [f64; 3],
    /// Largest angle of a face normal from the mean, rad.
    pub from_mean: f64,
    /// The same but for a thousandth of the area, which a few folded faces of a scan may have.
    pub most_from_mean: f64,
    /// Largest angle of a face normal from +Z but for a thousandth of the area, rad.
    pub most_from_up: f64,
    /// Largest angle of a face normal from -Z but for a thousandth of the area, rad.
    pub most_from_down: f64,
    /// Sharpest turn of a mesh from face to face on a concave and on a convex edge, rad.
    pub sharpest: [f64; 2],
    /// From where most of the faces is seen, as they are and turned over, if hardly any of it is seen from +Z.
    pub seen_from: [Option<[f64; 3]>; 2],
}

impl SurfaceFacts {
    fn has_several_faces(&self) -> bool {
        self.cad_faces.is_some_and(|count| count > 1)
    }
}

/// Where the faces of a solid look.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum Outside {
    /// Away from the material.
    Outward,
    /// Into it: they are turned over.
    Inward,
}

/// On five axes a part farther from the origin than this many of its diagonals is brought there: it cannot have been
/// drawn about the rotary axes.
const FAR: f64 = 5.0;
/// Coordinates beyond which no key brings a part back, mm.
const FARTHEST: f64 = 1e10;
/// Diameters that cutters are sold in, mm.
const DIAMETERS: [f64; 14] =
    [0.5, 1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0, 12.0, 16.0, 20.0, 25.0];
/// Cusp heights to start from, mm.
const SCALLOPS: [f64; 7] = [0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5];
/// Longest extents, in the file's units, below which a part is surely not drawn in mm: such parts
/// are smaller than the cutters that would machine them.
const METRES_BELOW: f64 = 1.0;
const INCHES_BELOW: f64 = 5.0;
/// A cutter below this part of the middle extent takes days; tighter places are left to another.
const SMALLEST_PART: f64 = 0.05;
/// Side steps across the middle extent of a surface and of a part, at most; more are for finishing.
const STEPS_ACROSS: f64 = 200.0;
const ACROSS_PART: f64 = 100.0;
/// Faces steeper than this, degrees from the axis, are not for three axes.
const STEEPEST: f64 = 80.0;
/// A valley sharper than this between two faces of a mesh is one that no cutter fits into, rad (20 degrees): noise of a
/// scan, folded faces or an edge of the part.
const VALLEY: f64 = core::f64::consts::PI / 9.0;
/// An edge of a mesh at which the surface turns by more than this, rad (60 degrees), is one over which an axis along the
/// normal would have to jump.
const EDGE: f64 = core::f64::consts::FRAC_PI_3;
/// A relief whose mean normal leans less than this from +Z is not turned, rad (20 degrees).
const NEARLY_UP: f64 = core::f64::consts::PI / 9.0;
/// A surface none of whose faces looks down is machined from above; rad (92 degrees).
const UPRIGHT: f64 = 92.0 * core::f64::consts::PI / 180.0;
/// An open surface with faces in all directions is a relief or scan, of which is machined what a cutter reaches from
/// above, where no cutter larger than this part of its middle extent fits its concave places.
const ROUGH: f64 = 1.0 / 15.0;
/// The same where all of it looks up, so that nothing but such places is lost.
const ROUGH_ABOVE: f64 = 1.0 / 12.0;
/// Tolerance of a part, and the coarsest of a surface, cusp heights.
const OF_SCALLOP: f64 = 0.5;
/// Tolerance of a surface, cusp heights, unless that is finer than the least one or the facets.
const OF_FINE_SCALLOP: f64 = 0.1;
/// The coarsest cusp that is still one of the ball, cutter diameters.
const COARSEST: f64 = 0.02;
/// Tolerances to start from, mm: the least that is not finer than the facets of the mesh.
const TOLERANCES: [f64; 5] = [0.005, 0.01, 0.02, 0.05, 0.1];

/// How far the facets of a mesh are off the smooth surface, mm, where the job's tolerance is coarser than usual for it.
pub fn coarse_facets(facts: &SurfaceFacts) -> Option<f64> {
    let off = facts.off_smooth * Unit::guess(facts).mm();
    (off > TOLERANCES[0]).then_some(off)
}

/// The unit of the surface's numbers, where they are too small for mm and it is guessed.
pub fn guessed_unit(facts: &SurfaceFacts) -> Option<&'static str> {
    match Unit::guess(facts) {
        Unit::Millimetre => None,
        Unit::Inch => Some("inches"),
        Unit::Metre => Some("metres"),
    }
}

/// A commented job file for the surface in `file`, with values to start from.
///
/// `file`: name of the surface file relative to the job file. The text reads as a valid job.
pub fn template(file: &str, facts: &SurfaceFacts) -> String {
    let unit = Unit::guess(facts);
    let placed = Placed::of(facts);
    let whole = placed.is_part;
    let radius = placed.concave_radius.map(|r| r * unit.mm());
    let size = facts.size.map(|s| if s.is_finite() { s.abs() * unit.mm() } else { 0.0 });
    let mut sorted = size;
    sorted.order_by(f64::total_cmp);
    let middle = sorted[1];
    // What the cutter bridges of a part does not limit it.
    let diameter = diameter_for(middle, radius.filter(|_| !whole));
    let across = if whole { ACROSS_PART } else { STEPS_ACROSS };
    let coarse = coarse_facets(facts);
    let facets = tolerance_for(coarse.unwrap_or_default(), diameter);
    let scallop = scallop_for(middle / across, diameter).max(facets / OF_SCALLOP);
    let about_facets = coarse.map_or_else(String::new, |off| {
        format!("; facets are about {off:.3} mm off a smooth surface")
    });
    let share = if whole { OF_SCALLOP } else { OF_FINE_SCALLOP };
    // A product of decimals that reads as one.
    let tolerance = ((share * scallop).max(facets) * 1e6).round() / 1e6;
    // The usual cutting speed of 150 m/min; a hundredth of the diameter per tooth.
    let spindle = (150_000.0 / (std::f64::consts::PI * diameter)).min(12_000.0).round();
    let feed = (0.01 * diameter * 2.0 * spindle / 10.0).round().max(1.0) * 10.0;
    let name = toml::Value::String(file.to_owned());
    let [x, y, z] = size;
    let mut text = String::new();
    // Writing to a string cannot fail.
    let _ = write!(
        text,
        "\
# A job for a surface of {x:.1} x {y:.1} x {z:.1} mm. Every key with its default is in
# docs/job-file.md. Lengths in mm, angles in degrees, feeds in mm/min.
version = 1

[surface]
file = {name}
{}{}{}{}
[tool]
kind = \"ball\"              # ball | flat | bull
{:<26} # {}
flutes = 2

[cut]
{:<26} # cusp height; or stepover = the same side step everywhere
{:<26} # material above the surface, along its normal
feed = {feed:?}
spindle = {spindle:?}
{:<26} # of path and cusps{}
direction = \"climb\"        # climb | conventional
inaccessible = \"lift\"      # lift the cutter where it does not fit, or refuse the job
{}
[path]
pattern = \"contour\"        # rings; or iso-scallop | iso-planar | spiral and more
boundary = \"open\"          # open: air outside of the surface; wall: material that stays

[force]
{:<26} # limit of the removal rate, times that of a straight pass
control = {:<16} # off | feed | fastest | trochoid

[machine]
{:<26} # {}
clearance = 10.0

[output]
gcode = {{ post = \"linuxcnc\" }}
svg = [\"flat\", \"surface\"{}, \"scallop\"{}]
",
        if facts.has_several_faces() {
            "face = \"all\"               # or numbers, as evencut inspect lists them\n"
        } else {
            ""
        },
        unit.line(),
        placed.lines(),
        placed.centred(facts, unit.mm()),
        format!("diameter = {diameter:?}"),
        match radius {
            _ if whole => "narrower places are bridged".to_owned(),
            Some(r) if 1.8 * r <= 0.1 * middle => reason(diameter, r),
            _ => "about a tenth of the surface's width; no concave place needs a smaller one"
                .to_owned(),
        },
        format!("scallop = {scallop:?}"),
        format!("axial_depth = {:?}", (diameter * 5.0).round() / 100.0),
        format!("tolerance = {tolerance:?}"),
        about_facets,
        if placed.five_axes {
            "lead = 10.0                # tilt in the feed direction\n"
        } else {
            ""
        },
        if whole { "# relative = 1.5" } else { "relative = 1.5" },
        if whole { "\"off\"" } else { "\"feed\"" },
        format!("axes = {:?}", if placed.five_axes { "xyzac" } else { "3" }),
        match (whole, placed.five_axes) {
            (true, _) => "five axes only for one surface, without surface.steepest",
            (false, true) => "xyzac and others; 3 without cut.lead",
            (false, false) => "3 | xyzac and others, with cut.lead for flat and bull ends",
        },
        if whole { "" } else { ", \"mrr\"" },
        if whole { "" } else { ", \"removal\"" },
    );
    text
}

/// Unit of the file's lengths, which mesh formats do not tell.
#[derive(Copy, Clone)]
enum Unit {
    Millimetre,
    Inch,
    Metre,
}

impl Unit {
    fn guess(facts: &SurfaceFacts) -> Self {
        let longest = facts.size.iter().copied().fold(0.0, f64::max);
        match longest {
            _ if facts.cad_faces.is_some() => Unit::Millimetre,
            l if l < METRES_BELOW => Unit::Metre,
            l if l < INCHES_BELOW => Unit::Inch,
            _ => Unit::Millimetre,
        }
    }

    fn mm(self) -> f64 {
        match self {
            Unit::Millimetre => 1.0,
            Unit::Inch => 25.4,
            Unit::Metre => 1000.0,
        }
    }

    fn line(self) -> &'static str {
        match self {
            Unit::Millimetre => "",
            Unit::Inch => {
                "units = \"inch\"             # a guess: the numbers are too small for mm; remove it\n\
                 \x20                          # if they are mm\n"
            }
            Unit::Metre => {
                "scale = 1000.0             # a guess: the numbers are too small for mm and are taken\n\
                 \x20                          # as metres; remove it if they are mm\n"
            }
        }
    }
}

/// How the part stands under the spindle.
struct Placed {
    /// Whether the faces of an open surface look down.
    flip: bool,
    /// Rotations about X and Y that turn the surface up, degrees.
    turn: Option<[f64; 2]>,
    five_axes: bool,
    /// Whether it is machined as a part, from above.
    is_part: bool,
    /// Smallest concave radius on the side that is machined, in the file's units.
    concave_radius: Option<f64>,
}

impl Placed {
    fn of(facts: &SurfaceFacts) -> Self {
        // Faces of a solid look outward. An open surface has no outside; the side that looks up is usually meant.
        let flip = match facts.solid {
            Some(outside) => outside == Outside::Inward,
            None => facts.looks_down,
        };
        let is_part = facts.is_part || facts.has_several_faces();
        let seen_from = facts.seen_from[usize::from(flip)].map(DVec3::from_array);
        let placed = Self {
            flip,
            turn: seen_from.filter(|_| is_part || facts.solid.is_some()).map(turned_up),
            five_axes: false,
            is_part,
            concave_radius: match flip {
                true => facts.smallest_convex_radius,
                false => facts.smallest_concave_radius,
            },
        };
        let mean = DVec3::from_array(facts.mean_normal);
        if !(mean.is_finite() && mean.length() > 0.5) {
            return placed;
        }
        let mean = if flip { -mean } else { mean };
        let steepest = STEEPEST.to_radians();
        let lean = math::acos_clamped(mean.normalize().z);
        // A body stands as it was drawn.
        let is_body = facts.solid.is_some() || facts.has_several_faces();
        let is_part = |rough: f64| placed.is_part || placed.is_rough(facts, rough);
        // Where nearly all of it looks up, nothing is lost.
        let has_valleys = facts.sharpest[usize::from(flip)] > VALLEY;
        let is_reached =
            |lean: f64| is_part(ROUGH_ABOVE) || has_valleys || facts.from_mean + lean >= steepest;
        if !is_body && facts.most_from_mean + lean < steepest {
            Self { is_part: is_reached(lean), ..placed }
        } else if !is_body && facts.most_from_mean < steepest {
            Self { is_part: is_reached(0.0), turn: Some(turned_up(mean)), ..placed }
        } else {
            // Walls are no reason for five axes.
            let from_above = if flip { facts.most_from_down } else { facts.most_from_up };
            let stands = from_above < UPRIGHT;
            let has_edges = facts.sharpest.iter().any(|turn| *turn > EDGE);
            let is_part = is_part(ROUGH) || stands || has_edges;
            // A relief or scan is turned as a smooth sheet is, unless it nearly looks up.
            let leans = !is_body && !stands && is_part && lean > NEARLY_UP;
            let turn = leans.then(|| turned_up(mean)).or(placed.turn);
            Self { is_part, five_axes: !is_part, turn, ..placed }
        }
    }

    fn is_rough(&self, facts: &SurfaceFacts, rough: f64) -> bool {
        let mut size = facts.size;
        size.order_by(f64::total_cmp);
        self.concave_radius.is_some_and(|radius| 2.0 * radius < rough * size[1])
    }

    fn lines(&self) -> String {
        let flip = if self.flip {
            "flip = true                # its faces look down or inward: it is machined from the other side\n"
        } else {
            ""
        };
        let turn = self.turn.map_or(String::new(), |[x, y]| {
            format!(
                "# Turned until most of it looks up, as three axes need.\nrotate = [{x:?}, {y:?}, 0.0]\n"
            )
        });
        let reached = match (self.is_part, self.turn) {
            (false, _) => "",
            (true, None) => {
                "# A part, as it was drawn, +Z up; rotate = [90.0, 0.0, 0.0] turns it. What a cutter reaches of it\n\
                 # from above, up to this slope in degrees, is machined.\n\
                 steepest = 80.0\n"
            }
            (true, Some(_)) => {
                "# What a cutter reaches of it from above, up to this slope in degrees, is machined.\n\
                 steepest = 80.0\n"
            }
        };
        format!("{flip}{turn}{reached}")
    }

    /// The line that brings a part to the origin, where it lies far from it; `mm`: the file's unit.
    fn centred(&self, facts: &SurfaceFacts, mm: f64) -> String {
        let [middle, size] = [facts.middle, facts.size].map(|v| mm * DVec3::from_array(v));
        let [x, y] = self.turn.unwrap_or_default().map(f64::to_radians);
        let turned = rotation(DVec3::new(x, y, 0.0)) * middle;
        let far = if self.five_axes { FAR * size.length() } else { LONGEST_TRAVEL };
        let may_be_set = turned.abs().max_element() < FARTHEST;
        if turned.length() < far || !may_be_set {
            return String::new();
        }
        let what =
            if self.five_axes { "the centre of the rotary axes, the origin" } else { "the origin" };
        let [x, y, z] = turned.to_array().map(|x| 0.0 - x.round());
        format!("# To {what}.\ntranslate = [{x:?}, {y:?}, {z:?}]\n")
    }
}

/// Rotations about X and Y that turn a direction up, degrees.
fn turned_up(way: DVec3) -> [f64; 2] {
    let about_x = math::atan2(way.y, way.z);
    let about_y = math::atan2(-way.x, math::hypot(way.y, way.z));
    // No negative zero.
    [about_x, about_y].map(|a| (a.to_degrees() * 10.0).round() / 10.0 + 0.0)
}

/// The largest cutter that fits the concave places with a tenth to spare and is at most a tenth of
/// the middle extent, but not so small that the whole surface would take days.
fn diameter_for(middle: f64, concave_radius: Option<f64>) -> f64 {
    let by_radius = concave_radius.map_or(f64::INFINITY, |r| 1.8 * r);
    let bound = (0.1 * middle).min(by_radius).max(SMALLEST_PART * middle);
    DIAMETERS.into_iter().rev().find(|d| *d <= bound).unwrap_or(DIAMETERS[0])
}

/// The smallest usual cusp height whose side steps are no narrower than `widest`, mm, those of a semi-finish.
fn scallop_for(widest: f64, diameter: f64) -> f64 {
    let enough = |h: &f64| 2.0 * (h * (diameter - h)).max(0.0).sqrt() >= widest;
    let coarsest = SCALLOPS.into_iter().rev().find(|h| *h <= COARSEST * diameter);
    let chosen = SCALLOPS[1..].iter().copied().find(enough);
    chosen.unwrap_or(f64::INFINITY).min(coarsest.unwrap_or(SCALLOPS[0]))
}

/// The least usual tolerance that is not finer than facets `off` mm off a smooth surface, but no coarser than half the
/// coarsest cusp.
fn tolerance_for(off: f64, diameter: f64) -> f64 {
    let usual = TOLERANCES.into_iter().filter(|t| *t <= OF_SCALLOP * COARSEST * diameter);
    usual.reduce(|chosen, next| if chosen < off { next } else { chosen }).unwrap_or(TOLERANCES[0])
}

fn reason(diameter: f64, concave_radius: f64) -> String {
    if 0.5 * diameter < concave_radius {
        format!("the smallest concave radius of the surface is {concave_radius:.2} mm")
    } else {
        format!("does not fit the smallest concave radius of {concave_radius:.2} mm")
    }
}
