//! The channel between two blades, and the path through all channels.

use super::axes::{AxisField, AxisOptions, Stand};
use super::channel::{Channel, ROWS, part};
use super::edge::{edge_along, edge_on_hub};
use super::error::HubError;
use super::layout::{ALIKE, Edges, Layout, Part};
use super::path::{Leg, Order, Route, Shortened, Station};
use super::rest::{Gauge, TooHigh, gaps, with_rest};
use super::sides::Flanks;
use super::spline::ParameterCurve;
use super::strips::{Line, Measured, Strip, ways};
use super::wheel::Wheel;
use crate::cutter_location::{
    Clearance, Hindrance, Pose, clearance, clearance_above_end, is_clear,
};
use crate::footprint::Footprint;
use crate::geometry::{DVec2, DVec3, OrderBy};
use crate::job::{HubChannels, HubOptions, HubPasses};
use crate::nurbs::{NurbsSurface, TrimLoop};
use crate::removal::Cutter;
use crate::surface::Part as Facets;
use crate::tool::Assembly;
use crate::toolpath::{MoveKind, PathPoint, Toolpath};

/// Nodes of the field of tool axes, along a channel and across it.
const AXES: (usize, usize) = (25, 7);
/// Largest angle between tool axis and surface normal, rad: 75 degrees.
const STEEPEST: f64 = 1.309;
/// Distances of the tool from the blades above this many clearances, and mm, are not told apart.
const FAR: f64 = 10.0;
/// Share of the tolerance that a curve on the hub may be off.
const FITTED: f64 = 0.5;
/// Part of the hub's length within which the end of a blade's edge is at the rim.
const AT_RIM: f64 = 0.02;
/// Part of a turn from which on a piece of the hub is taken whole.
const WHOLE: f64 = 0.9;
/// Pieces in which an edge is drawn, and rows from one cross line that is drawn to the next.
const DRAWN: usize = 360;
const EVERY: usize = 16;
/// Distance from blades, clearances: that is aimed at where axes are chosen, that has to be kept at every point of the
/// path, since between points and by the simulation's own inaccuracy some is lost, and that of links and extensions.
const AIMED: f64 = 1.15;
const KEPT: f64 = 1.05;
const CLEAR: f64 = 1.1;
/// How often passes are made longer, and added, where they leave too much.
const ROUNDS: usize = 4;
/// Longest way between two places at which a link is tested, cutter radii, and turn of its axis, rad.
const TESTED: f64 = 0.2;
const TESTED_TURN: f64 = 0.02;
/// Ways to go over two parts of a channel.
const ORDERS: [Order; 4] = [
    Order { forward: true, back: false },
    Order { forward: false, back: false },
    Order { forward: true, back: true },
    Order { forward: false, back: true },
];

/// The surfaces of a blade, placed, mm.
#[derive(Clone, Debug)]
pub struct Blade {
    /// The surfaces, with fillets.
    pub surfaces: Vec<NurbsSurface>,
    /// Points along the edges that bound the surfaces, which are faces with such; empty where they are given whole.
    pub bounds: Vec<Vec<DVec3>>,
    /// They as triangles, seen from the air.
    pub facets: Facets,
}

impl Blade {
    /// Its edge on the hub: the bounds of its faces that lie on the hub, if they make one, else what its surfaces have
    /// in common with the hub.
    fn edge(&self, wheel: &Wheel, tolerance: f64) -> Result<ParameterCurve, HubError> {
        // Bounds of what is not the foot may make rings on the hub, too.
        let has_flanks = |edge: &ParameterCurve| Flanks::new(wheel, edge, false).is_ok();
        let edge = match edge_along(&wheel.hub, &self.bounds, tolerance)?.filter(has_flanks) {
            Some(edge) => edge,
            None => edge_on_hub(&wheel.hub, &self.surfaces, tolerance)?,
        };
        let (low, high) = wheel.ends();
        let near = AT_RIM * (high - low);
        let is_at_rim = |at: &DVec2| {
            let along = at[1 - wheel.around];
            along <= low + near || along >= high - near
        };
        let ends = [0.0, 1.0].map(|m| edge.point(m));
        match ends.iter().find(|at| !edge.is_closed() && !is_at_rim(at)) {
            Some(_) => {
                let [at, other] = ends.map(|at| wheel.place(at));
                Err(HubError::NoRing { at, other, gap: at.distance(other) })
            }
            None => Ok(edge),
        }
    }
}

