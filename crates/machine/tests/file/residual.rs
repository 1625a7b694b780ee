//! Residual flexibility in the file: refusals, writing, parameters.

use vibro_machine::Description;
use vibro_machine::description::StopLaw;
use vibro_machine::file::{no_records, parse};

/// A blade with a contact at its tip and a stop at its platform, all on residual flexibility.
const BLADE: &str = r#"name = "Blade"
[body.box]
mass = 1.0
[spring.k]
between = ["ground", "box"]
stiffness = 1.0
[modal.blade]
frequencies = ["556 Hz", "1666 Hz"]
nodes = { tip = { x = [0.9, -1.7], y = [1.6, 1.2] }, push = [0.7, 0.2], free = [0.3, 0.3] }
residual = { nodes = ["tip.x", "tip.y", "push"], flexibility = [[4e-8, 1e-8, 0.0], [1e-8, 3e-8, 0.0], [0.0, 0.0, 2e-8]] }
[contact.tip]
between = ["ground", "blade.tip"]
normal = "y"
tangent = "x"
gap = "0.1 mm"
stiffness = "20 N/um"
tangential_stiffness = "15 N/um"
friction = 0.3
[stop.push]
between = ["ground", "blade.push"]
gap = "0.2 mm"
[spring.mount]
between = ["box", "blade.push"]
stiffness = "1 kN/m"
[load.f]
on = "blade.push"
constant = 1.0
"#;

const REDUCE: &str = "reduce the body with `--method rubin` or `craig-bampton`, which keep the flexibility as modes, or take the node out of `residual`";

