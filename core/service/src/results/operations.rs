//! A job of several operations → the files of its results.
//!
//! Each operation is planned and judged like a job of its own, with the material that those before it left. Its files
//! are those of a job with the number of the operation before their names; the job as it was planned, the program and
//! the report of all are common.

use super::program::{WrittenProgram, checked, read_back, setting};
use super::{Input, Inputs, OutputFile, Part, Results, ResultsError, ResultsOptions, Written};
use evencut_core::job::{Job, Operation, Resolved};
use evencut_core::plan::{Files, PlanError, Prepared, Stage, SurfaceKeys, plan_on, stock_of};
use evencut_core::toolpath::Toolpath;
use evencut_output::post::{Dialect, OperationProgram, program_of_operations};
use evencut_output::report::{
    FORMAT, FileRecord, OperationFigures, OperationsReport, ProgramFigures, Versions,
};

/// The results of a job of several operations.
#[derive(Clone, Debug)]
pub struct OperationsResults {
    /// All files, the report last.
    pub files: Vec<OutputFile>,
    /// The report of all.
    pub report: OperationsReport,
    /// The results of each operation, without its files.
    pub operations: Vec<Results>,
}

/// Why there are none, and in which operation, from 1.
#[derive(Debug)]
pub struct OperationError {
    /// Number of the operation.
    pub operation: usize,
    /// Why.
    pub error: Box<ResultsError>,
}

impl OperationError {
    fn of(number: usize) -> impl Fn(ResultsError) -> Self {
        move |error| Self { operation: number, error: error.into() }
    }
}

/// Plans the operations of a job and writes all files that it requests.
///
/// As [`results()`](super::results()); `progress` is also given the number of the operation.
///
/// # Errors
/// [`OperationError`]; no partial results are returned.
pub fn operations_results(
    resolved: &Resolved,
    job_file: Input,
    files: Files,
    options: ResultsOptions,
    progress: &mut dyn FnMut(usize, Stage, f64),
) -> Result<OperationsResults, OperationError> {
    let mut all =
        All { job: &resolved.job, files: Vec::new(), done: Vec::new(), skipped: Vec::new() };
    all.add("job.resolved.toml", resolved.to_toml());
    let mut stock = stock_of(&resolved.job);
    let mut prepared = None;
    let jobs: Vec<Job> = resolved.operations.iter().enumerate().map(of_operation).collect();
    let mut inputs = Vec::new();
    for (i, job) in jobs.iter().enumerate() {
        let of = OperationError::of(i + 1);
        inputs.push(Inputs::new(job, job_file, files).map_err(&of)?);
    }
    let is_common = inputs.iter().zip(&jobs).all(|(inputs, job)| {
        inputs.dialect.as_ref().is_some_and(|dialect| dialect.changes_tools(&job.machine.axes))
    });
    for (i, inputs) in inputs.iter_mut().enumerate() {
        let number = i + 1;
        let of = OperationError::of(number);
        let progress = &mut |stage, part| progress(number, stage, part);
        inputs.part = Some(Part { number, has_own_program: !is_common });
        let job = inputs.job;
        let is_known = |prepared: &std::sync::Arc<Prepared>| prepared.is_of(job);
        let ground = match prepared.take().filter(is_known) {
            Some(prepared) => prepared,
            None => Prepared::new(SurfaceKeys::of(job), files, options.threads, progress)
                .map_err(|error| of(error.into()))?,
        };
        let planned = match plan_on(&ground, job, &stock, options.threads, progress) {
            Ok(planned) => planned,
            // It has nothing to cut, or no way to: all else is as it was to be.
            Err(error @ (PlanError::NoRest { .. } | PlanError::RestTooNarrow { .. }))
                if !all.done.is_empty() =>
            {
                all.skipped.push(format!("operation {number}: {error}"));
                prepared = Some(ground);
                continue;
            }
            Err(error) => return Err(of(error.into())),
        };
        let written = Written::of(inputs, &planned).map_err(&of)?;
        let judged =
            inputs.judge(&planned, &stock, options, progress).map_err(|error| of(error.into()))?;
        let mut results =
            written.finish(inputs, &planned, judged.as_ref(), options.threads, progress);
        all.files.append(&mut results.files);
        let rapid_plane = planned.rapid_plane;
        stock = stock.after(planned.earlier(job));
        all.done.push(Done { index: i, results, path: planned.toolpath, rapid_plane });
        prepared = Some(ground);
    }
    let of = OperationError::of(jobs.len());
    let mut report = all.report(&resolved.operations, &inputs);
    let dialect = inputs.first().and_then(|inputs| inputs.dialect.as_ref());
    if let Some(dialect) = dialect.filter(|_| is_common) {
        let (program, findings) = all.program(&jobs, &resolved.operations, dialect).map_err(&of)?;
        report.program = Some(ProgramFigures {
            file: program.name.clone(),
            post: dialect.name().to_owned(),
            number: resolved.job.setup.program_number.into(),
            blocks: program.bytes.iter().filter(|b| **b == b'\n').count() as u64,
            bytes: program.bytes.len() as u64,
        });
        report.findings = findings;
        all.files.push(program);
    }
    report.passed = report.passed.map(|passed| passed && report.findings.is_empty());
    report.outputs = all.files.iter().map(|f| FileRecord::of(&f.name, &f.bytes)).collect();
    all.add("report.html", report.to_html());
    all.add("report.json", report.to_json());
    let operations = all.done.into_iter().map(|done| done.results).collect();
    Ok(OperationsResults { files: all.files, report, operations })
}

