//! The files of a hub's job → hub and blades, and the channel between two blades as a surface.

use super::error::PlanError;
use super::load::{Files, HubKeys, SurfaceKeys};
use crate::geometry::math::{atan2, cos, sin};
use crate::geometry::{DMat3, DVec2, DVec3};
use crate::hub::{Blade, Passage, PassageOptions};
use crate::job::{BladeSurface, HubOptions, SurfaceSource};
use crate::mesh::repair::turn_faces;
use crate::nurbs::{MeshOptions, NurbsSurface, Trim, mesh, read_json};
use crate::step::{SmoothFormat, StepFile};
use crate::surface::{Part, Surface, Warning, Whole, build_parametric, placement};
use core::f64::consts::TAU;

/// How long the sides of triangles may be of what is not machined, square roots of the area.
const LONGEST: f64 = 0.25;
/// Share of the clearance by which triangles of blades may be off.
const OF_CLEARANCE: f64 = 0.05;
/// Share of the tolerance by which lines between points of a blade's bounds may be off them: cubics through the points
/// are far nearer.
const OF_TOLERANCE: f64 = 0.25;
/// Pitches by which a blade of the file is beside those of the job from which on it is none of them.
const BETWEEN: f64 = 0.1;
/// How far corners of a face may be off those of another one, turned, as a part of its size; and turns, rad, that are none.
const COPIED: f64 = 5e-3;
/// Size of a face, as a part of the other's, and ends of edges from which on one may be the other, turned.
const AS_LARGE: f64 = 0.9;
const FEWEST: usize = 6;
/// Cosine between the normals of hub and fillet at the fillet's edge above which one continues the other.
const CONTINUES: f64 = 0.5;

/// A surface and the triangles of the piece of it that is meant.
struct Face {
    surface: NurbsSurface,
    facets: Part,
}

/// Where surfaces come from.
struct Source<'a> {
    keys: &'a SurfaceKeys,
    files: Files<'a>,
    place: (DMat3, DVec3),
    /// The STEP file of the hub, if it is one.
    step: Option<StepFile>,
    name: &'a str,
}

impl<'a> Source<'a> {
    fn new(keys: &'a SurfaceKeys, files: Files<'a>) -> Result<Self, PlanError> {
        let SurfaceSource::File(name) = &keys.surface.source else {
            return Err(PlanError::UnknownFormat(String::new()));
        };
        let bytes = files.surface.ok_or_else(|| PlanError::NoFile(name.clone()))?;
        let step = match SmoothFormat::from_name(name) {
            Some(SmoothFormat::Step) => {
                Some(StepFile::read(bytes).map_err(|e| PlanError::Smooth(e.into()))?)
            }
            Some(SmoothFormat::Json) => None,
            None => return Err(PlanError::UnknownFormat(name.clone())),
        };
        let place = (placement(&keys.surface), keys.surface.translate);
        Ok(Self { keys, files, place, step, name })
    }

    /// The surface of the hub.
    fn hub(&self) -> Result<NurbsSurface, PlanError> {
        match &self.step {
            Some(step) => {
                let face = step.choose(self.keys.surface.face.number(), false);
                let surface = face.and_then(|face| step.surface(face, self.place));
                surface.map_err(|e| PlanError::Smooth(e.into()))
            }
            None => {
                let bytes =
                    self.files.surface.ok_or_else(|| PlanError::NoFile(self.name.into()))?;
                self.json(bytes).map(|(surface, _)| surface)
            }
        }
    }

    fn json(&self, bytes: &[u8]) -> Result<(NurbsSurface, Trim), PlanError> {
        let read = || {
            let file = read_json(bytes)?;
            let surface = file.surface.transformed(self.place.0, self.place.1)?;
            let (low, high) = file.trim.unwrap_or(surface.domain());
            Ok((surface, Trim::Rectangle(low, high)))
        };
        read().map_err(|e: crate::nurbs::NurbsError| PlanError::Smooth(e.into()))
    }

    /// The surfaces of a blade, `key` in the job, with triangles within `chord` mm that are seen from the air; the lines
    /// between points of bounds are within `fine` mm.
    fn blade(
        &self,
        key: &'static str,
        list: &[BladeSurface],
        (chord, fine): (f64, f64),
    ) -> Result<Blade, PlanError> {
        let options = MeshOptions { chord, longest: LONGEST, ..MeshOptions::default() };
        let face = |item: &BladeSurface| -> Result<Face, PlanError> {
            let wrong = |error: String| PlanError::Blade { key, what: error };
            match (item, &self.step) {
                (BladeSurface::Face(number), Some(step)) => {
                    let mesh =
                        || step.mesh(step.choose(Some(*number), false)?, self.place, options);
                    let found = mesh().map_err(|e| wrong(e.to_string()))?;
                    let soup = found.mesh.soup;
                    let facets = Part { positions: soup.positions, faces: soup.faces };
                    Ok(Face { surface: found.surface, facets })
                }
                (BladeSurface::Face(number), None) => {
                    Err(wrong(format!("there is no STEP file for face {number}")))
                }
                (BladeSurface::File(name), _) => {
                    let bytes =
                        self.files.blade(name).ok_or_else(|| PlanError::NoFile(name.clone()))?;
                    let of_file = |e: PlanError| wrong(format!("{name}: {e}"));
                    let (surface, trim) = self.json(bytes).map_err(of_file)?;
                    let soup = mesh(&surface, trim, options)
                        .map_err(|e| wrong(format!("{name}: {e}")))?
                        .soup;
                    Ok(Face {
                        surface,
                        facets: Part { positions: soup.positions, faces: soup.faces },
                    })
                }
            }
        };
        let mut faces = list.iter().map(face).collect::<Result<Vec<Face>, _>>()?;
        if self.step.is_none() {
            let hub = self.hub()?;
            turn_outward(&mut faces, &hub);
        }
        let mut facets = Part::default();
        faces.iter().for_each(|face| facets.add(&face.facets));
        let surfaces = faces.into_iter().map(|f| f.surface).collect();
        Ok(Blade { surfaces, bounds: self.bounds(key, list, fine)?, facets })
    }

