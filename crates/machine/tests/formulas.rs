//! Springs and dampers whose forces are formulas: motions in closed form, energies, events, ends.

use crate::common::assembled;
use std::f64::consts::PI;
use vibro_machine::derivative::Gradient;
use vibro_machine::file::{no_records, parse};
use vibro_machine::motion::{Event, EventKind, Motion};
use vibro_machine::{Assembly, Differentiated, Quantity, What};

fn described(text: &str) -> Result<vibro_machine::description::Description, String> {
    parse(text, "m.toml", &no_records).map_err(|refusal| refusal.to_string())
}

/// Rounding of a state after some periods, relative to its amplitudes.
const RETURNED: f64 = 1e-12;
/// Tolerance on the difference from 40 digits, divided by the motion's amplification of a change
/// of its start: some tens of roundings of coordinates and rates of order 1 to 10.
const ROUNDINGS: f64 = 1e-13;
/// Difference of the energy from its accounts, relative to the first energy.
const BALANCE: f64 = 1e-13;
/// Rate at which friction of the width 1e-5 m/s comes to rest.
const SMOOTHED: f64 = 2e-4;

/// Rounding of the invariants of a chaotic-looking but integrable chain over 100 s.
const TODA: f64 = 1e-12;
/// Rounding of states of order 1 after some oscillations, and of times of impacts, s.
const SINGLE: f64 = 2e-13;
/// Rounding of two motions over some impacts, and of their energies of some joules.
const SAME: f64 = 1e-11;
/// Largest difference of a derivative from 40 digits, relative to the largest of its column.
const OF_DERIVATIVE: f64 = 1e-9;
/// Shift of a number for central differences, and their relative tolerance: truncation, and
/// rounding divided by the shift.
const DIFFERENCE: f64 = 1e-6;
const OF_DIFFERENCE: f64 = 1e-6;

/// Complete elliptic integral of the first kind of a modulus by the arithmetic-geometric mean.
fn complete(modulus: f64) -> f64 {
    let (mut a, mut b) = (1.0, (1.0 - modulus * modulus).sqrt());
    for _ in 0..40 {
        (a, b) = (0.5 * (a + b), (a * b).sqrt());
    }
    PI / (2.0 * a)
}

/// Jacobi's sn by descending Landen transformations.
fn sn(u: f64, modulus: f64) -> f64 {
    let (mut means, mut a, mut b) = (Vec::new(), 1.0, (1.0 - modulus * modulus).sqrt());
    for _ in 0..20 {
        let c = 0.5 * (a - b);
        (a, b) = (0.5 * (a + b), (a * b).sqrt());
        means.push(c / a);
    }
    let mut angle = u * a * f64::from(1u32 << means.len());
    for c in means.iter().rev() {
        angle = 0.5 * (angle + (c * angle.sin()).asin());
    }
    angle.sin()
}

/// A pendulum that starts at rest at 170°: sin(φ/2) = k sn(K(k) - ω t).
#[test]
fn closed_form_pendulum_from_170_degrees() {
    let (inertia, moment, start) = (0.7f64, 2.3, 170.0 / 180.0 * PI);
    let text = format!(
        "name = \"Pendulum\"\n[parameters]\nm = 0.5\ng = 9.2\nl = 0.5\n\
         [body.arm]\ninertia = {inertia}\nstart = {{ s = {start} }}\n\
         [spring.weight]\nbetween = [\"ground\", \"arm\"]\nforce = \"= m*g*l * sin(e)\"\n"
    );
    let (omega, modulus) = ((moment / inertia).sqrt(), (start / 2.0).sin());
    let mut motion = Motion::new(assembled(&text)).expect("a motion");
    let period = 4.0 * complete(modulus) / omega;
    let mut largest = 0.0f64;
    for k in 1..=200 {
        let time = f64::from(k) * 0.02 * period;
        motion.advance_to(time).expect("an end");
        let exact = 2.0 * (modulus * sn(complete(modulus) - omega * time, modulus)).asin();
        largest = largest.max((motion.coordinate(0) - exact).abs());
    }
    assert!(largest < RETURNED, "{largest:e}");
    assert!((motion.body(0)[0] - start).abs() < RETURNED && motion.body(0)[1].abs() < RETURNED);
    let (kinetic, stored) = motion.kinetic_and_stored();
    let whole = moment * (1.0 - start.cos());
    assert!((kinetic + stored - whole).abs() < BALANCE * whole, "{:e}", kinetic + stored - whole);
}

