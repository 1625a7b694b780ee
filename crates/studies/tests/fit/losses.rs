//! Outliers, and derivatives that do not exist.

use super::*;

#[test]
fn invariant_outliers_count_little_by_their_size() {
    let m = example("coulomb_oscillator.toml");
    let mut measured = record(&m, &[("mass.s", 5e-6)], 0.25, 100, &mut Noise(10));
    [3, 20, 55].into_iter().for_each(|i| measured.columns[0].1[i] = 5e-3);
    let free = ["spring.mount.stiffness", "friction.floor.force"];
    for loss in [Loss::Huber, Loss::SoftL1] {
        let begin = off(&m, &free, |_| 1.02);
        let sigma = Some(vec![5e-6]);
        let found = fitted(&FitRequest { loss, sigma, ..request(begin, measured.clone(), &free) });
        for (name, value) in &found.values {
            let truth = m.description.get(name).unwrap();
            assert!((value / truth - 1.0).abs() < 0.01, "{loss:?}: {name} {value}, true {truth}");
        }
    }
}

#[test]
fn invariant_outliers_count_little_without_a_known_noise() {
    let m = example("coulomb_oscillator.toml");
    let mut measured = record(&m, &[("mass.s", 5e-6)], 0.25, 200, &mut Noise(18));
    (0..200).step_by(15).for_each(|i| measured.columns[0].1[i] += if i % 2 == 0 { 2e-3 } else { -1e-3 });
    let free = ["spring.mount.stiffness", "friction.floor.force"];
    for loss in [Loss::Huber, Loss::SoftL1] {
        let begin = off(&m, &free, |_| 1.1);
        let found = fitted(&FitRequest { loss, ..request(begin, measured.clone(), &free) });
        for ((name, value), error) in found.values.iter().zip(&found.uncertainty.errors) {
            let truth = m.description.get(name).unwrap();
            let error = error.unwrap();
            assert!(
                (value - truth).abs() < FAR * error && error < 0.01 * truth,
                "{loss:?}: {name} {value} {error}"
            );
        }
    }
}

#[test]
fn made_record_of_a_slider_that_begins_at_its_limit() {
    // The joint would exceed its full force at the start, so it begins at its limit.
    let text = "name = \"Joint\"\nbody.a = { mass = 1.0, start = { s = 1e-3 } }\n\
                spring.k = { between = [\"ground\", \"a\"], stiffness = 4000.0, damping = 3.0 }\n\
                spring.joint = { between = [\"ground\", \"a\"], stiffness = 2500.0, slip = 2.0 }\n";
    let m = Machine::parse(text, "joint.toml", &no_records).unwrap();
    let measured = record(&m, &[("a.s", 1e-6)], 0.4, 300, &mut Noise(19));
    let free = ["spring.k.stiffness", "spring.joint.stiffness", "spring.joint.slip"];
    let found = fitted(&request(m.clone(), measured.clone(), &free));
    // The elongation at the start is the limit's, whatever the free parameters.
    assert!(found.lost.is_empty(), "{:?}", found.lost);
    let found = fitted(&request(off(&m, &free, |i| [1.1, 1.1, 0.9][i]), measured, &free));
    for ((name, value), error) in found.values.iter().zip(&found.uncertainty.errors) {
        let truth = m.description.get(name).unwrap();
        assert!((value - truth).abs() < FAR * error.unwrap(), "{name} {value} ± {error:?}, true {truth}");
    }
}

#[test]
fn invariant_errors_do_not_grow_with_the_size_of_outliers() {
    let m = example("coulomb_oscillator.toml");
    let free = ["spring.mount.stiffness", "friction.floor.force"];
    let clean = record(&m, &[("mass.s", 5e-6)], 0.25, 200, &mut Noise(64));
    let linear = fitted(&request(m.clone(), clean.clone(), &free)).uncertainty.white;
    for loss in [Loss::Huber, Loss::SoftL1] {
        let errors = |size: f64| {
            let mut measured = clean.clone();
            (0..200).step_by(15).for_each(|i| measured.columns[0].1[i] += size * (i as f64).sin().signum());
            fitted(&FitRequest { loss, ..request(m.clone(), measured, &free) }).uncertainty.white
        };
        let (near, far) = (errors(1e-2), errors(10.0));
        for ((near, far), linear) in near.iter().zip(&far).zip(&linear) {
            let (near, far, linear) = (near.unwrap(), far.unwrap(), linear.unwrap());
            assert!((far / near - 1.0).abs() < 0.01, "{loss:?}: {near} {far}");
            // 7 % outliers; the normal noise gives the loss 95 % of its information.
            assert!((0.8..1.6).contains(&(far / linear)), "{loss:?}: {far} {linear}");
        }
    }
}
