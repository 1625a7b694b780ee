//! The potential energy of a formula's force: the integral of φ(ε, 0) by Gauss's rule on halves.

use super::Formula;
use crate::kernel::NODES;

/// Difference between the rule on an interval and on its halves, relative to the integral of |φ|,
/// at which the halves count as exact.
const EXACT: f64 = 1e-15;
/// Largest number of halvings.
const HALVINGS: u32 = 40;

/// Integrals of φ and of |φ| by Gauss's rule with twelve nodes.
fn rule(force: &dyn Fn(f64) -> f64, from: f64, to: f64) -> (f64, f64) {
    let length = to - from;
    let (mut sum, mut size) = (0.0, 0.0);
    for (node, weight) in NODES {
        let value = weight * force(from + node * length);
        sum += value;
        size += value.abs();
    }
    (sum * length, size * length.abs())
}

/// The integral over an interval with the rule's result, by halves until they agree with it.
fn halves(
    force: &dyn Fn(f64) -> f64,
    (from, to): (f64, f64),
    (whole, size): (f64, f64),
    (all, left): (f64, u32),
) -> f64 {
    let middle = 0.5 * (from + to);
    let (first, second) = (rule(force, from, middle), rule(force, middle, to));
    let sum = first.0 + second.0;
    let exact = EXACT * all.max(size).max(first.1 + second.1);
    if left == 0 || (sum - whole).abs() <= exact {
        return sum;
    }
    halves(force, (from, middle), first, (all, left - 1))
        + halves(force, (middle, to), second, (all, left - 1))
}

/// The work of the force φ(ε, 0) of a formula between two elongations, J. 0 where it is not
/// defined.
pub(crate) fn potential(formula: &Formula, from: f64, to: f64) -> f64 {
    if from == to {
        return 0.0;
    }
    let force = |e: f64| formula.value(e, 0.0).unwrap_or(0.0);
    let whole = rule(&force, from, to);
    halves(&force, (from, to), whole, (whole.1, HALVINGS))
}
