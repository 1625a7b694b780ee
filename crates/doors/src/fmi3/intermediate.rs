//! Intermediate update: a step calls the host's callback to request inputs during the step, and to
//! show outputs at events and at the end (FMI 3.0.2, 4.2.2).
//!
//! ```text
//! start ─ an input required? ─▶ values at 1/3, 2/3 and 3/3 of the step ─▶ cubic loads ─┐
//!   ┌──────────────────────────────────────────────────────────────────────────────────┘
//!   └▶ to the next event or the end ─ end ─▶ outputs shown ─▶ the step's end
//!             ▲          └─ event ─▶ outputs shown ─▶ law applied ─┐
//!             └────────────────────────────────────────────────────┘
//! ```

use super::instance::{FLOAT64, Instance, Update};
use super::problem::{CallProblem, Outcome};
use super::states::Function;
use crate::component::Component;
use crate::events::{Piece, StepOutcome};
use crate::hybrid::Pieces;
use crate::life::Phase;
use crate::log::Category;
use crate::messages::{Sink, Status};

/// The next action in a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Turn {
    /// Call the callback, then [`Instance::answered`].
    Ask(Update),
    /// The step is over.
    Done(StepOutcome),
}

/// A step in progress.
#[derive(Debug)]
pub struct Progress<C: Component> {
    pieces: Pieces<C>,
    /// Length, s.
    span: f64,
    begin: f64,
    /// Values of the required inputs at 0, 1/3, 2/3 and 3/3 of the step.
    inputs: Vec<[f64; 4]>,
    /// Purpose of the last call of the callback.
    asked: Asked,
    /// End of the step wanted by the host, s.
    until: Option<f64>,
}

/// Purpose of a call of the callback.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Asked {
    /// Inputs; the number counts the requests so far.
    Inputs(usize),
    /// Outputs before an event.
    Event,
    /// Outputs at the end.
    End,
}

impl<C: Component> Instance<C> {
    /// Registers `requiredIntermediateVariables` (FMI 3.0.2, 2.3.1).
    ///
    /// # Errors
    /// If no variable has the reference.
    pub fn require_intermediate_variables(
        &mut self,
        references: &[u32],
        has_callback: bool,
        sink: &mut dyn Sink,
    ) -> Outcome<C> {
        for &reference in references {
            let variable = self.common.component.variable(reference)?;
            if variable.continuous_input && has_callback && !self.required.contains(&reference) {
                self.required.push(reference);
            }
            if !variable.intermediate_update && self.enabled().contains(Category::Warnings) {
                let text = format!(
                    "fmi3InstantiateCoSimulation: {} is required for intermediate update, but has no intermediateUpdate = \
                     \"true\": it can be read there, not set",
                    variable.name
                );
                sink.send(Status::Warning, Category::Warnings, &text);
            }
        }
        Ok(())
    }

    /// Whether the host's callback is running.
    pub fn in_callback(&self) -> bool {
        self.update.is_some()
    }

    /// Checks that variables may be read now: not while inputs are requested.
    ///
    /// # Errors
    /// [`CallProblem::Intermediate`].
    #[inline]
    pub(super) fn check_get(&self) -> Outcome<C> {
        match self.update {
            Some(update) if update.set_requested => Err(CallProblem::Intermediate {
                what: "a variable is read".to_owned(),
                allowed: "only inputs can be set, since intermediateVariableGetAllowed is false",
            }),
            _ => Ok(()),
        }
    }

    /// Checks that these variables may be set now. Inside a step these are only the required
    /// inputs, while they are requested.
    ///
    /// # Errors
    /// [`CallProblem::Intermediate`]; if no variable has a reference.
    #[inline]
    pub(super) fn check_set(&self, references: &[u32]) -> Outcome<C> {
        match self.update {
            None => Ok(()),
            Some(update) => self.check_set_inside(references, update),
        }
    }

    #[cold]
    fn check_set_inside(&self, references: &[u32], update: Update) -> Outcome<C> {
        for &reference in references {
            let variable = self.component.variable(reference)?;
            if !(update.set_requested && self.required.contains(&reference)) {
                return Err(CallProblem::Intermediate {
                    what: format!("{} is set", variable.name),
                    allowed: "only inputs in requiredIntermediateVariables can be set, and only where \
                              intermediateVariableSetRequested is true",
                });
            }
        }
        Ok(())
    }

