//! Events of co-simulation as a host sees them that handles them itself: the component pauses
//! before an event, shows both of its limits, and applies its law when it is told to. A solver's
//! events (Model Exchange) are handled in the same two calls.

use super::arrival::take_back;
use super::{ComponentProblem, Engine, Instance, Outcome, Phase};
use crate::component::closed_form::ClosedForm;
use crate::component::continuous::Continuous;
use crate::component::log::{Category, Log};
use crate::component::settings::Settings;
use crate::component::values::Tick;
use std::borrow::Cow;
use vibro_impact::parameters::Parameters;
use vibro_impact::simulator::{Contact, DueEvent, Event, ImpactRecord, Loads, Simulator};

/// What moves, as it is to be read now: at an event the host handles, a copy after the event.
#[allow(clippy::large_enum_variant)] // it lives while it is read, and boxes would allocate
pub(super) enum Present<'a> {
    None,
    Simulation(Cow<'a, Simulator>),
    Closed(Cow<'a, ClosedForm>),
    Continuous(Cow<'a, Continuous>),
}

/// What a step or an event is to take over from the settings.
#[derive(Clone, Copy, Default)]
pub(super) struct Changes<'a> {
    pub(super) parameters: Option<&'a Parameters>,
    pub(super) loads: Option<&'a Loads>,
}

impl<'a> Changes<'a> {
    /// Of settings of which parameters or loads were set.
    pub(super) fn of(settings: &'a Settings, (parameters, loads): (bool, bool)) -> Self {
        Self {
            parameters: parameters.then_some(&settings.parameters),
            loads: loads.then_some(&settings.loads),
        }
    }

    pub(super) fn any(&self) -> bool {
        self.parameters.is_some() || self.loads.is_some()
    }

    /// Lets the simulator take them over.
    ///
    /// # Errors
    /// As the simulator's; the first may have been taken over then.
    pub(super) fn put(&self, simulator: &mut Simulator) -> Result<(), vibro_impact::Error> {
        if let Some(parameters) = self.parameters {
            simulator.set_parameters(parameters)?;
        }
        if let Some(loads) = self.loads {
            simulator.set_loads(loads)?;
        }
        Ok(())
    }
}

/// Reports the rest or release that has come of what was set from outside, if there was one.
pub(super) fn report_contact(before: Contact, simulator: &Simulator, report: &mut dyn FnMut(&Event)) {
    let (time, now) = (simulator.time(), simulator.contact());
    if now != before {
        report(&match now {
            Contact::Flight => Event::Release { time, side: before.side() as i8 },
            rest => Event::Rest { time, side: rest.side() as i8 },
        });
    }
}

/// Tells events where that is wanted.
pub(super) fn teller<'a>(log: &'a mut dyn Log) -> impl FnMut(&Event) + 'a {
    let wanted = log.wants(Category::Events);
    move |event| {
        if wanted {
            log.log(Category::Events, &describe(event));
        }
    }
}

/// All impacts of a record.
fn impacts(record: &ImpactRecord) -> u64 {
    record.upper + record.lower
}

