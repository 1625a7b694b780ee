//! Uncertainty: errors compared with the spread of repeated fits; undetermined combinations.

use super::*;
use nalgebra::DMatrix;

#[test]
fn second_method_errors_are_those_of_repeated_records() {
    let m = example("coulomb_oscillator.toml");
    let free = ["spring.mount.stiffness", "friction.floor.force"];
    let (mut inside, mut all, mut noise) = (0u32, 0u32, Noise(7));
    for _ in 0..200 {
        let measured = record(&m, &[("mass.s", 5e-6)], 0.25, 100, &mut noise);
        let found = fitted(&request(off(&m, &free, |_| 1.05), measured, &free));
        for ((name, value), error) in found.values.iter().zip(&found.uncertainty.errors) {
            let truth = m.description.get(name).unwrap();
            inside += u32::from((value - truth).abs() < 2.0 * error.unwrap());
            all += 1;
        }
    }
    // 95.4 % of normal estimates; the bounds allow for correlation within a draw.
    let share = f64::from(inside) / f64::from(all);
    assert!((0.90..=0.98).contains(&share), "{share}");
}

#[test]
fn closed_form_only_ratios_of_mass_stiffness_and_friction_are_determined() {
    let m = example("coulomb_oscillator.toml");
    let measured = record(&m, &[("mass.s", 2e-6)], 0.25, 500, &mut Noise(4));
    let free = ["body.mass.mass", "spring.mount.stiffness", "friction.floor.force"];
    let found = fitted(&request(off(&m, &free, |i| [1.0, 1.1, 0.9][i]), measured, &free));
    let [undetermined] = &found.uncertainty.undetermined[..] else {
        panic!("{:?}", found.uncertainty.undetermined)
    };
    let parts: Vec<f64> = undetermined.combination.iter().map(|(_, part)| part.abs()).collect();
    assert_eq!(parts.len(), 3);
    assert!(parts.iter().all(|part| (part - 3f64.sqrt().recip()).abs() < 1e-4), "{parts:?}");
    assert!(found.uncertainty.errors.iter().all(Option::is_none));
}

#[test]
fn invariant_a_number_without_effect_spoils_no_other() {
    // The stop is out of reach.
    let text = "name = \"Far\"\nbody.a = { mass = 1.0, start = { s = 1e-3 } }\n\
                spring.k = { between = [\"ground\", \"a\"], stiffness = 9300.0 }\n\
                stop.far = { between = [\"ground\", \"a\"], gap = 1.0, restitution = 0.5 }\n";
    let m = Machine::parse(text, "far.toml", &no_records).unwrap();
    let measured = record(&m, &[("a.s", 1e-6)], 0.3, 200, &mut Noise(8));
    let free = ["spring.k.stiffness", "stop.far.gap"];
    let found = fitted(&request(m.with([("spring.k.stiffness", 8e3)]).unwrap(), measured, &free));
    let error = found.uncertainty.errors[0].unwrap();
    assert!((found.values[0].1 - 9300.0).abs() < FAR * error && error < 10.0, "{:?} {error}", found.values);
    assert_eq!((found.values[1].1, found.uncertainty.errors[1]), (1.0, None));
}

#[test]
fn closed_form_of_two_factors_only_the_product_is_determined() {
    let text = "name = \"Product\"\nparameters = { width = 20.0, modulus = 500.0 }\n\
                body.a = { mass = 1.0, start = { s = 1e-3 } }\n\
                spring.k = { between = [\"ground\", \"a\"], stiffness = \"= width * modulus\", damping = 5.0 }\n";
    let m = Machine::parse(text, "product.toml", &no_records).unwrap();
    let measured = record(&m, &[("a.s", 1e-6)], 0.3, 200, &mut Noise(16));
    let free = ["width", "spring.k.damping", "modulus"];
    let found = fitted(&request(off(&m, &free, |_| 1.05), measured, &free));
    let [undetermined] = &found.uncertainty.undetermined[..] else {
        panic!("{:?}", found.uncertainty.undetermined)
    };
    let [(a, width), (b, modulus)] = &undetermined.combination[..] else { panic!("{undetermined:?}") };
    assert_eq!((a.as_str(), b.as_str()), ("width", "modulus"));
    assert!((width + modulus).abs() < 1e-4 && (width.abs() - 0.5f64.sqrt()).abs() < 1e-4, "{undetermined:?}");
    let [None, Some(error), None] = found.uncertainty.errors[..] else { panic!("{:?}", found.uncertainty) };
    assert!((found.values[1].1 - 5.0).abs() < FAR * error);
    let product = found.values[0].1 * found.values[2].1;
    assert!((product / 1e4 - 1.0).abs() < 1e-3, "{product}");
}

