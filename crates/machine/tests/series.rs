//! Springs in series with a dashpot (Maxwell elements): closed forms and second methods.

use crate::common::*;
use nalgebra::{Complex, DMatrix, DVector};
use std::f64::consts::TAU;
use std::sync::Arc;
use vibro_machine::derivative::{By, Gradient};
use vibro_machine::file::{no_records, parse};
use vibro_machine::motion::Reached;
use vibro_machine::neutral::Neutral;
use vibro_machine::{Assembly, Differentiated, Motion, Quantity, Start, What};

/// A hundred roundings of numbers of order one.
const ROUNDING: f64 = 1e-13;

/// A shaken foot that pulls a body through a Zener element: 40 N/m in parallel with 100 N/m in
/// series with 5 N s/m.
const ZENER: &str = r#"
    name = "Zener"
    body.foot = { motion = { amplitude = 0.5, frequency = 1.3, phase = 0.4 } }
    body.box = { mass = 2.0, start = { s = 0.1, v = -0.3 } }
    spring.soft = { between = ["foot", "box"], stiffness = 40.0 }
    spring.mount = { between = ["foot", "box"], stiffness = "0.1 N/mm", series_damping = "5 N s/m", damping = 0.5, slider = "20 mm" }
    load.push = { on = "box", constant = 3.0 }
"#;

/// A held elongation: b = b0 exp(-k t/c), with the loss b0² (1 - exp(-2 k t/c))/2k.
#[test]
fn closed_form_a_spring_that_is_held_relaxes() {
    let mut m = motion(machine(
        r#"
        name = "Held"
        body.wall = { motion = { constant = 0.2 } }
        body.box = { mass = 1.0 }
        spring.mount = { between = ["ground", "wall"], stiffness = 100.0, series_damping = 5.0, slider = 0.05 }
        spring.k = { between = ["ground", "box"], stiffness = 1.0 }
    "#,
    ));
    m.advance_to(0.07).unwrap();
    let (k, c, b) = (100.0, 5.0, 15.0 * (-100.0 * 0.07 / 5.0f64).exp());
    assert!((of(&m, 0, What::F) - b).abs() < ROUNDING * 15.0);
    assert!((of(&m, 0, What::Slider(None)) - (0.2 - b / k)).abs() < ROUNDING);
    let lost = m.energy().branches[0].value();
    assert!((lost - (15.0 * 15.0 - b * b) / (2.0 * k)).abs() < ROUNDING * 2.0, "{lost} {c}");
}

/// f = K e with the complex stiffness K = d iω + k iω c/(k + iω c) under harmonic motion.
#[test]
fn closed_form_the_complex_stiffness_under_harmonic_motion() {
    let (k, c, d, f) = (100.0, 5.0, 0.5, 1.3);
    let mut m = motion(machine(
        r#"
        name = "Shaken"
        body.foot = { motion = { amplitude = 0.5, frequency = 1.3, phase = 0.4 } }
        body.box = { mass = 1.0 }
        spring.mount = { between = ["ground", "foot"], stiffness = 100.0, series_damping = 5.0, damping = 0.5 }
        spring.k = { between = ["ground", "box"], stiffness = 1.0 }
    "#,
    ));
    let (i, omega) = (Complex::i(), TAU * f);
    let stiffness = i * omega * d + k * i * omega * c / (k + i * omega * c);
    for time in [3.0, 3.1, 3.37, 7.9] {
        m.advance_to(time).unwrap();
        let e = 0.5 * (i * (omega * time + 0.4)).exp();
        let exact = (stiffness * e).im;
        // After 3 s, exp(-60) of the initial value is left.
        assert!((of(&m, 0, What::F) - exact).abs() < ROUNDING * 100.0, "{time}: {exact}");
    }
    // A period of steady motion loses π Im K A².
    let (from, to) = (7.9, 7.9 + 1.0 / f);
    let lost = |m: &Motion| m.energy().branches[0].value() + m.energy().dashpots[0].value();
    let before = lost(&m);
    m.advance_to(to).unwrap();
    let exact = 0.5 * TAU * stiffness.im * 0.25;
    assert!((lost(&m) - before - exact).abs() < ROUNDING * 100.0, "{from} {exact}");
}

