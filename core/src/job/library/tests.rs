use super::{LibraryError, ToolLibrary};
use crate::job::{self, Job};
use crate::machine::SpindleDirection;
use crate::tool::AssemblyPart;

const OWN: &str = include_str!("../../../../fuzz/seeds/tools/own.toml");
const BALL: &str = include_str!("../../../../fuzz/seeds/tools/ball.fctb");
const BULL: &str = include_str!("../../../../fuzz/seeds/tools/bull.fctb");
const LIST: &str = include_str!("../../../../fuzz/seeds/tools/list.fctl");
const FUSION: &str = include_str!("../../../../fuzz/seeds/tools/fusion.json");

fn job_with(top: &str, tool: &str) -> String {
    format!(
        "version = 1\n{top}[surface.analytic]\nkind = \"plane\"\n[tool]\n{tool}\n[cut]\nstepover = 0.2\n\
         axial_depth = 0.2\nfeed = 100.0\n"
    )
}

fn taken(library: &str, tool: &str) -> Result<Job, String> {
    taken_in("", library, tool)
}

fn taken_in(top: &str, library: &str, tool: &str) -> Result<Job, String> {
    let text = job_with(top, &format!("library = \"shop.json\"\n{tool}"));
    let read = job::read_with(text.as_bytes(), &mut |_, _| Ok(library.as_bytes().to_vec()));
    match read {
        Ok(read) => {
            assert_eq!(read.beside, [("shop.json".to_owned(), library.as_bytes().to_vec())]);
            Ok(read.job)
        }
        Err(faults) => Err(faults.render("job.toml", text.as_bytes())),
    }
}

fn written(tool: &str) -> Job {
    let text = job_with("", tool);
    job::read(text.as_bytes())
        .unwrap_or_else(|f| panic!("{}", f.render("job", text.as_bytes())))
        .job
}

#[test]
fn a_job_with_a_library_is_the_job_with_the_values_written_out() {
    let own = "number = 7\nlength_offset = 17\nkind = \"ball\"\ndiameter = 10.0\nflutes = 2\nlength = 25.0\n\
               shank_diameter = 9.5\nstickout = 60.0\nholder = [{ diameter = 27.0, length = 20.0 }, { diameter = 34.0, \
               upper_diameter = 40.0, length = 30.0 }]";
    assert_eq!(taken(OWN, "number = 7"), Ok(written(own)));
    assert_eq!(taken(OWN, "name = \"Ball 10 long\""), Ok(written(own)));
    let ball = "diameter = 6.0\nlength = 18.0\nflutes = 2\nshank_diameter = 6.35";
    assert_eq!(taken(BALL, ""), Ok(written(ball)));
    let bull = "diameter = 8.0\ncorner_radius = 1.0\nlength = 12.7\nflutes = 4\nnumber = 9";
    assert_eq!(taken(BULL, "number = 9"), Ok(written(bull)), "it has no number of its own");
    let inch = "number = 3\ndiameter = 12.7\nflutes = 2\nlength = 25.4\nshank_diameter = 12.7\nstickout = 63.5\n";
    let holder = "holder = [{ diameter = 24, upper_diameter = 28, length = 10 }, { diameter = 40, length = 40 }]";
    let (job, same) =
        (taken(FUSION, "name = \"B-500\"").unwrap(), written(&format!("{inch}{holder}")));
    assert_eq!((job.tool, job.setup, job.flutes), (same.tool, same.setup, same.flutes));
    for (a, b) in job.assembly.sections.iter().zip(&same.assembly.sections) {
        let near = |a: [f64; 2], b: [f64; 2]| (a[0] - b[0]).abs().max((a[1] - b[1]).abs()) < 1e-12;
        assert!(a.part == b.part && near(a.heights, b.heights) && near(a.radii, b.radii));
    }
    assert_eq!(job.assembly.sections.len(), 3);
}

#[test]
fn the_written_job_has_all_values_and_no_library() {
    for (library, tool) in [(OWN, "number = 7"), (BALL, ""), (FUSION, "number = 4")] {
        let job = taken(library, tool).unwrap();
        let text = job.to_toml();
        assert!(!text.contains("library"), "{text}");
        assert_eq!(job::read(text.as_bytes()).unwrap().job, job);
    }
}

