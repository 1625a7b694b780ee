//! Problems of stiffnesses that step in time.

use super::refused;
use crate::description::{Description, Interpolation, Signal, StopLaw};
use crate::polyline::slopes;
use crate::refusal::Problem;
use crate::stepped::{MOST_LEVELS, count, given, zero};

/// Allowed parts of a stiffness that steps, in words.
const ALLOWED: &str = "is not supported in a stiffness, which is constant between its steps; use \
    constant, steps or a table with \
    interpolation = \"hold\", and repeat";

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
        check_signal(&name, signal, spring.stiffness, problems);
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
            StopLaw::Compliant { stiffness, .. } => check_signal(&name, signal, stiffness, problems),
        }
    }
    let falls = machine.springs.iter().find(|own| slopes(&own.points).iter().any(|slope| *slope < 0.0));
    if let (true, true, Some(spring)) = (any, machine.starts_at_rest, falls) {
        let text =
            "falling lines cannot be combined with a stiffness that steps in a machine that starts at rest";
        problems.push(Problem::new(format!("spring.{}.points", spring.name), None, text));
    }
}

fn check_signal(name: &str, signal: &Signal, beside: f64, problems: &mut Vec<Problem>) {
    let is_held = signal.table.as_ref().is_none_or(|own| own.interpolation == Interpolation::Hold);
    let kinds = [
        ("harmonics", !signal.harmonics.is_empty()),
        ("sweep", !signal.sweeps.is_empty()),
        ("input", signal.input),
        ("table", !is_held),
    ];
    let count_before = problems.len();
    for (key, _) in kinds.iter().filter(|own| own.1) {
        problems.push(Problem::new(format!("{name}.{key}"), None, ALLOWED));
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
    check_levels(name, signal, problems);
}

/// Each level must be at least 0, up to rounding, but for one before a step at a period's start.
fn check_levels(name: &str, signal: &Signal, problems: &mut Vec<Problem>) {
    let all = given(signal);
    let is_unused = signal.repeat.is_some() && signal.steps.first().is_some_and(|step| step.time == 0.0);
    let negative = |(i, k): &(usize, &f64)| **k < -zero(&all) && !(*i == 0 && is_unused);
    if let Some((i, k)) = all.iter().enumerate().find(negative) {
        let text = match (&signal.table, i) {
            (Some(_), _) => "this value of the table, plus the constant, must be at least 0".to_owned(),
            (None, 0) => "the stiffness before the first step must be at least 0".to_owned(),
            (None, i) => format!("the stiffness after steps[{}] must be at least 0", i - 1),
        };
        problems.push(refused(name, *k, text));
    }
}
