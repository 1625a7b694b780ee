//! The linear part of an orbit: given the impact phases, the state follows from six linear
//! equations; the contact conditions are the residual (docs/theory.md (101) to (105)).
//!
//! If a body is hardly held by a spring, the first contact is one of the six equations, and the
//! return of the body belongs to the residual instead (docs/theory.md (112)).

use super::system::{Anchor, System};
use crate::obstacle::Obstacle;
use crate::stop_word::OrbitWord;
use nalgebra::{Complex, ComplexField, DMatrix, DVector, Matrix6, SMatrix};
use vibro_impact::steady::exact_orbit::{Transition, Vector6};

/// Ratio of the diagonal entries of an LU decomposition of σI - M below which the matrix counts as
/// singular: the state would have fewer than six digits.
const REGULAR: f64 = 1e-10;

/// The row whose product with a state is w.
const GAP: Vector6 = Vector6::new(-1.0, 1.0, 0.0, 0.0, 0.0, 0.0);

/// Quantity, at the ends of the flights, whose derivative is computed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Functional {
    /// w.
    Gap = 0,
    /// w'.
    Rate = 1,
}

impl Functional {
    /// Value at a state without the drive's motion.
    fn of(self, z: &Vector6) -> f64 {
        match self {
            Self::Gap => z[1] - z[0],
            Self::Rate => z[4] - z[3],
        }
    }
}

/// One pass of a word at given impact phases, closed by docs/theory.md (103). Flight i leads from
/// impact i to impact i + 1.
pub(super) struct Cycle<'a> {
    pub system: &'a System,
    pub word: &'a OrbitWord,
    pub phases: &'a [f64],
    transitions: Vec<Transition>,
    /// M of docs/theory.md (102).
    map: Matrix6<f64>,
    /// The derivatives of w and of w' at the end of each flight with respect to the state at the
    /// start.
    rows: Vec<[Vector6; 2]>,
    /// z, the state minus the motion without impacts. `start` is just after the first impact;
    /// `before` and `after` refer to the impact at the end of each flight.
    pub start: Vector6,
    pub before: Vec<Vector6>,
    pub after: Vec<Vector6>,
    /// w - s at the end of each flight. For an anchored system the last entry is the error of
    /// return of the anchored displacement.
    pub residual: Vec<f64>,
    /// w'⁻ at the end of each flight.
    pub rates: Vec<f64>,
}

/// Phase of the impact at the end of a flight, where the next flight starts.
fn arrival(word: &OrbitWord, phases: &[f64], flight: usize) -> f64 {
    phases.get(flight + 1).copied().unwrap_or(phases[0] + word.span())
}

/// In the matrix of the equations for a state, replaces the row for the return of the anchored
/// displacement by the row of the first contact. If another displacement moves with the anchored
/// one, its row becomes the return of their difference.
fn anchor_rows<T: ComplexField<RealField = f64>>(closed: &mut SMatrix<T, 6, 6>, anchor: Anchor) {
    let place = anchor.place();
    if let Some(follower) = anchor.follower() {
        let beside = closed.row(follower) - closed.row(place);
        closed.set_row(follower, &beside);
    }
    closed.set_row(place, &GAP.transpose().map(T::from_real));
}

/// On the right side of these equations, replaces the entry for the return of the anchored
/// displacement by the value of the first contact.
fn anchor_right<T: ComplexField<RealField = f64>>(right: &mut SMatrix<T, 6, 1>, anchor: Anchor, contact: T) {
    let place = anchor.place();
    if let Some(follower) = anchor.follower() {
        right[follower] = right[follower].clone() - right[place].clone();
    }
    right[place] = contact;
}

/// The maps of all flights; `None` unless the phases are in order.
pub(super) fn transitions(system: &System, word: &OrbitWord, phases: &[f64]) -> Option<Vec<Transition>> {
    let spans = (0..phases.len()).map(|i| arrival(word, phases, i) - phases[i]);
    spans.map(|span| (span > 0.0).then(|| system.flight.transition(span))).collect()
}

