//! Variable-radius trochoids: loops that cut over-engaged stretches of a ring, or of an open pass, in thin bites. What is
//! said of rings holds of open passes.
//!
//! - *Corridor*: the free space between the ring and what is beside it: the next ring, the other side of the same ring,
//!   another wall.
//! - *Guide*: the medial line of the corridor, on which the loop centres run; the inscribed circle is the loop.
//! - *Bite*: the step from one loop to the next; chosen so that the loop's peak removal rate,
//!   measured against the stock, is just below the limit.
//! - *Share*: the rate of the real cutter over that of the disc, known from the plain passes.
//!
//! 1. At each place of the ring the inscribed circle that touches it there.
//! 2. The cutting part of one revolution while the centre moves one bite and the radius changes linearly,
//!    `C(t) = O(t) + R(t) (cos, sin)`. The rest of it cuts nothing: a chord leads to where the next cut begins. Where
//!    the ring is run again anyway, a loop ends before its cut is thin.
//! 3. The bite from the closed form for the first try, then corrected by measurement. A loop that would cut nothing
//!    is not made: into a corner loops go in only, though the ring beside them goes in and out.
//!
//! Source: "Trajectory planning for constant-force milling of freeform surfaces based on conformal mapping",
//! a Chinese patent application: trochoids of variable radius.

mod corridor;

pub use corridor::Corridor;

use crate::engagement::Simulation;
use crate::geometry::{DVec2, math};
use crate::toolpath::MoveKind;
use core::f64::consts::{PI, TAU};

/// A loop's peak is steered to this fraction of the limit. Higher: more loops are made twice; lower: more loops.
const AIM_PEAK: f64 = 0.975;
/// A loop whose peak is above this fraction of the limit is made again with a smaller bite.
const HIGH_PEAK: f64 = 0.998;
/// Number of consecutive slowed loops after which the ring is followed at limited feed instead.
const MOST_FAILURES: usize = 25;
/// Tries per loop before it is slowed instead.
const TRIES: usize = 8;
/// Smallest bite as a fraction of the cutter radius; where it is too much the feed is reduced.
const SMALLEST_BITE: f64 = 2e-3;

/// Loops may have this many times the radius wanted, where rings are farther apart: in corners.
const LARGEST: f64 = 2.0;
/// Where the ring is run again a loop is left when its cut falls below this fraction of its peak. Higher: the ring
/// takes more; lower: loops end with thin bites.
const THIN: f64 = 0.35;
/// Where the ring is run again loops have this fraction of the radius of the inscribed circle: a path that touches two
/// walls in turn would be led into the corner between them.
const SHY: f64 = 0.97;
/// From the boundary on loops are begun where they have this fraction of the radius that they reach within this many
/// radii of theirs.
const WIDE: f64 = 0.9;
const WIDE_WITHIN: f64 = 6.0;
/// Places between which loops that grow are interpolated.
const GROWING: usize = 4;
/// A cut begins this many turns before the one of the loop before did.
const LEAD_IN: f64 = 0.05;
/// The last loops of a stretch, up to this number, are evened out.
const EVENED: f64 = 3.0;
/// The engagement of a falling cut does not rise by more than this from one side of a loop to the next.
const FALLING: f64 = 0.02;
/// Distance of the places where a way is asked for stock, cutter radii.
const CLEAR_SPACING: f64 = 0.2;
/// An engagement below this counts as rounding.
const IDLE: f64 = 1e-9;

/// Passes by which a loop may lie outside of ring 0, to allow for the inaccuracy of the field between vertices.
const ROOM_SLACK: f64 = 0.02;

/// Greatest number of turns of a helix; a limit that would need more is kept by a slower feed.
const MOST_TURNS: f64 = 60.0;

/// Options of the loops; lengths in mm on the surface, feeds in mm/s.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Loops {
    /// Loop radius where rings are one side step apart, mm.
    pub radius: f64,
    /// Where rings are closer, loops of this radius may reach beyond the neighbour, mm.
    pub least: f64,
    /// Loops smaller than this are not made, mm; the ring is slowed there instead.
    pub smallest: f64,
    /// Largest bite, mm.
    pub max_bite: f64,
    /// Feed where a loop cuts nothing, mm/s.
    pub return_feed: f64,
    /// Chord error of a loop, mm.
    pub tolerance: f64,
    /// +1: stock on the right of a move and loops counter-clockwise (climb); -1: the reverse.
    pub hand: f64,
}

