//! The waist: the path that is delivered, as typed points with feed, axis and purpose.

use crate::geometry::{DVec2, DVec3, Shown};
use crate::units::{per_minute, per_second};
use std::ops::{Index, IndexMut};
use thiserror::Error;

/// What a move is for.
#[derive(Copy, Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum MoveKind {
    /// Along a pass.
    Cut,
    /// The cutting part of a trochoid.
    Trochoid,
    /// The part of a trochoid loop that cuts nothing.
    Return,
    /// Between passes at feed, on the surface, approaching or retracting.
    Link,
    /// At rapid speed, above the clearance height.
    Rapid,
}

impl MoveKind {
    /// All kinds, in the order of [`PerKind`].
    pub const ALL: [Self; 5] = [Self::Cut, Self::Trochoid, Self::Return, Self::Link, Self::Rapid];

    /// Its name in `toolpath.csv`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Cut => "cut",
            Self::Trochoid => "trochoid",
            Self::Return => "return",
            Self::Link => "link",
            Self::Rapid => "rapid",
        }
    }
}

/// A number for each kind of move.
#[derive(Copy, Clone, Debug, PartialEq, Default)]
pub struct PerKind([f64; 5]);

impl PerKind {
    /// Sum over the kinds.
    pub fn total(&self) -> f64 {
        self.0.iter().sum()
    }
}

impl Index<MoveKind> for PerKind {
    type Output = f64;
    fn index(&self, kind: MoveKind) -> &f64 {
        &self.0[kind as usize]
    }
}

impl IndexMut<MoveKind> for PerKind {
    fn index_mut(&mut self, kind: MoveKind) -> &mut f64 {
        &mut self.0[kind as usize]
    }
}

/// Sums over a path.
#[derive(Copy, Clone, Debug, PartialEq, Default)]
pub struct Statistics {
    /// Travel of the tip, mm.
    pub length: PerKind,
    /// Time from the points' own `time`, s.
    pub time: PerKind,
    /// Largest predicted removal rate, mm³/s.
    pub peak_mrr: f64,
}

/// The end of a move; the move starts at the point before. The first point is where the path starts.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct PathPoint {
    /// Purpose of the move that ends here.
    pub kind: MoveKind,
    /// Index of the pass, in cutting order.
    pub pass: u32,
    /// Index of the region.
    pub region: u32,
    /// Tool tip, mm.
    pub tip: DVec3,
    /// Unit tool axis, from the tip to the spindle.
    pub axis: DVec3,
    /// Unit surface normal at the contact, toward the tool; the axis where there is no contact.
    pub normal: DVec3,
    /// Flat image of the contact, flat mm; `None` away from the surface.
    pub flat: Option<DVec2>,
    /// Feed of the move that ends here, mm/s, measured at the contact.
    pub feed: f64,
    /// Largest predicted removal rate on the move that ends here, mm³/s.
    pub mrr: f64,
    /// Engagement angle of the disc in the plane, rad; 0 where it is not known.
    pub alpha: f64,
    /// Time at which the point is reached with the feeds as commanded, s.
    pub time: f64,
}

impl PathPoint {
    /// The point a part `t` of the way on the straight move from here to `end`.
    pub fn toward(&self, end: &Self, t: f64) -> Self {
        let between = |u: DVec3, v: DVec3| u.lerp(v, t).normalize_or(v);
        Self {
            tip: self.tip.lerp(end.tip, t),
            axis: between(self.axis, end.axis),
            normal: between(self.normal, end.normal),
            // At the start of a run the contact is not known; the image stays that of the end.
            flat: end.flat.map(|to| self.flat.map_or(to, |from| from.lerp(to, t))),
            ..*end
        }
    }
}

/// What the disc in the plane predicts for a move.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Planar {
    /// Mean removal rate in the plane, flat mm² times mm per s.
    pub mrr2: f64,
    /// Area of the surface over that of the plane.
    pub tau: f64,
    /// Engagement angle where the rate is largest, rad.
    pub alpha: f64,
}

