//! Rates beyond what doubles carry: a machine that has them would move by numbers that are none, or
//! never.

use crate::description::{BodyKind, Description, Signal, StopLaw};
use crate::error::Error;
use crate::system::{Elongation, System};

/// The highest rate, rad/s, or frequency, Hz: its square times the largest coordinate, 1e100, is a
/// number.
const MOST_RATE: f64 = 1e100;

/// Springs and compliant stops, with the inertias that they move, and harmonics are slower than
/// that.
///
/// # Errors
/// [`Error::TooFast`].
pub(crate) fn check(machine: &Description, system: &System) -> Result<(), Error> {
    for (spring, rows) in machine.springs.iter().zip(&system.springs) {
        check_force(("spring", &spring.name), &rows.elongation, [spring.stiffness, spring.damping])?;
    }
    for (stop, rows) in machine.stops.iter().zip(&system.stops) {
        if let StopLaw::Compliant { stiffness, damping, .. } = stop.law {
            check_force(("stop", &stop.name), &rows.elongation, [stiffness, damping])?;
        }
    }
    signals(machine).try_for_each(|(name, signal)| {
        let fast = signal.harmonics.iter().map(|h| h.frequency).find(|f| *f > MOST_RATE);
        fast.map_or(Ok(()), |value| Err(Error::TooFast { name: format!("{name}: frequency"), value }))
    })
}

/// The rates that a stiffness and a damping would make by themselves. What is linked to a light
/// body moves with it, and makes them lower.
fn check_force(
    (kind, name): (&str, &str),
    elongation: &Elongation,
    [stiffness, damping]: [f64; 2],
) -> Result<(), Error> {
    let compliance = elongation.column.norm_squared();
    let rate = |force: f64| if force > 0.0 { force * compliance } else { 0.0 };
    for (what, value, rate) in
        [("stiffness", stiffness, rate(stiffness).sqrt()), ("damping", damping, rate(damping))]
    {
        if rate.is_nan() || rate > MOST_RATE {
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
