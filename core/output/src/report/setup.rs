//! What is to be set up at the machine before the program runs.

use serde::Serialize;

/// The setup of a program.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct SetupFigures {
    /// The program; null where none is written.
    pub program: Option<ProgramFigures>,
    /// The tool.
    pub tool: SetupTool,
    /// Spindle speed, rev/min.
    pub spindle_per_min: f64,
    /// Direction of the spindle, seen from it towards the tip: clockwise or counter-clockwise.
    pub spindle_direction: String,
    /// Coolant: off, flood, mist, air or through.
    pub coolant: String,
    /// Nominal feed, mm/min.
    pub feed_mm_per_min: f64,
    /// Stock that is left over the surface before this cut, along its normal, mm; null where it is what earlier operations
    /// left.
    pub axial_depth_mm: Option<f64>,
    /// Stock that is left on the surface after it, mm.
    pub allowance_mm: f64,
    /// Work offset that the program calls; null where it is the one in force.
    pub work_offset: Option<String>,
    /// Rotary axes of the machine, the one nearest to the workpiece first.
    pub rotary_axes: Vec<String>,
    /// Where the material ends before the first operation; null where only its thickness over the surface is known.
    pub stock: Option<String>,
    /// What stands beside the part and is avoided, with its distance.
    pub avoid: Vec<String>,
    /// Height along the tool axis, from program zero, at and above which rapids run, mm.
    pub rapid_plane_mm: f64,
    /// Where the axes of the machine go in the program.
    pub reach: Vec<ReachFigures>,
}

/// The program that is written.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct ProgramFigures {
    /// Name of its file.
    pub file: String,
    /// Post-processor.
    pub post: String,
    /// Number of the program, where the post writes it.
    pub number: u64,
    /// Lines.
    pub blocks: u64,
    /// Size, bytes.
    pub bytes: u64,
}

/// The tool that is to be in the spindle.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct SetupTool {
    /// Number in the tool table.
    pub number: u64,
    /// Number of the offset of its length (H).
    pub length_offset: u64,
    /// Number of the offset of its diameter (D).
    pub diameter_offset: u64,
    /// ball, flat or bull.
    pub kind: String,
    /// Diameter, mm.
    pub diameter_mm: f64,
    /// Corner radius, mm.
    pub corner_radius_mm: f64,
    /// Number of flutes.
    pub flutes: u64,
    /// From the tip to where the shank begins, mm; null where the job does not say.
    pub length_mm: Option<f64>,
    /// Diameter of the shank, mm; null where the job does not say.
    pub shank_diameter_mm: Option<f64>,
    /// How far it stands out of the holder, mm; null where the job does not say.
    pub stickout_mm: Option<f64>,
    /// From the tip to the spindle's gauge line, mm; null where the job does not need it.
    pub gauge_length_mm: Option<f64>,
}

/// Where an axis of the machine goes.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct ReachFigures {
    /// Its letter.
    pub axis: String,
    /// Least position, mm or degrees.
    pub least: f64,
    /// Greatest position, mm or degrees.
    pub greatest: f64,
    /// mm or deg.
    pub unit: String,
}

impl SetupFigures {
    /// What is set up, and how, for a reader.
    pub(super) fn lines(&self) -> Vec<(&'static str, String)> {
        let mut lines = Vec::new();
        if let Some(p) = &self.program {
            let size =
                format!("{}, post {}, {} blocks, {} bytes", p.file, p.post, p.blocks, p.bytes);
            lines.push(("program", size));
        }
        lines.push(("tool", self.tool.words()));
        let turning =
            format!("S{:.0} per minute, {}", self.spindle_per_min, self.spindle_direction);
        lines.push(("spindle", turning));
        lines.push(("coolant", self.coolant.clone()));
        lines.push(("feed", format!("{:.0} mm/min", self.feed_mm_per_min)));
        let before = match self.axial_depth_mm {
            Some(depth) => format!("{:.3} mm over the surface before", depth + self.allowance_mm),
            None => "what the operations before left".to_owned(),
        };
        let ends = self.stock.as_ref().map_or_else(String::new, |stock| format!("; {stock}"));
        let stock = format!("{before}, {:.3} mm after{ends}", self.allowance_mm);
        lines.push(("stock", stock));
        let offset = self.work_offset.as_deref().unwrap_or("the one in force");
        lines.push((
            "work offset",
            format!("{offset}; zero is the origin of the part's file, as the job places it"),
        ));
        if !self.rotary_axes.is_empty() {
            lines.push(("rotary axes", self.rotary_axes.join("; ")));
        }
        if !self.avoid.is_empty() {
            lines.push(("keep clear of", self.avoid.join("; ")));
        }
        let plane = match self.rotary_axes.is_empty() {
            true => format!("at Z {:.3} and above", self.rapid_plane_mm),
            false => {
                format!("tip {:.3} mm and more from zero, along the tool", self.rapid_plane_mm)
            }
        };
        lines.push(("rapids", plane));
        let reach = self.reach.iter().map(|r| {
            let unit = if r.unit == "deg" { "°" } else { "" };
            format!("{} {:.2}{unit} to {:.2}{unit}", r.axis, r.least, r.greatest)
        });
        let reach: Vec<String> = reach.collect();
        if !reach.is_empty() {
            lines.push(("axes go", reach.join(", ")));
        }
        lines
    }
}

impl SetupTool {
    fn words(&self) -> String {
        let mut words = format!(
            "T{}, H{}, D{}: {} end mill, diameter {:.3} mm, corner radius {:.3} mm, {} flutes",
            self.number,
            self.length_offset,
            self.diameter_offset,
            self.kind,
            self.diameter_mm,
            self.corner_radius_mm,
            self.flutes
        );
        for (what, length) in [
            ("cutter length", self.length_mm),
            ("shank", self.shank_diameter_mm),
            ("stickout at least", self.stickout_mm),
            ("tip to gauge line", self.gauge_length_mm),
        ] {
            words.extend(length.map(|length| format!(", {what} {length:.2} mm")));
        }
        words
    }
}
