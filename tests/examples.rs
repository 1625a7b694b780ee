//! The examples run, with their assertions.

#[path = "../examples/closed_forms.rs"]
mod closed_forms;
#[path = "../examples/custom_load.rs"]
mod custom_load;
#[path = "../examples/run.rs"]
mod run;
#[path = "../examples/sweep.rs"]
mod sweep;

#[test]
fn invariant_the_examples_run() {
    for example in [run::main, custom_load::main, sweep::main, closed_forms::main] {
        example().unwrap();
    }
}
