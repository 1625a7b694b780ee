//! Springs in series and their states of first order: derivatives by one parameter
//! (docs/assembly-law.md, section 15).

use super::machine::{Instant, Machine};
use super::rows::BranchTangent;
use super::tangent::Tangent;
use super::weights::Weights;
use crate::description::Description;
use crate::functional::StateRow;
use crate::mode::{Mode, SliderState};
use crate::system::{BranchLaw, System, in_series};
use nalgebra::{DMatrix, DVector};

impl Tangent {
    /// Adds the springs in series, and the start values of all inner places.
    pub(super) fn put_branches(&mut self, system: &System, d: &Description, along: &Description) {
        self.inner.extend(in_series(along).map(|own| own.slider));
        let springs = in_series(d).zip(in_series(along));
        for (rows, (spring, by)) in system.branches.iter().zip(springs) {
            let own = self.elongation(system, spring.arms, by.arms);
            let e = &rows.elongation;
            let force = (by.stiffness / rows.stiffness) * &*rows.force;
            let [mut level, sliding] = [(); 2].map(|()| StateRow::zeros(system.signals.size));
            let rate = match (spring.law, by.law) {
                (BranchLaw::Dashpot(damping), BranchLaw::Dashpot(dc)) => {
                    &own.rate - (1.0 / damping) * &force + (dc / (damping * damping)) * &*rows.force
                }
                (_, BranchLaw::Slider(slip)) => {
                    level[system.signals.one] = slip;
                    own.rate.clone()
                }
                // Contacts follow their stops.
                _ => return,
            };
            // The force of a slider depends on the mode.
            if !rows.is_slider() {
                self.forces.ger(-1.0, &own.w, &rows.force, 1.0);
                self.forces.ger(-1.0, &e.w, &force, 1.0);
            }
            self.branches.push(BranchTangent { elongation: own, force, rate, level, sliding, slaved: None });
        }
    }

    /// Adds the springs and sliders of contacts, after the stops whose forces limit theirs.
    pub(super) fn put_contacts(&mut self, system: &System, d: &Description, along: &Description) {
        let first = self.branches.len();
        let contacts = in_series(d).zip(in_series(along)).skip(first);
        for (rows, (own, by)) in system.branches[first..].iter().zip(contacts) {
            let (BranchLaw::Contact { stop, friction }, BranchLaw::Contact { friction: moved, .. }) =
                (own.law, by.law)
            else {
                continue;
            };
            let (stop_rows, stop_by) = (&system.stops[stop], &self.stops[stop]);
            let (k, dk) = (stop_rows.stiffness(), along.contacts[stop - d.stops.len()].stiffness);
            let rate = &stop_rows.elongation.rate;
            let by_number = moved * k + friction * dk - friction * k * by.stiffness / own.stiffness;
            let sliding = (by_number / own.stiffness) * &**rate
                + (friction * k / own.stiffness) * &stop_by.elongation.rate;
            let level = moved * &*stop_rows.force + friction * &stop_by.force;
            let elongation = self.elongation(system, own.arms, by.arms);
            let (force, rate) = ((by.stiffness / own.stiffness) * &*rows.force, elongation.rate.clone());
            let made = BranchTangent { elongation, force, rate, level, sliding, slaved: None };
            let made = self.residual_branch(system, self.branches.len(), made);
            self.branches.push(made);
        }
    }

    /// Returns the derivative of a branch's force in a state of its slider.
    pub fn branch_force(&self, i: usize, state: SliderState) -> StateRow {
        let own = &self.branches[i];
        match state {
            SliderState::Held => own.force.clone(),
            // The direction of an open contact is 0.
            state => state.direction() * &own.level,
        }
    }

    /// Returns the derivatives of the rows of states of first order that vary, with their places.
    pub(super) fn first_order(&self, system: &System, mode: &Mode) -> Vec<(usize, StateRow)> {
        let branches = (0..system.branches.len()).filter_map(|i| {
            let (place, own) = (system.branches[i].place, &self.branches[i]);
            match rate_of(system, mode, i) {
                Moves::No => None,
                Moves::WithRate => Some((place, own.rate.clone())),
                Moves::WithLevel(direction) => Some((place, direction * &own.sliding)),
                Moves::Slaved => own.slaved.as_ref().map(|[_, rate]| (place, rate.clone())),
            }
        });
        branches.chain(self.rates_of_blocks(system, mode)).collect()
    }
}

/// How the stretch of a branch varies in a mode.
enum Moves {
    No,
    /// Varies with the rate of the elongation.
    WithRate,
    /// Varies with the level of a contact's slider, which slips in this direction.
    WithLevel(f64),
    /// On residual flexibility, the other forces determine the stretch.
    Slaved,
}

fn rate_of(system: &System, mode: &Mode, i: usize) -> Moves {
    let branch = &system.branches[i];
    match mode.sliders[i] {
        _ if !branch.is_slider() => Moves::WithRate,
        SliderState::Held => Moves::WithRate,
        _ if branch.slaved.is_some() => Moves::Slaved,
        state if branch.sliding.is_some() && state != SliderState::Off => Moves::WithLevel(state.direction()),
        _ => Moves::No,
    }
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
            let slaved = branch.slaved.as_ref().zip(self.tangents[p].branches[i].slaved.as_ref());
            if let Some(([stretch, _], [by, _])) = slaved {
                delta[branch.place] = stretch.dot(delta) + by.dot(at.z);
                continue;
            }
            if at.mode.mode.sliders[i] == SliderState::Off {
                delta[branch.place] = 0.0;
                continue;
            }
            if let (Some(direction), true) = (slips(i).or_else(|| moved(i)), branch.is_slider()) {
                let by = &self.tangents[p].branches[i];
                let rows = branch.followed_level().map_or(0.0, |level| level.dot(delta));
                let level = direction * (rows + by.level.dot(at.z));
                let off = branch.force.dot(delta) + by.force.dot(at.z) - level;
                delta[branch.place] -= off / branch.stiffness;
            }
        }
    }

    /// Replaces derivatives of inner places by derivatives of stretches, in a derivative of given
    /// states.
    pub(super) fn take_given(&self, p: usize, z: &DVector<f64>, delta: &mut DVector<f64>) {
        for (branch, by) in self.system.branches.iter().zip(&self.tangents[p].branches) {
            let e = branch.whole.dot(delta) + by.elongation.e.dot(z);
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
            delta[branch.place] += branch.whole.dot(jump) + by.elongation.e.dot(moved);
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
            SliderState::Off => {}
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
        for (i, (rows, own)) in system.branches.iter().zip(&mut self.branches).enumerate() {
            let row = || by_a.row(rows.place - system.coordinates).transpose();
            match rate_of(system, mode, i) {
                Moves::No => {}
                Moves::WithRate => own.rate += row(),
                Moves::WithLevel(direction) => own.sliding += direction * row(),
                // Machines with residual flexibility are differentiated by columns.
                Moves::Slaved => {}
            }
        }
    }
}
