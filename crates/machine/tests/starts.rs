//! Starts from a state: a motion continues from its own state, and invalid states are refused.

use crate::common::machines::BLOCK_ON_BELT;
use std::sync::Arc;
use vibro_machine::derivative::By;
use vibro_machine::motion::Event;
use vibro_machine::{Assembly, Error, Motion, Start, file};

/// Rounding of a state times the growth of errors over the compared time.
const ROUNDING: f64 = 1e-10;

fn machine() -> Arc<Assembly> {
    let description =
        vibro_machine::file::parse(BLOCK_ON_BELT, "block.toml", &vibro_machine::file::no_records);
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

/// A pinion that drives a wheel with a stop; the engine's motion is prescribed.
const GEARS: &str = r#"
    name = "Gears"
    [body.engine]
    motion = { rate = "10 rad/s" }
    [body.pinion]
    inertia = "0.1 kg m2"
    start = { v = "10 rad/s" }
    [body.wheel]
    inertia = "0.4 kg m2"
    start = { v = "-5 rad/s" }
    [link.mesh]
    arms = { pinion = "5 cm", wheel = "10 cm" }
    [spring.shaft]
    between = ["engine", "pinion"]
    stiffness = "50 N m/rad"
    [stop.peg]
    between = ["ground", "pinion"]
    gap = "2 rad"
    restitution = 0.5
"#;

fn described(text: &str) -> vibro_machine::Description {
    file::parse(text, "machine.toml", &file::no_records).unwrap()
}

#[test]
fn invariant_a_start_is_written_and_read_with_all_digits() {
    for (text, time) in [(BLOCK_ON_BELT, 0.3141), (GEARS, 0.1)] {
        let assembly = Arc::new(Assembly::new(described(text)).unwrap());
        let mut motion = Motion::new(assembly.clone()).unwrap();
        motion.advance_to(time).unwrap();
        let start = Start::of(&motion);
        let again = Start::parse(&start.to_toml(), "start.toml", &assembly.description).unwrap();
        assert_eq!(again, start);
        let state = &motion.state().as_slice()[..2 * assembly.system().coordinates];
        assert_eq!(again.state(&assembly).unwrap(), state);
        // Numbers by name, one at a time.
        let mut named = Start::default();
        for (name, value) in start.numbers() {
            named.set(&assembly.description, &name, value).unwrap();
        }
        assert_eq!(named, start);
        assert_eq!(Start::try_from(String::from(start.clone())), Ok(start.clone()));
        let begun = again.motion(assembly).unwrap();
        assert_eq!((begun.time(), begun.mode()), (motion.time(), motion.mode()));
    }
}

#[test]
fn what_a_start_does_not_name_is_the_machines_own() {
    let d = described(GEARS);
    let assembly = Arc::new(Assembly::new(d.clone()).unwrap());
    let start = Start::parse("time = 0.5\nbody.pinion.s = \"90 deg\"", "start.toml", &d).unwrap();
    let motion = start.motion(assembly.clone()).unwrap();
    let quarter = std::f64::consts::FRAC_PI_2;
    assert_eq!((motion.time(), motion.body(1)[0], motion.body(1)[1]), (0.5, quarter, 10.0));
    // Links hold, and the engine has its prescribed angle at that time.
    assert!((motion.body(2)[0] + quarter / 2.0).abs() < ROUNDING && motion.body(0)[0] == 5.0);
    assert_eq!(
        Start::default().motion(assembly.clone()).unwrap().state(),
        Motion::new(assembly).unwrap().state()
    );
    // A machine that starts at rest has the same equilibrium at another time.
    let at_rest = described(
        "name = \"Rest\"\ngravity = 10.0\nstart = \"rest\"\n[body.a]\nmass = 2.0\ngravity = 1.0\n\
         [body.b]\nmass = 1.0\n[spring.a]\nbetween = [\"ground\", \"a\"]\nstiffness = 800.0\n\
         [spring.b]\nbetween = [\"ground\", \"b\"]\nstiffness = 800.0\n",
    );
    let mut start = Start::default();
    start.set_text(&at_rest, "b.s", "5 mm").unwrap();
    let motion = start.motion(Arc::new(Assembly::new(at_rest).unwrap())).unwrap();
    assert!((motion.body(0)[0] - 0.025).abs() < ROUNDING && motion.body(1)[0] == 0.005);
}

#[test]
fn what_is_no_start_is_refused_by_name() {
    let d = described(GEARS);
    let assembly = Arc::new(Assembly::new(d.clone()).unwrap());
    let told = |name: &str, value: &str| Start::default().set_text(&d, name, value).unwrap_err().to_string();
    for (name, value, expected) in [
        ("pinon.s", "1", "pinon.s: no start value has this name; did you mean `pinion.s`?"),
        ("pinion.a", "1", "pinion.a: no start value has this name; expected one of pinion.s, pinion.v"),
        ("engine.s", "1", "engine.s: its motion is prescribed; use start values of pinion, wheel"),
        ("pinion.s", "1 mm", "pinion.s = \"1 mm\": cannot be in `mm`; expected one of rad, mrad, deg, °"),
        ("time", "1 m", "time = \"1 m\": cannot be in `m`; expected one of s, ms, us, min, h"),
    ] {
        assert_eq!(told(name, value), expected);
    }
    let refused = |name: &str, value: f64| {
        let mut start = Start::default();
        start.set(&d, name, value).unwrap();
        let Error::Refused(refusal) = start.motion(assembly.clone()).unwrap_err() else { panic!("{name}") };
        refusal.to_string()
    };
    assert_eq!(
        refused("wheel.v", 1.0),
        "wheel.v = 1.0: links determine it from `pinion`; use start values of pinion"
    );
    assert_eq!(
        refused("pinion.s", 3.0),
        "stop.peg.gap = 2.0 rad: e - gap = 1.0 rad at the start, t = 0.0 s; a rigid stop requires e <= gap: change the start, or increase the gap"
    );
    assert!(Start::default().set(&d, "pinion.s", f64::NAN).is_err());
    let file = "tme = 1\n[body.pinon]\ns = 1.0\n[body.engine]\ns = 1.0\n[body.wheel]\ns = \"1 m\"\nx = 1.0\n";
    assert_eq!(
        Start::parse(file, "s.toml", &d).unwrap_err().to_string(),
        "s.toml:1: tme = 1: no such key; did you mean `time`?\n\
         s.toml:2: body.pinon: no body has this name; did you mean `pinion`?\n\
         s.toml:4: body.engine: its motion is prescribed; use a body with mass or inertia\n\
         s.toml:7: body.wheel.s = \"1 m\": cannot be in `m`; expected one of rad, mrad, deg, °\n\
         s.toml:8: body.wheel.x = 1.0: no such key; expected one of s, v"
    );
}

/// A block at rest under friction, with a rate of the size that rounding leaves at standstill.
#[test]
fn invariant_a_rate_of_rounding_is_rest() {
    let text = BLOCK_ON_BELT.replace("0.3 m/s", "0.0 m/s").replace("4 N", "1 N");
    let description = vibro_machine::file::parse(&text, "block.toml", &vibro_machine::file::no_records);
    let assembly = Arc::new(Assembly::new(description.unwrap()).unwrap());
    for rate in [0.0, 1e-32, -1e-20] {
        let mut motion = Motion::from_state(assembly.clone(), 0.0, &[1e-4, rate]).unwrap();
        assert!(motion.mode().frictions[0].sticks(), "v = {rate}");
        motion.advance_observed(1.0, &mut |event| panic!("{event:?}")).unwrap();
    }
    let motion = Motion::from_state(assembly, 0.0, &[1e-4, 1e-6]).unwrap();
    assert!(!motion.mode().frictions[0].sticks());
}

/// The derivatives with respect to a start from a file equal those with respect to the
/// description's start; a start that names all bodies has the same columns.
#[test]
fn second_method_derivatives_from_a_start_are_those_of_the_file_with_it() {
    let text = BLOCK_ON_BELT.replace("mass = \"2 kg\"", "mass = \"2 kg\"\nstart = { s = 5e-4, v = 0.02 }");
    let names = ["body.block.start.s", "body.block.start.v", "stop.wall.gap", "friction.belt.force"];
    let of_file = Arc::new(Assembly::new(described(&text)).unwrap());
    let mut times = Vec::new();
    let mut tell = |_: &Event, by: &[Option<f64>]| times.push(by.to_vec());
    let mut own = Start::default().differentiated(of_file.clone(), &names, &mut tell).unwrap();
    own.advance_observed(0.5, &mut tell).unwrap();
    let mut start = Start::default();
    start.set(&of_file.description, "block.s", 5e-4).unwrap();
    start.set(&of_file.description, "block.v", 0.02).unwrap();
    let mut again = Vec::new();
    let mut tell = |_: &Event, by: &[Option<f64>]| again.push(by.to_vec());
    let mut given = start.differentiated(machine(), &names, &mut tell).unwrap();
    given.advance_observed(0.5, &mut tell).unwrap();
    assert!(times.len() > 2 && times == again, "{times:?} {again:?}");
    for quantity in of_file.description.quantities() {
        for (p, name) in names.iter().enumerate() {
            let (one, other) = (own.derivative(quantity, p), given.derivative(quantity, p));
            assert!(one.is_some() && one == other, "{quantity:?} by {name}: {one:?} {other:?}");
        }
    }
    // Names of the start's numbers.
    let own = ["start.block.s", "start.block.v", "start.time"];
    let columns = start.columns(&machine(), &own).unwrap();
    assert_eq!(columns, [By::Start(0), By::Start(1), By::Time]);
    assert_eq!(Start::default().columns(&of_file, &own).unwrap(), columns);
    assert_eq!(start.columns(&of_file, &names[..2]).unwrap(), columns[..2]);
    for (name, words) in [
        ("stop.wal.gap", "did you mean `stop.wall.gap`?"),
        ("start.blck.v", "start.blck.v: no start value has this name; did you mean `start.block.v`?"),
    ] {
        let unknown = start.differentiated(machine(), &[name], &mut |_, _| ()).err().unwrap().to_string();
        assert!(unknown.contains(words), "{unknown}");
    }
}
