//! The matrix of a mode without held contacts, as a constant part and one term for each force that
//! acts in the mode: A = base - Σ by ⊗ force. No dense matrix is made when such a mode is met.

use super::System;
use crate::functional::Functional;
use crate::kernel::{Sparse, SparseMatrix};
use crate::mode::{FrictionState, Mode, SliderState, StopState, Watch, WatchTable};
use crate::norm::{LEAST_RATE, swept};
use std::sync::Arc;

/// The fraction of the rate that signals may add to it in the norm of (A6).
const SHARE: f64 = 0.1;

/// A force, and the decrease of z' per unit of it.
#[derive(Clone, Debug)]
pub struct Term {
    /// The force.
    pub force: Arc<Functional>,
    /// The vector M⁻¹ w at the indices of the velocities.
    pub by: Arc<Sparse>,
}

/// Data of the modes without held contacts, prepared before any mode is met.
#[derive(Clone, Debug)]
pub struct Split {
    /// Matrix A if nothing is pressed or slips, without stiff springs and springs with sliders.
    pub base: Arc<SparseMatrix>,
    /// Stiff springs.
    stiff: Vec<Term>,
    /// Forces of each stop, pressed, and at its cap or rebounding.
    stops: Vec<[Term; 2]>,
    /// Forces of each friction and each of its levels, in the states of [`LEVELS`].
    frictions: Vec<Vec<[Term; 4]>>,
    /// The stop that each friction follows, with the states that give it levels.
    follows: Vec<Option<Vec<(usize, StopState)>>>,
    /// Event functions of each stop, by state.
    watched_stops: Vec<[Vec<Known>; STATES.len()]>,
    /// Event functions of each friction and each of its levels if it is off, slips upwards or
    /// downwards, or sticks.
    watched_frictions: Vec<Vec<[Vec<Known>; 4]>>,
    /// Terms of each branch with a slider, in the states of [`SLIDERS`]: the force and the rate of
    /// the stretch, if it varies.
    sliders: Vec<(usize, [Vec<Term>; SLIDERS.len()])>,
    /// Event functions of each branch, in the states of [`SLIDERS`].
    watched_sliders: Vec<[Vec<Known>; SLIDERS.len()]>,
    /// For each stop that is a limit of an output: the term of A while it is passed.
    limits: Vec<Option<Term>>,
    norm: Norm,
}

/// An event function, and whether its slope depends on the mode, because it has entries on
/// velocities or on states of first order.
pub type Known = (Arc<WatchTable>, bool);

/// The norm of (A6) of a machine's modes: weights d of coordinates and Ω d of velocities. d² are
/// the diagonal entries of M⁻¹, for which stiffness is symmetric.
#[derive(Clone, Debug)]
struct Norm {
    scales: Vec<f64>,
    /// Weights of the states of first order.
    inner: Vec<f64>,
    /// Weight limit of each signal: it changes no velocity's rate by more than one.
    signals: Vec<f64>,
    /// The rate of the signals among themselves.
    rate: f64,
}

/// States of a friction whose force is its level, in the order of [`Split::frictions`].
const LEVELS: [FrictionState; 4] =
    [FrictionState::Up, FrictionState::Down, FrictionState::HeldUp, FrictionState::HeldDown];

/// The order of the states in [`Split::sliders`] and [`Split::watched_sliders`].
const SLIDERS: [SliderState; 4] = [SliderState::Held, SliderState::Up, SliderState::Down, SliderState::Off];

fn place_of_slider(state: SliderState) -> usize {
    SLIDERS.iter().position(|own| *own == state).unwrap_or_default()
}

/// The order of the states in [`Split::watched_stops`].
const STATES: [StopState; 8] = [
    StopState::Open,
    StopState::Closed,
    StopState::Below,
    StopState::Pressed,
    StopState::Free,
    StopState::Capped,
    StopState::Rebounding,
    StopState::Off,
];

fn place_of(state: StopState) -> usize {
    STATES.iter().position(|own| *own == state).unwrap_or_default()
}

