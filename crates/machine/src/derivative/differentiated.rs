//! A motion with its derivatives by parameters.

mod flights;
mod knots;
mod under_way;

pub(super) use flights::throughout;

use self::knots::Knot;
use super::by::By;
use super::columns::Columns;
use super::crossing::{Later, Met};
use super::extremes::Extremes;
use super::flight::Memory;
use super::lost::Lost;
use super::machine::{Instant, Machine};
use super::mode::VariedMode;
use super::passed::{Modes, Passed};
use super::start::{Given, Start};
use crate::assembly::Assembly;
use crate::error::Error;
use crate::motion::{Event, EventKind, Motion, Reached, start_of};
use crate::quantity::Quantity;
use nalgebra::DVector;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// A motion with the derivatives of its values and of its events' times with respect to numbers of
/// the machine and of its start. The derivatives are exact through impacts, contacts and sticking.
///
/// A column of derivatives is [`By`] a parameter, or by the initial state or time. Once a column
/// has no derivative, [`derivative`](Self::derivative) returns `None` for it, and
/// [`lost`](Self::lost) gives the reason.
///
/// A ball that falls from rest onto a floor at depth h hits it at √(2h/g):
///
/// ```
/// use std::sync::Arc;
/// use vibro_machine::{Assembly, Differentiated, Quantity, What, file};
///
/// let text = r#"
///     name = "Bouncer"
///     gravity = 10.0
///     [body.ball]
///     mass = "20 g"
///     gravity = 1.0
///     [stop.floor]
///     between = ["ground", "ball"]
///     gap = "5 m"
///     restitution = 0.5
/// "#;
/// let machine = file::parse(text, "ball.toml", &file::no_records)?;
/// let assembly = Arc::new(Assembly::new(machine)?);
/// let mut ball = Differentiated::new(assembly, &["stop.floor.gap", "gravity"])?;
/// let mut times = Vec::new();
/// ball.advance_observed(1.5, &mut |event, by| times.push((event.time, by[0], by[1])))?;
/// let (time, by_gap, by_gravity) = times[0];
/// assert!((time - 1.0).abs() < 1e-15);
/// assert!((by_gap.unwrap() - 0.1).abs() < 1e-15 && (by_gravity.unwrap() + 0.05).abs() < 1e-15);
/// // The ball has left the floor, at h, with 5 m/s; both depend on h.
/// let place = ball.derivative(Quantity::of_body(0, What::S), 0).unwrap();
/// let by_hand = 1.0 - 0.5 * (1.0 * 0.5 - 10.0 * 0.1) - 10.0 * 0.5 * 0.1;
/// assert!((place - by_hand).abs() < 1e-14);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone)]
pub struct Differentiated {
    machine: Arc<Machine>,
    motion: Motion,
    names: Vec<String>,
    modes: Modes,
    mode: Arc<VariedMode>,
    /// The state and its derivatives.
    deltas: Columns,
    /// Largest sizes of `deltas` so far.
    scales: Columns,
    /// Why each column has no derivatives, if so; its derivatives are then 0.
    lost: Vec<Option<Lost>>,
    memory: Memory,
    vectors: pulp::Arch,
    /// Events of the present instant.
    met: Vec<Met>,
}

/// Where a motion starts.
#[derive(Clone, Debug)]
pub(super) enum Origin {
    /// At the machine's start, at time 0.
    Machine,
    /// At a time in a state.
    State(f64, Vec<f64>),
}

/// Callback for events, each with the derivatives of its time by column.
pub type VariedObserver<'a> = dyn FnMut(&Event, &[Option<f64>]) + 'a;

impl Differentiated {
    /// Starts the motion at time 0 from the machine's initial state, with derivatives by numbers
    /// of the machine, for example `["stop.floor.gap"]`, or of its start ([`By`]).
    ///
    /// # Errors
    /// [`Error::Refused`] for an unknown parameter, with the nearest name; otherwise as
    /// [`Motion::new`].
    pub fn new(assembly: Arc<Assembly>, columns: &[impl Into<By> + Clone]) -> Result<Self, Error> {
        Self::new_observed(assembly, columns, &mut |_, _| ())
    }

