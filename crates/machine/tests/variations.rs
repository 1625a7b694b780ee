//! Variations through events compared with closed forms and with differences of motions.

use std::path::Path;
use std::sync::Arc;
use vibro_machine::motion::Reached;
use vibro_machine::{Assembly, Motion, file};

fn motion(text: &str) -> Motion {
    let machine = file::parse(text, "machine.toml", &file::no_records).unwrap();
    Motion::new(Arc::new(Assembly::new(machine).unwrap())).unwrap()
}

/// The variations at `end` with respect to the initial states and inputs, through every event.
fn varied(motion: &mut Motion, end: f64) -> Vec<Vec<f64>> {
    let mut variations = motion.unit_variations();
    while motion.advance_with(end, &mut variations).unwrap() == Reached::Event {}
    motion.pass_event_with(&mut variations).unwrap();
    variations
}

#[test]
fn closed_form_a_ball_that_falls_on_a_floor() {
    // Roundings of a state of the size 10.
    const ROUNDING: f64 = 1e-13;
    let text = "name = \"Ball\"\ngravity = 10.0\n[body.ball]\nmass = 2.0\ngravity = 1.0\nstart = { v = 1.0 }\n\
                [stop.floor]\nbetween = [\"ground\", \"ball\"]\ngap = 4.0\nrestitution = 0.5\n\
                [load.push]\non = \"ball\"\ninput = true\n";
    let (h, v0, g, e, m, end) = (4.0_f64, 1.0_f64, 10.0_f64, 0.5, 2.0, 1.0);
    let variations = varied(&mut motion(text), end);
    // It meets the floor at speed u after t: dt/ds(0) = -1/u, dt/dv(0) = -t/u; the derivatives of
    // u follow from energy.
    let u = (v0 * v0 + 2.0 * g * h).sqrt();
    let t = (u - v0) / g;
    let left = end - t;
    let after = |dt: f64, du: f64| {
        // s = h - e u (T - t) + g (T - t)²/2
        let ds = -e * du * left + e * u * dt - g * left * dt;
        let dv = -e * du - g * dt;
        [ds, dv]
    };
    let by_s = after(-1.0 / u, -g / u);
    let by_v = after(-t / u, v0 / u);
    // A constant force F adds F/m to g.
    let (dt_g, du_g) = (-0.5 * t * t / u, t - 0.5 * g * t * t / u);
    let mut by_g = after(dt_g, du_g);
    by_g[0] += 0.5 * left * left;
    by_g[1] += left;
    let by_f = by_g.map(|x| x / m);
    for (k, expected) in [by_s, by_v, by_f].iter().enumerate() {
        for i in 0..2 {
            let found = variations[k][i];
            assert!((found - expected[i]).abs() < ROUNDING, "{k} {i}: {found} {}", expected[i]);
        }
    }
}

#[test]
fn closed_form_friction_that_comes_to_rest_keeps_no_rate() {
    // Stops after v m/F at s = v² m/(2F).
    let text = "name = \"Sled\"\n[body.sled]\nmass = 2.0\nstart = { v = 3.0 }\n\
                [friction.ground]\nbetween = [\"ground\", \"sled\"]\nforce = 4.0\n";
    let variations = varied(&mut motion(text), 5.0);
    assert_eq!([variations[0][0], variations[0][1]], [1.0, 0.0]);
    assert!((variations[1][0] - 3.0 * 2.0 / 4.0).abs() < 1e-14 && variations[1][1].abs() < 1e-15);
}

#[test]
fn closed_form_what_a_closed_stop_holds_does_not_vary() {
    // Both bodies continue together; momentum is conserved.
    let text = "name = \"Pair\"\n[body.a]\nmass = 1.0\nstart = { v = 2.0 }\n[body.b]\nmass = 3.0\n\
                [stop.bump]\nbetween = [\"b\", \"a\"]\ngap = 1.0\nrestitution = 0.0\n\
                [load.push]\non = \"a\"\nconstant = 4.0\n";
    let (a, m, end) = (4.0_f64, 1.0, 3.0);
    let variations = varied(&mut motion(text), end);
    // Derivatives by the speed v of a, with t from 1 = v t + a t²/2.
    let v = 2.0_f64;
    let u = (v * v + 2.0 * a).sqrt();
    let t = (u - v) / a;
    let (dt, du) = (-t / u, v / u);
    // Common speed after the impact: V = u m/4 + (end - t) a/4; b is 1 behind a.
    let both = du * m / 4.0 - dt * a / 4.0;
    let left = end - t;
    let place = du * m / 4.0 * left - dt * (u * m / 4.0 + a / 4.0 * left);
    for (k, expected) in [place, place, both, both].iter().enumerate() {
        let found = variations[2][k];
        assert!((found - expected).abs() < 1e-13, "{k}: {found} {expected}");
    }
}

