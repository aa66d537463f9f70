//! What a mesh file holds, for a user who wants to know before writing a job.

use std::fmt;

use super::build::check_indices;
use super::error::SurfaceError;
use super::fault::{Fault, several_pieces, topology_faults};
use super::manifold::Surface;
use super::message::{Spot, short};
use crate::geometry::{DVec3, OrderBy, math};
use crate::mesh::repair::{bounding_box, face_area, split_pinches};
use crate::mesh::{
    Connectivity, Judgement, Repairs, TriangleSoup, VertexId, component_of, judge, repair,
};

/// Concave radii above this many diagonals are the noise of flat or convex places.
const FLATTEST: f64 = 100.0;
/// Area of the openings of a mesh that encloses a volume, at most, times that of its faces; and its volume, at least,
/// times the area to the power of 3/2 (0.07 for a cube).
const OPENINGS: f64 = 0.15;
const THIN: f64 = 1e-3;
/// A turn from face to face from which on an edge is meant to be one, rad (30 degrees); and the share of the others on
/// which facets are no farther off than is said.
const SHARP: f64 = core::f64::consts::FRAC_PI_6;
const MOST_OF_EDGES: f64 = 0.9;
/// Faces that lean farther than this are not seen from a direction, rad (80 degrees); and by which part more has to be
/// seen from another one to prefer it.
const SEEN: f64 = 80.0 * core::f64::consts::PI / 180.0;
/// Share of the area that a few folded faces of a scan or turned-over slivers may have.
const FEW: f64 = 1e-3;
const CLEARLY: f64 = 0.01;
/// Lengths of boundary loops and areas of components that are written out.
const LISTED: usize = 6;

/// The figures of a mesh, after repair, in the units of the file.
#[derive(Clone, Debug, PartialEq)]
pub struct Inspection {
    /// Vertices and faces as read.
    pub read: (usize, usize),
    /// What was repaired.
    pub repairs: Repairs,
    /// Topology of the whole mesh.
    pub judgement: Judgement,
    /// Total area.
    pub area: f64,
    /// Corners of the bounding box.
    pub bounds: (DVec3, DVec3),
    /// Shortest and longest edge.
    pub edges: (f64, f64),
    /// How far the facets are off the smooth surface that they stand for, as their angles suggest: on nine tenths of the
    /// edges less than this. Edges between which the mesh turns sharply are left out.
    pub off_smooth: f64,
    /// The sharpest turn from face to face on a concave and on a convex edge, rad; 0 where there is none.
    pub sharpest: [f64; 2],
    /// Smallest radius of a concave place and where it is; `None` if nothing is concave or the
    /// mesh is not a manifold.
    pub concave: Option<(f64, DVec3)>,
    /// The same of the convex places, which are the concave ones from the other side.
    pub convex: Option<(f64, DVec3)>,
    /// Where the faces of the largest component look.
    pub facing: Facing,
    /// The sum of the normals of all faces, each as long as its area.
    pub vector_area: DVec3,
    /// The volume that the faces enclose, if they enclose one but for small openings: negative where they look inward.
    pub enclosed: Option<f64>,
    /// What keeps the whole mesh from being machined without a selection.
    pub faults: Vec<Fault>,
}

/// Directions of face normals.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Facing {
    /// Unit mean by area; zero if there is none.
    pub mean: DVec3,
    /// Largest angle of a face from the mean, rad.
    pub from_mean: f64,
    /// The same but for a thousandth of the area.
    pub most_from_mean: f64,
    /// Largest angle of a face from +Z, rad.
    pub from_up: f64,
    /// The same but for a thousandth of the area.
    pub most_from_up: f64,
    /// Largest angle of a face from -Z but for a thousandth of the area, rad.
    pub most_from_down: f64,
    /// What of the faces is seen from where, of the faces as they are and turned over.
    pub fronts: [Front; 2],
}

