use super::*;
use crate::tests::{OSCILLATOR, example, text};
use crate::{Machine, Start};

/// Tolerance for the rounding of some hundred stretches.
const ROUNDING: f64 = 1e-11;

fn started(machine: &Machine) -> Motion {
    machine.motion(&Start::default()).unwrap().0
}

/// An undamped oscillation at 20/s from 0.1 m.
fn swinging() -> Motion {
    started(&text(
        "name = \"S\"\n[body.a]\nmass = 2.0\nstart = { s = 0.1 }\n[spring.k]\nbetween = [\"ground\", \"a\"]\nstiffness = 800.0\n\
         [load.f]\non = \"a\"\namplitude = 0.0\nfrequency = 5.0\n",
    ))
}

fn flow_of(motion: &Motion) -> Arc<Flow> {
    Flows::default().of(motion.assembly().system(), motion.mode())
}

#[test]
fn closed_form_polynomials_and_their_turning_points() {
    let q = |low: &[f64]| {
        let mut q = [0.0; ORDERS];
        q[..low.len()].copy_from_slice(low);
        q
    };
    assert_eq!(value_at(&q(&[1.0, 2.0, 3.0]), 2.0), 17.0);
    assert_eq!(dot(&[1.0, 2.0], &[3.0, -4.0]), -5.0);
    let series = Series { size: 2, terms: vec![3.0, -4.0, 0.5, 1.0] };
    assert_eq!(coefficients(&[1.0, 2.0], &series)[..3], [-5.0, 2.5, 0.0]);
    for (low, expected) in [
        (&[2.0][..], &[(0.0, 2.0), (1.0, 2.0)][..]),
        (&[2.0, -1.0], &[(0.0, 2.0), (1.0, 1.0)]),
        (&[1.0, -4.0, 4.0], &[(0.0, 1.0), (0.5, 0.0), (1.0, 1.0)]),
        (&[-1.0, 4.0, -4.0], &[(0.0, -1.0), (0.5, 0.0), (1.0, -1.0)]),
        // (u - ¼)(u - ¾) is the slope.
        (&[0.0, 0.1875, -0.5, 1.0 / 3.0], &[(0.0, 0.0), (0.25, 1.0 / 48.0), (0.75, 0.0), (1.0, 1.0 / 48.0)]),
    ] {
        let (mut found, mut values) = (Vec::new(), Vec::new());
        turning_points(&q(low), &mut |u, x| found.push((u, x)));
        monotone_pieces(&q(low), &mut |x| values.push(x));
        assert_eq!(found.len(), expected.len(), "{low:?} {found:?}");
        for ((found, value), expected) in found.iter().zip(values).zip(expected) {
            assert!(
                (found.0 - expected.0).abs() < ROUNDING && (found.1 - expected.1).abs() < ROUNDING,
                "{low:?} {found:?}"
            );
            assert_eq!(value, found.1);
        }
    }
}

#[test]
fn closed_form_a_flight_is_an_oscillation_by_series_of_bounded_length() {
    let motion = swinging();
    let (flow, z) = (flow_of(&motion), motion.state().as_slice());
    assert!((flow.derivative(z)[1] + 40.0).abs() < ROUNDING);
    let rate = flow.rate_of(&[0.0, 1.0, 0.0, 0.0, 0.0]);
    assert!((rate[0] + 400.0).abs() < ROUNDING && rate[1].abs() < ROUNDING, "{rate:?}");
    for span in [1e-3, 0.05, 3.0] {
        let (mut time, mut count) = (0.0, 0);
        let end = flow.stretches(z, span, &mut |series, length| {
            let now = |u: f64| {
                (0.1 * (20.0 * (time + u * length)).cos(), -2.0 * (20.0 * (time + u * length)).sin())
            };
            for u in [0.0, 0.3, 1.0] {
                let at = |i: usize| series.terms().rev().fold(0.0, |sum, term| sum * u + term[i]);
                assert!(
                    (at(0) - now(u).0).abs() < ROUNDING && (at(1) - now(u).1).abs() < 20.0 * ROUNDING,
                    "{span} {time} {u}"
                );
            }
            (time, count) = (time + length, count + 1);
        });
        assert!((time - span).abs() < ROUNDING);
        assert_eq!(f64::from(count), flow.stretches_of(span));
        assert!((end[0] - 0.1 * (20.0 * span).cos()).abs() < ROUNDING, "{span}");
    }
    // A stretch is at most two inverses of the rate long, and a sub-step three. The rate is at
    // least 20/s.
    let steps = flow.sub_steps_of(30.0);
    assert!(steps >= 200.0 && flow.stretches_of(30.0) == (1.5 * steps).ceil(), "{steps}");
    assert_eq!(flow.stretches_of(1e-9), 1.0);
}