#[test]
fn what_the_job_gives_counts() {
    let job = taken(OWN, "number = 7\ndiameter = 8.0\nstickout = 40.0\nlength_offset = 3").unwrap();
    assert_eq!((job.tool.radius(), job.tool.corner_radius()), (4.0, 4.0), "a ball stays one");
    assert_eq!(
        (job.setup.tool_number, job.setup.length_offset, job.setup.diameter_offset),
        (7, 3, 3)
    );
    assert_eq!(job.assembly.sections[0].heights, [25.0, 40.0]);
    let job = taken(FUSION, "name = \"Ball 1/2\"\nnumber = 30\ndiameter = 12.0").unwrap();
    assert_eq!(
        (job.setup.tool_number, job.setup.length_offset, job.setup.diameter_offset),
        (30, 30, 30)
    );
    assert_eq!(job.tool.corner_radius(), 6.0, "a ball stays one");
    let job = taken(FUSION, "number = 4\nkind = \"flat\"").unwrap();
    assert_eq!(job.tool.corner_radius(), 0.0);
    assert_eq!((job.setup.length_offset, job.setup.diameter_offset), (14, 24));
    assert_eq!(job.setup.spindle, SpindleDirection::CounterClockwise, "a left-hand cutter");
    assert_eq!(job.assembly.cutter_length, 30.0, "flutes and neck");
    let job = taken(OWN, "number = 8\ncorner_radius = 6.0").unwrap();
    assert_eq!(job.tool.bottom_radius(), 0.0);
    // A value of the library that may not be is no matter where the job gives its own.
    let wide = FUSION.replace("\"DC\": 10", "\"DC\": 1000");
    assert!(taken(&wide, "number = 4").unwrap_err().contains("1000.0 is out of range"));
    assert_eq!(taken(&wide, "number = 4\ndiameter = 10.0"), taken(FUSION, "number = 4"));
}

#[test]
fn libraries_and_jobs_may_differ_in_units() {
    let inch = "units = \"inch\"\n[[tool]]\nkind = \"bull\"\ndiameter = 0.375\ncorner_radius = 0.0625\nholder = \
                [{ diameter = 1, length = 2 }]";
    let job = taken(inch, "").unwrap();
    assert_eq!((job.tool.radius(), job.tool.corner_radius()), (0.5 * 0.375 * 25.4, 0.0625 * 25.4));
    let units = "units = \"inch\"\n";
    let same = taken_in(units, inch, "").unwrap();
    assert_eq!((same.tool, same.assembly.sections.len()), (job.tool, job.assembly.sections.len()));
    let metric = taken_in(units, OWN, "number = 7").unwrap();
    assert!((metric.tool.radius() - 5.0).abs() < 1e-12 && metric.tool.bottom_radius() == 0.0);
    let holder = metric.assembly.sections.iter().filter(|s| s.part == AssemblyPart::Holder);
    assert!(
        holder
            .max_by(|a, b| a.heights[1].total_cmp(&b.heights[1]))
            .is_some_and(|s| (s.heights[1] - 110.0).abs() < 1e-9)
    );
    let few = taken_in(units, OWN, "number = 7\ndiameter = 0.25").unwrap();
    assert_eq!(few.tool.radius(), 0.125 * 25.4, "the job's keys are in its own unit");
}

