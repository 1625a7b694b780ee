//! The system of a mode without held contacts as what always acts and a term for each force that
//! acts in the mode: A = base - Σ by ⊗ force. Nothing dense is made when such a mode is met.

use super::{Functional, StateRow, System};
use crate::flow::WatchTable;
use crate::kernel::{Sparse, SparseMatrix};
use crate::mode::{FrictionState, Mode, StopState, Watch};
use std::sync::Arc;

/// The part of the rate that signals may add to it in the norm of (A6).
const SHARE: f64 = 0.1;

/// A force with what a unit of it takes from z'.
#[derive(Clone, Debug)]
pub struct Term {
    /// The force.
    pub force: Arc<Functional>,
    /// M⁻¹ w in the places of the velocities.
    pub by: Arc<Sparse>,
    /// Sums of the force's entries on coordinates and on velocities, times the scales of these.
    reach: [f64; 2],
}

/// What is known of the modes without held contacts before any is met.
#[derive(Clone, Debug)]
pub struct Split {
    /// A where nothing is pressed or slips, but for stiff springs.
    pub base: Arc<SparseMatrix>,
    /// Stiff springs.
    stiff: Vec<Term>,
    /// By stop, pressed and at its cap.
    stops: Vec<[Term; 2]>,
    /// By friction, slipping upwards and downwards.
    frictions: Vec<[Term; 2]>,
    /// By stop and state what is watched.
    watched_stops: Vec<[Vec<Known>; 6]>,
    /// By friction what is watched where it is off, and where it slips upwards and downwards.
    watched_frictions: Vec<[Vec<Known>; 3]>,
    norm: Norm,
}

/// A watched functional; with entries on velocities its slope depends on the mode.
type Known = (Arc<WatchTable>, bool);

/// The norm of (A6) for these modes: weights d of coordinates and Ω d of velocities, where d² are
/// the entries of M⁻¹ on its diagonal, with which stiffness is symmetric.
#[derive(Clone, Debug)]
struct Norm {
    scales: Vec<f64>,
    /// By coordinate Σ|A| d/d of base, on coordinates and on velocities.
    rows: Vec<[f64; 2]>,
    /// By signal the largest weight beside which no velocity's rate feels it by more than one.
    signals: Vec<f64>,
    /// The rate of the signals among themselves.
    rate: f64,
}

/// The places of the states in [`Split::watched_stops`].
const STATES: [StopState; 6] = [
    StopState::Open,
    StopState::Closed,
    StopState::Below,
    StopState::Pressed,
    StopState::Free,
    StopState::Capped,
];

fn place_of(state: StopState) -> usize {
    STATES.iter().position(|own| *own == state).unwrap_or_default()
}

impl Split {
    pub(super) fn new(system: &System) -> Self {
        let n = system.coordinates;
        let base = Arc::new(system.base());
        let scales: Vec<f64> = (0..n)
            .map(|k| {
                let mut unit = nalgebra::DVector::zeros(n);
                unit[k] = 1.0;
                system.inertia.solve(&unit)[k].sqrt()
            })
            .collect();
        let term = |force: StateRow, e: &super::Elongation| {
            let places = e.mobility.iter().enumerate().map(|(k, x)| (n + k, *x));
            let size_of = |first: usize| {
                force.iter().skip(first).zip(&scales).map(|(x, scale)| x.abs() * scale).sum::<f64>()
            };
            let reach = [size_of(0), size_of(n)];
            Term { reach, force: Arc::new(Functional::of(force)), by: Arc::new(Sparse::from_terms(places)) }
        };
        let stiff = system.stiff_springs.iter().map(|&i| &system.springs[i]);
        let stiff: Vec<Term> = stiff.map(|s| term(s.force.clone(), &s.elongation)).collect();
        let of_stop = |i: usize| {
            [StopState::Pressed, StopState::Capped].map(|state| {
                let force =
                    system.stop_force(i, state).unwrap_or_else(|| StateRow::zeros(system.signals.size));
                term(force, &system.stops[i].elongation)
            })
        };
        let stops: Vec<[Term; 2]> = (0..system.stops.len()).map(of_stop).collect();
        let of_friction = |i: usize| {
            let friction = &system.frictions[i];
            [1.0, -1.0].map(|sign| term(sign * &friction.level, &friction.elongation))
        };
        let frictions: Vec<[Term; 2]> = (0..system.frictions.len()).map(of_friction).collect();
        let known = |rows: Vec<(Watch, StateRow)>| -> Vec<Known> {
            let rows = rows.into_iter().filter(|(_, row)| !system.is_constant_and_negative(row));
            rows.map(|(watch, row)| {
                let depends = row.rows(n, n).iter().any(|x| *x != 0.0);
                (Arc::new(WatchTable::new(watch, row, &base)), depends)
            })
            .collect()
        };
        let watched_stops = (0..system.stops.len())
            .map(|i| STATES.map(|state| known(system.watched_of_stop(i, state))))
            .collect();
        let slips = [FrictionState::Off, FrictionState::Up, FrictionState::Down];
        let watched_frictions = (0..system.frictions.len())
            .map(|i| slips.map(|state| known(system.watched_of_friction(i, state))))
            .collect();
        let norm = Norm::new(system, &base, scales, [&stiff, stops.as_flattened(), frictions.as_flattened()]);
        Self { base, stiff, stops, frictions, watched_stops, watched_frictions, norm }
    }