/// A place on the ring and the loop that touches it.
#[derive(Copy, Clone, Debug)]
struct Station {
    /// On the ring.
    touch: DVec2,
    /// Loop centre.
    center: DVec2,
    /// Loop radius, flat mm.
    radius: f64,
    /// True removal rate over that of the disc.
    share: f64,
}

/// A stretch of a ring.
#[derive(Copy, Clone, Debug)]
pub struct Span<'a> {
    /// Flat points, at least two.
    pub points: &'a [DVec2],
    /// The branches of the ring on this stretch, in order.
    pub branches: &'a [BranchRef<'a>],
    /// What stands beside the ring.
    pub corridor: &'a Corridor,
    /// +1 for loops on the stock side of the ring, -1 for loops on the cleared side.
    pub toward: f64,
    /// At each point the true removal rate over that of the disc: 1 where it is not known.
    pub shares: &'a [f64],
    /// Whether the stretch is run again afterwards, which takes what loops leave beside the ring.
    pub is_run_again: bool,
    /// Whether the stretch begins on the boundary, where no loop has room: the first one is made where the corridor is
    /// wide.
    pub begins_at_boundary: bool,
}

/// A branch that leaves from a stretch.
#[derive(Copy, Clone, Debug)]
pub struct BranchRef<'a> {
    /// Index of the point of the stretch from which it leaves and to which it returns.
    pub at: usize,
    /// Flat points between leaving and returning.
    pub points: &'a [DVec2],
}

/// Cuts the stretch `span` of a ring by loops.
///
/// The simulation must be where the first loop may start: see [`enter`]. Branches are not part of the guide: each is
/// cut, slower where the limit requires it, once the loops are past it. Returns the number of loops.
pub fn clear_span(simulation: &mut Simulation, span: &Span, loops: &Loops) -> usize {
    let guide = Guide::new(simulation, span, loops);
    let mut branches = guide.branches(span).into_iter().peekable();
    let mut count = 0;
    let mut bite = first_bite(simulation, &guide, loops);
    let (mut along, mut failures) = (0.0, 0);
    // Where on its loop a cut begins, in turns, and where on the guide the cutter is.
    let (mut begin, mut left) = (0.0, 0.0);
    while along < guide.length {
        let here = guide.station(along);
        while let Some((_, root, branch)) = branches.next_if(|(at, ..)| at + here.radius <= along) {
            branch.cut(simulation, root);
            begin = 0.0;
        }
        if here.radius * simulation.cutting.radius < loops.smallest * simulation.disc(here.center) {
            along = guide.skip_narrow(simulation, along, loops);
            (begin, left) = (0.0, along);
            continue;
        }
        let step = LoopStep {
            guide: &guide,
            from: along,
            here,
            loops,
            begin,
            left,
            is_run_again: span.is_run_again,
        };
        let taken = match step.take(simulation, bite) {
            Ok(taken) => {
                failures = 0;
                taken
            }
            Err(last) if failures < MOST_FAILURES => {
                failures += 1;
                step.slowed(simulation, last)
            }
            Err(_) => {
                guide.follow(simulation, along);
                break;
            }
        };
        bite = taken.next_bite;
        along += taken.used;
        if let Some(next) = taken.begin {
            (begin, left) = (next, along);
            count += 1;
        }
    }
    let last = guide.station(guide.length);
    guide.go(simulation, (left, guide.length), last.touch);
    for (_, root, branch) in branches {
        branch.cut(simulation, root);
        simulation.cut_limited(last.touch, MoveKind::Cut);
    }
    count
}

impl BranchRef<'_> {
    /// Goes to the root, out and back.
    fn cut(&self, simulation: &mut Simulation, root: DVec2) {
        simulation.cut_limited(root, MoveKind::Cut);
        simulation.facing_on(|simulation| {
            let way = self.points.iter().chain([&root]);
            way.for_each(|&p| simulation.cut_limited(p, MoveKind::Cut));
        });
    }
}

