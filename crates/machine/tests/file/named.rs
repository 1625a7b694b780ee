//! Named parameters and expressions.

use std::f64::consts::{PI, TAU};
use vibro_machine::Description;
use vibro_machine::file::{no_records, parse};

/// A machine with expressions of parameters in every place that accepts a number.
const NAMED: &str = r#"
name = "Named"
gravity = "= g0"
[parameters]
half = "= backlash / 2"
backlash = "0.1 mm"
g0 = 9.81
ratio = 2.5
radius = "50 mm"
speed = "1500 rpm"
rise = "20 ms"
turn = "90 deg"
f0 = "10 Hz"
[body.pinion]
inertia = "= 1e-3 * ratio"
start = { v = "= speed" }
[body.wheel]
inertia = 0.002
[body.box]
mass = "= (1 + ratio) * 2"
gravity = "= -1 / 2"
start = { s = "= -half" }
[body.table]
motion = { offset = "= half", amplitude = "= backlash", frequency = "= f0", rate = 0.1 }
[spring.k]
between = ["table", "box"]
stiffness = "= 48e3 - 2 * 3 - 1"
damping = "= 60 / 2 / 3"
preload = "= -ratio"
[damper.d]
between = ["ground", "wheel"]
damping = "= 0.1"
[stop.front]
arms = { pinion = "= radius", wheel = "= radius * ratio" }
gap = "= half"
stiffness = "= 1e6"
damping = 3.0
[stop.hard]
between = ["ground", "box"]
gap = "= 1e-2 + half"
restitution = "= 1 / ratio"
[friction.guide]
between = ["ground", "wheel"]
force = { constant = "= ratio" }
static = { constant = "= 2 * ratio", steps = [["= rise", "= 1 + ratio"]] }
[link.l]
arms = { pinion = "= ratio", wheel = 1.0 }
[load.shaker]
on = "box"
harmonics = [{ amplitude = "= ratio", frequency = "= speed / (2 * pi)", phase = "= turn" }, { amplitude = 1.0, frequency = 3.0 }]
steps = [["0.1 s", 2.0], ["= 10 * rise + 0.1", "= -ratio * 2"]]
"#;

fn read(text: &str) -> Description {
    parse(text, "m.toml", &no_records).unwrap()
}

/// The machine without its parameters, i.e. with literal numbers.
fn plain(machine: &Description) -> Description {
    Description { named: Default::default(), ..machine.clone() }
}

fn following() -> Vec<(&'static str, f64)> {
    let (half, speed) = (0.1 / 1e3 / 2.0, 1500.0 * PI / 30.0);
    vec![
        ("half", half),
        ("gravity", 9.81),
        ("body.pinion.inertia", 1e-3 * 2.5),
        ("body.pinion.start.v", speed),
        ("body.box.mass", 7.0),
        ("body.box.gravity", -0.5),
        ("body.box.start.s", -half),
        ("body.table.motion.constant", half),
        ("body.table.motion.amplitude", 0.1 / 1e3),
        ("body.table.motion.frequency", 10.0),
        ("spring.k.stiffness", 47_993.0),
        ("spring.k.damping", 10.0),
        ("spring.k.preload", -2.5),
        ("damper.d.damping", 0.1),
        ("stop.front.arms.pinion", 0.05),
        ("stop.front.arms.wheel", 0.05 * 2.5),
        ("stop.front.gap", half),
        ("stop.front.stiffness", 1e6),
        ("stop.hard.gap", 1e-2 + half),
        ("stop.hard.restitution", 0.4),
        ("friction.guide.force", 2.5),
        ("friction.guide.static.constant", 5.0),
        ("friction.guide.static.steps[0].time", 0.02),
        ("friction.guide.static.steps[0].height", 3.5),
        ("link.l.arms.pinion", 2.5),
        ("load.shaker.harmonics[0].amplitude", 2.5),
        ("load.shaker.harmonics[0].frequency", speed / TAU),
        ("load.shaker.harmonics[0].phase", 90.0 * PI / 180.0),
        ("load.shaker.steps[1].time", 10.0 * 0.02 + 0.1),
        ("load.shaker.steps[1].height", -2.5 * 2.0),
    ]
}

