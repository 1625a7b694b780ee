//! The derivative of a mode by each parameter: of A in z' = A z, of contact forces and of watched
//! functionals (docs/assembly-law.md (A29)).

use super::flight::Rung;
use super::tangent::Tangent;
use crate::flow::{LEAST_RATE, Ladder, RADIUS, rate_bound};
use crate::kernel::{Sparse, SparseMatrix};
use crate::law::box_qp::triangle;
use crate::mode::{Contact, Linear, Mode, StopState, Watch};
use crate::system::{StateRow, System};
use nalgebra::{DMatrix, DVector};

/// A row with its derivative by each parameter.
pub(super) struct VariedRow {
    pub row: StateRow,
    pub by: Vec<StateRow>,
}

/// What one parameter changes in a mode.
pub(super) struct InMode {
    /// Rows of the derivative of A that are not zero, by place.
    pub a: Vec<(usize, Sparse)>,
    /// Derivatives of the forces of the mode's basis.
    pub lambda: Vec<StateRow>,
}

/// A mode with its derivatives by all parameters.
pub(super) struct VariedMode {
    pub mode: Mode,
    /// A of z' = A z.
    pub a: SparseMatrix,
    /// The longest time of one power series, s.
    pub length: f64,
    /// Forces of the basis.
    pub lambda: Vec<StateRow>,
    pub watched: Vec<(Watch, StateRow)>,
    /// The upper triangle R with RᵀR = WᵀM⁻¹W of the basis.
    pub triangle: DMatrix<f64>,
    /// By parameter.
    pub by: Vec<InMode>,
    /// Flights over 2^k parts of `length`, made on first use.
    pub flights: Ladder<Rung>,
}

/// The contacts of a basis: directions, what unit forces do, and the triangle R with RᵀR = G.
struct Held {
    directions: DMatrix<f64>,
    mobility: DMatrix<f64>,
    triangle: DMatrix<f64>,
}

impl VariedMode {
    pub fn new(system: &System, tangents: &[Tangent], mode: &Mode) -> Self {
        let Linear { a, lambda, watched, .. } = system.linear(mode);
        let length = RADIUS / rate_bound(&a, system.signals.one).max(LEAST_RATE);
        let (n, size) = (system.coordinates, system.signals.size);
        let dense = |row: &Sparse| StateRow::from_vec(row.dense(size));
        let lambda: Vec<StateRow> = lambda.iter().map(dense).collect();
        let watched = watched.into_iter().map(|(watch, row)| (watch, dense(&row))).collect();
        let mut acceleration = DMatrix::zeros(n, size);
        for k in 0..n {
            a.row(n + k).iter().for_each(|&(j, x)| acceleration[(k, j)] = x);
        }
        let mut directions = DMatrix::zeros(n, mode.basis.len());
        for (k, &contact) in mode.basis.iter().enumerate() {
            directions.set_column(k, &system.elongation_of(contact).w);
        }
        let mobility = system.inertia.solve(&directions);
        let held = Held { directions, mobility, triangle: triangle(&system.columns(&mode.basis)) };
        let by = tangents.iter().map(|tangent| held.vary(system, tangent, mode, &acceleration, &lambda));
        let by = by.collect();
        let triangle = held.triangle;
        Self { mode: mode.clone(), a, length, lambda, watched, triangle, by, flights: Ladder::default() }
    }

    /// z' at a state.
    pub fn rates(&self, z: &DVector<f64>) -> DVector<f64> {
        self.a.rows_times(0..z.len(), z.as_slice())
    }

    /// The derivative of z' at a state and its derivative `delta` by parameter `p`.
    pub fn rates_by(&self, p: usize, z: &DVector<f64>, delta: &DVector<f64>) -> DVector<f64> {
        let mut rates = self.rates(delta);
        self.by[p].a.iter().for_each(|(i, row)| rates[*i] += row.dot(z.as_slice()));
        rates
    }

