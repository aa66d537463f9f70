//! The cutter's body against a straight column of material.
//!
//! Terms. The *core* is the flat bottom disc of radius `b = R - r_c` at height `r_c` above the tip and everything
//! straight above it; the body is everything within `r_c` of the core. A *column* stands on the surface along its
//! normal, from the allowance up to allowance plus depth. The body is convex, so it meets a column's line in one
//! interval: the column is cut down to where that begins. Material that overhangs the end of a column counts as
//! removed as well, but only by its length: the height of a column is the amount left.
//!
//! A wall of the cutter parallel to the columns would cut each down at once, and a rate summed over columns would
//! jump with them. Such a wall is therefore smeared over the width of a column: it takes the fraction of the column
//! that it covers. A wall passes gradually over an inclined column, which is cut without smearing.

use crate::geometry::DVec3;
use crate::geometry::disc::{self, Disc};
use crate::tool::Tool;

/// A column that leans by less than this fraction of its width counts as upright: a wall is smeared over it.
const UPRIGHT: f64 = 0.3;
/// A cosine to the axis below this is a right angle.
const FLAT: f64 = 1e-9;
/// A squared sine below this counts as zero.
const PARALLEL: f64 = 1e-18;
/// Newton steps to the rounded corner; convergence is quadratic and from below.
const STEPS: usize = 10;
/// Accuracy to which the corner is found, mm.
const MET: f64 = 2e-5;
/// Steps to the lowest height in a move.
const ROUNDS: usize = 6;
/// A height this close to the lowest is the lowest, mm.
const CLOSE: f64 = 1e-4;
/// In a move a column is cut to no more than this fraction of its length below its height at the end of the move:
/// steeper sides have passed it before.
const STEEP: f64 = 0.25;

/// Tip and unit axis of the cutter.
#[derive(Copy, Clone, Debug, PartialEq)]
pub(super) struct Pose {
    pub tip: DVec3,
    pub axis: DVec3,
}

impl Pose {
    /// The pose at a fraction `t` toward another, tip and axis linear as in the move.
    pub fn toward(&self, other: &Self, t: f64) -> Self {
        let axis = self.axis + (other.axis - self.axis) * t;
        Self { tip: self.tip.lerp(other.tip, t), axis: axis.normalize_or(self.axis) }
    }
}

/// A straight move of the cutter.
#[derive(Copy, Clone, Debug)]
pub(super) struct Stroke {
    pub from: Pose,
    pub to: Pose,
    /// Change of the tip, mm.
    travel: DVec3,
    /// Its length, mm.
    length: f64,
    /// Change of the axis; none for most cutters.
    turn: Option<DVec3>,
}

impl Stroke {
    /// From pose to pose.
    pub fn new(from: Pose, to: Pose) -> Self {
        let (travel, turn) = (to.tip - from.tip, to.axis - from.axis);
        let turn = (turn != DVec3::ZERO).then_some(turn);
        Self { from, to, travel, length: travel.length(), turn }
    }
}

/// Where columns stand: on `foot` along the unit `normal`.
#[derive(Copy, Clone, Debug)]
pub(crate) struct Line {
    pub foot: DVec3,
    pub normal: DVec3,
}

/// The layer that is cut, heights above the surface, mm.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Layer {
    /// Allowance below it.
    pub allowance: f64,
    /// Axial depth `H`.
    pub depth: f64,
    /// Whether what stands above the cutter on a column falls with what is cut: so thick a layer, where earlier cutters
    /// bridged the part, reaches across to other slopes.
    pub falls: bool,
}

impl Layer {
    /// Its upper side.
    pub fn top(&self) -> f64 {
        self.allowance + self.depth
    }
}

/// The cutter, and how far up from its tip it cuts.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Cutter {
    /// Its shape.
    pub tool: Tool,
    /// Length, mm; may be infinite.
    pub length: f64,
}

