//! A post-processor as data: what differs between controllers.

use super::error::DialectError;
use super::keys::{Keys, KeysError, read_keys};
use evencut_core::machine::{Axes, Coolant, Post, WorkOffset};
use std::collections::BTreeMap;

/// Most decimals of a number.
const MOST_DECIMALS: u32 = 9;
/// Longest text of a block, characters.
const LONGEST: usize = 200;

/// What `{name}` may stand for in a block.
pub(super) const FIELDS: [&str; 14] = [
    "program",
    "job",
    "tool",
    "length_offset",
    "diameter_offset",
    "diameter",
    "corner_radius",
    "speed",
    "spindle",
    "coolant_on",
    "coolant_off",
    "work_offset",
    "tolerance",
    "rapid_plane",
];

/// A post-processor: how the program of a controller is written. `docs/posts.md` has its keys.
///
/// In the blocks `{name}` is replaced, and a block of which a `{name}` has no value is left out.
#[derive(Clone, Debug, PartialEq)]
pub struct Dialect {
    /// Its name.
    pub(super) name: String,
    /// Of the program's file, without a point.
    pub(super) extension: String,
    /// What opens and closes a comment.
    pub(super) comment: [String; 2],
    /// Blocks before the comments at the top, and after all others.
    pub(super) first: Vec<String>,
    pub(super) last: Vec<String>,
    pub(super) line_numbers: Option<LineNumbers>,
    /// Where the words of motion stand.
    pub(super) motion: Motion,
    /// What begins a block at rapid speed, and one at feed.
    pub(super) rapid: String,
    pub(super) feed: String,
    /// Word of the feed in a block at rapid speed.
    pub(super) rapid_feed: String,
    /// Stands before the coordinates.
    pub(super) position: String,
    /// Stands between words.
    pub(super) separator: String,
    pub(super) decimals: Decimals,
    pub(super) words: Words,
    pub(super) spindle: Spindle,
    /// Blocks along arcs in the plane XY; `None` where there are none.
    pub(super) arc: Option<ArcWords>,
    /// The word for each kind of coolant, and for `off`; `air-off` and its like where that has a word of its own.
    pub(super) coolant: BTreeMap<String, String>,
    /// The word for each work offset, G54 to G59.3.
    pub(super) work_offset: BTreeMap<String, String>,
    pub(super) three_axis: Option<Program>,
    pub(super) five_axis: Option<Program>,
}

/// Numbers of blocks.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct LineNumbers {
    pub prefix: String,
    pub first: u32,
    pub step: u32,
    /// Whether `first`, `last` and comments have them, too.
    pub all: bool,
}

/// Where the words of motion stand.
#[derive(Copy, Clone, Debug, PartialEq, Eq, Default)]
pub(super) enum Motion {
    /// Before the coordinates, where they change.
    #[default]
    Modal,
    /// Before the coordinates of every block.
    EveryBlock,
    /// With the feed on lines of their own, before the line of the coordinates.
    OwnLine,
}

/// How numbers are written.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Decimals {
    /// Of lengths in mm.
    pub length: u32,
    /// Of angles in degrees.
    pub angle: u32,
    /// Of the direction of the tool axis.
    pub vector: u32,
    /// Of feeds in mm/min and in 1/min.
    pub feed: u32,
    /// Whether positive numbers have a sign.
    pub plus: bool,
    /// Whether zeros at the end are left out: `1.5` and `2.` instead of `1.5000` and `2.0000`.
    pub trimmed: bool,
}

/// Words of coordinates and feed; `{}` is the number.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Words {
    pub x: String,
    pub y: String,
    pub z: String,
    /// Positions of the rotary axes.
    pub a: Option<String>,
    pub b: Option<String>,
    pub c: Option<String>,
    /// Direction of the tool axis.
    pub i: Option<String>,
    pub j: Option<String>,
    pub k: Option<String>,
    pub feed: String,
}

/// Words of a block along an arc.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct ArcWords {
    pub clockwise: String,
    pub counter_clockwise: String,
    /// Of the way from the beginning to the centre.
    pub i: String,
    pub j: String,
}

/// Words for the direction of the spindle.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Spindle {
    pub clockwise: String,
    pub counter_clockwise: String,
}

