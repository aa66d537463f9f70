//! Faults as JSON, with the places that an editor counts.

use super::editor::units;
use evencut_core::job::{self, Beside, Fault, Resolved, Severity, SurfaceSource, line_and_column};
use evencut_service::faults::NamedFile;
use serde::Serialize;
use serde_json::{Value, json};

/// Why there is no answer.
#[derive(Debug, PartialEq, Serialize)]
#[serde(rename_all = "camelCase")]
pub enum Failure {
    /// A fault of the job, as [`as_json`] tells it.
    Fault(Value),
    /// What is wrong with a file.
    Message(String),
}

impl Failure {
    /// A fault of the job `source`.
    pub fn of(fault: &Fault, source: &str) -> Self {
        Self::Fault(as_json(fault, Severity::Error, source))
    }
}

/// What is wrong with a job, and what it names. `surfaces`: names of the files that are there; `beside`: those that it is
/// completed with, by their names in the job.
pub fn check(source: &str, surfaces: &[String], beside: &[(String, Vec<u8>)]) -> Value {
    let mut named = Vec::new();
    let read = job::read_with(source.as_bytes(), &mut |file, name| {
        named.push(name.to_owned());
        held_beside(source, file, name, beside)
    });
    let mut found = match read {
        Err(faults) => {
            let faults: Vec<Value> =
                faults.0.iter().map(|fault| as_json(fault, Severity::Error, source)).collect();
            json!({ "faults": faults, "surface": null, "avoid": [], "stock": null, "post": null, "blades": [], "name": null })
        }
        Ok(resolved) => found(&resolved, source, surfaces),
    };
    found["beside"] = named.into();
    found
}

/// The content of a file that a job is completed with, or that it is not there.
pub fn held_beside(
    source: &str,
    file: Beside,
    name: &str,
    beside: &[(String, Vec<u8>)],
) -> Result<Vec<u8>, Fault> {
    let held = beside.iter().find(|(held, _)| held == name).map(|(_, bytes)| bytes.clone());
    held.ok_or_else(|| NamedFile::Beside(file).missing(name, source.as_bytes()))
}

/// What a job that can be read names, and what of it is missing.
fn found(resolved: &Resolved, source: &str, surfaces: &[String]) -> Value {
    let surface = match &resolved.job.surface.source {
        SurfaceSource::File(file) => Some(file.as_str()),
        SurfaceSource::Analytic(_) => None,
    };
    let meshes: Vec<(NamedFile, &str)> = NamedFile::meshes(&resolved.job).collect();
    let names = |is_stock: bool| {
        let of = meshes.iter().filter(move |(file, _)| (*file == NamedFile::Stock) == is_stock);
        of.map(|(_, name)| *name)
    };
    let is_missing = |file: &&str| !surfaces.iter().any(|held| is_called(file, held));
    let missing = |file: NamedFile| move |name: &str| file.missing(name, source.as_bytes());
    let no_surface = surface.filter(is_missing).map(missing(NamedFile::Surface));
    let no_mesh = meshes.iter().filter(|(_, name)| is_missing(name));
    let no_mesh = no_mesh.map(|(file, name)| missing(*file)(name));
    let blades = resolved.job.blade_files();
    let no_blade = blades.iter().copied().filter(is_missing).map(missing(NamedFile::Blade));
    let post = resolved.job.post_file();
    let no_post = post.filter(is_missing).map(missing(NamedFile::Post));
    let missing: Vec<Fault> =
        no_surface.into_iter().chain(no_mesh).chain(no_blade).chain(no_post).collect();
    let errors = missing.iter().map(|fault| as_json(fault, Severity::Error, source));
    let warnings = resolved.warnings.0.iter().map(|f| as_json(f, Severity::Warning, source));
    let faults: Vec<Value> = errors.chain(warnings).collect();
    json!({
        "faults": faults,
        "surface": surface,
        "avoid": names(false).collect::<Vec<_>>(),
        "stock": names(true).next(),
        "post": post,
        "blades": blades,
        "name": resolved.job.name,
    })
}

/// Whether a job that names `file` means the file `held`: held files are in no folder, but those of
/// examples.
fn is_called(file: &str, held: &str) -> bool {
    file == held || file.rsplit(['/', '\\']).next() == Some(held)
}