/// Random chains against an extrapolation in 50 digits (`data/make_formulas.py`): number of
/// impacts, and states up to the rounding that the motion has amplified; the energy balances.
#[test]
fn second_method_random_chains_in_forty_digits() {
    let all = include_str!("data/formulas.txt");
    for row in all.lines() {
        let fields: Vec<&str> = row.split(';').collect();
        let number = |text: &str| text.trim().parse::<f64>().expect("a number");
        let (end, impacts, factor) = (number(fields[1]), number(fields[2]), number(fields[3]));
        let mut motion = Motion::new(assembled(&fields[0].replace('|', "\n"))).expect("a motion");
        let energy = |motion: &Motion| motion.kinetic_and_stored().0 + motion.kinetic_and_stored().1;
        let first = energy(&motion);
        let mut count = 0.0;
        let mut observer =
            |event: &Event| count += f64::from(u8::from(matches!(event.kind, EventKind::Impact { .. })));
        motion.advance_observed(end, &mut observer).expect("an end");
        assert_eq!(count, impacts, "{row}");
        let bodies = fields[4].split(',').count() / 2;
        for (k, x) in fields[4].split(',').map(number).enumerate() {
            let own = motion.body(k % bodies)[k / bodies];
            let off = (own - x).abs() / factor.max(1.0);
            assert!(off < ROUNDINGS, "{off:e}: {own} {x} of {row}");
        }
        let put_in = motion.energy().loads.iter().map(|own| own.value().abs()).sum::<f64>();
        let size = first.abs() + put_in + energy(&motion).abs() + 1.0;
        let off = energy(&motion) - first - motion.energy().balance();
        assert!(off.abs() < BALANCE * size, "{off:e} of {size} in {row}");
    }
}

/// The invariants of the Toda lattice: power sums of the eigenvalues of its matrix.
fn toda_invariants(q: &[f64], p: &[f64]) -> [f64; 3] {
    let a = |i: usize| (q[i] - q[(i + 1) % q.len()]).exp();
    let n = q.len();
    let sum = |of: &dyn Fn(usize) -> f64| (0..n).map(of).sum::<f64>();
    // Traces of the powers of the Lax matrix.
    [
        sum(&|i| 0.5 * p[i] * p[i] + a(i)),
        sum(&|i| p[i].powi(3) / 3.0 + (p[i] + p[(i + 1) % n]) * a(i)),
        sum(&|i| {
            let b = a((i + 1) % n);
            let (x, y) = (p[i], p[(i + 1) % n]);
            0.25 * x.powi(4) + (x * x + x * y + y * y) * a(i) + 0.5 * a(i) * a(i) + a(i) * b
        }),
    ]
}

/// A periodic Toda lattice of four bodies keeps its four invariants.
#[test]
fn invariant_toda_lattice() {
    let bodies = [(0.3, 0.5), (-0.2, -1.1), (0.6, 0.4), (-0.4, 0.9)];
    let mut text = String::from("name = \"Toda\"\n");
    for (i, (s, v)) in bodies.iter().enumerate() {
        text += &format!("body.b{i} = {{ mass = 1.0, start = {{ s = {s:?}, v = {v:?} }} }}\n");
        // Σ exp(qᵢ - qᵢ₊₁): the force along e = qᵢ₊₁ - qᵢ is -exp(-e).
        let next = (i + 1) % bodies.len();
        text += &format!("spring.k{i} = {{ between = [\"b{i}\", \"b{next}\"], force = \"= -exp(-e)\" }}\n");
    }
    let mut motion = Motion::new(assembled(&text)).expect("a motion");
    let of = |motion: &Motion| {
        let at = |k: usize| (0..bodies.len()).map(|i| motion.body(i)[k]).collect::<Vec<_>>();
        (toda_invariants(&at(0), &at(1)), at(1).iter().sum::<f64>())
    };
    let (first, momentum) = of(&motion);
    for k in 1..=100 {
        motion.advance_to(f64::from(k)).expect("an end");
        let (own, now) = of(&motion);
        for (a, b) in own.iter().zip(first) {
            assert!((a - b).abs() < TODA * b.abs().max(1.0), "{own:?} {first:?} at {k}");
        }
        assert!((now - momentum).abs() < TODA, "{now} {momentum}");
    }
}

/// Name, text, times, and states at these times.
type Case<'a> = (&'a str, &'a str, [f64; 2], [[f64; 2]; 2]);