#[test]
fn second_method_variations_are_carried_by_a_matrix_as_each_by_its_series() {
    let motion = started(&text(OSCILLATOR));
    let flow = flow_of(&motion);
    let size = motion.state().len();
    let unit = |k: usize| (0..size).map(|i| f64::from(u8::from(i == k))).collect::<Vec<f64>>();
    // A few stretches, and more than are carried one by one.
    for span in [0.1, 6.0, 30.0] {
        let mut all = [unit(0), unit(1), motion.state().as_slice().to_vec()];
        let alone = all.clone().map(|v| flow.stretches(&v, span, &mut |_, _| ()));
        flow.carry(motion.state().as_slice(), &mut all, span);
        for (carried, alone) in all.iter().zip(&alone) {
            for (a, b) in carried.iter().zip(alone) {
                assert!((a - b).abs() <= ROUNDING * b.abs().max(1.0), "{span}: {a} {b}");
            }
        }
    }
    assert!(flow.stretches_of(0.1) <= MANY && flow.stretches_of(6.0) > MANY);
}

/// Observations of a motion.
#[derive(Default)]
struct Seen {
    time: f64,
    flights: u32,
    told: Vec<Event>,
    passed: Vec<Event>,
    lost: f64,
}

impl Observer for Seen {
    fn flight(&mut self, _: &System, flight: ObservedFlight<'_>) {
        assert!((flight.time - self.time).abs() < ROUNDING, "{} {}", flight.time, self.time);
        self.time = flight.time + flight.span;
        self.flights += 1;
        let end = flight.flow.stretches(flight.start, flight.span, &mut |_, _| ());
        assert!(end.iter().all(|x| x.is_finite()));
    }
    fn passage(&mut self, _: &System, passage: Passage<'_>) {
        assert!((passage.time - self.time).abs() < ROUNDING);
        assert!(
            passage.watch.is_none_or(|own| passage.flows[0].watched.iter().any(|(watch, _)| *watch == own))
        );
        self.passed.extend_from_slice(passage.events);
        self.lost += passage.lost;
    }
    fn told(&mut self, event: &Event) {
        self.told.push(event.clone());
    }
}

#[test]
fn second_method_flights_and_passages_are_the_engines_motion() {
    for name in ["damper_with_buffer.toml", "impact_pair.toml", "three_balls.toml", "brake_squeal.toml"] {
        let mut motion = started(&example(name));
        let mut by_engine = motion.clone();
        let mut events = Vec::new();
        by_engine.advance_observed(4.0, &mut |event| events.push(event.clone())).unwrap();
        let mut seen = Seen::default();
        let stopped =
            follow(&mut motion, &mut Flows::default(), 4.0, &mut [&mut seen], &mut |_| false).unwrap();
        assert!(
            !stopped && (motion.time() - 4.0).abs() < ROUNDING && (seen.time - 4.0).abs() < ROUNDING,
            "{name}"
        );
        assert_eq!((&seen.told, &seen.passed), (&events, &events), "{name}");
        let lost = by_engine.energy().impacts.value();
        assert!((seen.lost - lost).abs() <= ROUNDING * lost.abs(), "{name}");
        // Follows to the first requested event, and no further.
        let mut motion = started(&example(name));
        let times: Vec<f64> = events.chunk_by(|a, b| a.time == b.time).map(|now| now[0].time).collect();
        let mut count = 0;
        let mut last = |now: &[Event]| {
            count += usize::from(!now.is_empty());
            count == times.len().min(3)
        };
        assert!(follow(&mut motion, &mut Flows::default(), 20.0, &mut [], &mut last).unwrap(), "{name}");
        assert!((motion.time() - times[count - 1]).abs() < ROUNDING, "{name} {} {times:?}", motion.time());
    }
}

