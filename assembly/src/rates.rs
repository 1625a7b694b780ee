//! Rates beyond what doubles carry: a machine that has them would move by numbers that are none, or never.

use crate::description::{Arms, BodyKind, Description, Signal, StopLaw};
use crate::error::Error;

/// The highest rate, rad/s, or frequency, Hz: its square times the largest coordinate, 1e100, is a number.
const MOST_RATE: f64 = 1e100;

/// Springs and compliant stops, with the inertias that they move, and harmonics are slower than that.
///
/// # Errors
/// [`Error::TooFast`].
pub(crate) fn check(machine: &Description) -> Result<(), Error> {
    for spring in &machine.springs {
        check_force(machine, ("spring", &spring.name), &spring.arms, [spring.stiffness, spring.damping])?;
    }
    for stop in &machine.stops {
        if let StopLaw::Compliant { stiffness, damping, .. } = stop.law {
            check_force(machine, ("stop", &stop.name), &stop.arms, [stiffness, damping])?;
        }
    }
    signals(machine).try_for_each(|(name, signal)| {
        let fast = signal.harmonics.iter().map(|h| h.frequency).find(|f| *f > MOST_RATE);
        fast.map_or(Ok(()), |value| Err(Error::TooFast { name: format!("{name}: frequency"), value }))
    })
}

/// The rates that a stiffness and a damping would make by themselves. Links make inertias greater only.
fn check_force(
    machine: &Description,
    (kind, name): (&str, &str),
    arms: &Arms,
    [stiffness, damping]: [f64; 2],
) -> Result<(), Error> {
    let each = arms.terms.iter().map(|&(body, arm)| match &machine.bodies[body].kind {
        BodyKind::Free(free) => arm * arm / free.inertia,
        BodyKind::Prescribed { .. } => 0.0,
    });
    let compliance: f64 = each.sum();
    let rate = |force: f64| if force > 0.0 { force * compliance } else { 0.0 };
    for (what, value, rate) in
        [("stiffness", stiffness, rate(stiffness).sqrt()), ("damping", damping, rate(damping))]
    {
        if rate > MOST_RATE {
            return Err(Error::TooFast { name: format!("{kind}.{name}.{what}"), value });
        }
    }
    Ok(())
}

/// Every signal, with the name of what it belongs to.
fn signals(machine: &Description) -> impl Iterator<Item = (String, &Signal)> {
    let motions = machine.bodies.iter().filter_map(|b| match &b.kind {
        BodyKind::Prescribed { motion, .. } => Some((format!("body.{}", b.name), motion)),
        BodyKind::Free(_) => None,
    });
    let levels = machine.frictions.iter().flat_map(|f| {
        let all = std::iter::once(&f.force).chain(&f.static_force);
        all.map(|signal| (format!("friction.{}", f.name), signal))
    });
    let loads = machine.loads.iter().map(|l| (format!("load.{}", l.name), &l.force));
    motions.chain(levels).chain(loads)
}
