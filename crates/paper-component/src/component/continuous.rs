//! The model for a host's own solver: states, derivatives, event indicators, and laws at events.

mod law;
mod varied;

use super::problem::ComponentProblem;
use super::values::{Approach, OutputValues, coupling_force};
use super::variation::{Velocities, quadrature, velocities};
use serde::{Deserialize, Serialize};
use vibro_impact::energy;
use vibro_impact::error::Error;
use vibro_impact::model::{
    Acceleration, Augmented, COORDINATES, DRIVE_COS, DRIVE_SIN, Model, RELATIVE, RELATIVE_RATE, SmoothMode,
};
use vibro_impact::parameters::Parameters;
use vibro_impact::simulator::{Contact, ImpactRecord, Simulator, State, check_time};
use vibro_numerics::double_double::DoubleDouble;
use vibro_numerics::drive_phase::DrivePhase;

/// All changing data.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Data {
    parameters: Parameters,
    time: f64,
    state: State,
    contact: Contact,
    phase: DrivePhase,
    forces: [f64; 3],
    record: ImpactRecord,
    /// Mechanical energy at the start, damped energy up to the last accepted step, impact losses.
    initial: f64,
    damped: f64,
    lost: f64,
    accepted: Point,
}

impl Data {
    /// Refuses numbers that no motion can have. Only a damaged saved state has such numbers.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] with the name of the number that is not finite.
    fn check(&self) -> Result<(), Error> {
        let at = &self.accepted;
        let points = [(&self.state, &self.forces, self.time), (&at.state, &at.forces, at.time)];
        let numbers = points.iter().flat_map(|(s, f, t)| s.x.iter().chain(&s.v).chain(f.iter()).chain([t]));
        let ImpactRecord { total_impulse, box_impulse, .. } = self.record;
        let sums = [self.initial, self.damped, self.lost, total_impulse, box_impulse];
        match numbers.chain(&sums).find(|x| !x.is_finite()) {
            None if self.phase.is_sound() => Ok(()),
            found => {
                let value = found.copied().unwrap_or(f64::NAN);
                Err(Error::OutOfRange { name: "saved state", value, allowed: "finite numbers" })
            }
        }
    }
}

/// The last accepted step or event; contact and parameters have not changed since.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
struct Point {
    time: f64,
    state: State,
    forces: [f64; 3],
}

/// The model for a host's solver.
#[derive(Clone, Debug)]
pub(crate) struct Continuous {
    data: Data,
    model: Model,
}

impl Continuous {
    /// The motion at the start of a simulation.
    ///
    /// # Errors
    /// As [`Simulator::new`].
    pub(crate) fn start(simulator: &Simulator, forces: [f64; 3]) -> Result<Self, Error> {
        Self::at(simulator.parameters(), simulator.state(), simulator.time(), simulator.contact(), forces)
    }

    /// A motion that begins in a given contact; also for trial evaluations at the start.
    pub(crate) fn at(
        parameters: &Parameters,
        state: State,
        time: f64,
        contact: Contact,
        forces: [f64; 3],
    ) -> Result<Self, Error> {
        let mut motion = Self::of(Data {
            parameters: *parameters,
            time,
            state,
            contact,
            phase: DrivePhase::new(parameters.drive_phase),
            forces,
            record: ImpactRecord::default(),
            initial: 0.0,
            damped: 0.0,
            lost: 0.0,
            accepted: Point::default(),
        })?;
        motion.anchor();
        // The input energy starts at 0.
        motion.data.initial = motion.values().mechanical;
        Ok(motion)
    }

    pub(crate) fn of(data: Data) -> Result<Self, Error> {
        data.check()?;
        Ok(Self { data, model: Model::new(&data.parameters)? })
    }

    /// Returns to given [`data`](Self::data).
    ///
    /// # Errors
    /// As [`of`](Self::of); then nothing has changed.
    pub(crate) fn restore(&mut self, data: Data) -> Result<(), Error> {
        data.check()?;
        if data.parameters != self.data.parameters {
            self.model = Model::new(&data.parameters)?;
        }
        self.data = data;
        Ok(())
    }

