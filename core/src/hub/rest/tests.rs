//! Passes on a cylinder of which one is missing or too short.

use super::super::shapes::Cylinder;
use super::super::strips::Strip;
use super::*;
use crate::footprint::Footprint;
use crate::geometry::DVec3;
use crate::tool::Tool;
use crate::toolpath::{MoveKind, PathPoint};

const HUB: Cylinder = Cylinder { radius: 50.0, length: 80.0 };
const RADIUS: f64 = 3.0;
const CUSP: f64 = 0.01;
const STEPS: usize = 400;

struct Case {
    wheel: Wheel,
    channel: Channel,
    measured: Measured,
}

impl Case {
    fn new() -> Self {
        let wheel = HUB.wheel(12);
        let z = |s: f64| 10.0 + 50.0 * s;
        let side = |x: f64| move |s: f64| DVec2::new(x, z(s));
        let channel = HUB.channel(&wheel, side(36.0), side(44.0));
        let footprint = Footprint::new(Tool::new(RADIUS, RADIUS).unwrap(), 0.0);
        let measured = Measured::new(&wheel, &channel, &Strip { footprint, cusp: CUSP });
        Self { wheel, channel, measured }
    }

    fn strips(&self) -> Vec<Line> {
        self.measured.strips(&self.wheel, &self.channel)
    }

    /// What passes along lines leave too high.
    fn left(&self, lines: &[Line]) -> Vec<TooHigh> {
        let mut path = Toolpath::default();
        let mut contacts = Vec::new();
        for line in lines {
            for i in 0..=STEPS {
                let s = line.from + (line.to - line.from) * i as f64 / STEPS as f64;
                let at = self.channel.at(s, line.at(s));
                let normal = self.wheel.normal(at);
                path.points.push(PathPoint {
                    kind: if i == 0 { MoveKind::Rapid } else { MoveKind::Cut },
                    pass: 0,
                    region: 0,
                    tip: self.wheel.hub.point(at),
                    axis: normal,
                    normal,
                    flat: None,
                    feed: 10.0,
                    mrr: 0.0,
                    alpha: 0.0,
                    time: 0.0,
                });
                contacts.push(Some(at));
            }
        }
        let gauge = Gauge {
            wheel: &self.wheel,
            cutter: Cutter { tool: Tool::new(RADIUS, RADIUS).unwrap(), length: f64::INFINITY },
            allowance: 0.0,
            limit: 1.02 * CUSP,
            threads: 1,
        };
        let parts = [(&self.channel, gaps(&self.measured, lines))];
        let mut left = gauge.too_high(path, &contacts, &parts).remove(0);
        // Nothing runs on beyond the ends here.
        left.retain(|l| (0.005..0.995).contains(&l.gap.s));
        left
    }

    fn place(&self, gap: &Gap) -> DVec3 {
        self.channel.place(&self.wheel, gap.s, gap.t)
    }
}

#[test]
fn strips_leave_nothing_too_high() {
    let case = Case::new();
    assert_eq!(case.left(&case.strips()), []);
}

/// Between two parallel passes with the distance `d` on a cylinder the height in the middle is that of a triangle of the
/// axis, the ball's centre and the cusp.
#[test]
fn a_missing_pass_is_measured_and_added() {
    let case = Case::new();
    let mut lines = case.strips();
    let count = lines.len();
    let missing = lines.remove(count / 2);
    let left = case.left(&lines);
    let beside = [count / 2 - 1, count / 2].map(|i| case.channel.at(0.5, lines[i].at(0.5)));
    let [a, b] = beside.map(|at| HUB.flat(case.wheel.hub.point(at)).x);
    let half = 0.5 * (b - a).abs() / HUB.radius;
    let (sine, cosine) = (crate::geometry::math::sin(half), crate::geometry::math::cos(half));
    let centre = HUB.radius + RADIUS;
    let reach = centre * cosine - (RADIUS * RADIUS - centre * centre * sine * sine).sqrt();
    let height = reach - HUB.radius;
    let highest = left.iter().map(|l| l.height).fold(0.0, f64::max);
    assert!((highest / height - 1.0).abs() < 0.02, "{highest}: {height}");
    let area: f64 = left.iter().map(|l| l.gap.area).sum();
    assert!(area > 0.9 * 50.0 * (b - a).abs(), "{area}");
    let mended = with_rest(&case.measured, lines, &left);
    assert_eq!(mended.len(), count);
    assert!((mended[count - 1].at(0.5) - missing.at(0.5)).abs() < 1e-3);
    assert_eq!(case.left(&mended), []);
}

#[test]
fn a_pass_that_begins_too_late_is_made_longer() {
    let case = Case::new();
    let mut lines = case.strips();
    let late = lines.len() / 2;
    lines[late].from = 0.04;
    // Beyond that the others close the gap.
    let left = case.left(&lines);
    assert!(left.iter().all(|l| l.gap.s < 0.04));
    assert!(left.iter().all(|l| case.place(&l.gap).z < 12.0 + 1e-9));
    let near: Vec<TooHigh> = left.iter().copied().filter(|l| l.gap.s > 0.02).collect();
    let mended = with_rest(&case.measured, lines.clone(), &near);
    assert_eq!(mended.len(), lines.len());
    assert!(mended[late].from < 0.02);
}
