//! Verification of every plan: what a path really leaves and really removes.
//!
//! - *Residual*: height along the surface normal that is left above the design surface (and its allowance) after the
//!   cutter has swept every move; a *scallop* where positive, a *gouge* where negative.
//! - *Untouched*: where no move reached the stock.
//! - *Wall*: material that stands outside the boundary of the machined surface and must stay, if the job has walls; a
//!   cut into it is measured by its depth.
//! - *Beside*: stock outside the boundary that goes straight up from it, where the surface rises toward it; only the
//!   removal rate counts it (`beside`).
//! - *Earlier cuts*: other paths, maybe with other cutters, that have cut the stock before.
//! - *Avoided*: a mesh from which cutter, shank and holder keep a distance on every move.
//! - *Load*: engagement, feed per tooth, power and force, from the same windows.
//! - *Removal rate*: volume removed from the columns of stock over the samples, in cutting order, divided by the time
//!   of a window of travel.
//!
//! Steps: (1) area-uniform samples of the design surface and, for gouges only, of the rest of the part (`samples`)
//! and of the walls (`walls`); (2) the path as short steps (`motion`); (3) each tile of samples swept by the steps
//! that reach it (`sweep`), independently of other tiles; (4) where heights between samples could break a limit, a
//! search for the highest place there (`peaks`); (5) figures; (6) sections across the passes, for the height of every
//! single cusp (`crests`).
//!
//! Nothing here comes from planning: a path is points and axes, a surface is triangles. Paths from other programs are
//! verified in the same way.
//!
//! Source: columns along normals instead of one direction, as in the normal vector cutting
//! method: Jerard, Drysdale, Hauck, Schaudt, Magewick, "Methods for detecting errors in numerically
//! controlled machining of sculptured surfaces", IEEE CG&A 9(1) (1989).

mod above;
mod avoided;
mod beside;
mod body;
mod bound;
mod clearance;
mod crests;
mod excused;
mod figures;
mod lanes;
mod load;
mod material;
mod motion;
mod options;
mod outcome;
mod peaks;
mod rate;
mod samples;
mod section;
mod solids;
mod sweep;
mod walls;

pub use above::AboveFigures;
pub use avoided::AvoidedFigures;
pub use clearance::{ClearanceFigures, clearance};
pub use crests::Crests;
pub use figures::{Band, Broken, Fault, Figures, MRR_NOISE, Nearest, Quantity, Spot, WallFigures};
pub use load::{Load, LoadOptions, Worst};
pub use options::{AboveCutter, Avoided, Earlier, EarlierCut, Solid, Sphere, VerifyOptions};
pub use outcome::Outcome;
pub use rate::{Rate, Window};
pub use samples::Facets;
pub use walls::{Rise, Walls};

use crate::geometry::{DVec3, OrderBy};
use crate::parallel;
use crate::toolpath::{MoveKind, Toolpath};
use body::Body;
use excused::Excused;
use figures::{DEEPEST, DEEPEST_IN_WALL};
use load::Gauge;
use material::{Material, Swept};
use motion::Motion;
use peaks::{Search, Sought};
use sweep::{Cut, SweptTile, Touch};
use thiserror::Error;
use walls::Outline;

/// Greatest number of samples; above it they are spaced farther apart.
const MOST_SAMPLES: f64 = 4.0e6;
/// Longest path that is simulated, cutter radii.
const LONGEST_PATH: f64 = 1.0e6;
/// Greatest number of samples of walls; above it they are spaced farther apart.
const MOST_ON_WALLS: f64 = 1.0e6;
/// Cosine of the angle between the cutter and the up direction below which the cutter counts as tilted.
const UPRIGHT: f64 = 1.0 - 1e-12;
/// A move that goes less than this across the axis counts as along it, mm.
const STRAIGHT_UP: f64 = 1e-6;
/// Samples of a wall on a cutter radius at least.
const WALL_SAMPLES_PER_RADIUS: f64 = 8.0;
/// Distance from the rim of the samples beside it, cutter radii: a sharp edge that moves along the rim is detected at
/// places a twentieth of the radius apart, between which it lies back by a third of this.
const BESIDE_RIM: f64 = 1e-3;
/// A rapid that removes less than this touches nothing, mm.
const GRAZE: f64 = 1e-4;

