//! The meaning of the file's keys, compared with values computed by hand.

use crate::refusals::{SOUND, records};
use vibro_machine::Description;
use vibro_machine::description::*;
use vibro_machine::file::{no_records, parse};

fn machine(text: &str) -> Description {
    parse(text, "m.toml", &records).unwrap_or_else(|refusal| panic!("{refusal}"))
}

/// The machine with one place of its file changed.
fn changed(from: &str, to: &str) -> Description {
    machine(&SOUND.replace(from, to))
}

#[test]
fn closed_form_every_key_lands_in_its_place_in_si() {
    let m = machine(SOUND);
    let names: Vec<_> = m.bodies.iter().map(|b| b.name.as_str()).collect();
    assert_eq!(names, ["box", "block", "wheel", "drum", "belt"], "bodies keep the file's order");
    assert_eq!((m.name.as_str(), m.gravity), ("Sound", 9.81));
    assert_eq!(m.bodies[1].kind, BodyKind::Free(Free { inertia: 0.35, gravity: -1.0, s: 0.002, v: 0.0 }));
    assert_eq!(m.bodies[2].dimension, Dimension::Rotation);
    assert_eq!(m.bodies[4].kind, BodyKind::Prescribed { motion: Signal::default(), rate: 0.5 });
    let mount = &m.springs[0];
    assert_eq!(mount.arms, Arms::between(None, Some(0), Dimension::Translation));
    assert_eq!((mount.stiffness, mount.damping, mount.preload), (48e3, 60.0, 0.0));
    let mesh = Arms { terms: vec![(2, 0.05), (0, 1.0)], dimension: Dimension::Translation, levers: true };
    assert_eq!(m.springs[1].arms, mesh);
    assert_eq!(m.stops[0].arms.terms, [(0, -1.0), (1, 1.0)], "e = s_block - s_box");
    assert_eq!(m.stops[0].law, StopLaw::Rigid { restitution: 0.7 });
    let law = StopLaw::Compliant { stiffness: 2e6, damping: 150.0, limit: DampingLimit::NoPull };
    assert_eq!((m.stops[1].gap, m.stops[1].law), (0.004, law));
    for (word, limit) in [("pull", DampingLimit::Pull), ("undamped-rebound", DampingLimit::UndampedRebound)] {
        let law = StopLaw::Compliant { stiffness: 2e6, damping: 150.0, limit };
        assert_eq!(changed("law = \"no-pull\"", &format!("law = {word:?}")).stops[1].law, law);
    }
    assert_eq!(
        (m.frictions[0].force.constant, m.frictions[0].static_force.as_ref().unwrap().constant),
        (0.4, 0.5)
    );
    let force = &m.loads[0].force;
    assert_eq!(force.harmonics, [Harmonic { amplitude: 150.0, frequency: 10.0, phase: 0.0 }]);
    assert_eq!(force.steps, [Step { time: 0.4, height: 20.0 }, Step { time: 0.9, height: -20.0 }]);
    assert_eq!(force.table, Some(Record::new(vec![(0.0, 0.0), (1.0, 2.5)], Interpolation::Straight)));
    assert_eq!(
        m.links[0].arms,
        Arms { terms: vec![(2, 1.0), (3, -3.0)], dimension: Dimension::Rotation, levers: true }
    );
}

#[test]
fn closed_form_other_ways_to_write_the_same() {
    let sound = machine(SOUND);
    for (from, to) in [
        ("mass = \"12 kg\"", "mass = 12"),
        ("mass = \"12 kg\"", "mass = 0xc"),
        ("mass = \"12 kg\"", "mass = 1_2.0"),
        ("mass = \"12 kg\"", "mass = \" 12000 g \""),
        ("stiffness = \"48 kN/m\"", "stiffness = \"48 N/mm\""),
        ("damping = \"60 N s/m\"", "damping = \"60 N·s/m\""),
        ("law = \"no-pull\"", ""),
        ("preload = 0.0", ""),
        (", phase = 0.0 }]", " }]"),
        (
            "harmonics = [{ amplitude = \"150 N\", frequency = \"10 Hz\", phase = 0.0 }]",
            "amplitude = 150\nfrequency = \"600 rpm\"",
        ),
        ("motion = { rate = \"0.5 m/s\" }", "motion = { rate = 0.5 }"),
        ("motion = { rate = \"0.5 m/s\" }", "motion = { offset = 0, rate = 0.5, input = false }"),
        ("motion = { rate = \"0.5 m/s\" }", "motion.rate = 0.5"),
        ("table = \"record.csv\"", "table = [[0, 0], [1, \"2.5 N\"]]\ninterpolation = \"straight\""),
        ("between = [\"ground\", \"box\"]", "between = [\n  'ground', # still\n  \"box\",\n]"),
    ] {
        assert_eq!(changed(from, to), sound, "{to}");
    }
}

#[test]
fn closed_form_what_a_prescribed_body_is_measured_in() {
    let base = |motion: &str, element: &str| {
        let text = format!(
            "name = \"P\"\n[body.wheel]\ninertia = 1.0\n[body.box]\nmass = 1.0\n[body.drive]\n{motion}\n[spring.a]\n{element}\nstiffness = 1.0\n\
             [spring.b]\nbetween = [\"ground\", \"box\"]\nstiffness = 1.0\n[spring.c]\nbetween = [\"ground\", \"wheel\"]\nstiffness = 1.0\n"
        );
        machine(&text).bodies[2].dimension
    };
    let levers = "arms = { drive = 1.0 }";
    assert_eq!(base("motion = { rate = \"10 rpm\" }", levers), Dimension::Rotation);
    assert_eq!(
        base("motion = { harmonics = [{ amplitude = \"1 deg\", frequency = 1.0 }] }", levers),
        Dimension::Rotation
    );
    assert_eq!(
        base("motion = { amplitude = 1.0, frequency = \"3 rad/s\", phase = \"1 rad\" }", levers),
        Dimension::Translation
    );
    assert_eq!(base("motion = { rate = 10.0 }", "between = [\"drive\", \"wheel\"]"), Dimension::Rotation);
    assert_eq!(base("motion = { input = true }", "between = [\"drive\", \"box\"]"), Dimension::Translation);
    assert_eq!(base("motion = { input = true }\ndimension = \"rotation\"", levers), Dimension::Rotation);
}