/// Single bodies against extrapolations in 45 digits: states at two times.
#[test]
fn second_method_single_bodies_in_forty_digits() {
    let plate = "mass = 0.5 }\nspring.k = { between = [\"ground\", \"b\"], stiffness = 20.0, damping = 0.1 }\n\
        spring.field = { between = [\"ground\", \"b\"], force = \"= -a / (d - e)^2\" }\n\
        [parameters]\na = 0.6\nd = 1.0\n";
    let van_der_pol = "mass = 1.0, start.s = 2.0 }\n\
        spring.k = { between = [\"ground\", \"b\"], stiffness = 1.0, force = \"= mu * (e^2 - 1) * rate\" }\n\
        [parameters]\nmu = 3.0\n";
    let lateral = |name: &str| {
        format!(
            "spring.{name} = {{ between = [\"ground\", \"b\"], stiffness = 50.0, damping = 0.5, \
             offset = 0.2, free_length = \"40 cm\" }}\n"
        )
    };
    let zero = format!(
        "mass = 1.0, start.s = 0.3 }}\nspring.k = {{ between = [\"ground\", \"b\"], stiffness = 100.0 }}\n{}{}",
        lateral("left"),
        lateral("right")
    );
    let truss = "mass = 1.0, start.s = 0.15 }\nload.l = { on = \"b\", amplitude = 4.0, frequency = 0.8 }\n\
        spring.t = { between = [\"ground\", \"b\"], stiffness = 400.0, damping = 0.3, offset = 0.2, free_length = 0.25 }\n";
    let damper = "mass = 2.0, start.s = 0.05 }\nload.l = { on = \"b\", amplitude = 20.0, frequency = 1.3 }\n\
        spring.k = { between = [\"ground\", \"b\"], stiffness = 300.0 }\n\
        damper.mr = { between = [\"ground\", \"b\"], damping = 1.5, force = \"= 8 * tanh(rate / 0.02)\" }\n";
    let cases: [Case; 5] = [
        (
            "plate",
            plate,
            [1.0, 3.0],
            [[0.0035567548019045502, -0.030503761209407215], [0.011597804301584101, -0.07191486258301981]],
        ),
        (
            "Van der Pol",
            van_der_pol,
            [5.0, 12.0],
            [[-1.8951640183373146, 0.23699932930311496], [0.8360876437221749, -1.01252207065073]],
        ),
        (
            "quasi-zero stiffness",
            &zero,
            [1.0, 3.0],
            [[-0.11278817335292213, -1.8688769897040072], [0.03268810914466084, 1.4198029512508106]],
        ),
        (
            "truss",
            truss,
            [1.0, 3.0],
            [[0.10316905160121706, -0.1578296814914727], [0.30116133117327787, -0.6153280285190496]],
        ),
        (
            "MR damper",
            damper,
            [0.5, 1.0],
            [[0.005903286204493914, -0.6380927168253444], [0.11316849756707846, 0.29116379088759936]],
        ),
    ];
    for (name, text, times, exact) in cases {
        let text = format!("name = \"M\"\nbody.b = {{ {text}");
        let mut motion = Motion::new(assembled(&text)).expect("a motion");
        for (time, exact) in times.into_iter().zip(exact) {
            motion.advance_to(time).expect("an end");
            let [s, v, _] = motion.body(0);
            let off = (s - exact[0]).abs().max((v - exact[1]).abs());
            assert!(off < SINGLE, "{name} at {time}: {off:e}");
        }
        let (kinetic, stored) = motion.kinetic_and_stored();
        let off = balance(&text, motion.time());
        assert!(off.abs() < BALANCE * (kinetic.abs() + stored.abs() + 1.0), "{name}: {off:e}");
    }
}

/// A pendulum with friction in its bearing and a rigid stop: four impacts against Taylor series in
/// 45 digits.
#[test]
fn second_method_pendulum_with_a_stop() {
    let text = "name = \"P\"\nbody.arm = { inertia = 0.7, start.s = 2.9 }\n\
        spring.weight = { between = [\"ground\", \"arm\"], force = \"= 2.3 * sin(e)\" }\n\
        damper.c = { between = [\"ground\", \"arm\"], damping = 0.02 }\n\
        stop.wall = { between = [\"arm\", \"ground\"], gap = 0.5, restitution = 0.8 }\n";
    // Time of the impact, and rate before it.
    let exact = [
        [2.093301665636718, -3.413146872590252],
        [4.612127469398578, -2.6197187541953704],
        [7.019150135396093, -2.001608365510787],
        [9.459400308269577, -1.5166289229702277],
    ];
    let mut motion = Motion::new(assembled(text)).expect("a motion");
    let mut found = Vec::new();
    motion
        .advance_observed(12.0, &mut |event: &Event| {
            if let EventKind::Impact { .. } = event.kind {
                found.push(event.time);
            }
        })
        .expect("an end");
    assert_eq!(found.len(), exact.len());
    for (own, [time, _]) in found.iter().zip(exact) {
        assert!((own - time).abs() < SINGLE, "{own} {time}");
    }
    let [s, v, _] = motion.body(0);
    let off = (s + 0.4992343786023159).abs().max((v + 1.1337411594277043).abs());
    assert!(off < SINGLE, "{off:e}");
}