/// Where the first loop of a span starts: the back of the loop, its centre and radius.
pub fn entry(simulation: &Simulation, span: &Span, loops: &Loops) -> (DVec2, DVec2, f64) {
    let guide = Guide::new(simulation, span, loops);
    let first = guide.station(0.0);
    let back = first.center - guide.heading(0.0) * first.radius;
    (back, first.center, first.radius)
}

/// Bite of the closed form: `S` for which `cos(phi) = (Q² - R² - (S + r)²) / (2 R (S + r))`, `Q = R + r`, gives the
/// engagement that meets the limit. This engagement is an upper bound.
fn first_bite(simulation: &Simulation, guide: &Guide, loops: &Loops) -> f64 {
    let (Station { radius, share, .. }, disc) = (guide.station(0.0), guide.start_disc);
    let intensity = simulation.cutting.limit
        / share
        / (simulation.cutting.radius * simulation.cutting.depth * simulation.cutting.feed);
    let cosine = 1.0 - intensity.min(1.9);
    // (S + r)² + 2 R cos(phi) (S + r) - (Q² - R²) = 0
    let half = disc * cosine;
    let outer = disc + radius;
    let bite = -half + (half * half + outer * outer - disc * disc).sqrt() - radius;
    let scale = simulation.cutting.radius / disc;
    let largest = loops.max_bite / scale;
    bite.clamp((SMALLEST_BITE * disc).min(largest), largest)
}

/// The medial line beside a stretch of ring, by arc length, with the loop that belongs to each place.
struct Guide {
    stations: Vec<Station>,
    /// Arc length of the loop centres up to each station, flat mm.
    arc: Vec<f64>,
    length: f64,
    start_disc: f64,
    /// Least radius of a loop, flat mm.
    smallest: f64,
}

impl Guide {
    fn new(simulation: &Simulation, span: &Span, loops: &Loops) -> Self {
        let disc = simulation.disc(span.points[0]);
        let wanted = loops.radius * disc / simulation.cutting.radius;
        let ring = resample(span, (0.25 * wanted).max(0.02 * disc));
        let mut stations: Vec<Station> = Vec::new();
        for i in 0..ring.len() {
            let (before, after) =
                (ring[i.saturating_sub(1)].0, ring[(i + 1).min(ring.len() - 1)].0);
            let heading = (after - before).normalize_or_zero();
            // With the stock on the right of the move, `hand` +1, its side is the clockwise one.
            let side = -heading.perp() * (loops.hand * span.toward);
            let mut station = largest_loop(simulation, ring[i].0, side, span.corridor, loops);
            station.share = ring[i].1;
            if span.is_run_again {
                station.radius *= SHY;
            }
            stations.push(station);
        }
        if span.begins_at_boundary {
            begin_wide(&mut stations, (WIDE_WITHIN * wanted, span.toward < 0.0));
        }
        let mut arc = vec![0.0];
        for w in stations.windows(2) {
            let step =
                0.5 * ((w[1].center - w[0].center).length() + (w[1].touch - w[0].touch).length());
            arc.push(arc[arc.len() - 1] + step);
        }
        let length = arc[arc.len() - 1];
        let smallest = loops.smallest * disc / simulation.cutting.radius;
        Self { stations, arc, length, start_disc: disc, smallest }
    }

