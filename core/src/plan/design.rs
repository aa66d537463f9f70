//! The files that a job names → its surface, and the part to which it belongs.

use super::blades::{self, ChannelParts};
use super::error::{FARTHEST, PlanError};
use super::load::{Avoided, Files, SurfaceKeys, load, load_avoided, load_stock};
use crate::geometry::DVec3;
use crate::hub::Passage;
use crate::machine::{Axes, LONGEST_TRAVEL};
use crate::reach::{Aside, Reached, reach, turn_outward};
use crate::surface::{Part, Surface, Warning, Whole};

/// What is machined, and what else there is.
#[derive(Clone, Debug)]
pub struct Design {
    /// The surface to be machined: what the job selects, or what the cutter reaches of that.
    pub surface: Surface,
    /// Number of its connected pieces.
    pub pieces: usize,
    /// What of the selection is not machined, if the surface is what the cutter reaches of it.
    pub aside: Option<Aside>,
    /// Over which of its faces the cutter bridges the part; empty where it is machined as it is.
    pub bridges: Vec<bool>,
    /// Which of its faces are the cutter's own surface, as it bridges the part; empty where it is machined as it is.
    pub(super) is_of_cutter: Vec<bool>,
    /// Facets of the part that are not machined, and of what is avoided: for pictures.
    pub rest: Part,
    /// What of the part must not be cut into beside the surface itself: its rest, and all of it under a reached surface.
    pub guarded: Part,
    /// Warnings about the surface.
    pub warnings: Vec<Warning>,
    /// The part to which the surface belongs.
    pub(super) part: Part,
    /// The material before the first operation, if the job says where it ends.
    pub stock: Option<Part>,
    /// What the whole tool stays away from.
    pub avoided: Vec<Avoided>,
    /// The channel of a hub that the surface is, and the hub about it.
    pub(super) passage: Option<(Passage, Part)>,
}

impl Design {
    /// Reads the surface of jobs with these keys. `threads`: number of threads, on which the result does not depend.
    ///
    /// # Errors
    /// [`PlanError`]: a surface that cannot be read or used, or of which nothing can be reached.
    pub fn new(keys: &SurfaceKeys, files: Files, threads: usize) -> Result<Self, PlanError> {
        if let Some(hub) = &keys.hub {
            return Self::of_channel(blades::channel(keys, files, hub)?, keys.axes);
        }
        let Whole { mut part, mut machined, surface, mut warnings } = load(keys, files)?;
        let (stock, avoided) = (load_stock(keys, files)?, load_avoided(keys, files)?);
        refuse_too_far(keys.axes, &part)?;
        let (surface, pieces, aside, [bridges, is_of_cutter], [mut rest, guarded]) =
            match keys.reach(threads) {
                Some(options) => {
                    let count = turn_outward(&mut part);
                    turn_outward(&mut machined);
                    warnings.extend((count > 0).then_some(Warning::TurnedOutward { count }));
                    let Reached { surface, pieces, aside, bridges, is_of_cutter, rest } =
                        reach(&part, &machined, &options)?;
                    (surface, pieces, Some(aside), [bridges, is_of_cutter], [rest, part.clone()])
                }
                None => {
                    let surface = surface?;
                    let rest = part.without(&surface);
                    (surface, 1, None, [Vec::new(), Vec::new()], [rest.clone(), rest])
                }
            };
        avoided.iter().for_each(|avoided| rest.add(&avoided.mesh));
        Ok(Self {
            surface,
            pieces,
            aside,
            bridges,
            is_of_cutter,
            rest,
            guarded,
            warnings,
            part,
            stock,
            avoided,
            passage: None,
        })
    }

    /// A channel of a hub, between two blades.
    fn of_channel(parts: ChannelParts, axes: Axes) -> Result<Self, PlanError> {
        let ChannelParts { passage, surface, mut part, warnings, about } = parts;
        let mut rest = passage.blades().clone();
        rest.add(&about);
        part.add(&rest);
        refuse_too_far(axes, &part)?;
        Ok(Self {
            surface,
            pieces: 1,
            aside: None,
            bridges: Vec::new(),
            is_of_cutter: Vec::new(),
            guarded: rest.clone(),
            rest,
            // The side from which a channel is machined is known.
            warnings: warnings.into_iter().filter(|w| !w.is_of_side()).collect(),
            part,
            stock: None,
            avoided: Vec::new(),
            passage: Some((passage, about)),
        })
    }

    /// The channel of a hub that the surface is, if it is one.
    pub fn passage(&self) -> Option<&Passage> {
        self.passage.as_ref().map(|(passage, _)| passage)
    }

    /// The hub about that channel.
    pub fn hub_about(&self) -> Option<&Part> {
        self.passage.as_ref().map(|(_, about)| about)
    }
}

fn refuse_too_far(axes: Axes, part: &Part) -> Result<(), PlanError> {
    let (low, high) = part
        .positions
        .iter()
        .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(l, h), &p| (l.min(p), h.max(p)));
    let middle = 0.5 * (low + high);
    let (distance, times) = (middle.length(), middle.length() / (high - low).length());
    if distance > LONGEST_TRAVEL {
        return Err(PlanError::FarFromOrigin { middle, distance });
    }
    if axes != Axes::ThreeAxis && times > FARTHEST {
        return Err(PlanError::FarFromCentre { middle, distance, times });
    }
    Ok(())
}