/// Text to replace, its replacement, and the message; `REDUCE` stands for the advice.
#[rustfmt::skip]
const CASES: &[(&str, &str, &str)] = &[
    ("residual = { nodes", "residul = { nodes", "b.toml:10: modal.blade.residul: no such key; did you mean `residual`?\nb.toml:19: stop.push: requires `restitution` (rigid stop) or `stiffness` (compliant stop)"),
    ("residual = { nodes = [\"tip.x\", \"tip.y\", \"push\"], flexibility", "residual = { nods = [\"tip.x\", \"tip.y\", \"push\"], flexibility", "b.toml:10: modal.blade.residual.nods = [\"tip.x\", \"tip.y\", \"push\"]: no such key; did you mean `nodes`?"),
    ("\"tip.y\", \"push\"]", "\"tp.y\", \"push\"]", "b.toml:10: modal.blade.residual.nodes[1] = \"tp.y\": the body has no such node; did you mean `tip.y`?"),
    ("\"tip.y\", \"push\"]", "\"tip.x\", \"push\"]", "b.toml:10: modal.blade.residual.nodes[1] = \"tip.x\": the node is named twice"),
    ("\"tip.y\", \"push\"]", "\"tip.y\"]", "b.toml:10: modal.blade.residual.flexibility = [[4e-8, 1e-8, 0.0], [1e-8, 3e-8, 0.0], [0.0, 0.0, 2e-8]]: has 3 rows and 3 columns; expected 2 of both, one for each of `nodes`"),
    ("[[4e-8, 1e-8, 0.0]", "[[4e-8, 2e-8, 0.0]", "b.toml:10: modal.blade.residual.flexibility: expected a symmetric matrix; the entry [1][0] is 1e-8, the entry [0][1] is 2e-8"),
    ("[[4e-8, 1e-8, 0.0], [1e-8, 3e-8, 0.0]", "[[4e-8, 5e-8, 0.0], [5e-8, 3e-8, 0.0]", "b.toml:10: modal.blade.residual.flexibility: has the eigenvalue -1.525e-8; expected no negative eigenvalue: a force would move its node against itself"),
    ("[\"ground\", \"blade.push\"]\ngap = \"0.2 mm\"", "[\"ground\", \"blade.free\"]\ngap = \"0.2 mm\"", "b.toml:19: stop.push: requires `restitution` (rigid stop) or `stiffness` (compliant stop); neither is needed only where every node of the stop has residual flexibility"),
    ("gap = \"0.2 mm\"", "gap = \"0.2 mm\"\nrestitution = 0.5", "b.toml:22: stop.push.restitution = 0.5: an impulse with a restitution coefficient (leave out `restitution` for a rigid stop that the waves in the body rebound from) cannot act on `blade.push`, which has residual flexibility; REDUCE"),
    ("gap = \"0.2 mm\"", "gap = \"0.2 mm\"\nstiffness = 1e6\ndamping = 2.0", "b.toml:23: stop.push.damping = 2.0: a dashpot cannot act on `blade.push`, which has residual flexibility; REDUCE"),
    ("gap = \"0.2 mm\"", "gap = \"0.2 mm\"\nstiffness = 1e6\nexponent = 1.5", "b.toml:19: stop.push: a curved force cannot act on `blade.push`, which has residual flexibility; REDUCE"),
    ("stiffness = \"1 kN/m\"", "stiffness = \"1 kN/m\"\ndamping = 3.0", "b.toml:25: spring.mount.damping = 3.0: a dashpot cannot act on `blade.push`, which has residual flexibility; REDUCE"),
    ("stiffness = \"1 kN/m\"", "stiffness = 0.0\npreload = 3.0", "b.toml:24: spring.mount.stiffness = 0.0: a spring without stiffness cannot act on `blade.push`, which has residual flexibility; REDUCE"),
    ("stiffness = \"1 kN/m\"", "stiffness = \"1 kN/m\"\nslip = 3.0", "b.toml:22: spring.mount: a dashpot or slider in series cannot act on `blade.push`, which has residual flexibility; REDUCE"),
    ("stiffness = \"1 kN/m\"", "stiffness = \"1 kN/m\"\ncubic = 3.0", "b.toml:22: spring.mount: a curved force cannot act on `blade.push`, which has residual flexibility; REDUCE"),
    ("[load.f]", "[damper.d]\nbetween = [\"ground\", \"blade.tip.x\"]\ndamping = 1.0\n[load.f]", "b.toml:25: damper.d: a dashpot cannot act on `blade.tip.x`, which has residual flexibility; REDUCE"),
    ("[load.f]", "[friction.d]\nbetween = [\"ground\", \"blade.tip.x\"]\nforce = 1.0\n[load.f]", "b.toml:25: friction.d: a friction element cannot act on `blade.tip.x`, which has residual flexibility; REDUCE"),
    ("[load.f]", "[friction.d]\nbetween = [\"ground\", \"box\"]\nfollows = \"push\"\ncoefficient = 0.1\n[load.f]", "b.toml:27: friction.d.follows: a stop with a friction element cannot act on `blade.push`, which has residual flexibility; REDUCE"),
    ("[load.f]", "[freewheel.d]\nbetween = [\"ground\", \"blade.tip.x\"]\n[load.f]", "b.toml:25: freewheel.d: a freewheel cannot act on `blade.tip.x`, which has residual flexibility; REDUCE"),
    ("[load.f]", "[link.d]\nbetween = [\"box\", \"blade.tip.x\"]\n[load.f]", "b.toml:25: link.d: a rigid link cannot act on `blade.tip.x`, which has residual flexibility; REDUCE"),
    ("constant = 1.0", "steps = [[0.1, 1.0]]", "b.toml:25: load.f: the force may jump (input, steps or a held table), and with it `blade.push`, which has residual flexibility; expected a continuous signal of time, such as a straight table; otherwise REDUCE"),
    ("constant = 1.0", "input = true", "b.toml:25: load.f: the force may jump (input, steps or a held table), and with it `blade.push`, which has residual flexibility; expected a continuous signal of time, such as a straight table; otherwise REDUCE"),
    ("[load.f]", "[block.b]\ninputs = [\"blade.tip.x.s\"]\noutputs = [\"y\"]\nd = [[1.0]]\n[load.f]", "b.toml:26: block.b.inputs: a block cannot read `blade.tip.x`, which has residual flexibility: its place depends on the contacts; REDUCE"),
    ("[body.box]", "[body.base]\nmotion = { steps = [[0.1, 0.001]] }\n[body.box]", "b.toml:20: contact.tip.friction = 0.3: friction on residual flexibility is not supported in a machine whose body.base jumps (input, steps or a held table); expected a continuous motion"),
    ("name = \"Blade\"", "name = \"Blade\"\nstart = \"rest\"", "b.toml:19: contact.tip.friction = 0.3: cannot be combined with `start = \"rest\"` on residual flexibility; give the start of each body, or take the nodes out of `residual`"),
    ("tangential_stiffness = \"15 N/um\"", "second_tangent = [\"ground\", \"box\"]\ncone = \"box\"\ntangential_stiffness = [1e7, 1e7]", "b.toml:17: contact.tip.second_tangent: a contact with two tangents is not supported on residual flexibility: remove `second_tangent` and `cone`, or take the nodes out of `residual`"),
    ("friction = 0.3", "friction = 9.0", "b.toml:18: contact.tip.friction = 9.0: the force would not be unique: friction presses the contact through the residual flexibility; expected at most 8.000000, or a smaller `stiffness`"),
    ("gap = \"0.1 mm\"\nstiffness = \"20 N/um\"", "preload = 3.0", "b.toml:15: contact.tip.preload = 3.0: requires `stiffness`: use `gap` for a rigid contact"),
];

