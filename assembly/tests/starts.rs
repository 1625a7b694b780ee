//! Starts from a state: a motion continues from its own state, and bad states are refused.

use std::sync::Arc;
use vibro_assembly::motion::Event;
use vibro_assembly::{Assembly, Error, Motion};

/// Rounding of a state times the growth of errors over the time compared.
const ROUNDING: f64 = 1e-10;

const MACHINE: &str = r#"
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

fn machine() -> Arc<Assembly> {
    let description = vibro_assembly::file::parse(MACHINE, "block.toml", &vibro_assembly::file::no_records);
    Arc::new(Assembly::new(description.unwrap()).unwrap())
}

#[test]
fn invariant_a_motion_continues_from_its_own_state() {
    let assembly = machine();
    for time in [0.0, 0.017, 0.11, 0.2, 0.3141] {
        let mut motion = Motion::new(assembly.clone()).unwrap();
        motion.advance_to(time).unwrap();
        let state = &motion.state().as_slice()[..2 * assembly.system().coordinates];
        let mut again = Motion::from_state(assembly.clone(), motion.time(), state).unwrap();
        assert_eq!(again.mode(), motion.mode(), "at {time} s");
        let (mut events, mut later) = (Vec::new(), Vec::new());
        let named = |event: &Event| (std::mem::discriminant(&event.kind), event.time);
        motion.advance_observed(time + 0.5, &mut |event| events.push(named(event))).unwrap();
        again.advance_observed(time + 0.5, &mut |event| later.push(named(event))).unwrap();
        assert!(events.len() > 2 && events.len() == later.len(), "from {time} s");
        for (one, other) in events.iter().zip(&later) {
            assert!(one.0 == other.0 && (one.1 - other.1).abs() < ROUNDING, "from {time} s");
        }
        assert!((motion.state() - again.state()).amax() < ROUNDING, "from {time} s");
    }
}

#[test]
fn bad_states_are_refused_by_name() {
    let refused = |state: &[f64]| Motion::from_state(machine(), 0.0, state).unwrap_err();
    let Error::OutOfRange { name, .. } = refused(&[0.0]) else { panic!("length") };
    assert_eq!(name, "length of the start");
    let Error::OutOfRange { name, .. } = refused(&[0.0, f64::NAN]) else { panic!("number") };
    assert_eq!(name, "start of body.block.v");
    let Error::Violated { stop, excess, .. } = refused(&[3e-3, 0.0]) else { panic!("stop") };
    assert_eq!(stop, "stop.wall");
    assert!((excess - 1e-3).abs() < 1e-15);
    assert!(Motion::from_state(machine(), f64::INFINITY, &[0.0, 0.0]).is_err());
}
