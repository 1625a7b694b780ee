//! Derivatives over a step, compared with differences of steps, with each other, and with the
//! exact orbit's stability.

use super::*;
use crate::component::variables::Edition;
use vibro_impact::parameters::Parameters;

type Matrix = [[f64; 6]; 6];

const STATES: [&str; 6] = structure::STATES;
const FF: EventHandling = EventHandling { event_mode: false, early_return: false };
const TT: EventHandling = EventHandling { event_mode: true, early_return: true };

/// An instance of an extended description from given start values.
fn started(handling: EventHandling, start: &[(&str, f64)]) -> Instance {
    let start_settings = Settings { stop_at_impact: true, ..Settings::default() };
    let protocol =
        Protocol { handling, start: start_settings, edition: Edition::Extended, ..Protocol::default() };
    let mut fmu = Instance::of_protocol(Interface::CoSimulation, protocol);
    for (name, value) in start {
        set(&mut fmu, name, *value).unwrap();
    }
    let mut fmu = initialize(fmu);
    if handling.event_mode {
        fmu.handle_events(&mut Messages::default()).unwrap();
        fmu.leave_event(&mut Messages::default()).unwrap();
    }
    fmu
}

fn advance(fmu: &mut Instance, size: f64) -> StepOutcome {
    let time = fmu.time();
    fmu.step_as_agreed(time, size, &mut Messages::default()).unwrap()
}

fn states(fmu: &mut Instance) -> [f64; 6] {
    STATES.map(|name| get(fmu, name))
}

fn transition(fmu: &mut Instance) -> Matrix {
    let mut matrix = [[f64::NAN; 6]; 6];
    fmu.get(ANY, &[reference("step.transition")], |i, value| matrix[i / 6][i % 6] = value).unwrap();
    matrix
}

fn response(fmu: &mut Instance) -> [[f64; 12]; 6] {
    let mut matrix = [[f64::NAN; 12]; 6];
    fmu.get(ANY, &[reference("step.response")], |i, value| matrix[i / 12][i % 12] = value).unwrap();
    matrix
}

fn product(a: &Matrix, b: &Matrix) -> Matrix {
    std::array::from_fn(|i| std::array::from_fn(|j| (0..6).map(|k| a[i][k] * b[k][j]).sum()))
}

fn norm(a: &Matrix) -> f64 {
    a.iter().flatten().map(|x| x * x).sum::<f64>().sqrt()
}

/// Step and tolerance of fourth-order differences. Their error is the fourth power of the step
/// times a fifth derivative, and the rounding divided by the step.
const STEP: f64 = 3e-5;
const DIFFERENCE: f64 = 1e-7;

/// Derivative of states at zero shift.
fn difference(at: impl Fn(f64) -> [f64; 6]) -> [f64; 6] {
    let [a, b, c, d] = [-2.0, -1.0, 1.0, 2.0].map(|places| at(places * STEP));
    std::array::from_fn(|i| (8.0 * (c[i] - b[i]) - (d[i] - a[i])) / (12.0 * STEP))
}

fn assert_near(found: f64, difference: f64, what: &str) {
    assert!((found - difference).abs() <= DIFFERENCE * (1.0 + found.abs()), "{what}: {found} {difference}");
}

const START: [(&str, f64); 6] = [
    ("box.s", 0.02),
    ("block.s", 0.9),
    ("secondary.s", -0.3),
    ("box.v", 0.1),
    ("block.v", 0.5),
    ("secondary.v", 0.2),
];

#[test]
fn second_method_transition_across_impacts_by_differences() {
    // In flight, across the first impact, across several.
    for size in [0.05, 2.5, 14.0] {
        let mut fmu = started(FF, &START);
        advance(&mut fmu, size);
        let impacts = get(&mut fmu, "impacts.upper") + get(&mut fmu, "impacts.lower");
        assert_eq!(impacts > 0.0, size > 1.0);
        let exact = transition(&mut fmu);
        for (j, name) in STATES.iter().enumerate() {
            let at = |shift: f64| {
                let start = START.map(|(own, value)| (own, if own == *name { value + shift } else { value }));
                let mut fmu = started(FF, &start);
                advance(&mut fmu, size);
                states(&mut fmu)
            };
            let differences = difference(at);
            for i in 0..6 {
                assert_near(exact[i][j], differences[i], &format!("{i} {name} over {size}"));
            }
        }
    }
}

#[test]
fn second_method_response_to_loads_by_differences() {
    for size in [0.05, 2.5, 5.0] {
        let inputs = ["box.f", "block.f", "secondary.f"];
        let run = |shift: f64, body: usize, order: usize| {
            let mut fmu = started(FF, &START);
            for (i, name) in inputs.iter().enumerate() {
                set(&mut fmu, name, 0.01 + if i == body && order == 0 { shift } else { 0.0 }).unwrap();
                for k in 1..4 {
                    let value = 0.002 + if i == body && order == k { shift } else { 0.0 };
                    fmu.set_input_derivatives(&[reference(name)], &[k as i32], &[value]).unwrap();
                }
            }
            advance(&mut fmu, size);
            fmu
        };
        let mut fmu = run(0.0, 0, 0);
        let exact = response(&mut fmu);
        for body in 0..3 {
            for order in 0..4 {
                let differences = difference(|shift| states(&mut run(shift, body, order)));
                for i in 0..6 {
                    let what = format!("{i} load {body} order {order} over {size}");
                    assert_near(exact[i][4 * body + order], differences[i], &what);
                }
            }
        }
    }
}

