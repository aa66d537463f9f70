//! Tables as typed arrays, and what is needed to read them.

use evencut_core::job::Job;
use evencut_core::preview::{Linked, Placement};
use evencut_core::toolpath::MoveKind;
use js_sys::{Float32Array, Uint8Array, Uint32Array};
use serde_json::{Value, json};
use wasm_bindgen::JsValue;

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

/// A table by its name; undefined if there is no such table.
pub fn table(linked: &Linked, name: &str) -> JsValue {
    let path = &linked.path;
    let single = |values: &Vec<f32>| Float32Array::from(values.as_slice()).into();
    let whole = |values: &Vec<u32>| Uint32Array::from(values.as_slice()).into();
    let small = |values: &Vec<u8>| Uint8Array::from(values.as_slice()).into();
    match name {
        "kind" => small(&path.kind),
        "pass" => whole(&path.pass),
        "region" => whole(&path.region),
        "time" => single(&path.time),
        "tip" => single(&path.tip),
        "axis" => single(&path.axis),
        "contact" => single(&path.contact),
        "flat" => single(&path.flat),
        "feed" => single(&path.feed),
        "rate" => single(&path.rate),
        "engagement" => single(&path.engagement),
        "plainTime" => single(&linked.plain[0]),
        "plainRate" => single(&linked.plain[1]),
        "samplePlace" => single(&linked.samples.place),
        "sampleResidual" => single(&linked.samples.residual),
        "sampleRate" => single(&linked.samples.rate),
        "sampleResidualTone" => small(&linked.samples.residual_tone),
        "sampleRateTone" => small(&linked.samples.rate_tone),
        "sampleState" => small(&linked.samples.state),
        "meshPositions" => single(&linked.mesh.positions),
        "meshFaces" => whole(&linked.mesh.faces),
        _ => JsValue::UNDEFINED,
    }
}