/// What a passage depends on.
#[derive(Clone, Debug)]
pub struct PassageOptions<'a> {
    /// The blades.
    pub hub: &'a HubOptions,
    /// Radius of the ball, mm.
    pub radius: f64,
    /// Tolerance of the path, mm.
    pub tolerance: f64,
}

/// The channel between two blades, before passes are laid out in it.
#[derive(Clone, Debug)]
pub struct Passage {
    wheel: Wheel,
    layout: Layout,
    loops: Vec<TrimLoop>,
    /// The blades at both sides of the channel, and the splitter in it.
    blades: Facets,
    /// Edge of the blade, and of the splitter, on the hub.
    edges: Vec<ParameterCurve>,
    lines: ChannelLines,
}

/// Lines of a channel in the parameters of the hub.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ChannelLines {
    /// The edges on the hub of the blades at both sides, and of the splitter.
    pub edges: Vec<Vec<DVec2>>,
    /// Lines of the map of the channel that run across it.
    pub across: Vec<Vec<DVec2>>,
}

impl ChannelLines {
    /// The lines with every place moved.
    pub fn moved(&self, to: impl Fn(DVec2) -> DVec2) -> Self {
        let all = |lines: &[Vec<DVec2>]| {
            lines.iter().map(|line| line.iter().map(|p| to(*p)).collect()).collect()
        };
        Self { edges: all(&self.edges), across: all(&self.across) }
    }
}

impl Passage {
    /// The channel of a hub. `hub`: its surface, placed, mm.
    ///
    /// # Errors
    /// [`HubError`].
    pub fn new(
        hub: &NurbsSurface,
        blade: &Blade,
        splitter: Option<&Blade>,
        options: &PassageOptions,
    ) -> Result<Self, HubError> {
        let &PassageOptions { hub: hub_options, radius, tolerance } = options;
        let wheel = Wheel::new(hub, hub_options, middle(&blade.facets))?;
        let fitted = FITTED * tolerance;
        let edge = blade.edge(&wheel, fitted)?;
        let splitter_edge = splitter.map(|s| s.edge(&wheel, fitted)).transpose()?;
        let around = |b: &Blade| Hindrance::new(&b.facets.positions, &b.facets.faces);
        let (of_blade, of_splitter) = (around(blade), splitter.map(around));
        let layout = Edges {
            wheel: &wheel,
            blade: (&edge, &of_blade),
            splitter: splitter_edge.as_ref().zip(of_splitter.as_ref()),
            radius,
            clearance: hub_options.clearance,
            tolerance: fitted,
        }
        .layout()?;
        let turned = |facets: &Facets, pitches: i32| Facets {
            positions: facets.positions.iter().map(|p| wheel.turned(*p, pitches)).collect(),
            faces: facets.faces.clone(),
        };
        let mut blades = blade.facets.clone();
        blades.add(&turned(&blade.facets, 1));
        if let Some(splitter) = splitter {
            blades.add(&turned(&splitter.facets, layout.splitter_pitches));
        }
        let loops = layout.loops();
        let alike = fitted.max(ALIKE);
        let of_edge = |edge: &ParameterCurve, pitches: i32| {
            let at = (0..=DRAWN).map(|i| edge.point(part(i, DRAWN + 1)));
            at.map(|p| if pitches == 0 { Ok(p) } else { wheel.carried(p, pitches, alike) })
                .collect::<Result<Vec<DVec2>, HubError>>()
        };
        let mut lines = ChannelLines {
            edges: vec![of_edge(&edge, 0)?, of_edge(&edge, 1)?],
            across: Vec::new(),
        };
        if let Some(edge) = &splitter_edge {
            lines.edges.push(of_edge(edge, layout.splitter_pitches)?);
        }
        let rows = || (EVERY..ROWS - 1).step_by(EVERY);
        let of_part = |p: &Part| rows().map(|row| p.channel.across(row)).collect::<Vec<_>>();
        lines.across = layout.parts.iter().flat_map(of_part).collect();
        let edges = core::iter::once(edge).chain(splitter_edge).collect();
        Ok(Self { wheel, layout, loops, blades, edges, lines })
    }

