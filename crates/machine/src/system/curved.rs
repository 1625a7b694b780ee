//! Curved forces of a machine: their coordinates in the augmented state.

use super::formula::{FormulaRows, Numbers, Operations, reference};
use super::{Elongation, FrictionRows, LevelRows, Part, System};
use crate::curved::{Curved, Operation, POWERS, Polynomial};
use crate::description::{Description, OddPower, Stribeck, StribeckExponent};
use crate::elements::Element;
use crate::formula::{Atom, Compiled, Line, Step};
use crate::functional::Functional;
use crate::kernel::SparseMatrix;
use crate::mode::{Mode, StopState};

/// The operations of an element's formula; none if it is refused.
pub(crate) fn compiled(element: Element) -> Option<Compiled> {
    element.formula()?.compiled().ok()
}

/// Whether a power is not straight.
fn is_bent(power: &OddPower) -> bool {
    !power.is_straight()
}

/// Number of operations of curved forces of a machine.
pub fn count(d: &Description) -> usize {
    let of_formula = |element| compiled(element).map_or(0, |own| own.steps.len());
    let of_law = |element| match element {
        Element::Spring(own) => {
            usize::from(own.has_polynomial()) + own.power.into_iter().filter(is_bent).count()
        }
        Element::Damper(own) => own.cubic.iter().count() + own.odd_powers().filter(is_bent).count(),
        Element::Stop(own) => {
            own.contact.map_or(0, |own| usize::from(own.exponent != 1.0) + own.dissipation.iter().count())
        }
        Element::Friction(friction) => friction.stribeck.map_or(0, operations_of),
        _ => 0,
    };
    d.elements().map(|element| of_law(element) + of_formula(element)).sum()
}

impl Curved {
    /// The operation in a mode. In the direction σ of a friction that slips, exp(-|a|) is
    /// exp(-σ a); while it does not slip, a is 0.
    pub(crate) fn in_mode(&self, mode: &Mode) -> Self {
        let Some(factor) = self.factor_in(mode) else { return self.clone() };
        let argument = match factor == 0.0 {
            true => Functional::zeros(self.argument.len()),
            false => factor * &self.argument,
        };
        Self { operation: Operation::Exponential, argument, ..self.clone() }
    }

    /// The factor of the argument in a mode; `None` for operations that are the same in all modes.
    pub(crate) fn factor_in(&self, mode: &Mode) -> Option<f64> {
        match (self.owner, self.operation) {
            (Part::Friction(i), Operation::Decay) => Some(-mode.frictions[i].direction()),
            _ => None,
        }
    }

    /// The column of xᵖ of a released contact, as if the contact had its force: accounts and event
    /// functions need this power beyond the release.
    pub(crate) fn released(&self, system: &System, mode: &Mode) -> Option<Vec<(usize, f64)>> {
        let (Part::Stop(i), Operation::OneSided(_)) = (self.owner, self.operation) else { return None };
        let stop = &system.stops[i];
        let terms = stop.elongation.mobility.terms().iter();
        let column = terms.map(|&(k, x)| (system.coordinates + k, stop.stiffness() * x));
        (mode.stops[i] == StopState::Free).then(|| column.collect())
    }
}

/// The first element with a curved force, by its dotted name.
pub fn first(d: &Description) -> Option<String> {
    d.elements().find(|element| element.is_curved()).map(Element::dotted)
}

/// Number of operations of Stribeck's curve.
fn operations_of(own: Stribeck) -> usize {
    match own.exponent {
        StribeckExponent::One => 2,
        StribeckExponent::Two => 3,
    }
}

impl System {
    /// Whether any force is a formula.
    pub fn has_formulas(&self) -> bool {
        self.springs.iter().any(|spring| spring.formula.is_some())
    }

    /// [`linearised`](Self::linearised) at zero displacements and rates, if there are formulas and
    /// all are defined there.
    pub fn linearised_at_zero(&self, a: &SparseMatrix) -> Option<SparseMatrix> {
        if !self.has_formulas() {
            return None;
        }
        let mut z = vec![0.0; self.signals.size];
        z[self.signals.one] = 1.0;
        self.fill_curved(&mut z);
        let is_defined = |own: &Curved| {
            let arguments = own.arguments(&z);
            own.operation.is_defined(arguments[0])
                && own.operation.slopes(arguments).iter().all(|x| x.is_finite())
        };
        self.curved.iter().all(is_defined).then(|| self.linearised(a, &z))
    }

