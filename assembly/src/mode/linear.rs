//! The linear system z' = A z of a mode and the functionals that end it (docs/assembly-law.md
//! (A5)).

use super::{Contact, FrictionState, Mode, StopState, Watch};
use crate::flow::DENSE;
use crate::kernel::SparseMatrix;
use crate::law::ZERO;
use crate::law::box_qp::triangle;
use crate::system::{Elongation, Functional, StateRow, System};
use nalgebra::{DMatrix, DVector};

/// The linear system of a mode.
#[derive(Clone, Debug)]
pub struct Linear {
    /// z' = A z.
    pub a: SparseMatrix,
    /// By entry of A: the sum of the sizes of its terms, whose rounding remains where a closed stop
    /// cancels them.
    pub terms: SparseMatrix,
    /// Contact forces of the basis, in its order, as rows.
    pub lambda: Vec<StateRow>,
    /// The upper triangle R with RᵀR = WᵀM⁻¹W of the basis.
    pub triangle: DMatrix<f64>,
    /// The functionals that end the mode, each negative inside it.
    pub watched: Vec<(Watch, StateRow)>,
    /// Elastic forces that may be computed separately.
    pub elastic: Option<Elastic>,
    /// Absolute values of the projection of velocities past the contacts, where there are contacts.
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
    /// The forces, each with what a unit of it takes from z'.
    pub forces: Vec<(Functional, StateRow)>,
    /// With stored matrices: whether a force ties a group that much softer forces move. Where this
    /// is false, the forces may still be what makes the mode fast.
    pub are_stiff: bool,
}

/// The contacts of a mode's basis.
struct Held<'a> {
    elongations: Vec<&'a Elongation>,
    /// L⁻¹ w of each.
    columns: DMatrix<f64>,
    /// The upper triangle R with RᵀR = WᵀM⁻¹W.
    triangle: DMatrix<f64>,
    /// M⁻¹ w of each.
    mobility: DMatrix<f64>,
    /// The projection of velocities and accelerations past the contacts, 1 - M⁻¹ W G⁻¹ Wᵀ, with
    /// rounding replaced by zero.
    loose: DMatrix<f64>,
}

impl<'a> Held<'a> {
    fn new(system: &'a System, basis: &[Contact]) -> Self {
        let elongations: Vec<_> = basis.iter().map(|&contact| system.elongation_of(contact)).collect();
        let columns = system.columns(basis);
        let triangle = triangle(&columns);
        let n = system.coordinates;
        if basis.is_empty() {
            let [mobility, loose] = [0, 0].map(|_| DMatrix::zeros(0, 0));
            return Self { elongations, columns, triangle, mobility, loose };
        }
        let mut directions = DMatrix::zeros(n, basis.len());
        elongations.iter().enumerate().for_each(|(k, e)| directions.set_column(k, &e.w));
        let mobility = system.inertia.solve(&directions);
        let mut shares = directions.transpose();
        triangle.tr_solve_upper_triangular_mut(&mut shares);
        triangle.solve_upper_triangular_mut(&mut shares);
        let one = DMatrix::identity(n, n);
        let sizes = &one + mobility.abs() * shares.abs();
        let left = one - &mobility * shares;
        let loose = left.zip_map(&sizes, |x, size| if x.abs() <= ZERO * size { 0.0 } else { x });
        Self { elongations, columns, triangle, mobility, loose }
    }

    /// Absolute values of [`loose`](Self::loose).
    fn loose_sizes(&self) -> SparseMatrix {
        let mut sizes = SparseMatrix::default();
        for row in self.loose.row_iter() {
            sizes.push_row(row.iter().map(|x| x.abs()).enumerate());
        }
        sizes
    }

    /// Subtracts the effect of the contacts' forces from accelerations. Coordinates that contacts
    /// hold completely move as prescribed bodies require, without rounding of the forces that
    /// cancel.
    fn hold(&self, system: &System, acceleration: &mut DMatrix<f64>, demand: &DMatrix<f64>) {
        *acceleration -= &self.mobility * demand;
        let held = |k: &usize| self.loose.row(*k).iter().all(|x| *x == 0.0);
        let held: Vec<usize> = (0..system.coordinates).filter(held).collect();
        if !held.is_empty() {
            let prescribed = self.demand(system, &DMatrix::zeros(system.coordinates, system.signals.size));
            for k in held {
                acceleration.set_row(k, &-(self.mobility.row(k) * &prescribed));
            }
        }
    }

    /// The contacts' forces, one row each, that keep e'' at zero against accelerations without
    /// them.
    fn demand(&self, system: &System, acceleration: &DMatrix<f64>) -> DMatrix<f64> {
        let mut demand = DMatrix::zeros(self.elongations.len(), system.signals.size); // e'' without contact forces
        let mut sizes = demand.clone();
        for (k, e) in self.elongations.iter().enumerate() {
            let row = acceleration.tr_mul(&e.w) + &e.drift;
            demand.set_row(k, &row.transpose());
            // Sizes of the terms: their sum may be rounding, as of bodies in free fall.
            let terms = acceleration.abs().tr_mul(&e.w.abs()) + e.drift.abs();
            sizes.set_row(k, &terms.transpose());
        }
        self.triangle.tr_solve_upper_triangular_mut(&mut demand);
        self.triangle.solve_upper_triangular_mut(&mut demand);
        zero_rounding(&mut demand, &self.columns, &sizes);
        demand
    }

