//! Studies from given starts: each motion begins there, at the start's time.

use super::*;
use crate::axis::ParameterAxis;
use crate::design_sweep::{Designs, SampledAxis, SweepRequest, row};
use crate::diagram::{DiagramRequest, diagram};
use crate::isoperiodic::{IsoperiodicRequest, PlaneMachine};
use crate::parts::Task;

/// A body that friction of 3 N holds within 0.03 m against a spring of 100 N/m, next to a stop.
const HELD: &str = "name = \"H\"\n[body.a]\nmass = 2.0\n[spring.k]\nbetween = [\"ground\", \"a\"]\nstiffness = 100.0\n\
    [friction.f]\nbetween = [\"ground\", \"a\"]\nforce = 3.0\n[stop.s]\nbetween = [\"ground\", \"a\"]\ngap = 0.05\nrestitution = 1.0\n";

/// An undamped body that a stop reflects if it gets that far.
const FREE: &str = "name = \"F\"\n[body.a]\nmass = 2.0\n[spring.k]\nbetween = [\"ground\", \"a\"]\nstiffness = 800.0\n\
    [stop.s]\nbetween = [\"ground\", \"a\"]\ngap = 0.05\nrestitution = 1.0\n";

fn looked_at(file: &str, period: f64) -> Machine {
    Machine { section: SectionRule::Period(period), ..text(file) }
}

fn start(machine: &Machine, numbers: &[(&str, f64)]) -> Start {
    let mut start = Start::default();
    numbers.iter().for_each(|(name, x)| start.set(&machine.description, name, *x).unwrap());
    start
}

fn axis(name: &str, ends: (f64, f64)) -> ParameterAxis<String> {
    ParameterAxis::of(name.to_owned(), ends, 3).unwrap()
}

#[test]
fn closed_form_a_diagram_begins_at_its_start_in_either_direction_and_with_each_value_anew() {
    let machine = looked_at(HELD, 0.1);
    for anew in [false, true] {
        let request = DiagramRequest {
            axis: axis("spring.k.stiffness", (50.0, 100.0)),
            of: "a.s".parse().unwrap(),
            at_section: true,
            discard: 5,
            keep: 4,
            exponents: None,
            anew,
            start: start(&machine, &[("a.s", 0.02), ("time", 7.0)]),
        };
        let found = diagram(&machine, &request, &Task::ALL).unwrap().unwrap();
        let met: Vec<_> = found.up.iter().chain(&found.down).flatten().map(|p| &p.maxima).collect();
        assert_eq!(met.len(), if anew { 3 } else { 6 });
        let near = |(s, _): &(f64, u32)| (s - 0.02).abs() < 1e-8;
        assert!(met.iter().all(|maxima| maxima.len() == 1 && near(&maxima[0])), "{met:?}");
        let beyond = DiagramRequest { start: start(&machine, &[("a.s", 0.06)]), ..request };
        let error = beyond.check(&machine).unwrap_err().to_string();
        assert!(error.contains("stop.s.gap = 0.05 m: e - gap = "), "{error}");
    }
}

#[test]
fn closed_form_each_start_of_a_design_has_the_amplitude_of_its_motion() {
    let machine = looked_at(FREE, 0.1);
    let request = SweepRequest::<Machine> {
        designs: Designs::Grid(vec![SampledAxis { name: "body.a.mass".into(), values: vec![2.0] }]),
        starts: vec![
            start(&machine, &[("a.s", 0.01)]),
            // 0.6 m/s over 20/s.
            start(&machine, &[("time", 3.0), ("a.v", 0.6)]),
            start(&machine, &[("a.s", 0.06)]),
        ],
        measures: vec!["amplitude.a.s".parse().unwrap()],
        discard: 20,
        ..SweepRequest::default()
    };
    let one = |k: usize| {
        row(&machine, &SweepRequest { starts: vec![request.starts[k].clone()], ..request.clone() }, 0)
    };
    for (k, amplitude) in [(0, 0.01), (1, 0.03)] {
        let found = one(k).outputs[0].unwrap().largest;
        assert!((found - amplitude).abs() < 1e-9, "{found}");
    }
    assert!(one(2).reason.unwrap().contains("a rigid stop requires e <= gap"));
    assert!(
        (row(&machine, &SweepRequest { starts: request.starts[..2].to_vec(), ..request.clone() }, 0).outputs
            [0]
        .unwrap()
        .largest
            - 0.03)
            .abs()
            < 1e-9
    );
    assert_eq!(request.motion(1).1.to_string(), "time=3.0,a.v=0.6");
}

#[test]
fn second_method_every_motion_of_a_plane_begins_at_its_start() {
    let machine = looked_at(FREE, 0.1);
    let contacts = |s: f64| {
        let request = IsoperiodicRequest::<Machine> {
            x: axis("body.a.mass", (1.9, 2.1)),
            y: axis("stop.s.gap", (0.04, 0.05)),
            start: start(&machine, &[("a.s", s)]),
            discard: 20,
            exponents: None,
        };
        machine.check_plane(&request).unwrap();
        machine.points(&request, 0..3, &mut ()).into_iter().map(|p| p.unwrap().contacts).collect::<Vec<_>>()
    };
    assert!(contacts(0.03).iter().all(|&contacts| contacts == 0.0));
    // Undamped, it would swing to the same distance on the stop's side.
    assert!(contacts(-0.06).iter().all(|&contacts| contacts > 0.2));
}