/// A job with the largest tolerance and the largest cutter of all operations: by its own each of them was checked alone.
fn loosest(job: &Job, jobs: &[Job]) -> Job {
    let mut loosest = job.clone();
    for job in jobs {
        loosest.cut.tolerance = loosest.cut.tolerance.max(job.cut.tolerance);
        if job.tool.radius() > loosest.tool.radius() {
            loosest.tool = job.tool;
        }
    }
    loosest
}

/// The job of an operation, with its name.
fn of_operation((i, operation): (usize, &Operation)) -> Job {
    let name = format!("{}, operation {}: {}", operation.job.name, i + 1, operation.name);
    Job { name, ..operation.job.clone() }
}

/// An operation that is planned.
struct Done {
    /// Index of the operation.
    index: usize,
    results: Results,
    path: Toolpath,
    rapid_plane: f64,
}

/// The files so far.
struct All<'a> {
    job: &'a Job,
    files: Vec<OutputFile>,
    done: Vec<Done>,
    /// Operations that cut nothing, and why.
    skipped: Vec<String>,
}

impl All<'_> {
    fn add(&mut self, name: &str, text: String) {
        self.files.push(OutputFile { name: name.into(), bytes: text.into_bytes() });
    }

    /// The report of all, without program and outputs.
    fn report(&self, operations: &[Operation], inputs: &[Inputs]) -> OperationsReport {
        let figures = |done: &Done| {
            let (operation, number) = (&operations[done.index], done.index + 1);
            let name = (&operation.name[..], number as u64);
            let file = format!("{number}-report.json");
            OperationFigures::of(name, operation.job.rest, &done.results.report, &file)
        };
        let figures: Vec<OperationFigures> = self.done.iter().map(figures).collect();
        let tools: Vec<u64> = figures.iter().map(|f| f.tool).collect();
        let passed = figures.iter().map(|f| f.passed).collect::<Option<Vec<bool>>>();
        OperationsReport {
            format: FORMAT,
            job: self.job.name.clone(),
            versions: Versions { evencut: env!("CARGO_PKG_VERSION").into(), job_file: 1 },
            inputs: inputs.first().map_or_else(Vec::new, Inputs::records),
            program: None,
            length_mm: figures.iter().map(|f| f.length_mm).sum(),
            machine_time_s: figures.iter().map(|f| f.machine_time_s).sum(),
            tool_changes: tools.windows(2).filter(|w| w[0] != w[1]).count() as u64,
            passed: passed.map(|all| all.into_iter().all(|passed| passed)),
            findings: Vec::new(),
            skipped: self.skipped.clone(),
            operations: figures,
            outputs: Vec::new(),
        }
    }

    /// The program of all operations, and what is wrong with it.
    fn program(
        &self,
        jobs: &[Job],
        operations: &[Operation],
        dialect: &Dialect,
    ) -> Result<(OutputFile, Vec<String>), ResultsError> {
        let plane = self.done.iter().map(|done| done.rapid_plane).fold(f64::INFINITY, f64::min);
        let mut sections = Vec::new();
        for done in &self.done {
            let (job, name) = (&jobs[done.index], operations[done.index].name.clone());
            let options = WrittenProgram::options(job, &self.job.name, done.rapid_plane);
            sections.push(OperationProgram { name, path: &done.path, options });
        }
        let program = program_of_operations(&sections, dialect)?;
        let name = format!("program.{}", program.extension);
        // Each operation was read back by itself; together they are, where the machine is the same for all.
        let is_same = jobs.iter().all(|job| job.machine.axes == self.job.machine.axes);
        let mut findings = Vec::new();
        if is_same {
            let points = self.done.iter().flat_map(|done| done.path.points.iter().copied());
            let path = Toolpath { points: points.collect() };
            match read_back(&program.text, self.job) {
                Ok(read) => {
                    let loosest = loosest(self.job, jobs);
                    let settings =
                        self.done.iter().map(|done| setting(&jobs[done.index])).collect();
                    let rounding = dialect.rounding();
                    findings = checked(&read, &loosest, &path, plane, rounding, settings);
                }
                Err(error) if self.job.post_file().is_none() => return Err(error.into()),
                Err(error) if error.displaces() => findings.push(error.to_string()),
                // Each operation has the warning that it is not checked.
                Err(_) => {}
            }
        }
        Ok((OutputFile { name, bytes: program.text.into_bytes() }, findings))
    }
}