    /// Where along the guide the branches of its stretch leave, and from which point.
    fn branches<'b>(&self, span: &Span<'b>) -> Vec<(f64, DVec2, BranchRef<'b>)> {
        let mut from = 0;
        let place = |branch: &BranchRef<'b>| {
            let root = span.points[branch.at];
            let distance = |i: &usize| (self.stations[*i].touch - root).length_squared();
            let near = |a: &usize, b: &usize| distance(a).total_cmp(&distance(b)).then(a.cmp(b));
            from = (from..self.stations.len()).min_by(near).unwrap_or(from);
            (self.arc[from], root, *branch)
        };
        span.branches.iter().map(place).collect()
    }

    fn segment(&self, along: f64) -> (usize, f64) {
        let i = self.arc.partition_point(|&a| a <= along).clamp(1, self.arc.len().max(2) - 1);
        let (a, b) = (self.arc[i - 1], self.arc[i.min(self.arc.len() - 1)]);
        (i - 1, if b > a { ((along - a) / (b - a)).clamp(0.0, 1.0) } else { 0.0 })
    }

    fn station(&self, along: f64) -> Station {
        let (i, t) = self.segment(along);
        let (a, b) = (self.stations[i], self.stations[(i + 1).min(self.stations.len() - 1)]);
        Station {
            touch: a.touch.lerp(b.touch, t),
            center: a.center.lerp(b.center, t),
            radius: a.radius + (b.radius - a.radius) * t,
            share: a.share + (b.share - a.share) * t,
        }
    }

    /// Unit direction of the guide.
    fn heading(&self, along: f64) -> DVec2 {
        let window = 0.5 * self.stations[0].radius.max(0.02 * self.start_disc);
        let (back, ahead) = (self.station(along - window), self.station(along + window));
        let centers = (ahead.center - back.center).normalize_or_zero();
        let touches = (ahead.touch - back.touch).normalize_or_zero();
        let mean = (centers + touches).normalize_or_zero();
        if mean == DVec2::ZERO { DVec2::X } else { mean }
    }

    /// Goes to `to`, straight where nothing is in the way, else along the loops' centres between two places.
    fn go(&self, simulation: &mut Simulation, (from, until): (f64, f64), to: DVec2) {
        if !is_clear_way(simulation, to) {
            let (first, last) = (self.segment(from).0, self.segment(until).0);
            // Where there is hardly room the centres lie on the rim of what may be cut.
            let wide = self.stations[first..=last].iter().filter(|s| s.radius >= self.smallest);
            wide.for_each(|s| simulation.cut_limited(s.center, MoveKind::Trochoid));
        }
        simulation.cut_limited(to, MoveKind::Trochoid);
    }

    /// Follows the ring at limited feed to its end.
    fn follow(&self, simulation: &mut Simulation, from: f64) {
        let (start, _) = self.segment(from);
        self.stations[start..].iter().for_each(|s| simulation.cut_limited(s.touch, MoveKind::Cut));
    }

    /// Follows the ring at limited feed while the corridor is too narrow; returns where it ends.
    fn skip_narrow(&self, simulation: &mut Simulation, from: f64, loops: &Loops) -> f64 {
        let (start, _) = self.segment(from);
        for i in start..self.stations.len() {
            let s = self.stations[i];
            let wide =
                s.radius * simulation.cutting.radius >= loops.smallest * simulation.disc(s.center);
            if wide && self.arc[i] > from {
                return self.arc[i];
            }
            simulation.cut_limited(s.touch, MoveKind::Cut);
        }
        self.length
    }
}

/// Drops the stations before the first one whose loop is about as large as loops become within a distance. Where loops
/// run on a side that is cleared, those at that place grow from there on: the first one would be a slot.
fn begin_wide(stations: &mut Vec<Station>, (within, is_cleared): (f64, bool)) {
    let Some(start) = stations.first().map(|s| s.touch) else { return };
    let near = || stations.iter().take_while(|s| s.touch.distance(start) <= within);
    let largest = near().fold(0.0, |most: f64, s| most.max(s.radius));
    let first = near().position(|s| s.radius >= WIDE * largest).unwrap_or(0);
    stations.drain(..first);
    if is_cleared {
        let wide = stations[0];
        let to_side = 2.0 * (wide.center - wide.touch);
        let grown = |i: usize| {
            let part = i as f64 / GROWING as f64;
            let touch = wide.touch + to_side * (1.0 - part);
            Station {
                touch,
                center: touch + 0.5 * part * to_side,
                radius: part * wide.radius,
                ..wide
            }
        };
        stations.splice(..0, (0..GROWING).map(grown));
    }
}

/// The polyline of a stretch with its shares and points at most `spacing` apart, keeping its corners.
fn resample(span: &Span, spacing: f64) -> Vec<(DVec2, f64)> {
    let mut out = vec![(span.points[0], span.shares[0])];
    for (w, s) in span.points.windows(2).zip(span.shares.windows(2)) {
        let n = ((w[1] - w[0]).length() / spacing).ceil().max(1.0) as usize;
        let at = |i: usize| i as f64 / n as f64;
        out.extend((1..=n).map(|i| (w[0].lerp(w[1], at(i)), s[0] + (s[1] - s[0]) * at(i))));
    }
    out
}

