//! Instances → faces: surfaces, edges, units.

use super::edge::{Curve, Edge, Edges};
use super::error::StepError;
use super::face::{StepFace, Trimmed};
use super::part21::{Instance, Record, Value};
use crate::geometry::math::tan;
use crate::geometry::{DVec3, OrderBy, Shown, any_perpendicular};
use crate::nurbs::{NurbsCurve, NurbsError, NurbsParts, NurbsSurface};

/// Curves that wrap curves, at most.
const DEEPEST: usize = 8;
/// Most faces of a file.
const MOST_FACES: usize = 100_000;
/// Part of its extent by which an unbounded surface reaches beyond its edges.
const MARGIN: f64 = 0.01;
/// Number of places along an edge from which the extent of a surface is found.
const EXTENT_SAMPLES: usize = 24;

/// What keeps a face from being used.
type Shape<T> = Result<T, String>;

/// The faces of all shells, then those of none, in the order of the file.
pub(super) fn faces(instances: &[Instance]) -> Result<Vec<StepFace>, StepError> {
    let model = Model::new(instances)?;
    model.refuse_moved_parts()?;
    let mut ids: Vec<u64> = Vec::new();
    for instance in instances {
        for shell in ["CLOSED_SHELL", "OPEN_SHELL"].iter().filter_map(|n| instance.record(n)) {
            ids.extend(shell.values.last().map(references).unwrap_or_default());
        }
    }
    let mut listed = ids.clone();
    listed.order_total();
    let is_face = |i: &&Instance| i.record("ADVANCED_FACE").or(i.record("FACE_SURFACE")).is_some();
    let loose = instances.iter().filter(is_face).map(|i| i.id);
    ids.extend(loose.filter(|id| listed.binary_search(id).is_err()));
    ids.truncate(MOST_FACES);
    Ok(ids.into_iter().map(|id| model.face(id)).collect())
}

impl Instance {
    fn record(&self, name: &str) -> Option<&Record> {
        self.records.iter().find(|r| r.name == name)
    }

    /// Name of its only or most telling record.
    fn name(&self) -> &str {
        self.records.last().map_or("", |r| r.name.as_str())
    }
}

fn references(value: &Value) -> Vec<u64> {
    let Value::List(items) = value else { return Vec::new() };
    items
        .iter()
        .filter_map(|v| if let Value::Reference(id) = v { Some(*id) } else { None })
        .collect()
}

fn number(value: &Value) -> Option<f64> {
    match value {
        Value::Number(n) => Some(*n),
        Value::Typed(_, inner) => inner.first().and_then(number),
        _ => None,
    }
}

fn numbers(value: &Value) -> Option<Vec<f64>> {
    let Value::List(items) = value else { return None };
    items.iter().map(number).collect()
}

/// Local frame: origin, x, y, z.
#[derive(Copy, Clone)]
struct Frame {
    origin: DVec3,
    x: DVec3,
    y: DVec3,
    z: DVec3,
}

struct Model<'a> {
    by_id: Vec<&'a Instance>,
    /// mm per unit of length.
    length: f64,
    /// rad per unit of angle.
    angle: f64,
}

impl<'a> Model<'a> {
    fn new(instances: &'a [Instance]) -> Result<Self, StepError> {
        let mut by_id: Vec<&Instance> = instances.iter().collect();
        by_id.order_by_key(|i| i.id);
        if let Some(pair) = by_id.windows(2).find(|p| p[0].id == p[1].id) {
            let what = "the number is given twice".to_owned();
            return Err(StepError::Instance { id: pair[0].id, name: pair[0].name().into(), what });
        }
        let mut model = Self { by_id, length: 1.0, angle: 1.0 };
        model.read_units(instances)?;
        Ok(model)
    }

