//! What is wrong with a NURBS surface or keeps it from being meshed.

use std::fmt;

use thiserror::Error;

use super::degree::LARGEST_DEGREE;
use crate::geometry::{DVec2, DVec3, Shown};

/// One of the two parameters.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum Direction {
    /// The first.
    U,
    /// The second.
    V,
}

impl fmt::Display for Direction {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::U => "u",
            Self::V => "v",
        })
    }
}

/// Why numbers are no NURBS surface, or why it cannot be meshed.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum NurbsError {
    /// The text is not JSON.
    #[error(
        "nurbs: not JSON: {0}; a surface is a JSON object with degree_u, degree_v, knots_u, knots_v, control_points"
    )]
    Json(String),
    /// A key of the JSON object is missing or of another kind.
    #[error("nurbs: {place}: found {found}; expected {expected}")]
    Key {
        /// Path of the value.
        place: String,
        /// What is there.
        found: String,
        /// What should be there.
        expected: &'static str,
    },
    /// A degree that is not supported.
    #[error("nurbs: degree_{direction} = {degree}; a degree is from 1 to {LARGEST_DEGREE}")]
    Degree {
        /// Of which parameter.
        direction: Direction,
        /// The degree.
        degree: usize,
    },
    /// Fewer control points than the degree needs.
    #[error("nurbs: control_points: {points} along {direction}; degree_{direction} = {degree} needs at least {}", degree + 1)]
    TooFewPoints {
        /// Along which parameter.
        direction: Direction,
        /// Points there are.
        points: usize,
        /// The degree.
        degree: usize,
    },
    /// A row of control points of another length.
    #[error(
        "nurbs: control_points[{row}]: {found} points; expected {expected}, as in the first row"
    )]
    Ragged {
        /// Index of the row.
        row: usize,
        /// Its points.
        found: usize,
        /// Those of the first row.
        expected: usize,
    },
    /// A knot vector of the wrong length.
    #[error(
        "nurbs: knots_{direction}: {found} knots; expected {expected}, the control points along {direction} plus degree_{direction} plus 1, each knot as often as it counts"
    )]
    KnotCount {
        /// Of which parameter.
        direction: Direction,
        /// Knots there are.
        found: usize,
        /// Knots there should be.
        expected: usize,
    },
    /// A knot that is no number.
    #[error("nurbs: knots_{direction}[{index}] is not a finite number")]
    KnotNotFinite {
        /// Of which parameter.
        direction: Direction,
        /// Its index.
        index: usize,
    },
    /// A knot smaller than the one before.
    #[error("nurbs: knots_{direction}[{index}] = {} after {}; knots must not decrease", Shown(*value), Shown(*before))]
    KnotsDecrease {
        /// Of which parameter.
        direction: Direction,
        /// Its index.
        index: usize,
        /// The knot before.
        before: f64,
        /// The knot.
        value: f64,
    },
    /// A knot so often that the surface is torn there.
    #[error(
        "nurbs: knots_{direction}: the knot {} occurs more than {degree} times inside, which tears the surface; split the surface there",
        Shown(*value)
    )]
    KnotRepeats {
        /// Of which parameter.
        direction: Direction,
        /// The knot.
        value: f64,
        /// Its largest multiplicity.
        degree: usize,
    },
    /// The knots span nothing.
    #[error(
        "nurbs: knots_{direction}: the surface reaches from {} to {} in {direction}; give knots that increase",
        Shown(*low),
        Shown(*high)
    )]
    EmptyDomain {
        /// Of which parameter.
        direction: Direction,
        /// Where it begins.
        low: f64,
        /// Where it ends.
        high: f64,
    },
    /// A coordinate that is not a number, or too large.
    #[error("nurbs: control_points[{i}][{j}]: the coordinates ({}, {}, {}) are not finite or too large", Shown(at.x), Shown(at.y), Shown(at.z))]
    NotFinite {
        /// Index along u.
        i: usize,
        /// Index along v.
        j: usize,
        /// The point.
        at: DVec3,
    },
    /// A weight that is not positive.
    #[error(
        "nurbs: the weight of control_points[{i}][{j}] is {}; weights must be from 1e-9 to 1e9",
        Shown(*weight)
    )]
    Weight {
        /// Index along u.
        i: usize,
        /// Index along v.
        j: usize,
        /// The weight.
        weight: f64,
    },
    /// A trimming rectangle outside the surface.
    #[error("nurbs: trim_domain = [{}, {}, {}, {}]: expected [u from, u to, v from, v to], increasing, within [{}, {}] x [{}, {}]", Shown(trim[0]), Shown(trim[1]), Shown(trim[2]), Shown(trim[3]), Shown(low.x), Shown(high.x), Shown(low.y), Shown(high.y))]
    TrimDomain {
        /// The rectangle.
        trim: [f64; 4],
        /// Least parameters of the surface.
        low: DVec2,
        /// Greatest parameters of the surface.
        high: DVec2,
    },
    /// All points coincide or lie on a line.
    #[error(
        "nurbs: the surface has no area: its control points lie on a point or a line; check the file and surface.scale"
    )]
    NoArea,
    /// Trimming loops that cross or touch.
    #[error("nurbs: the trimming loops cross or touch near ({:.4}, {:.4}, {:.4}) mm; mend the face there", at.x, at.y, at.z)]
    LoopsCross {
        /// Where, mm.
        at: DVec3,
    },
    /// Trimming loops that bound nothing.
    #[error("nurbs: the trimming loops do not bound a piece of the surface: {why}; mend the face")]
    BadLoops {
        /// What is wrong.
        why: &'static str,
    },
    /// The mesh would be too large.
    #[error(
        "nurbs: a chord error of {} mm takes {} triangles or more, most of them near ({:.4}, {:.4}, {:.4}) mm, more than the {most} that are allowed; allow a larger error with surface.chord, or machine a part of the surface", Shown(*chord), Shown(count.round()), at.x, at.y, at.z
    )]
    TooFine {
        /// Where the surface bends most, mm.
        at: DVec3,
        /// Triangles (points of the boundary) it took so far, or estimated.
        count: f64,
        /// The chord error asked for, mm.
        chord: f64,
        /// Most triangles.
        most: usize,
    },
    /// The chord error cannot be reached.
    #[error("nurbs: near ({:.4}, {:.4}, {:.4}) mm the mesh stays {error:.3e} mm off the surface, more than the {} mm of surface.chord; the surface has a crease or folds there: mend it, or allow more", at.x, at.y, at.z, Shown(*chord))]
    NotReached {
        /// Where, mm.
        at: DVec3,
        /// The chord error there, mm.
        error: f64,
        /// The one asked for, mm.
        chord: f64,
    },
}
