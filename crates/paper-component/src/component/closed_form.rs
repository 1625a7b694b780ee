//! A steady state played in time: clock, drive phase, and the impacts and energies that a
//! simulation would count.

use super::problem::ComponentProblem;
use super::settings::SolutionMode;
use super::steady::{ORDERS, Solution};
use super::values::{Approach, OutputValues, coupling_force};
use serde::{Deserialize, Serialize};
use std::f64::consts::{PI, TAU};
use vibro_impact::energy::{self, FIVE};
use vibro_impact::error::Error;
use vibro_impact::model::{Impact, Model};
use vibro_impact::parameters::Parameters;
use vibro_impact::simulator::{
    AdvanceOutcome, Contact, Event, EventObserver, ImpactRecord, State, check_time,
};
use vibro_numerics::double_double::DoubleDouble;
use vibro_numerics::drive_phase::DrivePhase;

/// Largest length of a piece of the energies' quadrature, times the fastest rate. Five Gauss nodes
/// on such a piece have a relative error below 1e-12.
const PIECE: f64 = 0.5;
/// Largest number of pieces in half a period. Only modes more than 650 times faster than the drive
/// would need more.
const MAX_PIECES: f64 = 4096.0;

/// Cap on the impacts that one step reports. A closed form passes over any number of impacts in
/// one step, and the log must stay bounded.
pub(crate) const MOST_REPORTED: f64 = 1000.0;

/// Rounding of a drive phase, relative to itself: a few units in the last place from time,
/// frequency and offset.
const PHASE_ROUNDING: f64 = 8.0 * f64::EPSILON;

/// Largest rounding error of an angle since the last impact, rad.
fn phase_rounding(angle: f64) -> f64 {
    PHASE_ROUNDING * (angle.abs() + TAU)
}

/// Data that change in time; the solution follows from them.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Data {
    mode: SolutionMode,
    parameters: Parameters,
    time: DoubleDouble,
    phase: DrivePhase,
    /// Start time of the solution. The next four fields hold the impacts and energies up to this
    /// time.
    from: DoubleDouble,
    record: ImpactRecord,
    input: f64,
    damped: f64,
    impact: f64,
    limit: Limit,
}

impl Data {
    /// Refuses times and phases that no motion can have and at which impacts could not be counted.
    /// Only a damaged saved state has such values.
    ///
    /// # Errors
    /// [`PrecisionLost`](Error::PrecisionLost) for a time, [`OutOfRange`](Error::OutOfRange) for a
    /// phase.
    fn check(&self) -> Result<(), Error> {
        check_time(self.parameters.drive_frequency, self.time.value())?;
        check_time(self.parameters.drive_frequency, self.from.value())?;
        if self.phase.is_sound() {
            return Ok(());
        }
        Err(Error::OutOfRange {
            name: "saved state",
            value: f64::NAN,
            allowed: "a phase of less than one turn",
        })
    }
}

/// One-sided limit that is shown at an impact.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
enum Limit {
    /// The side that follows from the rounded time, which is not known to be the time of an
    /// impact.
    #[default]
    Any,
    /// The limit before the impact that is due now; this impact is not counted yet.
    Before,
    /// The limit after the impact.
    After,
}

/// A steady state that is played in time.
#[derive(Clone, Debug)]
pub(crate) struct ClosedForm {
    data: Data,
    solution: Solution,
    /// Relative speed and impulse of each impact, and the energy lost in it.
    speed: f64,
    impulse: f64,
    lost: f64,
    /// Drive phase since the last upper impact when the solution began to apply, in [0, 2π).
    offset: f64,
    /// Input and damped energy from an impact to each knot of the following half period.
    knots: Vec<[f64; 2]>,
}

impl ClosedForm {
    /// Starts at `time`.
    ///
    /// # Errors
    /// As [`Solution::new`].
    pub(crate) fn new(
        mode: SolutionMode,
        parameters: &Parameters,
        time: f64,
    ) -> Result<Self, ComponentProblem> {
        let time = DoubleDouble::new(time);
        Self::of(Data {
            mode,
            parameters: *parameters,
            time,
            phase: DrivePhase::new(parameters.drive_phase),
            from: time,
            record: ImpactRecord::default(),
            input: 0.0,
            damped: 0.0,
            impact: 0.0,
            limit: Limit::Any,
        })
    }