    /// As [`new`](Self::new), with the events at the start reported to `observer`.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn new_observed(
        assembly: Arc<Assembly>,
        columns: &[impl Into<By> + Clone],
        observer: &mut VariedObserver,
    ) -> Result<Self, Error> {
        Self::begin(assembly, columns, &Origin::Machine, observer)
    }

    /// Starts the motion at a time from a given state, as [`Motion::from_state`], with its
    /// derivatives. No parameter varies the state. A column that moves a rigid stop closed there,
    /// or its gap, has no derivative, since a start behind the stop is impossible. A motion [under
    /// way](Self::from_motion) follows the stop instead.
    ///
    /// The derivative of a spring's later state by its initial state is the transition matrix:
    ///
    /// ```
    /// use std::sync::Arc;
    /// use vibro_machine::derivative::By;
    /// use vibro_machine::{Assembly, Differentiated, file};
    ///
    /// let text = r#"
    ///     name = "Oscillator"
    ///     [body.a]
    ///     mass = 1.0
    ///     [spring.k]
    ///     between = ["ground", "a"]
    ///     stiffness = 4.0
    /// "#;
    /// let assembly = Arc::new(Assembly::new(file::parse(text, "a.toml", &file::no_records)?)?);
    /// let columns = [By::Start(0), By::Start(1)];
    /// let mut motion = Differentiated::from_state(assembly, 0.5, &[0.1, 0.0], &columns)?;
    /// motion.advance_to(0.8)?;
    /// let (sine, cosine) = 0.6f64.sin_cos();
    /// let matrix = [[cosine, -2.0 * sine], [0.5 * sine, cosine]];
    /// for (column, exact) in matrix.iter().enumerate() {
    ///     let found = motion.state_derivative(column).unwrap();
    ///     assert!(found.iter().zip(exact).all(|(x, y)| (x - y).abs() < 1e-14));
    /// }
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// As [`new`](Self::new) and [`Motion::from_state`].
    pub fn from_state(
        assembly: Arc<Assembly>,
        time: f64,
        state: &[f64],
        columns: &[impl Into<By> + Clone],
    ) -> Result<Self, Error> {
        Self::from_state_observed(assembly, time, state, columns, &mut |_, _| ())
    }

    /// As [`from_state`](Self::from_state), with the events at the start reported to `observer`.
    ///
    /// # Errors
    /// As [`from_state`](Self::from_state).
    pub fn from_state_observed(
        assembly: Arc<Assembly>,
        time: f64,
        state: &[f64],
        columns: &[impl Into<By> + Clone],
        observer: &mut VariedObserver,
    ) -> Result<Self, Error> {
        Self::begin(assembly, columns, &Origin::State(time, state.to_vec()), observer)
    }

    /// Starts the motion at an origin.
    pub(super) fn begin(
        assembly: Arc<Assembly>,
        columns: &[impl Into<By> + Clone],
        origin: &Origin,
        observer: &mut VariedObserver,
    ) -> Result<Self, Error> {
        let (time, state, given) = match origin {
            Origin::Machine => (0.0, &start_of(&assembly), Given::Machine),
            Origin::State(time, state) => (*time, state, Given::State),
        };
        let columns: Vec<By> = columns.iter().cloned().map(Into::into).collect();
        let machine = Arc::new(Machine::new(assembly.clone(), columns)?);
        let mut events = Vec::new();
        let mut note = |event: &Event| events.push(event.clone());
        let motion = match given {
            Given::Machine => Motion::new_observed(assembly, &mut note)?,
            _ => Motion::from_state_observed(assembly, time, state, &mut note)?,
        };
        Ok(Self::begun((machine, Modes::default()), motion, (given, state, &events), observer))
    }

    /// Starts a motion of the same machine at a time from a given state, with the same columns.
    /// Up to rounding, it is equal to [`from_state_observed`](Self::from_state_observed), which
    /// would make the derivatives of the machine's matrices again.
    ///
    /// # Errors
    /// As [`Motion::from_state`].
    pub fn again_observed(
        &self,
        time: f64,
        state: &[f64],
        observer: &mut VariedObserver,
    ) -> Result<Self, Error> {
        let mut events = Vec::new();
        let motion = self.motion.again(time, state, &mut |event| events.push(event.clone()))?;
        let kept = (self.machine.clone(), self.modes.clone());
        Ok(Self::begun(kept, motion, (Given::State, state, &events), observer))
    }

    /// A motion at its start, with the derivatives of its state.
    fn begun(
        (machine, mut modes): (Arc<Machine>, Modes),
        motion: Motion,
        (given, state, events): (Given, &[f64], &[Event]),
        observer: &mut VariedObserver,
    ) -> Self {
        let motion = motion.noting_touches();
        let machine = machine.at_mode(motion.mode()).unwrap_or(machine);
        let mode = modes.of(&machine, &motion, true);
        let z = machine.widened(motion.state());
        let mut begun = z.clone().into_owned();
        begun.as_mut_slice()[..state.len()].copy_from_slice(state);
        let (rates, sizes) = (mode.rates(&z), machine.widened(&motion.sizes().0));
        let at = Instant { mode: &mode, z: &z, rates: &rates, sizes: &sizes, time: motion.time() };
        let throughout = throughout(&mode, &motion).map(|own| own.0.contact()).collect();
        let start = Start { machine: &machine, given, begun: &begun, events, at, throughout };
        let count = machine.columns.len();
        let (mut deltas, mut lost) = (Columns::zeros(z.len(), count), vec![None; count]);
        deltas.put_state(z.as_slice());
        for (p, place) in lost.iter_mut().enumerate() {
            match start.derivative(p) {
                Ok(delta) => deltas.put(p, &delta),
                Err(found) => *place = Some(found),
            }
        }
        let later = |p: usize| if machine.columns[p] == By::Time { 1.0 } else { 0.0 };
        let times: Vec<_> = (0..count).map(|p| lost[p].is_none().then(|| later(p))).collect();
        events.iter().for_each(|event| observer(event, &times));
        let mut scales = Columns::zeros(z.len(), count);
        scales.include(&deltas);
        let names = machine.columns.iter().map(By::to_string).collect();
        let (memory, vectors, met) = (Memory::default(), pulp::Arch::new(), Vec::new());
        Self { machine, motion, names, modes, mode, deltas, scales, lost, memory, vectors, met }
    }

    /// Lets a flag interrupt the motion, as [`Motion::with_interruption`].
    #[must_use]
    pub fn with_interruption(mut self, asked: Arc<AtomicBool>) -> Self {
        self.motion = self.motion.with_interruption(asked);
        self
    }

    /// The motion itself.
    pub fn motion(&self) -> &Motion {
        &self.motion
    }

    /// Returns a column of the derivative of the augmented state, before the motion is advanced.
    pub(super) fn start_of(&self, p: usize) -> Result<DVector<f64>, Lost> {
        self.lost[p].clone().map_or_else(|| Ok(self.deltas.column(p)), Err)
    }

    /// Returns the machine and the motion.
    pub(super) fn into_parts(self) -> (Arc<Machine>, Motion) {
        (self.machine, self.motion)
    }

    /// Returns the columns, in the order of the derivatives.
    pub fn columns(&self) -> &[By] {
        &self.machine.columns
    }

    /// Returns the columns' names: the parameter's name, `start[0]`, … or `start.time`.
    pub fn parameters(&self) -> &[String] {
        &self.names
    }

    /// Returns a column of the derivative of the state: coordinates, then rates, then states of
    /// first order. `None` if it does not exist.
    pub fn state_derivative(&self, column: usize) -> Option<Vec<f64>> {
        let delta = self.column(column)?;
        Some(self.machine.given(column, &self.machine.widened(self.motion.state()), &delta))
    }

    /// Returns a column of the derivative of the augmented state.
    fn column(&self, p: usize) -> Option<DVector<f64>> {
        self.lost.get(p)?.is_none().then(|| self.deltas.column(p))
    }

    /// Returns a column of the derivative of a quantity at the present time; `None` if it does not
    /// exist. The forces of dependent contacts have no derivative while the contacts are held: the
    /// law determines only their sum.
    pub fn derivative(&self, quantity: Quantity, column: usize) -> Option<f64> {
        if self.is_shared(quantity) { None } else { self.derivative_in_mode(quantity, column) }
    }

    /// Returns the [`derivative`](Self::derivative), but for forces that the law leaves
    /// undetermined uses the values of the present mode, as outputs do.
    pub fn derivative_in_mode(&self, quantity: Quantity, column: usize) -> Option<f64> {
        let delta = &self.column(column)?;
        let z = self.machine.widened(self.motion.state());
        let point = super::values::Point {
            system: &self.machine.system,
            tangent: &self.machine.tangents[column],
            mode: &self.mode,
            p: column,
            z: &z,
            delta,
            scale: delta,
        };
        // No value is -0.
        Some(point.quantity(quantity) + 0.0).filter(|value| value.is_finite())
    }

    /// Whether the law determines this force only in sum with the forces of other contacts.
    pub(super) fn is_shared(&self, quantity: Quantity) -> bool {
        self.mode.is_shared(&self.machine.system, quantity)
    }

    /// Returns why a column no longer has derivatives.
    pub fn lost(&self, column: usize) -> Option<&Lost> {
        self.lost.get(column)?.as_ref()
    }

    /// Advances to a time.
    ///
    /// # Errors
    /// As [`Motion::advance_to`].
    pub fn advance_to(&mut self, end: f64) -> Result<(), Error> {
        self.advance_observed(end, &mut |_, _| ())
    }

    /// Advances to a time and reports all events, each with the derivatives of its time by column.
    ///
    /// # Errors
    /// As [`Motion::advance_to`].
    pub fn advance_observed(&mut self, end: f64, observer: &mut VariedObserver) -> Result<(), Error> {
        self.advance_with_extremes(end, &mut [], observer)
    }

    /// As [`advance_observed`](Self::advance_observed); also updates the extreme values of
    /// quantities on the way.
    ///
    /// # Errors
    /// As [`Motion::advance_to`].
    pub fn advance_with_extremes(
        &mut self,
        end: f64,
        extremes: &mut [Extremes],
        observer: &mut VariedObserver,
    ) -> Result<(), Error> {
        self.look(extremes);
        loop {
            match self.follow(end, extremes)? {
                Reached::End => {
                    self.look(extremes);
                    return Ok(());
                }
                Reached::Event => self.pass(extremes, observer)?,
            }
        }
    }

    /// Updates the extreme values with the present values.
    fn look(&self, extremes: &mut [Extremes]) {
        let now = (self.motion.time(), &self.deltas, &self.lost[..]);
        extremes.iter_mut().for_each(|own| own.at(&self.machine, &self.mode, now));
    }

    /// Applies the law of the pending event, and carries the derivatives over it.
    fn pass(&mut self, extremes: &mut [Extremes], observer: &mut VariedObserver) -> Result<(), Error> {
        let knot = if extremes.is_empty() && self.is_lone_knot() { Some(self.pass_knot()?) } else { None };
        if let Some(Knot::Kept(events)) = knot {
            let times: Vec<_> = self.lost.iter().map(|lost| lost.is_none().then_some(0.0)).collect();
            events.iter().for_each(|event| observer(event, &times));
            return Ok(());
        }
        let Self { machine, motion, modes, mode, deltas, scales, lost, met, .. } = self;
        let passed = match knot {
            Some(Knot::Applied(passed)) => *passed,
            _ => Passed::new(machine, motion, mode, |motion| modes.of(machine, motion, true))?,
        };
        *mode = passed.modes[1].clone();
        let crossing = passed.crossing(machine, met);
        let closes = passed.events.iter().any(|event| matches!(event.kind, EventKind::Close { .. }));
        let was = (closes || !extremes.is_empty()).then(|| deltas.clone());
        let later = crossing.carry(deltas, scales, lost);
        if let Some(was) = &was {
            let all = extremes.iter_mut();
            all.for_each(|own| own.cross(machine, &passed, [was, deltas], (&later, lost)));
        }
        for event in &passed.events {
            let time_of = |(p, later): (usize, &Option<Later>)| {
                let delta = was.as_ref().map(|was| was.column(p));
                Some(crossing.time_of(p, event, later.as_ref()?, delta.as_ref())? + 0.0)
            };
            observer(event, &later.iter().enumerate().map(time_of).collect::<Vec<_>>());
        }
        let later = later.iter().map(|later| later.as_ref().map(|later| later.event)).collect();
        let next = crossing.met(later);
        met.extend(next);
        if let Some(next) = passed.next {
            *machine = next;
        }
        Ok(())
    }
}
