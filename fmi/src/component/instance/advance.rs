//! Stepping for a host that may handle events itself or take steps that end early.

use super::arrival::{advance, is_at_end, pass_event_at_end, rounding, take_back};
use super::events::{Changes, describe, log_left_out};
use super::last_step::LastStep;
use super::{Engine, Instance, Outcome, Phase, Problem};
use crate::component::closed_form::ClosedForm;
use crate::component::event_state::Discrete;
use crate::component::log::{Category, Log};
use fmi_doors::Advance;
use vibro_impact::error::Error;
use vibro_impact::numerics::double_double::DoubleDouble;
use vibro_impact::simulator::{AdvanceOutcome, Event, EventObserver, Pause, Simulator};

/// What a step does at an event inside it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum AtEvent {
    /// Applies its law and goes on.
    Pass,
    /// Applies its law and goes on; what changes at events only is shown when the host handles
    /// events.
    Latch,
    /// Applies its law and ends.
    EndAfter,
    /// Ends before its law.
    EndBefore,
}

/// Where the motion stands after a run.
#[derive(Clone, Copy, Debug, Default)]
struct Stand {
    /// Before the end asked for.
    early: bool,
    /// An event was met whose handling is the host's.
    event: bool,
    /// The stop of the last impact that was passed over, or 0.
    side: i8,
    /// How many impacts of a steady state were not shown one by one.
    left_out: f64,
}

/// The stop of an event that is an impact; else what it was before.
pub(super) fn side_of(event: &Event, before: i8) -> i8 {
    match event {
        Event::Impact { side, .. } => *side,
        _ => before,
    }
}

impl Instance {
    /// From the present time towards `point + size`. Own time is the truth; `point` may be off by
    /// rounding. What a step does at an event is decided by the
    /// [`EventHandling`](crate::component::EventHandling) and the setting `stop_at_impact`:
    ///
    /// | event mode | early return, stop | at an event |
    /// |---|---|---|
    /// | no | no | its law is applied and the step goes on |
    /// | no | yes | its law is applied and the step ends |
    /// | yes | yes | the step ends before its law |
    /// | yes | no | its law is applied and the step goes on; discrete outputs change when the host handles events |
    ///
    /// An event at the step's end but for rounding ends it there: with event mode before the law,
    /// else after it.
    ///
    /// # Errors
    /// [`Problem`] when the step was not carried out at all; the component stands where it stood.
    pub fn advance(&mut self, point: f64, size: f64, log: &mut dyn Log) -> Outcome<Advance> {
        self.check_advance(point, size)?;
        let (at_event, event_mode) = (self.at_event(), self.life.handling.event_mode);
        let wanted = log.wants(Category::Events);
        let mut show = |event: &Event| log.log(Category::Events, &describe(event));
        let report: EventObserver = if wanted { Some(&mut show) } else { None };
        let changes = Changes::of(&self.settings, (self.parameters_set, self.loads_set));
        let (shown, stand) = match &mut self.engine {
            Engine::Simulation(simulator) => {
                let shown = event_mode.then(|| Discrete::of_simulator(simulator));
                let step = LastStep::begin(&mut self.last_step, simulator, &changes);
                let stand = match run(simulator, changes, (point, size), at_event, report) {
                    Ok(stand) => stand,
                    Err(error) => return Err(take_back(simulator, &step.before, error)),
                };
                (shown, stand)
            }
            Engine::Closed(form) => {
                let mut next = ClosedForm::clone(form);
                if let Some(parameters) = changes.parameters {
                    next.set_parameters(parameters)?;
                }
                let shown = event_mode.then(|| Discrete::of(&next.values()));
                let stand = play(&mut next, (point, size), at_event, report)?;
                **form = next;
                (shown, stand)
            }
            Engine::None | Engine::Continuous(_) => unreachable_step()?,
        };
        log_left_out(stand.left_out, point + size, log);
        self.life.phase = Phase::Step;
        self.events.pending = stand.event;
        self.events.latched = if stand.event { shown } else { None };
        // A host that handles no events is told of no side.
        self.events.side = if event_mode { stand.side } else { 0 };
        self.taken_over();
        self.hold_loads();
        Ok(Advance { time: self.time(), event: stand.event, early: stand.early })
    }