/// Why nothing can be verified.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum VerifyError {
    /// The surface has no area.
    #[error("verify: the surface has no area")]
    NoSurface,
    /// There is no move.
    #[error("verify: the path has {points} points; it takes two for a move")]
    NoPath {
        /// Points found.
        points: usize,
    },
    /// The path is too long for so small a cutter.
    #[error(
        "verify: the path is {length:.0} mm long, {:.0} times the cutter radius; at most \
         {LONGEST_PATH:.0} times can be simulated: check the cutter's diameter and the path's unit",
        length / radius
    )]
    TooFine {
        /// Length of the path, mm.
        length: f64,
        /// Cutter radius, mm.
        radius: f64,
    },
    /// The distance from a mesh cannot be measured.
    #[error(
        "verify: the distance from {name:?} cannot be measured: its mesh has no facets, or a coordinate of mesh or \
         path is not finite"
    )]
    NotMeasured {
        /// What the mesh is called.
        name: String,
    },
    /// An option that is not a positive number.
    #[error("verify: {what} is {value} mm; it must be a positive number")]
    NotPositive {
        /// Which.
        what: &'static str,
        /// What was given, mm.
        value: f64,
    },
}

/// A verified path.
#[derive(Clone, Debug)]
pub struct Verification {
    /// Figures of the samples.
    pub figures: Figures,
    /// The cusps between neighbouring passes.
    pub crests: Crests,
    /// The removal rate.
    pub rate: Rate,
    /// What was asked of the cutter, where its teeth are known.
    pub load: Option<Load>,
    /// How far shank and holder stay clear, where they are known.
    pub above: Option<AboveFigures>,
    /// How far the whole tool stays away from what it must avoid, in the order of the options.
    pub avoided: Vec<AvoidedFigures>,
    /// The samples, for pictures.
    pub samples: Vec<Outcome>,
}