/// What differs with the axes of the machine.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Program {
    /// Blocks before the first move.
    pub start: Vec<String>,
    /// Blocks that turn tool centre control on and off, where the tip is programmed; on three axes those that take up
    /// the tool's length, once the cutter stands over the first point.
    pub control_on: Vec<String>,
    pub control_off: Vec<String>,
    /// Blocks between the last move of an operation and the `start` of the next one; none where a program has one tool.
    pub change: Vec<String>,
    /// Blocks after the last move.
    pub end: Vec<String>,
    /// Instead of those of the post.
    pub rapid: Option<String>,
    pub feed: Option<String>,
    pub position: Position,
    pub orientation: Orientation,
    pub feed_mode: FeedMode,
    /// Whether words that do not change are written all the same.
    pub repeat_words: bool,
}

/// What coordinates are those of.
#[derive(Copy, Clone, Debug, PartialEq, Eq, Default)]
pub(super) enum Position {
    /// Positions of the machine's axes.
    #[default]
    Machine,
    /// The tip in the workpiece.
    Tip,
}

/// How the tool axis is written.
#[derive(Copy, Clone, Debug, PartialEq, Eq, Default)]
pub(super) enum Orientation {
    /// By the positions of the rotary axes.
    #[default]
    Angles,
    /// By its direction in the workpiece.
    Vector,
}

/// What the feed word says.
#[derive(Copy, Clone, Debug, PartialEq, Eq, Default)]
pub(super) enum FeedMode {
    /// Speed of the tip, mm/min; where only the tool axis turns, degrees/min.
    #[default]
    PerMinute,
    /// How often the block could be run in a minute.
    InverseTime,
}

impl Dialect {
    /// One of those that come along.
    ///
    /// # Errors
    /// [`DialectError`], which a test rules out.
    pub fn of(post: Post) -> Result<Self, DialectError> {
        Self::read(Self::source(post).as_bytes())
    }

