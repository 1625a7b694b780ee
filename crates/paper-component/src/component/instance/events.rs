//! Events of Co-Simulation for a host that handles them itself. The component pauses before an
//! event, shows the limits before and after it, and applies the law when the host calls for it.
//! Events in Model Exchange are handled by the same two calls.

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

/// Source of all values at present: the motion, or its copy after the event while the host handles
/// an event.
#[allow(clippy::large_enum_variant)] // it lives while it is read, and boxes would allocate
pub(super) enum Present<'a> {
    None,
    Simulation(Cow<'a, Simulator>),
    Closed(Cow<'a, ClosedForm>),
    Continuous(Cow<'a, Continuous>),
}

/// Settings that a step or an event takes over.
#[derive(Clone, Copy, Default)]
pub(super) struct Changes<'a> {
    pub(super) parameters: Option<&'a Parameters>,
    pub(super) loads: Option<&'a Loads>,
}

impl<'a> Changes<'a> {
    /// Changes of settings; the flags are whether parameters and loads were set.
    pub(super) fn of(settings: &'a Settings, (parameters, loads): (bool, bool)) -> Self {
        Self {
            parameters: parameters.then_some(&settings.parameters),
            loads: loads.then_some(&settings.loads),
        }
    }

    pub(super) fn any(&self) -> bool {
        self.parameters.is_some() || self.loads.is_some()
    }

    /// Applies the changes to the simulator.
    ///
    /// # Errors
    /// Errors of the simulator. The parameters may already have been set then.
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

/// Reports the rest or release that set values have caused, if any.
pub(super) fn report_contact(before: Contact, simulator: &Simulator, report: &mut dyn FnMut(&Event)) {
    let (time, now) = (simulator.time(), simulator.contact());
    if now != before {
        report(&match now {
            Contact::Flight => Event::Release { time, side: before.side() as i8 },
            rest => Event::Rest { time, side: rest.side() as i8 },
        });
    }
}

/// Logs events if the category of events is enabled.
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
    /// Settings that are not taken over yet.
    pub(super) fn changes(&self) -> Changes<'_> {
        Changes::of(&self.settings, (self.parameters_set, self.loads_set))
    }

    /// Whether the shown values are the values after the present event.
    pub(super) fn looks_past_the_event(&self) -> bool {
        self.life.phase == Phase::Event && self.life.handling.event_mode && !self.events.carried_out
    }

    /// Source of all values at present.
    ///
    /// # Errors
    /// If a value that was set is not possible.
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

    /// The clock of impacts ticks at an event if the number of impacts is larger than `shown`.
    /// `side` is the stop of the last impact that a step has passed, or 0.
    pub(super) fn begin_tick(&mut self, shown: u64, side: i8) {
        // If the values cannot be computed, the getters return the error.
        if self.refresh_values().is_ok() {
            self.tick.active = impacts(&self.values.impacts) > shown;
            if self.tick.active {
                let w = self.values.relative.0;
                self.tick.side = if side != 0 { side } else { w.signum() as i8 };
            }
        }
    }

    /// Number of impacts shown so far.
    pub(super) fn impacts_shown(&self) -> u64 {
        match (&self.events.latched, &self.engine) {
            (Some(shown), _) => impacts(&shown.impacts),
            (None, Engine::Simulation(simulator)) => impacts(simulator.impacts()),
            (None, Engine::Closed(form)) => impacts(&form.values().impacts),
            (None, Engine::Continuous(continuous)) => impacts(continuous.impacts()),
            (None, Engine::None) => 0,
        }
    }

    /// Values of the clock of impacts; `values` must be up to date. While the clock ticks they
    /// belong to the impact at the event, otherwise to the last tick.
    pub(super) fn present_tick(&self) -> Tick {
        if !self.tick.active {
            return self.tick;
        }
        let ImpactRecord { last_time: time, last_impulse: impulse, last_speed: speed, .. } =
            self.values.impacts;
        Tick { time, impulse, speed, ..self.tick }
    }

    /// Ends the tick; its values remain.
    pub(super) fn end_tick(&mut self) -> Outcome {
        if self.tick.active {
            self.refresh_values()?;
            self.tick = Tick { active: false, ..self.present_tick() };
        }
        Ok(())
    }

    /// Applies the impact law, rest or release that is due at the present point, with the inputs
    /// and parameters set now. Returns whether states have changed. One call carries out
    /// everything due at the present time; a further call does nothing.
    ///
    /// # Errors
    /// If a value that was set is not possible; then nothing has changed.
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

/// The steady state after the impact that is due, if any, with the parameters set since.
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

/// Logs the number of impacts of a steady state that a long step has not listed.
pub(super) fn log_left_out(impacts: f64, end: f64, log: &mut dyn Log) {
    if impacts > 0.0 && log.wants(Category::Events) {
        let message = format!("{impacts} more impacts up to t = {end} s are not listed one by one");
        log.log(Category::Events, &message);
    }
}

/// Description of an event.
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
