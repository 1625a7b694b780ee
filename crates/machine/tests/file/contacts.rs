//! Contacts with friction in the file: refusals, writing, directions of nodes, parameters.

use vibro_machine::Description;
use vibro_machine::description::{Closing, Dimension};
use vibro_machine::file::{completion, no_records, parse, with_numbers};

/// A blade with a contact at its tip.
const BLADE: &str = r#"name = "Blade"
[body.box]
mass = 1.0
[body.wheel]
inertia = 1.0
[spring.k]
between = ["ground", "box"]
stiffness = 1.0
[spring.w]
between = ["ground", "wheel"]
stiffness = 1.0
[modal.blade]
frequencies = ["556 Hz", "1666 Hz"]
nodes = { tip = { x = [0.9, -1.7], y = [1.6, 1.2], z = [0.4, -0.7] }, push = [0.7, 0.2] }
[contact.tip]
between = ["ground", "blade.tip"]
normal = "y"
tangent = "x"
gap = "0.1 mm"
stiffness = "20 N/um"
tangential_stiffness = "15 N/um"
friction = 0.3
[load.f]
on = "blade.tip.x"
constant = 1.0
"#;

/// Text to replace, its replacement, and the message.
#[rustfmt::skip]
const CASES: &[(&str, &str, &str)] = &[
    ("gap = \"0.1 mm\"", "", "b.toml:15: contact.tip: requires `gap`, the elongation at which the contact closes, or `preload`, the normal force at e = 0"),
    ("gap = \"0.1 mm\"", "gap = 0.0\npreload = 3.0", "b.toml:20: contact.tip.preload = 3.0: cannot be combined with `gap`: use `gap` for the elongation at which the contact closes, or `preload` for the normal force at e = 0"),
    ("stiffness = \"20 N/um\"\n", "", "b.toml:15: contact.tip: requires `stiffness`, the normal stiffness; it may be left out only where every node of `normal` has residual flexibility; use [stop.NAME] for a rigid stop"),
    ("stiffness = \"20 N/um\"", "stiffness = 0.0", "b.toml:20: contact.tip.stiffness = 0.0: must be greater than 0"),
    ("tangential_stiffness = \"15 N/um\"\n", "", "b.toml:18: contact.tip.tangent = \"x\": requires `tangential_stiffness`: friction acts along a tangent through a stiffness\nb.toml:21: contact.tip.friction = 0.3: requires `tangential_stiffness`: friction acts along a tangent through a stiffness"),
    ("friction = 0.3", "friction = -0.3", "b.toml:22: contact.tip.friction = -0.3: expected a number from 0 to 1e6"),
    ("friction = 0.3", "friction = 1e200", "b.toml:22: contact.tip.friction = 1e200: expected a number from 0 to 1e6"),
    ("friction = 0.3", "friction = 0.3\nrestitution = 0.5", "b.toml:23: contact.tip.restitution = 0.5: is not supported in a contact: laws of rigid contact with friction disagree (Newton, Poisson, Routh); use `stiffness`, or [stop.NAME] for a rigid stop without friction"),
    ("friction = 0.3", "friction = 0.3\nstatic_friction = 0.5", "b.toml:23: contact.tip.static_friction = 0.5: is not supported: the tangential force would jump; use `friction` alone"),
    ("friction = 0.3", "friction = 0.3\ntangents = 2", "b.toml:23: contact.tip.tangents = 2: is not a key of a contact; use `tangent`, and `second_tangent` with `cone = \"box\"`"),
    ("friction = 0.3", "friction = 0.3\nmu = 0.3", "b.toml:23: contact.tip.mu = 0.3: is called `friction` in a contact"),
    ("friction = 0.3", "friction = 0.3\ntangential_damping = 0.5", "b.toml:23: contact.tip.tangential_damping = 0.5: is not supported in a contact; use a [damper.NAME] along the tangent"),
    ("friction = 0.3", "friction = 0.3\ncone = \"box\"", "b.toml:23: contact.tip.cone = \"box\": requires `second_tangent`: with two tangents, \"box\" limits the force along each of them by friction times the normal force"),
    ("friction = 0.3", "friction = 0.3\ncone = \"circle\"", "b.toml:23: contact.tip.cone = \"circle\": is not piecewise linear; use `cone = \"box\"`"),
    ("friction = 0.3", "friction = 0.3\ncone = 8", "b.toml:23: contact.tip.cone = 8: a polygon is not supported; use `cone = \"box\"`"),
    ("friction = 0.3", "friction = 0.3\ncone = \"bx\"", "b.toml:23: contact.tip.cone = \"bx\": expected \"box\""),
    ("tangent = \"x\"\n", "tangent = \"x\"\nsecond_tangent = \"z\"\n", "b.toml:19: contact.tip.second_tangent = \"z\": requires `cone = \"box\"`: with two tangents, \"box\" limits the force along each of them by friction times the normal force\nb.toml:22: contact.tip.tangential_stiffness = \"15 N/um\": expected two numbers, one for each tangent, such as [1.0, 2.0]"),
    ("tangent = \"x\"\n", "second_tangent = \"z\"\ncone = \"box\"\n", "b.toml:18: contact.tip.second_tangent = \"z\": requires `tangent`: friction acts along a tangent through a stiffness\nb.toml:19: contact.tip.cone = \"box\": requires `tangent`: friction acts along a tangent through a stiffness\nb.toml:22: contact.tip.tangential_stiffness = \"15 N/um\": requires `tangent`: friction acts along a tangent through a stiffness\nb.toml:23: contact.tip.friction = 0.3: requires `tangent`: friction acts along a tangent through a stiffness"),
    ("tangent = \"x\"\n", "tangent = \"x\"\nsecond_tangent = \"z\"\ncone = \"box\"\n", "b.toml:23: contact.tip.tangential_stiffness = \"15 N/um\": expected two numbers, one for each tangent, such as [1.0, 2.0]"),
    ("tangential_stiffness = \"15 N/um\"", "second_tangent = \"z\"\ncone = \"box\"\nslider = [0.1, 0.2, 0.3]\ntangential_stiffness = [1e7, 0.0]", "b.toml:23: contact.tip.slider = [0.1, 0.2, 0.3]: expected two numbers, one for each tangent, such as [1.0, 2.0]\nb.toml:24: contact.tip.tangential_stiffness[1] = 0.0: must be greater than 0"),
    ("tangential_stiffness = \"15 N/um\"", "second_tangent = \"-x\"\ncone = \"box\"\ntangential_stiffness = [1e7, 2e7]", "b.toml:21: contact.tip.second_tangent: has the same direction as `tangent`; expected another direction of the bodies"),
    ("tangential_stiffness = \"15 N/um\"", "second_tangent = \"y\"\ncone = \"box\"\ntangential_stiffness = [1e7, 2e7]", "b.toml:21: contact.tip.second_tangent: has the same direction as `normal`; expected another direction of the bodies"),
    ("tangential_stiffness = \"15 N/um\"", "tangential_stiffness = [1e7, 2e7]", "b.toml:21: contact.tip.tangential_stiffness = [1e7, 2e7]: expected a number > 0 in N/m, or with a unit: N/m, N/mm, kN/m, kN/mm, MN/m, N/cm, N/um, GN/m, lbf/in"),
    ("friction = 0.3", "friction = 0.3\ndamping = 2.0", "b.toml:23: contact.tip.damping = 2.0: cannot be combined with `friction`: the limit of friction would jump when the contact closes; use the damping of the bodies"),
    ("friction = 0.3", "friction = 0.3\nfricton = 0.3", "b.toml:23: contact.tip.fricton = 0.3: no such key; did you mean `friction`?"),
    ("normal = \"y\"", "normal = \"w\"", "b.toml:17: contact.tip.normal = \"w\": `blade.tip` has no such direction; expected one of x, y, z"),
    ("normal = \"y\"", "normal = \"-x\"", "b.toml:18: contact.tip.tangent: has the same direction as `normal`; expected another direction of the bodies"),
    ("between = [\"ground\", \"blade.tip\"]", "between = [\"ground\", \"blade.tp\"]", "b.toml:16: contact.tip.between[1] = \"blade.tp\": no body has this name; did you mean `blade.tip`?"),
    ("between = [\"ground\", \"blade.tip\"]", "between = [\"ground\", \"blade.push\"]", "b.toml:16: contact.tip.between[1] = \"blade.push\": it has no directions; use `normal = [A, B]`, or give the node directions, such as nodes.tip = { x = [...], y = [...] }"),
    ("between = [\"ground\", \"blade.tip\"]", "between = [\"ground\", \"blade.tip.y\"]", "b.toml:16: contact.tip.between[1] = \"blade.tip.y\": is a direction of the node `blade.tip`; expected the node, \"blade.tip\": `normal` and `tangent` give the directions"),
    ("between = [\"ground\", \"blade.tip\"]", "between = [\"blade.tip\", \"blade.tip\"]", "b.toml:16: contact.tip.between = [\"blade.tip\", \"blade.tip\"]: both ends are the same; expected two nodes, or ground and a node"),
    ("normal = \"y\"", "normal = 3", "b.toml:17: contact.tip.normal = 3: expected a direction of the nodes in `between`, such as \"y\" or \"-y\"; two names, such as [\"ground\", \"box\"]; or { arms = { A = 1.0, B = -1.0 } }"),
    ("normal = \"y\"", "normal = [\"ground\", \"wheel\"]", "b.toml:17: contact.tip.normal = [\"ground\", \"wheel\"]: is an angle; the normal and the tangent of a contact are lengths: use `arms` with a lever such as \"50 mm\""),
];

