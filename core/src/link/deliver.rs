//! Flat path → the delivered [`Toolpath`]: mapped onto the surface, located, joined by retracts and approaches.

use crate::cutter_location::{
    LiftedSpan, LocateError, Located, LocatedPass, Obstacles, PassOptions, Standing, ToolAxis,
    locate_pass, tool_axes,
};
use crate::flat_path::FlatPoint;
use crate::flatten::OutsideChart;
use crate::geometry::{DVec2, DVec3, math};
use crate::lift::{Lift, Lifted};
use crate::parallel;
use crate::toolpath::{MoveKind, PathPoint, Toolpath};
use core::f64::consts::FRAC_PI_2;
use core::ops::Range;
use thiserror::Error;

/// Contacts located in one piece. Larger: less to share between threads; smaller: more points kept
/// at the joints.
const PIECE: usize = 2048;
/// Runs that are located together. More: less waiting for each other; fewer: less memory.
const BATCH: usize = 256;
/// Largest turn between two points of a rapid, rad.
const RAPID_TURN: f64 = 0.1;
/// Radii of an arc that are tried, each half of the one before.
const HALVINGS: u32 = 4;
/// Most points of an arc.
const MOST_ON_ARC: f64 = 90.0;

/// Why a flat path cannot be delivered.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum DeliverError {
    /// A point lies outside of the chart.
    #[error("lift: {0}")]
    Outside(#[from] OutsideChart),
    /// The cutter cannot be located.
    #[error(transparent)]
    Locate(#[from] LocateError),
}

/// How passes are located and joined.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct DeliverOptions {
    /// Locating.
    pub pass: PassOptions,
    /// Distance along the axis from the origin at and above which rapids run, mm: clear of part and
    /// stock, in any position of the tables.
    pub rapid_plane: f64,
    /// Where the cutter would have to be lifted by more than this, mm, it retracts instead if that is quicker.
    pub highest_raise: f64,
    /// Radius of the arcs on which the cutter comes to passes and leaves them, mm, where that touches nothing; 0 for none.
    pub entry_radius: f64,
    /// Number of threads; the path does not depend on it.
    pub threads: usize,
    /// Distance from the part, mm, from which on approaches are slow: clear of stock; infinite where stock may stand
    /// anywhere.
    pub slow_below: f64,
    /// Feed of approaches nearer to the part than that, mm/s.
    pub air_feed: f64,
    /// Speed of rapids, and feed of retracts and of approaches down to where they are slow, mm/s.
    pub rapid_feed: f64,
}

/// The delivered path and where the cutter had to be lifted.
#[derive(Clone, Debug, Default)]
pub struct Delivered {
    /// The path.
    pub toolpath: Toolpath,
    /// Where its points are on the surface; `None` for those away from it.
    pub places: Vec<Option<OnSurface>>,
    /// Stretches where the cutter does not fit.
    pub lifted: Vec<LiftedSpan>,
}

/// A place of a path on the surface.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct OnSurface {
    /// Flat image of the contact, flat mm.
    pub flat: DVec2,
    /// Unit flat direction in which the cutter faces; zero where it only arrives.
    pub facing: DVec2,
    /// Whether the cutter stands as this contact requires, not off a wall or between two contacts.
    pub is_exact: bool,
}

/// Maps flat paths onto the surface, locates the cutter along them and joins them.
#[derive(Copy, Clone)]
pub struct Deliverer<'a> {
    /// Onto the surface.
    pub lift: &'a Lift<'a>,
    /// What the cutter must not penetrate.
    pub obstacles: &'a Obstacles,
    /// How passes are located and joined.
    pub options: DeliverOptions,
}

