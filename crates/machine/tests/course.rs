//! Machines integrated by a solver that uses only derivatives and indicators, compared with the
//! exact motion; and machines whose parameters change during a motion.

use crate::common::*;
use std::path::Path;
use std::sync::Arc;
use vibro_machine::description::*;
use vibro_machine::mode::{FrictionState, StopState};
use vibro_machine::motion::Course;
use vibro_machine::{Assembly, Error, Motion, file};

/// Upper bound of the events of these motions.
const MOST_EVENTS: usize = 1000;

/// A servo with sampled and continuous blocks; without a quantum, which would amplify errors.
const SERVO: &str = include_str!("../../machine-component/tests/common/blocks.toml");

/// Solver of fixed step: the fourth-order Runge-Kutta method, with roots of indicators by
/// bisection.
struct Solver {
    motion: Motion,
    course: Course,
    events: usize,
}

impl Solver {
    fn new(assembly: &Arc<Assembly>) -> Self {
        let mut motion = Motion::new(assembly.clone()).unwrap();
        let course = motion.begin_course().unwrap();
        Self { motion, course, events: 0 }
    }

    fn slope(&mut self, time: f64, states: &[f64]) -> Vec<f64> {
        self.motion.place_at(&self.course, time);
        self.motion.set_states(states);
        self.motion.state_derivatives()
    }

    /// The states after a step `h`.
    fn stepped(&mut self, time: f64, x: &[f64], h: f64) -> Vec<f64> {
        let along =
            |k: &[f64], part: f64| -> Vec<f64> { x.iter().zip(k).map(|(x, k)| x + part * h * k).collect() };
        let a = self.slope(time, x);
        let b = self.slope(time + 0.5 * h, &along(&a, 0.5));
        let c = self.slope(time + 0.5 * h, &along(&b, 0.5));
        let d = self.slope(time + h, &along(&c, 1.0));
        (0..x.len()).map(|i| x[i] + h / 6.0 * (a[i] + 2.0 * (b[i] + c[i]) + d[i])).collect()
    }

    fn put(&mut self, time: f64, states: &[f64]) -> bool {
        self.motion.place_at(&self.course, time);
        self.motion.set_states(states);
        self.motion.indicators().iter().any(|indicator| *indicator <= 0.0)
    }

    fn run(&mut self, end: f64, step: f64) {
        while self.motion.time() < end {
            let (time, x) = (self.motion.time(), self.motion.states().to_vec());
            let knot = self.motion.next_knot_on(&self.course).unwrap_or(f64::INFINITY);
            let to = (time + step).min(end).min(knot);
            let mut h = to - time;
            let next = self.stepped(time, &x, h);
            if self.put(to, &next) {
                let mut low = 0.0;
                while h - low > 1e-15 * to.max(1.0) {
                    let middle = 0.5 * (low + h);
                    let there = self.stepped(time, &x, middle);
                    if self.put(time + middle, &there) { h = middle } else { low = middle }
                }
                let there = self.stepped(time, &x, h);
                self.put(time + h, &there);
            }
            if self.motion.accept(&mut self.course) {
                self.motion.handle_on(&mut self.course, &mut |_| ()).unwrap();
                self.events += 1;
                assert!(self.events < MOST_EVENTS, "at {}", self.motion.time());
                assert!(!self.motion.accept(&mut self.course.clone()), "at {}", self.motion.time());
            }
        }
    }
}

/// Error of the method where the third derivative of the motion jumps, and of late events, relative
/// to places of 0.01 m and speeds of 1 m/s.
const AT_EDGES: f64 = 1e-6;

#[test]
fn second_method_a_solver_follows_contacts_with_an_exponent() {
    let text = "name = \"C\"\ngravity = 9.81\n\
        body.b = { mass = 0.3, gravity = 1.0 }\n\
        stop.h = { between = [\"ground\", \"b\"], gap = 0.02, stiffness = 2e5, exponent = 1.5, dissipation = 0.3 }\n\
        stop.top = { between = [\"b\", \"ground\"], gap = 0.001, stiffness = 3e4, exponent = 1.25, damping = 2.0 }\n\
        damper.air = { between = [\"ground\", \"b\"], quadratic = 0.1 }\n\
        load.l = { on = \"b\", amplitude = 4.0, frequency = 6.0 }\n";
    let description = file::parse(text, "c.toml", &file::no_records).unwrap();
    let assembly = Arc::new(Assembly::new(description).unwrap());
    let mut solver = Solver::new(&assembly);
    solver.run(0.5, 1e-5);
    let mut motion = Motion::new(assembly).unwrap();
    let mut events = 0;
    motion.advance_observed(0.5, &mut |_| events += 1).unwrap();
    assert!(events > 6 && solver.events >= events, "{events} {}", solver.events);
    for k in 0..2 {
        let (own, exact) = (solver.motion.body(0)[k], motion.body(0)[k]);
        assert!((own - exact).abs() < AT_EDGES * [0.01_f64, 1.0][k].max(exact.abs()), "{own} {exact}");
    }
}