/// Derivatives by named parameters in formulas against differences in 50 digits
/// (`data/make_formulas.py`).
#[test]
fn second_method_derivatives_by_parameters_in_forty_digits() {
    for row in include_str!("data/formulas_by.txt").lines() {
        let fields: Vec<&str> = row.split(';').collect();
        let number = |text: &str| text.trim().parse::<f64>().expect("a number");
        let assembly = assembled(&fields[0].replace('|', "\n"));
        let mut motion = Differentiated::new(assembly, &[fields[2]]).expect("a motion");
        motion.advance_to(number(fields[1])).expect("an end");
        let own = motion.state_derivative(0).expect("a derivative");
        let exact: Vec<f64> = fields[3].split(',').map(number).collect();
        let size = exact.iter().fold(0.0f64, |most, x| most.max(x.abs()));
        for (a, b) in own.iter().zip(&exact) {
            assert!((a - b).abs() <= OF_DERIVATIVE * size, "{own:?} {exact:?} by {row}");
        }
    }
}

/// A chain with formulas, an offset spring, a soft stop and friction, for derivatives.
fn chain(x: &[f64; 6]) -> String {
    let [k, a, offset, length, damping, shift] = x;
    format!(
        "name = \"C\"\n[parameters]\nk = {k:?}\na = {a:?}\n[body]\na = {{ mass = 1.0, start = {{ s = {shift:?}, v = 1.5 }} }}\n\
         b = {{ mass = 0.5, start.v = -0.4 }}\n[spring]\n\
         p = {{ between = [\"ground\", \"a\"], force = \"= k * sin(e / a) + k * a * e * sqrt(1 + rate^2)\" }}\n\
         q = {{ between = [\"a\", \"b\"], stiffness = 30.0, damping = {damping:?}, offset = {offset:?}, free_length = {length:?} }}\n\
         [stop.soft]\nbetween = [\"ground\", \"b\"]\ngap = 0.2\nstiffness = 300.0\ndamping = 1.0\n\
         [damper.d]\nbetween = [\"ground\", \"b\"]\nforce = \"= 0.3 * atan(k * rate)\"\n\
         [load.l]\non = \"b\"\namplitude = 3.0\nfrequency = 0.9\n"
    )
}

/// Names of the numbers of [`chain`], and their values.
const NUMBERS: [(&str, f64); 6] = [
    ("k", 8.0),
    ("a", 0.6),
    ("spring.q.offset", 0.3),
    ("spring.q.free_length", 0.35),
    ("spring.q.damping", 0.4),
    ("body.a.start.s", 0.1),
];

/// Columns, a variation and a gradient against differences of motions.
#[test]
fn second_method_derivatives_are_differences() {
    let values = NUMBERS.map(|own| own.1);
    let moved = |i: usize, by: f64| {
        let mut values = values;
        values[i] += by;
        values
    };
    let place = Quantity::of_body(1, What::S);
    let end = |x: &[f64; 6]| {
        let mut motion = Motion::new(assembled(&chain(x))).expect("a motion");
        let sum: f64 = (1..=10)
            .map(|k| {
                motion.advance_to(0.2 * f64::from(k)).expect("an end");
                motion.value(place).powi(2)
            })
            .sum();
        (motion.states(), sum)
    };
    let names = NUMBERS.map(|own| own.0);
    let mut motion = Differentiated::new(assembled(&chain(&values)), &names).expect("a motion");
    motion.advance_to(2.0).expect("an end");
    let mut gradient = Gradient::new(assembled(&chain(&values)), &names).expect("a motion");
    for k in 1..=10 {
        gradient.advance_to(0.2 * f64::from(k)).expect("an end");
        let weight = 2.0 * gradient.motion().value(place);
        gradient.add(place, weight);
    }
    let gradient = gradient.gradient().expect("a gradient");
    for i in 0..NUMBERS.len() {
        let (above, below) = (end(&moved(i, DIFFERENCE)), end(&moved(i, -DIFFERENCE)));
        let own = motion.state_derivative(i).expect("a derivative");
        for ((a, b), own) in above.0.iter().zip(&below.0).zip(own.iter()) {
            let difference = (a - b) / (2.0 * DIFFERENCE);
            assert!(
                (difference - own).abs() < OF_DIFFERENCE * own.abs().max(1.0),
                "{}: {difference} {own}",
                names[i]
            );
        }
        let difference = (above.1 - below.1) / (2.0 * DIFFERENCE);
        let own = gradient[i].as_ref().expect("a derivative");
        assert!(
            (difference - own).abs() < OF_DIFFERENCE * own.abs().max(1.0),
            "{}: {difference} {own}",
            names[i]
        );
    }
}

