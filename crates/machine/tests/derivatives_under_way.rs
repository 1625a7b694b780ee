//! Derivatives of the rest of a motion, from a time during the motion; partial derivatives.

use crate::common::machines::BLOCK_ON_BELT;
use std::sync::Arc;
use vibro_machine::derivative::By;
use vibro_machine::motion::Reached;
use vibro_machine::{Assembly, Differentiated, Motion, Quantity, Start, What, file};

/// Rounding of derivatives after some events, relative to their size.
const ROUNDING: f64 = 1e-12;

fn machine() -> Arc<Assembly> {
    let description = file::parse(BLOCK_ON_BELT, "block.toml", &file::no_records).unwrap();
    Arc::new(Assembly::new(description).unwrap())
}

/// A motion's derivatives from now on equal the derivatives of a motion that starts in its state.
#[test]
fn second_method_derivatives_from_now_on_are_those_from_the_state() {
    let columns = ["spring.guide.stiffness", "stop.wall.gap", "load.shaker.frequency", "body.block.mass"];
    for time in [0.017, 0.2] {
        let mut motion = Motion::new(machine()).unwrap();
        motion.advance_to(time).unwrap();
        let start = Start::of(&motion);
        let state = start.state(&machine()).unwrap();
        let mut other = Differentiated::from_state(machine(), time, &state, &columns).unwrap();
        let mut own = Differentiated::from_motion(motion, &columns).unwrap();
        other.advance_to(time + 0.15).unwrap();
        // Event by event.
        let mut events = 0;
        while own.advance_before_event(time + 0.15).unwrap() == Reached::Event {
            own.apply_event(&mut |_, _| events += 1).unwrap();
        }
        assert!(events > 1, "{events}");
        for quantity in machine().description.quantities() {
            for (p, name) in columns.iter().enumerate() {
                let (a, b) = (own.derivative(quantity, p), other.derivative(quantity, p));
                let near = a.zip(b).is_some_and(|(a, b)| (a - b).abs() <= ROUNDING * (1.0 + a.abs()));
                assert!(near, "{quantity:?} by {name}: {a:?} {b:?} {:?}", own.lost(p));
            }
        }
    }
}

#[test]
fn closed_form_partial_derivatives_at_a_fixed_state() {
    let mut motion = Motion::new(machine()).unwrap();
    let (time, stiffness) = (0.017, "spring.guide.stiffness".to_owned());
    motion.advance_to(time).unwrap();
    let s = motion.body(0)[0];
    let columns =
        [By::Parameter(stiffness), By::Parameter("load.shaker.amplitude".into()), By::Time, By::Start(0)];
    let partial = Differentiated::at_fixed_state(motion.clone(), &columns).unwrap();
    let (a, angle) = (Quantity::of_body(0, What::A), std::f64::consts::TAU * 5.0 * time);
    let rate = 4.0 * std::f64::consts::TAU * 5.0 * angle.cos() / 2.0;
    let exact = [-s / 2.0, angle.sin() / 2.0, rate, -400.0];
    // It slips, so that friction is constant.
    assert!(motion.mode().frictions[0].direction() != 0.0);
    for (p, exact) in exact.into_iter().enumerate() {
        let found = partial.derivative(a, p).unwrap();
        assert!((found - exact).abs() < ROUNDING * (1.0 + exact.abs()), "{:?}: {found} {exact}", columns[p]);
    }
    assert_eq!(partial.derivative(Quantity::of_body(0, What::S), 0), Some(0.0));
    assert!(Differentiated::at_fixed_state(motion, &["stop.wal.gap"]).is_err());
}
