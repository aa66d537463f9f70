//! What the page is answered.

use evencut_core::plan::Stage;
use evencut_service::results::OutputFile;
use evencut_service::results::texture::TextureResults;
use serde_json::Value;

use crate::fault::{self, Failure};
use crate::plan::{Plan, plan};
use crate::request::Request;
use crate::{editor, new_job, texture};

/// An answer.
pub enum Answer {
    /// Words and numbers.
    Words(Value),
    /// A plan.
    Plan(Box<Plan>),
    /// The files of a simulated window, and what the command prints of it.
    Texture { files: Vec<OutputFile>, summary: String },
}

/// Answers a request. A plan calls `progress` with a stage and the part of it that is done, and `show` with what of it is
/// there before its end.
///
/// # Errors
/// Why there is no answer.
pub fn answer(
    request: Request,
    progress: &mut dyn FnMut(Stage, f64),
    show: &mut dyn FnMut(Plan),
) -> Result<Answer, Failure> {
    Ok(match request {
        Request::Completions { source, at } => Answer::Words(editor::completions(&source, at)),
        Request::Explanation { source, at } => Answer::Words(editor::explanation(&source, at)),
        Request::Check { source, surfaces, beside } => {
            Answer::Words(fault::check(&source, &surfaces, &beside))
        }
        Request::NewJob { name, bytes } => Answer::Words(new_job::new_job(&name, &bytes)?.into()),
        Request::Plan { name, job } => Answer::Plan(Box::new(plan(&name, &job, progress, show)?)),
        Request::Texture { job, path, at } => {
            let TextureResults { files, figures } = texture::texture(&job, &path, at)?;
            Answer::Texture { files, summary: figures.summary() }
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::request::JobFiles;
    use crate::tables::{Numbers, tables};

    const JOB: &str = "version = 1
[surface]
analytic = { kind = \"plane\", size = 8, resolution = 1 }
[tool]
diameter = 10
flutes = 2
[cut]
stepover = 0.5
axial_depth = 0.2
feed = 1200
spindle = 6000
[path]
pattern = \"iso-planar\"
angle = 0
";

    fn answered(request: Request) -> Result<Answer, Failure> {
        answer(request, &mut |_, _| {}, &mut |_| {})
    }

    fn job(source: &str) -> JobFiles {
        JobFiles { source: source.into(), ..JobFiles::default() }
    }

    fn fault(result: Result<Answer, Failure>) -> Value {
        match result {
            Err(Failure::Fault(fault)) => fault,
            Err(Failure::Message(message)) => panic!("a message, not a fault: {message}"),
            Ok(_) => panic!("an answer, not a fault"),
        }
    }

    #[test]
    fn a_plan_is_shown_as_far_as_it_is_there() {
        let (mut stages, mut shown) = (0, Vec::new());
        let request = Request::Plan { name: "plane.toml".into(), job: job(JOB) };
        let made = answer(request, &mut |_, _| stages += 1, &mut |plan| {
            shown.push((plan.report.is_some(), plan.linked.samples.state.len()));
        });
        let Ok(Answer::Plan(plan)) = made else { panic!("no plan") };
        assert_eq!(shown, [(false, 0), (true, 0)], "laid, then planned");
        assert!(stages > 0 && plan.report.is_some());
        assert!(plan.files.iter().any(|file| file.name == "report.json"));
        let lacks = |numbers| match numbers {
            Numbers::Small(values) => values.is_empty(),
            Numbers::Whole(values) => values.is_empty(),
            Numbers::Single(values) => values.is_empty(),
        };
        let lacking = tables(&plan.linked).into_iter().filter(|(_, numbers)| lacks(*numbers));
        assert_eq!(lacking.map(|(name, _)| name).collect::<Vec<_>>(), [""; 0]);
    }

    #[test]
    fn a_texture_is_simulated_on_the_path_of_the_plan() {
        let request = Request::Plan { name: "plane.toml".into(), job: job(JOB) };
        let Ok(Answer::Plan(plan)) = answered(request) else { panic!("no plan") };
        let path = plan.files.iter().find(|file| file.name == "toolpath.csv").unwrap();
        let texture = |path: &[u8], x| {
            answered(Request::Texture { job: job(JOB), path: path.to_vec(), at: [x, 0.0, 0.0] })
        };
        let Ok(Answer::Texture { files, summary }) = texture(&path.bytes, 0.0) else {
            panic!("no texture")
        };
        assert!(files.len() > 1 && summary.contains("Sa "), "{summary}");
        let far = fault(texture(&path.bytes, 500.0));
        assert!(far["message"].as_str().unwrap().contains("500"), "{far}");
        let broken = fault(texture(b"no path", 0.0));
        assert!(broken["line"].is_null() && broken["message"].is_string());
    }

    #[test]
    fn a_job_that_cannot_be_read_is_a_fault_with_its_place() {
        let bad = JOB.replace("feed", "fed");
        let plan = fault(answered(Request::Plan { name: "bad.toml".into(), job: job(&bad) }));
        assert!(plan["line"].is_number() && plan["severity"] == "error");
        let at = [0.0; 3];
        let texture = Request::Texture { job: job(&bad), path: Vec::new(), at };
        assert_eq!(fault(answered(texture)), plan);
    }

    #[test]
    fn a_broken_surface_is_a_fault_where_it_is_named() {
        let plane = "analytic = { kind = \"plane\", size = 8, resolution = 1 }";
        let source = JOB.replace(plane, "file = \"a.stl\"");
        let job = JobFiles { surface: Some(b"no mesh".to_vec()), ..job(&source) };
        let fault = fault(answered(Request::Plan { name: "a.toml".into(), job }));
        assert_eq!(fault["line"], 3, "{fault}");
    }

    #[test]
    fn a_file_that_is_no_surface_is_a_message() {
        for (name, bytes) in [("notes.txt", &b""[..]), ("broken.stl", &b"no mesh"[..])] {
            let request = Request::NewJob { name: name.into(), bytes: bytes.to_vec() };
            assert!(matches!(answered(request), Err(Failure::Message(_))), "{name}");
        }
    }
}