/// From where most of some faces is seen, shadows left aside.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Front {
    /// Area that is seen from +Z, over that of all.
    pub from_up: f64,
    /// Area that is seen from where most is, over that of all.
    pub most: f64,
    /// From where that is: an axis or a diagonal.
    pub direction: DVec3,
}

impl Front {
    /// `normals`: as long as one likes per area; `side`: -1 for faces turned over.
    fn of(normals: &[DVec3], side: f64) -> Self {
        let all: f64 = normals.iter().map(|n| n.length()).sum();
        let flattest = math::cos(SEEN);
        let seen = |from: DVec3| {
            let is_seen = |n: &&DVec3| side * n.dot(from) >= flattest * n.length();
            normals.iter().filter(is_seen).map(|n| n.length()).sum::<f64>() / all
        };
        let mut best = Self { from_up: seen(DVec3::Z), most: 0.0, direction: DVec3::Z };
        best.most = best.from_up;
        let steps = || [0.0, 1.0, -1.0].into_iter();
        let ways = steps().flat_map(|x| steps().flat_map(move |y| steps().map(move |z| [x, y, z])));
        for direction in ways.map(|way| DVec3::from_array(way).normalize_or_zero()) {
            let most = seen(direction);
            if most > best.most * (1.0 + CLEARLY) && direction != DVec3::ZERO {
                best = Self { most, direction, ..best };
            }
        }
        best
    }
}

impl Facing {
    /// The directions of the normals, each twice a face's area long.
    fn of(normals: &[DVec3]) -> Self {
        let mean = normals.iter().copied().sum::<DVec3>().normalize_or_zero();
        let farthest = |axis: DVec3| farthest(normals, axis);
        let ([from_mean, most_from_mean], [from_up, most_from_up]) =
            (farthest(mean), farthest(DVec3::Z));
        Self {
            mean,
            from_mean,
            most_from_mean,
            from_up,
            most_from_up,
            most_from_down: farthest(DVec3::NEG_Z)[1],
            fronts: [1.0, -1.0].map(|side| Front::of(normals, side)),
        }
    }
}

impl Inspection {
    /// Inspects a mesh; lengths stay in its units.
    ///
    /// # Errors
    /// [`SurfaceError::NoFaces`], [`SurfaceError::BadIndex`] or [`SurfaceError::NoArea`].
    pub fn new(soup: TriangleSoup) -> Result<Self, SurfaceError> {
        check_indices(&soup)?;
        let read = (soup.positions.len(), soup.faces.len());
        let repaired = repair(soup);
        let (mesh, repairs) = (repaired.mesh, repaired.repairs);
        if mesh.faces.is_empty() {
            return Err(SurfaceError::NoArea { faces: read.1 });
        }
        let judgement = judge(&mesh.positions, &mesh.faces);
        let bounds = bounding_box(&mesh.positions);
        let (vector_area, enclosed) = looking(&mesh);
        let bends = bends(&mesh);
        let (off_smooth, sharpest) = (off_smooth(&bends), sharpest(&bends));
        let [concave, convex] = smallest_radii(mesh.clone(), (bounds.1 - bounds.0).length());
        Ok(Self {
            read,
            repairs,
            area: mesh.faces.iter().map(|face| face_area(&mesh.positions, *face)).sum(),
            bounds,
            edges: edge_range(&mesh),
            off_smooth,
            sharpest,
            faults: several_pieces(&judgement, &mesh)
                .into_iter()
                .chain(topology_faults(&judgement))
                .collect(),
            facing: Facing::of(&normals_of_largest(&mesh, &judgement)),
            vector_area,
            enclosed,
            concave,
            convex,
            judgement,
        })
    }
}

/// Normal of a face, twice its area long.
fn doubled_normal(mesh: &TriangleSoup, face: &[u32; 3]) -> DVec3 {
    let [a, b, c] = face.map(|v| mesh.positions[v as usize]);
    (b - a).cross(c - a)
}

