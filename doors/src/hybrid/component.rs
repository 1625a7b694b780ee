//! Every [`Hybrid`] is a [`Component`].

use super::steps::{self, Pieces};
use super::{AtEvent, Hybrid};
use crate::component::Component;
use crate::events::{Advance, Handled, Piece, StepOutcome, StepReason};
use crate::life::{Interface, Phase};
use crate::log::Log;
use crate::problem::Problem;

impl<H: Hybrid> Component for H {
    type Pieces = Pieces<H>;

    const INTERMEDIATE_UPDATE: bool = true;

    fn enter_initialization(&mut self) {
        self.life_mut().phase = Phase::Initialization;
        self.forget();
    }

    fn exit_initialization(&mut self, log: &mut dyn Log) -> Result<(), H::Problem> {
        self.start(log)?;
        self.life_mut().begin();
        if self.life().phase == Phase::Event {
            self.begin_event();
        }
        Ok(())
    }

    fn terminate(&mut self) {
        self.end(false);
        self.life_mut().phase = Phase::Terminated;
    }

    fn fail(&mut self) {
        self.end(true);
        self.life_mut().phase = Phase::Terminated;
    }

    fn enter_event(&mut self) -> Result<(), H::Problem> {
        if self.life().interface == Interface::ModelExchange {
            self.accept()?;
        }
        self.life_mut().phase = Phase::Event;
        self.begin_event();
        Ok(())
    }

    fn handle_events(&mut self, log: &mut dyn Log) -> Result<Handled, H::Problem> {
        self.carry_out(log)
    }

    fn leave_event(&mut self, log: &mut dyn Log) -> Result<(), H::Problem> {
        self.go_on(Some(log))?;
        self.life_mut().go_on();
        Ok(())
    }

    #[inline]
    fn advance(&mut self, point: f64, size: f64, log: &mut dyn Log) -> Result<Advance, H::Problem> {
        let at_event = AtEvent::of(self.life().handling, self.ends_at_events());
        steps::advance(self, (point, size), at_event, log)
    }

    #[inline]
    fn step(&mut self, point: f64, size: f64, log: &mut dyn Log) -> Result<StepOutcome, H::Problem> {
        let at_event = if self.ends_at_events() { AtEvent::EndAfter } else { AtEvent::Pass };
        let Advance { time, early, .. } = steps::advance(self, (point, size), at_event, log)?;
        if early {
            self.life_mut().phase = Phase::StoppedEarly;
        }
        Ok(StepOutcome { time, reason: if early { StepReason::Stopped } else { StepReason::EndReached } })
    }

    fn enter_continuous(&mut self) -> Result<(), H::Problem> {
        self.go_on(None)?;
        self.life_mut().phase = Phase::Continuous;
        Ok(())
    }

    fn complete_integrator_step(&mut self) -> Result<bool, H::Problem> {
        self.accept()
    }

    /// At an event only to the present time, as some hosts do.
    fn set_time(&mut self, time: f64) -> Result<(), H::Problem> {
        let refuse = |allowed| Err(Problem::value("time", time, allowed).into());
        if !time.is_finite() {
            return refuse("a finite number");
        }
        if self.life().phase == Phase::Event && time != self.time() {
            return refuse("the present time in Event Mode");
        }
        self.put_time(time)
    }

    fn begin_pieces(&mut self, point: f64, size: f64) -> Result<Pieces<H>, H::Problem> {
        Pieces::begin(self, point, size)
    }

    fn left(&self, pieces: &Pieces<H>) -> f64 {
        (pieces.end.value() - self.time()).max(0.0)
    }

    fn interpolate_input(&mut self, reference: u32, values: [f64; 4], span: f64) {
        self.set_input(reference, steps::cubic(values, span, self.time()));
    }

    fn hold_input(&mut self, reference: u32, value: f64) {
        self.set_input(reference, [value, 0.0, 0.0, 0.0]);
    }

    fn start_pieces(&mut self, pieces: &mut Pieces<H>, log: &mut dyn Log) -> Result<Piece, H::Problem> {
        pieces.start(self, log)
    }

    fn next_piece(
        &mut self,
        pieces: &mut Pieces<H>,
        until: Option<f64>,
        log: &mut dyn Log,
    ) -> Result<Piece, H::Problem> {
        pieces.next(self, until, log)
    }

    fn ends_before_event(&self, pieces: &Pieces<H>) -> bool {
        pieces.at_event == AtEvent::EndBefore
    }

    fn pass_event(&mut self, pieces: &mut Pieces<H>, log: &mut dyn Log) -> bool {
        pieces.pass_event(self, log)
    }

    fn end_pieces(&mut self, pieces: &Pieces<H>) -> Advance {
        pieces.end(self)
    }

    fn take_pieces_back(&mut self, pieces: &Pieces<H>) -> Result<(), H::Problem> {
        self.restore(&pieces.before)
    }
}