    /// The forces that act in a mode beside base.
    pub fn terms(&self, mode: &Mode) -> Vec<Term> {
        let mut terms = self.stiff.clone();
        for (own, state) in self.stops.iter().zip(&mode.stops) {
            match state {
                StopState::Pressed => terms.push(own[0].clone()),
                StopState::Capped => terms.push(own[1].clone()),
                _ => {}
            }
        }
        for (own, state) in self.frictions.iter().zip(&mode.frictions) {
            match state {
                FrictionState::Up => terms.push(own[0].clone()),
                FrictionState::Down => terms.push(own[1].clone()),
                _ => {}
            }
        }
        terms
    }

    /// What ends a mode with this A.
    pub fn watched(&self, mode: &Mode, a: &SparseMatrix) -> Vec<Arc<WatchTable>> {
        let mut watched = Vec::new();
        let mut put = |known: &[Known]| {
            for (table, depends) in known {
                let own = if *depends { Arc::new(table.in_mode(a)) } else { table.clone() };
                watched.push(own);
            }
        };
        for (own, state) in self.watched_stops.iter().zip(&mode.stops) {
            put(&own[place_of(*state)]);
        }
        for (own, state) in self.watched_frictions.iter().zip(&mode.frictions) {
            match state {
                FrictionState::Off => put(&own[0]),
                FrictionState::Up => put(&own[1]),
                _ => put(&own[2]),
            }
        }
        watched
    }

    /// A bound of the norm of A with these terms beside base, and by coordinate 1/w (A6).
    pub fn norm(&self, terms: &[Term], one: usize) -> (f64, Vec<f64>) {
        let Norm { scales, rows, signals, rate } = &self.norm;
        let (mut rows, n) = (rows.clone(), scales.len());
        for term in terms {
            for &(place, x) in term.by.terms() {
                let share = x.abs() / scales[place - n];
                let row = &mut rows[place - n];
                (row[0], row[1]) = (row[0] + share * term.reach[0], row[1] + share * term.reach[1]);
            }
        }
        // Ω = κ/Ω + γ + SHARE Ω of each row, and the largest Ω of all.
        let of_row =
            |[k, c]: &[f64; 2]| (c + (c * c + 4.0 * (1.0 - SHARE) * k).sqrt()) / (2.0 * (1.0 - SHARE));
        let rate = rows.iter().map(of_row).fold(rate.max(crate::flow::LEAST_RATE), f64::max);
        let mut weights = Vec::with_capacity(one + signals.len());
        weights.extend(scales.iter().map(|d| 1.0 / d));
        weights.extend(scales.iter().map(|d| 1.0 / (rate * d)));
        let unit = SHARE * rate * rate / signals.len() as f64;
        weights.extend(signals.iter().map(|g| 1.0 / (unit * g)));
        (rate, weights)
    }
}

impl Norm {
    fn new(system: &System, base: &SparseMatrix, scales: Vec<f64>, terms: [&[Term]; 3]) -> Self {
        let (n, one, size) = (system.coordinates, system.signals.one, system.signals.size);
        let mut rows = vec![[0.0; 2]; n];
        let mut signals = vec![f64::INFINITY; size - one];
        // By row the sizes that signals may add to it in any mode.
        let mut added = vec![0.0; size - one];
        let mut by_row: Vec<Vec<(&Term, f64)>> = vec![Vec::new(); n];
        for term in terms.into_iter().flatten() {
            term.by.terms().iter().for_each(|&(place, x)| by_row[place - n].push((term, x)));
        }
        for (k, row) in rows.iter_mut().enumerate() {
            added.fill(0.0);
            for &(j, x) in base.row(n + k) {
                match j {
                    _ if j < n => row[0] += x.abs() * scales[j] / scales[k],
                    _ if j < one => row[1] += x.abs() * scales[j - n] / scales[k],
                    _ => added[j - one] += x.abs(),
                }
            }
            for (term, x) in &by_row[k] {
                let own = term.force.terms().iter().filter(|(j, _)| *j >= one);
                own.for_each(|&(j, f)| added[j - one] += (x * f).abs());
            }
            for (most, x) in signals.iter_mut().zip(&added).filter(|(_, x)| **x > 0.0) {
                *most = most.min(scales[k] / x);
            }
        }
        let lowest = rows.iter().map(|row| row[0].sqrt()).fold(crate::flow::LEAST_RATE, f64::max);
        for i in one..size {
            for &(j, x) in base.row(i).iter().filter(|(j, _)| *j >= one && *j != i) {
                let (i, j) = (i - one, j - one);
                if base.entry(j + one, i + one) != 0.0 {
                    let least = signals[i].min(signals[j]);
                    (signals[i], signals[j]) = (least, least);
                } else {
                    signals[j] = signals[j].min(lowest * signals[i] / x.abs());
                }
            }
        }
        signals.iter_mut().filter(|g| !g.is_finite()).for_each(|g| *g = 1.0);
        let of_row = |i: usize| {
            let terms = base.row(i).iter().filter(|(j, _)| *j >= one);
            terms.map(|&(j, x)| x.abs() * signals[j - one] / signals[i - one]).sum::<f64>()
        };
        let rate = (one..size).map(of_row).fold(0.0, f64::max);
        Self { scales, rows, signals, rate }
    }
}
