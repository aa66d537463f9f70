//! The pipeline: a job and file contents in, a path and its figures out, one stage after the other.
//!
//! 1. The surface of the job is read and laid flat: [`Prepared`], for any job with the same surface.
//! 2. Passes are laid out on it, and a path over them in the flat plane: [`Laid`].
//! 3. The path is delivered on the surface: [`Planned`].

mod blades;
mod delivery;
mod design;
mod error;
mod given_stock;
mod hub;
mod laid;
mod load;
mod parameter_map;
mod plane;
mod planned;
mod prepared;
mod stage;
mod uncut;

use crate::job::Job;
pub use crate::removal::{Earlier, Stock};
pub use crate::strips::CuspBudget;
pub use delivery::Plain;
pub use design::Design;
pub use error::PlanError;
pub use laid::Laid;
pub use load::{Avoided, Files, SurfaceKeys};
pub use planned::{Passes, Planned, Tightest};
pub use prepared::{Flattening, MapKind, Prepared};
pub use stage::Stage;
use std::sync::Arc;

/// Plans a job. `files`: the contents of the files that it names; `threads`: number of threads, on which the result
/// does not depend.
///
/// `progress` is called with the stage and the fraction of it that is done.
///
/// # Errors
/// [`PlanError`]: what cannot be planned, where, and what to change.
pub fn plan(
    job: &Job,
    files: Files,
    threads: usize,
    progress: &mut dyn FnMut(Stage, f64),
) -> Result<Planned, PlanError> {
    let prepared = Prepared::new(SurfaceKeys::of(job), files, threads, progress)?;
    plan_on(&prepared, job, &stock_of(job), threads, progress)
}

/// The material of a job before its first operation.
pub fn stock_of(job: &Job) -> Stock {
    Stock::fresh(job.cut.allowance + job.cut.axial_depth)
}

/// Plans a job on its surface, which may serve other jobs as well; `stock`: the material that it meets.
///
/// # Errors
/// As [`plan`].
///
/// # Panics
/// As [`Laid::new`].
pub fn plan_on(
    prepared: &Arc<Prepared>,
    job: &Job,
    stock: &Stock,
    threads: usize,
    progress: &mut dyn FnMut(Stage, f64),
) -> Result<Planned, PlanError> {
    match &prepared.design.passage {
        Some(passage) if job.hub.is_some() => {
            hub::planned(prepared, passage, job, threads, progress)
        }
        _ => Laid::new(prepared, job, stock, threads, progress)?.planned(progress),
    }
}
