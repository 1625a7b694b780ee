//! Jumps of prescribed bodies in coordinate and rate, at a knot of a signal or when an input is
//! set. Bodies linked to prescribed bodies jump as well (docs/assembly-law.md, section 3, Jumps).

use super::Motion;
use crate::error::Error;
use crate::mode::StopState;
use crate::signals::Input;
use crate::system::Elongation;
use nalgebra::DVector;

/// Tolerance for e > gap at a start, relative to the sizes of the terms of e - gap.
const START: f64 = 1e-13;

/// Values before signals jump. A jump is the difference from these values.
pub(super) struct BeforeJump {
    /// Coordinate and rate of each body.
    bodies: Vec<[f64; 2]>,
    /// Excess e - gap of each stop.
    pub(super) excess: Vec<f64>,
    /// Rate e' of each friction.
    rates: Vec<f64>,
    /// Elongation e of each branch.
    pub(super) branches: Vec<f64>,
    /// Part of each body's rate due to prescribed bodies, (D p')ᵢ.
    prescribed: Vec<f64>,
    /// Stored energy, J.
    stored: f64,
}

/// Contacts of the present mode that a jump has separated.
#[derive(Debug, Default)]
pub(super) struct Parted {
    /// Rigid stops that were closed and are open now, and freewheels whose rate has jumped.
    pub(super) stops: Vec<usize>,
    /// Frictions whose rate has jumped.
    pub(super) frictions: Vec<usize>,
    /// Whether sliders may no longer be at their levels.
    pub(super) sliders: bool,
}