/// Verifies a path. `design`: what is machined; `rest`: other facets of the part that must not be cut into.
/// `progress` is called with the fraction done.
///
/// # Errors
/// [`VerifyError`] when there is nothing to verify.
pub fn verify(
    path: &Toolpath,
    design: Facets,
    rest: Facets,
    options: &VerifyOptions,
    progress: &mut dyn FnMut(f64),
) -> Result<Verification, VerifyError> {
    let area = design.area();
    let spacing = checked(path, area, rest.area(), options)?;
    let body = Body::new(&options.tool, options.length);
    let motion = Motion::new(path, &body);
    let earlier = earlier(options);
    let cut = Cut { motion: &motion, body: &body };
    let before = earlier.iter().map(|(motion, body)| Cut { motion, body });
    let cuts: Vec<Cut> = before.chain([cut]).collect();
    let [layer, height] = options.tops();
    let material = Material {
        height,
        layer,
        allowance: options.allowance,
        deepest: DEEPEST * options.tool.radius(),
        tolerance: options.tolerance,
    };
    let inset = BESIDE_RIM * options.tool.radius();
    let outline = Outline::of(design, rest, options.walls.is_some(), options.tolerance);
    let tiles = samples::tiles(design, rest, spacing, &outline.open, &options.bridges);
    let mut swept: Vec<SweptTile> = Vec::with_capacity(tiles.len());
    // In groups, so that progress shows.
    for group in tiles.chunks(tiles.len().div_ceil(32).max(8)) {
        progress(swept.len() as f64 / tiles.len() as f64);
        let sweep = |tile: &samples::Tile| {
            let sweep = |samples| sweep::sweep(tile, samples, &cuts, material);
            let swept = sweep(tile.samples(spacing, inset));
            let is_cut = |s: &Swept| !s.sample.machined && s.height < -options.tolerance;
            let of_part = Some(options.tolerance);
            let ends = Ends { tile, facets: &[design, rest], of_part, deepest: material.deepest };
            ends.applied(swept, is_cut, sweep)
        };
        swept.extend(parallel::map(options.threads, group, sweep));
    }
    let on_walls = on_walls(path, (design, rest), cut, spacing, options);
    let beside = match options.tells_rate {
        true => beside::swept(design, options.up, spacing, (&cuts, material), options.threads),
        false => Vec::new(),
    };
    let removed = summed(swept.iter().chain(&beside));
    let gauge = |load| Gauge::new(path, &options.tool, options.depth, load);
    let mut gauge = options.load.map(gauge);
    let rate = rate::measure(path, &motion, &removed, options.tool.radius(), &mut |window| {
        if let Some(gauge) = &mut gauge {
            gauge.measure(window);
        }
    });
    let load = gauge.map(|gauge| gauge.load).filter(|_| options.tells_rate);
    let stock = options.stock.as_ref().map(Solid::facets);
    let nothing = Facets { positions: &[], faces: &[] };
    let in_stock = stock.map(|stock| into_solid([stock, nothing], &cuts, spacing, options));
    let touches =
        touches(swept.iter().chain(&beside).chain(&on_walls).chain(in_stock.iter().flatten()));
    let outcomes = outcomes(&swept, &outline.walled, options);
    let walled = &outline.walled;
    let search = Search { tiles: &tiles, cuts: &cuts, material, spacing, inset, walled, options };
    let [scallops, gouges] =
        [Sought::Scallop, Sought::Gouge].map(|what| search.search(what, &swept, &outcomes));
    // Millions of samples: what was swept is as large as all else, and no longer asked.
    drop(swept);
    let all = outcomes.into_iter().flatten();
    let (samples, mut further): (Vec<Outcome>, Vec<Outcome>) = all.partition(|s| s.area > 0.0);
    further.extend([&scallops, &gouges].into_iter().flat_map(|found| &found.peaks));
    let found = figures::Found { samples: &samples, further: &further, highest: scallops.highest };
    let into = [&on_walls[..], in_stock.as_deref().unwrap_or_default()]
        .map(|swept| WallFigures::of(swept, options));
    let measured = (&rate, load.as_ref());
    let mut figures = figures::Figures::of(path, found, into, &touches, measured, spacing, options);
    let survey = crests::Survey {
        path,
        motion: &motion,
        body: &body,
        material,
        allowance: options.allowance,
    };
    let crests = survey.crests(design, &samples, options.threads);
    let above = above::measure(path, design, rest, options);
    figures.broken.extend(above.iter().flat_map(AboveFigures::broken));
    let avoided = options.avoided.iter().map(|avoided| {
        let not_measured = || VerifyError::NotMeasured { name: avoided.name.clone() };
        avoided::measure(path, avoided, options).ok_or_else(not_measured)
    });
    let avoided = avoided.collect::<Result<Vec<_>, _>>()?;
    let broken = avoided.iter().enumerate().flat_map(|(i, a)| a.broken(i, path));
    figures.broken.extend(broken);
    progress(1.0);
    Ok(Verification { figures, crests, rate, load, above, avoided, samples })
}

/// The moves and the cutters of earlier cuts.
fn earlier(options: &VerifyOptions) -> Vec<(Motion, Body)> {
    let of = |cut: &EarlierCut| {
        let body = Body::new(&cut.tool, cut.length);
        (Motion::new(&cut.path, &body), body)
    };
    options.earlier.iter().flat_map(|earlier| &earlier.cuts).map(of).collect()
}

/// The swept walls after the sweep.
fn on_walls(
    path: &Toolpath,
    (design, rest): (Facets, Facets),
    cut: Cut,
    spacing: f64,
    options: &VerifyOptions,
) -> Vec<SweptTile> {
    let Some(walls) = options.walls else { return Vec::new() };
    // Samples of a high wall would be far apart.
    let height = walls.height.min(highest_reached(path, design, walls, options));
    let sheet = Walls { height, ..walls }.swept(design, rest, options.up);
    let nothing = Facets { positions: &[], faces: &[] };
    into_solid([nothing, sheet.facets()], &[cut], spacing, options)
}

