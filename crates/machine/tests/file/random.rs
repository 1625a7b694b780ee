//! Random valid machines.

use proptest::collection::vec;
use proptest::prelude::*;
use vibro_machine::Description;
use vibro_machine::description::*;

fn any_number() -> impl Strategy<Value = f64> {
    prop_oneof![
        proptest::num::f64::NORMAL | proptest::num::f64::SUBNORMAL | proptest::num::f64::ZERO,
        -10.0..10.0
    ]
}

fn positive() -> impl Strategy<Value = f64> {
    prop_oneof![proptest::num::f64::POSITIVE | proptest::num::f64::NORMAL, 1e-3..1e6].prop_map(f64::abs)
}

fn at_least(least: f64) -> impl Strategy<Value = f64> {
    positive().prop_map(move |x| x.max(least))
}

fn not_negative() -> impl Strategy<Value = f64> {
    any_number().prop_map(f64::abs)
}

/// Up to four distinct times in order, each with a value.
fn pairs(least: usize) -> impl Strategy<Value = Vec<(f64, f64)>> {
    vec((1e-9..10.0, any_number()), least..5).prop_map(|steps| {
        let mut time = -3.0;
        let after = |(step, value): (f64, f64)| {
            time += step;
            (time, value)
        };
        steps.into_iter().map(after).collect()
    })
}

const LAWS: [DampingLimit; 4] =
    [DampingLimit::NoPull, DampingLimit::Elastogap, DampingLimit::Pull, DampingLimit::UndampedRebound];

prop_compose! {
    fn harmonic()(amplitude in any_number(), frequency in at_least(1e-12), phase in any_number()) -> Harmonic {
        Harmonic { amplitude, frequency, phase }
    }
}

prop_compose! {
    fn sweep()(
        amplitude in any_number(),
        from in 1e-3..1e3_f64,
        to in 1e-3..1e3_f64,
        duration in 1e-3..10.0_f64,
        phase in any_number(),
        law in 0..2_usize,
    ) -> Sweep {
        Sweep { amplitude, from, to, duration, phase, law: SweepLaw::ALL[law].0 }
    }
}

prop_compose! {
    fn signal()(
        constant in any_number(),
        harmonics in vec(harmonic(), 0..3),
        sweeps in vec(sweep(), 0..3),
        steps in pairs(0),
        table in proptest::option::of((pairs(2), 0..3_usize, proptest::option::of(any_number()))),
        repeats in any::<bool>(),
        input in any::<bool>(),
    ) -> Signal {
        let steps = steps.into_iter().map(|(time, height)| Step { time, height }).collect();
        let record = |(knots, kind, scale): (_, usize, _)| Record { knots, scale, interpolation: Interpolation::ALL[kind].0 };
        let mut signal = Signal { constant, harmonics, sweeps, steps, table: table.map(record), repeat: None, input };
        if repeats && (!signal.steps.is_empty() || signal.table.is_some()) {
            signal.steps.iter_mut().for_each(|step| step.time += 3.0);
            signal.table.iter_mut().flat_map(|table| &mut table.knots).for_each(|knot| knot.0 += 3.0);
            signal.repeat = Some(50.0);
        }
        signal
    }
}

/// A signal, or a nonnegative number.
fn level() -> impl Strategy<Value = Signal> {
    let sound = |s: Signal| if s.is_constant() { Signal::constant(s.constant.abs()) } else { s };
    prop_oneof![signal().prop_map(sound), not_negative().prop_map(Signal::constant)]
}

prop_compose! {
    fn body()(
        rotation in any::<bool>(),
        prescribed in proptest::bool::weighted(0.2),
        inertia in positive(),
        gravity in -1.0..=1.0_f64,
        start in (any_number(), any_number()),
        motion in signal(),
        rate in any_number(),
        integrated in 0..3_u8,
    ) -> Body {
        let dimension = if rotation { Dimension::Rotation } else { Dimension::Translation };
        let gravity = if rotation { 0.0 } else { gravity };
        let kind = match prescribed {
            true if integrated > 0 => {
                let level = if integrated == 1 { Level::Rate } else { Level::Acceleration };
                let v = if integrated == 1 { 0.0 } else { start.1 };
                BodyKind::Integrated(Integrated { level, signal: motion, s: start.0, v })
            }
            true => BodyKind::Prescribed { motion, rate },
            false => BodyKind::Free(Free { inertia, gravity, s: start.0, v: start.1 }),
        };
        Body { name: String::new(), dimension, kind }
    }
}

/// Ingredients of an elongation: whether by levers, dimension, two body indices and two arms.
type Raw = (bool, bool, usize, usize, [f64; 2]);

