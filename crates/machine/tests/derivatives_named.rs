//! Derivatives by named parameters, compared with sums of columns of the literal numbers.

use std::sync::Arc;
use vibro_machine::derivative::{By, Gradient};
use vibro_machine::{Assembly, Description, Differentiated, file};

/// Gears and a clutch with play, radii, frequency, step times and levels from parameters.
const NAMED: &str = r#"
name = "Named"
[parameters]
backlash = "0.1 mm"
radius = "50 mm"
ratio = 1.6
pulse = "50 Hz"
closing = "20 ms"
level = "= closing * 20"
speed = "1500 rpm"
[body.engine]
motion = { rate = "= speed", amplitude = "0.3 deg", frequency = "= pulse" }
[body.pinion]
inertia = "0.0004 kg m2"
start = { v = "= speed" }
[body.wheel]
inertia = "= 0.0008 * ratio * ratio"
start = { v = "= -speed / ratio" }
[body.brake]
inertia = "0.001 kg m2"
[spring.clutch]
between = ["engine", "pinion"]
stiffness = "1.5 kN m/rad"
damping = "0.5 N m s/rad"
[stop.drive_flank]
arms = { pinion = "= radius", wheel = "= radius * ratio" }
gap = "= backlash / 2"
stiffness = "2 MN/m"
damping = "400 N s/m"
[stop.coast_flank]
arms = { pinion = "= -radius", wheel = "= -radius * ratio" }
gap = "= backlash / 2"
restitution = 0.6
[friction.bearing]
between = ["brake", "wheel"]
force = { steps = [["= closing", "= level"]] }
static = { steps = [["= closing", "= 1.1 * level"]] }
[load.drag]
on = "wheel"
amplitude = 2.0
frequency = "= 1.5 * pulse"
"#;

const END: f64 = 0.05;
/// Rounding relative to the largest term of a sum.
const ROUNDING: f64 = 1e-9;
/// Terms smaller than this (SI) count as rounding.
const ZERO: f64 = 1e-12;

fn machine() -> Description {
    file::parse(NAMED, "named.toml", &file::no_records).unwrap()
}

/// For each parameter, the numbers that depend on it with their derivatives, by hand.
fn sums(speed: f64) -> Vec<(&'static str, Vec<(&'static str, f64)>)> {
    vec![
        ("backlash", vec![("stop.drive_flank.gap", 0.5), ("stop.coast_flank.gap", 0.5)]),
        (
            "radius",
            vec![
                ("stop.drive_flank.arms.pinion", 1.0),
                ("stop.drive_flank.arms.wheel", 1.6),
                ("stop.coast_flank.arms.pinion", -1.0),
                ("stop.coast_flank.arms.wheel", -1.6),
            ],
        ),
        (
            "ratio",
            vec![
                ("body.wheel.inertia", 0.0016 * 1.6),
                ("body.wheel.start.v", speed / 1.6 / 1.6),
                ("stop.drive_flank.arms.wheel", 0.05),
                ("stop.coast_flank.arms.wheel", -0.05),
            ],
        ),
        ("pulse", vec![("body.engine.motion.frequency", 1.0), ("load.drag.frequency", 1.5)]),
        (
            "speed",
            vec![
                ("body.engine.motion.rate", 1.0),
                ("body.pinion.start.v", 1.0),
                ("body.wheel.start.v", -1.0 / 1.6),
            ],
        ),
    ]
}