    /// What a unit of an element's force takes from v', with the contacts' reaction: `loose` M⁻¹ w,
    /// with rounding replaced by zero.
    fn moved(&self, e: &Elongation) -> DVector<f64> {
        if self.elongations.is_empty() {
            return e.mobility.clone();
        }
        let sizes = self.loose.abs() * e.mobility.abs();
        (&self.loose * &e.mobility).zip_map(&sizes, |x, size| if x.abs() <= ZERO * size { 0.0 } else { x })
    }
}

impl System {
    /// The linear system of a mode.
    pub fn linear(&self, mode: &Mode) -> Linear {
        let mut acceleration = self.free_acceleration(&mode.stops, &mode.frictions);
        let (mut lambda, mut terms) = (Vec::new(), None);
        let held = Held::new(self, &mode.basis);
        if !mode.basis.is_empty() {
            let demand = held.demand(self, &acceleration);
            terms = Some(self.matrix(&(acceleration.abs() + held.mobility.abs() * demand.abs())));
            held.hold(self, &mut acceleration, &demand);
            lambda.extend(demand.row_iter().map(|row| row.transpose()));
        }
        let a = self.matrix(&acceleration);
        Linear {
            terms: terms.as_ref().unwrap_or(&a).abs(),
            a,
            watched: self.watched(mode, &lambda),
            lambda,
            elastic: self.elastic(mode, &held),
            loose: (!mode.basis.is_empty()).then(|| held.loose_sizes()),
            triangle: held.triangle,
        }
    }

    /// The matrix A with these rows of accelerations.
    fn matrix(&self, acceleration: &DMatrix<f64>) -> SparseMatrix {
        let (n, size) = (self.coordinates, self.signals.size);
        let mut a = SparseMatrix::default();
        (0..n).for_each(|k| a.push_row(std::iter::once((n + k, 1.0))));
        (0..n).for_each(|k| a.push_row((0..size).map(|j| (j, acceleration[(k, j)]))));
        self.signals.rates().iter().for_each(|row| a.push_row(row.terms().iter().copied()));
        a
    }

    /// The elastic forces of a mode that may be computed separately: those of stiff springs and of
    /// compliant stops that act.
    fn elastic(&self, mode: &Mode, held: &Held) -> Option<Elastic> {
        let mut forces = Vec::new();
        let mut put = |force: StateRow, e: &Elongation| {
            let mut by = StateRow::zeros(self.signals.size);
            by.rows_mut(self.coordinates, self.coordinates).copy_from(&held.moved(e));
            forces.push((Functional::of(force), by));
        };
        for &i in &self.stiff_springs {
            put(self.springs[i].force.clone(), &self.springs[i].elongation);
        }
        let (mut left, mut pressed) = (mode.stops.clone(), Vec::new());
        for (i, state) in left.iter_mut().enumerate() {
            if let Some(force) = self.stop_force(i, *state) {
                put(force, &self.stops[i].elongation);
                *state = StopState::Below;
                pressed.push(i);
            }
        }
        if forces.is_empty() {
            return None;
        }
        let mut rest = self.accelerations(self.soft_forces(), &left, &mode.frictions);
        let mut rest_terms = None;
        if !mode.basis.is_empty() {
            let demand = held.demand(self, &rest);
            rest_terms = Some(self.matrix(&(rest.abs() + held.mobility.abs() * demand.abs())).abs());
            held.hold(self, &mut rest, &demand);
        }
        let are_stiff = || !self.stiff_springs.is_empty() || !self.stiff_ties(&pressed).is_empty();
        let is_small = self.signals.size <= DENSE;
        Some(Elastic { rest: self.matrix(&rest), rest_terms, forces, are_stiff: is_small && are_stiff() })
    }

    /// The functionals that end a mode, each negative inside it.
    fn watched(&self, mode: &Mode, lambda: &[StateRow]) -> Vec<(Watch, StateRow)> {
        let stops = mode.stops.iter().enumerate().flat_map(|(i, &state)| self.watched_of_stop(i, state));
        let frictions = mode.frictions.iter().enumerate();
        let frictions = frictions.flat_map(|(i, &state)| self.watched_of_friction(i, state));
        let mut watched: Vec<(Watch, StateRow)> = stops.chain(frictions).collect();
        for (&contact, force) in mode.basis.iter().zip(lambda) {
            match contact {
                Contact::Stop(i) => watched.push((Watch::Opens(i), -force)),
                Contact::Friction(i) => {
                    let level = &self.frictions[i].static_level;
                    watched.push((Watch::Slips(i, true), force - level));
                    watched.push((Watch::Slips(i, false), -force - level));
                }
            }
        }
        // A negative constant, such as that of a constant friction level, needs no watch.
        watched.retain(|(_, row)| !self.is_constant_and_negative(row));
        watched
    }