fn example(name: &str) -> Arc<Assembly> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/assembly").join(name);
    Arc::new(Assembly::new(file::read(&path.with_extension("toml")).unwrap()).unwrap())
}

#[test]
fn second_method_a_solver_by_derivatives_and_indicators_finds_the_exact_motion() {
    // Relative to the nominal values of states: error of the method and late events, magnified by
    // impacts.
    const AGREEMENT: f64 = 1e-6;
    // Relative to the largest energy: error of the method and late events.
    const BALANCE: f64 = 1e-7;
    // Name, end, step, least number of events.
    let machines = [
        ("bouncing_ball", 4.0, 1e-2, 6),
        ("impact_on_spring", 0.1, 1e-5, 1),
        ("msl_elastogap", 2.0, 1e-3, 3),
        ("msl_coupled_clutches", 1.5, 1e-3, 7),
        ("coulomb_oscillator", 0.2, 1e-5, 4),
        ("damper_with_buffer", 0.3, 2e-5, 10),
        ("impact_pair", 20.0, 1e-3, 3),
        ("gear_backlash", 0.05, 1e-5, 1),
        ("cradle", 1.0, 1e-4, 1),
        ("laws", 0.7, 1e-4, 6),
        ("stepped", 0.8, 2e-5, 20),
        ("blocks", 0.3, 2e-5, 100),
    ];
    for (name, end, step, events) in machines {
        let assembly = match name {
            "laws" => Arc::new(Assembly::new(laws()).unwrap()),
            "blocks" => assembled(&SERVO.replace("quantum = { cart = { s = 1e-6 } }\n", "")),
            "stepped" => Arc::new(Assembly::new(stepped()).unwrap()),
            _ => example(name),
        };
        let mut solver = Solver::new(&assembly);
        let origin = {
            let (k, s) = solver.motion.kinetic_and_stored();
            k + s
        };
        solver.run(end, step);
        let mut exact = Motion::new(assembly.clone()).unwrap();
        exact.advance_to(end).unwrap();
        assert!(solver.events >= events, "{name}: {}", solver.events);
        let nominals = assembly.nominals();
        for (k, (a, b)) in solver.motion.states().iter().zip(exact.states()).enumerate() {
            assert!((a - b).abs() <= AGREEMENT * nominals[k].max(b.abs()), "{name}: state {k}: {a} {b}");
        }
        assert_eq!(solver.motion.mode().stops, exact.mode().stops, "{name}");
        let (kinetic, stored) = solver.motion.kinetic_and_stored();
        let accounts = solver.motion.energy_on(&solver.course);
        let residual = kinetic + stored - origin - accounts.balance();
        let size = kinetic.max(stored.abs()).max(origin.abs()).max(accounts.impacts.value());
        assert!(residual.abs() <= BALANCE * size, "{name}: {residual} of {size}");
    }
}

#[test]
fn closed_form_a_ball_comes_to_rest_on_a_course() {
    // sqrt(2 h/g) (1 + e)/(1 - e); bounces below about 1e-9 of the height are skipped, with their
    // time.
    const REST: f64 = 8.578_949_178_728_89;
    let mut solver = Solver::new(&example("bouncing_ball"));
    solver.run(9.0, 1e-2);
    // At rest the solver integrates the rounding of the forces' balance, relative to g.
    let [s, v] = solver.motion.states()[..] else { unreachable!("a ball has two states") };
    assert!((s - 1.0).abs() < 1e-14 && v.abs() < 1e-14, "{s} {v}");
    // Time of the skipped bounces: 2 u/(g (1 - e)) with u² = 2 g · 1e-9.
    assert!(solver.events > 90 && solver.events < 110, "{} until {REST}", solver.events);
}

