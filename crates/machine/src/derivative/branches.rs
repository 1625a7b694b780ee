//! Springs in series and their states of first order: derivatives by one parameter
//! (docs/assembly-law.md, section 15).

use super::machine::{Instant, Machine};
use super::rows::BranchTangent;
use super::tangent::Tangent;
use super::weights::Weights;
use crate::description::{Description, SeriesLaw};
use crate::functional::StateRow;
use crate::mode::{Mode, SliderState};
use crate::system::{System, in_series};
use nalgebra::{DMatrix, DVector};

impl Tangent {
    pub(super) fn put_branches(&mut self, system: &System, d: &Description, along: &Description) {
        let springs = in_series(d).zip(in_series(along));
        for (rows, ((spring, series), (by, change))) in system.branches.iter().zip(springs) {
            let own = self.elongation(system, &spring.arms, &by.arms);
            let e = &rows.elongation;
            let force = (by.stiffness / rows.stiffness) * &*rows.force;
            let mut level = StateRow::zeros(system.signals.size);
            let rate = match (series.law, change.law) {
                (SeriesLaw::Dashpot { damping }, SeriesLaw::Dashpot { damping: dc }) => {
                    &own.rate - (1.0 / damping) * &force + (dc / (damping * damping)) * &*rows.force
                }
                (_, SeriesLaw::Slider { slip }) => {
                    level[system.signals.one] = slip;
                    own.rate.clone()
                }
                // Unreachable: both descriptions are of one machine.
                (SeriesLaw::Slider { .. }, SeriesLaw::Dashpot { .. }) => level.clone(),
            };
            // The force of a slider depends on the mode.
            if !rows.is_slider() {
                self.forces.ger(-1.0, &own.w, &rows.force, 1.0);
                self.forces.ger(-1.0, &e.w, &force, 1.0);
            }
            self.branches.push(BranchTangent { elongation: own, force, rate, level });
            self.inner.push(change.slider);
        }
    }

    /// Returns the derivative of a branch's force in a state of its slider.
    pub fn branch_force(&self, i: usize, state: SliderState) -> StateRow {
        let own = &self.branches[i];
        match state {
            SliderState::Held => own.force.clone(),
            state => state.direction() * &own.level,
        }
    }

    /// Returns the derivatives of the rows of states of first order that vary, with their places.
    pub(super) fn first_order(&self, system: &System, mode: &Mode) -> Vec<(usize, StateRow)> {
        let moves = |i: &usize| is_moving(system, mode, *i);
        let all = (0..system.branches.len()).filter(moves);
        let branches = all.map(|i| (system.branches[i].place, self.branches[i].rate.clone()));
        branches.chain(self.rates_of_blocks(system, mode)).collect()
    }
}

/// Whether the stretch of a branch varies in a mode.
fn is_moving(system: &System, mode: &Mode, i: usize) -> bool {
    !system.branches[i].is_slider() || mode.sliders[i] == SliderState::Held
}

impl Machine {
    /// Sets the derivative of the stretch of each slider at its level, so that its force stays
    /// there. Such a slider slips in the mode, or a jump has moved it (`moved`).
    pub(super) fn keep_levels(
        &self,
        p: usize,
        delta: &mut DVector<f64>,
        at: &Instant,
        moved: impl Fn(usize) -> Option<f64>,
    ) {
        let slips = |i: usize| Some(at.mode.mode.sliders[i].direction()).filter(|d| *d != 0.0);
        for (i, branch) in self.system.branches.iter().enumerate() {
            if let (Some(direction), true) = (slips(i).or_else(|| moved(i)), branch.is_slider()) {
                let by = &self.tangents[p].branches[i];
                let level = direction * by.level.dot(at.z);
                let off = branch.force.dot(delta) + by.force.dot(at.z) - level;
                delta[branch.place] -= off / branch.stiffness;
            }
        }
    }

    /// Replaces derivatives of inner places by derivatives of stretches, in a derivative of given
    /// states.
    pub(super) fn take_given(&self, p: usize, z: &DVector<f64>, delta: &mut DVector<f64>) {
        for (branch, by) in self.system.branches.iter().zip(&self.tangents[p].branches) {
            let e = branch.elongation.e.dot(delta) + by.elongation.e.dot(z);
            delta[branch.place] = e - delta[branch.place];
        }
    }

    /// Stretches springs in series by a jump, keeping their inner places. The jump changes the
    /// state by `moved` and its derivative by `jump`.
    pub(super) fn stretch(
        &self,
        p: usize,
        moved: &DVector<f64>,
        jump: &DVector<f64>,
        delta: &mut DVector<f64>,
    ) {
        for (branch, by) in self.system.branches.iter().zip(&self.tangents[p].branches) {
            delta[branch.place] += branch.elongation.e.dot(jump) + by.elongation.e.dot(moved);
        }
    }

    /// Converts a derivative of the augmented state, with stretches, to a derivative of the given
    /// states: coordinates, rates, inner places and states of blocks.
    pub(super) fn given(&self, p: usize, z: &DVector<f64>, delta: &DVector<f64>) -> Vec<f64> {
        let mut states = delta.as_slice()[..self.system.states()].to_vec();
        for (branch, by) in self.system.branches.iter().zip(&self.tangents[p].branches) {
            states[branch.place] = branch.inner.dot(delta) + by.elongation.e.dot(z);
        }
        states
    }
}

impl Weights {
    /// Adds `factor` × `row` to the derivative by the force of a branch in a state of its slider.
    pub fn add_branch_force(&mut self, i: usize, state: SliderState, factor: f64, row: &StateRow) {
        let own = &mut self.branches[i];
        match state {
            SliderState::Held => own.force.axpy(factor, row, 1.0),
            state => own.level.axpy(state.direction() * factor, row, 1.0),
        }
    }

    /// Adds the derivatives by the forces of sliders in a mode, computed from the derivatives by
    /// the forces on the coordinates.
    pub(super) fn add_sliders(&mut self, system: &System, mode: &Mode, by_forces: &DMatrix<f64>) {
        for i in system.sliders() {
            let state = mode.sliders[i];
            self.branches[i].elongation.w -= by_forces * &*system.branch_force(i, state);
            let row = by_forces.tr_mul(&system.branches[i].elongation.w);
            self.add_branch_force(i, state, -1.0, &row);
        }
    }

    /// Adds the derivatives by the rows of states of first order. `by_a` is the derivative by the
    /// rows of A, beginning with the accelerations.
    pub(super) fn add_first_order(&mut self, system: &System, mode: &Mode, by_a: &DMatrix<f64>) {
        let all = system.branches.iter().zip(&mut self.branches).enumerate();
        for (_, (rows, own)) in all.filter(|(i, _)| is_moving(system, mode, *i)) {
            own.rate += by_a.row(rows.place - system.coordinates).transpose();
        }
    }
}
