//! The event-driven simulator: exact flow between events, event location with proof, and the
//! event's law at each event.
//!
//! A communication step is a reporting interval, not an integration step: ten steps of h and one
//! of 10 h agree to round-off. Advancing does not allocate, with one exception: a table that is
//! shared with another simulator is copied when it is first filled.
//!
//! Four kernels advance a motion by a sub-step. For each kernel the list gives its use, its proof
//! against missed events, and the inputs of its bits.
//!
//! - `flight_substep` (`flight.rs`), for flight without loads with more than an interval to go.
//!   Proof: samples of w and a bound on w''; dominance in the intervals that these do not clear.
//!   Bits: depend on the instruction set.
//! - `short_flight_substep` (`flight.rs`), for flight without loads with at most an interval to go
//!   and both ends clear of the stops. Proof: the bound on w'' over the interval. Bits: depend on
//!   the instruction set.
//! - `general_substep` (`general.rs`), for rest, loads, fast blocks, and all sub-steps that the
//!   first two kernels do not take. Proof: samples of w or the contact force, and a bound;
//!   dominance on series. Bits: equal on all instruction sets.
//! - `batch/`, for many flights side by side without loads and energy accounts. Proof: samples of
//!   w and a bound on w''; dominance in vectors. Bits: independent of the other motions, but
//!   different from the bits of the kernels above.
//!
//! The first three end in `finish_substep` (`step.rs`), which applies the event's law
//! (`contact.rs`) and limits the work. `batch/` applies the law of plain impacts in its lanes and
//! leaves rest, chatter and release to `finish_substep`. The statements and their error bounds are
//! in `docs/numerics.md`.

mod account;
mod advance;
mod batch;
mod contact;
mod departure;
mod flight;
mod general;
mod limits;
mod points;
mod snapshot;
mod step;
mod tables;
mod types;

pub use batch::{
    LaneUse, Maximum, MotionQueue, Plan, Reports, TOGETHER, Way, advance_queue, advance_queue_by,
    advance_together,
};
pub use snapshot::Snapshot;
pub use step::EventObserver;
pub use types::{
    AdvanceOutcome, Contact, DueEvent, EnergyAccounts, Event, ImpactRecord, Loads, Pause, WorkCounters,
};

use crate::energy::{self, Pending, Sums};
use crate::error::{Error, Result};
use crate::flow::{self, Series};
use crate::model::{Acceleration, COORDINATES, DRIVE_COS, DRIVE_SIN, Forces, Model};
pub use crate::model::{Augmented, SmoothMode};
use crate::parameters::Parameters;
pub use crate::state::State;
use departure::Departure;
pub use limits::check_time;
use limits::{check_constant_forces, check_loads, check_speeds, coordinates};
use serde::{Deserialize, Serialize};
use std::sync::Arc;
use tables::ModeTables;
pub use vibro_numerics::double_double::DoubleDouble;
use vibro_numerics::drive_phase::DrivePhase;

/// Everything that changes as the simulator advances.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct HybridState {
    time: DoubleDouble,
    /// x1, w, x3 and their rates.
    y: [f64; 6],
    contact: Contact,
    /// Order of the first derivative of w that leads away from the stop, in flight from a stop;
    /// otherwise 0.
    departing: u8,
    /// Whether the order of departure is uncertain, because all derivatives were within rounding.
    doubtful: bool,
    /// Start of the flight from a stop, while w still rounds to that stop.
    departure: Option<Departure>,
    /// Event that the motion has reached. Its law is not yet applied.
    due: Option<DueEvent>,
    phase: DrivePhase,
    loads: Forces,
    loads_from: DoubleDouble,
    record: ImpactRecord,
    sums: Sums,
}

