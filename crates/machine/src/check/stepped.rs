//! Problems of stiffnesses that step in time.

use super::{falling, refused};
use crate::description::{Description, Interpolation, Signal, StopLaw};
use crate::kinds::STIFFNESS;
use crate::refusal::Problem;
use crate::stepped::{MOST_LEVELS, count, given, zero};

/// The fault of a part that a stiffness that steps cannot have.
const UNSUPPORTED: &str = "is not supported in a stiffness, which is constant between its steps; use \
    `constant` with `steps`, or a `table` with interpolation = \"hold\"";

/// Problems of all stiffnesses that step in time.
pub(super) fn check(machine: &Description, problems: &mut Vec<Problem>) {
    let mut any = false;
    for spring in &machine.springs {
        let Some(signal) = &spring.stepped else { continue };
        let name = format!("spring.{}.stiffness", spring.name);
        any = true;
        if spring.series.is_some() || !spring.points.is_empty() {
            problems.push(Problem::new(
                &name,
                None,
                "cannot step in time with points or a partner in series; expected a number",
            ));
        }
        let unit = STIFFNESS.unit(spring.arms.dimension);
        check_signal(&name, signal, (spring.stiffness, unit), problems);
    }
    for stop in &machine.stops {
        let Some(signal) = &stop.stepped else { continue };
        let name = format!("stop.{}.stiffness", stop.name);
        any = true;
        match stop.law {
            StopLaw::Rigid { .. } => {
                let text = "cannot be combined with `restitution`: use `restitution` for a rigid stop, or \
                            `stiffness` for a compliant one";
                problems.push(Problem::new(&name, None, text));
            }
            StopLaw::Compliant { stiffness, .. } => {
                let unit = STIFFNESS.unit(stop.arms.dimension);
                check_signal(&name, signal, (stiffness, unit), problems);
            }
        }
    }
    if let (true, true, Some(spring)) = (any, machine.starts_at_rest, falling(machine)) {
        let text =
            "falling lines cannot be combined with a stiffness that steps in a machine that starts at rest";
        problems.push(Problem::new(format!("spring.{}.points", spring.name), None, text));
    }
}

fn check_signal(name: &str, signal: &Signal, (beside, unit): (f64, &str), problems: &mut Vec<Problem>) {
    let is_held = signal.table.as_ref().is_none_or(|own| own.interpolation == Interpolation::Hold);
    let kinds = [
        (if signal.harmonics.len() == 1 { "amplitude" } else { "harmonics" }, !signal.harmonics.is_empty()),
        ("sweep", !signal.sweeps.is_empty()),
        ("input", signal.input),
    ];
    let count_before = problems.len();
    for (key, _) in kinds.iter().filter(|own| own.1) {
        problems.push(Problem::new(format!("{name}.{key}"), None, UNSUPPORTED));
    }
    if !is_held {
        let text = "requires interpolation = \"hold\" in a stiffness, which is constant between its steps";
        problems.push(Problem::new(format!("{name}.table"), None, text));
    }
    if signal.table.is_some() && !signal.steps.is_empty() {
        let text = "cannot be combined with `table` in a stiffness: use one of them";
        problems.push(Problem::new(format!("{name}.steps"), None, text));
    }
    if beside != 0.0 {
        problems.push(refused(name, beside, "must be 0 if the stiffness steps in time"));
    }
    if problems.len() > count_before {
        return;
    }
    if signal.steps.is_empty() && signal.table.is_none() {
        let text =
            "does not step; expected steps or a table with interpolation = \"hold\", or a number alone";
        problems.push(Problem::new(name, None, text));
        return;
    }
    let count = count(signal);
    if count > MOST_LEVELS {
        let text = format!(
            "has {count} levels; expected at most {MOST_LEVELS}, counting one before the first step and \
             one after each step, \
             or one for each value of a table"
        );
        problems.push(Problem::new(name, None, text));
        return;
    }
    check_levels(name, signal, unit, problems);
}

/// Each level must be at least 0, up to rounding, but for one before a step at a period's start.
fn check_levels(name: &str, signal: &Signal, unit: &str, problems: &mut Vec<Problem>) {
    let all = given(signal);
    let is_unused = signal.repeat.is_some() && signal.steps.first().is_some_and(|step| step.time == 0.0);
    let negative = |(i, k): &(usize, &f64)| **k < -zero(&all) && !(*i == 0 && is_unused);
    let Some((i, k)) = all.iter().enumerate().find(negative) else { return };
    problems.push(match (&signal.table, i.checked_sub(1)) {
        (Some(_), _) => refused(
            name,
            *k,
            format!("in {unit}: this value of the table, plus `constant`, must be at least 0"),
        ),
        (None, None) => refused(name, *k, "the stiffness before the first step must be at least 0"),
        (None, Some(step)) => {
            let height = signal.steps[step].height;
            let text = format!(
                "makes the stiffness {k:?} {unit}; it must be at least 0: a height of {:?} {unit} or more",
                height - k
            );
            refused(format!("{name}.steps[{step}].height"), height, text)
        }
    });
}