#[test]
fn numbers_follow_from_parameters_bit_for_bit() {
    // The start contradicts the link, which is irrelevant here.
    let text = NAMED.replace("start = { v = \"= speed\" }", "start = { v = \"= speed - speed\" }");
    let machine = read(&text);
    for (name, value) in following() {
        let value = if name == "body.pinion.start.v" { 0.0 } else { value };
        assert_eq!(machine.get(name).unwrap().to_bits(), value.to_bits(), "{name}");
    }
    let found: Vec<_> = machine.following().into_iter().map(|own| own.name).collect();
    let names: Vec<_> = following().into_iter().map(|pair| pair.0).collect();
    assert_eq!(found, names);
    let settable: Vec<_> = machine.parameters().into_iter().map(|p| (p.name, p.unit)).collect();
    assert!(names.iter().all(|name| settable.iter().all(|own| own.0 != *name)));
    let named = &settable[settable.len() - 8..];
    let named: Vec<_> = named.iter().map(|own| (own.0.as_str(), own.1)).collect();
    let units =
        [("backlash", "m"), ("g0", "1"), ("ratio", "1"), ("radius", "m"), ("speed", "rad/s"), ("rise", "s")];
    assert_eq!(named, [&units[..], &[("turn", "rad"), ("f0", "Hz")]].concat());
    // The file keeps the parameters, and a file of literal numbers is the same machine.
    assert_eq!(read(&machine.to_toml()), machine);
    assert!(machine.to_toml().contains("gap = \"= half\"\n"));
    assert_eq!(read(&plain(&machine).to_toml()), plain(&machine));
}

#[test]
fn a_changed_parameter_is_a_file_with_that_value() {
    let text = NAMED.replace("start = { v = \"= speed\" }", "");
    let mut machine = read(&text);
    machine.replace("backlash", 2e-4).unwrap();
    assert_eq!(plain(&machine), plain(&read(&text.replace("\"0.1 mm\"", "2e-4"))));
    let both = machine.with([("ratio", 2.0), ("spring.k.damping", 1.0)]).unwrap_err();
    assert_eq!(both.to_string(), "spring.k.damping: is fixed by its expression `= 60 / 2 / 3`");
    for (name, said) in [
        (
            "stop.front.gap",
            "stop.front.gap: follows from `backlash` by the expression `= half`; change `backlash` instead",
        ),
        (
            "half",
            "half: follows from `backlash` by the expression `= backlash / 2`; change `backlash` instead",
        ),
        (
            "stop.front.arms.wheel",
            "stop.front.arms.wheel: follows from `ratio`, `radius` by the expression `= radius * ratio`; change `ratio`, `radius` instead",
        ),
    ] {
        assert_eq!(machine.clone().replace(name, 1.0).unwrap_err().to_string(), said);
        assert_eq!(machine.parameter(name).unwrap_err().to_string(), said);
    }
    let before = machine.clone();
    for (name, value, said) in [
        (
            "ratio",
            0.0,
            "ratio = 0.0: then stop.hard.restitution = 1 / ratio: divides by zero; change the expression or a parameter in its divisor",
        ),
        ("ratio", f64::NAN, "ratio = NaN: must be a finite number"),
        (
            "ratio",
            0.5,
            "ratio = 0.5: then stop.hard.restitution = 1 / ratio = 2.0: expected a number from 0 to 1",
        ),
        ("radius", 1e308, "radius = 1e308: then stop.front.arms.wheel = radius * ratio: is not finite"),
        ("backlas", 1.0, "backlas: no parameter has this name; did you mean `backlash`?"),
    ] {
        assert_eq!(machine.replace(name, value).unwrap_err().to_string(), said);
    }
    assert_eq!(machine, before);
}