    /// The hub, whole if it is a surface of revolution.
    pub fn hub(&self) -> &NurbsSurface {
        &self.wheel.hub
    }

    /// Whether the tool is on the side of `u` cross `v`.
    pub fn is_seen_along_normal(&self) -> bool {
        self.wheel.side() > 0.0
    }

    /// The outline of the channel and its holes, in the parameters of [`hub`](Self::hub).
    pub fn loops(&self) -> &[TrimLoop] {
        &self.loops
    }

    /// The blades beside the channel and the splitter in it.
    pub fn blades(&self) -> &Facets {
        &self.blades
    }

    /// What lies beside and across the channel, in the parameters of [`hub`](Self::hub).
    pub fn lines(&self) -> &ChannelLines {
        &self.lines
    }

    /// A rectangle of parameters that holds the channel and half a pitch to either side of it.
    pub fn around_channel(&self) -> (DVec2, DVec2) {
        let around = self.wheel.around;
        let (from, to) = self.wheel.hub.domain();
        let all = || self.loops.iter().flat_map(|l| &l.points).map(|p| p[around]);
        let half = 0.5 * self.wheel.period() / f64::from(self.wheel.blades);
        let (low, high) =
            (all().fold(f64::INFINITY, f64::min) - half, all().fold(f64::MIN, f64::max) + half);
        let (mut first, mut last) = (from, to);
        if high - low < WHOLE * self.wheel.period() {
            (first[around], last[around]) = (low, high);
        }
        (first, last)
    }

    /// The least Jacobian of the maps of the channel over its mean, and whether one of them had to be made harmonic.
    fn map_quality(&self) -> (f64, bool) {
        let parts = || self.layout.parts.iter().map(|p| &p.channel);
        let least = parts().map(|c| c.least_jacobian).fold(f64::INFINITY, f64::min);
        (least, parts().any(|c| c.is_harmonic))
    }

    /// Largest deviation of the fitted edges, mm.
    fn edge_deviation(&self) -> f64 {
        self.edges.iter().map(ParameterCurve::deviation).fold(0.0, f64::max)
    }
}

/// How the channels are machined.
#[derive(Clone, Debug)]
pub struct ChannelOptions<'a> {
    /// The blades.
    pub hub: &'a HubOptions,
    /// Cutter, shank and holder.
    pub assembly: &'a Assembly,
    /// The cutter as it touches the hub.
    pub footprint: Footprint,
    /// Height of cusps that is aimed at, mm.
    pub cusp: f64,
    /// Height above which no place should be left, mm.
    pub limit: f64,
    /// Allowance left on the hub, mm.
    pub allowance: f64,
    /// Tolerance of the path, mm.
    pub tolerance: f64,
    /// Feed along passes, through the air, and of rapids, mm/s.
    pub feeds: [f64; 3],
    /// Distance along the axis from the origin at and above which rapids run, mm.
    pub rapid_plane: f64,
    /// Number of threads; the path does not depend on it.
    pub threads: usize,
}

/// The path through the channels, and what is known of it.
#[derive(Clone, Debug)]
pub struct Channels {
    /// The path; the region of a point is its channel.
    pub toolpath: Toolpath,
    /// Parameters of the hub at the contacts; `None` away from the hub, and in all channels but the first.
    pub contacts: Vec<Option<DVec2>>,
    /// What is known of it.
    pub figures: ChannelFigures,
}

