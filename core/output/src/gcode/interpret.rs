//! Blocks → path: what a controller does with one block after another.

use super::arc::{Arc, Circle, Ends};
use super::block::{Block, Line};
use super::codes::{Modal, Motion, Once, SUBPROGRAM};
use super::error::{Fault, GcodeError};
use super::kinematics::{Kinematics, MachinePosition};
use super::motion::{Segment, Way};
use super::options::{ReadOptions, validate};
use super::program::{Finding, FindingKind, GcodeProgram, Move};
use super::scanner::Scanner;
use evencut_core::geometry::{DVec2, DVec3};
use evencut_core::machine::{Arrangement, Axes};
use evencut_core::toolpath::{MoveKind, PathPoint};
use evencut_core::units::{MINUTE, per_second};

/// Positions beyond this either way are taken for damage; mm and degrees.
const LARGEST: f64 = 1e6;

/// G codes, in tenths, that turn tool centre control on and off.
const TIP_ON: [u32; 3] = [434, 435, 2340];
const TIP_OFF: [u32; 2] = [430, 490];
/// Those that take the length of the tool into account.
const LENGTH_ON: [u32; 4] = [430, 434, 435, 2340];

/// X, Y, Z in mm, of the tip where tool centre control is on, and the rotary axes in rad, as far as they are known.
type Position = [Option<f64>; 5];

/// Reads a program, written here or elsewhere.
///
/// Formats: blocks of words (RS-274, ISO 6983, with what LinuxCNC, Fanuc, Haas, SINUMERIK and GRBL add); Heidenhain's
/// conversational one, from `BEGIN PGM`, with `L`, `LN`, `TOOL CALL`, `FUNCTION TCPM`, M128; APT cutter location data,
/// from `PARTNO`, with `GOTO`, `FEDRAT`, `RAPID`, `SPINDL`, `MULTAX`.
///
/// Read of blocks of words: G0 to G3 with centres (G91.1, G90.1), radii, helices and turns (P); G4 P in s; G17 to G19;
/// G20, G21; G28, G30, G53; G40, G43 H, G49, G80; one of G54 to G59.3,
/// G54.1 P, G154 P, G505 to G599; G43.4, G43.5, G234 and TRAORI with A3, B3, C3 (the tip is programmed in the workpiece
/// that turns with the tables); G700, G710; G61, G64; G90, G91; G93, G94;
/// M0 to M9, M30, M48, M49; S, T, N; a program number at the top; comments; `%`; block delete.
/// Arcs and turning moves become chords within the tolerance, with the time they take: at feed per minute
/// the tip's travel on three axes, the travel of the machine's linear axes on five (of the rotary ones
/// where no other moves, in degrees per minute), as controllers do.
///
/// # Errors
/// [`GcodeError`], naming the line: text that is no program, and whatever else would make the path
/// another one (compensation, cycles, subprograms, expressions, other offsets).
pub fn read(text: &str, options: &ReadOptions) -> Result<GcodeProgram, GcodeError> {
    validate(options)?;
    let mut reader = Reader::new(options);
    let mut block = Block::default();
    let text = text.trim_start_matches('\u{feff}');
    let mut scanner = Scanner::of(text);
    for text in text.lines() {
        reader.line = reader.line.saturating_add(1);
        let flow = reader.line_of_text(&mut scanner, &mut block, text);
        let place = |fault| GcodeError::Block { line: reader.line, block: quoted(text), fault };
        if !flow.map_err(place)? {
            break;
        }
    }
    if !reader.ended {
        let message = "no M2 or M30 at its end".to_string();
        let line = reader.line.max(1);
        reader.out.findings.push(Finding { line, kind: FindingKind::NoEnd, message });
    }
    reader.out.axes = reader.kinematics.0;
    Ok(reader.out)
}

/// The text of a block, cut short.
fn quoted(text: &str) -> String {
    let clean = text.trim().chars().map(|c| if c.is_control() { ' ' } else { c });
    clean.take(60).collect()
}

