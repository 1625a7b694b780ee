//! A motion: the state of a machine that advances from event to event, exactly.
//!
//! Between events the augmented state follows z' = A z of the [mode](Mode) in force
//! (docs/assembly-law.md (A5)): `step` advances by sub-steps, `passage` finds the first root of a
//! watched functional or proves that there is none, `long` joins sub-steps of a stiff machine. At
//! an event `contact` applies the law; `lone` is its shortcut where one element alone is concerned.
//! `course` applies the law where a host's solver integrates between events.
//!
//! [`Hybrid`] holds all that a saved state needs. The rest of [`Motion`] is settings, caches and
//! buffers; caches and buffers must not influence its bits, so that a resumed motion is
//! bit-identical to one that was never saved.

mod change;
mod contact;
mod course;
mod event;
mod jump;
mod limits;
mod lone;
mod long;
mod low_bounce;
mod passage;
mod projection;
mod report;
pub(crate) mod saved;
mod step;
mod tables;
mod values;
mod variation;
mod varied;

pub use course::Course;
pub use event::{Event, EventKind};
pub use varied::{Crossing, keep};

use crate::assembly::Assembly;
use crate::error::Error;
use crate::flow::{Ahead, DepartureRows, FlowTable, Group};
use crate::law::Sizes;
use crate::mode::{Mode, Watch};
use crate::signals::Input;
use jump::Parted;
use nalgebra::DVector;
use serde::{Deserialize, Serialize};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use tables::Tables;
use vibro_impact::numerics::double_double::DoubleDouble;

/// Callback for the events of an advance.
pub type Observer<'a> = Option<&'a mut dyn FnMut(&Event)>;

/// The end of an advance.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reached {
    /// At the time asked for.
    End,
    /// At an event: after its law or, for [`Motion::advance_before_event`], before it.
    Event,
}

/// A pending event, whose law is not applied yet.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
enum Due {
    /// A watched functional passes zero.
    Passage(Watch),
    /// A signal's knot.
    Knot,
}

/// The impacts of a stop since the start.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct StopRecord {
    /// Number of impacts.
    pub count: u64,
    /// Impulse of the last impact, N s.
    pub impulse: f64,
}

impl StopRecord {
    fn add(&mut self, impulse: f64) {
        *self = Self { count: self.count + 1, impulse };
    }
}

/// Complete hybrid state of a motion: what a saved state holds.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Hybrid {
    time: DoubleDouble,
    /// Start of the flight not yet taken into the sizes, s (docs/assembly-law.md (A14)).
    since: f64,
    #[serde(with = "saved::vector")]
    z: DVector<f64>,
    mode: Mode,
    /// By watched functional: order of its zero at the last event, 0 for no zero, `ORDERS` for zero
    /// throughout the mode.
    departing: Vec<usize>,
    sizes: Sizes,
    /// By input: time at which it was set, value and derivatives there.
    inputs: Vec<(f64, Input)>,
    /// Impacts by stop.
    impacts: Vec<StopRecord>,
    energy: crate::energy::Accounts,
    /// Events since time last advanced.
    chain: usize,
    /// Whole sub-steps since the last event or the last attempt at a long sub-step.
    carried: u32,
    /// Sub-steps since the signals were last computed from the clock.
    turns: u32,
    /// Functional whose zero was the last event.
    last: Option<Watch>,
    /// Pending event: reached, its law not applied yet.
    due: Option<Due>,
}

/// A motion of a machine.
#[derive(Clone, Debug)]
pub struct Motion {
    assembly: Arc<Assembly>,
    hybrid: Hybrid,
    tables: Tables,
    /// Index in `tables` of the mode in force.
    place: usize,
    /// Relative overshoot at an event; 0 unless a host integrates.
    overshoot: f64,
    /// Whether the general law decides at every event.
    is_general: bool,
    /// Limit of sub-steps in one call.
    most_work: u64,
    /// Flag by which another thread interrupts a call.
    asked: Option<Arc<AtomicBool>>,
    scratch: Scratch,
    vectors: pulp::Arch,
}