impl Deliverer<'_> {
    /// A whole path. `after`: where an earlier path ended, if this one continues from there; it is the first point of
    /// the result. `progress` is called with the fraction done.
    ///
    /// # Errors
    /// [`DeliverError`] when a point cannot be mapped or the cutter cannot be located there.
    pub fn path(
        &self,
        flat: &[FlatPoint],
        after: Option<PathPoint>,
        mut progress: impl FnMut(f64),
    ) -> Result<Delivered, DeliverError> {
        let Self { lift, obstacles, ref options } = *self;
        let mut out = Delivered::default();
        out.push_all(after.map(|point| (point, None)));
        for batch in runs(flat).chunks(BATCH) {
            let mapped = parallel::map(options.threads, batch, |run| {
                lift.run(&flat[run.clone()], run.start)
            });
            let mapped = mapped.into_iter().collect::<Result<Vec<_>, _>>()?;
            let located = locate(&mapped, obstacles, options)?;
            for (mapped, LocatedPass { points, lifted }) in mapped.iter().zip(located) {
                out.lifted.extend(lifted);
                Run { flat, mapped, located: &points, obstacles, options }.append(&mut out);
            }
            progress(batch.last().map_or(1.0, |run| run.end as f64 / flat.len() as f64));
        }
        Ok(out)
    }

    /// A path on the surface all the way, from its first point, where the tool axis is `start`, and back to it; `None` where the cutter would have to retract, or
    /// cannot be located at all.
    pub fn on_surface(&self, flat: &[FlatPoint], start: DVec3) -> Option<Delivered> {
        let Self { lift, obstacles, ref options } = *self;
        let mapped = lift.run(flat, 0).ok()?;
        let axes = tool_axes(&mapped.contacts, Some(start), &options.pass, obstacles);
        let LocatedPass { points, lifted } =
            locate_pass(&mapped.contacts, &axes, &options.pass, obstacles).ok()?;
        if points.iter().any(|l| l.raise > options.highest_raise) {
            return None;
        }
        let run = Run { flat, mapped: &mapped, located: &points, obstacles, options };
        let mut out = Delivered { lifted, ..Delivered::default() };
        out.push_all(points.iter().map(|l| run.point(l)));
        Some(out)
    }
}

impl Delivered {
    /// Appends a point and where it is on the surface.
    pub fn push(&mut self, point: PathPoint, place: Option<OnSurface>) {
        self.toolpath.points.push(point);
        self.places.push(place);
    }

    fn push_all(&mut self, points: impl IntoIterator<Item = (PathPoint, Option<OnSurface>)>) {
        points.into_iter().for_each(|(point, place)| self.push(point, place));
    }
}

/// The points between rapids, the rapid first.
fn runs(flat: &[FlatPoint]) -> Vec<Range<usize>> {
    let is_start = |i: &usize| *i == 0 || flat[*i].kind == MoveKind::Rapid;
    let starts: Vec<usize> = (0..flat.len()).filter(is_start).chain([flat.len()]).collect();
    starts.windows(2).map(|w| w[0]..w[1]).collect()
}

/// Locates runs in pieces that share their end points, on all threads.
fn locate(
    runs: &[Lifted],
    obstacles: &Obstacles,
    options: &DeliverOptions,
) -> Result<Vec<LocatedPass>, LocateError> {
    let pieces = |(k, Lifted { contacts, .. }): (usize, &Lifted)| {
        let (count, last) = (contacts.len(), contacts.len().saturating_sub(1));
        let starts = (0..last.max(1)).step_by(PIECE);
        starts.map(move |from| (k, from..(from + PIECE + 1).min(count)))
    };
    let pieces: Vec<(usize, Range<usize>)> = runs.iter().enumerate().flat_map(pieces).collect();
    let axes = parallel::map(options.threads, runs, |run| {
        tool_axes(&run.contacts, None, &options.pass, obstacles)
    });
    let located = parallel::map(options.threads, &pieces, |(k, piece)| {
        let (contacts, axes) = (&runs[*k].contacts[piece.clone()], &axes[*k][piece.clone()]);
        locate_pass(contacts, axes, &options.pass, obstacles)
    });
    let mut all = vec![LocatedPass::default(); runs.len()];
    for ((k, _), piece) in pieces.into_iter().zip(located) {
        let piece = piece?;
        let shared = usize::from(!all[k].points.is_empty());
        all[k].points.extend(piece.points.into_iter().skip(shared));
        all[k].lifted.extend(piece.lifted);
    }
    Ok(all)
}

/// A way down to a piece, or up from it.
struct Arc {
    /// The located point that it touches.
    at: usize,
    /// Tips along it from its far end on, without that point; one at least.
    tips: Vec<DVec3>,
}