/// A motion towards a pole or the edge of a domain ends with time and element; the state before
/// it is finite.
#[test]
fn invariant_motions_end_at_the_edge_of_a_domain() {
    // The plate closes, as its field is stronger than 4 k d³/27.
    let plate = "name = \"P\"\nbody.b = { mass = 0.5 }\n\
        spring.k = { between = [\"ground\", \"b\"], stiffness = 20.0 }\n\
        spring.field = { between = [\"ground\", \"b\"], force = \"= -4 / (1 - e)^2\" }\n";
    let mut motion = Motion::new(assembled(plate)).expect("a motion");
    let error = motion.advance_to(100.0).expect_err("an end").to_string();
    assert!(error.contains("spring.field") && error.contains("t = 0."), "{error}");
    let [s, v, _] = motion.body(0);
    assert!(s > 0.99 && s < 1.0 && v.is_finite(), "{s} {v}");
    // m v²/2 = 4/(1 - s) - 4 - k s²/2.
    let energy = 0.25 * v * v + 10.0 * s * s - 4.0 / (1.0 - s) + 4.0;
    assert!(energy.abs() < 1e-6 * v * v, "{energy:e} {v}");
    for (force, start, v) in [("sqrt(2 - e)", 0.0, 3.0), ("-ln(2 + rate)", 0.0, -1.5), ("e^0.5", 1.0, -2.0)] {
        let text = format!(
            "name = \"R\"\nbody.b = {{ mass = 1.0, start = {{ s = {start:?}, v = {v:?} }} }}\n\
             spring.root = {{ between = [\"ground\", \"b\"], force = \"= {force}\" }}\n"
        );
        let mut motion = Motion::new(assembled(&text)).expect("a motion");
        match motion.advance_to(30.0) {
            Ok(()) => panic!("{force}: no end at {:?}", motion.body(0)),
            Err(error) => {
                let error = error.to_string();
                assert!(
                    error.contains("spring.root")
                        && error.contains("reaches 0, where the formula is not defined"),
                    "{error}"
                );
            }
        }
        assert!(motion.body(0).iter().all(|x| x.is_finite()) && motion.time() > 0.01, "{:?}", motion.body(0));
    }
}

/// The change of the mechanical energy from the start to `end`, less the sum of the accounts, J.
fn balance(text: &str, end: f64) -> f64 {
    let mut motion = Motion::new(assembled(text)).expect("a motion");
    let before = motion.kinetic_and_stored();
    motion.advance_to(end).expect(text);
    let after = motion.kinetic_and_stored();
    after.0 + after.1 - before.0 - before.1 - motion.energy().balance()
}

/// A force that has a value at e' = 0 without depending on e is the preload of that value.
#[test]
fn invariant_balance_of_formulas_with_a_force_at_rest() {
    for element in [
        "damper.d = { between = [\"ground\", \"b\"], force = \"= 1 + rate\" }",
        "spring.d = { between = [\"ground\", \"b\"], force = \"= exp(0.5*rate)\" }",
    ] {
        let text = format!(
            "name = \"F\"\nbody.b = {{ mass = 1.0, start = {{ s = 0.5, v = 1.0 }} }}\n\
             spring.k = {{ between = [\"ground\", \"b\"], stiffness = 4.0 }}\n{element}\n"
        );
        let off = balance(&text, 5.0);
        assert!(off.abs() < BALANCE, "off by {off:e} J with {element}");
    }
}

/// Friction that a formula makes smooth has no edge of its domain, however sharp it is. v falls by
/// 1 m/s² until it is about the width of the curve.
#[test]
fn closed_form_smooth_friction_passes_zero() {
    for v in [0.5f64, 10.0] {
        let text = format!(
            "name = \"C\"\nbody.b = {{ mass = 1.0, start = {{ v = {v:?} }} }}\n\
             spring.k = {{ between = [\"ground\", \"b\"], stiffness = 1.0 }}\n\
             damper.d = {{ between = [\"ground\", \"b\"], force = \"= rate/sqrt(rate^2 + 1e-10)\" }}\n"
        );
        let mut motion = Motion::new(assembled(&text)).expect("a motion");
        // v = v0 cos t - sin t until t = atan v0.
        let turn = v.atan();
        motion.advance_to(turn).expect(&text);
        assert!(motion.body(0)[1].abs() < SMOOTHED, "{:?} at {turn} s in {text}", motion.body(0));
        let off = balance(&text, 4.0);
        assert!(off.abs() < BALANCE * v * v, "off by {off:e} J in {text}");
    }
}