#[test]
fn a_tool_that_is_not_there_is_answered_with_those_that_are() {
    let fault = taken(OWN, "name = \"ball 10 lng\"").unwrap_err();
    assert!(fault.contains("tool.name: shop.json has no tool \"ball 10 lng\""), "{fault}");
    assert!(fault.contains("--> job.toml:6:8"), "{fault}");
    assert!(fault.contains("the nearest name is \"Ball 10 long\" (T7)"), "{fault}");
    assert!(fault.contains("its numbers are: 7, 8"), "{fault}");
    assert!(fault.contains("`evencut tools shop.json` lists its tools"), "{fault}");
    assert_eq!(fault.matches("error: ").count(), 1, "{fault}");
    let fault = taken(OWN, "number = 9").unwrap_err();
    assert!(fault.contains("tool.number: shop.json has no tool T9"), "{fault}");
    assert!(taken(OWN, "").unwrap_err().contains("give `tool.number` or `tool.name`"));
    let twice = OWN.replace("number = 8", "number = 7");
    let fault = taken(&twice, "number = 7").unwrap_err();
    assert!(
        fault.contains("2 tools of shop.json are T7") && fault.contains("Bull 12 R2"),
        "{fault}"
    );
    let named = OWN.replace("Bull 12 R2", "Ball 10 long");
    assert!(taken(&named, "name = \"Ball 10 long\"").is_err());
    assert_eq!(taken(&named, "name = \"Ball 10 long\"\nnumber = 8"), taken(OWN, "number = 8"));
    let many: String =
        (1..100).map(|n| format!("[[tool]]\nnumber = {n}\ndiameter = 3\n")).collect();
    assert!(taken(&many, "number = 100").unwrap_err().contains("19, 20 and 79 more"));
    let text = job_with("", "diameter = 3\nname = \"Ball\"");
    let faults = job::read(text.as_bytes()).unwrap_err();
    assert!(faults.0[0].message.contains("there is no `library`"));
}

#[test]
fn what_cannot_cut_is_listed_and_refused() {
    let fault = taken(FUSION, "number = 5").unwrap_err();
    assert!(
        fault.contains("T5 \"Drill 5\" of shop.json cannot be used: drill: evencut cuts with"),
        "{fault}"
    );
    let fault = taken(LIST, "number = 2").unwrap_err();
    assert!(fault.contains("library = \"Bit/bull.fctb\""), "{fault}");
    for (shape, kind) in [("v-bit.fcstd", "v-bit"), ("/shapes/Drill.FCStd", "drill")] {
        let bit = BALL.replace("ballend.fcstd", shape);
        let found = ToolLibrary::read(bit.as_bytes()).unwrap();
        assert_eq!(found.tools[0].kind, kind);
        assert!(found.tools[0].faults()[0].contains("ball, flat and bull"));
    }
    let kinds =
        ["tapered mill", "lollipop mill", "circle segment barrel", "holder", "chamfer mill"];
    for kind in kinds {
        let library = FUSION.replace("ball end mill", kind);
        assert!(taken(&library, "number = 3").unwrap_err().contains(kind), "{kind}");
    }
    let library = ToolLibrary::read(FUSION.as_bytes()).unwrap();
    assert_eq!(library.tools.iter().map(|t| t.faults().len()).collect::<Vec<_>>(), [0, 0, 1]);
    assert_eq!((library.tools[2].number(), library.tools[2].name()), (Some(5), "Drill 5"));
}

#[test]
fn values_keep_the_rules_of_the_job() {
    let own = |from: &str, to: &str| taken(&OWN.replace(from, to), "number = 8").unwrap_err();
    assert!(own("corner_radius = 2.0", "corner_radius = 7.0").contains("7 mm is more than fits"));
    assert!(own("helix = 38.0", "helix = 80.0").contains("line 21: helix: 80.0 is out of range"));
    assert!(own("helix = 38.0", "helicks = 38.0").contains("helicks: unknown key"));
    assert!(own("helix = 38.0", "helix = \"38\"").contains("write 38 without quotes"));
    assert!(own("helix = 38.0", "library = \"x.toml\"").contains("not in a library"));
    let json = |from: &str, to: &str, n: u32| {
        taken(&FUSION.replace(from, to), &format!("number = {n}")).unwrap_err()
    };
    assert!(json("\"DC\": 10", "\"DC\": \"ten\"", 4).contains("DC is \"ten\", which is no number"));
    assert!(json("\"DC\": 10", "\"D\": 10", 4).contains("cutting diameter (DC) is missing"));
    assert!(json("\"DC\": 10", "\"DC\": -10", 4).contains("diameter: -10.0 is out of range"));
    assert!(json("\"RE\": 1,", "", 4).contains("corner radius (RE) is missing"));
    assert!(
        json("\"RE\": 0.25", "\"RE\": 0.125", 3).contains("the corner radius of a ball end is")
    );
    assert!(json("\"unit\": \"inches\"", "\"unit\": \"cubits\"", 3).contains("known: millimeters"));
    assert!(json("\"height\": 10", "\"height\": []", 3).contains("height is a list"));
    assert!(json("\"NOF\": 4", "\"NOF\": 4.5", 4).contains("NOF is 4.5, which is no whole number"));
    let bit = |from: &str, to: &str| taken(&BALL.replace(from, to), "").unwrap_err();
    assert!(bit("6.0000 mm", "6 furlongs").contains("Diameter is \"6 furlongs\""));
    assert!(bit("6.0000 mm", "0 mm").contains("diameter: 0.0 is out of range"));
    assert!(bit("\"Diameter\"", "\"Radius\"").contains("its Diameter is missing"));
}