    /// The motion of given [`data`](Self::data); its solution is bitwise equal to the original.
    ///
    /// # Errors
    /// As [`Solution::new`].
    pub(crate) fn of(data: Data) -> Result<Self, ComponentProblem> {
        let p = &data.parameters;
        data.check()?;
        let solution = Solution::new(data.mode, p)?;
        let model = Model::new(p)?;
        let Impact { speed, impulse, lost } = solution.impact(&model);
        let theta = data.phase.angle(p.drive_frequency, data.from);
        let mut form = Self {
            data,
            speed,
            impulse,
            lost,
            offset: (theta - solution.impact_phase()).rem_euclid(TAU),
            knots: Vec::new(),
            solution,
        };
        form.fill_knots(model.rate);
        Ok(form)
    }

    /// Returns to given [`data`](Self::data). Solves again only if mode, parameters, beginning or
    /// drive phase differ.
    ///
    /// # Errors
    /// As [`Solution::new`]; then nothing has changed.
    pub(crate) fn restore(&mut self, data: Data) -> Result<(), ComponentProblem> {
        let same = data.mode == self.data.mode
            && data.parameters == self.data.parameters
            && data.from == self.data.from
            && data.phase == self.data.phase;
        if same {
            data.check()?;
            self.data = data;
        } else {
            *self = Self::of(data)?;
        }
        Ok(())
    }

    pub(crate) fn data(&self) -> Data {
        self.data
    }

    pub(crate) fn solution(&self) -> &Solution {
        &self.solution
    }

    pub(crate) fn parameters(&self) -> &Parameters {
        &self.data.parameters
    }

    pub(crate) fn time(&self) -> f64 {
        self.data.time.value()
    }

    /// Changes to the steady state of other parameters at the present time. The drive's phase
    /// stays continuous.
    ///
    /// # Errors
    /// As [`Solution::new`]; then nothing has changed.
    pub(crate) fn set_parameters(&mut self, parameters: &Parameters) -> Result<(), ComponentProblem> {
        let old = self.data.parameters;
        if *parameters == old {
            return Ok(());
        }
        let now = self.values();
        let mut phase = self.data.phase;
        phase.rebase(old.drive_frequency, self.data.time, (old.drive_phase, parameters.drive_phase));
        let mut next = Self::of(Data {
            mode: self.data.mode,
            parameters: *parameters,
            time: self.data.time,
            phase,
            from: self.data.time,
            record: now.impacts,
            input: now.input,
            damped: now.damped,
            impact: now.impact_loss,
            limit: Limit::Any,
        })?;
        // The jump to another steady state is work from outside.
        next.data.input += next.values().mechanical - now.mechanical;
        *self = next;
        Ok(())
    }

    /// Advances to `begin + step`, or optionally only to the first impact. Reports at most
    /// [`MOST_REPORTED`] impacts, and also returns the number of impacts not reported.
    ///
    /// # Errors
    /// [`PrecisionLost`](vibro_impact::Error::PrecisionLost) for a time at which a double cannot
    /// distinguish two moments of the motion.
    pub(crate) fn advance(
        &mut self,
        begin: f64,
        step: f64,
        stop_at_impact: bool,
        observer: EventObserver<'_, '_>,
    ) -> Result<(AdvanceOutcome, f64), ComponentProblem> {
        let end = DoubleDouble::sum(begin, step);
        check_time(self.data.parameters.drive_frequency, end.value())?;
        if end.minus(self.data.time).value() <= 0.0 {
            return Ok((AdvanceOutcome::End, 0.0));
        }
        let before = self.halves(self.data.time).0;
        let after = self.halves(end).0;
        self.data.limit = Limit::Any;
        if stop_at_impact && after > before {
            self.data.time = self.impact_time(before + 1.0);
            if let Some(report) = observer {
                report(&self.event(before + 1.0));
            }
            return Ok((AdvanceOutcome::Impact, 0.0));
        }
        self.data.time = end;
        if let Some(report) = observer {
            let last = after.min(before + MOST_REPORTED);
            let mut n = before + 1.0;
            while n <= last {
                report(&self.event(n));
                n += 1.0;
            }
            return Ok((AdvanceOutcome::End, after - last.max(before)));
        }
        Ok((AdvanceOutcome::End, 0.0))
    }

