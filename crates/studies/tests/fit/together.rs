//! Fits of several records together.

use super::*;
use vibro_studies::fit::{Misfit, fit_records, misfit};

const FREE: [&str; 2] = ["spring.mount.stiffness", "friction.floor.force"];

/// A request whose last parameter each record has for itself.
fn with_own(request: FitRequest, name: &str) -> FitRequest {
    let mut request = request;
    request.free.push(Free { name: name.to_owned(), within: None, is_own: true });
    request
}

/// Records of an oscillator released from several places, which the fit does not know.
fn released(places: &[f64], factor: f64) -> Vec<FitRequest> {
    let m = example("coulomb_oscillator.toml");
    let one = |(k, place): (usize, &f64)| {
        let own = m.with([("body.mass.start.s", *place)]).unwrap();
        let measured = record(&own, &[("mass.s", 2e-6)], 0.25, 300, &mut Noise(90 + k as u64));
        with_own(request(off(&m, &FREE, |_| factor), measured, &FREE), "body.mass.start.s")
    };
    places.iter().enumerate().map(one).collect()
}

#[test]
fn made_records_share_numbers_and_have_starts_of_their_own() {
    let m = example("coulomb_oscillator.toml");
    let places = [2.1e-3, 1.4e-3, 1.9e-3];
    let all = fit_records(&released(&places, 1.2), &|_| true).unwrap();
    for (found, place) in all.iter().zip(places) {
        let truths = FREE.map(|name| m.description.get(name).unwrap()).into_iter().chain([place]);
        for (((name, value), error), truth) in found.values.iter().zip(&found.uncertainty.errors).zip(truths)
        {
            assert!((value - truth).abs() < FAR * error.unwrap(), "{name} {value} ± {error:?}, true {truth}");
        }
        assert_eq!(found.verdict, Verdict::Fits);
        assert_eq!(found.values[..2], all[0].values[..2]);
        assert_eq!(found.machine.description.get("body.mass.start.s").unwrap(), found.values[2].1);
    }
}

/// Near the minimum the costs are parabolas, and the information of independent records adds. The
/// parabolas of single records differ by their own noise, and by kinks of friction.
const LIKE_A_SUM: f64 = 0.1;

#[test]
fn second_method_information_of_records_is_the_sum_over_single_fits() {
    let all = released(&[2.1e-3, 1.4e-3], 1.1);
    let together = fit_records(&all, &|_| true).unwrap();
    let alone: Vec<Fitted> = all.iter().map(fitted).collect();
    for (k, name) in FREE.iter().enumerate() {
        let information: f64 = alone.iter().map(|own| own.uncertainty.white[k].unwrap().powi(-2)).sum();
        let expected = information.sqrt().recip();
        let found = together[0].uncertainty.white[k].unwrap();
        assert!((found / expected - 1.0).abs() < LIKE_A_SUM, "{name} {found} {expected}");
    }
}

#[test]
fn invariant_a_record_twice_has_the_values_of_one_and_smaller_errors() {
    let m = example("coulomb_oscillator.toml");
    let measured = record(&m, &[("mass.s", 2e-6)], 0.25, 300, &mut Noise(93));
    let one = FitRequest { sigma: Some(vec![2e-6]), ..request(off(&m, &FREE, |_| 1.1), measured, &FREE) };
    let (alone, twice) = (fitted(&one), fit_records(&[one.clone(), one], &|_| true).unwrap());
    for k in 0..FREE.len() {
        let error = alone.uncertainty.white[k].unwrap();
        // Both searches end at steps of the rounding level, far below a standard error.
        assert!((twice[0].values[k].1 - alone.values[k].1).abs() < 1e-3 * error);
        let ratio = twice[1].uncertainty.white[k].unwrap() / error;
        assert!((ratio * 2f64.sqrt() - 1.0).abs() < 1e-3, "{ratio}");
    }
    assert!((twice[0].cost / alone.cost - 2.0).abs() < 1e-6);
}

#[test]
fn invariant_a_record_of_another_machine_leaves_none_that_fits() {
    let mut all = released(&[2.1e-3, 1.4e-3], 1.0);
    let other = off(&example("coulomb_oscillator.toml"), &FREE, |_| 2.0);
    let other = other.with([("body.mass.start.s", 1.4e-3)]).unwrap();
    all[1].measured = record(&other, &[("mass.s", 2e-6)], 0.25, 300, &mut Noise(97));
    let verdicts = |all: &[FitRequest]| {
        let all = fit_records(all, &|_| true).unwrap();
        all.into_iter().map(|own| own.verdict).collect::<Vec<_>>()
    };
    assert!(verdicts(&all).iter().all(|own| *own != Verdict::Fits));
    // A record that would fit alone names the other one, which no motion of the machine makes.
    for (own, name) in all.iter_mut().zip(["slow", "fast"]) {
        own.name = name.into();
        own.free.iter_mut().for_each(|free| free.is_own = true);
    }
    all[1].measured.columns[0].1.iter_mut().skip(150).for_each(|x| *x += 1e-4);
    let verdicts = verdicts(&all);
    assert!(
        matches!(&verdicts[0], Verdict::Undecided(why) if why.starts_with("record fast ")),
        "{verdicts:?}"
    );
}

