//! The motion for the hybrid layer of the doors: a simulator or a closed form that makes its own
//! steps, or the model for a host's solver.

use super::arrival::{advance, is_at_end, rounding, take_back};
use super::events::{Changes, describe, log_left_out, report_contact, teller};
use super::last_step::LastStep;
use super::{ComponentProblem, Engine, Instance, Outcome, Phase, finite, given};
use crate::component::closed_form::{ClosedForm, Data};
use crate::component::event_state::{Discrete, EventState};
use crate::component::log::{Category, Log, Silence};
use crate::component::values::OutputValues;
use crate::component::variables::Edition;
use fmi_doors::hybrid::{Ended, Hybrid, Met, StepEnd, Until};
use fmi_doors::{Handled, Model};
use vibro_impact::error::Error;
use vibro_impact::simulator::{AdvanceOutcome, Event, EventObserver, Pause, Simulator};
use vibro_numerics::double_double::DoubleDouble;

/// Data that undo a step of a closed form. A simulator returns to the beginning of its
/// [`LastStep`].
#[derive(Debug)]
pub struct Undo(Option<Box<Data>>);

impl Hybrid for Instance {
    type Shown = Discrete;
    type Undo = Undo;

    const ROUNDING: f64 = super::arrival::UNITS;

    fn forget(&mut self) {
        self.invalidate();
    }

    fn start(&mut self, log: &mut dyn Log) -> Outcome {
        let (engine, objections) = self.initial_engine()?;
        match &engine {
            Engine::Simulation(simulator) => drop(finite(OutputValues::of(simulator))?),
            Engine::Closed(form) => drop(finite(form.values())?),
            Engine::Continuous(continuous) => drop(finite(continuous.values())?),
            Engine::None => {}
        }
        if log.wants(Category::Warnings) {
            let half = given::half_a_machine(&self.settings.parameters, self.given);
            objections.into_iter().chain(half).for_each(|text| log.log(Category::Warnings, &text));
        }
        self.nominals_told = Some(self.nominals());
        self.engine = engine;
        self.taken_over();
        Ok(())
    }

    fn check(&self, point: f64, size: f64) -> Outcome {
        if matches!(self.engine, Engine::None | Engine::Continuous(_)) {
            return Err(ComponentProblem::sequence("the instance is not initialized"));
        }
        self.life.check_step(point, size, self.time()).map_err(|problem| match problem {
            fmi_doors::Problem::Time { given, own } if self.life.phase == Phase::StoppedEarly => {
                ComponentProblem::Stopped { given, own }
            }
            problem => problem.into(),
        })?;
        if self.events.pending {
            return Err(ComponentProblem::sequence(
                "the event of the last step must be handled in Event Mode first",
            ));
        }
        Ok(())
    }

    fn ends_at_events(&self) -> bool {
        self.settings.stop_at_impact
    }

    /// A release or a rest caused by a changed input is a separate event. If a step is so short
    /// that the slopes of the loads from the host's callback are excessive, these loads are held
    /// constant.
    #[inline]
    fn take_over(&mut self, _: StepEnd, log: &mut dyn Log) -> Outcome<(Undo, bool)> {
        let changes = Changes::of(&self.settings, (self.parameters_set, self.loads_set));
        match &mut self.engine {
            Engine::Simulation(simulator) => {
                let step = LastStep::begin(&mut self.last_step, simulator, &changes);
                let before = simulator.contact();
                let mut taken = changes.put(simulator);
                if taken.is_err() && self.loads_set && self.slopes_set == [false; 3] {
                    let loads = &mut self.settings.loads;
                    loads.derivatives.iter_mut().for_each(|load| load[1..].fill(0.0));
                    step.loads = Some(*loads);
                    taken = simulator.set_loads(loads);
                }
                if let Err(error) = taken {
                    return Err(self.undo(Undo(None), error.into()));
                }
                let moved = simulator.contact() != before;
                if moved {
                    report_contact(before, simulator, &mut teller(log));
                }
                Ok((Undo(None), moved))
            }
            Engine::Closed(form) => {
                let before = Box::new(form.data());
                if let Some(parameters) = changes.parameters {
                    form.set_parameters(parameters)?;
                }
                Ok((Undo(Some(before)), false))
            }
            Engine::None | Engine::Continuous(_) => Ok((Undo(None), false)),
        }
    }

    fn taken_over(&mut self) {
        (self.parameters_set, self.loads_set) = (false, false);
        self.slopes_set = [false; 3];
        self.invalidate();
    }