    /// Advances to `begin + step` or to the first impact, which is then due; the limit before it
    /// is shown. An impact at most `late` (s) after the end counts as well. Returns whether an
    /// impact is due.
    ///
    /// # Errors
    /// As [`advance`](Self::advance).
    pub(crate) fn advance_before_event(
        &mut self,
        begin: f64,
        step: f64,
        late: f64,
    ) -> Result<bool, ComponentProblem> {
        let end = DoubleDouble::sum(begin, step);
        check_time(self.data.parameters.drive_frequency, end.value())?;
        if end.minus(self.data.time).value() <= 0.0 {
            return Ok(false);
        }
        let next = self.halves(self.data.time).0 + 1.0;
        let due = self.halves(end.plus(late)).0 >= next;
        (self.data.time, self.data.limit) =
            if due { (self.impact_time(next), Limit::Before) } else { (end, Limit::Any) };
        Ok(due)
    }

    /// Moves to the time `by` (s) from now on the same steady state.
    pub(crate) fn shift(&mut self, by: f64) {
        (self.data.time, self.data.limit) = (self.data.time.plus(by), Limit::Any);
    }

    /// Advances to an impact at most `late` (s) from now, which is then due. Does nothing without
    /// such an impact.
    pub(crate) fn meet(&mut self, late: f64) -> bool {
        let next = self.halves(self.data.time).0 + 1.0;
        let due = self.halves(self.data.time.plus(late)).0 >= next;
        if due {
            (self.data.time, self.data.limit) = (self.impact_time(next), Limit::Before);
        }
        due
    }

    /// Whether an impact is due.
    pub(crate) fn is_due(&self) -> bool {
        self.data.limit == Limit::Before
    }

    /// Applies the impact that is due; does nothing if none is due.
    pub(crate) fn apply_due_event(&mut self, observer: EventObserver<'_, '_>) {
        if self.is_due() {
            self.data.limit = Limit::After;
            if let Some(report) = observer {
                report(&self.event(self.halves(self.data.time).0));
            }
        }
    }

    /// Time of the next impact (s), by formula; it may round to the present time. If an impact is
    /// due, its time is returned.
    pub(crate) fn next_impact(&self) -> f64 {
        let now = self.halves(self.data.time).0;
        self.impact_time(if self.is_due() { now } else { now + 1.0 }).value().max(self.time())
    }

    /// Displacements and velocities; at an impact, for the limit that is shown. An impact that
    /// counts as past by the rounding of the phase shows the limit after it. If the rounded phase
    /// is on the other side of the impact, the velocities that jump are taken at a phase twice the
    /// rounding away.
    fn state(&self) -> State {
        let (theta, side) = (self.theta(), self.last_side());
        let (halves, since) = self.halves(self.data.time);
        let rounding = phase_rounding(halves * PI);
        let state = self.solution.state(theta);
        // The threshold is the mean of the approach and rebound velocities; the rebound may be
        // zero.
        let restitution = self.data.parameters.stop_restitution;
        let before = side * (state.v[1] - state.v[0]) > 0.5 * (1.0 - restitution) * self.speed;
        let way = match (self.data.limit, before) {
            (Limit::Before, false) => -2.0 * rounding,
            (Limit::After, true) => 2.0 * rounding,
            (Limit::Any, true) if since <= rounding => 2.0 * rounding,
            _ => return state,
        };
        let beside = self.solution.state(theta + way).v;
        State { x: state.x, v: [beside[0], beside[1], state.v[2]] }
    }

    /// The stop of the last impact, or of the impact that is due: +1 upper, -1 lower.
    fn last_side(&self) -> f64 {
        if self.halves(self.data.time).0 % 2.0 == 0.0 { 1.0 } else { -1.0 }
    }

    /// The stop of the last counted impact, at which the motion shown now began. An impact that is
    /// due is not counted.
    pub(crate) fn counted_side(&self) -> f64 {
        if self.is_due() { -self.last_side() } else { self.last_side() }
    }

    /// Half periods since the last upper impact before the solution applied, as a whole number,
    /// and the drive phase since the last impact, rad. Whole numbers above 0 count impacts; odd
    /// numbers are on the lower stop.
    fn halves(&self, time: DoubleDouble) -> (f64, f64) {
        let total = self.offset + self.data.parameters.drive_frequency * time.minus(self.data.from).value();
        // An impact that is a rounding error ahead has happened, so that a step that ends at an
        // impact does not meet it again.
        let whole = ((total + phase_rounding(total)) / PI).floor();
        (whole, (total - whole * PI).max(0.0))
    }

    fn impact_time(&self, n: f64) -> DoubleDouble {
        self.data.from.plus((n * PI - self.offset) / self.data.parameters.drive_frequency)
    }

