//! Facts of a surface from which a job file is made.

use evencut_core::job::SurfaceFacts;
use evencut_core::surface::Inspection;

/// Facts of a surface from which a job file is made.
pub fn facts(inspection: &Inspection) -> SurfaceFacts {
    let Inspection { judgement, bounds, concave, convex, facing, faults, .. } = inspection;
    SurfaceFacts {
        size: (bounds.1 - bounds.0).to_array(),
        smallest_concave_radius: concave.map(|(radius, _)| radius),
        smallest_convex_radius: convex.map(|(radius, _)| radius),
        closed: judgement.boundary_loops.is_empty(),
        is_part: !faults.is_empty(),
        mean_normal: facing.mean.to_array(),
        from_mean: facing.from_mean,
    }
}