/// The search for the equilibrium begins at zero coordinates, where this force is not defined; the
/// error has no NaN.
#[test]
fn golden_no_equilibrium_of_a_force_that_is_undefined_at_zero() {
    let text = "name = \"P\"\n[body.b]\nmass = 1.0\nstart.s = 0.5\n\
        [spring.k]\nbetween = [\"ground\", \"b\"]\nforce = \"= -0.01 / e\"\n";
    let said = Assembly::new(described(text).unwrap()).unwrap().equilibrium().unwrap_err().to_string();
    assert_eq!(
        said,
        "coordinates of the bodies = 0: expected coordinates at which the force of spring.k is defined: the search \
         for the equilibrium begins at 0"
    );
}

/// Formulas that are not allowed are refused; the message says what is.
#[test]
fn refusals_of_formulas() {
    let refused = |force: &str, more: &str| {
        let text = format!(
            "name = \"R\"\n[parameters]\nk = 2.0\nz = 0.0\n[body.b]\nmass = 1.0\n\
             [spring.k]\nbetween = [\"ground\", \"b\"]\nforce = {force}\n{more}"
        );
        described(&text).err().unwrap_or_else(|| panic!("{force} {more} is not refused"))
    };
    for (force, said) in [
        (
            "\"= abs(e)\"",
            "`abs` is not supported: a formula has no corners: points, stops and friction have them",
        ),
        ("\"= e > 0\"", "comparisons are not supported"),
        ("\"= sine(e)\"", "no function is called `sine`; did you mean `sin`?"),
        ("\"= e^k\"", "an exponent must be a number"),
        ("\"= e^rate\"", "an exponent must be a number"),
        ("\"= k * x\"", "no parameter is called `x`"),
        ("\"= sin e\"", "`sin` is a function; expected its argument in brackets, sin( )"),
        ("\"= 2 * e)\"", "`)` has no matching `(`; remove it"),
        ("\"= 3 * k\"", "has neither `e` nor `rate`"),
        ("\"= e / z\"", "divides by zero"),
        ("\"= e + ln(z)\"", "not finite"),
        (
            "\"= ln(e)\"",
            "spring.k.force: at the start, where e = 0.0 m and rate = 0.0 m/s, the formula contains ln(0.0)",
        ),
        (
            "\"= 1 / e\"",
            "contains a division by 0.0; the divisor must not be 0: change the formula or the start values",
        ),
        ("\"= sqrt(e - 1)\"", "contains sqrt(-1.0); the argument of sqrt must be greater than 0"),
        ("\"= e ** 2\"", "write `^` for a power"),
        ("\"= e +\"", "at the end of the expression"),
        ("\"= (e\"", "a `)` is missing"),
        ("\"k * e\"", "an expression begins with `=`"),
        ("3.0", "expected an expression of `e` and `rate`"),
    ] {
        let found = refused(force, "");
        assert!(found.contains("spring.k.force") && found.contains(said), "{force}: {found}");
    }
    for (more, said) in [
        ("slip = 1.0\nstiffness = 2.0\n", "cannot be combined with `slip`"),
        ("points = [[0.0, 0.0], [1.0, 2.0]]\n", "cannot be combined with `points`"),
        ("stiffness = { constant = 1.0, steps = [[1.0, 2.0]] }\n", "use two springs in parallel"),
        ("offset = 1.0\nfree_length = 1.0\nstiffness = 1.0\n", "cannot be combined with `offset`"),
    ] {
        let found = refused("\"= e^3\"", more);
        assert!(found.contains(said), "{more}: {found}");
    }
    let shadowed = "name = \"R\"\nbody.b = { mass = 1.0 }\n[parameters]\nrate = 3.0\n\
        [spring.k]\nbetween = [\"ground\", \"b\"]\nforce = \"= 2 * e\"\n";
    assert!(described(shadowed).expect_err("a refusal").contains("give the parameter `rate` another name"));
    let damper = "name = \"R\"\nbody.b = { mass = 1.0 }\n\
        damper.d = { between = [\"ground\", \"b\"], force = \"= e * rate\" }\n";
    assert!(described(damper).expect_err("a refusal").contains("cannot depend on `e`: use a spring"));
}

/// A file that is written reads as the same machine, and a parameter of a formula is set by its
/// name.
#[test]
fn invariant_files_are_written_back() {
    let text = chain(&NUMBERS.map(|own| own.1));
    let description = described(&text).expect("a machine");
    let again = described(&description.to_toml()).expect("the same machine");
    assert_eq!(description, again);
    let other = description.with([("k", 9.0)]).expect("a machine");
    assert_eq!(other.get("spring.p.force.k").expect("a number"), 9.0);
    let refused = description.with([("spring.p.force.k", 9.0)]).expect_err("a refusal").to_string();
    assert!(refused.contains("follows from `k`"), "{refused}");
}

