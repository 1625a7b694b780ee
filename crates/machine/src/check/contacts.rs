//! Problems of powers with an exponent: contacts of stops, and powers with two sides.

use super::refused;
use crate::description::{ContactLaw, DampingLimit, Description, OddPower, Stop, StopLaw};
use crate::kinds::{EXPONENT, NumberKind, ODD_EXPONENT};
use crate::refusal::Problem;

/// Adds the problems of exponents, and of what cannot be combined with a curved contact.
pub(super) fn check(machine: &Description, problems: &mut Vec<Problem>) {
    let springs = machine.springs.iter().map(|own| (format!("spring.{}", own.name), own.power));
    let dampers = machine.dampers.iter().map(|own| (format!("damper.{}", own.name), own.power));
    for (name, power) in springs.chain(dampers) {
        if let Some(OddPower { exponent, .. }) = power {
            check_exponent(&name, exponent, ODD_EXPONENT, problems);
        }
    }
    for stop in &machine.stops {
        if let Some(contact) = stop.contact {
            check_contact(stop, contact, problems);
        }
    }
    for friction in &machine.frictions {
        let stop = friction.follows.as_ref().and_then(|follows| machine.stops.get(follows.stop));
        if let Some(stop) = stop.filter(|stop| stop.contact.is_some()) {
            let name = format!("friction.{}.follows", friction.name);
            problems.push(Problem::new(name, Some(format!("{:?}", stop.name)), FOLLOWS));
        }
    }
}

/// The fault of a friction that follows a curved contact.
pub(crate) const FOLLOWS: &str = "friction at a stop with `exponent` or `dissipation` is not supported; use a stop \
                                  with `stiffness` and `damping`";

fn check_exponent(of: &str, exponent: f64, kind: NumberKind, problems: &mut Vec<Problem>) {
    if !kind.contains(exponent) {
        problems.push(refused(
            format!("{of}.exponent"),
            exponent,
            format!("expected {}", kind.range.allowed),
        ));
    }
}

fn check_contact(stop: &Stop, contact: ContactLaw, problems: &mut Vec<Problem>) {
    let of = format!("stop.{}", stop.name);
    check_exponent(&of, contact.exponent, EXPONENT, problems);
    let mut refuse = |text: &str| problems.push(Problem::new(&of, None, text));
    if stop.stepped.is_some() {
        refuse(
            "a stiffness that steps in time cannot be combined with `exponent` or `dissipation`: use two stops \
             side by side",
        );
    }
    match stop.law {
        StopLaw::Rigid { .. } => {
            refuse("`exponent` and `dissipation` require `stiffness`, not `restitution`")
        }
        StopLaw::Compliant { limit, .. } if limit != DampingLimit::NoPull => {
            refuse("`exponent` and `dissipation` require the law \"no-pull\"");
        }
        StopLaw::Compliant { damping, .. } if damping != 0.0 && contact.dissipation.is_some() => {
            refuse("`dissipation` cannot be combined with `damping`; expected one of them");
        }
        StopLaw::Compliant { .. } => {}
    }
}
