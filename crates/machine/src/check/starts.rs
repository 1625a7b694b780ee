//! Checks of the start: at time 0 links hold and rigid stops are not violated.

use super::refused;
use crate::description::{
    Arms, BodyKind, Description, Dimension, Integrated, Interpolation, Level, Record, Signal, StopLaw,
};
use crate::refusal::Problem;
use std::f64::consts::TAU;

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
    let starts = all(machine);
    formulas(machine, &starts, problems);
    for link in &machine.links {
        let unit = unit(link.arms.dimension);
        for (what, after, which) in [("e", "", 0), ("e'", "/s", 1)] {
            let (e, size) = elongation(&link.arms, &starts, which);
            if e.abs() > WRITTEN * size {
                let text = format!(
                    "the starts of its bodies give {what} = {e:?} {unit}{after}; a link requires {what} = 0"
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

/// Coordinate and rate of each body at time 0.
fn all(machine: &Description) -> Vec<[f64; 2]> {
    let own: Vec<_> = machine.bodies.iter().map(|b| start(&b.kind)).collect();
    let of_node = |row: &[(usize, f64)]| [0, 1].map(|k| row.iter().map(|term| term.1 * own[term.0][k]).sum());
    let starts = machine.bodies.iter().zip(&own);
    starts.map(|(b, own)| if let BodyKind::Node(row) = &b.kind { of_node(row) } else { *own }).collect()
}

/// Elongation and rate of an element at time 0.
pub(crate) fn start_of(machine: &Description, arms: &Arms) -> [f64; 2] {
    let starts = all(machine);
    [0, 1].map(|which| elongation(arms, &starts, which).0)
}

/// Problems of formulas that are not defined at the start.
fn formulas(machine: &Description, starts: &[[f64; 2]], problems: &mut Vec<Problem>) {
    for element in machine.elements() {
        let (Some(arms), Some(compiled)) = (element.arms(), crate::system::compiled(element)) else {
            continue;
        };
        let [e, rate] = [0, 1].map(|which| elongation(arms, starts, which).0);
        let Some((operation, argument)) = compiled.undefined(e, rate) else { continue };
        let text = format!(
            "{}; it is {argument:?} at the start, where e = {e:?} and rate = {rate:?}",
            operation.requirement()
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

/// An elongation (`which` 0) or its rate (1) at the start, and the sum of its terms' sizes.
fn elongation(arms: &Arms, starts: &[[f64; 2]], which: usize) -> (f64, f64) {
    let terms = arms.terms.iter().map(|&(body, arm)| arm * starts[body][which]);
    terms.fold((0.0, 0.0), |(sum, size), term| (sum + term, size + term.abs()))
}

/// Coordinate and rate at time 0. Both are NaN if time 0 lies between two knots of a cubic or
/// repeated record: every comparison with them is false.
fn start(kind: &BodyKind) -> [f64; 2] {
    let (motion, rate) = match kind {
        BodyKind::Free(free) => return [free.s, free.v],
        BodyKind::Prescribed { motion, rate } => (motion, rate),
        BodyKind::Integrated(Integrated { level: Level::Rate, signal: of, s, .. }) => {
            return [*s, signal(of)[0]];
        }
        BodyKind::Integrated(motion) => return [motion.s, motion.v],
        BodyKind::Node(_) => return [0.0; 2],
    };
    let [s, v] = signal(motion);
    [s, v + rate]
}

/// A signal and its rate just after time 0, with zero input.
fn signal(signal: &Signal) -> [f64; 2] {
    let mut sum = [signal.constant, 0.0];
    for harmonic in &signal.harmonics {
        let (sin, cos) = harmonic.phase.sin_cos();
        sum[0] += harmonic.amplitude * sin;
        sum[1] += harmonic.amplitude * TAU * harmonic.frequency * cos;
    }
    for sweep in &signal.sweeps {
        let (sin, cos) = sweep.phase.sin_cos();
        sum[0] += sweep.amplitude * sin;
        sum[1] += sweep.amplitude * TAU * sweep.from * cos;
    }
    sum[0] += signal.steps.iter().filter(|step| step.time <= 0.0).map(|step| step.height).sum::<f64>();
    let [s, v] = signal.table.as_ref().map_or([0.0; 2], |own| record(own, signal.repeat));
    [sum[0] + s, sum[1] + v]
}

fn record(record: &Record, repeat: Option<f64>) -> [f64; 2] {
    let knots = &record.knots;
    if repeat.is_some() && knots[0].0 > 0.0 {
        return [f64::NAN; 2];
    }
    let factor = record.factor();
    let after = knots.partition_point(|knot| knot.0 <= 0.0);
    if after == 0 || after == knots.len() {
        return [factor * knots[after.saturating_sub(1)].1, 0.0];
    }
    let ((t0, y0), (t1, y1)) = (knots[after - 1], knots[after]);
    let (y0, y1) = (factor * y0, factor * y1);
    match (record.interpolation, t0 == 0.0) {
        (Interpolation::Hold, _) => [y0, 0.0],
        (Interpolation::Straight, _) => {
            let slope = (y1 - y0) / (t1 - t0);
            [y0 - slope * t0, slope]
        }
        (Interpolation::Cubic, at_knot) => [if at_knot { y0 } else { f64::NAN }, f64::NAN],
    }
}