/// The matrix exponential of q' = v, m v' = -(k e + d e' + b) + F, x' = b/c with a harmonic foot.
#[test]
fn second_method_a_body_on_a_zener_element_is_the_matrix_exponential() {
    let mut m = motion(machine(ZENER));
    let begin = unaccounted(&m);
    m.advance_to(2.3).unwrap();
    let (mass, soft, k, c, d) = (2.0, 40.0, 100.0, 5.0, 0.5);
    let omega = TAU * 1.3;
    // z = (q, v, x, 1, cos, sin).
    let foot = [0.5 * 0.4f64.sin(), 0.5 * 0.4f64.cos()];
    let rate = [omega * foot[1], -omega * foot[0]];
    let mut a = DMatrix::zeros(6, 6);
    a[(0, 1)] = 1.0;
    a[(1, 0)] = -(soft + k) / mass;
    a[(1, 1)] = -d / mass;
    a[(1, 2)] = k / mass;
    a[(1, 3)] = 3.0 / mass;
    for j in 0..2 {
        a[(1, 4 + j)] = ((soft + k) * foot[j] + d * rate[j]) / mass;
        a[(2, 4 + j)] = -k / c * foot[j];
    }
    (a[(2, 0)], a[(2, 2)]) = (k / c, -k / c);
    (a[(4, 5)], a[(5, 4)]) = (-omega, omega);
    let exact = (a * 2.3).exp() * DVector::from_vec(vec![0.1, -0.3, 0.02, 1.0, 1.0, 0.0]);
    let found = [m.coordinate(1), m.rate(1), of(&m, 1, What::Slider(None))];
    for (found, exact) in found.iter().zip(exact.iter()) {
        assert!((found - exact).abs() < 10.0 * ROUNDING, "{found} {exact}");
    }
    assert!((unaccounted(&m) - begin).abs() < 10.0 * ROUNDING);
}

/// A ball that bounces on a plate with a Zener buffer: 50 digits by tests/data/make_series.py.
const BUFFER: &str = r#"
    name = "Buffer"
    gravity = 9.81
    body.ball = { mass = 0.5, gravity = 1.0 }
    body.plate = { mass = 0.05, gravity = 1.0, start = { s = 0.000613125 } }
    spring.soft = { between = ["ground", "plate"], stiffness = 800.0 }
    spring.mount = { between = ["ground", "plate"], stiffness = 3e3, series_damping = 12.0, slider = 0.000613125 }
    stop.skin = { between = ["plate", "ball"], gap = 0.2, stiffness = 2e4 }
"#;

#[test]
fn second_method_a_ball_bounces_on_a_zener_buffer() {
    let mut m = motion(machine(BUFFER));
    let begin = unaccounted(&m);
    let found = events(&mut m, 0.9);
    assert_eq!(found.len(), 37);
    // Rounding of some hundred sub-steps, amplified by contacts of 2 rad/ms.
    const MAGNIFIED: f64 = 1e-12;
    let times = [0.202_236_791_098_460_23, 0.207_425_972_037_103_5, 0.211_582_231_453_655_25];
    assert!(found.iter().zip(times).all(|(event, exact)| (event.time - exact).abs() < MAGNIFIED));
    assert!((found[36].time - 0.578_144_297_479_613_6).abs() < MAGNIFIED);
    let found = [m.coordinate(0), m.coordinate(1), m.rate(0), m.rate(1), of(&m, 1, What::Slider(None))];
    let exact = [
        0.206_868_860_280_023_46,
        0.006_626_684_355_588_402,
        8.435_535_121_990_838e-5,
        -0.000_842_556_217_381_253,
        0.006_631_849_825_048_354,
    ];
    for (found, exact) in found.iter().zip(exact) {
        assert!((found - exact).abs() < 1e3 * MAGNIFIED, "{found} {exact}");
    }
    assert!((unaccounted(&m) - begin).abs() < MAGNIFIED);
}

