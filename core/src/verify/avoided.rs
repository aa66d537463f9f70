//! How far the whole tool, cutter, shank and holder, stays away from what must be avoided, on every move.
//!
//! Steps, for each mesh: (1) the distance of each part of the tool from it; (2) where shank or holder are too near, by how
//! many whole millimetres the cutter would have to stand out farther.

use super::above::{least_stickout, longer, nearest};
use super::clearance::{ClearanceFigures, clearance};
use super::figures::{Broken, Nearest};
use super::options::{Avoided, VerifyOptions};
use super::samples::Facets;
use crate::tool::{Assembly, AssemblyPart};
use crate::toolpath::{MoveKind, Toolpath};

/// Part of the tolerance to which distances are known: a plan that keeps a distance to the tolerance is to be seen to.
const ACCURACY: f64 = 0.125;
/// The accuracy at most and at least, mm.
const ACCURACIES: [f64; 2] = [1e-5, 1e-3];

/// How far the tool stays away from one mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct AvoidedFigures {
    /// What was measured of each part of the tool: cutter, shank, holder.
    pub nearest: Vec<Nearest>,
    /// By how much farther the cutter would have to stand out, mm, where shank or holder are too near; `None` where it
    /// need not, or where even 256 mm more would not do.
    pub farther_out: Option<f64>,
}

impl AvoidedFigures {
    /// The part that comes nearest.
    pub fn closest(&self) -> Option<&Nearest> {
        self.nearest.iter().min_by(|a, b| a.distance.total_cmp(&b.distance))
    }

    /// What of mesh `index` is too near.
    pub(super) fn broken(&self, index: usize, path: &Toolpath) -> impl Iterator<Item = Broken> {
        let near = self.nearest.iter().filter(|n| n.is_too_near());
        near.map(move |&nearest| {
            let end = path.points.get(nearest.of as usize + 1);
            let farther_out = self.farther_out.filter(|_| nearest.part != AssemblyPart::Cutter);
            let on_rapid = end.is_some_and(|end| end.kind == MoveKind::Rapid);
            Broken::Avoided { index, nearest, on_rapid, farther_out }
        })
    }
}

/// Measures the tool against a mesh that it must avoid; `None` for a mesh without facets, and for numbers that are not
/// finite.
pub(super) fn measure(
    path: &Toolpath,
    avoided: &Avoided,
    options: &VerifyOptions,
) -> Option<AvoidedFigures> {
    let assembly = match &options.above {
        Some(above) => above.assembly.clone(),
        None => Assembly::of_cutter(options.tool, options.length),
    };
    Survey { path, assembly: &assembly, avoided, options }.figures()
}

struct Survey<'a> {
    path: &'a Toolpath,
    assembly: &'a Assembly,
    avoided: &'a Avoided,
    options: &'a VerifyOptions,
}

impl Survey<'_> {
    fn figures(&self) -> Option<AvoidedFigures> {
        let nearest = self.nearest(0.0)?;
        let is_above = |n: &&Nearest| n.part != AssemblyPart::Cutter;
        let is_near = |all: &[Nearest]| all.iter().filter(is_above).any(Nearest::is_too_near);
        let is_clear = |farther| self.nearest(farther).is_some_and(|all| !is_near(&all));
        let farther_out = is_near(&nearest).then(|| least_stickout(is_clear)).flatten();
        Some(AvoidedFigures { nearest, farther_out })
    }

    /// The distance of each part, the cutter standing out so much farther, mm.
    fn nearest(&self, farther: f64) -> Option<Vec<Nearest>> {
        let Self { path, avoided, options, .. } = *self;
        let sections = longer(self.assembly, farther);
        let assembly = Assembly { sections, ..self.assembly.clone() };
        let facets = Facets { positions: &avoided.positions, faces: &avoided.faces };
        let beyond = avoided.distance + 2.0 * options.tool.radius();
        let [least, most] = ACCURACIES;
        let accuracy = (ACCURACY * options.tolerance).clamp(least, most);
        let figures: ClearanceFigures =
            clearance(path, facets, &assembly, beyond, accuracy, options.threads)?;
        let parts = [AssemblyPart::Cutter, AssemblyPart::Shank, AssemblyPart::Holder];
        let of = |part| nearest(&figures, part, (avoided.distance, 0.0, beyond));
        Some(parts.into_iter().filter_map(of).collect())
    }
}
