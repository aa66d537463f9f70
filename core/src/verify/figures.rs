//! Figures of the samples: scallops, gouges, untouched area, and which limits are broken.

use super::load::{Load, LoadOptions, Worst};
use super::options::VerifyOptions;
use super::outcome::Outcome;
use super::rate::{Rate, Window};
use super::sweep::{SweptTile, Touch};
use crate::geometry::{DVec3, OrderBy, math};
use crate::tool::AssemblyPart;
use crate::toolpath::{MoveKind, Toolpath};

/// Upper ends of the slope bands, degrees; the last has none.
const BANDS: [f64; 4] = [15.0, 30.0, 45.0, 60.0];
/// Deepest gouge that is measured, cutter radii.
pub(super) const DEEPEST: f64 = 0.5;
/// Deepest cut into a wall that is measured, cutter radii.
pub(super) const DEEPEST_IN_WALL: f64 = 2.0;
/// Greatest number of places listed for each kind.
const MOST_SPOTS: usize = 10;
/// A peak of the removal rate above the limit by more than this factor breaks it: allows for the scatter that windows
/// of a fifth of the radius have because of the finite number of samples.
pub const MRR_NOISE: f64 = 1.03;

/// A place and the height there.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Spot {
    /// Where, mm.
    pub place: DVec3,
    /// Height, mm.
    pub height: f64,
    /// Index of the move that left it; that move ends at the next point of the path.
    pub of: Option<u32>,
    /// Whether that move or an earlier cut reached it.
    pub is_cut: bool,
}

/// Samples of a slope band or a region.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Band {
    /// Area, mm².
    pub area: f64,
    /// Area above the limit on the scallop, mm².
    pub above: f64,
    /// Largest residual, mm.
    pub largest: f64,
}

/// A move that is not allowed.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Fault {
    /// Index of the move.
    pub of: u32,
    /// Where, mm.
    pub place: DVec3,
    /// Depth in the material, mm; 0 where depth is not the fault.
    pub depth: f64,
}

/// Cuts into walls that are not faces of the part; they do not count in the other figures.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct WallFigures {
    /// Area of these walls, mm².
    pub area: f64,
    /// The deepest cut into them and where: its height is the depth, mm.
    pub deepest: Option<Spot>,
    /// Whether it may be deeper: cuts are measured only up to the cutter's diameter.
    pub is_deeper: bool,
    /// Area of wall cut into deeper than the tolerance, mm².
    pub cut: f64,
}

impl WallFigures {
    /// `None` where there is no such wall.
    pub(super) fn of(swept: &[SweptTile], options: &VerifyOptions) -> Option<Self> {
        let most = DEEPEST_IN_WALL * options.tool.radius() * (1.0 - 1e-6);
        let samples = || swept.iter().flat_map(|t| &t.samples);
        samples().next()?;
        let mut out = Self { area: 0.0, deepest: None, is_deeper: false, cut: 0.0 };
        for s in samples() {
            let (depth, area) = (-s.height, s.sample.section.area);
            out.area += area;
            out.cut += if depth > options.tolerance { area } else { 0.0 };
            if s.by.is_some() && depth > out.deepest.map_or(0.0, |d| d.height) {
                let (place, height) = (s.sample.position, depth);
                out.deepest = Some(Spot { place, height, of: s.by, is_cut: s.is_cut() });
            }
        }
        out.is_deeper = out.deepest.is_some_and(|d| d.height >= most);
        Some(out)
    }
}

