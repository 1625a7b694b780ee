//! The choice of the mode that follows an instant, order by order in the derivatives of the motion
//! (docs/assembly-law.md (A10) to (A12)).
//!
//! Values alone do not decide: a stop with e = gap and e' = 0 opens or stays closed by the first
//! nonzero derivative, and the contacts' forces depend on one another. At each order the undecided
//! contacts form one convex problem ([`BoxProblem`](super::box_qp::BoxProblem)) with unique
//! accelerations. It decides contacts with a nonzero residual, or with a force strictly inside its
//! bounds; the others continue to the next order. By (A11) the result is the only mode whose
//! conditions all hold just after the instant.
//!
//! A change must keep three things:
//!
//! - The zero tolerance is relative to the sizes of terms ([`Sizes`]), never absolute.
//! - A friction that leaves its static level restarts the choice with its sliding level, since the
//!   other contacts then bear other forces (A12).
//! - The basis of dependent contacts follows the order in which their forces came to lie strictly
//!   inside their bounds: the other contacts keep a share that is a bound or zero.
//!
//! The slider of a contact follows its stop (`contacts.rs`).
//!
//! A new kind of contact needs its candidates in `Stop` or `Friction`, its first classification in
//! `classify.rs`, and its bounds and decision in `order.rs`. A change is tested by
//! `tests/second_method.rs` (all modes tried, in 50 digits), `tests/lone_events.rs` (guess and
//! choice agree) and unchanged golden files.

mod classify;
mod contacts;
mod order;

use super::Sizes;
use super::box_qp::Jam;
use crate::curved::{CurveSeries, CurveSizes, NEAR, Operation, Piece, TERMS};
use crate::functional::StateRow;
use crate::mode::{Contact, FrictionState, Mode, SliderState, StopState};
use crate::system::System;
use nalgebra::{DMatrix, DVector};

/// Number of orders beyond twice the length of z after which an undecided contact of a machine
/// with curved forces counts as zero throughout: no theorem bounds the order, as (A11) does for
/// straight laws.
const FURTHER: usize = 8;

/// State of a stop during a selection.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Stop {
    /// Decided.
    Is(StopState),
    /// A rigid stop with e = gap and zero derivatives up to the present order.
    Touching,
    /// A compliant stop with e = gap and zero derivatives up to the present order.
    AtEdge,
    /// A compliant stop whose force is at the limit between two states: the state above and the
    /// state below the limit.
    AtLimit(StopState, StopState),
    /// An `ElastoGap` so near to its edge that its force is zero and at its cap within rounding.
    AtLimits,
    /// A compliant stop beyond its gap with e' = 0 and zero derivatives up to the present order,
    /// whose dashpot acts only while e grows.
    Turning,
}

/// State of a friction during a selection.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Friction {
    /// Decided.
    Is(FrictionState),
    /// e' and its derivatives are zero up to the present order. The value is the order of the
    /// level's first nonzero derivative.
    Resting(usize),
    /// Resting, with the force at its level in this direction up to the present order.
    AtLevel(f64),
}

/// State of a slider during a selection.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Slider {
    /// Decided.
    Is(SliderState),
    /// The force is at its level in this direction, or with 0 in both, and the rate of slip and
    /// its derivatives are zero up to the present order.
    AtLevel(f64),
    /// The slider of a contact at its edge, whose normal force is not decided.
    AtEdge,
}

/// Facts about a slider that its rounded values cannot show.
#[derive(Clone, Copy, Debug, Default)]
pub struct SliderFlag {
    /// Direction of the force if it is at its level; 0 if values decide.
    pub level: f64,
    /// Whether e' = 0.
    pub turns: bool,
}