    /// The edges that bound a blade's faces of the STEP file.
    fn bounds(
        &self,
        key: &'static str,
        list: &[BladeSurface],
        chord: f64,
    ) -> Result<Vec<Vec<DVec3>>, PlanError> {
        let Some(step) = &self.step else { return Ok(Vec::new()) };
        let number = |item: &BladeSurface| match item {
            BladeSurface::Face(number) => Some(step.choose(Some(*number), false)),
            BladeSurface::File(_) => None,
        };
        let faces = list.iter().filter_map(number).collect::<Result<Vec<usize>, _>>();
        let bounds = faces.and_then(|faces| step.boundary(&faces, self.place, chord));
        bounds.map_err(|e| PlanError::Blade { key, what: e.to_string() })
    }
}

impl Source<'_> {
    /// Refuses a number of blades that is not the file's: the largest face of the blade, turned about the axis, is another face
    /// of the file, but not where the job has a blade.
    fn refuse_other_pitch(&self, options: &HubOptions) -> Result<(), PlanError> {
        let Some(step) = &self.step else { return Ok(()) };
        let number = |item: &BladeSurface| match item {
            BladeSurface::Face(number) => step.choose(Some(*number), false).ok(),
            BladeSurface::File(_) => None,
        };
        let own: Vec<usize> =
            options.blade.iter().chain(&options.splitter).filter_map(number).collect();
        let corners = |face: usize| -> Vec<DVec3> {
            let (matrix, shift) = self.place;
            step.corners(face).into_iter().map(|p| matrix * p + shift - options.origin).collect()
        };
        let size = |all: &[DVec3]| {
            let first = all.first().copied().unwrap_or_default();
            all.iter().map(|p| p.distance(first)).fold(0.0, f64::max)
        };
        let of_blade = own.iter().take(options.blade.len()).map(|face| corners(*face));
        let largest = of_blade.max_by(|a, b| size(a).total_cmp(&size(b)));
        let Some((face, first)) = largest.and_then(|f| f.first().copied().map(|p| (f, p))) else {
            return Ok(());
        };
        let near = COPIED * size(&face);
        let turns = (0..step.faces().len()).filter(|i| !own.contains(i)).filter_map(|i| {
            let other = corners(i);
            let mut turn = other.iter().map(|p| turn_between(options.axis, first, *p));
            // Edges of the one may be divided, and those of the other not.
            let is_as_large = size(&other) > AS_LARGE * size(&face);
            turn.find(|turn| {
                let face: Vec<DVec3> =
                    face.iter().map(|p| turned(options.axis, *p, *turn)).collect();
                let is_on = |all: &[DVec3], p: DVec3| all.iter().any(|q| q.distance(p) < near);
                let (fewer, more) =
                    if other.len() < face.len() { (&other, &face) } else { (&face, &other) };
                is_as_large && fewer.len() >= FEWEST && fewer.iter().all(|p| is_on(more, *p))
            })
        });
        let turns: Vec<f64> = turns.filter(|turn| turn.abs() > COPIED).collect();
        let Some(least) = turns.iter().map(|t| t.abs()).min_by(f64::total_cmp) else {
            return Ok(());
        };
        let pitch = TAU / f64::from(options.blades);
        let is_off = |turn: &f64| {
            let pitches = turn / pitch;
            (pitches - pitches.round()).abs() > BETWEEN
        };
        let stand = (TAU / least).round();
        // All around, so that none is missing between them.
        let is_whole = turns.len() as f64 + 1.0 == stand;
        if stand == f64::from(options.blades) || !is_whole && !turns.iter().any(is_off) {
            return Ok(());
        }
        let what = format!(
            "the file has this blade again {:.1} degrees farther on, as {stand} blades stand, and {} of them stand {:.1} degrees \
             apart; correct hub.blades",
            360.0 / stand,
            options.blades,
            pitch.to_degrees()
        );
        Err(PlanError::Blade { key: "hub.blades", what })
    }
}

