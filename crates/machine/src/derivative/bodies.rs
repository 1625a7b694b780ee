//! The derivatives of all bodies' rows by one parameter (docs/assembly-law.md (A32)).

use super::rows::BodyTangent;
use crate::description::{BodyKind, Description};
use crate::functional::StateRow;
use crate::signals::SignalTangent;
use crate::system::{BodyRows, System};
use nalgebra::{DMatrix, DVector};

/// Returns the derivatives of the rows of all bodies. Prescribed bodies follow from their signals;
/// coordinates do not vary; bodies that links determine obey Σ arm ds = -Σ darm s.
pub(super) fn bodies(
    system: &System,
    d: &Description,
    along: &Description,
    signals: &SignalTangent,
) -> Vec<BodyTangent> {
    let (n, size) = (system.coordinates, system.signals.size);
    let zero = BodyTangent {
        s: StateRow::zeros(size),
        v: StateRow::zeros(size),
        weights: DVector::zeros(n),
        drift: StateRow::zeros(size),
    };
    let mut all = vec![zero; d.bodies.len()];
    let (mut next, mut dependent) = (0, Vec::new());
    for (i, body) in d.bodies.iter().enumerate() {
        match body.kind {
            BodyKind::Prescribed { .. } | BodyKind::Integrated(_) => {
                let (rows, own) = (&system.bodies[i], &mut all[i]);
                own.s = signals.rows[next].clone();
                own.v = system.signals.derivative(&own.s) + signals.turned(&rows.s);
                own.drift = system.signals.derivative(&own.v) + signals.turned(&rows.v);
                next += 1;
            }
            BodyKind::Node(_) => dependent.push(i),
            BodyKind::Free(_) if !system.bodies_of.contains(&i) => dependent.push(i),
            BodyKind::Free(_) => {}
        }
    }
    let moves = all.iter().any(|body| body.s.amax() > 0.0 || body.v.amax() > 0.0);
    let levers = along.links.iter().any(|link| link.arms.terms.iter().any(|term| term.1 != 0.0));
    if !dependent.is_empty() && (moves || levers) {
        put_dependent(system, d, along, &dependent, &mut all);
    }
    all
}

/// Concatenates the rows s, v, drift and weights.
fn row_of(s: [&StateRow; 4]) -> impl Iterator<Item = &f64> {
    s.into_iter().flat_map(|row| row.iter())
}

/// Body, arm and derivative of the arm, for each term of a sum that is zero.
type Tie = Vec<(usize, f64, f64)>;

fn tie(terms: &[(usize, f64)], by: &[(usize, f64)]) -> Tie {
    terms.iter().zip(by).map(|(&(body, arm), &(_, darm))| (body, arm, darm)).collect()
}

/// The equation s - row · q = 0 of each node.
fn nodes(d: &Description) -> impl Iterator<Item = Tie> {
    d.bodies.iter().enumerate().filter_map(|(i, body)| {
        let BodyKind::Node(row) = &body.kind else { return None };
        let row = row.iter().map(|&(k, factor)| (k, -factor, 0.0));
        Some(std::iter::once((i, 1.0, 0.0)).chain(row).collect())
    })
}

fn put_dependent(
    system: &System,
    d: &Description,
    along: &Description,
    dependent: &[usize],
    all: &mut [BodyTangent],
) {
    let ties = d.links.iter().zip(&along.links).map(|(link, by)| tie(&link.arms.terms, &by.arms.terms));
    let ties: Vec<_> = ties.chain(nodes(d)).collect();
    let (m, size) = (ties.len(), system.signals.size);
    let mut left = DMatrix::zeros(m, dependent.len());
    let mut right = DMatrix::zeros(m, 3 * size + system.coordinates);
    for (k, terms) in ties.into_iter().enumerate() {
        let mut subtract = |factor: f64, rows: [&StateRow; 4]| {
            right.row_mut(k).iter_mut().zip(row_of(rows)).for_each(|(sum, x)| *sum -= factor * x);
        };
        for (body, arm, darm) in terms {
            let BodyRows { s, v, weights, drift } = &system.bodies[body];
            subtract(darm, [s, v, drift, weights]);
            match dependent.iter().position(|&i| i == body) {
                Some(place) => left[(k, place)] += arm,
                None => {
                    let BodyTangent { s, v, weights, drift } = &all[body];
                    subtract(arm, [s, v, drift, weights]);
                }
            }
        }
    }
    // Each link, and each node's row, determines one of these bodies: the matrix is square and
    // regular.
    let Some(found) = left.lu().solve(&right) else { return };
    for (place, &body) in dependent.iter().enumerate() {
        let row = found.row(place).transpose();
        let own = &mut all[body];
        own.s.copy_from(&row.rows(0, size));
        own.v.copy_from(&row.rows(size, size));
        own.drift.copy_from(&row.rows(2 * size, size));
        own.weights.copy_from(&row.rows(3 * size, system.coordinates));
    }
}
