//! The doors' second component, the bouncing ball, as an FMU of both versions in FMPy.

mod common;

use common::ball;
use common::python::{command, python, root, run};

#[test]
fn closed_form_of_the_bouncing_ball_in_fmpy() {
    let (folder, library) = ball::described("ball");
    let mut script = command(python());
    script.arg(root().join("tests/fmpy/second_component.py")).arg(&folder).arg(&library);
    run("running it in FMPy", &mut script);
}
