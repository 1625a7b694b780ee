//! The gradient of a sum over a motion, computed backwards from its end.

use super::adjoint::{Adjoint, Step};
use super::by::By;
use super::differentiated::{Differentiated, Origin, throughout};
use super::extremes::shared;
use super::lost::{Cause, Lost};
use super::machine::Machine;
use super::mode::VariedMode;
use super::passed::{Modes, Passed};
use crate::assembly::Assembly;
use crate::error::Error;
use crate::motion::{Event, EventKind, Motion, Reached};
use crate::quantity::Quantity;
use crate::system::BranchRows;
use nalgebra::DVector;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// The gradient of a sum Σ cₖ yₖ of a motion's values at any times, and of its events' times, with
/// respect to many numbers of the machine and of its start. However many these numbers are, it
/// takes one forward and one backward pass. It therefore suits sums of squares, with cₖ = 2 ×
/// residual.
///
/// If the order of events at one instant is in doubt, the sum is differentiated by columns
/// ([`Differentiated`]). The result is equally exact, but takes longer.
///
/// ```
/// use std::sync::Arc;
/// use vibro_machine::derivative::Gradient;
/// use vibro_machine::{Assembly, Quantity, What, file};
///
/// let text = r#"
///     name = "Oscillator"
///     [body.a]
///     mass = 1.0
///     start = { s = 1.0 }
///     [spring.k]
///     between = ["ground", "a"]
///     stiffness = 4.0
/// "#;
/// let assembly = Arc::new(Assembly::new(file::parse(text, "a.toml", &file::no_records)?)?);
/// let place = Quantity::of_body(0, What::S);
/// let mut sum = Gradient::new(assembly, &["spring.k.stiffness", "body.a.start.s"])?;
/// for (time, measured) in [(0.3, 0.8), (0.7, 0.1)] {
///     sum.advance_to(time)?;
///     sum.add(place, 2.0 * (sum.motion().value(place) - measured));
/// }
/// // s = cos ωt with ω = √k.
/// let [by_stiffness, by_start] = sum.gradient()?.try_into().unwrap();
/// let residuals = [(0.3, 0.6f64.cos() - 0.8), (0.7, 1.4f64.cos() - 0.1)];
/// let exact =
///     |f: &dyn Fn(f64) -> f64| residuals.iter().map(|(t, r)| 2.0 * r * f(*t)).sum::<f64>();
/// assert!((by_stiffness.unwrap() - exact(&|t| -0.25 * t * (2.0 * t).sin())).abs() < 1e-14);
/// assert!((by_start.unwrap() - exact(&|t| (2.0 * t).cos())).abs() < 1e-14);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct Gradient {
    machine: Arc<Machine>,
    origin: Origin,
    motion: Motion,
    mode: Arc<VariedMode>,
    modes: Modes,
    /// Derivative of the initial state by each column.
    starts: Vec<Result<DVector<f64>, Lost>>,
    steps: Vec<Step>,
    /// Index of the step of each event; `None` for an event at the start.
    events: Vec<Option<usize>>,
    /// Sum of the factors of event times at the start.
    at_start: f64,
    calls: Vec<Call>,
    /// Whether an event has happened at the present instant.
    is_recent: bool,
    /// Whether derivatives have to be computed by columns.
    is_doubtful: bool,
}

/// A recorded call, to be repeated by columns if necessary.
enum Call {
    Advance(f64),
    Value(Quantity, f64),
    Time(usize, f64),
}

impl Gradient {
    /// Starts the motion at time 0 from the machine's initial state, with an empty sum.
    ///
    /// # Errors
    /// As [`Differentiated::new`].
    pub fn new(assembly: Arc<Assembly>, columns: &[impl Into<By> + Clone]) -> Result<Self, Error> {
        Self::begin(assembly, columns, Origin::Machine, &mut |_| ())
    }

    /// As [`new`](Self::new), but from a state at a time, as [`Differentiated::from_state`]. The
    /// events at the start are reported to `observer`.
    ///
    /// # Errors
    /// As [`Differentiated::from_state`].
    pub fn from_state(
        assembly: Arc<Assembly>,
        time: f64,
        state: &[f64],
        columns: &[impl Into<By> + Clone],
        observer: &mut dyn FnMut(&Event),
    ) -> Result<Self, Error> {
        Self::begin(assembly, columns, Origin::State(time, state.to_vec()), observer)
    }