    /// What is watched of a stop in a state, but for the force of a closed one.
    pub(crate) fn watched_of_stop(&self, i: usize, state: StopState) -> Vec<(Watch, StateRow)> {
        let stop = &self.stops[i];
        let damped = stop.force != stop.spring;
        match state {
            StopState::Open => vec![(Watch::Meets(i), (*stop.excess).clone())],
            StopState::Closed => Vec::new(),
            StopState::Below => vec![(Watch::Presses(i), (*stop.excess).clone())],
            StopState::Pressed => {
                let cap = (stop.is_elastogap() && damped)
                    .then(|| (Watch::Changes(i), &*stop.force - 2.0 * &*stop.spring));
                std::iter::once((Watch::Changes(i), -&*stop.force)).chain(cap).collect()
            }
            StopState::Free => {
                vec![(Watch::Changes(i), (*stop.force).clone()), (Watch::Leaves(i), -&*stop.excess)]
            }
            StopState::Capped => vec![
                (Watch::Changes(i), 2.0 * &*stop.spring - &*stop.force),
                (Watch::Leaves(i), -&*stop.excess),
            ],
        }
    }

    /// What is watched of a friction in a state, but for the force of one that sticks.
    pub(crate) fn watched_of_friction(&self, i: usize, state: FrictionState) -> Vec<(Watch, StateRow)> {
        let friction = &self.frictions[i];
        match state {
            FrictionState::Off => vec![(Watch::Level(i), friction.level.clone())],
            FrictionState::Up | FrictionState::Down => vec![
                (Watch::Stops(i), -state.direction() * &*friction.elongation.rate),
                (Watch::Level(i), -&friction.level),
            ],
            FrictionState::Stuck | FrictionState::HeldUp | FrictionState::HeldDown => {
                vec![(Watch::Level(i), -&friction.level)]
            }
        }
    }

    /// A of the mode in which nothing is pressed, slips or is held, but for stiff springs.
    pub(crate) fn base(&self) -> SparseMatrix {
        self.matrix(&self.accelerations(self.soft_forces(), &[], &[]))
    }

    pub(crate) fn is_constant_and_negative(&self, row: &DVector<f64>) -> bool {
        let one = self.signals.one;
        row[one] < 0.0 && row.iter().enumerate().all(|(j, &x)| j == one || x == 0.0)
    }
}

/// Replaces rounding in the rows of contact forces by zero, so that a force that vanishes
/// throughout is known to vanish. `demands` are by contact the sizes of what it holds against. A
/// contact's force is at most of the size that contacts hold against which share coordinates with
/// it, directly or through others.
fn zero_rounding(forces: &mut DMatrix<f64>, columns: &DMatrix<f64>, demands: &DMatrix<f64>) {
    let (m, size) = forces.shape();
    let norms: Vec<f64> = columns.column_iter().map(|c| c.norm().max(f64::MIN_POSITIVE)).collect();
    let shares = |i: usize, j: usize| columns.column(i).abs().dot(&columns.column(j).abs()) > 0.0;
    let mut group: Vec<usize> = (0..m).collect();
    for i in 0..m {
        for j in 0..i {
            if group[i] != group[j] && shares(i, j) {
                let (from, to) = (group[i], group[j]);
                group.iter_mut().filter(|g| **g == from).for_each(|g| *g = to);
            }
        }
    }
    for column in 0..size {
        for k in 0..m {
            let others = (0..m).filter(|&i| group[i] == group[k]);
            let largest = others.map(|i| demands[(i, column)] / norms[i]).fold(0.0, f64::max);
            if forces[(k, column)].abs() <= ZERO * largest / norms[k] {
                forces[(k, column)] = 0.0;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn closed_form_a_force_is_rounding_beside_what_its_group_holds_against() {
        // The first two contacts share a coordinate, the third has its own. Columns of demands: 1
        // at the first contact, which counts for the second by 1/√2 and not for the third; 1 at the
        // third, whose column has length 2; none.
        let columns = DMatrix::from_row_slice(3, 3, &[1.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 0.0, 2.0]);
        let demands = DMatrix::from_row_slice(3, 3, &[1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0]);
        let (small, more) = (0.2 * ZERO, 0.8 * ZERO);
        for (second, is_rounding) in [(small, true), (more, false)] {
            let forces = [0.5, small, small, second, small, small, small, small, small];
            let mut cleaned = DMatrix::from_row_slice(3, 3, &forces);
            zero_rounding(&mut cleaned, &columns, &demands);
            let kept = if is_rounding { 0.0 } else { second };
            let exact = [0.5, small, small, kept, small, small, small, 0.0, small];
            assert_eq!(cleaned, DMatrix::from_row_slice(3, 3, &exact));
        }
    }
}
