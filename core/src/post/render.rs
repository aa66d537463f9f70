//! The renderer: points → blocks, with unchanged words left out.

use super::dialect::Dialect;
use super::error::PostError;
use super::program::{Program, ProgramOptions};
use crate::geometry::DVec3;
use crate::machine::{Axes, Leg, Rotary, Tables};
use crate::machine_time::commanded_time;
use crate::toolpath::{MoveKind, PathPoint, Toolpath, push_fixed};
use crate::units::{MINUTE, per_minute};

/// How far below the rapid plane a rapid may be through rounding, mm.
const ROUNDING: f64 = 1e-6;

pub(super) fn render(
    path: &Toolpath,
    options: &ProgramOptions,
    dialect: &Dialect,
) -> Result<Program, PostError> {
    check(path, options)?;
    let mut text = String::with_capacity(48 * path.points.len() + 1024);
    header(&mut text, options, dialect);
    let tables = Tables::new(&options.machine, options.tolerance, options.tool.radius());
    let tables = tables.rounded(dialect.decimals[1]);
    let reach = [(f64::INFINITY, f64::NEG_INFINITY); 3];
    let mut writer = Writer {
        text,
        options,
        dialect,
        tables,
        modal: Default::default(),
        reach,
        legs: Vec::new(),
    };
    writer.start(&path.points)?;
    for pair in path.points.windows(2) {
        writer.step(&pair[0], &pair[1])?;
    }
    writer.finish(&path.points[path.points.len() - 1], last_feed(&path.points));
    check_travel(&writer.reach, options)?;
    Ok(Program { text: writer.text, extension: dialect.extension })
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

fn header(text: &mut String, options: &ProgramOptions, dialect: &Dialect) {
    let tool = &options.tool;
    let kind = tool.kind().name();
    let mut cutter = format!("tool {}: {kind} end mill, diameter ", options.tool_number);
    push_fixed(&mut cutter, 2.0 * tool.radius(), 4);
    cutter.push_str(" corner radius ");
    push_fixed(&mut cutter, tool.corner_radius(), 4);
    let name = format!("job: {}", options.name);
    let mut comments = vec!["evencut", &name, &cutter, "mm, tool tip programmed"];
    if options.machine.axes == Axes::Xyzac {
        comments.push("table A about X carries table C about Z, centre at program zero");
        comments.push("machine coordinates: run with trivial kinematics, tool centre control off");
    }
    for comment in comments {
        text.push_str(dialect.comment[0]);
        text.extend(comment.chars().take(100).map(plain));
        text.push_str(dialect.comment[1]);
        text.push('\n');
    }
    for block in dialect.preamble {
        text.push_str(&filled(block, options, dialect));
        text.push('\n');
    }
}

/// A character that means nothing to a controller inside a comment.
fn plain(c: char) -> char {
    let harmless = c.is_ascii_alphanumeric() || " .,:-+_=/".contains(c);
    if harmless { c } else { '_' }
}

fn filled(block: &str, options: &ProgramOptions, dialect: &Dialect) -> String {
    let number = |value: f64, decimals: u32| {
        let mut out = String::new();
        push_fixed(&mut out, value, decimals);
        out
    };
    let feed_mode = match options.machine.axes {
        Axes::ThreeAxis => dialect.feed_per_minute,
        Axes::Xyzac => dialect.inverse_time,
    };
    block
        .replace("{tolerance}", &number(options.tolerance, 4))
        .replace("{tool}", &options.tool_number.to_string())
        .replace("{speed}", &number(per_minute(options.spindle), 0))
        .replace("{feed_mode}", feed_mode)
}

/// What the controller remembers, as written.
#[derive(Default)]
struct Modal {
    motion: Option<bool>,
    words: [String; 5],
    feed: String,
}

struct Writer<'a> {
    text: String,
    options: &'a ProgramOptions,
    dialect: &'a Dialect,
    tables: Tables,
    modal: Modal,
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
    /// Time of the block, s.
    Time(f64),
}

