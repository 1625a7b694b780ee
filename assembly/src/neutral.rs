//! Neutral directions: changes of the coordinates on which no force depends, such as the angle of a
//! free shaft or the position of a train (docs/assembly-law.md (A30)).
//!
//! A direction u of the coordinates is neutral if no elongation that determines a force changes
//! along it: w · u = 0 for every spring with stiffness and every stop. If no dashpot and no
//! friction acts along u either, only loads change the momentum along u, and the direction u of
//! the velocities is neutral, too. A motion from a state shifted along neutral directions is the
//! original motion, shifted by a known amount: these directions have the exponent 0, and no return
//! depends on them.

use crate::description::Description;
use crate::system::System;
use nalgebra::DVector;

/// Largest entry of a unit row that counts as zero: arms and links are given to more digits.
const ZERO: f64 = 1e-10;

/// The neutral directions of a machine.
#[derive(Clone, Debug, PartialEq)]
pub struct Neutral {
    /// Number of coordinates.
    coordinates: usize,
    /// By state of first order the direction w of the elongation with which it moves.
    inner: Vec<DVector<f64>>,
    /// Directions of the coordinates, a sparse basis found by elimination.
    places: Vec<DVector<f64>>,
    /// Directions of the velocities.
    rates: Vec<DVector<f64>>,
}

/// The rows of G v, on which gyroscopic forces depend.
fn gyroscopic(system: &System) -> Vec<DVector<f64>> {
    let n = system.coordinates;
    let rows = system.gyroscopic_forces().map(|(_, force)| force.rows(n, n).into_owned());
    rows.filter(|row| row.amax() > 0.0).collect()
}

/// The rows of coordinates, or of velocities from `first` on, that blocks read.
fn read(system: &System, first: usize) -> Vec<DVector<f64>> {
    let inputs = system.blocks.iter().flat_map(|block| &block.inputs);
    let rows = inputs.map(|input| input.row.rows(first, system.coordinates).into_owned());
    rows.filter(|row| row.amax() > 0.0).collect()
}

impl Neutral {
    /// The directions of a machine.
    pub fn of(system: &System) -> Self {
        let springs = |acts: &dyn Fn(&crate::system::SpringRows) -> bool| {
            let all = system.springs.iter().filter(|s| acts(s));
            all.map(|s| s.elongation.w.clone()).collect::<Vec<_>>()
        };
        let mut rows = springs(&|s| s.stiffness != 0.0);
        rows.extend(system.stops[..system.first_freewheel].iter().map(|s| s.elongation.w.clone()));
        rows.extend(read(system, 0));
        let places = null_space(rows.clone(), system.coordinates);
        rows.extend(springs(&|s| s.damping != 0.0));
        rows.extend(gyroscopic(system));
        rows.extend(read(system, system.coordinates));
        rows.extend(system.stops[system.freewheels()].iter().map(|s| s.elongation.w.clone()));
        rows.extend(system.frictions.iter().map(|f| f.elongation.w.clone()));
        rows.extend(system.branches.iter().map(|b| b.elongation.w.clone()));
        let rates = null_space(rows, system.coordinates);
        let inner = system.branches.iter().map(|own| own.elongation.w.clone()).collect();
        Self { coordinates: system.coordinates, inner, places, rates }
    }

    /// Directions of the coordinates q on which no force depends, each of length N.
    pub fn places(&self) -> &[DVector<f64>] {
        &self.places
    }

    /// Directions of the velocities q' on which no force depends, each in the span of
    /// [`places`](Self::places).
    pub fn rates(&self) -> &[DVector<f64>] {
        &self.rates
    }

    /// All directions as changes of the state (q, q', states of first order).
    pub fn states(&self) -> Vec<Vec<f64>> {
        let n = self.coordinates;
        let all = self.places.iter().map(|u| (u, 0)).chain(self.rates.iter().map(|u| (u, n)));
        all.map(|(u, first)| {
            let mut state = vec![0.0; 2 * n];
            state[first..first + n].copy_from_slice(u.as_slice());
            // An inner place goes with the elongation, so that the force stays.
            state.extend(self.inner.iter().map(|w| if first == 0 { w.dot(u) } else { 0.0 }));
            state
        })
        .collect()
    }

    /// The directions in words by bodies, such as `no force depends on rotor.s`.
    pub fn in_words(&self, d: &Description, system: &System) -> Vec<String> {
        let along = |u: &DVector<f64>, letter: &str| {
            let moved = |row: &DVector<f64>| row.iter().zip(u.iter()).map(|(r, u)| r * u).sum::<f64>();
            let shares = system.bodies.iter().map(|body| moved(&body.s));
            let shares: Vec<(usize, f64)> = shares.enumerate().filter(|s| s.1.abs() > ZERO).collect();
            let names: Vec<String> =
                shares.iter().map(|(i, _)| format!("{}.{letter}", d.bodies[*i].name)).collect();
            let numbers: Vec<String> = shares.iter().map(|(_, x)| short(*x / shares[0].1)).collect();
            match &names[..] {
                [one] => one.clone(),
                _ => format!("{} together, as {}", names.join(", "), numbers.join(" : ")),
            }
        };
        let place = |u| format!("no force depends on {}", along(u, "s"));
        let rate = |u| format!("nor on {}: its momentum changes by loads alone", along(u, "v"));
        self.places.iter().map(place).chain(self.rates.iter().map(rate)).collect()
    }
}

/// A ratio rounded to six decimals, unless that gives 0.
fn short(x: f64) -> String {
    let rounded = (x * 1e6).round() / 1e6;
    format!("{}", if rounded == 0.0 { x } else { rounded })
}

/// A basis of the directions u with w · u = 0 for all rows w, by elimination with the largest
/// pivots, so that a body on which nothing acts is a basis vector of its own.
fn null_space(rows: Vec<DVector<f64>>, count: usize) -> Vec<DVector<f64>> {
    let mut pivots: Vec<(usize, DVector<f64>)> = Vec::new();
    for mut row in rows {
        let size = row.amax();
        if size == 0.0 {
            continue;
        }
        row /= size;
        for (pivot, other) in &pivots {
            let share = row[*pivot];
            row.axpy(-share, other, 1.0);
        }
        let pivot = row.iamax();
        if row[pivot].abs() <= ZERO {
            continue;
        }
        row /= row[pivot];
        for (_, other) in &mut pivots {
            let share = other[pivot];
            other.axpy(-share, &row, 1.0);
        }
        pivots.push((pivot, row));
    }
    let free = (0..count).filter(|place| pivots.iter().all(|(pivot, _)| pivot != place));
    free.map(|place| {
        let mut direction = DVector::zeros(count);
        direction[place] = 1.0;
        for (pivot, row) in &pivots {
            if row[place].abs() > ZERO {
                direction[*pivot] = -row[place];
            }
        }
        direction
    })
    .collect()
}
