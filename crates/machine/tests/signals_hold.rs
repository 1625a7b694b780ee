//! Records with values held from knot to knot, and their scale, compared with closed forms,
//! differences and the same machine with steps.

use crate::common::*;
use std::fmt::Write;
use std::sync::Arc;
use vibro_machine::file::{no_records, parse};
use vibro_machine::motion::EventKind;
use vibro_machine::{Assembly, Differentiated};

/// Roundings of sums of some thousands of numbers of order one.
const ROUNDING: f64 = 1e-11;
/// Step of central differences, whose error is proportional to its square.
const CHANGE: f64 = 1e-5;
const DIFFERENCE: f64 = 1e-7;

/// Pseudo-random numbers in [-1, 1].
fn noise(count: usize) -> Vec<f64> {
    let mut seed = 1_u64;
    let mut next = || {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (seed >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    };
    (0..count).map(|_| next()).collect()
}

fn table(values: &[f64], step: f64) -> String {
    let mut list = String::new();
    for (i, value) in values.iter().enumerate() {
        let _ = write!(list, "[{:?}, {value:?}], ", step * i as f64);
    }
    list
}

#[test]
fn closed_form_a_mass_under_a_held_force_is_piecewise_parabolic() {
    let (values, step) = (noise(2000), 1.0 / 1024.0);
    let list = table(&values, step);
    let mut m = moving(&format!(
        "name = \"Held\"\n[body.b]\nmass = 2.0\n[load.l]\non = \"b\"\ntable = [{list}]\ninterpolation = \"hold\"\n"
    ));
    let (mut s, mut v) = (0.0, 0.0);
    for (i, force) in values.iter().enumerate() {
        let (a, dt) = (force / 2.0, 0.3 * step);
        // Within the interval, and at its end.
        m.advance_to(step * i as f64 + dt).unwrap();
        near(m.body(0)[0], s + v * dt + 0.5 * a * dt * dt, ROUNDING);
        near(m.body(0)[2], a, ROUNDING);
        (s, v) = (s + v * step + 0.5 * a * step * step, v + a * step);
    }
    m.advance_to(step * 2000.0).unwrap();
    near(m.body(0)[0], s, ROUNDING);
    near(m.body(0)[1], v, ROUNDING);
}

#[test]
fn closed_form_the_value_at_a_knot_is_the_new_one_and_equal_neighbours_are_no_event() {
    let mut m = moving(
        "name = \"Held\"\n[body.b]\nmass = 1.0\n[load.l]\non = \"b\"\n\
         table = [[0.5, 1.0], [1.0, 1.0], [1.5, 3.0], [2.0, 3.0], [2.5, 3.0]]\ninterpolation = \"hold\"\n",
    );
    assert_eq!(m.body(0)[2], 1.0, "before the first knot its value holds");
    let all = events(&mut m, 1.5);
    assert_eq!(m.body(0)[2], 3.0);
    let all = [all, events(&mut m, 4.0)].concat();
    assert_eq!(times(&all, |kind| *kind == EventKind::Knot), [1.5]);
    near(m.body(0)[1], 1.5 + 2.5 * 3.0, ROUNDING);
}

/// A held record is the sum of steps at its knots, with impacts, friction and a drive.
#[test]
fn second_method_a_held_record_is_a_sum_of_steps() {
    let (values, step) = (noise(300), 0.01);
    let machine = |signal: &str| {
        moving(&format!(
            "name = \"Rig\"\n[body.b]\nmass = 1.0\n[spring.k]\nbetween = [\"ground\", \"b\"]\nstiffness = 100.0\n\
             [stop.r]\nbetween = [\"ground\", \"b\"]\ngap = 0.004\nrestitution = 0.6\n\
             [friction.f]\nbetween = [\"ground\", \"b\"]\nforce = 0.2\n[load.l]\non = \"b\"\n{signal}\n"
        ))
    };
    let mut held = machine(&format!("table = [{}]\ninterpolation = \"hold\"", table(&values, step)));
    let mut steps = String::new();
    for (i, pair) in values.windows(2).enumerate() {
        let _ = write!(steps, "[{:?}, {:?}], ", step * (i + 1) as f64, pair[1] - pair[0]);
    }
    let mut stepped = machine(&format!("constant = {:?}\nsteps = [{steps}]", values[0]));
    let (one, other) = (events(&mut held, 3.0), events(&mut stepped, 3.0));
    assert!(one.len() >= 400, "{}", one.len());
    assert_eq!(one.len(), other.len());
    for (a, b) in one.iter().zip(&other) {
        assert_eq!(std::mem::discriminant(&a.kind), std::mem::discriminant(&b.kind));
        near(a.time, b.time, ROUNDING);
    }
    near(held.body(0)[0], stepped.body(0)[0], ROUNDING);
}

/// The machine for the tests of the scale.
fn scaled(interpolation: &str, scale: &str) -> Assembly {
    let toml = format!(
        "name = \"Scaled\"\n[body.b]\nmass = 1.0\n[spring.k]\nbetween = [\"ground\", \"b\"]\nstiffness = 40.0\n\
         damping = 0.5\n[stop.r]\nbetween = [\"ground\", \"b\"]\ngap = 0.02\nrestitution = 0.6\n[load.l]\non = \"b\"\n\
         table = [[0.1, 0.0], [0.3, 1.0], [0.8, 0.25], [1.1, -0.5]]\ninterpolation = \"{interpolation}\"\nscale = \"{scale}\"\n"
    );
    Assembly::new(parse(&toml, "scaled.toml", &no_records).unwrap_or_else(|e| panic!("{e}"))).unwrap()
}

#[test]
fn second_method_a_scale_multiplies_the_record_and_has_a_derivative() {
    const SCALE: &str = "load.l.table.scale";
    for interpolation in ["straight", "cubic", "hold"] {
        let assembly = Arc::new(scaled(interpolation, "3 N"));
        assert_eq!(assembly.description.get(SCALE).unwrap(), 3.0);
        let end = |scale: f64| {
            let mut m = motion(assembly.description.with([(SCALE, scale)]).unwrap());
            m.advance_to(2.0).unwrap();
            m.body(0)
        };
        let mut varied = Differentiated::new(assembly.clone(), &[SCALE]).unwrap();
        varied.advance_to(2.0).unwrap();
        let found = varied.state_derivative(0).unwrap();
        let (more, less) = (end(3.0 + CHANGE), end(3.0 - CHANGE));
        for (k, found) in found.iter().enumerate() {
            near(*found, (more[k] - less[k]) / (2.0 * CHANGE), DIFFERENCE);
        }
        // A record in newtons with a factor of 1 is unchanged.
        let mut own = assembly.description.clone();
        let table = own.loads[0].force.table.as_mut().unwrap();
        table.scale = None;
        table.knots.iter_mut().for_each(|knot| knot.1 *= 3.0);
        let mut own = motion(own);
        own.advance_to(2.0).unwrap();
        assert_eq!(own.body(0), end(3.0));
    }
}

#[test]
fn invariant_what_is_refused_of_scale_and_interpolation() {
    let refused = |signal: &str| {
        let toml = format!("name = \"R\"\n[body.b]\nmass = 1.0\n[load.l]\non = \"b\"\n{signal}\n");
        parse(&toml, "r.toml", &no_records).unwrap_err().to_string()
    };
    assert_eq!(
        refused("table = [[0, \"1 N\"], [1, 2]]\nscale = 2.0"),
        "r.toml:6: load.l.table[0,1] = \"1 N\": cannot have a unit; expected a number"
    );
    assert_eq!(
        refused("constant = 1.0\nscale = 2.0"),
        "r.toml:7: load.l.scale = 2.0: requires `table`, the record to multiply"
    );
    assert_eq!(
        refused("table = [[0, 1], [1, 2]]\nscale = \"2 m\""),
        "r.toml:7: load.l.scale = \"2 m\": cannot be in `m`; expected one of N, mN, kN, MN, lbf"
    );
    assert_eq!(
        refused("table = [[0, 1], [1, 2]]\ninterpolation = \"held\""),
        "r.toml:7: load.l.interpolation = \"held\": expected \"straight\", \"cubic\" or \"hold\""
    );
}

/// The cost of finding and passing a knot does not grow with the number of knots.
#[test]
fn many_held_knots_cost_their_events_alone() {
    let time = |count: usize| {
        let list = table(&noise(count), 1e-3);
        let start = moving(&format!(
            "name = \"Held\"\n[body.b]\nmass = 2.0\n[spring.k]\nbetween = [\"ground\", \"b\"]\nstiffness = 1e3\n\
             [load.l]\non = \"b\"\ntable = [{list}]\ninterpolation = \"hold\"\n"
        ));
        // The minimum of several rounds, because other programs run too.
        let rounds = (0..5).map(|_| {
            let (mut m, began) = (start.clone(), std::time::Instant::now());
            m.advance_to(1e-3 * count as f64).unwrap();
            began.elapsed().as_secs_f64()
        });
        rounds.fold(f64::INFINITY, f64::min) / count as f64
    };
    // Twenty times as many knots; a search over all of them would take twenty times as long.
    let (few, many) = (time(1250), time(25_000));
    assert!(many < 5.0 * few, "{many} s a knot beside {few} s");
}