/// What lies behind facets, those of stock and those of walls, after the sweep by cuts in their order. The last is judged.
///
/// Across a place where the cutter is deepest, samples `s` apart underestimate its depth by `s² / 8R` at most.
fn into_solid(
    [stock, walls]: [Facets; 2],
    cuts: &[Cut],
    spacing: f64,
    options: &VerifyOptions,
) -> Vec<SweptTile> {
    let radius = options.tool.radius();
    let deepest = DEEPEST_IN_WALL * radius;
    let missing = 0.5 * options.tolerance.max(0.0);
    let wide = (8.0 * radius * missing).sqrt().min(radius / WALL_SAMPLES_PER_RADIUS);
    let spacing = wide.max(spacing).max(((stock.area() + walls.area()) / MOST_ON_WALLS).sqrt());
    let tolerance = options.tolerance;
    // What one cut has taken of stock is not there for the next.
    let allowance = -deepest;
    let material = Material { height: 0.0, layer: 0.0, allowance, deepest, tolerance };
    let tiles = samples::tiles(stock, walls, spacing, &[], &[]);
    parallel::map(options.threads, &tiles, |tile: &samples::Tile| {
        let mut samples = tile.samples(spacing, 0.0);
        samples.iter_mut().for_each(|s| s.wall = Some(deepest));
        let sweep = |samples| sweep::sweep(tile, samples, cuts, material);
        let ends = Ends { tile, facets: &[stock, walls], of_part: None, deepest };
        ends.applied(sweep(samples), Swept::is_cut, sweep)
    })
}

/// Where the material behind walls ends: where another wall is nearer.
struct Ends<'a> {
    tile: &'a samples::Tile,
    /// The walls.
    facets: &'a [Facets<'a>],
    /// For the part itself, the tolerance, mm.
    of_part: Option<f64>,
    /// Depths greater than this do not matter, mm.
    deepest: f64,
}

impl Ends<'_> {
    /// A tile swept again where a cut into its samples reaches beyond the end of their material.
    fn applied(
        &self,
        swept: SweptTile,
        is_cut: impl Fn(&Swept) -> bool,
        sweep: impl Fn(Vec<samples::Sample>) -> SweptTile,
    ) -> SweptTile {
        if !swept.samples.iter().any(&is_cut) {
            return swept;
        }
        let Self { tile, deepest, .. } = *self;
        let near = |facets| walls::near(facets, tile.centre, tile.radius + 2.0 * deepest);
        let facets: Vec<walls::Facet> = self.facets.iter().copied().flat_map(near).collect();
        let mut ends = false;
        let limited = |s: &Swept| {
            let mut sample = s.sample;
            if is_cut(s) {
                let (place, normal) = (sample.position, sample.normal);
                let behind = match self.of_part {
                    Some(tolerance) => {
                        walls::part_behind(place, normal, &facets, deepest, tolerance)
                    }
                    None => walls::depth_behind(place, normal, &facets, &|_| true, deepest),
                };
                if behind < deepest {
                    (ends, sample.wall) = (true, Some(behind));
                }
            }
            sample
        };
        let samples = swept.samples.iter().map(limited).collect();
        if ends { sweep(samples) } else { swept }
    }
}