/// The channels of a hub in figures.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct ChannelFigures {
    /// How the passes are spaced.
    pub spacing: HubPasses,
    /// Passes of a channel; those that begin or end within it are counted as well.
    pub passes: usize,
    /// Length of the passes of a channel on the hub with either spacing, mm: strips, equal parts.
    pub lengths: [f64; 2],
    /// Least length that passes of a channel can have, mm.
    pub length_floor: f64,
    /// Share of the area on which passes are at least 0.9 of the allowed side step apart.
    pub even_share: f64,
    /// Number of channels machined.
    pub channels: usize,
    /// The narrowest place between the curves on which the outermost passes run, and their distance there, mm.
    pub narrowest: (DVec3, f64),
    /// Least Jacobian of the map of the channel over its mean, and whether it is a harmonic map.
    pub least_jacobian: f64,
    /// Whether the map of the channel is harmonic; otherwise it is Coons'.
    pub is_harmonic: bool,
    /// Largest deviation of the curves fitted to the edges of the blades, mm.
    pub edge_deviation: f64,
    /// Extensions in a channel that are shorter than the job asks for, since the tool would come too near to something.
    pub shortened: Shortened,
    /// Times that the cutter is lifted off within a channel.
    pub retracts: usize,
    /// Area in a channel that the path leaves too high, mm², and the highest place of it.
    pub left: (f64, Option<DVec3>),
}

impl Passage {
    /// The path through the channels. `about`: the hub about the channel.
    ///
    /// # Errors
    /// [`HubError`]: where cutter, shank or holder would come too near to a blade.
    pub fn channels(&self, about: &Facets, options: &ChannelOptions) -> Result<Channels, HubError> {
        let strip = Strip { footprint: options.footprint, cusp: options.cusp };
        let hindrance = Hindrance::new(&self.blades.positions, &self.blades.faces);
        let mut all = self.blades.clone();
        all.add(about);
        let all = Hindrance::new(&all.positions, &all.faces);
        let parts = &self.layout.parts;
        let measured: Vec<Measured> =
            parts.iter().map(|part| Measured::new(&self.wheel, &part.channel, &strip)).collect();
        let strips = measured.iter().zip(parts).map(|(m, p)| m.strips(&self.wheel, &p.channel));
        let strips: Vec<Vec<Line>> = strips.collect();
        let of_part = |(i, m): (usize, &Measured)| parts[i].own(m.equal_parts(), i == 0);
        let equal: Vec<Vec<Line>> = measured.iter().enumerate().map(of_part).collect();
        let length = |of_parts: &[Vec<Line>]| -> f64 {
            let of_part = |(lines, part): (&Vec<Line>, &Part)| {
                lines.iter().map(|l| l.length(&self.wheel, &part.channel)).sum::<f64>()
            };
            of_parts.iter().zip(parts).map(of_part).sum()
        };
        let mut lengths = [&strips, &equal].map(|lines| length(lines));
        let spacing = match options.hub.passes {
            HubPasses::Shortest if lengths[0] <= lengths[1] => HubPasses::Strips,
            HubPasses::Shortest => HubPasses::EqualParameter,
            chosen => chosen,
        };
        let (least_jacobian, is_harmonic) = self.map_quality();
        let clear = |way: &[Station]| self.is_clear(way, (&hindrance, &all), options);
        let axes = parts.iter().map(|part| self.axes(&part.channel, &all, options));
        let axes = axes.collect::<Result<Vec<AxisField>, _>>()?;
        let routes = parts.iter().zip(&axes).map(|(part, axes)| Route {
            wheel: &self.wheel,
            channel: &part.channel,
            axes,
            radius: options.assembly.tool.radius(),
            allowance: options.allowance,
            tolerance: options.tolerance,
            extension: options.hub.extension,
            clear: &clear,
        });
        let routes: Vec<Route> = routes.collect();
        let lines = if spacing == HubPasses::Strips { strips } else { equal };
        let mut best = self.gone_over(&routes, &measured, lines, options);
        if spacing == HubPasses::Strips {
            for _ in 0..ROUNDS {
                if best.highest() == 0.0 {
                    break;
                }
                let longer = measured.iter().zip(best.lines.clone()).zip(&best.left);
                let longer = longer.map(|((m, lines), left)| with_rest(m, lines, left));
                let again = self.gone_over(&routes, &measured, longer.collect(), options);
                if again.highest() >= best.highest() {
                    break;
                }
                best = again;
            }
            lengths[0] = length(&best.lines);
        }
        let left = best.left_on(&routes);
        let Run { lines, gone: Gone { stations, shortened }, .. } = best;
        let passes = lines.iter().map(Vec::len).sum();
        let area: f64 = measured.iter().map(|m| m.area).sum();
        let even = measured.iter().zip(&lines).map(|(m, lines)| m.area * m.even_share(lines));
        let even_share = even.sum::<f64>() / area.max(f64::MIN_POSITIVE);
        self.refuse_collision(&stations, (&hindrance, &all), options)?;
        let channels = match options.hub.channels {
            HubChannels::One => 1,
            HubChannels::All => options.hub.blades,
        };
        let (toolpath, contacts) = self.toolpath(&stations, channels, options);
        Ok(Channels {
            toolpath,
            contacts,
            figures: ChannelFigures {
                spacing,
                passes,
                lengths,
                length_floor: measured.iter().map(|m| m.floor).sum(),
                even_share,
                channels: channels as usize,
                narrowest: self.layout.narrowest,
                least_jacobian,
                is_harmonic,
                edge_deviation: self.edge_deviation(),
                shortened,
                retracts: stations.len().saturating_sub(1),
                left,
            },
        })
    }