/// The sum of the normals of all faces, each as long as its area, and the volume within them: by Gauss' theorem, so that
/// cracks and small openings matter little. `None` if the openings are large.
fn looking(mesh: &TriangleSoup) -> (DVec3, Option<f64>) {
    let faces = || {
        let normal = |face: &[u32; 3]| 0.5 * doubled_normal(mesh, face);
        mesh.faces.iter().map(move |f| (f.map(|v| mesh.positions[v as usize]), normal(f)))
    };
    let area: f64 = faces().map(|(_, normal)| normal.length()).sum();
    let middle: DVec3 = faces().map(|(f, n)| f.iter().sum::<DVec3>() * n.length()).sum();
    let middle = middle / (3.0 * area);
    let sum: DVec3 = faces().map(|(_, normal)| normal).sum();
    let volume: f64 = faces().map(|(f, normal)| (f[0] - middle).dot(normal) / 3.0).sum();
    let encloses = sum.length() <= OPENINGS * area && volume.abs() >= THIN * area * area.sqrt();
    (sum, encloses.then_some(volume))
}

/// Largest angle of normals from an axis, and that of all but [`FEW`] of their length, rad.
fn farthest(normals: &[DVec3], axis: DVec3) -> [f64; 2] {
    let angle = |n: &DVec3| (math::acos_clamped(n.normalize_or_zero().dot(axis)), n.length());
    let mut angles: Vec<(f64, f64)> = normals.iter().map(angle).collect();
    angles.order_by(|a, b| b.0.total_cmp(&a.0));
    let mut left = FEW * angles.iter().map(|a| a.1).sum::<f64>();
    let is_most = |a: &&(f64, f64)| {
        left -= a.1;
        left < 0.0
    };
    let all = angles.first().map_or(0.0, |a| a.0);
    [all, angles.iter().find(is_most).map_or(all, |a| a.0)]
}

/// An edge between two faces.
struct Bend {
    /// Width of the two faces across it.
    across: f64,
    /// Angle between their normals, rad: negative where they form a valley.
    turn: f64,
}

/// All edges between two faces.
fn bends(mesh: &TriangleSoup) -> Vec<Bend> {
    let at = |v: u32| mesh.positions[v as usize];
    let mut sides: Vec<([u32; 2], usize)> = Vec::with_capacity(3 * mesh.faces.len());
    for (f, &[a, b, c]) in mesh.faces.iter().enumerate() {
        sides.extend([[a, b], [b, c], [c, a]].map(|[a, b]| ([a.min(b), a.max(b)], f)));
    }
    sides.order_total();
    let normal = |f: usize| doubled_normal(mesh, &mesh.faces[f]);
    let bend = |group: &[([u32; 2], usize)]| match group {
        [([a, b], f), (_, g)] => {
            let (m, n) = (normal(*f), normal(*g));
            let turn = math::atan2(m.cross(n).length(), m.dot(n));
            let height = |v: u32| m.dot(at(v) - at(*a));
            let is_valley = mesh.faces[*g].iter().map(|v| height(*v)).sum::<f64>() > 0.0;
            Some(Bend {
                across: 0.5 * (m.length() + n.length()) / at(*a).distance(at(*b)),
                turn: if is_valley { -turn } else { turn },
            })
        }
        _ => None,
    };
    sides.chunk_by(|a, b| a.0 == b.0).filter_map(bend).collect()
}

/// See [`Inspection::off_smooth`]: an arc that turns by an angle from one chord of length `w` to the next is `w / 8` times
/// that above its chords.
fn off_smooth(bends: &[Bend]) -> f64 {
    let smooth = bends.iter().filter(|bend| bend.turn.abs() < SHARP);
    let mut all: Vec<f64> = smooth.map(|bend| bend.across * bend.turn.abs() / 8.0).collect();
    let rank = (MOST_OF_EDGES * all.len() as f64) as usize;
    match rank < all.len() {
        true => *all.select_nth_unstable_by(rank, f64::total_cmp).1,
        false => 0.0,
    }
}

