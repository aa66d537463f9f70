//! A commented job file to start from.

use std::fmt::Write;

/// What is known of a surface file before a job for it is written.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct SurfaceFacts {
    /// Extents of the bounding box, mm.
    pub size: [f64; 3],
    /// Smallest concave radius of curvature, mm, if known.
    pub smallest_concave_radius: Option<f64>,
    /// Number of connected components.
    pub components: usize,
    /// Whether the mesh bounds a solid: the faces to machine must then be selected.
    pub closed: bool,
}

/// Diameters that cutters are sold in, mm.
const DIAMETERS: [f64; 14] =
    [0.5, 1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0, 12.0, 16.0, 20.0, 25.0];

/// A commented job file for the surface in `file`, with values to start from.
///
/// `file`: name of the surface file relative to the job file. The text reads as a valid job.
pub fn template(file: &str, facts: &SurfaceFacts) -> String {
    let diameter = diameter_for(facts);
    // A hundredth of the diameter per tooth at the default cutting speed.
    let spindle = (150_000.0 / (std::f64::consts::PI * diameter)).min(12_000.0).round();
    let feed = (0.01 * diameter * 2.0 * spindle / 10.0).round().max(1.0) * 10.0;
    let name = toml::Value::String(file.to_owned());
    let [x, y, z] = facts.size;
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
{}
[tool]
kind = \"ball\"              # ball | flat | bull
{:<26} # {}
flutes = 2

[cut]
scallop = 0.01             # cusp height; or stepover = the same side step everywhere
{:<26} # material above the surface, along its normal
feed = {feed:?}
spindle = {spindle:?}
tolerance = 0.005
direction = \"climb\"        # climb | conventional

[path]
order = \"outside-in\"       # outside-in | inside-out
boundary = \"open\"          # open: air outside of the surface; wall: material that stays

[force]
relative = 1.5             # limit of the removal rate, times that of a straight pass
control = \"trochoid\"       # off | trochoid | feed

[machine]
axes = \"3\"                 # 3 | xyzac
clearance = 10.0

[output]
gcode = {{ post = \"linuxcnc\" }}
svg = [\"flat\", \"surface\", \"mrr\"]
",
        selection(facts),
        format!("diameter = {diameter:?}"),
        reason(facts),
        format!("axial_depth = {:?}", (diameter * 5.0).round() / 100.0),
    );
    text
}

/// The largest cutter that fits the concave places with a tenth to spare, and at most a tenth of
/// the middle extent.
fn diameter_for(facts: &SurfaceFacts) -> f64 {
    let mut size = facts.size.map(|s| if s.is_finite() { s.abs() } else { 0.0 });
    size.sort_by(f64::total_cmp);
    let by_size = 0.1 * size[1];
    let by_radius = facts.smallest_concave_radius.map_or(f64::INFINITY, |r| 1.8 * r);
    let bound = by_size.min(by_radius);
    DIAMETERS.into_iter().rev().find(|d| *d <= bound).unwrap_or(DIAMETERS[0])
}

fn reason(facts: &SurfaceFacts) -> String {
    match facts.smallest_concave_radius {
        Some(r) => format!("the smallest concave radius of the surface is {r:.2} mm"),
        None => "no concave place limits it; about a tenth of the surface's width".to_owned(),
    }
}

fn selection(facts: &SurfaceFacts) -> String {
    let component = if facts.components > 1 { ", component = \"largest\"" } else { "" };
    if facts.closed {
        let component = if component.is_empty() { ", component = \"largest\"" } else { component };
        return format!(
            "# The file bounds a solid: only faces that look up are machined.\n\
             select = {{ normal_within = 75.0, of = [0, 0, 1]{component} }}\n"
        );
    }
    match facts.components {
        0 | 1 => String::new(),
        n => format!(
            "# The file has {n} pieces: the largest is machined.\n\
             select = {{ component = \"largest\" }}\n"
        ),
    }
}
