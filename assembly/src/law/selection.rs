//! Selection of the mode that follows an instant, order by order in the derivatives of the motion
//! (docs/assembly-law.md (A10) to (A12)).
//!
//! `classify` finds the elements' states that the present state decides. Each further order solves
//! the contacts' problem for the next derivative of the accelerations, and `order` reads from it
//! what it decides. A friction that leaves a static level of its own restarts the selection with
//! its kinetic level.

mod classify;
mod order;

use super::Sizes;
use super::box_qp::Jam;
use crate::mode::{Contact, FrictionState, Mode, StopState};
use crate::system::{Row, System};
use nalgebra::{DMatrix, DVector};

/// Verdict on a stop so far.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Stop {
    /// Decided.
    Is(StopState),
    /// A rigid stop with e = gap, whose derivatives so far are all zero.
    Touching,
    /// A compliant stop with e = gap, whose derivatives so far are all zero.
    AtEdge,
    /// A compliant stop whose force is at the limit between two states: the one above it and the
    /// one below.
    AtLimit(StopState, StopState),
    /// An `ElastoGap` so near to its edge that its force is both zero and at its cap, up to
    /// rounding.
    AtLimits,
}

/// Verdict on a friction so far.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Friction {
    /// Decided.
    Is(FrictionState),
    /// e' and its derivatives so far are zero; the level's first nonzero derivative has this order.
    Resting(usize),
    /// e' and its derivatives so far are zero, and the force is at its level in this direction.
    AtLevel(f64),
}

/// State of a selection.
pub struct Selection<'a> {
    system: &'a System,
    /// z and its known derivatives, by order.
    derivatives: Vec<DVector<f64>>,
    /// Sizes of `derivatives`, by order, which decide what is rounding.
    sizes: Vec<Sizes>,
    stops: Vec<Stop>,
    frictions: Vec<Friction>,
    /// Contacts in the order in which their forces came to lie strictly inside their bounds. They
    /// are preferred for the basis: those that depend on them then keep a bound or zero as force.
    preferred: Vec<Contact>,
    /// By friction: whether it has left its static level in this selection.
    released: Vec<bool>,
    /// By friction: direction in which its force was at its level when first tested, else 0.
    at_level: Vec<f64>,
}

/// Verdicts of an event on the elements, which take precedence over rounding of the state.
pub struct Touching<'a> {
    /// By stop: whether it is rigid with e = gap.
    pub stops: &'a [bool],
    /// By friction: whether e' = 0.
    pub resting: &'a [bool],
    /// By stop: whether it is compliant with e = gap.
    pub edges: &'a [bool],
    /// By stop: whether it is compliant with its force at a limit.
    pub limits: &'a [bool],
    /// Indices of rigid stops that are open whatever their speed: their impact is still to come.
    pub open: &'a [usize],
}