    /// The file of one of those that come along, TOML: to be copied and changed.
    pub fn source(post: Post) -> &'static str {
        match post {
            Post::LinuxCnc => include_str!("../../../posts/linuxcnc.toml"),
            Post::Fanuc => include_str!("../../../posts/fanuc.toml"),
            Post::Haas => include_str!("../../../posts/haas.toml"),
            Post::Siemens => include_str!("../../../posts/siemens.toml"),
            Post::Heidenhain => include_str!("../../../posts/heidenhain.toml"),
            Post::Grbl => include_str!("../../../posts/grbl.toml"),
            Post::Cldata => include_str!("../../../posts/cldata.toml"),
        }
    }

    /// Reads a post's file.
    ///
    /// # Errors
    /// [`DialectError`]: no TOML, an unknown or missing key, a value out of its range.
    pub fn read(bytes: &[u8]) -> Result<Self, DialectError> {
        let dialect = read_keys(bytes, Self::of_table)?;
        dialect.validate()?;
        Ok(dialect)
    }

    fn of_table(keys: &mut Keys) -> Result<Self, KeysError> {
        let program = |keys: &mut Keys, name| keys.table(name, Program::of_table);
        let dialect = Self {
            name: keys.text("name")?,
            extension: keys.text("extension")?,
            comment: match &keys.texts("comment")?[..] {
                [open, close] => [open.clone(), close.clone()],
                _ => return Err(keys.fault("comment", "it must be two texts, before and after")),
            },
            first: keys.texts("first")?,
            last: keys.texts("last")?,
            line_numbers: keys.table("line_numbers", LineNumbers::of_table)?,
            motion: keys.choice(
                "motion",
                &[
                    ("modal", Motion::Modal),
                    ("every-block", Motion::EveryBlock),
                    ("own-line", Motion::OwnLine),
                ],
            )?,
            rapid: keys.text("rapid")?,
            feed: keys.text("feed")?,
            rapid_feed: keys.optional("rapid_feed")?.unwrap_or_default(),
            position: keys.optional("position")?.unwrap_or_default(),
            separator: keys.optional("separator")?.unwrap_or_else(|| " ".to_string()),
            decimals: keys.required("decimals", Decimals::of_table)?,
            words: keys.required("words", Words::of_table)?,
            spindle: keys.required("spindle", Spindle::of_table)?,
            arc: keys.table("arc", ArcWords::of_table)?,
            coolant: keys.table("coolant", |texts| texts.all_texts())?.unwrap_or_default(),
            work_offset: keys.table("work_offset", |texts| texts.all_texts())?.unwrap_or_default(),
            three_axis: program(keys, "three_axis")?,
            five_axis: program(keys, "five_axis")?,
        };
        keys.nothing_left()?;
        Ok(dialect)
    }

    /// Its name.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// By how much a point is off at most through the rounding of its coordinates, mm.
    pub fn rounding(&self) -> f64 {
        0.5 * 3.0_f64.sqrt() / 10_u64.pow(self.decimals.length) as f64
    }

    /// Whether a program may change tools on such a machine.
    pub fn changes_tools(&self, axes: &Axes) -> bool {
        self.program(axes).is_ok_and(|program| !program.change.is_empty())
    }

    /// The words of arcs, if such a machine is to have any.
    ///
    /// # Errors
    /// [`DialectError::Arcs`] if there are none.
    pub(super) fn arcs(
        &self,
        axes: &Axes,
        wanted: bool,
    ) -> Result<Option<&ArcWords>, DialectError> {
        if !wanted || *axes != Axes::ThreeAxis {
            return Ok(None);
        }
        let missing = || DialectError::Arcs { post: self.name.clone() };
        self.arc.as_ref().map(Some).ok_or_else(missing)
    }

    /// Of angles in degrees.
    pub(super) fn angle_decimals(&self) -> u32 {
        self.decimals.angle
    }

    /// How programs for such a machine are written.
    ///
    /// # Errors
    /// [`DialectError::Axes`] if this post has no such programs.
    pub(super) fn program(&self, axes: &Axes) -> Result<&Program, DialectError> {
        let (program, table, what) = match axes {
            Axes::ThreeAxis => (&self.three_axis, "three_axis", "three axes"),
            Axes::FiveAxis(_) => (&self.five_axis, "five_axis", "five axes"),
        };
        let name = || self.name.clone();
        program.as_ref().ok_or_else(|| DialectError::Axes { post: name(), table, axes: what })
    }

    /// Whether there are words for the rotary axes of such a machine, where they are written.
    ///
    /// # Errors
    /// [`DialectError::Rotary`] if one is missing.
    pub(super) fn rotary_words(&self, axes: &Axes) -> Result<(), DialectError> {
        let by_vector = self.program(axes)?.orientation == Orientation::Vector;
        let Some(chain) = axes.chain().filter(|_| !by_vector) else { return Ok(()) };
        let Words { a, b, c, .. } = &self.words;
        let all = [('A', a), ('B', b), ('C', c)];
        let is_missing = |letter: &char| !all.iter().any(|(l, word)| l == letter && word.is_some());
        match chain.letters().into_iter().find(is_missing) {
            None => Ok(()),
            Some(letter) => {
                let (post, key) = (self.name.clone(), letter.to_ascii_lowercase());
                Err(DialectError::Rotary { post, letter, key })
            }
        }
    }

    /// The words that switch a coolant on and off; `None` for no coolant.
    ///
    /// # Errors
    /// [`DialectError::Coolant`] if there is no word for it, or none for `off`.
    pub(super) fn coolant(&self, coolant: Coolant) -> Result<Option<[&String; 2]>, DialectError> {
        if coolant == Coolant::Off {
            return Ok(None);
        }
        let own = format!("{}-off", coolant.name());
        let off = self.coolant.get(&own).or_else(|| self.coolant.get(Coolant::Off.name()));
        if let (Some(on), Some(off)) = (self.coolant.get(coolant.name()), off) {
            return Ok(Some([on, off]));
        }
        let (post, known) = (self.name.clone(), names(&self.coolant));
        Err(DialectError::Coolant { post, coolant: coolant.name(), known })
    }

    /// The word for a work offset.
    ///
    /// # Errors
    /// [`DialectError::WorkOffset`] if there is none.
    pub(super) fn work_offset(
        &self,
        offset: Option<WorkOffset>,
    ) -> Result<Option<&String>, DialectError> {
        let Some(offset) = offset.map(WorkOffset::name) else { return Ok(None) };
        let missing = || {
            let (post, known) = (self.name.clone(), names(&self.work_offset));
            DialectError::WorkOffset { post, offset, known }
        };
        self.work_offset.get(offset).map(Some).ok_or_else(missing)
    }

    fn validate(&self) -> Result<(), DialectError> {
        let is_plain = |c: char| c.is_ascii_alphanumeric() || "-_".contains(c);
        for (key, text, most) in [("name", &self.name, 40), ("extension", &self.extension, 8)] {
            if !(1..=most).contains(&text.len()) || !text.chars().all(is_plain) {
                let rule = format!("1 to {most} letters, digits, - and _");
                return Err(value(key, format!("{text:?}"), rule));
            }
        }
        let decimals = &self.decimals;
        let all = [
            ("length", decimals.length),
            ("angle", decimals.angle),
            ("vector", decimals.vector),
            ("feed", decimals.feed),
        ];
        for (key, n) in all {
            if n > MOST_DECIMALS {
                let key = format!("decimals.{key}");
                return Err(value(&key, n.to_string(), format!("0 to {MOST_DECIMALS}")));
            }
        }
        if self.line_numbers.as_ref().is_some_and(|numbers| numbers.step == 0) {
            return Err(value("line_numbers.step", "0".to_string(), "at least 1".to_string()));
        }
        let spindle = &self.spindle;
        for (key, text) in [
            ("rapid", &self.rapid),
            ("spindle.clockwise", &spindle.clockwise),
            ("spindle.counter-clockwise", &spindle.counter_clockwise),
        ] {
            if text.is_empty() {
                return Err(value(key, "empty".to_string(), "a word".to_string()));
            }
        }
        if self.three_axis.is_none() && self.five_axis.is_none() {
            let rule = "there; without both no program can be written".to_string();
            return Err(value("three_axis", "missing".to_string(), rule));
        }
        self.validate_words()?;
        self.texts().try_for_each(|(key, text)| validate_text(key, text))?;
        self.five_axis.iter().try_for_each(|program| self.validate_orientation(program))
    }

    fn validate_words(&self) -> Result<(), DialectError> {
        let of_arc = self.arc.iter().flat_map(|arc| [("i", &arc.i), ("j", &arc.j)]);
        let all = self.words.all().map(|(key, word)| ("words", key, word));
        for (table, key, word) in all.chain(of_arc.map(|(key, word)| ("arc", key, word))) {
            if word.matches("{}").count() != 1 || word.matches(['{', '}']).count() != 2 {
                let rule = "a text with {} once, for the number".to_string();
                return Err(value(&format!("{table}.{key}"), format!("{word:?}"), rule));
            }
        }
        Ok(())
    }

    fn validate_orientation(&self, program: &Program) -> Result<(), DialectError> {
        let Words { i, j, k, .. } = &self.words;
        if program.orientation == Orientation::Angles {
            return Ok(());
        }
        if program.position == Position::Machine {
            let rule = "\"tip\" where five_axis.orientation is \"vector\"".to_string();
            return Err(value("five_axis.position", "\"machine\"".to_string(), rule));
        }
        match [("i", i), ("j", j), ("k", k)].iter().find(|(_, word)| word.is_none()) {
            None => Ok(()),
            Some((key, _)) => {
                let rule = "there for five_axis.orientation vector".to_string();
                Err(value(&format!("words.{key}"), "missing".to_string(), rule))
            }
        }
    }

    /// All texts that come into a program, with their keys.
    fn texts(&self) -> impl Iterator<Item = (&'static str, &String)> {
        let own = [
            ("rapid", &self.rapid),
            ("feed", &self.feed),
            ("rapid_feed", &self.rapid_feed),
            ("position", &self.position),
            ("separator", &self.separator),
            ("spindle", &self.spindle.clockwise),
            ("spindle", &self.spindle.counter_clockwise),
        ];
        let mut all: Vec<(&'static str, &String)> = own.to_vec();
        all.extend(self.comment.iter().map(|text| ("comment", text)));
        all.extend(self.first.iter().map(|text| ("first", text)));
        all.extend(self.last.iter().map(|text| ("last", text)));
        all.extend(self.line_numbers.iter().map(|n| ("line_numbers.prefix", &n.prefix)));
        all.extend(self.words.all());
        if let Some(arc) = &self.arc {
            let ArcWords { clockwise, counter_clockwise, i, j } = arc;
            all.extend([clockwise, counter_clockwise, i, j].map(|text| ("arc", text)));
        }
        all.extend(self.coolant.values().map(|text| ("coolant", text)));
        all.extend(self.work_offset.values().map(|text| ("work_offset", text)));
        for (key, program) in [("three_axis", &self.three_axis), ("five_axis", &self.five_axis)] {
            let Some(p) = program else { continue };
            let blocks = [&p.start, &p.control_on, &p.control_off, &p.change, &p.end];
            all.extend(blocks.into_iter().flatten().map(|text| (key, text)));
            all.extend(p.rapid.iter().chain(&p.feed).map(|text| (key, text)));
        }
        all.into_iter()
    }
}