impl Motion {
    /// Sets input `i` from the present time on: value and derivatives of orders 1 to 3.
    ///
    /// # Errors
    /// As [`set_inputs`](Self::set_inputs).
    ///
    /// # Examples
    /// A force of 3 N that grows by 6 N/s moves 1 kg from rest by 1.5 t² + t³:
    ///
    /// ```
    /// use vibro_machine::{Assembly, Motion, file};
    ///
    /// let text = r#"
    ///     name = "Driven"
    ///     body.a = { mass = 1.0 }
    ///     load.hand = { on = "a", input = true }
    /// "#;
    /// let machine = file::parse(text, "driven.toml", &file::no_records)?;
    /// let mut motion = Motion::new(Assembly::new(machine)?.into())?;
    /// motion.set_input(0, [3.0, 6.0, 0.0, 0.0])?;
    /// motion.advance_to(2.0)?;
    /// assert!((motion.coordinate(0) - 14.0).abs() < 1e-13);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn set_input(&mut self, i: usize, derivatives: Input) -> Result<(), Error> {
        self.set_inputs(&[(i, derivatives)])
    }

    /// Sets several inputs at once (see [`set_input`](Self::set_input)), so that prescribed bodies
    /// that touch can jump together.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] for a value that is not finite; [`Error::Violated`] and
    /// [`Error::Jammed`] if prescribed bodies move into or against stops. No input is set then.
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
            let from = (self.hybrid.time.value(), derivatives);
            self.assembly.system.signals.set_input(&mut self.hybrid.inputs, i, from);
        }
        self.refill();
        self.apply_jump(stood, &mut None)
    }

    /// Values before a possible jump; `None` for a machine without prescribed motions.
    pub(super) fn before_jump(&self) -> Option<BeforeJump> {
        let (system, z) = (&self.assembly.system, &self.hybrid.z);
        system.has_motions.then(|| BeforeJump {
            bodies: system.bodies.iter().map(|b| [b.s.dot(z), b.v.dot(z)]).collect(),
            excess: system.stops.iter().map(|s| s.excess.dot(z)).collect(),
            rates: system.frictions.iter().map(|f| f.elongation.rate.dot(z)).collect(),
            branches: system.elongations_in_series(z.as_slice()),
            prescribed: self.prescribed_rates(),
            stored: self.kinetic_and_stored().1,
        })
    }

    /// Completes a jump of prescribed bodies since `before` by moving the bodies that links tie to
    /// them. Returns the contacts that the jump separates.
    pub(super) fn jump(&mut self, before: &BeforeJump) -> Parted {
        self.include_state();
        let shares = [self.share(before, 0), self.share(before, 1)];
        let n = self.assembly.system.coordinates;
        for (first, share) in [0, n].into_iter().zip(shares) {
            if let Some(share) = share {
                let mut moved = self.hybrid.z.rows_mut(first, n);
                moved += share;
            }
        }
        self.stretch(&before.branches);
        self.assembly.system.fill_curved(self.hybrid.z.as_mut_slice());
        self.include_state();
        self.apart(before)
    }

    /// Returns the change Δq of the coordinates (`which` 0) or of their rates (1) at a jump Δp of
    /// the prescribed bodies: M Δq = -Bᵀ m D Δp. Among all motions that the links allow, this is
    /// the smallest in the inertia's metric, and the limit of ever faster continuous motions.
    /// `None` if no link takes part.
    fn share(&self, before: &BeforeJump, which: usize) -> Option<DVector<f64>> {
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

    /// Refuses a jump after which a rigid stop has e > gap and a larger e - gap than before.
    pub(super) fn check_jump(&self, before: &BeforeJump) -> Result<(), Error> {
        let (stops, hybrid) = (&self.assembly.system.stops, &self.hybrid);
        for (i, stop) in stops.iter().enumerate().filter(|(_, stop)| stop.keeps_gap()) {
            let (excess, zero) = (stop.excess.dot(&hybrid.z), hybrid.sizes.zero_of(&stop.excess));
            if excess > zero && excess - before.excess[i] > zero {
                return Err(self.violated(i, excess));
            }
        }
        Ok(())
    }

    /// Refuses a start with e > gap at a rigid stop. The tolerance is the rounding of the terms of
    /// e - gap, where `ways` adds to the coordinates' sizes.
    pub(super) fn check_stops(&self, ways: &[f64]) -> Result<(), Error> {
        let (system, z) = (&self.assembly.system, &self.hybrid.z);
        for (i, stop) in system.stops.iter().enumerate().filter(|(_, stop)| stop.keeps_gap()) {
            let excess = stop.excess.dot(z);
            let sizes = z.iter().enumerate().map(|(i, x)| x.abs() + ways.get(i).copied().unwrap_or(0.0));
            let terms: f64 = stop.excess.iter().zip(sizes).map(|(a, size)| (a * size).abs()).sum();
            if excess > START * terms {
                return Err(self.violated(i, excess));
            }
        }
        Ok(())
    }

    /// Error for a rigid stop with e > gap.
    pub(super) fn violated(&self, i: usize, excess: f64) -> Error {
        let stop = self.assembly.name_of_stop(i);
        Error::Violated { stop, time: self.time(), excess }
    }

    /// Part of each body's rate due to prescribed bodies, (D p')ᵢ.
    fn prescribed_rates(&self) -> Vec<f64> {
        let (system, z, n) = (&self.assembly.system, &self.hybrid.z, self.assembly.system.coordinates);
        let own = |v: &DVector<f64>| v.rows(n, n).dot(&z.rows(n, n));
        system.bodies.iter().map(|b| b.v.dot(z) - own(&b.v)).collect()
    }

    /// Work of the prescribed motions in a jump, J: the links' impulses times the mean of the
    /// prescribed rates before and after, plus the change of the stored energy.
    pub(super) fn work_of_jump(&self, before: &BeforeJump) -> f64 {
        let (system, z) = (&self.assembly.system, &self.hybrid.z);
        let rates = before.prescribed.iter().zip(self.prescribed_rates());
        let bodies = system.bodies.iter().zip(&system.inertias).zip(&before.bodies);
        let impulses = bodies.map(|((body, inertia), was)| inertia * (body.v.dot(z) - was[1]));
        let kinetic: f64 = impulses.zip(rates).map(|(impulse, (was, is))| 0.5 * impulse * (was + is)).sum();
        kinetic + self.kinetic_and_stored().1 - before.stored
    }

    /// Returns the contacts of the present mode that a jump has separated.
    fn apart(&self, before: &BeforeJump) -> Parted {
        let Self { assembly, hybrid, .. } = self;
        let (system, z) = (&assembly.system, &hybrid.z);
        let opened = |&(i, state): &(usize, &StopState)| {
            let excess = &system.stops[i].excess;
            let (change, zero) = (excess.dot(z) - before.excess[i], hybrid.sizes.zero_of(excess));
            // A freewheel whose rate has jumped upwards has an impact.
            let jumps = system.stops[i].is_freewheel && change > zero;
            *state == StopState::Closed && (change < -zero || jumps)
        };
        let jumped = |i: usize, e: &Elongation| {
            (e.rate.dot(z) - before.rates[i]).abs() > hybrid.sizes.zero_of(&e.rate)
        };
        let stops = hybrid.mode.stops.iter().enumerate().filter(opened).map(|(i, _)| i);
        let frictions = (0..system.frictions.len()).filter(|&i| jumped(i, &system.frictions[i].elongation));
        Parted { stops: stops.collect(), frictions: frictions.collect(), sliders: true }
    }
}
