//! Planning for a page.

use evencut_core::job::{self, Job, Severity, SurfaceSource};
use evencut_core::plan::Files;
use evencut_core::preview::Linked;
use evencut_core::report::Report;
use evencut_service::failure;
use evencut_service::results::{
    Early, Input, OutputFile, Results, ResultsOptions, Watch, linked_results,
};
use evencut_service::stages::{done, words};
use js_sys::{Function, Uint8Array};
use wasm_bindgen::JsValue;
use wasm_bindgen::prelude::wasm_bindgen;

use crate::{fault, tables};

/// The page's own thread is the only one.
const OPTIONS: ResultsOptions = ResultsOptions { threads: 1, verify: true };

/// A planned job, or what of it is there: its files, and the numbers behind their pictures.
#[wasm_bindgen]
pub struct Plan {
    files: Vec<OutputFile>,
    report: Option<Report>,
    linked: Linked,
    job: Job,
}

/// Plans a job.
///
/// `name`: the job file's; `surface`: content of the surface file that it names, if it names one; `wall`: that of the
/// mesh beside it.
/// `progress` is called with a stage in words, the part of it and that of all the work that is done; `show` with the
/// [`Plan`] as far as it is there: once the path is laid, and once it is planned but not judged.
///
/// # Errors
/// The fault, as JSON.
#[wasm_bindgen]
pub fn plan(
    name: &str,
    source: &str,
    surface: Option<Vec<u8>>,
    wall: Option<Vec<u8>>,
    progress: &Function,
    show: &Function,
) -> Result<Plan, String> {
    let bytes = source.as_bytes();
    let error = |fault| fault::as_json(fault, Severity::Error, source).to_string();
    let job = match job::read(bytes) {
        Ok(resolved) => resolved.job,
        Err(faults) => return Err(faults.0.first().map(error).unwrap_or_default()),
    };
    let file = match &job.surface.source {
        SurfaceSource::File(file) => Some(file.as_str()),
        SurfaceSource::Analytic(_) => None,
    };
    let files = Files { surface: surface.as_deref(), wall: wall.as_deref() };
    // A page that cannot show what is there so far still wants the plan.
    let mut report = |stage, part: f64| {
        let done = done(stage, part);
        let _ = progress.call3(&JsValue::NULL, &words(stage).into(), &part.into(), &done.into());
    };
    let mut show = |early: Early| {
        let Early { files, linked, report } = early;
        let _ =
            show.call1(&JsValue::NULL, &Plan { files, report, linked, job: job.clone() }.into());
    };
    let watch = Watch { progress: &mut report, show: &mut show };
    let made = linked_results(&job, Input { name, bytes }, files, OPTIONS, watch);
    match made {
        Ok((Results { files, report }, linked)) => {
            Ok(Plan { files, report: Some(report), linked, job })
        }
        Err(failed) => Err(error(&failure::explain(&failed, bytes, file).1)),
    }
}

#[wasm_bindgen]
impl Plan {
    /// Names of the files.
    pub fn names(&self) -> Vec<String> {
        self.files.iter().map(|file| file.name.clone()).collect()
    }

    /// Content of a file; empty if there is no such file.
    pub fn file(&self, name: &str) -> Uint8Array {
        let file = self.files.iter().find(|file| file.name == name);
        Uint8Array::from(file.map_or(&[][..], |file| &file.bytes))
    }

    /// What is reported, as JSON; undefined while the path is only laid.
    pub fn report(&self) -> Option<String> {
        self.report.as_ref().map(Report::to_json)
    }

    /// What the command prints; undefined while the path is only laid.
    pub fn summary(&self) -> Option<String> {
        self.report.as_ref().map(Report::summary)
    }

    /// Where pictures show places, the cutter, limits and colours, as JSON.
    pub fn scales(&self) -> String {
        tables::scales(&self.linked, &self.job).to_string()
    }

    /// A table by its name; undefined if there is no such table.
    pub fn table(&self, name: &str) -> JsValue {
        tables::table(&self.linked, name)
    }
}
