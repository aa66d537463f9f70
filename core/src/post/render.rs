//! The renderer: points → blocks.

use super::blocks::{Blocks, Letter, notes};
use super::dialect::{Dialect, FeedMode, Orientation, Position};
use super::error::PostError;
use super::program::{Program, ProgramOptions};
use crate::geometry::{DVec3, math};
use crate::machine::{Axes, Leg, Rotary, Tables};
use crate::machine_time::commanded_time;
use crate::toolpath::{MoveKind, PathPoint, Toolpath};
use crate::units::{MINUTE, per_minute};

/// How far below the rapid plane a rapid may be through rounding, mm.
const ROUNDING: f64 = 1e-6;
/// How far below it a point is lifted to it, mm: less is left of rounded angles.
const LOW: f64 = 1e-3;
/// Travel of the tip below which a block is timed by the turn of the axis, mm: a few of the last digits.
const STILL: f64 = 1e-3;
/// Shortest time of a block, s.
const SHORTEST: f64 = 1e-4;

pub(super) fn render(
    path: &Toolpath,
    options: &ProgramOptions,
    dialect: &Dialect,
) -> Result<Program, PostError> {
    check(path, options)?;
    let program = dialect.program(options.machine.axes)?;
    let form = match (options.machine.axes, program.position, program.orientation) {
        (Axes::ThreeAxis, ..) => Form::Linear,
        (Axes::Xyzac, Position::Machine, _) => Form::Machine,
        (Axes::Xyzac, Position::Tip, Orientation::Angles) => Form::TipAngles,
        (Axes::Xyzac, Position::Tip, Orientation::Vector) => Form::TipVector,
    };
    let tables = Tables::new(&options.machine, options.tolerance, options.tool.radius())
        .keeping_tip(form.keeps_tip());
    let tables = match form {
        // The controller finds the angles by itself.
        Form::TipVector => tables,
        _ => tables.rounded(dialect.angle_decimals()),
    };
    let mut blocks = Blocks::new(options, dialect)?;
    blocks.text.reserve(48 * path.points.len() + 1024);
    blocks.header(options, notes(options.machine.axes, form.keeps_tip()));
    blocks.start();
    let reach = [(f64::INFINITY, f64::NEG_INFINITY); 3];
    let (feed_mode, legs) = (program.feed_mode, Vec::new());
    let mut writer = Writer { blocks, options, form, feed_mode, tables, reach, legs };
    writer.start(&path.points);
    for pair in path.points.windows(2) {
        writer.step(&pair[0], &pair[1])?;
    }
    writer.finish(&path.points[path.points.len() - 1], last_feed(&path.points));
    check_travel(&writer.reach, options)?;
    Ok(Program { text: writer.blocks.text, extension: dialect.extension.clone() })
}

/// Everything that would make the program wrong, before anything is written.
fn check(path: &Toolpath, options: &ProgramOptions) -> Result<(), PostError> {
    if path.points.is_empty() {
        return Err(PostError::Empty);
    }
    let rapid_plane = options.rapid_plane;
    for (index, p) in path.points.iter().enumerate() {
        if !p.tip.is_finite() || !(1.0 - 1e-6..1.0 + 1e-6).contains(&p.axis.length()) {
            return Err(PostError::NotFinite { index });
        }
        if options.machine.axes == Axes::ThreeAxis && p.axis.distance(DVec3::Z) > 1e-9 {
            return Err(PostError::TiltedAxis { index, tip: p.tip, axis: p.axis });
        }
        if index == 0 {
            continue;
        }
        if p.kind == MoveKind::Rapid {
            let height = height(p).min(height(&path.points[index - 1]));
            if height < rapid_plane - ROUNDING {
                return Err(PostError::LowRapid { index, tip: p.tip, height, rapid_plane });
            }
        } else if !(p.feed.is_finite() && p.feed > 0.0) {
            return Err(PostError::Feed { index, feed: p.feed });
        }
    }
    Ok(())
}

/// Whether every linear axis stays within its travel.
fn check_travel(reach: &[(f64, f64); 3], options: &ProgramOptions) -> Result<(), PostError> {
    let travel = &options.machine.travel;
    for (i, allowed) in [travel.x, travel.y, travel.z].into_iter().enumerate() {
        let Some((low, high)) = allowed else { continue };
        let position = if low - reach[i].0 > reach[i].1 - high { reach[i].0 } else { reach[i].1 };
        if position < low || position > high {
            return Err(PostError::Travel { axis: ['X', 'Y', 'Z'][i], position, low, high });
        }
    }
    Ok(())
}

/// Machine Z of the tip.
fn height(p: &PathPoint) -> f64 {
    p.tip.dot(p.axis)
}