/// The cutter and the layer it cuts.
#[derive(Copy, Clone, Debug)]
pub(super) struct Body {
    length: f64,
    radius: f64,
    corner: f64,
    bottom: f64,
    layer: Layer,
    /// Width over which walls are smeared, mm.
    smear: f64,
}

/// How far a column falls and how that changes along the move.
#[derive(Copy, Clone, Debug, PartialEq)]
struct Meeting {
    height: f64,
    /// Change of the height over the whole move, mm.
    slope: f64,
}

/// A column's line seen from the cutter: `rho²(h) = c + 2 b h + a h²`, `z(h) = z + cosine h`.
struct View {
    z: f64,
    cosine: f64,
    a: f64,
    b: f64,
    c: f64,
    /// From the tip to the foot.
    q: DVec3,
}

impl View {
    fn new(q: DVec3, z: f64, cosine: f64, line: &Line) -> Self {
        Self {
            z,
            cosine,
            a: 1.0 - cosine * cosine,
            b: q.dot(line.normal) - z * cosine,
            c: q.length_squared() - z * z,
            q,
        }
    }

    fn rho_squared(&self, h: f64) -> f64 {
        self.c + h * (2.0 * self.b + h * self.a)
    }

    /// Where the line is within `radius` of the axis.
    fn within(&self, radius: f64) -> Option<(f64, f64)> {
        let outside = self.c - radius * radius;
        if self.a < PARALLEL {
            return (outside <= 0.0).then_some((f64::NEG_INFINITY, f64::INFINITY));
        }
        let square = self.b * self.b - self.a * outside;
        if square < 0.0 {
            return None;
        }
        let root = square.sqrt();
        Some(((-self.b - root) / self.a, (root - self.b) / self.a))
    }

    /// Where the line comes above the plane across the axis at `level` over the tip.
    fn above(&self, level: f64) -> Option<f64> {
        if self.cosine > FLAT {
            Some((level - self.z) / self.cosine)
        } else {
            (self.z >= level).then_some(f64::NEG_INFINITY)
        }
    }
}

/// A place outside of the body.
struct Clear {
    /// Squared distance from the core, mm².
    square: f64,
    /// How fast the distance decreases, times the distance, over the whole move.
    approach: f64,
}

/// What is known of an entry before it is computed.
#[derive(Copy, Clone)]
struct Known {
    /// A height near it; infinite if none is known.
    near: f64,
    /// Above this height it does not matter.
    limit: f64,
}

/// Where a line enters the body, and the body's outward direction there.
struct Entry {
    height: f64,
    outward: DVec3,
}

impl Body {
    /// For a cutter, the layer and the width of columns, mm.
    pub fn new(Cutter { tool, length }: Cutter, layer: Layer, width: f64) -> Self {
        let (radius, corner) = (tool.radius(), tool.corner_radius());
        Self { length, radius, corner, bottom: radius - corner, layer, smear: width }
    }

    /// How far up from its tip it cuts, mm.
    pub fn length(&self) -> f64 {
        self.length
    }

    /// The layer.
    pub fn layer(&self) -> Layer {
        self.layer
    }

    /// Radius of everything that the body can remove, including the smear, mm.
    pub fn reach(&self) -> f64 {
        self.radius + 0.5 * self.smear
    }

    /// How far the body extends from the origin in the unit direction `d`, which points down from the cutter; beyond
    /// `length` above the tip it is ignored.
    pub fn support(&self, pose: &Pose, d: DVec3, length: f64) -> f64 {
        let up = d.dot(pose.axis);
        let across = (1.0 - up * up).max(0.0).sqrt();
        d.dot(pose.tip)
            + self.corner * (1.0 + up)
            + (self.bottom + 0.5 * self.smear) * across
            + up.max(0.0) * length
    }

    /// The larger of that distance at both ends of a stroke, and the distance at its end.
    pub fn supports(&self, stroke: &Stroke, d: DVec3, length: f64) -> [f64; 2] {
        let end = self.support(&stroke.to, d, length);
        let start = match stroke.turn {
            None => end - d.dot(stroke.travel),
            Some(_) => self.support(&stroke.from, d, length),
        };
        [end.max(start), end]
    }