/// The figures of the samples; areas in mm², heights in mm. Places where the plan says that the cutter does not fit
/// count only in `inaccessible`; gouges count everywhere.
#[derive(Clone, Debug, PartialEq)]
pub struct Figures {
    /// Area that is verified.
    pub area: f64,
    /// Number of samples.
    pub samples: usize,
    /// Distance between samples, mm.
    pub spacing: f64,
    /// Greatest amount by which the true largest residual may exceed the largest sampled one.
    pub sampling_bound: f64,
    /// Largest residual and where.
    pub largest: Option<Spot>,
    /// Residual below which 99 % of the area stays.
    pub p99: f64,
    /// Residual below which half of the area stays.
    pub p50: f64,
    /// Mean residual.
    pub mean: f64,
    /// Area above the limit on the scallop; 0 where there is none.
    pub above: f64,
    /// Places above limit and tolerance, worst first, a cutter radius apart.
    pub spots: Vec<Spot>,
    /// The same by slope: 0 to 15, 30, 45, 60 and above, degrees.
    pub by_slope: [Band; 5],
    /// The same by region of the path that left it, in their order.
    pub by_region: Vec<(u32, Band)>,
    /// Deepest gouge and where; heights negative.
    pub gouge: Option<Spot>,
    /// Whether it may be deeper: gouges are measured only up to half the cutter radius.
    pub gouge_is_deeper: bool,
    /// Area cut into deeper than the tolerance.
    pub gouged: f64,
    /// Cuts into walls; `None` where there are none but the part's own faces.
    pub walls: Option<WallFigures>,
    /// Cuts into the stock where the options say where it ends, which may be deep beside the surface.
    pub stock: Option<WallFigures>,
    /// Area that no move reached, and a place in it.
    pub untouched: (f64, Option<DVec3>),
    /// The area where the plan says that the cutter does not fit.
    pub inaccessible: Band,
    /// Rapids that touch stock or part.
    pub rapids: Vec<Fault>,
    /// Moves at feed without a feed.
    pub without_feed: Vec<Fault>,
    /// The limits that are broken.
    pub broken: Vec<Broken>,
}

/// What is asked of a cutter besides the removal rate.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// Angle of engagement, rad.
    Engagement,
    /// Feed per tooth, mm: the smallest.
    FeedPerTooth,
    /// Power, W.
    Power,
    /// Mean cutting force, N.
    Force,
}

/// The distance of a part of the assembly.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Nearest {
    /// Cutter, shank or holder.
    pub part: AssemblyPart,
    /// Least distance from part and stock, or from what is avoided, mm, too small by the accuracy at most; negative where it cuts in.
    pub distance: f64,
    /// Whether it may be greater: farther is not looked.
    pub is_farther: bool,
    /// What was asked, mm.
    pub wanted: f64,
    /// Where on it, mm.
    pub place: DVec3,
    /// Index of the move.
    pub of: u32,
}

impl Nearest {
    /// Whether it is nearer than was asked.
    pub fn is_too_near(&self) -> bool {
        self.distance < self.wanted
    }
}

/// A limit that is broken, or the lack of anything to verify.
#[derive(Copy, Clone, Debug, PartialEq)]
pub enum Broken {
    /// The scallop is too high.
    Scallop {
        /// Worst place.
        worst: Spot,
        /// Limit, mm.
        limit: f64,
    },
    /// The part is cut into.
    Gouge {
        /// Worst place.
        worst: Spot,
        /// Tolerance, mm.
        tolerance: f64,
    },
    /// A wall around what is machined is cut into.
    Wall {
        /// Worst place; its height is the depth.
        worst: Spot,
        /// Whether it may be deeper.
        is_deeper: bool,
        /// Tolerance, mm.
        tolerance: f64,
    },
    /// The stock is cut into deeper than is cut at once.
    Stock {
        /// Worst place; its height is the depth.
        worst: Spot,
        /// Whether it may be deeper.
        is_deeper: bool,
        /// How deep it may be, mm.
        limit: f64,
    },
    /// Shank or holder come too near to part or stock.
    TooNear {
        /// What comes how near.
        nearest: Nearest,
        /// By how much farther the cutter would have to stand out, mm, if that would do.
        farther_out: Option<f64>,
    },
    /// Cutter, shank or holder come too near to what is avoided.
    Avoided {
        /// Index of that.
        index: usize,
        /// What comes how near.
        nearest: Nearest,
        /// Whether it does on a rapid.
        on_rapid: bool,
        /// By how much farther the cutter would have to stand out, mm, if that would do.
        farther_out: Option<f64>,
    },
    /// The cutter fits nowhere, so that nothing can be verified.
    FitsNowhere {
        /// Area, mm².
        area: f64,
    },
    /// Stock was not reached.
    Untouched {
        /// Area, mm².
        area: f64,
        /// A place in it, mm.
        place: DVec3,
    },
    /// The removal rate is too high.
    RemovalRate {
        /// The worst window.
        worst: Window,
        /// Limit, mm³/s.
        limit: f64,
    },
    /// Too much is asked of the cutter.
    Load {
        /// What.
        quantity: Quantity,
        /// The worst value, in the quantity's unit.
        value: f64,
        /// Its limit.
        limit: f64,
        /// The window.
        at: Window,
    },
    /// Rapids touch stock.
    Rapid {
        /// How many.
        count: usize,
        /// The deepest.
        worst: Fault,
    },
    /// Moves at feed without a feed.
    NoFeed {
        /// How many.
        count: usize,
        /// The first.
        first: Fault,
    },
}