/// The row of a quantity in the current mode gives the same value as the motion, in flights, rests
/// and contacts.
#[test]
fn second_method_values_by_rows_are_the_columns_of_the_motion() {
    for name in [
        "damper_with_buffer.toml",
        "gear_backlash.toml",
        "brake_squeal.toml",
        "bouncing_ball.toml",
        "two_blocks.toml",
    ] {
        let mut motion = started(&example(name));
        let d = motion.assembly().description.clone();
        let mut flows = Flows::default();
        for k in 1..=60 {
            motion.advance_to(0.05 * f64::from(k)).unwrap();
            let columns = crate::values(&motion);
            for (quantity, value) in d.quantities().zip(columns) {
                let row = flow_of(&motion).row_of(motion.assembly().system(), quantity);
                let z = motion.state();
                let size: f64 = row.iter().zip(z.iter()).map(|(r, x)| (r * x).abs()).sum();
                let found = flows.value(&motion, quantity);
                assert!(
                    (found - value).abs() <= ROUNDING * size.max(1e-9),
                    "{name} {quantity:?}: {found} {value}"
                );
            }
        }
    }
}

/// Largest number of stretches of a flight that passes some edges: about ten between two edges, and some
/// tens that approach each edge.
const MOST_STRETCHES: usize = 400;

/// Four bodies with friction; the power of the first spring has its edge at e = 0.
const FOUR: &str = r#"
name = "R65"
body.b0 = { mass = 1.222, start = { s = 0.0008544, v = -0.5601 } }
body.b1 = { mass = 1.646, start = { s = -0.003414, v = 0.8536 } }
body.b2 = { mass = 2.565, start = { s = -0.003812, v = -0.5489 } }
body.b3 = { mass = 2.714, start = { s = -0.001972, v = -0.6063 } }
spring.s0 = { between = ["ground", "b0"], stiffness = 215.7, damping = 0.02287, preload = 0.0567, coefficient = 1605.0, exponent = 2.0 }
spring.s1 = { between = ["ground", "b1"], stiffness = 338.4, damping = 0.3451, preload = 0, quintic = 18440000.0 }
spring.s2 = { between = ["b0", "b1"], stiffness = 266.2, damping = 0.3176, force = "= 186.8*ln(1+132.1*e^2)*e" }
spring.s3 = { between = ["ground", "b2"], stiffness = 230.5, damping = 0.2095, force = "= 8.299*atan(18.08*e)" }
spring.s4 = { between = ["b1", "b2"], stiffness = 180.7, damping = 0.4301, preload = 0, cubic = -1990.0 }
spring.s5 = { between = ["ground", "b3"], stiffness = 249.1, damping = 0.07586, preload = 0 }
spring.s6 = { between = ["b2", "b3"], stiffness = 355.1, damping = 0.2428, force = "= 2.119*(exp(3.641*e)-1)" }
stop.h0 = { between = ["b2", "b1"], gap = 0.03401, stiffness = 41740.0, exponent = 1.5, dissipation = 0.1003 }
stop.w0 = { between = ["b3", "b0"], gap = 0.04894, restitution = 0.6773 }
stop.w1 = { between = ["b3", "b1"], gap = 0.03815, restitution = 0.6896 }
friction.f0 = { between = ["ground", "b0"], force = 1.149, static = 1.53, stribeck = 0.2227 }
friction.f1 = { between = ["ground", "b1"], force = 0.9467 }
load.l = { on = "b1", amplitude = 12.9, frequency = 1.451, phase = 0.2528 }
"#;