    fn begin(
        assembly: Arc<Assembly>,
        columns: &[impl Into<By> + Clone],
        origin: Origin,
        observer: &mut dyn FnMut(&Event),
    ) -> Result<Self, Error> {
        let mut events = Vec::new();
        let mut note = |event: &Event, _: &[Option<f64>]| {
            events.push(None);
            observer(event);
        };
        let begun = Differentiated::begin(assembly, columns, &origin, &mut note)?;
        let starts = (0..begun.columns().len()).map(|p| begun.start_of(p)).collect();
        let (machine, motion) = begun.into_parts();
        let mut modes = Modes::default();
        let mode = modes.of(&machine, &motion, false);
        // Curved forces and blocks, for example, are differentiated by columns.
        let is_doubtful = !machine.system.curved.is_empty()
            || machine.system.residual.is_some()
            || machine.system.branches.iter().any(BranchRows::is_frictionless)
            || !motion.mode().is_independent()
            || throughout(&mode, &motion).next().is_some()
            || !machine.system.blocks.is_empty();
        Ok(Self {
            machine,
            origin,
            motion,
            mode,
            modes,
            starts,
            steps: Vec::new(),
            events,
            at_start: 0.0,
            calls: Vec::new(),
            is_recent: false,
            is_doubtful,
        })
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

    /// Returns the columns of the gradient.
    pub fn columns(&self) -> &[By] {
        &self.machine.columns
    }

    /// Advances to a time.
    ///
    /// # Errors
    /// As [`Motion::advance_to`].
    pub fn advance_to(&mut self, end: f64) -> Result<(), Error> {
        self.advance_observed(end, &mut |_| ())
    }

    /// Advances to a time and reports all events, which are numbered from the first at the start.
    ///
    /// # Errors
    /// As [`Motion::advance_to`].
    pub fn advance_observed(&mut self, end: f64, observer: &mut dyn FnMut(&Event)) -> Result<(), Error> {
        self.calls.push(Call::Advance(end));
        loop {
            let from = self.motion.time();
            let z = self.machine.widened(self.motion.state()).into_owned();
            let outcome = self.motion.advance_flight(end, &mut |_| ());
            let span = self.motion.time() - from;
            let touches = self.motion.take_touches();
            self.is_doubtful |=
                touches.iter().any(|own| self.machine.is_touchy(self.mode.watched[own.place].0));
            if span > 0.0 {
                self.is_recent &= !self.mode.parts_instants(self.motion.time(), span);
                self.keep(|own| Step::Flight(own.mode.clone(), z, span));
            }
            match outcome? {
                Reached::End => return Ok(()),
                Reached::Event => self.pass(observer)?,
            }
        }
    }

    /// Adds `factor` × the present value of a quantity to the sum.
    pub fn add(&mut self, quantity: Quantity, factor: f64) {
        self.calls.push(Call::Value(quantity, factor));
        let z = self.machine.widened(self.motion.state()).into_owned();
        self.keep(|own| Step::Value(own.mode.clone(), z, quantity, factor));
    }

    /// Adds `factor` × the time of an event to the sum, by its number among all reported events.
    ///
    ///
    /// A ball that falls for T = √(2h/g) meets the floor again at (1 + 2 ε) T:
    ///
    /// ```
    /// use vibro_machine::derivative::Gradient;
    /// use vibro_machine::{Assembly, file};
    ///
    /// # let text = r#"
    /// #     name = "Ball"
    /// #     gravity = 10.0
    /// #     body.ball = { mass = "20 g", gravity = 1.0 }
    /// #     stop.floor = { between = ["ground", "ball"], gap = "5 m", restitution = 0.5 }
    /// # "#;
    /// let ball = Assembly::new(file::parse(text, "ball.toml", &file::no_records)?)?;
    /// let mut sum = Gradient::new(ball.into(), &["stop.floor.restitution", "stop.floor.gap"])?;
    /// sum.advance_to(2.2)?;
    /// sum.add_time(1, 1.0);
    /// let [by_restitution, by_gap] = sum.gradient()?.try_into().unwrap();
    /// assert!((by_restitution.unwrap() - 2.0).abs() < 1e-14);
    /// assert!((by_gap.unwrap() - 2.0 * 0.1).abs() < 1e-14);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn add_time(&mut self, event: usize, factor: f64) {
        self.calls.push(Call::Time(event, factor));
        match self.events.get(event) {
            Some(None) => self.at_start += factor,
            Some(&Some(step)) => match self.steps.get_mut(step) {
                Some(Step::Event(passed, sum)) => {
                    let closes = |event: &Event| matches!(event.kind, EventKind::Close { .. });
                    self.is_doubtful |= passed.events.iter().any(closes);
                    *sum += factor;
                }
                _ => self.is_doubtful = true,
            },
            None => {}
        }
    }

    /// Whether the gradient is computed by columns, which takes longer.
    pub fn is_by_columns(&self) -> bool {
        self.is_doubtful
    }

    /// Records a step, unless derivatives are computed by columns.
    fn keep(&mut self, step: impl FnOnce(&Self) -> Step) {
        if self.is_doubtful {
            self.steps.clear();
        } else {
            let step = step(self);
            self.steps.push(step);
        }
    }

