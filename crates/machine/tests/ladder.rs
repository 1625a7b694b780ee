//! Long sub-steps miss no event: stiff machines compared with closed forms, and with the motion in
//! calls too short for long sub-steps.

use crate::common::*;
use vibro_machine::description::*;
use vibro_machine::motion::{Event, EventKind};

/// Hundreds of roundings of times of order one.
const ROUNDING: f64 = 1e-12;
/// Rounding amplified by the impacts of 2 s, none of them grazing.
const MAGNIFIED: f64 = 1e-6;

/// A body whose fast motion has decayed, but keeps ordinary sub-steps short.
fn decayed() -> (Body, Spring) {
    (body("fast", 1.0, 0.0, 0.0), spring(&[(0, 1.0)], 1e6, 1e3))
}

#[test]
fn closed_form_what_is_pushed_evenly_meets_its_stop_however_long_the_sub_steps_are() {
    // The bound of a parabola is its curvature; any smaller bound would let a long sub-step pass
    // the stop. The body moves away from the stop first, or towards it at once.
    let (fast, stiff) = decayed();
    for (speed, push) in [(0.0, 2.0), (-1.5, 2.0), (0.7, 0.5)] {
        for k in 1..40 {
            let gap = 0.013 * f64::from(k);
            let d = Description {
                bodies: vec![fast.clone(), body("pushed", 1.0, 0.0, speed)],
                springs: vec![stiff.clone()],
                stops: vec![rigid("stop", &[(1, 1.0)], gap, 0.0)],
                loads: vec![Load { name: "push".into(), body: 1, force: constant(push) }],
                ..Description::default()
            };
            // speed t + push t²/2 = gap
            let time = (-speed + (speed * speed + 2.0 * push * gap).sqrt()) / push;
            let met = times(&events(&mut motion(d), 4.0), |k| matches!(k, EventKind::Close { .. }));
            assert!(met.len() == 1 && (met[0] - time).abs() < ROUNDING, "{speed} {gap}: {met:?} not {time}");
        }
    }
}

/// Random numbers in [0, 1) from a seed (generator of Numerical Recipes).
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }

    fn between(&mut self, from: f64, to: f64) -> f64 {
        from + (to - from) * self.next()
    }
}

/// A slow body that carries a light one whose vibration decays, both driven, each with stops; and
/// the highest rate, rad/s.
fn ringing(random: &mut Random) -> (Description, f64) {
    let mass = random.between(0.02, 0.3);
    let rate = 10f64.powf(random.between(2.2, 3.2));
    let damping = 10f64.powf(random.between(-2.5, -0.2));
    let tie = spring(&[(0, -1.0), (1, 1.0)], mass * rate * rate, 2.0 * damping * mass * rate);
    let (slow, drive) = (random.between(5.0, 60.0), random.between(0.3, 1.5));
    let mut d = Description {
        bodies: vec![
            body("slow", 1.0, random.between(-0.1, 0.1), random.between(-0.5, 0.5)),
            body("light", mass, 0.0, random.between(-0.5, 0.5)),
        ],
        springs: vec![spring(&[(0, 1.0)], slow, random.between(0.0, 1.0)), tie],
        stops: vec![
            rigid("light", &[(1, 1.0)], random.between(0.1, 0.25), 0.6),
            rigid("slow", &[(0, -1.0)], random.between(0.1, 0.25), 0.6),
        ],
        loads: vec![
            Load { name: "drive".into(), body: 0, force: sine(random.between(1.0, 5.0), drive, 0.0) },
            Load { name: "second".into(), body: 1, force: sine(random.between(0.0, 2.0), 2.3 * drive, 1.0) },
        ],
        ..Description::default()
    };
    if random.next() < 0.4 {
        d.frictions.push(friction(&[(0, 1.0)], random.between(0.1, 2.0)));
    }
    (d, rate * ((1.0 + mass) / 1.0).sqrt())
}

#[test]
fn second_method_random_machines_that_ring_down_in_parts_too_short_for_long_sub_steps() {
    const MACHINES: usize = 120;
    const END: f64 = 2.0;
    let mut random = Random(15);
    let mut long_ones = 0;
    for machine in 0..MACHINES {
        let (d, rate) = ringing(&mut random);
        let (mut long, mut short) = (motion(d.clone()), motion(d));
        let all = events(&mut long, END);
        let mut theirs: Vec<Event> = Vec::new();
        // A sub-step is 3 over a rate that is at least the highest.
        let parts = (END * rate / 2.0).ceil();
        for k in 1..=parts as usize {
            let end = END * k as f64 / parts;
            short.advance_observed(end, &mut |e| theirs.push(e.clone())).unwrap();
        }
        for (a, b) in all.iter().zip(&theirs) {
            let same = std::mem::discriminant(&a.kind) == std::mem::discriminant(&b.kind);
            assert!(same && (a.time - b.time).abs() < MAGNIFIED, "{machine}: {a:?} {b:?}");
        }
        assert_eq!(all.len(), theirs.len(), "{machine}");
        for i in 0..2 {
            let (a, b) = (long.body(i), short.body(i));
            assert!((a[0] - b[0]).abs() < MAGNIFIED, "{machine}: {a:?} {b:?}");
        }
        long_ones += usize::from(all.len() < 40);
    }
    assert!(long_ones > MACHINES / 4, "{long_ones}");
}