    fn get(&self, id: u64) -> Option<&'a Instance> {
        let at = self.by_id.binary_search_by_key(&id, |i| i.id).ok()?;
        Some(self.by_id[at])
    }

    fn at(&self, value: Option<&Value>) -> Shape<&'a Instance> {
        match value {
            Some(Value::Reference(id)) => self.get(*id).ok_or_else(|| format!("#{id} is missing")),
            _ => Err("a reference is missing".to_owned()),
        }
    }

    /// The record `name` of a referenced instance.
    fn record(&self, value: Option<&Value>, name: &'static str) -> Shape<&'a Record> {
        let instance = self.at(value)?;
        instance.record(name).ok_or_else(|| format!("#{} is no {name}", instance.id))
    }

    fn read_units(&mut self, instances: &[Instance]) -> Result<(), StepError> {
        let mut length: Option<f64> = None;
        for context in instances.iter().filter_map(|i| i.record("GLOBAL_UNIT_ASSIGNED_CONTEXT")) {
            for unit in context.values.first().map(references).unwrap_or_default() {
                let Some(unit) = self.get(unit) else { continue };
                if unit.record("LENGTH_UNIT").is_some() {
                    let mm = 1e3 * self.in_si(unit, 0).unwrap_or(1e-3);
                    match length {
                        Some(before) if (before / mm - 1.0).abs() > 1e-9 => {
                            return Err(StepError::Units(before, mm));
                        }
                        _ => length = Some(mm),
                    }
                } else if unit.record("PLANE_ANGLE_UNIT").is_some() {
                    self.angle = self.in_si(unit, 0).unwrap_or(1.0);
                }
            }
        }
        self.length = length.filter(|l| (1e-9..=1e9).contains(l)).unwrap_or(1.0);
        Ok(())
    }

    /// A unit in metres or radians.
    fn in_si(&self, unit: &Instance, depth: usize) -> Option<f64> {
        if let Some(si) = unit.record("SI_UNIT") {
            let prefix = match si.values.first() {
                Some(Value::Word(word)) => word.as_str(),
                _ => "",
            };
            return Some(match prefix {
                "KILO" => 1e3,
                "DECI" => 1e-1,
                "CENTI" => 1e-2,
                "MILLI" => 1e-3,
                "MICRO" => 1e-6,
                "NANO" => 1e-9,
                _ => 1.0,
            });
        }
        let conversion = unit.record("CONVERSION_BASED_UNIT").filter(|_| depth < DEEPEST)?;
        let measure = self.at(conversion.values.get(1)).ok()?;
        let values = &measure.records.iter().find(|r| r.values.len() == 2)?.values;
        Some(number(&values[0])? * self.in_si(self.at(values.get(1)).ok()?, depth + 1)?)
    }

    /// Parts are used in their own position only.
    fn refuse_moved_parts(&self) -> Result<(), StepError> {
        for instance in &self.by_id {
            let Some(moved) = instance.record("ITEM_DEFINED_TRANSFORMATION") else { continue };
            let frames = [2, 3].map(|k| self.frame(moved.values.get(k)));
            if let [Ok(a), Ok(b)] = frames {
                let off = (a.origin - b.origin).length() > 1e-6
                    || (a.x - b.x).length() > 1e-9
                    || (a.z - b.z).length() > 1e-9;
                if off {
                    return Err(StepError::Assembly(instance.id));
                }
            }
        }
        Ok(())
    }

    fn point(&self, value: Option<&Value>) -> Shape<DVec3> {
        let record = self.record(value, "CARTESIAN_POINT")?;
        let c = record.values.get(1).and_then(numbers).filter(|c| c.len() == 3);
        let c = c.ok_or("a point without three coordinates")?;
        Ok(DVec3::new(c[0], c[1], c[2]) * self.length)
    }

    fn direction(&self, value: Option<&Value>) -> Shape<DVec3> {
        let record = self.record(value, "DIRECTION")?;
        let c = record.values.get(1).and_then(numbers).filter(|c| c.len() == 3);
        let d = c.and_then(|c| DVec3::new(c[0], c[1], c[2]).try_normalize());
        d.ok_or_else(|| "a direction without length".to_owned())
    }

    /// Axis placements; what they leave out has the standard's defaults.
    fn frame(&self, value: Option<&Value>) -> Shape<Frame> {
        let instance = self.at(value)?;
        let record = instance.record("AXIS2_PLACEMENT_3D").or(instance.record("AXIS1_PLACEMENT"));
        let record = record.ok_or_else(|| format!("#{} is no axis placement", instance.id))?;
        let origin = self.point(record.values.get(1))?;
        let z = match record.values.get(2) {
            Some(Value::Reference(_)) => self.direction(record.values.get(2))?,
            _ => DVec3::Z,
        };
        let x = match record.values.get(3) {
            Some(Value::Reference(_)) => self.direction(record.values.get(3))?,
            _ => DVec3::X,
        };
        let x = (x - z * x.dot(z)).try_normalize().unwrap_or_else(|| any_perpendicular(z));
        Ok(Frame { origin, x, y: z.cross(x), z })
    }

    fn length_of(&self, record: &Record, index: usize) -> Shape<f64> {
        let value = record.values.get(index).and_then(number);
        let value = value.ok_or_else(|| format!("{} lacks a number", record.name))?;
        Ok(value * self.length)
    }

    fn face(&self, id: u64) -> StepFace {
        let mut kind = "unknown".to_owned();
        let shape = self.shape(id, &mut kind);
        StepFace { id, kind, shape }
    }

    fn shape(&self, id: u64, kind: &mut String) -> Shape<Trimmed> {
        let instance = self.get(id).ok_or("the face is missing")?;
        let face = instance.record("ADVANCED_FACE").or(instance.record("FACE_SURFACE"));
        let face = face.ok_or_else(|| format!("a {} is not supported", instance.name()))?;
        let surface = self.at(face.values.get(2))?;
        *kind = kind_of(surface);
        let reversed = matches!(face.values.get(3), Some(Value::Word(w)) if w == "F");
        let mut bounds = Vec::new();
        for bound in face.values.get(1).map(references).unwrap_or_default() {
            bounds.extend(self.bound(bound)?);
        }
        let edges = Edges { bounds };
        let surface = self.surface(surface, &edges)?;
        Ok(Trimmed { surface, edges, reversed })
    }

    /// The edges of a bound in its direction; none for a loop that is one vertex.
    fn bound(&self, id: u64) -> Shape<Option<Vec<Edge>>> {
        let instance = self.get(id).ok_or("a bound is missing")?;
        let bound = instance.record("FACE_BOUND").or(instance.record("FACE_OUTER_BOUND"));
        let bound = bound.ok_or("a bound is no FACE_BOUND")?;
        let forward = !matches!(bound.values.get(2), Some(Value::Word(w)) if w == "F");
        let line = self.at(bound.values.get(1))?;
        if line.record("VERTEX_LOOP").is_some() {
            return Ok(None);
        }
        let line = line
            .record("EDGE_LOOP")
            .ok_or_else(|| format!("a {} is not supported", line.name()))?;
        let mut edges = Vec::new();
        for id in line.values.get(1).map(references).unwrap_or_default() {
            edges.push(self.edge(id)?);
        }
        if !forward {
            edges.reverse();
            edges.iter_mut().for_each(|e| e.forward = !e.forward);
        }
        Ok(Some(edges))
    }

    fn edge(&self, id: u64) -> Shape<Edge> {
        let oriented = self.record(Some(&Value::Reference(id)), "ORIENTED_EDGE")?;
        let Some(Value::Reference(curve_id)) = oriented.values.get(3) else {
            return Err("an edge without a curve".to_owned());
        };
        let forward = !matches!(oriented.values.get(4), Some(Value::Word(w)) if w == "F");
        let curve = self.record(oriented.values.get(3), "EDGE_CURVE")?;
        let vertex = |k: usize| {
            let record = self.record(curve.values.get(k), "VERTEX_POINT")?;
            self.point(record.values.get(1))
        };
        let ends = [vertex(1)?, vertex(2)?];
        let vertices = [1, 2].map(|k| match curve.values.get(k) {
            Some(Value::Reference(id)) => *id,
            _ => 0,
        });
        let same = !matches!(curve.values.get(4), Some(Value::Word(w)) if w == "F");
        let geometry = self.curve(curve.values.get(3), 0)?;
        Ok(Edge { id: *curve_id, curve: geometry, ends, vertices, same, forward })
    }

    fn curve(&self, value: Option<&Value>, depth: usize) -> Shape<Curve> {
        let instance = self.at(value)?;
        if depth > DEEPEST {
            return Err("curves of curves of curves".to_owned());
        }
        for name in ["SURFACE_CURVE", "SEAM_CURVE", "INTERSECTION_CURVE", "TRIMMED_CURVE"] {
            if let Some(record) = instance.record(name) {
                return self.curve(record.values.get(1), depth + 1);
            }
        }
        if let Some(line) = instance.record("LINE") {
            let vector = self.record(line.values.get(2), "VECTOR")?;
            return Ok(Curve::Line(
                self.point(line.values.get(1))?,
                self.direction(vector.values.get(1))?,
            ));
        }
        if let Some(circle) = instance.record("CIRCLE") {
            let frame = self.frame(circle.values.get(1))?;
            let radius = self.length_of(circle, 2)?;
            return Ok(Curve::Ellipse(frame.origin, frame.x * radius, frame.y * radius));
        }
        if let Some(ellipse) = instance.record("ELLIPSE") {
            let frame = self.frame(ellipse.values.get(1))?;
            let (a, b) = (self.length_of(ellipse, 2)?, self.length_of(ellipse, 3)?);
            return Ok(Curve::Ellipse(frame.origin, frame.x * a, frame.y * b));
        }
        if let Some(line) = instance.record("POLYLINE") {
            return self.polyline(line);
        }
        self.spline(instance)
    }

    fn polyline(&self, record: &Record) -> Shape<Curve> {
        let ids = record.values.get(1).map(references).unwrap_or_default();
        let points: Vec<(DVec3, f64)> = ids
            .into_iter()
            .map(|id| self.point(Some(&Value::Reference(id))).map(|p| (p, 1.0)))
            .collect::<Result<_, _>>()?;
        let knots = knots_of(KnotKind::QuasiUniform, 1, points.len());
        NurbsCurve::new(1, knots, points).map(Curve::Spline).map_err(as_text)
    }

    fn spline(&self, instance: &Instance) -> Shape<Curve> {
        // A simple instance carries a name before its own values, a complex one does not.
        let simple = instance.records.len() == 1;
        let skip = usize::from(simple);
        let names = [
            "B_SPLINE_CURVE",
            "B_SPLINE_CURVE_WITH_KNOTS",
            "BEZIER_CURVE",
            "UNIFORM_CURVE",
            "QUASI_UNIFORM_CURVE",
        ];
        let base = if simple {
            names[1..].iter().find_map(|n| instance.record(n))
        } else {
            instance.record(names[0])
        };
        let base =
            base.ok_or_else(|| format!("a {} as an edge is not supported", instance.name()))?;
        let degree = whole(base.values.get(skip))?;
        let ids = base.values.get(skip + 1).map(references).unwrap_or_default();
        let mut points = Vec::with_capacity(ids.len());
        for id in ids {
            points.push((self.point(Some(&Value::Reference(id)))?, 1.0));
        }
        if let Some(rational) = instance.record("RATIONAL_B_SPLINE_CURVE") {
            let weights = rational.values.first().and_then(numbers);
            let weights =
                weights.filter(|w| w.len() == points.len()).ok_or("weights do not fit")?;
            points.iter_mut().zip(weights).for_each(|(p, w)| p.1 = w);
        }
        let knots = match instance.record(names[1]) {
            Some(record) => {
                let at = if simple { 6 } else { 0 };
                expanded(
                    record.values.get(at),
                    record.values.get(at + 1),
                    points.len() + degree + 1,
                )?
            }
            None => knots_of(knot_kind(instance), degree, points.len()),
        };
        NurbsCurve::new(degree, knots, points).map(Curve::Spline).map_err(as_text)
    }

    fn surface(&self, instance: &Instance, edges: &Edges) -> Shape<NurbsSurface> {
        let elementary = |name: &str| instance.record(name);
        if let Some(plane) = elementary("PLANE") {
            return self.plane(self.frame(plane.values.get(1))?, edges);
        }
        if let Some(cylinder) = elementary("CYLINDRICAL_SURFACE") {
            let (frame, r) = (self.frame(cylinder.values.get(1))?, self.length_of(cylinder, 2)?);
            return cone(frame, r, 0.0, edges);
        }
        if let Some(record) = elementary("CONICAL_SURFACE") {
            let (frame, r) = (self.frame(record.values.get(1))?, self.length_of(record, 2)?);
            let half = record.values.get(3).and_then(number).ok_or("a cone without an angle")?;
            return cone(frame, r, tan(half * self.angle), edges);
        }
        if let Some(sphere) = elementary("SPHERICAL_SURFACE") {
            let (f, r) = (self.frame(sphere.values.get(1))?, self.length_of(sphere, 2)?);
            let profile = NurbsCurve::half_circle(f.origin, -f.z * r, f.x * r).map_err(as_text)?;
            return profile.revolved(f.origin, f.z).map_err(as_text);
        }
        if let Some(torus) = elementary("TOROIDAL_SURFACE") {
            let (f, major, minor) = (
                self.frame(torus.values.get(1))?,
                self.length_of(torus, 2)?,
                self.length_of(torus, 3)?,
            );
            let centre = f.origin + f.x * major;
            let profile = NurbsCurve::ellipse(centre, f.x * minor, f.z * minor).map_err(as_text)?;
            return profile.revolved(f.origin, f.z).map_err(as_text);
        }
        if let Some(record) = elementary("SURFACE_OF_REVOLUTION") {
            let axis = self.frame(record.values.get(2))?;
            let along = |p: DVec3| (p - axis.origin).dot(axis.z);
            let profile = self.curve(record.values.get(1), 0)?;
            return as_spline(profile, edges, &along)?
                .revolved(axis.origin, axis.z)
                .map_err(as_text);
        }
        if let Some(record) = elementary("SURFACE_OF_LINEAR_EXTRUSION") {
            let vector = self.record(record.values.get(2), "VECTOR")?;
            let way = self.direction(vector.values.get(1))?;
            return extruded(self.curve(record.values.get(1), 0)?, way, edges);
        }
        self.spline_surface(instance)
    }

    fn plane(&self, f: Frame, edges: &Edges) -> Shape<NurbsSurface> {
        let (u0, u1) = widened(edges, &|p| (p - f.origin).dot(f.x))?;
        let (v0, v1) = widened(edges, &|p| (p - f.origin).dot(f.y))?;
        let a = f.origin + f.x * u0;
        NurbsCurve::line(a, a + f.x * (u1 - u0))
            .and_then(|line| line.extruded(f.y * v0, f.y * (v1 - v0)))
            .map_err(as_text)
    }

    fn spline_surface(&self, instance: &Instance) -> Shape<NurbsSurface> {
        let simple = instance.records.len() == 1;
        let skip = usize::from(simple);
        let names = [
            "B_SPLINE_SURFACE",
            "B_SPLINE_SURFACE_WITH_KNOTS",
            "BEZIER_SURFACE",
            "UNIFORM_SURFACE",
            "QUASI_UNIFORM_SURFACE",
        ];
        let base = if simple {
            names[1..].iter().find_map(|n| instance.record(n))
        } else {
            instance.record(names[0])
        };
        let base = base.ok_or_else(|| format!("a {} is not supported", instance.name()))?;
        let degree = [whole(base.values.get(skip))?, whole(base.values.get(skip + 1))?];
        let Some(Value::List(rows)) = base.values.get(skip + 2) else {
            return Err("a surface without control points".to_owned());
        };
        let mut points: Vec<Vec<DVec3>> = Vec::with_capacity(rows.len());
        for row in rows {
            let read = |id| self.point(Some(&Value::Reference(id)));
            points.push(references(row).into_iter().map(read).collect::<Result<_, _>>()?);
        }
        let counts = [points.len(), points.first().map_or(0, Vec::len)];
        let weights = match instance.record("RATIONAL_B_SPLINE_SURFACE") {
            None => Vec::new(),
            Some(record) => match record.values.first() {
                Some(Value::List(rows)) => rows
                    .iter()
                    .map(numbers)
                    .collect::<Option<Vec<_>>>()
                    .ok_or("weights are no numbers")?,
                _ => return Err("weights are missing".to_owned()),
            },
        };
        let knots = match instance.record(names[1]) {
            Some(r) => {
                let at = if simple { 8 } else { 0 };
                let read = |k: usize| {
                    expanded(
                        r.values.get(at + k),
                        r.values.get(at + 2 + k),
                        counts[k] + degree[k] + 1,
                    )
                };
                [read(0)?, read(1)?]
            }
            None => [0, 1].map(|k| knots_of(knot_kind(instance), degree[k], counts[k])),
        };
        NurbsSurface::new(NurbsParts { degree, knots, points, weights }).map_err(as_text)
    }
}

