//! The current motion, and the numbers for drawing it.

use crate::set::Set;
use vibro_impact::simulator::{AdvanceOutcome, Event, Pause, Simulator};
use vibro_impact::{Parameters, Result, State};
use vibro_studies::MotionClass;
use vibro_studies::paper::trajectories::Start;
use vibro_studies::paper::verdict::verdict;
use wasm_bindgen::prelude::*;

/// Length of a row of [`Machine::record`]: time, x1, x2, x3, v1, v2, v3, w, w', drive phase, and
/// the kind of the instant.
pub const ROW: usize = 11;

/// Kinds of an instant, the last number of a row: ordinary (`PLAIN`), just before an impact
/// (`BEFORE`), just after it (`AFTER`).
const PLAIN: f64 = 0.0;
const BEFORE: f64 = 1.0;
const AFTER: f64 = 2.0;

/// A motion of the machine.
#[wasm_bindgen]
#[derive(Clone, Debug)]
pub struct Machine {
    simulator: Simulator,
    /// Events since the last call of `take_events`: kind (0 impact, 1 rest, 2 release), time,
    /// side, speed, impulse.
    events: Vec<f64>,
}

/// State from the six numbers x1, x2, x3, v1, v2, v3 in SI units.
pub(crate) fn state_of(numbers: &[f64]) -> State {
    let at = |i: usize| numbers.get(i).copied().unwrap_or(0.0);
    State { x: [at(0), at(1), at(2)], v: [at(3), at(4), at(5)] }
}

#[wasm_bindgen]
impl Machine {
    /// Starts at time 0 from x1, x2, x3 (m), v1, v2, v3 (m/s).
    ///
    /// # Errors
    /// An error if the simulator refuses the parameters or the state.
    #[wasm_bindgen(constructor)]
    pub fn new(set: &Set, start: &[f64]) -> std::result::Result<Machine, JsError> {
        let simulator = Simulator::new(set.0.parameters(), &state_of(start), 0.0)?;
        Ok(Self { simulator, events: Vec::new() })
    }

    /// Changes the parameters during the motion. The drive's phase stays continuous.
    ///
    /// # Errors
    /// An error if the simulator refuses the parameters at the present state; the motion is then
    /// unchanged.
    pub fn set_parameters(&mut self, set: &Set) -> std::result::Result<(), JsError> {
        Ok(self.simulator.set_parameters(set.0.parameters())?)
    }

    /// A copy of this motion, advanced by `periods` drive periods, without energy accounts.
    ///
    /// # Errors
    /// An error of the simulator.
    pub fn settled(&self, periods: f64) -> std::result::Result<Machine, JsError> {
        let mut simulator = self.simulator.clone().without_energy_accounts();
        simulator.advance_to(simulator.time() + periods * simulator.parameters().period())?;
        Ok(Self { simulator, events: Vec::new() })
    }

    /// Time, x1, x2, x3, v1, v2, v3, w, w', drive phase, 0; then the stop at which the block rests
    /// (0 in flight), the contact force, the energy accounts (mechanical, input, damped, lost at
    /// impacts) and the impacts at the upper and lower stop.
    pub fn now(&self) -> Vec<f64> {
        let (simulator, mut row) = (&self.simulator, Vec::with_capacity(ROW + 8));
        push(&mut row, simulator, PLAIN, None);
        let accounts = simulator.energy_accounts();
        row.extend([simulator.contact().side(), simulator.contact_force()]);
        row.extend([accounts.mechanical, accounts.input, accounts.damped, accounts.impact]);
        row.extend([simulator.impacts().upper as f64, simulator.impacts().lower as f64]);
        row
    }

    /// Advances to `end` (s) and returns rows of [`ROW`] numbers: `count` equally spaced instants,
    /// the last at `end`, and two rows for each impact, just before and just after it.
    ///
    /// # Errors
    /// An error of the simulator; the motion then stays where the simulator stopped.
    pub fn record(&mut self, end: f64, count: u32) -> std::result::Result<Vec<f64>, JsError> {
        let begin = self.simulator.time();
        let mut rows = Vec::with_capacity(ROW * (count as usize + 16));
        for i in 1..=count {
            let share = f64::from(i) / f64::from(count);
            let next = if i == count { end } else { begin + (end - begin) * share };
            while self.piece(next, &mut rows)? == AdvanceOutcome::Impact {}
            push(&mut rows, &self.simulator, PLAIN, None);
        }
        Ok(rows)
    }

    /// Advances to just after the next impact, or to `end` (s) if there is none before. Returns
    /// the rows of the impact.
    ///
    /// # Errors
    /// An error of the simulator.
    pub fn to_impact(&mut self, end: f64) -> std::result::Result<Vec<f64>, JsError> {
        let mut rows = Vec::new();
        self.piece(end, &mut rows)?;
        Ok(rows)
    }

    /// The events since the last call, five numbers each: kind (0 impact, 1 rest, 2 release),
    /// time, side (1 or -1), approach speed, impulse.
    pub fn take_events(&mut self) -> Vec<f64> {
        std::mem::take(&mut self.events)
    }