    /// The path over passes, and what it leaves too high.
    fn gone_over(
        &self,
        routes: &[Route],
        measured: &[Measured],
        lines: Vec<Vec<Line>>,
        options: &ChannelOptions,
    ) -> Run {
        let gone = gone_over(routes, &lines);
        let (path, contacts) = self.toolpath(&gone.stations, 1, options);
        let gauge = Gauge {
            wheel: &self.wheel,
            cutter: Cutter { tool: options.assembly.tool, length: f64::INFINITY },
            allowance: options.allowance,
            limit: options.limit,
            threads: options.threads,
        };
        let parts = routes.iter().zip(measured).zip(&lines);
        let parts = parts.map(|((route, m), lines)| (route.channel, gaps(m, lines)));
        let left = gauge.too_high(path, &contacts, &parts.collect::<Vec<_>>());
        Run { lines, gone, left }
    }

    /// Whether the tool is clear of blades and hub between stations, too.
    fn is_clear(
        &self,
        way: &[Station],
        (blades, all): (&Hindrance, &Hindrance),
        options: &ChannelOptions,
    ) -> bool {
        let assembly = options.assembly;
        let radius = assembly.tool.radius();
        let distance = CLEAR * options.hub.clearance;
        let tip = |s: &Station| s.centre - s.axis * radius;
        way.windows(2).all(|pair| {
            let [a, b] = [pair[0], pair[1]];
            let way = a.centre.distance(b.centre) / (TESTED * radius);
            let turn = a.axis.distance(b.axis) / TESTED_TURN;
            let steps = way.max(turn).ceil().max(1.0) as usize;
            (0..=steps).all(|i| {
                let t = i as f64 / steps as f64;
                let axis = a.axis.lerp(b.axis, t).normalize_or(b.axis);
                let pose = Pose { tip: tip(&a).lerp(tip(&b), t), axis };
                is_clear(blades, assembly, pose, distance, true)
                    && is_clear(all, assembly, pose, distance, false)
            })
        })
    }

    /// The tool axes over a part of the channel.
    fn axes(
        &self,
        channel: &Channel,
        hindrance: &Hindrance,
        options: &ChannelOptions,
    ) -> Result<AxisField, HubError> {
        let stand = |r: usize, c: usize| {
            let (s, t) = (part(r, AXES.0), part(c, AXES.1));
            let at = channel.at(s, t);
            let [along, _] = ways(&self.wheel, channel, s, t);
            Stand {
                contact: self.wheel.hub.point(at),
                normal: self.wheel.normal(at),
                along: along.normalize_or_zero(),
            }
        };
        let nodes = (0..AXES.0).flat_map(|r| (0..AXES.1).map(move |c| (r, c)));
        let stands: Vec<Stand> = nodes.map(|(r, c)| stand(r, c)).collect();
        let wanted = AxisOptions {
            clearance: AIMED * options.hub.clearance,
            allowance: options.allowance,
            steepest: STEEPEST,
            threads: options.threads,
        };
        AxisField::new(&stands, AXES.0, AXES.1, hindrance, options.assembly, &wanted)
    }