/// The text of the blade with two tangents.
fn boxed() -> String {
    let one = "tangential_stiffness = \"15 N/um\"";
    let two = "second_tangent = \"z\"\ncone = \"box\"\ntangential_stiffness = [\"15 N/um\", 2e7]";
    BLADE.replace(one, two)
}

fn blade() -> Description {
    parse(BLADE, "b.toml", &no_records).expect("a machine")
}

#[test]
fn golden_refusals_of_contacts() {
    let mut wrong = String::new();
    for (from, to, message) in CASES {
        assert!(BLADE.contains(from), "{from}");
        let text = BLADE.replacen(from, to, 1);
        let refused = parse(&text, "b.toml", &no_records).expect_err(to).to_string();
        if refused != *message {
            wrong += &format!("{to}:\n{refused}\n{message}\n\n");
        }
    }
    assert!(wrong.is_empty(), "{wrong}");
}

#[test]
fn invariant_a_contact_is_written_as_it_is_read() {
    let other = BLADE
        .replace("normal = \"y\"", "normal = { arms = { wheel = \"50 mm\", box = 1.0 } }")
        .replace("tangent = \"x\"", "tangent = [\"box\", \"blade.push\"]")
        .replace("between = [\"ground\", \"blade.tip\"]\n", "")
        .replace("gap = \"0.1 mm\"", "preload = \"120 N\"\nslider = \"2 mm\"");
    let boxed = boxed().replace("friction = 0.3", "friction = 0.3\nslider = [0.1, \"-2 mm\"]");
    let oblique = boxed.replace("\"z\"", "{ arms = { box = 1.0, \"blade.tip.z\" = -0.5 } }");
    let named = boxed.replace("[\"15 N/um\", 2e7]", "[\"= k\", \"= 2 * k\"]") + "[parameters]\nk = 1e7\n";
    let plain = BLADE.replace("tangent = \"x\"\n", "").replace("tangential_stiffness = \"15 N/um\"\n", "");
    let plain =
        plain.replace("friction = 0.3\n", "damping = 3.0\n").replace("normal = \"y\"", "normal = \"-y\"");
    for text in [BLADE.to_owned(), other, plain, boxed, oblique, named] {
        let machine = parse(&text, "b.toml", &no_records).expect("a machine");
        let written = machine.to_toml();
        assert_eq!(parse(&written, "w.toml", &no_records).expect("a machine"), machine, "{written}");
    }
}