/// Results of the sweep.
#[derive(Copy, Clone, Debug)]
pub(super) struct Found<'a> {
    /// The samples.
    pub samples: &'a [Outcome],
    /// Further places, without area: they count only for the largest heights.
    pub further: &'a [Outcome],
    /// No height exceeds this or the largest residual, mm.
    pub highest: f64,
}

impl Figures {
    pub(super) fn of(
        path: &Toolpath,
        found: Found,
        [walls, stock]: [Option<WallFigures>; 2],
        touches: &[Touch],
        (rate, load): (&Rate, Option<&Load>),
        spacing: f64,
        options: &VerifyOptions,
    ) -> Self {
        let Found { samples, further, highest } = found;
        let judged: Vec<&Outcome> = samples.iter().filter(|s| s.is_judged()).collect();
        // Those that count for heights.
        let higher = further.iter().filter(|s| s.is_judged());
        let heights: Vec<&Outcome> = judged.iter().copied().chain(higher).collect();
        let of_part = || samples.iter().chain(further).filter(|s| s.is_of_part());
        let limit = options.scallop.unwrap_or(f64::INFINITY);
        let deepest = DEEPEST * options.tool.radius() * (1.0 - 1e-6) + options.allowance;
        let largest = worst(heights.iter().copied(), |s| s.residual);
        let [p50, p99] = percentiles(&judged);
        // On the rim, too, where samples have no area.
        let untouched = heights.iter().filter(|s| !s.is_cut());
        let mut figures = Self {
            area: sum(&judged, |_| 1.0),
            samples: samples.len(),
            spacing,
            sampling_bound: largest.map_or(0.0, |l| (highest - l.height).max(0.0)),
            largest,
            p99,
            p50,
            mean: sum(&judged, |s| f64::from(s.residual).max(0.0))
                / sum(&judged, |_| 1.0).max(1e-300),
            above: sum(&judged, |s| f64::from(u8::from(f64::from(s.residual) > limit))),
            spots: spots(&heights, limit + options.tolerance, options.tool.radius()),
            by_slope: by_slope(&heights, limit),
            by_region: by_region(path, &heights, limit),
            gouge: worst(of_part(), |s| -s.residual)
                .map(|s| Spot { height: -s.height, ..s })
                .filter(|s| s.height < 0.0),
            gouge_is_deeper: of_part().any(|s| f64::from(s.residual) <= -deepest),
            gouged: samples
                .iter()
                .filter(|s| s.is_of_part() && f64::from(s.residual) < -options.tolerance)
                .map(|s| f64::from(s.area))
                .sum(),
            walls,
            stock,
            untouched: (
                untouched.clone().map(|s| f64::from(s.area)).fold(0.0, |sum, area| sum + area),
                untouched.clone().next().map(|s| s.place()),
            ),
            inaccessible: Band::default(),
            rapids: touches
                .iter()
                .map(|t| Fault { of: t.of, place: t.place, depth: t.depth })
                .collect(),
            without_feed: without_feed(path)
                .map(|(of, place)| Fault { of, place, depth: 0.0 })
                .collect(),
            broken: Vec::new(),
        };
        let of_inaccessible = samples.iter().filter(|s| s.machined && s.inaccessible);
        of_inaccessible.for_each(|s| figures.inaccessible.add(s, limit));
        figures.broken = figures.broken((rate, load), options);
        figures
    }