    /// Cutter, shank and holder must clear the blades all along, and what is above the ball the hub, too.
    fn refuse_collision(
        &self,
        stations: &[Vec<Station>],
        (blades, all): (&Hindrance, &Hindrance),
        options: &ChannelOptions,
    ) -> Result<(), HubError> {
        let wanted = options.hub.clearance;
        let radius = options.assembly.tool.radius();
        let stations: Vec<&Station> = stations.iter().flatten().collect();
        let found = crate::parallel::map(options.threads, &stations, |station| {
            let tip = station.centre - station.axis * radius;
            let beyond = FAR * wanted;
            let of_all = clearance_above_end(all, options.assembly, tip, station.axis, beyond);
            let of_blades = clearance(blades, options.assembly, tip, station.axis, beyond);
            if of_all.distance < of_blades.distance { of_all } else { of_blades }
        });
        let worst = found.into_iter().min_by(|a, b| a.distance.total_cmp(&b.distance));
        match worst {
            Some(Clearance { distance, part, place }) if distance < KEPT * wanted => {
                Err(HubError::TooNear { place, distance, wanted, part })
            }
            _ => Ok(()),
        }
    }

    /// All channels, each with its approach and its retract.
    fn toolpath(
        &self,
        stations: &[Vec<Station>],
        channels: u32,
        options: &ChannelOptions,
    ) -> (Toolpath, Vec<Option<DVec2>>) {
        let mut points: Vec<PathPoint> = Vec::new();
        let mut contacts = Vec::new();
        for channel in 0..channels {
            for part in stations {
                self.add_part(&mut points, part, channel, options);
                let of_part = part.iter().map(|s| s.at.filter(|_| channel == 0));
                // The approach is there already, the retract comes last.
                contacts.resize(points.len() - part.len() - 1, None);
                contacts.extend(of_part);
                contacts.push(None);
            }
        }
        (Toolpath { points }, contacts)
    }

    /// A part of a channel with rapids to it, its approach and its retract.
    fn add_part(
        &self,
        points: &mut Vec<PathPoint>,
        part: &[Station],
        channel: u32,
        options: &ChannelOptions,
    ) {
        let [feed, air, rapid] = options.feeds;
        let radius = options.assembly.tool.radius();
        let point = |station: &Station| {
            let turned = |d: DVec3| self.wheel.turned_direction(d, channel as i32);
            let axis = turned(station.axis);
            let centre = self.wheel.turned(station.centre, channel as i32);
            PathPoint {
                kind: station.kind,
                pass: station.pass,
                region: channel,
                tip: centre - axis * radius,
                axis,
                normal: turned(station.normal),
                flat: None,
                feed,
                mrr: 0.0,
                alpha: 0.0,
                time: 0.0,
            }
        };
        let (Some(first), Some(last)) = (part.first(), part.last()) else { return };
        let above =
            |p: &PathPoint| p.tip + p.axis * (options.rapid_plane - p.tip.dot(p.axis)).max(0.0);
        let (first, last) = (point(first), point(last));
        let over = PathPoint {
            kind: MoveKind::Rapid,
            tip: above(&first),
            feed: rapid,
            normal: first.axis,
            ..first
        };
        let from = points.last().map(|p| (p.tip, p.axis));
        let rapids = crate::link::rapid_steps(from, (over.tip, over.axis), options.rapid_plane);
        points.extend(rapids.into_iter().map(|(tip, axis)| PathPoint {
            tip,
            axis,
            normal: axis,
            ..over
        }));
        let mut all = part.iter().map(point);
        points.extend(all.next().map(|p| PathPoint { kind: MoveKind::Link, feed: air, ..p }));
        points.extend(all);
        points.push(PathPoint {
            kind: MoveKind::Link,
            tip: above(&last),
            feed: air,
            normal: last.axis,
            ..last
        });
    }
}

