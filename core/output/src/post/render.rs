//! The renderer: points → blocks.

use super::blocks::{Blocks, Letter, Written, cutter, notes};
use super::dialect::{ArcWords, Dialect, FeedMode, Orientation, Position};
use super::error::PostError;
use super::program::{OperationProgram, Program, ProgramOptions};
use super::runs::{MOST, Shape, longest};
use evencut_core::geometry::{DVec3, math};
use evencut_core::machine::{Angles, Axes, Chain, Leg, Tables};
use evencut_core::machine_time::commanded_time;
use evencut_core::toolpath::{MoveKind, PathPoint, Toolpath};
use evencut_core::units::{MINUTE, per_minute};

/// How far below the rapid plane a rapid may be through rounding, mm.
const ROUNDING: f64 = 1e-6;
/// How far below it a point is lifted to it, mm: less is left of rounded angles.
const LOW: f64 = 1e-3;
/// Travel of the tip below which a block is timed by the turn of the axis, mm: a few of the last digits.
const STILL: f64 = 1e-3;
/// How far rounded positions may be beyond the range of a rotary axis, rad.
const TURN_ROUNDING: f64 = 1e-7;
/// Share of the tolerance by which a block may leave the points of its run.
const RUNS: f64 = 0.5;
/// By how much feeds may differ in a run, which has the slowest of them.
const ALIKE: f64 = 0.01;
/// Shortest time of a block, s.
const SHORTEST: f64 = 1e-4;

pub(super) fn render(
    path: &Toolpath,
    options: &ProgramOptions,
    dialect: &Dialect,
) -> Result<Program, PostError> {
    let begin = |blocks: &mut Blocks, notes: &[String]| blocks.header(options, notes);
    let written = written(path, options, dialect, begin, Blocks::end)?;
    Ok(Program { text: written.text, extension: dialect.extension.clone() })
}

/// Several operations as one program, with a change of the tool between them.
pub(super) fn render_all(
    operations: &[OperationProgram],
    dialect: &Dialect,
) -> Result<Program, PostError> {
    let mut cutters: Vec<String> =
        operations.iter().map(|operation| cutter(&operation.options)).collect();
    cutters.dedup();
    let mut done = None;
    for (i, operation) in operations.iter().enumerate() {
        let before = done.take();
        let begin = |blocks: &mut Blocks, notes: &[String]| {
            match before {
                Some(before) => blocks.after(before),
                None => blocks.common_header(&operation.options, &cutters),
            }
            let name = format!("operation {}: {}", i + 1, operation.name);
            blocks.comment(&name);
            notes.iter().for_each(|note| blocks.comment(note));
        };
        let end = if i + 1 < operations.len() { Blocks::change } else { Blocks::end };
        done = Some(written(operation.path, &operation.options, dialect, begin, end)?);
    }
    let text = done.map(|done: Written| done.text).ok_or(PostError::Empty)?;
    Ok(Program { text, extension: dialect.extension.clone() })
}