fn as_text(error: NurbsError) -> String {
    error.to_string()
}

fn whole(value: Option<&Value>) -> Shape<usize> {
    match value.and_then(number) {
        Some(n) if (0.0..=1000.0).contains(&n) && n.fract() == 0.0 => Ok(n as usize),
        _ => Err("a degree is missing".to_owned()),
    }
}

/// Knots repeated by their multiplicities, which must give `count`.
fn expanded(
    multiplicities: Option<&Value>,
    knots: Option<&Value>,
    count: usize,
) -> Shape<Vec<f64>> {
    let (Some(times), Some(knots)) = (multiplicities.and_then(numbers), knots.and_then(numbers))
    else {
        return Err("knots are missing".to_owned());
    };
    // Checked before anything is repeated.
    let total: f64 = times.iter().sum();
    if times.len() != knots.len() || times.iter().any(|t| *t < 1.0) || total != count as f64 {
        let total = Shown(total);
        return Err(format!("{total} knots by their multiplicities; expected {count}"));
    }
    Ok(times.iter().zip(knots).flat_map(|(t, k)| std::iter::repeat_n(k, *t as usize)).collect())
}

/// Knots that the kind of a spline says.
#[derive(Copy, Clone)]
enum KnotKind {
    Uniform,
    QuasiUniform,
    Bezier,
}

