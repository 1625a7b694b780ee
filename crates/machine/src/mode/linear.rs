//! The linear system z' = A z of a mode and the functionals that end it (docs/assembly-law.md
//! (A5)).

use super::groups::Triangle;
use super::held::{Held, Reaction};
use super::{Contact, FrictionState, Mode, SliderState, StopState, Watch};
use crate::kernel::{Sparse, SparseMatrix};
use crate::system::{Elongation, Functional, Split, System, Term};
use nalgebra::DMatrix;
use std::sync::Arc;

/// The linear system of a mode.
#[derive(Clone, Debug)]
pub struct Linear {
    /// Number of coordinates.
    pub coordinates: usize,
    /// z' = A z.
    pub a: SparseMatrix,
    /// By entry of A: the sum of the sizes of its terms; `None` without contacts. If a closed stop
    /// cancels the terms, their rounding remains.
    pub terms: Option<SparseMatrix>,
    /// Contact forces of the basis, in its order, as rows.
    pub lambda: Vec<Sparse>,
    /// The upper triangle R with RᵀR = WᵀM⁻¹W of the basis.
    pub triangle: Triangle,
    /// The functionals that end the mode, each negative inside it.
    pub watched: Vec<(Watch, Arc<Sparse>)>,
    /// Elastic forces that may be computed separately.
    pub elastic: Option<Elastic>,
    /// Absolute values of 1 - M⁻¹ W G⁻¹ Wᵀ, the projection of velocities onto those that the
    /// contacts allow; `None` without contacts.
    pub loose: Option<SparseMatrix>,
}

/// Forces of stiff springs and compliant stops, separate from the rest of A: A = rest - Σ by ⊗
/// force.
#[derive(Clone, Debug)]
pub struct Elastic {
    /// A without these forces.
    pub rest: SparseMatrix,
    /// By entry of `rest`: the sum of the sizes of its terms, where there are contacts.
    pub rest_terms: Option<SparseMatrix>,
    /// The forces, each with its vector `by`: a unit of the force reduces z' by this vector.
    pub forces: Vec<(Arc<Functional>, Arc<Sparse>)>,
    /// Whether a force ties a group of bodies that much softer forces move; always false without
    /// stored matrices. If it is false, the fastest motion of the mode may still come from these
    /// forces.
    pub are_stiff: bool,
}

/// What always acts, elastic forces, and other forces of a mode.
type SplitTerms<'a> = (&'a Split, Vec<Term>, Vec<Term>);

impl System {
    /// The linear system of a mode.
    pub fn linear(&self, mode: &Mode) -> Linear {
        let held = Held::new(self, &mode.basis);
        let terms = self.split_terms(mode);
        let free = match &terms {
            Some((split, elastic, others)) => split.with(elastic.iter().chain(others)),
            None => {
                let Mode { stops, frictions, sliders, .. } = mode;
                self.matrix(&self.free_acceleration(stops, frictions, sliders), (sliders, stops))
            }
        };
        let elastic = self.elastic(mode, &held, terms);
        if mode.basis.is_empty() {
            let watched = self.watched(mode, &[]);
            let (lambda, triangle) = (Vec::new(), Triangle::default());
            let coordinates = self.coordinates;
            return Linear {
                coordinates,
                a: free,
                terms: None,
                lambda,
                triangle,
                watched,
                elastic,
                loose: None,
            };
        }
        let Reaction { a, terms, lambda } = held.react(&free);
        Linear {
            coordinates: self.coordinates,
            a,
            terms: Some(terms),
            watched: self.watched(mode, &lambda),
            lambda,
            elastic,
            loose: Some(held.loose_sizes()),
            triangle: held.triangle(),
        }
    }