    /// A matrix A with z' = A z to first order near a state: the curved forces are replaced by their
    /// derivatives there.
    pub fn linearised(&self, a: &SparseMatrix, z: &[f64]) -> SparseMatrix {
        let size = self.signals.size;
        let straight = |row: &Functional, known: &[Functional]| {
            let own = row.terms().iter().map(|&(j, x)| match j.checked_sub(self.signals.curved) {
                Some(k) if k < known.len() => x * &known[k],
                _ => Functional::unit(size, j, x),
            });
            let all: Vec<Functional> = own.collect();
            Functional::sum(size, all.iter().map(|row| (1.0, row)))
        };
        let mut slopes: Vec<Functional> = Vec::new();
        for own in &self.curved {
            let by = own.operation.slopes(own.arguments(z));
            let rows = [straight(&own.argument, &slopes), straight(&own.second, &slopes)];
            slopes.push(Functional::sum(size, by.into_iter().zip(&rows)));
        }
        a.with_rows(
            |x| x,
            |i| {
                let row = Functional::from_terms(size, a.row(i).iter().copied());
                let is_curved = row.terms().iter().any(|term| term.0 >= self.signals.curved);
                is_curved.then(|| straight(&row, &slopes).terms().to_vec().into_iter())
            },
        )
    }

    /// Adds a curved force to the spring that was added last, of its elongation or of its rate.
    pub(crate) fn add_curve(&mut self, is_of_rate: bool, coefficients: [f64; POWERS]) {
        let place = self.signals.curved + self.curved.len();
        let Some(spring) = self.springs.last_mut() else { return };
        let Elongation { e, rate, .. } = &spring.elongation;
        let argument = if is_of_rate { rate } else { e }.clone();
        spring.force = &spring.force + &Functional::unit(self.signals.size, place, 1.0);
        spring.curves.push((self.curved.len(), 1.0));
        let operation = Operation::Polynomial(Polynomial { coefficients });
        let second = Functional::zeros(self.signals.size);
        let owner = Part::Spring(self.springs.len() - 1);
        self.curved.push(Curved { argument, second, operation, place, is_of_rate, owner });
    }

    /// Adds a formula to the spring that was added last. `start` returns its elongation at time 0.
    pub(crate) fn add_formula(&mut self, element: Element, start: impl FnOnce() -> f64) {
        let (Some(formula), Some(compiled)) = (element.formula(), compiled(element)) else { return };
        let Some(spring) = self.springs.last() else { return };
        let (elongation, size) = (spring.elongation.clone(), self.signals.size);
        let (first, one, zeros) = (self.curved.len(), self.signals.one, Functional::zeros(size));
        let operations = Operations { one, first: self.signals.curved + first };
        let row = |line: &Line| operations.row(line, &elongation.e, &elongation.rate, Numbers::Values);
        for (i, Step { operation, arguments }) in compiled.steps.iter().enumerate() {
            let [argument, second] = arguments.each_ref().map(row);
            let second = if operation.is_of_two() { second } else { zeros.clone() };
            let (place, owner) = (operations.first + i, Part::Spring(self.springs.len() - 1));
            let is_of_rate = arguments.iter().flat_map(|line| &line.0).any(|own| own.0 == Atom::Rate);
            self.curved.push(Curved { argument, second, operation: *operation, place, is_of_rate, owner });
        }
        let (force, elastic) = (row(&compiled.force), row(&compiled.elastic));
        let lossy = &force - &elastic;
        let from = reference(&compiled, start());
        let formula = formula.into_owned();
        if let Some(spring) = self.springs.last_mut() {
            spring.force = &spring.force + &force;
            spring.formula = Some(FormulaRows { formula, compiled, operations, lossy, from });
        }
    }

