//! What a job does not say of its machine, filled in from the file that describes it.
//!
//! The file has the keys of the job's `[machine]`, at its top; lengths in mm, whatever the job's unit.

use super::beside::{Beside, Load};
use super::document::{Document, read_table};
use super::fault::Fault;
use super::file::{MachineTable, RotaryTable, TravelTable, Units};
use super::units::INCH;

use toml::de::DeTable;

/// Fills in the machine of a document from its file; what is wrong with that is noted.
///
/// `load` gives the file's content. Returns its name and content, where the job names one that can be had.
pub(super) fn take(document: &mut Document, load: &mut Load<'_>) -> Option<(String, Vec<u8>)> {
    let name = document.file.machine.file.clone()?;
    let bytes = match load(Beside::Machine, &name) {
        Ok(bytes) => bytes,
        Err(fault) => {
            document.note(fault);
            return None;
        }
    };
    match read(&bytes) {
        Ok(machine) => fill(document, machine),
        Err(message) => {
            let fault = Fault::new("machine.file", format!("{name}: {message}"));
            document.note(fault.help("it has the keys of [machine], lengths in mm"));
        }
    }
    Some((name, bytes))
}

/// The table of a file, or what is wrong with it, with its line.
fn read(bytes: &[u8]) -> Result<MachineTable, String> {
    let source = std::str::from_utf8(bytes).map_err(|_| "it is no text (UTF-8)".to_owned())?;
    let line = |at: usize| 1 + source.bytes().take(at).filter(|b| *b == b'\n').count();
    let table = DeTable::parse(source).map_err(|error| {
        let message = error.message().split_whitespace().collect::<Vec<_>>().join(" ");
        format!("line {}: {message}", line(error.span().map_or(0, |span| span.start)))
    })?;
    let (machine, faults) = read_table::<MachineTable>("machine", table.get_ref(), 1.0);
    if let Some(fault) = faults.0.first() {
        let at = fault.span.as_ref().map_or(1, |span| line(span.start));
        let key = fault.key.trim_start_matches("machine.");
        let help = fault.help.first().map_or_else(String::new, |help| format!("; {help}"));
        return Err(format!("line {at}: {key}: {}{help}", fault.message));
    }
    match machine.file {
        Some(_) => Err("file: a machine's file names no other".to_owned()),
        None => Ok(machine),
    }
}

/// What the job says itself stays.
fn fill(document: &mut Document, machine: MachineTable) {
    let unit = match document.file.units {
        Some(Units::Inch) => INCH,
        Some(Units::Mm) | None => 1.0,
    };
    let length = |value: Option<f64>| value.map(|length| length / unit);
    let pair = |pair: [f64; 2]| pair.map(|end| end / unit);
    let travel = |travel: TravelTable| TravelTable {
        x: travel.x.map(pair),
        y: travel.y.map(pair),
        z: travel.z.map(pair),
    };
    let rotary = |axis: RotaryTable| RotaryTable {
        centre: axis.centre.map(|centre| centre.map(|c| c / unit)),
        ..axis
    };
    let given = |key: &str| document.places.has(&format!("machine.{key}"));
    // Axes by name and axes by description say the same.
    let has_axes = given("axes") || given("rotary");
    let free = |key: &str| !given(key);
    let own = document.file.machine.clone();
    document.file.machine = MachineTable {
        file: own.file,
        axes: own.axes.or(machine.axes.filter(|_| !has_axes)),
        rotary: own.rotary.or(machine
            .rotary
            .filter(|_| !has_axes)
            .map(|axes| axes.into_iter().map(rotary).collect())),
        pivot_length: own
            .pivot_length
            .or(length(machine.pivot_length).filter(|_| free("pivot_length"))),
        max_feed: own.max_feed.or(length(machine.max_feed).filter(|_| free("max_feed"))),
        max_acceleration: own
            .max_acceleration
            .or(length(machine.max_acceleration).filter(|_| free("max_acceleration"))),
        max_rotary_speed: own
            .max_rotary_speed
            .or(machine.max_rotary_speed.filter(|_| free("max_rotary_speed"))),
        max_rotary_acceleration: own
            .max_rotary_acceleration
            .or(machine.max_rotary_acceleration.filter(|_| free("max_rotary_acceleration"))),
        clearance: own.clearance.or(length(machine.clearance).filter(|_| free("clearance"))),
        work_offset: own.work_offset.or(machine.work_offset.filter(|_| free("work_offset"))),
        travel: own.travel.or(machine.travel.filter(|_| free("travel")).map(travel)),
    };
}

