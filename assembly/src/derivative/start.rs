//! Derivatives at the start of a motion (docs/assembly-law.md (A32)).

use super::impulse::Impulse;
use super::lost::{Cause, Lost};
use super::machine::{Instant, Machine, Varied};
use super::rest::equilibrium;
use crate::motion::Event;
use nalgebra::DVector;

/// The derivative by parameter `p` after the law at the start, which has had `events`; `begun` is
/// the state before it.
pub(super) fn start(
    machine: &Machine,
    p: usize,
    begun: &DVector<f64>,
    events: &[Event],
    at: &Instant,
) -> Result<DVector<f64>, Lost> {
    let (system, tangent) = (&machine.system, &machine.tangents[p]);
    let (n, mut delta) = (system.coordinates, DVector::zeros(system.signals.size));
    machine.fill(p, at.time, at.z, &mut delta);
    if tangent.signals.later(at.time).is_some() {
        let element = format!("the step at {} s", at.time);
        return Err(Lost { time: at.time, element, cause: Cause::Limit });
    }
    if machine.assembly.description.starts_at_rest {
        equilibrium(machine, p, &mut delta, at)?;
    }
    for (k, &(s, v)) in tangent.starts.iter().enumerate() {
        delta[k] += s;
        delta[n + k] += v;
    }
    let scale = delta.abs();
    machine.check_touching(Varied { p, delta: &delta, scale: &scale }, at)?;
    for impulse in &Impulse::all(system, events, begun) {
        if let Some(stop) = impulse.at_limit(system, tangent) {
            let element = machine.assembly.name_of_stop(stop);
            return Err(Lost { time: at.time, element, cause: Cause::Limit });
        }
        impulse.carry(system, tangent, &mut delta);
    }
    machine.keep(p, &mut delta, &scale, at)?;
    machine.check(Varied { p, delta: &delta, scale: &scale }, at, &machine.still(at, true))?;
    Ok(delta)
}
