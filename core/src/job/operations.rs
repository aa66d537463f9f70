//! The operations of a job: each is resolved as if it stood alone, and then held against those before it.

use super::complete::{Job, Operation, Resolved};
use super::document::{Document, Documents};
use super::fault::{Fault, Faults};
use super::file::{
    CutTable, ForceTable, JobFile, OperationTable, PathTable, RegionsTable, ToolTable,
    TrochoidTable,
};
use super::merged::Written;
use super::path::Pattern;
use super::write::{text, toml_of};
use serde::Serialize;

/// How much an operation may leave more than one before it, mm: nothing, but for rounding.
const MORE: f64 = 1e-9;

/// The end of a job file.
#[derive(Serialize)]
struct Operations {
    operation: Vec<OperationTable>,
}

/// Resolves the operations of a job, each by `resolve`.
///
/// # Errors
/// The faults of all, each once.
pub(super) fn resolved(
    documents: Documents,
    mut resolve: impl FnMut(Document) -> Result<Resolved, Faults>,
) -> Result<Resolved, Faults> {
    let Documents { list, operations, faults } = documents;
    let mut faults = faults.0;
    let mut all: Vec<Resolved> = Vec::new();
    for (document, number) in list.into_iter().zip(1..) {
        match resolve(document) {
            Ok(resolved) => all.push(resolved),
            Err(found) => found.0.into_iter().for_each(|fault| {
                add(&mut faults, of_operation(fault, number, operations.is_empty()));
            }),
        }
    }
    if faults.is_empty() {
        faults = contradictions(&all, &operations);
    }
    if !faults.is_empty() || all.is_empty() {
        let mut faults = Faults(faults);
        faults.sort();
        return Err(faults);
    }
    let (mut warnings, mut beside) = (Vec::new(), Vec::new());
    let mut list = Vec::new();
    for ((i, one), written) in all.iter().enumerate().zip(&operations) {
        let name = written.name.clone().unwrap_or_else(|| format!("operation {}", i + 1));
        list.push(Operation { name, job: Job { rest: written.is_rest, ..one.job.clone() } });
    }
    let mut job = None;
    for (one, number) in all.into_iter().zip(1..) {
        one.warnings.0.into_iter().for_each(|warning| {
            add(&mut warnings, of_operation(warning, number, operations.is_empty()));
        });
        for file in one.beside {
            if !beside.contains(&file) {
                beside.push(file);
            }
        }
        job = job.or(Some(one.job));
    }
    let mut warnings = Faults(warnings);
    warnings.sort();
    match job {
        Some(job) => Ok(Resolved { job, operations: list, warnings, beside }),
        None => Err(Faults::default()),
    }
}

/// Adds a fault that is not known yet: what the job says is found again with every operation.
fn add(faults: &mut Vec<Fault>, fault: Fault) {
    let is_same = |known: &Fault| known.span == fault.span && known.message == fault.message;
    if !faults.iter().any(is_same) {
        faults.push(fault);
    }
}

/// A fault that says in which operation it was found, where no place does.
fn of_operation(fault: Fault, number: usize, is_alone: bool) -> Fault {
    if is_alone || fault.span.is_some() {
        return fault;
    }
    Fault { message: format!("operation {number}: {}", fault.message), ..fault }
}