/// Passes of the parts of a channel, the path over them, and what it leaves too high of each part.
struct Run {
    lines: Vec<Vec<Line>>,
    gone: Gone,
    left: Vec<Vec<TooHigh>>,
}

impl Run {
    /// The highest place that is too high, mm; 0 where none is.
    fn highest(&self) -> f64 {
        self.left.iter().flatten().map(|left| left.height).fold(0.0, f64::max)
    }

    /// Area that is too high, mm², and the highest place of it.
    fn left_on(&self, routes: &[Route]) -> (f64, Option<DVec3>) {
        let all =
            || routes.iter().zip(&self.left).flat_map(|(r, left)| left.iter().map(move |l| (r, l)));
        let area = all().fold(0.0, |area, (_, left)| area + left.gap.area);
        let highest = all().max_by(|a, b| a.1.height.total_cmp(&b.1.height));
        (area, highest.map(|(r, l)| r.channel.place(r.wheel, l.gap.s, l.gap.t)))
    }
}

/// A channel gone over.
struct Gone {
    /// Stations without a retract between them.
    stations: Vec<Vec<Station>>,
    shortened: Shortened,
}

/// The path through the parts of a channel: where there are two, in that order of their passes in which the way from the
/// one to the other through the air is clear and the shortest; with a retract between them, where there is no such way.
fn gone_over(routes: &[Route], lines: &[Vec<Line>]) -> Gone {
    let [first, second] = routes else {
        let legs = routes.iter().zip(lines).map(|(route, lines)| route.path(lines, 0, ORDERS[0]));
        return Gone::of(legs.collect());
    };
    let passes = lines[0].len() as u32;
    let legs = |route: &Route, lines: &[Line], passes: u32| {
        ORDERS.map(|order| route.path(lines, passes, order))
    };
    let befores = legs(first, &lines[0], 0);
    let behinds = legs(second, &lines[1], passes);
    let length =
        |leg: &Leg| leg.stations.windows(2).map(|w| w[0].centre.distance(w[1].centre)).sum::<f64>();
    let mut choices: Vec<(f64, usize, usize)> = Vec::new();
    for (i, before) in befores.iter().enumerate() {
        // Only the beginning of the second leg matters.
        for (j, behind) in behinds.iter().enumerate().take(2) {
            if let (Some(from), Some(to)) = (before.stations.last(), behind.stations.first()) {
                let link = from.centre.distance(to.centre);
                choices.push((length(before) + link + length(behind), i, j));
            }
        }
    }
    choices.order_by(|a, b| a.0.total_cmp(&b.0));
    for (_, i, j) in choices {
        let (before, behind) = (&befores[i], &behinds[j]);
        let (Some(&from), Some(&to)) = (before.stations.last(), behind.stations.first()) else {
            continue;
        };
        let between = second.between(from, to);
        let link: Vec<Station> = [&[from], &between[..], &[to]].concat();
        if (second.clear)(&link) {
            let stations = [&before.stations[..], &between, &behind.stations].concat();
            return Gone {
                stations: vec![stations],
                shortened: before.shortened.with(behind.shortened),
            };
        }
    }
    let [before, ..] = befores;
    let [behind, ..] = behinds;
    Gone::of(vec![before, behind])
}

impl Gone {
    fn of(legs: Vec<Leg>) -> Self {
        let shortened = legs.iter().fold(Shortened::default(), |s, leg| s.with(leg.shortened));
        Self { stations: legs.into_iter().map(|leg| leg.stations).collect(), shortened }
    }
}

/// The mean of the vertices, mm.
fn middle(facets: &Facets) -> DVec3 {
    facets.positions.iter().sum::<DVec3>() / facets.positions.len().max(1) as f64
}
