//! Lines of a program: names filled in, numbers formatted, unchanged words left out.

use super::dialect::{ArcWords, Decimals, Dialect, Motion, Program};
use super::error::DialectError;
use super::program::ProgramOptions;
use evencut_core::geometry::{DVec2, DVec3};
use evencut_core::machine::{Axes, Carries, RotaryAxis, SpindleDirection};
use evencut_core::toolpath::push_fixed;
use evencut_core::units::per_minute;

/// Longest comment, characters.
const LONGEST_COMMENT: usize = 100;
/// Longest name of a job in a block, characters.
const LONGEST_NAME: usize = 24;

/// What a number is of.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub(super) enum Quantity {
    Length,
    Angle,
    Vector,
}

/// A coordinate that a block gives.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub(super) enum Letter {
    X,
    Y,
    Z,
    A,
    B,
    C,
    I,
    J,
    K,
}

/// The lines of a program that is being written.
pub(super) struct Blocks<'a> {
    pub text: String,
    dialect: &'a Dialect,
    program: &'a Program,
    fields: [(&'static str, Option<String>); 14],
    /// Of the next block.
    number: u32,
    modal: Modal,
}

/// What is written of a program.
pub(super) struct Written {
    pub text: String,
    /// Of the next block.
    number: u32,
}

/// What the controller remembers, as written.
#[derive(Default)]
struct Modal {
    motion: String,
    words: [String; 9],
    feed: String,
}

impl<'a> Blocks<'a> {
    /// # Errors
    /// [`DialectError`] if the post has no words for the setup.
    pub fn new(options: &ProgramOptions, dialect: &'a Dialect) -> Result<Self, DialectError> {
        let program = dialect.program(&options.machine.axes)?;
        let setup = &options.setup;
        let length = |value: f64| number(value, dialect.decimals.length, &dialect.decimals);
        let plain = |value: f64, decimals: u32| {
            let mut out = String::new();
            push_fixed(&mut out, value, decimals);
            out
        };
        let coolant = dialect.coolant(setup.coolant)?;
        let spindle = match setup.spindle {
            SpindleDirection::Clockwise => &dialect.spindle.clockwise,
            SpindleDirection::CounterClockwise => &dialect.spindle.counter_clockwise,
        };
        let fields = [
            ("program", Some(format!("{:04}", setup.program_number))),
            ("job", Some(identifier(&options.name))),
            ("tool", Some(setup.tool_number.to_string())),
            ("length_offset", Some(setup.length_offset.to_string())),
            ("diameter_offset", Some(setup.diameter_offset.to_string())),
            ("diameter", Some(plain(2.0 * options.tool.radius(), 4))),
            ("corner_radius", Some(plain(options.tool.corner_radius(), 4))),
            ("speed", Some(plain(per_minute(options.spindle), 0))),
            ("spindle", Some(spindle.clone())),
            ("coolant_on", coolant.map(|[on, _]| on.clone())),
            ("coolant_off", coolant.map(|[_, off]| off.clone())),
            ("work_offset", dialect.work_offset(setup.work_offset)?.cloned()),
            ("tolerance", Some(plain(options.tolerance, 4))),
            ("rapid_plane", Some(length(options.rapid_plane))),
        ];
        let number = dialect.line_numbers.as_ref().map_or(0, |numbers| numbers.first);
        let (text, modal) = (String::new(), Modal::default());
        Ok(Self { text, dialect, program, fields, number, modal })
    }

    /// The first lines: what the program is, for whom reads it.
    pub fn header(&mut self, options: &ProgramOptions, notes: &[String]) {
        self.fixed(&self.dialect.first, false);
        let name = format!("job: {}", options.name);
        let own = ["evencut", &name, &cutter(options), "mm, tool tip programmed"];
        own.into_iter().chain(notes.iter().map(String::as_str)).for_each(|c| self.comment(c));
    }

    /// The first lines of a program of several operations; `cutters`: with what each is made.
    pub fn common_header(&mut self, options: &ProgramOptions, cutters: &[String]) {
        self.fixed(&self.dialect.first, false);
        let name = format!("job: {}", options.name);
        let own = ["evencut", &name, "mm, tool tip programmed"];
        own.into_iter().chain(cutters.iter().map(String::as_str)).for_each(|c| self.comment(c));
    }

    /// A line for whom reads the program.
    pub fn comment(&mut self, comment: &str) {
        let [open, close] = &self.dialect.comment;
        let clean: String = comment.chars().take(LONGEST_COMMENT).map(harmless).collect();
        self.line(&format!("{open}{clean}{close}"), false);
    }

    /// Goes on with what another operation has written.
    pub fn after(&mut self, written: Written) {
        (self.text, self.number) = (written.text, written.number);
    }

    /// What is written, to go on with another operation.
    pub fn written(self) -> Written {
        Written { text: self.text, number: self.number }
    }

    /// The blocks between two operations.
    pub fn change(&mut self) {
        self.fixed(&self.program.change, true);
    }

    /// The blocks before the first move.
    pub fn start(&mut self) {
        self.fixed(&self.program.start, true);
    }

    /// Whether there are blocks between the approach and the descent.
    pub fn has_control(&self) -> bool {
        !self.program.control_on.is_empty()
    }

    /// Whether every block gives all coordinates.
    pub fn repeats_words(&self) -> bool {
        self.program.repeat_words
    }

    /// Tool centre control on, or off.
    pub fn control(&mut self, on: bool) {
        let blocks = if on { &self.program.control_on } else { &self.program.control_off };
        self.fixed(blocks, true);
        // The same numbers mean another place now.
        self.modal.words = Default::default();
    }

    /// The blocks after the last move.
    pub fn end(&mut self) {
        self.fixed(&self.program.end, true);
        self.fixed(&self.dialect.last, false);
    }

    /// Writes a move: of the coordinates those that change; `feed`: as its word gives it, and whether it is to be
    /// written even if it does not change. `None` is a rapid.
    pub fn go(&mut self, feed: Option<(f64, bool)>, coordinates: &[(Letter, f64)]) {
        let moved = self.moved(coordinates);
        if moved.is_empty() {
            return;
        }
        let own = if feed.is_some() { &self.program.feed } else { &self.program.rapid };
        let common = if feed.is_some() { &self.dialect.feed } else { &self.dialect.rapid };
        let motion = own.as_ref().unwrap_or(common);
        let is_new = core::mem::replace(&mut self.modal.motion, motion.clone()) != *motion;
        let feed = match feed {
            None => self.dialect.rapid_feed.clone(),
            Some((feed, always)) => self.feed_word(feed, always),
        };
        let separator = &self.dialect.separator;
        let position = format!("{}{}", self.dialect.position, moved.join(separator));
        let motion = if is_new || self.dialect.motion != Motion::Modal { motion } else { "" };
        let parts = [motion, &position, &feed];
        if self.dialect.motion == Motion::OwnLine {
            for part in [parts[0], parts[2], parts[1]].into_iter().filter(|part| !part.is_empty()) {
                self.line(part, true);
            }
            return;
        }
        let words: Vec<&str> = parts.into_iter().filter(|part| !part.is_empty()).collect();
        self.line(&words.join(separator), true);
    }

    /// The feed word, if it changes, or `always`.
    fn feed_word(&mut self, feed: f64, always: bool) -> String {
        let places = self.dialect.decimals.feed;
        // No feed is written as 0, which no controller moves at.
        let least = 1.0 / 10_u64.pow(places) as f64;
        let value = number(feed.max(least), places, &unsigned(self.dialect));
        let word = self.dialect.words.feed.replace("{}", &value);
        let changes = self.modal.feed != word;
        self.modal.feed = word;
        if always || changes { self.modal.feed.clone() } else { String::new() }
    }

    /// Writes a move along an arc to a place; `centre`: as seen from where it begins, mm; `feed`: as its word gives it.
    pub fn go_along(
        &mut self,
        words: &ArcWords,
        feed: f64,
        to: DVec3,
        (centre, counter_clockwise): (DVec2, bool),
    ) {
        let z = self.moved(&[(Letter::Z, to.z)]);
        self.moved(&[(Letter::X, to.x), (Letter::Y, to.y)]);
        let word = |letter: Letter| self.modal.words[letter as usize].clone();
        let mut position = vec![word(Letter::X), word(Letter::Y)];
        position.extend(z);
        for (word, value) in [(&words.i, centre.x), (&words.j, centre.y)] {
            position.push(word.replace("{}", &self.number(value, Quantity::Length)));
        }
        let motion = if counter_clockwise { &words.counter_clockwise } else { &words.clockwise };
        self.modal.motion.clone_from(motion);
        let feed = self.feed_word(feed, false);
        let separator = &self.dialect.separator;
        let position = format!("{}{}", self.dialect.position, position.join(separator));
        let parts = [motion.as_str(), &position, &feed];
        let parts: Vec<&str> = parts.into_iter().filter(|part| !part.is_empty()).collect();
        self.line(&parts.join(separator), true);
    }

    /// The words of coordinates that change.
    fn moved(&mut self, coordinates: &[(Letter, f64)]) -> Vec<String> {
        let words = &self.dialect.words;
        let mut moved = Vec::with_capacity(coordinates.len());
        let mut changes = false;
        for &(letter, value) in coordinates {
            let (word, quantity) = match letter {
                Letter::X => (Some(&words.x), Quantity::Length),
                Letter::Y => (Some(&words.y), Quantity::Length),
                Letter::Z => (Some(&words.z), Quantity::Length),
                Letter::A => (words.a.as_ref(), Quantity::Angle),
                Letter::B => (words.b.as_ref(), Quantity::Angle),
                Letter::C => (words.c.as_ref(), Quantity::Angle),
                Letter::I => (words.i.as_ref(), Quantity::Vector),
                Letter::J => (words.j.as_ref(), Quantity::Vector),
                Letter::K => (words.k.as_ref(), Quantity::Vector),
            };
            // A post without the words that it needs is refused when it is read.
            let Some(word) = word else { continue };
            let word = word.replace("{}", &self.number(value, quantity));
            let before = &mut self.modal.words[letter as usize];
            let is_same = word == *before;
            changes |= !is_same;
            if !is_same || self.program.repeat_words {
                moved.push(word.clone());
            }
            *before = word;
        }
        if changes { moved } else { Vec::new() }
    }

    fn number(&self, value: f64, quantity: Quantity) -> String {
        let decimals = &self.dialect.decimals;
        let places = match quantity {
            Quantity::Length => decimals.length,
            Quantity::Angle => decimals.angle,
            Quantity::Vector => decimals.vector,
        };
        number(value, places, decimals)
    }

    /// Blocks of the post, those left out of which a name has no value.
    fn fixed(&mut self, blocks: &[String], counts: bool) {
        for block in blocks {
            let mut filled = block.clone();
            let is_whole = self.fields.iter().all(|(name, value)| {
                let name = format!("{{{name}}}");
                let asked = filled.contains(&name);
                if let (true, Some(value)) = (asked, value) {
                    filled = filled.replace(&name, value);
                }
                !asked || value.is_some()
            });
            if is_whole {
                self.line(&filled, counts);
            }
        }
    }

    /// A line; `counts`: whether it is a block, which has a number if blocks have.
    fn line(&mut self, line: &str, counts: bool) {
        if let Some(numbers) = self.dialect.line_numbers.as_ref().filter(|n| counts || n.all) {
            self.text.push_str(&format!("{}{} ", numbers.prefix, self.number));
            self.number = self.number.saturating_add(numbers.step);
        }
        self.text.push_str(line);
        self.text.push('\n');
    }
}

/// The cutter of a program, in words.
pub(super) fn cutter(options: &ProgramOptions) -> String {
    let tool = &options.tool;
    let (number, kind) = (options.setup.tool_number, tool.kind().name());
    let mut cutter = format!("tool {number}: {kind} end mill, diameter ");
    push_fixed(&mut cutter, 2.0 * tool.radius(), 4);
    cutter.push_str(" corner radius ");
    push_fixed(&mut cutter, tool.corner_radius(), 4);
    cutter
}

/// A feed has no sign.
fn unsigned(dialect: &Dialect) -> Decimals {
    Decimals { plus: false, ..dialect.decimals.clone() }
}

/// A number as the controller is given it.
fn number(value: f64, places: u32, decimals: &Decimals) -> String {
    let mut out = String::with_capacity(16);
    push_fixed(&mut out, value, places);
    if decimals.plus && !out.starts_with('-') {
        out.insert(0, '+');
    }
    if decimals.trimmed && out.contains('.') {
        out.truncate(out.trim_end_matches('0').len());
    }
    out
}

/// A character that means nothing to a controller inside a comment.
fn harmless(c: char) -> char {
    let is_harmless = c.is_ascii_alphanumeric() || " .,:-+_=/".contains(c);
    if is_harmless { c } else { '_' }
}

/// A name of letters, digits, - and _.
fn identifier(name: &str) -> String {
    let clean = |c: char| if c.is_ascii_alphanumeric() || c == '-' { c } else { '_' };
    let name: String = name.chars().take(LONGEST_NAME).map(clean).collect();
    if name.is_empty() { "evencut".to_string() } else { name }
}

/// What is to be known of a program for five axes.
pub(super) fn notes(axes: &Axes, keeps_tip: bool) -> Vec<String> {
    let Some(chain) = axes.chain() else { return Vec::new() };
    let place = |p: DVec3| format!("{:.3} {:.3} {:.3}", p.x, p.y, p.z);
    let axis = |axis: &RotaryAxis| {
        let (what, from) = match axis.carries {
            Carries::Table => ("table", "program zero"),
            Carries::Head => ("head", "the gauge line"),
        };
        let about = match axis.direction {
            DVec3::X => "X".to_string(),
            DVec3::Y => "Y".to_string(),
            DVec3::Z => "Z".to_string(),
            direction => place(direction),
        };
        format!("{what} {} about {about}, centre {} from {from}", axis.letter, place(axis.centre))
    };
    let mut notes = vec!["rotary axes, the one nearest to the workpiece first:".to_string()];
    notes.extend(chain.axes().iter().map(axis));
    let (length, heads) = (chain.gauge_length(), chain.has_heads() && !keeps_tip);
    if heads {
        notes.push(format!(
            "tip to gauge line {length:.3}: a tool of another length needs another program"
        ));
    }
    notes.push(match keeps_tip {
        true => "workpiece coordinates: they turn with tables, tool centre control on".to_string(),
        false => {
            "machine coordinates: run with trivial kinematics, tool centre control off".to_string()
        }
    });
    notes
}
