//! Variables, continuous states and saved states: the component's [`Model`](fmi_doors::Model).

use super::access::{check_order, jet_of, no_such};
use super::{ComponentProblem, Engine, Instance, Outcome};
use crate::component::closed_form::ClosedForm;
use crate::component::continuous::{Continuous, check_states};
use crate::component::log::{Category, Log};
use crate::component::protocol::Protocol;
use crate::component::saved_state::{EngineState, SavedState};
use crate::component::settings::Settings;
use crate::component::structure::{DERIVATIVES, EVENT_INDICATORS, STATES};
use crate::component::variables::{Bases, Edition, Get, READERS, Reader, WRITERS, Writer};
use fmi_doors::{Dependency, EarlyEnd, Instantiation, Interface, Life, Model, Named};
use vibro_impact::simulator::{Simulator, State};

/// Highest order of input derivatives.
const INPUT_ORDER: i32 = 3;
/// Highest order of output derivatives: the derivatives of displacements are known up to the fifth
/// order, so the derivatives of accelerations up to the third.
const OUTPUT_ORDER: i32 = 3;
/// Limit of |w| in a state set by a solver, in gaps, in all editions except the first. A solver
/// that searches for an impact stays within this limit; a larger |w| is an error.
const REACH: f64 = 10.0;

#[allow(refining_impl_trait)] // numbers of the model are arrays
impl Model for Instance {
    type Problem = ComponentProblem;
    type State = SavedState;

    /// There are fewer than 100 variables; a saved state has less than a kilobyte.
    const MAX_COUNT: usize = 4096;
    const EARLY_END: EarlyEnd = EarlyEnd { event: "impact", because: ", since stopAtImpact is true" };

    fn instantiate(request: &Instantiation<'_>) -> Outcome<Self> {
        Ok(Self::of_protocol(request.interface, Protocol::of(request)?))
    }

    #[inline]
    fn life(&self) -> &Life {
        &self.life
    }

    #[inline]
    fn life_mut(&mut self) -> &mut Life {
        &mut self.life
    }

    /// A clock ticks only in Event Mode.
    fn tell_at_instantiation(&self, log: &mut dyn Log) {
        let silent = self.edition == Edition::Clocked && !self.life.handling.event_mode;
        if silent && log.wants(Category::Warnings) {
            let what = "eventModeUsed is false, so impacts.clock never ticks; everything else is correct";
            log.log(Category::Warnings, what);
        }
    }

    fn reset(&mut self) {
        let (numbering, edition) = (self.numbering, self.edition);
        let protocol = Protocol { numbering, handling: self.life.handling, start: self.initial, edition };
        *self = Self::of_protocol(self.life.interface, protocol);
    }

    fn time(&self) -> f64 {
        match &self.engine {
            Engine::Simulation(simulator) => simulator.time(),
            Engine::Closed(form) => form.time(),
            Engine::Continuous(continuous) => continuous.time(),
            Engine::None => self.life.start_time(),
        }
    }

