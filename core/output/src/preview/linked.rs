//! The numbers behind the pictures, for a page whose pictures answer to a pointer.
//!
//! A picture shows a place where its [`Placement`] puts it: a page finds the place under the
//! pointer by placing the tables' rows and looking for the nearest. Tables hold single-precision
//! numbers, a few to a row, one row after the other.

use super::channel_view::{self, ChannelScene};
use super::flat_map::{self, FlatLines};
use super::heat_map::{self, opening_rate};
use super::heat_scale::{PLAIN, Scale};
use super::mrr_chart::{self, ChartPlacement};
use super::placement::Placement;
use super::surface_view;
use crate::report::Profile;
use evencut_core::flatten::Chart;
use evencut_core::geometry::{DVec3, OrderBy};
use evencut_core::surface::Surface;
use evencut_core::toolpath::{PathPoint, Toolpath};
use evencut_core::units::{MINUTE, per_minute};
use evencut_core::verify::{Facets, Outcome, Verification};

/// Rows of the table of samples at most; more would show no more on a screen.
const MOST_SAMPLES: f64 = 200_000.0;
/// mm³/s in mm³/min, mm/s in mm/min.
/// Says that there is nothing.
const NOTHING: [f32; 3] = [f32::NAN; 3];

/// The points of the path, a row each; values of a row hold on the move that ends there.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PathTable {
    /// Kinds, as places in [`MoveKind::ALL`](evencut_core::toolpath::MoveKind::ALL).
    pub kind: Vec<u8>,
    /// Passes.
    pub pass: Vec<u32>,
    /// Regions.
    pub region: Vec<u32>,
    /// Times, s.
    pub time: Vec<f32>,
    /// Tool tips, 3 to a row, mm.
    pub tip: Vec<f32>,
    /// Tool axes, 3 to a row.
    pub axis: Vec<f32>,
    /// Places on the surface, 3 to a row, mm; not numbers away from it.
    pub contact: Vec<f32>,
    /// Places in the flat map, 2 to a row, flat mm; not numbers away from it.
    pub flat: Vec<f32>,
    /// Feeds, mm/min.
    pub feed: Vec<f32>,
    /// Removal rates, mm³/min.
    pub rate: Vec<f32>,
    /// Engagement angles, degrees.
    pub engagement: Vec<f32>,
}

/// What the judge found, thinned out: each row stands for its neighbourhood and is the worst of it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SampleTable {
    /// Places, 3 to a row, mm.
    pub place: Vec<f32>,
    /// Heights left, µm.
    pub residual: Vec<f32>,
    /// Measured removal rates when the places were opened, mm³/min; not a number where never.
    pub rate: Vec<f32>,
    /// Colours of the heights in `scallop.svg`, as places in [`Linked::residual_colours`].
    pub residual_tone: Vec<u8>,
    /// Colours of the rates in `removal.svg`, as places in [`Linked::rate_colours`].
    pub rate_tone: Vec<u8>,
    /// 0 where a move came, 1 where none did, 2 where the cutter does not fit.
    pub state: Vec<u8>,
}

/// Triangles, those of what is machined first.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MeshTable {
    /// Vertices, 3 to a row, mm.
    pub positions: Vec<f32>,
    /// Vertices of the faces, 3 to a row.
    pub faces: Vec<u32>,
    /// How many faces are machined.
    pub machined: u32,
}

