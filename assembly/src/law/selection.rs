//! Which mode follows: order by order in the derivatives of the motion (docs/assembly-law.md (A10)
//! to (A12)).

mod classify;
mod order;

use super::Sizes;
use super::box_qp::Jam;
use crate::mode::{Contact, FrictionState, Mode, StopState};
use crate::system::{StateRow, System};
use nalgebra::{DMatrix, DVector};

/// What is not yet known of an element.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Stop {
    Is(StopState),
    /// A rigid stop with e = gap, whose derivatives so far are all zero.
    Touching,
    /// A compliant stop with e = gap, likewise.
    AtEdge,
    /// A compliant stop whose force is at the limit of two states, with the state above and the one
    /// below it.
    AtLimit(StopState, StopState),
    /// An `ElastoGap` whose force is zero and at its cap, but for rounding, so near to its edge is
    /// it.
    AtLimits,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Friction {
    Is(FrictionState),
    /// e' = 0 and all derivatives so far; the level's first derivative that is not zero is of this
    /// order.
    Resting(usize),
    /// The same with |f| at its level throughout so far, in this direction.
    AtLevel(f64),
}

/// The choice of the mode that follows an instant.
pub struct Selection<'a> {
    system: &'a System,
    /// z and its derivatives, as far as they are known.
    derivatives: Vec<DVector<f64>>,
    /// Bounds of the sizes of the same.
    sizes: Vec<Sizes>,
    stops: Vec<Stop>,
    frictions: Vec<Friction>,
    /// Contacts in the order in which their forces came to lie strictly inside their bounds: the
    /// preferred basis, since what depends on them then keeps its share, which is a bound or zero.
    preferred: Vec<Contact>,
    /// By friction: whether it has left its static level.
    released: Vec<bool>,
    /// By friction: the direction in which its force was at its level in the first solution that
    /// decided on it, else 0.
    at_level: Vec<f64>,
}

/// Rigid stops that touch, by stop; and whether each friction has e' = 0 by an event's verdict.
pub struct EventVerdict<'a> {
    /// By stop.
    pub stops: &'a [bool],
    /// By friction.
    pub resting: &'a [bool],
    /// Compliant stops with e = gap by an event's verdict.
    pub edges: &'a [bool],
    /// Compliant stops whose force is at a limit by an event's verdict.
    pub limits: &'a [bool],
    /// Places of rigid stops that are open whatever their speed, since an impact of theirs is still
    /// to come.
    pub open: &'a [usize],
}

impl<'a> Selection<'a> {
    /// The mode that follows the state `z`, in which no touching stop closes with a speed.
    ///
    /// # Errors
    /// [`Jam`], whose contacts are places of stops: prescribed bodies drive them together.
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
            let state = selection.classify_stop(i, verdict);
            selection.stops.push(state);
        }
        for i in 0..system.frictions.len() {
            let state = selection.classify_friction(i, verdict.resting[i]);
            selection.frictions.push(state);
        }
        selection
    }

    /// Goes through the orders; returns the frictions that slip at their static levels, with which
    /// all begins anew.
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

    /// Whether the last known derivative is zero, and so all that follow: nothing decides any more.
    fn is_still(&self) -> bool {
        self.derivatives.last().is_some_and(|z| z.iter().all(|x| *x == 0.0))
    }

    /// Whether the state of every element is known.
    fn is_decided(&self) -> bool {
        self.stops.iter().all(|s| matches!(s, Stop::Is(_)))
            && self.frictions.iter().all(|f| matches!(f, Friction::Is(_)))
    }

    /// Whether forces of closed stops or sticking friction are to be found.
    fn has_contacts(&self) -> bool {
        self.stops.contains(&Stop::Is(StopState::Closed))
            || self.frictions.iter().any(|f| matches!(f, Friction::Is(state) if state.sticks()))
    }

    /// Compliant stops whose next known derivative is not zero. At order k the derivatives of e up
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

    /// The states as a mode's, with what is open as it is until it is decided.
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

    /// The accelerations' derivative of an order, and what it decides; returns the frictions that
    /// slip at their static levels.
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

    /// Adds the next derivative of z, and a bound of its size by the terms of the free
    /// accelerations and the contact forces' `shares`, which on a light body may be far greater
    /// than what they leave together.
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
            let mut unit = StateRow::zeros(signals.size);
            unit[j] = 1.0;
            let row = signals.derivative(&unit);
            next[j] = row.dot(z);
            size[j] = sizes.of(&row);
        }
        self.derivatives.push(next);
        self.sizes.push(Sizes(size));
    }

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
        // What depends on the others keeps the share of the solution: its level, or nothing.
        for (i, state) in frictions.iter_mut().enumerate() {
            let direction = self.at_level[i];
            if state.sticks() && direction != 0.0 && !basis.contains(&Contact::Friction(i)) {
                *state = if direction > 0.0 { FrictionState::HeldUp } else { FrictionState::HeldDown };
            }
        }
        Mode { stops, frictions, basis }
    }
}

fn slipping(direction: f64) -> FrictionState {
    if direction > 0.0 { FrictionState::Up } else { FrictionState::Down }
}