    /// Unit direction from the core's nearest point to `place`; none inside of the core.
    pub fn direction_to(&self, pose: &Pose, place: DVec3) -> Option<DVec3> {
        self.gap(pose, place).try_normalize()
    }

    /// How far from a round body a point must be at the end of a move to be clear of it throughout, if it is clear at
    /// the start, mm; `None` where an edge or a wall is in the material.
    ///
    /// The distance from a body with radii of curvature of at least `r_c` is convex along the move, with a second
    /// derivative of at most `1/r_c`: `f(s) >= s f(1) - s (1 - s) way² / (2 r_c)`. A turn moves everything beside the
    /// tip.
    pub fn dip(&self, stroke: &Stroke) -> Option<f64> {
        if self.corner < self.layer.top() {
            return None;
        }
        let turn = stroke.turn.map_or(0.0, DVec3::length);
        let way = stroke.length + 2.0 * turn * self.radius;
        Some(way * way / (2.0 * self.corner))
    }

    /// Whether the top of a column stays outside a round body during a move at whose start it was outside.
    ///
    /// The distance is convex along the move: it stays positive if it still falls at the end, or already
    /// grows at the start, or between as long as the tangents at both ends do.
    fn stays_clear(&self, stroke: &Stroke, line: &Line, height: f64) -> bool {
        if self.corner < self.layer.top() {
            return false;
        }
        let top = line.foot + line.normal * height;
        let Some(end) = self.clear_of(&stroke.to, stroke, line, top) else { return false };
        if end.approach >= 0.0 {
            return true;
        }
        let Some(start) = self.clear_of(&stroke.from, stroke, line, top) else { return false };
        if start.approach <= 0.0 {
            return true;
        }
        // Distances fall by `fall` in a whole move, or grow by `rise`.
        let (start_way, end_way) = (start.square.sqrt(), end.square.sqrt());
        let (fall, rise) = (start.approach / start_way, -end.approach / end_way);
        let (from, to) = (start_way - self.corner, end_way - self.corner);
        to * fall + from * rise > fall * rise
    }

    /// Clearance of the top of a column from a round body: only if the column points away from it.
    #[inline]
    fn clear_of(&self, pose: &Pose, stroke: &Stroke, line: &Line, top: DVec3) -> Option<Clear> {
        let q = top - pose.tip;
        let z = q.dot(pose.axis);
        let rho = (q.length_squared() - z * z).max(0.0).sqrt();
        let (out, below) = ((rho - self.bottom).max(0.0), (z - self.corner).min(0.0));
        let square = out * out + below * below;
        let spread = if out > 0.0 { out / rho } else { 0.0 };
        // The gap to the core along a direction.
        let along = |v: DVec3| {
            let up = v.dot(pose.axis);
            below * up + spread * (q.dot(v) - z * up)
        };
        if square <= self.corner * self.corner || along(line.normal) >= 0.0 {
            return None;
        }
        let mut approach = along(stroke.travel);
        if let Some(turn) = stroke.turn {
            // The core's nearest point is this high and in this direction.
            let r = q - pose.axis * below - (q - pose.axis * z) * spread;
            approach += along(turn) * r.dot(pose.axis) - along(pose.axis) * turn.dot(r);
        }
        Some(Clear { square, approach })
    }

    /// From the core's nearest point to a place; zero inside of the core.
    fn gap(&self, pose: &Pose, place: DVec3) -> DVec3 {
        let q = place - pose.tip;
        let z = q.dot(pose.axis);
        let across = q - pose.axis * z;
        let rho = across.length();
        let below = pose.axis * (z - self.corner).min(0.0);
        if rho > self.bottom { below + across * (1.0 - self.bottom / rho) } else { below }
    }