struct Reader<'a> {
    options: &'a ReadOptions,
    kinematics: Kinematics,
    modal: Modal,
    position: Position,
    /// Time since the path started, s.
    clock: f64,
    line: u32,
    /// Whether anything but comments came before.
    begun: bool,
    ended: bool,
    /// Line of the last move to a place that is not known.
    lost: u32,
    /// Line of the last change of the tool.
    changed: u32,
    /// Where the tables stand for the direction of the tool axis in the block.
    turned: Option<[f64; 2]>,
    out: GcodeProgram,
}

impl<'a> Reader<'a> {
    fn new(options: &'a ReadOptions) -> Self {
        Self {
            options,
            kinematics: Kinematics(options.axes),
            modal: Modal::default(),
            position: [None, None, None, Some(0.0), Some(0.0)],
            clock: 0.0,
            line: 0,
            begun: false,
            ended: false,
            lost: 0,
            changed: 0,
            turned: None,
            out: GcodeProgram::default(),
        }
    }

    /// Does what a line says; whether the program goes on.
    fn line_of_text(
        &mut self,
        scanner: &mut Scanner,
        block: &mut Block,
        text: &str,
    ) -> Result<bool, Fault> {
        match scanner.scan(block, text, self.options.block_delete)? {
            Line::Empty => Ok(true),
            // The second % ends the tape; text before the first is none of the program's.
            Line::Tape => Ok(!self.begun),
            Line::Words => {
                self.block(block)?;
                self.begun = true;
                Ok(!self.ended)
            }
        }
    }

    /// Which length of the tool is taken into account, if any: by G43 and H, by the cutting edge (D), or by what changes
    /// the tool.
    fn tool_length(&mut self, block: &mut Block) {
        let setting = &mut self.modal.setting;
        if block.g.contains(&490) {
            setting.length_offset = None;
            setting.lacks_length |= setting.tool.is_some();
        }
        let number = block.take('H');
        if let Some(number) = number {
            setting.length_offset = whole(number);
        }
        let edge = block.take('D').filter(|edge| *edge > 0.0);
        let is_on = block.g.iter().any(|code| LENGTH_ON.contains(code));
        if is_on || number.is_some() || edge.is_some() {
            setting.lacks_length = false;
        }
    }

    fn block(&mut self, block: &mut Block) -> Result<(), Fault> {
        self.program_number(block)?;
        let once = self.modal.g_codes(&block.g)?;
        if let Some(tool) = block.take('T') {
            self.modal.next_tool = whole(tool);
        }
        let end = self.modal.m_codes(&block.m)?;
        if block.m.contains(&60) {
            self.changed = self.line;
        }
        let on = block.g.iter().any(|code| TIP_ON.contains(code));
        let off = block.g.iter().any(|code| TIP_OFF.contains(code));
        match block.control {
            Some(on) => self.control(on),
            None if on || off => self.control(on),
            None => {}
        }
        self.tool_axis(block)?;
        self.modal.rates(block.take('F'), block.take('S'));
        self.tool_length(block);
        if let Some(&code) = block.g.iter().find(|code| [541, 1540].contains(code)) {
            // A number that is none of an offset is left, and so refused.
            if let Some(number) =
                block.get('P').filter(|p| p.fract() == 0.0 && (1.0..1e4).contains(p))
            {
                block.take('P');
                self.modal.offset(code, number as u32)?;
            }
        }
        if block.g.contains(&640) {
            block.take('P');
            block.take('Q');
        }
        match once {
            Some(Once::Dwell) => self.dwell(block)?,
            Some(Once::Home | Once::SecondHome) => self.go_home(block, once)?,
            Some(Once::MachineCoordinates) => self.move_in_machine(block)?,
            None => self.plain_move(block)?,
        }
        self.ended = end;
        self.nothing_left(block)
    }