    /// The forces of a mode that are added to the base matrix: elastic forces and others. `None`
    /// for a machine that stores matrices.
    fn split_terms(&self, mode: &Mode) -> Option<SplitTerms<'_>> {
        let split = (!self.keeps_matrices()).then(|| self.split())?;
        Some((split, split.elastic(mode), split.frictional(mode)))
    }

    /// The matrix A with these rows of accelerations, in states of the branches and of the stops.
    fn matrix(&self, acceleration: &DMatrix<f64>, states: (&[SliderState], &[StopState])) -> SparseMatrix {
        let size = self.signals.size;
        self.rows_of(|k, a| a.push_row((0..size).map(|j| (j, acceleration[(k, j)]))), states)
    }

    /// The matrix A where `push` adds the row of each coordinate's acceleration.
    fn rows_of(
        &self,
        push: impl Fn(usize, &mut SparseMatrix),
        (sliders, stops): (&[SliderState], &[StopState]),
    ) -> SparseMatrix {
        let n = self.coordinates;
        let mut a = SparseMatrix::default();
        (0..n).for_each(|k| a.push_row(std::iter::once((n + k, 1.0))));
        (0..n).for_each(|k| push(k, &mut a));
        self.push_first_order(&mut a, sliders, stops);
        self.signals.rates().iter().for_each(|row| a.push_row(row.terms().iter().copied()));
        a
    }

    /// The elastic forces of a mode that may be computed separately: those of stiff springs and of
    /// compliant stops that act.
    fn elastic(&self, mode: &Mode, held: &Held, terms: Option<SplitTerms>) -> Option<Elastic> {
        let springs = self.stiff_springs.iter().map(|&i| &self.springs[i].elongation);
        let is_elastic = |i: &usize| mode.stops[*i].has_force() && !self.is_limit(*i);
        let pressed: Vec<usize> = (0..mode.stops.len()).filter(is_elastic).collect();
        let stops = pressed.iter().map(|&i| &self.stops[i].elongation);
        let elongations: Vec<&Elongation> = springs.chain(stops).collect();
        if elongations.is_empty() {
            return None;
        }
        let moved = |e: &Elongation| Arc::new(held.moved(e));
        let (rest, forces) = match terms {
            Some((split, elastic, others)) => {
                let own = |(term, e): (Term, &Elongation)| {
                    (term.force, if held.holds(e) { moved(e) } else { term.by })
                };
                (split.with(others.iter()), elastic.into_iter().zip(elongations).map(own).collect())
            }
            None => {
                let mut left = mode.stops.clone();
                pressed.iter().for_each(|&i| left[i] = StopState::Below);
                let followed = (&mode.frictions[..], &mode.stops[..]);
                let rest = self.accelerations(self.soft_forces(), &left, followed, &mode.sliders);
                let springs = self.stiff_springs.iter().map(|&i| self.springs[i].force.clone());
                let stops = pressed.iter().filter_map(|&i| self.stop_force(i, mode.stops[i]));
                let forces = springs.chain(stops).map(Arc::new);
                (
                    self.matrix(&rest, (&mode.sliders, &mode.stops)),
                    forces.zip(elongations.into_iter().map(moved)).collect(),
                )
            }
        };
        let are_stiff = || !self.stiff_springs.is_empty() || !self.stiff_ties(&pressed).is_empty();
        let are_stiff = self.keeps_matrices() && are_stiff();
        if mode.basis.is_empty() {
            return Some(Elastic { rest, rest_terms: None, forces, are_stiff });
        }
        let Reaction { a, terms, .. } = held.react(&rest);
        Some(Elastic { rest: a, rest_terms: Some(terms), forces, are_stiff })
    }

    /// The functionals that end a mode, each negative inside it.
    fn watched(&self, mode: &Mode, lambda: &[Sparse]) -> Vec<(Watch, Arc<Sparse>)> {
        let mut watched: Vec<(Watch, Arc<Sparse>)> = if !self.keeps_matrices() {
            self.split().watched(mode).map(|(known, _)| (known.watch, known.row.clone())).collect()
        } else {
            let stops = mode.stops.iter().enumerate().flat_map(|(i, &state)| self.watched_of_stop(i, state));
            let frictions = mode.frictions.iter().enumerate();
            let frictions = frictions.flat_map(|(i, &state)| {
                self.watched_of_friction(i, self.frictions[i].place(&mode.stops), state)
            });
            let sliders = mode.sliders.iter().enumerate();
            let sliders = sliders.flat_map(|(i, &state)| self.watched_of_slider(i, state));
            let rows = stops
                .chain(frictions)
                .chain(sliders)
                .map(|(watch, row)| (watch, Arc::new(AsRef::<Sparse>::as_ref(&row).clone())));
            rows.filter(|(_, row)| !self.is_constant_and_negative(row)).collect()
        };
        for (&contact, force) in mode.basis.iter().zip(lambda) {
            let mut put = |watch: Watch, row: Sparse| {
                // A negative constant needs no watch.
                if !self.is_constant_and_negative(&row) {
                    watched.push((watch, Arc::new(row)));
                }
            };
            match contact {
                Contact::Stop(i) => put(Watch::Opens(i), force.times(-1.0)),
                Contact::Friction(i) => {
                    let Some(own) = self.frictions[i].at(&mode.stops) else { continue };
                    let level: &Sparse = own.static_level.as_ref();
                    put(Watch::Slips(i, true), force.less(level));
                    put(Watch::Slips(i, false), force.times(-1.0).less(level));
                }
                Contact::Slider(_) => {}
            }
        }
        watched
    }

    /// Functionals that are watched for a stop in a state, without the force of a closed stop.
    pub(crate) fn watched_of_stop(&self, i: usize, state: StopState) -> Vec<(Watch, Functional)> {
        let stop = &self.stops[i];
        let damped = stop.is_damped();
        let leaves = || (Watch::Leaves(i), -&stop.excess);
        match state {
            StopState::Open => vec![(Watch::Meets(i), stop.excess.clone())],
            StopState::Closed => Vec::new(),
            StopState::Below => vec![(Watch::Presses(i), stop.excess.clone())],
            StopState::Off => Vec::new(),
            StopState::Pressed if stop.is_gapless() => Vec::new(),
            // Of stiffness 0 the force does not tell where it ends.
            StopState::Pressed if stop.level.is_some() && !damped => vec![leaves()],
            StopState::Pressed if stop.turns() => vec![(Watch::Turns(i), -&stop.elongation.rate)],
            StopState::Pressed if !stop.is_limited() => vec![leaves()],
            StopState::Pressed => {
                let cap = (stop.is_elastogap() && damped)
                    .then(|| (Watch::Changes(i), &stop.force - &(2.0 * &stop.spring)));
                std::iter::once((Watch::Changes(i), -&stop.force)).chain(cap).collect()
            }
            StopState::Free => {
                vec![(Watch::Changes(i), stop.force.clone()), leaves()]
            }
            StopState::Capped => vec![(Watch::Changes(i), &(2.0 * &stop.spring) - &stop.force), leaves()],
            StopState::Rebounding => {
                vec![(Watch::Turns(i), stop.elongation.rate.clone()), leaves()]
            }
        }
    }

    /// Functionals that are watched for a friction with these of its levels in a state, without the
    /// force of one that sticks. Where a level passes zero with the force of a stop that never
    /// pulls, the stop's own functional ends the mode.
    pub(crate) fn watched_of_friction(
        &self,
        i: usize,
        levels: Option<usize>,
        state: FrictionState,
    ) -> Vec<(Watch, Functional)> {
        let friction = &self.frictions[i];
        let Some(own) = levels.map(|place| &friction.levels[place]) else { return Vec::new() };
        let sign = if state == FrictionState::Off { 1.0 } else { -1.0 };
        let level = friction.passes.then(|| (Watch::Level(i), sign * &own.level));
        let slips = matches!(state, FrictionState::Up | FrictionState::Down);
        let stops = slips.then(|| (Watch::Stops(i), -state.direction() * &friction.elongation.rate));
        stops.into_iter().chain(level).collect()
    }

    /// A of the mode in which no stop is pressed, no friction slips and no contact is held, without
    /// the forces of stiff springs and of springs with sliders.
    pub(crate) fn base(&self) -> SparseMatrix {
        let forces = self.soft_forces();
        if self.is_diagonal {
            // Forces are summed before they are divided, so that cancelling ones leave exact zeros.
            let row = |k: usize| forces.entries(k).iter().map(move |&(j, x)| (j, x / self.mass[(k, k)]));
            return self.rows_of(|k, a| a.push_row(row(k)), (&[], &[]));
        }
        let rows = self.inertia.solve_rows(forces);
        self.rows_of(|k, a| a.push_row(rows[k].iter().copied()), (&[], &[]))
    }

    /// Whether a row is a negative constant, such as that of a constant friction level.
    pub(crate) fn is_constant_and_negative(&self, row: &Sparse) -> bool {
        matches!(row.terms(), [(j, x)] if *j == self.signals.one && *x < 0.0)
    }
}
