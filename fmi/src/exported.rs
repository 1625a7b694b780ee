//! The component as the doors want it: which protocol each version of FMI has with it, and what is
//! the component's own.

use crate::component::log::{Category, Log};
use crate::component::saved_state::SavedState;
use crate::component::settings::{Settings, SolutionMode};
use crate::component::structure::{EVENT_INDICATORS, STATES};
use crate::component::variables::{Bases, Edition};
use crate::component::{
    Advance, Handled, Instance, Interface, Piece, Pieces, Problem, Protocol, StepOutcome,
};
use crate::{fmi2, fmi3};
use fmi_doors::{Component, Dependency, EarlyEnd, Instantiation, Life, Model, Named, Refusal, Version};

/// How far beyond a stop a solver may look, in gaps from the middle, in descriptions later than the
/// first: farther out it does not look for an impact, but has gone astray.
const REACH: f64 = 10.0;

impl Refusal for Problem {
    fn is_of_a_value(&self) -> bool {
        match self {
            Self::Model(_) | Self::ClosedForm { .. } | Self::Overflow { .. } | Self::Derivative { .. } => {
                true
            }
            Self::Door(problem) => problem.is_of_a_value(),
            _ => false,
        }
    }
}

impl Instance {
    /// Whether its description is later than that of FMI 2.0.
    fn is_extended(&self) -> bool {
        self.edition() > Edition::Every
    }
}

impl Model for Instance {
    type Problem = Problem;
    type State = SavedState;

    /// There are fewer than 100 variables; a saved state has less than a kilobyte.
    const MAX_COUNT: usize = 4096;
    const EARLY_END: EarlyEnd = EarlyEnd { event: "impact", because: ", since stopAtImpact is true" };

    fn instantiate(request: &Instantiation<'_>) -> Result<Self, Problem> {
        let protocol = match request.version {
            Version::Fmi2 => {
                request.check_token(&fmi2::description::guid())?;
                Protocol {
                    numbering: fmi2::description::NUMBERING,
                    handling: request.handling,
                    start: Settings::default(),
                    edition: Edition::Every,
                }
            }
            Version::Fmi3 => {
                use fmi3::description;
                let edition = description::edition_of(request.token);
                let main = || request.wrong_token(&description::instantiation_token(description::MAIN));
                let edition = edition.ok_or_else(main)?;
                Protocol {
                    numbering: description::numbering(edition),
                    handling: request.handling,
                    start: description::start_settings(),
                    edition,
                }
            }
        };
        Ok(Self::of_protocol(request.interface, protocol))
    }

    #[inline]
    fn life(&self) -> &Life {
        Self::life(self)
    }

    fn life_mut(&mut self) -> &mut Life {
        Self::life_mut(self)
    }

    /// A clock ticks in Event Mode (FMI 3.0.2, 2.3.1: FMUs with clocks need `eventModeUsed`).
    fn tell_at_instantiation(&self, log: &mut dyn Log) {
        if self.edition() == Edition::Clocked
            && !self.event_handling().event_mode
            && log.wants(Category::Warnings)
        {
            log.log(
                Category::Warnings,
                "eventModeUsed is false, so impacts.clock never ticks; all else is right",
            );
        }
    }

    fn reset(&mut self) {
        Self::reset(self);
    }

    fn time(&self) -> f64 {
        Self::time(self)
    }

    fn variable(&self, reference: u32) -> Result<Named<'_>, Problem> {
        let variable = Self::variable(self, reference)?;
        Ok(Named {
            name: variable.name.into(),
            continuous_input: variable.body.is_some(),
            intermediate_update: fmi3::description::intermediate_update(variable),
        })
    }

    #[inline(always)]
    fn get(
        &mut self,
        bases: Bases,
        references: &[u32],
        write: impl FnMut(usize, f64),
    ) -> Result<(), Problem> {
        Self::get(self, bases, references, write)
    }

    #[inline(always)]
    fn set(&mut self, bases: Bases, references: &[u32], read: impl Fn(usize) -> f64) -> Result<(), Problem> {
        Self::set(self, bases, references, read)
    }

    fn set_input_derivatives(
        &mut self,
        references: &[u32],
        orders: &[i32],
        values: &[f64],
    ) -> Result<(), Problem> {
        Self::set_input_derivatives(self, references, orders, values)
    }

    fn output_derivatives(
        &mut self,
        references: &[u32],
        orders: &[i32],
        write: impl FnMut(usize, f64),
    ) -> Result<(), Problem> {
        Self::output_derivatives(self, references, orders, write)
    }

    fn directional_derivative(
        &mut self,
        unknowns: &[u32],
        knowns: &[u32],
        seed: &[f64],
        write: impl FnMut(usize, f64),
    ) -> Result<(), Problem> {
        Self::directional_derivative(self, unknowns, knowns, seed, write)
    }

    fn dependencies(&self, reference: u32) -> Result<Vec<Dependency>, Problem> {
        Self::dependencies(self, reference)
    }

    /// In Model Exchange events are the host's to find.
    fn next_event_time(&mut self) -> Option<f64> {
        if self.interface() == Interface::ModelExchange {
            return None;
        }
        let prediction = self.prediction();
        prediction.known.then_some(prediction.time)
    }

    fn number_of_event_indicators(&self) -> usize {
        EVENT_INDICATORS
    }

    fn set_continuous_states(&mut self, states: &[f64]) -> Result<(), Problem> {
        let states: &[f64; STATES.len()] =
            states.try_into().map_err(|_| Problem::sequence("there are six continuous states"))?;
        let w = states[1] - states[0];
        if self.is_extended() && w.abs() > REACH * self.settings().parameters.stop_gap {
            let allowed = "up to 10 times stop.gap, so that a solver can look beyond an impact";
            return Err(Problem::value("stop.s", w, allowed));
        }
        Self::set_continuous_states(self, states)
    }

    fn continuous_states(&self) -> Result<impl AsRef<[f64]>, Problem> {
        Self::continuous_states(self)
    }

    fn state_derivatives(&self) -> Result<impl AsRef<[f64]>, Problem> {
        Self::state_derivatives(self)
    }

    fn event_indicators(&self) -> Result<impl AsRef<[f64]>, Problem> {
        Self::event_indicators(self)
    }

    fn nominals(&self) -> impl AsRef<[f64]> {
        Self::nominals(self)
    }

    fn save(&self) -> Result<SavedState, Problem> {
        Ok(Self::save(self))
    }

    #[inline]
    fn restore(&mut self, saved: &SavedState) -> Result<(), Problem> {
        Self::restore(self, saved)
    }

    fn serialize(&self, saved: &SavedState) -> Result<Vec<u8>, Problem> {
        saved.serialize()
    }

    fn deserialize(&self, bytes: &[u8]) -> Result<SavedState, Problem> {
        SavedState::deserialize(bytes)
    }
}

