//! What the page asks.

use evencut_core::job::{self, Fault, Job, Resolved, SurfaceSource};
use evencut_core::plan::Files;
use evencut_service::failure;
use evencut_service::results::ResultsError;
use serde::{Deserialize, Deserializer};

use crate::fault::{Failure, held_beside};

/// A message of the page.
#[derive(Debug, PartialEq, Deserialize)]
pub struct Message {
    /// Its number, by which the page knows what answers it.
    pub id: u32,
    /// What is asked.
    pub ask: Request,
}

/// What the page may ask: `{ check: { source, surfaces } }` and so on. Places are counted in UTF-16 units from the start.
#[derive(Debug, PartialEq, Deserialize)]
#[serde(rename_all = "camelCase")]
pub enum Request {
    /// What may be written at a place of a job.
    Completions { source: String, at: usize },
    /// What the key means that ends at a place of a job.
    Explanation { source: String, at: usize },
    /// What is wrong with a job. `surfaces`: names of the files that are there; `beside`: the files that the job is
    /// completed with, as far as they are there, by their names in the job.
    Check {
        source: String,
        surfaces: Vec<String>,
        #[serde(default, deserialize_with = "named_bytes")]
        beside: Vec<(String, Vec<u8>)>,
    },
    /// A job file for a surface file.
    NewJob {
        name: String,
        #[serde(with = "serde_bytes")]
        bytes: Vec<u8>,
    },
    /// The plan of a job. `name`: that of its file.
    Plan { name: String, job: JobFiles },
    /// What the teeth leave about a place of the surface, mm. `job`: what was planned; `path`: its `toolpath.csv`.
    Texture {
        job: JobFiles,
        #[serde(with = "serde_bytes")]
        path: Vec<u8>,
        at: [f64; 3],
    },
}

/// A job file, and the content of the files that it names, as far as it names any.
#[derive(Debug, Default, PartialEq, Deserialize)]
pub struct JobFiles {
    /// The job file.
    pub source: String,
    /// The surface.
    #[serde(default, with = "serde_bytes")]
    pub surface: Option<Vec<u8>>,
    /// The meshes beside the surface, by their names in the job.
    #[serde(default, deserialize_with = "named_bytes")]
    pub meshes: Vec<(String, Vec<u8>)>,
    /// The post-processor's file.
    #[serde(default, with = "serde_bytes")]
    pub post: Option<Vec<u8>>,
    /// The files that the job is completed with, by their names in the job.
    #[serde(default, deserialize_with = "named_bytes")]
    pub beside: Vec<(String, Vec<u8>)>,
    /// The surfaces of blades, by their names in the job.
    #[serde(default, deserialize_with = "named_bytes")]
    pub blades: Vec<(String, Vec<u8>)>,
}

/// Pairs of a name and bytes.
fn named_bytes<'de, D: Deserializer<'de>>(from: D) -> Result<Vec<(String, Vec<u8>)>, D::Error> {
    let pairs = Vec::<(String, serde_bytes::ByteBuf)>::deserialize(from)?;
    Ok(pairs.into_iter().map(|(name, bytes)| (name, bytes.into_vec())).collect())
}

impl JobFiles {
    /// The job.
    ///
    /// # Errors
    /// The first fault of the file.
    pub fn job(&self) -> Result<Job, Failure> {
        let read = job::read_with(self.source.as_bytes(), &mut |file, name| {
            held_beside(&self.source, file, name, &self.beside)
        });
        match read.and_then(Resolved::only) {
            Ok(resolved) => Ok(resolved.job),
            // A job that cannot be read has one fault at least.
            Err(faults) => Err(self.fault(&faults.0[0])),
        }
    }

    /// The files that the job names.
    pub fn named(&self) -> Files<'_> {
        Files {
            surface: self.surface.as_deref(),
            meshes: &self.meshes,
            post: self.post.as_deref(),
            beside: &self.beside,
            blades: &self.blades,
        }
    }

    /// A fault, with its place in the job file.
    pub fn fault(&self, fault: &Fault) -> Failure {
        Failure::of(fault, &self.source)
    }

    /// Why `job` came to nothing.
    pub fn failure(&self, job: &Job, error: &ResultsError) -> Failure {
        let surface = match &job.surface.source {
            SurfaceSource::File(file) => Some(file.as_str()),
            SurfaceSource::Analytic(_) => None,
        };
        self.fault(&failure::explain(error, self.source.as_bytes(), surface).1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    fn read(message: serde_json::Value) -> Result<Message, String> {
        serde_json::from_value(message).map_err(|error| error.to_string())
    }

    fn asked(ask: serde_json::Value) -> Request {
        read(json!({ "id": 7, "ask": ask })).unwrap().ask
    }

    #[test]
    fn requests_are_read_as_the_page_writes_them() {
        let source = || "name".to_owned();
        let place = json!({ "source": "name", "at": 3 });
        assert_eq!(
            asked(json!({ "completions": place })),
            Request::Completions { source: source(), at: 3 }
        );
        assert_eq!(
            asked(json!({ "explanation": place })),
            Request::Explanation { source: source(), at: 3 }
        );
        assert_eq!(
            asked(json!({ "check": { "source": "name", "surfaces": ["a.stl"] } })),
            Request::Check { source: source(), surfaces: vec!["a.stl".into()], beside: vec![] }
        );
        assert_eq!(
            asked(json!({ "newJob": { "name": "a.stl", "bytes": [1, 2] } })),
            Request::NewJob { name: "a.stl".into(), bytes: vec![1, 2] }
        );
        assert_eq!(
            asked(json!({ "texture": {
                "job": { "source": "name", "surface": [1], "meshes": [["c.stl", [2]]], "post": [5], "beside": [["t.toml", [6]]], "blades": [["b.json", [9]]] },
                "path": [3], "at": [4.0, 5, 6.5],
            } })),
            Request::Texture {
                job: JobFiles {
                    source: source(),
                    surface: Some(vec![1]),
                    meshes: vec![("c.stl".into(), vec![2])],
                    post: Some(vec![5]),
                    beside: vec![("t.toml".into(), vec![6])],
                    blades: vec![("b.json".into(), vec![9])],
                },
                path: vec![3],
                at: [4.0, 5.0, 6.5],
            }
        );
    }

    #[test]
    fn a_job_may_name_no_files() {
        let wanted = JobFiles { source: "name".into(), ..JobFiles::default() };
        for job in [json!({ "source": "name" }), json!({ "source": "name", "surface": null })] {
            let ask = asked(json!({ "plan": { "name": "a.toml", "job": job } }));
            let Request::Plan { job, .. } = ask else { panic!("{ask:?}") };
            assert_eq!(job, wanted);
        }
        assert!(wanted.named().surface.is_none() && wanted.named().meshes.is_empty());
    }

    #[test]
    fn what_is_no_request_is_named() {
        let no = |ask| read(json!({ "id": 7, "ask": ask })).unwrap_err();
        assert!(no(json!({ "mill": {} })).contains("mill"));
        assert!(no(json!({ "check": { "surfaces": [] } })).contains("source"));
        assert!(
            no(json!({ "texture": { "job": { "source": "" }, "path": [], "at": [1, 2] } }))
                .contains('3')
        );
        assert!(read(json!({ "ask": {} })).is_err() && read(json!(null)).is_err());
    }
}
