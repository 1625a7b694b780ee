//! The reference method compared with closed forms and the golden files of `tests/data`.
#![allow(missing_docs)]

mod common;

use common::golden::{distance, standard, table};
use std::f64::consts::TAU;
use vibro_impact::reference::{Reference, Tolerance};
use vibro_impact::simulator::{Contact, Event, Loads};
use vibro_impact::{Error, Parameters, State};

const TIGHT: Tolerance = Tolerance::new(1e-12);
/// Error after some thousand steps of 1e-12 each, for a motion that does not amplify errors.
const GLOBAL: f64 = 1e-9;

/// Free bodies: no springs, no drive.
fn free(restitution: f64) -> Parameters {
    Parameters {
        box_stiffness: 0.0,
        box_damping: 0.0,
        secondary_stiffness: 0.0,
        secondary_damping: 0.0,
        coupling_stiffness: 0.0,
        stop_restitution: restitution,
        drive_amplitude: 0.0,
        ..Parameters::default()
    }
}

fn events(reference: &mut Reference, end: f64) -> Vec<Event> {
    let mut events = Vec::new();
    reference.advance(end, &mut |event| events.push(*event)).unwrap();
    events
}

#[test]
fn closed_form_of_uncoupled_oscillators() {
    let p = Parameters {
        coupling_stiffness: 0.0,
        drive_amplitude: 0.02,
        drive_phase: 0.4,
        stop_gap: 10.0,
        ..Parameters::default()
    };
    let start = State { x: [0.3, 0.1, -0.7], v: [-0.2, 0.01, 0.5] };
    let end = 23.7;
    let mut reference = Reference::new(&p, &start, 0.0, TIGHT).unwrap();
    reference.advance_to(end).unwrap();

    // x = transient + Im(z e^{iωt}), z = F e^{iφ} / (k - mω² + icω).
    let damped = |x0: f64, v0: f64, m: f64, k: f64, c: f64, force: f64| {
        let (w, a) = (p.drive_frequency, c / (2.0 * m));
        let (re, im) = (k - m * w * w, c * w);
        let (size, lag) = (force / re.hypot(im), p.drive_phase - im.atan2(re));
        let own = (k / m - a * a).sqrt();
        let (b, d) = (x0 - size * lag.sin(), v0 - size * w * lag.cos());
        let e = (d + a * b) / own;
        let (s, q) = (own * end).sin_cos();
        let x = (-a * end).exp() * (b * q + e * s);
        let v = (-a * end).exp() * ((e * own - a * b) * q - (b * own + a * e) * s);
        (x + size * (w * end + lag).sin(), v + size * w * (w * end + lag).cos())
    };
    let (x1, v1) = damped(0.3, -0.2, p.box_mass, p.box_stiffness, p.box_damping, p.drive_amplitude);
    let (x3, v3) = damped(-0.7, 0.5, p.secondary_mass, p.secondary_stiffness, p.secondary_damping, 0.0);
    let expected = State { x: [x1, 0.1 + 0.01 * end, x3], v: [v1, 0.01, v3] };
    assert!(distance(&reference.state(), &expected, 1.0, 1.0) < GLOBAL);
}

#[test]
fn closed_form_of_free_bodies_momentum_and_restitution_at_each_impact() {
    let (p, kappa) = (free(0.6), 0.6);
    let start = State { x: [0.0, 0.0, 0.0], v: [0.25, 1.25, 0.0] };
    let mut reference = Reference::new(&p, &start, 0.0, TIGHT).unwrap();
    let momentum = 0.25 + 0.1 * 1.25;
    let (mut time, mut speed, mut side) = (1.0, 1.0, 1);
    for event in events(&mut reference, 60.0) {
        let Event::Impact { time: t, side: s, speed: v, impulse } = event else { panic!("{event:?}") };
        assert!((t - time).abs() < GLOBAL * (1.0 + time) / speed, "{t} {time}");
        assert_eq!(s, side);
        assert!((v - speed).abs() < GLOBAL);
        assert!((impulse - (1.0 + kappa) * 0.1 / 1.1 * speed).abs() < GLOBAL);
        speed *= kappa;
        time += 2.0 / speed;
        side = -side;
    }
    assert!(time > 60.0);
    assert_eq!(reference.impacts().upper + reference.impacts().lower, 5);
    let State { v, .. } = reference.state();
    assert!((v[0] + 0.1 * v[1] - momentum).abs() < GLOBAL);
    assert!(((v[1] - v[0]).abs() - speed).abs() < GLOBAL);
}