    #[inline]
    fn run(&mut self, end: StepEnd, until: Until, log: &mut dyn Log) -> Outcome<Met> {
        let wanted = log.wants(Category::Events);
        let (mut events, mut side, mut left_out) = (0, self.events.side, 0.0);
        let mut show = |event: &Event| {
            events += 1;
            side = side_of(event, side);
            if wanted {
                log.log(Category::Events, &describe(event));
            }
        };
        let counts = wanted || self.life.handling.event_mode;
        let report: EventObserver = if counts { Some(&mut show) } else { None };
        // If the host allows early return, a step also ends at releases.
        let every = self.life.handling.early_return;
        let met = match &mut self.engine {
            Engine::Simulation(simulator) => run(simulator, end, (until, every), report)?,
            Engine::Closed(form) => {
                let (met, unreported) = play(form, end, (until, every), report)?;
                left_out = unreported;
                met
            }
            Engine::None | Engine::Continuous(_) => Met::default(),
        };
        log_left_out(left_out, end.value(), log);
        self.events.side = side;
        self.invalidate();
        Ok(Met { events, ..met })
    }

    fn undo(&mut self, undo: Undo, problem: ComponentProblem) -> ComponentProblem {
        self.events.side = 0;
        self.invalidate();
        match (&mut self.engine, undo.0, &self.last_step) {
            (Engine::Simulation(simulator), _, Some(step)) => take_back(simulator, &step.before, problem),
            (Engine::Closed(form), Some(before), _) => match form.restore(*before) {
                Ok(()) => problem,
                Err(refused) => fmi_doors::Problem::not_taken_back(&problem, &refused).into(),
            },
            _ => problem,
        }
    }

    fn apply_law(&mut self, log: &mut dyn Log) -> Outcome {
        let (wanted, mut side) = (log.wants(Category::Events), self.events.side);
        let mut show = |event: &Event| {
            side = side_of(event, side);
            if wanted {
                log.log(Category::Events, &describe(event));
            }
        };
        match &mut self.engine {
            Engine::Simulation(simulator) => {
                simulator.apply_due_event(Some(&mut show));
            }
            Engine::Closed(form) => form.apply_due_event(Some(&mut show)),
            Engine::None | Engine::Continuous(_) => {}
        }
        self.events.side = side;
        self.invalidate();
        Ok(())
    }

    fn shown(&self) -> Discrete {
        match &self.engine {
            Engine::Simulation(simulator) => Discrete::of_simulator(simulator),
            Engine::Closed(form) => Discrete::of(&form.values()),
            Engine::Continuous(continuous) => Discrete::of(&continuous.values()),
            Engine::None => Discrete::of(&OutputValues::default()),
        }
    }

    fn latch(&mut self, shown: Option<Discrete>) {
        self.events.latched = shown;
    }

    /// Holds loads that have followed polynomials at their present values. If the step has stopped
    /// before its end, these loads continue to follow the polynomials.
    fn end_step(&mut self, ended: Ended) {
        self.events.pending = ended.event;
        if ended.due || !self.life.handling.event_mode {
            self.events.side = 0; // a due event is the last one; without Event Mode it is unused
        }
        let Engine::Simulation(simulator) = &self.engine else { return };
        for (body, load) in self.settings.loads.derivatives.iter_mut().enumerate() {
            if load[1..] != [0.0; 3] {
                let now = simulator.loads().derivatives[body];
                *load = if ended.stopped { now } else { [now[0], 0.0, 0.0, 0.0] };
                self.loads_set |= !ended.stopped;
            }
        }
    }

    fn set_input(&mut self, reference: u32, polynomial: [f64; 4]) {
        if let Some(body) = self.variable_of(reference).ok().and_then(|variable| variable.body) {
            self.settings.loads.derivatives[body] = polynomial;
            self.loads_set = true;
        }
    }

    fn begin_event(&mut self) {
        let (shown, side) =
            ((self.edition == Edition::Clocked).then(|| self.impacts_shown()), self.events.side);
        self.events = EventState::default();
        if self.life.handling.event_mode {
            self.invalidate();
        }
        if let Some(shown) = shown {
            self.begin_tick(shown, side);
        }
    }

    fn carry_out(&mut self, log: &mut dyn Log) -> Outcome<Handled> {
        self.end_tick()?;
        let states = self.apply_event(log)?;
        Ok(Handled { states, nominals: self.nominals_changed() })
    }