    fn event(&self, n: f64) -> Event {
        let side = if n % 2.0 == 0.0 { 1 } else { -1 };
        Event::Impact { time: self.impact_time(n).value(), side, speed: self.speed, impulse: self.impulse }
    }

    /// Phase of the drive, rad.
    pub(crate) fn theta(&self) -> f64 {
        self.data.phase.angle(self.data.parameters.drive_frequency, self.data.time)
    }

    /// Time derivatives of the displacements now.
    pub(crate) fn derivatives(&self) -> [[f64; ORDERS]; 3] {
        self.solution.derivatives(self.theta(), &self.state())
    }

    /// Present values of the outputs.
    pub(crate) fn values(&self) -> OutputValues {
        let (data, p) = (&self.data, &self.data.parameters);
        let d = self.derivatives();
        let state = State { x: d.map(|d| d[0]), v: d.map(|d| d[1]) };
        let y = state.to_relative();
        // Both counts use the same rounding, so that no impact is counted at the start, however
        // near an impact is.
        let ((first, before), (mut now, mut since)) = (self.halves(data.from), self.halves(data.time));
        if self.is_due() {
            (now, since) = (now - 1.0, PI);
        }
        let count = (now - first).max(0.0);
        let mut impacts = data.record;
        if count > 0.0 {
            let upper = (now / 2.0).floor() - (first / 2.0).floor();
            impacts.upper += upper as u64;
            impacts.lower += (count - upper) as u64;
            impacts.last_time = self.impact_time(now).value();
            (impacts.last_speed, impacts.last_impulse) = (self.speed, self.impulse);
            impacts.total_impulse += count * self.impulse;
            impacts.box_impulse += (2.0 * upper - count) * self.impulse;
        }
        let half = self.knots.last().copied().unwrap_or_default();
        let (begun, reached) = (self.energies(before), self.energies(since));
        let total = |i: usize| count * half[i] + (reached[i] - begun[i]);
        OutputValues {
            time: self.time(),
            x: state.x,
            v: state.v,
            acceleration: d.map(|d| d[2]),
            relative: (y[1], y[4]),
            contact_force: 0.0,
            coupling_force: coupling_force(p, &state.x),
            indicators: Approach::new(p, y[1], 0.0).indicators(Contact::Flight),
            mechanical: energy::mechanical(p, &y),
            input: data.input + total(0),
            damped: data.damped + total(1),
            impact_loss: data.impact + count * self.lost,
            contact: Contact::Flight,
            impacts,
        }
    }

    fn piece(&self) -> f64 {
        PI / (self.knots.len() - 1) as f64
    }

    fn fill_knots(&mut self, rate: f64) {
        let pieces = (PI * rate / (PIECE * self.data.parameters.drive_frequency))
            .ceil()
            .clamp(1.0, MAX_PIECES) as usize;
        let piece = PI / pieces as f64;
        let mut knots = vec![[0.0; 2]; pieces + 1];
        // One pass along the orbit for all pieces: computing each state alone would start again at
        // the impact.
        self.solution.with_states(|states| {
            for i in 0..pieces {
                let (from, to) = (i as f64 * piece, (i + 1) as f64 * piece);
                let energy = self.integrate(states, from, to);
                knots[i + 1] = [knots[i][0] + energy[0], knots[i][1] + energy[1]];
            }
        });
        self.knots = knots;
    }

    /// Input and damped energy from an impact to a drive phase `since` ∈ [0, π] later.
    fn energies(&self, since: f64) -> [f64; 2] {
        let index = ((since / self.piece()) as usize).min(self.knots.len() - 2);
        let from = index as f64 * self.piece();
        let rest = self.solution.with_states(|states| self.integrate(states, from, since));
        [self.knots[index][0] + rest[0], self.knots[index][1] + rest[1]]
    }

    /// Integrals of the powers between two phases after the upper impact. The half period after
    /// the lower impact is the mirror image and has the same powers.
    fn integrate(&self, states: &mut dyn FnMut(f64) -> State, from: f64, to: f64) -> [f64; 2] {
        let p = &self.data.parameters;
        let mut sums = [0.0; 2];
        for (node, weight) in FIVE.nodes.iter().zip(&FIVE.weights) {
            let theta = self.solution.impact_phase() + from + node * (to - from);
            let v = states(theta).v;
            sums[0] += weight * p.drive_amplitude * theta.sin() * v[0];
            sums[1] += weight * (p.box_damping * v[0] * v[0] + p.secondary_damping * v[2] * v[2]);
        }
        sums.map(|sum| sum * (to - from) / p.drive_frequency)
    }
}