    /// Whether an advance can be made at all.
    pub(super) fn check_advance(&self, point: f64, size: f64) -> Outcome {
        self.check_step(point, size)?;
        if self.events.pending {
            return Err(Problem::sequence("the event of the last step must be handled in Event Mode first"));
        }
        Ok(())
    }

    pub(super) fn at_event(&self) -> AtEvent {
        let stop = self.life.handling.early_return && self.settings.stop_at_impact;
        match (self.life.handling.event_mode, stop) {
            (false, false) => AtEvent::Pass,
            (false, true) => AtEvent::EndAfter,
            (true, true) => AtEvent::EndBefore,
            (true, false) => AtEvent::Latch,
        }
    }
}

/// `check_step` has refused these engines.
fn unreachable_step<T>() -> Outcome<T> {
    Err(Problem::sequence("the instance is not initialized"))
}

/// One step of the simulator.
fn run(
    simulator: &mut Simulator,
    changes: Changes<'_>,
    (point, size): (f64, f64),
    at_event: AtEvent,
    mut report: EventObserver<'_, '_>,
) -> Result<Stand, Error> {
    let end = DoubleDouble::sum(point, size);
    // A block that an input has let go of, or pressed on, at the step's start.
    let moved = changes.put(simulator, report.as_deref_mut())?;
    if at_event == AtEvent::Pass {
        advance(simulator, end, Pause::Never, report.as_deref_mut())?;
        pass_event_at_end(simulator, point + size, report)?;
        return Ok(Stand::default());
    }
    if at_event == AtEvent::EndBefore && moved {
        let early = point + size - simulator.time() > rounding(point + size);
        return Ok(Stand { early, event: true, ..Stand::default() });
    }
    let (mut events, mut side) = (usize::from(moved), 0);
    if at_event == AtEvent::Latch {
        let mut count = |event: &Event| {
            events += 1;
            side = side_of(event, side);
            if let Some(report) = &mut report {
                report(event);
            }
        };
        advance(simulator, end, Pause::Never, Some(&mut count))?;
        let due = is_at_end(simulator, point + size)?;
        let side = if due { 0 } else { side }; // one that is due comes last
        return Ok(Stand { event: due || events > 0, side, ..Stand::default() });
    }
    let paused =
        advance(simulator, end, Pause::BeforeEvent, report.as_deref_mut())? == AdvanceOutcome::EventDue;
    let early = paused && point + size - simulator.time() > rounding(point + size);
    let due = paused || is_at_end(simulator, point + size)?;
    if at_event == AtEvent::EndBefore {
        return Ok(Stand { early, event: due, ..Stand::default() });
    }
    if due {
        simulator.apply_due_event(report.as_deref_mut());
        if !early {
            advance(simulator, end, Pause::Never, report)?;
        }
    }
    Ok(Stand { early, ..Stand::default() })
}

/// One step of a steady state.
fn play(
    form: &mut ClosedForm,
    (point, size): (f64, f64),
    at_event: AtEvent,
    mut report: EventObserver<'_, '_>,
) -> Outcome<Stand> {
    if let AtEvent::Pass | AtEvent::Latch = at_event {
        let (mut events, mut side) = (0, 0);
        let mut count = |event: &Event| {
            events += 1;
            side = side_of(event, side);
            if let Some(report) = &mut report {
                report(event);
            }
        };
        let (_, left_out) = form.advance(point, size, false, Some(&mut count))?;
        let (latch, due) = (at_event == AtEvent::Latch, form.meet(rounding(point + size)));
        if due && !latch {
            form.apply_due_event(Some(&mut count));
        }
        let side = if due { 0 } else { side }; // one that is due comes last
        return Ok(Stand { early: false, event: latch && (due || events > 0), side, left_out });
    }
    let due = form.advance_before_event(point, size, rounding(point + size))?;
    let early = due && point + size - form.time() > rounding(point + size);
    if at_event == AtEvent::EndBefore {
        return Ok(Stand { early, event: due, ..Stand::default() });
    }
    form.apply_due_event(report);
    Ok(Stand { early, ..Stand::default() })
}
