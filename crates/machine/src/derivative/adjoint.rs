//! The adjoint method: the derivative of a sum with respect to everything before it, computed
//! backwards over a recorded motion (docs/assembly-law.md (A39), (A40)).

use super::columns::padded;
use super::machine::Machine;
use super::mode::VariedMode;
use super::passed::Passed;
use super::residual_rows::residual_row;
use super::series::orders;
use super::weights::{InMode, Weights};
use crate::flow::RADIUS;
use crate::functional::{Functional, StateRow};
use crate::kernel::{EIGHT, NODES, SHORT};
use crate::mode::{Contact, FrictionState, SliderState, StopState};
use crate::quantity::{Owner, Quantity, What};
use crate::system::Part;
use nalgebra::DVector;
use pulp::{Arch, Simd, WithSimd};
use std::collections::HashMap;
use std::sync::Arc;

/// Largest number of a flight's parts whose power series are kept at one time.
const KEPT: usize = 32;

/// A recorded step of a motion.
pub(super) enum Step {
    /// A flight: the mode, the state at its start, and its duration in s.
    Flight(Arc<VariedMode>, DVector<f64>, f64),
    /// An event, and the derivative of the sum with respect to its time.
    Event(Box<Passed>, f64),
    /// A term of the sum: the mode, the state, the quantity and its factor.
    Value(Arc<VariedMode>, DVector<f64>, Quantity, f64),
}

/// The derivative of a sum with respect to the present state and to all rows of the machine.
pub(super) struct Adjoint<'a> {
    machine: &'a Machine,
    pub state: DVector<f64>,
    weights: Weights,
    modes: HashMap<*const VariedMode, (Arc<VariedMode>, InMode)>,
    /// Contributions of varied signals at knots, by column.
    pub signals: Vec<f64>,
    series: Series,
}

/// Buffer for a flight's power series: a padded vector for each part and order.
#[derive(Default)]
struct Series {
    states: Vec<f64>,
    own: Vec<f64>,
    values: Vec<f64>,
    vectors: Option<Arch>,
}

impl<'a> Adjoint<'a> {
    /// The adjoint of a sum without terms.
    pub fn new(machine: &'a Machine) -> Self {
        let state = DVector::zeros(machine.system.signals.size);
        let (weights, signals) = (Weights::zeros(&machine.system), vec![0.0; machine.columns.len()]);
        Self { machine, state, weights, modes: HashMap::new(), signals, series: Series::default() }
    }

    fn in_mode(&mut self, mode: &Arc<VariedMode>) -> &mut InMode {
        let made = || (mode.clone(), InMode::zeros(&self.machine.system, mode));
        &mut self.modes.entry(Arc::as_ptr(mode)).or_insert_with(made).1
    }

    /// Propagates the adjoint backwards over a step.
    pub fn undo(&mut self, step: &Step) {
        match step {
            Step::Flight(mode, z, time) => self.fly(mode, z, *time),
            Step::Event(passed, factor) => self.cross(passed, *factor),
            Step::Value(mode, z, quantity, factor) => self.add(mode, z, *quantity, *factor),
        }
    }