/// Bounces end although a stop loses little or no energy, and between two stops in series, one of
/// which drives the body from the other.
#[test]
fn second_method_bounces_end_on_a_course_as_in_the_exact_motion() {
    // For coordinates, late events amplified by impacts; for rates, the rates of skipped bounces.
    const AGREEMENT: f64 = 1e-6;
    let rubbed = |restitution: f64, force: f64| Description {
        gravity: 10.0,
        bodies: vec![heavy("ball", 2.0, 1.0, 0.0, 0.0)],
        stops: vec![rigid("floor", &[(0, 1.0)], 1.0, restitution)],
        frictions: vec![friction(&[(0, 1.0)], force)],
        ..Description::default()
    };
    let between = |first: f64, second: f64| Description {
        bodies: vec![body("a", 0.11, -0.77, -0.51), body("b", 0.39, 0.75, -1.39)],
        springs: vec![spring(&[(0, 1.0)], 4.1, 1.9), spring(&[(1, 1.0)], 13.9, 0.0)],
        stops: vec![
            rigid("block", &[(1, -1.0), (0, 1.0)], -1.49, first),
            rigid("wall", &[(1, -1.0)], -0.58, second),
        ],
        ..Description::default()
    };
    for (name, machine, rests) in [
        ("rubbed", rubbed(1.0, 6.0), true),
        ("hardly lossy", rubbed(1.0 - 1e-12, 0.0), false),
        ("plastic on bouncing", between(0.0, 0.5), true),
        ("elastic on plastic", between(1.0, 0.0), true),
    ] {
        let assembly = Arc::new(Assembly::new(machine).unwrap());
        let (mut solver, mut exact) = (Solver::new(&assembly), Motion::new(assembly.clone()).unwrap());
        solver.run(5.0, 1e-3);
        exact.advance_to(5.0).unwrap();
        for (a, b) in solver.motion.states().iter().zip(exact.states()) {
            assert!((a - b).abs() < AGREEMENT * b.abs().max(1.0), "{name}: {a} {b}");
        }
        let closed = solver.motion.mode().stops.iter().all(|state| *state == StopState::Closed);
        assert!(closed == rests, "{name}: {:?}", solver.motion.mode());
    }
}

/// A solver's error moves a closed stop off its gap to either side. If a friction reverses
/// meanwhile, the error causes no impact and does not open the stop, and the friction reverses
/// once.
#[test]
fn closed_form_a_box_rests_on_a_shaken_table_while_its_guide_turns_round() {
    // Amplitude of the table, m; its acceleration is about half of g.
    const AMPLITUDE: f64 = 2e-3;
    // Half a period of the table, s.
    const HALF: f64 = 1.0 / 16.0;
    // Reversals of the friction: one per half period, after the first quarter period.
    const TURNS: usize = 20;
    let shaken = |restitution: f64| Description {
        gravity: 10.0,
        bodies: vec![
            heavy("box", 2.0, -1.0, 0.0, AMPLITUDE * std::f64::consts::PI / HALF),
            prescribed("table", sine(AMPLITUDE, 0.5 / HALF, 0.0), 0.0),
        ],
        stops: vec![rigid("contact", &[(0, -1.0), (1, 1.0)], 0.0, restitution)],
        frictions: vec![friction(&[(0, 1.0)], 3.0)],
        loads: vec![Load {
            name: "push".into(),
            body: 0,
            force: Signal { input: true, ..Signal::default() },
        }],
        ..Description::default()
    };
    for restitution in [0.0, 0.5, 1.0] {
        for step in [4e-3, 2e-3, 1e-3] {
            let assembly = Arc::new(Assembly::new(shaken(restitution)).unwrap());
            let mut solver = Solver::new(&assembly);
            for turn in 0..TURNS {
                solver.run((turn as f64 + 1.0) * HALF, step);
                let state = solver.motion.mode().stops[0];
                assert_eq!(state, StopState::Closed, "{restitution} {step} {turn}");
                let way = if turn % 2 == 1 { FrictionState::Up } else { FrictionState::Down };
                assert_eq!(solver.motion.mode().frictions[0], way, "{restitution} {step} {turn}");
                assert_eq!(solver.motion.impacts(0).count, 0, "{restitution} {step} {turn}");
            }
            // Setting an input while the stop is off its gap causes no event either.
            for off in [-1e-8, 1e-8] {
                let mut set = solver.motion.clone();
                let states: Vec<f64> = set.states().iter().map(|x| x + off).collect();
                set.set_states(&states);
                set.set_inputs_on(&mut solver.course.clone(), &[(0, [1.0, 0.0, 0.0, 0.0])]).unwrap();
                assert_eq!((set.mode().stops[0], set.impacts(0).count), (StopState::Closed, 0), "{off}");
            }
            // The solver's rate may pass zero before the table's; the contact is then corrected
            // first, which is an event of its own.
            assert!(solver.events <= 2 * TURNS, "{restitution} {step} {}", solver.events);
        }
    }
}