    /// The height that a column of height `height` has after a move.
    ///
    /// `h(t)` is convex along a straight move, so its least is at an end or where its slope
    /// changes sign; the start was the end of the move before.
    pub fn lowered(&self, stroke: &Stroke, line: &Line, height: f64) -> f64 {
        if self.corner > 0.0 {
            return self.lowered_by_side(stroke, line, height);
        }
        let height = self.under_disc(stroke, line).map_or(height, |low| height.min(low));
        if self.smear > 0.0 { self.lowered_by_side(stroke, line, height) } else { height }
    }

    /// As above, without what the edge of a flat end leaves in between.
    fn lowered_by_side(&self, stroke: &Stroke, line: &Line, height: f64) -> f64 {
        if self.stays_clear(stroke, line, height) {
            return height;
        }
        let limit = height + STEEP * stroke.length;
        let known = Known { near: limit, limit };
        let Some(end) = self.meet(&stroke.to, stroke, line, known) else { return height };
        let height = height.min(end.height);
        if end.slope <= 0.0 || end.height - end.slope >= height {
            return height;
        }
        self.lowered_between(stroke, line, height, end)
    }

    /// Whether a wall is smeared over a column whose top is `lean` mm beside its foot, seen along the axis.
    fn is_upright(&self, lean: f64) -> bool {
        lean < UPRIGHT * self.smear
    }

    /// Lowest position of a flat end over a column during a move. Not only at the end of the move: on the side of a
    /// strip, and behind a sinking cutter, a column is lowest where the edge leaves it. An upright column counts only
    /// where its whole width is covered.
    fn under_disc(&self, stroke: &Stroke, line: &Line) -> Option<f64> {
        let ends = [&stroke.from, &stroke.to].map(|p| Disc { middle: p.tip, axis: p.axis });
        let lean = self.layer.depth * line.normal.cross(stroke.to.axis).length();
        let covering = if self.is_upright(lean) { 0.5 * self.smear } else { 0.0 };
        let radius = self.radius - covering;
        let low = disc::lowest(ends, radius.max(0.0), line.foot, line.normal);
        low.map(|low| low.max(self.layer.allowance))
    }

    /// The same where the least may lie before the end of the move.
    fn lowered_between(&self, stroke: &Stroke, line: &Line, height: f64, end: Meeting) -> f64 {
        let at = |t: f64, near: f64| {
            let known = Known { near, limit: f64::INFINITY };
            self.meet(&stroke.from.toward(&stroke.to, t), stroke, line, known)
        };
        let Some(start) = at(0.0, end.height).filter(|s| s.slope < 0.0) else { return height };
        let (mut falling, mut rising, mut height) = ((0.0, start), (1.0, end), height);
        for round in 0..ROUNDS {
            let ((t0, a), (t1, b)) = (falling, rising);
            // Where the tangents meet: none is below, and exact where the body has an edge.
            let edge = (b.height - b.slope * t1 - a.height + a.slope * t0) / (a.slope - b.slope);
            let least = a.height + a.slope * (edge - t0);
            if !(t0 < edge && edge < t1) || height - least <= CLOSE {
                break;
            }
            // Where the slope, if linear, is zero: exact where the body is round.
            let level = t0 - a.slope * (t1 - t0) / (b.slope - a.slope);
            let t = if round % 2 == 0 { edge } else { level };
            let Some(middle) = at(t, 0.5 * (least + a.height.min(b.height))) else { break };
            height = height.min(middle.height);
            let side = if middle.slope > 0.0 { &mut rising } else { &mut falling };
            *side = (t, middle);
        }
        height
    }

