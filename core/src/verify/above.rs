//! How far shank and holder stay clear of part and stock: the sweep knows a cutter of one radius.
//!
//! - *Wide*: a section that is wider than the cutter somewhere. It must keep the asked clearance from the part, and from
//!   the stock, of which all is taken to be there until the end.
//! - *Slim*: a section of the shank that is not. Upright it goes where the cutter went before; where the axis leans it
//!   must not cut into the part.
//!
//! Steps: (1) the distance of wide and of slim sections from the machined surface and from the rest, on every move;
//! (2) where one is too small, by how many whole millimetres the cutter would have to stand out farther.

use super::clearance::{ClearanceFigures, clearance_of_sections};
use super::figures::{Broken, Nearest};
use super::options::{AboveCutter, Solid, VerifyOptions};
use super::samples::Facets;
use crate::geometry::{DVec3, OrderBy};
use crate::tool::{Assembly, AssemblyPart, Section};
use crate::toolpath::Toolpath;

/// Part of the asked clearance to which distances are known.
const ACCURACY: f64 = 0.02;
/// The same at least, mm.
const FINEST: f64 = 1e-3;
/// Cosine of the angle between axes that are one.
const SAME_AXIS: f64 = 1.0 - 1e-12;
/// Share by which a section that is as wide as the cutter may seem wider.
const ROUNDING: f64 = 1e-9;
/// Farthest that a longer stickout is looked for, mm.
const LONGEST: u32 = 256;

/// How far shank and holder stay clear.
#[derive(Clone, Debug, PartialEq)]
pub struct AboveFigures {
    /// What was measured, the shank before the holder.
    pub nearest: Vec<Nearest>,
    /// By how much farther the cutter would have to stand out, mm, where something is too near; `None` where it
    /// need not, or where even 256 mm more would not do.
    pub farther_out: Option<f64>,
}

impl AboveFigures {
    /// What is too near.
    pub(super) fn broken(&self) -> impl Iterator<Item = Broken> + '_ {
        let farther_out = self.farther_out;
        let near = self.nearest.iter().filter(|n| n.is_too_near());
        near.map(move |&nearest| Broken::TooNear { nearest, farther_out })
    }
}

/// Measures what is above the cutter; `None` where nothing is known of it.
pub(super) fn measure(
    path: &Toolpath,
    design: Facets,
    rest: Facets,
    options: &VerifyOptions,
) -> Option<AboveFigures> {
    let above = options.above.as_ref()?;
    let nothing = Facets { positions: &[], faces: &[] };
    let stock = options.stock.as_ref().map_or(nothing, Solid::facets);
    let survey = Survey::new(path, [design, rest, stock], above, options);
    let nearest = survey.nearest(0.0);
    let is_clear = |farther| !survey.nearest(farther).iter().any(Nearest::is_too_near);
    let is_near = nearest.iter().any(Nearest::is_too_near);
    let farther_out = is_near.then(|| least_stickout(is_clear)).flatten();
    Some(AboveFigures { nearest, farther_out })
}

/// By how many whole millimetres the cutter has to stand out farther for everything to be clear, mm; `None` where no
/// length does.
pub(super) fn least_stickout(is_clear: impl Fn(f64) -> bool) -> Option<f64> {
    let is_clear = |farther: u32| is_clear(f64::from(farther));
    is_clear(LONGEST).then(|| f64::from(least(LONGEST, is_clear)))
}

/// The sections of an assembly, the holder `farther` mm higher and the shank as much longer.
pub(super) fn longer(assembly: &Assembly, farther: f64) -> Vec<Section> {
    let raised = |s: &Section| match s.part {
        AssemblyPart::Holder => Section { heights: s.heights.map(|h| h + farther), ..*s },
        _ => Section { heights: [s.heights[0], s.heights[1] + farther], ..*s },
    };
    assembly.sections.iter().map(raised).collect()
}

/// The least number up to `most` for which something holds that holds for all greater ones.
fn least(most: u32, holds: impl Fn(u32) -> bool) -> u32 {
    let (mut fails, mut does) = (0, most);
    while does - fails > 1 {
        let middle = fails.midpoint(does);
        if holds(middle) {
            does = middle;
        } else {
            fails = middle;
        }
    }
    does
}