#[test]
fn second_method_series_of_actual_states_are_the_tables() {
    for (text, end, zero) in [(ZENER, 2.3, 10.0 * ROUNDING), (BUFFER, 0.5, 1e-10)] {
        let [mut one, mut other] = [text.to_owned(), with_company(text)].map(|text| motion(machine(&text)));
        let begin = unaccounted(&other);
        let [found, exact] = [&mut other, &mut one].map(|m| events(m, end).len());
        assert_eq!(found, exact);
        assert!((one.coordinate(1) - other.coordinate(1)).abs() < zero);
        let slider = |m: &Motion| of(m, 1, What::Slider(None));
        assert!((slider(&one) - slider(&other)).abs() < zero, "{} {}", slider(&one), slider(&other));
        assert!((unaccounted(&other) - begin).abs() < zero);
    }
}

/// Without harmonics, a relaxing machine comes to rest in the end: it gets there in long steps.
#[test]
fn invariant_long_steps_keep_the_energy_accounts() {
    let text = ZENER.replace("amplitude = 0.5, frequency = 1.3, phase = 0.4", "constant = 0.2");
    for text in [text.clone(), with_company(&text)] {
        let mut m = motion(machine(&text));
        let begin = unaccounted(&m);
        m.advance_to(400.0).unwrap();
        assert!((unaccounted(&m) - begin).abs() < 100.0 * ROUNDING);
        // 40 (s - 0.2) = 3; the branch carries nothing.
        assert!(
            (m.coordinate(1) - 0.275).abs() < 10.0 * ROUNDING && of(&m, 1, What::F).abs() < ROUNDING * 100.0
        );
    }
}

/// Derivatives of b = k (e - x0) exp(-k t/c) and of the loss (b0² - b²)/2k by k, c and x0.
#[test]
fn closed_form_derivatives_of_a_relaxation() {
    let text = r#"
        name = "Held"
        body.wall = { motion = { constant = 0.2 } }
        body.box = { mass = 1.0 }
        spring.mount = { between = ["ground", "wall"], stiffness = 100.0, series_damping = 5.0, slider = 0.05 }
        spring.k = { between = ["ground", "box"], stiffness = 1.0 }
    "#;
    let assembly = Arc::new(Assembly::new(machine(text)).unwrap());
    let names = ["stiffness", "series_damping", "slider"].map(|key| format!("spring.mount.{key}"));
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    let mut m = Differentiated::new(assembly, &names).unwrap();
    let (t, k, c, stretch): (f64, f64, f64, f64) = (0.07, 100.0, 5.0, 0.15);
    m.advance_to(t).unwrap();
    let decay = (-k * t / c).exp();
    let exact = [stretch * decay * (1.0 - k * t / c), k * stretch * decay * k * t / (c * c), -k * decay];
    for (p, exact) in exact.iter().enumerate() {
        let found = m.derivative(Quantity::of_element(0, What::F), p).unwrap();
        assert!((found - exact).abs() < 1e3 * ROUNDING, "{p}: {found} {exact}");
    }
}

/// Fourth-order differences with respect to every number, for a motion with contacts.
#[test]
fn second_method_derivatives_are_differences_of_motions() {
    // Error: the fourth power of the step, and rounding over the step, amplified by contacts;
    // accelerations are of order 10.
    const DIFFERENCE: f64 = 2e-6;
    for (text, end) in [(ZENER, 1.3), (BUFFER, 0.25)] {
        let d = machine(text);
        let names: Vec<String> = d.parameters().into_iter().map(|p| p.name).collect();
        let names: Vec<&str> = names.iter().map(String::as_str).collect();
        let quantities: Vec<_> = d.quantities().collect();
        let mut exact = Differentiated::new(Arc::new(Assembly::new(d.clone()).unwrap()), &names).unwrap();
        exact.advance_to(end).unwrap();
        for (p, name) in names.iter().enumerate() {
            let value = d.get(name).unwrap();
            let step = 1e-4 * value.abs().max(1e-2);
            let values = |k: f64| {
                let Ok(changed) = d.with([(*name, value + k * step)]) else { return vec![f64::NAN; 99] };
                let mut m = motion(changed);
                m.advance_to(end).unwrap();
                quantities.iter().map(|&q| m.value(q)).collect::<Vec<f64>>()
            };
            let [a, b, c, d] = [-2.0, -1.0, 1.0, 2.0].map(values);
            for (i, &quantity) in quantities.iter().enumerate() {
                let difference = (8.0 * (c[i] - b[i]) - (d[i] - a[i])) / (12.0 * step);
                let found = exact.derivative(quantity, p).unwrap_or_else(|| panic!("{name} {quantity:?}"));
                let of_kind = quantities.iter().filter(|q| q.what == quantity.what);
                let size = of_kind.map(|&q| exact.derivative(q, p).unwrap().abs()).fold(10.0, f64::max);
                // A number at its limit has no two-sided difference.
                assert!(
                    difference.is_nan() || (found - difference).abs() < DIFFERENCE * size,
                    "{name} {quantity:?}: {found} {difference}"
                );
            }
        }
    }
}

