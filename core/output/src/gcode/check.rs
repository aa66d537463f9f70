//! What is wrong with a program, by the moves that it makes.
//!
//! Neighbouring moves with the same fault are one finding, at the line of the first.

use super::kinematics::Kinematics;
use super::program::{Finding, FindingKind, GcodeProgram, Move};
use evencut_core::geometry::OrderBy;
use evencut_core::machine::{Chain, Travel};
use evencut_core::units::{per_minute, per_second};

/// Positions are programmed with four decimals at best; mm, and with as many of a degree.
const ROUNDING: f64 = 1e-4;

/// Share by which a measured feed may exceed the machine's, and travel by which, mm: the last digits of
/// feeds and positions.
const FEED_ROUNDING: (f64, f64) = (1e-3, 2e-3);

/// What a program is held against.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct CheckOptions {
    /// Height of the tip along the tool axis at and above which rapids must run, mm: of tables about program zero the
    /// machine's Z.
    pub clearance_plane: Option<f64>,
    /// Where the linear axes can go.
    pub travel: Travel,
    /// Fastest feed, mm/s: of the tip, and as programmed per minute.
    pub max_feed: Option<f64>,
}

/// What is wrong with a program that was read, ordered by line; nothing for a sound one.
///
/// Arcs are judged by the tolerance that the program was read with.
pub fn check(program: &GcodeProgram, options: &CheckOptions) -> Vec<Finding> {
    let checker = Checker { program, options };
    let mut findings = program.findings.clone();
    findings.extend(checker.rapids());
    findings.extend(checker.feeds());
    findings.extend(checker.travel());
    findings.order_by_key(|finding| (finding.line, finding.kind));
    findings
}

struct Checker<'a> {
    program: &'a GcodeProgram,
    options: &'a CheckOptions,
}

/// What a rule says about a move.
enum Verdict {
    /// It is not about this move.
    Beside,
    Kept,
    /// The measured value, and by how much it is too much.
    Broken(f64, f64),
}

/// Neighbouring moves that break a rule.
struct Run {
    first: u32,
    last: u32,
    moves: usize,
    value: f64,
    excess: f64,
}

impl Run {
    /// Where it ends, for messages.
    fn extent(&self) -> String {
        match self.moves {
            1 => String::new(),
            moves => format!(" ({moves} moves, to line {})", self.last),
        }
    }
}

