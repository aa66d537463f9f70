//! Independent work on several threads, with results that do not depend on their number.

use crate::geometry::OrderBy;
use std::sync::atomic::{AtomicUsize, Ordering};

/// `work` on every item, the results in the items' order.
///
/// With one thread nothing is spawned, as WebAssembly needs.
pub fn map<T: Sync, R: Send>(threads: usize, items: &[T], work: impl Fn(&T) -> R + Sync) -> Vec<R> {
    if threads <= 1 || items.len() <= 1 {
        return items.iter().map(work).collect();
    }
    let next = AtomicUsize::new(0);
    let run = || {
        let mut done = Vec::new();
        while let Some((i, item)) = Some(next.fetch_add(1, Ordering::Relaxed))
            .and_then(|i| items.get(i).map(|item| (i, item)))
        {
            done.push((i, work(item)));
        }
        done
    };
    let mut all: Vec<(usize, R)> = std::thread::scope(|scope| {
        let helpers: Vec<_> = (1..threads.min(items.len())).map(|_| scope.spawn(run)).collect();
        let mut all = run();
        for helper in helpers {
            match helper.join() {
                Ok(done) => all.extend(done),
                Err(panic) => std::panic::resume_unwind(panic),
            }
        }
        all
    });
    all.order_by_key(|(i, _)| *i);
    all.into_iter().map(|(_, r)| r).collect()
}

/// Both results, `second` made on a thread of its own if there is more than one.
pub fn both<A, B: Send>(
    threads: usize,
    first: impl FnOnce() -> A,
    second: impl FnOnce() -> B + Send,
) -> (A, B) {
    if threads <= 1 {
        let a = first();
        return (a, second());
    }
    std::thread::scope(|scope| {
        let other = scope.spawn(second);
        let a = first();
        match other.join() {
            Ok(b) => (a, b),
            Err(panic) => std::panic::resume_unwind(panic),
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn order_is_kept_for_any_number_of_threads() {
        let items: Vec<u64> = (0..1000).collect();
        let one = map(1, &items, |x| x * x);
        for threads in [2, 3, 16] {
            assert_eq!(map(threads, &items, |x| x * x), one);
        }
        assert_eq!(both(2, || 1, || 2), both(1, || 1, || 2));
    }
}
