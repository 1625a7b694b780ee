//! Jumps of signals, at a knot or by an input: prescribed bodies may jump in coordinate and rate,
//! and bodies that links tie to them jump as well (docs/assembly-law.md, section 3, Jumps).

use super::Motion;
use crate::error::Error;
use crate::mode::StopState;
use crate::signals::Input;
use crate::system::Elongation;
use nalgebra::DVector;

/// The machine's state before its signals were set.
pub(super) struct Before {
    /// By body: coordinate and rate.
    bodies: Vec<[f64; 2]>,
    /// By stop: e - gap.
    excess: Vec<f64>,
    /// By friction: e'.
    rates: Vec<f64>,
    /// By body: the part of its rate due to prescribed bodies.
    prescribed: Vec<f64>,
    /// Stored energy, J.
    stored: f64,
}

/// The contacts that a jump has separated.
#[derive(Debug, Default)]
pub(super) struct Parted {
    /// Rigid stops that were closed and are open now.
    pub(super) stops: Vec<usize>,
    /// Frictions whose rate has jumped.
    pub(super) frictions: Vec<usize>,
}

impl Motion {
    /// Sets the `i`-th input from the present time on: value and derivatives of orders 1 to 3.
    ///
    /// # Errors
    /// As [`set_inputs`](Self::set_inputs).
    pub fn set_input(&mut self, i: usize, derivatives: Input) -> Result<(), Error> {
        self.set_inputs(&[(i, derivatives)])
    }

    /// Sets several inputs at once, each as [`set_input`](Self::set_input) does: prescribed bodies
    /// that touch may jump together.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] for values that are not finite; [`Error::Violated`] and
    /// [`Error::Jammed`] where inputs move prescribed bodies. No input is set then.
    pub fn set_inputs(&mut self, inputs: &[(usize, Input)]) -> Result<(), Error> {
        for (i, derivatives) in inputs {
            if let Some(&value) = derivatives.iter().find(|d| !d.is_finite()) {
                return Err(Error::OutOfRange {
                    name: format!("input {i}"),
                    value,
                    allowed: "a finite number".into(),
                });
            }
        }
        if inputs.is_empty() {
            return Ok(());
        }
        let before = self.hybrid.clone();
        let taken = self.pass_event(&mut None).and_then(|()| self.take_inputs(inputs));
        taken.inspect_err(|_| self.restore(&before))
    }

    fn take_inputs(&mut self, inputs: &[(usize, Input)]) -> Result<(), Error> {
        let stood = self.before_jump();
        for &(i, derivatives) in inputs {
            self.hybrid.inputs[i] = (self.time(), derivatives);
        }
        self.refill();
        self.set_anew(stood, &mut None)
    }

    /// The state before a jump; `None` for a machine without prescribed bodies.
    pub(super) fn before_jump(&self) -> Option<Before> {
        let (system, z) = (&self.assembly.system, &self.hybrid.z);
        system.has_motions.then(|| Before {
            bodies: system.bodies.iter().map(|b| [b.s.dot(z), b.v.dot(z)]).collect(),
            excess: system.stops.iter().map(|s| s.excess.dot(z)).collect(),
            rates: system.frictions.iter().map(|f| f.elongation.rate.dot(z)).collect(),
            prescribed: self.prescribed_rates(),
            stored: self.kinetic_and_stored().1,
        })
    }

    /// Completes the jump of prescribed bodies since `before`: bodies tied to them by links take
    /// their share. Returns the contacts that it has separated.
    pub(super) fn jump(&mut self, before: &Before) -> Parted {
        self.hybrid.sizes.include(self.hybrid.z.as_slice());
        let shares = [self.share(before, 0), self.share(before, 1)];
        let n = self.assembly.system.coordinates;
        for (first, share) in [0, n].into_iter().zip(shares) {
            if let Some(share) = share {
                let mut moved = self.hybrid.z.rows_mut(first, n);
                moved += share;
            }
        }
        self.hybrid.sizes.include(self.hybrid.z.as_slice());
        self.apart(before)
    }

