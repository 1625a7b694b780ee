//! The derivative of a quantity with respect to all rows and matrices of a machine; its derivative
//! by any column follows from them (docs/assembly-law.md (A40)).

use super::columns::padded;
use super::mode::VariedMode;
use super::rows::{
    BodyTangent, BranchTangent, ElongationTangent, FrictionTangent, LevelTangent, StopTangent,
};
use super::tangent::Tangent;
use crate::functional::StateRow;
use crate::mode::{Contact, FrictionState, StopState, Watch};
use crate::system::{FrictionRows, System};
use nalgebra::{DMatrix, DVector};

/// Derivatives by each number of a machine's rows and matrices, laid out as a [`Tangent`].
pub(super) struct Weights {
    mass: DMatrix<f64>,
    forces: DMatrix<f64>,
    pub bodies: Vec<BodyTangent>,
    pub springs: Vec<(ElongationTangent, StateRow)>,
    pub stops: Vec<StopTangent>,
    pub frictions: Vec<FrictionTangent>,
    pub branches: Vec<BranchTangent>,
    pub loads: Vec<StateRow>,
    /// Derivatives by the signals' rows of A.
    signals: DMatrix<f64>,
}

/// Derivatives by the rows of one mode: the rows of A after the rates, and the basis's forces.
pub(super) struct InMode {
    pub a: DMatrix<f64>,
    /// Contributions of flights to `a`: a padded vector for each coordinate of z.
    pub sums: Vec<f64>,
    pub lambda: Vec<StateRow>,
}

impl InMode {
    pub fn zeros(system: &System, mode: &VariedMode) -> Self {
        let size = system.signals.size;
        Self {
            a: DMatrix::zeros(size - system.coordinates, size),
            sums: vec![0.0; size * padded(size)],
            lambda: vec![StateRow::zeros(size); mode.mode.basis.len()],
        }
    }

    /// Returns the derivative by A, including the contributions of flights.
    fn by_a(&self) -> DMatrix<f64> {
        let (mut a, size) = (self.a.clone(), self.a.ncols());
        let first = size - a.nrows();
        for (mut column, sums) in a.column_iter_mut().zip(self.sums.chunks_exact(padded(size))) {
            column.iter_mut().zip(&sums[first..size]).for_each(|(a, sum)| *a += sum);
        }
        a
    }

    /// Adds `factor` × `row` to the derivative by the force of a contact.
    fn add_force(&mut self, mode: &VariedMode, contact: Contact, factor: f64, row: &StateRow) {
        if let Some(k) = mode.mode.basis.iter().position(|&c| c == contact) {
            self.lambda[k].axpy(factor, row, 1.0);
        }
    }
}

impl Weights {
    pub fn zeros(system: &System) -> Self {
        let (n, size) = (system.coordinates, system.signals.size);
        let (row, w) = (StateRow::zeros(size), DVector::zeros(n));
        let e = ElongationTangent { e: row.clone(), rate: row.clone(), w: w.clone(), drift: row.clone() };
        let stop = StopTangent {
            elongation: e.clone(),
            excess: row.clone(),
            force: row.clone(),
            spring: row.clone(),
            restitution: 0.0,
            release: None,
        };
        let level = LevelTangent { level: row.clone(), static_level: row.clone() };
        let friction = |own: &FrictionRows| FrictionTangent {
            elongation: e.clone(),
            levels: vec![level.clone(); own.levels.len()],
        };
        let frictions = system.frictions.iter().map(friction).collect();
        let branch = BranchTangent {
            elongation: e.clone(),
            force: row.clone(),
            rate: row.clone(),
            level: row.clone(),
            sliding: row.clone(),
            slaved: None,
        };
        let body = BodyTangent { s: row.clone(), v: row.clone(), weights: w, drift: row.clone() };
        Self {
            mass: DMatrix::zeros(n, n),
            forces: DMatrix::zeros(n, size),
            bodies: vec![body; system.bodies.len()],
            springs: vec![(e, row.clone()); system.springs.len()],
            stops: vec![stop; system.stops.len()],
            frictions,
            branches: vec![branch; system.branches.len()],
            loads: vec![row; system.loads.len()],
            signals: DMatrix::zeros(size - system.signals.one, size),
        }
    }

    fn elongation(&mut self, contact: Contact) -> &mut ElongationTangent {
        match contact {
            Contact::Stop(i) => &mut self.stops[i].elongation,
            Contact::Friction(i) => &mut self.frictions[i].elongation,
            Contact::Slider(i) => &mut self.branches[i].elongation,
        }
    }

    /// Adds `factor` × `row` to the derivative by the row that a held contact keeps at zero.
    pub fn add_held(&mut self, contact: Contact, rates: bool, factor: f64, row: &StateRow) {
        match contact {
            Contact::Stop(i) if !rates => self.stops[i].excess.axpy(factor, row, 1.0),
            _ => self.elongation(contact).rate.axpy(factor, row, 1.0),
        }
    }