/// A stop's elongation, gap, rigidity, restitution, stiffness, damping, and whether it is clipped.
type RawStop = (Raw, f64, bool, f64, f64, f64, bool);

fn raw_arms() -> impl Strategy<Value = Raw> {
    let arm = || any_number().prop_filter("an arm is not zero", |arm| *arm != 0.0);
    (any::<bool>(), any::<bool>(), 0..100_usize, 0..100_usize, [arm(), arm()])
}

fn arms_of(bodies: &[Body], (levers, rotation, a, b, arms): Raw) -> Arms {
    let (a, b) = (a % bodies.len(), b % bodies.len());
    if levers {
        let dimension = if rotation { Dimension::Rotation } else { Dimension::Translation };
        let terms = if a == b { vec![(a, arms[0])] } else { vec![(a, arms[0]), (b, arms[1])] };
        return Arms { terms, dimension, levers };
    }
    let dimension = bodies[a].dimension;
    let other = Some(b).filter(|&b| b != a && bodies[b].dimension == dimension);
    if rotation { Arms::between(Some(a), other, dimension) } else { Arms::between(other, Some(a), dimension) }
}

prop_compose! {
    /// A valid machine: a spring on every body, links between bodies at rest at zero, rigid stops
    /// that the start does not violate.
    pub fn machine()(
        mut bodies in vec(body(), 1..6),
        gravity in not_negative(),
        starts_at_rest in any::<bool>(),
        springs in vec((raw_arms(), not_negative(), not_negative(), any_number()), 6),
        stops in vec((raw_arms(), any_number(), any::<bool>(), 0.0..=1.0_f64, not_negative(), not_negative(), any::<bool>()), 0..4),
        frictions in vec((raw_arms(), level(), proptest::option::of(level())), 0..3),
        loads in vec((0..100_usize, signal()), 0..3),
    ) -> Description {
        let free = Free { inertia: 1.5, gravity: 0.0, s: 0.25, v: -1.0 };
        bodies[0].kind = BodyKind::Free(free);
        for (i, body) in bodies.iter_mut().enumerate() {
            body.name = format!("body_{i}");
            if let (true, BodyKind::Free(free)) = (starts_at_rest, &mut body.kind) {
                (free.s, free.v) = (0.0, 0.0);
            }
        }
        let spring = |(i, (mut raw, stiffness, damping, preload)): (usize, (Raw, f64, f64, f64))| {
            raw.2 = i;
            let (name, arms) = (format!("spring_{i}"), arms_of(&bodies, raw));
            Spring { name, arms, stiffness, stepped: None, damping, preload, curve: Default::default(), power: None, force: None, across: None, points: Vec::new(), series: None }
        };
        let springs = springs.into_iter().enumerate().map(spring).collect();
        let stop = |(i, (raw, gap, rigid, restitution, stiffness, damping, clipped)): (usize, RawStop)| {
            let limit = LAWS[2 * (i % 2) + usize::from(clipped)];
            let arms = arms_of(&bodies, raw);
            // Starts at rigid stops are tested elsewhere.
            let rigid = rigid && starts_at_rest;
            let law = if rigid { StopLaw::Rigid { restitution } } else { StopLaw::Compliant { stiffness, damping, limit } };
            Stop { name: format!("stop_{i}"), arms, gap, law, stepped: None, contact: None }
        };
        let stops = stops.into_iter().enumerate().map(stop).collect();
        let friction = |(i, (raw, force, static_force)): (usize, (Raw, Signal, Option<Signal>))| {
            let low = |level: &Signal| level.is_constant() && force.is_constant() && level.constant < force.constant;
            let static_force = static_force.filter(|level| !low(level));
            Friction { name: format!("friction_{i}"), arms: arms_of(&bodies, raw), force, static_force, follows: None, stribeck: None, viscous: None }
        };
        let frictions = frictions.into_iter().enumerate().map(friction).collect();
        let load = |(i, (body, force)): (usize, (usize, Signal))| {
            let body = body % bodies.len();
            let body = if matches!(bodies[body].kind, BodyKind::Free(_)) { body } else { 0 };
            Load { name: format!("load_{i}"), body, force }
        };
        let loads = loads.into_iter().enumerate().map(load).collect();
        let free = bodies.iter().filter(|b| matches!(b.kind, BodyKind::Free(_))).count();
        let link = Link { name: "link_0".into(), arms: Arms { terms: vec![(0, 0.75)], dimension: Dimension::Translation, levers: true } };
        let links = if free > 1 && starts_at_rest { vec![link] } else { Vec::new() };
        Description { name: "Random".into(), gravity, starts_at_rest, bodies, springs, stops, frictions, links, loads, ..Description::default() }
    }
}
