//! The program of a planned path, read back.

use super::{OutputFile, ResultsError};
use evencut_core::job::Job;
use evencut_core::machine::Axes;
use evencut_core::plan::Planned;
use evencut_core::toolpath::Toolpath;
use evencut_output::gcode::{self, Following, GcodeError, GcodeProgram, Setting};
use evencut_output::post::{Dialect, ProgramOptions, program};
use evencut_output::report::{ProgramFigures, ReachFigures};

/// A program as it was written and as it was read back.
pub(super) struct WrittenProgram {
    pub file: OutputFile,
    pub figures: ProgramFigures,
    /// Where the axes of the machine go; empty where it could not be read back.
    pub reach: Vec<ReachFigures>,
    /// What is wrong with it.
    pub findings: Vec<String>,
    /// Why it could not be read back.
    pub unread: Option<GcodeError>,
}

impl WrittenProgram {
    /// # Errors
    /// [`ResultsError`] if it cannot be written, or if one of a post that comes along cannot be read back.
    pub fn of(job: &Job, planned: &Planned, dialect: &Dialect) -> Result<Self, ResultsError> {
        let options = Self::options(job, &job.name, planned.rapid_plane);
        let program = program(&planned.toolpath, &options, dialect)?;
        let (mut reach, mut findings, mut unread) = (Vec::new(), Vec::new(), None);
        match read_back(&program.text, job) {
            Ok(read) => {
                let plane = planned.rapid_plane;
                findings = checked(
                    &read,
                    job,
                    &planned.toolpath,
                    plane,
                    dialect.rounding(),
                    vec![setting(job)],
                );
                reach = reach_of(&read);
            }
            Err(error) if job.post_file().is_none() => return Err(error.into()),
            Err(error) if error.displaces() => findings.push(error.to_string()),
            // A post of one's own may write for a controller that is not known here.
            Err(error) => unread = Some(error),
        }
        let name = format!("program.{}", program.extension);
        let figures = ProgramFigures {
            file: name.clone(),
            post: dialect.name().to_owned(),
            number: job.setup.program_number.into(),
            blocks: program.text.lines().count() as u64,
            bytes: program.text.len() as u64,
        };
        let file = OutputFile { name, bytes: program.text.into_bytes() };
        Ok(Self { file, figures, reach, findings, unread })
    }

    /// Gives its file a name.
    pub fn rename(&mut self, name: String) {
        self.figures.file.clone_from(&name);
        self.file.name = name;
    }

    /// What a program of a job needs beside the path; `name`: for a comment.
    pub fn options(job: &Job, name: &str, rapid_plane: f64) -> ProgramOptions {
        ProgramOptions {
            name: name.to_owned(),
            machine: job.machine,
            rapid_plane,
            tool: job.tool,
            setup: job.setup,
            spindle: job.cut.spindle,
            tolerance: job.cut.tolerance,
        }
    }
}

pub(super) fn read_back(text: &str, job: &Job) -> Result<GcodeProgram, GcodeError> {
    let reading = gcode::ReadOptions {
        axes: job.machine.axes,
        rapid_feed: job.machine.max_feed,
        ..gcode::ReadOptions::default()
    };
    gcode::read(text, &reading)
}

/// What a job sets the machine to.
pub(super) fn setting(job: &Job) -> Setting {
    Setting::wanted(&job.setup, job.cut.spindle)
}

/// Findings of the check of an emitted program; `plane`: height of the rapids, mm; `settings`: those of its operations.
pub(super) fn checked(
    read: &GcodeProgram,
    job: &Job,
    path: &Toolpath,
    plane: f64,
    rounding: f64,
    settings: Vec<Setting>,
) -> Vec<String> {
    // Where the tip is programmed, rapids are chords of the way on which the machine stays above the plane.
    let off_plane = match job.machine.axes {
        Axes::ThreeAxis => 0.0,
        Axes::FiveAxis(_) => job.cut.tolerance,
    };
    let rules = gcode::CheckOptions {
        clearance_plane: Some(plane - off_plane),
        travel: job.machine.travel,
        max_feed: Some(job.machine.max_feed),
    };
    let mut findings = gcode::check(read, &rules);
    let following = Following {
        tolerance: job.cut.tolerance,
        rounding,
        radius: job.tool.radius(),
        clearance_plane: plane,
        has_runs: job.setup.arcs,
    };
    findings.extend(gcode::leaves(read, path, following));
    findings.extend(gcode::differs(read, settings));
    findings.iter().map(ToString::to_string).collect()
}

/// Least and greatest position of every axis of the machine.
fn reach_of(read: &GcodeProgram) -> Vec<ReachFigures> {
    let figures = |axis: char, unit: &str, position: &dyn Fn(usize) -> f64| {
        let all = (0..read.machine.len()).map(position);
        let (least, greatest) = all
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), p| (low.min(p), high.max(p)));
        ReachFigures { axis: axis.to_string(), least, greatest, unit: unit.to_owned() }
    };
    let linear = ['X', 'Y', 'Z'].into_iter().enumerate();
    let mut reach: Vec<ReachFigures> =
        linear.map(|(i, axis)| figures(axis, "mm", &|k| read.machine[k].linear[i])).collect();
    let letters = read.axes.chain().map(|chain| chain.letters());
    for (i, axis) in letters.into_iter().flatten().enumerate() {
        reach.push(figures(axis, "deg", &|k| read.machine[k].rotary[i].to_degrees()));
    }
    reach
}
