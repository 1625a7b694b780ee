//! Starts at rest with blocks that read no body, and errors in files of blocks.

use crate::blocks::{check_derivatives, column};
use crate::common::*;
use vibro_machine::file::{no_records, parse};
use vibro_machine::{Assembly, Motion};

/// A hundred roundings of numbers of order one.
const ROUNDING: f64 = 1e-13;

/// A mass on a spring of 100 N/m under 2 N per unit of a block's output.
fn mass(block: &str) -> String {
    format!(
        r#"
        name = "Mass"
        start = "rest"
        body.mass = {{ mass = 1.0 }}
        spring.k = {{ between = ["ground", "mass"], stiffness = 100.0, damping = 1.0 }}
        load.push = {{ on = "mass", from = "block.y", factor = 2.0 }}
        signal.level = {{ constant = 5.0 }}
        block.block = {{ outputs = ["y"], {block} }}
    "#
    )
}

/// Blocks with outputs at the start, each with its first output.
const BLOCKS: [(&str, f64); 5] = [
    (r#"inputs = ["level"], d = [[1.5]]"#, 7.5),
    (r#"inputs = ["level"], d = [[1.5]], limits = { y = [-3, 3] }"#, 3.0),
    (r#"inputs = [], a = [[-1.0]], c = [[0.5]], start = [4.0]"#, 2.0),
    (r#"inputs = ["level"], d = [[1.5]], sample = 0.1, limits = { y = [-inf, 6] }"#, 6.0),
    (
        r#"inputs = ["level"], a = [[0.5]], b = [[1.0]], c = [[3.0]], d = [[1.0]], start = [1.0], sample = 0.1"#,
        8.0,
    ),
];

#[test]
fn closed_form_a_start_at_rest_bears_what_blocks_put_out() {
    for (block, y) in BLOCKS {
        let m = moving(&mass(block));
        near(column(&m, "block.y"), y, ROUNDING);
        near(column(&m, "mass.s"), 2.0 * y / 100.0, ROUNDING);
        near(column(&m, "mass.a"), 0.0, ROUNDING);
    }
    // Until the first output of a delayed block acts, the block outputs 0.
    let late = moving(&mass(r#"inputs = ["level"], d = [[1.5]], sample = 0.1, delay = 0.01"#));
    near(column(&late, "mass.s"), 0.0, ROUNDING);
}

#[test]
fn second_method_derivatives_of_starts_at_rest_beside_blocks() {
    let names: [&[&str]; 5] = [
        &["block.block.d[0,0]", "signal.level.constant", "load.push.factor", "spring.k.stiffness"],
        &["block.block.limits.y[1]", "signal.level.constant", "load.push.factor"],
        &["block.block.start[0]", "block.block.c[0,0]", "block.block.a[0,0]"],
        &["block.block.limits.y[1]", "block.block.d[0,0]", "load.push.factor"],
        &[
            "block.block.d[0,0]",
            "block.block.start[0]",
            "block.block.c[0,0]",
            "block.block.a[0,0]",
            "signal.level.constant",
        ],
    ];
    for ((block, _), names) in BLOCKS.into_iter().zip(names) {
        // Central differences with a relative step of 1e-5.
        check_derivatives(&mass(block), names, 0.37, &["mass.s", "mass.v", "block.y"], 1e-5, 1e-7);
    }
}

#[test]
fn golden_refusals_of_outputs_say_one_thing() {
    let free = |block: &str| mass(block).replace("start = \"rest\"", "");
    let twice = mass(r#"inputs = ["level"], d = [[1.5], [1.0]]"#).replace("[\"y\"]", "[\"y\", \"y\"]");
    let said = refusal(&twice);
    assert!(said.contains("block.block.outputs[1] = \"y\": is given twice; keep one of them"), "{said}");
    assert!(!said.contains("rows"), "{said}");
    let said = refusal(&free(r#"inputs = ["level"], d = [[1.5]], limits = { y = [inf, 3] }"#));
    assert!(said.contains("block.block.limits.y[0] = inf: expected a finite number or -inf"), "{said}");
    let fast = free(r#"inputs = [], a = [[-1e120]], c = [[1.0]]"#);
    let d = parse(&fast, "fast.toml", &no_records).expect("a machine");
    let error = Assembly::new(d).expect_err("a rate beyond all bounds").to_string();
    assert!(error.contains("block.block.a"), "{error}");
}

/// The first sample reads an input that is set at the start.
#[test]
fn closed_form_the_first_sample_reads_the_inputs_of_the_start() {
    let text = mass(r#"inputs = ["level"], d = [[1.5]], sample = 0.1"#);
    let text = text.replace("start = \"rest\"", "").replace("constant = 5.0", "input = true");
    let assembly = std::sync::Arc::new(Assembly::new(machine(&text)).expect("a machine"));
    assert!(assembly.has_samples());
    let given = [(0, [4.0, 0.0, 0.0, 0.0])];
    let mut m = Motion::starting_under(assembly.clone(), 0.0, &given).expect("a motion");
    near(column(&m, "block.y"), 6.0, ROUNDING);
    m.advance_to(0.05).expect("a motion");
    near(column(&m, "block.y"), 6.0, ROUNDING);
    // An input that is set after the sample waits for the next sample.
    let mut late = Motion::new(assembly).expect("a motion");
    late.set_input(0, given[0].1).expect("an input");
    late.advance_to(0.05).expect("a motion");
    near(column(&late, "block.y"), 0.0, ROUNDING);
    late.advance_to(0.15).expect("a motion");
    near(column(&late, "block.y"), 6.0, ROUNDING);
}