#[test]
fn closed_form_directions_of_nodes_are_their_rows() {
    let machine = blade();
    let place = |name: &str| machine.bodies.iter().position(|body| body.name == name).expect("a node");
    let contact = &machine.contacts[0];
    assert_eq!(contact.normal.terms, [(place("blade.tip.y"), 1.0)]);
    let tangent = &contact.tangents[0];
    assert_eq!(tangent.arms.terms, [(place("blade.tip.x"), 1.0)]);
    assert_eq!(tangent.arms.dimension, Dimension::Translation);
    let turned = parse(&BLADE.replace("normal = \"y\"", "normal = \"-y\""), "b.toml", &no_records);
    assert_eq!(turned.expect("a machine").contacts[0].normal.terms, [(place("blade.tip.y"), -1.0)]);
}

#[test]
fn golden_parameters_of_a_contact() {
    let machine = blade();
    let names: Vec<_> = machine
        .parameters()
        .into_iter()
        .map(|own| own.name)
        .filter(|name| name.starts_with("contact."))
        .collect();
    let keys = ["gap", "stiffness", "tangential_stiffness", "friction", "slider"];
    assert_eq!(names, keys.map(|key| format!("contact.tip.{key}")));
    let changed =
        machine.with([("contact.tip.gap", 0.002), ("contact.tip.friction", 0.5)]).expect("a machine");
    assert_eq!(changed.contacts[0].closing, Closing::Gap(0.002));
    let named = machine.named_quantities();
    let columns: Vec<_> =
        named.iter().filter(|own| own.name.starts_with("tip.")).map(|own| own.name.as_str()).collect();
    assert_eq!(columns, ["tip.e", "tip.rate", "tip.f", "tip.et", "tip.ft", "tip.slider"]);
}