/// What operations may not be together.
fn contradictions(all: &[Resolved], operations: &[Written]) -> Vec<Fault> {
    let mut faults = Vec::new();
    let at = |number: usize, message: String, help: &str| {
        let span = operations.get(number).map(|written| written.span.clone());
        Fault::new("operation", message).help(help).at(span)
    };
    if operations.first().is_some_and(|first| first.is_rest) {
        let message = "`rest` in the first operation: there is none before it".to_owned();
        faults.push(at(0, message, "remove it, or put the operation behind another"));
    }
    for (i, one) in all.iter().enumerate().filter(|_| !operations.is_empty()) {
        let (job, number) = (&one.job, i + 1);
        if job.path.pattern == Pattern::Hub || job.hub.is_some() {
            let message = format!("operation {number}: a hub is finished in a job of its own");
            faults.push(at(i, message, "write a job without `[[operation]]` for it"));
        }
        if job.texture.is_some() {
            let message = "a job with operations has no `[texture]`".to_owned();
            faults.push(at(i, message, "write a job of the last operation alone for it"));
        }
        for (k, before) in all[..i].iter().enumerate() {
            let [one, other] = [&before.job, job].map(|job| &job.setup);
            let same = [
                ("tool number", one.tool_number, other.tool_number),
                ("length offset", one.length_offset, other.length_offset),
            ];
            let same = same.into_iter().find(|(_, one, other)| one == other);
            if let Some((what, value, _)) = same.filter(|_| before.job.tool != job.tool) {
                let message = format!(
                    "operations {} and {number} have different cutters, but the same {what} {value}",
                    k + 1
                );
                faults.push(at(
                    i,
                    message,
                    "give each `tool` its `number`, which its offsets follow",
                ));
                break;
            }
            if job.cut.allowance > before.job.cut.allowance + MORE {
                let message = format!(
                    "operation {number} leaves an allowance of {} mm, operation {} before it only {} mm",
                    job.cut.allowance,
                    k + 1,
                    before.job.cut.allowance
                );
                faults.push(at(i, message, "give it a `cut.allowance` of at most that"));
                break;
            }
        }
    }
    faults
}

impl Resolved {
    /// The same, if it is a single operation.
    ///
    /// # Errors
    /// A fault that says that it has several.
    pub fn only(self) -> Result<Self, Faults> {
        if self.operations.is_empty() {
            return Ok(self);
        }
        let count = self.operations.len();
        let message = format!("the job has {count} operations, and here it must be a single one");
        let help =
            "`evencut plan` plans them all; for one alone write a job without `[[operation]]`";
        Err(Faults(vec![Fault::new("operation", message).help(help)]))
    }

    /// The jobs of its operations.
    pub fn jobs(&self) -> impl Iterator<Item = &Job> {
        let only = self.operations.is_empty().then_some(&self.job);
        self.operations.iter().map(|operation| &operation.job).chain(only)
    }

    /// The job as a job file, in mm, mm/min, degrees, with every default written out.
    ///
    /// Read again, it resolves to an equal job.
    pub fn to_toml(&self) -> String {
        if self.operations.is_empty() {
            return self.job.to_toml();
        }
        let of = |operation: &Operation| {
            let JobFile { tool, cut, regions, path, force, trochoid, .. } = operation.job.to_file();
            OperationTable {
                name: Some(operation.name.clone()),
                rest: Some(operation.job.rest),
                tool,
                cut,
                regions,
                path,
                force,
                trochoid,
            }
        };
        let list = Operations { operation: self.operations.iter().map(of).collect() };
        // Only strings, numbers and tables, which TOML can all express.
        let operations = toml_of(&list).unwrap_or_default();
        // Each operation says all of these itself.
        let common = JobFile {
            tool: ToolTable::default(),
            cut: CutTable::default(),
            regions: RegionsTable::default(),
            path: PathTable::default(),
            force: ForceTable::default(),
            trochoid: TrochoidTable::default(),
            ..self.job.to_file()
        };
        format!("{}\n{operations}", text(&common))
    }
}

#[cfg(test)]
mod tests {
    use crate::job::{Faults, Resolved, read};

    const COMMON: &str = "version = 1\n[surface.analytic]\nkind = \"plane\"\n[cut]\nstepover = 2.0\nfeed = 900.0\n\
                          [tool]\ndiameter = 10.0\n[force]\nrelative = 1.5\n";

    fn job(operations: &str) -> Result<Resolved, Faults> {
        read(format!("{COMMON}{operations}").as_bytes())
    }

    fn faults(operations: &str) -> String {
        let text = format!("{COMMON}{operations}");
        read(text.as_bytes()).unwrap_err().render("job.toml", text.as_bytes())
    }