#[test]
fn lengths_of_bits_have_units() {
    let of = |length: &str| {
        taken(&BALL.replace("6.0000 mm", length), "").map(|job| 2.0 * job.tool.radius()).ok()
    };
    assert_eq!(of("7,5 mm"), Some(7.5));
    assert_eq!(of(".25 in"), Some(6.35));
    assert_eq!(of("0.5\\\""), Some(12.7));
    assert_eq!(of("1.2 cm"), Some(12.0));
    assert_eq!(of("12"), Some(12.0));
    assert_eq!(of("1/8 in"), Some(3.175));
    assert_eq!(of("1 1/4\\\""), Some(31.75));
    for wrong in
        ["1e3 mm", "mm", "", "1,000.5 mm", "1 2 in", "1/0 in", "1/2/3 in", "/2 in", "1 /2 in"]
    {
        assert_eq!(of(wrong), None, "{wrong}");
    }
    let torus = BULL.replace("\"FlatRadius\": \"3.0 mm\"", "\"TorusRadius\": \"1.0 mm\"");
    assert_eq!(taken(&torus, ""), taken(BULL, ""));
}

#[test]
fn what_is_no_library_is_refused_and_never_taken_apart_without_end() {
    let error = |text: &str| ToolLibrary::read(text.as_bytes()).unwrap_err();
    assert_eq!(error("{}"), LibraryError::UnknownJson);
    assert_eq!(error("{\"data\": []}"), LibraryError::Empty);
    assert_eq!(error("PK\u{3}\u{4}rest"), LibraryError::Packed);
    assert_eq!(ToolLibrary::read(b"\xff\xfe").unwrap_err(), LibraryError::NotText);
    assert!(error("{\"data\": [1,}").to_string().contains("line 1 column"));
    assert!(error("").to_string().contains("TOML with [[tool]] tables"));
    assert!(error("tool = [1]\nspeed = 3").to_string().contains("line 2: speed: unknown key"));
    assert!(error("[[tool]\n").to_string().starts_with("line 1: "));
    for nested in ["[", "{\"data\":", "{\"data\":["] {
        assert!(matches!(
            error(&format!("{{\"data\": {}", nested.repeat(100_000))),
            LibraryError::Syntax(_)
        ));
        assert!(ToolLibrary::read(nested.repeat(100_000).as_bytes()).is_err());
    }
    let huge = format!("{{\"data\": [{}]}}", "[],".repeat(3 << 20));
    assert!(matches!(error(&huge), LibraryError::Large { .. }));
    let many = format!("{{\"data\": [{}0]}}", "0,".repeat(10_000));
    assert_eq!(error(&many), LibraryError::TooMany { count: 10_001 });
    let many = "[[tool]]\n".repeat(10_001);
    assert_eq!(error(&many), LibraryError::TooMany { count: 10_001 });
    let odd =
        "{\"data\": [null, 1, [], {}, {\"type\": {}, \"post-process\": 3, \"geometry\": [1]}]}";
    let library = ToolLibrary::read(odd.as_bytes()).unwrap();
    assert!(library.tools.iter().all(|tool| tool.refused.is_some()));
    assert!(taken(odd, "").is_err());
    let faults = taken("{", "number = 100000000\nname = 3").unwrap_err();
    assert!(faults.contains("tool.library: shop.json: no JSON"), "{faults}");
    let faults = taken(OWN, "number = 100000000").unwrap_err();
    assert_eq!(faults.matches("error: ").count(), 1, "{faults}");
}