struct Survey<'a> {
    path: &'a Toolpath,
    /// The machined surface, on which there may be stock, the rest, and where the stock ends.
    facets: [Facets<'a>; 3],
    above: &'a AboveCutter,
    /// Thickness of the stock, mm.
    stock: f64,
    tolerance: f64,
    leans: bool,
    threads: usize,
}

impl<'a> Survey<'a> {
    fn new(
        path: &'a Toolpath,
        facets: [Facets<'a>; 3],
        above: &'a AboveCutter,
        options: &VerifyOptions,
    ) -> Self {
        let first = path.points.first().map_or(DVec3::Z, |p| p.axis);
        Self {
            path,
            facets,
            above,
            stock: options.allowance + options.depth,
            tolerance: options.tolerance,
            leans: path.points.iter().any(|p| p.axis.dot(first) < SAME_AXIS),
            threads: options.threads,
        }
    }

    /// Shank and holder, the cutter standing out so much farther, mm.
    fn nearest(&self, farther: f64) -> Vec<Nearest> {
        let radius = self.above.assembly.tool.radius();
        let is_wide = |s: &Section| s.radii[0].max(s.radii[1]) > radius * (1.0 + ROUNDING);
        let (wide, slim): (Vec<Section>, Vec<Section>) =
            longer(&self.above.assembly, farther).into_iter().partition(is_wide);
        let mut found = Vec::new();
        if self.leans {
            // Of what touches, the distance may come out negative by the accuracy.
            found.extend(self.measured(slim, -self.tolerance - self.accuracy(), 0.0));
        }
        found.extend(self.measured(wide, self.above.clearance, self.stock));
        let mut least: Vec<Nearest> = Vec::new();
        for n in found {
            match least.iter_mut().find(|kept| kept.part == n.part) {
                Some(kept) if n.distance - n.wanted < kept.distance - kept.wanted => *kept = n,
                Some(_) => {}
                None => least.push(n),
            }
        }
        least.order_by_key(|n| n.part as u8);
        least
    }

    /// By how much distances may come out too small, mm.
    fn accuracy(&self) -> f64 {
        FINEST.max(ACCURACY * self.above.clearance)
    }

    /// The distances of sections from the rest, and from the machined surface with `stock` on it; of those that do not
    /// follow the cutter into the stock also from where that ends.
    fn measured(&self, sections: Vec<Section>, wanted: f64, stock: f64) -> Vec<Nearest> {
        let assembly = Assembly { sections, ..self.above.assembly.clone() };
        let beyond = wanted.max(0.0) + stock + 2.0 * assembly.tool.radius();
        let accuracy = self.accuracy();
        let of = |facets, stock: f64| -> Vec<Nearest> {
            let threads = self.threads;
            let found =
                clearance_of_sections(self.path, facets, &assembly, beyond, accuracy, threads);
            let Some(figures) = found else { return Vec::new() };
            let parts = [AssemblyPart::Shank, AssemblyPart::Holder];
            parts
                .into_iter()
                .filter_map(|p| nearest(&figures, p, (wanted, stock, beyond)))
                .collect()
        };
        let [design, rest, ends] = self.facets;
        let mut found = of(design, stock);
        found.extend(of(rest, 0.0));
        if stock > 0.0 {
            found.extend(of(ends, 0.0));
        }
        found
    }
}

/// What is known of a part of the assembly; `stock`: how much less the distance is than was measured, mm.
pub(super) fn nearest(
    figures: &ClearanceFigures,
    part: AssemblyPart,
    (wanted, stock, beyond): (f64, f64, f64),
) -> Option<Nearest> {
    let k = part as usize;
    let distance = figures.by_part[k]?;
    let along = figures.along.iter().enumerate();
    let least = along.min_by(|a, b| a.1[k].total_cmp(&b.1[k])).map_or(0, |(i, _)| i);
    Some(Nearest {
        part,
        distance: distance - stock,
        is_farther: distance >= beyond,
        wanted,
        place: figures.at_by_part[k],
        of: least.saturating_sub(1) as u32,
    })
}
