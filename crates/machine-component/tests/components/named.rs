//! Named parameters and the numbers that follow from them, as variables of the FMU.

use crate::solver::{Silent, Solver, get, set};
use fmi_doors::description::{Causality, Variability, Variable};
use fmi_doors::{Bases, Component, Interface, Model, Phase};
use std::sync::Arc;
use vibro_machine_component::{FILE, Plan};

/// A ball between two stops; the range of a restitution is 0 to 1, a stiffness is at least 0.
const BALL: &str = r#"
name = "Ball"
[parameters]
play = "0.2 m"                   # from stop to stop, <clear>
bounce = 0.4
stiff = 8.0                      #of the spring
v0 = 0.5
half = "= play / 2"              # of the way
body.ball = { mass = 2.0, start = { v = "= v0" } }
spring.k = { between = ["ground", "ball"], stiffness = "= 3 * stiff - 6" }
stop.right = { between = ["ground", "ball"], gap = "= half", restitution = "= 1 - 2 * bounce" }
stop.left = { between = ["ball", "ground"], gap = "= half", restitution = "= bounce * bounce" }
"#;

fn plan() -> Arc<Plan> {
    // The table of parameters ends where the first dotted key of another table begins.
    let text = BALL.replace("body.ball", "[body]\nball").replace("spring.k", "[spring]\nk");
    let text = text.replace("stop.right", "[stop]\nright").replace("stop.left", "left");
    Arc::new(Plan::new(text, FILE).unwrap())
}

fn variable(plan: &Plan, name: &str) -> Variable {
    let all = plan.description().variables;
    all.into_iter().find(|variable| variable.name == name).unwrap_or_else(|| panic!("{name}"))
}

#[test]
fn golden_named_parameters_have_comment_use_and_range_and_what_follows_is_calculated() {
    let plan = plan();
    for (name, text, [min, max]) in [
        ("play", "from stop to stop, <clear>; sets stop.left.gap, stop.right.gap", [None, None]),
        // 0 <= 1 - 2 bounce <= 1; the square gives no limit.
        (
            "bounce",
            "Named parameter; sets stop.left.restitution, stop.right.restitution",
            [Some(0.0), Some(0.5)],
        ),
        ("stiff", "of the spring; sets spring.k.stiffness", [Some(2.0), None]),
        ("v0", "Named parameter; sets body.ball.start.v", [None, None]),
    ] {
        let own = variable(&plan, name);
        assert_eq!((own.causality, &*own.description), (Causality::Parameter, text), "{name}");
        assert_eq!([own.min, own.max], [min, max], "{name}");
    }
    for (name, variability, text, [min, max]) in [
        ("half", Variability::Tunable, "of the way, by the expression `= play / 2`", [None, None]),
        (
            "stop.right.gap",
            Variability::Tunable,
            "Elongation at which the stop closes, by the expression `= half`",
            [None, None],
        ),
        (
            "stop.left.restitution",
            Variability::Tunable,
            "Restitution coefficient, by the expression `= bounce * bounce`",
            [Some(0.0), Some(1.0)],
        ),
        ("body.ball.start.v", Variability::Fixed, "Rate at time 0, by the expression `= v0`", [None, None]),
    ] {
        let own = variable(&plan, name);
        assert_eq!((own.causality, own.variability), (Causality::CalculatedParameter, variability), "{name}");
        assert_eq!((&*own.description, own.start, [own.min, own.max]), (text, None, [min, max]), "{name}");
        // FMI 2.0, 2.2.8; FMI 3.0.2, 2.4.8: each is an initial unknown, which names its knowns.
        let unknowns = plan.description().initial_unknowns;
        assert_eq!(unknowns.iter().filter(|unknown| unknown.reference == own.reference).count(), 1, "{name}");
    }
}

#[test]
fn closed_form_what_follows_is_read_as_it_follows_and_is_not_set() {
    let plan = plan();
    let place = |name: &str| plan.table.reference(name).unwrap();
    let mut machine = Solver::instance(&plan, Interface::CoSimulation);
    machine.set_experiment(None, 0.0, None).unwrap();
    machine.enter_initialization();
    let follows = |machine: &mut _, play: f64| {
        let all = ["half", "stop.left.gap", "stop.right.gap"].map(|name| get(machine, place(name)));
        assert_eq!(all, [Some(0.5 * play); 3]);
    };
    follows(&mut machine, 0.2);
    assert!(set(&mut machine, place("play"), 0.3));
    follows(&mut machine, 0.3);
    for phase in [Phase::Initialization, Phase::Step] {
        if phase == Phase::Step {
            machine.exit_initialization(&mut Silent).unwrap();
            assert!(set(&mut machine, place("play"), 0.4));
        }
        let refused = machine.set(Bases::REAL, &[place("stop.left.gap")], |_| 1.0).unwrap_err().to_string();
        assert!(
            refused.starts_with(
                "stop.left.gap, which follows from named parameters by the expression `= half`, cannot be set "
            ),
            "{refused}"
        );
    }
    follows(&mut machine, 0.4);
    // The motion uses them: 0.2 m at 0.5 m/s with a spring of 18 N/m, sin(3 t) · 0.5 / 3.
    machine.step_as_agreed(0.0, 0.4, &mut Silent).unwrap();
    let s = get(&mut machine, place("ball.s")).unwrap();
    assert!((s - (1.2f64).sin() * 0.5 / 3.0).abs() < 1e-12, "{s}");
}

#[test]
fn a_named_parameter_that_makes_a_number_wrong_is_refused_by_its_own_name() {
    let plan = plan();
    let place = |name: &str| plan.table.reference(name).unwrap();
    let begun = |values: &[(&str, f64)]| {
        let mut machine = Solver::instance(&plan, Interface::CoSimulation);
        machine.set_experiment(None, 0.0, None).unwrap();
        machine.enter_initialization();
        for (name, value) in values {
            assert!(set(&mut machine, place(name), *value));
        }
        let ended = machine.exit_initialization(&mut Silent).map_err(|problem| problem.to_string());
        (machine, ended.err().unwrap_or_default())
    };
    let wrong =
        "bounce = 0.75: then stop.right.restitution = 1 - 2 * bounce = -0.5: expected a number from 0 to 1";
    assert_eq!(begun(&[("bounce", 0.75), ("v0", 0.25)]).1, wrong);
    // During the motion it is refused at once, and nothing has changed.
    let (mut machine, ended) = begun(&[]);
    assert_eq!(ended, "");
    let refused = machine.set(Bases::REAL, &[place("bounce")], |_| 0.75).unwrap_err().to_string();
    assert_eq!((refused.as_str(), get(&mut machine, place("bounce"))), (wrong, Some(0.4)));
}