/// A compliant stop, unlike a rigid one, may be violated at the start; gaps and preloads may have
/// either sign.
#[test]
fn closed_form_what_is_allowed() {
    assert_eq!(changed("gap = \"4 mm\"", "gap = \"-4 mm\"").stops[1].gap, -0.004);
    assert_eq!(changed("preload = 0.0", "preload = \"-3 N\"").springs[0].preload, -3.0);
    assert_eq!(
        changed("restitution = 0.7", "restitution = 1").stops[0].law,
        StopLaw::Rigid { restitution: 1.0 }
    );
    assert_eq!(
        changed("s = \"2 mm\"", "s = \"5 mm\"").bodies[1].dimension,
        Dimension::Translation,
        "e = gap is no violation"
    );
    let at_rest = SOUND
        .replace("start = { s = \"2 mm\", v = 0.0 }\n", "")
        .replace("name =", "start = \"rest\"\nname =");
    assert!(machine(&at_rest).starts_at_rest);
    let linked = SOUND.replace("inertia = 1\n", "inertia = 1\nstart = { s = 0.1 }\n");
    let linked =
        linked.replace("inertia = \"0.02 kg m2\"\n", "inertia = \"0.02 kg m2\"\nstart = { s = 0.3 }\n");
    assert!(
        matches!(machine(&linked).bodies[3].kind, BodyKind::Free(Free { s: 0.1, .. })),
        "0.3 - 3 · 0.1 is round-off"
    );
}

/// A stop between a body and one of prescribed motion is checked against the motion's value at
/// time 0.
#[test]
fn closed_form_start_against_a_prescribed_motion() {
    let text = |phase: f64| {
        format!(
            "name = \"Pair\"\n[body.ball]\nmass = 1.0\n[body.base]\nmotion = {{ amplitude = 1.0, frequency = 1.0, phase = {phase} }}\n\
             [stop.wall]\nbetween = [\"base\", \"ball\"]\ngap = 0.5\nrestitution = 0.5\n"
        )
    };
    assert!(parse(&text(0.0), "m.toml", &no_records).is_ok());
    let refused = parse(&text(-std::f64::consts::FRAC_PI_2), "m.toml", &no_records).unwrap_err();
    assert_eq!(
        refused.to_string(),
        "m.toml:8: stop.wall.gap = 0.5: e = 1.0 m at the start is beyond the gap; a rigid stop requires e <= gap: increase the gap, or change the start"
    );
}

#[test]
fn invariant_records_are_read_beside_the_file() {
    let folder = std::env::temp_dir().join(format!("vibro-machine-{}", std::process::id()));
    std::fs::create_dir_all(folder.join("data")).unwrap();
    std::fs::write(
        folder.join("data/record.csv"),
        "\u{feff}time,force\r\n# by hand\r\n0.0, 1e-3\r\n0.5,2\r\n",
    )
    .unwrap();
    let file = folder.join("machine.toml");
    std::fs::write(&file, SOUND.replace("record.csv", "data/record.csv")).unwrap();
    let read = vibro_machine::file::read(&file);
    std::fs::remove_dir_all(&folder).unwrap();
    assert_eq!(read.unwrap().loads[0].force.table.as_ref().unwrap().knots, [(0.0, 1e-3), (0.5, 2.0)]);
    let gone = vibro_machine::file::read(&file).unwrap_err().to_string();
    assert!(gone.starts_with(&format!("{}: no such file", file.display())), "{gone}");
}

/// A record with units in its heading equals the same record in SI; a unit of another quantity is
/// refused, and so is a unit together with `scale`.
#[test]
fn closed_form_units_in_the_heading_of_a_record() {
    let of = |heading: &'static str, keys: &str| {
        let text =
            format!("name = \"M\"\n[body.m]\nmass = 1.0\n[load.f]\non = \"m\"\ntable = \"r.csv\"\n{keys}\n");
        parse(&text, "m.toml", &|_| Ok(format!("{heading}0,1\n10,2.5\n")))
            .map(|d| d.loads[0].force.table.clone().unwrap().knots)
            .map_err(|refused| refused.to_string())
    };
    assert_eq!(of("time [ms],f [kN]\n", ""), Ok(vec![(0.0, 1e3), (0.01, 2.5e3)]));
    assert_eq!(of("time (min); acc\n", "").map_err(|e| e.contains("line 2")), Err(true));
    assert_eq!(of("time_s,acc_g\n", "scale = 9.81"), Ok(vec![(0.0, 1.0), (10.0, 2.5)]));
    for (heading, keys, words) in [
        ("time [ms],f [mm]\n", "", "= \"r.csv\": line 1: `f` has the unit `mm`; expected one of N, mN"),
        (
            "time,f [kN]\n",
            "scale = 2.0",
            "= \"r.csv\": line 1: `f` has the unit `kN`, which cannot be combined with `scale`",
        ),
    ] {
        let refused = of(heading, keys).unwrap_err();
        assert!(refused.contains(words), "{refused}");
    }
}