impl Split {
    pub(super) fn new(system: &System) -> Self {
        let n = system.coordinates;
        let base = Arc::new(system.base().with_slices(n));
        let scales: Vec<f64> = (0..n).map(|k| system.inertia.compliance(k).sqrt()).collect();
        let term = |force: Functional, e: &super::Elongation| {
            let places = e.mobility.terms().iter().map(|&(k, x)| (n + k, x));
            Term { force: Arc::new(force), by: Arc::new(Sparse::from_terms(places)) }
        };
        let stiff = system.stiff_springs.iter().map(|&i| &system.springs[i]);
        let stiff: Vec<Term> = stiff.map(|s| term(s.force.clone(), &s.elongation)).collect();
        let of_limit = |i: usize| {
            let (force, e) = (&system.stops[i].force, &system.stops[i].elongation);
            let places = e.mobility.terms().iter().map(|&(k, x)| (n + k, x));
            let places = places.chain(system.stops[i].further.iter().copied());
            Term { force: Arc::new(force.clone()), by: Arc::new(Sparse::from_terms(places)) }
        };
        let limits = (0..system.stops.len()).map(|i| system.is_limit(i).then(|| of_limit(i)));
        let limits: Vec<Option<Term>> = limits.collect();
        let of_stop = |i: usize| {
            let other = if system.stops[i].turns() { StopState::Rebounding } else { StopState::Capped };
            [StopState::Pressed, other].map(|state| {
                let force =
                    system.stop_force(i, state).unwrap_or_else(|| Functional::zeros(system.signals.size));
                term(force, &system.stops[i].elongation)
            })
        };
        let stops: Vec<[Term; 2]> = (0..system.stops.len()).map(of_stop).collect();
        let of_friction = |i: usize| {
            let friction = &system.frictions[i];
            let levels = friction.levels.iter();
            let of_level = |own: &super::LevelRows| {
                LEVELS.map(|state: FrictionState| {
                    let force = state.force(&own.level, &own.static_level);
                    let force = force.unwrap_or_else(|| Functional::zeros(system.signals.size));
                    term(force, &friction.elongation)
                })
            };
            levels.map(of_level).collect()
        };
        let frictions: Vec<Vec<[Term; 4]>> = (0..system.frictions.len()).map(of_friction).collect();
        let known = |rows: Vec<(Watch, Functional)>| -> Vec<Known> {
            let rows = rows.into_iter().map(|(watch, row)| (watch, AsRef::<Sparse>::as_ref(&row).clone()));
            let rows = rows.filter(|(_, row)| !system.is_constant_and_negative(row));
            rows.map(|(watch, row)| {
                let depends = row.terms().iter().any(|(j, _)| (n..system.states()).contains(j));
                (Arc::new(WatchTable::new(watch, Arc::new(row), &base)), depends)
            })
            .collect()
        };
        let watched_stops = (0..system.stops.len())
            .map(|i| STATES.map(|state| known(system.watched_of_stop(i, state))))
            .collect();
        let states = [FrictionState::Off, FrictionState::Up, FrictionState::Down, FrictionState::Stuck];
        let watched_frictions = (0..system.frictions.len())
            .map(|i| {
                let levels = 0..system.frictions[i].levels.len();
                let of = |place| states.map(|state| known(system.watched_of_friction(i, Some(place), state)));
                levels.map(of).collect()
            })
            .collect();
        let follows = system.frictions.iter().map(|own| own.follows.clone()).collect();
        let of_slider = |i: usize| {
            let branch = &system.branches[i];
            let stretches = Sparse::from_terms(std::iter::once((branch.place, -1.0)));
            let by = Arc::new(stretches);
            let of_state = |state: SliderState| {
                let rate = match (state, &branch.sliding) {
                    (SliderState::Held, _) => Some(branch.rate.clone()),
                    _ if branch.slaved.is_some() => branch.slaved.as_ref().map(|own| own[1].clone()),
                    (SliderState::Up | SliderState::Down, Some(row)) => Some(state.direction() * row),
                    _ => None,
                };
                let rate = rate.map(|force| Term { force: Arc::new(force), by: by.clone() });
                let force = term(system.branch_force(i, state), &branch.elongation);
                let acts = state != SliderState::Off;
                acts.then_some(force).into_iter().chain(rate).collect()
            };
            (i, SLIDERS.map(of_state))
        };
        let sliders: Vec<(usize, [Vec<Term>; SLIDERS.len()])> = system.sliders().map(of_slider).collect();
        let levels = frictions.iter().flatten().flatten();
        let levels = levels.chain(sliders.iter().flat_map(|own| own.1.iter().flatten()));
        let levels: Vec<Term> = levels.cloned().collect();
        let watched_sliders = (0..system.branches.len())
            .map(|i| SLIDERS.map(|state| known(system.watched_of_slider(i, state))))
            .collect();
        let norm = Norm::new(system, &base, scales, [&stiff, stops.as_flattened(), &levels]);
        Self {
            base,
            stiff,
            stops,
            frictions,
            follows,
            watched_stops,
            watched_frictions,
            sliders,
            watched_sliders,
            limits,
            norm,
        }
    }