#[test]
fn closed_form_of_polynomial_loads_on_drifting_bodies() {
    let p = Parameters { stop_gap: 1e6, ..free(0.5) };
    let mut reference = Reference::new(&p, &State::default(), 5.0, TIGHT).unwrap();
    let d = [[0.1, -0.2, 0.3, 0.4], [0.01, 0.02, -0.03, 0.01], [0.0, 0.0, 0.05, -0.02]];
    reference.set_loads(&Loads { derivatives: d }).unwrap();
    reference.advance_to(8.0).unwrap();
    let t: f64 = 3.0;
    for (body, mass) in [p.box_mass, p.block_mass, p.secondary_mass].into_iter().enumerate() {
        let f = d[body];
        let x = t.powi(2) * (f[0] / 2.0 + t * (f[1] / 6.0 + t * (f[2] / 24.0 + t * f[3] / 120.0)));
        let v = t * (f[0] + t * (f[1] / 2.0 + t * (f[2] / 6.0 + t * f[3] / 24.0)));
        assert!((reference.state().x[body] - x / mass).abs() < GLOBAL);
        assert!((reference.state().v[body] - v / mass).abs() < GLOBAL);
    }
}

/// A block at rest on a box pulled by a constant force, which then reverses.
#[test]
fn closed_form_of_rest_and_release_under_loads() {
    let p = free(0.5);
    let start = State { x: [0.0, -1.0, 0.0], v: [0.0; 3] };
    let mut reference = Reference::new(&p, &start, 0.0, TIGHT).unwrap();
    // Force on the box 1 - t: pressed against the lower stop until t = 1, then released.
    reference.set_loads(&Loads { derivatives: [[1.0, -1.0, 0.0, 0.0], [0.0; 4], [0.0; 4]] }).unwrap();
    reference.advance_to(0.5).unwrap();
    assert_eq!(reference.contact(), Contact::RestLower);
    assert!((reference.contact_force() - 0.5 * 0.1 / 1.1).abs() < GLOBAL);
    let found = events(&mut reference, 2.0);
    let [Event::Release { time, side: -1 }] = found[..] else { panic!("{found:?}") };
    assert!((time - 1.0).abs() < GLOBAL);
    // v(1) = (1/2)/1.1; afterwards the box alone: x1'' = 1 - t.
    let v = 0.5 / 1.1;
    let x = (0.5 - 1.0 / 6.0) / 1.1;
    let expected = State { x: [x + v - 1.0 / 6.0, x + v - 1.0, 0.0], v: [v - 0.5, v, 0.0] };
    assert!(distance(&reference.state(), &expected, 1.0, 1.0) < GLOBAL);
}

