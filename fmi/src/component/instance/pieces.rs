//! A step in pieces from event to event, for a host that looks into it, sets inputs for its course,
//! or ends it early.

use super::advance::{AtEvent, side_of};
use super::arrival::{advance, is_at_end, rounding, take_back};
use super::events::{Changes, describe, report_contact};
use super::last_step::LastStep;
use super::{Engine, Instance, Outcome, Phase, Problem, SavedState};
use crate::component::event_state::Discrete;
use crate::component::log::{Category, Log};
use fmi_doors::{Advance, Piece};
use vibro_impact::numerics::double_double::DoubleDouble;
use vibro_impact::simulator::{AdvanceOutcome, Contact, Event, EventObserver, Pause};

/// A step in progress.
#[derive(Debug)]
pub struct Pieces {
    end: DoubleDouble,
    end_value: f64,
    at_event: AtEvent,
    /// What was shown of the discrete outputs at the step's start.
    shown: Discrete,
    contact: Contact,
    /// Events met so far, and the stop of the last one that was an impact.
    events: usize,
    side: i8,
    /// To take the step back.
    before: SavedState,
}

impl Instance {
    /// Begins a step as [`advance`](Self::advance) would make it.
    ///
    /// # Errors
    /// As [`advance`](Self::advance); nothing has changed then.
    pub fn begin_pieces(&mut self, point: f64, size: f64) -> Outcome<Pieces> {
        self.check_advance(point, size)?;
        let (shown, contact) = match &self.engine {
            Engine::Simulation(simulator) => (Discrete::of_simulator(simulator), simulator.contact()),
            Engine::Closed(form) => (Discrete::of(&form.values()), Contact::Flight),
            Engine::None | Engine::Continuous(_) => {
                return Err(Problem::sequence("there is nothing to step"));
            }
        };
        Ok(Pieces {
            end: DoubleDouble::sum(point, size),
            end_value: point + size,
            at_event: self.at_event(),
            shown,
            contact,
            events: 0,
            side: 0,
            before: self.save(),
        })
    }

    /// The time from here to the step's end, s.
    pub fn left(&self, pieces: &Pieces) -> f64 {
        (pieces.end_value - self.time()).max(0.0)
    }

    /// The load on a body as it is set, N.
    pub fn load(&self, body: usize) -> f64 {
        self.settings.loads.derivatives[body][0]
    }

    /// Lets the load on a body follow the cubic through `values` at 0, 1/3, 2/3 and 3/3 of the next
    /// `span` s.
    pub fn interpolate_load(&mut self, body: usize, values: [f64; 4], span: f64) {
        let [u0, u1, u2, u3] = values;
        let (first, second, third) =
            (u1 - u0, (u2 - u1) - (u1 - u0), (u3 - u2) - 2.0 * (u2 - u1) + (u1 - u0));
        // Newton's forward differences at the first value; three intervals to the span.
        let rate = 3.0 / span;
        // In a step of the length of rounding they say nothing.
        let resolved = span > f64::EPSILON * self.time().abs().max(1.0);
        let slopes = [first - 0.5 * second + third / 3.0, second - third, third];
        let scale = if resolved { [rate, rate * rate, rate * rate * rate] } else { [0.0; 3] };
        let load = &mut self.settings.loads.derivatives[body];
        *load = [u0, slopes[0] * scale[0], slopes[1] * scale[1], slopes[2] * scale[2]];
        self.loads_set = true;
    }

    /// Lets the load on a body hold a value from here on.
    pub fn hold_load(&mut self, body: usize, value: f64) {
        self.settings.loads.derivatives[body] = [value, 0.0, 0.0, 0.0];
        self.loads_set = true;
    }

    /// Takes the loads as they have become on their polynomials.
    pub(super) fn carry_loads(&mut self) {
        let Engine::Simulation(simulator) = &self.engine else { return };
        let slopes = self.settings.loads.derivatives.iter().flat_map(|load| &load[1..]);
        if slopes.into_iter().any(|slope| *slope != 0.0) {
            self.settings.loads = simulator.loads();
        }
    }

    /// Lets each load that has followed a polynomial through a step hold from its end on the value
    /// that it has there.
    pub(super) fn hold_loads(&mut self) {
        let Engine::Simulation(simulator) = &self.engine else { return };
        for body in 0..3 {
            if self.settings.loads.derivatives[body][1..] != [0.0; 3] {
                self.settings.loads.derivatives[body] =
                    [simulator.loads().derivatives[body][0], 0.0, 0.0, 0.0];
                self.loads_set = true;
            }
        }
    }

    /// Takes over what was set; where that has changed the contact, the step of a host that handles
    /// events ends here.
    ///
    /// # Errors
    /// For what is not possible; the step has been taken back then.
    pub fn start_pieces(&mut self, pieces: &mut Pieces, log: &mut dyn Log) -> Outcome<Piece> {
        if let Err(problem) = self.take_over() {
            return Err(self.take_back_for(pieces, problem));
        }
        let wanted = log.wants(Category::Events);
        let mut show = |event: &Event| log.log(Category::Events, &describe(event));
        let report: EventObserver = if wanted { Some(&mut show) } else { None };
        let moved = match &self.engine {
            Engine::Simulation(simulator) => report_contact(pieces.contact, simulator, report),
            _ => false,
        };
        pieces.events = usize::from(moved);
        Ok(if moved && pieces.at_event == AtEvent::EndBefore { Piece::Event } else { Piece::End })
    }