/// Numbers and columns of two tangents have the index of the tangent; one number is in one place
/// of the file.
#[test]
fn golden_parameters_of_two_tangents() {
    let text = boxed();
    let machine = parse(&text, "b.toml", &no_records).expect("a machine");
    let names: Vec<_> = machine.parameters().into_iter().map(|own| own.name).collect();
    let names: Vec<_> = names.iter().filter_map(|own| own.strip_prefix("contact.tip.")).collect();
    let both = ["tangential_stiffness[0]", "tangential_stiffness[1]", "friction", "slider[0]", "slider[1]"];
    assert_eq!(names, [&["gap", "stiffness"][..], &both].concat());
    let named = machine.named_quantities();
    let columns: Vec<_> = named.iter().filter_map(|own| own.name.strip_prefix("tip.")).collect();
    let each = ["et[0]", "ft[0]", "slider[0]", "et[1]", "ft[1]", "slider[1]"];
    assert_eq!(columns, [&["e", "rate", "f"][..], &each].concat());
    let other = machine.with([("contact.tip.tangential_stiffness[1]", 3e7)]).expect("a machine");
    assert_eq!(other.contacts[0].tangents[1].stiffness, 3e7);
    let edited = with_numbers(&text, &no_records, &other).expect("an edit");
    assert_eq!(edited, text.replace("2e7", "30000000.0"));
}

#[test]
fn golden_completions_in_a_contact() {
    let head = BLADE.split_once("normal = \"y\"").expect("a normal").0;
    let offers = |typed: &str| -> Vec<String> {
        completion(&format!("{head}{typed}"), "").offers.into_iter().map(|own| own.0).collect()
    };
    assert_eq!(offers("tang"), ["tangent", "tangential_stiffness"]);
    assert_eq!(offers("second"), ["second_tangent"]);
    assert_eq!(offers("second_tangent = \"z\"\ncone = \""), ["box"]);
    assert_eq!(offers("normal = \""), ["x", "y", "z"]);
    assert_eq!(offers("stiffness = \"3 k"), ["kN/m", "kN/mm"]);
    assert!(offers("").iter().all(|own| own != "restitution"));
}