impl Component for Instance {
    type Pieces = Pieces;

    const INTERMEDIATE_UPDATE: bool = true;

    fn set_experiment(
        &mut self,
        tolerance: Option<f64>,
        start: f64,
        stop: Option<f64>,
    ) -> Result<(), Problem> {
        Self::set_experiment(self, tolerance, start, stop)
    }

    fn enter_initialization(&mut self) {
        Self::enter_initialization(self);
    }

    /// In FMI 3.0 a closed form in Model Exchange is a mistake in the call, and not of a value.
    fn exit_initialization(&mut self, log: &mut dyn Log) -> Result<(), Problem> {
        let closed = self.settings().mode != SolutionMode::EventDriven;
        if closed && self.is_extended() && self.interface() == Interface::ModelExchange {
            let what = "mode must be 1 (EventDriven) in Model Exchange: a closed form has no derivatives to integrate";
            return Err(Problem::sequence(what));
        }
        Self::exit_initialization(self, log)
    }

    fn terminate(&mut self) {
        Self::terminate(self);
    }

    fn fail(&mut self) {
        Self::fail(self);
    }

    fn enter_event(&mut self) -> Result<(), Problem> {
        Self::enter_event(self)
    }

    fn handle_events(&mut self, log: &mut dyn Log) -> Result<Handled, Problem> {
        Self::handle_events(self, log)
    }

    fn leave_event(&mut self, log: &mut dyn Log) -> Result<(), Problem> {
        Self::leave_event(self, log)
    }

    #[inline]
    fn advance(&mut self, point: f64, size: f64, log: &mut dyn Log) -> Result<Advance, Problem> {
        Self::advance(self, point, size, log)
    }

    #[inline]
    fn step(&mut self, point: f64, size: f64, log: &mut dyn Log) -> Result<StepOutcome, Problem> {
        Self::step(self, point, size, log)
    }

    fn enter_continuous(&mut self) -> Result<(), Problem> {
        Self::enter_continuous(self);
        Ok(())
    }

    fn complete_integrator_step(&mut self) -> Result<bool, Problem> {
        Self::complete_integrator_step(self)
    }

    fn set_time(&mut self, time: f64) -> Result<(), Problem> {
        Self::set_time(self, time)
    }

    fn begin_pieces(&mut self, point: f64, size: f64) -> Result<Pieces, Problem> {
        Self::begin_pieces(self, point, size)
    }

    fn left(&self, pieces: &Pieces) -> f64 {
        Self::left(self, pieces)
    }

    fn interpolate_input(&mut self, reference: u32, values: [f64; 4], span: f64) {
        if let Ok(Some(body)) = Self::variable(self, reference).map(|variable| variable.body) {
            self.interpolate_load(body, values, span);
        }
    }

    fn hold_input(&mut self, reference: u32, value: f64) {
        if let Ok(Some(body)) = Self::variable(self, reference).map(|variable| variable.body) {
            self.hold_load(body, value);
        }
    }

    fn start_pieces(&mut self, pieces: &mut Pieces, log: &mut dyn Log) -> Result<Piece, Problem> {
        Self::start_pieces(self, pieces, log)
    }

    fn next_piece(
        &mut self,
        pieces: &mut Pieces,
        until: Option<f64>,
        log: &mut dyn Log,
    ) -> Result<Piece, Problem> {
        Self::next_piece(self, pieces, until, log)
    }

    fn ends_before_event(&self, pieces: &Pieces) -> bool {
        Self::ends_before_event(self, pieces)
    }

    fn pass_event(&mut self, pieces: &mut Pieces, log: &mut dyn Log) -> bool {
        Self::pass_event(self, pieces, log)
    }

    fn end_pieces(&mut self, pieces: &Pieces) -> Advance {
        Self::end_pieces(self, pieces)
    }

    fn take_pieces_back(&mut self, pieces: &Pieces) -> Result<(), Problem> {
        Self::take_pieces_back(self, pieces)
    }
}