    /// Finishes the backward pass; the result gives the derivative along any column.
    pub fn finish(self) -> Finished<'a> {
        let Self { machine, state, mut weights, modes, signals, .. } = self;
        modes.values().for_each(|(mode, own)| weights.add_mode(&machine.system, mode, own));
        Finished { machine, state, weights, signals }
    }

    /// Propagates μ backwards over a flight, μ⁻ = exp(Aᵀ t) μ, and adds ∫ μ zᵀ dt, the derivative
    /// by A.
    fn fly(&mut self, mode: &Arc<VariedMode>, z: &DVector<f64>, time: f64) {
        let parts = (time / mode.length).ceil().max(1.0) as usize;
        let step = time / parts as f64;
        let count = orders(RADIUS * step / mode.length);
        let mut series = std::mem::take(&mut self.series);
        let mut begins = vec![z.as_slice().to_vec()];
        // If not all parts are kept, a first pass finds the state at the start of each block.
        for block in 0..(parts - 1) / KEPT {
            let last = series.expand(mode, &begins[block], (KEPT, step, count));
            begins.push(last);
        }
        let mut state = std::mem::replace(&mut self.state, DVector::zeros(0));
        let own = self.in_mode(mode);
        for (block, begin) in begins.iter().enumerate().rev() {
            let kept = (parts - block * KEPT).min(KEPT);
            series.expand(mode, begin, (kept, step, count));
            for part in (0..kept).rev() {
                series.back(mode, part, (step, count), state.as_mut_slice(), own);
            }
        }
        self.state = state;
        self.series = series;
    }

    /// Propagates μ backwards over an isolated event, or a knot without a jump of velocities.
    fn cross(&mut self, passed: &Passed, factor: f64) {
        let [_, after] = &passed.modes;
        self.project(after, &passed.states[1]);
        if passed.due.is_none() {
            self.knot(passed, factor);
            return;
        }
        let mut later = factor - self.state.dot(&passed.rates[1]);
        for impulse in passed.impulses.iter().rev() {
            impulse.undo(&self.machine.system, &mut self.state, &mut self.weights);
        }
        later += self.state.dot(&passed.rates[0]);
        let Some(place) = passed.due else { return };
        let (mode, z) = (&passed.modes[0], &passed.states[0]);
        let (watch, row) = &mode.watched[place];
        let varied = -later / row.dot(&passed.rates[0]);
        self.state.axpy(varied, row, 1.0);
        let Self { machine, weights, modes, .. } = self;
        let made = || (mode.clone(), InMode::zeros(&machine.system, mode));
        let own = &mut modes.entry(Arc::as_ptr(mode)).or_insert_with(made).1;
        weights.add_watched(&machine.system, (mode, own), (*watch, row), (varied, z));
    }

    /// Propagates μ backwards over a knot, after which the derivatives of the signals are known.
    fn knot(&mut self, passed: &Passed, factor: f64) {
        let Self { machine, state, signals, .. } = self;
        let one = machine.system.signals.one;
        for (p, tangent) in machine.tangents.iter().enumerate().filter(|(_, t)| t.signals.varies()) {
            let mut known = DVector::zeros(state.len());
            machine.fill(p, passed.time, &passed.states[1], &mut known);
            signals[p] += known.rows_range(one..).dot(&state.rows_range(one..));
            if let Some(knot) = tangent.signals.later(passed.time) {
                let change = &passed.rates[0] - &passed.rates[1];
                signals[p] += knot.later * (factor + change.rows_range(..one).dot(&state.rows_range(..one)));
            }
        }
        state.rows_range_mut(one..).fill(0.0);
    }

    /// Adjoint of the projection onto the constraints that the contacts of a mode hold.
    fn project(&mut self, mode: &VariedMode, z: &DVector<f64>) {
        let (basis, system) = (&mode.mode.basis, &self.machine.system);
        let stops = basis.iter().take_while(|contact| system.keeps_place(**contact)).count();
        for (contacts, rates) in [(&basis[..], true), (&basis[..stops], false)] {
            if contacts.is_empty() {
                continue;
            }
            let n = system.coordinates;
            let places = self.state.rows(if rates { n } else { 0 }, n);
            let mut taken: Vec<f64> =
                contacts.iter().map(|&c| system.elongation_of(c).mobility.dot(&places)).collect();
            mode.triangle.solve(&mut taken);
            for (&contact, &taken) in contacts.iter().zip(&taken) {
                let row: &StateRow = match contact {
                    Contact::Stop(i) if !rates => &system.stops[i].excess,
                    _ => &system.elongation_of(contact).rate,
                };
                self.state.axpy(-taken, row, 1.0);
                self.weights.add_held(contact, rates, -taken, z);
            }
        }
    }

    /// Adds a term of the sum, y = ℓ z.
    fn add(&mut self, mode: &Arc<VariedMode>, z: &DVector<f64>, quantity: Quantity, factor: f64) {
        let machine = self.machine;
        match quantity.owner {
            Owner::Body(i) => self.add_body(mode, z, (i, quantity.what), factor),
            Owner::Element(i) if matches!(quantity.what, What::F | What::TangentF(_)) => {
                let parts = machine.system.parts_of(i, quantity.what);
                parts.iter().for_each(|&part| self.add_force(mode, z, part, factor));
            }
            Owner::Element(i) if matches!(quantity.what, What::Slider(_) | What::SliderRate(_)) => {
                let (What::Slider(k) | What::SliderRate(k)) = quantity.what else { return };
                let Some(branch) = machine.system.branch_of(i, k) else { return };
                let own = &machine.system.branches[branch];
                let by = &mut self.weights.branches[branch].elongation;
                if matches!(quantity.what, What::Slider(_)) {
                    self.state.axpy(factor, &own.inner, 1.0);
                    return by.e.axpy(factor, z, 1.0);
                }
                if own.is_slider() && mode.mode.sliders[branch] == SliderState::Held {
                    return;
                }
                self.state.axpy(factor, own.rate_of_whole(), 1.0);
                by.rate.axpy(factor, z, 1.0);
                mode.a.row(own.place).iter().for_each(|&(j, x)| self.state[j] -= factor * x);
                let in_mode = &mut self.in_mode(mode).a;
                let mut row = in_mode.row_mut(own.place - machine.system.coordinates);
                row.iter_mut().zip(z.iter()).for_each(|(sum, x)| *sum -= factor * x);
            }
            Owner::Element(i) => {
                let Some(&part) = machine.system.parts_of(i, quantity.what).first() else { return };
                let Some(rows) = machine.system.elongation_of_part(part) else { return };
                let own = match part {
                    Part::Spring(i) => &mut self.weights.springs[i].0,
                    Part::Stop(i) => &mut self.weights.stops[i].elongation,
                    Part::Friction(i) => &mut self.weights.frictions[i].elongation,
                    Part::Branch(i) => &mut self.weights.branches[i].elongation,
                    Part::Load(_) => return,
                };
                let is_place = matches!(quantity.what, What::E | What::TangentE(_));
                self.state.axpy(factor, if is_place { &rows.e } else { &rows.rate }, 1.0);
                if is_place { &mut own.e } else { &mut own.rate }.axpy(factor, z, 1.0);
            }
        }
    }

    fn add_body(&mut self, mode: &Arc<VariedMode>, z: &DVector<f64>, (i, what): (usize, What), factor: f64) {
        let system = &self.machine.system;
        let (rows, own) = (&system.bodies[i], &mut self.weights.bodies[i]);
        match what {
            What::S => {
                self.state.axpy(factor, &rows.s, 1.0);
                own.s.axpy(factor, z, 1.0);
            }
            What::V => {
                self.state.axpy(factor, &rows.v, 1.0);
                own.v.axpy(factor, z, 1.0);
            }
            _ => {
                let n = system.coordinates;
                own.weights.axpy(factor, &mode.rates(z).rows(n, n), 1.0);
                own.drift.axpy(factor, z, 1.0);
                self.state.axpy(factor, &rows.drift, 1.0);
                let by_mode = self.in_mode(mode);
                by_mode.a.rows_mut(0, n).ger(factor, &rows.weights, z, 1.0);
                for (k, weight) in rows.weights.iter().enumerate() {
                    let row = mode.a.row(n + k).iter();
                    row.for_each(|&(j, x)| self.state[j] += factor * weight * x);
                }
            }
        }
    }

    fn add_force(&mut self, mode: &Arc<VariedMode>, z: &DVector<f64>, part: Part, factor: f64) {
        let system = &self.machine.system;
        let held = |contact: Contact| {
            let place = mode.mode.basis.iter().position(|&c| c == contact);
            place.map(|k| mode.lambda[k].clone())
        };
        let (contact, row) = match part {
            Part::Spring(i) => {
                self.state.axpy(factor, &system.springs[i].force, 1.0);
                return self.weights.springs[i].1.axpy(factor, z, 1.0);
            }
            Part::Branch(i) => {
                let state = mode.mode.sliders[i];
                self.state.axpy(factor, &system.branch_force(i, state), 1.0);
                return self.weights.add_branch_force(i, state, factor, z);
            }
            Part::Load(i) => {
                self.state.axpy(factor, &system.loads[i], 1.0);
                return self.weights.loads[i].axpy(factor, z, 1.0);
            }
            Part::Stop(i) => match mode.mode.stops[i] {
                StopState::Closed => (Contact::Stop(i), held(Contact::Stop(i))),
                state => (Contact::Stop(i), system.stop_force(i, state).map(Functional::into_row)),
            },
            Part::Friction(i) => match mode.mode.frictions[i] {
                FrictionState::Stuck => (Contact::Friction(i), held(Contact::Friction(i))),
                state => {
                    let force = system.friction_force(i, state, &mode.mode.stops);
                    (Contact::Friction(i), force.map(Functional::into_row))
                }
            },
        };
        let Some(row) = row else { return };
        self.state.axpy(factor, &row, 1.0);
        let Self { machine, weights, modes, .. } = self;
        let made = || (mode.clone(), InMode::zeros(&machine.system, mode));
        let own = &mut modes.entry(Arc::as_ptr(mode)).or_insert_with(made).1;
        weights.add_force(&machine.system, (mode, own), contact, (factor, z));
    }
}

