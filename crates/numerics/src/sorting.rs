//! Sorting that is compiled once for all types, where speed does not matter.
//!
//! The standard library's sort is compiled again for each type and comparison, with 5 kB of
//! WebAssembly each time. This sort sorts indices, so that all callers share one copy.

use std::cmp::Ordering;

/// Sorts by a comparison, as `slice::sort_by` does: equal items keep their order.
pub fn sort_by<T>(items: &mut [T], mut compare: impl FnMut(&T, &T) -> Ordering) {
    let mut from = places(items.len(), &mut |i, j| compare(&items[i], &items[j]));
    for begin in 0..from.len() {
        // Follows the cycle of moves through this index.
        let mut to = begin;
        while from[to] != begin {
            let next = std::mem::replace(&mut from[to], to);
            items.swap(to, next);
            to = next;
        }
        from[to] = to;
    }
}

/// Sorts by a key, as `slice::sort_by_key` does: items of equal keys keep their order.
pub fn sort_by_key<T, K: Ord>(items: &mut [T], mut key: impl FnMut(&T) -> K) {
    sort_by(items, |a, b| key(a).cmp(&key(b)));
}

/// The index of each sorted item before sorting.
#[inline(never)]
fn places(count: usize, compare: &mut dyn FnMut(usize, usize) -> Ordering) -> Vec<usize> {
    let mut places: Vec<usize> = (0..count).collect();
    places.sort_by(|&i, &j| compare(i, j));
    places
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn second_method_the_order_is_that_of_the_standard_library(keys in proptest::collection::vec(0..9u8, 0..60)) {
            // Few keys, so that many are equal; the second number records their order.
            let mut items: Vec<(u8, usize)> = keys.into_iter().zip(0..).collect();
            let mut others = items.clone();
            super::sort_by_key(&mut items, |item| item.0);
            others.sort_by_key(|item| item.0);
            prop_assert_eq!(items, others);
        }
    }
}