#[test]
fn refusals_name_the_expression_and_its_line() {
    let with = |parameters: &str, gap: &str| {
        let text = format!(
            "name = \"M\"\n[body.b]\nmass = 1.0\n[stop.s]\nbetween = [\"ground\", \"b\"]\ngap = {gap}\nrestitution = 0.5\n[parameters]\n\
             {parameters}"
        );
        parse(&text, "m.toml", &no_records).err().map(|refused| refused.to_string()).unwrap_or_default()
    };
    const VALUE: &str =
        "expected a number, with or without a unit, or an expression such as \"= backlash / 2\"";
    for (parameters, gap, said) in [
        ("a = 1.0", "\"= b\"", "6: stop.s.gap = \"= b\": no parameter is called `b`; expected one of a".to_owned()),
        ("backlash = 1", "\"= backlsh\"", "6: stop.s.gap = \"= backlsh\": no parameter is called `backlsh`; did you mean `backlash`?".into()),
        ("a = 1.0", "\"a\"", "6: stop.s.gap = \"a\": an expression begins with `=`; write \"= a\"".into()),
        ("a = 0.0", "\"= 1 / a\"", "6: stop.s.gap = \"= 1 / a\": divides by zero; change the expression or a parameter in its divisor".into()),
        ("a = 1e200", "\"= a * a\"", "6: stop.s.gap = \"= a * a\": is not finite".into()),
        ("a = 1.0", "\"= (a\"", "6: stop.s.gap = \"= (a\": a `)` is missing at the end of the expression".into()),
        ("a = 1.0", "\"= 2 mm\"", "6: stop.s.gap = \"= 2 mm\": expected an operator before `mm`: + - * /; numbers in an expression are in SI, without a unit".into()),
        ("a = 1.0", "\"= a *\"", "6: stop.s.gap = \"= a *\": expected a number, `pi`, a parameter, `-` or `(` at the end of the expression".into()),
        ("a = \"= b\"\nb = \"= a + 1\"", "1.0", "9: a = \"= b\": depends on itself: its expression leads back to `a`; break this loop".into()),
        ("a = \"= 1 / b\"\nb = 0", "1.0", "9: a = \"= 1 / b\": divides by zero; change the expression or a parameter in its divisor".into()),
        ("a = \"b\"\nb = 0", "1.0", "9: a = \"b\": an expression begins with `=`; write \"= b\"".into()),
        ("a = \"2 g\"", "1.0", "9: a = \"2 g\": `g` is ambiguous (gram or 9.80665 m/s2): use kg for a mass, or m/s2 for an acceleration".into()),
        ("a = \"2 ells\"", "1.0", "9: a = \"2 ells\": `ells` is not a known unit; expected a unit such as mm, N or rad/s".into()),
        ("a = [1]", "1.0", format!("9: a = [1]: {VALUE}")),
        ("stop = 1", "1.0", "9: stop = 1: this name is reserved; use another name".into()),
        ("time = 1", "1.0", "9: time = 1: this name is reserved; use another name".into()),
        ("pi = 1", "1.0", "9: pi = 1: this name is reserved; use another name".into()),
    ] {
        let said = format!("m.toml:{said}").replace("9: ", "9: parameters.");
        assert_eq!(with(parameters, gap), said);
    }
    let record =
        "name = \"M\"\n[body.b]\nmass = 1.0\n[load.l]\non = \"b\"\ntable = [[0.0, \"= 1\"], [1.0, 2.0]]\n";
    assert_eq!(
        parse(record, "m.toml", &no_records).unwrap_err().to_string(),
        "m.toml:6: load.l.table[0,1]: an expression in a record is not supported; use a number"
    );
}

/// The example with parameters has the same motion as the one with literal numbers.
#[test]
fn second_method_the_example_moves_as_the_one_with_numbers() {
    let end = |name: &str| {
        let path =
            std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/assembly").join(name);
        let machine = vibro_machine::file::read(&path).unwrap();
        let mut motion =
            vibro_machine::Motion::new(vibro_machine::Assembly::new(machine).unwrap().into()).unwrap();
        motion.advance_to(0.02).unwrap();
        motion.states().to_vec()
    };
    // Quotients such as speed / ratio are rounded differently from the literal numbers.
    const ROUNDING: f64 = 1e-10;
    for (found, written) in end("play_by_one_number.toml").iter().zip(end("gear_backlash.toml")) {
        assert!((found - written).abs() < ROUNDING * written.abs(), "{found} and {written}");
    }
}

