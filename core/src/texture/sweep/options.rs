//! What is swept: the cutter with its teeth, and how its sweep is simulated.

use crate::texture::edge::Runout;
use crate::texture::kinematics::Spindle;
use crate::tool::Tool;

/// Which part of the edges is simulated.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum EdgePart {
    /// The part that can touch material.
    Effective,
    /// All of it: bottom, corner, and the side up to the start height.
    Full,
}

/// How time steps and elements of an edge find the nodes that they may lower.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum Search {
    /// Tile by tile: only steps and elements that come near a tile are looked at.
    Near,
    /// All elements in all steps; each quadrilateral is tested with the nodes of its box along the grid, however high it
    /// goes over them, and on one thread. A measure for the other, which gives the same heights.
    Buckets,
}

/// A cutter with its teeth.
#[derive(Clone, Debug, PartialEq)]
pub struct Cutter {
    /// Its body.
    pub tool: Tool,
    /// Number of teeth.
    pub flutes: u32,
    /// Helix angle, rad.
    pub helix: f64,
    /// How the teeth stand to the axis of turning.
    pub runout: Runout,
    /// How it turns.
    pub spindle: Spindle,
}

/// How a sweep is simulated.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct SweepOptions {
    /// Height of the material over the surface before, mm.
    pub start: f64,
    /// How far above the contact material reaches on the edge, mm; see [`thickness`](crate::texture::engagement::thickness).
    pub thickness: f64,
    /// How far the path may be off the surface, mm; added to the thickness.
    pub slack: f64,
    /// Part of the edges.
    pub part: EdgePart,
    /// Part of the edges whose points go no farther than the resolution in a time step. Parts can be compared node for
    /// node where it is the same.
    pub pace: EdgePart,
    /// How nodes are found.
    pub search: Search,
    /// Shortest length that is resolved, mm: `l_min`, of [`resolution`](crate::texture::steps::resolution); `None` for the
    /// grid's shortest cell, which is too long where cells are coarser than the marks of the teeth.
    pub resolution: Option<f64>,
    /// Number of threads, which changes nothing but the time.
    pub threads: usize,
}