/// Two excitation frequencies: each record's frequency is set, so it is not free.
#[test]
fn made_records_at_two_frequencies_of_a_damper_with_a_buffer() {
    let m = example("damper_with_buffer.toml");
    let free = ["stop.buffer.gap", "stop.buffer.stiffness", "stop.buffer.damping"];
    let one = |(k, frequency): (usize, f64)| {
        let own = m.with([("load.shaker.frequency", frequency)]).unwrap();
        let measured = record(&own, &[("box.s", 1e-5)], 0.6, 180, &mut Noise(95 + k as u64));
        request(off(&own, &free, |i| [1.2, 0.8, 1.2][i]), measured, &free)
    };
    let all: Vec<FitRequest> = [9.0, 10.0].into_iter().enumerate().map(one).collect();
    let found = fit_records(&all, &|_| true).unwrap();
    for ((name, value), error) in found[0].values.iter().zip(&found[0].uncertainty.errors) {
        let truth = m.description.get(name).unwrap();
        assert!((value - truth).abs() < FAR * error.unwrap(), "{name} {value} ± {error:?}, true {truth}");
    }
    assert!(
        found.iter().all(|own| own.verdict == Verdict::Fits),
        "{} {}",
        found[0].verdict,
        found[1].verdict
    );
}

#[test]
fn records_that_do_not_go_together_are_refused() {
    let all = released(&[2.1e-3, 1.4e-3], 1.1);
    let refused = |change: &dyn Fn(&mut FitRequest)| {
        let mut own = all.clone();
        change(&mut own[1]);
        fit_records(&own, &|_| true).unwrap_err().to_string()
    };
    let cases: [Refused; 5] = [
        (&|own| own.free.truncate(1), "record 2: the list of free parameters differs from record 1"),
        (&|own| own.loss = Loss::Huber, "record 2: the loss differs from record 1"),
        (&|own| own.starts = 3, "record 2: the number of further starts differs from record 1"),
        (&|own| own.sigma = Some(vec![1e-6]), "record 2: standard deviations must be given for all records"),
        (
            &|own| own.machine = off(&own.machine, &FREE[..1], |_| 1.5),
            "spring.mount.stiffness begins at 11000 in record 1 and at 16500 in record 2",
        ),
    ];
    for (change, words) in cases {
        let text = refused(change);
        assert!(text.contains(words), "{text}");
    }
    assert!(fit_records(&[], &|_| true).unwrap_err().to_string().contains("no record"));
}

/// A record of two samples has as many numbers of its own: its noise is the noise of the other
/// record, whose sensor it has.
#[test]
fn made_record_of_two_samples_takes_the_noise_of_the_other_record() {
    let text = "name = \"Ball\"\ngravity = 9.81\nbody.a = { mass = 1.0, gravity = 1.0 }\n\
                stop.floor = { between = [\"ground\", \"a\"], gap = 1.0, restitution = 0.8 }\n";
    let m = Machine::parse(text, "ball.toml", &no_records).unwrap();
    for seed in 0..6 {
        let mut noise = Noise(200 + seed);
        let own = |measured| {
            let mut own = request(m.clone(), measured, &["stop.floor.restitution"]);
            for name in ["body.a.start.s", "body.a.start.v"] {
                own = with_own(own, name);
            }
            own
        };
        let long = own(record(&m, &[("a.s", 1e-3)], 1.6, 80, &mut noise));
        let short = own(record(&m, &[("a.s", 1e-3)], 0.4, 2, &mut noise));
        let all = fit_records(&[long, short], &|_| true).unwrap();
        for own in &all {
            let truths = [0.8, 0.0, 0.0];
            for (((name, value), error), truth) in own.values.iter().zip(&own.uncertainty.errors).zip(truths)
            {
                assert!(
                    (value - truth).abs() < FAR * error.unwrap(),
                    "{name} {value} ± {error:?}, {}",
                    own.verdict
                );
            }
        }
    }
}

/// Two balls of different restitution: each record alone fits with its own, so no other number takes
/// up what the shared one leaves.
#[test]
fn invariant_residuals_of_a_shared_number_suspect_no_other() {
    let text = |e: f64| {
        format!(
            "name = \"Ball\"\ngravity = 9.81\nbody.a = {{ mass = 1.0, gravity = 1.0 }}\n\
             stop.floor = {{ between = [\"ground\", \"a\"], gap = 1.0, restitution = {e} }}\n"
        )
    };
    let ball = |e: f64| Machine::parse(&text(e), "ball.toml", &no_records).unwrap();
    let one = |(k, e): (usize, f64)| {
        let measured = record(&ball(e), &[("a.s", 1e-3)], 1.6, 200, &mut Noise(98 + k as u64));
        request(ball(0.75), measured, &["stop.floor.restitution"])
    };
    let all: Vec<FitRequest> = [0.82, 0.6].into_iter().enumerate().map(one).collect();
    for (request, found) in all.iter().zip(fit_records(&all, &|_| true).unwrap()) {
        assert_ne!(found.verdict, Verdict::Fits);
        let Misfit { suspects, .. } = misfit(request, &found, &|| true).unwrap();
        assert!(suspects.is_empty(), "{suspects:?}");
    }
}
