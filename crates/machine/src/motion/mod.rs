//! A motion: the hybrid state of a machine, which advances exactly from event to event.

mod change;
mod configured;
mod contact;
mod course;
mod event;
mod given;
mod impulse;
mod instant;
mod jump;
mod limits;
mod lone;
mod long;
mod low_bounce;
mod passage;
mod projection;
mod report;
mod samples;
mod saved;
mod start;
mod step;
mod tables;
pub(crate) mod touches;
mod values;
mod variation;
mod varied;

pub use course::Course;
pub use event::{Event, EventKind};
pub(crate) use impulse::Impulse;
pub(crate) use start::start_of;
pub use varied::{Crossing, keep};

use crate::assembly::Assembly;
use crate::error::Error;
use crate::flow::{Ahead, DepartureRows, FlowTable, Group};
use crate::law::Sizes;
use crate::mode::{Contact, FrictionState, Mode, SliderState, StopState, Watch};
use crate::signals::Input;
use configured::Configured;
use jump::Parted;
use nalgebra::DVector;
use serde::{Deserialize, Serialize};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use tables::Tables;
use vibro_numerics::double_double::DoubleDouble;

/// Callback for the events of an advance.
pub type Observer<'a> = Option<&'a mut dyn FnMut(&Event)>;

/// Where an advance has ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reached {
    /// At the requested time.
    End,
    /// At an event: after its law or, if requested, before it.
    Event,
}

/// A pending event, whose law is not applied yet.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
enum Due {
    /// An event function passes zero.
    Passage(Watch),
    /// A signal's knot.
    Knot,
    /// Coordinates of signals are reset; not an event.
    Renewal,
    /// Blocks are sampled, or their outputs act.
    Sample,
}

/// The impacts of a stop since the start.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct StopRecord {
    /// Number of impacts.
    pub count: u64,
    /// Impulse of the last impact, N s or N m s.
    pub impulse: f64,
}

impl StopRecord {
    fn add(&mut self, impulse: f64) {
        *self = Self { count: self.count + 1, impulse };
    }
}

/// The hybrid state: everything that changes while a motion advances.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Hybrid {
    time: DoubleDouble,
    /// Start of the present mode, s.
    since: f64,
    #[serde(with = "crate::serialized")]
    z: DVector<f64>,
    mode: Mode,
    /// The order of each event function's zero at the last event: 0 if it was not zero,
    /// [`ORDERS`](crate::flow::ORDERS) if it is zero throughout the mode.
    departing: Vec<usize>,
    sizes: Sizes,
    inputs: Vec<(f64, Input)>,
    /// The clock of each block.
    clocks: Vec<samples::Clock>,
    /// The impacts of each stop.
    impacts: Vec<StopRecord>,
    energy: crate::energy::Accounts,
    /// Number of events without progress of time.
    chain: usize,
    /// Number of whole sub-steps since an event or since the last attempt at a long step.
    carried: u32,
    /// Number of sub-steps since the signals were computed from the time.
    turns: u32,
    /// The event function that ended the last mode.
    last: Option<Watch>,
    /// Contacts that keep only e' at zero, each with its e when it began to hold; sorted.
    standing: Vec<(Contact, f64)>,
    /// The pending event.
    due: Option<Due>,
}

/// A motion of a machine.
///
///
/// A ball falls for 1 s onto a floor at 5 m and bounces back with half its speed, to a height of
/// 1.25 m:
///
/// ```
/// use vibro_machine::motion::Reached;
/// use vibro_machine::{Assembly, Motion, file};
///
/// let text = r#"
///     name = "Ball"
///     gravity = 10.0
///     body.ball = { mass = "20 g", gravity = 1.0 }
///     stop.floor = { between = ["ground", "ball"], gap = "5 m", restitution = 0.5 }
/// "#;
/// let machine = file::parse(text, "ball.toml", &file::no_records)?;
/// let mut motion = Motion::new(Assembly::new(machine)?.into())?;
/// motion.advance_to(1.5)?;
/// let [s, v, a] = motion.body(0);
/// assert!((s - 3.75).abs() < 1e-14 && v.abs() < 1e-14 && a == 10.0);
/// assert_eq!(motion.impacts(0).count, 1);
/// assert_eq!(motion.advance_to_event(9.0, &mut |_| ())?, Reached::Event);
/// assert!((motion.time() - 2.0).abs() < 1e-14 && (motion.rate(0) + 2.5).abs() < 1e-13);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct Motion {
    /// The machine.
    base: Arc<Assembly>,
    /// The machine with the rows of the present mode.
    assembly: Arc<Assembly>,
    configured: Configured,
    hybrid: Hybrid,
    tables: Tables,
    /// Index of the present mode in `tables`.
    place: usize,
    /// Relative overshoot at an event; 0 unless a host's solver integrates.
    overshoot: f64,
    /// Whether the general law decides at every event.
    is_general: bool,
    /// Largest number of sub-steps in one call.
    most_work: u64,
    /// Flag that interrupts a call.
    asked: Option<Arc<AtomicBool>>,
    scratch: Scratch,
    vectors: crate::vectors::Vectors,
}

