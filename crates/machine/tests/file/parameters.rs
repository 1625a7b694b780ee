//! Parameters by name.

use crate::random::machine;
use crate::refusals::{SOUND, records};
use proptest::prelude::*;
use vibro_machine::Description;
use vibro_machine::file::parse;

fn sound() -> Description {
    parse(SOUND, "m.toml", &records).unwrap()
}

#[test]
fn golden_names_units_and_values() {
    let all = sound().parameters();
    let shown: Vec<_> = all.iter().map(|p| format!("{} = {:?} {}", p.name, p.value, p.unit)).collect();
    assert_eq!(
        shown,
        [
            "gravity = 9.81 m/s2",
            "body.box.mass = 12.0 kg",
            "body.box.gravity = 0.0 1",
            "body.box.start.s = 0.0 m",
            "body.box.start.v = 0.0 m/s",
            "body.block.mass = 0.35 kg",
            "body.block.gravity = -1.0 1",
            "body.block.start.s = 0.002 m",
            "body.block.start.v = 0.0 m/s",
            "body.wheel.inertia = 0.02 kg.m2",
            "body.wheel.start.s = 0.0 rad",
            "body.wheel.start.v = 0.0 rad/s",
            "body.drum.inertia = 1.0 kg.m2",
            "body.drum.start.s = 0.0 rad",
            "body.drum.start.v = 0.0 rad/s",
            "body.belt.motion.constant = 0.0 m",
            "body.belt.motion.rate = 0.5 m/s",
            "spring.mount.stiffness = 48000.0 N/m",
            "spring.mount.damping = 60.0 N.s/m",
            "spring.mount.preload = 0.0 N",
            "spring.mesh.arms.wheel = 0.05 m",
            "spring.mesh.arms.box = 1.0 1",
            "spring.mesh.stiffness = 200000000.0 N/m",
            "spring.mesh.damping = 0.0 N.s/m",
            "spring.mesh.preload = 0.0 N",
            "stop.upper.gap = 0.005 m",
            "stop.upper.restitution = 0.7 1",
            "stop.buffer.gap = 0.004 m",
            "stop.buffer.stiffness = 2000000.0 N/m",
            "stop.buffer.damping = 150.0 N.s/m",
            "friction.guide.force = 0.4 N",
            "friction.guide.static = 0.5 N",
            "link.gear.arms.wheel = 1.0 1",
            "link.gear.arms.drum = -3.0 1",
            "load.shaker.constant = 0.0 N",
            "load.shaker.amplitude = 150.0 N",
            "load.shaker.frequency = 10.0 Hz",
            "load.shaker.phase = 0.0 rad",
            "load.shaker.steps[0].time = 0.4 s",
            "load.shaker.steps[0].height = 20.0 N",
            "load.shaker.steps[1].time = 0.9 s",
            "load.shaker.steps[1].height = -20.0 N",
        ]
    );
}

#[test]
fn golden_refusals_leave_the_machine_as_it_was() {
    let mut machine = sound();
    for (name, value, message) in [
        ("stop.uper.gap", 1.0, "stop.uper.gap: no parameter has this name; did you mean `stop.upper.gap`?"),
        (
            "stop.upper.gap",
            0.001,
            "stop.upper.gap = 0.001: e = 0.002 m at the start is beyond the gap; a rigid stop requires e <= gap: increase the gap, or change the start",
        ),
        ("stop.upper.gap", f64::NAN, "stop.upper.gap = NaN: must be a finite number"),
        ("body.box.mass", 0.0, "body.box.mass = 0.0: must be greater than 0"),
        (
            "friction.guide.force",
            0.6,
            "friction.guide.static = 0.5: must be at least 0.6 N, the sliding friction friction.guide.force",
        ),
        ("link.gear.arms.drum", 0.0, "link.gear.arms.drum = 0.0: must not be 0"),
        (
            "load.shaker.steps[0].time",
            2.0,
            "load.shaker.steps[1].time = 0.9: must be after 2.0 s, the time of the previous step",
        ),
    ] {
        assert_eq!(machine.replace(name, value).unwrap_err().to_string(), message);
        assert_eq!(machine, sound());
    }
}

#[test]
fn closed_form_values_that_are_allowed_only_together() {
    let changed = sound().with([("stop.upper.gap", 0.001), ("body.block.start.s", 0.0005)]).unwrap();
    assert_eq!((changed.get("stop.upper.gap"), changed.get("body.block.start.s")), (Ok(0.001), Ok(0.0005)));
    let gear = sound().with([("load.shaker.harmonics[0].amplitude", 2.0)]).unwrap();
    assert_eq!(gear.get("load.shaker.amplitude"), Ok(2.0));
}

#[test]
fn golden_reading_a_value_of_a_parameter() {
    let gap = sound().parameter("stop.upper.gap").unwrap();
    assert_eq!(gap.read("7 mm"), Ok(0.007));
    let refused = gap.read("7 N").unwrap_err().to_string();
    assert_eq!(refused, "stop.upper.gap = \"7 N\": cannot be in `N`; expected one of m, cm, mm, um, in");
}

proptest! {
    /// Each name exists once and belongs to its own number; writing a value back changes nothing
    /// else.
    #[test]
    fn invariant_every_name_leads_to_its_own_number(machine in machine()) {
        let all = machine.parameters();
        for (i, parameter) in all.iter().enumerate() {
            prop_assert_eq!(machine.get(&parameter.name), Ok(parameter.value));
            prop_assert_eq!(all.iter().position(|p| p.name == parameter.name), Some(i));
        }
        let same = machine.with(all.iter().map(|p| (p.name.as_str(), p.value)));
        prop_assert_eq!(same, Ok(machine));
    }
}

/// Structures that no file can express are refused in a program's description too.
#[test]
fn golden_refusals_of_a_program_s_description() {
    type Change = fn(&mut Description);
    let changed = |change: Change| {
        let mut machine = sound();
        change(&mut machine);
        machine.check().map_err(|refusal| refusal.to_string())
    };
    let cases: [(Change, &str); 8] = [
        (|m| m.springs[0].arms.terms[0].0 = 9, "spring.mount: no body has the index 9, counted from 0"),
        (
            |m| m.springs[0].arms.terms[0].1 = 2.0,
            "spring.mount.arms = [2.0]: an element without levers must have the arms -1 (first end) and 1 (second end)",
        ),
        (|m| m.links[0].arms.terms[1].0 = 2, "link.gear.arms.wheel = -3.0: the body is named twice"),
        (|m| m.links[0].arms.terms.clear(), "link.gear.arms: names no body; expected one or more bodies"),
        (
            |m| m.stops[0].arms.terms[1].0 = 2,
            "stop.upper.arms.wheel = 1.0: an element without levers requires a body of its own dimension",
        ),
        (|m| m.loads[0].body = 7, "load.shaker.on: no body has the index 7, counted from 0"),
        (
            |m| m.loads[0].force.table.as_mut().unwrap().knots[1].1 = f64::NAN,
            "load.shaker.table[1] = [1.0, NaN]: expected finite numbers",
        ),
        (|m| m.bodies[1].name = "box".into(), "body.box: is given twice; keep one of them"),
    ];
    assert_eq!(changed(|_| {}), Ok(()));
    for (change, message) in cases {
        assert_eq!(changed(change), Err(message.to_owned()));
    }
}