impl LineNumbers {
    fn of_table(keys: &mut Keys) -> Result<Self, KeysError> {
        let numbers = Self {
            prefix: keys.text("prefix")?,
            first: keys.number("first", None)?,
            step: keys.number("step", None)?,
            all: keys.flag("all")?,
        };
        keys.nothing_left()?;
        Ok(numbers)
    }
}

impl Decimals {
    fn of_table(keys: &mut Keys) -> Result<Self, KeysError> {
        let decimals = Self {
            length: keys.number("length", None)?,
            angle: keys.number("angle", Some(4))?,
            vector: keys.number("vector", Some(7))?,
            feed: keys.number("feed", None)?,
            plus: keys.flag("plus")?,
            trimmed: keys.flag("trimmed")?,
        };
        keys.nothing_left()?;
        Ok(decimals)
    }
}

impl Spindle {
    fn of_table(keys: &mut Keys) -> Result<Self, KeysError> {
        let clockwise = keys.text("clockwise")?;
        let spindle = Self { clockwise, counter_clockwise: keys.text("counter-clockwise")? };
        keys.nothing_left()?;
        Ok(spindle)
    }
}

impl ArcWords {
    fn of_table(keys: &mut Keys) -> Result<Self, KeysError> {
        let (clockwise, counter_clockwise) =
            (keys.text("clockwise")?, keys.text("counter-clockwise")?);
        let arc = Self { clockwise, counter_clockwise, i: keys.text("i")?, j: keys.text("j")? };
        keys.nothing_left()?;
        Ok(arc)
    }
}

