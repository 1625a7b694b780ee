//! Random machines.

use super::*;
use proptest::prelude::*;

fn inertia() -> impl Strategy<Value = f64> {
    (-2.0..2.0f64).prop_map(|x| 10f64.powf(x))
}

/// A number from a short list, so that events coincide, or any number.
fn nice(range: f64) -> impl Strategy<Value = f64> {
    prop_oneof![Just(0.0), Just(range), Just(-range), Just(0.5 * range), -range..range]
}

fn signal(size: f64) -> impl Strategy<Value = Signal> {
    let step = prop::option::of((0.0..2.0f64, nice(size)));
    (nice(size), nice(size), 0.2..3.0f64, 0.0..6.2f64, step, record(size)).prop_map(
        |(constant, amplitude, frequency, phase, step, table)| Signal {
            constant,
            harmonics: if amplitude == 0.0 { vec![] } else { vec![Harmonic { amplitude, frequency, phase }] },
            steps: step.map(|(time, height)| Step { time, height }).into_iter().collect(),
            table,
            ..Signal::default()
        },
    )
}

/// A record through a few knots, in one signal of five.
fn record(size: f64) -> impl Strategy<Value = Option<Record>> {
    let knots = prop::collection::vec((0.1..1.0f64, nice(size)), 2..5);
    prop::option::weighted(0.2, (knots, any::<bool>())).prop_map(|record| {
        record.map(|(steps, cubic)| {
            let mut time = 0.0;
            let knots = steps.into_iter().map(|(dt, value)| {
                time += dt;
                (time, value)
            });
            let kind = if cubic { Interpolation::Cubic } else { Interpolation::Straight };
            Record::new(knots.collect(), kind)
        })
    })
}

/// Between a body and the previous one, or the ground.
fn place(bodies: usize) -> impl Strategy<Value = Vec<(usize, f64)>> {
    (0..bodies, 0..=bodies, any::<bool>()).prop_map(move |(a, b, turned)| {
        let sign = if turned { -1.0 } else { 1.0 };
        if a == b || b == bodies { vec![(a, sign)] } else { vec![(a, -sign), (b, sign)] }
    })
}

/// A machine of one to six bodies, sometimes of up to twelve; sometimes with a wheel linked to the
/// first body.
pub fn assembly() -> impl Strategy<Value = Description> {
    let count = prop_oneof![4 => 1usize..=6, 1 => 7usize..=11];
    let wheel = prop::option::weighted(0.3, (inertia(), prop_oneof![-3.0..-0.3f64, 0.3..3.0f64]));
    (count.prop_flat_map(machine), wheel).prop_map(|(mut d, wheel)| {
        if let (Some((m, ratio)), BodyKind::Free(first)) = (wheel, d.bodies[0].kind.clone()) {
            let count = d.bodies.len();
            d.bodies.push(body("wheel", m, first.s / ratio, first.v / ratio));
            d.links.push(Link { name: "gear".into(), arms: arms(&[(0, 1.0), (count, -ratio)]) });
        }
        d
    })
}

fn machine(count: usize) -> impl Strategy<Value = Description> {
    {
        let bodies = prop::collection::vec((inertia(), nice(1.0), nice(1.0), nice(1.0)), count);
        let springs = prop::collection::vec(
            (place(count), 0.0..3.0f64, prop_oneof![Just(0.0), 0.0..2.0f64]),
            1..=count + 1,
        );
        let stops = prop::collection::vec(
            (
                place(count),
                nice(1.0),
                prop_oneof![Just(0.0), Just(1.0), Just(0.5), 0.0..1.0f64],
                0..4u8,
                1.0..4.0f64,
                0.0..5.0f64,
            ),
            0..=4,
        );
        let frictions =
            prop::collection::vec((place(count), signal(1.0), prop::option::of(1.0..1.5f64)), 0..=3);
        let loads = prop::collection::vec((0..count, signal(3.0)), 1..=2);
        (bodies, springs, stops, frictions, loads, nice(9.81)).prop_map(
            move |(bodies, springs, stops, frictions, loads, gravity)| {
                let mut d = Description { gravity, ..Description::default() };
                for (i, (m, cosine, s, v)) in bodies.into_iter().enumerate() {
                    d.bodies.push(heavy(&format!("b{i}"), m, cosine, s, v));
                }
                for (arms, exponent, damping) in springs {
                    d.springs.push(spring(&arms, 10f64.powf(exponent), damping));
                }
                for (terms, gap, restitution, kind, exponent, damping) in stops {
                    let e: f64 = terms
                        .iter()
                        .map(
                            |&(i, arm)| {
                                if let BodyKind::Free(f) = d.bodies[i].kind { arm * f.s } else { 0.0 }
                            },
                        )
                        .sum();
                    let name = format!("stop{}", d.stops.len());
                    d.stops.push(match kind {
                        0 | 1 => rigid(&name, &terms, gap.max(e), restitution),
                        2 => {
                            compliant(&name, &terms, gap, 10f64.powf(exponent), damping, DampingLimit::NoPull)
                        }
                        _ => compliant(
                            &name,
                            &terms,
                            gap,
                            10f64.powf(exponent),
                            damping,
                            DampingLimit::Elastogap,
                        ),
                    });
                }
                for (terms, level, ratio) in frictions {
                    let mut own = friction(&terms, 0.0);
                    own.static_force = ratio.map(|r| scaled(&level, r));
                    own.force = level;
                    d.frictions.push(own);
                }
                for (body, force) in loads {
                    d.loads.push(Load { name: "load".into(), body, force });
                }
                d
            },
        )
    }
}

/// A signal times a number.
pub fn scaled(signal: &Signal, ratio: f64) -> Signal {
    let mut other = signal.clone();
    other.constant *= ratio;
    other.harmonics.iter_mut().for_each(|h| h.amplitude *= ratio);
    other.steps.iter_mut().for_each(|s| s.height *= ratio);
    other.table.iter_mut().flat_map(|t| &mut t.knots).for_each(|k| k.1 *= ratio);
    other
}

/// A block on a belt, which sticks, slips and hits a wall.
pub const BLOCK_ON_BELT: &str = r#"
    name = "BlockOnBelt"
    [body.block]
    mass = "2 kg"
    [body.belt]
    motion = { rate = "0.3 m/s" }
    [spring.guide]
    between = ["ground", "block"]
    stiffness = "800 N/m"
    [friction.belt]
    between = ["belt", "block"]
    force = "3 N"
    [stop.wall]
    between = ["ground", "block"]
    gap = "2 mm"
    restitution = 0.6
    [load.shaker]
    on = "block"
    amplitude = "4 N"
    frequency = "5 Hz"
"#;
