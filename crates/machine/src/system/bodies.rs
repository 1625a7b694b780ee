//! Rows of the bodies' coordinates.

use super::BodyRows;
use super::reduction::Reduction;
use crate::description::Description;
use crate::functional::Functional;
use crate::signals::Signals;

/// The rows of all bodies.
pub(super) fn bodies(
    d: &Description,
    reduction: &Reduction,
    signals: &Signals,
    motions: &[Option<usize>],
    rows: &[Functional],
) -> Vec<BodyRows> {
    let (n, size) = (reduction.kept.len(), signals.size);
    let prescribed = |i: usize, order: usize| {
        let of = |&(j, weight): &(usize, f64)| {
            let mut row = (*rows[motions[j]?]).clone();
            (0..order).for_each(|_| row = signals.derivative(&row));
            Some((weight, Functional::of(row)))
        };
        let parts: Vec<(f64, Functional)> = reduction.prescribed[i].terms().iter().filter_map(of).collect();
        Functional::sum(size, parts.iter().map(|(weight, row)| (*weight, row)))
    };
    let of = |i: usize| {
        let own = reduction.q[i].terms();
        let shifted = |first: usize| Functional::from_terms(size, own.iter().map(|&(k, x)| (first + k, x)));
        // The coordinates come before the signals.
        let both = |first: usize, order: usize| {
            Functional::sum(size, [(1.0, &shifted(first)), (1.0, &prescribed(i, order))])
        };
        let weights = Functional::from_terms(n, own.iter().copied());
        BodyRows { s: both(0, 0), v: both(n, 1), weights, drift: prescribed(i, 2) }
    };
    (0..d.bodies.len()).map(of).collect()
}
