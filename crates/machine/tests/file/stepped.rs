//! Stepping stiffness in files: written and read back, and errors.

use vibro_machine::file::{no_records, parse};

fn mesh(stiffness: &str) -> String {
    format!(
        "name = \"Mesh\"\n[body.gear]\nmass = 1.0\n[spring.mesh]\nbetween = [\"ground\", \"gear\"]\nstiffness = {stiffness}\n"
    )
}

#[test]
fn invariant_stiffness_that_steps_is_read_back_equal() {
    let named = "[parameters]\nheight = \"9 N/m\"\n";
    let step = "{ constant = 4.0, steps = [[0.1, \"= height\"]], repeat = 0.31 }\npreload = 0.7";
    let own = include_str!("../data/stepped.toml").to_owned();
    for text in [own, mesh(step).replace("[body.gear]", &format!("{named}[body.gear]"))] {
        let own = parse(&text, "m.toml", &no_records).unwrap_or_else(|problem| panic!("{problem}"));
        assert_eq!(parse(&own.to_toml(), "m.toml", &no_records).unwrap(), own);
    }
}

#[test]
fn refusals_say_what_a_stiffness_may_be() {
    let refused = |stiffness: &str| parse(&mesh(stiffness), "m.toml", &no_records).unwrap_err().to_string();
    let says = |stiffness: &str, words: &[&str]| {
        let said = refused(stiffness);
        words.iter().for_each(|word| assert!(said.contains(word), "{said}"));
    };
    let only = "is not supported in a stiffness, which is constant between its steps; use `constant` with";
    says("{ constant = 2.0, amplitude = 1.0, frequency = 3.0 }", &["spring.mesh.stiffness.amplitude", only]);
    let sweep = "{ constant = 2.0, sweep = { amplitude = 1.0, from = 1.0, to = 2.0, duration = 3.0 } }";
    says(sweep, &["spring.mesh.stiffness.sweep", only]);
    says("{ constant = 2.0, input = true }", &["spring.mesh.stiffness.input", only]);
    says(
        "{ table = [[0.0, 1.0], [1.0, 2.0]] }",
        &["spring.mesh.stiffness.table", "requires interpolation = \"hold\""],
    );
    says("{ constant = 2.0 }", &["does not step"]);
    says(
        "{ constant = 2.0, steps = [[0.1, -3.0]] }",
        &["steps[0].height = -3.0", "-1.0 N/m", "must be at least 0", "-2.0 N/m or more"],
    );
    says("{ constant = -2.0, steps = [[0.1, 3.0]] }", &["before the first step"]);
    says("{ table = [[0.0, -1.0], [1.0, 2.0]], interpolation = \"hold\" }", &["this value of the table"]);
    says(
        "{ constant = 1.0, steps = [[0.1, 1.0]], table = [[0.0, 1.0], [1.0, 2.0]], interpolation = \"hold\" }",
        &["cannot be combined with `table`"],
    );
    let many = (0..64).map(|k| format!("[{k}.5, 1.0]")).collect::<Vec<_>>().join(", ");
    says(&format!("{{ constant = 1.0, steps = [{many}] }}"), &["has 65 levels; expected at most 64"]);
    says("{ constant = \"2 N\", steps = [[0.1, 1.0]] }", &["N/m"]);
}
