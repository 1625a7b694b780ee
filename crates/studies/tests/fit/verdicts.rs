//! Verdicts of fits, and further starts.

use super::*;
use std::sync::Mutex;
use std::sync::atomic::{AtomicU32, Ordering};
use vibro_studies::fit::Progress;

const FREE: [&str; 2] = ["spring.mount.stiffness", "friction.floor.force"];

#[test]
fn invariant_a_motion_of_another_law_does_not_fit() {
    let m = example("coulomb_oscillator.toml");
    let measured = record(&m, &[("mass.s", 2e-6)], 0.25, 500, &mut Noise(51));
    let sound = fitted(&request(off(&m, &FREE, |_| 1.1), measured.clone(), &FREE));
    assert_eq!(sound.verdict, Verdict::Fits);
    // Friction is held at a third of its value.
    let begin = m.with([("friction.floor.force", m.description.get("friction.floor.force").unwrap() / 3.0)]);
    let found = fitted(&request(begin.unwrap(), measured, &FREE[..1]));
    let times = found.rms[0].1 / 2e-6;
    assert!(times > 10.0 && matches!(found.verdict, Verdict::Misses(_)), "{times}: {}", found.verdict);
    assert!(
        found.verdict.to_string().starts_with("does not fit: the residuals of mass.s are"),
        "{}",
        found.verdict
    );
}

#[test]
fn invariant_noise_that_lasts_is_undecided_or_no_fit() {
    let m = example("coulomb_oscillator.toml");
    let mut measured = record(&m, &[("mass.s", 0.0)], 0.25, 400, &mut Noise(52));
    let (mut own, mut noise) = (0.0, Noise(53));
    for value in &mut measured.columns[0].1 {
        own = 0.9 * own + 2e-6 * noise.normal();
        *value += own;
    }
    let found = fitted(&request(m, measured, &FREE));
    assert_ne!(found.verdict, Verdict::Fits);
}

/// A record with the digits of a table, whose rounding errors are correlated.
#[test]
fn invariant_residuals_within_rounding_of_the_record_fit() {
    let m = example("coulomb_oscillator.toml");
    let mut measured = record(&m, &[("mass.s", 0.0)], 0.25, 400, &mut Noise(54));
    let largest = measured.columns[0].1.iter().fold(0.0f64, |most, x| most.max(x.abs()));
    for (time, value) in measured.times.iter().zip(&mut measured.columns[0].1) {
        *value += 3e-7 * largest * (8.0 * time).sin();
    }
    let found = fitted(&request(off(&m, &FREE, |_| 1.05), measured, &FREE));
    assert_eq!(found.verdict, Verdict::Fits);
}

#[test]
fn invariant_a_fit_that_is_ended_is_undecided_and_has_the_best_values_so_far() {
    let m = example("coulomb_oscillator.toml");
    let measured = record(&m, &[("mass.s", 2e-6)], 0.25, 100, &mut Noise(54));
    let far = request(off(&m, &FREE, |_| 1.3), measured, &FREE);
    let whole = fitted(&far);
    let mut before = f64::INFINITY;
    // The given start is far off: without an early end, none of these would fit.
    for calls in [0, 2, 6] {
        let left = AtomicU32::new(calls);
        let one = |left: u32| left.checked_sub(1);
        let ended = |_: &Progress| left.fetch_update(Ordering::Relaxed, Ordering::Relaxed, one).is_ok();
        let found = fit(&far, &ended).unwrap();
        assert!(found.verdict.to_string().starts_with("undecided: ended by hand"), "{}", found.verdict);
        assert!(found.simulations < whole.simulations && found.rms[0].1 <= before, "{calls}");
        before = found.rms[0].1;
    }
    assert!(before < 0.1 * rms_of_start(&far) && whole.rms[0].1 <= before);
}

/// Residual at the start of a fit, before any step.
fn rms_of_start(request: &FitRequest) -> f64 {
    fit(request, &|_| false).unwrap().rms[0].1
}

#[test]
fn invariant_progress_grows_and_ends_at_the_cost_of_the_fit() {
    let m = example("coulomb_oscillator.toml");
    let measured = record(&m, &[("mass.s", 2e-6)], 0.25, 100, &mut Noise(54));
    let own = FitRequest { sigma: Some(vec![2e-6]), ..request(off(&m, &FREE, |_| 1.2), measured, &FREE) };
    let all: Mutex<Vec<Progress>> = Mutex::default();
    let found = fit(&own, &|now| {
        all.lock().unwrap().push(now.clone());
        true
    });
    let (found, all) = (found.unwrap(), all.into_inner().unwrap());
    let grows = |pair: &[Progress]| {
        pair[0].part <= pair[1].part && pair[0].simulations <= pair[1].simulations && pair[1].part <= 1.0
    };
    assert!(all.len() > 5 && all.windows(2).all(grows), "{all:?}");
    assert!(all.iter().all(|now| !now.stage.is_empty()));
    // Omitted attempts count as finished when restarts begin: 15 stages of 36.
    let beside = all.iter().find(|now| now.stage.starts_with("restarts near")).unwrap();
    assert_eq!(beside.part, 15.0 / 36.0);
    // The solver stops at a relative change of 1e-13: the last costs are exact to rounding.
    let best = all.last().unwrap().best.unwrap();
    assert!((best / found.cost - 1.0).abs() < 1e-9, "{best} {}", found.cost);
}