/// All of it.
#[derive(Clone, Debug, PartialEq)]
pub struct Linked {
    /// Where `flat.svg` shows flat places.
    pub flat: Placement,
    /// Where `surface.svg` shows places.
    pub surface: Placement,
    /// Where `scallop.svg` does; `None` without a simulation.
    pub scallop: Option<Placement>,
    /// Where `removal.svg` does.
    pub removal: Option<Placement>,
    /// Where `channel.svg` does; `None` without the channel of a hub.
    pub channel: Option<Placement>,
    /// Where `mrr.svg` shows times and rates.
    pub chart: ChartPlacement,
    /// The path that is delivered.
    pub path: PathTable,
    /// Times of the plain rings, s, and their removal rates, mm³/min.
    pub plain: [Vec<f32>; 2],
    /// The judge's samples.
    pub samples: SampleTable,
    /// What is drawn in three dimensions.
    pub mesh: MeshTable,
    /// Largest removal rate allowed, mm³/min; `None` where none is, and then no rate is predicted.
    pub limit: Option<f64>,
    /// Height of cusps that is allowed, µm.
    pub scallop_limit: f64,
    /// Colours of removal rates from none to the limit, then of what is above it; without a limit of
    /// times from the start to the end.
    pub colours: Vec<[u8; 3]>,
    /// Colours of heights left.
    pub residual_colours: Vec<[u8; 3]>,
    /// Colours of measured rates.
    pub rate_colours: Vec<[u8; 3]>,
}

/// What the pictures of a plan were drawn of.
#[derive(Copy, Clone, Debug)]
pub struct Drawn<'a> {
    /// The surface.
    pub surface: &'a Surface,
    /// Its flat image.
    pub chart: &'a Chart,
    /// The lines of its channel.
    pub lines: &'a FlatLines,
    /// That channel, of a hub.
    pub channel: Option<ChannelScene<'a>>,
    /// The path that is delivered.
    pub path: &'a Toolpath,
    /// For each point of it the place on the surface.
    pub contacts: &'a [Option<DVec3>],
    /// The plain rings; where the rate is not limited there is no other path to compare with.
    pub plain: Option<&'a Toolpath>,
    /// Facets of the part that are not machined.
    pub rest: Facets<'a>,
    /// What the judge found.
    pub verification: Option<&'a Verification>,
    /// Limit on the removal rate, mm³/s, where there is one.
    pub limit: Option<f64>,
    /// Height of cusps that is allowed, mm.
    pub scallop: f64,
    /// By how much it may be exceeded, mm.
    pub tolerance: f64,
}

impl Linked {
    /// The numbers behind the pictures of a plan.
    pub fn of(drawn: &Drawn) -> Self {
        let (positions, faces) = drawn.surface.triangles();
        let design = Facets { positions, faces: &faces };
        let plain = drawn.plain.unwrap_or(drawn.path);
        let (before, after) = (Profile::of(plain), Profile::of(drawn.path));
        let heat = drawn.verification.map(|v| Heat::of(drawn, v));
        let [residual_colours, rate_colours] = heat
            .as_ref()
            .map_or_else(Default::default, |h| [&h.residual, &h.rate].map(Scale::colours));
        let scallop = |v| heat_map::residual_placement(design, drawn.rest, v, drawn.tolerance);
        Self {
            flat: flat_map::placement(drawn.surface, drawn.chart, drawn.lines),
            surface: surface_view::placement(drawn.surface),
            scallop: drawn.verification.map(scallop),
            removal: drawn.verification.map(|_| heat_map::rate_placement(design, drawn.rest)),
            channel: drawn
                .channel
                .map(|scene| channel_view::placement(&scene, drawn.path, drawn.contacts)),
            chart: mrr_chart::placement(&before, &after, drawn.limit.unwrap_or(0.0)),
            path: path_table(drawn.path, drawn.contacts),
            plain: [single(&before.time, 1.0), single(&before.mrr, MINUTE)],
            samples: heat.as_ref().map_or_else(SampleTable::default, |heat| heat.table(drawn)),
            residual_colours,
            rate_colours,
            mesh: mesh_table(design, drawn.rest),
            limit: drawn.limit.map(per_minute),
            scallop_limit: 1e3 * drawn.scallop,
            colours: super::path_layers::colours().map(|c| c.0).to_vec(),
        }
    }
}

fn single(values: &[f64], factor: f64) -> Vec<f32> {
    values.iter().map(|v| (factor * v) as f32).collect()
}