impl Writer<'_> {
    /// To the first point: up to the rapid plane, across, then down.
    fn start(&mut self, points: &[PathPoint]) -> Result<(), PostError> {
        let first = &points[0];
        let plane = self.options.rapid_plane;
        let target = self.place(first);
        let safe = target.z.max(plane);
        self.block(Speed::Rapid, [None, None, Some(safe)], None);
        self.block(
            Speed::Rapid,
            [Some(target.x), Some(target.y), Some(safe)],
            Some(self.tables.at),
        );
        if target.z < plane - ROUNDING {
            let feed = feed_of(points[1..].iter()).unwrap_or(self.options.machine.max_feed);
            self.vertical(target, safe - target.z, feed);
        }
        Ok(())
    }

    fn finish(&mut self, last: &PathPoint, feed: Option<f64>) {
        let plane = self.options.rapid_plane;
        let at = self.tables.at.to_machine(last.tip);
        if at.z < plane - ROUNDING {
            let feed = feed.unwrap_or(self.options.machine.max_feed);
            self.vertical(DVec3::new(at.x, at.y, plane), plane - at.z, feed);
        }
        for block in self.dialect.ending {
            self.text.push_str(block);
            self.text.push('\n');
        }
    }

    /// A move at feed along the machine's Z.
    fn vertical(&mut self, target: DVec3, length: f64, feed: f64) {
        let speed = match self.options.machine.axes {
            Axes::ThreeAxis => Speed::Feed(feed),
            Axes::Xyzac => Speed::Time(length / feed),
        };
        self.block(speed, target.to_array().map(Some), Some(self.tables.at));
    }

    /// The move between two points of the path.
    fn step(&mut self, from: &PathPoint, to: &PathPoint) -> Result<(), PostError> {
        if to.kind == MoveKind::Rapid {
            let target = self.place(to);
            self.block(Speed::Rapid, target.to_array().map(Some), Some(self.tables.at));
            return Ok(());
        }
        if self.options.machine.axes == Axes::ThreeAxis {
            self.block(Speed::Feed(to.feed), to.tip.to_array().map(Some), None);
            return Ok(());
        }
        let time = commanded_time(from, to, &self.options.tool, &self.options.machine);
        let mut legs = core::mem::take(&mut self.legs);
        legs.clear();
        let tolerance = self.options.tolerance;
        let ends = ((from.tip, from.axis), (to.tip, to.axis));
        let gone = self.tables.go(ends.0, ends.1, time, &mut legs);
        gone.map_err(|place| PostError::Singular { place, tolerance })?;
        for leg in &legs {
            self.block(Speed::Time(leg.time), leg.to.to_array().map(Some), Some(leg.rotary));
        }
        self.legs = legs;
        Ok(())
    }

    /// Turns the tables for a point and gives its machine coordinates.
    fn place(&mut self, p: &PathPoint) -> DVec3 {
        if self.options.machine.axes == Axes::ThreeAxis {
            return p.tip;
        }
        self.tables.turn(p.axis);
        self.tables.at.to_machine(p.tip)
    }

    /// Writes a block of the words that change; `None` leaves a coordinate, or the tables, alone.
    fn block(&mut self, speed: Speed, position: [Option<f64>; 3], tables: Option<Rotary>) {
        let [lengths, angles, feeds] = self.dialect.decimals;
        for (reach, p) in self.reach.iter_mut().zip(position) {
            *reach = (reach.0.min(p.unwrap_or(reach.0)), reach.1.max(p.unwrap_or(reach.1)));
        }
        let rotary = match (self.options.machine.axes, tables) {
            (Axes::Xyzac, Some(Rotary { a, c })) => [Some(a.to_degrees()), Some(c.to_degrees())],
            _ => [None, None],
        };
        let values = position.into_iter().chain(rotary);
        let mut moved = String::new();
        for (i, value) in values.enumerate() {
            let Some(value) = value else { continue };
            let mut word = String::with_capacity(16);
            word.push(['X', 'Y', 'Z', 'A', 'C'][i]);
            push_fixed(&mut word, value, if i < 3 { lengths } else { angles });
            if word != self.modal.words[i] {
                moved.push(' ');
                moved.push_str(&word);
                self.modal.words[i] = word;
            }
        }
        if moved.is_empty() {
            return;
        }
        let feeding = !matches!(speed, Speed::Rapid);
        let mut block = String::with_capacity(48);
        if self.modal.motion != Some(feeding) {
            self.modal.motion = Some(feeding);
            block.push_str(if feeding { self.dialect.feed } else { self.dialect.rapid });
        }
        block.push_str(&moved);
        let mut feed = String::new();
        match speed {
            Speed::Rapid => {}
            Speed::Feed(feed_rate) => push_fixed(&mut feed, per_minute(feed_rate), feeds),
            // Each block is timed by itself; a move too short to time takes a tenth of a ms.
            Speed::Time(time) => push_fixed(&mut feed, MINUTE / time.max(1e-4), feeds),
        }
        let always = matches!(speed, Speed::Time(_));
        if feeding && (always || feed != self.modal.feed) {
            block.push_str(" F");
            block.push_str(&feed);
            self.modal.feed = feed;
        }
        self.text.push_str(block.trim_start());
        self.text.push('\n');
    }
}
