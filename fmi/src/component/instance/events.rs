//! Events of co-simulation as a host sees them that handles them itself: the component pauses
//! before an event, shows both of its limits, and applies its law when it is told to. A solver's
//! events (Model Exchange) are handled in the same two calls.

use super::arrival::take_back;
use super::{Engine, EventHandling, Instance, Outcome, Phase, Problem};
use crate::component::closed_form::ClosedForm;
use crate::component::continuous::Continuous;
use crate::component::event_state::EventState;
use crate::component::log::{Category, Log};
use crate::component::settings::Settings;
use crate::component::values::Tick;
use crate::component::variables::Edition;
use fmi_doors::Handled;
use std::borrow::Cow;
use vibro_impact::parameters::Parameters;
use vibro_impact::simulator::{Contact, DueEvent, Event, EventObserver, ImpactRecord, Loads, Simulator};

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

    /// Lets the simulator take them over; true where that has changed the contact, which is
    /// reported.
    ///
    /// # Errors
    /// As the simulator's; the first may have been taken over then.
    pub(super) fn put(
        &self,
        simulator: &mut Simulator,
        report: EventObserver<'_, '_>,
    ) -> Result<bool, vibro_impact::Error> {
        let before = simulator.contact();
        if let Some(parameters) = self.parameters {
            simulator.set_parameters(parameters)?;
        }
        if let Some(loads) = self.loads {
            simulator.set_loads(loads)?;
        }
        Ok(report_contact(before, simulator, report))
    }
}

/// Reports the rest or release that has come of what was set from outside; true where there was
/// one.
pub(super) fn report_contact(before: Contact, simulator: &Simulator, report: EventObserver<'_, '_>) -> bool {
    let (time, now) = (simulator.time(), simulator.contact());
    if now == before {
        return false;
    }
    if let Some(report) = report {
        report(&match now {
            Contact::Flight => Event::Release { time, side: before.side() as i8 },
            rest => Event::Rest { time, side: rest.side() as i8 },
        });
    }
    true
}

/// All impacts of a record.
fn impacts(record: &ImpactRecord) -> u64 {
    record.upper + record.lower
}

impl Instance {
    /// What the host does about events.
    pub fn event_handling(&self) -> EventHandling {
        self.life.handling
    }

