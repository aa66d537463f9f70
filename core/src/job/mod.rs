//! The job: what to machine and how, complete, in millimetres, radians and seconds.
//!
//! A job file is read against the [schema](schema()) of [`JobFile`] with all its faults noted at
//! once ([`Faults`]), and resolved into a [`Job`]: every default filled in, every value and
//! combination checked. No later stage knows a default. [`Job::to_toml`] goes the other way.

mod avoid;
mod beside;
mod complete;
mod completion;
mod cut;
mod document;
mod fault;
pub mod file;
mod force;
mod hub;
mod library;
mod machine_file;
mod merged;
mod operations;
mod output;
mod path;
mod reference;
mod regions;
mod resolve;
mod schema;
mod stock;
mod surface;
mod template;
mod texture;
mod units;
mod window;
mod words;
mod write;

pub use avoid::Avoid;
pub use beside::{Beside, Load};
pub use complete::{Job, Operation, Resolved};
pub use completion::{
    Completion, CompletionKind, Completions, Explanation, completions, explanation,
};
pub use cut::{Cut, CutDirection, Inaccessible, Stepover};
pub use fault::{Fault, Faults, Severity, line_and_column};
pub use file::JobFile;
pub use force::{
    FeedComponent, Force, ForceControl, MaterialGroup, MinChip, MrrLimit, TrochoidOptions,
};
pub use hub::{BladeSurface, HubChannels, HubOptions, HubPasses};
pub use library::{LibraryError, LibraryTool, ToolLibrary};
pub use output::{OutputOptions, Picture, Post, PostSource};
pub use path::{
    Boundary, FirstPass, Links, Parameter, PathOptions, Pattern, RingOrder, Start, StartKey,
    Traverse,
};
pub use reference::reference;
pub use regions::{
    Compensation, DistortionMeasure, DistortionOptions, Division, RegionMethod, RegionOptions,
    RegionOrder, TensorOptions,
};
pub use schema::schema;
pub use stock::StockShape;
pub use surface::{
    AnalyticKind, AnalyticOptions, AnalyticParameters, Component, Faces, FlattenMethod, Selection,
    SurfaceOptions, SurfaceSource,
};
pub use template::{Outside, SurfaceFacts, coarse_facets, guessed_unit, template};
pub use texture::{TextureCells, TextureOptions};

/// Reads and resolves a job file that says all by itself: its tool is from no library, its machine from no file.
///
/// `bytes`: the file, UTF-8 TOML of at most 1 MiB.
///
/// # Errors
/// All [`Faults`] of the file, in its order; after a syntax error only that.
pub fn read(bytes: &[u8]) -> Result<Resolved, Faults> {
    read_with(bytes, &mut |file, name| {
        let message = format!("the file {name:?} was not given");
        Err(Fault::new(file.key(), message).help("give the values themselves"))
    })
}

/// Reads and resolves a job file.
///
/// `bytes` as for [`read`]; `load` gives the content of the files that the job is completed with.
///
/// # Errors
/// As of [`read`], with those of the tool in its library and of the machine in its file.
pub fn read_with(bytes: &[u8], load: &mut Load<'_>) -> Result<Resolved, Faults> {
    operations::resolved(document::read_all(bytes)?, |mut document| {
        let machine = machine_file::take(&mut document, load);
        let library = library::take(&mut document, load);
        let resolved = resolve::resolve(document)?;
        Ok(Resolved { beside: machine.into_iter().chain(library).collect(), ..resolved })
    })
}

impl JobFile {
    /// Fills in the defaults and checks values and combinations.
    ///
    /// # Errors
    /// All [`Faults`], without places, since there is no source to point into.
    pub fn resolve(&self) -> Result<Resolved, Faults> {
        match write::toml_of(self) {
            Ok(text) => read(text.as_bytes()).map_err(Faults::without_places),
            Err(error) => Err(Faults(vec![Fault::new("", error.to_string())])),
        }
    }
}