fn knot_kind(instance: &Instance) -> KnotKind {
    let has = |name: &str| instance.records.iter().any(|r| r.name.starts_with(name));
    if has("BEZIER") {
        KnotKind::Bezier
    } else if has("UNIFORM") {
        KnotKind::Uniform
    } else {
        KnotKind::QuasiUniform
    }
}

fn knots_of(kind: KnotKind, degree: usize, points: usize) -> Vec<f64> {
    let (p, spans) = (degree as i64, points as i64 - degree as i64);
    let count = points as i64 + p + 1;
    let step = |i: i64| match kind {
        KnotKind::Uniform => i - p,
        KnotKind::QuasiUniform => (i - p).clamp(0, spans.max(0)),
        // Pieces of one degree each.
        KnotKind::Bezier => {
            (i - 1).div_euclid(p.max(1)).clamp(0, (points as i64 - 1).max(0) / p.max(1))
        }
    };
    (0..count).map(|i| step(i) as f64).collect()
}

fn kind_of(surface: &Instance) -> String {
    let names: Vec<&str> = surface.records.iter().map(|r| r.name.as_str()).collect();
    let has = |name: &str| names.contains(&name);
    if has("RATIONAL_B_SPLINE_SURFACE") {
        return "rational B-spline".to_owned();
    }
    let words = [
        ("PLANE", "plane"),
        ("CYLINDRICAL_SURFACE", "cylinder"),
        ("CONICAL_SURFACE", "cone"),
        ("SPHERICAL_SURFACE", "sphere"),
        ("TOROIDAL_SURFACE", "torus"),
        ("SURFACE_OF_REVOLUTION", "revolution"),
        ("SURFACE_OF_LINEAR_EXTRUSION", "extrusion"),
        ("B_SPLINE_SURFACE_WITH_KNOTS", "B-spline"),
        ("BEZIER_SURFACE", "Bezier"),
        ("QUASI_UNIFORM_SURFACE", "B-spline"),
        ("UNIFORM_SURFACE", "B-spline"),
    ];
    let known = words.iter().find(|(name, _)| has(name)).map(|(_, word)| (*word).to_owned());
    known.unwrap_or_else(|| surface.name().to_ascii_lowercase())
}

