//! Where a step leads: to its end, which own time may be past by rounding, with an event a little
//! behind it; or back to its beginning.

use super::ComponentProblem;
use vibro_impact::State;
use vibro_impact::error::Error;
use vibro_impact::numerics::double_double::DoubleDouble;
use vibro_impact::simulator::{AdvanceOutcome, Contact, EventObserver, Pause, Simulator, Snapshot};

/// Advances to an end, which own time may be past by the rounding that `point` is allowed: nothing
/// is left to do then.
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

/// Goes on to an event that lies past a step's end by rounding alone and stands before it; without
/// one nothing happens. A host that comes to the time of an event it was told must find it there,
/// or have it behind itself: else its next step would end where it began, and it would not
/// progress.
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

/// Whether no event can come within the rounding of a time: the block in flight is so far from the
/// stops that its acceleration moves it by far less than the margin in that, or it is pressed on by
/// far more than the force can lose.
fn is_clear(simulator: &Simulator, late: f64) -> bool {
    const MARGIN: f64 = 1e-6; // gaps, and parts of the forces that sizes and rates of the motion make
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

/// Units in the last place of a step's end by which a master's sum of time and step size may be
/// off.
pub(super) const UNITS: f64 = 4.0;

/// How far off a step's end an impact still is at its end, s.
pub(super) fn rounding(end: f64) -> f64 {
    UNITS * f64::EPSILON * end.abs()
}

/// How far past a step's end an event still is at its end, s. To the rounding of times comes that
/// of w, which moves the time of an impact by as much over the speed (docs/numerics.md, section 2,
/// *The root*): a slow block that is a few units in the last place before a stop at the time that a
/// master was told is at it.
fn lateness(simulator: &Simulator, end: f64) -> f64 {
    /// Of the last place of w, which each sub-step since the time was told may have moved by a unit
    /// where it is another than on the way on which the time was found.
    const UNITS: f64 = 256.0;
    /// At most so long, in parts of the fastest time constant: the slower bounces are the last of a
    /// chatter run. Also in parts of a master's time, of which it is a tenth of what own time may
    /// be off ([`TIME_TOLERANCE`](fmi_doors::TIME_TOLERANCE)).
    const LONGEST: f64 = 1e-10;
    let (_, rate) = simulator.relative_motion();
    let longest = LONGEST * end.abs().max(1.0).min(1.0 / simulator.fastest_rate());
    rounding(end) + (UNITS * f64::EPSILON * size(simulator) / rate.abs()).min(longest)
}

/// S of docs/numerics.md, section 1, but for what loads add: the size of the motion, m.
fn size(simulator: &Simulator) -> f64 {
    let (parameters, fastest) = (simulator.parameters(), simulator.fastest_rate());
    let State { x, v } = simulator.state();
    let pushed = parameters.drive_amplitude.abs() / (parameters.box_mass * fastest * fastest);
    parameters.stop_gap + x[0].abs() + x[2].abs() + (v[0].abs() + v[2].abs()) / fastest + pushed
}

/// Takes back a step that failed, and says why it did, or that it could not be taken back.
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