    /// `fmi3DoStep` with a callback: begins the step.
    ///
    /// # Errors
    /// As [`step_as_agreed`](Component::step_as_agreed); then nothing has changed.
    pub fn begin_step(
        &mut self,
        point: f64,
        size: f64,
        sink: &mut dyn Sink,
    ) -> Outcome<C, (Progress<C>, Turn)> {
        let pieces = Pieces::begin(&self.component, point, size)?;
        let mut progress = Progress {
            span: pieces.left(&self.component),
            begin: self.component.time(),
            inputs: vec![[0.0; 4]; self.required.len()],
            pieces,
            asked: Asked::Inputs(0),
            until: None,
        };
        let turn = if self.required.is_empty() {
            self.start(&mut progress, sink)?
        } else {
            self.read_inputs(&mut progress, 0)?;
            self.ask_inputs(&mut progress, 1)
        };
        Ok((progress, turn))
    }

    /// Reads the required inputs as set, and uses them as their values for all later times, the
    /// first of index `n`.
    fn read_inputs(&mut self, progress: &mut Progress<C>, n: usize) -> Outcome<C> {
        let inputs = &mut progress.inputs;
        Ok(self.common.component.get(FLOAT64, &self.required, |i, value| inputs[i][n..].fill(value))?)
    }

    /// Continues after the callback, with the time at which the host wants the step to end, if it
    /// requests one.
    ///
    /// # Errors
    /// As [`step_as_agreed`](Component::step_as_agreed), and if a call inside the callback was
    /// refused; the step has then been undone.
    pub fn answered(
        &mut self,
        progress: &mut Progress<C>,
        until: Option<f64>,
        sink: &mut dyn Sink,
    ) -> Outcome<C, Turn> {
        self.update = None;
        if self.component.life().phase == Phase::Terminated {
            progress.pieces.take_back(&mut self.component)?;
            return Err(CallProblem::Sequence {
                what: "a call inside the callback was refused: the step has been taken back",
            });
        }
        if let (Some(time), Asked::Event | Asked::End) = (until, progress.asked) {
            let now = self.component.time();
            let end = now + progress.pieces.left(&self.component);
            progress.until = Some(if time > now { time } else { now }).filter(|time| *time < end);
        }
        match progress.asked {
            Asked::Inputs(n) => {
                self.read_inputs(progress, n)?;
                if n < 3 {
                    return Ok(self.ask_inputs(progress, n + 1));
                }
                for (input, values) in self.required.iter().zip(&progress.inputs) {
                    progress.pieces.interpolate(&mut self.common.component, *input, *values);
                }
                self.start(progress, sink)
            }
            Asked::Event => {
                let mut log = self.log(sink, Function::DoStep.name());
                let ends = progress.pieces.pass_event(&mut self.component, &mut log);
                let here = progress.until.is_some_and(|until| until <= self.component.time());
                if ends || here { Ok(self.end_step(progress)) } else { self.go_on(progress, sink) }
            }
            Asked::End => Ok(self.end_step(progress)),
        }
    }

    fn ask(&mut self, time: f64, set_requested: bool) -> Turn {
        let can_return_early = !set_requested && self.component.life().handling.early_return;
        let update = Update { time, set_requested, can_return_early };
        self.update = Some(update);
        Turn::Ask(update)
    }

    fn ask_inputs(&mut self, progress: &mut Progress<C>, n: usize) -> Turn {
        progress.asked = Asked::Inputs(n);
        let part = if n == 3 { progress.span } else { progress.span * n as f64 / 3.0 };
        self.ask(progress.begin + part, true)
    }

    fn start(&mut self, progress: &mut Progress<C>, sink: &mut dyn Sink) -> Outcome<C, Turn> {
        let mut log = self.log(sink, Function::DoStep.name());
        match progress.pieces.start(&mut self.component, &mut log)? {
            Piece::Event => Ok(self.end_step(progress)),
            Piece::End => self.go_on(progress, sink),
        }
    }

    /// Advances to the next event or the end.
    fn go_on(&mut self, progress: &mut Progress<C>, sink: &mut dyn Sink) -> Outcome<C, Turn> {
        let mut log = self.log(sink, Function::DoStep.name());
        let piece = progress.pieces.next(&mut self.component, progress.until, &mut log)?;
        let event = piece == Piece::Event;
        if event && progress.pieces.ends_before_event() || !event && progress.until.is_some() {
            return Ok(self.end_step(progress));
        }
        progress.asked = if event { Asked::Event } else { Asked::End };
        Ok(self.ask(self.component.time(), false))
    }

    fn end_step(&mut self, progress: &Progress<C>) -> Turn {
        let outcome = progress.pieces.end(&mut self.component);
        for (input, values) in self.required.iter().zip(&progress.inputs).filter(|_| !outcome.early) {
            self.common.component.set_input(*input, [values[3], 0.0, 0.0, 0.0]);
        }
        Turn::Done(outcome)
    }

    /// Marks the instance after a panic in the callback.
    pub fn callback_failed(&mut self) {
        self.update = None;
    }
}
