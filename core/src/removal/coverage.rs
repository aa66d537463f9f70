//! What the path leaves uncut, and whether the cutter could have removed it.

use super::body::{Layer, Line};
use super::columns::{Column, Columns};
use super::remains::Strokes;
use super::stock::Before;
use crate::cutter_location::{Obstacles, PassOptions, ToolAxis};
use crate::cutter_location::{is_in_wall, lowest_off_walls, raise_at};
use crate::geometry::{DVec2, DVec3, OrderBy};
use crate::parallel;
use crate::toolpath::{PathPoint, Toolpath};

/// Fraction of the tolerance by which a column may stand above the cusps: the rest is for the tops of cusps, which
/// lie between columns.
const SHARE: f64 = 0.5;
/// A column that lost less than this fraction of the layer's depth counts as untouched.
const UNTOUCHED: f64 = 1e-6;

/// What a delivered path leaves above the cusps that are meant to stay, as areas on the surface.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Coverage {
    /// Area of all columns, mm².
    pub area: f64,
    /// Uncut although the cutter could touch there, mm².
    pub never_covered: f64,
    /// Its greatest height, mm.
    pub never_covered_at: Option<DVec3>,
    /// Flat places of all of it.
    pub never_covered_flat: Vec<DVec2>,
    /// Uncut because the cutter cannot touch there, mm².
    pub inaccessible: f64,
    /// Its greatest height, mm.
    pub inaccessible_at: Option<DVec3>,
    /// Spheres that contain everything inaccessible.
    pub inaccessible_places: Vec<Place>,
}

/// A sphere.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Place {
    /// Its centre, mm.
    pub centre: DVec3,
    /// Its radius, mm.
    pub radius: f64,
}

/// What determines where the cutter can touch.
pub struct Access<'a> {
    /// How the cutter is located.
    pub pass: PassOptions,
    /// The layer.
    pub layer: Layer,
    /// The part and its walls.
    pub obstacles: &'a Obstacles,
    /// The path: the cutter faces as at its nearest point.
    pub path: &'a Toolpath,
    /// Columns close to walls, which those of the layer may miss; `None` without walls.
    pub rim: Option<Columns>,
    /// Whether passes run along the walls. Where they end at them instead, what is left within reach of a wall is
    /// attributed to the wall.
    pub follows_walls: bool,
    /// Height over the allowance that may stay, mm.
    pub cusp: f64,
    /// Size of the cells that inaccessible places are gathered in, mm.
    pub cell: f64,
    /// What has cut the material before.
    pub(crate) before: &'a Before,
    /// Number of threads.
    pub threads: usize,
}

/// A column that is left too high.
struct Left {
    column: Column,
    flat: DVec2,
    over: f64,
}

/// What the path leaves of the columns.
pub fn coverage(columns: &Columns, access: &Access) -> Coverage {
    let mut left = left_over(columns, access);
    left.extend(access.rim.iter().flat_map(|rim| left_over(rim, access)));
    let fits = fits(&left, access);
    let mut out = Coverage { area: columns.area(), ..Coverage::default() };
    let mut highest = [f64::NEG_INFINITY; 2];
    let mut out_of_reach = Vec::new();
    for (l, fits) in left.iter().zip(fits) {
        let (area, place, highest) = if fits {
            out.never_covered_flat.push(l.flat);
            (&mut out.never_covered, &mut out.never_covered_at, &mut highest[0])
        } else {
            out_of_reach.push(l.column.line.foot);
            (&mut out.inaccessible, &mut out.inaccessible_at, &mut highest[1])
        };
        *area += l.column.section.area;
        if l.over > *highest {
            (*highest, *place) = (l.over, Some(l.column.line.foot));
        }
    }
    // Between a wall and the cutter beside it a wedge runs out that is narrower than the rim's columns see.
    let wedge = access.rim.as_ref().map_or(0.0, |_| access.wedge());
    out.inaccessible_places = gathered(&out_of_reach, access.cell, columns.spacing + wedge);
    out
}

impl Access<'_> {
    /// Distance beside its contact with a wall at which the cutter is off the wall by the tolerance, mm.
    fn wedge(&self) -> f64 {
        (2.0 * self.pass.tool.radius() * self.pass.tolerance).sqrt()
    }

    /// The greatest height of a column that is not too high, mm.
    fn allowed(&self) -> f64 {
        // What no move took from is left, however high a cusp may be.
        let untouched = self.layer.top() - UNTOUCHED * self.layer.depth;
        (self.layer.allowance + self.cusp + SHARE * self.pass.tolerance).min(untouched)
    }
}