    /// `O` and a number at the top name the program; elsewhere they are control flow.
    fn program_number(&self, block: &mut Block) -> Result<(), Fault> {
        let Some(number) = block.take('O') else { return Ok(()) };
        let plain = number >= 0.0 && number.fract() == 0.0;
        if plain && !self.begun && block.left().is_none() && block.g.is_empty() {
            return Ok(());
        }
        Err(Fault::Refused { word: "O".to_string(), remedy: SUBPROGRAM, displaces: true })
    }

    /// Tool centre control goes on or off: the same numbers mean another place.
    fn control(&mut self, on: bool) {
        if core::mem::replace(&mut self.modal.control, on) == on {
            return;
        }
        let upright = self.position[3..] == [Some(0.0); 2];
        match known(&self.position) {
            Some(at) => {
                let linear = match on {
                    true => self.kinematics.to_part(at.linear, at.rotary),
                    false => self.kinematics.to_machine(at.linear, at.rotary),
                };
                self.position[..3].copy_from_slice(&linear.to_array().map(Some));
            }
            None if upright => {}
            // It is lost already.
            None => self.position[..3].fill(None),
        }
    }

    /// The direction of the tool axis that a block gives, as angles of the tables.
    fn tool_axis(&mut self, block: &mut Block) -> Result<(), Fault> {
        if self.modal.control && self.modal.axis_by_ijk {
            block.vector = ['I', 'J', 'K'].map(|letter| block.take(letter));
        }
        self.turned = None;
        if block.vector == [None; 3] {
            return Ok(());
        }
        if !self.modal.control {
            let remedy = "it means nothing while tool centre control is off; turn it on before (TRAORI, FUNCTION TCPM, M128)";
            return Err(Fault::Refused {
                word: "the direction of the tool axis".to_string(),
                remedy,
                displaces: false,
            });
        }
        if self.kinematics.0 == Axes::ThreeAxis {
            // Whichever tables turn to the axis: tip, axis and height are the same.
            self.kinematics = Kinematics(Arrangement::Xyzac.axes(0.0));
        }
        let rotary = [3, 4].map(|i| self.position[i].unwrap_or(0.0));
        let before =
            self.kinematics.tip_and_axis(&MachinePosition { linear: DVec3::ZERO, rotary }).1;
        let mut axis = before.to_array();
        for (value, given) in axis.iter_mut().zip(block.vector) {
            *value = given.unwrap_or(*value);
        }
        let axis = DVec3::from(axis).try_normalize().unwrap_or(before);
        let [first, second] = self.kinematics.rotary_toward(axis, rotary);
        self.turned = Some([first, second]);
        Ok(())
    }

    fn nothing_left(&self, block: &Block) -> Result<(), Fault> {
        let Some(letter) = block.left() else { return Ok(()) };
        let turned = matches!(letter, 'A' | 'B' | 'C');
        if turned && !self.kinematics.letters().contains(&letter) {
            return Err(Fault::Rotary(letter, self.kinematics.name()));
        }
        Err(Fault::Unused(letter))
    }

    fn dwell(&mut self, block: &mut Block) -> Result<(), Fault> {
        let seconds = block.take('P').unwrap_or(0.0).max(0.0);
        if !self.out.lines.is_empty() {
            self.clock += seconds;
        }
        Ok(())
    }

    /// By way of the point that the block names, if any, its axes (or all) to where the machine has
    /// its reference.
    fn go_home(&mut self, block: &mut Block, once: Option<Once>) -> Result<(), Fault> {
        let letters = self.kinematics.letters();
        let named: Vec<bool> = letters.iter().map(|&l| block.get(l).is_some()).collect();
        let all = !named.contains(&true);
        let by = self.target(block)?;
        if by != self.position {
            self.go(Motion::Rapid, by, None)?;
        }
        let mut home = self.position;
        for i in (0..letters.len()).filter(|&i| all || named[i]) {
            home[i] = match self.options.machine_zero {
                Some(zero) if once == Some(Once::Home) => {
                    Some(zero.to_array().get(i).copied().unwrap_or(0.0))
                }
                _ => None,
            };
        }
        self.go(Motion::Rapid, home, None)
    }

