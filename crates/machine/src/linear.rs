//! The linear system z' = A z of a mode and the functionals that end it (docs/assembly-law.md
//! (A5)).

mod held;

use crate::functional::Functional;
use crate::kernel::{Sparse, SparseMatrix};
use crate::law::groups::Triangle;
use crate::mode::{Contact, Mode, StopState, Watch};
use crate::system::{Elongation, Split, System, Term};
use held::{Held, Reaction};
use std::borrow::Cow;
use std::sync::Arc;

/// The linear system of a mode.
#[derive(Clone, Debug)]
pub struct Linear {
    /// Number of coordinates.
    pub coordinates: usize,
    /// z' = A z.
    pub a: SparseMatrix,
    /// For each entry of A: the sum of the sizes of its terms; `None` without contacts. If a
    /// closed stop cancels the terms, their rounding error remains.
    pub terms: Option<SparseMatrix>,
    /// Contact forces of the basis, in its order, as rows.
    pub lambda: Vec<Sparse>,
    /// The upper triangle R with RᵀR = WᵀM⁻¹W of the basis.
    pub triangle: Triangle,
    /// The functionals that end the mode, each negative inside it.
    pub watched: Vec<(Watch, Arc<Sparse>)>,
    /// Elastic forces that may be computed separately.
    pub elastic: Option<Elastic>,
    /// Absolute values of 1 - M⁻¹ W G⁻¹ Wᵀ, the projection of velocities onto the velocities that
    /// the contacts allow; `None` without contacts.
    pub loose: Option<SparseMatrix>,
}

/// Forces of stiff springs and compliant stops, separate from the rest of A: A = rest - Σ by ⊗
/// force.
#[derive(Clone, Debug)]
pub struct Elastic {
    /// A without these forces.
    pub rest: SparseMatrix,
    /// For each entry of `rest`: the sum of the sizes of its terms, if there are contacts.
    pub rest_terms: Option<SparseMatrix>,
    /// The forces, each with its vector `by`: a unit of the force reduces z' by this vector.
    pub forces: Vec<(Arc<Functional>, Arc<Sparse>)>,
    /// Whether a force ties a group of bodies that much softer forces move; always false without
    /// stored matrices. Even if it is false, the fastest motion of the mode may come from these
    /// forces.
    pub are_stiff: bool,
}

/// Base matrix, elastic forces, and other forces of a mode.
type SplitTerms<'a> = (&'a Split, Vec<Term>, Vec<Term>);

impl System {
    /// The linear system of a mode.
    ///
    ///
    /// The second derivative of an oscillator's coordinate is -k/m s - c/m v:
    ///
    /// ```
    /// use vibro_machine::{Assembly, Motion, file};
    ///
    /// let text = r#"
    ///     name = "Oscillator"
    ///     body.a = { mass = 2.0 }
    ///     spring.k = { between = ["ground", "a"], stiffness = 8.0, damping = 1.0 }
    /// "#;
    /// let machine = file::parse(text, "oscillator.toml", &file::no_records)?;
    /// let motion = Motion::new(Assembly::new(machine)?.into())?;
    /// let linear = motion.assembly().system().linear(motion.mode());
    /// assert_eq!([0, 1].map(|column| linear.a.entry(0, column)), [0.0, 1.0]);
    /// assert_eq!([0, 1].map(|column| linear.a.entry(1, column)), [-4.0, -0.5]);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn linear(&self, mode: &Mode) -> Linear {
        if let Cow::Owned(own) = self.at_mode(mode) {
            return own.linear(mode);
        }
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

    /// The elastic forces of a mode that may be computed separately: forces of stiff springs and
    /// of compliant stops that act.
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
}