/// A fault with its place: line and column as the command tells them, `from` and `to` in UTF-16
/// units from the start; all null where there is no place.
fn as_json(fault: &Fault, severity: Severity, source: &str) -> Value {
    let severity = match severity {
        Severity::Error => "error",
        Severity::Warning => "warning",
    };
    let place = fault.span.as_ref().map(|span| {
        let (line, column) = line_and_column(source, span.start);
        (line, column, units(source, span.start), units(source, span.end))
    });
    json!({
        "severity": severity,
        "key": fault.key,
        "message": fault.message,
        "help": fault.help,
        "line": place.map(|p| p.0),
        "column": place.map(|p| p.1),
        "from": place.map(|p| p.2),
        "to": place.map(|p| p.3),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const JOB: &str = "version = 1\nname = \"Größe 📏\" # ö\n[surface]\nfile = \"a.stl\"\n\
                       [tool]\ndiameter = 10.0\n[cut]\nscallop = 0.01\nfeed = 1200.0\n";

    #[test]
    fn a_job_whose_surface_is_there_is_good() {
        let found = check(JOB, &["a.stl".into()], &[]);
        assert_eq!(
            found,
            json!({
                "faults": [],
                "surface": "a.stl",
                "avoid": [], "stock": null, "post": null, "beside": [],
                "blades": [],
                "name": "Größe 📏",
            })
        );
    }

    #[test]
    fn an_avoided_mesh_that_is_not_there_is_named() {
        let job = format!(
            "{JOB}[[avoid]]\nfile = \"clamp.stl\"\n[[avoid]]\nfile = \"parts/pin.stl\"\ndistance = 0\n"
        );
        let found = check(&job, &["a.stl".into(), "clamp.stl".into()], &[]);
        let message = found["faults"][0]["message"].as_str().unwrap();
        assert!(message.contains("parts/pin.stl"), "{message}");
        assert_eq!(found["faults"][0]["line"], 13);
        assert_eq!(found["avoid"], json!(["clamp.stl", "parts/pin.stl"]));
        let all = ["a.stl".into(), "clamp.stl".into(), "pin.stl".into()];
        assert_eq!(check(&job, &all, &[])["faults"], json!([]));
    }

    #[test]
    fn a_library_of_tools_is_asked_for_and_read() {
        let job = JOB.replace("diameter = 10.0", "library = \"a.tools.toml\"\nnumber = 7");
        let surfaces = ["a.stl".into()];
        let found = check(&job, &surfaces, &[]);
        let message = found["faults"][0]["message"].as_str().unwrap();
        assert!(
            message.contains("no file a.tools.toml") && found["beside"] == json!(["a.tools.toml"])
        );
        let tools = |bytes: &[u8]| [("a.tools.toml".to_owned(), bytes.to_vec())];
        let found = check(&job, &surfaces, &tools(b"[[tool]]\nnumber = 7\ndiameter = 10\n"));
        assert_eq!((&found["faults"], &found["surface"]), (&json!([]), &json!("a.stl")));
        let found = check(&job, &surfaces, &tools(b"[[tool]]\nnumber = 8\ndiameter = 10\n"));
        assert!(
            found["faults"][0]["line"] == 7 && found["beside"] == json!(["a.tools.toml"]),
            "{found}"
        );
    }

    #[test]
    fn a_surface_is_found_whatever_folder_is_named() {
        let job = JOB.replace("a.stl", "parts/left/a.stl");
        assert_eq!(check(&job, &["a.stl".into()], &[])["faults"], json!([]));
        assert_eq!(check(&job, &["left/a.stl".into()], &[])["faults"].as_array().unwrap().len(), 1);
    }

    #[test]
    fn places_count_lines_characters_and_units() {
        let found = check(JOB, &[], &[]);
        let fault = &found["faults"][0];
        assert_eq!((&fault["line"], &fault["column"]), (&json!(4), &json!(8)));
        let units: Vec<u16> = JOB.encode_utf16().collect();
        let range = |key: &str| fault[key].as_u64().unwrap() as usize;
        let marked = String::from_utf16(&units[range("from")..range("to")]).unwrap();
        assert_eq!(marked, "\"a.stl\"");
    }

    #[test]
    fn a_bad_job_has_no_name() {
        let found = check(&JOB.replace("feed", "fed"), &[], &[]);
        assert!(found["name"].is_null() && found["faults"][0]["severity"] == "error");
    }

    #[test]
    fn failures_are_told_apart() {
        let message = Failure::Message("no surface".into());
        assert_eq!(json!(message), json!({ "message": "no surface" }));
        let fault = evencut_service::faults::fault("too steep".into(), Some(12..16));
        let told = json!(Failure::of(&fault, JOB));
        assert_eq!(told["fault"]["message"], "too steep");
        assert_eq!((&told["fault"]["line"], &told["fault"]["column"]), (&json!(2), &json!(1)));
    }
}