impl<'a> Selection<'a> {
    /// The mode that follows the state `z`, in which no touching stop closes with a speed.
    ///
    /// # Errors
    /// [`Jam`], whose contacts are indices of stops that prescribed bodies drive together.
    pub fn select(
        system: &'a System,
        z: &DVector<f64>,
        sizes: &Sizes,
        touching: &Touching,
    ) -> Result<Mode, Jam> {
        let mut released = vec![false; system.frictions.len()];
        loop {
            let mut selection = Self::begin(system, z, sizes, touching, &released);
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
        touching: &Touching,
        released: &[bool],
    ) -> Self {
        let mut selection = Self {
            system,
            derivatives: vec![z.clone()],
            sizes: vec![sizes.clone()],
            stops: Vec::new(),
            frictions: Vec::new(),
            preferred: Vec::new(),
            at_level: vec![0.0; system.frictions.len()],
            released: released.to_vec(),
        };
        for i in 0..system.stops.len() {
            let state = selection.classify_stop(i, touching);
            selection.stops.push(state);
        }
        for i in 0..system.frictions.len() {
            let state = selection.classify_friction(i, touching.resting[i]);
            selection.frictions.push(state);
        }
        selection
    }

    /// Solves order by order until every element is decided; returns the frictions that leave their
    /// static levels, for which the selection starts again.
    fn run(&mut self) -> Result<Vec<usize>, Jam> {
        if self.is_decided() && !self.has_contacts() {
            return Ok(Vec::new());
        }
        for order in 0..=self.system.signals.size {
            self.decide_compliant(order);
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

    /// Whether the last known derivative is zero, hence all higher ones: they decide nothing.
    fn is_still(&self) -> bool {
        self.derivatives.last().is_some_and(|z| z.iter().all(|x| *x == 0.0))
    }

    /// Whether the state of every element is known.
    fn is_decided(&self) -> bool {
        self.stops.iter().all(|s| matches!(s, Stop::Is(_)))
            && self.frictions.iter().all(|f| matches!(f, Friction::Is(_)))
    }

    /// Whether there are closed stops or sticking friction, whose forces are unknown.
    fn has_contacts(&self) -> bool {
        self.stops.contains(&Stop::Is(StopState::Closed))
            || self.frictions.iter().any(|f| matches!(f, Friction::Is(state) if state.sticks()))
    }

    /// Decides compliant stops whose next derivative is nonzero. At order k the derivatives of e up
    /// to k + 1 are known.
    fn decide_compliant(&mut self, order: usize) {
        for i in 0..self.stops.len() {
            let stop = &self.system.stops[i];
            match self.stops[i] {
                Stop::AtEdge => {
                    let sign = self.sign(&stop.elongation.rate, order);
                    if sign != 0.0 {
                        self.stops[i] = Stop::Is(if sign > 0.0 { stop.entered() } else { StopState::Below });
                    }
                }
                Stop::AtLimit(above, below) if order > 0 => {
                    let difference = match above {
                        StopState::Capped => &*stop.force - 2.0 * &*stop.spring,
                        _ => (*stop.force).clone(),
                    };
                    let sign = self.sign(&difference, order);
                    if sign != 0.0 {
                        self.stops[i] = Stop::Is(if sign > 0.0 { above } else { below });
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
    }

    /// The elements' states, with a provisional one for those not decided yet.
    fn states(&self) -> (Vec<StopState>, Vec<FrictionState>) {
        let stops = self.stops.iter().map(|s| match *s {
            Stop::Is(state) => state,
            Stop::Touching => StopState::Closed,
            Stop::AtEdge => StopState::Below,
            Stop::AtLimit(_, below) => below,
            Stop::AtLimits => StopState::Pressed,
        });
        let frictions = self.frictions.iter().map(|f| match *f {
            Friction::Is(state) => state,
            Friction::Resting(_) | Friction::AtLevel(_) => FrictionState::Stuck,
        });
        (stops.collect(), frictions.collect())
    }

    /// Solves for the accelerations' derivative of an order and decides by it; returns the
    /// frictions that leave their static levels.
    fn solve(&mut self, order: usize) -> Result<Vec<usize>, Jam> {
        let (stops, frictions) = self.states();
        let free = self.system.free_acceleration(&stops, &frictions);
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
            let problem = self.problem(order, &contacts, &free);
            let solution = self.solved(&problem, &contacts)?;
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

    /// Appends the next derivative of z and its size, from the terms of the free accelerations and
    /// the contact forces' `shares`, which on a light body may be far larger than their sum.
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
        for k in 0..n {
            next[k] = z[n + k];
            size[k] = sizes.0[n + k];
            next[n + k] = acceleration[k];
            let terms: f64 = free.row(k).iter().zip(sizes.0.iter()).map(|(f, s)| f.abs() * s).sum();
            size[n + k] = terms + shares[k];
        }
        for j in signals.one..signals.size {
            let mut unit = Row::zeros(signals.size);
            unit[j] = 1.0;
            let row = signals.derivative(&unit);
            next[j] = row.dot(z);
            size[j] = sizes.of(&row);
        }
        self.derivatives.push(next);
        self.sizes.push(Sizes(size));
    }

    /// The mode of the decided states, with its basis.
    fn finish(self) -> Mode {
        let (stops, mut frictions) = self.states();
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
        // Dependent contacts keep their share of the solution: the level or zero.
        for (i, state) in frictions.iter_mut().enumerate() {
            let direction = self.at_level[i];
            if state.sticks() && direction != 0.0 && !basis.contains(&Contact::Friction(i)) {
                *state = if direction > 0.0 { FrictionState::HeldUp } else { FrictionState::HeldDown };
            }
        }
        Mode { stops, frictions, basis }
    }
}

/// The slipping state with this sign of e'.
fn slipping(direction: f64) -> FrictionState {
    if direction > 0.0 { FrictionState::Up } else { FrictionState::Down }
}