    fn take_over(&mut self) -> Outcome {
        match &mut self.engine {
            Engine::Simulation(simulator) => {
                if self.parameters_set {
                    simulator.set_parameters(&self.settings.parameters)?;
                }
                let loads = &mut self.settings.loads;
                if self.loads_set && simulator.set_loads(loads).is_err() {
                    // In a step so short that slopes are out of all proportion, the loads are held.
                    loads.derivatives.iter_mut().for_each(|load| load[1..].fill(0.0));
                    simulator.set_loads(loads)?;
                }
            }
            Engine::Closed(form) if self.parameters_set => form.set_parameters(&self.settings.parameters)?,
            _ => {}
        }
        (self.parameters_set, self.loads_set) = (false, false);
        if let Engine::Simulation(simulator) = &self.engine {
            LastStep::begin(&mut self.last_step, simulator, &Changes::default());
        }
        self.invalidate();
        Ok(())
    }

    /// To the next event, or to `until` (s; the step's end without it) if none comes before.
    ///
    /// # Errors
    /// As [`advance`](Self::advance); the step has been taken back then.
    pub fn next_piece(
        &mut self,
        pieces: &mut Pieces,
        until: Option<f64>,
        log: &mut dyn Log,
    ) -> Outcome<Piece> {
        let wanted = log.wants(Category::Events);
        let mut show = |event: &Event| log.log(Category::Events, &describe(event));
        let report: EventObserver = if wanted { Some(&mut show) } else { None };
        let end = until.map_or(pieces.end, DoubleDouble::new);
        let late = rounding(end.value());
        let outcome = match &mut self.engine {
            Engine::Simulation(simulator) => {
                let before = simulator.snapshot();
                advance(simulator, end, Pause::BeforeEvent, report)
                    .map(|reached| reached == AdvanceOutcome::EventDue)
                    .and_then(|due| Ok(due || until.is_none() && is_at_end(simulator, pieces.end_value)?))
                    .map_err(|error| take_back(simulator, &before, error))
            }
            Engine::Closed(form) => form.advance_before_event(end.hi, end.lo, late),
            Engine::None | Engine::Continuous(_) => Ok(false),
        };
        self.invalidate();
        match outcome {
            Ok(due) => Ok(if due { Piece::Event } else { Piece::End }),
            Err(problem) => Err(self.take_back_for(pieces, problem)),
        }
    }

    /// Whether the step ends at an event, and is to be left there before its law.
    pub fn ends_before_event(&self, pieces: &Pieces) -> bool {
        pieces.at_event == AtEvent::EndBefore
    }

    /// Applies the law of the event before which the last piece has ended; true where the step ends
    /// after it.
    pub fn pass_event(&mut self, pieces: &mut Pieces, log: &mut dyn Log) -> bool {
        let wanted = log.wants(Category::Events);
        let mut side = pieces.side;
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
        pieces.side = side;
        pieces.events += 1;
        if pieces.at_event == AtEvent::Latch {
            self.events.latched = Some(pieces.shown);
        }
        self.invalidate();
        pieces.at_event == AtEvent::EndAfter
    }

    /// Ends the step where it stands. The loads hold their present values from here on.
    pub fn end_pieces(&mut self, pieces: &Pieces) -> Advance {
        let time = self.time();
        let due = match &self.engine {
            Engine::Simulation(simulator) => simulator.due_event().is_some(),
            Engine::Closed(form) => form.is_due(),
            Engine::None | Engine::Continuous(_) => false,
        };
        let event = self.life.handling.event_mode && (due || pieces.events > 0);
        let early = pieces.end_value - time > rounding(pieces.end_value);
        self.hold_loads();
        self.life.phase = Phase::Step;
        self.events.pending = event;
        self.events.latched = event.then_some(pieces.shown);
        self.events.side = if event && !due { pieces.side } else { 0 };
        self.slopes_set = [false; 3];
        self.invalidate();
        Advance { time, event, early }
    }

    /// As before [`begin_pieces`](Self::begin_pieces).
    ///
    /// # Errors
    /// As [`restore`](Self::restore).
    pub fn take_pieces_back(&mut self, pieces: &Pieces) -> Outcome {
        self.restore(&pieces.before)
    }

    /// Takes a step back that has met a problem; the problem, or that the step could not be taken
    /// back.
    fn take_back_for(&mut self, pieces: &Pieces, problem: Problem) -> Problem {
        match self.take_pieces_back(pieces) {
            Ok(()) => problem,
            Err(refused) => {
                Problem::NotTakenBack { cause: problem.to_string(), refused: refused.to_string() }
            }
        }
    }
}