fn feed_of<'a>(mut points: impl Iterator<Item = &'a PathPoint>) -> Option<f64> {
    points.find(|p| p.kind != MoveKind::Rapid).map(|p| p.feed)
}

fn last_feed(points: &[PathPoint]) -> Option<f64> {
    feed_of(points[1..].iter().rev())
}

/// What the coordinates of a program are.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
enum Form {
    /// The tip, on three axes.
    Linear,
    /// Positions of the axes of the machine.
    Machine,
    /// The tip in the workpiece and the angles of the tables.
    TipAngles,
    /// The tip in the workpiece and the direction of the tool axis.
    TipVector,
}

impl Form {
    /// Whether the controller keeps the tip on its line while the tables turn.
    fn keeps_tip(self) -> bool {
        matches!(self, Self::TipAngles | Self::TipVector)
    }
}

struct Writer<'a> {
    blocks: Blocks<'a>,
    options: &'a ProgramOptions,
    form: Form,
    feed_mode: FeedMode,
    tables: Tables,
    /// Least and greatest position of each linear axis so far, mm.
    reach: [(f64, f64); 3],
    /// Of the move that is being written.
    legs: Vec<Leg>,
}

/// How fast a block runs.
#[derive(Copy, Clone)]
enum Speed {
    Rapid,
    /// mm/s.
    Feed(f64),
    /// Time of the block, s; travel of the tip in the workpiece, mm; turn of the axis, rad.
    Time {
        time: f64,
        travel: f64,
        turn: f64,
    },
}

/// Where a block ends.
#[derive(Copy, Clone)]
struct Place {
    /// In the workpiece.
    tip: DVec3,
    axis: DVec3,
    rotary: Rotary,
}

impl Place {
    fn machine(&self) -> DVec3 {
        self.rotary.to_machine(self.tip)
    }
}