#[test]
fn second_method_errors_of_correlated_residuals_are_the_spread_of_repeated_fits() {
    // A sensor whose noise lasts some ten samples.
    const LASTS: f64 = 0.9;
    let m = example("coulomb_oscillator.toml");
    let free = ["spring.mount.stiffness", "friction.floor.force"];
    let (mut values, mut errors, mut white, mut noise) = (Vec::new(), 0.0, 0.0, Noise(17));
    for _ in 0..40 {
        let mut measured = record(&m, &[("mass.s", 0.0)], 0.25, 400, &mut noise);
        let mut own = 0.0;
        for value in &mut measured.columns[0].1 {
            own = LASTS * own + 2e-6 * noise.normal();
            *value += own;
        }
        let found = fitted(&request(m.clone(), measured, &free));
        values.push(found.values[0].1);
        errors += found.uncertainty.errors[0].unwrap() / 40.0;
        white += found.uncertainty.white[0].unwrap() / 40.0;
    }
    let mean = values.iter().sum::<f64>() / 40.0;
    let spread = (values.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / 39.0).sqrt();
    // 40 draws give a spread to 11 %; at this length the Newey-West errors are some 10 to 20 % too
    // small.
    assert!((0.7..1.3).contains(&(errors / spread)), "{errors} {spread}");
    assert!(white < 0.5 * spread, "{white} {spread}");
}

