//! The start at rest compared with closed forms.

use crate::common::*;
use vibro_machine::description::*;
use vibro_machine::mode::{FrictionState, StopState};
use vibro_machine::{Assembly, Error};

/// Hundreds of roundings of numbers of order one.
const ROUNDING: f64 = 1e-13;
/// Error of a coordinate relative to the sum of the absolute elongations, as documented: thousands
/// of roundings.
const PLACE: f64 = 1e-12;

fn at_rest(d: Description) -> Description {
    Description { gravity: 10.0, starts_at_rest: true, ..d }
}

/// Requires that no body moves and no event occurs until a time.
fn stands(m: &mut vibro_machine::Motion, end: f64) {
    let free = |b: &Body| matches!(b.kind, BodyKind::Free(_));
    let bodies = &m.assembly().description.bodies;
    let places: Vec<usize> = (0..bodies.len()).filter(|&i| free(&bodies[i])).collect();
    let before: Vec<(usize, f64)> = places.into_iter().map(|i| (i, m.body(i)[0])).collect();
    let all = events(m, end);
    assert!(all.is_empty(), "{all:?}");
    for (i, s) in before {
        let [now, v, a] = m.body(i);
        // A stiff spring amplifies the rounding of the initial coordinates.
        assert!(
            (now - s).abs() < ROUNDING && v.abs() < 10.0 * ROUNDING && a.abs() < 1e2 * ROUNDING,
            "{i} {now} {v} {a}"
        );
    }
}

#[test]
fn closed_form_hanging_chain() {
    // Two masses on two springs: the upper spring carries both, the lower one its own mass.
    let d = Description {
        bodies: vec![heavy("a", 1.0, 1.0, 0.0, 0.0), heavy("b", 2.0, 1.0, 0.0, 0.0)],
        springs: vec![spring(&[(0, 1.0)], 300.0, 1.0), spring(&[(0, -1.0), (1, 1.0)], 1e5, 0.0)],
        ..Description::default()
    };
    let mut m = motion(at_rest(d));
    assert!((m.body(0)[0] - 0.1).abs() < ROUNDING && (m.body(1)[0] - 0.1 - 20.0 / 1e5).abs() < ROUNDING);
    stands(&mut m, 1.0);
}

#[test]
fn closed_form_preloaded_stops() {
    // A block pressed on a rigid stop by a preloaded spring; a second block on a rubber on the
    // first.
    let d = Description {
        bodies: vec![heavy("block", 1.0, 1.0, 0.0, 0.0), heavy("rider", 3.0, 1.0, 0.0, 0.0)],
        springs: vec![Spring { preload: -50.0, ..spring(&[(0, 1.0)], 100.0, 0.0) }],
        stops: vec![
            rigid("floor", &[(0, 1.0)], 0.2, 0.5),
            compliant("rubber", &[(0, -1.0), (1, 1.0)], -0.5, 1e3, 20.0, DampingLimit::NoPull),
            rigid("unused", &[(1, -1.0)], 4.0, 0.5),
        ],
        ..Description::default()
    };
    let mut m = motion(at_rest(d));
    // 50 N preload, 10 N and 30 N of weight, less 100 N/m * 0.2 m of the spring.
    assert!((m.stop(0)[2] - 70.0).abs() < 1e3 * ROUNDING, "{:?}", m.stop(0));
    assert!((m.stop(1)[2] - 30.0).abs() < 1e3 * ROUNDING, "{:?}", m.stop(1));
    assert_eq!(m.mode().stops, [StopState::Closed, StopState::Pressed, StopState::Open]);
    stands(&mut m, 1.0);
}

#[test]
fn closed_form_friction_holds_where_it_must() {
    // Friction alone carries the first block; the second hangs on a spring, and friction carries
    // nothing.
    let held = |level| Description {
        bodies: vec![heavy("held", 1.0, 1.0, 0.0, 0.0), heavy("hung", 1.0, 1.0, 0.0, 0.0)],
        springs: vec![spring(&[(1, 1.0)], 100.0, 0.0)],
        frictions: vec![
            Friction { static_force: Some(constant(12.0)), ..friction(&[(0, 1.0)], level) },
            friction(&[(1, 1.0)], 50.0),
        ],
        ..Description::default()
    };
    let mut m = motion(at_rest(held(10.5)));
    assert_eq!(m.body(0)[0], 0.0);
    assert!((m.friction(0)[2] - 10.0).abs() < ROUNDING * 100.0, "{:?}", m.friction(0));
    assert_eq!(m.mode().frictions, [FrictionState::Stuck; 2]);
    stands(&mut m, 1.0);
    // The static level alone holds the weight.
    stands(&mut motion(at_rest(held(9.0))), 1.0);
}

