//! The end of a step, and the return to its beginning after an error. Because of rounding, the
//! simulator's own time may be past the end of a step, and an event at the end may be slightly
//! past it.

use super::ComponentProblem;
use vibro_impact::State;
use vibro_impact::error::Error;
use vibro_impact::simulator::{AdvanceOutcome, Contact, EventObserver, Pause, Simulator, Snapshot};
use vibro_numerics::double_double::DoubleDouble;

/// Advances to `end`. The simulator's own time may already be past `end` by the rounding that the
/// `point` of a step may have; then nothing is done.
pub(super) fn advance(
    simulator: &mut Simulator,
    end: DoubleDouble,
    pause: Pause,
    report: EventObserver<'_, '_>,
) -> Result<AdvanceOutcome, Error> {
    match simulator.advance_until(end, pause, report) {
        Err(Error::Step { .. }) => Ok(AdvanceOutcome::End),
        outcome => outcome,
    }
}

/// Whether an event is past a step's end only by rounding. If so, advances to the event and pauses
/// before its law; otherwise leaves the motion unchanged. A host may step to the announced time of
/// an event. The event must then be at the end of this step or before it. Otherwise the next step
/// would end where it began, and the host would make no progress.
pub(super) fn is_at_end(simulator: &mut Simulator, end: f64) -> Result<bool, Error> {
    if is_clear(simulator, rounding(end)) {
        return Ok(false);
    }
    let (before, late) = (simulator.snapshot(), lateness(simulator, end));
    let reached = advance(simulator, DoubleDouble::sum(end, late), Pause::BeforeEvent, None)?;
    if reached == AdvanceOutcome::EventDue {
        return Ok(true);
    }
    simulator.restore(&before)?;
    Ok(false)
}

/// Whether no event can occur within `late`, s, the rounding of a time. A block in flight must be
/// farther from the stops than it moves in that time at its present speed, by a margin that is far
/// larger than the effect of its acceleration. A block in rest must have a contact force far
/// larger than the change of the force in that time.
fn is_clear(simulator: &Simulator, late: f64) -> bool {
    const MARGIN: f64 = 1e-6; // in units of the gap, and of `forces`
    let ((w, rate), parameters) = (simulator.relative_motion(), simulator.parameters());
    let gap = parameters.stop_gap;
    if simulator.contact() == Contact::Flight {
        return gap - w.abs() > MARGIN * gap + 4.0 * late * rate.abs();
    }
    let fastest = simulator.fastest_rate();
    let loads: f64 = simulator.loads().derivatives.iter().flatten().map(|load| load.abs()).sum();
    let pair = 1.0 / (1.0 / parameters.box_mass + 1.0 / parameters.block_mass);
    let forces = pair * fastest * fastest * size(simulator) + loads * fastest.max(1.0);
    simulator.contact_force() > (MARGIN + 8.0 * late * fastest) * forces
}

/// Largest error of a master's sum of time and step size, in units in the last place of a step's
/// end.
pub(super) const UNITS: f64 = 4.0;

/// Tolerance on the time between an impact and a step's end, s. Within it the impact counts as at
/// the end.
pub(super) fn rounding(end: f64) -> f64 {
    UNITS * f64::EPSILON * end.abs()
}

/// Tolerance on the time of an event after a step's end, s. Within it the event counts as at the
/// end. The tolerance is the rounding of times plus the rounding of w divided by the speed |w'|.
/// The quotient is the error of an impact's time (docs/numerics.md, section 2, *The root*). If a
/// master steps to the announced time of an impact, a slow block may still be a few units in the
/// last place of w before the stop. It then counts as at the stop.
fn lateness(simulator: &Simulator, end: f64) -> f64 {
    /// Rounding of w in units in its last place. Since the announcement, each sub-step that
    /// differs from the sub-steps with which the time was found may have moved w by one unit.
    const UNITS: f64 = 256.0;
    /// Cap on the time for the rounding of w, as a fraction of the fastest time constant; slower
    /// bounces are the last ones of a chatter run. The time is also at most this fraction of
    /// max(1, |t|), a tenth of the tolerance of a master's time
    /// ([`TIME_TOLERANCE`](fmi_doors::TIME_TOLERANCE)).
    const LONGEST: f64 = 1e-10;
    let (_, rate) = simulator.relative_motion();
    let longest = LONGEST * end.abs().max(1.0).min(1.0 / simulator.fastest_rate());
    rounding(end) + (UNITS * f64::EPSILON * size(simulator) / rate.abs()).min(longest)
}

/// Size S of the motion in docs/numerics.md, section 1, without the contribution of loads, m.
fn size(simulator: &Simulator) -> f64 {
    let (parameters, fastest) = (simulator.parameters(), simulator.fastest_rate());
    let State { x, v } = simulator.state();
    let pushed = parameters.drive_amplitude.abs() / (parameters.box_mass * fastest * fastest);
    parameters.stop_gap + x[0].abs() + x[2].abs() + (v[0].abs() + v[2].abs()) / fastest + pushed
}

/// Undoes a failed step. Returns the step's error, or an error that states that undoing failed.
#[cold]
pub(super) fn take_back(
    simulator: &mut Simulator,
    before: &Snapshot,
    problem: ComponentProblem,
) -> ComponentProblem {
    if let Err(refused) = simulator.restore(before) {
        return fmi_doors::Problem::not_taken_back(&problem, &refused).into();
    }
    match problem {
        ComponentProblem::Model(Error::WorkLimit { time, events, restitution, path, .. }) => {
            ComponentProblem::WorkLimit { own: simulator.time(), time, events, restitution, path }
        }
        problem => problem,
    }
}