/// State of a selection.
pub struct Selection<'a> {
    system: &'a System,
    /// z and its derivatives, by order.
    derivatives: Vec<DVector<f64>>,
    /// Bounds of the sizes of `derivatives`, by order.
    sizes: Vec<Sizes>,
    stops: Vec<Stop>,
    frictions: Vec<Friction>,
    sliders: Vec<Slider>,
    /// Contacts in the order of their forces' arrival strictly inside their bounds. The basis
    /// prefers these contacts: contacts that depend on them then keep a share that is a bound or
    /// zero.
    preferred: Vec<Contact>,
    /// Whether each friction has left its static level in this choice.
    released: Vec<bool>,
    /// The states of the stops, provisional if undecided.
    pressing: Vec<StopState>,
    /// Whether the level of each friction that follows a stop is positive.
    acts: Vec<bool>,
    /// Whether the stop that each friction follows pulls.
    ends: Vec<bool>,
    /// Direction of each friction's force if it was at its level in its first solution, else 0.
    at_level: Vec<f64>,
    /// Taylor coefficients of the curved forces, with their sizes.
    curves: Vec<(CurveSeries, CurveSizes)>,
}

/// Facts from an event about its elements, which their rounded values cannot show.
pub struct EventVerdict<'a> {
    /// Whether each rigid stop touches.
    pub stops: &'a [bool],
    /// Whether each friction has e' = 0.
    pub resting: &'a [bool],
    /// Whether each compliant stop has e = gap.
    pub edges: &'a [bool],
    /// Whether the force of each compliant stop is at a limit.
    pub limits: &'a [bool],
    /// Flags of each branch's slider.
    pub sliders: &'a [SliderFlag],
    /// Indices of rigid stops that count as open at any speed: their impact is still to come.
    pub open: &'a [usize],
}

impl<'a> Selection<'a> {
    /// Returns the mode that follows the state `z`; no touching stop may close with a speed.
    ///
    /// # Errors
    /// [`Jam`] with indices of stops, if prescribed bodies drive them together.
    pub fn select(
        system: &'a System,
        z: &DVector<f64>,
        sizes: &Sizes,
        verdict: &EventVerdict,
    ) -> Result<Mode, Jam> {
        let mut released = vec![false; system.frictions.len()];
        loop {
            let mut selection = Self::begin(system, z, sizes, verdict, &released);
            let leaving = selection.run()?;
            if leaving.is_empty() {
                return Ok(selection.finish());
            }
            leaving.into_iter().for_each(|i| released[i] = true);
        }
    }

    fn begin(
        system: &'a System,
        z: &DVector<f64>,
        sizes: &Sizes,
        verdict: &EventVerdict,
        released: &[bool],
    ) -> Self {
        let mut z = z.clone();
        system.fill_curved(z.as_mut_slice());
        let curves = system.curved.iter().map(|curved| {
            let (operation, arguments) = (&curved.operation, curved.arguments(z.as_slice()));
            let mut series = CurveSeries::default();
            let shifts = curved.argument_sizes(sizes.0.as_slice());
            series.piece = Piece::of(operation, arguments[0], NEAR * shifts[0]);
            series.next(operation, 0, arguments);
            (series, CurveSizes::of(operation, arguments, shifts))
        });
        let mut selection = Self {
            system,
            curves: curves.collect(),
            derivatives: vec![z.clone()],
            sizes: vec![sizes.clone()],
            stops: Vec::new(),
            frictions: Vec::new(),
            sliders: Vec::new(),
            preferred: Vec::new(),
            at_level: vec![0.0; system.frictions.len()],
            released: released.to_vec(),
            pressing: Vec::new(),
            acts: vec![false; system.frictions.len()],
            ends: vec![false; system.frictions.len()],
        };
        for i in 0..system.stops.len() {
            let state = selection.classify_stop(i, verdict);
            selection.stops.push(state);
        }
        for i in 0..system.frictions.len() {
            let state = selection.classify_friction(i, verdict.resting[i]);
            selection.frictions.push(state);
        }
        for (i, flag) in verdict.sliders.iter().enumerate() {
            let state = selection.classify_slider(i, *flag, verdict);
            selection.sliders.push(state);
        }
        selection.pressing = selection.states().0;
        selection
    }

    /// Decides order by order. Returns the frictions that slip at their static levels; if there
    /// are any, the choice restarts.
    fn run(&mut self) -> Result<Vec<usize>, Jam> {
        let follows = self.system.frictions.iter().any(|own| own.follows.is_some());
        if self.is_decided() && !self.has_contacts() && !follows {
            return Ok(Vec::new());
        }
        let last = match self.curves.is_empty() {
            true => self.system.signals.size,
            false => (2 * self.system.signals.size + FURTHER).min(TERMS - 2),
        };
        for order in 0..=last {
            self.decide_compliant(order);
            if follows {
                self.follow(order);
            }
            let leaving = self.solve(order)?;
            if !leaving.is_empty() {
                return Ok(leaving);
            }
            if self.is_decided() || self.is_still() {
                break;
            }
        }
        Ok(Vec::new())
    }