/// A body on a belt with a spring, whose friction falls with Stribeck's curve.
fn belt(x: &[f64; 4]) -> String {
    let [force, largest, speed, stiffness] = x;
    format!(
        "name = \"Belt\"\nbody.belt = {{ dimension = \"translation\", motion = {{ rate = 0.1 }} }}\n\
         body.m = {{ mass = 1.0, start.v = 0.1 }}\n\
         spring.k = {{ between = [\"ground\", \"m\"], stiffness = {stiffness:?}, damping = 0.1 }}\n\
         friction.f = {{ between = [\"belt\", \"m\"], force = {force:?}, static = {largest:?}, stribeck = {speed:?} }}\n"
    )
}

/// Stick and slip against an extrapolation in 45 digits; the friction does not jump where it
/// leaves sticking, and the energy balances.
#[test]
fn second_method_stribeck_friction_on_a_belt() {
    let exact = [0.798, 1.4042654659104081, 2.275183411559605, 2.8814488774700133, 3.75236682311921];
    let text = belt(&[2.0, 4.0, 0.05, 50.0]);
    let mut motion = Motion::new(assembled(&text)).expect("a motion");
    let (first, mut found) = (motion.kinetic_and_stored(), Vec::new());
    motion
        .advance_observed(4.0, &mut |event: &Event| {
            if matches!(event.kind, EventKind::Stick { .. } | EventKind::Slip { .. }) {
                found.push(event.time);
            }
        })
        .expect("an end");
    assert_eq!(found.len(), exact.len(), "{found:?}");
    for (own, exact) in found.iter().zip(exact) {
        assert!((own - exact).abs() < SINGLE, "{own} {exact}");
    }
    let [s, v, _] = motion.body(1);
    let off = (s - 0.07369297915387019).abs().max((v + 0.25812899280493035).abs());
    assert!(off < SINGLE, "{off:e}");
    let now = motion.kinetic_and_stored();
    let off = now.0 + now.1 - first.0 - first.1 - motion.energy().balance();
    assert!(off.abs() < BALANCE, "{off:e}");
    // Just before and after the first slip.
    let force = |time: f64| {
        let mut motion = Motion::new(assembled(&text)).expect("a motion");
        motion.advance_to(time).expect("an end");
        let index = motion.assembly().description.elements().count() - 1;
        motion.value(Quantity::of_element(index, What::F))
    };
    assert!((force(0.798 - 1e-9) + 4.0).abs() < 1e-6 && (force(0.798 + 1e-6) + 4.0).abs() < 1e-4);
}

/// Derivatives by the numbers of a Stribeck friction against differences.
#[test]
fn second_method_derivatives_of_stribeck_friction() {
    let values = [2.0, 4.0, 0.05, 50.0];
    let names = ["friction.f.force", "friction.f.static", "friction.f.stribeck", "spring.k.stiffness"];
    let mut motion = Differentiated::new(assembled(&belt(&values)), &names).expect("a motion");
    motion.advance_to(4.0).expect("an end");
    let end = |i: usize, by: f64| {
        let mut values = values;
        values[i] += by;
        let mut motion = Motion::new(assembled(&belt(&values))).expect("a motion");
        motion.advance_to(4.0).expect("an end");
        motion.states()
    };
    for i in 0..values.len() {
        let shift = DIFFERENCE * values[i];
        let own = motion.state_derivative(i).expect("a derivative");
        for ((a, b), own) in end(i, shift).iter().zip(end(i, -shift)).zip(own.iter()) {
            let difference = (a - b) / (2.0 * shift);
            assert!(
                (difference - own).abs() < OF_DIFFERENCE * own.abs().max(10.0),
                "{}: {difference} {own}",
                names[i]
            );
        }
    }
    let alone = belt(&values).replace("static = 4.0, ", "");
    assert!(described(&alone).expect_err("a refusal").contains("requires `static`"));
    let description = described(&belt(&values)).expect("a machine");
    assert_eq!(description, described(&description.to_toml()).expect("the same machine"));
}