/// Buffers of a sub-step.
#[derive(Clone, Debug, Default)]
struct Scratch {
    /// Values, slopes and bounds of the event functions at the start.
    heads: Vec<Group>,
    /// Intervals where each event function may pass zero, as bits.
    near: Vec<u8>,
    /// State at the start of `interval`.
    start: DVector<f64>,
    /// The prepared interval.
    interval: Option<usize>,
    ahead: Ahead,
    /// z' at the start of a long step, or of a sub-step with separate forces; otherwise scratch.
    rates: Vec<f64>,
    /// z'' where `rates` is z'; otherwise scratch.
    second: Vec<f64>,
    /// Buffer of `FlowTable::departure`.
    rows: DepartureRows,
    /// Each contact's deviation from its constraint.
    off: Vec<f64>,
    /// Values of each coordinate at the nodes for powers.
    nodes: Vec<crate::energy::AtNodes>,
    /// Values of each event function at the nodes for powers.
    values: Vec<crate::energy::AtNodes>,
    /// Recorded touches, if derivatives need them.
    touches: Option<touches::Touches>,
}

impl Motion {
    /// Starts the motion at time 0 from the machine's initial state.
    ///
    /// # Errors
    /// [`Error::Jammed`] if prescribed bodies drive stops together at the start.
    pub fn new(assembly: Arc<Assembly>) -> Result<Self, Error> {
        Self::starting_at(assembly, 0.0)
    }