    /// Whether the last and all higher derivatives are zero: nothing remains to decide.
    fn is_still(&self) -> bool {
        self.derivatives.last().is_some_and(|z| z.iter().all(|x| *x == 0.0))
    }

    /// Whether the state of every element is decided.
    fn is_decided(&self) -> bool {
        self.stops.iter().all(|s| matches!(s, Stop::Is(_)))
            && self.frictions.iter().all(|f| matches!(f, Friction::Is(_)))
            && self.sliders.iter().all(|s| matches!(s, Slider::Is(_)))
            && (0..self.frictions.len()).all(|i| self.is_level_decided(i))
    }

    /// Whether the sign of a level that follows a stop which may pull is known.
    fn is_level_decided(&self, i: usize) -> bool {
        let friction = &self.system.frictions[i];
        let passes = friction.follows.is_some() && friction.passes;
        !passes || self.acts[i] || self.ends[i] || friction.at(&self.pressing).is_none()
    }

    /// Whether a stop is closed or a friction sticks.
    fn has_contacts(&self) -> bool {
        self.stops.contains(&Stop::Is(StopState::Closed))
            || self.frictions.iter().any(|f| matches!(f, Friction::Is(state) if state.sticks()))
    }

    /// Decides compliant stops and sliders by the next derivative if it is not zero. At order k
    /// the derivatives of e up to k + 1 are known.
    fn decide_compliant(&mut self, order: usize) {
        for i in 0..self.sliders.len() {
            if let (Slider::AtLevel(direction), None) = (self.sliders[i], self.system.branches[i].stop()) {
                let sign = self.sign(&self.system.branches[i].elongation.rate, order);
                if sign != 0.0 {
                    self.sliders[i] = slid(direction, sign);
                }
            }
        }
        for i in 0..self.stops.len() {
            let stop = &self.system.stops[i];
            match self.stops[i] {
                // The rate of an output as a row of z depends on the mode.
                Stop::AtEdge if stop.limit.is_some() => {
                    let sign = if order > 0 { self.sign(&stop.excess, order) } else { 0.0 };
                    if sign != 0.0 {
                        let passed = if sign > 0.0 { StopState::Pressed } else { StopState::Below };
                        self.stops[i] = Stop::Is(passed);
                    }
                }
                Stop::AtEdge => {
                    let sign = self.sign(&stop.elongation.rate, order);
                    if sign != 0.0 {
                        self.stops[i] = Stop::Is(if sign > 0.0 { stop.entered() } else { StopState::Below });
                    }
                }
                Stop::AtLimit(above, below) if order > 0 => {
                    let difference = match above {
                        StopState::Capped => &*stop.force - 2.0 * &*stop.spring,
                        _ => (**stop.limited().unwrap_or(&stop.force)).clone(),
                    };
                    let sign = self.sign(&difference, order);
                    if sign != 0.0 {
                        self.stops[i] = Stop::Is(if sign > 0.0 { above } else { below });
                    }
                }
                Stop::Turning if order > 0 => {
                    let sign = self.sign(&stop.elongation.rate, order);
                    if sign != 0.0 {
                        let state = if sign > 0.0 { StopState::Pressed } else { StopState::Rebounding };
                        self.stops[i] = Stop::Is(state);
                    }
                }
                Stop::AtLimits if order > 0 => {
                    let beyond = self.sign(&(&*stop.force - 2.0 * &*stop.spring), order);
                    let force = self.sign(&stop.force, order);
                    self.stops[i] = match (beyond, force) {
                        (beyond, _) if beyond > 0.0 => Stop::Is(StopState::Capped),
                        (_, force) if force < 0.0 => Stop::Is(StopState::Free),
                        (0.0, 0.0) => Stop::AtLimits,
                        (0.0, _) => Stop::AtLimit(StopState::Capped, StopState::Pressed),
                        (_, 0.0) => Stop::AtLimit(StopState::Pressed, StopState::Free),
                        _ => Stop::Is(StopState::Pressed),
                    };
                }
                _ => {}
            }
        }
        self.decide_contacts(order);
    }