    /// The change of the coordinates (`which` 0) or of their rates (1) at a jump of the prescribed
    /// bodies, M Δq = -Bᵀ m D Δp: the least change of the free bodies in the inertia's metric that
    /// their links allow, and the limit of ever faster continuous motions. `None` where no link
    /// takes part.
    fn share(&self, before: &Before, which: usize) -> Option<DVector<f64>> {
        let (system, z) = (&self.assembly.system, &self.hybrid.z);
        let mut pull = DVector::zeros(system.coordinates);
        let mut any = false;
        for ((body, &inertia), was) in system.bodies.iter().zip(&system.inertias).zip(&before.bodies) {
            let row = if which == 0 { &body.s } else { &body.v };
            let jump = row.dot(z) - was[which];
            if inertia > 0.0 && jump.abs() > self.hybrid.sizes.zero(row) {
                pull.axpy(-inertia * jump, &body.weights, 1.0);
                any = true;
            }
        }
        any.then(|| system.inertia.solve(&pull))
    }

    /// Refuses a jump that violates a rigid stop.
    pub(super) fn check_jump(&self, before: &Before) -> Result<(), Error> {
        let (stops, hybrid) = (&self.assembly.system.stops, &self.hybrid);
        for (i, stop) in stops.iter().enumerate().filter(|(_, stop)| stop.restitution().is_some()) {
            let (excess, zero) = (stop.excess.dot(&hybrid.z), hybrid.sizes.zero_of(&stop.excess));
            if excess > zero && excess - before.excess[i] > zero {
                return Err(self.violated(i, excess));
            }
        }
        Ok(())
    }

    /// The error of a violated rigid stop.
    pub(super) fn violated(&self, i: usize, excess: f64) -> Error {
        let stop = self.assembly.name_of_stop(i);
        Error::Violated { stop, time: self.time(), excess }
    }

    /// By body: the part (D p')ᵢ of its rate due to prescribed bodies.
    fn prescribed_rates(&self) -> Vec<f64> {
        let (system, z, n) = (&self.assembly.system, &self.hybrid.z, self.assembly.system.coordinates);
        let own = |v: &DVector<f64>| v.rows(n, n).dot(&z.rows(n, n));
        system.bodies.iter().map(|b| b.v.dot(z) - own(&b.v)).collect()
    }

    /// The work of prescribed motions at a jump: the links' impulses times the means of the
    /// prescribed rates before and after, and the change of the stored energy.
    pub(super) fn work_of_jump(&self, before: &Before) -> f64 {
        let (system, z) = (&self.assembly.system, &self.hybrid.z);
        let rates = before.prescribed.iter().zip(self.prescribed_rates());
        let bodies = system.bodies.iter().zip(&system.inertias).zip(&before.bodies);
        let impulses = bodies.map(|((body, inertia), was)| inertia * (body.v.dot(z) - was[1]));
        let kinetic: f64 = impulses.zip(rates).map(|(impulse, (was, is))| 0.5 * impulse * (was + is)).sum();
        kinetic + self.kinetic_and_stored().1 - before.stored
    }

    /// Contacts of the present mode that a jump has separated.
    fn apart(&self, before: &Before) -> Parted {
        let Self { assembly, hybrid, .. } = self;
        let (system, z) = (&assembly.system, &hybrid.z);
        let opened = |&(i, state): &(usize, &StopState)| {
            let excess = &system.stops[i].excess;
            *state == StopState::Closed && excess.dot(z) - before.excess[i] < -hybrid.sizes.zero_of(excess)
        };
        let jumped = |i: usize, e: &Elongation| {
            (e.rate.dot(z) - before.rates[i]).abs() > hybrid.sizes.zero_of(&e.rate)
        };
        let stops = hybrid.mode.stops.iter().enumerate().filter(opened).map(|(i, _)| i);
        let frictions = (0..system.frictions.len()).filter(|&i| jumped(i, &system.frictions[i].elongation));
        Parted { stops: stops.collect(), frictions: frictions.collect() }
    }
}