impl<'a> Cycle<'a> {
    /// Closes a word at given phases.
    pub fn new(system: &'a System, word: &'a OrbitWord, phases: &'a [f64]) -> Result<Self, Obstacle> {
        let transitions = transitions(system, word, phases).ok_or(Obstacle::Order)?;
        Self::with_transitions(system, word, phases, transitions)
    }

    /// Closes a word at given phases with known maps of its flights. The maps do not depend on the
    /// drive's amplitude or on loads.
    pub fn with_transitions(
        system: &'a System,
        word: &'a OrbitWord,
        phases: &'a [f64],
        transitions: Vec<Transition>,
    ) -> Result<Self, Obstacle> {
        Obstacle::check(system, word)?;
        let n = phases.len();
        let forced = |i: usize| system.forced_gap(arrival(word, phases, i));
        let span = |i: usize| arrival(word, phases, i) - phases[i];
        let (mut map, mut constant) = (Matrix6::identity(), Vector6::zeros());
        let mut rows = Vec::with_capacity(n);
        for (i, transition) in transitions.iter().enumerate() {
            map = mapped(&map, |z| transition.apply(z));
            rows.push([1, 4].map(|i| (map.row(i) - map.row(i - 1)).transpose()));
            map = mapped(&map, |z| system.flight.strike(z, 0.0));
            constant =
                system.flight.strike(&system.state_after(transition, span(i), &constant), forced(i)[1]);
        }
        let sigma = f64::from(word.closing());
        let mut closed = Matrix6::identity() * sigma - map;
        if let Some(anchor) = system.anchor() {
            anchor_rows(&mut closed, anchor);
            anchor_right(&mut constant, anchor, word.side(0) - system.forced_gap(phases[0])[0]);
        }
        let start = solve(&closed, &constant).ok_or(Obstacle::Singular)?;
        let (mut before, mut after) = (Vec::with_capacity(n), Vec::with_capacity(n));
        let (mut residual, mut rates) = (Vec::with_capacity(n), Vec::with_capacity(n));
        let mut z = start;
        for (i, transition) in transitions.iter().enumerate() {
            let [gap, rate, _] = forced(i);
            let arrived = system.state_after(transition, span(i), &z);
            residual.push(Functional::Gap.of(&arrived) + gap - word.side(i + 1));
            rates.push(Functional::Rate.of(&arrived) + rate);
            z = system.flight.strike(&arrived, rate);
            before.push(arrived);
            after.push(z);
        }
        if let Some(place) = system.anchor().map(Anchor::place) {
            residual[n - 1] = z[place] - sigma * start[place];
        }
        if residual.iter().chain(&rates).any(|x| !x.is_finite()) {
            return Err(Obstacle::Singular);
        }
        Ok(Self { system, word, phases, transitions, map, rows, start, before, after, residual, rates })
    }

