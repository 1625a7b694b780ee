//! The impacts of one instant as linear maps of variations of the state (docs/assembly-law.md
//! (A36)).

use super::{Event, EventKind};
use crate::system::System;
use nalgebra::{DMatrix, DVector};

/// Singular values of the compliance matrix of stops hit together count as zero below this
/// multiple of its largest entry: the box problem of (A7) leaves out contacts whose columns depend
/// on other columns.
const SINGULAR: f64 = 1e-12;

/// One impact: the stops with an impulse P, for which G P = (1 + ε) u.
pub(crate) struct Impulse {
    pub stops: Vec<usize>,
    /// Restitution of each stop; 0 if the stop closes.
    pub restitution: Vec<f64>,
    /// Whether each stop has no further bounce.
    pub closes: Vec<bool>,
    /// Impulse P of each stop.
    pub impulses: DVector<f64>,
    /// The inverse of G; the pseudo-inverse if several stops are hit.
    pub inverse: DMatrix<f64>,
    /// States before and after the impact.
    pub states: [DVector<f64>; 2],
}

impl Impulse {
    /// Returns the reported impacts in their order; `z` is the state before the first impact.
    pub fn all(system: &System, events: &[Event], z: &DVector<f64>) -> Vec<Self> {
        let hit = events.iter().filter_map(|event| match event.kind {
            EventKind::Impact { stop, impulse, stops, .. } => Some((stop, impulse, stops)),
            _ => None,
        });
        let (mut hit, mut all) = (hit.peekable(), Vec::<Self>::new());
        while let Some(&(_, _, count)) = hit.peek() {
            let group: Vec<_> = hit.by_ref().take(count.max(1)).collect();
            let before = all.last().map_or(z, |last| &last.states[1]);
            let impact = Self::new(system, events, &group, before);
            all.push(impact);
        }
        all
    }

    /// Splits impacts of uncoupled stops into impacts of single stops.
    pub(crate) fn one_by_one(system: &System, events: &[Event], all: &[Self]) -> Vec<Self> {
        let mut singles: Vec<Self> = Vec::new();
        for impulse in all {
            for (&stop, &p) in impulse.stops.iter().zip(impulse.impulses.iter()) {
                let z = singles.last().map_or(&impulse.states[0], |last| &last.states[1]);
                singles.push(Self::new(system, events, &[(stop, p, 1)], z));
            }
        }
        singles
    }

    fn new(system: &System, events: &[Event], group: &[(usize, f64, usize)], z: &DVector<f64>) -> Self {
        let stops: Vec<usize> = group.iter().map(|hit| hit.0).collect();
        let closes = |stop: usize| events.iter().any(|e| e.kind == EventKind::Close { stop });
        // An impact with a freewheel is plastic.
        let catches = stops.iter().any(|&stop| system.stops[stop].is_freewheel);
        let closes: Vec<bool> = stops.iter().map(|&stop| catches || closes(stop)).collect();
        let own = |(&stop, closes): (&usize, &bool)| {
            system.stops[stop].restitution().filter(|_| !closes).unwrap_or(0.0)
        };
        let restitution = stops.iter().zip(&closes).map(own).collect();
        let rows = |i: usize| &system.stops[stops[i]].elongation;
        let count = stops.len();
        let mut g = DMatrix::from_fn(count, count, |i, j| rows(i).w.dot(&rows(j).mobility));
        let inverse = if count == 1 && g[(0, 0)] > 0.0 {
            g[(0, 0)] = 1.0 / g[(0, 0)];
            Some(g)
        } else {
            let limit = (SINGULAR * g.amax()).max(f64::MIN_POSITIVE);
            g.pseudo_inverse(limit).ok().filter(|inverse| inverse.shape() == (count, count))
        };
        let impulses = DVector::from_iterator(group.len(), group.iter().map(|hit| hit.1));
        let mut after = z.clone();
        for (k, p) in impulses.iter().enumerate() {
            change_rates(system, &mut after, -p, &rows(k).mobility);
        }
        Self {
            stops,
            restitution,
            closes,
            impulses,
            inverse: inverse.unwrap_or_else(|| DMatrix::zeros(count, count)),
            states: [z.clone(), after],
        }
    }

    /// Carries a variation of the state over the impact.
    pub fn carry_state(&self, system: &System, variation: &mut [f64]) {
        let rows = |k: usize| &system.stops[self.stops[k]].elongation;
        let demand = |k: usize, _| (1.0 + self.restitution[k]) * rows(k).rate.at(variation);
        let impulses = &self.inverse * DVector::from_fn(self.stops.len(), demand);
        for (k, p) in impulses.iter().enumerate() {
            let rates = variation[system.coordinates..].iter_mut();
            rates.zip(rows(k).mobility.iter()).for_each(|(v, m)| *v -= p * m);
        }
    }
}

/// Adds `factor` × `change` to the rates of the coordinates.
fn change_rates(system: &System, z: &mut DVector<f64>, factor: f64, change: &DVector<f64>) {
    z.rows_mut(system.coordinates, system.coordinates).axpy(factor, change, 1.0);
}
