//! Steps in pieces, and time in Model Exchange.

use crate::solver::{Silent, Solver, get, set};
use fmi_doors::hybrid::Pieces;
use fmi_doors::{Component, EventHandling, Interface, Life, Model, Piece};
use std::path::Path;
use std::sync::Arc;
use vibro_machine::file;
use vibro_machine_component::{FILE, Machine, Plan};

/// Rounding over half a second.
const ROUNDING: f64 = 1e-14;

fn ball() -> Arc<Plan> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/assembly/bouncing_ball.toml");
    Arc::new(Plan::of(&file::read(&path).unwrap()).unwrap())
}

fn begun(plan: &Arc<Plan>, handling: EventHandling) -> Machine {
    let mut machine = Machine::new(plan.clone(), Life::new(Interface::CoSimulation, handling));
    machine.set_experiment(None, 0.0, None).unwrap();
    machine.enter_initialization();
    machine.exit_initialization(&mut Silent).unwrap();
    if handling.event_mode {
        machine.leave_event(&mut Silent).unwrap();
    }
    machine
}

#[test]
fn closed_form_an_input_holds_its_last_value_after_a_step_in_which_it_had_a_course() {
    let text = "name = \"Sled\"\n[body.sled]\nmass = 4.0\n[load.push]\non = \"sled\"\ninput = true\n";
    let plan = Arc::new(Plan::new(text.into(), FILE).unwrap());
    let mut sled = begun(&plan, EventHandling::default());
    let mut pieces = Pieces::begin(&sled, 0.0, 0.5).unwrap();
    assert_eq!(pieces.left(&sled), 0.5);
    // t² + t³, whose derivatives at the step's end are not zero.
    let push = |t: f64| t * t + t * t * t;
    pieces.interpolate(&mut sled, plan.table.inputs[0], [0.0, 1.0, 2.0, 3.0].map(|k| push(k / 6.0)));
    pieces.start(&mut sled, &mut Silent).unwrap();
    assert_eq!(pieces.next(&mut sled, None, &mut Silent).unwrap(), Piece::End);
    let ended = pieces.end(&mut sled);
    assert_eq!((ended.time, ended.event, ended.early), (0.5, false, false));
    let v = (0.125 / 3.0 + 0.0625 / 4.0) / 4.0;
    let rate = plan.table.reference("sled.v").unwrap();
    assert!((get(&mut sled, rate).unwrap() - v).abs() < ROUNDING);
    sled.step_as_agreed(0.5, 0.5, &mut Silent).unwrap();
    let later = v + 0.5 * push(0.5) / 4.0;
    assert!((get(&mut sled, rate).unwrap() - later).abs() < ROUNDING);
}

#[test]
fn closed_form_what_changes_at_events_is_shown_once_they_are_handled() {
    let plan = ball();
    let mut ball = begun(&plan, EventHandling { event_mode: true, early_return: false });
    let [impacts, rate] = ["floor.impacts", "ball.v"].map(|name| plan.table.reference(name).unwrap());
    let mut pieces = Pieces::begin(&ball, 0.0, 0.5).unwrap();
    pieces.start(&mut ball, &mut Silent).unwrap();
    assert_eq!(pieces.next(&mut ball, None, &mut Silent).unwrap(), Piece::Event);
    // The fall over one metre.
    assert!((ball.time() - (2.0 / 9.81f64).sqrt()).abs() < ROUNDING);
    assert!(!pieces.ends_before_event());
    pieces.pass_event(&mut ball, &mut Silent);
    assert_eq!(pieces.next(&mut ball, None, &mut Silent).unwrap(), Piece::End);
    let ended = pieces.end(&mut ball);
    assert_eq!((ended.time, ended.event, ended.early), (0.5, true, false));
    assert_eq!(get(&mut ball, impacts), Some(0.0));
    assert!(get(&mut ball, rate).unwrap() < 0.0);
    ball.enter_event().unwrap();
    ball.handle_events(&mut Silent).unwrap();
    assert_eq!(get(&mut ball, impacts), Some(1.0));
}

#[test]
fn time_in_event_mode_is_the_present_one() {
    let mut solver = Solver::new(&ball());
    solver.step(0.125);
    let machine = &mut solver.machine;
    machine.enter_event().unwrap();
    machine.set_time(0.125).unwrap();
    let refused = machine.set_time(0.25).unwrap_err().to_string();
    assert!(refused.contains("time = 0.25: expected the present time in Event Mode"), "{refused}");
}

#[test]
fn closed_form_derivatives_of_an_input_that_are_not_set_are_zero() {
    let text = "name = \"Sled\"\n[body.sled]\nmass = 4.0\n[load.push]\non = \"sled\"\ninput = true\n";
    let plan = Arc::new(Plan::new(text.into(), FILE).unwrap());
    let rate = plan.table.reference("sled.v").unwrap();
    for (order, v) in [(1, 0.125 / 4.0), (2, 0.125 / 6.0 / 4.0), (3, 0.0625 / 24.0 / 4.0)] {
        let mut sled = begun(&plan, EventHandling::default());
        sled.set_input_derivatives(&[plan.table.inputs[0]], &[order], &[1.0]).unwrap();
        sled.step_as_agreed(0.0, 0.5, &mut Silent).unwrap();
        assert!((get(&mut sled, rate).unwrap() - v).abs() < ROUNDING, "{order}");
    }
}

#[test]
fn closed_form_an_input_is_zero_until_it_is_set() {
    let text = "name = \"Sled\"\n[body.sled]\nmass = 4.0\n[load.push]\non = \"sled\"\ninput = true\n";
    let plan = Arc::new(Plan::new(text.into(), FILE).unwrap());
    let input = plan.table.inputs[0];
    for interface in [Interface::CoSimulation, Interface::ModelExchange] {
        let mut sled = Solver::instance(&plan, interface);
        assert_eq!(get(&mut sled, input), Some(0.0));
        sled.set_experiment(None, 0.0, None).unwrap();
        sled.enter_initialization();
        assert_eq!(get(&mut sled, input), Some(0.0));
        assert!(set(&mut sled, input, 8.0));
        let acceleration = plan.table.reference("sled.a").unwrap();
        assert_eq!((get(&mut sled, input), get(&mut sled, acceleration)), (Some(8.0), Some(2.0)));
        sled.exit_initialization(&mut Silent).unwrap();
        assert_eq!((get(&mut sled, input), get(&mut sled, acceleration)), (Some(8.0), Some(2.0)));
        // The same as when it was made.
        sled.reset();
        assert_eq!(get(&mut sled, input), Some(0.0));
    }
}