#[test]
fn second_method_a_column_by_a_parameter_is_the_sum_of_columns_by_what_follows() {
    let named = Arc::new(Assembly::new(machine()).unwrap());
    let plain = Description { named: Default::default(), ..machine() };
    let plain = Arc::new(Assembly::new(plain).unwrap());
    let sums = sums(machine().get("speed").unwrap());
    let columns: Vec<&str> = sums.iter().map(|sum| sum.0).collect();
    let terms: Vec<&str> = sums.iter().flat_map(|sum| sum.1.iter().map(|term| term.0)).collect();
    let mut own = Differentiated::new(named.clone(), &columns).unwrap();
    let mut apart = Differentiated::new(plain, &terms).unwrap();
    own.advance_to(END).unwrap();
    apart.advance_to(END).unwrap();
    assert_eq!(own.motion().states(), apart.motion().states(), "the motions have the same bits");
    let mut gradient = Gradient::new(named, &columns).unwrap();
    gradient.advance_to(END).unwrap();
    let quantities: Vec<_> = own.motion().assembly().description.quantities().collect();
    let mut totals = vec![(0.0, 0.0); columns.len()];
    for &quantity in &quantities {
        gradient.add(quantity, 1.0);
        let mut column = 0;
        for (p, (name, parts)) in sums.iter().enumerate() {
            let (mut sum, mut size) = (0.0, 0.0f64);
            for (_, weight) in parts {
                let term = weight * apart.derivative(quantity, column).expect("no event is lost");
                (sum, size, column) = (sum + term, size.max(term.abs()), column + 1);
            }
            let found = own.derivative(quantity, p).expect("no event is lost");
            assert!((found - sum).abs() <= ROUNDING * size + ZERO, "{name}: {found} and {sum} of {size}");
            totals[p] = (totals[p].0 + found, f64::max(totals[p].1, found.abs()));
        }
    }
    for (p, found) in gradient.gradient().unwrap().into_iter().enumerate() {
        let (found, (sum, size)) = (found.unwrap(), totals[p]);
        assert!(size > 0.0 && (found - sum).abs() <= ROUNDING * size, "{}: {found} and {sum}", columns[p]);
    }
}

/// Both levels of the clutch step at the same varying time; compared with central differences.
#[test]
fn differences_of_a_time_at_which_two_signals_step() {
    let assembly =
        |closing: f64| Arc::new(Assembly::new(machine().with([("closing", closing)]).unwrap()).unwrap());
    let mut own = Differentiated::new(assembly(0.02), &["closing"]).unwrap();
    let mut gradient = Gradient::new(assembly(0.02), &["closing"]).unwrap();
    let end = 0.022;
    own.advance_to(end).unwrap();
    gradient.advance_to(end).unwrap();
    let states = |closing: f64| {
        let mut motion = vibro_machine::Motion::new(assembly(closing)).unwrap();
        motion.advance_to(end).unwrap();
        motion.states().to_vec()
    };
    const STEP: f64 = 1e-7;
    let (above, below) = (states(0.02 + STEP), states(0.02 - STEP));
    let found = own.state_derivative(0).unwrap();
    let largest = found.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
    for (k, x) in found.iter().enumerate() {
        let difference = (above[k] - below[k]) / (2.0 * STEP);
        assert!((x - difference).abs() < 1e-4 * largest, "{k}: {x} and {difference} of {largest}");
    }
    assert!(largest > 1.0);
    let quantities: Vec<_> = own.motion().assembly().description.quantities().collect();
    quantities.iter().for_each(|&quantity| gradient.add(quantity, 1.0));
    let sum: f64 = quantities.iter().map(|&quantity| own.derivative(quantity, 0).unwrap()).sum();
    let found = gradient.gradient().unwrap()[0].clone().unwrap();
    assert!((found - sum).abs() < ROUNDING * sum.abs().max(largest), "{found} and {sum}");
}

#[test]
fn a_derivative_by_what_follows_is_refused_with_its_parameter() {
    let assembly = Arc::new(Assembly::new(machine()).unwrap());
    let refused =
        Differentiated::new(assembly.clone(), &[By::from("stop.drive_flank.gap")]).map(drop).unwrap_err();
    let said = "stop.drive_flank.gap: follows from `backlash` by the expression `= backlash / 2`; change `backlash` instead";
    assert_eq!(refused.to_string(), said);
    assert_eq!(Gradient::new(assembly, &["stop.drive_flank.gap"]).map(drop).unwrap_err().to_string(), said);
}
