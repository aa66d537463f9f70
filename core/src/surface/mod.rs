//! The surface to be machined: one oriented manifold piece with its normals.

mod analytic;
mod build;
mod curvature;
mod error;
mod fault;
mod inspect;
mod manifold;
mod message;
mod parametrisation;
mod point;
mod select;
mod warning;

pub use analytic::{AnalyticSurface, Domain};
pub use build::{
    Built, Part, Whole, build, build_beside, build_parametric, build_placed, build_whole, placement,
};
pub use curvature::CurvatureField;
pub use error::SurfaceError;
pub use fault::Fault;
pub use inspect::{Facing, Front, Inspection};
pub use manifold::Surface;
pub use parametrisation::Parametrisation;
pub use point::SurfacePoint;
pub use warning::Warning;

pub use crate::geometry::shape::ShapeOperator;