/// See [`Inspection::sharpest`].
fn sharpest(bends: &[Bend]) -> [f64; 2] {
    [-1.0, 1.0].map(|side| bends.iter().map(|bend| side * bend.turn).fold(0.0, f64::max))
}

fn edge_range(mesh: &TriangleSoup) -> (f64, f64) {
    let at = |v: u32| mesh.positions[v as usize];
    let sides = mesh.faces.iter().flat_map(|&[a, b, c]| [(a, b), (b, c), (c, a)]);
    sides
        .map(|(a, b)| (at(b) - at(a)).length())
        .fold((f64::INFINITY, 0.0), |(low, high), l| (low.min(l), high.max(l)))
}

/// Normals of the faces of the component of largest area, twice their area long.
fn normals_of_largest(mesh: &TriangleSoup, judgement: &Judgement) -> Vec<DVec3> {
    let number = component_of(&mesh.positions, &mesh.faces, &judgement.components);
    let largest = mesh.faces.iter().zip(number).filter(|(_, component)| *component == 0);
    largest.map(|(face, _)| doubled_normal(mesh, face)).collect()
}

/// Smallest concave and convex radius over all vertices, if there is a manifold to measure them on.
fn smallest_radii(mut mesh: TriangleSoup, diagonal: f64) -> [Option<(f64, DVec3)>; 2] {
    split_pinches(&mut mesh, |_| true);
    let faces = mesh.faces.iter().map(|face| face.map(VertexId)).collect();
    let Ok(connectivity) = Connectivity::new(mesh.positions.len(), faces) else {
        return [None; 2];
    };
    let surface = Surface::new(connectivity, mesh.positions);
    let field = surface.curvature(None);
    let sharpest = |curvature: fn((f64, f64, DVec3)) -> f64| {
        let at =
            field.operators().iter().map(|o| curvature(o.principal())).zip(surface.positions());
        let (k, place) = at.max_by(|(a, _), (b, _)| a.total_cmp(b))?;
        (k * FLATTEST * diagonal > 1.0).then(|| (1.0 / k, *place))
    };
    [sharpest(|(least, ..)| -least), sharpest(|(_, most, _)| most)]
}

impl fmt::Display for Inspection {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let j = &self.judgement;
        let (low, high) = self.bounds;
        let (shortest, longest) = self.edges;
        let areas: Vec<f64> = j.components.iter().map(|c| c.area).collect();
        let genus = j.genus.map_or("not defined".to_owned(), |genus| genus.to_string());
        writeln!(f, "read           {} vertices, {} faces", self.read.0, self.read.1)?;
        writeln!(f, "repaired       {}", self.repairs)?;
        writeln!(f, "mesh           {} vertices, {} faces", j.vertices, j.faces)?;
        writeln!(f, "components     {} (area {} mm²)", areas.len(), listed(&areas))?;
        let loops = &j.boundary_loops;
        match loops.len() {
            0 => writeln!(f, "boundary       none: the surface is closed")?,
            n => writeln!(f, "boundary loops {n} (length {} mm)", listed(loops))?,
        }
        writeln!(f, "genus          {genus} (Euler characteristic {})", j.euler)?;
        writeln!(f, "area           {} mm²", short(self.area))?;
        writeln!(f, "bounding box   {} to {} mm", Spot(low), Spot(high))?;
        writeln!(f, "edges          {} to {} mm", short(shortest), short(longest))?;
        writeln!(f, "facets         about {} mm off a smooth surface", short(self.off_smooth))?;
        match self.concave {
            Some((radius, place)) => writeln!(
                f,
                "tightest       concave radius {} mm at {}",
                short(radius),
                Spot(place)
            )?,
            None => writeln!(f, "tightest       no concave place found")?,
        }
        let Facing { mean, from_mean, from_up, .. } = self.facing;
        let of_mean =
            || format!("within {} degrees of {}, ", short(from_mean.to_degrees()), Spot(mean));
        let of_mean = if mean == DVec3::ZERO { String::new() } else { of_mean() };
        writeln!(
            f,
            "normals        {of_mean}within {} degrees of +Z",
            short(from_up.to_degrees())
        )?;
        if let Some(volume) = self.enclosed {
            let side = if volume < 0.0 { "; the faces look inward" } else { "" };
            writeln!(f, "encloses       {} mm³{side}", short(volume.abs()))?;
        }
        for fault in &self.faults {
            writeln!(f, "fault          {fault}")?;
        }
        if !self.faults.is_empty() {
            writeln!(
                f,
                "all the same   a job with surface.steepest machines it from above; `evencut new` writes one"
            )?;
        }
        Ok(())
    }
}

