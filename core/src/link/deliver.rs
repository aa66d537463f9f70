//! Flat path → the delivered [`Toolpath`]: lifted, located, joined by retracts and approaches.

use crate::cutter_location::{
    CheckMesh, LocateError, Located, PassOptions, RaisedStretch, ToolAxis, locate_pass,
};
use crate::flat_path::FlatPoint;
use crate::flatten::OutsideChart;
use crate::geometry::{DVec3, math};
use crate::lift::{Lift, Lifted};
use crate::toolpath::{MoveKind, PathPoint, Toolpath};
use thiserror::Error;

/// Largest turn between two points of a rapid around the part, rad.
const RAPID_TURN: f64 = 0.1;

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
    /// Height of rapids above part and stock, mm.
    pub clearance: f64,
    /// Feed of approach and retract through air, mm/s.
    pub air_feed: f64,
    /// Speed of rapids, mm/s.
    pub rapid_feed: f64,
}

/// The space that rapids keep out of.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct KeepOut {
    /// Lower and upper corner of the part with its stock, mm.
    pub bounds: (DVec3, DVec3),
}

/// The delivered path and where the cutter had to be raised.
#[derive(Clone, Debug, Default)]
pub struct Delivered {
    /// The path.
    pub toolpath: Toolpath,
    /// Stretches where the cutter does not fit.
    pub raised: Vec<RaisedStretch>,
}

/// Lifts, locates and joins a flat path. `progress` is called with the part done.
///
/// # Errors
/// [`DeliverError`] when a point cannot be lifted or the cutter cannot be located there.
pub fn deliver(
    flat: &[FlatPoint],
    lift: &Lift,
    check: &CheckMesh,
    keep_out: &KeepOut,
    options: &DeliverOptions,
    mut progress: impl FnMut(f64),
) -> Result<Delivered, DeliverError> {
    let mut out = Delivered::default();
    let mut start = 0;
    while start < flat.len() {
        let end = (start + 1..flat.len())
            .find(|&i| flat[i].kind == MoveKind::Rapid)
            .unwrap_or(flat.len());
        let lifted = lift.run(&flat[start..end], start)?;
        let located = locate_pass(&lifted.contacts, &options.pass, check)?;
        out.raised.extend(located.raised);
        let run = Run { flat, lifted: &lifted, located: &located.points };
        run.append(&mut out.toolpath.points, keep_out, options);
        start = end;
        progress(end as f64 / flat.len() as f64);
    }
    Ok(out)
}

/// Moves between two retracts.
struct Run<'a> {
    flat: &'a [FlatPoint],
    lifted: &'a Lifted,
    located: &'a [Located],
}

impl Run<'_> {
    fn append(&self, points: &mut Vec<PathPoint>, keep_out: &KeepOut, options: &DeliverOptions) {
        let (Some(first), Some(last)) = (self.located.first(), self.located.last()) else { return };
        let pass = self.flat[self.lifted.points[first.keys.0].source].pass;
        let above = keep_out.above(first, options);
        rapid(points, keep_out, options, pass, above, first.axis);
        let link = |tip: DVec3, l: &Located, pass: u32| PathPoint {
            kind: MoveKind::Link,
            pass,
            region: 0,
            tip,
            axis: l.axis,
            normal: l.axis,
            flat: None,
            feed: options.air_feed,
            mrr: 0.0,
            alpha: 0.0,
            time: 0.0,
        };
        points.push(link(first.tip, first, pass));
        points.extend(self.located.iter().skip(1).map(|l| self.point(l)));
        let pass = self.flat[self.lifted.points[last.keys.1].source].pass;
        points.push(link(keep_out.above(last, options), last, pass));
    }

    /// A located point with the largest removal rate of the moves it covers.
    fn point(&self, l: &Located) -> PathPoint {
        let sources = (self.lifted.points[l.keys.0].source, self.lifted.points[l.keys.1].source);
        let covered = &self.flat[sources.0..=sources.1];
        let worst = covered
            .iter()
            .fold(&self.flat[sources.1], |worst, p| if p.mrr > worst.mrr { p } else { worst });
        let end = &self.flat[sources.1];
        PathPoint {
            kind: end.kind,
            pass: end.pass,
            region: 0,
            tip: l.tip,
            axis: l.axis,
            normal: l.normal,
            flat: Some(self.lifted.points[l.keys.1].uv),
            feed: l.feed,
            mrr: worst.mrr,
            alpha: worst.alpha,
            time: 0.0,
        }
    }
}

impl KeepOut {
    fn center(&self) -> DVec3 {
        0.5 * (self.bounds.0 + self.bounds.1)
    }

    fn sphere(&self, clearance: f64) -> f64 {
        0.5 * (self.bounds.1 - self.bounds.0).length() + clearance
    }

    /// Where the tip is clear of everything, reached along the axis.
    ///
    /// Fixed axis: the plane `clearance` above the part. Turning axis: the sphere `clearance`
    /// outside of the part's bounding sphere.
    fn above(&self, l: &Located, options: &DeliverOptions) -> DVec3 {
        match options.pass.axis {
            ToolAxis::Fixed(axis) => {
                let corner =
                    |i: usize| if axis[i] > 0.0 { self.bounds.1[i] } else { self.bounds.0[i] };
                let top: f64 = (0..3).map(|i| corner(i) * axis[i]).sum();
                l.tip + axis * (top + options.clearance - l.tip.dot(axis)).max(0.0)
            }
            ToolAxis::Lead(_) => {
                let offset = l.tip - self.center();
                let radius = self.sphere(options.clearance);
                let (b, c) = (offset.dot(l.axis), offset.length_squared() - radius * radius);
                l.tip + l.axis * (-b + (b * b - c).max(0.0).sqrt()).max(0.0)
            }
        }
    }
}

/// Rapid from where the path ends to `to`, around the part if the axis turns.
fn rapid(
    points: &mut Vec<PathPoint>,
    keep_out: &KeepOut,
    options: &DeliverOptions,
    pass: u32,
    to: DVec3,
    axis: DVec3,
) {
    let last = points.last().copied();
    let mut push = |tip: DVec3, axis: DVec3| {
        points.push(PathPoint {
            kind: MoveKind::Rapid,
            pass,
            region: 0,
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
    let center = keep_out.center();
    let (from, goal) = (last.tip - center, to - center);
    let turn = angle(from, goal).max(angle(last.axis, axis));
    let steps = (turn / RAPID_TURN).ceil().max(1.0) as usize;
    for i in 1..steps {
        let t = i as f64 / steps as f64;
        let radius = from.length() + (goal.length() - from.length()) * t;
        push(center + turned(from, goal, t) * radius, turned(last.axis, axis, t));
    }
    push(to, axis);
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