/// Least and greatest measure of the edges, a little widened.
fn widened(edges: &Edges, measure: &dyn Fn(DVec3) -> f64) -> Shape<(f64, f64)> {
    let points = || edges.bounds.iter().flatten().flat_map(|e| e.samples(EXTENT_SAMPLES));
    let low = points().map(measure).fold(f64::INFINITY, f64::min);
    let high = points().map(measure).fold(f64::NEG_INFINITY, f64::max);
    if low >= high {
        return Err("its edges do not determine its extent".to_owned());
    }
    let margin = MARGIN * (high - low);
    Ok((low - margin, high + margin))
}

/// A cone of radius `r` at its origin that grows by `slope` along its axis.
fn cone(f: Frame, r: f64, slope: f64, edges: &Edges) -> Shape<NurbsSurface> {
    let (mut low, mut high) = widened(edges, &|p| (p - f.origin).dot(f.z))?;
    if slope != 0.0 {
        let apex = -r / slope;
        // An end near the apex is the apex; a face without a second end reaches to it.
        let ends = edges.without_seams().len();
        let alone = ends < 2;
        if slope > 0.0 && (low < apex || alone) {
            low = apex;
        }
        if slope < 0.0 && (high > apex || alone) {
            high = apex;
        }
    }
    let at = |h: f64| f.origin + f.z * h + f.x * (r + slope * h).max(0.0);
    NurbsCurve::line(at(low), at(high))
        .and_then(|line| line.revolved(f.origin, f.z))
        .map_err(as_text)
}