    /// The functionals of a watch, each with its derivatives.
    pub fn varied(&self, system: &System, tangents: &[Tangent], watch: Watch) -> Vec<VariedRow> {
        let own = self.watched.iter().filter(|(own, _)| *own == watch);
        let vary = |(_, row): &(Watch, StateRow)| VariedRow {
            row: row.clone(),
            by: (0..tangents.len()).map(|p| self.row_by(system, &tangents[p], p, watch, row)).collect(),
        };
        own.map(vary).collect()
    }

    /// The derivative of a watched functional by parameter `p`.
    pub fn row_by(
        &self,
        system: &System,
        tangent: &Tangent,
        p: usize,
        watch: Watch,
        row: &StateRow,
    ) -> StateRow {
        let force = |contact: Contact| {
            let place = self.mode.basis.iter().position(|&c| c == contact);
            place.map_or_else(|| StateRow::zeros(row.len()), |k| self.by[p].lambda[k].clone())
        };
        match watch {
            Watch::Meets(i) | Watch::Presses(i) => tangent.stops[i].excess.clone(),
            Watch::Leaves(i) => -&tangent.stops[i].excess,
            Watch::Opens(i) => -force(Contact::Stop(i)),
            Watch::Changes(i) => {
                let (stop, by) = (&system.stops[i], &tangent.stops[i]);
                let cap = &by.force - 2.0 * &by.spring;
                match self.mode.stops[i] {
                    StopState::Free => by.force.clone(),
                    StopState::Capped => -cap,
                    _ if *row == -&*stop.force => -&by.force,
                    _ => cap,
                }
            }
            Watch::Stops(i) => -self.mode.frictions[i].direction() * &tangent.frictions[i].elongation.rate,
            Watch::Slips(i, up) => {
                let sign = if up { 1.0 } else { -1.0 };
                sign * force(Contact::Friction(i)) - &tangent.frictions[i].static_level
            }
            Watch::Level(i) => {
                let off = self.mode.frictions[i] == crate::mode::FrictionState::Off;
                if off { tangent.frictions[i].level.clone() } else { -&tangent.frictions[i].level }
            }
        }
    }
}

impl Held {
    /// The derivatives of accelerations a and contact forces λ, by differentiating
    /// M a + W λ = F z and Wᵀ a + drift z = 0.
    fn vary(
        &self,
        system: &System,
        tangent: &Tangent,
        mode: &Mode,
        acceleration: &DMatrix<f64>,
        lambda: &[StateRow],
    ) -> InMode {
        let mut forces = tangent.forces_in(system, mode);
        if tangent.mass.amax() > 0.0 {
            forces -= &tangent.mass * acceleration;
        }
        let elongation = |contact: Contact| match contact {
            Contact::Stop(i) => &tangent.stops[i].elongation,
            Contact::Friction(i) => &tangent.frictions[i].elongation,
        };
        for (&contact, force) in mode.basis.iter().zip(lambda) {
            forces.ger(-1.0, &elongation(contact).w, force, 1.0);
        }
        let mut change = system.inertia.solve(&forces);
        let mut lambda = Vec::new();
        if !mode.basis.is_empty() {
            let mut demand = self.directions.tr_mul(&change);
            for (k, &contact) in mode.basis.iter().enumerate() {
                let own = elongation(contact);
                let row = acceleration.tr_mul(&own.w) + &own.drift;
                let mut to = demand.row_mut(k);
                to += row.transpose();
            }
            self.triangle.tr_solve_upper_triangular_mut(&mut demand);
            self.triangle.solve_upper_triangular_mut(&mut demand);
            change -= &self.mobility * &demand;
            lambda.extend(demand.row_iter().map(|row| row.transpose()));
        }
        let n = system.coordinates;
        let rows = change.row_iter().enumerate();
        let rows = rows.map(|(k, row)| (n + k, Sparse::of(row.transpose().as_slice())));
        let signals = tangent.signals.rates().map(|(i, term)| (i, Sparse::from_terms(std::iter::once(term))));
        let a = rows.filter(|(_, row)| !row.terms().is_empty()).chain(signals).collect();
        InMode { a, lambda }
    }
}