impl Planar {
    /// Mean removal rate on the surface, mm³/s.
    pub fn mrr3(&self) -> f64 {
        self.tau * self.mrr2
    }
}

/// The path that is delivered.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct Toolpath {
    /// The points, in cutting order.
    pub points: Vec<PathPoint>,
}

/// Header of `toolpath.csv`: tip in mm, unit axis and normal, feed in mm/min, removal rate in
/// mm³/min, engagement in degrees, time in s; then the plane's prediction, empty where there is none.
pub const CSV_HEADER: &str = "pass,region,kind,x,y,z,i,j,k,nx,ny,nz,feed,mrr,alpha,t,mrr2,tau,mrr3";
/// Number of the columns that a table may lack: the prediction.
const PREDICTED: usize = 3;

/// Names of the columns, for messages.
const COLUMNS: [&str; 19] = [
    "pass", "region", "kind", "x", "y", "z", "i", "j", "k", "nx", "ny", "nz", "feed", "mrr",
    "alpha", "t", "mrr2", "tau", "mrr3",
];

/// What a `toolpath.csv` may not be.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum CsvError {
    /// The first line is another header.
    #[error("toolpath.csv, line 1: header \"{found}\"; it must be \"{CSV_HEADER}\"")]
    Header {
        /// The line found.
        found: String,
    },
    /// A row has another number of fields.
    #[error(
        "toolpath.csv, line {line}: {found} fields; a row has 19, or 16 under a header without the last three"
    )]
    Fields {
        /// Line, from 1.
        line: usize,
        /// How many fields.
        found: usize,
    },
    /// A field is not what its column holds.
    #[error("toolpath.csv, line {line}, column {column}: \"{found}\"; {expected}")]
    Field {
        /// Line, from 1.
        line: usize,
        /// Column name.
        column: &'static str,
        /// The field's text.
        found: String,
        /// What it must be.
        expected: &'static str,
    },
    /// An axis or a normal is not a unit vector.
    #[error(
        "toolpath.csv, line {line}, column {column}: a vector of length {}; it must be 1",
        Shown(*length)
    )]
    NotUnit {
        /// Line, from 1.
        line: usize,
        /// First column of the vector.
        column: &'static str,
        /// Its length.
        length: f64,
    },
}

impl Toolpath {
    /// For each point how far the farther end of the move to it is from the nearest link along the path, mm; 0 on links.
    pub fn away_from_links(&self) -> Vec<f64> {
        let points = &self.points;
        let is_pass = |i: usize| matches!(points[i].kind, MoveKind::Cut | MoveKind::Trochoid);
        let length = |i: usize| if i > 0 { points[i].tip.distance(points[i - 1].tip) } else { 0.0 };
        let run = |order: &mut dyn Iterator<Item = usize>| {
            let mut away = vec![0.0; points.len()];
            let mut travelled = f64::INFINITY;
            for i in order {
                travelled = match points[i].kind {
                    MoveKind::Link | MoveKind::Rapid => 0.0,
                    _ => travelled + length(i),
                };
                away[i] = if is_pass(i) { travelled } else { 0.0 };
            }
            away
        };
        let (after, before) = (run(&mut (0..points.len())), run(&mut (0..points.len()).rev()));
        after.into_iter().zip(before).map(|(a, b)| f64::min(a, b)).collect()
    }

    /// Lengths and times per kind of move.
    pub fn statistics(&self) -> Statistics {
        let mut sums = Statistics::default();
        for pair in self.points.windows(2) {
            let kind = pair[1].kind;
            sums.length[kind] += pair[1].tip.distance(pair[0].tip);
            sums.time[kind] += pair[1].time - pair[0].time;
            sums.peak_mrr = sums.peak_mrr.max(pair[1].mrr);
        }
        sums
    }

