//! The choice of minimal coordinates: links and nodes determine the other coordinates
//! (docs/assembly-law.md (A1)).

use crate::description::{BodyKind, Description};
use crate::error::Error;
use crate::kernel::Sparse;
use nalgebra::DVector;

/// A link is redundant if, after elimination, its largest arm on a free coordinate is below this
/// fraction of its largest original arm.
const NO_PIVOT: f64 = 1e-12;

/// All bodies' coordinates in terms of q and of the prescribed bodies' coordinates.
pub struct Reduction {
    /// The bodies whose coordinates are q.
    pub kept: Vec<usize>,
    /// Weights of q for each body.
    pub q: Vec<Sparse>,
    /// Weights of the prescribed bodies' coordinates for each body.
    pub prescribed: Vec<Sparse>,
}

/// Eliminates one coordinate for each link: the one with the largest remaining arm, so that no arm
/// is divided by a small arm.
pub fn reduce(d: &Description) -> Result<Reduction, Error> {
    let count = d.bodies.len();
    let free: Vec<bool> = d.bodies.iter().map(|b| matches!(b.kind, BodyKind::Free(_))).collect();
    // A node follows from its row; links do not eliminate it.
    let mut equations: Vec<(usize, DVector<f64>)> = nodes(d).collect();
    let follows: Vec<bool> = d.bodies.iter().map(|b| !b.kind.is_prescribed()).collect();
    for link in &d.links {
        let mut row: DVector<f64> = DVector::zeros(count);
        link.arms.terms.iter().for_each(|&(body, arm)| row[body] += arm);
        let largest = row.amax();
        for (pivot, other) in &equations {
            let share = row[*pivot];
            row.axpy(-share, other, 1.0);
            row[*pivot] = 0.0;
        }
        let pivot = (0..count).filter(|&i| free[i]).max_by(|&a, &b| row[a].abs().total_cmp(&row[b].abs()));
        let Some(pivot) = pivot.filter(|&p| row[p].abs() > NO_PIVOT * largest) else {
            return Err(Error::Redundant { link: link.name.clone() });
        };
        row /= row[pivot];
        row[pivot] = 1.0;
        for (_, other) in &mut equations {
            let share = other[pivot];
            other.axpy(-share, &row, 1.0);
            other[pivot] = 0.0;
        }
        equations.push((pivot, row));
    }
    let mut dependent: Vec<Option<&DVector<f64>>> = vec![None; count];
    equations.iter().for_each(|(pivot, row)| dependent[*pivot] = Some(row));
    let kept: Vec<usize> = (0..count).filter(|&i| free[i] && dependent[i].is_none()).collect();
    let mut place = vec![None; count];
    kept.iter().enumerate().for_each(|(k, &i)| place[i] = Some(k));
    let (mut q, mut prescribed) = (Vec::with_capacity(count), Vec::with_capacity(count));
    for i in 0..count {
        let (mut own, mut others) = (Vec::new(), Vec::new());
        if !follows[i] {
            others.push((i, 1.0));
        } else if let Some(row) = dependent[i] {
            for j in (0..count).filter(|&j| j != i && row[j] != 0.0) {
                match place[j] {
                    Some(k) => own.push((k, -row[j])),
                    None => others.push((j, -row[j])),
                }
            }
        } else if let Some(k) = place[i] {
            own.push((k, 1.0));
        }
        q.push(Sparse::from_terms(own.into_iter()));
        prescribed.push(Sparse::from_terms(others.into_iter()));
    }
    Ok(Reduction { kept, q, prescribed })
}

/// The equation s - row · q = 0 of each node, with its index as pivot.
fn nodes(d: &Description) -> impl Iterator<Item = (usize, DVector<f64>)> {
    d.bodies.iter().enumerate().filter_map(|(i, body)| {
        let BodyKind::Node(terms) = &body.kind else { return None };
        let mut row = DVector::zeros(d.bodies.len());
        row[i] = 1.0;
        terms.iter().for_each(|&(body, factor)| row[body] -= factor);
        Some((i, row))
    })
}
