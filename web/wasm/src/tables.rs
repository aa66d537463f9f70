//! The tables of a plan, and what is needed to read them.

use evencut_core::job::Job;
use evencut_core::toolpath::MoveKind;
use evencut_output::preview::{Linked, Placement};
use serde_json::{Value, json};

/// Where pictures show places, the cutter, limits and colours.
pub fn scales(linked: &Linked, job: &Job) -> Value {
    let placement =
        |p: &Placement| json!({ "x": p.x, "y": p.y, "near": p.near, "drawing": p.drawing });
    let chart = &linked.chart;
    json!({
        "pictures": {
            "flat.svg": placement(&linked.flat),
            "surface.svg": placement(&linked.surface),
            "scallop.svg": linked.scallop.as_ref().map(placement),
            "channel.svg": linked.channel.as_ref().map(placement),
            "removal.svg": linked.removal.as_ref().map(placement),
        },
        "chart": {
            "panels": chart.panels,
            "size": chart.size,
            "duration": chart.duration,
            "top": chart.top,
        },
        "kinds": MoveKind::ALL.map(MoveKind::name),
        "machined": linked.mesh.machined,
        "limit": linked.limit,
        "scallopLimit": linked.scallop_limit,
        "colours": linked.colours,
        "residualColours": linked.residual_colours,
        "rateColours": linked.rate_colours,
        "tool": { "radius": job.tool.radius(), "corner": job.tool.corner_radius() },
    })
}

/// All tables, by the names that the page knows them by.
pub fn tables(linked: &Linked) -> [(&'static str, Numbers<'_>); 21] {
    use Numbers::{Single, Small, Whole};
    let Linked { path, samples, mesh, plain: [plain_time, plain_rate], .. } = linked;
    [
        ("kind", Small(&path.kind)),
        ("pass", Whole(&path.pass)),
        ("region", Whole(&path.region)),
        ("time", Single(&path.time)),
        ("tip", Single(&path.tip)),
        ("axis", Single(&path.axis)),
        ("contact", Single(&path.contact)),
        ("flat", Single(&path.flat)),
        ("feed", Single(&path.feed)),
        ("rate", Single(&path.rate)),
        ("engagement", Single(&path.engagement)),
        ("plainTime", Single(plain_time)),
        ("plainRate", Single(plain_rate)),
        ("samplePlace", Single(&samples.place)),
        ("sampleResidual", Single(&samples.residual)),
        ("sampleRate", Single(&samples.rate)),
        ("sampleState", Small(&samples.state)),
        ("sampleResidualTone", Small(&samples.residual_tone)),
        ("sampleRateTone", Small(&samples.rate_tone)),
        ("meshPositions", Single(&mesh.positions)),
        ("meshFaces", Whole(&mesh.faces)),
    ]
}

/// The numbers of a table.
#[derive(Copy, Clone, Debug, PartialEq)]
pub enum Numbers<'a> {
    /// Whole numbers of one byte.
    Small(&'a [u8]),
    /// Whole numbers.
    Whole(&'a [u32]),
    /// Numbers in single precision.
    Single(&'a [f32]),
}