/// Returns the row of a quantity in a mode: its derivative with respect to the state.
pub(super) fn row_of(machine: &Machine, mode: &Arc<VariedMode>, quantity: Quantity) -> StateRow {
    if let Some(row) = residual_row(&machine.system, mode, quantity) {
        return row;
    }
    let mut alone = Adjoint::new(machine);
    alone.add(mode, &StateRow::zeros(machine.system.signals.size), quantity, 1.0);
    alone.state
}

/// The derivative of a sum with respect to the initial state and to all rows of the machine.
pub(super) struct Finished<'a> {
    machine: &'a Machine,
    state: DVector<f64>,
    weights: Weights,
    signals: Vec<f64>,
}

impl Finished<'_> {
    /// Returns the derivative along column `p`; `start` is this column of the initial state.
    pub fn along(&self, p: usize, start: &DVector<f64>) -> f64 {
        let tangent = &self.machine.tangents[p];
        self.state.dot(start) + self.signals[p] + self.weights.along(&self.machine.system, tangent)
    }
}

impl Series {
    /// Computes the power series, with `count` orders, of each of `parts` parts of a flight from
    /// the state `z`. A part has the length `step`. Returns the state at the end.
    fn expand(
        &mut self,
        mode: &VariedMode,
        z: &[f64],
        (parts, step, count): (usize, f64, usize),
    ) -> Vec<f64> {
        let (size, width) = (z.len(), padded(z.len()));
        self.states.clear();
        self.states.resize(parts * (count + 1) * width, 0.0);
        let mut z = z.to_vec();
        for own in self.states.chunks_exact_mut((count + 1) * width).take(parts) {
            own[..size].copy_from_slice(&z);
            for k in 1..=count {
                let (before, after) = own.split_at_mut(k * width);
                mode.a.rows_times_to(0, &before[(k - 1) * width..], step / k as f64, &mut after[..size]);
                z.iter_mut().zip(&after[..size]).for_each(|(sum, x)| *sum += x);
            }
        }
        z
    }