impl HybridState {
    /// Checks a start. It counts as flight until its contact is classified, and has no loads.
    fn new(parameters: &Parameters, model: &Model, state: &State, time: f64) -> Result<Self> {
        if !time.is_finite() {
            return Err(Error::OutOfRange { name: "time", value: time, allowed: "a finite number" });
        }
        check_time(model.rate, time)?;
        let y = coordinates(parameters, state)?;
        check_constant_forces(model)?;
        check_speeds(model, state)?;
        Ok(Self {
            time: DoubleDouble::new(time),
            y,
            contact: Contact::Flight,
            departing: 0,
            doubtful: false,
            departure: None,
            due: None,
            phase: DrivePhase::new(parameters.drive_phase),
            loads: [[0.0; 4]; 3],
            loads_from: DoubleDouble::new(time),
            record: ImpactRecord::default(),
            sums: Sums::default(),
        })
    }
}

/// The event-driven simulator of one system.
#[derive(Clone, Debug)]
pub struct Simulator {
    parameters: Parameters,
    model: Model,
    substep: f64,
    /// Tables of flight, shared by simulators that were made from one another.
    flight: Arc<ModeTables>,
    /// Tables of rest, shared in the same way.
    rest: Arc<ModeTables>,
    hybrid: HybridState,
    pending: Pending,
    work: WorkCounters,
    keeps_energy_accounts: bool,
}

impl Simulator {
    /// Starts at `time` (s) from `state`, without loads. The drive's phase is
    /// `ω1 time + drive.phase`.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] if a parameter, the state or the time is out of range;
    /// [`Error::Penetration`] if the block is outside the stops; [`Error::PrecisionLost`] if
    /// double precision does not resolve the motion.
    pub fn new(parameters: &Parameters, state: &State, time: f64) -> Result<Self> {
        let model = Model::new(parameters)?;
        let hybrid = HybridState::new(parameters, &model, state, time)?;
        let mut simulator = Self {
            parameters: *parameters,
            substep: flow::substep(&model),
            model,
            flight: Arc::new(ModeTables::zero()),
            rest: Arc::new(ModeTables::zero()),
            hybrid,
            pending: Pending::default(),
            work: WorkCounters::default(),
            keeps_energy_accounts: true,
        };
        simulator.renew_tables();
        simulator.classify_contact();
        Ok(simulator)
    }

