//! Planning for a page.

use evencut_core::job::Job;
use evencut_core::plan::Stage;
use evencut_output::preview::Linked;
use evencut_output::report::Report;
use evencut_service::results::{
    Early, Input, OutputFile, Results, ResultsOptions, Watch, linked_results,
};

use crate::fault::Failure;
use crate::request::JobFiles;

/// The worker's own thread is the only one.
const OPTIONS: ResultsOptions = ResultsOptions { threads: 1, verify: true };

/// A planned job, or what of it is there.
pub struct Plan {
    /// Its files.
    pub files: Vec<OutputFile>,
    /// What is reported; `None` while the path is only laid.
    pub report: Option<Report>,
    /// The numbers behind the pictures.
    pub linked: Linked,
    /// The job.
    pub job: Job,
}

/// Plans a job. `name`: that of its file.
///
/// `progress` is called with a stage and the part of it that is done; `show` with the plan as far as it is there: once
/// the path is laid, and once it is planned but not judged.
///
/// # Errors
/// The fault.
pub fn plan(
    name: &str,
    given: &JobFiles,
    progress: &mut dyn FnMut(Stage, f64),
    show: &mut dyn FnMut(Plan),
) -> Result<Plan, Failure> {
    let job = given.job()?;
    let mut show = |early: Early| {
        let Early { files, linked, report } = early;
        show(Plan { files, report, linked, job: job.clone() });
    };
    let input = Input { name, bytes: given.source.as_bytes() };
    let watch = Watch { progress, show: &mut show };
    match linked_results(&job, input, given.named(), OPTIONS, watch) {
        Ok((Results { files, report, .. }, linked)) => {
            Ok(Plan { files, report: Some(report), linked, job })
        }
        Err(error) => Err(given.failure(&job, &error)),
    }
}