/// A table that a host sets between events has no rate, so that a box at rest on it keeps its
/// coordinate until an event. If the table has returned by then, or is a little lower, no stop is
/// violated, and the box is placed on it.
#[test]
fn a_table_that_is_set_back_at_an_event_does_not_hit_the_box_on_it() {
    let description = Description {
        gravity: 10.0,
        bodies: vec![
            heavy("box", 2.0, -1.0, 0.0, 0.0),
            prescribed(
                "table",
                Signal { input: true, steps: vec![Step { time: 0.1, height: 1e-3 }], ..Signal::default() },
                0.0,
            ),
        ],
        stops: vec![rigid("contact", &[(0, -1.0), (1, 1.0)], 0.0, 0.5)],
        ..Description::default()
    };
    let assembly = Arc::new(Assembly::new(description).unwrap());
    for (between, at, time) in
        [(-0.01, 0.0, 0.05), (-0.01, -5e-3, 0.05), (-1e-9, 0.0, 0.05), (0.01, 0.0, 0.05), (-0.01, -0.01, 0.1)]
    {
        let mut motion = Motion::new(assembly.clone()).unwrap();
        let mut course = motion.begin_course().unwrap();
        motion.place_at(&course, time);
        motion.set_input_on(&mut course, 0, between);
        motion.handle_on(&mut course, &mut |_| ()).unwrap();
        let step = if time < 0.1 { 0.0 } else { 1e-3 };
        motion.set_inputs_on(&mut course, &[(0, [at, 0.0, 0.0, 0.0])]).unwrap();
        assert_eq!(
            (motion.mode().stops[0], motion.impacts(0).count),
            (StopState::Closed, 0),
            "{between} {at}"
        );
        assert_eq!(motion.states(), [at + step, 0.0], "{between} {at}");
    }
}

/// An impact is detected late. Its correction moves a body onto the gap of another stop, which the
/// impact then closes with an impact of its own. Bodies that fall together have no events: the
/// force between them is exactly zero, not the rounding of their weights.
#[test]
fn invariant_a_stop_that_the_impact_of_another_drives_shut_has_its_own_impact() {
    // Relative to the initial energy: error of the method and late events.
    const BALANCE: f64 = 1e-9;
    // After the end of the bounces in flight, and before the floor is met.
    const END: f64 = 0.7;
    let pile = Description {
        gravity: 10.0,
        bodies: vec![
            heavy("a", 1.178_564_385_441_606, 1.0, -0.691_228_594_068_854_1, -0.299_602_400_762_734_26),
            heavy("b", 0.169_824_442_960_325_45, 1.0, -1.864_588_999_553_841_8, -0.580_524_020_808_613_3),
            heavy("c", 7.020_282_044_627_496, 1.0, -2.434_958_035_573_696, -0.506_737_524_653_467_8),
        ],
        stops: vec![
            rigid("floor", &[(0, 1.0)], 0.0, 0.999_999_999),
            rigid("ab", &[(1, 1.0), (0, -1.0)], -0.031_555_031_848_786_594, 0.3),
            rigid("bc", &[(2, 1.0), (1, -1.0)], -0.042_416_871_717_701_82, 0.3),
        ],
        ..Description::default()
    };
    let mut solver = Solver::new(&Arc::new(Assembly::new(pile).unwrap()));
    let energy = |solver: &Solver| {
        let (kinetic, stored) = solver.motion.kinetic_and_stored();
        kinetic + stored - solver.motion.energy_on(&solver.course).balance()
    };
    let start = energy(&solver);
    solver.run(END, 2e-3);
    let residual = energy(&solver) - start;
    assert!(residual.abs() < BALANCE * start.abs(), "{residual} of {start}");
}

