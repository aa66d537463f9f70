//! What the search for rest works on: a surface, how paths are put on it, what may be left.

use super::samples::{Places, Sample};
use crate::link::Deliverer;
use crate::removal::{Before, Place};
use std::collections::BTreeSet;

/// What may be left.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct RestOptions {
    /// Distance between passes, mm.
    pub side_step: f64,
    /// Places higher than this are machined again, mm.
    pub limit: f64,
    /// Higher than this, mm, is left only where the cutter does not come as low.
    pub allowed: f64,
    /// Places lower than this, mm, do not come near the limit again.
    pub close: f64,
    /// How far the edge of the strip trails behind the contact, mm: branches continue beyond the boundary by this.
    pub lag: f64,
    /// Whether passes must cover the surface up to its boundary: no wall stands there.
    pub has_open_rim: bool,
}

/// Measures a path and cuts what it leaves too high.
pub struct Rest<'a> {
    pub(super) options: RestOptions,
    pub(super) places: Places<'a>,
    pub(super) deliverer: Deliverer<'a>,
    /// What has cut the material before.
    pub(super) before: &'a Before,
    /// Those that were nearly too high.
    pub(super) samples: Vec<Sample>,
    /// Whether samples were placed beside passes, on the ridges, and not yet thinned out.
    pub(super) on_ridges: bool,
    /// Whether what a wall keeps the cutter from is lowered as far as the cutter comes beside the wall.
    pub(super) beside_walls: bool,
    /// The cells of the chart through which branches go that were inserted since all samples were looked at.
    pub(super) branched: BTreeSet<[i64; 2]>,
    /// What is too high and cannot be lowered.
    pub(super) inaccessible: Vec<Place>,
}

impl<'a> Rest<'a> {
    /// For the places of a surface on which `deliverer` puts paths, and from which `before` has cut already.
    pub(crate) fn new(
        places: Places<'a>,
        deliverer: Deliverer<'a>,
        before: &'a Before,
        options: RestOptions,
    ) -> Self {
        Self {
            options,
            places,
            deliverer,
            before,
            samples: Vec::new(),
            on_ridges: false,
            beside_walls: false,
            branched: BTreeSet::new(),
            inaccessible: Vec::new(),
        }
    }
}