    fn variable(&self, reference: u32) -> Outcome<Named<'_>> {
        let variable = self.variable_of(reference)?;
        Ok(Named {
            name: variable.name.into(),
            continuous_input: variable.body.is_some(),
            intermediate_update: variable.is_seen_within_steps(),
        })
    }

    #[inline]
    fn get(&mut self, bases: Bases, references: &[u32], mut write: impl FnMut(usize, f64)) -> Outcome {
        let numbering = self.numbering;
        let initialized = !matches!(self.engine, Engine::None);
        let mut needs = 0;
        for &reference in references {
            match READERS.get(numbering.place(reference)) {
                Some(reader) if bases.contains(reader.base) => needs |= reader.needs,
                _ => return Err(no_such(numbering, reference, bases)),
            }
        }
        let moves = needs & Reader::MOTION != 0 || initialized && needs & Reader::START != 0;
        if moves && self.values_stale {
            self.refresh_values()?;
        }
        if needs & Reader::DERIVED != 0 && self.derived_stale {
            self.refresh_derived();
        }
        if needs & Reader::PREDICTION != 0 {
            self.refresh_prediction();
        }
        if needs & Reader::STEP != 0 {
            self.refresh_step_matrices();
        }
        let mut i = 0;
        for &reference in references {
            let value = match READERS[numbering.place(reference)].get {
                Get::Output(get) => get(&self.values),
                Get::Start(_, now) if initialized => now(&self.values),
                Get::Setting(get) | Get::Start(get, _) => get(&self.settings),
                Get::Derived(get) => get(&self.derived),
                Get::Prediction(get) => get(&self.prediction.unwrap_or_default()),
                Get::Tick(get) => get(&self.present_tick()),
                Get::Elements(size, get) => {
                    (0..size).for_each(|k| write(i + k, get(&self.values, k)));
                    i += size;
                    continue;
                }
                Get::Step(size, get) => {
                    (0..size).for_each(|k| write(i + k, get(&self.step_matrices.unwrap_or_default(), k)));
                    i += size;
                    continue;
                }
            };
            write(i, value);
            i += 1;
        }
        Ok(())
    }

    #[inline]
    fn set(&mut self, bases: Bases, references: &[u32], read: impl Fn(usize) -> f64) -> Outcome {
        let numbering = self.numbering;
        let when = self.when();
        let closed = matches!(self.engine, Engine::Closed(_));
        for (i, &reference) in references.iter().enumerate() {
            let value = read(i);
            let plain = |writer: &Writer| writer.takes(bases, when, value) && !(closed && writer.input);
            if !WRITERS.get(numbering.place(reference)).is_some_and(plain) {
                self.check_set(reference, bases, value)?;
            }
        }
        // A host's solver sees the new values immediately, not in the next step.
        let before = match &self.engine {
            Engine::Continuous(continuous) => {
                let set = (self.parameters_set, self.loads_set, self.given);
                Some((self.settings, set, self.events, continuous.state()))
            }
            _ => None,
        };
        self.events.carried_out &= references.is_empty();
        for (i, &reference) in references.iter().enumerate() {
            self.assign(&WRITERS[numbering.place(reference)], read(i));
        }
        if let (Some((settings, set, events, state)), Engine::Continuous(continuous)) =
            (before, &mut self.engine)
        {
            if self.parameters_set
                && let Err(error) = continuous.set_parameters(&self.settings.parameters)
            {
                (self.settings, self.events) = (settings, events);
                (self.parameters_set, self.loads_set, self.given) = set;
                continuous.set_state(state);
                self.invalidate();
                return Err(error.into());
            }
            self.parameters_set = false;
            continuous.set_forces(self.settings.loads.derivatives.map(|load| load[0]));
            self.invalidate();
        }
        Ok(())
    }

    fn set_input_derivatives(&mut self, references: &[u32], orders: &[i32], values: &[f64]) -> Outcome {
        for ((&reference, &order), &value) in references.iter().zip(orders).zip(values) {
            let variable = self.look_up(reference, Bases::REAL)?;
            if variable.body.is_none() {
                return Err(ComponentProblem::NoDerivative {
                    name: variable.name,
                    allowed: "derivatives of inputs",
                });
            }
            check_order(variable, order, INPUT_ORDER, "1, 2 or 3")?;
            if !value.is_finite() {
                return Err(ComponentProblem::value(variable.name, value, "a finite derivative"));
            }
            self.check_load(variable, value)?;
        }
        for ((&reference, &order), &value) in references.iter().zip(orders).zip(values) {
            if let Some(body) = self.look_up(reference, Bases::REAL)?.body {
                let load = &mut self.settings.loads.derivatives[body];
                if !self.slopes_set[body] {
                    self.slopes_set[body] = true;
                    load[1..].fill(0.0);
                }
                load[order as usize] = value;
                self.loads_set = true;
            }
        }
        self.prediction = None;
        if matches!(self.engine, Engine::None) {
            self.invalidate();
        }
        Ok(())
    }

    /// At an event these are the derivatives before it; if the outputs show the motion after the
    /// event, they are the derivatives after it.
    fn output_derivatives(
        &mut self,
        references: &[u32],
        orders: &[i32],
        mut write: impl FnMut(usize, f64),
    ) -> Outcome {
        for (&reference, &order) in references.iter().zip(orders) {
            let variable = self.look_up(reference, Bases::REAL)?;
            jet_of(variable)?;
            check_order(variable, order, OUTPUT_ORDER, "1, 2 or 3")?;
        }
        let jets = self.jets()?;
        let derivative = |instance: &Self, reference: u32, order: i32| -> Outcome<f64> {
            let variable = instance.look_up(reference, Bases::REAL)?;
            let value = jet_of(variable)?(&jets).0[order as usize];
            if value.is_finite() {
                return Ok(value);
            }
            Err(ComponentProblem::Overflow { name: variable.name, value, time: instance.time() })
        };
        for (&reference, &order) in references.iter().zip(orders) {
            derivative(self, reference, order)?;
        }
        for (i, (&reference, &order)) in references.iter().zip(orders).enumerate() {
            write(i, derivative(self, reference, order)?);
        }
        Ok(())
    }

    fn directional_derivative(
        &mut self,
        unknowns: &[u32],
        knowns: &[u32],
        seed: &[f64],
        write: impl FnMut(usize, f64),
    ) -> Outcome {
        self.derivative_along(unknowns, knowns, seed, write)
    }

    fn dependencies(&self, reference: u32) -> Outcome<Vec<Dependency>> {
        self.present_dependencies(reference)
    }

    /// In Model Exchange the host finds the events.
    fn next_event_time(&mut self) -> Option<f64> {
        if self.life.interface == Interface::ModelExchange {
            return None;
        }
        let prediction = self.prediction();
        prediction.known.then_some(prediction.time)
    }

    fn set_continuous_states(&mut self, states: &[f64]) -> Outcome {
        let states: &[f64; 6] =
            states.try_into().map_err(|_| ComponentProblem::sequence("there are six continuous states"))?;
        let w = states[1] - states[0];
        if self.edition > Edition::Every && w.abs() > REACH * self.settings.parameters.stop_gap {
            let allowed = "at most 10 times stop.gap, so that a solver can look beyond an impact";
            return Err(ComponentProblem::value("stop.s", w, allowed));
        }
        let state = check_states(states)?;
        self.continuous_mut()?.set_state(state);
        self.invalidate();
        Ok(())
    }

    fn continuous_states(&self) -> Outcome<[f64; 6]> {
        self.with_continuous(STATES, |continuous| {
            let State { x, v } = continuous.state();
            [x[0], x[1], x[2], v[0], v[1], v[2]]
        })
    }

    fn state_derivatives(&self) -> Outcome<[f64; 6]> {
        self.with_continuous(DERIVATIVES, Continuous::derivatives)
    }

    /// Distances to both stops in flight, pressing acceleration in rest: an event occurs when one
    /// becomes negative.
    fn event_indicators(&self) -> Outcome<[f64; EVENT_INDICATORS]> {
        self.with_continuous(["an event indicator"; EVENT_INDICATORS], Continuous::indicators)
    }

    /// Nominal values of the continuous states from the parameters set now: the gap, and the gap
    /// times the drive's frequency. Each is positive and finite.
    fn nominals(&self) -> [f64; 6] {
        let parameters = &self.settings.parameters;
        let positive = |value: f64| value.clamp(f64::MIN_POSITIVE, f64::MAX);
        let length = positive(parameters.stop_gap);
        let frequency = parameters.drive_frequency.abs();
        // If the drive's frequency is zero, the system's fastest rate replaces it.
        let own = || vibro_impact::model::Model::new(parameters).map_or(1.0, |model| model.rate);
        let speed = positive(length * if frequency > 0.0 { frequency } else { own() });
        [length, length, length, speed, speed, speed]
    }

    fn number_of_event_indicators(&self) -> usize {
        EVENT_INDICATORS
    }

    #[inline]
    fn save(&self) -> Outcome<SavedState> {
        Ok(Self::save(self))
    }

    #[inline]
    fn restore(&mut self, saved: &SavedState) -> Outcome {
        let mut life = self.life;
        let SavedState { interface, phase, experiment, .. } = *saved;
        life.take_over(&Life { interface, phase, experiment, ..life })?;
        saved.check()?;
        match (&mut self.engine, &saved.engine) {
            (engine, EngineState::None) => *engine = Engine::None,
            (Engine::Simulation(simulator), EngineState::Simulation(snapshot)) => {
                simulator.restore(snapshot)?;
            }
            (engine, EngineState::Simulation(snapshot)) => {
                // The values of this simulator have no effect: the snapshot replaces them.
                let standard = Settings::default();
                let mut simulator = Simulator::new(&standard.parameters, &standard.start, 0.0)?;
                simulator.restore(snapshot)?;
                *engine = Engine::Simulation(Box::new(simulator));
            }
            (Engine::Closed(form), EngineState::Closed(data)) => form.restore(*data)?,
            (engine, EngineState::Closed(data)) => {
                *engine = Engine::Closed(Box::new(ClosedForm::of(*data)?));
            }
            (Engine::Continuous(continuous), EngineState::Continuous(data)) => continuous.restore(*data)?,
            (engine, EngineState::Continuous(data)) => {
                *engine = Engine::Continuous(Box::new(Continuous::of(*data)?));
            }
        }
        self.life = life;
        self.derived_stale |= self.settings.parameters != saved.settings.parameters;
        self.settings = saved.settings;
        if saved.settings.stop_at_impact == saved.stop_by_default {
            self.settings.stop_at_impact = self.initial.stop_at_impact;
        }
        self.slopes_set = saved.slopes_set;
        self.parameters_set = saved.parameters_set;
        self.loads_set = saved.loads_set;
        self.last_step = None;
        self.events = saved.events;
        self.tick = saved.tick;
        self.nominals_told = saved.nominals_told;
        self.given = saved.given;
        self.invalidate();
        self.meet_own_protocol();
        Ok(())
    }

    fn serialize(&self, saved: &SavedState) -> Outcome<Vec<u8>> {
        saved.serialize()
    }

    fn deserialize(&self, bytes: &[u8]) -> Outcome<SavedState> {
        SavedState::deserialize(bytes)
    }
}