    fn pass(&mut self, observer: &mut dyn FnMut(&Event)) -> Result<(), Error> {
        let Self { machine, motion, modes, mode, .. } = self;
        let passed = Passed::new(machine, motion, mode, |motion| modes.of(machine, motion, false))?;
        *mode = passed.modes[1].clone();
        let is_still = throughout(&self.mode, &self.motion).next().is_some();
        self.is_doubtful |= self.is_recent || is_still || !is_plain(&self.machine, &passed);
        self.is_recent = true;
        self.lose(&passed);
        for event in &passed.events {
            self.events.push(Some(self.steps.len()));
            observer(event);
        }
        self.keep(|_| Step::Event(Box::new(passed), 0.0));
        Ok(())
    }

    /// Ends columns that vary the restitution of a stop hit with restitution 0.
    fn lose(&mut self, passed: &Passed) {
        let Self { machine, starts, .. } = self;
        for impulse in passed.impulses.iter().filter(|impulse| impulse.is_plastic(&machine.system)) {
            for (start, tangent) in
                starts.iter_mut().zip(&machine.tangents).filter(|(start, _)| start.is_ok())
            {
                if let Some(stop) = impulse.at_limit(&machine.system, tangent) {
                    let element = machine.assembly.name_of_stop(stop);
                    *start = Err(Lost { time: passed.time, element, cause: Cause::Limit });
                }
            }
        }
    }

    /// Returns the derivative of the sum by each column, or the reason why it does not exist.
    ///
    /// # Errors
    /// Errors of the motion, if derivatives are computed by columns.
    pub fn gradient(&self) -> Result<Vec<Result<f64, Lost>>, Error> {
        if self.is_doubtful {
            return self.by_columns();
        }
        let mut adjoint = Adjoint::new(&self.machine);
        self.steps.iter().rev().for_each(|step| adjoint.undo(step));
        let found = adjoint.finish();
        let by = |(p, start): (usize, &Result<DVector<f64>, Lost>)| {
            let later = if self.machine.columns[p] == By::Time { self.at_start } else { 0.0 };
            // No value is -0.
            start.as_ref().map(|start| found.along(p, start) + later + 0.0).map_err(Clone::clone)
        };
        Ok(self.starts.iter().enumerate().map(by).collect())
    }

    fn by_columns(&self) -> Result<Vec<Result<f64, Lost>>, Error> {
        let count = self.machine.columns.len();
        let (mut sums, mut times, mut open) = (vec![Some(0.0); count], Vec::new(), None);
        let mut note = |_: &Event, by: &[Option<f64>]| times.push(by.to_vec());
        let (assembly, columns) = (self.machine.assembly.clone(), &self.machine.columns);
        let mut motion = Differentiated::begin(assembly, columns, &self.origin, &mut note)?;
        let mut add = |factor: f64, by: &dyn Fn(usize) -> Option<f64>| {
            for (p, sum) in sums.iter_mut().enumerate() {
                *sum = sum.zip(by(p)).map(|(sum, x)| sum + factor * x);
            }
        };
        let mut end = self.motion.time();
        for call in &self.calls {
            match *call {
                Call::Advance(time) => {
                    end = time;
                    motion.advance_observed(time, &mut |_, by| times.push(by.to_vec()))?;
                }
                Call::Value(quantity, factor) => {
                    add(factor, &|p| motion.derivative(quantity, p));
                    if motion.is_shared(quantity) {
                        open.get_or_insert_with(|| shared(&self.machine, quantity, motion.motion().time()));
                    }
                }
                Call::Time(event, factor) => add(factor, &|p| times.get(event)?[p]),
            }
        }
        let lost = |p: usize| {
            let why = motion.lost(p).or(open.as_ref()).cloned();
            why.unwrap_or_else(|| Lost::unknown(end))
        };
        Ok(sums.into_iter().enumerate().map(|(p, sum)| sum.ok_or_else(|| lost(p))).collect())
    }
}

/// Whether an event has a derivative by any column: nothing else comes to a limit, no contact
/// depends on others, and at a knot only forces jump.
fn is_plain(machine: &Machine, passed: &Passed) -> bool {
    let crossing = passed.crossing(machine, &[]);
    let signals = &machine.system.signals;
    let jumps = || {
        let [before, after] = &passed.states;
        before.rows_range(signals.one..) != after.rows_range(signals.one..)
    };
    let moves = || machine.tangents.iter().any(|tangent| tangent.signals.varies_pieces());
    let delayed = || machine.tangents.iter().any(|tangent| tangent.signals.later(passed.time).is_some());
    let is_plain_knot = || {
        crossing.due.is_none()
            && crossing.together.is_empty()
            && passed.impulses.is_empty()
            && !(machine.system.has_motions && (jumps() || moves()))
            && !(signals.knots_at(passed.time) > 1 && delayed())
    };
    let is_held = passed.modes.iter().all(|mode| mode.mode.is_independent());
    is_held && crossing.still.is_empty() && (crossing.is_alone() || is_plain_knot())
}
