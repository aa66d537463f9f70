//! Boxes that are looked up by the places in them.

use super::DVec3;
use rstar::RTree;
use rstar::primitives::{GeomWithData, Rectangle};

/// A box with a number.
pub type Boxed = GeomWithData<Rectangle<[f64; 3]>, u32>;

/// The box with this number that holds some places.
pub fn around(number: u32, places: &[DVec3]) -> Boxed {
    let low = places.iter().fold(DVec3::INFINITY, |low, p| low.min(*p));
    let high = places.iter().fold(DVec3::NEG_INFINITY, |high, p| high.max(*p));
    GeomWithData::new(Rectangle::from_corners(low.to_array(), high.to_array()), number)
}

/// Boxes, by their places.
pub struct Boxes(RTree<Boxed>);

impl Boxes {
    /// These boxes.
    pub fn new(boxes: Vec<Boxed>) -> Self {
        Self(RTree::bulk_load(boxes))
    }

    /// The numbers of the boxes that hold a place, in no order.
    pub fn holding(&self, place: DVec3) -> impl Iterator<Item = u32> + '_ {
        self.0.locate_all_at_point(place.to_array()).map(|found| found.data)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn boxes_hold_the_places_on_their_sides() {
        let corner = |x: f64| DVec3::new(x, 0.0, 0.0);
        let flat = |n: u32, from: f64, to: f64| around(n, &[corner(from), corner(to)]);
        let boxes = Boxes::new(vec![flat(7, 0.0, 2.0), flat(3, 2.0, 5.0)]);
        let at = |x: f64| {
            let mut found: Vec<u32> = boxes.holding(corner(x)).collect();
            found.sort_unstable();
            found
        };
        assert_eq!([at(-1.0), at(1.0), at(2.0), at(5.0)], [vec![], vec![7], vec![3, 7], vec![3]]);
    }
}