/// A curve as a spline; a line as far as the edges reach along it.
fn as_spline(curve: Curve, edges: &Edges, along: &dyn Fn(DVec3) -> f64) -> Shape<NurbsCurve> {
    match curve {
        Curve::Spline(curve) => Ok(curve),
        Curve::Ellipse(centre, x, y) => NurbsCurve::ellipse(centre, x, y).map_err(as_text),
        Curve::Line(p, d) => {
            let slope = along(p + d) - along(p);
            if slope.abs() < 1e-9 {
                return Err("the revolved line is perpendicular to the axis".to_owned());
            }
            let (low, high) = widened(edges, along)?;
            let at = |h: f64| p + d * ((h - along(p)) / slope);
            let (a, b) = if slope > 0.0 { (at(low), at(high)) } else { (at(high), at(low)) };
            NurbsCurve::line(a, b).map_err(as_text)
        }
    }
}

fn extruded(curve: Curve, way: DVec3, edges: &Edges) -> Shape<NurbsSurface> {
    let curve = match curve {
        Curve::Line(p, d) => {
            let across =
                (d - way * d.dot(way)).try_normalize().ok_or("a line extruded along itself")?;
            let (low, high) = widened(edges, &|q| (q - p).dot(across) / d.dot(across))?;
            NurbsCurve::line(p + d * low, p + d * high).map_err(as_text)?
        }
        Curve::Ellipse(centre, x, y) => NurbsCurve::ellipse(centre, x, y).map_err(as_text)?,
        Curve::Spline(curve) => curve,
    };
    // Heights along the way, from wherever the curve runs.
    let (from, to) = curve.domain();
    let heights = (0..=64).map(|k| curve.point(from + (to - from) * f64::from(k) / 64.0).dot(way));
    let (least, most) =
        heights.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| (l.min(x), h.max(x)));
    let (low, high) = widened(edges, &|p| p.dot(way))?;
    curve.extruded(way * (low - most), way * (high - low + most - least)).map_err(as_text)
}