/// The height above the edge of a surface up to which a wall has to be checked, mm: what a cutter does higher up, it
/// also does lower down.
fn highest_reached(path: &Toolpath, design: Facets, walls: Walls, options: &VerifyOptions) -> f64 {
    let radius = options.tool.radius();
    let up = |p: &DVec3| p.dot(options.up);
    let is_upright = path.points.iter().all(|p| p.axis.dot(options.up) > UPRIGHT);
    if walls.rise == Rise::Up && is_upright {
        // Above its end the cutter is a cylinder along the wall: down to its lowest place and up again it cuts the same.
        let heights = || design.positions.iter().map(up);
        let (lowest, highest) =
            (heights().fold(f64::INFINITY, f64::min), heights().fold(f64::MIN, f64::max));
        let top = highest + walls.height;
        let of_move = |tips: [DVec3; 2]| {
            let [from, to] = tips.map(|tip| up(&tip));
            let across = (tips[1] - tips[0]).reject_from_normalized(options.up).length();
            if across < STRAIGHT_UP { from.min(to) } else { from.max(to) }
        };
        let moves = path.points.windows(2).map(|pair| [pair[0].tip, pair[1].tip]);
        let below = moves.filter(|tips| tips.iter().any(|tip| up(tip) <= top));
        return below.map(of_move).fold(lowest, f64::max) - lowest + 2.0 * radius;
    }
    let all = || path.points.iter().map(|p| p.tip).chain(design.positions.iter().copied());
    let (low, high) =
        all().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(l, h), p| (l.min(p), h.max(p)));
    low.distance(high) + options.length + radius
}

/// The distance between samples, once all results are in order.
fn checked(
    path: &Toolpath,
    area: f64,
    rest: f64,
    options: &VerifyOptions,
) -> Result<f64, VerifyError> {
    let positive = |what, value: f64| {
        if value > 0.0 { Ok(()) } else { Err(VerifyError::NotPositive { what, value }) }
    };
    positive("the depth of the stock", options.depth + options.allowance)?;
    positive("the distance of samples", options.spacing)?;
    positive("the length of the cutter", options.length)?;
    positive("the height of the walls", options.walls.map_or(1.0, |w| w.height))?;
    if path.points.len() < 2 {
        return Err(VerifyError::NoPath { points: path.points.len() });
    }
    if !(area.is_finite() && area > 0.0) {
        return Err(VerifyError::NoSurface);
    }
    let cuts = path.points.windows(2).filter(|w| w[1].kind != MoveKind::Rapid);
    let length: f64 = cuts.map(|w| w[0].tip.distance(w[1].tip)).sum();
    let radius = options.tool.radius();
    if length > LONGEST_PATH * radius || length.is_nan() {
        return Err(VerifyError::TooFine { length, radius });
    }
    Ok(options.spacing.max(((area + rest) / MOST_SAMPLES).sqrt()))
}

/// Volume by step, adding the tiles in their order.
fn summed<'a>(swept: impl Iterator<Item = &'a SweptTile>) -> Vec<(u64, f64)> {
    let mut all: Vec<(u64, f64)> = swept.flat_map(|t| t.removed.iter().copied()).collect();
    all.order_by_key(|r| r.0);
    all.dedup_by(|next, sum| {
        let same = next.0 == sum.0;
        if same {
            sum.1 += next.1;
        }
        same
    });
    all
}

/// The deepest touch of every rapid that touches, in order.
fn touches<'a>(swept: impl Iterator<Item = &'a SweptTile>) -> Vec<Touch> {
    let mut all: Vec<Touch> = swept.flat_map(|t| t.touched.iter().copied()).collect();
    all.retain(|t| t.depth > GRAZE);
    all.order_by(|a, b| a.of.cmp(&b.of).then(b.depth.total_cmp(&a.depth)));
    all.dedup_by_key(|t| t.of);
    all
}

/// The outcome of every sample, by tile.
fn outcomes(
    swept: &[SweptTile],
    walled: &[[DVec3; 2]],
    options: &VerifyOptions,
) -> Vec<Vec<Outcome>> {
    let of_tile = |tile: &SweptTile| {
        let (low, high) = samples::bounds(tile.samples.iter().map(|s| s.sample.position));
        let (centre, radius) = (0.5 * (low + high), 0.5 * low.distance(high));
        let excused = Excused::near(options, walled, centre, radius);
        tile.samples.iter().map(|s| excused.outcome(s, options)).collect()
    };
    swept.iter().map(of_tile).collect()
}

#[cfg(test)]
mod tests;