/// The first few numbers, and how many more there are.
fn listed(values: &[f64]) -> String {
    let shown: Vec<String> = values.iter().take(LISTED).map(|v| short(*v)).collect();
    match values.len().saturating_sub(LISTED) {
        0 => shown.join(", "),
        more => format!("{}, and {more} more", shown.join(", ")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface::AnalyticSurface;

    #[test]
    fn a_bowl_is_reported_with_its_radius() {
        let bowl = AnalyticSurface::SphereCap { radius: -25.0, diameter: 30.0 }.mesh(0.7);
        let inspection = Inspection::new(bowl).unwrap();
        let (radius, _) = inspection.concave.unwrap();
        assert!((radius / 25.0 - 1.0).abs() < 0.01, "{radius}");
        assert!(inspection.faults.is_empty());
        let rim = inspection.judgement.boundary_loops[0];
        assert!((rim / (std::f64::consts::PI * 30.0) - 1.0).abs() < 1e-3);
        let text = inspection.to_string();
        for word in ["components     1", "boundary loops 1 (length 94.2", "genus          0"] {
            assert!(text.contains(word), "{text}");
        }
    }

    #[test]
    fn a_cube_encloses_its_volume_with_and_without_a_lid_and_inside_out() {
        let corner = |i: usize| DVec3::new((i & 1) as f64, (i >> 1 & 1) as f64, (i >> 2) as f64);
        let sides: [[u32; 4]; 6] =
            [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let halves = sides.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]);
        let positions = (0..8).map(|i| 2.0 * corner(i) + DVec3::new(7.0, -3.0, 2.0)).collect();
        let cube = TriangleSoup { positions, faces: halves.collect(), texture: None };
        let enclosed = |mesh: &TriangleSoup| looking(mesh).1;
        assert!((enclosed(&cube).unwrap() - 8.0).abs() < 1e-12);
        let mut inward = cube.clone();
        inward.faces.iter_mut().for_each(|f| f.swap(0, 1));
        assert!((enclosed(&inward).unwrap() + 8.0).abs() < 1e-12);
        // Half of a side is missing: a twelfth of the area.
        let mut open = cube.clone();
        open.faces.pop();
        let volume = enclosed(&open).unwrap();
        assert!((7.0..8.0).contains(&volume), "{volume}");
        // A whole side: the opening is a fifth of what is left.
        open.faces.truncate(10);
        assert_eq!(enclosed(&open), None);
        let dome = AnalyticSurface::SphereCap { radius: 25.0, diameter: 30.0 }.mesh(0.7);
        assert_eq!(enclosed(&dome), None);
    }

    #[test]
    fn walls_with_vertices_on_the_edge_of_the_next_are_closed_but_a_tube_is_not() {
        // A wedge on whose lower edge, halfway, lies a vertex of its bottom alone.
        let at = [(0, 0, 0), (4, 0, 0), (0, 3, 0), (4, 3, 0), (0, 3, 2), (4, 3, 2), (2, 0, 0)];
        let positions = at.map(|(x, y, z)| DVec3::new(x.into(), y.into(), z.into())).to_vec();
        let wedge = [[0, 1, 5], [0, 5, 4], [2, 4, 5], [2, 5, 3], [0, 4, 2], [1, 3, 5]];
        let bottom = [[0, 2, 6], [6, 2, 3], [6, 3, 1]];
        let faces = wedge.into_iter().chain(bottom).collect();
        let faults = |faces| {
            let soup = TriangleSoup { positions: positions.clone(), faces, texture: None };
            Inspection::new(soup).unwrap().faults
        };
        assert_eq!(faults(faces), [Fault::Closed { faces: 9, slits: 1 }]);
        assert_eq!(faults(wedge.to_vec()), []);
    }

    #[test]
    fn a_standing_tube_is_seen_from_its_side() {
        let rim = |i: usize, z: f64| {
            let angle = i as f64 * std::f64::consts::TAU / 32.0;
            DVec3::new(math::cos(angle), math::sin(angle), z)
        };
        let positions = (0..64).map(|i| rim(i % 32, 3.0 * f64::from(i >= 32))).collect();
        let side = |i: u32| [[i, (i + 1) % 32, (i + 1) % 32 + 32], [i, (i + 1) % 32 + 32, i + 32]];
        let faces = (0..32).flat_map(side).collect();
        let tube = TriangleSoup { positions, faces, texture: None };
        let inspection = Inspection::new(tube).unwrap();
        // Its openings look away from each other.
        assert_eq!((inspection.vector_area.length() < 1e-9, inspection.faults.len()), (true, 0));
        let [front, turned_over] = inspection.facing.fronts;
        assert_eq!((front.from_up, front.direction.z), (0.0, 0.0), "{front:?}");
        // Within 80 of 90 degrees from a direction across.
        assert!((front.most - 8.0 / 18.0).abs() < 0.04, "{}", front.most);
        assert!((turned_over.most - front.most).abs() < 1e-9);
    }

    #[test]
    fn facets_of_a_dome_are_about_as_far_off_as_their_chords_and_a_plane_is_exact() {
        let (radius, edge) = (25.0, 0.7);
        let dome = AnalyticSurface::SphereCap { radius, diameter: 30.0 }.mesh(edge);
        let off = Inspection::new(dome).unwrap().off_smooth;
        let chord = edge * edge / (8.0 * radius);
        // Between triangles of that side the turn is smaller than between chords across it.
        assert!((0.25 * chord..chord).contains(&off), "{off} {chord}");
        let plane = AnalyticSurface::Plane { width: 10.0, depth: 10.0 }.mesh(1.0);
        assert!(Inspection::new(plane).unwrap().off_smooth < 1e-9);
    }

    #[test]
    fn a_dome_has_no_concave_place() {
        let dome = AnalyticSurface::SphereCap { radius: 25.0, diameter: 30.0 }.mesh(0.7);
        let inspection = Inspection::new(dome).unwrap();
        assert_eq!(inspection.concave, None);
        let (radius, _) = inspection.convex.unwrap();
        assert!((radius / 25.0 - 1.0).abs() < 0.01, "{radius}");
    }

    #[test]
    fn normals_of_a_dome_look_up_to_its_rim() {
        let dome = AnalyticSurface::SphereCap { radius: 25.0, diameter: 30.0 }.mesh(0.7);
        let Facing { mean, from_mean, from_up, .. } = Inspection::new(dome).unwrap().facing;
        assert!((mean - DVec3::Z).length() < 1e-3, "{mean}");
        // The rim leans by asin(15 / 25); the outermost faces lie just inside of it.
        let rim = math::asin(0.6);
        for angle in [from_mean, from_up] {
            assert!(angle < rim + 0.01 && angle > rim - 0.05, "{angle}");
        }
    }
}
