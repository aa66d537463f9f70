//! What is reported of a plan: numbers with stable keys, a summary for the terminal, a page.
//!
//! Keys carry their units. The numbers are written with six significant digits, so that the bytes
//! of [`Report::to_json`] depend on nothing but the plan.

mod hub;
mod json;
mod operations;
mod page;
mod path;
mod plan;
mod profile;
mod record;
mod regions;
mod setup;
mod summary;
mod tensor;
mod texture;
mod verification;

pub use hub::{HubFigures, HubVerdict, MeasuredClearance};
pub use operations::{OperationFigures, OperationsReport};
pub(crate) use page::escaped;
pub use path::{ByKind, PathFigures, PlaneFigures, RateFigures};
pub use plan::{
    AsideFigures, CoverageFigures, FlattenFigures, ForceFigures, GougeFigures, LiftedSpan,
    PassFigures, Report, StepoverFigures, SurfaceFigures, TiltFigures, Warning,
};
pub use profile::Profile;
pub use record::{BadReport, FileRecord, Recorded, RecordedCoverage, Versions};
pub use regions::{DivisionFigures, PieceFigures, SpacingFigures, UndividedFigures};
pub use setup::{ProgramFigures, ReachFigures, SetupFigures, SetupTool};
pub use tensor::{PointFigures, TensorFigures};
pub use texture::{
    ArealFigures, CuttingFigures, ProfileFigures, TextureFigures, WindowFigures, WorkFigures,
};
pub use verification::{
    AboveCutterFigures, AvoidedFigures, CuspFigures, FaultFigures, Lines, LoadFigures, MrrFigures,
    RegionFigures, ScallopFigures, SlopeFigures, SpotFigures, StockCutFigures, VerificationFigures,
    VerificationReport, WallCutFigures,
};

/// Version of the report's keys: grows when one changes its meaning or goes away.
pub const FORMAT: u32 = 1;

impl Report {
    /// The report as JSON, keys in the order of the types, six significant digits.
    ///
    /// Values that are not finite become null.
    pub fn to_json(&self) -> String {
        json::pretty(self)
    }

    /// One screen of text for a terminal.
    pub fn summary(&self) -> String {
        summary::summary(self)
    }

    /// A page with tables and pictures that asks for nothing from outside.
    ///
    /// `pictures`: heading and SVG text of each.
    pub fn to_html(&self, pictures: &[(&str, &str)]) -> String {
        page::page(self, pictures)
    }
}

#[cfg(test)]
mod documentation;
#[cfg(test)]
mod samples;