    /// Adds Stribeck's curve to the friction that was added last: its level is sliding + (largest -
    /// sliding) exp(-(|e'|/v)ᵖ) for both directions of e', and equals the static level at e' = 0.
    pub(crate) fn add_stribeck(&mut self, Stribeck { speed, exponent }: Stribeck) {
        let (place, size) = (self.signals.curved + self.curved.len(), self.signals.size);
        let owner = Part::Friction(self.frictions.len() - 1);
        let Some(FrictionRows { elongation, levels, has_static, .. }) = self.frictions.last_mut() else {
            return;
        };
        let unit = |place: usize, value: f64| Functional::unit(size, place, value);
        let (zeros, mut coefficients) = (Functional::zeros(size), [0.0; POWERS]);
        coefficients[0] = 1.0;
        let square = Operation::Polynomial(Polynomial { coefficients });
        for LevelRows { level, static_level } in levels {
            let ratio = (1.0 / speed) * &elongation.rate;
            let mut rows = match exponent {
                StribeckExponent::One => vec![(Operation::Decay, ratio, zeros.clone(), true)],
                StribeckExponent::Two => vec![
                    (square, ratio, zeros.clone(), true),
                    (Operation::Exponential, unit(place, -1.0), zeros.clone(), false),
                ],
            };
            let factor = unit(place + rows.len() - 1, 1.0);
            rows.push((Operation::Product, &*static_level - &*level, factor, false));
            let last = place + rows.len() - 1;
            for (i, (operation, argument, second, is_of_rate)) in rows.into_iter().enumerate() {
                let place = place + i;
                self.curved.push(Curved { argument, second, operation, place, is_of_rate, owner });
            }
            *level = &*level + &unit(last, 1.0);
            *static_level = level.clone();
        }
        // The level falls without a jump.
        *has_static = false;
    }

    /// Adds powers with two sides to the spring that was added last, of its elongation or of its
    /// rate. A power with the exponent 1 is part of its stiffness or damping.
    pub(crate) fn add_odd_powers(&mut self, is_of_rate: bool, powers: impl IntoIterator<Item = OddPower>) {
        for OddPower { coefficient, exponent } in powers.into_iter().filter(is_bent) {
            let Some(spring) = self.springs.last() else { return };
            let Elongation { e, rate, .. } = &spring.elongation;
            let argument = if is_of_rate { rate } else { e }.clone();
            let (index, owner) = (self.curved.len(), Part::Spring(self.springs.len() - 1));
            let none = Functional::zeros(self.signals.size);
            let row = self.add_operation(Operation::TwoSided(exponent), [&argument, &none], owner);
            self.curved[index].is_of_rate = is_of_rate;
            let Some(spring) = self.springs.last_mut() else { return };
            spring.force = &spring.force + &(coefficient * &row);
            spring.curves.push((index, coefficient));
        }
    }

    /// Adds an operation; returns the row of its value.
    pub(crate) fn add_operation(
        &mut self,
        operation: Operation,
        [argument, second]: [&Functional; 2],
        owner: Part,
    ) -> Functional {
        let place = self.signals.curved + self.curved.len();
        let (argument, second) = (argument.clone(), second.clone());
        self.curved.push(Curved { argument, second, operation, place, is_of_rate: false, owner });
        Functional::unit(self.signals.size, place, 1.0)
    }

    /// Writes the curved forces into the augmented state, from its coordinates and rates.
    #[inline(always)]
    pub(crate) fn fill_curved(&self, z: &mut [f64]) {
        for curved in &self.curved {
            curved.fill(z);
        }
    }

    /// Writes the variations of the curved forces into a variation of the state `z`.
    pub fn vary_curved(&self, z: &[f64], variation: &mut [f64]) {
        for curved in &self.curved {
            curved.vary(z, variation);
        }
    }

    /// Raises the sizes of curved forces to their rounding at a state.
    #[inline(always)]
    pub(crate) fn include_curved(&self, z: &[f64], sizes: &mut [f64]) {
        for curved in &self.curved {
            sizes[curved.place] = sizes[curved.place].max(curved.size(z, sizes));
        }
    }

    /// Sets the sizes of curved forces to their rounding at a state.
    pub(crate) fn set_curved_sizes(&self, z: &[f64], sizes: &mut [f64]) {
        for curved in &self.curved {
            sizes[curved.place] = curved.size(z, sizes);
        }
    }
}
