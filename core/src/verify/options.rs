//! Options of the verification.

use super::load::LoadOptions;
use super::samples::Facets;
use super::walls::Walls;
use crate::geometry::DVec3;
use crate::tool::{Assembly, Tool};
use crate::toolpath::Toolpath;

/// Cutter, stock and limits.
#[derive(Clone, Debug)]
pub struct VerifyOptions {
    /// The cutter.
    pub tool: Tool,
    /// Length of the cutter with its shank, mm; may be infinite.
    pub length: f64,
    /// Axial depth of the layer of stock, mm.
    pub depth: f64,
    /// Whether that depth is known to be that of the stock, so that a removal rate can be measured.
    pub tells_rate: bool,
    /// Allowance left on the surface, mm.
    pub allowance: f64,
    /// What has cut the stock before; `None` where it is the whole layer.
    pub earlier: Option<Earlier>,
    /// Limit on the scallop height, mm.
    pub scallop: Option<f64>,
    /// By how much the scallop limit may be exceeded and the surface cut into, mm.
    pub tolerance: f64,
    /// Limit on the removal rate, mm³/s.
    pub mrr_limit: Option<f64>,
    /// The cutter's teeth and what may be asked of them, where they are known.
    pub load: Option<LoadOptions>,
    /// Distance between samples, mm.
    pub spacing: f64,
    /// The direction from which slopes are counted, unit.
    pub up: DVec3,
    /// Places where the plan says that the cutter does not fit; evaluated separately.
    pub inaccessible: Vec<Sphere>,
    /// The walls around the machined surface; `None` where its boundary is open.
    pub walls: Option<Walls>,
    /// Faces of the design surface over which the cutter bridges the part, by their numbers; empty where there are none.
    /// Nothing can be cut into there but the part, which is the rest.
    pub bridges: Vec<bool>,
    /// What is above the cutter; `None` where it is not known.
    pub above: Option<AboveCutter>,
    /// Where the stock ends before any cut, beside the surface, too; `None` where only the layer is known.
    pub stock: Option<Solid>,
    /// What the whole tool must stay away from.
    pub avoided: Vec<Avoided>,
    /// Number of threads; the result does not depend on it.
    pub threads: usize,
}

/// What has cut the stock before the path that is judged.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Earlier {
    /// Height of the upper side of the stock above the surface before any cut, mm.
    pub top: f64,
    /// By how much it may be higher where cutters bridged the part, mm.
    pub bridged: f64,
    /// The cuts, in their order.
    pub cuts: Vec<EarlierCut>,
}

/// A path that has cut the stock before.
#[derive(Clone, Debug, PartialEq)]
pub struct EarlierCut {
    /// The path.
    pub path: Toolpath,
    /// Its cutter.
    pub tool: Tool,
    /// Length of the cutter with its shank, mm; may be infinite.
    pub length: f64,
}

impl VerifyOptions {
    /// Height of the upper side of the stock above the surface before any cut, mm; and where cutters bridged the part.
    pub(super) fn tops(&self) -> [f64; 2] {
        match &self.earlier {
            None => [self.allowance + self.depth; 2],
            Some(earlier) => [earlier.top, earlier.top + earlier.bridged],
        }
    }

    /// How deep the cutter may go into the stock, mm.
    pub fn most_into_stock(&self) -> f64 {
        self.tops()[0] - self.allowance + self.tolerance
    }
}

/// What is above the cutter, and how far it must stay clear.
#[derive(Clone, Debug, PartialEq)]
pub struct AboveCutter {
    /// The cutter with shank and holder.
    pub assembly: Assembly,
    /// Distance of what is wider than the cutter from part and stock, mm.
    pub clearance: f64,
}

/// What encloses the stock before any cut.
#[derive(Clone, Debug, PartialEq)]
pub struct Solid {
    /// `#V` positions, mm.
    pub positions: Vec<DVec3>,
    /// `#F` triples of indices into them, counter-clockwise from outside.
    pub faces: Vec<[u32; 3]>,
}

impl Solid {
    pub(super) fn facets(&self) -> Facets<'_> {
        Facets { positions: &self.positions, faces: &self.faces }
    }
}

/// A mesh that cutter, shank and holder must stay away from.
#[derive(Clone, Debug, PartialEq)]
pub struct Avoided {
    /// What it is called.
    pub name: String,
    /// How far they must stay away from it, mm.
    pub distance: f64,
    /// `#V` positions, mm.
    pub positions: Vec<DVec3>,
    /// `#F` triples of indices into them.
    pub faces: Vec<[u32; 3]>,
}

/// A sphere.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Sphere {
    /// Centre, mm.
    pub centre: DVec3,
    /// Radius, mm.
    pub radius: f64,
}