/// Steps that end before each law: the product of the matrices read after the events is the matrix
/// of the whole step; a matrix read before an event lacks the jump.
#[test]
fn invariant_products_of_steps_between_impacts() {
    const ROUNDING: f64 = 1e-9;
    let mut whole = started(FF, &START);
    advance(&mut whole, 20.0);
    let mut fmu = started(TT, &START);
    let mut matrix: Matrix = std::array::from_fn(|i| std::array::from_fn(|j| f64::from(u8::from(i == j))));
    let mut impacts = 0;
    while fmu.time() < 20.0 {
        let size = 20.0 - fmu.time();
        let end = advance(&mut fmu, size);
        let before = transition(&mut fmu);
        if end.event {
            fmu.enter_event().unwrap();
            let shown = transition(&mut fmu);
            fmu.handle_events(&mut Messages::default()).unwrap();
            fmu.leave_event(&mut Messages::default()).unwrap();
            assert!(norm(&shown) != norm(&before), "the jump");
            assert_eq!(transition(&mut fmu), shown);
            impacts += 1;
        }
        matrix = product(&transition(&mut fmu), &matrix);
    }
    assert!(impacts > 3);
    let expected = transition(&mut whole);
    for (a, b) in matrix.iter().flatten().zip(expected.iter().flatten()) {
        assert!((a - b).abs() <= ROUNDING * norm(&expected), "{a} {b}");
    }
}

/// Over half a period of the exact orbit the matrix is the half-cycle map's, at another section:
/// its spectral radius agrees with the value of `steady` from closed forms.
#[test]
fn second_method_spectral_radius_of_the_exact_orbit() {
    const SAME: f64 = 1e-8;
    const SQUARINGS: i32 = 34; // of the matrix: the norm's constant factor then counts for 1e-10
    for (amplitude, phase) in [(0.15, 0.3), (0.12, 2.0)] {
        let start = [("drive.amplitude", amplitude), ("drive.phase", phase), ("startOnOrbit", 1.0)];
        let mut fmu = started(FF, &start);
        advance(&mut fmu, 0.5 * Parameters::default().period());
        assert_eq!(get(&mut fmu, "impacts.upper") + get(&mut fmu, "impacts.lower"), 1.0);
        let mut power = transition(&mut fmu);
        let mut logarithm = 0.0; // of the power's scale, per factor
        for i in 0..SQUARINGS {
            let size = norm(&power);
            logarithm += size.ln() / 2_f64.powi(i);
            power = power.map(|row| row.map(|x| x / size));
            power = product(&power, &power);
        }
        logarithm += norm(&power).ln() / 2_f64.powi(SQUARINGS);
        let expected = get(&mut fmu, "steady.spectralRadius");
        assert!((logarithm.exp() - expected).abs() < SAME, "{amplitude}: {} {expected}", logarithm.exp());
    }
}

/// In resting contact only the joint motion of box and block remains, also through release and the
/// flight after it.
#[test]
fn second_method_through_rest_and_release() {
    let rest = [
        ("box.s", 0.1),
        ("block.s", 1.1),
        ("box.v", 0.3),
        ("block.v", 0.3),
        ("block.f", 0.5),
        ("secondary.v", 0.2),
    ];
    for (size, state) in [(0.5, 2.0), (4.0, 1.0)] {
        let run = |name: &str, shift: f64| {
            let start = rest.map(|(own, value)| {
                let together = own == name || own == name.replace("box", "block");
                (own, if together { value + shift } else { value })
            });
            let mut fmu = started(FF, &start);
            assert_eq!(get(&mut fmu, "stop.state"), 2.0);
            set(&mut fmu, "block.f", 0.5).unwrap();
            // A growing pull releases the block.
            fmu.set_input_derivatives(&[reference("block.f")], &[1], &[-0.5]).unwrap();
            advance(&mut fmu, size);
            fmu
        };
        let mut fmu = run("", 0.0);
        assert_eq!(get(&mut fmu, "stop.state"), state, "after {size}");
        let exact = transition(&mut fmu);
        for (j, name) in [(0, "box.s"), (3, "box.v"), (5, "secondary.v")] {
            let differences = difference(|shift| states(&mut run(name, shift)));
            for i in 0..6 {
                let together = if j < 5 { exact[i][j + 1] } else { 0.0 };
                assert_near(exact[i][j] + together, differences[i], &format!("{i} {name} {size}"));
            }
        }
    }
}

#[test]
fn without_a_step_it_is_that_of_no_time() {
    let mut fmu = started(TT, &START);
    let identity = transition(&mut fmu);
    assert!((0..6).all(|i| (0..6).all(|j| identity[i][j] == f64::from(u8::from(i == j)))));
    advance(&mut fmu, 0.1);
    assert_ne!(transition(&mut fmu), identity);
    let saved = fmu.save();
    fmu.restore(&saved).unwrap();
    assert_eq!(transition(&mut fmu), identity, "a restored state has made no step");
    let mut closed = started(TT, &[("mode", 3.0)]);
    advance(&mut closed, 0.1);
    assert_eq!(transition(&mut closed), identity);
}