/// The largest loop that touches the ring at `touch` on the given side, stays in the corridor and inside of ring 0.
fn largest_loop(
    simulation: &Simulation,
    touch: DVec2,
    side: DVec2,
    corridor: &Corridor,
    loops: &Loops,
) -> Station {
    let per_mm = simulation.disc(touch) / simulation.cutting.radius;
    let wanted = loops.radius * per_mm;
    let mut radius = corridor.inscribed(touch, side, loops.least * per_mm, LARGEST * wanted);
    for _ in 0..60 {
        let center = touch + side * radius;
        let fits = (0..8).all(|k| {
            let a = TAU * k as f64 / 8.0;
            let arm = -side * math::cos(a) + side.perp() * math::sin(a);
            is_inside(simulation, center + arm * radius)
        });
        if fits {
            return Station { touch, center, radius, share: 1.0 };
        }
        radius *= 0.95;
    }
    Station { touch, center: touch, radius: 0.0, share: 1.0 }
}

/// Whether the cutter centre may be at `p`: in the chart and not outside of ring 0.
fn is_inside(simulation: &Simulation, p: DVec2) -> bool {
    simulation.terrain.room(p).is_some_and(|room| room >= -ROOM_SLACK)
}

/// Whether the straight way to `to` cuts nothing and stays inside of ring 0.
fn is_clear_way(simulation: &Simulation, to: DVec2) -> bool {
    let (from, way) = (simulation.at(), to - simulation.at());
    let Some(feed) = way.try_normalize() else { return true };
    // Along the rim of what may be cut it would leave that by a rounding error.
    let middle = simulation.terrain.room(from + 0.5 * way);
    if !middle.is_some_and(|room| room >= ROOM_SLACK) {
        return false;
    }
    let steps = (way.length() / (CLEAR_SPACING * simulation.disc(from))).ceil().max(1.0) as usize;
    simulation.terrain.joins(from, to)
        && (0..=steps).all(|i| {
            let p = from + way * (i as f64 / steps as f64);
            is_inside(simulation, p) && simulation.engagement(p, feed).normal_feed < IDLE
        })
}

/// `center + arm`, shortened toward the centre until the cutter may be there.
fn drawn_in(simulation: &Simulation, center: DVec2, mut arm: DVec2) -> DVec2 {
    for _ in 0..200 {
        if is_inside(simulation, center + arm) {
            break;
        }
        arm *= 0.98;
    }
    center + arm
}

/// Whether a loop is cut at the nominal feed or slower where the limit requires it.
#[derive(Copy, Clone)]
enum Pace {
    Full,
    Limited,
}

impl Pace {
    fn go(self, simulation: &mut Simulation, to: DVec2) {
        match self {
            Self::Full => simulation.cut(to, MoveKind::Trochoid),
            Self::Limited => simulation.cut_limited(to, MoveKind::Trochoid),
        }
    }
}

/// One loop, from the station at `from` on.
struct LoopStep<'g> {
    guide: &'g Guide,
    from: f64,
    here: Station,
    loops: &'g Loops,
    /// Where on the loop the cut is expected to begin, in turns from its back.
    begin: f64,
    /// Where on the guide the cutter is.
    left: f64,
    is_run_again: bool,
}

/// What became of a loop.
struct Taken {
    /// The bite to try next.
    next_bite: f64,
    /// The bite used.
    used: f64,
    /// Where the next cut is expected to begin, in turns; `None` where there was nothing to cut and no move was made.
    begin: Option<f64>,
}

/// A loop that was made.
struct Made {
    peak: f64,
    /// Where it began to cut, in turns from its back; `None` where it cut nothing.
    first: Option<f64>,
}