/// Moves between two retracts.
struct Run<'a> {
    flat: &'a [FlatPoint],
    mapped: &'a Lifted,
    located: &'a [Located],
    obstacles: &'a Obstacles,
    options: &'a DeliverOptions,
}

impl Run<'_> {
    /// Appends the run; where the cutter had to be lifted far out of the cut, and a retract takes less time, it retracts
    /// and continues behind that place. A single point between two such places is left out.
    fn append(&self, out: &mut Delivered) {
        let count = self.located.len();
        let fits = |i: &usize| self.located[*i].raise <= self.options.highest_raise;
        let misfits = |from: usize| (from..count).find(|i| !fits(i)).unwrap_or(count);
        let mut from = 0;
        while let Some(first) = (from..count).find(fits) {
            let mut end = misfits(first);
            while let Some(next) = (end..count).find(fits)
                && self.is_quicker_lifted(end - 1..next + 1)
            {
                end = misfits(next);
            }
            let is_point = end - first == 1 && first > 0 && end < count;
            if !is_point {
                self.append_piece(out, first..end);
            }
            from = end;
        }
    }

    /// Whether the cutter gets sooner from the first of these points to the last along them than by way of the rapid
    /// plane.
    fn is_quicker_lifted(&self, points: Range<usize>) -> bool {
        let points = &self.located[points];
        let (Some(first), Some(last)) = (points.first(), points.last()) else { return false };
        let options = self.options;
        let above = |l: &Located| options.above(l.tip, l.axis);
        let up_and_down = above(first).distance(first.tip) + above(last).distance(last.tip);
        let across = above(first).distance(above(last));
        let slow = options.slow_below.min(0.5 * up_and_down);
        let by_retract =
            slow / options.air_feed + (up_and_down - slow + across) / options.rapid_feed;
        let lifted: f64 = points.windows(2).map(|w| w[0].tip.distance(w[1].tip) / w[1].feed).sum();
        points.iter().all(|l| l.raise.is_finite()) && lifted <= by_retract
    }

    /// Appends a piece with its approach and its retract.
    ///
    /// Where other parts of the surface obstruct the approach, the cutter comes down at the first place of the piece
    /// with a free approach and goes back along the piece from there; it leaves from the last such place, back along
    /// what it has just cut. A piece without such a place is out of reach.
    fn append_piece(&self, out: &mut Delivered, piece: Range<usize>) {
        let mut indices = piece.clone();
        let is_open = |i: &usize| self.is_open(self.located[*i].tip, self.located[*i].axis);
        let Some(entry) = indices.clone().find(is_open) else {
            out.lifted.push(self.out_of_reach(piece));
            return;
        };
        let exit = indices.rfind(is_open).unwrap_or(entry);
        let into = if entry == piece.start { self.arc_into(&piece) } else { None };
        // What an arc begins or ends at, or the whole piece.
        let first = into.as_ref().map_or(piece.start, |arc| arc.at);
        let out_of = if exit + 1 == piece.end { self.arc_out_of(&piece) } else { None };
        let out_of = out_of.filter(|arc| arc.at > first);
        let end = out_of.as_ref().map_or(piece.end, |arc| arc.at + 1);
        match &into {
            Some(arc) => self.come_down_on(out, arc),
            None => {
                let down = &self.located[entry];
                self.come_to(out, down.tip, down);
                let arrived = OnSurface { facing: DVec2::ZERO, ..self.place(down) };
                out.push_all([(self.link(down.tip, down), Some(arrived))]);
                out.push_all((piece.start..entry).rev().map(|i| self.back_to(i)));
            }
        }
        out.push_all(self.located[first + 1..end].iter().map(|l| self.point(l)));
        let up = match &out_of {
            Some(arc) => {
                let l = &self.located[arc.at];
                let on_arc = |tip: &DVec3| (PathPoint { feed: l.feed, ..self.link(*tip, l) }, None);
                out.push_all(arc.tips.iter().rev().map(on_arc));
                Located { tip: arc.tips[0], ..*l }
            }
            None => {
                out.push_all((exit..piece.end - 1).rev().map(|i| self.back_to(i)));
                self.located[exit]
            }
        };
        let above = self.link(self.options.above(up.tip, up.axis), &up);
        out.push_all([(PathPoint { feed: self.options.rapid_feed, ..above }, None)]);
    }

    /// From wherever the path ends to above a place at which the cutter is to come down, and down to where the approach is
    /// slow.
    fn come_to(&self, out: &mut Delivered, tip: DVec3, l: &Located) {
        let options = self.options;
        let above = options.above(tip, l.axis);
        rapid(&mut out.toolpath.points, options, self.source(l), above, l.axis);
        out.places.resize(out.toolpath.points.len(), None);
        if options.slow_below == f64::INFINITY {
            return;
        }
        let tool = options.pass.tool;
        let at = Standing { tool, tip, axis: l.axis, reach: f64::INFINITY };
        let height = self.obstacles.raise(at, options.slow_below);
        if height > 0.0 && height < above.distance(tip) {
            let slow = self.link(tip + l.axis * height, l);
            out.push_all([(PathPoint { feed: options.rapid_feed, ..slow }, None)]);
        }
    }

    /// Comes down on an arc, from wherever the path ends, to where it touches the surface.
    fn come_down_on(&self, out: &mut Delivered, arc: &Arc) {
        let down = &self.located[arc.at];
        let feed = self.located.get(arc.at + 1).unwrap_or(down).feed;
        self.come_to(out, arc.tips[0], down);
        out.push_all([(self.link(arc.tips[0], down), None)]);
        let on_arc = |tip: &DVec3| (PathPoint { feed, ..self.link(*tip, down) }, None);
        out.push_all(arc.tips[1..].iter().map(on_arc));
        let (arrived, place) = self.point(down);
        out.push_all([(PathPoint { kind: MoveKind::Link, feed, ..arrived }, place)]);
    }

    /// The arc on which a piece is entered; `None` where it is entered another way, by a helix or along what is above
    /// it, and where there is no room.
    fn arc_into(&self, piece: &Range<usize>) -> Option<Arc> {
        let source = |i: usize| self.mapped.points[self.located[i].keys.1].source;
        let first = source(piece.start);
        let at = match self.flat[first].height > 0.0 {
            false => piece.start,
            // From over the surface straight down to it, and out to the end of its overrun.
            true => {
                let touch = self.flat.get(first + 1).filter(|touch| touch.height == 0.0)?;
                let down = piece.clone().take_while(|&i| source(i) <= first + 1);
                self.farthest(down.filter(|&i| source(i) > first), touch.overrun)?
            }
        };
        self.arc(at, at + 1..piece.end)
    }

    /// The arc on which a piece is left, from the end of its overrun.
    fn arc_out_of(&self, piece: &Range<usize>) -> Option<Arc> {
        let source = |i: usize| self.mapped.points[self.located[i].keys.1].source;
        let last = source(piece.end - 1);
        // An overrun has the flat place of its end.
        let uv = |i: usize| self.mapped.points[self.located[i].keys.1].uv;
        let is_end = |i: &usize| source(*i) == last && uv(*i) == self.flat[last].at;
        let end = piece.clone().rev().take_while(is_end);
        let at = self.farthest(end, self.flat[last].overrun)?;
        self.arc(at, (piece.start..at).rev())
    }

    /// Of located points of a flat one, in either order from the surface on, that which is farthest out on its overrun.
    fn farthest(&self, points: impl Iterator<Item = usize>, overrun: f64) -> Option<usize> {
        let points: Vec<usize> = points.collect();
        let touch = points.iter().copied().max_by_key(|&i| self.located[i].keys.1)?;
        if overrun == 0.0 {
            return Some(touch);
        }
        let end = &self.located[touch];
        let out =
            |i: usize| (self.located[i].contact - end.contact).reject_from(end.normal).length();
        points.into_iter().max_by(|&a, &b| out(a).total_cmp(&out(b)))
    }

    /// A quarter of a circle that touches a piece at the point `at`, in the plane of the tool axis and of the way to the
    /// points `onward` from there. Its radius is that of the options, but no more than the height up to the rapid plane,
    /// or a half, quarter, eighth of it, whichever is clear first.
    fn arc(&self, at: usize, mut onward: impl Iterator<Item = usize>) -> Option<Arc> {
        let (end, options) = (&self.located[at], self.options);
        let height = (options.rapid_plane - end.tip.dot(end.axis)).max(0.0);
        let largest = options.entry_radius.min(height);
        let way = |i: usize| self.located[i].tip - end.tip;
        // Points at one place have no direction.
        let is_away = |i: &usize| way(*i).length() > options.pass.tolerance;
        let ahead = way(onward.find(is_away).filter(|_| largest > 0.0)?).normalize_or_zero();
        let up = (end.axis - ahead * end.axis.dot(ahead)).try_normalize()?;
        let tips = |radius: f64| {
            let step = (8.0 * options.pass.tolerance / radius).sqrt();
            let count = (FRAC_PI_2 / step).ceil().clamp(2.0, MOST_ON_ARC) as u32;
            let tip = move |k: u32| {
                let turn = FRAC_PI_2 * f64::from(k) / f64::from(count);
                let (sine, cosine) = (math::sin(turn), math::cos(turn));
                end.tip + radius * (up * (1.0 - cosine) - ahead * sine)
            };
            (1..=count).rev().map(tip).collect::<Vec<DVec3>>()
        };
        let is_open = |tip: &DVec3| self.is_open(*tip, end.axis);
        let mut radii = (0..HALVINGS).map(|k| largest / f64::from(1u32 << k));
        let tips = radii.find_map(|r| Some(tips(r)).filter(|tips| tips.iter().all(is_open)))?;
        Some(Arc { at, tips })
    }

    /// Whether the part leaves the line along the axis free from here to the rapid plane.
    fn is_open(&self, tip: DVec3, axis: DVec3) -> bool {
        let PassOptions { tool, allowance, tolerance, .. } = self.options.pass;
        let at = Standing { tool, tip, axis, reach: f64::INFINITY };
        let height = (self.options.rapid_plane - tip.dot(axis)).max(0.0);
        let is_above_clear =
            || self.obstacles.above().is_none_or(|a| a.is_way_out_clear(tip, axis, height));
        self.obstacles.is_clear(at, allowance, tolerance) && is_above_clear()
    }

    /// A piece that cannot be entered, as a stretch from which the cutter is kept away.
    fn out_of_reach(&self, piece: Range<usize>) -> LiftedSpan {
        let piece = &self.located[piece];
        let (first, last) = (&piece[0], &piece[piece.len() - 1]);
        let length = piece.windows(2).map(|w| w[0].contact.distance(w[1].contact)).sum();
        let raise = self.options.rapid_plane - first.tip.dot(first.axis);
        let place = first.contact;
        LiftedSpan { from: place, to: last.contact, length, raise: raise.max(first.raise), place }
    }

    /// The flat point of a located one, or the one toward which it moves.
    fn source(&self, l: &Located) -> &FlatPoint {
        &self.flat[self.mapped.points[l.keys.1].source]
    }

    /// A straight move through air.
    fn link(&self, tip: DVec3, l: &Located) -> PathPoint {
        PathPoint {
            kind: MoveKind::Link,
            pass: self.source(l).pass,
            region: self.source(l).region,
            tip,
            axis: l.axis,
            normal: l.axis,
            flat: None,
            feed: self.options.air_feed,
            mrr: 0.0,
            alpha: 0.0,
            time: 0.0,
        }
    }

    /// A move back to a located point from the one behind it; it may cut material.
    fn back_to(&self, index: usize) -> (PathPoint, Option<OnSurface>) {
        let (point, place) = self.point(&self.located[index]);
        (PathPoint { kind: MoveKind::Link, ..point }, place)
    }

    /// Where a located point is on the surface.
    fn place(&self, l: &Located) -> OnSurface {
        let source = self.mapped.points[l.keys.1].source;
        let way = || self.flat[source].at - self.flat[source.saturating_sub(1)].at;
        let facing = self.flat[source].heading.unwrap_or_else(way).normalize_or_zero();
        OnSurface { flat: self.mapped.points[l.keys.1].uv, facing, is_exact: l.is_of_contact }
    }

    /// A located point with the largest removal rate of the moves it covers.
    fn point(&self, l: &Located) -> (PathPoint, Option<OnSurface>) {
        let sources = (self.mapped.points[l.keys.0].source, self.mapped.points[l.keys.1].source);
        let covered = &self.flat[sources.0..=sources.1];
        let worst = covered
            .iter()
            .fold(&self.flat[sources.1], |worst, p| if p.mrr > worst.mrr { p } else { worst });
        let end = &self.flat[sources.1];
        let place = self.place(l);
        let point = PathPoint {
            kind: end.kind,
            pass: end.pass,
            region: end.region,
            tip: l.tip,
            axis: l.axis,
            normal: l.normal,
            flat: Some(place.flat),
            feed: l.feed,
            mrr: worst.mrr,
            alpha: 0.0,
            time: 0.0,
        };
        (point, Some(place))
    }
}

