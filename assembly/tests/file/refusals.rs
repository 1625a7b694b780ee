//! Every refusal of the file, with its whole message.

use vibro_assembly::file::{no_records, parse};

/// A machine that is accepted, of which each case changes one place.
const SOUND: &str = r#"name = "Sound"
gravity = "9.81 m/s2"
[body.box]
mass = "12 kg"
[body.block]
mass = "350 g"
gravity = -1.0
start = { s = "2 mm", v = 0.0 }
[body.wheel]
inertia = "0.02 kg m2"
[body.drum]
inertia = 1
[body.belt]
motion = { rate = "0.5 m/s" }
[spring.mount]
between = ["ground", "box"]
stiffness = "48 kN/m"
damping = "60 N s/m"
preload = 0.0
[stop.upper]
between = ["box", "block"]
gap = "5 mm"
restitution = 0.7
[stop.buffer]
between = ["block", "box"]
gap = "4 mm"
stiffness = "2 MN/m"
damping = "150 N s/m"
law = "no-pull"
[friction.guide]
between = ["belt", "block"]
force = "0.4 N"
static = "0.5 N"
[load.shaker]
on = "box"
harmonics = [{ amplitude = "150 N", frequency = "10 Hz", phase = 0.0 }]
steps = [[0.4, 20.0], [0.9, -20.0]]
table = "record.csv"
[spring.mesh]
arms = { wheel = "50 mm", box = 1.0 }
stiffness = "200 MN/m"
[link.gear]
arms = { wheel = 1.0, drum = -3.0 }
"#;

/// What is put for what, and what is said then. Lines are counted in the changed text.
#[rustfmt::skip]
const CASES: &[(&str, &str, &str)] = &[
    // Unknown names.
    ("gap = \"5 mm\"", "gpa = \"5 mm\"", "m.toml:23: stop.upper.gap: is missing: allowed is a finite number, in m, cm, mm, um\nm.toml:25: stop.upper.gpa = \"5 mm\": no such key; the nearest is `gap`"),
];

fn records(path: &str) -> std::io::Result<String> {
    match path {
        "record.csv" => Ok("time,value\n0,0\n1,2.5\n".into()),
        _ => Err(std::io::Error::other("there is no such file")),
    }
}

fn said(text: &str) -> String {
    match parse(text, "m.toml", &records) {
        Ok(_) => "accepted".into(),
        Err(refusal) => refusal.to_string(),
    }
}

#[test]
fn golden_message_of_every_refusal() {
    assert_eq!(said(SOUND), "accepted");
    let mut wrong = Vec::new();
    for (from, to, message) in CASES {
        assert_eq!(SOUND.matches(from).count(), 1, "{from}");
        let found = said(&SOUND.replace(from, to));
        if found != *message {
            wrong.push(format!("{from} -> {to}\n  said: {found:?}\n  not:  {message:?}"));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