impl Checker<'_> {
    fn rapids(&self) -> Vec<Finding> {
        let Some(plane) = self.options.clearance_plane else { return Vec::new() };
        let rule = |diagonal: bool| {
            move |i: usize, m: &Move| match m.lowest.filter(|_| m.rapid) {
                None => Verdict::Beside,
                Some(z) if z < plane - ROUNDING && self.dives(i, plane) == diagonal => {
                    Verdict::Broken(z, plane - z)
                }
                Some(_) => Verdict::Kept,
            }
        };
        let low = self.findings(FindingKind::LowRapid, rule(false), |z| {
            format!(
                "rapid {z:.3} mm high along the tool axis; the clearance plane is at {plane:.3} mm"
            )
        });
        let diagonal = self.findings(FindingKind::DiagonalRapid, rule(true), |z| {
            format!(
                "rapid down to {z:.3} mm along the tool axis while it also moves across it or turns; below the clearance plane at {plane:.3} mm go down alone and at feed"
            )
        });
        low.into_iter().chain(diagonal).collect()
    }

    /// Whether a move goes down below the plane while other axes move.
    fn dives(&self, index: usize, plane: f64) -> bool {
        let points = self.program.points_of(index);
        if points.is_empty() || points.start == 0 {
            return false;
        }
        let machine = &self.program.machine;
        let (from, to) = (machine[points.start - 1], machine[points.end - 1]);
        let kinematics = Kinematics(self.program.axes);
        let (low, high) = (kinematics.in_tool_frame(&to), kinematics.in_tool_frame(&from));
        let way = low - high;
        let turn = |i: usize| (to.rotary[i] - from.rotary[i]).abs().to_degrees();
        let aside = way.truncate().length() > ROUNDING || turn(0).max(turn(1)) > ROUNDING;
        aside && way.z < -ROUNDING && low.z < plane - ROUNDING
    }

    fn feeds(&self) -> Vec<Finding> {
        let rule = |broken: fn(&Move) -> bool| {
            move |_: usize, m: &Move| match (m.rapid, broken(m)) {
                (true, _) => Verdict::Beside,
                (_, true) => Verdict::Broken(m.feed.unwrap_or(0.0), 0.0),
                (_, false) => Verdict::Kept,
            }
        };
        let without = |m: &Move| !m.feed.is_some_and(|feed| feed > 0.0);
        let mut findings = self.findings(FindingKind::NoFeed, rule(without), |_| {
            "feed move without a feed; F must be above 0, under G93 in every block".to_string()
        });
        findings.extend(self.findings(
            FindingKind::SpindleOff,
            rule(|m| !m.setting.turns()),
            |_| "feed move while the spindle is stopped; it needs M3 or M4 and S".to_string(),
        ));
        findings.extend(self.findings(
            FindingKind::NoLength,
            rule(|m| m.setting.lacks_length),
            |_| {
                "feed move after a tool change without the length of the tool; it needs G43 with H, or D"
                    .to_string()
            },
        ));
        let Some(most) = self.options.max_feed else { return findings };
        let fast = |i: usize, m: &Move| self.fast(i, m, most);
        findings.extend(self.findings(FindingKind::FastFeed, fast, |feed| {
            format!(
                "feed of {:.1} mm/min; the machine's is {:.1}",
                per_minute(feed),
                per_minute(most)
            )
        }));
        findings
    }

    fn fast(&self, index: usize, m: &Move, most: f64) -> Verdict {
        if m.rapid {
            return Verdict::Beside;
        }
        let programmed = m.feed.filter(|_| !m.inverse_time).map_or(0.0, per_second);
        let (share, length) = FEED_ROUNDING;
        let travel = self.tip_travel(index);
        let measured = if m.duration > 0.0 { travel / m.duration } else { 0.0 };
        if travel > most * m.duration * (1.0 + share) + length && measured > programmed {
            Verdict::Broken(measured, measured - most)
        } else if programmed > most * (1.0 + 1e-6) {
            Verdict::Broken(programmed, programmed - most)
        } else {
            Verdict::Kept
        }
    }

    /// Travel of the tip in the workpiece, mm; 0 for moves before the path and without a feed.
    fn tip_travel(&self, index: usize) -> f64 {
        let points = self.program.points_of(index);
        if points.start == 0 || self.program.moves[index].duration == 0.0 {
            return 0.0;
        }
        let path = &self.program.path.points[points.start - 1..points.end];
        path.windows(2).map(|pair| pair[1].tip.distance(pair[0].tip)).sum()
    }

    fn travel(&self) -> Vec<Finding> {
        let Travel { x, y, z } = self.options.travel;
        let mut ranges = vec![('X', x), ('Y', y), ('Z', z)];
        for axis in self.program.axes.chain().into_iter().flat_map(Chain::axes) {
            let (low, high) = axis.range;
            ranges.push((axis.letter, Some((low.to_degrees(), high.to_degrees()))));
        }
        let mut findings = Vec::new();
        for (axis, (name, range)) in ranges.into_iter().enumerate() {
            let Some((low, high)) = range else { continue };
            let unit = if axis < 3 { "mm" } else { "degrees" };
            let rule = |i: usize, _: &Move| self.beyond(i, axis, (low, high));
            findings.extend(self.findings(FindingKind::Travel, rule, |position| {
                format!("{name} goes to {position:.3}; the machine allows {low} to {high} {unit}")
            }));
        }
        findings
    }

    /// The position of a move that is farthest outside of a range.
    fn beyond(&self, index: usize, axis: usize, (low, high): (f64, f64)) -> Verdict {
        let mut verdict = Verdict::Beside;
        let mut worst = ROUNDING;
        for place in &self.program.machine[self.program.points_of(index)] {
            let position = match axis {
                0..3 => place.linear[axis],
                _ => place.rotary[axis - 3].to_degrees(),
            };
            let excess = (low - position).max(position - high);
            if excess > worst {
                worst = excess;
                verdict = Verdict::Broken(position, excess);
            } else if matches!(verdict, Verdict::Beside) {
                verdict = Verdict::Kept;
            }
        }
        verdict
    }

    /// A finding for every run of moves that break a rule.
    fn findings(
        &self,
        kind: FindingKind,
        rule: impl Fn(usize, &Move) -> Verdict,
        message: impl Fn(f64) -> String,
    ) -> Vec<Finding> {
        let runs = self.runs(rule);
        let finding = |run: Run| {
            let message = message(run.value) + &run.extent();
            Finding { line: run.first, kind, message }
        };
        runs.into_iter().map(finding).collect()
    }

    fn runs(&self, rule: impl Fn(usize, &Move) -> Verdict) -> Vec<Run> {
        let mut runs: Vec<Run> = Vec::new();
        let mut open = false;
        for (i, m) in self.program.moves.iter().enumerate() {
            let (value, excess) = match rule(i, m) {
                Verdict::Beside => continue,
                Verdict::Kept => {
                    open = false;
                    continue;
                }
                Verdict::Broken(value, excess) => (value, excess),
            };
            match runs.last_mut().filter(|_| open) {
                Some(run) => {
                    run.last = m.line;
                    run.moves += 1;
                    if excess > run.excess {
                        (run.value, run.excess) = (value, excess);
                    }
                }
                None => runs.push(Run { first: m.line, last: m.line, moves: 1, value, excess }),
            }
            open = true;
        }
        runs
    }
}