impl Instance {
    /// What was set and not yet taken over.
    pub(super) fn changes(&self) -> Changes<'_> {
        Changes::of(&self.settings, (self.parameters_set, self.loads_set))
    }

    /// Whether what is read now is what comes after the event at which the host stands.
    pub(super) fn looks_past_the_event(&self) -> bool {
        self.life.phase == Phase::Event && self.life.handling.event_mode && !self.events.carried_out
    }

    /// What is to be read now.
    ///
    /// # Errors
    /// When what was set is not possible.
    pub(super) fn present(&self) -> Outcome<Present<'_>> {
        let past = self.looks_past_the_event();
        Ok(match &self.engine {
            Engine::None => Present::None,
            Engine::Simulation(simulator) => {
                let changes = self.changes();
                if past && (simulator.due_event().is_some() || changes.any()) {
                    let mut ahead = Simulator::clone(simulator);
                    changes.put(&mut ahead)?;
                    ahead.apply_due_event(None);
                    Present::Simulation(Cow::Owned(ahead))
                } else {
                    Present::Simulation(Cow::Borrowed(simulator))
                }
            }
            Engine::Closed(form) => {
                if past && (form.is_due() || self.parameters_set) {
                    Present::Closed(Cow::Owned(after_event(form, self.changes().parameters, &mut |_| {})?))
                } else {
                    Present::Closed(Cow::Borrowed(form))
                }
            }
            Engine::Continuous(continuous) => {
                if past {
                    let mut ahead = Continuous::clone(continuous);
                    ahead.handle_event(&mut |_| {});
                    Present::Continuous(Cow::Owned(ahead))
                } else {
                    Present::Continuous(Cow::Borrowed(continuous))
                }
            }
        })
    }

    /// The clock of impacts ticks at an event at which more impacts are counted than were `shown`;
    /// `side` is the stop of the last one that a step has passed over, or 0.
    pub(super) fn begin_tick(&mut self, shown: u64, side: i8) {
        // Where the values cannot be had, getters will say why.
        if self.refresh_values().is_ok() {
            self.tick.active = impacts(&self.values.impacts) > shown;
            if self.tick.active {
                let w = self.values.relative.0;
                self.tick.side = if side != 0 { side } else { w.signum() as i8 };
            }
        }
    }

    /// Impacts that are counted so far, as it is shown.
    pub(super) fn impacts_shown(&self) -> u64 {
        match (&self.events.latched, &self.engine) {
            (Some(shown), _) => impacts(&shown.impacts),
            (None, Engine::Simulation(simulator)) => impacts(simulator.impacts()),
            (None, Engine::Closed(form)) => impacts(&form.values().impacts),
            (None, Engine::Continuous(continuous)) => impacts(continuous.impacts()),
            (None, Engine::None) => 0,
        }
    }

    /// What the clock of impacts shows, the values being up to date: while it ticks, the impact
    /// after the event; else that of the last tick.
    pub(super) fn present_tick(&self) -> Tick {
        if !self.tick.active {
            return self.tick;
        }
        let ImpactRecord { last_time: time, last_impulse: impulse, last_speed: speed, .. } =
            self.values.impacts;
        Tick { time, impulse, speed, ..self.tick }
    }

    /// Ends the tick; what it has shown stays.
    pub(super) fn end_tick(&mut self) -> Outcome {
        if self.tick.active {
            self.refresh_values()?;
            self.tick = Tick { active: false, ..self.present_tick() };
        }
        Ok(())
    }

    /// The impact law, rest or release where the present point calls for it, with inputs and
    /// parameters as set now; whether states have changed. One call does all that happens at an
    /// instant; a further one does nothing.
    ///
    /// # Errors
    /// What was set and is not possible; nothing has changed then.
    pub(super) fn apply_event(&mut self, log: &mut dyn Log) -> Outcome<bool> {
        let mut report = teller(log);
        let changes = Changes::of(&self.settings, (self.parameters_set, self.loads_set));
        let changed = match &mut self.engine {
            Engine::None => return Err(ComponentProblem::sequence("the instance is not initialized")),
            Engine::Continuous(continuous) => continuous.handle_event(&mut report),
            Engine::Simulation(simulator) => {
                let (before, contact) = (simulator.snapshot(), simulator.contact());
                if let Err(error) = changes.put(simulator) {
                    return Err(take_back(simulator, &before, error.into()));
                }
                report_contact(contact, simulator, &mut report);
                matches!(simulator.apply_due_event(Some(&mut report)), Some(DueEvent::Impact { .. }))
            }
            Engine::Closed(form) => {
                let due = form.is_due();
                **form = after_event(form, changes.parameters, &mut report)?;
                due
            }
        };
        if !matches!(self.engine, Engine::Continuous(_)) {
            (self.parameters_set, self.loads_set) = (false, false);
        }
        self.events.carried_out = true;
        self.invalidate();
        Ok(changed)
    }
}

/// The steady state after the impact at which it stands, with parameters that were set since.
fn after_event(
    form: &ClosedForm,
    parameters: Option<&Parameters>,
    report: &mut dyn FnMut(&Event),
) -> Outcome<ClosedForm> {
    let (mut ahead, mut impact) = (form.clone(), None);
    ahead.apply_due_event(Some(&mut |event| impact = Some(*event)));
    if let Some(parameters) = parameters {
        ahead.set_parameters(parameters)?;
    }
    impact.iter().for_each(report);
    Ok(ahead)
}

/// Tells how many impacts of a steady state a long step has not listed.
pub(super) fn log_left_out(impacts: f64, end: f64, log: &mut dyn Log) {
    if impacts > 0.0 && log.wants(Category::Events) {
        let message = format!("{impacts} more impacts up to t = {end} s are not listed one by one");
        log.log(Category::Events, &message);
    }
}

/// An event in words.
pub(super) fn describe(event: &Event) -> String {
    let stop = |side: i8| if side > 0 { "upper" } else { "lower" };
    match *event {
        Event::Impact { time, side, speed, impulse } => format!(
            "impact on the {} stop at t = {time} s: approach speed {speed} m/s, impulse {impulse} N.s",
            stop(side)
        ),
        Event::Rest { time, side } => {
            format!("the block comes to rest on the {} stop at t = {time} s", stop(side))
        }
        Event::Release { time, side } => format!("the block leaves the {} stop at t = {time} s", stop(side)),
    }
}