    /// Adds -κ P of an impulse to the derivative by a stop's direction, with κ = `kick`.
    pub fn add_direction(&mut self, stop: usize, impulse: f64, kick: &DVector<f64>) {
        self.stops[stop].elongation.w.axpy(-impulse, kick, 1.0);
    }

    /// Adds κ (M⁻¹ W P)ᵀ to the derivative by the inertia matrix.
    pub fn add_mass(&mut self, kick: &DVector<f64>, moved: &DVector<f64>) {
        self.mass.ger(1.0, kick, moved, 1.0);
    }

    /// Adds `factor` × `row` to the derivative by the force of a compliant stop in a state.
    pub fn add_stop_force(&mut self, i: usize, state: StopState, factor: f64, row: &StateRow) {
        match state {
            StopState::Pressed => self.stops[i].force.axpy(factor, row, 1.0),
            StopState::Capped => self.stops[i].spring.axpy(2.0 * factor, row, 1.0),
            StopState::Rebounding => self.stops[i].spring.axpy(factor, row, 1.0),
            _ => {}
        }
    }

    pub fn add_friction_force(
        &mut self,
        (i, levels): (usize, Option<usize>),
        state: FrictionState,
        factor: f64,
        row: &StateRow,
    ) {
        let Some(levels) = levels else { return };
        let own = &mut self.frictions[i].levels[levels];
        match state {
            FrictionState::Up => own.level.axpy(factor, row, 1.0),
            FrictionState::Down => own.level.axpy(-factor, row, 1.0),
            FrictionState::HeldUp => own.static_level.axpy(factor, row, 1.0),
            FrictionState::HeldDown => own.static_level.axpy(-factor, row, 1.0),
            FrictionState::Off | FrictionState::Stuck => {}
        }
    }

    /// Adds `factor` × `z` to the derivative by an event function of a mode.
    pub fn add_watched(
        &mut self,
        system: &System,
        (mode, own): (&VariedMode, &mut InMode),
        (watch, row): (Watch, &StateRow),
        (factor, z): (f64, &StateRow),
    ) {
        match watch {
            Watch::Meets(i) | Watch::Presses(i) => self.stops[i].excess.axpy(factor, z, 1.0),
            Watch::Leaves(i) => self.stops[i].excess.axpy(-factor, z, 1.0),
            Watch::Opens(i) => own.add_force(mode, Contact::Stop(i), -factor, z),
            Watch::Changes(i) => {
                let (force, spring) = match mode.mode.stops[i] {
                    StopState::Free => (factor, 0.0),
                    StopState::Capped => (-factor, 2.0 * factor),
                    _ if *row == -&*system.stops[i].force => (-factor, 0.0),
                    _ => (factor, -2.0 * factor),
                };
                self.stops[i].force.axpy(force, z, 1.0);
                self.stops[i].spring.axpy(spring, z, 1.0);
            }
            Watch::Turns(i) => {
                let factor = if mode.mode.stops[i] == StopState::Rebounding { factor } else { -factor };
                self.stops[i].elongation.rate.axpy(factor, z, 1.0);
            }
            Watch::Stops(i) => {
                let factor = -mode.mode.frictions[i].direction() * factor;
                self.frictions[i].elongation.rate.axpy(factor, z, 1.0);
            }
            Watch::Slips(i, up) => {
                own.add_force(mode, Contact::Friction(i), if up { factor } else { -factor }, z);
                if let Some(levels) = system.frictions[i].place(&mode.mode.stops) {
                    self.frictions[i].levels[levels].static_level.axpy(-factor, z, 1.0);
                }
            }
            Watch::Yields(i, up) => {
                let own = &mut self.branches[i];
                own.force.axpy(if up { factor } else { -factor }, z, 1.0);
                own.level.axpy(-factor, z, 1.0);
            }
            Watch::Reverses(i) => {
                let own = &mut self.branches[i];
                own.elongation.rate.axpy(-mode.mode.sliders[i].direction() * factor, z, 1.0);
                own.sliding.axpy(factor, z, 1.0);
            }
            Watch::Level(i) => {
                let off = mode.mode.frictions[i] == FrictionState::Off;
                let levels = system.frictions[i].place(&mode.mode.stops).unwrap_or_default();
                let level = &mut self.frictions[i].levels[levels].level;
                level.axpy(if off { factor } else { -factor }, z, 1.0);
            }
        }
    }

    /// Adds `factor` × `z` to the derivative by the force of a contact in a mode.
    pub fn add_force(
        &mut self,
        system: &System,
        (mode, own): (&VariedMode, &mut InMode),
        contact: Contact,
        (factor, z): (f64, &StateRow),
    ) {
        match contact {
            Contact::Stop(i) if mode.mode.stops[i] != StopState::Closed => {
                self.add_stop_force(i, mode.mode.stops[i], factor, z);
            }
            Contact::Friction(i) if mode.mode.frictions[i] != FrictionState::Stuck => {
                let levels = system.frictions[i].place(&mode.mode.stops);
                self.add_friction_force((i, levels), mode.mode.frictions[i], factor, z);
            }
            _ => own.add_force(mode, contact, factor, z),
        }
    }