/// Buffers of a sub-step, reused to avoid allocation.
#[derive(Clone, Debug, Default)]
struct Scratch {
    /// By group of watched functionals: value, slope and bound of the curvature at the start.
    heads: Vec<Group>,
    /// By watched functional: bits of the intervals in which it may pass zero.
    near: Vec<u8>,
    /// State at the start of `interval`, or a copy of the state at an event.
    start: DVector<f64>,
    /// Interval of the sub-step that `start` and `ahead` belong to.
    interval: Option<usize>,
    ahead: Ahead,
    /// z' at the start of a long sub-step, or of one that computes elastic forces separately.
    rates: Vec<f64>,
    /// z'' at that start.
    second: Vec<f64>,
    /// Memory of `FlowTable::departure`.
    rows: DepartureRows,
    /// By contact: its deviation from the constraint.
    off: Vec<f64>,
    /// By functional of the powers: values at the quadrature nodes.
    values: Vec<crate::energy::AtNodes>,
}

impl Motion {
    /// Starts a motion at time 0 from the machine's start values.
    ///
    /// # Errors
    /// [`Error::Jammed`] where prescribed bodies drive stops together at the start.
    pub fn new(assembly: Arc<Assembly>) -> Result<Self, Error> {
        Self::starting_at(assembly, 0.0)
    }