    /// What was set and not yet taken over.
    pub(super) fn changes(&self) -> Changes<'_> {
        Changes::of(&self.settings, (self.parameters_set, self.loads_set))
    }

    /// All that was set has been taken over, and nothing that was computed holds any longer.
    pub(super) fn taken_over(&mut self) {
        (self.parameters_set, self.loads_set) = (false, false);
        self.slopes_set = [false; 3];
        self.invalidate();
    }

    /// Whether what is read now is what comes after the event at which the host stands.
    fn looks_past_the_event(&self) -> bool {
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
                    changes.put(&mut ahead, None)?;
                    ahead.apply_due_event(None);
                    Present::Simulation(Cow::Owned(ahead))
                } else {
                    Present::Simulation(Cow::Borrowed(simulator))
                }
            }
            Engine::Closed(form) => {
                if past && (form.is_due() || self.parameters_set) {
                    Present::Closed(Cow::Owned(self.form_after_event(form, None)?))
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

    /// The steady state after the impact at which it stands, with the parameters that were set
    /// since.
    fn form_after_event(&self, form: &ClosedForm, report: EventObserver<'_, '_>) -> Outcome<ClosedForm> {
        let (mut ahead, mut impact) = (form.clone(), None);
        ahead.apply_due_event(Some(&mut |event| impact = Some(*event)));
        if self.parameters_set {
            ahead.set_parameters(&self.settings.parameters)?;
        }
        if let (Some(event), Some(report)) = (impact, report) {
            report(&event);
        }
        Ok(ahead)
    }

    /// The host comes to handle an event: what changes at events only is shown from now on. There
    /// need not be one.
    ///
    /// # Errors
    /// [`Sequence`](fmi_doors::Problem::Sequence) before initialization.
    pub fn enter_event(&mut self) -> Outcome {
        match &mut self.engine {
            Engine::None => return Err(Problem::sequence("the instance is not initialized")),
            Engine::Continuous(continuous) => continuous.accept(),
            Engine::Simulation(_) | Engine::Closed(_) => {}
        }
        self.begin_event();
        Ok(())
    }

    /// The phase of an event, with nothing done about it yet.
    pub(super) fn begin_event(&mut self) {
        let (shown, side) =
            ((self.edition == Edition::Clocked).then(|| self.impacts_shown()), self.events.side);
        self.life.phase = Phase::Event;
        self.events = EventState::default();
        if self.life.handling.event_mode {
            self.invalidate();
        }
        // Where the values cannot be had, getters will say why.
        if let (Some(shown), Ok(())) = (shown, self.refresh_values()) {
            self.tick.active = impacts(&self.values.impacts) > shown;
            if self.tick.active {
                let w = self.values.relative.0;
                self.tick.side = if side != 0 { side } else { w.signum() as i8 };
            }
        }
    }

    /// Impacts that are counted so far, as it is shown.
    fn impacts_shown(&self) -> u64 {
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
    fn end_tick(&mut self) -> Outcome {
        if self.tick.active {
            self.refresh_values()?;
            self.tick = Tick { active: false, ..self.present_tick() };
        }
        Ok(())
    }

    /// The impact law, rest or release where the present point calls for it, with inputs and
    /// parameters as set now; returns what has changed. One call does all that happens at an
    /// instant; a further one does nothing.
    ///
    /// # Errors
    /// [`Sequence`](fmi_doors::Problem::Sequence) before initialization; what was set and is not
    /// possible. Nothing has changed then.
    pub fn handle_events(&mut self, log: &mut dyn Log) -> Outcome<Handled> {
        self.end_tick()?;
        let wanted = log.wants(Category::Events);
        let mut show = |event: &Event| log.log(Category::Events, &describe(event));
        let report: EventObserver = if wanted { Some(&mut show) } else { None };
        let changed = self.carry_out_event(report)?;
        Ok(Handled { states: changed, nominals: self.nominals_changed() })
    }

    /// The same without its messages; whether states have changed.
    fn carry_out_event(&mut self, mut report: EventObserver<'_, '_>) -> Outcome<bool> {
        let changed = match &mut self.engine {
            Engine::None => return Err(Problem::sequence("the instance is not initialized")),
            Engine::Continuous(continuous) => continuous.handle_event(&mut |event| {
                if let Some(report) = &mut report {
                    report(event);
                }
            }),
            Engine::Simulation(_) => self.carry_out(report)?,
            Engine::Closed(_) => self.carry_out_form(report)?,
        };
        if !matches!(self.engine, Engine::Continuous(_)) {
            (self.parameters_set, self.loads_set) = (false, false);
        }
        self.events.carried_out = true;
        self.invalidate();
        Ok(changed)
    }

    /// Ends the simulation. An event that has been shown but not been updated has taken place, so
    /// that what was read stays and is saved; one that is not possible has not.
    pub fn terminate(&mut self) {
        if self.looks_past_the_event() && self.carry_out_event(None).is_err() {
            self.invalidate();
        }
        self.life.phase = Phase::Terminated;
    }

    /// An error has ended the simulation. An event that has been shown but not been updated has not
    /// taken place: neither here nor in a state saved now. A clock that ticks there has ticked:
    /// what it has shown stays as that of its last tick.
    pub fn fail(&mut self) {
        if self.end_tick().is_err() {
            self.tick.active = false;
        }
        if self.looks_past_the_event() {
            self.invalidate();
        }
        self.life.phase = Phase::Terminated;
    }

    /// The same for the simulator; true where an impact has made the states jump.
    fn carry_out(&mut self, mut report: EventObserver<'_, '_>) -> Outcome<bool> {
        let changes = Changes::of(&self.settings, (self.parameters_set, self.loads_set));
        let Engine::Simulation(simulator) = &mut self.engine else { return Ok(false) };
        let before = simulator.snapshot();
        if let Err(error) = changes.put(simulator, report.as_deref_mut()) {
            return Err(take_back(simulator, &before, error));
        }
        let due = simulator.apply_due_event(report);
        Ok(matches!(due, Some(DueEvent::Impact { .. })))
    }

    /// The same for a steady state.
    fn carry_out_form(&mut self, report: EventObserver<'_, '_>) -> Outcome<bool> {
        let Engine::Closed(form) = &self.engine else { return Ok(false) };
        let (due, next) = (form.is_due(), self.form_after_event(form, report)?);
        self.engine = Engine::Closed(Box::new(next));
        Ok(due)
    }

    /// The component steps on from here; an event the host has not carried out is, with a warning.
    ///
    /// # Errors
    /// As [`handle_events`](Self::handle_events).
    pub fn leave_event(&mut self, log: &mut dyn Log) -> Outcome {
        if !self.events.carried_out {
            self.handle_events(log)?;
            if log.wants(Category::Warnings) {
                let what =
                    "the discrete states were not updated since the event, or the last set value: done now";
                log.log(Category::Warnings, what);
            }
        }
        self.life.go_on();
        Ok(())
    }
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