/// The turn about an axis through the origin from one place to another, rad, from -pi to pi.
fn turn_between(axis: DVec3, from: DVec3, to: DVec3) -> f64 {
    let across = from - axis * axis.dot(from);
    atan2(axis.cross(across).dot(to), across.dot(to))
}

/// A place turned about an axis through the origin.
fn turned(axis: DVec3, place: DVec3, turn: f64) -> DVec3 {
    let along = axis * axis.dot(place);
    let across = place - along;
    along + across * cos(turn) + axis.cross(across) * sin(turn)
}

/// Turns the triangles of surfaces toward the air: away from the middle of the blade, but those of a fillet, which
/// continues the hub, as the hub looks.
fn turn_outward(faces: &mut [Face], hub: &NurbsSurface) {
    let all = || faces.iter().flat_map(|f| &f.facets.positions);
    let middle = all().sum::<DVec3>() / all().count().max(1) as f64;
    let (low, high) = hub.domain();
    let foot = |place: DVec3| {
        const NET: usize = 16;
        let step = |i: usize| (i as f64 + 0.5) / NET as f64;
        let net =
            (0..NET * NET).map(|k| low + (high - low) * DVec2::new(step(k / NET), step(k % NET)));
        let nearest = net.min_by(|a, b| {
            hub.point(*a).distance_squared(place).total_cmp(&hub.point(*b).distance_squared(place))
        });
        hub.project(place, nearest.unwrap_or(low))
    };
    let foot_of_middle = foot(middle);
    let to_air = (middle - hub.point(foot_of_middle.0)).dot(hub.normal(foot_of_middle.0)).signum();
    for face in faces {
        let Part { positions, faces } = &mut face.facets;
        let corners = |f: &[u32; 3]| f.map(|v| positions[v as usize]);
        let normal = |[a, b, c]: [DVec3; 3]| (b - a).cross(c - a);
        // The triangle nearest to the hub.
        let nearest = faces.iter().map(|f| {
            let [a, b, c] = corners(f);
            let place = (a + b + c) / 3.0;
            (foot(place), normal([a, b, c]))
        });
        let nearest = nearest.min_by(|a, b| a.0.1.total_cmp(&b.0.1));
        let along_hub = nearest.map_or(0.0, |((at, off), normal)| {
            let near = off < 0.02 * hub.size();
            if near { normal.normalize_or_zero().dot(hub.normal(at)) * to_air } else { 0.0 }
        });
        let outward: f64 =
            faces.iter().map(|f| (corners(f)[0] - middle).dot(normal(corners(f)))).sum();
        let is_inward = match along_hub.abs() > CONTINUES {
            true => along_hub < 0.0,
            false => outward < 0.0,
        };
        if is_inward {
            faces.iter_mut().for_each(|f| f.swap(1, 2));
        }
    }
}

/// The channel between two blades.
pub(super) struct ChannelParts {
    pub passage: Passage,
    /// The channel as a surface.
    pub surface: Surface,
    /// Its triangles.
    pub part: Part,
    /// Warnings about it.
    pub warnings: Vec<Warning>,
    /// The hub about it.
    pub about: Part,
}

/// Reads the hub and the blades of a job, and makes the channel between two blades a surface.
///
/// # Errors
/// [`PlanError`]: what cannot be read or used.
pub(super) fn channel(
    keys: &SurfaceKeys,
    files: Files,
    hub: &HubKeys,
) -> Result<ChannelParts, PlanError> {
    let source = Source::new(keys, files)?;
    let options = &hub.options;
    source.refuse_other_pitch(options)?;
    let chord = (OF_CLEARANCE * options.clearance, OF_TOLERANCE * hub.tolerance);
    let blade = source.blade("hub.blade", &options.blade, chord)?;
    let splitter = match options.splitter.is_empty() {
        true => None,
        false => Some(source.blade("hub.splitter", &options.splitter, chord)?),
    };
    let asked = PassageOptions { hub: options, radius: hub.radius, tolerance: hub.tolerance };
    let passage = Passage::new(&source.hub()?, &blade, splitter.as_ref(), &asked)?;
    let fine = MeshOptions { chord: keys.chord, ..MeshOptions::default() };
    let of_nurbs = |e: crate::nurbs::NurbsError| PlanError::Smooth(e.into());
    let turned = |mut soup: crate::mesh::TriangleSoup| {
        if !passage.is_seen_along_normal() {
            turn_faces(&mut soup, |_| true);
        }
        soup
    };
    let channel =
        mesh(passage.hub(), Trim::Loops(passage.loops().to_vec()), fine).map_err(of_nurbs)?;
    let whole = build_parametric(turned(channel.soup), passage.hub().clone(), &keys.surface)?;
    let Whole { part, surface, warnings, .. } = whole;
    let surface = surface?;
    // The hub about the channel.
    let (low, high) = passage.around_channel();
    let coarse = MeshOptions { chord: keys.chord, longest: LONGEST, ..MeshOptions::default() };
    let about = mesh(passage.hub(), Trim::Rectangle(low, high), coarse).map_err(of_nurbs)?;
    let about = turned(about.soup);
    let about = Part { positions: about.positions, faces: about.faces };
    Ok(ChannelParts { passage, surface, part, warnings, about })
}
