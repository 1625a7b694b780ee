//! Places and rates at time 0.

use super::{Arms, BodyKind, Description, Integrated, Interpolation, Level, Record, Signal};
use std::f64::consts::TAU;

/// Coordinate and rate of each body at time 0.
pub(crate) fn starts(machine: &Description) -> Vec<[f64; 2]> {
    let own: Vec<_> = machine.bodies.iter().map(|b| start(&b.kind)).collect();
    let of_node = |row: &[(usize, f64)]| [0, 1].map(|k| row.iter().map(|term| term.1 * own[term.0][k]).sum());
    let starts = machine.bodies.iter().zip(&own);
    starts.map(|(b, own)| if let BodyKind::Node(row) = &b.kind { of_node(row) } else { *own }).collect()
}

/// Elongation and rate of an element at time 0.
pub(crate) fn start_of(machine: &Description, arms: &Arms) -> [f64; 2] {
    let all = starts(machine);
    [0, 1].map(|which| elongation(arms, &all, which).0)
}

/// An elongation (`which` 0) or its rate (1) at the start, and the sum of its terms' sizes.
pub(crate) fn elongation(arms: &Arms, starts: &[[f64; 2]], which: usize) -> (f64, f64) {
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