    /// G53: absolute, from machine zero.
    fn move_in_machine(&mut self, block: &mut Block) -> Result<(), Fault> {
        let motion = match self.modal.motion {
            Some(motion @ (Motion::Rapid | Motion::Feed)) => motion,
            _ => return Err(Fault::NoMotion),
        };
        let mut to = self.position;
        let letters = self.kinematics.letters();
        let mut moved = false;
        for (i, &letter) in letters.iter().enumerate() {
            let Some(value) = block.take(letter) else { continue };
            moved = true;
            let zero = self.options.machine_zero.map(|zero| zero.to_array());
            to[i] = match zero {
                Some(zero) if i < 3 => Some(zero[i] + self.length(value)),
                None if i < 3 => None,
                _ => Some(value.to_radians()),
            };
        }
        if moved { self.go(motion, to, None) } else { Ok(()) }
    }

    fn plain_move(&mut self, block: &mut Block) -> Result<(), Fault> {
        let letters = self.kinematics.letters();
        let coordinates = letters.iter().any(|&l| block.get(l).is_some());
        let arc = matches!(self.modal.motion, Some(Motion::Arc { .. }));
        let centre = arc && ['I', 'J', 'K', 'R'].iter().any(|&l| block.get(l).is_some());
        if !coordinates && !centre && self.turned.is_none() {
            return Ok(());
        }
        let motion = self.modal.motion.ok_or(Fault::NoMotion)?;
        let to = self.target(block)?;
        let arc = match motion {
            Motion::Arc { counter_clockwise } => Some(self.arc(block, &to, counter_clockwise)?),
            Motion::Rapid | Motion::Feed => None,
        };
        self.go(motion, to, arc)
    }

    fn length(&self, word: f64) -> f64 {
        word * self.modal.unit
    }

    /// Where the words of a block lead.
    fn target(&self, block: &mut Block) -> Result<Position, Fault> {
        let mut to = self.position;
        if let Some(rotary) = self.turned {
            to[3..].copy_from_slice(&rotary.map(Some));
        }
        for (i, &letter) in self.kinematics.letters().iter().enumerate() {
            let Some(word) = block.take(letter) else { continue };
            let value = if i < 3 { self.length(word) } else { word.to_radians() };
            to[i] = match (self.modal.incremental, self.position[i]) {
                (false, _) => Some(value),
                (true, before) => before.map(|before| before + value),
            };
        }
        Ok(to)
    }

    fn arc(
        &mut self,
        block: &mut Block,
        to: &Position,
        counter_clockwise: bool,
    ) -> Result<Arc, Fault> {
        let plane = self.modal.plane;
        let [i, j, _] = plane.axes();
        let (Some(from), Some(to)) = (in_plane(&self.position, [i, j]), in_plane(to, [i, j]))
        else {
            return Err(Fault::Arc(
                "starts or ends where X, Y or Z is not known; move there first",
            ));
        };
        let turns = block.take('P').unwrap_or(1.0);
        if !(turns >= 1.0 && turns.fract() == 0.0) {
            return Err(Fault::Arc("has turns (P) that are not a whole number from 1"));
        }
        let circle = self.circle(block, from)?;
        let arc = Arc::new(plane, &Ends { from, to, counter_clockwise, turns }, circle)?;
        if arc.mismatch > self.options.arc_tolerance {
            self.report_mismatch(&arc);
        }
        Ok(arc)
    }

    fn report_mismatch(&mut self, arc: &Arc) {
        let (line, kind) = (self.line, FindingKind::ArcRadius);
        let message = format!(
            "the arc's ends miss its circle by {:.4} mm; at most {} mm are allowed",
            arc.mismatch, self.options.arc_tolerance
        );
        self.out.findings.push(Finding { line, kind, message });
    }