    /// Propagates μ backwards over a part: expands μ in powers of the time before the part's end,
    /// and integrates ∫ μ zᵀ dt by Gauss quadrature.
    fn back(
        &mut self,
        mode: &VariedMode,
        part: usize,
        (step, count): (f64, usize),
        state: &mut [f64],
        to: &mut InMode,
    ) {
        let Self { states, own, values, vectors } = self;
        let (size, width) = (state.len(), padded(state.len()));
        own.clear();
        own.resize((count + 1) * width, 0.0);
        own[..size].copy_from_slice(state);
        for k in 1..=count {
            let (before, after) = own.split_at_mut(k * width);
            mode.a.after_row(&before[(k - 1) * width..][..size], step / k as f64, &mut after[..size]);
            state.iter_mut().zip(&after[..size]).for_each(|(sum, x)| *sum += x);
        }
        let length = (count + 1) * width;
        let states = &states[part * length..][..length];
        let nodes: &[(f64, f64)] = if RADIUS * step / mode.length <= SHORT { &EIGHT } else { &NODES };
        values.resize(2 * BESIDE * width, 0.0);
        vectors.get_or_insert_with(Arch::new).dispatch(Integral {
            states,
            own,
            nodes,
            step,
            values,
            size,
            sums: &mut to.sums,
        });
    }
}