/// Stretches pass the edge of a power with the sign of e, at which series end, and reach the end of the
/// flight, also one that is a rounding away.
#[test]
fn invariant_stretches_pass_the_edge_of_a_power() {
    let mut motion = started(&text(FOUR));
    for k in 0..40 {
        motion.advance_to_event(3.0, &mut |_| ()).unwrap();
        for part in [0.3, 0.9, 0.999, 1.1] {
            let (flow, z, span) = (flow_of(&motion), motion.state().as_slice().to_vec(), 0.12198 * part);
            let (mut count, mut time) = (0, 0.0);
            flow.stretches(&z, span, &mut |_, length| {
                count += 1;
                time += length;
                assert!(count < MOST_STRETCHES, "{k} {time}");
            });
            assert!((time - span).abs() < ROUNDING, "{time}");
        }
    }
}

/// Two bodies, of which one slips with Stribeck's curve until it sticks.
const TWO: &str = r#"
name = "R82"
body.b0 = { mass = 2.423, start = { s = 0.02901, v = -0.4157 } }
body.b1 = { mass = 2.561, start = { s = -0.01922, v = -0.666 } }
spring.s0 = { between = ["ground", "b0"], stiffness = 141.2, damping = 0.4566, force = "= 110.5*ln(1+367.3*e^2)*e" }
spring.s1 = { between = ["ground", "b1"], stiffness = 195.6, damping = 0.3232, preload = 0, quadratic = -284.0, cubic = 181400.0, quartic = -4021.0, quintic = 33130000.0 }
spring.s2 = { between = ["b0", "b1"], stiffness = 387.3, damping = 0.02287, preload = 0, quadratic = 108.0, cubic = 161400.0, quartic = 2098.0, quintic = 17870000.0 }
stop.w1 = { between = ["b0", "b1"], gap = 0.0278, restitution = 0.627 }
friction.f0 = { between = ["ground", "b0"], force = 2.086, static = 3.811, stribeck = 0.1914 }
load.l = { on = "b0", amplitude = 10.3, frequency = 0.7904, phase = 2.338 }
"#;

/// Largest number of stretches of a slip; without an end at a rounding there are some 20,000, until
/// the time that is left underflows.
const MOST_OF_A_SLIP: usize = 2000;

/// A way of a rounding is left at the end of a slip: the highest terms of its series are too small
/// for a double.
#[test]
fn invariant_stretches_of_a_slip_end_with_it() {
    let mut motion = started(&text(TWO));
    for k in 0..30 {
        let (flow, z, begin) = (flow_of(&motion), motion.state().as_slice().to_vec(), motion.time());
        motion.advance_to_event(3.0, &mut |_| ()).unwrap();
        for part in [1.0, 1.0 - 1e-9, 0.9] {
            let mut count = 0;
            flow.stretches(&z, part * (motion.time() - begin), &mut |_, _| {
                count += 1;
                assert!(count < MOST_OF_A_SLIP, "{k} {part}");
            });
        }
    }
}

/// Output times next to the end of a slip are reached in as few steps as others.
#[test]
fn invariant_output_times_next_to_the_end_of_a_slip_are_reached() {
    const END: f64 = 0.6862;
    let mut motion = started(&text(TWO));
    (1..=500).for_each(|k| motion.advance_to(END * f64::from(k) / 500.0).unwrap());
    assert_eq!(motion.time(), END);
}

/// Stretches across the edge of a power, at which series end, end in the state of the motion.
#[test]
fn second_method_stretches_pass_the_edge_of_a_power() {
    let mut motion = started(&text(
        "name = \"E\"\nbody.a = { mass = 1.0, start = { s = 0.1, v = -1.0 } }\n\
         spring.k = { between = [\"ground\", \"a\"], coefficient = 40.0, exponent = 2.0 }\n\
         load.f = { on = \"a\", amplitude = 0.0, frequency = 5.0 }\n",
    ));
    let (flow, z, span) = (flow_of(&motion), motion.state().as_slice().to_vec(), 0.3);
    let mut count = 0;
    let end = flow.stretches(&z, span, &mut |_, _| {
        count += 1;
        assert!(count < MOST_STRETCHES);
    });
    motion.advance_to(span).unwrap();
    let off = end.iter().zip(motion.state().as_slice()).fold(0.0f64, |most, (a, b)| most.max((a - b).abs()));
    assert!(off < ROUNDING, "{off:e}");
}
