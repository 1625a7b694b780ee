//! Events of a single element, which are handled directly, compared with the general law.

use crate::common::both_laws::{BothLaws, on_machines};
use crate::common::machines::assembly;
use crate::common::{machine, moving};
use std::cell::Cell;
use std::sync::Arc;
use vibro_machine::motion::EventKind;
use vibro_machine::{Assembly, Differentiated};

/// Difference of the two solutions relative to the largest coordinate: rounding of an impulse,
/// amplified by the ratio of the heaviest to the lightest mass, 1e4.
const ROUNDING: f64 = 1e-12;
const BOTH: BothLaws = BothLaws { events: 300, end: 4.0, rounding: ROUNDING };

#[test]
fn second_method_events_of_one_element_by_the_general_law() {
    let [events, same] = [Cell::new(0), Cell::new(0)];
    on_machines(&assembly(), 300, |start| {
        BOTH.follow(start, |handled| {
            events.set(events.get() + 1);
            same.set(same.get() + usize::from(handled.direct.save() == handled.general.save()));
            Ok(())
        })
    });
    println!("{} of {} events without a bit of difference", same.get(), events.get());
    assert!(events.get() > 3000, "{}", events.get());
}

/// A box that a record drives, with a block between a rigid stop and a buffer with friction. The
/// record has knots at equal intervals.
fn driven(interval: f64) -> String {
    let force = |t: f64| 60.0 * (20.0 * t).sin() + 25.0 * (53.0 * t).cos();
    // Straight between knots 20 ms apart; further knots lie on the line.
    let straight = |t: f64| {
        let from = (t / 0.02 + 1e-9).floor();
        let part = t / 0.02 - from;
        (1.0 - part) * force(0.02 * from) + part * force(0.02 * (from + 1.0))
    };
    let knots = (0..=(2.0 / interval).round() as u32).map(|k| f64::from(k) * interval);
    let knots: Vec<String> = knots.map(|t| format!("[{t:?}, {:?}]", straight(t))).collect();
    format!(
        "name = \"Driven\"\n\
         body.box = {{ mass = 5.0 }}\n\
         body.block = {{ mass = 0.8 }}\n\
         spring.mount = {{ between = [\"ground\", \"box\"], stiffness = 9e3, damping = 20.0 }}\n\
         stop.steel = {{ between = [\"box\", \"block\"], gap = 2e-3, restitution = 0.6 }}\n\
         stop.buffer = {{ between = [\"block\", \"box\"], gap = 1e-3, stiffness = 5e4, damping = 30.0 }}\n\
         friction.guide = {{ between = [\"box\", \"block\"], force = 0.4 }}\n\
         load.shaker = {{ on = \"box\", table = [{}] }}\n",
        knots.join(", ")
    )
}

#[test]
fn second_method_knots_by_the_general_law_bit_for_bit() {
    let [knots, sticks] = [Cell::new(0), Cell::new(0)];
    let most = BothLaws { events: 3000, end: 2.0, rounding: 0.0 };
    let look = |handled: crate::common::both_laws::Handled| {
        if handled.observed.iter().any(|event| event.kind == EventKind::Knot) {
            knots.set(knots.get() + 1);
            sticks.set(sticks.get() + u32::from(handled.before.contacts().next().is_some()));
            assert!(handled.direct.save() == handled.general.save(), "at {}", handled.direct.time());
        }
        Ok(())
    };
    // Impulses differ by rounding.
    BothLaws { rounding: ROUNDING, ..most }.follow(moving(&driven(1e-3)), look).unwrap();
    // Most knots come while the block slides between its stops, some while it is held.
    assert!(knots.get() > 1500 && sticks.get() > 10, "{} {}", knots.get(), sticks.get());
}

/// Difference of derivatives, relative to their size: rounding of two thousand flights, amplified
/// by impacts.
const CARRIED: f64 = 1e-8;

#[test]
fn invariant_knots_on_a_straight_line_change_no_derivative() {
    let names = ["stop.steel.gap", "stop.steel.restitution", "stop.buffer.stiffness", "friction.guide.force"];
    let [few, many] = [0.02, 1e-3].map(|interval| {
        let assembly = Arc::new(Assembly::new(machine(&driven(interval))).unwrap());
        let mut motion = Differentiated::new(assembly, &names).unwrap();
        motion.advance_to(0.5).unwrap();
        (0..names.len()).map(|p| motion.state_derivative(p).unwrap()).collect::<Vec<_>>()
    });
    for ((a, b), name) in few.iter().zip(&many).zip(names) {
        let size = a.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
        assert!(size > 0.0, "{name} moves nothing");
        assert!(a.iter().zip(b).all(|(x, y)| (x - y).abs() < CARRIED * size), "{name}: {a:?} {b:?}");
    }
}