impl Writer<'_> {
    /// To the first point: up to the rapid plane, across, then down.
    fn start(&mut self, points: &[PathPoint]) {
        let first = &points[0];
        let plane = self.options.rapid_plane;
        let target = self.place(first);
        let low = Some(plane - target.machine().z).filter(|low| *low > LOW).unwrap_or(0.0);
        let safe = Place { tip: target.tip + low * target.axis, ..target };
        match self.form {
            // Retracted before, the cutter goes over the first point before it goes down.
            Form::Linear if self.blocks.has_control() => {
                let machine = safe.machine();
                self.blocks.go(None, &[(Letter::X, machine.x), (Letter::Y, machine.y)]);
                self.blocks.control(true);
            }
            // Blocks of which each gives all coordinates cannot go up alone.
            Form::Linear | Form::Machine if self.blocks.repeats_words() => {}
            Form::Linear | Form::Machine => {
                self.extend(safe.machine());
                self.blocks.go(None, &[(Letter::Z, safe.machine().z)]);
            }
            // The tables turn before the control follows them.
            Form::TipAngles => {
                self.blocks.go(None, &angles(safe.rotary));
                self.blocks.control(true);
            }
            Form::TipVector => self.blocks.control(true),
        }
        self.block(Speed::Rapid, safe);
        if low > 0.0 {
            let feed = feed_of(points[1..].iter()).unwrap_or(self.options.machine.max_feed);
            self.along_axis(target, low, feed);
        }
    }

    fn finish(&mut self, last: &PathPoint, feed: Option<f64>) {
        let at = Place { tip: last.tip, axis: last.axis, rotary: self.tables.at };
        let low = self.options.rapid_plane - at.machine().z;
        if low > LOW {
            let feed = feed.unwrap_or(self.options.machine.max_feed);
            self.along_axis(Place { tip: at.tip + low * at.axis, ..at }, low, feed);
        }
        if self.form.keeps_tip() {
            self.blocks.control(false);
        }
        self.blocks.end();
    }

    /// A move at feed along the tool axis.
    fn along_axis(&mut self, to: Place, travel: f64, feed: f64) {
        let speed = match self.form {
            Form::Linear => Speed::Feed(feed),
            _ => Speed::Time { time: travel / feed, travel, turn: 0.0 },
        };
        self.block(speed, to);
    }

    /// The move between two points of the path.
    fn step(&mut self, from: &PathPoint, to: &PathPoint) -> Result<(), PostError> {
        if self.form == Form::Linear {
            let speed = match to.kind {
                MoveKind::Rapid => Speed::Rapid,
                _ => Speed::Feed(to.feed),
            };
            let place = self.place(to);
            self.block(speed, place);
            return Ok(());
        }
        if to.kind == MoveKind::Rapid {
            self.rapid(from, to);
            return Ok(());
        }
        let time = commanded_time(from, to, &self.options.tool, &self.options.machine);
        if self.form == Form::TipVector {
            let least = self.tables.turn(to.axis);
            let place = Place { tip: to.tip, axis: to.axis, rotary: self.tables.at };
            let travel = from.tip.distance(to.tip);
            let turn = angle(from.axis, to.axis);
            self.block(Speed::Time { time: time.max(least), travel, turn }, place);
            return Ok(());
        }
        self.legs(from, to, time)
    }

    /// A move at feed with the angles of the tables.
    fn legs(&mut self, from: &PathPoint, to: &PathPoint, time: f64) -> Result<(), PostError> {
        let mut legs = core::mem::take(&mut self.legs);
        legs.clear();
        let mut before = Place { tip: from.tip, axis: from.axis, rotary: self.tables.at };
        let ends = ((from.tip, from.axis), (to.tip, to.axis));
        let gone = self.tables.go(ends.0, ends.1, time, &mut legs);
        let tolerance = self.options.tolerance;
        gone.map_err(|place| PostError::Singular { place, tolerance })?;
        for leg in &legs {
            let rotary = leg.rotary;
            let place = Place { tip: rotary.to_part(leg.to), axis: rotary.axis(), rotary };
            let travel = before.tip.distance(place.tip);
            let turn = before.rotary.turn_to(rotary);
            self.block(Speed::Time { time: leg.time, travel, turn }, place);
            before = place;
        }
        self.legs = legs;
        Ok(())
    }

    /// A rapid: the linear axes of the machine run straight, above part and stock.
    fn rapid(&mut self, from: &PathPoint, to: &PathPoint) {
        if !self.form.keeps_tip() {
            let place = self.place(to);
            self.block(Speed::Rapid, place);
            return;
        }
        for (tip, rotary) in self.tables.turn_straight(from.tip, (to.tip, to.axis)) {
            let axis = if tip == to.tip { to.axis } else { rotary.axis() };
            self.block(Speed::Rapid, Place { tip, axis, rotary });
        }
    }

    /// Turns the tables for a point.
    fn place(&mut self, p: &PathPoint) -> Place {
        if self.form != Form::Linear {
            self.tables.turn(p.axis);
        }
        Place { tip: p.tip, axis: p.axis, rotary: self.tables.at }
    }

    fn extend(&mut self, machine: DVec3) {
        for (reach, p) in self.reach.iter_mut().zip(machine.to_array()) {
            *reach = (reach.0.min(p), reach.1.max(p));
        }
    }

    /// Writes a block that ends at a place.
    fn block(&mut self, speed: Speed, to: Place) {
        let machine = to.machine();
        self.extend(machine);
        let [a, c] = angles(to.rotary);
        let linear = |p: DVec3| [(Letter::X, p.x), (Letter::Y, p.y), (Letter::Z, p.z)];
        let feed = self.feed(speed);
        match self.form {
            Form::Linear => self.blocks.go(feed, &linear(to.tip)),
            Form::Machine | Form::TipAngles => {
                let position = if self.form == Form::Machine { machine } else { to.tip };
                let [x, y, z] = linear(position);
                self.blocks.go(feed, &[x, y, z, a, c]);
            }
            Form::TipVector => {
                let [x, y, z] = linear(to.tip);
                let axis = to.axis;
                let vector = [(Letter::I, axis.x), (Letter::J, axis.y), (Letter::K, axis.z)];
                self.blocks.go(feed, &[x, y, z, vector[0], vector[1], vector[2]]);
            }
        }
    }

    /// The number of the feed word, and whether it is to be written even if it does not change.
    fn feed(&self, speed: Speed) -> Option<(f64, bool)> {
        match (speed, self.feed_mode) {
            (Speed::Rapid, _) => None,
            (Speed::Feed(feed), _) => Some((per_minute(feed), false)),
            // Each block is timed by itself.
            (Speed::Time { time, .. }, FeedMode::InverseTime) => {
                Some((MINUTE / time.max(SHORTEST), true))
            }
            (Speed::Time { time, travel, turn }, FeedMode::PerMinute) => {
                let way = if travel > STILL { travel } else { turn.to_degrees() };
                Some((MINUTE * way / time.max(SHORTEST), false))
            }
        }
    }
}

fn angles(rotary: Rotary) -> [(Letter, f64); 2] {
    [(Letter::A, rotary.a.to_degrees()), (Letter::C, rotary.c.to_degrees())]
}

/// Between two unit vectors, rad.
fn angle(a: DVec3, b: DVec3) -> f64 {
    math::atan2(a.cross(b).length(), a.dot(b))
}