impl LoopStep<'_> {
    /// Makes the loop with a bite whose peak stays below the limit.
    ///
    /// Loops change little from one to the next, so a peak that is merely low is accepted and corrected in the next
    /// loop. `Err`, with nothing cut and the last bite considered, when no bite tried is small enough.
    fn take(&self, simulation: &mut Simulation, first: f64) -> Result<Taken, f64> {
        let disc = simulation.disc(self.here.center);
        let per_mm = disc / simulation.cutting.radius;
        let largest = self.loops.max_bite * per_mm;
        let smallest = (SMALLEST_BITE * disc).min(largest);
        let mut bite = first.clamp(smallest, largest);
        let mut earlier: Option<(f64, f64)> = None;
        for _ in 0..TRIES {
            let mark = simulation.mark();
            let used = self.evened(bite);
            let made = self.run(simulation, used, Pace::Full);
            let peak = made.peak * self.here.share / simulation.cutting.limit;
            if made.first.is_none() {
                simulation.undo(&mark);
                simulation.keep();
                return Ok(Taken { next_bite: bite, used, begin: None });
            }
            if peak <= HIGH_PEAK {
                simulation.keep();
                let change = (AIM_PEAK / peak.max(0.5)).min(1.3);
                let next_bite = if used < bite { bite } else { bite * change };
                return Ok(Taken { next_bite, used, begin: self.next_begin(&made) });
            }
            simulation.undo(&mark);
            simulation.keep();
            if bite <= smallest {
                break;
            }
            let next = smaller_bite((used, peak), earlier);
            earlier = Some((used, peak));
            bite = next.max(smallest);
        }
        Err(bite)
    }

    /// The bite or, near the end of the guide, one that leaves no thin bite for the last loop.
    fn evened(&self, bite: f64) -> f64 {
        let rest = self.guide.length - self.from;
        let loops = (rest / bite).ceil();
        if loops <= EVENED { rest / loops.max(1.0) } else { bite }
    }

    /// Makes the loop with that bite, slower where the limit requires it.
    fn slowed(&self, simulation: &mut Simulation, bite: f64) -> Taken {
        let used = self.evened(bite);
        let made = self.run(simulation, used, Pace::Limited);
        Taken { next_bite: bite, used, begin: self.next_begin(&made).or(Some(0.0)) }
    }

    /// Somewhat before this cut began.
    fn next_begin(&self, made: &Made) -> Option<f64> {
        made.first.map(|first| (first - LEAD_IN).max(0.0))
    }

    /// Makes the loop: a straight way through the air, and the arc that cuts.
    fn run(&self, simulation: &mut Simulation, used: f64, pace: Pace) -> Made {
        let next = self.guide.station(self.from + used);
        let heading = self.guide.heading(self.from + 0.5 * used);
        let mark = simulation.points().len();
        let scale = simulation.cutting.radius / simulation.disc(self.here.center);
        let sides = sides_of_loop(self.here.radius.max(next.radius) * scale, self.loops.tolerance);
        let at = |t: f64| {
            let angle = PI + self.loops.hand * TAU * t;
            let radius = self.here.radius + (next.radius - self.here.radius) * t;
            let center = self.here.center.lerp(next.center, t);
            let arm = heading * math::cos(angle) + heading.perp() * math::sin(angle);
            (center, arm * radius)
        };
        let place = |simulation: &Simulation, t: f64| {
            let (center, arm) = at(t);
            drawn_in(simulation, center, arm)
        };
        let clear = [self.begin, 0.5 * self.begin, 0.0]
            .into_iter()
            .find(|&t| is_clear_way(simulation, place(simulation, t)));
        let begin = clear.unwrap_or(0.0);
        let to = place(simulation, begin);
        if clear.is_none() {
            self.guide.go(simulation, (self.left, self.from), self.here.center);
        }
        // A leaning axis would swing round with every loop.
        simulation.face(Some(heading));
        pace.go(simulation, to);
        let reached = simulation.points()[mark..].iter().map(|p| p.mrr);
        let mut peak = reached.fold(0.0, f64::max);
        let mut first = (peak > 0.0).then_some(begin);
        let mut last = begin;
        let steps = ((1.0 - begin) * sides as f64).ceil() as usize;
        for i in 1..=steps {
            let t = begin + (1.0 - begin) * i as f64 / steps as f64;
            let made = simulation.points().len();
            let (center, _) = at(t);
            let to = place(simulation, t);
            if !simulation.terrain.joins(simulation.at(), to) {
                // Around a corner of the boundary that pokes into the loop.
                pace.go(simulation, center);
            }
            pace.go(simulation, to);
            let rate = simulation.points()[made..].iter().map(|p| p.mrr).fold(0.0, f64::max);
            peak = peak.max(rate);
            let is_thin = self.is_run_again && t > 0.5 && rate < THIN * peak;
            if rate > 0.0 {
                first.get_or_insert(last);
            }
            if is_thin && self.is_falling(simulation, t, sides, &place) {
                break;
            }
            if rate > 0.0 {
                last = t;
                continue;
            }
            if first.is_some() && t > 0.5 && self.is_done(simulation, t, sides, &place) {
                break;
            }
            last = t;
        }
        simulation.face(None);
        simulation.hurry_idle(mark, self.loops.return_feed);
        Made { peak, first }
    }

    /// Whether the rest of the loop, from `t` turns on, cuts nothing.
    fn is_done(&self, simulation: &Simulation, t: f64, sides: usize, place: Place) -> bool {
        self.rest(simulation, t, sides, place).all(|rate| rate < IDLE)
    }

    /// Whether the cut of the rest of the loop, from `t` turns on, only falls.
    fn is_falling(&self, simulation: &Simulation, t: f64, sides: usize, place: Place) -> bool {
        let rates: Vec<f64> = self.rest(simulation, t, sides, place).collect();
        rates.windows(2).all(|w| w[1] <= w[0] + FALLING)
    }

    /// Engagement of the rest of a loop, if none of it is made.
    fn rest<'a>(
        &self,
        simulation: &'a Simulation,
        t: f64,
        sides: usize,
        place: Place<'a>,
    ) -> impl Iterator<Item = f64> + 'a {
        let steps = ((1.0 - t) * sides as f64).ceil().max(1.0) as usize;
        let mut before = simulation.at();
        (1..=steps).map(move |i| {
            let here = place(simulation, t + (1.0 - t) * i as f64 / steps as f64);
            let way = (here - before).normalize_or_zero();
            before = here;
            simulation.engagement(here, way).normal_feed
        })
    }
}