/// The same machine by keys and by formulas: curves, straight forces, and a dashpot.
#[test]
fn invariant_formulas_are_the_forces_of_the_keys() {
    let text = |spring: &str, damper: &str, more: &str| {
        format!(
            "name = \"S\"\nbody.a = {{ mass = 1.0, start = {{ s = 0.3, v = 1.0 }} }}\nbody.b = {{ mass = 0.5 }}\n\
             spring.a = {{ between = [\"ground\", \"a\"], {spring} }}\n\
             spring.b = {{ between = [\"a\", \"b\"], stiffness = 12.0{more} }}\n\
             damper.d = {{ between = [\"ground\", \"b\"], {damper} }}\n\
             stop.s = {{ between = [\"ground\", \"b\"], gap = 0.2, restitution = 0.7 }}\n\
             load.l = {{ on = \"a\", amplitude = 2.0, frequency = 0.6 }}\n"
        )
    };
    let end = |text: &str| {
        let mut motion = Motion::new(assembled(text)).expect("a motion");
        let first = motion.kinetic_and_stored();
        motion.advance_to(5.0).expect("an end");
        let now = motion.kinetic_and_stored();
        (motion.states(), now.0 + now.1 - first.0 - first.1, motion.energy().balance())
    };
    let pairs = [
        // Straight: no operation.
        (
            text("stiffness = 8.0, damping = 0.2, preload = 1.5", "damping = 0.3", ""),
            text("force = \"= 8 * e + 0.2 * rate + 1.5\"", "force = \"= 0.3 * rate\"", ""),
        ),
        (
            text("stiffness = 8.0, quadratic = 3.0, cubic = 40.0", "damping = 0.3, cubic = 0.2", ""),
            text("cubic = 40.0, force = \"= 8 * e + 3 * e^2\"", "cubic = 0.2, force = \"= 0.3 * rate\"", ""),
        ),
        (
            text("stiffness = 8.0, quintic = 60.0", "damping = 0.1, cubic = 0.2", ", cubic = 9.0"),
            text(
                "force = \"= 8 * e + 60 * e * e^2 * e^2\"",
                "force = \"= rate * (0.1 + 0.2 * rate * rate)\"",
                ", force = \"= 9 * e^3 * (sin(e)^2 + cos(e)^2)\"",
            ),
        ),
    ];
    for (keys, formulas) in &pairs {
        let (keys, formulas) = (end(keys), end(formulas));
        for (a, b) in keys.0.iter().zip(&formulas.0) {
            assert!((a - b).abs() < SAME, "{keys:?} {formulas:?}");
        }
        for (change, balance) in [(keys.1, keys.2), (formulas.1, formulas.2)] {
            assert!((change - balance).abs() < SAME, "{change} {balance}");
        }
        assert!((keys.1 - formulas.1).abs() < SAME, "{keys:?} {formulas:?}");
    }
}

/// A gradient by parameters of straight formulas, which have no operation, equals the gradient by
/// the keys.
#[test]
fn second_method_a_gradient_of_straight_formulas() {
    let text = |force: &str| {
        format!(
            "name = \"G\"\n[parameters]\nk = 20.0\nc = 0.4\np = 1.5\n[body.b]\nmass = 1.0\nstart.v = 1.0\n\
             [spring.s]\nbetween = [\"ground\", \"b\"]\n{force}\n\
             [stop.w]\nbetween = [\"ground\", \"b\"]\ngap = 0.1\nrestitution = 0.8\n"
        )
    };
    let gradient = |force: &str| {
        let mut found = Gradient::new(assembled(&text(force)), &["k", "c", "p"]).expect("a motion");
        for k in 1..=10 {
            found.advance_to(0.3 * f64::from(k)).expect("an end");
            found.add(Quantity::of_body(0, What::S), 1.0);
        }
        found
            .gradient()
            .expect("a gradient")
            .into_iter()
            .map(|own| own.expect("a derivative"))
            .collect::<Vec<_>>()
    };
    let keys = gradient("stiffness = \"= k\"\ndamping = \"= c\"\npreload = \"= p\"");
    let formula = gradient("force = \"= k * e + c * rate + p\"");
    for (a, b) in keys.iter().zip(&formula) {
        assert!((a - b).abs() < SAME * a.abs().max(1.0), "{keys:?} {formula:?}");
    }
}

/// Largest difference of a speed from that of a body against a constant friction, m/s: the body passes
/// rates of some 1e-9 m/s at the start, where the friction is less.
const BEGINNING: f64 = 1e-9;

/// A body is pushed with 10 N against a friction of 1 N by tanh, which is saturated but for the first
/// 1e-10 s: v = 9 t. Its series is 1e9 times longer than its radius of convergence suggests.
#[test]
fn closed_form_saturated_smooth_friction() {
    let text = "name = \"Saturated\"\nbody.m = { mass = 1.0 }\nload.push = { on = \"m\", constant = 10.0 }\n\
                damper.d = { between = [\"ground\", \"m\"], force = \"= tanh(rate / 1e-9)\" }\n";
    for time in [1e-3, 1.0, 100.0] {
        let mut motion = Motion::new(assembled(text)).expect("a motion");
        motion.advance_to(time).expect("an end");
        let off = motion.body(0)[1] - 9.0 * time;
        assert!(off.abs() < BEGINNING * time.max(1.0), "{off:e} after {time} s");
    }
}