    /// How often the cutter leaves the part to go on elsewhere.
    pub fn retracts(&self) -> usize {
        let is_rapid = |p: &PathPoint| p.kind == MoveKind::Rapid;
        self.points.windows(2).filter(|w| is_rapid(&w[1]) && !is_rapid(&w[0])).count()
    }

    /// The path as text: [`CSV_HEADER`] and a row a point. `planar`: the prediction for each point, or for none.
    pub fn to_csv(&self, planar: &[Option<Planar>]) -> String {
        let mut out = String::with_capacity(180 * self.points.len() + CSV_HEADER.len() + 1);
        out.push_str(CSV_HEADER);
        out.push('\n');
        for (i, p) in self.points.iter().enumerate() {
            push_fixed(&mut out, f64::from(p.pass), 0);
            out.push(',');
            push_fixed(&mut out, f64::from(p.region), 0);
            out.push(',');
            out.push_str(p.kind.name());
            for (vector, decimals) in [(p.tip, 6), (p.axis, 9), (p.normal, 9)] {
                for value in vector.to_array() {
                    out.push(',');
                    push_fixed(&mut out, value, decimals);
                }
            }
            let rest = [
                (per_minute(p.feed), 4),
                (per_minute(p.mrr), 4),
                (p.alpha.to_degrees(), 4),
                (p.time, 6),
            ];
            for (value, decimals) in rest {
                out.push(',');
                push_fixed(&mut out, value, decimals);
            }
            match planar.get(i).copied().flatten() {
                Some(p) => {
                    let prediction =
                        [(per_minute(p.mrr2), 4), (p.tau, 6), (per_minute(p.mrr3()), 4)];
                    for (value, decimals) in prediction {
                        out.push(',');
                        push_fixed(&mut out, value, decimals);
                    }
                }
                None => out.push_str(",,,"),
            }
            out.push('\n');
        }
        out
    }

    /// The path from such a text, or one without the last three columns; flat images and the plane's prediction are not part of it.
    ///
    /// # Errors
    /// [`CsvError`], naming line and column.
    pub fn from_csv(text: &str) -> Result<Self, CsvError> {
        let mut lines = text.lines();
        let header = lines.next().unwrap_or_default().trim_start_matches('\u{feff}').trim();
        if ![COLUMNS.len() - PREDICTED, COLUMNS.len()]
            .iter()
            .any(|&n| header == COLUMNS[..n].join(","))
        {
            return Err(CsvError::Header { found: header.escape_debug().take(SHOWN).collect() });
        }
        let rows = lines.enumerate().filter(|(_, row)| !row.trim().is_empty());
        let columns = header.split(',').count();
        let points =
            rows.map(|(i, row)| read_row(row, i + 2, columns)).collect::<Result<_, _>>()?;
        Ok(Self { points })
    }
}

/// Longest piece of a table in a message, characters; the right header has 73.
const SHOWN: usize = 80;
/// Largest coordinate of a path, mm; programs are held to the same.
const LARGEST: f64 = 1e7;