/// The place on a loop after a part of a turn.
type Place<'a> = &'a dyn Fn(&Simulation, f64) -> DVec2;

/// The bite to try after one whose peak is too high: on the line through this and the previous try, or in proportion.
fn smaller_bite((bite, peak): (f64, f64), earlier: Option<(f64, f64)>) -> f64 {
    let guess = match earlier {
        Some((b, p)) if p > peak && b > bite => bite - (peak - AIM_PEAK) * (b - bite) / (p - peak),
        _ => bite * AIM_PEAK / peak,
    };
    guess.clamp(0.3 * bite, 0.95 * bite)
}

/// Number of sides of a loop: its chords lie on the surface whatever their number, so `tolerance` only has to keep
/// the machine from slowing at corners; with fewer the engagement jumps at every corner.
fn sides_of_loop(radius: f64, tolerance: f64) -> usize {
    let half = math::acos_clamped(1.0 - tolerance / radius.max(tolerance));
    ((PI / half).ceil() as usize).clamp(20, 24)
}

/// Cuts down from above the stock by a helix about `center`, arriving at its start `back`.
///
/// The removal rate of a steady helix of a disc is its plan area times the pitch over the time of
/// a turn, so the pitch follows from the limit.
pub fn enter(simulation: &mut Simulation, back: DVec2, center: DVec2, loops: &Loops) {
    let arm = back - center;
    let radius = arm.length();
    let disc = simulation.disc(center);
    let scale = simulation.cutting.radius / disc;
    let turn = TAU * radius * scale / simulation.cutting.feed;
    let plan = PI * (radius + disc) * (radius + disc) * scale * scale;
    let limit = simulation
        .cutting
        .limit
        .min(2.0 * simulation.cutting.radius * simulation.cutting.depth * simulation.cutting.feed);
    let volume = simulation.cutting.depth * plan;
    let turns = (volume / (0.95 * limit * turn)).ceil().clamp(1.0, MOST_TURNS);
    let slower = (0.95 * limit * turn * turns / volume).min(1.0);
    let sides = sides_of_loop(radius * scale, loops.tolerance);
    let steps = turns as usize * sides;
    simulation.arrive(back, simulation.cutting.depth, MoveKind::Link);
    let mrr = slower * volume / (turns * turn);
    for i in 1..=steps + sides {
        let angle = loops.hand * TAU * (i % sides) as f64 / sides as f64;
        let (c, s) = (math::cos(angle), math::sin(angle));
        let height = simulation.cutting.depth * (1.0 - i as f64 / steps as f64).max(0.0);
        let to = drawn_in(simulation, center, arm * c + arm.perp() * s);
        simulation.descend(to, height, mrr, slower * simulation.cutting.feed);
    }
}

#[cfg(test)]
mod tests;