    /// Returns the states of all elements, provisional if undecided: touching stops closed,
    /// resting frictions stuck.
    fn states(&self) -> (Vec<StopState>, Vec<FrictionState>) {
        let stops = self.stops.iter().map(|s| match *s {
            Stop::Is(state) => state,
            Stop::Touching => StopState::Closed,
            Stop::AtEdge => StopState::Below,
            Stop::AtLimit(_, below) => below,
            Stop::AtLimits | Stop::Turning => StopState::Pressed,
        });
        let stops: Vec<StopState> = stops.collect();
        let frictions = self.frictions.iter().enumerate().map(|(i, f)| match *f {
            // A friction without a level is off, whatever its rate.
            Friction::Is(_) if self.is_without_level(i, &stops) => FrictionState::Off,
            Friction::Is(state) => state,
            Friction::Resting(_) | Friction::AtLevel(_) => FrictionState::Stuck,
        });
        let frictions = frictions.collect();
        (stops, frictions)
    }

    /// Whether a friction follows a stop without a pressing force.
    fn is_without_level(&self, i: usize, stops: &[StopState]) -> bool {
        let friction = &self.system.frictions[i];
        friction.follows.is_some() && (self.ends[i] || friction.at(stops).is_none())
    }

    /// Solves for the accelerations' derivative of an order and decides by it. Returns the
    /// frictions that slip at their static levels.
    fn solve(&mut self, order: usize) -> Result<Vec<usize>, Jam> {
        let (stops, frictions) = self.states();
        let free = self.system.free_acceleration(&stops, &frictions, &self.slider_states());
        let contacts: Vec<Contact> = (0..stops.len())
            .filter(|&i| stops[i] == StopState::Closed)
            .map(Contact::Stop)
            .chain(
                (0..frictions.len()).filter(|&i| frictions[i] == FrictionState::Stuck).map(Contact::Friction),
            )
            .collect();
        let z = self.derivatives[order].clone();
        let mut acceleration = &free * &z;
        let mut shares = DVector::zeros(self.system.coordinates);
        if !contacts.is_empty() {
            let problem = self.contact_problem(order, &contacts, &free);
            let solution = self.solve_contacts(&problem, &contacts)?;
            let leaving = self.leaving(&contacts, &solution);
            if !leaving.is_empty() {
                return Ok(leaving);
            }
            let mut forces = DVector::zeros(self.system.coordinates);
            for (k, &contact) in contacts.iter().enumerate() {
                let (e, force) = (self.system.elongation_of(contact), solution.lambda[k]);
                forces.axpy(force, &e.w, 1.0);
                shares.zip_apply(&e.mobility, |share: &mut f64, m| *share += (force * m).abs());
            }
            acceleration -= self.system.inertia.solve(&forces);
            self.decide(order, &contacts, &problem, &solution);
            self.prefer(&contacts, &problem, &solution);
        }
        self.differentiate(&z, &acceleration, &free, &shares);
        Ok(Vec::new())
    }