#[test]
fn second_method_gradients_are_columns_and_variations_are_columns_by_the_start() {
    for (text, end) in [(ZENER, 1.3), (BUFFER, 0.25)] {
        let d = machine(text);
        let assembly = Arc::new(Assembly::new(d.clone()).unwrap());
        let states = assembly.system().states();
        let mut columns: Vec<By> = d.parameters().into_iter().map(|p| p.name.into()).collect();
        columns.extend((0..states).map(By::Start));
        let mut sum = Gradient::new(assembly.clone(), &columns).unwrap();
        let mut exact = Differentiated::new(assembly.clone(), &columns).unwrap();
        let mut sizes = vec![[0.0; 2]; columns.len()];
        let quantities: Vec<_> = d.quantities().collect();
        let rate = Quantity::of_element(1, What::SliderRate(None));
        for k in 1..=3 {
            let time = end * f64::from(k) / 3.0;
            sum.advance_to(time).unwrap();
            exact.advance_to(time).unwrap();
            for (i, &quantity) in quantities.iter().chain([&rate]).enumerate() {
                let factor = 1.0 - 0.3 * i as f64;
                sum.add(quantity, factor);
                for (p, [sum, size]) in sizes.iter_mut().enumerate() {
                    let term = factor * exact.derivative(quantity, p).unwrap();
                    *sum += term;
                    *size += term.abs();
                }
            }
        }
        assert!(!sum.is_by_columns());
        for ((found, [exact, size]), by) in sum.gradient().unwrap().iter().zip(&sizes).zip(&columns) {
            let found = found.as_ref().unwrap();
            assert!((found - exact).abs() <= 1e-12 * size, "{by}: {found} {exact}");
        }
        // Variations carry the same derivatives, one by one.
        let mut m = Motion::new(assembly.clone()).unwrap();
        let mut variations = m.unit_variations();
        while m.advance_with(end, &mut variations).unwrap() == Reached::Event {}
        for (j, variation) in variations.iter().enumerate() {
            let exact = exact.state_derivative(columns.len() - states + j).unwrap();
            let size = exact.iter().fold(1.0, |most: f64, x| most.max(x.abs()));
            let variation = m.assembly().system().given(variation);
            let off = variation.iter().zip(&exact).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            assert!(off < 1e-9 * size, "{j}: {off}");
        }
    }
}

/// At rest the branch has relaxed: 800 s = m g, x = s. Derivative by k of `soft`: ds = -s/k.
#[test]
fn closed_form_a_start_at_rest_has_relaxed() {
    let text = BUFFER.replace(", start = { s = 0.000613125 }", "").replace(", slider = 0.000613125", "");
    let text = text.replace("body.ball", "start = \"rest\"\n body.ball").replace("gap = 0.2", "gap = 0.0");
    let d = machine(&text);
    let assembly = Arc::new(Assembly::new(d.clone()).unwrap());
    let names = ["spring.soft.stiffness", "spring.mount.stiffness", "spring.mount.series_damping", "gravity"];
    let m = Differentiated::new(assembly, &names).unwrap();
    let plate = 0.55 * 9.81 / 800.0;
    let slider = Quantity::of_element(1, What::Slider(None));
    assert!((m.motion().value(slider) - plate).abs() < ROUNDING);
    assert!(of(m.motion(), 1, What::F).abs() < ROUNDING * 100.0);
    for (p, exact) in [-plate / 800.0, 0.0, 0.0, plate / 9.81].iter().enumerate() {
        for quantity in [Quantity::of_body(1, What::S), slider] {
            let found = m.derivative(quantity, p).unwrap();
            assert!((found - exact).abs() < ROUNDING, "{p}: {found} {exact}");
        }
    }
    let mut m = m;
    m.advance_to(0.3).unwrap();
    assert!((m.motion().value(slider) - plate).abs() < ROUNDING);
}