    #[test]
    fn an_operation_says_what_differs() {
        let read = job("[[operation]]\nname = \"semi\"\ncut = { allowance = 0.3 }\n[[operation]]\n\
                        tool = { diameter = 6.0, number = 2 }\ncut = { scallop = 0.01 }\nforce = { mrr_limit = 500.0 }\n\
                        [[operation]]\nrest = true\ntool = { diameter = 3.0, number = 3 }\n")
        .unwrap();
        let [semi, finish, rest] = &read.operations[..] else { panic!("{read:?}") };
        assert_eq!(
            [&semi.name[..], &finish.name, &rest.name],
            ["semi", "operation 2", "operation 3"]
        );
        assert_eq!((semi.job.cut.allowance, finish.job.cut.allowance), (0.3, 0.0));
        assert_eq!(read.job, semi.job);
        let radii = [semi, finish, rest].map(|o| (o.job.tool.radius(), o.job.setup.tool_number));
        assert_eq!(radii, [(5.0, 1), (3.0, 2), (1.5, 3)]);
        // One of two keys that exclude each other replaces the other; without one the job's counts.
        assert_ne!(finish.job.cut.stepover, semi.job.cut.stepover);
        assert_eq!(rest.job.cut.stepover, semi.job.cut.stepover);
        assert_eq!(finish.job.mrr_limit(), 500.0 / 60.0);
        assert_eq!([semi, finish, rest].map(|o| o.job.rest), [false, false, true]);
        assert!(read.clone().only().is_err());
        // Written out and read again it is the same.
        let again = crate::job::read(read.to_toml().as_bytes()).unwrap();
        assert_eq!(again.operations, read.operations);
        // Also where operations have patterns whose keys exclude each other.
        let read = job("[[operation]]\npath = { pattern = \"iso-scallop\", start = \"widest\" }\n[[operation]]\n").unwrap();
        let again = crate::job::read(read.to_toml().as_bytes()).unwrap();
        assert_eq!(again.operations, read.operations);
    }

    #[test]
    fn a_single_operation_is_a_job_without_any() {
        let read = job("").unwrap();
        assert!(read.operations.is_empty());
        assert_eq!(read.jobs().count(), 1);
        assert_eq!(read.clone().only().unwrap(), read);
    }

    #[test]
    fn faults_of_operations_have_their_places() {
        let text = faults("[[operation]]\n[[operation]]\ncut = { feeed = 3.0 }\nspeed = 1\n");
        assert!(text.contains("unknown key") && text.contains("did you mean `feed`?"), "{text}");
        assert!(text.contains("job.toml:13:9") && text.contains("job.toml:14:1"), "{text}");
        // Once, although every operation has it.
        let text = faults("[path]\npattern = \"zigzag\"\n[[operation]]\n[[operation]]\n");
        assert_eq!(text.matches("is not available").count(), 1, "{text}");
        let text = faults("[[operation]]\nrest = true\n");
        assert!(text.contains("there is none before it"), "{text}");
        let text = faults("[[operation]]\n[[operation]]\ntool = { diameter = 4.0 }\n");
        assert!(text.contains("different cutters, but the same tool number 1"), "{text}");
        let same = "tool = { diameter = 4.0, number = 2, length_offset = 1 }\n";
        let text = faults(&format!("[[operation]]\n[[operation]]\n{same}"));
        assert!(
            text.contains("the same length offset 1") && text.contains("job.toml:13"),
            "{text}"
        );
        let text = faults("[[operation]]\n[[operation]]\ncut = { allowance = 0.1 }\n");
        assert!(text.contains("operation 2 leaves an allowance of 0.1 mm"), "{text}");
        let text = faults("[operation]\nname = \"a\"\n");
        assert!(text.contains("[[operation]]"), "{text}");
        let many = "[[operation]]\n".repeat(21);
        assert!(faults(&many).contains("21 items"), "{}", faults(&many));
    }
}