    /// The cycle with these phases in another system.
    pub fn in_system<'b>(&self, system: &'b System) -> Result<Cycle<'b>, Obstacle>
    where
        'a: 'b,
    {
        let (own, other) = (&self.system.flight, &system.flight);
        // Parameters on which the maps of the flights depend.
        let rates =
            |f: &vibro_impact::steady::exact_orbit::Flight| [f.k1, f.c1, f.k2, f.k3, f.c3, f.k32, f.rate];
        if rates(own) == rates(other) {
            Cycle::with_transitions(system, self.word, self.phases, self.transitions.clone())
        } else {
            Cycle::new(system, self.word, self.phases)
        }
    }

    fn len(&self) -> usize {
        self.phases.len()
    }

    fn sigma(&self) -> f64 {
        f64::from(self.word.closing())
    }

    /// The matrix of the equations for the state (`factor` 1), or for variations of the state that
    /// close with `factor` times the word's sign.
    fn closed<T: ComplexField<RealField = f64>>(&self, factor: &T) -> SMatrix<T, 6, 6> {
        let factor = factor.clone() * T::from_real(self.sigma());
        let mut closed = SMatrix::<T, 6, 6>::identity() * factor - self.map.map(T::from_real);
        if let Some(anchor) = self.system.anchor() {
            anchor_rows(&mut closed, anchor);
        }
        closed
    }

    /// Factor for the determinant of the residual's derivative: the product does not depend on the
    /// choice of the equations for the state (docs/theory.md (112)). 1 unless the system is
    /// anchored.
    pub fn anchor(&self, factor: f64) -> f64 {
        if self.system.anchor().is_some() {
            factor * self.sigma() * self.closed(&factor).determinant()
        } else {
            1.0
        }
    }

    /// The phase of the impact at the end of a flight.
    pub fn arrival(&self, flight: usize) -> f64 {
        arrival(self.word, self.phases, flight)
    }

    /// The flight that ends at impact `index`.
    pub fn flight_to(&self, index: usize) -> usize {
        (index + self.len() - 1) % self.len()
    }

    /// z after an impact.
    pub fn departure(&self, flight: usize) -> &Vector6 {
        if flight == 0 { &self.start } else { &self.after[flight - 1] }
    }

    /// Contact errors at the start and at the end of a flight, units of L; at an orbit they are
    /// only rounding.
    pub fn contact_errors(&self, flight: usize) -> [f64; 2] {
        let off = |z: &Vector6, phase: f64, impact: usize| {
            (Functional::Gap.of(z) + self.system.forced_gap(phase)[0] - self.word.side(impact)).abs()
        };
        let start = off(self.departure(flight), self.phases[flight], flight);
        [start, off(&self.before[flight], self.arrival(flight), flight + 1)]
    }

    /// s w'⁻, the approach speed of impact `index`.
    pub fn speed(&self, index: usize) -> f64 {
        let flight = self.flight_to(index);
        self.word.side(flight + 1) * self.rates[flight]
    }

    /// w'' just before the impact at the end of a flight.
    pub fn approach_acceleration(&self, flight: usize) -> f64 {
        let free = Functional::Rate.of(&self.system.rate(&self.before[flight]));
        free + self.system.forced_gap(self.arrival(flight))[2]
    }

    /// Whether the block stays on its stop after the impact at the start of a flight. Without
    /// restitution it leaves at zero speed, and stays if its acceleration points to the stop.
    pub fn stays(&self, flight: usize) -> bool {
        self.system.flight.kappa == 0.0 && {
            let free = Functional::Rate.of(&self.system.rate(self.departure(flight)));
            let acceleration = free + self.system.forced_gap(self.phases[flight])[2];
            self.word.side(flight) * acceleration > 0.0
        }
    }

    /// Derivative of the state at a later time with respect to an impact's phase, J f⁻ - f⁺
    /// (docs/theory.md (104)).
    fn delay(&self, flight: usize) -> Vector6 {
        let forced = self.system.forced_gap(self.arrival(flight))[2];
        let approach = self.system.rate(&self.before[flight]);
        self.system.flight.delay(&approach, forced, &self.system.rate(&self.after[flight]))
    }

    /// The derivative of a functional at the ends of the flights with respect to the phases,
    /// docs/theory.md (105). The variations close with `factor` times the word's sign: 1 for
    /// variations of the orbit itself, -1 for doubling the period or breaking the symmetry.
    pub fn derivative(&self, functional: Functional, factor: f64) -> Option<DMatrix<f64>> {
        self.derivative_for(functional, factor)
    }

    /// [`derivative`](Self::derivative) of the gap for variations that close with a complex
    /// factor.
    pub fn complex_derivative(&self, factor: Complex<f64>) -> Option<DMatrix<Complex<f64>>> {
        self.derivative_for(Functional::Gap, factor)
    }

    fn derivative_for<T: ComplexField<RealField = f64>>(
        &self,
        functional: Functional,
        factor: T,
    ) -> Option<DMatrix<T>> {
        let n = self.len();
        let (direct, ends) = self.delays(functional);
        let lu = self.closed(&factor).lu();
        let anchor = self.system.anchor();
        let returns = anchor.filter(|_| functional == Functional::Gap).map(Anchor::place);
        let contacts = if returns.is_some() { n - 1 } else { n };
        let mut matrix = direct.map(T::from_real);
        for k in 0..n {
            // The first impact is varied only at the end of the word, where variations have the
            // factor.
            let part = if k == 0 { factor.clone() } else { T::one() };
            let end = ends[k].map(|x| T::from_real(x) * part.clone());
            let mut right = end.clone();
            if let Some(anchor) = anchor {
                let contact = if k == 0 { -self.departure_rate() } else { 0.0 };
                anchor_right(&mut right, anchor, T::from_real(contact));
            }
            let start = lu.solve(&right)?;
            let along = |row: &Vector6| -> T {
                let terms = row.iter().zip(start.iter()).map(|(a, b)| T::from_real(*a) * b.clone());
                terms.fold(T::zero(), |sum, term| sum + term)
            };
            for i in 0..contacts {
                matrix[(i, k)] += along(&self.rows[i][functional as usize]);
            }
            if let Some(place) = returns {
                let begin = factor.clone() * T::from_real(self.sigma()) * start[place].clone();
                matrix[(n - 1, k)] = along(&self.map.row(place).transpose()) + end[place].clone() - begin;
            }
        }
        for i in 0..contacts {
            let own = T::from_real(match functional {
                Functional::Gap => self.rates[i],
                Functional::Rate => self.approach_acceleration(i),
            });
            matrix[(i, (i + 1) % n)] += if i + 1 == n { factor.clone() * own } else { own };
        }
        Some(matrix)
    }

    /// w'⁺ of the first impact, from the state after it.
    fn departure_rate(&self) -> f64 {
        Functional::Rate.of(&self.start) + self.system.forced_gap(self.phases[0])[1]
    }

    /// The direct effect of delaying each impact: on a functional at the ends of the later
    /// flights, and on the state at the end of the word.
    fn delays(&self, functional: Functional) -> (DMatrix<f64>, Vec<Vector6>) {
        let n = self.len();
        let mut direct = DMatrix::zeros(n, n);
        let mut first = self.delay(n - 1);
        if self.system.anchor().is_some() {
            // Before convergence, the state at the end of the word differs from the initial state.
            first += self.system.rate(&self.after[n - 1]) - self.system.rate(&self.start) * self.sigma();
        }
        let mut ends = vec![first];
        for k in 1..n {
            let mut variation = self.delay(k - 1);
            for i in k..n {
                variation = self.transitions[i].apply(&variation);
                direct[(i, k)] = functional.of(&variation);
                variation = self.system.flight.strike(&variation, 0.0);
            }
            ends.push(variation);
        }
        (direct, ends)
    }

    /// The map of variations over one pass of the word, from just after the first impact to just
    /// after the closing impact, with the closing sign: docs/theory.md (106). Its eigenvalues are
    /// the multipliers. Each impact must have a nonzero approach speed.
    pub fn monodromy(&self) -> Matrix6<f64> {
        let mut map = Matrix6::identity();
        for (i, transition) in self.transitions.iter().enumerate() {
            let delay = self.delay(i) / self.rates[i];
            map = mapped(&map, |z| self.system.flight.saltate(&transition.apply(z), &delay));
        }
        map * f64::from(self.word.closing())
    }

    /// M, the map of the free part of the state at fixed phases, docs/theory.md (102).
    #[cfg(test)]
    pub fn map(&self) -> &Matrix6<f64> {
        &self.map
    }

    /// The residual as a vector.
    pub fn residual_vector(&self) -> DVector<f64> {
        DVector::from_column_slice(&self.residual)
    }
}

/// A matrix with a linear map applied to each column.
fn mapped(matrix: &Matrix6<f64>, map: impl Fn(&Vector6) -> Vector6) -> Matrix6<f64> {
    Matrix6::from_columns(&[0, 1, 2, 3, 4, 5].map(|i| map(&matrix.column(i).into())))
}

/// The solution of six linear equations; `None` if the matrix is singular within rounding.
fn solve(matrix: &Matrix6<f64>, right: &Vector6) -> Option<Vector6> {
    let lu = matrix.lu();
    let diagonal = lu.lu_internal().diagonal();
    let (least, most) =
        diagonal.iter().fold((f64::INFINITY, 0.0_f64), |(a, b), x| (a.min(x.abs()), b.max(x.abs())));
    // False for NaN too.
    if least > REGULAR * most { lu.solve(right) } else { None }
}
