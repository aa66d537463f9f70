//! The path as moves in cutting order, divided into steps, with bounds by which a tile of the part skips most of
//! them.
//!
//! - *Move*: the motion to a point of the path; the tip goes straight, the axis turns evenly.
//! - *Step*: a piece of a move, so short that the axis hardly turns. All times within it are treated alike.
//! - *Cluster*: consecutive moves and bounds of the cutter on them.

use super::body::{Body, Nearest, Placed};
use crate::geometry::DVec3;
use crate::toolpath::{MoveKind, PathPoint, Toolpath};

/// Longest step as a fraction of the cutter radius: half a window of the removal rate.
const LONGEST: f64 = 0.1;
/// Largest turn on a step, rad; the error of a straight line from end to end at a distance `R` from the tip is its
/// square times `R / 8`: 0.2 µm for 5 mm.
const LARGEST_TURN: f64 = 0.017;
/// Greatest number of steps of a move; only moves of metres get longer steps.
const MOST_STEPS: f64 = 4096.0;
/// Children of a cluster.
const FAN: usize = 16;

/// A move.
#[derive(Copy, Clone, Debug)]
pub struct Move {
    /// Where it starts.
    pub from: Placed,
    /// Where it ends.
    pub to: Placed,
    /// Whether it is a rapid.
    pub rapid: bool,
    /// Number of steps; 0 for a move of length zero.
    pub steps: u32,
    /// Number of steps before it.
    pub first_step: u64,
}

/// Bounds of the cutter on a set of moves.
#[derive(Copy, Clone, Debug)]
struct Cluster {
    /// Middle of the tips.
    middle: DVec3,
    /// Farthest tip from it.
    radius: f64,
    axis: DVec3,
    /// Largest distance of an axis from the mean one, as unit vectors.
    spread: f64,
}

/// All moves of a path.
#[derive(Clone, Debug)]
pub struct Motion {
    moves: Vec<Move>,
    /// Bounds of every single move.
    leaves: Vec<Cluster>,
    /// Clusters of [`FAN`] moves, of [`FAN`] of those, and so on.
    levels: Vec<Vec<Cluster>>,
}

/// A step of a move.
#[derive(Copy, Clone, Debug)]
pub struct Step {
    /// Where it starts.
    pub from: Placed,
    /// Half way.
    pub middle: Placed,
    /// Where it ends.
    pub to: Placed,
    /// Index of the move.
    pub of: u32,
    /// Index among all steps.
    pub index: u64,
    /// Half the travel of the tip.
    pub half_way: DVec3,
    /// Half the change of the axis.
    pub half_turn: f64,
}

impl Step {
    /// The cutter at a position of the step from -1, its start, to 1, its end.
    pub fn at(&self, part: f64) -> Placed {
        let axis = self.middle.axis + 0.5 * part * (self.to.axis - self.from.axis);
        let tip = self.middle.tip + self.half_way * part;
        Placed { tip, axis: axis.normalize_or(self.middle.axis) }
    }

    /// How fast the cutter, at that position of the step, approaches a point, over the whole step; its spin about the
    /// axis is ignored.
    pub fn approach(&self, at: &Placed, near: &Nearest, point: DVec3) -> f64 {
        let touched = point - near.outward * near.distance - at.tip;
        let turn = self.to.axis - self.from.axis;
        let way = 2.0 * self.half_way + turn * touched.dot(at.axis) - at.axis * turn.dot(touched);
        way.dot(near.outward)
    }

    /// Whether the cutter may come within a given distance of a point.
    pub fn may_come_near(&self, body: &Body, point: DVec3, distance: f64) -> bool {
        let turned = 2.0 * self.half_turn * point.distance(self.to.tip);
        let way = 2.0 * self.half_way.length() + turned;
        body.nearest(&self.to, point).distance < distance + way
    }
}

impl Motion {
    /// The moves of a path for a cutter.
    pub fn new(path: &Toolpath, body: &Body) -> Self {
        let mut moves = Vec::with_capacity(path.points.len());
        let mut steps = 0;
        for pair in path.points.windows(2) {
            let m = Move::new(&pair[0], &pair[1], body, steps);
            steps += u64::from(m.steps);
            moves.push(m);
        }
        let leaf = |m: &Move| Cluster::of([m.from, m.to].into_iter());
        let leaves: Vec<Cluster> = moves.iter().map(leaf).collect();
        let mut levels: Vec<Vec<Cluster>> = Vec::new();
        let mut below = leaves.clone();
        while below.len() > FAN {
            below = below.chunks(FAN).map(Cluster::join).collect();
            levels.push(below.clone());
        }
        Self { moves, leaves, levels }
    }