#[test]
fn made_record_by_twenty_starts_from_50_percent_off() {
    let m = example("coulomb_oscillator.toml");
    let measured = record(&m, &[("mass.s", 2e-6)], 0.25, 100, &mut Noise(55));
    let own = request(off(&m, &FREE, |i| [1.5, 0.5][i]), measured, &FREE);
    let range = |name: &&str| {
        let truth = m.description.get(name).unwrap();
        Free { name: (*name).to_owned(), within: Some((0.4 * truth, 1.8 * truth)), is_own: false }
    };
    let found = fitted(&FitRequest { free: FREE.iter().map(range).collect(), starts: 20, ..own });
    for ((name, value), error) in found.values.iter().zip(&found.uncertainty.errors) {
        let truth = m.description.get(name).unwrap();
        assert!((value - truth).abs() < FAR * error.unwrap(), "{name} {value} ± {error:?}, true {truth}");
    }
    assert_eq!(found.verdict, Verdict::Fits);
}

#[test]
fn invariant_contacts_that_the_motion_does_not_have_are_no_fit() {
    // A ball that bounces on a lower floor, whose place is not free.
    let text = |gap: f64| {
        format!(
            "name = \"Ball\"\ngravity = 9.81\nbody.a = {{ mass = 1.0, gravity = 1.0 }}\n\
             stop.floor = {{ between = [\"ground\", \"a\"], gap = {gap}, restitution = 0.8 }}\n"
        )
    };
    let ball = |gap: f64| Machine::parse(&text(gap), "ball.toml", &no_records).unwrap();
    let measured = contacts(&ball(0.5), &["floor"], 1.5, 1e-5, &mut Noise(56));
    let own = request(ball(0.8), measured, &["stop.floor.restitution"]);
    // Without a given noise, a few contact times do not show whether their deviation is noise.
    assert!(matches!(fitted(&own).verdict, Verdict::Undecided(_)));
    let found = fitted(&FitRequest { sigma: Some(vec![1e-5]), ..own });
    assert!(matches!(found.verdict, Verdict::Misses(_)), "{}", found.verdict);
    // From 20 m the ball does not reach the floor in 1.5 s: every contact of the record lacks a
    // counterpart.
    let measured = contacts(&ball(0.5), &["floor"], 1.5, 1e-5, &mut Noise(56));
    let count = measured.contacts[0].1.len();
    let found = fitted(&request(ball(20.0), measured, &["stop.floor.restitution"]));
    assert_eq!(
        found.verdict,
        Verdict::Misses(format!(
            "{count} of {count} contacts of stop.floor have no contact of the fitted motion"
        )),
        "{}",
        found.verdict
    );
}

/// Longest time of a fit that takes a hundredth of a second, s.
const BOUNDED: f64 = 10.0;

/// A contact that no motion has leaves an error of 2e19 N/m, by which restarts must not move the
/// stiffness: the motion of such a spring takes hours.
#[test]
fn invariant_restarts_do_not_move_a_parameter_by_an_error_of_any_size() {
    let text = |stiffness: f64| {
        format!(
            "name = \"Apart\"\nbody.m = {{ mass = 1.0, start = {{ s = 0.01 }} }}\n\
             spring.k = {{ between = [\"ground\", \"m\"], stiffness = {stiffness:?} }}\n\
             stop.wall = {{ between = [\"ground\", \"m\"], gap = 1.0, restitution = 0.5 }}\n"
        )
    };
    let m = |stiffness: f64| Machine::parse(&text(stiffness), "apart.toml", &no_records).unwrap();
    let mut measured = record(&m(100.0), &[("m.s", 1e-8)], 0.95, 20, &mut Noise(11));
    measured.contacts = vec![("stop.wall".into(), vec![0.1])];
    let begin = std::time::Instant::now();
    let own = request(m(90.0), measured, &["spring.k.stiffness"]);
    let found = fit(&own, &|_| begin.elapsed().as_secs_f64() < BOUNDED).unwrap();
    assert!(matches!(found.verdict, Verdict::Misses(_)), "{}", found.verdict);
}

