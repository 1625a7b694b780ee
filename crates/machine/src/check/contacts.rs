//! Problems of powers with an exponent (contacts of stops, powers with two sides) and of contacts
//! with friction.

use super::refused;
use crate::description::{
    Arms, BodyKind, Contact, ContactLaw, DampingLimit, Description, OddPower, Stop, StopLaw,
};
use crate::kinds::EXPONENT;
use crate::refusal::Problem;
use crate::slots::TANGENTS;
use std::collections::BTreeMap;

/// Adds the problems of exponents, and of what cannot be combined with a curved contact.
pub(super) fn check(machine: &Description, problems: &mut Vec<Problem>) {
    let springs = machine.springs.iter().map(|own| (format!("spring.{}", own.name), own.power));
    let dampers = machine.dampers.iter().map(|own| (format!("damper.{}", own.name), own.power));
    for (name, power) in springs.chain(dampers) {
        if let Some(OddPower { exponent, .. }) = power {
            check_exponent(&name, exponent, problems);
        }
    }
    for stop in &machine.stops {
        if let Some(contact) = stop.contact {
            check_contact(stop, contact, problems);
        }
    }
    machine.contacts.iter().for_each(|contact| check_friction(machine, contact, problems));
    for friction in &machine.frictions {
        let stop = friction.follows.as_ref().and_then(|follows| machine.stops.get(follows.stop));
        if let Some(stop) = stop.filter(|stop| stop.contact.is_some()) {
            let name = format!("friction.{}.follows", friction.name);
            problems.push(Problem::new(name, Some(format!("{:?}", stop.name)), FOLLOWS));
        }
    }
}

/// Adds the problems of contacts with friction.
fn check_friction(machine: &Description, contact: &Contact, problems: &mut Vec<Problem>) {
    if contact.tangents.is_empty() {
        return;
    }
    let of = format!("contact.{}", contact.name);
    if contact.damping != 0.0 {
        let text = "cannot be combined with `friction`: the limit of friction would jump when the contact \
                    closes; use the damping of the bodies";
        problems.push(refused(format!("{of}.damping"), contact.damping, text));
    }
    let tangents = contact.tangents.iter().map(|tangent| &tangent.arms);
    let arms: Vec<&Arms> = std::iter::once(&contact.normal).chain(tangents).collect();
    let rows: Vec<_> = arms.iter().map(|arms| on_coordinates(machine, arms)).collect();
    let keys: Vec<&str> = std::iter::once("normal").chain(TANGENTS).collect();
    for i in 1..rows.len() {
        if let Some(j) = (0..i).find(|&j| is_parallel(&rows[j], &rows[i])) {
            let text =
                format!("has the same direction as `{}`; expected another direction of the bodies", keys[j]);
            problems.push(Problem::new(format!("{of}.{}", keys[i]), None, text));
        }
    }
    let is_flexible = arms.iter().flat_map(|arms| &arms.terms).any(|term| machine.has_residual(term.0));
    if is_flexible && contact.tangents.len() > 1 {
        let text = "a contact with two tangents is not supported on residual flexibility: remove \
                    `second_tangent` and `cone`, or take the nodes out of `residual`";
        problems.push(Problem::new(format!("{of}.second_tangent"), None, text));
    }
    if machine.starts_at_rest && is_flexible {
        let text = "cannot be combined with `start = \"rest\"` on residual flexibility; give the start of each \
                    body, or take the nodes out of `residual`";
        problems.push(refused(format!("{of}.friction"), contact.friction, text));
    }
}

/// An elongation as factors of bodies, with nodes replaced by the coordinates behind them.
fn on_coordinates(machine: &Description, arms: &Arms) -> BTreeMap<usize, f64> {
    let mut all = BTreeMap::new();
    for &(body, arm) in &arms.terms {
        match machine.bodies.get(body).map(|body| &body.kind) {
            Some(BodyKind::Node(row)) => {
                row.iter().for_each(|&(k, factor)| *all.entry(k).or_default() += arm * factor);
            }
            _ => *all.entry(body).or_default() += arm,
        }
    }
    all
}

/// Whether two rows are multiples of one another.
fn is_parallel(a: &BTreeMap<usize, f64>, b: &BTreeMap<usize, f64>) -> bool {
    let of = |row: &BTreeMap<usize, f64>, k: &usize| row.get(k).copied().unwrap_or_default();
    let all: Vec<(f64, f64)> = a.keys().chain(b.keys()).map(|k| (of(a, k), of(b, k))).collect();
    let [aa, bb, ab] = [
        all.iter().map(|own| own.0 * own.0).sum::<f64>(),
        all.iter().map(|own| own.1 * own.1).sum::<f64>(),
        all.iter().map(|own| own.0 * own.1).sum::<f64>(),
    ];
    ab * ab >= (1.0 - PARALLEL) * aa * bb
}

/// Two directions count as parallel up to this square of the sine of their angle: rounding.
const PARALLEL: f64 = 1e-14;

/// The fault of a friction that follows a curved contact.
pub(crate) const FOLLOWS: &str = "friction at a stop with `exponent` or `dissipation` is not supported; use a stop \
                                  with `stiffness` and `damping`";

fn check_exponent(of: &str, exponent: f64, problems: &mut Vec<Problem>) {
    if !EXPONENT.contains(exponent) {
        problems.push(refused(
            format!("{of}.exponent"),
            exponent,
            format!("expected {}", EXPONENT.range.allowed),
        ));
    }
}

fn check_contact(stop: &Stop, contact: ContactLaw, problems: &mut Vec<Problem>) {
    let of = format!("stop.{}", stop.name);
    check_exponent(&of, contact.exponent, problems);
    let mut refuse = |text: &str| problems.push(Problem::new(&of, None, text));
    if stop.stepped.is_some() {
        refuse(
            "a stiffness that steps in time cannot be combined with `exponent` or `dissipation`: use two stops \
             in parallel",
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