#[test]
fn invariant_starts_name_inner_places() {
    let assembly = Arc::new(Assembly::new(machine(ZENER)).unwrap());
    assert_eq!(Start::names(&assembly), ["box.s", "box.v", "mount.slider"]);
    let mut m = Motion::new(assembly.clone()).unwrap();
    m.advance_to(0.7).unwrap();
    let start = Start::of(&m);
    let read = Start::parse(&start.to_toml(), "start.toml", &assembly.description).unwrap();
    assert_eq!(read, start);
    assert_eq!(Start::try_from(String::from(start.clone())).unwrap(), start);
    let mut on = read.motion(assembly.clone()).unwrap();
    on.advance_to(1.3).unwrap();
    m.advance_to(1.3).unwrap();
    assert!((of(&on, 1, What::Slider(None)) - of(&m, 1, What::Slider(None))).abs() < ROUNDING);
    let mut one = Start::default();
    one.set_text(&assembly.description, "spring.mount.slider", "30 mm").unwrap();
    assert_eq!(one.motion(assembly.clone()).unwrap().states()[2], 0.03);
    let refused = one.set(&assembly.description, "mount.slide", 1.0).unwrap_err().to_string();
    assert!(refused.contains("mount.slider"), "{refused}");
    let text = "time = 0.0\n[spring.soft]\nslider = 1.0\n";
    let refused = Start::parse(text, "start.toml", &assembly.description).unwrap_err().to_string();
    assert!(refused.contains("spring.soft") && refused.contains("expected one of mount"), "{refused}");
}

/// A body held only by such a spring is neutral at any position: coordinate and inner coordinate
/// together are neutral, its rate is not.
#[test]
fn closed_form_place_and_inner_place_are_neutral_together() {
    let text = r#"
        name = "Loose"
        body.box = { mass = 1.0 }
        spring.mount = { between = ["ground", "box"], stiffness = 100.0, series_damping = 5.0 }
    "#;
    let assembly = Assembly::new(machine(text)).unwrap();
    let neutral = Neutral::of(assembly.system());
    assert_eq!(neutral.states(), [vec![1.0, 0.0, 0.0]]);
}

#[test]
fn invariant_files_are_written_back_and_refused_by_name() {
    let d = machine(ZENER);
    assert_eq!(parse(&d.to_toml(), "again.toml", &no_records).unwrap(), d);
    let names: Vec<_> = d.parameters().into_iter().map(|p| p.name).filter(|n| n.contains("mount")).collect();
    let keys = ["stiffness", "damping", "series_damping", "slider"];
    assert_eq!(names, keys.map(|key| format!("spring.mount.{key}")));
    let columns: Vec<_> = d.named_quantities().into_iter().map(|q| q.name).collect();
    assert!(columns.contains(&"mount.slider".into()) && !columns.contains(&"soft.slider".into()));
    for (from, to, name) in [
        ("series_damping = \"5 N s/m\"", "series_damping = 0.0", "spring.mount.series_damping = 0.0"),
        ("stiffness = \"0.1 N/mm\"", "stiffness = 0.0", "spring.mount.stiffness = 0.0"),
        ("series_damping = \"5 N s/m\"", "series_dampin = 5.0", "series_damping"),
        ("series_damping = \"5 N s/m\", ", "", "spring.mount.slider"),
        ("damping = 0.5", "preload = 1.0", "spring.mount.preload"),
        ("slider = \"20 mm\"", "slider = \"20 N\"", "spring.mount.slider"),
    ] {
        let refused = refusal(&ZENER.replace(from, to));
        assert!(refused.contains(name), "{to}: {refused}");
    }
    let mut wrong = d;
    wrong.springs[1].preload = 1.0;
    assert!(wrong.check().unwrap_err().to_string().contains("spring.mount.preload = 1.0"));
}