/// Cramér-Rao bound for white noise: the inverse of the information, from finite differences of
/// motions alone.
fn bound(
    m: &Machine,
    free: &[&'static str],
    column: &str,
    (until, count): (f64, usize),
    sigma: f64,
) -> Vec<f64> {
    let run = |m: &Machine| record(m, &[(column, 0.0)], until, count, &mut Noise(0)).columns[0].1.clone();
    let mut jacobian = DMatrix::zeros(count, free.len());
    for (j, name) in free.iter().enumerate() {
        let value = m.description.get(name).unwrap();
        let step = 1e-5 * if value == 0.0 { 1e-2 } else { value.abs() };
        let [high, low] = [step, -step].map(|step| run(&m.with([(*name, value + step)]).unwrap()));
        high.iter()
            .zip(low)
            .enumerate()
            .for_each(|(i, (a, b))| jacobian[(i, j)] = (a - b) / (2.0 * step * sigma));
    }
    let inverse = jacobian.tr_mul(&jacobian).try_inverse().unwrap();
    (0..free.len()).map(|j| inverse[(j, j)].sqrt()).collect()
}

#[test]
fn second_method_an_error_larger_than_its_number_is_given_and_enlarges_the_others() {
    // Both damping and friction dissipate energy: the error of each exceeds its value.
    let text = "name = \"Ring\"\nbody.b = { mass = 1.0, start = { s = 1e-3 } }\n\
                spring.k = { between = [\"ground\", \"b\"], stiffness = 400.0, damping = 0.02 }\n\
                friction.f = { between = [\"ground\", \"b\"], force = 5e-3 }\n";
    let m = Machine::parse(text, "ring.toml", &no_records).unwrap();
    let free = ["spring.k.stiffness", "spring.k.damping", "friction.f.force"];
    let (sigma, span) = (2e-5, (0.4, 100));
    let measured = record(&m, &[("b.s", sigma)], span.0, span.1, &mut Noise(61));
    let found = fitted(&FitRequest { sigma: Some(vec![sigma]), ..request(m.clone(), measured, &free) });
    let at = m.with(free.iter().zip(&found.values).map(|(name, (_, x))| (*name, *x))).unwrap();
    let bound = bound(&at, &free, "b.s", span, sigma);
    assert!(bound[1] > found.values[1].1, "{bound:?} {:?}", found.values);
    for ((error, bound), name) in found.uncertainty.white.iter().zip(&bound).zip(free) {
        assert!((error.unwrap() / bound - 1.0).abs() < 0.01, "{name}: {error:?}, bound {bound}");
    }
    assert!(found.uncertainty.undetermined.is_empty());
}

#[test]
fn second_method_numbers_near_zero_have_the_error_of_the_bound() {
    let text = "name = \"Rest\"\nbody.b = { mass = 1.0, start = { s = 1e-3, v = 0.0 } }\n\
                spring.k = { between = [\"ground\", \"b\"], stiffness = 400.0, damping = 2.0 }\n";
    let m = Machine::parse(text, "rest.toml", &no_records).unwrap();
    let free = ["spring.k.stiffness", "body.b.start.v", "record.offset.b.s"];
    let sigma = 2e-5;
    let measured = record(&m, &[("b.s", sigma)], 0.4, 100, &mut Noise(62));
    let found = fitted(&FitRequest { sigma: Some(vec![sigma]), ..request(m, measured, &free) });
    for ((name, value), error) in found.values[1..].iter().zip(&found.uncertainty.errors[1..]) {
        assert!(value.abs() < FAR * error.unwrap(), "{name} {value} ± {error:?}");
    }
    // Error of a mean of 100 samples, increased by the correlation with the decay.
    let offset = found.uncertainty.white[2].unwrap() / (sigma / 10.0);
    assert!((1.0..1.5).contains(&offset), "{offset}");
}

#[test]
fn closed_form_as_many_numbers_as_samples_leave_no_noise() {
    let m = example("coulomb_oscillator.toml");
    let measured = Measured {
        times: vec![0.01, 0.02],
        columns: vec![(
            "mass.s".parse().unwrap(),
            record(&m, &[("mass.s", 0.0)], 0.02, 3, &mut Noise(0)).columns[0].1[1..].to_vec(),
        )],
        ..Measured::default()
    };
    let own = request(m, measured, &["spring.mount.stiffness", "body.mass.start.v"]);
    let found = fitted(&own);
    assert_eq!(found.uncertainty.errors, [None, None]);
    assert!(
        found.verdict.to_string().contains("no residual is left to estimate the noise"),
        "{}",
        found.verdict
    );
    let given = fitted(&FitRequest { sigma: Some(vec![1e-6]), ..own });
    assert!(given.uncertainty.errors.iter().all(Option::is_some));
}

#[test]
fn closed_form_shift_phase_and_speed_are_not_determined_together() {
    // A shift of the record equals a change of the load's phase by ω times the shift, and of the
    // start by its velocity and acceleration.
    let text = "name = \"Driven\"\nbody.a = { mass = 1.0, start = { s = 1e-2 } }\n\
                spring.k = { between = [\"ground\", \"a\"], stiffness = 900.0, damping = 2.0 }\n\
                load.l = { on = \"a\", amplitude = 3.0, frequency = 4.0, phase = 0.3 }\n";
    let m = Machine::parse(text, "driven.toml", &no_records).unwrap();
    let measured = record(&m, &[("a.s", 1e-5)], 2.0, 200, &mut Noise(67));
    let free = ["load.l.phase", "record.shift", "body.a.start.v", "spring.k.stiffness", "body.a.start.s"];
    let found = fitted(&request(m, measured, &free));
    let [undetermined] = &found.uncertainty.undetermined[..] else { panic!("{:?}", found.uncertainty) };
    let names: Vec<&str> = undetermined.combination.iter().map(|(name, _)| name.as_str()).collect();
    // The velocity is nearly 0, and so is the component of the start's displacement.
    assert!(free[..3].iter().all(|name| names.contains(name)), "{undetermined}");
    let [None, None, None, Some(error), _] = found.uncertainty.errors[..] else {
        panic!("{:?}", found.uncertainty)
    };
    assert!(!names.contains(&free[3]) && (found.values[3].1 - 900.0).abs() < FAR * error);
}

#[test]
fn invariant_a_number_that_is_the_rounding_of_zero_has_an_error() {
    let m = example("coulomb_oscillator.toml");
    let measured = record(&m, &[("mass.s", 0.0)], 0.25, 100, &mut Noise(0));
    let found = fitted(&request(m, measured, &["spring.mount.stiffness", "record.offset.mass.s"]));
    let error = found.uncertainty.errors[1].unwrap();
    assert!(found.values[1].1.abs() < 1e-12 && error < 1e-12, "{:?} {error}", found.values);
}

/// A ball falls 1 m, with one sample after the contact. A larger gap moves the contact behind this
/// sample at latest, so the cost rises by the square of its residual at most. That is 1, if the
/// noise equals the contact's effect on this sample. The cost is sought up to five standard errors
/// away: a rise of 1 there means an error that is five times larger.
#[test]
fn closed_form_an_error_is_five_times_larger_where_the_last_sample_after_a_contact_is_lost() {
    let text = "name = \"Ball\"\ngravity = 9.81\nbody.b = { mass = 1.0, gravity = 1.0 }\n\
                stop.floor = { between = [\"ground\", \"b\"], gap = 1.0, restitution = 0.8 }\n";
    let m = Machine::parse(text, "ball.toml", &no_records).unwrap();
    let (contact, after) = ((2.0f64 / 9.81).sqrt(), 1e-6);
    let lost = (1.0 + 0.8) * 9.81 * contact * after;
    let fall = |time: f64| 0.5 * 9.81 * time * time;
    let times = vec![0.1, 0.2, 0.3, 0.4, contact + after];
    let mut values: Vec<f64> = times.iter().map(|time| fall(*time)).collect();
    values[4] -= lost;
    let measured = Measured { times, columns: vec![("b.s".parse().unwrap(), values)], contacts: Vec::new() };
    let own = FitRequest { sigma: Some(vec![lost]), ..request(m, measured, &["stop.floor.gap"]) };
    let found = fitted(&own);
    let factor = found.uncertainty.errors[0].unwrap() / found.uncertainty.white[0].unwrap();
    // Gravity bends the fall by a millionth within the last interval.
    assert!((factor - 5.0).abs() < 1e-3, "{factor}");
}
