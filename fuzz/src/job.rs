//! Job files, and the surfaces of their formulas.

use crate::Outcome;
use evencut_core::job::{self, SurfaceSource};
use evencut_core::plan::{Design, Files, SurfaceKeys};

/// Most edges along the mesh of a formula here; a job may ask for more than is quick.
const FINEST: f64 = 50.0;

/// A job file.
pub fn job(bytes: &[u8]) -> Outcome {
    let resolved = match job::read(bytes) {
        Ok(resolved) => resolved,
        Err(faults) => {
            assert!(!faults.is_empty() && faults.0.iter().all(|f| !f.message.is_empty()));
            assert!(faults.render("job.toml", bytes).contains("error: "));
            return Outcome::Refused;
        }
    };
    let warnings = &resolved.warnings;
    warnings.render_as(job::Severity::Warning, "job.toml", bytes);
    let text = resolved.to_toml();
    let again = job::read(text.as_bytes());
    let again = again.unwrap_or_else(|f| panic!("{}\n{text}", f.render("job", text.as_bytes())));
    assert_eq!(text, again.to_toml());
    if let SurfaceSource::Analytic(formula) = &resolved.job.surface.source
        && formula.parameters.size < FINEST * formula.parameters.resolution
        && let Err(error) = Design::new(&SurfaceKeys::of(&resolved.job), Files::default(), 1)
    {
        assert!(!error.to_string().is_empty());
    }
    Outcome::Read
}