    fn circle(&self, block: &mut Block, from: DVec2) -> Result<Circle, Fault> {
        let [i, j, _] = self.modal.plane.axes();
        let letters = [['I', 'J', 'K'][i], ['I', 'J', 'K'][j]];
        let offsets = letters.map(|letter| block.take(letter).map(|word| self.length(word)));
        if let Some(radius) = block.take('R') {
            return match offsets {
                [None, None] => Ok(Circle::Radius(self.length(radius))),
                _ => Err(Fault::Arc("has both a radius (R) and a centre (I, J, K)")),
            };
        }
        match offsets {
            [None, None] => Err(Fault::Arc("has no centre in its plane; give I, J, K, or R")),
            [Some(x), Some(y)] if self.modal.absolute_centres => {
                Ok(Circle::Centre(DVec2::new(x, y)))
            }
            _ if self.modal.absolute_centres => {
                Err(Fault::Arc("has one coordinate of its centre; G90.1 needs both"))
            }
            [x, y] => {
                let offset = DVec2::new(x.unwrap_or(0.0), y.unwrap_or(0.0));
                Ok(Circle::Centre(from + offset))
            }
        }
    }

    /// Makes a move: its points, its time, and a note of it.
    fn go(&mut self, motion: Motion, to: Position, arc: Option<Arc>) -> Result<(), Fault> {
        self.within_reason(&to)?;
        let ends = (self.machine(&self.position), self.machine(&to));
        let height = |at: &MachinePosition| self.kinematics.in_tool_frame(at).z;
        // Of a place that is known in part the Z word is the best that is known.
        let heights = match self.modal.control {
            true => [ends.0.map(|at| height(&at)), ends.1.map(|at| height(&at))],
            false => [
                ends.0.map_or(self.position[2], |at| Some(height(&at))),
                ends.1.map_or(to[2], |at| Some(height(&at))),
            ],
        };
        self.position = to;
        let way = match (self.modal.control, self.turned) {
            (false, _) => Way::Machine,
            (true, None) => Way::Tip,
            (true, Some(_)) => Way::TipAndAxis,
        };
        let rapid = motion == Motion::Rapid;
        let mut duration = 0.0;
        let start = self.out.lines.len();
        match ends {
            (Some(from), Some(to)) if start > 0 => {
                let segment = Segment { from, to, arc, way, kinematics: self.kinematics };
                duration = self.duration(&segment, rapid);
                self.follow(&segment, rapid, duration)?;
            }
            // The first rapid after a change of the tool at the machine's reference is taken as one from the last place
            // that is known.
            (None, Some(_)) if start > 0 && !(rapid && self.changed > self.lost) => {
                return Err(Fault::Lost { since: self.lost });
            }
            (_, Some(to)) => self.push(&to, rapid),
            _ => {}
        }
        if ends.1.is_none() && ends.0.is_some() {
            self.lost = self.line;
        }
        let on_the_way = self.out.path.points[start..].iter().map(|p| p.tip.dot(p.axis));
        let lowest = heights.into_iter().flatten().chain(on_the_way).reduce(f64::min);
        self.note(rapid, duration, lowest);
        Ok(())
    }

    /// The position of the axes of the machine, if it is known.
    fn machine(&self, position: &Position) -> Option<MachinePosition> {
        let at = known(position)?;
        let linear = match self.modal.control {
            true => self.kinematics.to_machine(at.linear, at.rotary),
            false => at.linear,
        };
        Some(MachinePosition { linear, ..at })
    }

    fn within_reason(&self, to: &Position) -> Result<(), Fault> {
        for (i, &axis) in self.kinematics.letters().iter().enumerate() {
            let value = to[i].map_or(0.0, |v| if i < 3 { v } else { v.to_degrees() });
            // Also refuses what is not a number.
            if !(0.0..=LARGEST).contains(&value.abs()) {
                return Err(Fault::TooFar { axis, value, limit: LARGEST });
            }
        }
        Ok(())
    }