    fn broken(&self, (rate, load): (&Rate, Option<&Load>), options: &VerifyOptions) -> Vec<Broken> {
        let scallop = self.largest.zip(options.scallop).and_then(|(worst, limit)| {
            (worst.height > limit + options.tolerance).then_some(Broken::Scallop { worst, limit })
        });
        let tolerance = options.tolerance;
        let gouge = self
            .gouge
            .filter(|g| g.height < -tolerance)
            .map(|worst| Broken::Gouge { worst, tolerance });
        let wall = self.walls.and_then(|walls| {
            let worst = walls.deepest.filter(|d| d.height > tolerance)?;
            Some(Broken::Wall { worst, is_deeper: walls.is_deeper, tolerance })
        });
        let stock = self.stock.and_then(|stock| {
            let limit = options.most_into_stock();
            let worst = stock.deepest.filter(|d| d.height > limit)?;
            Some(Broken::Stock { worst, is_deeper: stock.is_deeper, limit })
        });
        let of_inaccessible = self.inaccessible.area;
        let nowhere = (self.area == 0.0 && of_inaccessible > 0.0)
            .then_some(Broken::FitsNowhere { area: of_inaccessible });
        let untouched =
            self.untouched.1.map(|place| Broken::Untouched { area: self.untouched.0, place });
        let mrr = rate.peak.zip(options.mrr_limit).and_then(|(worst, limit)| {
            let over = worst.measured > MRR_NOISE * limit;
            over.then_some(Broken::RemovalRate { worst, limit })
        });
        let deepest =
            self.rapids.iter().copied().reduce(|a, b| if b.depth > a.depth { b } else { a });
        let rapid = deepest.map(|worst| Broken::Rapid { count: self.rapids.len(), worst });
        let first = self.without_feed.first().copied();
        let no_feed = first.map(|first| Broken::NoFeed { count: self.without_feed.len(), first });
        let loads = load.zip(options.load).map(|(load, limits)| overloads(load, limits));
        let first = [nowhere, scallop, gouge, wall, stock, untouched, mrr];
        let last = [rapid, no_feed];
        first
            .into_iter()
            .flatten()
            .chain(loads.into_iter().flatten())
            .chain(last.into_iter().flatten())
            .collect()
    }
}

/// The limits on the load that are broken.
fn overloads(load: &Load, limits: LoadOptions) -> Vec<Broken> {
    let above = |worst: Worst, limit: Option<f64>, quantity: Quantity| {
        let ((value, at), limit) = worst.zip(limit)?;
        (quantity.share(value, limit) > quantity.noise()).then_some(Broken::Load {
            quantity,
            value,
            limit,
            at,
        })
    };
    let all = [
        above(load.engaged, limits.most_engaged, Quantity::Engagement),
        above(load.per_tooth, limits.least_per_tooth, Quantity::FeedPerTooth),
        above(load.power, limits.most_power, Quantity::Power),
        above(load.force, limits.most_force, Quantity::Force),
    ];
    all.into_iter().flatten().collect()
}

impl Quantity {
    /// A value as a multiple of its limit; of the volume removed, for an angle.
    fn share(self, value: f64, limit: f64) -> f64 {
        match self {
            Self::Engagement => (1.0 - math::cos(value)) / (1.0 - math::cos(limit)),
            Self::FeedPerTooth => limit / value,
            Self::Power | Self::Force => value / limit,
        }
    }

    /// From which multiple on the limit is broken. The feed is known without scatter, but for rounding.
    fn noise(self) -> f64 {
        match self {
            Self::FeedPerTooth => 1.01,
            Self::Engagement | Self::Power | Self::Force => MRR_NOISE,
        }
    }
}

impl Outcome {
    fn spot(&self) -> Spot {
        let (place, height) = (self.place(), f64::from(self.residual));
        Spot { place, height, of: self.by, is_cut: self.is_cut() }
    }
}

