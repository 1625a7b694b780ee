//! Numbers so small or lists so empty that they allow no motion.

use vibro_machine::file::{no_records, parse};

fn said(line: &str) -> String {
    let text = format!(
        "name = \"M\"\nbody.a = {{ mass = 1.0 }}\nspring.k = {{ between = [\"ground\", \"a\"], stiffness = 10.0 }}\n{line}\n"
    );
    parse(&text, "m.toml", &no_records).map_or_else(|refusal| refusal.to_string(), |_| "read".into())
}

/// Lines with a number of a size that no motion allows, each with words of its error.
const SAID: [(&str, &str); 17] = [
    (
        "load.l = { on = \"a\", sweep = { amplitude = 1.0, from = 1.0, to = 2.0, duration = 1e-300 } }",
        "m.toml:4: load.l.sweep.duration = 1e-300: must be at least 1e-9 s",
    ),
    (
        "load.l = { on = \"a\", sweep = { amplitude = 1.0, from = 1e-300, to = 2.0, duration = 1.0 } }",
        "m.toml:4: load.l.sweep.from = 1e-300: must be 0, or at least 1e-12 Hz",
    ),
    ("load.l = { on = \"a\", sweep = { amplitude = 1.0, from = 0.0, to = 2.0, duration = 1.0 } }", "read"),
    (
        "load.l = { on = \"a\", steps = [[0.0, 1.0]], repeat = 1e-299 }",
        "m.toml:4: load.l.repeat = 1e-299: must be at least 1e-9 s",
    ),
    (
        "load.l = { on = \"a\", amplitude = 1.0, frequency = \"1e-320 Hz\" }",
        "m.toml:4: load.l.frequency = \"1e-320 Hz\": must be at least 1e-12 Hz",
    ),
    (
        "spring.s = { between = [\"ground\", \"a\"], stiffness = 1.0, series_damping = 1e-320 }",
        "m.toml:4: spring.s.series_damping = 1e-320: must be at least 1e-150 N.s/m",
    ),
    (
        "spring.s = { between = [\"ground\", \"a\"], stiffness = 1e-320, series_damping = 1.0 }",
        "m.toml:4: spring.s.stiffness = 1e-320: must be at least 1e-150 N/m",
    ),
    ("spring.s = { between = [\"ground\", \"a\"], stiffness = 0.0 }", "read"),
    (
        "parameters.small = 1e-200\nload.l = { on = \"a\", amplitude = 1.0, frequency = \"= small\" }",
        "m.toml:5: load.l.frequency = \"= small\": is 1e-200; must be at least 1e-12 Hz",
    ),
    (
        "load.l = { on = \"a\", table = [[0.0, 1.0], [1e-320, 2.0]] }",
        "m.toml:4: load.l.table[1] = [1e-320, 2.0]: must be at least 1e-12 s after 0.0 s, the time of the previous row; only interpolation = \"hold\" allows less",
    ),
    ("load.l = { on = \"a\", table = [[0.0, 1.0], [1e-320, 2.0]], interpolation = \"hold\" }", "read"),
    (
        "load.l = { on = \"a\", steps = [] }",
        "m.toml:4: load.l.steps = []: is empty; expected a list of [time, height], such as [[0.4, 20.0]]",
    ),
    (
        "load.l = { on = \"a\", sweep = [] }",
        "m.toml:4: load.l.sweep = []: is empty; expected a sweep such as ",
    ),
    (
        "load.l = { on = \"a\", harmonics = [] }",
        "m.toml:4: load.l.harmonics = []: is empty; expected a list such as ",
    ),
    (
        "matrix.tube = { mass = [[1.0]], stiffness = [[1.0]], gravity = [1.0], nodes = { t = 0 } }",
        "m.toml:4: matrix.tube.gravity: requires `gravity` at the top level of the file, such as `gravity = \"9.81 m/s2\"`",
    ),
    (
        "modal.beam = { frequencies = [1.0, 2.0], gravity = [1.0, 2.0], nodes = { t = [1.0, 1.0] } }",
        "m.toml:4: modal.beam.gravity: requires `gravity` at the top level of the file, such as `gravity = \"9.81 m/s2\"`",
    ),
    (
        "parameters = { bad = \"5 foo\", good = 1.0 }\nspring.s = { between = [\"ground\", \"a\"], stiffness = \"= bad\", damping = \"= good\" }",
        "m.toml:4: parameters.bad = \"5 foo\": `foo` is not a known unit; expected a unit such as mm, N or rad/s",
    ),
];

#[test]
fn errors_of_extremes_have_name_value_and_what_is_allowed() {
    for (line, expected) in SAID {
        let found = said(line);
        assert!(found.starts_with(expected) && found.lines().count() == 1, "{line}\n{found}\n{expected}");
    }
}
