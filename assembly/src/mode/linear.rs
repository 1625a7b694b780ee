//! The linear system of a mode, z' = A z, with the functionals that end it (docs/assembly-law.md (A5)).

use super::{Contact, FrictionState, Mode, StopState, Watch};
use crate::kernel::SparseMatrix;
use crate::law::ZERO;
use crate::law::box_qp::triangle;
use crate::system::{Functional, Row, System};
use nalgebra::{DMatrix, DVector};

/// The linear system of a mode.
#[derive(Clone, Debug)]
pub struct Linear {
    /// z' = A z.
    pub a: SparseMatrix,
    /// By entry of A the sizes of the terms that it is the sum of: what a closed stop cancels leaves rounding of these.
    pub terms: SparseMatrix,
    /// The forces of the basis, by its order.
    pub lambda: Vec<Row>,
    /// The upper triangle R with RᵀR = WᵀM⁻¹W of the basis.
    pub triangle: DMatrix<f64>,
    /// What ends the mode, each negative inside it.
    pub watched: Vec<(Watch, Row)>,
    /// The forces of the compliant stops that press, where there are such and no contacts.
    pub buffers: Option<Buffers>,
}

/// The forces of compliant stops apart from the rest of a mode's system: A = rest - Σ by ⊗ force.
#[derive(Clone, Debug)]
pub struct Buffers {
    /// A without them.
    pub rest: SparseMatrix,
    /// The forces, and what a unit of each takes from z'.
    pub forces: Vec<(Functional, Row)>,
}

impl System {
    /// The linear system of a mode.
    pub fn linear(&self, mode: &Mode) -> Linear {
        let (n, size) = (self.coordinates, self.signals.size);
        let mut acceleration = self.free_acceleration(&mode.stops, &mode.frictions);
        let mut acceleration_terms = acceleration.abs();
        let m = mode.basis.len();
        let mut lambda = Vec::new();
        let columns = self.columns(&mode.basis);
        let r = triangle(&columns);
        if m > 0 {
            let mut demand = DMatrix::zeros(m, size); // e'' without contact forces
            for (k, &contact) in mode.basis.iter().enumerate() {
                let e = self.elongation_of(contact);
                let row = acceleration.tr_mul(&e.w) + &e.drift;
                demand.set_row(k, &row.transpose());
            }
            let sizes = demand.abs();
            r.tr_solve_upper_triangular_mut(&mut demand);
            r.solve_upper_triangular_mut(&mut demand);
            clean(&mut demand, &columns, &sizes);
            let mut directions = DMatrix::zeros(n, m);
            for (k, &contact) in mode.basis.iter().enumerate() {
                directions.set_column(k, &self.elongation_of(contact).w);
                lambda.push(demand.row(k).transpose());
            }
            let mobility = self.inertia.solve(&directions);
            acceleration_terms += mobility.abs() * demand.abs();
            acceleration -= mobility * &demand;
        }
        let buffers = if m == 0 { self.buffers(mode) } else { None };
        Linear {
            a: self.matrix(&acceleration),
            terms: self.matrix(&acceleration_terms).abs(),
            watched: self.watched(mode, &lambda),
            lambda,
            triangle: r,
            buffers,
        }
    }

    /// The matrix of a mode with these accelerations.
    fn matrix(&self, acceleration: &DMatrix<f64>) -> SparseMatrix {
        let (n, size) = (self.coordinates, self.signals.size);
        let mut a = SparseMatrix::default();
        (0..n).for_each(|k| a.push_row(std::iter::once((n + k, 1.0))));
        (0..n).for_each(|k| a.push_row((0..size).map(|j| (j, acceleration[(k, j)]))));
        let mut unit = Row::zeros(size);
        for j in self.signals.one..size {
            unit[j] = 1.0;
            a.push_row(self.signals.derivative(&unit).iter().copied().enumerate());
            unit[j] = 0.0;
        }
        a
    }

    /// The compliant stops that press in a mode without contacts.
    fn buffers(&self, mode: &Mode) -> Option<Buffers> {
        let (n, size) = (self.coordinates, self.signals.size);
        let mut left = mode.stops.clone();
        let mut forces = Vec::new();
        for (i, state) in left.iter_mut().enumerate() {
            let Some(force) = self.stop_force(i, *state) else { continue };
            let mut by = Row::zeros(size);
            by.rows_mut(n, n).copy_from(&self.stops[i].elongation.mobility);
            forces.push((Functional::of(force), by));
            *state = StopState::Below;
        }
        if forces.is_empty() {
            return None;
        }
        let rest = self.free_acceleration(&left, &mode.frictions);
        Some(Buffers { rest: self.matrix(&rest), forces })
    }

    /// The functionals that end a mode.
    fn watched(&self, mode: &Mode, lambda: &[Row]) -> Vec<(Watch, Row)> {
        let mut watched = Vec::new();
        for (i, &state) in mode.stops.iter().enumerate() {
            let stop = &self.stops[i];
            let damped = stop.force != stop.spring;
            match state {
                StopState::Open => watched.push((Watch::Meets(i), (*stop.excess).clone())),
                StopState::Closed => {}
                StopState::Below => watched.push((Watch::Presses(i), (*stop.excess).clone())),
                StopState::Pressed => {
                    watched.push((Watch::Changes(i), -&*stop.force));
                    if stop.is_elastogap() && damped {
                        watched.push((Watch::Changes(i), &*stop.force - 2.0 * &*stop.spring));
                    }
                }
                StopState::Free => {
                    watched.push((Watch::Changes(i), (*stop.force).clone()));
                    watched.push((Watch::Leaves(i), -&*stop.excess));
                }
                StopState::Capped => {
                    watched.push((Watch::Changes(i), 2.0 * &*stop.spring - &*stop.force));
                    watched.push((Watch::Leaves(i), -&*stop.excess));
                }
            }
        }
        for (i, (&state, friction)) in mode.frictions.iter().zip(&self.frictions).enumerate() {
            match state {
                FrictionState::Off => watched.push((Watch::Level(i), friction.level.clone())),
                FrictionState::Up | FrictionState::Down => {
                    watched.push((Watch::Stops(i), -state.direction() * &*friction.elongation.rate));
                    watched.push((Watch::Level(i), -&friction.level));
                }
                FrictionState::Stuck | FrictionState::HeldUp | FrictionState::HeldDown => {
                    watched.push((Watch::Level(i), -&friction.level));
                }
            }
        }
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
        // What never changes needs no watch: a level that is a positive constant, say.
        watched.retain(|(_, row)| !self.is_constant_and_negative(row));
        watched
    }

    fn is_constant_and_negative(&self, row: &DVector<f64>) -> bool {
        let one = self.signals.one;
        row[one] < 0.0 && row.iter().enumerate().all(|(j, &x)| j == one || x == 0.0)
    }
}

/// Takes the rounding out of the forces' rows, so that a force that is zero throughout is known to be: `demands` are the sizes of
/// what each contact has to hold against. A contact's force is at most of the size of what contacts that share coordinates with
/// it, directly or through others, hold against.
fn clean(forces: &mut DMatrix<f64>, columns: &DMatrix<f64>, demands: &DMatrix<f64>) {
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