fn read_row(row: &str, line: usize, columns: usize) -> Result<PathPoint, CsvError> {
    let fields: Vec<&str> = row.split(',').map(str::trim).collect();
    if fields.len() != columns {
        return Err(CsvError::Fields { line, found: fields.len() });
    }
    let wrong = |c: usize, expected| CsvError::Field {
        line,
        column: COLUMNS[c],
        found: fields[c].escape_debug().take(SHOWN).collect(),
        expected,
    };
    let count = |c: usize| {
        fields[c].parse::<u32>().map_err(|_| wrong(c, "it must be a whole number from 0"))
    };
    let number = |c: usize| match fields[c].parse::<f64>() {
        Ok(value) if value.is_finite() => Ok(value),
        _ => Err(wrong(c, "it must be a finite number")),
    };
    let vector = |c: usize| Ok(DVec3::new(number(c)?, number(c + 1)?, number(c + 2)?));
    let length = |c: usize| match number(c)? {
        value if value.abs() <= LARGEST => Ok(value),
        _ => Err(wrong(c, "it must be at most 10 km")),
    };
    let unit = |c: usize| {
        let v: DVec3 = vector(c)?;
        let length = v.length();
        if (length - 1.0).abs() > 1e-4 {
            return Err(CsvError::NotUnit { line, column: COLUMNS[c], length });
        }
        Ok(v / length)
    };
    let predicted = (COLUMNS.len() - PREDICTED..columns).filter(|&c| !fields[c].is_empty());
    predicted.map(number).collect::<Result<Vec<_>, _>>()?;
    let kind = MoveKind::ALL
        .into_iter()
        .find(|kind| kind.name() == fields[2])
        .ok_or_else(|| wrong(2, "it must be cut, trochoid, return, link or rapid"))?;
    Ok(PathPoint {
        kind,
        pass: count(0)?,
        region: count(1)?,
        tip: DVec3::new(length(3)?, length(4)?, length(5)?),
        axis: unit(6)?,
        normal: unit(9)?,
        flat: None,
        feed: per_second(number(12)?),
        mrr: per_second(number(13)?),
        alpha: number(14)?.to_radians(),
        time: number(15)?,
    })
}

/// Appends a number with fixed decimals, halves rounded away from zero, and never a negative zero.
pub fn push_fixed(out: &mut String, value: f64, decimals: u32) {
    let scale = 10u64.pow(decimals);
    let scaled = (value * scale as f64).round();
    if scaled.is_nan() || scaled.abs() >= 9e15 {
        // Beyond exact integers; also names what is not a number.
        out.push_str(&format!("{value:.*}", decimals as usize));
        return;
    }
    if scaled < 0.0 {
        out.push('-');
    }
    let mut number = scaled.abs() as u64;
    // 16 digits of the number and the point.
    let mut buffer = [0u8; 24];
    let mut at = buffer.len();
    let mut written = 0;
    while number > 0 || written <= decimals {
        if written == decimals && decimals > 0 {
            at -= 1;
            buffer[at] = b'.';
        }
        at -= 1;
        buffer[at] = b'0' + (number % 10) as u8;
        number /= 10;
        written += 1;
    }
    out.extend(buffer[at..].iter().map(|&b| char::from(b)));
}

#[cfg(test)]
mod tests {
    use super::*;

    fn point(kind: MoveKind, tip: DVec3, time: f64) -> PathPoint {
        PathPoint {
            kind,
            pass: 3,
            region: 1,
            tip,
            axis: DVec3::new(0.6, 0.0, 0.8),
            normal: DVec3::Z,
            flat: None,
            feed: 20.0,
            mrr: 1.5,
            alpha: 0.25,
            time,
        }
    }

    #[test]
    fn the_first_approach_is_no_retract() {
        use MoveKind::{Cut, Link, Rapid};
        let kinds = [Rapid, Rapid, Link, Cut, Link, Rapid, Rapid, Link, Cut, Cut, Rapid, Cut];
        let points = kinds.map(|kind| point(kind, DVec3::ZERO, 0.0)).to_vec();
        assert_eq!(Toolpath { points }.retracts(), 2);
        assert_eq!(Toolpath::default().retracts(), 0);
    }

    #[test]
    fn numbers_have_fixed_digits_and_no_negative_zero() {
        let text = |value, decimals| {
            let mut out = String::new();
            push_fixed(&mut out, value, decimals);
            out
        };
        assert_eq!(text(0.0, 0), "0");
        assert_eq!(text(-0.00004, 4), "0.0000");
        assert_eq!(text(-0.00005, 4), "-0.0001");
        assert_eq!(text(12.5, 3), "12.500");
        assert_eq!(text(-1234.0, 0), "-1234");
        assert_eq!(text(0.05, 6), "0.050000");
        assert_eq!(text(999999.9999999, 6), "1000000.000000");
        assert_eq!(text(1e17, 2), "100000000000000000.00");
    }