fn path_table(path: &Toolpath, contacts: &[Option<DVec3>]) -> PathTable {
    let points = &path.points;
    let number = |value: fn(&PathPoint) -> f64| points.iter().map(|p| value(p) as f32).collect();
    let vector = |value: fn(&PathPoint) -> DVec3| {
        points.iter().flat_map(|p| value(p).as_vec3().to_array()).collect()
    };
    let contact = |c: &Option<DVec3>| c.map_or(NOTHING, |c| c.as_vec3().to_array());
    let flat = |p: &PathPoint| p.flat.map_or([f32::NAN; 2], |f| f.as_vec2().to_array());
    PathTable {
        kind: points.iter().map(|p| p.kind as u8).collect(),
        pass: points.iter().map(|p| p.pass).collect(),
        region: points.iter().map(|p| p.region).collect(),
        time: number(|p| p.time),
        tip: vector(|p| p.tip),
        axis: vector(|p| p.axis),
        contact: contacts.iter().flat_map(contact).collect(),
        flat: points.iter().flat_map(flat).collect(),
        feed: number(|p| per_minute(p.feed)),
        rate: number(|p| per_minute(p.mrr)),
        engagement: number(|p| p.alpha.to_degrees()),
    }
}

/// What the judge found, with the colours of its pictures.
struct Heat<'a> {
    verification: &'a Verification,
    tolerance: f64,
    residual: Scale,
    rate: Scale,
}

impl<'a> Heat<'a> {
    fn of(drawn: &Drawn, verification: &'a Verification) -> Self {
        let has_rest = !drawn.rest.faces.is_empty();
        let (limit, tolerance) = (Some(drawn.scallop), drawn.tolerance);
        Self {
            verification,
            tolerance,
            residual: heat_map::residual_scale(has_rest, verification, limit, tolerance),
            rate: heat_map::rate_scale(has_rest, &verification.rate, drawn.limit),
        }
    }

    /// The worst sample of each cube of a grid that is as fine as the largest table allows.
    fn table(&self, drawn: &Drawn) -> SampleTable {
        let cube = (drawn.surface.area() / MOST_SAMPLES).sqrt().max(f64::MIN_POSITIVE);
        let cell = |s: &Outcome| s.position.map(|x| (f64::from(x) / cube).floor() as i64);
        let samples = self.verification.samples.iter().filter(|s| s.machined);
        let mut rows: Vec<([i64; 3], &Outcome)> = samples.map(|s| (cell(s), s)).collect();
        rows.order_by(|a, b| a.0.cmp(&b.0).then(b.1.residual.abs().total_cmp(&a.1.residual.abs())));
        rows.dedup_by_key(|row| row.0);
        let mut table = SampleTable::default();
        rows.iter().for_each(|(_, s)| self.push(&mut table, s, drawn.path));
        table
    }

    fn push(&self, table: &mut SampleTable, sample: &Outcome, path: &Toolpath) {
        let rate = opening_rate(sample, path, &self.verification.rate);
        let height = heat_map::residual_mark(sample, &self.residual, self.tolerance);
        table.place.extend(sample.position);
        table.residual.push(1e3 * sample.residual);
        table.rate.push(rate.map_or(f32::NAN, |r| (per_minute(r)) as f32));
        table.residual_tone.push(height.map_or(PLAIN, |mark| mark.tone));
        table.rate_tone.push(heat_map::rate_mark(rate, &self.rate).tone);
        table.state.push(state(sample));
    }
}

fn state(sample: &Outcome) -> u8 {
    match (sample.inaccessible, sample.is_cut()) {
        (true, _) => 2,
        (_, false) => 1,
        _ => 0,
    }
}