impl Band {
    fn add(&mut self, s: &Outcome, limit: f64) {
        let (area, residual) = (f64::from(s.area), f64::from(s.residual));
        self.area += area;
        self.above += if residual > limit { area } else { 0.0 };
        self.largest = self.largest.max(residual);
    }
}

/// How far the residual may rise between samples: the greatest slope of the cutter's side relative to the surface at
/// the height of the largest residual, times the distance to the next sample.
pub(super) fn sampling_bound(height: f64, spacing: f64, options: &VerifyOptions) -> f64 {
    let corner = options.tool.corner_radius();
    let part = if corner > 0.0 { height.max(0.0) / corner } else { 1.0 };
    // The slope of a circle where it stands that high.
    let cosine = (1.0 - part).max(0.0);
    0.5 * spacing * (1.0 - cosine * cosine).sqrt()
}

fn sum(samples: &[&Outcome], of: impl Fn(&Outcome) -> f64) -> f64 {
    samples.iter().map(|s| f64::from(s.area) * of(s)).sum()
}

fn worst<'a>(
    samples: impl Iterator<Item = &'a Outcome>,
    of: impl Fn(&Outcome) -> f32,
) -> Option<Spot> {
    let largest = samples.reduce(|a, b| if of(b) > of(a) { b } else { a })?;
    Some(Spot { height: f64::from(of(largest)), ..largest.spot() })
}

/// The residuals below which half and 99 % of the area stay.
fn percentiles(samples: &[&Outcome]) -> [f64; 2] {
    let mut sorted: Vec<(f32, f32)> = samples.iter().map(|s| (s.residual, s.area)).collect();
    sorted.order_total_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
    let total: f64 = sorted.iter().map(|s| f64::from(s.1)).sum();
    let at = |share: f64| {
        let mut left = share * total;
        let reached = sorted.iter().find(|s| {
            left -= f64::from(s.1);
            left <= 0.0
        });
        reached.or(sorted.last()).map_or(0.0, |s| f64::from(s.0))
    };
    [at(0.5), at(0.99)]
}

/// The worst places above `limit`, at least `apart` mm from each other.
fn spots(samples: &[&Outcome], limit: f64, apart: f64) -> Vec<Spot> {
    let mut above: Vec<Spot> =
        samples.iter().filter(|s| f64::from(s.residual) > limit).map(|s| s.spot()).collect();
    above.order_by(|a, b| b.height.total_cmp(&a.height));
    let mut out: Vec<Spot> = Vec::new();
    for spot in above {
        if out.len() < MOST_SPOTS && out.iter().all(|o| o.place.distance(spot.place) > apart) {
            out.push(spot);
        }
    }
    out
}

fn by_slope(samples: &[&Outcome], limit: f64) -> [Band; 5] {
    let mut bands: [Band; 5] = Default::default();
    let cosines = BANDS.map(|b| math::cos(b.to_radians()));
    for s in samples {
        let band = cosines.iter().filter(|&&c| f64::from(s.up) < c).count();
        bands[band].add(s, limit);
    }
    bands
}

fn by_region(path: &Toolpath, samples: &[&Outcome], limit: f64) -> Vec<(u32, Band)> {
    let mut bands = std::collections::BTreeMap::<u32, Band>::new();
    for s in samples {
        let point = s.by.and_then(|of| path.points.get(of as usize + 1));
        if let Some(point) = point {
            bands.entry(point.region).or_default().add(s, limit);
        }
    }
    bands.into_iter().collect()
}

/// Moves at feed without a feed: index and end of each.
fn without_feed(path: &Toolpath) -> impl Iterator<Item = (u32, DVec3)> + '_ {
    path.points.windows(2).enumerate().filter_map(|(i, pair)| {
        let moves = pair[0].tip != pair[1].tip || pair[0].axis != pair[1].axis;
        let fed = pair[1].kind == MoveKind::Rapid || pair[1].feed > 0.0;
        (moves && !fed).then_some((i as u32, pair[1].tip))
    })
}
