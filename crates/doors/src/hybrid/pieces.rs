//! A step in pieces from event to event, for a host that reads outputs or sets inputs during the
//! step, or ends it early.

use super::steps::{is_early, shown};
use super::{AtEvent, Ended, Hybrid, Met, StepEnd, Until};
use crate::events::{Piece, StepOutcome};
use crate::life::Phase;
use crate::log::Log;
use crate::problem::Problem;

/// A step in progress.
#[derive(Debug)]
pub struct Pieces<H: Hybrid> {
    end: StepEnd,
    at_event: AtEvent,
    /// State before the step, used to undo it.
    before: H::State,
    undo: Option<H::Undo>,
    /// Values that change at events only, as shown at the start of the step; `None` if the host
    /// does not handle events.
    shown: Option<H::Shown>,
    /// Whether the law of an event is still to be applied, and the number of events so far.
    met: Met,
    /// The error of the law of an event; the step is then undone.
    failed: Option<H::Problem>,
}

impl<H: Hybrid> Pieces<H> {
    /// Begins a step with the behaviour of [`step_as_agreed`](crate::Component::step_as_agreed).
    ///
    /// # Errors
    /// As [`step_as_agreed`](crate::Component::step_as_agreed).
    pub fn begin(h: &H, point: f64, size: f64) -> Result<Self, H::Problem> {
        h.check(point, size)?;
        Ok(Self {
            end: StepEnd { point, size },
            at_event: AtEvent::of(h.life().handling, h.ends_at_events()),
            before: h.save()?,
            undo: None,
            shown: shown(h),
            met: Met::default(),
            failed: None,
        })
    }

    /// The time from here to the step's end, s.
    pub fn left(&self, h: &H) -> f64 {
        (self.end.value() - h.time()).max(0.0)
    }

    /// Lets an input follow the cubic through `values` at 0, 1/3, 2/3 and 3/3 of the way to the
    /// step's end.
    pub fn interpolate(&self, h: &mut H, reference: u32, values: [f64; 4]) {
        let polynomial = cubic(values, self.left(h), h.time());
        h.set_input(reference, polynomial);
    }

    /// Takes over the values that were set. If this causes an event and the host handles events,
    /// the step ends here.
    ///
    /// # Errors
    /// If a value that was set is not possible; then the step has been undone.
    pub fn start(&mut self, h: &mut H, log: &mut dyn Log) -> Result<Piece, H::Problem> {
        match h.take_over(self.end, log) {
            Err(problem) => Err(self.taken_back(h, problem)),
            Ok((undo, moved)) => {
                self.undo = Some(undo);
                self.met.events += usize::from(moved);
                h.taken_over();
                let ends = moved && self.ends_before_event();
                Ok(if ends { Piece::Event } else { Piece::End })
            }
        }
    }

    /// Advances to the next event, or to `until` (s; by default the end of the step) if there is
    /// no event before it.
    ///
    /// # Errors
    /// As [`step_as_agreed`](crate::Component::step_as_agreed); then the step has been undone.
    pub fn next(&mut self, h: &mut H, until: Option<f64>, log: &mut dyn Log) -> Result<Piece, H::Problem> {
        let end = until.map_or(self.end, |point| StepEnd { point, size: 0.0 });
        let met = match self.failed.take() {
            Some(problem) => Err(problem),
            None => h.run(end, Until::Event, log),
        };
        match met {
            Err(problem) => Err(self.taken_back(h, problem)),
            Ok(met) => {
                self.met.due = met.due;
                Ok(if met.due { Piece::Event } else { Piece::End })
            }
        }
    }

    /// Whether a step ends before the law of an event.
    pub fn ends_before_event(&self) -> bool {
        self.at_event == AtEvent::EndBefore
    }

    /// Applies the law of the event before which the last piece ended. Returns whether the step
    /// ends after it. If the law fails, the next piece returns the error.
    pub fn pass_event(&mut self, h: &mut H, log: &mut dyn Log) -> bool {
        self.failed = h.apply_law(log).err();
        self.met = Met { due: self.failed.is_some(), events: self.met.events + 1, ..self.met };
        if let Some(shown) = &self.shown {
            h.latch(Some(shown.clone()));
        }
        self.at_event == AtEvent::EndAfter
    }

    /// Ends the step at the present time.
    pub fn end(&self, h: &mut H) -> StepOutcome {
        let Met { due, events, .. } = self.met;
        let (event, early) = (self.shown.is_some() && (due || events > 0), is_early(h, self.end));
        h.life_mut().phase = Phase::Step;
        h.latch(self.shown.clone().filter(|_| event));
        h.end_step(Ended { event, due, stopped: false, interpolated: true });
        StepOutcome { time: h.time(), event, early }
    }

    /// Returns to the state before the step.
    ///
    /// # Errors
    /// As [`restore`](crate::Model::restore).
    pub fn take_back(&self, h: &mut H) -> Result<(), H::Problem> {
        h.restore(&self.before)
    }

    /// Undoes a step because of `problem`. Returns `problem`, or a problem that states that
    /// undoing failed.
    fn taken_back(&mut self, h: &mut H, problem: H::Problem) -> H::Problem {
        let problem = match self.undo.take() {
            Some(undo) => h.undo(undo, problem),
            None => problem,
        };
        match self.take_back(h) {
            Ok(()) => problem,
            Err(refused) => Problem::not_taken_back(&problem, &refused).into(),
        }
    }
}

/// Value and derivatives at 0 of the cubic through `values` at 0, 1/3, 2/3 and 3/3 of `span` s, at
/// a time of the motion.
fn cubic([u0, u1, u2, u3]: [f64; 4], span: f64, time: f64) -> [f64; 4] {
    // Newton's forward differences at the first value; three intervals in the span.
    let (first, second, third) = (u1 - u0, (u2 - u1) - (u1 - u0), (u3 - u2) - 2.0 * (u2 - u1) + (u1 - u0));
    let rate = 3.0 / span;
    let slopes = [first - 0.5 * second + third / 3.0, second - third, third];
    let scale = [rate, rate * rate, rate * rate * rate];
    let polynomial = [u0, slopes[0] * scale[0], slopes[1] * scale[1], slopes[2] * scale[2]];
    // In a step as short as the rounding of times, the differences have no meaning.
    let says = span > f64::EPSILON * time.abs().max(1.0) && polynomial.iter().all(|x| x.is_finite());
    if says { polynomial } else { [u0, 0.0, 0.0, 0.0] }
}

#[cfg(test)]
mod tests {
    use super::cubic;

    #[test]
    fn closed_form_derivatives_of_a_cubic() {
        // 1 - 2 t + 3 t² - 4 t³ over 3 s; all numbers are exact.
        let values = [0.0, 1.0, 2.0, 3.0].map(|t: f64| 1.0 - 2.0 * t + 3.0 * t * t - 4.0 * t * t * t);
        assert_eq!(cubic(values, 3.0, 0.0), [1.0, -2.0, 6.0, -24.0]);
        assert_eq!(cubic(values, 1e-17, 0.0), [1.0, 0.0, 0.0, 0.0]);
    }
}