    /// Returns the elastic forces of a mode: first of stiff springs, then of stops.
    pub fn elastic(&self, mode: &Mode) -> Vec<Term> {
        let stops = self.stops.iter().zip(&mode.stops).zip(&self.limits).filter(|own| own.1.is_none());
        let stops = stops.filter_map(|((own, state), _)| match state {
            StopState::Pressed => Some(&own[0]),
            StopState::Capped | StopState::Rebounding => Some(&own[1]),
            _ => None,
        });
        self.stiff.iter().chain(stops).cloned().collect()
    }

    /// Returns the forces of frictions that their state determines, the forces of sliders, the
    /// rates of stretches of held sliders, and the terms of passed limits of outputs.
    pub fn frictional(&self, mode: &Mode) -> Vec<Term> {
        let frictions = self.frictions.iter().zip(&mode.frictions).enumerate();
        let place = |state: &FrictionState| LEVELS.iter().position(|own| own == state);
        let acting = |(i, (own, state)): (usize, (&Vec<[Term; 4]>, &FrictionState))| {
            Some(own[self.levels_of(i, mode)?][place(state)?].clone())
        };
        let sliders = self.sliders.iter().flat_map(|(i, own)| &own[place_of_slider(mode.sliders[*i])]);
        let limits = self.limits.iter().zip(&mode.stops).filter(|own| *own.1 == StopState::Pressed);
        let limits = limits.filter_map(|own| own.0.clone());
        frictions.filter_map(acting).chain(sliders.cloned()).chain(limits).collect()
    }

    /// Returns the index of a friction's levels in a mode.
    fn levels_of(&self, i: usize, mode: &Mode) -> Option<usize> {
        match &self.follows[i] {
            None => Some(0),
            Some(all) => all.iter().position(|(stop, state)| *state == mode.stops[*stop]),
        }
    }

    /// Returns A with these forces in addition to base.
    pub fn with<'t>(&self, terms: impl Iterator<Item = &'t Term>) -> SparseMatrix {
        self.base.less(terms.map(|term| [term.by.terms(), term.force.terms()]))
    }

    /// Returns the event functions of a mode, except for the forces of held contacts.
    pub fn watched(&self, mode: &Mode) -> impl Iterator<Item = &Known> {
        let stops = self.watched_stops.iter().zip(&mode.stops).map(|(own, state)| &own[place_of(*state)]);
        let frictions = self.watched_frictions.iter().zip(&mode.frictions).enumerate();
        let frictions = frictions.filter_map(|(i, (own, state))| {
            let own = &own[self.levels_of(i, mode)?];
            Some(match state {
                FrictionState::Off => &own[0],
                FrictionState::Up => &own[1],
                FrictionState::Down => &own[2],
                FrictionState::Stuck | FrictionState::HeldUp | FrictionState::HeldDown => &own[3],
            })
        });
        let sliders = self.watched_sliders.iter().zip(&mode.sliders);
        let sliders = sliders.map(|(own, state)| &own[place_of_slider(*state)]);
        stops.chain(frictions).chain(sliders).flatten()
    }

    /// Returns a bound of the norm of a mode's A, and 1/w for each coordinate (A6).
    pub fn norm(&self, a: &SparseMatrix) -> (f64, Vec<f64>) {
        let Norm { scales, inner, signals, rate } = &self.norm;
        let (n, first, one) = (scales.len(), 2 * scales.len(), 2 * scales.len() + inner.len());
        // Solve Ω = κ/Ω + γ + SHARE Ω for each row, and take the largest Ω.
        let of_row = |k: f64, c: f64| (c + (c * c + 4.0 * (1.0 - SHARE) * k).sqrt()) / (2.0 * (1.0 - SHARE));
        let (mut rate, mut excess) = (rate.max(LEAST_RATE), 1.0f64);
        for (k, scale) in scales.iter().enumerate() {
            let (mut stiffness, mut damping) = (0.0, 0.0);
            for &(j, x) in a.row(n + k) {
                match j {
                    _ if j < n => stiffness += x.abs() * scales[j] / scale,
                    _ if j < first => damping += x.abs() * scales[j - n] / scale,
                    _ if j < one => stiffness += x.abs() * inner[j - first] / scale,
                    // Held contacts may pass more of a signal to a body than it has on its own.
                    _ => excess = excess.max(x.abs() * signals[j - one] / scale),
                }
            }
            rate = rate.max(of_row(stiffness, damping));
        }
        let (mut rate, bound) = (rate, |rate: f64| self.norm.of_inner(a, rate));
        rate = rate.max(bound(0.0).0 / (1.0 - SHARE));
        excess = excess.max(bound(rate).1);
        let mut weights = Vec::with_capacity(one + signals.len());
        weights.extend(scales.iter().map(|d| 1.0 / d));
        weights.extend(scales.iter().map(|d| 1.0 / (rate * d)));
        weights.extend(inner.iter().map(|s| 1.0 / s));
        let unit = SHARE * rate * rate / (signals.len() as f64 * excess);
        weights.extend(signals.iter().map(|g| 1.0 / (unit * g)));
        (rate.max(bound(rate).0), weights)
    }
}