    #[test]
    fn csv_gives_the_path_back() {
        let path = Toolpath {
            points: vec![
                point(MoveKind::Rapid, DVec3::new(1.0, -2.5, 3.000001), 0.0),
                point(MoveKind::Trochoid, DVec3::new(-1e-9, 100.25, 0.0), 1.5),
            ],
        };
        let text = path.to_csv(&[None, Some(Planar { mrr2: 0.75, tau: 2.0, alpha: 0.25 })]);
        let mut lines = text.lines();
        assert_eq!(lines.next(), Some(CSV_HEADER));
        assert!(lines.next().unwrap().starts_with("3,1,rapid,1.000000,-2.500000,3.000001,0.6"));
        assert!(lines.next().unwrap().ends_with(",45.0000,2.000000,90.0000"));
        let back = Toolpath::from_csv(&text).unwrap();
        for (a, b) in path.points.iter().zip(&back.points) {
            assert_eq!((a.kind, a.pass, a.region), (b.kind, b.pass, b.region));
            assert!(a.tip.distance(b.tip) < 1e-6 && a.axis.distance(b.axis) < 1e-8);
            assert!((a.feed - b.feed).abs() < 1e-5 && (a.time - b.time).abs() < 1e-6);
            assert!((a.mrr - b.mrr).abs() < 1e-5 && (a.alpha - b.alpha).abs() < 1e-5);
        }
        // A table of 16 columns, without the prediction, is the same path.
        let cut = |line: &str| line.split(',').take(16).collect::<Vec<_>>().join(",");
        let short: Vec<String> = text.lines().map(cut).collect();
        assert_eq!(Toolpath::from_csv(&short.join("\n")).unwrap(), back);
    }

    #[test]
    fn csv_errors_name_line_and_column() {
        let row = "0,0,cut,0,0,0,0,0,1,0,0,1,1,1,1,1,,1,2";
        let read = |row: &str| Toolpath::from_csv(&format!("{CSV_HEADER}\n{row}\n")).unwrap_err();
        assert!(matches!(Toolpath::from_csv("x,y"), Err(CsvError::Header { .. })));
        assert_eq!(read("1,2"), CsvError::Fields { line: 2, found: 2 });
        let column = |e| match e {
            CsvError::Field { line: 2, column, .. } => column,
            other => panic!("{other}"),
        };
        assert_eq!(column(read(&row.replacen("cut", "dig", 1))), "kind");
        assert_eq!(column(read(&row.replacen("cut,0", "cut,inf", 1))), "x");
        assert_eq!(column(read(&row.replacen("0", "-1", 1))), "pass");
        assert_eq!(column(read(&row.replacen("cut,0", "cut,1e9", 1))), "x");
        assert_eq!(column(read(&row.replacen("1,2", "1,x", 1))), "mrr3");
        let bent = read("0,0,cut,0,0,0,0,0,2,0,0,1,1,1,1,1,,,");
        assert_eq!(bent, CsvError::NotUnit { line: 2, column: "i", length: 2.0 });
    }

    #[test]
    fn statistics_are_per_kind() {
        let path = Toolpath {
            points: vec![
                point(MoveKind::Rapid, DVec3::ZERO, 0.0),
                point(MoveKind::Cut, DVec3::X * 3.0, 1.0),
                point(MoveKind::Link, DVec3::new(3.0, 4.0, 0.0), 1.5),
                point(MoveKind::Cut, DVec3::Y * 4.0, 3.0),
            ],
        };
        let sums = path.statistics();
        assert_eq!(sums.length[MoveKind::Cut], 6.0);
        assert_eq!(sums.length[MoveKind::Link], 4.0);
        assert_eq!(sums.time[MoveKind::Cut], 2.5);
        assert_eq!(sums.length.total(), 10.0);
    }
}