/// The blocks of a path between those that `begin` and those that `end` it.
fn written<'a>(
    path: &Toolpath,
    options: &'a ProgramOptions,
    dialect: &'a Dialect,
    begin: impl FnOnce(&mut Blocks<'a>, &[String]),
    end: fn(&mut Blocks<'a>),
) -> Result<Written, PostError> {
    check(path, options)?;
    let axes = &options.machine.axes;
    let program = dialect.program(axes)?;
    let form = match (axes, program.position, program.orientation) {
        (Axes::ThreeAxis, ..) => Form::Linear,
        (Axes::FiveAxis(_), Position::Machine, _) => Form::Machine,
        (Axes::FiveAxis(_), Position::Tip, Orientation::Angles) => Form::TipAngles,
        (Axes::FiveAxis(_), Position::Tip, Orientation::Vector) => Form::TipVector,
    };
    let tables = Tables::of(&options.machine, options.tolerance, options.tool.radius());
    let tables =
        tables.map(|tables| tables.keeping_tip(form.keeps_tip())).map(|tables| match form {
            // The controller finds the angles by itself.
            Form::TipVector => tables,
            _ => tables.rounded(dialect.angle_decimals()),
        });
    let mut blocks = Blocks::new(options, dialect)?;
    begin(&mut blocks, &notes(axes, form.keeps_tip()));
    blocks.text.reserve(48 * path.points.len() + 1024);
    blocks.start();
    let reach = [(f64::INFINITY, f64::NEG_INFINITY); 3];
    let (feed_mode, legs) = (program.feed_mode, Vec::new());
    let turned = [Turned::default(); 2];
    let mut writer = Writer { blocks, options, form, feed_mode, tables, reach, turned, legs };
    writer.start(&path.points);
    let arcs = dialect.arcs(axes, options.setup.arcs)?;
    let mut i = 1;
    while i < path.points.len() {
        let run = arcs.and_then(|words| writer.run(&path.points[i - 1..], words));
        match run {
            Some(moves) => i += moves,
            None => {
                writer.step(&path.points[i - 1], &path.points[i..])?;
                i += 1;
            }
        }
    }
    writer.finish(&path.points[path.points.len() - 1], last_feed(&path.points));
    check_travel(&writer.reach, options)?;
    check_turns(&writer.turned, options)?;
    end(&mut writer.blocks);
    Ok(writer.blocks.written())
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
        match options.machine.axes.chain() {
            None if p.axis.distance(DVec3::Z) > 1e-9 => {
                return Err(PostError::TiltedAxis { index, tip: p.tip, axis: p.axis });
            }
            Some(chain) if !chain.reaches(p.axis) => {
                let [first, second] = chain.letters();
                let (tip, axis) = (p.tip, p.axis);
                return Err(PostError::Unreachable { first, second, tip, axis });
            }
            _ => {}
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

/// Whether every rotary axis stays within its range.
fn check_turns(turned: &[Turned; 2], options: &ProgramOptions) -> Result<(), PostError> {
    let Some(chain) = options.machine.axes.chain() else { return Ok(()) };
    let remedies = [
        "it is wound back at retracts only, so let the path retract more often (path.links = \"retract\"), or turn the part about that axis (surface.rotate)",
        "lean less (cut.lead), turn the part (surface.rotate), or choose another machine",
    ];
    for ((axis, turned), remedy) in chain.axes().iter().zip(turned).zip(remedies) {
        let (low, high) = axis.range;
        for &(position, place) in [&turned.least, &turned.greatest].into_iter().flatten() {
            if position < low - TURN_ROUNDING || position > high + TURN_ROUNDING {
                let [position, low, high] = [position, low, high].map(f64::to_degrees);
                return Err(PostError::RotaryTravel {
                    axis: axis.letter,
                    position,
                    low,
                    high,
                    place,
                    remedy,
                });
            }
        }
    }
    Ok(())
}

/// Height of the tip along the tool axis; on centred tables the machine's Z.
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
    /// The tip in the workpiece and the positions of the rotary axes.
    TipAngles,
    /// The tip in the workpiece and the direction of the tool axis.
    TipVector,
}

impl Form {
    /// Whether the controller keeps the tip on its line while the rotary axes turn.
    fn keeps_tip(self) -> bool {
        matches!(self, Self::TipAngles | Self::TipVector)
    }
}

struct Writer<'a> {
    blocks: Blocks<'a>,
    options: &'a ProgramOptions,
    form: Form,
    feed_mode: FeedMode,
    /// `None` on three axes.
    tables: Option<Tables>,
    /// Least and greatest position of each linear axis so far, mm.
    reach: [(f64, f64); 3],
    turned: [Turned; 2],
    /// Of the move that is being written.
    legs: Vec<Leg>,
}

/// Least and greatest position of a rotary axis so far, rad, with the tips there.
#[derive(Copy, Clone, Default)]
struct Turned {
    least: Option<(f64, DVec3)>,
    greatest: Option<(f64, DVec3)>,
}

impl Turned {
    fn extend(&mut self, position: f64, tip: DVec3) {
        if self.least.is_none_or(|(least, _)| position < least) {
            self.least = Some((position, tip));
        }
        if self.greatest.is_none_or(|(greatest, _)| position > greatest) {
            self.greatest = Some((position, tip));
        }
    }
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
    rotary: Angles,
}

impl Place {
    /// Along the tool axis, mm.
    fn height(&self) -> f64 {
        self.tip.dot(self.axis)
    }
}

impl Writer<'_> {
    /// To the first point: up to the rapid plane, across, then down.
    fn start(&mut self, points: &[PathPoint]) {
        let first = &points[0];
        let plane = self.options.rapid_plane;
        self.unwind(points);
        let target = self.place(first);
        let low = Some(plane - target.height()).filter(|low| *low > LOW).unwrap_or(0.0);
        let safe = Place { tip: target.tip + low * target.axis, ..target };
        match self.form {
            // Retracted before, the cutter goes over the first point before it goes down.
            Form::Linear if self.blocks.has_control() => {
                let machine = self.machine(&safe);
                self.blocks.go(None, &[(Letter::X, machine.x), (Letter::Y, machine.y)]);
                self.blocks.control(true);
            }
            // Blocks of which each gives all coordinates cannot go up alone.
            Form::Linear | Form::Machine if self.blocks.repeats_words() => {}
            Form::Linear | Form::Machine => {
                let upright = self.upright(&safe);
                let machine = self.machine(&upright.unwrap_or(safe));
                self.extend(machine);
                self.blocks.go(None, &[(Letter::Z, machine.z)]);
                // A leaning head is lower than an upright one: it turns where the linear axes give way.
                if let (Some(upright), Some(tables)) = (upright, &mut self.tables) {
                    tables.at = upright.rotary;
                    self.block(Speed::Rapid, upright);
                    self.unwind(points);
                    self.rapid(upright.tip, &PathPoint { tip: safe.tip, ..*first });
                }
            }
            // The rotary axes turn before the control follows them.
            Form::TipAngles => {
                let angles = self.angles(safe.rotary);
                self.blocks.go(None, &angles);
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
        let at = Place { tip: last.tip, axis: last.axis, rotary: self.rotary() };
        let low = self.options.rapid_plane - at.height();
        if low > LOW {
            let feed = feed.unwrap_or(self.options.machine.max_feed);
            self.along_axis(Place { tip: at.tip + low * at.axis, ..at }, low, feed);
        }
        if self.form.keeps_tip() {
            self.blocks.control(false);
        }
    }

    /// A move at feed along the tool axis.
    fn along_axis(&mut self, to: Place, travel: f64, feed: f64) {
        let speed = match self.form {
            Form::Linear => Speed::Feed(feed),
            _ => Speed::Time { time: travel / feed, travel, turn: 0.0 },
        };
        self.block(speed, to);
    }

    /// Writes the longest run of moves from the first point that one block will do for; how many they are.
    fn run(&mut self, points: &[PathPoint], words: &ArcWords) -> Option<usize> {
        let (mut least, mut most) = (f64::INFINITY, 0.0f64);
        let is_alike = |p: &&PathPoint| {
            (least, most) = (least.min(p.feed), most.max(p.feed));
            p.kind != MoveKind::Rapid && most - least <= ALIKE * most
        };
        let alike = points[1..].iter().take(MOST).take_while(is_alike).count();
        let tips: Vec<DVec3> = points[..=alike].iter().map(|p| p.tip).collect();
        let (moves, shape) = longest(&tips, RUNS * self.options.tolerance)?;
        let run = &points[1..=moves];
        let feed = run.iter().map(|p| p.feed).fold(f64::INFINITY, f64::min);
        run.iter().for_each(|p| self.extend(p.tip));
        let end = &run[moves - 1];
        match shape {
            Shape::Line => self.block(
                Speed::Feed(feed),
                Place { tip: end.tip, axis: end.axis, rotary: self.rotary() },
            ),
            Shape::Arc { centre, counter_clockwise } => {
                let centre = centre - points[0].tip.truncate();
                let circle = (centre, counter_clockwise);
                self.blocks.go_along(words, per_minute(feed), end.tip, circle);
            }
        }
        Some(moves)
    }

    /// The move from a point of the path to the first of those that follow.
    fn step(&mut self, from: &PathPoint, rest: &[PathPoint]) -> Result<(), PostError> {
        let to = &rest[0];
        let Some(tables) = &mut self.tables else {
            let speed = match to.kind {
                MoveKind::Rapid => Speed::Rapid,
                _ => Speed::Feed(to.feed),
            };
            let place = self.place(to);
            self.block(speed, place);
            return Ok(());
        };
        if to.kind == MoveKind::Rapid {
            self.unwind(rest);
            self.rapid(from.tip, to);
            return Ok(());
        }
        let time = commanded_time(from, to, &self.options.tool, &self.options.machine);
        if self.form == Form::TipVector {
            let least = tables.turn(to.axis);
            let place = Place { tip: to.tip, axis: to.axis, rotary: tables.at };
            let travel = from.tip.distance(to.tip);
            let turn = angle(from.axis, to.axis);
            self.block(Speed::Time { time: time.max(least), travel, turn }, place);
            return Ok(());
        }
        self.legs(from, to, time)
    }

    /// A move at feed with the positions of the rotary axes.
    fn legs(&mut self, from: &PathPoint, to: &PathPoint, time: f64) -> Result<(), PostError> {
        let Some(tables) = &mut self.tables else { return Ok(()) };
        let mut legs = core::mem::take(&mut self.legs);
        legs.clear();
        let chain = tables.chain;
        let mut before = Place { tip: from.tip, axis: from.axis, rotary: tables.at };
        let ends = ((from.tip, from.axis), (to.tip, to.axis));
        let gone = tables.go(ends.0, ends.1, time, &mut legs);
        let (tolerance, axis) = (self.options.tolerance, chain.letters()[0]);
        gone.map_err(|place| PostError::Singular { place, tolerance, axis })?;
        for leg in &legs {
            let rotary = leg.rotary;
            let (tip, axis) = (chain.to_part(leg.to, rotary), chain.axis(rotary));
            let place = Place { tip, axis, rotary };
            let travel = before.tip.distance(place.tip);
            let turn = chain.turn(before.rotary, rotary);
            self.block(Speed::Time { time: leg.time, travel, turn }, place);
            before = place;
        }
        self.legs = legs;
        Ok(())
    }

    /// A rapid above part and stock, of which the height along the tool axis never falls below those at its ends.
    fn rapid(&mut self, from: DVec3, to: &PathPoint) {
        let Some(tables) = &mut self.tables else { return };
        let chain = tables.chain;
        for (tip, rotary) in tables.turn_straight(from, (to.tip, to.axis)) {
            let axis = if tip == to.tip { to.axis } else { chain.axis(rotary) };
            self.block(Speed::Rapid, Place { tip, axis, rotary });
        }
    }

    /// Keeps the rotary axes within their ranges until the next rapid, if a turn by whole windings does.
    fn unwind(&mut self, from: &[PathPoint]) {
        let Some(tables) = &mut self.tables else { return };
        let stretch = from[1..].iter().take_while(|p| p.kind != MoveKind::Rapid);
        tables.unwind(from[..1].iter().chain(stretch).map(|p| p.axis));
    }

    /// Turns the rotary axes for a point.
    fn place(&mut self, p: &PathPoint) -> Place {
        if let Some(tables) = &mut self.tables {
            tables.turn(p.axis);
        }
        Place { tip: p.tip, axis: p.axis, rotary: self.rotary() }
    }

    /// Where the rotary axes stand.
    fn rotary(&self) -> Angles {
        self.tables.map_or([0.0; 2], |tables| tables.at)
    }

    fn chain(&self) -> Option<&Chain> {
        self.tables.as_ref().map(|tables| &tables.chain)
    }

    /// Positions of the linear axes.
    fn machine(&self, place: &Place) -> DVec3 {
        self.chain().map_or(place.tip, |chain| chain.to_machine(place.tip, place.rotary))
    }

    /// Over a place with all rotary axes at zero, on machines on which they carry the tip up or down.
    fn upright(&self, place: &Place) -> Option<Place> {
        let chain = self.chain().filter(|chain| !chain.is_centred())?;
        let rotary = [0.0; 2];
        let axis = chain.axis(rotary);
        let low = self.options.rapid_plane - place.tip.dot(axis);
        Some(Place { tip: place.tip + low.max(0.0) * axis, axis, rotary })
    }

    /// Words of the rotary axes, in the order of their letters.
    fn angles(&self, at: Angles) -> Vec<(Letter, f64)> {
        let Some(chain) = self.chain() else { return Vec::new() };
        let letter = |i: usize| match chain.letters()[i] {
            'A' => Letter::A,
            'B' => Letter::B,
            _ => Letter::C,
        };
        let order = if chain.letters()[0] < chain.letters()[1] { [0, 1] } else { [1, 0] };
        order.map(|i| (letter(i), at[i].to_degrees())).to_vec()
    }

    fn extend(&mut self, machine: DVec3) {
        for (reach, p) in self.reach.iter_mut().zip(machine.to_array()) {
            *reach = (reach.0.min(p), reach.1.max(p));
        }
    }

    /// Writes a block that ends at a place.
    fn block(&mut self, speed: Speed, to: Place) {
        let machine = self.machine(&to);
        self.extend(machine);
        for (turned, position) in self.turned.iter_mut().zip(to.rotary) {
            turned.extend(position, to.tip);
        }
        let linear = |p: DVec3| [(Letter::X, p.x), (Letter::Y, p.y), (Letter::Z, p.z)];
        let feed = self.feed(speed);
        match self.form {
            Form::Linear => self.blocks.go(feed, &linear(to.tip)),
            Form::Machine | Form::TipAngles => {
                let position = if self.form == Form::Machine { machine } else { to.tip };
                let mut words = linear(position).to_vec();
                words.extend(self.angles(to.rotary));
                self.blocks.go(feed, &words);
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

/// Between two unit vectors, rad.
fn angle(a: DVec3, b: DVec3) -> f64 {
    math::atan2(a.cross(b).length(), a.dot(b))
}