    /// The moves, in order; move `i` ends at point `i + 1`.
    pub fn moves(&self) -> &[Move] {
        &self.moves
    }

    /// Calls `visit` for the steps, in order, on which the cutter may reach into a sphere.
    pub fn near(&self, body: &Body, centre: DVec3, radius: f64, visit: &mut dyn FnMut(&Step)) {
        let target = Target { body, centre, radius };
        let top = self.levels.last().map_or(self.moves.len(), Vec::len);
        (0..top).for_each(|i| self.descend(self.levels.len(), i, &target, visit));
    }

    fn descend(&self, level: usize, index: usize, target: &Target, visit: &mut dyn FnMut(&Step)) {
        if level == 0 {
            let m = &self.moves[index];
            if m.steps > 0 && !target.is_clear_of(&self.leaves[index]) {
                m.visit_steps(index as u32, 0, m.steps, target, visit);
            }
            return;
        }
        if target.is_clear_of(&self.levels[level - 1][index]) {
            return;
        }
        let below = if level > 1 { self.levels[level - 2].len() } else { self.moves.len() };
        let children = index * FAN..((index + 1) * FAN).min(below);
        children.for_each(|child| self.descend(level - 1, child, target, visit));
    }
}

impl Move {
    fn new(from: &PathPoint, to: &PathPoint, body: &Body, first_step: u64) -> Self {
        let length = to.tip.distance(from.tip);
        let turn = to.axis.distance(from.axis);
        let pieces = (length / (LONGEST * body.radius())).max(turn / LARGEST_TURN);
        let place = |p: &PathPoint| Placed { tip: p.tip, axis: p.axis };
        Self {
            from: place(from),
            to: place(to),
            rapid: to.kind == MoveKind::Rapid,
            steps: pieces.ceil().clamp(0.0, MOST_STEPS) as u32,
            first_step,
        }
    }

    /// The cutter at a fraction `t` of the move.
    pub fn at(&self, t: f64) -> Placed {
        let tip = self.from.tip.lerp(self.to.tip, t);
        // Most cutters never turn.
        if self.from.axis == self.to.axis {
            return Placed { tip, axis: self.to.axis };
        }
        let axis = self.from.axis.lerp(self.to.axis, t);
        Placed { tip, axis: axis.normalize_or(self.to.axis) }
    }

    /// Step `k` of the move, which is the path's move `of`.
    fn step(&self, of: u32, k: u32) -> Step {
        let n = f64::from(self.steps);
        let [from, middle, to] = [0.0, 0.5, 1.0].map(|s| self.at((f64::from(k) + s) / n));
        Step {
            from,
            middle,
            to,
            of,
            index: self.first_step + u64::from(k),
            half_way: 0.5 * (to.tip - from.tip),
            half_turn: 0.5 * to.axis.distance(from.axis),
        }
    }

    fn visit_steps(
        &self,
        of: u32,
        first: u32,
        end: u32,
        target: &Target,
        visit: &mut dyn FnMut(&Step),
    ) {
        let n = f64::from(self.steps);
        let all = end - first == self.steps;
        let ends = || [first, end].map(|k| self.at(f64::from(k) / n));
        if !all && target.is_clear_of(&Cluster::of(ends().into_iter())) {
            return;
        }
        if end - first == 1 {
            return visit(&self.step(of, first));
        }
        let half = first + (end - first) / 2;
        self.visit_steps(of, first, half, target, visit);
        self.visit_steps(of, half, end, target, visit);
    }
}

impl Cluster {
    /// Bounds around straight moves between the places.
    fn of(places: impl Iterator<Item = Placed> + Clone) -> Self {
        let tips = places.clone().map(|p| p.tip);
        let (low, high) = super::samples::bounds(tips.clone());
        let middle = 0.5 * (low + high);
        let sum: DVec3 = places.clone().map(|p| p.axis).sum();
        let axis = sum.normalize_or(DVec3::Z);
        Self {
            middle,
            radius: tips.map(|p| p.distance(middle)).fold(0.0, f64::max),
            axis,
            spread: places.map(|p| p.axis.distance(axis)).fold(0.0, f64::max),
        }
    }