/// An error caused by parameters is reported under the names of all parameters that cause it; an
/// error of another number is not.
#[test]
fn a_parameter_is_blamed_for_what_follows_from_it_alone() {
    let machine = read(
        r#"
        name = "M"
        [parameters]
        play = "0.1 m"        # of both sides
        reach = "= 2 * play"  # further on
        soft = 0.5
        [body.b]
        mass = 1.0
        start = { s = 0.05 }
        [stop.s]
        between = ["ground", "b"]
        gap = "= reach - play"
        restitution = "= soft"
        [stop.t]
        between = ["b", "ground"]
        gap = 0.1
        restitution = "= soft / play * 0.1"
        "#,
    );
    let refused = |changes: &[(&str, f64)]| machine.with(changes.iter().copied()).unwrap_err().to_string();
    // The moved stop excludes the start.
    assert!(refused(&[("play", 0.01)]).starts_with("play = 0.01: then "), "{}", refused(&[("play", 0.01)]));
    let both = refused(&[("play", 0.2), ("soft", 4.0)]);
    let lines: Vec<_> = both.lines().collect();
    assert_eq!(lines[0], "soft = 4.0: then stop.s.restitution = soft = 4.0: expected a number from 0 to 1");
    assert!(
        lines[1].starts_with("play = 0.2, soft = 4.0: then stop.t.restitution = soft / play * 0.1 = 2.0")
    );
    assert_eq!(refused(&[("body.b.mass", -1.0)]), "body.b.mass = -1.0: must be greater than 0");
    let other = refused(&[("soft", 0.4), ("body.b.start.s", 0.3)]);
    assert!(!other.contains("soft"), "{other}");
    // Comments are kept, and give the meaning.
    let meaning = |name: &str| machine.parameter(name).unwrap().meaning;
    assert_eq!([meaning("play"), meaning("soft")], ["of both sides", "Named parameter"]);
    assert_eq!(machine.following()[0].meaning, "further on");
    assert!(machine.to_toml().contains("reach = \"= 2 * play\" # further on\n"));
}

/// Both indices of a matrix element are in one pair of brackets, as in FMI's structured names; the
/// spelling with two pairs is accepted.
#[test]
fn a_matrix_has_one_name_a_number_and_another_spelling() {
    let text = r#"
        name = "M"
        parameters = { g = 2.0 }
        body.b = { mass = 1.0 }
        load.l = { on = "b", from = "c.y" }
        [block.c]
        inputs = ["b.s", "b.v"]
        d = [[-1.0, "= -g"]]
        outputs = ["y"]
    "#;
    let mut machine = read(text);
    let names: Vec<_> = machine.parameters().into_iter().map(|own| own.name).collect();
    assert!(names.contains(&"block.c.d[0,0]".to_owned()) && !names.iter().any(|name| name.contains("][")));
    for name in ["block.c.d[0,0]", "block.c.d[0][0]"] {
        machine.replace(name, -3.0).unwrap();
        assert_eq!((machine.get("block.c.d[0,0]").unwrap(), machine.get(name).unwrap()), (-3.0, -3.0));
        machine.replace(name, -1.0).unwrap();
    }
    for name in ["block.c.d[0,1]", "block.c.d[0][1]"] {
        assert_eq!(machine.get(name).unwrap(), -2.0);
        assert!(machine.replace(name, 1.0).unwrap_err().to_string().contains("follows from `g`"));
    }
    let wrong = parse(&text.replace("-1.0,", "\"x\","), "m.toml", &no_records).unwrap_err().to_string();
    assert!(wrong.contains("m.toml:8: block.c.d[0,0] = \"x\""), "{wrong}");
}
