//! Samples of a surface as marks in the pixels in which they are seen.
//!
//! Steps: (1) every visible sample marks its pixel, and of several in one the worst stays: a mean
//! would hide faults; (2) lone faults grow until they can be seen; (3) pixels without a sample take
//! the mark of the nearest that has one.

use super::shading::Side;
use super::view::Canvas;
use evencut_core::geometry::DVec3;
use std::collections::VecDeque;

/// What is marked, in the order of weight.
#[derive(Copy, Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Rank {
    /// Not judged.
    Apart,
    /// Within the limit.
    Within,
    /// Above the limit.
    Above,
    /// No move came there.
    Untouched,
    /// The part is cut into.
    Gouge,
}

/// The mark of a pixel. The larger one outweighs the smaller: by rank, then by value.
#[derive(Copy, Clone, Debug, PartialEq, PartialOrd)]
pub struct Mark {
    /// What it tells.
    pub rank: Rank,
    /// How much of it.
    pub value: f32,
    /// Its colour's number.
    pub tone: u8,
}

/// Pixels around a lone fault that show it too: less is lost in the picture, more looks larger than
/// other faults.
const GROWTH: isize = 2;
/// A fault with fewer than `SEEN` faulty pixels within `LONE` of it is lone: others are seen as they
/// are, and dots along a cusp that just reaches the limit would look like more than that.
const LONE: isize = 8;
const SEEN: usize = 4;

/// The mark of every pixel of a canvas; `None` where nothing is known.
pub fn field(canvas: &Canvas, samples: impl Iterator<Item = (DVec3, Mark)>) -> Vec<Option<Mark>> {
    let mut field = vec![None; canvas.raster.shade.len()];
    for (place, mark) in samples {
        if let Some(pixel) = canvas.pixel(place) {
            keep_worst(&mut field[pixel], mark);
        }
    }
    grow_lone_faults(canvas, &mut field);
    fill_gaps(canvas, &mut field);
    field
}

fn keep_worst(pixel: &mut Option<Mark>, mark: Mark) {
    if pixel.is_none_or(|held| mark > held) {
        *pixel = Some(mark);
    }
}

/// Pixels within `reach` of one, corners left out, itself included.
fn around(canvas: &Canvas, pixel: usize, reach: isize) -> impl Iterator<Item = usize> + use<> {
    let (width, height) = (canvas.raster.width, canvas.raster.height);
    let (x, y) = (pixel % width, pixel / width);
    let steps = move || -reach..=reach;
    let offsets = steps().flat_map(move |dy| steps().map(move |dx| (dx, dy)));
    let round = move |&(dx, dy): &(isize, isize)| reach < 2 || dx.abs() + dy.abs() < 2 * reach;
    offsets.filter(round).filter_map(move |(dx, dy)| {
        let (x, y) = (x.checked_add_signed(dx)?, y.checked_add_signed(dy)?);
        (x < width && y < height).then_some(y * width + x)
    })
}

fn grow_lone_faults(canvas: &Canvas, field: &mut [Option<Mark>]) {
    let is_fault = |pixel: &usize| field[*pixel].is_some_and(|m| m.rank >= Rank::Above);
    let is_lone =
        |pixel: &usize| around(canvas, *pixel, LONE).filter(is_fault).take(SEEN).count() < SEEN;
    let lone: Vec<usize> = (0..field.len()).filter(is_fault).filter(is_lone).collect();
    let grown: Vec<(usize, Mark)> = lone.iter().filter_map(|&p| Some((p, field[p]?))).collect();
    for (pixel, mark) in grown {
        for beside in around(canvas, pixel, GROWTH).filter(|&p| canvas.raster.shade[p] > 0) {
            keep_worst(&mut field[beside], mark);
        }
    }
}

/// Spreads marks over what is machined, breadth first.
fn fill_gaps(canvas: &Canvas, field: &mut [Option<Mark>]) {
    let machined =
        |pixel: usize| canvas.raster.look(pixel).is_some_and(|(side, _)| side == Side::Outer);
    let marked = |&pixel: &usize| field[pixel].is_some() && machined(pixel);
    let mut front: VecDeque<usize> = (0..field.len()).filter(marked).collect();
    while let Some(pixel) = front.pop_front() {
        for beside in around(canvas, pixel, 1) {
            if field[beside].is_none() && machined(beside) {
                field[beside] = field[pixel];
                front.push_back(beside);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::preview::samples;
    use crate::preview::view::{Shape, View};

    fn canvas() -> (Canvas, Vec<DVec3>) {
        let surface = samples::bump(40).surface;
        let shape = Shape::of(&surface);
        let canvas = Canvas::new(&shape, View::of(&shape, &[]), 1.5);
        let seen = surface.positions().iter().copied().filter(|&p| canvas.is_visible(p));
        let seen = seen.collect();
        (canvas, seen)
    }

    fn mark(rank: Rank, value: f32) -> Mark {
        Mark { rank, value, tone: 0 }
    }

    fn count(field: &[Option<Mark>], rank: Rank) -> usize {
        field.iter().flatten().filter(|m| m.rank == rank).count()
    }

    #[test]
    fn the_worst_of_a_pixel_stays() {
        let (canvas, seen) = canvas();
        let order = [
            mark(Rank::Above, 9.0),
            mark(Rank::Gouge, 0.1),
            mark(Rank::Gouge, 0.2),
            mark(Rank::Within, 99.0),
        ];
        for turn in 0..4 {
            let marks = (0..4).map(|i| (seen[800], order[(i + turn) % 4]));
            let field = field(&canvas, marks);
            assert_eq!(field[canvas.pixel(seen[800]).unwrap()], Some(mark(Rank::Gouge, 0.2)));
        }
    }

    #[test]
    fn a_lone_fault_can_be_seen() {
        let (canvas, seen) = canvas();
        let place = canvas.pixel(seen[800]).unwrap();
        let mut field = vec![Some(mark(Rank::Within, 0.0)); canvas.raster.shade.len()];
        field[place] = Some(mark(Rank::Gouge, 1.0));
        grow_lone_faults(&canvas, &mut field);
        let width = canvas.raster.width;
        for beside in [place - 2, place + 2, place - 2 * width, place + 2 * width] {
            assert_eq!(field[beside].unwrap().rank, Rank::Gouge);
        }
        assert_eq!(count(&field, Rank::Gouge), 21);
    }

    #[test]
    fn wide_faults_do_not_grow() {
        let (canvas, _) = canvas();
        let middle = canvas.raster.height / 2 * canvas.raster.width + canvas.raster.width / 2;
        let mut field = vec![None; canvas.raster.shade.len()];
        (middle..middle + 50).for_each(|p| field[p] = Some(mark(Rank::Above, 1.0)));
        grow_lone_faults(&canvas, &mut field);
        assert_eq!(count(&field, Rank::Above), 50);
    }

    #[test]
    fn one_sample_fills_the_surface() {
        let (canvas, seen) = canvas();
        let field = field(&canvas, std::iter::once((seen[0], mark(Rank::Within, 1.0))));
        let outer = |&p: &usize| canvas.raster.look(p).is_some_and(|l| l.0 == Side::Outer);
        assert!((0..field.len()).filter(outer).all(|p| field[p].is_some()));
        assert!((0..field.len()).filter(|p| !outer(p)).all(|p| field[p].is_none()));
    }
}