#[test]
fn golden_standard_work_over_20_periods() {
    // The error is 1e-8 at the tolerance 1e-12; the block is less accurate between impacts.
    const AFTER_20: f64 = 1e-7;
    let (p, start) = standard();
    let mut reference = Reference::new(&p, &start, 0.0, TIGHT).unwrap();
    let mut found = Vec::new();
    for row in table("standard_double_periods.csv") {
        reference.advance(row.get("t"), &mut |event| found.push(*event)).unwrap();
        assert_eq!(found.len() as f64, row.get("impacts"));
        let error = distance(&reference.state(), &row.state(""), 1.0, 1.0);
        assert!(error < AFTER_20, "period {}: {error:e}", row.text("period"));
    }
    let golden = table("standard_double_impacts.csv");
    assert_eq!((found.len(), golden.len()), (50, 50));
    for (event, row) in found.iter().zip(&golden) {
        let Event::Impact { time, side, speed, impulse } = *event else { panic!("{event:?}") };
        assert_eq!(f64::from(side), row.get("side"));
        assert!((time - row.get("t")).abs() < AFTER_20 / row.get("speed"));
        assert!((speed - row.get("speed")).abs() < AFTER_20 / row.get("speed"));
        assert!((impulse - row.get("impulse")).abs() < AFTER_20 / row.get("speed"));
    }
}

/// The motion settles on the orbit of the standard work or on its mirror image, x → -x half a
/// period later. Rounding decides which, as errors grow 10⁹ times between periods 20 and 60.
#[test]
fn golden_standard_work_settles_on_the_certified_orbit_or_its_mirror() {
    const SETTLED: f64 = 1e-9;
    let certified = State {
        x: [-0.4253110842429075, 0.2872634800253607, 0.4900836440556809],
        v: [-0.7166788315354791, -1.2876764920670574, -0.3927812190837065],
    };
    let (p, start) = standard();
    let mut reference = Reference::new(&p, &start, 0.0, TIGHT).unwrap();
    reference.advance_to(700.0 * TAU).unwrap();
    let direct = distance(&reference.state(), &certified, 1.0, 1.0);
    reference.advance_to(700.5 * TAU).unwrap();
    let State { x, v } = reference.state();
    let mirror = State { x: x.map(|x| -x), v: v.map(|v| -v) };
    let error = direct.min(distance(&mirror, &certified, 1.0, 1.0));
    assert!(error < SETTLED, "{error:e}");
}

#[test]
fn golden_grazing_set() {
    // Error of w relative to L, from 1e-12 per step over up to 1.6 periods. It shifts an impact by
    // the error over the speed, and changes the velocities after it accordingly.
    const GAP_ERROR: f64 = 1e-10;
    let rows = table("grazing.csv");
    assert!(rows.len() > 400);
    for row in rows {
        let (p, t0, id) = (row.parameters(), row.get("t0"), row.text("id"));
        let mut reference = Reference::new(&p, &row.state(""), t0, TIGHT).unwrap();
        let found = events(&mut reference, row.get("t_end"));
        let speed = match found[..] {
            [] => {
                assert_eq!(row.get("contact"), 0.0, "row {id}: missed");
                p.stop_gap
            }
            [Event::Impact { time, side, speed, .. }] => {
                assert_eq!(row.get("contact"), 1.0, "row {id}: invented");
                assert_eq!(f64::from(side), row.get("side"));
                let error = (time - t0 - row.get("delay")).abs() * row.get("speed") / p.stop_gap;
                assert!(error < GAP_ERROR, "row {id}: {error:e}");
                speed
            }
            _ => panic!("row {id}: {found:?}"),
        };
        let rate = p.drive_frequency.max(1.0);
        let error = distance(&reference.state(), &row.state("e_"), p.stop_gap, p.stop_gap * rate);
        let allowed = GAP_ERROR * (1.0 + p.stop_gap * rate / speed);
        assert!(error < allowed, "row {id}: state {error:e}");
    }
}