    /// Height to which the column is cut at a pose; none also where that is certainly above what matters.
    fn meet(&self, pose: &Pose, stroke: &Stroke, line: &Line, known: Known) -> Option<Meeting> {
        let q = line.foot - pose.tip;
        let (z, cosine) = (q.dot(pose.axis), line.normal.dot(pose.axis));
        // Nothing of the cutter is below its tip.
        if z + cosine * known.limit <= 0.0 && cosine > 0.0 {
            return None;
        }
        let middle = z + cosine * (self.layer.allowance + 0.5 * self.layer.depth);
        if middle > self.length {
            return None;
        }
        let view = View::new(q, z, cosine, line);
        let lean = view.a.max(0.0).sqrt() * self.layer.depth;
        let upright = self.is_upright(lean);
        let reach = if upright { self.reach() } else { self.radius };
        let near = view.rho_squared(self.layer.allowance + 0.5 * self.layer.depth);
        // The middle of the column lies within half its lean of all of it.
        let farthest = reach + 0.5 * lean;
        if near > farthest * farthest {
            return None;
        }
        if upright && self.corner < self.layer.depth {
            self.meet_smeared(pose, stroke, line, &view, near.max(0.0).sqrt())
        } else {
            self.under_bottom(pose, stroke, line, &view)
                .or_else(|| self.meet_sharp(pose, stroke, line, &view, known))
        }
    }

    /// A column that lies entirely over the flat bottom.
    fn under_bottom(
        &self,
        pose: &Pose,
        stroke: &Stroke,
        line: &Line,
        view: &View,
    ) -> Option<Meeting> {
        let height = if view.cosine > FLAT { -view.z / view.cosine } else { return None };
        let (floor, top) = (self.layer.allowance, self.layer.top());
        let over = view.rho_squared(height) <= self.bottom * self.bottom
            && view.rho_squared(top) <= self.radius * self.radius
            && height <= top;
        let entry = Entry { height, outward: -pose.axis };
        over.then(|| Meeting {
            height: height.max(floor),
            slope: slope(&entry, pose, stroke, line),
        })
    }

    fn meet_sharp(
        &self,
        pose: &Pose,
        stroke: &Stroke,
        line: &Line,
        view: &View,
        known: Known,
    ) -> Option<Meeting> {
        let (first, last) = view.within(self.radius)?;
        let entry = self.entry(pose, line, view, first, known)?;
        let (floor, top) = (self.layer.allowance, self.layer.top());
        if entry.height > self.highest(known) || last <= entry.height.max(floor) {
            return None;
        }
        let left_above = if self.layer.falls { 0.0 } else { (top - last).max(0.0) };
        Some(Meeting {
            height: entry.height.max(floor) + left_above,
            slope: slope(&entry, pose, stroke, line),
        })
    }

    /// The highest relevant entry: from above the layer the corner may have come down into the column earlier.
    fn highest(&self, known: Known) -> f64 {
        known.limit.min(self.layer.top() + self.corner)
    }

    /// Beside a wall that is parallel to the column and covers a fraction of it.
    fn meet_smeared(
        &self,
        pose: &Pose,
        stroke: &Stroke,
        line: &Line,
        view: &View,
        rho: f64,
    ) -> Option<Meeting> {
        let covered = (0.5 + (self.radius - rho) / self.smear).min(1.0);
        if covered <= 0.0 {
            return None;
        }
        let entry = match view.within(self.radius) {
            Some(_) => {
                let nothing = Known { near: f64::INFINITY, limit: f64::INFINITY };
                self.entry(pose, line, view, f64::NEG_INFINITY, nothing)?
            }
            None => Entry { height: view.above(self.corner)?, outward: -pose.axis },
        };
        let (floor, top) = (self.layer.allowance, self.layer.top());
        if entry.height > top {
            return None;
        }
        let low = entry.height.max(floor);
        let mut change = covered * slope(&entry, pose, stroke, line);
        if covered < 1.0 && rho > 0.0 {
            let middle = view.q + line.normal * (floor + 0.5 * self.layer.depth);
            let across = middle - pose.axis * middle.dot(pose.axis);
            change -= (top - low) * across.dot(stroke.travel) / (rho * self.smear);
        }
        Some(Meeting { height: low + (1.0 - covered) * (top - low), slope: change })
    }