impl Norm {
    fn new(system: &System, base: &SparseMatrix, scales: Vec<f64>, terms: [&[Term]; 3]) -> Self {
        let (n, one, size) = (system.coordinates, system.signals.one, system.signals.size);
        let mut signals = vec![f64::INFINITY; size - one];
        // The sizes that signals may add to a row in any mode.
        let mut added = vec![0.0; size - one];
        let mut by_row: Vec<Vec<(&Term, f64)>> = vec![Vec::new(); n];
        for term in terms.into_iter().flatten() {
            let on_rates = term.by.terms().iter().filter(|(place, _)| *place < 2 * n);
            on_rates.for_each(|&(place, x)| by_row[place - n].push((term, x)));
        }
        let mut lowest = LEAST_RATE.max(swept(base, one));
        for k in 0..n {
            added.fill(0.0);
            let mut stiffness = 0.0;
            for &(j, x) in base.row(n + k) {
                match j {
                    _ if j < n => stiffness += x.abs() * scales[j] / scales[k],
                    _ if j < one => {}
                    _ => added[j - one] += x.abs(),
                }
            }
            lowest = lowest.max(stiffness.sqrt());
            for (term, x) in &by_row[k] {
                let own = term.force.terms().iter().filter(|(j, _)| *j >= one);
                own.for_each(|&(j, f)| added[j - one] += (x * f).abs());
            }
            for (most, x) in signals.iter_mut().zip(&added).filter(|(_, x)| **x > 0.0) {
                *most = most.min(scales[k] / x);
            }
        }
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
        let inner = (2 * n..).zip(&system.first_order).map(|(i, own)| Self::inner(&scales, i, &own.rate));
        Self { inner: inner.collect(), scales, signals, rate }
    }

    /// Returns the weight of state of first order `i`, from the row of its rate. The weight makes
    /// the terms of the coordinates at most as large as the state's own term, and leaves the
    /// signals their share of the terms of the velocities.
    fn inner(scales: &[f64], i: usize, rate: &Functional) -> f64 {
        let n = scales.len();
        let sum = |first: usize| {
            let terms = rate.terms().iter().filter(|(j, _)| (first..first + n).contains(j));
            terms.map(|&(j, x)| x.abs() * scales[j - first]).sum::<f64>()
        };
        let weight = (sum(0) / rate[i].abs()).max(sum(n) / (1.0 - SHARE));
        if weight.is_finite() && weight > 0.0 { weight } else { 1.0 }
    }

    /// Returns the largest row sum of a state of first order, with Ω = `rate` and the signals'
    /// share, and the largest ratio of a signal to its share.
    fn of_inner(&self, a: &SparseMatrix, rate: f64) -> (f64, f64) {
        let (n, first) = (self.scales.len(), 2 * self.scales.len());
        let one = first + self.inner.len();
        let (mut most, mut excess) = (0.0f64, 0.0f64);
        for (i, own) in (first..).zip(&self.inner) {
            let (mut sum, mut is_driven) = (0.0, false);
            for &(j, x) in a.row(i) {
                match j {
                    _ if j < n => sum += x.abs() * self.scales[j] / own,
                    _ if j < first => sum += x.abs() * rate * self.scales[j - n] / own,
                    _ if j < one => sum += x.abs() * self.inner[j - first] / own,
                    _ => {
                        is_driven = true;
                        excess = excess.max(x.abs() * self.signals[j - one] * rate / own);
                    }
                }
            }
            most = most.max(sum + if is_driven { SHARE * rate } else { 0.0 });
        }
        (most, excess)
    }
}