/// Gauss nodes evaluated side by side.
const BESIDE: usize = 4;

/// Adds ∫ μ zᵀ dt over a part of a flight to `sums`, by Gauss quadrature of both power series. The
/// series of μ runs backwards from the part's end. Compiled for each vector instruction set.
struct Integral<'a> {
    states: &'a [f64],
    own: &'a [f64],
    nodes: &'a [(f64, f64)],
    step: f64,
    /// Buffer for the values of both series at some nodes.
    values: &'a mut [f64],
    size: usize,
    /// A padded vector for each coordinate of z.
    sums: &'a mut [f64],
}

impl WithSimd for Integral<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { states, own, nodes, step, values, size, sums } = self;
        let width = padded(size);
        let each = width / S::F64_LANES;
        for nodes in nodes.chunks_exact(BESIDE) {
            let (z, mu) = values.split_at_mut(BESIDE * width);
            values_at(simd, states, std::array::from_fn(|k| nodes[k].0), z);
            values_at(simd, own, std::array::from_fn(|k| 1.0 - nodes[k].0), mu);
            let mu = S::as_simd_f64s(mu).0;
            let columns = S::as_mut_simd_f64s(sums).0.chunks_exact_mut(each);
            for (j, column) in columns.enumerate() {
                let factors: [S::f64s; BESIDE] =
                    std::array::from_fn(|k| simd.splat_f64s(nodes[k].1 * step * z[k * width + j]));
                for (v, sum) in column.iter_mut().enumerate() {
                    for (k, factor) in factors.iter().enumerate() {
                        *sum = simd.add_f64s(*sum, simd.mul_f64s(*factor, mu[k * each + v]));
                    }
                }
            }
        }
    }
}

/// Evaluates a power series at some places by Horner's rule; writes the values one after another.
#[inline(always)]
fn values_at<S: Simd>(simd: S, series: &[f64], places: [f64; BESIDE], to: &mut [f64]) {
    let (series, to) = (S::as_simd_f64s(series).0, S::as_mut_simd_f64s(to).0);
    let (each, places) = (to.len() / BESIDE, places.map(|x| simd.splat_f64s(x)));
    for v in 0..each {
        let mut sums = [simd.splat_f64s(0.0); BESIDE];
        for term in series.chunks_exact(each).rev() {
            for (sum, x) in sums.iter_mut().zip(&places) {
                *sum = simd.add_f64s(simd.mul_f64s(*sum, *x), term[v]);
            }
        }
        sums.into_iter().enumerate().for_each(|(k, sum)| to[k * each + v] = sum);
    }
}