fn blade() -> Description {
    parse(BLADE, "b.toml", &no_records).expect("a machine")
}

#[test]
fn golden_refusals_of_residual_flexibility() {
    let mut wrong = String::new();
    for (from, to, message) in CASES {
        assert!(BLADE.contains(from), "{from}");
        let text = BLADE.replacen(from, to, 1);
        let refused = match parse(&text, "b.toml", &no_records) {
            Err(refused) => refused.to_string(),
            Ok(_) => "accepted".into(),
        };
        let message = message.replace("REDUCE", REDUCE);
        if refused != message {
            wrong += &format!("{to}:\n{refused}\n{message}\n\n");
        }
    }
    assert!(wrong.is_empty(), "{wrong}");
}

/// Several elements on the same flexibility have no start at rest, and rigid ones in the same direction no
/// unique force.
#[test]
fn golden_refusals_of_elements_that_share_flexibility() {
    let plain = BLADE.replace("tangent = \"x\"\n", "").replace("tangential_stiffness = \"15 N/um\"\n", "");
    let plain = plain.replace("friction = 0.3\n", "");
    let rest = plain.replace("name = \"Blade\"", "name = \"Blade\"\nstart = \"rest\"");
    let refused = parse(&rest, "b.toml", &no_records).expect_err("a refusal").to_string();
    let expected = "b.toml:2: start = \"rest\": is not supported with several elements that share residual flexibility; give the start of each body";
    assert_eq!(refused, expected);
    let two = plain.replace(
        "[spring.mount]",
        "[stop.other]\nbetween = [\"ground\", \"blade.push\"]\ngap = 0.0\n[spring.mount]",
    );
    let refused = parse(&two, "b.toml", &no_records).expect_err("a refusal").to_string();
    assert!(refused.contains("leaves no force unique"), "{refused}");
}

#[test]
fn invariant_residual_flexibility_is_written_as_it_is_read() {
    let machine = blade();
    let own = machine.modals[0].residual.as_ref().expect("residual flexibility");
    let names: Vec<&str> = own.nodes.iter().map(|node| machine.bodies[*node].name.as_str()).collect();
    assert_eq!(names, ["blade.tip.x", "blade.tip.y", "blade.push"]);
    assert_eq!((own.flexibility[(0, 1)], own.flexibility[(2, 2)]), (1e-8, 2e-8));
    assert!(matches!(machine.stops[0].law, StopLaw::Compliant { stiffness, .. } if stiffness.is_infinite()));
    let rigid = BLADE.replace("stiffness = \"20 N/um\"\n", "");
    for text in [BLADE.to_owned(), rigid] {
        let machine = parse(&text, "b.toml", &no_records).expect("a machine");
        let written = machine.to_toml();
        assert_eq!(parse(&written, "w.toml", &no_records).expect("a machine"), machine, "{written}");
        // Neither the flexibility nor a stiffness that is left out is a parameter.
        assert!(
            machine.parameters().iter().all(|own| !own.name.contains("residual") && own.value.is_finite())
        );
    }
}

/// A table of the flexibility in a file.
#[test]
fn invariant_the_flexibility_may_be_a_file() {
    let text = BLADE.replace("[[4e-8, 1e-8, 0.0], [1e-8, 3e-8, 0.0], [0.0, 0.0, 2e-8]]", "\"g.csv\"");
    let records = |_: &str| Ok("4e-8, 1e-8, 0.0\n1e-8, 3e-8, 0.0\n0.0, 0.0, 2e-8\n".to_owned());
    assert_eq!(parse(&text, "b.toml", &records).expect("a machine"), blade());
}