impl DeliverOptions {
    /// The place on the rapid plane, along the axis from `tip` if that lies below it.
    fn above(&self, tip: DVec3, axis: DVec3) -> DVec3 {
        tip + axis * (self.rapid_plane - tip.dot(axis)).max(0.0)
    }
}

/// Rapid on the rapid plane from where the path ends to `to`, in steps if the axis turns.
fn rapid(
    points: &mut Vec<PathPoint>,
    options: &DeliverOptions,
    next: &FlatPoint,
    to: DVec3,
    axis: DVec3,
) {
    let last = points.last().copied();
    let mut push = |tip: DVec3, axis: DVec3| {
        points.push(PathPoint {
            kind: MoveKind::Rapid,
            pass: next.pass,
            region: next.region,
            tip,
            axis,
            normal: axis,
            flat: None,
            feed: options.rapid_feed,
            mrr: 0.0,
            alpha: 0.0,
            time: 0.0,
        });
    };
    let Some(last) = last else { return push(to, axis) };
    if matches!(options.pass.axis, ToolAxis::Fixed(_)) {
        return push(to, axis);
    }
    for (tip, axis) in rapid_steps(Some((last.tip, last.axis)), (to, axis), options.rapid_plane) {
        push(tip, axis);
    }
}

/// Tips and axes of a rapid on the rapid plane in steps, if the axis turns, its start not among them; with no start, its
/// end alone.
pub fn rapid_steps(
    from: Option<(DVec3, DVec3)>,
    (to, axis): (DVec3, DVec3),
    rapid_plane: f64,
) -> Vec<(DVec3, DVec3)> {
    let Some((start, first)) = from else { return vec![(to, axis)] };
    let steps = (angle(first, axis) / RAPID_TURN).ceil().max(1.0) as usize;
    let step = |i: usize| {
        let t = i as f64 / steps as f64;
        let between = turned(first, axis, t);
        let level = start.lerp(to, t);
        (level + between * (rapid_plane - level.dot(between)), between)
    };
    (1..steps).map(step).chain([(to, axis)]).collect()
}