#[test]
fn closed_form_without_friction_where_there_is_a_spring() {
    let d = Description {
        bodies: vec![heavy("hung", 1.0, 1.0, 0.0, 0.0)],
        springs: vec![spring(&[(0, 1.0)], 100.0, 0.0)],
        frictions: vec![friction(&[(0, 1.0)], 50.0)],
        ..Description::default()
    };
    let mut m = motion(at_rest(d));
    assert!((m.body(0)[0] - 0.1).abs() < ROUNDING && m.friction(0)[2].abs() < 1e2 * ROUNDING);
    stands(&mut m, 1.0);
}

#[test]
fn no_equilibrium_is_refused_by_name() {
    let d = Description {
        bodies: vec![heavy("hung", 1.0, 1.0, 0.0, 0.0), heavy("loose", 1.0, 0.5, 0.0, 0.0)],
        springs: vec![spring(&[(0, 1.0)], 100.0, 0.0)],
        stops: vec![rigid("ceiling", &[(1, -1.0)], 1.0, 0.5)],
        frictions: vec![friction(&[(1, 1.0)], 4.0)],
        ..Description::default()
    };
    let refused = Assembly::new(at_rest(d)).unwrap_err();
    let Error::NoEquilibrium { body, acceleration, .. } = &refused else { panic!("{refused}") };
    assert!(body == "loose" && (acceleration - 1.0).abs() < 1e-6, "{refused}");
}

#[test]
fn closed_form_belt_rubs_a_body_at_rest() {
    let d = Description {
        bodies: vec![prescribed("belt", constant(0.0), 0.5), body("block", 1.0, 0.0, 0.0)],
        springs: vec![spring(&[(1, 1.0)], 200.0, 0.0)],
        frictions: vec![friction(&[(0, -1.0), (1, 1.0)], 4.0)],
        ..Description::default()
    };
    let mut m = motion(at_rest(d));
    assert!((m.body(1)[0] - 0.02).abs() < ROUNDING, "{:?}", m.body(1));
    stands(&mut m, 0.5);
}

/// Random numbers in [0, 1) from a seed (generator of Numerical Recipes).
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }

    fn power(&mut self, from: f64, to: f64) -> f64 {
        10f64.powf(from + (to - from) * self.next())
    }
}

/// A forest: each body hangs on ground or on an earlier body, under gravity or a load; stiffnesses
/// differ by up to 1e12, inertias by 1e11. Some springs are pressed buffers, or have a closed
/// rigid stop or friction in parallel that bears nothing. Returned with it are the coordinate of
/// each body and the sum of the absolute elongations between it and ground.
fn forest(random: &mut Random, count: usize) -> (Description, Vec<(f64, f64)>) {
    let mut d = Description::default();
    let (mut parents, mut stiffnesses, mut own) = (Vec::new(), Vec::new(), Vec::new());
    for i in 0..count {
        let parent = (i > 0 && random.next() < 0.8).then(|| (random.next() * i as f64) as usize);
        let (mass, stiffness) = (random.power(-8.0, 3.0), random.power(-1.0, 11.0));
        d.bodies.push(heavy(&format!("b{i}"), mass, 1.0, 0.0, 0.0));
        let mut force = 10.0 * mass;
        if random.next() < 0.5 {
            let push = random.power(-4.0, 3.0);
            force += push;
            d.loads.push(Load { name: format!("l{i}"), body: i, force: constant(push) });
        }
        let terms = parent.map_or(vec![(i, 1.0)], |p| vec![(p, -1.0), (i, 1.0)]);
        if random.next() < 0.3 {
            d.stops.push(compliant(&format!("k{i}"), &terms, 0.0, stiffness, 0.0, DampingLimit::NoPull));
        } else {
            d.springs.push(spring(&terms, stiffness, 0.0));
        }
        if random.next() < 0.2 {
            d.frictions.push(friction(&terms, 1e3));
        }
        parents.push(parent);
        stiffnesses.push(stiffness);
        own.push(force);
    }
    // Each spring carries the force on its body and on all bodies that hang on that body.
    let mut borne = own;
    for i in (0..count).rev() {
        if let Some(parent) = parents[i] {
            borne[parent] += borne[i];
        }
    }
    let mut places: Vec<(f64, f64)> = Vec::new();
    for i in 0..count {
        let e = borne[i] / stiffnesses[i];
        let (s, size) = parents[i].map_or((0.0, 0.0), |p| places[p]);
        places.push((s + e, size + e.abs()));
    }
    (at_rest(d), places)
}

#[test]
fn closed_form_forests_of_springs_whose_stiffnesses_are_far_apart() {
    let mut random = Random(44);
    for machine in 0..500 {
        let count = 1 + (random.next() * 12.0) as usize;
        let (d, places) = forest(&mut random, count);
        let found = Assembly::new(d).unwrap_or_else(|e| panic!("{machine}: {e}")).equilibrium().unwrap();
        for (i, (found, (s, size))) in found.iter().zip(&places).enumerate() {
            assert!((found - s).abs() <= PLACE * size, "{machine}.{i}: {found:e} instead of {s:e}");
        }
    }
}

