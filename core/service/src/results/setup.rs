//! What is to be set up at the machine.

use super::program::WrittenProgram;
use evencut_core::job::{Job, StockShape};
use evencut_core::machine::{Carries, Chain, RotaryAxis, SpindleDirection, WorkOffset};
use evencut_core::plan::Planned;
use evencut_core::tool::AssemblyPart;
use evencut_core::units::per_minute;
use evencut_output::report::{SetupFigures, SetupTool};

/// `is_first`: whether no operation has cut before.
pub(super) fn figures(
    job: &Job,
    planned: &Planned,
    program: Option<&WrittenProgram>,
    is_first: bool,
) -> SetupFigures {
    let rotary = |axis: &RotaryAxis| {
        let (what, from) = match axis.carries {
            Carries::Table => ("table", "program zero"),
            Carries::Head => ("head", "the gauge line"),
        };
        let centre = axis.centre;
        let (x, y, z) = (centre.x, centre.y, centre.z);
        let d = axis.direction;
        let about = match (d.x, d.y, d.z) {
            (1.0, 0.0, 0.0) => "X".to_owned(),
            (0.0, 1.0, 0.0) => "Y".to_owned(),
            (0.0, 0.0, 1.0) => "Z".to_owned(),
            (i, j, k) => format!("({i:.4}, {j:.4}, {k:.4})"),
        };
        let letter = axis.letter;
        format!(
            "{what} {letter}, counter-clockwise about {about}, centre ({x:.3}, {y:.3}, {z:.3}) from {from}"
        )
    };
    let chain = job.machine.axes.chain();
    SetupFigures {
        program: program.map(|program| program.figures.clone()),
        tool: tool(job),
        spindle_per_min: per_minute(job.cut.spindle),
        spindle_direction: match job.setup.spindle {
            SpindleDirection::Clockwise => "clockwise".to_owned(),
            SpindleDirection::CounterClockwise => "counter-clockwise".to_owned(),
        },
        coolant: job.setup.coolant.name().to_owned(),
        feed_mm_per_min: per_minute(job.cut.feed),
        axial_depth_mm: is_first.then_some(job.cut.axial_depth),
        allowance_mm: job.cut.allowance,
        work_offset: job.setup.work_offset.map(WorkOffset::name).map(str::to_owned),
        rotary_axes: chain.into_iter().flat_map(Chain::axes).map(rotary).collect(),
        stock: job.stock.as_ref().filter(|_| is_first).map(stock),
        avoid: job.avoid.iter().map(|a| format!("{} by {:.3} mm", a.name, a.distance)).collect(),
        rapid_plane_mm: planned.rapid_plane,
        reach: program.map(|program| program.reach.clone()).unwrap_or_default(),
    }
}

/// Where the material ends, in words.
fn stock(shape: &StockShape) -> String {
    match shape {
        StockShape::File(file) => format!("all of it in {file}"),
        StockShape::Box([a, b]) => format!(
            "box from ({:.3}, {:.3}, {:.3}) to ({:.3}, {:.3}, {:.3})",
            a.x, a.y, a.z, b.x, b.y, b.z
        ),
    }
}

fn tool(job: &Job) -> SetupTool {
    let shank = job.assembly.sections.iter().find(|s| s.part == AssemblyPart::Shank);
    let length = job.machine.axes.chain().map(Chain::gauge_length).filter(|length| *length > 0.0);
    SetupTool {
        number: job.setup.tool_number.into(),
        length_offset: job.setup.length_offset.into(),
        diameter_offset: job.setup.diameter_offset.into(),
        kind: job.tool.kind().name().to_owned(),
        diameter_mm: 2.0 * job.tool.radius(),
        corner_radius_mm: job.tool.corner_radius(),
        flutes: job.flutes.into(),
        length_mm: shank.map(|_| job.assembly.cutter_length),
        shank_diameter_mm: shank.map(|s| 2.0 * s.radii[0]),
        stickout_mm: shank.map(|s| s.heights[1]),
        gauge_length_mm: length,
    }
}