    /// Starts a motion at time 0 and reports the impacts at the start to `observer`.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn new_observed(assembly: Arc<Assembly>, observer: &mut dyn FnMut(&Event)) -> Result<Self, Error> {
        Self::begin(assembly, 0.0, &mut Some(observer))
    }

    /// Starts a motion at `time`, s: bodies have their start values, signals their values at that
    /// time.
    ///
    /// # Errors
    /// As [`new`](Self::new); [`Error::OutOfRange`] for a time that is not finite.
    pub fn starting_at(assembly: Arc<Assembly>, time: f64) -> Result<Self, Error> {
        Self::begin(assembly, time, &mut None)
    }

    fn begin(assembly: Arc<Assembly>, time: f64, observer: &mut Observer) -> Result<Self, Error> {
        if !time.is_finite() {
            return Err(Error::OutOfRange {
                name: "start time".into(),
                value: time,
                allowed: "a finite number".into(),
            });
        }
        let time = DoubleDouble::new(time);
        let system = &assembly.system;
        let mut z = DVector::zeros(system.signals.size);
        let n = system.coordinates;
        for (k, &body) in system.bodies_of.iter().enumerate() {
            (z[k], z[n + k]) = assembly.starts[body];
        }
        let inputs = vec![(0.0, [0.0; 4]); system.signals.inputs];
        system.signals.fill(time, &inputs, z.as_mut_slice());
        let mut sizes = Sizes(DVector::zeros(system.signals.size));
        sizes.include(z.as_slice());
        for j in system.signals.one..system.signals.constant_size_until() {
            sizes.0[j] = 1.0;
        }
        let mode = Mode { stops: Vec::new(), frictions: Vec::new(), basis: Vec::new() };
        let energy = crate::energy::Accounts::new(system);
        let impacts = vec![StopRecord::default(); system.stops.len()];
        let hybrid = Hybrid {
            time,
            since: time.value(),
            z,
            mode,
            departing: Vec::new(),
            sizes,
            inputs,
            impacts,
            energy,
            chain: 0,
            carried: 0,
            turns: 0,
            last: None,
            due: None,
        };
        let mut motion = Self::of(assembly, hybrid);
        motion.check_sizes()?;
        motion.settle(&[], &Parted::default(), observer)?;
        Ok(motion)
    }

    /// A motion in state `hybrid` with empty tables; the caller sets the mode in force.
    fn of(assembly: Arc<Assembly>, hybrid: Hybrid) -> Self {
        let size = hybrid.z.len();
        let scratch = Scratch { start: DVector::zeros(size), ..Scratch::default() };
        let (tables, vectors) = (Tables::default(), pulp::Arch::new());
        Self {
            assembly,
            hybrid,
            tables,
            place: 0,
            overshoot: 0.0,
            is_general: false,
            most_work: step::MOST_WORK,
            asked: None,
            scratch,
            vectors,
        }
    }

    /// The machine.
    pub fn assembly(&self) -> &Arc<Assembly> {
        &self.assembly
    }

    /// Present time, s.
    pub fn time(&self) -> f64 {
        self.hybrid.time.value()
    }

    /// The augmented state (q, v, 1, signals) now, to which the rows of the
    /// [system](Assembly::system) apply.
    pub fn state(&self) -> &DVector<f64> {
        &self.hybrid.z
    }

    /// The functional whose zero is the pending event; `None` without one and at a signal's knot.
    pub fn due(&self) -> Option<Watch> {
        match self.hybrid.due {
            Some(Due::Passage(watch)) => Some(watch),
            Some(Due::Knot) | None => None,
        }
    }

    /// The present mode.
    pub fn mode(&self) -> &Mode {
        &self.hybrid.mode
    }

    /// A body's coordinate, rate and acceleration: m, m/s, m/s² or rad, rad/s, rad/s².
    pub fn body(&self, i: usize) -> [f64; 3] {
        let system = &self.assembly.system;
        let (rows, z, n) = (&system.bodies[i], &self.hybrid.z, system.coordinates);
        let weights = rows.weights.iter().enumerate().filter(|(_, weight)| **weight != 0.0);
        let acceleration: f64 = weights.map(|(k, w)| w * self.table().a.row_times(n + k, z.as_slice())).sum();
        [rows.s.dot(z), rows.v.dot(z), acceleration + rows.drift.dot(z)]
    }

    /// A body's coordinate alone, m or rad.
    pub fn coordinate(&self, i: usize) -> f64 {
        self.assembly.system.bodies[i].s.dot(&self.hybrid.z)
    }

    /// A body's rate alone, m/s or rad/s.
    pub fn rate(&self, i: usize) -> f64 {
        self.assembly.system.bodies[i].v.dot(&self.hybrid.z)
    }

    /// A spring's elongation, its rate and its force.
    pub fn spring(&self, i: usize) -> [f64; 3] {
        let (spring, z) = (&self.assembly.system.springs[i], &self.hybrid.z);
        [spring.elongation.e.dot(z), spring.elongation.rate.dot(z), spring.force.dot(z)]
    }

    /// A stop's elongation, its rate and its force.
    pub fn stop(&self, i: usize) -> [f64; 3] {
        let [e, rate, force] = self.stop_varied(i);
        // Never a pull, by (A13): near its zero the computed force may be negative by rounding.
        [e, rate, force.max(0.0)]
    }

    /// A stop's elongation, its rate and its force, linear in the state: not clipped at zero.
    fn stop_varied(&self, i: usize) -> [f64; 3] {
        let (system, z) = (&self.assembly.system, &self.hybrid.z);
        let stop = &system.stops[i];
        let state = self.hybrid.mode.stops[i];
        let force = match state {
            StopState::Closed => self.contact_force(Contact::Stop(i)),
            _ => system.stop_force_at(i, state, z).unwrap_or(0.0),
        };
        [stop.elongation.e.dot(z), stop.elongation.rate.dot(z), force]
    }

    /// A friction's elongation, its rate and its force.
    pub fn friction(&self, i: usize) -> [f64; 3] {
        let (system, z) = (&self.assembly.system, &self.hybrid.z);
        let friction = &system.frictions[i];
        let state = self.hybrid.mode.frictions[i];
        let force = match state {
            FrictionState::Stuck => self.contact_force(Contact::Friction(i)),
            _ => system.friction_force_at(i, state, z).unwrap_or(0.0),
        };
        [friction.elongation.e.dot(z), friction.elongation.rate.dot(z), force]
    }

    /// The value of a quantity of the machine, in SI units.
    pub fn value(&self, quantity: Quantity) -> f64 {
        self.value_by(quantity, |i| self.stop(i)[2])
    }

    /// The value of a quantity in a motion that stands for a derivative (see
    /// [`variation`](Self::variation)): a stop's force may then have either sign.
    pub fn value_varied(&self, quantity: Quantity) -> f64 {
        self.value_by(quantity, |i| self.stop_varied(i)[2])
    }

    fn value_by(&self, quantity: Quantity, stop_force: impl Fn(usize) -> f64) -> f64 {
        let i = match (quantity.owner, quantity.what) {
            (Owner::Body(i), What::S) => return self.coordinate(i),
            (Owner::Body(i), What::V) => return self.rate(i),
            (Owner::Body(i), _) => return self.body(i)[2],
            (Owner::Element(i), _) => i,
        };
        let (parts, z) = (&self.assembly.system.parts[i], &self.hybrid.z);
        let elongation = || parts.first().and_then(|part| self.assembly.system.elongation_of_part(*part));
        match quantity.what {
            What::F => {
                let force = |part: &Part| match *part {
                    Part::Spring(i) => self.spring(i)[2],
                    Part::Stop(i) => stop_force(i),
                    Part::Friction(i) => self.friction(i)[2],
                    Part::Load(i) => self.load(i),
                };
                parts.iter().map(force).sum()
            }
            What::E => elongation().map_or(0.0, |own| own.e.dot(z)),
            _ => elongation().map_or(0.0, |own| own.rate.dot(z)),
        }
    }

    /// A load's force.
    pub fn load(&self, i: usize) -> f64 {
        self.assembly.system.loads[i].dot(&self.hybrid.z)
    }

    fn contact_force(&self, contact: Contact) -> f64 {
        let place = self.hybrid.mode.basis.iter().position(|&c| c == contact);
        place.map_or(0.0, |k| self.table().lambda[k].dot(&self.hybrid.z))
    }

    /// The record of a stop's impacts.
    pub fn impacts(&self, i: usize) -> StopRecord {
        self.hybrid.impacts[i]
    }

    /// The energy accounts.
    pub fn energy(&self) -> &crate::energy::Accounts {
        &self.hybrid.energy
    }

    /// Switches the energy accounts off; they keep their present values.
    #[must_use]
    pub fn without_energy_accounts(mut self) -> Self {
        self.hybrid.energy = self.hybrid.energy.off();
        self
    }

    /// Sets the approximate limit, in bytes, of the memory for tables of modes; default 128 MB.
    /// Beyond the limit all tables are dropped, and rebuilt when they are needed.
    #[must_use]
    pub fn with_table_memory(mut self, bytes: usize) -> Self {
        self.tables.most = bytes;
        self
    }

    /// Present size of the tables of modes, bytes.
    pub fn table_memory(&self) -> usize {
        self.tables.bytes()
    }

    /// Decides every event by the general law, even where one element alone is concerned: an
    /// independent path for tests and comparisons.
    #[must_use]
    pub fn by_general_law(mut self) -> Self {
        self.is_general = true;
        self
    }

    /// Kinetic and stored energy, J.
    pub fn kinetic_and_stored(&self) -> (f64, f64) {
        crate::energy::mechanical(&self.assembly.system, &self.hybrid.z)
    }

    /// The present value and derivatives of an input.
    pub fn input(&self, i: usize) -> Input {
        let (from, input) = &self.hybrid.inputs[i];
        crate::signals::shifted(input, self.time() - from)
    }

    /// A copy of the hybrid state, for [`restore`](Self::restore).
    pub fn save(&self) -> Hybrid {
        self.hybrid.clone()
    }

    /// Restores a state saved from a motion of this machine.
    pub fn restore(&mut self, saved: &Hybrid) {
        self.hybrid = saved.clone();
        self.tables.make_room();
        self.place = self.tables.place_of(&self.hybrid.mode, &self.assembly.system);
    }

    /// Computes the signals' part of the state from the clock.
    fn refill(&mut self) {
        let signals = &self.assembly.system.signals;
        signals.fill(self.hybrid.time, &self.hybrid.inputs, self.hybrid.z.as_mut_slice());
        self.hybrid.turns = 0;
    }

    /// The flow of the present mode.
    fn table(&self) -> &FlowTable {
        &self.tables.at(self.place).table
    }
}