/// A stiff spring holds a light part on a stop of a heavy one. The rounding of the spring's force
/// exceeds the excess of the friction force at the late event: the part sticks until the excess is
/// significant, which is correct.
#[test]
fn closed_form_a_part_slips_that_a_stiff_spring_holds_on_a_stop() {
    const FREQUENCY: f64 = 1.17;
    // Largest delay after the theoretical instant of slipping, s, halved down to rounding.
    const LATEST: f64 = 1e-3;
    const HALVES: i32 = 50;
    // Number of halvings, to 1.6e-5 s, up to which the excess of the force is significant.
    const SURE: i32 = 6;
    let machine = Description {
        bodies: vec![body("part", 0.013, -0.0535, 0.0), body("heavy", 10.0, -0.04, 0.0)],
        springs: vec![spring(&[(1, 1.0)], 64.0, 0.0), spring(&[(0, -1.0), (1, 1.0)], 4.4e5, 4.2e3)],
        stops: vec![rigid("seat", &[(0, 1.0), (1, -1.0)], -0.0135, 0.5)],
        frictions: vec![friction(&[(0, 1.0)], 10.5)],
        loads: vec![Load { name: "pull".into(), body: 0, force: sine(18.0, FREQUENCY, 0.0) }],
        ..Description::default()
    };
    let slips = ((10.5f64 - 64.0 * 0.04) / 18.0).asin() / (std::f64::consts::TAU * FREQUENCY);
    let mut stuck = Motion::new(Arc::new(Assembly::new(machine).unwrap())).unwrap();
    let course = stuck.begin_course().unwrap();
    // A solver's rounding of states at rest.
    let start: Vec<f64> = stuck.states().iter().map(|x| x + 1e-20).collect();
    for half in 0..HALVES {
        let mut late = stuck.clone();
        late.place_at(&course, slips + LATEST * 0.5f64.powi(half));
        late.set_states(&start);
        late.handle_on(&mut course.clone(), &mut |_| ()).unwrap();
        let friction = late.mode().frictions[0];
        assert!(
            friction == FrictionState::Up || (half > SURE && friction == FrictionState::Stuck),
            "{half} {friction:?}"
        );
    }
}

#[test]
fn closed_form_a_stiffness_that_changes_under_way() {
    // One or two roundings of the phase.
    const ROUNDING: f64 = 1e-14;
    let mut machine = Description { bodies: vec![body("b", 1.0, 1.0, 0.0)], ..Description::default() };
    machine.springs = vec![spring(&[(0, 1.0)], 4.0, 0.0)];
    let mut stiffer = machine.clone();
    stiffer.springs[0].stiffness = 9.0;
    let stiffer = Arc::new(Assembly::new(stiffer).unwrap());
    let mut whole = motion(machine);
    whole.advance_to(0.3).unwrap();
    let mut on = whole.changed(stiffer).unwrap();
    on.advance_to(0.8).unwrap();
    // cos 2t, then the continuation with 3 rad/s.
    let (s, v) = ((0.6f64).cos(), -2.0 * (0.6f64).sin());
    let expected = s * 1.5f64.cos() + v / 3.0 * 1.5f64.sin();
    assert!((on.body(0)[0] - expected).abs() < ROUNDING, "{}", on.body(0)[0] - expected);
}

/// The force of a closed stop takes a few products and a quotient, each rounded.
const ROUNDED: f64 = 1e-15;

#[test]
fn closed_form_a_stop_gives_way_or_is_violated_where_its_gap_changes() {
    let machine = |gap: f64, gravity: f64| Description {
        gravity,
        bodies: vec![heavy("ball", 2.0, 1.0, 0.0, 0.0)],
        stops: vec![rigid("floor", &[(0, 1.0)], gap, 0.0)],
        ..Description::default()
    };
    let presses = |motion: &Motion, force: f64| {
        let [e, rate, f] = motion.stop(0);
        assert!(e == 0.0 && rate == 0.0 && (f - force).abs() <= ROUNDED * force, "{e} {rate} {f}");
    };
    let mut resting = motion(machine(0.0, 10.0));
    resting.advance_to(1.0).unwrap();
    presses(&resting, 20.0);
    // More weight increases the force; a lowered floor lets the box fall; a raised floor is
    // refused by name.
    let heavier = resting.changed(Arc::new(Assembly::new(machine(0.0, 20.0)).unwrap())).unwrap();
    presses(&heavier, 40.0);
    let mut falling = resting.changed(Arc::new(Assembly::new(machine(0.5, 10.0)).unwrap())).unwrap();
    falling.advance_to(1.1).unwrap();
    assert!((falling.body(0)[0] - 0.05).abs() < 1e-15 && falling.stop(0)[2] == 0.0);
    let risen = Description { bodies: vec![heavy("ball", 2.0, 1.0, -1.0, 0.0)], ..machine(-0.5, 10.0) };
    let refused = resting.changed(Arc::new(Assembly::new(risen).unwrap())).unwrap_err();
    assert!(matches!(&refused, Error::Violated { stop, .. } if stop == "stop.floor"), "{refused}");
    presses(&resting, 20.0);
}
