//! Signals against their definition, and signals carried along against signals at a time.

use super::*;
use crate::description::Interpolation;
use crate::description::{Harmonic, Record, Step};

/// Tolerance for values of order one, with phases of some tens of turns.
const ROUNDING: f64 = 1e-12;
/// Distance from a knot, s; and tolerance for the change over it, with slopes of some hundreds.
const BESIDE: f64 = 1e-9;
const ACROSS: f64 = 1e-6;

const KNOTS: [(f64, f64); 5] = [(0.5, 1.0), (0.75, -2.0), (1.5, -2.5), (2.0, 0.5), (3.0, 0.25)];

/// A signal with parts of every kind, its own rate and an input; and a signal of steps alone.
fn signals(interpolation: Interpolation) -> (Signals, Vec<DVector<f64>>) {
    let harmonic = |amplitude, frequency, phase| Harmonic { amplitude, frequency, phase };
    let step = |time, height| Step { time, height };
    let mut builder = Builder::new(4, Layout::default());
    let all = Signal {
        constant: 0.7,
        harmonics: vec![harmonic(2.0, 1.5, 0.4), harmonic(0.5, 3.0, -1.0), harmonic(1.0, 1.5, 2.0)],
        steps: vec![step(0.4, -0.8), step(1.1, 0.3)],
        table: Some(Record::new(KNOTS.to_vec(), interpolation)),
        repeat: None,
        sweeps: Vec::new(),
        input: true,
    };
    builder.add_motion(&Course { v: 0.6, ..Course::from(&all) });
    builder.add(&Signal { steps: vec![step(0.9, 5.0)], ..Signal::default() });
    builder.add_motion(&Course { v: -0.25, ..Course::from(&Signal::default()) });
    let (signals, rows) = builder.finish(0);
    (signals, rows.into_iter().map(|row| (*row).clone()).collect())
}

const INPUT: (f64, Input) = (0.2, [1.0, -0.5, 0.4, 0.9]);

fn at(signals: &Signals, time: f64) -> DVector<f64> {
    let mut z = DVector::zeros(signals.size);
    signals.fill(DoubleDouble::new(time), &[INPUT], z.as_mut_slice());
    z
}

#[test]
fn closed_form_each_part_of_a_signal_from_the_clock() {
    for (interpolation, word) in Interpolation::ALL {
        let (signals, rows) = signals(interpolation);
        assert_eq!((signals.inputs, signals.constant_size_until()), (1, 4 + 1 + 4));
        for time in [0.2, 0.4, 0.45, 0.5, 0.75, 1.1, 1.2, 1.5, 2.0, 2.5, 3.0, 7.0] {
            let z = at(&signals, time);
            let wave = |amplitude: f64, frequency: f64, phase: f64| {
                amplitude * (TAU * frequency * time + phase).sin()
            };
            let stepped = |from: f64, height: f64| if time >= from { height } else { 0.0 };
            let steps = stepped(0.4, -0.8) + stepped(1.1, 0.3);
            let dt = time - INPUT.0;
            let [a, b, c, d] = INPUT.1;
            let input = a + b * dt + c * dt.powi(2) / 2.0 + d * dt.powi(3) / 6.0;
            let own = wave(2.0, 1.5, 0.4) + wave(0.5, 3.0, -1.0) + wave(1.0, 1.5, 2.0);
            let known = 0.7 + own + steps + input + 0.6 * time;
            let table = rows[0].dot(&z) - known;
            let after = KNOTS.partition_point(|k| k.0 <= time);
            if after == 0 || after == KNOTS.len() || KNOTS[after - 1].0 == time {
                // At a knot: its value. Outside the record: the value of its first or last knot.
                let exact = KNOTS[after.max(1) - 1].1;
                assert!((table - exact).abs() < ROUNDING, "{word} {time}: {table}");
            } else if interpolation == Interpolation::Hold {
                assert!((table - KNOTS[after - 1].1).abs() < ROUNDING, "{time}: {table}");
            } else if interpolation == Interpolation::Straight {
                let ((t0, y0), (t1, y1)) = (KNOTS[after - 1], KNOTS[after]);
                let exact = y0 + (y1 - y0) * (time - t0) / (t1 - t0);
                assert!((table - exact).abs() < ROUNDING, "{time}: {table}");
            }
            assert_eq!(rows[1].dot(&z), if time >= 0.9 { 5.0 } else { 0.0 });
            assert!((rows[2].dot(&z) + 0.25 * time).abs() < ROUNDING);
        }
    }
}

#[test]
fn invariant_a_cubic_record_is_smooth_and_meets_its_knots_from_both_sides() {
    let table = Pieces::of_record(&Record::new(KNOTS.to_vec(), Interpolation::Cubic), 1.0, None);
    let slopes = vibro_numerics::monotone::monotone_slopes(&KNOTS);
    for (i, &(time, value)) in KNOTS.iter().enumerate() {
        for beside in [time - BESIDE, time + BESIDE] {
            let [y, slope, ..] = table.at(DoubleDouble::new(beside));
            assert!((y - value).abs() < ACROSS, "{beside}: {y}");
            let is_outside = beside < KNOTS[0].0 || beside > KNOTS[KNOTS.len() - 1].0;
            let exact = if is_outside { 0.0 } else { slopes[i] };
            assert!((slope - exact).abs() < ACROSS, "{beside}: {slope} {exact}");
        }
    }
}

#[test]
fn second_method_signals_carried_on_and_their_derivatives() {
    for (interpolation, word) in Interpolation::ALL {
        let (signals, rows) = signals(interpolation);
        // Between two knots, with no frequency turning by more than SMALL rad.
        for (time, dt) in [(0.55, 0.02), (0.8, 0.015), (1.7, 0.0201), (4.0, 0.021)] {
            let (from, exact) = (at(&signals, time), at(&signals, time + dt));
            let mut to = DVector::zeros(signals.size);
            signals.carry_within(from.as_slice(), dt, to.as_mut_slice());
            for j in signals.one..signals.size {
                let size = exact[j].abs().max(1.0);
                assert!(
                    (to[j] - exact[j]).abs() < ROUNDING * size,
                    "{word} {time} {j}: {} {}",
                    to[j],
                    exact[j]
                );
            }
            // A Taylor series of the signal from the rows of its derivatives.
            for row in &rows {
                let (mut derivative, mut sum, mut power) = (row.clone(), 0.0, 1.0);
                for k in 1..24 {
                    sum += power * derivative.dot(&from);
                    power *= dt / f64::from(k);
                    derivative = signals.derivative(&derivative);
                }
                assert!((sum - row.dot(&exact)).abs() < ROUNDING, "{word} {time}: {sum}");
            }
        }
        // All knots in order, each passed once.
        let (mut time, mut knots) = (0.0, Vec::new());
        while let Some(next) = signals.next_knot(time) {
            knots.push(next);
            time = next;
        }
        // A value held from before the first knot on is not a change.
        let first = if interpolation == Interpolation::Hold { &[0.4][..] } else { &[0.4, 0.5] };
        assert_eq!(knots, [first, &[0.75, 0.9, 1.1, 1.5, 2.0, 3.0]].concat());
        let first = signals.place_of_input(0).unwrap();
        assert_eq!((rows[0][first], signals.place_of_input(1)), (1.0, None));
    }
}