    /// Adds the next derivative of z and a bound of its size, from the terms of the free
    /// accelerations and the contact forces' `shares`. On a light body the terms may be far
    /// greater than their sum.
    fn differentiate(
        &mut self,
        z: &DVector<f64>,
        acceleration: &DVector<f64>,
        free: &DMatrix<f64>,
        shares: &DVector<f64>,
    ) {
        let (n, signals) = (self.system.coordinates, &self.system.signals);
        let mut next = DVector::zeros(signals.size);
        let mut size = DVector::zeros(signals.size);
        let sizes = &self.sizes[self.sizes.len() - 1];
        let terms = sizes.of_rows(free);
        for k in 0..n {
            next[k] = z[n + k];
            size[k] = sizes.0[n + k];
            next[n + k] = acceleration[k];
            size[n + k] = terms[k] + shares[k];
        }
        let states = self.slider_states();
        for (i, j) in self.system.places_of_first_order().enumerate() {
            if let Some(row) = self.system.rate_of_first_order(i, &states) {
                next[j] = row.dot(z);
                size[j] = sizes.of(&row);
            }
        }
        if self.system.first_limit < self.system.first_freewheel {
            let stops = self.states().0;
            self.system.add_limits(&stops, z, &mut next);
            for (stop, _) in self.system.passed_limits(&stops) {
                let beyond = sizes.of(&stop.excess);
                stop.further.iter().for_each(|&(place, by)| size[place] += by.abs() * beyond);
            }
        }
        for j in signals.one..signals.size {
            let mut unit = StateRow::zeros(signals.size);
            unit[j] = 1.0;
            let row = signals.derivative(&unit);
            next[j] = row.dot(z);
            size[j] = sizes.of(&row);
        }
        self.differentiate_curves(next.as_mut_slice(), size.as_mut_slice());
        self.derivatives.push(next);
        self.sizes.push(Sizes(size));
    }

    /// Sets the curved forces in the next derivative of z and in its sizes, given the other
    /// coordinates.
    fn differentiate_curves(&mut self, next: &mut [f64], size: &mut [f64]) {
        let order = self.derivatives.len();
        let factorial = (1..=order).fold(1.0, |product, k| product * k as f64);
        for (curved, (series, sizes)) in self.system.curved.iter().zip(&mut self.curves) {
            let mut arguments = curved.arguments(next).map(|x| x / factorial);
            let terms = curved.argument_sizes(size).map(|x| x / factorial);
            if curved.operation == Operation::Decay && arguments[0].abs() <= NEAR * terms[0] {
                // A rounding has no side.
                arguments[0] = 0.0;
            }
            next[curved.place] = factorial * series.next(&curved.operation, order, arguments);
            size[curved.place] = factorial * sizes.next(order, terms);
        }
    }

    /// Returns the mode of the decided states, with its basis.
    fn finish(self) -> Mode {
        let (stops, mut frictions) = self.states();
        for (i, state) in frictions.iter_mut().enumerate() {
            if self.is_without_level(i, &stops) {
                *state = FrictionState::Off;
            }
        }
        let mut contacts = self.preferred.clone();
        let closed = (0..stops.len()).filter(|&i| stops[i] == StopState::Closed).map(Contact::Stop);
        let stuck =
            (0..frictions.len()).filter(|&i| frictions[i] == FrictionState::Stuck).map(Contact::Friction);
        let mut all: Vec<Contact> = closed.chain(stuck).collect();
        all.sort_by_key(|c| matches!(c, Contact::Friction(i) if self.at_level[*i] != 0.0));
        contacts.retain(|c| all.contains(c));
        for contact in all {
            if !contacts.contains(&contact) {
                contacts.push(contact);
            }
        }
        let basis = self.system.independent(&contacts);
        // A friction outside the basis keeps its share of the solution: its level, or zero.
        for (i, state) in frictions.iter_mut().enumerate() {
            let direction = self.at_level[i];
            if state.sticks() && direction != 0.0 && !basis.contains(&Contact::Friction(i)) {
                *state = if direction > 0.0 { FrictionState::HeldUp } else { FrictionState::HeldDown };
            }
        }
        Mode { stops, frictions, sliders: self.slider_states(), basis }
    }

    /// Returns the states of all branches; undecided sliders at their levels, whose rate of slip
    /// is zero, are held.
    fn slider_states(&self) -> Vec<SliderState> {
        let state = |slider: &Slider| match *slider {
            Slider::Is(state) => state,
            Slider::AtLevel(_) => SliderState::Held,
            Slider::AtEdge => SliderState::Off,
        };
        self.sliders.iter().map(state).collect()
    }
}

/// A slider at its level in a direction, decided by the sign of the first nonzero derivative of e.
fn slid(direction: f64, sign: f64) -> Slider {
    let slips = direction * sign > 0.0;
    Slider::Is(if slips { SliderState::slipping(direction) } else { SliderState::Held })
}

/// Returns the slipping state with this sign of e'.
fn slipping(direction: f64) -> FrictionState {
    if direction > 0.0 { FrictionState::Up } else { FrictionState::Down }
}