    /// `count` points of the stroboscopic Poincaré section at drive phase 0, four numbers each: w,
    /// w', x1, v1.
    ///
    /// # Errors
    /// An error of the simulator.
    pub fn strobe(&mut self, count: u32) -> std::result::Result<Vec<f64>, JsError> {
        let (omega, length) =
            (self.simulator.parameters().drive_frequency, self.simulator.parameters().period());
        let mut points = Vec::with_capacity(4 * count as usize);
        // The next instant with phase 0. A phase that differs from 0 only by rounding counts as 0.
        let ahead = (-self.simulator.drive_phase()).rem_euclid(std::f64::consts::TAU);
        let first = if ahead > std::f64::consts::TAU - 1e-9 { 0.0 } else { ahead / omega };
        let begin = self.simulator.time() + first;
        for i in 0..count {
            self.simulator.advance_to(begin + f64::from(i) * length)?;
            let ((w, rate), state) = (self.simulator.relative_motion(), self.simulator.state());
            points.extend([w, rate, state.x[0], state.v[0]]);
        }
        Ok(points)
    }

    /// Points of the Poincaré section at impacts, over `periods` drive periods, four numbers each:
    /// drive phase, side times approach speed, and x1, v1 after the impact.
    ///
    /// # Errors
    /// An error of the simulator.
    pub fn impacts(&mut self, periods: u32) -> std::result::Result<Vec<f64>, JsError> {
        let end = self.simulator.time() + f64::from(periods) * self.simulator.parameters().period();
        let mut points = Vec::new();
        loop {
            let mut hit = None;
            let reason = self.simulator.advance_until(
                end,
                Pause::AfterImpact,
                Some(&mut |event: &Event| {
                    if let Event::Impact { side, speed, .. } = *event {
                        hit = Some(f64::from(side) * speed);
                    }
                }),
            )?;
            let Some(speed) = hit.filter(|_| reason == AdvanceOutcome::Impact) else { return Ok(points) };
            let state = self.simulator.state();
            points.extend([self.simulator.drive_phase(), speed, state.x[0], state.v[0]]);
        }
    }

    /// The class of the settled motion, nine numbers: its period in drive periods (0 if there is
    /// none up to 32); impacts per period at the upper and at the lower stop; 1 if it is its own
    /// mirror image; 1 if the block rests; 1 if it is still settling; 1 if it is chaotic; the
    /// largest Lyapunov exponent per unit of the dimensionless time (NaN if it has a period); 1 if
    /// its class is undecided. The motion of this object is not advanced.
    ///
    /// # Errors
    /// An error of the simulator.
    pub fn class(&self) -> std::result::Result<Vec<f64>, JsError> {
        let p = self.simulator.parameters();
        // The motion for the verdict starts at time 0 with the present drive phase.
        let parameters = Parameters { drive_phase: self.simulator.drive_phase(), ..*p };
        let verdict = verdict(&Start { parameters, state: self.simulator.state() }, 0)?;
        let (found, class) = (&verdict.attractor, verdict.class);
        let [symmetric, rests, settling, chaotic, undecided] = [
            found.is_symmetric(),
            found.rests,
            class == MotionClass::Settling,
            class == MotionClass::Chaotic,
            class == MotionClass::NotSettled,
        ]
        .map(|holds| f64::from(u8::from(holds)));
        let period = f64::from(found.period.unwrap_or(0));
        let largest = verdict.exponent.map_or(f64::NAN, |e| (e.value / p.box_frequency()).max(0.0));
        let [up, low] = found.impacts;
        Ok(vec![period, up, low, symmetric, rests, settling, chaotic, largest, undecided])
    }

    /// A copy, which the page frees separately.
    pub fn copy(&self) -> Machine {
        self.clone()
    }
}

impl Machine {
    /// Advances to `end` or to just after the next impact, and records the events and both sides
    /// of the impact.
    fn piece(&mut self, end: f64, rows: &mut Vec<f64>) -> Result<AdvanceOutcome> {
        let (events, mut push_back) = (&mut self.events, None);
        let outcome = self.simulator.advance_until(
            end,
            Pause::AfterImpact,
            Some(&mut |event: &Event| match *event {
                Event::Impact { time, side, speed, impulse } => {
                    push_back = Some((f64::from(side), impulse));
                    events.extend([0.0, time, f64::from(side), speed, impulse]);
                }
                Event::Rest { time, side } => events.extend([1.0, time, f64::from(side), 0.0, 0.0]),
                Event::Release { time, side } => events.extend([2.0, time, f64::from(side), 0.0, 0.0]),
            }),
        )?;
        if let (AdvanceOutcome::Impact, Some(impact)) = (outcome, push_back) {
            push(rows, &self.simulator, BEFORE, Some(impact));
            push(rows, &self.simulator, AFTER, None);
        }
        Ok(outcome)
    }
}

/// Appends a row: the present state or, if `impact` has the stop's side and the impulse, the left
/// limit at this impact, docs/theory.md (11).
fn push(rows: &mut Vec<f64>, simulator: &Simulator, what: f64, impact: Option<(f64, f64)>) {
    let (parameters, mut state) = (simulator.parameters(), simulator.state());
    let (w, mut rate) = simulator.relative_motion();
    if let Some((side, impulse)) = impact {
        state.v[0] -= side * impulse / parameters.box_mass;
        state.v[1] += side * impulse / parameters.block_mass;
        rate = state.v[1] - state.v[0];
    }
    let (x, v) = (state.x, state.v);
    rows.extend([
        simulator.time(),
        x[0],
        x[1],
        x[2],
        v[0],
        v[1],
        v[2],
        w,
        rate,
        simulator.drive_phase(),
        what,
    ]);
}
