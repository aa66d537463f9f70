//! Sorting whose code is there once, not once for each kind of item, where that matters.
//!
//! Each call of a slice's own sort adds some ten kilobytes to a program; in the module that the page loads they were a
//! sixth of all. There items are put in order by their numbers, which one function sorts. The order is the same.

use core::cmp::Ordering;

/// Sorting; as [`slice::sort_by`] and [`slice::sort_by_key`].
pub trait OrderBy<T> {
    /// By a comparison.
    fn order_by(&mut self, compare: impl FnMut(&T, &T) -> Ordering);

    /// By a key.
    fn order_by_key<K: Ord>(&mut self, mut key: impl FnMut(&T) -> K) {
        self.order_by(|a, b| key(a).cmp(&key(b)));
    }

    /// By a comparison that finds only what cannot be told apart to be equal: so it need not be stable.
    fn order_total_by(&mut self, compare: impl FnMut(&T, &T) -> Ordering);

    /// By a key that no two items share.
    fn order_total_by_key<K: Ord>(&mut self, mut key: impl FnMut(&T) -> K) {
        self.order_total_by(|a, b| key(a).cmp(&key(b)));
    }

    /// Items of which equal ones cannot be told apart.
    fn order_total(&mut self)
    where
        T: Ord,
    {
        self.order_total_by(T::cmp);
    }
}

/// So few items are put in order where they stand.
const FEW: usize = 12;

impl<T> OrderBy<T> for [T] {
    fn order_by(&mut self, mut compare: impl FnMut(&T, &T) -> Ordering) {
        if cfg!(not(any(target_arch = "wasm32", test))) {
            return self.sort_by(compare);
        }
        let from = numbers(self.len(), &mut |a, b| compare(&self[a], &self[b]));
        rearrange(self, from);
    }

    fn order_total_by(&mut self, mut compare: impl FnMut(&T, &T) -> Ordering) {
        if cfg!(not(any(target_arch = "wasm32", test))) {
            return self.sort_unstable_by(compare);
        }
        if self.len() > FEW {
            return self.order_by(compare);
        }
        for end in 1..self.len() {
            let mut at = end;
            while at > 0 && compare(&self[at - 1], &self[at]) == Ordering::Greater {
                self.swap(at - 1, at);
                at -= 1;
            }
        }
    }
}

/// The numbers of items in their order.
#[inline(never)]
fn numbers(count: usize, compare: &mut dyn FnMut(usize, usize) -> Ordering) -> Vec<usize> {
    let mut numbers: Vec<usize> = (0..count).collect();
    numbers.sort_by(|&a, &b| compare(a, b));
    numbers
}

/// Puts at each place the item that stood at the place named for it.
fn rearrange<T>(items: &mut [T], mut from: Vec<usize>) {
    for start in 0..from.len() {
        let mut place = start;
        // Along a cycle each item is swapped to where it belongs; a place that is done names itself.
        loop {
            let source = core::mem::replace(&mut from[place], place);
            if source == start || source == place {
                break;
            }
            items.swap(place, source);
            place = source;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn items_are_ordered_as_a_slice_orders_them() {
        let mut state = 7_u64;
        let mut next = |below: u64| {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            (state >> 33) % below
        };
        for count in 0..60 {
            for kinds in [1, 3, 1000] {
                let items: Vec<(u64, usize)> = (0..count).map(|i| (next(kinds), i)).collect();
                let (mut ours, mut theirs) = (items.clone(), items);
                ours.order_by_key(|item| item.0);
                theirs.sort_by_key(|item| item.0);
                assert_eq!(ours, theirs);
                ours.order_total();
                theirs.sort_unstable();
                assert_eq!(ours, theirs);
                ours.order_total_by_key(|item| (core::cmp::Reverse(item.0), item.1));
                theirs.sort_unstable_by_key(|item| (core::cmp::Reverse(item.0), item.1));
                assert_eq!(ours, theirs);
                ours.order_by(|a, b| b.0.cmp(&a.0));
                theirs.sort_by_key(|item| core::cmp::Reverse(item.0));
                assert_eq!(ours, theirs);
            }
        }
    }
}