    fn note(&mut self, rapid: bool, duration: f64, lowest: Option<f64>) {
        let modal = &self.modal;
        self.out.moves.push(Move {
            line: self.line,
            rapid,
            end: self.out.lines.len(),
            feed: modal.feed.map(|feed| feed[1]),
            inverse_time: modal.inverse_time,
            duration,
            setting: modal.setting,
            lowest,
        });
    }

    /// Time of a move, s; 0 without a feed.
    fn duration(&self, segment: &Segment, rapid: bool) -> f64 {
        let length = segment.length();
        if rapid {
            return self.rapid_length(segment, length) / self.options.rapid_feed;
        }
        let Some([word, feed]) = self.modal.feed.filter(|feed| feed[1] > 0.0) else { return 0.0 };
        if self.modal.inverse_time {
            MINUTE / feed
        } else if length > 0.0 {
            MINUTE * length / feed
        } else {
            // Degrees per minute where only the tool axis turns.
            MINUTE * segment.turn_alone().to_degrees() / word
        }
    }

    /// The longer of the travel on the machine and in the workpiece.
    fn rapid_length(&self, segment: &Segment, length: f64) -> f64 {
        let tip = |at: &MachinePosition| self.kinematics.tip_and_axis(at).0;
        length.max(tip(&segment.from).distance(tip(&segment.to)))
    }

    /// Feed as programmed, mm/s; 0 if there is none or it is inverse time.
    fn feed(&self, rapid: bool) -> f64 {
        if rapid {
            return self.options.rapid_feed;
        }
        let feed = self.modal.feed.filter(|_| !self.modal.inverse_time);
        feed.map_or(0.0, |feed| per_second(feed[1].max(0.0)))
    }

    /// The chords of a move.
    fn follow(&mut self, segment: &Segment, rapid: bool, duration: f64) -> Result<(), Fault> {
        let start = self.clock;
        let options = self.options;
        let room = options.max_points.saturating_sub(self.out.lines.len());
        let moved = segment.from != segment.to || segment.arc.is_some();
        let shares = segment.chords(options.chord_tolerance, room);
        let shares = shares.ok_or(Fault::TooLong { limit: options.max_points })?;
        let mut from = 0.0;
        for share in shares.into_iter().filter(|_| moved) {
            self.clock = start + duration * share;
            self.push(&segment.at(share), rapid);
            if self.modal.inverse_time || segment.turn() > 0.0 {
                self.measure_feed(duration * (share - from));
            }
            from = share;
        }
        self.clock = start + duration;
        Ok(())
    }

    /// Sets the feed of the last point from the tip's travel in `time` s.
    fn measure_feed(&mut self, time: f64) {
        if let [.., before, last] = &mut self.out.path.points[..] {
            let travel = last.tip.distance(before.tip);
            last.feed = if time > 0.0 { travel / time } else { 0.0 };
        }
    }

    fn push(&mut self, at: &MachinePosition, rapid: bool) {
        let (tip, axis) = self.kinematics.tip_and_axis(at);
        self.out.path.points.push(PathPoint {
            kind: if rapid { MoveKind::Rapid } else { MoveKind::Cut },
            pass: 0,
            region: 0,
            tip,
            axis,
            normal: axis,
            flat: None,
            feed: self.feed(rapid),
            mrr: 0.0,
            alpha: 0.0,
            time: self.clock,
        });
        self.out.lines.push(self.line);
        self.out.machine.push(*at);
    }
}

/// A number of a tool or an offset; `None` for what is none.
fn whole(word: f64) -> Option<u32> {
    (word.fract() == 0.0 && (0.0..1e9).contains(&word)).then_some(word as u32)
}

fn in_plane(position: &Position, [i, j]: [usize; 2]) -> Option<DVec2> {
    Some(DVec2::new(position[i]?, position[j]?))
}

fn known(position: &Position) -> Option<MachinePosition> {
    let &[Some(x), Some(y), Some(z), Some(first), Some(second)] = position else { return None };
    Some(MachinePosition { linear: DVec3::new(x, y, z), rotary: [first, second] })
}