#[test]
fn closed_form_a_sensor_on_a_stiff_spring_of_a_soft_one() {
    // Two springs in series with a stiffness ratio of 1e8 to 1e12; the sensor is on the stiff one,
    // which may also be a buffer.
    for stiff in [1e10, 1e12, 1e14] {
        for mass in [1e-8, 1e-3, 1.0] {
            for is_buffer in [false, true] {
                let mut d = Description {
                    bodies: vec![heavy("box", 1.0, 1.0, 0.0, 0.0), heavy("sensor", mass, 1.0, 0.0, 0.0)],
                    springs: vec![spring(&[(0, 1.0)], 100.0, 1.0)],
                    ..Description::default()
                };
                let terms = [(0, -1.0), (1, 1.0)];
                if is_buffer {
                    d.stops.push(compliant("buffer", &terms, 0.0, stiff, 0.0, DampingLimit::NoPull));
                } else {
                    d.springs.push(spring(&terms, stiff, 0.0));
                }
                let found = Assembly::new(at_rest(d.clone())).unwrap().equilibrium().unwrap();
                let s = 10.0 * (1.0 + mass) / 100.0;
                assert!((found[0] - s).abs() <= PLACE * s, "{stiff:e} {mass:e} {is_buffer}: {found:?}");
                assert!((found[1] - found[0]).abs() <= 10.0 * mass / stiff + PLACE * s, "{found:?}");
                // The error names the light body without support, however stiff the supports of
                // other bodies are.
                d.bodies.push(heavy("loose", 1e-8, 0.5, 0.0, 0.0));
                let refused = Assembly::new(at_rest(d)).unwrap_err();
                let Error::NoEquilibrium { body, acceleration, .. } = &refused else { panic!("{refused}") };
                assert!(body == "loose" && (acceleration - 5.0).abs() < 1e-6, "{refused}");
            }
        }
    }
}

#[test]
fn closed_form_a_belt_whose_speed_is_rounding_of_its_amplitude_does_not_rub() {
    // cos 90° is 6e-17 in doubles, and -1.8e-16 for 270°.
    for quarters in [1.0, 3.0, 5.0] {
        let d = Description {
            bodies: vec![
                prescribed("belt", sine(0.1, 2.0, quarters * std::f64::consts::FRAC_PI_2), 0.0),
                body("block", 1.0, 0.0, 0.0),
            ],
            springs: vec![spring(&[(1, 1.0)], 200.0, 0.0)],
            frictions: vec![friction(&[(0, -1.0), (1, 1.0)], 4.0)],
            ..Description::default()
        };
        assert_eq!(motion(at_rest(d)).body(1)[0], 0.0, "{quarters}");
    }
}

#[test]
fn closed_form_belts_that_move_rub_with_the_level_of_slipping_not_with_the_static_one() {
    // Up and down, with a static level three times as high; a second body is held by its static
    // level.
    for rate in [0.5, -0.5] {
        let d = Description {
            bodies: vec![
                prescribed("belt", constant(0.0), rate),
                body("block", 1.0, 0.0, 0.0),
                heavy("held", 1.0, 1.0, 0.0, 0.0),
            ],
            springs: vec![spring(&[(1, 1.0)], 200.0, 0.0)],
            frictions: vec![
                Friction { static_force: Some(constant(12.0)), ..friction(&[(0, -1.0), (1, 1.0)], 4.0) },
                Friction {
                    name: "holder".into(),
                    static_force: Some(constant(11.0)),
                    ..friction(&[(2, 1.0)], 9.0)
                },
            ],
            ..Description::default()
        };
        let m = motion(at_rest(d));
        assert!((m.body(1)[0] - rate.signum() * 0.02).abs() < ROUNDING, "{rate}: {:?}", m.body(1));
        assert_eq!(m.body(2)[0], 0.0);
    }
}

#[test]
fn closed_form_records_below_zero_that_a_lever_sets_against_each_other() {
    // b moves opposite to a, so that equal forces on both cancel. A third force of -6 N on a
    // stretches the spring of 50 N/m by -0.12 m. Absolute values count, not signs.
    let record = |force: f64| Signal {
        table: Some(Record::new(vec![(0.0, force), (2.0, force)], Interpolation::Straight)),
        ..Signal::default()
    };
    let load = |body: usize, force: f64| Load { name: "load".into(), body, force: record(force) };
    for size in [-27.0, 27.0, -2.7e6] {
        let d = Description {
            bodies: vec![body("a", 1.0, 0.0, 0.0), body("b", 1.0, 0.0, 0.0)],
            links: vec![Link { name: "l".into(), arms: arms(&[(0, 1.0), (1, 1.0)]) }],
            springs: vec![spring(&[(0, 1.0)], 50.0, 1.0)],
            loads: vec![load(0, size), load(1, size), load(0, -6.0)],
            ..Description::default()
        };
        let m = motion(at_rest(d));
        assert!((m.body(0)[0] + 0.12).abs() < ROUNDING * size.abs(), "{size}: {:?}", m.body(0));
        assert!((m.body(0)[0] + m.body(1)[0]).abs() < ROUNDING, "{size}: {:?}", m.body(1));
    }
}