    pub(crate) fn data(&self) -> Data {
        self.data
    }

    pub(crate) fn contact(&self) -> Contact {
        self.data.contact
    }

    pub(crate) fn impacts(&self) -> &ImpactRecord {
        &self.data.record
    }

    pub(crate) fn time(&self) -> f64 {
        self.data.time
    }

    /// # Errors
    /// [`Error::PrecisionLost`]; then nothing has changed.
    pub(crate) fn set_time(&mut self, time: f64) -> Result<(), Error> {
        check_time(self.model.rate, time)?;
        self.data.time = time;
        Ok(())
    }

    pub(crate) fn state(&self) -> State {
        self.data.state
    }

    pub(crate) fn set_state(&mut self, state: State) {
        self.data.state = state;
    }

    pub(crate) fn set_forces(&mut self, forces: [f64; 3]) {
        self.data.forces = forces;
    }

    /// Sets the parameters immediately; the drive's phase stays continuous. The energy that the
    /// change adds to springs and masses counts as input, since the input is the remainder of the
    /// energy balance.
    ///
    /// # Errors
    /// As [`Simulator::set_parameters`]; then nothing has changed.
    pub(crate) fn set_parameters(&mut self, parameters: &Parameters) -> Result<(), Error> {
        let old = self.data.parameters;
        let model = Model::new(parameters)?;
        check_time(model.rate, self.data.time)?;
        let phases = (old.drive_phase, parameters.drive_phase);
        if parameters.drive_frequency != old.drive_frequency || phases.0 != phases.1 {
            self.data.phase.rebase(old.drive_frequency, DoubleDouble::new(self.data.time), phases);
        }
        self.data.parameters = *parameters;
        self.model = model;
        self.anchor();
        Ok(())
    }

    fn mode(&self) -> SmoothMode {
        self.data.contact.mode()
    }

    fn now(&self) -> Point {
        Point { time: self.data.time, state: self.data.state, forces: self.data.forces }
    }

    fn augmented(&self) -> Augmented {
        self.augmented_at(&self.now())
    }

    fn augmented_at(&self, at: &Point) -> Augmented {
        let mut z = [0.0; COORDINATES];
        z[..6].copy_from_slice(&at.state.to_relative());
        let theta = self.data.phase.angle(self.model.omega, DoubleDouble::new(at.time));
        (z[DRIVE_SIN], z[DRIVE_COS]) = theta.sin_cos();
        z
    }

    /// x1'', x2'', x3'' and the free relative acceleration.
    fn accelerations(&self) -> ([f64; 3], f64) {
        let Acceleration { coordinates: a, free } =
            self.model.acceleration(self.mode(), &self.augmented(), Some(self.data.forces));
        ([a[0], a[0] + a[1], a[2]], free)
    }

    /// Time derivatives of x1, x2, x3, v1, v2, v3.
    pub(crate) fn derivatives(&self) -> [f64; 6] {
        let (v, (a, _)) = (self.data.state.v, self.accelerations());
        [v[0], v[1], v[2], a[0], a[1], a[2]]
    }

    /// Event indicators. In flight: the distances to the upper and lower stop, in gaps. In rest:
    /// the free relative acceleration that presses the block on the stop, in units of the largest
    /// acceleration by springs and drive at a displacement of one gap.
    pub(crate) fn indicators(&self) -> [f64; 3] {
        let (m, State { x, .. }) = (&self.model, &self.data.state);
        let pressing = self.data.contact.side() * self.accelerations().1;
        let approach = Approach { gap: m.gap, w: x[1] - x[0], pressing, spring: m.k1 + m.k2, drive: m.drive };
        approach.indicators(self.data.contact)
    }

    /// Whether an accepted point is past an event that the host has missed. In flight the block
    /// then overlaps a stop and moves further into it; in rest the stop no longer presses on the
    /// block. Solvers of fixed step may miss an event, since they compare indicators across an
    /// event or step over two changes of sign.
    pub(crate) fn missed_event(&self) -> bool {
        match self.data.contact {
            Contact::Flight => {
                let State { x, v } = &self.data.state;
                let w = x[1] - x[0];
                w.abs() >= self.model.gap && w.signum() * (v[1] - v[0]) > 0.0
            }
            contact => contact.side() * self.accelerations().1 <= 0.0,
        }
    }