/// Error of a fourth-order difference relative to a column's largest entry: fourth power of the
/// step, and rounding over the step.
const DIFFERENCE: f64 = 2e-5;

/// A ball of mass 1 at speed u hits the first of two touching balls at rest. Both stops take part:
/// P = (4/3, 2/3) u for ε = 1 and equal masses, by (A7), so that the speeds are -u/3, 2u/3, 2u/3.
#[test]
fn closed_form_a_ball_that_hits_two_that_touch() {
    // Roundings of a few operations; a difference quotient would have 1e-10.
    const ROUNDING: f64 = 1e-14;
    let text = "name = \"Three\"\n[body.a]\nmass = 1.0\nstart = { v = 1.0 }\n[body.b]\nmass = 1.0\n[body.c]\nmass = 1.0\n\
                [stop.ab]\nbetween = [\"b\", \"a\"]\ngap = 0.5\nrestitution = 1.0\n\
                [stop.bc]\nbetween = [\"c\", \"b\"]\ngap = 0.0\nrestitution = 1.0\n";
    let mut three = motion(text);
    let mut variations = varied(&mut three, 2.0);
    let speeds = [-1.0 / 3.0, 2.0 / 3.0, 2.0 / 3.0];
    assert!((0..3).all(|i| (three.rate(i) - speeds[i]).abs() < ROUNDING));
    // For the rate of a, the impact is at time 0.5/u at a fixed position; all speeds scale with u.
    let by_rate = variations.swap_remove(3);
    for i in 0..3 {
        let place = speeds[i] * (1.5 + 0.5);
        assert!((by_rate[3 + i] - speeds[i]).abs() < ROUNDING, "{i}: {}", by_rate[3 + i]);
        assert!((by_rate[i] - place).abs() < ROUNDING, "{i}: {} {place}", by_rate[i]);
    }
}

#[test]
fn second_method_the_examples_against_differences_of_motions() {
    for (name, end, events, step) in [
        ("bouncing_ball", 3.0, 2, 2e-5),
        ("paper_machine", 12.0, 3, 2e-5),
        // Friction comes to rest within micrometres of the buffer: the step must be small.
        ("damper_with_buffer", 0.5, 10, 5e-7),
        ("msl_elastogap", 3.0, 2, 2e-5),
        // The flanks amplify a rounding of the angles by 4e4/s in the velocities: the step must be
        // large.
        ("gear_backlash", 0.03, 4, 1e-4),
        ("msl_coupled_clutches", 1.3, 4, 2e-5),
        ("two_blocks", 0.1, 1, 2e-5),
    ] {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/assembly").join(name);
        let machine = file::read(&path.with_extension("toml")).unwrap();
        let assembly = Arc::new(Assembly::new(machine.clone()).unwrap());
        let n = assembly.states().len();
        // Coordinates and rates by body.
        let start = Motion::new(assembly.clone()).unwrap();
        let starts: Vec<_> =
            (0..machine.bodies.len()).map(|i| (start.coordinate(i), start.rate(i))).collect();
        let mut met = 0;
        let mut plain = start.clone();
        plain.advance_observed(end, &mut |_| met += 1).unwrap();
        assert!(met >= events, "{name}: {met} events");
        let exact = varied(&mut start.clone(), end);
        for (k, varied) in exact[..2 * n].iter().enumerate() {
            let body = assembly.states()[k % n];
            let value = if k < n { starts[body].0 } else { starts[body].1 };
            let scale = value.abs().max(1e-2);
            let at = |places: f64| {
                let mut starts = starts.clone();
                let shift = places * step * scale;
                if k < n {
                    starts[body].0 += shift
                } else {
                    starts[body].1 += shift
                }
                let shifted = Assembly::new(machine.clone()).unwrap().starting_from(starts);
                let mut motion = Motion::new(Arc::new(shifted)).unwrap();
                motion.advance_to(end).unwrap();
                motion.states().to_vec()
            };
            let [a, b, c, d] = [-2.0, -1.0, 1.0, 2.0].map(at);
            let largest = varied[..2 * n].iter().fold(0.0_f64, |most, x| most.max(x.abs()));
            for i in 0..2 * n {
                let difference = (8.0 * (c[i] - b[i]) - (d[i] - a[i])) / (12.0 * step * scale);
                let error = (varied[i] - difference).abs();
                assert!(
                    error <= DIFFERENCE * largest.max(1.0),
                    "{name}: state {i} by {k}: {} {difference} of {largest}",
                    varied[i]
                );
            }
        }
    }
}
