//! Checks of the start: at time 0 links hold and rigid stops are not violated.

use super::refused;
use crate::description::{BodyKind, Description, Dimension, StopLaw, elongation, starts};
use crate::refusal::Problem;

/// Relative tolerance of a link at the start, for start values written with ten digits.
const WRITTEN: f64 = 1e-9;

/// Tolerance for e > gap, relative to both sizes: sums equal in the file differ by rounding.
const ZERO: f64 = 1e-13;

/// Problems of the start; requires a machine without other problems. A start at rest is checked by
/// [`equilibrium`](crate::rest::equilibrium).
pub(super) fn check(machine: &Description, problems: &mut Vec<Problem>) {
    if machine.starts_at_rest {
        return at_rest(machine, problems);
    }
    let starts = starts(machine);
    formulas(machine, &starts, problems);
    for link in &machine.links {
        let unit = unit(link.arms.dimension);
        for (what, after, which) in [("e", "", 0), ("e'", "/s", 1)] {
            let (e, size) = elongation(&link.arms, &starts, which);
            if e.abs() > WRITTEN * size {
                let text = format!(
                    "the starts of its bodies give {what} = {e:?} {unit}{after}; a link requires {what} = 0: change the \
                     start of one of them"
                );
                problems.push(Problem::new(format!("link.{}", link.name), None, text));
                break;
            }
        }
    }
    for stop in &machine.stops {
        let (e, size) = elongation(&stop.arms, &starts, 0);
        if matches!(stop.law, StopLaw::Rigid { .. }) && e - stop.gap > ZERO * (size + stop.gap.abs()) {
            let text = format!(
                "e = {e:?} {} at the start is beyond the gap; a rigid stop requires e <= gap: increase the \
                 gap, or change the start",
                unit(stop.arms.dimension)
            );
            problems.push(refused(format!("stop.{}.gap", stop.name), stop.gap, text));
        }
    }
}

/// Problems of formulas that are not defined at the start.
fn formulas(machine: &Description, starts: &[[f64; 2]], problems: &mut Vec<Problem>) {
    for element in machine.elements() {
        let (Some(arms), Some(compiled)) = (element.arms(), crate::system::compiled(element)) else {
            continue;
        };
        let [e, rate] = [0, 1].map(|which| elongation(arms, starts, which).0);
        let Some((operation, argument)) = compiled.undefined(e, rate) else { continue };
        let unit = unit(arms.dimension);
        let text = format!(
            "at the start, where e = {e:?} {unit} and rate = {rate:?} {unit}/s, the formula contains {}: change \
             the formula or the start values",
            operation.undefined(argument)
        );
        problems.push(Problem::new(format!("{}.force", element.dotted()), None, text));
    }
}

fn at_rest(machine: &Description, problems: &mut Vec<Problem>) {
    for spring in &machine.springs {
        let Some(series) = spring.series.filter(|own| own.slider != 0.0) else { continue };
        let text = "cannot be combined with `start = \"rest\"`, the start of the machine: remove one of them";
        problems.push(refused(format!("spring.{}.slider", spring.name), series.slider, text));
    }
    for body in &machine.bodies {
        let BodyKind::Free(free) = &body.kind else { continue };
        for (key, value) in [("s", free.s), ("v", free.v)] {
            if value != 0.0 {
                let text = "cannot be combined with `start = \"rest\"`, the start of the machine: \
                            remove one of them";
                problems.push(refused(format!("body.{}.start.{key}", body.name), value, text));
            }
        }
    }
}

fn unit(dimension: Dimension) -> &'static str {
    match dimension {
        Dimension::Translation => "m",
        Dimension::Rotation => "rad",
    }
}