#[test]
fn invariant_noise_of_contacts_alone_is_not_called_another_law() {
    let text = "name = \"Ball\"\ngravity = 9.81\nbody.a = { mass = 1.0, gravity = 1.0 }\n\
                stop.floor = { between = [\"ground\", \"a\"], gap = 1.0, restitution = 0.87 }\n";
    let m = Machine::parse(text, "ball.toml", &no_records).unwrap();
    let free = ["stop.floor.gap", "stop.floor.restitution"];
    // Times are off by 4 % of the mean interval.
    let measured = contacts(&m, &["floor"], 6.0, 2e-2, &mut Noise(65));
    let own = request(off(&m, &free, |i| [0.95, 0.98][i]), measured, &free);
    let found = fitted(&own);
    assert!(found.verdict.to_string().contains("--sigma contacts=TIME"), "{}", found.verdict);
    let given = fitted(&FitRequest { sigma: Some(vec![2e-2]), ..own });
    assert_eq!(given.verdict, Verdict::Fits);
    for ((name, value), error) in given.values.iter().zip(&given.uncertainty.errors) {
        let truth = m.description.get(name).unwrap();
        assert!((value - truth).abs() < FAR * error.unwrap(), "{name} {value} ± {error:?}");
    }
}

#[test]
fn invariant_a_rounded_input_is_undecided_unless_its_steps_are_below_the_noise() {
    let cart = |quantum: f64| {
        let text = format!(
            "name = \"Cart\"\nbody.cart = {{ mass = 2.0, start = {{ s = 0.05 }} }}\n\
             damper.d = {{ between = [\"ground\", \"cart\"], damping = 4.0 }}\n\
             block.p = {{ inputs = [\"cart.s\"], d = [[-400.0]], outputs = [\"u\"], sample = 0.01, \
             quantum = {{ \"cart.s\" = {quantum:?} }} }}\n\
             load.motor = {{ on = \"cart\", from = \"p.u\" }}\n"
        );
        Machine::parse(&text, "cart.toml", &no_records).unwrap()
    };
    for (quantum, is_seen) in [(1e-2, true), (1e-9, false)] {
        let m = cart(quantum);
        let measured = record(&m, &[("cart.s", 1e-5)], 1.0, 200, &mut Noise(66));
        let free = ["damper.d.damping", "body.cart.mass"];
        let found = fitted(&request(off(&m, &free, |_| 1.1), measured, &free));
        let says = found.verdict.to_string().contains("a block rounds its input");
        assert_eq!((says, found.verdict == Verdict::Fits), (is_seen, !is_seen), "{}", found.verdict);
        assert!(!matches!(found.verdict, Verdict::Misses(_)), "{}", found.verdict);
    }
}

#[test]
fn invariant_a_given_noise_is_left_by_chance_alone() {
    // The noise of this draw of 500 samples is 5 % too small, within two standard deviations.
    let m = example("coulomb_oscillator.toml");
    let measured = record(&m, &[("mass.s", 2e-6)], 0.25, 500, &mut Noise(51));
    for loss in [Loss::Linear, Loss::Huber] {
        let of = |part: f64| {
            let (begin, sigma) = (off(&m, &FREE, |_| 1.1), Some(vec![part * 2e-6]));
            fitted(&FitRequest { sigma, loss, ..request(begin, measured.clone(), &FREE) }).verdict
        };
        assert_eq!(of(1.0), Verdict::Fits, "{loss:?}");
        let many = of(1.0 / 1.5).to_string();
        assert!(many.starts_with("undecided: the residuals of mass.s are 1.4"), "{loss:?}: {many}");
    }
    let slightly = FitRequest { sigma: Some(vec![2e-6 / 1.25]), ..request(m, measured, &FREE) };
    let slightly = fitted(&slightly).verdict.to_string();
    assert!(slightly.starts_with("undecided: the residuals of mass.s are 1.1"), "{slightly}");
}

#[test]
fn invariant_a_number_at_an_end_of_its_range_is_named() {
    let m = example("coulomb_oscillator.toml");
    let measured = record(&m, &[("mass.s", 2e-6)], 0.25, 500, &mut Noise(51));
    let stiffness = m.description.get(FREE[0]).unwrap();
    let mut own = request(off(&m, &FREE, |i| [0.9, 1.0][i]), measured, &FREE);
    assert_eq!(fitted(&own).at_bounds, []);
    own.free[0].within = Some((0.8 * stiffness, 0.95 * stiffness));
    let found = fitted(&own);
    assert_eq!(found.at_bounds, [(FREE[0].to_owned(), 0.95 * stiffness)]);
    assert_ne!(found.verdict, Verdict::Fits);
}