fn mesh_table(design: Facets, rest: Facets) -> MeshTable {
    let shift = design.positions.len() as u32;
    let rest_positions = if rest.faces.is_empty() { &[][..] } else { rest.positions };
    let positions = design.positions.iter().chain(rest_positions);
    MeshTable {
        positions: positions.flat_map(|p| p.as_vec3().to_array()).collect(),
        faces: design
            .faces
            .iter()
            .copied()
            .chain(rest.faces.iter().map(|f| f.map(|v| v + shift)))
            .flatten()
            .collect(),
        machined: design.faces.len() as u32,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::preview::samples;
    use evencut_core::tool::Tool;
    use evencut_core::verify::{VerifyOptions, verify};

    const NO_REST: Facets = Facets { positions: &[], faces: &[] };

    fn judged(s: &samples::Sample, path: &Toolpath) -> Verification {
        let (positions, faces) = s.surface.triangles();
        let options = VerifyOptions {
            tool: Tool::new(5.0, 5.0).unwrap(),
            length: f64::INFINITY,
            depth: 0.5,
            tells_rate: true,
            earlier: None,
            allowance: 0.0,
            scallop: Some(0.03),
            tolerance: 0.005,
            mrr_limit: Some(samples::LIMIT),
            load: None,
            spacing: 0.5,
            up: DVec3::Z,
            inaccessible: Vec::new(),
            bridges: Vec::new(),
            walls: None,
            above: None,
            stock: None,
            avoided: Vec::new(),
            threads: 1,
        };
        let design = Facets { positions, faces: &faces };
        verify(path, design, NO_REST, &options, &mut |_| {}).unwrap()
    }

    fn linked(s: &samples::Sample, path: &Toolpath, judged: Option<&Verification>) -> Linked {
        Linked::of(&Drawn {
            surface: &s.surface,
            chart: &s.chart,
            lines: &FlatLines::default(),
            channel: None,
            path,
            contacts: &s.contacts(path),
            plain: None,
            rest: NO_REST,
            verification: judged,
            limit: Some(samples::LIMIT),
            scallop: 0.03,
            tolerance: 0.005,
        })
    }

    #[test]
    fn tables_have_a_row_for_every_point() {
        let s = samples::bump(20);
        let path = samples::rings(&s, 3_000);
        let linked = linked(&s, &path, None);
        let t = &linked.path;
        let singles = [t.time.len(), t.feed.len(), t.rate.len(), t.engagement.len(), t.kind.len()];
        assert_eq!(singles, [3_000; 5]);
        let triples = [t.tip.len(), t.axis.len(), t.contact.len(), t.flat.len() * 3 / 2];
        assert_eq!(triples, [9_000; 4]);
        assert_eq!(linked.mesh.machined, 800);
        assert_eq!((linked.scallop, linked.samples), (None, SampleTable::default()));
    }

    #[test]
    fn placements_are_those_of_the_pictures() {
        // A path of one move: its line in each picture starts at its placed contact.
        let s = samples::bump(20);
        let mut path = samples::rings(&s, 3_000);
        path.points.truncate(2);
        let linked = linked(&s, &path, None);
        let starts = |svg: &str, at: [f64; 2]| {
            let [x, y] = at.map(|v| (100.0 * v).round());
            assert!(svg.contains(&format!("\"M{x} {y}l")), "{x} {y}");
        };
        let flat = path.points[0].flat.unwrap().extend(0.0);
        let svg = flat_map::flat_map(
            &s.surface,
            &s.chart,
            &FlatLines::default(),
            &path,
            Some(samples::LIMIT),
        );
        starts(&svg, linked.flat.place(flat));
        let contacts = s.contacts(&path);
        let svg = surface_view::surface_view(&s.surface, &path, &contacts, Some(samples::LIMIT));
        starts(&svg, linked.surface.place(contacts[0].unwrap()));
    }

    #[test]
    fn the_highest_residual_stays_in_the_table() {
        let s = samples::bump(20);
        let path = samples::rings(&s, 3_000);
        let judged = judged(&s, &path);
        let linked = linked(&s, &path, Some(&judged));
        let highest = |values: &mut dyn Iterator<Item = f32>| values.fold(0.0, f32::max);
        let all = highest(&mut judged.samples.iter().map(|s| 1e3 * s.residual));
        assert_eq!(highest(&mut linked.samples.residual.iter().copied()), all);
        assert_eq!(linked.samples.place.len(), 3 * linked.samples.state.len());
        let tones = linked.samples.residual_tone.iter().map(|&t| usize::from(t));
        assert!(tones.max().unwrap() < linked.residual_colours.len());
        assert_eq!(linked.samples.rate_tone.len(), linked.samples.state.len());
        assert!(linked.scallop.is_some() && linked.removal.is_some());
    }
}