    /// Carries out an event that the host has not carried out, and logs a warning.
    fn go_on(&mut self, log: Option<&mut dyn Log>) -> Outcome {
        let Some(log) = log.filter(|_| !self.events.carried_out) else { return Ok(()) };
        self.carry_out(log)?;
        if log.wants(Category::Warnings) {
            let what =
                "the discrete states were not updated since the event, or the last set value: done now";
            log.log(Category::Warnings, what);
        }
        Ok(())
    }

    /// An event that has been shown but not carried out is applied at the end, so that the values
    /// read remain and are saved. An event that is not possible is not applied. After an error the
    /// event is not applied, neither here nor in a state saved now; a tick of the clock ends.
    fn end(&mut self, failed: bool) {
        if failed && self.end_tick().is_err() {
            self.tick.active = false;
        }
        if self.looks_past_the_event() && (failed || self.apply_event(&mut Silence).is_err()) {
            self.invalidate();
        }
    }

    fn put_time(&mut self, time: f64) -> Outcome {
        self.continuous_mut()?.set_time(time)?;
        self.invalidate();
        Ok(())
    }

    /// Updates the energy accounts to the present point.
    fn accept(&mut self) -> Outcome<bool> {
        let continuous = self.continuous_mut()?;
        continuous.accept();
        let missed = continuous.missed_event();
        self.invalidate();
        Ok(missed)
    }
}

/// The stop of an impact; for any other event, `before`.
fn side_of(event: &Event, before: i8) -> i8 {
    match event {
        Event::Impact { side, .. } => *side,
        _ => before,
    }
}

/// Runs a simulator. A step that ends after an event ends after any event if `every` is true,
/// otherwise only after an impact.
fn run(
    simulator: &mut Simulator,
    end: StepEnd,
    (until, every): (Until, bool),
    mut report: EventObserver<'_, '_>,
) -> Result<Met, Error> {
    let (to, last) = (DoubleDouble::sum(end.point, end.size), end.value());
    let is_before = |simulator: &Simulator| last - simulator.time() > rounding(last);
    let stopped = Met { stopped: true, ..Met::default() };
    match until {
        Until::End => {
            advance(simulator, to, Pause::Never, report)?;
        }
        Until::Event => {
            if advance(simulator, to, Pause::BeforeEvent, report)? == AdvanceOutcome::EventDue {
                return Ok(Met { due: true, ..Met::default() });
            }
        }
        Until::After if every => {
            let paused = advance(simulator, to, Pause::BeforeEvent, report.as_deref_mut())?
                == AdvanceOutcome::EventDue;
            let early = paused && is_before(simulator);
            if paused || is_at_end(simulator, last)? {
                simulator.apply_due_event(report.as_deref_mut());
                if early {
                    return Ok(stopped);
                }
                advance(simulator, to, Pause::Never, report)?;
            }
            return Ok(Met::default());
        }
        Until::After => {
            if advance(simulator, to, Pause::AfterImpact, report.as_deref_mut())? == AdvanceOutcome::Impact {
                if is_before(simulator) {
                    return Ok(stopped);
                }
                // The event is at the end up to rounding.
                advance(simulator, to, Pause::Never, report)?;
            }
        }
    }
    Ok(Met { due: !end.is_chosen() && is_at_end(simulator, last)?, ..Met::default() })
}

/// Plays a steady state. A long run does not report all impacts; the number of unreported impacts
/// is also returned.
fn play(
    form: &mut ClosedForm,
    end: StepEnd,
    (until, every): (Until, bool),
    report: EventObserver<'_, '_>,
) -> Outcome<(Met, f64)> {
    let last = end.value();
    if until == Until::Event || until == Until::After && every {
        let due = form.advance_before_event(end.point, end.size, rounding(last))?;
        if until == Until::Event {
            return Ok((Met { due, ..Met::default() }, 0.0));
        }
        form.apply_due_event(report);
        let stopped = due && last - form.time() > rounding(last);
        return Ok((Met { stopped, ..Met::default() }, 0.0));
    }
    let (reached, left_out) = form.advance(end.point, end.size, until == Until::After, report)?;
    if reached == AdvanceOutcome::Impact {
        return Ok((Met { stopped: form.time() < last, ..Met::default() }, left_out));
    }
    Ok((Met { due: form.meet(rounding(last)), ..Met::default() }, left_out))
}