    /// Accepts the present point: the damped energy is accumulated up to it.
    pub(crate) fn accept(&mut self) {
        self.data.damped = self.damped();
        self.anchor();
    }

    /// Makes the present point the beginning of the next interval of the damped energy.
    fn anchor(&mut self) {
        let Data { time, state, forces, .. } = self.data;
        self.data.accepted = Point { time, state, forces };
    }

    /// v1 and v3 with three derivatives each at a point; `slope` is the time derivative of the
    /// forces.
    fn velocities(&self, at: &Point, slope: [f64; 3]) -> Velocities {
        velocities(&self.model, self.mode(), &self.augmented_at(at), at.forces, slope)
    }

    /// Damped energy up to now. The open interval is integrated by two-point Hermite quadrature
    /// with three derivatives at each end (an error of h⁹); the forces are linear between its
    /// ends.
    fn damped(&self) -> f64 {
        let (from, now) = (self.data.accepted, self.now());
        let h = now.time - from.time;
        if h == 0.0 {
            return self.data.damped;
        }
        let slope = std::array::from_fn(|i| (now.forces[i] - from.forces[i]) / h);
        let (a, b) = (self.velocities(&from, slope), self.velocities(&now, slope));
        self.data.damped + quadrature(h, &self.power(&a, &a), &self.power(&b, &b))
    }

    /// c1 v1 w1 + c3 v3 w3 with three derivatives, by Leibniz' rule.
    fn power(&self, v: &Velocities, w: &Velocities) -> [f64; 4] {
        let (p, mut power) = (&self.data.parameters, [0.0; 4]);
        for ((c, v), w) in [p.box_damping, p.secondary_damping].iter().zip(v).zip(w) {
            power[0] += c * (v[0] * w[0]);
            power[1] += c * (v[0] * w[1] + v[1] * w[0]);
            power[2] += c * (v[0] * w[2] + 2.0 * v[1] * w[1] + v[2] * w[0]);
            power[3] += c * (v[0] * w[3] + 3.0 * (v[1] * w[2] + v[2] * w[1]) + v[3] * w[0]);
        }
        power
    }

    /// Values of the outputs at the present point. In rest the relative displacement is exactly
    /// one gap, free of the solver's rounding.
    pub(crate) fn values(&self) -> OutputValues {
        let (data, (a, free)) = (&self.data, self.accelerations());
        let z = self.augmented();
        let (relative, contact_force) = match data.contact {
            Contact::Flight => ((z[RELATIVE], z[RELATIVE_RATE]), 0.0),
            contact => {
                let force = self.model.reduced_mass * contact.side() * free;
                ((contact.side() * self.model.gap, 0.0), if force > 0.0 { force } else { 0.0 })
            }
        };
        let mut y = [0.0; 6];
        y.copy_from_slice(&z[..6]);
        let (mechanical, damped) = (energy::mechanical(&data.parameters, &y), self.damped());
        OutputValues {
            time: data.time,
            x: data.state.x,
            v: data.state.v,
            acceleration: a,
            relative,
            contact_force,
            coupling_force: coupling_force(&data.parameters, &data.state.x),
            indicators: self.indicators(),
            mechanical,
            // The input is the remainder of the energy balance of the host's solution; it contains
            // the errors of the host's solver (docs/theory.md, section 12).
            input: mechanical - data.initial + damped + data.lost,
            damped,
            impact_loss: data.lost,
            contact: data.contact,
            impacts: data.record,
        }
    }
}

/// A set of states that is not finite.
pub(crate) fn check_states(states: &[f64; 6]) -> Result<State, ComponentProblem> {
    for (name, value) in super::structure::STATES.iter().zip(states) {
        if !value.is_finite() {
            return Err(ComponentProblem::value(name, *value, "a finite number"));
        }
    }
    let [x1, x2, x3, v1, v2, v3] = *states;
    Ok(State { x: [x1, x2, x3], v: [v1, v2, v3] })
}
