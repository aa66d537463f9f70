//! Why the channels of a hub cannot be planned.

use crate::geometry::DVec3;
use crate::tool::AssemblyPart;
use thiserror::Error;

/// What stands against planning the channels of a hub.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum HubError {
    /// A geodesic leaves the surface or ends at a singular place.
    #[error(
        "hub: a geodesic from ({:.3}, {:.3}, {:.3}) ends {done:.3} mm on, of {wanted:.3} mm: the hub's surface ends or \
         has no normal there; take a hub surface that reaches farther",
        from.x, from.y, from.z
    )]
    GeodesicEnds {
        /// Where it begins, mm.
        from: DVec3,
        /// How far it runs, mm.
        done: f64,
        /// How far it should, mm.
        wanted: f64,
    },
    /// A curve cannot be fitted.
    #[error(
        "hub: a B-spline through the edge at ({:.3}, {:.3}, {:.3}) stays {off:.4} mm off, more than the tolerance of \
         {tolerance:.4} mm; mend the edge or widen cut.tolerance",
        at.x, at.y, at.z
    )]
    NotFitted {
        /// The worst place, mm.
        at: DVec3,
        /// How far off it is, mm.
        off: f64,
        /// What is allowed, mm.
        tolerance: f64,
    },
    /// The hub does not close around the axis.
    #[error(
        "hub: the surface does not run once around the axis ({:.3}, {:.3}, {:.3}), and is no part of a surface of \
         revolution about it; correct hub.axis or hub.origin, or give the whole hub",
        axis.x, axis.y, axis.z
    )]
    NotAround {
        /// The axis that the job gives.
        axis: DVec3,
    },
    /// The hub differs from pitch to pitch.
    #[error(
        "hub: turned by a pitch, ({:.3}, {:.3}, {:.3}) mm lies {off:.6} mm off the hub; at most {tolerance:.6} mm may be; \
         correct hub.blades, hub.axis or hub.origin",
        at.x, at.y, at.z
    )]
    NotAlike {
        /// A turned place, mm.
        at: DVec3,
        /// How far it is off, mm.
        off: f64,
        /// What is allowed, mm.
        tolerance: f64,
    },
    /// A curve has too few points to fit.
    #[error(
        "hub: a curve at ({:.3}, {:.3}, {:.3}) has {found} different points, and a B-spline of degree {degree} needs \
         at least {}; give more points along the edge",
        at.x, at.y, at.z, degree + 1
    )]
    TooFewPoints {
        /// Where it begins, mm.
        at: DVec3,
        /// Different points.
        found: usize,
        /// Degree of the curve.
        degree: usize,
    },
    /// The length of a geodesic, measured along it, is not the one asked for.
    #[error(
        "hub: a geodesic from ({:.3}, {:.3}, {:.3}) is {off:.2e} mm off its length, more than {allowed:.2e} mm; \
         the hub's surface is too uneven there for this tolerance: smooth it or widen cut.tolerance",
        from.x, from.y, from.z
    )]
    GeodesicInexact {
        /// Where it begins, mm.
        from: DVec3,
        /// Difference of the lengths, mm.
        off: f64,
        /// What is allowed, mm.
        allowed: f64,
    },
    /// A curve has no direction at a place.
    #[error(
        "hub: the edge stands still at ({:.3}, {:.3}, {:.3}), so that it has no side there; remove repeated points \
         from the edge",
        at.x, at.y, at.z
    )]
    NoDirection {
        /// The place, mm.
        at: DVec3,
    },
    /// Nothing is left of an offset after trimming.
    #[error(
        "hub: nothing of the curve {distance:.3} mm beside the edge at ({:.3}, {:.3}, {:.3}) stays that far from the \
         whole edge; take a smaller cutter or less clearance",
        at.x, at.y, at.z
    )]
    NoOffset {
        /// A place of the edge, mm.
        at: DVec3,
        /// Distance of the offset, mm.
        distance: f64,
    },
    /// A curve turns so finely that sampling it does not end.
    #[error(
        "hub: a curve needs more than {most} points within {tolerance:.4} mm, the last at ({:.3}, {:.3}, {:.3}); \
         smooth the edge or widen cut.tolerance",
        at.x, at.y, at.z
    )]
    TooFine {
        /// Where points were still wanted, mm.
        at: DVec3,
        /// Points, at most.
        most: usize,
        /// What is allowed, mm.
        tolerance: f64,
    },
    /// Neither a side of the surface lies on the hub nor does it pass through the hub.
    #[error(
        "hub: surface {foot} of the blade's foot does not meet the hub: the nearest place of its sides, at \
         ({:.3}, {:.3}, {:.3}), is {off:.4} mm off, and the tolerance is {tolerance:.4} mm; lengthen the blade into \
         the hub or widen cut.tolerance",
        at.x, at.y, at.z
    )]
    NoEdge {
        /// Index of the surface, from 0.
        foot: usize,
        /// The place of its sides that is nearest to the hub, mm.
        at: DVec3,
        /// How far it is off the hub there, mm.
        off: f64,
        /// What is allowed, mm.
        tolerance: f64,
    },
    /// No surface of a blade or fillet is given.
    #[error(
        "hub: no surface of the blade's foot is given; name its fillet, or the blade where it has none"
    )]
    NoFoot,
    /// The surfaces of a blade's foot leave a gap between their edges.
    #[error(
        "hub: the edges of the blade's surfaces on the hub leave a gap of {gap:.3} mm at ({:.3}, {:.3}, {:.3}), more \
         than {allowed:.3} mm; add the surface that is missing there",
        at.x, at.y, at.z
    )]
    EdgeGap {
        /// Where one edge ends, mm.
        at: DVec3,
        /// From there to the next edge, mm.
        gap: f64,
        /// What a straight piece may close, mm.
        allowed: f64,
    },
    /// The edge of a blade does not close.
    #[error(
        "hub: the edge of the blade on the hub is no ring: it begins at ({:.3}, {:.3}, {:.3}) and ends {gap:.3} mm from \
         there at ({:.3}, {:.3}, {:.3}), which is not at the rim of the hub; add the surface that is missing between \
         them",
        at.x, at.y, at.z, other.x, other.y, other.z
    )]
    NoRing {
        /// Where it begins, mm.
        at: DVec3,
        /// Where it ends, mm.
        other: DVec3,
        /// Their distance, mm.
        gap: f64,
    },
    /// A point of an edge is not on the hub.
    #[error(
        "hub: the edge's point at ({:.3}, {:.3}, {:.3}) is {off:.3} mm off the hub, or beyond what its surface can be \
         continued to; mend the edge, or take a hub surface that reaches farther",
        at.x, at.y, at.z
    )]
    OffHub {
        /// The place, mm.
        at: DVec3,
        /// Distance to the hub, mm.
        off: f64,
    },
    /// The edge of a blade has no two flanks.
    #[error(
        "hub: the edge of the blade near ({:.3}, {:.3}, {:.3}) has no flanks along the hub: it must run around the blade, \
         or from rim to rim of the hub; correct hub.blade",
        at.x, at.y, at.z
    )]
    NoFlanks {
        /// A place of the edge, mm.
        at: DVec3,
    },
    /// The cutter does not fit between two blades.
    #[error(
        "hub: a cutter of {diameter:.3} mm with {clearance:.3} mm to the fillets does not pass between the blades near \
         ({:.3}, {:.3}, {:.3}); the largest that does has {largest:.3} mm",
        place.x, place.y, place.z
    )]
    TooNarrow {
        /// The narrowest place, mm.
        place: DVec3,
        /// Diameter of the cutter, mm.
        diameter: f64,
        /// Distance from fillets, mm.
        clearance: f64,
        /// Largest diameter that passes, mm.
        largest: f64,
    },
    /// Blades touch each other.
    #[error(
        "hub: {blades} of these blades touch each other near ({:.3}, {:.3}, {:.3}), or come within hub.clearance; correct \
         hub.blades, or name the surfaces of one blade only",
        place.x, place.y, place.z
    )]
    Overlap {
        /// The place, mm.
        place: DVec3,
        /// Number of blades.
        blades: u32,
    },
    /// A splitter touches the blades.
    #[error(
        "hub: the splitter does not stand between the blades: it touches one, or comes within hub.clearance of it, near \
         ({:.3}, {:.3}, {:.3}); correct hub.splitter",
        place.x, place.y, place.z
    )]
    SplitterAside {
        /// The place, mm.
        place: DVec3,
    },
    /// Blades lean over the channel so far that the ball does not fit below them.
    #[error(
        "hub: a ball of {diameter:.3} mm with {clearance:.3} mm to the blades does not fit between them near \
         ({:.3}, {:.3}, {:.3}); take a smaller cutter",
        place.x, place.y, place.z
    )]
    NoRoom {
        /// The place, mm.
        place: DVec3,
        /// Diameter of the cutter, mm.
        diameter: f64,
        /// Distance from blades, mm.
        clearance: f64,
    },
    /// The tool comes too near to a blade.
    #[error(
        "hub: the {} comes within {distance:.3} mm of the blade at ({:.3}, {:.3}, {:.3}); hub.clearance is {wanted:.3} mm, \
         and between the points of the path a twentieth of it may be lost; give a thinner or longer tool, a smaller \
         cutter, or less clearance",
        part.name(), place.x, place.y, place.z
    )]
    TooNear {
        /// The place of the blade, mm.
        place: DVec3,
        /// The distance there, mm.
        distance: f64,
        /// The clearance of the job, mm.
        wanted: f64,
        /// Which part of the tool.
        part: AssemblyPart,
    },
    /// No map of the channel is found.
    #[error("hub: the map of the channel near ({:.3}, {:.3}, {:.3}) folds; correct hub.blade", at.x, at.y, at.z)]
    Folded {
        /// Its middle, mm.
        at: DVec3,
    },
    /// No tool axis keeps the tool clear at some places.
    #[error(
        "hub: no tool axis at ({:.3}, {:.3}, {:.3}) (row {row}, column {column}; {refused} of {nodes} places have none): \
         with the best one the {} {}, at ({:.3}, {:.3}, {:.3}), and {wanted:.3} mm are wanted, hub.clearance and a margin; {remedy}",
        at.x, at.y, at.z, part.name(), shown(*clearance), touches.x, touches.y, touches.z
    )]
    NoAxis {
        /// The worst place, on the hub, mm.
        at: DVec3,
        /// Its station along the channel.
        row: usize,
        /// Its place across.
        column: usize,
        /// How many places have no axis.
        refused: usize,
        /// How many there are.
        nodes: usize,
        /// Greatest clearance that was found, mm; negative where it penetrates.
        clearance: f64,
        /// What is wanted, mm.
        wanted: f64,
        /// What comes nearest there.
        part: AssemblyPart,
        /// The place of the blades or the hub that it comes nearest to, mm.
        touches: DVec3,
        /// What would help.
        remedy: String,
    },
    /// The stands do not fill their grid.
    #[error(
        "hub: {stands} stands for {rows} rows of {columns}; there must be as many as nodes, and one at least"
    )]
    AxisGrid {
        /// Stands given.
        stands: usize,
        /// Rows of the grid.
        rows: usize,
        /// Columns of the grid.
        columns: usize,
    },
    /// A stand that is none.
    #[error(
        "hub: the place in row {row}, column {column} of the channel has no finite position or no normal; mend the \
         hub's surface there"
    )]
    AxisStand {
        /// Its row.
        row: usize,
        /// Its column.
        column: usize,
    },
    /// An option out of its range.
    #[error("hub: the {name} of tool axes is {value}; it must be {rule}")]
    AxisOption {
        /// What it is.
        name: &'static str,
        /// What was given.
        value: f64,
        /// What it must be.
        rule: &'static str,
    },
}

/// A clearance in words.
fn shown(clearance: f64) -> String {
    if clearance > 0.0 {
        format!("is {clearance:.3} mm clear")
    } else if clearance == 0.0 {
        "touches".into()
    } else {
        format!("penetrates by {:.3} mm", -clearance)
    }
}