fn angle(a: DVec3, b: DVec3) -> f64 {
    math::atan2(a.cross(b).length(), a.dot(b))
}

/// The unit direction a part `t` of the way from `a` to `b` along the great circle.
fn turned(a: DVec3, b: DVec3, t: f64) -> DVec3 {
    let (a, b) = (a.normalize_or_zero(), b.normalize_or_zero());
    let whole = angle(a, b);
    let side = (b - a * a.dot(b)).normalize_or_zero();
    let side = if side == DVec3::ZERO { crate::geometry::any_perpendicular(a) } else { side };
    a * math::cos(whole * t) + side * math::sin(whole * t)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cutter_location::CheckMesh;
    use crate::lift::LiftedPoint;
    use crate::tool::Tool;

    const ROOF: f64 = 20.0;

    /// Roofs over the plane z = 0 from one x to another.
    fn roofs(spans: &[[f64; 2]]) -> Obstacles {
        let corners = |s: &[f64; 2]| {
            [(s[0], -9.0), (s[1], -9.0), (s[1], 9.0), (s[0], 9.0)]
                .map(|(x, y)| DVec3::new(x, y, ROOF))
        };
        let faces = (0..spans.len() as u32)
            .flat_map(|i| [[4 * i, 4 * i + 1, 4 * i + 2], [4 * i, 4 * i + 2, 4 * i + 3]])
            .collect();
        Obstacles::of_part(CheckMesh::new(spans.iter().flat_map(corners).collect(), faces))
    }

    /// A pass from x = 0 to 30 on the plane, cut by a ball of radius 3 with 10 mm of length.
    fn delivered(spans: &[[f64; 2]]) -> Delivered {
        delivered_lifted(spans, |_| 0.0)
    }

    /// The same pass, entered and left on arcs.
    fn delivered_on_arcs(spans: &[[f64; 2]], entry_radius: f64) -> Delivered {
        delivered_with(spans, |_| 0.0, entry_radius, 1.0)
    }

    /// The same pass, lifted over places of it.
    fn delivered_lifted(spans: &[[f64; 2]], raise: impl Fn(u32) -> f64) -> Delivered {
        delivered_with(spans, raise, 0.0, 1.0)
    }

    fn delivered_with(
        spans: &[[f64; 2]],
        raise: impl Fn(u32) -> f64,
        entry_radius: f64,
        slow_below: f64,
    ) -> Delivered {
        let located: Vec<Located> = (0..=30)
            .map(|i| {
                let raise = raise(i);
                let contact = DVec3::new(f64::from(i), 0.0, 0.0);
                let tip = contact + DVec3::Z * if raise.is_finite() { raise } else { 0.0 };
                let keys = (i as usize, i as usize);
                let (axis, normal) = (DVec3::Z, DVec3::Z);
                Located { tip, axis, contact, normal, feed: 10.0, raise, is_of_contact: true, keys }
            })
            .collect();
        let flat: Vec<FlatPoint> = located
            .iter()
            .map(|l| FlatPoint {
                at: l.tip.truncate(),
                height: 0.0,
                kind: MoveKind::Cut,
                pass: 0,
                region: 0,
                feed: l.feed,
                mrr: 0.0,
                alpha: 0.0,
                length: 1.0,
                heading: None,
                overrun: 0.0,
            })
            .collect();
        let point = |source| LiftedPoint { uv: DVec2::new(source as f64, 0.0), source };
        let points = (0..flat.len()).map(point).collect();
        let mapped = Lifted { contacts: Vec::new(), points };
        let options = DeliverOptions {
            pass: PassOptions {
                tool: Tool::new(3.0, 3.0).unwrap(),
                axis: ToolAxis::Fixed(DVec3::Z),
                axis_rate: f64::INFINITY,
                largest_tilt: 0.0,
                allowance: 0.0,
                tolerance: 0.01,
                reach: 10.0,
            },
            rapid_plane: 50.0,
            highest_raise: 3.0,
            entry_radius,
            threads: 1,
            slow_below,
            air_feed: 20.0,
            rapid_feed: 100.0,
        };
        let check = roofs(spans);
        let (located, obstacles) = (&located[..], &check);
        let mut out = Delivered::default();
        Run { flat: &flat, mapped: &mapped, located, obstacles, options: &options }
            .append(&mut out);
        out
    }

    #[test]
    fn an_open_pass_is_entered_and_left_at_its_ends() {
        let points = delivered(&[]).toolpath.points;
        assert_eq!(points.len(), 1 + 1 + 30 + 1);
        assert_eq!((points[0].tip.x, points[32].tip.x), (0.0, 30.0));
    }

    #[test]
    fn the_cutter_comes_and_goes_beside_roofs() {
        let out = delivered(&[[-5.0, 7.5], [20.5, 40.0]]);
        let points = out.toolpath.points;
        // The roof's edge lies within the radius of all places before 11 and after 17.
        assert_eq!((points[0].tip.x, points[1].tip.x), (11.0, 11.0));
        assert_eq!(points.last().map(|p| p.tip), Some(DVec3::new(17.0, 0.0, 50.0)));
        let reached = |x: f64| points.iter().any(|p| p.tip == DVec3::new(x, 0.0, 0.0));
        assert!((0..=30).all(|x| reached(f64::from(x))));
        let straight = |w: &[PathPoint]| w[0].tip.z > 0.0 || w[0].tip.distance(w[1].tip) < 1.5;
        assert!(points[1..points.len() - 1].windows(2).all(straight));
        assert!(out.lifted.is_empty());
    }

    /// From the pass at 0 to the rapid plane at 50 and back, at 100 mm/s, and at 20 mm/s for the last mm, takes 1.04 s: at
    /// 10 mm/s a way of 10.4 mm.
    #[test]
    fn the_cutter_retracts_where_that_is_quicker_than_being_lifted() {
        let rapids = |out: &Delivered| {
            out.toolpath.points.iter().filter(|p| p.kind == MoveKind::Rapid).count()
        };
        let over = |height: f64| move |i: u32| if (12..=14).contains(&i) { height } else { 0.0 };
        assert_eq!(rapids(&delivered_lifted(&[], over(3.5))), 1);
        assert_eq!(rapids(&delivered_lifted(&[], over(5.0))), 2);
        assert_eq!(rapids(&delivered_lifted(&[], over(f64::INFINITY))), 2);
    }

    /// A ball of radius 3 passes the edge of a roof at half a millimetre: within the distance of 1 mm below which it is
    /// slow, from where the ball of radius 4 leaves the edge.
    #[test]
    fn approaches_are_slow_near_the_part_alone() {
        let points = delivered(&[[-9.0, -3.5]]).toolpath.points;
        let height = ROOF + (16.0f64 - 3.5 * 3.5).sqrt() - 3.0;
        assert!(points[1].tip.distance(DVec3::new(0.0, 0.0, height)) < 1e-5);
        let feeds: Vec<f64> = points.iter().map(|p| p.feed).collect();
        assert_eq!((&feeds[..4], feeds.last()), (&[100.0, 100.0, 20.0, 10.0][..], Some(&100.0)));
        // All the way down where stock may stand beside the part.
        let points = delivered_with(&[[-9.0, -3.5]], |_| 0.0, 0.0, f64::INFINITY).toolpath.points;
        let feeds: Vec<f64> = points.iter().map(|p| p.feed).collect();
        assert_eq!((&feeds[..3], feeds.last()), (&[100.0, 20.0, 10.0][..], Some(&100.0)));
    }

    #[test]
    fn a_pass_is_entered_and_left_on_arcs() {
        let points = delivered_on_arcs(&[], 4.0).toolpath.points;
        assert!(points[1].tip.distance(DVec3::new(-4.0, 0.0, 4.0)) < 1e-9);
        let cut = points.iter().position(|p| p.kind == MoveKind::Cut).unwrap();
        for p in &points[1..cut] {
            assert!((DVec3::new(0.0, 0.0, 4.0).distance(p.tip) - 4.0).abs() < 1e-12);
        }
        // The chords are off the circle by the tolerance at most, and so is the last of them off the pass by an angle.
        let chord = points[cut - 1].tip - points[cut - 2].tip;
        assert!(chord.z < 0.0 && -chord.z / chord.x < 2.0 * (2.0 * 0.01f64 / 4.0).sqrt());
        // Down at the feed of air, on the arc at that of the cut.
        assert!(points[1].feed == 20.0 && points[2..cut].iter().all(|p| p.feed == 10.0));
        let mirrored: Vec<DVec3> = points.iter().rev().map(|p| p.tip).collect();
        for (p, q) in points.iter().zip(mirrored) {
            assert!(p.tip.distance(DVec3::new(30.0 - q.x, q.y, q.z)) < 1e-9);
        }
    }

    /// Beside a roof that ends at x = -4.5 a ball of radius 3 has room for an arc of 1 mm, not of 2.
    #[test]
    fn an_arc_is_smaller_where_something_is_in_the_way() {
        let first = |spans: &[[f64; 2]]| {
            let points = delivered_on_arcs(spans, 4.0).toolpath.points;
            points.into_iter().find(|p| p.feed == 20.0).unwrap().tip
        };
        assert!(first(&[[-9.0, -4.5]]).distance(DVec3::new(-1.0, 0.0, 1.0)) < 1e-9);
        assert_eq!(first(&[[-9.0, -3.2]]), DVec3::ZERO);
    }

    #[test]
    fn a_pass_under_a_roof_is_out_of_reach() {
        let out = delivered(&[[-9.0, 40.0]]);
        assert!(out.toolpath.points.is_empty());
        assert_eq!(out.lifted.len(), 1);
        assert_eq!((out.lifted[0].length, out.lifted[0].raise), (30.0, 50.0));
    }
}