    fn join(children: &[Self]) -> Self {
        let radius = children.iter().map(|c| c.radius).fold(0.0, f64::max);
        let (low, high) = super::samples::bounds(children.iter().map(|c| c.middle));
        let middle = 0.5 * (low + high);
        let sum: DVec3 = children.iter().map(|c| c.axis).sum();
        let axis = sum.normalize_or(DVec3::Z);
        let far = |c: &Self| c.middle.distance(middle) + c.radius;
        let turned = |c: &Self| c.axis.distance(axis) + c.spread;
        Self {
            middle,
            radius: children.iter().map(far).fold(radius, f64::max),
            axis,
            spread: children.iter().map(turned).fold(0.0, f64::max),
        }
    }
}

/// A sphere that the cutter may reach into.
struct Target<'a> {
    body: &'a Body,
    centre: DVec3,
    radius: f64,
}

impl Target<'_> {
    /// Whether the cutter, anywhere in the cluster, stays out of the sphere.
    fn is_clear_of(&self, cluster: &Cluster) -> bool {
        let way = self.centre - cluster.middle;
        let slack = self.radius + cluster.radius;
        let distance = way.length();
        let (radius, length) = (self.body.radius(), self.body.length());
        if length.is_finite() && distance > slack + length + radius {
            return true;
        }
        let height = way.dot(cluster.axis);
        let across = (distance * distance - height * height).max(0.0).sqrt();
        let lean = cluster.spread * (distance + slack);
        across > radius + slack + 2.0 * lean
            || height + slack + lean < 0.0
            || height - slack - lean > length
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tool::Tool;

    fn path(points: &[(f64, f64, f64, f64)]) -> Toolpath {
        let point = |&(x, y, z, lean): &(f64, f64, f64, f64)| PathPoint {
            kind: MoveKind::Cut,
            pass: 0,
            region: 0,
            tip: DVec3::new(x, y, z),
            axis: DVec3::new(lean, 0.0, 1.0).normalize(),
            normal: DVec3::Z,
            flat: None,
            feed: 1.0,
            mrr: 0.0,
            alpha: 0.0,
            time: 0.0,
        };
        Toolpath { points: points.iter().map(point).collect() }
    }

    #[test]
    fn no_step_that_reaches_is_left_out() {
        let points: Vec<_> = (0..400)
            .map(|i| {
                let t = f64::from(i);
                (
                    f64::from(i % 40) * 3.0,
                    t * 0.25,
                    f64::from(i % 7) * 2.0,
                    0.01 * f64::from(i % 50),
                )
            })
            .collect();
        let body = Body::new(&Tool::new(2.0, 0.5).unwrap(), 12.0);
        let motion = Motion::new(&path(&points), &body);
        for centre in [DVec3::new(60.0, 45.0, 14.0), DVec3::new(3.0, 90.0, 14.0)] {
            let mut visited = Vec::new();
            motion.near(&body, centre, 1.0, &mut |s| visited.push(s.index));
            assert!(visited.windows(2).all(|w| w[0] < w[1]));
            let mut reaching = 0;
            for (i, m) in motion.moves().iter().enumerate() {
                for k in 0..m.steps {
                    let step = m.step(i as u32, k);
                    let reaches = [step.from, step.middle, step.to]
                        .iter()
                        .any(|at| body.nearest(at, centre).distance < 1.0);
                    reaching += usize::from(reaches);
                    assert!(!reaches || visited.binary_search(&step.index).is_ok());
                }
            }
            assert!(
                reaching > 0 && visited.len() < 2 * reaching + 200,
                "{} {reaching}",
                visited.len()
            );
        }
    }

    #[test]
    fn steps_are_short_and_hardly_turn() {
        let body = Body::new(&Tool::new(5.0, 5.0).unwrap(), 20.0);
        let motion =
            Motion::new(&path(&[(0., 0., 0., 0.), (3., 0., 0., 0.), (3., 0., 0., 0.2)]), &body);
        assert_eq!(motion.moves()[0].steps, 6);
        assert_eq!(motion.moves()[1].steps, 12);
        assert_eq!(motion.moves()[1].first_step, 6);
    }
}