    /// Another simulator of this system without loads, at `time` (s) and `state`. It shares this
    /// simulator's tables, so that its cost is small.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn with_state(&self, state: &State, time: f64) -> Result<Self> {
        let hybrid = HybridState::new(&self.parameters, &self.model, state, time)?;
        let mut simulator = Self { hybrid, work: WorkCounters::default(), ..self.clone() };
        simulator.classify_contact();
        Ok(simulator)
    }

    /// Restarts this simulator in its memory, bit-identical to [`new`](Self::new). Nothing is
    /// allocated unless another simulator shares the tables, and with unchanged parameters the
    /// tables are kept. Whether energy accounts are kept does not change.
    ///
    /// ```
    /// use vibro_impact::{Parameters, Simulator, State};
    ///
    /// let p = Parameters::default();
    /// let mut one = Simulator::new(&p, &State::default(), 0.0)?;
    /// one.advance_to(10.0)?;
    /// let other = Parameters { stop_restitution: 0.5, ..p };
    /// let start = State { x: [0.0, 0.4, 0.0], v: [0.0; 3] };
    /// one.restart(&other, &start, 3.0)?;
    /// assert_eq!(one.snapshot(), Simulator::new(&other, &start, 3.0)?.snapshot());
    /// # Ok::<(), vibro_impact::Error>(())
    /// ```
    ///
    /// # Errors
    /// As [`new`](Self::new); nothing has changed then.
    pub fn restart(&mut self, parameters: &Parameters, state: &State, time: f64) -> Result<()> {
        let same = *parameters == self.parameters;
        let model = if same { self.model } else { Model::new(parameters)? };
        self.hybrid = HybridState::new(parameters, &model, state, time)?;
        (self.pending, self.work) = (Pending::default(), WorkCounters::default());
        if !same {
            self.install(parameters, model);
        }
        self.classify_contact();
        Ok(())
    }

    /// This simulator without the accounts of input and damped energy, for sweeps that do not need
    /// them.
    #[must_use]
    pub fn without_energy_accounts(mut self) -> Self {
        self.keeps_energy_accounts = false;
        self
    }

    /// The parameters in force.
    pub fn parameters(&self) -> &Parameters {
        &self.parameters
    }

    /// Sets the parameters at the present time. A change of drive frequency keeps the drive's
    /// phase continuous, a change of drive phase shifts it. Energy that the change itself adds to
    /// springs and masses counts as input. Loads in force stay, even if
    /// [`set_loads`](Self::set_loads) would refuse them for the new machine.
    ///
    /// An impact that is [due](Self::due_event) stays due while the block touches the stop, and
    /// its law uses the new values. After every change the contact is determined again, and so is
    /// a release that is due.
    ///
    /// # Errors
    /// As [`new`](Self::new); nothing has changed then.
    pub fn set_parameters(&mut self, parameters: &Parameters) -> Result<()> {
        if *parameters == self.parameters {
            return Ok(());
        }
        let model = Model::new(parameters)?;
        check_time(model.rate, self.time())?;
        check_constant_forces(&model)?;
        check_speeds(&model, &self.state())?;
        let gap_changed = parameters.stop_gap != self.parameters.stop_gap;
        let y = if gap_changed { coordinates(parameters, &self.state())? } else { self.hybrid.y };
        let before = energy::mechanical(&self.parameters, &self.hybrid.y);
        let (time, phases) = (self.hybrid.time, (self.parameters.drive_phase, parameters.drive_phase));
        if parameters.drive_frequency != self.parameters.drive_frequency || phases.0 != phases.1 {
            self.hybrid.phase.rebase(self.parameters.drive_frequency, time, phases);
        }
        self.hybrid.y = y;
        let gained = energy::mechanical(parameters, &y) - before;
        self.hybrid.sums.input = self.hybrid.sums.input.plus(gained);
        self.install(parameters, model);
        self.classify_contact();
        Ok(())
    }

    /// Sets the parameters and their model, which the caller has checked, and renews the tables.
    fn install(&mut self, parameters: &Parameters, model: Model) {
        self.parameters = *parameters;
        self.substep = flow::substep(&model);
        self.model = model;
        self.renew_tables();
    }

    /// Sets the loads, as polynomials in the time from now, until they are set again. The constant
    /// loads of the [parameters](Parameters::constant_loads) add to them. An event that is due is
    /// treated as in [`set_parameters`](Self::set_parameters).
    ///
    /// # Errors
    /// [`Error::OutOfRange`] if a load is not finite, and [`Error::PrecisionLost`] if it is too
    /// large for the system in double precision; nothing has changed then.
    pub fn set_loads(&mut self, loads: &Loads) -> Result<()> {
        const NAMES: [&str; 3] = ["box.f", "block.f", "secondary.f"];
        for (name, derivatives) in NAMES.iter().zip(&loads.derivatives) {
            if let Some(&value) = derivatives.iter().find(|d| !d.is_finite()) {
                return Err(Error::OutOfRange { name, value, allowed: "a finite number" });
            }
        }
        check_loads(&self.model, &loads.derivatives)?;
        let before =
            flow::shifted(&self.hybrid.loads, self.hybrid.time.minus(self.hybrid.loads_from).value());
        let unchanged = before == loads.derivatives;
        self.hybrid.loads = loads.derivatives;
        self.hybrid.loads_from = self.hybrid.time;
        if !unchanged {
            self.prepare_load_tables();
            self.classify_contact();
        }
        Ok(())
    }

    /// Fastest rate r of the system, 1/s (docs/numerics.md, section 1).
    #[doc(hidden)]
    pub fn fastest_rate(&self) -> f64 {
        self.model.rate
    }

    /// Present time, s.
    pub fn time(&self) -> f64 {
        self.hybrid.time.value()
    }

    /// Displacements and velocities of the three bodies.
    pub fn state(&self) -> State {
        State::from_relative(&self.hybrid.y)
    }

    /// Whether the block flies or rests, and at which stop.
    pub fn contact(&self) -> Contact {
        self.hybrid.contact
    }

    /// Accelerations of the three bodies (resting contact included), m/s².
    pub fn acceleration(&self) -> [f64; 3] {
        let a = self.accelerations().coordinates;
        [a[0], a[0] + a[1], a[2]]
    }

    /// Time derivatives of the three displacements, `[body][order]` for orders 0…5, m/s^order.
    pub fn derivatives(&self) -> [[f64; 6]; 3] {
        let forces = self.forces_now();
        let radius = 1.0 / self.model.rate;
        let series = Series::<6>::expand(&self.model, self.mode(), &self.augmented(), Some(&forces), radius);
        series.derivatives(self.model.rate)
    }

    /// Relative displacement w = x2 - x1 (m) and its rate (m/s): exactly ±L and 0 in rest.
    pub fn relative_motion(&self) -> (f64, f64) {
        (self.hybrid.y[1], self.hybrid.y[4])
    }

    /// Contact force λ in N (docs/theory.md (14)): positive in resting contact at either stop,
    /// where it pushes block and box apart, and exactly 0 in flight. On the box it acts in the
    /// direction of the stop, `contact().side() * λ`, and on the block in the opposite direction.
    /// Impulses of impacts are not part of it.
    pub fn contact_force(&self) -> f64 {
        let side = self.hybrid.contact.side();
        let force = self.model.reduced_mass * side * self.accelerations().free;
        if force > 0.0 { force } else { 0.0 } // never -0
    }

    /// Drive phase θ in [-π, π], rad; the drive's force is F10 sin θ.
    #[inline]
    pub fn drive_phase(&self) -> f64 {
        self.hybrid.phase.angle(self.model.omega, self.hybrid.time)
    }

    /// Present loads with their derivatives: the sum of the loads that were set and the constant
    /// loads.
    pub fn loads(&self) -> Loads {
        Loads { derivatives: self.forces_now() }
    }

    /// Energy accounts; input and damped are zero for a simulator
    /// [`without_energy_accounts`](Self::without_energy_accounts).
    pub fn energy_accounts(&self) -> EnergyAccounts {
        let Sums { input, damped, impact } = self.hybrid.sums;
        EnergyAccounts {
            mechanical: energy::mechanical(&self.parameters, &self.hybrid.y),
            input: input.value(),
            damped: damped.value(),
            impact: impact.value(),
        }
    }

    /// Energy lost in impacts so far, J: [`EnergyAccounts::impact`] without the other accounts.
    #[inline]
    pub fn impact_loss(&self) -> f64 {
        self.hybrid.sums.impact.value()
    }

    /// Record of the impacts so far.
    pub fn impacts(&self) -> &ImpactRecord {
        &self.hybrid.record
    }

    /// Work done so far by this simulator; not part of a snapshot.
    pub fn work_counters(&self) -> &WorkCounters {
        &self.work
    }

    #[inline(always)]
    fn mode(&self) -> SmoothMode {
        self.hybrid.contact.mode()
    }

    /// Augmented state: x1, w, x3, their rates, cos θ and sin θ.
    #[inline(always)]
    pub fn augmented(&self) -> Augmented {
        let mut z = [0.0; COORDINATES];
        z[..6].copy_from_slice(&self.hybrid.y);
        let angle = self.drive_phase();
        (z[DRIVE_SIN], z[DRIVE_COS]) = angle.sin_cos();
        z
    }

    #[inline(always)]
    fn forces_now(&self) -> Forces {
        let mut forces =
            flow::shifted(&self.hybrid.loads, self.hybrid.time.minus(self.hybrid.loads_from).value());
        for (force, constant) in forces.iter_mut().zip(&self.model.constant_loads) {
            force[0] += constant;
        }
        forces
    }

    fn accelerations(&self) -> Acceleration {
        let f = self.forces_now();
        self.model.acceleration(self.mode(), &self.augmented(), Some(f.map(|d| d[0])))
    }

    fn loaded(&self) -> bool {
        self.hybrid.loads != [[0.0; 4]; 3] || self.model.constant_loads != [0.0; 3]
    }
}