fn left_over(columns: &Columns, access: &Access) -> Vec<Left> {
    let allowed = access.allowed();
    let (tool, length) = (access.pass.tool, access.pass.reach);
    // Which piece removes what is not asked.
    let strokes = Strokes::of(access.path, &tool);
    let stages = access.before.with(&strokes, tool, length);
    let heights = columns.remains(&stages, access.layer, allowed, access.threads);
    let mut left = Vec::new();
    for (block, heights) in columns.blocks.iter().zip(&heights) {
        for (i, &height) in heights.iter().enumerate().filter(|(_, h)| **h > allowed) {
            let (column, flat) = (block.columns[i], block.flat[i]);
            left.push(Left { column, flat, over: height - allowed });
        }
    }
    left
}

/// Whether the cutter could lower each column far enough: from where it touches the column, or beside walls from the
/// nearest possible position.
fn fits(left: &[Left], access: &Access) -> Vec<bool> {
    let feeds = FeedIndex::new(access.path, access.pass.axis);
    let (pass, obstacles) = (access.pass, access.obstacles);
    // What the path leaves at its best may be higher by its chords.
    let allowed = access.allowed() - pass.tolerance;
    parallel::map(access.threads, left, |l| {
        let Line { foot, normal } = l.column.line;
        let feed = feeds.nearest(l.flat);
        let is_clear = || raise_at(foot, normal, feed, &pass, obstacles) <= pass.tolerance;
        match access.follows_walls {
            true => match lowest_off_walls(foot, normal, feed, &pass, obstacles) {
                Some(at) => at.contains(foot + normal * allowed),
                None => is_clear(),
            },
            false => !is_in_wall(foot, normal, feed, &pass, obstacles) && is_clear(),
        }
    })
}

/// The directions in which the cutter faces along a path, by place.
pub(crate) struct FeedIndex {
    /// Flat place and direction of the points, by their first coordinate.
    points: Vec<(DVec2, DVec3)>,
}

impl FeedIndex {
    /// Empty where the axis does not depend on the feed.
    pub fn new(path: &Toolpath, axis: ToolAxis) -> Self {
        let mut points: Vec<_> = match axis {
            ToolAxis::Fixed(_) => Vec::new(),
            // It leans that way: on a branch's way back it faces against the feed.
            ToolAxis::Lead(lead) => {
                let facing = |p: &PathPoint| (p.axis - p.normal * p.axis.dot(p.normal)) * lead;
                path.points.iter().filter_map(|p| Some((p.flat?, facing(p)))).collect()
            }
        };
        points.order_by(|a, b| a.0.x.total_cmp(&b.0.x));
        Self { points }
    }

    /// The direction in which the cutter faces at the point nearest to `at`.
    pub fn nearest(&self, at: DVec2) -> DVec3 {
        let start = self.points.partition_point(|m| m.0.x < at.x);
        let mut best = (f64::INFINITY, DVec3::ZERO);
        let mut look = |m: &(DVec2, DVec3)| {
            let square = m.0.distance_squared(at);
            if square < best.0 {
                best = (square, m.1);
            }
            (m.0.x - at.x) * (m.0.x - at.x) <= best.0
        };
        let _ = self.points[start..].iter().all(&mut look);
        let _ = self.points[..start].iter().rev().all(&mut look);
        best.1
    }
}

/// Spheres over places gathered by a grid of cells of size `cell`, each wider by `margin`.
fn gathered(places: &[DVec3], cell: f64, margin: f64) -> Vec<Place> {
    let mut keyed: Vec<([i64; 3], DVec3)> =
        places.iter().map(|&p| ((p / cell).to_array().map(|x| x.floor() as i64), p)).collect();
    keyed.order_by_key(|k| k.0);
    keyed
        .chunk_by(|a, b| a.0 == b.0)
        .map(|group| {
            let centre = group.iter().map(|g| g.1).sum::<DVec3>() / group.len() as f64;
            let far = group.iter().map(|g| g.1.distance(centre)).fold(0.0, f64::max);
            Place { centre, radius: far + margin }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spheres_hold_what_was_gathered() {
        let places: Vec<DVec3> = (0..500)
            .map(|i| DVec3::new(f64::from(i % 23), f64::from(i % 7), 0.01 * f64::from(i)))
            .collect();
        let spheres = gathered(&places, 2.5, 0.1);
        assert!(spheres.len() < 120);
        let held = |p: &DVec3| spheres.iter().any(|s| s.centre.distance(*p) <= s.radius);
        assert!(places.iter().all(held));
        assert!(spheres.iter().all(|s| s.radius <= 2.5 * 3.0f64.sqrt() + 0.1));
    }
}
