//! From the file as written to the complete job: defaults, units, combinations.
//!
//! Each table has one function. A value that another fault already concerns is replaced by its
//! default and raises no second fault; the job is given out only if there is none at all.

mod avoid;
mod cutting;
mod force;
mod hub;
mod machine;
mod name;
mod output;
mod path;
mod regions;
mod resolver;
mod stock;
mod surface;
mod texture;
mod warnings;

pub(super) use surface::{is_step, uses};

use super::complete::{Job, Resolved};
use super::document::Document;
use super::fault::Faults;
use super::file::Units;
use super::surface::FlattenMethod;
use super::units::{INCH, radians};
use resolver::Resolver;

/// Resolves a document.
///
/// # Errors
/// The faults of the document and all that are found here, in the order of the file.
pub(super) fn resolve(document: Document) -> Result<Resolved, Faults> {
    let Document { file, places, faults } = document;
    let unit = match file.units {
        Some(Units::Inch) => INCH,
        Some(Units::Mm) | None => 1.0,
    };
    let mut resolver = Resolver { file: &file, places, unit, faults: faults.0, warnings: vec![] };
    let job = resolver.job();
    let (mut faults, mut warnings) = (Faults(resolver.faults), Faults(resolver.warnings));
    match job {
        Some(job) if faults.is_empty() => {
            warnings.sort();
            Ok(Resolved { job, operations: Vec::new(), warnings, beside: Vec::new() })
        }
        _ => {
            faults.sort();
            Err(faults)
        }
    }
}

/// How far what is wider than the cutter stays clear of the part, and the whole tool of what it avoids, by default, mm.
const CLEARANCE: f64 = 0.5;
/// Overlap of the strips of neighbouring regions by default, nominal side steps. Smaller: the error of
/// the passes shows in the cusps along borders; larger: longer paths.
const BLEND: f64 = 0.1;

impl Resolver<'_> {
    fn job(&mut self) -> Option<Job> {
        let surface = self.surface();
        let name = self.name();
        let tool = self.tool();
        let machine = self.machine();
        self.check_arcs(&machine.axes);
        let cut = self.cut(tool, &machine);
        let trochoid = self.trochoid(tool, &machine);
        let force = self.force(tool, cut.as_ref());
        let file = self.file;
        let (surface, tool) = (surface?, tool?);
        let regions = self.regions(tool);
        let cut = cut?;
        let assembly = self.assembly(tool);
        let clearance = self.length(file.tool.clearance, CLEARANCE);
        let hub = self.hub((&surface, &tool), (&cut, &force, &machine));
        let mut job = Job {
            name,
            surface,
            flatten: file.flatten.method.unwrap_or(FlattenMethod::Bff),
            assembly,
            clearance,
            tool,
            flutes: file.tool.flutes.unwrap_or(4),
            helix: radians(file.tool.helix.unwrap_or(30.0)),
            regions,
            rest: false,
            cut,
            path: self.path(),
            stock: self.stock(),
            avoid: self.avoid(clearance),
            hub,
            force,
            trochoid: trochoid?,
            machine,
            texture: None,
            setup: self.setup(),
            output: self.output(),
        };
        if file.regions.blend.is_none() {
            job.regions.blend = BLEND * job.nominal_side_step();
        }
        if file.path.wall_height.is_none() {
            let stock = job.cut.allowance + job.cut.axial_depth;
            job.path.wall_height = stock.max(2.0 * job.tool.radius());
        }
        job.texture = self.texture(&job);
        self.check_blend(&job);
        self.check_engagement(&job);
        self.add_warnings(&job);
        Some(job)
    }
}