impl Program {
    fn of_table(keys: &mut Keys) -> Result<Self, KeysError> {
        let program = Self {
            start: keys.texts("start")?,
            control_on: keys.texts("control_on")?,
            control_off: keys.texts("control_off")?,
            change: keys.texts("change")?,
            end: keys.texts("end")?,
            rapid: keys.optional("rapid")?,
            feed: keys.optional("feed")?,
            position: keys
                .choice("position", &[("machine", Position::Machine), ("tip", Position::Tip)])?,
            orientation: keys.choice(
                "orientation",
                &[("angles", Orientation::Angles), ("vector", Orientation::Vector)],
            )?,
            feed_mode: keys.choice(
                "feed_mode",
                &[("per-minute", FeedMode::PerMinute), ("inverse-time", FeedMode::InverseTime)],
            )?,
            repeat_words: keys.flag("repeat_words")?,
        };
        keys.nothing_left()?;
        Ok(program)
    }
}

impl Words {
    fn of_table(keys: &mut Keys) -> Result<Self, KeysError> {
        let words = Self {
            x: keys.text("x")?,
            y: keys.text("y")?,
            z: keys.text("z")?,
            a: keys.optional("a")?,
            b: keys.optional("b")?,
            c: keys.optional("c")?,
            i: keys.optional("i")?,
            j: keys.optional("j")?,
            k: keys.optional("k")?,
            feed: keys.text("feed")?,
        };
        keys.nothing_left()?;
        Ok(words)
    }

    fn all(&self) -> impl Iterator<Item = (&'static str, &String)> {
        let Self { x, y, z, a, b, c, i, j, k, feed } = self;
        let always = [("x", x), ("y", y), ("z", z), ("feed", feed)];
        let some = [("a", a), ("b", b), ("c", c), ("i", i), ("j", j), ("k", k)];
        let some = some.into_iter().filter_map(|(key, word)| Some((key, word.as_ref()?)));
        always.into_iter().chain(some)
    }
}

/// Printable ASCII on one line, of which every `{name}` is known.
fn validate_text(key: &str, text: &str) -> Result<(), DialectError> {
    if text.len() > LONGEST || !text.chars().all(|c| c == ' ' || c.is_ascii_graphic()) {
        let rule = format!("one line of at most {LONGEST} printable ASCII characters");
        return Err(value(key, format!("{:?}", text.chars().take(40).collect::<String>()), rule));
    }
    for part in text.split('{').skip(1) {
        let name = part.split('}').next().unwrap_or_default();
        let is_closed = part.contains('}');
        if !(is_closed && (name.is_empty() || FIELDS.contains(&name))) {
            return Err(DialectError::Field {
                key: key.to_string(),
                name: name.chars().take(40).collect(),
                known: FIELDS.join(", "),
            });
        }
    }
    Ok(())
}

/// The names that a table has, for messages.
fn names(table: &BTreeMap<String, String>) -> String {
    let all: Vec<&str> = table.keys().map(String::as_str).collect();
    if all.is_empty() { "none".to_string() } else { all.join(", ") }
}

fn value(key: &str, value: String, rule: String) -> DialectError {
    DialectError::Value { key: key.to_string(), value, rule }
}