    /// Where the line enters the body; it enters the cylinder of the cutter's radius at `side`.
    fn entry(
        &self,
        pose: &Pose,
        line: &Line,
        view: &View,
        side: f64,
        known: Known,
    ) -> Option<Entry> {
        if self.bottom == 0.0
            && let Some(entry) = self.entry_of_ball(pose, line, view)
        {
            return Some(entry);
        }
        let base = if self.bottom == 0.0 { self.corner } else { 0.0 };
        let under = view.above(base)?;
        let (height, from_below) = if under >= side { (under, true) } else { (side, false) };
        if self.corner == 0.0 || self.bottom == 0.0 {
            let outward = if from_below {
                -pose.axis
            } else {
                let at = view.q + line.normal * height;
                at - pose.axis * at.dot(pose.axis)
            };
            return Some(Entry { height, outward });
        }
        let outside = height.max(self.layer.allowance - self.radius);
        let height = self.height_at_corner(view, outside, known)?;
        let at = view.q + line.normal * height;
        let z = at.dot(pose.axis);
        let across = at - pose.axis * z;
        let out = 1.0 - self.bottom / across.length().max(self.bottom);
        let outward = across * out + pose.axis * (z - self.corner).min(0.0);
        // Inside of the core there is no direction: from below.
        let outward = if outward == DVec3::ZERO { -pose.axis } else { outward };
        Some(Entry { height, outward })
    }

    /// Enters the sphere, unless the line came through the cylinder above it.
    fn entry_of_ball(&self, pose: &Pose, line: &Line, view: &View) -> Option<Entry> {
        let from_centre = view.q - pose.axis * self.corner;
        let along = from_centre.dot(line.normal);
        let square = self.corner * self.corner - from_centre.length_squared() + along * along;
        if square < 0.0 {
            return None;
        }
        let height = -along - square.sqrt();
        let outward = from_centre + line.normal * height;
        (outward.dot(pose.axis) <= 0.0).then_some(Entry { height, outward })
    }

    /// Newton's method on the distance from the core, which is convex along the line: from a known height, from which
    /// the first step leads outside, or from `outside`.
    fn height_at_corner(&self, view: &View, outside: f64, known: Known) -> Option<f64> {
        let top = self.highest(known);
        let mut height = if known.near.is_finite() { known.near.min(top) } else { outside };
        let mut guessed = height > outside;
        height = height.max(outside);
        for _ in 0..STEPS {
            let rho = view.rho_squared(height).max(0.0).sqrt();
            let out = (rho - self.bottom).max(0.0);
            let under = (self.corner - view.z - view.cosine * height).max(0.0);
            let distance = (out * out + under * under).sqrt();
            let excess = distance - self.corner;
            let spread = if out > 0.0 { out * (view.b + view.a * height) / rho } else { 0.0 };
            let rate = (spread - under * view.cosine) / distance;
            // Where the body ends again the distance grows.
            if excess <= MET && (!guessed || (rate < 0.0 && excess >= -MET)) {
                return Some(height);
            }
            if rate < -FLAT {
                let step = excess / rate;
                height -= step;
                // The distance bends by 1/r_c at most: what a further step would change.
                if excess.abs() < 0.1 * self.corner && step * step < -2.0 * MET * self.corner * rate
                {
                    return (height <= top).then_some(height.max(outside));
                }
                // Outside, and still below.
                if excess > 0.0 && height > top {
                    return None;
                }
                height = height.max(outside);
            } else if guessed {
                // Behind the body's middle, or in its core.
                height = outside;
            } else {
                return None;
            }
            guessed &= excess <= 0.0 && height > outside;
        }
        Some(height)
    }
}

/// Change of the entry's height over the whole move: the body's side moves with the cutter.
fn slope(entry: &Entry, pose: &Pose, stroke: &Stroke, line: &Line) -> f64 {
    // A turn moves what lies above the tip, and what lies beside it up or down.
    let swung = stroke.turn.map_or(DVec3::ZERO, |turn| {
        let r = line.foot + line.normal * entry.height - pose.tip;
        turn * r.dot(pose.axis) - pose.axis * turn.dot(r)
    });
    let travel = stroke.travel + swung;
    let against = entry.outward.dot(line.normal);
    if against < 0.0 { entry.outward.dot(travel) / against } else { 0.0 }
}