    /// As [`new`](Self::new), with the events at the start reported to `observer`.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn new_observed(assembly: Arc<Assembly>, observer: &mut dyn FnMut(&Event)) -> Result<Self, Error> {
        let start = start_of(&assembly);
        Self::begin(assembly, 0.0, &start, &mut Some(observer))
    }

    /// Starts the motion at another time, s. Bodies have their start values, signals their values
    /// at that time.
    ///
    /// # Errors
    /// As [`new`](Self::new); [`Error::OutOfRange`] for a time that is not finite.
    pub fn starting_at(assembly: Arc<Assembly>, time: f64) -> Result<Self, Error> {
        let start = start_of(&assembly);
        Self::begin(assembly, time, &start, &mut None)
    }

    /// As [`starting_at`](Self::starting_at), with inputs given at the start, which samples of
    /// blocks at this time read.
    ///
    /// # Errors
    /// As [`starting_at`](Self::starting_at) and [`set_inputs`](Self::set_inputs).
    pub fn starting_under(
        assembly: Arc<Assembly>,
        time: f64,
        inputs: &[(usize, Input)],
    ) -> Result<Self, Error> {
        let start = start_of(&assembly);
        let mut motion = Self::placed(assembly, time, &start, true)?;
        motion.settle(&[], &Parted::default(), &mut None)?;
        motion.set_inputs(inputs)?;
        motion.apply_samples(&mut None)?;
        Ok(motion)
    }

    /// Starts the motion from a state: the machine's coordinates, m or rad, then their rates, then
    /// the states of first order. [`System::bodies_of`](crate::system::System::bodies_of) lists
    /// the bodies. The law finds which stops are closed and which friction sticks. Signals have
    /// their values at `time`, s. Samples of blocks at this time count as done, unless all
    /// blocks are in the machine's initial state: then they are still due.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] for a number that is not finite and for a state of another length;
    /// [`Error::Violated`] if a rigid stop has e > gap; otherwise as [`new`](Self::new).
    pub fn from_state(assembly: Arc<Assembly>, time: f64, state: &[f64]) -> Result<Self, Error> {
        Self::from_state_observed(assembly, time, state, &mut |_| ())
    }

    /// As [`from_state`](Self::from_state), with the events at the start reported to `observer`.
    ///
    /// # Errors
    /// As [`from_state`](Self::from_state).
    pub fn from_state_observed(
        assembly: Arc<Assembly>,
        time: f64,
        state: &[f64],
        observer: &mut dyn FnMut(&Event),
    ) -> Result<Self, Error> {
        Self::from_state_with(None, assembly, time, state, observer)
    }

    /// As [`from_state_observed`](Self::from_state_observed) on the machine of another motion,
    /// whose tables of modes it takes over.
    pub(crate) fn again(
        &self,
        time: f64,
        state: &[f64],
        observer: &mut dyn FnMut(&Event),
    ) -> Result<Self, Error> {
        Self::from_state_with(Some(&self.tables), self.base.clone(), time, state, observer)
    }

    fn from_state_with(
        tables: Option<&Tables>,
        assembly: Arc<Assembly>,
        time: f64,
        state: &[f64],
        observer: &mut dyn FnMut(&Event),
    ) -> Result<Self, Error> {
        let out = |name: String, value: f64, allowed: String| Err(Error::OutOfRange { name, value, allowed });
        let size = assembly.system.states();
        if state.len() != size {
            return out("length of the start".into(), state.len() as f64, format!("{size}"));
        }
        if let Some(i) = state.iter().position(|x| !x.is_finite()) {
            let name = format!("start of {}", assembly.name_of_state(i));
            return out(name, state[i], "a finite number".into());
        }
        let mut motion = {
            let fresh = assembly.is_fresh(state);
            Self::placed(assembly, time, state, fresh)?
        };
        motion.tables = tables.cloned().unwrap_or(motion.tables);
        let ways = motion.include_standing();
        motion.check_stops(&ways)?;
        motion.settle(&[], &Parted::default(), &mut Some(observer))?;
        motion.apply_samples(&mut Some(observer))?;
        Ok(motion)
    }

    /// Raises the sizes of rates to the rates that forces produce while they move a coordinate by
    /// its own size, or during a sub-step without held contacts if that is shorter. The rate of a
    /// body that was at rest in an earlier motion is only rounding and gives no size. Returns by
    /// coordinate the distance moved in a sub-step, or until forces have reversed the motion.
    fn include_standing(&mut self) -> Vec<f64> {
        let (system, Hybrid { z, sizes, .. }) = (&self.assembly.system, &mut self.hybrid);
        let state = |stop: &crate::system::StopRows| match stop.restitution() {
            Some(_) => StopState::Open,
            None if stop.is_off(z) => StopState::Off,
            None if stop.is_gapless() => StopState::Pressed,
            None if stop.excess.dot(z) > 0.0 => stop.entered(),
            None => StopState::Below,
        };
        let stops = system.stops.iter().map(state).collect();
        let frictions = vec![FrictionState::Up; system.frictions.len()];
        // Closed contacts act through their tangential stiffness.
        let sliders = vec![SliderState::Held; system.branches.len()];
        let table = FlowTable::of_mode(system, &Mode { stops, frictions, sliders, basis: Vec::new() });
        let (first, length) = (system.coordinates, table.length_for(z.as_slice(), sizes.0.as_slice()));
        let mut added = vec![0.0; system.states() - first];
        table.flight_sizes(sizes.0.as_slice(), length, &mut Vec::new(), &mut added);
        let (places, rates) = sizes.0.as_mut_slice().split_at_mut(first);
        let mut ways = vec![0.0; first];
        for (((place, rate), added), way) in places.iter().zip(rates).zip(added).zip(&mut ways) {
            if added <= 0.0 {
                continue;
            }
            let (acceleration, time) = (added / length, length.min(LONGEST));
            *way =
                (*rate * *rate / (2.0 * acceleration)).min(*rate * time) + 0.5 * acceleration * time * time;
            // After t = √(2 s/a) a coordinate that started at rest has moved by s.
            *rate = rate.max((2.0 * *place / (added * length)).sqrt().min(1.0) * added);
        }
        ways
    }

    /// Starts the motion from a state. Rigid stops with e > gap are opened by the smallest
    /// movement of bodies.
    fn begin(
        assembly: Arc<Assembly>,
        time: f64,
        start: &[f64],
        observer: &mut Observer,
    ) -> Result<Self, Error> {
        let mut motion = Self::placed(assembly, time, start, true)?;
        motion.settle(&[], &Parted::default(), observer)?;
        motion.apply_samples(observer)?;
        Ok(motion)
    }

    /// Returns the state at the start before the law. The time is moved to the last knot or sample
    /// of the same instant. Samples at this time count as done unless `fresh` is true.
    fn placed(assembly: Arc<Assembly>, time: f64, start: &[f64], fresh: bool) -> Result<Self, Error> {
        if !time.is_finite() {
            return Err(Error::OutOfRange {
                name: "start time".into(),
                value: time,
                allowed: "a finite number".into(),
            });
        }
        let system = &assembly.system;
        let time = DoubleDouble::new(system.last_of_instant(time));
        let inputs = system.signals.no_inputs();
        let z = Self::state_with_signals(&assembly, time, start, &inputs);
        let mut sizes = Sizes(DVector::zeros(system.signals.size));
        sizes.include(z.as_slice());
        system.include_curved(z.as_slice(), sizes.0.as_mut_slice());
        for j in system.signals.one..system.signals.constant_size_until() {
            sizes.0[j] = 1.0;
        }
        let mode = Mode {
            stops: Vec::new(),
            frictions: Vec::new(),
            sliders: system.held_sliders(),
            basis: Vec::new(),
        };
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
            clocks: system.clocks(time.value(), fresh),
            impacts,
            energy,
            chain: 0,
            carried: 0,
            turns: 0,
            last: None,
            standing: Vec::new(),
            due: None,
        };
        let motion = Self::of(assembly, hybrid);
        motion.check_sizes()?;
        motion.check_domains()?;
        Ok(motion)
    }

    /// Creates a motion with a hybrid state, before its mode is entered.
    fn of(assembly: Arc<Assembly>, hybrid: Hybrid) -> Self {
        let size = hybrid.z.len();
        let scratch = Scratch { start: DVector::zeros(size), ..Scratch::default() };
        let (tables, vectors) = (Tables::new(&assembly.system), crate::vectors::Vectors::new());
        Self {
            base: assembly.clone(),
            assembly,
            configured: Configured::default(),
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
    #[expect(clippy::misnamed_getters, reason = "users see the machine without the rows of a mode")]
    pub fn assembly(&self) -> &Arc<Assembly> {
        &self.base
    }

    /// The machine as matrices, with the rows of the present mode.
    pub fn system(&self) -> &crate::system::System {
        &self.assembly.system
    }

    /// Present time, s.
    pub fn time(&self) -> f64 {
        self.hybrid.time.value()
    }

    /// The augmented state (q, v, states of first order, 1, signals), on which the rows of the
    /// [system](Assembly::system) act.
    pub fn state(&self) -> &DVector<f64> {
        &self.hybrid.z
    }

    /// Largest sizes of the augmented state so far.
    pub(crate) fn sizes(&self) -> &Sizes {
        &self.hybrid.sizes
    }

    /// The event function of a pending event; `None` at a signal's knot or without an event.
    pub fn due(&self) -> Option<Watch> {
        match self.hybrid.due {
            Some(Due::Passage(watch)) => Some(watch),
            Some(Due::Knot | Due::Renewal | Due::Sample) | None => None,
        }
    }

    /// Whether the pending event is a knot of a signal.
    pub(crate) fn is_knot_due(&self) -> bool {
        matches!(self.hybrid.due, Some(Due::Knot))
    }

    /// Whether only coordinates of signals have to be reset.
    pub(crate) fn is_renewal_due(&self) -> bool {
        self.hybrid.due == Some(Due::Renewal)
    }

    /// The present mode.
    pub fn mode(&self) -> &Mode {
        &self.hybrid.mode
    }

    /// The impacts of a stop.
    pub fn impacts(&self, i: usize) -> StopRecord {
        self.hybrid.impacts[i]
    }

    /// The energy accounts.
    pub fn energy(&self) -> &crate::energy::Accounts {
        &self.hybrid.energy
    }

    /// Switches the energy accounts off: they no longer change.
    #[must_use]
    pub fn without_energy_accounts(mut self) -> Self {
        self.hybrid.energy = self.hybrid.energy.off();
        self
    }

    /// Limits the memory for the tables of modes, in bytes, approximately. Beyond the limit,
    /// tables are made again when needed. The default is 128 MB, or 16 MB for more than 20
    /// augmented coordinates.
    #[must_use]
    pub fn with_table_memory(mut self, bytes: usize) -> Self {
        self.tables.most = bytes;
        self
    }

    /// Present size of the tables of modes, bytes.
    pub fn table_memory(&self) -> usize {
        self.tables.bytes()
    }

    /// Makes the general law decide every event, even events of a single element: a second method
    /// for tests and comparisons.
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

    /// Returns the hybrid state, so that the motion can continue from it.
    pub fn save(&self) -> Hybrid {
        self.hybrid.clone()
    }

    /// Restores a hybrid state that was saved from a motion of the same machine.
    pub fn restore(&mut self, saved: &Hybrid) {
        self.hybrid = saved.clone();
        self.tables.make_room();
        self.take_rows();
        self.place = self.tables.place_of(&self.hybrid.mode, &self.assembly.system);
    }

    fn refill(&mut self) {
        let system = &self.assembly.system;
        system.signals.fill(self.hybrid.time, &self.hybrid.inputs, self.hybrid.z.as_mut_slice());
        system.fill_curved(self.hybrid.z.as_mut_slice());
        self.hybrid.turns = 0;
    }

    /// Updates the largest sizes by the present state.
    #[inline(always)]
    fn include_state(&mut self) {
        let Hybrid { sizes, z, .. } = &mut self.hybrid;
        sizes.include(z.as_slice());
        self.assembly.system.include_curved(z.as_slice(), sizes.0.as_mut_slice());
    }

    /// The flow of the present mode.
    fn table(&self) -> &FlowTable {
        &self.tables.at(self.place).table
    }
}

/// Time limit for forces in the distances at a start, s.
const LONGEST: f64 = 1.0;