#[cfg(test)]
mod tests {
    use crate::job::{Faults, Resolved, read_with};

    const FILE: &str = "max_feed = 6000.0\nmax_acceleration = 900.0\nclearance = 25.4\n[travel]\n\
                        x = [-254.0, 254.0]\n[[rotary]]\nletter = \"C\"\ncarries = \"table\"\n\
                        centre = [0.0, 0.0, -50.8]\nmax_speed = 30.0\n[[rotary]]\nletter = \"B\"\n\
                        carries = \"table\"\n";

    fn job(unit: &str, machine: &str, file: &str) -> Result<Resolved, Faults> {
        let text = format!(
            "version = 1\nunits = \"{unit}\"\n[surface.analytic]\nkind = \"plane\"\n[tool]\ndiameter = 1.0\n\
             [cut]\nstepover = 0.1\nfeed = 10.0\n[machine]\n{machine}"
        );
        read_with(text.as_bytes(), &mut |_, _| Ok(file.as_bytes().to_vec()))
    }

    #[test]
    fn a_machine_of_a_file_is_that_of_its_values() {
        let whole = job(
            "mm",
            &FILE
                .replace("[travel]", "[machine.travel]")
                .replace("[[rotary]]", "[[machine.rotary]]"),
            "",
        );
        let of_file = job("mm", "file = \"a.machine.toml\"", FILE).unwrap();
        assert_eq!(of_file.job, whole.unwrap().job);
        assert_eq!(of_file.beside, [("a.machine.toml".to_owned(), FILE.as_bytes().to_vec())]);
        // Its lengths are mm in a job in inches, too.
        let inches = job("inch", "file = \"a.machine.toml\"", FILE).unwrap().job.machine;
        assert_eq!(inches, of_file.job.machine);
    }

    #[test]
    fn what_the_job_says_itself_stays() {
        let own =
            job("mm", "file = \"a.toml\"\nmax_feed = 5000.0\naxes = \"xyzac\"\n", FILE).unwrap();
        let machine = own.job.machine;
        assert!((machine.max_feed - 5000.0 / 60.0).abs() < 1e-9);
        assert_eq!(machine.axes.chain().unwrap().letters(), ['C', 'A']);
        assert!((machine.max_acceleration - 900.0).abs() < 1e-9);
    }

    #[test]
    fn what_is_wrong_with_a_file_is_named_with_its_line() {
        let refused =
            |file: &str| job("mm", "file = \"a.toml\"", file).unwrap_err().render("a.toml", b"");
        for (file, parts) in [
            (
                "max_feed = 6000.0\nmax_fed = 3.0\n",
                ["line 2: max_fed: unknown key", "did you mean `max_feed`"],
            ),
            ("max_feed = -1.0\n", ["line 1: max_feed: -1.0 is out of range", "expected"]),
            ("[[rotary]\n", ["line 1:", "machine.file"]),
            ("file = \"b\"\n", ["names no other", "keys of [machine]"]),
            ("[[rotary]]\nletter = \"C\"\n", ["rotary", "machine.file"]),
        ] {
            let message = refused(file);
            assert!(parts.iter().all(|part| message.contains(part)), "{message}");
        }
    }
}