    /// Adds the derivatives by everything that determines a mode's rows: the adjoint of (A34).
    pub fn add_mode(&mut self, system: &System, mode: &VariedMode, own: &InMode) {
        let (n, size, basis) = (system.coordinates, system.signals.size, &mode.mode.basis);
        let by_a = own.by_a();
        let one = system.signals.one;
        self.signals += by_a.rows(one - n, size - one);
        self.add_first_order(system, &mode.mode, &by_a);
        let own_a = by_a.rows(0, n);
        let mut acceleration = DMatrix::zeros(n, size);
        for k in 0..n {
            mode.a.row(n + k).iter().for_each(|&(j, x)| acceleration[(k, j)] = x);
        }
        // Constraints: D = G⁻¹ (Λ - Wᵀ M⁻¹ Y); forces: Z = M⁻¹ (Y + W D).
        let mut held = DMatrix::zeros(basis.len(), size);
        for (k, (&contact, lambda)) in basis.iter().zip(&own.lambda).enumerate() {
            let moved = own_a.tr_mul(&system.elongation_of(contact).mobility);
            held.row_mut(k).copy_from(&(lambda - moved).transpose());
        }
        if !basis.is_empty() {
            held.as_mut_slice().chunks_exact_mut(basis.len()).for_each(|column| mode.triangle.solve(column));
        }
        let mut by_forces = own_a.into_owned();
        for (k, &contact) in basis.iter().enumerate() {
            by_forces.ger(1.0, &system.elongation_of(contact).w, &held.row(k).transpose(), 1.0);
        }
        system.inertia.solve_mut(&mut by_forces);
        for (k, &contact) in basis.iter().enumerate() {
            let row = held.row(k).transpose();
            let elongation = self.elongation(contact);
            elongation.w += &acceleration * &row - &by_forces * &mode.lambda[k];
            elongation.drift += row;
        }
        self.mass -= &by_forces * acceleration.transpose();
        for (i, &state) in mode.mode.stops.iter().enumerate() {
            if let Some(force) = system.stop_force(i, state) {
                self.stops[i].elongation.w -= &by_forces * &*force;
                let row = by_forces.tr_mul(&system.stops[i].elongation.w);
                self.add_stop_force(i, state, -1.0, &row);
            }
        }
        for (i, &state) in mode.mode.frictions.iter().enumerate() {
            let levels = system.frictions[i].place(&mode.mode.stops);
            if let Some(force) = system.friction_force(i, state, &mode.mode.stops) {
                self.frictions[i].elongation.w -= &by_forces * &*force;
                let row = by_forces.tr_mul(&system.frictions[i].elongation.w);
                self.add_friction_force((i, levels), state, -1.0, &row);
            }
        }
        self.add_sliders(system, &mode.mode, &by_forces);
        self.forces += by_forces;
    }

    /// Returns the derivative along a column: the sum of all products with its tangent.
    pub fn along(&self, system: &System, tangent: &Tangent) -> f64 {
        if tangent.is_zero {
            return 0.0;
        }
        let e = |own: &ElongationTangent, by: &ElongationTangent| {
            own.e.dot(&by.e) + own.rate.dot(&by.rate) + own.w.dot(&by.w) + own.drift.dot(&by.drift)
        };
        let bodies = self.bodies.iter().zip(&tangent.bodies);
        let bodies = bodies.map(|(own, by)| {
            own.s.dot(&by.s) + own.v.dot(&by.v) + own.weights.dot(&by.weights) + own.drift.dot(&by.drift)
        });
        let springs = self.springs.iter().zip(&tangent.springs);
        let springs = springs.map(|(own, by)| e(&own.0, &by.0) + own.1.dot(&by.1));
        let stops = self.stops.iter().zip(&tangent.stops).map(|(own, by)| {
            let rows = own.excess.dot(&by.excess) + own.force.dot(&by.force) + own.spring.dot(&by.spring);
            e(&own.elongation, &by.elongation) + rows + own.restitution * by.restitution
        });
        let frictions = self.frictions.iter().zip(&tangent.frictions).map(|(own, by)| {
            let levels = own.levels.iter().zip(&by.levels);
            let levels =
                levels.map(|(own, by)| own.level.dot(&by.level) + own.static_level.dot(&by.static_level));
            e(&own.elongation, &by.elongation) + levels.sum::<f64>()
        });
        let branches = self.branches.iter().zip(&tangent.branches).map(|(own, by)| {
            e(&own.elongation, &by.elongation)
                + own.force.dot(&by.force)
                + own.rate.dot(&by.rate)
                + own.level.dot(&by.level)
                + own.sliding.dot(&by.sliding)
        });
        let loads = self.loads.iter().zip(&tangent.loads).map(|(own, by)| own.dot(by));
        let one = system.signals.one;
        let signals = tangent.signals.rates().map(|(i, (j, x))| self.signals[(i - one, j)] * x);
        let elements =
            bodies.chain(springs).chain(stops).chain(frictions).chain(branches).chain(loads).chain(signals);
        self.mass.dot(&tangent.mass) + self.forces.dot(&tangent.forces) + elements.sum::<f64>()
    }
}