#[test]
fn golden_chatter_set() {
    // A run that is closed at a rebound of 4e-12 L changes the state by that height, and a chatter
    // with kappa = 0.9 amplifies the error of its first impact.
    const AFTER_CHATTER: f64 = 1e-9;
    let rows = table("chatter.csv");
    assert!(rows.len() > 100);
    for row in rows {
        let (p, t0, id) = (row.parameters(), row.get("t0"), row.text("id"));
        let mut reference = Reference::new(&p, &row.state(""), t0, TIGHT).unwrap();
        let found = events(&mut reference, row.get("t_end"));
        let rest = row.get("mode") == 1.0;
        assert_eq!(reference.contact() != Contact::Flight, rest, "row {id}: {found:?}");
        let releases = found.iter().filter(|event| matches!(event, Event::Release { .. })).count();
        assert_eq!(releases, usize::from(!rest), "row {id}");
        for event in &found {
            match *event {
                Event::Rest { time, side } => {
                    assert_eq!(f64::from(side), row.get("side"));
                    // The run is closed before its last rebounds, each of about 1e-6/rate.
                    let early = (row.get("rest") - (time - t0)) * p.drive_frequency;
                    assert!((-1e-9..1e-3).contains(&early), "row {id}: {early:e}");
                }
                Event::Release { time, .. } => {
                    let error = (time - t0 - row.get("release")).abs() * p.drive_frequency;
                    assert!(error < AFTER_CHATTER, "row {id}: release {error:e}");
                }
                Event::Impact { .. } => {}
            }
        }
        let speed = p.stop_gap * p.drive_frequency;
        let error = distance(&reference.state(), &row.state("e_"), p.stop_gap, speed);
        assert!(error < AFTER_CHATTER, "row {id}: state {error:e}");
        let unit = p.block_mass * p.stop_gap * p.drive_frequency.powi(2);
        let error = (reference.contact_force() - row.get("force")).abs() / unit;
        assert!(error < AFTER_CHATTER, "row {id}: force {error:e}");
    }
}

#[test]
fn invariant_of_splitting_the_advance() {
    let (p, start) = standard();
    let mut whole = Reference::new(&p, &start, 0.0, TIGHT).unwrap();
    let mut parts = whole.clone();
    whole.advance_to(30.0).unwrap();
    for k in 1..=300 {
        parts.advance_to(f64::from(k) * 0.1).unwrap();
    }
    assert!(distance(&whole.state(), &parts.state(), 1.0, 1.0) < GLOBAL);
    assert_eq!(whole.time(), parts.time());
}

/// A pressed block with κ = 0 rests at once, and with κ = 1 bounces evenly without end.
#[test]
fn limits_of_restitution() {
    let loads = Loads { derivatives: [[0.0; 4], [0.1, 0.0, 0.0, 0.0], [0.0; 4]] };
    for (restitution, count) in [(0.0, 1), (1.0, 8)] {
        // An immovable box: the block falls with 1 m/s² from 0.5 m below the upper stop, with
        // contacts at t = 1, 3, 5, ...
        let p = Parameters { box_mass: 1e15, ..free(restitution) };
        let start = State { x: [0.0, 0.5, 0.0], v: [0.0; 3] };
        let mut reference = Reference::new(&p, &start, 0.0, TIGHT).unwrap();
        reference.set_loads(&loads).unwrap();
        reference.advance_to(16.0).unwrap();
        assert_eq!(reference.impacts().upper, count);
        assert_eq!(reference.contact() == Contact::RestUpper, restitution == 0.0);
    }
}

#[test]
fn errors_name_what_is_refused() {
    let (p, _) = standard();
    let new = |x2: f64, tolerance| {
        Reference::new(&p, &State { x: [0.0, x2, 0.0], v: [0.0; 3] }, 0.0, Tolerance::new(tolerance))
    };
    assert!(matches!(new(1.1, 1e-9), Err(Error::Penetration { .. })));
    assert!(matches!(new(f64::NAN, 1e-9), Err(Error::OutOfRange { name: "block.s", .. })));
    assert!(matches!(new(0.0, 0.5), Err(Error::OutOfRange { name: "tolerance.step", .. })));
    let mut reference = new(0.0, 1e-9).unwrap();
    assert!(matches!(reference.advance_to(-1.0), Err(Error::Step { .. })));
    assert!(matches!(reference.advance_to(f64::INFINITY), Err(Error::Step { .. })));
}
